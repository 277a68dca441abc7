//! Crates, rocks, bunnies and armadillos fall into a bin and come to rest: manifolds for a solver.
//!
//! The library finds the manifolds of each pair within a skin: at most four points a piece, apart
//! or sunk, with ids that last. The small [`solver`] keeps bodies a skin apart. It starts from the
//! impulses that the point with the same id had in the frame before.
//!
//! `cargo run --release --example falling [-- [--picture FILE.svg] [FILE.obj ...]]`
//!
//! Files are further kinds of bodies, in metres times any factor: they are scaled to a diagonal of
//! one.

#[path = "../common/mod.rs"]
mod common;
mod picture;
#[allow(dead_code, reason = "`punctual pile` uses the rest")]
#[path = "../../crates/cli/src/pile/solver.rs"]
mod solver;

use std::collections::{HashMap, HashSet};
use std::error::Error;
use std::io::{StdoutLock, Write};
use std::rc::Rc;
use std::time::Duration;
use std::{env, fs, mem};

use cpu_time::ThreadTime;
use picture::Picture;
use punctual::glam::{DQuat, DVec3, Vec3};
use punctual::tree::Solid;
use punctual::{
    Budget, BuildOptions, Mesh, MeshError, PairMemory, Pose, PoseError, Query, Tree, Verdict,
    Workspace, shapes,
};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
use solver::{Contact, ContactKey, FRAME, Mass, RigidBody, Solver};

const BODIES: usize = 40;
/// The first bodies are the bin: a floor and four walls.
const FIXED: usize = 5;
/// Distance at which bodies rest, and what they may be sunk in at rest, in metres.
const SKIN: f64 = 0.005;
const DEEPEST: f64 = 0.002;
/// A body whose fastest point is slower than this, in m/s, is at rest.
const AT_REST: f64 = 0.01;
const FRAMES: usize = 480;
/// From this frame on, everything must have settled as far as overlaps go.
const SETTLED: usize = 180;
/// Budget of one pair of bodies in one frame: more than any needs.
const BUDGET: Budget = Budget::work(10_000_000);

/// Counts over all frames.
#[derive(Default)]
struct Tally {
    points: usize,
    /// Points that had the same id in the frame before.
    known: usize,
    /// Bodies that were moved apart because an overlap had no normal.
    teleports: usize,
    /// Processor time, without that of other programs.
    slowest: Duration,
    took: Duration,
}

struct World {
    /// Of each body.
    trees: Vec<Rc<Tree>>,
    bodies: Vec<RigidBody>,
    poses: Vec<Pose>,
    contacts: Vec<Contact>,
    /// Those of this frame, and of the one before.
    keys: [HashSet<ContactKey>; 2],
    memories: HashMap<[usize; 2], PairMemory>,
    solver: Solver,
    workspace: Workspace,
    pushes: PenetrationWorkspace,
    tally: Tally,
}

impl World {
    fn insert(&mut self, tree: &Rc<Tree>, body: RigidBody) {
        self.trees.push(Rc::clone(tree));
        self.bodies.push(body);
    }

    fn place(&mut self) -> Result<(), PoseError> {
        self.poses = self
            .bodies
            .iter()
            .map(RigidBody::pose)
            .collect::<Result<_, _>>()?;
        Ok(())
    }

    fn frame(&mut self) -> Result<(), PoseError> {
        let start = ThreadTime::now();
        self.place()?;
        self.contacts.clear();
        self.keys.swap(0, 1);
        self.keys[0].clear();
        for b in 0..self.bodies.len() {
            for a in 0..b {
                if !self.bodies[b].is_fixed() {
                    self.touch([a, b])?;
                }
            }
        }
        let took = start.elapsed();
        self.tally.slowest = self.tally.slowest.max(took);
        self.tally.took += took;
        self.solver.step(&mut self.bodies, &mut self.contacts);
        Ok(())
    }

