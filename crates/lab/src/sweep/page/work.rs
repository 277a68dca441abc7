//! What is known after a share of the work: the same figures on every machine.

use crate::report::{Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table};
use crate::statistics::{mean, quantile, sorted};
use punctual::Mode;

use super::super::contender::{CERTIFIED, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE, label};
use super::super::measure::Limit;
use super::super::plan::plan;
use super::super::summary::{
    BV_TESTS, COVERAGE, DETECTED, Feature, RECALL, WORK, Which, Worst, area, first_hit,
    first_hit_of_case, volume_left, worst_case,
};
use super::{Report, at_work, drawn, number, over_work};

/// A question that is asked after a share of the work.
struct Question {
    id: &'static str,
    title: &'static str,
    shown: &'static str,
    mode: Mode,
    feature: Feature,
    /// Share of the work, in percent, that is put in words; the nearest one measured.
    percent: u32,
}

const QUESTIONS: [Question; 3] = [
    Question {
        id: "any",
        title: "Is there a contact?",
        shown: "Share of the poses in contact at which the contact is known after a share of the work. A plain query for \
                a first contact ends with it, and so knows what depth-first knows.",
        mode: Mode::Any,
        feature: DETECTED,
        percent: 5,
    },
    Question {
        id: "all",
        title: "Which triangles meet?",
        shown: "Share of the pairs of triangles that meet which are known after a share of the work (recall).",
        mode: Mode::All,
        feature: RECALL,
        percent: 20,
    },
    Question {
        id: "coverage",
        title: "Where do they meet?",
        shown: "Share of the contact regions, of which a pair is known after a share of the work (coverage). A region is a \
                cell of a grid, 5 % of the smaller mesh wide, in which triangles meet.",
        mode: Mode::All,
        feature: COVERAGE,
        percent: 20,
    },
];

