//! Motion queries: two trees, how they move, and tolerances in; proven times out.

use crate::arrays::list;
use crate::budget::{punctual_budget, punctual_clock};
use crate::distance::{check_margins, finite, finite_or_default};
use crate::estimate::{punctual_remaining, tell};
use crate::memory::{known, punctual_memory};
use crate::outcome::{
    punctual_certificate, punctual_quantiles, punctual_stats, punctual_stop_reason,
};
use crate::pose::{punctual_aabb, punctual_point, punctual_pose};
use crate::query::{answer, trees};
use crate::sized::{begin, grows, place, read};
use crate::status::{Fault, door, given, punctual_status};
use crate::tree::punctual_tree;
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use core::mem::MaybeUninit;
use punctual::glam::DVec3;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Motion, Pose, Query};

/// A rigid motion in one unit of time, from time 0 to 1: constant velocity, and constant turn about an axis that moves along. At
/// time `t` a point that `start` brings to `x` is at `p + t velocity + R(t turn) (x - p)`, where `p` is a point of the axis at
/// time 0. It is checked wherever it is used.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_motion {
    /// Where it begins.
    pub start: punctual_pose,
    /// The velocity of the axis: length per unit of time.
    pub velocity: punctual_point,
    /// The axis by the right-hand rule, times the angle in radians; zeros: no turn.
    pub turn: punctual_point,
    /// From a point of the axis to the origin of the body at time 0; zeros: the axis goes through it.
    pub arm: punctual_point,
}

/// A straight line without turn.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_motion_straight(
    start: punctual_pose,
    velocity: punctual_point,
) -> punctual_motion {
    let none = DVec3::ZERO.into();
    punctual_motion {
        start,
        velocity,
        turn: none,
        arm: none,
    }
}

/// The screw from one pose to another: a turn of at most half a circle about an axis, and a shift along it.
///
/// Fails with BAD_POSE or BAD_ARGUMENT.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_motion_screw(
    start: punctual_pose,
    end: punctual_pose,
    motion: Option<&mut MaybeUninit<punctual_motion>>,
) -> punctual_status {
    door("punctual_motion_screw", || {
        let motion = given(motion, "motion")?;
        motion.write(Motion::screw(start.check()?, end.check()?)?.into());
        Ok(())
    })
}

/// Where the body is at a time, 0 to 1; times outside are taken for 0 or 1, and NaN for 0.
///
/// Fails with BAD_POSE or BAD_ARGUMENT.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_motion_pose(
    motion: Option<&punctual_motion>,
    time: f64,
    pose: Option<&mut MaybeUninit<punctual_pose>>,
) -> punctual_status {
    door("punctual_motion_pose", || {
        let motion = given(motion, "motion")?.check()?;
        given(pose, "pose")?.write((&motion.pose(time)).into());
        Ok(())
    })
}

/// The question until when a motion is free, and when the surfaces meet. Plain data, made by `punctual_motion_query_new`, one
/// for each motion; it borrows the trees. To resume a query all of it must be what it was. Lengths are in the unit of the meshes,
/// times from 0 to 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_motion_query<'t> {
    /// Its size in bytes, as made.
    pub size: u32,
    /// Whether A moves too: 0 (the default) or not 0.
    pub a_moves: u32,
    /// Tree A.
    pub a: Option<&'t punctual_tree>,
    /// Tree B; it may be the same.
    pub b: Option<&'t punctual_tree>,
    /// How B moves: in A's frame, or in the world if A moves too.
    pub of_b: punctual_motion,
    /// How, in the world.
    pub of_a: punctual_motion,
    /// Done when nothing moves farther than this, seen from A, between the two times; 0: as close as double can tell. -1 by
    /// default, as any negative number: a millionth of the longest extent of the smaller mesh, roughly.
    pub tolerance: f64,
    /// Done also when the two times differ by no more than this. 0 by default.
    pub time_tolerance: f64,
    /// By how much each surface is thickened, A's first. 0 by default.
    pub margins: [f64; 2],
}

