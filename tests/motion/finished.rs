//! A query that nothing stopped: on soups made to be nasty, and where the time of contact is known.

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Mesh, Motion, Pose, Query, StopReason, Tree, Workspace, shapes};

use crate::common::random::{Drift, Family, pose_about, soup, soups};
use crate::judge::{ENOUGH, Truth, run};
use crate::random::Random;

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

/// The square `|x|, |y| <= half` in the plane `z = 0`, of `2 cells^2` triangles.
fn plate(half: f64, cells: u32) -> Mesh {
    let at = |i: u32| half * (2.0 * f64::from(i) / f64::from(cells) - 1.0);
    let corners = (0..=cells).flat_map(|i| (0..=cells).map(move |j| DVec3::new(at(i), at(j), 0.0)));
    let quads = (0..cells).flat_map(|i| (0..cells).map(move |j| i * (cells + 1) + j));
    let triangles = quads.flat_map(|k| {
        [
            [k, k + 1, k + cells + 1],
            [k + 1, k + cells + 2, k + cells + 1],
        ]
    });
    Mesh::from_f64(corners, triangles).unwrap()
}

/// Straight lines, turns about near and far axes, and screws, that lead past the middle of a soup; none where numbers are
/// beyond what motions take.
pub fn motions(family: Family, count: usize, random: &mut Random) -> Vec<Motion> {
    let (scale, center) = (family.scale(), family.center());
    let mut motions = Vec::new();
    for i in 0..count {
        let start = pose_about(
            center,
            2.0 * scale,
            [Drift::None, Drift::Shear][i % 2],
            random,
        );
        let to_middle = center - start.transform_point(center);
        let velocity = to_middle * 2.0 + random.vector() * scale;
        let turn = random.vector() * [0.3, 3.0, 40.0][random.below(3)];
        let motion = match random.below(4) {
            0 => Motion::straight(start, velocity),
            1 => Motion::turning(start, velocity, turn, start.transform_point(center)),
            2 => Motion::turning(
                start,
                velocity * 0.1,
                turn,
                center + random.vector() * scale * 3.0,
            ),
            _ => Motion::screw(start, pose_about(center, 2.0 * scale, Drift::None, random)),
        };
        motions.extend(motion);
    }
    motions
}

fn assert_soups_true(family: Family) {
    let mut random = Random::new(family as u64 + 300);
    let mut workspace = Workspace::new();
    let (mut touching, mut free) = (0, 0);
    for (a_triangles, b_triangles) in [(1, 1), (2, 7), (24, 16)] {
        let a = Tree::new(soup(family, a_triangles, &mut random));
        let b = Tree::new(soup(family, b_triangles, &mut random));
        for motion in motions(family, 12, &mut random) {
            let mut truth = Truth::new(&a, &b, motion);
            let said = run(&truth.query, &mut workspace, ENOUGH);
            match truth.assert_complete(&said, &mut random) {
                true => touching += 1,
                false => free += 1,
            }
        }
    }
    println!("{touching} touch, {free} do not");
    let rare = matches!(family, Family::Enormous | Family::Nested);
    assert!(rare || touching > 3 && free > 0, "{touching} and {free}");
}

soups!(assert_soups_true);

#[test]
fn both_bodies_may_move() {
    let mut random = Random::new(31);
    let mut workspace = Workspace::new();
    let mut touching = 0;
    for i in 0..30 {
        let [a, b] = [12, 20].map(|count| Tree::new(soup(Family::Double, count, &mut random)));
        let [of_a, of_b] = [0, 1].map(|_| motions(Family::Double, 1, &mut random)[0]);
        let mut truth = Truth::of(Query::impact_of_both([&a, &b], [of_a, of_b]), &a, &b);
        let said = run(&truth.query, &mut workspace, ENOUGH);
        touching += u32::from(truth.assert_complete(&said, &mut random));
        // A body that stands still is one that does not move.
        let still = Motion::straight(Pose::IDENTITY, DVec3::ZERO).unwrap();
        let of_one = run(&Query::impact(&a, &b, of_b), &mut workspace, ENOUGH);
        let of_two = run(
            &Query::impact_of_both([&a, &b], [still, of_b]),
            &mut workspace,
            ENOUGH,
        );
        let close = |x: f64, y: f64| (x - y).abs() < 1e-5;
        assert!(
            close(of_one.value.lower, of_two.value.lower),
            "{i}: {of_one:?} {of_two:?}"
        );
    }
    assert!(touching > 5);
}

