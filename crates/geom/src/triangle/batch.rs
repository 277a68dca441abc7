//! Tests eight triangle pairs at a time in `f32`: certain hits, certain misses, and the rest in
//! doubt.
//!
//! All coordinates are relative to the first corner of A's triangle; this subtraction cancels, so
//! it is done in `f64`. Let `p1, p2` be edges of A, `f1, f2` edges of B, and `q` the first corner
//! of B. Four cross products and ten dot products give the distances of all corners from the other
//! plane, and a determinant for each edge of A and each edge of B. A determinant is positive if the
//! line of one edge passes the other counterclockwise.
//!
//! If two triangles meet and are not coplanar, an edge of one meets the other. So a pair is
//! - a hit if an edge certainly crosses the other plane and certainly passes all three edges there
//!   on the same side,
//! - a miss if all corners of one are certainly on one side of the other's plane, or if each of the
//!   six edges certainly misses the other triangle: its ends are on one side of the plane, or its
//!   line passes the triangle's edges on different sides.
//!
//! Each value has an error bound per lane, computed from the largest components `P`, `F`, `Q` of
//! `p`, `f`, `q`; `docs/numerics.md` derives the bounds. Coplanar and degenerate pairs always end
//! in doubt.

use crate::lanes::{Column, D8, F8, Lanes, V8, all, cross, dot, per_axis, per_part};
use crate::tolerance::ROUNDING;

/// A triangle in rows of four: first corner, two edges, and the residual of rounding the first
/// corner.
pub type Rows = [[f32; 4]; 3];

/// Transformation of B's triangles into A's coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Rotation times scale, row by row.
    pub linear: [[f64; 3]; 3],
    pub translation: [f64; 3],
    /// `linear` in `f32`, for edges.
    pub rotation: [[f32; 3]; 3],
    /// Error bound of a transformed corner, beyond its rounding to `f32`, in A's units.
    pub position_error: f32,
    /// Error bound of a transformed edge of B, in A's units, divided by [`ROUNDING`].
    pub edge_error: f32,
}

/// Results of the test, one bit per lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdicts {
    pub hit: u32,
    pub doubt: u32,
}

impl Verdicts {
    /// No lane is decided.
    pub const NONE: Self = Self {
        hit: 0,
        doubt: 0xff,
    };

    /// Merges the verdicts of other lanes, or of another test of these lanes.
    #[inline(always)]
    pub fn add(&mut self, Self { hit, doubt }: Self) {
        self.hit |= hit;
        self.doubt &= doubt;
    }
}

/// Edges that certainly cross the other triangle: edges 01, 12 and 20 of A, then those of B. One
/// bit per lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct Crossings([u32; 6]);

impl Crossings {
    /// Crossings of a lane, one bit per edge.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> u32 {
        (0..6).fold(0, |bits, i| bits | (self.0[i] >> lane & 1) << i)
    }
}

/// Tests `a[i]` against `b[i]` at least for the lanes `i` in the bit mask `wanted`. Adds the
/// crossings of hits to `crossings`, if present.
#[inline(always)]
// The lint sees only the last use of `crossings`, which could take the option by value. The first
// use could not.
#[allow(clippy::needless_option_as_deref)]
pub fn test<L: Lanes>(
    lanes: L,
    wanted: u32,
    [a, b]: [[&Rows; 8]; 2],
    placement: &Placement,
    mut crossings: Option<&mut Crossings>,
) -> Verdicts {
    let mut verdicts = Verdicts::NONE;
    per_part!(lanes: L, part => {
        if L::IS_WHOLE || wanted & all(part) != 0 {
            verdicts.add(test_part(part, [a, b], placement, crossings.as_deref_mut()));
        }
    });
    verdicts
}

#[inline(always)]
fn test_part<L: Lanes>(
    lanes: L,
    [a, b]: [[&Rows; 8]; 2],
    placement: &Placement,
    crossings: Option<&mut Crossings>,
) -> Verdicts {
    let a = Transposed::new(lanes, a);
    let a = L::settled(&a);
    let b = Transposed::new(lanes, b);
    let b = L::settled(&b);
    let q = first_corner(lanes, a, b, placement);
    let (f1, f2) = (
        rotate(lanes, &placement.rotation, b.edge1),
        rotate(lanes, &placement.rotation, b.edge2),
    );

    // Bounds are computed from sizes, relative to `ROUNDING`. So an absolute error of a corner or
    // an edge, divided by `ROUNDING`, is added to its size.
    let sizes = [
        largest(a.edge1).max(largest(a.edge2)) + F8::splat(lanes, EDGE_ERROR),
        largest(f1).max(largest(f2)) + F8::splat(lanes, placement.edge_error),
        largest(q) + F8::splat(lanes, placement.position_error * (1.0 / ROUNDING)),
    ];
    let bounds = Bounds::new(sizes, ROUNDING, F8::splat(lanes, UNDERFLOW));
    certain(
        [a.edge1, a.edge2],
        [f1, f2],
        q,
        L::settled(&bounds),
        crossings,
    )
}

