//! A refitted tree answers as exactly as a new one, however far the vertices went, and says when a new one would pay.

mod common;

use common::check::{ENOUGH, assert_complete, resume, run, run_to_end};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::all_pairs;
use common::{MODES, ORDERS};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::prediction::CostModel;
use punctual::{
    Aabb, Budget, BuildOptions, Mesh, MeshError, Mode, PairMemory, Pose, Query, Tree, Verdict,
    Workspace, shapes,
};

fn vertices(mesh: &Mesh) -> Vec<DVec3> {
    (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect()
}

fn all_options() -> [BuildOptions; 3] {
    let mut axes = BuildOptions::default();
    axes.orientations = false;
    [BuildOptions::fast_build(), BuildOptions::default(), axes]
}

/// Both trees in all orders and modes against all pairs.
#[track_caller]
fn assert_exact(a: &Tree, b: &Tree, pose: Pose) -> usize {
    a.validate().unwrap();
    let truth = all_pairs(a.mesh(), b.mesh(), &pose);
    let mut workspace = Workspace::new();
    for mode in MODES {
        for order in ORDERS {
            let query = Query::intersection(a, b, pose).mode(mode).order(order);
            let (outcome, pairs) = run_to_end(&query, &mut workspace, ENOUGH);
            assert_complete(mode, &outcome, &pairs, &truth);
        }
    }
    truth.len()
}

#[test]
fn unchanged_vertices_give_the_same_tree() {
    let mut random = Random::new(21);
    for family in Family::ALL {
        for options in all_options() {
            let built = Tree::with_options(soup(family, 300, &mut random), &options);
            let mut refitted = built.clone();
            refitted.refit_f64(&vertices(built.mesh())).unwrap();
            assert_eq!(
                (refitted.mesh(), refitted.stats()),
                (built.mesh(), built.stats())
            );
            assert_eq!(refitted.degradation(), 1.0, "{family:?}");
            let pose = pose_about(
                family.center(),
                0.5 * family.scale(),
                Drift::None,
                &mut random,
            );
            let answer = |tree: &Tree| {
                let mut workspace = Workspace::new();
                let query = Query::all_pairs(tree, tree, pose);
                let outcome = run(&query, &mut workspace, ENOUGH);
                (outcome, workspace.pairs().to_vec())
            };
            assert_eq!(answer(&refitted), answer(&built), "{family:?}");
        }
    }
}

type Deformation = (&'static str, fn(DVec3) -> DVec3);

/// From a wobble to the loss of two dimensions; some need f64, some another unit.
const DEFORMATIONS: [Deformation; 8] = [
    ("wobble", |v| {
        v + 0.01 * DVec3::new((9.0 * v.y).sin(), (7.0 * v.z).sin(), (8.0 * v.x).sin())
    }),
    ("twist", |v| DMat3::from_rotation_z(2.0 * v.z) * v),
    ("turn inside out", |v| v / (v.length_squared() + 0.3)),
    ("stretch a thousandfold", |v| {
        DVec3::new(1000.0, 1.0, 1e-3) * v
    }),
    ("shift far away", |v| v + DVec3::new(1e7, -3e6, 0.1)),
    ("shrink to dust", |v| 1e-200 * v),
    ("squash to a plane", |v| DVec3::new(v.x, v.y, 0.25)),
    ("collapse to a point", |_| DVec3::new(0.5, 0.25, 0.125)),
];

#[test]
fn deformed_meshes_are_answered_exactly() {
    let mut random = Random::new(4);
    let still = Tree::new(shapes::torus(1.0, 0.3, 14));
    for options in all_options() {
        let mut tree = Tree::with_options(shapes::torus_knot(2, 3, 0.2, 16), &options);
        let rest = vertices(tree.mesh());
        let mut touching = 0;
        // Always from the last shape, not from the first.
        for (name, deformation) in DEFORMATIONS {
            let moved: Vec<DVec3> = rest.iter().map(|&v| deformation(v)).collect();
            tree.refit_f64(&moved).unwrap();
            assert_eq!(vertices(tree.mesh()), moved, "{name}");
            let bounds = tree.mesh().aabb();
            let center = bounds.center();
            let pose = pose_about(DVec3::ZERO, 0.2, Drift::None, &mut random);
            touching += assert_exact(&tree, &still, Pose::new(*pose.rotation(), center).unwrap());
            assert_exact(
                &tree,
                &tree,
                Pose::new(DMat3::IDENTITY, bounds.extents() * 0.3).unwrap(),
            );
        }
        assert!(touching > 100, "{touching}");
        tree.refit_f64(&rest).unwrap();
        assert!(
            (tree.degradation() - 1.0).abs() < 1e-4,
            "{}",
            tree.degradation()
        );
    }
}

/// Every vertex somewhere else: nothing of the old tree fits any more.
#[test]
fn scattered_vertices_are_answered_exactly() {
    let mut random = Random::new(12);
    for family in Family::ALL {
        let mut tree = Tree::new(soup(Family::Uniform, 150, &mut random));
        let scattered = vertices(&soup(family, 150, &mut random));
        tree.refit_f64(&scattered).unwrap();
        let pose = pose_about(
            family.center(),
            0.1 * family.scale(),
            Drift::Scale,
            &mut random,
        );
        assert_exact(&tree, &tree, pose);
        assert_exact(&tree, &tree, Pose::IDENTITY);
    }
}

#[test]
fn f32_and_f64_vertices_are_the_same_where_both_are_exact() {
    let mut tree = Tree::new(shapes::gear(9, 2));
    let moved: Vec<Vec3> = vertices(tree.mesh())
        .iter()
        .map(|v| v.as_vec3() * 3.0)
        .collect();
    tree.refit(&moved).unwrap();
    let mut twin = Tree::new(shapes::gear(9, 2));
    twin.refit_f64(&moved.iter().map(|v| v.as_dvec3()).collect::<Vec<_>>())
        .unwrap();
    assert!(tree.mesh().is_f32() && tree.mesh() == twin.mesh() && tree.stats() == twin.stats());
}

/// One triangle; the last vertex is not used.
const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 2.0, -3.0],
    [7.0, 7.0, 7.0],
];

