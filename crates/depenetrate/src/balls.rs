//! Balls inside of the bodies, which are grown where a push is blocked.
//!
//! A ball that touches the surface at its foot has its center on the normal there. It begins large
//! and shrinks until it touches the nearest point of the surface too. Then the body has no larger
//! ball with this foot. What is proven is the distance from the center to the surface.

use super::PenetrationQuery;
use super::directions::normal;
use super::machine::{Machine, Step, Task};
use super::sets::{Pair, Point, unit};
use glam::DVec3;
use punctual::intersection::Operand;
use punctual::{Query, Tree, Verdict};
use punctual_geom::triangle_segment;

/// Maximum number of questions for a ball.
const QUESTIONS: u32 = 6;

/// A ball is done if the surface is no nearer than this share of its radius.
const DONE: f64 = 0.8;

/// Number of triangles of a mesh that are searched for a corner that is far outside of the other.
const SAMPLES: usize = 256;

/// A ball that is grown, in the frame of its body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seed {
    of_b: bool,
    center: DVec3,
    radius: f64,
    /// The point of the surface at which it touches, and the normal there. `None` if only the
    /// center is known.
    foot: Option<(DVec3, DVec3)>,
    left: u32,
}

impl Machine<'_, '_, '_> {
    /// True if points of the other body that are inside of this one prove anything.
    fn has_inside(&self, of_b: bool) -> bool {
        self.state.longest[usize::from(of_b)] > 0.0
    }

    /// Keeps a point and the balls that it gives, if they may be of use, and raises `low` by them.
    fn keep(&mut self, point: Point) {
        let state = &mut *self.state;
        let (rounding, longest) = (state.rounding, state.longest);
        self.sets.add_point(point, rounding, longest, |ball| {
            let center = punctual_geom::length(ball.center);
            state.raise_low((ball.radius - center - rounding).min(ball.longest));
            ball.radius + center > state.low && center - ball.radius < state.high
        });
    }

    /// Learns from two triangles that block a push.
    pub(super) fn learn(&mut self, id: [u32; 2], direction: DVec3) {
        let corners = self.corners(id);
        self.sets.add_pair(id, Pair::new(corners));
        for (of_b, corners) in [false, true].into_iter().zip(corners) {
            if let Some(place) = deepest(of_b, corners.into_iter(), direction)
                && self.has_inside(!of_b)
            {
                let radius = 0.0;
                self.keep(Point {
                    of_b,
                    place,
                    radius,
                });
            }
        }
    }

    /// Plants a ball in each body about the middle of the part that their boxes share, and about
    /// the corner of the other that is deepest for the best push.
    pub(super) fn sow_corners(&mut self) {
        let a = self.asked.a.mesh().aabb();
        let b = self.asked.b.aabb_at(&self.asked.asked.b_in_a);
        let middle = 0.5 * (a.min.max(b.min) + a.max.min(b.max));
        self.plant(false, middle, None);
        self.plant(true, self.state.back.transform_point(middle), None);
        let corners = [false, true].map(|of_b| {
            let corners = self.sets.corners(of_b);
            deepest(of_b, corners, self.state.direction)
        });
        if let [Some(of_a), Some(of_b)] = corners {
            self.plant(false, of_b, None);
            self.plant(true, self.state.back.transform_point(of_a), None);
        }
    }

    /// Plants a ball in each body where they block a push.
    pub(super) fn sow(&mut self, obstacle: Verdict, at: DVec3) {
        match obstacle {
            Verdict::Intersecting { witness } => {
                let [a, b] = self.corners(witness);
                let Some([p, q]) = triangle_segment(&a, &b.map(|corner| corner + at)) else {
                    return;
                };
                let foot = 0.5 * (p + q);
                let back = self.state.back.transform_point(foot - at);
                let of_b = self.asked.b.mesh().triangle(witness[1] as usize);
                self.plant(false, foot, Some(normal(&a)));
                self.plant(true, back, Some(normal(&of_b)));
            }
            Verdict::Contained { inner } => {
                let of_b = inner == Operand::B;
                let corners = self.asked.tree(of_b).mesh().triangle(0);
                let foot = (corners[0] + corners[1] + corners[2]) / 3.0;
                let other = match inner {
                    Operand::A => self.state.back.transform_point(foot - at),
                    Operand::B => self.asked.asked.b_in_a.transform_point(foot) + at,
                };
                self.plant(of_b, foot, Some(normal(&corners)));
                self.plant(!of_b, other, None);
            }
            _ => {}
        }
    }

    fn plant(&mut self, of_b: bool, place: DVec3, normal: Option<DVec3>) {
        if self.asked.asked.push_only || self.state.is_thick || !self.has_inside(of_b) {
            return;
        }
        let radius = 0.5 * self.size();
        let (center, foot) = match normal {
            Some(normal) => (place - normal * radius, Some((place, normal))),
            None => (place, None),
        };
        let left = QUESTIONS;
        let _ = self.state.seeds.try_push(Seed {
            of_b,
            center,
            radius,
            foot,
            left,
        });
    }

    /// Asks how large the ball of the last seed may be.
    pub(super) fn grow(&mut self) -> Step {
        let Some(seed) = self.state.seeds.last().copied() else {
            self.pay(64)?;
            self.state.task = match self.state.current {
                Some(_) => Task::Try(0, None),
                None => Task::Start,
            };
            return Ok(());
        };
        let tree = self.asked.tree(seed.of_b);
        let found = match Query::signed_distance(tree, seed.center) {
            Ok(query) => Some(self.ask(&query)?),
            Err(_) => None,
        };
        self.spend(400);
        self.state.seeds.pop();
        let Some((found, distance)) = found.and_then(|found| Some((found, found.distance?))) else {
            return Ok(());
        };
        let nearest = distance.point;
        let winding = found.winding.unwrap_or(0.0);
        let is_inside = winding > 0.0 || winding < 0.0 && !self.asked.asked.solid;
        // The distance is that of the thickened body: of its core minus the radius.
        let radius = tree.radius() * (1.0 + 4.0 * f64::EPSILON);
        let depth = if winding > 0.0 {
            -distance.high - radius
        } else {
            distance.low + tree.radius() * (1.0 - 4.0 * f64::EPSILON)
        };
        let next = match seed.foot {
            // The largest that touches the surface there, too.
            None => Some((0.5 * self.size(), nearest, unit(nearest - seed.center))),
            Some((foot, normal)) => {
                let chord = foot - nearest;
                let radius = chord.length_squared() / (2.0 * normal.dot(chord));
                let is_less = radius > 0.0 && radius < DONE * seed.radius;
                is_less.then_some((radius, foot, normal))
            }
        };
        if is_inside && (next.is_none() || seed.foot.is_none()) {
            let (place, radius) = if seed.of_b {
                let place = self.asked.asked.b_in_a.transform_point(seed.center);
                (place, depth * self.state.least_scale)
            } else {
                (seed.center, depth)
            };
            let of_b = seed.of_b;
            self.keep(Point {
                of_b,
                place,
                radius,
            });
        }
        if let Some((radius, foot, normal)) = next.filter(|_| seed.left > 0)
            && (is_inside || seed.foot.is_some())
        {
            let seed = Seed {
                center: foot - normal * radius,
                radius,
                foot: Some((foot, normal)),
                left: seed.left - 1,
                ..seed
            };
            let _ = self.state.seeds.try_push(seed);
        }
        Ok(())
    }
}

