//! Points and solids: the answers of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::call::*;
use punctual::glam::DVec3;
use punctual::points::PointBounds;
use punctual::{Budget, Query};
use punctual_capi::{punctual_status as Status, *};

fn points() -> Vec<[f64; 3]> {
    let point = |i: u32| {
        let angle = f64::from(i) * 0.4;
        [
            angle.cos() * 2.0,
            angle.sin() * 2.0,
            0.03 * f64::from(i % 7),
        ]
    };
    (0..40).map(point).collect()
}

/// A run, or the next part of one.
#[allow(clippy::too_many_arguments, reason = "the arguments of the call")]
fn spend(
    resumes: bool,
    tree: Option<&punctual_tree>,
    points: &[[f64; 3]],
    measures: u32,
    workspace: Option<&mut punctual_workspace>,
    work: u64,
    bounds: *mut punctual_point_bounds,
    outcome: Option<&mut MaybeUninit<punctual_points_outcome>>,
) -> Status {
    let (points, count) = (points.as_ptr().cast(), points.len());
    let (budget, out) = (punctual_budget_work(work), slot(outcome));
    // SAFETY: arrays as long as said, no clock of the caller's.
    unsafe {
        match resumes {
            true => punctual_points_resume(
                tree, points, count, measures, workspace, budget, None, bounds, out,
            ),
            false => punctual_points_run(
                tree, points, count, measures, workspace, budget, None, bounds, out,
            ),
        }
    }
}

fn same(ours: &punctual_point_bounds, theirs: &PointBounds) {
    assert_eq!(Some(ours.winding), theirs.winding);
    assert_eq!(ours.error, theirs.error);
    assert_eq!(
        ours.inside == punctual_inside::Yes,
        theirs.inside == Some(true)
    );
    assert_eq!(ours.is_on_surface != 0, theirs.is_on_surface);
    match theirs.distance {
        None => assert_eq!(
            (ours.low, ours.high, ours.triangle),
            (0.0, 0.0, PUNCTUAL_NO_TRIANGLE)
        ),
        Some(distance) => {
            assert_eq!((ours.low, ours.high), (distance.low, distance.high));
            assert_eq!(ours.triangle, distance.triangle);
            assert_eq!(ours.nearest, distance.point.into());
        }
    }
}

#[test]
fn points_are_those_of_rust() {
    let (ours, theirs) = solid_knots();
    let (mut workspace, mut other) = workspaces();
    let points = points();
    for measures in [0, 1] {
        let mut bounds = vec![MaybeUninit::<punctual_point_bounds>::uninit(); points.len()];
        let room = bounds.as_mut_ptr().cast();
        let (mut resumes, mut calls) = (false, 0);
        loop {
            let outcome = made(|out| {
                let (tree, workspace) = (Some(&*ours), Some(&mut *workspace));
                spend(resumes, tree, &points, measures, workspace, 2000, room, out)
            });
            (resumes, calls) = (true, calls + 1);
            if outcome.stop == punctual_stop_reason::Finished {
                assert_eq!(outcome.done, points.len());
                break;
            }
        }
        assert!(calls > 3);
        let query = if measures == 0 {
            Query::windings(&theirs, &points)
        } else {
            Query::signed_distances(&theirs, &points)
        };
        let answer = query.unwrap().run(&mut other, Budget::unlimited());
        assert_eq!(answer.value, points.len());
        for (ours, theirs) in bounds.iter().zip(other.points()) {
            // SAFETY: the call has written it.
            same(unsafe { ours.assume_init_ref() }, theirs);
        }
    }
}

/// What a call writes, in words.
fn tell<T: std::fmt::Debug>(call: impl FnOnce(Option<&mut MaybeUninit<T>>) -> Status) -> String {
    format!("{:?}", made(call))
}

