//! Push-out: two trees, a pose and a budget in; a translation that parts the surfaces out.

use crate::budget::{punctual_budget, punctual_clock};
use crate::outcome::{nanoseconds, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::{answer, trees};
use crate::sized::{begin, grows, read};
use crate::status::{Fault, door, punctual_status};
use crate::tree::punctual_tree;
use crate::workspace::punctual_workspace;
use punctual::Pose;
use punctual::glam::DVec3;
use punctual_depenetrate::{PushOut, PushOutQuery};

/// The question which way, and how far, B has to be moved until the surfaces no longer meet. Plain data, made by
/// `punctual_push_out_query_new`, one for each pose; it borrows the trees.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_push_out_query<'t> {
    /// Its size in bytes, as made.
    pub size: u32,
    /// Stop after this many exact queries. UINT32_MAX by default: the search ends by itself.
    pub query_limit: u32,
    /// Tree A.
    pub a: Option<&'t punctual_tree>,
    /// Tree B; it may be the same.
    pub b: Option<&'t punctual_tree>,
    /// Brings coordinates of B into those of A.
    pub b_in_a: punctual_pose,
}

grows!(punctual_push_out_query<'_>: size, b_in_a..b_in_a);

/// The answer: the shortest push found. There may be a shorter one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_push_out {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Whether the budget sufficed for one; if not, direction, distance and pose are zeros.
    pub has_push: bool,
    /// Where B moves to, a unit vector in A's frame; the x axis if the surfaces do not meet anyway.
    pub direction: punctual_point,
    /// How far, in the unit of the meshes; 0 if the surfaces do not meet anyway.
    pub distance: f64,
    /// The pose after the push. Proven: no triangle of A shares a point with one of B there.
    pub b_in_a: punctual_pose,
    /// Exact queries that were run.
    pub queries: u32,
    /// Why it returned; STOP_REASON_FINISHED also at the limit of queries.
    pub stop: punctual_stop_reason,
    /// Units of work.
    pub work: u64,
    /// Time in nanoseconds; -1 if it was not measured, which it is only under a time budget.
    pub elapsed: i64,
}

grows!(punctual_push_out: size, has_push..elapsed);

impl Default for punctual_push_out_query<'_> {
    fn default() -> Self {
        Self {
            size: Self::SIZE,
            query_limit: u32::MAX,
            a: None,
            b: None,
            b_in_a: (&Pose::IDENTITY).into(),
        }
    }
}

/// The question how `b` is pushed out of `a`, with the default options. Checked when it is run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_push_out_query_init<'t>(
    query: *mut punctual_push_out_query<'t>,
    size: usize,
    a: Option<&'t punctual_tree>,
    b: Option<&'t punctual_tree>,
    b_in_a: punctual_pose,
) {
    // SAFETY: the contract of the header for structs.
    unsafe {
        begin(
            query,
            size,
            punctual_push_out_query {
                a,
                b,
                b_in_a,
                ..Default::default()
            },
        )
    }
}

/// Looks for a push within a budget. More budget of work never gives a longer one. It does not allocate, lock or panic; afterwards
/// the workspace holds nothing that could be resumed. `clock` may be null: the clock of the system.
///
/// Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the workspace is unchanged then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_push_out_query_run(
    query: *const punctual_push_out_query<'_>,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    push: *mut punctual_push_out,
) -> punctual_status {
    door("punctual_push_out_query_run", || {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let query = read(query, "query")?.check()?;
            answer(workspace, None, budget, clock, push, |w, _, b| {
                Ok(query.run(w, b))
            })
        }
    })
}

impl<'t> punctual_push_out_query<'t> {
    fn check(self) -> Result<PushOutQuery<'t>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        let query = PushOutQuery::new(a, b, self.b_in_a.check()?);
        Ok(query.query_limit(self.query_limit))
    }
}

impl From<PushOut> for punctual_push_out {
    fn from(found: PushOut) -> Self {
        let (direction, distance, b_in_a) =
            found.push.map_or((DVec3::ZERO, 0.0, [0.0; 12]), |push| {
                (push.direction, push.distance, push.b_in_a.to_row_major())
            });
        Self {
            size: Self::SIZE,
            has_push: found.push.is_some(),
            direction: direction.into(),
            distance,
            b_in_a: punctual_pose { m: b_in_a },
            queries: found.queries,
            stop: found.stop.into(),
            work: found.work,
            elapsed: nanoseconds(found.elapsed),
        }
    }
}
