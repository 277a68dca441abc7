//! Do two closed triangles share a point? Exact for all finite `f64` coordinates.
//!
//! Every decision is the sign of a determinant of coordinate differences: a volume (3 x 3) or an area (2 x 2).
//! Each sign is computed in `f64` first; a result below its proven error bound is computed again in integers
//! wide enough to hold it. One formula serves all number types, so no sign is ever wrong.
//!
//! A degenerate triangle is the hull of its three points: a segment or a point.
//!
//! Notation: a triangle's normal is `(t1 - t0) x (t2 - t0)`; a point is above its plane if the volume spanned by the
//! normal's two edges and the point is positive.

use core::array::from_fn;
use core::cell::OnceCell;
use core::ops::{Add, Mul, Sub};

use bnum::Int;
use bnum::cast::As;
use glam::DVec3;

type Triangle = [DVec3; 3];

/// Whether the closed triangles `a` and `b` share a point. All coordinates must be finite.
pub(crate) fn intersects(a: &Triangle, b: &Triangle) -> bool {
    let Some(pair) = Pair::with_touching_boxes(a, b) else {
        return false;
    };
    if a.iter().any(|p| b.contains(p)) {
        return true;
    }
    if pair.extent.min_element() == 0.0 {
        return pair.coplanar_meet(); // all six points in one axis-aligned plane
    }
    let a_sides = pair.volumes(b, *a);
    if strictly_one_sided(a_sides) {
        return false;
    }
    let b_sides = pair.volumes(a, *b);
    if strictly_one_sided(b_sides) {
        return false;
    }
    match (a_sides == [0; 3], b_sides == [0; 3]) {
        (false, false) => pair.crossing_meet(a_sides, b_sides),
        // Were `a` proper, `b` would lie in its plane; were `b` too, `a` would lie in the plane of `b`. So `a` is a segment.
        (false, true) => pair.segment_meets(a, a_sides, b),
        (true, false) => pair.segment_meets(b, b_sides, a),
        (true, true) => pair.coplanar_meet(),
    }
}

fn strictly_one_sided(sides: [i8; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}

/// Two triangles with touching boxes, and what the signs of their determinants need.
struct Pair<'a> {
    a: &'a Triangle,
    b: &'a Triangle,
    /// Extent of the box around both: no computed coordinate difference is larger.
    extent: DVec3,
    /// `extent`, padded against underflow; NaN if a determinant could overflow.
    reach: DVec3,
    grid: OnceCell<Grid>,
}

impl<'a> Pair<'a> {
    fn with_touching_boxes(a: &'a Triangle, b: &'a Triangle) -> Option<Self> {
        let (a_min, a_max) = (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
        let (b_min, b_max) = (b[0].min(b[1]).min(b[2]), b[0].max(b[1]).max(b[2]));
        if !(a_min.cmple(b_max) & b_min.cmple(a_max)).all() {
            return None;
        }
        let extent = a_max.max(b_max) - a_min.min(b_min);
        let reach = if extent.max_element() <= FILTER_LARGEST { extent + FILTER_PADDING } else { DVec3::NAN };
        Some(Pair { a, b, extent, reach, grid: OnceCell::new() })
    }

    /// Side of each point relative to the plane of `t`.
    fn volumes<const N: usize>(&self, t: &Triangle, points: [DVec3; N]) -> [i8; N] {
        let bound = VOLUME_BOUND * self.reach.x * self.reach.y * self.reach.z;
        let filtered = volumes(t.map(|p| p.to_array()), points.map(|p| p.to_array()));
        if filtered.iter().all(|v| v.abs() > bound) {
            return filtered.map(|v| sign(v, 0.0));
        }
        let grid = self.grid();
        match grid.bits {
            0..=40 => grid.volumes::<i128, N>(t, points),
            41..=125 => grid.volumes::<Int<48>, N>(t, points),
            126..=339 => grid.volumes::<Int<128>, N>(t, points),
            _ => grid.volumes::<Int<792>, N>(t, points),
        }
    }

    /// Side of `r` relative to the line `pq`, all projected along `axis`.
    fn area(&self, axis: usize, [p, q, r]: [DVec3; 3]) -> i8 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let bound = AREA_BOUND * self.reach[i] * self.reach[j];
        let filtered = area([p, q, r].map(|v| [v[i], v[j]]));
        if filtered.abs() > bound {
            return sign(filtered, 0.0);
        }
        let grid = self.grid();
        match grid.bits {
            0..=40 => grid.area::<i128>(i, j, [p, q, r]),
            41..=125 => grid.area::<Int<48>>(i, j, [p, q, r]),
            126..=339 => grid.area::<Int<128>>(i, j, [p, q, r]),
            _ => grid.area::<Int<792>>(i, j, [p, q, r]),
        }
    }

