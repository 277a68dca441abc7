//! What is told of the work left: in one call for every question, and pair by pair with a memory.

mod common;

use std::time::Duration;

use common::random::Random;
use punctual::clock::ManualClock;
use punctual::engine::{Ask, Question};
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::{Quantiles, Remaining};
use punctual::rays::RayMode;
use punctual::tree::Solid;
use punctual::{
    Budget, BuildOptions, Mode, Motion, PairMemory, Pose, Query, Ray, StopReason, Tree, Workspace,
    shapes,
};

fn trees() -> [Tree; 2] {
    let solid = BuildOptions::default().solid(Solid::Keep);
    [shapes::icosphere(4), shapes::torus(1.0, 0.3, 64)].map(|mesh| Tree::with_options(mesh, &solid))
}

fn at(x: f64) -> Pose {
    Pose::new(DMat3::from_rotation_z(0.7), DVec3::new(x, 0.1, 0.2)).unwrap()
}

#[track_caller]
fn is_told(left: &Remaining) {
    for Quantiles { p10, p50, p90 } in [left.work, left.time] {
        assert!(
            0.0 < p10 && p10 <= p50 && p50 <= p90 && p90.is_finite(),
            "{left:?}"
        );
    }
}

/// Stops a query again and again, asks what is left, and compares with what came.
fn stopped<'t, Q: Question>(query: &Query<'t, Q>, other: &Query<'t, Q>, tells_probability: bool)
where
    Query<'t, Q>: Ask<Q>,
{
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let whole = query.run(&mut workspace, Budget::unlimited().clock(&clock));
    let end = query.remaining(&workspace, None).unwrap();
    assert_eq!(
        (end.work, end.time),
        (Quantiles::default(), Quantiles::default()),
        "nothing is left of a finished run"
    );
    assert!(other.remaining(&workspace, None).is_err());
    assert!(query.remaining(&Workspace::new(), None).is_err());
    let (mut covered, mut stops) = (0, 0);
    for share in 0..20 {
        let budget = Budget::work(whole.stats.work * share / 20);
        let answer = query.run(&mut workspace, budget.clock(&clock));
        if answer.stop != StopReason::WorkLimit {
            continue;
        }
        let left = query.remaining(&workspace, None).unwrap();
        is_told(&left);
        assert_eq!(left.probability.is_some(), tells_probability);
        assert_eq!(query.remaining(&workspace, None).unwrap(), left);
        let unit = left.time.p50 / left.work.p50;
        assert!((unit / workspace.cost_model().bv_test - 1.0).abs() < 1e-9);
        stops += 1;
        let actual = (whole.stats.work - answer.stats.work) as f64;
        covered += usize::from(actual <= 2.0 * left.work.p90);
    }
    assert!(stops >= 10 && 10 * covered >= 7 * stops, "{covered}");
}

#[test]
fn every_question_tells_what_is_left_of_it_in_the_same_call() {
    let [a, b] = trees();
    let (near, far) = (at(1.2), at(2.6));
    for mode in [Mode::Any, Mode::All] {
        // A hit would end the search for any.
        let pose = if mode == Mode::Any { at(1.98) } else { near };
        let [query, other] = [pose, far].map(|pose| Query::intersection(&a, &b, pose).mode(mode));
        stopped(&query, &other, true);
    }
    let [query, other] = [far, near].map(|pose| Query::distance(&a, &b, pose));
    stopped(&query, &other, false);
    stopped(&query.closer_than(0.5), &other, false);
    for margin in [0.0, 0.05] {
        let [query, other] = [near, far].map(|pose| Query::contacts(&a, &b, pose).margin(margin));
        stopped(&query, &other, false);
        let [query, other] = [near, far].map(|pose| Query::manifolds(&a, &b, pose).skin(margin));
        stopped(&query, &other, false);
    }
    let [query, other] = [1.0, 2.0].map(|way| {
        let motion = Motion::straight(at(4.0), [-2.0 * way, 0.0, 0.0]).unwrap();
        Query::impact(&a, &b, motion)
    });
    stopped(&query, &other, false);
    let mut random = Random::new(5);
    let mut point = || (1.3 * random.vector()).to_array();
    let rays: Vec<Ray> = (0..60)
        .map(|_| Ray::new(point().map(|x| 5.0 * x), point()).unwrap())
        .collect();
    stopped(&Query::rays(&b, &rays), &Query::rays(&b, &rays[1..]), false);
    let through = Ray::new([-3.0, 0.01, 0.02], [1.0, 0.0, 0.0]).unwrap();
    let [query, other] = [through, rays[0]].map(|ray| Query::ray(&b, ray).mode(RayMode::All));
    stopped(&query, &other, false);
    let points: Vec<[f64; 3]> = (0..60).map(|_| point()).collect();
    let others = &points[1..];
    let asked = |points| Query::windings(&b, points).unwrap();
    stopped(&asked(&points), &asked(others), false);
    let asked = |points| Query::signed_distances(&b, points).unwrap();
    stopped(&asked(&points), &asked(others), false);
    let asked = |point| Query::signed_distance(&b, point).unwrap();
    stopped(&asked(points[0]), &asked(points[1]), false);
}

