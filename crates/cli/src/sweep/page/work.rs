//! What is known after a share of the work: the same figures on every machine.

use punctual::Mode;
use punctual_lab::report::{Axis, Block, Chart, Failure, Lead, Section, Series, Shape, Table};
use punctual_lab::statistics::{mean, quantile, sorted};

use super::super::contender::{CERTIFIED, CURVES, CUT_OFF, DEFAULT, DEPTH_FIRST, NARROWED, ORACLE, label, names};
use super::super::measure::{Limit, PERCENT};
use super::super::summary::{
    BV_TESTS, COVERAGE, DETECTED, Feature, RECALL, WORK, Which, Worst, area, first_hit, first_hit_of_case, volume_left,
    worst_case,
};
use super::{Report, at_work, over_work};

/// A question that is asked after a share of the work.
struct Question {
    id: &'static str,
    title: &'static str,
    shown: &'static str,
    mode: Mode,
    feature: Feature,
    /// Share of the work, in percent, that is looked at in words.
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
        QUESTIONS.iter().map(|question| self.answer(question)).collect()
    }

    fn answer(&self, question: &Question) -> Result<Section, Failure> {
        let &Question { id, title, shown, mode, feature, percent } = question;
        let at = |order, percent| at_work(self.cases, order, mode, percent, feature);
        let worst =
            |order, percent| worst_case(self.cases, Which { order, mode, budget: Limit::Work(percent) }, feature);
        let mut chart = over_work(self.cases, title, mode, feature);
        chart.series.insert(0, self.band(mode, feature));
        let table = by_percent(names(), |order, percent| [at(order, percent), worst(order, percent).value]);
        let compared = CURVES.iter().filter(|curve| mode == Mode::All || curve.order != CUT_OFF);
        let words = compared.map(|curve| {
            let Worst { case, value } = worst(curve.order, percent);
            format!("{} {:.2} (worst case {value:.2}, {case})", curve.label, at(curve.order, percent))
        });
        let mut measured = format!("With {percent} % of the work: {}.", words.collect::<Vec<_>>().join("; "));
        if id == "all" {
            let [ours, plain, oracle] = [DEFAULT, DEPTH_FIRST, ORACLE].map(|order| area(self.cases, order));
            measured += &format!(" Mean over all budgets: {ours:.2}, depth-first {plain:.2}, best order {oracle:.2}.");
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
            blocks: vec![self.plot(id, &chart)?, Block::Text(text), Block::Table(table)],
        })
    }

    /// The middle half of the poses. Where an answer is yes or no it would say nothing.
    fn band(&self, mode: Mode, feature: Feature) -> Series {
        let bar = |percent: u32| {
            let which = Which { order: DEFAULT, mode, budget: Limit::Work(percent) };
            let rows = self
                .cases
                .iter()
                .flat_map(|case| case.work.rows.iter().filter(move |row| which.picks(row) && case.collides(row)));
            let values = sorted(rows.map(feature));
            [f64::from(percent), quantile(&values, 0.25), quantile(&values, 0.75)]
        };
        Series::new("", 0, Shape::Band(if mode == Mode::Any { vec![] } else { PERCENT.map(bar).to_vec() }))
    }

    pub(super) fn first_hit(&self) -> Section {
        let header = ["how many times less than depth-first", "work: mean", "worst case", "BV tests: mean"];
        let worst = |order: &str| {
            let gains = self.cases.iter().filter_map(|case| Some((&*case.name, first_hit_of_case(case, order, WORK)?)));
            Worst::least(gains)
        };
        let row = |order| {
            let gains =
                [first_hit(self.cases, order, WORK), worst(order).value, first_hit(self.cases, order, BV_TESTS)];
            std::iter::once(label(order).to_owned()).chain(gains.map(|gain| format!("{gain:.2}"))).collect()
        };
        let [ours, oracle] = [DEFAULT, ORACLE].map(|order| first_hit(self.cases, order, WORK));
        let Worst { case, value } = worst(DEFAULT);
        Section {
            id: "first-hit".into(),
            title: "How soon is the first contact found?".into(),
            lead: Lead::Shows(
                "How many times less work than depth-first it takes to find the first pair of triangles that meet."
                    .into(),
            ),
            measured: format!(
                "{ours:.2} times less (worst case {value:.2}, {case}); the best order {oracle:.2} times. Geometric means."
            ),
            blocks: vec![Block::Table(Table::new(
                header,
                names().filter(|order| *order != CUT_OFF).map(row).collect(),
            ))],
        }
    }

    /// How the certificate shrinks.
    pub(super) fn volume_left(&self) -> Result<Section, Failure> {
        const HALF: u32 = 50;
        let at =
            |order, percent| mean(volume_left(self.cases, order, percent).map(|(_, left)| left)).unwrap_or(f64::NAN);
        let worst = |order, percent| Worst::largest(volume_left(self.cases, order, percent));
        let line = |(color, order): (usize, &&'static str)| {
            let points = PERCENT.map(|percent| [f64::from(percent), at(order, percent)]);
            Series::new(label(order), color, Shape::Line(points.to_vec()))
        };
        let chart = Chart {
            title: "Room that is left for missed contacts".to_owned(),
            x: Axis::linear(super::WORK).range(0.0..100.0),
            y: Axis::linear("share of the boxes' overlap").range(0.0..1.0),
            series: CERTIFIED.iter().enumerate().map(line).collect(),
        };
        let cell = |order, percent| [at(order, percent), worst(order, percent).value];
        let table = by_percent(CERTIFIED.into_iter(), cell);
        let Worst { case, value } = worst(DEFAULT, HALF);
        Ok(Section {
            id: "volume-left".into(),
            title: "Where could a contact still be?".into(),
            lead: Lead::Shows(
                "A stopped query names boxes outside of which nothing was missed (its certificate). Their volume, as a share \
                 of the overlap of the bounding boxes of the two meshes: 1 means that nothing is known, 0 that all is. A \
                 certificate can be narrowed: a tenth more work opens the largest of its boxes."
                    .into(),
            ),
            measured: format!(
                "After {HALF} % of the work: {:.2} (worst case {value:.2}, {case}); narrowed {:.3} (worst case {:.2}); \
                 depth-first {:.2}.",
                at(DEFAULT, HALF),
                at(NARROWED, HALF),
                worst(NARROWED, HALF).value,
                at(DEPTH_FIRST, HALF),
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
fn by_percent(orders: impl Iterator<Item = &'static str>, cell: impl Fn(&'static str, u32) -> [f64; 2]) -> Table {
    let header = std::iter::once("mean / worst case".to_owned()).chain(PERCENT.map(|percent| format!("{percent} %")));
    let row = |order| {
        let cells = PERCENT.map(|percent| {
            let [mean, worst] = cell(order, percent);
            format!("{mean:.2} / {worst:.2}")
        });
        std::iter::once(label(order).to_owned()).chain(cells).collect()
    };
    Table { header: header.collect(), rows: orders.map(row).collect() }
}
