//! What does a range sensor see in a room with a pillar? A batch of rays.

use std::error::Error;

use punctual::glam::DMat3;
use punctual::{Budget, Pose, Query, Ray, Tree, Workspace, shapes};
use punctual_scene::{Body, Scene, SceneRay};

fn main() -> Result<(), Box<dyn Error>> {
    let room = Tree::new(shapes::cuboid([4.0, 3.0, 1.5], 8));
    let mut workspace = Workspace::new();
    let rays = (0..360)
        .map(|degree| f64::from(degree).to_radians())
        .map(|angle| Ray::new([1.0, 0.5, 0.0], [angle.cos(), angle.sin(), 0.0]))
        .collect::<Result<Vec<Ray>, _>>()?;

    let scan = Query::rays(&room, &rays).run(&mut workspace, Budget::unlimited());
    let ranges = workspace.first_hits().iter().flatten().map(|hit| hit.t);
    let [least, most] = ranges.fold([f64::INFINITY, 0.0], |[l, m], t| [t.min(l), t.max(m)]);
    println!("{} rays, walls {least:.3} to {most:.3} away", scan.value);

    // In a scene, a ray tells which body it hits.
    let mut scene = Scene::new();
    let pillar = Tree::new(shapes::cuboid([0.2, 0.2, 1.5], 4)).into();
    let place = Pose::new(DMat3::IDENTITY, [3.0, 0.5, 0.0])?;
    let bodies = [
        Body::fixed(room.into(), Pose::IDENTITY),
        Body::fixed(pillar, place),
    ];
    let [_, pillar] = bodies.map(|body| scene.insert(body));
    let cast = scene.cast(&SceneRay::new(rays[0]), Budget::unlimited())?;
    let hit = cast.hit.ok_or("nothing is hit")?;
    let (is_pillar, range) = (hit.body == pillar?, hit.on_body.t);
    println!("the first ray hits the pillar: {is_pillar}, {range:.3} away");
    Ok(())
}
