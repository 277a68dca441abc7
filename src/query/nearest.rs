//! How far apart are two surfaces? What a traversal that asks this does with node pairs and triangle pairs.
//!
//! Pairs whose boxes overlap are finished depth-first, the deepest first: as long as there are any, nothing is proven. Pairs
//! that are apart wait in the queue by their lower bounds, and are dropped when they can't matter any more. To begin with,
//! a *dive* opens nothing but the child that seems to be closest, down to two triangles, so that there is an upper bound to
//! compare with; it leaves no trace.
//!
//! Triangles go through two tests: eight pairs at a time in `f32` for lower bounds, and one pair at a time in `f64`, for
//! those that may be closer than the closest so far, by the features that `f32` has found closest. Those that may only raise
//! the lower bound are put off to the end. Of many pairs of two clusters the closest are tested, and the cluster pair is put
//! back with the others.
//!
//! Contacts ([`super::contacts`]) are the same question with a limit and without an interval that closes in: each pair within
//! the limit goes to a list, and those that are apart are looked at in `f64` four at a time. So are certificates that are
//! narrowed ([`super::narrow`]), of which the list has the triangles only.

use super::boxes::Keys;
use super::expand::{Sink, expand};
use super::gaps::{Direction, Gaps};
use super::interval::Interval;
use super::outcome::{LEVELS, Stats, StopReason};
use super::queue::{Origin, Pair};
use super::search::{Bounded, DIVE, TOGETHER, least_key, root};
use super::traversal::{Question, Traversal};
use super::triangle_pairs::rows;
use super::views::Relation;
use super::workspace::Workspace;
use crate::contact::Contact;
use crate::math::bits;
use crate::math::lanes::{Column, F8, Lanes};
use crate::model::cost::{
    WORK_PER_CLOSEST_POINTS, WORK_PER_CONTACT, WORK_PER_DISTANCE_TEST, WORK_PER_EXACT_TEST, WORK_PER_EXPANSION,
    WORK_PER_FEATURES, WORK_PER_FEATURES_ALONE, WORK_PER_LOOKUP, WORK_PER_SEGMENT,
};
use crate::tree::WIDTH;
use crate::triangle::distance::{Chosen, Distances, Four, closest, distances};
use crate::triangle::triangles_intersect;
use arrayvec::ArrayVec;
use glam::DVec3;

/// Triangle pairs of two clusters that are not all tested at once.
const MANY: u32 = 16;

/// How far apart two surfaces are.
pub(super) struct Distance {
    /// Squared distance, in A's units, from which on nothing matters: not less than that of the interval.
    cut: f32,
    /// [`Gaps::doubt`].
    doubt: f32,
    /// From A to B, where the closest triangles found are: [`Gaps::direction`].
    direction: Direction,
    /// The least key of children met by a dive.
    guess: f32,
    /// The node pair that is being opened.
    pair: Pair,
}

impl Distance {
    pub fn new(relation: &Relation, interval: &Interval) -> Self {
        // To begin with, that of the middles.
        let direction = Direction::new(relation.middle().normalize_or_zero(), relation);
        let pair = Pair::new(0, 0);
        let mut distance = Self { cut: 0.0, doubt: 0.0, direction, guess: f32::INFINITY, pair };
        distance.update(relation, interval);
        distance
    }

    /// After a change of the interval.
    fn update(&mut self, relation: &Relation, interval: &Interval) {
        self.cut = interval.square_cut(relation.unit);
        self.doubt = root(self.cut) + relation.least_gap_and_margin();
        if let Some((_, found)) = interval.nearest() {
            self.direction = Direction::new(-found.direction, relation);
        }
    }
}

