//! Exact predicates and proven bounds of triangles, with poses, boxes, motions and rays.
//!
//! The base of the crate `punctual`, which re-exports what its users need. Nothing here knows a
//! tree. The modules, macros and functions serve the other crates of the library and may change
//! with every version; the kernels of queries, `lanes` and `triangle`, are hidden.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![allow(
    rustdoc::private_intra_doc_links,
    reason = "comments of hidden modules speak to readers of the code"
)]

extern crate alloc;

#[cfg(all(target_arch = "x86", not(target_feature = "sse2")))]
compile_error!(
    "punctual needs SSE2 on x86: x87 rounds differently, so bounds and answers could be false"
);

mod aabb;
#[cfg(feature = "serde")]
pub mod bound;
pub mod denormals;
#[doc(hidden)]
pub mod lanes;
mod motion;
mod names;
mod pose;
pub mod random;
mod ray;
pub mod tolerance;
#[doc(hidden)]
pub mod triangle;

pub use aabb::Aabb;
pub use motion::{Motion, MotionError};
pub use names::UnknownName;
pub use pose::{Pose, PoseError, rotation_deviation};
pub use ray::{Ray, RayError};
pub use triangle::ray::Side;
pub use triangle::{triangle_segment, triangles_intersect, triangles_intersect_beyond_shared};

/// The length of a vector, computed without overflow or underflow of its square.
#[inline]
pub fn length(v: glam::DVec3) -> f64 {
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
#[inline]
pub fn nanoseconds(time: core::time::Duration) -> f64 {
    time.as_secs() as f64 * 1e9 + f64::from(time.subsec_nanos())
}

/// Positions of the set bits of a mask, lowest first.
#[inline(always)]
pub fn bits(mask: impl Into<u64>) -> impl Iterator<Item = usize> {
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
pub fn larger<T: PartialOrd>(x: T, y: T) -> T {
    if x > y { x } else { y }
}

/// The smaller of two numbers; see [`larger`].
#[inline(always)]
pub fn smaller<T: PartialOrd>(x: T, y: T) -> T {
    if x < y { x } else { y }
}

/// The largest component.
#[inline(always)]
pub fn largest(v: glam::DVec3) -> f64 {
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
