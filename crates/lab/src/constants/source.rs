//! The fit itself, and the source file that holds what it found.

use std::collections::HashSet;

use punctual::Mode;
use punctual::internals::{Batch, FrontierSummary, Lead};
use punctual::internals::{batch_features, listing_features, mean_left, single_features};
use punctual::internals::{between_features, closing_features, features_of_all, features_of_any};
use punctual::internals::{
    history_features, hit_features, passing_features, recall_features, tracing_features,
};

use super::Data;
use super::moments::{Approaching, Moment, Moments};
use super::sample::Sample;
use crate::machine;
use crate::regression::{dot, least_squares, logistic, quantile};
use crate::statistics::mean;

/// The upper one is for 90 %: meshes that were not fitted are dearer more often than cheaper.
const QUANTILES: [f64; 3] = [0.1, 0.5, 0.935];

/// Residuals below this (log2) are not told apart by quantile regression.
const BLUR: f64 = 0.02;

/// How much the logit of a hit is held back: with less, cases that were not fitted come out worse.
const PULL: f64 = 1e-3;

/// Fits the constants: Rust source, to be put in the place of `src/model/constants.rs`.
pub fn fit(data: &Data) -> String {
    let open = data
        .samples
        .iter()
        .filter(|sample| !sample.frontier.is_done());
    let (tracing, open): (Vec<&Sample>, Vec<&Sample>) =
        open.partition(|sample| sample.lead == Lead::Curves);
    let (remembering, alone): (Vec<&Sample>, Vec<&Sample>) =
        open.into_iter().partition(|sample| sample.last.is_some());
    [
        header(data),
        intersections(data, &alone, &remembering, &tracing),
        other_questions(&data.moments),
    ]
    .concat()
}

fn of<'s>(samples: &[&'s Sample], mode: Mode) -> impl Iterator<Item = &'s Sample> {
    samples
        .iter()
        .copied()
        .filter(move |sample| sample.mode == mode)
}

/// The samples of queries that have begun, or of those that have not.
fn at<'s>(samples: &[&'s Sample], mode: Mode, begun: bool) -> impl Iterator<Item = &'s Sample> {
    of(samples, mode).filter(move |sample| sample.frontier.is_begun() == begun)
}

/// The samples of queries that have not begun, and are to go to their end.
fn whole<'s>(samples: &[&'s Sample], mode: Mode) -> impl Iterator<Item = &'s Sample> {
    of(samples, mode).filter(|sample| sample.stop.is_none())
}

