//! Robots: configurations and edges, many in one call.

use crate::arrays::{Transform, Transforms, column, numbers_if, points, table};
use crate::errors::{finite, robot_error, value_error};
use crate::interrupt::Progress;
use crate::limit::Limit;
use crate::robot_motion::{Trajectory, Way};
use crate::tree::{Surface, warn};
use crate::view::View;
use numpy::{
    PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods,
};
use punctual::Budget;
use punctual::clock::ClockedBudget;
use punctual_robot::{
    Checker, Clearance, ClearanceOptions, Collision, Edge, EdgeAnswer, EdgeOptions, Margin, Model,
    NearPair, Outcome, RobotError, Scope, Shape, ShapeId, UrdfOptions,
};
use punctual_view::Obstacle;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Configurations, and edges, that are asked between two looks whether the user cancels the call.
const BETWEEN_LOOKS: usize = 1 << 14;
const EDGES_BETWEEN_LOOKS: usize = 1 << 8;

/// What an obstacle was added with, and how it moves, for pickles.
#[derive(Clone, Serialize, Deserialize)]
struct Added {
    name: String,
    solid: Solid,
    pose: [f64; 12],
    link: Option<String>,
    may_touch: Vec<String>,
    way: Option<Way>,
}

/// Which names may touch or not, in the order told, for pickles.
type Allowed = Vec<([String; 2], bool)>;

/// What margins were set, for pickles: names, whether they are a padding, and metres.
type Margins = BTreeMap<(Option<String>, Option<String>, bool), f64>;

/// A shape, for pickles.
#[derive(Clone, Serialize, Deserialize)]
enum Solid {
    #[serde(with = "tree_bytes")]
    Mesh(Arc<punctual::Tree>),
    Box([f64; 3]),
    Sphere(f64),
    Cylinder([f64; 2]),
}

impl Solid {
    fn shape(&self) -> PyResult<Shape> {
        let shape = match self {
            Self::Mesh(tree) => Ok(Shape::tree(Arc::clone(tree))),
            Self::Box(size) => Shape::cuboid(*size),
            Self::Sphere(radius) => Shape::sphere(*radius),
            Self::Cylinder([radius, length]) => Shape::cylinder(*radius, *length),
        };
        shape.map_err(value_error)
    }
}

/// A tree as the bytes of its file. Made only for pickles.
mod tree_bytes {
    use super::{Arc, Deserialize, Serialize};
    use punctual::Tree;
    use serde::de::{Deserializer, Error};
    use serde::ser::Serializer;

