//! How well the built-in constants do: a table of errors for each case and in total.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use punctual::Mode;
use punctual::internals::{
    Lead, Tracker, all_left, any_left, between, contacts_left, expected, manifolds_left,
    motion_work_left, points_left, probability, rays_left, recall, work_left,
};
use punctual::prediction::{DEFAULT_PRIOR, Quantiles};

use super::Data;
use super::distances::Moment;
use super::plots;
use super::sample::Sample;
use super::{batches, listings, motions};
use crate::report::{self, Chances, Failure};
use crate::statistics::{quantile, sorted};

/// Errors `log2(predicted / actual)` of the whole cost, and whether the actual cost is below each quantile.
#[derive(Default)]
pub struct Costs {
    pub errors: Vec<f64>,
    below: [usize; 3],
}

/// Predictions for the queries of a pair one after the other, each corrected by what came of those
/// before.
#[derive(Default)]
pub struct Tracked {
    pub costs: Costs,
    /// For each case: its tracker, and whether each query took no more than the 90 % quantile.
    pairs: BTreeMap<usize, (Tracker, Vec<bool>)>,
}

impl Tracked {
    fn add(&mut self, case: usize, used: f64, actual: f64, model: Quantiles) {
        let (tracker, covered) = self.pairs.entry(case).or_default();
        let told = tracker.told(model);
        self.costs.add(used, actual, told);
        covered.push(actual <= used + told.p90 + 0.5);
        tracker.learn(model, actual - used, true);
    }

    /// The least share of a window of queries of one pair that took no more than the 90 % quantile.
    fn worst_window(&self) -> f64 {
        let windows = self.pairs.values().flat_map(|(_, covered)| {
            let later = covered.get(LEARNING..).unwrap_or_default();
            let long = if later.len() >= WINDOW { later } else { &[] };
            long.windows(WINDOW)
        });
        let share = |window: &[bool]| {
            window.iter().filter(|covered| **covered).count() as f64 / WINDOW as f64
        };
        windows.map(share).fold(f64::NAN, f64::min)
    }

    fn fields(&self) -> Vec<String> {
        let mut fields = self.costs.fields();
        fields.push(text(self.worst_window()));
        fields
    }
}

/// Queries after which the quantiles for a pair are judged, and how many together.
const LEARNING: usize = 10;
const WINDOW: usize = 50;

/// What is measured of some samples.
#[derive(Default)]
pub struct Scores {
    /// The whole cost by the level-wise sum alone, and by its sum over the frontier of the probe.
    level_sum: Costs,
    frontier_sum: Costs,
    /// Of each kind of [`TRACKED`]: before the query, stopped, and before it with a memory.
    pub tracked: [[Tracked; 3]; 4],
    contacts: Costs,
    contacts_stopped: Costs,
    manifolds: Costs,
    manifolds_stopped: Costs,
    rays: Costs,
    rays_stopped: Costs,
    points: Costs,
    points_stopped: Costs,
    pub all: Costs,
    pub any: Costs,
    pub at_10: Costs,
    pub at_50: Costs,
    distance: Costs,
    distance_limited: Costs,
    distance_at_10: Costs,
    distance_at_50: Costs,
    motion: Costs,
    motion_at_10: Costs,
    motion_at_50: Costs,
    /// How many distances were told from stopped queries, and how many are not above each quantile.
    between: [usize; 4],
    pub chances: Chances,
    pub chances_after_history: Chances,
    /// The same with those queries that were decided within the budget, and so are certain.
    budgeted: Chances,
    budgeted_after_history: Chances,
    pub recalls: Vec<f64>,
    pub recalls_with_hits: Vec<f64>,
    pub recalls_after_history: Vec<f64>,
    pub recalls_marching: Vec<f64>,
}

impl Costs {
    fn add(&mut self, used: f64, actual: f64, left: Quantiles) {
        let Quantiles { p10, p50, p90 } = left.map(|n| n + used);
        self.errors.push((p50.max(1.0) / actual.max(1.0)).log2());
        // Predictions are real numbers, counts are whole.
        for (below, quantile) in self.below.iter_mut().zip([p10, p50, p90]) {
            *below += usize::from(actual <= quantile + 0.5);
        }
    }

