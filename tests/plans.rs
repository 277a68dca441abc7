//! The plans of a run: whatever may be spent, and however often that changes, nothing said is false, nothing is reported twice
//! and everything is found, wherever it is stopped, in however small a workspace. What may be cut finds more early; what is not
//! cut costs no more than depth-first.

mod common;

use common::ORDERS;
use common::check::{
    ENOUGH, assert_certificate, assert_complete, assert_sound, resume, run, run_to_end, sorted,
};
use common::random::{Drift, Random, pose_about};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::{Intersection, Order};
use punctual::{Budget, Mesh, Mode, Pose, Query, StopReason, Tree, Workspace, shapes};
use std::time::Duration;

/// A time that is not expected to last.
const SHORT: Budget = Budget::time(Duration::from_nanos(1));

struct Case {
    a: Tree,
    b: Tree,
    pose: Pose,
}

impl Case {
    fn query(&self) -> Query<'_, Intersection> {
        Query::all_pairs(&self.a, &self.b, self.pose)
    }

    /// All pairs, depth-first.
    fn truth(&self) -> Vec<[u32; 2]> {
        let mut workspace = Workspace::new();
        let _ = run(
            &self.query().order(Order::DepthFirst),
            &mut workspace,
            Budget::unlimited(),
        );
        sorted(workspace.pairs())
    }
}

fn pose(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(
        DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(0.3),
        DVec3::new(x, y, z),
    )
    .unwrap()
}

