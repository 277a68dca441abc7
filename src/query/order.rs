//! Which node pair is visited next.

use super::frames::{Frames, Relation};
use super::queue::BUCKETS;
use crate::tree::{Node, xyz};

/// What a query looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// Whether there is an intersection: stops at the first.
    #[default]
    Any,
    /// Every intersecting pair of triangles.
    All,
}

/// Which node pair of the front is visited next. All orders give the same finished answer; they differ in what is known
/// when a budget ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Order {
    /// Deepest penetration of the boxes first, the least over the six face axes, relative to the sizes of the nodes. The
    /// default: it costs next to nothing, and finds intersections earliest in time (`docs/benchmarks.md`).
    #[default]
    Penetration,
    /// Lowest product of the two alphas first, as the paper proposes.
    LowAlpha,
    /// Largest relative volume of the boxes' overlap first.
    OverlapVolume,
    /// Depth-first: no queue at all, the least overhead.
    DepthFirst,
    /// Level by level.
    BreadthFirst,
    /// At random, by this seed.
    Random(u64),
}

/// The boxes of a node pair, in the frame of A's node.
pub(super) struct BoxPair {
    a: Extent,
    b: Extent,
}

/// Centre and half extents.
type Extent = ([f32; 3], [f32; 3]);

impl BoxPair {
    pub fn new(a: &Node, b: &Node, relation: &Relation) -> Self {
        let view = Frames::new(a, b, relation).of_b;
        let (center, half) = (b.own_center * relation.scale, b.own_half * relation.scale);
        Self { a: (xyz(a.own_center), xyz(a.own_half)), b: (xyz(view.point(center)), xyz(view.half(half))) }
    }

    /// Overlap volume over the smaller box, on A's axes; within 0..=1.
    fn overlap_volume(&self) -> f32 {
        let share = |k: usize| {
            let (a, b, distance) = (self.a.1[k], self.b.1[k], (self.b.0[k] - self.a.0[k]).abs());
            let (least, slack) = (2.0 * a.min(b), 1e-3 * (a + b) + 1e-9);
            ((a + b - distance).clamp(0.0, least) + slack) / (least + slack)
        };
        (0..3).map(share).product()
    }
}

/// Boxes overlap by at most about a sixth of the sum of their sizes, so relative depth times this is within 0..=1.
const DEPTHS: f32 = 6.0;

impl Order {
    /// The bucket of a pair, and whether it goes first or last there; `depth` is how deep its boxes overlap over the sum of
    /// their sizes, `alpha` the product of the two alphas.
    pub(super) fn bucket(
        self,
        boxes: impl FnOnce() -> BoxPair,
        depth: f32,
        alpha: f32,
        random: &mut u64,
    ) -> (usize, bool) {
        let step = |x: f32, steps: usize| ((x * steps as f32) as usize).min(steps - 1);
        match self {
            Self::DepthFirst => (0, true),
            Self::BreadthFirst => (0, false),
            Self::Penetration => (step(1.0 - DEPTHS * depth, BUCKETS), true),
            Self::OverlapVolume => (step(-libm::log2f(boxes().overlap_volume()) / 32.0, BUCKETS), true),
            Self::LowAlpha => (step(alpha, BUCKETS), true),
            Self::Random(_) => ((next(random) >> 57) as usize, true),
        }
    }
}

/// SplitMix64.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

const _: () = assert!(BUCKETS == 1 << 7);
