//! Principal axes of up to eight subtrees at a time, one a lane.
//!
//! The surface of a subtree is summed up by its [`Moments`]: area, mean, covariance, second moment of the normals, and the
//! largest triangle. Those of a node follow from those of its children, so all nodes together cost `O(n)`. Everything here
//! is plain `f32` arithmetic in a fixed order, the same bits on every machine; an orientation only has to be good, and the one
//! that is taken is made orthonormal in `f64` ([`super::orientation`]).

use super::Effort;
use super::columns::{Columns, F, V, cross, dot, sums};
use super::unit::Triangle;
use super::wide::WIDTH;
use arrayvec::ArrayVec;
use glam::{Mat3A, Vec3A};

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
type Symmetric = [F; 6];

/// Lets areas of zero be divided by.
const TINY: f32 = 1e-30;

/// The surfaces of up to eight subtrees; a lane without area is empty.
#[derive(Clone, Copy)]
pub(super) struct Moments {
    area: F,
    mean: V,
    covariance: Symmetric,
    normals: Symmetric,
    /// The area of the largest triangle, and which it is.
    largest_area: F,
    largest: [u32; WIDTH],
}

impl Moments {
    pub const EMPTY: Self = Self {
        area: F::ZERO,
        mean: [F::ZERO; 3],
        covariance: [F::ZERO; 6],
        normals: [F::ZERO; 6],
        largest_area: F::ZERO,
        largest: [0; WIDTH],
    };

    /// Of up to eight single triangles, the first of which is number `first`.
    pub fn of_triangles(triangles: &[Triangle], first: usize) -> Self {
        let Columns { first: corner, edges: [e, f], present } = Columns::of(triangles);
        let normal = cross(e, f);
        // A triangle without area still has a place.
        let area = dot(normal, normal).sqrt() + F::splat(TINY);
        let (ee, ff, gg) = (square(e), square(f), square(each(|k| e[k] + f[k])));
        let (third, part) = (F::splat(1.0 / 3.0), F::splat(1.0 / 36.0));
        Self {
            area: area * present,
            mean: each(|k| corner[k] + (e[k] + f[k]) * third),
            // (2 e e^T + 2 f f^T - e f^T - f e^T) / 36
            covariance: entries(|k| ((ee[k] + ff[k]) * F::splat(3.0) - gg[k]) * part),
            normals: square(normal).map(|x| x * present / area),
            largest_area: area * present,
            largest: core::array::from_fn(|i| (first + i) as u32),
        }
    }

    /// Puts the moments of all lanes of `parts` together into lane `lane`.
    pub fn set(&mut self, lane: usize, parts: &Self) {
        let w = parts.area;
        let [area, x, y, z] = sums([w, w * parts.mean[0], w * parts.mean[1], w * parts.mean[2]]);
        let scale = 1.0 / area;
        let mean = [x * scale, y * scale, z * scale];
        let apart = square(each(|k| parts.mean[k] - F::splat(mean[k])));
        let c = entries(|k| (parts.covariance[k] + apart[k]) * w);
        let n = &parts.normals;
        let [xx, yy, zz, xy] = sums([c[0], c[1], c[2], c[3]]);
        let [xz, yz, n0, n1] = sums([c[4], c[5], n[0], n[1]]);
        let normals = sums([n[2], n[3], n[4], n[5]]);
        put(&mut self.area, lane, area);
        for (k, x) in mean.into_iter().enumerate() {
            put(&mut self.mean[k], lane, x);
        }
        for (k, x) in [xx, yy, zz, xy, xz, yz].into_iter().enumerate() {
            put(&mut self.covariance[k], lane, x * scale);
        }
        for (k, x) in [n0, n1, normals[0], normals[1], normals[2], normals[3]].into_iter().enumerate() {
            put(&mut self.normals[k], lane, x);
        }
        let areas = parts.largest_area.to_array();
        let widest = (1..WIDTH).fold(0, |best, i| if areas[i] > areas[best] { i } else { best });
        put(&mut self.largest_area, lane, areas[widest]);
        self.largest[lane] = parts.largest[widest];
    }

    /// Each of up to eight put together in a lane of its own.
    pub fn of_all(parts: &[Self]) -> Self {
        let mut all = Self::EMPTY;
        for (lane, part) in parts.iter().enumerate() {
            all.set(lane, part);
        }
        all
    }

