//! The promise at every possible stop: whatever the budget, nothing that is said is false, nothing that was found
//! is lost, what was not looked at is named, and a resumed query ends in the same bits as one that never stopped.
//!
//! By default a sample of the stops, with every one of the first and last; `PUNCTUAL_ALL_STOPS=1` takes all of them.

mod common;

use std::time::Duration;

use common::check::{
    ENOUGH, assert_certificate, assert_complete, assert_sound, resume, run, sorted,
};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::{Place, all_pairs, place};
use common::steps::assert_step;
use common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::intersection::{Intersection, Order};
use punctual::prediction::MAX_STEP_WORK;
use punctual::{
    Answer, Budget, Mesh, Mode, PairMemory, Pose, Query, StopReason, Tree, Verdict, Workspace,
    shapes,
};

struct Case {
    name: &'static str,
    a: Tree,
    b: Tree,
    pose: Pose,
    truth: Vec<[u32; 2]>,
}

impl Case {
    fn new(name: &'static str, a: Mesh, b: Mesh, pose: Pose) -> Self {
        let truth = all_pairs(&a, &b, &pose);
        let (a, b) = (Tree::new(a), Tree::new(b));
        Self {
            name,
            a,
            b,
            pose,
            truth,
        }
    }

    fn query(&self, mode: Mode, order: Order) -> Query<'_, Intersection> {
        Query::intersection(&self.a, &self.b, self.pose)
            .mode(mode)
            .order(order)
    }

    /// Every mode and order.
    fn each_query(&self, mut visit: impl FnMut(&Query<Intersection>, Mode)) {
        for mode in MODES {
            for order in ORDERS {
                let query = self.query(mode, order);
                visit(&query, mode);
            }
        }
    }
}

fn shifted(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

/// Small enough to stop at every unit of work, and different in what they reach.
fn cases() -> Vec<Case> {
    let mut random = Random::new(2024);
    let turned = pose_about(DVec3::ZERO, 0.3, Drift::Shear, &mut random);
    let linked = {
        let turn = DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2);
        Pose::new(turn, DVec3::new(1.0, 0.0, 0.0)).unwrap()
    };
    let ring = || shapes::torus(1.0, 0.15, 12);
    let knot = || shapes::torus_knot(2, 3, 0.15, 10);
    let one = |size: f32| {
        let corners = [[-0.5, -0.4, 0.1], [0.6, -0.3, 0.0], [0.1, 0.7, -0.1]]
            .map(|corner| corner.map(|x| size * x));
        Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap()
    };
    // The middle of the small triangle lies on the knot.
    let [x, y, z] = knot().triangle(30);
    let aside = Pose::new(*turned.rotation(), (x + y + z) / 3.0).unwrap();
    let far = Family::FarOffset;
    let far_pose = pose_about(far.center(), 0.5, Drift::None, &mut random);
    let mut soup = |family, count| soup(family, count, &mut random);
    vec![
        Case::new("linked rings, no contact", ring(), ring(), linked),
        Case::new("crossing rings", ring(), ring(), shifted(0.4, 0.1, 0.05)),
        Case::new(
            "spheres apart",
            shapes::icosphere(1),
            shapes::icosphere(1),
            shifted(9.0, 0.0, 0.0),
        ),
        Case::new(
            "spheres inside each other",
            shapes::icosphere(2),
            shapes::icosphere(1),
            shifted(0.1, 0.0, 0.0),
        ),
        Case::new(
            "flush boxes",
            shapes::cuboid(Vec3::ONE, 3),
            shapes::cuboid(Vec3::ONE, 3),
            shifted(2.0, 0.5, 0.25),
        ),
        Case::new(
            "coincident boxes",
            shapes::cuboid(Vec3::ONE, 2),
            shapes::cuboid(Vec3::ONE, 2),
            Pose::IDENTITY,
        ),
        Case::new(
            "knots",
            shapes::torus_knot(2, 3, 0.15, 10),
            shapes::torus_knot(3, 2, 0.15, 10),
            turned,
        ),
        Case::new(
            "dust on a field",
            shapes::height_field(16, 3),
            soup(Family::Uniform, 1),
            Pose::IDENTITY,
        ),
        Case::new(
            "degenerate soups",
            soup(Family::Degenerate, 70),
            soup(Family::Degenerate, 70),
            turned,
        ),
        Case::new(
            "soups on a grid",
            soup(Family::Grid, 40),
            soup(Family::Grid, 60),
            Pose::IDENTITY,
        ),
        Case::new(
            "unequal soups",
            soup(Family::Unequal, 150),
            soup(Family::Unequal, 30),
            turned,
        ),
        Case::new("f64 soups far away", soup(far, 50), soup(far, 50), far_pose),
        Case::new("a triangle across a knot", knot(), one(3.0), turned),
        Case::new("a knot across a triangle", one(3.0), knot(), turned),
        Case::new("a small triangle in a knot", knot(), one(0.2), aside),
        Case::new(
            "a knot around a small triangle",
            one(0.2),
            knot(),
            aside.inverse().unwrap(),
        ),
        Case::new(
            "a triangle among far ones",
            soup(far, 60),
            soup(far, 1),
            far_pose,
        ),
        Case::new(
            "far ones around a triangle",
            soup(far, 1),
            soup(far, 60),
            far_pose,
        ),
        Case::new(
            "nothing at all",
            soup(Family::Uniform, 0),
            soup(Family::Uniform, 9),
            Pose::IDENTITY,
        ),
    ]
}

