//! The one loop over node pairs, its stop rule, and what it guarantees.
//!
//! Every query runs through [`Traversal::run`]: `any` and `all`, with and without a budget, in every order. Each turn does
//! one step of bounded work: it tests a triangle pair that is in doubt, or a batch of eight waiting triangle pairs ([`leaf`]),
//! or opens a node pair of the front ([`expand`]). Before each step the deadline may end the call. Whatever is not done by
//! then is still in the buffers:
//!
//! **Guarantee.** At every moment each intersecting pair of triangles has been reported, or waits, or is in doubt, or lies
//! under a pair of the front. So an empty rest proves that all have been reported, and a stopped run can say what may be
//! missing and go on later as if it had never stopped.
//!
//! A pair of clusters to which a hit leads ([`march`]) may be opened before the front comes to it; it is passed over then.
//!
//! [`leaf`]: super::leaf
//! [`march`]: super::march

use super::boxes::Depths;
use super::deadline::Deadline;
use super::expand::{Sink, expand};
use super::options::{Mode, Options};
use super::order::overlap_volume;
use super::outcome::{LEVELS, StopReason};
use super::queue::{Origin, Pair};
use super::strategy::Strategy;
use super::views::Relation;
use super::workspace::Workspace;
use crate::math::Pose;
use crate::math::lanes::{Kernel, Lanes};
use crate::model::cost::{WORK_PER_EXPANSION, WORK_PER_LOOKUP};
use crate::tree::Tree;

/// One call of a query.
pub(super) struct Traversal<'q, 'c> {
    pub a: &'q Tree,
    pub b: &'q Tree,
    pub b_in_a: &'q Pose,
    pub options: &'q Options,
    pub strategy: Strategy,
    pub relation: &'q Relation,
    pub workspace: &'q mut Workspace,
    pub deadline: &'q mut Deadline<'c>,
    pub depths: Depths,
    /// Where the pair at hand comes from.
    pub origin: Origin,
}

impl Kernel for &mut Traversal<'_, '_> {
    type Output = StopReason;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> StopReason {
        loop {
            if let Some(reason) = self.deadline.stop(self.workspace.run.stats.work) {
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
            } else if let Some((pair, origin)) = self.next_pair() {
                self.origin = origin;
                if !self.strategy.march || self.is_new(pair) {
                    expand(lanes, pair, [self.a, self.b], self.relation, self);
                }
                self.workspace.testing = self.workspace.waiting.len() >= self.strategy.batch;
            } else if self.workspace.waiting.len() == 0 {
                return StopReason::Finished;
            } else {
                self.workspace.testing = true;
            }
        }
    }
}

impl Traversal<'_, '_> {
    /// The pair to be opened next: what hits lead to, before the front.
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        if self.strategy.march
            && let Some(pair) = self.workspace.march.pop()
        {
            return Some((pair, Origin::Stack));
        }
        self.workspace.front.pop()
    }

    /// Whether a pair has still to be opened: it is none of clusters to which a hit has led before.
    fn is_new(&mut self, Pair { nodes: [a, b], .. }: Pair) -> bool {
        self.workspace.run.stats.work += WORK_PER_LOOKUP;
        let are_clusters = || self.a.nodes()[a as usize].is_cluster && self.b.nodes()[b as usize].is_cluster;
        self.workspace.march.visit([a, b], are_clusters)
    }

    #[inline(never)]
    fn queue_all(&mut self, mut hits: u64, child: impl Fn(u32) -> Pair) {
        let mut ahead = if self.origin == Origin::Path { self.workspace.front.path_witnesses() } else { 0 };
        while hits != 0 {
            let bit = hits.trailing_zeros();
            hits &= hits - 1;
            let pair = child(bit);
            let below = self.witnesses_below(pair, ahead);
            ahead &= !below;
            if !self.workspace.front.follow(pair, below) {
                self.queue(pair, self.depths.as_flattened()[bit as usize % 64]);
            }
        }
        if self.origin == Origin::Path {
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

    /// Queues a pair whose boxes overlap by `depth`, or pushes it on the stack if its expected cost is below the threshold.
    fn queue(&mut self, pair: Pair, depth: f32) {
        let (a, b) = (&self.a.nodes()[pair.nodes[0] as usize], &self.b.nodes()[pair.nodes[1] as usize]);
        if libm::sqrtf(a.self_cost * b.self_cost) >= self.strategy.queue_threshold {
            let volume = || overlap_volume(a, b, self.relation);
            let random = &mut self.workspace.run.random;
            let depth = depth / (a.size + b.size * self.relation.scale);
            let (bucket, first) = self.options.order.bucket(volume, depth, a.alpha * b.alpha, random);
            self.workspace.front.queue(pair, bucket, first);
        } else {
            self.workspace.front.push(pair);
        }
    }
}

impl Sink for Traversal<'_, '_> {
    #[inline(always)]
    fn count(&mut self, level: usize, bv_tests: u32) {
        let stats = &mut self.workspace.run.stats;
        stats.bv_tests_per_level[level.min(LEVELS - 1)] += u64::from(bv_tests);
        stats.work += WORK_PER_EXPANSION + u64::from(bv_tests);
    }

    #[inline(always)]
    fn depths(&mut self) -> &mut Depths {
        &mut self.depths
    }

    /// Pairs go where their parent came from: on the stack, into the queue, or on the paths to witnesses, and what is beside
    /// these into the queue.
    #[inline(always)]
    fn pairs(&mut self, mut hits: u64, child: impl Fn(u32) -> Pair) {
        if self.origin != Origin::Stack {
            return self.queue_all(hits, child);
        }
        if hits == 0 {
            return;
        }
        let (mut deepest, mut at) = (f32::NEG_INFINITY, 0);
        while hits != 0 {
            let bit = hits.trailing_zeros();
            hits &= hits - 1;
            let place = self.workspace.front.push(child(bit));
            let depth = self.depths.as_flattened()[bit as usize % 64];
            if self.strategy.deepest_first && depth > deepest {
                (deepest, at) = (depth, place);
            }
        }
        if self.strategy.deepest_first {
            self.workspace.front.raise(at);
        }
    }

    #[inline(always)]
    fn cluster(&mut self, pair: Pair) {
        self.workspace.front.push(pair);
    }

    #[inline(always)]
    fn triangles(&mut self, hits: u64, first: [u32; 2]) {
        self.workspace.waiting.push_all(hits, first);
    }
}

/// The positions of the bits of `mask`, lowest first.
#[inline(always)]
pub(super) fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < 32).then_some(bit)
    })
}
