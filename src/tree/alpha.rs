//! The diminishing factor of a subtree: the factor by which boxes shrink from one binary level to
//! the next.

use core::f32::consts::LN_2;
use glam::Vec3;
use punctual_geom::lanes::per_axis;
use wide::bytemuck::cast;
use wide::{f32x4, i32x4};

/// `alpha_k = (mean leaf extent_k / node extent_k)^(1/h)`, where `h = log2(triangles)` is the
/// height of a balanced binary tree; 1 if there is nothing to shrink.
pub(super) fn alpha(leaf: Vec3, own: Vec3, triangles: u32) -> Vec3 {
    if triangles < 2 {
        return Vec3::ONE;
    }
    let [x, y, z] = per_axis!(k => {
        if own[k] > 0.0 { (leaf[k] / own[k]).clamp(f32::MIN_POSITIVE, 1.0) } else { 1.0 }
    });
    let [x, y, z, height] = log2(f32x4::new([x, y, z, triangles as f32])).to_array();
    let [x, y, z, _] = exp2(f32x4::new([x, y, z, 0.0]) * f32x4::splat(1.0 / height)).to_array();
    Vec3::new(x, y, z)
}

/// log2 of positive normal numbers, off by less than 10^-6. Computes four at once, unlike `libm`.
#[inline(always)]
fn log2(x: f32x4) -> f32x4 {
    // x = 2^e m, m within sqrt(1/2)..sqrt(2).
    let half_root = i32x4::splat(0x3f35_04f3);
    let shifted = cast::<f32x4, i32x4>(x) - half_root;
    let m: f32x4 = cast((shifted & i32x4::splat(0x007f_ffff)) + half_root);
    let e: i32x4 = shifted >> 23_i32;
    // ln m = 2 artanh t
    let t = (m - f32x4::ONE) / (m + f32x4::ONE);
    let tt = t * t;
    e.round_float()
        + t * polynomial(
            tt,
            [
                2.0 / LN_2,
                2.0 / 3.0 / LN_2,
                2.0 / 5.0 / LN_2,
                2.0 / 7.0 / LN_2,
            ],
        )
}

/// 2^x for x within -126..=0, with a relative error below 10^-6.
#[inline(always)]
fn exp2(x: f32x4) -> f32x4 {
    let whole = (x - f32x4::HALF).fast_trunc_int();
    let y = (x - whole.round_float()) * f32x4::splat(LN_2);
    let power = polynomial(
        y,
        [
            1.0,
            1.0,
            0.5,
            1.0 / 6.0,
            1.0 / 24.0,
            1.0 / 120.0,
            1.0 / 720.0,
        ],
    );
    let exponent: i32x4 = (whole + i32x4::splat(127)) << 23_i32;
    power * cast::<i32x4, f32x4>(exponent)
}

/// The sum of `coefficients[i] * x^i`. No operation is fused.
#[inline(always)]
fn polynomial<const N: usize>(x: f32x4, coefficients: [f32; N]) -> f32x4 {
    let mut sum = f32x4::splat(coefficients[N - 1]);
    for i in (0..N - 1).rev() {
        sum = sum * x + f32x4::splat(coefficients[i]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_logarithms_are_those_of_libm() {
        let one = |f: fn(f32x4) -> f32x4, x: f32| f(f32x4::splat(x)).to_array()[2];
        for i in 1..=20_000 {
            let x = i as f32 / 20_000.0;
            for x in [x, 1.0 / x, x * 1e-30, 1.0 - x * 1e-6] {
                assert!(
                    (one(log2, x) - libm::log2f(x)).abs() < 1e-6 * libm::log2f(x).abs().max(1.0),
                    "{x}"
                );
            }
            let x = -126.0 * (i - 1) as f32 / 20_000.0;
            for x in [x, x / 100.0] {
                assert!((one(exp2, x) / libm::exp2f(x) - 1.0).abs() < 1e-6, "{x}");
            }
        }
    }

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
