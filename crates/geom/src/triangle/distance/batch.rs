//! Eight pairs at a time in `f32`. Coordinates are relative to the first corners of A's triangles.
//! This subtraction cancels, so it is done in `f64`.

use crate::lanes::{Column, F8, Lanes, V8, add, cross, dot, per_axis, scaled, sub};
use crate::tolerance::ROUNDING;
use crate::triangle::batch::{
    EDGE_ERROR, Placement, Rows, Transposed, UNDERFLOW, first_corner, rotate,
};

/// Bounds of the distances of eight pairs, in A's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Proven lower bound: no two points of the triangles are closer. 0 if nothing is proven.
    pub low: [f32; 8],
    /// Approximate distance of the closest features. Not proven, and meaningless if the triangles
    /// meet.
    pub about: [f32; 8],
    /// Direction from B to A along which `low` is proven, of any length; per axis.
    pub direction: [[f32; 8]; 3],
    /// Where the closest features are, of A and of B.
    pub places: [Places; 2],
}

/// Points of eight triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// The edge from the first corner to the second (0), from the first to the third (1), or from
    /// the second to the third (2); 3 inside the face.
    pub edge: [f32; 8],
    /// The part of the edge before the point, from 0 to 1.
    pub along: [f32; 8],
}

/// The distances of `a[i]` and `b[i]` for the eight lanes.
#[inline(always)]
pub fn distances<L: Lanes>(
    lanes: L,
    a: [&Rows; 8],
    b: [&Rows; 8],
    placement: &Placement,
) -> Distances {
    let pair = Pair::new(lanes, a, b, placement);
    let (p, q, f) = (pair.p, pair.q, pair.f);
    let zero = [F8::splat(lanes, 0.0); 3];
    let (of_a, of_b) = (edges(lanes, zero, p), edges(lanes, q, f));
    let mut closest = closest_edges(lanes, &of_a, &of_b);
    let (one, two) = (add(q, f[0]), add(q, f[1]));
    closest.or_face(lanes, 0, p, of_a[0].inverse, [q, one, two]);
    closest.or_face(
        lanes,
        1,
        f,
        of_b[0].inverse,
        [sub(zero, q), sub(p[0], q), sub(p[1], q)],
    );
    let (low, is_above) = pair.gap(lanes, closest.direction);
    let direction = per_axis!(k => {
        is_above.select(closest.direction[k], zero[k] - closest.direction[k]).store()
    });
    Distances {
        low: low.store(),
        about: closest.square.sqrt().store(),
        direction,
        places: [
            Places {
                edge: closest.places[0][0].store(),
                along: closest.places[0][1].store(),
            },
            Places {
                edge: closest.places[1][0].store(),
                along: closest.places[1][1].store(),
            },
        ],
    }
}

/// Least squared length of an edge (A's units squared). Shorter edges have no known length; their
/// squared length is raised to this.
pub(super) const LEAST_SQUARE: f32 = 1e-28;
/// 2^90. If the error bound of a gap is less than this, no term of the gap is near overflow.
pub(super) const LARGEST_ERROR: f32 = f32::from_bits((127 + 90) << 23);

/// `a` where the mask is set, else `b`.
#[inline(always)]
pub(super) fn select<L: Lanes>(mask: F8<L>, a: V8<L>, b: V8<L>) -> V8<L> {
    per_axis!(k => mask.select(a[k], b[k]))
}

/// The larger magnitude per component.
#[inline(always)]
fn reach<L: Lanes>([a, b]: [V8<L>; 2]) -> V8<L> {
    per_axis!(k => a[k].abs().max(b[k].abs()))
}

/// Clamps `x` to 0..=1.
#[inline(always)]
pub(super) fn clamped<L: Lanes>(lanes: L, x: F8<L>) -> F8<L> {
    x.max(F8::splat(lanes, 0.0)).min(F8::splat(lanes, 1.0))
}

/// Two masks: the second value is less than the first; the third is less than both others.
#[inline(always)]
fn least<L: Lanes>([a, b, c]: [F8<L>; 3]) -> [F8<L>; 2] {
    [b.less(a), c.less(a.min(b))]
}

/// Eight pairs of triangles relative to A's first corners.
pub struct Pair<L: Lanes> {
    /// Edges of A from its first corner.
    pub p: [V8<L>; 2],
    /// B's first corner, and its edges from there.
    pub q: V8<L>,
    pub f: [V8<L>; 2],
    /// The error bound of a gap along a direction is the dot product of this vector with the
    /// magnitudes of the direction's components.
    pub error: V8<L>,
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    pub fn new(lanes: L, a: [&Rows; 8], b: [&Rows; 8], placement: &Placement) -> Self {
        let (a, b) = (Transposed::new(lanes, a), Transposed::new(lanes, b));
        let q = first_corner(lanes, &a, &b, placement);
        let p = [a.edge1, a.edge2];
        let rotation = &placement.rotation;
        let f = [
            rotate(lanes, rotation, b.edge1),
            rotate(lanes, rotation, b.edge2),
        ];
        let (reach_p, reach_f, reach_b) = (reach(p), reach(f), reach([b.edge1, b.edge2]));
        let absolute = F8::splat(
            lanes,
            placement.position_error + ROUNDING * (placement.edge_error + EDGE_ERROR),
        );
        let error = per_axis!(k => {
            let turned = dot(per_axis!(j => F8::splat(lanes, rotation[k][j].abs())), reach_b);
            (reach_p[k] + q[k].abs()) * F8::splat(lanes, 2.51 * ROUNDING)
                + (reach_f[k] + turned) * F8::splat(lanes, 3.52 * ROUNDING)
                + absolute
        });
        Self { p, q, f, error }
    }

