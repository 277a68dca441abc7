//! Intersection of thickened surfaces: triangles no farther apart than the sum of the radii, asked
//! as the question of the distance with a limit, or of contacts.

use super::Intersection;
use super::estimate::{Estimate, Prediction};
use crate::engine::boxes::RelativePose;
use crate::engine::deadline::Deadline;
use crate::engine::frontier::Pair;
use crate::engine::memory::PairMemory;
use crate::engine::options::Mode;
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Query};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse;
use crate::engine::triangles::{PATIENCE, ids};
use crate::engine::workspace::{ResumeError, Workspace};
use crate::model::closing;
use crate::model::cost::WORK_PER_DISTANCE_TEST;
use crate::query::distance::halves::Halves;
use crate::query::distance::interval::{Interval, Tolerance};
use crate::query::distance::nearest::Nearness;

impl Query<'_, Intersection> {
    /// Prepares the workspace for a run from the roots.
    #[cold]
    pub(super) fn begin_within(&self, workspace: &mut Workspace, memory: Option<&PairMemory>) {
        workspace.clear();
        let options = &self.asked.options;
        let strategy = Strategy {
            batch: PATIENCE,
            ..Strategy::NONE
        };
        workspace.run.begin(self.key(), strategy);
        let clearance = memory.map_or(0.0, |memory| {
            memory.clearance(self.a, self.b, &self.asked.b_in_a)
        });
        if clearance > options.reach || self.a.nodes().is_empty() || self.b.nodes().is_empty() {
            return;
        }
        let tolerance = Tolerance::default();
        let mut guess = None;
        let interval = if options.mode == Mode::Any {
            let of_pair = memory.filter(|memory| memory.is_of(self.a, self.b));
            guess = of_pair.and_then(|memory| memory.witnesses().first().copied());
            Interval::new(tolerance, options.reach, 0.0)
        } else {
            let contacts = &mut workspace.state.contacts;
            contacts.begin(options.reach, options.reach, usize::MAX);
            contacts.lists_pairs = true;
            workspace.state.intersection.limit = options.pair_limit;
            Interval::new(tolerance, 0.0, options.reach)
        };
        workspace.state.distance.begin(interval, guess);
        workspace.state.distance.halves = Halves::of(self.a, self.b);
        workspace.testing = guess.is_some();
        workspace.frontier.push(Pair::new(0, 0));
    }

    /// Continues the run in the workspace until it is over or the deadline stops it.
    #[cold]
    pub(super) fn search_within(
        &self,
        relative: &RelativePose,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> StopReason {
        let (trees, b_in_a) = ([self.a, self.b], &self.asked.b_in_a);
        let search = &mut workspace.state.distance;
        let question = Nearness::new(relative, &search.interval);
        let question = question.beside(trees, relative, search);
        let stop = traverse(question, trees, b_in_a, relative, workspace, deadline);
        workspace.bound(f32::INFINITY, relative.unit);
        if self.asked.options.mode == Mode::All || !stop.is_final() {
            return stop;
        }
        // Triangles that `f64` cannot tell from those within count as within.
        let interval = &workspace.state.distance.interval;
        let is_within = interval.high().min(interval.low()) <= self.asked.options.reach;
        match interval.nearest().filter(|_| is_within) {
            Some((pair, found)) => {
                workspace.report_within(pair, ids(trees, pair), found.high);
                StopReason::FirstHit
            }
            None => stop,
        }
    }

    /// Predicts the rest of a query after `work`, with these proven bounds of the distance, by the
    /// model of distances. Each unit of work counts as a box test.
    pub(super) fn rest_within(&self, work: u64, bounds: [f64; 2]) -> Prediction {
        let query = Query::distance(self.a, self.b, self.asked.b_in_a).closer_than(0.0);
        let work = closing::work_left(&query.closing(work, bounds));
        Prediction {
            bv_tests: work,
            triangle_tests: work.map(|work| work / WORK_PER_DISTANCE_TEST as f64),
            work,
        }
    }

    /// The estimate for a run in the workspace. The boxes of the cores show little about thickened
    /// surfaces, so the probability is the prior until the run has decided.
    pub(super) fn estimate_within(&self, workspace: &Workspace) -> Result<Estimate, ResumeError> {
        self.holds(workspace)?;
        let run = &workspace.run;
        let interval = &workspace.state.distance.interval;
        let bounds = [interval.low(), interval.high()];
        let bounds = bounds.map(|bound| (bound - self.asked.options.reach).max(0.0));
        let remaining = if run.stopped {
            self.rest_within(run.stats.work, bounds)
        } else {
            Prediction::default()
        };
        let has_found = run.stats.found > 0;
        let done = run.stats.work as f64 / (run.stats.work as f64 + remaining.work.p50).max(1.0);
        Ok(Estimate {
            remaining,
            probability: match (has_found, run.stopped) {
                (true, _) => 1.0,
                (false, true) => self.asked.prior.clamp(0.0, 1.0),
                (false, false) => 0.0,
            },
            recall: match (has_found, run.stopped) {
                (_, false) => 1.0,
                (true, true) => done,
                (false, true) => 0.0,
            },
        })
    }
}
