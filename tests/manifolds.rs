//! Contact manifolds of solids: normals and depths of cases whose truth is known, apart and sunk, in
//! one list; ids that last; the same bits however a query is cut; nothing false at a stop.

mod common;

use common::ask::{answer, resume, run, run_with_memory};
use common::meshes::{at, moved, nothing, one, placed, solid};
use common::random::Random;
use common::steps::assert_step;
use punctual::contacts::{Manifold, Manifolds};
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::shapes::{gear, icosphere, torus, torus_knot};
use punctual::{Budget, Mesh, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes};
use std::f64::consts::{FRAC_PI_4, SQRT_2, TAU};

fn cuboid(half: [f32; 3], cells: u32) -> Tree {
    solid(shapes::cuboid(half, cells))
}

fn crate_of(half: f32, cells: u32) -> Tree {
    cuboid([half; 3], cells)
}

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

/// About z, by any angle.
fn spun(random: &mut Random) -> DMat3 {
    DMat3::from_rotation_z(TAU * random.unit())
}

fn degrees(x: DVec3, y: DVec3) -> f64 {
    x.cross(y).length().atan2(x.dot(y)).to_degrees()
}

/// The manifolds of a finished query.
#[track_caller]
fn manifolds(a: &Tree, b: &Tree, pose: Pose, skin: f64) -> Vec<Manifold> {
    let mut workspace = Workspace::new();
    let query = Query::manifolds(a, b, pose).skin(skin);
    let answer = query.run(&mut workspace, Budget::unlimited());
    assert_eq!(answer.stop, StopReason::Finished);
    assert_eq!(answer.value.low, f64::INFINITY);
    for manifold in workspace.manifolds() {
        assert!((1..=4).contains(&manifold.points().len()));
        for point in manifold.points() {
            let between = point.points[0] - point.points[1];
            let off = between - point.distance * point.normal;
            assert!(off.length() < 1e-9, "{point:?}");
            assert!(manifold.distance <= point.distance);
        }
    }
    workspace.manifolds().to_vec()
}

/// The only manifold of a finished query.
#[track_caller]
fn only(a: &Tree, b: &Tree, pose: Pose, skin: f64) -> Manifold {
    let mut found = manifolds(a, b, pose, skin);
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

#[track_caller]
fn assert_near(is: f64, expected: f64, error: f64) {
    assert!((is - expected).abs() < error, "{is}, not {expected}");
}

/// The normal of each point is as close to the true one as `most` degrees.
#[track_caller]
fn assert_normal<'m>(manifolds: impl IntoIterator<Item = &'m Manifold>, truth: DVec3, most: f64) {
    let points = manifolds.into_iter().flat_map(Manifold::points);
    let angles = points.map(|point| degrees(point.normal, truth));
    let worst = angles.fold(0.0, f64::max);
    assert!(worst < most, "{worst} degrees");
}

