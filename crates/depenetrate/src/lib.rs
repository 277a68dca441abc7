//! Push-out (depenetration): the shortest translation found that separates two surfaces, and the
//! proof that it does.
//!
//! It is a caller of [`Query`](punctual::Query): contacts give directions, a search finds the
//! lengths, and an exact query checks each length.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]

extern crate alloc;

mod blocked;
mod cover;
mod directions;
mod penetration;
mod search;

pub use penetration::{
    MAX_PENETRATION_STEP_WORK, Penetration, PenetrationQuery, PenetrationWorkspace,
};

use core::time::Duration;
use glam::DVec3;
use punctual::clock::ClockedBudget;
use punctual::engine::Deadline;
use punctual::{StopReason, Tree, Workspace};
use punctual_geom::Pose;
use search::Search;

/// Asks in which direction, and how far, B has to move until the surfaces no longer intersect.
/// Cheap to make; make one for each pose.
///
/// **Guarantee.** Every push that it returns has been checked, whenever it stops: an exact query,
/// run to its end at the pose after the push, found that no triangle of A shares a point with one
/// of B. More budget of work never gives a longer push. A shorter push may exist
/// (`docs/guide/push_out.md`).
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
/// use punctual_depenetrate::PushOutQuery;
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

/// A translation that separates the surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Push {
    /// Direction in which B moves: a unit vector in A's frame. The x axis if the surfaces do not
    /// intersect.
    pub direction: DVec3,
    /// Length of the translation, in the length unit of the meshes. 0 if the surfaces do not
    /// intersect.
    pub distance: f64,
    /// The pose after the push, at which the surfaces are separated: `direction * distance` is
    /// added to the translation.
    pub b_in_a: Pose,
}

/// The answer to a [`PushOutQuery`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct PushOut {
    /// The shortest push found. `None` if the budget ended before one was found.
    pub push: Option<Push>,
    /// Exact queries that were run, including the one that found the contacts.
    pub queries: u32,
    /// Why it returned. [`StopReason::Finished`] also at the limit of queries.
    pub stop: StopReason,
    /// Units of work, see [`Budget::work`](punctual::Budget::work).
    pub work: u64,
    /// Duration of the call; measured only under a time budget.
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

    /// Stops after this many exact queries. By default there is no limit: the search ends by
    /// itself, after about 40 queries at a shallow contact and 110 at a deep one (means over many
    /// meshes).
    #[must_use]
    pub fn query_limit(mut self, queries: u32) -> Self {
        self.query_limit = queries;
        self
    }

    /// Runs within a budget. It does not allocate, lock or panic. Afterwards the workspace holds no
    /// run that could be resumed.
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
