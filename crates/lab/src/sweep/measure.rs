//! What a stopped query is worth: the features of one stop, and the runs under budgets of work that give them.

use std::time::Duration;

use punctual::intersection::Intersection;
use punctual::prediction::Estimate;
use punctual::{Budget, Certificate, Mode, PairMemory, Query, StopReason, Verdict, Workspace};

use super::case::Case;
use super::confidence::Guess;
use super::contender::{CERTIFIED, CUT_OFF, DEFAULT, DEPTH_FIRST, ORACLE, WARM};
use super::open::{self, Overlap};
use super::oracle::Oracle;
use super::plan::plan;
use super::truth::Truth;

/// The features of one query at the moment its budget ended.
#[derive(Clone, Copy)]
pub struct Row {
    pub pose: usize,
    pub order: &'static str,
    pub mode: Mode,
    pub budget: Limit,
    pub verdict: Answer,
    /// Share of the intersecting pairs found; 1 where there are none.
    pub recall: f64,
    /// Share of the contact regions with a pair found; 1 where there are none.
    pub coverage: f64,
    /// Longest edge of a box in which pairs may be missing, in the box diagonal of the smaller mesh. Not a number for
    /// baselines that are derived.
    pub unresolved: f64,
    /// Volume of these boxes over that of the overlap of the meshes' boxes. Measured for some, else not a number.
    pub volume_left: f64,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    /// Percent of what a finished depth-first `all` run costs at the same pose.
    Work(u32),
    Time(Duration),
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Answer {
    Detected,
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
    pub mode: Mode,
    pub work: u64,
    pub bv_tests: u64,
}

/// What a case gave under budgets of work.
#[derive(Default)]
pub struct Measured {
    pub rows: Vec<Row>,
    pub finished: Vec<Finished>,
    /// What the default order told of its rest.
    pub guesses: Vec<Guess>,
    /// Most work beyond a budget.
    pub overrun: u64,
    /// What differs from the truth, in words.
    pub wrong: Vec<String>,
    /// Certificates, and what is false in them, in words.
    pub certificates: usize,
    pub loose: Vec<String>,
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

    pub fn recall(&self) -> f64 {
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

    pub fn coverage(&self) -> f64 {
        share(
            self.seen_regions.iter().filter(|seen| **seen).count(),
            self.truth.regions,
        )
    }

    /// What the outcome says, if that is true.
    pub fn answer(&self, outcome: &punctual::Answer<Verdict>, mode: Mode) -> Answer {
        let complete = outcome.stop != StopReason::Finished
            || mode == Mode::Any
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

fn share(part: usize, whole: usize) -> f64 {
    if whole == 0 {
        1.0
    } else {
        part as f64 / whole as f64
    }
}

/// Runs every contender at every pose, in both modes, through all budgets of work to the end.
pub fn case(case: &Case, truth: &[Truth], mut progress: impl FnMut() -> bool) -> Option<Measured> {
    let mut measured = Measured::default();
    let mut workspace = Workspace::with_capacity(4096, 1 << 16);
    let mut memories = [PairMemory::new(), PairMemory::new()];
    for (pose, truth) in truth.iter().enumerate() {
        let full = Query::all_pairs(&case.a, &case.b, case.poses[pose]).plain();
        let full = finish(&full, &mut workspace);
        let run = Run {
            case,
            truth,
            pose,
            full,
            overlap: Overlap::new(case, &case.poses[pose]),
        };
        for contender in plan().contenders() {
            let query = contender.query(&case.a, &case.b, case.poses[pose]);
            for mode in [Mode::Any, Mode::All] {
                run.stops(
                    &query.mode(mode),
                    contender.name,
                    mode,
                    None,
                    &mut workspace,
                    &mut measured,
                );
            }
        }
        let query = Query::intersection(&case.a, &case.b, case.poses[pose]);
        for (mode, memory) in [Mode::Any, Mode::All].into_iter().zip(&mut memories) {
            run.stops(
                &query.mode(mode),
                WARM,
                mode,
                Some(memory),
                &mut workspace,
                &mut measured,
            );
        }
        run.oracle(
            &Oracle::new(&case.a, &case.b, &case.poses[pose], &truth.pairs),
            &mut measured,
        );
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
            return None;
        }
    }
    Some(measured)
}

/// Goes on with a query until it has done work up to `limit`, however often the pair buffer fills.
fn advance(
    query: &Query<Intersection>,
    workspace: &mut Workspace,
    mut memory: Option<&mut PairMemory>,
    mut outcome: punctual::Answer<Verdict>,
    limit: u64,
    mut report: impl FnMut([u32; 2]),
) -> punctual::Answer<Verdict> {
    loop {
        let budget = Budget::work(limit.saturating_sub(outcome.stats.work));
        match query
            .with_memory(memory.as_deref_mut())
            .resume(workspace, budget)
        {
            Ok(next) => outcome = next,
            Err(_) => return outcome,
        }
        workspace.drain_pairs().for_each(&mut report);
        if outcome.stop != StopReason::PairsFull {
            return outcome;
        }
    }
}

/// Work of a finished run.
fn finish(query: &Query<Intersection>, workspace: &mut Workspace) -> u64 {
    let outcome = query.run(workspace, Budget::work(0));
    advance(query, workspace, None, outcome, u64::MAX, drop)
        .stats
        .work
}

/// A pose of a case, with the work of a finished `all` run.
struct Run<'c> {
    case: &'c Case,
    truth: &'c Truth,
    pose: usize,
    full: u64,
    overlap: Overlap,
}

impl Run<'_> {
    /// One query, stopped at every budget and resumed, which by the promise of the library gives the bits of a run with
    /// that budget alone.
    fn stops(
        &self,
        query: &Query<Intersection>,
        order: &'static str,
        mode: Mode,
        mut memory: Option<&mut PairMemory>,
        workspace: &mut Workspace,
        measured: &mut Measured,
    ) {
        let mut judge = Judge::new(self.truth);
        let tells = [DEFAULT, WARM].contains(&order);
        let mut guesses = vec![];
        let guess = Guess {
            pose: self.pose,
            order,
            mode,
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
                limit,
                |pair| judge.report(pair),
            );
            let answer = judge.answer(&outcome, mode);
            if answer == Answer::Wrong {
                let at = percent.map_or("finished".to_owned(), |percent| format!("{percent} %"));
                measured.wrong.push(format!(
                    "{} pose {} {order} {mode:?} {at}: wrong",
                    self.case.name, self.pose
                ));
            }
            let Some(percent) = percent else { continue };
            if outcome.stop == StopReason::WorkLimit {
                measured.overrun = measured
                    .overrun
                    .max(outcome.stats.work.saturating_sub(limit));
            }
            let stopped =
                outcome.stop != StopReason::Finished && outcome.stop != StopReason::FirstHit;
            let (extent, volume_left) = match query.certificate(workspace) {
                Ok(certificate) => self.check(&certificate, &judge, order, mode, measured),
                Err(_) => (f64::NAN, f64::NAN),
            };
            if tells
                && stopped
                && let Ok(told) = query.estimate(workspace, memory.as_deref())
            {
                guesses.push(guessed(
                    Guess { percent, ..guess },
                    &told,
                    &outcome,
                    judge.recall(),
                ));
            }
            let row = Row {
                pose: self.pose,
                order,
                mode,
                budget: Limit::Work(percent),
                verdict: answer,
                recall: judge.recall(),
                coverage: judge.coverage(),
                unresolved: if stopped {
                    extent / self.case.size()
                } else {
                    0.0
                },
                volume_left,
            };
            measured.rows.push(row);
            if order == DEPTH_FIRST {
                measured.rows.push(cut_off(row, stopped));
            }
        }
        let (work, bv_tests) = (outcome.stats.work, outcome.stats.bv_tests);
        let error = |told: f64| (told.max(1.0) / (bv_tests as f64).max(1.0)).log2();
        measured.guesses.extend(guesses.into_iter().map(|g| Guess {
            total_error: error(g.total_error),
            ..g
        }));
        measured.finished.push(Finished {
            pose: self.pose,
            order,
            mode,
            work,
            bv_tests,
        });
    }

