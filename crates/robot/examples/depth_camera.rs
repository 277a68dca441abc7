//! An arm before a depth camera: each image becomes the cloud that replaces the last one, and the
//! arm goes on only where the way to its goal is proven free among the points. A box is pushed into
//! that way. `depth_camera`.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use punctual::glam::{DMat3, DVec3};
use punctual::rays::RayHit;
use punctual::{Budget, DepthCamera, Mesh, Pose, Query, Ray, Tree, Workspace, shapes};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, EdgeAnswer, EdgeOptions, Model, NearPairs, Shape,
    UrdfOptions,
};

/// Half of the distance of neighbouring points on what the camera sees, about.
const RADIUS: f64 = 0.006;

/// What stands there: a table, and a box at this place along y.
fn scene(y: f64) -> Result<Mesh, Box<dyn Error>> {
    let parts = [
        (
            shapes::cuboid([0.4, 0.9, 0.02], 1),
            DVec3::new(0.55, 0.0, 0.18),
        ),
        (
            shapes::cuboid([0.06, 0.06, 0.2], 1),
            DVec3::new(0.45, y, 0.4),
        ),
    ];
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (part, at) in parts {
        let first = vertices.len() as u32;
        vertices.extend((0..part.vertex_count()).map(|i| (part.vertex(i) + at).to_array()));
        triangles.extend(part.triangles().iter().map(|t| t.map(|i| i + first)));
    }
    Ok(Mesh::from_f64(vertices, triangles)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/arm7.urdf");
    let mut checker = Checker::new(Model::from_urdf(own, &UrdfOptions::default())?.into());
    let camera = DepthCamera {
        size: [320, 240],
        focal: [280.0; 2],
        center: [159.5, 119.5],
        scale: 1.0,
    };
    // It looks from above the table, down and back to the arm.
    let forward = DVec3::new(-0.35, 0.0, -1.0).normalize();
    let right = DVec3::Y;
    let rotation = DMat3::from_cols(right, forward.cross(right), forward);
    let place = Pose::new(rotation, [0.85, 0.0, 1.5])?;
    let pixel = |i: usize| {
        let at = DVec3::new((i % 320) as f64, (i / 320) as f64, 0.0);
        let [x, y] = [0, 1].map(|k| (at[k] - camera.center[k]) / camera.focal[k]);
        Ray::new(place.translation(), rotation * DVec3::new(x, y, 1.0))
    };
    let rays: Vec<Ray> = (0..320 * 240).map(pixel).collect::<Result<_, _>>()?;

    let (mut workspace, mut points, mut near) =
        (Workspace::new(), Vec::new(), NearPairs::default());
    let goal = vec![0.9, 0.75, 0.0, 1.2, 0.0, 1.2, 0.0];
    let mut now = goal.clone();
    now[0] = -0.9;
    let (mut cloud, mut slowest, mut stops) = (None, Duration::ZERO, 0);
    for frame in 0..90 {
        // The simulated image: without noise, and without the arm in it.
        let world = Tree::new(scene(
            0.9 - 0.55 * (f64::from(frame) / 60.0 * std::f64::consts::PI).sin(),
        )?);
        let _ = Query::rays(&world, &rays).run(&mut workspace, Budget::unlimited());
        let depth = |hit: &Option<RayHit>| hit.map_or(0.0, |hit| hit.t as f32);
        let depths: Vec<f32> = workspace.first_hits().iter().map(depth).collect();

        // What a controller does with it.
        let start = Instant::now();
        camera.points(&depths, &mut points)?;
        let tree = Tree::from_points(points.iter().copied())?.with_radius(RADIUS)?;
        if let Some(last) = cloud.take() {
            checker.remove(last)?;
        }
        cloud = Some(checker.add("camera", place, Shape::tree(Arc::new(tree)))?);
        let edge = checker.edge(
            &now,
            &goal,
            &EdgeOptions::first(),
            Budget::time(Duration::from_millis(3)),
        )?;
        let way = edge.value.free_until;
        let taken = start.elapsed();
        slowest = slowest.max(taken);

        // A thirtieth of the way in a frame, at most to a tenth before what is proven.
        let step = (1.0f64 / 30.0).min(0.9 * way);
        now.iter_mut()
            .zip(&goal)
            .for_each(|(x, to)| *x += step * (to - *x));
        assert_eq!(
            checker.collide(&now, Budget::unlimited())?.value,
            Collision::Free
        );
        stops += u32::from(edge.value.answer != EdgeAnswer::Free);
        if frame % 10 == 0 {
            let options = ClearanceOptions::default();
            let _ = checker.near_pairs(&now, 0.1, &options, Budget::unlimited(), &mut near)?;
            println!(
                "frame {frame}: {} points, {:.1} ms, way {way:.3} ({:?}), {} pairs within 10 cm",
                points.len(),
                taken.as_secs_f64() * 1e3,
                edge.value.answer,
                near.pairs.len()
            );
        }
    }
    println!(
        "slowest frame {:.1} ms; the way was not free in {stops} of 90 frames",
        slowest.as_secs_f64() * 1e3
    );
    assert!(stops > 0);
    Ok(())
}
