//! Whatever stops a query, and wherever: nothing false, and it goes on as if it had never stopped.

use crate::common::random::{Family, Random, soup};
use crate::common::steps::assert_step;
use crate::finished::{ENOUGH, lines, run};
use punctual::clock::ManualClock;
use punctual::prediction::MAX_STEP_WORK;
use punctual::rays::{RayHit, RayMode};
use punctual::{Budget, Query, Ray, ResumeError, StopReason, Tree, Workspace, shapes};

const MODES: [RayMode; 3] = [RayMode::Nearest, RayMode::Any, RayMode::All];

fn cases() -> Vec<(Tree, Vec<Ray>)> {
    let mut random = Random::new(11);
    let meshes = [
        shapes::icosphere(3),
        shapes::torus_knot(2, 3, 0.2, 40),
        shapes::cuboid([1.0; 3], 5),
    ];
    let soups = [
        Family::Uniform,
        Family::Degenerate,
        Family::Unequal,
        Family::Duplicate,
    ];
    let meshes = meshes
        .into_iter()
        .chain(soups.map(|family| soup(family, 50, &mut random)));
    let trees: Vec<Tree> = meshes.map(Tree::new).collect();
    let rays = |tree: &Tree, random: &mut Random| {
        lines(tree, 12, random)
            .iter()
            .map(|line| line.ray)
            .collect()
    };
    trees
        .into_iter()
        .map(|tree| (rays(&tree, &mut random), tree))
        .map(|(rays, tree)| (tree, rays))
        .collect()
}

#[test]
fn after_every_step_nothing_is_false() {
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    for (tree, rays) in &cases() {
        for (&ray, mode) in rays.iter().flat_map(|ray| MODES.map(|mode| (ray, mode))) {
            let _ = run(tree, ray, RayMode::All, &mut workspace);
            let truth: Vec<RayHit> = workspace.ray_hits().to_vec();
            let whole = run(tree, ray, mode, &mut workspace);
            let query = Query::ray(tree, ray).mode(mode);
            let mut said = query.run(&mut workspace, Budget::work(0).clock(&clock));
            let mut before = said;
            while said.stop == StopReason::WorkLimit {
                let found: Vec<RayHit> = match mode {
                    RayMode::All => workspace.ray_hits().to_vec(),
                    _ => said.value.hit.into_iter().collect(),
                };
                assert!(found.iter().all(|hit| truth.contains(hit)));
                for hit in &truth {
                    assert!(
                        hit.t >= said.value.free_until || found.contains(hit),
                        "{hit:?} {said:?}"
                    );
                }
                before = said;
                said = query
                    .resume(&mut workspace, Budget::work(1).clock(&clock))
                    .unwrap();
                let is_any = mode == RayMode::Any && said.value.hit.is_some();
                assert!(
                    is_any || before.value.free_until <= said.value.free_until,
                    "{before:?} {said:?}"
                );
                assert_step(said.stats.work - before.stats.work, 1, MAX_STEP_WORK);
            }
            assert_eq!(said, whole, "{before:?}");
            assert_eq!(
                query.resume(&mut workspace, ENOUGH.clock(&clock)),
                Err(ResumeError)
            );
        }
    }
}

/// Also where a copy of the workspace goes on.
#[test]
fn batches_in_pieces_end_in_the_same_bits() {
    let (mut workspace, clock, mut random) = (Workspace::new(), ManualClock::new(), Random::new(2));
    for (tree, rays) in &cases() {
        for batch in [Query::rays(tree, rays), Query::rays(tree, rays).any()] {
            let full = batch.run(&mut workspace, ENOUGH.clock(&clock));
            let whole = workspace.first_hits().to_vec();
            let mut said = batch.run(&mut workspace, Budget::work(0).clock(&clock));
            while said.stop == StopReason::WorkLimit {
                assert_eq!(workspace.first_hits()[..said.value], whole[..said.value]);
                if random.below(3) == 0 {
                    workspace = workspace.clone();
                }
                said = batch
                    .resume(
                        &mut workspace,
                        Budget::work(random.below(900) as u64).clock(&clock),
                    )
                    .unwrap();
            }
            assert_eq!((said, workspace.first_hits()), (full, &whole[..]));
        }
    }
}

#[test]
fn a_full_buffer_is_drained_and_filled_again() {
    let tree = Tree::new(shapes::torus_knot(3, 5, 0.2, 60));
    let ray = Ray::new([-9.0, 0.11, 0.05], [1.0, 0.0, 0.0]).unwrap();
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let whole = run(&tree, ray, RayMode::All, &mut workspace);
    let all: Vec<RayHit> = workspace.ray_hits().to_vec();
    assert!(all.len() > 4 && whole.stop == StopReason::Finished);
    let mut small = Workspace::new();
    small.reserve_ray_hits(3);
    let query = Query::ray(&tree, ray).mode(RayMode::All);
    let (mut said, mut hits) = (query.run(&mut small, ENOUGH.clock(&clock)), Vec::new());
    while said.stop == StopReason::PairsFull {
        hits.extend(small.drain_ray_hits());
        said = query.resume(&mut small, ENOUGH.clock(&clock)).unwrap();
    }
    hits.extend(small.drain_ray_hits());
    assert_eq!((said, hits), (whole, all));
}

#[test]
fn what_is_not_the_stopped_run_is_refused() {
    let [tree, twin] = [3, 3].map(|level| Tree::new(shapes::icosphere(level)));
    let ray = Ray::new([0.0, 0.0, 3.0], [0.01, 0.0, -1.0]).unwrap();
    let other = Ray::new([0.0, 0.0, 3.0], [0.02, 0.0, -1.0]).unwrap();
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let query = Query::ray(&tree, ray);
    let _ = query.run(&mut workspace, Budget::work(0).clock(&clock));
    for wrong in [
        Query::ray(&tree, other),
        query.mode(RayMode::Any),
        Query::ray(&twin, ray),
    ] {
        assert_eq!(
            wrong.resume(&mut workspace.clone(), ENOUGH.clock(&clock)),
            Err(ResumeError)
        );
    }
    assert!(
        query
            .resume(&mut workspace, ENOUGH.clock(&clock))
            .unwrap()
            .value
            .hit
            .is_some()
    );
    let rays = [ray, other];
    let _ = Query::rays(&tree, &rays).run(&mut workspace, Budget::work(0).clock(&clock));
    assert_eq!(
        query.resume(&mut workspace, ENOUGH.clock(&clock)),
        Err(ResumeError)
    );
}
