//! Contact manifolds of solids: normals and depths of cases whose truth is known, apart and sunk, in
//! one list; ids that last; the same bits however a query is cut; nothing false at a stop.

#[path = "common/steps.rs"]
mod steps;

use oorandom::Rand64;
use punctual::contacts::Manifold;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::tree::Solid;
use punctual::{
    Budget, BuildOptions, Mesh, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes,
};
use std::f64::consts::{FRAC_PI_4, SQRT_2, TAU};
use steps::assert_step;

fn solid(mesh: Mesh) -> Tree {
    Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Keep))
}

fn cuboid(half: [f32; 3], cells: u32) -> Tree {
    solid(shapes::cuboid(half, cells))
}

fn at(rotation: DMat3, place: DVec3) -> Pose {
    Pose::new(rotation, place).expect("a rotation")
}

fn between(random: &mut Rand64, low: f64, high: f64) -> f64 {
    low + (high - low) * random.rand_float()
}

fn degrees(x: DVec3, y: DVec3) -> f64 {
    x.cross(y).length().atan2(x.dot(y)).to_degrees()
}

/// The manifolds of a finished query.
fn manifolds(a: &Tree, b: &Tree, pose: Pose, skin: f64) -> Vec<Manifold> {
    let mut workspace = Workspace::new();
    let query = Query::manifolds(a, b, pose).skin(skin);
    let answer = query.run(&mut workspace, Budget::unlimited());
    assert_eq!(answer.stop, StopReason::Finished);
    assert_eq!(answer.value.low, f64::INFINITY);
    for manifold in workspace.manifolds() {
        assert!(manifold.points().len() <= 4 && !manifold.points().is_empty());
        for point in manifold.points() {
            let between = point.points[0] - point.points[1];
            assert!(
                (between - point.distance * point.normal).length() < 1e-9,
                "{point:?}"
            );
            assert!(manifold.distance <= point.distance);
        }
    }
    workspace.manifolds().to_vec()
}

/// Largest angle of a normal of any point to the true one.
fn worst_normal(manifolds: &[Manifold], truth: DVec3) -> f64 {
    let points = manifolds.iter().flat_map(Manifold::points);
    points
        .map(|point| degrees(point.normal, truth))
        .fold(0.0, f64::max)
}