fn half_ball() -> Mesh {
    let ball = shapes::icosphere(3);
    Mesh::from_f64(
        (0..ball.vertex_count()).map(|i| 0.5 * ball.vertex(i)),
        ball.triangles().iter().copied(),
    )
    .unwrap()
}

/// Two boxes face to face: the time is the gap over the speed.
#[test]
fn the_time_of_contact_is_that_of_the_gap() {
    let cube = |cells| Tree::new(shapes::cuboid(Vec3::ONE, cells));
    let (a, b, mut workspace) = (cube(5), cube(3), Workspace::new());
    for (gap, speed) in [
        (1.0, 4.0),
        (1e-6, 1.0),
        (100.0, 101.0),
        (1e-3, 1e-2),
        (0.5, 1e4),
        (3.0, 3.0),
    ] {
        let motion = Motion::straight(at(2.0 + gap, 0.3, 0.2), [-speed, 0.0, 0.0]).unwrap();
        let said = run(&Query::impact(&a, &b, motion), &mut workspace, ENOUGH);
        let time = gap / speed;
        let touching = said.value.upper.unwrap();
        assert!(
            said.value.lower <= time && time <= touching,
            "{gap} {speed}: {said:?}"
        );
        let tolerance = 2e-6 * a.unit_length().min(b.unit_length());
        assert!(
            (touching - said.value.lower) * speed <= tolerance,
            "{gap} {speed}: {said:?}"
        );
        let exact = run(
            &Query::impact(&a, &b, motion).tolerance(0.0),
            &mut workspace,
            ENOUGH,
        );
        assert!(
            (exact.value.upper.unwrap() - exact.value.lower) * speed <= 1e-12 * (1.0 + speed),
            "{exact:?}"
        );
        assert!(
            exact.value.lower <= time && time <= exact.value.upper.unwrap() + 1e-15,
            "{exact:?}"
        );
    }
    // Just not reached.
    let motion = Motion::straight(at(3.0, 0.3, 0.2), [-1.0 + 1e-9, 0.0, 0.0]).unwrap();
    let said = run(&Query::impact(&a, &b, motion), &mut workspace, ENOUGH);
    assert_eq!((said.value.lower, said.value.upper), (1.0, None));
}

/// The tolerance follows the smaller mesh: a ball lands as exactly on a slab as large as a town as on a table.
#[test]
fn the_default_tolerance_is_that_of_the_smaller_mesh() {
    let ball = Tree::new(half_ball());
    let point = Tree::new(Mesh::from_f64([DVec3::ZERO], [[0, 0, 0]]).unwrap());
    let mut workspace = Workspace::new();
    for half in [5.0_f32, 500.0, 50_000.0] {
        let slab = Tree::new(shapes::cuboid([half, half, 1.0], 16));
        for turn in [0.0, 0.02] {
            let start = at(0.3 * f64::from(half), 0.2 * f64::from(half), 4.0);
            let motion = Motion::turning(
                start,
                [0.0, 0.0, -10.0],
                [0.0, 0.0, turn],
                start.translation(),
            )
            .unwrap();
            let said = run(&Query::impact(&slab, &ball, motion), &mut workspace, ENOUGH);
            let late = said.value.upper.unwrap() - said.value.lower;
            assert!(
                late * 10.0 <= 2.1e-6 * ball.unit_length(),
                "{half} {turn}: {said:?}"
            );
            assert!(
                (said.value.lower - 0.25).abs() < 1e-6,
                "{half} {turn}: {said:?}"
            );
            // A point that is a ball by its margin, and one that is not.
            let thick = Query::impact(&slab, &point, motion).margins([0.0, 0.5]);
            let said = run(&thick, &mut workspace, ENOUGH);
            let late = said.value.upper.unwrap() - said.value.lower;
            assert!(
                late * 10.0 <= 1.1e-6 && (said.value.lower - 0.25).abs() < 1e-6,
                "{half} {turn}: {said:?}"
            );
            let said = run(
                &Query::impact(&slab, &point, motion),
                &mut workspace,
                ENOUGH,
            );
            assert!(
                (said.value.lower - 0.3).abs() < 1e-9 && said.stats.work < 100_000,
                "{half} {turn}: {said:?}"
            );
        }
    }
}

