//! Scaled and mirrored instances: they answer as a tree built of the scaled mesh, at its cost.

mod common;

use common::check::{ENOUGH, run, sorted};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::all_pairs;
use punctual::glam::DVec3;
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Mesh, MeshError, Pose, Query, Tree, Workspace, shapes};

/// Mirrored one, two and three times, stretched, flattened and tiny.
const FACTORS: [[f64; 3]; 8] = [
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0; 3],
    [2.0, 0.5, 1.0],
    [-1.5, 2.5, 0.7],
    [1.0, 1e-9, 1.0],
    [0.001; 3],
    [1e-250, -2.0, 1.0],
];

fn all_options() -> [BuildOptions; 3] {
    let mut axes = BuildOptions::default();
    axes.orientations = false;
    [BuildOptions::fast_build(), BuildOptions::default(), axes]
}

#[test]
fn scaled_trees_find_the_pairs_of_the_scaled_mesh() {
    let (mut random, mut touching) = (Random::new(66), 0);
    let knot = shapes::torus_knot(2, 3, 0.2, 12);
    let soups = Family::ALL.map(|family| soup(family, 120, &mut random));
    for mesh in soups.into_iter().chain([knot]) {
        for options in all_options() {
            let tree = Tree::with_options(mesh.clone(), &options);
            for factors in FACTORS {
                let scaled = tree.scaled(factors).unwrap();
                scaled.validate().unwrap();
                for i in 0..mesh.vertex_count() {
                    let expected = mesh.vertex(i) * DVec3::from(factors);
                    assert_eq!(scaled.mesh().vertex(i), expected, "{factors:?}");
                }
                let reach = scaled.mesh().aabb().extents() * 0.2;
                let pose = pose_about(DVec3::ZERO, 0.0, Drift::None, &mut random);
                let center = scaled.mesh().aabb().center();
                let about = center - *pose.rotation() * center + reach;
                let pose = Pose::new(*pose.rotation(), about).unwrap();
                let query = Query::all_pairs(&scaled, &scaled, pose);
                let mut workspace = Workspace::new();
                let _ = run(&query, &mut workspace, ENOUGH);
                let truth = all_pairs(scaled.mesh(), scaled.mesh(), &pose);
                assert_eq!(sorted(workspace.pairs()), truth, "{factors:?}");
                touching += truth.len();
            }
        }
    }
    assert!(touching > 10_000, "{touching}");
}

/// A mirrored triangle turns, so its neighbors change places too.
#[test]
fn neighbors_of_mirrored_triangles_share_their_edges() {
    let tree = Tree::new(shapes::torus_knot(2, 3, 0.2, 16));
    let mirrored = tree.scaled([1.0, -2.0, 1.0]).unwrap();
    for triangle in 0..mirrored.mesh().len() as u32 {
        let corners = mirrored.vertices_of(triangle);
        let id = mirrored.ids()[triangle as usize] as usize;
        assert_eq!(mirrored.mesh().triangles()[id], corners);
        for edge in 0..3 {
            let next = mirrored.across(triangle, edge).unwrap();
            let there = mirrored.vertices_of(next);
            assert!(there.contains(&corners[edge]) && there.contains(&corners[(edge + 1) % 3]));
        }
    }
}

#[test]
fn mirrored_solids_keep_their_inside() {
    let mut workspace = Workspace::new();
    let options = BuildOptions::default().solid(Solid::Keep).extremes(true);
    let tree = Tree::with_options(shapes::icosphere(3), &options);
    let volume = tree.solid().unwrap().volume();
    for factors in [[-1.0, 1.0, 1.0], [2.0, 3.0, 0.5], [-2.0, -3.0, -0.5]] {
        let scaled = tree.scaled(factors).unwrap();
        let fresh = Tree::with_options(scaled.mesh().clone(), &options);
        let (one, other) = (scaled.solid().unwrap(), fresh.solid().unwrap());
        let product = factors.iter().product::<f64>().abs() * volume;
        assert!((one.volume() - product).abs() < 1e-12 * product);
        assert!(!one.components()[0].inside_out && one.is_closed());
        assert!(!other.components()[0].inside_out);
        assert_eq!(
            scaled.stats().bytes_extremes > 0,
            fresh.stats().bytes_extremes > 0
        );
        for (point, inside) in [(DVec3::ZERO, 1.0), (DVec3::X * 2.5, 0.0)] {
            let query = Query::winding(&scaled, point).unwrap();
            let answer = query.run(&mut workspace, Budget::unlimited());
            assert_eq!(answer.value.winding, Some(inside));
        }
    }
}

