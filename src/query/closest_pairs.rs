//! Tests of triangle pairs in a search for the closest pair, or for all pairs within a margin.
//!
//! Triangle pairs pass two tests. The first gives lower bounds in `f32`, eight pairs at a time. The
//! second, in `f64` and one pair at a time, is for pairs that may be closer than the closest so
//! far; it uses the features that `f32` found closest. Pairs that can only raise the lower bound
//! are put off to the end. Within a margin there is no closest: each pair counts, and separated
//! pairs are tested in `f64` four at a time.

use super::corners::Corners;
use super::nearest::Nearness;
use super::outcome::Stats;
use super::search::{Bounded, TOGETHER};
use super::traversal::Traversal;
use super::triangle_pairs::{ids, rows};
use super::workspace::Workspace;
use crate::contact::Contact;
use crate::contact::manifold::Shape;
use crate::model::cost::{
    WORK_PER_CLOSEST_POINTS, WORK_PER_CONTACT, WORK_PER_DISTANCE_TEST, WORK_PER_EXACT_TEST,
    WORK_PER_FEATURES, WORK_PER_FEATURES_ALONE, WORK_PER_LOOKUP, WORK_PER_SEGMENT,
};
use crate::tree::WIDTH;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Lanes};
use punctual_geom::triangle::distance::{Chosen, Closest, Distances, Four, closest, distances};
use punctual_geom::triangle_segment;

impl Traversal<'_, '_, Nearness> {
    /// True if there may be no room for the results of the next step.
    #[cold]
    #[inline(never)]
    pub(super) fn is_full(&self) -> bool {
        let search = &self.workspace.search;
        self.workspace.contacts.is_full()
            && !(search.proposed.is_empty() && search.linked.is_empty())
    }