impl Question for Traversal<'_, '_, Distance> {
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        let search = &mut self.workspace.search;
        match search.dive.take() {
            Some(pair) => Some((pair, Origin::Path)),
            None => self.workspace.front.pop(),
        }
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair) {
        let Distance { cut, doubt, direction, .. } = self.question;
        let mut gaps = Gaps::new(cut, doubt, self.relation.shrink, direction);
        match self.origin {
            Origin::Path => {
                self.question.guess = f32::INFINITY;
                (gaps.cut, gaps.swell) = (f32::INFINITY, DIVE);
            }
            Origin::Queue => {
                gaps.least = self.workspace.front.popped_key();
                if gaps.least >= gaps.cut {
                    self.workspace.run.stats.work += WORK_PER_LOOKUP;
                    let dropped = &mut self.workspace.search.dropped;
                    *dropped = dropped.min(gaps.least);
                    return;
                }
                // What goes on the stack for lack of room has no bound any more.
                if self.workspace.front.room() < WIDTH * WIDTH {
                    let workspace = &mut *self.workspace;
                    workspace.search.bound(&workspace.front, root(gaps.least), self.relation.unit);
                }
            }
            Origin::Stack => {}
        }
        self.question.pair = pair;
        expand(lanes, pair, [self.a, self.b], self.relation, &mut gaps, self);
        let search = &mut self.workspace.search;
        if self.origin != Origin::Path {
            // Whatever was not kept of its children is at least as far apart.
            search.interval.pass_rest();
        } else if search.dive.is_none() {
            search.is_diving = false;
        }
    }

    #[inline(always)]
    fn waits(&self, any: bool) -> bool {
        let search = &self.workspace.search;
        search.is_due() || any && !search.is_done()
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason> {
        if self.workspace.contacts.margin().is_some() && self.is_full() {
            return Some(StopReason::PairsFull);
        }
        let search = &mut self.workspace.search;
        if let Some(proposed) = search.proposed.pop() {
            self.consider(lanes, proposed);
        } else if search.is_linked() {
            self.test_linked(lanes);
        } else if !search.waiting.is_empty() {
            self.test_batch(lanes);
        } else if let Some(left) = search.put_off.pop() {
            self.consider(lanes, left);
        }
        let search = &self.workspace.search;
        let last = self.workspace.front.is_empty();
        self.workspace.testing = search.is_due() || last && !search.is_done();
        search.interval.is_decided().then_some(StopReason::Finished)
    }
}

impl Traversal<'_, '_, Distance> {
    /// Whether there may be no room for what the next step finds.
    #[cold]
    #[inline(never)]
    fn is_full(&self) -> bool {
        let Workspace { contacts, found, search, .. } = &*self.workspace;
        if self.strategy.largest_first {
            found.len() == found.capacity()
        } else {
            contacts.is_full() && !(search.proposed.is_empty() && search.linked.is_empty())
        }
    }

