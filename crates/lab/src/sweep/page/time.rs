//! What is known when a time is up, and how late that is: of this machine.

use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table, short};
use crate::statistics::{quantile, sorted};

use super::super::contender::{DEFAULT, ORACLE, label};
use super::super::measure::{Asked, Limit};
use super::super::plan::plan;
use super::super::punctuality::{Overrun, UNLIMITED};
use super::super::summary::{
    CLOCKS, DETECTED, Measurement, QUANTILES, RECALL, Worst, finished_time, rounds,
};
use super::{Kind, Report, by_budget, drawn, number};

/// Budgets in the tables, as many as fit on a page.
const SHOWN: usize = 8;

impl Report<'_> {
    pub(super) fn time(&self) -> Result<Section, Failure> {
        let mut blocks = vec![self.plot("overview", &self.overview())?];
        let step = plan().time_us.len().div_ceil(SHOWN);
        let budgets = plan().times().step_by(step);
        let budgets: Vec<_> = budgets
            .map(|time| (format!("{} us", time.as_micros()), Limit::Time(time)))
            .collect();
        for (id, title, asked, feature) in [
            (
                "any-time",
                "Contact detected within a time",
                Asked::Any,
                DETECTED,
            ),
            ("all-time", "Pairs found within a time", Asked::All, RECALL),
        ] {
            let chart = Kind::Time.chart(self.cases, title, asked, feature);
            blocks.push(self.plot(id, &chart)?);
            let orders = drawn().map(|curve| curve.order);
            blocks.push(Block::Table(by_budget(
                &format!("{title}: mean / worst case"),
                orders.filter(|order| *order != ORACLE),
                &budgets,
                self.mean_and_worst(asked, feature),
            )));
        }
        let time = |order: &str, asked| {
            let of_round = |round| finished_time(self.cases, order, asked, round);
            let times = sorted((0..rounds(self.cases)).map(of_round));
            quantile(&times, 0.0)
        };
        let header = ["finished query, microseconds", "first contact", "all pairs"];
        let row = |order| {
            let times = [Asked::Any, Asked::All].map(|asked| short(time(order, asked)));
            let name = label(order).to_owned();
            std::iter::once(name).chain(times).collect()
        };
        let orders = plan().timed_names().chain([UNLIMITED]);
        blocks.push(Block::Table(Table::new(header, orders.map(row).collect())));
        blocks.push(Block::Text(
            "A finished query: geometric mean over cases of the mean over poses, the best of the rounds. \"No budget\" is this \
             library without a budget, which goes depth-first."
                .into(),
        ));
        let [any, all] = [Asked::Any, Asked::All]
            .map(|asked| number(time(DEFAULT, asked) / time(UNLIMITED, asked)));
        Ok(Section::shows(
            "time",
            "What is known when the time is up?",
            "Share of the poses in contact at which the contact is known, of the pairs of triangles that meet which are \
             found (recall), and of the distances that are known to 10 %, after a time. A plain query that is cut off has \
             found all, or nothing that is known.",
            format!(
                "A query that could be stopped at any unit of work, but runs to its end, takes {any} (first contact) and \
                 {all} times (all pairs) as long as one without a budget."
            ),
            blocks,
        ))
    }

    pub(super) fn lateness(&self) -> Result<Section, Failure> {
        let section = |what, measured, blocks| {
            Section::shows(
                "late",
                "How late is a stopped query?",
                what,
                measured,
                blocks,
            )
        };
        let late = "How long after its deadline a query came back.";
        let values = CLOCKS.map(|(_, reading)| {
            let every = self.cases.iter().flat_map(overruns);
            sorted(every.map(|overrun| 1e6 * reading(overrun)))
        });
        if values[0].is_empty() {
            let measured = "No query was stopped by a deadline.".to_owned();
            return Ok(section(late.to_owned(), measured, vec![]));
        }
        let names = [
            "query, wall clock",
            "query, CPU time",
            "empty loop, wall clock",
        ];
        let header = std::iter::once("microseconds late").chain(QUANTILES.map(|(name, _)| name));
        let row = |(name, values): (&str, &Vec<f64>)| {
            let cells = QUANTILES.map(|(_, fraction)| number(quantile(values, fraction)));
            std::iter::once(name.to_owned()).chain(cells).collect()
        };
        let rows = names.into_iter().zip(&values).map(row).collect();
        let share = [
            0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999,
        ];
        let curve = |values: &Vec<f64>| {
            share
                .map(|share| [100.0 * (1.0 - share), quantile(values, share).max(0.01)])
                .to_vec()
        };
        let series = names.iter().zip(&values).enumerate();
        let chart = Chart {
            title: "How late, and how often".to_owned(),
            x: Axis::log("% of the stopped queries that are later"),
            y: Axis::log("microseconds late"),
            series: series
                .map(|(i, (name, values))| Series::new(*name, i, Shape::Line(curve(values))))
                .collect(),
        };
        let p99 = |case: &Measurement| {
            let late = sorted(overruns(case).map(|overrun| 1e6 * overrun.wall));
            quantile(&late, 0.99)
        };
        let timed = self.cases.iter();
        let timed = timed.filter(|case| overruns(case).next().is_some());
        let Worst { case, value } =
            Worst::largest(timed.map(|case| (case.name.as_str(), p99(case))));
        let [median, tail] = [0.5, 0.99].map(|fraction| quantile(&values[0], fraction));
        let measured = format!(
            "{} stops by a deadline. Late by {median:.2} us (median) and {tail:.2} us (1 % are later; worst case {value:.2} \
             us, {case}); the loop by {:.2} and {:.2} us.",
            values[0].len(),
            quantile(&values[2], 0.5),
            quantile(&values[2], 0.99),
        );
        let what = "The empty loop only looks at the clock, over the same time, directly after the query: what it is late, the \
                    machine did.";
        let table = Block::Table(Table::new(header, rows));
        let blocks = vec![self.plot("late", &chart)?, table];
        Ok(section(format!("{late} {what}"), measured, blocks))
    }
}

fn overruns(case: &Measurement) -> impl Iterator<Item = &Overrun> {
    case.rounds.iter().flat_map(|round| &round.overruns)
}