    /// Computes lower bounds of up to eight waiting pairs.
    #[inline(always)]
    pub(super) fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let search = &mut self.workspace.search;
        let mut dropped = search.dropped;
        let (pairs, keys, count) =
            search.pop_batch(self.question.cut, |low| dropped = dropped.min(low));
        search.dropped = dropped;
        if count == 0 {
            return;
        }
        let found = distances(
            lanes,
            rows(self.a, pairs, 0),
            rows(self.b, pairs, 1),
            &self.relative.triangles,
        );
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += count as u64;
        stats.work += count as u64 * WORK_PER_DISTANCE_TEST;
        // The boxes may have proven a larger bound; keep it.
        let proven = F8::load(lanes, &keys).max(F8::splat(lanes, 0.0)).sqrt()
            * F8::splat(lanes, 1.0 - f32::EPSILON);
        let low = F8::load(lanes, &found.low).max(proven);
        if self.workspace.contacts.margin().is_some() {
            let meet = !F8::splat(lanes, 0.0).less(low).mask();
            // Larger than the rounded root.
            let cut = F8::splat(lanes, self.question.cut).sqrt()
                * F8::splat(lanes, 1.0 + 4.0 * f32::EPSILON);
            let near = (low.less(cut).mask() | meet) & ((1 << count) - 1);
            self.link(&pairs, &low.store(), near, meet, &found.closest);
        } else {
            self.propose(&pairs[..count], &low.store(), &found);
        }
    }

    /// Pairs that may be within the margin wait for their closest points. Pairs that may intersect
    /// wait for an exact test.
    #[inline(never)]
    fn link(
        &mut self,
        pairs: &[[u32; 2]; WIDTH],
        low: &[f32; WIDTH],
        near: u32,
        meet: u32,
        chosen: &Chosen,
    ) {
        let Workspace {
            search,
            corners: [of_a, of_b],
            reduction,
            ..
        } = &mut *self.workspace;
        search.interval.pass_rest();
        for i in bits(near) {
            let i = i % WIDTH;
            if reduction.is_on && meet >> i & 1 == 0 {
                let a = of_a.of(self.a, pairs[i][0], |v| v);
                let b = of_b.of(self.b, pairs[i][1], |v| self.b_in_a.transform_point(v));
                let low = f64::from(low[i]) * self.relative.unit;
                if reduction.skin.covers([a, b], low) {
                    continue;
                }
            }
            let bounded = Bounded {
                pair: pairs[i],
                low: low[i],
                closest: chosen.of(i),
            };
            if meet >> i & 1 == 0 {
                search.linked.push(bounded);
            } else {
                search.proposed.push(bounded);
            }
        }
    }

    /// Computes the closest points of a few linked pairs, as far as there is room for the contacts.
    #[inline(never)]
    pub(super) fn test_linked<L: Lanes>(&mut self, lanes: L) {
        let Workspace {
            search,
            contacts,
            corners,
            run,
            reduction,
            overlaps,
            ..
        } = &mut *self.workspace;
        let shape = Shape {
            trees: [self.a, self.b],
            b_in_a: self.b_in_a,
            has_inside: [true; 2],
        };
        let count = search.linked.len().min(TOGETHER).min(contacts.room());
        let linked = &search.linked[search.linked.len() - count..];
        let (trees, mut four) = ([self.a, self.b], Four::NONE);
        for (i, Bounded { pair, closest, .. }) in linked.iter().enumerate() {
            four.set(
                i,
                *closest,
                Corners::of_pair(corners, trees, self.b_in_a, *pair),
            );
        }
        let found = lanes.run(&four);
        run.stats.work += count as u64 * WORK_PER_FEATURES;
        let margin = contacts.margin().unwrap_or(0.0);
        for (i, bounded) in linked.iter().enumerate() {
            let Some(found) = found.of(i) else {
                search.proposed.push(*bounded);
                continue;
            };
            if found.low.max(f64::from(bounded.low) * self.relative.unit) <= margin {
                if reduction.is_on {
                    reduction.note(bounded.pair, found.high);
                    let found_of = Corners::of_pair(corners, trees, self.b_in_a, bounded.pair);
                    if !reduction.skin.take(shape, bounded.pair, found_of, &found) {
                        overlaps.take_touching(bounded.pair, found.points[0]);
                        contacts.hold();
                    }
                } else {
                    contacts.push(Contact::parted(ids(trees, bounded.pair), &found));
                }
                run.stats.work += WORK_PER_CONTACT;
                run.stats.found += 1;
            }
        }
        search.linked.truncate(search.linked.len() - count);
        self.deadline.allow_for_long_step();
    }

    /// Pairs that may be the closest are tested next, the most likely first. Pairs that can only
    /// raise the lower bound are put off.
    #[inline(never)]
    fn propose(&mut self, pairs: &[[u32; 2]], low: &[f32; WIDTH], found: &Distances) {
        let search = &mut self.workspace.search;
        let closer =
            (search.interval.high() / self.relative.unit) as f32 * (1.0 - 4.0 * f32::EPSILON);
        let mut order = ArrayVec::<usize, WIDTH>::new();
        for (i, &low) in low.iter().enumerate().take(pairs.len()) {
            let bound = f64::from(low) * self.relative.unit;
            if search.interval.matters(bound) {
                order.push(i);
            } else {
                search.interval.pass(bound);
            }
        }
        // NaN of either sign becomes infinity.
        let about = found.about.map(|about| {
            if about < f32::INFINITY {
                about
            } else {
                f32::INFINITY
            }
        });
        order.sort_unstable_by(|&i, &j| about[j].total_cmp(&about[i]).then(j.cmp(&i)));
        for i in order {
            let proposed = Bounded {
                pair: pairs[i],
                low: low[i],
                closest: found.closest.of(i),
            };
            if low[i] > 0.0 && about[i] > closer && !search.put_off.is_full() {
                search.put_off.push(proposed);
            } else {
                search.proposed.push(proposed);
            }
        }
    }

    /// Tests a pair in `f64`, unless it no longer matters.
    #[inline(never)]
    pub(super) fn consider<L: Lanes>(
        &mut self,
        lanes: L,
        Bounded {
            pair,
            low,
            closest: features,
        }: Bounded,
    ) {
        let workspace = &mut *self.workspace;
        let interval = &mut workspace.search.interval;
        let is_settled = interval
            .nearest()
            .is_some_and(|(nearest, _)| nearest == pair);
        let stats = &mut workspace.run.stats;
        let proven = f64::from(low) * self.relative.unit;
        if is_settled || !interval.matters(proven) {
            stats.work += WORK_PER_LOOKUP;
            if !is_settled {
                interval.pass(proven);
            }
            return;
        }
        let trees = [self.a, self.b];
        let [a, b] = Corners::of_pair(&mut workspace.corners, trees, self.b_in_a, pair);
        self.deadline.allow_for_long_step();
        if let Some(margin) = workspace.contacts.margin() {
            if let Some(contact) = contact(ids(trees, pair), [a, b], proven, margin, stats) {
                workspace.run.stats.found += 1;
                if workspace.reduction.is_on {
                    workspace.reduction.note(pair, contact.distance);
                }
                if !workspace.reduction.is_on {
                    workspace.contacts.push(contact);
                } else if let Some(segment) = contact.segment {
                    workspace.overlaps.take(pair, [a, b], segment);
                    workspace.contacts.hold();
                    workspace.reduction.skin.take_meeting([a, b]);
                } else {
                    let found = Closest {
                        points: contact.points,
                        direction: contact.normal,
                        low: proven,
                        high: contact.distance,
                        is_tight: true,
                    };
                    let shape = Shape {
                        trees: [self.a, self.b],
                        b_in_a: self.b_in_a,
                        has_inside: [true; 2],
                    };
                    if !workspace.reduction.skin.take(shape, pair, [a, b], &found) {
                        workspace.overlaps.take_touching(pair, found.points[0]);
                        workspace.contacts.hold();
                    }
                }
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
        let segment = if found.low.max(proven) == 0.0 {
            stats.exact_tests += 1;
            stats.work += WORK_PER_EXACT_TEST;
            triangle_segment(a, b)
        } else {
            None
        };
        found = match segment {
            Some(ends) => Closest::meeting(ends),
            None => found.of_apart(a, b),
        };
        found.low = found.low.max(proven);
        workspace.search.interval.settle(pair, &found);
        self.question
            .update(self.relative, &workspace.search.interval);
    }
}

/// The contact of two triangles that are at least `proven` apart, if their distance is within the
/// margin.
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
        stats.work += if touching.is_some() {
            WORK_PER_SEGMENT + WORK_PER_CONTACT
        } else {
            0
        };
        if touching.is_some() {
            return touching;
        }
    }
    let found = closest(corners[0], corners[1]).of_apart(corners[0], corners[1]);
    stats.work += WORK_PER_CLOSEST_POINTS;
    (found.low.max(proven) <= margin).then(|| {
        stats.work += WORK_PER_CONTACT;
        Contact::apart(triangles, corners, &found)
    })
}
