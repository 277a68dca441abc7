//! A query that nothing stopped: on soups made to be nasty, and where the time of contact is known.

use punctual::glam::{DMat3, DVec3};
use punctual::impact::Impact;
use punctual::{Mesh, Motion, Pose, Query, StopReason, Tree, shapes};

use crate::common::meshes::{at, ball, cube, moved, nothing, one, placed, triangles};
use crate::common::random::{Drift, Family, pose_about, soup, soups};
use crate::judge::{Truth, answer};
use crate::random::Random;

/// The square `|x|, |y| <= half` in the plane `z = 0`, of `2 cells^2` triangles.
fn plate(half: f64, cells: u32) -> Tree {
    let at = |i: u32| half * (2.0 * f64::from(i) / f64::from(cells) - 1.0);
    let corner = |i, j| DVec3::new(at(i), at(j), 0.0);
    let squares = (0..cells * cells).map(|k| (k / cells, k % cells));
    Tree::new(triangles(squares.flat_map(|(i, j)| {
        let [p, q] = [corner(i, j + 1), corner(i + 1, j)];
        [[corner(i, j), p, q], [p, corner(i + 1, j + 1), q]]
    })))
}

pub fn straight(start: Pose, velocity: impl Into<DVec3>) -> Motion {
    Motion::straight(start, velocity.into()).unwrap()
}

/// B turns about its own origin meanwhile.
fn turning(start: Pose, velocity: impl Into<DVec3>, turn: impl Into<DVec3>) -> Motion {
    Motion::turning(start, velocity.into(), turn.into(), start.translation()).unwrap()
}

/// They meet at a time that is known, and the query tells it to within `width`.
#[track_caller]
fn assert_meet(query: &Query<Impact>, time: f64, width: f64) {
    let said = answer(query);
    let (lower, upper) = (said.value.lower, said.value.upper.expect("they meet"));
    assert!(lower <= time && time <= upper + 1e-15, "{time} {said:?}");
    assert!(upper - lower <= width, "{width} {said:?}");
}

