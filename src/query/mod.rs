//! The budgeted query: two trees, a pose and a budget in, an [`Outcome`] out.
//!
//! [`traversal`] has the one loop, the stop rule and the guarantee; [`queue`] the front, [`budget`] the meter, [`boxes`]
//! and [`frames`] the overlap test, [`certificate`] what an unfinished query can still say.

mod boxes;
mod budget;
mod certificate;
mod corners;
mod estimate;
mod frames;
mod look;
mod measure;
mod memory;
mod order;
mod outcome;
mod queue;
mod traversal;
mod waiting;
mod workspace;

pub use crate::model::cost::CostModel;
#[cfg(feature = "std")]
pub use budget::SystemClock;
pub use budget::{
    Budget, Clock, MAX_STEP_WORK, ManualClock, WORK_PER_EXACT_TEST, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST,
};
pub use certificate::Certificate;
pub use estimate::{Estimate, Prediction};
pub use memory::PairMemory;
pub use order::{Mode, Order};
pub use outcome::{LEVELS, Outcome, Stats, StopReason, Verdict};
pub use workspace::{ResumeError, Workspace};

use crate::math::Pose;
use crate::model::confidence::DEFAULT_PRIOR;
use crate::tree::{Tree, WIDTH};
use budget::Meter;
use corners::Corners;
use frames::Relation;
use memory::{Before, WITNESSES};
use queue::Pair;
use traversal::Traversal;
use workspace::Key;

/// See [`Query::grain`].
const DEFAULT_GRAIN: f32 = 256.0;

/// Everything about a query that is a choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Options {
    pub mode: Mode,
    pub order: Order,
    pub pair_limit: usize,
    pub poll_interval: u64,
    pub grain: Option<f32>,
}

impl Options {
    pub fn grain(&self) -> f32 {
        self.grain.unwrap_or(match (self.mode, self.order) {
            (Mode::Any, Order::Penetration) => f32::INFINITY,
            _ => DEFAULT_GRAIN,
        })
    }
}

/// The question whether, or where, two meshes intersect at a pose. Cheap to make; one for each pose.
///
/// ```
/// use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
/// let mut workspace = Workspace::new();
/// let outcome = Query::new(&a, &b, Pose::IDENTITY).run(&mut workspace, Budget::work(20_000));
/// match outcome.verdict {
///     Verdict::Intersecting { witness } => println!("triangles {witness:?} meet"),
///     Verdict::Separated => println!("no contact"),
///     Verdict::Undecided => println!("not known yet"),
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Query<'t> {
    a: &'t Tree,
    b: &'t Tree,
    b_in_a: Pose,
    options: Options,
    prior: f64,
}

impl<'t> Query<'t> {
    /// Asks about the meshes of `a` and `b`, where `b_in_a` brings B's coordinates into A's.
    #[must_use]
    pub fn new(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        let options = Options {
            mode: Mode::Any,
            order: Order::Penetration,
            pair_limit: usize::MAX,
            poll_interval: MAX_STEP_WORK,
            grain: None,
        };
        Self { a, b, b_in_a, options, prior: DEFAULT_PRIOR }
    }

