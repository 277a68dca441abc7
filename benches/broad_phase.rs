//! The broad phase of a scene by its number of bodies: `cargo bench -p punctual-benches --bench broad_phase`.
//!
//! Bodies with boxes of edge 2 in a cube, 5 units of volume to a body, a tenth of them fixed, go straight and are reflected at
//! the walls, at two speeds. Printed are medians over frames, new poses included, and queries of a body's two small triangles.

use std::sync::Arc;
use std::time::Instant;

use oorandom::Rand64;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mesh, Pose, Tree};
use punctual_scene::{Body, Scene};

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).expect("a shift is a pose")
}

/// A small triangle in each of two opposite corners of a cube of edge 2.
fn corners() -> Tree {
    let corner = |at: f32| [[at, at, at], [0.99 * at, at, at], [at, 0.99 * at, at]];
    let vertices = [corner(-1.0), corner(1.0)].concat();
    Tree::new(Mesh::new(vertices, [[0u32, 1, 2], [3, 4, 5]]).expect("the mesh is sound"))
}

fn measure(bodies: usize, speed: f64, frames: usize) -> (f64, f64) {
    let corners = Arc::new(corners());
    let wall = 0.5 * (20.0 * bodies as f64).cbrt();
    let mut random = Rand64::new(1);
    let mut vector =
        |scale: f64| scale * DVec3::from_array([(); 3].map(|()| 2.0 * random.rand_float() - 1.0));
    let mut moving: Vec<(DVec3, DVec3)> =
        (0..bodies).map(|_| (vector(wall), vector(speed))).collect();
    let mut scene = Scene::new();
    let insert = |(body, (place, _)): (usize, &(DVec3, DVec3))| match body % 10 {
        0 => scene.insert(Body::fixed(Arc::clone(&corners), at(*place))),
        _ => scene.insert(Body::moving(Arc::clone(&corners), at(*place))),
    };
    let ids: Vec<_> = moving
        .iter()
        .enumerate()
        .map(insert)
        .collect::<Result<_, _>>()
        .expect("all are sound");
    let (mut times, mut pairs) = (Vec::new(), 0);
    for _ in 0..frames {
        let start = Instant::now();
        for (body, (place, velocity)) in moving
            .iter_mut()
            .enumerate()
            .filter(|(body, _)| body % 10 != 0)
        {
            *place += *velocity;
            for axis in 0..3 {
                if place[axis].abs() > wall {
                    velocity[axis] = -velocity[axis].abs() * place[axis].signum();
                }
            }
            scene
                .set_pose(ids[body], at(*place))
                .expect("it is in the scene");
        }
        pairs = scene.detect(Budget::unlimited()).pairs.len();
        times.push(start.elapsed().as_secs_f64());
    }
    times.drain(..frames / 4);
    times.sort_unstable_by(f64::total_cmp);
    (
        times[times.len() / 2] * 1e9 / bodies as f64,
        pairs as f64 / bodies as f64,
    )
}

fn main() {
    println!("bodies  ns a body slow  fast  pairs a body");
    for bodies in [2, 1_000, 3_000, 10_000, 30_000, 100_000] {
        let frames = (4_000_000 / bodies).clamp(40, 2_000);
        let (slow, pairs) = measure(bodies, 0.01, frames);
        let (fast, _) = measure(bodies, 0.2, frames);
        println!("{bodies:>6} {slow:>15.0} {fast:>5.0} {pairs:>13.2}");
    }
}