    /// Lower bounds of up to eight waiting pairs.
    #[inline(always)]
    fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let search = &mut self.workspace.search;
        let mut dropped = search.dropped;
        let (pairs, keys, count) = search.pop_batch(self.question.cut, |low| dropped = dropped.min(low));
        search.dropped = dropped;
        if count == 0 {
            return;
        }
        let found = distances(lanes, rows(self.a, pairs, 0), rows(self.b, pairs, 1), &self.relation.triangles);
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += count as u64;
        stats.work += count as u64 * WORK_PER_DISTANCE_TEST;
        // Boxes may have proven more: what is proven stays so.
        let proven = F8::load(lanes, &keys).max(F8::splat(lanes, 0.0)).sqrt() * F8::splat(lanes, 1.0 - f32::EPSILON);
        let low = F8::load(lanes, &found.low).max(proven);
        if self.workspace.contacts.margin().is_some() && !self.strategy.largest_first {
            let meet = !F8::splat(lanes, 0.0).less(low).mask();
            // More than the root, which is rounded.
            let cut = F8::splat(lanes, self.question.cut).sqrt() * F8::splat(lanes, 1.0 + 4.0 * f32::EPSILON);
            let near = (low.less(cut).mask() | meet) & ((1 << count) - 1);
            self.link(&pairs, &low.store(), near, meet, &found.closest);
        } else {
            self.propose(&pairs[..count], &low.store(), &found);
        }
    }

    /// Pairs that may be within the margin wait for their closest points, those that may meet for an exact test.
    #[inline(never)]
    fn link(&mut self, pairs: &[[u32; 2]; WIDTH], low: &[f32; WIDTH], near: u32, meet: u32, chosen: &Chosen) {
        let search = &mut self.workspace.search;
        search.interval.pass_rest();
        for i in bits(near) {
            let i = i % WIDTH;
            let bounded = Bounded { pair: pairs[i], low: low[i], closest: chosen.of(i) };
            if meet >> i & 1 == 0 {
                search.linked.push(bounded);
            } else {
                search.proposed.push(bounded);
            }
        }
    }

    /// Closest points of a few linked pairs, as far as there is room for the contacts.
    #[inline(never)]
    fn test_linked<L: Lanes>(&mut self, lanes: L) {
        let Workspace { search, contacts, corners: [of_a, of_b], run, .. } = &mut *self.workspace;
        let count = search.linked.len().min(TOGETHER).min(contacts.room());
        let linked = &search.linked[search.linked.len() - count..];
        let mut four = Four::NONE;
        for (i, Bounded { pair, closest, .. }) in linked.iter().enumerate() {
            let a = of_a.of(self.a, pair[0], |v| v);
            let b = of_b.of(self.b, pair[1], |v| self.b_in_a.transform_point(v));
            four.set(i, *closest, [a, b]);
        }
        let found = lanes.run(&four);
        run.stats.work += count as u64 * WORK_PER_FEATURES;
        let margin = contacts.margin().unwrap_or(0.0);
        for (i, bounded) in linked.iter().enumerate() {
            let Some(found) = found.of(i) else {
                search.proposed.push(*bounded);
                continue;
            };
            if found.low.max(f64::from(bounded.low) * self.relation.unit) <= margin {
                let ids = [self.a.ids()[bounded.pair[0] as usize], self.b.ids()[bounded.pair[1] as usize]];
                contacts.push(Contact::parted(ids, &found));
                run.stats.work += WORK_PER_CONTACT;
                run.found += 1;
            }
        }
        search.linked.truncate(search.linked.len() - count);
        self.deadline.allow_for_long_step();
    }

    /// What may be closest is looked at next, the most likely first; what may only bound the distance is put off.
    #[inline(never)]
    fn propose(&mut self, pairs: &[[u32; 2]], low: &[f32; WIDTH], found: &Distances) {
        let search = &mut self.workspace.search;
        let closer = (search.interval.high() / self.relation.unit) as f32 * (1.0 - 4.0 * f32::EPSILON);
        let mut order = ArrayVec::<usize, WIDTH>::new();
        for (i, &low) in low.iter().enumerate().take(pairs.len()) {
            let bound = f64::from(low) * self.relation.unit;
            if search.interval.matters(bound) {
                order.push(i);
            } else {
                search.interval.pass(bound);
            }
        }
        // Whatever the sign of what is no number.
        let about = found.about.map(|about| if about < f32::INFINITY { about } else { f32::INFINITY });
        order.sort_unstable_by(|&i, &j| about[j].total_cmp(&about[i]).then(j.cmp(&i)));
        for i in order {
            let proposed = Bounded { pair: pairs[i], low: low[i], closest: found.closest.of(i) };
            if low[i] > 0.0 && about[i] > closer && !search.put_off.is_full() {
                search.put_off.push(proposed);
            } else {
                search.proposed.push(proposed);
            }
        }
    }

    /// Looks at a pair in `f64`, unless it does not matter any more.
    #[inline(never)]
    fn consider<L: Lanes>(&mut self, lanes: L, Bounded { pair, low, closest: features }: Bounded) {
        let workspace = &mut *self.workspace;
        let interval = &mut workspace.search.interval;
        let is_settled = interval.nearest().is_some_and(|(nearest, _)| nearest == pair);
        let stats = &mut workspace.run.stats;
        let proven = f64::from(low) * self.relation.unit;
        if is_settled || !interval.matters(proven) {
            stats.work += WORK_PER_LOOKUP;
            if !is_settled {
                interval.pass(proven);
            }
            return;
        }
        let [of_a, of_b] = &mut workspace.corners;
        let a = of_a.of(self.a, pair[0], |v| v);
        let b = of_b.of(self.b, pair[1], |v| self.b_in_a.transform_point(v));
        self.deadline.allow_for_long_step();
        if let Some(margin) = workspace.contacts.margin() {
            let ids = [self.a.ids()[pair[0] as usize], self.b.ids()[pair[1] as usize]];
            if self.strategy.largest_first {
                stats.work += WORK_PER_CLOSEST_POINTS;
                if closest(a, b).low.max(proven) <= margin {
                    workspace.found.push(ids);
                    workspace.run.found += 1;
                }
            } else if let Some(contact) = contact(ids, [a, b], proven, margin, stats) {
                workspace.contacts.push(contact);
                workspace.run.found += 1;
            }
            return;
        }
        let known = if proven > 0.0 {
            stats.work += WORK_PER_FEATURES_ALONE;
            lanes.run(&Four::one(features, [a, b])).of(0)
        } else {
            None
        };
        let mut found = known.unwrap_or_else(|| {
            stats.work += WORK_PER_CLOSEST_POINTS;
            closest(a, b)
        });
        found.low = found.low.max(proven);
        let meet = found.low == 0.0 && {
            stats.exact_tests += 1;
            stats.work += WORK_PER_EXACT_TEST;
            triangles_intersect(a, b)
        };
        workspace.search.interval.settle(pair, &found, meet);
        self.question.update(self.relation, &workspace.search.interval);
    }
}

