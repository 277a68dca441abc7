//! The report as a page: what must hold, what was measured, and on what.

use std::path::Path;
use std::time::Duration;

use punctual::Mode;
use punctual_lab::report::{Axis, Block, Chart, Failure, Page, Picture, Section, Series, Shape, Table, Verdict, short};
use punctual_lab::statistics::{mean, quantile, sorted};

use super::confidence;
use super::contender::{CONTENDERS, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE, WARM};
use super::measure::{Limit, PERCENT};
use super::punctuality::{MICROSECONDS, UNLIMITED};
use super::summary::{
    CLOCKS, COVERAGE, DETECTED, Feature, Measurement, QUANTILES, RECALL, Stratum, Which, area, finished_time,
    first_hit, of_case, over_cases,
};

/// Draws the plots into the folder and returns the page they stand on.
pub fn page(cases: &[Measurement], folder: &Path, intro: Vec<String>) -> Result<Page, Failure> {
    let report = Report { cases, folder };
    report.overview()?;
    let sections = vec![
        report.wrong(),
        report.budget(
            "any",
            "Is there a contact?",
            Mode::Any,
            DETECTED,
            5,
            0.70,
            "of the colliding poses are detected",
        )?,
        report.budget(
            "all",
            "Which triangles meet?",
            Mode::All,
            RECALL,
            20,
            0.70,
            "of the intersecting pairs are found",
        )?,
        report.budget(
            "coverage",
            "Where do they meet?",
            Mode::All,
            COVERAGE,
            20,
            0.80,
            "of the contact regions are seen",
        )?,
        report.first_hit(),
        report.time()?,
        confidence::section(cases, |name, chart| report.plot(name, chart))?,
        report.punctuality()?,
        report.strata(),
        report.each_case(),
    ];
    Ok(Page { title: "Collision queries that are stopped: speed against error".to_owned(), intro, sections })
}

struct Report<'r> {
    cases: &'r [Measurement],
    folder: &'r Path,
}

