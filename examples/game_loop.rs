//! A game loop: 240 moving bodies in a whirl around 24 fixed pillars above a landscape, 60 frames a
//! second, one millisecond of each for all collisions.
//!
//! The player and its neighbours have the highest priority. A second scene without a budget counts
//! the pairs of bodies that really touch. For every tenth frame the table shows the share of the
//! contacts that was reported, and the share of the pairs with overlapping boxes that was decided.
//! The last lines tell what that gains over the simplest rival: a plain loop over the pairs, one
//! query after another, which stops after the same time.
//! Times are processor times, so that the lateness of the library stands apart from the time that
//! other programs took.

mod common;

use std::error::Error;
use std::f64::consts::TAU;
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Budget, Pose, PoseError, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, BodyId, BodyKind, PairReport, Scene, SceneError};

const BODIES: usize = 240;
const FRAMES: usize = 120;
const BUDGET: Duration = Duration::from_millis(1);
/// Budgets at which the scene is compared with a plain loop.
const BUDGETS: [u64; 4] = [100, 250, 500, 1000];

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
        bodies.push(Body::fixed(
            Arc::clone(&pillar),
            at(9.0 * angle.cos(), 9.0 * angle.sin(), 2.0)?,
        ));
    }
    for i in 0..BODIES {
        let body = Body::moving(Arc::clone(&shapes[i % shapes.len()]), pose(i, 0)?);
        bodies.push(body.importance(if i == 0 { 1.0 } else { 0.0 }));
    }
    Ok(bodies)
}

/// The pose of a body: on a ring of the whirl, rising and sinking, turning about its own axis.
fn pose(body: usize, frame: usize) -> Result<Pose, PoseError> {
    let (time, body) = (frame as f64 / 60.0, body as f64);
    let ring = 4.0 + 22.0 * (0.618 * body).fract();
    let angle = 2.4 * body + 6.0 * time / ring;
    let height = 2.5 + 2.0 * (0.7 * body + time).sin();
    let turn =
        DMat3::from_rotation_z(body + 2.0 * time) * DMat3::from_rotation_x(0.3 * body * time);
    Pose::new(
        turn,
        DVec3::new(ring * angle.cos(), ring * angle.sin(), height),
    )
}

fn insert_all(scene: &mut Scene, bodies: &[Body]) -> Result<Vec<BodyId>, SceneError> {
    bodies
        .iter()
        .map(|body| scene.insert(body.clone()))
        .collect()
}

/// Counts and times of one frame, or sums over all frames.
#[derive(Default)]
struct Counts {
    contacts: usize,
    found: usize,
    pairs: usize,
    decided: usize,
    wrong: usize,
    /// Processor time with the budget and without, and the time that other programs took while the
    /// budget ran.
    used: Duration,
    unhurried: Duration,
    taken: Duration,
}

impl Counts {
    fn add(&mut self, frame: &Self) {
        self.contacts += frame.contacts;
        self.found += frame.found;
        self.pairs += frame.pairs;
        self.decided += frame.decided;
        self.wrong += frame.wrong;
        self.used += frame.used;
        self.unhurried += frame.unhurried;
        self.taken += frame.taken;
    }

    /// Percent of the contacts that were reported, and of the pairs that were decided.
    fn shares(&self) -> [f64; 2] {
        [[self.found, self.contacts], [self.decided, self.pairs]]
            .map(|[part, all]| 100.0 * part as f64 / all as f64)
    }
}

/// A plain loop: the boxes of all bodies against each other, and one query after another where they
/// overlap, until the time is up. Returns the number of contacts that it reports.
fn plain_loop(
    scene: &Scene,
    workspace: &mut Workspace,
    budget: Duration,
) -> Result<usize, Box<dyn Error>> {
    let (start, mut found) = (ThreadTime::now(), 0);
    let bodies = scene.bodies().map(|(_, body)| body);
    let bodies: Vec<_> = bodies
        .map(|body| (body, body.tree.aabb_at(&body.pose)))
        .collect();
    for (index, (a, box_a)) in bodies.iter().enumerate() {
        for (b, box_b) in &bodies[..index] {
            let are_fixed = a.kind == BodyKind::Fixed && b.kind == BodyKind::Fixed;
            if are_fixed || !box_a.intersects(box_b) {
                continue;
            }
            let left = budget.saturating_sub(start.elapsed());
            let b_in_a = a.pose.inverse()?.compose(&b.pose)?;
            let query = Query::intersection(&a.tree, &b.tree, b_in_a);
            match query.run(workspace, Budget::time(left)).value {
                Verdict::Undecided => return Ok(found),
                verdict => found += usize::from(verdict.meets()),
            }
        }
    }
    Ok(found)
}

