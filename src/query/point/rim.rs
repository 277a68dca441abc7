//! What the boundary of an open surface adds to the winding number.
//!
//! A cone over the boundary closes the surface. Its apex is infinitely far behind the ray, which
//! then crosses no triangle of the cone. So the winding number is what the ray counts, less the
//! solid angles of the cone, over `4 pi`. Seen from the point, an edge and the apex span a spherical
//! triangle. Let the ray go along `x`, let `p` and `r` be the ends as seen from the point, and let
//! `p_`, `r_` be their components across the ray, as unit vectors. Then half of the solid angle is
//! the argument of the complex number
//!
//! `tan(P/2) tan(R/2) + p_ . r_  -  i p_ x r_`,
//!
//! with `P`, `R` the angles to the ray. These numbers are multiplied, and whole turns are counted, so
//! there is one arc tangent a point. The argument jumps only where the ray passes an edge; there the
//! side on which it passes is decided exactly, as for the triangles that the ray crosses. The error
//! is some roundings an edge, and more only near the edge itself: `docs/numerics.md`.

use crate::math::lanes::{Column, D4, Lanes, per_axis};
use crate::math::{larger, largest};
use crate::mesh::Mesh;
use crate::triangle::crossing::{Heading, side};
use core::f64::consts::TAU;
use glam::DVec3;

/// A vertex of the boundary: the unit vector across the ray, and the tangent of half the angle to
/// the ray.
pub(super) type Seen = [f64; 3];

/// A point that looks at a boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewer {
    pub point: DVec3,
    pub heading: Heading,
    /// A power of two that brings the whole mesh within 2 of the point.
    scale: f64,
}

/// Squared length across the ray below which a vertex is looked at alone.
const LEAST_SQUARE: f64 = 1e-200;

impl Viewer {
    pub fn new(mesh: &Mesh, point: DVec3, heading: Heading) -> Self {
        let bounds = mesh.aabb();
        let reach = largest((bounds.max - point).abs().max((point - bounds.min).abs()));
        // 2^-e for the exponent e of the reach, or as near as possible.
        let exponent = (reach.to_bits() >> 52).clamp(1, 2045);
        Self {
            point,
            heading,
            scale: f64::from_bits((2046 - exponent) << 52),
        }
    }

    /// Four vertices.
    #[inline(always)]
    pub fn see<L: Lanes>(&self, lanes: L, vertices: [DVec3; 4]) -> [Seen; 4] {
        let Heading { axis, is_negative } = self.heading;
        let splat = |x: f64| D4::splat(lanes, x);
        let column = |axis: usize| {
            let axis = axis % 3;
            let [a, b, c, d] = vertices.map(|vertex| vertex[axis]);
            (D4::load(lanes, &[a, b, c, d]) - splat(self.point[axis])) * splat(self.scale)
        };
        let along = column(axis) * splat(if is_negative { -1.0 } else { 1.0 });
        let [y, z] = [column(axis + 1), column(axis + 2)];
        let square = y * y + z * z;
        let inverse = splat(1.0) / square.sqrt();
        let across = square * inverse;
        let length = (along * along + square).sqrt();
        let is_ahead = splat(0.0).less(along);
        let tangent =
            is_ahead.select(across, length - along) / is_ahead.select(length + along, across);
        let seen = per_axis!(k => [y * inverse, z * inverse, tangent][k].store());
        let low = square.less(splat(LEAST_SQUARE)).mask() as usize;
        core::array::from_fn(|i| {
            if low >> i & 1 != 0 {
                self.see_near_axis(vertices[i])
            } else {
                [seen[0][i], seen[1][i], seen[2][i]]
            }
        })
    }

    /// A vertex that is nearly or exactly on the line of the ray.
    #[cold]
    fn see_near_axis(&self, vertex: DVec3) -> Seen {
        let from = vertex - self.point;
        let Heading { axis, is_negative } = self.heading;
        let along = if is_negative { -from[axis] } else { from[axis] };
        let [y, z] = [from[(axis + 1) % 3], from[(axis + 2) % 3]];
        let size = larger(y.abs(), z.abs());
        if size > 0.0 {
            let [y, z] = [y / size, z / size];
            let length = libm::sqrt(y * y + z * z);
            let across = size * length;
            let whole = libm::hypot(along, across);
            let tangent = if along > 0.0 {
                across / (whole + along)
            } else {
                (whole - along) / across
            };
            [y / length, z / length, tangent]
        } else if along > 0.0 {
            // The ray is tilted towards the second axis, so the vertex is on the other side.
            [-1.0, 0.0, 0.0]
        } else {
            [1.0, 0.0, f64::INFINITY]
        }
    }

