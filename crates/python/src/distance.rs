//! How far apart two meshes are at a pose.

use crate::answer::{Answer, Asked};
use crate::arrays::{Transform, numbers_if, table};
use crate::errors::{finite, not_negative, resume_error, undecided};
use crate::estimate::{Certificate, DistanceEstimate, Quantiles};
use crate::limit::Limit;
use crate::memory::{Memory, lent};
use crate::query::with_workspace;
use crate::tree::Surface;
use crate::view::View;
use numpy::PyArray2;
use punctual::{Clock, Pose, Workspace};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// All that a distance query is asked, but the trees and the pose.
#[derive(Clone, Copy, Default)]
pub struct DistanceOptions {
    absolute: Option<f64>,
    relative: Option<f64>,
    margins: [f64; 2],
    limit: Option<f64>,
    leave_contact_open: bool,
}

impl DistanceOptions {
    pub fn new(
        [absolute, relative]: [Option<f64>; 2],
        margins: Option<&Bound<'_, PyAny>>,
        limit: Option<f64>,
        leave_contact_open: bool,
    ) -> PyResult<Self> {
        let margins = numbers_if(margins, "margins")?.unwrap_or_default();
        let numbers = [
            ("absolute_tolerance", absolute),
            ("relative_tolerance", relative),
            ("margins[0]", Some(margins[0])),
            ("margins[1]", Some(margins[1])),
        ];
        finite(numbers)?;
        not_negative([("closer_than", limit)])?;
        Ok(Self {
            absolute,
            relative,
            margins,
            limit,
            leave_contact_open,
        })
    }

    pub fn query<'t>(
        &self,
        a: &'t punctual::Tree,
        b: &'t punctual::Tree,
        pose: Pose,
    ) -> punctual::Query<'t, punctual::distance::Distance> {
        let query = punctual::Query::distance(a, b, pose).margins(self.margins);
        let mut query = query.leave_contact_open(self.leave_contact_open);
        if let Some(length) = self.absolute {
            query = query.absolute_tolerance(length);
        }
        if let Some(share) = self.relative {
            query = query.relative_tolerance(share);
        }
        if let Some(limit) = self.limit {
            query = query.closer_than(limit);
        }
        query
    }
}

/// What a distance query says, wherever it stopped: low <= distance <= high, both proven.
///
/// Its truth value is the answer to `closer_than`; it raises UndecidedError while that is not known, and TypeError if
/// it was not asked.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Distance {
    answer: punctual::Answer<punctual::distance::Bounds>,
    /// The length of `closer_than`.
    limit: Option<f64>,
    #[serde(skip)]
    asked: Option<Asked>,
    #[serde(skip)]
    options: DistanceOptions,
}

impl Distance {
    fn new(
        py: Python<'_>,
        (answer, base): (punctual::Answer<punctual::distance::Bounds>, Answer),
        asked: Asked,
        options: DistanceOptions,
    ) -> PyResult<Bound<'_, Self>> {
        Bound::new(
            py,
            (
                Self {
                    answer,
                    limit: options.limit,
                    asked: Some(asked),
                    options,
                },
                base,
            ),
        )
    }
}

#[pymethods]
impl Distance {
    /// Proven: the surfaces are nowhere closer. Infinite if one of the meshes is empty.
    #[getter]
    fn low(&self) -> f64 {
        self.answer.value.low
    }

    /// Proven: the distance of the two points, 0 only if the surfaces meet. Infinite if nothing was found yet.
    #[getter]
    fn high(&self) -> f64 {
        self.answer.value.high
    }

