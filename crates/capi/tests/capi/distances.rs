//! Distance queries: the bounds, points and counters of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::call::*;
use super::queries::same_stats;
use punctual::distance::{Bounds, DistanceEstimate};
use punctual::{Answer, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes};
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
        Pose::new(
            tilted.rotation(),
            tilted.translation() + punctual::glam::DVec3::X * x,
        )
        .unwrap()
    })
}

/// Each option, budgets that stop and resume, with and without memory.
#[test]
fn distances_are_those_of_rust() {
    let ours = tree_of(&knot());
    let theirs = Tree::new(shapes::torus_knot(2, 3, 0.2, 96));
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut other = Workspace::new();
    let mut stops = 0;
    for (tolerance, share, margins, limit) in [
        (-1.0, 0.0, [0.0; 2], f64::INFINITY),
        (0.0, 0.0, [0.0; 2], f64::INFINITY),
        (0.0, 0.1, [0.0, 0.3], f64::INFINITY),
        (0.5, 0.0, [0.1, 0.0], f64::INFINITY),
        (0.0, 0.0, [0.0; 2], 1.0),
    ] {
        let (mut memory, mut remembered) =
            (owned(|out| punctual_memory_new(out)), PairMemory::new());
        for pose in poses() {
            let mut query = punctual_distance_query_new(Some(&ours), Some(&ours), raw(&pose));
            (query.absolute_tolerance, query.relative_tolerance) = (tolerance, share);
            (query.margins, query.closer_than) = (margins, limit);
            query.leave_contact_open = u32::from(tolerance == 0.5);
            let native = Query::distance(&theirs, &theirs, pose)
                .relative_tolerance(share)
                .margins(margins);
            let native = native
                .closer_than(limit)
                .leave_contact_open(tolerance == 0.5);
            let native = if tolerance < 0.0 {
                native
            } else {
                native.absolute_tolerance(tolerance)
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
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    for (bad, what) in [
        (
            punctual_distance_query {
                absolute_tolerance: nan,
                ..query
            },
            "absolute_tolerance is NaN",
        ),
        (
            punctual_distance_query {
                relative_tolerance: -0.1,
                ..query
            },
            "relative_tolerance is -0.1",
        ),
        (
            punctual_distance_query {
                relative_tolerance: nan,
                ..query
            },
            "relative_tolerance is NaN",
        ),
        (
            punctual_distance_query {
                absolute_tolerance: infinite,
                ..query
            },
            "absolute_tolerance is inf",
        ),
        (
            punctual_distance_query {
                relative_tolerance: infinite,
                ..query
            },
            "relative_tolerance is inf",
        ),
        (
            punctual_distance_query {
                closer_than: -1.0,
                ..query
            },
            "closer_than is -1",
        ),
        (
            punctual_distance_query {
                margins: [-1.0, 0.0],
                ..query
            },
            "margins[0] is -1",
        ),
        (
            punctual_distance_query {
                margins: [0.0, infinite],
                ..query
            },
            "margins[1] is inf",
        ),
    ] {
        let status = run(
            &bad,
            Some(&mut workspace),
            punctual_budget_unlimited(),
            Some(&mut MaybeUninit::uninit()),
        );
        assert_eq!(status, Status::BadArgument);
        let text = last_error();
        assert!(
            text.starts_with(&format!(
                "punctual_distance_query_run: query->{what}, which is "
            )),
            "{text}"
        );
    }
    let mut bad = query;
    bad.b_in_a.m[7] = nan;
    refuses! {
        run(&bad, Some(&mut workspace), punctual_budget_unlimited(), Some(&mut MaybeUninit::uninit()))
            => BadPose "punctual_distance_query_run: entry 7 of the pose [R|t], row by row, is not finite";
    }
}
