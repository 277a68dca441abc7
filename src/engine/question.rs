//! Parts common to all questions: a query runs, continues, and bounds what it may have missed.

use super::certificate::{Certificate, Place};
use super::deadline::system::ClockedBudget;
use super::deadline::{Budget, Deadline};
use super::memory::{PairMemory, Sought};
use super::options::OptionError;
use super::outcome::{Answer, Stats, StopReason};
use super::workspace::{Key, ResumeError, Workspace};
use crate::model::prediction::Quantiles;
use crate::tree::Tree;
use punctual_geom::nanoseconds;

/// A question about two trees. Cheap to make; make one for each pose.
///
/// Its constructors choose the question: [`Query::intersection`], [`Query::all_pairs`],
/// [`Query::distance`], [`Query::contacts`], [`Query::points_within`], [`Query::impact`],
/// [`Query::ray`], [`Query::rays`].
/// [`Query::run`] answers it within a budget, and [`Query::resume`] continues a stopped run.
///
/// **Guarantee.** At every moment each pair of triangles that matters has been taken into account,
/// or is kept in the workspace, or lies under a node pair still to be opened. So a finished answer
/// has missed nothing. A stopped query can bound what it may have missed ([`Query::certificate`]),
/// and it can continue later as if it had never stopped. A full queue changes only the order of
/// visits, and a full buffer is a stop reason; neither loses an answer.
#[derive(Clone, Copy, Debug)]
pub struct Query<'t, Q> {
    pub(crate) a: &'t Tree,
    pub(crate) b: &'t Tree,
    pub(crate) asked: Q,
    pub(crate) fault: Option<OptionError>,
    /// False if the question is about the surfaces even of solids.
    pub(crate) solids: bool,
}

/// The question of a [`Query`], with the type of its answer.
pub trait Question {
    /// The type of [`Answer::value`].
    type Value;
}

/// Questions that can use a [`PairMemory`] of the previous frame.
pub trait Remembers: Question {}

/// How a run of a question begins, continues and is answered. [`Query`] has the rest, which all
/// questions share.
pub trait Ask<Q: Question> {
    /// Two calls belong to one query if their keys are equal.
    fn key(&self) -> Key;

    /// True if the workspace agrees with the query in what the key leaves out.
    fn is_in(&self, _workspace: &Workspace) -> bool {
        true
    }

    /// Prepares the workspace for a run from the roots.
    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, budget: Budget);

    /// Continues the run in the workspace until it is over or the deadline stops it.
    fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason;

    /// The answer of the run in the workspace, which ended for the reason `stop`.
    fn answer(&self, workspace: &Workspace, stop: StopReason) -> Q::Value;

    /// Spends a budget on the run in the workspace, and answers.
    fn spend(
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

    /// Units of work left in the run in the workspace, which was stopped. For a question whether
    /// surfaces meet, also the probability that they do.
    fn left(&self, workspace: &Workspace, memory: Option<&PairMemory>) -> (Quantiles, Option<f64>);
}

/// A question whose open pairs are pairs of nodes and triangles of two trees, so that a
/// [`Certificate`] can bound what they hide. Rays are no such question.
pub trait Certify<Q: Question>: Ask<Q> {
    /// The pose or motion of B, and the largest distance that matters.
    fn place(&self, workspace: &Workspace) -> Place<'_>;
}

impl<'t, Q> Query<'t, Q> {
    /// Sum of the radii of both trees.
    pub(crate) fn radii(&self) -> f64 {
        self.a.radius() + self.b.radius()
    }

    pub(crate) fn of([a, b]: [&'t Tree; 2], asked: Q) -> Self {
        Self {
            a,
            b,
            asked,
            fault: None,
            solids: true,
        }
    }

    /// Returns the query if all numbers given to it are valid. Without this check the query uses
    /// the nearest valid numbers.
    ///
    /// # Errors
    /// If a tolerance, a margin or a limit is negative, too large or NaN. The error names the first
    /// of them.
    pub fn checked(self) -> Result<Self, OptionError> {
        match self.fault {
            Some(fault) => Err(fault),
            None => Ok(self),
        }
    }
}

impl<'t, Q: Question> Query<'t, Q>
where
    Self: Ask<Q>,
{
    /// Runs within a budget. The pairs, contacts and hits that it finds stay in the workspace.
    ///
    /// Under a budget of time it reads the clock more often the nearer the deadline, in the end
    /// every [`Budget::poll_interval`] units of work. It does not lock or panic. It does not
    /// allocate, with these exceptions. The first query in a workspace for contacts, for all hits
    /// of a ray, or for near points makes room for 4,096 of them. A query for near points of a
    /// larger cloud than any before makes room for marks of its blocks. The first query for a
    /// larger batch of rays or points than any before makes room for their answers. The first
    /// queries for manifolds, and about solids of which one may hold the other, make room too.
    /// [`Workspace::reserve_contacts`] and [`Workspace::reserve_ray_hits`] make room in advance.
    pub fn run<'c>(
        &self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Answer<Q::Value> {
        self.run_from(workspace, None, budget.into())
    }

    /// Continues the stopped run that the workspace holds, with a fresh budget.
    ///
    /// However budgets of work cut a query into calls, the last answer equals that of one
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

    /// The query with the memory of its pair: it uses what the memory holds of the previous frame,
    /// and updates it for the next.
    ///
    /// While B stays within the proven clearance ([`PairMemory::clearance`]), the answer is known
    /// without a search. Triangles that intersected, or were closest, are tested first.
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

    /// Bounds what the last run of this query in `workspace` may have missed, and where.
    ///
    /// For a distance query, this is what is closer than its upper bound by more than the
    /// tolerance. For a contact query, the boxes hold the middle of the closest points of each
    /// missing contact. For a motion, the boxes show where the surfaces may still meet before the
    /// contact that was found, if any.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this query (the same trees, pose and options).
    pub fn certificate<'w>(
        &'w self,
        workspace: &'w Workspace,
    ) -> Result<Certificate<'w>, ResumeError>
    where
        Self: Certify<Q>,
    {
        self.holds(workspace)?;
        Ok(Certificate {
            a: self.a,
            b: self.b,
            place: self.place(workspace),
            workspace,
        })
    }

