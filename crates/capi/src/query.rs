//! Queries: budget, clock and options in; an outcome or a certificate out.

use crate::arrays::list;
use crate::clock::{AnyClock, punctual_clock};
use crate::memory::punctual_memory;
use crate::mesh::punctual_aabb;
use crate::outcome::{hand_out, punctual_certificate, punctual_outcome};
use crate::pose::punctual_pose;
use crate::status::{Fault, door, given, punctual_status, value_of};
use crate::tree::punctual_tree;
use crate::workspace::punctual_workspace;
use core::mem::MaybeUninit;
use core::time::Duration;
use punctual::{Budget, DEFAULT_PRIOR, MAX_STEP_WORK, Mode, Order, PairMemory, Query, Tree, Workspace};

/// What a query looks for.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum punctual_mode {
    /// Whether there is an intersection: stops at the first.
    Any = 0,
    /// Every intersecting pair of triangles.
    All = 1,
}

/// Which node pair is visited next. All orders give the same finished answer; they differ in what is known when a budget ends.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum punctual_order {
    /// Deepest relative penetration of the boxes first; the default, and best at finding intersections early.
    Penetration = 0,
    /// Lowest product of the two alphas first.
    LowAlpha = 1,
    /// Largest relative volume of the boxes' overlap first.
    OverlapVolume = 2,
    /// Depth-first: no queue at all, the least overhead.
    DepthFirst = 3,
    /// Level by level.
    BreadthFirst = 4,
    /// At random, by `seed`.
    Random = 5,
}

/// What `limit` of a budget limits.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum punctual_budget_kind {
    /// Nothing.
    Unlimited = 0,
    /// Time from the start of the call, in nanoseconds.
    Time = 1,
    /// Units of work: where it stops depends on the input alone.
    Work = 2,
}

/// What one call may spend. Made by `punctual_budget_unlimited`, `punctual_budget_time` and `punctual_budget_work`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct punctual_budget {
    /// Nanoseconds or units of work.
    pub limit: u64,
    /// A `punctual_budget_kind`.
    pub kind: u32,
    /// Least work between looks at the clock, which bounds how late a time budget can end; PUNCTUAL_MAX_STEP_WORK by default. A
    /// frame of a scene goes by the default.
    pub poll_interval: u64,
}

/// A question: two trees, a pose, and what can be chosen. Plain data, made by `punctual_query_new`, one for each pose; it
/// borrows the trees. To resume a query or to ask for its certificate, all of it must be what it was.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_query<'t> {
    /// Tree A.
    pub a: Option<&'t punctual_tree>,
    /// Tree B; it may be the same.
    pub b: Option<&'t punctual_tree>,
    /// Brings coordinates of B into those of A.
    pub b_in_a: punctual_pose,
    /// A `punctual_mode`; MODE_ANY by default.
    pub mode: u32,
    /// A `punctual_order`; ORDER_PENETRATION by default.
    pub order: u32,
    /// For ORDER_RANDOM.
    pub seed: u64,
    /// Stop with PAIRS_FULL when this many pairs are in the workspace; by default SIZE_MAX: when it is full.
    pub pair_limit: usize,
    /// For experiments: node pairs of which fewer BV tests than this are expected are finished at once instead of being
    /// queued: 0 queues every pair, infinity none. -1 by default: 128, or 1024 under a budget of work for MODE_ALL if trees were
    /// built with `neighbors` (32 with `early`), and infinity for MODE_ANY with ORDER_PENETRATION.
    pub queue_threshold: f32,
    /// Whether finding much early is worth some more time in all, for MODE_ALL: 0 (the default) or not 0. It needs trees that
    /// were built with `neighbors`.
    pub early: u32,
    /// The share of poses with an intersection among those that are asked about, 0 to 1, which shifts the probability of
    /// `punctual_query_estimate`; by default that of the poses for which the model was fitted.
    pub prior: f64,
}

/// As much as it takes.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_budget_unlimited() -> punctual_budget {
    punctual_budget { limit: 0, kind: punctual_budget_kind::Unlimited as u32, poll_interval: MAX_STEP_WORK }
}