impl Report<'_> {
    fn plot(&self, name: &str, chart: &Chart) -> Result<Block, Failure> {
        let picture = Picture::render(chart)?;
        picture.write(self.folder, name)?;
        Ok(Block::from(&picture))
    }

    /// Detection and recall in one picture, to be shown elsewhere.
    fn overview(&self) -> Result<(), Failure> {
        let mut series = vec![];
        for (mode, feature, what) in [(Mode::Any, DETECTED, "detected"), (Mode::All, RECALL, "pairs found")] {
            for order in [DEFAULT, DEPTH_FIRST, ORACLE] {
                let at = |percent| over_cases(self.cases, Which { order, mode, budget: Limit::Work(percent) }, feature);
                let points = PERCENT.map(|percent| [f64::from(percent), at(percent)]).to_vec();
                let shape = if order == ORACLE { Shape::Dashed(points) } else { Shape::Line(points) };
                series.push(Series::new(format!("{what}, {}", label(order)), series.len(), shape));
            }
        }
        let chart = Chart {
            title: "What is known when a query is stopped".to_owned(),
            x: Axis::log("work, % of a finished run that finds all"),
            y: Axis::linear("share").range(0.0..1.0),
            series,
        };
        self.plot("overview", &chart).map(drop)
    }

    fn wrong(&self) -> Section {
        let wrong: usize = self.cases.iter().map(|case| case.work.wrong.len()).sum();
        let wrong = wrong + self.cases.iter().flat_map(|case| &case.rounds).map(|round| round.wrong).sum::<usize>();
        let rows = |case: &Measurement| case.work.rows.len() + case.rounds.iter().map(|r| r.rows.len()).sum::<usize>();
        let total: usize = self.cases.iter().map(rows).sum();
        let overrun = self.cases.iter().map(|case| case.work.overrun).max().unwrap_or(0);
        Section {
            id: "wrong".into(),
            title: "Wrong answers".into(),
            claim: "Whenever a query is stopped, what it says is true.".into(),
            measured: format!(
                "{wrong} wrong in {total} stops. A budget of work is overrun by {overrun} units at most."
            ),
            verdict: verdict(wrong == 0, false),
            blocks: vec![],
        }
    }

    #[expect(clippy::too_many_arguments)]
    fn budget(
        &self,
        id: &str,
        title: &str,
        mode: Mode,
        feature: Feature,
        percent: u32,
        wanted: f64,
        what: &str,
    ) -> Result<Section, Failure> {
        let at = |order, percent| over_cases(self.cases, Which { order, mode, budget: Limit::Work(percent) }, feature);
        let mut series: Vec<Series> = vec![self.band(mode, feature)];
        for (i, order) in names().enumerate() {
            let points = PERCENT.map(|percent| [f64::from(percent), at(order, percent)]).to_vec();
            let shape =
                if [ORACLE, CUT_OFF, WARM].contains(&order) { Shape::Dashed(points) } else { Shape::Line(points) };
            series.push(Series::new(label(order), i, shape));
        }
        let chart = Chart {
            title: title.to_owned(),
            x: Axis::log("work, % of a finished run that finds all"),
            y: Axis::linear("share").range(0.0..1.0),
            series,
        };
        let header = std::iter::once("order".to_owned()).chain(PERCENT.map(|percent| format!("{percent} %")));
        let mut table = Table { header: header.collect(), rows: vec![] };
        for order in names() {
            let values = PERCENT.map(|percent| format!("{:.2}", at(order, percent)));
            table.rows.push(std::iter::once(label(order)).chain(values).collect());
        }
        let (ours, oracle) = (at(DEFAULT, percent), at(ORACLE, percent));
        let mut measured = format!(
            "{ours:.3} by the default order, {:.3} depth-first; an oracle that knows the truth reaches {oracle:.3}.",
            at(DEPTH_FIRST, percent)
        );
        if id == "all" {
            let [ours, oracle] = [DEFAULT, ORACLE].map(|order| area(self.cases, order));
            let best = best(|order| area(self.cases, order));
            measured += &format!(
                " Area under the curve {ours:.3}, regret to the oracle {:.3}; best order: {best}.",
                oracle - ours
            );
        }
        Ok(Section {
            id: id.to_owned(),
            title: title.to_owned(),
            claim: format!("With {percent} % of the work, {wanted:.2} or more {what}."),
            measured,
            verdict: verdict(ours >= wanted, false),
            blocks: vec![
                self.plot(id, &chart)?,
                Block::Text("Mean over cases, which count alike, of the mean over their colliding poses. The shaded band holds the middle half of the colliding poses of all cases under the default order.".into()),
                Block::Table(table),
            ],
        })
    }

    /// The middle half of the poses, default order.
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
        // Where an answer is yes or no, a band says nothing.
        Series::new("", 0, Shape::Band(if mode == Mode::Any { vec![] } else { PERCENT.map(bar).to_vec() }))
    }

    fn first_hit(&self) -> Section {
        let header = ["order", "less work than depth-first", "fewer BV tests"].map(str::to_owned).to_vec();
        let orders = names().filter(|order| *order != CUT_OFF);
        let row = |order| {
            std::iter::once(label(order)).chain(first_hit(self.cases, order).map(|x| format!("{x:.2}x"))).collect()
        };
        let [[ours, _], [oracle, _]] = [DEFAULT, ORACLE].map(|order| first_hit(self.cases, order));
        Section {
            id: "first-hit".into(),
            title: "How soon is the first contact found?".into(),
            claim: "The default order needs a seventh of what plain depth-first needs, or less.".into(),
            measured: format!("{ours:.2} times less work; the oracle {oracle:.2} times. (Geometric means.)"),
            verdict: verdict(ours >= 7.0, false),
            blocks: vec![Block::Table(Table { header, rows: orders.map(row).collect() })],
        }
    }

    fn time(&self) -> Result<Section, Failure> {
        let mut blocks = vec![];
        for (id, title, mode, feature) in [
            ("any-time", "Detected within a time", Mode::Any, DETECTED),
            ("all-time", "Pairs found within a time", Mode::All, RECALL),
        ] {
            let mut series = vec![];
            for (i, contender) in CONTENDERS.iter().enumerate() {
                let at = |us: u64| {
                    let budget = Limit::Time(Duration::from_micros(us));
                    over_cases(self.cases, Which { order: contender.name, mode, budget }, feature)
                };
                let points = MICROSECONDS.map(|us| [us as f64, at(us)]).to_vec();
                series.push(Series::new(label(contender.name), i, Shape::Line(points)));
            }
            let (x, y) = (Axis::log("budget, microseconds"), Axis::linear("share").range(0.0..1.0));
            blocks.push(self.plot(id, &Chart { title: title.to_owned(), x, y, series })?);
        }
        let header = ["finished query, microseconds", "any", "all"].map(str::to_owned).to_vec();
        let time = |order: &str, mode| {
            let rounds = self.cases.iter().map(|case| case.rounds.len()).min().unwrap_or(0);
            let times = sorted((0..rounds).map(|round| finished_time(self.cases, order, mode, round)));
            quantile(&times, 0.0)
        };
        let orders = CONTENDERS.iter().map(|contender| contender.name).chain([UNLIMITED]);
        let row = |order: &str| vec![label(order), short(time(order, Mode::Any)), short(time(order, Mode::All))];
        let ratio = time(DEFAULT, Mode::All) / time(UNLIMITED, Mode::All);
        blocks.push(Block::Table(Table { header, rows: orders.map(row).collect() }));
        blocks.push(Block::Text("Finished: geometric mean over cases of the mean over poses, the best of the rounds. \"No budget\" is the default without a budget, which goes depth-first.".into()));
        Ok(Section {
            id: "time".into(),
            title: "And in microseconds?".into(),
            claim: "An order is worth its queue: by a given time more is known than depth-first.".into(),
            measured: format!(
                "To the end, the default order takes {ratio:.2} times as long with its queue as without a budget."
            ),
            verdict: self.verdict_in_time(),
            blocks,
        })
    }

    /// Whether the default is ahead of depth-first at every budget of time, or at some.
    fn verdict_in_time(&self) -> Verdict {
        let ahead = |(mode, feature, us): (Mode, Feature, u64)| {
            let budget = Limit::Time(Duration::from_micros(us));
            let [ours, plain] =
                [DEFAULT, DEPTH_FIRST].map(|order| over_cases(self.cases, Which { order, mode, budget }, feature));
            ours >= plain - 0.005
        };
        let all = MICROSECONDS.iter().flat_map(|&us| [(Mode::Any, DETECTED, us), (Mode::All, RECALL, us)]);
        let ahead: Vec<bool> = all.map(ahead).collect();
        verdict(ahead.iter().all(|ahead| *ahead), ahead.contains(&true))
    }

    fn punctuality(&self) -> Result<Section, Failure> {
        let overruns = || self.cases.iter().flat_map(|case| &case.rounds).flat_map(|round| &round.overruns);
        let values = CLOCKS.map(|(_, reading)| sorted(overruns().map(|overrun| 1e6 * reading(overrun))));
        let names = ["query, wall clock", "query, CPU time", "loop that only looks at the clock, wall clock"];
        let header =
            std::iter::once("microseconds late").chain(QUANTILES.map(|(name, _)| name)).map(str::to_owned).collect();
        let row = |(name, values): (&str, &Vec<f64>)| {
            let at = |(_, fraction)| format!("{:.2}", quantile(values, fraction));
            std::iter::once(name.to_owned()).chain(QUANTILES.map(at)).collect()
        };
        let rows = names.into_iter().zip(&values).map(row).collect();
        let beyond = |values: &[f64]| {
            let tail = values.iter().filter(|late| **late > 10.0).count();
            (tail, 100.0 * tail as f64 / values.len().max(1) as f64)
        };
        let [(ours, ours_share), (loops, loop_share)] = [beyond(&values[0]), beyond(&values[2])];
        let share = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999];
        let curve =
            |values: &Vec<f64>| share.map(|share| [100.0 * (1.0 - share), quantile(values, share).max(0.01)]).to_vec();
        let series = names.iter().zip(&values).enumerate();
        let chart = Chart {
            title: "How late, and how often".to_owned(),
            x: Axis::log("% of the stopped queries that are later"),
            y: Axis::log("microseconds late"),
            series: series.map(|(i, (name, values))| Series::new(*name, i, Shape::Line(curve(values)))).collect(),
        };
        let median = quantile(&values[0], 0.5);
        Ok(Section {
            id: "late".into(),
            title: "How late is a stopped query?".into(),
            claim: "A query ends within a microsecond of its deadline; what is later, the machine did.".into(),
            measured: format!(
                "{} stops by a deadline: median {median:.2} us late, 99 % within {:.2} us ({:.2} us of CPU time). More than 10 us: {ours} \
                 queries ({ours_share:.2} %), and {loops} of the loops directly after them ({loop_share:.2} %).",
                values[0].len(),
                quantile(&values[0], 0.99),
                quantile(&values[1], 0.99),
            ),
            verdict: verdict(quantile(&values[0], 0.9) < 1.0, median < 1.0),
            blocks: vec![self.plot("late", &chart)?, Block::Table(Table { header, rows })],
        })
    }

    fn strata(&self) -> Section {
        let header = [
            "poses",
            "number",
            "undecided at 20 %",
            "any@5 %",
            "depth-first",
            "low-alpha",
            "recall@20 %",
            "depth-first",
            "low-alpha",
        ];
        let row =
            |stratum: Stratum| {
                let number: usize =
                    self.cases.iter().map(|case| case.strata.iter().filter(|s| **s == stratum).count()).sum();
                let at = |order, mode, percent, feature: Feature| {
                    let which = Which { order, mode, budget: Limit::Work(percent) };
                    let rows = self.cases.iter().flat_map(|case| {
                        case.work.rows.iter().filter(move |row| which.picks(row) && case.strata[row.pose] == stratum)
                    });
                    mean(rows.map(feature)).map_or("-".to_owned(), |value| format!("{value:.2}"))
                };
                let mut row = vec![stratum.name().to_owned(), number.to_string()];
                row.push(at(DEFAULT, Mode::Any, 20, super::summary::UNDECIDED));
                for (mode, percent, feature) in [(Mode::Any, 5, DETECTED), (Mode::All, 20, RECALL)] {
                    row.extend([DEFAULT, DEPTH_FIRST, "low-alpha"].map(|order| {
                        if stratum.collides() { at(order, mode, percent, feature) } else { "-".to_owned() }
                    }));
                }
                row
            };
        Section {
            id: "strata".into(),
            title: "Easy and hard poses".into(),
            claim: "Averages do not hide hard poses behind easy ones.".into(),
            measured: "Poses by separation and overlap, each pose counted once.".into(),
            verdict: Verdict::Holds,
            blocks: vec![Block::Table(Table {
                header: header.map(str::to_owned).to_vec(),
                rows: Stratum::ALL.map(row).to_vec(),
            })],
        }
    }

    fn each_case(&self) -> Section {
        let header = [
            "case",
            "triangles",
            "poses",
            "hits",
            "any@5 %",
            "best order",
            "recall@20 %",
            "best order",
            "coverage@20 %",
            "low-alpha loses by",
        ];
        let mut lost = 0;
        let rows = self.cases.iter().map(|case| {
            let at = |order, mode, percent, feature: Feature| {
                let which = Which { order, mode, budget: Limit::Work(percent) };
                of_case(case, case.work.rows.iter(), which, feature).unwrap_or(f64::NAN)
            };
            let any = |order| at(order, Mode::Any, 5, DETECTED);
            let all = |order| at(order, Mode::All, 20, RECALL);
            let loss = all(DEFAULT) - all("low-alpha");
            lost += usize::from(loss > 0.0);
            vec![
                case.name.clone(),
                format!("{} x {}", case.triangles[0], case.triangles[1]),
                case.strata.len().to_string(),
                case.hits().to_string(),
                format!("{:.2}", any(DEFAULT)),
                best(any).to_owned(),
                format!("{:.2}", all(DEFAULT)),
                best(all).to_owned(),
                format!("{:.2}", at(DEFAULT, Mode::All, 20, COVERAGE)),
                format!("{loss:.2}"),
            ]
        });
        let rows: Vec<_> = rows.collect();
        Section {
            id: "cases".into(),
            title: "Which order wins where, and where low alpha loses".into(),
            claim: "The default order is ahead of the paper's low alpha first.".into(),
            measured: format!("More recall at 20 % of the work in {lost} of {} cases.", rows.len()),
            verdict: verdict(lost == rows.len(), lost > 0),
            blocks: vec![Block::Table(Table { header: header.map(str::to_owned).to_vec(), rows })],
        }
    }
}

fn verdict(holds: bool, in_part: bool) -> Verdict {
    match (holds, in_part) {
        (true, _) => Verdict::Holds,
        (false, true) => Verdict::HoldsInPart,
        (false, false) => Verdict::DoesNotHold,
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    CONTENDERS.iter().map(|contender| contender.name).chain([ORACLE, CUT_OFF, WARM])
}

fn label(order: &str) -> String {
    match order {
        DEFAULT => format!("{order} (default)"),
        CUT_OFF => "plain query, cut off".to_owned(),
        WARM => "default, warm start".to_owned(),
        _ => order.to_owned(),
    }
}

/// The order of the engine with the largest value, the first of equals.
fn best(value: impl Fn(&'static str) -> f64) -> &'static str {
    let names = CONTENDERS.iter().map(|contender| contender.name);
    names.reduce(|best, name| if value(name) > value(best) { name } else { best }).unwrap_or(DEFAULT)
}
