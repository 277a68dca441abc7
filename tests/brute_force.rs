//! The budgeted engine without a budget says exactly what brute force says: on soups made to be nasty,
//! on the built-in shapes, in every order and mode, with the queue in use and without it.

mod common;

use common::check::{ENOUGH, assert_complete, run, run_to_end};
use common::random::{Drift, Family, Random, pose_about, poses, soup, soups};
use common::reference::all_pairs;
use common::{MODES, ORDERS};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{
    Budget, BuildOptions, Mesh, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes,
};

/// All orders and modes, each without a budget, with one, and with the queue in use from the first pair on.
#[track_caller]
fn assert_equal_to_brute_force(a: &Tree, b: &Tree, pose: Pose, workspace: &mut Workspace) -> usize {
    let truth = all_pairs(a.mesh(), b.mesh(), &pose);
    for mode in MODES {
        for order in ORDERS {
            let query = Query::intersection(a, b, pose).mode(mode).order(order);
            for (query, budget) in [
                (query, Budget::unlimited()),
                (query, ENOUGH),
                (query.plain(), ENOUGH),
            ] {
                let (outcome, pairs) = run_to_end(&query, workspace, budget);
                assert_complete(mode, &outcome, &pairs, &truth);
            }
        }
    }
    truth.len()
}

/// Both answers must occur, or the family tests half of what it seems to.
fn assert_soups_equal(family: Family) {
    let mut random = Random::new(family as u64 + 1);
    let mut workspace = Workspace::new();
    let (mut touching, mut apart) = (0, 0);
    for (a_triangles, b_triangles) in [(1, 1), (3, 9), (60, 60), (200, 17), (1, 90), (90, 1)] {
        let a = Tree::new(soup(family, a_triangles, &mut random));
        let b = Tree::new(soup(family, b_triangles, &mut random));
        a.validate().unwrap();
        b.validate().unwrap();
        let poses = poses(family, 9, &mut random)
            .into_iter()
            .map(|pose| (&b, pose));
        for (b, pose) in poses.chain([(&a, Pose::IDENTITY)]) {
            match assert_equal_to_brute_force(&a, b, pose, &mut workspace) {
                0 => apart += 1,
                _ => touching += 1,
            }
        }
    }
    assert!(touching > 0 && apart > 0, "{touching} and {apart}");
}

soups!(assert_soups_equal);

/// One triangle of any size, either way around: from a thousandth of the mesh to a thousand times it, and one without area;
/// where both lie near their origins, and where the pose brings back what lies far from its own.
#[test]
fn a_lone_triangle_against_a_mesh() {
    let knot = shapes::torus_knot(2, 3, 0.15, 12);
    let far = DVec3::new(1e8, -3e7, 2e8);
    let mut random = Random::new(81);
    let mut workspace = Workspace::new();
    let moved = |corners: &[DVec3], by: DVec3, triangles: &[[u32; 3]]| {
        let corners = corners.iter().map(|&corner| (corner + by).to_array());
        Tree::new(Mesh::from_f64(corners, triangles.iter().copied()).unwrap())
    };
    for [of_mesh, of_one] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, -1.0]] {
        let corners: Vec<_> = (0..knot.vertex_count()).map(|i| knot.vertex(i)).collect();
        let mesh = moved(&corners, far * of_mesh, knot.triangles());
        let (mut touching, mut apart) = (0, 0);
        for size in [1e-3, 0.03, 0.2, 1.0, 5.0, 1e3] {
            for corner in [[0.3, 0.9], [1.0, 0.0]] {
                let corners =
                    [[-0.5, -0.3], [0.5, -0.3], corner].map(|[x, y]| size * DVec3::new(x, y, 0.0));
                let one = moved(&corners, far * of_one, &[[0, 1, 2]]);
                for i in 0..if of_mesh == of_one { 24 } else { 12 } {
                    // A point of the triangle lies on a triangle of the mesh, or near it.
                    let drift = [Drift::None, Drift::Scale, Drift::Shear][i % 3];
                    let turn = *pose_about(DVec3::ZERO, 1.0, drift, &mut random).rotation();
                    let [p, q, r] = mesh.mesh().triangle(i * 17 % mesh.mesh().len());
                    let normal = (q - p).cross(r - p).normalize();
                    let at = (p + q + r) / 3.0 + normal * 0.25 * size.min(1.0) * (i % 4) as f64;
                    let [x, y, z] = one.mesh().triangle(0);
                    let pose = Pose::new(turn, at - turn * (x * 0.3 + y * 0.4 + z * 0.3)).unwrap();
                    for met in [
                        assert_equal_to_brute_force(&mesh, &one, pose, &mut workspace),
                        assert_equal_to_brute_force(
                            &one,
                            &mesh,
                            pose.inverse().unwrap(),
                            &mut workspace,
                        ),
                    ] {
                        (touching, apart) = if met > 0 {
                            (touching + 1, apart)
                        } else {
                            (touching, apart + 1)
                        };
                    }
                }
            }
        }
        assert!(touching > 50 && apart > 50, "{touching} and {apart}");
    }
}