/// Height of the lowest vertex at a pose.
fn lowest(tree: &Tree, rotation: DMat3) -> f64 {
    let vertices = (0..tree.mesh().vertex_count()).map(|i| (rotation * tree.mesh().vertex(i)).z);
    vertices.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_crate_in_a_floor_has_the_normal_of_the_floor_and_its_depth() {
    let mut random = Random::new(1);
    let floor = cuboid([0.5, 0.5, 0.05], 1);
    let top = floor.mesh().aabb().max.z;
    for (cells, tilt) in [1, 6]
        .into_iter()
        .flat_map(|n| [0.0, 0.0035, 0.2].map(|t| (n, t)))
    {
        let crate_ = crate_of(0.1, cells);
        for trial in 0..200 {
            let axis = DVec3::new(1.0, random.unit(), 0.0).normalize();
            let tilted = DMat3::from_axis_angle(axis, tilt * random.unit());
            let rotation = tilted * spun(&mut random);
            let depth = if trial == 0 {
                0.0
            } else {
                5e-3 * random.unit()
            };
            let [x, y] = [(); 2].map(|()| between(&mut random, -0.3, 0.3));
            let place = [x, y, top - lowest(&crate_, rotation) - depth];
            let skin = [0.0, 0.002, 0.01][trial % 3];
            let found = manifolds(&floor, &crate_, placed(rotation, place), skin);
            if trial > 0 {
                assert!(found[0].is_overlap && found[0].is_whole, "{found:?}");
                assert_near(found[0].distance, -depth, 1e-9);
            }
            assert_normal(&found, -DVec3::Z, 0.01);
            if tilt == 0.0 && depth > 1e-9 {
                assert_near(found[0].area, 0.04, 1e-6);
                assert_eq!(found[0].points().len(), 4);
            }
        }
    }
}

#[test]
fn thin_plates_are_as_deep_as_they_are() {
    let mut random = Random::new(2);
    let plate = cuboid([0.1, 0.1, 0.0005], 4);
    for (depth, skin) in [(5e-4, 0.0), (8e-4, 0.0), (5e-4, 0.002)] {
        for _ in 0..50 {
            let rotation = spun(&mut random);
            let [x, y] = [(); 2].map(|()| 0.05 * random.unit());
            let pose = placed(rotation, [x, y, 0.001 - depth]);
            let found = manifolds(&plate, &plate, pose, skin);
            assert_normal(&found, -DVec3::Z, 0.5);
            assert_near(found[0].distance, -depth, 0.01 * depth);
        }
    }
}

#[test]
fn spheres_part_along_the_line_of_their_centers() {
    let mut random = Random::new(3);
    let ball = solid(icosphere(4));
    let mut ratios = Vec::new();
    for trial in 0..50 {
        let way = random.vector().normalize();
        let pose = placed(DMat3::IDENTITY, 1.7 * way);
        let found = manifolds(&ball, &ball, pose, [0.0, 0.01][trial % 2]);
        assert_normal(&found, -way, 0.5);
        ratios.push(-found[0].distance / 0.3);
    }
    ratios.sort_by(f64::total_cmp);
    assert_near(ratios[ratios.len() / 2], 1.0, 0.01);
}

#[test]
fn every_pose_of_closed_surfaces_that_meet_has_a_manifold() {
    let mut random = Random::new(4);
    let solids = [
        solid(icosphere(2)),
        solid(torus(0.7, 0.25, 24)),
        cuboid([0.5, 0.8, 0.3], 3),
        solid(gear(9, 1)),
    ];
    let (mut meetings, mut normals) = (0, 0);
    for trial in 0..600 {
        let (a, b) = (&solids[trial % 4], &solids[trial / 4 % 4]);
        let pose = placed(random.rotation(), random.vector());
        let meets = answer(&Query::contacts(a, b, pose)).stats.found > 0;
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
    assert!(meetings > 200, "{meetings}");
    assert!(
        normals as f64 > 0.95 * meetings as f64,
        "{normals} of {meetings}"
    );
}

#[test]
fn solids_apart_have_the_corners_of_their_common_area() {
    let floor = cuboid([2.0, 2.0, 0.5], 1);
    for cells in [1, 5] {
        let pose = placed(DMat3::from_rotation_z(0.3), [0.2, -0.1, 1.01]);
        let foot = only(&floor, &crate_of(0.5, cells), pose, 0.02);
        assert_normal([&foot], -DVec3::Z, 1e-6);
        assert_near(foot.area, 1.0, 1e-6);
        for [x, y] in [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]] {
            let corner = pose.transform_point([x, y, -0.5]);
            let mut points = foot.points().iter().map(|point| point.points[1]);
            assert!(
                points.any(|point| (point - corner).length() < 1e-6),
                "{foot:?}"
            );
        }
        foot.points()
            .iter()
            .for_each(|point| assert_near(point.distance, 0.01, 1e-6));
    }
    // Half of it beyond the edge of the floor: the corners of what is over the floor.
    let foot = only(&floor, &crate_of(0.5, 1), at(2.0, 0.0, 1.01), 0.02);
    assert_normal([&foot], -DVec3::Z, 1e-6);
    assert_near(foot.area, 0.5, 1e-6);
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
    [gear(11, 2), torus_knot(2, 3, 0.45, 40), icosphere(3)]
        .map(solid)
        .into()
}

#[test]
fn pairs_without_a_closer_look_add_nothing() {
    let mut random = Random::new(9);
    let bodies = uneven();
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(1 << 20);
    for trial in 0..90 {
        let body = &bodies[trial % 3];
        let size = body.mesh().aabb().extents().length();
        let floor = crate_of(size as f32, [1, 12, 40][trial / 3 % 3]);
        let tilt = [0.0, 0.003, 0.5][trial / 9 % 3];
        let rotation = DMat3::from_rotation_x(tilt) * spun(&mut random);
        let (skin, gap) = (0.02 * size, between(&mut random, 0.001, 0.01) * size);
        let pose = placed(rotation, DVec3::Z * (size + gap - lowest(body, rotation)));
        let query = Query::contacts(&floor, body, pose).margin(skin);
        let contacts = query.run(&mut workspace, Budget::unlimited());
        assert_eq!(contacts.stop, StopReason::Finished);
        let nearest = workspace.contacts().next().expect("within").distance;
        let found = manifolds(&floor, body, pose, skin);
        let least = found[0].distance;
        assert!(nearest * (1.0 - 1e-9) <= least && least <= 1.002 * nearest);
        if trial % 3 == 0 && tilt == 0.0 {
            assert_near(found[0].area / foot_area(body), 1.0, 1e-6);
        }
    }
}

#[test]
fn manifolds_keep_the_closest_pair_of_a_place() {
    let mut random = Random::new(10);
    let mut bodies = uneven();
    bodies.push(cuboid([0.7, 0.5, 0.9], 1));
    let mut workspace = Workspace::new();
    for trial in 0..96 {
        let (a, b) = (&bodies[trial % 4], &bodies[trial / 4 % 4]);
        let skin = 0.02 * a.mesh().aabb().extents().length();
        let axis = random.vector().normalize();
        let turn = DMat3::from_axis_angle(axis, TAU * random.unit());
        let (mut pose, gap) = (
            placed(turn, 9.0 * axis),
            between(&mut random, 0.05, 0.9) * skin,
        );
        let mut distance = f64::INFINITY;
        while distance > 1.01 * gap {
            distance = answer(&Query::distance(a, b, pose)).value.low;
            pose = placed(turn, pose.translation() - (distance - gap) * axis);
        }
        let query = Query::contacts(a, b, pose).margin(skin);
        assert!(
            query
                .run(&mut workspace, Budget::unlimited())
                .stop
                .is_final()
        );
        let truth = workspace.contacts().next().expect("within").distance;
        // Along the normal of a face the distance may be less, by a factor of cos .8 degrees.
        let ratio = manifolds(a, b, pose, skin)[0].distance / truth;
        assert!((0.9998..=1.002).contains(&ratio), "{ratio}, trial {trial}");
    }
}

#[test]
fn the_nearest_contact_is_told_on_an_inner_side_too() {
    let (room, ball, pose) = (crate_of(1.02, 8), solid(icosphere(3)), at(0.01, 0.0, 0.0));
    let mut workspace = Workspace::new();
    let query = Query::manifolds(&ball, &room, pose).skin(0.02);
    let answer_ = query.run(&mut workspace, Budget::unlimited()).value;
    let (_, nearest) = answer_.nearest.expect("within the skin");
    assert!(!answer_.meets && workspace.manifolds().is_empty());
    let truth = answer(&Query::distance(&ball, &room, pose).surfaces()).value;
    assert!(truth.low <= nearest * (1.0 + 1e-9) && nearest <= 1.002 * truth.high);
}

#[test]
fn internal_edges_of_flat_meshes_leave_no_ghost_normals() {
    let mut random = Random::new(5);
    let floor = cuboid([2.0, 2.0, 0.5], 40);
    let solids = [crate_of(0.2, 1), crate_of(0.2, 7), solid(icosphere(3))];
    for trial in 0..90 {
        let (body, is_ball) = (&solids[trial % 3], trial % 3 == 2);
        let tilt = [0.0, 0.05 * random.unit()][trial % 2];
        let rotation = DMat3::from_rotation_x(tilt) * spun(&mut random);
        let rest = 0.5 - lowest(body, rotation);
        let (height, size, most) = if is_ball {
            (1.5, 1.0, 3.0)
        } else {
            (rest, 0.2, 0.01)
        };
        let gap = between(&mut random, -0.01, 0.01) * size;
        let place = random.vector().with_z(height + gap);
        let found = manifolds(&floor, body, placed(rotation, place), 0.02 * size);
        assert!(!found.is_empty(), "{trial}");
        assert_normal(&found, -DVec3::Z, most);
    }
}

#[test]
fn edges_and_corners_have_the_normals_that_part_them() {
    let cube = crate_of(0.5, 1);
    let [rx, ry] = [
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_y(FRAC_PI_4),
    ];
    // Roof on roof: the normal is across both edges.
    for depth in [-0.01, 0.0, 1e-3, 0.1] {
        let place = rx.transpose() * DVec3::new(0.05, 0.03, SQRT_2 - depth);
        let one = only(&cube, &cube, placed(rx.transpose() * ry, place), 0.02);
        assert_normal([&one], rx.transpose() * -DVec3::Z, 1e-4);
        assert_near(one.distance, -depth, 1e-9);
    }
    // A corner that points down, over a face and into it.
    let floor = cuboid([2.0, 2.0, 0.5], 1);
    let corner = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::ONE.normalize(), -DVec3::Z));
    for depth in [-0.01, 1e-3, 0.05] {
        let height = 0.5 - lowest(&cube, corner) - depth;
        let one = only(&floor, &cube, placed(corner, [0.3, 0.2, height]), 0.02);
        assert_normal([&one], -DVec3::Z, 1e-4);
        assert_near(one.distance, -depth, 1e-9);
    }
}

