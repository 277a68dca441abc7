//! Whether two closed triangles meet, decided by exact signs.
//!
//! Two closed triangles meet if and only if an edge of one meets the other triangle, coplanar ones included, as long as
//! one of them is no mere segment or point; two of those meet if and only if two of their edges do. So six segment-triangle
//! tests, or nine segment-segment tests, decide, and those need only the signs of determinants: [`orient3d`] and
//! [`orient2d`], from crate `robust` where its arithmetic can neither overflow nor underflow, else from wide integers.
//! The answer depends on signs alone, so it cannot change when triangles are swapped or corners turned.

use bnum::Int;
use bnum::cast::CastFrom;
use core::cmp::Ordering::{self, Equal};
use glam::DVec3;
use robust::{Coord, Coord3D};

/// Whether two closed triangles share a point; a degenerate triangle is the hull of its corners.
pub(super) fn intersects(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    if a.iter().any(|p| b.contains(p)) {
        return true;
    }
    let least = |t: &[DVec3; 3]| t[0].min(t[1]).min(t[2]);
    let most = |t: &[DVec3; 3]| t[0].max(t[1]).max(t[2]);
    if least(a).cmpgt(most(b)).any() || least(b).cmpgt(most(a)).any() {
        return false;
    }
    match Scale::of(a, b) {
        Scale::Safe => Exact { signs: &Robust }.meet(a, b),
        Scale::By(factor) => Exact { signs: &Robust }.meet(&a.map(|p| p * factor), &b.map(|p| p * factor)),
        Scale::Wide => Exact { signs: &WideIntegers }.meet(a, b),
    }
}

/// Which arithmetic is exact for the given coordinates.
enum Scale {
    Safe,
    By(f64),
    Wide,
}

/// Biased exponents of 2^300 and 2^-288.
///
/// `robust` computes with sums of products of three differences. With all magnitudes below 2^300 no product exceeds
/// 2^910; with all of them zero or at least 2^-288, every coordinate is a multiple of 2^-340 and every product one of
/// 2^-1020, above the least denormal 2^-1074: nothing overflows or underflows, so its error-free transformations are
/// error-free.
const LARGEST: i64 = 1023 + 300;
const LEAST: i64 = 1023 - 288;

impl Scale {
    fn of(a: &[DVec3; 3], b: &[DVec3; 3]) -> Self {
        let (largest, least) = exponents(a, b);
        if largest < LARGEST && least >= LEAST {
            return Self::Safe;
        }
        // As large as allowed: so that 2^299 <= the largest magnitude < 2^300, unless all are denormal.
        let shift = (LARGEST - 1 - largest).min(1023);
        let factor = f64::from_bits(((1023 + shift) as u64) << 52);
        let (_, scaled_least) = exponents(&a.map(|p| p * factor), &b.map(|p| p * factor));
        // Scaled up, nothing is lost; scaled down, nothing that stays as large as this.
        if scaled_least >= LEAST && (shift >= 0 || least + shift >= LEAST) { Self::By(factor) } else { Self::Wide }
    }
}

/// Biased exponents of the largest and the least magnitude, zeros left aside.
fn exponents(a: &[DVec3; 3], b: &[DVec3; 3]) -> (i64, i64) {
    let (mut largest, mut least) = (0, u64::MAX);
    for x in a.iter().chain(b).flat_map(|p| p.to_array()) {
        let magnitude = x.to_bits() << 1;
        largest = largest.max(magnitude);
        // Zero wraps around to the top; nothing else changes its exponent but powers of two, by one step down.
        least = least.min(magnitude.wrapping_sub(1));
    }
    ((largest >> 53) as i64, (least >> 53) as i64)
}

