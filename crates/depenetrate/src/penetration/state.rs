//! What a penetration query keeps from step to step.

use super::{BALLS, CONES, Job, PAIRS, Penetration, PenetrationQuery, Point, SUMMITS, State};
use crate::blocked::Pool;
use crate::cover::{Ball, Cone, Pair};
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::time::Duration;
use glam::{DMat3, DVec3};
use punctual::engine::crossings;
use punctual::{PairMemory, Stats, Tree};
use punctual_geom::Pose;

/// Rounding of a coordinate of B after a push, relative to the coordinates: proof in
/// `docs/numerics.md`.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// How many corners of a mesh are looked at to find one that is far outside of the other.
const SAMPLES: usize = 256;

impl State {
    pub(super) fn new() -> Self {
        Self {
            pairs: Vec::with_capacity(PAIRS),
            bounds: Vec::with_capacity(PAIRS),
            ids: Vec::with_capacity(PAIRS),
            balls: Vec::with_capacity(BALLS),
            cones: BinaryHeap::with_capacity(CONES),
            ..Self::blank()
        }
    }

    /// A state without room for anything.
    pub(super) fn blank() -> Self {
        Self {
            key: None,
            job: Job::Over,
            asking: None,
            memory: PairMemory::without_clearance(),
            blocked: Pool::default(),
            segments: None,
            likely: ArrayVec::new(),
            explored: 0,
            pairs: Vec::new(),
            bounds: Vec::new(),
            ids: Vec::new(),
            next_pair: 0,
            widest: (0.0, 0),
            balls: Vec::new(),
            next_ball: 0,
            points: ArrayVec::new(),
            summits: ArrayVec::new(),
            next_summit: 0,
            seed: None,
            trials: Default::default(),
            has_sought: false,
            cones: BinaryHeap::new(),
            number: 0,
            advances: 0,
            low: 0.0,
            high: f64::INFINITY,
            direction: DVec3::ZERO,
            is_apart: false,
            has_all_directions: false,
            rounding: 0.0,
            least_scale: 1.0,
            back: Pose::IDENTITY,
            inner: [0.0; 2],
            stats: Stats::default(),
        }
    }

    /// Starts a new run.
    pub(super) fn begin(&mut self, asked: &PenetrationQuery<'_>) {
        let (pairs, bounds, ids) = (
            core::mem::take(&mut self.pairs),
            core::mem::take(&mut self.bounds),
            core::mem::take(&mut self.ids),
        );
        let (balls, cones) = (
            core::mem::take(&mut self.balls),
            core::mem::take(&mut self.cones),
        );
        *self = Self {
            pairs: emptied(pairs),
            bounds: emptied(bounds),
            ids: emptied(ids),
            balls: emptied(balls),
            cones: BinaryHeap::from(emptied(cones.into_vec())),
            key: Some(asked.key()),
            job: Job::Contacts,
            ..Self::blank()
        };
        let pose = &asked.b_in_a;
        let largest = |tree: &Tree| {
            let bounds = tree.mesh().aabb();
            bounds.min.abs().max(bounds.max.abs()).max_element()
        };
        let magnitude =
            largest(asked.a) + 4.0 * largest(asked.b) + pose.translation().abs().max_element();
        self.rounding = ROUNDING * magnitude + f64::MIN_POSITIVE;
        let rotation = pose.rotation();
        let defect = rotation.transpose() * *rotation - DMat3::IDENTITY;
        let defect = defect
            .to_cols_array()
            .into_iter()
            .fold(0.0, |most: f64, entry| most.max(entry.abs()));
        self.least_scale = libm::sqrt((1.0 - 3.0 * defect).max(0.0)) * (1.0 - 1e-12);
        match pose.inverse() {
            Ok(back) => self.back = back,
            // Nothing is measured in B's frame.
            Err(_) => self.least_scale = 0.0,
        }
        let margin = 16.0 * self.rounding;
        self.inner = [false, true].map(|of_b| (asked.inner(of_b) - margin).max(0.0));
    }

    pub(super) fn penetration(&self, limit: f64) -> Penetration {
        let found = self.high < f64::INFINITY && !self.is_apart;
        let deeper = match limit {
            f64::INFINITY => None,
            _ if self.low > limit => Some(true),
            _ if self.high <= limit => Some(false),
            _ => None,
        };
        Penetration {
            low: self.low,
            high: self.high,
            direction: found.then_some(self.direction),
            deeper,
        }
    }

    pub(super) fn took(&mut self, elapsed: Option<Duration>) {
        if let Some(elapsed) = elapsed {
            let total = &mut self.stats.elapsed;
            *total = Some(total.unwrap_or_default().saturating_add(elapsed));
        }
    }

    /// Keeps a pair, in the place of the oldest if there is no room. Returns its number.
    pub(super) fn add_pair(&mut self, id: [u32; 2], corners: [[DVec3; 3]; 2]) -> usize {
        if let Some(known) = self.ids.iter().position(|&other| other == id) {
            return known;
        }
        let pair = Pair::new(corners);
        let at = if self.pairs.len() < PAIRS {
            self.pairs.push(pair);
            self.bounds.push(pair.bounds());
            self.ids.push(id);
            self.pairs.len() - 1
        } else {
            let at = self.next_pair;
            self.next_pair = (at + 1) % PAIRS;
            (self.pairs[at], self.bounds[at], self.ids[at]) = (pair, pair.bounds(), id);
            at
        };
        at
    }

