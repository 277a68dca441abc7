//! Until when a motion is free.

use crate::answer::{Answer, Asked};
use crate::arrays::{Transform, numbers_if};
use crate::errors::{finite, resume_error, value_error};
use crate::estimate::{Certificate, Quantiles};
use crate::limit::Limit;
use crate::memory::{Memory, lent};
use crate::query::with_workspace;
use crate::tree::Surface;
use crate::view::View;
use punctual::{Clock, Motion, Workspace};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// What a motion query says; times from 0 to 1.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Passage {
    answer: punctual::Answer<punctual::impact::TimeOfImpact>,
    #[serde(skip)]
    asked: Option<Asked>,
    #[serde(skip)]
    options: Option<Options>,
}

/// All that a query of a motion is asked, but the trees.
#[derive(Clone, Copy)]
struct Options {
    motion: Motion,
    margins: [f64; 2],
    tolerance: Option<f64>,
    time_tolerance: Option<f64>,
}

impl Options {
    fn new(
        motion: Motion,
        tolerances: [Option<f64>; 2],
        margins: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let margins = numbers_if(margins, "margins")?.unwrap_or_default();
        let ([tolerance, time_tolerance], [of_a, of_b]) = (tolerances, margins.map(Some));
        let lengths = [
            ("tolerance", tolerance),
            ("margins[0]", of_a),
            ("margins[1]", of_b),
        ];
        finite(
            lengths
                .into_iter()
                .chain([("time_tolerance", time_tolerance)]),
        )?;
        Ok(Self {
            motion,
            margins,
            tolerance,
            time_tolerance,
        })
    }

    fn query<'t>(
        &self,
        a: &'t punctual::Tree,
        b: &'t punctual::Tree,
    ) -> punctual::Query<'t, punctual::impact::Impact> {
        let mut query = punctual::Query::impact(a, b, self.motion).margins(self.margins);
        if let Some(length) = self.tolerance {
            query = query.tolerance(length);
        }
        if let Some(time) = self.time_tolerance {
            query = query.time_tolerance(time);
        }
        query
    }
}

impl Passage {
    fn new(
        py: Python<'_>,
        (answer, base): (punctual::Answer<punctual::impact::TimeOfImpact>, Answer),
        asked: Asked,
        options: Options,
    ) -> PyResult<Bound<'_, Self>> {
        Bound::new(
            py,
            (
                Self {
                    answer,
                    asked: Some(asked),
                    options: Some(options),
                },
                base,
            ),
        )
    }
}

#[pymethods]
impl Passage {
    /// Proven: the surfaces meet at no time before. 1 where `touching_at` is None: the motion is free to its end.
    #[getter]
    fn free_until(&self) -> f64 {
        self.answer.value.lower
    }

    /// Proven: the surfaces meet at this time; 0 if they do at the start. None: no contact was found (yet).
    #[getter]
    fn touching_at(&self) -> Option<f64> {
        self.answer.value.upper
    }

    /// The triangles that meet then, of A and of B; None if no contact was found.
    #[getter]
    fn triangles(&self) -> Option<(u32, u32)> {
        self.answer.value.triangles.map(Into::into)
    }

    /// A page that shows the way of b, and where it meets a; saved if a path is given. The query is run anew for it.
    ///
    /// Raises ValueError if a tree was refitted since, or the answer was pickled, and OSError if the file cannot be
    /// written.
    #[pyo3(signature = (path=None))]
    fn view(&self, py: Python<'_>, path: Option<PathBuf>) -> PyResult<View> {
        let Self {
            answer,
            asked,
            options,
        } = self;
        Asked::view(asked, py, path, |bodies, _| {
            let [a, b] = bodies.trees();
            let options = options.as_ref().ok_or(punctual::ResumeError)?;
            punctual_view::motion(bodies, options.query(a, b), answer)
        })
    }

    fn __repr__(&self) -> String {
        let punctual::impact::TimeOfImpact { lower, upper, .. } = self.answer.value;
        let touching = upper.map_or("no contact found".to_owned(), |time| {
            format!("touching at {time}")
        });
        let stop = self.answer.stop;
        format!("<punctual3d.Passage: free until {lower}, {touching}, {stop}>")
    }
}

