//! Queries of known truth, stopped on the way: what the model sees, and what came of it.

use punctual::clock::ManualClock;
use punctual::internals::{self, FrontierSummary, Lead, pair_cost};
use punctual::intersection::Intersection;
use punctual::prediction::{Counts, History};
use punctual::{Answer, Budget, Mode, PairMemory, Query, StopReason, Verdict, Workspace};

use super::cases::Case;
use super::moments::{STOPS, THINNED};
use crate::traversal::advance;

/// A query at one moment, and its end.
pub struct Sample {
    /// The case it is of, by number.
    pub case: usize,
    pub mode: Mode,
    /// The share of the work of a complete query after which it was stopped; `None` before it began.
    pub stop: Option<f64>,
    pub frontier: FrontierSummary,
    /// Counts of the finished query, of the same mode.
    pub total: Counts,
    /// Number of intersecting pairs in truth.
    pub hits: u64,
    /// [`pair_cost`] of the roots at the deepest.
    pub root_cost: f64,
    /// How many of the [`STOPS`] come after its end, known before it began.
    pub decided: usize,
    /// What is remembered of the frame before; `None` if the query had no memory.
    pub last: Option<Last>,
    /// What leads the query.
    pub lead: Lead,
}

/// What the frame before said and took, in the same mode.
#[derive(Clone, Copy)]
pub struct Last {
    pub history: History,
    pub bv_tests: f64,
}

impl Sample {
    /// BV tests that were left.
    pub fn left(&self) -> f64 {
        self.total.bv_tests - self.frontier.bv_tests
    }

    pub fn is_hit(&self) -> bool {
        self.hits > 0
    }
}

/// All poses of a case, in both modes, at all moments; those of a motion also with a memory.
pub fn samples(case_number: usize, case: &Case) -> Vec<Sample> {
    let mut sampler = Sampler {
        number: case_number,
        case,
        workspace: Workspace::new(),
        samples: Vec::new(),
    };
    let mut memories = [PairMemory::new(), PairMemory::new()];
    for (number, &pose) in case.poses.iter().enumerate() {
        let query = Query::intersection(&case.a, &case.b, pose);
        let tracing = query.mode(Mode::All);
        let complete = run(&tracing, &mut sampler.workspace, None, None);
        // For all pairs, as runs that nothing is expected to cut.
        let modes = [tracing.plain(), query];
        for ((mode, query), memory) in [Mode::All, Mode::Any]
            .into_iter()
            .zip(modes)
            .zip(&mut memories)
        {
            // Without a memory, frames close together are the same query again.
            if !case.is_motion || number % THINNED == 0 {
                sampler.sample(&query, mode, &complete, None, false);
                if mode == Mode::All {
                    sampler.sample(&tracing, mode, &complete, None, true);
                }
            }
            if case.is_motion {
                sampler.sample(&query, mode, &complete, Some(memory), false);
                let _ = run(&query, &mut sampler.workspace, Some(memory), None);
            }
        }
    }
    sampler.samples
}

struct Sampler<'c> {
    number: usize,
    case: &'c Case,
    workspace: Workspace,
    samples: Vec<Sample>,
}

impl Sampler<'_> {
    /// All moments of a query. A memory that knows nothing yet gives none.
    fn sample(
        &mut self,
        query: &Query<Intersection>,
        mode: Mode,
        complete: &Answer<Verdict>,
        memory: Option<&PairMemory>,
        traces: bool,
    ) {
        let last = match memory.map(|memory| (memory.history(), memory.last_bv_tests())) {
            None => None,
            Some((Some(history), Some(bv_tests))) => Some(Last {
                history,
                bv_tests: bv_tests as f64,
            }),
            Some(_) => return,
        };
        let lead = if traces { Lead::Curves } else { Lead::Nothing };
        let roots = [&self.case.a, &self.case.b]
            .map(|tree| tree.root().map_or(0.0, |root| root.self_cost()));
        let sample = |stop, frontier, end: &Answer<Verdict>| Sample {
            case: self.number,
            mode,
            stop,
            frontier,
            total: end.stats.counts(),
            hits: complete.stats.found,
            root_cost: pair_cost(roots, 1.0).into(),
            decided: 0,
            last,
            lead,
        };
        let whole = run(query, &mut self.workspace, memory.cloned().as_mut(), None);
        let before = self.samples.len();
        self.samples
            .push(sample(None, internals::frontier_before(query), &whole));
        for stop in STOPS {
            let limit = (stop * complete.stats.work as f64) as u64;
            let outcome = run(
                query,
                &mut self.workspace,
                memory.cloned().as_mut(),
                Some(limit),
            );
            if outcome.stop == StopReason::WorkLimit
                && let Ok(frontier) = internals::frontier(query, &self.workspace)
            {
                let end = advance(query, &mut self.workspace, None, outcome, None, drop);
                self.samples.push(sample(Some(stop), frontier, &end));
            } else {
                self.samples[before].decided += 1;
            }
        }
    }
}

/// One run, however often the pair buffer fills; without a limit, to the end.
fn run(
    query: &Query<Intersection>,
    workspace: &mut Workspace,
    mut memory: Option<&mut PairMemory>,
    limit: Option<u64>,
) -> Answer<Verdict> {
    let budget = limit.map_or(Budget::unlimited(), Budget::work);
    let begun = query.with_memory(memory.as_deref_mut());
    let outcome = begun.run(workspace, budget.clock(&ManualClock::new()));
    if outcome.stop == StopReason::PairsFull {
        advance(query, workspace, memory, outcome, limit, drop)
    } else {
        outcome
    }
}
