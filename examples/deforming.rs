//! A flag waves in the wind and meets a turning gear: a mesh that is another one in each frame, its tree built anew.
//!
//! Prints, for some frames, how long the new tree took, and how many triangles of the flag and the gear meet; each count is
//! compared with a query of the two alone.

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Body, Budget, Mesh, MeshError, Mode, Pose, Query, Scene, Tree, Workspace, shapes};

const CELLS: u32 = 48;

/// A flag of 2 x 1, from the pole at x = 0.
fn flag(time: f32) -> Result<Mesh, MeshError> {
    let side = CELLS + 1;
    let vertex = |i: u32| {
        let (x, y) = ((i % side) as f32 / CELLS as f32, (i / side) as f32 / CELLS as f32);
        let wave = (7.0 * x - 4.0 * time).sin() + 0.5 * (5.0 * y + 11.0 * x - 6.0 * time).sin();
        Vec3::new(2.0 * x, y, 0.3 * x * wave)
    };
    let cells = (0..CELLS * CELLS).map(|cell| cell % CELLS + cell / CELLS * side);
    let triangles = cells.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]);
    Mesh::new((0..side * side).map(vertex), triangles)
}

fn main() -> Result<(), Box<dyn Error>> {
    let gear = Arc::new(Tree::new(shapes::gear(17, 6)));
    let mut scene = Scene::new().mode(Mode::All);
    let waving = scene.insert(Body::moving(Arc::new(Tree::new(flag(0.0)?)), Pose::IDENTITY))?;
    let turning = scene.insert(Body::moving(Arc::clone(&gear), Pose::IDENTITY))?;
    let mut workspace = Workspace::new();
    println!("frame  build us  contacts");
    for frame in 0..120 {
        let time = frame as f32 / 60.0;
        let start = Instant::now();
        let tree = Arc::new(Tree::new(flag(time)?));
        let build = start.elapsed().as_micros();
        let turn = DMat3::from_rotation_x(1.2) * DMat3::from_rotation_z(f64::from(time));
        let place = Pose::new(turn, DVec3::new(1.8, 0.5, 0.8 - 0.4 * f64::from(time)))?;
        scene.set_tree(waving, Arc::clone(&tree))?;
        scene.set_pose(turning, place)?;

        let report = scene.detect(Budget::unlimited());
        let contacts = report.pair(waving, turning).map_or(0, |pair| pair.found);
        let alone = Query::new(&tree, &gear, place).mode(Mode::All).run(&mut workspace, Budget::unlimited());
        assert_eq!(contacts, alone.found, "frame {frame}");
        if frame % 10 == 0 {
            println!("{frame:>5} {build:>9} {contacts:>9}");
        }
    }
    Ok(())
}
