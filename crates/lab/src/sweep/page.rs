//! The report as a page: the guarantees, tested; then figures and comparisons, each with its worst case.

mod cases;
mod distance;
mod guarantees;
mod time;
mod work;

use std::ops::Range;
use std::path::Path;

use crate::report::{self, Axis, Block, Chart, Failure, Page, Series, Shape, Table};

use super::confidence;
use super::contender::{CURVES, CUT_OFF, Curve, DEFAULT, DEPTH_FIRST, ORACLE, label};
use super::distance::OURS;
use super::measure::{Asked, Limit};
use super::plan::plan;
use super::summary::{
    DETECTED, FINISHED, Feature, Measurement, PROVEN, RECALL, Which, Worst, over_cases, worst_case,
};

/// Draws the plots into the folder and returns the page they stand on.
pub fn page(cases: &[Measurement], folder: &Path, intro: Vec<String>) -> Result<Page, Failure> {
    report::create_folder(&folder.join("cases"))?;
    let report = Report { cases, folder };
    let has = |asked| cases.iter().any(|case| case.has(asked));
    let mut sections = Vec::new();
    if has(Asked::Any) {
        sections.push(report.time()?);
    }
    sections.extend(report.guarantees());
    if has(Asked::Distance) {
        sections.push(report.distance()?);
    }
    if has(Asked::Any) {
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
        // A plain query for a first contact or a distance knows what depth-first knows.
        let shown: [(usize, &str, &str, Asked, Feature); 7] = [
            (0, DEFAULT, DEFAULT, Asked::Any, DETECTED),
            (0, DEPTH_FIRST, DEPTH_FIRST, Asked::Any, DETECTED),
            (1, DEFAULT, DEFAULT, Asked::All, RECALL),
            (1, DEPTH_FIRST, DEPTH_FIRST, Asked::All, RECALL),
            (1, CUT_OFF, CUT_OFF, Asked::All, RECALL),
            (2, DEFAULT, OURS, Asked::Distance, PROVEN),
            (2, DEPTH_FIRST, DEPTH_FIRST, Asked::Distance, FINISHED),
        ];
        let lines = shown
            .map(|(.., order, asked, feature)| Kind::Time.line(self.cases, order, asked, feature));
        let span = time_span(&lines);
        let series = shown
            .into_iter()
            .zip(lines)
            .map(|((color, order, ..), points)| {
                let what = ["contact detected", "pairs found", "distance within 10 %"][color];
                let points = within(points, &span);
                let shape = match order {
                    CUT_OFF => Shape::Points(points),
                    _ => Shape::line(points, order == DEPTH_FIRST),
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

/// Something of one curve after the other, in words: its mean and its worst case.
fn in_words(name: &str, mean: f64, Worst { case, value }: Worst) -> String {
    let (mean, value) = (number(mean), number(value));
    format!("{name} {mean} (worst case {value}, {case})")
}

/// The lines of the plots, of what was measured.
fn drawn() -> impl Iterator<Item = Curve> {
    CURVES
        .into_iter()
        .filter(|curve| plan().names().any(|name| name == curve.order))
}

const TIME: &str = "time given, microseconds";
const WORK: &str = "work done, % of a full search";

/// The budgets over which something is shown.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Work,
    Time,
}

impl Kind {
    /// The budgets, and their places on an axis.
    fn limits(self) -> Vec<(f64, Limit)> {
        let works = plan().percent().map(|p| (f64::from(p), Limit::Work(p)));
        let times = plan()
            .times()
            .map(|t| (1e6 * t.as_secs_f64(), Limit::Time(t)));
        match self {
            Self::Work => works.collect(),
            Self::Time => times.collect(),
        }
    }

    /// A feature at each budget; a mean over these cases.
    fn line(
        self,
        cases: &[Measurement],
        order: &'static str,
        asked: Asked,
        feature: Feature,
    ) -> Vec<[f64; 2]> {
        let limits = self.limits().into_iter();
        limits
            .map(|(x, limit)| [x, over_cases(cases, Which(order, asked, limit), feature)])
            .collect()
    }

    /// A feature over what is given; a mean over these cases. A plain query for a first contact ends with it, as
    /// depth-first does, and has no line; the best order has no time.
    fn chart(self, cases: &[Measurement], title: &str, asked: Asked, feature: Feature) -> Chart {
        let curves = drawn().enumerate().filter(|(_, curve)| {
            (asked == Asked::All || curve.order != CUT_OFF)
                && (self == Self::Work || curve.order != ORACLE)
        });
        let (curves, mut lines): (Vec<_>, Vec<_>) = curves
            .map(|curve| (curve, self.line(cases, curve.1.order, asked, feature)))
            .unzip();
        let x = if self == Self::Work {
            lines.iter_mut().for_each(|line| line.insert(0, [0.0, 0.0]));
            Axis::linear(WORK).range(0.0..100.0)
        } else {
            let span = time_span(&lines);
            lines = lines.into_iter().map(|line| within(line, &span)).collect();
            Axis::log(TIME).range(span)
        };
        let series = curves
            .into_iter()
            .zip(lines)
            .map(|((color, curve), points)| {
                Series::new(curve.label, color, Shape::line(points, curve.dashed))
            });
        Chart {
            title: title.to_owned(),
            x,
            y: Axis::linear("share").range(0.0..1.0),
            series: series.collect(),
        }
    }
}

fn at_work(
    cases: &[Measurement],
    order: &'static str,
    asked: Asked,
    percent: u32,
    feature: Feature,
) -> f64 {
    over_cases(cases, Which(order, asked, Limit::Work(percent)), feature)
}

/// The times within which something happens: from the last at which all lines are at 0 to the first at which all are at 1.
fn time_span(lines: &[Vec<[f64; 2]>]) -> Range<f64> {
    const END: f64 = 0.005;
    let all = |i: usize, at: &dyn Fn(f64) -> bool| lines.iter().all(|line| at(line[i][1]));
    let budgets = &plan().time_us;
    let last = budgets.len() - 1;
    let start = (0..last).rev().find(|&i| all(i, &|y| y < END)).unwrap_or(0);
    let end = (start + 1..last)
        .find(|&i| all(i, &|y| y > 1.0 - END))
        .unwrap_or(last);
    budgets[start] as f64..budgets[end].max(budgets[start] + 1) as f64
}

fn within(points: Vec<[f64; 2]>, span: &Range<f64>) -> Vec<[f64; 2]> {
    let points = points.into_iter();
    points
        .filter(|[x, _]| *x >= span.start && *x <= span.end)
        .collect()
}

/// A row for each order and a column for each budget, with the mean and the worst case.
fn by_budget(
    title: &str,
    orders: impl Iterator<Item = &'static str>,
    budgets: &[(String, Limit)],
    cell: impl Fn(&'static str, Limit) -> [f64; 2],
) -> Table {
    let names = budgets.iter().map(|(name, _)| name.clone());
    let row = |order| {
        let cells = budgets.iter().map(|(_, limit)| cell(order, *limit));
        let cells = cells.map(|both| both.map(number).join(" / "));
        std::iter::once(label(order).to_owned())
            .chain(cells)
            .collect()
    };
    let header = std::iter::once(title.to_owned()).chain(names);
    Table::new(header, orders.map(row).collect())
}

/// The budgets of work, with their names in tables.
fn works() -> Vec<(String, Limit)> {
    let works = plan().percent();
    works
        .map(|percent| (format!("{percent} %"), Limit::Work(percent)))
        .collect()
}

impl Report<'_> {
    /// Mean over cases and worst case of a feature, for [`by_budget`].
    fn mean_and_worst(
        &self,
        asked: Asked,
        feature: Feature,
    ) -> impl Fn(&'static str, Limit) -> [f64; 2] {
        move |order, limit| {
            let which = Which(order, asked, limit);
            let worst = worst_case(self.cases, which, feature).value;
            [over_cases(self.cases, which, feature), worst]
        }
    }
}
