//! Boxes, a ball, a ring and gears fall on a floor, rest and stack: contacts for a solver.
//!
//! The library finds where bodies are close, and the normals that separate them. The small
//! [`solver`] keeps bodies a skin apart, so surfaces never meet and every normal is that of two
//! closest points. It takes the few points that stand for each patch, and starts from the impulses
//! that the patch with the same id had in the frame before. If bodies meet all the same, the
//! shortest push found separates them.
//!
//! `cargo run --release --example falling [-- --picture FILE.svg]`

#[path = "../common/mod.rs"]
mod common;
mod picture;
mod solver;

use std::collections::HashMap;
use std::error::Error;
use std::io::{StdoutLock, Write};
use std::time::Duration;
use std::{env, fs, mem};

use cpu_time::ThreadTime;
use picture::Picture;
use punctual::contacts::Patches;
use punctual::glam::{DQuat, DVec3, Vec3};
use punctual::{Budget, Mesh, MeshError, PoseError, Query, Tree, Workspace, shapes};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
use solver::{Body, Point, STEP};

const FRAMES: usize = 420;
/// Solver iterations a frame.
const ROUNDS: usize = 30;
/// Distance at which bodies rest. The edge of a box is 1.
const SKIN: f64 = 0.01;
/// Budget of one pair of bodies in one frame: more than any needs.
const BUDGET: Budget = Budget::work(10_000_000);

/// Counts over all frames.
#[derive(Default)]
struct Tally {
    queries: usize,
    contacts: u64,
    points: usize,
    /// How often bodies met, and the longest push.
    meetings: usize,
    deepest: f64,
    /// Processor time, without that of other programs.
    slowest: Duration,
    late: usize,
}

struct World {
    bodies: Vec<Body>,
    points: Vec<Point>,
    patches: HashMap<[usize; 2], Patches>,
    workspace: Workspace,
    pushes: PenetrationWorkspace,
    tally: Tally,
}

impl World {
    fn frame(&mut self) -> Result<(), PoseError> {
        let start = ThreadTime::now();
        self.bodies.iter_mut().for_each(Body::fall);
        let before = mem::take(&mut self.points);
        for a in 0..self.bodies.len() {
            for b in a + 1..self.bodies.len() {
                self.touch([a, b])?;
            }
        }
        for point in &mut self.points {
            if let Some(known) = before.iter().find(|known| point.is(known)) {
                point.start_from(known, &mut self.bodies);
            }
        }
        for _ in 0..ROUNDS {
            self.points
                .iter_mut()
                .for_each(|point| point.solve(&mut self.bodies));
        }
        self.bodies.iter_mut().for_each(Body::advance);
        self.tally.points += self.points.len();
        let took = start.elapsed();
        self.tally.slowest = self.tally.slowest.max(took);
        self.tally.late += usize::from(took.as_secs_f64() > STEP);
        Ok(())
    }

    /// Finds the points at which two bodies may touch within this frame.
    fn touch(&mut self, pair: [usize; 2]) -> Result<(), PoseError> {
        let [a, b] = pair.map(|i| &self.bodies[i]);
        let margin = 2.0 * SKIN + STEP * a.closing_speed(b);
        if a.is_far_from(b, margin) {
            return Ok(());
        }
        let mut nearest = self.look(pair, margin)?;
        if nearest == Some(0.0) && self.part(pair)? {
            nearest = self.look(pair, margin)?;
        }
        let Some(nearest) = nearest else {
            return Ok(());
        };
        let [a, b] = pair.map(|i| &self.bodies[i]);
        let pose = a.pose()?;
        let patches = self.patches.entry(pair).or_default();
        patches.update(&a.tree, &b.tree, self.workspace.contacts());
        for patch in patches.as_slice() {
            // The normal of the nearest contact separates convex pieces. Normals of triangles that
            // are not opposite to each other are aslant, so a point keeps its own normal only if
            // that points elsewhere.
            let straight = patches.contacts_of(patch)[0].normal;
            for contact in patches.points_of(patch) {
                let normal = if contact.normal.dot(straight) > 0.25 {
                    straight
                } else {
                    contact.normal
                };
                let gap = (contact.points[0] - contact.points[1])
                    .dot(normal)
                    .max(nearest);
                let places = contact.points.map(|point| pose.transform_point(point));
                let arms = [places[0] - a.position, places[1] - b.position];
                self.points.push(Point::new(
                    pair,
                    patch.id,
                    arms,
                    *pose.rotation() * normal,
                    gap - SKIN,
                ));
            }
        }
        Ok(())
    }

    /// Distance of two bodies, if it is within the margin.
    fn look(&mut self, pair: [usize; 2], margin: f64) -> Result<Option<f64>, PoseError> {
        let [a, b] = pair.map(|i| &self.bodies[i]);
        let query = Query::contacts(&a.tree, &b.tree, b.pose_in(a)?).margin(margin);
        self.tally.contacts += query.run(&mut self.workspace, BUDGET).stats.found;
        self.tally.queries += 1;
        Ok(self
            .workspace
            .contacts()
            .next()
            .map(|nearest| nearest.distance))
    }