    /// Candidates for the orientations of all lanes.
    pub fn candidates(&self) -> Candidates {
        let longest = dominant(self.covariance);
        let (facing, normal) = eigenvectors(self.normals);
        // The second axis is the longest axis without what it has of the normal.
        let along = dot(longest, normal);
        let across = each(|k| longest[k] - normal[k] * along);
        let length = dot(across, across).sqrt();
        let parallel = length.simd_lt(F::splat(1e-3));
        let scale = F::ONE / length.fast_max(F::splat(1e-3));
        let mixed = [
            each(|k| parallel.bitselect(facing[0][k], normal[k])),
            each(|k| parallel.bitselect(facing[1][k], across[k] * scale)),
        ];
        Candidates { facing, mixed, largest: self.largest }
    }

    /// Summed surface area of boxes as large as the lanes' standard deviations along the columns of `axes`.
    pub fn cost(&self, axes: &Mat3A) -> f32 {
        let s = &self.covariance;
        let deviation = |a: Vec3A| {
            let [x, y, z] = a.to_array();
            let twice = F::splat(2.0 * x * y) * s[3] + F::splat(2.0 * x * z) * s[4] + F::splat(2.0 * y * z) * s[5];
            let variance = F::splat(x * x) * s[0] + F::splat(y * y) * s[1] + F::splat(z * z) * s[2] + twice;
            variance.fast_max(F::ZERO).sqrt()
        };
        area(deviation(axes.x_axis), deviation(axes.y_axis), deviation(axes.z_axis))
    }
}

impl Columns {
    /// Summed surface area of the triangles' boxes along the columns of `axes`.
    pub fn cost(&self, axes: &Mat3A) -> f32 {
        let extent = |a: Vec3A| {
            let a = a.to_array().map(F::splat);
            let (e, f) = (dot(a, self.edges[0]), dot(a, self.edges[1]));
            e.fast_max(f).fast_max(F::ZERO) - e.fast_min(f).fast_min(F::ZERO)
        };
        area(extent(axes.x_axis) * self.present, extent(axes.y_axis), extent(axes.z_axis) * self.present)
    }
}

/// Orientations to choose from, for each lane; orthogonal up to some roundings.
pub(super) struct Candidates {
    /// Principal axes of the normals.
    facing: [V; 3],
    /// The dominant normal, and across it the longest axis of the surface.
    mixed: [V; 2],
    largest: [u32; WIDTH],
}

impl Candidates {
    pub fn of_lane(&self, lane: usize, triangles: &[Triangle], effort: Effort) -> ArrayVec<Mat3A, 5> {
        let axis = |v: &V| Vec3A::from_array([0, 1, 2].map(|k| v[k].as_array()[lane]));
        let [x, y, z] = self.facing.each_ref().map(axis);
        let [normal, second] = self.mixed.each_ref().map(axis);
        let mut candidates = ArrayVec::new();
        candidates.push(Mat3A::from_cols(x, y, z));
        candidates.push(Mat3A::from_cols(normal, second, normal.cross(second)));
        let largest = Sides::of(&triangles[self.largest[lane] as usize]);
        candidates.push(largest.orientation(largest.middle));
        if effort == Effort::Best {
            candidates.push(largest.orientation(largest.longest));
            candidates.push(Mat3A::IDENTITY);
        }
        candidates
    }
}

/// A triangle's normal and its edges of middle length, which is a side of the rectangle where two triangles make one up,
/// and of largest.
struct Sides {
    normal: Vec3A,
    middle: Vec3A,
    longest: Vec3A,
}

impl Sides {
    fn of(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.corners().map(Vec3A::from);
        let (e, f, g) = (b - a, c - a, c - b);
        let (ee, ff, gg) = (e.length_squared(), f.length_squared(), g.length_squared());
        let (longest, [(p, pp), (q, qq)]) = if ee >= ff.max(gg) {
            (e, [(f, ff), (g, gg)])
        } else if ff >= gg {
            (f, [(e, ee), (g, gg)])
        } else {
            (g, [(e, ee), (f, ff)])
        };
        Self { normal: e.cross(f), middle: if pp >= qq { p } else { q }, longest }
    }

    /// The orientation of the normal and `side`.
    fn orientation(&self, side: Vec3A) -> Mat3A {
        match (self.normal.try_normalize(), side.try_normalize()) {
            (Some(x), Some(y)) => Mat3A::from_cols(x, y, x.cross(y)),
            _ => Mat3A::IDENTITY,
        }
    }
}

fn put(v: &mut F, lane: usize, x: f32) {
    v.as_mut_array()[lane] = x;
}

#[inline(always)]
fn each(f: impl Fn(usize) -> F) -> V {
    [f(0), f(1), f(2)]
}

#[inline(always)]
fn entries(f: impl Fn(usize) -> F) -> Symmetric {
    [f(0), f(1), f(2), f(3), f(4), f(5)]
}

