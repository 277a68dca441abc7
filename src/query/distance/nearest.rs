//! Distance of two surfaces: how the traversal handles node pairs and triangle pairs.
//!
//! Pairs whose boxes overlap are finished depth-first, the deepest first: as long as there are any,
//! no lower bound is proven. Separated pairs wait in the queue, ordered by their lower bounds, and
//! are dropped when they no longer matter. The search starts with a *dive*, which opens only the
//! child that seems closest, down to two triangles. It gives an upper bound to compare with, and
//! leaves no other trace.
//!
//! [Contacts](crate::query::contacts) are the distance question with a limit and without an
//! interval that narrows: each pair within the limit goes to a list. The tests of triangle pairs
//! are in [`closest_pairs`](super::closest_pairs).

use super::gaps::{Direction, Gaps};
use super::interval::Interval;
use super::lone::Lone;
use super::search::{Bounded, DIVE, Search, Waiting, root};
use crate::engine::boxes::RelativePose;
use crate::engine::expand::{Keys, LeafRows, Scratch, Sink, expand, key_of, node};
use crate::engine::frontier::{Origin, Pair};
use crate::engine::outcome::{Stats, StopReason};
use crate::engine::traversal::{Traversal, Visitor};
use crate::model::cost::{MAX_STEP_WORK, WORK_PER_LOOKUP, WORK_PER_RAY_NODE};
use crate::tree::{Tree, WIDTH};
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Lanes};

/// The question of the distance of two surfaces.
pub(crate) struct Nearness {
    /// Pairs at this squared distance or more, in A's units, are dropped. Not less than the cut of
    /// the interval.
    pub(crate) cut: f32,
    /// [`Gaps::doubt`].
    doubt: f32,
    /// Direction from A to B between the closest triangles found: [`Gaps::direction`].
    direction: Direction,
    /// The least key of a child seen by the dive.
    guess: f32,
    /// All node pairs go on one stack.
    pub(super) depth_first: bool,
    /// The body that is one point or segment.
    pub(super) lone: Option<Lone>,
}

/// Maximum number of nodes opened beside a lone body in one step.
const NODES_PER_STEP: u32 = 6;

const _: () = assert!(NODES_PER_STEP as u64 * WORK_PER_RAY_NODE <= MAX_STEP_WORK);

impl Nearness {
    pub fn new(relative: &RelativePose, interval: &Interval) -> Self {
        // At first the direction between the middles.
        let direction = Direction::new(relative.middle().normalize_or_zero());
        let mut distance = Self {
            cut: 0.0,
            doubt: 0.0,
            direction,
            guess: f32::INFINITY,
            depth_first: false,
            lone: None,
        };
        distance.update(relative, interval);
        distance
    }

    /// Searches beside a lone body, if one of the trees is one.
    pub fn beside(
        mut self,
        trees: [&Tree; 2],
        relative: &RelativePose,
        search: &mut Search,
    ) -> Self {
        self.lone = Lone::of(trees, relative);
        if let Some(lone) = &self.lone {
            search.beside(lone.is_a);
            self.update(relative, &search.interval);
        }
        self
    }

    /// Updates the cut and the direction after a change of the interval.
    pub(crate) fn update(&mut self, relative: &RelativePose, interval: &Interval) {
        self.cut = interval.square_cut(relative.unit);
        self.doubt = root(self.cut) + relative.least_gap_and_margin();
        if let Some((_, found)) = interval.nearest() {
            self.direction = Direction::new(-found.direction);
            if let Some(lone) = &mut self.lone {
                lone.turn(relative, -found.direction);
            }
        }
    }
}