/// Height of the lowest vertex at a pose.
fn lowest(tree: &Tree, rotation: DMat3) -> f64 {
    let vertices = (0..tree.mesh().vertex_count()).map(|i| (rotation * tree.mesh().vertex(i)).z);
    vertices.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_crate_in_a_floor_has_the_normal_of_the_floor_and_its_depth() {
    let mut random = Rand64::new(1);
    let floor = cuboid([0.5, 0.5, 0.05], 1);
    let top = floor.mesh().aabb().max.z;
    for (cells, tilt) in [
        (1, 0.0),
        (6, 0.0),
        (1, 0.0035),
        (6, 0.0035),
        (1, 0.2),
        (6, 0.2),
    ] {
        let crate_ = cuboid([0.1; 3], cells);
        for trial in 0..200 {
            let axis = DVec3::new(1.0, random.rand_float(), 0.0).normalize();
            let turn = DQuat::from_axis_angle(axis, tilt * random.rand_float())
                * DQuat::from_rotation_z(TAU * random.rand_float());
            let rotation = DMat3::from_quat(turn);
            let depth = if trial == 0 {
                0.0
            } else {
                between(&mut random, 0.0, 5e-3)
            };
            let place = DVec3::new(
                between(&mut random, -0.3, 0.3),
                between(&mut random, -0.3, 0.3),
                top - lowest(&crate_, rotation) - depth,
            );
            let skin = [0.0, 0.002, 0.01][trial % 3];
            let found = manifolds(&floor, &crate_, at(rotation, place), skin);
            if trial > 0 {
                assert!(
                    found[0].is_overlap && found[0].is_whole,
                    "{trial}: {found:?}"
                );
                let is_right = (found[0].distance + depth).abs() < 1e-9;
                assert!(is_right, "{trial}: {} for {depth}", found[0].distance);
            }
            let worst = worst_normal(&found, -DVec3::Z);
            assert!(
                worst < 0.01,
                "{trial}: {worst} degrees, tilt {tilt}, skin {skin}"
            );
            if tilt == 0.0 && depth > 1e-9 {
                assert!(
                    (found[0].area - 0.04).abs() < 1e-6,
                    "{trial}: {}",
                    found[0].area
                );
                assert_eq!(found[0].points().len(), 4);
            }
        }
    }
}

#[test]
fn thin_plates_are_as_deep_as_they_are() {
    let mut random = Rand64::new(2);
    let plate = cuboid([0.1, 0.1, 0.0005], 4);
    for (depth, skin) in [(5e-4, 0.0), (8e-4, 0.0), (5e-4, 0.002)] {
        for _ in 0..50 {
            let rotation = DMat3::from_rotation_z(TAU * random.rand_float());
            let (x, y) = (
                between(&mut random, 0.0, 0.05),
                between(&mut random, 0.0, 0.05),
            );
            let pose = at(rotation, DVec3::new(x, y, 0.001 - depth));
            let found = manifolds(&plate, &plate, pose, skin);
            let worst = worst_normal(&found, -DVec3::Z);
            assert!(worst < 0.5, "{worst} degrees at {x}, {y}");
            let ratio = -found[0].distance / depth;
            assert!((0.99..1.01).contains(&ratio), "{ratio} of the depth");
        }
    }
}

#[test]
fn spheres_part_along_the_line_of_their_centers() {
    let mut random = Rand64::new(3);
    let ball = solid(shapes::icosphere(4));
    let mut ratios = Vec::new();
    for trial in 0..50 {
        let [x, y, z] = [(); 3].map(|()| between(&mut random, -1.0, 1.0));
        let Some(way) = DVec3::new(x, y, z).try_normalize() else {
            continue;
        };
        let pose = at(DMat3::IDENTITY, 1.7 * way);
        let found = manifolds(&ball, &ball, pose, [0.0, 0.01][trial % 2]);
        let worst = worst_normal(&found, -way);
        assert!(worst < 0.5, "{worst} degrees");
        ratios.push(-found[0].distance / 0.3);
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!((0.99..1.01).contains(&median), "{median}");
}

#[test]
fn every_pose_of_closed_surfaces_that_meet_has_a_manifold() {
    let mut random = Rand64::new(4);
    let solids = [
        solid(shapes::icosphere(2)),
        solid(shapes::torus(0.7, 0.25, 24)),
        cuboid([0.5, 0.8, 0.3], 3),
        solid(shapes::gear(9, 1)),
    ];
    let mut workspace = Workspace::new();
    let (mut meetings, mut normals) = (0, 0);
    for trial in 0..600 {
        let (a, b) = (&solids[trial % 4], &solids[trial / 4 % 4]);
        let turn = DQuat::from_euler(
            punctual::glam::EulerRot::XYZ,
            TAU * random.rand_float(),
            TAU * random.rand_float(),
            TAU * random.rand_float(),
        );
        let place = DVec3::from_array([(); 3].map(|()| between(&mut random, -1.0, 1.0)));
        let pose = at(DMat3::from_quat(turn), place);
        let contacts = Query::contacts(a, b, pose);
        let meets = contacts
            .run(&mut workspace, Budget::unlimited())
            .stats
            .found
            > 0;
        let found = manifolds(a, b, pose, 0.0);
        assert_eq!(meets, !found.is_empty(), "{trial}");
        assert!(
            found
                .iter()
                .all(|one| one.is_overlap && one.distance <= 0.0)
        );
        meetings += usize::from(meets);
        normals += usize::from(found.iter().any(|one| one.normal != DVec3::ZERO));
    }
    assert!(
        meetings > 200 && normals as f64 > 0.95 * meetings as f64,
        "{normals} of {meetings}"
    );
}

#[test]
fn solids_apart_have_the_corners_of_their_common_area() {
    let floor = cuboid([2.0, 2.0, 0.5], 1);
    for cells in [1, 5] {
        let crate_ = cuboid([0.5; 3], cells);
        let pose = at(DMat3::from_rotation_z(0.3), DVec3::new(0.2, -0.1, 1.01));
        let found = manifolds(&floor, &crate_, pose, 0.02);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(worst_normal(&found, -DVec3::Z) < 1e-6 && (found[0].area - 1.0).abs() < 1e-6);
        let corners = [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]];
        for [x, y] in corners {
            let corner = pose.transform_point([x, y, -0.5]);
            let is_it = |point: &DVec3| (*point - corner).length() < 1e-6;
            let points = found[0].points();
            assert!(
                points.iter().any(|point| is_it(&point.points[1])),
                "{found:?}"
            );
        }
        assert!(
            found[0]
                .points()
                .iter()
                .all(|point| (point.distance - 0.01).abs() < 1e-6)
        );
    }
    // Half of it beyond the edge of the floor: the corners of what is over the floor.
    let pose = at(DMat3::IDENTITY, DVec3::new(2.0, 0.0, 1.01));
    let found = manifolds(&floor, &cuboid([0.5; 3], 1), pose, 0.02);
    assert!(worst_normal(&found, -DVec3::Z) < 1e-6 && (found[0].area - 0.5).abs() < 1e-6);
}

/// Area of the lowest faces of a body that stands on them.
fn foot_area(body: &Tree) -> f64 {
    let lowest = body.mesh().aabb().min.z;
    let triangles = (0..body.mesh().len()).map(|i| body.mesh().triangle(i));
    let on_it = triangles.filter(|corners| corners.iter().all(|p| p.z < lowest + 1e-6));
    on_it
        .map(|[p, q, r]| 0.5 * (q - p).cross(r - p).length())
        .sum()
}

/// A gear, a knot and a ball.
fn uneven() -> Vec<Tree> {
    let meshes = [
        shapes::gear(11, 2),
        shapes::torus_knot(2, 3, 0.45, 40),
        shapes::icosphere(3),
    ];
    meshes.map(solid).into()
}

#[test]
fn pairs_without_a_closer_look_add_nothing() {
    let mut random = Rand64::new(9);
    let bodies = uneven();
    let mut workspace = Workspace::new();
    for trial in 0..90 {
        let body = &bodies[trial % 3];
        let size = body.mesh().aabb().extents().length();
        let floor = cuboid([size as f32; 3], [1, 12, 40][trial / 3 % 3]);
        let tilt = [0.0, 0.003, 0.5][trial / 9 % 3];
        let rotation =
            DMat3::from_rotation_x(tilt) * DMat3::from_rotation_z(TAU * random.rand_float());
        let (skin, gap) = (0.02 * size, between(&mut random, 0.001, 0.01) * size);
        let pose = at(rotation, DVec3::Z * (size + gap - lowest(body, rotation)));
        let query = Query::contacts(&floor, body, pose).margin(skin);
        workspace.reserve_contacts(1 << 20);
        let contacts = query.run(&mut workspace, Budget::unlimited());
        assert_eq!(contacts.stop, StopReason::Finished);
        let contacts: Vec<_> = workspace.contacts().copied().collect();
        let found = manifolds(&floor, body, pose, skin);
        let [nearest, least] = [contacts[0].distance, found[0].distance];
        assert!(nearest * (1.0 - 1e-9) <= least && least <= 1.002 * nearest);
        if trial % 3 == 0 && tilt == 0.0 {
            let foot = foot_area(body);
            assert!(
                (found[0].area / foot - 1.0).abs() < 1e-6,
                "{} of {foot}",
                found[0].area
            );
        }
    }
}

#[test]
fn of_pairs_beside_closer_ones_the_closest_stays() {
    let mut random = Rand64::new(10);
    let mut bodies = uneven();
    bodies.push(cuboid([0.7, 0.5, 0.9], 1));
    let mut workspace = Workspace::new();
    for trial in 0..96 {
        let (a, b) = (&bodies[trial % 4], &bodies[trial / 4 % 4]);
        let skin = 0.02 * a.mesh().aabb().extents().length();
        let axis = DVec3::from([0; 3].map(|_| between(&mut random, -1.0, 1.0))).normalize();
        let turn = DMat3::from_axis_angle(axis, TAU * random.rand_float());
        let (mut pose, gap) = (at(turn, 9.0 * axis), between(&mut random, 0.05, 0.9) * skin);
        let mut distance = f64::INFINITY;
        while distance > 1.01 * gap {
            let query = Query::distance(a, b, pose);
            distance = query.run(&mut workspace, Budget::unlimited()).value.low;
            pose = at(turn, pose.translation() - (distance - gap) * axis);
        }
        let query = Query::contacts(a, b, pose).margin(skin);
        assert!(
            query
                .run(&mut workspace, Budget::unlimited())
                .stop
                .is_final()
        );
        let truth = workspace.contacts().next().expect("within").distance;
        let found = manifolds(a, b, pose, skin);
        // Along the normal of a face the distance may be less, by a factor of cos .8 degrees.
        let least = found[0].distance;
        assert!(
            0.9998 * truth <= least && least <= 1.002 * truth,
            "{least} {truth}, trial {trial}"
        );
    }
}

#[test]
fn the_nearest_contact_is_told_on_an_inner_side_too() {
    let mut workspace = Workspace::new();
    let (room, ball) = (cuboid([1.02; 3], 8), solid(shapes::icosphere(3)));
    let query = Query::manifolds(&ball, &room, at(DMat3::IDENTITY, DVec3::X * 0.01)).skin(0.02);
    let answer = query.run(&mut workspace, Budget::unlimited()).value;
    let (_, nearest) = answer.nearest.expect("within the skin");
    assert!(!answer.meets && workspace.manifolds().is_empty());
    let query = Query::distance(&ball, &room, at(DMat3::IDENTITY, DVec3::X * 0.01));
    let truth = query
        .surfaces()
        .run(&mut workspace, Budget::unlimited())
        .value;
    assert!(truth.low <= nearest * (1.0 + 1e-9) && nearest <= 1.002 * truth.high);
}

#[test]
fn internal_edges_of_flat_meshes_leave_no_ghost_normals() {
    let mut random = Rand64::new(5);
    let floor = cuboid([2.0, 2.0, 0.5], 40);
    let solids = [
        cuboid([0.2; 3], 1),
        cuboid([0.2; 3], 7),
        solid(shapes::icosphere(3)),
    ];
    for trial in 0..90 {
        let body = &solids[trial % 3];
        let (place, size) = if trial % 3 == 2 {
            (1.5, 1.0)
        } else {
            (0.7, 0.2)
        };
        let tilt = if trial % 2 == 0 {
            0.0
        } else {
            0.05 * random.rand_float()
        };
        let rotation =
            DMat3::from_rotation_x(tilt) * DMat3::from_rotation_z(TAU * random.rand_float());
        let height = if trial % 3 == 2 {
            place
        } else {
            0.5 - lowest(body, rotation)
        };
        let gap = between(&mut random, -0.01, 0.01) * size;
        let pose = at(
            rotation,
            DVec3::new(
                between(&mut random, -1.0, 1.0),
                between(&mut random, -1.0, 1.0),
                height + gap,
            ),
        );
        let found = manifolds(&floor, body, pose, 0.02 * size);
        assert!(!found.is_empty(), "{trial}");
        let worst = worst_normal(&found, -DVec3::Z);
        assert!(
            worst < if trial % 3 == 2 { 3.0 } else { 0.01 },
            "{trial}: {worst} degrees"
        );
    }
}

#[test]
fn edges_and_corners_have_the_normals_that_part_them() {
    let cube = cuboid([0.5; 3], 1);
    let (rx, ry) = (
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_y(FRAC_PI_4),
    );
    // Roof on roof: the normal is across both edges.
    for depth in [-0.01, 0.0, 1e-3, 0.1] {
        let place = DVec3::new(0.05, 0.03, SQRT_2 - depth);
        let found = manifolds(
            &cube,
            &cube,
            at(rx.transpose() * ry, rx.transpose() * place),
            0.02,
        );
        let worst = worst_normal(&found, rx.transpose() * -DVec3::Z);
        assert!(found.len() == 1 && worst < 1e-4, "{depth}: {worst} degrees");
        assert!(
            (found[0].distance + depth).abs() < 1e-9,
            "{depth}: {}",
            found[0].distance
        );
    }
    // A corner that points down, over a face and into it.
    let floor = cuboid([2.0, 2.0, 0.5], 1);
    let corner = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::ONE.normalize(), -DVec3::Z));
    for depth in [-0.01, 1e-3, 0.05] {
        let height = 0.5 - lowest(&cube, corner) - depth;
        let found = manifolds(
            &floor,
            &cube,
            at(corner, DVec3::new(0.3, 0.2, height)),
            0.02,
        );
        assert!(
            found.len() == 1 && worst_normal(&found, -DVec3::Z) < 1e-4,
            "{found:?}"
        );
        assert!(
            (found[0].distance + depth).abs() < 1e-9,
            "{depth}: {}",
            found[0].distance
        );
    }
}