/// Each question after each other one, in one workspace, with budgets that leave no room for it.
#[test]
fn a_query_without_memory_for_its_points_shows_no_older_answer() {
    let (knot, _) = solid_knots();
    let ball = solid_of(&owned(|mesh| punctual_shape_icosphere(2, mesh)));
    let trees = [&*knot, &*ball];
    // On the surface of the ball, inside of it, and far away.
    let places = [[0.0, 0.0, 1.0], [0.1, 0.2, 0.3], [30.0, 0.0, 0.0]];
    let ask = |what: usize, i: usize, workspace: &mut punctual_workspace, work: u64| {
        let (tree, other) = (trees[i % 2], trees[1 - i % 2]);
        let mut pose = raw(&punctual::Pose::IDENTITY);
        pose.m[3] = i as f64;
        let (workspace, budget) = (Some(workspace), punctual_budget_work(work));
        let (query, of) = (punctual_query_new, (Some(tree), Some(other)));
        // SAFETY: arrays as long as said, no clock of the caller's.
        unsafe {
            match what {
                0 => {
                    let mut bounds = [MaybeUninit::<punctual_point_bounds>::uninit(); 1];
                    let (place, room) = ([places[i]], bounds.as_mut_ptr().cast());
                    let said =
                        made(|out| spend(false, Some(tree), &place, 1, workspace, work, room, out));
                    let done = (said.done > 0).then(|| bounds[0].assume_init());
                    let done = done.map(|done| (done.winding, done.low, done.high));
                    format!("{said:?} {done:?}")
                }
                1 => {
                    let along = punctual_point { x: 1.0, ..NO_POINT };
                    let ray = punctual_ray_new(DVec3::from(places[i]).into(), along);
                    let mut query = punctual_ray_query_new(Some(tree), ray);
                    query.solid = 1;
                    tell(|out| punctual_ray_query_run(&query, workspace, budget, None, slot(out)))
                }
                2 => {
                    let query = query(of.0, of.1, pose);
                    tell(|out| run(&query, workspace, budget, out))
                }
                3 => {
                    let asked = punctual_distance_query_new(of.0, of.1, pose);
                    let run = punctual_distance_query_run;
                    tell(|out| run(&asked, workspace, None, budget, None, slot(out)))
                }
                _ => {
                    let asked = punctual_manifold_query_new(of.0, of.1, pose);
                    let run = punctual_manifold_query_run;
                    tell(|out| run(&asked, workspace, None, budget, None, slot(out)))
                }
            }
        }
    };
    let all: Vec<_> = (0..5)
        .flat_map(|what| (0..3).map(move |i| (what, i)))
        .collect();
    let mut used = owned(|out| punctual_workspace_new(out));
    for &(what, i) in &all {
        for work in [0, 1, 400, 2_000] {
            let mut fresh = owned(|out| punctual_workspace_new(out));
            let expected = ask(what, i, &mut fresh, work);
            for &(earlier, j) in &all {
                for stop in [1, 700, u64::MAX] {
                    ask(earlier, j, &mut used, stop);
                    let said = ask(what, i, &mut used, work);
                    assert_eq!(said, expected, "{what} {i} {earlier} {j} {work} {stop}");
                }
            }
        }
    }
}

#[test]
fn open_surfaces_and_bad_points_are_refused() {
    let (ours, surface) = (solid_of(&knot()), tree_of(&knot()));
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut bounds = [const { MaybeUninit::<punctual_point_bounds>::uninit() }; 2];
    let (room, nowhere) = (bounds.as_mut_ptr().cast(), null_mut());
    let (mut out, mut other) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    let (points, lost) = ([[0.0; 3]; 2], [[0.0; 3], [0.0, 0.0, f64::NAN]]);
    let (some, open, none) = (Some(&*ours), Some(&*surface), None);
    let mut spend = |resumes, tree, points: &[[f64; 3]], measures, bounds| {
        let (held, out) = (Some(&mut *workspace), Some(&mut out));
        spend(resumes, tree, points, measures, held, 9, bounds, out)
    };
    refuses! {
        spend(false, open, &points, 0, room)
            => BadArgument "punctual_points_run: the tree was not built as a solid, see `solid` of punctual_build_options";
        spend(true, some, &points, 0, room) => NotResumable;
        spend(false, some, &lost, 1, room)
            => BadArgument "punctual_points_run: point 1 is not finite along axis 2";
        spend(false, none, &points, 1, room) => null "tree";
        spend(false, some, &points, 1, nowhere) => null "bounds";
    }
    let (held, again) = (&mut *workspace, self::spend);
    refuses! {
        again(false, some, &points, 1, None, 9, room, Some(&mut other)) => null "workspace";
        again(false, some, &points, 1, Some(held), 9, room, None) => null "outcome";
    }
    let options = punctual_build_options {
        solid: 7,
        ..Default::default()
    };
    let mut tree = MaybeUninit::uninit();
    refuses! {
        punctual_tree_new(Some(&knot()), asked(Some(&options)), Some(&mut tree))
            => BadArgument "punctual_tree_new: options->solid has no value 7";
    }
}

#[test]
fn a_body_inside_another_is_contained() {
    let (small, large) = (
        solid_of(&owned(|mesh| punctual_shape_cuboid(0.1, 0.2, 0.1, 1, mesh))),
        solid_of(&owned(|mesh| punctual_shape_icosphere(2, mesh))),
    );
    let mut workspace = owned(|out| punctual_workspace_new(out));
    for (inner, a, b) in [(0, &small, &large), (1, &large, &small)] {
        let query = punctual_query_new(Some(a), Some(b), raw(&punctual::Pose::IDENTITY));
        let budget = punctual_budget_work(1 << 40);
        let outcome = made(|out| run(&query, Some(&mut workspace), budget, out));
        assert_eq!(outcome.verdict, punctual_verdict::Contained);
        assert_eq!(outcome.witness, [inner, 0].into());
    }
}