impl<const POINTS: bool> Visitor for Traversal<'_, '_, Nearness, POINTS> {
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        let workspace = &*self.workspace;
        let is_due = workspace.state.distance.halves.is_due(workspace.work());
        if is_due && !workspace.frontier.is_empty() {
            self.look_for_plane();
        }
        let search = &mut self.workspace.state.distance;
        if self.question.lone.is_some() {
            let frontier = &mut self.workspace.frontier;
            let next = match search.interval.nearest() {
                // The first nodes are those above the first upper bound.
                None => frontier.pop_stack(),
                Some(_) => frontier.pop_least(self.question.cut, &mut search.dropped),
            };
            return Some((next?, Origin::Beside));
        }
        match search.dive.take() {
            Some(pair) => Some((pair, Origin::Dive)),
            None => self.workspace.frontier.pop(),
        }
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair, scratch: &mut Scratch) {
        let (question, relative) = (&self.question, self.relative);
        let mut gaps =
            Gaps::<true>::new(question.cut, question.doubt, relative, question.direction);
        match self.origin {
            Origin::Dive => {
                self.question.guess = f32::INFINITY;
                (gaps.cut, gaps.swell) = (f32::INFINITY, DIVE);
            }
            Origin::Queue => {
                gaps.least = self.workspace.frontier.popped_key();
                if gaps.least >= gaps.cut {
                    self.workspace.run.stats.work += WORK_PER_LOOKUP;
                    let dropped = &mut self.workspace.state.distance.dropped;
                    *dropped = dropped.min(gaps.least);
                    return;
                }
                // A pair that the full queue puts on the stack loses its bound.
                if self.workspace.frontier.room() < WIDTH * WIDTH {
                    self.workspace.bound(root(gaps.least), relative.unit);
                }
            }
            Origin::Beside => return self.open_beside(lanes, pair),
            Origin::Stack | Origin::Path => {}
        }
        let trees = [self.a, self.b];
        expand::<POINTS, _, _>(lanes, pair, trees, relative, &mut gaps, scratch, self);
        let search = &mut self.workspace.state.distance;
        if self.origin != Origin::Dive {
            // Every child that was dropped is at least as far apart as the cut.
            search.interval.pass_rest();
        } else if search.dive.is_none() {
            search.is_diving = false;
        }
    }

    #[inline(always)]
    fn waits(&self, any: bool) -> bool {
        let search = &self.workspace.state.distance;
        search.is_due() || any && !search.is_done()
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason> {
        if self.workspace.state.contacts.margin().is_some() && self.is_full() {
            return Some(StopReason::PairsFull);
        }
        let search = &mut self.workspace.state.distance;
        if let Some(proposed) = search.proposed.pop() {
            self.consider(proposed);
        } else if !search.waiting.is_empty() {
            self.test_batch(lanes);
        } else if let Some(left) = search.put_off.pop() {
            self.consider(left);
        }
        let search = &self.workspace.state.distance;
        let last = self.workspace.frontier.is_empty();
        self.workspace.testing = search.is_due() || last && !search.is_done();
        search.interval.is_decided().then_some(StopReason::Finished)
    }
}

impl<const POINTS: bool> Sink for Traversal<'_, '_, Nearness, POINTS> {
    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        &mut self.workspace.run.stats
    }

    #[inline(always)]
    fn pairs(&mut self, hits: u64, keys: &Keys, child: impl Fn(u32) -> Pair) {
        let key = |bit| key_of(keys, bit);
        let mut deepest = (0.0, None);
        let last = if self.question.depth_first {
            closest(hits, key)
        } else {
            0
        };
        for hits in [hits & !last, last] {
            for bit in bits(hits) {
                self.keep(child(bit as u32), key(bit), &mut deepest);
            }
        }
        if let Some(at) = deepest.1 {
            self.workspace.frontier.raise(at);
        }
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, key: impl FnOnce() -> f32) {
        self.keep(pair, key(), &mut (0.0, None));
    }

    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &mut self,
        _: L,
        hits: u64,
        key: impl Fn(usize) -> f32,
        first: [u32; 2],
        _: impl FnOnce() -> LeafRows<'t>,
    ) {
        let search = &mut self.workspace.state.distance;
        search.wait(hits, first, key);
        if search.is_diving {
            // One pair is enough for a guess, which proves nothing; all pairs are visited again.
            let likely = search.waiting.iter().min_by(|x, y| x.key.total_cmp(&y.key));
            let likely = likely.map(|likely| Bounded::unknown(likely.pair));
            search.proposed.extend(likely);
            search.waiting.clear();
        }
    }
}

