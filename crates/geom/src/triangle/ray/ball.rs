//! A ball whose middle moves along a ray: when it first touches a triangle. This is where the ray
//! enters the triangle thickened by the radius of the ball.
//!
//! The distance of a triangle from a point on a line is a convex function of the parameter. At each
//! step a direction proves a lower bound of it that is linear in the parameter
//! ([`Closest::direction`]). The ball cannot touch before that bound reaches the radius; there is
//! the next parameter (Newton's method from the left). If the bound does not fall, the ball misses.
//!
//! [`Closest::direction`]: super::super::distance::Closest::direction

use super::super::distance::{closest_or_meeting, closest_to_point};
use super::Side;
use crate::{Ray, largest, length};
use glam::DVec3;

/// A ball on its way along a ray.
#[derive(Clone, Copy, Debug)]
pub struct MovingBall {
    origin: DVec3,
    /// Its largest component is 1.
    direction: DVec3,
    /// Largest component of the ray's direction.
    scale: f64,
    /// Lengths along the direction end here.
    end: f64,
    radius: f64,
}

/// The result of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BallStep {
    /// The ball touches first at this parameter of the ray.
    Touches(f64, Side),
    /// The ball touches nowhere.
    Misses,
    /// The ball does not touch before this length along its way.
    FreeUntil(f64),
}

/// A ball touches if it is no farther than this, relative to the largest coordinate of the triangle
/// as seen from the origin and to the radius: more than [`closest_to_point`] leaves open.
const TOUCHES: f64 = 1e-13;

/// Fraction of a step that is certain in spite of its rounding.
const CERTAIN: f64 = 1.0 - 8.0 * f64::EPSILON;

/// Directions closer to a plane than this, relative to both lengths, come from neither side.
const ALONG: f64 = 1e-14;

impl MovingBall {
    /// A ball along a ray.
    #[must_use]
    pub fn new(ray: &Ray, radius: f64) -> Self {
        let direction = ray.direction();
        let scale = largest(direction.abs());
        Self {
            origin: ray.origin(),
            direction: direction / scale,
            scale,
            end: if ray.is_segment() {
                scale
            } else {
                f64::INFINITY
            },
            radius,
        }
    }

    /// Advances towards a triangle from a length along the path before which the ball does not
    /// touch it. The second value is true if that took long. Constant time.
    #[must_use]
    pub fn step(&self, corners: &[DVec3; 3], from: f64) -> (BallStep, bool) {
        let corners = corners.map(|corner| corner - self.origin);
        let place = self.direction * from;
        let fast = closest_to_point(&corners, place);
        let found = match fast {
            Some(found) => found,
            None => closest_or_meeting(&corners, &[place; 3]),
        };
        let was_long = fast.is_none();
        let farthest = corners.map(|corner| largest(corner.abs()));
        let size = farthest[0].max(farthest[1]).max(farthest[2]) + self.radius;
        let gap = found.low - self.radius;
        if found.high - self.radius <= TOUCHES * size || gap <= 0.0 {
            return (self.touches(&corners, from), was_long);
        }
        // The direction leads from the point to the triangle.
        let closing = self.direction.dot(found.direction);
        if closing <= 0.0 {
            return (BallStep::Misses, was_long);
        }
        let next = from + gap / closing * CERTAIN;
        // No triangle is as far as a length that overflows.
        let step = if next > self.end || next == f64::INFINITY {
            BallStep::Misses
        } else if next > from {
            BallStep::FreeUntil(next)
        } else {
            self.touches(&corners, from)
        };
        (step, was_long)
    }

