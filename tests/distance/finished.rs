//! A query that nothing stopped, against brute force over all pairs: on soups made to be nasty and on surfaces.

use punctual::distance::Bounds;
use punctual::glam::{DMat3, DVec3};
use punctual::{
    Answer, Budget, Mesh, Mode, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes,
};

use crate::common::meshes::{at, ball, moved, nothing, placed, triangles};
use crate::common::random::{Drift, Family, Random, pose_about, poses, soup, soups};
use crate::distance::{ENOUGH, Question, Truth, answer, run};

pub fn scaled(mesh: &Mesh, factor: f64, offset: DVec3) -> Mesh {
    moved(mesh, |vertex| factor * vertex + offset)
}

/// Every kind of question, both ways round; whether they meet.
#[track_caller]
fn assert_true(a: &Tree, b: &Tree, pose: Pose) -> bool {
    let mut workspace = Workspace::new();
    let mut truth = Truth::new(a, b, &pose);
    for asked in truth.questions() {
        let said = run(&asked.query(a, b, pose), &mut workspace, ENOUGH);
        truth.assert_complete(&asked, &said);
    }
    // The pose back is rounded, so this is another question.
    let inverse = pose.inverse().unwrap();
    let mut other = Truth::new(b, a, &inverse);
    let said = answer(&Question::EXACT.query(b, a, inverse));
    other.assert_complete(&Question::EXACT, &said);
    truth.meet()
}

/// Near each other, and as far apart as their size and more.
fn assert_soups_true(family: Family) {
    let mut random = Random::new(family as u64 + 100);
    let (mut touching, mut apart) = (0, 0);
    // No farther than poses go.
    let farthest = if family == Family::Enormous {
        8.0
    } else {
        30.0
    };
    for counts in [[1, 1], [3, 9], [30, 30]] {
        let [a, b] = counts.map(|count| Tree::new(soup(family, count, &mut random)));
        let near = poses(family, 6, &mut random);
        let far = [1.5, 4.0, farthest].map(|reach| {
            let turned = pose_about(family.center(), 0.0, Drift::Shear, &mut random);
            let way = random.vector().normalize() * reach * family.scale();
            placed(*turned.rotation(), turned.translation() + way)
        });
        let poses = near.into_iter().chain(far).map(|pose| (&b, pose));
        for (b, pose) in poses.chain([(&a, Pose::IDENTITY)]) {
            match assert_true(&a, b, pose) {
                true => touching += 1,
                false => apart += 1,
            }
        }
    }
    println!("{touching} meet, {apart} do not");
    assert!(touching > 0 && apart > 5, "{touching} and {apart}");
}

soups!(assert_soups_true);

#[test]
fn shapes_against_shapes() {
    let mut random = Random::new(77);
    let trees = [
        shapes::icosphere(1),
        shapes::cuboid([0.8, 0.5, 0.1], 2),
        shapes::torus(1.0, 0.2, 8),
        shapes::torus_knot(2, 3, 0.15, 8),
        shapes::gear(7, 1),
    ]
    .map(Tree::new);
    for (a, b) in trees.iter().flat_map(|a| trees.iter().map(move |b| (a, b))) {
        for (drift, reach) in [(Drift::None, 0.5), (Drift::Scale, 2.0), (Drift::Shear, 6.0)] {
            assert_true(a, b, pose_about(DVec3::ZERO, reach, drift, &mut random));
        }
    }
}

/// A plate of squares in the plane z = 0, turned.
fn plate(squares: u32, turn: DMat3) -> Tree {
    let corner =
        |x: u32, y: u32| turn * DVec3::new(f64::from(x), f64::from(y), 0.0) / f64::from(squares);
    let places = (0..squares * squares).map(|i| (i % squares, i / squares));
    Tree::new(triangles(places.flat_map(|(x, y)| {
        let [p, q] = [corner(x, y), corner(x + 1, y)];
        let [r, s] = [corner(x + 1, y + 1), corner(x, y + 1)];
        [[p, q, r], [p, r, s]]
    })))
}

fn tilt() -> DMat3 {
    DMat3::from_rotation_x(1.0) * DMat3::from_rotation_z(0.7)
}

