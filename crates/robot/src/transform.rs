//! Rigid transforms of the inner loops: rotations are orthonormal up to rounding.

use punctual::Pose;
use punctual::glam::{DMat3, DVec3};
use punctual_geom::rotation_deviation;

use crate::RobotError;
use crate::model::LARGEST;

/// A pose is used as given up to this deviation from a rotation.
const ORTHONORMAL: f64 = 1e-14;

/// A pose is refused beyond this deviation. Matrices of f32 numbers are within it.
const REFUSED: f64 = 1e-6;

/// Maps a point `p` to `r p + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transform {
    pub r: DMat3,
    pub t: DVec3,
}

impl Transform {
    pub const IDENTITY: Self = Self {
        r: DMat3::IDENTITY,
        t: DVec3::ZERO,
    };

    /// Takes a pose; one that is not orthonormal to rounding is replaced by the nearest that is.
    pub fn from_pose(pose: &Pose) -> Result<Self, RobotError> {
        let (r, t) = (*pose.rotation(), pose.translation());
        if t.abs().max_element() > LARGEST {
            return Err(RobotError::model(format!(
                "translation {t}, allowed is {LARGEST:e}"
            )));
        }
        let deviation = rotation_deviation(&r);
        if deviation <= ORTHONORMAL {
            return Ok(Self { r, t });
        }
        if deviation > REFUSED {
            return Err(RobotError::model(format!(
                "pose is off a rotation by {deviation:e}, allowed is {REFUSED:e}"
            )));
        }
        let x = r.x_axis.normalize();
        let z = x.cross(r.y_axis).normalize();
        let r = DMat3::from_cols(x, z.cross(x), z);
        Ok(Self { r, t })
    }

    pub fn pose(&self) -> Pose {
        Pose::unchecked(self.r, self.t)
    }

    #[inline]
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            r: self.r * inner.r,
            t: self.r * inner.t + self.t,
        }
    }

    /// `self` inverted, after `other`: the frame of `other` seen from the frame of `self`.
    #[inline]
    pub fn to(&self, other: &Self) -> Self {
        let inverse = self.r.transpose();
        Self {
            r: inverse * other.r,
            t: inverse * (other.t - self.t),
        }
    }

    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.r * p + self.t
    }

    /// Maps a point back.
    #[inline]
    pub fn point_back(&self, p: DVec3) -> DVec3 {
        self.r.transpose() * (p - self.t)
    }

    /// A rotation about x, then y, then z, all fixed, and a translation: how URDF states origins.
    #[cfg(feature = "urdf")]
    pub fn from_rpy([roll, pitch, yaw]: [f64; 3], t: [f64; 3]) -> Self {
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
        let r = DMat3::from_cols(
            DVec3::new(cy * cp, sy * cp, -sp),
            DVec3::new(cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
            DVec3::new(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
        );
        Self {
            r,
            t: DVec3::from_array(t),
        }
    }
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
