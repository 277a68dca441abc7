//! Pictures: reliability diagrams, and distributions of errors.

use std::path::Path;

use super::evaluate::Scores;
use crate::report::{self, Axis, Chart, Failure, Series, Shape};
use crate::statistics::sorted;

pub fn draw(scores: &Scores, folder: &Path) -> Result<(), Failure> {
    let reliability = [
        ("reliability", "Probability of a hit"),
        (
            "reliability_after_history",
            "Probability of a hit, last verdict known",
        ),
    ];
    for ((name, title), chances) in reliability.into_iter().zip(&scores.undecided) {
        if !chances.0.is_empty() {
            report::plot(folder, name, &chances.diagram(title))?;
        }
    }
    let tracked = |kind: usize| &*scores.tracked[kind][2].costs.errors;
    let before = [
        ("all", scores.errors("all")),
        ("any", scores.errors("any")),
        ("all, last frame known", tracked(0)),
        ("any, last frame known", tracked(1)),
    ];
    let during = [
        ("before", scores.errors("all")),
        ("at 10 %", scores.errors("all_at_10")),
        ("at 50 %", scores.errors("all_at_50")),
    ];
    for (name, when, costs) in [
        ("errors_before", "before", &before[..]),
        ("errors_during", "during", &during),
    ] {
        let title = format!("Error of the predicted BV tests, {when} the query");
        report::plot(folder, name, &distribution(title, costs))?;
    }
    Ok(())
}

/// Share of queries with at most this error, over the error.
fn distribution(title: String, kinds: &[(&str, &[f64])]) -> Chart {
    const STEPS: usize = 400;
    let line = |errors: &[f64]| {
        let errors = sorted(errors.iter().map(|error| error.abs()));
        let n = errors.len();
        (0..=STEPS)
            .map(|i| (i * (n - 1)) / STEPS)
            .map(|i| [errors[i], (i + 1) as f64 / n as f64])
            .collect()
    };
    let known = kinds.iter().filter(|(_, errors)| !errors.is_empty());
    let series = known
        .zip(0..)
        .map(|((name, errors), color)| Series::new(*name, color, Shape::Line(line(errors))));
    Chart {
        title,
        x: Axis::linear("|log2(predicted / actual)|").range(0.0..4.0),
        y: Axis::linear("share of the queries").range(0.0..1.0),
        series: series.collect(),
    }
}