/// Stop within this time from the start of the call.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_budget_time(nanoseconds: u64) -> punctual_budget {
    punctual_budget { limit: nanoseconds, kind: punctual_budget_kind::Time as u32, ..punctual_budget_unlimited() }
}

/// Stop after this much work, at most PUNCTUAL_MAX_STEP_WORK later (distance queries: PUNCTUAL_MAX_DISTANCE_STEP_WORK): the
/// same bits on every machine, in every run.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_budget_work(units: u64) -> punctual_budget {
    punctual_budget { limit: units, kind: punctual_budget_kind::Work as u32, ..punctual_budget_unlimited() }
}

/// The question whether `a` and `b` intersect, with the default options. Checked when it is run.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_query_new<'t>(
    a: Option<&'t punctual_tree>,
    b: Option<&'t punctual_tree>,
    b_in_a: punctual_pose,
) -> punctual_query<'t> {
    punctual_query {
        a,
        b,
        b_in_a,
        mode: punctual_mode::Any as u32,
        order: punctual_order::Penetration as u32,
        seed: 0,
        pair_limit: usize::MAX,
        queue_threshold: -1.0,
        early: 0,
        prior: DEFAULT_PRIOR,
    }
}

/// Runs a query within a budget. It does not allocate, lock or panic. `memory` may be null; `clock` may be null: the clock of
/// the system.
///
/// Under a time budget it returns at most one poll interval of work late, under a work budget at most
/// PUNCTUAL_MAX_STEP_WORK units later. What it finds stays in the workspace.
///
/// Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the workspace is unchanged then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_query_run(
    query: Option<&punctual_query>,
    workspace: Option<&mut punctual_workspace>,
    memory: Option<&mut punctual_memory>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    outcome: Option<&mut MaybeUninit<punctual_outcome>>,
) -> punctual_status {
    door("punctual_query_run", || {
        let query = given(query, "query")?.check()?;
        // SAFETY: the contract of the header for clocks.
        unsafe { answer(workspace, memory, budget, clock, outcome, |w, m, b, c| Ok(query.run_with(w, m, b, c))) }
    })
}

/// Goes on with the stopped run that the workspace holds, with a fresh budget. However it is cut into pieces by work budgets,
/// the outcome at the end is that of one uninterrupted run.
///
/// Fails as `punctual_query_run`, and with NOT_RESUMABLE if the last run in this workspace was not of this very query or is
/// complete.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_query_resume(
    query: Option<&punctual_query>,
    workspace: Option<&mut punctual_workspace>,
    memory: Option<&mut punctual_memory>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    outcome: Option<&mut MaybeUninit<punctual_outcome>>,
) -> punctual_status {
    door("punctual_query_resume", || {
        let query = given(query, "query")?.check()?;
        // SAFETY: the contract of the header for clocks.
        unsafe { answer(workspace, memory, budget, clock, outcome, |w, m, b, c| Ok(query.resume_with(w, m, b, c)?)) }
    })
}

/// What the last run of this query in the workspace left open. Takes time linear in the open pairs; allocates nothing.
///
/// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_query_certificate(
    query: Option<&punctual_query>,
    workspace: Option<&punctual_workspace>,
    certificate: Option<&mut MaybeUninit<punctual_certificate>>,
) -> punctual_status {
    door("punctual_query_certificate", || {
        let query = given(query, "query")?.check()?;
        let certificate = given(certificate, "certificate")?;
        let open = query.certificate(given(workspace, "workspace")?.0.get("workspace")?)?;
        certificate.write(open.into());
        Ok(())
    })
}

/// Boxes in A's frame, at most one for each open pair: every missed intersection has all its points in one of them. As many
/// as `capacity` allows are written to `boxes`, and how many there are to `count`.
///
/// Fails as `punctual_query_certificate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_query_open_boxes(
    query: Option<&punctual_query>,
    workspace: Option<&punctual_workspace>,
    boxes: *mut punctual_aabb,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_query_open_boxes", || {
        let query = given(query, "query")?.check()?;
        let count = given(count, "count")?;
        let open = query.certificate(given(workspace, "workspace")?.0.get("workspace")?)?;
        // SAFETY: the contract of the header for arrays.
        unsafe { list(boxes, capacity, "boxes", count, open.boxes()) }
    })
}

