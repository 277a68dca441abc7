//! Where two meshes meet or come close.

use crate::answer::{Answer, Asked};
use crate::arrays::{Transform, column, points, table};
use crate::errors::{not_negative, value_error};
use crate::limit::Limit;
use crate::query::with_workspace;
use crate::tree::Surface;
use crate::view::View;
use numpy::{PyArray1, PyArray2, PyArray3};
use punctual::contacts::Contact;
use punctual::glam::DVec3;
use punctual::{Clock, Pose, Query, StopReason, Workspace};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The pairs of triangles within a margin of each other, the nearest first: a row for each in all arrays, in A's frame.
///
/// All of them if `stop` is "finished"; of a stopped query the part found so far, and every other contact is at least
/// `low` apart.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Contacts {
    answer: punctual::Answer<punctual::contacts::ContactBounds>,
    found: Vec<Contact>,
    /// The unit normals of both triangles, if they have any.
    faces: Vec<[Option<DVec3>; 2]>,
    #[serde(skip)]
    asked: Option<Asked>,
    #[serde(skip)]
    options: Options,
}

/// All that a query of contacts is asked, but the trees and the pose.
#[derive(Clone, Copy, Default)]
struct Options {
    margin: f64,
    most: usize,
}

impl Options {
    fn query<'t>(
        &self,
        a: &'t punctual::Tree,
        b: &'t punctual::Tree,
        pose: Pose,
    ) -> Query<'t, punctual::contacts::Contacts> {
        Query::contacts(a, b, pose)
            .margin(self.margin)
            .contact_limit(self.most)
    }
}

#[pymethods]
impl Contacts {
    /// (N, 2): triangle of A, triangle of B.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        table(py, self.found.iter().map(|contact| contact.triangles))
    }

    /// (N, 2, 3): the closest points, of A and of B. Of triangles that meet both are the middle of the segment.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        points(
            py,
            self.found
                .iter()
                .map(|contact| contact.points.map(|point| point.to_array())),
        )
    }

    /// (N, 3): unit vectors from B to A.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(
            py,
            self.found.iter().map(|contact| contact.normal.to_array()),
        )
    }

    /// (N, 2, 3): the unit normals of the triangle of A and of that of B, by the right-hand rule; NaN for one without area.
    #[getter]
    fn face_normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        points(
            py,
            self.faces
                .iter()
                .map(|faces| faces.map(|normal| normal.unwrap_or(DVec3::NAN).to_array())),
        )
    }

    /// (N,): how far apart they are, ascending; 0 only if they meet.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(
            py,
            self.found.iter().map(|contact| contact.distance).collect(),
        )
    }

    /// (N, 2, 3): the ends of the segments in which triangles meet; NaN where they are apart.
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let ends = |contact: &Contact| {
            contact
                .segment
                .map_or([[f64::NAN; 3]; 2], |ends| ends.map(|end| end.to_array()))
        };
        points(py, self.found.iter().map(ends))
    }

    /// Proven: every contact that is missing is at least this far apart; infinite if none is missing.
    #[getter]
    fn low(&self) -> f64 {
        self.answer.value.low
    }

    /// A page that shows where surfaces meet or come close, saved if a path is given. The query is run anew for it.
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
            let most = (options.most < usize::MAX).then_some(options.most);
            punctual_view::contacts(bodies, options.query(a, b, *pose), pose, most, answer)
        })
    }

    fn __len__(&self) -> usize {
        self.found.len()
    }

    fn __repr__(&self) -> String {
        format!(
            "<punctual3d.Contacts: {}, {}>",
            self.found.len(),
            self.answer.stop
        )
    }
}

/// Runs a query and goes on when the workspace is full, until `most` contacts are found, the nearest first.
pub fn spend(
    query: &Query<'_, punctual::contacts::Contacts>,
    workspace: &mut Workspace,
    (limit, clock): (Limit, &dyn Clock),
    most: usize,
) -> (
    punctual::Answer<punctual::contacts::ContactBounds>,
    Answer,
    Vec<Contact>,
) {
    let mut answer = query.run(workspace, limit.budget().clock(clock));
    let mut found: Vec<Contact> = workspace.drain_contacts().collect();
    while answer.stop == StopReason::PairsFull && found.len() < most && !clock.is_cancelled() {
        let left = limit.left(&punctual::Stats::default(), &answer.stats);
        let Ok(next) = query.resume(workspace, left.budget().clock(clock)) else {
            break;
        };
        answer = next;
        found.extend(workspace.drain_contacts());
    }
    found.sort_by(|x, y| {
        x.distance
            .total_cmp(&y.distance)
            .then(x.triangles.cmp(&y.triangles))
    });
    if let Some(left_out) = found.get(most) {
        (answer.value.low, answer.stop) = (
            answer.value.low.min(left_out.distance),
            StopReason::PairsFull,
        );
        found.truncate(most);
    }
    (answer, Answer::of(query, workspace, None, &answer), found)
}

/// All pairs of triangles of two trees that meet or are no farther apart than a margin, the nearest first.
///
/// T: (4, 4) matrix that brings coordinates of b into those of a; the identity by default. margin: 0 for those that
/// meet. limit: stop at so many. budget: seconds; work: units of work.
///
/// Raises ValueError for a T that is not rigid and a margin that is not a number or negative, and TypeError for wrong
/// types.
#[pyfunction]
#[pyo3(signature = (a, b, T=None, *, margin=0.0, limit=None, budget=None, work=None))]
#[expect(
    non_snake_case,
    clippy::too_many_arguments,
    reason = "the names and arguments of the Python function"
)]
pub fn contacts<'py>(
    py: Python<'py>,
    a: Surface<'py>,
    b: Surface<'py>,
    T: Option<Transform>,
    margin: f64,
    limit: Option<usize>,
    budget: Option<f64>,
    work: Option<u64>,
) -> PyResult<Bound<'py, Contacts>> {
    not_negative([("margin", Some(margin))])?;
    let most = match limit {
        Some(0) => return Err(value_error("limit is 0, expected at least 1")),
        most => most.unwrap_or(usize::MAX),
    };
    let spent = Limit::new(budget, work)?;
    let (options, pose) = (Options { margin, most }, T.unwrap_or_default().0);
    let query = options.query(&a.arc, &b.arc, pose);
    let run = |clock: &dyn Clock| {
        let (answer, base, found) =
            with_workspace(|workspace| spend(&query, workspace, (spent, clock), most));
        let faces = found
            .iter()
            .map(|contact| query.face_normals(contact.triangles))
            .collect();
        (answer, base, found, faces)
    };
    let (answer, base, found, faces) = spent.run(py, run)?;
    let asked = Some(Asked::new(a, b, pose));
    Bound::new(
        py,
        (
            Contacts {
                answer,
                found,
                faces,
                asked,
                options,
            },
            base,
        ),
    )
}