#[test]
fn shapes_against_shapes() {
    let trees = [
        shapes::icosphere(2),
        shapes::cuboid(Vec3::new(0.8, 0.5, 0.1), 3),
        shapes::torus(1.0, 0.2, 12),
        shapes::torus_knot(2, 3, 0.15, 12),
        shapes::gear(9, 2),
        shapes::height_field(12, 5),
    ]
    .map(Tree::new);
    let mut random = Random::new(77);
    let mut workspace = Workspace::new();
    for a in &trees {
        for b in &trees {
            for drift in [Drift::None, Drift::Scale, Drift::Shear] {
                let pose = pose_about(DVec3::ZERO, 1.0, drift, &mut random);
                assert_equal_to_brute_force(a, b, pose, &mut workspace);
            }
        }
    }
}

/// A mesh on itself: every box overlaps its twin exactly, every triangle meets its neighbours.
#[test]
fn coincident_shapes() {
    let mut workspace = Workspace::new();
    for mesh in [shapes::icosphere(1), shapes::cuboid(Vec3::ONE, 2)] {
        let tree = Tree::new(mesh);
        for shift in [0.0, 1e-9, 1e-16, f64::MIN_POSITIVE] {
            let pose = Pose::new(DMat3::IDENTITY, DVec3::new(shift, 0.0, 0.0)).unwrap();
            assert_equal_to_brute_force(&tree, &tree, pose, &mut workspace);
        }
    }
}

/// Each triangle an eighth as large and as far as the one before: no split can balance the tree.
#[test]
fn the_deepest_tree() {
    let corner = |k: u32, x: f64, y: f64| {
        (f64::exp2(1000.0 - 3.0 * f64::from(k)) * DVec3::new(x, y, 0.25)).to_array()
    };
    let corners = (0..600).flat_map(|k| {
        [
            corner(k, 1.0, 0.0),
            corner(k, 0.75, 0.0),
            corner(k, 0.75, 0.5),
        ]
    });
    let triangles = (0..600).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
    let tree = Tree::new(Mesh::from_f64(corners, triangles).unwrap());
    tree.validate().unwrap();
    let mut workspace = Workspace::new();
    for mut workspace in [Workspace::new(), Workspace::with_capacity(0, 100)] {
        assert_equal_to_brute_force(&tree, &tree, Pose::IDENTITY, &mut workspace);
    }
    let turn = DMat3::from_rotation_x(0.3);
    let turned = Pose::new(turn, DVec3::ZERO).unwrap();
    assert_equal_to_brute_force(&tree, &tree, turned, &mut workspace);
}

/// A grain of dust, and a crowd of them, against a mesh a million times as large.
#[test]
fn meshes_of_very_unequal_size() {
    let mut random = Random::new(5);
    let mut workspace = Workspace::new();
    let large = Tree::new(scaled(&shapes::icosphere(2), 1e6));
    let surface = large.mesh().triangle(11)[0];
    let mut touching = 0;
    for count in [1, 30] {
        let small = Tree::new(soup(Family::Uniform, count, &mut random));
        for _ in 0..20 {
            let reach = 1e6 * random.vector();
            for center in [surface, reach] {
                let pose = Pose::new(random.rotation(), center + random.vector()).unwrap();
                touching += assert_equal_to_brute_force(&large, &small, pose, &mut workspace);
                let inverse = pose.inverse().unwrap();
                assert_equal_to_brute_force(&small, &large, inverse, &mut workspace);
            }
        }
    }
    assert!(touching > 0);
}

fn scaled(mesh: &Mesh, factor: f64) -> Mesh {
    let vertices = (0..mesh.vertex_count()).map(|index| factor * mesh.vertex(index));
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

#[test]
fn no_poll_interval_changes_the_answer() {
    let a = Tree::new(shapes::torus_knot(2, 3, 0.2, 16));
    let b = Tree::new(shapes::gear(11, 2));
    let mut random = Random::new(9);
    let mut workspace = Workspace::new();
    for _ in 0..4 {
        let pose = pose_about(DVec3::ZERO, 0.8, Drift::None, &mut random);
        let truth = all_pairs(a.mesh(), b.mesh(), &pose);
        for mode in MODES {
            for order in ORDERS {
                for poll in [0, 1, u64::MAX] {
                    let query = Query::intersection(&a, &b, pose).mode(mode).order(order);
                    let (outcome, pairs) =
                        run_to_end(&query, &mut workspace, ENOUGH.poll_interval(poll));
                    assert_complete(mode, &outcome, &pairs, &truth);
                }
            }
        }
    }
}

#[test]
fn an_empty_mesh_is_separated_from_everything() {
    let empty = || Mesh::new([[0.0f32; 3]], []).unwrap();
    let nothing = Tree::new(empty());
    let built = Tree::with_options(empty(), &BuildOptions::default());
    let sphere = Tree::new(shapes::icosphere(1));
    let mut workspace = Workspace::new();
    for (a, b) in [(&nothing, &sphere), (&sphere, &nothing), (&nothing, &built)] {
        for mode in MODES {
            for order in ORDERS {
                let query = Query::intersection(a, b, Pose::IDENTITY)
                    .mode(mode)
                    .order(order);
                let outcome = run(&query, &mut workspace, Budget::unlimited());
                assert_eq!(outcome.value, Verdict::Separated);
                assert_eq!(outcome.stop, StopReason::Finished);
                assert_eq!(outcome.stats.found, 0);
            }
        }
    }
}