    /// Proven gap between the projections on a line along `n`, which may have any length; 0 if none
    /// is proven. The mask is set if `n` points from B to A.
    #[inline(always)]
    fn gap(&self, lanes: L, n: V8<L>) -> (F8<L>, F8<L>) {
        let (zero, underflow) = (F8::splat(lanes, 0.0), F8::splat(lanes, UNDERFLOW));
        let (a1, a2) = (dot(self.p[0], n), dot(self.p[1], n));
        let (b0, b1, b2) = (dot(self.q, n), dot(self.f[0], n), dot(self.f[1], n));
        let (a_low, a_high) = (zero.min(a1).min(a2), zero.max(a1).max(a2));
        let (b_low, b_high) = (zero.min(b1).min(b2), zero.max(b1).max(b2));
        let (above, below) = (a_low - (b0 + b_high), (b0 + b_low) - a_high);
        let gap = above.max(below);
        let sums = (a_high - a_low) + (b_high - b_low) + b0.abs();
        let error =
            dot(per_axis!(k => n[k].abs()), self.error) + sums * F8::splat(lanes, 2.51 * ROUNDING);
        let certain = gap - error - underflow;
        let length = (dot(n, n) + underflow).sqrt();
        // Also false if an operand is NaN.
        let is_proven = zero
            .less(certain)
            .and(error.less(F8::splat(lanes, LARGEST_ERROR)));
        let low = certain / length * F8::splat(lanes, 1.0 - 9.0 * ROUNDING);
        (is_proven.select(low, zero), below.less(above))
    }
}

/// The closest features so far.
struct Closest<L: Lanes> {
    /// Squared distance.
    square: F8<L>,
    /// Direction that separates the triangles at these features, up to its sign and length.
    direction: V8<L>,
    /// The edge of A and of B, and the fraction along it ([`Places`]).
    places: [[F8<L>; 2]; 2],
}

/// An edge of eight triangles.
struct Edge<L: Lanes> {
    start: V8<L>,
    step: V8<L>,
    /// `|step|^2`, and its inverse.
    square: F8<L>,
    inverse: F8<L>,
}

/// The three edges of each triangle, given its first corner and the edges `x` and `y` that begin
/// there.
#[inline(always)]
fn edges<L: Lanes>(lanes: L, corner: V8<L>, [x, y]: [V8<L>; 2]) -> [Edge<L>; 3] {
    [
        Edge::new(lanes, corner, x),
        Edge::new(lanes, corner, y),
        Edge::new(lanes, add(corner, x), sub(y, x)),
    ]
}

impl<L: Lanes> Edge<L> {
    #[inline(always)]
    fn new(lanes: L, start: V8<L>, step: V8<L>) -> Self {
        let square = dot(step, step).max(F8::splat(lanes, LEAST_SQUARE));
        Self {
            start,
            step,
            square,
            inverse: F8::splat(lanes, 1.0) / square,
        }
    }

    /// Closest points of this edge and another. Solves for the lines and clamps to this edge.
    /// Projects that point on the other edge and clamps it, then projects back on this edge and
    /// clamps again.
    #[inline(always)]
    fn link(&self, lanes: L, other: &Self) -> Link<L> {
        let (d, e) = (self.step, other.step);
        let from = sub(self.start, other.start);
        let (d_from, d_e) = (dot(d, from), dot(d, e));
        let (on_e, ratio) = (dot(e, from) * other.inverse, d_e * other.inverse);
        let determinant = (self.square - d_e * ratio).max(F8::splat(lanes, LEAST_SQUARE));
        let s = clamped(lanes, (d_e * on_e - d_from) / determinant);
        let t = clamped(lanes, ratio * s + on_e);
        let s = clamped(lanes, (d_e * t - d_from) * self.inverse);
        let between = sub(add(from, scaled(d, s)), scaled(e, t));
        Link {
            s,
            t,
            between,
            square: dot(between, between),
        }
    }
}

/// The closest points of two edges: their parameters along the edges, and their difference.
struct Link<L: Lanes> {
    s: F8<L>,
    t: F8<L>,
    between: V8<L>,
    square: F8<L>,
}