    /// Tells what the last run of this query in `workspace` has left to do: work, time, and for an
    /// intersection the probability that the surfaces meet. Nothing is left of a finished run. Uses
    /// the memory of the pair, which learns from it when the query has ended.
    ///
    /// Costs as much time as 7,000 (any) to 13,000 (all) units of work for an intersection, because
    /// it opens the costliest pairs of the frontier on trial: 3 to 9 microseconds. For contacts and
    /// manifolds it is 1,000 units, and 7,000 with a large frontier; for all other questions 100 to
    /// 400. No allocation; work and probability are the same bits on every machine.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
    /// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
    /// let mut workspace = Workspace::new();
    /// let query = Query::all_pairs(&a, &b, Pose::IDENTITY);
    /// let _ = query.run(&mut workspace, Budget::work(2_000));
    /// let left = query.remaining(&workspace, None)?;
    /// let us = left.time.map(|ns| ns / 1e3);
    /// println!("{} us more, {} us with a probability of 90 %", us.p50, us.p90);
    /// assert!(0.0 < us.p50 && us.p50 <= us.p90 && left.probability.is_some());
    /// # Ok::<(), punctual::ResumeError>(())
    /// ```
    ///
    /// # Errors
    /// If the last run in this workspace was not of this query (the same trees, pose and options).
    pub fn remaining(
        &self,
        workspace: &Workspace,
        memory: Option<&PairMemory>,
    ) -> Result<Remaining, ResumeError> {
        self.holds(workspace)?;
        let is_stopped = workspace.run.stopped;
        let (work, probability) = self.left(workspace, memory.filter(|_| is_stopped));
        let work = if is_stopped {
            work
        } else {
            Quantiles::default()
        };
        let stats = workspace.stats();
        let unit = match stats.elapsed {
            Some(elapsed) if stats.work > 0 => nanoseconds(elapsed) / stats.work as f64,
            _ => workspace.cost_model.bv_test,
        };
        Ok(Remaining {
            work,
            time: work.map(|work| work * unit),
            probability,
        })
    }

    /// The model's quantiles of the work left, after `used`, corrected by the memory of the pair.
    /// `after` is the prediction by the query before.
    pub(crate) fn predicted(
        &self,
        memory: Option<&PairMemory>,
        sought: Sought,
        used: f64,
        model: Quantiles,
        after: impl FnOnce(&PairMemory) -> Option<Quantiles>,
    ) -> Quantiles {
        match memory.filter(|memory| memory.is_of(self.a, self.b)) {
            Some(memory) => memory.predict(sought, &self.key(), used, model, || after(memory)),
            None => model,
        }
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

    /// For tasks of several queries: continues the stopped run of this query in the workspace, or
    /// begins one. The plan of a new run does not depend on a budget, so budgets of work may cut it
    /// anywhere. Also returns the effort of earlier calls of the run.
    pub fn go_on(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> (Answer<Q::Value>, Stats) {
        let before = if self.is_stopped_in(workspace) {
            workspace.stats()
        } else {
            self.begin(workspace, memory.as_deref(), Budget::unlimited());
            Stats::default()
        };
        (self.spend(workspace, memory, deadline), before)
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

    /// An error unless the last run in the workspace was of this query.
    #[inline]
    pub(crate) fn holds(&self, workspace: &Workspace) -> Result<(), ResumeError> {
        let is_same = workspace.run.key == Some(self.key()) && self.is_in(workspace);
        is_same.then_some(()).ok_or(ResumeError)
    }

    /// True if the workspace holds a stopped run of this query.
    #[inline]
    pub fn is_stopped_in(&self, workspace: &Workspace) -> bool {
        workspace.run.stopped && self.holds(workspace).is_ok()
    }
}

/// What a stopped query has left to do: [`Query::remaining`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Remaining {
    /// Units of work, see [`Budget::work`].
    pub work: Quantiles,
    /// Nanoseconds: the work at the pace of the run so far, if its calls had budgets of time.
    /// Otherwise at [`CostModel::bv_test`](crate::prediction::CostModel::bv_test) of the workspace.
    pub time: Quantiles,
    /// Probability that the surfaces intersect: 1 if they are known to, 0 if they are known to be
    /// apart. `None` for other questions.
    pub probability: Option<f64>,
}

/// A query with the memory of its pair: [`Query::with_memory`].
#[derive(Debug)]
#[must_use]
pub struct QueryWithMemory<'m, 't, Q> {
    query: &'m Query<'t, Q>,
    memory: Option<&'m mut PairMemory>,
}

impl<'t, Q: Question> QueryWithMemory<'_, 't, Q>
where
    Query<'t, Q>: Ask<Q>,
{
    /// [`Query::run`] with the memory.
    pub fn run<'c>(
        self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Answer<Q::Value> {
        self.query.run_from(workspace, self.memory, budget.into())
    }

    /// [`Query::resume`] with the memory.
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