    /// The closest points found, (2, 3): that of A and that of B, both in A's frame, moved towards each other by the
    /// margins.
    /// If the triangles meet, both are one point of the segment in which they do. None if nothing was found yet.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let nearest = self.answer.value.nearest;
        nearest
            .map(|nearest| table(py, nearest.points.map(|point| point.to_array())))
            .transpose()
    }

    /// The closest triangles found, of A and of B; None if nothing was found yet.
    #[getter]
    fn triangles(&self) -> Option<(u32, u32)> {
        self.answer
            .value
            .nearest
            .map(|nearest| nearest.triangles.into())
    }

    /// Whether the surfaces are no farther apart than the limit, proven; None if that is undecided, or was not asked.
    #[getter]
    fn closer(&self) -> Option<bool> {
        self.answer.value.closer
    }

    /// A page that shows the closest points found, saved if a path is given. The query is run anew for it.
    ///
    /// Raises ValueError if a tree was refitted since, or the answer was pickled, and OSError if the file cannot be
    /// written.
    #[pyo3(signature = (path=None))]
    fn view(&self, py: Python<'_>, path: Option<PathBuf>) -> PyResult<View> {
        let Self {
            answer,
            asked,
            options,
            ..
        } = self;
        Asked::view(asked, py, path, |bodies, pose| {
            let [a, b] = bodies.trees();
            punctual_view::distance(bodies, options.query(a, b, *pose), pose, answer)
        })
    }

    fn __bool__(&self) -> PyResult<bool> {
        let Some(limit) = self.limit else {
            return Err(PyTypeError::new_err(
                "a distance has no truth value: compare its bounds low and high",
            ));
        };
        let what = format!("the surfaces are closer than {limit}");
        self.answer
            .value
            .closer
            .ok_or_else(|| undecided(&what, self.answer.stop))
    }

    fn __repr__(&self) -> String {
        let punctual::distance::Bounds { low, high, .. } = self.answer.value;
        let stop = self.answer.stop;
        format!("<punctual3d.Distance: {low} to {high}, {stop}>")
    }
}

fn ask<'py>(
    py: Python<'py>,
    [a, b]: [Surface<'py>; 2],
    pose: Pose,
    options: DistanceOptions,
    limit: Limit,
    mut memory: Option<PyRefMut<'_, Memory>>,
) -> PyResult<Bound<'py, Distance>> {
    let query = options.query(&a.arc, &b.arc, pose);
    let mut memory = lent(&mut memory);
    let run = |clock: &dyn Clock| {
        with_workspace(|workspace| {
            let with = query.with_memory(memory.as_deref_mut());
            let answer = with.run(workspace, limit.budget().clock(clock));
            (
                answer,
                Answer::of(&query, workspace, memory.as_deref(), &answer),
            )
        })
    };
    let answer = limit.run(py, run)?;
    Distance::new(py, answer, Asked::new(a, b, pose), options)
}

/// How far apart the surfaces of two trees are: 0 if they meet.
///
/// T: (4, 4) matrix that brings coordinates of b into those of a; the identity by default. Done as soon as `high - low`
/// is no more than absolute_tolerance (a millionth of the larger mesh by default, roughly), or `high <= (1 +
/// relative_tolerance) low`, and it is known whether they meet; with leave_contact_open also as soon as `high` is no more
/// than absolute_tolerance. margins: by how much the surfaces are thickened, that of a and that of b. budget: seconds;
/// work: units of work. memory: what it learned at the pose before.
///
/// Raises ValueError for a T that is not rigid and for negative numbers, and TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, absolute_tolerance=None, relative_tolerance=None, margins=None,
    leave_contact_open=false, budget=None, work=None, memory=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names and arguments of the Python function"
)]
pub fn distance<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    T: Option<Transform>,
    absolute_tolerance: Option<f64>,
    relative_tolerance: Option<f64>,
    margins: Option<&Bound<'py, PyAny>>,
    leave_contact_open: bool,
    budget: Option<f64>,
    work: Option<u64>,
    memory: Option<PyRefMut<'_, Memory>>,
) -> PyResult<Bound<'py, Distance>> {
    let options = DistanceOptions::new(
        [absolute_tolerance, relative_tolerance],
        margins,
        None,
        leave_contact_open,
    )?;
    ask(
        py,
        [a, b],
        T.unwrap_or_default().0,
        options,
        Limit::new(budget, work)?,
        memory,
    )
}

/// Whether the surfaces of two trees are no farther apart than a length: the truth value of the result. Takes a
/// fraction of the time of `distance`, whose other arguments it has.
#[pyfunction]
#[pyo3(signature = (a, b, length, T=None, *, margins=None, budget=None, work=None, memory=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names and arguments of the Python function"
)]
pub fn closer_than<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    length: f64,
    T: Option<Transform>,
    margins: Option<&Bound<'py, PyAny>>,
    budget: Option<f64>,
    work: Option<u64>,
    memory: Option<PyRefMut<'_, Memory>>,
) -> PyResult<Bound<'py, Distance>> {
    not_negative([("length", Some(length))])?;
    let options = DistanceOptions::new([None; 2], margins, Some(length), false)?;
    ask(
        py,
        [a, b],
        T.unwrap_or_default().0,
        options,
        Limit::new(budget, work)?,
        memory,
    )
}