    pub fn serialize<S: Serializer>(tree: &Arc<Tree>, to: S) -> Result<S::Ok, S::Error> {
        tree.to_bytes().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Tree>, D::Error> {
        let bytes = Vec::<u8>::deserialize(from)?;
        Tree::from_bytes(&bytes)
            .map(Arc::new)
            .map_err(Error::custom)
    }
}

/// Where a robot comes from, for pickles.
#[derive(Clone, Serialize, Deserialize)]
struct Source {
    urdf: PathBuf,
    srdf: Option<PathBuf>,
    packages: Vec<PathBuf>,
    solids: bool,
}

/// A robot among obstacles: which configurations collide, how much clearance they have, which edges
/// are free.
///
/// Made by `from_urdf`. A configuration has one value for each of `joint_names`, in radians or
/// metres; a call takes one, (J,), or many, (N, J). Meshes are surfaces, or solids as asked; boxes,
/// spheres and cylinders are solids, cylinders as prisms around them of 128 sides. Answers are exact
/// for the poses of `link_poses`. Calls of several threads wait for each other: to use several cores, give
/// `threads`, or pickle a robot for each process.
#[pyclass(module = "punctual3d", frozen)]
pub struct Robot {
    /// In a box: Python's objects have less alignment than it needs.
    checker: Box<Mutex<Checker>>,
    added: Mutex<Vec<(ShapeId, Added)>>,
    margins: Mutex<Margins>,
    allowed: Mutex<Allowed>,
    source: Source,
}

/// What robots say of configurations, a row for each.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct RobotCollisions {
    /// (N,) int8: 1 collides, 0 free, both proven; -1 the budget ended first.
    #[serde(with = "crate::arrays::bytes")]
    verdict: Py<PyArray1<i8>>,
    /// (N, 2) int64: numbers of shapes that meet (`Robot.shape_name`); -1 where verdict is not 1.
    #[serde(with = "crate::arrays::bytes")]
    pairs: Py<PyArray2<i64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

/// All pairs of shapes that meet, of each configuration.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct RobotMeetings {
    /// (N,) int8: 1 collides, 0 free, both proven; -1 the budget ended first.
    #[serde(with = "crate::arrays::bytes")]
    verdict: Py<PyArray1<i8>>,
    /// (N,) bool: whether all pairs that meet are told; not where the budget ended first.
    #[serde(with = "crate::arrays::bytes")]
    complete: Py<PyArray1<bool>>,
    /// (M, 2) int64: numbers of shapes that meet (`Robot.shape_name`), of all configurations; those of configuration i
    /// are pairs[offsets[i]:offsets[i + 1]].
    #[serde(with = "crate::arrays::bytes")]
    pairs: Py<PyArray2<i64>>,
    /// (N + 1,) int64.
    #[serde(with = "crate::arrays::bytes")]
    offsets: Py<PyArray1<i64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

/// The least distance of all pairs of shapes, a row for each configuration: low <= distance <=
/// high, in metres.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct RobotClearances {
    /// (N,) float64, proven.
    #[serde(with = "crate::arrays::bytes")]
    low: Py<PyArray1<f64>>,
    /// (N,) float64, proven.
    #[serde(with = "crate::arrays::bytes")]
    high: Py<PyArray1<f64>>,
    /// (N, 2) int64: numbers of the closest shapes found; -1 where there are none.
    #[serde(with = "crate::arrays::bytes")]
    pairs: Py<PyArray2<i64>>,
    /// (N, 2, 3) float64: their closest points in the world.
    #[serde(with = "crate::arrays::bytes")]
    points: Py<PyArray3<f64>>,
    /// (N, 3) float64: unit vectors from the first point to the second, 0 where they are one.
    #[serde(with = "crate::arrays::bytes")]
    normals: Py<PyArray2<f64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

/// All pairs of shapes that are near each other, of each configuration: low <= what is left of the
/// distance above the margin <= high, in metres. Those of configuration i are the rows from
/// offsets[i] to offsets[i + 1].
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct RobotNearPairs {
    /// (M, 2) int64: numbers of the shapes (`Robot.shape_name`), the lower one first.
    #[serde(with = "crate::arrays::bytes")]
    pairs: Py<PyArray2<i64>>,
    /// (M,) float64, proven.
    #[serde(with = "crate::arrays::bytes")]
    low: Py<PyArray1<f64>>,
    /// (M,) float64, proven.
    #[serde(with = "crate::arrays::bytes")]
    high: Py<PyArray1<f64>>,
    /// (M, 2, 3) float64: their closest points in the world; 0 if one holds the other.
    #[serde(with = "crate::arrays::bytes")]
    points: Py<PyArray3<f64>>,
    /// (M, 3) float64: unit vectors from the first point to the second, 0 where they are one.
    #[serde(with = "crate::arrays::bytes")]
    normals: Py<PyArray2<f64>>,
    /// (M, J) float64: how the distance changes with each joint, in m/rad or m/m; 0 of points that
    /// touch.
    #[serde(with = "crate::arrays::bytes")]
    gradients: Py<PyArray2<f64>>,
    /// (N + 1,) int64.
    #[serde(with = "crate::arrays::bytes")]
    offsets: Py<PyArray1<i64>>,
    /// (N,) float64, proven: no less is left of the pairs that are not listed; `within` at least,
    /// unless the budget ended first.
    #[serde(with = "crate::arrays::bytes")]
    beyond: Py<PyArray1<f64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

/// What is known of straight lines in joint space, a row for each; times are shares of them. Of a
/// path or a horizon one row, with the times that these state.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct RobotEdges {
    /// (N,) int8: 0 free, 1 in contact somewhere, both proven for all times; -1 not known.
    #[serde(with = "crate::arrays::bytes")]
    verdict: Py<PyArray1<i8>>,
    /// (N,) float64: no contact before, proven; the time of the end where all is free.
    #[serde(with = "crate::arrays::bytes")]
    free_until: Py<PyArray1<f64>>,
    /// (N,) float64: contact then, proven; NaN where none was found.
    #[serde(with = "crate::arrays::bytes")]
    touching_at: Py<PyArray1<f64>>,
    /// (N, 2) int64: numbers of the shapes that meet then; -1 where none was found.
    #[serde(with = "crate::arrays::bytes")]
    pairs: Py<PyArray2<i64>>,
    /// (N,) uint64: units of work done.
    #[serde(with = "crate::arrays::bytes")]
    work: Py<PyArray1<u64>>,
}

fn numbers(pair: Option<[ShapeId; 2]>) -> [i64; 2] {
    pair.map_or([-1; 2], |pair| pair.map(|id| i64::from(id.number())))
}

/// 1 collides, 0 free, -1 undecided.
fn code(row: &Outcome<Collision>) -> i8 {
    match row.value {
        Collision::Free => 0,
        Collision::Contact(_) => 1,
        Collision::Undecided => -1,
    }
}

fn count(codes: &Bound<'_, PyArray1<i8>>, code: i8) -> PyResult<usize> {
    Ok(codes.to_vec()?.iter().filter(|&&c| c == code).count())
}

fn edge_options(
    first: bool,
    resolution: f64,
    [start, duration]: [f64; 2],
) -> PyResult<EdgeOptions> {
    finite([("resolution", Some(resolution))])?;
    let mut options = match first {
        true => EdgeOptions::first(),
        false => EdgeOptions::any(),
    };
    (options.resolution, options.start, options.duration) = (resolution, start, duration);
    Ok(options)
}

/// Where the rows of each configuration begin among all rows, and where the last ones end.
fn offsets(counts: impl Iterator<Item = usize>) -> Vec<i64> {
    let sums = counts.scan(0, |sum, count| {
        *sum += count as i64;
        Some(*sum)
    });
    std::iter::once(0).chain(sums).collect()
}

fn robot_edges(py: Python<'_>, rows: &[Outcome<Edge>]) -> PyResult<RobotEdges> {
    let code = |row: &Outcome<Edge>| match row.value.answer {
        EdgeAnswer::Free => 0,
        EdgeAnswer::Contact => 1,
        EdgeAnswer::Undecided => -1,
    };
    let each = |number: fn(&Edge) -> f64| {
        column(py, rows.iter().map(|row| number(&row.value)).collect()).unbind()
    };
    Ok(RobotEdges {
        verdict: column(py, rows.iter().map(code).collect()).unbind(),
        free_until: each(|row| row.free_until),
        touching_at: each(|row| row.touching_at.unwrap_or(f64::NAN)),
        pairs: table(py, rows.iter().map(|row| numbers(row.value.pair)))?.unbind(),
        work: column(py, rows.iter().map(|row| row.work).collect()).unbind(),
    })
}

/// The largest share of the speed, 0 to 1, at which a robot that is free for `free_for` seconds at
/// full speed may go on for `cycle` seconds and then still stop in time. braking: seconds in which
/// it stops from the full speed (`braking_time`).
#[pyfunction]
#[pyo3(signature = (free_for, cycle, braking))]
pub fn safe_speed(free_for: f64, cycle: f64, braking: f64) -> f64 {
    punctual_robot::safe_speed(free_for, cycle, braking)
}

/// Seconds in which joints with these velocities stop, all in proportion, if each can decelerate so
/// much: (J,), rad/s^2 or m/s^2.
#[pyfunction]
#[pyo3(signature = (velocity, decelerations))]
pub fn braking_time(velocity: One, decelerations: One) -> PyResult<f64> {
    let (v, a) = (velocity.0, decelerations.0);
    if v.len() != a.len() {
        let fault = format!("{} velocities, {} decelerations", v.len(), a.len());
        return Err(value_error(fault));
    }
    Ok(punctual_robot::braking_time(&v, &a))
}

/// A row for each configuration: one of a vector, many of a matrix.
pub struct Rows<'py>(pub PyReadonlyArray2<'py, f64>);