#[test]
fn a_pin_through_a_plate_has_no_normal() {
    let plate = cuboid([0.5, 0.5, 0.05], 1);
    for cells in [1, 3, 12] {
        let pin = cuboid([0.01, 0.01, 0.3], cells);
        for skin in [0.0, 0.002] {
            let found = manifolds(&plate, &pin, at(0.1, 0.1, 0.02), skin);
            let is_right = |one: &Manifold| one.is_overlap && one.normal == DVec3::ZERO;
            assert!(!found.is_empty() && found.iter().all(is_right), "{found:?}");
        }
    }
}

#[test]
fn a_foot_that_is_sunk_and_apart_is_one_manifold() {
    let (floor, crate_) = (cuboid([0.5, 0.5, 0.05], 1), crate_of(0.1, 4));
    let rotation = DMat3::from_rotation_x(0.01);
    let height = 0.05_f32 as f64 - lowest(&crate_, rotation) - 5e-4;
    let foot = only(&floor, &crate_, placed(rotation, DVec3::Z * height), 0.004);
    assert_normal([&foot], -DVec3::Z, 1e-4);
    assert!(foot.is_overlap && foot.points().len() == 4, "{foot:?}");
    assert_near(foot.distance, -5e-4, 1e-9);
    assert_near(foot.area, 0.04, 1e-4);
    let distances = foot.points().iter().map(|point| point.distance);
    let highest = distances.fold(0.0, f64::max);
    assert!(
        highest > 1e-3,
        "{highest}: the far edge is 1.5 mm above the floor"
    );
}

