//! Points of a cloud near a surface: how the traversal handles node pairs and triangle pairs.
//!
//! A block of points meets many nodes of the surface. The points found are marked, and are of no
//! interest to the pairs that follow. So each point is found once.

use crate::engine::boxes::RelativePose;
use crate::engine::expand::{Keys, LeafRows, Scratch, Sink, expand};
use crate::engine::frontier::{Origin, Pair};
use crate::engine::outcome::{Stats, StopReason};
use crate::engine::traversal::{Traversal, Visitor};
use crate::engine::triangles::corners::Corners;
use crate::model::cost::{
    WORK_PER_CLOSEST_POINTS, WORK_PER_EXACT_TEST, WORK_PER_LOOKUP, WORK_PER_POINT_AROUND,
};
use crate::query::distance::gaps::{Direction, Gaps};
use crate::query::distance::search::root;
use crate::tree::WIDTH;
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Lanes};
use punctual_geom::triangle::batch::Rows;
use punctual_geom::triangle::distance::{Around, closest_or_meeting, closest_to_point};
use punctual_geom::triangles_intersect;

/// The question which points are within a reach.
pub(super) struct Nearby {
    /// The largest distance of interest, in the length unit of the meshes.
    reach: f64,
    /// Pairs of boxes at this squared distance or more, in A's units, are dropped.
    cut: f32,
    /// [`Gaps::doubt`].
    doubt: f32,
    /// A point closer than `sure` is within the reach, one farther than `far` is not; in A's units.
    sure: f32,
    far: f32,
    /// The block of the opened pair, if its points are opened.
    block: usize,
}

impl Nearby {
    pub fn new(relative: &RelativePose, reach: f64) -> Self {
        let beyond = (reach * (1.0 + 4.0 * f64::EPSILON)).max(f64::MIN_POSITIVE) / relative.unit;
        let cut = ((beyond * beyond * (1.0 + f64::from(f32::EPSILON))) as f32).max(1e-36);
        let far = libm::sqrtf(cut) * (1.0 + 4.0 * f32::EPSILON);
        // Without a map in `f32` every pair is in doubt.
        let sure = if relative.shrink > 0.0 {
            (reach / relative.unit * (1.0 - f64::from(f32::EPSILON))) as f32
        } else {
            0.0
        };
        Self {
            reach,
            cut,
            doubt: root(cut) + relative.least_gap_and_margin(),
            sure,
            far,
            block: 0,
        }
    }
}

impl<const POINTS: bool> Visitor for Traversal<'_, '_, Nearby, POINTS> {
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        self.workspace.frontier.pop()
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, mut pair: Pair, scratch: &mut Scratch) {
        if let Some(block) = self.a.block_of(pair.nodes[0]) {
            pair.active[0] &= !self.workspace.state.near_points.marks[block];
            self.question.block = block;
            if pair.active[0] == 0 {
                self.workspace.run.stats.work += WORK_PER_LOOKUP;
                return;
            }
        }
        let (question, relative) = (&self.question, self.relative);
        let direction = Direction::new(DVec3::ZERO);
        let mut gaps = Gaps::<false>::new(question.cut, question.doubt, relative, direction);
        let trees = [self.a, self.b];
        expand::<POINTS, _, _>(lanes, pair, trees, relative, &mut gaps, scratch, self);
    }

    #[inline(always)]
    fn waits(&self, _: bool) -> bool {
        !self.workspace.waiting.is_empty()
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, _: L) -> Option<StopReason> {
        if self.workspace.state.near_points.room() == 0 {
            return Some(StopReason::PairsFull);
        }
        self.test_one();
        self.workspace.testing = !self.workspace.waiting.is_empty();
        None
    }
}

impl<const POINTS: bool> Traversal<'_, '_, Nearby, POINTS> {
    /// Tests the last waiting pair in `f64`, unless its point is known.
    #[cold]
    #[inline(never)]
    fn test_one(&mut self) {
        let workspace = &mut *self.workspace;
        let Some(pair) = workspace.waiting.pop() else {
            return;
        };
        let (block, lane) = self.a.place_in_block(pair[0]);
        let stats = &mut workspace.run.stats;
        if workspace.state.near_points.marks[block] >> lane & 1 != 0 {
            stats.work += WORK_PER_LOOKUP;
            return;
        }
        self.deadline.allow_for_long_step();
        let trees = [self.a, self.b];
        let [a, b] = Corners::of_pair(&mut workspace.corners, trees, self.b_in_a, pair);
        let is_within = if self.question.reach > 0.0 {
            stats.work += WORK_PER_CLOSEST_POINTS;
            let found = closest_to_point(b, a[0]).unwrap_or_else(|| closest_or_meeting(b, a));
            found.low <= self.question.reach
        } else {
            stats.exact_tests += 1;
            stats.work += WORK_PER_EXACT_TEST;
            triangles_intersect(a, b)
        };
        if is_within {
            stats.found += 1;
            let id = self.a.ids()[pair[0] as usize];
            (workspace.state.near_points).mark(block, 1 << lane, |_| id);
        }
    }
}

impl<const POINTS: bool> Sink for Traversal<'_, '_, Nearby, POINTS> {
    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        &mut self.workspace.run.stats
    }

    #[inline(always)]
    fn pairs(&mut self, hits: u64, _: &Keys, child: impl Fn(u32) -> Pair) {
        self.workspace.frontier.push_all(hits, child);
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, _: impl FnOnce() -> f32) {
        self.workspace.frontier.push(pair);
    }

    /// Decides points one by one, each against all triangles of the other leaf.
    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &mut self,
        lanes: L,
        hits: u64,
        _: impl Fn(usize) -> f32,
        first: [u32; 2],
        rows: impl FnOnce() -> LeafRows<'t>,
    ) {
        if hits == 0 {
            return;
        }
        let [a, b] = rows();
        let around = Around::new(lanes, a[0], b, &self.relative.triangles);
        let (sure, far) = (
            F8::splat(lanes, self.question.sure),
            F8::splat(lanes, self.question.far),
        );
        let workspace = &mut *self.workspace;
        let (mut found, mut tested) = (0_u8, 0);
        let room = workspace.state.near_points.room();
        for i in 0..WIDTH {
            let row = (hits >> (WIDTH * i)) as u32 & 0xff;
            if row == 0 {
                continue;
            }
            tested += 1;
            let [low, high] = around.bounds(lanes, between(a[0], a[i]));
            let near = high.less(sure).mask() & row;
            if near != 0 && found.count_ones() < room as u32 {
                found |= 1 << i;
                continue;
            }
            for j in bits(row & (near | !far.less(low).mask())) {
                workspace
                    .waiting
                    .push([first[0] + i as u32, first[1] + j as u32]);
            }
        }
        let stats = &mut workspace.run.stats;
        stats.primitive_tests += u64::from(hits.count_ones());
        stats.work += tested * WORK_PER_POINT_AROUND;
        if found != 0 {
            stats.found += u64::from(found.count_ones());
            let ids = &self.a.ids()[first[0] as usize..];
            let block = self.question.block;
            (workspace.state.near_points).mark(block, found, |lane| ids[lane]);
        }
    }
}

/// The vector between two points of a cloud, in its units.
#[inline(always)]
fn between(from: &Rows, to: &Rows) -> [f32; 3] {
    let at = |rows: &Rows, k: usize| f64::from(rows[0][k]) + f64::from(rows[2][k + 1]);
    [0, 1, 2].map(|k| (at(to, k) - at(from, k)) as f32)
}