/// Decides the pairs of all lanes. A has the edges `p`, B the edges `f` and the first corner `q`,
/// relative to the first corner of A.
#[inline(always)]
pub(super) fn certain<N: Column>(
    [p1, p2]: [[N; 3]; 2],
    [f1, f2]: [[N; 3]; 2],
    q: [N; 3],
    bounds: &Bounds<N>,
    crossings: Option<&mut Crossings>,
) -> Verdicts {
    let normal_a = cross(p1, p2);
    let normal_b = cross(f1, f2);

    let (g1, g2) = (dot(normal_a, f1), dot(normal_a, f2));
    let (w1, w2) = (dot(normal_b, p1), dot(normal_b, p2));
    let (a0, b0) = (dot(normal_a, q), -dot(normal_b, q));
    let (of_b, of_a) = ([a0, a0 + g1, a0 + g2], [b0, b0 + w1, b0 + w2]);

    // Determinants that tell on which side the lines of two edges pass each other. Rows are the
    // edges of A, columns those of B, both in the order 01, 12, 20.
    let (x1, x2) = (cross(q, f1), cross(q, f2));
    let (u11, u12, u21, u22) = (dot(p1, x1), dot(p1, x2), dot(p2, x1), dot(p2, x2));
    let (v1, v2) = (u12 - u11 + w1, u22 - u21 + w2);
    let middle = (v2 - v1 + (g2 - g1)).times(MIDDLE);
    let rows = [
        [u11, v1, -u12],
        [u21 - u11 + g1, middle, u12 - u22 - g2],
        [-u21, -v2, u22],
    ];

    let [x, y, z] = per_axis!(j => {
        edge([of_b[j], of_b[(j + 1) % 3]], bounds.plane_a, [rows[0][j], rows[1][j], rows[2][j]], bounds.line)
    });
    let [u, v, w] =
        per_axis!(i => edge([of_a[i], of_a[(i + 1) % 3]], bounds.plane_b, rows[i], bounds.line));
    let miss = x
        .miss
        .and(y.miss)
        .and(z.miss)
        .and(u.miss)
        .and(v.miss)
        .and(w.miss);
    let hit = x.hit.or(y.hit).or(z.hit).or(u.hit).or(v.hit).or(w.hit);
    if let Some(crossings) = crossings {
        for (bits, hit) in crossings
            .0
            .iter_mut()
            .zip([u.hit, v.hit, w.hit, x.hit, y.hit, z.hit])
        {
            *bits |= hit.mask();
        }
    }
    // If two edges of a triangle are on one side of the other plane, so are all three corners.
    let one_side = x.same.and(y.same).or(u.same.and(v.same));
    let (hit, miss) = (hit.mask(), miss.or(one_side).mask());
    Verdicts {
        hit,
        doubt: !(hit | miss) & 0xff,
    }
}

/// Eight triangles, stored by component.
pub struct Transposed<L: Lanes> {
    pub first: V8<L>,
    pub edge1: V8<L>,
    pub edge2: V8<L>,
    rest: V8<L>,
}

