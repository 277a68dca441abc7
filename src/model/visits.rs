//! `N_v`, the number of box pairs that a traversal visits, level by level: the paper's model, with
//! what this library measures in place of the paper's average case.
//!
//! R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time of Collision Detection
//! using AABB Trees" (EGVE 2006): on level `l` of two binary trees there are `4^l` pairs of boxes.
//! Boxes shrink by the factor `alpha_k` along axis `k` from level to level. So averaged over all
//! placements in which the roots overlap, a pair on level `l` overlaps with probability
//! `prod_k alpha_k^l`.
//!
//! | paper | | here |
//! |---|---|---|
//! | Eq. 1, 2 | `N_v = sum_l 4^l P(l)` | [`visits`], with `n_l^2` boxes in place of `4^l` |
//! | Eq. 7 | one axis counts: `N_v <= sum_l (4 alpha_y)^l` | shrinkage `[1, alpha_y^l, 1]` |
//! | Eq. 9 | two axes: `sum_l (4 alpha_x alpha_y)^l` | shrinkage `[alpha_x^l, alpha_y^l, 1]` |
//! | Eq. 11 | three axes: `sum_l (4 alpha_x alpha_y alpha_z)^l` | shrinkage `alpha_k^l` |
//!
//! Measured in place of assumed: the number of boxes and their mean extents on each level of each
//! subtree ([`crate::tree`], at build and refit), so alpha may differ from level to level. And each
//! pair is weighted by how deep its boxes overlap ([`pair_cost`]), which the average over all
//! placements does not know. [`super::prediction`] corrects the sum by regression.

/// A level of boxes below a root.
pub struct Level {
    /// Number of boxes, the paper's `2^l`.
    pub boxes: f32,
    /// Mean extent of the boxes over that of the root, by axis: the paper's `alpha_k^l`.
    pub shrinkage: [f32; 3],
}

/// Expected BV tests of a subtree against a copy of itself, averaged over all placements in which
/// their boxes overlap: Equation 11. `levels` begins with the children of the root.
///
/// Each pair that overlaps is replaced by all pairs of its children. So the tests of a level are
/// its pairs times the overlapping share of the level above; for the first level, all its pairs.
#[inline(always)]
pub fn visits(levels: impl IntoIterator<Item = Level>) -> f32 {
    let (mut overlapping, mut tests) = (1.0, 0.0);
    for Level { boxes, shrinkage } in levels {
        tests += boxes * boxes * overlapping;
        let [x, y, z] = shrinkage;
        overlapping = x * y * z;
    }
    tests
}

/// Expected BV tests below a pair of nodes: `27 (v_A v_B p^3)^(1/4)`. `v` is the `visits` of each
/// node. `p` is the relative penetration of the boxes, 0 to 1.
///
/// The exponents are rounded from a fit of the sums over 47,000 frontiers (`docs/model.md`).
#[inline(always)]
pub fn pair_cost(self_costs: [f32; 2], penetration: f32) -> f32 {
    let p = penetration;
    // The root of `libm` is a legacy instruction, which stalls AVX code.
    let fourth = wide::f32x4::splat(self_costs[0] * self_costs[1] * p * p * p);
    27.0 * fourth.sqrt().sqrt().as_array()[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs that overlap on levels 0 to `depth` of binary trees, by [`visits`]: a quarter of the
    /// tests of the levels below.
    fn overlapping(alpha: [f32; 3], depth: i32) -> f32 {
        let level = |l: i32| Level {
            boxes: f32::exp2(l as f32),
            shrinkage: alpha.map(|factor| factor.powi(l)),
        };
        visits((1..=depth + 1).map(level)) / 4.0
    }

    #[test]
    fn equations_7_9_and_11_are_the_sum_over_levels() {
        let alpha = [0.7, 0.8, 0.9];
        for axes in 1..=3 {
            let counted = core::array::from_fn(|k| if k < axes { alpha[k] } else { 1.0 });
            let q = 4.0 * counted.iter().product::<f32>();
            for depth in [0, 1, 5, 12] {
                let exact: f32 = (0..=depth).map(|l| q.powi(l)).sum();
                let predicted = overlapping(counted, depth);
                assert!(
                    (predicted / exact - 1.0).abs() < 1e-5,
                    "{predicted} is not {exact}"
                );
            }
        }
    }

    #[test]
    fn boxes_that_do_not_shrink_are_all_tested() {
        assert_eq!(overlapping([1.0; 3], 2), 1.0 + 4.0 + 16.0);
    }
}
