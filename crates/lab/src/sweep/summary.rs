//! From rows to figures: one tidy table, and the figures that releases are compared by.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::cell;
use crate::statistics::{mean, quantile, sorted};
use punctual::Pose;
use punctual::prediction::{MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK};

use super::case::Case;
use super::contender::{CERTIFIED, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE};
use super::distance::{ORDERS, OURS};
use super::measure::{Answer, Asked, Finished, Limit, Measured, Round, Row};
use super::plan::plan;
use super::punctuality::{Overrun, UNLIMITED};
use super::truth::Truth;

/// A case, measured.
pub struct Measurement {
    pub name: String,
    pub triangles: [usize; 2],
    /// Of each pose.
    pub strata: Vec<Stratum>,
    pub work: Measured,
    pub rounds: Vec<Round>,
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
        let [a, b] = case.boxes(pose);
        match truth.pairs.len() {
            0 if !a.intersects(&b) => Self::Apart,
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
    /// Whether a question was asked.
    pub fn has(&self, asked: Asked) -> bool {
        self.work.rows.iter().any(|row| row.asked == asked)
    }

    pub fn hits(&self) -> usize {
        let hits = self.strata.iter().filter(|stratum| stratum.collides());
        hits.count()
    }

    /// What differs from the truth, in words.
    pub fn complaints(&self) -> impl Iterator<Item = &String> {
        self.work.wrong.iter().chain(&self.work.loose)
    }

    /// Keeps the times at poses at which ours were measured too.
    pub fn take_peers(&mut self, mut peers: BTreeMap<String, BTreeMap<usize, f64>>) {
        let distances = self.work.rows.iter();
        let distances = distances.filter(|row| row.asked == Asked::Distance);
        let apart: BTreeSet<usize> = distances.map(|row| row.pose).collect();
        peers
            .values_mut()
            .for_each(|times| times.retain(|pose, _| apart.contains(pose)));
        peers.retain(|_, times| !times.is_empty());
        self.peers = peers;
    }

    /// The rows of budgets of work, and of all rounds together.
    fn rows(&self) -> impl Iterator<Item = &Row> {
        let timed = self.rounds.iter().flat_map(|round| &round.rows);
        self.work.rows.iter().chain(timed)
    }

    /// Of these, which ones: of intersections those at poses at which the meshes meet.
    pub fn picked(&self, which: Which) -> impl Iterator<Item = &Row> {
        self.rows()
            .filter(move |row| which.picks(row) && self.counts(row))
    }

    fn counts(&self, row: &Row) -> bool {
        row.asked == Asked::Distance || self.strata[row.pose].collides()
    }
}

/// Most work beyond a budget, of queries for intersections and for distances, and how much is allowed.
pub fn overruns(cases: &[Measurement]) -> [(u64, u64); 2] {
    let most = |i: usize| cases.iter().map(|case| case.work.overruns[i]).max();
    [
        (most(0).unwrap_or(0), MAX_STEP_WORK),
        (most(1).unwrap_or(0), MAX_DISTANCE_STEP_WORK),
    ]
}

/// What a row is asked for.
pub type Feature = fn(&Row) -> f64;

pub const DETECTED: Feature = |row| f64::from(row.verdict == Answer::Detected);
pub const UNDECIDED: Feature = |row| f64::from(row.verdict == Answer::Undecided);
pub const RECALL: Feature = |row| row.recall;
pub const COVERAGE: Feature = |row| row.coverage;
pub const LOW: Feature = |row| row.low;
pub const HIGH: Feature = |row| row.high;
pub const FINISHED: Feature = |row| f64::from(row.verdict == Answer::Separated);

/// By how much a bound of a distance may be off to count as near; 10 % where it is put in words.
const NEAR: f64 = 0.1;

pub const HIGH_IS_NEAR: Feature = |row| FINISHED(row).max(f64::from(row.high <= 1.0 + NEAR));
pub const PROVEN: Feature = |row| FINISHED(row).max(f64::from(row.high <= (1.0 + NEAR) * row.low));

/// What distance queries reach on the way to their end, in words.
pub const GOALS: [(&str, Feature); 2] = [
    ("upper bound within 10 % of the distance", HIGH_IS_NEAR),
    ("bounds within 10 % of each other", PROVEN),
];

/// Which rows: an order, a question and a budget.
#[derive(Clone, Copy)]
pub struct Which(pub &'static str, pub Asked, pub Limit);

impl Which {
    pub fn picks(&self, row: &Row) -> bool {
        (row.order, row.asked, row.budget) == (self.0, self.1, self.2)
    }
}

/// The mean of each case over its poses, with the case's name; not of those without such poses.
fn by_case(
    cases: &[Measurement],
    which: Which,
    feature: Feature,
) -> impl Iterator<Item = (&str, f64)> {
    let value = move |case: &Measurement| mean(case.picked(which).map(feature));
    cases
        .iter()
        .filter_map(move |case| Some((case.name.as_str(), value(case)?)))
}

/// Mean over cases, which count alike, of the means over their poses.
pub fn over_cases(cases: &[Measurement], which: Which, feature: Feature) -> f64 {
    mean(by_case(cases, which, feature).map(|(_, value)| value)).unwrap_or(f64::NAN)
}

/// A feature of all poses of all cases, sorted.
pub fn spread(cases: &[Measurement], which: Which, feature: Feature) -> Vec<f64> {
    sorted(
        cases
            .iter()
            .flat_map(|case| case.picked(which))
            .map(feature),
    )
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
    let which = Which(order, Asked::All, Limit::Work(percent));
    cases.iter().filter_map(move |case| {
        let rows = case.work.rows.iter().filter(|row| which.picks(row));
        let values = sorted(rows.map(|row| row.volume_left));
        (!values.is_empty()).then(|| (case.name.as_str(), quantile(&values, 0.5)))
    })
}

/// Share of the recall that is known on average while the work of a finished run is done: the area under the curve.
pub fn area(cases: &[Measurement], order: &'static str) -> f64 {
    let at = |percent| {
        let which = Which(order, Asked::All, Limit::Work(percent));
        [f64::from(percent) / 100.0, over_cases(cases, which, RECALL)]
    };
    let points: Vec<[f64; 2]> = std::iter::once([0.0, 0.0])
        .chain(plan().percent().map(at))
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
    cost: fn(&Finished) -> f64,
) -> Option<f64> {
    let log = |order: &str| {
        let runs = case.work.finished.iter().filter(|run| {
            run.order == order && run.asked == Asked::Any && case.strata[run.pose].collides()
        });
        mean(runs.map(|run| cost(run).max(1.0).ln()))
    };
    Some((log(DEPTH_FIRST)? - log(order)?).exp())
}

pub const WORK: fn(&Finished) -> f64 = |run| run.cost;
pub const BV_TESTS: fn(&Finished) -> f64 = |run| run.bv_tests;

fn geometric_mean(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(f64::ln)).map_or(f64::NAN, f64::exp)
}

/// Geometric mean of it over cases.
pub fn first_hit(cases: &[Measurement], order: &str, cost: fn(&Finished) -> f64) -> f64 {
    let gains = cases.iter();
    geometric_mean(gains.filter_map(|case| first_hit_of_case(case, order, cost)))
}

/// Mean cost of finished queries.
fn mean_cost(finished: &[Finished], order: &str, asked: Asked) -> Option<f64> {
    let runs = finished.iter();
    let runs = runs.filter(|run| run.order == order && run.asked == asked);
    mean(runs.map(|run| run.cost))
}

/// Geometric mean over cases of the mean time of a finished query, in microseconds.
pub fn finished_time(cases: &[Measurement], order: &str, asked: Asked, round: usize) -> f64 {
    let rounds = cases.iter().filter_map(|case| case.rounds.get(round));
    let times = rounds.filter_map(|round| mean_cost(&round.finished, order, asked));
    geometric_mean(times.map(|seconds| 1e6 * seconds))
}

/// The share of the work of a finished depth-first distance query with which the median pose of a case reaches a goal.
pub fn reached<'m>(
    cases: &'m [Measurement],
    order: &'static str,
    goal: usize,
) -> impl Iterator<Item = (&'m str, f64)> {
    cases.iter().filter_map(move |case| {
        let of_order = case.work.reached.iter().filter(|run| run.0 == order);
        let values = sorted(of_order.map(|run| run.1[goal]));
        (!values.is_empty()).then(|| (&*case.name, quantile(&values, 0.5)))
    })
}

