//! With denormal numbers flushed to zero, as games set their processors, no verdict is false, and ordinary queries do not
//! notice.
#![cfg(target_arch = "x86_64")]

mod common;
#[path = "common/distance.rs"]
mod distance;
#[path = "common/exact_distance.rs"]
mod exact_distance;
use common::reference;

use common::MODES;
use common::check::{ENOUGH, assert_complete, run_to_end};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::all_pairs;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mesh, Pose, Query, Ray, StopReason, Tree, Verdict, Workspace};
use punctual_scene::{Body, Scene};
use std::sync::Arc;

const FLUSH_TO_ZERO: u32 = 1 << 15;
const DENORMALS_ARE_ZERO: u32 = 1 << 6;

/// Runs `work` with bits of the control and status register set.
fn with_flags<T>(flags: u32, work: impl FnOnce() -> T) -> T {
    let before = control();
    set_control(before | flags);
    let result = work();
    set_control(before);
    result
}

#[allow(
    unsafe_code,
    reason = "the library has none; this is what a program around it does"
)]
fn control() -> u32 {
    let mut register = 0_u32;
    // SAFETY: stores four bytes to a place that is large enough.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack)) };
    register
}

#[allow(
    unsafe_code,
    reason = "the library has none; this is what a program around it does"
)]
fn set_control(register: u32) {
    // SAFETY: loads the value that was stored, but for the two bits above.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack)) };
}

/// How small the numbers of a case are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Size {
    Ordinary,
    /// Near the least normal f32 number, above or below.
    NearF32,
    /// Near the least normal f64 number.
    NearF64,
    /// Ordinary ones with tiny ones among them, most of them within what a query takes; and a pose with such entries.
    SomeTiny,
    /// Ordinary ones with denormal ones among them, of f32 or f64.
    SomeDenormal,
    /// An ordinary mesh, and a pose with denormal entries.
    DenormalPose,
}

fn tiny(size: Size, random: &mut Random) -> f64 {
    let least = match size {
        Size::SomeTiny => [1e-288, 1e-250, 1e-140, 1e-39, 1e-17],
        _ => [f64::from_bits(1), 1e-310, 3e-308, 1e-300, 1e-200],
    };
    least[random.below(5)]
        * (1.0 + random.below(3) as f64)
        * if random.below(2) == 0 { 1.0 } else { -1.0 }
}

fn mesh(size: Size, random: &mut Random) -> Mesh {
    let family = [
        Family::Uniform,
        Family::Degenerate,
        Family::Grid,
        Family::Nested,
        Family::Sliver,
    ][random.below(5)];
    let mesh = soup(family, 12, random);
    let scale = match size {
        Size::NearF32 => [1e-36, 1e-38, 1e-40, 1e-44][random.below(4)],
        Size::NearF64 => [1e-280, 1e-306, 1e-309, 1e-321][random.below(4)],
        _ => 1.0,
    };
    let triangles = mesh.triangles().to_vec();
    let vertices: Vec<DVec3> = (0..mesh.vertex_count())
        .map(|i| {
            let mut vertex = scale * mesh.vertex(i);
            if matches!(size, Size::SomeDenormal | Size::SomeTiny) && random.below(2) == 0 {
                vertex[random.below(3)] = tiny(size, random);
            }
            vertex
        })
        .collect();
    match size {
        // Rounded to f32, so that it is kept so.
        Size::NearF32 => Mesh::new(vertices.iter().map(|v| v.as_vec3()), triangles).unwrap(),
        _ => Mesh::from_f64(vertices, triangles).unwrap(),
    }
}

fn pose(size: Size, random: &mut Random) -> Pose {
    let turned = pose_about(DVec3::ZERO, 0.1, Drift::None, random);
    let turned = if random.below(3) == 0 {
        Pose::IDENTITY
    } else {
        turned
    };
    match size {
        Size::DenormalPose | Size::SomeTiny if random.below(3) > 0 => {
            let mut rotation = DMat3::IDENTITY.to_cols_array();
            for entry in [1, 2, 3, 5, 6, 7] {
                rotation[entry] = tiny(size, random);
            }
            let translation = DVec3::new(tiny(size, random), 0.0, tiny(size, random));
            Pose::new(DMat3::from_cols_array(&rotation), translation).unwrap()
        }
        Size::Ordinary => turned,
        _ => Pose::new(*turned.rotation(), DVec3::ZERO).unwrap(),
    }
}

