//! A filter in `f64` for triangles of one surface: do they certainly meet only in the corners they
//! share? `docs/numerics.md` derives the bounds.

use glam::DVec3;

type Triangle = [DVec3; 3];

/// The corners that two triangles share: bit `3 i + j` for corner `i` of `a` and `j` of `b`.
#[inline(always)]
pub fn shared<P: PartialEq>(a: &[P; 3], b: &[P; 3]) -> u32 {
    let row =
        |p: &P| u32::from(*p == b[0]) | u32::from(*p == b[1]) << 1 | u32::from(*p == b[2]) << 2;
    row(&a[0]) | row(&a[1]) << 3 | row(&a[2]) << 6
}

/// True if triangles certainly meet only in these shared corners. `scale` is a power of two that
/// takes differences of corners to 2 or less.
#[inline(always)]
pub fn meet_only_in(shared: u32, a: &Triangle, b: &Triangle, scale: f64) -> bool {
    let corners = |bit: u32| [bit as usize / 3 % 3, bit as usize % 3];
    let [i, j] = corners(shared.trailing_zeros());
    let p = a[i];
    let from = |q: DVec3| (q - p) * scale;
    match shared.count_ones() {
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
