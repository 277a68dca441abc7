//! Bounds from two known features, four pairs at a time in `f64`. The features are those that `f32`
//! found closest.
//!
//! Both bounds follow from the two features as for [one pair](super::pair). If other features are
//! closer, or numbers are out of range, the bounds are not tight. Then there is no result, and the
//! caller uses [`closest`](super::closest).

use super::pair::{Closest, TIGHT};
use crate::lanes::{Column, D4, Kernel, Lanes, add, cross, dot, per_axis, scaled, sub};
use glam::DVec3;

/// The closest features of two triangles: an edge of each, or a face and a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Features {
    /// For A and for B, the index of an [order](ORDERS) that begins with the corners of the edge,
    /// or with the corner. Any index, if the feature is the face.
    pub orders: [u8; 2],
    pub face: Face,
}

impl Features {
    pub const ANY: Self = Self {
        orders: [0; 2],
        face: Face::Nobodys,
    };
}

/// The triangle that has the face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    Nobodys,
    Of { side: u8 },
}

/// Orders of corners. Orders 0, 1 and 2 begin with an edge each; [eight pairs](super::batch) have
/// their edges in this sequence. Orders 0, 2 and 3 begin with corners 0, 1 and 2.
const ORDERS: [[usize; 3]; 4] = [[0, 1, 2], [0, 2, 1], [1, 2, 0], [2, 0, 1]];

/// Four pairs of triangles, indexed by triangle, corner, axis, pair. The corners of the feature
/// come first in each triangle. The triangle with the face comes first in each pair.
pub struct Four {
    corners: [[[[f64; 4]; 3]; 3]; 2],
    /// 1 if a face is one of the features, else 0.
    faces: [f64; 4],
    /// Bit mask of the pairs whose face is B's. In these, B is the first triangle.
    turned: u32,
}

impl Four {
    /// A single pair, in lane 0.
    #[inline]
    pub fn one(features: Features, triangles: [&[DVec3; 3]; 2]) -> Self {
        let mut four = Self::NONE;
        four.set(0, features, triangles);
        four
    }

    pub const NONE: Self = Self {
        corners: [[[[0.0; 4]; 3]; 3]; 2],
        faces: [0.0; 4],
        turned: 0,
    };

    #[inline]
    pub fn set(&mut self, pair: usize, features: Features, triangles: [&[DVec3; 3]; 2]) {
        // The remainder lets the compiler omit bounds checks.
        let pair = pair % 4;
        let is_turned = features.face == Face::Of { side: 1 };
        self.faces[pair] = if features.face == Face::Nobodys {
            0.0
        } else {
            1.0
        };
        self.turned |= u32::from(is_turned) << pair;
        for (i, to) in self.corners.iter_mut().enumerate() {
            let side = i ^ usize::from(is_turned);
            let (triangle, order) = (triangles[side], &ORDERS[features.orders[side] as usize % 4]);
            for (to, &corner) in to.iter_mut().zip(order) {
                let corner = triangle[corner];
                (to[0][pair], to[1][pair], to[2][pair]) = (corner.x, corner.y, corner.z);
            }
        }
    }
}

/// Results for four pairs.
pub struct Found {
    points: [[[f64; 4]; 3]; 2],
    direction: [[f64; 4]; 3],
    low: [f64; 4],
    high: [f64; 4],
    /// Bit mask of the pairs that have a result.
    known: u32,
    turned: u32,
}

impl Found {
    /// Result of one pair, as [`closest`](super::closest) would give it; `None` if there is none.
    #[inline]
    pub fn of(&self, pair: usize) -> Option<Closest> {
        let pair = pair % 4;
        if self.known >> pair & 1 == 0 {
            return None;
        }
        let vector = |[x, y, z]: &[[f64; 4]; 3]| DVec3::new(x[pair], y[pair], z[pair]);
        let (first, second, direction) = (
            vector(&self.points[0]),
            vector(&self.points[1]),
            vector(&self.direction),
        );
        let is_turned = self.turned >> pair & 1 != 0;
        let (points, direction) = if is_turned {
            ([second, first], -direction)
        } else {
            ([first, second], direction)
        };
        Some(Closest {
            points,
            direction,
            low: self.low[pair],
            high: self.high[pair],
            is_tight: true,
        })
    }
}

