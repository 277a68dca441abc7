//! Orders of visits.

use super::queue::BUCKETS;
use punctual_geom::named;

/// Decides which node pair of the frontier is visited next. All orders give the same finished
/// answer; they differ in what is known when a budget ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Order {
    /// Deepest penetration of the boxes first: the least over the six face axes, relative to the
    /// sizes of the nodes. The default: it costs almost nothing, and finds intersections earliest
    /// in time (`docs/benchmarks.md`).
    #[default]
    Penetration,
    /// Lowest product of the two diminishing factors `alpha` first, as the paper proposes.
    LowAlpha,
    /// Depth-first, without a queue: least overhead.
    DepthFirst,
}

named!(Order {
    Penetration => "penetration",
    LowAlpha => "low-alpha",
    DepthFirst => "depth-first",
});

/// The depth of an overlap is at most about a sixth of the sum of the sizes, so the relative depth
/// times this is within 0..=1.
const DEPTHS: f32 = 6.0;

impl Order {
    /// The bucket of a pair. `depth` is the overlap depth of its boxes over the sum of their sizes,
    /// `alpha` the product of the two diminishing factors.
    pub(super) fn bucket(self, depth: f32, alpha: impl FnOnce() -> f32) -> usize {
        let share = match self {
            Self::DepthFirst => return 0,
            Self::Penetration => 1.0 - DEPTHS * depth,
            Self::LowAlpha => alpha(),
        };
        ((share * BUCKETS as f32) as usize).min(BUCKETS - 1)
    }
}
