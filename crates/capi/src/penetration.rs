//! Penetration: two trees, a pose and a budget in; bounds of the depth and a push out.

use crate::handle::{Handle, put};
use crate::outcome::{nanoseconds, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::sized::grows;
use crate::status::{Fault, free};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, question};
use core::mem::MaybeUninit;
use punctual::Pose;
use punctual::glam::DVec3;
use punctual_depenetrate::{Penetration, PenetrationQuery, PenetrationWorkspace};

/// Every buffer that a penetration query needs, about 2 MB, and what the last one left open.
/// Allocated once: queries do not allocate. One thread at a time may use it.
#[derive(Debug)]
pub struct punctual_penetration_workspace(pub(crate) Handle<PenetrationWorkspace>);

/// Whether two bodies penetrate each other deeper than the `deeper_than` of a query.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum punctual_deeper {
    /// Not known: the budget ended first, it was not asked, or the depth is the limit up to the
    /// rounding of numbers as large as the meshes.
    Undecided = 0,
    /// Proven: no translation that is as short as the limit parts them.
    Yes = 1,
    /// Proven: a translation no longer than the limit parts them.
    No = 2,
}

/// The question how far B has to be moved, at least, until the bodies are apart. Plain data, made
/// by `punctual_penetration_query_new`, one for each pose; it borrows the trees. To resume a query,
/// all of it must be what it was.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_penetration_query<'t> {
    /// Its size in bytes, as made.
    pub size: u32,
    /// Whether closed components of trees that were built as solids are solids: 0 or not 0. Then a
    /// body inside of the other penetrates it. 0 by default.
    pub solid: u16,
    /// Whether only a short push is looked for, so that low stays 0: 0 or not 0. The query is then
    /// finished when it has tried 32 directions all around and turned the best one. 0 by default.
    pub push_only: u16,
    /// Tree A.
    pub a: Option<&'t punctual_tree>,
    /// Tree B; it may be the same.
    pub b: Option<&'t punctual_tree>,
    /// Brings coordinates of B into those of A.
    pub b_in_a: punctual_pose,
    /// Finished as soon as high <= (1 + this) low; 0.001 by default. Negative values and NaN count
    /// as 0.
    pub relative_tolerance: f64,
    /// Finished as soon as high <= low + this, too; 0 by default. Negative values and NaN count as
    /// 0.
    pub absolute_tolerance: f64,
    /// Finished as soon as it is known whether the bodies penetrate each other deeper than this,
    /// whatever the tolerances; infinite by default, which asks nothing. Negative values and NaN
    /// count as 0.
    pub deeper_than: f64,
}

grows!(punctual_penetration_query<'_>: size, relative_tolerance..deeper_than);

/// The answer: low <= depth <= high, both proven, also where a budget ended the query. Lengths are
/// in the unit of the meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_penetration {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Whether a push is known; if not, the bodies are apart, or the budget ended before one was
    /// found, and the direction is zeros.
    pub has_push: bool,
    /// Where B moves to, a unit vector in A's frame.
    pub direction: punctual_point,
    /// No shorter translation of B parts the bodies.
    pub low: f64,
    /// The length of the push; 0 if they are apart, infinite if none is known.
    pub high: f64,
    /// The pose after the push, at which they are apart: proven. The pose of the query if no push
    /// is known.
    pub b_in_a: punctual_pose,
    /// Why it returned.
    pub stop: punctual_stop_reason,
    /// The answer to `deeper_than`.
    pub deeper: punctual_deeper,
    /// Units of work, resumed calls included.
    pub work: u64,
    /// Time in nanoseconds, resumed calls included; -1 if it was not measured, which it is only
    /// under a time budget.
    pub elapsed: i64,
}

grows!(punctual_penetration: size, has_push..elapsed);

impl Default for punctual_penetration_query<'_> {
    fn default() -> Self {
        Self {
            size: Self::SIZE,
            solid: 0,
            push_only: 0,
            a: None,
            b: None,
            b_in_a: (&Pose::IDENTITY).into(),
            relative_tolerance: 1e-3,
            absolute_tolerance: 0.0,
            deeper_than: f64::INFINITY,
        }
    }
}

calls! {
    /// Makes a workspace.
    fn punctual_penetration_workspace_new(
        workspace: Option<&mut MaybeUninit<Option<Box<punctual_penetration_workspace>>>>
    ) {
        put(workspace, || {
            Ok(punctual_penetration_workspace(Handle::new(PenetrationWorkspace::new())))
        })
    }
}

/// Frees a workspace; null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_penetration_workspace_free(
    workspace: Option<Box<punctual_penetration_workspace>>,
) {
    free(workspace);
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

impl From<punctual::Answer<Penetration>> for punctual_penetration {
    fn from(found: punctual::Answer<Penetration>) -> Self {
        Self {
            size: Self::SIZE,
            has_push: found.value.direction.is_some(),
            direction: found.value.direction.unwrap_or(DVec3::ZERO).into(),
            low: found.value.low,
            high: found.value.high,
            b_in_a: (&found.value.b_in_a).into(),
            stop: found.stop.into(),
            deeper: match found.value.deeper {
                None => punctual_deeper::Undecided,
                Some(true) => punctual_deeper::Yes,
                Some(false) => punctual_deeper::No,
            },
            work: found.stats.work,
            elapsed: nanoseconds(found.stats.elapsed),
        }
    }
}
