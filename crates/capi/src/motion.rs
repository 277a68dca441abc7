//! Motion queries: two trees, how they move, and tolerances in; proven times out.

use crate::distance::{check_margins, finite, finite_or_default};
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::sized::grows;
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, question};
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use core::mem::MaybeUninit;
use punctual::glam::DVec3;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Motion, Pose, Query};

/// A rigid motion in one unit of time, from time 0 to 1: constant velocity, and constant turn about
/// an axis that moves along. At time `t` a point that `start` brings to `x` is at `p + t velocity +
/// R(t turn) (x - p)`, where `p` is a point of the axis at time 0. It is checked wherever it is
/// used.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_motion {
    /// Where it begins.
    pub start: punctual_pose,
    /// The velocity of the axis: length per unit of time.
    pub velocity: punctual_point,
    /// The axis by the right-hand rule, times the angle in radians; zeros: no turn.
    pub turn: punctual_point,
    /// From a point of the axis to the origin of the body at time 0; zeros: the axis goes through
    /// it.
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

question! {
    punctual_motion_query(punctual_workspace, memory) -> punctual_passage {
        /// Runs a motion query within a budget. It does not allocate, lock or panic. `memory` may
        /// be null: what it knows of the motion before makes the answer faster.
        ///
        /// Under a time budget it returns at most one poll interval of work late, under a work
        /// budget at most PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
        run punctual_motion_query_run;

        /// However it is cut into pieces by work budgets, the outcome at the end is that of one
        /// uninterrupted run.
        resume punctual_motion_query_resume;

        /// A rough guess: nine of ten queries are within a factor of 8.6 of the median.
        predict punctual_motion_query_predict;

        remaining punctual_motion_query_remaining;

        /// Where the surfaces may still meet before the contact that the last run of this query in
        /// the workspace found, if any.
        certificate punctual_motion_query_certificate;

        /// Where the surfaces meet before the contact that was found, if any, all points of A that
        /// B touches are in one of them.
        open_boxes punctual_motion_query_open_boxes;
    }
}

calls! {
    /// The screw from one pose to another: a turn of at most half a circle about an axis, and a
    /// shift along it.
    ///
    /// Fails with BAD_POSE or BAD_ARGUMENT.
    fn punctual_motion_screw(
        start: punctual_pose, end: punctual_pose, motion: Option<&mut MaybeUninit<punctual_motion>>
    ) {
        let motion = given(motion, "motion")?;
        motion.write(Motion::screw(start.check()?, end.check()?)?.into());
        Ok(())
    }

    /// Where the body is at a time, 0 to 1; times outside are taken for 0 or 1, and NaN for 0.
    ///
    /// Fails with BAD_POSE or BAD_ARGUMENT.
    fn punctual_motion_pose(
        motion: Option<&punctual_motion>, time: f64, pose: Option<&mut MaybeUninit<punctual_pose>>
    ) {
        let motion = given(motion, "motion")?.check()?;
        given(pose, "pose")?.write((&motion.pose(time)).into());
        Ok(())
    }
}

/// The question until when a motion is free, and when the surfaces meet. Plain data, made by
/// `punctual_motion_query_new`, one for each motion; it borrows the trees. To resume a query all of
/// it must be what it was. Lengths are in the unit of the meshes, times from 0 to 1.
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
    /// Done when nothing moves farther than this, seen from A, between the two times; 0: as close
    /// as double can tell. -1 by default, as any negative number: a millionth of the longest extent
    /// of the smaller mesh, roughly.
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
    /// Proven: the surfaces meet at no time before. 1 without a contact: the motion is free to its
    /// end.
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

inits! {
    /// The question until when the motion of `b` in the frame of `a` is free, with the default
    /// options. Checked when it is run.
    punctual_motion_query_init(
        query: punctual_motion_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_motion
    ) { a, b, of_b: b_in_a }
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