/// About `count` budgets, with every one at both ends; or all of them, if that is asked for.
fn budgets(full: u64, count: u64) -> impl Iterator<Item = u64> {
    let all = std::env::var_os("PUNCTUAL_ALL_STOPS").is_some();
    let stride = if all { 1 } else { (full / count).max(1) };
    let end = count.min(2 * MAX_STEP_WORK);
    let near_an_end = move |work: u64| work < end || work + end > full;
    (0..=full + 1).filter(move |&work| near_an_end(work) || work.is_multiple_of(stride))
}

fn assert_stop_is_punctual(outcome: &Answer<Verdict>, before: u64, budget: u64) {
    let spent = outcome.stats.work - before;
    assert_step(spent, budget, MAX_STEP_WORK);
    if outcome.stop == StopReason::WorkLimit {
        assert!(
            spent + MAX_STEP_WORK >= budget,
            "stopped early, {spent} of {budget}"
        );
    }
}

#[test]
fn at_any_work_budget_nothing_is_false_and_nothing_found_is_lost() {
    let mut workspace = Workspace::new();
    for case in cases() {
        case.each_query(|query, mode| {
            let full = run(query, &mut workspace, ENOUGH);
            let full_pairs = workspace.pairs().to_vec();
            assert_complete(mode, &full, &full_pairs, &case.truth);
            for budget in budgets(full.stats.work, 200) {
                let outcome = run(query, &mut workspace, Budget::work(budget));
                let pairs = workspace.pairs();
                assert_sound(&outcome, pairs, &case.truth);
                assert_stop_is_punctual(&outcome, 0, budget);
                assert!(full_pairs.starts_with(pairs), "{}: {budget}", case.name);
                if budget >= full.stats.work {
                    assert_eq!(outcome, full, "{}", case.name);
                }
            }
        });
    }
}

#[test]
fn at_any_stop_the_certificate_covers_what_is_missing() {
    let mut workspace = Workspace::new();
    let mut undecided_or_partial = 0;
    for case in cases() {
        let places: Vec<Place> = case
            .truth
            .iter()
            .map(|&pair| place(case.a.mesh(), case.b.mesh(), &case.pose, pair))
            .collect();
        case.each_query(|query, _| {
            let full = run(query, &mut workspace, ENOUGH);
            for budget in budgets(full.stats.work, 25) {
                let outcome = run(query, &mut workspace, Budget::work(budget));
                let certificate = query.certificate(&workspace).unwrap();
                assert_certificate(&certificate, &outcome, case.truth.len());
                let found = sorted(workspace.pairs());
                let boxes: Vec<_> = certificate.boxes().collect();
                for (pair, place) in case.truth.iter().zip(&places) {
                    let covered = boxes.iter().any(|open| place.is_in(open));
                    assert!(
                        covered || found.binary_search(pair).is_ok(),
                        "{}: {pair:?} is in no box, budget {budget}",
                        case.name
                    );
                }
                undecided_or_partial += usize::from(found.len() < case.truth.len());
            }
        });
    }
    assert!(undecided_or_partial > 100);
}