#[test]
fn a_pin_through_a_plate_has_no_normal() {
    let plate = cuboid([0.5, 0.5, 0.05], 1);
    for cells in [1, 3, 12] {
        let pin = cuboid([0.01, 0.01, 0.3], cells);
        for skin in [0.0, 0.002] {
            let found = manifolds(
                &plate,
                &pin,
                at(DMat3::IDENTITY, DVec3::new(0.1, 0.1, 0.02)),
                skin,
            );
            assert!(
                !found.is_empty() && found.iter().all(|one| one.is_overlap),
                "{found:?}"
            );
            assert!(
                found.iter().all(|one| one.normal == DVec3::ZERO),
                "{cells}: {found:?}"
            );
        }
    }
}

#[test]
fn a_foot_that_is_sunk_and_apart_is_one_manifold() {
    let floor = cuboid([0.5, 0.5, 0.05], 1);
    let crate_ = cuboid([0.1; 3], 4);
    let rotation = DMat3::from_rotation_x(0.01);
    let height = 0.05_f32 as f64 - lowest(&crate_, rotation) - 5e-4;
    let found = manifolds(&floor, &crate_, at(rotation, DVec3::Z * height), 0.004);
    assert!(worst_normal(&found, -DVec3::Z) < 1e-4, "{found:?}");
    let [foot] = &found[..] else {
        panic!("{found:?}")
    };
    assert!(foot.is_overlap && (foot.distance + 5e-4).abs() < 1e-9);
    assert!(
        foot.points().len() == 4 && (foot.area - 0.04).abs() < 1e-4,
        "{foot:?}"
    );
    let points = foot.points().iter();
    let highest = points.map(|point| point.distance).fold(0.0, f64::max);
    assert!(
        highest > 1e-3,
        "{highest}: the far edge is 1.5 mm above the floor"
    );
}

