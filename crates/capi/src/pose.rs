//! Points, boxes and poses.

use crate::status::{Fault, given};
use crate::verbs::calls;
use core::mem::MaybeUninit;
use punctual::Pose;
use punctual::glam::{DQuat, DVec3};

/// A point or a vector, in the length unit of the mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_point {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
    /// Along the z axis.
    pub z: f64,
}

impl From<punctual::glam::DVec3> for punctual_point {
    fn from(point: punctual::glam::DVec3) -> Self {
        Self {
            x: point.x,
            y: point.y,
            z: point.z,
        }
    }
}

/// A box that is parallel to the axes; empty if `min` exceeds `max`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_aabb {
    /// Smallest coordinates.
    pub min: punctual_point,
    /// Largest coordinates.
    pub max: punctual_point,
}

impl From<punctual::Aabb> for punctual_aabb {
    fn from(aabb: punctual::Aabb) -> Self {
        Self {
            min: aabb.min.into(),
            max: aabb.max.into(),
        }
    }
}

/// A rotation followed by a translation: the 3 x 4 matrix `[R|t]`, row by row. `b_in_a` maps
/// coordinates of B to those of A: `((m[0]*x + m[1]*y) + m[2]*z) + m[3]` and so on, in double,
/// rounded after each operation.
///
/// It is checked wherever it is used (finite, no entry of `|R^T R - I|` above 1e-3, no mirror) and
/// then used as it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_pose {
    /// Row by row; `m[3]`, `m[7]` and `m[11]` are the translation, in the length unit of the
    /// meshes.
    pub m: [f64; 12],
}

impl punctual_pose {
    pub(crate) fn check(&self) -> Result<Pose, Fault> {
        Ok(Pose::from_row_major(self.m)?)
    }
}

impl From<&Pose> for punctual_pose {
    fn from(pose: &Pose) -> Self {
        Self {
            m: pose.to_row_major(),
        }
    }
}

/// The pose that maps every point to itself.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_pose_identity() -> punctual_pose {
    (&Pose::IDENTITY).into()
}

calls! {
    /// A pose from a quaternion, which is normalised first, and a translation.
    ///
    /// Fails with BAD_POSE if the quaternion is zero or a number is not finite.
    fn punctual_pose_from_quaternion(
        x: f64, y: f64, z: f64, w: f64, translation: punctual_point,
        pose: Option<&mut MaybeUninit<punctual_pose>>
    ) {
        let translation = DVec3::new(translation.x, translation.y, translation.z);
        write(pose, || Ok(Pose::from_quat(DQuat::from_xyzw(x, y, z, w), translation)?))
    }

    /// `outer` after `inner`, rounded: of `b_in_a` and `c_in_b`, `c_in_a`.
    ///
    /// Fails with BAD_POSE if one of them or the result is no pose.
    fn punctual_pose_compose(
        outer: punctual_pose, inner: punctual_pose, pose: Option<&mut MaybeUninit<punctual_pose>>
    ) {
        write(pose, || Ok(outer.check()?.compose(&inner.check()?)?))
    }

    /// The inverse map, rounded: of `b_in_a`, `a_in_b`.
    ///
    /// Fails with BAD_POSE if it or the result is no pose.
    fn punctual_pose_inverse(of: punctual_pose, pose: Option<&mut MaybeUninit<punctual_pose>>) {
        write(pose, || Ok(of.check()?.inverse()?))
    }
}

fn write(
    out: Option<&mut MaybeUninit<punctual_pose>>,
    make: impl FnOnce() -> Result<Pose, Fault>,
) -> Result<(), Fault> {
    given(out, "pose")?.write((&make()?).into());
    Ok(())
}
