//! Many bodies, one budget a frame.

use crate::arrays::{Transform, Transforms, column, numbers, numbers_if, table};
use crate::batch::check_threads;
use crate::errors::value_error;
use crate::limit::Limit;
use crate::motion::path;
use crate::query::{ModeName, code};
use crate::query_batch::verdicts;
use crate::rays::{checked, not_nan, ray_mode};
use crate::scene_cast::BodyHits;
use crate::scene_contacts::ContactPoints;
use crate::scene_shapes::{
    ClosestBody, Overlaps, OverlapsFound, SceneHits, Shape, ShapeCast, still,
};
use crate::scene_tables::{BodyContacts, GroupDistances, PairDistances, PairPassages, names};
use crate::scene_view;
use crate::tree::Surface;
use crate::view::View;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use punctual::rays::RayMode;
use punctual::{Mode, Ray};
use punctual_scene::Scene as Inner;
use punctual_scene::{
    Body, BodyId, CompoundId, Filter, MeasureId, PairReport, SceneError, SceneRay,
};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// Bodies that move, and the question which of them meet, asked again every frame within a budget for all of them.
///
/// mode: "any" intersection of each pair, or the number of "all". threads: how many share the queries of a frame; answers
/// under a budget of work, or none, are the same on any number of them. Bodies are named by integers, which are the
/// same in
/// all scenes to which the same was done: a scene cannot tell a name of another one from its own.
///
/// Raises ValueError for no threads, and OSError if the system has no more.
#[pyclass(module = "punctual3d")]
pub struct Scene {
    scene: Inner,
    threads: usize,
    /// Whether nothing was changed since the last frame.
    is_current: bool,
}

impl Scene {
    /// Changes the scene, so that the last report does not hold any more; unless that is refused.
    fn change<R>(
        &mut self,
        change: impl FnOnce(&mut Inner) -> Result<R, SceneError>,
    ) -> PyResult<R> {
        let done = change(&mut self.scene).map_err(|error| scene_error(&self.scene, error))?;
        self.is_current = false;
        Ok(done)
    }

    /// Requests contacts, or no longer: of two bodies, or of all pairs.
    fn request_contacts(
        &mut self,
        [x, y]: [Option<u64>; 2],
        of_two: impl FnOnce(&mut Inner, BodyId, BodyId) -> Result<(), SceneError>,
        of_all: impl FnOnce(&mut Inner),
    ) -> PyResult<()> {
        if let Some([x, y]) = both(x, y)? {
            let requested = of_two(&mut self.scene, x, y);
            return requested.map_err(|error| scene_error(&self.scene, error));
        }
        of_all(&mut self.scene);
        Ok(())
    }
}

/// What a frame found: a row for each pair of bodies whose boxes overlap, or whose distance is asked for. If whole,
/// bodies that are not in it together, and may meet, do not.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct Report {
    /// Frames so far, this one included.
    frame: u64,
    /// (N, 2) uint64: the two bodies.
    #[serde(with = "crate::arrays::bytes")]
    bodies: Py<PyArray2<u64>>,
    /// (N,) int8: 1 they intersect, 2 they come within their margins (whether they intersect is not said), 3 one solid
    /// is inside the other, or has a vertex in it, 0 none of these, all proven; -1 undecided. They meet where it is above 0.
    #[serde(with = "crate::arrays::bytes")]
    verdict: Py<PyArray1<i8>>,
    /// (N, 2) uint32: triangles of the two bodies that intersect, or come within the margins; zeros where verdict is
    /// neither 1 nor 2.
    #[serde(with = "crate::arrays::bytes")]
    witness: Py<PyArray2<u32>>,
    /// (N,) float64: how far apart the witness is at most, margins not subtracted: 0 where verdict is 1, above 0 where
    /// it is 2, infinite elsewhere.
    #[serde(with = "crate::arrays::bytes")]
    witness_distance: Py<PyArray1<f64>>,
    /// (N,) uint64: intersecting pairs of triangles found.
    #[serde(with = "crate::arrays::bytes")]
    found: Py<PyArray1<u64>>,
    /// (N,) float64: probability that they meet.
    #[serde(with = "crate::arrays::bytes")]
    probability: Py<PyArray1<f64>>,
    /// (N,) uint64: frames since the pair was decided; 0 if it was in this one.
    #[serde(with = "crate::arrays::bytes")]
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
    /// Contacts that begin, go on and end; empty unless they are tracked (`Scene.track_contacts`).
    #[serde(with = "crate::record::nested")]
    contacts: Py<BodyContacts>,
    /// The distances that are asked for (`Scene.measure`), whether their pairs had a turn or not.
    #[serde(with = "crate::record::nested")]
    distances: Py<PairDistances>,
    /// The distances of groups that are asked for (`Scene.measure_groups`).
    #[serde(with = "crate::record::nested")]
    group_distances: Py<GroupDistances>,
    /// Until when bodies in motion are free (`Scene.set_motion`). If whole, others do not meet on their way; pairs
    /// whose distance is asked for have no row.
    #[serde(with = "crate::record::nested")]
    passages: Py<PairPassages>,
}