#[test]
fn ids_last_while_a_body_slides_and_sinks() {
    let (floor, crate_) = (cuboid([2.0, 2.0, 0.5], 20), cuboid([0.25; 3], 3));
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let mut known: Option<(u64, Vec<u64>)> = None;
    for frame in 0..60 {
        let t = f64::from(frame);
        let height = 0.75 + 0.004 * (0.3 * t).cos();
        let pose = at(
            DMat3::from_rotation_z(0.3 + 0.002 * t),
            DVec3::new(-0.5 + 0.01 * t, 0.1, height),
        );
        let query = Query::manifolds(&floor, &crate_, pose).skin(0.01);
        let _ = query
            .with_memory(&mut memory)
            .run(&mut workspace, Budget::unlimited());
        let [manifold] = workspace.manifolds() else {
            panic!("{frame}: {:?}", workspace.manifolds());
        };
        let mut ids: Vec<u64> = manifold.points().iter().map(|point| point.id).collect();
        ids.sort_unstable();
        let now = (manifold.id, ids);
        assert_eq!(known.get_or_insert_with(|| now.clone()), &now, "{frame}");
    }
    assert_eq!(known.map(|(_, ids)| ids.len()), Some(4));
    // Far away and back: new ids, none twice.
    let far = Query::manifolds(&floor, &crate_, at(DMat3::IDENTITY, DVec3::Z * 9.0)).skin(0.01);
    let _ = far
        .with_memory(&mut memory)
        .run(&mut workspace, Budget::unlimited());
    assert!(workspace.manifolds().is_empty());
    let near = Query::manifolds(&floor, &crate_, at(DMat3::IDENTITY, DVec3::Z * 0.755)).skin(0.01);
    let _ = near
        .with_memory(&mut memory)
        .run(&mut workspace, Budget::unlimited());
    assert!(
        workspace.manifolds()[0]
            .points()
            .iter()
            .all(|point| point.id >= 4)
    );
}