/// Once all pairs are listed, the frontier holds what rays enter, which are no pairs of nodes.
#[test]
fn manifolds_tell_what_is_left_wherever_they_are_stopped() {
    let mesh = || shapes::torus_knot(2, 3, 0.2, 96);
    let (a, b) = (Tree::new(mesh()), Tree::new(mesh()));
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let query = Query::manifolds(&a, &b, at(0.4)).skin(0.01);
    let whole = query.run(&mut workspace, Budget::unlimited().clock(&clock));
    let mut answer = query.run(&mut workspace, Budget::work(0).clock(&clock));
    let mut stops = 0;
    while answer.stop == StopReason::WorkLimit {
        is_told(&query.remaining(&workspace, None).unwrap());
        stops += 1;
        let budget = Budget::work(whole.stats.work / 500);
        answer = query.resume(&mut workspace, budget.clock(&clock)).unwrap();
    }
    assert!(stops > 200, "{stops}");
}

#[test]
fn time_left_goes_by_the_pace_of_the_run() {
    let [a, b] = trees();
    let (mut workspace, clock) = (
        Workspace::new(),
        ManualClock::ticking(Duration::from_nanos(500)),
    );
    let query = Query::all_pairs(&a, &b, at(1.2));
    let budget = Budget::time(Duration::from_micros(9));
    let answer = query.run(&mut workspace, budget.clock(&clock));
    let left = query.remaining(&workspace, None).unwrap();
    assert_eq!(answer.stop, StopReason::Deadline);
    let elapsed = answer.stats.elapsed.unwrap().as_nanos() as f64;
    let pace = elapsed / answer.stats.work as f64;
    assert_eq!(left.time, left.work.map(|work| work * pace));
}

/// Shares of the queries of a pair that took no more than told, in the worst window of 50 after
/// the first ten: told before the query, and when it was stopped.
fn worst_windows(covered: &[[bool; 2]]) -> [f64; 2] {
    [0, 1].map(|which| {
        let share = |window: &[[bool; 2]]| {
            window.iter().filter(|query| query[which]).count() as f64 / window.len() as f64
        };
        covered[10..].windows(50).map(share).fold(1.0, f64::min)
    })
}

