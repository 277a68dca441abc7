//! Boxes, poses and tolerances: the ground every other module stands on.

mod aabb;
#[cfg(feature = "serde")]
pub(crate) mod bound;
pub(crate) mod denormals;
pub(crate) mod lanes;
pub(crate) mod motion;
pub(crate) mod pose;
pub(crate) mod random;
mod ray;
pub(crate) mod tolerance;

pub use aabb::Aabb;
pub use motion::{Motion, MotionError};
pub(crate) use pose::rotation_deviation;
pub use pose::{Pose, PoseError};
pub use ray::{Ray, RayError};

/// The length of a vector, whose square need not be a number.
pub(crate) fn length(v: glam::DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest == 0.0 { 0.0 } else { largest * (v / largest).length() }
}
