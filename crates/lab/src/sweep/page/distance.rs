//! How far apart surfaces are: what a stopped query knows of it, after a share of the work and after a time.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table, short};
use crate::statistics::{mean, quantile, sorted};

use super::super::contender::DEPTH_FIRST;
use super::super::distance::{ORDERS, OURS, TOLD};
use super::super::measure::Asked;
use super::super::summary::{
    Feature, GOALS, HIGH, HIGH_IS_NEAR, LOW, Measurement, PROVEN, Which, reached_over_cases, spread,
};
use super::{Kind, Report, TIME, in_words, number, time_span};

const WORK: &str = "work done, % of a finished depth-first query";

/// Each order with its colour, the same as in the other plots, and its name in words.
const CURVES: [(&str, usize, &str); 3] = [
    (OURS, 0, "this library"),
    (DEPTH_FIRST, 2, "depth-first"),
    (TOLD, 4, "told the closest triangles"),
];

/// Colours of other libraries.
const PEERS: [usize; 5] = [5, 6, 1, 3, 7];

fn label(order: &str) -> &'static str {
    let curve = CURVES.iter().find(|curve| curve.0 == order);
    curve.map_or("", |curve| curve.2)
}

/// For each peer the median of its times at the poses of these cases.
fn peers(cases: &[Measurement]) -> BTreeMap<&String, f64> {
    let names: BTreeSet<&String> = cases.iter().flat_map(|case| case.peers.keys()).collect();
    let times = |name| {
        cases
            .iter()
            .filter_map(move |case| case.peers.get(name))
            .flat_map(BTreeMap::values)
            .copied()
    };
    names
        .into_iter()
        .map(|name| (name, quantile(&sorted(times(name)), 0.5)))
        .collect()
}

/// Who is compared: who is told the answer has no use for a deadline.
fn curves(kind: Kind) -> impl Iterator<Item = (&'static str, usize, &'static str)> {
    CURVES
        .into_iter()
        .filter(move |curve| kind == Kind::Work || curve.0 != TOLD)
}

/// The axis on which these shares of poses are shown, and lines up to `top` where other libraries have
/// their answer.
fn axis(
    kind: Kind,
    cases: &[Measurement],
    shares: &[Vec<[f64; 2]>],
    top: f64,
) -> (Axis, Vec<Series>) {
    if kind == Kind::Work {
        return (Axis::linear(WORK).range(0.0..100.0), Vec::new());
    }
    let peers = peers(cases);
    let span = time_span(shares);
    let last = peers.values().map(|us| 1.2 * us).fold(span.end, f64::max);
    let line = |(i, (name, us)): (usize, (&String, f64))| {
        Series::new(
            format!("{name} has its answer"),
            PEERS[i % PEERS.len()],
            Shape::Line(vec![[us, 0.0], [us, top]]),
        )
    };
    (
        Axis::log(TIME).range(span.start..last),
        peers.into_iter().enumerate().map(line).collect(),
    )
}

/// Both bounds over the true distance: the median pose as lines, and a band beyond which is one of ten on each side.
fn bounds(cases: &[Measurement], title: String, kind: Kind) -> Chart {
    const TOP: f64 = 2.0;
    let at = |order, feature, fraction: f64| {
        let limits = kind.limits().into_iter();
        let points = limits.map(move |(x, limit)| {
            let values = spread(cases, Which(order, Asked::Distance, limit), feature);
            [x, quantile(&values, fraction)]
        });
        points.collect::<Vec<_>>()
    };
    let band = at(OURS, LOW, 0.1).into_iter().zip(at(OURS, HIGH, 0.9));
    let band = band.map(|([x, low], [_, high])| [x, low, high]);
    let mut series = vec![Series::new("", 0, Shape::Band(band.collect()))];
    for (order, color, name) in curves(kind) {
        for (name, feature) in [(name, LOW), ("", HIGH)] {
            // What is above the frame is drawn along its edge.
            let points = at(order, feature, 0.5).into_iter();
            let points = points.map(|[x, y]| [x, y.min(TOP)]).collect();
            series.push(Series::new(name, color, Shape::line(points, order != OURS)));
        }
    }
    let (x, peers) = axis(kind, cases, &shares(cases, kind), TOP);
    series.extend(peers);
    Chart {
        title,
        x,
        y: Axis::linear("bound / true distance").range(0.0..TOP),
        series,
    }
}

/// For each order and goal, the share of poses that have reached it.
fn shares(cases: &[Measurement], kind: Kind) -> Vec<Vec<[f64; 2]>> {
    let line = |order, feature: Feature| kind.line(cases, order, Asked::Distance, feature);
    curves(kind)
        .flat_map(|(order, ..)| [HIGH_IS_NEAR, PROVEN].map(|feature| line(order, feature)))
        .collect()
}

/// These shares.
fn near(cases: &[Measurement], title: String, kind: Kind) -> Chart {
    let lines = shares(cases, kind);
    let (x, peers) = axis(kind, cases, &lines, 1.0);
    let names = curves(kind).flat_map(|(order, color, name)| {
        [("upper bound", true), ("both bounds", false)]
            .map(|(bound, is_dashed)| (order, format!("{name}: {bound}"), color, is_dashed))
    });
    // Who is told the answer has the upper bound at once.
    let shown = names.zip(lines);
    let shown = shown.filter(|((order, .., is_upper), _)| *order != TOLD || !is_upper);
    let series = shown.map(|((_, name, color, is_dashed), points)| {
        Series::new(name, color, Shape::line(points, is_dashed))
    });
    Chart {
        title,
        x,
        y: Axis::linear("share of the poses").range(0.0..1.0),
        series: series.chain(peers).collect(),
    }
}

