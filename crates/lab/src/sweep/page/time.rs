//! What is known when a time is up, and how late that is: of this machine.

use crate::report::{Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table, short};
use crate::statistics::{quantile, sorted};
use punctual::Mode;

use super::super::contender::{DEFAULT, ORACLE, label};
use super::super::measure::Limit;
use super::super::plan::plan;
use super::super::punctuality::{Overrun, UNLIMITED};
use super::super::summary::{
    CLOCKS, DETECTED, Feature, Measurement, QUANTILES, RECALL, Which, Worst, finished_time,
    over_cases, worst_case,
};
use super::{Report, drawn, number, over_time};

/// Budgets in the tables, as many as fit on a page.
const SHOWN: usize = 8;

impl Report<'_> {
    pub(super) fn time(&self) -> Result<Section, Failure> {
        let mut blocks = vec![self.plot("overview", &self.overview())?];
        for (id, title, mode, feature) in [
            (
                "any-time",
                "Contact detected within a time",
                Mode::Any,
                DETECTED,
            ),
            ("all-time", "Pairs found within a time", Mode::All, RECALL),
        ] {
            blocks.push(self.plot(id, &over_time(self.cases, title, mode, feature))?);
            blocks.push(Block::Table(self.time_table(title, mode, feature)));
        }
        let time = |order: &str, mode| {
            let rounds = self
                .cases
                .iter()
                .map(|case| case.rounds.len())
                .min()
                .unwrap_or(0);
            let times =
                sorted((0..rounds).map(|round| finished_time(self.cases, order, mode, round)));
            quantile(&times, 0.0)
        };
        let header = ["finished query, microseconds", "first contact", "all pairs"];
        let orders = plan()
            .contenders()
            .map(|contender| contender.name)
            .chain([UNLIMITED]);
        let row = |order| {
            vec![
                label(order).to_owned(),
                short(time(order, Mode::Any)),
                short(time(order, Mode::All)),
            ]
        };
        blocks.push(Block::Table(Table::new(header, orders.map(row).collect())));
        blocks.push(Block::Text(
            "A finished query: geometric mean over cases of the mean over poses, the best of the rounds. \"No budget\" is this \
             library without a budget, which goes depth-first."
                .into(),
        ));
        let [any, all] =
            [Mode::Any, Mode::All].map(|mode| number(time(DEFAULT, mode) / time(UNLIMITED, mode)));
        Ok(Section {
            id: "time".into(),
            title: "What is known when the time is up?".into(),
            lead: Lead::Shows(
                "Share of the poses in contact at which the contact is known, of the pairs of triangles that meet which are \
                 found (recall), and of the distances that are known to 10 %, after a time. A plain query that is cut off has \
                 found all, or nothing that is known."
                    .into(),
            ),
            measured: format!(
                "A query that could be stopped at any unit of work, but runs to its end, takes {any} (first contact) and \
                 {all} times (all pairs) as long as one without a budget."
            ),
            blocks,
        })
    }

    fn time_table(&self, title: &str, mode: Mode, feature: Feature) -> Table {
        let chosen = plan().microseconds();
        let budgets = || chosen.iter().copied().step_by(chosen.len().div_ceil(SHOWN));
        let header = std::iter::once(format!("{title}: mean / worst case"));
        let cell = |order, us| {
            let which = Which {
                order,
                mode,
                budget: Limit::Time(std::time::Duration::from_micros(us)),
            };
            let worst = worst_case(self.cases, which, feature).value;
            format!(
                "{} / {}",
                number(over_cases(self.cases, which, feature)),
                number(worst)
            )
        };
        let row = |order| {
            std::iter::once(label(order).to_owned())
                .chain(budgets().map(|us| cell(order, us)))
                .collect()
        };
        let rows = drawn()
            .filter(|curve| curve.order != ORACLE)
            .map(|curve| row(curve.order))
            .collect();
        Table {
            header: header
                .chain(budgets().map(|us| format!("{us} us")))
                .collect(),
            rows,
        }
    }

    pub(super) fn lateness(&self) -> Result<Section, Failure> {
        let every = || self.cases.iter().flat_map(overruns);
        if every().next().is_none() {
            return Ok(Section {
                id: "late".into(),
                title: "How late is a stopped query?".into(),
                lead: Lead::Shows("How long after its deadline a query came back.".into()),
                measured: "No query was stopped by a deadline.".into(),
                blocks: vec![],
            });
        }
        let values =
            CLOCKS.map(|(_, reading)| sorted(every().map(|overrun| 1e6 * reading(overrun))));
        let names = [
            "query, wall clock",
            "query, CPU time",
            "empty loop, wall clock",
        ];
        let header = std::iter::once("microseconds late").chain(QUANTILES.map(|(name, _)| name));
        let row = |(name, values): (&str, &Vec<f64>)| {
            let at = |(_, fraction)| number(quantile(values, fraction));
            std::iter::once(name.to_owned())
                .chain(QUANTILES.map(at))
                .collect()
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
            quantile(
                &sorted(overruns(case).map(|overrun| 1e6 * overrun.wall)),
                0.99,
            )
        };
        let timed = self
            .cases
            .iter()
            .filter(|case| overruns(case).next().is_some());
        let Worst { case, value } = Worst::largest(timed.map(|case| (&*case.name, p99(case))));
        let [median, tail] = [0.5, 0.99].map(|fraction| quantile(&values[0], fraction));
        Ok(Section {
            id: "late".into(),
            title: "How late is a stopped query?".into(),
            lead: Lead::Shows(
                "How long after its deadline a query came back. The empty loop only looks at the clock, over the same time, \
                 directly after the query: what it is late, the machine did."
                    .into(),
            ),
            measured: format!(
                "{} stops by a deadline. Late by {median:.2} us (median) and {tail:.2} us (1 % are later; worst case {value:.2} \
                 us, {case}); the loop by {:.2} and {:.2} us.",
                values[0].len(),
                quantile(&values[2], 0.5),
                quantile(&values[2], 0.99),
            ),
            blocks: vec![self.plot("late", &chart)?, Block::Table(Table::new(header, rows))],
        })
    }
}

fn overruns(case: &Measurement) -> impl Iterator<Item = &Overrun> {
    case.rounds.iter().flat_map(|round| &round.overruns)
}
