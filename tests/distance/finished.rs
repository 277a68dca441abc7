//! A query that nothing stopped, against brute force over all pairs: on soups made to be nasty and on surfaces.

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Budget, Mesh, Mode, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes};

use crate::common::random::{Drift, Family, Random, pose_about, poses, soup, soups};
use crate::distance::{ENOUGH, Question, Truth, run};

pub fn moved(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

/// Triangles from three corners each.
pub fn triangles(corners: impl IntoIterator<Item = [DVec3; 3]>) -> Mesh {
    let corners: Vec<DVec3> = corners.into_iter().flatten().collect();
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Mesh::from_f64(corners, triangles).unwrap()
}

pub fn scaled(mesh: &Mesh, factor: f64, offset: DVec3) -> Mesh {
    let vertices = (0..mesh.vertex_count()).map(|index| factor * mesh.vertex(index) + offset);
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

/// Every kind of question, both ways round; whether they meet.
#[track_caller]
fn assert_true(a: &Tree, b: &Tree, pose: Pose, workspace: &mut Workspace) -> bool {
    let mut truth = Truth::new(a, b, &pose);
    for asked in truth.questions() {
        let said = run(&asked.query(a, b, pose), workspace, ENOUGH);
        truth.assert_complete(&asked, &said);
    }
    // The pose back is rounded, so this is another question.
    let inverse = pose.inverse().unwrap();
    let mut other = Truth::new(b, a, &inverse);
    let said = run(&Question::EXACT.query(b, a, inverse), workspace, ENOUGH);
    other.assert_complete(&Question::EXACT, &said);
    truth.meet()
}

/// Near each other, and as far apart as their size and more.
fn assert_soups_true(family: Family) {
    let mut random = Random::new(family as u64 + 100);
    let mut workspace = Workspace::new();
    let (mut touching, mut apart) = (0, 0);
    for (a_triangles, b_triangles) in [(1, 1), (3, 9), (30, 30)] {
        let a = Tree::new(soup(family, a_triangles, &mut random));
        let b = Tree::new(soup(family, b_triangles, &mut random));
        let near = poses(family, 6, &mut random);
        // No farther than poses go.
        let far = [
            1.5,
            4.0,
            if family == Family::Enormous {
                8.0
            } else {
                30.0
            },
        ]
        .map(|reach| {
            let turned = pose_about(family.center(), 0.0, Drift::Shear, &mut random);
            let way = random.vector().normalize() * reach * family.scale();
            Pose::new(*turned.rotation(), turned.translation() + way).unwrap()
        });
        let poses = near.into_iter().chain(far).map(|pose| (&b, pose));
        for (b, pose) in poses.chain([(&a, Pose::IDENTITY)]) {
            match assert_true(&a, b, pose, &mut workspace) {
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
    let trees = [
        shapes::icosphere(1),
        shapes::cuboid(Vec3::new(0.8, 0.5, 0.1), 2),
        shapes::torus(1.0, 0.2, 8),
        shapes::torus_knot(2, 3, 0.15, 8),
        shapes::gear(7, 1),
    ]
    .map(Tree::new);
    let mut random = Random::new(77);
    let mut workspace = Workspace::new();
    for a in &trees {
        for b in &trees {
            for (drift, reach) in [(Drift::None, 0.5), (Drift::Scale, 2.0), (Drift::Shear, 6.0)] {
                assert_true(
                    a,
                    b,
                    pose_about(DVec3::ZERO, reach, drift, &mut random),
                    &mut workspace,
                );
            }
        }
    }
}

/// A plate of squares in the plane z = 0, turned by 1 about an axis of its own.
fn plate(squares: u32, turn: DMat3) -> Mesh {
    let corner =
        |x: u32, y: u32| turn * DVec3::new(f64::from(x), f64::from(y), 0.0) / f64::from(squares);
    triangles((0..squares * squares).flat_map(|i| {
        let (x, y) = (i / squares, i % squares);
        let [p, q, r, s] = [
            corner(x, y),
            corner(x + 1, y),
            corner(x + 1, y + 1),
            corner(x, y + 1),
        ];
        [[p, q, r], [p, r, s]]
    }))
}

/// All pairs of triangles above one another are equally far apart.
#[test]
fn parallel_plates() {
    let mut workspace = Workspace::new();
    for turn in [
        DMat3::IDENTITY,
        DMat3::from_rotation_x(1.0) * DMat3::from_rotation_z(0.7),
    ] {
        let tree = Tree::new(plate(5, turn));
        for gap in [1.0, 1e-2, 1e-5, 1e-8, 1e-13, 1e-16, 0.0] {
            let along = turn * DVec3::new(0.013, 0.021, gap);
            assert_true(
                &tree,
                &tree,
                moved(along.x, along.y, along.z),
                &mut workspace,
            );
            // Not quite parallel.
            let tilted = turn * DMat3::from_rotation_x(1e-3 * gap) * turn.transpose();
            assert_true(
                &tree,
                &tree,
                Pose::new(tilted, along).unwrap(),
                &mut workspace,
            );
        }
    }
}

/// Plates that are closer than the margins of `f32` allow to tell are parted high up in the trees. Before, every triangle was
/// compared with those above it: 9 to 27 million units of work.
#[test]
fn plates_that_nearly_touch_take_little_work() {
    const LITTLE: u64 = 200_000;
    let mut workspace = Workspace::new();
    let tilted = DMat3::from_rotation_x(1.0) * DMat3::from_rotation_z(0.7);
    let other = DMat3::from_rotation_y(2.0) * DMat3::from_rotation_x(0.4);
    for [of_a, of_b] in [[DMat3::IDENTITY; 2], [tilted; 2], [tilted, other]] {
        let (a, b) = (Tree::new(plate(100, of_a)), Tree::new(plate(91, of_b)));
        for (angle, gap) in [(0.0, 1e-5), (0.3, 1e-5), (0.0, 1e-6), (0.3, 1e-6)] {
            let gap = 0.5 * gap;
            let turn = of_a * DMat3::from_rotation_z(angle) * of_b.transpose();
            let pose = Pose::new(turn, of_a * DVec3::new(0.013, 0.021, gap)).unwrap();
            let query = Query::distance(&a, &b, pose);
            for query in [query, query.absolute_tolerance(1e-4)] {
                let said = query.run(&mut workspace, ENOUGH);
                // Below the tolerance all that is asked is whether they meet.
                assert!(
                    said.value.low <= gap * (1.0 + 1e-9) && gap * (1.0 - 1e-9) <= said.value.high,
                    "{said:?}"
                );
                assert!(
                    said.stop == StopReason::Finished && said.stats.work < LITTLE,
                    "{}",
                    said.stats.work
                );
            }
            for mode in [Mode::Any, Mode::All] {
                let said = Query::intersection(&a, &b, pose)
                    .mode(mode)
                    .run(&mut workspace, ENOUGH);
                assert!(
                    said.value == Verdict::Separated && said.stats.work < LITTLE,
                    "{}",
                    said.stats.work
                );
            }
        }
    }
}

/// Who leaves contact open has an answer as soon as `high` is within the tolerance, whether the plates meet or not; what is
/// farther apart is told as ever.
#[test]
fn plates_within_the_tolerance_take_little_work_if_contact_is_left_open() {
    const TOLERANCE: f64 = 1e-4;
    let mut workspace = Workspace::new();
    let tilted = DMat3::from_rotation_x(1.0) * DMat3::from_rotation_z(0.7);
    let (a, b) = (Tree::new(plate(100, tilted)), Tree::new(plate(91, tilted)));
    for gap in [0.0, 1e-16, 1e-12, 1e-8, 1e-7, 1e-6, 9e-5, 2e-4] {
        let along = tilted * DVec3::new(0.013, 0.021, gap);
        let query =
            Query::distance(&a, &b, moved(along.x, along.y, along.z)).absolute_tolerance(TOLERANCE);
        let said = query.leave_contact_open(true).run(&mut workspace, ENOUGH);
        assert!(
            said.stop == StopReason::Finished && said.stats.work < 50_000,
            "{gap:e}: {said:?}"
        );
        let rounding = 1e-15;
        assert!(
            said.value.low <= gap + rounding && gap <= said.value.high + rounding,
            "{gap:e}: {said:?}"
        );
        assert!(
            said.value.high - said.value.low <= TOLERANCE
                && (gap < TOLERANCE || said.value.low > 0.0),
            "{gap:e}: {said:?}"
        );
    }
}

/// One inside the other, all around at about the same distance; and a copy of itself, unmoved and moved by next to nothing.
#[test]
fn concentric_spheres_and_coincident_copies() {
    let mut workspace = Workspace::new();
    let sphere = shapes::icosphere(1);
    let tree = Tree::new(sphere.clone());
    for factor in [0.5, 0.9, 0.999, 1.0 - 1e-7, 1.0 - 1e-12, 1.0, 1.1] {
        let inner = Tree::new(scaled(&sphere, factor, DVec3::ZERO));
        assert_true(&tree, &inner, Pose::IDENTITY, &mut workspace);
    }
    for shift in [1e-3, 1e-9, 1e-16, f64::MIN_POSITIVE, 5e-324] {
        assert!(assert_true(
            &tree,
            &tree,
            moved(shift, 0.0, 0.0),
            &mut workspace
        ));
    }
}

/// A million times as long as wide, in all directions and all in one.
#[test]
fn needles() {
    let mut random = Random::new(17);
    let mut workspace = Workspace::new();
    for width in [1e-3, 1e-6, 1e-12, 0.0] {
        for spread in [1.0, 1e-4] {
            let mut needles = |count: usize| {
                Tree::new(triangles((0..count).map(|_| {
                    let start = random.vector();
                    let end = start + spread * random.vector() + DVec3::new(1.0, 0.5, 0.0);
                    [start, end, end.lerp(start, 0.4) + width * random.vector()]
                })))
            };
            let (a, b) = (needles(20), needles(20));
            for shift in [0.0, 1.0, 10.0] {
                assert_true(&a, &b, moved(0.0, 0.3 * shift, shift), &mut workspace);
            }
        }
    }
}

/// A mesh of one point, of one segment and of one triangle, against each other and against surfaces, in a vertex too.
#[test]
fn points_segments_and_triangles() {
    let point = |p: DVec3| triangles([[p; 3]]);
    let segment = triangles([[DVec3::X, -DVec3::X, DVec3::ZERO]]);
    let triangle = triangles([[DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.1)]]);
    let sphere = shapes::icosphere(1);
    let vertex = sphere.vertex(5);
    let meshes = [
        point(DVec3::ZERO),
        point(vertex),
        segment,
        triangle,
        sphere,
        shapes::cuboid(Vec3::ONE, 1),
    ];
    let trees = meshes.map(Tree::new);
    let mut random = Random::new(3);
    let mut workspace = Workspace::new();
    let mut touching = 0;
    for a in &trees {
        for b in &trees {
            let turned = pose_about(DVec3::ZERO, 2.0, Drift::None, &mut random);
            // A corner on a corner, exactly.
            let onto = a.mesh().vertex(0) - b.mesh().vertex(0);
            for pose in [
                Pose::IDENTITY,
                moved(2.0, 0.0, 0.0),
                moved(onto.x, onto.y, onto.z),
                turned,
            ] {
                touching += usize::from(assert_true(a, b, pose, &mut workspace));
            }
        }
    }
    assert!(touching > 30, "{touching}");
}

/// Meshes of every size against meshes of every size, next to each other and far away.
#[test]
fn units_of_every_ratio() {
    let mut random = Random::new(5);
    let mut workspace = Workspace::new();
    let sphere = shapes::icosphere(0);
    for a_size in [1e-300, 1e-12, 1.0, 1e9, 1e300] {
        for ratio in [1e-300, 1e-30, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e30, 1e300] {
            let b_size = a_size * ratio;
            if !(1e-320..1e301).contains(&b_size) {
                continue;
            }
            let [a, b] = [a_size, b_size].map(|size| Tree::new(scaled(&sphere, size, DVec3::ZERO)));
            let larger = f64::max(a_size, b_size);
            for place in [0.5, 1.0, 2.5] {
                let rotation = random.rotation();
                let way = place * larger * random.vector().normalize();
                assert_true(&a, &b, Pose::new(rotation, way).unwrap(), &mut workspace);
            }
        }
    }
}

/// At 1e9 times their size from the origin, and from each other; there f32 can tell no distance from another.
#[test]
fn far_from_the_origin_and_from_each_other() {
    let mut random = Random::new(6);
    let mut workspace = Workspace::new();
    let sphere = shapes::icosphere(1);
    for far in [1e3, 1e9, 1e13] {
        let away = far * random.vector();
        let tree = Tree::new(scaled(&sphere, 1.0, away));
        for drift in [Drift::None, Drift::Scale] {
            assert_true(
                &tree,
                &tree,
                pose_about(away, 3.0, drift, &mut random),
                &mut workspace,
            );
        }
    }
    let tree = Tree::new(shapes::icosphere(0));
    for far in [1e3, 1e9, 1e13, 1e18, 1e19, 1e20, 1e38, 1e39, 1e100, 1e300] {
        for turn in [DMat3::IDENTITY, random.rotation()] {
            let pose = Pose::new(turn, far * random.vector()).unwrap();
            assert_true(&tree, &tree, pose, &mut workspace);
        }
    }
}

#[test]
fn nothing_is_infinitely_far() {
    let nothing = Tree::new(Mesh::new([[0.0f32; 3]], []).unwrap());
    let sphere = Tree::new(shapes::icosphere(1));
    let mut workspace = Workspace::new();
    for (a, b) in [
        (&nothing, &sphere),
        (&sphere, &nothing),
        (&nothing, &nothing),
    ] {
        for margins in [[0.0; 2], [1.0, 2.0], [f64::MAX, 1.0]] {
            let thick = Question {
                margins,
                ..Question::default()
            };
            for asked in [
                thick,
                Question {
                    closer_than: Some(3.0),
                    ..thick
                },
            ] {
                for budget in [Budget::work(0), ENOUGH] {
                    let said = run(&asked.query(a, b, Pose::IDENTITY), &mut workspace, budget);
                    assert_eq!(
                        (said.value.low, said.value.high),
                        (f64::INFINITY, f64::INFINITY),
                        "{asked:?}"
                    );
                    assert_eq!(
                        (said.stop, said.value.nearest),
                        (StopReason::Finished, None)
                    );
                    assert_eq!(said.value.closer, asked.closer_than.map(|_| false));
                }
            }
        }
    }
}

/// Only who asks for no tolerance is content with a relative one where meshes are far apart.
#[test]
fn a_tolerance_that_is_asked_for_is_kept_however_far() {
    let sphere = Tree::new(shapes::icosphere(1));
    let mut workspace = Workspace::new();
    for far in [65.0, 1e3, 1e6] {
        let pose = moved(far, 0.3, 0.2);
        let mut truth = Truth::new(&sphere, &sphere, &pose);
        let query = Query::distance(&sphere, &sphere, pose);
        for absolute in [0.0, 1e-9] {
            let asked = Question {
                absolute: Some(absolute),
                ..Question::default()
            };
            truth.assert_complete(
                &asked,
                &run(&query.absolute_tolerance(absolute), &mut workspace, ENOUGH),
            );
        }
        let said = run(&query, &mut workspace, ENOUGH);
        truth.assert_sound(&Question::default(), &said);
        assert!(
            said.value.high - said.value.low <= 1.000_000_1e-5 * said.value.low,
            "{said:?}"
        );
    }
}

/// What the margins round away is not taken for proven.
#[test]
fn a_relative_tolerance_is_kept_within_margins() {
    let sphere = Tree::new(shapes::icosphere(2));
    let mut workspace = Workspace::new();
    for margins in [[0.0, 0.0], [0.5, 0.25], [0.9, 1.0], [1.0, 3.0]] {
        for share in [0.0, 1e-9, 1e-3, 1.0, 1e6, 1e13, 1e15, 1e17, 1e200] {
            let asked = Query::distance(&sphere, &sphere, moved(4.2, 0.3, 0.2)).margins(margins);
            let said = run(
                &asked.absolute_tolerance(0.0).relative_tolerance(share),
                &mut workspace,
                ENOUGH,
            );
            assert!(
                said.value.high <= (1.0 + share) * said.value.low + 1e-13,
                "{margins:?}, {share:e}: {said:?}"
            );
        }
    }
}

/// Concentric triangles in one plane, of growing sizes.
fn nested(count: u32) -> Tree {
    let corner = |i: u32, angle: f32| {
        let size = (i + 1) as f32 / count as f32;
        [size * angle.cos(), size * angle.sin(), 0.0]
    };
    let corners =
        (0..count).flat_map(|i| [0.0, 2.094_395_2, 4.188_790_3].map(|angle| corner(i, angle)));
    let corners: Vec<[f32; 3]> = corners.collect();
    Tree::new(
        Mesh::new(
            corners,
            (0..count)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect::<Vec<_>>(),
        )
        .unwrap(),
    )
}

/// All pairs of nested triangles are as good as equally far, for boxes; a plane tells.
#[test]
fn nested_sheets_take_work_that_grows_with_the_triangles_only() {
    let mut workspace = Workspace::new();
    for place in [[5.0, 3.0, 2.0], [0.0, 0.0, 30.0]] {
        let mut work = |count: u32| {
            let sheet = nested(count);
            let pose = Pose::new(DMat3::IDENTITY, place).unwrap();
            let said = run(
                &Query::distance(&sheet, &sheet, pose),
                &mut workspace,
                ENOUGH,
            );
            assert_eq!(said.stop, StopReason::Finished);
            assert!(
                said.value.high - said.value.low <= 1.001e-6 * sheet.unit_length(),
                "{said:?}"
            );
            let outer = nested(1);
            let exact = run(
                &Query::distance(&outer, &outer, pose),
                &mut workspace,
                ENOUGH,
            );
            let truth = exact.value.high.min(DVec3::from(place).length());
            assert!(
                said.value.low <= truth && truth <= said.value.high + 1e-6,
                "{said:?} {exact:?}"
            );
            said.stats.work
        };
        let (few, many) = (work(2_000), work(16_000));
        assert!(
            many < 300 * 16_000 && many < 12 * few.max(100 * 2_000),
            "{few} and {many}"
        );
    }
}