/// Plays all frames within each budget and within none, beside a plain loop. `contacts`: the number
/// of those that there are.
fn against_a_plain_loop(
    out: &mut impl Write,
    bodies: &[Body],
    contacts: usize,
) -> Result<(), Box<dyn Error>> {
    writeln!(
        out,
        "\nThe share of the contacts, and the time of a frame, of"
    )?;
    writeln!(out, "  budget          the scene           a plain loop")?;
    let mut workspace = Workspace::new();
    let budgets = BUDGETS.map(|budget| Some(Duration::from_micros(budget)));
    for budget in budgets.into_iter().chain([None]) {
        let mut scene = Scene::new();
        let ids = insert_all(&mut scene, bodies)?;
        let moving = ids.iter().skip(ids.len() - BODIES);
        let (mut found, mut used) = ([0; 2], [Duration::ZERO; 2]);
        for frame in 0..FRAMES {
            for (body, &id) in moving.clone().enumerate() {
                scene.set_pose(id, pose(body, frame)?)?;
            }
            let start = ThreadTime::now();
            found[0] += scene
                .detect(budget.map_or(Budget::unlimited(), Budget::time))
                .intersecting;
            used[0] += start.elapsed();
            let start = ThreadTime::now();
            found[1] += plain_loop(&scene, &mut workspace, budget.unwrap_or(Duration::MAX))?;
            used[1] += start.elapsed();
        }
        let budget = budget.map_or("none".into(), |budget| format!("{budget:?}"));
        write!(out, "{budget:>8}")?;
        for (found, used) in found.into_iter().zip(used) {
            let share = 100.0 * found as f64 / contacts as f64;
            let used = 1e6 * used.as_secs_f64() / FRAMES as f64;
            write!(out, "     {share:>4.0} % {used:>6.0} us")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Plays one frame of both scenes.
fn compare(scene: &mut Scene, unhurried: &mut Scene) -> Counts {
    let start = ThreadTime::now();
    let report = scene.detect(Budget::time(BUDGET));
    let used = start.elapsed();
    let start = ThreadTime::now();
    let truth = unhurried.detect(Budget::unlimited());
    let touch = |verdict| matches!(verdict, Verdict::Intersecting { .. });
    // A frame that other programs cut short lists fewer pairs.
    let decided = report
        .pairs
        .iter()
        .filter(|pair| pair.verdict != Verdict::Undecided);
    let truly_touch = |pair: &PairReport| {
        truth
            .pair(pair.a, pair.b)
            .is_some_and(|pair| touch(pair.verdict))
    };
    let wrong = decided.filter(|pair| touch(pair.verdict) != truly_touch(pair));
    Counts {
        contacts: truth.intersecting,
        found: report.intersecting,
        pairs: truth.pairs.len(),
        decided: report.decided,
        wrong: wrong.count(),
        used,
        unhurried: start.elapsed(),
        taken: report.elapsed.unwrap_or_default().saturating_sub(used),
    }
}

fn play(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let bodies = bodies()?;
    let (mut scene, mut unhurried) = (Scene::new(), Scene::new());
    let ids = insert_all(&mut scene, &bodies)?;
    let unhurried_ids = insert_all(&mut unhurried, &bodies)?;
    let moving = ids.iter().zip(&unhurried_ids).skip(ids.len() - BODIES);
    writeln!(
        out,
        "{} bodies, and {BUDGET:?} of each frame to find out which of them touch",
        ids.len()
    )?;
    writeln!(
        out,
        "       contacts           pairs              processor time, us      taken by"
    )?;
    writeln!(
        out,
        "frame   true reported       all  decided     used  past the budget  others, us"
    )?;
    let (mut total, mut late, mut oldest) = (Counts::default(), Vec::new(), 0);
    for frame in 0..FRAMES {
        for (body, (&id, &same)) in moving.clone().enumerate() {
            let pose = pose(body, frame)?;
            scene.set_pose(id, pose)?;
            unhurried.set_pose(same, pose)?;
        }
        let now = compare(&mut scene, &mut unhurried);
        total.add(&now);
        late.push(now.used.saturating_sub(BUDGET));
        oldest = oldest.max(scene.report().worst_age);
        if frame % 10 == 0 {
            let ([found, decided], (contacts, pairs)) = (now.shares(), (now.contacts, now.pairs));
            let [used, late, lost] =
                [now.used, late[frame], now.taken].map(|time| 1e6 * time.as_secs_f64());
            write!(
                out,
                "{frame:>5} {contacts:>6} {found:>6.0} % {pairs:>9} {decided:>6.0} %"
            )?;
            writeln!(out, " {used:>8.0} {late:>16.1} {lost:>11.0}")?;
        }
    }
    late.sort_unstable();
    let [most, worst] = [late[FRAMES * 9 / 10], late[FRAMES - 1]];
    let [used, whole] = [total.used, total.unhurried].map(|time| time / FRAMES as u32);
    let (
        [found, decided],
        Counts {
            contacts,
            decided: answers,
            wrong,
            taken,
            ..
        },
    ) = (total.shares(), total);
    writeln!(
        out,
        "\nA frame took {used:.2?} of processor time, {whole:.2?} if every pair is decided; other programs took {taken:.1?} in all."
    )?;
    writeln!(
        out,
        "It passed its budget by at most {most:.1?} in nine of ten frames, by {worst:.1?} in the worst."
    )?;
    writeln!(
        out,
        "In time it reported {found:.0} % of the contacts and decided {decided:.0} % of the pairs; none waited more than {oldest} frames."
    )?;
    writeln!(
        out,
        "{wrong} of its {answers} answers were wrong: what it had no time for, it called undecided."
    )?;
    against_a_plain_loop(out, &bodies, contacts)?;
    assert_eq!(wrong, 0);
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(play)
}
