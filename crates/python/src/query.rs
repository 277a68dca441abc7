//! Whether, and where, two meshes meet at a pose.

use crate::answer::{Answer, Asked};
use crate::arrays::{Transform, table};
use crate::errors::{resume_error, undecided, value_error};
use crate::estimate::{Certificate, Estimate, Prediction};
use crate::limit::Limit;
use crate::memory::{Memory, lent};
use crate::tree::Surface;
use crate::view::View;
use numpy::PyArray2;
use punctual::prediction::CostModel;
use punctual::{Clock, Mode, PairMemory, Pose, StopReason, Verdict, Workspace};
use pyo3::intern;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;

/// "any" or "all".
#[derive(Clone, Copy)]
pub struct ModeName(pub Mode);

impl<'py> FromPyObject<'_, 'py> for ModeName {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        // The same object, as literals are, is compared in no time; its text costs an allocation.
        if given.is(intern!(given.py(), "all")) {
            return Ok(Self(Mode::All));
        }
        let name: Cow<'_, str> = given.extract()?;
        name.parse()
            .map(Self)
            .map_err(|error| value_error(format_args!("mode: {error}")))
    }
}

/// All that a query is asked, but the trees and the pose.
#[derive(Clone, Copy, Default)]
pub struct QueryOptions {
    mode: Mode,
    prior: Option<f64>,
}

impl QueryOptions {
    pub fn new(mode: Option<ModeName>, prior: Option<f64>) -> PyResult<Self> {
        if let Some(share) = prior.filter(|share| !(0.0..=1.0).contains(share)) {
            return Err(value_error(format_args!(
                "prior is {share}, expected a share, 0 to 1"
            )));
        }
        let mode = mode.map_or(Mode::Any, |ModeName(mode)| mode);
        Ok(Self { mode, prior })
    }

    pub fn query<'t>(
        &self,
        a: &'t punctual::Tree,
        b: &'t punctual::Tree,
        pose: Pose,
    ) -> punctual::Query<'t, punctual::intersection::Intersection> {
        let query = punctual::Query::intersection(a, b, pose).mode(self.mode);
        match self.prior {
            Some(share) => query.prior(share),
            None => query,
        }
    }
}

/// Runs a query, or goes on with it. What it finds is added to `pairs`, more than the workspace has room for, too.
pub fn spend(
    query: &punctual::Query<'_, punctual::intersection::Intersection>,
    workspace: &mut Workspace,
    mut memory: Option<&mut PairMemory>,
    (limit, clock): (Limit, &dyn Clock),
    pairs: &mut Vec<[u32; 2]>,
    stopped: Option<punctual::Answer<Verdict>>,
) -> Result<punctual::Answer<Verdict>, punctual::ResumeError> {
    let before = stopped.map(|outcome| outcome.stats).unwrap_or_default();
    let mut outcome = match stopped {
        None => query
            .with_memory(memory.as_deref_mut())
            .run(workspace, limit.budget().clock(clock)),
        Some(_) => query
            .with_memory(memory.as_deref_mut())
            .resume(workspace, limit.budget().clock(clock))?,
    };
    pairs.extend(workspace.drain_pairs());
    while outcome.stop == StopReason::PairsFull && !clock.is_cancelled() {
        let left = limit.left(&before, &outcome.stats);
        outcome = query
            .with_memory(memory.as_deref_mut())
            .resume(workspace, left.budget().clock(clock))?;
        pairs.extend(workspace.drain_pairs());
    }
    Ok(outcome)
}

/// Whether there is more to find.
pub fn is_stopped(outcome: &punctual::Answer<Verdict>) -> bool {
    !matches!(outcome.stop, StopReason::Finished | StopReason::FirstHit)
}

/// What a query says. Its truth value tells whether the surfaces meet, and raises UndecidedError while that is not
/// known.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Collision {
    outcome: punctual::Answer<Verdict>,
    pairs: Vec<[u32; 2]>,
    /// Of a stopped query.
    estimate: Option<Estimate>,
    #[serde(skip)]
    asked: Option<Asked>,
    #[serde(skip)]
    options: QueryOptions,
}

