//! The one loop over node pairs, its stop rule, and what it guarantees.
//!
//! Every query runs through [`Traversal::run`]: `any` and `all`, with and without a budget, in every order. Each turn does
//! one step of bounded work, a triangle pair that is in doubt, a batch of eight waiting triangle pairs, or a node pair from
//! the front, and before each step the meter may end the call. Whatever is not done by then is still in the buffers:
//!
//! **Guarantee.** At every moment each intersecting pair of triangles has been reported, or waits, or is in doubt, or lies
//! under a pair of the front. So an empty rest proves that all have been reported, and a stopped run can say what may be
//! missing and go on later as if it had never stopped.

use super::Options;
use super::boxes::{self, Depths};
use super::budget::{Clock, Meter, WORK_PER_EXACT_TEST, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST};
use super::frames::{Frames, Relation};
use super::order::{BoxPair, Mode};
use super::outcome::{LEVELS, StopReason};
use super::queue::{Pair, TRIANGLE};
use super::workspace::Workspace;
use crate::math::Pose;
use crate::math::lanes::{Kernel, Lanes};
use crate::tree::{Node, Tree};
use crate::triangle::batch::{self, Rows};
use crate::triangle::triangles_intersect;

/// One side of a node pair.
#[derive(Clone, Copy)]
enum Side<'t> {
    Node(&'t Node),
    Triangle(&'t Rows),
}

/// Which nodes of a pair are replaced by their children.
enum Open {
    Both,
    A,
    B,
}

/// The side along which the hits of a test are counted.
#[derive(Clone, Copy)]
enum Along {
    A,
    B,
}

/// One call of a query.
pub(super) struct Traversal<'q, 'c, C> {
    pub a: &'q Tree,
    pub b: &'q Tree,
    pub b_in_a: &'q Pose,
    pub options: &'q Options,
    pub relation: &'q Relation,
    pub workspace: &'q mut Workspace,
    pub meter: Meter<'c, C>,
    pub depths: Depths,
    /// Triangle pairs that are let to wait before they are tested.
    pub batch: usize,
}

impl<C: Clock> Kernel for &mut Traversal<'_, '_, C> {
    type Output = StopReason;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> StopReason {
        let mut frames = Frames::UNKNOWN;
        loop {
            if let Some(reason) = self.meter.stop(self.workspace.run.stats.work) {
                return if self.workspace.is_done() { StopReason::Finished } else { reason };
            }
            if self.workspace.testing {
                if self.workspace.found.len() >= self.pair_limit() {
                    return StopReason::PairsFull;
                }
                self.test(lanes);
                if self.workspace.run.found > 0 && self.options.mode == Mode::Any {
                    return StopReason::FirstHit;
                }
            } else if let Some((pair, queued)) = self.workspace.front.pop() {
                self.expand(lanes, pair, queued, &mut frames);
                self.workspace.testing = self.workspace.waiting.len() >= self.batch;
            } else if self.workspace.waiting.is_empty() {
                return StopReason::Finished;
            } else {
                self.workspace.testing = true;
            }
        }
    }
}

impl<'q, C: Clock> Traversal<'q, '_, C> {
    /// Tests the triangle pair in doubt, or a batch of those that wait.
    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) {
        if let Some(pair) = self.workspace.doubtful.pop() {
            self.test_exactly(pair);
        } else {
            self.test_batch(lanes);
        }
        let workspace = &mut *self.workspace;
        let waiting = workspace.waiting.len();
        // A last, partial batch is worth it only when nothing else is left.
        workspace.testing =
            !workspace.doubtful.is_empty() || waiting >= 8 || (waiting > 0 && workspace.front.is_empty());
    }

    #[inline(always)]
    fn pair_limit(&self) -> usize {
        self.options.pair_limit.min(self.workspace.found.capacity())
    }

    /// Tests up to eight waiting pairs, as many as could be reported.
    #[inline(always)]
    fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let room = self.pair_limit() - self.workspace.found.len();
        let waiting = &mut self.workspace.waiting;
        let count = waiting.len().min(room).min(8);
        let Some(&last) = waiting.last() else { return };
        let mut pairs = [last; 8];
        pairs[..count].copy_from_slice(&waiting[waiting.len() - count..]);
        waiting.truncate(waiting.len() - count);

        let (a, b) = (self.a.triangles(), self.b.triangles());
        let [p, q, r, s, t, u, v, w] = pairs;
        let of_a = |pair: [u32; 2]| &a[pair[0] as usize].0;
        let of_b = |pair: [u32; 2]| &b[pair[1] as usize].0;
        let verdicts = batch::test(
            lanes,
            [of_a(p), of_a(q), of_a(r), of_a(s), of_a(t), of_a(u), of_a(v), of_a(w)],
            [of_b(p), of_b(q), of_b(r), of_b(s), of_b(t), of_b(u), of_b(v), of_b(w)],
            &self.relation.triangles,
        );
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += count as u64;
        stats.work += count as u64 * WORK_PER_TRIANGLE_TEST;
        let tested = (1 << count) - 1;
        for lane in bits(verdicts.hit & tested) {
            self.report(pairs[lane]);
        }
        for lane in bits(verdicts.doubt & tested) {
            self.workspace.doubtful.push(pairs[lane]);
        }
    }

    #[cold]
    fn test_exactly(&mut self, pair: [u32; 2]) {
        let id = [self.a.ids()[pair[0] as usize], self.b.ids()[pair[1] as usize]];
        let a = self.a.mesh().triangle(id[0] as usize);
        let b = self.b.mesh().triangle(id[1] as usize).map(|v| self.b_in_a.transform_point(v));
        let stats = &mut self.workspace.run.stats;
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST;
        // The one step whose time differs a hundredfold.
        self.meter.look_next();
        if triangles_intersect(&a, &b) {
            self.report(pair);
        }
    }

    fn report(&mut self, pair: [u32; 2]) {
        let workspace = &mut *self.workspace;
        if workspace.run.found > 0 && self.options.mode == Mode::Any {
            // One is enough; the others of its batch stay open.
            return workspace.doubtful.push(pair);
        }
        let ids = [self.a.ids()[pair[0] as usize], self.b.ids()[pair[1] as usize]];
        workspace.run.found += 1;
        workspace.run.witness.get_or_insert([ids, pair]);
        workspace.found.push(ids);
    }

    /// Replaces a pair by the pairs of children that may meet.
    #[inline(always)]
    fn expand<L: Lanes>(&mut self, lanes: L, [ia, ib]: Pair, queued: bool, frames: &mut Frames) {
        let Relation { scale, skew, .. } = *self.relation;
        match (side(self.a, ia), side(self.b, ib)) {
            (Side::Node(a), Side::Node(b)) => {
                frames.update(Some(a), Some(b), self.relation);
                let level = usize::from(a.depth) + usize::from(b.depth);
                if !boxes::own(a, b, frames) {
                    return self.count(level, 1);
                }
                let (of_a, of_b) = (&frames.of_a, &frames.of_b);
                match open(a, b, scale) {
                    Open::Both => {
                        self.count(level + 2, u64::from(a.children) * u64::from(b.children) + 1);
                        let hits = boxes::both(lanes, a, b, frames, scale, &mut self.depths);
                        self.place(hits, [first_child(a), first_child(b)], Along::B, queued);
                    }
                    Open::A => {
                        self.count(level + 1, u64::from(a.children) + 1);
                        let hits = boxes::children(lanes, a, b, [of_a, of_b], 1.0 / scale, &mut self.depths);
                        self.place(hits, [first_child(a), ib], Along::A, queued);
                    }
                    Open::B => {
                        self.count(level + 1, u64::from(b.children) + 1);
                        let hits = boxes::children(lanes, b, a, [of_b, of_a], scale, &mut self.depths);
                        self.place(hits, [ia, first_child(b)], Along::B, queued);
                    }
                }
            }
            (Side::Triangle(triangle), Side::Node(b)) => {
                frames.update(None, Some(b), self.relation);
                self.count(usize::from(b.depth) + usize::from(b.height), u64::from(b.children));
                let view = &frames.of_a;
                let hits = boxes::children_and_triangle(lanes, b, triangle, view, skew, &mut self.depths);
                self.place(hits, [ia, first_child(b)], Along::B, false);
            }
            (Side::Node(a), Side::Triangle(triangle)) => {
                frames.update(Some(a), None, self.relation);
                self.count(usize::from(a.depth) + usize::from(a.height), u64::from(a.children));
                let view = &frames.of_b;
                let hits = boxes::children_and_triangle(lanes, a, triangle, view, skew, &mut self.depths);
                self.place(hits, [first_child(a), ib], Along::A, false);
            }
            (Side::Triangle(_), Side::Triangle(_)) => debug_assert!(false, "these never come to the front"),
        }
    }

    #[inline(always)]
    fn count(&mut self, level: usize, bv_tests: u64) {
        let stats = &mut self.workspace.run.stats;
        stats.bv_tests_per_level[level.min(LEVELS - 1)] += bv_tests;
        stats.work += WORK_PER_EXPANSION + bv_tests;
    }

    /// Puts the pairs of `hits` where they belong: triangle pairs to those that wait, node pairs into the queue if their
    /// parent came from there, all else on the stack. Where the first hit is all that counts, the deepest goes on top.
    ///
    /// The low three bits of a hit count from `first` along one side, the others along the other.
    #[inline(always)]
    fn place(&mut self, mut hits: u64, first: Pair, along: Along, queued: bool) {
        let triangles = first[0] & first[1] & TRIANGLE != 0;
        let greedy = self.options.mode == Mode::Any;
        let mut deepest = f32::NEG_INFINITY;
        while hits != 0 {
            let lane = hits.trailing_zeros();
            hits &= hits - 1;
            let (i, j) = match along {
                Along::A => (lane % 8, lane / 8),
                Along::B => (lane / 8, lane % 8),
            };
            let pair = [first[0] + i, first[1] + j];
            if triangles {
                self.workspace.waiting.push([pair[0] & !TRIANGLE, pair[1] & !TRIANGLE]);
            } else if queued {
                self.queue(pair);
            } else {
                let depth = self.depths.as_flattened()[lane as usize];
                let on_top = !greedy || depth > deepest;
                self.workspace.front.push(pair, on_top);
                deepest = deepest.max(depth);
            }
        }
    }

    /// Queues a pair, unless it is a grain.
    #[inline(never)]
    fn queue(&mut self, pair: Pair) {
        match (side(self.a, pair[0]), side(self.b, pair[1])) {
            (Side::Node(a), Side::Node(b)) if libm::sqrtf(a.visits * b.visits) >= self.options.grain => {
                let boxes = BoxPair::new(a, b, self.relation);
                let random = &mut self.workspace.run.random;
                let (bucket, first) = self.options.order.bucket(&boxes, a.alpha * b.alpha, random);
                self.workspace.front.queue(pair, bucket, first);
            }
            _ => self.workspace.front.push(pair, true),
        }
    }
}