/// What a solver gets in a frame: the ids of all manifolds and points.
fn ids(query: &Query<Manifolds>, memory: &mut PairMemory) -> (Vec<u64>, Vec<u64>) {
    let mut workspace = Workspace::new();
    let _ = run_with_memory(query, &mut workspace, memory, Budget::unlimited());
    let found = workspace.manifolds();
    let points = found.iter().flat_map(Manifold::points);
    let mut ids: Vec<u64> = points.map(|point| point.id).collect();
    ids.sort_unstable();
    (found.iter().map(|one| one.id).collect(), ids)
}

#[test]
fn ids_last_while_a_body_slides_and_sinks() {
    let (floor, crate_) = (cuboid([2.0, 2.0, 0.5], 20), crate_of(0.25, 3));
    let ask = |pose| Query::manifolds(&floor, &crate_, pose).skin(0.01);
    let (mut memory, mut known) = (PairMemory::new(), None);
    for frame in 0..60 {
        let t = f64::from(frame);
        let place = [-0.5 + 0.01 * t, 0.1, 0.75 + 0.004 * (0.3 * t).cos()];
        let pose = placed(DMat3::from_rotation_z(0.3 + 0.002 * t), place);
        let now = ids(&ask(pose), &mut memory);
        assert_eq!((now.0.len(), now.1.len()), (1, 4), "{frame}: {now:?}");
        assert_eq!(known.get_or_insert_with(|| now.clone()), &now, "{frame}");
    }
    // Far away and back: new ids, none twice.
    assert!(ids(&ask(at(0.0, 0.0, 9.0)), &mut memory).0.is_empty());
    let (_, points) = ids(&ask(at(0.0, 0.0, 0.755)), &mut memory);
    assert!(points.len() == 4 && points.iter().all(|id| *id >= 4));
}

