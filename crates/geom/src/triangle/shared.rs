//! Filters for triangles of one surface: do they certainly meet only in the corners they share?
//! Eight pairs at a time in `f32`, what that leaves in doubt in `f64`. `docs/numerics.md` derives
//! the bounds.

use super::batch::{EDGE_ERROR, Rows, Transposed, UNDERFLOW, largest};
use crate::lanes::{Column, F8, Lanes, V8, add, all, cross, dot, per_axis, per_part, scaled, sub};
use crate::tolerance::ROUNDING;
use glam::DVec3;

type Triangle = [DVec3; 3];

/// The corners that two triangles share: bit `3 i + j` for corner `i` of `a` and `j` of `b`.
#[inline(always)]
pub fn shared<P: PartialEq>(a: &[P; 3], b: &[P; 3]) -> u32 {
    let row =
        |p: &P| u32::from(*p == b[0]) | u32::from(*p == b[1]) << 1 | u32::from(*p == b[2]) << 2;
    row(&a[0]) | row(&a[1]) << 3 | row(&a[2]) << 6
}

/// For each mask of [`shared()`]: in the bits from 6 on the number of shared corners, 0 if it is
/// not 1 or 2 for each triangle; in the bits below the rows of [`TURNS`] for `a` and `b`.
const LAYOUTS: [u8; 512] = {
    let mut layouts = [0; 512];
    let mut bits = 1;
    while bits < 512_u32 {
        let count = bits.count_ones();
        let (first, last) = (bits.trailing_zeros(), 31 - bits.leading_zeros());
        let ([i, j], [k, l]) = ([first / 3, first % 3], [last / 3, last % 3]);
        let is_edge = count == 2 && i != k && j != l;
        if count == 1 || is_edge {
            let row_a = 2 * i + (k == (i + 2) % 3) as u32;
            let row_b = 2 * j + (l == (j + 2) % 3) as u32;
            layouts[bits as usize] = (count << 6 | row_b << 3 | row_a) as u8;
        }
        bits += 1;
    }
    layouts
};

/// Two sides of a triangle that start in a corner, as sums of its stored edges: two factors for
/// each. Row `2 i` has those to the corners `i + 1` and `i + 2`, row `2 i + 1` has them exchanged.
const TURNS: [[f32; 4]; 6] = [
    [1.0, 0.0, 0.0, 1.0],
    [0.0, 1.0, 1.0, 0.0],
    [-1.0, 1.0, -1.0, 0.0],
    [-1.0, 0.0, -1.0, 1.0],
    [0.0, -1.0, 1.0, -1.0],
    [1.0, -1.0, 0.0, -1.0],
];

/// Mask of the pairs of triangles `a[i]`, `b[i]` that certainly meet only in the corners they
/// share, at least one ([`shared()`]).
#[inline(always)]
pub fn meet_only_in_shared<L: Lanes>(lanes: L, shared: &[u32; 8], [a, b]: [[&Rows; 8]; 2]) -> u32 {
    let mut apart = 0;
    per_part!(lanes: L, part => {
        apart |= part_meets_only_in(part, shared, [a, b]) & all(part);
    });
    apart
}

