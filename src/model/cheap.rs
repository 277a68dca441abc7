//! The cheap cost: one stored number a node, for a look at every pair of a front.
//!
//! A node keeps `g`, the logarithm of what it costs against its like, the mean over all placements ([`super::moments`],
//! with the product of the means for the mean of the products). Two nodes share their cost by the geometric mean, and a
//! deep overlap of their boxes costs more than a shallow one.

use glam::DVec3;

/// `g = log2(1 + sum_{l<h} 4 n_l^2 prod_k e_k(l) / e_k(0))`: log2 of the expected BV tests of a binary subtree of height
/// `h` against its like. Item `l` of `levels`, from the node itself at `l = 0` on, has the number of boxes and their mean
/// extent; the level of the leaves is left out, since nothing below it is tested. 0 for a leaf.
pub fn self_cost(levels: impl IntoIterator<Item = (f64, DVec3)>) -> f64 {
    let mut levels = levels.into_iter().peekable();
    let Some(&(_, root)) = levels.peek() else {
        return 0.0;
    };
    let ratio = |e: DVec3, k: usize| if root[k] > 0.0 { (e[k] / root[k]).min(1.0) } else { 1.0 };
    let tests = levels.map(|(n, e)| 4.0 * n * n * ratio(e, 0) * ratio(e, 1) * ratio(e, 2));
    libm::log2(1.0 + tests.sum::<f64>())
}

/// Relative overlap volume of two boxes, `prod_k (o_k + eps) / (2 min(a_k, b_k) + eps)`, with the overlap
/// `o_k = clamp(a_k + b_k - |c_k|, 0, 2 min(a_k, b_k))` and `eps = 1e-3 (a_k + b_k) + 1e-9`: 1 if one holds the other,
/// near 0 if they barely meet. `a` and `b` are half extents in one frame, `c` is the offset of the centres.
pub fn relative_volume(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let axis = |k: usize| {
        let least = 2.0 * a[k].min(b[k]);
        let overlap = (a[k] + b[k] - c[k].abs()).max(0.0).min(least);
        let eps = 1e-3 * (a[k] + b[k]) + 1e-9;
        (overlap + eps) / (least + eps)
    };
    axis(0) * axis(1) * axis(2)
}

/// The cost of a pair, up to a factor: `c = 2^((g_A + g_B) / 4 + log2(relvol) / 2)`.
pub fn pair_cost(g_a: f64, g_b: f64, relative_volume: f64) -> f64 {
    libm::exp2(0.25 * (g_a + g_b)) * libm::sqrt(relative_volume)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_self_cost_by_hand() {
        assert_eq!(self_cost([]), 0.0);
        // A node above two leaves: its four tests.
        assert_eq!(self_cost([(1.0, DVec3::ONE)]), f64::log2(5.0));
        // One more level, boxes half as large along x: 4 + 4 * 4 / 2.
        assert_eq!(self_cost([(1.0, DVec3::ONE), (2.0, DVec3::new(0.5, 1.0, 1.0))]), f64::log2(13.0));
        // A flat node: the axis without extent does not count.
        assert_eq!(self_cost([(1.0, DVec3::new(1.0, 1.0, 0.0))]), f64::log2(5.0));
    }

    #[test]
    fn the_self_cost_follows_equation_11() {
        let alpha: f64 = 0.8;
        let levels = (0..9).map(|l| (f64::powi(2.0, l), DVec3::splat(alpha.powi(l))));
        let expected = 1.0 + 4.0 * crate::model::paper::eq11([alpha; 3], 8);
        assert!((self_cost(levels) - expected.log2()).abs() < 1e-12);
    }

    #[test]
    fn relative_volumes() {
        let one = DVec3::ONE;
        let at = |c: DVec3| relative_volume(one, one * 0.5, c);
        assert_eq!([at(DVec3::ZERO), at(one * 0.5)], [1.0, 1.0]);
        let half = at(DVec3::X);
        assert!((half - 0.5).abs() < 1e-3, "{half}");
        assert!(at(DVec3::X * 1.5) < 2e-3 && at(DVec3::X * 9.0) == at(DVec3::X * 1.5));
        assert!((at(DVec3::new(1.0, -1.0, 0.0)) - half * half).abs() < 1e-15);
        assert_eq!(relative_volume(DVec3::ZERO, DVec3::ZERO, DVec3::ZERO), 1.0);
    }

    #[test]
    fn the_pair_cost_by_hand() {
        assert_eq!(pair_cost(0.0, 0.0, 1.0), 1.0);
        assert_eq!(pair_cost(6.0, 10.0, 0.25), 8.0);
    }
}