/// Pairs with overlaps, with a skin, with both, with many pieces, and a pair that only touches.
fn cases() -> Vec<(Tree, Tree, Pose, f64)> {
    let turned = |x, y, z| placed(DMat3::from_rotation_x(0.01), [x, y, z]);
    let (floor, crate_) = (cuboid([0.5, 0.5, 0.05], 1), crate_of(0.1, 6));
    let touching = at(0.0, 0.0, f64::from(0.05_f32 + 0.1_f32));
    let [ball, small] = [3, 2].map(|detail| solid(icosphere(detail)));
    let (ring, gear) = (solid(torus(1.0, 0.3, 40)), solid(gear(9, 1)));
    let field = Tree::new(shapes::height_field(24, 1));
    vec![
        (floor.clone(), crate_.clone(), turned(0.1, 0.0, 0.15), 0.004),
        (ball.clone(), ball.clone(), turned(1.8, 0.0, 0.0), 0.0),
        (ball, ring, turned(0.4, 0.0, 0.0), 0.01),
        (gear.clone(), gear, turned(0.9, 0.4, 0.1), 0.02),
        (field, small, turned(0.0, 0.0, 0.9), 0.01),
        (floor, crate_, touching, 0.004),
    ]
}

/// The overlaps of many pairs began with a step as long as their number.
#[test]
fn many_pairs_pass_a_budget_by_no_more_than_a_step() {
    for size in [1.0, 1e295] {
        let tree = solid(moved(&torus_knot(2, 3, 0.2, 96), |vertex| size * vertex));
        let turn = DMat3::from_rotation_x(0.1) * DMat3::from_rotation_z(0.05);
        let query = Query::manifolds(&tree, &tree, placed(turn, DVec3::ZERO));
        let whole = answer(&query);
        assert!(whole.stats.found > 1_000, "{:?}", whole.stats);
        let mut workspace = Workspace::new();
        let mut said = run(&query, &mut workspace, Budget::work(0));
        while said.stop == StopReason::WorkLimit {
            let before = said.stats.work;
            said = resume(&query, &mut workspace, Budget::work(1));
            assert_step(said.stats.work - before, 1, MAX_DISTANCE_STEP_WORK);
        }
        assert_eq!(
            (said.value, said.stats.work),
            (whole.value, whole.stats.work)
        );
    }
}

/// With a memory, of which ids come, and without.
#[test]
fn at_every_stop_nothing_is_false_and_resumed_runs_end_with_the_same_bits() {
    for (number, (a, b, pose, skin)) in cases().into_iter().enumerate() {
        let query = Query::manifolds(&a, &b, pose).skin(skin);
        let mut workspace = Workspace::new();
        let near = placed(
            *pose.rotation() * DMat3::from_rotation_z(1e-3),
            pose.translation(),
        );
        let mut memory = PairMemory::new();
        let _ = ids(&Query::manifolds(&a, &b, near).skin(skin), &mut memory);
        for (step, remembers) in [(1, false), (2_000, false), (30_000, false), (5_000, true)] {
            let [mut known, mut cut] = [(); 2].map(|()| remembers.then(|| memory.clone()));
            let whole = query.with_memory(known.as_mut());
            let whole = whole.run(&mut workspace, Budget::unlimited());
            let all = workspace.manifolds().to_vec();
            assert!(!all.is_empty(), "{number}");
            let begun = query.with_memory(cut.as_mut());
            let mut answer = begun.run(&mut workspace, Budget::work(step));
            let mut stops = 0;
            while answer.stop == StopReason::WorkLimit {
                stops += 1;
                for manifold in workspace.manifolds() {
                    if manifold.is_overlap {
                        let is_same = |one: &Manifold| {
                            one.normal == manifold.normal
                                && (one.distance == manifold.distance
                                    || (one.area, one.points())
                                        == (manifold.area, manifold.points()))
                        };
                        assert!(all.iter().any(is_same), "{number}: {manifold:?}");
                    } else {
                        assert!(manifold.points().iter().all(|point| point.distance <= skin));
                    }
                }
                let first = workspace.manifolds().first();
                let known = first.map_or(f64::INFINITY, |one| one.distance);
                let least = all[0].distance.max(0.0) * 1.001 + 1e-12;
                assert!(answer.value.low.min(known) <= least, "{number}: {answer:?}");
                assert!(!answer.value.meets || whole.value.meets);
                assert!(stops < 1_000_000, "{number}: no end");
                let before = answer.stats.work;
                let known = query.with_memory(cut.as_mut());
                answer = known.resume(&mut workspace, Budget::work(step)).unwrap();
                assert_step(answer.stats.work - before, step, MAX_DISTANCE_STEP_WORK);
            }
            assert!(stops > 0 || step > 2_000, "{number}: {:?}", whole.stats);
            assert_eq!(workspace.manifolds(), all, "{number}");
            assert_eq!(answer.stats.work, whole.stats.work, "{number}");
        }
    }
}

