//! The fit itself, and the source file that holds what it found.

use std::collections::HashSet;
use std::fmt::Write;

use punctual::model::confidence::{history_features, hit_features, recall_features};
use punctual::model::prediction::{features_of_all, features_of_any};
use punctual::model::regression::{least_squares, logistic, quantile};
use punctual::{CostModel, Mode};

use super::Data;
use super::sample::Sample;
use crate::machine;

/// The upper one is for 90 %: meshes that were not fitted are dearer more often than cheaper.
const QUANTILES: [f64; 3] = [0.1, 0.5, 0.935];

/// Residuals below this (log2) are not told apart by quantile regression.
const BLUR: f64 = 0.02;

/// How much the logit of a hit is held back: with less, cases that were not fitted come out worse.
const PULL: f64 = 1e-3;

/// The constants, as Rust source.
pub fn fit(data: &Data) -> String {
    let open: Vec<&Sample> = data.samples.iter().filter(|sample| !sample.front.is_done()).collect();
    let alone: Vec<&Sample> = open.iter().copied().filter(|sample| sample.last.is_none()).collect();
    let of = |mode| alone.iter().copied().filter(move |sample| sample.mode == mode);

    let all_left = quantiles(of(Mode::All), |s| (features_of_all(&s.front), log_left(s)));
    let roots = of(Mode::All).filter(|sample| sample.stop.is_none());
    let root_most = quantiles(roots, |s| ([1.0, s.root_cost.max(1.0).log2()], log_left(s)))[2];

    // Before a query and after a part of it are two questions; one answer to both would be the worse for each.
    let [hit_before, hit] = [false, true].map(|begun| {
        let moments = of(Mode::Any).filter(|sample| sample.front.is_begun() == begun);
        regression(moments, |s| (hit_features(&s.front), f64::from(s.is_hit())))
    });
    let logit = |s: &Sample| dot(if s.front.is_begun() { &hit } else { &hit_before }, &hit_features(&s.front));
    let chance = |s: &Sample| 1.0 / (1.0 + (-logit(s)).exp());
    let any_left = quantiles(of(Mode::Any), |s| (features_of_any(&s.front, chance(s)), log_left(s)));

    let remembered = || open.iter().copied().filter_map(|sample| Some((sample, sample.last?)));
    let change = |s: &Sample| {
        let before = s.last.map_or(1.0, |last| last.bv_tests.max(1.0));
        ([1.0], (s.total.bv_tests.max(1.0) / before).log2())
    };
    let [all_after, any_after] = [Mode::All, Mode::Any].map(|mode| {
        let frames = remembered().map(|(sample, _)| sample).filter(|s| s.stop.is_none() && s.mode == mode);
        quantiles(frames, change).map(|[w]| w)
    });
    let moved = remembered().map(|(sample, _)| sample).filter(|s| s.mode == Mode::Any && s.stop.is_some());
    let remembering = |s: &Sample| {
        let features =
            s.last.map(|last| history_features(logit(s), s.front.deepest, &last.history)).unwrap_or_default();
        (features, f64::from(s.is_hit()))
    };
    let hit_after_history = regression(moved, remembering);

    let poses: Vec<&Sample> = of(Mode::Any).filter(|sample| sample.stop.is_none()).collect();
    let base_rate = poses.iter().filter(|sample| sample.is_hit()).count() as f64 / poses.len() as f64;

    let cost = CostModel::measure();
    let mut source = header(data);
    constant(
        &mut source,
        "ALL_LEFT",
        "[[f64; 3]; 3]",
        &nested(&all_left),
        "Quantiles of the BV tests left, for each the weights of `features_of_all`.",
    );
    constant(
        &mut source,
        "ROOT_MOST",
        "[f64; 2]",
        &list(&root_most),
        "90 % quantile of log2 of a whole query from log2 of the cost of its roots at the deepest: intercept, slope.",
    );
    constant(
        &mut source,
        "ANY_LEFT",
        "[[f64; 6]; 3]",
        &nested(&any_left),
        "The same if the first hit ends the query, weights of `features_of_any`.",
    );
    constant(
        &mut source,
        "ALL_AFTER",
        "[f64; 3]",
        &list(&all_after),
        "Quantiles of log2 (BV tests of a frame / those of the frame before).",
    );
    constant(&mut source, "ANY_AFTER", "[f64; 3]", &list(&any_after), "The same if the first hit ends the query.");
    constant(
        &mut source,
        "OPENINGS_OF_BV_TESTS",
        "[f64; 2]",
        &list(&power_law(data, |c| c.box_updates)),
        "log2 of opened node pairs: intercept, slope in log2 of BV tests.",
    );
    constant(
        &mut source,
        "TRIANGLE_TESTS_OF_BV_TESTS",
        "[f64; 2]",
        &list(&power_law(data, |c| c.triangle_tests)),
        "log2 of triangle tests: the same.",
    );
    constant(&mut source, "HIT", "[f64; 13]", &list(&hit), "Logit of a hit, weights of `hit_features`.");
    constant(&mut source, "HIT_BEFORE", "[f64; 13]", &list(&hit_before), "The same before the query.");
    constant(
        &mut source,
        "HIT_AFTER_HISTORY",
        "[f64; 6]",
        &list(&hit_after_history),
        "The same with the verdict of the frame before, weights of `history_features`.",
    );
    constant(&mut source, "BASE_RATE", "f64", &number(base_rate), "Share of poses with a hit.");
    constant(
        &mut source,
        "RECALL",
        "[f64; 9]",
        &list(&recall(&of(Mode::All).collect::<Vec<_>>())),
        "Logit of the recall, weights of `recall_features`.",
    );
    let nanoseconds = [cost.bv_test, cost.triangle_test, cost.box_update, cost.setup];
    constant(
        &mut source,
        "NANOSECONDS",
        "[f64; 4]",
        &list(&nanoseconds),
        "Cost of a BV test, a triangle test, an opened node pair and a query, by `CostModel::measure`.",
    );
    source
}