impl<'py> FromPyObject<'_, 'py> for Rows<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = given.cast::<PyArray2<f64>>()
            && array.is_c_contiguous()
        {
            return Ok(Self(array.to_owned().try_readonly()?));
        }
        let py = given.py();
        let numpy = py.import(intern!(py, "numpy"))?;
        let array = numpy.call_method1(
            intern!(py, "ascontiguousarray"),
            (&given, numpy::dtype::<f64>(py)),
        )?;
        let array = numpy.call_method1(intern!(py, "atleast_2d"), (array,))?;
        let rows = array.cast_into::<PyArray2<f64>>();
        Ok(Self(
            rows.map_err(|_| value_error("configurations: expected (N, J)"))?
                .try_readonly()?,
        ))
    }
}

/// One configuration: of an array of f64, or any sequence of numbers.
pub struct One(pub Vec<f64>);

impl<'py> FromPyObject<'_, 'py> for One {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match given.cast::<PyArray1<f64>>() {
            Ok(array) if array.is_c_contiguous() => Ok(Self(array.to_vec()?)),
            _ => Ok(Self(given.extract()?)),
        }
    }
}

/// The pairs that count for a clearance.
#[derive(FromPyObject)]
enum ScopeName {
    Shape(u32),
    Word(String),
}

impl Robot {
    fn new(source: Source) -> Result<Self, RobotError> {
        let mut options = UrdfOptions::default();
        options.srdf.clone_from(&source.srdf);
        options.packages.clone_from(&source.packages);
        options.solids = source.solids;
        let model = Model::from_urdf(&source.urdf, &options)?;
        Ok(Self {
            checker: Box::new(Mutex::new(Checker::new(Arc::new(model)))),
            added: Mutex::default(),
            margins: Mutex::default(),
            allowed: Mutex::default(),
            source,
        })
    }

    pub fn checker(&self) -> MutexGuard<'_, Checker> {
        self.checker.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn added(&self) -> MutexGuard<'_, Vec<(ShapeId, Added)>> {
        self.added.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn margins(&self) -> MutexGuard<'_, Margins> {
        self.margins.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a link or an obstacle has this name.
    fn has(&self, name: &str) -> bool {
        let is_link = self.checker().model().link_names().any(|link| link == name);
        is_link || self.added().iter().any(|(_, added)| added.name == name)
    }

    fn insert(&self, added: Added, shape: Shape) -> Result<u32, RobotError> {
        let pose = punctual::Pose::from_row_major(added.pose).unwrap_or(punctual::Pose::IDENTITY);
        let touches: Vec<&str> = added.may_touch.iter().map(String::as_str).collect();
        let track = added.way.as_ref().map(Way::track).transpose()?;
        let mut checker = self.checker();
        let id = checker.attach(&added.name, added.link.as_deref(), pose, shape, &touches)?;
        track.map_or(Ok(()), |track| checker.move_along(id, track))?;
        drop(checker);
        self.added().push((id, added));
        Ok(id.number())
    }

    fn allowed(&self) -> MutexGuard<'_, Allowed> {
        self.allowed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells what a pickle was told of names, those of removed obstacles too: others of these names
    /// may come.
    fn restore_names(&self, margins: Margins, allowed: Allowed) -> PyResult<()> {
        let mut absent = Vec::new();
        let of_margins = margins.keys().flat_map(|(name, other, _)| [name, other]);
        let of_margins = of_margins.flatten();
        for name in of_margins.chain(allowed.iter().flat_map(|(names, _)| names)) {
            if !self.has(name) {
                let shape = Shape::sphere(1.0).map_err(value_error)?;
                let added = Added {
                    name: name.clone(),
                    solid: Solid::Sphere(1.0),
                    pose: punctual::Pose::IDENTITY.to_row_major(),
                    link: None,
                    may_touch: Vec::new(),
                    way: None,
                };
                absent.push(self.insert(added, shape).map_err(value_error)?);
            }
        }
        for ((name, other, padding), margin) in margins {
            self.set_margin(margin, name, other, padding)?;
        }
        for ([name, other], may_touch) in allowed {
            self.allow(name, other, may_touch)?;
        }
        absent
            .into_iter()
            .try_for_each(|number| self.remove(number))
    }

    fn id(&self, number: u32) -> PyResult<ShapeId> {
        let added = self.added();
        let found = added.binary_search_by_key(&number, |(id, _)| id.number());
        found.map(|at| added[at].0).map_err(|_| {
            value_error(format_args!(
                "obstacle {number}: {}",
                RobotError::NoObstacle
            ))
        })
    }

    /// Keeps for pickles how an obstacle was changed.
    fn change(&self, id: ShapeId, change: impl FnOnce(&mut Added)) {
        let mut added = self.added();
        if let Some((_, added)) = added.iter_mut().find(|(other, _)| *other == id) {
            change(added);
        }
    }

    fn scope(&self, scope: &ScopeName) -> PyResult<Scope> {
        let of_shape = |number: &u32| self.checker().id(*number).map(Scope::Shape);
        let (found, given) = match scope {
            ScopeName::Word(word) if word == "robot" => return Ok(Scope::Robot),
            ScopeName::Word(word) if word == "obstacles" => return Ok(Scope::Obstacles),
            ScopeName::Word(word) => (None, format!("{word:?}")),
            ScopeName::Shape(number) => (of_shape(number), number.to_string()),
        };
        found.ok_or_else(|| {
            let expected = "expected robot, obstacles or the number of a shape";
            value_error(format_args!("scope: {given}, {expected}"))
        })
    }

    fn clearance_options(
        &self,
        tolerance: f64,
        scope: Option<ScopeName>,
    ) -> PyResult<ClearanceOptions> {
        finite([("tolerance", Some(tolerance))])?;
        let scope = scope.map_or(Ok(Scope::All), |scope| self.scope(&scope))?;
        let options = ClearanceOptions::default().tolerance(tolerance);
        Ok(options.scope(scope))
    }