#[inline(always)]
fn side(tree: &Tree, index: u32) -> Side<'_> {
    if index & TRIANGLE == 0 {
        Side::Node(&tree.nodes()[index as usize])
    } else {
        Side::Triangle(&tree.triangles()[(index & !TRIANGLE) as usize].0)
    }
}

#[inline(always)]
fn first_child(node: &Node) -> u32 {
    node.first_child | if node.is_cluster { TRIANGLE } else { 0 }
}

/// The larger of two nodes of one kind is opened alone if it is this many times larger than the other.
const LARGER: f32 = 6.0;

/// A cluster is opened before an inner node only if it is this many times larger.
const LARGER_CLUSTER: f32 = 4.0;

#[inline(always)]
fn open(a: &Node, b: &Node, scale: f32) -> Open {
    let (size_a, size_b) = (a.size, b.size * scale);
    match (a.is_cluster, b.is_cluster) {
        (true, false) => {
            if size_a > LARGER_CLUSTER * size_b {
                Open::A
            } else {
                Open::B
            }
        }
        (false, true) => {
            if size_b > LARGER_CLUSTER * size_a {
                Open::B
            } else {
                Open::A
            }
        }
        _ if size_a > LARGER * size_b => Open::A,
        _ if size_b > LARGER * size_a => Open::B,
        _ => Open::Both,
    }
}

/// The positions of the bits of `mask`, lowest first.
#[inline(always)]
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < 32).then_some(bit)
    })
}
