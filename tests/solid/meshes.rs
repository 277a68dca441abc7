//! Meshes made of others.

use punctual::Mesh;
use punctual::glam::DVec3;

/// Several meshes as one, each scaled and moved, and reversed if its scale is negative.
pub fn union(parts: &[(&Mesh, f64, DVec3)]) -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for &(mesh, scale, offset) in parts {
        let first = vertices.len() as u32;
        vertices.extend((0..mesh.vertex_count()).map(|i| mesh.vertex(i) * scale.abs() + offset));
        triangles.extend(mesh.triangles().iter().map(|t| {
            let [a, b, c] = t.map(|i| i + first);
            if scale < 0.0 { [a, c, b] } else { [a, b, c] }
        }));
    }
    Mesh::from_f64(vertices, triangles).unwrap()
}

/// The mesh with other triangles.
pub fn with_triangles(mesh: &Mesh, triangles: impl IntoIterator<Item = [u32; 3]>) -> Mesh {
    Mesh::from_f64((0..mesh.vertex_count()).map(|i| mesh.vertex(i)), triangles).unwrap()
}

/// The mesh without shared vertices, as an STL file has it.
pub fn unwelded(mesh: &Mesh) -> Mesh {
    let corners = (0..mesh.len()).flat_map(|i| mesh.triangle(i));
    Mesh::from_f64(
        corners.collect::<Vec<_>>(),
        (0..mesh.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]),
    )
    .unwrap()
}