impl<L: Lanes> Link<L> {
    #[inline(always)]
    fn select(mask: F8<L>, a: &Self, b: &Self) -> Self {
        Self {
            s: mask.select(a.s, b.s),
            t: mask.select(a.t, b.t),
            between: select(mask, a.between, b.between),
            square: mask.select(a.square, b.square),
        }
    }
}

/// The closest pair of edges, one of each triangle.
#[inline(always)]
fn closest_edges<L: Lanes>(lanes: L, a: &[Edge<L>; 3], b: &[Edge<L>; 3]) -> Closest<L> {
    let links = per_axis!(i => per_axis!(j => a[i].link(lanes, &b[j])));
    let squares =
        per_axis!(i => links[i][0].square.min(links[i][1].square).min(links[i][2].square));
    let [second, third] = least(squares);
    let of_edge = per_axis!(j => Link::select(third, &links[2][j], &Link::select(second, &links[1][j], &links[0][j])));
    let d = select(third, a[2].step, select(second, a[1].step, a[0].step));
    let d_square = third.select(a[2].square, second.select(a[1].square, a[0].square));
    let edge_a = number(lanes, [second, third]);
    let [second, third] = least(per_axis!(j => of_edge[j].square));
    let link = Link::select(
        third,
        &of_edge[2],
        &Link::select(second, &of_edge[1], &of_edge[0]),
    );
    let e = select(third, b[2].step, select(second, b[1].step, b[0].step));
    let edge_b = number(lanes, [second, third]);
    let e_inverse = third.select(b[2].inverse, second.select(b[1].inverse, b[0].inverse));

    // If a point lies inside its edge, the difference is perpendicular to that edge up to rounding;
    // subtract this rounding.
    let (zero, one) = (F8::splat(lanes, 0.0), F8::splat(lanes, 1.0));
    let d_inside = zero.less(link.s).and(link.s.less(one));
    let e_inside = zero.less(link.t).and(link.t.less(one));
    let (d, e) = (
        per_axis!(k => d[k].and(d_inside)),
        per_axis!(k => e[k].and(e_inside)),
    );
    let across = sub(link.between, scaled(e, dot(link.between, e) * e_inverse));
    let d = sub(d, scaled(e, dot(d, e) * e_inverse));
    // Edges closer to parallel than 1e-3 have no second direction.
    let square = dot(d, d).max(d_square * F8::splat(lanes, 1e-6));
    let direction = sub(across, scaled(d, dot(across, d) / square));
    Closest {
        square: link.square,
        direction,
        places: [[edge_a, link.s], [edge_b, link.t]],
    }
}

/// The number of three that two masks select.
#[inline(always)]
fn number<L: Lanes>(lanes: L, [second, third]: [F8<L>; 2]) -> F8<L> {
    let first = F8::splat(lanes, 1.0).and(second);
    third.select(F8::splat(lanes, 2.0), first)
}

impl<L: Lanes> Closest<L> {
    /// Tests a face, of the triangle `side`, against the corners of the other. The face has the
    /// edges `x` and `y` from its first corner; `inverse` is `1 / |x|^2`, and `corners` are
    /// relative to its first corner. Only the corner closest to the plane can be the closest point:
    /// from every other corner, the distance to the face decreases on the way to it.
    #[inline(always)]
    fn or_face(
        &mut self,
        lanes: L,
        side: usize,
        [x, y]: [V8<L>; 2],
        inverse: F8<L>,
        corners: [V8<L>; 3],
    ) {
        let y = scaled(y, inverse);
        let normal = cross(x, y);
        let heights = per_axis!(v => dot(normal, corners[v]).abs());
        let [second, third] = least(heights);
        let corner = select(third, corners[2], select(second, corners[1], corners[0]));
        let height = heights[0].min(heights[1]).min(heights[2]);
        let area = dot(normal, normal).max(F8::splat(lanes, UNDERFLOW));
        let (s, t) = (dot(cross(y, normal), corner), dot(cross(normal, x), corner));
        let zero = F8::splat(lanes, 0.0);
        let is_over = zero
            .less(s)
            .and(zero.less(t))
            .and((s + t * inverse).less(area));
        let square = height * (height / area);
        let closer = is_over.and(square.less(self.square));
        self.square = closer.select(square, self.square);
        self.direction = select(closer, normal, self.direction);
        // The second corner ends the first edge, the third corner the second.
        let (zero, one) = (F8::splat(lanes, 0.0), F8::splat(lanes, 1.0));
        let of_corner = [one.and(third), one.and(second.or(third))];
        let of_face = [F8::splat(lanes, 3.0), zero];
        let [edge, along] = self.places[1 - side];
        self.places[1 - side] = [
            closer.select(of_corner[0], edge),
            closer.select(of_corner[1], along),
        ];
        let [edge, along] = self.places[side];
        self.places[side] = [
            closer.select(of_face[0], edge),
            closer.select(of_face[1], along),
        ];
    }
}