    /// The shape of configurations; an error unless they have a value for each joint.
    fn check_width(&self, rows: &Rows<'_>) -> PyResult<(usize, usize)> {
        let (count, width) = (rows.0.shape()[0], rows.0.shape()[1]);
        let joints = self.checker().model().joint_names().len();
        if width == joints {
            return Ok((count, width));
        }
        let fault = format!("configurations: shape ({count}, {width}), expected (N, {joints})");
        Err(value_error(fault))
    }

    /// Asks about one motion.
    fn ask_one(
        &self,
        py: Python<'_>,
        limit: Limit,
        ask: impl FnOnce(&mut Checker, ClockedBudget<'_>) -> Result<Outcome<Edge>, RobotError> + Send,
    ) -> PyResult<RobotEdges> {
        let found = limit.run(py, |clock| {
            ask(&mut self.checker(), limit.budget().clock(clock))
        })?;
        robot_edges(py, &[found.map_err(value_error)?])
    }

    /// Asks in blocks of rows, without the interpreter's lock, and tells `progress` after each.
    fn ask<T: Send>(
        &self,
        py: Python<'_>,
        rows: &Rows<'_>,
        block: usize,
        progress: Option<Py<PyAny>>,
        ask: impl Fn(&mut Checker, usize, &[f64]) -> Result<Vec<T>, RobotError> + Sync,
    ) -> PyResult<Vec<T>> {
        let (count, width) = self.check_width(rows)?;
        let values = rows.0.as_slice().map_err(value_error)?;
        let mut answers = Vec::with_capacity(count);
        let progress = Progress::new(progress, count);
        // No numbers say how many configurations without a value there are.
        let block = if width == 0 { 1 } else { block };
        for first in (0..count).step_by(block) {
            let last = count.min(first + block);
            let part = &values[first * width..last * width];
            answers.extend(
                py.detach(|| ask(&mut self.checker(), first, part))
                    .map_err(value_error)?,
            );
            progress.add(last - first);
            py.check_signals()?;
            progress.tell(py)?;
        }
        Ok(answers)
    }
}

#[pymethods]
impl Robot {
    /// Reads a robot from a URDF file.
    ///
    /// srdf: the SRDF file, whose disabled pairs are not asked; without it, links joined by one
    /// moving joint are not. packages: folders in which `package://` names are sought, before those
    /// above the URDF file. solids: closed meshes are solids, so that what is inside them collides.
    ///
    /// Warns (UserWarning) of each of its `notices`. Raises FileNotFoundError if there is no such file, or none of a mesh that
    /// it names, and ValueError for other faults, with the file, the line, and the link or joint.
    #[classmethod]
    #[pyo3(signature = (urdf, *, srdf=None, packages=Vec::new(), solids=false))]
    fn from_urdf(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        urdf: PathBuf,
        srdf: Option<PathBuf>,
        packages: Vec<PathBuf>,
        solids: bool,
    ) -> PyResult<Self> {
        let source = Source {
            urdf,
            srdf,
            packages,
            solids,
        };
        let robot = py
            .detach(|| Self::new(source))
            .map_err(|error| robot_error(&error))?;
        for notice in robot.notices() {
            warn(py, notice)?;
        }
        Ok(robot)
    }

    /// What the files say that is not heeded, a line each: pairs of links that the robot does not have, elements that are
    /// passed over, open meshes that were to be solids.
    #[getter]
    fn notices(&self) -> Vec<String> {
        self.checker().model().notices().to_vec()
    }

    /// Names of the joints whose values make a configuration.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.checker().model().joint_names().to_vec()
    }

