//! What a stopped query is worth: the features of one stop, and the runs under budgets of work that give them.

use std::time::Duration;

use punctual::intersection::Intersection;
use punctual::prediction::Estimate;
use punctual::{Budget, Certificate, Mode, PairMemory, Query, StopReason, Verdict, Workspace};

use crate::traversal::advance;

use super::case::Case;
use super::confidence::Guess;
use super::contender::{CERTIFIED, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE, WARM};
use super::open::{self, Overlap};
use super::oracle::Oracle;
use super::plan::plan;
use super::punctuality::Overrun;
use super::truth::Truth;

/// What is asked of two meshes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Asked {
    /// Whether they meet.
    Any,
    /// Which triangles do.
    All,
    /// How far apart they are, at poses at which they are apart.
    Distance,
}

/// The questions about intersections, as the engine has them.
pub const MODES: [(Asked, Mode); 2] = [(Asked::Any, Mode::Any), (Asked::All, Mode::All)];

/// The features of one query at the moment its budget ended; not a number where they are not measured.
#[derive(Clone, Copy)]
pub struct Row {
    pub pose: usize,
    pub order: &'static str,
    pub asked: Asked,
    pub budget: Limit,
    pub verdict: Answer,
    /// Share of the intersecting pairs found; 1 where there are none.
    pub recall: f64,
    /// Share of the contact regions with a pair found; 1 where there are none.
    pub coverage: f64,
    /// Longest edge of a box in which pairs may be missing, in the box diagonal of the smaller mesh.
    pub unresolved: f64,
    /// Volume of these boxes over that of the overlap of the meshes' boxes.
    pub volume_left: f64,
    /// Bounds of the distance over the true one.
    pub low: f64,
    pub high: f64,
}

