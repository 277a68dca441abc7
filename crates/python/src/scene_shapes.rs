//! What shapes and many rays meet in a scene.

use crate::answer::Answer;
use crate::arrays::{Transform, column, numbers, table};
use crate::errors::value_error;
use crate::query::code;
use crate::rays::side;
use crate::tree::Surface;
use numpy::{PyArray1, PyArray2};
use punctual::{Motion, Pose, StopReason, Verdict};
use punctual_scene::{BodyId, BodyOverlap, Filter, SceneCast, SceneShape, ShapeHit};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The first argument of questions about shapes: a tree or a mesh, or the three numbers of a point.
pub enum Shape<'py> {
    Tree(Surface<'py>),
    Point([f64; 3]),
}

impl<'py> FromPyObject<'_, 'py> for Shape<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match given.extract() {
            Ok(tree) => Ok(Self::Tree(tree)),
            Err(fault) => numbers(&given, "shape").map(Self::Point).map_err(|_| fault),
        }
    }
}

impl Shape<'_> {
    /// Where it is: a point has no other pose than its own place.
    pub fn place(&self, pose: Option<Transform>) -> PyResult<Pose> {
        match (self, pose) {
            (Self::Tree(_), pose) => Ok(pose.unwrap_or_default().0),
            (Self::Point(point), None) => {
                Pose::new(punctual::glam::DMat3::IDENTITY, *point).map_err(value_error)
            }
            (Self::Point(_), Some(_)) => Err(value_error("T: not together with a point")),
        }
    }

    /// The question, without the trees of Python.
    pub fn asked(
        &self,
        motion: Motion,
        margin: f64,
        (groups, mask, body): (u32, u32, Option<u64>),
    ) -> PyResult<SceneShape<'_>> {
        let shape = match self {
            Self::Tree(tree) => SceneShape::moving(&tree.arc, motion),
            Self::Point(point) => SceneShape::point(*point)
                .map_err(value_error)?
                .along(motion.velocity())
                .map_err(value_error)?,
        };
        let shape = shape.margin(margin).filter(Filter::new(groups, mask));
        Ok(body.map_or(shape, |body| shape.of_body(BodyId::from_bits(body))))
    }
}

/// The motion of what rests.
pub fn still(pose: Pose) -> PyResult<Motion> {
    Motion::straight(pose, [0.0; 3]).map_err(value_error)
}

fn bits(py: Python<'_>, bodies: impl Iterator<Item = BodyId>) -> Bound<'_, PyArray1<u64>> {
    column(py, bodies.map(BodyId::to_bits).collect())
}

/// What is said of the body of a hit.
#[derive(Serialize, Deserialize)]
struct Hit(Option<ShapeHit>);

impl Hit {
    fn body(&self) -> Option<u64> {
        self.0.map(|hit| hit.body.to_bits())
    }

    fn triangles(&self) -> Option<(u32, u32)> {
        self.0?.triangles.map(Into::into)
    }

    fn points<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let found = self.0.and_then(|hit| hit.points);
        found
            .map(|both| table(py, both.into_iter().map(|point| point.to_array())))
            .transpose()
    }

    fn normal<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let normal = self.0?.normal?;
        Some(column(py, normal.to_array().to_vec()))
    }
}

/// What a shape meets on its way through a scene; times from 0 to 1.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct ShapeCast {
    free_until: f64,
    touching_at: Option<f64>,
    hit: Hit,
}

impl ShapeCast {
    pub fn new(py: Python<'_>, cast: punctual_scene::ShapeCast) -> PyResult<Bound<'_, Self>> {
        let base = Answer {
            stop: cast.stop,
            work: cast.work,
            elapsed: cast.elapsed,
            remaining: None,
        };
        let cast = Self {
            free_until: cast.free_until,
            touching_at: cast.touching_at,
            hit: Hit(cast.hit),
        };
        Bound::new(py, (cast, base))
    }
}

#[pymethods]
impl ShapeCast {
    /// Proven: it meets no body before. 1 where `touching_at` is None: it is free to its end.
    #[getter]
    fn free_until(&self) -> f64 {
        self.free_until
    }

