//! Each promise of [`punctual_depenetrate::PenetrationQuery`]: its interval holds the depth whenever it stops, it only
//! shrinks, and it comes within the budget.

#[path = "../../../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use common::files::{self, Soup};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::steps::assert_step;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::tree::Solid;
use punctual::{
    Answer, Budget, BuildOptions, Mesh, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes,
};
use punctual_depenetrate::{
    MAX_PENETRATION_STEP_WORK, Penetration, PenetrationQuery, PenetrationWorkspace,
};

struct Case {
    name: &'static str,
    a: Tree,
    b: Tree,
    pose: Pose,
    solid: bool,
    /// The depth, where it is known.
    depth: Option<f64>,
}

fn tree(mesh: Mesh) -> Tree {
    Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Keep))
}

impl Case {
    fn new(name: &'static str, a: Mesh, b: Mesh, pose: Pose) -> Self {
        Self {
            name,
            a: tree(a),
            b: tree(b),
            pose,
            solid: false,
            depth: None,
        }
    }

    fn solid(self) -> Self {
        Self {
            solid: true,
            ..self
        }
    }

    fn depth(self, depth: f64) -> Self {
        Self {
            depth: Some(depth),
            ..self
        }
    }

    fn query(&self) -> PenetrationQuery<'_> {
        PenetrationQuery::new(&self.a, &self.b, self.pose).solid(self.solid)
    }

    fn pushed(&self, by: DVec3) -> Pose {
        Pose::new(self.pose.rotation(), self.pose.translation() + by).unwrap()
    }

    /// True if an exact query, and for solids a count of solid angles, find them apart after a push.
    fn is_apart_after(&self, by: DVec3, workspace: &mut Workspace) -> bool {
        let pose = self.pushed(by);
        let verdict = Query::intersection(&self.a, &self.b, pose)
            .run(workspace, Budget::unlimited())
            .value;
        verdict == Verdict::Separated && !(self.solid && self.is_contained(&pose))
    }

    /// True if the first corner of one mesh is inside of the other. The surfaces do not meet.
    fn is_contained(&self, pose: &Pose) -> bool {
        let corner = |tree: &Tree| tree.mesh().triangle(0)[0];
        let back = pose.inverse().unwrap();
        winding(self.a.mesh(), pose.transform_point(corner(&self.b))) > 0.5
            || winding(self.b.mesh(), back.transform_point(corner(&self.a))) > 0.5
    }

    #[track_caller]
    fn assert_sound(&self, answer: &Answer<Penetration>, pushes: usize, workspace: &mut Workspace) {
        let Penetration {
            low,
            high,
            direction,
            ..
        } = answer.value;
        let name = self.name;
        assert!(0.0 <= low && low <= high, "{name}: {answer:?}");
        if let Some(depth) = self.depth {
            assert!(
                low <= depth * (1.0 + 1e-9) && depth * (1.0 - 1e-9) <= high,
                "{name}: {answer:?}"
            );
        }
        match direction {
            Some(n) => {
                assert!((n.length() - 1.0).abs() < 1e-12 && high > 0.0, "{name}");
                assert!(self.is_apart_after(n * high, workspace), "{name}");
            }
            None => assert!(high == 0.0 || high == f64::INFINITY, "{name}: {answer:?}"),
        }
        for n in spread(pushes) {
            let by = n * (low * (1.0 - 1e-12));
            assert!(low == 0.0 || !self.is_apart_after(by, workspace), "{name}");
        }
    }
}

/// The winding number, by solid angles.
fn winding(mesh: &Mesh, point: DVec3) -> f64 {
    let angle = |i: usize| {
        let [p, q, r] = mesh.triangle(i).map(|corner| corner - point);
        let (x, y, z) = (p.length(), q.length(), r.length());
        let below = x * y * z + p.dot(q) * z + q.dot(r) * x + r.dot(p) * y;
        2.0 * p.dot(q.cross(r)).atan2(below)
    };
    (0..mesh.len()).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Unit vectors all around.
fn spread(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (i as f64 * 2.399_963).sin_cos();
        let around = (1.0 - z * z).sqrt();
        DVec3::new(cos * around, sin * around, z).normalize()
    })
}

