//! The diminishing factor of a subtree: the factor by which boxes shrink from one binary level to
//! the next.

use glam::Vec3;

/// `alpha_k = (mean leaf extent_k / node extent_k)^(1/h)`, where `h = log2(triangles)` is the
/// height of a balanced binary tree; 1 if there is nothing to shrink.
pub(super) fn alpha(leaf: Vec3, own: Vec3, triangles: u32) -> Vec3 {
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
}
