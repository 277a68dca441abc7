//! With denormal numbers flushed to zero, as games set their processors, all answers are what they are without.
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
use punctual::glam::{DMat3, DVec3};
use punctual::{
    Body, Budget, ManualClock, Mesh, Pose, Query, Ray, Scene, StopReason, Tree, Workspace,
};
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
    /// Near the least number that is not taken for zero, above or below.
    NearLeast,
    /// Ordinary ones with tiny and denormal ones among them; and a pose with such entries.
    SomeTiny,
}

const SIZES: [Size; 4] = [
    Size::Ordinary,
    Size::NearF32,
    Size::NearLeast,
    Size::SomeTiny,
];

const FLAGS: [u32; 3] = [
    FLUSH_TO_ZERO,
    DENORMALS_ARE_ZERO,
    FLUSH_TO_ZERO | DENORMALS_ARE_ZERO,
];

fn tiny(random: &mut Random) -> f64 {
    [f64::from_bits(1), 1e-310, 1e-91, 1e-90, 1e-70, 1e-39, 1e-17][random.below(7)]
        * (1.0 + random.below(3) as f64)
        * if random.below(2) == 0 { 1.0 } else { -1.0 }
}

/// The corners of a mesh, and its triangles.
fn soup_of(size: Size, random: &mut Random) -> (Vec<DVec3>, Vec<[u32; 3]>) {
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
        Size::NearLeast => [1e-84, 1e-89, 1e-91, 1e-321][random.below(4)],
        _ => 1.0,
    };
    let vertices = (0..mesh.vertex_count()).map(|i| {
        let mut vertex = scale * mesh.vertex(i);
        if size == Size::SomeTiny && random.below(2) == 0 {
            vertex[random.below(3)] = tiny(random);
        }
        vertex
    });
    (vertices.collect(), mesh.triangles().to_vec())
}

fn mesh(size: Size, (vertices, triangles): &(Vec<DVec3>, Vec<[u32; 3]>)) -> Mesh {
    let triangles = triangles.iter().copied();
    match size {
        // Rounded to f32, so that it is kept so.
        Size::NearF32 => Mesh::new(vertices.iter().map(|v| v.as_vec3()), triangles).unwrap(),
        _ => Mesh::from_f64(vertices.iter().copied(), triangles).unwrap(),
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
        Size::SomeTiny if random.below(3) > 0 => {
            let mut rotation = DMat3::IDENTITY.to_cols_array();
            for entry in [1, 2, 3, 5, 6, 7] {
                rotation[entry] = tiny(random);
            }
            let translation = DVec3::new(tiny(random), 0.0, tiny(random));
            Pose::new(DMat3::from_cols_array(&rotation), translation).unwrap()
        }
        Size::Ordinary => turned,
        _ => Pose::new(*turned.rotation(), DVec3::ZERO).unwrap(),
    }
}

#[test]
fn verdicts_are_true_where_denormal_numbers_are_flushed() {
    let mut random = Random::new(21);
    let mut workspace = Workspace::new();
    for size in SIZES {
        let mut meet = 0;
        for round in 0..1500 {
            let flags = FLAGS[round % 3];
            let soups = [soup_of(size, &mut random), soup_of(size, &mut random)];
            let [a, b] = soups.each_ref().map(|soup| mesh(size, soup));
            let b_in_a = pose(size, &mut random);
            let truth = all_pairs(&a, &b, &b_in_a);
            meet += usize::from(!truth.is_empty());
            let flushed = with_flags(flags, || soups.each_ref().map(|soup| mesh(size, soup)));
            assert_eq!(flushed, [a.clone(), b.clone()]);
            let built_before = [a, b].map(Tree::new);
            for mode in MODES {
                let (outcome, pairs) = with_flags(flags, || {
                    let [a, b] = if round.is_multiple_of(2) {
                        built_before.clone()
                    } else {
                        flushed.clone().map(Tree::new)
                    };
                    run_to_end(
                        &Query::intersection(&a, &b, b_in_a).mode(mode),
                        &mut workspace,
                        ENOUGH,
                    )
                });
                assert_complete(mode, &outcome, &pairs, &truth);
            }
        }
        assert!(meet > 300, "{size:?}: {meet}");
    }
}