/// Edges without length passed for parallel to all others, and put points beside the surfaces.
#[test]
fn points_of_triangles_without_an_area_are_on_both_surfaces() {
    let mut random = Random::new(9);
    let plate = cuboid([0.5, 0.5, 0.1], 1);
    let dot = one([DVec3::ZERO; 3]);
    let mut points = 0;
    for trial in 0..300 {
        let [p, q] = [(); 2].map(|()| 0.5 * random.vector());
        // Often along an edge of the plate, and at times longer than it.
        let q = [p + DVec3::Y * q.y * 4.0, q][trial % 2];
        let corners = [[p, p, q], [p, q, q], [p, q, p.lerp(q, 0.3)], [q, p, p]][trial % 4];
        let needle = one(corners);
        let height = if trial % 3 == 0 {
            0.105 - needle.mesh().aabb().min.z
        } else {
            0.1
        };
        let pose = at(0.5 - p.x + 0.01, 0.0, height);
        let found = manifolds(&plate, &needle, pose, 0.02);
        for point in found.iter().flat_map(Manifold::points) {
            points += 1;
            let [on_a, on_b] = point.points;
            let on_b = pose.inverse().unwrap().transform_point(on_b);
            for (tree, place) in [(&plate, on_a), (&needle, on_b)] {
                let query = Query::distance(tree, &dot, placed(DMat3::IDENTITY, place));
                let off = answer(&query).value.low;
                let slant = 0.13 * point.distance.abs();
                assert!(off <= slant + 1e-6, "{trial}: {point:?} {off:?}");
            }
        }
    }
    assert!(points > 100, "{points}");
}

#[test]
fn more_pairs_than_there_is_room_for_stop_the_query_and_it_goes_on() {
    let ball = solid(icosphere(4));
    let pose = placed(DMat3::from_rotation_x(0.3), DVec3::X * 0.5);
    let query = Query::manifolds(&ball, &ball, pose);
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(50);
    let mut said = query.run(&mut workspace, Budget::unlimited());
    let mut stops = 0;
    while said.stop == StopReason::PairsFull {
        stops += 1;
        workspace.reserve_contacts(2 * said.stats.found as usize);
        said = query.resume(&mut workspace, Budget::unlimited()).unwrap();
    }
    assert!(stops > 0 && said.stop == StopReason::Finished);
    assert_eq!(workspace.manifolds(), manifolds(&ball, &ball, pose, 0.0));
}

#[test]
fn odd_input_is_told_or_harmless() {
    let (cube, empty) = (crate_of(0.5, 1), nothing());
    for skin in [-1.0, f64::NAN] {
        let query = Query::manifolds(&cube, &cube, Pose::IDENTITY).skin(skin);
        assert_eq!(query.checked().unwrap_err().argument, "skin");
    }
    assert!(manifolds(&cube, &empty, Pose::IDENTITY, 1.0).is_empty());
    assert!(manifolds(&empty, &empty, Pose::IDENTITY, 0.0).is_empty());
    // The same place: all faces coincide, and no direction parts the bodies.
    assert!(manifolds(&cube, &cube, Pose::IDENTITY, 0.01).is_empty());
    let flat = one([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]);
    for pose in [Pose::IDENTITY, at(0.0, 0.0, 0.505)] {
        let _ = manifolds(&cube, &flat, pose, 0.01);
        let _ = manifolds(&flat, &flat, pose, 0.01);
    }
}

