//! The report as a page: the guarantees, tested; then figures and comparisons, each with its worst case.

mod cases;
mod distance;
mod guarantees;
mod time;
mod work;

use std::ops::Range;
use std::path::Path;
use std::time::Duration;

use crate::report::{self, Axis, Block, Chart, Failure, Page, Series, Shape};
use punctual::Mode;

use super::confidence;
use super::contender::{CURVES, CUT_OFF, Curve, DEFAULT, DEPTH_FIRST, ORACLE, label};
use super::distance::OURS;
use super::distance::summary::{FINISHED, Kind, PROVEN};
use super::measure::Limit;
use super::plan::plan;
use super::summary::{DETECTED, Feature, Measurement, RECALL, Which, over_cases};

/// Draws the plots into the folder and returns the page they stand on.
pub fn page(cases: &[Measurement], folder: &Path, intro: Vec<String>) -> Result<Page, Failure> {
    report::create_folder(&folder.join("cases"))?;
    let report = Report { cases, folder };
    let mut sections = Vec::new();
    if cases.iter().any(has_intersections) {
        sections.push(report.time()?);
    }
    sections.extend(report.guarantees());
    if cases.iter().any(distance::has_any) {
        sections.push(report.distance()?);
    }
    if cases.iter().any(has_intersections) {
        // All of these are means over the poses in contact.
        if cases.iter().any(|case| case.hits() > 0) {
            sections.extend(report.work()?);
            sections.push(report.first_hit());
        }
        sections.extend([
            report.volume_left()?,
            report.lateness()?,
            confidence::section(cases, |name, chart| report.plot(name, chart))?,
            report.strata(),
        ]);
    }
    sections.push(report.each_case()?);
    Ok(Page {
        title: "Collision queries that are stopped: speed against error".to_owned(),
        intro,
        sections,
    })
}

/// Whether more than distances was measured.
fn has_intersections(case: &Measurement) -> bool {
    !case.work.rows.is_empty()
}

struct Report<'r> {
    cases: &'r [Measurement],
    folder: &'r Path,
}

impl Report<'_> {
    fn plot(&self, name: &str, chart: &Chart) -> Result<Block, Failure> {
        report::plot(self.folder, name, chart)
    }

    /// What users get from a deadline, in one picture, also to be shown elsewhere.
    fn overview(&self) -> Chart {
        let over_time = |order, mode, feature| time_points(self.cases, order, mode, feature);
        // A plain query for a first contact or a distance knows what depth-first knows.
        let contacts =
            [DEFAULT, DEPTH_FIRST].map(|order| (0, order, over_time(order, Mode::Any, DETECTED)));
        let pairs = [DEFAULT, DEPTH_FIRST, CUT_OFF]
            .map(|order| (1, order, over_time(order, Mode::All, RECALL)));
        let distances = [
            (DEFAULT, OURS, PROVEN),
            (DEPTH_FIRST, DEPTH_FIRST, FINISHED),
        ]
        .map(|(order, name, feature)| {
            (
                2,
                order,
                distance::line(self.cases, Kind::Time, name, feature),
            )
        });
        let shown: Vec<_> = contacts.into_iter().chain(pairs).chain(distances).collect();
        let span = time_span(shown.iter().map(|(.., points)| points));
        let series = shown.into_iter().map(|(color, order, points)| {
            let what = ["contact detected", "pairs found", "distance within 10 %"][color];
            let points = within(points, &span);
            let shape = match order {
                DEPTH_FIRST => Shape::Dashed(points),
                CUT_OFF => Shape::Points(points),
                _ => Shape::Line(points),
            };
            Series::new(format!("{what}: {}", label(order)), color, shape)
        });
        Chart {
            title: "What is known when the time is up".to_owned(),
            series: series.collect(),
            x: Axis::log(TIME).range(span.clone()),
            y: Axis::linear("share, mean over poses").range(0.0..1.0),
        }
    }
}

/// A number for people; a dash where there is none.
fn number(value: f64) -> String {
    decimals(value, 2)
}

/// A count with its noun, such as "3 cases".
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A number with so many digits; a dash where there is none.
pub fn decimals(value: f64, digits: usize) -> String {
    if value.is_finite() {
        format!("{value:.digits$}")
    } else {
        "-".to_owned()
    }
}

