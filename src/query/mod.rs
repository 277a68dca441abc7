//! The budgeted query: two trees, a pose and a budget in, an [`Outcome`] out.
//!
//! [`traversal`] has the one loop, the stop rule and the guarantee. Around it:
//!
//! | what | where |
//! |---|---|
//! | whether surfaces meet, or where: [`Query`] | here; [`intersection`], [`lone`], [`leaf`], [`refinement`], [`march`], [`follow`] |
//! | how far apart they are: [`DistanceQuery`] | [`distance`]; [`nearest`], [`closest_pairs`], [`gaps`], [`interval`], [`search`] |
//! | where they meet or are close: [`ContactQuery`] | [`contacts`], asked as one of these two |
//! | when they meet on the way: [`MotionQuery`] | [`motion`] |
//! | what rays hit: [`RayQuery`], [`RayBatch`] | [`ray`] |
//! | what a node pair is replaced by, whatever is asked | [`expand`]; [`boxes`], [`edge_axes`], [`views`] |
//! | what can be told without a query | [`glance`], [`parting`] |
//! | pairs that wait | [`queue`], by [`order`]; [`triangle_pairs`] |
//! | the choices of a run, and its end | [`options`], [`strategy`]; [`budget`], [`system`], [`deadline`] |
//! | all that changes during a query; what is kept for the next | [`workspace`]; [`memory`], [`clearance`] |
//! | what an unfinished query can still say | [`certificate`], [`narrow`] |
//! | what a query costs | [`estimate`], [`probe`], [`measure`] |

#[cfg(all(test, feature = "std"))]
mod apart_tests;
mod boxes;
mod budget;
mod certificate;
mod clearance;
mod close_boxes;
mod closest_pairs;
mod contacts;
mod corners;
mod deadline;
mod distance;
mod edge_axes;
mod estimate;
mod expand;
mod flushing;
mod follow;
mod gaps;
pub(crate) mod glance;
mod halves;
mod intersection;
mod interval;
mod known;
mod leaf;
mod lone;
mod march;
mod measure;
mod memory;
mod motion;
mod narrow;
mod nearest;
#[cfg(feature = "internals")]
pub(crate) mod opened;
mod options;
mod order;
mod outcome;
pub(crate) mod parting;
mod probe;
mod queue;
mod ray;
mod refinement;
mod search;
mod strategy;
mod system;
mod traversal;
#[cfg(all(test, feature = "std"))]
mod triangle_bounds_tests;
mod triangle_pairs;
mod views;
mod workspace;

pub use budget::{Budget, Clock, ManualClock};
pub use certificate::Certificate;
pub(crate) use clearance::displacement;
pub use contacts::{ContactQuery, Contacts};
pub(crate) use deadline::Deadline;
pub use distance::{Distance, DistanceQuery, Nearest};
pub use estimate::{DistanceEstimate, Estimate, Prediction};
pub(crate) use flushing::matters as flushing_matters;
pub use memory::PairMemory;
pub use motion::{MotionQuery, Passage};
use options::Options;
pub use options::{Mode, OptionError};
pub use order::Order;
pub use outcome::{LEVELS, Outcome, Stats, StopReason, Verdict};
pub use ray::{RayBatch, RayBatchOutcome, RayCast, RayHit, RayMode, RayQuery};
pub(crate) use strategy::Strategy;
pub(crate) use system::SYSTEM;
#[cfg(all(
    feature = "std",
    not(all(target_family = "wasm", target_os = "unknown"))
))]
pub use system::SystemClock;
pub use workspace::{ResumeError, Workspace};

use crate::math::{Pose, nanoseconds};
use crate::model::confidence::DEFAULT_PRIOR;
use crate::model::cost::Counts;
use crate::tree::{Tree, WIDTH};
use certificate::Place;
use intersection::{Intersection, Overlapping};
use lone::{Lone, Placing};
use memory::{Before, WITNESSES};
use queue::Pair;
use strategy::{Plan, WarmStart};
use traversal::Traversal;
use views::Relation;
use workspace::{Asked, Key};

