//! What a query says of its rest, against what came: probability, recall, BV tests.

use std::collections::BTreeMap;

use crate::report::{Block, Chances, Chart, Failure, Lead, Section, Table};
use crate::statistics::{mean, quantile, sorted};
use punctual::Mode;

use super::contender::{DEFAULT, WARM};
use super::page::decimals;
use super::plan::plan;
use super::summary::{Measurement, Worst};

/// What was told at one moment of one query.
#[derive(Clone, Copy)]
pub struct Guess {
    pub pose: usize,
    pub order: &'static str,
    pub mode: Mode,
    /// Of the work; nothing is done yet at 0. Queries that had ended by then told nothing.
    pub percent: u32,
    /// That the surfaces meet; none has been found to.
    pub probability: Option<f64>,
    /// Told share of the intersecting pairs found, less the true one.
    pub recall_error: Option<f64>,
    /// `log2` of the told BV tests over the true ones, of the whole query.
    pub total_error: f64,
}

/// The guesses of some moments: an order, a mode, and a share of the work or all.
fn guesses<'m>(
    cases: &'m [Measurement],
    order: &'static str,
    mode: Mode,
    percent: Option<u32>,
) -> impl Iterator<Item = (&'m Measurement, &'m Guess)> {
    let of_case = |case: &'m Measurement| case.work.guesses.iter().map(move |guess| (case, guess));
    cases.iter().flat_map(of_case).filter(move |(_, guess)| {
        guess.order == order
            && guess.mode == mode
            && percent.is_none_or(|percent| guess.percent == percent)
    })
}

/// Probabilities told by stopped queries that had found nothing.
fn chances(cases: &[Measurement], order: &'static str, percent: Option<u32>) -> Chances {
    let told = guesses(cases, order, Mode::Any, percent).filter(|(_, guess)| guess.percent > 0);
    Chances(
        told.filter_map(|(case, guess)| {
            Some((guess.probability?, case.strata[guess.pose].collides()))
        })
        .collect(),
    )
}

/// Mean absolute error of the recall, where there is something to find.
fn recall_error(cases: &[Measurement], order: &'static str, percent: Option<u32>) -> f64 {
    let told = guesses(cases, order, Mode::All, percent)
        .filter(|(case, guess)| case.strata[guess.pose].collides());
    mean(told.filter_map(|(_, guess)| guess.recall_error.map(f64::abs))).unwrap_or(f64::NAN)
}

/// Median and 90 % quantile of the absolute error of the told cost.
fn total_error(cases: &[Measurement], order: &'static str, mode: Mode, percent: u32) -> [f64; 2] {
    let errors = sorted(
        guesses(cases, order, mode, Some(percent)).map(|(_, guess)| guess.total_error.abs()),
    );
    [0.5, 0.9].map(|fraction| quantile(&errors, fraction))
}

/// Figures for `punctual compare`: the same bits in every run.
pub fn figures(cases: &[Measurement], figures: &mut BTreeMap<String, f64>) {
    let mut put = |name: String, value: f64| figures.insert(name, value);
    for order in [DEFAULT, WARM] {
        let chances = chances(cases, order, None);
        put(format!("brier {order}"), chances.brier());
        put(format!("ece {order}"), chances.calibration_error());
    }
    put(
        "recall error".to_owned(),
        recall_error(cases, DEFAULT, None),
    );
    put(
        format!("recall error {WARM}"),
        recall_error(cases, WARM, None),
    );
    for percent in [0, 10, 50] {
        for (name, mode) in [("any", Mode::Any), ("all", Mode::All)] {
            let [median, high] = total_error(cases, DEFAULT, mode, percent);
            put(
                format!("error of predicted bv tests {name}@{percent}% p50"),
                median,
            );
            put(
                format!("error of predicted bv tests {name}@{percent}% p90"),
                high,
            );
        }
    }
}

