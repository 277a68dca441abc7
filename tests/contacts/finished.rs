//! A query that nothing stopped, against brute force over all pairs: on soups made to be nasty and on surfaces.

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Mesh, Pose, Query, StopReason, Tree, Workspace, shapes};

use crate::common::random::{Drift, Family, Random, pose_about, poses, soup, soups};
use crate::truth::{ENOUGH, Truth, listed, run};

pub fn moved(x: f64, y: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, y, z)).unwrap()
}

/// With several margins, each a share of the extent of both; how many contacts there are.
#[track_caller]
fn assert_true(
    a: &Tree,
    b: &Tree,
    pose: Pose,
    shares: &[f64],
    workspace: &mut Workspace,
) -> Vec<usize> {
    let mut truth = Truth::new(a, b, &pose);
    let counts = shares.iter().map(|share| {
        let margin = share * truth.size;
        let said = run(
            &Query::contacts(a, b, pose).margin(margin),
            workspace,
            ENOUGH,
        );
        truth.assert_finished(margin, &said, workspace);
        workspace.contacts().len()
    });
    counts.collect()
}

fn assert_soups_true(family: Family) {
    let mut random = Random::new(family as u64 + 300);
    let mut workspace = Workspace::new();
    let mut counts = [0; 4];
    for (a_triangles, b_triangles) in [(1, 1), (3, 9), (15, 15)] {
        let a = Tree::new(soup(family, a_triangles, &mut random));
        let b = Tree::new(soup(family, b_triangles, &mut random));
        let away = family.scale() * 2.5 * DVec3::new(0.4, 0.5, 0.6);
        let near = poses(family, 3, &mut random).into_iter();
        for pose in near.chain([Pose::new(DMat3::IDENTITY, away).unwrap()]) {
            let found = assert_true(&a, &b, pose, &[0.0, 1e-9, 0.03, 0.2], &mut workspace);
            counts
                .iter_mut()
                .zip(found)
                .for_each(|(sum, count)| *sum += count);
        }
    }
    println!("{counts:?}");
    assert!(counts.is_sorted() && counts[3] > 100, "{counts:?}");
}

soups!(assert_soups_true);

#[test]
fn shapes_against_shapes() {
    let trees = [
        shapes::icosphere(1),
        shapes::cuboid(Vec3::new(0.8, 0.5, 0.1), 2),
        shapes::torus(1.0, 0.2, 8),
        shapes::gear(7, 1),
    ]
    .map(Tree::new);
    let mut random = Random::new(78);
    let mut workspace = Workspace::new();
    let mut found = 0;
    for a in &trees {
        for b in &trees {
            let pose = pose_about(DVec3::ZERO, 1.0, Drift::Shear, &mut random);
            found += assert_true(a, b, pose, &[0.0, 0.02], &mut workspace)[1];
        }
    }
    assert!(found > 500, "{found}");
}

/// Corners on corners, edges on edges, faces on faces, exactly; and boxes that all but touch.
#[test]
fn boxes_that_touch() {
    let cube = Tree::new(shapes::cuboid(Vec3::ONE, 2));
    let mut workspace = Workspace::new();
    for (x, y, z) in [
        (2.0, 0.0, 0.0),
        (2.0, 2.0, 0.0),
        (2.0, 2.0, 2.0),
        (2.0, 0.3, 0.1),
        (0.0, 0.0, 0.0),
    ] {
        for gap in [0.0, 1e-6] {
            let pose = moved(x + gap * x, y, z);
            let counts = assert_true(&cube, &cube, pose, &[0.0, 1e-12, 1e-5], &mut workspace);
            assert_eq!(counts[0] > 0, gap == 0.0 || x == 0.0, "{counts:?}");
            assert!(counts[2] > 0);
        }
    }
    // Face to face: B is moved along x, so A parts from it along -x. Its upper face looks at A's.
    let _ = run(
        &Query::contacts(&cube, &cube, moved(2.0, 0.0, 0.0)),
        &mut workspace,
        ENOUGH,
    );
    let normals = workspace
        .contacts()
        .filter(|contact| contact.normal == DVec3::NEG_X)
        .count();
    assert!(normals >= 8, "{normals}");
}