/// The question whether, or where, two meshes intersect at a pose. Cheap to make; one for each pose.
///
/// **Guarantee.** At every moment each intersecting pair of triangles has been reported, or is kept in the workspace as a
/// triangle pair still to be tested, or lies under a node pair still to be opened. So `Separated` is said only when nothing
/// is left, a stopped query can name what it may have missed ([`Query::certificate`]), and it can go on later as if it had
/// never stopped ([`Query::resume`]). A full queue costs order, a full pair buffer is a stop reason; neither costs an answer.
///
/// ```
/// use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
/// let mut workspace = Workspace::new();
/// let outcome = Query::new(&a, &b, Pose::IDENTITY).run(&mut workspace, Budget::work(20_000));
/// match outcome.verdict {
///     // `Within` is what a scene says of bodies with margins.
///     Verdict::Intersecting { witness } | Verdict::Within { witness, .. } => println!("triangles {witness:?} meet"),
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
        Self {
            a,
            b,
            b_in_a,
            options: Options::DEFAULT,
            prior: DEFAULT_PRIOR,
        }
    }

    /// Any intersection (the default), or all of them.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.options.mode = mode;
        self
    }

    /// Stop with [`StopReason::PairsFull`] when this many pairs are in the workspace; by default, when it is full.
    #[must_use]
    pub fn pair_limit(mut self, pairs: usize) -> Self {
        self.options.pair_limit = pairs.max(1);
        self
    }

    /// The share of poses with an intersection among those that are asked about, 0 to 1; it shifts the probability of
    /// [`Query::estimate`]. By default that of the poses for which the model was fitted,
    /// [`DEFAULT_PRIOR`](crate::DEFAULT_PRIOR), as with NaN.
    #[must_use]
    pub fn prior(mut self, share: f64) -> Self {
        self.prior = if share.is_nan() { DEFAULT_PRIOR } else { share };
        self
    }

    /// For experiments: the order of visits; penetration by default, which finds most before a budget ends
    /// (`docs/benchmarks.md`).
    #[must_use]
    pub fn order(mut self, order: Order) -> Self {
        self.options.order = order;
        self
    }

    /// For experiments: node pairs of which fewer BV tests than this are expected are finished depth-first at once instead
    /// of being queued. 0 (and NaN) queues every node pair, infinity none. By default 48 in the default order and 128 in
    /// others, and infinity for [`Mode::Any`] in the default order: a stack with the deepest of siblings on top finds the
    /// first hit sooner than the queue (`docs/benchmarks.md`). In the default order it matters only where a budget may cut
    /// the run.
    #[must_use]
    pub fn queue_threshold(mut self, bv_tests: f32) -> Self {
        // The larger of NaN and 0 is 0.
        self.options.queue_threshold = Some(bv_tests.max(0.0));
        self
    }

    /// Runs within a budget, by the clock of the system. What it finds stays in the workspace.
    ///
    /// Under a budget of time it looks at the clock more often the nearer the deadline, in the end every
    /// [`Budget::poll_interval`] units of work. It does not allocate, lock or panic.
    pub fn run(&self, workspace: &mut Workspace, budget: Budget) -> Outcome {
        self.run_with(workspace, None, budget.by_system(), &crate::query::SYSTEM)
    }

    /// [`Query::run`] with what is remembered of the pair from the frame before, and will be for the next. As long as B stays
    /// within what the memory knows of its distance ([`PairMemory::clearance`]), the answer is known without a search.
    pub fn run_with_memory(
        &self,
        workspace: &mut Workspace,
        memory: &mut PairMemory,
        budget: Budget,
    ) -> Outcome {
        self.run_with(
            workspace,
            Some(memory),
            budget.by_system(),
            &crate::query::SYSTEM,
        )
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget.
    ///
    /// However it is cut into pieces by budgets of work, the outcome at the end is that of one uninterrupted run.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options, or is complete.
    pub fn resume(
        &self,
        workspace: &mut Workspace,
        budget: Budget,
    ) -> Result<Outcome, ResumeError> {
        self.resume_with(workspace, None, budget.by_system(), &crate::query::SYSTEM)
    }

    /// [`Query::resume`] with what is remembered of the pair.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options, or is complete.
    pub fn resume_with_memory(
        &self,
        workspace: &mut Workspace,
        memory: &mut PairMemory,
        budget: Budget,
    ) -> Result<Outcome, ResumeError> {
        self.resume_with(
            workspace,
            Some(memory),
            budget.by_system(),
            &crate::query::SYSTEM,
        )
    }

    /// [`Query::run`] by a clock of the caller's, with or without a memory.
    pub fn run_with(
        &self,
        workspace: &mut Workspace,
        mut memory: Option<&mut PairMemory>,
        budget: Budget,
        clock: &dyn Clock,
    ) -> Outcome {
        let mut deadline = Deadline::of(budget, clock);
        if let Some(memory) = &mut memory {
            memory.bind(self.a, self.b);
        }
        let fits = |limit| self.fits(limit, memory.as_deref(), &workspace.cost_model);
        let plan = Plan::within(budget, self.options.mode, fits);
        let strategy = plan.strategy(&self.options);
        self.begin(workspace, memory.as_deref(), strategy);
        self.spend(workspace, memory, &mut deadline)
    }

    /// [`Query::resume`] by a clock of the caller's, with or without a memory.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options, or is complete.
    pub fn resume_with(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        budget: Budget,
        clock: &dyn Clock,
    ) -> Result<Outcome, ResumeError> {
        workspace.run.holds_stopped(&self.key())?;
        Ok(self.spend(workspace, memory, &mut Deadline::of(budget, clock)))
    }

    /// What the last run of this query in `workspace` left open.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options.
    pub fn certificate<'w>(
        &'w self,
        workspace: &'w Workspace,
    ) -> Result<Certificate<'w>, ResumeError> {
        workspace.run.holds(&self.key())?;
        Ok(Certificate::new(
            [self.a, self.b],
            Place::Still(&self.b_in_a, 0.0),
            workspace,
        ))
    }

    /// Whether the workspace holds a stopped run of this query.
    pub(crate) fn is_stopped_in(&self, workspace: &Workspace) -> bool {
        workspace.run.holds_stopped(&self.key()).is_ok()
    }

    fn key(&self) -> Key {
        Key::new(
            [self.a, self.b],
            self.b_in_a,
            Asked::Intersection(self.options),
        )
    }

    /// The strategy of a run in a larger task, which goes to its end (`complete`) or may be cut: with full batches, with which
    /// small budgets of scenes find more.
    pub(crate) fn strategy(&self, complete: bool) -> Strategy {
        Strategy {
            batch: WIDTH,
            ..Plan::of(self.options.mode, !complete).strategy(&self.options)
        }
    }

    /// Prepares the workspace for a run from the roots.
    #[inline(always)]
    pub(crate) fn begin(
        &self,
        workspace: &mut Workspace,
        memory: Option<&PairMemory>,
        strategy: Strategy,
    ) {
        self.begin_after(0, workspace, memory, strategy);
    }

    /// The same, where so many of the latest witnesses were tested already and do not meet.
    #[inline(always)]
    pub(crate) fn begin_after(
        &self,
        refuted: usize,
        workspace: &mut Workspace,
        memory: Option<&PairMemory>,
        strategy: Strategy,
    ) {
        workspace.clear();
        workspace.run.begin(self.key(), strategy);
        let remembered = memory
            .filter(|memory| memory.last_verdict() != Some(false) && memory.is_of(self.a, self.b));
        let witnesses = remembered.map_or(&[][..], PairMemory::witnesses);
        match strategy.warm_start {
            WarmStart::None => {}
            WarmStart::Paths => workspace.witnesses.extend(witnesses.iter().copied()),
            WarmStart::Witnesses => {
                // They wait like any other triangle pairs, and so are tested first.
                let latest = &witnesses[..witnesses.len().min(WITNESSES)];
                workspace
                    .waiting
                    .extend(&latest[refuted.min(latest.len())..]);
                workspace.testing = workspace.waiting.len() > 0;
            }
        }
        let are_apart =
            memory.is_some_and(|memory| memory.clearance(self.a, self.b, &self.b_in_a) > 0.0);
        if are_apart || self.a.nodes().is_empty() || self.b.nodes().is_empty() {
            return;
        }
        let paths = (1u32 << workspace.witnesses.len()) - 1;
        if workspace.front.follow(Pair::new(0, 0), paths as u16) {
            // The first of the paths.
        } else if strategy.queues() {
            workspace.front.queue(Pair::new(0, 0), 0.0, 0, true);
        } else {
            // Made where it is stored: copied in one piece, it would have to wait until the pieces are in the cache.
            workspace.front.push(Pair::new(0, 0));
        }
        // Where triangles met last, others near them are likely to meet now: they are visited first.
        if let (WarmStart::Witnesses, Some(&[x, y])) = (strategy.warm_start, witnesses.first()) {
            let (x, y) = (self.a.nodes_above(x), self.b.nodes_above(y));
            workspace.front.push(Pair::new(x[0], y[0]));
            workspace.front.push(Pair::new(x[1], y[1]));
        }
    }

    /// Spends a budget on the run in the workspace; learns what it costs.
    fn spend(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> Outcome {
        let before = if workspace.run.stopped {
            workspace.counts()
        } else {
            Counts::default()
        };
        let stop = self.advance(workspace, memory, deadline);
        let elapsed = deadline.elapsed();
        if let Some(elapsed) = elapsed {
            let done = workspace.counts().since(&before);
            workspace.cost_model = workspace.cost_model.learned(&done, nanoseconds(elapsed));
        }
        workspace.run.took(elapsed);
        workspace.outcome(stop)
    }

    /// Goes on with the run in the workspace until it is over or the deadline stops it.
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let before = Before {
            resumed: workspace.run.stopped,
            decided: workspace.run.witness.is_some(),
        };
        let (options, trees) = (&self.options, [self.a, self.b]);
        let stop = if Lone::is_one(trees) {
            // Only a queue asks where B lies.
            let placed;
            let relation = if workspace.run.strategy.queues() {
                placed = Relation::new(self.a, self.b, &self.b_in_a);
                &placed
            } else {
                &Relation::BLIND
            };
            let lone = workspace.instructions.run(Placing {
                trees,
                b_in_a: &self.b_in_a,
            });
            let question = Intersection {
                options,
                opener: &lone,
            };
            Traversal::new(question, trees, &self.b_in_a, relation, workspace, deadline).advance()
        } else {
            let relation = Relation::new(self.a, self.b, &self.b_in_a);
            let question = Intersection {
                options,
                opener: Overlapping,
            };
            Traversal::new(
                question,
                trees,
                &self.b_in_a,
                &relation,
                workspace,
                deadline,
            )
            .advance()
        };
        if stop == StopReason::FlushedToZero {
            return stop;
        }
        if let Some(memory) = memory {
            memory.bind(self.a, self.b);
            memory.remember(self.options.mode, stop, workspace, before);
        }
        stop
    }
}
