//! Distance queries: the bounds, points and counters of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::call::*;
use super::queries::same_stats;
use punctual::distance::{Bounds, DistanceEstimate};
use punctual::{Answer, Pose, Query, StopReason, Workspace};
use punctual_capi::{punctual_status as Status, *};

fn same(ours: &punctual_distance, theirs: &Answer<Bounds>) {
    assert_eq!([ours.low, ours.high], [theirs.value.low, theirs.value.high]);
    let closer = match theirs.value.closer {
        None => punctual_closer::Undecided,
        Some(true) => punctual_closer::Yes,
        Some(false) => punctual_closer::No,
    };
    assert_eq!(
        (ours.closer, ours.has_nearest),
        (closer, theirs.value.nearest.is_some())
    );
    let (ids, points) = theirs
        .value
        .nearest
        .map_or_else(Default::default, |near| (near.triangles, near.points));
    assert_eq!([ours.nearest.a, ours.nearest.b], ids);
    assert_eq!(
        ours.points.map(|p| [p.x, p.y, p.z]),
        points.map(|p| p.to_array())
    );
    same_stats(&ours.stats, &theirs.stats);
}

fn same_estimate(
    query: &punctual_distance_query,
    workspace: &punctual_workspace,
    theirs: DistanceEstimate,
) {
    let said = made(|out| unsafe {
        punctual_distance_query_estimate(asked(Some(query)), Some(workspace), None, slot(out))
    });
    assert_eq!(
        [said.remaining, said.distance],
        [theirs.remaining, theirs.distance].map(Into::into)
    );
}

/// Of a knot and itself: through each other, closer, and apart.
fn poses() -> [Pose; 3] {
    let tilted = tilted();
    [0.0, 1.5, 4.0].map(|x| {
        let place = tilted.translation() + punctual::glam::DVec3::X * x;
        Pose::new(tilted.rotation(), place).unwrap()
    })
}

/// Each option, budgets that stop and resume, with and without memory.
#[test]
fn distances_are_those_of_rust() {
    let (ours, theirs) = knots();
    let (mut workspace, mut other) = workspaces();
    let mut stops = 0;
    for (tolerance, share, margins, limit) in [
        (-1.0, 0.0, [0.0; 2], f64::INFINITY),
        (0.0, 0.0, [0.0; 2], f64::INFINITY),
        (0.0, 0.1, [0.0, 0.3], f64::INFINITY),
        (0.5, 0.0, [0.1, 0.0], f64::INFINITY),
        (0.0, 0.0, [0.0; 2], 1.0),
    ] {
        let (mut memory, mut remembered) = memories();
        for pose in poses() {
            let mut query = punctual_distance_query_new(Some(&ours), Some(&ours), raw(&pose));
            (query.absolute_tolerance, query.relative_tolerance) = (tolerance, share);
            (query.margins, query.closer_than) = (margins, limit);
            query.leave_contact_open = u32::from(tolerance == 0.5);
            let native = Query::distance(&theirs, &theirs, pose).relative_tolerance(share);
            let native = native.margins(margins).closer_than(limit);
            let native = native.leave_contact_open(tolerance == 0.5);
            let native = match tolerance {
                -1.0 => native,
                _ => native.absolute_tolerance(tolerance),
            };
            let expected = made(|work| unsafe {
                punctual_distance_query_predict(asked(Some(&query)), Some(&memory), work)
            });
            assert_eq!(expected, native.predict(Some(&remembered)).into());
            let compare =
                |said: &_, told: &_, held: &mut punctual_workspace, other: &mut Workspace| {
                    same(said, told);
                    if told.stop != StopReason::Finished {
                        same_certificate!(
                            punctual_distance_query_certificate,
                            punctual_distance_query_open_boxes,
                            &query,
                            held,
                            native.certificate(other).unwrap()
                        );
                        same_estimate(&query, held, native.estimate(other, None).unwrap());
                    }
                };
            stops += to_the_end!(
                punctual_distance_query_run, punctual_distance_query_resume, query, native, 4_000,
                workspace, other, memory, remembered; compare
            );
        }
    }
    assert!(stops > 5, "{stops}");
}

