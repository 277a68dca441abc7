//! Candidate axes for an orientation, and their costs, for up to eight subtrees at a time, one per
//! lane.
//!
//! All arithmetic is plain `f32` in a fixed order, so all machines give the same bits. Candidates
//! are orthogonal up to some roundings. The chosen one is made orthonormal in `f64`
//! ([`super::orientation`]).

use super::eight::{Eight, present};
use super::moments::{Surfaces, Symmetric, TINY, per_entry};
use crate::tree::unit::Triangle;
use crate::tree::wide::WIDTH;
use glam::{Mat3A, Vec3A};
use punctual_geom::lanes::{Column, F8, Lanes, V8, cross, dot, per_axis, scaled, sums};

/// Three axes per lane, in unit coordinates.
pub(crate) type Axes<L> = [V8<L>; 3];

/// Candidate axes for each lane: `0[candidate][axis][component][lane]`.
pub(crate) struct Candidates([[[[f32; WIDTH]; 3]; 3]; 3]);

impl Candidates {
    /// The candidates: the principal axes of the normals; the dominant normal with the longest axis
    /// of the surface; and the normal of the largest triangle with its edge of middle length.
    #[inline(always)]
    pub fn of<L: Lanes>(lanes: L, surfaces: &Surfaces<L>, triangles: &[Triangle]) -> Self {
        let (facing, normal) = eigenvectors(lanes, surfaces.normals);
        let longest = dominant(lanes, surfaces.covariance);
        let largest = Eight::of_numbers(lanes, triangles, surfaces.largest);
        let all = [
            facing,
            facing_and_longest(lanes, &facing, normal, longest),
            sides(lanes, &largest),
        ];
        Self(per_axis!(c => per_axis!(i => per_axis!(j => all[c][i][j].store()))))
    }

    /// Costs of axes for `subtree`. The first is that of the axes `own`; the others are those of
    /// the candidates of `lane`.
    #[inline(always)]
    pub fn costs<L: Lanes>(
        &self,
        lanes: L,
        lane: usize,
        own: &Axes<L>,
        subtree: &impl Cost<L>,
    ) -> [f32; 4] {
        let [x, y, z] = per_axis!(c => {
            let axes = per_axis!(i => per_axis!(j => F8::splat(lanes, self.0[c][i][j][lane])));
            subtree.areas(lanes, &axes)
        });
        sums([subtree.areas(lanes, own), x, y, z])
    }

    /// The axes with the least of `costs`, the first of equal ones. `None` stands for the axes
    /// `own` in [`costs`](Self::costs).
    #[inline(always)]
    pub fn best(&self, lane: usize, costs: &[f32; 4]) -> Option<Mat3A> {
        let mut best = 0;
        for i in 1..costs.len() {
            if costs[i] < costs[best] {
                best = i;
            }
        }
        let axes = &self.0[best.checked_sub(1)?];
        let [x, y, z] =
            per_axis!(i => Vec3A::new(axes[i][0][lane], axes[i][1][lane], axes[i][2][lane]));
        Some(Mat3A::from_cols(x, y, z))
    }
}

/// A subtree for which axes are to be chosen.
pub(crate) trait Cost<L: Lanes> {
    /// Half the surface areas of boxes along `axes`. Their sum over the lanes is the cost of the
    /// axes.
    fn areas(&self, lanes: L, axes: &Axes<L>) -> F8<L>;
}

/// Estimates the boxes of the children: their half extents are the standard deviations of their
/// surfaces.
impl<L: Lanes> Cost<L> for Surfaces<L> {
    #[inline(always)]
    fn areas(&self, lanes: L, axes: &Axes<L>) -> F8<L> {
        let s = &self.covariance;
        let (two, zero) = (F8::splat(lanes, 2.0), F8::splat(lanes, 0.0));
        let [x, y, z] = per_axis!(i => {
            let [x, y, z] = axes[i];
            let twice = two * x * y * s[3] + two * x * z * s[4] + two * y * z * s[5];
            let variance = x * x * s[0] + y * y * s[1] + z * z * s[2] + twice;
            variance.max(zero).sqrt()
        });
        x * y + y * z + z * x
    }
}

/// Up to eight triangles. Their boxes are computed, not estimated.
pub(crate) struct Leaf<L: Lanes> {
    triangles: Eight<L>,
    present: F8<L>,
}

impl<L: Lanes> Leaf<L> {
    #[inline(always)]
    pub fn of(lanes: L, triangles: &[Triangle]) -> Self {
        Self {
            triangles: Eight::of_few(lanes, triangles),
            present: present(lanes, triangles.len()),
        }
    }
}

impl<L: Lanes> Cost<L> for Leaf<L> {
    #[inline(always)]
    fn areas(&self, lanes: L, axes: &Axes<L>) -> F8<L> {
        let zero = F8::splat(lanes, 0.0);
        let [x, y, z] = per_axis!(i => {
            let (e, f) = (dot(axes[i], self.triangles.edges[0]), dot(axes[i], self.triangles.edges[1]));
            e.max(f).max(zero) - e.min(f).min(zero)
        });
        let (x, z) = (x * self.present, z * self.present);
        x * y + y * z + z * x
    }
}

