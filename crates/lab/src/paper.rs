//! Equations 1 and 11 of the paper, and its Table 1.
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

/// Eq 11, three dimensions: `N_v <= sum_{l=0..d} (4 a_x a_y a_z)^l`, by Horner's rule.
///
/// An equality for the mean over all placements in which the roots meet: there boxes of extents `a`
/// and `b` within roots of extents `A` and `B` meet along an axis with probability
/// `(a + b) / (A + B)`.
pub fn eq11(alpha: [f64; 3], depth: u32) -> f64 {
    let q = 4.0 * alpha.iter().product::<f64>();
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
    fn the_sum_is_its_closed_form_and_that_of_its_levels() {
        assert_eq!(eq1(3, 0.25), 16.0);
        assert_eq!(eq11([1.0; 3], 2), 1.0 + 4.0 + 16.0);
        // By hand: 4 * .8^3 = 2.048.
        close(eq11([0.8; 3], 2), 1.0 + 2.048 + 4.194_304);
        for alpha in [[0.6, 0.8, 0.9], [0.5, 0.5, 0.999], [1.0, 0.4, 0.2]] {
            let product: f64 = alpha.iter().product();
            let levels: f64 = (0..=10).map(|l| eq1(l, product.powi(l as i32))).sum();
            close(eq11(alpha, 10), levels);
            let q = 4.0 * product;
            close(eq11(alpha, 10), (q.powi(11) - 1.0) / (q - 1.0));
        }
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