/// By the clock of the system, without memory.
fn run(
    query: &punctual_distance_query,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    out: Option<&mut MaybeUninit<punctual_distance>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe {
        punctual_distance_query_run(asked(Some(query)), workspace, None, budget, None, slot(out))
    }
}

#[test]
fn null_is_refused_by_distance_queries() {
    let tree = tree_of(&knot());
    let query = punctual_distance_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let budget = punctual_budget_unlimited();
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut out = MaybeUninit::uninit();
    refuses! {
        run(&punctual_distance_query { a: None, ..query }, None, budget, None) => null "query->a";
        run(&punctual_distance_query { b: None, ..query }, None, budget, None) => null "query->b";
        run(&query, None, budget, None) => null "outcome";
        run(&query, None, budget, Some(&mut out)) => null "workspace";
        punctual_distance_query_certificate(asked(None), None, slot(None)) => null "query";
        punctual_distance_query_predict(asked(None), None, None) => null "query";
        punctual_distance_query_predict(asked(Some(&query)), None, None) => null "work";
        punctual_distance_query_estimate(asked(None), None, None, slot(None)) => null "query";
        punctual_distance_query_estimate(asked(Some(&query)), None, None, slot(None))
            => null "estimate";
        punctual_distance_query_certificate(asked(Some(&query)), None, slot(None))
            => null "certificate";
        punctual_distance_query_certificate(asked(Some(&query)), None, slot(Some(&mut MaybeUninit::uninit())))
            => null "workspace";
    }
    let no_clock = punctual_clock {
        now: None,
        context: null_mut(),
    };
    refuses! {
        punctual_distance_query_open_boxes(asked(None), None, null_mut(), 0, None)
            => null "query";
        punctual_distance_query_open_boxes(asked(Some(&query)), None, null_mut(), 0, None)
            => null "count";
        punctual_distance_query_run(asked(None), None, None, budget, None, slot(None))
            => null "query";
        punctual_distance_query_resume(asked(None), None, None, budget, None, slot(None))
            => null "query";
    }
    let (workspace, clock) = (Some(&mut *workspace), Some(&no_clock));
    refuses! {
        punctual_distance_query_resume(asked(Some(&query)), workspace, None, budget, clock, slot(Some(&mut out)))
            => null "clock->now";
    }
}

#[test]
fn numbers_out_of_range_are_named_by_distance_queries() {
    let tree = tree_of(&knot());
    let query = punctual_distance_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let budget = punctual_budget_unlimited();
    let mut refused = |change: fn(&mut punctual_distance_query), what: &str| {
        let (mut bad, mut out) = (query, MaybeUninit::uninit());
        change(&mut bad);
        refuses! { run(&bad, Some(&mut workspace), budget, Some(&mut out)) => BadArgument; }
        let start = format!("punctual_distance_query_run: query->{what}, which is ");
        assert!(last_error().starts_with(&start), "{}", last_error());
    };
    refused(
        |q| q.absolute_tolerance = f64::NAN,
        "absolute_tolerance is NaN",
    );
    refused(
        |q| q.relative_tolerance = -0.1,
        "relative_tolerance is -0.1",
    );
    refused(
        |q| q.relative_tolerance = f64::NAN,
        "relative_tolerance is NaN",
    );
    refused(
        |q| q.absolute_tolerance = f64::INFINITY,
        "absolute_tolerance is inf",
    );
    refused(
        |q| q.relative_tolerance = f64::INFINITY,
        "relative_tolerance is inf",
    );
    refused(|q| q.closer_than = -1.0, "closer_than is -1");
    refused(|q| q.margins[0] = -1.0, "margins[0] is -1");
    refused(|q| q.margins[1] = f64::INFINITY, "margins[1] is inf");
    let mut out = MaybeUninit::uninit();
    let mut bad = query;
    bad.b_in_a.m[7] = f64::NAN;
    refuses! {
        run(&bad, Some(&mut workspace), budget, Some(&mut out))
            => BadPose "punctual_distance_query_run: entry 7 of the pose [R|t], row by row, is not finite";
    }
}