#[test]
fn slices_of_any_length_end_in_the_same_bits() {
    let mut random = Random::new(11);
    let (mut whole, mut sliced) = (Workspace::new(), Workspace::new());
    for case in cases() {
        case.each_query(|query, _| {
            let full = run(query, &mut whole, ENOUGH);
            for slice in [Some(1), Some(7), None] {
                let mut next = || slice.unwrap_or_else(|| random.below(2_000) as u64);
                let mut outcome = run(query, &mut sliced, Budget::work(next()));
                while outcome.stop == StopReason::WorkLimit {
                    let before = outcome.stats.work;
                    let budget = next();
                    outcome = resume(query, &mut sliced, Budget::work(budget));
                    assert_stop_is_punctual(&outcome, before, budget);
                    assert!(
                        budget == 0
                            || outcome.stats.work > before
                            || outcome.stop != StopReason::WorkLimit
                    );
                }
                assert_eq!(outcome, full, "{}, slices of {slice:?}", case.name);
                assert_eq!(sliced.pairs(), whole.pairs(), "{}", case.name);
            }
        });
    }
}

/// A run that stops once, wherever, and then goes on to its end.
#[test]
fn a_lone_triangle_resumes_from_any_stop() {
    let (mut whole, mut stopped) = (Workspace::new(), Workspace::new());
    let mut stops = 0;
    for case in cases()
        .iter()
        .filter(|case| case.a.mesh().len() == 1 || case.b.mesh().len() == 1)
    {
        case.each_query(|query, mode| {
            let full = run(query, &mut whole, ENOUGH);
            assert_complete(mode, &full, whole.pairs(), &case.truth);
            for budget in 0..full.stats.work.min(3_000) {
                let mut outcome = run(query, &mut stopped, Budget::work(budget));
                assert_sound(&outcome, stopped.pairs(), &case.truth);
                if outcome.stop == StopReason::WorkLimit {
                    stops += 1;
                    outcome = resume(query, &mut stopped, ENOUGH);
                }
                assert_eq!(outcome, full, "{}, {budget}", case.name);
                assert_eq!(stopped.pairs(), whole.pairs(), "{}, {budget}", case.name);
            }
        });
    }
    assert!(stops > 10_000, "{stops}");
}

/// The clock ticks once a look, so a budget of k ticks ends at look k, and the work between two looks is bounded.
#[test]
fn time_budgets_are_sound_and_kept() {
    const POLL: u64 = 64;
    let tick = Duration::from_micros(1);
    let mut workspace = Workspace::new();
    for case in cases() {
        case.each_query(|query, mode| {
            for ticks in 0u32.. {
                let clock = ManualClock::ticking(tick);
                let time = tick * ticks;
                // Looks are as far apart as the time that is left allows.
                let most_per_look = POLL.max(time.as_nanos() as u64) + MAX_STEP_WORK;
                let mut outcome = query.run(
                    &mut workspace,
                    Budget::time(time).poll_interval(POLL).clock(&clock),
                );
                assert_sound(&outcome, workspace.pairs(), &case.truth);
                assert!(outcome.stats.work <= u64::from(ticks + 1) * most_per_look);
                if outcome.stop != StopReason::Deadline {
                    assert_complete(mode, &outcome, workspace.pairs(), &case.truth);
                    break;
                }
                assert!(outcome.stats.elapsed.unwrap() >= time);
                let certificate = query.certificate(&workspace).unwrap();
                assert_certificate(&certificate, &outcome, case.truth.len());
                if ticks % 16 == 1 {
                    while outcome.stop == StopReason::Deadline {
                        let more = Budget::time(2 * tick).poll_interval(POLL);
                        outcome = query.resume(&mut workspace, more.clock(&clock)).unwrap();
                    }
                    assert_complete(mode, &outcome, workspace.pairs(), &case.truth);
                }
            }
        });
    }
}

/// Exact tests differ most in their time, so the clock is looked at after each, unless the deadline is far.
#[test]
fn near_the_deadline_the_clock_is_looked_at_after_each_exact_test() {
    let cube = Tree::new(shapes::cuboid(Vec3::ONE, 4));
    let query = Query::all_pairs(&cube, &cube, shifted(1e-300, 0.0, 0.0));
    let tick = Duration::from_nanos(1);
    let clock = ManualClock::ticking(tick);
    let looks = |time| {
        let outcome = query.run(&mut Workspace::new(), Budget::time(time).clock(&clock));
        assert_eq!(outcome.stop, StopReason::Finished);
        assert!(outcome.stats.exact_tests > 100);
        [
            outcome.stats.elapsed.unwrap().as_nanos() as u64,
            outcome.stats.exact_tests,
        ]
    };
    let [near, exact_tests] = looks(Duration::from_micros(8));
    assert!(near >= exact_tests, "{near}");
    let [far, _] = looks(Duration::from_secs(1));
    assert!(
        far < near / 10,
        "at the end, and now and then whether the call is cancelled: {far}"
    );
}

