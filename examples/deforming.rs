//! A flag waves in the wind and meets a turning gear: a mesh that deforms, refitted in each frame
//! and rebuilt when that pays.
//!
//! Prints for some frames the time of the refit and its prediction, how loose the boxes have
//! become, how many triangles of flag and gear meet, and the work of the query on the refitted tree
//! and on a new one. Both queries must find the same number.

mod common;

use std::error::Error;
use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::prediction::CostModel;
use punctual::{Budget, Mesh, Mode, Pose, Query, Tree, Workspace, shapes};
use punctual_scene::{Body, Scene};

const CELLS: u32 = 48;
const SIDE: u32 = CELLS + 1;

/// A new tree costs about seven refits. For a shape that is asked about only once it pays from a
/// degradation of about 2 on.
const REBUILD_ABOVE: f32 = 1.25;

/// The vertices of a flag of 2 x 1, from the pole at x = 0.
fn flag(time: f32) -> Vec<Vec3> {
    let vertex = |i: u32| {
        let (x, y) = (
            (i % SIDE) as f32 / CELLS as f32,
            (i / SIDE) as f32 / CELLS as f32,
        );
        let wave = (7.0 * x - 4.0 * time).sin() + 0.5 * (5.0 * y + 11.0 * x - 6.0 * time).sin();
        Vec3::new(2.0 * x, y, 0.3 * (4.0 * time).min(1.0) * x * wave)
    };
    (0..SIDE * SIDE).map(vertex).collect()
}

fn triangles() -> impl Iterator<Item = [u32; 3]> {
    let cells = (0..CELLS * CELLS).map(|cell| cell % CELLS + cell / CELLS * SIDE);
    cells.flat_map(|i| [[i, i + 1, i + SIDE], [i + 1, i + SIDE + 1, i + SIDE]])
}

fn wave(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let gear = Arc::new(Tree::new(shapes::gear(17, 6)));
    let mut scene = Scene::new();
    scene.set_mode(Mode::All);
    let waving = Arc::new(Tree::new(Mesh::new(flag(0.0), triangles())?));
    let waving = scene.insert(Body::moving(waving, Pose::IDENTITY))?;
    let turning = scene.insert(Body::moving(Arc::clone(&gear), Pose::IDENTITY))?;
    let mut workspace = Workspace::new();
    let costs = CostModel::measure();
    writeln!(
        out,
        "frame  refit us  told  degradation  contacts   work  work of a new tree"
    )?;
    for frame in 0..120 {
        let time = frame as f32 / 60.0;
        let turn = DMat3::from_rotation_x(1.2) * DMat3::from_rotation_z(f64::from(time));
        let place = Pose::new(turn, DVec3::new(1.8, 0.5, 0.8 - 0.4 * f64::from(time)))?;
        scene.set_pose(turning, place)?;
        let vertices = flag(time);
        let tree = scene.tree_mut(waving)?;
        let start = Instant::now();
        tree.refit(&vertices)?;
        let (took, degradation) = (start.elapsed().as_micros(), tree.degradation());
        let told = 1e-3 * costs.refit_time(tree);
        let fresh = Tree::new(tree.mesh().clone());
        let mut alone =
            |tree| Query::all_pairs(tree, &gear, place).run(&mut workspace, Budget::unlimited());
        let (refitted, rebuilt) = (alone(tree), alone(&fresh));

        let report = scene.detect(Budget::unlimited());
        let contacts = report.pair(waving, turning).map_or(0, |pair| pair.found);
        assert_eq!(
            [contacts, refitted.stats.found],
            [rebuilt.stats.found; 2],
            "frame {frame}"
        );
        if frame % 10 == 0 {
            let (work, new) = (refitted.stats.work, rebuilt.stats.work);
            writeln!(
                out,
                "{frame:>5} {took:>9} {told:>5.0} {degradation:>12.2} {contacts:>9} {work:>6} {new:>6}"
            )?;
        }
        if degradation > REBUILD_ABOVE {
            scene.set_tree(waving, Arc::new(fresh))?;
            writeln!(out, "{frame:>5} rebuilt")?;
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(wave)
}
