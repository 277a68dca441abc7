//! Intersection of two surfaces: how the traversal handles node pairs. [`leaf`](super::leaf) has
//! its triangle tests.
//!
//! Overlapping boxes are of interest, deepest first. Triangle pairs found along a curve
//! ([`trace`](super::trace)) before the frontier reaches them are not tested again.

use crate::engine::boxes::overlap::Overlap;
use crate::engine::expand::{Keys, LeafRows, MadeLeaf, Scratch, Sink, expand, key_of, node};
use crate::engine::frontier::order::Order;
use crate::engine::frontier::{Origin, Pair};
use crate::engine::options::{Mode, Options};
use crate::engine::outcome::{Stats, StopReason};
use crate::engine::strategy::Tracing;
use crate::engine::traversal::{Traversal, Visitor};
use crate::engine::triangles::push_all;
use crate::engine::workspace::Workspace;
use crate::model::cost::WORK_PER_LOOKUP;
use crate::tree::{Node, Tree, WIDTH};
use punctual_geom::bits;
use punctual_geom::lanes::{Lanes, Portable};

/// The question whether, or where, two surfaces intersect.
pub(crate) struct Meeting<'q> {
    pub options: &'q Options,
}

impl<const POINTS: bool> Visitor for Traversal<'_, '_, Meeting<'_>, POINTS> {
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        self.workspace.frontier.pop()
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair, scratch: &mut Scratch) {
        let (trees, relative) = ([self.a, self.b], self.relative);
        if let Some(order) = self.strategy.queue
            && self.origin != Origin::Stack
        {
            let made = &mut [None, None];
            self.share = order.share(nodes::<POINTS>(trees, pair, made), relative);
        }
        expand::<POINTS, _, _>(
            lanes,
            pair,
            trees,
            relative,
            &mut Overlap::default(),
            scratch,
            self,
        );
    }

    #[inline(always)]
    fn waits(&self, any: bool) -> bool {
        let enough = if any { 1 } else { self.strategy.batch };
        self.workspace.waiting.len() >= enough
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason> {
        if self.room() == 0 {
            return Some(StopReason::PairsFull);
        }
        self.end_trace();
        if self.workspace.state.intersection.trace.is_due() {
            self.trace_on(lanes);
        } else {
            self.test_triangles(lanes);
        }
        self.workspace.testing = self.goes_on_testing();
        self.has_enough()
    }
}

impl<const POINTS: bool> Traversal<'_, '_, Meeting<'_>, POINTS> {
    /// Ends a run of [`Mode::Any`] at the first hit.
    #[inline(always)]
    fn has_enough(&self) -> Option<StopReason> {
        let is_enough =
            self.workspace.run.stats.found > 0 && self.question.options.mode == Mode::Any;
        is_enough.then_some(StopReason::FirstHit)
    }

    /// Of the children of a pair on a path, puts those that contain witnesses on the paths. Returns
    /// the others.
    #[cold]
    #[inline(never)]
    fn follow_paths(&mut self, hits: u64, child: impl Fn(u32) -> Pair) -> u64 {
        let mut ahead = self.workspace.frontier.path_witnesses();
        bits(hits).fold(hits, |rest, bit| {
            let pair = child(bit as u32);
            let below = self.witnesses_below(pair, ahead);
            ahead &= !below;
            let follows = self.workspace.frontier.follow(pair, below);
            rest & !(u64::from(follows) << bit)
        })
    }

    /// Puts the children of a pair of the queue or of a path where they belong.
    #[inline(always)]
    fn queue_all(&mut self, mut hits: u64, keys: &Keys, child: impl Fn(u32) -> Pair) {
        let is_path = self.origin == Origin::Path;
        if is_path {
            hits = self.follow_paths(hits, &child);
        }
        if self.strategy.queue.is_some() {
            let frontier = &mut self.workspace.frontier;
            frontier.rank_all(hits, keys, self.share, child);
        } else {
            self.workspace.frontier.push_all(hits, child);
        }
        if is_path {
            self.workspace.frontier.set_aside();
        }
    }

    /// The keys of the pairs of `hits` by their alphas.
    #[cold]
    fn alphas(&self, hits: u64, child: impl Fn(u32) -> Pair) -> Keys {
        let mut keys = Keys::default();
        for bit in bits(hits) {
            let pair = child(bit as u32);
            let made = &mut [None, None];
            let nodes = nodes::<POINTS>([self.a, self.b], pair, made);
            keys.as_flattened_mut()[bit] = Order::low_alpha(nodes);
        }
        keys
    }

    /// Stops curve tracing once the traversal has done its share of the work.
    #[inline(always)]
    fn end_trace(&mut self) {
        let Workspace {
            run,
            frontier,
            state,
            ..
        } = &*self.workspace;
        if let Tracing::Within(work_per_pair) = self.strategy.trace
            && run.stats.found > 0
            && run.stats.work - state.intersection.trace.work
                > work_per_pair * frontier.len() as u64
        {
            self.workspace.state.intersection.trace.stop();
            self.strategy.trace = Tracing::Over;
            self.workspace.run.strategy = self.strategy;
            self.workspace.drop_known([self.a, self.b]);
        }
    }

    /// Pushes pairs so that the one with the largest key is on top and the second below it.
    #[inline(never)]
    fn push_ranked(&mut self, hits: u64, keys: &Keys, child: impl Fn(u32) -> Pair) {
        // The key, with the index of the pair in its last bits. A select, not a branch, because
        // the comparison is unpredictable.
        let (mut first, mut second) = (0, 0);
        for bit in bits(hits) {
            let key = key_of(keys, bit).to_bits() & !63 | bit as u32;
            second = second.max(first.min(key));
            first = first.max(key);
        }
        let (first, second) = (first % 64, second % 64);
        let frontier = &mut self.workspace.frontier;
        let rest = hits & !(1 << first);
        if rest != 0 {
            frontier.push_all(rest & !(1 << second), &child);
            frontier.push(child(second));
        }
        frontier.push(child(first));
    }

    /// The witnesses of the previous frame, out of `among`, that lie below a pair.
    #[inline(always)]
    fn witnesses_below(&self, pair: Pair, among: u16) -> u16 {
        let made = &mut [None, None];
        let [a, b] = nodes::<POINTS>([self.a, self.b], pair, made);
        bits(among).fold(0, |below, i| {
            let [x, y] =
                self.workspace.state.intersection.witnesses[i].map(|triangle| triangle as usize);
            let leads = a.triangle_range().contains(&x) && b.triangle_range().contains(&y);
            below | u16::from(leads) << i
        })
    }
}

