//! The diminishing factor of a subtree, the paper's `alpha`: the factor by which boxes shrink from
//! one binary level to the next.
//!
//! It is measured when a tree is built or refitted. Each node stores the logarithm of the product
//! over the three axes, which is all that queries need; the factors of single axes are for
//! statistics.

use glam::Vec3;

/// `alpha_k = (mean leaf extent_k / node extent_k)^(1/h)`, where `h = log2(triangles)` is the
/// height of a balanced binary tree; 1 if there is nothing to shrink.
pub(crate) fn alpha(leaf: Vec3, own: Vec3, triangles: u32) -> Vec3 {
    if triangles < 2 {
        return Vec3::ONE;
    }
    let exponent = 1.0 / libm::log2f(triangles as f32);
    let shrinking = |k: usize| {
        if own[k] > 0.0 {
            (leaf[k] / own[k]).clamp(f32::MIN_POSITIVE, 1.0)
        } else {
            1.0
        }
    };
    Vec3::from_array([0, 1, 2].map(|k| libm::powf(shrinking(k), exponent)))
}

/// log2 of the product of the three factors of [`alpha`], for `levels = log2(triangles)`, within
/// `2e-4 / levels`. A ratio of extents below `1e-12` counts as that. The same bits on every
/// machine, and cheap enough for a refit.
#[inline(always)]
pub(crate) fn log_alpha(leaf: Vec3, own: Vec3, levels: f32) -> f32 {
    if levels == 0.0 {
        return 0.0;
    }
    let shrinking = |k: usize| {
        if own[k] > 0.0 {
            (leaf[k] / own[k]).clamp(1e-12, 1.0)
        } else {
            1.0
        }
    };
    log2(shrinking(0) * shrinking(1) * shrinking(2)) / levels
}

/// log2 of a positive normal number, within `2e-4`. A polynomial for the mantissa `m`, exact at 1
/// and 2; its inner factor minimizes the largest error.
#[inline(always)]
fn log2(x: f32) -> f32 {
    let exponent = (x.to_bits() >> 23) as f32 - 127.0;
    let m = f32::from_bits(x.to_bits() & 0x007f_ffff | 0x3f80_0000);
    let inner = (0.403_319 - 0.082_130_5 * m) * m - 0.759_914_2;
    exponent + (m - 1.0) * (1.0 + (m - 2.0) * inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_to_shrink_is_alpha_one_and_points_in_a_box_are_zero() {
        assert_eq!(alpha(Vec3::ONE, Vec3::ONE, 1), Vec3::ONE);
        let alpha = alpha(Vec3::new(0.0, 0.25, 0.0), Vec3::new(0.0, 1.0, 1.0), 4);
        assert!(
            (alpha - Vec3::new(1.0, 0.5, 0.0)).abs().max_element() < 1e-6,
            "{alpha}"
        );
    }

    #[test]
    fn the_stored_logarithm_is_that_of_the_product() {
        let own = Vec3::new(1.0, 2.0, 0.0);
        for triangles in [2_u32, 3, 7, 100, 70_000] {
            let levels = libm::log2f(triangles as f32);
            for i in 1..200 {
                let leaf = Vec3::new(0.005, 0.01, 0.0) * i as f32;
                let product = alpha(leaf, own, triangles).element_product();
                let error = log_alpha(leaf, own, levels) - libm::log2f(product);
                assert!(
                    error.abs() < 2e-4 / levels + 1e-6,
                    "{triangles} {leaf}: {error}"
                );
            }
        }
        assert_eq!(log_alpha(Vec3::ONE, Vec3::ONE, 0.0), 0.0);
        let points = log_alpha(Vec3::ZERO, Vec3::ONE, 1.0);
        assert!(points.is_finite() && points < -119.0, "{points}");
    }
}