#[test]
fn points_stay_when_bodies_at_rest_tremble() {
    let mut random = Random::new(6);
    let (floor, crate_) = (cuboid([2.0, 2.0, 0.5], 4), crate_of(0.25, 3));
    // A crate on a crate, turned: eight corners, the deepest of them another one in each frame.
    for (lower, height) in [(&floor, 0.754), (&crate_, 0.504)] {
        let (mut memory, mut known) = (PairMemory::new(), None);
        for frame in 0..50 {
            let tilt = DQuat::from_scaled_axis(2e-4 * random.vector().with_z(0.0));
            let rotation = DMat3::from_quat(tilt * DQuat::from_rotation_z(0.6));
            let pose = placed(rotation, DVec3::Z * height);
            let query = Query::manifolds(lower, &crate_, pose).skin(0.01);
            let (_, now) = ids(&query, &mut memory);
            assert!(now.len() == 4, "{frame}: {now:?}");
            assert_eq!(known.get_or_insert_with(|| now.clone()), &now, "{frame}");
        }
    }
}

#[test]
fn crossing_edges_are_one_point() {
    let mut random = Random::new(7);
    let cube = crate_of(0.5, 3);
    let [rx, ry] = [
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_y(FRAC_PI_4),
    ];
    for trial in 0..50 {
        let place = (0.3 * random.vector()).with_z(SQRT_2 + 0.005);
        let turn = DMat3::from_rotation_z(0.4 * random.signed());
        let pose = placed(rx.transpose() * turn * ry, rx.transpose() * place);
        let found = manifolds(&cube, &cube, pose, 0.0052);
        assert!(
            found.len() == 1 && found[0].points().len() == 1,
            "{trial}: {found:?}"
        );
    }
}

/// What lies beyond the depth, here a part in the cube that is no cavity, does not matter.
#[test]
fn a_part_inside_a_body_takes_no_normal() {
    let cube = crate_of(0.5, 1);
    let mesh = cube.mesh();
    let vertices = (0..8).map(|i| mesh.vertex(i));
    let vertices = vertices.clone().chain(vertices.map(|vertex| 0.4 * vertex));
    let inner = mesh.triangles().iter().map(|t| t.map(|i| i + 8));
    let triangles = mesh.triangles().iter().copied().chain(inner);
    let filled = solid(Mesh::from_f64(vertices, triangles).unwrap());
    let [rx, ry] = [
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_y(FRAC_PI_4),
    ];
    // An edge of one crosses an edge of the other.
    let place = rx.transpose() * DVec3::Z * (SQRT_2 - 0.01);
    let pose = placed(rx.transpose() * ry, place);
    for (a, b) in [
        (&cube, &cube),
        (&filled, &cube),
        (&cube, &filled),
        (&filled, &filled),
    ] {
        let one = only(a, b, pose, 0.0);
        assert_normal([&one], rx.transpose() * DVec3::NEG_Z, 1e-6);
        assert_near(one.distance, -0.01, 1e-3);
    }
}

#[test]
fn a_body_on_many_feet_has_those_that_bear_it() {
    // A slab on nine feet. The three that are the longest carry it, though all are within the skin.
    let mut random = Random::new(8);
    let floor = cuboid([2.0, 2.0, 0.5], 1);
    for trial in 0..50 {
        let (mut corners, mut triangles) = (Vec::new(), Vec::new());
        // One in each row and in another column, not in one line.
        let longest = [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1]][trial % 4];
        for (x, y) in (0..9).map(|foot| (foot / 3, foot % 3)) {
            let long = if longest[x] == y { 0.004 } else { 0.0 };
            let place = 0.5 * DVec3::new(x as f64 - 1.0, y as f64 - 1.0, 0.0);
            let first = corners.len() as u32;
            let tip = DVec3::Z * (-0.2 - long - 1e-6 * random.unit());
            let around = [[0.1, 0.0], [-0.05, 0.0866], [-0.05, -0.0866]];
            corners.push(place + tip);
            corners.extend(around.map(|[u, v]| place + DVec3::new(u, v, 0.0)));
            let faces = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
            triangles.extend(faces.map(|face| face.map(|corner| first + corner)));
        }
        let body = solid(Mesh::from_f64(corners, triangles).unwrap());
        let foot = only(&floor, &body, at(0.0, 0.0, 0.5 + 0.204 + 0.005), 0.01);
        let bearing = foot.points().iter().filter(|point| point.distance < 0.0051);
        assert_eq!(bearing.count(), 3, "{trial}: {foot:?}");
    }
}