/// Mean over cases, and the worst.
pub fn reached_over_cases<'m>(
    cases: &'m [Measurement],
    order: &'static str,
    goal: usize,
) -> (f64, Worst<'m>) {
    let mean = mean(reached(cases, order, goal).map(|(_, share)| share)).unwrap_or(f64::NAN);
    (mean, Worst::largest(reached(cases, order, goal)))
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

/// Figures of intersections, each at every budget: the question, and the feature.
const FIGURES: [(&str, Asked, Feature); 4] = [
    ("any", Asked::Any, DETECTED),
    ("undecided", Asked::Any, UNDECIDED),
    ("recall", Asked::All, RECALL),
    ("coverage", Asked::All, COVERAGE),
];

/// The figures of budgets of work: the same bits in every run.
pub fn work_figures(cases: &[Measurement]) -> BTreeMap<String, f64> {
    let mut figures = BTreeMap::new();
    let mut put = |name: String, value: f64| {
        figures.insert(name, value);
    };
    for order in plan().names() {
        for percent in plan().percent() {
            for (name, asked, feature) in FIGURES {
                let which = Which(order, asked, Limit::Work(percent));
                let value = over_cases(cases, which, feature);
                put(format!("{name}@{percent}% {order}"), value);
            }
        }
        put(format!("area under recall {order}"), area(cases, order));
        let regret = area(cases, ORACLE) - area(cases, order);
        put(format!("regret to oracle {order}"), regret);
        for (name, cost) in [("work", WORK), ("bv tests", BV_TESTS)] {
            if order != CUT_OFF {
                let gain = first_hit(cases, order, cost);
                put(format!("first hit over depth-first {order} {name}"), gain);
            }
        }
    }
    for order in CERTIFIED {
        for percent in plan().percent() {
            let left = mean(volume_left(cases, order, percent).map(|(_, left)| left));
            let left = left.unwrap_or(f64::NAN);
            put(format!("volume left@{percent}% {order}"), left);
        }
    }
    for (name, asked, percent, feature) in [
        ("any@5%", Asked::Any, 5, DETECTED),
        ("recall@20%", Asked::All, 20, RECALL),
        ("coverage@20%", Asked::All, 20, COVERAGE),
    ] {
        let which = Which(DEFAULT, asked, Limit::Work(percent));
        for (case, value) in by_case(cases, which, feature) {
            put(format!("{name} {DEFAULT} {case}"), value);
        }
    }
    super::confidence::figures(cases, &mut put);
    for order in ORDERS {
        for (goal, (name, _)) in GOALS.into_iter().enumerate() {
            let (mean, worst) = reached_over_cases(cases, order, goal);
            put(format!("{name}: work {order}"), mean);
            put(format!("{name}: work {order} worst case"), worst.value);
            for (case, share) in reached(cases, order, goal).filter(|_| order == OURS) {
                put(format!("{name}: work {order} {case}"), share);
            }
        }
        let costs = cases.iter().map(|case| &case.work.finished);
        let costs = costs.filter_map(|runs| mean_cost(runs, order, Asked::Distance));
        put(
            format!("finished distance: work {order}"),
            geometric_mean(costs),
        );
    }
    let sum = |count: fn(&Measured) -> usize| {
        let counts = cases.iter().map(|case| count(&case.work));
        counts.sum::<usize>() as f64
    };
    put("wrong".to_owned(), sum(|work| work.wrong.len()));
    put(
        "false certificates".to_owned(),
        sum(|work| work.loose.len()),
    );
    let [(overrun, _), (of_distances, _)] = overruns(cases);
    put("overrun max work".to_owned(), overrun as f64);
    put("overrun max work distance".to_owned(), of_distances as f64);
    figures
}

/// The figures of time, each with its noise.
pub fn time_figures(cases: &[Measurement]) -> BTreeMap<String, Figure> {
    let mut figures = BTreeMap::new();
    let rounds = rounds(cases);
    let mut put = |name: String, value: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..rounds).map(value).collect();
        figures.insert(name, Figure::of_rounds(&values));
    };
    for order in plan().timed_names().chain([CUT_OFF]) {
        for limit in plan().times() {
            for (name, asked, feature) in [
                ("any", Asked::Any, DETECTED),
                ("recall", Asked::All, RECALL),
            ] {
                let which = Which(order, asked, Limit::Time(limit));
                let of_case = |case: &Measurement, round: usize| {
                    let rows = case.rounds[round].rows.iter();
                    mean(
                        rows.filter(|row| which.picks(row) && case.counts(row))
                            .map(feature),
                    )
                };
                let us = limit.as_micros();
                put(format!("{name}@{us}us {order}"), &|round| {
                    mean(cases.iter().filter_map(|case| of_case(case, round))).unwrap_or(f64::NAN)
                });
            }
        }
    }
    for order in plan().timed_names().chain([UNLIMITED]) {
        for (name, asked) in [("any", Asked::Any), ("all", Asked::All)] {
            put(format!("finished {name} us {order}"), &|round| {
                finished_time(cases, order, asked, round)
            });
        }
    }
    for (name, fraction) in QUANTILES {
        for (clock, overrun) in CLOCKS {
            put(format!("overrun {name} us {clock}"), &|round| {
                let overruns = cases.iter().flat_map(|case| &case.rounds[round].overruns);
                1e6 * quantile(&sorted(overruns.map(overrun)), fraction)
            });
        }
    }
    figures
}

