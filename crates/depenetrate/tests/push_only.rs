//! Each promise of [`PenetrationQuery::push_only`]: what it returns parts the surfaces, gets shorter with the budget, and
//! comes within it; on meshes of all sorts.

#[path = "../../../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use common::random::{Drift, Family, Random, pose_about, soup};
use common::steps::assert_step;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Answer, Budget, Mesh, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes};
use punctual_depenetrate::{
    MAX_PENETRATION_STEP_WORK, Penetration, PenetrationQuery, PenetrationWorkspace,
};

struct Case {
    name: &'static str,
    a: Tree,
    b: Tree,
    pose: Pose,
}

impl Case {
    fn new(name: &'static str, a: Mesh, b: Mesh, pose: Pose) -> Self {
        Self {
            name,
            a: Tree::new(a),
            b: Tree::new(b),
            pose,
        }
    }

    fn query(&self) -> PenetrationQuery<'_> {
        PenetrationQuery::new(&self.a, &self.b, self.pose).push_only(true)
    }

    /// The push of an answer leads where it says, and there the surfaces are apart; infinite without one.
    #[track_caller]
    fn proven_distance(&self, found: &Answer<Penetration>) -> f64 {
        let Penetration {
            low,
            high,
            direction,
            b_in_a,
            ..
        } = found.value;
        assert_eq!(low, 0.0, "{}", self.name);
        let Some(direction) = direction else {
            assert_eq!(b_in_a, self.pose, "{}", self.name);
            return high;
        };
        assert!(
            (direction.length() - 1.0).abs() < 1e-12 && high >= 0.0,
            "{}: {found:?}",
            self.name
        );
        let translation = self.pose.translation() + direction * high;
        let pose = Pose::new(self.pose.rotation(), translation).unwrap();
        assert_eq!(b_in_a, pose, "{}", self.name);
        let verdict = Query::intersection(&self.a, &self.b, b_in_a)
            .run(&mut Workspace::new(), Budget::unlimited())
            .value;
        assert_eq!(verdict, Verdict::Separated, "{}: {found:?}", self.name);
        high
    }
}

