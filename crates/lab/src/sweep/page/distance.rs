//! How far apart surfaces are: what a stopped query knows of it, after a share of the work and after a time.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::{Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table, short};
use crate::statistics::{quantile, sorted};

use super::super::contender::DEPTH_FIRST;
use super::super::distance::summary::{
    Feature, GOALS, HIGH, HIGH_IS_NEAR, Kind, LARGEST, LOW, MEAN, PROVEN, reached,
    reached_over_cases,
};
use super::super::distance::{ORDERS, OURS, TOLD};
use super::super::plan::plan;
use super::super::summary::{Measurement, Worst};
use super::{Report, TIME, number, time_span};

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
    CURVES
        .iter()
        .find(|curve| curve.0 == order)
        .map_or("", |curve| curve.2)
}

impl Kind {
    /// Where its stops are: places on an axis.
    fn places(self) -> Vec<f64> {
        match self {
            Self::Work => (1..=100).map(f64::from).collect(),
            Self::Time => plan().microseconds().iter().map(|&us| us as f64).collect(),
        }
    }

    /// Who is compared: who is told the answer has no use for a deadline.
    fn curves(self) -> impl Iterator<Item = (&'static str, usize, &'static str)> {
        CURVES
            .into_iter()
            .filter(move |curve| self == Self::Work || curve.0 != TOLD)
    }

