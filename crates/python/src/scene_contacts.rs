//! Where bodies of a scene touch.

use crate::arrays::{column, table};
use numpy::{PyArray1, PyArray2};
use punctual::Pose;
use punctual_scene::{BodyId, PlacedContact};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// Where two bodies touch: a row for each of the few points that stand for their contacts, those of the deepest manifold
/// first. Points and normals are where the bodies are now, in the coordinates of the scene.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct ContactPoints {
    /// (N,) uint64: the manifold that each belongs to; the same from frame to frame while it keeps a point.
    #[serde(with = "crate::arrays::bytes")]
    manifolds: Py<PyArray1<u64>>,
    /// (N,) uint64: the same from frame to frame while the point stays near its place on one of the bodies.
    #[serde(with = "crate::arrays::bytes")]
    ids: Py<PyArray1<u64>>,
    /// (N, 3) float64: the point on the body of the lower index.
    #[serde(with = "crate::arrays::bytes")]
    points_a: Py<PyArray2<f64>>,
    /// (N, 3) float64: the point on the other body.
    #[serde(with = "crate::arrays::bytes")]
    points_b: Py<PyArray2<f64>>,
    /// (N, 3) float64, unit vectors: moved along it, the body of the lower index parts from the other.
    #[serde(with = "crate::arrays::bytes")]
    normals: Py<PyArray2<f64>>,
    /// (N,) float64, lengths: signed distances along the normals, without margins; negative where the bodies are sunk into
    /// each other.
    #[serde(with = "crate::arrays::bytes")]
    distances: Py<PyArray1<f64>>,
    /// The surfaces were at least so far apart wherever no point stands for a contact when the points were found, margins
    /// not subtracted (`Scene.set_look_ahead`); 0 if one body is within the other, or nothing is known.
    low: f64,
    /// The solid that was inside the other, or had a vertex in it, while their surfaces did not meet, by its name; None
    /// if none was. No point stands for that.
    within: Option<u64>,
    /// How far the surfaces have moved relative to each other since then, at most; infinite if nothing is known.
    drift: f64,
    /// Frames since this was found.
    age: u64,
}

impl ContactPoints {
    pub fn new(
        py: Python<'_>,
        found: &punctual_scene::Contacts<'_>,
        poses: [&Pose; 2],
    ) -> PyResult<Self> {
        let points = found.points;
        let now: Vec<PlacedContact> = points.iter().map(|point| point.at(poses)).collect();
        let of = |read: fn(&PlacedContact) -> [f64; 3]| {
            PyResult::Ok(table(py, now.iter().map(read))?.unbind())
        };
        Ok(Self {
            manifolds: column(py, points.iter().map(|point| point.manifold).collect()).unbind(),
            ids: column(py, points.iter().map(|point| point.id).collect()).unbind(),
            points_a: of(|point| point.points[0].to_array())?,
            points_b: of(|point| point.points[1].to_array())?,
            normals: of(|point| point.normal.to_array())?,
            distances: column(py, now.iter().map(|point| point.distance).collect()).unbind(),
            low: found.low,
            within: found.within.map(BodyId::to_bits),
            drift: found.drift,
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
        let Self { low, drift, .. } = self;
        Ok(format!(
            "<punctual3d.ContactPoints: {} points, others at least {low} apart, drift {drift}>",
            self.__len__(py)?
        ))
    }
}
