//! Crates, rocks, bunnies and armadillos fall into a bin and come to rest: manifolds for a solver.
//!
//! A scene finds the manifolds of each pair within a skin: at most four points a piece, apart or
//! sunk, with ids that last. The small [`solver`] keeps bodies half a skin apart. It starts from the
//! impulses that the point with the same id had in the frame before.
//!
//! `cargo run --release --example falling [-- [--picture FILE.svg] [FILE.obj ...]]`
//!
//! Files are further kinds of bodies. All are scaled to a diagonal of one.

#[path = "../common/mod.rs"]
mod common;
mod picture;
#[allow(dead_code, reason = "`punctual pile` uses the rest")]
#[path = "../../crates/cli/src/pile/solver.rs"]
mod solver;
#[allow(dead_code, reason = "`punctual pile` uses the rest")]
#[path = "../../crates/cli/src/pile/world.rs"]
mod world;

use std::error::Error;
use std::io::{StdoutLock, Write};
use std::time::Duration;
use std::{env, fs};

use cpu_time::ThreadTime;
use picture::Picture;
use punctual::glam::{DQuat, DVec3, Vec3};
use punctual::{Budget, Mesh, MeshError, shapes};
use punctual_depenetrate::PenetrationWorkspace;
use solver::FRAME;
use world::{Pile, SIZE, Shape};

const BODIES: usize = 40;
/// The first bodies are the bin: a floor and four walls.
const FIXED: usize = 5;
/// Distance within which bodies have contacts. As no time is short, it is wide: what comes near within
/// a frame has contacts before it touches.
const SKIN: f64 = 0.02 * SIZE;
/// What bodies may be sunk in at rest, as a share of their size.
const DEEPEST: f64 = 0.002;
/// A body whose fastest point is slower than this, in sizes a second, is at rest.
const AT_REST: f64 = 0.01;
const FRAMES: usize = 480;
/// From this frame on, everything must have settled as far as overlaps go.
const SETTLED: usize = 180;
/// A closed star: a ball with bumps, each of a direction, a height and a sharpness.
fn star(detail: u32, scale: DVec3, bumps: &[(DVec3, f64, f64)]) -> Result<Mesh, MeshError> {
    let ball = shapes::icosphere(detail);
    let vertices = (0..ball.vertex_count()).map(|i| {
        let way = ball.vertex(i);
        let bump = |&(to, height, sharpness): &(DVec3, f64, f64)| {
            height * (sharpness * (way.dot(to.normalize()) - 1.0)).exp()
        };
        scale * way * (1.0 + bumps.iter().map(bump).sum::<f64>())
    });
    Mesh::from_f64(vertices, ball.triangles().iter().copied())
}

/// The mesh of an OBJ file with `v` and `f` lines, its middle at the origin, its diagonal one.
fn load(path: &str) -> Result<Mesh, Box<dyn Error>> {
    let text = fs::read_to_string(path)?;
    let lines = |kind: &'static str| {
        let rows = text.lines().map(|line| line.split_ascii_whitespace());
        rows.filter_map(move |mut row| (row.next() == Some(kind)).then_some(row))
    };
    let mut vertices = Vec::new();
    for mut row in lines("v") {
        let mut next = || row.next().unwrap_or("").parse::<f64>();
        vertices.push(DVec3::new(next()?, next()?, next()?));
    }
    let mut triangles = Vec::new();
    for mut row in lines("f") {
        let mut next = || {
            row.next()
                .unwrap_or("")
                .split('/')
                .next()
                .unwrap_or("")
                .parse::<u32>()
        };
        triangles.push([next()?, next()?, next()?].map(|vertex| vertex.wrapping_sub(1)));
    }
    let bounds = Mesh::from_f64(vertices.clone(), triangles.clone())?.aabb();
    let (middle, scale) = (bounds.center(), 1.0 / bounds.extents().length());
    let vertices = vertices.into_iter().map(|vertex| scale * (vertex - middle));
    Ok(Mesh::from_f64(vertices, triangles)?)
}