/// The plots of all cases, or of one, whose name is added to the titles.
pub(super) fn charts(cases: &[Measurement], of: &str) -> [(&'static str, Chart); 4] {
    let draw = |id, what, over, kind, chart: fn(&[Measurement], String, Kind) -> Chart| {
        (id, chart(cases, format!("{what}, over {over}{of}"), kind))
    };
    let [distance, near_by] = ["Bounds of the distance", "Known within 10 %"];
    [
        draw("distance", distance, "work", Kind::Work, bounds),
        draw("distance-near", near_by, "work", Kind::Work, near),
        draw("distance-time", distance, "time", Kind::Time, bounds),
        draw("distance-near-time", near_by, "time", Kind::Time, near),
    ]
}

impl Report<'_> {
    pub(super) fn distance(&self) -> Result<Section, Failure> {
        let goals = GOALS.into_iter().enumerate().map(|(goal, (name, _))| {
            let words = ORDERS.map(|order| {
                let (mean, worst) = reached_over_cases(self.cases, order, goal);
                in_words(label(order), mean, worst)
            });
            format!("{name}: {}", words.join("; "))
        });
        let goals: Vec<String> = goals.collect();
        let charts = charts(self.cases, "");
        let plots = charts
            .iter()
            .map(|(name, chart)| self.plot(name, chart))
            .collect::<Result<Vec<_>, _>>()?;
        let mut blocks = vec![Block::Text(
            "Lines: the median pose; shaded: nine of ten poses of this library on each side. \"Depth-first\" opens the closest \
             child first and then all that is left, with the same boxes and triangles; as long as something is left it \
             proves no lower bound. \"Told the closest triangles\" begins with the answer and only has to prove that nothing \
             is closer, which no search with these boxes can avoid. A finished query counts as within 10 %: it ends as soon as the bounds are \
             a millionth of the size of the meshes apart. Of another library nothing is known before its line, the median \
             of its times."
                .into(),
        )];
        blocks.extend(plots);
        blocks.extend([Block::Table(self.goals()), Block::Table(self.finished())]);
        Ok(Section::shows(
            "distance",
            "How far apart are they?",
            "Whenever a distance query stops, it says between which bounds the distance lies: no two points are closer than \
             the lower bound, two named points are as close as the upper one. Shown is how soon they close in, at the poses at \
             which the meshes are apart.",
            format!(
                "Share of the work of a finished depth-first query with which the median pose of a case has its {}. Means over \
                 cases.",
                goals.join(". Its ")
            ),
            blocks,
        ))
    }

    /// For each case the work with which the median pose reaches each goal.
    fn goals(&self) -> Table {
        let columns = GOALS.into_iter().enumerate().flat_map(|(goal, (name, _))| {
            ORDERS.map(|order| (format!("{name}: {}", label(order)), order, goal))
        });
        let columns: Vec<(String, &str, usize)> = columns.collect();
        let row = |case: &Measurement| {
            let alone = std::slice::from_ref(case);
            let cells = columns
                .iter()
                .map(|(_, order, goal)| number(reached_over_cases(alone, order, *goal).0));
            let poses = case.work.reached.len() / ORDERS.len();
            [case.name.clone(), poses.to_string()]
                .into_iter()
                .chain(cells)
                .collect()
        };
        let header = ["share of the work", "poses apart"].into_iter();
        let header = header.chain(columns.iter().map(|(name, ..)| name.as_str()));
        Table::new(header, self.apart().map(row).collect())
    }

    /// The cases in which a distance was measured.
    fn apart(&self) -> impl Iterator<Item = &Measurement> {
        self.cases.iter().filter(|case| case.has(Asked::Distance))
    }

    /// What finished queries take, and those of other libraries.
    fn finished(&self) -> Table {
        let peers: Vec<&String> = peers(self.cases).into_keys().collect();
        let row = |case: &Measurement| {
            let ours = ORDERS.map(|order| {
                // The least time of each pose.
                let mut least = BTreeMap::new();
                let rounds = case.rounds.iter().flat_map(|round| &round.finished);
                for run in rounds.filter(|run| run.order == order && run.asked == Asked::Distance) {
                    let time = least.entry(run.pose).or_insert(f64::INFINITY);
                    *time = (1e6 * run.cost).min(*time);
                }
                least
            });
            let none = BTreeMap::new();
            let theirs = peers
                .iter()
                .map(|name| case.peers.get(*name).unwrap_or(&none));
            let cells = ours.iter().chain(theirs).map(|times| {
                let Some(mean) = mean(times.values().copied()) else {
                    return "-".to_owned();
                };
                let slowest = times.values().copied().fold(0.0, f64::max);
                format!("{} / {}", short(mean), short(slowest))
            });
            std::iter::once(case.name.clone()).chain(cells).collect()
        };
        let header = std::iter::once("finished distance query, us: mean / slowest pose");
        let header = header.chain(ORDERS.map(label));
        let header = header.chain(peers.iter().map(|name| name.as_str()));
        Table::new(header, self.apart().map(row).collect())
    }
}