impl Row {
    pub fn new(
        pose: usize,
        order: &'static str,
        asked: Asked,
        budget: Limit,
        verdict: Answer,
    ) -> Self {
        let none = f64::NAN;
        Self {
            pose,
            order,
            asked,
            budget,
            verdict,
            recall: none,
            coverage: none,
            unresolved: none,
            volume_left: none,
            low: none,
            high: none,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    /// Percent of what a finished depth-first query, for `all` or for the distance, costs at the same pose.
    Work(u32),
    Time(Duration),
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Answer {
    Detected,
    /// Of a distance: as close as was asked for.
    Separated,
    Undecided,
    /// Said, and not true.
    Wrong,
}

/// A run to the end.
#[derive(Clone, Copy)]
pub struct Finished {
    pub pose: usize,
    pub order: &'static str,
    pub asked: Asked,
    /// Work, for a distance over that of depth-first; or seconds.
    pub cost: f64,
    pub bv_tests: f64,
}

/// What a case gave under budgets of work.
#[derive(Default)]
pub struct Measured {
    pub rows: Vec<Row>,
    pub finished: Vec<Finished>,
    /// For each order and pose apart the work, over that of depth-first, with which each goal of a
    /// distance is reached.
    pub reached: Vec<(&'static str, [f64; 2])>,
    /// What the default order told of its rest.
    pub guesses: Vec<Guess>,
    /// Most work beyond a budget, of queries for intersections and for distances.
    pub overruns: [u64; 2],
    /// Comparisons of distances with the truth.
    pub distances: usize,
    /// What differs from the truth, in words.
    pub wrong: Vec<String>,
    /// Certificates, and what is false in them, in words.
    pub certificates: usize,
    pub loose: Vec<String>,
}

/// What is known under budgets of time in one round over all poses of a case, in order, so that no query
/// finds its own tracks in the caches.
#[derive(Default)]
pub struct Round {
    pub rows: Vec<Row>,
    /// Of the default order, where the deadline ended it.
    pub overruns: Vec<Overrun>,
    pub finished: Vec<Finished>,
    pub wrong: usize,
}

/// Progress of a query against the truth.
pub struct Judge<'t> {
    truth: &'t Truth,
    seen: Vec<bool>,
    seen_regions: Vec<bool>,
    found: usize,
    false_pairs: usize,
}

impl<'t> Judge<'t> {
    pub fn new(truth: &'t Truth) -> Self {
        Self {
            truth,
            seen: vec![false; truth.pairs.len()],
            seen_regions: vec![false; truth.regions],
            found: 0,
            false_pairs: 0,
        }
    }

    /// Takes note of a pair that the query reports. One that is not true, or comes twice, is false.
    pub fn report(&mut self, pair: [u32; 2]) {
        match self.truth.pairs.binary_search(&pair) {
            Ok(at) if !self.seen[at] => self.see(at),
            _ => self.false_pairs += 1,
        }
    }

    fn see(&mut self, at: usize) {
        self.seen[at] = true;
        self.seen_regions[self.truth.region[at] as usize] = true;
        self.found += 1;
    }

    fn recall(&self) -> f64 {
        share(self.found, self.truth.pairs.len())
    }

    /// An intersecting pair that was not reported: the first after `start`, cyclically.
    fn missing(&self, start: usize) -> Option<[u32; 2]> {
        let count = self.seen.len();
        let indices = (0..count).map(|i| (start + i) % count);
        indices
            .into_iter()
            .find(|&i| !self.seen[i])
            .map(|i| self.truth.pairs[i])
    }

    fn coverage(&self) -> f64 {
        share(
            self.seen_regions.iter().filter(|seen| **seen).count(),
            self.truth.regions,
        )
    }

    /// What the outcome says, if that is true.
    pub fn answer(&self, outcome: &punctual::Answer<Verdict>, asked: Asked) -> Answer {
        let complete = outcome.stop != StopReason::Finished
            || asked == Asked::Any
            || self.found == self.truth.pairs.len();
        let truth = !self.truth.pairs.is_empty();
        match outcome.value {
            _ if self.false_pairs > 0 || !complete => Answer::Wrong,
            Verdict::Intersecting { witness }
                if self.truth.pairs.binary_search(&witness).is_ok() =>
            {
                Answer::Detected
            }
            Verdict::Separated if !truth => Answer::Separated,
            Verdict::Undecided => Answer::Undecided,
            _ => Answer::Wrong,
        }
    }
}

impl Row {
    /// With the progress of its query.
    pub fn with(self, judge: &Judge) -> Self {
        let (recall, coverage) = (judge.recall(), judge.coverage());
        Self {
            recall,
            coverage,
            ..self
        }
    }
}

fn share(part: usize, whole: usize) -> f64 {
    if whole == 0 {
        1.0
    } else {
        part as f64 / whole as f64
    }
}

/// Runs every contender at every pose, for both questions, through all budgets of work to the end. False
/// if `progress`, called after each pose, says stop.
pub fn case(
    case: &Case,
    truth: &[Truth],
    measured: &mut Measured,
    mut progress: impl FnMut() -> bool,
) -> bool {
    let mut workspace = Workspace::with_capacity(4096, 1 << 16);
    let mut memories = [PairMemory::new(), PairMemory::new()];
    for (pose, truth) in truth.iter().enumerate() {
        let full = Query::all_pairs(&case.a, &case.b, case.poses[pose]).plain();
        let full = finish(&full, &mut workspace);
        let overlap = Overlap::new(case, &case.poses[pose]);
        let mut run = Run {
            case,
            truth,
            pose,
            full,
            overlap,
            measured,
        };
        for contender in plan().contenders() {
            let query = contender.query(&case.a, &case.b, case.poses[pose]);
            for (asked, mode) in MODES {
                run.stops(
                    &query.mode(mode),
                    contender.name,
                    asked,
                    None,
                    &mut workspace,
                );
            }
        }
        let query = Query::intersection(&case.a, &case.b, case.poses[pose]);
        for ((asked, mode), memory) in MODES.into_iter().zip(&mut memories) {
            run.stops(&query.mode(mode), WARM, asked, Some(memory), &mut workspace);
        }
        run.oracle();
        if let Some(&known) = case.known.get(pose)
            && known != truth.pairs.len() as u64
        {
            let pairs = truth.pairs.len();
            measured.wrong.push(format!(
                "{} pose {pose}: {pairs} pairs, but truth.csv has {known}",
                case.name
            ));
        }
        if !progress() {
            return false;
        }
    }
    true
}

/// Work of a finished run.
fn finish(query: &Query<Intersection>, workspace: &mut Workspace) -> u64 {
    let outcome = query.run(workspace, Budget::work(0));
    advance(query, workspace, None, outcome, Some(u64::MAX), drop)
        .stats
        .work
}

/// A pose of a case, with the work of a finished `all` run, and where what it gives is noted.
struct Run<'c> {
    case: &'c Case,
    truth: &'c Truth,
    pose: usize,
    full: u64,
    overlap: Overlap,
    measured: &'c mut Measured,
}

impl Run<'_> {
    /// One query, stopped at every budget and resumed, which by the promise of the library gives the bits of a run with
    /// that budget alone.
    fn stops(
        &mut self,
        query: &Query<Intersection>,
        order: &'static str,
        asked: Asked,
        mut memory: Option<&mut PairMemory>,
        workspace: &mut Workspace,
    ) {
        let mut judge = Judge::new(self.truth);
        let tells = [DEFAULT, WARM].contains(&order);
        let mut guesses = vec![];
        let guess = Guess {
            pose: self.pose,
            order,
            asked,
            percent: 0,
            probability: None,
            recall_error: None,
            total_error: 0.0,
        };
        if tells {
            guesses.push(Guess {
                total_error: query.predict(memory.as_deref()).bv_tests.p50,
                ..guess
            });
        }
        let mut outcome = query
            .with_memory(memory.as_deref_mut())
            .run(workspace, Budget::work(0));
        for percent in plan().percent().map(Some).chain([None]) {
            let limit = percent.map_or(u64::MAX, |percent| {
                (self.full * u64::from(percent)).div_ceil(100)
            });
            outcome = advance(
                query,
                workspace,
                memory.as_deref_mut(),
                outcome,
                Some(limit),
                |pair| judge.report(pair),
            );
            let verdict = judge.answer(&outcome, asked);
            if verdict == Answer::Wrong {
                let at = percent.map_or("finished".to_owned(), |percent| format!("{percent} %"));
                self.measured.wrong.push(format!(
                    "{} pose {} {order} {asked:?} {at}: wrong",
                    self.case.name, self.pose
                ));
            }
            let Some(percent) = percent else { continue };
            if outcome.stop == StopReason::WorkLimit {
                let overrun = &mut self.measured.overruns[0];
                *overrun = outcome.stats.work.saturating_sub(limit).max(*overrun);
            }
            let is_stopped =
                outcome.stop != StopReason::Finished && outcome.stop != StopReason::FirstHit;
            let mut row =
                Row::new(self.pose, order, asked, Limit::Work(percent), verdict).with(&judge);
            if let Ok(certificate) = query.certificate(workspace) {
                self.check(&certificate, &judge, &mut row);
            }
            if !is_stopped {
                row.unresolved = 0.0;
            }
            if tells
                && is_stopped
                && let Ok(told) = query.estimate(workspace, memory.as_deref())
            {
                guesses.push(guessed(
                    Guess { percent, ..guess },
                    &told,
                    &outcome,
                    judge.recall(),
                ));
            }
            self.measured.rows.push(row);
            if order == DEPTH_FIRST {
                self.measured.rows.push(cut_off(row, is_stopped));
            }
        }
        let bv_tests = outcome.stats.bv_tests as f64;
        let error = |told: f64| (told.max(1.0) / bv_tests.max(1.0)).log2();
        self.measured
            .guesses
            .extend(guesses.into_iter().map(|guess| Guess {
                total_error: error(guess.total_error),
                ..guess
            }));
        self.measured.finished.push(Finished {
            pose: self.pose,
            order,
            asked,
            cost: outcome.stats.work as f64,
            bv_tests,
        });
    }

    /// Compares what the certificate promises with the truth, and notes how much room it leaves.
    fn check(&mut self, certificate: &Certificate, judge: &Judge, row: &mut Row) {
        let Row {
            pose, order, asked, ..
        } = *row;
        self.measured.certificates += 1;
        // Another one at each stop.
        let missing = judge.missing(self.measured.certificates);
        if let Some(what) = open::fault(certificate, self.case, pose, self.truth, missing) {
            self.measured.loose.push(format!(
                "{} pose {pose} {order} {asked:?}: {what}",
                self.case.name
            ));
        }
        if asked == Asked::All && CERTIFIED.contains(&order) {
            row.volume_left = self.overlap.volume_left(certificate);
        }
        row.unresolved = certificate.largest_extent() / self.case.size();
    }

    /// The best order, computed from the truth.
    fn oracle(&mut self) {
        let Case { a, b, poses, .. } = self.case;
        let oracle = Oracle::new(a, b, &poses[self.pose], &self.truth.pairs);
        let mut judge = Judge::new(self.truth);
        let mut found = oracle.found.iter().peekable();
        let hit = !self.truth.pairs.is_empty();
        for percent in plan().percent() {
            let limit = (self.full * u64::from(percent)).div_ceil(100);
            while let Some((_, at)) = found.next_if(|(work, _)| *work <= limit) {
                judge.see(*at as usize);
            }
            let verdict = if hit && oracle.last_step < limit {
                Answer::Detected
            } else if percent == 100 {
                Answer::Separated
            } else {
                Answer::Undecided
            };
            for (asked, _) in MODES {
                let row = Row::new(self.pose, ORACLE, asked, Limit::Work(percent), verdict);
                self.measured.rows.push(row.with(&judge));
            }
        }
        if hit {
            let [cost, bv_tests] = oracle.first_hit.map(|count| count as f64);
            self.measured.finished.push(Finished {
                pose: self.pose,
                order: ORACLE,
                asked: Asked::Any,
                cost,
                bv_tests,
            });
        }
    }
}

/// A guess with what a stopped query tells. The error is the told BV tests of the whole query until the true ones are known.
fn guessed(
    guess: Guess,
    told: &Estimate,
    outcome: &punctual::Answer<Verdict>,
    recall: f64,
) -> Guess {
    Guess {
        probability: (outcome.stats.found == 0).then_some(told.probability),
        recall_error: (guess.asked == Asked::All).then_some(told.recall - recall),
        total_error: outcome.stats.bv_tests as f64 + told.remaining.bv_tests.p50,
        ..guess
    }
}

/// What is left of a row if nothing is told before the end.
pub fn cut_off(row: Row, is_stopped: bool) -> Row {
    let known = |share: f64| if is_stopped { 0.0 } else { share };
    let verdict = if is_stopped {
        Answer::Undecided
    } else {
        row.verdict
    };
    Row {
        recall: known(row.recall),
        coverage: known(row.coverage),
        ..Row::new(row.pose, CUT_OFF, row.asked, row.budget, verdict)
    }
}