    pub(super) fn keep_ball(&mut self, ball: Ball) {
        if self.balls.len() < BALLS {
            self.balls.push(ball);
        } else {
            self.balls[self.next_ball] = ball;
            self.next_ball = (self.next_ball + 1) % BALLS;
        }
    }

    /// Keeps a summit, in the place of the oldest if there is no room.
    pub(super) fn keep_summit(&mut self, summit: (DVec3, DVec3)) {
        if self.summits.try_push(summit).is_err() {
            self.summits[self.next_summit] = summit;
            self.next_summit = (self.next_summit + 1) % SUMMITS;
        }
    }

    pub(super) fn add_cone(&mut self, cone: Cone) {
        self.number += 1;
        self.cones.push(Cone {
            number: self.number,
            ..cone
        });
    }

    /// A push of this length is proven to separate.
    pub(super) fn separates(&mut self, direction: DVec3, length: f64) {
        if length < self.high {
            (self.high, self.direction) = (length, direction);
        }
    }

    /// True if a new radius is worth another turn of the same cone.
    pub(super) fn is_gain(&self, cone: &Cone, radius: f64) -> bool {
        let goal = self.high.min(4.0 * cone.radius);
        radius >= self.high || radius > cone.radius + 0.25 * (goal - cone.radius)
    }

    /// Keeps the corner of a triangle that is deepest in the other body for a push along
    /// `direction`.
    pub(super) fn add_point(&mut self, of_b: bool, corners: &[DVec3; 3], direction: DVec3) {
        let toward = if of_b { -direction } else { direction };
        let deepest = corners
            .iter()
            .max_by(|p, q| p.dot(toward).total_cmp(&q.dot(toward)));
        let Some(&place) = deepest else { return };
        let known = |point: &Point| point.of_b == of_b && point.place == place;
        let point = match self.points.iter().position(known) {
            Some(at) => self.points.remove(at),
            None => Point {
                of_b,
                place,
                near: ArrayVec::new(),
                inside: ArrayVec::new(),
            },
        };
        if self.points.is_full() {
            // The oldest that was found outside, or else the oldest.
            let is_outside = |point: &Point| point.inside.is_empty() && !point.near.is_empty();
            let worst = self.points.iter().position(is_outside);
            self.points.remove(worst.unwrap_or(0));
        }
        self.points.push(point);
    }
}

/// The vector without its elements.
fn emptied<T>(mut all: Vec<T>) -> Vec<T> {
    all.clear();
    all
}

impl PenetrationQuery<'_> {
    /// For how long a push a point of the other body that is inside of A (of B) proves that they
    /// are not apart.
    ///
    /// For solids that is for ever. For surfaces it is as long as another point of the same
    /// component stays outside, as one does that is far from the box.
    pub(super) fn inner(&self, of_b: bool) -> f64 {
        let (body, other) = if of_b {
            (self.b, self.a)
        } else {
            (self.a, self.b)
        };
        let has_inside = |tree: &Tree| {
            let solidity = tree.solid();
            solidity.is_some_and(|solidity| solidity.components().iter().any(|c| c.is_closed()))
        };
        if !has_inside(body) {
            return 0.0;
        }
        if self.solid {
            return f64::INFINITY;
        }
        let is_one = |tree: &Tree| {
            let solidity = tree.solid();
            solidity.is_some_and(|solidity| solidity.components().len() == 1)
        };
        if !is_one(other) {
            return 0.0;
        }
        let bounds = if of_b {
            self.b.aabb_at(&self.b_in_a)
        } else {
            self.a.mesh().aabb()
        };
        let count = other.mesh().len();
        let distance = |triangle: usize| {
            let [corner, ..] = other.mesh().triangle(triangle);
            let place = if of_b {
                corner
            } else {
                self.b_in_a.transform_point(corner)
            };
            let outside = (bounds.min - place).max(place - bounds.max);
            punctual_geom::length(outside.max(DVec3::ZERO))
        };
        let farthest = (0..count)
            .step_by(count.div_ceil(SAMPLES).max(1))
            .map(distance);
        farthest.fold(0.0, f64::max) * (1.0 - 1e-9)
    }

    /// How often the closed components of A (of B) wind around a point of their frame.
    pub(super) fn winding(&self, of_b: bool, point: DVec3) -> i32 {
        let tree = if of_b { self.b } else { self.a };
        let Some(solidity) = tree.solid() else {
            return 0;
        };
        let is_closed = |triangle| {
            let component = solidity.component_of(triangle) as usize;
            solidity.components()[component].is_closed()
        };
        crossings(tree, point, is_closed).winding
    }

    /// True if a point of the frame of A (of B) is inside.
    pub(super) fn is_inside(&self, of_b: bool, point: DVec3) -> bool {
        let winding = self.winding(of_b, point);
        if self.solid {
            winding > 0
        } else {
            winding != 0
        }
    }
}
