//! Motion queries: two trees, how they move, and tolerances in; proven times out.

use crate::distance::{check_margins, finite, finite_or_default};
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, question, types};
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use core::mem::MaybeUninit;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Motion, Query};

types! {
    /// A rigid motion in one unit of time, from time 0 to 1: constant velocity, and constant turn
    /// about an axis that moves along. At time `t` a point that `start` brings to `x` is at `p + t
    /// velocity + R(t turn) (x - p)`, where `p` is a point of the axis at time 0. It is checked
    /// wherever it is used.
    plain punctual_motion from (motion: Motion) {
        /// Where it begins.
        start: punctual_pose = (&motion.start()).into(),
        /// The velocity of the axis: length per unit of time.
        velocity: punctual_point = motion.velocity().into(),
        /// The axis by the right-hand rule, times the angle in radians; zeros: no turn.
        turn: punctual_point = motion.turn().into(),
        /// From a point of the axis to the origin of the body at time 0; zeros: the axis goes
        /// through it.
        arm: punctual_point = motion.arm().into(),
    }
}

/// A straight line without turn.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_motion_straight(
    start: punctual_pose,
    velocity: punctual_point,
) -> punctual_motion {
    punctual_motion {
        start,
        velocity,
        ..punctual_motion::STILL
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

types! {
    /// The question until when a motion is free, and when the surfaces meet. Plain data, made by
    /// `punctual_motion_query_new`, one for each motion; it borrows the trees. To resume a query
    /// all of it must be what it was. Lengths are in the unit of the meshes, times from 0 to 1.
    asked punctual_motion_query<'t>(of_b) {
        /// Whether A moves too: 0 (the default) or not 0.
        a_moves: u32 = 0,
        /// Tree A.
        a: Option<&'t punctual_tree> = None,
        /// Tree B; it may be the same.
        b: Option<&'t punctual_tree> = None,
        /// How B moves: in A's frame, or in the world if A moves too.
        of_b: punctual_motion = punctual_motion::STILL,
        /// How, in the world.
        of_a: punctual_motion = punctual_motion::STILL,
        /// Done when nothing moves farther than this, seen from A, between the two times; 0: as
        /// close as double can tell. -1 by default, as any negative number: a millionth of the
        /// longest extent of the smaller mesh, roughly.
        tolerance: f64 = -1.0,
        /// Done also when the two times differ by no more than this. 0 by default.
        time_tolerance: f64 = 0.0,
        /// By how much each surface is thickened, A's first. 0 by default.
        margins: [f64; 2] = [0.0; 2],
    }

    /// The answer of a motion query, wherever it stopped; times from 0 to 1.
    told punctual_passage(free_until) from (passage: Answer<TimeOfImpact>) {
        /// Proven: the surfaces meet at no time before. 1 without a contact: the motion is free to
        /// its end.
        free_until: f64 = passage.value.lower,
        /// Whether a contact was found (yet); if not, its time and the triangles are zeros.
        touches: bool = passage.value.upper.is_some(),
        /// Proven: the surfaces meet at this time; 0 if they do at the start.
        touching_at: f64 = passage.value.upper.unwrap_or(0.0),
        /// The triangles that meet then.
        triangles: punctual_triangle_pair = passage.value.triangles.unwrap_or_default().into(),
        /// Why the query returned.
        stop: punctual_stop_reason = passage.stop.into(),
        /// What it has done.
        stats: punctual_stats = passage.stats.into(),
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
    /// Nothing moves.
    pub(crate) const STILL: Self = Self {
        start: punctual_pose::IDENTITY,
        velocity: punctual_point::ZERO,
        turn: punctual_point::ZERO,
        arm: punctual_point::ZERO,
    };

    pub(crate) fn check(&self) -> Result<Motion, Fault> {
        Ok(Motion::with_arm(
            self.start.check()?,
            self.velocity.numbers(),
            self.turn.numbers(),
            self.arm.numbers(),
        )?)
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
