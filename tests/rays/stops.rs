//! Whatever stops a query, and wherever: nothing false, and it goes on as if it had never stopped.

use crate::common::ask::{answer, resumes, run, run_in_pieces};
use crate::common::meshes::{ball, cube, knot};
use crate::common::random::{Family, Random, soup};
use crate::common::steps::assert_step;
use crate::finished::{ENOUGH, lines};
use punctual::prediction::MAX_STEP_WORK;
use punctual::rays::{RayHit, RayMode};
use punctual::{Budget, Query, Ray, StopReason, Tree, Workspace, shapes};

const MODES: [RayMode; 3] = [RayMode::Nearest, RayMode::Any, RayMode::All];

fn cases() -> Vec<(Tree, Vec<Ray>)> {
    let mut random = Random::new(11);
    let mut trees = vec![ball(3), knot(0.2, 40), cube(5)];
    for family in [
        Family::Uniform,
        Family::Degenerate,
        Family::Unequal,
        Family::Duplicate,
    ] {
        trees.push(Tree::new(soup(family, 50, &mut random)));
    }
    let cases = trees.into_iter().map(|tree| {
        let lines = lines(&tree, 12, &mut random);
        (tree, lines.iter().map(|line| line.ray).collect())
    });
    cases.collect()
}

#[test]
fn after_every_step_nothing_is_false() {
    let mut workspace = Workspace::new();
    for (tree, rays) in &cases() {
        for (&ray, mode) in rays.iter().flat_map(|ray| MODES.map(|mode| (ray, mode))) {
            let all = Query::ray(tree, ray).mode(RayMode::All);
            let _ = run(&all, &mut workspace, ENOUGH);
            let truth: Vec<RayHit> = workspace.ray_hits().to_vec();
            let query = all.mode(mode);
            let mut before = run(&query, &mut workspace, Budget::work(0));
            let said = run_in_pieces(
                &query,
                &mut workspace,
                || 1,
                |said, held| {
                    let found: Vec<RayHit> = match mode {
                        RayMode::All => held.ray_hits().to_vec(),
                        _ => said.value.hit.into_iter().collect(),
                    };
                    assert!(found.iter().all(|hit| truth.contains(hit)));
                    let is_known =
                        |hit: &RayHit| hit.t >= said.value.free_until || found.contains(hit);
                    assert!(truth.iter().all(is_known), "{truth:?} {said:?}");
                    let is_any = mode == RayMode::Any && said.value.hit.is_some();
                    let closes_in = before.value.free_until <= said.value.free_until;
                    assert!(is_any || closes_in, "{before:?} {said:?}");
                    assert_step(said.stats.work - before.stats.work, 1, MAX_STEP_WORK);
                    before = *said;
                },
            );
            assert_eq!(said, answer(&query), "{before:?}");
        }
    }
}

/// Also where a copy of the workspace goes on.
#[test]
fn batches_in_pieces_end_in_the_same_bits() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(2));
    for (tree, rays) in &cases() {
        for batch in [Query::rays(tree, rays), Query::rays(tree, rays).any()] {
            let full = run(&batch, &mut workspace, ENOUGH);
            let whole = workspace.first_hits().to_vec();
            let pieces = || random.below(900) as u64;
            let said = run_in_pieces(&batch, &mut workspace, pieces, |said, held| {
                assert_eq!(held.first_hits()[..said.value], whole[..said.value]);
                *held = held.clone();
            });
            assert_eq!((said, workspace.first_hits()), (full, &whole[..]));
        }
    }
}

#[test]
fn a_full_buffer_is_drained_and_filled_again() {
    let tree = Tree::new(shapes::torus_knot(3, 5, 0.2, 60));
    let ray = Ray::new([-9.0, 0.11, 0.05], [1.0, 0.0, 0.0]).unwrap();
    let query = Query::ray(&tree, ray).mode(RayMode::All);
    let [mut workspace, mut small] = [Workspace::new(), Workspace::new()];
    let whole = run(&query, &mut workspace, ENOUGH);
    let all: Vec<RayHit> = workspace.ray_hits().to_vec();
    assert!(all.len() > 4 && whole.stop == StopReason::Finished);
    small.reserve_ray_hits(3);
    let (mut said, mut hits) = (run(&query, &mut small, ENOUGH), Vec::new());
    while said.stop == StopReason::PairsFull {
        hits.extend(small.drain_ray_hits());
        said = crate::common::ask::resume(&query, &mut small, ENOUGH);
    }
    hits.extend(small.drain_ray_hits());
    assert_eq!((said, hits), (whole, all));
}

#[test]
fn only_a_stopped_run_of_the_same_query_resumes() {
    let [tree, twin] = [ball(3), ball(3)];
    let ray = Ray::new([0.0, 0.0, 3.0], [0.01, 0.0, -1.0]).unwrap();
    let other = Ray::new([0.0, 0.0, 3.0], [0.02, 0.0, -1.0]).unwrap();
    let mut workspace = Workspace::new();
    let query = Query::ray(&tree, ray);
    let _ = run(&query, &mut workspace, Budget::work(0));
    for wrong in [
        Query::ray(&tree, other),
        query.mode(RayMode::Any),
        Query::ray(&twin, ray),
    ] {
        assert!(!resumes(&wrong, &workspace));
    }
    assert!(resumes(&query, &workspace));
    let _ = run(
        &Query::rays(&tree, &[ray, other]),
        &mut workspace,
        Budget::work(0),
    );
    assert!(!resumes(&query, &workspace));
}
