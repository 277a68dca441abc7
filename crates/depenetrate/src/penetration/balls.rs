//! Balls of blocked translations: about corners that are inside of the other body, and about points
//! that are deep in both solids.

use super::{
    Asking, CLIMB, CLIMBS, Climb, DEEP, Job, Machine, Point, RANDOM_SEEDS, SEEDS, Task,
    WORK_PER_PROOF, WORK_PER_RAY,
};
use crate::blocked::unit;
use crate::cover::{Ball, Cone};
use crate::directions::{Segments, all_around};
use glam::DVec3;
use punctual_geom::random::Random;

impl Machine<'_, '_, '_, '_> {
    /// All translations shorter than `radius` are blocked.
    pub(super) fn raise_low(&mut self, radius: f64) {
        let state = &mut *self.state;
        state.low = state.low.max(radius.min(state.high));
    }

    /// Where a point is in the frame of the other body while B is moved.
    pub(super) fn place(&self, point: &Point, at: DVec3) -> DVec3 {
        if point.of_b {
            point.place + at
        } else {
            self.state.back.transform_point(point.place - at)
        }
    }

    /// Asks how deep a point is while B is moved; `None` if it is known to be less than `needed`.
    pub(super) fn ask_point(&mut self, index: usize, at: DVec3, needed: f64) -> Option<u64> {
        let point = self.state.points.get(index)?;
        let place = self.place(point, at);
        let is_near = |near: &DVec3| punctual_geom::length(*near - place) < needed;
        if point.near.iter().any(is_near) {
            return None;
        }
        let of_b = !point.of_b;
        Some(self.ask(Asking::Near { of_b, point: place }))
    }

    /// Keeps the ball of a point that is inside of the other body, at `distance` from its surface,
    /// while B is moved by `at`.
    pub(super) fn add_ball(
        &mut self,
        index: usize,
        at: DVec3,
        distance: f64,
        nearest: DVec3,
    ) -> Option<Ball> {
        let point = self.state.points.get(index)?;
        let (of_b, place) = (point.of_b, self.place(point, at));
        let point_in_a = point.place;
        let mut radius = distance;
        if !of_b {
            let miss = self.asked.b_in_a.transform_point(place) - (point_in_a - at);
            radius = distance * self.state.least_scale - 2.0 * punctual_geom::length(miss);
        }
        let radius = radius - 16.0 * self.state.rounding;
        let is_known = |&(center, radius): &(DVec3, f64)| {
            punctual_geom::length(center - at) < radius * (1.0 - 1e-9)
        };
        let is_inside = point.inside.iter().any(is_known) || self.asked.is_inside(!of_b, place);
        let longest = self.state.inner[usize::from(!of_b)];
        let point = &mut self.state.points[index];
        if point.near.is_full() {
            point.near.remove(0);
        }
        point.near.push(nearest);
        if !(is_inside && radius > 0.0) {
            return None;
        }
        if point.inside.is_full() {
            point.inside.remove(0);
        }
        point.inside.push((at, radius));
        let ball = Ball {
            center: at,
            radius,
            longest,
        };
        self.state.keep_ball(ball);
        Some(ball)
    }

    pub(super) fn about(&mut self, index: usize) -> u64 {
        if index >= self.state.points.len() {
            self.state.job = Job::Start;
            return 64;
        }
        let needed = self.state.low;
        self.ask_point(index, DVec3::ZERO, needed)
            .unwrap_or_else(|| {
                self.state.job = Job::About(index + 1);
                100
            })
    }

    /// Makes the first cones, with the radius known by now.
    pub(super) fn start(&mut self) -> u64 {
        let rounding = self.state.rounding;
        let (margin, number) = self.state.widest;
        let half = 0.9 * margin;
        if let Some(pair) = self.state.pairs.get(number)
            && half > 64.0 * rounding
            && pair.fills_cube(half)
        {
            self.raise_low(half - 8.0 * rounding);
        }
        let radius = self.state.low;
        if self.may_seek() && radius < DEEP * self.state.high {
            self.state.job = Job::Seek(0);
        } else if radius > 64.0 * rounding {
            for cone in Cone::all_around() {
                self.state.add_cone(Cone { radius, ..cone });
            }
            self.state.job = Job::Pick;
        } else if self.state.has_all_directions {
            self.state.job = Job::Over;
        } else {
            // Nothing more is known of `low`, so what is left is a shorter push.
            self.state.has_all_directions = true;
            self.state.likely.extend(all_around());
            self.state.job = Job::Explore;
        }
        2 * WORK_PER_PROOF
    }

    /// True if both have an inside, and no point deep in both was sought yet.
    pub(super) fn may_seek(&self) -> bool {
        self.asked.solid && self.state.inner == [f64::INFINITY; 2] && !self.state.has_sought
    }

    /// Begins a climb at a place that is inside of both, if it is.
    pub(super) fn seek(&mut self, index: usize) -> u64 {
        self.state.has_sought = true;
        let half = self.state.direction * (0.5 * self.state.high.min(self.size()));
        let (place, trials) = match index {
            0 => (self.state.segments.as_ref().map(Segments::middle), 1),
            1..RANDOM_SEEDS => {
                let point = self.state.points.iter().rev().nth(index - 1);
                let inward = |p: &Point| {
                    if p.of_b {
                        p.place + half
                    } else {
                        p.place - half
                    }
                };
                (point.map(inward), 1)
            }
            RANDOM_SEEDS..SEEDS => (Some(self.random_place(index as u64)), 1),
            SEEDS => (self.state.seed.map(|(_, place)| place), CLIMB),
            _ => {
                self.state.job = if self.state.number > 0 {
                    Job::Pick
                } else {
                    Job::Start
                };
                return 64;
            }
        };
        let place = place.filter(|&place| self.is_in_both(place, DVec3::ZERO));
        self.state.job = place.map_or(Job::Seek(index + 1), |place| {
            let step = 0.5 * punctual_geom::length(half);
            Job::Climb(Climb::new(index, DVec3::ZERO, place, step, trials, None))
        });
        2 * WORK_PER_RAY
    }

