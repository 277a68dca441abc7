//! Workspaces: what a clone has, and what must not be lost between calls.

mod common;

use common::check::{self, ENOUGH, run, run_to_end};
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, StopReason, Tree, Workspace, shapes};

fn crossing() -> (Tree, Pose) {
    (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 48)),
        Pose::new(DMat3::IDENTITY, DVec3::new(0.3, 0.2, 0.1)).unwrap(),
    )
}

/// A cloned vector has no room: every query ended with a full pair buffer, and draining it went on for ever.
#[test]
fn a_cloned_workspace_has_the_room_of_its_original() {
    let (tree, pose) = crossing();
    let query = Query::all_pairs(&tree, &tree, pose);
    for original in [Workspace::new(), Workspace::with_capacity(16, 100_000)] {
        let mut clone = original.clone();
        let outcome = run(&query, &mut clone, ENOUGH);
        assert_eq!(outcome.stop, StopReason::Finished);
        assert_eq!(clone.clone().pairs(), clone.pairs());
        let mut original = original;
        assert_eq!(run(&query, &mut original, ENOUGH), outcome);
    }
    let small = Workspace::with_capacity(16, 5);
    let (outcome, pairs) = run_to_end(&query, &mut small.clone(), ENOUGH);
    assert_eq!(
        (outcome.stop, pairs.len() as u64),
        (StopReason::Finished, outcome.stats.found)
    );
}

#[test]
fn a_clone_goes_on_with_the_stopped_run_of_its_original() {
    let (tree, pose) = crossing();
    let query = Query::all_pairs(&tree, &tree, pose);
    let mut workspace = Workspace::new();
    let full = run(&query, &mut workspace, ENOUGH);
    let all = workspace.pairs().to_vec();
    for budget in [0, 5_000, full.stats.work / 2] {
        assert_eq!(
            run(&query, &mut workspace, Budget::work(budget)).stop,
            StopReason::WorkLimit
        );
        let mut clone = workspace.clone();
        for workspace in [&mut clone, &mut workspace] {
            assert_eq!(check::resume(&query, workspace, ENOUGH), full);
            assert_eq!(workspace.pairs(), all);
        }
    }
}
