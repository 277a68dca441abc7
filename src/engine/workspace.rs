//! All buffers of a query, owned by the caller.

use super::frontier::Frontier;
use super::options::{ContactOptions, DistanceOptions, Options};
use super::outcome::Operand;
use super::outcome::{Stats, StopReason, Verdict};
use super::strategy::Strategy;
use super::triangles::TrianglePairs;
use super::triangles::corners::Corners;
use crate::model::cost::CostModel;
use crate::query::state::State;
use crate::tree::Tree;
use alloc::boxed::Box;
use arrayvec::ArrayVec;
use core::fmt;
use core::time::Duration;
use punctual_geom::Pose;
use punctual_geom::lanes::Instructions;

/// The buffers of a query, allocated once. Only some first queries allocate more:
/// [`Query::run`](crate::Query::run).
///
/// It holds the pairs that the last query found, and the state that [`crate::Query::resume`]
/// continues from. A fresh workspace and a used one give the same answers. A clone has the same
/// contents and the same capacity.
///
/// It also learns the costs of queries on this machine ([`Workspace::cost_model`]).
#[derive(Clone, Debug)]
pub struct Workspace {
    pub(crate) instructions: Instructions,
    pub(crate) cost_model: CostModel,
    pub(crate) frontier: Frontier,
    /// Triangle pairs (tree order) that wait for the filter, and those that it left in doubt.
    pub(crate) waiting: Box<TrianglePairs>,
    pub(crate) uncertain: ArrayVec<[u32; 2], 8>,
    /// Cached corners of triangles of A and of B for the tests in `f64`.
    pub(crate) corners: [Corners; 2],
    /// True while triangle pairs are tested: until none is in doubt and less than a batch waits.
    pub(crate) testing: bool,
    /// The last batch was inconclusive: take the next node pair from another part of the stack.
    pub(crate) inconclusive: bool,
    /// The states of the questions.
    pub(crate) state: State,
    pub(crate) run: Run,
}

/// The state of the last query, apart from its buffers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// The trees, the pose and the options of the query.
    pub key: Option<Key>,
    pub strategy: Strategy,
    /// True if a budget or a full buffer stopped it, so that it can be resumed.
    pub stopped: bool,
    /// Without the sum of the BV tests and the peak of the queue, which [`Workspace::stats`] adds.
    pub stats: Stats,
    /// The first pair found: ids of the input meshes.
    pub witness: Option<[u32; 2]>,
    /// How far its cores are apart, if surfaces have radii.
    pub apart: f64,
    pub containment: Containment,
}

impl Run {
    /// Starts a new run. Assigns field by field: storing zeros is faster than copying a constant.
    #[inline(always)]
    pub fn begin(&mut self, key: Key, strategy: Strategy) {
        self.key = Some(key);
        self.strategy = strategy;
        self.stopped = false;
        self.stats = Stats::default();
        self.witness = None;
        self.apart = 0.0;
        self.containment = Containment::Open;
    }

    /// Adds the time of a call, if it was measured.
    pub fn took(&mut self, elapsed: Option<Duration>) {
        if let Some(elapsed) = elapsed {
            let total = &mut self.stats.elapsed;
            *total = Some(total.unwrap_or_default().saturating_add(elapsed));
        }
    }

    /// The verdict of a run that ended for this reason.
    pub fn verdict(&self, stop: StopReason) -> Verdict {
        match (self.witness, stop) {
            (Some(witness), _) => Verdict::of_witness(witness, self.apart),
            (None, StopReason::Finished) => Verdict::Separated,
            _ => Verdict::Undecided,
        }
    }
}

/// The state of a run's question about containment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Containment {
    /// Nothing is known yet.
    Open,
    /// It is being asked whether this body is inside the other.
    Asking(Operand),
    /// The body that has a vertex inside the other; `None` if neither has.
    Known(Option<Operand>),
}

impl Containment {
    /// The body that has a vertex inside the other.
    pub fn inner(self) -> Option<Operand> {
        match self {
            Self::Known(inner) => inner,
            _ => None,
        }
    }
}

/// Identifies a query: calls with equal keys belong to one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    pub trees: [usize; 2],
    pub b_in_a: Pose,
    pub asked: Asked,
}

impl Key {
    pub fn new(trees: [&Tree; 2], b_in_a: Pose, asked: Asked) -> Self {
        Self {
            trees: trees.map(Tree::identity),
            b_in_a,
            asked,
        }
    }
}

