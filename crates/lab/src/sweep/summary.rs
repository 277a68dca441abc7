//! From rows to figures: one tidy table, and the figures that releases are compared by.

use std::collections::{BTreeMap, BTreeSet};

use crate::statistics::{mean, quantile, sorted};
use punctual::prediction::{MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK};
use punctual::{Mode, Pose};

use super::case::Case;
use super::contender::{CERTIFIED, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE};
use super::distance;
use super::measure::{Answer, Finished, Limit, Measured, Row};
use super::plan::plan;
use super::punctuality::{Round, UNLIMITED};
use super::truth::Truth;

/// A case, measured.
pub struct Measurement {
    pub name: String,
    pub triangles: [usize; 2],
    /// Of each pose.
    pub strata: Vec<Stratum>,
    pub work: Measured,
    pub rounds: Vec<Round>,
    pub distance: distance::Measured,
    /// Microseconds of other libraries' distance queries at each pose.
    pub peers: BTreeMap<String, BTreeMap<usize, f64>>,
}

/// How hard a pose is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Stratum {
    /// The boxes of the meshes are apart.
    Apart,
    /// The boxes meet and the meshes do not.
    NearMiss,
    /// At most 10 pairs of triangles intersect.
    Grazing,
    /// At most 100.
    Shallow,
    Deep,
}

impl Stratum {
    pub const ALL: [Self; 5] = [
        Self::Apart,
        Self::NearMiss,
        Self::Grazing,
        Self::Shallow,
        Self::Deep,
    ];

    pub fn of(case: &Case, pose: &Pose, truth: &Truth) -> Self {
        match truth.pairs.len() {
            0 if case.boxes_apart(pose) => Self::Apart,
            0 => Self::NearMiss,
            1..=10 => Self::Grazing,
            11..=100 => Self::Shallow,
            _ => Self::Deep,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Apart => "boxes apart",
            Self::NearMiss => "near miss",
            Self::Grazing => "1-10 pairs",
            Self::Shallow => "11-100 pairs",
            Self::Deep => "over 100 pairs",
        }
    }

    pub fn collides(self) -> bool {
        self >= Self::Grazing
    }
}

impl Measurement {
    pub fn collides(&self, row: &Row) -> bool {
        self.strata[row.pose].collides()
    }

    pub fn hits(&self) -> usize {
        self.strata
            .iter()
            .filter(|stratum| stratum.collides())
            .count()
    }

    /// What differs from the truth, in words.
    pub fn complaints(&self) -> impl Iterator<Item = &String> {
        self.work
            .wrong
            .iter()
            .chain(&self.work.loose)
            .chain(&self.distance.wrong)
    }

    /// Keeps the times at poses at which ours were measured too.
    pub fn take_peers(&mut self, mut peers: BTreeMap<String, BTreeMap<usize, f64>>) {
        let apart: BTreeSet<usize> = self.distance.runs.iter().map(|run| run.pose).collect();
        peers
            .values_mut()
            .for_each(|times| times.retain(|pose, _| apart.contains(pose)));
        peers.retain(|_, times| !times.is_empty());
        self.peers = peers;
    }

    fn rows(&self) -> impl Iterator<Item = &Row> {
        self.work
            .rows
            .iter()
            .chain(self.rounds.iter().flat_map(|round| &round.rows))
    }
}

/// Most work beyond a budget, of queries for intersections and for distances, and how much is allowed.
pub fn overruns(cases: &[Measurement]) -> [(u64, u64); 2] {
    let most = |overrun: fn(&Measurement) -> u64| cases.iter().map(overrun).max().unwrap_or(0);
    [
        (most(|case| case.work.overrun), MAX_STEP_WORK),
        (most(|case| case.distance.overrun), MAX_DISTANCE_STEP_WORK),
    ]
}

/// What a row is asked for.
pub type Feature = fn(&Row) -> f64;

pub const DETECTED: Feature = |row| f64::from(u8::from(row.verdict == Answer::Detected));
pub const UNDECIDED: Feature = |row| f64::from(u8::from(row.verdict == Answer::Undecided));
pub const RECALL: Feature = |row| row.recall;
pub const COVERAGE: Feature = |row| row.coverage;

/// Which rows: an order, a mode and a budget, of colliding poses.
#[derive(Clone, Copy)]
pub struct Which {
    pub order: &'static str,
    pub mode: Mode,
    pub budget: Limit,
}

impl Which {
    pub fn picks(&self, row: &Row) -> bool {
        row.order == self.order && row.mode == self.mode && row.budget == self.budget
    }
}

