//! The frame of a node: the rotation in which its children's boxes are smallest.
//!
//! Axis-aligned boxes are loose where a part lies slanted in its file or is a slanted thin sheet. So each wide node takes,
//! top-down, the candidate with the least summed surface area of its children's boxes: the frame of its parent, the
//! mesh's own axes, the principal axes of its triangles and of their normals, and the dominant normal with the longest
//! principal axis. Axes and costs come from samples, so a node costs `O(1)`; its boxes are computed in full afterwards.

use super::unit::{Corners, Triangle, Unit};
use crate::mesh::Mesh;
use alloc::vec::Vec;
use core::ops::Range;
use glam::{DMat3, DVec3, Mat3A, Vec3A};

/// A node's frame: `rotation` maps frame to unit coordinates (its columns are the axes); equal ids mean equal frames.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub rotation: Mat3A,
    pub id: u32,
}

impl Frame {
    pub const IDENTITY: Self = Self { rotation: Mat3A::IDENTITY, id: 0 };
}

/// A box in some frame.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Extent {
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// The box of the given triangles in the frame that `to_frame` leads to.
    pub fn of<'t>(triangles: impl IntoIterator<Item = &'t Triangle>, to_frame: &Mat3A) -> Self {
        triangles.into_iter().flat_map(|t| t.corners()).fold(Self::EMPTY, |extent, corner| {
            let x = *to_frame * Vec3A::from(corner);
            Self { min: extent.min.min(x), max: extent.max.max(x) }
        })
    }

    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub fn center(&self) -> Vec3A {
        (self.min + self.max) * 0.5
    }

    pub fn half(&self) -> Vec3A {
        (self.max - self.min) * 0.5
    }

    /// Half the surface area.
    pub fn area(&self) -> f32 {
        let e = self.max - self.min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

/// Samples for the axes, and for the cost of one child's box.
const AXIS_SAMPLES: usize = 64;
const COST_SAMPLES: usize = 8;

/// The best frame for a node whose children hold the given ranges of `triangles`; a new one gets the id `next_id`.
pub(super) fn choose(parent: Frame, children: &[Range<usize>], triangles: &[Triangle], next_id: u32) -> Frame {
    let all = children[0].start..children[children.len() - 1].end;
    let mut best = (parent, cost(&parent.rotation, children, triangles));
    let own = principal_axes(&triangles[all]);
    for (rotation, id) in core::iter::once((Mat3A::IDENTITY, 0)).chain(own.map(|axes| (axes, next_id))) {
        if id != best.0.id || id == next_id {
            let cost = cost(&rotation, children, triangles);
            if cost < best.1 {
                best = (Frame { rotation, id }, cost);
            }
        }
    }
    best.0
}

/// Turns the corners of a mesh into the frame in which its triangles' boxes are smallest, so that the binary tree, which
/// splits along the axes, does not depend on how a part lies in its file. `O(n)`.
pub(super) fn align(corners: &mut [Corners], unit: &Unit, mesh: &Mesh) {
    const SAMPLES: usize = 512;
    let step = corners.len().div_ceil(SAMPLES).max(1);
    let ids: Vec<u32> = (0..corners.len() as u32).step_by(step).collect();
    let samples: Vec<Triangle> = unit.triangles(mesh, &ids).collect();
    let one_each: Vec<Range<usize>> = (0..samples.len()).map(|i| i..i + 1).collect();
    if one_each.is_empty() {
        return;
    }
    let to_frame = choose(Frame::IDENTITY, &one_each, &samples, 1).rotation.transpose();
    if to_frame != Mat3A::IDENTITY {
        for Corners(triangle) in corners {
            *triangle = triangle.map(|x| (to_frame * Vec3A::from(x)).into());
        }
    }
}

fn sampled<T>(all: &[T], samples: usize) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(samples).max(1))
}

/// Summed surface area of the children's boxes.
fn cost(rotation: &Mat3A, children: &[Range<usize>], triangles: &[Triangle]) -> f32 {
    let to_frame = rotation.transpose();
    let area = |child: &Range<usize>| Extent::of(sampled(&triangles[child.clone()], COST_SAMPLES), &to_frame).area();
    children.iter().map(area).sum()
}

