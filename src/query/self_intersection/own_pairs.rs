//! Self-intersection: how the traversal handles node pairs of one tree, and triangle pairs.
//!
//! A node is paired with itself, and with nodes that follow it. So each pair of triangles comes
//! once.

use crate::engine::boxes::overlap::Overlap;
use crate::engine::expand::{Keys, LeafRows, Scratch, Sink, expand};
use crate::engine::frontier::{Origin, Pair};
use crate::engine::options::{Mode, Options};
use crate::engine::outcome::{Stats, StopReason};
use crate::engine::traversal::{Traversal, Visitor};
use crate::engine::triangles::{ids, is_full, points, pop_batch, push_all, rows};
use crate::model::cost::{WORK_PER_EXACT_TEST, WORK_PER_TRIANGLE_TEST};
use crate::tree::WIDTH;
use punctual_geom::bits;
use punctual_geom::lanes::Lanes;
use punctual_geom::triangle::batch;
use punctual_geom::triangle::shared::{meet_only_in, meet_only_in_shared, shared};
use punctual_geom::triangles_intersect_beyond_shared;

/// The pairs of children `i`, `j` of one node with `i < j`.
const FORWARD: u64 = 0x0080_c0e0_f0f8_fcfe;

/// Those with `i = j`.
const SAME: u64 = 0x8040_2010_0804_0201;

/// The question whether, or where, a surface intersects itself.
pub(super) struct OwnPairs<'q> {
    options: &'q Options,
    /// True if the opened pair is a node with itself.
    is_same: bool,
}

impl<'q> OwnPairs<'q> {
    pub fn new(options: &'q Options) -> Self {
        let is_same = false;
        Self { options, is_same }
    }
}

impl<const POINTS: bool> Visitor for Traversal<'_, '_, OwnPairs<'_>, POINTS> {
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        self.workspace.frontier.pop()
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair, scratch: &mut Scratch) {
        self.question.is_same = pair.nodes[0] == pair.nodes[1];
        let (trees, relative) = ([self.a, self.b], self.relative);
        let measure = &mut Overlap::default();
        expand::<POINTS, _, _>(lanes, pair, trees, relative, measure, scratch, self);
    }

    #[inline(always)]
    fn waits(&self, any: bool) -> bool {
        let enough = if any { 1 } else { self.strategy.batch };
        self.workspace.waiting.len() >= enough
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason> {
        let found = &self.workspace.state.intersection.found;
        if found.len() >= self.question.options.pair_limit.min(found.capacity()) {
            return Some(StopReason::PairsFull);
        }
        match self.workspace.uncertain.pop() {
            Some(pair) => self.test_exactly(pair),
            None => self.test_batch(lanes),
        }
        let workspace = &mut *self.workspace;
        let waiting = &workspace.waiting;
        workspace.testing = !workspace.uncertain.is_empty()
            || waiting.len() >= WIDTH
            || !waiting.is_empty() && workspace.frontier.is_empty()
            || is_full(waiting);
        let is_enough = workspace.run.stats.found > 0 && self.question.options.mode == Mode::Any;
        is_enough.then_some(StopReason::FirstHit)
    }
}

impl<const POINTS: bool> Traversal<'_, '_, OwnPairs<'_>, POINTS> {
    /// Tests up to eight waiting pairs: those that share vertices, then the others, and in `f64`
    /// what that leaves in doubt. Corners of different vertices may be at one position.
    #[inline(always)]
    fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let tree = self.a;
        let (pairs, count) = pop_batch(&mut self.workspace.waiting, WIDTH);
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += count as u64;
        stats.work += count as u64 * WORK_PER_TRIANGLE_TEST;
        let made = [
            points::<POINTS>(tree, pairs, 0),
            points::<POINTS>(tree, pairs, 1),
        ];
        let rows = [
            rows(tree, &made[0], pairs, 0),
            rows(tree, &made[1], pairs, 1),
        ];
        let tested = (1 << count) - 1;
        let mut corners = [0; WIDTH];
        let mut strangers = 0;
        for (lane, &[i, j]) in pairs.iter().enumerate() {
            corners[lane] = shared(&tree.vertices_of(i), &tree.vertices_of(j));
            strangers |= u32::from(corners[lane] == 0) << lane;
        }
        let mut doubts = 0;
        if strangers & tested != tested {
            doubts |= !strangers & !meet_only_in_shared(lanes, &corners, rows);
        }
        if strangers & tested != 0 {
            let verdicts = batch::test(lanes, strangers, rows, &self.relative.triangles, None);
            doubts |= strangers & (verdicts.hit | verdicts.doubt);
        }
        let scale = tree.unit().scale();
        for lane in bits(doubts & tested) {
            let [a, b] = pairs[lane].map(|triangle| tree.corners(triangle));
            if !meet_only_in(shared(&a, &b), &a, &b, scale) {
                self.workspace.uncertain.push(pairs[lane]);
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn test_exactly(&mut self, pair: [u32; 2]) {
        let [a, b] = pair.map(|triangle| self.a.corners(triangle));
        // The only step whose time varies a hundredfold.
        self.deadline.allow_for_long_step();
        let run = &mut self.workspace.run;
        run.stats.exact_tests += 1;
        run.stats.work += WORK_PER_EXACT_TEST;
        if triangles_intersect_beyond_shared(&a, &b) {
            let mut ids = ids([self.a; 2], pair);
            ids.sort_unstable();
            run.stats.found += 1;
            run.witness.get_or_insert(ids);
            self.workspace.state.intersection.found.push(ids);
        }
    }
}

impl<const POINTS: bool> Sink for Traversal<'_, '_, OwnPairs<'_>, POINTS> {
    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        &mut self.workspace.run.stats
    }

    #[inline(always)]
    fn pairs(&mut self, mut hits: u64, _: &Keys, child: impl Fn(u32) -> Pair) {
        if self.question.is_same {
            hits &= FORWARD | SAME;
        }
        self.workspace.frontier.push_all(hits, child);
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, _: impl FnOnce() -> f32) {
        self.workspace.frontier.push(pair);
    }

    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &mut self,
        _: L,
        mut hits: u64,
        _: impl Fn(usize) -> f32,
        first: [u32; 2],
        _: impl FnOnce() -> LeafRows<'t>,
    ) {
        if self.question.is_same {
            hits &= FORWARD;
        }
        push_all(&mut self.workspace.waiting, hits, first);
    }
}
