//! The points of a cloud that are near a surface: two trees, a pose and a distance in; ids out.

use crate::arrays::find_room;
use crate::distance::not_negative;
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::punctual_pose;
use crate::query::trees;
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, lists, question, types};
use crate::workspace::punctual_workspace;
use punctual::points::PointsWithin;
use punctual::{Answer, Query};

types! {
    /// The question which points of a cloud are no farther from a surface than a distance, each
    /// once. Plain data, made by `punctual_near_points_query_new`, one for each pose; it borrows
    /// the trees. To resume a query or to ask for its certificate, all of it must be what it was.
    ///
    /// A solid is its surface: a point deep inside is not near it. The radii of both trees add to
    /// the distance. Of points that double cannot tell from points within, some are found, too.
    asked punctual_near_points_query<'t>(b_in_a) {
        /// The cloud, as made by `punctual_tree_from_points_f32` or the like.
        a: Option<&'t punctual_tree> = None,
        /// The surface: of a mesh, a shape or another cloud.
        b: Option<&'t punctual_tree> = None,
        /// Brings coordinates of B into those of A.
        b_in_a: punctual_pose = punctual_pose::IDENTITY,
        /// The distance, in the length unit of the meshes; 0 by default, infinity for all points.
        distance: f64 = 0.0,
        /// Stop with PAIRS_FULL when this many points are in the workspace; by default SIZE_MAX:
        /// when it is full.
        point_limit: usize = usize::MAX,
    }

    /// The answer. The points stay in the workspace: `punctual_workspace_near_points`.
    told punctual_near_points(found) from (near: Answer<u64>) {
        /// Why the query returned.
        stop: punctual_stop_reason = near.stop.into(),
        /// Points found, resumed calls and drained points included.
        found: u64 = near.value,
        /// What it has done.
        stats: punctual_stats = near.stats.into(),
    }
}

inits! {
    /// The question which points of the cloud `a` are on the surface of `b`, or within a distance
    /// that is set after. Checked when it is run.
    punctual_near_points_query_init(
        query: punctual_near_points_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_pose
    ) { a, b, b_in_a }
}

question! {
    punctual_near_points_query(punctual_workspace) -> punctual_near_points {
        /// Finds the points within a budget. The first query in a workspace makes room for 4,096
        /// points, unless `punctual_workspace_reserve_near_points` has made some, and for marks of
        /// the cloud, 5 bytes for eight points; nothing else allocates. It does not lock or panic.
        ///
        /// Under a time budget it returns at most one poll interval of work late.
        run punctual_near_points_query_run;

        /// After PAIRS_FULL drain the points or make room first. However it is cut into pieces by
        /// work budgets, the points at the end are those of one uninterrupted run.
        resume punctual_near_points_query_resume;

        remaining punctual_near_points_query_remaining;

        /// Where the last run of this query in the workspace may have missed points.
        certificate punctual_near_points_query_certificate;

        /// The middle between a missed point and the surface is in one of them.
        open_boxes punctual_near_points_query_open_boxes;
    }
}

calls! {
    /// Forgets the points, so that a query that stopped with PAIRS_FULL can be resumed. Copy them
    /// first.
    change punctual_workspace_drain_near_points(workspace: punctual_workspace) =
        drop(workspace.drain_near_points());

    /// Makes room for at least so many points, 4 bytes each.
    ///
    /// Fails with OUT_OF_MEMORY if there is not that much.
    change punctual_workspace_reserve_near_points(workspace: punctual_workspace, points: usize) = {
        find_room([(points, size_of::<u32>())])?;
        workspace.reserve_near_points(points)
    };
}

lists! {
    /// The points that the last query found, if it was for points near a surface, without those
    /// drained: by their index in the input of the cloud, in order of discovery.
    list punctual_workspace_near_points(workspace: punctual_workspace) -> points: u32 =
        workspace.near_points().iter().copied();
}

impl<'t> punctual_near_points_query<'t> {
    fn check(self) -> Result<Query<'t, PointsWithin>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        not_negative(self.distance, "query->distance")?;
        let query = Query::points_within(a, b, self.b_in_a.check()?, self.distance)?;
        Ok(query.point_limit(self.point_limit))
    }
}
