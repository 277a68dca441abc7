//! What the boundary of an open surface adds to the winding number.
//!
//! A cone over the boundary closes the surface. Its apex is infinitely far behind the ray, which
//! then crosses no triangle of the cone. So the winding number is what the ray counts, less the
//! solid angles of the cone, over `4 pi`. Seen from the point, an edge and the apex span a
//! spherical triangle. Let the ray go along `x`, let `p` and `r` be the ends as seen from the
//! point, and let `p_`, `r_` be their components across the ray, as unit vectors. Then half of the
//! solid angle is the argument of the complex number
//!
//! `tan(P/2) tan(R/2) + p_ . r_  +  i p_ x r_`,
//!
//! with `P`, `R` the angles to the ray; it may be multiplied by any positive number. These numbers
//! are multiplied, in four lanes, and whole turns are counted, so there is one arc tangent a lane.
//! The argument jumps only where the ray passes an edge; there the side on which it passes is
//! decided exactly, as for the triangles that the ray crosses. The error is some roundings an edge,
//! and more only near the edge itself: `docs/numerics.md`.

use crate::mesh::Mesh;
use core::f64::consts::TAU;
use glam::DVec3;
use punctual_geom::lanes::{Column, D4, Lanes, per_axis, unrolled};
use punctual_geom::triangle::crossing::{Heading, side};
use punctual_geom::{bits, larger, largest};

/// A vertex of the boundary: a vector across the ray, and its length times the tangent of half the
/// angle to the ray.
pub(super) type Seen = [f64; 3];

/// A point that looks at a boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewer {
    pub point: DVec3,
    pub heading: Heading,
    /// A power of two that brings the whole mesh within 2 of the point.
    scale: f64,
}

