//! Speed against error: the same recording within one budget after the other.

use std::io::Write;
use std::path::Path;

use punctual::Budget;
use punctual_lab::report::{self, Axis, Chart, Failure, Series, Shape};

use super::files::Recording;
use super::play::{Settings, play};
use super::summary::Summary;

/// Budgets, as parts of the median frame without one.
const PARTS: [f64; 9] = [0.1, 0.15, 0.25, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0];

pub fn run(
    recording: &Recording,
    settings: &Settings,
    plot: Option<&Path>,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let unlimited = Settings {
        budget: None,
        ..*settings
    };
    let free = Summary::of(&play(recording, &unlimited, |_, _| Ok(()))?.0);
    let [median, p99, max] = free.cpu.map(|time| time.as_secs_f64() * 1e6);
    writeln!(
        out,
        "# without a budget: cpu_us median={median:.1} p99={p99:.1} max={max:.1} wrong={}",
        free.wrong
    )?;
    writeln!(
        out,
        "part,budget_us,found,decided,wrong,worst_age,cpu_median_us,cpu_p99_us,overrun_p99_us"
    )?;
    let (mut found, mut decided) = (vec![], vec![]);
    for part in PARTS {
        let limit = free.cpu[0].mul_f64(part);
        let (rows, _) = play(
            recording,
            &Settings {
                budget: Some(Budget::time(limit)),
                ..*settings
            },
            |_, _| Ok(()),
        )?;
        let summary = Summary::of(&rows);
        found.push([100.0 * part, summary.found()]);
        decided.push([100.0 * part, summary.decided]);
        let us = |time: std::time::Duration| time.as_secs_f64() * 1e6;
        writeln!(
            out,
            "{part},{:.1},{:.5},{:.5},{},{},{:.1},{:.1},{:.2}",
            us(limit),
            summary.found(),
            summary.decided,
            summary.wrong,
            summary.worst_age,
            us(summary.cpu[0]),
            us(summary.cpu[1]),
            us(summary.overrun[1]),
        )?;
    }
    if let Some(folder) = plot {
        report::create_folder(folder)?;
        let mut series = vec![Series::new("pairs decided", 1, Shape::Line(decided))];
        if recording.truth.is_some() {
            series.insert(
                0,
                Series::new("intersecting pairs found", 0, Shape::Line(found)),
            );
        }
        let chart = Chart {
            title: "What a frame knows when its budget ends".to_owned(),
            x: Axis::log("budget, % of the median frame without one"),
            y: Axis::linear("share").range(0.0..1.0),
            series,
        };
        report::plot(folder, "scene", &chart)?;
    }
    Ok(())
}