/// Products and inverses too: they lose their smallest entries, and so do their products.
#[test]
fn poses_are_the_same_where_denormal_numbers_are_flushed() {
    let mut random = Random::new(25);
    for round in 0..3000 {
        let rows = [
            pose(Size::SomeTiny, &mut random),
            pose(Size::SomeTiny, &mut random),
        ]
        .map(|pose| pose.to_row_major());
        let make = || {
            let [a, b] = rows.map(|rows| Pose::from_row_major(rows).unwrap());
            let inverse = a.inverse().unwrap();
            let product = inverse.compose(&b).unwrap();
            [inverse, product, product.compose(&inverse).unwrap()].map(|pose| pose.to_row_major())
        };
        let made = make();
        assert_eq!(with_flags(FLAGS[round % 3], make), made);
        let entries = made.as_flattened();
        assert!(
            entries
                .iter()
                .all(|x| *x == 0.0 || x.abs() >= 2f64.powi(-300))
        );
    }
}

/// Bounds included, wherever the query stops.
#[test]
fn distances_are_true_where_denormal_numbers_are_flushed() {
    let mut random = Random::new(22);
    let mut workspace = Workspace::new();
    for size in SIZES {
        for round in 0..40 {
            let [a, b] = [0; 2].map(|_| Tree::new(mesh(size, &soup_of(size, &mut random))));
            let b_in_a = pose(size, &mut random);
            let mut truth = distance::Truth::new(&a, &b, &b_in_a);
            let has_tiny =
                |asked: &distance::Question| asked.margins.iter().any(|&x| x > 0.0 && x < 1e-90);
            for asked in truth
                .questions()
                .into_iter()
                .filter(|asked| !has_tiny(asked))
            {
                let query = asked.query(&a, &b, b_in_a);
                let budget = [Budget::work(random.below(4000) as u64), distance::ENOUGH][round % 2];
                let said = with_flags(FLAGS[round % 3], || {
                    distance::run(&query, &mut workspace, budget)
                });
                truth.assert_sound(&asked, &said);
                if said.stop == StopReason::Finished {
                    truth.assert_complete(&asked, &said);
                }
            }
        }
    }
}

#[test]
fn a_scene_says_the_same_where_denormal_numbers_are_flushed() {
    let mut random = Random::new(4);
    let trees: Vec<_> = SIZES
        .iter()
        .map(|&size| Arc::new(Tree::new(mesh(size, &soup_of(size, &mut random)))))
        .collect();
    let mut scenes = [Scene::new(), Scene::new()];
    for tree in &trees {
        for shift in [0.0, 1e-89, 0.5] {
            let pose = Pose::new(DMat3::IDENTITY, DVec3::splat(shift)).unwrap();
            for scene in &mut scenes {
                scene.insert(Body::moving(Arc::clone(tree), pose)).unwrap();
            }
        }
    }
    let mut decided = 0;
    for _ in 0..3 {
        let [plain, flushed] = &mut scenes;
        let detect = |scene: &mut Scene| {
            let report = scene.detect(Budget::unlimited().clock(&ManualClock::new()));
            let pairs = report
                .pairs
                .iter()
                .map(|pair| (pair.a, pair.b, pair.verdict));
            pairs
                .map(|(a, b, verdict)| (a.index(), b.index(), verdict.name()))
                .collect::<Vec<_>>()
        };
        let said = detect(plain);
        assert_eq!(
            with_flags(FLUSH_TO_ZERO | DENORMALS_ARE_ZERO, || detect(flushed)),
            said
        );
        decided += said.len();
    }
    assert!(decided > 90, "{decided}");
}

#[test]
fn rays_hit_the_same_where_denormal_numbers_are_flushed() {
    let clock = ManualClock::new();
    let mut workspace = Workspace::new();
    for scale in [1.0, 1e-30, 1e-40, 1e-89] {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
            .map(|corner| corner.map(|x| x * scale));
        let tree = Tree::new(Mesh::from_f64(corners, [[0, 1, 2]]).unwrap());
        for (x, size) in [0.25, 0.375, 0.75]
            .into_iter()
            .flat_map(|x| [1.0, 1e-30, 1e-89].map(|size| (x, size)))
        {
            let ray = Ray::new([x * scale, 0.5 * scale, scale], [0.0, 0.0, -size]).unwrap();
            let query = Query::ray(&tree, ray);
            let truth = query.run(&mut workspace, Budget::unlimited().clock(&clock));
            assert_eq!(truth.value.hit.is_some(), x <= 0.5);
            let run = || query.run(&mut workspace, Budget::unlimited().clock(&clock));
            assert_eq!(with_flags(FLUSH_TO_ZERO | DENORMALS_ARE_ZERO, run), truth);
        }
    }
}