/// Pairs with overlaps, with a skin, with both, with many pieces, and a pair that only touches.
fn cases() -> Vec<(Tree, Tree, Pose, f64)> {
    let turned = DMat3::from_rotation_x(0.01);
    vec![
        (
            cuboid([0.5, 0.5, 0.05], 1),
            cuboid([0.1; 3], 6),
            at(turned, DVec3::new(0.1, 0.0, 0.15)),
            0.004,
        ),
        (
            solid(shapes::icosphere(3)),
            solid(shapes::icosphere(3)),
            at(turned, DVec3::X * 1.8),
            0.0,
        ),
        (
            solid(shapes::icosphere(3)),
            solid(shapes::torus(1.0, 0.3, 40)),
            at(turned, DVec3::X * 0.4),
            0.01,
        ),
        (
            solid(shapes::gear(9, 1)),
            solid(shapes::gear(9, 1)),
            at(turned, DVec3::new(0.9, 0.4, 0.1)),
            0.02,
        ),
        (
            Tree::new(shapes::height_field(24, 1)),
            solid(shapes::icosphere(2)),
            at(turned, DVec3::Z * 0.9),
            0.01,
        ),
        (
            cuboid([0.5, 0.5, 0.05], 1),
            cuboid([0.1; 3], 6),
            at(DMat3::IDENTITY, DVec3::Z * f64::from(0.05_f32 + 0.1_f32)),
            0.004,
        ),
    ]
}

/// The overlaps of many pairs began with a step as long as their number.
#[test]
fn many_pairs_pass_a_budget_by_no_more_than_a_step() {
    for size in [1.0, 1e295] {
        let knot = shapes::torus_knot(2, 3, 0.2, 96);
        let corners = (0..knot.vertex_count()).map(|i| (size * knot.vertex(i)).to_array());
        let triangles = knot.triangles().iter().copied();
        let mesh = Mesh::from_f64(corners.collect::<Vec<_>>(), triangles).unwrap();
        let tree = solid(mesh);
        let turn = DMat3::from_rotation_x(0.1) * DMat3::from_rotation_z(0.05);
        let query = Query::manifolds(&tree, &tree, at(turn, DVec3::ZERO));
        let mut workspace = Workspace::new();
        let whole = query.run(&mut workspace, Budget::unlimited());
        assert!(whole.stats.found > 1_000, "{:?}", whole.stats);
        let mut answer = query.run(&mut workspace, Budget::work(0));
        while answer.stop == StopReason::WorkLimit {
            let before = answer.stats.work;
            answer = query.resume(&mut workspace, Budget::work(1)).unwrap();
            assert_step(answer.stats.work - before, 1, MAX_DISTANCE_STEP_WORK);
        }
        assert_eq!(
            (answer.value, answer.stats.work),
            (whole.value, whole.stats.work)
        );
    }
}