fn one_triangle() -> Tree {
    Tree::new(Mesh::new(CORNERS, [[0, 1, 2]]).unwrap())
}

#[test]
fn the_mesh_with_new_vertices_is_that_of_a_new_one() {
    let moved = CORNERS.map(|v| v.map(|x| 2.0 * x - 1.0));
    for triangles in [&[[0, 1, 2]][..], &[[0, 1, 2], [1, 2, 3]]] {
        let mesh = |vertices| Mesh::new(vertices, triangles.iter().copied()).unwrap();
        let mut tree = Tree::new(mesh(CORNERS));
        tree.refit(&moved).unwrap();
        assert_eq!(tree.mesh(), &mesh(moved));
        tree.refit_f64(&CORNERS.map(|v| v.map(f64::from))).unwrap();
        assert_eq!(tree.mesh(), &mesh(CORNERS));
    }
}

#[test]
fn unused_vertices_may_become_anything() {
    let mut tree = one_triangle();
    tree.refit(&[CORNERS[0], CORNERS[1], CORNERS[1], [0.0, f32::NAN, 0.0]])
        .unwrap();
    assert_eq!(tree.mesh().aabb(), Aabb::new(DVec3::ZERO, DVec3::X));
}

#[test]
fn vertices_that_need_f64_get_it_and_keep_it() {
    let mut tree = one_triangle();
    let tenth = CORNERS.map(|v| v.map(|x| f64::from(x) * 0.1));
    tree.refit_f64(&tenth).unwrap();
    assert!(!tree.mesh().is_f32());
    assert_eq!(tree.mesh().vertex(2).to_array(), tenth[2]);
    tree.refit(&CORNERS).unwrap();
    assert!(!tree.mesh().is_f32());
    assert_eq!(tree.mesh().vertex(2), DVec3::new(0.0, 2.0, -3.0));
}

#[test]
fn faults_are_named_and_change_nothing() {
    let mut tree = Tree::new(shapes::icosphere(2));
    let rest = vertices(tree.mesh());
    let error = tree.refit_f64(&rest[1..]).unwrap_err();
    assert_eq!(
        error,
        MeshError::VertexCount {
            given: rest.len() - 1,
            vertices: rest.len()
        }
    );
    assert_eq!(
        error.to_string(),
        format!(
            "{} new vertices for a mesh with {}",
            rest.len() - 1,
            rest.len()
        )
    );
    for bad in [f64::NAN, f64::INFINITY, 1e308] {
        let mut moved = rest.clone();
        moved[17].y = bad;
        let error = tree.refit_f64(&moved).unwrap_err();
        let expected = match bad.is_finite() {
            true => MeshError::TooLarge {
                vertex: 17,
                axis: 1,
            },
            false => MeshError::NotFinite {
                vertex: 17,
                axis: 1,
            },
        };
        assert_eq!(error, expected);
    }
    let mut moved: Vec<Vec3> = rest.iter().map(|v| v.as_vec3()).collect();
    assert_eq!(tree.refit(&moved[1..]).unwrap_err(), error);
    moved[17].z = f32::NAN;
    assert_eq!(
        tree.refit(&moved).unwrap_err(),
        MeshError::NotFinite {
            vertex: 17,
            axis: 2
        }
    );
    assert_eq!(vertices(tree.mesh()), rest);
    assert_exact(
        &tree,
        &tree,
        Pose::new(DMat3::IDENTITY, DVec3::new(0.3, 0.0, 0.0)).unwrap(),
    );
}