/// `alone`: without a memory; `remembering`: with one; `tracing`: those that follow curves.
fn intersections(
    data: &Data,
    alone: &[&Sample],
    remembering: &[&Sample],
    tracing: &[&Sample],
) -> String {
    // Before a query and after a part of it are two questions; one answer to both would be the worse for each.
    let hit = [false, true].map(|begun| {
        // Of a frontier that leaves nothing the answer is known.
        let moments = at(alone, Mode::Any, begun).filter(|sample| !sample.frontier.is_clear());
        regression(moments, |s| {
            (hit_features(&s.frontier), f64::from(s.is_hit()))
        })
    });
    let logit = |s: &Sample| {
        let weights = &hit[usize::from(s.frontier.is_begun())];
        dot(weights, &hit_features(&s.frontier))
    };
    let [all_before, all] = [false, true].map(|begun| {
        quantiles(at(alone, Mode::All, begun), |s| {
            (features_of_all(&s.frontier), log_left(s))
        })
    });
    let [any_before, any] = [false, true].map(|begun| {
        quantiles(at(alone, Mode::Any, begun), |s| {
            let features = features_of_any(&s.frontier, sigmoid(logit(s)));
            (features, log_left(s))
        })
    });
    let [_, _, root_most] = quantiles(whole(alone, Mode::All), |s| {
        ([1.0, s.root_cost.max(1.0).log2()], log_left(s))
    });
    let [all_after, any_after] = [Mode::All, Mode::Any].map(|mode| {
        let change = |s: &Sample| {
            let before = s.last.map_or(1.0, |last| last.bv_tests.max(1.0));
            ([1.0], (s.total.bv_tests.max(1.0) / before).log2())
        };
        quantiles(whole(remembering, mode), change).map(|[w]| w)
    });
    let moved = of(remembering, Mode::Any)
        .filter(|sample| sample.stop.is_some() && !sample.frontier.is_clear());
    let after_history = regression(moved, |s| {
        let features = s
            .last
            .map(|last| history_features(logit(s), s.frontier.deepest, &last.history));
        (features.unwrap_or_default(), f64::from(s.is_hit()))
    });
    let hits = whole(alone, Mode::Any).map(|sample| f64::from(sample.is_hit()));
    let base_rate = number(mean(hits).unwrap_or(f64::NAN));
    let [before, begun] = &hit;
    let openings = power_law(data, |counts| counts.box_updates);
    let triangle_tests = power_law(data, |counts| counts.triangle_tests);
    let recall = recall_weights(of(alone, Mode::All), recall_features);
    let tracing = recall_weights(tracing.iter().copied(), tracing_features);
    let each = "for each, the weights of";
    [
        table("ALL_LEFT", &all, &format!("Quantiles of log2 of the BV tests left if all hits are wanted: {each}\n/// `features_of_all`.")),
        table("ALL_BEFORE", &all_before, "`ALL_LEFT` before the query."),
        list("ROOT_MOST", &root_most, "90 % quantile of log2 of the BV tests of a whole query: intercept, and slope in log2 of the pair\n/// cost of the roots at their deepest penetration."),
        table("ANY_LEFT", &any, &format!("`ALL_LEFT` if the first hit ends the query: {each} `features_of_any`.")),
        table("ANY_BEFORE", &any_before, "`ANY_LEFT` before the query."),
        list("ALL_AFTER", &all_after, "Quantiles of log2 (BV tests of a query / BV tests of the query in the frame before)."),
        list("ANY_AFTER", &any_after, "`ALL_AFTER` if the first hit ends the query."),
        list("OPENINGS_OF_BV_TESTS", &openings, "log2 of opened node pairs: intercept, and slope in log2 of BV tests."),
        list("TRIANGLE_TESTS_OF_BV_TESTS", &triangle_tests, "log2 of triangle tests: intercept, and slope in log2 of BV tests."),
        list("HIT", begun, "Logit of a hit after a part of the query: weights of `hit_features`."),
        list("HIT_BEFORE", before, "Logit of a hit before the query: weights of `hit_features`."),
        list("HIT_AFTER_HISTORY", &after_history, "Logit of a hit with the verdict of the frame before: weights of `history_features`."),
        constant("BASE_RATE", "f64", &base_rate, "Fraction of poses with a hit."),
        list("RECALL", &recall, "Logit of the recall: weights of `recall_features`."),
        list("RECALL_TRACING", &tracing, "Logit of the recall of queries that trace curves: weights of `tracing_features`."),
    ]
    .concat()
}

