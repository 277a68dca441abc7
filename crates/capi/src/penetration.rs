//! Penetration: two trees, a pose and a budget in; bounds of the depth and a push out.

use crate::outcome::{nanoseconds, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::status::Fault;
use crate::tree::punctual_tree;
use crate::verbs::{calls, handles, inits, question, types};
use punctual_depenetrate::{Penetration, PenetrationQuery, PenetrationWorkspace};

handles! {
    /// Every buffer that a penetration query needs, about 2 MB, and what the last one left open.
    /// Allocated once: queries do not allocate. One thread at a time may use it.
    punctual_penetration_workspace(PenetrationWorkspace);

    /// Frees a workspace; null is fine.
    punctual_penetration_workspace_free(workspace);
}

types! {
    /// Whether two bodies penetrate each other deeper than the `deeper_than` of a query.
    enum punctual_deeper from bool {
        /// Not known: the budget ended first, it was not asked, or the depth is the limit up to the
        /// rounding of numbers as large as the meshes.
        Undecided = 0,
        /// Proven: no translation that is as short as the limit parts them.
        Yes = 1,
        /// Proven: a translation no longer than the limit parts them.
        No = 2,
    }

    /// The question how far B has to be moved, at least, until the bodies are apart. Plain data,
    /// made by `punctual_penetration_query_new`, one for each pose; it borrows the trees. To resume
    /// a query, all of it must be what it was.
    asked punctual_penetration_query<'t>(relative_tolerance) {
        /// Whether closed components of trees that were built as solids are solids: 0 or not 0.
        /// Then a body inside of the other penetrates it. 0 by default.
        solid: u16 = 0,
        /// Whether only a short push is looked for, so that low stays 0: 0 or not 0. The query is
        /// then finished when it has tried 32 directions all around and turned the best one. 0 by
        /// default.
        push_only: u16 = 0,
        /// Tree A.
        a: Option<&'t punctual_tree> = None,
        /// Tree B; it may be the same.
        b: Option<&'t punctual_tree> = None,
        /// Brings coordinates of B into those of A.
        b_in_a: punctual_pose = punctual_pose::IDENTITY,
        /// Finished as soon as high <= (1 + this) low; 0.001 by default. Negative values and NaN
        /// count as 0.
        relative_tolerance: f64 = 1e-3,
        /// Finished as soon as high <= low + this, too; 0 by default. Negative values and NaN count
        /// as 0.
        absolute_tolerance: f64 = 0.0,
        /// Finished as soon as it is known whether the bodies penetrate each other deeper than
        /// this, whatever the tolerances; infinite by default, which asks nothing. Negative values
        /// and NaN count as 0.
        deeper_than: f64 = f64::INFINITY,
    }

    /// The answer: low <= depth <= high, both proven, also where a budget ended the query. Lengths
    /// are in the unit of the meshes.
    told punctual_penetration(has_push) from (found: punctual::Answer<Penetration>) {
        /// Whether a push is known; if not, the bodies are apart, or the budget ended before one
        /// was found, and the direction is zeros.
        has_push: bool = found.value.direction.is_some(),
        /// Where B moves to, a unit vector in A's frame.
        direction: punctual_point = found.value.direction.unwrap_or_default().into(),
        /// No shorter translation of B parts the bodies.
        low: f64 = found.value.low,
        /// The length of the push; 0 if they are apart, infinite if none is known.
        high: f64 = found.value.high,
        /// The pose after the push, at which they are apart: proven. The pose of the query if no
        /// push is known.
        b_in_a: punctual_pose = (&found.value.b_in_a).into(),
        /// Why it returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// The answer to `deeper_than`.
        deeper: punctual_deeper = found.value.deeper.into(),
        /// Units of work, resumed calls included.
        work: u64 = found.stats.work,
        /// Time in nanoseconds, resumed calls included; -1 if it was not measured, which it is only
        /// under a time budget.
        elapsed: i64 = nanoseconds(found.stats.elapsed),
    }
}

calls! {
    /// Makes a workspace.
    make punctual_penetration_workspace_new() -> workspace: punctual_penetration_workspace =
        PenetrationWorkspace::new();
}

inits! {
    /// The question how deep `a` and `b` penetrate each other, with the default options. Checked
    /// when it is run.
    punctual_penetration_query_init(
        query: punctual_penetration_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_pose
    ) { a, b, b_in_a }
}

question! {
    punctual_penetration_query(punctual_penetration_workspace) -> punctual_penetration {
        /// Bounds the depth within a budget. It does not allocate, lock or panic.
        run punctual_penetration_query_run;

        resume punctual_penetration_query_resume;
    }
}

impl<'t> punctual_penetration_query<'t> {
    fn check(self) -> Result<PenetrationQuery<'t>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        let query = PenetrationQuery::new(a, b, self.b_in_a.check()?);
        let query = query.solid(self.solid != 0).push_only(self.push_only != 0);
        let query = query.relative_tolerance(self.relative_tolerance);
        let query = query.absolute_tolerance(self.absolute_tolerance);
        Ok(query.deeper_than(self.deeper_than))
    }
}
