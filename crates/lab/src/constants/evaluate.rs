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
use super::moments::{Approaching, Moment};
use super::plots;
use super::sample::Sample;
use crate::report::{self, Chances, Failure};
use crate::statistics::{mean, quantile, sorted};

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
        let corrected = tracker.corrected(model);
        self.costs.add(used, actual, corrected);
        covered.push(actual <= used + corrected.p90 + 0.5);
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

    fn figures(&self) -> Vec<(&'static str, f64)> {
        let mut figures = self.costs.figures();
        figures.push(("worst_window", self.worst_window()));
        figures
    }
}

/// Queries after which the quantiles for a pair are judged, and how many together.
const LEARNING: usize = 10;
const WINDOW: usize = 50;

/// What is measured of some samples.
#[derive(Default)]
pub struct Scores {
    /// By the names of [`COSTS`].
    costs: BTreeMap<&'static str, Costs>,
    /// Of each kind of [`TRACKED`] and each of [`STAGES`].
    pub tracked: [[Tracked; 3]; 4],
    /// How many distances were told from stopped queries, and how many are not above each quantile.
    between: [usize; 4],
    /// Without and with a history: of queries that were undecided when their budget ended; and with
    /// those that were decided within the budget, and so are certain.
    pub undecided: [Chances; 2],
    budgeted: [Chances; 2],
    /// Errors of the recall: of all, where something was found, after a history, along curves.
    recalls: [Vec<f64>; 4],
}

impl Scores {
    /// Errors of a cost, one of [`COSTS`].
    pub fn errors(&self, name: &str) -> &[f64] {
        self.costs.get(name).map_or(&[], |costs| &costs.errors)
    }

    fn costs(&mut self, name: &'static str) -> &mut Costs {
        self.costs.entry(name).or_default()
    }

    fn add(&mut self, sample: &Sample) {
        if sample.lead == Lead::Curves {
            if sample.stop.is_some() && sample.frontier.found > 0.0 {
                self.recalls[3].push(recall_error(sample));
            }
            return;
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
            self.costs("level_sum")
                .add(0.0, total, Quantiles::exactly(sum));
            self.costs("frontier_sum")
                .add(0.0, total, Quantiles::exactly(expected(frontier)));
        }
        let name = match (sample.mode, sample.stop, sample.last) {
            (Mode::All, None, None) => Some("all"),
            (Mode::Any, None, None) => Some("any"),
            (Mode::All, Some(0.1), None) => Some("all_at_10"),
            (Mode::All, Some(0.5), None) => Some("all_at_50"),
            _ => None,
        };
        if let Some(name) = name {
            self.costs(name).add(used, total, left);
        }
        match (sample.mode, sample.stop) {
            (Mode::Any, _) => self.add_chance(sample, chance),
            (Mode::All, Some(_)) if sample.is_hit() => self.add_recall(sample),
            (Mode::All, _) => {}
        }
    }