fn shifted(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

fn turned(angle: f64, place: DVec3) -> Pose {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    Pose::new(DMat3::from_quat(DQuat::from_axis_angle(axis, angle)), place).unwrap()
}

fn mapped(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Mesh {
    let vertices: Vec<DVec3> = (0..mesh.vertex_count())
        .map(|i| map(mesh.vertex(i)))
        .collect();
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

/// A cuboid of these extents.
fn cuboid(x: f32, y: f32, z: f32, cells: u32) -> Mesh {
    shapes::cuboid(Vec3::new(x, y, z) * 0.5, cells)
}

/// All of them penetrate each other.
fn cases() -> Vec<Case> {
    let cube = || cuboid(2.0, 2.0, 2.0, 3);
    let sphere = || shapes::icosphere(3);
    let floor = || cuboid(10.0, 10.0, 1.0, 1);
    let far = DVec3::new(1e7, -3e6, 2e7);
    let mut random = Random::new(77);
    let anywhere = pose_about(DVec3::ZERO, 0.4, Drift::Shear, &mut random);
    vec![
        Case::new("cubes", cube(), cube(), shifted(1.9, 0.3, 0.2)).depth(0.1),
        Case::new("cubes, solid", cube(), cube(), shifted(1.5, 0.3, 0.2))
            .solid()
            .depth(0.5),
        Case::new(
            "a crate in a floor",
            floor(),
            cuboid(0.5, 0.5, 0.5, 1),
            shifted(0.3, -0.2, 0.745),
        )
        .solid()
        .depth(0.005),
        Case::new(
            "a fine crate in a floor",
            floor(),
            cuboid(0.5, 0.5, 0.5, 6),
            shifted(0.3, -0.2, 0.7),
        )
        .solid()
        .depth(0.05),
        Case::new(
            "a tilted crate in a floor",
            floor(),
            cube(),
            turned(0.7, DVec3::new(0.1, 0.2, 1.8)),
        )
        .solid(),
        Case::new(
            "plates",
            cuboid(4.0, 4.0, 0.02, 2),
            cuboid(3.0, 3.0, 0.02, 2),
            shifted(0.2, 0.1, 0.015),
        )
        .solid()
        .depth(2.0 * f64::from(0.01_f32) - 0.015),
        Case::new("spheres", sphere(), sphere(), shifted(1.8, 0.2, 0.1)),
        Case::new("deep spheres", sphere(), sphere(), shifted(0.9, 0.2, 0.1)).solid(),
        Case::new(
            "one in the other",
            sphere(),
            cuboid(0.2, 0.2, 0.2, 1),
            shifted(0.3, 0.0, 0.0),
        )
        .solid(),
        Case::new(
            "rings",
            shapes::torus(1.0, 0.15, 24),
            shapes::torus(1.0, 0.15, 24),
            shifted(0.4, 0.1, 0.05),
        ),
        Case::new(
            "linked rings",
            shapes::torus(1.0, 0.3, 24),
            shapes::torus(1.0, 0.3, 24),
            turned(1.5, DVec3::new(1.1, 0.2, 0.1)),
        )
        .solid(),
        Case::new(
            "an open field",
            shapes::height_field(16, 3),
            sphere(),
            Pose::IDENTITY,
        ),
        Case::new(
            "soups",
            soup(Family::Uniform, 60, &mut random),
            soup(Family::Uniform, 60, &mut random),
            anywhere,
        ),
        Case::new(
            "degenerate soups",
            soup(Family::Degenerate, 60, &mut random),
            soup(Family::Degenerate, 60, &mut random),
            anywhere,
        ),
        Case::new(
            "far away",
            mapped(&cube(), |p| p + far),
            cube(),
            shifted(far.x + 1.875, far.y, far.z),
        )
        .solid()
        .depth(0.125),
        Case::new(
            "huge",
            mapped(&cube(), |p| p * 1e150),
            mapped(&cube(), |p| p * 1e150),
            shifted(1.5e150, 1e149, 0.0),
        )
        .depth(0.5e150),
        Case::new(
            "tiny",
            mapped(&cube(), |p| p * 1e-150),
            mapped(&cube(), |p| p * 1e-150),
            shifted(1.5e-150, 1e-151, 0.0),
        )
        .depth(0.5e-150),
        Case::new(
            "a tiny one in a huge one",
            mapped(&cube(), |p| p * 1e6),
            cube(),
            shifted(1e6 + 0.5, 5.0, 7.0),
        )
        .solid()
        .depth(0.5),
    ]
}

#[test]
fn no_shorter_push_separates_and_the_push_does() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    for case in cases() {
        let answer = case.query().run(&mut penetration, Budget::work(20_000_000));
        case.assert_sound(&answer, 1000, &mut workspace);
        assert!(answer.value.high < f64::INFINITY, "{}", case.name);
    }
}

#[test]
fn known_depths_are_found() {
    let mut penetration = PenetrationWorkspace::new();
    for case in cases().into_iter().filter(|case| case.depth.is_some()) {
        let answer = case.query().run(&mut penetration, Budget::work(20_000_000));
        let Penetration { low, high, .. } = answer.value;
        assert!(high <= 1.01 * low, "{}: {answer:?}", case.name);
    }
}

/// A face, an edge or a corner that parts them bounds the push exactly.
#[test]
fn pushes_off_flat_faces_are_exact() {
    let mut penetration = PenetrationWorkspace::new();
    let mut random = Random::new(11);
    let known: Vec<Case> = cases().into_iter().filter(|c| c.depth.is_some()).collect();
    for case in &known {
        for push_only in [false, true] {
            let query = case.query().push_only(push_only);
            let value = query.run(&mut penetration, Budget::work(20_000_000)).value;
            let (high, depth) = (value.high, case.depth.unwrap());
            let nearest = value.direction.unwrap().abs().max_element();
            let roundings = 128.0 * f64::EPSILON * case.pose.translation().length();
            assert!((high - depth).abs() < 1e-6 * depth + roundings, "{value:?}");
            assert!(nearest > 1.0 - 1e-9, "{}: {value:?}", case.name);
        }
    }
    // A corner of the crate is the lowest. The floor is large.
    let floor = tree(cuboid(10.0, 10.0, 1.0, 1));
    let cube = tree(cuboid(2.0, 2.0, 2.0, 3));
    for _ in 0..40 {
        let angle = 3.0 * random.unit();
        let turn = turned(angle, DVec3::ZERO);
        let corners = (0..cube.mesh().vertex_count()).map(|i| cube.mesh().vertex(i));
        let lowest = corners
            .map(|p| turn.transform_point(p).z)
            .fold(0.0, f64::min);
        let depth = 1e-4 + 0.3 * random.unit();
        let pose = turned(angle, DVec3::new(0.1, 0.2, 0.5 - lowest - depth));
        let query = PenetrationQuery::new(&floor, &cube, pose).solid(true);
        for push_only in [false, true] {
            let query = query.push_only(push_only);
            let value = query.run(&mut penetration, Budget::work(20_000_000)).value;
            let direction = value.direction.unwrap();
            assert!((value.high / depth - 1.0).abs() < 1e-6, "{depth} {value:?}");
            assert!((direction - DVec3::Z).length() < 1e-6, "{depth} {value:?}");
        }
    }
}

#[test]
fn spheres_are_as_deep_as_balls() {
    let mut penetration = PenetrationWorkspace::new();
    for case in cases() {
        let distance = match case.name {
            "spheres" => shifted(1.8, 0.2, 0.1).translation().length(),
            "deep spheres" => shifted(0.9, 0.2, 0.1).translation().length(),
            _ => continue,
        };
        let answer = case.query().run(&mut penetration, Budget::work(20_000_000));
        let Penetration { low, high, .. } = answer.value;
        let depth = 2.0 - distance;
        // They are polyhedra, and so smaller than balls.
        assert!(low > 0.9 * depth && high < depth, "{answer:?} {depth}");
    }
}

#[test]
fn both_bounds_only_improve_and_hold_at_every_stop() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    for case in cases() {
        let (mut low, mut high, mut budget) = (0.0, f64::INFINITY, 0);
        while budget < 3_000_000 {
            let answer = case.query().run(&mut penetration, Budget::work(budget));
            case.assert_sound(&answer, 16, &mut workspace);
            let Penetration {
                low: new_low,
                high: new_high,
                ..
            } = answer.value;
            assert!(new_low >= low && new_high <= high, "{budget}");
            assert_step(answer.stats.work, budget, MAX_PENETRATION_STEP_WORK);
            (low, high, budget) = (new_low, new_high, budget * 4 / 3 + 97);
        }
    }
}

/// Random directions and lengths, most of them just below the bound. `PUNCTUAL_PUSHES` of each case
/// and stop, 40 without it.
#[test]
fn no_random_push_below_low_separates() {
    let count = std::env::var("PUNCTUAL_PUSHES").map_or(40, |count| count.parse().unwrap());
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let (mut random, mut tried) = (Random::new(53), 0);
    for case in cases() {
        for work in [30_000, 300_000, 3_000_000] {
            let low = case
                .query()
                .run(&mut penetration, Budget::work(work))
                .value
                .low;
            for i in 0..if low > 0.0 { count } else { 0 } {
                let mut part = || random.signed();
                let direction = DVec3::new(part(), part(), part()).normalize();
                let share = if i % 4 == 0 {
                    part().abs()
                } else {
                    1.0 - 1e-12
                };
                let by = direction * (low * share);
                assert!(!case.is_apart_after(by, &mut workspace), "{by}");
                tried += 1;
            }
        }
    }
    println!("{tried} pushes");
    assert!(tried > 20 * count, "{tried}");
}

#[test]
fn a_resumed_run_ends_with_the_bits_of_an_uninterrupted_one() {
    let (mut penetration, mut other) = (PenetrationWorkspace::new(), PenetrationWorkspace::new());
    let mut compared = 0;
    for case in cases() {
        let query = case.query().relative_tolerance(0.05);
        let whole = query.run(&mut penetration, Budget::work(8_000_000));
        if whole.stop != StopReason::Finished {
            continue;
        }
        compared += 1;
        for piece in [1, 700, 9_000, 120_000] {
            let mut answer = query.run(&mut other, Budget::work(piece));
            for _ in 0..60 {
                if answer.stop == StopReason::WorkLimit {
                    answer = query.resume(&mut other, Budget::work(piece)).unwrap();
                }
            }
            while answer.stop == StopReason::WorkLimit {
                answer = query.resume(&mut other, Budget::work(1_000_003)).unwrap();
            }
            assert_eq!(answer, whole, "{} {piece}", case.name);
        }
    }
    assert!(compared > 8, "{compared}");
}

/// However small its budget, a call does a step.
#[test]
fn every_call_gets_on() {
    let mut penetration = PenetrationWorkspace::new();
    let case = &cases()[0];
    let mut answer = case.query().run(&mut penetration, Budget::work(1));
    for _ in 0..10_000 {
        if answer.stop == StopReason::Finished {
            break;
        }
        let before = answer.stats.work;
        answer = case
            .query()
            .resume(&mut penetration, Budget::work(1))
            .unwrap();
        assert!(answer.stats.work > before, "{answer:?}");
        assert_step(answer.stats.work - before, 1, MAX_PENETRATION_STEP_WORK);
    }
    assert_eq!(answer.stop, StopReason::Finished);
}

#[test]
fn a_deadline_ends_it() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let mut stopped = 0;
    for case in cases() {
        for step in 0..32 {
            let clock = ManualClock::ticking(Duration::from_nanos(100));
            let limit = Duration::from_nanos(100).mul_f64((0.5 * f64::from(step)).exp2());
            let answer = case
                .query()
                .run(&mut penetration, Budget::time(limit).clock(&clock));
            case.assert_sound(&answer, 4, &mut workspace);
            assert!(
                answer.stats.elapsed.unwrap() <= limit + Duration::from_nanos(500),
                "{}: {answer:?}",
                case.name
            );
            stopped += usize::from(answer.stop == StopReason::Deadline);
        }
    }
    assert!(stopped > 100, "{stopped}");
}

