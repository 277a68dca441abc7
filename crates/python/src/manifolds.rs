//! Contact manifolds: what a solver needs of two solids.

use crate::answer::Answer;
use crate::arrays::{Transform, column, points, table};
use crate::errors::not_negative;
use crate::limit::Limit;
use crate::memory::{Memory, lent};
use crate::query::with_workspace;
use crate::tree::Surface;
use numpy::{PyArray1, PyArray2, PyArray3};
use punctual::contacts::{Manifold, ManifoldPoint};
use punctual::{Clock, PairMemory, Query, StopReason, Workspace};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// The contact manifolds of two solids: a row for each of their points in all arrays, in A's frame. The deepest manifold comes
/// first, of its points, four at most, the deepest.
///
/// All of them if `stop` is "finished"; what is missing of a stopped query is at least `low` apart.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Manifolds {
    answer: punctual::Answer<punctual::contacts::ManifoldBounds>,
    found: Vec<Manifold>,
}

impl Manifolds {
    fn rows(&self) -> impl Iterator<Item = (&Manifold, &ManifoldPoint)> {
        self.found
            .iter()
            .flat_map(|manifold| manifold.points().iter().map(move |point| (manifold, point)))
    }
}

#[pymethods]
impl Manifolds {
    /// (N,) uint64: the points' ids, the same from frame to frame with a memory.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        column(py, self.rows().map(|(_, point)| point.id).collect())
    }

    /// (N,) uint64: the ids of their manifolds.
    #[getter]
    fn manifolds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        column(py, self.rows().map(|(manifold, _)| manifold.id).collect())
    }

    /// (N, 2, 3): the points on A and on B.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        points(
            py,
            self.rows()
                .map(|(_, point)| point.points.map(|place| place.to_array())),
        )
    }

    /// (N, 3): unit vectors from B to A; zeros in an overlap without a normal, as of a pin through a plate.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.rows().map(|(_, point)| point.normal.to_array()))
    }

    /// (N,): signed distances along the normals, negative where the solids are sunk into each other.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.rows().map(|(_, point)| point.distance).collect())
    }

    /// (N,): the areas of their manifolds, seen along the normal.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.rows().map(|(manifold, _)| manifold.area).collect())
    }

    /// (N,) bool: whether the surfaces meet in their manifolds.
    #[getter]
    fn is_overlap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        column(
            py,
            self.rows()
                .map(|(manifold, _)| manifold.is_overlap)
                .collect(),
        )
    }

    /// Proven: every contact that is missing is at least this far apart; 0 while overlaps may be missing, infinite if nothing is.
    #[getter]
    fn low(&self) -> f64 {
        self.answer.value.low
    }

    /// Number of manifolds.
    #[getter]
    fn count(&self) -> usize {
        self.found.len()
    }

    fn __len__(&self) -> usize {
        self.rows().count()
    }

    fn __repr__(&self) -> String {
        let (count, points) = (self.found.len(), self.__len__());
        format!(
            "<punctual3d.Manifolds: {count} of {points} points, {}>",
            self.answer.stop
        )
    }
}

/// Runs a query, with more room where there is not enough.
fn spend(
    query: &Query<'_, punctual::contacts::Manifolds>,
    workspace: &mut Workspace,
    (limit, clock): (Limit, &dyn Clock),
    mut memory: Option<&mut PairMemory>,
) -> (
    punctual::Answer<punctual::contacts::ManifoldBounds>,
    Answer,
    Vec<Manifold>,
) {
    let with = query.with_memory(memory.as_deref_mut());
    let mut answer = with.run(workspace, limit.budget().clock(clock));
    while answer.stop == StopReason::PairsFull && !clock.is_cancelled() {
        workspace.reserve_contacts(2 * answer.stats.found as usize);
        let left = limit.left(&punctual::Stats::default(), &answer.stats);
        let with = query.with_memory(memory.as_deref_mut());
        let Ok(next) = with.resume(workspace, left.budget().clock(clock)) else {
            break;
        };
        answer = next;
    }
    let base = Answer::of(query, workspace, memory.as_deref(), &answer);
    (answer, base, workspace.manifolds().to_vec())
}

/// The contact manifolds of two solids: at most four points for each piece of contact, with signed distances along a normal.
///
/// Triangles are counterclockwise seen from outside. T: (4, 4) matrix that brings coordinates of b into those of a; the
/// identity by default. skin: solids apart have points of contact up to this distance; 0 for overlaps alone. budget: seconds;
/// work: units of work. memory: keeps the ids from pose to pose.
///
/// Raises ValueError for a T that is not rigid and a skin that is not a number or negative, and TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, skin=0.0, budget=None, work=None, memory=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names and arguments of the Python function"
)]
pub fn manifolds<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    T: Option<Transform>,
    skin: f64,
    budget: Option<f64>,
    work: Option<u64>,
    mut memory: Option<PyRefMut<'_, Memory>>,
) -> PyResult<Bound<'py, Manifolds>> {
    not_negative([("skin", Some(skin))])?;
    let spent = Limit::new(budget, work)?;
    let query = Query::manifolds(&a.arc, &b.arc, T.unwrap_or_default().0).skin(skin);
    let memory = lent(&mut memory);
    let (answer, base, found) = spent.run(py, |clock| {
        with_workspace(|workspace| spend(&query, workspace, (spent, clock), memory))
    })?;
    Bound::new(py, (Manifolds { answer, found }, base))
}

/// The overlaps of two solids: `manifolds` without a skin.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, budget=None, work=None, memory=None))]
#[expect(non_snake_case, reason = "the name of the argument in Python")]
pub fn overlap<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    T: Option<Transform>,
    budget: Option<f64>,
    work: Option<u64>,
    memory: Option<PyRefMut<'_, Memory>>,
) -> PyResult<Bound<'py, Manifolds>> {
    manifolds(py, a, b, T, 0.0, budget, work, memory)
}
