//! Queries: budget, clock and options in; an outcome or a certificate out.

use crate::budget::{punctual_budget, punctual_clock};
use crate::handle::{Holds, change, get};
use crate::memory::punctual_memory;
use crate::outcome::{punctual_stats, punctual_stop_reason, punctual_verdict, verdict};
use crate::pose::punctual_pose;
use crate::sized::{Sized32, place};
use crate::status::{Fault, value_of};
use crate::tree::punctual_tree;
use crate::verbs::{inits, question, types};
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use punctual::clock::ClockedBudget;
use punctual::intersection::{Intersection, Order};
use punctual::prediction::DEFAULT_PRIOR;
use punctual::{Answer, Mode, PairMemory, Query, Tree, Verdict};

types! {
    /// What a query looks for.
    enum punctual_mode {
        /// Whether there is an intersection: stops at the first.
        Any = 0,
        /// Every intersecting pair of triangles.
        All = 1,
    }

    /// Which node pair is visited next. All orders give the same finished answer; they differ in
    /// what is known when a budget ends.
    enum punctual_order {
        /// Deepest relative penetration of the boxes first; the default, and best at finding
        /// intersections early.
        Penetration = 0,
        /// Lowest product of the two alphas first.
        LowAlpha = 1,
        /// Depth-first: no queue at all, the least overhead.
        DepthFirst = 2,
    }

    /// A question: two trees, a pose, and what can be chosen. Plain data, made by
    /// `punctual_query_new`, one for each pose; it borrows the trees. To resume a query or to ask
    /// for its certificate, all of it must be what it was.
    asked punctual_query<'t>(b_in_a) {
        /// Tree A.
        a: Option<&'t punctual_tree> = None,
        /// Tree B; it may be the same.
        b: Option<&'t punctual_tree> = None,
        /// Brings coordinates of B into those of A.
        b_in_a: punctual_pose = punctual_pose::IDENTITY,
        /// A `punctual_mode`; MODE_ANY by default.
        mode: u32 = punctual_mode::Any as u32,
        /// A `punctual_order`; ORDER_PENETRATION by default.
        order: u32 = punctual_order::Penetration as u32,
        /// Stop with PAIRS_FULL when this many pairs are in the workspace; by default SIZE_MAX:
        /// when it is full.
        pair_limit: usize = usize::MAX,
        /// The share of poses with an intersection among those that are asked about, 0 to 1, which
        /// shifts the probability of `punctual_query_estimate`; by default that of the poses for
        /// which the model was fitted.
        prior: f64 = DEFAULT_PRIOR,
    }

    /// The answer of a query. The found pairs stay in the workspace: `punctual_workspace_pairs`.
    told punctual_outcome(witness) from (found: Answer<Verdict>) {
        /// Whether the surfaces meet.
        verdict: punctual_verdict = verdict(found.value).0,
        /// Why the query returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// If they meet, two triangles that do; else zeros.
        witness: punctual_triangle_pair = verdict(found.value).1,
        /// Intersecting pairs found, resumed calls and drained pairs included; at most 1 for
        /// MODE_ANY.
        found: u64 = found.stats.found,
        /// What it has done.
        stats: punctual_stats = found.stats.into(),
    }
}

inits! {
    /// The question whether `a` and `b` intersect, with the default options. Checked when it is
    /// run.
    punctual_query_init(
        query: punctual_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_pose
    ) { a, b, b_in_a }
}

question! {
    punctual_query(punctual_workspace, memory) -> punctual_outcome {
        /// Runs a query within a budget. It does not allocate, lock or panic. `memory` may be null.
        ///
        /// Under a time budget it returns at most one poll interval of work late, under a work
        /// budget at most PUNCTUAL_MAX_STEP_WORK units later. What it finds stays in the workspace.
        run punctual_query_run;

        /// However it is cut into pieces by work budgets, the outcome at the end is that of one
        /// uninterrupted run.
        resume punctual_query_resume;

        /// What the last run of this query in the workspace left open.
        certificate punctual_query_certificate;

        /// Every missed intersection has all its points in one of them.
        open_boxes punctual_query_open_boxes;

        remaining punctual_query_remaining;
    }
}

/// Hands what a caller passed to `run`, which runs or resumes a query, and the answer back.
///
/// # Safety
/// That of [`punctual_budget::spend`] and of [`place`].
pub(crate) unsafe fn answer<H: Holds, Found, Written: Sized32 + From<Found>>(
    workspace: Option<&mut H>,
    memory: Option<&mut punctual_memory>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    outcome: *mut Written,
    run: impl FnOnce(&mut H::Value, Option<&mut PairMemory>, ClockedBudget<'_>) -> Result<Found, Fault>,
) -> Result<(), Fault> {
    let spend = |budget: ClockedBudget<'_>| {
        // SAFETY: the caller's promise.
        let outcome = unsafe { place(outcome, "outcome") }?;
        let found = change(workspace, "workspace", |workspace| match memory {
            Some(memory) => change(Some(memory), "memory", |memory| {
                run(workspace, Some(memory), budget)
            }),
            None => run(workspace, None, budget),
        })?;
        outcome.write(found.into());
        Ok(())
    };
    // SAFETY: the same.
    unsafe { budget.spend(clock, spend) }
}

/// The trees of a query.
pub(crate) fn trees<'t>(
    a: Option<&'t punctual_tree>,
    b: Option<&'t punctual_tree>,
) -> Result<[&'t Tree; 2], Fault> {
    Ok([get(a, "query->a")?, get(b, "query->b")?])
}

impl<'t> punctual_query<'t> {
    pub(crate) fn check(self) -> Result<Query<'t, Intersection>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        let orders = [Order::Penetration, Order::LowAlpha, Order::DepthFirst];
        let order = value_of(self.order, "query->order", &orders)?;
        if self.prior.is_nan() {
            return Err(Fault::Number("query->prior", self.prior));
        }
        Ok(Query::intersection(a, b, self.b_in_a.check()?)
            .mode(check_mode(self.mode, "query->mode")?)
            .order(order)
            .pair_limit(self.pair_limit)
            .prior(self.prior))
    }
}

pub(crate) fn check_mode(value: u32, what: &'static str) -> Result<Mode, Fault> {
    value_of(value, what, &[Mode::Any, Mode::All])
}
