//! Exact signs of volumes (3x3 determinants of coordinate differences) and of areas (2x2).
//!
//! A sign comes from plain `f64` arithmetic if the result exceeds a proven error bound. Otherwise
//! the crate `robust` computes it again (adaptive floating-point expansions). Where its arithmetic
//! could overflow or underflow, the sign is that of a [`Sum`] of products.

use core::array::from_fn;

use glam::DVec3;
use robust::{Coord, Coord3D};

use super::sum::{Sum, Term, determinant, on_grid};

/// Signs of determinants of points in a box.
///
/// Error bounds: let E be the computed extents of the box, and e half the machine epsilon. Rounding
/// is monotone, so no computed difference exceeds E. A volume has 6 products of 3 differences, each
/// rounded at most 8 times (3 differences, 2 products, 3 sums), so its error is below
/// `6 * 8.1 e Ex Ey Ez`; the bound takes 64 for 48.6. An area has 2 products of 2 differences,
/// rounded 4 times, so its error is below `2 * 4.1 e Ei Ej`; the bound takes 16.
///
/// If E <= 2^300, nothing overflows. Underflow adds less than `2^-1071 (1 + max E)`, and less than
/// `2^-1016 (1 + max E)^2` if denormal numbers are flushed to zero. Each E is padded by 2^-300,
/// which adds more than that to the bounds.
pub(super) struct Signs {
    /// Padded extents. Infinite if a determinant might overflow, so that no `f64` result exceeds
    /// its bound.
    extent: DVec3,
}

pub const PADDING: f64 = f64::from_bits((1023 - 300) << 52);
pub const LARGEST_EXTENT: f64 = f64::from_bits((1023 + 300) << 52);
const VOLUME_BOUND: f64 = 32.0 * f64::EPSILON;
const AREA_BOUND: f64 = 8.0 * f64::EPSILON;

impl Signs {
    /// Signs for points in a box of this size.
    pub fn within(extent: DVec3) -> Self {
        let is_safe = extent.max_element() <= LARGEST_EXTENT;
        Self {
            extent: if is_safe {
                extent + PADDING
            } else {
                DVec3::INFINITY
            },
        }
    }

    /// Sides of the points relative to the plane of `t`: 1 on the side to which the normal
    /// `(t1 - t0) x (t2 - t0)` points.
    pub fn sides<const N: usize>(&self, t: &[DVec3; 3], points: &[DVec3; N]) -> [i8; N] {
        let bound = VOLUME_BOUND * self.extent.x * self.extent.y * self.extent.z;
        let volumes = volumes(t.map(|p| p.to_array()), points.map(|p| p.to_array()));
        from_fn(|i| match volumes[i] {
            volume if volume.abs() > bound => sign(volume),
            _ => exact_side([t[0], t[1], t[2], points[i]].map(|p| p.to_array())),
        })
    }

    /// Side of one point relative to a plane. This is also the side on which line `t0 t1` passes
    /// line `t2 point`.
    pub fn side(&self, t: [DVec3; 3], point: DVec3) -> i8 {
        self.sides(&t, &[point])[0]
    }

    /// Orientation of three points projected along `axis`: 1 if counterclockwise, seen against the
    /// axis.
    pub fn turn(&self, axis: usize, points: &[DVec3; 3]) -> i8 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let points = points.map(|p| [p[i], p[j]]);
        match area(points) {
            area if area.abs() > AREA_BOUND * self.extent[i] * self.extent[j] => sign(area),
            _ => exact_turn(points),
        }
    }

    /// Position of the plane of `t` along `p q`, as a fraction of the length. The points `p` and
    /// `q` are not strictly on one side of the plane, and not both in it. The error is less than
    /// `tolerance`, or a few roundings. So if `tolerance` is 1 or more, the result may be any
    /// fraction.
    pub fn share_to_plane(&self, t: &[DVec3; 3], [p, q]: [DVec3; 2], tolerance: f64) -> f64 {
        let bound = VOLUME_BOUND * self.extent.x * self.extent.y * self.extent.z;
        let points = [t[0], t[1], t[2], p, q].map(|p| p.to_array());
        let [from, to] = volumes([points[0], points[1], points[2]], [points[3], points[4]]);
        fast_share(from, to, bound, tolerance).unwrap_or_else(|| {
            let (points, width) = on_grid(points);
            let volume =
                |i: usize| exact_volume([&points[0], &points[1], &points[2], &points[i]], width);
            volume(3).share_of_sizes(&volume(4))
        })
    }

    /// Position of the line `r s` along `p q`, projected along `axis`, as a fraction of the length.
    /// The points `p` and `q` are strictly on different sides of the line. The error is that of
    /// [`share_to_plane`](Self::share_to_plane).
    pub fn share_to_line(
        &self,
        axis: usize,
        [r, s]: [DVec3; 2],
        [p, q]: [DVec3; 2],
        tolerance: f64,
    ) -> f64 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let points = [r, s, p, q].map(|p| [p[i], p[j]]);
        let [from, to] = [2, 3].map(|k: usize| area([points[0], points[1], points[k]]));
        fast_share(
            from,
            to,
            AREA_BOUND * self.extent[i] * self.extent[j],
            tolerance,
        )
        .unwrap_or_else(|| {
            let (points, width) = on_grid(points);
            let area = |k: usize| exact_area([&points[0], &points[1], &points[k]], width);
            area(2).share_of_sizes(&area(3))
        })
    }
}

