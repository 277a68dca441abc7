//! What `controller.c` and `../cpp/engine.cpp` must say: the same motions, asked in Rust.

use punctual::clock::ManualClock;
use punctual::glam::{DQuat, DVec3, Vec3};
use punctual::{Budget, Pose, PoseError, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, Scene};
use std::error::Error;
use std::sync::Arc;

/// From -1 to 1 and back, once as x grows by 1.
fn swing(x: f64) -> f64 {
    4.0 * (x - (x + 0.5).floor()).abs() - 1.0
}

const LINKS: usize = 3;

fn links(base: Pose, pace: f64, phase: f64) -> Result<Vec<Pose>, PoseError> {
    let along = |x| Pose::from_quat(DQuat::IDENTITY, DVec3::X * x);
    let mut frame = base;
    let mut links = Vec::new();
    for i in 0..LINKS {
        let t = 0.6 * swing(pace * phase + 0.17 * i as f64);
        let [y, z] = if i == 1 { [t, 0.0] } else { [0.0, t] };
        frame = frame.compose(&Pose::from_quat(
            DQuat::from_xyzw(0.0, y, z, 1.0),
            DVec3::ZERO,
        )?)?;
        links.push(frame.compose(&along(0.5)?)?);
        frame = frame.compose(&along(1.0)?)?;
    }
    Ok(links)
}

fn controller() -> Result<(), Box<dyn Error>> {
    let trees = [
        shapes::cuboid(Vec3::new(0.5, 0.1, 0.1), 16),
        shapes::torus_knot(2, 3, 0.1, 256),
        shapes::torus(0.4, 0.1, 96),
    ]
    .map(Tree::new);
    let opposite = Pose::from_quat(
        DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0),
        DVec3::new(3.4, 0.3, 0.1),
    )?;
    let mut workspace = Workspace::new();
    let mut memories: Vec<_> = (0..LINKS * LINKS)
        .map(|_| punctual::PairMemory::new())
        .collect();
    let (mut separated, mut undecided, mut intersecting) = (0, 0, 0);
    let (mut phase, mut speed, mut direction, mut last_met) = (0.0, 0.1, 1.0, false);
    for _ in 0..2000 {
        let (a, b) = (
            links(Pose::IDENTITY, 1.3, phase)?,
            links(opposite, 0.9, phase)?,
        );
        let (mut left, mut met, mut open) = (20_000, false, false);
        for (pair, memory) in memories.iter_mut().enumerate() {
            let (i, j) = (pair / LINKS, pair % LINKS);
            let query = Query::intersection(&trees[i], &trees[j], a[i].inverse()?.compose(&b[j])?);
            let share = Budget::work(left / (LINKS * LINKS - pair) as u64);
            let outcome = query
                .with_memory(memory)
                .run(&mut workspace, share.clock(&ManualClock::new()));
            left = left.saturating_sub(outcome.stats.work);
            open |= outcome.value == Verdict::Undecided;
            met |= !matches!(outcome.value, Verdict::Separated | Verdict::Undecided);
        }
        if met {
            intersecting += 1;
            direction *= if last_met { 1.0 } else { -1.0 };
            speed = 0.3;
        } else if open {
            undecided += 1;
            speed = 0.5 * speed + 0.01;
        } else {
            separated += 1;
            speed = f64::min(1.0, 1.05 * speed + 0.01);
        }
        last_met = met;
        phase += direction * speed * 0.001;
    }
    println!(
        "= controller: {separated} separated, {undecided} undecided, {intersecting} intersecting, phase {phase:.12}"
    );
    Ok(())
}

fn pose_of(body: usize, frame: u32) -> Result<Pose, PoseError> {
    let (time, own) = (f64::from(frame) / 60.0, 0.618 * body as f64);
    let place = DVec3::new(
        6.0 * swing(own + 0.05 * time),
        6.0 * swing(1.7 * own - 0.04 * time),
        1.0 + swing(own + 0.3 * time),
    );
    Pose::from_quat(
        DQuat::from_xyzw(swing(own + time), swing(2.0 * own), 0.5, 1.0),
        place,
    )
}

fn engine() -> Result<(), Box<dyn Error>> {
    let hills = shapes::height_field(32, 7);
    let rest: Vec<DVec3> = (0..hills.vertex_count()).map(|i| hills.vertex(i)).collect();
    let trees = [
        shapes::torus_knot(2, 3, 0.2, 96),
        shapes::gear(17, 4),
        shapes::icosphere(4),
    ]
    .map(|mesh| Arc::new(Tree::new(mesh)));
    let mut scene = Scene::new();
    let ground = scene.insert(Body::fixed(Arc::new(Tree::new(hills)), Pose::IDENTITY))?;
    let mut ids = Vec::new();
    for i in 0..60 {
        let body = Body::moving(Arc::clone(&trees[i % trees.len()]), pose_of(i, 0)?);
        ids.push(scene.insert(body.importance(if i == 0 { 1.0 } else { 0.0 }))?);
    }
    let (mut pairs, mut decided, mut intersecting, mut oldest, mut work) = (0, 0, 0, 0, 0);
    for frame in 0..60 {
        let wave = |v: &DVec3| {
            [
                7.0 * v.x,
                7.0 * v.y,
                v.z + 0.2 * swing(v.x + f64::from(frame) / 120.0),
            ]
            .map(|c| c as f32)
        };
        let vertices: Vec<[f32; 3]> = rest.iter().map(wave).collect();
        scene.tree_mut(ground)?.refit(&vertices)?;
        for (i, &id) in ids.iter().enumerate() {
            scene.set_pose(id, pose_of(i, frame)?)?;
        }
        let report = scene.detect(Budget::work(400_000).clock(&ManualClock::new()));
        pairs += report.pairs.len();
        decided += report.decided;
        intersecting += report.intersecting;
        oldest = oldest.max(report.worst_age);
        work += report.work;
    }
    println!(
        "= engine: {pairs} pairs, {decided} decided, {intersecting} intersecting, oldest {oldest}, work {work}"
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    controller()?;
    engine()
}