/// What is known of two triangles that are at least `proven` apart, if that is within the margin.
fn contact(
    triangles: [u32; 2],
    corners: [&[DVec3; 3]; 2],
    proven: f64,
    margin: f64,
    stats: &mut Stats,
) -> Option<Contact> {
    if proven == 0.0 {
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST;
        let touching = Contact::touching(triangles, corners);
        stats.work += if touching.is_some() { WORK_PER_SEGMENT + WORK_PER_CONTACT } else { 0 };
        if touching.is_some() {
            return touching;
        }
    }
    let found = closest(corners[0], corners[1]);
    stats.work += WORK_PER_CLOSEST_POINTS;
    (found.low.max(proven) <= margin).then(|| {
        stats.work += WORK_PER_CONTACT;
        Contact::apart(triangles, corners, &found)
    })
}

impl Sink for Traversal<'_, '_, Distance> {
    #[inline(always)]
    fn count(&mut self, level: usize, bv_tests: u32) {
        let stats = &mut self.workspace.run.stats;
        stats.bv_tests_per_level[level.min(LEVELS - 1)] += u64::from(bv_tests);
        stats.work += WORK_PER_EXPANSION + 2 * u64::from(bv_tests);
    }

    #[inline(always)]
    fn spend(&mut self, work: u64) {
        self.workspace.run.stats.work += work;
    }

    #[inline(always)]
    fn keys(&mut self) -> &mut Keys {
        &mut self.keys
    }

    #[inline(always)]
    fn pairs(&mut self, hits: u64, child: impl Fn(u32) -> Pair) {
        if self.strategy.largest_first {
            return self.queue_all(hits, child);
        }
        let mut deepest = (0.0, None);
        let last = if self.strategy.deepest_first { self.closest(hits) } else { 0 };
        for mut hits in [hits & !last, last] {
            while hits != 0 {
                let bit = hits.trailing_zeros();
                hits &= hits - 1;
                let key = self.keys.as_flattened()[bit as usize % 64];
                self.place(child(bit), key, &mut deepest);
            }
        }
        if let Some(at) = deepest.1 {
            self.workspace.front.raise(at);
        }
    }