#[test]
fn bodies_that_are_apart_have_no_depth() {
    let empty = || Mesh::new([[0f32; 3]; 0], []).unwrap();
    let sphere = || shapes::icosphere(2);
    let small = || mapped(&shapes::icosphere(2), |p| p * 0.3);
    let apart = [
        Case::new("apart", sphere(), sphere(), shifted(2.5, 0.0, 0.0)),
        Case::new("apart, solid", sphere(), sphere(), shifted(2.5, 0.0, 0.0)).solid(),
        Case::new("one in the other", sphere(), small(), Pose::IDENTITY),
        Case::new("nothing and a sphere", empty(), sphere(), Pose::IDENTITY).solid(),
        Case::new("a sphere and nothing", sphere(), empty(), Pose::IDENTITY),
        Case::new("nothing", empty(), empty(), Pose::IDENTITY),
    ];
    let mut penetration = PenetrationWorkspace::new();
    for case in apart {
        let answer = case.query().run(&mut penetration, Budget::unlimited());
        let Penetration {
            low,
            high,
            direction,
            ..
        } = answer.value;
        assert_eq!((low, high, direction), (0.0, 0.0, None), "{}", case.name);
        assert_eq!(answer.stop, StopReason::Finished, "{}", case.name);
        assert!(
            case.query()
                .resume(&mut penetration, Budget::unlimited())
                .is_err()
        );
    }
}