/// Rounds of all cases.
pub fn rounds(cases: &[Measurement]) -> usize {
    let rounds = cases.iter().map(|case| case.rounds.len());
    rounds.min().unwrap_or(0)
}

type Reading = fn(&Overrun) -> f64;

pub const CLOCKS: [(&str, Reading); 3] = [
    ("wall", |overrun| overrun.wall),
    ("cpu", |overrun| overrun.cpu),
    ("spin", |overrun| overrun.spin),
];

/// A budget as the tables have it.
fn budget(limit: Limit) -> [String; 2] {
    match limit {
        Limit::Work(percent) => ["work_percent".to_owned(), percent.to_string()],
        Limit::Time(time) => ["time_us".to_owned(), time.as_micros().to_string()],
    }
}

fn numbers<const N: usize>(numbers: [f64; N]) -> [String; N] {
    numbers.map(|number| cell(number, 6))
}

pub const HEADER: &str = "case,stratum,order,mode,budget_kind,budget,poses,detected,undecided,wrong,recall_mean,recall_p5,\
     recall_p50,recall_p95,coverage_mean,coverage_p5,coverage_p50,coverage_p95,unresolved_p50,unresolved_p95";

/// The tidy table of intersections: a line for each case, stratum, order, mode and budget.
pub fn table(case: &Measurement) -> Vec<Vec<String>> {
    let mut groups = BTreeMap::<_, Vec<&Row>>::new();
    for row in case.rows().filter(|row| row.asked != Asked::Distance) {
        for stratum in [None, Some(case.strata[row.pose])] {
            let key = (stratum, row.order, row.asked, row.budget);
            groups.entry(key).or_default().push(row);
        }
    }
    let mut lines = Vec::new();
    for ((stratum, order, asked, limit), rows) in groups {
        let values = |feature: Feature| rows.iter().map(move |row| feature(row));
        let mean = |feature: Feature| mean(values(feature)).unwrap_or(f64::NAN);
        let mut fields = vec![
            case.name.clone(),
            stratum.map_or("every", Stratum::name).to_owned(),
            order.to_owned(),
            format!("{asked:?}").to_lowercase(),
        ];
        fields.extend(budget(limit));
        fields.push(rows.len().to_string());
        let wrong: Feature = |row| f64::from(row.verdict == Answer::Wrong);
        fields.extend(numbers([DETECTED, UNDECIDED, wrong].map(mean)));
        for feature in [RECALL, COVERAGE] {
            let sorted = sorted(values(feature));
            let spread = [0.05, 0.5, 0.95].map(|fraction| quantile(&sorted, fraction));
            fields.extend(numbers([mean(feature)]).into_iter().chain(numbers(spread)));
        }
        let unresolved = sorted(values(|row| row.unresolved));
        fields.extend(numbers(
            [0.5, 0.95].map(|fraction| quantile(&unresolved, fraction)),
        ));
        lines.push(fields);
    }
    lines
}