/// The lines of the plots, of what was measured.
fn drawn() -> impl Iterator<Item = Curve> {
    CURVES
        .into_iter()
        .filter(|curve| plan().names().any(|name| name == curve.order))
}

const TIME: &str = "time given, microseconds";
const WORK: &str = "work done, % of a full search";

/// What is plotted for a mode. A plain query for a first contact ends with it, as depth-first does, and has no line.
fn curves(mode: Mode) -> impl Iterator<Item = (usize, Curve)> {
    drawn()
        .enumerate()
        .filter(move |(_, curve)| mode == Mode::All || curve.order != CUT_OFF)
}

fn series((color, curve): (usize, Curve), points: Vec<[f64; 2]>) -> Series {
    Series::new(
        curve.label,
        color,
        if curve.dashed {
            Shape::Dashed(points)
        } else {
            Shape::Line(points)
        },
    )
}

/// A feature over the work done; a mean over these cases.
fn over_work(cases: &[Measurement], title: &str, mode: Mode, feature: Feature) -> Chart {
    let points = |order| {
        let measured = plan().percent().map(|percent| {
            [
                f64::from(percent),
                at_work(cases, order, mode, percent, feature),
            ]
        });
        std::iter::once([0.0, 0.0]).chain(measured).collect()
    };
    Chart {
        title: title.to_owned(),
        x: Axis::linear(WORK).range(0.0..100.0),
        y: Axis::linear("share").range(0.0..1.0),
        series: curves(mode)
            .map(|curve| series(curve, points(curve.1.order)))
            .collect(),
    }
}

fn at_work(
    cases: &[Measurement],
    order: &'static str,
    mode: Mode,
    percent: u32,
    feature: Feature,
) -> f64 {
    over_cases(
        cases,
        Which {
            order,
            mode,
            budget: Limit::Work(percent),
        },
        feature,
    )
}

/// A feature over the time given; a mean over these cases.
fn over_time(cases: &[Measurement], title: &str, mode: Mode, feature: Feature) -> Chart {
    let timed = curves(mode).filter(|(_, curve)| curve.order != ORACLE);
    let lines: Vec<_> = timed
        .map(|curve| (curve, time_points(cases, curve.1.order, mode, feature)))
        .collect();
    let span = time_span(lines.iter().map(|(_, points)| points));
    Chart {
        title: title.to_owned(),
        series: lines
            .into_iter()
            .map(|(curve, points)| series(curve, within(points, &span)))
            .collect(),
        x: Axis::log(TIME).range(span),
        y: Axis::linear("share").range(0.0..1.0),
    }
}

fn time_points(
    cases: &[Measurement],
    order: &'static str,
    mode: Mode,
    feature: Feature,
) -> Vec<[f64; 2]> {
    let at = |us: u64| {
        over_cases(
            cases,
            Which {
                order,
                mode,
                budget: Limit::Time(Duration::from_micros(us)),
            },
            feature,
        )
    };
    plan()
        .microseconds()
        .iter()
        .map(|&us| [us as f64, at(us)])
        .collect()
}

/// The times within which something happens: from the last at which all lines are at 0 to the first at which all are at 1.
fn time_span<'p>(lines: impl Iterator<Item = &'p Vec<[f64; 2]>>) -> Range<f64> {
    const END: f64 = 0.005;
    let lines: Vec<_> = lines.collect();
    let all = |i: usize, at: &dyn Fn(f64) -> bool| lines.iter().all(|line| at(line[i][1]));
    let budgets = plan().microseconds();
    let last = budgets.len() - 1;
    let start = (0..last).rev().find(|&i| all(i, &|y| y < END)).unwrap_or(0);
    let end = (start + 1..last)
        .find(|&i| all(i, &|y| y > 1.0 - END))
        .unwrap_or(last);
    budgets[start] as f64..budgets[end].max(budgets[start] + 1) as f64
}

fn within(points: Vec<[f64; 2]>, span: &Range<f64>) -> Vec<[f64; 2]> {
    points
        .into_iter()
        .filter(|[x, _]| *x >= span.start && *x <= span.end)
        .collect()
}

/// The largest, by name: the first of equals.
fn best(
    names: impl Iterator<Item = &'static str>,
    value: impl Fn(&'static str) -> f64,
) -> &'static str {
    names
        .reduce(|best, name| {
            if value(name) > value(best) {
                name
            } else {
                best
            }
        })
        .unwrap_or(DEPTH_FIRST)
}