    /// Moves the second body out of the first if they meet, and returns whether it did. The second
    /// one is never the floor.
    fn part(&mut self, pair: [usize; 2]) -> Result<bool, PoseError> {
        let [a, b] = pair.map(|i| &self.bodies[i]);
        let query = PenetrationQuery::new(&a.tree, &b.tree, b.pose_in(a)?).push_only(true);
        let found = query.run(&mut self.pushes, BUDGET).value;
        let Some(direction) = found.direction else {
            return Ok(false);
        };
        self.tally.meetings += 1;
        self.tally.deepest = self.tally.deepest.max(found.high);
        let way = a.turn * direction * (found.high + SKIN);
        self.bodies[pair[1]].position += way;
        Ok(true)
    }

    fn energy(&self) -> f64 {
        self.bodies.iter().map(Body::energy).sum()
    }

    /// Speed of the fastest point of any body.
    fn speed(&self) -> f64 {
        self.bodies.iter().map(Body::fastest).fold(0.0, f64::max)
    }
}

/// A floor, a pyramid of boxes, and the bodies that fall on it.
fn bodies() -> Result<Vec<Body>, MeshError> {
    let cube = || shapes::cuboid(Vec3::splat(0.5), 2);
    let sphere = shapes::icosphere(2);
    let vertices = (0..sphere.vertex_count()).map(|i| 0.5 * sphere.vertex(i));
    let ball = Mesh::from_f64(vertices, sphere.triangles().iter().copied())?;
    let at = |mesh: Mesh, x: f64, y: f64, z: f64, turn: f64| {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), turn);
        Body::new(Tree::new(mesh), DVec3::new(x, y, z), turn)
    };
    let floor = Tree::new(shapes::cuboid(Vec3::new(2.6, 2.6, 0.25), 6));
    let mut bodies = vec![Body::fixed(floor, DVec3::new(0.0, 0.0, -0.25))];
    for (x, z) in [
        (-1.06, 0.6),
        (0.0, 0.6),
        (1.06, 0.6),
        (-0.53, 1.8),
        (0.53, 1.8),
        (0.0, 3.0),
    ] {
        bodies.push(at(cube(), x, 0.4, z, 0.0));
    }
    bodies.extend([
        at(shapes::torus(0.55, 0.2, 20), -1.1, -1.2, 1.0, 0.4),
        at(shapes::gear(9, 1), 1.2, -1.2, 1.4, 0.5),
        at(shapes::gear(9, 1), 1.1, -1.3, 2.6, 1.0),
        at(
            shapes::cuboid(Vec3::new(0.25, 0.25, 0.5), 2),
            -1.1,
            -1.2,
            2.5,
            0.3,
        ),
        at(ball, 0.0, -0.4, 4.4, 0.0),
    ]);
    Ok(bodies)
}

fn run(out: &mut StdoutLock) -> Result<(), Box<dyn Error>> {
    let path = match &env::args().skip(1).collect::<Vec<_>>()[..] {
        [] => None,
        [option, path] if option == "--picture" => Some(path.clone()),
        _ => return Err("usage: falling [--picture FILE.svg]".into()),
    };
    let (patches, workspace, tally) = (HashMap::new(), Workspace::new(), Tally::default());
    let mut world = World {
        bodies: bodies()?,
        points: Vec::new(),
        patches,
        workspace,
        pushes: PenetrationWorkspace::new(),
        tally,
    };
    let mut picture = Picture::default();
    writeln!(out, "second   energy   speed of the fastest point")?;
    for frame in 0..=FRAMES {
        if frame % 60 == 0 {
            writeln!(
                out,
                "{:6} {:8.2} {:8.4}",
                frame / 60,
                world.energy(),
                world.speed()
            )?;
        }
        if [0, 50, FRAMES].contains(&frame) {
            picture.add(&world.bodies, &format!("{:.1} s", frame as f64 * STEP));
        }
        if frame < FRAMES {
            world.frame()?;
        }
    }
    if let Some(path) = path {
        fs::write(path, picture.svg())?;
    }
    let Tally {
        queries,
        contacts,
        points,
        meetings,
        deepest,
        slowest,
        late,
    } = world.tally;
    let [slowest, frame] = [slowest.as_secs_f64(), STEP].map(|time| 1e3 * time);
    writeln!(
        out,
        "{queries} queries found {contacts} contacts; {points} points stood for them."
    )?;
    writeln!(
        out,
        "Deepest overlap: {:.1} % of a box; {meetings} times in all, parted at once.",
        100.0 * deepest
    )?;
    writeln!(
        out,
        "{late} of {FRAMES} frames late; the slowest took {slowest:.1} of {frame:.1} ms of processor time."
    )?;
    if world.speed() > 0.01 {
        Err("the bodies did not come to rest".into())
    } else {
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(run)
}
