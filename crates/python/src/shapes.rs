//! Generated trees, for first steps and tests.

use crate::tree::Tree;
use punctual::shapes;
use pyo3::prelude::*;

/// The tree of a sphere of radius 1 with 20 * 4^subdivisions triangles.
#[pyfunction]
pub fn icosphere(subdivisions: u32) -> Tree {
    Tree::new(shapes::icosphere(subdivisions))
}

/// The tree of a box whose faces are split into cells x cells squares.
#[pyfunction]
pub fn cuboid(half_extents: [f32; 3], cells: u32) -> Tree {
    Tree::new(shapes::cuboid(half_extents, cells))
}

/// The tree of a ring around the z axis.
#[pyfunction]
pub fn torus(major: f32, minor: f32, resolution: u32) -> Tree {
    Tree::new(shapes::torus(major, minor, resolution))
}

/// The tree of a tube around a (p, q) torus knot.
#[pyfunction]
pub fn torus_knot(p: u32, q: u32, tube: f32, resolution: u32) -> Tree {
    Tree::new(shapes::torus_knot(p, q, tube, resolution))
}
