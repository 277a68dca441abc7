//! From stops of distance queries to figures.

use std::collections::BTreeMap;

use crate::statistics::{mean, quantile, sorted};

use super::super::plan::plan;
use super::super::summary::{Measurement, Worst, cell};
use super::{ORDERS, OURS, Run, Stop};

/// What a stop is asked for.
pub type Feature = fn(&Stop) -> f64;

pub const LOW: Feature = |stop| stop.low;
pub const HIGH: Feature = |stop| stop.high;
pub const HIGH_IS_NEAR: Feature = |stop| f64::from(u8::from(stop.is_high_near()));
pub const PROVEN: Feature = |stop| f64::from(u8::from(stop.is_proven()));
pub const FINISHED: Feature = |stop| f64::from(u8::from(stop.finished));

/// What is reached on the way to the end: its place in [`Run::reached`], and words for it.
pub const GOALS: [(usize, &str); 2] = [
    (0, "upper bound within 10 % of the distance"),
    (1, "bounds within 10 % of each other"),
];

/// The budgets at which stops are looked at: places in [`Run::stops`].
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Work,
    Time,
}

impl Kind {
    /// The runs of a case, of all rounds together.
    fn runs(self, case: &Measurement) -> impl Iterator<Item = &Run> {
        let rounds = case
            .distance
            .rounds
            .iter()
            .flatten()
            .filter(move |_| self == Self::Time);
        case.distance
            .runs
            .iter()
            .filter(move |_| self == Self::Work)
            .chain(rounds)
    }

    fn of_order<'m>(
        self,
        case: &'m Measurement,
        order: &'static str,
    ) -> impl Iterator<Item = &'m Run> {
        self.runs(case).filter(move |run| run.order == order)
    }

    /// A feature at the `i`-th budget, of all poses of all cases, sorted.
    pub fn spread(
        self,
        cases: &[Measurement],
        order: &'static str,
        i: usize,
        feature: Feature,
    ) -> Vec<f64> {
        let runs = cases.iter().flat_map(|case| self.of_order(case, order));
        sorted(runs.map(|run| feature(&run.stops[i])))
    }

    /// Its mean over cases, which count alike, of the means over their poses.
    pub fn mean(
        self,
        cases: &[Measurement],
        order: &'static str,
        i: usize,
        feature: Feature,
    ) -> f64 {
        let of_case = |case| mean(self.of_order(case, order).map(|run| feature(&run.stops[i])));
        mean(cases.iter().filter_map(of_case)).unwrap_or(f64::NAN)
    }

    /// What it takes to the end: of each case that has any, with its name, a figure of the sorted values of its poses.
    pub fn whole<'m>(
        self,
        cases: &'m [Measurement],
        order: &'static str,
        figure: fn(&[f64]) -> f64,
    ) -> impl Iterator<Item = (&'m str, f64)> {
        let of_case = move |case: &'m Measurement| {
            let mut least = BTreeMap::new();
            for run in self.of_order(case, order) {
                let time = least.entry(run.pose).or_insert(f64::INFINITY);
                *time = run.whole.min(*time);
            }
            let values = sorted(least.into_values());
            (!values.is_empty()).then(|| (&*case.name, figure(&values)))
        };
        cases.iter().filter_map(of_case)
    }
}

/// Mean and largest of sorted values.
pub const MEAN: fn(&[f64]) -> f64 = |values| mean(values.iter().copied()).unwrap_or(f64::NAN);
pub const LARGEST: fn(&[f64]) -> f64 = |values| quantile(values, 1.0);

/// The share of the work of a finished depth-first query with which the median pose of a case reaches a goal.
pub fn reached<'m>(
    cases: &'m [Measurement],
    order: &'static str,
    goal: usize,
) -> impl Iterator<Item = (&'m str, f64)> {
    cases.iter().filter_map(move |case| {
        let values = sorted(
            Kind::Work
                .of_order(case, order)
                .map(|run| run.reached[goal]),
        );
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

/// Figures for `punctual compare`: the same bits in every run.
pub fn work_figures(cases: &[Measurement], figures: &mut BTreeMap<String, f64>) {
    for order in ORDERS {
        for (goal, name) in GOALS {
            let (mean, worst) = reached_over_cases(cases, order, goal);
            figures.insert(format!("{name}: work {order}"), mean);
            figures.insert(format!("{name}: work {order} worst case"), worst.value);
            for (case, share) in reached(cases, order, goal).filter(|_| order == OURS) {
                figures.insert(format!("{name}: work {order} {case}"), share);
            }
        }
        let whole = Kind::Work
            .whole(cases, order, MEAN)
            .map(|(_, work)| work.ln());
        figures.insert(
            format!("finished distance: work {order}"),
            mean(whole).map_or(f64::NAN, f64::exp),
        );
    }
}

pub const HEADER: &str =
    "case,order,budget_kind,budget,poses,low_p10,low_p50,high_p50,high_p90,high_near,proven";

/// The tidy table: a line for each case, order and budget, bounds over the true distance.
pub fn table(case: &Measurement) -> Vec<Vec<String>> {
    if case.distance.runs.is_empty() {
        return Vec::new();
    }
    let alone = std::slice::from_ref(case);
    let works = plan().percent().map(|percent| {
        (
            Kind::Work,
            "work_percent",
            u64::from(percent),
            percent as usize - 1,
        )
    });
    let times = plan()
        .microseconds()
        .iter()
        .enumerate()
        .map(|(i, &us)| (Kind::Time, "time_us", us, i));
    let budgets: Vec<_> = works.chain(times).collect();
    let line = |order, (kind, name, budget, i): (Kind, &str, u64, usize)| {
        let [low, high] = [LOW, HIGH].map(|feature| kind.spread(alone, order, i, feature));
        let share = |feature| kind.mean(alone, order, i, feature);
        let numbers = [
            quantile(&low, 0.1),
            quantile(&low, 0.5),
            quantile(&high, 0.5),
            quantile(&high, 0.9),
            share(HIGH_IS_NEAR),
            share(PROVEN),
        ];
        let names = [
            case.name.clone(),
            order.to_owned(),
            name.to_owned(),
            budget.to_string(),
            low.len().to_string(),
        ];
        names.into_iter().chain(numbers.map(cell)).collect()
    };
    ORDERS
        .iter()
        .flat_map(|order| budgets.iter().map(move |budget| line(order, *budget)))
        .collect()
}
