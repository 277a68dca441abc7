//! Rigid transforms of the inner loops: rotations are orthonormal up to rounding.

use punctual::Pose;
use punctual::glam::{DAffine3, DMat3, DVec3};
use punctual_geom::rotation_deviation;

use crate::RobotError;
use crate::error::refuse;
use crate::model::LARGEST;

/// A pose is used as given up to this deviation from a rotation.
const ORTHONORMAL: f64 = 1e-14;

/// A pose is refused beyond this deviation. Matrices of f32 numbers are within it.
const REFUSED: f64 = 1e-6;

/// Maps a point `p` to `matrix3 p + translation`.
pub(crate) type Transform = DAffine3;

/// Takes a pose; one that is not orthonormal to rounding is replaced by the nearest that is.
pub(crate) fn from_pose(pose: &Pose) -> Result<Transform, RobotError> {
    let (r, t) = (*pose.rotation(), pose.translation());
    let deviation = rotation_deviation(&r);
    if t.abs().max_element() > LARGEST {
        return refuse(format!("translation {t}, allowed is {LARGEST:e}"));
    }
    if deviation > REFUSED {
        let what = format!("pose is off a rotation by {deviation:e}");
        return refuse(format!("{what}, allowed is {REFUSED:e}"));
    }
    let is_fine = deviation <= ORTHONORMAL;
    let r = if is_fine { r } else { orthonormal(r) };
    Ok(Transform::from_mat3_translation(r, t))
}

pub(crate) fn to_pose(transform: &Transform) -> Pose {
    Pose::unchecked(transform.matrix3, transform.translation)
}

/// `b` seen from `a`.
#[inline]
pub(crate) fn relative(a: &Transform, b: &Transform) -> Transform {
    let inverse = a.matrix3.transpose();
    let t = inverse * (b.translation - a.translation);
    Transform::from_mat3_translation(inverse * b.matrix3, t)
}

/// A rotation about x, then y, then z, all fixed, and a translation: how URDF states origins.
#[cfg(feature = "urdf")]
pub(crate) fn from_rpy([roll, pitch, yaw]: [f64; 3], t: [f64; 3]) -> Transform {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let r = DMat3::from_cols(
        DVec3::new(cy * cp, sy * cp, -sp),
        DVec3::new(cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
        DVec3::new(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
    );
    Transform::from_mat3_translation(r, t.into())
}

/// A rotation near a matrix that is nearly one.
pub(crate) fn orthonormal(r: DMat3) -> DMat3 {
    let x = r.x_axis.normalize();
    let z = x.cross(r.y_axis).normalize();
    DMat3::from_cols(x, z.cross(x), z)
}

/// Rotation about a unit axis (Rodrigues' formula).
#[inline]
pub(crate) fn rotation_about(axis: DVec3, angle: f64) -> DMat3 {
    let (s, c) = angle.sin_cos();
    let ka = axis * (1.0 - c);
    let sa = axis * s;
    DMat3::from_cols(
        axis * ka.x + DVec3::new(c, sa.z, -sa.y),
        axis * ka.y + DVec3::new(-sa.z, c, sa.x),
        axis * ka.z + DVec3::new(sa.y, -sa.x, c),
    )
}
