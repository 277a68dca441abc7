//! Which node pair is visited next.

use super::frames::{Frames, Relation, View};
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
    /// Deepest relative penetration of the boxes first, the least over the six face axes; among equals the lower alpha.
    /// The default, and by far the best at finding intersections early.
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

/// The boxes of a node pair, each seen from its own frame and from that of the other.
pub(super) struct BoxPair {
    a: Seen,
    b: Seen,
    a_in_b: Seen,
    b_in_a: Seen,
}

/// Centre and half extents.
type Seen = ([f32; 3], [f32; 3]);

impl BoxPair {
    pub fn new(a: &Node, b: &Node, relation: &Relation) -> Self {
        let frames = Frames::new(a, b, relation);
        let (a, b) = ((a.own_center, a.own_half), (b.own_center * relation.scale, b.own_half * relation.scale));
        let seen = |(center, half), view: &View| (xyz(view.point(center)), xyz(view.half(half)));
        Self {
            a: (xyz(a.0), xyz(a.1)),
            b: (xyz(b.0), xyz(b.1)),
            a_in_b: seen(a, &frames.of_a),
            b_in_a: seen(b, &frames.of_b),
        }
    }

    /// Half extents of both and the distance of the centres, on the six face axes.
    fn axes(&self) -> impl Iterator<Item = (f32, f32, f32)> + '_ {
        let in_a = (0..3).map(|k| (self.a.1[k], self.b_in_a.1[k], (self.b_in_a.0[k] - self.a.0[k]).abs()));
        let in_b = (0..3).map(|k| (self.a_in_b.1[k], self.b.1[k], (self.b.0[k] - self.a_in_b.0[k]).abs()));
        in_a.chain(in_b)
    }

    /// `min (s - |d|) / s`, `s` the sum of the half extents and `d` the offset of the centres on an axis; within 0..=1.
    fn penetration(&self) -> f32 {
        self.axes().map(|(a, b, d)| (a + b - d) / (a + b + 1e-30)).fold(1.0, f32::min).max(0.0)
    }

    /// Overlap volume over the smaller box, on A's axes; within 0..=1.
    fn overlap_volume(&self) -> f32 {
        let share = |(a, b, d): (f32, f32, f32)| {
            let (least, slack) = (2.0 * a.min(b), 1e-3 * (a + b) + 1e-9);
            ((a + b - d).clamp(0.0, least) + slack) / (least + slack)
        };
        self.axes().take(3).map(share).product()
    }
}

/// Classes of alpha among pairs of equal penetration.
const CLASSES: usize = 4;

impl Order {
    /// The bucket of a pair, and whether it goes first or last there.
    pub(super) fn bucket(self, boxes: &BoxPair, alpha: f32, random: &mut u64) -> (usize, bool) {
        let step = |x: f32, steps: usize| ((x * steps as f32) as usize).min(steps - 1);
        match self {
            Self::DepthFirst => (0, true),
            Self::BreadthFirst => (0, false),
            Self::Penetration => {
                let depth = step(1.0 - boxes.penetration(), BUCKETS / CLASSES);
                (depth * CLASSES + step(alpha, CLASSES), true)
            }
            Self::OverlapVolume => (step(-libm::log2f(boxes.overlap_volume()) / 32.0, BUCKETS), true),
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