#[test]
fn no_verdict_is_false_where_denormal_numbers_are_flushed() {
    let mut random = Random::new(21);
    let mut workspace = Workspace::new();
    for size in [
        Size::Ordinary,
        Size::NearF32,
        Size::NearF64,
        Size::SomeTiny,
        Size::SomeDenormal,
        Size::DenormalPose,
    ] {
        let (mut decided, mut refused, mut meet) = (0, 0, 0);
        for round in 0..1500 {
            let [a, b] = [mesh(size, &mut random), mesh(size, &mut random)];
            let b_in_a = pose(size, &mut random);
            let truth = all_pairs(&a, &b, &b_in_a);
            let flags = [
                FLUSH_TO_ZERO,
                DENORMALS_ARE_ZERO,
                FLUSH_TO_ZERO | DENORMALS_ARE_ZERO,
            ][round % 3];
            let built_before = [Tree::new(a.clone()), Tree::new(b.clone())];
            for mode in MODES {
                let (outcome, pairs) = with_flags(flags, || {
                    let [a, b] = if round.is_multiple_of(2) {
                        built_before.clone()
                    } else {
                        [Tree::new(a.clone()), Tree::new(b.clone())]
                    };
                    run_to_end(
                        &Query::intersection(&a, &b, b_in_a).mode(mode),
                        &mut workspace,
                        ENOUGH,
                    )
                });
                if outcome.stop == StopReason::FlushedToZero {
                    assert_eq!(
                        (outcome.value, outcome.stats.found),
                        (Verdict::Undecided, 0)
                    );
                    refused += 1;
                } else {
                    assert_complete(mode, &outcome, &pairs, &truth);
                    (decided, meet) = (decided + 1, meet + usize::from(!truth.is_empty()));
                }
            }
        }
        println!("{size:?}: {decided} decided, {meet} of them meet, {refused} refused");
        assert!(
            meet > 0 || matches!(size, Size::NearF64 | Size::SomeDenormal),
            "{size:?}"
        );
        assert_eq!(refused > 0, size != Size::Ordinary, "{size:?}");
    }
}

/// Bounds included, wherever the query stops.
#[test]
fn no_distance_is_false_where_denormal_numbers_are_flushed() {
    let mut random = Random::new(22);
    let mut workspace = Workspace::new();
    for size in [
        Size::Ordinary,
        Size::NearF32,
        Size::NearF64,
        Size::SomeTiny,
        Size::SomeDenormal,
        Size::DenormalPose,
    ] {
        let (mut told, mut refused) = (0, 0);
        for round in 0..40 {
            let [a, b] = [mesh(size, &mut random), mesh(size, &mut random)].map(Tree::new);
            let b_in_a = pose(size, &mut random);
            let mut truth = distance::Truth::new(&a, &b, &b_in_a);
            let flags = [
                FLUSH_TO_ZERO,
                DENORMALS_ARE_ZERO,
                FLUSH_TO_ZERO | DENORMALS_ARE_ZERO,
            ][round % 3];
            for asked in truth.questions() {
                let query = asked.query(&a, &b, b_in_a);
                let budget = [Budget::work(random.below(4000) as u64), distance::ENOUGH][round % 2];
                let said = with_flags(flags, || distance::run(&query, &mut workspace, budget));
                truth.assert_sound(&asked, &said);
                match said.stop {
                    StopReason::FlushedToZero => {
                        assert_eq!(
                            (said.value.low, said.value.high, said.value.closer),
                            (0.0, f64::INFINITY, None)
                        );
                        refused += 1;
                        let rest = distance::resume(&query, &mut workspace, distance::ENOUGH);
                        truth.assert_complete(&asked, &rest);
                    }
                    StopReason::Finished => truth.assert_complete(&asked, &said),
                    _ => told += 1,
                }
            }
        }
        println!("{size:?}: {told} stopped, {refused} refused");
        assert_eq!(refused > 0, size != Size::Ordinary, "{size:?}");
    }
}

