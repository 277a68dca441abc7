//! Same input and same work budget: same bits, in every run, thread and workspace. A seed and a memory change
//! the way to an answer, never the answer.

mod common;

use std::thread;

use common::check::{ENOUGH, assert_complete, assert_sound, run, run_to_end, run_with_memory};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::all_pairs;
use common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::intersection::{Intersection, Order};
use punctual::tree::{Subtree, TreeStats};
use punctual::{
    Aabb, Answer, Budget, BuildOptions, Certificate, Mesh, MeshError, Mode, PairMemory, Pose,
    PoseError, Query, Stats, StopReason, Tree, Verdict, Workspace, shapes,
};

/// Everything a run says: the outcome with all counters, the pairs in order, the open boxes in order.
#[derive(Debug, PartialEq)]
struct Said {
    outcome: Answer<Verdict>,
    pairs: Vec<[u32; 2]>,
    upper_bound: u64,
    open: Vec<Aabb>,
}

fn ask(query: &Query<Intersection>, workspace: &mut Workspace, budget: Budget) -> Said {
    let outcome = run(query, workspace, budget);
    let certificate = query.certificate(workspace).unwrap();
    Said {
        outcome,
        pairs: workspace.pairs().to_vec(),
        upper_bound: certificate.upper_bound(),
        open: certificate.boxes().collect(),
    }
}

fn knot_and_gear() -> (Tree, Tree, Pose) {
    let knot = Tree::new(shapes::torus_knot(2, 3, 0.2, 16));
    let gear = Tree::new(shapes::gear(11, 2));
    let pose = pose_about(DVec3::ZERO, 0.2, Drift::None, &mut Random::new(4));
    (knot, gear, pose)
}

/// The kernels of this machine against those that run everywhere.
#[test]
fn all_kernels_say_the_same() {
    let (a, b, pose) = knot_and_gear();
    let mut portable = Workspace::new();
    portable.use_portable_kernels();
    for mode in MODES {
        for order in ORDERS {
            let query = Query::intersection(&a, &b, pose).mode(mode).order(order);
            for budget in [
                Budget::unlimited(),
                Budget::work(5_000),
                Budget::work(50_000),
            ] {
                let expected = ask(&query, &mut Workspace::new(), budget);
                assert_eq!(ask(&query, &mut portable, budget), expected, "{mode:?}");
            }
        }
    }
}

#[test]
fn a_hundred_runs_in_several_workspaces_and_threads_say_the_same() {
    let (a, b, pose) = knot_and_gear();
    let (again_a, again_b, _) = knot_and_gear();
    for mode in MODES {
        for order in ORDERS {
            let query = Query::intersection(&a, &b, pose).mode(mode).order(order);
            let full = run(&query, &mut Workspace::new(), ENOUGH);
            for budget in [
                Budget::unlimited(),
                ENOUGH,
                Budget::work(full.stats.work / 2),
            ] {
                let first = ask(&query, &mut Workspace::new(), budget);
                let rounds = || {
                    let mut used = Workspace::new();
                    for round in 0..50 {
                        assert_eq!(ask(&query, &mut used, budget), first, "{round}");
                        let other = Query::intersection(&b, &a, pose).order(Order::LowAlpha);
                        let _ = run(&other, &mut used, Budget::work(40 * round));
                    }
                };
                thread::scope(|scope| {
                    scope.spawn(rounds);
                    scope.spawn(rounds);
                });
                let rebuilt = Query::intersection(&again_a, &again_b, pose);
                let rebuilt = rebuilt.mode(mode).order(order);
                assert_eq!(ask(&rebuilt, &mut Workspace::new(), budget), first);
            }
        }
    }
}

#[test]
fn orders_differ_in_order() {
    let (a, b, pose) = knot_and_gear();
    let mut workspace = Workspace::new();
    let in_order = ORDERS.map(|order| {
        let query = Query::all_pairs(&a, &b, pose);
        run_to_end(&query.order(order), &mut workspace, ENOUGH).1
    });
    for (i, one) in in_order.iter().enumerate() {
        for (j, other) in in_order.iter().enumerate().skip(i + 1) {
            assert!(one != other, "{:?} and {:?}", ORDERS[i], ORDERS[j]);
        }
    }
}