fn other_questions(moments: &Moments) -> String {
    let Moments {
        distances,
        motions,
        contacts,
        manifolds,
        rays,
        points,
    } = moments;
    let alone = |is_limited| {
        distances.iter().filter(move |moment| {
            moment.last.is_none() && moment.seen.closing.limit.is_some() == is_limited
        })
    };
    let [distance, limited] = [false, true]
        .map(|is_limited| work_left(alone(is_limited), |seen| closing_features(&seen.closing)));
    let place = |moment: &Moment<Approaching>| {
        let place = moment.seen.place()?;
        Some((moment.case, between_features(&moment.seen.closing), place))
    };
    let between = quantiles_of(Rows::new(alone(false).filter_map(place)));
    let motion = motions.iter().filter(|moment| moment.last.is_none());
    let single = |moments: &[Moment<Batch>]| {
        let waiting = moments.iter().filter(|moment| moment.seen.done == 0.0);
        quantiles_of(Rows::new(waiting.map(|moment| {
            let each = moment.left() / moment.seen.left;
            (moment.case, single_features(&moment.seen), each.log2())
        })))
    };
    let begun = rays
        .iter()
        .chain(points)
        .filter(|moment| moment.seen.done > 0.0);
    let later = quantiles_of(Rows::new(begun.map(|moment| {
        let ratio = moment.left() / mean_left(&moment.seen);
        (moment.case, batch_features(&moment.seen), ratio.log2())
    })));
    let left = "Quantiles of log2 of the work left";
    let weights = "for each, the weights of\n///";
    [
        table("DISTANCE_LEFT", &distance, &format!("{left} in a distance query without a limit: {weights} `closing_features`.")),
        table("LIMIT_LEFT", &limited, &format!("{left} in a distance query with a limit: {weights} `closing_features`.")),
        list("DISTANCE_AFTER", &after(distances), "Quantiles of log2 (work of a distance query / work of the query in the frame before)."),
        table("DISTANCE_BETWEEN", &between, "Quantiles of the distance, scaled to 0 at its lower bound and 1 at its upper bound: for each,\n/// the weights of `between_features`."),
        table("MOTION_LEFT", &work_left(motion, passing_features), &format!("{left} in a motion query: {weights} `passing_features`.")),
        list("MOTION_AFTER", &after(motions), "Quantiles of log2 (work of a motion query / work of the query for the motion before)."),
        table("CONTACTS_LEFT", &work_left(contacts, listing_features), &format!("{left} in a contact query: {weights} `listing_features`.")),
        table("MANIFOLDS_LEFT", &work_left(manifolds, listing_features), "`CONTACTS_LEFT` of a manifold query."),
        table("RAY_WORK", &single(rays), &format!("{left} for each ray of a batch, before one is done: for each, the\n/// weights of `single_features`.")),
        table("POINT_WORK", &single(points), "`RAY_WORK` of points."),
        table("BATCH_LEFT", &later, &format!("{left} in a batch over the mean of those done times those left: for\n/// each, the weights of `batch_features`.")),
    ]
    .concat()
}

/// Weights of quantiles of log2 of the work left.
fn work_left<'m, S: 'm, const N: usize>(
    moments: impl IntoIterator<Item = &'m Moment<S>>,
    features: impl Fn(&S) -> [f64; N],
) -> [[f64; N]; 3] {
    let row = |moment: &Moment<S>| (moment.case, features(&moment.seen), moment.left().log2());
    quantiles_of(Rows::new(moments.into_iter().map(row)))
}

/// Quantiles of log2 of the work of a query over that of the one before.
fn after<S>(moments: &[Moment<S>]) -> [f64; 3] {
    let whole = moments.iter().filter(|moment| moment.stop.is_none());
    let change = |moment: &Moment<S>| {
        let change = moment.total.max(1.0) / moment.last?.max(1.0);
        Some((moment.case, [1.0], change.log2()))
    };
    quantiles_of(Rows::new(whole.filter_map(change))).map(|[w]| w)
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
    /// From the number of a case, features and target of each.
    fn new(given: impl Iterator<Item = (usize, [f64; N], f64)>) -> Self {
        let mut rows = Self {
            x: Vec::new(),
            y: Vec::new(),
            cases: Vec::new(),
        };
        for (case, x, y) in given {
            rows.x.push(x);
            rows.y.push(y);
            rows.cases.push(case);
        }
        rows
    }

    fn of<'s>(
        samples: impl Iterator<Item = &'s Sample>,
        row: impl Fn(&Sample) -> ([f64; N], f64),
    ) -> Self {
        Self::new(samples.map(|sample| {
            let (x, y) = row(sample);
            (sample.case, x, y)
        }))
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
        self.x
            .iter()
            .zip(&self.cases)
            .map(|(x, case)| dot(&weights[case % FOLDS], x))
            .collect()
    }
}

fn quantiles<'s, const N: usize>(
    samples: impl Iterator<Item = &'s Sample>,
    row: impl Fn(&Sample) -> ([f64; N], f64),
) -> [[f64; N]; 3] {
    quantiles_of(Rows::of(samples, row))
}

