//! Once its buffers have grown to the size of the scene, a frame touches no allocator: bodies that move, meet and part,
//! with and without budgets.

#[path = "common/allocations.rs"]
mod allocations;

use std::sync::Arc;
use std::time::Duration;

use allocations::allocator_calls;
use punctual::glam::{DMat3, DVec3};
use punctual::{Body, BodyId, Budget, ManualClock, Mode, Pose, Scene, Tree, shapes};

const PERIOD: usize = 40;

/// Bodies on circles that cross, back where they were after each period.
fn pose(body: usize, frame: usize) -> Pose {
    let time = std::f64::consts::TAU * ((frame % PERIOD) as f64 / PERIOD as f64 + 0.13 * body as f64);
    let turn = DMat3::from_rotation_z(time) * DMat3::from_rotation_x(time);
    let center = DVec3::new((body % 6) as f64, (body / 6 % 6) as f64, (body / 36) as f64);
    Pose::new(turn, 1.5 * center + DVec3::new(time.cos(), time.sin(), 0.3 * time.sin())).unwrap()
}

fn play(scene: &mut Scene, ids: &[BodyId], frames: usize) -> usize {
    let budgets =
        [Budget::unlimited(), Budget::work(20_000), Budget::work(200_000), Budget::time(Duration::from_micros(50))];
    let clock = ManualClock::ticking(Duration::from_nanos(700));
    let mut undecided = 0;
    for frame in 0..frames {
        for (body, &id) in ids.iter().enumerate().skip(1) {
            scene.set_pose(id, pose(body, frame)).unwrap();
        }
        // Each budget meets each phase of the motion.
        let report = scene.detect_with(budgets[(frame + frame / PERIOD) % budgets.len()], &clock);
        undecided += report.undecided();
    }
    undecided
}

#[test]
fn a_frame_does_not_allocate() {
    for mode in [Mode::Any, Mode::All] {
        let knot = Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.15, 32)));
        let mut scene = Scene::new().mode(mode);
        let bodies = (0..100).map(|body| Body::moving(Arc::clone(&knot), pose(body, 0)));
        let ids: Vec<BodyId> = bodies.map(|body| scene.insert(body).unwrap()).collect();
        // Two rounds of each budget at each phase.
        let warm_up = 8 * PERIOD;
        play(&mut scene, &ids, warm_up);
        let mut undecided = 0;
        let calls = allocator_calls(|| undecided = play(&mut scene, &ids, warm_up));
        assert_eq!(calls, 0, "{mode:?}");
        assert!(undecided > 0, "no budget was too small");
    }
}
