//! Where bodies of a scene touch.

use crate::arrays::{column, table};
use numpy::{PyArray1, PyArray2};
use punctual_scene::ContactPoint;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// Where two bodies touch: a row for each of the few points that stand for their contacts, the nearest first. Coordinates
/// are those of the scene.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct ContactPoints {
    /// (N,) uint64: the patch of contacts that each stands for; the same from frame to frame while it lasts.
    #[serde(with = "crate::arrays::bytes")]
    patches: Py<PyArray1<u64>>,
    /// (N, 2) uint32: triangles of the body of the lower index and of the other one.
    #[serde(with = "crate::arrays::bytes")]
    triangles: Py<PyArray2<u32>>,
    /// (N, 3) float64: the closest point of the triangle of the body of the lower index.
    #[serde(with = "crate::arrays::bytes")]
    points_a: Py<PyArray2<f64>>,
    /// (N, 3) float64: that of the other triangle.
    #[serde(with = "crate::arrays::bytes")]
    points_b: Py<PyArray2<f64>>,
    /// (N, 3) float64, unit vectors: moved along it, the body of the lower index parts from the other.
    #[serde(with = "crate::arrays::bytes")]
    normals: Py<PyArray2<f64>>,
    /// (N,) float64, lengths: how far apart the triangles are, without margins; 0 only if they meet.
    #[serde(with = "crate::arrays::bytes")]
    distances: Py<PyArray1<f64>>,
    /// Every contact that no point stands for is at least so far away; infinite if there is none, 0 if nothing is known.
    low: f64,
    /// Frames since this was found. 0: it holds for the bodies where they were in the last frame.
    age: u64,
}

impl ContactPoints {
    pub fn new(py: Python<'_>, found: &punctual_scene::ContactPoints<'_>) -> PyResult<Self> {
        let points = found.points;
        let of = |read: fn(&ContactPoint) -> [f64; 3]| {
            PyResult::Ok(table(py, points.iter().map(read))?.unbind())
        };
        Ok(Self {
            patches: column(py, points.iter().map(|point| point.patch).collect()).unbind(),
            triangles: table(py, points.iter().map(|point| point.triangles))?.unbind(),
            points_a: of(|point| point.points[0].to_array())?,
            points_b: of(|point| point.points[1].to_array())?,
            normals: of(|point| point.normal.to_array())?,
            distances: column(py, points.iter().map(|point| point.distance).collect()).unbind(),
            low: found.low,
            age: found.age,
        })
    }
}

#[pymethods]
impl ContactPoints {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.distances.bind(py).as_any().len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Self { low, age, .. } = self;
        Ok(format!(
            "<punctual3d.ContactPoints: {} points, others from {low} on, age {age}>",
            self.__len__(py)?
        ))
    }
}
