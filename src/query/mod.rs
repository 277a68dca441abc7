//! The budgeted query: two trees, a question and a budget in, an [`Answer`] out.
//!
//! [`traversal`] has the one loop, the stop rule and the guarantee. Around it:
//!
//! | what | where |
//! |---|---|
//! | every question: [`Query`], [`Ask`] | here |
//! | whether surfaces meet, or where | [`intersection`]; [`meeting`], [`leaf`], [`refinement`], [`march`], [`follow`] |
//! | how far apart they are | [`distance`]; [`nearest`], [`closest_pairs`], [`gaps`], [`interval`], [`search`] |
//! | where they meet or are close | [`contacts`], asked as one of these two |
//! | when they meet on the way | [`motion`] |
//! | what rays hit | [`ray`] |
//! | what a node pair is replaced by, whatever is asked | [`expand`]; [`boxes`], [`edge_axes`], [`views`] |
//! | what can be told without a query | [`root_test`], [`parting`] |
//! | pairs that wait | [`queue`], by [`order`]; [`triangle_pairs`] |
//! | the choices of a run, and its end | [`options`], [`strategy`]; [`budget`], [`system`], [`deadline`] |
//! | all that changes during a query; what is kept for the next | [`workspace`]; [`memory`], [`clearance`] |
//! | what an unfinished query can still say | [`certificate`] |
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
mod follow;
mod gaps;
mod halves;
mod intersection;
mod interval;
mod known;
mod leaf;
mod march;
mod measure;
mod meeting;
mod memory;
mod motion;
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
pub(crate) mod root_test;
mod search;
mod strategy;
mod system;
mod traversal;
#[cfg(all(test, feature = "std"))]
mod triangle_bounds_tests;
mod triangle_pairs;
mod views;
mod workspace;

pub use budget::{Budget, Clock, ClockedBudget, ManualClock};
pub use certificate::Certificate;
pub(crate) use clearance::displacement;
pub use contacts::{ContactBounds, Contacts};
pub(crate) use deadline::Deadline;
pub use distance::{Bounds, Distance, Nearest};
pub use estimate::{DistanceEstimate, Estimate, Prediction};
pub use intersection::Intersection;
pub use memory::PairMemory;
pub use motion::{Impact, TimeOfImpact};
pub use options::{Mode, OptionError};
pub use order::Order;
pub use outcome::{Answer, LEVELS, Stats, StopReason, Verdict};
pub use ray::{RayBounds, RayCast, RayHit, RayMode, Rays};
pub(crate) use system::SYSTEM;
#[cfg(all(
    feature = "std",
    not(all(target_family = "wasm", target_os = "unknown"))
))]
pub use system::SystemClock;
pub use workspace::{ResumeError, Workspace};

use crate::tree::Tree;
use certificate::Place;
use workspace::Key;

/// A question about two trees. Cheap to make; one for each pose.
///
/// Its constructors say what is asked: [`Query::intersection`], [`Query::all_pairs`],
/// [`Query::distance`], [`Query::contacts`], [`Query::impact`], [`Query::ray`]. [`Query::run`]
/// answers it within a budget, and [`Query::resume`] goes on where the budget ended.
///
/// **Guarantee.** At every moment each pair of triangles that matters has been taken into account,
/// or is kept in the workspace, or lies under a node pair still to be opened. So a finished answer
/// has missed nothing, a stopped query can name what it may have missed ([`Query::certificate`]),
/// and it can go on later as if it had never stopped. A full queue costs order, a full buffer is a
/// stop reason; neither costs an answer.
#[derive(Clone, Copy, Debug)]
pub struct Query<'t, Q> {
    a: &'t Tree,
    b: &'t Tree,
    asked: Q,
    fault: Option<OptionError>,
}

/// What a [`Query`] asks, and what its answer is.
pub trait Question {
    /// What an [`Answer`] tells.
    type Value;
}

/// Questions for which a [`PairMemory`] has something of the frame before.
pub trait Remembers: Question {}

/// How a run of a question begins, goes on and is answered. [`Query`] has the rest, which is the
/// same for all questions.
pub trait Ask {
    type Value;

    /// What two calls must have in common to be one query.
    fn key(&self) -> Key;

    /// Whether the workspace has what the key leaves out.
    fn is_in(&self, _workspace: &Workspace) -> bool {
        true
    }

    /// Prepares the workspace for a run from the roots.
    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, budget: Budget);

    /// Goes on with the run in the workspace until it is over or the deadline stops it.
    fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason;

    /// What the run in the workspace has shown, having ended for this reason.
    fn answer(&self, workspace: &Workspace, stop: StopReason) -> Self::Value;

    /// Where B is, and how far apart what matters may be.
    fn place(&self, workspace: &Workspace) -> Place<'_>;
}

