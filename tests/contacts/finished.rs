//! A query that nothing stopped, against brute force over all pairs: on soups made to be nasty and on surfaces.

use punctual::glam::DVec3;
use punctual::{Pose, Query, StopReason, Tree, Workspace, shapes};

use crate::common::meshes::{at, ball, cube, moved, nothing, one, placed};
use crate::common::random::{Drift, Family, Random, pose_about, poses, soup, soups};
use crate::truth::{ENOUGH, Truth, listed, run};

/// With several margins, each a share of the extent of both; how many contacts there are.
#[track_caller]
fn assert_true<const N: usize>(a: &Tree, b: &Tree, pose: Pose, shares: [f64; N]) -> [usize; N] {
    let mut truth = Truth::new(a, b, &pose);
    let mut workspace = Workspace::new();
    shares.map(|share| {
        let margin = share * truth.size;
        let query = Query::contacts(a, b, pose).margin(margin);
        let said = run(&query, &mut workspace, ENOUGH);
        truth.assert_finished(margin, &said, &workspace);
        workspace.contacts().len()
    })
}

fn assert_soups_true(family: Family) {
    let mut random = Random::new(family as u64 + 300);
    let mut sums = [0; 4];
    for counts in [[1, 1], [3, 9], [15, 15]] {
        let [a, b] = counts.map(|count| Tree::new(soup(family, count, &mut random)));
        let away = family.scale() * 2.5 * DVec3::new(0.4, 0.5, 0.6);
        let near = poses(family, 3, &mut random).into_iter();
        for pose in near.chain([at(away.x, away.y, away.z)]) {
            let found = assert_true(&a, &b, pose, [0.0, 1e-9, 0.03, 0.2]);
            sums.iter_mut()
                .zip(found)
                .for_each(|(sum, count)| *sum += count);
        }
    }
    println!("{sums:?}");
    assert!(sums.is_sorted() && sums[3] > 100, "{sums:?}");
}

soups!(assert_soups_true);

#[test]
fn shapes_against_shapes() {
    let trees = [
        shapes::icosphere(1),
        shapes::cuboid([0.8, 0.5, 0.1], 2),
        shapes::torus(1.0, 0.2, 8),
        shapes::gear(7, 1),
    ]
    .map(Tree::new);
    let (mut random, mut found) = (Random::new(78), 0);
    for (a, b) in trees.iter().flat_map(|a| trees.iter().map(move |b| (a, b))) {
        let pose = pose_about(DVec3::ZERO, 1.0, Drift::Shear, &mut random);
        found += assert_true(a, b, pose, [0.0, 0.02])[1];
    }
    assert!(found > 500, "{found}");
}

/// Corners on corners, edges on edges, faces on faces, exactly; and boxes that all but touch.
#[test]
fn boxes_that_touch() {
    let cube = cube(2);
    for (x, y, z) in [
        (2.0, 0.0, 0.0),
        (2.0, 2.0, 0.0),
        (2.0, 2.0, 2.0),
        (2.0, 0.3, 0.1),
        (0.0, 0.0, 0.0),
    ] {
        for gap in [0.0, 1e-6] {
            let pose = at(x + gap * x, y, z);
            let counts = assert_true(&cube, &cube, pose, [0.0, 1e-12, 1e-5]);
            assert_eq!(counts[0] > 0, gap == 0.0 || x == 0.0, "{counts:?}");
            assert!(counts[2] > 0);
        }
    }
    // Face to face: B is moved along x, so A parts from it along -x. Its upper face looks at A's.
    let mut workspace = Workspace::new();
    let _ = run(
        &Query::contacts(&cube, &cube, at(2.0, 0.0, 0.0)),
        &mut workspace,
        ENOUGH,
    );
    let contacts = listed(&workspace);
    let is_flat = |normal: DVec3| normal == DVec3::NEG_X;
    let flat = contacts.iter().filter(|contact| is_flat(contact.normal));
    assert!(flat.count() >= 8, "{contacts:?}");
}

/// Sizes of any ratio, far from the origin and from each other.
#[test]
fn sizes_and_places_of_all_kinds() {
    let mut random = Random::new(5);
    let sphere = shapes::icosphere(0);
    let scaled = |size: f64, away| Tree::new(moved(&sphere, |vertex| size * vertex + away));
    for (size, other) in [
        (1e-300, 1.0),
        (1e-12, 1e-3),
        (1.0, 1e-30),
        (1.0, 1e12),
        (1e300, 1e288),
        (1e300, 1e300),
    ] {
        let (a, b) = (scaled(size, DVec3::ZERO), scaled(other, DVec3::ZERO));
        let way = size.max(other) * DVec3::new(0.9, 0.3, 0.2);
        assert_true(&a, &b, placed(random.rotation(), way), [0.0, 0.01, 1.0]);
    }
    for far in [1e3, 1e9, 1e13] {
        let away = far * random.vector();
        let (tree, near) = (scaled(1.0, away), scaled(1.0, DVec3::ZERO));
        let pose = pose_about(away, 1.0, Drift::Scale, &mut random);
        assert_true(&tree, &tree, pose, [0.0, 0.02]);
        assert_true(&near, &near, placed(random.rotation(), away), [0.0, 0.5]);
    }
}

/// Points, segments and triangles of no area have no normals; all contacts have one.
#[test]
fn points_and_segments() {
    let trees = [
        one([DVec3::ZERO; 3]),
        one([DVec3::X, DVec3::NEG_X, DVec3::ZERO]),
        one([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.1)]),
    ];
    let mut met = 0;
    for (a, b) in trees.iter().flat_map(|a| trees.iter().map(move |b| (a, b))) {
        for pose in [Pose::IDENTITY, at(0.0, 0.0, 0.01), at(0.0, 5e-324, 0.0)] {
            met += assert_true(a, b, pose, [0.0, 0.1, 1.0])[0];
        }
    }
    assert!(met >= 9, "{met}");
}

#[test]
fn margins_of_all_kinds() {
    let (a, b) = (ball(1), Tree::new(shapes::torus(1.0, 0.2, 6)));
    let pairs = a.mesh().len() * b.mesh().len();
    let mut workspace = Workspace::new();
    workspace.reserve_contacts(pairs);
    let query = Query::contacts(&a, &b, at(0.4, 0.1, 0.7));
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
        assert_eq!(whole.len(), pairs);
        assert_eq!(whole[..touching.len()], touching);
    }
    Truth::new(&a, &b, &at(0.4, 0.1, 0.7)).assert_complete(1e300, &set(1e300));
}

#[test]
fn empty_meshes_have_no_contacts() {
    let (nothing, sphere, mut workspace) = (nothing(), ball(1), Workspace::new());
    for (a, b) in [
        (&nothing, &sphere),
        (&sphere, &nothing),
        (&nothing, &nothing),
    ] {
        for margin in [0.0, 1.0, f64::INFINITY] {
            let query = Query::contacts(a, b, Pose::IDENTITY).margin(margin);
            let said = run(&query, &mut workspace, ENOUGH);
            let told = (said.stop, said.value.low, said.stats.found);
            assert_eq!(told, (StopReason::Finished, f64::INFINITY, 0));
            assert_eq!(query.certificate(&workspace).unwrap().open_pairs(), 0);
        }
    }
}
