//! Orders of visits.

use crate::engine::boxes::RelativePose;
use crate::tree::Node;
use punctual_geom::named;

/// Decides which node pair of the frontier is visited next, if a budget may cut the query. All
/// orders give the same finished answer, and differ by the key of the queue alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Order {
    /// Deepest penetration of the boxes first, relative to their sizes and to the levels left below
    /// them: `depth / ((size_a + size_b) (levels_a + levels_b))`. The depth is the least over the
    /// six face axes, `size` the root of a box's surface area, and `levels` log2 of its triangles,
    /// both of the pair that was opened. The default: it finds intersections earliest
    /// (`docs/benchmarks.md`).
    #[default]
    Penetration,
    /// Lowest product of the two diminishing factors `alpha` first, as the paper proposes.
    LowAlpha,
    /// The pair found last first: a stack in place of the queue.
    DepthFirst,
}

named!(Order {
    Penetration => "penetration",
    LowAlpha => "low-alpha",
    DepthFirst => "depth-first",
});

impl Order {
    /// The factor from the keys of a pair's children to their ranks.
    #[inline(always)]
    pub(crate) fn share(self, [a, b]: [&Node; 2], relative: &RelativePose) -> f32 {
        if self == Self::LowAlpha {
            return 1.0;
        }
        let size = a.size + b.size * relative.scale;
        1.0 / (size * (a.levels + b.levels)).max(f32::MIN_POSITIVE)
    }

    /// The key of two nodes by their alphas, not negative: the largest is visited first.
    #[inline(always)]
    pub(crate) fn low_alpha([a, b]: [&Node; 2]) -> f32 {
        // Not the negative of the sum, which may be -0.
        0.0 - (a.log_alpha + b.log_alpha)
    }
}