/// What a stopped query left in its workspace is about the old shape.
#[test]
fn a_query_is_not_resumed_over_a_refit() {
    let mut tree = Tree::new(shapes::icosphere(3));
    let rest = vertices(tree.mesh());
    let mut workspace = Workspace::new();
    let stopped = run(
        &Query::all_pairs(&tree, &tree, Pose::IDENTITY),
        &mut workspace,
        Budget::work(500),
    );
    assert!(!matches!(stopped.value, Verdict::Separated));
    let more = resume(
        &Query::all_pairs(&tree, &tree, Pose::IDENTITY),
        &mut workspace,
        Budget::work(500),
    );
    assert_ne!(more.stop, punctual::StopReason::Finished);
    tree.refit_f64(&rest).unwrap();
    let query = Query::all_pairs(&tree, &tree, Pose::IDENTITY);
    let clock = punctual::clock::ManualClock::new();
    assert!(query.resume(&mut workspace, ENOUGH.clock(&clock)).is_err());
}

/// The triangles that met are still those to try first when the mesh has moved a little.
#[test]
fn memory_outlives_a_refit() {
    let mut tree = Tree::new(shapes::icosphere(4));
    let moved: Vec<DVec3> = vertices(tree.mesh())
        .iter()
        .map(|v| *v * 1.000001)
        .collect();
    let pose = Pose::new(DMat3::IDENTITY, DVec3::new(0.5, 0.2, 0.1)).unwrap();
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let clock = punctual::clock::ManualClock::new();
    let mut ask = |tree: &Tree| {
        let query = Query::intersection(tree, tree, pose).mode(Mode::Any);
        query
            .with_memory(&mut memory)
            .run(&mut workspace, ENOUGH.clock(&clock))
    };
    assert!(ask(&tree).stats.bv_tests > 0);
    tree.refit_f64(&moved).unwrap();
    let again = ask(&tree);
    assert!(
        matches!(again.value, Verdict::Intersecting { .. }),
        "{again:?}"
    );
    assert_eq!(again.stats.bv_tests, 0);
}

#[test]
fn an_empty_mesh_is_refitted() {
    let mut tree = Tree::new(Mesh::new([[0.0f32; 3]; 0], []).unwrap());
    tree.refit::<[f32; 3]>(&[]).unwrap();
    assert_eq!((tree.degradation(), tree.root().is_none()), (1.0, true));
    let costs = CostModel::new([0.0, 0.0, 2.0, 0.0]);
    assert_eq!(costs.refit_time(&tree), 0.0);
    let tree = Tree::new(shapes::icosphere(3));
    assert_eq!(
        costs.refit_time(&tree),
        2.0 * (tree.stats().nodes + tree.mesh().len()) as f64
    );
}

/// Degradation grows with the motion that makes a new tree pay, and a new tree has none.
#[test]
fn degradation_tells_wobbles_from_ruins() {
    let mesh = shapes::torus_knot(2, 3, 0.2, 64);
    let rest = vertices(&mesh);
    let mut tree = Tree::new(mesh);
    let mut degradation = |amount: f64| {
        let moved: Vec<DVec3> = rest
            .iter()
            .map(|v| DMat3::from_rotation_z(amount * v.z) * *v)
            .collect();
        tree.refit_f64(&moved).unwrap();
        f64::from(tree.degradation())
    };
    let twists = [0.0, 0.1, 1.0, 5.0, 25.0].map(&mut degradation);
    assert_eq!(twists[0], 1.0);
    assert!(twists[1] < 1.1 && twists[3] > 1.5, "{twists:?}");
    assert!(twists.is_sorted(), "{twists:?}");
    let moved = tree.mesh().clone();
    assert_eq!(Tree::new(moved).degradation(), 1.0);
}