    fn fields(&self) -> Vec<String> {
        let absolute = sorted(self.errors.iter().map(|e| e.abs()));
        let share = |below: usize| below as f64 / self.errors.len() as f64;
        let [low, _, high] = self.below;
        [
            quantile(&absolute, 0.5),
            quantile(&absolute, 0.9),
            share(high),
            share(low),
        ]
        .map(text)
        .to_vec()
    }
}

fn fields_of(chances: &Chances) -> Vec<String> {
    [
        chances.0.len() as f64,
        chances.brier(),
        chances.calibration_error(),
    ]
    .map(text)
    .to_vec()
}

impl Scores {
    fn add(&mut self, sample: &Sample) {
        if sample.lead == Lead::Curves {
            return self.add_marching(sample);
        }
        let frontier = &sample.frontier;
        let history = sample.last.map(|last| last.history);
        let chance = probability(frontier, history.as_ref(), DEFAULT_PRIOR);
        let left = match sample.mode {
            Mode::All => all_left(frontier),
            Mode::Any => any_left(frontier, chance),
        };
        let (used, total) = (sample.frontier.bv_tests, sample.total.bv_tests);
        let kind = usize::from(sample.mode == Mode::Any);
        if let Some(stage) = stage(sample.stop, sample.last.is_some())
            && !frontier.is_done()
        {
            self.tracked[kind][stage].add(sample.case, used, total, left);
        }
        if sample.mode == Mode::All && sample.stop.is_none() && sample.last.is_none() {
            // The root of the product of what both subtrees take against themselves.
            let sum = (sample.root_cost / 27.0).powi(2);
            self.level_sum.add(0.0, total, Quantiles::exactly(sum));
            self.frontier_sum
                .add(0.0, total, Quantiles::exactly(expected(frontier)));
        }
        let costs = match (sample.mode, sample.stop, sample.last) {
            (Mode::All, None, None) => Some(&mut self.all),
            (Mode::Any, None, None) => Some(&mut self.any),
            (Mode::All, Some(0.1), None) => Some(&mut self.at_10),
            (Mode::All, Some(0.5), None) => Some(&mut self.at_50),
            _ => None,
        };
        if let Some(costs) = costs {
            costs.add(used, total, left);
        }
        match (sample.mode, sample.stop) {
            (Mode::Any, _) => self.add_chance(sample, chance),
            (Mode::All, Some(_)) if sample.is_hit() => self.add_recall(sample),
            (Mode::All, _) => {}
        }
    }

    fn add_distance(&mut self, moment: &Moment) {
        let Moment {
            ref closing,
            stop,
            total,
            distance,
            last,
            ..
        } = *moment;
        let costs = match (stop, last, closing.limit) {
            (None, None, None) => Some(&mut self.distance),
            (None, None, Some(_)) => Some(&mut self.distance_limited),
            (Some(0.1), None, None) => Some(&mut self.distance_at_10),
            (Some(0.5), None, None) => Some(&mut self.distance_at_50),
            _ => None,
        };
        if let Some(costs) = costs {
            costs.add(closing.work, total, work_left(closing));
        }
        if let Some(stage) = stage(stop, last.is_some())
            && closing.limit.is_none()
        {
            self.tracked[2][stage].add(moment.case, closing.work, total, work_left(closing));
        }
        if closing.limit.is_none() && last.is_none() && moment.place().is_some() {
            let Quantiles { p10, p50, p90 } = between(closing);
            let [told, below @ ..] = &mut self.between;
            *told += 1;
            for (below, quantile) in below.iter_mut().zip([p10, p50, p90]) {
                *below += usize::from(distance <= quantile);
            }
        }
    }

    fn add_motion(&mut self, moment: &motions::Moment) {
        let (used, left) = (moment.passing.work, motion_work_left(&moment.passing));
        if let Some(stage) = stage(moment.stop, moment.last.is_some()) {
            self.tracked[3][stage].add(moment.case, used, moment.total, left);
        }
        let costs = match (moment.stop, moment.last) {
            (None, None) => &mut self.motion,
            (Some(0.1), None) => &mut self.motion_at_10,
            (Some(0.5), None) => &mut self.motion_at_50,
            _ => return,
        };
        costs.add(used, moment.total, left);
    }