grows!(punctual_motion_query<'_>: size, of_b..margins);

/// The answer of a motion query, wherever it stopped; times from 0 to 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_passage {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Proven: the surfaces meet at no time before. 1 without a contact: the motion is free to its end.
    pub free_until: f64,
    /// Whether a contact was found (yet); if not, its time and the triangles are zeros.
    pub touches: bool,
    /// Proven: the surfaces meet at this time; 0 if they do at the start.
    pub touching_at: f64,
    /// The triangles that meet then.
    pub triangles: punctual_triangle_pair,
    /// Why the query returned.
    pub stop: punctual_stop_reason,
    /// What it has done.
    pub stats: punctual_stats,
}

grows!(punctual_passage: size, free_until..stats);

impl Default for punctual_motion_query<'_> {
    fn default() -> Self {
        let still = punctual_motion_straight((&Pose::IDENTITY).into(), DVec3::ZERO.into());
        Self {
            size: Self::SIZE,
            a_moves: 0,
            a: None,
            b: None,
            of_b: still,
            of_a: still,
            tolerance: -1.0,
            time_tolerance: 0.0,
            margins: [0.0; 2],
        }
    }
}

/// The question until when the motion of `b` in the frame of `a` is free, with the default options. Checked when it is run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_init<'t>(
    query: *mut punctual_motion_query<'t>,
    size: usize,
    a: Option<&'t punctual_tree>,
    b: Option<&'t punctual_tree>,
    b_in_a: punctual_motion,
) {
    // SAFETY: the contract of the header for structs.
    unsafe {
        begin(
            query,
            size,
            punctual_motion_query {
                a,
                b,
                of_b: b_in_a,
                ..Default::default()
            },
        )
    }
}

/// Runs a motion query within a budget. It does not allocate, lock or panic. `memory` may be null: what it knows of the motion
/// before makes the answer faster; `clock` may be null: the clock of the system.
///
/// Under a time budget it returns at most one poll interval of work late, under a work budget at most
/// PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
///
/// Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the workspace is unchanged then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_run(
    query: *const punctual_motion_query<'_>,
    workspace: Option<&mut punctual_workspace>,
    memory: Option<&mut punctual_memory>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    outcome: *mut punctual_passage,
) -> punctual_status {
    door("punctual_motion_query_run", || {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let query = read(query, "query")?.check()?;
            answer(workspace, memory, budget, clock, outcome, |w, m, b| {
                Ok(query.with_memory(m).run(w, b))
            })
        }
    })
}

/// Goes on with the stopped run that the workspace holds, with a fresh budget. However it is cut into pieces by work budgets, the
/// outcome at the end is that of one uninterrupted run.
///
/// Fails as `punctual_motion_query_run`, and with NOT_RESUMABLE if the last run in this workspace was not of this very query or
/// is complete.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_resume(
    query: *const punctual_motion_query<'_>,
    workspace: Option<&mut punctual_workspace>,
    memory: Option<&mut punctual_memory>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    outcome: *mut punctual_passage,
) -> punctual_status {
    door("punctual_motion_query_resume", || {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let query = read(query, "query")?.check()?;
            answer(workspace, memory, budget, clock, outcome, |w, m, b| {
                Ok(query.with_memory(m).resume(w, b)?)
            })
        }
    })
}

/// Units of work that this query will take if nothing stops it, given what is remembered of the pair; `memory` may be null. A rough
/// guess: nine of ten queries are within a factor of 8.6 of the median. Takes constant time and allocates nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_predict(
    query: *const punctual_motion_query<'_>,
    memory: Option<&punctual_memory>,
    work: Option<&mut MaybeUninit<punctual_quantiles>>,
) -> punctual_status {
    door("punctual_motion_query_predict", || {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        given(work, "work")?.write(query.predict(known(memory)?).into());
        Ok(())
    })
}

