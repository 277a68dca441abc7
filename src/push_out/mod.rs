//! Push-out: the shortest translation found that parts two surfaces, and proof that it does.
//!
//! It is a caller of [`Query`](crate::Query): contacts give the [`directions`], the [`search`]
//! finds how far, and each length is checked by an exact query. [`blocked`] remembers what those
//! that met have shown.

mod blocked;
mod directions;
mod search;

use crate::math::Pose;
use crate::query::{ClockedBudget, Deadline, StopReason, Workspace};
use crate::tree::Tree;
use core::time::Duration;
use glam::DVec3;
use search::Search;

/// The question which way, and how far, B has to be moved until the surfaces no longer meet. Cheap
/// to make; one for each pose.
///
/// **Guarantee.** Whenever it stops, a push that it returns has been checked: an exact query, run
/// to its end at the very pose that the push leads to, found that no triangle of A shares a point
/// with one of B. More budget of work never gives a longer push. There may be a shorter one
/// (`docs/guide/push_out.md`).
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Budget, Pose, PushOutQuery, Query, Tree, Verdict, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(3)), Tree::new(shapes::icosphere(3)));
/// let mut workspace = Workspace::new();
/// let pose = Pose::new(DMat3::IDENTITY, DVec3::new(1.9, 0.1, 0.0))?;
/// let push = PushOutQuery::new(&a, &b, pose).run(&mut workspace, Budget::work(1_000_000)).push.unwrap();
/// assert!(push.distance < 0.12 && push.direction.x > 0.9);
/// let verdict = Query::intersection(&a, &b, push.b_in_a).run(&mut workspace, Budget::unlimited()).value;
/// assert_eq!(verdict, Verdict::Separated);
/// # Ok::<(), punctual::PoseError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PushOutQuery<'t> {
    a: &'t Tree,
    b: &'t Tree,
    b_in_a: Pose,
    query_limit: u32,
}

/// A translation that parts the surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Push {
    /// Where B moves to, a unit vector in A's frame; the x axis if the surfaces do not meet anyway.
    pub direction: DVec3,
    /// How far, in the length unit of the meshes; 0 if the surfaces do not meet anyway.
    pub distance: f64,
    /// The pose after the push, at which the surfaces are apart: `direction * distance` is added to
    /// the translation.
    pub b_in_a: Pose,
}

/// The answer to a [`PushOutQuery`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct PushOut {
    /// The shortest push found; `None` if the budget ended before there was one.
    pub push: Option<Push>,
    /// Exact queries that were run, the one that found the contacts included.
    pub queries: u32,
    /// Why it returned; [`StopReason::Finished`] also at the limit of queries.
    pub stop: StopReason,
    /// Units of work, see [`Budget::work`](crate::Budget::work).
    pub work: u64,
    /// Time; measured only under a time budget.
    pub elapsed: Option<Duration>,
}

impl<'t> PushOutQuery<'t> {
    /// Asks about the meshes of `a` and `b`, where `b_in_a` brings B's coordinates into A's.
    #[must_use]
    pub fn new(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        Self {
            a,
            b,
            b_in_a,
            query_limit: u32::MAX,
        }
    }

    /// Stop after this many exact queries. By default the search ends by itself, after about 40 at
    /// a shallow contact and 110 at a deep one (means over many meshes).
    #[must_use]
    pub fn query_limit(mut self, queries: u32) -> Self {
        self.query_limit = queries;
        self
    }

    /// Runs within a budget. It does not allocate, lock or panic. Afterwards the workspace holds
    /// nothing that could be resumed.
    pub fn run<'c>(
        &self,
        workspace: &mut Workspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> PushOut {
        let mut deadline = Deadline::of(budget.into());
        let mut search = Search::new(self, workspace, &mut deadline);
        let stop = search.run().err().unwrap_or(StopReason::Finished);
        let (push, queries, work) = (search.best, search.queries, search.work);
        workspace.forget_run();
        PushOut {
            push,
            queries,
            stop,
            work,
            elapsed: deadline.elapsed(),
        }
    }
}