/// `punctual_query_certificate` and `punctual_query_open_boxes` after `work` units of work that open the largest of the
/// boxes: the more, the less room is left and the lower is the upper bound. The run in `workspace` stays as it is and can be
/// resumed; the work is done in `aside`, another workspace, whatever that held before. Intersections that it comes across
/// have boxes too, since the query has not found them. Takes time linear in the open pairs, then that of the work; allocates
/// nothing.
///
/// Fails as `punctual_query_certificate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_query_narrowed_certificate(
    query: Option<&punctual_query>,
    workspace: Option<&punctual_workspace>,
    aside: Option<&mut punctual_workspace>,
    work: u64,
    certificate: Option<&mut MaybeUninit<punctual_certificate>>,
    boxes: *mut punctual_aabb,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_query_narrowed_certificate", || {
        let query = given(query, "query")?.check()?;
        let (certificate, count) = (given(certificate, "certificate")?, given(count, "count")?);
        let workspace = given(workspace, "workspace")?.0.get("workspace")?;
        given(aside, "aside")?.0.change("aside", |aside| {
            let open = query.narrowed_certificate(workspace, aside, work)?;
            // SAFETY: the contract of the header for arrays.
            unsafe { hand_out(&open, certificate, boxes, capacity, count) }
        })
    })
}

/// Hands what a caller passed to `run`, which runs or resumes a query, and the answer back.
///
/// # Safety
/// That of [`AnyClock::new`].
pub(crate) unsafe fn answer<Answer, Outcome: From<Answer>>(
    workspace: Option<&mut punctual_workspace>,
    memory: Option<&mut punctual_memory>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    outcome: Option<&mut MaybeUninit<Outcome>>,
    run: impl FnOnce(&mut Workspace, Option<&mut PairMemory>, Budget, &AnyClock) -> Result<Answer, Fault>,
) -> Result<(), Fault> {
    let budget = budget.check()?;
    // SAFETY: the caller's promise.
    let clock = unsafe { AnyClock::new(clock) }?;
    let outcome = given(outcome, "outcome")?;
    let answer = given(workspace, "workspace")?.0.change("workspace", |workspace| match memory {
        Some(memory) => memory.0.change("memory", |memory| run(workspace, Some(memory), budget, &clock)),
        None => run(workspace, None, budget, &clock),
    })?;
    outcome.write(answer.into());
    Ok(())
}

/// The trees of a query.
pub(crate) fn trees<'t>(a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>) -> Result<[&'t Tree; 2], Fault> {
    Ok([given(a, "query->a")?.0.get("query->a")?, given(b, "query->b")?.0.get("query->b")?])
}

impl punctual_query<'_> {
    pub(crate) fn check(&self) -> Result<Query<'_>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        use Order::{BreadthFirst, DepthFirst, LowAlpha, OverlapVolume, Penetration, Random};
        let orders = [Penetration, LowAlpha, OverlapVolume, DepthFirst, BreadthFirst, Random(self.seed)];
        let order = value_of(self.order, "query->order", &orders)?;
        if self.queue_threshold.is_nan() {
            return Err(Fault::Number("query->queue_threshold", f64::NAN));
        }
        if self.prior.is_nan() {
            return Err(Fault::Number("query->prior", self.prior));
        }
        let query = Query::new(a, b, self.b_in_a.check()?).mode(check_mode(self.mode, "query->mode")?).order(order);
        let query = if self.queue_threshold < 0.0 { query } else { query.queue_threshold(self.queue_threshold) };
        let query = query.pair_limit(self.pair_limit).early(self.early != 0);
        Ok(query.prior(self.prior))
    }
}

pub(crate) fn check_mode(value: u32, what: &'static str) -> Result<Mode, Fault> {
    value_of(value, what, &[Mode::Any, Mode::All])
}

impl punctual_budget {
    pub(crate) fn check(self) -> Result<Budget, Fault> {
        let time = Budget::time(Duration::from_nanos(self.limit));
        let budget = value_of(self.kind, "budget.kind", &[Budget::unlimited(), time, Budget::work(self.limit)])?;
        Ok(budget.poll_interval(self.poll_interval))
    }
}