    /// Multiplies the number of an edge. `ends` are asked for only if the ray passes it closely.
    #[inline(always)]
    pub fn turn(&self, turn: &mut Turn, [p, r]: [Seen; 2], ends: impl Fn() -> [DVec3; 2]) {
        let sign = if self.heading.is_negative { -1.0 } else { 1.0 };
        let product = p[2] * r[2];
        let re = product + (p[0] * r[0] + p[1] * r[1]);
        let mut im = sign * (p[0] * r[1] - p[1] * r[0]);
        if re < 0.0 && im.abs() < CLOSE {
            let side = side(self.point, self.heading, ends());
            im = larger(im.abs(), LEAST) * f64::from(side);
        }
        // Infinite: the end is behind the point. No number: the point is on the edge.
        if re.abs() < f64::INFINITY {
            turn.multiply(re, im, 1.0 + product);
        }
    }
}

/// Bound of the error of the imaginary part of an edge, which decides its sign.
const CLOSE: f64 = 64.0 * f64::EPSILON;

/// Imaginary part of an edge that has none, so that it has a sign.
const LEAST: f64 = 1e-30;

/// A product of complex numbers, with the number of its whole turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    re: f64,
    im: f64,
    turns: i32,
    /// Largest square of an edge's error, in roundings.
    worst: f64,
    edges: u32,
}

impl Turn {
    pub const NONE: Self = Self {
        re: 1.0,
        im: 0.0,
        turns: 0,
        worst: 1.0,
        edges: 0,
    };

    /// Multiplies by a number whose error is some roundings of `size`.
    #[inline(always)]
    fn multiply(&mut self, re: f64, im: f64, size: f64) {
        let square = re * re + im * im;
        let error = size * size / square;
        // Also false for no number.
        self.worst = if error > self.worst {
            error
        } else {
            self.worst
        };
        self.edges += 1;
        let (old_re, old_im) = (self.re, self.im);
        let new = [old_re * re - old_im * im, old_re * im + old_im * re];
        // Twice in the left half turns past the negative axis, whatever the sign of a tiny
        // imaginary part.
        let is_left = old_re < 0.0 && re < 0.0;
        let (is_up, may_pass) = (old_im >= 0.0, old_re <= 0.0 || re <= 0.0);
        if is_up && im >= 0.0 && may_pass && (is_left || new[1] < 0.0) {
            self.turns += 1;
        } else if !is_up && im < 0.0 && may_pass && (is_left || new[1] >= 0.0) {
            self.turns -= 1;
        }
        let size = larger(new[0].abs(), new[1].abs());
        // A power of two; for zero and no numbers, nothing is multiplied.
        let scale = f64::from_bits((2046 << 52) - (size.to_bits() & 0x7ff << 52));
        if size > 1e-290 && size < 1e290 {
            (self.re, self.im) = (new[0] * scale, new[1] * scale);
        }
    }

    /// The part of the winding number, and a bound of its error.
    pub fn winding(&self) -> (f64, f64) {
        let angle = libm::atan2(self.im, self.re) / TAU + f64::from(self.turns);
        let error = 4.0 * f64::EPSILON * (f64::from(self.edges) + 1.0) * libm::sqrt(self.worst);
        (angle, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// Compares with the sum of the arguments.
    #[test]
    fn the_turns_of_a_product_are_those_of_the_sum_of_its_arguments() {
        let mut random = Random::new(3);
        for _ in 0..2000 {
            let (mut turn, mut sum) = (Turn::NONE, 0.0);
            for _ in 0..random.bits() % 40 {
                let angle = match random.bits() % 4 {
                    0 => core::f64::consts::PI * (1.0 - 1e-16 * random.fraction()),
                    1 => -core::f64::consts::PI * (1.0 - 1e-9 * random.fraction()),
                    _ => core::f64::consts::PI * (2.0 * random.fraction() - 1.0),
                };
                let size = libm::exp2(200.0 * random.fraction() - 100.0);
                let (im, re) = libm::sincos(angle);
                turn.multiply(size * re, size * im, 1.0);
                sum += libm::atan2(size * im, size * re);
            }
            assert!((turn.winding().0 - sum / TAU).abs() < 1e-13);
        }
    }
}
