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
use super::queue::{Origin, Pair};
use super::workspace::Workspace;
use crate::math::Pose;
use crate::math::lanes::{Kernel, Lanes};
use crate::tree::{Node, Tree, WIDTH};
use crate::triangle::batch::{self, Rows};
use crate::triangle::triangles_intersect;

/// What a pair of nodes is replaced by.
enum Open {
    Both,
    A,
    B,
    TrianglesOfA,
    TrianglesOfB,
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
    /// Whether the deepest of siblings goes on top of the stack.
    pub greedy: bool,
    /// Triangle pairs that are let to wait before they are tested.
    pub batch: usize,
}

impl<C: Clock> Kernel for &mut Traversal<'_, '_, C> {
    type Output = StopReason;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> StopReason {
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
            } else if let Some((pair, origin)) = self.workspace.front.pop() {
                self.expand(lanes, pair, origin);
                self.workspace.testing = self.workspace.waiting.len() >= self.batch;
            } else if self.workspace.waiting.len() == 0 {
                return StopReason::Finished;
            } else {
                self.workspace.testing = true;
            }
        }
    }
}

impl<'q, C: Clock> Traversal<'q, '_, C> {
    /// Tests a triangle pair in doubt, or a batch of those that wait.
    ///
    /// Where copies of a surface run side by side all is in doubt, and whole regions never meet. So where the first hit is
    /// all that counts, a batch with doubts that come to nothing sends the traversal elsewhere; what waits is tested later.
    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) {
        if let Some(pair) = self.workspace.doubtful.pop() {
            self.test_exactly(pair);
        } else {
            self.test_batch(lanes);
            self.workspace.elsewhere = self.options.mode == Mode::Any && !self.workspace.doubtful.is_empty();
        }
        let workspace = &mut *self.workspace;
        let (waiting, last) = (workspace.waiting.len(), workspace.front.is_empty());
        if !workspace.doubtful.is_empty() {
            return;
        }
        if workspace.elsewhere {
            workspace.front.go_elsewhere();
        }
        // A last, partial batch is worth it only when nothing else is left.
        workspace.testing =
            waiting >= WIDTH && !workspace.elsewhere || waiting > 0 && last || workspace.waiting.is_full();
    }

    #[inline(always)]
    fn pair_limit(&self) -> usize {
        self.options.pair_limit.min(self.workspace.found.capacity())
    }

    /// Tests up to eight waiting pairs, as many as could be reported.
    #[inline(always)]
    fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let room = self.pair_limit() - self.workspace.found.len();
        let (pairs, count) = self.workspace.waiting.pop_batch(room);
        if count == 0 {
            return;
        }
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
        let [of_a, of_b] = &mut self.workspace.corners;
        let a = of_a.of(self.a, pair[0], |v| v);
        let b = of_b.of(self.b, pair[1], |v| self.b_in_a.transform_point(v));
        let meet = triangles_intersect(a, b);
        let stats = &mut self.workspace.run.stats;
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST;
        // The one step whose time differs a hundredfold.
        self.meter.look_next();
        if meet {
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
        workspace.sample.note(pair, workspace.run.found);
        workspace.run.found += 1;
        workspace.run.witness.get_or_insert(ids);
        workspace.found.push(ids);
    }

    #[inline(never)]
    fn queue_all(&mut self, mut hits: u64, origin: Origin, child: impl Fn(u32) -> Pair) {
        let mut ahead = if origin == Origin::Path { self.workspace.front.led() } else { 0 };
        while hits != 0 {
            let lane = hits.trailing_zeros();
            hits &= hits - 1;
            let pair = child(lane);
            let below = self.witnesses_below(pair, ahead);
            ahead &= !below;
            if !self.workspace.front.follow(pair, below) {
                self.queue(pair, self.depths.as_flattened()[lane as usize % 64]);
            }
        }
        if origin == Origin::Path {
            self.workspace.front.set_aside();
        }
    }

    /// Which of these witnesses of the frame before are below a pair.
    #[inline(always)]
    fn witnesses_below(&self, Pair { nodes: [a, b], .. }: Pair, among: u16) -> u16 {
        bits(among.into()).fold(0, |below, i| {
            let [x, y] = self.workspace.witnesses[i].map(|triangle| triangle as usize);
            let (a, b) = (&self.a.nodes()[a as usize], &self.b.nodes()[b as usize]);
            let leads = a.triangle_range().contains(&x) && b.triangle_range().contains(&y);
            below | u16::from(leads) << i
        })
    }

    /// Queues a pair whose boxes overlap by `depth`, unless it is a grain.
    fn queue(&mut self, pair: Pair, depth: f32) {
        let (a, b) = (&self.a.nodes()[pair.nodes[0] as usize], &self.b.nodes()[pair.nodes[1] as usize]);
        if libm::sqrtf(a.self_cost * b.self_cost) >= self.options.grain() {
            let boxes = || BoxPair::new(a, b, self.relation);
            let random = &mut self.workspace.run.random;
            let depth = depth / (a.size + b.size * self.relation.scale);
            let (bucket, first) = self.options.order.bucket(boxes, depth, a.alpha * b.alpha, random);
            self.workspace.front.queue(pair, bucket, first);
        } else {
            self.workspace.front.push(pair);
        }
    }
}