#[test]
fn a_refused_query_goes_on_when_the_flags_are_cleared() {
    let mut random = Random::new(3);
    let tree = Tree::new(mesh(Size::SomeDenormal, &mut random));
    let query = Query::intersection(&tree, &tree, Pose::IDENTITY);
    let mut workspace = Workspace::new();
    let clock = ManualClock::new();
    let outcome = with_flags(DENORMALS_ARE_ZERO, || {
        query.run(&mut workspace, ENOUGH.clock(&clock))
    });
    assert_eq!(
        (outcome.stop, outcome.stats.work),
        (StopReason::FlushedToZero, 0)
    );
    let outcome = query.resume(&mut workspace, ENOUGH.clock(&clock)).unwrap();
    assert_eq!(outcome.stop, StopReason::FirstHit);
}

#[test]
fn a_scene_leaves_open_what_flushing_could_falsify() {
    let mut random = Random::new(4);
    let [small, usual] =
        [Size::NearF64, Size::Ordinary].map(|size| Arc::new(Tree::new(mesh(size, &mut random))));
    let mut scene = Scene::new();
    for tree in [&small, &usual] {
        for _ in 0..2 {
            scene
                .insert(Body::moving(Arc::clone(tree), Pose::IDENTITY))
                .unwrap();
        }
    }
    for _ in 0..3 {
        let report = with_flags(FLUSH_TO_ZERO | DENORMALS_ARE_ZERO, || {
            scene
                .detect(Budget::work(100_000).clock(&ManualClock::new()))
                .clone()
        });
        let known: Vec<bool> = report
            .pairs
            .iter()
            .map(|pair| pair.verdict != Verdict::Undecided)
            .collect();
        // All pairs but that of the usual bodies have a small one.
        assert_eq!(known, [false, false, false, false, false, true]);
    }
    assert_eq!(
        scene
            .detect(Budget::unlimited().clock(&ManualClock::new()))
            .undecided(),
        0
    );
}

/// What a ray hits is the same with the flags, or the query says that it cannot tell.
#[test]
fn rays_that_flushing_could_falsify_are_refused() {
    let clock = ManualClock::new();
    let (mut workspace, mut refused, mut answered) = (Workspace::new(), 0, 0);
    for scale in [1.0, 1e-30, 1e-200, 1e-295, 1e-310] {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
            .map(|corner| corner.map(|x| x * scale));
        let tree = Tree::new(Mesh::from_f64(corners, [[0, 1, 2]]).unwrap());
        for (x, size) in [0.25, 0.375, 0.75]
            .into_iter()
            .flat_map(|x| [1.0, 1e-30, 1e-310].map(|size| (x, size)))
        {
            let ray = Ray::new([x * scale, 0.5 * scale, scale], [0.0, 0.0, -size]).unwrap();
            let query = Query::ray(&tree, ray);
            let truth = query.run(&mut workspace, Budget::unlimited().clock(&clock));
            assert_eq!(truth.value.hit.is_some(), x <= 0.5);
            let run = || query.run(&mut workspace, Budget::unlimited().clock(&clock));
            let cast = with_flags(FLUSH_TO_ZERO | DENORMALS_ARE_ZERO, run);
            if cast.stop == StopReason::FlushedToZero {
                refused += 1;
                assert_eq!((cast.value.hit, cast.value.free_until), (None, 0.0));
                assert_eq!(
                    query
                        .resume(&mut workspace, Budget::unlimited().clock(&clock))
                        .unwrap(),
                    truth
                );
            } else {
                answered += 1;
                assert_eq!(cast, truth);
            }
        }
    }
    assert!(refused >= 9 && answered >= 12, "{refused} {answered}");
}