/// With a clock that stands still a time budget never ends, and one of nothing is over at the first look.
#[test]
fn only_the_clock_ends_a_time_budget() {
    let case = Case::new(
        "spheres",
        shapes::icosphere(2),
        shapes::icosphere(2),
        shifted(0.5, 0.0, 0.0),
    );
    let query = case.query(Mode::All, Order::default());
    let mut workspace = Workspace::new();
    let clock = ManualClock::new();
    let short = Budget::time(Duration::from_nanos(1)).poll_interval(1);
    let outcome = query.run(&mut workspace, short.clock(&clock));
    assert_complete(Mode::All, &outcome, workspace.pairs(), &case.truth);
    let none = Budget::time(Duration::ZERO).poll_interval(1);
    let outcome = query.run(&mut workspace, none.clock(&clock));
    assert_eq!(outcome.stop, StopReason::Deadline);
    assert_eq!(outcome.value, Verdict::Undecided);
    assert!(outcome.stats.work <= MAX_STEP_WORK);
    clock.advance(Duration::from_secs(1));
    let outcome = query.resume(&mut workspace, short.clock(&clock));
    assert_eq!(outcome.unwrap().stop, StopReason::Finished);
    assert_eq!(sorted(workspace.pairs()), case.truth);
}

#[test]
fn a_full_queue_loses_nothing() {
    for capacity in [0, 1, 2, 8] {
        let mut workspace = Workspace::with_capacity(capacity, 10_000);
        for case in cases() {
            case.each_query(|query, mode| {
                let full = run(query, &mut workspace, ENOUGH);
                let full_pairs = workspace.pairs().to_vec();
                assert_complete(mode, &full, &full_pairs, &case.truth);
                assert!(full.stats.queue_peak as usize <= 64 + capacity);
                for budget in budgets(full.stats.work, 12) {
                    let mut outcome = run(query, &mut workspace, Budget::work(budget));
                    assert_sound(&outcome, workspace.pairs(), &case.truth);
                    let certificate = query.certificate(&workspace).unwrap();
                    assert_certificate(&certificate, &outcome, case.truth.len());
                    if outcome.stop == StopReason::WorkLimit {
                        outcome = resume(query, &mut workspace, ENOUGH);
                    }
                    assert_eq!(outcome, full, "{}, {budget}", case.name);
                    assert_eq!(workspace.pairs(), full_pairs);
                }
            });
        }
    }
}

#[test]
fn a_full_pair_buffer_stops_and_loses_nothing() {
    let mut workspaces = [
        (usize::MAX, Workspace::with_capacity(64, 1)),
        (1, Workspace::new()),
        (2, Workspace::new()),
        (7, Workspace::with_capacity(64, 7)),
    ];
    for case in cases() {
        case.each_query(|query, mode| {
            for (limit, workspace) in &mut workspaces {
                let query = query.pair_limit(*limit);
                let most = (*limit).min(7);
                let mut outcome = run(&query, workspace, ENOUGH);
                let mut pairs = Vec::new();
                while outcome.stop == StopReason::PairsFull {
                    assert!(matches!(outcome.value, Verdict::Intersecting { .. }));
                    assert!((1..=most).contains(&workspace.pairs().len()));
                    let certificate = query.certificate(workspace).unwrap();
                    assert_certificate(&certificate, &outcome, case.truth.len());
                    pairs.extend(workspace.drain_pairs());
                    assert_eq!(outcome.stats.found, pairs.len() as u64);
                    outcome = resume(&query, workspace, ENOUGH);
                }
                pairs.extend(workspace.drain_pairs());
                assert_complete(mode, &outcome, &pairs, &case.truth);
            }
        });
    }
}

