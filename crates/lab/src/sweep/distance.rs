//! Distance queries that are stopped: how close their bounds are to the true distance.

use std::time::Instant;

use punctual::clock::SystemClock;
use punctual::distance::{Bounds, Distance};
use punctual::{Budget, PairMemory, Query, StopReason, Workspace};

use super::case::Case;
use super::contender::DEPTH_FIRST;
use super::measure::{Answer, Asked, Finished, Limit, Measured, Round, Row};
use super::plan::plan;
use super::summary::GOALS;
use super::truth::Truth;
use crate::approach::diagonal;

/// The library as it comes.
pub const OURS: &str = "nearest-first";

/// The same, told the closest triangles: what it takes to prove that no others are closer, which no search can avoid.
pub const TOLD: &str = "told";

pub const ORDERS: [&str; 3] = [OURS, DEPTH_FIRST, TOLD];

/// The true distances of a case.
pub struct Truths<'c> {
    case: &'c Case,
    /// Of each pose, as bounds: of a distance that is known they are the same.
    bounds: Vec<[f64; 2]>,
    /// For each pose the memory of a finished query.
    memories: Vec<PairMemory>,
}

impl<'c> Truths<'c> {
    /// From the file of the case, or by a finished query without tolerance.
    pub fn new(case: &'c Case, truth: &[Truth], measured: &mut Measured) -> Self {
        let mut workspace = Workspace::new();
        let (mut bounds, mut memories) = (Vec::new(), Vec::new());
        for (pose, truth) in truth.iter().enumerate() {
            // What is told are the closest triangles, and nothing that would be proven at once.
            let mut memory = PairMemory::without_clearance();
            let query = query(case, pose, OURS).absolute_tolerance(0.0);
            let Bounds { low, high, .. } = query
                .with_memory(&mut memory)
                .run(&mut workspace, Budget::unlimited())
                .value;
            let known = case.distances.get(pose).map(|&distance| [distance; 2]);
            let [least, most] = known.unwrap_or([low, high]);
            measured.distances += 1;
            let met = truth.pairs.len();
            if !within([low, high], [least, most], case) || (high == 0.0) != (met > 0) {
                let said = format!(
                    "{} pose {pose}: said to be {low} to {high} apart",
                    case.name
                );
                measured.wrong.push(format!(
                    "{said}, is {least}, and {met} pairs of triangles meet"
                ));
            }
            bounds.push([least, most]);
            memories.push(memory);
        }
        Self {
            case,
            bounds,
            memories,
        }
    }

    /// Whether the surfaces are apart, by a distance that others can be compared with.
    fn is_apart(&self, pose: usize) -> bool {
        let [low, high] = self.bounds[pose];
        low > 0.0 && high.is_finite()
    }

    /// Through each percent of the work of a finished depth-first query to the end, all orders at all poses.
    pub fn work(&self, measured: &mut Measured) {
        let mut workspace = Workspace::new();
        for pose in (0..self.bounds.len()).filter(|&pose| self.is_apart(pose)) {
            let full = query(self.case, pose, DEPTH_FIRST)
                .run(&mut workspace, Budget::unlimited())
                .stats
                .work;
            for order in ORDERS {
                self.stops(pose, order, full, &mut workspace, measured);
            }
        }
    }

