//! Intersects rays with triangles: eight triangles at a time in `f32` to find certain misses
//! ([`batch`]), then one at a time in `f64`, with exact signs where those are in doubt.
//!
//! A line that is not parallel to a triangle's plane meets the triangle if it passes no two of its
//! edges on different sides. The side on which it passes an edge depends on the edge alone, and is
//! decided exactly. So no ray slips through between two triangles that share an edge or a corner.
//! Proof of the bounds: `docs/numerics.md`, "Rays".

pub mod ball;
pub mod batch;

use super::exact::line::Line;
use super::exact::{LARGEST_EXTENT, PADDING};
use crate::{Ray, larger, largest, smaller};
use core::array::from_fn;
use glam::DVec3;

/// The side of a triangle that a ray comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Side {
    /// The side from which the corners appear counterclockwise.
    Front,
    /// The side from which the corners appear clockwise.
    Back,
    /// Neither: the ray lies in the triangle's plane, or the triangle is a segment or a point.
    Edge,
}

crate::named!(Side { Front => "front", Back => "back", Edge => "edge" });

/// A ray prepared for tests in `f64`.
#[derive(Clone, Copy, Debug)]
pub struct Aim<'q> {
    pub ray: &'q Ray,
    /// The direction times `unit`; its largest component is between 1 and 2.
    pub direction: DVec3,
    /// log2 of the number by which the direction was divided.
    pub exponent: i32,
    unit: f64,
    /// Relative error bound of a determinant; infinite if the range of `f64` does not suffice.
    bound: f64,
}

/// Error of a determinant of three vectors, relative to the sum of the magnitudes of its six
/// products: `docs/numerics.md`.
const BOUND: f64 = 5.0 * f64::EPSILON;

/// Largest error of a hit for which `f64` suffices, relative to the largest coordinate of the
/// triangle as seen from the ray's origin.
const TOLERANCE: f64 = 1e-11;

/// Largest magnitude of the exponent of a direction for which `f64` suffices.
pub const EXPONENTS: i32 = 300;

impl<'q> Aim<'q> {
    #[inline(always)]
    pub fn new(ray: &'q Ray) -> Self {
        let direction = ray.direction();
        let exponent = (largest(direction.abs()).to_bits() >> 52) as i32 - 1023;
        let is_plain = exponent.abs() <= EXPONENTS;
        let unit = if is_plain {
            f64::from_bits(((1023 - exponent) as u64) << 52)
        } else {
            1.0
        };
        let bound = if is_plain { BOUND } else { f64::INFINITY };
        Self {
            ray,
            direction: direction * unit,
            exponent,
            unit,
            bound,
        }
    }