impl Collision {
    fn new<'py>(
        py: Python<'py>,
        (outcome, estimate): (punctual::Answer<Verdict>, Option<Estimate>),
        pairs: Vec<[u32; 2]>,
        asked: Asked,
        options: QueryOptions,
    ) -> PyResult<Bound<'py, Self>> {
        let base = Answer {
            remaining: estimate.map(|estimate| estimate.remaining.into()),
            ..Answer::new(outcome.stop, &outcome.stats)
        };
        Bound::new(
            py,
            (
                Self {
                    outcome,
                    pairs,
                    estimate,
                    asked: Some(asked),
                    options,
                },
                base,
            ),
        )
    }
}

/// What can be said of the last run of a query in `workspace`, if it was stopped.
fn estimate(
    query: &punctual::Query<'_, punctual::intersection::Intersection>,
    workspace: &Workspace,
    memory: Option<&PairMemory>,
    outcome: &punctual::Answer<Verdict>,
) -> Result<Option<Estimate>, punctual::ResumeError> {
    let estimate = is_stopped(outcome)
        .then(|| query.estimate(workspace, memory))
        .transpose()?;
    Ok(estimate.map(|estimate| Estimate::new(&estimate, &workspace.cost_model())))
}

/// The verdict as a number for arrays.
pub fn code(verdict: Verdict) -> i8 {
    match verdict {
        Verdict::Contained { .. } => 3,
        Verdict::Within { .. } => 2,
        Verdict::Intersecting { .. } => 1,
        Verdict::Separated => 0,
        Verdict::Undecided => -1,
    }
}

/// The probability that surfaces meet for which the verdict is known.
pub fn certainty(verdict: Verdict) -> f64 {
    if verdict.meets() { 1.0 } else { 0.0 }
}

#[pymethods]
impl Collision {
    /// "intersecting", "contained" (one solid is inside the other) and "separated" are proven; "undecided": the budget
    /// ended first.
    #[getter]
    fn verdict(&self) -> &'static str {
        self.outcome.value.name()
    }

    /// Two triangles, of A and of B, that meet; None if none was found.
    #[getter]
    fn witness(&self) -> Option<(u32, u32)> {
        self.outcome.value.witness().map(Into::into)
    }

    /// The intersecting pairs found, (N, 2): triangle of A, triangle of B. All of them if mode is "all" and the query
    /// finished; at most one if mode is "any".
    #[getter]
    fn pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        table(py, self.pairs.iter().copied())
    }

    /// Number of intersecting pairs found.
    #[getter]
    fn found(&self) -> u64 {
        self.outcome.stats.found
    }

    /// Probability that the surfaces meet: 1 or 0 where that is proven, an estimate where it is undecided.
    #[getter]
    fn probability(&self) -> f64 {
        self.estimate
            .map_or(certainty(self.outcome.value), |estimate| {
                estimate.probability
            })
    }

    /// Expected share of the intersecting pairs that was found: 1 if the query finished, an estimate if it was stopped.
    #[getter]
    fn recall(&self) -> f64 {
        self.estimate.map_or(1.0, |estimate| estimate.recall)
    }

    /// Box overlap tests.
    #[getter]
    fn bv_tests(&self) -> u64 {
        self.outcome.stats.bv_tests
    }

    /// Triangle pairs tested.
    #[getter]
    fn primitive_tests(&self) -> u64 {
        self.outcome.stats.primitive_tests
    }

    /// A page that shows which triangles meet, and the boxes still open, after each of a ladder of budgets; saved if
    /// a path is given. The query is run anew for it.
    ///
    /// Raises ValueError if a tree was refitted since, or the answer was pickled, and OSError if the file cannot be
    /// written.
    #[pyo3(signature = (path=None))]
    fn view(&self, py: Python<'_>, path: Option<PathBuf>) -> PyResult<View> {
        let Self {
            outcome,
            asked,
            options,
            ..
        } = self;
        Asked::view(asked, py, path, |bodies, pose| {
            let [a, b] = bodies.trees();
            punctual_view::pair(
                bodies,
                options.query(a, b, *pose),
                pose,
                options.mode,
                outcome,
            )
        })
    }

    fn __bool__(&self) -> PyResult<bool> {
        match self.outcome.value {
            Verdict::Undecided => Err(undecided("the surfaces meet", self.outcome.stop)),
            verdict => Ok(verdict.meets()),
        }
    }

    fn __repr__(&self) -> String {
        let punctual::Answer {
            value: verdict,
            stop,
            stats,
            ..
        } = self.outcome;
        let (found, probability) = (stats.found, self.probability());
        format!(
            "<punctual3d.Collision: {verdict}, {found} found, {stop}, probability {probability:.3}>"
        )
    }
}

