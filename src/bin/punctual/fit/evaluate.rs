//! How well the built-in constants do: a table of errors for each case and in total.

use std::io::Write;
use std::path::Path;

use punctual::Mode;
use punctual::model::confidence::{DEFAULT_PRIOR, probability, recall};
use punctual::model::prediction::{Quantiles, all_left, all_left_after, any_left, any_left_after};

use super::Data;
use super::plots;
use super::sample::Sample;
use crate::report::{self, Failure};

/// Errors `log2(predicted / actual)` of the whole cost, and whether the actual cost is below each quantile.
#[derive(Default)]
pub struct Costs {
    pub errors: Vec<f64>,
    below: [usize; 3],
}

/// Probabilities told, and what came of them.
#[derive(Default)]
pub struct Chances(pub Vec<(f64, bool)>);

/// What is measured of some samples.
#[derive(Default)]
pub struct Scores {
    pub all: Costs,
    pub any: Costs,
    pub all_after_history: Costs,
    pub any_after_history: Costs,
    pub at_10: Costs,
    pub at_50: Costs,
    pub chances: Chances,
    pub chances_after_history: Chances,
    /// The same with those queries that were decided within the budget, and so are certain.
    budgeted: Chances,
    budgeted_after_history: Chances,
    pub recalls: Vec<f64>,
    pub recalls_with_hits: Vec<f64>,
}

impl Costs {
    fn add(&mut self, sample: &Sample, left: Quantiles) {
        let [used, actual] = [sample.front.bv_tests, sample.total.bv_tests].map(|n| n.max(0.0));
        let Quantiles { p10, p50, p90 } = left.map(|n| n + used);
        self.errors.push((p50.max(1.0) / actual.max(1.0)).log2());
        // Predictions are real numbers, counts are whole.
        for (below, quantile) in self.below.iter_mut().zip([p10, p50, p90]) {
            *below += usize::from(actual <= quantile + 0.5);
        }
    }

    fn fields(&self) -> Vec<String> {
        let absolute: Vec<f64> = self.errors.iter().map(|e| e.abs()).collect();
        let share = |below: usize| below as f64 / self.errors.len() as f64;
        let [low, _, high] = self.below;
        [quantile(&absolute, 0.5), quantile(&absolute, 0.9), share(high), share(low)].map(text).to_vec()
    }
}

impl Chances {
    fn fields(&self) -> Vec<String> {
        [self.0.len() as f64, self.brier(), self.calibration_error()].map(text).to_vec()
    }

    /// Mean square of the difference between what was told (0 to 1) and what came (0 or 1).
    pub fn brier(&self) -> f64 {
        let squares = self.0.iter().map(|&(p, hit)| (p - f64::from(hit)).powi(2));
        squares.sum::<f64>() / self.0.len() as f64
    }

    /// Mean difference, over ten bins, between what was told and how often it came.
    pub fn calibration_error(&self) -> f64 {
        let bins = self.bins();
        bins.iter().map(|bin| bin.count * (bin.told - bin.came).abs()).sum::<f64>() / self.0.len() as f64
    }

    /// Ten bins of equal width, without the empty ones.
    pub fn bins(&self) -> Vec<Bin> {
        let bin = |i: usize| {
            let inside = || self.0.iter().filter(move |(p, _)| ((p * 10.0) as usize).min(9) == i);
            let count = inside().count() as f64;
            let told = inside().map(|(p, _)| p).sum::<f64>() / count;
            let came = inside().filter(|(_, hit)| *hit).count() as f64 / count;
            Bin { count, told, came }
        };
        (0..10).map(bin).filter(|bin| bin.count > 0.0).collect()
    }
}

/// Probabilities that are about the same.
pub struct Bin {
    pub count: f64,
    /// Their mean.
    pub told: f64,
    /// The share that came true.
    pub came: f64,
}

impl Bin {
    /// The range of the true probability, 95 % (Wilson's score interval).
    pub fn interval(&self) -> [f64; 2] {
        const Z: f64 = 1.96;
        let (n, p) = (self.count, self.came);
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        [(middle - half).max(0.0), (middle + half).min(1.0)]
    }
}

impl Scores {
    fn add(&mut self, sample: &Sample) {
        let front = &sample.front;
        let history = sample.last.map(|last| last.history);
        let chance = probability(front, history.as_ref(), DEFAULT_PRIOR);
        let model = match sample.mode {
            Mode::All => all_left(front),
            Mode::Any => any_left(front, chance),
        };
        let left = match (sample.last, sample.mode) {
            (None, _) => model,
            (Some(last), Mode::All) => all_left_after(model, last.bv_tests, front.bv_tests),
            (Some(last), Mode::Any) => any_left_after(model, last.bv_tests, front.bv_tests),
        };
        let costs = match (sample.mode, sample.stop, sample.last) {
            (Mode::All, None, None) => Some(&mut self.all),
            (Mode::Any, None, None) => Some(&mut self.any),
            (Mode::All, None, Some(_)) => Some(&mut self.all_after_history),
            (Mode::Any, None, Some(_)) => Some(&mut self.any_after_history),
            (Mode::All, Some(0.1), None) => Some(&mut self.at_10),
            (Mode::All, Some(0.5), None) => Some(&mut self.at_50),
            _ => None,
        };
        if let Some(costs) = costs {
            costs.add(sample, left);
        }
        match (sample.mode, sample.stop) {
            (Mode::Any, _) => self.add_chance(sample, chance),
            (Mode::All, Some(_)) if sample.last.is_none() && sample.is_hit() => self.add_recall(sample),
            (Mode::All, _) => {}
        }
    }

