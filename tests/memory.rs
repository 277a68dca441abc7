//! The formulas for memory in `docs/real-time.md`, checked against what the allocator hands out.

#[path = "common/allocations.rs"]
mod allocations;

use std::sync::Arc;

use allocations::held;
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, BuildOptions, Mesh, Pose, Tree, Workspace, shapes};
use punctual_scene::{Body, Scene};

#[test]
fn a_workspace_has_20_bytes_a_queued_and_8_a_found_pair() {
    for (queue, found) in [(0, 1), (4096, 65536), (100, 7)] {
        let (_workspace, bytes) = held(|| Workspace::with_capacity(queue, found));
        assert_eq!(bytes, 356_360 + 20 * queue + 8 * found);
    }
}

#[test]
fn the_page_tells_the_bytes_of_a_workspace_with_the_defaults() {
    let (_workspace, bytes) = held(Workspace::new);
    let told = format!("{},{:03} with the defaults", bytes / 1000, bytes % 1000);
    assert!(
        include_str!("../docs/real-time.md").contains(&told),
        "{told}"
    );
}

#[test]
fn a_tree_holds_what_its_statistics_say_and_less_than_200_bytes_a_triangle() {
    let meshes = [
        shapes::icosphere(5),
        shapes::torus_knot(2, 3, 0.2, 128),
        shapes::gear(25, 4),
        shapes::height_field(64, 3),
    ];
    for mesh in meshes {
        let wide = (0..mesh.vertex_count())
            .map(|i| mesh.vertex(i) * 0.1)
            .collect::<Vec<DVec3>>();
        let wide = Mesh::from_f64(wide, mesh.triangles().iter().copied()).unwrap();
        for mesh in [mesh, wide] {
            let (triangles, bytes_mesh) = (mesh.len(), mesh.bytes());
            let (tree, bytes) = held(|| Tree::new(mesh));
            assert_eq!(bytes + bytes_mesh, tree.stats().bytes());
            let per_triangle = tree.stats().bytes() as f64 / triangles as f64;
            println!(
                "{triangles} triangles, f32 {}: {per_triangle:.1} bytes each",
                tree.mesh().is_f32()
            );
            assert!(per_triangle < 200.0);
            let file = tree.to_bytes();
            let (_loaded, bytes) = held(|| Tree::from_bytes(&file).unwrap());
            assert_eq!(bytes, tree.stats().bytes());
            let (mesh, options) = (tree.mesh().clone(), BuildOptions::default().extremes(true));
            let (tree, bytes) = held(|| Tree::with_options(mesh, &options));
            assert_eq!(bytes + bytes_mesh, tree.stats().bytes());
            assert!((9_000..10_000 + 10 * triangles).contains(&tree.stats().bytes_extremes));
        }
    }
}

#[test]
fn a_scene_has_a_fixed_part_and_some_hundred_bytes_a_body_and_a_pair() {
    let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    let (mut scene, fixed) = held(Scene::new);
    println!("a scene: {fixed} bytes");
    assert!(fixed < 7_000_000);
    // A row in which each meets the next.
    for bodies in [100, 400] {
        let (pairs, bytes) = held(|| {
            while scene.len() < bodies {
                let pose = Pose::new(DMat3::IDENTITY, DVec3::X * 1.5 * scene.len() as f64).unwrap();
                scene.insert(Body::moving(Arc::clone(&ball), pose)).unwrap();
            }
            scene
                .detect(Budget::unlimited().clock(&ManualClock::new()))
                .pairs
                .len()
        });
        println!("{} bodies, {pairs} pairs: {bytes} bytes more", scene.len());
        assert!(bytes < 50_000 + bodies * 3500);
    }
}