    fn grid(&self) -> &Grid {
        self.grid.get_or_init(|| Grid::new(self.a.iter().chain(self.b)))
    }

    fn crossing_meet(&self, a_sides: [i8; 3], b_sides: [i8; 3]) -> bool {
        let (i, a_up) = lone_vertex(a_sides);
        let (j, b_up) = lone_vertex(b_sides);
        let (mut a_next, mut a_last) = (self.a[(i + 1) % 3], self.a[(i + 2) % 3]);
        let (mut b_next, mut b_last) = (self.b[(j + 1) % 3], self.b[(j + 2) % 3]);
        if a_up < 0 {
            (b_next, b_last) = (b_last, b_next);
        }
        if b_up < 0 {
            (a_next, a_last) = (a_last, a_next);
        }
        let (a_lone, b_lone) = (self.a[i], self.b[j]);
        self.volumes(&[a_lone, a_next, b_lone], [b_next]) <= [0]
            && self.volumes(&[a_lone, a_last, b_lone], [b_last]) >= [0]
    }

    fn segment_meets(&self, s: &Triangle, sides: [i8; 3], t: &Triangle) -> bool {
        let (p, q) = if sides[0] != sides[1] { (s[0], s[1]) } else { (s[0], s[2]) };
        let turns: [i8; 3] = from_fn(|i| self.volumes(&[p, q, t[i]], [t[(i + 1) % 3]])[0]);
        !(turns.contains(&1) && turns.contains(&-1))
    }

    fn coplanar_meet(&self) -> bool {
        for axis in 0..3 {
            let (a_turn, b_turn) = (self.area(axis, *self.a), self.area(axis, *self.b));
            if a_turn != 0 || b_turn != 0 {
                return !self.separated(axis, self.a, a_turn, self.b) && !self.separated(axis, self.b, b_turn, self.a);
            }
        }
        let edges = |t: &Triangle| -> [(DVec3, DVec3); 3] {
            let t = *t;
            from_fn(|i| (t[i], t[(i + 1) % 3]))
        };
        let skew = edges(self.a)
            .iter()
            .any(|&(p, q)| edges(self.b).iter().any(|&(r, s)| self.volumes(&[p, q, r], [s]) != [0]));
        !skew && (0..3).all(|axis| !self.separated(axis, self.a, 0, self.b) && !self.separated(axis, self.b, 0, self.a))
    }

    /// Whether the line of an edge of `s` separates the triangles strictly, all projected along `axis`.
    fn separated(&self, axis: usize, s: &Triangle, turn: i8, t: &Triangle) -> bool {
        (0..3).any(|i| {
            let (p, q) = (s[i], s[(i + 1) % 3]);
            let side = self.area(axis, [p, q, t[0]]);
            side != 0 && side != turn && t[1..].iter().all(|&r| self.area(axis, [p, q, r]) == side)
        })
    }
}