    /// The pose of the second body in the frame of the first, if their boxes are within `margin`.
    fn near(&self, pair: [usize; 2], margin: f64) -> Result<Option<Pose>, PoseError> {
        let [x, y] = pair.map(|i| self.trees[i].aabb_at(&self.poses[i]));
        let gaps = (x.min - y.max).max(y.min - x.max);
        if gaps.max_element() > margin {
            return Ok(None);
        }
        let [a, b] = pair.map(|i| &self.poses[i]);
        a.inverse()?.compose(b).map(Some)
    }

    /// Finds the points at which two bodies may touch within this frame.
    fn touch(&mut self, pair: [usize; 2]) -> Result<(), PoseError> {
        let [a, b] = pair.map(|i| &self.bodies[i]);
        let spin = [a, b].map(|body| body.spin.length() * body.radius);
        let approach = a.velocity.distance(b.velocity) + spin[0] + spin[1];
        let skin = 2.0 * SKIN + FRAME * approach;
        let Some(b_in_a) = self.near(pair, skin)? else {
            return Ok(());
        };
        let [a, b] = pair.map(|i| &self.trees[i]);
        let query = Query::manifolds(a, b, b_in_a).skin(skin);
        let memory = self.memories.entry(pair).or_default();
        let _ = query.with_memory(memory).run(&mut self.workspace, BUDGET);
        let found = self.workspace.manifolds();
        if found.iter().any(|one| one.normal == DVec3::ZERO) {
            return self.part(pair);
        }
        let a = &self.poses[pair[0]];
        for point in found.iter().flat_map(|one| one.points()) {
            let key = (pair, point.id);
            self.tally.points += 1;
            self.tally.known += usize::from(self.keys[1].contains(&key));
            self.keys[0].insert(key);
            let places = point.points.map(|end| a.transform_point(end));
            let normal = *a.rotation() * point.normal;
            let gap = point.distance - SKIN;
            self.contacts
                .push(Contact::new(key, places, normal, gap, &self.bodies));
        }
        Ok(())
    }

    /// Moves the second body out of the first. The second one is never fixed.
    fn part(&mut self, pair: [usize; 2]) -> Result<(), PoseError> {
        let Some(b_in_a) = self.near(pair, 0.0)? else {
            return Ok(());
        };
        let [a, b] = pair.map(|i| &self.trees[i]);
        let query = PenetrationQuery::new(a, b, b_in_a).push_only(true);
        let found = query.run(&mut self.pushes, BUDGET).value;
        if let Some(direction) = found.direction {
            self.tally.teleports += 1;
            let way = *self.poses[pair[0]].rotation() * direction * found.high;
            self.bodies[pair[1]].position += way;
        }
        Ok(())
    }

    /// The deepest overlap of any two bodies: the shortest push found that parts them. It knows
    /// nothing of manifolds.
    fn deepest(&mut self) -> Result<f64, PoseError> {
        let mut deepest = 0.0_f64;
        self.place()?;
        for j in 0..self.bodies.len() {
            for i in 0..j {
                let Some(b_in_a) = self
                    .near([i, j], 0.0)?
                    .filter(|_| !self.bodies[j].is_fixed())
                else {
                    continue;
                };
                let (a, b) = (&self.trees[i], &self.trees[j]);
                let meet = Query::intersection(a, b, b_in_a);
                if meet.run(&mut self.workspace, BUDGET).value == Verdict::Separated {
                    continue;
                }
                let query = PenetrationQuery::new(a, b, b_in_a).push_only(true);
                deepest = deepest.max(query.run(&mut self.pushes, BUDGET).value.high);
            }
        }
        Ok(deepest)
    }

    /// Speed of the fastest point of any body.
    fn speed(&self) -> f64 {
        self.bodies.iter().map(RigidBody::speed).fold(0.0, f64::max)
    }
}

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

