//! The paper's equations, by number.
//!
//! `l` counts levels of the bounding volume test tree, 0 for the pair of roots; `d = log2 n` is the height of a binary tree
//! of `n` leaves; `alpha` the factor by which boxes shrink along an axis from one level to the next, in `0..=1`. `N_v` is
//! the number of box pairs that overlap; an engine that tests all four pairs of children makes `4 N_v` tests, less the
//! last level. Letters are the paper's.

use std::cmp::Ordering;

/// Eq 1: overlapping pairs on level `l`, `N^(l) = 4^l P[A^(l) meets B^(l)]`.
pub fn eq1(level: u32, probability: f64) -> f64 {
    libm::exp2(2.0 * f64::from(level)) * probability
}

/// Eq 2: `N_v = sum_{l=1..d} N^(l)`, from the probabilities on levels `1..=d`.
pub fn eq2(probabilities: &[f64]) -> f64 {
    (1..)
        .zip(probabilities)
        .map(|(level, &p)| eq1(level, p))
        .sum()
}

/// Eq 7, two dimensions, the overlap along x bounded by 1: `N_v <= ((4 a_y)^(d+1) - 1) / (4 a_y - 1)`.
pub fn eq7(alpha_y: f64, depth: u32) -> f64 {
    geometric_sum(4.0 * alpha_y, depth)
}

/// Eq 9, two dimensions: `N_v <= sum_{l=0..d} (4 a_x a_y)^l`.
///
/// An equality for the mean over all placements in which the roots meet, see [`super::moments`].
pub fn eq9(alpha: [f64; 2], depth: u32) -> f64 {
    geometric_sum(4.0 * alpha.iter().product::<f64>(), depth)
}

/// Eq 11, three dimensions: `N_v <= sum_{l=0..d} (4 a_x a_y a_z)^l`, with equality as for [`eq9`].
pub fn eq11(alpha: [f64; 3], depth: u32) -> f64 {
    geometric_sum(4.0 * alpha.iter().product::<f64>(), depth)
}

/// Eq 9 and 11 with factors that differ from level to level, as the paper allows before it sets them equal:
/// `N_v <= sum_l prod_{j<=l} 4 prod_k alpha_jk`, where `alphas[j - 1]` leads from level `j - 1` to level `j`.
pub fn visits_per_level_alpha<const D: usize>(alphas: &[[f64; D]]) -> f64 {
    alphas.iter().rev().fold(1.0, |below, alpha| {
        1.0 + 4.0 * alpha.iter().product::<f64>() * below
    })
}

/// `sum_{l=0..depth} q^l` by Horner's rule, which unlike `(q^(depth+1) - 1) / (q - 1)` is as accurate near `q = 1`.
fn geometric_sum(q: f64, depth: u32) -> f64 {
    (0..depth).fold(1.0, |sum, _| 1.0 + q * sum)
}

/// Table 1: how `N_v` grows with the number of leaves `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Growth {
    /// `O(1)`
    Constant,
    /// `O(log n)`
    Logarithmic,
    /// `O(n^exponent)`
    Power(f64),
}

impl Growth {
    /// The growth for a product of the alphas of all axes: `O(n^lg(4 product))` above 1/4, `O(lg n)` at 1/4 exactly,
    /// constant below. (The paper's table prints "1/4" in its first row, which must read "< 1/4".)
    pub fn of(alpha_product: f64) -> Self {
        match alpha_product.total_cmp(&0.25) {
            Ordering::Less => Self::Constant,
            Ordering::Equal => Self::Logarithmic,
            Ordering::Greater => Self::Power(2.0 + libm::log2(alpha_product)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, exact: f64) {
        assert!(
            (found / exact - 1.0).abs() < 1e-12,
            "{found} is not {exact}"
        );
    }

    #[test]
    fn one_level_is_all_pairs_times_the_probability() {
        assert_eq!(
            [eq1(0, 1.0), eq1(3, 0.25), eq1(13, 1.0)],
            [1.0, 16.0, 67_108_864.0]
        );
        assert_eq!(eq2(&[]), 0.0);
        assert_eq!(eq2(&[0.5, 0.25]), 4.0 * 0.5 + 16.0 * 0.25);
    }

    #[test]
    fn the_sums_are_their_closed_forms() {
        for q in [0.3, 0.9999, 1.000_001, 2.048, 4.0] {
            for depth in [0, 1, 2, 7, 13, 30] {
                let closed = (f64::powi(q, depth as i32 + 1) - 1.0) / (q - 1.0);
                assert!((eq7(q / 4.0, depth) / closed - 1.0).abs() < 1e-9);
            }
        }
        assert_eq!(eq7(0.25, 9), 10.0);
        assert_eq!(eq9([0.5, 1.0], 3), 1.0 + 2.0 + 4.0 + 8.0);
        assert_eq!(eq11([1.0; 3], 2), 1.0 + 4.0 + 16.0);
        // By hand: 4 * .8^3 = 2.048.
        close(eq11([0.8; 3], 2), 1.0 + 2.048 + 4.194_304);
    }

    #[test]
    fn equal_alphas_on_every_level_are_the_constant_case() {
        let alpha = [0.7, 0.8, 0.9];
        close(visits_per_level_alpha(&[alpha; 9]), eq11(alpha, 9));
        close(visits_per_level_alpha(&[[0.7, 0.8]; 9]), eq9([0.7, 0.8], 9));
        close(
            visits_per_level_alpha(&[[0.5], [0.25]]),
            1.0 + 2.0 + 2.0 * 1.0,
        );
        assert_eq!(visits_per_level_alpha::<3>(&[]), 1.0);
    }

    #[test]
    fn eq2_with_the_papers_probabilities_is_eq11_without_the_roots() {
        let alpha: [f64; 3] = [0.6, 0.8, 0.9];
        let product: f64 = alpha.iter().product();
        let probabilities: Vec<f64> = (1..=10).map(|l| product.powi(l)).collect();
        close(eq2(&probabilities), eq11(alpha, 10) - 1.0);
    }

    #[test]
    fn table_1() {
        assert_eq!(Growth::of(0.2), Growth::Constant);
        assert_eq!(Growth::of(0.5 * 0.5), Growth::Logarithmic);
        assert_eq!(Growth::of(1.0), Growth::Power(2.0));
        let Growth::Power(root) = Growth::of(f64::sqrt(1.0 / 8.0)) else {
            panic!()
        };
        close(root, 0.5);
        let Growth::Power(three_quarters) = Growth::of(0.75) else {
            panic!()
        };
        close(three_quarters, 3f64.log2());
    }
}