/// Weights of three quantiles of a target. Each is moved so that it has its share below in cases that were not fitted.
fn quantiles_of<const N: usize>(rows: Rows<N>) -> [[f64; N]; 3] {
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

fn sigmoid(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// Weights of the recall with about the least mean absolute error: logistic regression, again with samples weighted by slope
/// over error.
fn recall_weights<'s, const N: usize>(
    samples: impl Iterator<Item = &'s Sample>,
    features: fn(&FrontierSummary) -> [f64; N],
) -> [f64; N] {
    let found = samples.filter(|sample| sample.frontier.found > 0.0);
    let (x, y): (Vec<_>, Vec<_>) = found
        .map(|s| (features(&s.frontier), s.frontier.found / s.hits as f64))
        .unzip();
    let mut weights = vec![1.0; x.len()];
    let mut best = (f64::INFINITY, [0.0; N]);
    for _ in 0..20 {
        let w = logistic(&x, &y, &weights, 1e-5);
        let p: Vec<f64> = x.iter().map(|x| sigmoid(dot(&w, x))).collect();
        let errors = p.iter().zip(&y).map(|(p, y)| (p - y).abs());
        let sum: f64 = errors.clone().sum();
        if sum < best.0 {
            best = (sum, w);
        }
        weights = p
            .iter()
            .zip(errors)
            .map(|(p, error)| p * (1.0 - p) / error.max(0.01))
            .collect();
    }
    best.1
}

/// Intercept and slope of log2 of a count of complete queries.
fn power_law(data: &Data, count: impl Fn(&punctual::prediction::Counts) -> f64) -> [f64; 2] {
    let whole = data
        .samples
        .iter()
        .filter(|sample| sample.stop.is_none() && count(&sample.total) > 0.0);
    let (x, y): (Vec<_>, Vec<_>) = whole
        .map(|s| {
            (
                [1.0, s.total.bv_tests.max(1.0).log2()],
                count(&s.total).log2(),
            )
        })
        .unzip();
    least_squares(&x, &y, &vec![1.0; x.len()])
}

fn header(data: &Data) -> String {
    let mut text = format!(
        "//! The fitted constants of the model; made by `punctual fit`, not by hand.\n//!\n//! Fitted on {}, \
         on {} {}, by version {},\n//! from {} poses ({} moments of queries) of:\n",
        machine::today(),
        std::env::consts::ARCH,
        std::env::consts::OS,
        env!("CARGO_PKG_VERSION"),
        data.poses,
        data.counts()[2],
    );
    let mut line = String::from("//!");
    for name in &data.names {
        if line.len() + name.len() >= 100 {
            text += &line;
            text.push('\n');
            line = String::from("//!");
        }
        line.push(' ');
        line += name;
    }
    text + &line + "\n"
}

fn constant(name: &str, kind: &str, value: &str, doc: &str) -> String {
    format!("\n/// {doc}\npub(super) const {name}: {kind} = {value};\n")
}

fn list<const N: usize>(name: &str, numbers: &[f64; N], doc: &str) -> String {
    constant(name, &format!("[f64; {N}]"), &row(numbers), doc)
}

fn table<const N: usize, const M: usize>(name: &str, rows: &[[f64; N]; M], doc: &str) -> String {
    constant(name, &format!("[[f64; {N}]; {M}]"), &lines(rows), doc)
}

/// A number with five digits.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return "0.0".into();
    }
    let decimals = (4.0 - x.abs().log10().floor()).clamp(1.0, 12.0) as usize;
    format!("{x:.decimals$}")
}

fn row(numbers: &[f64]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|&x| number(x)).collect();
    format!("[{}]", numbers.join(", "))
}

fn lines<const N: usize>(rows: &[[f64; N]]) -> String {
    let rows: Vec<_> = rows
        .iter()
        .map(|numbers| format!("\n    {},", row(numbers)))
        .collect();
    format!("[{}\n]", rows.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits() {
        assert_eq!(
            [
                number(1.0 / 3.0),
                number(-12345.678),
                number(0.000_123_456),
                number(0.0)
            ],
            ["0.33333", "-12345.7", "0.00012346", "0.0"]
        );
        assert_eq!(lines(&[[1.0, 2.0]]), "[\n    [1.0000, 2.0000],\n]");
    }
}