/// Square of a part of a vector below which a vertex is visited alone.
const LEAST_SQUARE: f64 = 1e-100;

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

    /// Four vertices. Let `l` be the length of a vector, `x` its part along the ray and `v` that
    /// across. The numbers are `(l + x) v` and `v . v` if `x > 0`, else `v` and `l - x`. Neither
    /// loses digits.
    #[inline(always)]
    pub fn see<L: Lanes>(&self, lanes: L, vertices: [DVec3; 4]) -> [Seen; 4] {
        let Heading { axis, is_negative } = self.heading;
        let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
        let [a, b, c, d] = unrolled!(i in [0, 1, 2, 3] => vertices[i].to_array());
        let (point, scale) = (self.point.to_array(), D4::splat(lanes, self.scale));
        let [along, y, z] = per_axis!(k => {
            let axis = axes[k] % 3;
            (D4::load(lanes, &[a[axis], b[axis], c[axis], d[axis]]) - D4::splat(lanes, point[axis])) * scale
        });
        let along = along * D4::splat(lanes, if is_negative { -1.0 } else { 1.0 });
        let square = y * y + z * z;
        let length = (along * along + square).sqrt();
        let is_ahead = D4::splat(lanes, 0.0).less(along);
        let factor = is_ahead.select(length + along, D4::splat(lanes, 1.0));
        let tangent = is_ahead.select(square, length - along).store();
        let (y, z) = ((y * factor).store(), (z * factor).store());
        let mut seen = unrolled!(i in [0, 1, 2, 3] => [y[i], z[i], tangent[i]]);
        let least = D4::splat(lanes, LEAST_SQUARE);
        let is_close = square.less(least).and(is_ahead);
        let is_close = is_close.or((along * along).less(least).and(square.less(least)));
        for i in bits(is_close.mask()) {
            seen[i % 4] = self.see_close(vertices[i % 4]);
        }
        seen
    }

    /// A vertex ahead that is nearly or exactly on the ray, or one that is very close.
    #[cold]
    fn see_close(&self, vertex: DVec3) -> Seen {
        let from = (vertex - self.point) * self.scale;
        let largest = largest(from.abs());
        if largest == 0.0 {
            return [0.0; 3];
        }
        let (from, Heading { axis, is_negative }) = (from / largest, self.heading);
        let along = if is_negative { -from[axis] } else { from[axis] };
        let [y, z] = [from[(axis + 1) % 3], from[(axis + 2) % 3]];
        let size = larger(y.abs(), z.abs());
        if along <= 0.0 {
            let length = libm::sqrt(along * along + (y * y + z * z));
            [y, z, length - along]
        } else if size > 0.0 {
            let [y, z] = [y / size, z / size];
            let square = y * y + z * z;
            let length = libm::hypot(along, size * libm::sqrt(square));
            [y, z, size * square / (length + along)]
        } else {
            // The ray is tilted towards the second axis, so the vertex is on the other side.
            [-1.0, 0.0, 0.0]
        }
    }

    /// Multiplies the numbers of at most four edges. `ends` are asked for if the ray passes an edge
    /// closely.
    #[inline(always)]
    pub fn turn<L: Lanes>(
        &self,
        lanes: L,
        turn: &mut Turn,
        edges: &[[u32; 2]],
        seen: &[Seen],
        ends: impl Fn([u32; 2]) -> [DVec3; 2],
    ) {
        let (zero, one) = (D4::splat(lanes, 0.0), D4::splat(lanes, 1.0));
        // Written out: vectors are slow in closures.
        let [e, f, g, h] = unrolled!(i in [0, 1, 2, 3] => match edges.get(i) {
            Some(&[from, to]) => [&seen[from as usize], &seen[to as usize]],
            // Multiplies by 1.
            None => [&[1.0, 0.0, 0.0]; 2],
        });
        let p = per_axis!(k => D4::load(lanes, &[e[0][k], f[0][k], g[0][k], h[0][k]]));
        let r = per_axis!(k => D4::load(lanes, &[e[1][k], f[1][k], g[1][k], h[1][k]]));
        let [tangents, y, z] = [p[2] * r[2], p[0] * r[0], p[1] * r[1]];
        let [left, right] = [p[0] * r[1], p[1] * r[0]];
        let re = tangents + (y + z);
        let sign = D4::splat(lanes, if self.heading.is_negative { -1.0 } else { 1.0 });
        let mut im = (left - right) * sign;
        let across = left.abs() + right.abs();
        let is_close = re.less(zero).and(
            im.abs()
                .less(across * D4::splat(lanes, CLOSE) + D4::splat(lanes, LEAST)),
        );
        if is_close.mask() != 0 {
            let mut parts = im.store();
            for lane in bits(is_close.mask()).filter(|&lane| lane < edges.len()) {
                let side = side(self.point, self.heading, ends(edges[lane]));
                parts[lane] = larger(parts[lane].abs(), LEAST) * f64::from(side);
            }
            im = D4::load(lanes, &parts);
        }
        let size = tangents + (y.abs() + z.abs()) + across;
        turn.multiply([re, im], size, [zero, one]);
        turn.edges += edges.len() as u32;
    }
}

/// Bound of the error of the imaginary part of an edge, relative to its two products.
const CLOSE: f64 = 64.0 * f64::EPSILON;

/// Imaginary part of an edge that has none, so that it has a sign.
const LEAST: f64 = 1e-150;

/// Four products of complex numbers, with the numbers of their whole turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    re: [f64; 4],
    im: [f64; 4],
    turns: [f64; 4],
    /// Largest square of an edge's error, in roundings.
    worst: [f64; 4],
    edges: u32,
}

impl Turn {
    pub const NONE: Self = Self {
        re: [1.0; 4],
        im: [0.0; 4],
        turns: [0.0; 4],
        worst: [1.0; 4],
        edges: 0,
    };