/// Names of kinds, and the bodies of each.
fn kinds() -> Result<Vec<(String, Vec<Mesh>)>, MeshError> {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut rocks = Vec::new();
    for k in 0..5 {
        let turn = DQuat::from_rotation_z(f64::from(k));
        let bumps = [x, y + z, y - x, z - x, -z, x - y - z].map(|to| (turn * to, 0.25, 6.0));
        rocks.push(star(2, 0.3 * DVec3::new(1.0, 0.8, 0.7), &bumps)?);
    }
    let head = (x + 0.6 * z, 0.7, 9.0);
    let ears = [
        (x + 2.0 * z + 0.6 * y, 1.1, 40.0),
        (x + 2.0 * z - 0.6 * y, 1.1, 40.0),
    ];
    let bunny = star(
        3,
        DVec3::splat(0.22),
        &[head, ears[0], ears[1], (-x, 0.3, 20.0)],
    )?;
    let limbs = [x + y, x - y, y - x, -x - y].map(|to| (to, 1.2, 25.0));
    let body = [(z, 0.5, 12.0), (3.0 * z - 2.0 * x, 1.0, 30.0)];
    let armadillo = star(3, DVec3::splat(0.2), &[&limbs[..], &body[..]].concat())?;
    let crates = vec![shapes::cuboid(Vec3::splat(0.25), 3)];
    let all = [
        ("crates", crates),
        ("rocks", rocks),
        ("bunnies", vec![bunny]),
        ("armadillos", vec![armadillo]),
    ];
    Ok(all.map(|(name, meshes)| (name.into(), meshes)).into())
}

fn run(out: &mut StdoutLock) -> Result<(), Box<dyn Error>> {
    let mut all = kinds()?;
    let (mut picture, mut path) = (Picture::default(), None);
    let mut arguments = env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--picture" {
            path = Some(arguments.next().ok_or("--picture FILE.svg")?);
        } else {
            let mesh = load(&argument)?;
            all.push((argument, vec![mesh]));
        }
    }
    writeln!(
        out,
        "{BODIES} bodies of each kind, {} s; after {} s none may be deeper than {} % of its size.",
        FRAMES as f64 * FRAME,
        SETTLED as f64 * FRAME,
        100.0 * DEEPEST
    )?;
    let (mut failures, mut pushes) = (Vec::new(), PenetrationWorkspace::default());
    for (name, meshes) in all {
        let shapes = meshes.iter().map(|mesh| Shape::new(mesh, SIZE));
        let shapes: Vec<Shape> =
            (shapes.collect::<Result<_, _>>()).map_err(|error| format!("{name}: {error}"))?;
        let mut pile = Pile::new(&shapes, BODIES, SKIN)?;
        let (mut deepest, mut manifolds) = (0.0_f64, 0);
        let (mut took, mut slowest) = (Duration::ZERO, Duration::ZERO);
        let pictured: &[usize] = match &*name {
            "crates" => &[20, 60, FRAMES - 1],
            _ => &[],
        };
        for frame in 0..FRAMES {
            pile.place()?;
            if pictured.contains(&frame) {
                let bodies = pile.scene.bodies().map(|(_, body)| body);
                picture.add(bodies, &format!("{:.1} s", frame as f64 * FRAME));
            }
            let start = ThreadTime::now();
            pile.scene.detect(Budget::unlimited());
            let time = start.elapsed();
            (took, slowest) = (took + time, slowest.max(time));
            if frame >= SETTLED && frame % 30 == 0 {
                deepest = deepest.max(*pile.depths(&mut pushes)?.last().unwrap_or(&0.0));
            }
            manifolds += pile.advance()?.manifolds;
        }
        let speed = *pile.speeds().last().unwrap_or(&0.0);
        let milliseconds = |time: Duration| 1e3 * time.as_secs_f64();
        writeln!(
            out,
            "{name}: deepest overlap {:.3} %, fastest point {speed:.4} sizes a second.\n  \
             {} manifolds a frame, found in {:.1} ms, at most {:.1}.",
            100.0 * deepest,
            manifolds / FRAMES,
            milliseconds(took) / FRAMES as f64,
            milliseconds(slowest)
        )?;
        if deepest > DEEPEST || speed > AT_REST {
            failures.push(name);
        }
    }
    if let Some(path) = path {
        fs::write(path, picture.svg())?;
    }
    if failures.is_empty() {
        Ok(())
    } else {
        Err(format!("these did not come to rest: {failures:?}").into())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(run)
}
