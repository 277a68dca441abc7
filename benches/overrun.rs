//! How late a time budget ends, in CPU time of the thread: `cargo bench -p punctual-benches --bench overrun -- [CALLS] [FOLDER..]` (default 20,000
//! calls; fewer with the longer budgets).
//!
//! Queries and scenes that need more than their budget, deadlines by the system's clock, measured by the CPU clock of the
//! thread, so that what other programs take does not count; interrupts do. Beside each call, for as long, a loop that does
//! nothing but look at the system's clock. Both figures have one look at the CPU clock in them, a system call. A folder is one
//! of the bench `motion`: its distances and motions are asked with short budgets. Run something on the other cores when
//! measuring.

#[path = "../examples/controller/arms.rs"]
mod arms;
mod case;

use std::sync::Arc;
use std::time::Duration;

use arms::Arms;
use case::Case;
use cpu_time::ThreadTime;
use oorandom::Rand64;
use punctual::clock::SystemClock;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Budget, Clock, Mesh, Mode, Pose, Query, StopReason, Tree, Workspace, shapes};
use punctual_scene::{Body, BodyId, Scene};

/// Quantiles of times, microseconds.
fn row(name: &str, mut times: Vec<Duration>) {
    times.sort_unstable();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e6;
    let [half, ninety, most, nearly_all, all] = [0.5, 0.9, 0.99, 0.999, 1.0].map(at);
    println!("{name:<44} {half:>8.2} {ninety:>8.2} {most:>8.2} {nearly_all:>8.2} {all:>8.2}");
}

/// A result, and the CPU time that it took.
fn timed<R>(call: impl FnOnce() -> R) -> (R, Duration) {
    let start = ThreadTime::now();
    let result = call();
    (result, start.elapsed())
}

/// CPU time past the budget of `call`, which returns whether the budget ended it and how long it took, and of an idle
/// loop of the same length.
fn measure(
    name: &str,
    calls: usize,
    budget: Duration,
    mut call: impl FnMut(usize) -> (bool, Duration),
) {
    let (mut late, mut idle) = (Vec::with_capacity(calls), Vec::with_capacity(calls));
    for number in 0..calls {
        let (stopped, elapsed) = call(number);
        if !stopped {
            continue;
        }
        late.push(elapsed.saturating_sub(budget));
        let (start, clock) = (ThreadTime::now(), SystemClock::default());
        let end = clock.now() + budget;
        while clock.now() < end {}
        idle.push(start.elapsed().saturating_sub(budget));
    }
    println!("{} of {calls} calls used their budget", late.len());
    if late.is_empty() {
        return;
    }
    row(&format!("{name}, past {budget:?}"), late);
    row("  idle loop", idle);
}

/// All pairs of two knots, at turns of their own.
fn knots(calls: usize) {
    let mut workspace = Workspace::new();
    for resolution in [128, 512] {
        let knot = Tree::new(shapes::torus_knot(2, 3, 0.2, resolution));
        for (micros, calls) in [(20, calls), (200, calls / 10)] {
            let (name, budget) = (
                format!("{} triangles a side", knot.mesh().len()),
                Duration::from_micros(micros),
            );
            measure(&name, calls, budget, |number| {
                let query = Query::all_pairs(&knot, &knot, turned(number));
                timed(|| {
                    query.run(&mut workspace, Budget::time(budget)).stop == StopReason::Deadline
                })
            });
        }
    }
}

fn turned(number: usize) -> Pose {
    let turn = DMat3::from_rotation_x(0.2 + 0.001 * (number % 2500) as f64);
    Pose::new(turn, DVec3::ZERO).expect("a rotation")
}

/// Distances and motions.
fn far_and_free(case: &Case, calls: usize) {
    let ([a, b], motions) = (&case.trees, case.motions());
    let mut workspace = Workspace::new();
    for micros in [5, 20] {
        let budget = Duration::from_micros(micros);
        measure(
            &format!("{}, distances", case.name),
            calls,
            budget,
            |number| {
                let query = Query::distance(a, b, case.poses[number % case.poses.len()]);
                timed(|| {
                    query.run(&mut workspace, Budget::time(budget)).stop == StopReason::Deadline
                })
            },
        );
        measure(
            &format!("{}, motions", case.name),
            calls,
            budget,
            |number| {
                let query = Query::impact(a, b, motions[number % motions.len()]);
                timed(|| {
                    query.run(&mut workspace, Budget::time(budget)).stop == StopReason::Deadline
                })
            },
        );
    }
}