    /// Any intersection (the default), or all of them.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.options.mode = mode;
        self
    }

    /// The order of visits; penetration by default.
    #[must_use]
    pub fn order(mut self, order: Order) -> Self {
        self.options.order = order;
        self
    }

    /// Stop with [`StopReason::PairsFull`] when this many pairs are in the workspace; by default, when it is full.
    #[must_use]
    pub fn pair_limit(mut self, pairs: usize) -> Self {
        self.options.pair_limit = pairs.max(1);
        self
    }

    /// Least work between looks at the clock, which come closer together towards the deadline; default
    /// [`MAX_STEP_WORK`]. It bounds how late a time budget can end.
    #[must_use]
    pub fn poll_interval(mut self, work: u64) -> Self {
        self.options.poll_interval = work;
        self
    }

    /// Node pairs of which fewer BV tests than this are expected are finished depth-first at once instead of being
    /// queued. 0 queues every node pair, and infinity none. By default 256, and infinity for the first hit in the default
    /// order: there a stack with the deepest of siblings on top finds it sooner than the queue (`docs/benchmarks.md`).
    #[must_use]
    pub fn grain(mut self, bv_tests: f32) -> Self {
        self.options.grain = Some(bv_tests);
        self
    }

    /// The share of poses with an intersection among those that are asked about, 0 to 1; it shifts the probability of
    /// [`Query::estimate`]. By default that of the poses for which the model was fitted,
    /// [`crate::model::confidence::DEFAULT_PRIOR`].
    #[must_use]
    pub fn prior(mut self, share: f64) -> Self {
        self.prior = share;
        self
    }

    /// Runs within a budget, by the clock of the system. What it finds stays in the workspace.
    ///
    /// Under a time budget it returns at most one poll interval of work late. It does not allocate, lock or panic.
    #[cfg(feature = "std")]
    pub fn run(&self, workspace: &mut Workspace, budget: Budget) -> Outcome {
        self.run_with(workspace, None, budget, &SystemClock::default())
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget.
    ///
    /// However it is cut into pieces by work budgets, the outcome at the end is that of one uninterrupted run.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options, or is complete.
    #[cfg(feature = "std")]
    pub fn resume(&self, workspace: &mut Workspace, budget: Budget) -> Result<Outcome, ResumeError> {
        self.resume_with(workspace, None, budget, &SystemClock::default())
    }

    /// [`Query::run`] with the memory of earlier frames and a clock of the caller's.
    pub fn run_with<C: Clock>(
        &self,
        workspace: &mut Workspace,
        mut memory: Option<&mut PairMemory>,
        budget: Budget,
        clock: &C,
    ) -> Outcome {
        workspace.clear();
        workspace.run.key = Some(self.key());
        if let Order::Random(seed) = self.options.order {
            workspace.run.random = seed;
        }
        if let Some(memory) = &mut memory {
            memory.bind(self.a, self.b);
        }
        let queues = self.queues(budget, memory.as_deref());
        if let Some(memory) = memory.as_deref().filter(|memory| memory.last_verdict() != Some(false)) {
            let witnesses = memory.witnesses();
            if self.options.mode == Mode::Any {
                // They are tested before anything else, as any other waiting pairs.
                workspace.waiting.extend(&witnesses[..witnesses.len().min(WITNESSES)]);
                workspace.testing = !witnesses.is_empty();
            } else if queues && self.options.order == Order::default() {
                // The paths to them are opened before anything else.
                workspace.witnesses.extend(witnesses.iter().copied());
            }
        }
        if !self.a.nodes().is_empty() && !self.b.nodes().is_empty() {
            if queues {
                let known = (1u32 << workspace.witnesses.len()) - 1;
                if !workspace.front.follow(Pair::new(0, 0), known as u16) {
                    workspace.front.queue(Pair::new(0, 0), 0, true);
                }
            } else {
                workspace.front.push(Pair::new(0, 0));
            }
            // Where triangles met last, others near them are likely to meet now: they are visited first.
            if let Some(&[x, y]) = workspace.waiting.as_slice().first() {
                let (x, y) = (self.a.nodes_above(x), self.b.nodes_above(y));
                workspace.front.push(Pair::new(x[0], y[0]));
                workspace.front.push(Pair::new(x[1], y[1]));
            }
        }
        self.proceed(workspace, memory, budget, clock)
    }

    /// [`Query::resume`] with the memory of earlier frames and a clock of the caller's.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options, or is complete.
    pub fn resume_with<C: Clock>(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        budget: Budget,
        clock: &C,
    ) -> Result<Outcome, ResumeError> {
        if workspace.run.stopped && workspace.run.key == Some(self.key()) {
            Ok(self.proceed(workspace, memory, budget, clock))
        } else {
            Err(ResumeError)
        }
    }

    /// What the last run of this query in `workspace` left open.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options.
    pub fn certificate<'w>(&'w self, workspace: &'w Workspace) -> Result<Certificate<'w>, ResumeError> {
        if workspace.run.key == Some(self.key()) {
            Ok(Certificate::new(self.a, self.b, &self.b_in_a, workspace))
        } else {
            Err(ResumeError)
        }
    }

    fn key(&self) -> Key {
        Key { trees: [self.a.identity(), self.b.identity()], b_in_a: self.b_in_a, options: self.options }
    }

    /// Whether node pairs are queued. What no budget can cut short, or a time budget is not expected to, is finished
    /// depth-first, which costs least, unless another order was asked for. Work budgets promise the same bits however the
    /// work is cut into pieces, so their size decides nothing.
    fn queues(&self, budget: Budget, memory: Option<&PairMemory>) -> bool {
        match self.options.order {
            _ if self.options.grain() == f32::INFINITY => false,
            Order::DepthFirst => false,
            Order::Penetration => budget.work.is_some() || budget.time.is_some_and(|limit| !self.fits(limit, memory)),
            _ => true,
        }
    }

    fn proceed<C: Clock>(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        budget: Budget,
        clock: &C,
    ) -> Outcome {
        let before = Before { resumed: workspace.run.stopped, decided: workspace.run.witness.is_some() };
        let counts_before = budget.time.map(|_| workspace.run.stats.counts());
        let meter = Meter::start(budget, self.options.poll_interval, clock, workspace.run.stats.work);
        // Waiting pairs are work: within a budget, or when the first hit ends the query, they wait only for a full batch.
        let patient = self.options.mode == Mode::All && budget == Budget::unlimited();
        let instructions = workspace.instructions;
        workspace.corners.iter_mut().for_each(Corners::clear);
        let relation = Relation::new(self.a, self.b, &self.b_in_a);
        let mut traversal = Traversal {
            a: self.a,
            b: self.b,
            b_in_a: &self.b_in_a,
            options: &self.options,
            relation: &relation,
            workspace,
            meter,
            depths: [[0.0; WIDTH]; WIDTH],
            greedy: self.options.mode == Mode::Any && self.options.order == Order::default(),
            batch: if patient { waiting::PATIENCE } else { 8 },
        };
        let stop = instructions.run(&mut traversal);
        let elapsed = traversal.meter.elapsed();
        let run = &mut workspace.run;
        run.stats.bv_tests = run.stats.bv_tests_per_level.iter().sum();
        run.stats.queue_peak = workspace.front.peak();
        if let Some(elapsed) = elapsed {
            run.stats.elapsed = Some(run.stats.elapsed.unwrap_or_default().saturating_add(elapsed));
        }
        run.stopped = !matches!(stop, StopReason::Finished | StopReason::FirstHit);
        let verdict = match (run.witness, stop) {
            (Some(witness), _) => Verdict::Intersecting { witness },
            (None, StopReason::Finished) => Verdict::Separated,
            _ => Verdict::Undecided,
        };
        let outcome = Outcome { verdict, stop, found: run.found, stats: run.stats };
        if let Some(memory) = memory {
            memory.bind(self.a, self.b);
            memory.remember(self.options.mode, &outcome, workspace.sample.pairs(), before);
            if let (Some(elapsed), Some(counts)) = (elapsed, counts_before) {
                memory.learn(&outcome.stats.counts().since(&counts), elapsed);
            }
        }
        outcome
    }
}