/// All pairs of triangles above one another are equally far apart.
#[test]
fn parallel_plates() {
    for turn in [DMat3::IDENTITY, tilt()] {
        let tree = plate(5, turn);
        for gap in [1.0, 1e-2, 1e-5, 1e-8, 1e-13, 1e-16, 0.0] {
            let along = turn * DVec3::new(0.013, 0.021, gap);
            assert_true(&tree, &tree, placed(DMat3::IDENTITY, along));
            // Not quite parallel.
            let tilted = turn * DMat3::from_rotation_x(1e-3 * gap) * turn.transpose();
            assert_true(&tree, &tree, placed(tilted, along));
        }
    }
}

/// Plates that are closer than the margins of `f32` allow to tell are parted high up in the trees. Before, every triangle was
/// compared with those above it: 9 to 27 million units of work.
#[test]
fn plates_that_nearly_touch_take_little_work() {
    const LITTLE: u64 = 200_000;
    let other = DMat3::from_rotation_y(2.0) * DMat3::from_rotation_x(0.4);
    for [of_a, of_b] in [[DMat3::IDENTITY; 2], [tilt(); 2], [tilt(), other]] {
        let (a, b) = (plate(100, of_a), plate(91, of_b));
        for (angle, gap) in [(0.0, 5e-6), (0.3, 5e-6), (0.0, 5e-7), (0.3, 5e-7)] {
            let turn = of_a * DMat3::from_rotation_z(angle) * of_b.transpose();
            let pose = placed(turn, of_a * DVec3::new(0.013, 0.021, gap));
            let query = Query::distance(&a, &b, pose);
            for query in [query, query.absolute_tolerance(1e-4)] {
                let Answer {
                    value, stop, stats, ..
                } = answer(&query);
                // Below the tolerance all that is asked is whether they meet.
                let [low, high] = [gap * (1.0 - 1e-9), gap * (1.0 + 1e-9)];
                assert!(value.low <= high && low <= value.high, "{value:?}");
                assert_eq!(stop, StopReason::Finished);
                assert!(stats.work < LITTLE, "{stats:?}");
            }
            for mode in [Mode::Any, Mode::All] {
                let said = answer(&Query::intersection(&a, &b, pose).mode(mode));
                assert_eq!(said.value, Verdict::Separated);
                assert!(said.stats.work < LITTLE, "{}", said.stats.work);
            }
        }
    }
}

/// Who leaves contact open has an answer as soon as `high` is within the tolerance, whether the plates meet or not; what is
/// farther apart is told as ever.
#[test]
fn plates_within_the_tolerance_take_little_work_if_contact_is_left_open() {
    const TOLERANCE: f64 = 1e-4;
    let (a, b) = (plate(100, tilt()), plate(91, tilt()));
    for gap in [0.0, 1e-16, 1e-12, 1e-8, 1e-7, 1e-6, 9e-5, 2e-4] {
        let pose = placed(DMat3::IDENTITY, tilt() * DVec3::new(0.013, 0.021, gap));
        let query = Query::distance(&a, &b, pose).absolute_tolerance(TOLERANCE);
        let said = answer(&query.leave_contact_open(true));
        let Bounds { low, high, .. } = said.value;
        assert!(said.stats.work < 50_000, "{gap:e}: {said:?}");
        assert_eq!(said.stop, StopReason::Finished);
        assert!(
            low <= gap + 1e-15 && gap <= high + 1e-15,
            "{gap:e}: {said:?}"
        );
        assert!(high - low <= TOLERANCE, "{gap:e}: {said:?}");
        assert!(gap < TOLERANCE || low > 0.0, "{gap:e}: {said:?}");
    }
}

/// One inside the other, all around at about the same distance; and a copy of itself, unmoved and moved by next to nothing.
#[test]
fn concentric_spheres_and_coincident_copies() {
    let tree = ball(1);
    for factor in [0.5, 0.9, 0.999, 1.0 - 1e-7, 1.0 - 1e-12, 1.0, 1.1] {
        let inner = Tree::new(scaled(tree.mesh(), factor, DVec3::ZERO));
        assert_true(&tree, &inner, Pose::IDENTITY);
    }
    for shift in [1e-3, 1e-9, 1e-16, f64::MIN_POSITIVE, 5e-324] {
        assert!(assert_true(&tree, &tree, at(shift, 0.0, 0.0)));
    }
}

