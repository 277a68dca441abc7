//! Cases that need no files: generated shapes approach each other at random, up to predefined offsets from the first touch.

use punctual::glam::{DMat3, DQuat, DVec3, EulerRot, Vec3};
use punctual::{Budget, Mesh, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_lab::artificial::Random;
use punctual_lab::report::Failure;

use super::case::{Case, size};

/// Distances past the first touch, in the box diagonal of the smaller mesh.
const OFFSETS: [f64; 7] = [-0.05, -0.02, -0.01, -0.001, 0.001, 0.01, 0.05];

/// Makes a case when it is its turn.
type Maker = Box<dyn FnOnce() -> Result<Case, Failure>>;

pub fn cases(quick: bool) -> Vec<Maker> {
    let fine = u32::from(!quick);
    let approaches = if quick { 4 } else { 12 };
    let make = |name: &'static str, seed: u64, a: fn(u32) -> Mesh, b: fn(u32) -> Mesh| -> Maker {
        Box::new(move || {
            let (a, b) = (a(fine), b(fine));
            let poses = approach(&Tree::new(a.clone()), &Tree::new(b.clone()), approaches, seed);
            Ok(Case::new(name, a, b, poses))
        })
    };
    let gear = |fine: u32| shapes::gear(12, 2 + 2 * fine);
    let knot = |fine: u32| shapes::torus_knot(2, 3, 0.2, 48 << fine);
    vec![
        make("knot_sphere", 1, knot, |fine| shapes::icosphere(3 + fine)),
        make("gear_gear", 2, |fine| shapes::gear(16, 2 + 2 * fine), gear),
        make("torus_torus", 3, |fine| shapes::torus(1.0, 0.2, 40 << fine), |fine| shapes::torus(0.8, 0.3, 40 << fine)),
        make("plate_knot", 4, |fine| shapes::cuboid(Vec3::new(1.0, 0.8, 0.02), 12 << fine), knot),
        make("hills_gear", 5, |fine| shapes::height_field(32 << fine, 1), gear),
        make("hills_hills", 6, |fine| shapes::height_field(32 << fine, 2), |fine| shapes::height_field(32 << fine, 3)),
    ]
}

/// Poses on random lines towards A: one for each offset from the first touch of each approach, turned at random.
fn approach(a: &Tree, b: &Tree, approaches: u64, seed: u64) -> Vec<Pose> {
    let center = |mesh: &Mesh| (mesh.aabb().min + mesh.aabb().max) * 0.5;
    let (from, to) = (center(b.mesh()), center(a.mesh()));
    let reach = size(a.mesh()) + size(b.mesh());
    let unit = size(a.mesh()).min(size(b.mesh()));
    let mut random = Random::new(seed);
    let mut workspace = Workspace::new();
    let mut poses = Vec::new();
    for _ in 0..approaches {
        let angles = [(); 3].map(|()| random.fraction() * std::f64::consts::TAU);
        let turn = DMat3::from_quat(DQuat::from_euler(EulerRot::XYZ, angles[0], angles[1], angles[2]));
        let angle = random.fraction() * std::f64::consts::TAU;
        let z = 2.0 * random.fraction() - 1.0;
        let side = (1.0 - z * z).sqrt();
        let direction = DVec3::new(side * angle.cos(), side * angle.sin(), z);
        let at = |distance: f64| Pose::new(turn, to - turn * from + direction * distance);
        let mut meets = |distance: f64| {
            let Ok(pose) = at(distance) else { return false };
            let outcome = Query::new(a, b, pose).run(&mut workspace, Budget::unlimited());
            matches!(outcome.verdict, Verdict::Intersecting { .. })
        };
        let steps = 400;
        let along = |i: u32| reach * (1.0 - f64::from(i) / f64::from(steps));
        let Some(first) = (1..=steps).find(|&i| meets(along(i))) else { continue };
        let (mut apart, mut touching) = (along(first - 1), along(first));
        for _ in 0..40 {
            let middle = 0.5 * (apart + touching);
            if meets(middle) { touching = middle } else { apart = middle }
        }
        poses.extend(OFFSETS.iter().filter_map(|offset| at(touching + offset * unit).ok()));
    }
    poses
}
