//! The threads of a scene: what they cost when there is nothing to do. Alone in its process, whose CPU time it measures.

#![cfg(feature = "parallel")]

use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

use cpu_time::ProcessTime;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Tree, shapes};
use punctual_scene::{Body, Scene};

/// 200 balls, each of which meets its neighbors.
fn balls(scene: &mut Scene) {
    let ball = Arc::new(Tree::new(shapes::icosphere(3)));
    for body in 0..200 {
        let place = DVec3::new(1.5 * f64::from(body), 0.0, 0.0);
        let _ = scene
            .insert(Body::moving(
                Arc::clone(&ball),
                Pose::new(DMat3::IDENTITY, place).unwrap(),
            ))
            .unwrap();
    }
}

#[test]
fn threads_sleep_when_no_frame_comes() {
    let mut scene = Scene::new();
    scene.use_threads(4).unwrap();
    balls(&mut scene);
    let ids: Vec<_> = scene.bodies().map(|(id, _)| id).collect();
    let (mut idle, mut met) = (Duration::ZERO, 0);
    for frame in 0..20 {
        for (body, &id) in ids.iter().enumerate() {
            let place = DVec3::new(1.5 * body as f64, 0.1 * f64::from(frame % 5), 0.0);
            scene
                .set_pose(id, Pose::new(DMat3::IDENTITY, place).unwrap())
                .unwrap();
        }
        met += scene.detect(Budget::unlimited()).intersecting;
        let began = ProcessTime::now();
        sleep(Duration::from_millis(20));
        idle += began.elapsed();
    }
    assert_eq!(met, 20 * 199);
    // Three workers that poll for 0.2 ms take 12 ms; those that never sleep take all cores for 400 ms.
    assert!(idle < Duration::from_millis(40), "{idle:?}");
}