/// A million times as long as wide, in all directions and all in one.
#[test]
fn needles() {
    let mut random = Random::new(17);
    for width in [1e-3, 1e-6, 1e-12, 0.0] {
        for spread in [1.0, 1e-4] {
            let mut needle = || {
                let start = random.vector();
                let end = start + spread * random.vector() + DVec3::new(1.0, 0.5, 0.0);
                [start, end, end.lerp(start, 0.4) + width * random.vector()]
            };
            let [a, b] = [(); 2].map(|()| Tree::new(triangles((0..20).map(|_| needle()))));
            for shift in [0.0, 1.0, 10.0] {
                assert_true(&a, &b, at(0.0, 0.3 * shift, shift));
            }
        }
    }
}

/// A mesh of one point, of one segment and of one triangle, against each other and against surfaces, in a vertex too.
#[test]
fn points_segments_and_triangles() {
    let sphere = shapes::icosphere(1);
    let trees = [
        triangles([[DVec3::ZERO; 3]]),
        triangles([[sphere.vertex(5); 3]]),
        triangles([[DVec3::X, -DVec3::X, DVec3::ZERO]]),
        triangles([[DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.1)]]),
        sphere,
        shapes::cuboid([1.0; 3], 1),
    ]
    .map(Tree::new);
    let (mut random, mut touching) = (Random::new(3), 0);
    for (a, b) in trees.iter().flat_map(|a| trees.iter().map(move |b| (a, b))) {
        let turned = pose_about(DVec3::ZERO, 2.0, Drift::None, &mut random);
        // A corner on a corner, exactly.
        let onto = placed(DMat3::IDENTITY, a.mesh().vertex(0) - b.mesh().vertex(0));
        for pose in [Pose::IDENTITY, at(2.0, 0.0, 0.0), onto, turned] {
            touching += usize::from(assert_true(a, b, pose));
        }
    }
    assert!(touching > 30, "{touching}");
}

/// Meshes of every size against meshes of every size, next to each other and far away.
#[test]
fn units_of_every_ratio() {
    let mut random = Random::new(5);
    let sphere = shapes::icosphere(0);
    for a_size in [1e-300, 1e-12, 1.0, 1e9, 1e300] {
        let sizes = [1e-300, 1e-30, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e30, 1e300];
        let sizes = sizes.map(|ratio| a_size * ratio).into_iter();
        for b_size in sizes.filter(|size| (1e-320..1e301).contains(size)) {
            let [a, b] = [a_size, b_size].map(|size| Tree::new(scaled(&sphere, size, DVec3::ZERO)));
            for place in [0.5, 1.0, 2.5] {
                let rotation = random.rotation();
                let way = place * f64::max(a_size, b_size) * random.vector().normalize();
                assert_true(&a, &b, placed(rotation, way));
            }
        }
    }
}

/// At 1e9 times their size from the origin, and from each other; there f32 can tell no distance from another.
#[test]
fn far_from_the_origin_and_from_each_other() {
    let mut random = Random::new(6);
    for far in [1e3, 1e9, 1e13] {
        let away = far * random.vector();
        let tree = Tree::new(scaled(&shapes::icosphere(1), 1.0, away));
        for drift in [Drift::None, Drift::Scale] {
            assert_true(&tree, &tree, pose_about(away, 3.0, drift, &mut random));
        }
    }
    let tree = ball(0);
    for far in [1e3, 1e9, 1e13, 1e18, 1e19, 1e20, 1e38, 1e39, 1e100, 1e300] {
        for turn in [DMat3::IDENTITY, random.rotation()] {
            assert_true(&tree, &tree, placed(turn, far * random.vector()));
        }
    }
}

