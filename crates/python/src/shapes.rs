//! Generated trees, for first steps and tests.

use crate::arrays::numbers;
use crate::tree::Tree;
use punctual::shapes;
use pyo3::prelude::*;

/// The tree of a sphere of radius 1 with 20 * 4^subdivisions triangles.
#[pyfunction]
pub fn icosphere(py: Python<'_>, subdivisions: u32) -> PyResult<Tree> {
    Tree::of(py, move || shapes::icosphere(subdivisions))
}

/// The tree of a box whose faces are split into cells x cells squares.
#[pyfunction]
pub fn cuboid(py: Python<'_>, half_extents: &Bound<'_, PyAny>, cells: u32) -> PyResult<Tree> {
    let half_extents = numbers(half_extents, "half_extents")?.map(|length: f64| length as f32);
    Tree::of(py, move || shapes::cuboid(half_extents, cells))
}

/// The tree of a ring around the z axis.
#[pyfunction]
pub fn torus(py: Python<'_>, major: f32, minor: f32, resolution: u32) -> PyResult<Tree> {
    Tree::of(py, move || shapes::torus(major, minor, resolution))
}

/// The tree of a tube around a (p, q) torus knot.
#[pyfunction]
pub fn torus_knot(py: Python<'_>, p: u32, q: u32, tube: f32, resolution: u32) -> PyResult<Tree> {
    Tree::of(py, move || shapes::torus_knot(p, q, tube, resolution))
}
