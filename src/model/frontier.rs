//! A frontier in numbers: all that the model knows of a query that has begun or is about to begin.

/// Work done and work left of a query, after a probe has opened the costliest pairs of its
/// frontier.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct FrontierSummary {
    /// BV tests made.
    pub bv_tests: f64,
    /// Triangle pairs tested.
    pub triangle_tests: f64,
    /// Intersecting pairs found.
    pub found: f64,
    /// Intersecting pairs found along curves.
    pub followed: f64,
    /// Intersecting pairs found along curves that the boxes have reached since.
    pub passed: f64,
    /// True if the query is still following a curve.
    pub follows: bool,
    /// BV tests made by the probe. The query has yet to make these tests.
    pub probed: f64,
    /// Triangle pairs that wait for their test, including those that the probe reached.
    pub triangle_pairs: f64,
    /// Open node pairs.
    pub node_pairs: f64,
    /// Sum of [`pair_cost`](super::visits::pair_cost) over the open node pairs.
    pub cost: f64,
    /// Largest [`pair_cost`](super::visits::pair_cost) of an open node pair.
    pub largest: f64,
    /// Sum over the open node pairs: [`pair_cost`](super::visits::pair_cost) times relative
    /// penetration.
    pub depth: f64,
    /// Deepest relative penetration of an open node pair, 0 to 1.
    pub deepest: f64,
    /// Largest amount by which one box of an open node pair extends beyond both sides of the other
    /// on an axis, relative to the sum of their extents; -1 to 1, negative if no box extends beyond
    /// both sides. Surfaces that cross leave such pairs.
    pub crossing: f64,
}

impl FrontierSummary {
    /// True if the query has done anything yet.
    pub fn is_begun(&self) -> bool {
        self.bv_tests + self.triangle_tests > 0.0
    }

    /// True if nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.probed == 0.0 && self.is_clear()
    }

    /// True if nothing is left that may meet: the probe has come to the end of all open pairs.
    pub fn is_clear(&self) -> bool {
        self.triangle_pairs + self.node_pairs == 0.0
    }
}
