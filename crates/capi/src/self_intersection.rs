//! Self-intersections: a tree in; pairs of its triangles out.

use crate::handle::get;
use crate::query::{check_mode, punctual_mode, punctual_outcome};
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{inits, question, types};
use crate::workspace::punctual_workspace;
use punctual::Query;
use punctual::intersection::SelfIntersection;

types! {
    /// The question where a surface intersects itself. Plain data, made by
    /// `punctual_self_query_new`; it borrows the tree. To resume a query or to ask for its
    /// certificate, all of it must be what it was.
    ///
    /// Triangles without a common corner count if they share a point; with one, if they share
    /// another point; with a common edge, if they are coplanar and on the same side of it. Corners
    /// are common if their positions are equal. A triangle that is there twice counts.
    asked punctual_self_query<'t>(pair_limit) {
        /// A `punctual_mode`; MODE_ALL by default.
        mode: u32 = punctual_mode::All as u32,
        /// The tree.
        tree: Option<&'t punctual_tree> = None,
        /// Stop with PAIRS_FULL when this many pairs are in the workspace; by default SIZE_MAX:
        /// when it is full.
        pair_limit: usize = usize::MAX,
    }
}

inits! {
    /// The question for all pairs of triangles of a mesh that intersect. Checked when it is run.
    punctual_self_query_init(
        query: punctual_self_query<'t>, tree: Option<&'t punctual_tree>
    ) { tree }
}

question! {
    punctual_self_query(punctual_workspace) -> punctual_outcome {
        /// Runs a query within a budget. It does not allocate, lock or panic. The pairs stay in the
        /// workspace, each once, the lower triangle first.
        ///
        /// Under a time budget it returns at most one poll interval of work late, under a work
        /// budget at most PUNCTUAL_MAX_STEP_WORK units later.
        run punctual_self_query_run;

        /// However it is cut into pieces by work budgets, the outcome at the end is that of one
        /// uninterrupted run.
        resume punctual_self_query_resume;

        /// What the last run of this query in the workspace left open.
        certificate punctual_self_query_certificate;

        /// Every missed intersection has all its points in one of them.
        open_boxes punctual_self_query_open_boxes;

        remaining punctual_self_query_remaining;
    }
}

impl<'t> punctual_self_query<'t> {
    pub(crate) fn check(self) -> Result<Query<'t, SelfIntersection>, Fault> {
        let tree = get(self.tree, "query->tree")?;
        Ok(Query::self_intersections(tree)
            .mode(check_mode(self.mode, "query->mode")?)
            .pair_limit(self.pair_limit))
    }
}