/// The normals of triangles, their edges of middle length, and the axes perpendicular to both. If
/// two triangles form a rectangle, the middle edge is a side of it. The axes of the mesh where the
/// normal or the edge has no direction.
#[inline(always)]
fn sides<L: Lanes>(lanes: L, triangles: &Eight<L>) -> Axes<L> {
    let [a, b, c] = triangles.corners();
    let (e, f, g) = (
        per_axis!(k => b[k] - a[k]),
        per_axis!(k => c[k] - a[k]),
        per_axis!(k => c[k] - b[k]),
    );
    let (ee, ff, gg) = (dot(e, e), dot(f, f), dot(g, g));
    let (not_e, g_over_f) = (ee.less(ff.max(gg)), ff.less(gg));
    // The two edges besides the longest.
    let (p, pp) = (
        per_axis!(k => not_e.select(e[k], f[k])),
        not_e.select(ee, ff),
    );
    let to_f = not_e.and(g_over_f);
    let (q, qq) = (per_axis!(k => to_f.select(f[k], g[k])), to_f.select(ff, gg));
    let q_over_p = pp.less(qq);
    let middle = per_axis!(k => q_over_p.select(q[k], p[k]));
    let ((x, x_there), (y, y_there)) = (unit(lanes, cross(e, f)), unit(lanes, middle));
    let (axes, there, none) = ([x, y, cross(x, y)], x_there.and(y_there), identity(lanes));
    per_axis!(i => per_axis!(j => there.select(axes[i][j], none[i][j])))
}

/// `v` scaled to length 1, and the mask of the lanes in which it has a direction.
#[inline(always)]
fn unit<L: Lanes>(lanes: L, v: V8<L>) -> (V8<L>, F8<L>) {
    let scale = F8::splat(lanes, 1.0) / dot(v, v).sqrt();
    (
        scaled(v, scale),
        scale.less(F8::splat(lanes, f32::INFINITY)),
    )
}

#[inline(always)]
pub(crate) fn identity<L: Lanes>(lanes: L) -> Axes<L> {
    let (o, l) = (F8::splat(lanes, 0.0), F8::splat(lanes, 1.0));
    [[l, o, o], [o, l, o], [o, o, l]]
}

/// The dominant normal and, perpendicular to it, the longest axis of the surface. If these are
/// parallel, the first two axes of `facing`.
#[inline(always)]
fn facing_and_longest<L: Lanes>(
    lanes: L,
    facing: &Axes<L>,
    normal: V8<L>,
    longest: V8<L>,
) -> Axes<L> {
    let (one, least) = (F8::splat(lanes, 1.0), F8::splat(lanes, 1e-3));
    let along = dot(longest, normal);
    let across = per_axis!(k => longest[k] - normal[k] * along);
    let length = dot(across, across).sqrt();
    let (parallel, scale) = (length.less(least), one / length.max(least));
    let x = per_axis!(k => parallel.select(facing[0][k], normal[k]));
    let y = per_axis!(k => parallel.select(facing[1][k], across[k] * scale));
    [x, y, cross(x, y)]
}

/// Eigenvectors of the largest eigenvalues: a column of a high power of each matrix, computed by
/// squaring.
#[inline(always)]
fn dominant<L: Lanes>(lanes: L, mut m: Symmetric<L>) -> V8<L> {
    let (one, tiny) = (F8::splat(lanes, 1.0), F8::splat(lanes, TINY));
    for _ in 0..6 {
        let scale = one / (m[0] + m[1] + m[2] + tiny);
        let [xx, yy, zz, xy, xz, yz] = per_entry!(k => m[k] * scale);
        m = [
            xx * xx + xy * xy + xz * xz,
            xy * xy + yy * yy + yz * yz,
            xz * xz + yz * yz + zz * zz,
            xy * (xx + yy) + xz * yz,
            xz * (xx + zz) + xy * yz,
            yz * (yy + zz) + xy * xz,
        ];
    }
    let [xx, yy, zz, xy, xz, yz] = m;
    let column = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let v = of_largest([xx, yy, zz], &column);
    let scale = one / (dot(v, v) + tiny).sqrt();
    scaled(v, scale)
}

/// Selects the vector that belongs to the largest value.
#[inline(always)]
fn of_largest<L: Lanes>([x, y, z]: V8<L>, vectors: &[V8<L>; 3]) -> V8<L> {
    let (z_over_y, x_largest) = (y.less(z), y.max(z).less(x));
    per_axis!(k => x_largest.select(vectors[0][k], z_over_y.select(vectors[2][k], vectors[1][k])))
}

