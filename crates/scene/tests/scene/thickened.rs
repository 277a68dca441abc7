//! Bodies whose trees have a radius, in a scene: as pairs and as rays see them.

use super::*;
use punctual::{Mesh, Ray};
use punctual_scene::SceneRay;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, y, z]).unwrap()
}

#[test]
fn balls_capsules_and_rounded_boxes_meet_a_field_by_their_radii() {
    let segment = |half: f64, radius: f64| {
        let ends = [[0.0, 0.0, -half], [0.0, 0.0, half]];
        let core = Mesh::from_f64(ends.to_vec(), vec![[0, 1, 1]]).unwrap();
        Arc::new(Tree::new(core).with_radius(radius).unwrap())
    };
    let core = Tree::new(shapes::cuboid([0.25; 3], 1));
    let rounded = Arc::new(core.with_radius(0.25).unwrap());
    let field = Arc::new(Tree::new(shapes::cuboid([20.0, 20.0, 0.5], 16)));
    let mut scene = Scene::new();
    let ground = scene
        .insert(Body::fixed(field, at(0.0, 0.0, -0.5)))
        .unwrap();
    let kinds = [
        (segment(0.0, 0.5), 0.5),
        (segment(0.5, 0.25), 0.75),
        (rounded, 0.5),
    ];
    let mut bodies = Vec::new();
    for (i, (tree, reach)) in kinds.iter().enumerate() {
        for (k, height) in [0.999, 1.001].into_iter().enumerate() {
            let pose = at(3.0 * i as f64, 5.0 * k as f64, height * reach);
            let body = scene.insert(Body::moving(Arc::clone(tree), pose)).unwrap();
            bodies.push((body, height < 1.0, pose.translation(), *reach));
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
