//! Meshes, trees and poses that many tests are about.

use punctual::glam::{DMat3, DVec3};
use punctual::tree::Solid;
use punctual::{BuildOptions, Mesh, Pose, Tree, shapes};

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    placed(DMat3::IDENTITY, DVec3::new(x, y, z))
}

pub fn placed(rotation: DMat3, place: impl Into<DVec3>) -> Pose {
    Pose::new(rotation, place.into()).expect("a rotation")
}

pub fn ball(detail: u32) -> Tree {
    Tree::new(shapes::icosphere(detail))
}

/// The cube from -1 to 1, each face in `cells`^2 squares.
pub fn cube(cells: u32) -> Tree {
    Tree::new(shapes::cuboid([1.0; 3], cells))
}

pub fn ring(cells: u32) -> Tree {
    Tree::new(shapes::torus(1.0, 0.15, cells))
}

/// A torus knot of two and three turns.
pub fn knot(thickness: f32, cells: u32) -> Tree {
    Tree::new(shapes::torus_knot(2, 3, thickness, cells))
}

pub fn solid(mesh: Mesh) -> Tree {
    Tree::with_options(mesh, &BuildOptions::default().solid(Solid::Keep))
}

/// No triangle at all.
pub fn nothing() -> Tree {
    Tree::new(Mesh::new([[0.0_f32; 3]], []).unwrap())
}

/// The mesh with each vertex moved.
pub fn moved(mesh: &Mesh, place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let vertices = (0..mesh.vertex_count()).map(|index| place(mesh.vertex(index)));
    Mesh::from_f64(vertices, mesh.triangles().iter().copied()).unwrap()
}

/// Triangles of three corners each, none of them shared.
pub fn triangles(corners: impl IntoIterator<Item = [DVec3; 3]>) -> Mesh {
    let corners: Vec<DVec3> = corners.into_iter().flatten().collect();
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Mesh::from_f64(corners, triangles).unwrap()
}

/// The tree of one triangle.
pub fn one(corners: [DVec3; 3]) -> Tree {
    Tree::new(triangles([corners]))
}