    /// A cost told at a moment, for one of the names: before the query, stopped at 10 % and at 50 %.
    fn add_cost<S>(&mut self, moment: &Moment<S>, names: [&'static str; 3], left: Quantiles) {
        let name = match (moment.stop, moment.last) {
            (None, None) => names[0],
            (Some(0.1), None) => names[1],
            (Some(0.5), None) => names[2],
            _ => return,
        };
        self.costs(name).add(moment.work, moment.total, left);
    }

    /// The same, corrected by what came of those before, for a kind of [`TRACKED`].
    fn track<S>(&mut self, moment: &Moment<S>, kind: usize, left: Quantiles) {
        if let Some(stage) = stage(moment.stop, moment.last.is_some()) {
            self.tracked[kind][stage].add(moment.case, moment.work, moment.total, left);
        }
    }

    /// What is told to be left at a moment, for one of the names: before work is done, and stopped.
    fn add_left<S>(&mut self, moment: &Moment<S>, names: [&'static str; 2], left: Quantiles) {
        let name = names[usize::from(moment.work > 0.0)];
        self.costs(name).add(0.0, moment.total - moment.work, left);
    }

    fn add_distance(&mut self, moment: &Moment<Approaching>) {
        let closing = &moment.seen.closing;
        let left = work_left(closing);
        if closing.limit.is_some() {
            if moment.stop.is_none() {
                self.costs("distance_limited")
                    .add(moment.work, moment.total, left);
            }
            return;
        }
        let names = ["distance", "distance_at_10", "distance_at_50"];
        self.add_cost(moment, names, left);
        self.track(moment, 2, left);
        if moment.last.is_none() && moment.seen.place().is_some() {
            let Quantiles { p10, p50, p90 } = between(closing);
            let [told, below @ ..] = &mut self.between;
            *told += 1;
            for (below, quantile) in below.iter_mut().zip([p10, p50, p90]) {
                *below += usize::from(moment.seen.distance <= quantile);
            }
        }
    }

    fn add_chance(&mut self, sample: &Sample, chance: f64) {
        let with_history = usize::from(sample.last.is_some());
        let budgeted = &mut self.budgeted[with_history].0;
        let is_hit = sample.is_hit();
        if sample.stop.is_none() {
            let certain = (f64::from(is_hit), is_hit);
            budgeted.extend(std::iter::repeat_n(certain, sample.decided));
        } else {
            budgeted.push((chance, is_hit));
            self.undecided[with_history].0.push((chance, is_hit));
        }
    }

    fn add_recall(&mut self, sample: &Sample) {
        let error = recall_error(sample);
        if sample.last.is_some() {
            self.recalls[2].push(error);
        } else {
            self.recalls[0].push(error);
            if sample.frontier.found > 0.0 {
                self.recalls[1].push(error);
            }
        }
    }

    /// The columns of the table.
    fn figures(&self) -> Vec<(String, f64)> {
        let none = Costs::default();
        let costs = |name| self.costs.get(name).unwrap_or(&none).figures();
        let costs = COSTS.split(' ').map(|name| (name.to_owned(), costs(name)));
        let tracked = TRACKED
            .iter()
            .zip(&self.tracked)
            .flat_map(|(kind, stages)| {
                let stages = STAGES.iter().zip(stages);
                stages.map(move |(stage, tracked)| (format!("{kind}_{stage}"), tracked.figures()))
            });
        let scores = |chances: &Chances| {
            vec![
                ("count", chances.0.len() as f64),
                ("brier", chances.brier()),
                ("ece", chances.calibration_error()),
            ]
        };
        let chances = self.undecided.iter().chain(&self.budgeted).map(scores);
        let chances = CHANCES.map(str::to_owned).into_iter().zip(chances);
        let [told, low, median, high] = self.between.map(|count| count as f64);
        let between = vec![
            ("count", told),
            ("below_p10", low / told),
            ("below_p50", median / told),
            ("below_p90", high / told),
        ];
        let mean = |errors: &Vec<f64>| mean(errors.iter().copied()).unwrap_or(f64::NAN);
        let recalls = RECALLS.into_iter().zip(self.recalls.iter().map(mean));
        let groups = costs.chain(tracked).chain(chances).chain([
            ("distance_between".to_owned(), between),
            ("recall".to_owned(), recalls.collect()),
        ]);
        let named = |(group, figures): (String, Vec<(&str, f64)>)| {
            let name = move |(figure, value)| (format!("{group}_{figure}"), value);
            figures.into_iter().map(name).collect::<Vec<_>>()
        };
        groups.flat_map(named).collect()
    }
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

    fn figures(&self) -> Vec<(&'static str, f64)> {
        let absolute = sorted(self.errors.iter().map(|e| e.abs()));
        let share = |below: usize| below as f64 / self.errors.len() as f64;
        let [low, _, high] = self.below;
        vec![
            ("median", quantile(&absolute, 0.5)),
            ("p90", quantile(&absolute, 0.9)),
            ("below_p90", share(high)),
            ("below_p10", share(low)),
        ]
    }
}

/// By how much the told recall of a stopped query is off.
fn recall_error(sample: &Sample) -> f64 {
    (recall(&sample.frontier, sample.lead) - sample.frontier.found / sample.hits as f64).abs()
}

/// Columns of a cost: median and 90 % quantile of `|log2(predicted / actual)|`, shares of actual costs not above the predicted
/// 90 % quantile and the 10 % quantile.
const COSTS: &str = "all any level_sum frontier_sum all_at_10 all_at_50 distance distance_limited \
    distance_at_10 distance_at_50 motion motion_at_10 motion_at_50 contacts contacts_stopped manifolds \
    manifolds_stopped rays rays_stopped points points_stopped";

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

/// Columns of mean absolute errors of the recall.
const RECALLS: [&str; 4] = [
    "mae",
    "mae_with_hits",
    "mae_after_history",
    "mae_marching_with_hits",
];

/// Reports how well the built-in constants do: writes tables (CSV) and pictures (SVG) of their errors to `folder`, and the
/// totals to `out`.
///
/// # Errors
/// If a file cannot be written; the message names it.
pub fn report(data: &Data, folder: &Path, out: &mut impl Write) -> Result<(), Failure> {
    let names: Vec<&str> = data
        .names
        .iter()
        .map(String::as_str)
        .chain(["total"])
        .collect();
    let mut scores: Vec<Scores> = names.iter().map(|_| Scores::default()).collect();
    let mut add = |case: usize, add: &dyn Fn(&mut Scores)| {
        add(&mut scores[case]);
        add(&mut scores[names.len() - 1]);
    };
    for sample in &data.samples {
        add(sample.case, &|scores| scores.add(sample));
    }
    let moments = &data.moments;
    for moment in &moments.distances {
        add(moment.case, &|scores| scores.add_distance(moment));
    }
    for moment in &moments.motions {
        let left = motion_work_left(&moment.seen);
        add(moment.case, &|scores| {
            scores.track(moment, 3, left);
            scores.add_cost(moment, ["motion", "motion_at_10", "motion_at_50"], left);
        });
    }
    for (moments, names, left) in [
        (
            &moments.contacts,
            ["contacts", "contacts_stopped"],
            contacts_left as fn(&_) -> _,
        ),
        (
            &moments.manifolds,
            ["manifolds", "manifolds_stopped"],
            manifolds_left,
        ),
    ] {
        for moment in moments {
            add(moment.case, &|scores| {
                scores.add_left(moment, names, left(&moment.seen))
            });
        }
    }
    for (moments, names, left) in [
        (
            &moments.rays,
            ["rays", "rays_stopped"],
            rays_left as fn(&_) -> _,
        ),
        (&moments.points, ["points", "points_stopped"], points_left),
    ] {
        for moment in moments {
            add(moment.case, &|scores| {
                scores.add_left(moment, names, left(&moment.seen))
            });
        }
    }
    let figures: Vec<_> = scores.iter().map(Scores::figures).collect();
    let text = |value: &f64| report::cell(*value, 3);
    let row = |(name, figures): (&&str, &Vec<(String, f64)>)| {
        let cells = figures.iter().map(|(_, value)| text(value));
        std::iter::once(name.to_string()).chain(cells).collect()
    };
    let rows: Vec<_> = names.iter().zip(&figures).map(row).collect();
    let total = &figures[names.len() - 1];
    let header: Vec<&str> = total.iter().map(|(name, _)| name.as_str()).collect();
    report::write_csv(
        folder,
        "model",
        &format!("case,{}", header.join(",")),
        &rows,
    )?;
    for (name, value) in total {
        writeln!(out, "{name:32} {}", text(value))?;
    }
    plots::draw(&scores[names.len() - 1], folder)
}