impl Report {
    fn new(py: Python<'_>, scene: &Inner) -> PyResult<Self> {
        let report = scene.report();
        let pairs = &report.pairs;
        let distance = |pair: &PairReport| pair.verdict.witness_distance().unwrap_or(f64::INFINITY);
        let counts =
            |count: fn(&PairReport) -> u64| column(py, pairs.iter().map(count).collect()).unbind();
        Ok(Self {
            frame: report.frame,
            bodies: names(py, pairs.iter().map(|pair| [pair.a, pair.b]))?,
            verdict: column(py, pairs.iter().map(|pair| code(pair.verdict)).collect()).unbind(),
            witness: table(
                py,
                pairs
                    .iter()
                    .map(|pair| pair.verdict.witness().unwrap_or_default()),
            )?
            .unbind(),
            witness_distance: column(py, pairs.iter().map(distance).collect()).unbind(),
            found: counts(|pair| pair.found),
            probability: column(py, pairs.iter().map(|pair| pair.probability).collect()).unbind(),
            age: counts(|pair| pair.age),
            whole: report.is_whole(),
            unplaced: report.unplaced,
            unpaired: report.unpaired,
            unlisted: report.unlisted,
            work: report.work,
            elapsed: report.elapsed.map(|elapsed| elapsed.as_secs_f64()),
            contacts: BodyContacts::new(py, &report.contacts)?,
            distances: PairDistances::new(py, &scene.distances().collect::<Vec<_>>())?,
            group_distances: GroupDistances::new(py, &report.group_distances)?,
            passages: PairPassages::new(py, &scene.passages().collect::<Vec<_>>())?,
        })
    }
}

#[pymethods]
impl Report {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let codes = self.verdict.bind(py).to_vec()?;
        let (frame, pairs, verdicts) = (self.frame, codes.len(), verdicts(&codes));
        let whole = if self.whole { "whole" } else { "not whole" };
        Ok(format!(
            "<punctual3d.Report: frame {frame}, {pairs} pairs, {verdicts}, {whole}>"
        ))
    }
}

/// Two bodies, or none.
fn both(x: Option<u64>, y: Option<u64>) -> PyResult<Option<[BodyId; 2]>> {
    match (x, y) {
        (None, None) => Ok(None),
        (Some(x), Some(y)) => Ok(Some([x, y].map(BodyId::from_bits))),
        _ => Err(value_error("x and y: both bodies are needed, or none")),
    }
}

fn ids(bodies: &[u64]) -> Vec<BodyId> {
    bodies.iter().map(|&body| BodyId::from_bits(body)).collect()
}