    /// True if the direction is within the range for which `f64` suffices.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.bound < f64::INFINITY
    }

    /// The first point that ray and triangle share, as its parameter and the side that the ray
    /// comes from; `None` if there is none within the limits. The last value is true if exact
    /// arithmetic was needed. `faces` is the side on which the line passes all three edges, if
    /// known.
    #[inline(always)]
    pub fn hit(&self, corners: &[DVec3; 3], faces: Option<i8>) -> (Option<(f64, Side)>, bool) {
        let mut exact = Exact {
            ray: self.ray,
            corners,
            line: None,
        };
        let found = self.first(corners, faces, &mut exact);
        let [t_min, t_max] = self.ray.limits();
        (
            found.filter(|&(t, _)| t_min <= t && t <= t_max),
            exact.line.is_some(),
        )
    }

    #[inline(always)]
    fn first(
        &self,
        corners: &[DVec3; 3],
        faces: Option<i8>,
        exact: &mut Exact,
    ) -> Option<(f64, Side)> {
        let d = self.direction;
        let origin = self.ray.origin();
        let [a, b, c] = [
            corners[0] - origin,
            corners[1] - origin,
            corners[2] - origin,
        ];
        let [e, f, g] = [
            corners[1] - corners[0],
            corners[2] - corners[1],
            corners[0] - corners[2],
        ];
        let reach = sizes(a, b, c) + DVec3::splat(PADDING);
        let extent = sizes(e, f, g) + DVec3::splat(PADDING);
        let size = d.abs() + DVec3::splat(PADDING);
        let farthest = largest(reach);
        let bound = if farthest <= LARGEST_EXTENT {
            self.bound
        } else {
            f64::INFINITY
        };

        let faces = match faces {
            Some(faces) => faces,
            None => {
                let passes = [d.dot(a.cross(e)), d.dot(b.cross(f)), d.dot(c.cross(g))];
                match sides(passes, bound * size.dot(products(reach, extent)), exact)? {
                    0 => return exact.line().t_in_plane().map(|t| (t, Side::Edge)),
                    faces => faces,
                }
            }
        };

        let normal = e.cross(-g);
        let (above, along) = (normal.dot(a), normal.dot(d));
        let square = products(extent, extent);
        let (above_error, along_error) = (bound * reach.dot(square), bound * size.dot(square));
        if sign(above, above_error).unwrap_or_else(|| exact.line().above()) == -faces {
            return None;
        }
        if self.ray.is_segment() {
            let left = along / self.unit - above;
            let error = along_error / self.unit + 2.0 * above_error;
            // `left` is the distance of the end from the plane, along the normal. If it has the
            // sign of `along`, the end lies after the plane.
            if sign(left, error).unwrap_or_else(|| -exact.line().above_end()) == -faces {
                return None;
            }
        }
        let t = above / along;
        // If the range of `f64` does not suffice, the errors are infinite. The right-hand side may
        // then be infinite too, so the comparison is strict.
        let is_close =
            above_error + t.abs() * along_error < 0.4 * TOLERANCE * along.abs() * farthest;
        let t = if is_close {
            t * self.unit
        } else {
            exact.line().t()
        };
        let t = if self.ray.is_segment() { t.min(1.0) } else { t };
        // Adding 0.0 removes a minus zero, which would be a different answer for the same point.
        Some((
            t.max(0.0) + 0.0,
            if faces < 0 { Side::Front } else { Side::Back },
        ))
    }
}

/// The exact line of a ray, created when first needed.
struct Exact<'q> {
    ray: &'q Ray,
    corners: &'q [DVec3; 3],
    line: Option<Line>,
}

impl Exact<'_> {
    #[cold]
    fn line(&mut self) -> &Line {
        let Self { ray, corners, line } = self;
        line.get_or_insert_with(|| Line::new(ray, corners))
    }
}

/// The side on which a line passes the edges of a triangle: 1 or -1. 0 if the line passes no edge
/// on a side; `None` if it passes two edges on different sides. `passes` has one determinant per
/// edge, with an error of at most `error`.
#[inline(always)]
fn sides(passes: [f64; 3], error: f64, exact: &mut Exact) -> Option<i8> {
    let least = smaller(smaller(passes[0], passes[1]), passes[2]);
    let most = larger(larger(passes[0], passes[1]), passes[2]);
    match (most > error, least < -error) {
        (true, true) => None,
        (true, false) if least > error => Some(1),
        (false, true) if most < -error => Some(-1),
        _ => {
            let sides: [i8; 3] =
                from_fn(|i| sign(passes[i], error).unwrap_or_else(|| exact.line().side(i)));
            match (sides.contains(&1), sides.contains(&-1)) {
                (true, true) => None,
                (one, other) => Some(i8::from(one) - i8::from(other)),
            }
        }
    }
}

/// The sign of a value with an error of at most `error`; `None` if it is uncertain.
#[inline(always)]
fn sign(value: f64, error: f64) -> Option<i8> {
    if value > error {
        Some(1)
    } else if value < -error {
        Some(-1)
    } else {
        None
    }
}

/// The largest magnitude of each component.
#[inline(always)]
fn sizes(u: DVec3, v: DVec3, w: DVec3) -> DVec3 {
    let most = |x: f64, y: f64, z: f64| larger(larger(x.abs(), y.abs()), z.abs());
    DVec3::new(
        most(u.x, v.x, w.x),
        most(u.y, v.y, w.y),
        most(u.z, v.z, w.z),
    )
}

/// For each component of a cross product, the sum of the magnitudes of its two products. The
/// vectors have the magnitudes `u` and `v`.
#[inline(always)]
fn products(u: DVec3, v: DVec3) -> DVec3 {
    DVec3::new(
        u.y * v.z + u.z * v.y,
        u.z * v.x + u.x * v.z,
        u.x * v.y + u.y * v.x,
    )
}
