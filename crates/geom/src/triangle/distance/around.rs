//! A point and eight triangles in `f32`: both bounds of the distance, proven.
//!
//! Coordinates are relative to the first point of a block, near which all others are.

use super::batch::{LARGEST_ERROR, LEAST_SQUARE, Pair, clamped, select};
use crate::lanes::{Column, F8, Lanes, V8, add, cross, dot, per_axis, scaled, sub};
use crate::tolerance::ROUNDING;
use crate::triangle::batch::{Placement, Rows, UNDERFLOW};

/// Eight triangles of B around a point of A.
pub struct Around<L: Lanes> {
    /// The first corners, and the edges from there.
    corner: V8<L>,
    edges: [V8<L>; 2],
    /// The edge between the other two corners.
    third: V8<L>,
    /// Inverse squared lengths of the three edges.
    inverse: [F8<L>; 3],
    /// Projection of the first edge on the third.
    turn: F8<L>,
    /// Normal of the faces, and the vectors whose dot products with a point are its coordinates
    /// along the two edges.
    normal: V8<L>,
    parts: [V8<L>; 2],
    /// As [`Pair::error`].
    error: V8<L>,
}

impl<L: Lanes> Around<L> {
    /// The triangles `b` of B around the point `a` of A, which is a triangle without extent.
    #[inline(always)]
    pub fn new(lanes: L, a: &Rows, b: [&Rows; 8], placement: &Placement) -> Self {
        let Pair { q, f, error, .. } = Pair::new(lanes, [a; 8], b, placement);
        let third = sub(f[1], f[0]);
        let inverse = |edge: V8<L>| {
            F8::splat(lanes, 1.0) / dot(edge, edge).max(F8::splat(lanes, LEAST_SQUARE))
        };
        let inverse = [inverse(f[0]), inverse(f[1]), inverse(third)];
        let x = scaled(f[0], inverse[0]);
        let normal = cross(x, f[1]);
        let area = F8::splat(lanes, 1.0) / dot(normal, normal).max(F8::splat(lanes, UNDERFLOW));
        Self {
            corner: q,
            edges: f,
            third,
            inverse,
            turn: dot(f[0], third),
            normal,
            parts: [
                scaled(cross(f[1], normal), area * inverse[0]),
                scaled(cross(normal, x), area),
            ],
            error,
        }
    }

    /// Proven lower and upper bounds of the distances of a point, given relative to the point of
    /// [`new`](Self::new), in A's units. The lower one is 0 if nothing is proven.
    #[inline(always)]
    pub fn bounds(&self, lanes: L, point: [f32; 3]) -> [F8<L>; 2] {
        let (zero, one) = (F8::splat(lanes, 0.0), F8::splat(lanes, 1.0));
        let [x, y] = self.edges;
        let point = per_axis!(k => F8::splat(lanes, point[k]));
        let to = sub(point, self.corner);
        let (at_x, at_y) = (dot(to, x), dot(to, y));
        let (s, t) = (dot(self.parts[0], to), dot(self.parts[1], to));
        let is_over = zero.less(s).and(zero.less(t)).and((s + t).less(one));
        let share = [
            clamped(lanes, at_x * self.inverse[0]),
            clamped(lanes, at_y * self.inverse[1]),
            clamped(lanes, (at_y - at_x - self.turn) * self.inverse[2]),
        ];
        let edges = [
            sub(to, scaled(x, share[0])),
            sub(to, scaled(y, share[1])),
            sub(to, add(x, scaled(self.third, share[2]))),
        ];
        let square = per_axis!(i => dot(edges[i], edges[i]));
        let (second, third) = (
            square[1].less(square[0]),
            square[2].less(square[0].min(square[1])),
        );
        let edge = select(third, edges[2], select(second, edges[1], edges[0]));
        let face = sub(to, add(scaled(x, s), scaled(y, t)));
        let (way, direction) = (
            select(is_over, face, edge),
            select(is_over, self.normal, edge),
        );

        // Both bounds share the error of a corner relative to the point.
        let error = per_axis!(k => {
            self.error[k] + (to[k].abs() + point[k].abs()) * F8::splat(lanes, 6.0 * ROUNDING)
        });
        let length = dot(way, way).sqrt() * F8::splat(lanes, 1.0 + 8.0 * ROUNDING);
        let high = length + (error[0] + error[1] + error[2]) * F8::splat(lanes, 4.0);

        let (at, at_x, at_y) = (dot(direction, to), dot(direction, x), dot(direction, y));
        let (least, most) = (zero.min(at_x).min(at_y), zero.max(at_x).max(at_y));
        let gap = (at - most).max(least - at);
        let sums = (most - least) + at.abs();
        let error = dot(per_axis!(k => direction[k].abs()), error)
            + sums * F8::splat(lanes, 2.51 * ROUNDING);
        let underflow = F8::splat(lanes, UNDERFLOW);
        let certain = gap - error - underflow;
        let length = (dot(direction, direction) + underflow).sqrt();
        // Also false if an operand is NaN.
        let is_proven = zero
            .less(certain)
            .and(error.less(F8::splat(lanes, LARGEST_ERROR)));
        let low = certain / length * F8::splat(lanes, 1.0 - 9.0 * ROUNDING);
        [is_proven.select(low, zero), high]
    }
}