/// Parts of the data that are fitted without the others, to see how well that serves cases that were not fitted.
const FOLDS: usize = 5;

/// Features and targets of some samples, and the case that each is of.
struct Rows<const N: usize> {
    x: Vec<[f64; N]>,
    y: Vec<f64>,
    cases: Vec<usize>,
}

impl<const N: usize> Rows<N> {
    fn of<'s>(samples: impl Iterator<Item = &'s Sample>, row: impl Fn(&Sample) -> ([f64; N], f64)) -> Self {
        let mut rows = Self { x: Vec::new(), y: Vec::new(), cases: Vec::new() };
        for sample in samples {
            let (x, y) = row(sample);
            rows.x.push(x);
            rows.y.push(y);
            rows.cases.push(sample.case);
        }
        rows
    }

    /// `w . x` of every row, where `w` is what `fit` makes of the cases of the other folds.
    fn foretold(&self, fit: impl Fn(&[[f64; N]], &[f64]) -> [f64; N]) -> Vec<f64> {
        let weights: Vec<[f64; N]> = (0..FOLDS)
            .map(|fold| {
                let others = (0..self.y.len()).filter(|&i| self.cases[i] % FOLDS != fold);
                let (x, y): (Vec<_>, Vec<_>) = others.map(|i| (self.x[i], self.y[i])).unzip();
                fit(&x, &y)
            })
            .collect();
        self.x.iter().zip(&self.cases).map(|(x, case)| dot(&weights[case % FOLDS], x)).collect()
    }
}

/// Weights of three quantiles of a target. Each is moved so that it has its share below in cases that were not fitted.
fn quantiles<'s, const N: usize>(
    samples: impl Iterator<Item = &'s Sample>,
    row: impl Fn(&Sample) -> ([f64; N], f64),
) -> [[f64; N]; 3] {
    let rows = Rows::of(samples, row);
    QUANTILES.map(|p| {
        let foretold = rows.foretold(|x, y| quantile(x, y, p, BLUR));
        let rest: Vec<f64> = rows.y.iter().zip(foretold).map(|(y, q)| y - q).collect();
        let [shift] = quantile(&vec![[1.0]; rest.len()], &rest, p, 1e-3);
        let mut w = quantile(&rows.x, &rows.y, p, BLUR);
        w[0] += shift;
        w
    })
}

