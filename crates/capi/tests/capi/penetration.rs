//! Penetration: the answers of Rust, and everything that is refused.

use std::mem::MaybeUninit;

use super::call::*;
use punctual::glam::DVec3;
use punctual::tree::Solid;
use punctual::{Answer, Budget, BuildOptions, Pose, StopReason, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};
use punctual_depenetrate::{Penetration, PenetrationQuery, PenetrationWorkspace};

#[derive(Clone, Copy, PartialEq)]
enum Verb {
    Run,
    Resume,
}

const RUN: Verb = Verb::Run;
const RESUME: Verb = Verb::Resume;

fn call(
    verb: Verb,
    query: &punctual_penetration_query,
    workspace: Option<&mut punctual_penetration_workspace>,
    work: u64,
    out: Option<&mut MaybeUninit<punctual_penetration>>,
) -> Status {
    let budget = punctual_budget_work(work);
    let (query, out) = (asked(Some(query)), slot(out));
    // SAFETY: no clock of the caller's.
    unsafe {
        match verb {
            Verb::Run => punctual_penetration_query_run(query, workspace, budget, None, out),
            Verb::Resume => punctual_penetration_query_resume(query, workspace, budget, None, out),
        }
    }
}

fn same(said: &punctual_penetration, expected: &Answer<Penetration>) {
    let Penetration {
        low,
        high,
        direction,
        b_in_a,
        deeper,
        ..
    } = expected.value;
    let deeper = match deeper {
        None => punctual_deeper::Undecided,
        Some(true) => punctual_deeper::Yes,
        Some(false) => punctual_deeper::No,
    };
    assert_eq!(said.deeper, deeper);
    let n = direction.unwrap_or(DVec3::ZERO);
    assert_eq!((said.low, said.high), (low, high));
    assert_eq!(
        [said.direction.x, said.direction.y, said.direction.z],
        n.to_array()
    );
    assert_eq!(
        (said.has_push, said.b_in_a),
        (direction.is_some(), raw(&b_in_a))
    );
    assert_eq!((said.work, said.elapsed), (expected.stats.work, -1));
    assert_eq!(format!("{:?}", said.stop), format!("{:?}", expected.stop));
}

#[test]
fn penetrations_are_those_of_rust() {
    let options = punctual_build_options {
        solid: 1,
        ..punctual_build_options_default()
    };
    // SAFETY: the options are as large as said.
    let ours = owned(|out| unsafe { punctual_tree_new(Some(&knot()), &options, out) });
    let solid = BuildOptions::default().solid(Solid::Flip);
    let theirs = Tree::with_options(shapes::torus_knot(2, 3, 0.2, 96), &solid);
    let mut workspace = owned(|out| punctual_penetration_workspace_new(out));
    let mut other = PenetrationWorkspace::new();
    let away = Pose::new(tilted().rotation(), DVec3::new(9.0, 0.0, 0.0)).unwrap();
    let (mut pushes, mut resumed) = (0, 0);
    for (pose, work, solid, push_only) in [
        (tilted(), 1_000_000, 0, 0),
        (tilted(), 1_000_000, 1, 0),
        (tilted(), 3_000_000, 0, 1),
        (tilted(), 10, 1, 0),
        (away, 100_000, 0, 0),
    ] {
        let mut query = punctual_penetration_query_new(Some(&ours), Some(&ours), raw(&pose));
        (query.solid, query.push_only) = (solid, push_only);
        let native = PenetrationQuery::new(&theirs, &theirs, pose);
        let native = native.solid(solid != 0).push_only(push_only != 0);
        let said = made(|out| call(RUN, &query, Some(&mut workspace), work, out));
        let expected = native.run(&mut other, Budget::work(work));
        same(&said, &expected);
        pushes += usize::from(said.has_push);
        if expected.stop == StopReason::WorkLimit {
            let said = made(|out| call(RESUME, &query, Some(&mut workspace), 50_000, out));
            same(
                &said,
                &native.resume(&mut other, Budget::work(50_000)).unwrap(),
            );
            resumed += 1;
        }
    }
    assert!(pushes == 3 && resumed > 0, "{pushes} {resumed}");
    punctual_penetration_workspace_free(Some(workspace));
    punctual_penetration_workspace_free(None);
}

#[test]
fn limits_and_tolerances_are_those_of_rust() {
    let options = punctual_build_options {
        solid: 1,
        ..punctual_build_options_default()
    };
    // SAFETY: the options are as large as said.
    let ours = owned(|out| unsafe { punctual_tree_new(Some(&knot()), &options, out) });
    let solid = BuildOptions::default().solid(Solid::Flip);
    let theirs = Tree::with_options(shapes::torus_knot(2, 3, 0.2, 96), &solid);
    let mut workspace = owned(|out| punctual_penetration_workspace_new(out));
    let (mut other, mut decided) = (PenetrationWorkspace::new(), 0);
    let query = punctual_penetration_query_new(Some(&ours), Some(&ours), raw(&tilted()));
    assert_eq!(
        (query.absolute_tolerance, query.deeper_than),
        (0.0, f64::INFINITY)
    );
    for (length, limit) in [(0.0, 1e-6), (0.0, 50.0), (0.5, f64::INFINITY)] {
        let query = punctual_penetration_query {
            absolute_tolerance: length,
            deeper_than: limit,
            ..query
        };
        let native = PenetrationQuery::new(&theirs, &theirs, tilted());
        let native = native.absolute_tolerance(length).deeper_than(limit);
        let said = made(|out| call(RUN, &query, Some(&mut workspace), 3_000_000, out));
        same(&said, &native.run(&mut other, Budget::work(3_000_000)));
        decided += usize::from(said.deeper != punctual_deeper::Undecided);
    }
    assert_eq!(decided, 2);
    punctual_penetration_workspace_free(Some(workspace));
}

#[test]
fn nulls_and_bad_poses_are_refused_by_penetration_queries() {
    let ours = tree_of(&knot());
    let (tree, mut out) = (Some(&*ours), MaybeUninit::uninit());
    let mut workspace = owned(|out| punctual_penetration_workspace_new(out));
    let query = punctual_penetration_query_new(tree, tree, raw(&tilted()));
    let no_a = punctual_penetration_query { a: None, ..query };
    refuses! {
        call(RUN, &no_a, None, 1, None) => null "query->a";
    }
    let no_b = punctual_penetration_query { b: None, ..query };
    refuses! {
        call(RUN, &no_b, None, 1, None) => null "query->b";
        call(RUN, &query, None, 1, None) => null "outcome";
        call(RUN, &query, None, 1, Some(&mut out)) => null "workspace";
    }
    let mut bad = query;
    bad.b_in_a.m[0] = 2.0;
    let status = call(RUN, &bad, Some(&mut workspace), 1, Some(&mut out));
    assert_eq!(status, Status::BadPose);
    let status = call(RESUME, &query, Some(&mut workspace), 1, Some(&mut out));
    assert_eq!(status, Status::NotResumable);
    refuses! {
        punctual_penetration_workspace_new(None) => null "the place for the new handle";
    }
}
