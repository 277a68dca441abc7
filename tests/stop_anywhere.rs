//! The promise at every possible stop: whatever the budget, nothing that is said is false, nothing that was found
//! is lost, what was not looked at is named, and a resumed query ends in the same bits as one that never stopped.
//!
//! By default a sample of the stops, with every one of the first and last; `PUNCTUAL_ALL_STOPS=1` takes all of them.

mod common;

use std::time::Duration;

use common::ask::{answer, assert_time_is_kept, resumes, run_in_pieces};
use common::check::{
    ENOUGH, assert_certificate, assert_complete, assert_sound, resume, run, sorted,
};
use common::meshes::{at, cube, moved, placed, triangles};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::{Place, all_pairs, place};
use common::steps::assert_step;
use common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::{Intersection, Order};
use punctual::prediction::MAX_STEP_WORK;
use punctual::shapes::{icosphere, torus, torus_knot};
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

fn case(name: &'static str, a: Mesh, b: Mesh, pose: Pose) -> Case {
    let truth = all_pairs(&a, &b, &pose);
    let (a, b) = (Tree::new(a), Tree::new(b));
    Case {
        name,
        a,
        b,
        pose,
        truth,
    }
}

impl Case {
    fn query(&self, mode: Mode, order: Order) -> Query<'_, Intersection> {
        Query::intersection(&self.a, &self.b, self.pose)
            .mode(mode)
            .order(order)
    }

    /// Every mode and order.
    fn each_query(&self, mut visit: impl FnMut(&Query<Intersection>, Mode)) {
        for (mode, order) in MODES
            .iter()
            .flat_map(|mode| ORDERS.map(|order| (*mode, order)))
        {
            visit(&self.query(mode, order), mode);
        }
    }

    /// Where each of the true pairs meets.
    fn places(&self) -> Vec<Place> {
        let of = |&pair| place(self.a.mesh(), self.b.mesh(), &self.pose, pair);
        self.truth.iter().map(of).collect()
    }
}