fn solid(mesh: Mesh) -> Rc<Tree> {
    let options = BuildOptions::default().solid(Solid::Keep);
    Rc::new(Tree::with_options(mesh, &options))
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

/// A bin, and bodies of these kinds in layers above it.
fn world(meshes: Vec<Mesh>) -> Result<World, Box<dyn Error>> {
    let mut world = World {
        trees: Vec::new(),
        bodies: Vec::new(),
        poses: Vec::new(),
        contacts: Vec::new(),
        keys: [HashSet::new(), HashSet::new()],
        memories: HashMap::new(),
        solver: Solver::default(),
        workspace: Workspace::new(),
        pushes: PenetrationWorkspace::default(),
        tally: Tally::default(),
    };
    let mut slab = |size: [f32; 3], at: [f64; 3]| {
        let tree = solid(shapes::cuboid(size, 4));
        world.insert(&tree, RigidBody::fixed(at.into()));
    };
    slab([2.0, 2.0, 0.25], [0.0, 0.0, -0.25]);
    for side in [-1.75, 1.75] {
        slab([0.25, 2.0, 2.0], [side, 0.0, 2.0]);
        slab([1.5, 0.25, 2.0], [0.0, side, 2.0]);
    }
    let mut shapes = Vec::new();
    for mesh in meshes {
        let tree = solid(mesh);
        let mass = Mass::of(&tree)?;
        shapes.push((tree, mass));
    }
    for i in 0..BODIES {
        let [x, y, z] = [i % 3, i / 3 % 3, i / 9].map(|i| i as f64);
        let t = i as f64;
        let shift = 0.1 * DVec3::new((7.0 * t).sin(), (5.0 * t).sin(), (3.0 * t).sin());
        let place = 0.9 * DVec3::new(x - 1.0, y - 1.0, 0.7 + z) + shift;
        let axis = DVec3::new((2.0 * t).sin(), (3.0 * t).cos(), 0.5).normalize();
        let turn = DQuat::from_axis_angle(axis, t);
        let (tree, mass) = &shapes[i % shapes.len()];
        world.insert(
            tree,
            RigidBody::moving(mass, place + turn * mass.centre, turn),
        );
    }
    Ok(world)
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
        "{BODIES} bodies of each kind, {} s; after {} s none may be deeper than {} mm.",
        FRAMES as f64 * FRAME,
        SETTLED as f64 * FRAME,
        1e3 * DEEPEST
    )?;
    let mut failures = Vec::new();
    for (name, meshes) in all {
        let mut world = world(meshes).map_err(|error| format!("{name}: {error}"))?;
        let mut deepest = 0.0_f64;
        let pictured: &[usize] = match &*name {
            "crates" => &[20, 60, FRAMES - 1],
            _ => &[],
        };
        for frame in 0..FRAMES {
            if pictured.contains(&frame) {
                world.place()?;
                picture.add(
                    &world.trees,
                    &world.poses,
                    &format!("{:.1} s", frame as f64 * FRAME),
                );
            }
            world.frame()?;
            if frame >= SETTLED && frame % 30 == 0 {
                deepest = deepest.max(world.deepest()?);
            }
        }
        let (tally, speed) = (mem::take(&mut world.tally), world.speed());
        let milliseconds = |time: Duration| 1e3 * time.as_secs_f64();
        writeln!(
            out,
            "{name}: deepest overlap {:.3} mm, {} teleports, fastest point {speed:.4} m/s.\n  \
             {} points, {:.2} % of them known from the frame before; manifolds of a frame {:.1} ms, \
             at most {:.1}.",
            1e3 * deepest,
            tally.teleports,
            tally.points,
            100.0 * tally.known as f64 / tally.points as f64,
            milliseconds(tally.took) / FRAMES as f64,
            milliseconds(tally.slowest)
        )?;
        if deepest > DEEPEST || tally.teleports > 0 || speed > AT_REST {
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
