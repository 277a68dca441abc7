//! The depth of convex bodies against the truth: the least support of the Minkowski difference over
//! all normals of faces and all products of edges.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::random::Random;
use common::steps::assert_step;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::tree::Solid;
use punctual::{
    Answer, Budget, BuildOptions, Mesh, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes,
};
use punctual_depenetrate::{
    MAX_PENETRATION_STEP_WORK, Penetration, PenetrationQuery, PenetrationWorkspace,
};
use std::time::Duration;

fn solid(mesh: Mesh) -> Tree {
    Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Keep))
}

/// The hull of points in general position: the triples that have all others on one side.
fn hull(points: &[DVec3]) -> Mesh {
    let mut faces = Vec::new();
    let indices = 0..points.len();
    for i in indices.clone() {
        for j in indices.clone().filter(|&j| j > i) {
            for k in indices.clone().filter(|&k| k > i && k != j) {
                let [p, q, r] = [i, j, k].map(|at| points[at]);
                let normal = (q - p).cross(r - p);
                let others = indices.clone().filter(|at| ![i, j, k].contains(at));
                let mut heights = others.map(|at| normal.dot(points[at] - p));
                if heights.all(|height| height < 0.0) {
                    faces.push([i, j, k].map(|at| at as u32));
                }
            }
        }
    }
    Mesh::from_f64(points.iter().copied(), faces).unwrap()
}

/// A hull of points on an ellipsoid.
fn random_hull(count: usize, random: &mut Random) -> Mesh {
    let axes = DVec3::new(1.0, 0.3 + 0.7 * random.unit(), 0.2 + 0.8 * random.unit());
    let mut point = || {
        let mut part = || random.signed();
        DVec3::new(part(), part(), part()).normalize() * axes
    };
    let points: Vec<DVec3> = (0..count).map(|_| point()).collect();
    hull(&points)
}

