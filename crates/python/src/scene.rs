//! Many bodies, one budget a frame.

use crate::arrays::{Transform, Transforms, column, table};
use crate::errors::value_error;
use crate::limit::Limit;
use crate::query::{ModeName, code, witness};
use crate::tree::Tree;
use numpy::{PyArray1, PyArray2};
use punctual::{Body, BodyId, Filter, Mode, PairReport};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use std::sync::Arc;

/// Bodies that move, and the question which of them meet, asked again every frame within a budget for all of them.
///
/// mode: "any" intersection of each pair, or the number of "all". Bodies are named by integers.
#[pyclass(module = "punctual")]
pub struct Scene(punctual::Scene);

/// What a frame found: a row for each pair of bodies whose boxes overlap. If whole, bodies that are not in it together
/// do not meet.
#[pyclass(module = "punctual", frozen, get_all)]
pub struct Report {
    /// Frames so far, this one included.
    frame: u64,
    /// (N, 2) uint64: the two bodies.
    bodies: Py<PyArray2<u64>>,
    /// (N,) int8: 1 they meet, 0 they do not, both proven; -1 undecided.
    verdict: Py<PyArray1<i8>>,
    /// (N, 2) uint32: triangles of the two bodies that meet; zeros where verdict is not 1.
    witness: Py<PyArray2<u32>>,
    /// (N,) uint64: intersecting pairs of triangles found.
    found: Py<PyArray1<u64>>,
    /// (N,) float64: probability that they meet.
    probability: Py<PyArray1<f64>>,
    /// (N,) uint64: frames since the pair was decided; 0 if it was in this one.
    age: Py<PyArray1<u64>>,
    /// Whether all bodies were placed, all pairs found, and all of them listed.
    whole: bool,
    /// Bodies whose boxes are not up to date.
    unplaced: usize,
    /// Bodies that not all partners are known of.
    unpaired: usize,
    /// Known pairs that have no row.
    unlisted: usize,
    /// Units of work done.
    work: u64,
    /// Seconds; None without a budget of time.
    elapsed: Option<f64>,
}

impl Report {
    fn new(py: Python<'_>, report: &punctual::Report) -> PyResult<Self> {
        let pairs = &report.pairs;
        let counts = |count: fn(&PairReport) -> u64| column(py, pairs.iter().map(count).collect()).unbind();
        Ok(Self {
            frame: report.frame,
            bodies: table(py, pairs.iter().map(|pair| [pair.a.to_bits(), pair.b.to_bits()]))?.unbind(),
            verdict: column(py, pairs.iter().map(|pair| code(pair.verdict)).collect()).unbind(),
            witness: table(py, pairs.iter().map(|pair| witness(pair.verdict).unwrap_or_default()))?.unbind(),
            found: counts(|pair| pair.found),
            probability: column(py, pairs.iter().map(|pair| pair.probability).collect()).unbind(),
            age: counts(|pair| pair.age),
            whole: report.is_whole(),
            unplaced: report.unplaced,
            unpaired: report.unpaired,
            unlisted: report.unlisted,
            work: report.work,
            elapsed: report.elapsed.map(|elapsed| elapsed.as_secs_f64()),
        })
    }
}

/// A body that is not in the scene is a missing key.
fn scene_error(error: punctual::SceneError) -> PyErr {
    match error {
        punctual::SceneError::NoSuchBody { .. } => PyKeyError::new_err(error.to_string()),
        _ => value_error(error),
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (*, mode=None))]
    fn new(mode: Option<ModeName>) -> Self {
        Self(punctual::Scene::new().max_pairs(usize::MAX).mode(mode.map_or(Mode::Any, |ModeName(mode)| mode)))
    }

    /// Puts a body into the scene and returns its name.
    ///
    /// T: (4, 4) matrix that brings coordinates of the mesh into those of the scene. Fixed bodies are not compared with
    /// each other. groups and mask: bits; two bodies are compared if each has a group in the other's mask. importance:
    /// pairs of more important bodies go first.
    #[pyo3(signature = (tree, T=None, *, fixed=false, groups=u32::MAX, mask=u32::MAX, importance=0.0))]
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn insert(
        &mut self,
        tree: PyRef<'_, Tree>,
        T: Option<Transform>,
        fixed: bool,
        groups: u32,
        mask: u32,
        importance: f32,
    ) -> PyResult<u64> {
        let (tree, Transform(pose)) = (Arc::clone(&tree.arc), T.unwrap_or_default());
        let body = if fixed { Body::fixed(tree, pose) } else { Body::moving(tree, pose) };
        let body = body.filter(Filter::new(groups, mask)).importance(importance);
        self.0.insert(body).map(BodyId::to_bits).map_err(scene_error)
    }

    /// Takes a body out of the scene. Raises KeyError if it is not in it, as all that name one.
    fn remove(&mut self, body: u64) -> PyResult<()> {
        self.0.remove(BodyId::from_bits(body)).map(drop).map_err(scene_error)
    }

    /// Moves a body.
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn set_pose(&mut self, body: u64, T: Transform) -> PyResult<()> {
        self.0.set_pose(BodyId::from_bits(body), T.0).map_err(scene_error)
    }

    /// Moves bodies: N names and (N, 4, 4) matrices. Raises ValueError with the row of a matrix that is not rigid,
    /// before any body is moved.
    fn set_poses(&mut self, bodies: Vec<u64>, poses: Transforms) -> PyResult<()> {
        let Transforms(poses) = poses;
        if bodies.len() != poses.len() {
            return Err(value_error(format_args!("{} bodies, but {} poses", bodies.len(), poses.len())));
        }
        for &body in &bodies {
            self.0.body(BodyId::from_bits(body)).map_err(scene_error)?;
        }
        bodies
            .into_iter()
            .zip(poses)
            .try_for_each(|(body, pose)| self.0.set_pose(BodyId::from_bits(body), pose).map_err(scene_error))
    }

    /// Gives a body another tree.
    fn set_tree(&mut self, body: u64, tree: PyRef<'_, Tree>) -> PyResult<()> {
        self.0.set_tree(BodyId::from_bits(body), Arc::clone(&tree.arc)).map_err(scene_error)
    }

    /// Finds out which bodies meet, within a budget of seconds or units of work for the whole frame. Every pair of
    /// bodies has its turn within a number of frames that the documentation of the Rust library states.
    #[pyo3(signature = (budget=None, *, work=None))]
    fn step(&mut self, py: Python<'_>, budget: Option<f64>, work: Option<u64>) -> PyResult<Report> {
        let limit = Limit::new(budget, work)?;
        let scene = &mut self.0;
        limit.unlocked(py, || {
            scene.detect(limit.budget());
        });
        Report::new(py, self.0.report())
    }

    /// What is not known about two bodies where they are now: no more triangle pairs than the first number intersect,
    /// and each intersection that was not found lies in a box no longer than the second.
    fn certificate(&self, x: u64, y: u64) -> PyResult<(u64, f64)> {
        let certificate = self.0.certificate(BodyId::from_bits(x), BodyId::from_bits(y)).map_err(scene_error)?;
        Ok((certificate.upper_bound, certificate.largest_extent))
    }

    /// Number of bodies.
    fn __len__(&self) -> usize {
        self.0.len()
    }
}