    fn add_listing(&mut self, moment: &listings::Moment) {
        let listing = &moment.listing;
        let (costs, left) = match (moment.is_manifold, moment.stop > 0.0) {
            (false, false) => (&mut self.contacts, contacts_left(listing)),
            (false, true) => (&mut self.contacts_stopped, contacts_left(listing)),
            (true, false) => (&mut self.manifolds, manifolds_left(listing)),
            (true, true) => (&mut self.manifolds_stopped, manifolds_left(listing)),
        };
        costs.add(0.0, moment.total - listing.work, left);
    }

    fn add_batch(&mut self, moment: &batches::Moment) {
        let batch = &moment.batch;
        let (costs, left) = match (moment.is_of_points, batch.work > 0.0) {
            (false, false) => (&mut self.rays, rays_left(batch)),
            (false, true) => (&mut self.rays_stopped, rays_left(batch)),
            (true, false) => (&mut self.points, points_left(batch)),
            (true, true) => (&mut self.points_stopped, points_left(batch)),
        };
        costs.add(0.0, moment.total - batch.work, left);
    }

    fn add_chance(&mut self, sample: &Sample, chance: f64) {
        let (undecided, budgeted) = match sample.last {
            None => (&mut self.chances.0, &mut self.budgeted.0),
            Some(_) => (
                &mut self.chances_after_history.0,
                &mut self.budgeted_after_history.0,
            ),
        };
        let is_hit = sample.is_hit();
        if sample.stop.is_none() {
            budgeted.extend(std::iter::repeat_n(
                (f64::from(is_hit), is_hit),
                sample.decided,
            ));
        } else {
            undecided.push((chance, is_hit));
            budgeted.push((chance, is_hit));
        }
    }

    fn add_recall(&mut self, sample: &Sample) {
        let error = recall_error(sample);
        if sample.last.is_some() {
            self.recalls_after_history.push(error);
        } else {
            self.recalls.push(error);
            if sample.frontier.found > 0.0 {
                self.recalls_with_hits.push(error);
            }
        }
    }

    fn add_marching(&mut self, sample: &Sample) {
        if sample.stop.is_some() && sample.frontier.found > 0.0 {
            self.recalls_marching.push(recall_error(sample));
        }
    }

    fn fields(&self) -> Vec<String> {
        let costs = [
            &self.all,
            &self.any,
            &self.level_sum,
            &self.frontier_sum,
            &self.at_10,
            &self.at_50,
            &self.distance,
            &self.distance_limited,
            &self.distance_at_10,
            &self.distance_at_50,
            &self.motion,
            &self.motion_at_10,
            &self.motion_at_50,
            &self.contacts,
            &self.contacts_stopped,
            &self.manifolds,
            &self.manifolds_stopped,
            &self.rays,
            &self.rays_stopped,
            &self.points,
            &self.points_stopped,
        ];
        let mean = |errors: &[f64]| text(errors.iter().sum::<f64>() / errors.len() as f64);
        let mut fields: Vec<String> = costs.into_iter().flat_map(Costs::fields).collect();
        fields.extend(self.tracked.iter().flatten().flat_map(Tracked::fields));
        let chances = [
            &self.chances,
            &self.chances_after_history,
            &self.budgeted,
            &self.budgeted_after_history,
        ];
        fields.extend(chances.into_iter().flat_map(fields_of));
        let [told, below @ ..] = self.between.map(|count| count as f64);
        fields.push(text(told));
        fields.extend(below.map(|below| text(below / told)));
        let recalls = [
            &self.recalls,
            &self.recalls_with_hits,
            &self.recalls_after_history,
            &self.recalls_marching,
        ];
        fields.extend(recalls.map(|errors| mean(errors)));
        fields
    }
}

/// By how much the told recall of a stopped query is off.
fn recall_error(sample: &Sample) -> f64 {
    (recall(&sample.frontier, sample.lead) - sample.frontier.found / sample.hits as f64).abs()
}

