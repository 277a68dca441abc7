//! Whether, and where, two meshes meet at each of many poses.

use crate::arrays::{Transforms, column, table};
use crate::batch::{each, workers};
use crate::errors::resume_error;
use crate::limit::Limit;
use crate::memory::{Memory, lent};
use crate::query::{ModeName, QueryOptions, certainty, code, is_stopped, spend};
use crate::tree::Surface;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use punctual::Verdict;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// What a batch says: a row for each pose.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct CollisionBatch {
    /// (N,) int8: 1 the surfaces meet, 3 one solid is inside the other, 0 neither, all proven; -1 the budget ended first.
    /// They meet where it is above 0.
    #[serde(with = "crate::arrays::bytes")]
    verdict: Py<PyArray1<i8>>,
    /// (N, 2) uint32: triangles of a and of b that meet; zeros where verdict is not 1.
    #[serde(with = "crate::arrays::bytes")]
    witness: Py<PyArray2<u32>>,
    /// (N,) uint64: intersecting pairs found.
    #[serde(with = "crate::arrays::bytes")]
    found: Py<PyArray1<u64>>,
    /// (M, 2) uint32: the intersecting pairs of all poses; those of pose i are pairs[offsets[i]:offsets[i + 1]].
    #[serde(with = "crate::arrays::bytes")]
    pairs: Py<PyArray2<u32>>,
    /// (N + 1,) int64.
    #[serde(with = "crate::arrays::bytes")]
    offsets: Py<PyArray1<i64>>,
    /// (N,) float64: probability that the surfaces meet, an estimate where verdict is -1.
    #[serde(with = "crate::arrays::bytes")]
    probability: Py<PyArray1<f64>>,
    /// (N,) float64: expected share of the intersecting pairs that was found.
    #[serde(with = "crate::arrays::bytes")]
    recall: Py<PyArray1<f64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

/// How many meet, within their margins too, are apart, and are undecided.
pub fn verdicts(codes: &[i8]) -> String {
    let count = |sign| codes.iter().filter(|&&code| code.signum() == sign).count();
    format!(
        "{} meet, {} apart, {} undecided",
        count(1),
        count(0),
        count(-1)
    )
}

/// The answer for one pose, as small as it can be: there may be millions.
#[derive(Clone)]
struct Row {
    verdict: Verdict,
    pairs: Vec<[u32; 2]>,
    work: u64,
    probability: f64,
    recall: f64,
}

impl Default for Row {
    fn default() -> Self {
        Self {
            verdict: Verdict::Undecided,
            pairs: Vec::new(),
            work: 0,
            probability: 0.0,
            recall: 0.0,
        }
    }
}

impl CollisionBatch {
    fn new(py: Python<'_>, rows: &[Row]) -> PyResult<Self> {
        let numbers =
            |number: fn(&Row) -> f64| column(py, rows.iter().map(number).collect()).unbind();
        let counts = |count: fn(&Row) -> u64| column(py, rows.iter().map(count).collect()).unbind();
        let mut offsets = vec![0];
        offsets.extend(rows.iter().scan(0, |sum, row| {
            *sum += row.pairs.len() as i64;
            Some(*sum)
        }));
        Ok(Self {
            verdict: column(py, rows.iter().map(|row| code(row.verdict)).collect()).unbind(),
            witness: table(
                py,
                rows.iter()
                    .map(|row| row.verdict.witness().unwrap_or_default()),
            )?
            .unbind(),
            found: counts(|row| row.pairs.len() as u64),
            pairs: table(py, rows.iter().flat_map(|row| row.pairs.iter().copied()))?.unbind(),
            offsets: column(py, offsets).unbind(),
            probability: numbers(|row| row.probability),
            recall: numbers(|row| row.recall),
            work: counts(|row| row.work),
        })
    }
}

#[pymethods]
impl CollisionBatch {
    /// Number of poses.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.verdict.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let verdicts = verdicts(&self.verdict.bind(py).to_vec()?);
        Ok(format!(
            "<punctual3d.CollisionBatch: {} poses, {verdicts}>",
            self.__len__(py)?
        ))
    }
}

/// `collide` at each of many poses, in one call and without the interpreter's lock.
///
/// poses: (N, 4, 4) matrices, or one, that bring coordinates of b into those of a. budget and work are those of each
/// pose.
/// threads: how many share the poses; answers under a budget of work, or none, are the same on any number of them.
/// memory: taken along the poses in their order, for poses that follow each other; it needs threads=1. progress:
/// a callable, told every 50 ms and at the end how many poses are done, and of how many. The other
/// arguments are those of `collide`.
///
/// Raises ValueError for a matrix that is not rigid, with its row.
#[pyfunction]
#[pyo3(signature = (a, b, poses, *, mode=None, budget=None, work=None, memory=None, prior=None,
    threads=1, progress=None))]
#[expect(
    clippy::too_many_arguments,
    reason = "the arguments of the Python function"
)]
pub fn collide_batch(
    py: Python<'_>,
    a: Surface<'_>,
    b: Surface<'_>,
    poses: Transforms,
    mode: Option<ModeName>,
    budget: Option<f64>,
    work: Option<u64>,
    mut memory: Option<PyRefMut<'_, Memory>>,
    prior: Option<f64>,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<CollisionBatch> {
    let limit = Limit::new(budget, work)?;
    let options = QueryOptions::new(mode, prior)?;
    let Transforms(poses) = poses;
    let (a, b) = (&*a.arc, &*b.arc);
    let workers = workers(threads, poses.len(), lent(&mut memory))?;
    let rows = each(py, poses.len(), progress, workers, |worker, clock, at| {
        let (query, mut pairs) = (options.query(a, b, poses[at]), Vec::new());
        let (workspace, memory) = (&mut worker.workspace, worker.memory.as_deref_mut());
        let outcome = spend(&query, workspace, memory, (limit, clock), &mut pairs, None)
            .map_err(resume_error)?;
        let (mut probability, mut recall) = (certainty(outcome.value), 1.0);
        if is_stopped(&outcome) {
            let estimate = query
                .estimate(&worker.workspace, worker.memory.as_deref())
                .map_err(resume_error)?;
            (probability, recall) = (estimate.probability, estimate.recall);
        }
        Ok(Row {
            verdict: outcome.value,
            pairs,
            work: outcome.stats.work,
            probability,
            recall,
        })
    })?;
    CollisionBatch::new(py, &rows)
}
