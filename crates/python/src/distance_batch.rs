//! How far apart two meshes are at each of many poses.

use crate::arrays::{Transforms, column, points, table};
use crate::batch::{Worker, each, workers};
use crate::distance::DistanceOptions;
use crate::limit::Limit;
use crate::memory::{Memory, lent};
use crate::tree::Surface;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use punctual::distance::{Bounds, Nearest};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// What a batch says: a row for each pose, low <= distance <= high.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct DistanceBatch {
    /// (N,) float64, proven.
    #[serde(with = "crate::arrays::bytes")]
    low: Py<PyArray1<f64>>,
    /// (N,) float64, proven: the distance of the two points; infinite where nothing was found yet.
    #[serde(with = "crate::arrays::bytes")]
    high: Py<PyArray1<f64>>,
    /// (N,) int8: 1 no farther apart than closer_than, 0 farther, both proven; -1 undecided, or not asked.
    #[serde(with = "crate::arrays::bytes")]
    closer: Py<PyArray1<i8>>,
    /// (N, 2) uint32: the closest triangles found, of a and of b; zeros where high is infinite.
    #[serde(with = "crate::arrays::bytes")]
    triangles: Py<PyArray2<u32>>,
    /// (N, 2, 3) float64: their closest points, both in a's frame, one point twice where the triangles meet; NaN where
    /// high is
    /// infinite.
    #[serde(with = "crate::arrays::bytes")]
    points: Py<PyArray3<f64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

/// The least lower bound and the greatest upper one.
pub fn span(low: &[f64], high: &[f64]) -> [f64; 2] {
    let least = low.iter().copied().reduce(f64::min);
    let most = high.iter().copied().reduce(f64::max);
    [least, most].map(|bound| bound.unwrap_or(f64::NAN))
}

/// The answer for one pose, as small as it can be: there may be millions.
#[derive(Clone, Default)]
struct Row {
    low: f64,
    high: f64,
    nearest: Option<Nearest>,
    closer: Option<bool>,
    work: u64,
}

impl DistanceBatch {
    fn new(py: Python<'_>, rows: &[Row]) -> PyResult<Self> {
        let numbers =
            |number: fn(&Row) -> f64| column(py, rows.iter().map(number).collect()).unbind();
        let triangles = |row: &Row| row.nearest.map_or([0; 2], |nearest| nearest.triangles);
        let nearest = |row: &Row| {
            row.nearest.map_or([[f64::NAN; 3]; 2], |nearest| {
                nearest.points.map(|point| point.to_array())
            })
        };
        Ok(Self {
            low: numbers(|row| row.low),
            high: numbers(|row| row.high),
            closer: column(
                py,
                rows.iter()
                    .map(|row| row.closer.map_or(-1, i8::from))
                    .collect(),
            )
            .unbind(),
            triangles: table(py, rows.iter().map(triangles))?.unbind(),
            points: points(py, rows.iter().map(nearest))?.unbind(),
            work: column(py, rows.iter().map(|row| row.work).collect()).unbind(),
        })
    }
}

#[pymethods]
impl DistanceBatch {
    /// Number of poses.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.low.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let [least, most] = span(&self.low.bind(py).to_vec()?, &self.high.bind(py).to_vec()?);
        Ok(format!(
            "<punctual3d.DistanceBatch: {} poses, {least} to {most}>",
            self.__len__(py)?
        ))
    }
}

/// `distance` at each of many poses, or `closer_than` if that is given, in one call and without the interpreter's lock.
///
/// poses: (N, 4, 4) matrices, or one, that bring coordinates of b into those of a. budget and work are those of each
/// pose.
/// threads: how many share the poses; answers under a budget of work, or none, are the same on any number of them.
/// memory: taken along the poses in their order, for poses that follow each other; it needs threads=1. progress:
/// a callable, told every 50 ms and at the end how many poses are done, and of how many. The other
/// arguments are those of `distance`.
///
/// Raises ValueError for a matrix that is not rigid, with its row.
#[pyfunction]
#[pyo3(signature = (a, b, poses, *, absolute_tolerance=None, relative_tolerance=None, margins=None, closer_than=None,
    leave_contact_open=false, budget=None, work=None, memory=None, threads=1, progress=None))]
#[expect(
    clippy::too_many_arguments,
    reason = "the arguments of the Python function"
)]
pub fn distance_batch(
    py: Python<'_>,
    a: Surface<'_>,
    b: Surface<'_>,
    poses: Transforms,
    absolute_tolerance: Option<f64>,
    relative_tolerance: Option<f64>,
    margins: Option<&Bound<'_, PyAny>>,
    closer_than: Option<f64>,
    leave_contact_open: bool,
    budget: Option<f64>,
    work: Option<u64>,
    mut memory: Option<PyRefMut<'_, Memory>>,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<DistanceBatch> {
    let limit = Limit::new(budget, work)?;
    let tolerances = [absolute_tolerance, relative_tolerance];
    let options = DistanceOptions::new(tolerances, margins, closer_than, leave_contact_open)?;
    let Transforms(poses) = poses;
    let (a, b) = (&*a.arc, &*b.arc);
    let workers = workers(threads, poses.len(), lent(&mut memory))?;
    let rows = each(py, poses.len(), progress, workers, |worker, clock, at| {
        let query = options.query(a, b, poses[at]);
        let Worker { workspace, memory } = worker;
        let answer = query
            .with_memory(memory.as_deref_mut())
            .run(workspace, limit.budget().clock(clock));
        let Bounds {
            low,
            high,
            nearest,
            closer,
            ..
        } = answer.value;
        Ok(Row {
            low,
            high,
            nearest,
            closer,
            work: answer.stats.work,
        })
    })?;
    DistanceBatch::new(py, &rows)
}