fn lone_vertex(sides: [i8; 3]) -> (usize, i8) {
    let others = |i: usize| (sides[(i + 1) % 3], sides[(i + 2) % 3]);
    let lone = |&i: &usize| {
        let (q, r) = others(i);
        sides[i] != q && sides[i] != r
    };
    match (0..3).filter(|&i| sides[i] != 0).find(lone) {
        Some(i) => (i, sides[i]),
        None => {
            let i = (0..3).find(|&i| sides[i] == 0).unwrap_or(0);
            (i, -others(i).0)
        }
    }
}

const FILTER_PADDING: DVec3 = DVec3::splat(f64::from_bits((1023 - 300) << 52));
const FILTER_LARGEST: f64 = f64::from_bits((1023 + 300) << 52);
const VOLUME_BOUND: f64 = 32.0 * f64::EPSILON;
const AREA_BOUND: f64 = 8.0 * f64::EPSILON;

trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + PartialOrd {}
impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + PartialOrd> Number for T {}

fn difference<T: Number, const D: usize>(p: [T; D], q: [T; D]) -> [T; D] {
    from_fn(|i| p[i] - q[i])
}

#[inline(always)]
fn volumes<T: Number, const N: usize>(t: [[T; 3]; 3], points: [[T; 3]; N]) -> [T; N] {
    let (e, f) = (difference(t[1], t[0]), difference(t[2], t[0]));
    let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    points.map(|p| {
        let d = difference(p, t[0]);
        normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2]
    })
}

fn area<T: Number>([p, q, r]: [[T; 2]; 3]) -> T {
    let (e, f) = (difference(q, p), difference(r, p));
    e[0] * f[1] - e[1] * f[0]
}

fn sign<T: Number>(value: T, zero: T) -> i8 {
    (value > zero) as i8 - (value < zero) as i8
}

trait Exact: Number {
    fn scaled(mantissa: i64, shift: u32) -> Self;
}
impl Exact for i128 {
    fn scaled(mantissa: i64, shift: u32) -> Self {
        i128::from(mantissa) << shift
    }
}
impl<const N: usize> Exact for Int<N> {
    fn scaled(mantissa: i64, shift: u32) -> Self {
        mantissa.as_::<Self>() << shift
    }
}

/// The coarsest power-of-two grid that holds all coordinates of a pair.
struct Grid {
    low: i32,
    bits: u32,
}

impl Grid {
    fn new<'a>(points: impl Iterator<Item = &'a DVec3>) -> Self {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for value in points.flat_map(|p| p.to_array()) {
            let (mantissa, exponent) = split(value);
            if mantissa != 0 {
                low = low.min(exponent);
                high = high.max(exponent + 64 - mantissa.unsigned_abs().leading_zeros() as i32);
            }
        }
        Grid { low, bits: high.saturating_sub(low).max(0) as u32 }
    }

    fn coordinate<T: Exact>(&self, value: f64) -> T {
        let (mantissa, exponent) = split(value);
        let shift = if mantissa == 0 { 0 } else { (exponent - self.low) as u32 };
        T::scaled(mantissa, shift)
    }

    fn volumes<T: Exact, const N: usize>(&self, t: &Triangle, points: [DVec3; N]) -> [i8; N] {
        let on_grid = |p: DVec3| p.to_array().map(|v| self.coordinate::<T>(v));
        volumes(t.map(on_grid), points.map(on_grid)).map(|v| sign(v, T::scaled(0, 0)))
    }

    fn area<T: Exact>(&self, i: usize, j: usize, points: [DVec3; 3]) -> i8 {
        let on_grid = |p: DVec3| [p[i], p[j]].map(|v| self.coordinate::<T>(v));
        sign(area(points.map(on_grid)), T::scaled(0, 0))
    }
}

/// `value` as an odd (or zero) mantissa times a power of two.
fn split(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let biased = (bits >> 52 & 0x7ff) as i32;
    let hidden = u64::from(biased != 0) << 52;
    let magnitude = (bits & ((1 << 52) - 1) | hidden) as i64;
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = magnitude.trailing_zeros();
    let odd = magnitude >> zeros;
    (if value < 0.0 { -odd } else { odd }, biased.max(1) - 1075 + zeros as i32)
}
