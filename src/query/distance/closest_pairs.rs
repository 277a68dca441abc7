//! Tests of triangle pairs in a search for the closest pair, or for all pairs within a margin.
//!
//! Triangle pairs pass two tests. The first gives lower bounds in `f32`, eight pairs at a time. The
//! second, in `f64` and one pair at a time, is for pairs that may be closer than the closest so
//! far. Pairs that can only raise the lower bound are put off to the end. Within a margin there is
//! no closest: each pair counts.

use super::nearest::Nearness;
use super::search::Bounded;
use crate::engine::traversal::Traversal;
use crate::engine::triangles::corners::Corners;
use crate::engine::triangles::{ids, points, rows};
use crate::engine::workspace::Workspace;
use crate::model::cost::{
    WORK_PER_CLOSEST_POINTS, WORK_PER_CONTACT, WORK_PER_DISTANCE_TEST, WORK_PER_EXACT_TEST,
    WORK_PER_LOOKUP, WORK_PER_POINT_TRIANGLE, WORK_PER_SEGMENT,
};
use crate::query::contacts::contact::Contact;
use crate::query::manifolds::manifold::{Shape, Skin, falls_beside};
use crate::tree::{Tree, WIDTH};
use arrayvec::ArrayVec;
use punctual_geom::bits;
use punctual_geom::lanes::{Column, F8, Lanes};
use punctual_geom::triangle::distance::{Closest, Distances, closest, distances};
use punctual_geom::{triangle_segment, triangles_intersect};

/// A direction that proves at least this fraction of a distance is within 5 degrees of the normal,
/// rounding included.
pub(crate) const CLOSE: f32 = 0.999;

/// In place of the lower bound of a proposed pair: only its common area counts.
const ONLY_AREA: f32 = f32::INFINITY;

impl<const POINTS: bool> Traversal<'_, '_, Nearness, POINTS> {
    /// True if there may be no room for the results of the next step.
    #[cold]
    #[inline(never)]
    pub(crate) fn is_full(&self) -> bool {
        let state = &self.workspace.state;
        let is_full = if state.contacts.lists_pairs {
            state.intersection.is_full()
        } else {
            state.contacts.is_full()
        };
        is_full && !state.distance.proposed.is_empty()
    }