/// Exact signs of determinants.
trait Signs {
    /// Side of the plane through `a`, `b`, `c` on which `d` lies.
    fn orient3d(&self, a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering;
    /// Side of the line through `a`, `b` on which `c` lies, without coordinate `axis`.
    fn orient2d(&self, axis: usize, a: DVec3, b: DVec3, c: DVec3) -> Ordering;
}

fn drop_axis(axis: usize, p: DVec3) -> [f64; 2] {
    [p[(axis + 1) % 3], p[(axis + 2) % 3]]
}

struct Robust;

impl Signs for Robust {
    fn orient3d(&self, a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering {
        let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
        robust::orient3d(coord(a), coord(b), coord(c), coord(d)).total_cmp_zero()
    }

    fn orient2d(&self, axis: usize, a: DVec3, b: DVec3, c: DVec3) -> Ordering {
        let coord = |p: DVec3| {
            let [x, y] = drop_axis(axis, p);
            Coord { x, y }
        };
        robust::orient2d(coord(a), coord(b), coord(c)).total_cmp_zero()
    }
}

trait TotalCmpZero {
    fn total_cmp_zero(self) -> Ordering;
}

impl TotalCmpZero for f64 {
    /// The sign; zeros of both signs are `Equal`.
    fn total_cmp_zero(self) -> Ordering {
        if self > 0.0 {
            Ordering::Greater
        } else if self < 0.0 {
            Ordering::Less
        } else {
            Equal
        }
    }
}

/// Integers in units of the least denormal, for any finite coordinates up to 2^1003: a difference has at most 2,079 bits,
/// a determinant of three by three 6,240 of these 6,528. Some 20 us a sign, for spreads beyond 10^170 only.
struct WideIntegers;

type Wide = Int<816>;

impl WideIntegers {
    fn integer(x: f64) -> Wide {
        let bits = x.to_bits();
        let (exponent, fraction) = (bits >> 52 & 0x7ff, bits & ((1 << 52) - 1));
        let magnitude = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        let magnitude = Wide::cast_from(magnitude) << exponent.saturating_sub(1) as u32;
        if x < 0.0 { -magnitude } else { magnitude }
    }

    fn difference(a: DVec3, b: DVec3) -> [Wide; 3] {
        [0, 1, 2].map(|k| Self::integer(a[k]) - Self::integer(b[k]))
    }
}

impl Signs for WideIntegers {
    fn orient3d(&self, a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering {
        let [a, b, c] = [a, b, c].map(|p| Self::difference(p, d));
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        (a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)).cmp(&Wide::cast_from(0u8))
    }

    fn orient2d(&self, axis: usize, a: DVec3, b: DVec3, c: DVec3) -> Ordering {
        let [a, b] = [a, b].map(|p| Self::difference(p, c));
        let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
        (a[x] * b[y] - a[y] * b[x]).cmp(&Wide::cast_from(0u8))
    }
}

/// The tests, over one kind of signs.
struct Exact<'s, S> {
    signs: &'s S,
}

impl<S: Signs> Exact<'_, S> {
    fn meet(&self, a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
        match (self.shadow(a), self.shadow(b)) {
            (Some(axis_a), Some(axis_b)) => self.surfaces_meet(a, axis_a, b, axis_b),
            (Some(axis), None) => edges(b).any(|edge| self.segment_meets(edge, a, axis, self.sides(a, edge))),
            (None, Some(axis)) => edges(a).any(|edge| self.segment_meets(edge, b, axis, self.sides(b, edge))),
            (None, None) => edges(a).any(|e| edges(b).any(|f| self.segments_meet(e, f))),
        }
    }

    /// An axis along which the triangle casts a shadow with area; `None` if it has none itself.
    fn shadow(&self, [a, b, c]: &[DVec3; 3]) -> Option<usize> {
        (0..3).find(|&axis| self.signs.orient2d(axis, *a, *b, *c) != Equal)
    }

