//! What all answers have in common: why they were given and what they took, and of what.

use crate::errors::value_error;
use crate::estimate::Remaining;
use crate::tree::{Surface, Tree};
use crate::view::View;
use punctual::engine::{Ask, Question};
use punctual::{PairMemory, Pose, Query, ResumeError, Stats, StopReason, Workspace};
use punctual_view::Bodies;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::PathBuf;
use std::time::Duration;

/// What every answer has, whatever was asked.
#[pyclass(module = "punctual3d", frozen, subclass)]
#[derive(Clone, Serialize, Deserialize)]
pub struct Answer {
    pub stop: StopReason,
    pub work: u64,
    pub elapsed: Option<Duration>,
    pub remaining: Option<Remaining>,
}

impl Answer {
    pub fn new(stop: StopReason, stats: &Stats) -> Self {
        Self {
            stop,
            work: stats.work,
            elapsed: stats.elapsed,
            remaining: None,
        }
    }

    /// The last answer of a query in this workspace, with what the query has still to do.
    pub fn of<'t, Q: Question>(
        query: &Query<'t, Q>,
        workspace: &Workspace,
        memory: Option<&PairMemory>,
        answer: &punctual::Answer<Q::Value>,
    ) -> Self
    where
        Query<'t, Q>: Ask<Q>,
    {
        let told = || query.remaining(workspace, memory).ok().map(Remaining::from);
        Self {
            remaining: (!answer.stop.is_final()).then(told).flatten(),
            ..Self::new(answer.stop, &answer.stats)
        }
    }
}

#[pymethods]
impl Answer {
    /// Why the query returned: "finished"; "first-hit", of `collide` and `Scene.cast` if one is enough; "deadline" or
    /// "work-limit", the budget ended first; "pairs-full", there are more contacts than `limit`; "flushed-to-zero", the
    /// processor drops denormal numbers.
    #[getter]
    fn stop(&self) -> String {
        self.stop.to_string()
    }

    /// Units of work done; the same for the same input on every machine.
    #[getter]
    fn work(&self) -> u64 {
        self.work
    }

    /// What a stopped query has still to do, expected; None if it finished, or of many queries in one call.
    #[getter]
    fn remaining(&self) -> Option<Remaining> {
        self.remaining
    }

    /// Seconds; None without a budget of time, since a look at the clock costs as much as a small query.
    #[getter]
    fn elapsed(&self) -> Option<f64> {
        self.elapsed.map(|elapsed| elapsed.as_secs_f64())
    }
}

/// Two trees and where B was, for answers that can be shown.
///
/// Trees are kept as the objects of Python, not by an `Arc`: otherwise a refit would have to copy a tree that an answer
/// still knows.
pub struct Asked {
    trees: [(Py<Tree>, u64); 2],
    pub pose: Pose,
}

impl Asked {
    pub fn new(a: Surface<'_>, b: Surface<'_>, pose: Pose) -> Self {
        let known = |Surface(tree): Surface<'_>| {
            let refits = tree.refits;
            (tree.into(), refits)
        };
        Self {
            trees: [known(a), known(b)],
            pose,
        }
    }

    pub fn clone_ref(&self, py: Python<'_>) -> Self {
        Self {
            trees: [0, 1].map(|side| (self.trees[side].0.clone_ref(py), self.trees[side].1)),
            pose: self.pose,
        }
    }

    /// The page that `show` makes of the trees, saved if a file is named. Made without the interpreter's lock.
    ///
    /// An answer that was pickled has none.
    pub fn view(
        asked: &Option<Self>,
        py: Python<'_>,
        path: Option<PathBuf>,
        show: impl FnOnce(&Bodies<'_>, &Pose) -> Result<punctual_view::View, ResumeError> + Send,
    ) -> PyResult<View> {
        let Some(Self { trees: known, pose }) = asked else {
            return Err(value_error(
                "the answer was pickled, which leaves the trees behind: it cannot be shown",
            ));
        };
        let mut trees = Vec::new();
        for (name, (tree, refits)) in ["a", "b"].into_iter().zip(known) {
            let tree = tree.try_borrow(py)?;
            if tree.refits != *refits {
                return Err(value_error(format_args!(
                    "{name} was refitted since it was asked about"
                )));
            }
            trees.push(tree.arc.clone());
        }
        View::made(py, path, || {
            let trees = [&*trees[0], &*trees[1]];
            let name = |tree: &punctual::Tree| {
                format!(
                    "mesh of {} triangles",
                    punctual_view::count(tree.mesh().len() as u64)
                )
            };
            show(&Bodies::new(trees.map(name), trees), pose)
                .map_err(io::Error::other)?
                .html()
        })
    }
}
