//! Case by case, and easy poses apart from hard ones.

use crate::report::{Block, Failure, Section, Table};
use crate::statistics::mean;

use super::super::contender::{DEFAULT, DEPTH_FIRST, LOW_ALPHA, label};
use super::super::measure::{Asked, Limit};
use super::super::plan::plan;
use super::super::summary::{
    COVERAGE, DETECTED, Feature, Measurement, RECALL, Stratum, UNDECIDED, WORK, Which,
    first_hit_of_case, volume_left,
};
use super::{Kind, Report, at_work, counted, distance, number};

/// The shares of the work at which contacts and pairs are told.
fn soon_and_later() -> [u32; 2] {
    [5, 20].map(|percent| plan().percent_near(percent))
}

impl Report<'_> {
    pub(super) fn strata(&self) -> Section {
        let [soon, later] = soon_and_later();
        let shown = || {
            let orders = plan().names();
            orders.filter(|order| [DEFAULT, DEPTH_FIRST, LOW_ALPHA].contains(order))
        };
        let columns: Vec<(String, Which, Feature)> = [
            (format!("detected at {soon} %"), Asked::Any, soon, DETECTED),
            (format!("pairs at {later} %"), Asked::All, later, RECALL),
        ]
        .into_iter()
        .flat_map(|(what, asked, percent, feature)| {
            shown().map(move |order| {
                let which = Which(order, asked, Limit::Work(percent));
                (format!("{what}: {}", label(order)), which, feature)
            })
        })
        .collect();
        let row = |stratum: Stratum| {
            let counts = self.cases.iter();
            let counts = counts.map(|case| case.strata.iter().filter(|s| **s == stratum).count());
            let at = |which: Which, feature: Feature| {
                let rows = self.cases.iter().flat_map(|case| {
                    let rows = case.work.rows.iter();
                    rows.filter(move |row| which.picks(row) && case.strata[row.pose] == stratum)
                });
                number(mean(rows.map(feature)).unwrap_or(f64::NAN))
            };
            let undecided = Which(DEFAULT, Asked::Any, Limit::Work(later));
            let cells = columns.iter().map(|(_, which, feature)| {
                if stratum.collides() {
                    at(*which, *feature)
                } else {
                    "-".to_owned()
                }
            });
            [
                stratum.name().to_owned(),
                counts.sum::<usize>().to_string(),
                at(undecided, UNDECIDED),
            ]
            .into_iter()
            .chain(cells)
            .collect()
        };
        let header = [
            "poses".to_owned(),
            "number".to_owned(),
            format!("undecided at {later} %"),
        ];
        let header = header
            .into_iter()
            .chain(columns.iter().map(|(name, ..)| name.clone()));
        Section::shows(
            "strata",
            "Easy and hard poses",
            "The poses by how deep the meshes are in each other, so that no mean hides hard poses behind easy ones.",
            "Each pose counts once.",
            vec![Block::Table(Table::new(
                header,
                Stratum::ALL.map(row).to_vec(),
            ))],
        )
    }

    pub(super) fn each_case(&self) -> Result<Section, Failure> {
        let mut blocks = Vec::new();
        if self.cases.iter().any(|case| case.has(Asked::Any)) {
            let [soon, later] = soon_and_later();
            let header = format!(
                "case|triangles|poses|in contact|detected at {soon} %|depth-first|best order of ours|pairs at {later} %|\
                 depth-first|best order of ours|regions at {later} %|first hit, share of the work of depth-first|\
                 volume left at {} %",
                plan().percent_near(50)
            );
            blocks.push(Block::Table(Table::new(
                header.split('|'),
                self.cases.iter().map(row).collect(),
            )));
        }
        for case in self.cases {
            blocks.push(self.plots_of(case)?);
        }
        Ok(Section::shows(
            "cases",
            "Case by case",
            "The figures of each case, and, to be unfolded, its plots.",
            format!(
                "{}, {} of them with poses in contact.",
                counted(self.cases.len(), "case"),
                self.cases.iter().filter(|case| case.hits() > 0).count()
            ),
            blocks,
        ))
    }

    /// The plots of one case.
    fn plots_of(&self, case: &Measurement) -> Result<Block, Failure> {
        let (name, alone) = (&case.name, std::slice::from_ref(case));
        let mut charts = Vec::new();
        if case.hits() > 0 && case.has(Asked::Any) {
            for (id, what, kind, asked, feature) in [
                (
                    "work",
                    "pairs found, over work",
                    Kind::Work,
                    Asked::All,
                    RECALL,
                ),
                (
                    "any-time",
                    "contact detected within a time",
                    Kind::Time,
                    Asked::Any,
                    DETECTED,
                ),
                (
                    "all-time",
                    "pairs found within a time",
                    Kind::Time,
                    Asked::All,
                    RECALL,
                ),
            ] {
                let title = format!("{name}: {what}");
                charts.push((id, kind.chart(alone, &title, asked, feature)));
            }
        }
        if case.has(Asked::Distance) {
            charts.extend(distance::charts(alone, &format!(": {name}")));
        }
        let plots = charts
            .iter()
            .map(|(what, chart)| self.plot(&format!("cases/{name}-{what}"), chart));
        let plots = plots.collect::<Result<_, _>>()?;
        Ok(Block::Details(name.clone(), plots))
    }
}

fn row(case: &Measurement) -> Vec<String> {
    let alone = std::slice::from_ref(case);
    let [soon, later] = soon_and_later();
    let any = |order| at_work(alone, order, Asked::Any, soon, DETECTED);
    let all = |order| at_work(alone, order, Asked::All, later, RECALL);
    let left = volume_left(alone, DEFAULT, plan().percent_near(50)).next();
    let first_hit = first_hit_of_case(case, DEFAULT, WORK).map(|gain| 1.0 / gain);
    vec![
        case.name.clone(),
        format!("{} x {}", case.triangles[0], case.triangles[1]),
        case.strata.len().to_string(),
        case.hits().to_string(),
        number(any(DEFAULT)),
        number(any(DEPTH_FIRST)),
        best(any),
        number(all(DEFAULT)),
        number(all(DEPTH_FIRST)),
        best(all),
        number(at_work(alone, DEFAULT, Asked::All, later, COVERAGE)),
        number(first_hit.unwrap_or(f64::NAN)),
        number(left.map_or(f64::NAN, |(_, left)| left)),
    ]
}

/// The order with the largest value, the first of equals; a dash where there is none.
fn best(value: impl Fn(&'static str) -> f64) -> String {
    let orders = plan().timed_names();
    let best = orders.reduce(|best, name| {
        if value(name) > value(best) {
            name
        } else {
            best
        }
    });
    let best = best.filter(|best| !value(best).is_nan());
    best.unwrap_or("-").to_owned()
}