    fn surfaces_meet(&self, a: &[DVec3; 3], axis_a: usize, b: &[DVec3; 3], axis_b: usize) -> bool {
        let of_b = b.map(|p| self.signs.orient3d(a[0], a[1], a[2], p));
        if one_side(of_b) {
            return false;
        }
        let of_a = a.map(|p| self.signs.orient3d(b[0], b[1], b[2], p));
        if one_side(of_a) {
            return false;
        }
        let turn = |sides: [Ordering; 3], i: usize| [sides[i], sides[(i + 1) % 3]];
        edges(b).enumerate().any(|(i, edge)| self.segment_meets(edge, a, axis_a, turn(of_b, i)))
            || edges(a).enumerate().any(|(i, edge)| self.segment_meets(edge, b, axis_b, turn(of_a, i)))
    }

    fn sides(&self, t: &[DVec3; 3], edge: [DVec3; 2]) -> [Ordering; 2] {
        edge.map(|p| self.signs.orient3d(t[0], t[1], t[2], p))
    }

    /// Whether a closed segment, with its ends on the given sides of the plane, meets a triangle with area.
    fn segment_meets(&self, [p, q]: [DVec3; 2], t: &[DVec3; 3], axis: usize, sides: [Ordering; 2]) -> bool {
        match sides {
            [Equal, Equal] => self.coplanar_segment_meets([p, q], t, axis),
            [start, end] if start == end => false,
            // The line meets the plane in one point, which lies in the triangle if the line passes no two edges on
            // different sides.
            _ => !mixed(edges(t).map(|[a, b]| self.signs.orient3d(p, q, a, b))),
        }
    }

    /// The same in the plane of the triangle, seen along `axis`.
    fn coplanar_segment_meets(&self, [p, q]: [DVec3; 2], t: &[DVec3; 3], axis: usize) -> bool {
        let inside = |p: DVec3| !mixed(edges(t).map(|[a, b]| self.signs.orient2d(axis, a, b, p)));
        inside(p) || inside(q) || edges(t).any(|edge| self.shadows_meet(axis, [p, q], edge))
    }

    /// Two closed segments in space. If they are coplanar and not all on one line, they meet where their shadows meet
    /// along an axis that does not flatten their plane, and points in common have common shadows along all. On one line,
    /// shadows along the axes meet together unless the line is parallel to the axis, where they are points that always
    /// meet.
    fn segments_meet(&self, [p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> bool {
        self.signs.orient3d(p, q, r, s) == Equal && (0..3).all(|axis| self.shadows_meet(axis, [p, q], [r, s]))
    }

    /// Two closed segments in the plane without coordinate `axis`.
    fn shadows_meet(&self, axis: usize, [p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> bool {
        let turn = |a, b, c| self.signs.orient2d(axis, a, b, c);
        let (r_side, s_side) = (turn(p, q, r), turn(p, q, s));
        let (p_side, q_side) = (turn(r, s, p), turn(r, s, q));
        if [r_side, s_side, p_side, q_side] == [Equal; 4] {
            // All on one line: their extents overlap on both coordinates.
            return (1..3).all(|k| {
                let k = (axis + k) % 3;
                p[k].min(q[k]) <= r[k].max(s[k]) && r[k].min(s[k]) <= p[k].max(q[k])
            });
        }
        let apart = |a: Ordering, b: Ordering| a == b && a != Equal;
        !apart(r_side, s_side) && !apart(p_side, q_side)
    }
}

fn edges(t: &[DVec3; 3]) -> impl Iterator<Item = [DVec3; 2]> {
    let [a, b, c] = *t;
    [[a, b], [b, c], [c, a]].into_iter()
}

/// Whether all are strictly on the same side.
fn one_side(sides: [Ordering; 3]) -> bool {
    sides[0] != Equal && sides[0] == sides[1] && sides[0] == sides[2]
}

/// Whether two are strictly on different sides.
fn mixed(mut sides: impl Iterator<Item = Ordering>) -> bool {
    let mut first = Equal;
    sides.any(|side| {
        first = if first == Equal { side } else { first };
        side != Equal && side != first
    })
}
