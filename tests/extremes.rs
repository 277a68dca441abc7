//! Meshes of very unequal size, long slivers, nothing but degenerate triangles: exact, and without visiting everything.

mod common;

use common::check::{ENOUGH, assert_complete, run_to_end};
use common::random::{Drift, Random, pose_about};
use common::reference::all_pairs;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{BuildOptions, Mesh, Mode, Pose, Query, Stats, Tree, Workspace, shapes};

/// Both modes against all pairs, both ways round; the number of pairs and the counters of `All`.
#[track_caller]
fn assert_exact(a: &Tree, b: &Tree, b_in_a: Pose) -> (usize, Stats) {
    let truth = all_pairs(a.mesh(), b.mesh(), &b_in_a);
    let mut workspace = Workspace::new();
    let mut stats = None;
    for mode in [Mode::Any, Mode::All] {
        let (outcome, pairs) = run_to_end(
            &Query::intersection(a, b, b_in_a).mode(mode),
            &mut workspace,
            ENOUGH,
        );
        assert_complete(mode, &outcome, &pairs, &truth);
        stats = Some(outcome.stats);
    }
    (truth.len(), stats.unwrap())
}

/// The tree of each preset: none may lose a pair.
fn trees(mesh: &Mesh) -> [Tree; 2] {
    [BuildOptions::fast_build(), BuildOptions::default()].map(|options| {
        let tree = Tree::with_options(mesh.clone(), &options);
        tree.validate().unwrap();
        tree
    })
}

fn moved(translation: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, translation).unwrap()
}

/// Triangles from three corners each.
fn soup(corners: impl IntoIterator<Item = [DVec3; 3]>) -> Mesh {
    let corners: Vec<DVec3> = corners.into_iter().flatten().collect();
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Mesh::from_f64(corners, triangles).unwrap()
}

#[test]
fn a_quarter_of_a_million_triangles_against_a_thousand() {
    let field = Tree::new(shapes::height_field(358, 7));
    let part = Tree::new(shapes::torus_knot(2, 3, 0.2, 64));
    assert!(field.mesh().len() > 256_000 && part.mesh().len() == 1024);
    field.validate().unwrap();
    let bounds = field.mesh().aabb();
    let size = 0.05 * bounds.extents().x;
    let small = (0..part.mesh().vertex_count()).map(|i| (size * part.mesh().vertex(i)).to_array());
    let part = Tree::new(Mesh::from_f64(small, part.mesh().triangles().iter().copied()).unwrap());
    let middle = field.mesh().vertex(field.mesh().vertex_count() / 2);
    let (touching, stats) = assert_exact(&field, &part, moved(middle));
    assert!(touching > 100, "{touching}");
    assert!(stats.primitive_tests < 100 * touching as u64, "{stats:?}");
    let (none, stats) = assert_exact(
        &field,
        &part,
        moved(middle + (size + bounds.extents().z) * DVec3::Z),
    );
    assert_eq!((none, stats.primitive_tests), (0, 0));
}

#[test]
fn a_part_in_a_room() {
    let mut random = Random::new(9);
    let rooms = trees(&shapes::cuboid(Vec3::new(10.0, 8.0, 3.0), 41));
    let part = Tree::new(shapes::gear(13, 3));
    assert_eq!(rooms[0].mesh().len(), 12 * 41 * 41);
    for room in &rooms {
        // In the air: the boxes of the walls part it at once.
        let turned = pose_about(DVec3::ZERO, 1.0, Drift::None, &mut random);
        let (none, stats) = assert_exact(room, &part, turned);
        assert_eq!(none, 0);
        assert!(stats.bv_tests < 1000, "{stats:?}");
        // In a corner, through three walls.
        let corner = Pose::new(*turned.rotation(), DVec3::new(9.9, 7.9, -2.9)).unwrap();
        let (touching, stats) = assert_exact(room, &part, corner);
        assert!(
            touching > 100 && stats.primitive_tests < 20 * touching as u64,
            "{touching} {stats:?}"
        );
        // Flat on the floor, where it touches exactly.
        let half = part.mesh().aabb().extents().z / 2.0;
        let (touching, _) = assert_exact(room, &part, moved(DVec3::new(0.0, 0.0, half - 3.0)));
        assert!(touching > 100, "{touching}");
    }
}