#[test]
fn at_every_stop_nothing_is_false_and_resumed_runs_end_with_the_same_bits() {
    for (number, (a, b, pose, skin)) in cases().into_iter().enumerate() {
        let query = Query::manifolds(&a, &b, pose).skin(skin);
        let mut workspace = Workspace::new();
        let whole = query.run(&mut workspace, Budget::unlimited());
        let all = workspace.manifolds().to_vec();
        assert!(!all.is_empty(), "{number}");
        for step in [1, 2_000, 30_000] {
            let mut answer = query.run(&mut workspace, Budget::work(step));
            let mut stops = 0;
            while answer.stop == StopReason::WorkLimit {
                stops += 1;
                for manifold in workspace.manifolds() {
                    if manifold.is_overlap {
                        let is_same = |one: &Manifold| {
                            (one.normal, one.area, one.points())
                                == (manifold.normal, manifold.area, manifold.points())
                                || one.normal == manifold.normal
                                    && one.distance == manifold.distance
                        };
                        assert!(all.iter().any(is_same), "{number}: {manifold:?}");
                    } else {
                        assert!(manifold.points().iter().all(|point| point.distance <= skin));
                    }
                }
                let known = workspace
                    .manifolds()
                    .first()
                    .map_or(f64::INFINITY, |one| one.distance);
                let least = all[0].distance.max(0.0);
                assert!(
                    answer.value.low.min(known) <= least * 1.001 + 1e-12,
                    "{number}: {answer:?}"
                );
                assert!(!answer.value.meets || whole.value.meets);
                assert!(stops < 1_000_000, "{number}: no end");
                let before = answer.stats.work;
                answer = query.resume(&mut workspace, Budget::work(step)).unwrap();
                assert_step(answer.stats.work - before, step, MAX_DISTANCE_STEP_WORK);
            }
            assert!(stops > 0 || step == 30_000, "{number}: {:?}", whole.stats);
            assert_eq!(workspace.manifolds(), all, "{number}");
            assert_eq!(answer.stats.work, whole.stats.work, "{number}");
            assert!(query.resume(&mut workspace, Budget::unlimited()).is_err());
        }
    }
}