#[inline(always)]
fn part_meets_only_in<L: Lanes>(lanes: L, shared: &[u32; 8], [a, b]: [[&Rows; 8]; 2]) -> u32 {
    let [mut edges, mut corners] = [0; 2];
    let mut turns = [[&TURNS[0]; 8]; 2];
    for lane in 0..8 {
        let layout = LAYOUTS[shared[lane] as usize & 511];
        corners |= u32::from(layout >> 6 & 1) << lane;
        edges |= u32::from(layout >> 7) << lane;
        turns[0][lane] = &TURNS[layout as usize & 7];
        turns[1][lane] = &TURNS[layout as usize >> 3 & 7];
    }
    let [(a, size_a), (b, size_b)] = [sides(lanes, a, turns[0]), sides(lanes, b, turns[1])];
    let normal = cross(a[0], a[1]);
    let (x, y) = (dot(normal, b[0]), dot(normal, b[1]));
    let volume = bound(lanes, 700.0, size_a * size_a * size_b);
    let mut apart = 0;
    if edges != 0 {
        let other = cross(a[0], b[1]);
        let folded = bound(lanes, 3600.0, size_a * size_a * size_a * size_b);
        let open = dot(normal, other).less(-folded).or(volume.less(y.abs()));
        apart |= open.mask() & edges;
    }
    if corners & !apart != 0 {
        let of_b = cross(b[0], b[1]);
        let (z, w) = (dot(of_b, a[0]), dot(of_b, a[1]));
        let volume_b = bound(lanes, 700.0, size_b * size_b * size_a);
        // Any direction is right if it separates, so its rounding does not matter.
        let n = sub(
            add(unit(lanes, a[0]), unit(lanes, a[1])),
            add(unit(lanes, b[0]), unit(lanes, b[1])),
        );
        let length = sum(n);
        let (of_a, to_b) = (
            bound(lanes, 16.0, length * size_a),
            bound(lanes, 16.0, length * size_b),
        );
        let between = of_a
            .less(dot(n, a[0]))
            .and(of_a.less(dot(n, a[1])))
            .and(dot(n, b[0]).less(-to_b))
            .and(dot(n, b[1]).less(-to_b));
        let open = between.or(beside(x, y, volume)).or(beside(z, w, volume_b));
        apart |= open.mask() & corners;
    }
    apart
}

/// Two sides of each triangle, and a bound of the components of its edges.
#[inline(always)]
fn sides<L: Lanes>(lanes: L, rows: [&Rows; 8], turns: [&[f32; 4]; 8]) -> ([V8<L>; 2], F8<L>) {
    let triangle = Transposed::new(lanes, rows);
    let [p, q, r, s] = F8::columns(lanes, turns);
    let (e, f) = (triangle.edge1, triangle.edge2);
    let size = largest(e).max(largest(f)) + F8::splat(lanes, EDGE_ERROR);
    (
        [
            per_axis!(k => e[k] * p + f[k] * q),
            per_axis!(k => e[k] * r + f[k] * s),
        ],
        size,
    )
}

/// The error bound of a value whose terms are products of sizes.
#[inline(always)]
fn bound<L: Lanes>(lanes: L, roundings: f32, size: F8<L>) -> F8<L> {
    size.times(roundings * ROUNDING) + F8::splat(lanes, 4.0 * UNDERFLOW)
}

/// Mask: both values are certainly positive, or both certainly negative.
#[inline(always)]
fn beside<N: Column>(x: N, y: N, bound: N) -> N {
    bound.less(x.min(y)).or(x.max(y).less(-bound))
}

#[inline(always)]
fn sum<N: Column>(v: [N; 3]) -> N {
    v[0].abs() + v[1].abs() + v[2].abs()
}

#[inline(always)]
fn unit<L: Lanes>(lanes: L, v: V8<L>) -> V8<L> {
    scaled(v, F8::splat(lanes, 1.0) / sum(v))
}

/// True if triangles certainly meet only in these shared corners, or nowhere. `scale` is a power of
/// two that takes differences of corners to 2 or less.
#[inline(always)]
pub fn meet_only_in(shared: u32, a: &Triangle, b: &Triangle, scale: f64) -> bool {
    let corners = |bit: u32| [bit as usize / 3 % 3, bit as usize % 3];
    let [i, j] = corners(shared.trailing_zeros() % 9);
    let p = a[i];
    let from = |q: DVec3| (q - p) * scale;
    match shared.count_ones() {
        0 => are_apart_across_a_side(a.map(from), b.map(from)),
        1 => {
            let others = |t: &Triangle, i: usize| [from(t[(i + 1) % 3]), from(t[(i + 2) % 3])];
            only_in_corner(others(a, i), others(b, j))
        }
        2 => {
            let [k, l] = corners(31 - shared.leading_zeros());
            // Not with a corner that a triangle has twice.
            i != k && j != l && only_in_edge(from(a[k]), from(a[3 - i - k]), from(b[3 - j - l]))
        }
        _ => false,
    }
}