/// A body, a compound or a measure that is not in the scene is a missing key.
pub fn scene_error(scene: &Inner, error: SceneError) -> PyErr {
    let message = scene.message(&error);
    match error {
        SceneError::NoSuchBody { .. }
        | SceneError::NoSuchCompound { .. }
        | SceneError::NoSuchMeasure { .. } => PyKeyError::new_err(message),
        _ => value_error(message),
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (*, mode=None, threads=1))]
    fn new(mode: Option<ModeName>, threads: usize) -> PyResult<Self> {
        check_threads(threads)?;
        let mode = mode.map_or(Mode::Any, |ModeName(mode)| mode);
        let mut scene = punctual_scene::Scene::new();
        scene.set_max_pairs(usize::MAX);
        scene.set_mode(mode);
        scene.use_threads(threads)?;
        Ok(Self {
            scene,
            threads,
            is_current: false,
        })
    }

    /// Puts a body into the scene and returns its name.
    ///
    /// T: (4, 4) matrix that brings coordinates of the mesh into those of the scene. Fixed bodies are not compared with
    /// each other. A kinematic body, which moves as the program says and which nothing pushes, is a fixed one with a
    /// new pose in each frame (`set_pose`), or a motion (`set_motion`) so that nothing slips through it. groups and mask: bits; two bodies are compared if each has a group in the other's mask. importance:
    /// pairs of more important bodies go first. margin: a length; bodies meet when they come within the sum of theirs.
    /// sensor: what meets the body or is inside it is told, but its pairs have no contact points,
    /// unless those of two bodies are asked for (`find_contacts`).
    ///
    /// Raises ValueError for a T that is not rigid, an importance that is not a number, and a margin that is not a
    /// length from 0 to 2^1000.
    #[pyo3(signature = (tree, T=None, *, fixed=false, groups=u32::MAX, mask=u32::MAX, importance=0.0, margin=0.0, sensor=false))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the names and arguments of the Python function"
    )]
    fn insert(
        &mut self,
        tree: Surface<'_>,
        T: Option<Transform>,
        fixed: bool,
        groups: u32,
        mask: u32,
        importance: f32,
        margin: f64,
        sensor: bool,
    ) -> PyResult<u64> {
        let (tree, Transform(pose)) = (Arc::clone(&tree.arc), T.unwrap_or_default());
        let body = if fixed {
            Body::fixed(tree, pose)
        } else {
            Body::moving(tree, pose)
        };
        let mut body = body
            .filter(Filter::new(groups, mask))
            .importance(importance)
            .margin(margin);
        body.is_sensor = sensor;
        self.change(|scene| scene.insert(body)).map(BodyId::to_bits)
    }

    /// Names a body in messages and on pages; by an empty text no more.
    fn set_name(&mut self, body: u64, name: &str) -> PyResult<()> {
        self.scene
            .set_name(BodyId::from_bits(body), name)
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// The name of a body as a text; empty if it has none, or is not in the scene.
    fn name(&self, body: u64) -> &str {
        self.scene.name(BodyId::from_bits(body))
    }

    /// Moves a body to the group of this name, beside its bits; None: out of its group.
    fn set_group(&mut self, body: u64, group: Option<&str>) -> PyResult<()> {
        self.change(|scene| {
            let group = group.map(|name| scene.group(name));
            scene.set_group(BodyId::from_bits(body), group)
        })
    }

    /// Ignores all pairs of a body of one group and a body of the other, or does no longer; twice the same name: the
    /// bodies of a group do not meet each other.
    #[pyo3(signature = (x, y, ignores=true))]
    fn ignore_groups(&mut self, x: &str, y: &str, ignores: bool) -> PyResult<()> {
        self.change(|scene| {
            let (x, y) = (scene.group(x), scene.group(y));
            scene.ignore_groups(x, y, ignores)
        })
    }

    /// Ignores a pair of bodies, or does no longer: it may not meet. Forgotten with one of its bodies.
    #[pyo3(signature = (x, y, ignores=true))]
    fn ignore(&mut self, x: u64, y: u64, ignores: bool) -> PyResult<()> {
        self.change(|scene| scene.ignore(BodyId::from_bits(x), BodyId::from_bits(y), ignores))
    }

    /// Takes a body out of the scene. Raises KeyError if it is not in it, as all that name one.
    fn remove(&mut self, body: u64) -> PyResult<()> {
        self.change(|scene| scene.remove(BodyId::from_bits(body)))
            .map(drop)
    }

    /// Moves a body, which rests there.
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn set_pose(&mut self, body: u64, T: Transform) -> PyResult<()> {
        self.change(|scene| scene.set_pose(BodyId::from_bits(body), T.0))
    }

    /// Moves bodies: N names and (N, 4, 4) matrices, or none of them: raises ValueError with the row of a matrix that
    /// is not
    /// rigid, and KeyError for a body that is not in the scene.
    fn set_poses(&mut self, bodies: Vec<u64>, poses: Transforms) -> PyResult<()> {
        let Transforms(poses) = poses;
        if bodies.len() != poses.len() {
            return Err(value_error(format_args!(
                "{} bodies, but {} poses",
                bodies.len(),
                poses.len()
            )));
        }
        self.change(|scene| scene.set_poses(ids(&bodies).into_iter().zip(poses)))
    }

    /// Gives a body another tree.
    fn set_tree(&mut self, body: u64, tree: Surface<'_>) -> PyResult<()> {
        self.change(|scene| scene.set_tree(BodyId::from_bits(body), Arc::clone(&tree.arc)))
    }

    /// Thickens a body by a margin, a length: bodies meet when they come within the sum of theirs. Then the verdict is
    /// 2,
    /// unless triangles were found that intersect, and the witness is the closest pair of triangles that was found.
    /// Raises ValueError for a margin that is not from 0 to 2^1000.
    fn set_margin(&mut self, body: u64, margin: f64) -> PyResult<()> {
        self.change(|scene| scene.set_margin(BodyId::from_bits(body), margin))
    }

    /// From the next frame on `Report.contacts` tells which pairs of bodies begin to touch, go on, and part.
    fn track_contacts(&mut self) {
        self.scene.track_contacts();
    }

    /// Asks for the distance of two bodies in every frame from now on, wherever they are: `Report.distances`. Margins
    /// count. tolerance: a length, done as soon as the bounds are this close.
    ///
    /// Raises ValueError for a body and itself, and a tolerance that is not from 0 to 2^1000.
    fn measure(&mut self, x: u64, y: u64, tolerance: f64) -> PyResult<()> {
        self.scene
            .measure(BodyId::from_bits(x), BodyId::from_bits(y), tolerance)
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// Asks for the distance of two bodies no more.
    fn stop_measuring(&mut self, x: u64, y: u64) -> PyResult<()> {
        self.scene
            .stop_measuring(BodyId::from_bits(x), BodyId::from_bits(y))
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// Moves a body to where a motion begins, and says where it goes until the next frame, time 1: `Report.passages`
    /// tells until when each of its pairs is free, also those with a distance (`measure`), which is that at time 0. The
    /// motion stays until `set_pose`, or another one.
    ///
    /// T: (4, 4) matrix that brings coordinates of the mesh into those of the scene, at time 0. to: the same at time 1,
    /// with a screw from the one to the other. Or, in coordinates of the scene, velocity: (3,), the way until time 1;
    /// turn: (3,), axis times angle in radians; point: (3,), a point of the axis at time 0, which moves with the
    /// velocity; the origin of the mesh by default.
    ///
    /// Raises ValueError for a T that is not rigid, numbers that are not finite and for contradictions; the body then
    /// stays where it was.
    #[pyo3(signature = (body, T, *, to=None, velocity=None, turn=None, point=None))]
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn set_motion(
        &mut self,
        body: u64,
        T: Transform,
        to: Option<Transform>,
        velocity: Option<&Bound<'_, PyAny>>,
        turn: Option<&Bound<'_, PyAny>>,
        point: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let motion = path(T, to, [velocity, turn, point])?;
        self.change(|scene| scene.set_motion(BodyId::from_bits(body), motion))
    }

    /// Puts bodies into the scene as the parts of one compound, which move as one and never meet each other; returns the
    /// name of the compound. The parts are bodies like others (`parts`).
    ///
    /// T: (4, 4) matrix, the place of the compound in the scene. parts: pairs of a tree and a (4, 4) matrix, the place of
    /// the part in the compound. margin: a length, of each part.
    ///
    /// Raises ValueError for a matrix that is not rigid; the scene is then as it was.
    #[pyo3(signature = (parts, T=None, *, margin=0.0))]
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn insert_compound(
        &mut self,
        parts: Vec<(Surface<'_>, Transform)>,
        T: Option<Transform>,
        margin: f64,
    ) -> PyResult<u64> {
        let body = |(tree, Transform(place)): &(Surface<'_>, Transform)| {
            Body::moving(Arc::clone(&tree.arc), *place).margin(margin)
        };
        let Transform(pose) = T.unwrap_or_default();
        self.change(|scene| scene.insert_compound(pose, parts.iter().map(body)))
            .map(CompoundId::to_bits)
    }

    /// The names of the parts of a compound. Raises KeyError if it is not in the scene, as all that name one.
    fn parts(&self, compound: u64) -> PyResult<Vec<u64>> {
        let parts = self
            .scene
            .parts(CompoundId::from_bits(compound))
            .map_err(|error| scene_error(&self.scene, error))?;
        Ok(parts.map(BodyId::to_bits).collect())
    }

    /// The compound that a body is a part of; None if it is none.
    fn compound_of(&self, body: u64) -> PyResult<Option<u64>> {
        let compound = self
            .scene
            .compound_of(BodyId::from_bits(body))
            .map_err(|error| scene_error(&self.scene, error))?;
        Ok(compound.map(CompoundId::to_bits))
    }

    /// Moves all parts of a compound.
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn set_compound_pose(&mut self, compound: u64, T: Transform) -> PyResult<()> {
        self.change(|scene| scene.set_compound_pose(CompoundId::from_bits(compound), T.0))
    }

    /// Gives all parts of a compound one motion, about one axis; arguments as of `set_motion`.
    #[pyo3(signature = (compound, T, *, to=None, velocity=None, turn=None, point=None))]
    #[expect(non_snake_case, reason = "the name of the Python argument")]
    fn set_compound_motion(
        &mut self,
        compound: u64,
        T: Transform,
        to: Option<Transform>,
        velocity: Option<&Bound<'_, PyAny>>,
        turn: Option<&Bound<'_, PyAny>>,
        point: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let motion = path(T, to, [velocity, turn, point])?;
        self.change(|scene| scene.set_compound_motion(CompoundId::from_bits(compound), motion))
    }

    /// Takes a compound out of the scene, with all of its parts.
    fn remove_compound(&mut self, compound: u64) -> PyResult<()> {
        self.change(|scene| scene.remove_compound(CompoundId::from_bits(compound)))
    }

    /// Asks for the least distance between two groups of bodies in every frame from now on (`Report.group_distances`):
    /// a robot and what stands around it, say. Returns a name for it. Margins count. tolerance: a length.
    ///
    /// Both groups may have bodies in common, or be one: the distance within a robot, of all its pairs that may meet. A
    /// body
    /// has no distance from itself.
    ///
    /// Raises ValueError if both groups are one and the same body, and for a tolerance that is not from 0 to 2^1000.
    fn measure_groups(&mut self, x: Vec<u64>, y: Vec<u64>, tolerance: f64) -> PyResult<u64> {
        self.scene
            .measure_groups(&ids(&x), &ids(&y), tolerance)
            .map(MeasureId::to_bits)
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// Asks for the distance of two groups no more. Raises KeyError if it is not asked for.
    fn stop_measuring_groups(&mut self, measure: u64) -> PyResult<()> {
        self.scene
            .stop_measuring_groups(MeasureId::from_bits(measure))
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// Finds where bodies touch from the next frame on (`contact_points`): of two bodies, or of all pairs that meet and
    /// of which one body is in the groups `groups` and the other in `mask`, by the `groups` that they were inserted
    /// with. Several calls add up.
    #[pyo3(signature = (x=None, y=None, *, groups=u32::MAX, mask=u32::MAX))]
    fn find_contacts(
        &mut self,
        x: Option<u64>,
        y: Option<u64>,
        groups: u32,
        mask: u32,
    ) -> PyResult<()> {
        let of_all = |scene: &mut Inner| scene.find_contacts_between(Filter::new(groups, mask));
        self.request_contacts([x, y], Inner::find_contacts_of, of_all)
    }

    /// Ends the call of `find_contacts` with the same arguments; nothing changes if there was none. Contacts of pairs
    /// that are asked for otherwise are found as before.
    #[pyo3(signature = (x=None, y=None, *, groups=u32::MAX, mask=u32::MAX))]
    fn stop_finding_contacts(
        &mut self,
        x: Option<u64>,
        y: Option<u64>,
        groups: u32,
        mask: u32,
    ) -> PyResult<()> {
        let filter = Filter::new(groups, mask);
        let of_all = |scene: &mut Inner| scene.stop_finding_contacts_between(filter);
        self.request_contacts([x, y], Inner::stop_finding_contacts_of, of_all)
    }

    /// Where two bodies touch, as far as the frames up to the last have found, if that is asked for (`find_contacts`); no
    /// points if they were found apart. Raises ValueError for a body and itself.
    fn contact_points(&self, py: Python<'_>, x: u64, y: u64) -> PyResult<ContactPoints> {
        let mut ids = [BodyId::from_bits(x), BodyId::from_bits(y)];
        ids.sort_by_key(|id| id.index());
        let [a, b] = ids;
        let found = self
            .scene
            .contacts(a, b)
            .map_err(|error| scene_error(&self.scene, error))?;
        let pose = |id| {
            PyResult::Ok(
                &self
                    .scene
                    .body(id)
                    .map_err(|error| scene_error(&self.scene, error))?
                    .pose,
            )
        };
        ContactPoints::new(py, &found, [pose(a)?, pose(b)?])
    }

    /// Sets how far apart bodies are found out to be that have no contacts, besides their margins: up to so far, or to
    /// four fifths of their distance, `ContactPoints.low` tells it; 0 by default. Raises ValueError for a length that is
    /// not from 0 to 2^1000.
    fn set_look_ahead(&mut self, length: f64) -> PyResult<()> {
        self.change(|scene| scene.set_look_ahead(length))
    }

    /// How far a body may move from where it is before it could touch another one where no contact point stands, or sink
    /// into it there by more than `sink`; at most `stride`. If all moving bodies move no farther after each frame, and the
    /// fixed ones rest, none sinks in deeper there, whatever the budgets. Pairs whose contacts are not asked for
    /// (`find_contacts`) do not count.
    #[pyo3(signature = (body, stride, sink=0.0))]
    fn may_move(&mut self, body: u64, stride: f64, sink: f64) -> PyResult<f64> {
        (self.scene.may_move(BodyId::from_bits(body), stride, sink))
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// Says how much a question matters, beside the bodies that it is asked of: "meet", "distance", "motion" or "contacts";
    /// 0 by default. Raises ValueError for another question, and an importance that is not finite.
    fn set_question_importance(&mut self, question: &str, importance: f32) -> PyResult<()> {
        let question = question.parse().map_err(value_error)?;
        self.scene
            .set_question_importance(question, importance)
            .map_err(|error| scene_error(&self.scene, error))
    }

    /// Which bodies a ray or a segment hits, where they are now.
    ///
    /// origin: (3,), in coordinates of the scene. direction: (3,), of any length; t counts in that length. Or end:
    /// (3,), for a segment, of which t goes from 0 to 1. mode: "nearest" hit, "any", or "all". t_min, t_max: hits
    /// outside are left out. groups and mask: bits; only bodies that a body with these may meet are asked. budget: seconds;
    /// work: units of work.
    ///
    /// Casts are fastest after `step`. Raises ValueError for numbers that are no ray, here or in the coordinates of a
    /// body that is far away.
    #[pyo3(signature = (origin, direction=None, *, end=None, mode="nearest", t_min=0.0, t_max=f64::INFINITY,
        groups=u32::MAX, mask=u32::MAX, budget=None, work=None))]
    #[expect(
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn cast<'py>(
        &mut self,
        py: Python<'py>,
        origin: &Bound<'_, PyAny>,
        direction: Option<&Bound<'_, PyAny>>,
        end: Option<&Bound<'_, PyAny>>,
        mode: &str,
        t_min: f64,
        t_max: f64,
        groups: u32,
        mask: u32,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, BodyHits>> {
        let (mode, limit) = (ray_mode(mode)?, Limit::new(budget, work)?);
        not_nan([t_min, t_max])?;
        let origin: [f64; 3] = numbers(origin, "origin")?;
        let ray = match (numbers_if(direction, "direction")?, numbers_if(end, "end")?) {
            (Some(direction), None) => Ray::new(origin, direction),
            (None, Some(end)) => Ray::segment(origin, end),
            _ => {
                return Err(value_error(
                    "direction and end: one of them is needed, not both",
                ));
            }
        };
        let ray = SceneRay::new(ray.map_err(value_error)?.within(t_min, t_max)).mode(mode);
        let ray = ray.filter(Filter::new(groups, mask));
        let scene = &mut self.scene;
        let cast = limit.run(py, |clock| scene.cast(&ray, limit.budget().clock(clock)))?;
        let cast = cast.map_err(|error| scene_error(&self.scene, error))?;
        BodyHits::new(py, cast, self.scene.ray_hits())
    }

    /// Which bodies many rays or segments hit, one after another within one budget.
    ///
    /// origins: (N, 3), in coordinates of the scene. directions or ends, t_min, t_max: as of `rays`. mode: "nearest"
    /// hit or "any" of each ray. groups, mask: as of `cast`. body: only others that this one may meet are asked. budget:
    /// seconds; work: units of work; of all rays together. Shared among the threads of the scene; a budget of work, or
    /// none, gives the same answers on any number of them.
    ///
    /// Raises ValueError as `cast`, with the row, and KeyError for a body that is not in the scene.
    #[pyo3(signature = (origins, directions=None, *, ends=None, mode="nearest", t_min=0.0, t_max=f64::INFINITY,
        groups=u32::MAX, mask=u32::MAX, body=None, budget=None, work=None))]
    #[expect(
        clippy::too_many_arguments,
        reason = "the arguments of the Python function"
    )]
    fn cast_rays<'py>(
        &mut self,
        py: Python<'py>,
        origins: &Bound<'_, PyAny>,
        directions: Option<&Bound<'_, PyAny>>,
        ends: Option<&Bound<'_, PyAny>>,
        mode: &str,
        t_min: f64,
        t_max: f64,
        groups: u32,
        mask: u32,
        body: Option<u64>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, SceneHits>> {
        let (mode, limit) = (ray_mode(mode)?, Limit::new(budget, work)?);
        if mode == RayMode::All {
            return Err(value_error("mode: \"nearest\" or \"any\" of many rays"));
        }
        let rays = checked(py, origins, [directions, ends], [t_min, t_max])?;
        let asked = |ray| {
            let ray = SceneRay::new(ray).mode(mode);
            let ray = ray.filter(Filter::new(groups, mask));
            body.map_or(ray, |body| ray.of_body(BodyId::from_bits(body)))
        };
        let rays: Vec<_> = rays.into_iter().map(asked).collect();
        let (scene, alone) = (&mut self.scene, self.threads == 1);
        let (casts, elapsed) = limit.run(py, |clock| {
            let begin = clock.now();
            let casts = if alone {
                scene.cast_rays(&rays, limit.budget().clock(clock))
            } else {
                scene.cast_rays(&rays, limit.budget())
            };
            (casts.map(<[_]>::to_vec), clock.now().saturating_sub(begin))
        })?;
        let casts = casts.map_err(|error| scene_error(&self.scene, error))?;
        SceneHits::new(py, casts, budget.map(|_| elapsed))
    }

    /// Which body a shape meets first on its way.
    ///
    /// shape: a tree or a mesh, or (3,), a point. T: (4, 4) matrix that brings coordinates of the mesh into those of the
    /// scene at time 0. to, velocity, turn, point: its way until time 1, as of `set_motion`; of a point only a velocity.
    /// margin: a length by which it is thickened: a point is then a ball; without one it passes through surfaces in no
    /// time, which only free_until tells: cast a ray instead. groups, mask, body: as of `cast_rays`. budget: seconds;
    /// work: units of work. Bodies are where they were put last; their own motions do not count.
    ///
    /// Raises ValueError for a T that is not rigid, numbers that are not finite and contradictions, and KeyError for a
    /// body that is not in the scene.
    #[pyo3(signature = (shape, T=None, *, to=None, velocity=None, turn=None, point=None, margin=0.0,
        groups=u32::MAX, mask=u32::MAX, body=None, budget=None, work=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the names and arguments of the Python function"
    )]
    fn cast_shape<'py>(
        &mut self,
        py: Python<'py>,
        shape: Shape<'_>,
        T: Option<Transform>,
        to: Option<Transform>,
        velocity: Option<&Bound<'_, PyAny>>,
        turn: Option<&Bound<'_, PyAny>>,
        point: Option<&Bound<'_, PyAny>>,
        margin: f64,
        groups: u32,
        mask: u32,
        body: Option<u64>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, ShapeCast>> {
        let limit = Limit::new(budget, work)?;
        if matches!(shape, Shape::Point(_)) && (to.is_some() || turn.is_some()) {
            return Err(value_error("to, turn: not together with a point"));
        }
        let motion = path(Transform(shape.place(T)?), to, [velocity, turn, point])?;
        let asked = shape.asked(motion, margin, (groups, mask, body))?;
        let scene = &mut self.scene;
        let cast = limit.run(py, |clock| {
            scene.cast_shape(&asked, limit.budget().clock(clock))
        })?;
        ShapeCast::new(py, cast.map_err(|error| scene_error(&self.scene, error))?)
    }

    /// Which bodies a shape meets where it is; of two solids, what is inside meets.
    ///
    /// shape, T, margin, groups, mask, body, budget, work: as of `cast_shape`. mode: "all" bodies, or "any".
    #[pyo3(signature = (shape, T=None, *, mode=None, margin=0.0, groups=u32::MAX, mask=u32::MAX, body=None,
        budget=None, work=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the names and arguments of the Python function"
    )]
    fn overlap<'py>(
        &mut self,
        py: Python<'py>,
        shape: Shape<'_>,
        T: Option<Transform>,
        mode: Option<ModeName>,
        margin: f64,
        groups: u32,
        mask: u32,
        body: Option<u64>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, Overlaps>> {
        let limit = Limit::new(budget, work)?;
        let mode = mode.map_or(Mode::All, |ModeName(mode)| mode);
        let asked = shape.asked(still(shape.place(T)?)?, margin, (groups, mask, body))?;
        let scene = &mut self.scene;
        let found = limit.run(py, |clock| {
            let found = scene.overlap(&asked, mode, limit.budget().clock(clock));
            found.map(OverlapsFound::from)
        })?;
        Overlaps::new(py, found.map_err(|error| scene_error(&self.scene, error))?)
    }

    /// Which body is closest to a shape, or to a point: bounds of its distance, and where.
    ///
    /// shape, T, margin, groups, mask, body, budget, work: as of `cast_shape`. within: bodies farther away are not
    /// asked. Raises ValueError for a `within` that is negative or no number.
    #[pyo3(signature = (shape, T=None, *, within=f64::INFINITY, margin=0.0, groups=u32::MAX, mask=u32::MAX, body=None,
        budget=None, work=None))]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "the names and arguments of the Python function"
    )]
    fn closest<'py>(
        &mut self,
        py: Python<'py>,
        shape: Shape<'_>,
        T: Option<Transform>,
        within: f64,
        margin: f64,
        groups: u32,
        mask: u32,
        body: Option<u64>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Bound<'py, ClosestBody>> {
        let limit = Limit::new(budget, work)?;
        let asked = shape.asked(still(shape.place(T)?)?, margin, (groups, mask, body))?;
        let scene = &mut self.scene;
        let found = limit.run(py, |clock| {
            scene.closest(&asked, within, limit.budget().clock(clock))
        })?;
        ClosestBody::new(py, found.map_err(|error| scene_error(&self.scene, error))?)
    }

    /// Finds out which bodies meet, within a budget of seconds or units of work for the whole frame. Every pair of
    /// bodies has its turn within a number of frames that the documentation of the Rust library states.
    #[pyo3(signature = (budget=None, *, work=None))]
    fn step(&mut self, py: Python<'_>, budget: Option<f64>, work: Option<u64>) -> PyResult<Report> {
        let limit = Limit::new(budget, work)?;
        let scene = &mut self.scene;
        let alone = self.threads == 1;
        limit.run(py, |clock| {
            let _ = if alone {
                scene.detect(limit.budget().clock(clock))
            } else {
                scene.detect(limit.budget())
            };
        })?;
        self.is_current = true;
        Report::new(py, &self.scene)
    }

    /// What is not known about two bodies where they are now: no more triangle pairs than the first number intersect,
    /// and each intersection that was not found lies in a box no longer than the second. Raises ValueError for a body and
    /// itself.
    fn certificate(&self, x: u64, y: u64) -> PyResult<(u64, f64)> {
        let certificate = self
            .scene
            .certificate(BodyId::from_bits(x), BodyId::from_bits(y))
            .map_err(|error| scene_error(&self.scene, error))?;
        Ok((certificate.upper_bound, certificate.largest_extent))
    }

    /// A page that shows the bodies as they were in the last frame, in colours that say which meet another, which meet
    /// none and of which that is not known, and where they touch, if that was asked for (`find_contacts`). Saved if a
    /// path is given.
    ///
    /// Raises ValueError before the first frame, or if a body was changed since the last, and OSError if the file cannot be
    /// written.
    #[pyo3(signature = (path=None))]
    fn view(&self, py: Python<'_>, path: Option<PathBuf>) -> PyResult<View> {
        if !self.is_current {
            return Err(value_error("bodies were changed since the last step"));
        }
        let scene = &self.scene;
        View::made(py, path, || scene_view::page(scene).html())
    }

    /// Number of bodies.
    fn __len__(&self) -> usize {
        self.scene.len()
    }

    fn __repr__(&self) -> String {
        format!("<punctual3d.Scene of {} bodies>", self.scene.len())
    }
}