/// What lies beside what is told by the directions across edges, where planes coincide.
#[test]
fn a_turn_in_its_own_plane_takes_little_more_than_one_beside_it() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let tree = Tree::new(Mesh::from_f64(corners, [[0, 1, 2]]).unwrap());
    let mut workspace = Workspace::new();
    for place in [0.9, 1.3, 1.5] {
        for angle in [0.05, 1.0, 6.2] {
            let mut work = |height: f64| {
                let start = at(place, place, height);
                let motion =
                    Motion::turning(start, [0.0; 3], [0.0, 0.0, angle], start.translation())
                        .unwrap();
                run(&Query::impact(&tree, &tree, motion), &mut workspace, ENOUGH)
                    .stats
                    .work
            };
            let [within, beside] = [0.0, 0.01].map(&mut work);
            assert!(
                within <= 16 * beside,
                "{place} {angle}: {within} and {beside}"
            );
        }
    }
    // The time at which they meet is that of the angle.
    let start = at(0.9, 0.9, 0.0);
    let motion = Motion::turning(start, [0.0; 3], [0.0, 0.0, 6.2], start.translation()).unwrap();
    let said = run(&Query::impact(&tree, &tree, motion), &mut workspace, ENOUGH);
    // The edge along y comes to the corner (0, 1), which is at (-.9, .1) from the axis.
    let nearest = (0.1_f64.atan2(-0.9) - std::f64::consts::FRAC_PI_2) / 6.2;
    assert!(
        said.value.lower <= nearest && nearest <= said.value.upper.unwrap() + 1e-12,
        "{nearest} {said:?}"
    );
}

/// A rod that turns about its middle meets a wall when its end does: the angle is known.
#[test]
fn the_time_of_contact_is_that_of_the_angle() {
    let rod = Tree::new(Mesh::from_f64([-DVec3::X, DVec3::X], [[0, 1, 1]]).unwrap());
    let wall = Tree::new(plate(5.0, 4));
    let mut workspace = Workspace::new();
    for height in [0.9, 0.5, 0.1, 1e-3] {
        let start = at(0.0, 0.0, height);
        let motion = Motion::turning(start, DVec3::ZERO, [0.0, 1.6, 0.0], start.translation());
        let said = run(
            &Query::impact(&wall, &rod, motion.unwrap()),
            &mut workspace,
            ENOUGH,
        );
        let time = height.asin() / 1.6;
        assert!(
            said.value.lower <= time && time <= said.value.upper.unwrap(),
            "{time}: {said:?}"
        );
        assert!(
            said.value.upper.unwrap() - said.value.lower < 1e-5,
            "{time}: {said:?}"
        );
    }
}

/// The same in the turn of a frame, which is one piece: the end of the rod comes near by the turn alone.
#[test]
fn the_time_of_contact_in_a_short_turn_is_that_of_the_angle() {
    let rod =
        Tree::new(Mesh::from_f64([-DVec3::X, DVec3::X, DVec3::Y * 0.1], [[0, 1, 2]]).unwrap());
    let wall = Tree::new(plate(5.0, 4));
    let mut workspace = Workspace::new();
    for angle in [0.06_f64, 0.03, 0.005] {
        for time in [0.02, 0.3, 0.7, 0.99, 1.01] {
            let start = at(0.0, 0.0, (time * angle).sin());
            let motion =
                Motion::turning(start, DVec3::ZERO, [0.0, angle, 0.0], start.translation())
                    .unwrap();
            for query in [
                Query::impact(&wall, &rod, motion),
                Query::impact_of_both(
                    [&wall, &rod],
                    [
                        Motion::straight(Pose::IDENTITY, DVec3::ZERO).unwrap(),
                        motion,
                    ],
                ),
            ] {
                let said = run(&query, &mut workspace, ENOUGH);
                assert_eq!(
                    said.value.upper.is_some(),
                    time < 1.0,
                    "{angle} {time}: {said:?}"
                );
                assert!(
                    said.value.lower <= time
                        && said
                            .value
                            .upper
                            .is_none_or(|touching| time <= touching + 1e-15)
                );
                assert!(
                    said.value
                        .upper
                        .is_none_or(|touching| (touching - said.value.lower) * angle < 1e-5)
                );
            }
        }
    }
}