    /// Multiplies the product; the error of each factor is a few roundings of `size`.
    #[inline(always)]
    fn multiply<L: Lanes>(&mut self, [re, im]: [D4<L>; 2], size: D4<L>, [zero, one]: [D4<L>; 2]) {
        let lanes = zero.lanes();
        let square = re * re + im * im;
        // No number has no argument: the point is on the edge.
        let is_number = zero.less(square);
        let (re, im) = (is_number.select(re, one), is_number.select(im, zero));
        let error = (size * size) / square;
        self.worst = D4::load(lanes, &self.worst).max(error).store();

        let (old_re, old_im) = (D4::load(lanes, &self.re), D4::load(lanes, &self.im));
        let new = [old_re * re - old_im * im, old_re * im + old_im * re];
        // Twice in the left half turns past the negative axis, whatever the sign of a tiny
        // imaginary part; twice in the right half never does.
        let is_left = old_re.less(zero).and(re.less(zero));
        let is_right = zero.less(old_re).and(zero.less(re));
        let (was_below, is_below) = (old_im.less(zero), im.less(zero));
        let now_below = new[1].less(zero);
        let up = is_below.select(zero, is_left.or(now_below).and(one));
        let down = is_below.select(now_below.select(is_left.and(one), one), zero);
        let turned = is_right.select(zero, was_below.select(-down, up));
        self.turns = (D4::load(lanes, &self.turns) + turned).store();

        let size = new[0].abs().max(new[1].abs());
        let power = size.and(D4::splat(lanes, f64::INFINITY));
        self.re = (new[0] / power).store();
        self.im = (new[1] / power).store();
    }

    /// The part of the winding number, and a bound of its error.
    pub fn winding(&self) -> (f64, f64) {
        // The sum makes a zero positive: the turns are counted for an argument of pi, not of -pi.
        let angle = |i: usize| libm::atan2(self.im[i] + 0.0, self.re[i]) / TAU + self.turns[i];
        let worst = self
            .worst
            .iter()
            .fold(1.0, |worst, &one| larger(worst, one));
        let error = 2.0 * f64::EPSILON * (f64::from(self.edges) + 4.0) * libm::sqrt(worst);
        ((angle(0) + angle(1)) + (angle(2) + angle(3)), error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;
    use punctual_geom::lanes::{Instructions, Kernel};
    use punctual_geom::random::Random;

    struct Multiply<'t>(&'t mut Turn, [[f64; 4]; 2]);

    impl Kernel for Multiply<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) {
            let Self(turn, [re, im]) = self;
            let [zero, one] = [0.0, 1.0].map(|x| D4::splat(lanes, x));
            turn.multiply(
                [D4::load(lanes, &re), D4::load(lanes, &im)],
                one,
                [zero, one],
            );
        }
    }

    /// Compares with the sum of the arguments.
    #[test]
    fn the_turns_of_a_product_are_those_of_the_sum_of_its_arguments() {
        let mut random = Random::new(3);
        for instructions in [Instructions::detect(), Instructions::PORTABLE] {
            for _ in 0..2000 {
                let (mut turn, mut sum) = (Turn::NONE, 0.0);
                for _ in 0..random.bits() % 40 {
                    let [mut real, mut imaginary] = [[0.0; 4]; 2];
                    for (real, imaginary) in real.iter_mut().zip(&mut imaginary) {
                        let angle = match random.bits() % 6 {
                            0 => PI * (1.0 - 1e-16 * random.fraction()),
                            1 => -PI * (1.0 - 1e-9 * random.fraction()),
                            2 => 0.5 * PI * (random.bits() % 3) as f64 - 0.5 * PI,
                            _ => PI * (2.0 * random.fraction() - 1.0),
                        };
                        let size = libm::exp2(200.0 * random.fraction() - 100.0);
                        let (im, re) = libm::sincos(angle);
                        (*real, *imaginary) = (size * re, size * im);
                        sum += libm::atan2(size * im, size * re);
                    }
                    instructions.run(Multiply(&mut turn, [real, imaginary]));
                }
                assert!((turn.winding().0 - sum / TAU).abs() < 1e-13);
            }
        }
    }

    /// Whole turns of exact quarters: every product is on an axis.
    #[test]
    fn quarter_turns_are_counted_exactly() {
        for quarter in [1.0, -1.0] {
            let mut turn = Turn::NONE;
            for i in 1..=9 {
                Instructions::PORTABLE.run(Multiply(&mut turn, [[0.0; 4], [quarter; 4]]));
                assert_eq!(turn.winding().0, quarter * f64::from(i));
            }
        }
    }
}