/// All pairs of two bodies in a scene: large knots, and two tessellations of a plane, tilted in single precision.
fn scenes_of_two(calls: usize) {
    let knot = || Tree::new(shapes::torus_knot(2, 3, 0.2, 512));
    let tilt = tilt();
    let plane = |cells| {
        let mesh = shapes::height_field(cells, 3);
        let vertices =
            (0..mesh.vertex_count()).map(|i| (tilt * mesh.vertex(i).with_z(0.0)).as_vec3());
        Tree::new(Mesh::new(vertices, mesh.triangles().iter().copied()).expect("a sound mesh"))
    };
    let planes = [plane(96), plane(80)];
    let of_two = [
        (
            "two knots in a scene",
            [knot(), knot()],
            200,
            turned as fn(usize) -> Pose,
        ),
        ("two planes in a scene", planes, 1000, shifted),
    ];
    for (name, trees, micros, pose) in of_two {
        let mut scene = Scene::new();
        scene.set_mode(Mode::All);
        let [a, b] = trees.map(Arc::new);
        let bodies = [
            Body::fixed(a, Pose::IDENTITY),
            Body::moving(b, Pose::IDENTITY),
        ];
        let [_, moving] = bodies.map(|body| scene.insert(body).expect("a sound body"));
        let budget = Duration::from_micros(micros);
        measure(name, calls, budget, |number| {
            let (report, took) = timed(|| scene.detect(Budget::time(budget)));
            let stopped = report.complete < report.pairs.len();
            scene.set_pose(moving, pose(number)).expect("a moving body");
            (stopped, took)
        });
    }
}

fn tilt() -> DQuat {
    DQuat::from_rotation_x(0.3) * DQuat::from_rotation_y(0.7)
}

fn shifted(number: usize) -> Pose {
    let shift = tilt() * DVec3::X * (1e-4 * (number % 1000) as f64);
    Pose::new(DMat3::IDENTITY, shift).expect("a pose")
}

fn arms_at_work(calls: usize) {
    let mut arms = Arms::new().expect("sound meshes");
    let budget = Duration::from_micros(5);
    measure("two arms", calls, budget, |number| {
        let (undecided, took) = timed(|| arms.scene.detect(Budget::time(budget)).undecided());
        arms.place(0.01 * (number % 1000) as f64)
            .expect("sound poses");
        (undecided > 0, took)
    });
}

/// Scenes of many knots that move: what is asked of them, and how many and how dense they are.
fn crowds(calls: usize) {
    let knot = Arc::new(Tree::new(shapes::torus_knot(2, 3, 0.2, 24)));
    type Ask = fn(&mut Scene, &[BodyId]);
    let groups: Ask = |scene, ids| {
        let teams: Vec<_> = ids.chunks(8).collect();
        for (i, a) in teams.iter().enumerate() {
            for b in &teams[..i] {
                scene.measure_groups(a, b, 1e-3).expect("sound bodies");
            }
        }
    };
    let halves: Ask = |scene, ids| {
        let [a, b] = [&ids[..949], &ids[949..]];
        scene.measure_groups(a, b, 1e-3).expect("sound bodies");
    };
    let crowds: [(&str, usize, f64, Ask); 5] = [
        ("1,000 knots", 1_000, 14.0, |_, _| ()),
        ("contacts of 1,000 knots", 1_000, 14.0, |scene, _| {
            scene.find_contacts()
        }),
        ("120 pairs of groups", 128, 12.0, groups),
        ("groups of 900,000 pairs", 1_898, 30.0, halves),
        ("50,000 knots", 50_000, 80.0, |_, _| ()),
    ];
    for (name, count, side, ask) in crowds {
        for micros in [100, 300, 1_000] {
            let mut random = Rand64::new(1);
            let mut vector =
                |scale: f64| scale * DVec3::from_array([(); 3].map(|()| random.rand_float()));
            let mut scene = Scene::new();
            scene.reserve(count, 20 * count);
            let ids: Vec<_> = (0..count)
                .map(|_| {
                    let body = Body::moving(Arc::clone(&knot), at(vector(side)));
                    scene.insert(body.margin(0.02)).expect("a sound body")
                })
                .collect();
            ask(&mut scene, &ids);
            let budget = Duration::from_micros(micros);
            let calls = if count > 10_000 { calls / 4 } else { calls };
            measure(name, calls, budget, |_| {
                let (report, took) = timed(|| scene.detect(Budget::time(budget)));
                let stopped = !report.is_whole() || report.complete < report.pairs.len();
                for &id in &ids {
                    let place = scene.body(id).expect("a body").pose.translation();
                    let pose = at(place + vector(0.06) - DVec3::splat(0.03));
                    scene.set_pose(id, pose).expect("a moving body");
                }
                (stopped, took)
            });
        }
    }
}

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).expect("a pose")
}

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let calls = arguments
        .iter()
        .find_map(|argument| argument.parse().ok())
        .unwrap_or(20_000);
    let clock = ThreadTime::now();
    let mut looks: Vec<Duration> = (0..1000).map(|_| clock.elapsed()).collect();
    looks = looks.windows(2).map(|two| two[1] - two[0]).collect();
    println!(
        "{:<44} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "microseconds", "p50", "p90", "p99", "p99.9", "max"
    );
    row("one look at the CPU clock", looks);

    knots(calls);
    scenes_of_two(calls / 20);
    arms_at_work(calls);
    crowds(calls / 40);
    far_and_free(&Case::ball_and_knot(), calls);
    for folder in arguments
        .iter()
        .filter(|argument| argument.parse::<usize>().is_err())
    {
        far_and_free(&Case::read(folder), calls);
    }
}
