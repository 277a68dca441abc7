//! Boxes, poses, rays, motions, SIMD lanes and tolerances: the base of all other modules.

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

/// The length of a vector, computed without overflow or underflow of its square.
pub(crate) fn length(v: glam::DVec3) -> f64 {
    let length = v.length();
    if (1e-140..1e140).contains(&length) {
        return length;
    }
    let largest = v.abs().max_element();
    if largest == 0.0 {
        0.0
    } else {
        largest * (v / largest).length()
    }
}

/// Converts a duration to nanoseconds. Avoids `Duration::as_nanos`: its 128-bit conversion takes as
/// long as a clock read.
pub(crate) fn nanoseconds(time: core::time::Duration) -> f64 {
    time.as_secs() as f64 * 1e9 + f64::from(time.subsec_nanos())
}

/// Positions of the set bits of a mask, lowest first.
#[inline(always)]
pub(crate) fn bits(mask: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut mask = mask.into();
    core::iter::from_fn(move || {
        let bit = if mask == 0 {
            None
        } else {
            Some(mask.trailing_zeros() as usize)
        };
        mask &= mask.wrapping_sub(1);
        bit
    })
}

/// The larger of two numbers. Four times as fast as `f64::max` and `f32::max`, which handle NaN.
#[inline(always)]
pub(crate) fn larger<T: PartialOrd>(x: T, y: T) -> T {
    if x > y { x } else { y }
}

/// The smaller of two numbers; see [`larger`].
#[inline(always)]
pub(crate) fn smaller<T: PartialOrd>(x: T, y: T) -> T {
    if x < y { x } else { y }
}

/// The largest component.
#[inline(always)]
pub(crate) fn largest(v: glam::DVec3) -> f64 {
    larger(larger(v.x, v.y), v.z)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    #[test]
    fn vectors_of_every_length_have_their_length() {
        for length in [5e-324, 1e-300, 1e-140, 1e-139, 1.0, 1e139, 1e140, 1e300] {
            assert_eq!(super::length(DVec3::new(0.0, -length, 0.0)), length);
        }
    }
}