    fn add_chance(&mut self, sample: &Sample, chance: f64) {
        let (undecided, budgeted) = match sample.last {
            None => (&mut self.chances.0, &mut self.budgeted.0),
            Some(_) => (&mut self.chances_after_history.0, &mut self.budgeted_after_history.0),
        };
        let is_hit = sample.is_hit();
        if sample.stop.is_none() {
            budgeted.extend(std::iter::repeat_n((f64::from(is_hit), is_hit), sample.decided));
        } else {
            undecided.push((chance, is_hit));
            budgeted.push((chance, is_hit));
        }
    }

    fn add_recall(&mut self, sample: &Sample) {
        let error = (recall(&sample.front) - sample.front.found / sample.hits as f64).abs();
        self.recalls.push(error);
        if sample.front.found > 0.0 {
            self.recalls_with_hits.push(error);
        }
    }

    fn fields(&self) -> Vec<String> {
        let costs = [&self.all, &self.any, &self.all_after_history, &self.any_after_history, &self.at_10, &self.at_50];
        let mean = |errors: &[f64]| text(errors.iter().sum::<f64>() / errors.len() as f64);
        let mut fields: Vec<String> = costs.into_iter().flat_map(Costs::fields).collect();
        let chances = [&self.chances, &self.chances_after_history, &self.budgeted, &self.budgeted_after_history];
        fields.extend(chances.into_iter().flat_map(Chances::fields));
        fields.extend([mean(&self.recalls), mean(&self.recalls_with_hits)]);
        fields
    }
}

/// Columns of a cost: median and 90 % quantile of `|log2(predicted / actual)|`, shares of actual costs not above the predicted
/// 90 % quantile and the 10 % quantile.
const COSTS: [&str; 6] = ["all", "any", "all_after_history", "any_after_history", "all_at_10", "all_at_50"];

/// Columns of probabilities: how many were told, their Brier score and calibration error; for queries that their budget left
/// undecided, and for all with a budget.
const CHANCES: [&str; 4] = ["undecided", "undecided_after_history", "budgeted", "budgeted_after_history"];

fn header() -> String {
    let costs =
        COSTS.iter().flat_map(|cost| ["median", "p90", "below_p90", "below_p10"].map(|f| format!("{cost}_{f}")));
    let chances = CHANCES.iter().flat_map(|of| ["count", "brier", "ece"].map(|f| format!("{of}_{f}")));
    let recalls = ["recall_mae", "recall_mae_with_hits"].map(str::to_owned);
    let names: Vec<String> = costs.chain(chances).chain(recalls).collect();
    format!("case,{}", names.join(","))
}

/// Writes the table and the pictures to `folder`, and the totals to `out`.
pub fn report(data: &Data, folder: &Path, out: &mut impl Write) -> Result<(), Failure> {
    let mut total = Scores::default();
    let mut cases: Vec<Scores> = data.names.iter().map(|_| Scores::default()).collect();
    for sample in &data.samples {
        total.add(sample);
        cases[sample.case].add(sample);
    }
    let named = data.names.iter().map(String::as_str).zip(&cases).chain([("total", &total)]);
    let row = |(name, scores): (&str, &Scores)| [vec![name.to_owned()], scores.fields()].concat();
    let rows: Vec<_> = named.map(row).collect();
    report::write_csv(folder, "model", &header(), &rows)?;
    for (name, value) in header().split(',').zip(&rows[rows.len() - 1]).skip(1) {
        writeln!(out, "{name:32} {value}")?;
    }
    plots::draw(&total, folder)
}

/// A quantile of numbers in any order; NaN without any.
fn quantile(numbers: &[f64], p: f64) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    sorted.get((p * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Three decimals; nothing for what was not measured.
fn text(x: f64) -> String {
    if x.is_finite() { format!("{x:.3}").trim_end_matches('0').trim_end_matches('.').to_owned() } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_of_chances_by_hand() {
        let chances = Chances(vec![(0.2, false), (0.2, true), (0.9, true), (1.0, true)]);
        assert!((chances.brier() - (0.04 + 0.64 + 0.01) / 4.0).abs() < 1e-12);
        // Told .2, came half of the time; told .95 on average, came always.
        assert!((chances.calibration_error() - (2.0 * 0.3 + 2.0 * 0.05) / 4.0).abs() < 1e-12);
        let [low, high] = chances.bins()[1].interval();
        assert!(high == 1.0 && (low - 0.342).abs() < 1e-3, "{low}");
    }

    #[test]
    fn quantiles_and_text() {
        assert_eq!([quantile(&[3.0, 1.0, 2.0], 0.5), quantile(&[3.0, 1.0, 2.0], 0.9)], [2.0, 3.0]);
        assert_eq!([text(f64::NAN), text(0.5), text(2.0), text(1.0 / 3.0)], ["", "0.5", "2", "0.333"]);
    }
}
