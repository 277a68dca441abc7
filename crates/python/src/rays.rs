//! What rays hit.

use crate::arrays::{column, vectors};
use crate::errors::value_error;
use crate::limit::Limit;
use crate::query::WORKSPACE;
use crate::tree::Tree;
use numpy::PyArray1;
use punctual::{Ray, RayBatch, RayBatchOutcome, RayHit, RayMode, Side};
use pyo3::prelude::*;

/// What rays hit: a row for each in all arrays.
///
/// The first `done` rows are answers. If the budget ended first, rows follow that say nothing: there `t` is NaN.
#[pyclass(module = "punctual", frozen)]
pub struct RayHits {
    hits: Vec<Option<RayHit>>,
    answer: RayBatchOutcome,
}

#[pymethods]
impl RayHits {
    /// (N,) int64: the triangle that is hit, an index into the faces of the mesh; -1 for none.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        column(py, self.hits.iter().map(|hit| hit.map_or(-1, |hit| hit.triangle.into())).collect())
    }

    /// (N,) float64: the hit is at `origin + t * direction`, or at `origin + t * (end - origin)`; infinite for none.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let done = self.answer.done;
        let none = |row| if row < done { f64::INFINITY } else { f64::NAN };
        column(py, self.hits.iter().enumerate().map(|(row, hit)| hit.map_or(none(row), |hit| hit.t)).collect())
    }

    /// (N,) int8: 1 if the ray comes from the side from which the corners appear counterclockwise, -1 from the other;
    /// 0 if it lies in the plane of the triangle, or hits none.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i8>> {
        let side = |hit: &Option<RayHit>| match hit.map(|hit| hit.side) {
            Some(Side::Front) => 1,
            Some(Side::Back) => -1,
            Some(Side::Edge) | None => 0,
        };
        column(py, self.hits.iter().map(side).collect())
    }

    /// The first so many rays are answered; all of them if `stop` is "finished".
    #[getter]
    fn done(&self) -> usize {
        self.answer.done
    }

    /// Why the query returned: "finished", "deadline", "work-limit" or "flushed-to-zero".
    #[getter]
    fn stop(&self) -> String {
        self.answer.stop.to_string()
    }

    /// Units of work done; the same for the same input on every machine.
    #[getter]
    fn work(&self) -> u64 {
        self.answer.stats.work
    }

    /// Seconds; None without a budget of time.
    #[getter]
    fn elapsed(&self) -> Option<f64> {
        self.answer.stats.elapsed.map(|elapsed| elapsed.as_secs_f64())
    }

    fn __len__(&self) -> usize {
        self.hits.len()
    }

    fn __repr__(&self) -> String {
        let count = self.hits.iter().flatten().count();
        format!("<punctual.RayHits: {count} of {}, {} done, {}>", self.hits.len(), self.answer.done, self.answer.stop)
    }
}

/// The rays of two arrays, checked: each origin with its direction, or with its end.
fn checked(
    origins: &Bound<'_, PyAny>,
    [directions, ends]: [Option<&Bound<'_, PyAny>>; 2],
    [t_min, t_max]: [f64; 2],
) -> PyResult<Vec<Ray>> {
    let (what, targets) = match (directions, ends) {
        (Some(directions), None) => ("directions", directions),
        (None, Some(ends)) => ("ends", ends),
        _ => return Err(value_error("directions and ends: one of them is needed, not both")),
    };
    for (limit, number) in [("t_min", t_min), ("t_max", t_max)] {
        if number.is_nan() {
            return Err(value_error(format_args!("{limit} is NaN, expected a number")));
        }
    }
    let (origins, targets) = (vectors(origins, "origins")?, vectors(targets, what)?);
    if origins.len() != targets.len() {
        let (origins, targets) = (origins.len(), targets.len());
        return Err(value_error(format_args!("{what}: {targets} rows, but origins has {origins}")));
    }
    let rays = origins.into_iter().zip(targets).enumerate().map(|(row, (origin, target))| {
        let ray = if ends.is_some() { Ray::segment(origin, target) } else { Ray::new(origin, target) };
        let ray = ray.map_err(|error| value_error(format_args!("ray {row}: {error}")))?;
        Ok(ray.within(t_min, t_max))
    });
    rays.collect()
}

/// What each of many rays hits, in one call and, without a budget of time, without the interpreter's lock.
///
/// origins: (N, 3), in the frame of the tree's mesh. directions: (N, 3), of any length; t counts in that length. Or ends:
/// (N, 3), for segments, of which t goes from 0 to 1. mode: "nearest" hit, or "any". t_min, t_max: hits outside are
/// left out. budget: seconds; work: units of work; of all rays together.
///
/// Whether a triangle is hit is exact: no ray slips through between two triangles that share an edge.
///
/// Raises ValueError for arrays of other shapes and numbers that are no ray, with the row, and TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (tree, origins, directions=None, *, ends=None, mode="nearest", t_min=0.0, t_max=f64::INFINITY,
    budget=None, work=None))]
#[expect(clippy::too_many_arguments, reason = "the arguments of the Python function")]
pub fn rays(
    py: Python<'_>,
    tree: PyRef<'_, Tree>,
    origins: &Bound<'_, PyAny>,
    directions: Option<&Bound<'_, PyAny>>,
    ends: Option<&Bound<'_, PyAny>>,
    mode: &str,
    t_min: f64,
    t_max: f64,
    budget: Option<f64>,
    work: Option<u64>,
) -> PyResult<RayHits> {
    let is_any = match mode.parse() {
        Ok(RayMode::Nearest) => false,
        Ok(RayMode::Any) => true,
        _ => return Err(value_error(format_args!("mode is {mode:?}, expected \"nearest\" or \"any\""))),
    };
    let limit = Limit::new(budget, work)?;
    let rays = checked(origins, [directions, ends], [t_min, t_max])?;
    let tree = &*tree.0;
    Ok(limit.unlocked(py, || {
        let batch = RayBatch::new(tree, &rays);
        let batch = if is_any { batch.any() } else { batch };
        let mut hits = vec![None; rays.len()];
        let answer = WORKSPACE.with_borrow_mut(|workspace| batch.run(workspace, &mut hits, limit.budget()));
        RayHits { hits, answer }
    }))
}
