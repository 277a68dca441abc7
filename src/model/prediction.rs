//! Predicts the BV tests left in a query from the summary of its frontier: a median and a range.
//!
//! A quantile `Q` of the tests left is `log2 Q = w . x`, where `x` are a few features of the
//! frontier. Each quantile has its own weights `w`, fitted by quantile regression. Before a query
//! the frontier is the pair of roots, and all tests are left.

use super::constants::{
    ALL_AFTER, ALL_BEFORE, ALL_LEFT, ANY_AFTER, ANY_BEFORE, ANY_LEFT, OPENINGS_OF_BV_TESTS,
    ROOT_MOST, TRIANGLE_TESTS_OF_BV_TESTS,
};
use super::cost::Counts;
use super::frontier::FrontierSummary;
use libm::{exp2, log2};

/// An uncertain number: its median, and its 10 % and 90 % quantiles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quantiles {
    /// The number is below this with probability 10 %.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub p10: f64,
    /// The median.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub p50: f64,
    /// The number is below this with probability 90 %.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub p90: f64,
}

impl Quantiles {
    /// A certain number: all three are equal.
    pub const fn exactly(x: f64) -> Self {
        Self {
            p10: x,
            p50: x,
            p90: x,
        }
    }

    /// Raises the median to at least `least`. Then limits the others so that all are in order and
    /// at least `least`.
    pub(super) fn ordered([p10, p50, p90]: [f64; 3], least: f64) -> Self {
        let p50 = p50.max(least);
        Self {
            p10: p10.clamp(least, p50),
            p50,
            p90: p90.max(p50),
        }
    }

    /// Applies a rising function to each quantile.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            p10: f(self.p10),
            p50: f(self.p50),
            p90: f(self.p90),
        }
    }
}

/// BV tests expected in the rest of a query that finds all intersections: those of the probe, plus
/// the sum of the pair costs. At least 1.
pub fn expected(frontier: &FrontierSummary) -> f64 {
    (frontier.probed + frontier.cost).max(1.0)
}

/// The fraction of [`expected`] that comes from pair costs and not from the probe.
fn unseen(frontier: &FrontierSummary) -> f64 {
    frontier.cost / expected(frontier)
}

/// Features of [`all_left`]: 1, the logarithm of the expected tests, the fraction of them that is
/// only estimated, the deepest pair, the crossing, and the numbers of open and waiting pairs.
pub fn features_of_all(frontier: &FrontierSummary) -> [f64; 7] {
    [
        1.0,
        log2(expected(frontier)),
        unseen(frontier),
        frontier.deepest,
        frontier.crossing,
        log2(frontier.node_pairs + 1.0),
        log2(frontier.triangle_pairs + 1.0),
    ]
}

/// Features of [`any_left`]: those of [`all_left`], the probability of a hit, and its products with
/// two of them. A hit ends the query.
pub fn features_of_any(frontier: &FrontierSummary, probability: f64) -> [f64; 10] {
    let [one, size, unseen, deepest, crossing, nodes, waiting] = features_of_all(frontier);
    let p = probability;
    [
        one,
        size,
        unseen,
        deepest,
        crossing,
        nodes,
        waiting,
        p,
        p * size,
        p * unseen,
    ]
}

/// BV tests left in a query that finds all intersections.
pub fn all_left(frontier: &FrontierSummary) -> Quantiles {
    if frontier.is_done() {
        return Quantiles::exactly(0.0);
    }
    let x = features_of_all(frontier);
    let weights = if frontier.is_begun() {
        ALL_LEFT
    } else {
        ALL_BEFORE
    };
    Quantiles::ordered(weights.map(|w| exp2(dot(&w, &x))), frontier.probed)
}

/// BV tests left in a query that ends with the first intersection. `probability` is that of an
/// intersection.
pub fn any_left(frontier: &FrontierSummary, probability: f64) -> Quantiles {
    if frontier.is_done() {
        return Quantiles::exactly(0.0);
    }
    let x = features_of_any(frontier, probability);
    let Quantiles { p90, .. } = all_left(frontier);
    let weights = if frontier.is_begun() {
        ANY_LEFT
    } else {
        ANY_BEFORE
    };
    Quantiles::ordered(weights.map(|w| exp2(dot(&w, &x)).min(p90)), 1.0)
}

/// log2 of the 90 % quantile of the BV tests of a whole query that finds all intersections.
/// `root_cost` is the [`super::visits::pair_cost`] of the roots at their deepest penetration, so
/// their positions do not matter.
pub fn most(root_cost: f64, log2: fn(f64) -> f64) -> f64 {
    let [intercept, slope] = ROOT_MOST;
    intercept + slope * log2(root_cost.max(1.0))
}

/// [`most`], computed from the BV tests of the pair's previous query alone.
pub fn most_of_all_after(previous: f64, log2: fn(f64) -> f64) -> f64 {
    log2(previous.max(1.0)) + ALL_AFTER[2]
}

/// [`most_of_all_after`] for a query that ends with the first intersection.
pub fn most_of_any_after(previous: f64, log2: fn(f64) -> f64) -> f64 {
    log2(previous.max(1.0)) + ANY_AFTER[2]
}

/// Predicts the BV tests of a query from those of the `previous` query of its pair alone, if both
/// find all intersections.
pub fn all_after(previous: f64) -> Quantiles {
    after(previous, ALL_AFTER)
}

/// [`all_after`] for a query that ends with the first intersection.
pub fn any_after(previous: f64) -> Quantiles {
    after(previous, ANY_AFTER)
}

/// `changes` are quantiles of `log2(now / previous)`.
pub(super) fn after(previous: f64, changes: [f64; 3]) -> Quantiles {
    Quantiles::ordered(changes.map(|change| previous.max(1.0) * exp2(change)), 1.0)
}

/// The counts of a query from the log2 of its BV tests. Power laws give the triangle tests and the
/// opened node pairs. There is at most one opened node pair per BV test.
pub fn counts(log2_bv_tests: f64) -> Counts {
    let power_law = |[intercept, slope]: [f64; 2]| exp2(intercept + slope * log2_bv_tests);
    let bv_tests = exp2(log2_bv_tests);
    Counts {
        bv_tests,
        triangle_tests: power_law(TRIANGLE_TESTS_OF_BV_TESTS),
        box_updates: power_law(OPENINGS_OF_BV_TESTS).min(bv_tests),
    }
}

pub(super) fn dot(w: &[f64], x: &[f64]) -> f64 {
    w.iter().zip(x).map(|(w, x)| w * x).sum()
}