#[test]
fn only_a_stopped_run_of_the_same_query_resumes() {
    let sphere = Tree::new(shapes::icosphere(2));
    let other = Tree::new(shapes::icosphere(1));
    let query = Query::intersection(&sphere, &sphere, shifted(0.5, 0.0, 0.0)).mode(Mode::All);
    let clock = ManualClock::new();
    let mut workspace = Workspace::new();
    let resumed = |query: &Query<Intersection>, workspace: &mut Workspace| {
        query.resume(workspace, ENOUGH.clock(&clock)).is_ok()
    };
    assert!(!resumed(&query, &mut workspace), "fresh workspace");
    let finished = run(&query, &mut workspace, ENOUGH);
    assert_eq!(finished.stop, StopReason::Finished);
    assert!(!resumed(&query, &mut workspace), "finished run");
    let strangers = [
        Query::intersection(&sphere, &sphere, shifted(0.6, 0.0, 0.0)).mode(Mode::All),
        Query::intersection(&sphere, &other, shifted(0.5, 0.0, 0.0)).mode(Mode::All),
        Query::intersection(&other, &sphere, shifted(0.5, 0.0, 0.0)).mode(Mode::All),
        query.mode(Mode::Any),
        query.order(Order::LowAlpha),
    ];
    for stranger in &strangers {
        let stopped = run(&query, &mut workspace, Budget::work(100));
        assert_eq!(stopped.stop, StopReason::WorkLimit);
        assert!(stranger.certificate(&workspace).is_err());
        assert!(!resumed(stranger, &mut workspace));
        assert!(resumed(&query, &mut workspace), "the stopped run is intact");
    }
}

/// A pose that cancels leaves small coordinates with the rounding of large ones: the boxes of a certificate allow for it.
#[test]
fn certificate_boxes_hold_what_a_pose_brings_back_from_afar() {
    let mut workspace = Workspace::new();
    let mut points = 0;
    for distance in [1e8, 1e11, 1e13] {
        let away = DVec3::new(distance, -0.7 * distance, 0.4 * distance);
        let knot = shapes::torus_knot(2, 3, 0.3, 12);
        let far = (0..knot.vertex_count()).map(|i| (knot.vertex(i) + away).to_array());
        let far = Mesh::from_f64(far, knot.triangles().iter().copied()).unwrap();
        // Turned, so that each coordinate is a sum of large ones.
        let turn = DMat3::from_rotation_z(0.8) * DMat3::from_rotation_x(-0.5);
        let back = Pose::new(turn, DVec3::new(0.2, 0.1, 0.0) - turn * away).unwrap();
        let case = Case::new("brought back", knot, far, back);
        let places: Vec<Place> = case
            .truth
            .iter()
            .map(|&pair| place(case.a.mesh(), case.b.mesh(), &case.pose, pair))
            .collect();
        assert!(!case.truth.is_empty());
        let query = case.query(Mode::All, Order::default());
        let full = run(&query, &mut workspace, ENOUGH);
        for budget in budgets(full.stats.work, 200) {
            let outcome = run(&query, &mut workspace, Budget::work(budget));
            let certificate = query.certificate(&workspace).unwrap();
            assert_certificate(&certificate, &outcome, case.truth.len());
            let (found, boxes) = (
                sorted(workspace.pairs()),
                certificate.boxes().collect::<Vec<_>>(),
            );
            for (pair, place) in case.truth.iter().zip(&places) {
                let covered =
                    found.binary_search(pair).is_ok() || boxes.iter().any(|open| place.is_in(open));
                assert!(
                    covered,
                    "{distance:e}: {pair:?} is in no box, budget {budget}"
                );
                points += 1;
            }
        }
    }
    assert!(points > 10_000);
}

/// However little each call does, with and without a memory, in a large and in a small workspace.
#[test]
fn the_upper_bound_of_a_certificate_never_grows() {
    let (mut large, mut again, mut small) = (
        Workspace::new(),
        Workspace::new(),
        Workspace::with_capacity(64, 100_000),
    );
    let mut lower = 0;
    for case in cases() {
        let mut memory = PairMemory::new();
        case.each_query(|query, mode| {
            for (workspace, remembers) in
                [(&mut large, false), (&mut again, true), (&mut small, false)]
            {
                let clock = ManualClock::new();
                let known = remembers.then_some(&mut memory);
                let mut said = query
                    .with_memory(known)
                    .run(workspace, Budget::work(0).clock(&clock));
                let mut bound = u64::MAX;
                loop {
                    let certificate = query.certificate(workspace).unwrap();
                    assert_certificate(
                        &certificate,
                        &said,
                        if mode == Mode::All {
                            case.truth.len()
                        } else {
                            0
                        },
                    );
                    assert!(
                        certificate.upper_bound() <= bound,
                        "{}: {bound}, then {certificate:?}",
                        case.name
                    );
                    lower += u64::from(certificate.upper_bound() < bound);
                    bound = certificate.upper_bound();
                    if said.stop != StopReason::WorkLimit {
                        break;
                    }
                    let known = remembers.then_some(&mut memory);
                    said = query
                        .with_memory(known)
                        .resume(workspace, Budget::work(1).clock(&clock))
                        .unwrap();
                }
            }
        });
    }
    assert!(lower > 10_000, "{lower}");
}