    /// (J, 2) float64: lower and upper limits of these joints, infinite where there are none. Never
    /// enforced.
    #[getter]
    fn joint_limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let none = [f64::NEG_INFINITY, f64::INFINITY];
        let limits = self.checker().model().joint_limits().to_vec();
        table(py, limits.into_iter().map(|limits| limits.unwrap_or(none)))
    }

    /// Names of the links, in the order of `link_poses`.
    #[getter]
    fn link_names(&self) -> Vec<String> {
        self.checker()
            .model()
            .link_names()
            .map(str::to_owned)
            .collect()
    }

    /// Name of a shape by its number: of its link, or of the obstacle. Raises ValueError if it was
    /// removed.
    #[pyo3(signature = (number))]
    fn shape_name(&self, number: u32) -> PyResult<String> {
        let checker = self.checker();
        let id = checker.id(number).and_then(|id| checker.name(id));
        let name = id.ok_or_else(|| value_error(format_args!("there is no shape {number}")))?;
        Ok(name.to_owned())
    }

    /// Adds an obstacle, and returns its number: one of mesh (a Tree or a trimesh.Trimesh; a Tree
    /// that was built as a closed solid is one), box (three lengths), sphere (radius) and cylinder (radius, length), centred, a cylinder along z.
    ///
    /// T: (4, 4), its place in the world, or in the frame of link if that is given: then it moves
    /// with that link. It is not asked with the links of may_touch. Warns (UserWarning) of a Tree
    /// that was built as a solid and is open: it is a surface. Raises ValueError for a link that the
    /// robot does not have.
    #[pyo3(signature = (name, T=None, *, mesh=None, r#box=None, sphere=None, cylinder=None, link=None, may_touch=Vec::new()))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn add(
        &self,
        py: Python<'_>,
        name: String,
        T: Option<Transform>,
        mesh: Option<Surface<'_>>,
        r#box: Option<[f64; 3]>,
        sphere: Option<f64>,
        cylinder: Option<[f64; 2]>,
        link: Option<String>,
        may_touch: Vec<String>,
    ) -> PyResult<u32> {
        let pose = T.unwrap_or_default().0.to_row_major();
        let solid = match (&mesh, r#box, sphere, cylinder) {
            (Some(mesh), None, None, None) => Solid::Mesh(Arc::clone(&mesh.arc)),
            (None, Some(size), None, None) => Solid::Box(size),
            (None, None, Some(radius), None) => Solid::Sphere(radius),
            (None, None, None, Some(size)) => Solid::Cylinder(size),
            _ => {
                let fault = "one of mesh, box, sphere and cylinder must be given";
                return Err(value_error(fault));
            }
        };
        let open = mesh.and_then(|mesh| Some(mesh.arc.solid()?.open_edges()));
        if let Some(open) = open.filter(|&open| open > 0) {
            let why = format!("it has {open} open edges");
            warn(py, format!("obstacle {name}: a surface, for {why}"))?;
        }
        let shape = solid.shape()?;
        let added = Added {
            name,
            solid,
            pose,
            link,
            may_touch,
            way: None,
        };
        self.insert(added, shape).map_err(value_error)
    }

    /// Moves an obstacle to another place, in the frame in which it was added.
    #[pyo3(signature = (number, T))]
    #[expect(non_snake_case, reason = "the argument of the Python function")]
    fn r#move(&self, number: u32, T: Transform) -> PyResult<()> {
        let id = self.id(number)?;
        self.checker().move_to(id, T.0).map_err(value_error)?;
        self.change(id, |added| {
            (added.pose, added.way) = (T.0.to_row_major(), None);
        });
        Ok(())
    }

    /// Makes an obstacle in the world move by itself, in edges, paths, trajectories and horizons;
    /// labels and clearances are of time 0. `move` ends its motion. It is not checked against links
    /// that stand still in the world, nor other obstacles.
    ///
    /// poses: (4, 4), where it is at time 0; from there it goes on with a linear velocity (m/s) and
    /// turns about its origin with an angular one (rad/s), both (3,), in the frame of the world. Or
    /// (N, 4, 4), where it is at ascending times (s), (N,). reach: each of its points may be so far
    /// (m) from there, and farther by reach_speed (m/s) with time. Raises ValueError for an obstacle
    /// that is attached to a link, and for faults of the numbers, with the pose.
    #[pyo3(signature = (number, poses, *, linear=None, angular=None, times=None, reach=0.0, reach_speed=0.0))]
    #[expect(
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn move_along(
        &self,
        number: u32,
        poses: Transforms,
        linear: Option<&Bound<'_, PyAny>>,
        angular: Option<&Bound<'_, PyAny>>,
        times: Option<One>,
        reach: f64,
        reach_speed: f64,
    ) -> PyResult<()> {
        let id = self.id(number)?;
        let linear = numbers_if(linear, "linear")?;
        let angular = numbers_if(angular, "angular")?;
        let is_steady = linear.or(angular).is_some();
        let times = match times {
            Some(_) if is_steady => Err("times: not with linear or angular".to_owned()),
            Some(One(times)) if times.len() == poses.0.len() => Ok(Ok(times)),
            Some(One(times)) => Err(format!("times: {} of {} poses", times.len(), poses.0.len())),
            None if poses.0.len() == 1 => Ok(Err([linear, angular].map(Option::unwrap_or_default))),
            None => Err(format!("times: expected those of {} poses", poses.0.len())),
        };
        let way = Way {
            poses: poses.0.iter().map(punctual::Pose::to_row_major).collect(),
            times: times.map_err(value_error)?,
            reach: [reach, reach_speed],
        };
        let track = way.track().map_err(value_error)?;
        self.checker().move_along(id, track).map_err(value_error)?;
        self.change(id, |added| added.way = Some(way));
        Ok(())
    }

    /// Removes an obstacle.
    #[pyo3(signature = (number))]
    fn remove(&self, number: u32) -> PyResult<()> {
        let id = self.id(number)?;
        self.checker().remove(id).map_err(value_error)?;
        self.added().retain(|(other, _)| *other != id);
        Ok(())
    }

    /// Sets how far apart shapes must be, in metres: 0 at first. Shapes that are no farther apart
    /// than their margin count as in contact, in all answers: labels, edges, paths and horizons. A
    /// clearance is what is left above the margin, so it is negative within it.
    ///
    /// name: a link or an obstacle, whose pairs it is for, in addition to the margin of all; without
    /// it, it is for all pairs. other: a second one: the margin is for pairs of these two, in place
    /// of all other margins. padding: it is for pairs of the link `name`, or of what is attached to
    /// one, and obstacles in the world, in addition to the others. A link stands for all its shapes.
    ///
    /// Obstacles that are added later follow what was set for their names. Pickles keep margins.
    /// Raises ValueError, which names the argument, if there is no link or obstacle of a name, if
    /// other or padding have no name or come together, and if margin is negative, NaN or more than
    /// 1e30. Nothing is changed then.
    #[pyo3(signature = (margin, *, name=None, other=None, padding=false))]
    fn set_margin(
        &self,
        margin: f64,
        name: Option<String>,
        other: Option<String>,
        padding: bool,
    ) -> PyResult<()> {
        for (argument, given) in [("name", &name), ("other", &other)] {
            if let Some(name) = given.as_ref().filter(|name| !self.has(name)) {
                let fault = format!("{argument}: there is no link or obstacle {name}");
                return Err(value_error(fault));
            }
        }
        let of = match (name.as_deref(), other.as_deref(), padding) {
            (None, None, false) => Margin::All,
            (Some(name), None, false) => Margin::Of(name),
            (Some(name), None, true) => Margin::Padding(name),
            (Some(name), Some(other), false) => Margin::Pair(name, other),
            (Some(_), Some(_), true) => return Err(value_error("padding: not of two names")),
            (None, Some(_), _) => return Err(value_error("other: expected name too")),
            (None, None, true) => return Err(value_error("padding: expected name too")),
        };
        let mut margins = self.margins();
        self.checker().set_margin(of, margin).map_err(value_error)?;
        // Either order names the same pair.
        let names = match other {
            Some(other) if Some(&other) < name.as_ref() => (Some(other), name),
            other => (name, other),
        };
        margins.insert((names.0, names.1, padding), margin);
        Ok(())
    }

    /// Tells whether two links or obstacles may touch: pairs that may are not asked. What was told
    /// last of a pair counts, before the SRDF file and may_touch. Obstacles that are added later
    /// follow what was told of their names. Pickles keep it. Raises ValueError, which names the
    /// argument, if there is no link or obstacle of a name.
    #[pyo3(signature = (name, other, may_touch=true))]
    fn allow(&self, name: String, other: String, may_touch: bool) -> PyResult<()> {
        for (argument, name) in [("name", &name), ("other", &other)] {
            if !self.has(name) {
                let fault = format!("{argument}: there is no link or obstacle {name}");
                return Err(value_error(fault));
            }
        }
        let told = self.checker().allow([&name, &other], may_touch);
        told.map_err(value_error)?;
        let mut names = [name, other];
        names.sort();
        let mut allowed = self.allowed();
        allowed.retain(|(other, _)| *other != names);
        allowed.push((names, may_touch));
        Ok(())
    }

    /// (N, L, 4, 4) float64: poses of all links in the world.
    #[pyo3(signature = (Q))]
    #[expect(non_snake_case, reason = "the argument of the Python function")]
    fn link_poses<'py>(
        &self,
        py: Python<'py>,
        Q: Rows<'py>,
    ) -> PyResult<Bound<'py, PyArray4<f64>>> {
        let model = Arc::clone(self.checker().model());
        let (count, width) = (Q.0.shape()[0], Q.0.shape()[1]);
        let values = Q.0.as_slice().map_err(value_error)?;
        let mut flat = Vec::new();
        for row in 0..count {
            let poses = model.link_poses(&values[row * width..][..width]);
            for pose in poses.map_err(value_error)? {
                flat.extend(pose.to_row_major());
                flat.extend([0.0, 0.0, 0.0, 1.0]);
            }
        }
        column(py, flat).reshape([count, model.link_names().len(), 4, 4])
    }

    /// Which configurations collide.
    ///
    /// Q: (N, J), or one, (J,). budget (seconds) and work are those of each configuration. threads:
    /// how many share them; answers under a budget of work, or none, are the same on any number of
    /// them. progress: a callable, told from time to time and at the end how many are done, and of
    /// how many.
    #[pyo3(signature = (Q, *, budget=None, work=None, threads=1, progress=None))]
    #[expect(non_snake_case, reason = "the argument of the Python function")]
    fn collide(
        &self,
        py: Python<'_>,
        Q: Rows<'_>,
        budget: Option<f64>,
        work: Option<u64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<RobotCollisions> {
        let budget = Limit::new(budget, work)?.budget();
        let rows = self.ask(py, &Q, BETWEEN_LOOKS, progress, |checker, _, part| {
            checker.collide_batch(part, budget, threads)
        })?;
        let pair = |row: &Outcome<Collision>| match row.value {
            Collision::Contact(pair) => numbers(Some(pair)),
            _ => numbers(None),
        };
        Ok(RobotCollisions {
            verdict: column(py, rows.iter().map(code).collect()).unbind(),
            pairs: table(py, rows.iter().map(pair))?.unbind(),
            work: column(py, rows.iter().map(|row| row.work).collect()).unbind(),
        })
    }

    /// All pairs of shapes that meet, not only the first: a search of the whole robot.
    ///
    /// Q, budget, work and progress: as of `collide`.
    #[pyo3(signature = (Q, *, budget=None, work=None, progress=None))]
    #[expect(non_snake_case, reason = "the argument of the Python function")]
    fn collide_all(
        &self,
        py: Python<'_>,
        Q: Rows<'_>,
        budget: Option<f64>,
        work: Option<u64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<RobotMeetings> {
        let budget = Limit::new(budget, work)?.budget();
        let rows = self.ask(py, &Q, EDGES_BETWEEN_LOOKS, progress, |checker, _, part| {
            let width = checker.model().joint_names().len();
            // A robot that does not move has one configuration, without numbers.
            let parts = part.chunks_exact(width.max(1));
            let parts = parts.chain((width == 0).then_some(part));
            let all = |configuration| {
                let mut pairs = Vec::new();
                let found = checker.collide_all(configuration, budget, &mut pairs)?;
                Ok((found, pairs))
            };
            parts.map(all).collect()
        })?;
        let offsets = offsets(rows.iter().map(|(_, pairs)| pairs.len()));
        let pairs = rows.iter().flat_map(|(_, pairs)| pairs);
        let is_whole = |(found, _): &(Outcome<_>, _)| found.stop.is_final();
        Ok(RobotMeetings {
            verdict: column(py, rows.iter().map(|(found, _)| code(found)).collect()).unbind(),
            complete: column(py, rows.iter().map(is_whole).collect()).unbind(),
            pairs: table(py, pairs.map(|&pair| numbers(Some(pair))))?.unbind(),
            offsets: column(py, offsets).unbind(),
            work: column(py, rows.iter().map(|(found, _)| found.work).collect()).unbind(),
        })
    }

    /// How far configurations are from contact: bounds that are `tolerance` (metres) apart, and
    /// where.
    ///
    /// scope: which pairs count: those within the "robot", with what is attached to it; those of it and "obstacles" that
    /// stand still; those of the shape of a number; by default all. Other arguments as those of `collide`. Raises
    /// ValueError for another scope.
    #[pyo3(signature = (Q, *, tolerance=1e-6, scope=None, budget=None, work=None, threads=1, progress=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn clearance(
        &self,
        py: Python<'_>,
        Q: Rows<'_>,
        tolerance: f64,
        scope: Option<ScopeName>,
        budget: Option<f64>,
        work: Option<u64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<RobotClearances> {
        let budget = Limit::new(budget, work)?.budget();
        let options = self.clearance_options(tolerance, scope)?;
        let rows = self.ask(py, &Q, BETWEEN_LOOKS, progress, |checker, _, part| {
            checker.clearance_batch(part, &options, budget, threads)
        })?;
        let each = |number: fn(&Clearance) -> f64| {
            column(py, rows.iter().map(|row| number(&row.value)).collect()).unbind()
        };
        let places = rows
            .iter()
            .map(|row| row.value.points.map(|p| p.to_array()));
        Ok(RobotClearances {
            low: each(|row| row.low),
            high: each(|row| row.high),
            pairs: table(py, rows.iter().map(|row| numbers(row.value.pair)))?.unbind(),
            points: points(py, places)?.unbind(),
            normals: table(py, rows.iter().map(|row| row.value.normal.to_array()))?.unbind(),
            work: column(py, rows.iter().map(|row| row.work).collect()).unbind(),
        })
    }

    /// All pairs of shapes of which no more than `within` metres is left above their margin, each with
    /// proven bounds, closest points and a gradient in joint space: for optimisation, model-predictive
    /// control and barrier functions. Pairs may be listed that are beyond by the tolerance.
    ///
    /// Other arguments as those of `clearance`.
    #[pyo3(signature = (Q, within, *, tolerance=1e-6, scope=None, budget=None, work=None, threads=1, progress=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn near_pairs(
        &self,
        py: Python<'_>,
        Q: Rows<'_>,
        within: f64,
        tolerance: f64,
        scope: Option<ScopeName>,
        budget: Option<f64>,
        work: Option<u64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<RobotNearPairs> {
        let budget = Limit::new(budget, work)?.budget();
        let options = self.clearance_options(tolerance, scope)?;
        if within.is_nan() {
            return Err(value_error("within is NaN"));
        }
        let (_, width) = self.check_width(&Q)?;
        let rows = self.ask(py, &Q, EDGES_BETWEEN_LOOKS, progress, |checker, _, part| {
            checker.near_pairs_batch(part, within, &options, budget, threads)
        })?;
        let pairs = || rows.iter().flat_map(|(_, found)| &found.pairs);
        let each = |number: fn(&NearPair) -> f64| column(py, pairs().map(number).collect());
        let gradients = rows.iter().flat_map(|(_, found)| &found.gradients).copied();
        let gradients = column(py, gradients.collect()).reshape([pairs().count(), width])?;
        let places = pairs().map(|pair| pair.points.map(|p| p.to_array()));
        let counts = rows.iter().map(|(_, found)| found.pairs.len());
        let beyond = rows.iter().map(|(outcome, _)| outcome.value);
        let work = rows.iter().map(|(outcome, _)| outcome.work);
        Ok(RobotNearPairs {
            pairs: table(py, pairs().map(|pair| numbers(Some(pair.pair))))?.unbind(),
            low: each(|pair| pair.low).unbind(),
            high: each(|pair| pair.high).unbind(),
            points: points(py, places)?.unbind(),
            normals: table(py, pairs().map(|pair| pair.normal.to_array()))?.unbind(),
            gradients: gradients.unbind(),
            offsets: column(py, offsets(counts)).unbind(),
            beyond: column(py, beyond.collect()).unbind(),
            work: column(py, work.collect()).unbind(),
        })
    }

    /// Whether straight lines in joint space are free, from each row of Q0 to that of Q1. Free is
    /// proven for all of the line, not at samples.
    ///
    /// first: seek the first contact, not any. resolution: shares of the line that are shorter are
    /// given up. start: when the line begins, in seconds, and duration: what it takes, for obstacles
    /// that move by themselves; times of the answer are in this unit. Other arguments as those of
    /// `collide`.
    #[pyo3(signature = (Q0, Q1, *, first=false, resolution=1e-6, start=0.0, duration=1.0, budget=None, work=None, threads=1, progress=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn edges(
        &self,
        py: Python<'_>,
        Q0: Rows<'_>,
        Q1: Rows<'_>,
        first: bool,
        resolution: f64,
        start: f64,
        duration: f64,
        budget: Option<f64>,
        work: Option<u64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<RobotEdges> {
        let budget = Limit::new(budget, work)?.budget();
        if Q0.0.shape() != Q1.0.shape() {
            return Err(value_error("Q0 and Q1: different shapes"));
        }
        let options = edge_options(first, resolution, [start, duration])?;
        let width = Q0.0.shape()[1];
        let ends = Q1.0.as_slice().map_err(value_error)?;
        let rows = self.ask(
            py,
            &Q0,
            EDGES_BETWEEN_LOOKS,
            progress,
            |checker, at, part| {
                let ends = &ends[at * width..][..part.len()];
                checker.edge_batch(part, ends, &options, budget, threads)
            },
        )?;
        robot_edges(py, &rows)
    }

    /// Whether a path is free: straight lines from each row of Q to the next, proven from coarse to
    /// fine along all of it. One row; times count lines, so 1.5 is the middle of the second one.
    ///
    /// Other arguments as those of `edges`; duration is that of each line. `resume` continues a path
    /// that its budget stopped.
    #[pyo3(signature = (Q, *, first=false, resolution=1e-6, start=0.0, duration=1.0, budget=None, work=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn path(
        &self,
        py: Python<'_>,
        Q: Rows<'_>,
        first: bool,
        resolution: f64,
        start: f64,
        duration: f64,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<RobotEdges> {
        self.check_width(&Q)?;
        let options = edge_options(first, resolution, [start, duration])?;
        let knots = Q.0.as_slice().map_err(value_error)?;
        self.ask_one(py, Limit::new(budget, work)?, |checker, budget| {
            checker.path(knots, &options, budget)
        })
    }

    /// Whether a motion along polynomials of time is free, proven as by `path`. One row; its times
    /// are seconds. start: when it begins, for obstacles that move by themselves. Other arguments as
    /// those of `edges`. `resume` continues it.
    #[pyo3(signature = (motion, *, first=false, resolution=1e-6, start=0.0, budget=None, work=None))]
    #[expect(
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn trajectory(
        &self,
        py: Python<'_>,
        motion: PyRef<'_, Trajectory>,
        first: bool,
        resolution: f64,
        start: f64,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<RobotEdges> {
        let options = edge_options(first, resolution, [start, 1.0])?;
        let motion = &motion.0;
        self.ask_one(py, Limit::new(budget, work)?, |checker, budget| {
            checker.trajectory(motion, &options, budget)
        })
    }

    /// For how long the robot is free if its joints go on at this velocity (rad/s or m/s), at most
    /// for `seconds`. One row; its times are seconds.
    ///
    /// q, velocity: (J,). The near future is proven first: a budget (seconds) or work that ends
    /// early leaves a shorter `free_until`, from which `safe_speed` makes a speed.
    #[pyo3(signature = (q, velocity, seconds, *, budget=None, work=None))]
    fn horizon(
        &self,
        py: Python<'_>,
        q: One,
        velocity: One,
        seconds: f64,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<RobotEdges> {
        finite([("seconds", Some(seconds))])?;
        self.ask_one(py, Limit::new(budget, work)?, |checker, budget| {
            checker.horizon(&q.0, &velocity.0, seconds, budget)
        })
    }

    /// Continues the last `path`, `trajectory` or `horizon`, which its budget stopped. Raises ValueError if it is
    /// done, or something else was asked or changed since.
    #[pyo3(signature = (*, budget=None, work=None))]
    fn resume(
        &self,
        py: Python<'_>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<RobotEdges> {
        self.ask_one(py, Limit::new(budget, work)?, |checker, budget| {
            checker.resume_edge(budget)
        })
    }

    /// A page with the robot and its obstacles at the configurations, (N, J), as that of
    /// `punctual robot --view`: links coloured by clearance, a slider for each joint. Saved if a
    /// path is given.
    #[pyo3(signature = (Q, path=None))]
    #[expect(non_snake_case, reason = "the argument of the Python function")]
    fn view(&self, py: Python<'_>, Q: Rows<'_>, path: Option<PathBuf>) -> PyResult<View> {
        let (_, width) = self.check_width(&Q)?;
        let rows =
            Q.0.as_slice()
                .map_err(value_error)?
                .chunks_exact(width.max(1));
        let rows: Vec<(usize, &[f64])> = rows.enumerate().collect();
        let added = self.added().clone();
        let obstacles = added.iter().map(|(id, added)| {
            Ok(Obstacle {
                id: *id,
                link: added.link.as_deref(),
                pose: punctual::Pose::from_row_major(added.pose).map_err(value_error)?,
                shape: added.solid.shape()?,
            })
        });
        let obstacles = obstacles.collect::<PyResult<Vec<_>>>()?;
        let stride = punctual_view::stride(rows.len());
        let rows: Vec<_> = rows.into_iter().step_by(stride).collect();
        let page = py.detach(|| {
            let mut checker = self.checker();
            let title = format!(
                "How far a robot is from contact: {}",
                checker.model().name()
            );
            punctual_view::robot(title, &mut checker, &obstacles, &rows, Budget::unlimited())
        });
        let page = page.map_err(value_error)?;
        View::made(py, path, || page.html())
    }

    /// Whether one configuration, (J,), is free.
    #[pyo3(signature = (q))]
    fn is_valid(&self, q: One) -> PyResult<bool> {
        let found = self.checker().collide(&q.0, Budget::unlimited());
        Ok(found.map_err(value_error)?.value == Collision::Free)
    }

    /// Whether the straight line between two configurations, (J,), is proven free.
    #[pyo3(signature = (q0, q1))]
    fn is_edge_valid(&self, q0: One, q1: One) -> PyResult<bool> {
        let options = EdgeOptions::any();
        let found = self
            .checker()
            .edge(&q0.0, &q1.0, &options, Budget::unlimited());
        Ok(found.map_err(value_error)?.value.answer == EdgeAnswer::Free)
    }

    /// Reads the files again, adds the obstacles, with their numbers, and tells it what it was told of names.
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let added: Vec<(u32, Added)> = (self.added().iter())
            .map(|(id, added)| (id.number(), added.clone()))
            .collect();
        let margins = self.margins().clone();
        let state = (&self.source, added, margins, self.allowed().clone());
        let state = postcard::to_allocvec(&state).map_err(value_error)?;
        let restore = py.get_type::<Self>().getattr(intern!(py, "_restore"))?;
        Ok((restore, (PyBytes::new(py, &state),)))
    }

    /// The robot of a pickle.
    #[staticmethod]
    fn _restore(py: Python<'_>, state: &[u8]) -> PyResult<Self> {
        let damaged = |fault| value_error(format_args!("Robot: the pickle is damaged: {fault}"));
        type State = (Source, Vec<(u32, Added)>, Margins, Allowed);
        let state = postcard::from_bytes::<State>(state).map_err(damaged)?;
        let (source, added, margins, allowed) = state;
        py.detach(|| {
            let robot = Self::new(source).map_err(|error| robot_error(&error))?;
            for (number, added) in added {
                let shape = added.solid.shape()?;
                robot.checker().number_next(number);
                robot.insert(added, shape).map_err(value_error)?;
            }
            robot.restore_names(margins, allowed)?;
            Ok(robot)
        })
    }

    fn __repr__(&self) -> String {
        let checker = self.checker();
        let model = checker.model();
        format!(
            "<punctual3d.Robot {:?}: {} joint values, {} links, {} pairs>",
            model.name(),
            model.joint_names().len(),
            model.link_names().len(),
            checker.pairs().len()
        )
    }
}

#[pymethods]
impl RobotCollisions {
    /// Number of configurations.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.verdict.bind(py).len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let codes = self.verdict.bind(py);
        let [met, free, open] = [1, 0, -1].map(|code| count(codes, code));
        let (met, free, open) = (met?, free?, open?);
        Ok(format!(
            "<punctual3d.RobotCollisions: {met} collide, {free} free, {open} undecided>"
        ))
    }
}

#[pymethods]
impl RobotMeetings {
    /// Number of configurations.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.verdict.bind(py).len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (configurations, pairs) = (self.__len__(py)?, self.pairs.bind(py).shape()[0]);
        Ok(format!(
            "<punctual3d.RobotMeetings: {configurations} configurations, {pairs} pairs meet>"
        ))
    }
}

#[pymethods]
impl RobotClearances {
    /// Number of configurations.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.low.bind(py).len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "<punctual3d.RobotClearances: {} configurations>",
            self.__len__(py)?
        ))
    }
}

#[pymethods]
impl RobotNearPairs {
    /// Number of configurations.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.beyond.bind(py).len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (configurations, pairs) = (self.__len__(py)?, self.pairs.bind(py).shape()[0]);
        Ok(format!(
            "<punctual3d.RobotNearPairs: {configurations} configurations, {pairs} pairs>"
        ))
    }
}

#[pymethods]
impl RobotEdges {
    /// Number of edges.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.verdict.bind(py).len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let codes = self.verdict.bind(py);
        let [met, free, open] = [1, 0, -1].map(|code| count(codes, code));
        let (met, free, open) = (met?, free?, open?);
        Ok(format!(
            "<punctual3d.RobotEdges: {free} free, {met} blocked, {open} undecided>"
        ))
    }
}