impl<'q, C: Clock> Opener<'q> for Traversal<'q, '_, C> {
    #[inline(always)]
    fn trees(&self) -> [&'q Tree; 2] {
        [self.a, self.b]
    }

    #[inline(always)]
    fn relation(&self) -> &'q Relation {
        self.relation
    }

    #[inline(always)]
    fn depths(&mut self) -> &mut Depths {
        &mut self.depths
    }

    #[inline(always)]
    fn count(&mut self, level: usize, bv_tests: u32) {
        let stats = &mut self.workspace.run.stats;
        stats.bv_tests_per_level[level.min(LEVELS - 1)] += u64::from(bv_tests);
        stats.work += WORK_PER_EXPANSION + u64::from(bv_tests);
    }

    #[inline(always)]
    fn push(&mut self, mut hits: u64, origin: Origin, child: impl Fn(u32) -> Pair) {
        let (mut deepest, mut at) = (f32::NEG_INFINITY, 0);
        if origin != Origin::Stack {
            return self.queue_all(hits, origin, child);
        }
        if hits == 0 {
            return;
        }
        while hits != 0 {
            let lane = hits.trailing_zeros();
            hits &= hits - 1;
            let place = self.workspace.front.push(child(lane));
            let depth = self.depths.as_flattened()[lane as usize % 64];
            if self.greedy && depth > deepest {
                (deepest, at) = (depth, place);
            }
        }
        if self.greedy {
            self.workspace.front.raise(at);
        }
    }

    #[inline(always)]
    fn push_one(&mut self, pair: Pair) {
        self.workspace.front.push(pair);
    }

    #[inline(always)]
    fn push_triangles(&mut self, hits: u64, first: [u32; 2]) {
        self.workspace.waiting.push_all(hits, first);
    }
}