    /// A place that both boxes share.
    fn random_place(&self, number: u64) -> DVec3 {
        let a = self.asked.a.mesh().aabb();
        let b = self.asked.b.aabb_at(&self.asked.b_in_a);
        let (min, max) = (a.min.max(b.min), a.max.min(b.max));
        let mut random = Random::new(number);
        let mut share = || random.fraction();
        min + (max - min) * DVec3::new(share(), share(), share())
    }

    /// True if a point of A's frame is inside of both while B is moved.
    pub(super) fn is_in_both(&self, place: DVec3, at: DVec3) -> bool {
        self.asked.is_inside(false, place)
            && self
                .asked
                .is_inside(true, self.state.back.transform_point(place - at))
    }

    pub(super) fn climb(&mut self, mut climb: Climb) -> u64 {
        if climb.left == 0 || climb.step < climb.least {
            self.end_climb(climb);
            return 256;
        }
        if climb.of_a.is_none() {
            if !self.is_in_both(climb.trial, climb.at) {
                climb.turn_away();
                self.state.job = Job::Climb(climb);
                return 2 * WORK_PER_RAY;
            }
            return 2 * WORK_PER_RAY
                + self.ask(Asking::Near {
                    of_b: false,
                    point: climb.trial,
                });
        }
        let point = self.state.back.transform_point(climb.trial - climb.at);
        self.ask(Asking::Near { of_b: true, point })
    }

    pub(super) fn climbed(&mut self, mut climb: Climb, distance: f64) {
        if let Some(of_a) = climb.of_a.take() {
            let place = climb.trial - climb.at;
            let back = self.state.back.transform_point(place);
            let miss = self.asked.b_in_a.transform_point(back) - place;
            let sum = of_a + distance * self.state.least_scale
                - 2.0 * punctual_geom::length(miss)
                - 32.0 * self.state.rounding;
            if sum > climb.sum {
                climb.rise(sum);
            } else {
                climb.turn_away();
            }
        } else {
            climb.of_a = Some(distance);
        }
        self.state.job = Job::Climb(climb);
    }

    pub(super) fn end_climb(&mut self, climb: Climb) {
        let ball = Ball {
            center: climb.at,
            radius: climb.sum,
            longest: f64::INFINITY,
        };
        let is_ball = ball.radius > 0.0;
        if climb.cone.is_none() && climb.number < SEEDS {
            if self.state.seed.is_none_or(|(sum, _)| sum < climb.sum) {
                self.state.seed = Some((climb.sum, climb.best));
            }
            self.state.job = Job::Seek(climb.number + 1);
            return;
        }
        if is_ball {
            self.state.keep_ball(ball);
            self.state.keep_summit((climb.at, climb.best));
        }
        let Some(mut task) = climb.task() else {
            if is_ball && self.state.number == 0 {
                self.raise_low(ball.radius);
            }
            self.state.job = Job::Seek(climb.number + 1);
            return;
        };
        if is_ball && let Some(advance) = task.rays.by_ball(&ball) {
            task.proven = task.proven.max(advance.radius);
        }
        let gains = self.state.is_gain(&task.cone, task.proven);
        self.state.trials[CLIMBS].note(gains);
        task.stage = self.before_contacts();
        self.settle(task);
    }
}

impl Climb {
    pub(super) fn new(
        number: usize,
        at: DVec3,
        start: DVec3,
        step: f64,
        left: u32,
        cone: Option<Task>,
    ) -> Self {
        Self {
            number,
            at,
            best: start,
            sum: 0.0,
            step,
            least: 0.01 * step,
            left,
            side: 0,
            turns: 0,
            trial: start,
            of_a: None,
            cone,
        }
    }

    pub(super) fn task(&self) -> Option<Task> {
        self.cone
    }

    /// The trial is better.
    pub(super) fn rise(&mut self, sum: f64) {
        (self.best, self.sum) = (self.trial, sum);
        self.step *= 1.3;
        self.next(true);
    }

    /// The trial is no better.
    pub(super) fn turn_away(&mut self) {
        self.side += 1;
        let is_round = self.side == 6;
        if is_round {
            self.step *= 0.5;
        }
        self.next(is_round);
    }

    /// Chooses the next of six directions, of a turned compass if the last is done with.
    pub(super) fn next(&mut self, is_new: bool) {
        self.left = self.left.saturating_sub(1);
        if is_new {
            self.side = 0;
            self.turns += 1;
        }
        let mut random = Random::new(self.turns);
        let mut axis = || random.between(-1.0, 1.0);
        let first = unit(DVec3::new(axis(), axis(), axis()) + DVec3::splat(1e-9));
        let (second, third) = first.any_orthonormal_pair();
        let along = [first, second, third][self.side / 2 % 3];
        let sign = if self.side % 2 == 0 { 1.0 } else { -1.0 };
        self.trial = self.best + along * (sign * self.step);
    }
}
