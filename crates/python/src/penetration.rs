//! How deep two meshes penetrate each other.

use crate::answer::Answer;
use crate::arrays::{Transform, column, matrix};
use crate::errors::{finite, not_negative, not_solid};
use crate::limit::Limit;
use crate::tree::Surface;
use numpy::{PyArray1, PyArray2};
use punctual::Clock;
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// How far B has to be moved, at least, until the bodies are apart: `low <= depth <= high`, both proven.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Penetration(punctual_depenetrate::Penetration);

#[pymethods]
impl Penetration {
    /// No shorter translation parts them.
    #[getter]
    fn low(&self) -> f64 {
        self.0.low
    }

    /// The length of a translation that parts them; 0 if they are apart, inf if none was found yet.
    #[getter]
    fn high(&self) -> f64 {
        self.0.high
    }

    /// (3,): where B moves to by `high`, a unit vector in A's frame. None: they are apart, or none was found yet.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0
            .direction
            .map(|direction| column(py, direction.to_array().to_vec()))
    }

    /// (4, 4): the pose after the push, at which they are apart: proven. None: they are apart, or none was found yet.
    #[getter]
    #[expect(non_snake_case, reason = "the name in Python")]
    fn T<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let matrix = |_| matrix(py, &self.0.b_in_a);
        self.0.direction.map(matrix).transpose()
    }

    /// Whether they penetrate each other deeper than `deeper_than`, proven; None if that is undecided, or was not asked.
    #[getter]
    fn deeper(&self) -> Option<bool> {
        self.0.deeper
    }

    fn __repr__(&self) -> String {
        let punctual_depenetrate::Penetration { low, high, .. } = self.0;
        format!("<punctual3d.Penetration: {low} to {high}>")
    }
}

/// How deep a and b penetrate each other: the length of the shortest translation of b after which they are apart, bounded
/// from both sides whenever the search stops.
///
/// T: (4, 4) matrix that brings coordinates of b into those of a; the identity by default. solid: take the closed components
/// of trees that were built with `solid="flip"` as solids, so that one inside of the other penetrates it. Raises
/// ValueError if neither was.
/// push_only: look only for a short translation, so that low stays 0; finished when 32 directions all around were tried and the
/// best one turned. relative_tolerance: stop as soon as high <= (1 + relative_tolerance) low; 0.001 by default.
/// absolute_tolerance: stop as soon as high <= low + absolute_tolerance, too. deeper_than: ask only whether they penetrate each
/// other deeper than this length, whatever the tolerances; `deeper` has the answer. budget: seconds; work: units of work.
///
/// Raises ValueError for a T that is not rigid, and TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, solid=false, push_only=false, relative_tolerance=None,
    absolute_tolerance=None, deeper_than=None, budget=None, work=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names of the arguments in Python"
)]
pub fn penetration<'py>(
    py: Python<'py>,
    a: Surface<'_>,
    b: Surface<'_>,
    T: Option<Transform>,
    solid: bool,
    push_only: bool,
    relative_tolerance: Option<f64>,
    absolute_tolerance: Option<f64>,
    deeper_than: Option<f64>,
    budget: Option<f64>,
    work: Option<u64>,
) -> PyResult<Bound<'py, Penetration>> {
    let limit = Limit::new(budget, work)?;
    let (a, b) = (&*a.arc, &*b.arc);
    if solid && a.solid().is_none() && b.solid().is_none() {
        return Err(not_solid());
    }
    let query = PenetrationQuery::new(a, b, T.unwrap_or_default().0).solid(solid);
    let query = query.push_only(push_only);
    finite([
        ("relative_tolerance", relative_tolerance),
        ("absolute_tolerance", absolute_tolerance),
    ])?;
    not_negative([("deeper_than", deeper_than)])?;
    let mut query = query.absolute_tolerance(absolute_tolerance.unwrap_or(0.0));
    if let Some(share) = relative_tolerance {
        query = query.relative_tolerance(share);
    }
    if let Some(length) = deeper_than {
        query = query.deeper_than(length);
    }
    let run = |clock: &dyn Clock| {
        with_workspace(|workspace| query.run(workspace, limit.budget().clock(clock)))
    };
    let found = limit.run(py, run)?;
    Bound::new(
        py,
        (
            Penetration(found.value),
            Answer {
                stop: found.stop,
                work: found.stats.work,
                elapsed: found.stats.elapsed,
                remaining: None,
            },
        ),
    )
}

/// Lends the buffers of a thread, which are used again and again.
pub fn with_workspace<R>(run: impl FnOnce(&mut PenetrationWorkspace) -> R) -> R {
    thread_local! {
        static WORKSPACE: RefCell<Option<Box<PenetrationWorkspace>>> = const { RefCell::new(None) };
    }
    WORKSPACE.with(|workspace| match workspace.try_borrow_mut() {
        Ok(mut workspace) => run(workspace.get_or_insert_with(Box::default)),
        // The handler of a signal asks while the query that it interrupted has them.
        Err(_) => run(&mut Box::default()),
    })
}
