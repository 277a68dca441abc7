//! Contact manifolds: two solids and a pose in; what a solver needs of them out.

use crate::distance::not_negative;
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{inits, lists, question, types};
use crate::workspace::punctual_workspace;
use punctual::contacts::{Manifold, ManifoldBounds, ManifoldPoint, Manifolds};
use punctual::{Answer, Query};

types! {
    /// The question for the contact manifolds of two solids: triangles are counterclockwise seen
    /// from outside. Plain data, made by `punctual_manifold_query_init`, one for each pose; it
    /// borrows the trees. To resume a query, all of it must be what it was.
    asked punctual_manifold_query<'t>(b_in_a) {
        /// Tree A.
        a: Option<&'t punctual_tree> = None,
        /// Tree B; it may be the same.
        b: Option<&'t punctual_tree> = None,
        /// Brings coordinates of B into those of A.
        b_in_a: punctual_pose = punctual_pose::IDENTITY,
        /// Solids apart have points of contact up to this distance, in the unit of the meshes; 0 by
        /// default: overlaps alone.
        skin: f64 = 0.0,
    }

    /// The answer of a query for manifolds. Their points stay in the workspace:
    /// `punctual_workspace_manifold_points`.
    told punctual_manifolds(low) from (manifolds: Answer<ManifoldBounds>) {
        /// Whether the surfaces are known to intersect.
        meets: bool = manifolds.value.meets,
        /// Proven: every contact that is missing is at least this far apart; 0 while overlaps may
        /// be missing. Infinite if the query is finished.
        low: f64 = manifolds.value.low,
        /// Pairs of triangles within the skin that were reduced, resumed calls included.
        found: u64 = manifolds.stats.found,
        /// Why the query returned.
        stop: punctual_stop_reason = manifolds.stop.into(),
        /// What it has done.
        stats: punctual_stats = manifolds.stats.into(),
    }

    /// A point of a contact manifold. All of it is in A's frame, in the unit of the meshes.
    row punctual_manifold_point(distance) from ((manifold, point): (&Manifold, &ManifoldPoint)) {
        /// The id of the point: with a memory the same from frame to frame.
        id: u64 = point.id,
        /// The id of its manifold.
        manifold: u64 = manifold.id,
        /// The point on A and the point on B.
        points: [punctual_point; 2] = point.points.map(Into::into),
        /// Unit vector from B to A; zeros in an overlap without a normal, as of a pin through a
        /// plate.
        normal: punctual_point = point.normal.into(),
        /// Signed distance along the normal: negative where the solids are sunk into each other.
        distance: f64 = point.distance,
        /// Whether the surfaces intersect in this manifold, 1 or 0.
        is_overlap: u32 = manifold.is_overlap.into(),
        /// Whether all of the manifold was looked at, 1 or 0; if not, its depth is a lower bound.
        is_whole: u32 = manifold.is_whole.into(),
        /// The area of the manifold, seen along the normal.
        area: f64 = manifold.area,
        /// The middle of the manifold.
        centroid: punctual_point = manifold.centroid.into(),
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

lists! {
    /// The points of the manifolds that the last query found, if it was one for manifolds: those of
    /// the deepest first.
    rows punctual_workspace_manifold_points(workspace: punctual_workspace)
        -> points: punctual_manifold_point, points_size =
            workspace.manifolds().iter().flat_map(|manifold| {
                manifold.points().iter().map(move |point| (manifold, point))
            });
}
