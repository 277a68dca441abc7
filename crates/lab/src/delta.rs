//! Expected visits of artificial trees at a given offset: the dependence on delta that the paper left open, exact.
//!
//! Along one axis let the roots have extent 1 and their centres be `x` apart. One level down the boxes are alpha as large,
//! and the centres of two children are `x - (1 - alpha)`, `x` (twice) or `x + (1 - alpha)` apart, since each child lies
//! at the low or the high end of its parent. Scaled to extent 1 again, that is the same question with one level less. So
//! the probability that two boxes of level `l` meet along the axis is
//!
//! `f_0(x) = 1`,
//! `f_l(x) = 1/4 f_(l-1)((x - 1 + alpha) / alpha) + 1/2 f_(l-1)(x / alpha) + 1/4 f_(l-1)((x + 1 - alpha) / alpha)`,
//!
//! and 0 where `|x| > 1`. If corners are drawn at random, axes are independent ([`super::artificial`]) and
//!
//! `E[O_l] = 4^l prod_k f_l(x_k; alpha_k)`,  `N_v = sum_{l=0..d} E[O_l]`.
//!
//! The mean of `f_l` over `-1 < x < 1` is `alpha^l`, which gives the paper's Eq 11 back.

use crate::paper;

/// The probability `f_l(x; alpha)` that boxes of level `level` meet along an axis, by the recursion as it stands.
///
/// `O(3^level)` in the worst case, `alpha` near 1: for tests and experiments. [`AxisTable`] is for the rest.
pub fn overlap_probability(alpha: f64, level: u32, x: f64) -> f64 {
    // Boxes that touch meet, also where rounding has put a hair between them.
    if x.abs() > 1.0 + 1e-12 {
        0.0
    } else if level == 0 {
        1.0
    } else {
        let (below, step) = (
            |x: f64| overlap_probability(alpha, level - 1, x / alpha),
            1.0 - alpha,
        );
        0.25 * below(x - step) + 0.5 * below(x) + 0.25 * below(x + step)
    }
}

/// `N_v` of artificial trees whose roots overlap by `delta` along x, the exact mean over lateral offsets and random corners,
/// level by level.
pub fn exact_visits(alpha: [f64; 3], delta: f64, depth: u32) -> f64 {
    let lateral = alpha[1] * alpha[2];
    let probability =
        |l: u32| overlap_probability(alpha[0], l, 1.0 - delta) * lateral.powi(l as i32);
    (0..=depth).map(|l| paper::eq1(l, probability(l))).sum()
}

/// `f_l(x; alpha)` for all levels up to a depth and one alpha, on a grid of `x`.
///
/// Keeps the running integral of `f_l`, which obeys the same recursion times alpha and has no jumps, and differentiates
/// it over two cells of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisTable {
    /// `cells + 1` values a level: `integral[l][i] = int_0^(i / cells) f_l`.
    integral: Vec<f64>,
    cells: usize,
}

impl AxisTable {
    /// Tabulates levels `0..=depth`. `O(depth * cells)`; `alpha` is in `0 < alpha <= 1`, `cells` at least 1.
    pub fn new(alpha: f64, depth: u32, cells: usize) -> Self {
        let cells = cells.max(1);
        let mut integral: Vec<f64> = (0..=cells).map(|i| i as f64 / cells as f64).collect();
        for level in 0..depth as usize {
            let above = &integral[level * (cells + 1)..];
            let part = |x: f64| interpolate(above, x / alpha);
            let step = 1.0 - alpha;
            let next: Vec<f64> = (0..=cells)
                .map(|i| {
                    let x = i as f64 / cells as f64;
                    // The constants of integration of the outer two cancel: the integral is odd.
                    alpha * (0.25 * part(x - step) + 0.5 * part(x) + 0.25 * part(x + step))
                })
                .collect();
            integral.extend(next);
        }
        Self { integral, cells }
    }

    /// Levels of boxes, the root's not counted.
    pub fn depth(&self) -> usize {
        self.integral.len() / (self.cells + 1) - 1
    }

    /// `f_l(x)` for the root's centres `x` extents apart, averaged over one cell on either side.
    ///
    /// # Panics
    /// If `level` exceeds the depth.
    pub fn overlap_probability(&self, level: usize, x: f64) -> f64 {
        let above = &self.integral[level * (self.cells + 1)..][..self.cells + 1];
        let cell = 1.0 / self.cells as f64;
        let x = x.abs();
        if x > 1.0 {
            return 0.0;
        }
        let (low, high) = (x - cell, (x + cell).min(1.0));
        (interpolate(above, high) - interpolate(above, low)) / (high - low)
    }

    /// Local exponent of `N_v` at the depth of the table: `log2(N_v(n) / N_v(n / 2))` of cubes that shrink by `alpha`, with
    /// roots that overlap by `delta` along x, the mean over lateral offsets.
    ///
    /// With the depth it approaches the exponent of Eq 11, `max(0, log2(4 alpha^3))`, at every `delta > 0`.
    pub fn exponent(&self, alpha: f64, delta: f64) -> f64 {
        let lateral = 4.0 * alpha * alpha;
        let pairs =
            |level| libm::pow(lateral, level as f64) * self.overlap_probability(level, 1.0 - delta);
        let above: f64 = (0..self.depth()).map(pairs).sum();
        (1.0 + pairs(self.depth()) / above).log2()
    }
}