    /// Proven: it meets `body` at this time. None: no contact was found (yet).
    #[getter]
    fn touching_at(&self) -> Option<f64> {
        self.touching_at
    }

    /// The body that it meets; None if no contact was found.
    #[getter]
    fn body(&self) -> Option<u64> {
        self.hit.body()
    }

    /// The triangles that meet, of the body and of the shape; None without a hit, or if one is inside the other.
    #[getter]
    fn triangles(&self) -> Option<(u32, u32)> {
        self.hit.triangles()
    }

    /// (2, 3) float64: their closest points just before, of the body and of the shape; None without triangles.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.hit.points(py)
    }

    /// (3,) float64: unit vector from the body to the shape, just before; None where they intersect at once.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.hit.normal(py)
    }

    fn __repr__(slf: PyRef<'_, Self>) -> String {
        let touching = slf
            .touching_at
            .map_or("no contact found".to_owned(), |time| {
                format!("touching at {time}")
            });
        let (free_until, stop) = (slf.free_until, slf.as_super().stop);
        format!("<punctual3d.ShapeCast: free until {free_until}, {touching}, {stop}>")
    }
}

/// The body of a scene that is closest to a shape: low <= distance <= high.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct ClosestBody {
    low: f64,
    high: f64,
    hit: Hit,
}

impl ClosestBody {
    pub fn new(py: Python<'_>, found: punctual_scene::Closest) -> PyResult<Bound<'_, Self>> {
        let base = Answer {
            stop: found.stop,
            work: found.work,
            elapsed: found.elapsed,
            remaining: None,
        };
        let closest = Self {
            low: found.low,
            high: found.high,
            hit: Hit(found.hit),
        };
        Bound::new(py, (closest, base))
    }
}

#[pymethods]
impl ClosestBody {
    /// Proven: no body is closer, margins subtracted. Infinite if there is none at all.
    #[getter]
    fn low(&self) -> f64 {
        self.low
    }

    /// Proven: `body` is no farther; 0 if they meet. Infinite if none was found.
    #[getter]
    fn high(&self) -> f64 {
        self.high
    }

    /// The closest body found; None if none was.
    #[getter]
    fn body(&self) -> Option<u64> {
        self.hit.body()
    }

    /// The closest triangles, of the body and of the shape; None without a body, or if one is inside the other.
    #[getter]
    fn triangles(&self) -> Option<(u32, u32)> {
        self.hit.triangles()
    }

    /// (2, 3) float64: their closest points, of the body and of the shape; None without triangles.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.hit.points(py)
    }

    /// (3,) float64: unit vector from the body to the shape; None where they intersect.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.hit.normal(py)
    }

    fn __repr__(slf: PyRef<'_, Self>) -> String {
        let (low, high, stop) = (slf.low, slf.high, slf.as_super().stop);
        format!("<punctual3d.ClosestBody: {low} to {high}, {stop}>")
    }
}

/// The bodies of a scene that a shape meets: a row for each.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct Overlaps {
    met: Vec<BodyOverlap>,
    undecided: Vec<BodyId>,
    whole: bool,
}

impl Overlaps {
    pub fn new(py: Python<'_>, found: OverlapsFound) -> PyResult<Bound<'_, Self>> {
        Bound::new(py, (found.0, found.1))
    }
}

/// An answer that does not borrow the scene.
pub struct OverlapsFound(Overlaps, Answer);

impl From<punctual_scene::Overlap<'_>> for OverlapsFound {
    fn from(found: punctual_scene::Overlap<'_>) -> Self {
        let overlaps = Overlaps {
            met: found.met.to_vec(),
            undecided: found.undecided.to_vec(),
            whole: found.is_whole,
        };
        let base = Answer {
            stop: found.stop,
            work: found.work,
            elapsed: found.elapsed,
            remaining: None,
        };
        Self(overlaps, base)
    }
}