#[test]
fn thin_plates_and_fast_bodies_are_not_passed_through() {
    let plate = Tree::new(plate(3.0, 8));
    let bullet = Tree::new(shapes::icosphere(2));
    let mut workspace = Workspace::new();
    for speed in [1e1, 1e4, 1e7, 1e9] {
        let start = at(0.21, -0.4, 0.37 * speed);
        let motion = Motion::straight(start, [0.0, 0.0, -speed]).unwrap();
        let said = run(
            &Query::impact(&plate, &bullet, motion),
            &mut workspace,
            ENOUGH,
        );
        let (free, touching) = (said.value.lower, said.value.upper.unwrap());
        assert!(
            free <= 0.37 && (touching - free) * speed <= 1e-5 * (1.0 + speed * 1e-9),
            "{speed}: {said:?}"
        );
        assert!(
            (touching - (0.37 - 1.0 / speed)).abs() < 0.02 / speed + 1e-9,
            "{speed}: {said:?}"
        );
    }
}

/// Nothing moves, or the motion ends where it begins.
/// Where lengths overflow, bounds are no numbers.
#[test]
fn a_motion_has_a_piece_even_if_meshes_are_too_large_for_lengths() {
    let far = f64::from_bits((1023 + 1000) << 52);
    let mesh =
        || Mesh::from_f64([[0.0; 3], [far, 0.0, 0.0], [0.0, far, 0.0]], [[0, 1, 2]]).unwrap();
    let (a, b) = (Tree::new(mesh()), Tree::new(mesh()));
    for velocity in [[0.0; 3], [0.0, 0.0, 1.0]] {
        let motion = Motion::straight(Pose::IDENTITY, velocity).unwrap();
        let said = run(
            &Query::impact(&a, &b, motion),
            &mut Workspace::new(),
            ENOUGH,
        );
        assert!(said.value.lower == 0.0, "{said:?}");
    }
}

/// Squares of lengths overflow, lengths do not.
#[test]
fn nothing_is_free_where_a_mesh_of_1e301_meets_one_of_size_1() {
    let small = || {
        Mesh::from_f64(
            [[-3.0, -4.0, -4.0], [-4.0; 3], [1.0; 3]],
            [[0, 1, 2], [0, 1, 1]],
        )
        .unwrap()
    };
    for size in [
        1e150,
        1e155,
        1e200,
        1e300,
        f64::from_bits((1023 + 1000) << 52),
    ] {
        let corners = [[-size; 3], [1.0; 3], [-size, -size, 1.0]];
        let large = || Mesh::from_f64(corners, [[0, 1, 0], [2, 2, 1]]).unwrap();
        for meshes in [[small(), large()], [large(), small()]] {
            let [a, b] = meshes.map(Tree::new);
            for (way, turn) in [
                (0.0, 0.0),
                (1.0, 0.0),
                (size.min(1e200), 0.0),
                (0.0, 0.2),
                (1.0, 3.0),
            ] {
                let motion =
                    Motion::turning(Pose::IDENTITY, [0.0, way, 0.0], [0.0, 0.0, turn], [way; 3])
                        .unwrap();
                for query in [
                    Query::impact(&a, &b, motion),
                    Query::impact_of_both([&a, &b], [motion; 2]),
                ] {
                    let said = run(&query, &mut Workspace::new(), ENOUGH);
                    assert!(said.value.lower == 0.0, "{size:e} {way:e} {turn}: {said:?}");
                }
            }
        }
    }
}

#[test]
fn standing_still_is_a_motion() {
    let (a, b) = (
        Tree::new(shapes::icosphere(2)),
        Tree::new(shapes::torus(1.0, 0.3, 12)),
    );
    let mut workspace = Workspace::new();
    for (start, meets) in [(at(0.3, 0.0, 0.0), true), (at(9.0, 0.0, 0.0), false)] {
        let turned = Pose::new(DMat3::from_rotation_y(0.4), start.translation()).unwrap();
        for motion in [
            Motion::straight(start, DVec3::ZERO),
            Motion::screw(start, start),
            Motion::screw(turned, turned),
            Motion::turning(start, DVec3::ZERO, DVec3::ZERO, [5.0, 0.0, 0.0]),
        ] {
            let said = run(
                &Query::impact(&a, &b, motion.unwrap()),
                &mut workspace,
                ENOUGH,
            );
            assert_eq!(said.stop, StopReason::Finished);
            let expected = if meets { (0.0, Some(0.0)) } else { (1.0, None) };
            assert_eq!((said.value.lower, said.value.upper), expected);
        }
    }
}

