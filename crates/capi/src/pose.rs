//! Points, boxes and poses.

use crate::status::{Fault, given};
use crate::verbs::{calls, types};
use core::mem::MaybeUninit;
use punctual::Pose;
use punctual::glam::{DQuat, DVec3};

types! {
    /// A point or a vector, in the length unit of the mesh.
    plain punctual_point from (point: DVec3) {
        /// Along the x axis.
        x: f64 = point.x,
        /// Along the y axis.
        y: f64 = point.y,
        /// Along the z axis.
        z: f64 = point.z,
    }

    /// A box that is parallel to the axes; empty if `min` exceeds `max`.
    plain punctual_aabb from (aabb: punctual::Aabb) {
        /// Smallest coordinates.
        min: punctual_point = aabb.min.into(),
        /// Largest coordinates.
        max: punctual_point = aabb.max.into(),
    }

    /// A rotation followed by a translation: the 3 x 4 matrix `[R|t]`, row by row. `b_in_a` maps
    /// coordinates of B to those of A: `((m[0]*x + m[1]*y) + m[2]*z) + m[3]` and so on, in double,
    /// rounded after each operation.
    ///
    /// It is checked wherever it is used (finite, no entry of `|R^T R - I|` above 1e-3, no mirror)
    /// and then used as it is.
    plain punctual_pose from (pose: &Pose) {
        /// Row by row; `m[3]`, `m[7]` and `m[11]` are the translation, in the length unit of the
        /// meshes.
        m: [f64; 12] = pose.to_row_major(),
    }
}

impl punctual_point {
    pub(crate) const ZERO: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
    };

    pub(crate) fn numbers(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl punctual_pose {
    pub(crate) const IDENTITY: Self = Self {
        m: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    };

    pub(crate) fn check(&self) -> Result<Pose, Fault> {
        Ok(Pose::from_row_major(self.m)?)
    }
}

/// The pose that maps every point to itself.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_pose_identity() -> punctual_pose {
    punctual_pose::IDENTITY
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