/// Curves that are closed, many, and cut by open edges; aligned surfaces, where all is in doubt; a soup without neighbors.
fn cases() -> Vec<Case> {
    let case = |a: Mesh, b: Mesh, pose| Case {
        a: Tree::new(a),
        b: Tree::new(b),
        pose,
    };
    let sphere = || shapes::icosphere(4);
    let apart = |mesh: &Mesh| {
        let corners: Vec<DVec3> = (0..mesh.len()).flat_map(|i| mesh.triangle(i)).collect();
        let triangles = (0..mesh.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        Mesh::from_f64(corners.iter().map(|corner| corner.to_array()), triangles).unwrap()
    };
    vec![
        case(sphere(), sphere(), pose(0.7, 0.2, 0.1)),
        case(
            shapes::torus_knot(2, 3, 0.2, 40),
            shapes::torus_knot(3, 2, 0.2, 40),
            pose(0.1, 0.0, 0.2),
        ),
        case(
            shapes::height_field(40, 1),
            shapes::height_field(40, 2),
            pose(0.0, 0.0, 0.0),
        ),
        case(
            shapes::gear(12, 4),
            shapes::gear(12, 4),
            Pose::new(DMat3::IDENTITY, DVec3::new(0.5, 0.0, 0.0)).unwrap(),
        ),
        case(
            shapes::cuboid([1.0; 3], 6),
            shapes::cuboid([1.0; 3], 6),
            Pose::IDENTITY,
        ),
        case(apart(&sphere()), sphere(), pose(0.7, 0.2, 0.1)),
    ]
}

#[test]
fn all_plans_end_in_the_same_pairs() {
    let mut workspace = Workspace::new();
    let clock = ManualClock::new();
    for (i, case) in cases().iter().enumerate() {
        let truth = case.truth();
        assert!(!truth.is_empty(), "case {i}");
        for query in ORDERS.map(|order| case.query().order(order)) {
            for budget in [ENOUGH, Budget::unlimited(), SHORT] {
                // The clock stands still, so that what is short lasts nevertheless.
                let outcome = query.run(&mut workspace, budget.clock(&clock));
                assert_complete(Mode::All, &outcome, workspace.pairs(), &truth);
            }
        }
    }
}

/// A run goes on by the plan that it was begun with, whatever budget it gets next.
#[test]
fn budgets_of_other_kinds_go_on_with_a_run() {
    let clock = ManualClock::new();
    for case in cases() {
        let truth = case.truth();
        for (first, next) in [
            (Budget::work(2_000), Budget::unlimited()),
            (Budget::work(2_000), SHORT),
            // These end when the pair buffer is full.
            (Budget::unlimited(), Budget::work(1_000)),
            (SHORT, Budget::work(1_000)),
            (SHORT, Budget::unlimited()),
            (Budget::unlimited(), SHORT),
        ] {
            let mut workspace = Workspace::with_capacity(64, truth.len() / 4 + 1);
            let query = case.query();
            let mut outcome = query.run(&mut workspace, first.clock(&clock));
            let (mut pairs, mut calls) = (Vec::new(), 1);
            loop {
                let here = [&pairs[..], workspace.pairs()].concat();
                assert_sound(&outcome, &here, &truth);
                pairs.extend(workspace.drain_pairs());
                if outcome.stop == StopReason::Finished {
                    break;
                }
                // The one kind and the other in turn.
                let budget = if calls % 2 == 1 { next } else { first };
                outcome = query.resume(&mut workspace, budget.clock(&clock)).unwrap();
                calls += 1;
            }
            assert!(calls > 1);
            assert_eq!(sorted(&pairs), truth);
        }
    }
}

/// More stops: `PUNCTUAL_STOPS=1000000 cargo test --release --test plans`.
#[test]
fn no_pair_is_wrong_or_told_twice_at_any_stop() {
    let stops: usize = std::env::var("PUNCTUAL_STOPS").map_or(1500, |stops| stops.parse().unwrap());
    let mut random = Random::new(5);
    let mut cases = cases();
    let mut workspaces =
        [(4096, 65536), (0, 8), (3, 100), (64, 2000)].map(|(q, f)| Workspace::with_capacity(q, f));
    let mut stopped = 0;
    for round in 0.. {
        let count = cases.len();
        let case = &mut cases[round % count];
        if round >= count && random.below(3) > 0 {
            case.pose = pose_about(DVec3::ZERO, 0.8, Drift::Shear, &mut random);
        }
        let truth = case.truth();
        let all = run(&case.query(), &mut Workspace::new(), ENOUGH).stats.work;
        for _ in 0..10 {
            let query = case.query().order(ORDERS[random.below(3)]);
            let workspace = &mut workspaces[random.below(4)];
            let mut outcome = run(
                &query,
                workspace,
                Budget::work((random.unit() * 1.3 * all as f64) as u64),
            );
            let mut pairs = Vec::new();
            for pieces in 0.. {
                if pieces < 8 || outcome.stop == StopReason::Finished {
                    let here = [&pairs[..], workspace.pairs()].concat();
                    assert_sound(&outcome, &here, &truth);
                    assert_certificate(
                        &query.certificate(workspace).unwrap(),
                        &outcome,
                        truth.len(),
                    );
                    stopped += usize::from(outcome.stop != StopReason::Finished);
                }
                pairs.extend(workspace.drain_pairs());
                if outcome.stop == StopReason::Finished {
                    break;
                }
                let budget = if pieces < 8 {
                    Budget::work((random.unit() * 0.5 * all as f64) as u64)
                } else {
                    ENOUGH
                };
                outcome = resume(&query, workspace, budget);
            }
            assert_eq!(sorted(&pairs), truth);
        }
        if stopped >= stops {
            break;
        }
    }
}

#[test]
fn a_resumed_trace_ends_in_the_same_bits_as_one_that_never_stopped() {
    for case in cases() {
        for query in ORDERS.map(|order| case.query().order(order)) {
            let (mut whole, mut pieces) = (Workspace::new(), Workspace::new());
            let expected = run(&query, &mut whole, ENOUGH);
            let mut outcome = run(&query, &mut pieces, Budget::work(1));
            while outcome.stop == StopReason::WorkLimit {
                pieces = pieces.clone();
                outcome = resume(
                    &query,
                    &mut pieces,
                    Budget::work(1 + outcome.stats.work % 977),
                );
            }
            assert_eq!((outcome, pieces.pairs()), (expected, whole.pairs()));
        }
    }
}

#[test]
fn both_kernels_trace_the_same_bits() {
    for case in cases() {
        let (mut fast, mut portable) = (Workspace::new(), Workspace::new());
        portable.use_portable_kernels();
        for work in [0, 500, 5_000, 50_000, u64::MAX] {
            let budget = Budget::work(work);
            assert_eq!(
                run(&case.query(), &mut fast, budget),
                run(&case.query(), &mut portable, budget)
            );
            assert_eq!(fast.pairs(), portable.pairs());
        }
    }
}

#[test]
fn full_buffers_lose_nothing_while_tracing() {
    for case in cases() {
        let truth = case.truth();
        for found in [1, 7, 64] {
            let mut workspace = Workspace::with_capacity(16, found);
            let (outcome, pairs) = run_to_end(&case.query(), &mut workspace, ENOUGH);
            assert_eq!(
                (outcome.stop, sorted(&pairs)),
                (StopReason::Finished, truth.clone())
            );
        }
    }
}

#[test]
fn limited_queries_know_much_at_a_fifth_of_the_work() {
    let (mut plain, mut planned) = (0.0, 0.0);
    let mut workspace = Workspace::new();
    // Without the last two, where there is nothing to follow.
    for case in cases().iter().take(4) {
        let depth_first = case.query().plain();
        let all = run(&depth_first, &mut workspace, ENOUGH);
        let budget = Budget::work(all.stats.work / 5);
        let share = |query: &Query<Intersection>, workspace: &mut Workspace| {
            run(query, workspace, budget).stats.found as f64 / all.stats.found as f64
        };
        plain += share(&depth_first, &mut workspace) / 4.0;
        planned += share(&case.query(), &mut workspace) / 4.0;
    }
    assert!(planned > 0.4, "{planned}");
    assert!(planned > 2.0 * plain, "{planned} after {plain}");
}

/// Where edges of both meshes cross each other, curves end, so what is left must be found elsewhere.
#[test]
fn much_is_known_at_a_fifth_of_the_work_of_aligned_surfaces_too() {
    let (a, b) = (
        Tree::new(shapes::icosphere(5)),
        Tree::new(shapes::torus(2.0, 0.5, 128)),
    );
    let mut workspace = Workspace::new();
    for (angle, least) in [(0.0, 0.45), (0.01, 0.45), (0.3, 0.9)] {
        for x in [0.9, 1.0, 1.05] {
            let turn = DMat3::from_rotation_y(angle);
            let pose = Pose::new(turn, DVec3::new(x, 0.0, 0.0)).unwrap();
            let query = Query::all_pairs(&a, &b, pose);
            let all = run(&query, &mut workspace, Budget::unlimited()).stats;
            let budget = Budget::work(all.work / 5);
            let found = run(&query, &mut workspace, budget).stats.found;
            let share = found as f64 / all.found as f64;
            assert!(share > least, "{share} at {x}, turned by {angle}");
        }
    }
}

#[test]
fn a_first_hit_that_may_be_cut_comes_sooner_than_depth_first_in_the_geometric_mean() {
    let (mut workspace, mut logs) = (Workspace::new(), Vec::new());
    for mut case in cases() {
        let (turn, shift) = (*case.pose.rotation(), case.pose.translation());
        for k in 0..16 {
            let place = shift + DVec3::new(0.02, -0.03, 0.04) * f64::from(k);
            let turn = DMat3::from_rotation_z(0.7 * f64::from(k)) * turn;
            case.pose = Pose::new(turn, place).unwrap();
            let query = case.query().mode(Mode::Any);
            let [plain, planned] =
                [query.plain(), query].map(|query| run(&query, &mut workspace, ENOUGH));
            if plain.value.meets() {
                logs.push((planned.stats.work as f64 / plain.stats.work as f64).ln());
            }
        }
    }
    let mean = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
    assert!(logs.len() > 80 && mean < 0.8, "{mean} {}", logs.len());
}

#[test]
fn a_finished_run_that_could_be_cut_takes_little_more_than_depth_first() {
    let mut workspace = Workspace::new();
    for case in &cases() {
        let mut work = |query: Query<Intersection>| run(&query, &mut workspace, ENOUGH).stats.work;
        let plain = work(case.query().plain());
        let planned = work(case.query());
        assert!(planned as f64 <= 1.35 * plain as f64, "{planned} {plain}");
    }
}

#[test]
fn unlimited_queries_go_depth_first() {
    let mut workspace = Workspace::new();
    for case in &cases() {
        let mut outcome =
            |query: Query<Intersection>| run(&query, &mut workspace, Budget::unlimited());
        assert_eq!(
            outcome(case.query()),
            outcome(case.query().order(Order::DepthFirst))
        );
    }
}

/// By how much the told recall is off, at shares of the work of a query that is not cut off.
#[test]
fn runs_that_are_cut_know_how_much_they_have_found() {
    let (mut off, mut stops) = (0.0, 0.0);
    let mut workspace = Workspace::new();
    for case in cases().iter().take(4) {
        let all = run(&case.query(), &mut workspace, ENOUGH);
        for tenth in 1..10 {
            let query = case.query();
            let outcome = run(
                &query,
                &mut workspace,
                Budget::work(all.stats.work * tenth / 10),
            );
            let told = query.estimate(&workspace, None).unwrap().recall;
            off += (told - outcome.stats.found as f64 / all.stats.found as f64).abs();
            stops += 1.0;
        }
    }
    assert!(off < 0.25 * stops, "{}", off / stops);
}

#[test]
fn a_refit_mesh_and_one_read_from_a_file_are_traced_as_well() {
    let case = &mut cases()[0];
    case.a = Tree::from_bytes(&case.a.to_bytes()).unwrap();
    assert_eq!(case.a.stats().bytes_neighbors, 12 * case.a.mesh().len());
    let (mesh, stretch) = (case.a.mesh(), DVec3::new(1.2, 0.8, 1.0));
    let moved: Vec<[f64; 3]> = (0..mesh.vertex_count())
        .map(|i| (mesh.vertex(i) * stretch + DVec3::splat(0.05)).to_array())
        .collect();
    case.a.refit_f64(&moved).unwrap();
    let truth = case.truth();
    let mut workspace = Workspace::new();
    let outcome = run(&case.query(), &mut workspace, ENOUGH);
    assert!(!truth.is_empty());
    assert_complete(Mode::All, &outcome, workspace.pairs(), &truth);
}