fn corners(mesh: &Mesh) -> Vec<DVec3> {
    (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect()
}

/// The depth of two convex meshes.
fn depth(a: &Mesh, b: &Mesh, pose: &Pose) -> f64 {
    let placed = |p: DVec3| pose.transform_point(p);
    let of_b: Vec<DVec3> = corners(b).into_iter().map(placed).collect();
    let of_a = corners(a);
    let faces = |mesh: &Mesh, place: &dyn Fn(DVec3) -> DVec3| -> Vec<[DVec3; 3]> {
        (0..mesh.len())
            .map(|i| mesh.triangle(i).map(place))
            .collect()
    };
    let (a, b) = (faces(a, &|p| p), faces(b, &placed));
    let normals = a.iter().chain(&b).map(|[p, q, r]| (q - p).cross(r - p));
    let edges = |faces: &[[DVec3; 3]]| -> Vec<DVec3> {
        let of = |&[p, q, r]: &[DVec3; 3]| [[p, q], [q, r], [r, p]];
        let is_first = |[p, q]: &[DVec3; 2]| p.to_array() < q.to_array();
        faces
            .iter()
            .flat_map(of)
            .filter(is_first)
            .map(|[p, q]| q - p)
            .collect()
    };
    let of_edges = edges(&b);
    let crosses = edges(&a).into_iter().flat_map(|e| {
        of_edges
            .iter()
            .map(move |f| e.cross(*f))
            .collect::<Vec<_>>()
    });
    let mut least = f64::INFINITY;
    for normal in normals.chain(crosses) {
        if normal.length() < 1e-9 {
            continue;
        }
        for n in [normal.normalize(), -normal.normalize()] {
            let [most, fewest] = [&of_a, &of_b].map(|all| all.iter().map(|p| p.dot(n)));
            let reach = most.fold(f64::NEG_INFINITY, f64::max);
            least = least.min(reach - fewest.fold(f64::INFINITY, f64::min));
        }
    }
    least
}

fn random_pose(distance: f64, random: &mut Random) -> Pose {
    let mut part = || random.signed();
    let axis = DVec3::new(part(), part(), part()).normalize();
    let way = DVec3::new(part(), part(), part()).normalize();
    let turn = DQuat::from_axis_angle(axis, 3.0 * part());
    Pose::new(DMat3::from_quat(turn), way * distance).unwrap()
}

/// The push separates, and no random one below `low` does.
#[track_caller]
fn assert_sound(
    [a, b]: [&Tree; 2],
    pose: &Pose,
    answer: &Answer<Penetration>,
    depth: f64,
    workspace: &mut Workspace,
) {
    let Penetration { low, high, .. } = answer.value;
    assert!(low <= depth + 1e-13 && depth <= high + 1e-13, "{depth}");
    let mut verdict = |by: DVec3| {
        let pose = Pose::new(pose.rotation(), pose.translation() + by).unwrap();
        Query::intersection(a, b, pose)
            .run(workspace, Budget::unlimited())
            .value
    };
    if let Some(direction) = answer.value.direction {
        assert_eq!(verdict(direction * high), Verdict::Separated, "{answer:?}");
        assert_ne!(
            verdict(direction * (low * (1.0 - 1e-12))),
            Verdict::Separated,
            "{answer:?}"
        );
    }
}

#[test]
fn hulls_and_boxes_finish_with_the_true_depth() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let (mut random, mut most) = (Random::new(5), 0);
    for i in 0..300 {
        let count = [4, 5, 8, 12, 24][i % 5];
        let [a, b] = [(); 2].map(|()| match i % 3 {
            0 => shapes::cuboid([1.0, 0.1 + random.unit() as f32, 0.7], 1 + i as u32 % 2),
            _ => random_hull(count, &mut random),
        });
        let [a, b] = [a, b].map(solid);
        let pose = random_pose([0.0, 0.2, 0.5, 0.9][i % 4], &mut random);
        let truth = depth(a.mesh(), b.mesh(), &pose).max(0.0);
        let query = PenetrationQuery::new(&a, &b, pose).solid(true);
        let answer = query.run(&mut penetration, Budget::unlimited());
        assert_sound([&a, &b], &pose, &answer, truth, &mut workspace);
        let Penetration { low, high, .. } = answer.value;
        assert!(high <= 1.001 * low + 1e-12, "{i}: {truth} {answer:?}");
        assert_eq!(answer.stop, StopReason::Finished);
        most = most.max(answer.stats.work);
    }
    println!("{most} units");
    assert!(most < 200_000, "{most}");
}

#[test]
fn a_small_body_in_a_large_one_is_as_deep_as_its_way_out() {
    let mut random = Random::new(8);
    let large = solid(random_hull(60, &mut random));
    let small = solid(shapes::cuboid([0.05; 3], 1));
    let mut penetration = PenetrationWorkspace::new();
    let pose = random_pose(0.05, &mut random);
    let truth = depth(large.mesh(), small.mesh(), &pose);
    let query = PenetrationQuery::new(&large, &small, pose);
    let value = query
        .solid(true)
        .run(&mut penetration, Budget::unlimited())
        .value;
    assert!(value.low <= truth && truth <= value.high && value.high < 1.001 * value.low);
    // Its surface is apart from that of the large one.
    let value = query.run(&mut penetration, Budget::unlimited()).value;
    assert_eq!((value.low, value.high, value.direction), (0.0, 0.0, None));
}

/// A box with these least and greatest corners.
fn cuboid(min: [f64; 3], max: [f64; 3]) -> Mesh {
    let [min, max] = [min, max].map(DVec3::from);
    let unit = shapes::cuboid([0.5; 3], 1);
    let place = |i: usize| min + (unit.vertex(i) + 0.5) * (max - min);
    let vertices: Vec<DVec3> = (0..unit.vertex_count()).map(place).collect();
    Mesh::from_f64(vertices, unit.triangles().iter().copied()).unwrap()
}

fn merged(meshes: &[Mesh]) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = vertices.len() as u32;
        vertices.extend(corners(mesh));
        faces.extend(mesh.triangles().iter().map(|face| face.map(|i| first + i)));
    }
    Mesh::from_f64(vertices, faces).unwrap()
}