/// Mean of a case over its colliding poses.
pub fn of_case<'r>(
    case: &Measurement,
    rows: impl Iterator<Item = &'r Row>,
    which: Which,
    feature: Feature,
) -> Option<f64> {
    mean(
        rows.filter(|row| which.picks(row) && case.collides(row))
            .map(feature),
    )
}

/// The same for each case that has colliding poses, with the case's name.
fn by_case(
    cases: &[Measurement],
    which: Which,
    feature: Feature,
) -> impl Iterator<Item = (&str, f64)> {
    let value = move |case: &Measurement| match which.budget {
        Limit::Work(_) => of_case(case, case.work.rows.iter(), which, feature),
        Limit::Time(_) => of_case(
            case,
            case.rounds.iter().flat_map(|round| &round.rows),
            which,
            feature,
        ),
    };
    cases
        .iter()
        .filter_map(move |case| Some((case.name.as_str(), value(case)?)))
}

/// Mean over cases, which count alike, of the means over their colliding poses.
pub fn over_cases(cases: &[Measurement], which: Which, feature: Feature) -> f64 {
    mean(by_case(cases, which, feature).map(|(_, value)| value)).unwrap_or(f64::NAN)
}

/// The case with the least mean, and that.
pub fn worst_case(cases: &[Measurement], which: Which, feature: Feature) -> Worst<'_> {
    Worst::least(by_case(cases, which, feature))
}

/// A case, and how bad it is.
#[derive(Clone, Copy)]
pub struct Worst<'m> {
    pub case: &'m str,
    pub value: f64,
}