    #[inline(always)]
    fn cluster(&mut self, pair: Pair, column: usize) {
        let key = least_key(&self.keys, &pair, column);
        if self.strategy.largest_first {
            return self.queue_by_room(pair, key, root(self.question.cut));
        }
        self.place(pair, key, &mut (0.0, None));
    }

    #[inline(always)]
    fn triangles(&mut self, hits: u64, first: [u32; 2]) {
        let hits = if hits.count_ones() > MANY && self.puts_back() { self.put_back(hits) } else { hits };
        let search = &mut self.workspace.search;
        search.wait(hits, first, |bit| self.keys.as_flattened()[bit % 64]);
        if search.is_diving {
            // One is enough for a guess, which is no bound; all are met again.
            let likely = search.waiting.iter().min_by(|x, y| x.low.total_cmp(&y.low));
            search.proposed.extend(likely.map(|likely| Bounded { low: 0.0, ..*likely }));
            search.waiting.clear();
        }
    }
}

impl Traversal<'_, '_, Distance> {
    /// Queues pairs by room.
    #[cold]
    #[inline(never)]
    fn queue_all(&mut self, hits: u64, child: impl Fn(u32) -> Pair) {
        for bit in bits(hits) {
            let key = self.keys.as_flattened()[bit];
            self.queue_by_room(child(bit as u32), key, root(self.question.cut));
        }
    }

    /// Whether of many triangle pairs the closest are looked at first: where one distance is asked for, by the queue.
    #[inline(always)]
    fn puts_back(&self) -> bool {
        let is_alone = self.workspace.contacts.margin().is_none();
        is_alone && self.origin != Origin::Path && !self.strategy.deepest_first && !self.strategy.largest_first
    }

    /// Takes the rows with the closest boxes of these triangle pairs of two clusters, until they are eight pairs, and puts the
    /// cluster pair back with the other rows: most of these don't matter any more when it is their turn. Rows with boxes that
    /// overlap stay, since nothing is proven of them.
    #[inline(never)]
    fn put_back(&mut self, hits: u64) -> u64 {
        let row_of = |row: usize| hits & 0xff << (WIDTH * row);
        let least = |row| bits(row_of(row)).map(|bit| self.keys.as_flattened()[bit]).fold(f32::INFINITY, f32::min);
        let mut rows: [_; WIDTH] = core::array::from_fn(|row| (least(row), row));
        rows.sort_unstable_by(|(x, i), (y, j)| x.total_cmp(y).then(i.cmp(j)));
        let (mut taken, mut left) = (0_u64, None);
        let mut pair = Pair { alive: [0, self.question.pair.alive[1]], ..self.question.pair };
        for (key, row) in rows {
            if key <= 0.0 || taken.count_ones() < WIDTH as u32 {
                taken |= row_of(row);
            } else if row_of(row) != 0 {
                pair.alive[0] |= 1 << row;
                left.get_or_insert(key);
            }
        }
        if let Some(key) = left {
            self.place(pair, key, &mut (0.0, None));
        }
        taken
    }

    /// The bit of the least key.
    #[inline(never)]
    fn closest(&self, hits: u64) -> u64 {
        let key = |bit: &usize| self.keys.as_flattened()[*bit];
        let closest = bits(hits).min_by(|i, j| key(i).total_cmp(&key(j)));
        closest.map_or(0, |bit| 1 << bit)
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, key: f32, deepest: &mut (f32, Option<usize>)) {
        let workspace = &mut *self.workspace;
        if self.origin == Origin::Path {
            if key < self.question.guess {
                self.question.guess = key;
                workspace.search.dive = Some(pair);
            }
        } else if key > 0.0 || self.strategy.deepest_first {
            let search = &mut workspace.search;
            let bucket = if self.strategy.deepest_first { 0 } else { search.bucket(key, self.question.cut) };
            workspace.front.queue(pair, key, bucket, true);
        } else {
            let at = workspace.front.push(pair);
            if key < deepest.0 {
                *deepest = (key, Some(at));
            }
        }
    }
}