    /// Computes lower bounds of up to eight waiting pairs.
    #[inline(always)]
    pub(crate) fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let search = &mut self.workspace.state.distance;
        let mut dropped = search.dropped;
        let (pairs, keys, count) =
            search.pop_batch(self.question.cut, |low| dropped = dropped.min(low));
        search.dropped = dropped;
        if count == 0 {
            return;
        }
        let made = [
            points::<POINTS>(self.a, pairs, 0),
            points::<POINTS>(self.b, pairs, 1),
        ];
        let found = distances(
            lanes,
            rows(self.a, &made[0], pairs, 0),
            rows(self.b, &made[1], pairs, 1),
            &self.relative.triangles,
        );
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += count as u64;
        stats.work += count as u64 * WORK_PER_DISTANCE_TEST;
        // The boxes may have proven a larger bound; keep it.
        let proven = F8::load(lanes, &keys).max(F8::splat(lanes, 0.0)).sqrt()
            * F8::splat(lanes, 1.0 - f32::EPSILON);
        let low = F8::load(lanes, &found.low).max(proven);
        if self.workspace.state.contacts.margin().is_some() {
            let meet = !F8::splat(lanes, 0.0).less(low).mask();
            // The factor makes the rounded root larger than the exact one.
            let cut = F8::splat(lanes, self.question.cut).sqrt()
                * F8::splat(lanes, 1.0 + 4.0 * f32::EPSILON);
            let near = (low.less(cut).mask() | meet) & ((1 << count) - 1);
            self.keep_near(&pairs, &low.store(), near & !meet, near & meet, &found);
        } else {
            self.propose(&pairs[..count], &low.store(), &found);
        }
    }

    /// Proposes the pairs that may be within the margin, except those that add nothing to the skin
    /// of the manifolds. Of `found`, the pairs in the mask `apart` do not intersect, those in
    /// `meet` may.
    #[inline(never)]
    fn keep_near(
        &mut self,
        pairs: &[[u32; 2]; WIDTH],
        low: &[f32; WIDTH],
        apart: u32,
        meet: u32,
        found: &Distances,
    ) {
        let Workspace { corners, state, .. } = &mut *self.workspace;
        let (search, reduction) = (&mut state.distance, &mut state.manifolds.reduction);
        search.interval.pass_rest();
        let shape = Shape {
            trees: [self.a, self.b],
            b_in_a: self.b_in_a,
        };
        for i in bits(apart | meet).map(|i| i % WIDTH) {
            let (pair, low) = (pairs[i], low[i]);
            // A bound as good as the distance is proven by a direction close to the normal.
            if reduction.is_on && apart >> i & 1 != 0 && found.low[i] >= CLOSE * found.about[i] {
                let of_pair = Corners::of_pair(corners, [self.a, self.b], self.b_in_a, pair);
                let normal = found.direction.map(|of_axis| f64::from(of_axis[i])).into();
                let low = f64::from(low) * self.relative.unit;
                let nearest = reduction.nearest.map_or(f64::INFINITY, |(_, least)| least);
                let places = (&found.places, i);
                if reduction.skin.covers(of_pair, low, normal, nearest)
                    || falls_beside(shape, pair, of_pair, places, low, normal)
                {
                    if Skin::has_area(of_pair) {
                        let low = ONLY_AREA;
                        search.proposed.push(Bounded { pair, low });
                    }
                    continue;
                }
            }
            search.proposed.push(Bounded { pair, low });
        }
    }

    /// Pairs that may be the closest are tested next, the most likely first. Pairs that can only
    /// raise the lower bound are put off.
    #[inline(never)]
    fn propose(&mut self, pairs: &[[u32; 2]], low: &[f32; WIDTH], found: &Distances) {
        let search = &mut self.workspace.state.distance;
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
    pub(crate) fn consider(&mut self, Bounded { pair, low }: Bounded) {
        let workspace = &mut *self.workspace;
        if low == ONLY_AREA && workspace.state.manifolds.reduction.is_on {
            let trees = [self.a, self.b];
            let of_pair = Corners::of_pair(&mut workspace.corners, trees, self.b_in_a, pair);
            let reduction = &mut workspace.state.manifolds.reduction;
            return reduction.take_area(of_pair, &mut workspace.run.stats);
        }
        let interval = &mut workspace.state.distance.interval;
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
        self.deadline.allow_for_long_step();
        if let Some(margin) = workspace.state.contacts.margin() {
            return self.consider_contact(Bounded { pair, low }, proven, margin);
        }
        let trees = [self.a, self.b];
        let [a, b] = Corners::of_pair(&mut workspace.corners, trees, self.b_in_a, pair);
        let near = match self.question.lone {
            Some(lone) if lone.is_point => lone.closest(a, b),
            _ => None,
        };
        stats.work += match near {
            Some(_) => WORK_PER_POINT_TRIANGLE,
            None => WORK_PER_CLOSEST_POINTS,
        };
        let mut found = near.unwrap_or_else(|| closest(a, b));
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
        workspace.state.distance.interval.settle(pair, &found);
        self.question
            .update(self.relative, &workspace.state.distance.interval);
    }

    /// Keeps the contact of a pair that is at least `proven` apart, if its distance is within the
    /// margin.
    fn consider_contact(&mut self, proposed: Bounded, proven: f64, margin: f64) {
        let Workspace {
            corners,
            run,
            state,
            ..
        } = &mut *self.workspace;
        let (search, contacts) = (&mut state.distance, &mut state.contacts);
        let manifolds = &mut state.manifolds;
        let (reduction, overlaps) = (&mut manifolds.reduction, &mut manifolds.overlaps);
        let (trees, pair) = ([self.a, self.b], proposed.pair);
        let of_pair @ [a, b] = Corners::of_pair(corners, trees, self.b_in_a, pair);
        let (triangles, stats) = (ids(trees, pair), &mut run.stats);
        let shape = Shape {
            trees,
            b_in_a: self.b_in_a,
        };
        if contacts.lists_pairs {
            stats.work += WORK_PER_CLOSEST_POINTS;
            let mut found = closest(a, b);
            let mut meet = false;
            if found.low.max(proven) == 0.0 {
                stats.exact_tests += 1;
                stats.work += WORK_PER_EXACT_TEST;
                meet = triangles_intersect(a, b);
            }
            if !meet {
                found = found.of_apart(a, b);
            }
            if meet || found.low.max(proven) <= margin {
                let distance = if meet { 0.0 } else { found.high };
                self.workspace.report_within(pair, triangles, distance);
            }
            return;
        }
        if proven == 0.0 {
            if reduction.is_on {
                if !reduction.take_near(shape, pair, of_pair, overlaps, contacts, stats) {
                    search.proposed.push(proposed);
                }
                return;
            }
            stats.exact_tests += 1;
            stats.work += WORK_PER_EXACT_TEST;
            if let Some(segment) = triangle_segment(a, b) {
                stats.work += WORK_PER_SEGMENT + WORK_PER_CONTACT;
                stats.found += 1;
                let contact = Contact::touching(triangles, of_pair, segment);
                return contacts.push(contact.thickened(trees.map(Tree::radius)));
            }
        }
        stats.work += WORK_PER_CLOSEST_POINTS;
        let mut found = closest(a, b).of_apart(a, b);
        found.low = found.low.max(proven);
        if found.low > margin {
            return;
        }
        stats.work += WORK_PER_CONTACT;
        stats.found += 1;
        let contact = Contact::apart(triangles, of_pair, &found);
        if !reduction.is_on {
            return contacts.push(contact.thickened(trees.map(Tree::radius)));
        }
        reduction.note(pair, contact.distance);
        found.direction = contact.normal;
        reduction.skin.take(shape, pair, of_pair, &found);
    }
}
