//! Predicts the cost of a query, and estimates what a stopped one leaves open: quantiles, a
//! probability, a recall.
//!
//! Apart from the choice of the plan under a budget of time ([`Query::fits`]), nothing here runs
//! inside a query. The caller asks when it wants to know ([`Query::remaining`] states the cost).

use super::Intersection;
use super::probe::Probe;
use crate::engine::boxes::RelativePose;
use crate::engine::frontier::Pair;
use crate::engine::memory::{PairMemory, Sought};
use crate::engine::options::Mode;
use crate::engine::question::Query;
use crate::engine::strategy::Tracing;
use crate::engine::workspace::{ResumeError, Workspace};
use crate::model::confidence::{self, Lead};
use crate::model::cost::{CostModel, Counts};
use crate::model::frontier::FrontierSummary;
use crate::model::prediction::{self, Quantiles};
use crate::model::visits::pair_cost;
use core::time::Duration;
use punctual_geom::lanes::Instructions;
use punctual_geom::nanoseconds;

/// The expected cost of a query, or of the rest of one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Prediction {
    /// BV tests, `N_v`.
    pub bv_tests: Quantiles,
    /// Triangle pairs tested, `N_p`.
    pub triangle_tests: Quantiles,
    /// Units of work, see [`crate::Budget::work`].
    pub work: Quantiles,
}

impl Prediction {
    fn of(bv_tests: Quantiles) -> Self {
        Self {
            bv_tests,
            triangle_tests: bv_tests.map(|n| counts(n).triangle_tests),
            work: bv_tests.map(|n| counts(n).work()),
        }
    }

    /// The time by a cost model, in its unit: [`crate::Workspace::cost_model`],
    /// [`CostModel::measure`], or the default model, which gives nanoseconds on a machine like the
    /// one used for the fit.
    #[must_use]
    pub fn time(&self, cost_model: &CostModel) -> Quantiles {
        self.bv_tests.map(|n| {
            if n > 0.0 {
                cost_model.time(&counts(n))
            } else {
                0.0
            }
        })
    }
}

/// The typical counts of a query with this many BV tests.
fn counts(bv_tests: f64) -> Counts {
    if bv_tests > 0.0 {
        prediction::counts(libm::log2(bv_tests))
    } else {
        Counts::default()
    }
}

/// The estimate for a stopped query: see [`Query::estimate`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Estimate {
    /// Expected cost of the rest of the query.
    pub remaining: Prediction,
    /// Probability that the surfaces intersect: 1 if a hit was found, 0 if they are proven
    /// separated, by the query or by the probe of its frontier that the estimate makes. A
    /// [`crate::prediction::Calibration`] corrects it for one pair of parts.
    pub probability: f64,
    /// Expected share of the intersecting pairs that has been found: 1 if the query is complete, 0
    /// if none is found yet. For [`Mode::Any`], which searches for one pair, 1 as soon as it is
    /// decided.
    pub recall: f64,
}

/// Maximum effort of a probe, in openings and children: before a query, and after a stopped one.
const EFFORT_BEFORE: usize = 48;
const EFFORT_AFTER: usize = 120;

/// Maximum number of pairs of a frontier that are sampled, and number sampled between two checks of
/// the time. The other pairs count as the mean of the sample.
const SAMPLE: usize = 256;
const SAMPLE_STEP: usize = 8;