/// A question and its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    Intersection(Options),
    SelfIntersection(Options),
    Distance(DistanceOptions),
    /// The options are in the `MotionState`.
    Motion,
    Contacts(ContactOptions),
    PointsWithin(ContactOptions),
    Manifolds(ContactOptions),
    /// The rays are in the `RayState`.
    Ray,
    /// The points are in the `PointState`.
    Points,
}

impl Workspace {
    /// Room for 4,096 queued node pairs and 65,536 found pairs, about 960 kB.
    #[must_use]
    pub fn new() -> Self {
        Self::with_capacity(4096, 65536)
    }

    /// Room for `queue` node pairs of distances and motions, and for `found` intersecting pairs:
    /// about 360 kB and `20 queue + 8 found` bytes. Intersections have a queue of 64 pairs of their
    /// own. With a full queue the query goes depth-first and loses nothing. A full buffer of pairs
    /// stops it with [`crate::StopReason::PairsFull`], to be drained and resumed.
    #[must_use]
    pub fn with_capacity(queue: usize, found: usize) -> Self {
        Self {
            instructions: Instructions::detect(),
            cost_model: CostModel::default(),
            frontier: Frontier::new(queue),
            waiting: Box::default(),
            uncertain: ArrayVec::new(),
            corners: [Corners::EMPTY; 2],
            testing: false,
            inconclusive: false,
            state: State::new(found),
            run: Run {
                key: None,
                strategy: Strategy::NONE,
                stopped: false,
                stats: Stats::default(),
                witness: None,
                apart: 0.0,
                containment: Containment::Open,
            },
        }
    }

    /// For experiments: uses the portable kernels on any machine; slower, with the same bits.
    pub fn use_portable_kernels(&mut self) {
        self.instructions = Instructions::PORTABLE;
    }

    /// The costs of a BV test, a triangle pair, an opened node pair and a query on this machine, in
    /// nanoseconds, as learned from runs with a budget of time. They decide the plan of a query
    /// with such a budget.
    pub fn cost_model(&self) -> CostModel {
        self.cost_model
    }

    /// Sets the costs, for example to those of [`CostModel::measure`]. Each query with a budget of
    /// time updates them.
    pub fn set_cost_model(&mut self, cost_model: CostModel) {
        self.cost_model = cost_model;
    }

    /// Forgets the run, so that none can be resumed.
    pub fn forget_run(&mut self) {
        self.run.key = None;
        self.run.stopped = false;
    }

    /// True if a budget or a full buffer stopped the last run.
    pub fn is_stopped(&self) -> bool {
        self.run.stopped
    }

    /// [`Stats::work`] of the last query.
    pub fn work(&self) -> u64 {
        self.run.stats.work
    }

    /// [`Stats::bv_tests`] of the last query.
    pub fn bv_tests(&self) -> u64 {
        self.run.stats.bv_tests
    }

    /// [`Stats::found`] of the last query.
    pub fn found(&self) -> u64 {
        self.run.stats.found
    }

    /// The verdict of the last query, which ended for this reason, if it was an intersection. It
    /// is about the surfaces, whether the bodies are solids or not.
    pub fn verdict(&self, stop: StopReason) -> Verdict {
        self.run.verdict(stop)
    }

    /// The effort of the last query, resumed calls included.
    #[inline]
    pub fn stats(&self) -> Stats {
        Stats {
            queue_peak: self.frontier.peak(),
            ..self.run.stats
        }
    }

    /// True if nothing is left open.
    pub(crate) fn is_done(&self) -> bool {
        self.frontier.is_empty()
            && self.waiting.is_empty()
            && self.uncertain.is_empty()
            && self.state.is_done()
    }

    /// The triangle pairs (tree order) of an intersection query that wait for a test.
    pub(crate) fn triangle_pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        self.waiting
            .as_slice()
            .iter()
            .chain(&self.uncertain)
            .copied()
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.frontier.clear();
        self.waiting.clear();
        self.uncertain.clear();
        self.testing = false;
        self.inconclusive = false;
        self.state.clear();
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// The workspace holds no stopped run of this query: another query was run in it since, or none was
/// run, or this one is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResumeError;

impl fmt::Display for ResumeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "the workspace does not hold a run of this query (same trees, pose and options)",
        )
    }
}

impl core::error::Error for ResumeError {}