/// Relative error of a determinant or of a product of normals, over the product of the sums of the
/// sizes of components: at most 32 roundings.
const ERROR: f64 = 16.0 * f64::EPSILON;

/// More than all products that underflow.
const TINY: f64 = 1e-300;

fn size(v: DVec3) -> f64 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// Are triangles apart along a direction that lies in the plane of one of them, across one of its
/// sides? Triangles that are almost coplanar and do not meet are.
fn are_apart_across_a_side(a: Triangle, b: Triangle) -> bool {
    let sizes = a.iter().chain(&b).map(|&v| size(v)).fold(0.0, f64::max);
    [a, b].iter().any(|t| {
        let sides = [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
        let normal = sides[0].cross(sides[1]);
        sides.iter().any(|&side| {
            // Any direction is right if it separates, so its rounding does not matter.
            let across = normal.cross(side);
            let bound = ERROR * size(across) * sizes + TINY;
            let [of_a, of_b] = [a, b].map(|t| t.map(|v| across.dot(v)));
            let least = |x: [f64; 3]| x[0].min(x[1]).min(x[2]);
            let most = |x: [f64; 3]| x[0].max(x[1]).max(x[2]);
            least(of_b) - most(of_a) > bound || least(of_a) - most(of_b) > bound
        })
    })
}

/// Triangles that share an edge, from its end at the origin: `edge` to its other end, and to the
/// other corners. They meet beyond it only if their normals are parallel and of one direction.
fn only_in_edge(edge: DVec3, r: DVec3, s: DVec3) -> bool {
    let normal = edge.cross(r);
    let sizes = size(edge) * size(r) * size(s);
    normal.dot(edge.cross(s)) < -(ERROR * sizes * size(edge) + TINY)
        || normal.dot(s).abs() > ERROR * sizes + TINY
}

/// Triangles that share a corner, the origin: are the cones of their other corners apart? They are
/// if a plane through the origin separates them strictly, or if one of them is strictly on one side
/// of the plane of the other.
fn only_in_corner(a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    let (sizes_a, sizes_b) = (a.map(size), b.map(size));
    let unit = |v: [DVec3; 2], sizes: [f64; 2]| [v[0] * (1.0 / sizes[0]), v[1] * (1.0 / sizes[1])];
    let (unit_a, unit_b) = (unit(a, sizes_a), unit(b, sizes_b));
    // Any direction is right if it separates, so its rounding does not matter.
    let parts = |n: DVec3| {
        let bound = ERROR * size(n) + TINY;
        // Each compared, because a minimum would drop NaN.
        (n.dot(unit_a[0]) > bound)
            & (n.dot(unit_a[1]) > bound)
            & (n.dot(unit_b[0]) < -bound)
            & (n.dot(unit_b[1]) < -bound)
    };
    if parts(unit_a[0] + unit_a[1] - (unit_b[0] + unit_b[1])) {
        return true;
    }
    let (normal_a, normal_b) = (a[0].cross(a[1]), b[0].cross(b[1]));
    let passes = |normal: DVec3, span: [f64; 2], others: [DVec3; 2], sizes: [f64; 2]| {
        let bound = |i: usize| ERROR * span[0] * span[1] * sizes[i] + TINY;
        let [x, y] = others.map(|v| normal.dot(v));
        x > bound(0) && y > bound(1) || x < -bound(0) && y < -bound(1)
    };
    if passes(normal_a, sizes_a, b, sizes_b) || passes(normal_b, sizes_b, a, sizes_a) {
        return true;
    }
    // Almost coplanar: a plane between the corners that are closest as seen from the origin.
    let turn = normal_a.dot(normal_b);
    let normal = if turn < 0.0 {
        normal_a - normal_b
    } else {
        normal_a + normal_b
    };
    let pairs = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| unit_a[i] + unit_b[j]);
    let middle = pairs
        .into_iter()
        .max_by(|x, y| x.length_squared().total_cmp(&y.length_squared()));
    middle.is_some_and(|middle| {
        let across = normal.cross(middle);
        parts(across) || parts(-across)
    })
}