/// Edges without length passed for parallel to all others, and put points beside the surfaces.
#[test]
fn points_of_triangles_without_an_area_are_on_both_surfaces() {
    let mut random = Rand64::new(9);
    let plate = cuboid([0.5, 0.5, 0.1], 1);
    let dot = Tree::new(Mesh::new([[0.0f32; 3]; 3], [[0, 1, 2]]).unwrap());
    let mut points = 0;
    for trial in 0..300 {
        let mut part = || random.rand_float() - 0.5;
        let [p, q] = [(); 2].map(|()| DVec3::new(part(), part(), part()));
        // Often along an edge of the plate, and at times longer than it.
        let q = if trial % 2 == 0 {
            p + DVec3::Y * q.y * 4.0
        } else {
            q
        };
        let corners = [[p, p, q], [p, q, q], [p, q, p.lerp(q, 0.3)], [q, p, p]][trial % 4];
        let needle = Mesh::from_f64(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let least = corners
            .map(|corner| corner.z)
            .into_iter()
            .fold(1.0, f64::min);
        let height = DVec3::new(0.5 - p.x + 0.01, 0.0, 0.105 - least);
        let needle = Tree::new(needle);
        let pose = at(
            DMat3::IDENTITY,
            if trial % 3 == 0 {
                height
            } else {
                height.with_z(0.1)
            },
        );
        for one in manifolds(&plate, &needle, pose, 0.02) {
            for point in one.points() {
                points += 1;
                let [on_a, on_b] = point.points;
                let on_b = pose.inverse().unwrap().transform_point(on_b);
                for (tree, place) in [(&plate, on_a), (&needle, on_b)] {
                    let query = Query::distance(tree, &dot, at(DMat3::IDENTITY, place));
                    let off = query.run(&mut Workspace::new(), Budget::unlimited()).value;
                    let slant = 0.13 * point.distance.abs();
                    assert!(off.low <= slant + 1e-6, "{trial}: {point:?} {off:?}");
                }
            }
        }
    }
    assert!(points > 100, "{points}");
}

#[test]
fn more_pairs_than_there_is_room_for_stop_the_query_and_it_goes_on() {
    let (a, b) = (solid(shapes::icosphere(4)), solid(shapes::icosphere(4)));
    let pose = at(DMat3::from_rotation_x(0.3), DVec3::X * 0.5);
    let query = Query::manifolds(&a, &b, pose);
    let all = manifolds(&a, &b, pose, 0.0);
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(50);
    let mut answer = query.run(&mut workspace, Budget::unlimited());
    let mut stops = 0;
    while answer.stop == StopReason::PairsFull {
        stops += 1;
        workspace.reserve_contacts(2 * answer.stats.found as usize);
        answer = query.resume(&mut workspace, Budget::unlimited()).unwrap();
    }
    assert!(stops > 0 && answer.stop == StopReason::Finished);
    assert_eq!(workspace.manifolds(), all);
}

#[test]
fn odd_input_is_told_or_harmless() {
    let (a, b) = (cuboid([0.5; 3], 1), cuboid([0.5; 3], 1));
    let empty = Tree::new(Mesh::new(Vec::<Vec3>::new(), Vec::<[u32; 3]>::new()).unwrap());
    for skin in [-1.0, f64::NAN] {
        let query = Query::manifolds(&a, &b, Pose::IDENTITY).skin(skin);
        assert_eq!(query.checked().unwrap_err().argument, "skin");
    }
    assert!(manifolds(&a, &empty, Pose::IDENTITY, 1.0).is_empty());
    assert!(manifolds(&empty, &empty, Pose::IDENTITY, 0.0).is_empty());
    // The same place: all faces coincide, and no direction parts the bodies.
    assert!(manifolds(&a, &b, Pose::IDENTITY, 0.01).is_empty());
    let flat =
        Tree::new(Mesh::new([[0.0f32; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0, 1, 2]]).unwrap());
    for pose in [Pose::IDENTITY, at(DMat3::IDENTITY, DVec3::Z * 0.505)] {
        let _ = manifolds(&a, &flat, pose, 0.01);
        let _ = manifolds(&flat, &flat, pose, 0.01);
    }
}

/// What a solver gets, frame by frame: the ids of the points of all manifolds.
fn ids(query: Query<'_, punctual::contacts::Manifolds>, memory: &mut PairMemory) -> Vec<u64> {
    let mut workspace = Workspace::new();
    let _ = query
        .with_memory(memory)
        .run(&mut workspace, Budget::unlimited());
    let points = workspace.manifolds().iter().flat_map(Manifold::points);
    let mut ids: Vec<u64> = points.map(|point| point.id).collect();
    ids.sort_unstable();
    ids
}

#[test]
fn points_stay_when_bodies_at_rest_tremble() {
    let mut random = Rand64::new(6);
    let (floor, crate_) = (cuboid([2.0, 2.0, 0.5], 4), cuboid([0.25; 3], 3));
    // A crate on a crate, turned: eight corners, the deepest of them another one in each frame.
    for (lower, height) in [(&floor, 0.754), (&crate_, 0.504)] {
        let mut memory = PairMemory::new();
        let mut known = None;
        for frame in 0..50 {
            let tilt = DVec3::new(random.rand_float() - 0.5, random.rand_float() - 0.5, 0.0);
            let turn = DQuat::from_scaled_axis(4e-4 * tilt) * DQuat::from_rotation_z(0.6);
            let pose = at(DMat3::from_quat(turn), DVec3::Z * height);
            let query = Query::manifolds(lower, &crate_, pose).skin(0.01);
            let now = ids(query, &mut memory);
            assert!(now.len() == 4, "{frame}: {now:?}");
            assert_eq!(known.get_or_insert_with(|| now.clone()), &now, "{frame}");
        }
    }
}

#[test]
fn crossing_edges_are_one_point() {
    let mut random = Rand64::new(7);
    let cube = cuboid([0.5; 3], 3);
    let (rx, ry) = (
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_y(FRAC_PI_4),
    );
    for trial in 0..50 {
        let [x, y] = [(); 2].map(|()| between(&mut random, -0.3, 0.3));
        let turn = DMat3::from_rotation_z(between(&mut random, -0.4, 0.4));
        let place = DVec3::new(x, y, SQRT_2 + 0.005);
        let pose = at(rx.transpose() * turn * ry, rx.transpose() * place);
        let found = manifolds(&cube, &cube, pose, 0.0052);
        let points: Vec<_> = found.iter().flat_map(Manifold::points).collect();
        assert!(points.len() == 1, "{trial}: {points:?}");
    }
}

/// What lies beyond the depth, here a part in the cube that is no cavity, does not matter.
#[test]
fn a_part_inside_a_body_takes_no_normal() {
    let part = |half: f32, first: u32| {
        let mesh = shapes::cuboid(Vec3::splat(half), 1);
        let vertices: Vec<DVec3> = (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect();
        let triangles = mesh.triangles().iter().map(|t| t.map(|v| v + first));
        (vertices, triangles.collect::<Vec<_>>())
    };
    let (mut vertices, mut triangles) = part(0.5, 0);
    let (inner, of_inner) = part(0.2, vertices.len() as u32);
    vertices.extend(inner);
    triangles.extend(of_inner);
    let filled = solid(Mesh::from_f64(vertices, triangles).unwrap());
    let cube = cuboid([0.5; 3], 1);
    let [rx, ry] = [
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_y(FRAC_PI_4),
    ];
    // An edge of one crosses an edge of the other.
    let pose = at(
        rx.transpose() * ry,
        rx.transpose() * DVec3::Z * (SQRT_2 - 0.01),
    );
    for (a, b) in [
        (&cube, &cube),
        (&filled, &cube),
        (&cube, &filled),
        (&filled, &filled),
    ] {
        let found = manifolds(a, b, pose, 0.0);
        let [one] = &found[..] else {
            panic!("{found:?}")
        };
        let truth = rx.transpose() * DVec3::NEG_Z;
        assert!(
            degrees(one.normal, truth) < 1e-6 && (one.distance + 0.01).abs() < 1e-3,
            "{one:?}"
        );
    }
}

#[test]
fn a_body_on_many_feet_has_those_that_bear_it() {
    // A slab on nine feet. The three that are the longest carry it, though all are within the skin.
    let mut random = Rand64::new(8);
    let floor = cuboid([2.0, 2.0, 0.5], 1);
    for trial in 0..50 {
        let mut long = [0; 9];
        let (mut corners, mut triangles) = (Vec::new(), Vec::new());
        // One in each row and in another column, not in one line.
        let rows = [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1]];
        for (x, y) in (0..).zip(rows[trial % 4]) {
            long[3 * x + y] = 1;
        }
        for (foot, long) in long.into_iter().enumerate() {
            let (x, y) = ((foot / 3) as f64 - 1.0, (foot % 3) as f64 - 1.0);
            let tip = -0.2 - 0.004 * f64::from(long) - 1e-6 * random.rand_float();
            let first = corners.len() as u32;
            let around = [[0.1, 0.0], [-0.05, 0.0866], [-0.05, -0.0866]];
            corners.push(DVec3::new(0.5 * x, 0.5 * y, tip));
            corners.extend(around.map(|[u, v]| DVec3::new(0.5 * x + u, 0.5 * y + v, 0.0)));
            let faces = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
            triangles.extend(faces.map(|face| face.map(|corner| first + corner)));
        }
        let body = solid(Mesh::from_f64(corners, triangles).unwrap());
        let pose = at(DMat3::IDENTITY, DVec3::Z * (0.5 + 0.204 + 0.005));
        let found = manifolds(&floor, &body, pose, 0.01);
        let [manifold] = &found[..] else {
            panic!("{trial}: {found:?}")
        };
        let bearing = manifold
            .points()
            .iter()
            .filter(|point| point.distance < 0.0051);
        assert_eq!(bearing.count(), 3, "{trial}: {found:?}");
    }
}

#[test]
fn with_a_memory_ids_do_not_depend_on_how_a_query_is_cut() {
    for (number, (a, b, pose, skin)) in cases().into_iter().enumerate() {
        let near = at(
            *pose.rotation() * DMat3::from_rotation_z(1e-3),
            pose.translation(),
        );
        let query = Query::manifolds(&a, &b, pose).skin(skin);
        let mut memory = PairMemory::new();
        let mut workspace = Workspace::new();
        let before = Query::manifolds(&a, &b, near).skin(skin);
        let _ = before
            .with_memory(&mut memory)
            .run(&mut workspace, Budget::unlimited());
        let (mut whole, mut cut) = (memory.clone(), memory);
        let _ = query
            .with_memory(&mut whole)
            .run(&mut workspace, Budget::unlimited());
        let all = workspace.manifolds().to_vec();
        let mut answer = query
            .with_memory(&mut cut)
            .run(&mut workspace, Budget::work(5_000));
        while answer.stop == StopReason::WorkLimit {
            answer = query
                .with_memory(&mut cut)
                .resume(&mut workspace, Budget::work(5_000))
                .unwrap();
        }
        assert_eq!(workspace.manifolds(), all, "{number}");
    }
}