/// The nodes of a pair. Leaves of clouds are made in `made`.
#[inline(always)]
fn nodes<'t, const POINTS: bool>(
    [a, b]: [&'t Tree; 2],
    pair: Pair,
    [of_a, of_b]: &'t mut [MadeLeaf; 2],
) -> [&'t Node; 2] {
    let ([i, j], lanes) = (pair.nodes, Portable {});
    let (a, _) = node::<POINTS, _>(lanes, a, i, of_a);
    let (b, _) = node::<POINTS, _>(lanes, b, j, of_b);
    [a, b]
}

impl<const POINTS: bool> Sink for Traversal<'_, '_, Meeting<'_>, POINTS> {
    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        &mut self.workspace.run.stats
    }

    /// Pairs go where their parent came from: on the stack, or into the queue. Children of a pair
    /// on a path go on the paths if they contain witnesses, else into the queue.
    #[inline(always)]
    fn pairs(&mut self, mut hits: u64, keys: &Keys, child: impl Fn(u32) -> Pair) {
        let alphas;
        let keys = if self.strategy.queue == Some(Order::LowAlpha) {
            alphas = self.alphas(hits, &child);
            &alphas
        } else {
            keys
        };
        if self.origin != Origin::Stack {
            return self.queue_all(hits, keys, child);
        }
        if !self.strategy.deepest_first {
            return self.workspace.frontier.push_all(hits, child);
        }
        if hits == 0 {
            return;
        }
        if self.strategy.ranks() {
            return self.push_ranked(hits, keys, child);
        }
        let depth = |bit| key_of(keys, bit);
        let frontier = &mut self.workspace.frontier;
        let (mut bit, mut place) = (
            hits.trailing_zeros(),
            frontier.push(child(hits.trailing_zeros())),
        );
        let (mut deepest, mut first, mut at) = (depth(bit as usize), bit, place);
        hits &= hits - 1;
        while hits != 0 {
            bit = hits.trailing_zeros();
            hits &= hits - 1;
            place = frontier.push(child(bit));
            let next = depth(bit as usize);
            // A select, not a branch, because the comparison is unpredictable.
            let is_deeper = next > deepest;
            deepest = if is_deeper { next } else { deepest };
            (first, at) = if is_deeper { (bit, place) } else { (first, at) };
        }
        // Swaps the deepest with the last one. Both are made anew, because loading what has just
        // been stored takes longer.
        frontier.put(at, child(bit));
        frontier.put(place, child(first));
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, _depth: impl FnOnce() -> f32) {
        self.workspace.frontier.push(pair);
    }

    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &mut self,
        _: L,
        mut hits: u64,
        depth: impl Fn(usize) -> f32,
        first: [u32; 2],
        _: impl FnOnce() -> LeafRows<'t>,
    ) {
        if self.strategy.trace != Tracing::Never
            && hits != 0
            && !self.workspace.state.intersection.trace.known.is_empty()
        {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            hits = self.workspace.state.intersection.trace.pass(hits, first);
        }
        if self.strategy.ranks() && hits.count_ones() as usize > WIDTH {
            let deeper = deeper(hits, depth);
            push_all(&mut self.workspace.waiting, hits & !deeper, first);
            hits = deeper;
        }
        push_all(&mut self.workspace.waiting, hits, first);
    }
}

/// The pairs of `hits` that are deeper than their mean.
#[inline(never)]
fn deeper(hits: u64, depth: impl Fn(usize) -> f32) -> u64 {
    let mean = bits(hits).map(&depth).sum::<f32>() / hits.count_ones() as f32;
    bits(hits).fold(0, |deeper, bit| {
        deeper | u64::from(depth(bit) > mean) << bit
    })
}