impl<'m> Worst<'m> {
    pub fn least(values: impl Iterator<Item = (&'m str, f64)>) -> Self {
        let none = Self {
            case: "none",
            value: f64::NAN,
        };
        values
            .min_by(|x, y| x.1.total_cmp(&y.1))
            .map_or(none, |(case, value)| Self { case, value })
    }

    pub fn largest(values: impl Iterator<Item = (&'m str, f64)>) -> Self {
        let least = Self::least(values.map(|(case, value)| (case, -value)));
        Self {
            value: -least.value,
            ..least
        }
    }
}

/// Median, over the poses of each case at which the boxes of the meshes overlap, of the volume left by a query that looks
/// for all pairs; with the case's name.
pub fn volume_left<'m>(
    cases: &'m [Measurement],
    order: &'static str,
    percent: u32,
) -> impl Iterator<Item = (&'m str, f64)> {
    let which = Which {
        order,
        mode: Mode::All,
        budget: Limit::Work(percent),
    };
    cases.iter().filter_map(move |case| {
        let rows = case
            .work
            .rows
            .iter()
            .filter(|row| which.picks(row) && !row.volume_left.is_nan());
        let values = sorted(rows.map(|row| row.volume_left));
        (!values.is_empty()).then(|| (case.name.as_str(), quantile(&values, 0.5)))
    })
}

/// Share of the recall that is known on average while the work of a finished run is done: the area under the curve.
pub fn area(cases: &[Measurement], order: &'static str) -> f64 {
    let at = |percent| {
        over_cases(
            cases,
            Which {
                order,
                mode: Mode::All,
                budget: Limit::Work(percent),
            },
            RECALL,
        )
    };
    let points: Vec<[f64; 2]> = std::iter::once([0.0, 0.0])
        .chain(
            plan()
                .percent()
                .map(|percent| [f64::from(percent) / 100.0, at(percent)]),
        )
        .collect();
    points
        .windows(2)
        .map(|ends| (ends[1][0] - ends[0][0]) * (ends[0][1] + ends[1][1]) * 0.5)
        .sum()
}

/// How much less a case takes to the first hit than depth-first, in work or in BV tests: geometric mean over its colliding
/// poses.
pub fn first_hit_of_case(
    case: &Measurement,
    order: &str,
    cost: fn(&Finished) -> u64,
) -> Option<f64> {
    let log = |order: &str| {
        let runs = case
            .work
            .finished
            .iter()
            .filter(|run| run.order == order && run.mode == Mode::Any);
        let runs = runs.filter(|run| case.strata[run.pose].collides());
        mean(runs.map(|run| (cost(run).max(1) as f64).ln()))
    };
    Some((log(DEPTH_FIRST)? - log(order)?).exp())
}

pub const WORK: fn(&Finished) -> u64 = |run| run.work;
pub const BV_TESTS: fn(&Finished) -> u64 = |run| run.bv_tests;

/// Geometric mean of it over cases.
pub fn first_hit(cases: &[Measurement], order: &str, cost: fn(&Finished) -> u64) -> f64 {
    let gains = cases
        .iter()
        .filter_map(|case| first_hit_of_case(case, order, cost));
    mean(gains.map(f64::ln)).map_or(f64::NAN, f64::exp)
}

/// Geometric mean over cases of the mean time of a finished query, in microseconds.
pub fn finished_time(cases: &[Measurement], order: &str, mode: Mode, round: usize) -> f64 {
    let time = |case: &Measurement| {
        let times = case
            .rounds
            .get(round)?
            .finished
            .iter()
            .filter(|time| time.order == order && time.mode == mode);
        Some((mean(times.map(|time| time.seconds))? * 1e6).ln())
    };
    mean(cases.iter().filter_map(time)).map_or(f64::NAN, f64::exp)
}

pub const QUANTILES: [(&str, f64); 5] = [
    ("p50", 0.5),
    ("p90", 0.9),
    ("p99", 0.99),
    ("p99.9", 0.999),
    ("max", 1.0),
];

/// A figure that varies from round to round, by about `noise` either way.
#[derive(Clone, Copy)]
pub struct Figure {
    pub value: f64,
    pub noise: f64,
}

impl Figure {
    fn of_rounds(values: &[f64]) -> Self {
        let sorted = sorted(values.iter().copied());
        let (low, high) = (quantile(&sorted, 0.0), quantile(&sorted, 1.0));
        Self {
            value: quantile(&sorted, 0.5),
            noise: high - low,
        }
    }
}

/// The figures of budgets of work: the same bits in every run.
pub fn work_figures(cases: &[Measurement]) -> BTreeMap<String, f64> {
    let mut figures = BTreeMap::new();
    let mut put = |name: String, value: f64| figures.insert(name, value);
    for order in plan().names() {
        for percent in plan().percent() {
            let budget = Limit::Work(percent);
            let any = Which {
                order,
                mode: Mode::Any,
                budget,
            };
            let all = Which {
                order,
                mode: Mode::All,
                budget,
            };
            put(
                format!("any@{percent}% {order}"),
                over_cases(cases, any, DETECTED),
            );
            put(
                format!("undecided@{percent}% {order}"),
                over_cases(cases, any, UNDECIDED),
            );
            put(
                format!("recall@{percent}% {order}"),
                over_cases(cases, all, RECALL),
            );
            put(
                format!("coverage@{percent}% {order}"),
                over_cases(cases, all, COVERAGE),
            );
        }
        put(format!("area under recall {order}"), area(cases, order));
        put(
            format!("regret to oracle {order}"),
            area(cases, ORACLE) - area(cases, order),
        );
        if order != CUT_OFF {
            put(
                format!("first hit over depth-first {order} work"),
                first_hit(cases, order, WORK),
            );
            put(
                format!("first hit over depth-first {order} bv tests"),
                first_hit(cases, order, BV_TESTS),
            );
        }
    }
    for order in CERTIFIED {
        for percent in plan().percent() {
            let left = mean(volume_left(cases, order, percent).map(|(_, left)| left));
            put(
                format!("volume left@{percent}% {order}"),
                left.unwrap_or(f64::NAN),
            );
        }
    }
    for case in cases {
        for (name, mode, percent, feature) in [
            ("any@5%", Mode::Any, 5, DETECTED),
            ("recall@20%", Mode::All, 20, RECALL),
            ("coverage@20%", Mode::All, 20, COVERAGE),
        ] {
            let which = Which {
                order: DEFAULT,
                mode,
                budget: Limit::Work(percent),
            };
            if let Some(value) = of_case(case, case.work.rows.iter(), which, feature) {
                put(format!("{name} {DEFAULT} {}", case.name), value);
            }
        }
    }
    super::confidence::figures(cases, &mut figures);
    distance::summary::work_figures(cases, &mut figures);
    let mut put = |name: String, value: f64| figures.insert(name, value);
    let wrong: usize = cases
        .iter()
        .map(|case| case.work.wrong.len() + case.distance.wrong.len())
        .sum();
    put("wrong".to_owned(), wrong as f64);
    let loose: usize = cases.iter().map(|case| case.work.loose.len()).sum();
    put("false certificates".to_owned(), loose as f64);
    for (name, (overrun, _)) in ["overrun max work", "overrun max work distance"]
        .into_iter()
        .zip(overruns(cases))
    {
        put(name.to_owned(), overrun as f64);
    }
    figures
}

/// The figures of time, each with its noise.
pub fn time_figures(cases: &[Measurement]) -> BTreeMap<String, Figure> {
    let mut figures = BTreeMap::new();
    let rounds = cases
        .iter()
        .map(|case| case.rounds.len())
        .min()
        .unwrap_or(0);
    let mut put = |name: String, value: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..rounds).map(value).collect();
        figures.insert(name, Figure::of_rounds(&values));
    };
    let share = |which: Which, feature: Feature, round: usize| {
        let of_round =
            |case: &Measurement| of_case(case, case.rounds[round].rows.iter(), which, feature);
        mean(cases.iter().filter_map(of_round)).unwrap_or(f64::NAN)
    };
    for order in plan()
        .contenders()
        .map(|contender| contender.name)
        .chain([CUT_OFF])
    {
        for &us in plan().microseconds() {
            let budget = Limit::Time(std::time::Duration::from_micros(us));
            put(format!("any@{us}us {order}"), &|r| {
                share(
                    Which {
                        order,
                        mode: Mode::Any,
                        budget,
                    },
                    DETECTED,
                    r,
                )
            });
            put(format!("recall@{us}us {order}"), &|r| {
                share(
                    Which {
                        order,
                        mode: Mode::All,
                        budget,
                    },
                    RECALL,
                    r,
                )
            });
        }
    }
    for order in plan()
        .contenders()
        .map(|contender| contender.name)
        .chain([UNLIMITED])
    {
        for (name, mode) in [("any", Mode::Any), ("all", Mode::All)] {
            put(format!("finished {name} us {order}"), &|round| {
                finished_time(cases, order, mode, round)
            });
        }
    }
    for (name, fraction) in QUANTILES {
        for (clock, overrun) in CLOCKS {
            let of_round = |round: usize| {
                let overruns = cases.iter().flat_map(|case| &case.rounds[round].overruns);
                1e6 * quantile(&sorted(overruns.map(overrun)), fraction)
            };
            put(format!("overrun {name} us {clock}"), &of_round);
        }
    }
    figures
}

