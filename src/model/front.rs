//! A front in numbers: all that the model sees of a query that is under way, or about to begin.

/// What a query has done and what lies before it, once the costliest pairs of its front have been opened on trial.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct FrontSummary {
    /// BV tests that the query has made.
    pub bv_tests: f64,
    /// Triangle pairs that it has tested.
    pub triangle_tests: f64,
    /// Intersecting pairs that it has found.
    pub found: f64,
    /// Those among them that it found along curves.
    pub followed: f64,
    /// How many of these its boxes have come to since.
    pub passed: f64,
    /// Whether it is still following one.
    pub follows: bool,
    /// BV tests made by the probe, which the query has still to make.
    pub probed: f64,
    /// Triangle pairs that wait, those met on trial included.
    pub triangle_pairs: f64,
    /// Open node pairs.
    pub node_pairs: f64,
    /// Sum of [`pair_cost`] over the open node pairs.
    pub cost: f64,
    /// The largest of these.
    pub largest: f64,
    /// Sum of [`pair_cost`] times relative penetration.
    pub depth: f64,
    /// Deepest relative penetration of an open node pair, 0 to 1.
    pub deepest: f64,
    /// Most that one box reaches beyond both sides of the other on an axis, relative to the sum of their extents; -1 to 1,
    /// negative if none does. Surfaces that cross leave such pairs.
    pub crossing: f64,
}

impl FrontSummary {
    /// Whether the query has done anything yet.
    pub fn is_begun(&self) -> bool {
        self.bv_tests + self.triangle_tests > 0.0
    }

    /// Whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.probed == 0.0 && self.is_clear()
    }

    /// Whether nothing is left that may meet: the probe has come to the end of all open pairs.
    pub fn is_clear(&self) -> bool {
        self.triangle_pairs + self.node_pairs == 0.0
    }
}

/// Expected BV tests under a pair of nodes: `27 (v_A v_B p^3)^(1/4)`, where `v` is what each costs against a copy of itself, averaged
/// over placements, and `p` the relative penetration of the boxes, 0 to 1.
///
/// The exponents are rounded from a fit of the sums over 47,000 fronts (`docs/model.md`); what the fronts still need is fitted
/// on top of it.
#[inline(always)]
pub fn pair_cost(self_costs: [f32; 2], penetration: f32) -> f32 {
    let p = penetration;
    // The root of `libm` is a legacy instruction, which stalls code for AVX.
    let fourth = wide::f32x4::splat(self_costs[0] * self_costs[1] * p * p * p);
    27.0 * fourth.sqrt().sqrt().as_array()[0]
}