    fn touches(&self, [a, b, c]: &[DVec3; 3], at: f64) -> BallStep {
        let (u, v) = (*b - *a, *c - *a);
        let unit = length(u).max(length(v));
        let normal = (u / unit).cross(v / unit);
        let along = normal.dot(self.direction);
        let side = if along < -ALONG {
            Side::Front
        } else if along > ALONG {
            Side::Back
        } else {
            Side::Edge
        };
        let t = at / self.scale;
        let t = if self.end < f64::INFINITY {
            t.min(1.0)
        } else {
            t
        };
        BallStep::Touches(t, side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// The first touch by small steps of the ball, which the bounds of distances prove free.
    fn follow(ray: &Ray, corners: &[DVec3; 3], radius: f64) -> (Option<f64>, u32) {
        let ball = MovingBall::new(ray, radius);
        let (mut at, mut steps) = (0.0, 0);
        loop {
            steps += 1;
            match ball.step(corners, at).0 {
                BallStep::Touches(t, _) => return (Some(t), steps),
                BallStep::Misses => return (None, steps),
                BallStep::FreeUntil(next) => at = next,
            }
        }
    }

    #[test]
    fn a_ball_that_passes_far_away_misses() {
        let ray = Ray::new([-1e300, 0.0, 0.0], [1e-13, -1.0, 1e-300]).unwrap();
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from_array);
        assert_eq!(follow(&ray, &corners, 1.0).0, None);
    }

    #[test]
    fn a_ball_against_a_point_touches_where_the_quadratic_says() {
        let mut random = Random::new(3);
        let (mut hits, mut most) = (0, 0);
        for _ in 0..20_000 {
            let mut vector = |size: f64| {
                let [x, y, z] = [(); 3].map(|()| size * (2.0 * random.fraction() - 1.0));
                DVec3::new(x, y, z)
            };
            let (origin, direction, point) = (vector(3.0), vector(1.0), vector(1.0));
            let radius = vector(1.0).length();
            let ray = Ray::new(origin, direction).unwrap();
            let (found, steps) = follow(&ray, &[point; 3], radius);
            most = most.max(steps);
            let (to, square) = (point - origin, direction.length_squared());
            let along = to.dot(direction) / square;
            let root = along * along - (to.length_squared() - radius * radius) / square;
            let across = (to - direction * along).length();
            let starts = to.length() - radius;
            match found {
                Some(t) if starts <= 0.0 => assert_eq!(t, 0.0),
                Some(t) => {
                    hits += 1;
                    let off = (ray.at(t) - point).length() - radius;
                    assert!(off.abs() < 1e-12, "{off}");
                    let exact = along - root.max(0.0).sqrt();
                    let grazing = root.max(0.0).sqrt() * square.sqrt() < 1e-5;
                    assert!(
                        grazing || (t - exact).abs() * square.sqrt() < 1e-6,
                        "{t} {exact}"
                    );
                }
                None => assert!(across > radius - 1e-12 || along < 0.0, "{across} {radius}"),
            }
        }
        assert!(hits > 500 && most < 32, "{hits} hits, {most} steps");
    }

    #[test]
    fn a_ball_touches_faces_edges_and_corners_first() {
        let triangle = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let from = |x: f64, y: f64| {
            let ray = Ray::new([x, y, 10.0], [0.0, 0.0, -2.0]).unwrap();
            follow(&ray, &triangle, 0.5).0
        };
        assert!((from(1.0, 1.0).unwrap() - 4.75).abs() < 1e-12);
        assert!((from(1.0, -0.3).unwrap() - 4.8).abs() < 1e-12);
        assert!((from(-0.3, -0.4).unwrap() - 5.0).abs() < 1e-6);
        assert_eq!(from(-0.4, -0.4), None);
        let segment = Ray::segment([1.0, 1.0, 10.0], [1.0, 1.0, 0.6]).unwrap();
        assert_eq!(follow(&segment, &triangle, 0.5).0, None);
        let along = Ray::new([-9.0, 1.0, 0.2], [1.0, 0.0, 0.0]).unwrap();
        let at = follow(&along, &triangle, 0.5).0.unwrap();
        assert!((at - (9.0 - 0.21_f64.sqrt())).abs() < 1e-9);
        let step = MovingBall::new(&along, 0.5).step(&triangle, 9.0).0;
        assert_eq!(step, BallStep::Touches(9.0, Side::Edge));
    }
}