type Reading = fn(&super::punctuality::Overrun) -> f64;

pub const CLOCKS: [(&str, Reading); 3] = [
    ("wall", |overrun| overrun.wall),
    ("cpu", |overrun| overrun.cpu),
    ("spin", |overrun| overrun.spin),
];

pub const HEADER: &str = "case,stratum,order,mode,budget_kind,budget,poses,detected,undecided,wrong,recall_mean,recall_p5,\
     recall_p50,recall_p95,coverage_mean,coverage_p5,coverage_p50,coverage_p95,unresolved_p50,unresolved_p95";

/// The tidy table: a line for each case, stratum, order, mode and budget.
pub fn table(case: &Measurement) -> Vec<Vec<String>> {
    let mut groups = BTreeMap::<_, Vec<&Row>>::new();
    for row in case.rows() {
        let stratum = case.strata[row.pose];
        for stratum in [None, Some(stratum)] {
            let key = (stratum, row.order, row.mode == Mode::All, row.budget);
            groups.entry(key).or_default().push(row);
        }
    }
    let line = |((stratum, order, all, budget), rows): (
        (Option<Stratum>, &str, bool, Limit),
        Vec<&Row>,
    )| {
        let (kind, amount) = match budget {
            Limit::Work(percent) => ("work_percent", f64::from(percent)),
            Limit::Time(time) => ("time_us", time.as_secs_f64() * 1e6),
        };
        let share = |answer: Answer| {
            rows.iter().filter(|row| row.verdict == answer).count() as f64 / rows.len() as f64
        };
        let spread = |feature: Feature, fractions: &[f64]| {
            let values = sorted(rows.iter().map(|row| feature(row)));
            fractions
                .iter()
                .map(|&fraction| cell(quantile(&values, fraction)))
                .collect::<Vec<_>>()
        };
        let mut fields = vec![
            case.name.clone(),
            stratum.map_or("every", Stratum::name).to_owned(),
            order.to_owned(),
            if all { "all" } else { "any" }.to_owned(),
            kind.to_owned(),
            cell(amount),
            rows.len().to_string(),
        ];
        fields.extend(
            [Answer::Detected, Answer::Undecided, Answer::Wrong].map(|answer| cell(share(answer))),
        );
        for feature in [RECALL, COVERAGE] {
            fields.push(cell(
                mean(rows.iter().map(|row| feature(row))).unwrap_or(f64::NAN),
            ));
            fields.extend(spread(feature, &[0.05, 0.5, 0.95]));
        }
        fields.extend(spread(|row| row.unresolved, &[0.5, 0.95]));
        fields
    };
    groups.into_iter().map(line).collect()
}

/// A number in the table; empty where there is none.
pub fn cell(value: f64) -> String {
    if value.is_nan() {
        String::new()
    } else {
        format!("{:.6}", value)
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned()
    }
}