#[test]
fn empty_meshes_are_free() {
    let (empty, b) = (
        Tree::new(Mesh::from_f64([DVec3::ZERO; 0], []).unwrap()),
        Tree::new(shapes::icosphere(1)),
    );
    let motion = Motion::straight(at(3.0, 0.0, 0.0), [-6.0, 0.0, 0.0]).unwrap();
    for (a, b) in [(&empty, &b), (&b, &empty), (&empty, &empty)] {
        let said = run(&Query::impact(a, b, motion), &mut Workspace::new(), ENOUGH);
        assert_eq!(
            (said.value.lower, said.value.upper, said.stop),
            (1.0, None, StopReason::Finished)
        );
    }
}

/// A ball and a capsule are a point and a segment with a margin.
#[test]
fn margins_make_contacts_earlier() {
    let point = Tree::new(Mesh::from_f64([DVec3::ZERO], [[0, 0, 0]]).unwrap());
    let (b, mut workspace) = (Tree::new(shapes::cuboid(Vec3::ONE, 3)), Workspace::new());
    let motion = Motion::straight(at(4.0, 0.1, 0.2), [-4.0, 0.0, 0.0]).unwrap();
    for margins in [
        [0.0, 0.0],
        [0.5, 0.0],
        [0.25, 0.5],
        [2.0, 0.9],
        [3.0, 0.0],
        [7.0, 0.0],
        [f64::NAN, -1.0],
    ] {
        let query = Query::impact(&point, &b, motion).margins(margins);
        let said = run(&query, &mut workspace, ENOUGH);
        let margin: f64 = margins.iter().filter(|margin| **margin > 0.0).sum();
        let time = ((3.0 - margin) / 4.0).max(0.0);
        let touching = said.value.upper.unwrap();
        assert!(
            said.value.lower <= time && time <= touching + 1e-15,
            "{margin}: {said:?}"
        );
        assert!(touching - said.value.lower <= 2e-6, "{margin}: {said:?}");
    }
}

/// The surfaces slide along each other and never meet; and they land flat.
#[test]
fn parallel_plates_slide_and_land() {
    let (a, mut workspace) = (Tree::new(plate(1.0, 20)), Workspace::new());
    let b = Tree::new(shapes::cuboid(Vec3::new(0.75, 0.75, 0.5), 12));
    for gap in [1e-3, 1e-6, 1e-9] {
        let slide = Motion::straight(at(0.3, 0.4, 0.5 + gap), [0.5, -0.2, 0.0]).unwrap();
        let said = run(&Query::impact(&a, &b, slide), &mut workspace, ENOUGH);
        assert_eq!(
            (said.value.lower, said.value.upper),
            (1.0, None),
            "{gap}: {said:?}"
        );
        let land = Motion::straight(at(0.3, 0.4, 0.5 + gap), [0.5, -0.2, -2.0 * gap]).unwrap();
        let said = run(&Query::impact(&a, &b, land), &mut workspace, ENOUGH);
        assert!(
            said.value.lower <= 0.5 && said.value.upper.unwrap() >= 0.5 - 1e-7,
            "{gap}: {said:?}"
        );
    }
}

#[test]
fn tolerances_are_kept() {
    let (a, b) = (
        Tree::new(shapes::torus(1.0, 0.3, 16)),
        Tree::new(shapes::icosphere(2)),
    );
    let motion = Motion::turning(
        at(4.0, 0.2, 0.1),
        [-4.0, 0.0, 0.0],
        [0.0, 0.5, 1.0],
        [4.0, 0.0, 0.0],
    )
    .unwrap();
    let mut workspace = Workspace::new();
    let mut last = 0.0;
    for tolerance in [1e-1, 1e-3, 1e-6, 1e-9, 0.0, f64::NAN] {
        let mut truth = Truth::of(Query::impact(&a, &b, motion).tolerance(tolerance), &a, &b);
        let said = run(&truth.query, &mut workspace, ENOUGH);
        assert!(truth.assert_complete(&said, &mut Random::new(1)));
        assert!(
            said.value.upper.unwrap() - said.value.lower <= tolerance.max(1e-13),
            "{said:?}"
        );
        last = f64::max(last, said.value.lower);
        let by_time = Query::impact(&a, &b, motion)
            .tolerance(0.0)
            .time_tolerance(tolerance);
        let said = run(&by_time, &mut workspace, ENOUGH);
        assert!(
            said.value.upper.unwrap() - said.value.lower <= tolerance.max(1e-13),
            "{said:?}"
        );
        assert!(said.value.upper.unwrap() >= last, "{said:?}");
    }
}

