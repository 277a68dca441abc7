//! Which way, and how far, two meshes have to be moved apart.

use crate::answer::Answer;
use crate::arrays::{Transform, column, table};
use crate::limit::Limit;
use crate::query::with_workspace;
use crate::tree::Surface;
use numpy::{PyArray1, PyArray2};
use punctual::Clock;
use punctual_depenetrate::PushOutQuery;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// The shortest translation of B found that parts the surfaces. There may be a shorter one.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct PushOut(punctual_depenetrate::PushOut);

#[pymethods]
impl PushOut {
    /// (3,): where B moves to, a unit vector in A's frame; the x axis if the surfaces do not meet anyway. None: the budget
    /// ended before a push was found.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0
            .push
            .map(|push| column(py, push.direction.to_array().to_vec()))
    }

    /// How far; 0 if the surfaces do not meet anyway. None: no push was found.
    #[getter]
    fn distance(&self) -> Option<f64> {
        self.0.push.map(|push| push.distance)
    }

    /// (4, 4): the pose after the push, at which the surfaces are apart: proven. None: no push was found.
    #[getter]
    #[expect(non_snake_case, reason = "the name in Python")]
    fn T<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let matrix = |push: punctual_depenetrate::Push| {
            let m = push.b_in_a.to_row_major();
            table(
                py,
                [0, 1, 2]
                    .map(|row| [0, 1, 2, 3].map(|at| m[4 * row + at]))
                    .into_iter()
                    .chain([LAST]),
            )
        };
        self.0.push.map(matrix).transpose()
    }

    /// Exact queries that were run.
    #[getter]
    fn queries(&self) -> u32 {
        self.0.queries
    }

    fn __repr__(&self) -> String {
        let found = self.0.push.map_or("none found".to_owned(), |push| {
            let [x, y, z] = push.direction.to_array();
            format!("{} along ({x}, {y}, {z})", push.distance)
        });
        format!("<punctual3d.PushOut: {found}, {}>", self.0.stop)
    }
}

/// The last row of a matrix that is a pose.
const LAST: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// The shortest translation of b that can be found after which the surfaces do not meet, which is proven for the pose that it
/// leads to. More work never gives a longer one.
///
/// T: (4, 4) matrix that brings coordinates of b into those of a; the identity by default. query_limit: stop after so many
/// exact queries. budget: seconds; work: units of work.
///
/// Raises ValueError for a T that is not rigid, and TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, query_limit=None, budget=None, work=None))]
#[expect(non_snake_case, reason = "the name of the argument in Python")]
pub fn push_out<'py>(
    py: Python<'py>,
    a: Surface<'_>,
    b: Surface<'_>,
    T: Option<Transform>,
    query_limit: Option<u32>,
    budget: Option<f64>,
    work: Option<u64>,
) -> PyResult<Bound<'py, PushOut>> {
    let limit = Limit::new(budget, work)?;
    let (a, b) = (&*a.arc, &*b.arc);
    let query = PushOutQuery::new(a, b, T.unwrap_or_default().0)
        .query_limit(query_limit.unwrap_or(u32::MAX));
    let run = |clock: &dyn Clock| {
        with_workspace(|workspace| query.run(workspace, limit.budget().clock(clock)))
    };
    let found = limit.run(py, run)?;
    Bound::new(
        py,
        (
            PushOut(found),
            Answer {
                stop: found.stop,
                work: found.work,
                elapsed: found.elapsed,
            },
        ),
    )
}
