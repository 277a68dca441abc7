//! The orientation of a node's boxes.

use glam::{DMat3, DVec3, Mat3, Mat3A};
use punctual_geom::tolerance::ROUNDING;
use wide::f64x2;

/// Id of an orientation chosen for the whole mesh. Ids of orientations chosen for single nodes are
/// larger.
pub(crate) const MESH_ORIENTATION: u32 = 1;

/// The columns of `rotation` are the axes of a node's boxes, in unit coordinates. Equal ids mean
/// equal orientations.
#[derive(Clone, Copy)]
pub(crate) struct Orientation {
    pub rotation: Mat3A,
    pub id: u32,
}

impl Orientation {
    pub const IDENTITY: Self = Self {
        rotation: Mat3A::IDENTITY,
        id: 0,
    };

    /// Makes axes orthonormal that are orthogonal up to some roundings.
    #[inline(always)]
    pub fn of(axes: &Mat3A, id: u32) -> Self {
        Self::along([axes.x_axis.as_dvec3(), axes.y_axis.as_dvec3()], id)
    }

    /// The right-handed rotation whose first axis has the direction of `x`, and whose second is
    /// closest to that of `y`. It is orthonormal up to one rounding of each entry.
    #[inline(always)]
    pub fn along([x, y]: [DVec3; 2], id: u32) -> Self {
        let x = normalized(x);
        let y = normalized(y - x * x.dot(y));
        let rotation = Mat3A::from_cols(x.as_vec3a(), y.as_vec3a(), x.cross(y).as_vec3a());
        Self { rotation, id }
    }

    /// True if this is a rotation to the accuracy that the margins of a query need: `|Q Q^T - I|`
    /// and `|Q^T Q - I|` are at most 4 roundings per entry (`docs/numerics.md`).
    pub fn is_orthonormal(&self) -> bool {
        let q = Mat3::from(self.rotation).as_dmat3();
        let small = |x: f64| x.abs() <= f64::from(4.0 * ROUNDING);
        let is_identity = |m: DMat3| (m - DMat3::IDENTITY).to_cols_array().into_iter().all(small);
        is_identity(q * q.transpose()) && is_identity(q.transpose() * q) && q.determinant() > 0.0
    }
}

#[inline(always)]
fn normalized(v: DVec3) -> DVec3 {
    // The square root of `libm` is an instruction that stalls AVX code for a hundred cycles.
    let [length, _] = f64x2::splat(v.length_squared()).sqrt().to_array();
    v * (1.0 / length)
}