    /// The axis, and lines where other libraries have their answer.
    fn axis(self, cases: &[Measurement], lines: &[Vec<[f64; 2]>], top: f64) -> (Axis, Vec<Series>) {
        if self == Self::Work {
            return (Axis::linear(WORK).range(0.0..100.0), Vec::new());
        }
        let peers = peers(cases);
        let span = time_span(lines.iter());
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

/// Both bounds over the true distance: the median pose as lines, and a band beyond which is one of ten on each side.
fn bounds(cases: &[Measurement], title: &str, kind: Kind) -> Chart {
    const TOP: f64 = 2.0;
    let at = |order, feature, fraction: f64| {
        let point = |(i, x): (usize, f64)| {
            [
                x,
                quantile(&kind.spread(cases, order, i, feature), fraction),
            ]
        };
        kind.places()
            .into_iter()
            .enumerate()
            .map(point)
            .collect::<Vec<_>>()
    };
    let band = at(OURS, LOW, 0.1)
        .into_iter()
        .zip(at(OURS, HIGH, 0.9))
        .map(|([x, low], [_, high])| [x, low, high]);
    let mut series = vec![Series::new("", 0, Shape::Band(band.collect()))];
    for (order, color, name) in kind.curves() {
        for (name, feature) in [(name, LOW), ("", HIGH)] {
            // What is above the frame is drawn along its edge.
            let points = at(order, feature, 0.5)
                .into_iter()
                .map(|[x, y]| [x, y.min(TOP)])
                .collect();
            series.push(Series::new(
                name,
                color,
                if order == OURS {
                    Shape::Line(points)
                } else {
                    Shape::Dashed(points)
                },
            ));
        }
    }
    let (x, peers) = kind.axis(cases, &shares(cases, kind), TOP);
    series.extend(peers);
    Chart {
        title: title.to_owned(),
        x,
        y: Axis::linear("bound / true distance").range(0.0..TOP),
        series,
    }
}

/// A feature at each budget; a mean over these cases.
pub(super) fn line(
    cases: &[Measurement],
    kind: Kind,
    order: &'static str,
    feature: Feature,
) -> Vec<[f64; 2]> {
    kind.places()
        .into_iter()
        .enumerate()
        .map(|(i, x)| [x, kind.mean(cases, order, i, feature)])
        .collect()
}

/// For each order and goal, the share of poses that have reached it.
fn shares(cases: &[Measurement], kind: Kind) -> Vec<Vec<[f64; 2]>> {
    let features = [HIGH_IS_NEAR, PROVEN];
    kind.curves()
        .flat_map(|curve| features.map(|feature| line(cases, kind, curve.0, feature)))
        .collect()
}

/// These shares.
fn near(cases: &[Measurement], title: &str, kind: Kind) -> Chart {
    let lines = shares(cases, kind);
    let (x, peers) = kind.axis(cases, &lines, 1.0);
    let names = kind.curves().flat_map(|(_, color, name)| {
        [
            (format!("{name}: upper bound"), color, true),
            (format!("{name}: both bounds"), color, false),
        ]
    });
    // Who is told the answer has the upper bound at once.
    let shown = names
        .zip(lines)
        .filter(|((name, ..), _)| *name != format!("{}: upper bound", label(TOLD)));
    let series = shown.map(|((name, color, dashed), points)| {
        Series::new(
            name,
            color,
            if dashed {
                Shape::Dashed(points)
            } else {
                Shape::Line(points)
            },
        )
    });
    Chart {
        title: title.to_owned(),
        x,
        y: Axis::linear("share of the poses").range(0.0..1.0),
        series: series.chain(peers).collect(),
    }
}

/// The plots of all cases, or of one, whose name is added to the titles.
pub(super) fn charts(cases: &[Measurement], of: &str) -> [(&'static str, Chart); 4] {
    [
        (
            "distance",
            bounds(
                cases,
                &format!("Bounds of the distance, over work{of}"),
                Kind::Work,
            ),
        ),
        (
            "distance-near",
            near(
                cases,
                &format!("Known within 10 %, over work{of}"),
                Kind::Work,
            ),
        ),
        (
            "distance-time",
            bounds(
                cases,
                &format!("Bounds of the distance, over time{of}"),
                Kind::Time,
            ),
        ),
        (
            "distance-near-time",
            near(
                cases,
                &format!("Known within 10 %, over time{of}"),
                Kind::Time,
            ),
        ),
    ]
}

pub(super) fn has_any(case: &Measurement) -> bool {
    !case.distance.runs.is_empty()
}

impl Report<'_> {
    pub(super) fn distance(&self) -> Result<Section, Failure> {
        let goals = GOALS.map(|(goal, name)| {
            let words = ORDERS.map(|order| {
                let (mean, Worst { case, value }) = reached_over_cases(self.cases, order, goal);
                format!(
                    "{} {} (worst case {}, {case})",
                    label(order),
                    number(mean),
                    number(value)
                )
            });
            format!("{name}: {}", words.join("; "))
        });
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
        Ok(Section {
            id: "distance".into(),
            title: "How far apart are they?".into(),
            lead: Lead::Shows(
                "Whenever a distance query stops, it says between which bounds the distance lies: no two points are closer than \
                 the lower bound, two named points are as close as the upper one. Shown is how soon they close in, at the poses at \
                 which the meshes are apart."
                    .into(),
            ),
            measured: format!(
                "Share of the work of a finished depth-first query with which the median pose of a case has its {}. Means over \
                 cases.",
                goals.join(". Its ")
            ),
            blocks,
        })
    }

    /// For each case the work with which the median pose reaches each goal.
    fn goals(&self) -> Table {
        let header = GOALS
            .iter()
            .flat_map(|(_, name)| ORDERS.map(|order| format!("{name}: {}", label(order))));
        let columns: Vec<BTreeMap<&str, f64>> = GOALS
            .iter()
            .flat_map(|(goal, _)| ORDERS.map(|order| reached(self.cases, order, *goal).collect()))
            .collect();
        let row = |case: &Measurement| {
            let cells = columns
                .iter()
                .map(|column| number(column.get(&*case.name).copied().unwrap_or(f64::NAN)));
            let poses = case.distance.runs.len() / ORDERS.len();
            [case.name.clone(), poses.to_string()]
                .into_iter()
                .chain(cells)
                .collect()
        };
        Table {
            header: ["share of the work", "poses apart"]
                .map(str::to_owned)
                .into_iter()
                .chain(header)
                .collect(),
            rows: self
                .cases
                .iter()
                .filter(|case| has_any(case))
                .map(row)
                .collect(),
        }
    }

    /// What finished queries take, and those of other libraries.
    fn finished(&self) -> Table {
        let peers: Vec<&String> = peers(self.cases).into_keys().collect();
        let header = std::iter::once("finished distance query, us: mean / slowest pose".to_owned());
        let row = |case: &Measurement| {
            let alone = std::slice::from_ref(case);
            let ours = ORDERS.map(|order| {
                [MEAN, LARGEST].map(|figure| {
                    Kind::Time
                        .whole(alone, order, figure)
                        .next()
                        .map(|(_, time)| 1e6 * time)
                })
            });
            let theirs = peers.iter().map(|name| {
                let times = case
                    .peers
                    .get(*name)
                    .map(|times| sorted(times.values().copied()));
                [MEAN, LARGEST].map(|figure| times.as_ref().map(|times| figure(times)))
            });
            let cells = ours
                .into_iter()
                .chain(theirs)
                .map(|both| both.map(|us| us.map_or("-".to_owned(), short)).join(" / "));
            std::iter::once(case.name.clone()).chain(cells).collect()
        };
        Table {
            header: header
                .chain(ORDERS.map(|order| label(order).to_owned()))
                .chain(peers.iter().map(|p| p.to_string()))
                .collect(),
            rows: self
                .cases
                .iter()
                .filter(|case| has_any(case))
                .map(row)
                .collect(),
        }
    }
}