/// The odd function with the given values at equal steps from 0 to 1, constant beyond.
fn interpolate(values: &[f64], x: f64) -> f64 {
    let last = values.len() - 1;
    let place = x.abs().min(1.0) * last as f64;
    let cell = (place as usize).min(last.saturating_sub(1));
    let value =
        values[cell] + (values[(cell + 1).min(last)] - values[cell]) * (place - cell as f64);
    if x < 0.0 { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artificial::{ArtificialTree, Corners, Random};

    #[test]
    fn small_cases_by_hand() {
        let f = overlap_probability;
        assert_eq!([f(0.5, 0, 0.9), f(0.5, 0, 1.1)], [1.0, 0.0]);
        // Level 1, alpha 1/2: the children's centres are x - 1/2, x, x + 1/2 apart, and meet within 1/2.
        assert_eq!(
            [
                f(0.5, 1, 0.0),
                f(0.5, 1, 0.25),
                f(0.5, 1, 0.75),
                f(0.5, 1, 1.0)
            ],
            [1.0, 0.75, 0.25, 0.25]
        );
        // Without shrinking everything meets; touching roots touch in one of four pairs on each level.
        assert_eq!([f(1.0, 9, 1.0), f(0.7, 9, 1.0)], [1.0, 0.25f64.powi(9)]);
    }

    #[test]
    fn the_mean_over_all_offsets_is_alpha_to_the_level() {
        for (alpha, level) in [(0.5, 5), (0.7, 6), (0.9, 7)] {
            let n = 4000;
            let x = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
            let mean = (0..n)
                .map(|i| overlap_probability(alpha, level, x(i)))
                .sum::<f64>()
                / f64::from(n);
            assert!(
                (mean / f64::powi(alpha, level as i32) - 1.0).abs() < 1e-3,
                "{alpha} {level}: {mean}"
            );
            let table = AxisTable::new(alpha, level, 128);
            assert_eq!(table.depth(), level as usize);
            let whole = table.integral[table.integral.len() - 1];
            assert!((whole / f64::powi(alpha, level as i32) - 1.0).abs() < 1e-9);
        }
    }

    /// Mean over a cell on either side, of the recursion as it stands.
    fn averaged(alpha: f64, level: u32, x: f64, cells: usize) -> f64 {
        let n = 200;
        let low = x - 1.0 / cells as f64;
        let high = (x + 1.0 / cells as f64).min(1.0);
        let at = |i: i32| low + (high - low) * (f64::from(i) + 0.5) / f64::from(n);
        (0..n)
            .map(|i| overlap_probability(alpha, level, at(i)))
            .sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn the_axis_table_is_the_recursion_averaged() {
        for alpha in [0.5, 0.7, 0.9] {
            let table = AxisTable::new(alpha, 8, 64);
            for level in [0, 1, 4, 8] {
                for x in [0.0, 0.1, 0.4, 0.75] {
                    let (found, exact) = (
                        table.overlap_probability(level as usize, x),
                        averaged(alpha, level, x, 64),
                    );
                    let scale = f64::powi(alpha, level as i32);
                    assert!(
                        (found - exact).abs() < 0.03 * scale,
                        "{alpha} {level} {x}: {found} is not {exact}"
                    );
                }
            }
            assert_eq!(table.overlap_probability(3, 1.01), 0.0);
        }
    }

    /// The paper's claim: the asymptotic number depends on delta only to a minor extent.
    #[test]
    fn at_every_delta_growth_approaches_that_of_equation_11() {
        let at = |alpha, delta, depth| AxisTable::new(alpha, depth, 4096).exponent(alpha, delta);
        // By the recursion on 200,001 points, computed apart.
        for (delta, depth, exponent) in [(0.1, 9, 0.1837), (0.1, 20, 0.9561), (0.4, 13, 0.9569)] {
            let found = at(0.8, delta, depth);
            assert!((found - exponent).abs() < 0.002, "{delta} {depth}: {found}");
        }
        for alpha in [0.6, 0.7, 0.8] {
            let limit = f64::max(0.0, (4.0 * f64::powi(alpha, 3)).log2());
            for delta in [0.05, 0.1, 0.2, 0.4, 0.9] {
                let found = at(alpha, delta, 40);
                assert!(
                    (found - limit).abs() < 0.002,
                    "{alpha} {delta}: {found} is not {limit}"
                );
            }
        }
    }

    #[test]
    fn artificial_trees_visit_what_the_recursion_says() {
        let mut random = Random::new(11);
        for (alpha, delta) in [
            ([0.83, 0.76, 0.91], 0.33),
            ([0.7; 3], 0.87),
            ([0.91, 0.8, 0.62], 0.62),
        ] {
            let runs = 3000;
            let mut total = 0;
            for _ in 0..runs {
                let corners = [(); 2].map(|()| Corners::Random(random.bits()));
                let [a, b] = corners.map(|corners| ArtificialTree {
                    alpha,
                    depth: 9,
                    corners,
                });
                let [y, z] = [(); 2].map(|()| random.between(-1.0, 1.0));
                total += a.visits(&b, [1.0 - delta, y, z]).total();
            }
            let mean = total as f64 / f64::from(runs);
            let exact = exact_visits(alpha, delta, 9);
            assert!(
                (mean / exact - 1.0).abs() < 0.08,
                "{alpha:?} {delta}: {mean} is not {exact}"
            );
        }
    }
}
