//! Case by case, and easy poses apart from hard ones.

use crate::report::{Block, Failure, Lead, Section, Table};
use crate::statistics::mean;
use punctual::Mode;

use super::super::contender::{DEFAULT, DEPTH_FIRST, LOW_ALPHA, label};
use super::super::measure::Limit;
use super::super::plan::plan;
use super::super::summary::{
    COVERAGE, DETECTED, Feature, Measurement, RECALL, Stratum, UNDECIDED, WORK, Which,
    first_hit_of_case, volume_left,
};
use super::{
    Report, at_work, best, counted, distance, has_intersections, number, over_time, over_work,
};

/// Orders that are shown for kinds of poses.
fn shown() -> impl Iterator<Item = &'static str> {
    plan()
        .names()
        .filter(|order| [DEFAULT, DEPTH_FIRST, LOW_ALPHA].contains(order))
}

impl Report<'_> {
    pub(super) fn strata(&self) -> Section {
        let [soon, later] = [5, 20].map(|percent| plan().percent_near(percent));
        let header = [
            "poses".to_owned(),
            "number".to_owned(),
            format!("undecided at {later} %"),
        ]
        .into_iter();
        let header = header.chain(
            [
                format!("detected at {soon} %"),
                format!("pairs at {later} %"),
            ]
            .into_iter()
            .flat_map(|what| shown().map(move |order| format!("{what}: {}", label(order)))),
        );
        Section {
            id: "strata".into(),
            title: "Easy and hard poses".into(),
            lead: Lead::Shows(
                "The poses by how deep the meshes are in each other, so that no mean hides hard poses behind easy ones.".into(),
            ),
            measured: "Each pose counts once.".into(),
            blocks: vec![Block::Table(Table {
                header: header.collect(),
                rows: Stratum::ALL.map(|stratum| self.stratum(stratum)).to_vec(),
            })],
        }
    }

    fn stratum(&self, stratum: Stratum) -> Vec<String> {
        let poses: usize = self
            .cases
            .iter()
            .map(|case| case.strata.iter().filter(|s| **s == stratum).count())
            .sum();
        let at = |order, mode, percent, feature: Feature| {
            let which = Which {
                order,
                mode,
                budget: Limit::Work(percent),
            };
            let rows = self.cases.iter().flat_map(|case| {
                case.work
                    .rows
                    .iter()
                    .filter(move |row| which.picks(row) && case.strata[row.pose] == stratum)
            });
            number(mean(rows.map(feature)).unwrap_or(f64::NAN))
        };
        let [soon, later] = [5, 20].map(|percent| plan().percent_near(percent));
        let mut row = vec![
            stratum.name().to_owned(),
            poses.to_string(),
            at(DEFAULT, Mode::Any, later, UNDECIDED),
        ];
        for (mode, percent, feature) in [(Mode::Any, soon, DETECTED), (Mode::All, later, RECALL)] {
            let cell = |order| {
                if stratum.collides() {
                    at(order, mode, percent, feature)
                } else {
                    "-".to_owned()
                }
            };
            row.extend(shown().map(cell));
        }
        row
    }

    pub(super) fn each_case(&self) -> Result<Section, Failure> {
        let [soon, later] = [5, 20].map(|percent| plan().percent_near(percent));
        let header = [
            "case",
            "triangles",
            "poses",
            "in contact",
            &format!("detected at {soon} %"),
            "depth-first",
            "best order of ours",
            &format!("pairs at {later} %"),
            "depth-first",
            "best order of ours",
            &format!("regions at {later} %"),
            "first hit, share of the work of depth-first",
            &format!("volume left at {} %", plan().percent_near(50)),
        ];
        let mut blocks = Vec::new();
        if self.cases.iter().any(has_intersections) {
            blocks.push(Block::Table(Table::new(
                header,
                self.cases.iter().map(row).collect(),
            )));
        }
        for case in self.cases {
            blocks.push(self.plots_of(case)?);
        }
        Ok(Section {
            id: "cases".into(),
            title: "Case by case".into(),
            lead: Lead::Shows("The figures of each case, and, to be unfolded, its plots.".into()),
            measured: format!(
                "{}, {} of them with poses in contact.",
                counted(self.cases.len(), "case"),
                self.cases.iter().filter(|case| case.hits() > 0).count()
            ),
            blocks,
        })
    }

    /// The plots of one case.
    fn plots_of(&self, case: &Measurement) -> Result<Block, Failure> {
        let (name, alone) = (&case.name, std::slice::from_ref(case));
        let mut charts = Vec::new();
        if case.hits() > 0 && has_intersections(case) {
            charts.extend([
                (
                    "work",
                    over_work(
                        alone,
                        &format!("{name}: pairs found, over work"),
                        Mode::All,
                        RECALL,
                    ),
                ),
                (
                    "any-time",
                    over_time(
                        alone,
                        &format!("{name}: contact detected within a time"),
                        Mode::Any,
                        DETECTED,
                    ),
                ),
                (
                    "all-time",
                    over_time(
                        alone,
                        &format!("{name}: pairs found within a time"),
                        Mode::All,
                        RECALL,
                    ),
                ),
            ]);
        }
        if distance::has_any(case) {
            charts.extend(distance::charts(alone, &format!(": {name}")));
        }
        let plots = charts
            .iter()
            .map(|(what, chart)| self.plot(&format!("cases/{name}-{what}"), chart));
        Ok(Block::Details(
            name.clone(),
            plots.collect::<Result<_, _>>()?,
        ))
    }
}

fn row(case: &Measurement) -> Vec<String> {
    let alone = std::slice::from_ref(case);
    let [soon, later] = [5, 20].map(|percent| plan().percent_near(percent));
    let any = |order| at_work(alone, order, Mode::Any, soon, DETECTED);
    let all = |order| at_work(alone, order, Mode::All, later, RECALL);
    let orders = || plan().contenders().map(|contender| contender.name);
    let name = |order: &str, value: f64| {
        if value.is_nan() {
            "-".to_owned()
        } else {
            order.to_owned()
        }
    };
    let [best_any, best_all] = [best(orders(), any), best(orders(), all)];
    let left = volume_left(alone, DEFAULT, plan().percent_near(50))
        .next()
        .map_or(f64::NAN, |(_, left)| left);
    vec![
        case.name.clone(),
        format!("{} x {}", case.triangles[0], case.triangles[1]),
        case.strata.len().to_string(),
        case.hits().to_string(),
        number(any(DEFAULT)),
        number(any(DEPTH_FIRST)),
        name(best_any, any(best_any)),
        number(all(DEFAULT)),
        number(all(DEPTH_FIRST)),
        name(best_all, all(best_all)),
        number(at_work(alone, DEFAULT, Mode::All, later, COVERAGE)),
        number(1.0 / first_hit_of_case(case, DEFAULT, WORK).unwrap_or(f64::NAN)),
        number(left),
    ]
}