#[track_caller]
fn assert_free(query: &Query<Impact>) -> u64 {
    let said = answer(query);
    let told = (said.value.lower, said.value.upper, said.stop);
    assert_eq!(told, (1.0, None, StopReason::Finished));
    said.stats.work
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
    let (mut touching, mut free) = (0, 0);
    for (a_triangles, b_triangles) in [(1, 1), (2, 7), (24, 16)] {
        let a = Tree::new(soup(family, a_triangles, &mut random));
        let b = Tree::new(soup(family, b_triangles, &mut random));
        for motion in motions(family, 12, &mut random) {
            let mut truth = Truth::new(&a, &b, motion);
            let said = answer(&truth.query);
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
    let mut touching = 0;
    for i in 0..30 {
        let [a, b] = [12, 20].map(|count| Tree::new(soup(Family::Double, count, &mut random)));
        let [of_a, of_b] = [0, 1].map(|_| motions(Family::Double, 1, &mut random)[0]);
        let mut truth = Truth::of(Query::impact_of_both([&a, &b], [of_a, of_b]), &a, &b);
        let said = answer(&truth.query);
        touching += u32::from(truth.assert_complete(&said, &mut random));
        // A body that stands still is one that does not move.
        let still = Motion::straight(Pose::IDENTITY, DVec3::ZERO).unwrap();
        let of_one = answer(&Query::impact(&a, &b, of_b));
        let of_two = answer(&Query::impact_of_both([&a, &b], [still, of_b]));
        let close = |x: f64, y: f64| (x - y).abs() < 1e-5;
        assert!(close(of_one.value.lower, of_two.value.lower), "{i}");
    }
    assert!(touching > 5);
}

/// Two boxes face to face: the time is the gap over the speed.
#[test]
fn the_time_of_contact_is_that_of_the_gap() {
    let (a, b) = (cube(5), cube(3));
    let tolerance = 2e-6 * a.unit_length().min(b.unit_length());
    for (gap, speed) in [
        (1.0, 4.0),
        (1e-6, 1.0),
        (1e2, 101.0),
        (1e-3, 1e-2),
        (0.5, 1e4),
        (3.0, 3.0),
    ] {
        let motion = straight(at(2.0 + gap, 0.3, 0.2), [-speed, 0.0, 0.0]);
        let query = Query::impact(&a, &b, motion);
        assert_meet(&query, gap / speed, tolerance / speed);
        let width = 1e-12 * (1.0 + 1.0 / speed);
        assert_meet(&query.tolerance(0.0), gap / speed, width);
    }
    // Just not reached.
    let motion = straight(at(3.0, 0.3, 0.2), [-1.0 + 1e-9, 0.0, 0.0]);
    assert_free(&Query::impact(&a, &b, motion));
}

/// The tolerance follows the smaller mesh: a ball lands as exactly on a slab as large as a town as on a table.
#[test]
fn the_default_tolerance_is_that_of_the_smaller_mesh() {
    let ball = Tree::new(moved(&shapes::icosphere(3), |vertex| 0.5 * vertex));
    let point = one([DVec3::ZERO; 3]);
    for half in [5.0_f32, 500.0, 50_000.0] {
        let slab = Tree::new(shapes::cuboid([half, half, 1.0], 16));
        let start = at(0.3 * f64::from(half), 0.2 * f64::from(half), 4.0);
        for turn in [0.0, 0.02] {
            let motion = turning(start, [0.0, 0.0, -10.0], [0.0, 0.0, turn]);
            let said = answer(&Query::impact(&slab, &ball, motion)).value;
            let late = said.upper.unwrap() - said.lower;
            assert!(late * 10.0 <= 2.1e-6 * ball.unit_length(), "{half}");
            assert!((said.lower - 0.25).abs() < 1e-6, "{half}");
            // A point that is a ball by its margin, and one that is not.
            let query = Query::impact(&slab, &point, motion);
            assert_meet(&query.margins([0.0, 0.5]), 0.25, 1.1e-7);
            let said = answer(&query);
            assert!((said.value.lower - 0.3).abs() < 1e-9, "{half} {turn}");
            assert!(said.stats.work < 100_000, "{half} {turn}");
        }
    }
}

/// What lies beside what is told by the directions across edges, where planes coincide.
#[test]
fn a_turn_in_its_own_plane_takes_little_more_than_one_beside_it() {
    let tree = one([DVec3::ZERO, DVec3::X, DVec3::Y]);
    let query = |place, height, angle| {
        let motion = turning(at(place, place, height), [0.0; 3], [0.0, 0.0, angle]);
        Query::impact(&tree, &tree, motion)
    };
    for place in [0.9, 1.3, 1.5] {
        for angle in [0.05, 1.0, 6.2] {
            let work = |height| answer(&query(place, height, angle)).stats.work;
            let [within, beside] = [0.0, 0.01].map(work);
            assert!(within <= 16 * beside, "{place} {angle} {within} {beside}");
        }
    }
    // The edge along y comes to the corner (0, 1), which is at (-.9, .1) from the axis.
    let nearest = (0.1_f64.atan2(-0.9) - std::f64::consts::FRAC_PI_2) / 6.2;
    assert_meet(&query(0.9, 0.0, 6.2), nearest, 1.0);
}

/// A rod that turns about its middle meets a wall when its end does: the angle is known. A short turn is that of a frame, and
/// one piece: the end of the rod comes near by the turn alone.
#[test]
fn the_time_of_contact_is_that_of_the_angle() {
    let rod = one([-DVec3::X, DVec3::X, DVec3::X]);
    let wall = plate(5.0, 4);
    for height in [0.9, 0.5, 0.1, 1e-3_f64] {
        let motion = turning(at(0.0, 0.0, height), [0.0; 3], [0.0, 1.6, 0.0]);
        assert_meet(
            &Query::impact(&wall, &rod, motion),
            height.asin() / 1.6,
            1e-5,
        );
    }
    let rod = one([-DVec3::X, DVec3::X, DVec3::Y * 0.1]);
    let still = straight(Pose::IDENTITY, [0.0; 3]);
    for angle in [0.06_f64, 0.03, 0.005] {
        for time in [0.02, 0.3, 0.7, 0.99, 1.01] {
            let start = at(0.0, 0.0, (time * angle).sin());
            let motion = turning(start, [0.0; 3], [0.0, angle, 0.0]);
            let of_one = Query::impact(&wall, &rod, motion);
            let of_both = Query::impact_of_both([&wall, &rod], [still, motion]);
            for query in [of_one, of_both] {
                if time < 1.0 {
                    assert_meet(&query, time, 1e-5 / angle);
                } else {
                    assert_free(&query);
                }
            }
        }
    }
}

#[test]
fn thin_plates_and_fast_bodies_are_not_passed_through() {
    let (plate, bullet) = (plate(3.0, 8), ball(2));
    for speed in [1e1, 1e4, 1e7, 1e9] {
        let motion = straight(at(0.21, -0.4, 0.37 * speed), [0.0, 0.0, -speed]);
        let said = answer(&Query::impact(&plate, &bullet, motion)).value;
        let (free, touching) = (said.lower, said.upper.unwrap());
        let width = 1e-5 * (1.0 + speed * 1e-9);
        assert!(
            free <= 0.37 && (touching - free) * speed <= width,
            "{said:?}"
        );
        let late = touching - (0.37 - 1.0 / speed);
        assert!(late.abs() < 0.02 / speed + 1e-9, "{speed}: {said:?}");
    }
}

/// Where lengths overflow, bounds are no numbers.
#[test]
fn a_motion_has_a_piece_even_if_meshes_are_too_large_for_lengths() {
    let far = 2_f64.powi(1000);
    let tree = one([DVec3::ZERO, DVec3::X * far, DVec3::Y * far]);
    for velocity in [[0.0; 3], [0.0, 0.0, 1.0]] {
        let query = Query::impact(&tree, &tree, straight(Pose::IDENTITY, velocity));
        assert_eq!(answer(&query).value.lower, 0.0);
    }
}

/// Squares of lengths overflow, lengths do not.
#[test]
fn nothing_is_free_where_a_mesh_of_1e301_meets_one_of_size_1() {
    let small = [[-3.0, -4.0, -4.0], [-4.0; 3], [1.0; 3]];
    let small = Tree::new(Mesh::from_f64(small, [[0, 1, 2], [0, 1, 1]]).unwrap());
    for size in [1e150, 1e155, 1e200, 1e300, 2_f64.powi(1000)] {
        let corners = [[-size; 3], [1.0; 3], [-size, -size, 1.0]];
        let large = Tree::new(Mesh::from_f64(corners, [[0, 1, 0], [2, 2, 1]]).unwrap());
        let way = size.min(1e200);
        for [a, b] in [[&small, &large], [&large, &small]] {
            for (way, turn) in [(0.0, 0.0), (1.0, 0.0), (way, 0.0), (0.0, 0.2), (1.0, 3.0)] {
                let [velocity, turn] = [DVec3::Y * way, DVec3::Z * turn];
                let motion = Motion::turning(Pose::IDENTITY, velocity, turn, [way; 3]).unwrap();
                let of_both = Query::impact_of_both([a, b], [motion; 2]);
                for query in [Query::impact(a, b, motion), of_both] {
                    let said = answer(&query);
                    assert!(said.value.lower == 0.0, "{size:e} {way:e} {turn}: {said:?}");
                }
            }
        }
    }
}

#[test]
fn standing_still_is_a_motion() {
    let (a, b) = (ball(2), Tree::new(shapes::torus(1.0, 0.3, 12)));
    for (start, meets) in [(at(0.3, 0.0, 0.0), true), (at(9.0, 0.0, 0.0), false)] {
        let turned = placed(DMat3::from_rotation_y(0.4), start.translation());
        for motion in [
            Motion::straight(start, DVec3::ZERO),
            Motion::screw(start, start),
            Motion::screw(turned, turned),
            Motion::turning(start, DVec3::ZERO, DVec3::ZERO, [5.0, 0.0, 0.0]),
        ] {
            let query = Query::impact(&a, &b, motion.unwrap());
            if meets {
                assert_meet(&query, 0.0, 0.0);
            } else {
                assert_free(&query);
            }
        }
    }
}

#[test]
fn empty_meshes_are_free() {
    let (empty, b) = (nothing(), ball(1));
    let motion = straight(at(3.0, 0.0, 0.0), [-6.0, 0.0, 0.0]);
    for (a, b) in [(&empty, &b), (&b, &empty), (&empty, &empty)] {
        assert_free(&Query::impact(a, b, motion));
    }
}

/// A ball and a capsule are a point and a segment with a margin.
#[test]
fn margins_make_contacts_earlier() {
    let (point, cube) = (one([DVec3::ZERO; 3]), cube(3));
    let motion = straight(at(4.0, 0.1, 0.2), [-4.0, 0.0, 0.0]);
    let query = Query::impact(&point, &cube, motion);
    for (margins, sum) in [
        ([0.0, 0.0], 0.0),
        ([0.5, 0.0], 0.5),
        ([0.25, 0.5], 0.75),
        ([2.0, 0.9], 2.9),
        ([3.0, 0.0], 3.0),
        ([7.0, 0.0], 7.0),
        ([f64::NAN, -1.0], 0.0),
    ] {
        let time = f64::max((3.0 - sum) / 4.0, 0.0);
        assert_meet(&query.margins(margins), time, 2e-6);
    }
}

/// The surfaces slide along each other and never meet; and they land flat.
#[test]
fn parallel_plates_slide_and_land() {
    let a = plate(1.0, 20);
    let b = Tree::new(shapes::cuboid([0.75, 0.75, 0.5], 12));
    for gap in [1e-3, 1e-6, 1e-9] {
        let start = at(0.3, 0.4, 0.5 + gap);
        let motion = |way| straight(start, [0.5, -0.2, way]);
        assert_free(&Query::impact(&a, &b, motion(0.0)));
        let said = answer(&Query::impact(&a, &b, motion(-2.0 * gap))).value;
        assert!(
            said.lower <= 0.5 && said.upper.unwrap() >= 0.5 - 1e-7,
            "{gap}"
        );
    }
}

#[test]
fn tolerances_are_kept() {
    let (a, b) = (Tree::new(shapes::torus(1.0, 0.3, 16)), ball(2));
    let (velocity, turn) = ([-4.0, 0.0, 0.0], [0.0, 0.5, 1.0]);
    let motion = Motion::turning(at(4.0, 0.2, 0.1), velocity, turn, [4.0, 0.0, 0.0]).unwrap();
    let query = Query::impact(&a, &b, motion);
    let mut last = 0.0;
    for tolerance in [1e-1, 1e-3, 1e-6, 1e-9, 0.0, f64::NAN] {
        let mut truth = Truth::of(query.tolerance(tolerance), &a, &b);
        let by_length = answer(&truth.query);
        assert!(truth.assert_complete(&by_length, &mut Random::new(1)));
        last = f64::max(last, by_length.value.lower);
        let by_time = answer(&query.tolerance(0.0).time_tolerance(tolerance));
        for said in [by_length, by_time] {
            let upper = said.value.upper.unwrap();
            assert!(upper - said.value.lower <= tolerance.max(1e-13), "{said:?}");
            assert!(upper >= last, "{said:?}");
        }
    }
}

/// Eight triangles go down the tree of a fine mesh together, each by its box and its plane.
#[test]
fn large_triangles_do_not_pass_through_fine_meshes() {
    let (mut random, ball) = (Random::new(41), ball(2));
    let mut touching = 0;
    for i in 0..24 {
        let sails = Tree::new(triangles(
            (0..9).map(|_| [0; 3].map(|_| random.vector() * 1.5)),
        ));
        let start = pose_about(DVec3::ZERO, 1.0, Drift::None, &mut random);
        let start = placed(*start.rotation(), random.vector().normalize() * 4.0);
        let velocity = start.translation() * -1.2 + random.vector() * 2.5;
        let turn = random.vector() * f64::from(i % 3) * 0.5;
        let trees = [[&ball, &sails], [&sails, &ball]];
        let [a, b] = trees[i as usize % 2];
        let mut truth = Truth::new(a, b, turning(start, velocity, turn));
        let said = answer(&truth.query);
        touching += u32::from(truth.assert_complete(&said, &mut random));
    }
    assert!((6..22).contains(&touching), "{touching} of 24");
}

/// What matters is how far a mesh is from the axis of its turn, not where along it, nor where the mesh has its origin.
#[test]
fn a_mesh_far_along_its_axis_is_no_dearer() {
    let ball = ball(2);
    let work = [0.0, 1e4, 1e8].map(|far| {
        let away = DVec3::new(0.3, 0.7, far);
        let other = Tree::new(moved(ball.mesh(), |vertex| vertex + away));
        let pose = |turn, x| {
            let turn = DMat3::from_rotation_z(turn);
            placed(turn, DVec3::new(x, 0.2, 0.0) - turn * away)
        };
        let motion = Motion::screw(pose(0.0, 5.2), pose(0.3, 2.2)).unwrap();
        assert_free(&Query::impact(&ball, &other, motion))
    });
    assert!(work.iter().all(|units| *units <= 2 * work[0]), "{work:?}");
}

/// What matters is how one body turns against the other: here a gear that rolls on one, while both are carried around by up to a
/// radian.
#[test]
fn bodies_that_turn_together_are_little_dearer() {
    let gear = Tree::new(shapes::gear(24, 8));
    let work = [0.0, 0.1, 1.0].map(|angle| {
        let turn = [angle, 0.0, -angle / 2.0];
        let carried = Motion::turning(Pose::IDENTITY, [0.1, 0.0, 0.2], turn, [1.0, 3.0, 0.0]);
        let carried = carried.unwrap();
        let place = |time: f64, turn: f64| {
            let beside = placed(DMat3::from_rotation_z(turn), [2.02, 0.0, 0.0]);
            carried.pose(time).compose(&beside).unwrap()
        };
        let rolling = Motion::screw(place(0.0, 0.13), place(1.0, 0.16)).unwrap();
        assert_free(&Query::impact_of_both([&gear, &gear], [carried, rolling]))
    });
    let [alone, slow, fast] = work;
    assert!(slow <= 2 * alone && fast <= 20 * alone, "{work:?}");
}