impl<const POINTS: bool> Traversal<'_, '_, Nearness, POINTS> {
    /// Opens a node of the other tree beside a lone body ([`Pair::keyed`]), then its closest child,
    /// and so on; the other children go on the stack, the closest on top.
    #[inline(always)]
    fn open_beside<L: Lanes>(&mut self, lanes: L, mut pair: Pair) {
        let Some(lone) = &self.question.lone else {
            return;
        };
        let tree = if lone.is_a { self.b } else { self.a };
        let cut = self.question.cut;
        for _ in 0..NODES_PER_STEP {
            let workspace = &mut *self.workspace;
            let search = &mut workspace.state.distance;
            if pair.key() >= cut {
                workspace.run.stats.work += WORK_PER_LOOKUP;
                search.dropped = search.dropped.min(pair.key());
                return;
            }
            let mut leaf = None;
            let (node, _) = node::<POINTS, L>(lanes, tree, pair.nodes[0], &mut leaf);
            let (near, order) = lone.keys(lanes, node);
            let near = near.max(F8::splat(lanes, pair.key()));
            let hits = near.less(F8::splat(lanes, cut)).mask() & node.valid();
            let (keys, order) = (near.store(), order.store());
            workspace.run.stats.bv_tests += u64::from(node.children);
            workspace.run.stats.work += WORK_PER_RAY_NODE;
            // Every child that was dropped is at least as far apart as the cut.
            search.interval.pass_rest();
            if hits == 0 {
                return;
            }
            let first = node.first_child;
            let likeliest = likeliest(hits, &order);
            if !node.is_leaf {
                let child = |i: usize| Pair::keyed(first + i as u32, keys[i % WIDTH]);
                for i in bits(hits & !(1 << likeliest)) {
                    workspace.frontier.push(child(i));
                }
                pair = child(likeliest);
                continue;
            }
            // The test of a point in `f64` takes no longer than that in `f32`. Without an upper
            // bound, one pair gives the others a cut.
            let is_contacts = workspace.state.contacts.margin().is_some();
            let search = &mut workspace.state.distance;
            let all = lone.is_point && !is_contacts;
            let one = all || !is_contacts && search.interval.nearest().is_none();
            let low = near.max(F8::splat(lanes, 0.0)).sqrt();
            let low = (low * F8::splat(lanes, 1.0 - f32::EPSILON)).store();
            let mut wait = |i: usize, is_proposed: bool| {
                let (other, at) = (first + i as u32, i % WIDTH);
                let pair = if lone.is_a { [0, other] } else { [other, 0] };
                if is_proposed {
                    let low = low[at];
                    search.proposed.push(Bounded { pair, low });
                } else {
                    let key = keys[at];
                    search.waiting.push(Waiting { pair, key });
                }
            };
            bits(hits & !(1 << likeliest)).for_each(|i| wait(i, all));
            wait(likeliest, one);
            return;
        }
        self.workspace.frontier.push(pair);
    }

    /// Keeps a child for later. `deepest` is the key and place on the stack of the deepest of its
    /// siblings.
    #[inline(always)]
    fn keep(&mut self, pair: Pair, key: f32, deepest: &mut (f32, Option<usize>)) {
        let workspace = &mut *self.workspace;
        if self.origin == Origin::Dive {
            if key < self.question.guess {
                self.question.guess = key;
                workspace.state.distance.dive = Some(pair);
            }
        } else if key > 0.0 || self.question.depth_first {
            let search = &mut workspace.state.distance;
            let bucket = if self.question.depth_first {
                0
            } else {
                search.bucket(key, self.question.cut)
            };
            workspace.frontier.queue(pair, key, bucket);
        } else {
            let at = workspace.frontier.push(pair);
            if key < deepest.0 {
                *deepest = (key, Some(at));
            }
        }
    }

    /// Continues the pass over all vertices. If it decides the question, drops everything left.
    #[cold]
    #[inline(never)]
    fn look_for_plane(&mut self) {
        let work = self.workspace.work();
        let search = &mut self.workspace.state.distance;
        let nearest = search.interval.nearest();
        let towards = || nearest.map_or(DVec3::ZERO, |(_, found)| -found.direction);
        let trees = [self.a, self.b];
        let (taken, gap) = search.halves.look(trees, self.b_in_a, towards, work);
        self.workspace.run.stats.work += taken;
        self.deadline.allow_for_long_step();
        if let Some(gap) = gap
            && self.workspace.state.distance.interval.know(gap)
        {
            self.workspace.frontier.drop_all();
            self.workspace.state.distance.drop_all();
        }
    }
}

/// The bit of a mask, which is not 0, with the least entry of `order`.
#[inline(always)]
fn likeliest(mut hits: u32, order: &[f32; WIDTH]) -> usize {
    let mut found = hits.trailing_zeros() as usize % WIDTH;
    while hits != 0 {
        let i = hits.trailing_zeros() as usize % WIDTH;
        hits &= hits - 1;
        // A select, not a branch, because the comparison is unpredictable.
        found = if order[i] < order[found] { i } else { found };
    }
    found
}

/// The bit with the least key, as a mask.
#[inline(never)]
fn closest(hits: u64, key: impl Fn(usize) -> f32) -> u64 {
    let closest = bits(hits).min_by(|&i, &j| key(i).total_cmp(&key(j)));
    closest.map_or(0, |bit| 1 << bit)
}
