//! What a scene learns from the probabilities that it tells of stopped queries.

use std::sync::Arc;

use crate::{detect, put};
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Calibration;
use punctual::{Budget, Pose, Tree, Verdict, shapes};
use punctual_scene::{Body, Scene};

/// What a scene has learned when a pair is decided that a few frames could not decide, if a body moves before the last of them
/// or not. A tube lies within another.
fn learned(moves: bool, last: Budget) -> Calibration {
    let tube = |radius| {
        Body::moving(
            Arc::new(Tree::new(shapes::torus(0.8, radius, 48))),
            Pose::IDENTITY,
        )
    };
    let mut scene = Scene::new();
    scene.insert(tube(0.2)).unwrap();
    let inner = scene.insert(tube(0.19)).unwrap();
    for _ in 0..4 {
        let pair = detect(&mut scene, Budget::work(5_000)).pairs[0];
        assert_eq!((pair.verdict, pair.complete), (Verdict::Undecided, false));
        assert!(pair.probability > 0.0 && pair.probability < 1.0);
    }
    assert_eq!(scene.calibration(), Calibration::default());
    if moves {
        put(
            &mut scene,
            inner,
            Pose::new(DMat3::IDENTITY, DVec3::new(1e-4, 0.0, 0.0)).unwrap(),
        );
    }
    let pair = detect(&mut scene, last).pairs[0];
    assert_eq!((pair.verdict, pair.complete), (Verdict::Separated, true));
    scene.calibration()
}

#[test]
fn estimates_of_bodies_at_rest_teach_and_those_of_bodies_that_moved_since_do_not() {
    for last in [Budget::unlimited(), Budget::work(1 << 40)] {
        assert_ne!(learned(false, last), Calibration::default(), "{last:?}");
        assert_eq!(learned(true, last), Calibration::default(), "{last:?}");
    }
}