#[pymethods]
impl Overlaps {
    /// (N,) uint64: the bodies that meet the shape, proven.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        bits(py, self.met.iter().map(|met| met.body))
    }

    /// (N,) int8: 1 surfaces intersect, 2 they come within the margins, 3 one is inside the other.
    #[getter]
    fn verdicts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i8>> {
        column(py, self.met.iter().map(|met| code(met.verdict)).collect())
    }

    /// (N, 2) uint32: triangles of the body and of the shape that prove it; zeros where one is inside the other.
    #[getter]
    fn witnesses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let witness = |verdict: Verdict| verdict.witness().unwrap_or_default();
        table(py, self.met.iter().map(|met| witness(met.verdict)))
    }

    /// (M,) uint64: the bodies whose boxes overlap that of the shape and that were not decided.
    #[getter]
    fn undecided<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        bits(py, self.undecided.iter().copied())
    }

    /// True if all other bodies are proven not to meet it. False if the budget ended before all boxes were compared, or
    /// of mode "any", if a first body was enough.
    #[getter]
    fn whole(&self) -> bool {
        self.whole
    }

    fn __len__(&self) -> usize {
        self.met.len()
    }

    fn __repr__(slf: PyRef<'_, Self>) -> String {
        let (met, open, stop) = (slf.met.len(), slf.undecided.len(), slf.as_super().stop);
        format!("<punctual3d.Overlaps: {met} bodies, {open} undecided, {stop}>")
    }
}

/// What many rays hit in a scene: a row for each ray.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct SceneHits {
    casts: Vec<SceneCast>,
}

impl SceneHits {
    /// The answers, the last of which may be cut, and the time that they took.
    pub fn new(
        py: Python<'_>,
        casts: Vec<SceneCast>,
        elapsed: Option<Duration>,
    ) -> PyResult<Bound<'_, Self>> {
        let is_done = |cast: &&SceneCast| is_done(cast);
        let stop = casts.iter().find(|cast| !is_done(cast));
        let base = Answer {
            stop: stop.map_or(StopReason::Finished, |cast| cast.stop),
            work: casts.iter().map(|cast| cast.work).sum(),
            elapsed,
            remaining: None,
        };
        Bound::new(py, (Self { casts }, base))
    }

    fn of<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        read: impl Fn(&SceneCast) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        column(py, self.casts.iter().map(read).collect())
    }
}

fn is_done(cast: &SceneCast) -> bool {
    matches!(cast.stop, StopReason::Finished | StopReason::FirstHit)
}

#[pymethods]
impl SceneHits {
    /// (N,) uint64: the body that is hit; 2^64 - 1 for none.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.of(py, |cast| {
            cast.hit.map_or(u64::MAX, |hit| hit.body.to_bits())
        })
    }

    /// (N,) int64: the triangle that is hit, an index into the faces of the body's mesh; -1 for none.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.of(py, |cast| {
            cast.hit.map_or(-1, |hit| hit.on_body.triangle.into())
        })
    }

    /// (N,) float64: the hit is at `origin + t * direction`, or at `origin + t * (end - origin)`; infinite for none, NaN
    /// if the budget ended before one was found.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let none = |cast: &SceneCast| {
            if is_done(cast) {
                f64::INFINITY
            } else {
                f64::NAN
            }
        };
        self.of(py, |cast| cast.hit.map_or(none(cast), |hit| hit.on_body.t))
    }

    /// (N,) int8: 1 if the ray comes from the side from which the corners appear counterclockwise, -1 from the other;
    /// 0 if it lies in the plane of the triangle, or hits none.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i8>> {
        self.of(py, |cast| cast.hit.map_or(0, |hit| side(hit.on_body.side)))
    }

    /// (N,) float64: proven, no hit that was not found lies before this t.
    #[getter]
    fn free_until<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.of(py, |cast| cast.free_until)
    }

    /// (N,) bool: whether the ray is answered; all are if `stop` is "finished".
    #[getter]
    fn done<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.of(py, is_done)
    }

    fn __len__(&self) -> usize {
        self.casts.len()
    }

    fn __repr__(slf: PyRef<'_, Self>) -> String {
        let hits = slf.casts.iter().filter(|cast| cast.hit.is_some()).count();
        let (rays, stop) = (slf.casts.len(), slf.as_super().stop);
        format!("<punctual3d.SceneHits: {hits} hits of {rays} rays, {stop}>")
    }
}