/// Weights of a logit. They are stretched and moved so that they are calibrated in cases that were not fitted (Platt).
fn regression<'s, const N: usize>(
    samples: impl Iterator<Item = &'s Sample>,
    row: impl Fn(&Sample) -> ([f64; N], f64),
) -> [f64; N] {
    let rows = Rows::of(samples, row);
    if rows.y.is_empty() {
        return [0.0; N];
    }
    let fit = |x: &[[f64; N]], y: &[f64]| logistic(x, y, &vec![1.0; y.len()], PULL);
    let weights = fit(&rows.x, &rows.y);
    if rows.cases.iter().collect::<HashSet<_>>().len() < FOLDS {
        return weights;
    }
    let x: Vec<[f64; 2]> = rows.foretold(fit).into_iter().map(|z| [1.0, z]).collect();
    let [shift, stretch] = logistic(&x, &rows.y, &vec![1.0; x.len()], 0.0);
    let mut w = weights.map(|w| stretch * w);
    w[0] += shift;
    w
}

fn log_left(sample: &Sample) -> f64 {
    sample.left().max(1.0).log2()
}

fn dot(w: &[f64], x: &[f64]) -> f64 {
    w.iter().zip(x).map(|(w, x)| w * x).sum()
}

/// Weights of the recall with about the least mean absolute error: logistic regression, again with samples weighted by slope
/// over error.
fn recall(samples: &[&Sample]) -> [f64; 9] {
    let found = samples.iter().filter(|sample| sample.front.found > 0.0);
    let (x, y): (Vec<_>, Vec<_>) = found.map(|s| (recall_features(&s.front), s.front.found / s.hits as f64)).unzip();
    let mut weights = vec![1.0; x.len()];
    let mut best = (f64::INFINITY, [0.0; 9]);
    for _ in 0..20 {
        let w = logistic(&x, &y, &weights, 1e-5);
        let p: Vec<f64> = x.iter().map(|x| 1.0 / (1.0 + (-dot(&w, x)).exp())).collect();
        let errors = p.iter().zip(&y).map(|(p, y)| (p - y).abs());
        let sum: f64 = errors.clone().sum();
        if sum < best.0 {
            best = (sum, w);
        }
        weights = p.iter().zip(errors).map(|(p, error)| p * (1.0 - p) / error.max(0.01)).collect();
    }
    best.1
}

/// Intercept and slope of log2 of a count of complete queries.
fn power_law(data: &Data, count: impl Fn(&punctual::model::cost::Counts) -> f64) -> [f64; 2] {
    let whole = data.samples.iter().filter(|sample| sample.stop.is_none() && count(&sample.total) > 0.0);
    let (x, y): (Vec<_>, Vec<_>) =
        whole.map(|s| ([1.0, s.total.bv_tests.max(1.0).log2()], count(&s.total).log2())).unzip();
    least_squares(&x, &y, &vec![1.0; x.len()])
}

fn header(data: &Data) -> String {
    let mut text = format!(
        "//! The fitted constants of the model; made by `punctual fit`, not by hand.\n//!\n//! On {}, \
         on {} {}, by version {}, from {} poses ({} moments of queries) of:\n",
        machine::today(),
        std::env::consts::ARCH,
        std::env::consts::OS,
        env!("CARGO_PKG_VERSION"),
        data.poses,
        data.samples.len(),
    );
    let mut line = String::from("//!");
    for name in &data.names {
        if line.len() + name.len() > 110 {
            text += &line;
            text.push('\n');
            line = String::from("//!");
        }
        line.push(' ');
        line += name;
    }
    text + &line + "\n"
}

fn constant(source: &mut String, name: &str, kind: &str, value: &str, doc: &str) {
    // Writing to a string does not fail.
    let _ = write!(source, "\n/// {doc}\n#[rustfmt::skip]\npub(super) const {name}: {kind} = {value};\n");
}

/// A number with five digits.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return "0.0".into();
    }
    let decimals = (4.0 - x.abs().log10().floor()).clamp(1.0, 12.0) as usize;
    format!("{x:.decimals$}")
}

fn list(numbers: &[f64]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|&x| number(x)).collect();
    format!("[{}]", numbers.join(", "))
}

fn nested<const N: usize>(lists: &[[f64; N]]) -> String {
    let lists: Vec<_> = lists.iter().map(|numbers| format!("\n    {},", list(numbers))).collect();
    format!("[{}\n]", lists.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits() {
        assert_eq!(
            [number(1.0 / 3.0), number(-12345.678), number(0.000_123_456), number(0.0)],
            ["0.33333", "-12345.7", "0.00012346", "0.0"]
        );
        assert_eq!(nested(&[[1.0, 2.0]]), "[\n    [1.0000, 2.0000],\n]");
    }
}
