//! What is known after a share of the work: the same figures on every machine.

use crate::report::{Axis, Block, Chart, Failure, Section, Series, Shape, Table};
use crate::statistics::{mean, quantile};

use super::super::contender::{CERTIFIED, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE, label};
use super::super::measure::{Asked, Limit};
use super::super::plan::plan;
use super::super::summary::{
    BV_TESTS, COVERAGE, DETECTED, Feature, RECALL, WORK, Which, Worst, area, first_hit,
    first_hit_of_case, spread, volume_left, worst_case,
};
use super::{Kind, Report, at_work, by_budget, drawn, in_words, number, works};

/// A question that is asked after a share of the work.
struct Question {
    id: &'static str,
    title: &'static str,
    shown: &'static str,
    asked: Asked,
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
        asked: Asked::Any,
        feature: DETECTED,
        percent: 5,
    },
    Question {
        id: "all",
        title: "Which triangles meet?",
        shown: "Share of the pairs of triangles that meet which are known after a share of the work (recall).",
        asked: Asked::All,
        feature: RECALL,
        percent: 20,
    },
    Question {
        id: "coverage",
        title: "Where do they meet?",
        shown: "Share of the contact regions, of which a pair is known after a share of the work (coverage). A region is a \
                cell of a grid, 5 % of the smaller mesh wide, in which triangles meet.",
        asked: Asked::All,
        feature: COVERAGE,
        percent: 20,
    },
];

const MEAN_AND_WORST: &str = "mean / worst case";

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
            asked,
            feature,
            ..
        } = question;
        let percent = plan().percent_near(question.percent);
        let mut chart = Kind::Work.chart(self.cases, title, asked, feature);
        let mut text =
            "Each case counts alike, as the mean over its poses in contact. The worst case is the one with the least mean."
                .to_owned();
        // Where an answer is yes or no a band would say nothing.
        if asked == Asked::All {
            chart.series.insert(0, self.band(asked, feature));
            text += " The shaded band holds the middle half of these poses of all cases, for this library.";
        }
        let compared = drawn().filter(|curve| asked == Asked::All || curve.order != CUT_OFF);
        let words = compared.map(|curve| {
            let mean = at_work(self.cases, curve.order, asked, percent, feature);
            let which = Which(curve.order, asked, Limit::Work(percent));
            in_words(curve.label, mean, worst_case(self.cases, which, feature))
        });
        let words = words.collect::<Vec<_>>().join("; ");
        let mut measured = format!("With {percent} % of the work: {words}.");
        if id == "all" {
            let [ours, plain, oracle] =
                [DEFAULT, DEPTH_FIRST, ORACLE].map(|order| number(area(self.cases, order)));
            measured += &format!(
                " Mean over all budgets: {ours}, depth-first {plain}, best order {oracle}."
            );
        }
        let cell = self.mean_and_worst(asked, feature);
        let table = by_budget(MEAN_AND_WORST, plan().names(), &works(), cell);
        let blocks = vec![
            self.plot(id, &chart)?,
            Block::Text(text),
            Block::Table(table),
        ];
        Ok(Section::shows(id, title, shown, measured, blocks))
    }

    /// The middle half of the poses.
    fn band(&self, asked: Asked, feature: Feature) -> Series {
        let bar = |percent: u32| {
            let which = Which(DEFAULT, asked, Limit::Work(percent));
            let values = spread(self.cases, which, feature);
            let [low, high] = [0.25, 0.75].map(|fraction| quantile(&values, fraction));
            [f64::from(percent), low, high]
        };
        Series::new("", 0, Shape::Band(plan().percent().map(bar).collect()))
    }

    pub(super) fn first_hit(&self) -> Section {
        let header = [
            "share of what depth-first takes",
            "work: mean",
            "worst case",
            "BV tests: mean",
        ];
        let share = |order: &str, cost| 1.0 / first_hit(self.cases, order, cost);
        let worst = |order: &str| {
            let gains = self.cases.iter().filter_map(|case| {
                Some((&*case.name, 1.0 / first_hit_of_case(case, order, WORK)?))
            });
            Worst::largest(gains)
        };
        let row = |order| {
            let cells = [
                share(order, WORK),
                worst(order).value,
                share(order, BV_TESTS),
            ];
            std::iter::once(label(order).to_owned())
                .chain(cells.map(number))
                .collect()
        };
        let Worst { case, value } = worst(DEFAULT);
        let [ours, oracle] = [DEFAULT, ORACLE].map(|order| share(order, WORK));
        let orders = plan().names().filter(|order| *order != CUT_OFF);
        Section::shows(
            "first-hit",
            "How soon is the first contact found?",
            "The work to the first pair of triangles that meet, over that of a depth-first search: below 1 is sooner.",
            format!(
                "{ours:.2} of the work of depth-first (worst case {value:.2}, {case}); the best order {oracle:.2}. Geometric means."
            ),
            vec![Block::Table(Table::new(header, orders.map(row).collect()))],
        )
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
        let cell = |order, limit| match limit {
            Limit::Work(percent) => [at(order, percent), worst(order, percent).value],
            Limit::Time(_) => [f64::NAN; 2],
        };
        let table = by_budget(MEAN_AND_WORST, CERTIFIED.into_iter(), &works(), cell);
        let words = in_words("", at(DEFAULT, half), worst(DEFAULT, half));
        Ok(Section::shows(
            "volume-left",
            "Where could a contact still be?",
            "A stopped query names boxes outside of which nothing was missed (its certificate). Their volume, as a share \
             of the overlap of the bounding boxes of the two meshes: 1 means that nothing is known, 0 that all is.",
            format!(
                "After {half} % of the work:{words}; depth-first {}.",
                number(at(DEPTH_FIRST, half)),
            ),
            vec![
                self.plot("volume-left", &chart)?,
                Block::Text(
                    "Mean over cases of the median over the poses at which the bounding boxes overlap; all pairs are looked \
                     for. Measured at 512 points in the overlap."
                        .into(),
                ),
                Block::Table(table),
            ],
        ))
    }
}
