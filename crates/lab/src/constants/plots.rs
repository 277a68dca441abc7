//! Pictures: reliability diagrams, and distributions of errors.

use std::path::Path;

use super::evaluate::{Costs, Scores};
use crate::report::{Axis, Chart, Failure, Picture, Series, Shape};

pub fn draw(scores: &Scores, folder: &Path) -> Result<(), Failure> {
    let reliability = [
        ("reliability", "Probability of a hit", &scores.chances),
        (
            "reliability_after_history",
            "Probability of a hit, last verdict known",
            &scores.chances_after_history,
        ),
    ];
    for (name, title, chances) in reliability {
        if !chances.0.is_empty() {
            Picture::render(&chances.diagram(title))?.write(folder, name)?;
        }
    }
    let before = [
        ("all", &scores.all),
        ("any", &scores.any),
        ("all, last frame known", &scores.tracked[0][2].costs),
        ("any, last frame known", &scores.tracked[1][2].costs),
    ];
    let during = [
        ("before", &scores.all),
        ("at 10 %", &scores.at_10),
        ("at 50 %", &scores.at_50),
    ];
    Picture::render(&distribution(
        "Error of the predicted BV tests, before the query",
        &before,
    ))?
    .write(folder, "errors_before")?;
    Picture::render(&distribution(
        "Error of the predicted BV tests, during the query",
        &during,
    ))?
    .write(folder, "errors_during")
}

/// Share of queries with at most this error, over the error.
fn distribution(title: &str, costs: &[(&str, &Costs)]) -> Chart {
    const STEPS: usize = 400;
    let line = |costs: &Costs| {
        let mut errors: Vec<f64> = costs.errors.iter().map(|error| error.abs()).collect();
        errors.sort_unstable_by(f64::total_cmp);
        let n = errors.len();
        (0..=STEPS)
            .map(|i| (i * (n - 1)) / STEPS)
            .map(|i| [errors[i], (i + 1) as f64 / n as f64])
            .collect()
    };
    let known = costs.iter().filter(|(_, costs)| !costs.errors.is_empty());
    let series = known
        .zip(0..)
        .map(|((name, costs), color)| Series::new(*name, color, Shape::Line(line(costs))));
    Chart {
        title: title.into(),
        x: Axis::linear("|log2(predicted / actual)|").range(0.0..4.0),
        y: Axis::linear("share of the queries").range(0.0..1.0),
        series: series.collect(),
    }
}
