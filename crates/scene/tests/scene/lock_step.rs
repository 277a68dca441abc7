//! Budgets of work, and none: what a scene says is the same on any number of threads, whatever came before.
#![cfg(feature = "parallel")]

use punctual::Budget;
use punctual::glam::DVec3;
use punctual_scene::{BodyId, Scene};

use crate::world::World;

/// All that a frame says.
pub fn said(scene: &Scene) -> String {
    let ids: Vec<BodyId> = scene.bodies().map(|(id, _)| id).collect();
    let distances: Vec<_> = scene.distances().collect();
    let passages: Vec<_> = scene.passages().collect();
    let mut said = format!(
        "{:?} {:?} {distances:?} {passages:?}",
        scene.report(),
        scene.calibration()
    );
    for (i, &a) in ids.iter().enumerate() {
        for &b in &ids[..i] {
            said += &format!("{:?} {:?}", scene.contacts(a, b), scene.certificate(a, b));
        }
    }
    said
}

#[test]
fn frames_without_a_budget_and_of_work_say_the_same_on_any_number_of_threads() {
    for seed in 0..12 {
        let mut worlds = [1, 2, 4].map(|threads| {
            let mut world = World::new(seed, DVec3::ZERO);
            world.scene.use_threads(threads).unwrap();
            if seed % 3 == 1 {
                world.scene.find_contacts();
            }
            world
        });
        for frame in 0..120 {
            let said = worlds.each_mut().map(|world| {
                // Some frames rest, so that runs are resumed and estimates are told of what comes out later.
                let changes = if world.random.below(3) == 0 {
                    0
                } else {
                    world.random.below(6)
                };
                for _ in 0..changes {
                    world.change();
                }
                let budget = match world.random.below(4) {
                    0 => Budget::unlimited(),
                    _ => Budget::work(1 << (8 + world.random.below(10))),
                };
                world.scene.detect(budget);
                said(&world.scene)
            });
            assert_eq!(said[0], said[1], "seed {seed}, frame {frame}, two threads");
            assert_eq!(said[0], said[2], "seed {seed}, frame {frame}, four threads");
        }
    }
}