/// Eight triangles go down the tree of a fine mesh together, each by its box and its plane.
#[test]
fn large_triangles_do_not_pass_through_fine_meshes() {
    let (mut random, mut workspace) = (Random::new(41), Workspace::new());
    let ball = Tree::new(shapes::icosphere(2));
    let (mut touching, mut free) = (0, 0);
    for i in 0..24 {
        let corners: Vec<DVec3> = (0..27).map(|_| random.vector() * 1.5).collect();
        let sails = Tree::new(
            Mesh::from_f64(corners, (0..9).map(|k| [3 * k, 3 * k + 1, 3 * k + 2])).unwrap(),
        );
        let start = pose_about(DVec3::ZERO, 1.0, Drift::None, &mut random);
        let start = Pose::new(*start.rotation(), random.vector().normalize() * 4.0).unwrap();
        let velocity = start.translation() * -1.2 + random.vector() * 2.5;
        let turn = random.vector() * f64::from(i % 3) * 0.5;
        let motion = Motion::turning(start, velocity, turn, start.translation()).unwrap();
        let [a, b] = if i % 2 == 0 {
            [&ball, &sails]
        } else {
            [&sails, &ball]
        };
        let mut truth = Truth::new(a, b, motion);
        let said = run(&truth.query, &mut workspace, ENOUGH);
        match truth.assert_complete(&said, &mut random) {
            true => touching += 1,
            false => free += 1,
        }
    }
    assert!(touching > 5 && free > 2, "{touching} and {free}");
}

/// What matters is how far a mesh is from the axis of its turn, not where along it, nor where the mesh has its origin.
#[test]
fn a_mesh_far_along_its_axis_is_no_dearer() {
    let (ball, mut workspace) = (Tree::new(shapes::icosphere(2)), Workspace::new());
    let mut work = Vec::new();
    for far in [0.0, 1e4, 1e8] {
        let away = DVec3::new(0.3, 0.7, far);
        let mesh = ball.mesh();
        let vertices = (0..mesh.vertex_count()).map(|vertex| mesh.vertex(vertex) + away);
        let moved = Tree::new(Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap());
        let pose = |turn, x| {
            let turn = DMat3::from_rotation_z(turn);
            Pose::new(turn, DVec3::new(x, 0.2, 0.0) - turn * away).unwrap()
        };
        let motion = Motion::screw(pose(0.0, 5.2), pose(0.3, 2.2)).unwrap();
        let said = run(
            &Query::impact(&ball, &moved, motion),
            &mut workspace,
            ENOUGH,
        );
        assert_eq!((said.value.lower, said.value.upper), (1.0, None));
        work.push(said.stats.work);
    }
    assert!(work.iter().all(|units| *units <= 2 * work[0]), "{work:?}");
}

/// What matters is how one body turns against the other: here a gear that rolls on one, while both are carried around by up to a
/// radian.
#[test]
fn bodies_that_turn_together_are_little_dearer() {
    let (gear, mut workspace) = (Tree::new(shapes::gear(24, 8)), Workspace::new());
    let beside =
        |turn: f64| Pose::new(DMat3::from_rotation_z(turn), DVec3::new(2.02, 0.0, 0.0)).unwrap();
    let mut work = Vec::new();
    for angle in [0.0, 0.1, 1.0] {
        let carried = Motion::turning(
            Pose::IDENTITY,
            [0.1, 0.0, 0.2],
            [angle, 0.0, -angle / 2.0],
            [1.0, 3.0, 0.0],
        )
        .unwrap();
        let place = |time: f64, turn: f64| carried.pose(time).compose(&beside(turn)).unwrap();
        let rolling = Motion::screw(place(0.0, 0.13), place(1.0, 0.16)).unwrap();
        let said = run(
            &Query::impact_of_both([&gear, &gear], [carried, rolling]),
            &mut workspace,
            ENOUGH,
        );
        assert_eq!((said.value.lower, said.value.upper), (1.0, None));
        work.push(said.stats.work);
    }
    assert!(
        work[1] <= 2 * work[0] && work[2] <= 20 * work[0],
        "{work:?}"
    );
}
