//! Bodies whose trees have a radius, in a scene: as pairs and as rays see them.

use super::*;
use punctual::Ray;
use punctual_scene::SceneRay;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, y, z]).unwrap()
}

#[test]
fn balls_capsules_and_rounded_boxes_meet_a_field_by_their_radii() {
    // A plane above y = -10, hills beyond it.
    let heights = (0..41 * 41).map(|i| {
        if i < 20 * 41 {
            (0.7 * f64::from(i)).sin()
        } else {
            0.0
        }
    });
    let field = Arc::new(Tree::height_field(heights, 41, [1.0; 2]).unwrap());
    let mut scene = Scene::new();
    let ground = scene
        .insert(Body::fixed(field, at(-10.0, -30.0, 0.0)))
        .unwrap();
    let kinds = [
        (Tree::ball(0.5), 0.5),
        (Tree::capsule(0.25, 1.0), 0.75),
        (Tree::rounded_cuboid([1.0; 3], 0.25), 0.5),
        (Tree::cuboid([1.0; 3]), 0.5),
        (Tree::cylinder(0.25, 1.0), 0.5),
        (Tree::cone(0.25, 1.0), 0.5),
    ];
    let mut bodies = Vec::new();
    for (i, (tree, reach)) in kinds.into_iter().enumerate() {
        let tree = Arc::new(tree.unwrap());
        for (k, height) in [0.999, 1.001].into_iter().enumerate() {
            let pose = at(3.0 * i as f64, 5.0 * k as f64, height * reach);
            let body = scene.insert(Body::moving(Arc::clone(&tree), pose)).unwrap();
            bodies.push((body, height < 1.0, pose.translation(), reach));
        }
    }
    for _ in 0..3 {
        let report = scene.detect(Budget::unlimited());
        for &(body, meets, ..) in &bodies {
            let verdict = report.pair(ground, body).map(|pair| pair.verdict);
            assert_eq!(verdict.is_some_and(|verdict| verdict.meets()), meets);
        }
    }
    for &(body, _, place, reach) in &bodies {
        let ray = Ray::new([place.x, place.y, 9.0], [0.0, 0.0, -1.0]).unwrap();
        let cast = scene.cast(&SceneRay::new(ray), Budget::unlimited());
        let hit = cast.unwrap().hit.unwrap();
        assert_eq!(hit.body, body);
        assert!((hit.on_body.t - (9.0 - place.z - reach)).abs() < 1e-9);
    }
}
