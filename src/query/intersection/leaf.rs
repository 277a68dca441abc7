//! Tests of triangle pairs: eight at a time in the fast filter, those in doubt one at a time in the
//! exact test.

use super::meeting::Meeting;
use crate::engine::options::Mode;
use crate::engine::traversal::Traversal;
use crate::engine::triangles::corners::Corners;
use crate::engine::triangles::{ids, is_full, points, pop_batch, rows};
use crate::engine::workspace::{Run, Workspace};
use crate::model::cost::{
    WORK_PER_CONTACT, WORK_PER_EXACT_TEST, WORK_PER_SEGMENT, WORK_PER_TRIANGLE_TEST,
};
use crate::query::contacts::contact::{Contact, face_normal};
use crate::query::manifolds::manifold::Shape;
use crate::tree::WIDTH;
use punctual_geom::bits;
use punctual_geom::lanes::Lanes;
use punctual_geom::triangle::batch::{self, Crossings};
use punctual_geom::{triangle_segment, triangles_intersect};

impl<const POINTS: bool> Traversal<'_, '_, Meeting<'_>, POINTS> {
    /// Tests a triangle pair in doubt, or a batch of those that wait.
    ///
    /// If copies of a surface lie side by side, every pair is in doubt, and whole regions have no
    /// intersection. So with [`Mode::Any`], a batch with doubts but without a hit sends the
    /// traversal to another part of the stack. The pairs that wait are tested later.
    #[inline(always)]
    pub(crate) fn test_triangles<L: Lanes>(&mut self, lanes: L) {
        if let Some(&pair) = self.workspace.uncertain.last() {
            if !self.look_for_plane(pair) {
                self.workspace.uncertain.pop();
                self.test_exactly(pair);
            }
        } else {
            self.test_batch(lanes);
            self.workspace.inconclusive =
                self.question.options.mode == Mode::Any && !self.workspace.uncertain.is_empty();
        }
        let workspace = &mut *self.workspace;
        if workspace.uncertain.is_empty() && workspace.inconclusive {
            workspace.frontier.go_elsewhere();
        }
    }

    /// True if the next step is to test triangle pairs, or trace curves, again.
    #[inline(always)]
    pub(crate) fn goes_on_testing(&self) -> bool {
        let workspace = &*self.workspace;
        let waiting = &workspace.waiting;
        // A last, partial batch is worthwhile only when nothing else is left.
        let pays = waiting.len() >= WIDTH && !workspace.inconclusive
            || !waiting.is_empty() && workspace.frontier.is_empty()
            || is_full(waiting);
        // Once nothing is left, every pair that a curve could lead to is known.
        pays || !workspace.uncertain.is_empty()
            || workspace.state.intersection.trace.is_due() && !workspace.is_done()
    }

    /// True if hits are contacts. Then hits also go through the exact test, which gives the segment
    /// in which the triangles intersect.
    #[inline(always)]
    fn looks_for_contacts(&self) -> bool {
        self.workspace.state.contacts.margin().is_some()
    }

    /// Number of further pairs that could be reported.
    #[inline(always)]
    pub(crate) fn room(&self) -> usize {
        let found = &self.workspace.state.intersection.found;
        if self.looks_for_contacts() {
            return usize::from(!self.workspace.state.contacts.is_full()) * WIDTH;
        }
        self.question.options.pair_limit.min(found.capacity()) - found.len()
    }

    /// Tests up to eight waiting pairs, at most as many as could be reported.
    #[inline(always)]
    fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let room = self.room();
        let (pairs, count) = pop_batch(&mut self.workspace.waiting, room);
        if count == 0 {
            return;
        }
        let tested = (1 << count) - 1;
        let mut crossings = Crossings::default();
        let made = [
            points::<POINTS>(self.a, pairs, 0),
            points::<POINTS>(self.b, pairs, 1),
        ];
        let verdicts = batch::test(
            lanes,
            tested,
            [
                rows(self.a, &made[0], pairs, 0),
                rows(self.b, &made[1], pairs, 1),
            ],
            &self.relative.triangles,
            self.strategy.trace.goes_on().then_some(&mut crossings),
        );
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += count as u64;
        stats.work += count as u64 * WORK_PER_TRIANGLE_TEST;
        let exact = if self.looks_for_contacts() {
            verdicts.hit | verdicts.doubt
        } else {
            verdicts.doubt
        };
        for lane in bits(verdicts.hit & !exact & tested) {
            self.report(pairs[lane], || crossings.of(lane));
        }
        for lane in bits(exact & tested) {
            self.workspace.uncertain.push(pairs[lane]);
        }
    }

    /// Continues the pass over all vertices, along the normal of a triangle in doubt, if it is due.
    /// If it separates the surfaces, drops everything left.
    #[cold]
    #[inline(never)]
    fn look_for_plane(&mut self, pair: [u32; 2]) -> bool {
        let (trees, b_in_a) = ([self.a, self.b], self.b_in_a);
        let Workspace {
            corners,
            run: Run { stats, .. },
            state,
            ..
        } = &mut *self.workspace;
        let (halves, work) = (
            state.distance.halves(trees),
            stats.exact_tests * WORK_PER_EXACT_TEST,
        );
        if stats.found > 0 || !halves.is_due(work) {
            return false;
        }
        let towards = || {
            let [a, b] = Corners::of_pair(corners, trees, b_in_a, pair);
            let normal = face_normal(a).unwrap_or_default();
            normal * normal.dot(b[0] - a[0]).signum()
        };
        let (taken, gap) = halves.look(trees, b_in_a, towards, work);
        stats.work += taken;
        self.deadline.allow_for_long_step();
        if gap.is_some() {
            self.workspace.frontier.drop_all();
            self.workspace.waiting.clear();
            self.workspace.uncertain.clear();
        }
        true
    }

    #[cold]
    #[inline(never)]
    fn test_exactly(&mut self, pair: [u32; 2]) {
        let trees = [self.a, self.b];
        let Workspace {
            corners,
            run: Run { stats, .. },
            state,
            ..
        } = &mut *self.workspace;
        let (contacts, manifolds) = (&mut state.contacts, &mut state.manifolds);
        let of_pair @ [a, b] = Corners::of_pair(corners, trees, self.b_in_a, pair);
        // The only step whose time varies a hundredfold.
        self.deadline.allow_for_long_step();
        if manifolds.reduction.is_on {
            let shape = Shape {
                trees,
                b_in_a: self.b_in_a,
            };
            let (reduction, overlaps) = (&mut manifolds.reduction, &mut manifolds.overlaps);
            if !reduction.take_near(shape, pair, of_pair, overlaps, contacts, stats) {
                self.workspace.uncertain.push(pair);
            }
            return;
        }
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST;
        if contacts.margin().is_none() {
            if triangles_intersect(a, b) {
                self.report(pair, || 0);
            }
        } else if let Some(segment) = triangle_segment(a, b) {
            stats.work += WORK_PER_SEGMENT + WORK_PER_CONTACT;
            stats.found += 1;
            contacts.push(Contact::touching(ids(trees, pair), of_pair, segment));
        }
    }

    /// Reports a pair that intersects, unless it is known. For curve tracing, `crossings` returns
    /// the edges that certainly cross.
    #[inline(always)]
    fn report(&mut self, pair: [u32; 2], crossings: impl FnOnce() -> u32) {
        let workspace = &mut *self.workspace;
        if workspace.run.stats.found > 0 && self.question.options.mode == Mode::Any {
            // One hit is enough; the other hits of its batch stay open.
            return workspace.uncertain.push(pair);
        }
        if self.strategy.trace.goes_on() && workspace.run.stats.found == 0 {
            self.strategy = self.strategy.after_first_hit();
            workspace.run.strategy = self.strategy;
            workspace.frontier.end_ranking();
        }
        let (trees, state) = ([self.a, self.b], &mut workspace.state.intersection);
        if self.strategy.trace.goes_on() && !state.trace.note(trees, pair, crossings()) {
            return;
        }
        let ids = ids(trees, pair);
        state.sample.note(pair, workspace.run.stats.found);
        workspace.run.stats.found += 1;
        workspace.run.witness.get_or_insert(ids);
        state.found.push(ids);
    }
}