/// The corner of A (of B) that is deepest in the other body for a push along `direction`.
fn deepest(of_b: bool, corners: impl Iterator<Item = DVec3>, direction: DVec3) -> Option<DVec3> {
    let toward = if of_b { -direction } else { direction };
    corners.max_by(|p, q| p.dot(toward).total_cmp(&q.dot(toward)))
}

impl PenetrationQuery<'_> {
    fn tree(&self, of_b: bool) -> &Tree {
        if of_b { self.b } else { self.a }
    }

    /// The longest push at which a point of the other body inside A (inside B) proves that the
    /// bodies are not apart.
    ///
    /// For solids, any length. For surfaces, lengths at which another point of the same component
    /// stays outside, as a point far from the box does.
    pub(super) fn longest(&self, of_b: bool) -> f64 {
        let (body, other) = (self.tree(of_b), self.tree(!of_b));
        let (Some(inside), Some(solid)) = (body.solid(), other.solid()) else {
            return 0.0;
        };
        let pose = &self.asked.b_in_a;
        if !inside.is_closed() || pose.inverse().is_err() {
            return 0.0;
        }
        if self.asked.solid {
            return f64::INFINITY;
        }
        if solid.components().len() != 1 {
            return 0.0;
        }
        let bounds = if of_b {
            body.aabb_at(pose)
        } else {
            body.mesh().aabb()
        };
        let distance = |triangle: usize| {
            let [corner, ..] = other.mesh().triangle(triangle);
            let place = if of_b {
                corner
            } else {
                pose.transform_point(corner)
            };
            let outside = (bounds.min - place).max(place - bounds.max);
            punctual_geom::length(outside.max(DVec3::ZERO))
        };
        let count = other.mesh().len();
        let some = (0..count).step_by(count.div_ceil(SAMPLES).max(1));
        some.map(distance).fold(0.0, f64::max) * (1.0 - 1e-9)
    }
}
