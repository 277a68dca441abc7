//! A game loop: 240 moving bodies in a whirl around 24 fixed pillars above a landscape, 60 frames a second, one millisecond
//! of each for all collisions.
//!
//! A player and what comes near matter most. Each frame prints a bar for the part of the budget that it used (40 characters),
//! its verdicts, and how long the longest waiting pair is undecided. In the end every verdict has been compared with a second
//! scene that had all the time it wanted.

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Duration;

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Body, BodyId, Budget, Pose, PoseError, Report, Scene, SceneError, Tree, Verdict, shapes};

const BODIES: usize = 240;
const FRAMES: usize = 120;
const BUDGET: Duration = Duration::from_millis(1);

/// The landscape, the pillars, then the bodies.
fn bodies() -> Result<Vec<Body>, PoseError> {
    let tree = |mesh| Arc::new(Tree::new(mesh));
    let ground = tree(shapes::height_field(48, 7));
    let pillar = tree(shapes::cuboid(Vec3::new(0.3, 0.3, 4.0), 8));
    let shapes = [
        tree(shapes::torus_knot(2, 3, 0.2, 96)),
        tree(shapes::gear(17, 4)),
        tree(shapes::icosphere(4)),
        tree(shapes::torus(0.9, 0.25, 48)),
        tree(shapes::cuboid(Vec3::new(0.8, 0.5, 0.3), 12)),
    ];
    let at = |x: f64, y: f64, z: f64| Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z));
    let mut bodies = vec![Body::fixed(ground, at(0.0, 0.0, -1.5)?)];
    for i in 0..24 {
        let angle = TAU * f64::from(i) / 24.0;
        bodies.push(Body::fixed(Arc::clone(&pillar), at(9.0 * angle.cos(), 9.0 * angle.sin(), 2.0)?));
    }
    for i in 0..BODIES {
        let body = Body::moving(Arc::clone(&shapes[i % shapes.len()]), pose(i, 0)?);
        bodies.push(body.importance(if i == 0 { 1.0 } else { 0.0 }));
    }
    Ok(bodies)
}

/// Each body follows a ring of the whirl, rising and sinking, and turns about its own axis.
fn pose(body: usize, frame: usize) -> Result<Pose, PoseError> {
    let (time, body) = (frame as f64 / 60.0, body as f64);
    let ring = 4.0 + 22.0 * (0.618 * body).fract();
    let angle = 2.4 * body + 6.0 * time / ring;
    let height = 2.5 + 2.0 * (0.7 * body + time).sin();
    let turn = DMat3::from_rotation_z(body + 2.0 * time) * DMat3::from_rotation_x(0.3 * body * time);
    Pose::new(turn, DVec3::new(ring * angle.cos(), ring * angle.sin(), height))
}

fn insert_all(scene: &mut Scene, bodies: &[Body]) -> Result<Vec<BodyId>, SceneError> {
    bodies.iter().map(|body| scene.insert(body.clone())).collect()
}

/// Decided pairs of `report` that `truth` contradicts. Both list the same pairs.
fn wrong(report: &Report, truth: &Report) -> usize {
    let hit = |verdict| matches!(verdict, Verdict::Intersecting { .. });
    let both = report.pairs.iter().zip(&truth.pairs);
    both.filter(|(x, y)| x.verdict != Verdict::Undecided && hit(x.verdict) != hit(y.verdict)).count()
}

fn main() -> Result<(), Box<dyn Error>> {
    let bodies = bodies()?;
    let (mut scene, mut unhurried) = (Scene::new(), Scene::new());
    let ids = insert_all(&mut scene, &bodies)?;
    insert_all(&mut unhurried, &bodies)?;
    let moving = &ids[ids.len() - BODIES..];
    let (mut late, mut mistakes, mut decided, mut asked) = (0, 0, 0, 0);
    println!("{:<48} pairs  meet  apart  undecided  oldest", format!("{} bodies, {BUDGET:?} a frame", ids.len()));
    for frame in 0..FRAMES {
        for (body, &id) in moving.iter().enumerate() {
            let pose = pose(body, frame)?;
            scene.set_pose(id, pose)?;
            unhurried.set_pose(id, pose)?;
        }
        let report = scene.detect(Budget::time(BUDGET));
        let used = report.elapsed.unwrap_or_default().as_secs_f64() / BUDGET.as_secs_f64();
        let bar = "#".repeat((40.0 * used).round().min(40.0) as usize);
        let (pairs, meet, undecided) = (report.pairs.len(), report.intersecting, report.undecided());
        let apart = report.decided - meet;
        let percent = 100.0 * used;
        println!("{bar:40} {percent:>5.1} % {pairs:>6} {meet:>5} {apart:>6} {undecided:>10} {:>7}", report.worst_age);
        late += usize::from(used > 1.0);
        (decided, asked) = (decided + report.decided, asked + pairs);
        mistakes += wrong(report, unhurried.detect(Budget::unlimited()));
    }
    println!(
        "{decided} of {asked} verdicts in time; {late} of {FRAMES} frames late; verdicts that were wrong: {mistakes}."
    );
    assert_eq!(mistakes, 0);
    Ok(())
}
