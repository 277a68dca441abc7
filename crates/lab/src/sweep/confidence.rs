//! What a query says of its rest, against what came: probability, recall, BV tests.

use crate::report::{Block, Chances, Chart, Failure, Lead, Section, Table};
use crate::statistics::{mean, quantile, sorted};

use super::contender::{DEFAULT, WARM};
use super::measure::Asked;
use super::page::decimals;
use super::plan::plan;
use super::summary::{Measurement, Worst};

/// What was told at one moment of one query.
#[derive(Clone, Copy)]
pub struct Guess {
    pub pose: usize,
    pub order: &'static str,
    pub asked: Asked,
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
    asked: Asked,
    percent: Option<u32>,
) -> impl Iterator<Item = (&'m Measurement, &'m Guess)> {
    let of_case = |case: &'m Measurement| case.work.guesses.iter().map(move |guess| (case, guess));
    cases.iter().flat_map(of_case).filter(move |(_, guess)| {
        guess.order == order
            && guess.asked == asked
            && percent.is_none_or(|percent| guess.percent == percent)
    })
}

/// Probabilities told by stopped queries that had found nothing.
fn chances(cases: &[Measurement], order: &'static str, percent: Option<u32>) -> Chances {
    let told = guesses(cases, order, Asked::Any, percent).filter(|(_, guess)| guess.percent > 0);
    Chances(
        told.filter_map(|(case, guess)| {
            Some((guess.probability?, case.strata[guess.pose].collides()))
        })
        .collect(),
    )
}

/// Mean absolute error of the recall, where there is something to find.
fn recall_error(cases: &[Measurement], order: &'static str, percent: Option<u32>) -> f64 {
    let told = guesses(cases, order, Asked::All, percent)
        .filter(|(case, guess)| case.strata[guess.pose].collides());
    mean(told.filter_map(|(_, guess)| guess.recall_error.map(f64::abs))).unwrap_or(f64::NAN)
}

/// Median and 90 % quantile of the absolute error of the told cost.
fn total_error(cases: &[Measurement], order: &'static str, asked: Asked, percent: u32) -> [f64; 2] {
    let errors = sorted(
        guesses(cases, order, asked, Some(percent)).map(|(_, guess)| guess.total_error.abs()),
    );
    [0.5, 0.9].map(|fraction| quantile(&errors, fraction))
}

/// Figures for `punctual compare`: the same bits in every run.
pub fn figures(cases: &[Measurement], put: &mut impl FnMut(String, f64)) {
    for order in [DEFAULT, WARM] {
        let chances = chances(cases, order, None);
        put(format!("brier {order}"), chances.brier());
        put(format!("ece {order}"), chances.calibration_error());
    }
    for (name, order) in [("recall error", DEFAULT), ("recall error warm", WARM)] {
        put(name.to_owned(), recall_error(cases, order, None));
    }
    for percent in [0, 10, 50] {
        for (name, asked) in [("any", Asked::Any), ("all", Asked::All)] {
            let errors = total_error(cases, DEFAULT, asked, percent);
            for (fraction, error) in ["p50", "p90"].into_iter().zip(errors) {
                let name = format!("error of predicted bv tests {name}@{percent}% {fraction}");
                put(name, error);
            }
        }
    }
}

/// What is told before the query and at each share of its work.
fn table(cases: &[Measurement]) -> Table {
    let header = "work|undecided|Brier|ECE|warm: undecided|Brier|ECE|error of the recall|warm|\
                  BV tests any: p50|p90|all: p50|p90";
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
        for asked in [Asked::Any, Asked::All] {
            row.extend(total_error(cases, DEFAULT, asked, percent).map(number));
        }
        row
    };
    let rows = std::iter::once(0)
        .chain(plan().percent())
        .filter(|percent| *percent < 100)
        .map(row)
        .collect();
    Table::new(header.split('|'), rows)
}

/// Undecided stops from which on the probabilities of a single case are judged: with fewer, chance alone makes them look bad.
const ENOUGH: usize = 30;

pub fn section(
    cases: &[Measurement],
    mut plot: impl FnMut(&str, &Chart) -> Result<Block, Failure>,
) -> Result<Section, Failure> {
    let number = |x| decimals(x, 3);
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
    let alone = |case| chances(std::slice::from_ref(case), DEFAULT, None);
    let judged = cases.iter().map(|case| (&*case.name, alone(case)));
    let judged: Vec<(&str, Chances)> = judged
        .filter(|(_, chances)| chances.0.len() >= ENOUGH)
        .collect();
    let errors = || {
        judged
            .iter()
            .map(|(case, chances)| (*case, chances.calibration_error()))
    };
    let row = |(case, chances): &(&str, Chances)| {
        let scores = [chances.brier(), chances.calibration_error()].map(number);
        let count = chances.0.len().to_string();
        [case.to_string(), count]
            .into_iter()
            .chain(scores)
            .collect()
    };
    blocks.push(Block::Table(Table::new(
        ["case", "undecided stops", "Brier", "ECE"],
        judged.iter().map(row).collect(),
    )));
    let worst = Worst::largest(errors());
    let measured = if cold.0.is_empty() {
        "No query was undecided when it was stopped.".to_owned()
    } else {
        format!(
            "{} undecided stops: Brier {}, off by {} on average (ECE). Single cases with {ENOUGH} stops or more: off by {} \
             on average, worst case {}, {}. Share of the pairs found: told within {} on average.",
            cold.0.len(),
            number(cold.brier()),
            number(cold.calibration_error()),
            number(mean(errors().map(|(_, error)| error)).unwrap_or(f64::NAN)),
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