/// As surfaces they are apart at any distance; as solids one has to leave the other.
#[test]
fn a_solid_in_a_solid_is_as_deep_as_its_way_out() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let case = Case::new(
        "a cube in a cube",
        cuboid(4.0, 4.0, 4.0, 1),
        cuboid(0.5, 0.5, 0.5, 1),
        shifted(1.25, 0.25, 0.0),
    );
    let case = case.solid().depth(1.0);
    let answer = case.query().run(&mut penetration, Budget::work(20_000_000));
    case.assert_sound(&answer, 1000, &mut workspace);
    let Penetration { low, high, .. } = answer.value;
    assert!(low > 0.7 && high < 1.02, "{answer:?}");
}

#[test]
fn coincident_surfaces_have_no_low() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let knot = || shapes::torus_knot(2, 3, 0.15, 24);
    for case in [
        Case::new("copies", knot(), knot(), Pose::IDENTITY),
        Case::new(
            "flush cubes",
            cuboid(2.0, 2.0, 2.0, 3),
            cuboid(2.0, 2.0, 2.0, 3),
            shifted(2.0, 0.5, 0.25),
        ),
        Case::new(
            "flush solids",
            cuboid(2.0, 2.0, 2.0, 3),
            cuboid(2.0, 2.0, 2.0, 3),
            shifted(2.0, 0.5, 0.25),
        )
        .solid(),
    ] {
        let answer = case.query().run(&mut penetration, Budget::work(20_000_000));
        case.assert_sound(&answer, 200, &mut workspace);
        if case.name != "copies" {
            assert!(
                answer.value.low == 0.0 && answer.value.high < 1e-6,
                "{answer:?}"
            );
        }
    }
}