pub const DISTANCE_HEADER: &str =
    "case,order,budget_kind,budget,poses,low_p10,low_p50,high_p50,high_p90,high_near,proven";

/// The tidy table of distances: a line for each case, order and budget, bounds over the true distance.
pub fn distance_table(case: &Measurement) -> Vec<Vec<String>> {
    let alone = std::slice::from_ref(case);
    let mut lines = Vec::new();
    for order in ORDERS.into_iter().filter(|_| case.has(Asked::Distance)) {
        let works = plan().percent().map(Limit::Work);
        for limit in works.chain(plan().times().map(Limit::Time)) {
            let which = Which(order, Asked::Distance, limit);
            let [low, high] = [LOW, HIGH].map(|feature| spread(alone, which, feature));
            let [near, proven] =
                [HIGH_IS_NEAR, PROVEN].map(|feature| over_cases(alone, which, feature));
            let mut fields = vec![case.name.clone(), order.to_owned()];
            fields.extend(budget(limit));
            fields.push(low.len().to_string());
            fields.extend(numbers([
                quantile(&low, 0.1),
                quantile(&low, 0.5),
                quantile(&high, 0.5),
                quantile(&high, 0.9),
                near,
                proven,
            ]));
            lines.push(fields);
        }
    }
    lines
}