impl Report<'_> {
    /// A section for each question.
    pub(super) fn work(&self) -> Result<Vec<Section>, Failure> {
        QUESTIONS
            .iter()
            .map(|question| self.answer(question))
            .collect()
    }

    fn answer(&self, question: &Question) -> Result<Section, Failure> {
        let &Question {
            id,
            title,
            shown,
            mode,
            feature,
            percent,
        } = question;
        let percent = plan().percent_near(percent);
        let at = |order, percent| at_work(self.cases, order, mode, percent, feature);
        let worst = |order, percent| {
            worst_case(
                self.cases,
                Which {
                    order,
                    mode,
                    budget: Limit::Work(percent),
                },
                feature,
            )
        };
        let mut chart = over_work(self.cases, title, mode, feature);
        chart.series.insert(0, self.band(mode, feature));
        let table = by_percent(plan().names(), |order, percent| {
            [at(order, percent), worst(order, percent).value]
        });
        let compared = drawn().filter(|curve| mode == Mode::All || curve.order != CUT_OFF);
        let words = compared.map(|curve| {
            let Worst { case, value } = worst(curve.order, percent);
            format!(
                "{} {} (worst case {}, {case})",
                curve.label,
                number(at(curve.order, percent)),
                number(value)
            )
        });
        let mut measured = format!(
            "With {percent} % of the work: {}.",
            words.collect::<Vec<_>>().join("; ")
        );
        if id == "all" {
            let [ours, plain, oracle] =
                [DEFAULT, DEPTH_FIRST, ORACLE].map(|order| number(area(self.cases, order)));
            measured += &format!(
                " Mean over all budgets: {ours}, depth-first {plain}, best order {oracle}."
            );
        }
        let mut text =
            "Each case counts alike, as the mean over its poses in contact. The worst case is the one with the least \
                        mean."
                .to_owned();
        if mode == Mode::All {
            text += " The shaded band holds the middle half of these poses of all cases, for this library.";
        }
        Ok(Section {
            id: id.to_owned(),
            title: title.to_owned(),
            lead: Lead::Shows(shown.to_owned()),
            measured,
            blocks: vec![
                self.plot(id, &chart)?,
                Block::Text(text),
                Block::Table(table),
            ],
        })
    }

    /// The middle half of the poses. Where an answer is yes or no it would say nothing.
    fn band(&self, mode: Mode, feature: Feature) -> Series {
        let bar = |percent: u32| {
            let which = Which {
                order: DEFAULT,
                mode,
                budget: Limit::Work(percent),
            };
            let rows = self.cases.iter().flat_map(|case| {
                case.work
                    .rows
                    .iter()
                    .filter(move |row| which.picks(row) && case.collides(row))
            });
            let values = sorted(rows.map(feature));
            [
                f64::from(percent),
                quantile(&values, 0.25),
                quantile(&values, 0.75),
            ]
        };
        Series::new(
            "",
            0,
            Shape::Band(if mode == Mode::Any {
                vec![]
            } else {
                plan().percent().map(bar).collect()
            }),
        )
    }

    pub(super) fn first_hit(&self) -> Section {
        let header = [
            "share of what depth-first takes",
            "work: mean",
            "worst case",
            "BV tests: mean",
        ];
        let worst = |order: &str| {
            let shares = self.cases.iter().filter_map(|case| {
                Some((&*case.name, 1.0 / first_hit_of_case(case, order, WORK)?))
            });
            Worst::largest(shares)
        };
        let row = |order| {
            let [work, bv_tests] =
                [WORK, BV_TESTS].map(|cost| 1.0 / first_hit(self.cases, order, cost));
            std::iter::once(label(order).to_owned())
                .chain([work, worst(order).value, bv_tests].map(number))
                .collect()
        };
        let [ours, oracle] =
            [DEFAULT, ORACLE].map(|order| 1.0 / first_hit(self.cases, order, WORK));
        let Worst { case, value } = worst(DEFAULT);
        Section {
            id: "first-hit".into(),
            title: "How soon is the first contact found?".into(),
            lead: Lead::Shows(
                "The work to the first pair of triangles that meet, over that of a depth-first search: below 1 is sooner.".into(),
            ),
            measured: format!(
                "{ours:.2} of the work of depth-first (worst case {value:.2}, {case}); the best order {oracle:.2}. Geometric means."
            ),
            blocks: vec![Block::Table(Table::new(
                header,
                plan().names().filter(|order| *order != CUT_OFF).map(row).collect(),
            ))],
        }
    }

    /// How the certificate shrinks.
    pub(super) fn volume_left(&self) -> Result<Section, Failure> {
        let half = plan().percent_near(50);
        let at = |order, percent| {
            mean(volume_left(self.cases, order, percent).map(|(_, left)| left)).unwrap_or(f64::NAN)
        };
        let worst = |order, percent| Worst::largest(volume_left(self.cases, order, percent));
        let line = |(color, order): (usize, &&'static str)| {
            let points = plan()
                .percent()
                .map(|percent| [f64::from(percent), at(order, percent)]);
            Series::new(label(order), color, Shape::Line(points.collect()))
        };
        let chart = Chart {
            title: "Room that is left for missed contacts".to_owned(),
            x: Axis::linear(super::WORK).range(0.0..100.0),
            y: Axis::linear("share of the boxes' overlap").range(0.0..1.0),
            series: CERTIFIED.iter().enumerate().map(line).collect(),
        };
        let cell = |order, percent| [at(order, percent), worst(order, percent).value];
        let table = by_percent(CERTIFIED.into_iter(), cell);
        let Worst { case, value } = worst(DEFAULT, half);
        Ok(Section {
            id: "volume-left".into(),
            title: "Where could a contact still be?".into(),
            lead: Lead::Shows(
                "A stopped query names boxes outside of which nothing was missed (its certificate). Their volume, as a share \
                 of the overlap of the bounding boxes of the two meshes: 1 means that nothing is known, 0 that all is."
                    .into(),
            ),
            measured: format!(
                "After {half} % of the work: {} (worst case {}, {case}); depth-first {}.",
                number(at(DEFAULT, half)),
                number(value),
                number(at(DEPTH_FIRST, half)),
            ),
            blocks: vec![
                self.plot("volume-left", &chart)?,
                Block::Text(
                    "Mean over cases of the median over the poses at which the bounding boxes overlap; all pairs are looked \
                     for. Measured at 512 points in the overlap."
                        .into(),
                ),
                Block::Table(table),
            ],
        })
    }
}

/// A row for each order and a column for each share of the work; `cell` gives the mean and the worst case.
fn by_percent(
    orders: impl Iterator<Item = &'static str>,
    cell: impl Fn(&'static str, u32) -> [f64; 2],
) -> Table {
    let header = std::iter::once("mean / worst case".to_owned())
        .chain(plan().percent().map(|percent| format!("{percent} %")));
    let row = |order| {
        let cells = plan().percent().map(|percent| {
            let [mean, worst] = cell(order, percent);
            format!("{} / {}", number(mean), number(worst))
        });
        std::iter::once(label(order).to_owned())
            .chain(cells)
            .collect()
    };
    Table {
        header: header.collect(),
        rows: orders.map(row).collect(),
    }
}