/// Sizes of any ratio, far from the origin and from each other.
#[test]
fn sizes_and_places_of_all_kinds() {
    let mut random = Random::new(5);
    let mut workspace = Workspace::new();
    let sphere = shapes::icosphere(0);
    let scaled = |factor: f64, offset: DVec3| {
        let vertices =
            (0..sphere.vertex_count()).map(|index| factor * sphere.vertex(index) + offset);
        Tree::new(Mesh::from_f64(vertices, sphere.triangles().iter().copied()).unwrap())
    };
    for (size, ratio) in [
        (1e-300, 1e300),
        (1e-12, 1e9),
        (1.0, 1e-30),
        (1.0, 1e12),
        (1e300, 1e-12),
        (1e300, 1.0),
    ] {
        let (a, b) = (scaled(size, DVec3::ZERO), scaled(size * ratio, DVec3::ZERO));
        let way = size.max(size * ratio) * DVec3::new(0.9, 0.3, 0.2);
        assert_true(
            &a,
            &b,
            Pose::new(random.rotation(), way).unwrap(),
            &[0.0, 0.01, 1.0],
            &mut workspace,
        );
    }
    for far in [1e3, 1e9, 1e13] {
        let away = far * random.vector();
        let tree = scaled(1.0, away);
        assert_true(
            &tree,
            &tree,
            pose_about(away, 1.0, Drift::Scale, &mut random),
            &[0.0, 0.02],
            &mut workspace,
        );
        let near = scaled(1.0, DVec3::ZERO);
        let pose = Pose::new(random.rotation(), away).unwrap();
        assert_true(&near, &near, pose, &[0.0, 0.5], &mut workspace);
    }
}

/// Points, segments and triangles of no area have no normals; all contacts have one.
#[test]
fn points_and_segments() {
    let mesh = |corners: [DVec3; 3]| Tree::new(Mesh::from_f64(corners, [[0, 1, 2]]).unwrap());
    let trees = [
        mesh([DVec3::ZERO; 3]),
        mesh([DVec3::X, DVec3::NEG_X, DVec3::ZERO]),
        mesh([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.1)]),
    ];
    let (mut workspace, mut met) = (Workspace::new(), 0);
    for a in &trees {
        for b in &trees {
            for pose in [
                Pose::IDENTITY,
                moved(0.0, 0.0, 0.01),
                moved(0.0, 5e-324, 0.0),
            ] {
                met += assert_true(a, b, pose, &[0.0, 0.1, 1.0], &mut workspace)[0];
            }
        }
    }
    assert!(met >= 9, "{met}");
}

#[test]
fn margins_of_all_kinds() {
    let (a, b) = (
        Tree::new(shapes::icosphere(1)),
        Tree::new(shapes::torus(1.0, 0.2, 6)),
    );
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(a.mesh().len() * b.mesh().len());
    let query = Query::contacts(&a, &b, moved(0.4, 0.1, 0.7));
    let mut set = |margin: f64| {
        let said = run(&query.margin(margin), &mut workspace, ENOUGH);
        assert_eq!(said.stop, StopReason::Finished);
        listed(&workspace)
    };
    let touching = set(0.0);
    assert!(!touching.is_empty() && touching.iter().all(|contact| contact.distance == 0.0));
    for none in [-1.0, -0.0, f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(set(none), touching);
    }
    for all in [f64::INFINITY, f64::MAX, 1e300, 100.0] {
        let whole = set(all);
        assert_eq!(whole.len(), a.mesh().len() * b.mesh().len());
        assert_eq!(whole[..touching.len()], touching);
    }
    Truth::new(&a, &b, &moved(0.4, 0.1, 0.7)).assert_complete(1e300, &set(1e300));
}

#[test]
fn nothing_has_no_contacts() {
    let nothing = Tree::new(Mesh::new([[0.0f32; 3]], []).unwrap());
    let sphere = Tree::new(shapes::icosphere(1));
    let mut workspace = Workspace::new();
    for (a, b) in [
        (&nothing, &sphere),
        (&sphere, &nothing),
        (&nothing, &nothing),
    ] {
        for margin in [0.0, 1.0, f64::INFINITY] {
            let query = Query::contacts(a, b, Pose::IDENTITY).margin(margin);
            let said = run(&query, &mut workspace, ENOUGH);
            assert_eq!(
                (said.stop, said.value.low, said.stats.found),
                (StopReason::Finished, f64::INFINITY, 0)
            );
            assert_eq!(query.certificate(&workspace).unwrap().open_pairs(), 0);
        }
    }
}