/// What is told before the query and at each share of its work.
fn table(cases: &[Measurement]) -> Table {
    let header = [
        "work",
        "undecided",
        "Brier",
        "ECE",
        "warm: undecided",
        "Brier",
        "ECE",
        "error of the recall",
        "warm",
        "BV tests any: p50",
        "p90",
        "all: p50",
        "p90",
    ];
    let number = |x| decimals(x, 3);
    let row = |percent: u32| {
        let mut row = vec![if percent == 0 {
            "before".to_owned()
        } else {
            format!("{percent} %")
        }];
        for order in [DEFAULT, WARM] {
            let chances = chances(cases, order, Some(percent));
            row.push(chances.0.len().to_string());
            row.extend([chances.brier(), chances.calibration_error()].map(number));
        }
        row.extend([DEFAULT, WARM].map(|order| number(recall_error(cases, order, Some(percent)))));
        for mode in [Mode::Any, Mode::All] {
            row.extend(total_error(cases, DEFAULT, mode, percent).map(number));
        }
        row
    };
    let rows = std::iter::once(0)
        .chain(plan().percent())
        .filter(|percent| *percent < 100)
        .map(row)
        .collect();
    Table {
        header: header.map(str::to_owned).to_vec(),
        rows,
    }
}

/// Undecided stops from which on the probabilities of a single case are judged: with fewer, chance alone makes them look bad.
const ENOUGH: usize = 30;

/// Errors of the probabilities told in single cases.
struct Errors<'m> {
    /// Mean over the cases with enough stops.
    mean: f64,
    worst: Worst<'m>,
    /// A row for each case.
    rows: Vec<Vec<String>>,
}

impl<'m> Errors<'m> {
    fn of(cases: &'m [Measurement]) -> Self {
        let alone = |case| chances(std::slice::from_ref(case), DEFAULT, None);
        let told: Vec<(&str, Chances)> = cases
            .iter()
            .map(|case| (&*case.name, alone(case)))
            .collect();
        let judged = || told.iter().filter(|(_, chances)| chances.0.len() >= ENOUGH);
        let errors = || judged().map(|(case, chances)| (*case, chances.calibration_error()));
        let row = |(case, chances): &(&str, Chances)| {
            let scores =
                [chances.brier(), chances.calibration_error()].map(|score| decimals(score, 3));
            [case.to_string(), chances.0.len().to_string()]
                .into_iter()
                .chain(scores)
                .collect()
        };
        let mean = mean(errors().map(|(_, error)| error)).unwrap_or(f64::NAN);
        Self {
            mean,
            worst: Worst::largest(errors()),
            rows: judged().map(row).collect(),
        }
    }
}

pub fn section(
    cases: &[Measurement],
    mut plot: impl FnMut(&str, &Chart) -> Result<Block, Failure>,
) -> Result<Section, Failure> {
    let [cold, warm] = [DEFAULT, WARM].map(|order| chances(cases, order, None));
    let mut blocks = vec![];
    for (name, title, chances) in [
        ("reliability", "Probability of contact", &cold),
        ("reliability-warm", "The same, with memory", &warm),
    ] {
        if !chances.0.is_empty() {
            blocks.push(plot(name, &chances.diagram(title))?);
        }
    }
    blocks.push(Block::Text(
        "Of queries that had found nothing when they were stopped. Brier: mean square of the probability told less what came (0 or 1). \
         ECE: how far off, on average over ten bins, what was told was from how often it came. Error of the recall: mean absolute \
         difference from the true share. BV tests: |log2(told / true)| of the whole query. Warm: with a memory of the pose before."
            .into(),
    ));
    blocks.push(Block::Table(table(cases)));
    let Errors { mean, worst, rows } = Errors::of(cases);
    blocks.push(Block::Table(Table::new(
        ["case", "undecided stops", "Brier", "ECE"],
        rows,
    )));
    let measured = if cold.0.is_empty() {
        "No query was undecided when it was stopped.".to_owned()
    } else {
        let number = |x| decimals(x, 3);
        format!(
            "{} undecided stops: Brier {}, off by {} on average (ECE). Single cases with {ENOUGH} stops or more: off by {} \
             on average, worst case {}, {}. Share of the pairs found: told within {} on average.",
            cold.0.len(),
            number(cold.brier()),
            number(cold.calibration_error()),
            number(mean),
            number(worst.value),
            worst.case,
            number(recall_error(cases, DEFAULT, None)),
        )
    };
    Ok(Section {
        id: "confidence".into(),
        title: "How sure is a partial answer?".into(),
        lead: Lead::Shows(
            "A stopped query that has found no contact tells how likely there is one. Shown is how often there was one where \
             it told which probability."
                .into(),
        ),
        measured,
        blocks,
    })
}