type V4<L> = [D4<L>; 3];

/// Bounds of the reach of a pair. Beyond them, products of four lengths may leave the range of
/// `f64`.
const LARGEST: f64 = 1e60;
const LEAST: f64 = 1e-60;

/// Bounds of the squared length of a direction. Between them, neither underflow nor overflow has
/// spoilt the direction.
const LEAST_SQUARE: f64 = 1e-270;
const LARGEST_SQUARE: f64 = 1e270;

/// Squared sine below which two edges have no perpendicular direction.
const PARALLEL: f64 = 1e-12;

impl Kernel for &Four {
    type Output = Found;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Found {
        let [a, b] = &self.corners;
        let origin: V4<L> = per_axis!(k => D4::load(lanes, &a[0][k]));
        let p: [V4<L>; 2] = [
            per_axis!(k => D4::load(lanes, &a[1][k]) - origin[k]),
            per_axis!(k => D4::load(lanes, &a[2][k]) - origin[k]),
        ];
        let q: [V4<L>; 3] = per_axis!(i => per_axis!(k => D4::load(lanes, &b[i][k]) - origin[k]));
        let reach = per_axis!(k => p[0][k].abs().max(p[1][k].abs()) + q[0][k].abs().max(q[1][k].abs()).max(q[2][k].abs()));

        let mut linked = Linked::edges(lanes, p[0], [q[0], q[1]]);
        let zero = D4::splat(lanes, 0.0);
        let is_face = zero.less(D4::load(lanes, &self.faces));
        if is_face.mask() != 0 {
            linked = Linked::select(is_face, Linked::face(lanes, p, q[0]), linked);
        }

        let Linked {
            points: [on_a, on_b],
            direction: n,
            valid,
        } = linked;
        let (low, direction) = gap(lanes, p, q, reach, n);
        let between = sub(on_a, on_b);
        let length = dot(reach, reach).sqrt();
        let rounding = length * D4::splat(lanes, 3.01 * f64::EPSILON);
        let high =
            (dot(between, between).sqrt() + rounding) * D4::splat(lanes, 1.0 + 3.0 * f64::EPSILON);
        let largest = reach[0].max(reach[1]).max(reach[2]);
        let fits = D4::splat(lanes, LEAST)
            .less(largest)
            .and(largest.less(D4::splat(lanes, LARGEST)));
        let is_tight = zero
            .less(low)
            .and((high - low).less(length * D4::splat(lanes, TIGHT)));
        let points = [add(origin, on_a), add(origin, on_b)];
        Found {
            points: [
                per_axis!(k => points[0][k].store()),
                per_axis!(k => points[1][k].store()),
            ],
            direction: per_axis!(k => direction[k].store()),
            low: low.store(),
            high: high.store(),
            known: is_tight.and(fits).and(valid).mask(),
            turned: self.turned,
        }
    }
}

#[inline(always)]
fn select<L: Lanes>(mask: D4<L>, a: V4<L>, b: V4<L>) -> V4<L> {
    per_axis!(k => mask.select(a[k], b[k]))
}

/// Clamps `x` to 0..=1; NaN becomes 0.
#[inline(always)]
fn clamped<L: Lanes>(lanes: L, x: D4<L>) -> D4<L> {
    let (zero, one) = (D4::splat(lanes, 0.0), D4::splat(lanes, 1.0));
    x.and(zero.less(x)).min(one)
}

/// Closest points of two features, relative to the first corner of the first triangle, and the
/// direction that separates the features.
struct Linked<L: Lanes> {
    points: [V4<L>; 2],
    direction: V4<L>,
    /// Mask: the points lie on the features.
    valid: D4<L>,
}

