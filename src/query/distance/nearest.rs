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
use super::search::{Bounded, DIVE, root};
use crate::engine::boxes::RelativePose;
use crate::engine::expand::{Keys, LeafRows, Scratch, Sink, expand, key_of};
use crate::engine::frontier::{Origin, Pair};
use crate::engine::outcome::{Stats, StopReason};
use crate::engine::traversal::{Traversal, Visitor};
use crate::model::cost::WORK_PER_LOOKUP;
use crate::tree::WIDTH;
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::Lanes;

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
}

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
        };
        distance.update(relative, interval);
        distance
    }

    /// Updates the cut and the direction after a change of the interval.
    pub(crate) fn update(&mut self, relative: &RelativePose, interval: &Interval) {
        self.cut = interval.square_cut(relative.unit);
        self.doubt = root(self.cut) + relative.least_gap_and_margin();
        if let Some((_, found)) = interval.nearest() {
            self.direction = Direction::new(-found.direction);
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

/// The bit of the least key, as a mask.
#[inline(never)]
fn closest(hits: u64, key: impl Fn(usize) -> f32) -> u64 {
    let closest = bits(hits).min_by(|&i, &j| key(i).total_cmp(&key(j)));
    closest.map_or(0, |bit| 1 << bit)
}