#[test]
fn deeper_than_is_decided() {
    let mut penetration = PenetrationWorkspace::new();
    for case in cases() {
        let Some(depth) = case.depth else { continue };
        for (share, expected) in [(0.5, true), (0.9, true), (1.1, false), (3.0, false)] {
            let answer = case
                .query()
                .deeper_than(depth * share)
                .run(&mut penetration, Budget::work(20_000_000));
            assert_eq!(answer.value.deeper, Some(expected), "{} {share}", case.name);
            assert_eq!(answer.stop, StopReason::Finished, "{}", case.name);
        }
    }
}

/// A body inside of a shell that is no solid is apart from it; a tree without solidity still has proven bounds.
#[test]
fn trees_that_are_no_solids_are_surfaces() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let mut case = Case::new(
        "cubes",
        cuboid(2.0, 2.0, 2.0, 3),
        cuboid(2.0, 2.0, 2.0, 3),
        shifted(1.9, 0.3, 0.2),
    );
    (case.a, case.b) = (
        Tree::new(case.a.mesh().clone()),
        Tree::new(case.b.mesh().clone()),
    );
    let case = case.depth(0.1);
    let answer = case.query().run(&mut penetration, Budget::work(20_000_000));
    case.assert_sound(&answer, 1000, &mut workspace);
    assert!(answer.value.low > 0.09, "{answer:?}");
}

/// Scanned and CAD meshes in contact, if the data is beside the repository.
#[test]
fn meshes_in_contact_have_sound_bounds() {
    let Some(shared) = files::shared("meshes") else {
        return;
    };
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let mut shares = Vec::new();
    for folder in files::folders(&shared.join("cases"), "contact_") {
        let case = files::text(&folder.join("case.txt"));
        let [a, b] = ["a", "b"].map(|key| {
            let name = files::value(&case, key).unwrap();
            tree(Soup::read(&folder.join(name)).mesh().unwrap())
        });
        let mut case = Case {
            name: "a mesh",
            a,
            b,
            pose: Pose::IDENTITY,
            solid: false,
            depth: None,
        };
        for pose in files::poses(&folder.join("poses.txt"))
            .into_iter()
            .step_by(29)
        {
            case.pose = pose.unwrap();
            let answer = case.query().run(&mut penetration, Budget::work(2_000_000));
            case.assert_sound(&answer, 40, &mut workspace);
            if answer.value.high > 0.0 {
                shares.push(answer.value.low / answer.value.high);
            }
        }
    }
    shares.sort_by(f64::total_cmp);
    assert!(
        shares.is_empty() || shares[shares.len() / 2] > 0.9,
        "{shares:?}"
    );
}
