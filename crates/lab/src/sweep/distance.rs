//! Distance queries that are stopped: how close their bounds are to the true distance.

pub mod summary;

use std::time::{Duration, Instant};

use punctual::clock::SystemClock;
use punctual::distance::{Bounds, Distance};
use punctual::{Answer, Budget, PairMemory, Query, StopReason, Workspace};

use super::case::{Case, size};
use super::contender::DEPTH_FIRST;
use super::plan::plan;
use super::truth::Truth;

/// The library as it comes.
pub const OURS: &str = "nearest-first";

/// The same, told the closest triangles: what it takes to prove that no others are closer, which no search can avoid.
pub const TOLD: &str = "told";

pub const ORDERS: [&str; 3] = [OURS, DEPTH_FIRST, TOLD];

/// By how much a bound may be off to count as near; 10 % where it is put in words.
const NEAR: f64 = 0.1;

/// What is known when a query is stopped; bounds over the true distance.
#[derive(Clone, Copy)]
pub struct Stop {
    pub low: f64,
    pub high: f64,
    /// As close as was asked for.
    pub finished: bool,
}

impl Stop {
    pub fn is_high_near(&self) -> bool {
        self.finished || self.high <= 1.0 + NEAR
    }

    pub fn is_proven(&self) -> bool {
        self.finished || self.high <= (1.0 + NEAR) * self.low
    }
}

/// A query at a pose at which the surfaces are apart, stopped at each budget.
pub struct Run {
    pub pose: usize,
    pub order: &'static str,
    /// At each percent of the work of a finished depth-first query, 1 to 100, or at each budget of time.
    pub stops: Vec<Stop>,
    /// Work, in that unit, or seconds to the end of the query.
    pub whole: f64,
    /// Work, in that unit, until the upper bound is near the distance, and until the bounds are near each other.
    pub reached: [f64; 2],
}

/// What distance queries gave in a case.
#[derive(Default)]
pub struct Measured {
    pub runs: Vec<Run>,
    pub rounds: Vec<Vec<Run>>,
    pub stops: usize,
    /// Most work beyond a budget.
    pub overrun: u64,
    /// What differs from the truth, in words.
    pub wrong: Vec<String>,
}

/// All of a case: budgets of work at all poses, then rounds of budgets of time at up to so many.
pub fn case(case: &Case, truth: &[Truth], rounds: u64, poses: usize) -> Measured {
    let mut measured = Measured::default();
    let truths = Truths::new(case, truth, &mut measured);
    truths.work(&mut measured);
    (0..rounds).for_each(|_| truths.round(poses, &mut measured));
    measured
}

/// The true distances of a case.
struct Truths<'c> {
    case: &'c Case,
    /// Of each pose, as bounds: of a distance that is known they are the same.
    bounds: Vec<[f64; 2]>,
    /// For each pose the memory of a finished query.
    memories: Vec<PairMemory>,
}

impl<'c> Truths<'c> {
    /// From the file of the case, or by a finished query without tolerance.
    fn new(case: &'c Case, truth: &[Truth], measured: &mut Measured) -> Self {
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
            measured.stops += 1;
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
    fn work(&self, measured: &mut Measured) {
        let mut workspace = Workspace::new();
        for pose in (0..self.bounds.len()).filter(|&pose| self.is_apart(pose)) {
            let full = query(self.case, pose, DEPTH_FIRST)
                .run(&mut workspace, Budget::unlimited())
                .stats
                .work;
            for order in ORDERS {
                let run = self.stops(pose, order, full, &mut workspace, measured);
                measured.runs.push(run);
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
    ) -> Run {
        let (query, clock) = (query(self.case, pose, order), SystemClock::default());
        let mut memory = self.memory(pose, order);
        let mut said = query
            .with_memory(memory.as_mut())
            .run(workspace, Budget::work(0).clock(&clock));
        let mut run = Run {
            pose,
            order,
            stops: Vec::new(),
            whole: 0.0,
            reached: [f64::NAN; 2],
        };
        for percent in 1.. {
            let limit = if percent > 100 {
                u64::MAX
            } else {
                (full * percent).div_ceil(100)
            };
            let budget = Budget::work(limit.saturating_sub(said.stats.work));
            said = query
                .with_memory(memory.as_mut())
                .resume(workspace, budget.clock(&clock))
                .unwrap_or(said);
            run.whole = said.stats.work as f64 / full as f64;
            let stop = self.judge(pose, order, &said, measured);
            for (reached, near) in run
                .reached
                .iter_mut()
                .zip([stop.is_high_near(), stop.is_proven()])
            {
                if near && reached.is_nan() {
                    *reached = run.whole;
                }
            }
            if percent > 100 {
                break;
            }
            if said.stop == StopReason::WorkLimit {
                measured.overrun = measured.overrun.max(said.stats.work.saturating_sub(limit));
            }
            run.stops.push(stop);
        }
        run
    }

    /// All orders, within each budget of time, at up to so many poses; a pass over the poses for each budget.
    fn round(&self, most: usize, measured: &mut Measured) {
        let clock = SystemClock::default();
        let mut workspace = Workspace::new();
        let mut runs = Vec::new();
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
            let first = runs.len();
            for &pose in &poses {
                let (_, whole) = timed(pose, Budget::unlimited());
                runs.push(Run {
                    pose,
                    order,
                    stops: Vec::new(),
                    whole,
                    reached: [f64::NAN; 2],
                });
            }
            for limit in plan()
                .microseconds()
                .iter()
                .copied()
                .map(Duration::from_micros)
            {
                for run in &mut runs[first..] {
                    let (said, _) = timed(run.pose, Budget::time(limit));
                    run.stops.push(self.judge(run.pose, order, &said, measured));
                }
            }
        }
        measured.rounds.push(runs);
    }

    fn memory(&self, pose: usize, order: &str) -> Option<PairMemory> {
        (order == TOLD).then(|| self.memories[pose].clone())
    }

    /// Compares what is said with the truth.
    fn judge(
        &self,
        pose: usize,
        order: &str,
        said: &Answer<Bounds>,
        measured: &mut Measured,
    ) -> Stop {
        let (truth, finished) = (self.bounds[pose], said.stop == StopReason::Finished);
        measured.stops += 1;
        if !within([said.value.low, said.value.high], truth, self.case) {
            let Bounds { low, high, .. } = said.value;
            let what = format!(
                "{} pose {pose} {order}: said to be {low} to {high} apart, is {}",
                self.case.name, truth[0]
            );
            measured.wrong.push(what);
        }
        Stop {
            low: said.value.low / truth[1],
            high: said.value.high / truth[1],
            finished,
        }
    }
}

/// Whether bounds hold a distance that is itself known by bounds, and up to its rounding.
fn within([low, high]: [f64; 2], [least, most]: [f64; 2], case: &Case) -> bool {
    let error = 1e-13 * (size(case.a.mesh()) + size(case.b.mesh()) + most);
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