/// Eigenvectors of symmetric matrices, in no particular order, and for each matrix the one with the
/// largest eigenvalue (Jacobi rotations).
#[inline(always)]
fn eigenvectors<L: Lanes>(lanes: L, m: Symmetric<L>) -> (Axes<L>, V8<L>) {
    let (zero, one, tiny) = (
        F8::splat(lanes, 0.0),
        F8::splat(lanes, 1.0),
        F8::splat(lanes, TINY),
    );
    let scale = one / (m[0] + m[1] + m[2] + tiny);
    let [xx, yy, zz, xy, xz, yz] = per_entry!(k => m[k] * scale);
    let mut diagonal = [xx, yy, zz];
    // The off-diagonal entry that is not in row and column k.
    let mut other = [yz, xz, xy];
    let mut axes = identity(lanes);
    // Convergence is quadratic.
    for _ in 0..3 {
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let (difference, twice) = (diagonal[q] - diagonal[p], other[r] + other[r]);
            let root = (difference * difference + twice * twice).sqrt();
            // Rotates by the smaller of two possible angles. Multiplying by -1 also changes the
            // sign of a zero, which subtracting from 0 would not.
            let twice = difference
                .less(zero)
                .select(twice * F8::splat(lanes, -1.0), twice);
            let t = twice / (difference.abs() + root + tiny);
            let c = one / (t * t + one).sqrt();
            let s = t * c;
            let shift = t * other[r];
            diagonal[p] = diagonal[p] - shift;
            diagonal[q] = diagonal[q] + shift;
            other[r] = zero;
            (other[q], other[p]) = (c * other[q] - s * other[p], s * other[q] + c * other[p]);
            let (a, b) = (axes[p], axes[q]);
            axes[p] = per_axis!(k => c * a[k] - s * b[k]);
            axes[q] = per_axis!(k => s * a[k] + c * b[k]);
        }
    }
    (axes, of_largest(diagonal, &axes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat, DVec3, Vec3};
    use punctual_geom::lanes::Portable;

    fn matrices() -> [DMat3; WIDTH] {
        core::array::from_fn(|i| {
            let i = i as f64;
            let r = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(
                0.3 * i,
                -1.1,
                0.7 - 0.2 * i,
            )));
            r * DMat3::from_diagonal(DVec3::new(1.0, 5.0, i) * 1e-6) * r.transpose()
        })
    }

    fn columns(matrices: &[DMat3; WIDTH]) -> Symmetric<Portable> {
        [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
            .map(|(i, j)| F8::load(Portable {}, &matrices.map(|m| m.col(i)[j] as f32)))
    }

    fn lane(v: V8<Portable>, lane: usize) -> DVec3 {
        DVec3::from_array(v.map(|x| f64::from(x.store()[lane])))
    }

    #[test]
    fn eigenvectors_diagonalise_all_lanes() {
        let matrices = matrices();
        let (axes, longest) = eigenvectors(Portable {}, columns(&matrices));
        let power = dominant(Portable {}, columns(&matrices));
        for (i, m) in matrices.iter().enumerate() {
            let [x, y, z] = axes.map(|axis| lane(axis, i));
            let q = DMat3::from_cols(x, y, z);
            assert!((q.transpose() * q).abs_diff_eq(DMat3::IDENTITY, 1e-5));
            let d = q.transpose() * *m * q;
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                assert!(d.col(i)[j].abs() < 1e-11, "{d}");
            }
            let largest = d.col(0)[0].max(d.col(1)[1]).max(d.col(2)[2]);
            for v in [longest, power].map(|v| lane(v, i)) {
                assert!((v.dot(*m * v) - largest).abs() < 1e-11, "{v}");
            }
        }
    }

    #[test]
    fn eigenvectors_of_nothing_are_the_axes_of_the_mesh() {
        let (axes, _) = eigenvectors(Portable {}, columns(&[DMat3::ZERO; WIDTH]));
        for i in [0, 3, 7] {
            assert_eq!(
                axes.map(|axis| lane(axis, i)),
                [DVec3::X, DVec3::Y, DVec3::Z]
            );
        }
    }

    /// Half of a rectangle of 3 x 4 with the corners in any order, then a point and a segment.
    #[test]
    fn the_axes_of_a_triangle_are_its_normal_and_the_edge_of_middle_length() {
        let (o, p, q) = (
            Vec3::ZERO,
            Vec3::new(3.0, 0.0, 0.0),
            Vec3::new(0.0, 4.0, 0.0),
        );
        let corners = [
            [o, p, q],
            [p, o, q],
            [q, o, p],
            [o, q, p],
            [p, q, o],
            [q, p, o],
            [p, p, p],
            [o, p, p],
        ];
        let triangles = corners.map(|[a, b, c]| {
            let (e, f) = (b - a, c - a);
            Triangle([
                [a.x, a.y, a.z, e.x],
                [e.y, e.z, f.x, f.y],
                [f.z, 0.0, 0.0, 0.0],
            ])
        });
        let sides = sides(Portable {}, &Eight::of_few(Portable {}, &triangles));
        for i in 0..6 {
            let [x, y, z] = sides.map(|axis| lane(axis, i));
            assert_eq!((x.abs(), y.abs(), z.abs()), (DVec3::Z, DVec3::Y, DVec3::X));
        }
        for i in 6..WIDTH {
            assert_eq!(
                sides.map(|axis| lane(axis, i)),
                [DVec3::X, DVec3::Y, DVec3::Z]
            );
        }
    }
}
