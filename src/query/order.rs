//! Which node pair is visited next.

use super::boxes::{box_in_a, box_in_b};
use super::frames::{Frames, Relation};
use super::queue::BUCKETS;
use crate::tree::Node;

/// What a query looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
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

/// The boxes of a node pair: those of A in the frame of A's side and those of B in the frame of B's, each seen from the
/// other side as well.
pub(super) struct BoxPair {
    a: ([f32; 3], [f32; 3]),
    b: ([f32; 3], [f32; 3]),
    a_in_b: ([f32; 3], [f32; 3]),
    b_in_a: ([f32; 3], [f32; 3]),
}

impl BoxPair {
    /// For pairs that are never queued.
    pub fn none() -> Self {
        let none = ([0.0; 3], [0.0; 3]);
        Self { a: none, b: none, a_in_b: none, b_in_a: none }
    }

    fn new(a: ([f32; 3], [f32; 3]), b: ([f32; 3], [f32; 3]), frames: &Frames, relation: &Relation) -> Self {
        let a_in_b = box_in_b(&a.0, &a.1, frames, relation.margin[1]);
        let b_in_a = box_in_a(&b.0, &b.1, frames, relation.margin[0]);
        Self { a, b, a_in_b, b_in_a }
    }

    pub fn of_children(a: &Node, i: usize, b: &Node, j: usize, frames: &Frames, relation: &Relation) -> Self {
        Self::new(child_box(a, i), child_box(b, j), frames, relation)
    }

    pub fn of_child_of_a(a: &Node, i: usize, b: &Node, frames: &Frames, relation: &Relation) -> Self {
        Self::new(child_box(a, i), (b.own_center, b.own_half), frames, relation)
    }

    pub fn of_child_of_b(a: &Node, b: &Node, j: usize, frames: &Frames, relation: &Relation) -> Self {
        Self::new((a.own_center, a.own_half), child_box(b, j), frames, relation)
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

fn child_box(node: &Node, lane: usize) -> ([f32; 3], [f32; 3]) {
    let at = |columns: &[[f32; 8]; 3]| [columns[0][lane], columns[1][lane], columns[2][lane]];
    (at(&node.center), at(&node.half))
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
