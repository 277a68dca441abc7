//! How a part lies in its file must not matter: not for the answer, and hardly for the work.

use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::{Budget, Mesh, Pose, Query, Tree, Workspace, shapes};

fn turned(mesh: &Mesh, by: DQuat) -> Mesh {
    let vertices = (0..mesh.vertex_count()).map(|i| by * mesh.vertex(i));
    Mesh::from_f64(
        vertices.map(|v| v.to_array()),
        mesh.triangles().iter().copied(),
    )
    .unwrap()
}

/// Work of finding all pairs at some poses, with both meshes turned in their files and the poses turned back.
fn work(a: &Mesh, b: &Mesh, turn_a: DQuat, turn_b: DQuat) -> (u64, u64) {
    let (a, b) = (Tree::new(turned(a, turn_a)), Tree::new(turned(b, turn_b)));
    let mut workspace = Workspace::new();
    let (mut work, mut found) = (0, 0);
    for i in 0..40 {
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.1 * f64::from(i), -0.7));
        let shift = DVec3::new(0.02 * f64::from(i), 0.9, 0.3);
        let rotation = DMat3::from_quat(turn_a * turn * turn_b.inverse());
        let pose = Pose::new(rotation, turn_a * shift).unwrap();
        let query = Query::all_pairs(&a, &b, pose);
        let outcome = query.run(
            &mut workspace,
            Budget::unlimited().clock(&ManualClock::new()),
        );
        work += outcome.stats.work;
        found += outcome.stats.found;
    }
    (work, found)
}

/// Long thin beams along all three axes: their triangles' boxes are large only when the part is tilted.
fn frame_of_beams() -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for i in 0..64 {
            let mut half = [0.01; 3];
            half[axis] = 1.0;
            let mut center = [0.0; 3];
            center[(axis + 1) % 3] = f64::from(i % 8) / 4.0 - 0.875;
            center[(axis + 2) % 3] = f64::from(i / 8) / 4.0 - 0.875;
            let beam = shapes::cuboid(Vec3::from_array(half), 1);
            let first = vertices.len() as u32;
            vertices.extend(
                (0..beam.vertex_count()).map(|k| (beam.vertex(k) + DVec3::from(center)).to_array()),
            );
            triangles.extend(beam.triangles().iter().map(|t| t.map(|k| k + first)));
        }
    }
    Mesh::from_f64(vertices, triangles).unwrap()
}

#[test]
fn tilted_parts_cost_about_the_same() {
    let beams = frame_of_beams();
    let gear = shapes::gear(17, 3);
    for (a, b) in [(&beams, &gear), (&gear, &gear), (&beams, &beams)] {
        let (straight, found) = work(a, b, DQuat::IDENTITY, DQuat::IDENTITY);
        let turn_a = DQuat::from_scaled_axis(DVec3::new(0.5, -0.4, 0.3));
        let turn_b = DQuat::from_scaled_axis(DVec3::new(-0.2, 0.6, 0.8));
        let (tilted, found_tilted) = work(a, b, turn_a, turn_b);
        assert!(found > 1000, "{found}");
        // Turning rounds the vertices, so contacts at the very border may differ.
        assert!(found.abs_diff(found_tilted) <= found / 1000, "{found}");
        assert!(tilted * 10 <= straight * 13, "{tilted} against {straight}");
    }
}