/// Three candidates: principal axes of the surface, of its normals, and of both mixed.
fn principal_axes(triangles: &[Triangle]) -> [Mat3A; 3] {
    let (mut surface, mut normals) = (Moments::default(), Moments::default());
    for triangle in sampled(triangles, AXIS_SAMPLES) {
        let [a, b, c] = triangle.corners().map(|x| x.as_dvec3());
        let normal = (b - a).cross(c - a);
        // Triangles without area still have a place.
        let area = normal.length() + 1e-30;
        for (x, weight) in [(a, 1.0), (b, 1.0), (c, 1.0), ((a + b + c) / 3.0, 9.0)] {
            surface.add(x, area * weight / 12.0);
        }
        normals.add_direction(normal / area, area);
    }
    let spread = eigenvectors(surface.covariance());
    let facing = eigenvectors(normals.second);
    let normal = facing.x_axis;
    let mixed = orthonormal(normal, spread.x_axis).unwrap_or(facing);
    [spread, facing, mixed].map(|m| Mat3A::from_cols(m.x_axis.as_vec3a(), m.y_axis.as_vec3a(), m.z_axis.as_vec3a()))
}

/// Weighted sums of 1, x and x x^T.
#[derive(Default)]
struct Moments {
    weight: f64,
    first: DVec3,
    second: DMat3,
}

impl Moments {
    fn add(&mut self, x: DVec3, weight: f64) {
        self.weight += weight;
        self.first += x * weight;
        self.add_direction(x, weight);
    }

    fn add_direction(&mut self, x: DVec3, weight: f64) {
        let w = x * weight;
        self.second += DMat3::from_cols(x * w.x, x * w.y, x * w.z);
    }

    fn covariance(&self) -> DMat3 {
        let mean = self.first / self.weight;
        self.second - DMat3::from_cols(mean * self.first.x, mean * self.first.y, mean * self.first.z)
    }
}

/// Orthonormal eigenvectors of a symmetric matrix, largest eigenvalue first (cyclic Jacobi rotations).
fn eigenvectors(symmetric: DMat3) -> DMat3 {
    let mut m = symmetric.to_cols_array_2d();
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q].abs() <= 1e-12 * (m[p][p] + m[q][q]).abs() {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + DVec3::new(theta, 1.0, 0.0).length());
            let c = 1.0 / DVec3::new(t, 1.0, 0.0).length();
            let s = t * c;
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (m[p][k], m[q][k]) = (c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]);
                (axes[p][k], axes[q][k]) = (c * axes[p][k] - s * axes[q][k], s * axes[p][k] + c * axes[q][k]);
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| m[j][j].total_cmp(&m[i][i]));
    orthonormal(axes[order[0]].into(), axes[order[1]].into()).unwrap_or(DMat3::IDENTITY)
}

/// The right-handed frame with first axis along `x` and second in the plane of `x` and `y`; `None` if they are parallel.
fn orthonormal(x: DVec3, y: DVec3) -> Option<DMat3> {
    let x = x.try_normalize()?;
    let y = y - x * x.dot(y);
    let y = if y.length() > 1e-6 { y.normalize() } else { return None };
    Some(DMat3::from_cols(x, y, x.cross(y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_diagonalise() {
        let r = DMat3::from_quat(glam::DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7)));
        let m = r * DMat3::from_diagonal(DVec3::new(1.0, 5.0, 2.0)) * r.transpose();
        let axes = eigenvectors(m);
        let d = axes.transpose() * m * axes;
        let expected = DMat3::from_diagonal(DVec3::new(5.0, 2.0, 1.0));
        assert!(d.abs_diff_eq(expected, 1e-9), "{d}");
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn eigenvectors_of_nothing_are_a_frame() {
        for m in [DMat3::ZERO, DMat3::IDENTITY, DMat3::from_diagonal(DVec3::new(0.0, 1e-300, 0.0))] {
            let axes = eigenvectors(m);
            assert!((axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
    }
}
