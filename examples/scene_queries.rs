//! Questions between frames: many rays, a shape on its way, what it overlaps, and what is closest.

use std::error::Error;
use std::sync::Arc;

use punctual::{Budget, Mode, Pose, Ray, Tree, shapes};
use punctual_scene::{Body, Scene, SceneRay, SceneShape};

fn main() -> Result<(), Box<dyn Error>> {
    let at = |x: f64, y: f64| Pose::from_quat([0.0, 0.0, 0.0, 1.0], [x, y, 0.0]);
    let (ball, post) = (shapes::icosphere(4), shapes::cuboid([0.2, 0.2, 2.0], 4));
    let (ball, post) = (Arc::new(Tree::new(ball)), Arc::new(Tree::new(post)));
    let mut scene = Scene::new();
    for (x, name) in [(3.0, "near post"), (6.0, "far post")] {
        let id = scene.insert(Body::fixed(Arc::clone(&post), at(x, 0.0)?))?;
        scene.set_name(id, name)?;
    }
    let player = scene.insert(Body::moving(Arc::clone(&ball), at(0.0, 0.5)?))?;
    scene.detect(Budget::unlimited());

    let ray =
        |y| Ray::new([0.0, y, 0.0], [1.0, 0.0, 0.0]).map(|ray| SceneRay::new(ray).of_body(player));
    let rays: Vec<_> = (0..10)
        .map(|i| ray(0.1 * f64::from(i)))
        .collect::<Result<_, _>>()?;
    let hits = scene
        .cast_rays(&rays, Budget::unlimited())?
        .iter()
        .filter(|cast| cast.hit.is_some());
    println!("{} of {} rays hit a post", hits.count(), rays.len());

    // Where the player may go, asked within a budget: proven even if that ends first.
    let shape = SceneShape::new(&ball, at(0.0, 0.5)?).of_body(player);
    let cast = scene.cast_shape(&shape.along([9.0, 0.0, 0.0])?, Budget::work(50_000))?;
    let met = cast.hit.map_or("nothing", |hit| scene.name(hit.body));
    println!(
        "along x it is free for {:.3} of the way, and meets the {met}",
        cast.free_until
    );

    let closest = scene.closest(&shape, f64::INFINITY, Budget::unlimited())?;
    println!("the closest body is {:.3} away", closest.high);
    let around = scene.overlap(&shape.margin(5.0), Mode::All, Budget::unlimited())?;
    println!("{} bodies are within 5 of it", around.met.len());
    Ok(())
}