    /// Compares what the certificate promises with the truth. Returns the longest edge of its boxes, and for some queries
    /// the volume left.
    fn check(
        &self,
        certificate: &Certificate,
        judge: &Judge,
        order: &'static str,
        mode: Mode,
        measured: &mut Measured,
    ) -> (f64, f64) {
        measured.certificates += 1;
        // Another one at each stop.
        let missing = judge.missing(measured.certificates);
        if let Some(what) = open::fault(certificate, self.case, self.pose, self.truth, missing) {
            measured.loose.push(format!(
                "{} pose {} {order} {mode:?}: {what}",
                self.case.name, self.pose
            ));
        }
        let shown = mode == Mode::All && CERTIFIED.contains(&order);
        let volume_left = if shown {
            self.overlap.volume_left(certificate)
        } else {
            f64::NAN
        };
        (certificate.largest_extent(), volume_left)
    }

    fn oracle(&self, oracle: &Oracle, measured: &mut Measured) {
        let mut judge = Judge::new(self.truth);
        let mut found = oracle.found.iter().peekable();
        let hit = !self.truth.pairs.is_empty();
        for percent in plan().percent() {
            let limit = (self.full * u64::from(percent)).div_ceil(100);
            while let Some((_, at)) = found.next_if(|(work, _)| *work <= limit) {
                judge.see(*at as usize);
            }
            for mode in [Mode::Any, Mode::All] {
                let detected = hit && oracle.last_step < limit;
                let verdict = if detected {
                    Answer::Detected
                } else if percent == 100 {
                    Answer::Separated
                } else {
                    Answer::Undecided
                };
                measured.rows.push(Row {
                    pose: self.pose,
                    order: ORACLE,
                    mode,
                    budget: Limit::Work(percent),
                    verdict,
                    recall: judge.recall(),
                    coverage: judge.coverage(),
                    unresolved: f64::NAN,
                    volume_left: f64::NAN,
                });
            }
        }
        if hit {
            let [work, bv_tests] = oracle.first_hit;
            measured.finished.push(Finished {
                pose: self.pose,
                order: ORACLE,
                mode: Mode::Any,
                work,
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
        recall_error: (guess.mode == Mode::All).then_some(told.recall - recall),
        total_error: outcome.stats.bv_tests as f64 + told.remaining.bv_tests.p50,
        ..guess
    }
}

/// What is left of a row if nothing is told before the end.
pub fn cut_off(row: Row, stopped: bool) -> Row {
    let known = |share: f64| if stopped { 0.0 } else { share };
    let (recall, coverage) = (known(row.recall), known(row.coverage));
    let verdict = if stopped {
        Answer::Undecided
    } else {
        row.verdict
    };
    Row {
        order: CUT_OFF,
        recall,
        coverage,
        verdict,
        unresolved: f64::NAN,
        volume_left: f64::NAN,
        ..row
    }
}