/// Small enough to stop at every unit of work, and different in what they reach.
fn cases() -> Vec<Case> {
    let mut random = Random::new(2024);
    let turned = pose_about(DVec3::ZERO, 0.3, Drift::Shear, &mut random);
    let linked = placed(DMat3::from_rotation_x(1.57), [1.0, 0.0, 0.0]);
    let [ring, knot] = [torus(1.0, 0.15, 12), torus_knot(2, 3, 0.15, 10)];
    let [sphere, field] = [icosphere(1), shapes::height_field(16, 3)];
    let box_of = |cells| shapes::cuboid([1.0; 3], cells);
    let one = |size: f64| {
        let corners = [[-0.5, -0.4, 0.1], [0.6, -0.3, 0.0], [0.1, 0.7, -0.1]];
        triangles([corners.map(|corner| size * DVec3::from(corner))])
    };
    // The middle of the small triangle lies on the knot.
    let [x, y, z] = knot.triangle(30);
    let aside = placed(*turned.rotation(), (x + y + z) / 3.0);
    let around = aside.inverse().unwrap();
    let far_pose = pose_about(Family::FarOffset.center(), 0.5, Drift::None, &mut random);
    let mut soup = |family, count| soup(family, count, &mut random);
    let mut soups = |family, counts: [usize; 2]| counts.map(|count| soup(family, count));
    let [points, edges] = soups(Family::Degenerate, [70, 70]);
    let [few, many] = soups(Family::Grid, [40, 60]);
    let [small, large] = soups(Family::Unequal, [150, 30]);
    let [here, there] = soups(Family::FarOffset, [50, 60]);
    let [dot, grain] = soups(Family::FarOffset, [1, 1]);
    let [dust, empty] = soups(Family::Uniform, [1, 0]);
    let same = Pose::IDENTITY;
    vec![
        case("linked rings", ring.clone(), ring.clone(), linked),
        case("crossing rings", ring.clone(), ring, at(0.4, 0.1, 0.05)),
        case("apart", sphere.clone(), sphere.clone(), at(9.0, 0.0, 0.0)),
        case("one in the other", icosphere(2), sphere, at(0.1, 0.0, 0.0)),
        case("flush boxes", box_of(3), box_of(3), at(2.0, 0.5, 0.25)),
        case("coincident boxes", box_of(2), box_of(2), same),
        case("knots", knot.clone(), torus_knot(3, 2, 0.15, 10), turned),
        case("dust on a field", field, dust.clone(), same),
        case("degenerate soups", points, edges, turned),
        case("soups on a grid", few, many, same),
        case("unequal soups", small, large, turned),
        case("f64 soups far away", here.clone(), there.clone(), far_pose),
        case("a triangle across a knot", knot.clone(), one(3.0), turned),
        case("a knot across a triangle", one(3.0), knot.clone(), turned),
        case("a small triangle in a knot", knot.clone(), one(0.2), aside),
        case("a knot around a small one", one(0.2), knot, around),
        case("a triangle among far ones", here, dot, far_pose),
        case("far ones around a triangle", grain, there, far_pose),
        case("nothing at all", empty, dust, same),
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

fn assert_stop_is_punctual(said: &Answer<Verdict>, before: u64, budget: u64) {
    let spent = said.stats.work - before;
    assert_step(spent, budget, MAX_STEP_WORK);
    if said.stop == StopReason::WorkLimit {
        assert!(spent + MAX_STEP_WORK >= budget, "{spent} {budget}");
    }
}

/// Each pair was found, or lies in a box of the certificate. How many were not found.
#[track_caller]
fn assert_covered(
    case: &Case,
    places: &[Place],
    query: &Query<Intersection>,
    workspace: &Workspace,
) -> usize {
    let certificate = query.certificate(workspace).unwrap();
    let found = sorted(workspace.pairs());
    let boxes: Vec<_> = certificate.boxes().collect();
    for (pair, place) in case.truth.iter().zip(places) {
        let covered = boxes.iter().any(|open| place.is_in(open));
        assert!(covered || found.binary_search(pair).is_ok(), "{pair:?}");
    }
    case.truth.len() - found.len()
}

/// With any room in the queue; each stopped run is resumed to the same bits.
#[test]
fn at_any_work_budget_nothing_is_false_and_nothing_found_is_lost() {
    let mut missing = 0;
    for (capacity, count) in [(4096, 100), (0, 12), (1, 12), (2, 12), (8, 12)] {
        let mut workspace = Workspace::with_capacity(capacity, 10_000);
        for case in cases() {
            let places = case.places();
            case.each_query(|query, mode| {
                let full = run(query, &mut workspace, ENOUGH);
                let full_pairs = workspace.pairs().to_vec();
                assert_complete(mode, &full, &full_pairs, &case.truth);
                assert!(full.stats.queue_peak as usize <= 64 + capacity);
                for (i, budget) in budgets(full.stats.work, count).enumerate() {
                    let mut said = run(query, &mut workspace, Budget::work(budget));
                    assert_sound(&said, workspace.pairs(), &case.truth);
                    assert_stop_is_punctual(&said, 0, budget);
                    assert!(full_pairs.starts_with(workspace.pairs()), "{}", case.name);
                    let certificate = query.certificate(&workspace).unwrap();
                    assert_certificate(&certificate, &said, case.truth.len());
                    if i % 8 == 0 {
                        missing += assert_covered(&case, &places, query, &workspace);
                    }
                    if said.stop == StopReason::WorkLimit {
                        said = resume(query, &mut workspace, ENOUGH);
                    }
                    assert_eq!(said, full, "{}, {budget}", case.name);
                    assert_eq!(workspace.pairs(), full_pairs, "{}", case.name);
                }
            });
        }
    }
    assert!(missing > 10_000, "{missing}");
}

#[test]
fn slices_of_any_length_end_in_the_same_bits() {
    let mut random = Random::new(11);
    let (mut whole, mut sliced) = (Workspace::new(), Workspace::new());
    for case in cases() {
        case.each_query(|query, _| {
            let full = run(query, &mut whole, ENOUGH);
            for slice in [Some(1), Some(7), None] {
                let mut before = 0;
                let mut next = || slice.unwrap_or_else(|| random.below(2_000) as u64);
                let said = run_in_pieces(query, &mut sliced, &mut next, |said, _| {
                    // A budget of 0 does nothing, any other at least a step.
                    assert!(slice.is_none() || said.stats.work > before);
                    assert!(said.stats.work - before < 2_000 + MAX_STEP_WORK);
                    before = said.stats.work;
                });
                assert_eq!(said, full, "{}, slices of {slice:?}", case.name);
                assert_eq!(sliced.pairs(), whole.pairs(), "{}", case.name);
            }
        });
    }
}

#[test]
fn time_budgets_are_sound_and_kept() {
    let more = Budget::time(Duration::from_micros(2)).poll_interval(64);
    let mut workspace = Workspace::new();
    for case in cases() {
        case.each_query(|query, mode| {
            let check = |said: &Answer<Verdict>, held: &mut Workspace, clock: &ManualClock| {
                assert_sound(said, held.pairs(), &case.truth);
                let certificate = query.certificate(held).unwrap();
                assert_certificate(&certificate, said, case.truth.len());
                let mut said = *said;
                if said.stop == StopReason::Deadline && said.stats.work % 16 != 1 {
                    return;
                }
                while said.stop == StopReason::Deadline {
                    said = query.resume(held, more.clock(clock)).unwrap();
                }
                assert_complete(mode, &said, held.pairs(), &case.truth);
            };
            assert_time_is_kept(query, &mut workspace, MAX_STEP_WORK, 0.., check);
        });
    }
}

/// Exact tests differ most in their time, so the clock is looked at after each, unless the deadline is far.
#[test]
fn near_the_deadline_the_clock_is_looked_at_after_each_exact_test() {
    let cube = cube(4);
    let query = Query::all_pairs(&cube, &cube, at(1e-300, 0.0, 0.0));
    let tick = Duration::from_nanos(1);
    let clock = ManualClock::ticking(tick);
    let looks = |time| {
        let outcome = query.run(&mut Workspace::new(), Budget::time(time).clock(&clock));
        assert_eq!(outcome.stop, StopReason::Finished);
        assert!(outcome.stats.exact_tests > 100);
        let elapsed = outcome.stats.elapsed.unwrap().as_nanos() as u64;
        [elapsed, outcome.stats.exact_tests]
    };
    let [near, exact_tests] = looks(Duration::from_micros(8));
    assert!(near >= exact_tests, "{near}");
    let [far, _] = looks(Duration::from_secs(1));
    assert!(far < near / 10, "{far}");
}

/// With a clock that stands still a time budget never ends, and one of nothing is over at the first look.
#[test]
fn only_the_clock_ends_a_time_budget() {
    let sphere = icosphere(2);
    let case = case("spheres", sphere.clone(), sphere, at(0.5, 0.0, 0.0));
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
    let [sphere, other] = [2, 1].map(|detail| Tree::new(icosphere(detail)));
    let place = at(0.5, 0.0, 0.0);
    let query = Query::all_pairs(&sphere, &sphere, place);
    let mut workspace = Workspace::new();
    let stopped = run(&query, &mut workspace, Budget::work(100));
    assert_eq!(stopped.stop, StopReason::WorkLimit);
    for stranger in [
        Query::all_pairs(&sphere, &sphere, at(0.6, 0.0, 0.0)),
        Query::all_pairs(&sphere, &other, place),
        Query::all_pairs(&other, &sphere, place),
        query.mode(Mode::Any),
        query.order(Order::LowAlpha),
    ] {
        assert!(stranger.certificate(&workspace).is_err());
        assert!(!resumes(&stranger, &workspace));
    }
    assert!(resumes(&query, &workspace));
}

/// A pose that cancels leaves small coordinates with the rounding of large ones: the boxes of a certificate allow for it.
#[test]
fn certificate_boxes_hold_what_a_pose_brings_back_from_afar() {
    let mut workspace = Workspace::new();
    let mut missing = 0;
    for distance in [1e8, 1e11, 1e13] {
        let away = DVec3::new(distance, -0.7 * distance, 0.4 * distance);
        let knot = torus_knot(2, 3, 0.3, 12);
        let far = moved(&knot, |vertex| vertex + away);
        // Turned, so that each coordinate is a sum of large ones.
        let turn = DMat3::from_rotation_z(0.8) * DMat3::from_rotation_x(-0.5);
        let back = placed(turn, DVec3::new(0.2, 0.1, 0.0) - turn * away);
        let case = case("brought back", knot, far, back);
        let places = case.places();
        let query = case.query(Mode::All, Order::default());
        for budget in budgets(answer(&query).stats.work, 200) {
            let said = run(&query, &mut workspace, Budget::work(budget));
            let certificate = query.certificate(&workspace).unwrap();
            assert_certificate(&certificate, &said, case.truth.len());
            missing += assert_covered(&case, &places, &query, &workspace);
        }
    }
    assert!(missing > 10_000, "{missing}");
}

/// However little each call does, with and without a memory, in a large and in a small workspace.
#[test]
fn the_upper_bound_of_a_certificate_never_grows() {
    let [mut large, mut again] = [Workspace::new(), Workspace::new()];
    let mut small = Workspace::with_capacity(64, 100_000);
    let (mut lower, clock) = (0, ManualClock::new());
    for case in cases() {
        let mut memory = PairMemory::new();
        case.each_query(|query, mode| {
            let least = if mode == Mode::All {
                case.truth.len()
            } else {
                0
            };
            for (workspace, remembers) in
                [(&mut large, false), (&mut again, true), (&mut small, false)]
            {
                let known = query.with_memory(remembers.then_some(&mut memory));
                let mut said = known.run(workspace, Budget::work(0).clock(&clock));
                let mut bound = u64::MAX;
                loop {
                    let certificate = query.certificate(workspace).unwrap();
                    assert_certificate(&certificate, &said, least);
                    assert!(certificate.upper_bound() <= bound, "{bound}");
                    lower += u64::from(certificate.upper_bound() < bound);
                    bound = certificate.upper_bound();
                    if said.stop != StopReason::WorkLimit {
                        break;
                    }
                    let known = query.with_memory(remembers.then_some(&mut memory));
                    let step = Budget::work(1).clock(&clock);
                    said = known.resume(workspace, step).unwrap();
                }
            }
        });
    }
    assert!(lower > 10_000, "{lower}");
}
