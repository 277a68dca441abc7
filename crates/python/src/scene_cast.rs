//! What a ray hits in a scene.

use crate::answer::Answer;
use crate::arrays::column;
use crate::rays::side;
use numpy::PyArray1;
use punctual_scene::{BodyHit, SceneCast};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// What a ray hits in a scene: a row for each hit, the nearest first; at most one of the modes "nearest" and "any".
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct BodyHits {
    cast: SceneCast,
    hits: Vec<BodyHit>,
}

impl BodyHits {
    /// The hits of a cast, of which `all` are those of mode "all".
    pub fn new<'py>(
        py: Python<'py>,
        cast: SceneCast,
        all: &[BodyHit],
    ) -> PyResult<Bound<'py, Self>> {
        let mut hits = if all.is_empty() {
            Vec::from_iter(cast.hit)
        } else {
            all.to_vec()
        };
        let place = |hit: &BodyHit| (hit.body.index(), hit.on_body.triangle);
        hits.sort_by(|x, y| {
            x.on_body
                .t
                .total_cmp(&y.on_body.t)
                .then(place(x).cmp(&place(y)))
        });
        let base = Answer {
            stop: cast.stop,
            work: cast.work,
            elapsed: cast.elapsed,
            remaining: None,
        };
        Bound::new(py, (Self { cast, hits }, base))
    }
}

#[pymethods]
impl BodyHits {
    /// (N,) uint64: the body that is hit.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        column(py, self.hits.iter().map(|hit| hit.body.to_bits()).collect())
    }

    /// (N,) int64: the triangle that is hit, an index into the faces of the body's mesh.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        column(
            py,
            self.hits
                .iter()
                .map(|hit| hit.on_body.triangle.into())
                .collect(),
        )
    }

    /// (N,) float64: the hit is at `origin + t * direction`, or at `origin + t * (end - origin)`.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.hits.iter().map(|hit| hit.on_body.t).collect())
    }

    /// (N,) int8: 1 if the ray comes from the side from which the corners appear counterclockwise, -1 from the other;
    /// 0 if it lies in the plane of the triangle.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i8>> {
        column(
            py,
            self.hits.iter().map(|hit| side(hit.on_body.side)).collect(),
        )
    }

    /// How many triangles were found to be hit; of mode "all", the rows.
    #[getter]
    fn found(&self) -> u64 {
        self.cast.found
    }

    /// Proven: no hit that was not found lies before this t. Of a nearest hit that is known, its own; infinite if
    /// nothing is left to be found.
    #[getter]
    fn free_until(&self) -> f64 {
        self.cast.free_until
    }

    fn __len__(&self) -> usize {
        self.hits.len()
    }

    fn __repr__(&self) -> String {
        let SceneCast {
            free_until, stop, ..
        } = self.cast;
        format!(
            "<punctual3d.BodyHits: {} hits, free until {free_until}, {stop}>",
            self.hits.len()
        )
    }
}
