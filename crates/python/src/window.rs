//! Windows: the newest points of a sensor as a tree.

use crate::arrays::{column, vectors};
use crate::errors::value_error;
use crate::limit::Limit;
use crate::tree::Tree;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::sync::Arc;

/// The newest points of a sensor as the tree of a cloud: a frame is brought into it in slices of a budget, and the oldest
/// points expire.
///
/// capacity: the number of points that are kept. reach: about the length of the region that they span, such as twice the
/// range of the sensor, in their unit of length; if it is several times too large or small, queries take longer.
/// A frame takes a part of the time of a new tree, from some 100,000 points on; queries take 1.0 to 1.8 times as long as
/// with one. Raises ValueError, which names the argument.
#[pyclass(module = "punctual3d")]
pub struct PointWindow(punctual::tree::PointWindow);

#[pymethods]
impl PointWindow {
    #[new]
    fn build(capacity: usize, reach: f64) -> PyResult<Self> {
        let window = punctual::tree::PointWindow::new(capacity, reach);
        window.map(Self).map_err(value_error)
    }

    /// Takes the points of a frame, (N, 3), rounded to f32, in the frame of the tree. They are in the tree once `advance`
    /// returns True. Raises ValueError for the first point that is not finite; then none is taken.
    fn insert(&mut self, points: &Bound<'_, PyAny>) -> PyResult<()> {
        let points = vectors(points, "points")?;
        let points = points.iter().map(|point| point.map(|x| x as f32));
        let points: Vec<_> = points.collect();
        self.0.insert(&points).map_err(value_error)
    }

    /// Brings the points into the tree within a budget in seconds, or units of work; True if all are in it. Otherwise the
    /// tree is that of the frames before, and the next call goes on.
    #[pyo3(signature = (budget=None, *, work=None))]
    fn advance(
        &mut self,
        py: Python<'_>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<bool> {
        let limit = Limit::new(budget, work)?;
        limit.run(py, |clock| self.0.advance(limit.budget().clock(clock)))
    }

    /// The tree of the newest points. It does not change; the next frame makes another one, in the memory of the one before
    /// this, if nothing holds that any more.
    #[getter]
    fn tree(&self) -> Tree {
        Tree::from(Arc::clone(self.0.tree()))
    }

    /// How many points were inserted before each point of the tree, (N,): which frame, and which of its points it was.
    #[getter]
    fn numbers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let ids = 0..self.0.tree().mesh().len() as u32;
        column(py, ids.map(|id| self.0.number(id) as i64).collect())
    }
}