/// The same question as that of `distance`, or of `closer_than`, with buffers of its own (960 kB), so that it can be
/// predicted, resumed and asked for its certificate.
#[pyclass(module = "punctual3d")]
pub struct DistanceQuery {
    trees: [Arc<punctual::Tree>; 2],
    asked: Asked,
    options: DistanceOptions,
    workspace: Box<Workspace>,
}

impl DistanceQuery {
    fn query(&self) -> punctual::Query<'_, punctual::distance::Distance> {
        let [a, b] = &self.trees;
        self.options.query(a, b, self.asked.pose)
    }
}

#[pymethods]
impl DistanceQuery {
    #[new]
    #[pyo3(signature = (a, b, T=None, *, absolute_tolerance=None, relative_tolerance=None, margins=None,
        closer_than=None, leave_contact_open=false))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the name of the Python argument"
    )]
    fn new(
        a: Surface<'_>,
        b: Surface<'_>,
        T: Option<Transform>,
        absolute_tolerance: Option<f64>,
        relative_tolerance: Option<f64>,
        margins: Option<&Bound<'_, PyAny>>,
        closer_than: Option<f64>,
        leave_contact_open: bool,
    ) -> PyResult<Self> {
        let tolerances = [absolute_tolerance, relative_tolerance];
        let options = DistanceOptions::new(tolerances, margins, closer_than, leave_contact_open)?;
        let trees = [Arc::clone(&a.arc), Arc::clone(&b.arc)];
        let asked = Asked::new(a, b, T.unwrap_or_default().0);
        Ok(Self {
            trees,
            asked,
            options,
            workspace: Box::new(Workspace::new()),
        })
    }

    /// Runs from the start, within a budget of seconds or of units of work.
    #[pyo3(signature = (*, budget=None, work=None, memory=None))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        budget: Option<f64>,
        work: Option<u64>,
        mut memory: Option<PyRefMut<'_, Memory>>,
    ) -> PyResult<Bound<'py, Distance>> {
        let limit = Limit::new(budget, work)?;
        let Self {
            trees: [a, b],
            asked,
            options,
            workspace,
            ..
        } = self;
        let (query, mut memory) = (options.query(a, b, asked.pose), lent(&mut memory));
        let answer = limit.run(py, |clock| {
            let with = query.with_memory(memory.as_deref_mut());
            let answer = with.run(workspace, limit.budget().clock(clock));
            (
                answer,
                Answer::of(&query, workspace, memory.as_deref(), &answer),
            )
        })?;
        Distance::new(py, answer, asked.clone_ref(py), *options)
    }

    /// Goes on with the stopped run, with a fresh budget; its bounds are no worse than before. Raises ResumeError if
    /// there is no stopped run.
    #[pyo3(signature = (*, budget=None, work=None))]
    fn resume<'py>(
        &mut self,
        py: Python<'py>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, Distance>> {
        let limit = Limit::new(budget, work)?;
        let Self {
            trees: [a, b],
            asked,
            options,
            workspace,
            ..
        } = self;
        let query = options.query(a, b, asked.pose);
        let resume = |clock: &dyn Clock| {
            let answer = query.resume(workspace, limit.budget().clock(clock))?;
            Ok((answer, Answer::of(&query, workspace, None, &answer)))
        };
        let answer = limit.run(py, resume)?.map_err(resume_error)?;
        Distance::new(py, answer, asked.clone_ref(py), *options)
    }

    /// Units of work that it will take if nothing stops it.
    #[pyo3(signature = (*, memory=None))]
    fn predict(&self, memory: Option<PyRef<'_, Memory>>) -> Quantiles {
        self.query()
            .predict(memory.as_ref().map(|memory| &memory.0))
            .into()
    }

    /// What the last run left open, as far as can be guessed. Raises ResumeError before the first run.
    #[pyo3(signature = (*, memory=None))]
    fn estimate(&self, memory: Option<PyRef<'_, Memory>>) -> PyResult<DistanceEstimate> {
        let memory = memory.as_ref().map(|memory| &memory.0);
        Ok(self
            .query()
            .estimate(&self.workspace, memory)
            .map_err(resume_error)?
            .into())
    }

    /// Where the last run may have missed what is closer than its upper bound by more than the tolerance. Raises ResumeError
    /// before the first run.
    fn certificate(&self) -> PyResult<Certificate> {
        Ok(self
            .query()
            .certificate(&self.workspace)
            .map_err(resume_error)?
            .into())
    }

    fn __repr__(&self) -> String {
        let [a, b] = self.trees.each_ref().map(|tree| tree.mesh().len());
        format!("<punctual3d.DistanceQuery of {a} and {b} triangles>")
    }
}