impl<L: Lanes> Transposed<L> {
    #[inline(always)]
    pub fn new(lanes: L, rows: [&Rows; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = rows;
        let [[x, y, z, ex], [ey, ez, fx, fy], [fz, rx, ry, rz]] = per_axis!(i => F8::columns(lanes, [&a[i], &b[i], &c[i], &d[i], &e[i], &f[i], &g[i], &h[i]]));
        Self {
            first: [x, y, z],
            edge1: [ex, ey, ez],
            edge2: [fx, fy, fz],
            rest: [rx, ry, rz],
        }
    }

    #[inline(always)]
    pub fn corner(&self, lanes: L) -> [D8<L>; 3] {
        per_axis!(k => D8::widen(lanes, self.first[k]) + D8::widen(lanes, self.rest[k]))
    }
}

/// First corner of B's triangle relative to the first corner of A's, in A's units, computed in
/// `f64`.
#[inline(always)]
pub(super) fn first_corner<L: Lanes>(
    lanes: L,
    a: &Transposed<L>,
    b: &Transposed<L>,
    placement: &Placement,
) -> V8<L> {
    let (a, b) = (a.corner(lanes), b.corner(lanes));
    per_axis!(k => {
        let [x, y, z] = placement.linear[k];
        let x = D8::splat(lanes, x) * b[0] + D8::splat(lanes, y) * b[1] + D8::splat(lanes, z) * b[2];
        (x + (D8::splat(lanes, placement.translation[k]) - a[k])).narrow()
    })
}

/// Rotates an edge of B to A's coordinates.
#[inline(always)]
pub fn rotate<L: Lanes>(lanes: L, rotation: &[[f32; 3]; 3], edge: V8<L>) -> V8<L> {
    per_axis!(k => dot(per_axis!(j => F8::splat(lanes, rotation[k][j])), edge))
}

/// The largest magnitude of the components, per lane.
#[inline(always)]
pub fn largest<N: Column>(v: [N; 3]) -> N {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// Error bounds of the computed values.
pub(super) struct Bounds<N> {
    plane_a: N,
    plane_b: N,
    line: N,
}

impl<N: Column> Bounds<N> {
    /// Bounds from the largest components of `p`, `f` and `q`, and the relative rounding error of
    /// one operation.
    #[inline(always)]
    pub fn new([p, f, q]: [N; 3], rounding: f32, underflow: N) -> Self {
        Self {
            plane_a: (p * p * (q + f)).times(128.0 * rounding) + underflow,
            plane_b: (f * f * (q + p)).times(192.0 * rounding) + underflow,
            line: (p * f * (p + f + q)).times(256.0 * rounding) + underflow,
        }
    }
}

/// Absolute error of an edge, 2^-52, divided by [`ROUNDING`].
pub const EDGE_ERROR: f32 = ROUNDING / 16.0;

/// Least amount by which bounds enlarge an edge: 2^-50. Then the parts of an edge and of its
/// products that are flushed to zero are less than their rounding.
pub const LEAST_EDGE_ERROR: f32 = ROUNDING / (1 << 26) as f32;

/// Upper bound of the underflow error of a value, with or without flush to zero: 85 times the least
/// normal number.
pub const UNDERFLOW: f32 = 1e-36;

/// Scale of the determinant of both middle edges. Its error is 2.25 times that of the other
/// determinants, so it is scaled by less than 1 / 2.25 before the comparison.
const MIDDLE: f32 = 0.4375;

/// Least and largest of three values.
#[derive(Clone, Copy)]
pub(super) struct Range<N> {
    pub low: N,
    pub high: N,
}

impl<N: Column> Range<N> {
    #[inline(always)]
    pub fn of([x, y, z]: [N; 3]) -> Self {
        Self {
            low: x.min(y).min(z),
            high: x.max(y).max(z),
        }
    }

    /// If all values have one sign, their least distance from 0. Otherwise `-min(-low, high)`,
    /// which is not positive.
    #[inline(always)]
    fn aside(self) -> N {
        self.low.max(-self.high)
    }

    /// Mask: all values are certainly positive, or all certainly negative, if each has an error
    /// below `bound`.
    #[inline(always)]
    pub fn same(self, bound: N) -> N {
        bound.less(self.aside())
    }

    /// Mask: one value is certainly positive and another certainly negative, if each has an error
    /// below `bound`.
    #[inline(always)]
    pub fn mixed(self, bound: N) -> N {
        self.aside().less(-bound)
    }
}

/// Certain results of an edge against a triangle, as masks.
struct Edge<N> {
    hit: N,
    miss: N,
    /// Both ends are on one side of the triangle's plane.
    same: N,
}

/// Tests an edge against a triangle. `start` and `end` are the distances of the edge's ends from
/// the plane, with the error bound `plane`. `sides` are the determinants of the edge's line with
/// the triangle's three edges, with the error bound `line`.
#[inline(always)]
fn edge<N: Column>([start, end]: [N; 2], plane: N, sides: [N; 3], line: N) -> Edge<N> {
    let ends = Range {
        low: start.min(end),
        high: start.max(end),
    };
    let (sides, same) = (Range::of(sides), ends.same(plane));
    Edge {
        hit: ends.mixed(plane).and(sides.same(line)),
        miss: same.or(sides.mixed(line)),
        same,
    }
}