impl<L: Lanes> Linked<L> {
    #[inline(always)]
    fn select(mask: D4<L>, a: Self, b: Self) -> Self {
        let points = [
            select(mask, a.points[0], b.points[0]),
            select(mask, a.points[1], b.points[1]),
        ];
        let direction = select(mask, a.direction, b.direction);
        Self {
            points,
            direction,
            valid: mask.select(a.valid, b.valid),
        }
    }

    /// Closest points of two edges, computed as for [one pair](super::pair). One edge is `d` from
    /// the origin, the other leads from `o` to `end`.
    #[inline(always)]
    fn edges(lanes: L, d: V4<L>, [o, end]: [V4<L>; 2]) -> Self {
        let (zero, one) = (D4::splat(lanes, 0.0), D4::splat(lanes, 1.0));
        let e = sub(end, o);
        let across = cross(d, e);
        let (area, d_square, e_square) = (dot(across, across), dot(d, d), dot(e, e));
        let (d_e, d_o, e_o) = (dot(d, e), dot(d, o), dot(e, o));
        let s = clamped(lanes, dot(cross(o, e), across) / area);
        let t = clamped(lanes, (d_e * s - e_o) / e_square);
        let s = clamped(lanes, (d_e * t + d_o) / d_square);
        let points = [scaled(d, s), add(scaled(o, one - t), scaled(end, t))];
        let between = sub(points[0], points[1]);

        let (d_inside, e_inside) = (zero.less(s).and(s.less(one)), zero.less(t).and(t.less(one)));
        let is_skew = d_inside
            .and(e_inside)
            .and((d_square * e_square * D4::splat(lanes, PARALLEL)).less(area));
        let (along, square) = (select(d_inside, d, e), d_inside.select(d_square, e_square));
        let share = (dot(between, along) / square).and(d_inside.or(e_inside));
        let direction = select(is_skew, across, sub(between, scaled(along, share)));
        Self {
            points,
            direction,
            valid: zero.less(one),
        }
    }

    /// Closest points of a face and a corner. The face has the edges `x` and `y` from the origin.
    /// The result is valid if the foot of the corner lies inside the face.
    #[inline(always)]
    fn face(lanes: L, [x, y]: [V4<L>; 2], corner: V4<L>) -> Self {
        let (zero, one) = (D4::splat(lanes, 0.0), D4::splat(lanes, 1.0));
        let normal = cross(x, y);
        let area = dot(normal, normal);
        let (s, t) = (
            dot(cross(y, normal), corner) / area,
            dot(cross(normal, x), corner) / area,
        );
        let valid = zero.less(s).and(zero.less(t)).and((s + t).less(one));
        Self {
            points: [add(scaled(x, s), scaled(y, t)), corner],
            direction: normal,
            valid,
        }
    }
}

/// Proven gap between the projections on a line along `n`, and the unit vector along `n` that
/// points from the second triangle to the first. The gap is 0 if none is proven.
#[inline(always)]
fn gap<L: Lanes>(lanes: L, p: [V4<L>; 2], q: [V4<L>; 3], reach: V4<L>, n: V4<L>) -> (D4<L>, V4<L>) {
    let (zero, one) = (D4::splat(lanes, 0.0), D4::splat(lanes, 1.0));
    let (x, y) = (dot(p[0], n), dot(p[1], n));
    let [u, v, w] = per_axis!(i => dot(q[i], n));
    let above = zero.min(x).min(y) - u.max(v).max(w);
    let below = u.min(v).min(w) - zero.max(x).max(y);
    let error = dot(per_axis!(k => n[k].abs()), reach) * D4::splat(lanes, 2.01 * f64::EPSILON)
        + D4::splat(lanes, 1e-300);
    let gap = above.max(below) - error;
    let square = dot(n, n);
    let inverse = one / square.sqrt();
    let is_proven = zero
        .less(gap)
        .and(D4::splat(lanes, LEAST_SQUARE).less(square))
        .and(square.less(D4::splat(lanes, LARGEST_SQUARE)));
    let low = (gap * inverse * D4::splat(lanes, 1.0 - 4.0 * f64::EPSILON)).and(is_proven);
    let towards_a = below.less(above).select(inverse, -inverse);
    (low, scaled(n, towards_a))
}