/// Lends the buffers of queries that are asked by a function: those of a thread are used again and again.
pub fn with_workspace<R>(run: impl FnOnce(&mut Workspace) -> R) -> R {
    thread_local! {
        static WORKSPACE: RefCell<Box<Workspace>> = RefCell::new(Box::new(Workspace::new()));
    }
    WORKSPACE.with(|workspace| match workspace.try_borrow_mut() {
        Ok(mut workspace) => run(&mut workspace),
        // The handler of a signal asks while the query that it interrupted has them.
        Err(_) => run(&mut Box::new(Workspace::new())),
    })
}

/// Whether, and where, the surfaces of two trees meet.
///
/// a, b: trees; as in all calls, a mesh with `vertices` and `faces`, such as a trimesh.Trimesh, is taken in place of
/// one, and a
/// tree is built from it for this call, which takes longer than most questions.
///
/// T: (4, 4) matrix that brings coordinates of b into those of a; the identity by default. mode: "any" stops at the
/// first intersection, "all" finds every intersecting pair of triangles. budget: seconds; work: units of work, for the
/// same answer on every machine; without either the query finishes. memory: what it learned at the pose before. prior:
/// share of poses with an intersection that is to be expected.
///
/// Raises ValueError for a T that is not rigid, and TypeError for wrong types. `Query` is the same, to be resumed.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, mode=None, budget=None, work=None, memory=None, prior=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names and arguments of the Python function"
)]
pub fn collide<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    T: Option<Transform>,
    mode: Option<ModeName>,
    budget: Option<f64>,
    work: Option<u64>,
    mut memory: Option<PyRefMut<'_, Memory>>,
    prior: Option<f64>,
) -> PyResult<Bound<'py, Collision>> {
    let (limit, pose) = (Limit::new(budget, work)?, T.unwrap_or_default().0);
    let options = QueryOptions::new(mode, prior)?;
    let query = options.query(&a.arc, &b.arc, pose);
    let (mut memory, mut pairs) = (lent(&mut memory), Vec::new());
    let mut run = |workspace: &mut Workspace, clock: &dyn Clock| {
        let outcome = spend(
            &query,
            workspace,
            memory.as_deref_mut(),
            (limit, clock),
            &mut pairs,
            None,
        )?;
        Ok((
            outcome,
            estimate(&query, workspace, memory.as_deref(), &outcome)?,
        ))
    };
    let answer = limit
        .run(py, |clock| {
            with_workspace(|workspace| run(workspace, clock))
        })?
        .map_err(resume_error)?;
    Collision::new(py, answer, pairs, Asked::new(a, b, pose), options)
}

/// The same question as that of `collide`, with buffers of its own (960 kB), so that it can be predicted, resumed and
/// asked for its certificate.
#[pyclass(module = "punctual3d")]
pub struct Query {
    trees: [Arc<punctual::Tree>; 2],
    asked: Asked,
    options: QueryOptions,
    workspace: Box<Workspace>,
    /// All that the last run found, and its outcome.
    pairs: Vec<[u32; 2]>,
    outcome: Option<punctual::Answer<Verdict>>,
}