#[test]
fn empty_meshes_are_infinitely_far() {
    let (nothing, sphere, mut workspace) = (nothing(), ball(1), Workspace::new());
    for (a, b) in [
        (&nothing, &sphere),
        (&sphere, &nothing),
        (&nothing, &nothing),
    ] {
        for margins in [[0.0; 2], [1.0, 2.0], [f64::MAX, 1.0]] {
            for closer_than in [None, Some(3.0)] {
                let asked = Question {
                    margins,
                    closer_than,
                    ..Question::default()
                };
                for budget in [Budget::work(0), ENOUGH] {
                    let said = run(&asked.query(a, b, Pose::IDENTITY), &mut workspace, budget);
                    let Bounds { low, high, .. } = said.value;
                    assert_eq!((low, high), (f64::INFINITY, f64::INFINITY), "{asked:?}");
                    assert_eq!(said.stop, StopReason::Finished);
                    assert_eq!(said.value.nearest, None);
                    assert_eq!(said.value.closer, closer_than.map(|_| false));
                }
            }
        }
    }
}

/// Only who asks for no tolerance is content with a relative one where meshes are far apart.
#[test]
fn a_tolerance_that_is_asked_for_is_kept_however_far() {
    let sphere = ball(1);
    for far in [65.0, 1e3, 1e6] {
        let pose = at(far, 0.3, 0.2);
        let mut truth = Truth::new(&sphere, &sphere, &pose);
        let query = Query::distance(&sphere, &sphere, pose);
        for length in [0.0, 1e-9] {
            let absolute = Some(length);
            let asked = Question {
                absolute,
                ..Question::default()
            };
            truth.assert_complete(&asked, &answer(&query.absolute_tolerance(length)));
        }
        let said = answer(&query);
        truth.assert_sound(&Question::default(), &said);
        let Bounds { low, high, .. } = said.value;
        assert!(high - low <= 1.000_000_1e-5 * low, "{said:?}");
    }
}

/// What the margins round away is not taken for proven.
#[test]
fn a_relative_tolerance_is_kept_within_margins() {
    let sphere = ball(2);
    for margins in [[0.0, 0.0], [0.5, 0.25], [0.9, 1.0], [1.0, 3.0]] {
        let query = Query::distance(&sphere, &sphere, at(4.2, 0.3, 0.2)).margins(margins);
        let query = query.absolute_tolerance(0.0);
        for share in [0.0, 1e-9, 1e-3, 1.0, 1e6, 1e13, 1e15, 1e17, 1e200] {
            let Bounds { low, high, .. } = answer(&query.relative_tolerance(share)).value;
            assert!(
                high <= (1.0 + share) * low + 1e-13,
                "{margins:?}, {share:e}"
            );
        }
    }
}

/// Concentric triangles in one plane, of growing sizes.
fn nested(count: u32) -> Tree {
    let corner = |i: u32, angle: f32| {
        let size = (i + 1) as f32 / count as f32;
        DVec3::new(
            f64::from(size * angle.cos()),
            f64::from(size * angle.sin()),
            0.0,
        )
    };
    let angles = [0.0, 2.094_395_2, 4.188_790_3];
    Tree::new(triangles(
        (0..count).map(|i| angles.map(|angle| corner(i, angle))),
    ))
}

/// All pairs of nested triangles are as good as equally far, for boxes; a plane tells.
#[test]
fn nested_sheets_take_work_that_grows_with_the_triangles_only() {
    for place in [[5.0, 3.0, 2.0], [0.0, 0.0, 30.0]] {
        let pose = placed(DMat3::IDENTITY, place);
        let outer = nested(1);
        let exact = answer(&Query::distance(&outer, &outer, pose)).value.high;
        let truth = exact.min(DVec3::from(place).length());
        let work = |count: u32| {
            let sheet = nested(count);
            let said = answer(&Query::distance(&sheet, &sheet, pose));
            let Bounds { low, high, .. } = said.value;
            assert_eq!(said.stop, StopReason::Finished);
            assert!(high - low <= 1.001e-6 * sheet.unit_length(), "{said:?}");
            assert!(low <= truth && truth <= high + 1e-6, "{said:?} {truth}");
            said.stats.work
        };
        let (few, many) = (work(2_000), work(16_000));
        assert!(many < 300 * 16_000, "{many}");
        assert!(many < 12 * few.max(100 * 2_000), "{few} and {many}");
    }
}