/// Columns of a cost: median and 90 % quantile of `|log2(predicted / actual)|`, shares of actual costs not above the predicted
/// 90 % quantile and the 10 % quantile.
const COSTS: [&str; 21] = [
    "all",
    "any",
    "level_sum",
    "frontier_sum",
    "all_at_10",
    "all_at_50",
    "distance",
    "distance_limited",
    "distance_at_10",
    "distance_at_50",
    "motion",
    "motion_at_10",
    "motion_at_50",
    "contacts",
    "contacts_stopped",
    "manifolds",
    "manifolds_stopped",
    "rays",
    "rays_stopped",
    "points",
    "points_stopped",
];

/// Columns of costs that are corrected pair by pair. They have one more: the least share not above
/// the 90 % quantile of any 50 queries of one case in a row, after the first 10.
const TRACKED: [&str; 4] = ["all", "any", "distance", "motion"];
const STAGES: [&str; 3] = ["tracked", "stopped_tracked", "after_history"];

/// The place in [`STAGES`] of a moment; `None` for those that are not tracked.
fn stage(stop: Option<f64>, has_memory: bool) -> Option<usize> {
    match (stop.is_some(), has_memory) {
        (stopped, false) => Some(usize::from(stopped)),
        (false, true) => Some(2),
        (true, true) => None,
    }
}

/// Columns of probabilities: how many were told, their Brier score and calibration error; for queries that their budget left
/// undecided, and for all with a budget.
const CHANCES: [&str; 4] = [
    "undecided",
    "undecided_after_history",
    "budgeted",
    "budgeted_after_history",
];

fn header() -> String {
    let costs = COSTS.iter().flat_map(|cost| {
        ["median", "p90", "below_p90", "below_p10"].map(|f| format!("{cost}_{f}"))
    });
    let chances = CHANCES
        .iter()
        .flat_map(|of| ["count", "brier", "ece"].map(|f| format!("{of}_{f}")));
    let between =
        ["count", "below_p10", "below_p50", "below_p90"].map(|of| format!("distance_between_{of}"));
    let recalls = ["", "_with_hits", "_after_history", "_marching_with_hits"]
        .map(|of| format!("recall_mae{of}"));
    let tracked = TRACKED.iter().flat_map(|kind| {
        STAGES.iter().flat_map(move |stage| {
            ["median", "p90", "below_p90", "below_p10", "worst_window"]
                .map(|f| format!("{kind}_{stage}_{f}"))
        })
    });
    let names: Vec<String> = costs
        .chain(tracked)
        .chain(chances)
        .chain(between)
        .chain(recalls)
        .collect();
    format!("case,{}", names.join(","))
}

/// Reports how well the built-in constants do: writes tables (CSV) and pictures (SVG, PNG) of their errors to `folder`, and
/// the totals to `out`.
///
/// # Errors
/// If a file cannot be written; the message names it.
pub fn report(data: &Data, folder: &Path, out: &mut impl Write) -> Result<(), Failure> {
    let mut total = Scores::default();
    let mut cases: Vec<Scores> = data.names.iter().map(|_| Scores::default()).collect();
    for sample in &data.samples {
        total.add(sample);
        cases[sample.case].add(sample);
    }
    for moment in &data.moments {
        total.add_distance(moment);
        cases[moment.case].add_distance(moment);
    }
    for moment in &data.motions {
        total.add_motion(moment);
        cases[moment.case].add_motion(moment);
    }
    for moment in &data.listings {
        total.add_listing(moment);
        cases[moment.case].add_listing(moment);
    }
    for moment in &data.batches {
        total.add_batch(moment);
        cases[moment.case].add_batch(moment);
    }
    let named = data
        .names
        .iter()
        .map(String::as_str)
        .zip(&cases)
        .chain([("total", &total)]);
    let row = |(name, scores): (&str, &Scores)| [vec![name.to_owned()], scores.fields()].concat();
    let rows: Vec<_> = named.map(row).collect();
    report::write_csv(folder, "model", &header(), &rows)?;
    for (name, value) in header().split(',').zip(&rows[rows.len() - 1]).skip(1) {
        writeln!(out, "{name:32} {value}")?;
    }
    plots::draw(&total, folder)
}

/// Three decimals; nothing for what was not measured.
fn text(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.3}")
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned()
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_the_table() {
        assert_eq!(
            [text(f64::NAN), text(0.5), text(2.0), text(1.0 / 3.0)],
            ["", "0.5", "2", "0.333"]
        );
    }
}