impl Query<'_, Intersection> {
    /// Predicts the cost of this query if nothing stops it, using the memory of the pair. Takes
    /// about 1 microsecond, no allocation; the same bits on every machine.
    ///
    /// ```
    /// use punctual::{Pose, Query, Tree, shapes};
    /// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
    /// let tests = Query::intersection(&a, &b, Pose::IDENTITY).predict(None).bv_tests;
    /// assert!(1.0 <= tests.p10 && tests.p10 <= tests.p50 && tests.p50 <= tests.p90);
    /// ```
    #[must_use]
    pub fn predict(&self, memory: Option<&PairMemory>) -> Prediction {
        if self.asked.options.reach > 0.0 {
            return self.rest_within(0, [0.0, f64::INFINITY]);
        }
        let memory = self.known(memory);
        self.rest(&self.frontier_before(), 0, memory)
    }

    /// Estimates what the last run of this query in `workspace` leaves open, using the memory of
    /// the pair. Costs as much as [`Query::remaining`], no allocation; the same bits on every
    /// machine.
    ///
    /// Part of this time is spent on opening the costliest pairs of the frontier on trial, which
    /// shows more than their boxes.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options.
    pub fn estimate(
        &self,
        workspace: &Workspace,
        memory: Option<&PairMemory>,
    ) -> Result<Estimate, ResumeError> {
        self.estimate_while(workspace, memory, &|| true)
    }

    /// [`Query::estimate`] that samples fewer pairs of the frontier, at least eight, and opens
    /// fewer, if `goes_on` returns false.
    #[doc(hidden)]
    pub fn estimate_while(
        &self,
        workspace: &Workspace,
        memory: Option<&PairMemory>,
        goes_on: &dyn Fn() -> bool,
    ) -> Result<Estimate, ResumeError> {
        if self.asked.options.reach > 0.0 {
            return self.estimate_within(workspace);
        }
        let frontier = self.frontier_while(workspace, goes_on)?;
        let memory = self.known(memory);
        let run = &workspace.run;
        let decided = run.stats.found > 0 && self.asked.options.mode == Mode::Any;
        let remaining = if decided || frontier.is_done() {
            Prediction::default()
        } else {
            self.rest(&frontier, workspace.work(), memory)
        };
        let probability = if run.stats.found > 0 {
            1.0
        } else {
            self.probability(&frontier, memory)
        };
        // A run that traces curves has found more than its work suggests.
        let lead = match run.strategy.trace {
            Tracing::Never => Lead::Nothing,
            _ => Lead::Curves,
        };
        let recall = if decided {
            1.0
        } else {
            confidence::recall(&frontier, lead)
        };
        Ok(Estimate {
            remaining,
            probability,
            recall,
        })
    }

    /// What an estimate needs of the frontier that the last run of this query left, or of the part
    /// of it that is read until `goes_on` returns false.
    pub(crate) fn frontier_while(
        &self,
        workspace: &Workspace,
        goes_on: &dyn Fn() -> bool,
    ) -> Result<FrontierSummary, ResumeError> {
        self.holds(workspace)?;
        let run = &workspace.run;
        let summary = FrontierSummary {
            bv_tests: run.stats.bv_tests as f64,
            triangle_tests: run.stats.primitive_tests as f64,
            found: run.stats.found as f64,
            followed: workspace.state.intersection.trace.followed as f64,
            passed: workspace.state.intersection.trace.passed as f64,
            follows: workspace.state.intersection.trace.is_due(),
            triangle_pairs: (workspace.waiting.len() + workspace.uncertain.len()) as f64,
            ..FrontierSummary::default()
        };
        let open = workspace.frontier.len();
        let relative = RelativePose::new(self.a, self.b, &self.asked.b_in_a);
        let mut probe = Probe::new([self.a, self.b], &relative, summary, goes_on);
        let mut sample = 0;
        for pair in workspace.frontier.iter().take(SAMPLE) {
            if sample > 0 && sample % SAMPLE_STEP == 0 && !goes_on() {
                break;
            }
            probe.add(pair);
            sample += 1;
        }
        let mut frontier = probe.finish(workspace.instructions, EFFORT_AFTER);
        let beyond = (open - sample) as f64 / sample.max(1) as f64;
        frontier.node_pairs += beyond * frontier.node_pairs;
        if frontier.node_pairs == 0.0 {
            // Nothing is known of the pairs that were not sampled.
            frontier.node_pairs = (open - sample) as f64;
        }
        frontier.cost += beyond * frontier.cost;
        frontier.depth += beyond * frontier.depth;
        Ok(frontier)
    }

    /// The frontier before the query: its root, opened on trial.
    pub(crate) fn frontier_before(&self) -> FrontierSummary {
        let relative = RelativePose::new(self.a, self.b, &self.asked.b_in_a);
        let mut probe = Probe::new(
            [self.a, self.b],
            &relative,
            FrontierSummary::default(),
            &|| true,
        );
        if !self.a.nodes().is_empty() && !self.b.nodes().is_empty() {
            probe.add(Pair::new(0, 0));
        }
        probe.finish(Instructions::detect(), EFFORT_BEFORE)
    }

    /// The memory, if it is of this pair.
    fn known<'m>(&self, memory: Option<&'m PairMemory>) -> Option<&'m PairMemory> {
        memory.filter(|memory| memory.is_of(self.a, self.b))
    }

    fn probability(&self, frontier: &FrontierSummary, memory: Option<&PairMemory>) -> f64 {
        let history = memory.and_then(PairMemory::history);
        confidence::probability(frontier, history.as_ref(), self.asked.prior)
    }

    /// Predicts the rest of a query with this frontier, after `work`.
    fn rest(
        &self,
        frontier: &FrontierSummary,
        work: u64,
        memory: Option<&PairMemory>,
    ) -> Prediction {
        let mode = self.asked.options.mode;
        let tests = match mode {
            Mode::All => prediction::all_left(frontier),
            Mode::Any => prediction::any_left(frontier, self.probability(frontier, memory)),
        };
        let model = Prediction::of(tests);
        if frontier.is_done() {
            return model;
        }
        let after = |memory: &PairMemory| {
            let previous = memory.last_bv_tests_of(mode)? as f64;
            Some(match mode {
                Mode::All => prediction::all_after(previous),
                Mode::Any => prediction::any_after(previous),
            })
        };
        let used = frontier.bv_tests;
        let tests_left = self.predicted(memory, Sought::tests(mode), used, tests, after);
        let work_after = |memory: &PairMemory| Some(Prediction::of(after(memory)?).work);
        let work = self.predicted(
            memory,
            Sought::work(mode),
            work as f64,
            model.work,
            work_after,
        );
        Prediction {
            work,
            ..Prediction::of(tests_left)
        }
    }

    /// Lets the memory of the pair learn from a call.
    pub(crate) fn teach(&self, memory: &mut PairMemory, workspace: &Workspace, is_finished: bool) {
        let (mode, run) = (self.asked.options.mode, &workspace.run.stats);
        memory.learn(Sought::tests(mode), workspace, run.bv_tests, is_finished);
        memory.learn(Sought::work(mode), workspace, run.work, is_finished);
    }

    /// True if the time is expected to suffice for the 90 % quantile of the cost. Without a memory,
    /// that of the costliest placement of the two trees; with one, that of the next frame. Reads no
    /// boxes.
    pub(crate) fn fits(
        &self,
        limit: Duration,
        memory: Option<&PairMemory>,
        cost_model: &CostModel,
    ) -> bool {
        let (Some(a), Some(b)) = (self.a.nodes().first(), self.b.nodes().first()) else {
            return true;
        };
        let memory = self.known(memory);
        let roots = pair_cost([a.self_cost, b.self_cost], 1.0);
        let mode = self.asked.options.mode;
        let previous = memory.and_then(|memory| memory.last_bv_tests_of(mode));
        let most = |log2: fn(f64) -> f64| match (previous.map(|tests| tests as f64), mode) {
            (None, _) => prediction::most(roots.into(), log2),
            (Some(previous), Mode::All) => prediction::most_of_all_after(previous, log2),
            (Some(previous), Mode::Any) => prediction::most_of_any_after(previous, log2),
        };
        // A time that is far too short shows by exponents, without a logarithm.
        let bv_tests = exponent(nanoseconds(limit) / cost_model.bv_test) + 1.0;
        if most(exponent) > bv_tests {
            return false;
        }
        let most = most(libm::log2);
        cost_model.time(&prediction::counts(most)) <= nanoseconds(limit)
    }
}

/// The logarithm to base 2 of a number of at least 1, rounded down.
fn exponent(x: f64) -> f64 {
    (x.to_bits() >> 52) as f64 - 1023.0
}
