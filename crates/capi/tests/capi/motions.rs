//! Motion queries: the times and counters of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::call::*;
use super::queries::same_stats;
use punctual::glam::DVec3;
use punctual::impact::TimeOfImpact;
use punctual::{Answer, Motion, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes};
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

fn point(v: DVec3) -> punctual_point {
    punctual_point {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

/// One of ours and one of theirs: straight, turning, and a screw.
fn motions() -> [(punctual_motion, Motion); 3] {
    let (start, end) = (tilted(), Pose::IDENTITY);
    let start = Pose::new(
        start.rotation(),
        start.translation() + DVec3::new(5.0, 1.0, 0.0),
    )
    .unwrap();
    let (velocity, turn, arm) = (
        DVec3::new(-8.0, -1.0, 0.5),
        DVec3::new(0.3, 2.0, 0.1),
        DVec3::new(0.5, 0.0, 1.0),
    );
    let straight = punctual_motion_straight(raw(&start), point(velocity));
    let turning = punctual_motion {
        turn: point(turn),
        arm: point(arm),
        ..straight
    };
    [
        (straight, Motion::straight(start, velocity).unwrap()),
        (
            turning,
            Motion::with_arm(start, velocity, turn, arm).unwrap(),
        ),
        (
            made(|out| punctual_motion_screw(raw(&start), raw(&end), out)),
            Motion::screw(start, end).unwrap(),
        ),
    ]
}

/// Each option, budgets that stop and resume, with and without memory.
#[test]
fn motions_are_those_of_rust() {
    let ours = tree_of(&knot());
    let theirs = Tree::new(shapes::torus_knot(2, 3, 0.2, 96));
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let (mut memory, mut remembered) = (owned(|out| punctual_memory_new(out)), PairMemory::new());
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
            let native = if tolerance < 0.0 {
                native
            } else {
                native.tolerance(tolerance)
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
    let mut refused = |query: punctual_motion_query, what: &str| {
        let (workspace, out) = (Some(&mut *workspace), Some(&mut MaybeUninit::uninit()));
        // SAFETY: no clock of the caller's.
        let status = unsafe {
            punctual_motion_query_run(
                asked(Some(&query)),
                workspace,
                None,
                budget,
                None,
                slot(out),
            )
        };
        assert!(
            status != Status::Ok && last_error().contains(what),
            "{what}: {status:?} {}",
            last_error()
        );
        status
    };
    assert_eq!(
        refused(
            punctual_motion_query { a: None, ..query },
            "query->a is null"
        ),
        Status::Null
    );
    assert_eq!(
        refused(
            punctual_motion_query { b: None, ..query },
            "query->b is null"
        ),
        Status::Null
    );
    for (bad, what) in [
        (
            punctual_motion_query {
                tolerance: f64::NAN,
                ..query
            },
            "query->tolerance",
        ),
        (
            punctual_motion_query {
                tolerance: f64::INFINITY,
                ..query
            },
            "query->tolerance is inf",
        ),
        (
            punctual_motion_query {
                time_tolerance: -1.0,
                ..query
            },
            "query->time_tolerance",
        ),
        (
            punctual_motion_query {
                time_tolerance: f64::INFINITY,
                ..query
            },
            "query->time_tolerance is inf",
        ),
        (
            punctual_motion_query {
                margins: [0.0, f64::INFINITY],
                ..query
            },
            "query->margins[1]",
        ),
        (
            punctual_motion_query {
                of_b: punctual_motion {
                    turn: NAN,
                    ..motion
                },
                ..query
            },
            "not finite",
        ),
        (
            punctual_motion_query {
                of_b: punctual_motion {
                    velocity: FAR,
                    ..motion
                },
                ..query
            },
            "2^990",
        ),
    ] {
        assert_eq!(refused(bad, what), Status::BadArgument);
    }
    let mut bad = query;
    bad.of_b.start.m[0] = 2.0;
    assert_eq!(refused(bad, "rotation"), Status::BadPose);
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

const NAN: punctual_point = punctual_point {
    x: 0.0,
    y: f64::NAN,
    z: 0.0,
};
const FAR: punctual_point = punctual_point {
    x: 1e300,
    y: 0.0,
    z: 0.0,
};