/// A pipe around z, of the outer radius 1.
fn pipe(inner: f64, sides: u32) -> Mesh {
    let ring = |radius: f64, z: f64| {
        (0..sides).map(move |i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(sides)).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let rings = [(1.0, 0.0), (1.0, 2.0), (inner, 2.0), (inner, 0.0)];
    let vertices: Vec<DVec3> = rings.into_iter().flat_map(|(r, z)| ring(r, z)).collect();
    let quads = (0..4).flat_map(|k| (0..sides).map(move |i| (k, i)));
    let faces = quads.flat_map(|(k, i)| {
        let at = |ring: u32, i: u32| ring % 4 * sides + i % sides;
        let [p, q, r, s] = [at(k, i), at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)];
        [[p, q, r], [p, r, s]]
    });
    Mesh::from_f64(vertices, faces).unwrap()
}

fn shifted(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

/// Bodies that touch, how to sink B into A, and the depth where they touch.
fn touching() -> Vec<(&'static str, Mesh, Mesh, Pose, DVec3, f64)> {
    let wall = || cuboid([0.0; 3], [6.0, 0.2, 3.0]);
    let beam = || cuboid([2.9, -1.0, 1.4], [3.1, 0.0, 1.6]);
    let angle = || {
        let leg = cuboid([0.0; 3], [1.0, 0.2, 3.0]);
        merged(&[leg, cuboid([0.0, 0.2, 0.0], [0.2, 1.0, 3.0])])
    };
    let tube = || pipe(0.8, 24);
    vec![
        (
            "a beam at a wall",
            wall(),
            beam(),
            Pose::IDENTITY,
            DVec3::Y,
            0.0,
        ),
        (
            "flush beams",
            beam(),
            beam(),
            shifted(0.2, 0.0, 0.0),
            -DVec3::X,
            0.0,
        ),
        (
            "a corner on a wall",
            wall(),
            beam(),
            shifted(2.9, 0.0, 0.0),
            DVec3::Y,
            0.0,
        ),
        (
            "angles",
            angle(),
            angle(),
            shifted(0.0, 0.0, 3.0),
            -DVec3::Z,
            0.0,
        ),
        (
            "pipes in a row",
            tube(),
            tube(),
            shifted(0.0, 0.0, 2.0),
            -DVec3::Z,
            0.0,
        ),
        (
            "pipes side by side",
            tube(),
            tube(),
            shifted(2.0, 0.0, 0.5),
            -DVec3::X,
            0.0,
        ),
        (
            "a pipe on a wall",
            wall(),
            tube(),
            shifted(3.0, 1.2, 0.5),
            -DVec3::Y,
            0.0,
        ),
        (
            "a pipe in a pipe",
            pipe(0.8, 24),
            mapped(&tube(), |p| p * 0.8),
            shifted(0.0, 0.0, 0.2),
            DVec3::X,
            // Aside, where they overlap at once. The way out along the axis is longer.
            1.8 * (std::f64::consts::PI / 24.0).cos(),
        ),
    ]
}

#[test]
fn bodies_that_touch_take_no_longer_than_bodies_that_are_sunk_by_a_nanometer() {
    let mut penetration = PenetrationWorkspace::new();
    for (name, a, b, pose, into, depth) in touching() {
        let [a, b] = [a, b].map(solid);
        for solid in [true, false] {
            let mut measure = |sunk: f64| {
                let pose = Pose::new(pose.rotation(), pose.translation() + into * sunk).unwrap();
                let query = PenetrationQuery::new(&a, &b, pose).solid(solid);
                query.run(&mut penetration, Budget::work(100_000_000))
            };
            let (touch, sunk) = (measure(0.0), measure(1e-9));
            assert!(
                touch.value.low <= depth
                    && (0.0..1e-10 + 1e-9 * depth).contains(&(touch.value.high - depth)),
                "{name} {touch:?}"
            );
            assert!(touch.stop == StopReason::Finished, "{name} {touch:?}");
            assert!(2 * touch.stats.work <= 3 * sunk.stats.work, "{name}");
            assert!(sunk.value.high >= 0.99e-9, "{name} {sunk:?}");
        }
    }
}

fn mapped(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Mesh {
    let vertices: Vec<DVec3> = corners(mesh).into_iter().map(map).collect();
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

/// Each triangle with vertices of its own.
fn soup(mesh: &Mesh) -> Mesh {
    let vertices: Vec<DVec3> = (0..mesh.len()).flat_map(|i| mesh.triangle(i)).collect();
    let faces = (0..mesh.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh::from_f64(vertices, faces).unwrap()
}

/// The slack of the only component, if it is convex.
fn slack(mesh: Mesh) -> Option<f64> {
    let tree = solid(mesh);
    let [component] = tree.solid().unwrap().convex() else {
        panic!("several components")
    };
    component.as_ref().map(|convex| convex.slack)
}

#[test]
fn convex_meshes_are_known_whatever_their_rounding_and_indices() {
    let mut random = Random::new(13);
    for i in 0..60 {
        let turn = DMat3::from_quat(DQuat::from_rotation_z(random.unit()));
        let far = DVec3::new(1e5, -3e4, 7.0) * f64::from(i % 2);
        let hull = random_hull(30, &mut random);
        let meshes = [
            shapes::cuboid([1.0, 0.2, 3.0], 1 + i % 5),
            shapes::icosphere(i % 4),
            soup(&hull),
            hull,
            pipe_end(40),
        ];
        for mesh in meshes {
            let turned = mapped(&mesh, |p| turn * p + far);
            let found = slack(turned).unwrap();
            assert!(found < 1e-9, "{found}");
            let rounded = mapped(&mesh, |p| (turn * p).as_vec3().as_dvec3());
            assert!(slack(rounded).unwrap() < 1e-6);
        }
    }
    for size in [1e-150, 1e150] {
        assert_eq!(
            slack(mapped(&shapes::icosphere(2), |p| p * size)),
            Some(0.0)
        );
    }
    // Thousands of narrow faces.
    assert_eq!(slack(pipe_end(5000)), Some(0.0));
    assert_eq!(slack(shapes::icosphere(5)), Some(0.0));
}

/// A prism.
fn pipe_end(sides: u32) -> Mesh {
    let ring = |z: f64| {
        (0..sides).map(move |i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(sides)).sin_cos();
            DVec3::new(cos, sin, z)
        })
    };
    let vertices: Vec<DVec3> = ring(0.0).chain(ring(0.5)).collect();
    let caps = (1..sides - 1).flat_map(|i| [[0, i + 1, i], [sides, sides + i, sides + i + 1]]);
    let sides = (0..sides).flat_map(|i| {
        let next = (i + 1) % sides;
        [[i, next, next + sides], [i, next + sides, i + sides]]
    });
    Mesh::from_f64(vertices, caps.chain(sides)).unwrap()
}

#[test]
fn meshes_that_are_not_convex_are_known() {
    let ball = shapes::icosphere(3);
    let dented = |depth: f64| {
        let first = ball.triangle(17)[0];
        mapped(&ball, |p| if p == first { p * (1.0 - depth) } else { p })
    };
    assert_eq!(slack(dented(0.0)), Some(0.0));
    assert!(slack(dented(0.04)).is_none_or(|slack| slack > 1e-3));
    let inside_out = ball.triangles().iter().map(|&[p, q, r]| [q, p, r]);
    for mesh in [
        shapes::torus(1.0, 0.3, 24),
        pipe(0.7, 12),
        dented(0.3),
        Mesh::from_f64(corners(&ball), inside_out).unwrap(),
        Mesh::from_f64(corners(&ball), ball.triangles()[1..].iter().copied()).unwrap(),
        shapes::height_field(8, 1),
        // Flat, and no more than a point.
        mapped(&ball, |p| p * DVec3::new(1.0, 1.0, 0.0)),
        mapped(&ball, |_| DVec3::ONE),
    ] {
        assert_eq!(slack(mesh), None);
    }
    // Twice around the same center, joined along two edges.
    let twice = Mesh::from_f64(
        corners(&ball),
        ball.triangles().iter().chain(ball.triangles()).copied(),
    );
    assert!(
        solid(twice.unwrap())
            .solid()
            .unwrap()
            .convex()
            .iter()
            .all(Option::is_none)
    );
}

/// Decomposed meshes: the deepest pair of pieces decides here.
#[test]
fn convex_pieces_finish_tight() {
    let (mut penetration, mut workspace) = (PenetrationWorkspace::new(), Workspace::new());
    let table = merged(&[
        cuboid([0.0, 0.0, 1.0], [2.0, 1.0, 1.1]),
        cuboid([0.0, 0.0, 0.0], [0.1, 0.1, 1.0]),
        cuboid([1.9, 0.9, 0.0], [2.0, 1.0, 1.0]),
    ]);
    let bell = merged(&[
        cuboid([-0.5, -0.1, -0.1], [0.5, 0.1, 0.1]),
        mapped(&shapes::icosphere(2), |p| p * 0.3 + DVec3::X * 0.7),
        mapped(&shapes::icosphere(2), |p| p * 0.3 - DVec3::X * 0.7),
    ]);
    let [a, b] = [table, bell].map(solid);
    for depth in [1e-4, 0.01, 0.05] {
        // The lowest corners of the balls decide.
        let level = shifted(1.0, 0.5, 0.0);
        let pose = shifted(1.0, 0.5, 1.1 - depth - lowest(&b, level));
        for is_solid in [true, false] {
            let query = PenetrationQuery::new(&a, &b, pose).solid(is_solid);
            let answer = query.run(&mut penetration, Budget::work(30_000_000));
            let Penetration { low, high, .. } = answer.value;
            assert!(low <= depth + 1e-12 && depth <= high * 1.0001, "{depth}");
            if is_solid {
                assert!(
                    high <= 1.001 * low && answer.stop == StopReason::Finished,
                    "{answer:?}"
                );
            }
            if let Some(direction) = answer.value.direction {
                let pose = Pose::new(pose.rotation(), pose.translation() + direction * high);
                let query = Query::intersection(&a, &b, pose.unwrap());
                let verdict = query.run(&mut workspace, Budget::unlimited()).value;
                assert_eq!(verdict, Verdict::Separated);
            }
        }
    }
}

fn lowest(tree: &Tree, pose: Pose) -> f64 {
    let heights = corners(tree.mesh())
        .into_iter()
        .map(|p| pose.transform_point(p).z);
    heights.fold(f64::INFINITY, f64::min)
}

/// Boxes flush with boxes, needles and plates, far from the origin, of all sizes.
#[test]
fn degenerate_bodies_finish_with_the_true_depth() {
    let mut penetration = PenetrationWorkspace::new();
    let mut random = Random::new(21);
    for i in 0..240 {
        let thin = [1.0, 1e-2, 1e-3][i % 3];
        let [a, b] = [0, 1].map(|k| match (i + k) % 4 {
            0 => shapes::cuboid([1.0, 0.5, 0.25], 1 + i as u32 % 3),
            1 => pipe_end(12),
            2 => mapped(&random_hull(12, &mut random), |p| {
                p * DVec3::new(1.0, thin, thin)
            }),
            _ => soup(&mapped(&random_hull(20, &mut random), |p| {
                p * DVec3::new(1.0, 1.0, thin)
            })),
        });
        let size = [1e-9, 1.0, 1e9, 1e-150, 1e120][i % 5];
        let far = DVec3::new(3e3, -1e3, 50.0) * f64::from(i as u32 % 2);
        let pose = match i % 7 {
            0 => shifted(1.0, 0.5, 0.25),
            1 => shifted(0.0, 0.0, 0.0),
            2 => shifted(1.5, 0.0, 0.125),
            _ => random_pose([0.0, 0.2, 0.5, 0.9][i % 4], &mut random),
        };
        // About the origin at size 1; the bodies are the same up to rounding.
        let truth = depth(&a, &b, &pose).max(0.0) * size;
        let pose = Pose::new(pose.rotation(), (pose.translation() + far) * size).unwrap();
        let a = solid(mapped(&a, |p| (p + far) * size));
        let b = solid(mapped(&b, |p| p * size));
        let query = PenetrationQuery::new(&a, &b, pose).solid(true);
        let answer = query.run(&mut penetration, Budget::work(100_000_000));
        let Penetration { low, high, .. } = answer.value;
        let rounding = if far == DVec3::ZERO { 1e-13 } else { 1e-11 } * size;
        assert!(low <= truth + rounding && truth <= high + rounding, "{i}");
        assert!(high <= 1.001 * low + 200.0 * rounding, "{i}");
        assert!(
            answer.stop == StopReason::Finished && answer.stats.work < 200_000,
            "{i}: {answer:?}"
        );
    }
}

/// Meshes of all sorts, of which few are convex.
fn sorts() -> Vec<Mesh> {
    let triangle = [DVec3::X, DVec3::Y, DVec3::Z];
    let ball = shapes::icosphere(4);
    let half = ball.triangles()[..ball.len() / 2].iter().copied();
    let near = |mesh: &Mesh| mapped(mesh, |p| p * 0.4 + DVec3::splat(0.3));
    vec![
        Mesh::from_f64([DVec3::ZERO; 0], []).unwrap(),
        Mesh::from_f64(triangle, [[0, 1, 2]]).unwrap(),
        Mesh::from_f64([DVec3::ONE; 3], [[0, 1, 2]]).unwrap(),
        Mesh::from_f64(corners(&ball), half).unwrap(),
        shapes::height_field(40, 3),
        shapes::torus_knot(2, 3, 0.2, 64),
        ball.clone(),
        merged(&[
            ball.clone(),
            near(&ball),
            shapes::cuboid([1.2, 0.1, 0.1], 1),
        ]),
        pipe_end(2000),
    ]
}

#[test]
fn a_budget_of_work_is_passed_by_less_than_a_step_whatever_the_shapes() {
    let mut penetration = PenetrationWorkspace::new();
    for size in [1.0, 1e295] {
        let trees: Vec<Tree> = sorts()
            .iter()
            .map(|mesh| solid(mapped(mesh, |p| p * size)))
            .collect();
        for (i, a) in trees.iter().enumerate() {
            for b in &trees[..=i] {
                let turn = DMat3::from_rotation_y(0.4);
                let pose = Pose::new(turn, DVec3::new(0.5, 0.3, 0.2) * size).unwrap();
                for solid in [false, true] {
                    let query = PenetrationQuery::new(a, b, pose).solid(solid);
                    let mut answer = query.run(&mut penetration, Budget::work(0));
                    let (mut low, mut high) = (0.0, f64::INFINITY);
                    assert_step(answer.stats.work, 0, MAX_PENETRATION_STEP_WORK);
                    for budget in [1, 3, 97, 800, 4_000, 20_000].repeat(12) {
                        if answer.stop == StopReason::Finished {
                            break;
                        }
                        let before = answer.stats.work;
                        answer = query
                            .resume(&mut penetration, Budget::work(budget))
                            .unwrap();
                        assert_step(
                            answer.stats.work - before,
                            budget,
                            MAX_PENETRATION_STEP_WORK,
                        );
                        assert!(
                            answer.value.low >= low && answer.value.high <= high,
                            "{answer:?}"
                        );
                        (low, high) = (answer.value.low, answer.value.high);
                    }
                    for nanoseconds in [0, 1, 1_000] {
                        let limit = Duration::from_nanos(nanoseconds);
                        let cut = query.run(&mut penetration, Budget::time(limit)).value;
                        assert!(cut.low <= high && low <= cut.high, "{cut:?} {answer:?}");
                    }
                }
            }
        }
    }
}