/// A path in and out of contact, then a jump; memories that are fresh, that know the frame before, that come from
/// another pair of meshes.
#[test]
fn a_memory_never_changes_what_is_decided() {
    let (a, b, _) = knot_and_gear();
    let stranger = Tree::new(soup(Family::Uniform, 300, &mut Random::new(1)));
    let mut workspace = Workspace::new();
    let mut answers = [0, 0];
    for mode in MODES {
        for order in ORDERS {
            let (mut memory, mut starved, mut foreign) =
                (PairMemory::new(), PairMemory::new(), PairMemory::new());
            for step in -30..30 {
                let pose = on_path(step);
                let truth = all_pairs(a.mesh(), b.mesh(), &pose);
                answers[usize::from(truth.is_empty())] += 1;
                let query = Query::intersection(&a, &b, pose).mode(mode).order(order);
                for known in [&mut PairMemory::new(), &mut memory, &mut foreign] {
                    let all = Budget::unlimited();
                    let outcome = run_with_memory(&query, &mut workspace, known, all);
                    assert_complete(mode, &outcome, workspace.pairs(), &truth);
                }
                for budget in [0, 50, 500, 3_000].map(Budget::work) {
                    let outcome = run_with_memory(&query, &mut workspace, &mut starved, budget);
                    assert_sound(&outcome, workspace.pairs(), &truth);
                }
                let elsewhere = Query::intersection(&stranger, &stranger, pose).mode(mode);
                let half = Budget::work(2_000);
                let _ = run_with_memory(&elsewhere, &mut workspace, &mut foreign, half);
            }
        }
    }
    assert!(answers.iter().all(|&count| count > 100), "{answers:?}");
}

fn on_path(step: i32) -> Pose {
    let turn = DMat3::from_rotation_z(0.02 * f64::from(step));
    let shift = DVec3::new(0.1 * f64::from(step), 0.05, 0.0);
    Pose::new(turn, shift).unwrap()
}

/// Memory works across frames: on smooth motion the last witness answers at once.
#[test]
fn a_memory_finds_the_last_witness_again() {
    let a = Tree::new(shapes::torus_knot(2, 3, 0.2, 40));
    let b = Tree::new(shapes::cuboid(Vec3::splat(0.4), 8));
    let mut workspace = Workspace::new();
    let mut memory = PairMemory::new();
    let (mut with, mut without) = (0, 0);
    for frame in 0..20 {
        let shift = DVec3::new(1.0, 1e-4 * f64::from(frame), 0.0);
        let pose = Pose::new(DMat3::IDENTITY, shift).unwrap();
        let query = Query::intersection(&a, &b, pose);
        let all = Budget::unlimited();
        let remembered = run_with_memory(&query, &mut workspace, &mut memory, all);
        let blank = run(&query, &mut workspace, all);
        assert_eq!(blank.stop, StopReason::FirstHit);
        assert_eq!(remembered.stop, StopReason::FirstHit);
        with += remembered.stats.work;
        without += blank.stats.work;
    }
    assert!(2 * with < without, "{with} with, {without} without");
}

/// A memory is part of the input: a stopped run with it resumes to the same bits too.
#[test]
fn a_run_with_memory_resumes_to_the_same_bits() {
    let (a, b, pose) = knot_and_gear();
    let clock = ManualClock::new();
    let (mut whole, mut sliced) = (Workspace::new(), Workspace::new());
    for mode in MODES {
        let query = Query::intersection(&a, &b, pose).mode(mode);
        let mut memory = PairMemory::new();
        for _ in 0..3 {
            let mut copy = memory.clone();
            let all = ENOUGH;
            let full = run_with_memory(&query, &mut whole, &mut memory, all);
            let slice = Budget::work(13);
            let mut outcome = run_with_memory(&query, &mut sliced, &mut copy, slice);
            while outcome.stop == StopReason::WorkLimit {
                outcome = query
                    .with_memory(&mut copy)
                    .resume(&mut sliced, slice.clock(&clock))
                    .unwrap();
            }
            assert_eq!(outcome, full);
            assert_eq!(sliced.pairs(), whole.pairs());
            assert_eq!(copy, memory);
        }
    }
}

#[test]
fn public_types_cross_threads() {
    const fn send_and_sync<T: Send + Sync>() {}
    const fn send<T: Send>() {}
    send_and_sync::<(Aabb, Pose, PoseError, Mesh, MeshError)>();
    send_and_sync::<(Tree, BuildOptions, TreeStats, Subtree<'_>)>();
    send_and_sync::<(
        Query<'_, Intersection>,
        Mode,
        Order,
        Budget,
        Workspace,
        PairMemory,
    )>();
    send_and_sync::<(Answer<Verdict>, Verdict, StopReason, Stats, Certificate<'_>)>();
    #[cfg(feature = "std")]
    send_and_sync::<punctual::clock::SystemClock>();
    send::<ManualClock>();
}