#[test]
fn one_huge_triangle_against_thousands_of_small_ones() {
    let corners = [
        DVec3::new(-3e3, -1e3, 0.25),
        DVec3::new(2e3, -2e3, 0.25),
        DVec3::new(0.0, 4e3, 0.25),
    ];
    let huge = Tree::new(soup([corners]));
    for sphere in &trees(&shapes::icosphere(4)) {
        let (touching, stats) = assert_exact(&huge, sphere, Pose::IDENTITY);
        assert!(
            touching > 100 && stats.primitive_tests < 8 * touching as u64,
            "{touching} {stats:?}"
        );
        let (other_way, _) = assert_exact(sphere, &huge, Pose::IDENTITY);
        assert_eq!(other_way, touching);
        assert_eq!(assert_exact(&huge, sphere, moved(DVec3::Z * 1.5)).0, 0);
    }
    // The same in one mesh with small ones: it may not spoil their boxes.
    let sphere = shapes::icosphere(4);
    let mixed = soup(
        (0..sphere.len())
            .map(|i| sphere.triangle(i))
            .chain([corners]),
    );
    let other = Tree::new(shapes::torus(0.9, 0.2, 24));
    for mixed in &trees(&mixed) {
        let (touching, stats) = assert_exact(mixed, &other, moved(DVec3::new(0.4, 0.1, 0.3)));
        assert!(
            touching > 100 && stats.primitive_tests < 20 * touching as u64,
            "{touching} {stats:?}"
        );
    }
}

/// Needles in all directions, a million times as long as wide; half of the meetings are by their length.
#[test]
fn long_slivers() {
    let mut random = Random::new(17);
    let mut needles = |count: usize| {
        soup((0..count).map(|_| {
            let (start, way) = (random.vector(), 0.7 * random.vector());
            [start, start + way, start + way + 1e-6 * random.vector()]
        }))
    };
    let (a, b) = (needles(2500), needles(2500));
    let plate = Tree::new(shapes::cuboid(Vec3::new(1.0, 1.0, 0.01), 16));
    let b = Tree::new(b);
    for a in &trees(&a) {
        let (touching, stats) = assert_exact(a, &plate, Pose::IDENTITY);
        assert!(
            touching > 600 && stats.primitive_tests < 80 * touching as u64,
            "{touching} {stats:?}"
        );
        let (_, stats) = assert_exact(a, &b, Pose::IDENTITY);
        assert!(stats.primitive_tests < 2500 * 2500 / 20, "{stats:?}");
    }
}

/// Points, segments and repeated corners only, some of them on the other surface.
#[test]
fn meshes_of_degenerate_triangles_only() {
    let mut random = Random::new(23);
    let sphere = shapes::icosphere(3);
    let degenerate = soup((0..3000).map(|i| {
        let (p, q) = (random.vector(), random.vector());
        let on = sphere.triangle(random.below(sphere.len()));
        match i % 4 {
            0 => [p; 3],
            1 => [p, q, p],
            2 => [p, 0.5 * p + 0.5 * q, q],
            _ => [on[0]; 3],
        }
    }));
    let sphere = Tree::new(sphere);
    for degenerate in &trees(&degenerate) {
        let (touching, _) = assert_exact(degenerate, &sphere, Pose::IDENTITY);
        assert!(touching > 750, "{touching}");
    }
    let itself = Tree::new(degenerate);
    assert!(assert_exact(&itself, &itself, Pose::IDENTITY).0 >= 3000);
    // All in one point, and on it.
    let point = Tree::new(soup((0..400).map(|_| [DVec3::X; 3])));
    point.validate().unwrap();
    assert_eq!(assert_exact(&point, &sphere, Pose::IDENTITY).0 % 400, 0);
    let (all, _) = assert_exact(&point, &point, Pose::IDENTITY);
    assert_eq!(all, 160_000);
}
