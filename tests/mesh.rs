//! Meshes: what is accepted, what is refused and where, and that every bit is kept.

use punctual::glam::DVec3;
use punctual::{Aabb, Mesh, MeshError};

const COORDINATE_LIMIT: f64 = f64::from_bits((1023 + 1000) << 52);
const NAN: [f64; 3] = [f64::NAN; 3];
const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, -3.0]];

fn bits(mesh: &Mesh, i: usize) -> [u64; 3] {
    mesh.vertex(i).to_array().map(f64::to_bits)
}

#[test]
fn an_index_past_the_end_is_named() {
    let error = Mesh::from_f64(CORNERS, [[0, 1, 2], [0, 3, 9]]).unwrap_err();
    let expected = MeshError::IndexOutOfRange {
        triangle: 1,
        corner: 1,
        index: 3,
        vertices: 3,
    };
    assert_eq!(error, expected);
    let text = "corner 1 of triangle 1 is vertex 3, but there are 3 vertices";
    assert_eq!(error.to_string(), text);
}

#[test]
fn a_bad_coordinate_is_named() {
    for axis in 0..3 {
        for (value, expected) in [
            (f64::NAN, MeshError::NotFinite { vertex: 2, axis }),
            (f64::NEG_INFINITY, MeshError::NotFinite { vertex: 2, axis }),
            (
                COORDINATE_LIMIT.next_up(),
                MeshError::TooLarge { vertex: 2, axis },
            ),
            (-f64::MAX, MeshError::TooLarge { vertex: 2, axis }),
        ] {
            let mut corners = CORNERS;
            corners[2][axis] = value;
            assert_eq!(Mesh::from_f64(corners, [[0, 1, 2]]), Err(expected));
        }
    }
    let infinite = [[0.0, f32::INFINITY, 0.0]];
    let expected = MeshError::NotFinite { vertex: 0, axis: 1 };
    assert_eq!(Mesh::new(infinite, [[0, 0, 0]]), Err(expected));
}

#[test]
fn the_largest_coordinates_are_accepted() {
    assert_eq!(COORDINATE_LIMIT, 2f64.powi(1000));
    let corners = [[-COORDINATE_LIMIT; 3], [COORDINATE_LIMIT; 3]];
    let mesh = Mesh::from_f64(corners, [[0, 1, 1]]).unwrap();
    assert!(!mesh.is_f32() && mesh.aabb().extents().is_finite());
    assert!(Mesh::new([[f32::MAX; 3]], [[0, 0, 0]]).unwrap().is_f32());
}

#[test]
fn unused_vertices_are_never_looked_at() {
    let vertices = [
        NAN,
        CORNERS[0],
        CORNERS[1],
        [1e300, f64::INFINITY, 0.1],
        CORNERS[2],
    ];
    let mesh = Mesh::from_f64(vertices, [[1, 2, 4]]).unwrap();
    assert!(mesh.is_f32());
    assert_eq!(mesh.aabb(), Aabb::from_points(CORNERS.map(DVec3::from)));
    assert_eq!(mesh.triangle(0), CORNERS.map(DVec3::from));
}

#[test]
fn f32_exact_vertices_are_stored_as_f32_with_every_bit() {
    let tiny = f64::from(f32::from_bits(1));
    let vertices = [[-0.0, tiny, f64::from(f32::MAX)], [0.5, -tiny, 0.0]];
    let mesh = Mesh::from_f64(vertices, [[0, 1, 1]]).unwrap();
    assert!(mesh.is_f32());
    assert_eq!(bits(&mesh, 0), vertices[0].map(f64::to_bits));
    assert_eq!(bits(&mesh, 1), vertices[1].map(f64::to_bits));
}

#[test]
fn one_inexact_coordinate_keeps_f64() {
    for value in [
        0.1,
        1e39,
        1e-46,
        1.0f64.next_up(),
        f64::from(f32::MAX).next_up(),
    ] {
        let vertices = [[0.0; 3], [0.0, 0.0, value]];
        let mesh = Mesh::from_f64(vertices, [[0, 1, 1]]).unwrap();
        assert!(!mesh.is_f32());
        assert_eq!(mesh.triangle(0)[2].z.to_bits(), value.to_bits());
        assert_eq!(bits(&mesh, 1)[2], value.to_bits());
    }
}

#[test]
fn no_triangles_are_a_mesh_with_an_empty_box() {
    let lone = Mesh::from_f64([NAN], []).unwrap();
    let none = Mesh::new([[0.0f32; 3]; 0], []).unwrap();
    assert!(lone.is_empty() && none.is_empty());
    assert_eq!((lone.vertex_count(), none.vertex_count()), (1, 0));
    assert_eq!((lone.aabb(), none.bytes()), (Aabb::EMPTY, 0));
}

#[test]
fn bytes_follow_the_storage() {
    let narrow = Mesh::from_f64(CORNERS, [[0, 1, 2]]).unwrap();
    let wide = Mesh::from_f64(CORNERS.map(|v| v.map(|c| c * 0.1)), [[0, 1, 2]]).unwrap();
    assert_eq!((narrow.bytes(), wide.bytes()), (3 * 12 + 12, 3 * 24 + 12));
}