/// Fraction of the way from `from` to `to` at which a value that changes linearly is zero. The two
/// numbers have different signs, and each has an error of at most `bound`. `None` if the error of
/// the fraction may reach `tolerance`. With errors `d` and `e` of the numbers, that error is `((1 -
/// share) d + share e) / span`.
fn fast_share(from: f64, to: f64, bound: f64, tolerance: f64) -> Option<f64> {
    let span = from - to;
    (bound < tolerance * span.abs()).then(|| (from / span).clamp(0.0, 1.0))
}

/// `det(t1 - t0, t2 - t0, p - t0)` of each point.
#[inline]
fn volumes<const N: usize>(t: [[f64; 3]; 3], points: [[f64; 3]; N]) -> [f64; N] {
    let from_t0 = |p: [f64; 3]| [p[0] - t[0][0], p[1] - t[0][1], p[2] - t[0][2]];
    let (e, f) = (from_t0(t[1]), from_t0(t[2]));
    let normal = [
        e[1] * f[2] - e[2] * f[1],
        e[2] * f[0] - e[0] * f[2],
        e[0] * f[1] - e[1] * f[0],
    ];
    points
        .map(from_t0)
        .map(|d| normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2])
}

/// `det(q - p, r - p)`.
#[inline]
fn area([p, q, r]: [[f64; 2]; 3]) -> f64 {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// True if `robust` is exact for these coordinates.
///
/// `robust` adds products of three differences. If all magnitudes are below 2^300, no product
/// exceeds 2^910. If all are zero or at least 2^-288, every coordinate is a multiple of 2^-340 and
/// every product a multiple of 2^-1020, above the least denormal 2^-1074. So nothing overflows or
/// underflows, and its error-free transformations are error-free.
fn is_safe(coordinates: &[f64]) -> bool {
    let in_range = |x: f64| {
        x.to_bits() << 1 == 0 || (1023 - 288..1023 + 300).contains(&(x.abs().to_bits() >> 52))
    };
    coordinates.iter().all(|&x| in_range(x))
}

/// True if all points share a coordinate, or if they are at most two points when seen along an
/// axis. Then they lie in a plane. This is common: it holds for corners on floors and walls, and
/// manufactured parts have many of those. Where copies of such parts coincide, it holds for nearly
/// all points whose sign is in doubt.
fn share_floor_or_wall(points: &[[f64; 3]; 4]) -> bool {
    (0..3).any(|i| {
        let [p, q, r, s] = points.map(|p| [p[i], p[(i + 1) % 3]]);
        let is_floor = q[0] == p[0] && r[0] == p[0] && s[0] == p[0];
        let other = if p != q { q } else { r };
        let known = |x| x == p || x == other;
        is_floor || known(r) && (known(s) || p == other)
    })
}

/// Sign of `det(p1 - p0, p2 - p0, p3 - p0)`.
fn exact_side(points: [[f64; 3]; 4]) -> i8 {
    if share_floor_or_wall(&points) {
        return 0;
    }
    if is_safe(points.as_flattened()) {
        let [p, q, r, s] = points.map(|[x, y, z]| Coord3D { x, y, z });
        // `robust` is positive below the plane, where the corners appear clockwise.
        return -sign(robust::orient3d(p, q, r, s));
    }
    let (points, width) = on_grid(points);
    exact_volume(points.each_ref(), width).sign()
}

/// `det(p1 - p0, p2 - p0, p3 - p0)` of points on a grid of this width.
fn exact_volume([p0, p1, p2, p3]: [&[Term; 3]; 4], width: u32) -> Sum {
    determinant([[p1, p0], [p2, p0], [p3, p0]], [0, 1, 2], width)
}

/// Sign of `det(p1 - p0, p2 - p0)`.
fn exact_turn(points: [[f64; 2]; 3]) -> i8 {
    if is_safe(points.as_flattened()) {
        let [p, q, r] = points.map(|[x, y]| Coord { x, y });
        return sign(robust::orient2d(p, q, r));
    }
    let (points, width) = on_grid(points);
    exact_area(points.each_ref(), width).sign()
}

/// `det(p1 - p0, p2 - p0)` of points on a grid of this width.
fn exact_area([p0, p1, p2]: [&[Term; 2]; 3], width: u32) -> Sum {
    determinant([[p1, p0], [p2, p0]], [0, 1], width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const TINY: f64 = f64::from_bits(1);

    #[test]
    fn filter_expansions_and_sums_agree() {
        let mut random = Random::new(1);
        let mut next = || (random.bits() % 9) as f64 - 4.0;
        for _ in 0..3000 {
            let points: [[f64; 3]; 4] = from_fn(|_| from_fn(|_| next()));
            let flat = [0, 1, 2].map(|i: usize| [points[i][1], points[i][2]]);
            let vectors = points.map(DVec3::from_array);
            let signs = Signs::within(DVec3::splat(8.0));
            let side = signs.side([vectors[0], vectors[1], vectors[2]], vectors[3]);
            let turn = signs.turn(0, &[vectors[0], vectors[1], vectors[2]]);
            // Scaling each axis by a power of two or a denormal does not change the signs.
            let power = |exponent: u64| f64::from_bits((1023 + exponent) << 52);
            for scale in [
                [1.0; 3],
                [1.0, 1.0 / power(900), power(800)],
                [TINY, power(1000), 0.25],
                [power(1020); 3],
            ] {
                assert_eq!(
                    exact_side(points.map(|p| from_fn(|i| p[i] * scale[i]))),
                    side,
                    "{points:?}"
                );
                assert_eq!(
                    exact_turn(flat.map(|p| from_fn(|i| p[i] * scale[i]))),
                    turn,
                    "{points:?}"
                );
            }
        }
    }

    #[test]
    fn floors_and_walls_are_flat() {
        let mut random = Random::new(1);
        let (mut flat, mut spatial) = (0, 0);
        for _ in 0..20_000 {
            let points: [[f64; 3]; 4] = from_fn(|_| from_fn(|_| (random.bits() % 3) as f64));
            let different = |seen: &dyn Fn([f64; 3]) -> [f64; 2]| {
                let seen = points.map(seen);
                (0..4).filter(|&i| !seen[..i].contains(&seen[i])).count()
            };
            let is_floor = |axis: usize| different(&|p| [p[axis], 0.0]) == 1;
            let is_wall = |axis: usize| different(&|p| [p[(axis + 1) % 3], p[(axis + 2) % 3]]) <= 2;
            let is_flat = (0..3).any(|axis| is_floor(axis) || is_wall(axis));
            assert_eq!(share_floor_or_wall(&points), is_flat, "{points:?}");
            let volume = sign(volumes([points[0], points[1], points[2]], [points[3]])[0]);
            assert_eq!(exact_side(points), volume, "{points:?}");
            flat += usize::from(is_flat);
            spatial += usize::from(volume != 0);
        }
        assert!(flat > 1000 && spatial > 1000, "{flat} {spatial}");
    }

    /// A regular tetrahedron and a right triangle in the corners of a cube: the largest volume and
    /// area of each width.
    #[test]
    fn largest_volumes_of_all_widths() {
        for exponent in 1..1024 {
            let below = f64::from_bits(((1024 + exponent) << 52) - 1); // all bits set
            for m in [
                f64::from_bits((1022 + exponent) << 52),
                (below / 2.0).trunc(),
                below / 2.0,
            ] {
                assert_eq!(
                    exact_side([[-m, -m, -m], [m, m, -m], [m, -m, m], [-m, m, m]]),
                    -1,
                    "{m:e}"
                );
                assert_eq!(
                    exact_side([[-m, -m, m], [m, m, m], [m, -m, -m], [-m, m, -m]]),
                    1,
                    "{m:e}"
                );
                assert_eq!(exact_turn([[-m, -m], [m, -m], [m, m]]), 1, "{m:e}");
            }
        }
    }

    /// Also covers the widest possible grid: the denormal decides all signs but the zeros.
    #[test]
    fn largest_and_least_values_together() {
        let (m, t) = (f64::MAX, TINY);
        assert_eq!(
            exact_side([[-m, -m, -m], [m, -m, t], [-m, m, t], [m, m, m]]),
            -1
        );
        assert_eq!(
            exact_side([[-m, -m, -m], [m, -m, -t], [-m, m, -t], [m, m, m]]),
            1
        );
        assert_eq!(
            exact_side([[-m, -m, -m], [m, -m, 0.0], [-m, m, 0.0], [m, m, m]]),
            0
        );
        assert_eq!(exact_side([[0.0; 3], [m, m, m], [t, t, t], [m, t, -m]]), 0);
        assert_eq!(exact_turn([[-m, -m], [m, m], [t, 0.0]]), -1);
        assert_eq!(exact_turn([[-m, -m], [m, m], [t, t]]), 0);
    }
}