/// What opens pairs, and where their children go.
pub(super) trait Opener<'q> {
    fn trees(&self) -> [&'q Tree; 2];

    fn relation(&self) -> &'q Relation;

    fn depths(&mut self) -> &mut Depths;

    fn count(&mut self, level: usize, bv_tests: u32);

    /// Puts pairs of children where their parent came from: on the stack, where the deepest goes on top if the first hit is all
    /// that counts, into the queue, or on the paths to witnesses and what is beside them into the queue. `child` makes the pair
    /// of a bit of `hits`.
    fn push(&mut self, hits: u64, origin: Origin, child: impl Fn(u32) -> Pair);

    /// Puts a pair on the stack.
    fn push_one(&mut self, pair: Pair);

    /// The triangles of a cluster, bit `8 i + j` for triangle `j` against child `i` of a node. Those of one child stay together:
    /// they are the part of the cluster that is still alive.
    #[inline(always)]
    fn push_held(&mut self, hits: u64, child: impl Fn(u32, u8) -> Pair) {
        for (i, alive) in (0..).zip(hits.to_le_bytes()) {
            if alive != 0 {
                self.push_one(child(i, alive));
            }
        }
    }

    /// The triangle pairs `first + [i, j]` for the bits `8 i + j` of `hits`.
    fn push_triangles(&mut self, hits: u64, first: [u32; 2]);

    /// Replaces a pair by the pairs of children that may meet.
    #[inline(always)]
    fn expand<L: Lanes>(&mut self, lanes: L, Pair { nodes, alive }: Pair, origin: Origin) {
        let [ia, ib] = nodes;
        let ([tree_a, tree_b], relation) = (self.trees(), self.relation());
        let scale = relation.scale;
        let (a, b) = (&tree_a.nodes()[ia as usize], &tree_b.nodes()[ib as usize]);
        let level = usize::from(a.depth) + usize::from(b.depth);
        let frames = Frames::new(a, b, relation);
        if !boxes::own(a, b, &frames, scale) {
            return self.count(level, 1);
        }
        // Kept in memory: the kernels broadcast single entries, which is dear out of registers.
        let frames = core::hint::black_box(&frames);
        let valid = [u32::from(alive[0]) & a.valid(), u32::from(alive[1]) & b.valid()];
        let first = [a.first_child, b.first_child];
        match open(a, b, scale) {
            Open::Both => {
                self.count(level + 2, valid[0].count_ones() * valid[1].count_ones() + 1);
                let hits = boxes::both(lanes, [a, b], valid, frames, scale, self.depths());
                if a.is_cluster {
                    self.push_triangles(hits, first);
                } else {
                    self.push(hits, origin, |lane| Pair::new(first[0] + lane / 8, first[1] + lane % 8));
                }
            }
            Open::A => {
                self.count(level + 1, u32::from(a.children) + 1);
                let of = [&frames.of_a, &frames.of_b];
                let hits = boxes::children(lanes, [a, b], of, [1.0, scale], &mut self.depths()[0]);
                self.push(hits.into(), origin, |i| Pair { nodes: [first[0] + i, ib], alive: [u8::MAX, alive[1]] });
            }
            Open::B => {
                self.count(level + 1, u32::from(b.children) + 1);
                let of = [&frames.of_b, &frames.of_a];
                let hits = boxes::children(lanes, [b, a], of, [scale, 1.0], &mut self.depths()[0]);
                self.push(hits.into(), origin, |j| Pair { nodes: [ia, first[1] + j], alive: [alive[0], u8::MAX] });
            }
            Open::TrianglesOfA => {
                self.count(level + 2, valid[0].count_ones() * u32::from(b.children) + 1);
                let view = frames.triangles_of_a(b, relation);
                let hits = boxes::triangles(lanes, b, scale, rows(tree_a, a), valid[0], &view, relation.skew);
                self.push_held(transposed(hits), |j, alive| Pair {
                    nodes: [ia, first[1] + j],
                    alive: [alive, u8::MAX],
                });
            }
            Open::TrianglesOfB => {
                self.count(level + 2, valid[1].count_ones() * u32::from(a.children) + 1);
                let view = frames.triangles_of_b(a, relation);
                let hits = boxes::triangles(lanes, a, 1.0, rows(tree_b, b), valid[1], &view, relation.skew);
                self.push_held(transposed(hits), |i, alive| Pair {
                    nodes: [first[0] + i, ib],
                    alive: [u8::MAX, alive],
                });
            }
        }
    }
}

/// Bit `8 i + j` goes to `8 j + i`: blocks of 1, 2 and 4 change places across the diagonal.
#[inline(always)]
fn transposed(mut bits: u64) -> u64 {
    for (shift, mask) in [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)] {
        let moved = (bits ^ (bits >> shift)) & mask;
        bits ^= moved ^ (moved << shift);
    }
    bits
}

/// The triangles of a cluster; the last one again where there are fewer than eight.
#[inline(always)]
fn rows<'t>(tree: &'t Tree, cluster: &Node) -> [&'t Rows; WIDTH] {
    let triangles = &tree.triangles()[cluster.triangle_range()];
    let last = triangles.len() - 1;
    let mut rows = [&triangles[last].0; WIDTH];
    let mut i = 0;
    while i < last {
        rows[i] = &triangles[i].0;
        i += 1;
    }
    rows
}

/// The larger of two inner nodes is opened alone if it is this many times larger than the other.
const LARGER: f32 = 6.0;

#[inline(always)]
fn open(a: &Node, b: &Node, scale: f32) -> Open {
    let (size_a, size_b) = (a.size, b.size * scale);
    match (a.is_cluster, b.is_cluster) {
        (true, true) => Open::Both,
        (true, false) if size_a > size_b => Open::TrianglesOfA,
        (true, false) => Open::B,
        (false, true) if size_b > size_a => Open::TrianglesOfB,
        (false, true) => Open::A,
        (false, false) if size_a > LARGER * size_b => Open::A,
        (false, false) if size_b > LARGER * size_a => Open::B,
        (false, false) => Open::Both,
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

#[cfg(test)]
mod tests {
    use super::transposed;

    #[test]
    fn transposing_moves_each_bit_across_the_diagonal() {
        for i in 0..8 {
            for j in 0..8 {
                assert_eq!(transposed(1 << (8 * i + j)), 1 << (8 * j + i));
            }
        }
        assert_eq!(transposed(transposed(0x0123_4567_89ab_cdef)), 0x0123_4567_89ab_cdef);
    }
}
