//! The orientation of a node: the rotation in which its children's boxes are smallest.
//!
//! Axis-aligned boxes are loose where a part lies slanted in its file or is a slanted thin sheet. So each wide node takes,
//! top-down, the candidate whose children promise the smallest boxes: the orientation of its parent, the principal axes of its
//! triangles' normals, the dominant normal with the longest principal axis of the surface, and the axes of the largest
//! triangle ([`super::axes`]). The box of a child is guessed from its covariance, that of a triangle is computed.

use super::Effort;
use super::axes::Moments;
use super::columns::Columns;
use super::unit::Triangle;
use super::wide::WIDTH;
use crate::math::tolerance::ROUNDING;
use alloc::vec::Vec;
use glam::{DMat3, Mat3, Mat3A};

/// The id of an orientation chosen for the whole mesh; those of nodes follow.
pub(super) const MESH_ORIENTATION: u32 = 1;

/// The columns of `rotation` are the axes of a node's boxes, unit coordinates; equal ids mean equal orientations.
#[derive(Clone, Copy)]
pub(super) struct Orientation {
    pub rotation: Mat3A,
    pub id: u32,
}

impl Orientation {
    pub const IDENTITY: Self = Self { rotation: Mat3A::IDENTITY, id: 0 };

    /// Whether it is a rotation as nearly as the margins of a query need it: `|Q Q^T - I|` and `|Q^T Q - I|` at most 4
    /// roundings an entry (`docs/numerics.md`).
    pub fn is_orthonormal(&self) -> bool {
        let q = Mat3::from(self.rotation).as_dmat3();
        let small = |x: f64| x.abs() <= f64::from(4.0 * ROUNDING);
        let is_identity = |m: DMat3| (m - DMat3::IDENTITY).to_cols_array().into_iter().all(small);
        is_identity(q * q.transpose()) && is_identity(q.transpose() * q) && q.determinant() > 0.0
    }

    /// Whichever has the least cost: this one, or a new one with the given id.
    pub fn or_better(self, candidates: &[Mat3A], id: u32, cost: impl Fn(&Mat3A) -> f32) -> Self {
        let mut best = (None, cost(&self.rotation));
        for candidate in candidates {
            let cost = cost(candidate);
            if cost < best.1 {
                best = (Some(candidate), cost);
            }
        }
        let new = |candidate: &Mat3A| Self { rotation: orthonormal(candidate), id };
        best.0.map_or(self, new)
    }
}

/// The orientation in which single triangles have the smallest boxes, so that the binary tree, which splits along its axes,
/// does not depend on how a part lies in its file. `O(samples)`.
pub(super) fn align(samples: &[Triangle]) -> Orientation {
    // An orientation that is hardly better than the mesh's own is chance.
    const MARGIN: f32 = 0.95;
    let chunks = || samples.chunks(WIDTH).enumerate();
    let mut merged: Vec<Moments> = chunks().map(|(i, chunk)| Moments::of_triangles(chunk, i * WIDTH)).collect();
    while merged.len() > 1 {
        merged = merged.chunks(WIDTH).map(Moments::of_all).collect();
    }
    let [whole] = merged[..] else { return Orientation::IDENTITY };
    let candidates = Moments::of_all(&[whole]).candidates().of_lane(0, samples, Effort::Normal);
    let cost = |axes: &Mat3A| {
        let boxes: f32 = chunks().map(|(_, chunk)| Columns::of(chunk).cost(axes)).sum();
        if *axes == Mat3A::IDENTITY { boxes * MARGIN } else { boxes }
    };
    Orientation::IDENTITY.or_better(&candidates, MESH_ORIENTATION, cost)
}

/// The right-handed rotation, orthonormal up to one rounding of each entry, that agrees best with the first column of `m`,
/// then with its second.
fn orthonormal(m: &Mat3A) -> Mat3A {
    let x = m.x_axis.as_dvec3().normalize();
    let y = m.y_axis.as_dvec3();
    let y = (y - x * x.dot(y)).normalize();
    Mat3A::from_cols(x.as_vec3a(), y.as_vec3a(), x.cross(y).as_vec3a())
}