/// What the last run of this query in the workspace has still to do, given what is remembered of the pair; `memory` may be
/// null, and learns from it when the query has ended.
/// Takes less than a microsecond and allocates nothing.
///
/// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_remaining(
    query: *const punctual_motion_query<'_>,
    workspace: Option<&punctual_workspace>,
    memory: Option<&punctual_memory>,
    remaining: *mut punctual_remaining,
) -> punctual_status {
    door("punctual_motion_query_remaining", || {
        // SAFETY: the contract of the header for structs.
        unsafe {
            tell(
                &read(query, "query")?.check()?,
                workspace,
                memory,
                remaining,
            )
        }
    })
}

/// Where the surfaces may still meet before the contact that the last run of this query in the workspace found, if any.
/// Takes time
/// linear in the open pairs; allocates nothing.
///
/// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_certificate(
    query: *const punctual_motion_query<'_>,
    workspace: Option<&punctual_workspace>,
    certificate: *mut punctual_certificate,
) -> punctual_status {
    door("punctual_motion_query_certificate", || {
        // SAFETY: the contract of the header for structs.
        let (query, certificate) = unsafe {
            (
                read(query, "query")?.check()?,
                place(certificate, "certificate")?,
            )
        };
        certificate.write(
            query
                .certificate(given(workspace, "workspace")?.0.get("workspace")?)?
                .into(),
        );
        Ok(())
    })
}

/// Boxes in A's frame, at most one for each open pair: where the surfaces meet before the contact that was found, if
/// any, all points
/// of A that B touches are in one of them. As many as `capacity` allows are written to `boxes`, and how many there are
/// to
/// `count`.
///
/// Fails as `punctual_motion_query_certificate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_motion_query_open_boxes(
    query: *const punctual_motion_query<'_>,
    workspace: Option<&punctual_workspace>,
    boxes: *mut punctual_aabb,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_motion_query_open_boxes", || {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        let count = given(count, "count")?;
        let open = query.certificate(given(workspace, "workspace")?.0.get("workspace")?)?;
        // SAFETY: the contract of the header for arrays.
        unsafe { list(boxes, capacity, "boxes", count, open.boxes()) }
    })
}

impl punctual_motion {
    pub(crate) fn check(&self) -> Result<Motion, Fault> {
        let vector = |v: punctual_point| [v.x, v.y, v.z];
        Ok(Motion::with_arm(
            self.start.check()?,
            vector(self.velocity),
            vector(self.turn),
            vector(self.arm),
        )?)
    }
}

impl From<Motion> for punctual_motion {
    fn from(motion: Motion) -> Self {
        let [velocity, turn, arm] =
            [motion.velocity(), motion.turn(), motion.arm()].map(Into::into);
        Self {
            start: (&motion.start()).into(),
            velocity,
            turn,
            arm,
        }
    }
}

impl<'t> punctual_motion_query<'t> {
    pub(crate) fn check(self) -> Result<Query<'t, Impact>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        finite_or_default(self.tolerance, "query->tolerance")?;
        finite(self.time_tolerance, "query->time_tolerance")?;
        check_margins(self.margins)?;
        let of_b = self.of_b.check()?;
        let query = if self.a_moves != 0 {
            Query::impact_of_both([a, b], [self.of_a.check()?, of_b])
        } else {
            Query::impact(a, b, of_b)
        };
        let query = match self.tolerance {
            ..0.0 => query,
            length => query.tolerance(length),
        };
        Ok(query
            .time_tolerance(self.time_tolerance)
            .margins(self.margins))
    }
}

impl From<Answer<TimeOfImpact>> for punctual_passage {
    fn from(passage: Answer<TimeOfImpact>) -> Self {
        Self {
            size: Self::SIZE,
            free_until: passage.value.lower,
            touches: passage.value.upper.is_some(),
            touching_at: passage.value.upper.unwrap_or(0.0),
            triangles: passage.value.triangles.unwrap_or_default().into(),
            stop: passage.stop.into(),
            stats: passage.stats.into(),
        }
    }
}