    /// One query, stopped and resumed, which by the promise of the library gives the bits of a run with that budget alone.
    fn stops(
        &self,
        pose: usize,
        order: &'static str,
        full: u64,
        workspace: &mut Workspace,
        measured: &mut Measured,
    ) {
        let (query, clock) = (query(self.case, pose, order), SystemClock::default());
        let mut memory = self.memory(pose, order);
        let mut said = query
            .with_memory(memory.as_mut())
            .run(workspace, Budget::work(0).clock(&clock));
        let mut goals = [f64::NAN; 2];
        for percent in (1..=100).map(Some).chain([None]) {
            let limit = percent.map_or(u64::MAX, |percent| {
                (full * u64::from(percent)).div_ceil(100)
            });
            let budget = Budget::work(limit.saturating_sub(said.stats.work));
            said = query
                .with_memory(memory.as_mut())
                .resume(workspace, budget.clock(&clock))
                .unwrap_or(said);
            let done = said.stats.work as f64 / full as f64;
            let row = self.judge(
                pose,
                order,
                Limit::Work(percent.unwrap_or(0)),
                &said,
                measured,
            );
            for (reached, (_, goal)) in goals.iter_mut().zip(GOALS) {
                if goal(&row) == 1.0 && reached.is_nan() {
                    *reached = done;
                }
            }
            let Some(percent) = percent else {
                measured.finished.push(Finished {
                    pose,
                    order,
                    asked: Asked::Distance,
                    cost: done,
                    bv_tests: f64::NAN,
                });
                continue;
            };
            if said.stop == StopReason::WorkLimit {
                let overrun = &mut measured.overruns[1];
                *overrun = said.stats.work.saturating_sub(limit).max(*overrun);
            }
            if plan().percent().any(|chosen| chosen == percent) {
                measured.rows.push(row);
            }
        }
        measured.reached.push((order, goals));
    }

    /// All orders, within each budget of time, at up to so many poses; a pass over the poses for each budget.
    pub fn round(&self, most: usize, measured: &mut Measured) -> Round {
        let clock = SystemClock::default();
        let mut workspace = Workspace::new();
        let mut round = Round::default();
        let apart: Vec<usize> = (0..self.bounds.len())
            .filter(|&pose| self.is_apart(pose))
            .collect();
        let most = most.min(apart.len());
        let poses: Vec<usize> = (0..most).map(|i| apart[i * apart.len() / most]).collect();
        for order in ORDERS {
            let mut timed = |pose: usize, budget: Budget| {
                let mut memory = self.memory(pose, order);
                let start = Instant::now();
                let said = query(self.case, pose, order)
                    .with_memory(memory.as_mut())
                    .run(&mut workspace, budget.clock(&clock));
                (said, start.elapsed().as_secs_f64())
            };
            let finished = poses.iter().map(|&pose| Finished {
                pose,
                order,
                asked: Asked::Distance,
                cost: timed(pose, Budget::unlimited()).1,
                bv_tests: f64::NAN,
            });
            round.finished.extend(finished);
            for limit in plan().times() {
                for &pose in &poses {
                    let (said, _) = timed(pose, Budget::time(limit));
                    let row = self.judge(pose, order, Limit::Time(limit), &said, measured);
                    round.rows.push(row);
                }
            }
        }
        round
    }

    fn memory(&self, pose: usize, order: &str) -> Option<PairMemory> {
        (order == TOLD).then(|| self.memories[pose].clone())
    }

    /// Compares what is said with the truth.
    fn judge(
        &self,
        pose: usize,
        order: &'static str,
        budget: Limit,
        said: &punctual::Answer<Bounds>,
        measured: &mut Measured,
    ) -> Row {
        let (truth, Bounds { low, high, .. }) = (self.bounds[pose], said.value);
        measured.distances += 1;
        if !within([low, high], truth, self.case) {
            let what = format!(
                "{} pose {pose} {order}: said to be {low} to {high} apart, is {}",
                self.case.name, truth[0]
            );
            measured.wrong.push(what);
        }
        let verdict = if said.stop == StopReason::Finished {
            Answer::Separated
        } else {
            Answer::Undecided
        };
        Row {
            low: low / truth[1],
            high: high / truth[1],
            ..Row::new(pose, order, Asked::Distance, budget, verdict)
        }
    }
}

/// Whether bounds hold a distance that is itself known by bounds, and up to its rounding.
fn within([low, high]: [f64; 2], [least, most]: [f64; 2], case: &Case) -> bool {
    let error = 1e-13 * (diagonal(case.a.mesh()) + diagonal(case.b.mesh()) + most);
    least == f64::INFINITY || low <= most + error && least <= high + error
}

fn query<'c>(case: &'c Case, pose: usize, order: &str) -> Query<'c, Distance> {
    let query = Query::distance(&case.a, &case.b, case.poses[pose]);
    if order == DEPTH_FIRST {
        query.depth_first()
    } else {
        query
    }
}