/// Flush plates take many times the work that the model expects.
#[test]
fn after_ten_queries_of_a_pair_what_is_told_holds_for_this_pair() {
    let plate = || Tree::new(shapes::cuboid([1.0, 0.5, 0.05], 20));
    let knot = || Tree::new(shapes::torus_knot(2, 3, 0.1, 256));
    let flush = |random: &mut Random| {
        let way = DVec3::new(0.3, 0.2, 0.0) * random.vector() + DVec3::Z * 0.1;
        Pose::new(DMat3::IDENTITY, way).unwrap()
    };
    let anywhere =
        |random: &mut Random| Pose::new(random.rotation(), 1.5 * random.vector()).unwrap();
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let poses: [&dyn Fn(&mut Random) -> Pose; 2] = [&flush, &anywhere];
    let pairs = [[plate(), plate()], [knot(), knot()]];
    for ([a, b], pose) in pairs.iter().zip(poses) {
        let mut covered: [Vec<[bool; 2]>; 4] = Default::default();
        let mut memories: [PairMemory; 4] = Default::default();
        let mut random = Random::new(8);
        for _ in 0..110 {
            let pose = pose(&mut random);
            for (k, mode) in [Mode::Any, Mode::All].into_iter().enumerate() {
                let query = Query::intersection(a, b, pose).mode(mode);
                let told = query.predict(Some(&memories[k])).bv_tests.p90;
                let (left, used, total) = cut(&query, &mut memories[k], &mut workspace, &clock);
                covered[k].push([total.1 <= told, total.0 - used <= left]);
            }
            let query = Query::distance(a, b, pose);
            let told = query.predict(Some(&memories[2])).p90;
            let (left, used, total) = cut(&query, &mut memories[2], &mut workspace, &clock);
            covered[2].push([total.0 <= told, total.0 - used <= left]);
            let motion = Motion::straight(pose, [0.2, 0.1, 0.3]).unwrap();
            let query = Query::impact(a, b, motion);
            let told = query.predict(Some(&memories[3])).p90;
            let (left, used, total) = cut(&query, &mut memories[3], &mut workspace, &clock);
            covered[3].push([total.0 <= told, total.0 - used <= left]);
        }
        for (covered, name) in covered.iter().zip(["any", "all", "distance", "impact"]) {
            let worst = worst_windows(covered);
            println!("{name}: {worst:?}");
            assert!(worst.iter().all(|&share| share >= 0.8), "{name}: {worst:?}");
        }
    }
}

/// Runs a query with a memory, stopped once. Returns the 90 % quantile of the work left then, the
/// work done then, and the whole work and BV tests.
fn cut<'t, Q: Question + punctual::engine::Remembers>(
    query: &Query<'t, Q>,
    memory: &mut PairMemory,
    workspace: &mut Workspace,
    clock: &ManualClock,
) -> (f64, f64, (f64, f64))
where
    Query<'t, Q>: Ask<Q>,
{
    let mut answer = query
        .with_memory(&mut *memory)
        .run(workspace, Budget::work(1500).clock(clock));
    let used = answer.stats.work as f64;
    let left = query.remaining(workspace, Some(memory)).unwrap().work.p90;
    if answer.stop == StopReason::WorkLimit {
        let budget = Budget::unlimited().clock(clock);
        answer = query.with_memory(memory).resume(workspace, budget).unwrap();
    }
    let stats = answer.stats;
    (left, used, (stats.work as f64, stats.bv_tests as f64))
}

#[test]
fn the_same_calls_leave_the_same_memory() {
    let [a, b] = trees();
    let play = || {
        let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
        let clock = ManualClock::new();
        let told: Vec<_> = (0..30)
            .map(|i| {
                let query = Query::all_pairs(&a, &b, at(1.0 + 0.01 * f64::from(i)));
                let told = query.predict(Some(&memory));
                let _ = cut(&query, &mut memory, &mut workspace, &clock);
                told
            })
            .collect();
        (told, memory)
    };
    assert_eq!(play(), play());
}

#[test]
fn a_prediction_for_another_pose_teaches_nothing() {
    let [a, b] = trees();
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let [asked, run, later] = [1.0, 1.5, 1.7].map(|x| Query::all_pairs(&a, &b, at(x)));
    let _ = asked
        .with_memory(&mut memory)
        .run(&mut workspace, Budget::work(1));
    let mut other = memory.clone();
    let _ = asked.predict(Some(&memory));
    for memory in [&mut memory, &mut other] {
        let _ = run
            .with_memory(memory)
            .run(&mut workspace, Budget::unlimited());
    }
    assert_eq!(later.predict(Some(&memory)), later.predict(Some(&other)));
}
