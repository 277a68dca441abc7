//! Contact manifolds: two solids and a pose in; what a solver needs of them out.

use crate::distance::not_negative;
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::sized::grows;
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{inits, lists, question};
use crate::workspace::punctual_workspace;
use punctual::contacts::{Manifold, ManifoldBounds, ManifoldPoint, Manifolds};
use punctual::{Answer, Pose, Query};

/// The question for the contact manifolds of two solids: triangles are counterclockwise seen from
/// outside. Plain data, made by `punctual_manifold_query_init`, one for each pose; it borrows the
/// trees. To resume a query, all of it must be what it was.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_manifold_query<'t> {
    /// Its size in bytes, as made.
    pub size: u32,
    /// Tree A.
    pub a: Option<&'t punctual_tree>,
    /// Tree B; it may be the same.
    pub b: Option<&'t punctual_tree>,
    /// Brings coordinates of B into those of A.
    pub b_in_a: punctual_pose,
    /// Solids apart have points of contact up to this distance, in the unit of the meshes; 0 by
    /// default: overlaps alone.
    pub skin: f64,
}

grows!(punctual_manifold_query<'_>: size, b_in_a..skin);

/// The answer of a query for manifolds. Their points stay in the workspace:
/// `punctual_workspace_manifold_points`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_manifolds {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Whether the surfaces are known to intersect.
    pub meets: bool,
    /// Proven: every contact that is missing is at least this far apart; 0 while overlaps may be
    /// missing. Infinite if the query is finished.
    pub low: f64,
    /// Pairs of triangles within the skin that were reduced, resumed calls included.
    pub found: u64,
    /// Why the query returned.
    pub stop: punctual_stop_reason,
    /// What it has done.
    pub stats: punctual_stats,
}

grows!(punctual_manifolds: size, low..stats);

/// A point of a contact manifold. All of it is in A's frame, in the unit of the meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_manifold_point {
    /// The id of the point: with a memory the same from frame to frame.
    pub id: u64,
    /// The id of its manifold.
    pub manifold: u64,
    /// The point on A and the point on B.
    pub points: [punctual_point; 2],
    /// Unit vector from B to A; zeros in an overlap without a normal, as of a pin through a plate.
    pub normal: punctual_point,
    /// Signed distance along the normal: negative where the solids are sunk into each other.
    pub distance: f64,
    /// Whether the surfaces intersect in this manifold, 1 or 0.
    pub is_overlap: u32,
    /// Whether all of the manifold was looked at, 1 or 0; if not, its depth is a lower bound.
    pub is_whole: u32,
    /// The area of the manifold, seen along the normal.
    pub area: f64,
    /// The middle of the manifold.
    pub centroid: punctual_point,
}

grows!(punctual_manifold_point: distance..centroid);

impl Default for punctual_manifold_query<'_> {
    fn default() -> Self {
        let b_in_a = (&Pose::IDENTITY).into();
        Self {
            size: Self::SIZE,
            a: None,
            b: None,
            b_in_a,
            skin: 0.0,
        }
    }
}

inits! {
    /// The question for the manifolds of `a` and `b`, without a skin. Checked when it is run.
    punctual_manifold_query_init(
        query: punctual_manifold_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_pose
    ) { a, b, b_in_a }
}

question! {
    punctual_manifold_query(punctual_workspace, memory) -> punctual_manifolds {
        /// Runs a query for manifolds within a budget. It keeps its buffers in the workspace, so it
        /// allocates only where a query is larger than those before. It does not lock or panic.
        /// `memory` may be null: it keeps the ids from frame to frame.
        ///
        /// If more pairs intersect than `punctual_workspace_reserve_contacts` has made room for,
        /// 4,096 by default, it stops with PAIRS_FULL; make room and resume it.
        run punctual_manifold_query_run;

        /// However it is cut into pieces by work budgets, the manifolds at the end are those of one
        /// uninterrupted run.
        resume punctual_manifold_query_resume;

        remaining punctual_manifold_query_remaining;
    }
}

impl<'t> punctual_manifold_query<'t> {
    fn check(self) -> Result<Query<'t, Manifolds>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        not_negative(self.skin, "query->skin")?;
        Ok(Query::manifolds(a, b, self.b_in_a.check()?).skin(self.skin))
    }
}

impl From<Answer<ManifoldBounds>> for punctual_manifolds {
    fn from(manifolds: Answer<ManifoldBounds>) -> Self {
        Self {
            size: Self::SIZE,
            meets: manifolds.value.meets,
            low: manifolds.value.low,
            found: manifolds.stats.found,
            stop: manifolds.stop.into(),
            stats: manifolds.stats.into(),
        }
    }
}

impl From<(&Manifold, &ManifoldPoint)> for punctual_manifold_point {
    fn from((manifold, point): (&Manifold, &ManifoldPoint)) -> Self {
        Self {
            id: point.id,
            manifold: manifold.id,
            points: point.points.map(Into::into),
            normal: point.normal.into(),
            distance: point.distance,
            is_overlap: manifold.is_overlap.into(),
            is_whole: manifold.is_whole.into(),
            area: manifold.area,
            centroid: manifold.centroid.into(),
        }
    }
}

lists! {
    /// The points of the manifolds that the last query found, if it was one for manifolds: those of
    /// the deepest first.
    rows punctual_workspace_manifold_points(workspace: punctual_workspace)
        -> points: punctual_manifold_point, points_size =
            workspace.manifolds().iter().flat_map(|manifold| {
                manifold.points().iter().map(move |point| (manifold, point))
            });
}