fn shifted(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

fn mapped(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Mesh {
    let vertices: Vec<DVec3> = (0..mesh.vertex_count())
        .map(|i| map(mesh.vertex(i)))
        .collect();
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

fn inside_out(mesh: &Mesh) -> Mesh {
    let vertices: Vec<DVec3> = (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect();
    Mesh::from_f64(
        vertices,
        mesh.triangles().iter().map(|&[p, q, r]| [q, p, r]),
    )
    .unwrap()
}

/// One triangle with these corners.
fn triangle(corners: [[f64; 3]; 3]) -> Mesh {
    Mesh::from_f64(corners, [[0, 1, 2]]).unwrap()
}

/// All of them meet.
fn cases() -> Vec<Case> {
    let mut random = Random::new(77);
    let sphere = || shapes::icosphere(2);
    let cube = || shapes::cuboid(Vec3::ONE, 3);
    let knot = || shapes::torus_knot(2, 3, 0.15, 24);
    let turned = pose_about(DVec3::ZERO, 0.4, Drift::Shear, &mut random);
    let far = DVec3::new(1e7, -3e6, 2e7);
    let [huge, tiny] = [1e150, 1e-150];
    let needle = triangle([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.5]]);
    let point = triangle([[0.25, 0.25, 0.0]; 3]);
    let floor = triangle([[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]]);
    let mut dust = |family| soup(family, 60, &mut random);
    vec![
        Case::new("spheres", sphere(), sphere(), shifted(1.8, 0.2, 0.1)),
        Case::new(
            "spheres, one inside out",
            inside_out(&sphere()),
            sphere(),
            shifted(1.8, 0.2, 0.1),
        ),
        Case::new(
            "spheres, inside out",
            inside_out(&sphere()),
            inside_out(&sphere()),
            shifted(1.8, 0.2, 0.1),
        ),
        Case::new("cubes", cube(), cube(), shifted(1.9, 0.3, 0.2)),
        Case::new("flush cubes", cube(), cube(), shifted(2.0, 0.5, 0.25)),
        Case::new("copies", knot(), knot(), Pose::IDENTITY),
        Case::new("knots", knot(), shapes::torus_knot(3, 2, 0.15, 24), turned),
        Case::new(
            "rings",
            shapes::torus(1.0, 0.15, 24),
            shapes::torus(1.0, 0.15, 24),
            shifted(0.4, 0.1, 0.05),
        ),
        Case::new(
            "an open field",
            shapes::height_field(16, 3),
            sphere(),
            Pose::IDENTITY,
        ),
        Case::new(
            "soups",
            dust(Family::Uniform),
            dust(Family::Uniform),
            turned,
        ),
        Case::new(
            "degenerate soups",
            dust(Family::Degenerate),
            dust(Family::Degenerate),
            turned,
        ),
        Case::new(
            "far away",
            mapped(&sphere(), |p| p + far),
            sphere(),
            shifted(far.x + 1.8, far.y, far.z + 0.1),
        ),
        Case::new(
            "huge",
            mapped(&cube(), |p| p * huge),
            mapped(&sphere(), |p| p * huge),
            shifted(1.5 * huge, 0.0, 0.0),
        ),
        Case::new(
            "tiny",
            mapped(&cube(), |p| p * tiny),
            mapped(&sphere(), |p| p * tiny),
            shifted(1.5 * tiny, 0.0, 0.0),
        ),
        Case::new(
            "a tiny one on a huge one",
            mapped(&cube(), |p| p * 1e9),
            sphere(),
            shifted(1e9, 5.0, 7.0),
        ),
        Case::new("a needle", floor.clone(), needle, Pose::IDENTITY),
        Case::new("a point", floor, point.clone(), Pose::IDENTITY),
        Case::new("two points", point.clone(), point, Pose::IDENTITY),
    ]
}

#[test]
fn the_push_parts_the_surfaces() {
    let mut workspace = PenetrationWorkspace::new();
    for case in cases() {
        let found = case.query().run(&mut workspace, Budget::unlimited());
        let distance = case.proven_distance(&found);
        assert!(distance > 0.0 && distance.is_finite(), "{found:?}");
        assert_eq!(
            (found.stop, found.stats.elapsed),
            (StopReason::Finished, None),
            "{}",
            case.name
        );
        // The workspace was used, a fresh one gives the same.
        assert_eq!(
            case.query()
                .run(&mut PenetrationWorkspace::new(), Budget::unlimited()),
            found,
            "{}",
            case.name
        );
    }
}

#[test]
fn the_push_is_about_the_depth() {
    let depths = [
        (
            "spheres",
            2.0 - (1.8f64.powi(2) + 0.2f64.powi(2) + 0.1f64.powi(2)).sqrt(),
        ),
        ("cubes", 0.1),
        ("huge", 0.5e150),
        ("tiny", 0.5e-150),
        ("a needle", 0.5f64.sqrt()),
    ];
    let found_depths = depths.map(|(name, depth)| {
        let case = cases().into_iter().find(|case| case.name == name).unwrap();
        let found = case
            .query()
            .run(&mut PenetrationWorkspace::new(), Budget::unlimited());
        case.proven_distance(&found) / depth
    });
    let [spheres, rest @ ..] = found_depths;
    // They are polyhedra, and so smaller than balls.
    assert!((0.8..1.0).contains(&spheres), "{spheres}");
    assert!(
        rest.iter().all(|share| (0.999..1.02).contains(share)),
        "{rest:?}"
    );
}

/// The normals of a surface that is inside out lead the wrong way; the search finds its way all the same.
#[test]
fn which_side_is_outside_does_not_matter() {
    let distances = ["spheres", "spheres, one inside out", "spheres, inside out"].map(|name| {
        let case = cases().into_iter().find(|case| case.name == name).unwrap();
        case.proven_distance(
            &case
                .query()
                .run(&mut PenetrationWorkspace::new(), Budget::unlimited()),
        )
    });
    let [least, most] = [f64::min, f64::max]
        .map(|of: fn(f64, f64) -> f64| distances.into_iter().reduce(of).unwrap());
    assert!(most < 1.03 * least, "{distances:?}");
}

#[test]
fn more_work_never_gives_a_longer_push() {
    let mut workspace = PenetrationWorkspace::new();
    for case in cases() {
        let whole = case.query().run(&mut workspace, Budget::unlimited());
        let (mut distance, mut budget) = (f64::INFINITY, 0);
        while budget < 2 * whole.stats.work {
            let found = case.query().run(&mut workspace, Budget::work(budget));
            let shorter = case.proven_distance(&found);
            assert!(shorter <= distance, "{budget} {shorter:e} {distance:e}");
            assert_step(found.stats.work, budget, MAX_PENETRATION_STEP_WORK);
            let is_short = found.stats.work < whole.stats.work;
            assert_eq!(
                found.stop,
                if is_short {
                    StopReason::WorkLimit
                } else {
                    StopReason::Finished
                },
                "{}",
                case.name
            );
            (distance, budget) = (shorter, budget * 5 / 4 + 97);
        }
        assert_eq!(distance, whole.value.high, "{}", case.name);
    }
}

#[test]
fn a_deadline_leaves_what_is_proven() {
    let mut workspace = PenetrationWorkspace::new();
    let mut stops = [0, 0];
    for case in cases() {
        for step in 0..48 {
            let clock = ManualClock::ticking(Duration::from_nanos(100));
            let limit = Duration::from_nanos(100).mul_f64((0.5 * f64::from(step)).exp2());
            let found = case
                .query()
                .run(&mut workspace, Budget::time(limit).clock(&clock));
            let distance = case.proven_distance(&found);
            assert!(
                matches!(found.stop, StopReason::Deadline | StopReason::Finished),
                "{}: {found:?}",
                case.name
            );
            assert!(
                found.stats.elapsed.unwrap() <= limit + Duration::from_nanos(500),
                "{}: {found:?}",
                case.name
            );
            stops[usize::from(distance < f64::INFINITY)] +=
                usize::from(found.stop == StopReason::Deadline);
        }
    }
    assert!(stops.iter().all(|&count| count > 20), "{stops:?}");
}

#[test]
fn surfaces_that_are_apart_need_no_push() {
    let empty = || Mesh::new([[0f32; 3]; 0], []).unwrap();
    let sphere = || shapes::icosphere(2);
    let apart = [
        Case::new("apart", sphere(), sphere(), shifted(2.5, 0.0, 0.0)),
        Case::new(
            "one in the other",
            sphere(),
            mapped(&sphere(), |p| p * 0.3),
            Pose::IDENTITY,
        ),
        Case::new("nothing and a sphere", empty(), sphere(), Pose::IDENTITY),
        Case::new("a sphere and nothing", sphere(), empty(), Pose::IDENTITY),
        Case::new("nothing", empty(), empty(), Pose::IDENTITY),
    ];
    for case in apart {
        let found = case
            .query()
            .run(&mut PenetrationWorkspace::new(), Budget::unlimited());
        assert_eq!(case.proven_distance(&found), 0.0, "{}", case.name);
        assert_eq!(found.stop, StopReason::Finished, "{}", case.name);
    }
}

/// Beside blind sampling: the least push along any of 200 directions, by bisection.
#[test]
fn the_push_is_about_the_least_of_sampled_directions() {
    let (mut workspace, mut penetration) = (Workspace::new(), PenetrationWorkspace::new());
    for case in cases().into_iter().take(9) {
        let mut apart = |direction: DVec3, length: f64| {
            let pose = Pose::new(
                case.pose.rotation(),
                case.pose.translation() + direction * length,
            )
            .unwrap();
            let verdict = Query::intersection(&case.a, &case.b, pose)
                .run(&mut workspace, Budget::unlimited())
                .value;
            verdict == Verdict::Separated
        };
        let mut least = 100.0;
        for i in 0..200 {
            let (z, turn) = (1.0 - (2 * i + 1) as f64 / 200.0, i as f64 * 2.399_963);
            let (sin, cos) = turn.sin_cos();
            let direction =
                DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z).normalize();
            let (mut low, mut high) = (0.0, 0.999 * least);
            if !apart(direction, high) {
                continue;
            }
            while high - low > 1e-3 * high && high > 1e-6 {
                let middle = 0.5 * (low + high);
                let end = if apart(direction, middle) {
                    &mut high
                } else {
                    &mut low
                };
                *end = middle;
            }
            least = high;
        }
        let found = case.query().run(&mut penetration, Budget::unlimited());
        let distance = case.proven_distance(&found);
        assert!(distance <= 1.1 * least + 1e-6, "{distance} {least}");
    }
}