/// How a body goes from T: to another pose, or with a velocity and a turn.
pub fn path(
    start: Transform,
    to: Option<Transform>,
    [velocity, turn, point]: [Option<&Bound<'_, PyAny>>; 3],
) -> PyResult<Motion> {
    let (velocity, turn) = (numbers_if(velocity, "velocity")?, numbers_if(turn, "turn")?);
    let point = numbers_if(point, "point")?;
    let motion = match (to, velocity, turn) {
        (Some(end), None, None) if point.is_none() => Motion::screw(start.0, end.0),
        (Some(_), ..) => return Err(value_error("to: not together with velocity, turn or point")),
        (None, None, None) => {
            return Err(value_error(
                "no motion: one of to, velocity and turn is needed",
            ));
        }
        (None, _, None) if point.is_some() => {
            return Err(value_error("point: only together with turn"));
        }
        (None, velocity, turn) => {
            let point = point.unwrap_or_else(|| start.0.translation().to_array());
            Motion::turning(
                start.0,
                velocity.unwrap_or_default(),
                turn.unwrap_or_default(),
                point,
            )
        }
    };
    motion.map_err(value_error)
}

/// Until when b can move without meeting a, and when they meet.
///
/// T: (4, 4) matrix that brings coordinates of b into those of a, at time 0. to: the same at time 1, with a screw from the
/// one to the other. Or velocity: (3,), the way until time 1; turn: (3,), axis times angle in radians; point: (3,), a
/// point of the axis at time 0, which moves with the velocity; the origin of b by default. tolerance: done as soon as
/// the surfaces are this close at the time that is found, about a millionth of the longest extent of the smaller mesh
/// by
/// default; time_tolerance: as soon as it is known this closely. margins: by how much the surfaces are thickened, that
/// of
/// a and that of b. budget: seconds; work: units of work. memory: what it learned from the motion before.
///
/// Raises ValueError for a T that is not rigid, numbers that are negative or not finite and for contradictions, and
/// TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, to=None, velocity=None, turn=None, point=None, tolerance=None,
    time_tolerance=None, margins=None, budget=None, work=None, memory=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names and arguments of the Python function"
)]
pub fn motion<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    T: Option<Transform>,
    to: Option<Transform>,
    velocity: Option<&Bound<'_, PyAny>>,
    turn: Option<&Bound<'_, PyAny>>,
    point: Option<&Bound<'_, PyAny>>,
    tolerance: Option<f64>,
    time_tolerance: Option<f64>,
    margins: Option<&Bound<'_, PyAny>>,
    budget: Option<f64>,
    work: Option<u64>,
    mut memory: Option<PyRefMut<'_, Memory>>,
) -> PyResult<Bound<'py, Passage>> {
    let start = T.unwrap_or_default();
    let options = Options::new(
        path(start, to, [velocity, turn, point])?,
        [tolerance, time_tolerance],
        margins,
    )?;
    let limit = Limit::new(budget, work)?;
    let query = options.query(&a.arc, &b.arc);
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
    Passage::new(py, answer, Asked::new(a, b, start.0), options)
}

/// The same question as that of `motion`, with buffers of its own (960 kB), so that it can be predicted, resumed and
/// asked for its certificate.
#[pyclass(module = "punctual3d")]
pub struct MotionQuery {
    trees: [Arc<punctual::Tree>; 2],
    asked: Asked,
    options: Options,
    workspace: Box<Workspace>,
}

impl MotionQuery {
    fn query(&self) -> punctual::Query<'_, punctual::impact::Impact> {
        let [a, b] = &self.trees;
        self.options.query(a, b)
    }
}

#[pymethods]
impl MotionQuery {
    #[new]
    #[pyo3(signature = (a, b, T=None, *, to=None, velocity=None, turn=None, point=None, tolerance=None,
        time_tolerance=None, margins=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the names and arguments of the Python function"
    )]
    fn new(
        a: Surface<'_>,
        b: Surface<'_>,
        T: Option<Transform>,
        to: Option<Transform>,
        velocity: Option<&Bound<'_, PyAny>>,
        turn: Option<&Bound<'_, PyAny>>,
        point: Option<&Bound<'_, PyAny>>,
        tolerance: Option<f64>,
        time_tolerance: Option<f64>,
        margins: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let start = T.unwrap_or_default();
        let options = Options::new(
            path(start, to, [velocity, turn, point])?,
            [tolerance, time_tolerance],
            margins,
        )?;
        let trees = [Arc::clone(&a.arc), Arc::clone(&b.arc)];
        Ok(Self {
            trees,
            asked: Asked::new(a, b, start.0),
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
    ) -> PyResult<Bound<'py, Passage>> {
        let limit = Limit::new(budget, work)?;
        let Self {
            trees: [a, b],
            asked,
            options,
            workspace,
        } = self;
        let (query, mut memory) = (options.query(a, b), lent(&mut memory));
        let answer = limit.run(py, |clock| {
            let with = query.with_memory(memory.as_deref_mut());
            let answer = with.run(workspace, limit.budget().clock(clock));
            (
                answer,
                Answer::of(&query, workspace, memory.as_deref(), &answer),
            )
        })?;
        Passage::new(py, answer, asked.clone_ref(py), *options)
    }

    /// Goes on with the stopped run, with a fresh budget; what it says is no worse than before. Raises ResumeError if
    /// there is no stopped run.
    #[pyo3(signature = (*, budget=None, work=None))]
    fn resume<'py>(
        &mut self,
        py: Python<'py>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, Passage>> {
        let limit = Limit::new(budget, work)?;
        let Self {
            trees: [a, b],
            asked,
            options,
            workspace,
        } = self;
        let query = options.query(a, b);
        let resume = |clock: &dyn Clock| {
            let answer = query.resume(workspace, limit.budget().clock(clock))?;
            Ok((answer, Answer::of(&query, workspace, None, &answer)))
        };
        let answer = limit.run(py, resume)?.map_err(resume_error)?;
        Passage::new(py, answer, asked.clone_ref(py), *options)
    }

    /// Units of work that it will take if nothing stops it.
    #[pyo3(signature = (*, memory=None))]
    fn predict(&self, memory: Option<PyRef<'_, Memory>>) -> Quantiles {
        self.query()
            .predict(memory.as_ref().map(|memory| &memory.0))
            .into()
    }

    /// Where the surfaces may still meet before the contact that the last run found, if any. Raises ResumeError before
    /// the first run.
    fn certificate(&self) -> PyResult<Certificate> {
        Ok(self
            .query()
            .certificate(&self.workspace)
            .map_err(resume_error)?
            .into())
    }

    fn __repr__(&self) -> String {
        let [a, b] = self.trees.each_ref().map(|tree| tree.mesh().len());
        format!("<punctual3d.MotionQuery of {a} and {b} triangles>")
    }
}