/// By units of work, so that it is the same on every machine. Without mapped orientations a
/// mirrored tree costs twice as much.
#[test]
fn queries_of_scaled_trees_cost_little_more_than_those_of_new_ones() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(5));
    let probe = shapes::torus_knot(2, 3, 0.2, 24);
    let mut sums = Vec::new();
    for mesh in [
        shapes::torus_knot(3, 5, 0.3, 64),
        shapes::height_field(64, 3),
    ] {
        // Tilted, so that no box has the axes of the mesh.
        let turn = random.rotation();
        let vertices = (0..mesh.vertex_count()).map(|i| turn * mesh.vertex(i));
        let mesh = Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap();
        let tree = Tree::new(mesh);
        for factors in [
            [1.0, 1.0, -1.0],
            [-1.0; 3],
            [2.0, 0.5, 1.0],
            [1.0, 1.0, 3.0],
        ] {
            let scaled = tree.scaled(factors).unwrap();
            let fresh = Tree::new(scaled.mesh().clone());
            let bounds = scaled.mesh().aabb();
            let size = bounds.extents().max_element();
            let probe = Tree::new(probe.scaled_by([0.15 * size; 3]).unwrap());
            let mut work = [0, 0];
            for _ in 0..60 {
                let vertex = scaled
                    .mesh()
                    .vertex(random.below(scaled.mesh().vertex_count()));
                let at = vertex + 0.2 * size * random.vector();
                let pose = Pose::new(random.rotation(), at).unwrap();
                for (sum, tree) in work.iter_mut().zip([&scaled, &fresh]) {
                    let query = Query::all_pairs(tree, &probe, pose);
                    *sum += query.run(&mut workspace, Budget::unlimited()).stats.work;
                    let query = Query::distance(tree, &probe, pose);
                    *sum += query.run(&mut workspace, Budget::unlimited()).stats.work;
                }
            }
            sums.push(work[0] as f64 / work[1] as f64);
        }
    }
    let mean = sums.iter().sum::<f64>() / sums.len() as f64;
    assert!(mean < 1.1 && sums.iter().all(|&x| x < 1.25), "{sums:?}");
}

#[test]
fn bad_factors_are_named_and_products_that_are_too_large() {
    let mesh = shapes::cuboid([1.0, 2.0, 3.0], 1);
    let tree = Tree::new(mesh.clone());
    for axis in 0..3 {
        for bad in [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY] {
            let mut factors = [1.0; 3];
            factors[axis] = bad;
            let expected = MeshError::Factor { axis, factor: bad };
            assert_eq!(mesh.scaled_by(factors).unwrap_err(), expected);
            assert_eq!(tree.scaled(factors).unwrap_err(), expected);
        }
        for large in [1.1e301, f64::MAX] {
            let mut factors = [1.0; 3];
            factors[axis] = large;
            let error = tree.scaled(factors).unwrap_err();
            assert!(
                matches!(error, MeshError::TooLarge { axis: at, .. } if at == axis),
                "{error}"
            );
        }
    }
    let error = mesh.scaled_by([1.0, f64::NAN, 1.0]).unwrap_err();
    assert!(matches!(error, MeshError::Factor { axis: 1, factor } if factor.is_nan()));
    assert_eq!(
        error.to_string(),
        "factor NaN along axis 1, must be finite and not 0"
    );
    let empty = Tree::new(Mesh::new([[0.0f32; 3]; 0], []).unwrap());
    assert!(empty.scaled([2.0; 3]).unwrap().mesh().is_empty());
}

#[test]
fn a_centered_mesh_has_its_box_about_the_origin() {
    let far = DVec3::new(1e6, -3e5, 4.0);
    let mesh = shapes::gear(12, 2);
    let vertices = (0..mesh.vertex_count()).map(|i| mesh.vertex(i) + far);
    let mesh = Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap();
    let (centered, center) = mesh.centered();
    assert_eq!(center, mesh.aabb().center());
    assert!(centered.aabb().center().length() < 1e-9);
    assert_eq!(centered.triangles(), mesh.triangles());
    for i in 0..mesh.vertex_count() {
        assert_eq!(centered.vertex(i), mesh.vertex(i) - center);
    }
    let empty = Mesh::new([[0.0f32; 3]; 0], []).unwrap();
    assert_eq!(empty.centered(), (empty.clone(), DVec3::ZERO));
}