impl Query {
    fn query(&self) -> punctual::Query<'_, punctual::intersection::Intersection> {
        let [a, b] = &self.trees;
        self.options.query(a, b, self.asked.pose)
    }

    fn spend<'py>(
        &mut self,
        py: Python<'py>,
        limit: Limit,
        mut memory: Option<PyRefMut<'_, Memory>>,
        stopped: Option<punctual::Answer<Verdict>>,
    ) -> PyResult<Bound<'py, Collision>> {
        let Self {
            trees: [a, b],
            asked,
            options,
            workspace,
            pairs,
            outcome,
            ..
        } = self;
        let (query, mut memory) = (options.query(a, b, asked.pose), lent(&mut memory));
        let run = |clock: &dyn Clock| {
            let now = spend(
                &query,
                workspace,
                memory.as_deref_mut(),
                (limit, clock),
                pairs,
                stopped,
            )?;
            *outcome = Some(now);
            Ok((
                (now, estimate(&query, workspace, memory.as_deref(), &now)?),
                pairs.clone(),
            ))
        };
        let (answer, pairs) = limit.run(py, run)?.map_err(resume_error)?;
        Collision::new(py, answer, pairs, asked.clone_ref(py), *options)
    }
}

#[pymethods]
impl Query {
    #[new]
    #[pyo3(signature = (a, b, T=None, *, mode=None, prior=None))]
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn new(
        a: Surface<'_>,
        b: Surface<'_>,
        T: Option<Transform>,
        mode: Option<ModeName>,
        prior: Option<f64>,
    ) -> PyResult<Self> {
        let options = QueryOptions::new(mode, prior)?;
        let trees = [Arc::clone(&a.arc), Arc::clone(&b.arc)];
        let asked = Asked::new(a, b, T.unwrap_or_default().0);
        let workspace = Box::new(Workspace::new());
        Ok(Self {
            trees,
            asked,
            options,
            workspace,
            pairs: Vec::new(),
            outcome: None,
        })
    }

    /// Runs from the start, within a budget of seconds or of units of work.
    #[pyo3(signature = (*, budget=None, work=None, memory=None))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        budget: Option<f64>,
        work: Option<u64>,
        memory: Option<PyRefMut<'_, Memory>>,
    ) -> PyResult<Bound<'py, Collision>> {
        let limit = Limit::new(budget, work)?;
        self.pairs.clear();
        self.spend(py, limit, memory, None)
    }

    /// Goes on with the stopped run, with a fresh budget. Cut anyhow by budgets of work, the end is that of one run.
    /// Raises ResumeError if there is no stopped run.
    #[pyo3(signature = (*, budget=None, work=None, memory=None))]
    fn resume<'py>(
        &mut self,
        py: Python<'py>,
        budget: Option<f64>,
        work: Option<u64>,
        memory: Option<PyRefMut<'_, Memory>>,
    ) -> PyResult<Bound<'py, Collision>> {
        let limit = Limit::new(budget, work)?;
        let stopped = self
            .outcome
            .filter(is_stopped)
            .ok_or_else(|| resume_error(punctual::ResumeError))?;
        self.spend(py, limit, memory, Some(stopped))
    }

    /// What it will take if nothing stops it; about 1 us.
    #[pyo3(signature = (*, memory=None))]
    fn predict(&self, memory: Option<PyRef<'_, Memory>>) -> Prediction {
        let memory = memory.as_ref().map(|memory| &memory.0);
        Prediction::new(&self.query().predict(memory), &CostModel::default())
    }

    /// What the last run left open, as far as can be guessed; about 3 us. Raises ResumeError before the first run.
    #[pyo3(signature = (*, memory=None))]
    fn estimate(&self, memory: Option<PyRef<'_, Memory>>) -> PyResult<Estimate> {
        let memory = memory.as_ref().map(|memory| &memory.0);
        let estimate = self
            .query()
            .estimate(&self.workspace, memory)
            .map_err(resume_error)?;
        Ok(Estimate::new(&estimate, &self.workspace.cost_model()))
    }

    /// What the last run left open, as far as it is proven. Raises ResumeError before the first run.
    fn certificate(&self) -> PyResult<Certificate> {
        Ok(self
            .query()
            .certificate(&self.workspace)
            .map_err(resume_error)?
            .into())
    }

    fn __repr__(&self) -> String {
        let [a, b] = self.trees.each_ref().map(|tree| tree.mesh().len());
        format!("<punctual3d.Query of {a} and {b} triangles>")
    }
}