#[inline(always)]
fn square([x, y, z]: V) -> Symmetric {
    [x * x, y * y, z * z, x * y, x * z, y * z]
}

/// Half the summed surface area of boxes.
fn area(x: F, y: F, z: F) -> f32 {
    let [area, ..] = sums([x * y + y * z + z * x, F::ZERO, F::ZERO, F::ZERO]);
    area
}

/// Eigenvectors of the largest eigenvalues: a column of a high power of each matrix, by squaring.
fn dominant(mut m: Symmetric) -> V {
    for _ in 0..6 {
        let scale = F::ONE / (m[0] + m[1] + m[2] + F::splat(TINY));
        let [xx, yy, zz, xy, xz, yz] = m.map(|x| x * scale);
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
    let (z_over_y, x_largest) = (yy.simd_lt(zz), yy.fast_max(zz).simd_lt(xx));
    let v = each(|k| x_largest.bitselect(column[0][k], z_over_y.bitselect(column[2][k], column[1][k])));
    let scale = F::ONE / (dot(v, v) + F::splat(TINY)).sqrt();
    v.map(|x| x * scale)
}

/// Eigenvectors of symmetric matrices, in no order, and of each the one with the largest eigenvalue (Jacobi rotations).
fn eigenvectors(m: Symmetric) -> ([V; 3], V) {
    let (o, l) = (F::ZERO, F::ONE);
    let scale = l / (m[0] + m[1] + m[2] + F::splat(TINY));
    let [xx, yy, zz, xy, xz, yz] = m.map(|x| x * scale);
    let mut diagonal = [xx, yy, zz];
    // The entry that is not in row and column k.
    let mut other = [yz, xz, xy];
    let mut axes = [[l, o, o], [o, l, o], [o, o, l]];
    // Convergence is quadratic.
    for _ in 0..3 {
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let (difference, twice) = (diagonal[q] - diagonal[p], other[r] + other[r]);
            let root = (difference * difference + twice * twice).sqrt();
            let t = difference.simd_lt(o).bitselect(-twice, twice) / (difference.abs() + root + F::splat(TINY));
            let c = l / (t * t + l).sqrt();
            let s = t * c;
            let shift = t * other[r];
            diagonal[p] -= shift;
            diagonal[q] += shift;
            other[r] = o;
            (other[q], other[p]) = (c * other[q] - s * other[p], s * other[q] + c * other[p]);
            let (a, b) = (axes[p], axes[q]);
            axes[p] = each(|k| c * a[k] - s * b[k]);
            axes[q] = each(|k| s * a[k] + c * b[k]);
        }
    }
    let [x, y, z] = diagonal;
    let (z_over_y, x_largest) = (y.simd_lt(z), y.fast_max(z).simd_lt(x));
    let longest = each(|k| x_largest.bitselect(axes[0][k], z_over_y.bitselect(axes[2][k], axes[1][k])));
    (axes, longest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat, DVec3};

    fn matrices() -> [DMat3; WIDTH] {
        core::array::from_fn(|i| {
            let i = i as f64;
            let r = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.3 * i, -1.1, 0.7 - 0.2 * i)));
            r * DMat3::from_diagonal(DVec3::new(1.0, 5.0, i) * 1e-6) * r.transpose()
        })
    }

    #[test]
    fn eigenvectors_diagonalise_all_lanes() {
        let matrices = matrices();
        let entry = |i: usize, j: usize| F::new(matrices.map(|m| m.col(i)[j] as f32));
        let (axes, longest) =
            eigenvectors([entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]);
        for (lane, m) in matrices.iter().enumerate() {
            let column = |v: V| DVec3::from_array(v.map(|x| f64::from(x.as_array()[lane])));
            let q = DMat3::from_cols(column(axes[0]), column(axes[1]), column(axes[2]));
            assert!((q.transpose() * q).abs_diff_eq(DMat3::IDENTITY, 1e-5));
            let d = q.transpose() * *m * q;
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                assert!(d.col(i)[j].abs() < 1e-11, "{d}");
            }
            let v = column(longest);
            let largest = d.col(0)[0].max(d.col(1)[1]).max(d.col(2)[2]);
            assert!((v.dot(*m * v) - largest).abs() < 1e-11);
        }
    }

    #[test]
    fn eigenvectors_of_nothing_are_a_orientation() {
        let (axes, _) = eigenvectors([F::ZERO; 6]);
        assert_eq!(axes[0].map(|x| x.to_array()[3]), [1.0, 0.0, 0.0]);
        assert_eq!(axes[2].map(|x| x.to_array()[7]), [0.0, 0.0, 1.0]);
    }
}