impl<'t, Q> Query<'t, Q> {
    fn of([a, b]: [&'t Tree; 2], asked: Q) -> Self {
        Self {
            a,
            b,
            asked,
            fault: None,
        }
    }

    /// The query itself, if all that it was given are numbers that it can use. Without this, it
    /// goes by the nearest that it can.
    ///
    /// # Errors
    /// If a tolerance, a margin or a limit is negative, too large or no number. The error names the
    /// first of them.
    pub fn checked(self) -> Result<Self, OptionError> {
        match self.fault {
            Some(fault) => Err(fault),
            None => Ok(self),
        }
    }
}

impl<'t, Q: Question> Query<'t, Q>
where
    Self: Ask<Value = Q::Value>,
{
    /// Runs within a budget. What it finds stays in the workspace.
    ///
    /// Under a budget of time it looks at the clock more often the nearer the deadline, in the end
    /// every [`Budget::poll_interval`] units of work. It does not lock or panic. It does not
    /// allocate, but for the first query in a workspace for contacts or for all hits of a ray: it
    /// makes room for 4,096, unless [`Workspace::reserve_contacts`] or
    /// [`Workspace::reserve_ray_hits`] has made some.
    pub fn run<'c>(
        &self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Answer<Q::Value> {
        self.run_from(workspace, None, budget.into())
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget.
    ///
    /// However it is cut into pieces by budgets of work, the answer at the end is that of one
    /// uninterrupted run.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this query (the same trees, pose and options),
    /// or is complete.
    pub fn resume<'c>(
        &self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Answer<Q::Value>, ResumeError> {
        self.resume_from(workspace, None, budget.into())
    }

    /// The query with what is remembered of the pair, if anything, from the frame before, and will
    /// be for the next.
    ///
    /// As long as B stays within what the memory knows of its distance ([`PairMemory::clearance`]),
    /// the answer is known without a search; and triangles that met, or were closest, are looked at
    /// first.
    ///
    /// ```
    /// use punctual::{Budget, PairMemory, Pose, Query, Tree, Workspace, shapes};
    /// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
    /// let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    /// let query = Query::intersection(&a, &b, Pose::IDENTITY);
    /// let first = query.with_memory(&mut memory).run(&mut workspace, Budget::unlimited());
    /// let again = query.with_memory(&mut memory).run(&mut workspace, Budget::unlimited());
    /// assert!(again.value == first.value && again.stats.work < first.stats.work);
    /// ```
    pub fn with_memory<'m>(
        &'m self,
        memory: impl Into<Option<&'m mut PairMemory>>,
    ) -> QueryWithMemory<'m, 't, Q>
    where
        Q: Remembers,
    {
        QueryWithMemory {
            query: self,
            memory: memory.into(),
        }
    }

    /// What the last run of this query in `workspace` may have missed, and where.
    ///
    /// Of a distance query that is what is closer than its upper bound by more than the tolerance,
    /// of a contact query the middle of the closest points of each contact, and of a motion where
    /// the surfaces may still meet before the contact that was found, if any.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this query (the same trees, pose and options).
    pub fn certificate<'w>(
        &'w self,
        workspace: &'w Workspace,
    ) -> Result<Certificate<'w>, ResumeError> {
        self.holds(workspace)?;
        let place = self.place(workspace);
        Ok(Certificate::new([self.a, self.b], place, workspace))
    }

    fn run_from(
        &self,
        workspace: &mut Workspace,
        mut memory: Option<&mut PairMemory>,
        budget: ClockedBudget<'_>,
    ) -> Answer<Q::Value> {
        let mut deadline = Deadline::of(budget);
        if let Some(memory) = &mut memory {
            memory.bind(self.a, self.b);
        }
        self.begin(workspace, memory.as_deref(), budget.parts().0);
        self.spend(workspace, memory, &mut deadline)
    }

    fn resume_from(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        budget: ClockedBudget<'_>,
    ) -> Result<Answer<Q::Value>, ResumeError> {
        if !self.is_stopped_in(workspace) {
            return Err(ResumeError);
        }
        Ok(self.spend(workspace, memory, &mut Deadline::of(budget)))
    }

    /// Spends a budget on the run in the workspace.
    pub(crate) fn spend(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> Answer<Q::Value> {
        let stop = self.advance(workspace, memory, deadline);
        workspace.run.took(deadline.elapsed());
        Answer {
            value: self.answer(workspace, stop),
            stop,
            stats: workspace.stats(),
        }
    }

    /// Whether the workspace has the last run of this query.
    pub(crate) fn holds(&self, workspace: &Workspace) -> Result<(), ResumeError> {
        workspace.run.holds(&self.key())?;
        if self.is_in(workspace) {
            Ok(())
        } else {
            Err(ResumeError)
        }
    }

    /// Whether the workspace holds a stopped run of this query.
    pub(crate) fn is_stopped_in(&self, workspace: &Workspace) -> bool {
        workspace.run.stopped && self.holds(workspace).is_ok()
    }
}

/// A query that goes by what is remembered of its pair: [`Query::with_memory`].
#[derive(Debug)]
#[must_use]
pub struct QueryWithMemory<'m, 't, Q> {
    query: &'m Query<'t, Q>,
    memory: Option<&'m mut PairMemory>,
}

impl<'t, Q: Question> QueryWithMemory<'_, 't, Q>
where
    Query<'t, Q>: Ask<Value = Q::Value>,
{
    /// [`Query::run`] by the memory.
    pub fn run<'c>(
        self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Answer<Q::Value> {
        self.query.run_from(workspace, self.memory, budget.into())
    }

    /// [`Query::resume`] by the memory.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this query (the same trees, pose and options),
    /// or is complete.
    pub fn resume<'c>(
        self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Answer<Q::Value>, ResumeError> {
        self.query
            .resume_from(workspace, self.memory, budget.into())
    }
}
