//! Motion queries: the times and counters of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::call::*;
use super::queries::same_stats;
use punctual::glam::DVec3;
use punctual::impact::TimeOfImpact;
use punctual::{Answer, Motion, Pose, Query, StopReason, Workspace};
use punctual_capi::{punctual_status as Status, *};

fn same(ours: &punctual_passage, theirs: &Answer<TimeOfImpact>) {
    assert_eq!(
        (ours.free_until, ours.touches),
        (theirs.value.lower, theirs.value.upper.is_some())
    );
    assert_eq!(ours.touching_at, theirs.value.upper.unwrap_or(0.0));
    assert_eq!(
        [ours.triangles.a, ours.triangles.b],
        theirs.value.triangles.unwrap_or_default()
    );
    same_stats(&ours.stats, &theirs.stats);
}

/// One of ours and one of theirs: straight, turning, and a screw.
fn motions() -> [(punctual_motion, Motion); 3] {
    let (end, place) = (
        Pose::IDENTITY,
        tilted().translation() + DVec3::new(5.0, 1.0, 0.0),
    );
    let start = Pose::new(tilted().rotation(), place).unwrap();
    let [velocity, turn] = [DVec3::new(-8.0, -1.0, 0.5), DVec3::new(0.3, 2.0, 0.1)];
    let arm = DVec3::new(0.5, 0.0, 1.0);
    let straight = punctual_motion_straight(raw(&start), velocity.into());
    let turning = punctual_motion {
        turn: turn.into(),
        arm: arm.into(),
        ..straight
    };
    let screw = made(|out| punctual_motion_screw(raw(&start), raw(&end), out));
    let with_arm = Motion::with_arm(start, velocity, turn, arm);
    [
        (straight, Motion::straight(start, velocity).unwrap()),
        (turning, with_arm.unwrap()),
        (screw, Motion::screw(start, end).unwrap()),
    ]
}

/// Each option, budgets that stop and resume, with and without memory.
#[test]
fn motions_are_those_of_rust() {
    let (ours, theirs) = knots();
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let (mut memory, mut remembered) = memories();
    let mut other = Workspace::new();
    let mut stops = 0;
    for (tolerance, time_tolerance, margins, both) in [
        (-1.0, 0.0, [0.0; 2], false),
        (1e-3, 0.0, [0.1, 0.2], false),
        (0.0, 1e-2, [0.0; 2], true),
    ] {
        for (raw_motion, motion) in motions() {
            for time in [0.0, 0.3, 1.0] {
                let pose = made(|out| punctual_motion_pose(Some(&raw_motion), time, out));
                assert_eq!(pose, raw(&motion.pose(time)));
            }
            let mut query = punctual_motion_query_new(Some(&ours), Some(&ours), raw_motion);
            (query.tolerance, query.time_tolerance, query.margins) =
                (tolerance, time_tolerance, margins);
            (query.a_moves, query.of_a) = (both.into(), motions()[1].0);
            let native = match both {
                true => Query::impact_of_both([&theirs; 2], [motions()[1].1, motion]),
                false => Query::impact(&theirs, &theirs, motion),
            };
            let native = native.time_tolerance(time_tolerance).margins(margins);
            let native = match tolerance {
                -1.0 => native,
                _ => native.tolerance(tolerance),
            };
            let told = made(|work| unsafe {
                punctual_motion_query_predict(asked(Some(&query)), Some(&memory), work)
            });
            assert_eq!(told, native.predict(Some(&remembered)).into());
            let compare =
                |said: &_, told: &_, held: &mut punctual_workspace, other: &mut Workspace| {
                    same(said, told);
                    if told.stop != StopReason::Finished {
                        same_certificate!(
                            punctual_motion_query_certificate,
                            punctual_motion_query_open_boxes,
                            &query,
                            held,
                            native.certificate(other).unwrap()
                        );
                    }
                };
            stops += to_the_end!(
                punctual_motion_query_run, punctual_motion_query_resume, query, native, 8_000,
                workspace, other, memory, remembered; compare
            );
        }
    }
    assert!(stops > 5, "{stops}");
}

#[test]
fn bad_motions_are_refused() {
    let tree = tree_of(&knot());
    let (motion, _) = motions()[1];
    let query = punctual_motion_query_new(Some(&tree), Some(&tree), motion);
    let budget = punctual_budget_unlimited();
    let mut workspace = owned(|out| punctual_workspace_new(out));
    refuses! {
        punctual_motion_query_certificate(asked(Some(&query)), None, slot(None))
            => null "certificate";
        punctual_motion_query_open_boxes(asked(Some(&query)), None, null_mut(), 0, None)
            => null "count";
    }
    let mut refused = |change: fn(&mut punctual_motion_query), expected: Status, what: &str| {
        let (mut bad, mut out) = (query, MaybeUninit::uninit());
        change(&mut bad);
        let (held, out) = (Some(&mut *workspace), slot(Some(&mut out)));
        // SAFETY: no clock of the caller's.
        let status =
            unsafe { punctual_motion_query_run(asked(Some(&bad)), held, None, budget, None, out) };
        assert_eq!(status, expected, "{what}");
        assert!(last_error().contains(what), "{what}: {}", last_error());
    };
    refused(|q| q.a = None, Status::Null, "query->a is null");
    refused(|q| q.b = None, Status::Null, "query->b is null");
    let bad = Status::BadArgument;
    refused(|q| q.tolerance = f64::NAN, bad, "query->tolerance");
    refused(
        |q| q.tolerance = f64::INFINITY,
        bad,
        "query->tolerance is inf",
    );
    refused(|q| q.time_tolerance = -1.0, bad, "query->time_tolerance");
    refused(
        |q| q.time_tolerance = f64::INFINITY,
        bad,
        "query->time_tolerance is inf",
    );
    refused(|q| q.margins[1] = f64::INFINITY, bad, "query->margins[1]");
    refused(|q| q.of_b.turn.y = f64::NAN, bad, "not finite");
    refused(|q| q.of_b.velocity.x = 1e300, bad, "2^990");
    refused(|q| q.of_b.start.m[0] = 2.0, Status::BadPose, "rotation");
    refuses! {
        punctual_motion_query_predict(asked(None), None, None) => null "query";
        punctual_motion_query_predict(asked(Some(&query)), None, None) => null "work";
        punctual_motion_query_remaining(asked(None), None, None, null_mut()) => null "query";
        punctual_motion_query_remaining(asked(Some(&query)), None, None, null_mut())
            => null "remaining";
        punctual_motion_screw(motion.start, motion.start, None) => null "motion";
        punctual_motion_pose(None, 0.0, None) => null "motion";
        punctual_motion_pose(Some(&motion), 0.0, None) => null "pose";
    }
}
