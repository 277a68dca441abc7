//! The interface of `trimesh.collision.CollisionManager`, on a scene.

use crate::arrays::{Transform, column, matrix};
use crate::contacts;
use crate::interrupt::cancellable;
use crate::limit::Limit;
use crate::penetration;
use crate::query::with_workspace;
use crate::scene::scene_error;
use crate::tree::{Surface, Tree};
use numpy::PyArray1;
use punctual::contacts::Contact;
use punctual::glam::DVec3;
use punctual::{Budget, Clock, Mode, Pose, Query};
use punctual_depenetrate::PenetrationQuery;
use punctual_scene::{Body, BodyId, Scene, SceneError, SceneShape};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyAttributeError, PyKeyError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyDict, PySet, PyTuple, PyType};
use std::cell::Cell;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

/// Most work about the depth of two solids, some 5 ms. Convex ones need a tenth of it, unless they are round and have
/// almost one centre: then the depth told is up to .1 % more than the least.
const MOST_DEPTH_WORK: u64 = 5_000_000;

/// Work of the first frame that looks whether any two objects meet. Each next one doubles it, so that one meeting of many
/// is found without the others.
const LOOK_WORK: u64 = 1_000_000;

/// Where two objects meet: two triangles of surfaces, or the deepest place of two solids.
#[pyclass(module = "punctual3d", frozen)]
pub struct ContactData {
    names: [Py<PyAny>; 2],
    place: Place,
}

#[pymethods]
impl ContactData {
    /// The names of the two objects, a set.
    #[getter]
    fn names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PySet>> {
        PySet::new(py, &self.names)
    }

    /// (3,): the middle of the segment in which the triangles meet; of solids, the middle between the points
    /// of both that touch last when they are parted.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.place.point.to_array().to_vec())
    }

    /// (3,), a unit vector: moved along it, the first object parts from the second; of surfaces, if both have their
    /// normals outside. The first is the one of the manager that was asked, or the one that was added first.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, self.place.normal.to_array().to_vec())
    }

    /// The shortest way found that parts two solids, which is along the normal. Of surfaces it is not known: raises
    /// AttributeError.
    #[getter]
    fn depth(&self) -> PyResult<f64> {
        self.place.depth.ok_or_else(|| {
            PyAttributeError::new_err(
                "depth: surfaces have none; see punctual3d.manifolds and punctual3d.penetration",
            )
        })
    }

    /// The triangle of the object of this name.
    fn index(&self, name: &Bound<'_, PyAny>) -> PyResult<u32> {
        Ok(self.place.triangles[side(&self.names, name)?])
    }

    #[staticmethod]
    fn _of(
        names: [Py<PyAny>; 2],
        vectors: [[f64; 3]; 2],
        triangles: [u32; 2],
        depth: Option<f64>,
    ) -> Self {
        let [point, normal] = vectors.map(DVec3::from);
        let place = Place {
            point,
            normal,
            triangles,
            depth,
        };
        Self { names, place }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, Self { names, place }) = (slf.py(), slf.get());
        let vectors = [place.point, place.normal].map(<[f64; 3]>::from);
        let names = names.each_ref().map(|name| name.clone_ref(py));
        let parts = (names, vectors, place.triangles, place.depth);
        Ok((slf.getattr("_of")?, parts.into_bound_py_any(py)?))
    }
}

/// Where two objects are closest; of two solids that meet, where they are deepest.
#[pyclass(module = "punctual3d", frozen)]
pub struct DistanceData {
    names: [Py<PyAny>; 2],
    closest: Closest,
}

#[pymethods]
impl DistanceData {
    /// The names of the two objects, a set.
    #[getter]
    fn names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PySet>> {
        PySet::new(py, &self.names)
    }

    /// How far apart they are; of surfaces that meet 0, of two solids minus the shortest way found that parts them.
    #[getter]
    fn distance(&self) -> f64 {
        self.closest.distance
    }

    /// The closest triangle of the object of this name.
    fn index(&self, name: &Bound<'_, PyAny>) -> PyResult<u32> {
        Ok(self.closest.triangles[side(&self.names, name)?])
    }

    /// Its closest point, (3,).
    fn point<'py>(&self, name: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let point = self.closest.points[side(&self.names, name)?];
        Ok(column(name.py(), point.to_array().to_vec()))
    }

    #[staticmethod]
    fn _of(
        names: [Py<PyAny>; 2],
        points: [[f64; 3]; 2],
        triangles: [u32; 2],
        distance: f64,
    ) -> Self {
        let closest = Closest {
            distance,
            points: points.map(DVec3::from),
            triangles,
        };
        Self { names, closest }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, Self { names, closest }) = (slf.py(), slf.get());
        let points = closest.points.map(<[f64; 3]>::from);
        let names = names.each_ref().map(|name| name.clone_ref(py));
        let parts = (names, points, closest.triangles, closest.distance);
        Ok((slf.getattr("_of")?, parts.into_bound_py_any(py)?))
    }
}

/// Which of two objects has a name.
fn side(names: &[Py<PyAny>; 2], name: &Bound<'_, PyAny>) -> PyResult<usize> {
    for (side, own) in names.iter().enumerate().rev() {
        if name.eq(own)? {
            return Ok(side);
        }
    }
    Err(PyKeyError::new_err(name.clone().unbind()))
}

/// A tree where it is.
#[derive(Clone)]
struct Placed {
    tree: Arc<punctual::Tree>,
    pose: Pose,
}

impl Placed {
    fn new(mesh: &Bound<'_, PyAny>, transform: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let py = mesh.py();
        let is_convex = match mesh.cast::<Tree>() {
            Ok(_) => None,
            Err(_) => mesh.getattr_opt(intern!(py, "is_convex"))?,
        };
        let tree = match is_convex {
            Some(is_convex) if is_convex.is_truthy()? => {
                Tree::from_trimesh(&py.get_type::<Tree>(), mesh, "normal", false, "flip")?.arc
            }
            _ => Arc::clone(&mesh.extract::<Surface>()?.arc),
        };
        let pose = transform.map_or(Ok(Transform::default()), |given| given.extract())?;
        Ok(Self { tree, pose: pose.0 })
    }

    fn of(body: &Body) -> Self {
        let (tree, pose) = (Arc::clone(&body.tree), body.pose);
        Self { tree, pose }
    }

    /// Whether its tree is a closed solid.
    fn is_solid(&self) -> bool {
        self.tree
            .solid()
            .is_some_and(|solid| solid.open_edges() == 0)
    }

    fn shape(&self) -> SceneShape<'_> {
        SceneShape::new(&self.tree, self.pose)
    }
}

/// A place where two objects meet.
#[derive(Clone, Copy)]
struct Place {
    point: DVec3,
    normal: DVec3,
    triangles: [u32; 2],
    /// Of solids.
    depth: Option<f64>,
}

/// The closest points of two objects.
#[derive(Clone, Copy)]
struct Closest {
    distance: f64,
    points: [DVec3; 2],
    triangles: [u32; 2],
}

/// Two objects that may meet.
struct Pair([Placed; 2]);

impl Pair {
    fn b_in_a(&self) -> Pose {
        let Self([a, b]) = self;
        a.pose.inverse_unchecked().compose_unchecked(&b.pose)
    }

    fn are_solid(&self) -> bool {
        self.0.iter().all(Placed::is_solid)
    }

    /// Where they meet.
    fn places(&self, clock: &dyn Clock) -> Vec<Place> {
        if self.are_solid() {
            let deepest = self.deepest(f64::INFINITY, clock);
            let place = |(normal, deepest): (DVec3, Closest)| Place {
                point: deepest.points[0].midpoint(deepest.points[1]),
                normal,
                triangles: deepest.triangles,
                depth: Some(-deepest.distance),
            };
            return deepest.into_iter().map(place).collect();
        }
        let a = &self.0[0];
        let place = |contact: &Contact| Place {
            point: a.pose.transform_point(contact.points[0]),
            normal: *a.pose.rotation() * contact.normal,
            triangles: contact.triangles,
            depth: None,
        };
        self.contacts(clock).iter().map(place).collect()
    }

    /// The pairs of triangles that meet.
    fn contacts(&self, clock: &dyn Clock) -> Vec<Contact> {
        let Self([a, b]) = self;
        let query = Query::contacts(&a.tree, &b.tree, self.b_in_a());
        let (_, _, found) = with_workspace(|workspace| {
            contacts::spend(&query, workspace, (Limit::None, clock), usize::MAX)
        });
        found
    }

    /// Where two that meet are closest or, if they are solids, deepest. None unless their distance is below a limit.
    fn closest(&self, below: f64, clock: &dyn Clock) -> Option<Closest> {
        if self.are_solid() {
            return Some(self.deepest(below, clock)?.1);
        }
        if below <= 0.0 {
            return None;
        }
        let Self([a, b]) = self;
        let query = Query::distance(&a.tree, &b.tree, self.b_in_a());
        let found =
            with_workspace(|workspace| query.run(workspace, Budget::unlimited().clock(clock)));
        let punctual::distance::Bounds { high, nearest, .. } = found.value;
        nearest.map(|nearest| Closest {
            distance: high,
            points: nearest.points.map(|point| a.pose.transform_point(point)),
            triangles: nearest.triangles,
        })
    }

    /// How deep a solid is in another: the least way that parts them, where, and along which normal of the first. None
    /// unless their distance, minus the depth, is below a limit.
    fn deepest(&self, below: f64, clock: &dyn Clock) -> Option<(DVec3, Closest)> {
        let Self([a, b]) = self;
        let b_in_a = self.b_in_a();
        let query = PenetrationQuery::new(&a.tree, &b.tree, b_in_a).solid(true);
        let query = query.relative_tolerance(1e-6);
        let ask = |query: PenetrationQuery| {
            penetration::with_workspace(|workspace| {
                query
                    .run(workspace, Budget::work(MOST_DEPTH_WORK).clock(clock))
                    .value
            })
        };
        if below <= 0.0 && ask(query.deeper_than(-below)).deeper == Some(false) {
            return None;
        }
        let found = ask(query);
        let corners = [(a, Pose::IDENTITY), (b, b_in_a)].map(|(placed, pose)| {
            let mesh = placed.tree.mesh();
            let corners = |triangle| mesh.triangle(triangle).map(|p| pose.transform_point(p));
            (0..mesh.len()).map(corners).collect::<Vec<_>>()
        });
        let way = -found.direction.unwrap_or_default();
        let (mut depth, mut normal) = (found.high, way);
        // The way found is never shorter than the least, which is along the normal of a face if one is that near: exactly
        // so, if the solids are convex; of those with radii, along the line between the cores if these are apart.
        let normal_of = |sign: f64| {
            move |&[p, q, r]: &[DVec3; 3]| sign * (q - p).cross(r - p).normalize_or_zero()
        };
        let faces = corners.iter().zip([-1.0, 1.0]);
        let faces = faces.flat_map(|(triangles, sign)| triangles.iter().map(normal_of(sign)));
        let faces = faces.filter(|normal| normal.dot(way) > 1.0 - 1e-5);
        let radii = [&a.tree, &b.tree].map(|tree| tree.radius());
        let between = (radii != [0.0; 2]).then(|| self.contacts(clock));
        let between = between.into_iter().flatten();
        let between = between.min_by(|a, b| a.distance.total_cmp(&b.distance));
        for candidate in faces.chain(between.map(|contact| contact.normal)) {
            let cores = reach(&corners[0], -candidate) + reach(&corners[1], candidate);
            let width = cores + radii[0] + radii[1];
            if width <= depth {
                (depth, normal) = (width, candidate);
            }
        }
        // Where they touch when they are parted.
        let push = normal * (depth * (1.0 + 1e-9));
        let apart = Pose::new(*b_in_a.rotation(), b_in_a.translation() - push).ok()?;
        let query = Query::distance(&a.tree, &b.tree, apart).relative_tolerance(0.1);
        let touching = with_workspace(|workspace| {
            query
                .run(workspace, Budget::unlimited().clock(clock))
                .value
                .nearest
        })?;
        let points = [touching.points[0], touching.points[1] + push];
        let closest = Closest {
            distance: -depth,
            points: points.map(|point| a.pose.transform_point(point)),
            triangles: touching.triangles,
        };
        Some((*a.pose.rotation() * normal, closest))
    }
}

/// How far triangles reach along a direction.
fn reach(triangles: &[[DVec3; 3]], direction: DVec3) -> f64 {
    let along = triangles.as_flattened().iter().map(|c| c.dot(direction));
    along.fold(f64::NEG_INFINITY, f64::max)
}

/// An object that is asked about.
struct Asker {
    name: Py<PyAny>,
    placed: Placed,
    /// The body that it is itself.
    body: Option<BodyId>,
}

impl Asker {
    /// The object of a call, which is in no manager.
    fn external(
        mesh: &Bound<'_, PyAny>,
        transform: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Self>> {
        Ok(vec![Self {
            name: intern!(mesh.py(), "__external").clone().into_any().unbind(),
            placed: Placed::new(mesh, transform)?,
            body: None,
        }])
    }
}

/// The objects of a manager: the bodies of a scene.
struct Objects {
    scene: Scene,
    /// The bits of the body of each name.
    ids: Py<PyDict>,
    names: HashMap<BodyId, Py<PyAny>>,
    /// Number of objects added. The data of a body is the number before it was.
    added: u64,
}

impl Objects {
    fn error(&self, error: SceneError) -> PyErr {
        scene_error(&self.scene, error)
    }

    /// The body of a name, if there is one.
    fn find(&self, name: &Bound<'_, PyAny>) -> PyResult<Option<BodyId>> {
        let bits = self.ids.bind(name.py()).get_item(name)?;
        let id = bits.map(|bits| bits.extract().map(BodyId::from_bits));
        id.transpose()
    }

    fn get(&self, name: &Bound<'_, PyAny>) -> PyResult<BodyId> {
        self.find(name)?
            .ok_or_else(|| PyValueError::new_err(format!("{name} not in collision manager!")))
    }

    fn add(&mut self, name: &Bound<'_, PyAny>, Placed { tree, pose }: Placed) -> PyResult<()> {
        let changed = match self.find(name)? {
            // The pose first: it may be refused.
            Some(id) => {
                let placed = self.scene.set_pose(id, pose);
                placed.and_then(|()| self.scene.set_tree(id, tree))
            }
            None => match self.scene.insert(Body::moving(tree, pose).data(self.added)) {
                Ok(id) => {
                    self.added += 1;
                    self.names.insert(id, name.clone().unbind());
                    self.ids.bind(name.py()).set_item(name, id.to_bits())?;
                    Ok(())
                }
                Err(error) => Err(error),
            },
        };
        changed.map_err(|error| self.error(error))
    }

    /// All objects, or one.
    fn askers(&self, py: Python<'_>, only: Option<BodyId>) -> Vec<Asker> {
        let bodies = self.scene.bodies();
        let bodies = bodies.filter(|&(id, _)| only.is_none_or(|only| id == only));
        let asker = |(id, body): (BodyId, &Body)| Asker {
            name: self.names[&id].clone_ref(py),
            placed: Placed::of(body),
            body: Some(id),
        };
        bodies.map(asker).collect()
    }

    fn name<'py>(&self, py: Python<'py>, id: BodyId) -> Bound<'py, PyAny> {
        self.names[&id].bind(py).clone()
    }
}

/// The bodies that objects which are not in the scene meet, each with the number of the object.
fn meetings(
    scene: &mut Scene,
    askers: &[Asker],
    mode: Mode,
    clock: &dyn Clock,
) -> Result<Vec<(BodyId, usize)>, SceneError> {
    let mut met = Vec::new();
    for (number, asker) in askers.iter().enumerate() {
        let found = scene.overlap(
            &asker.placed.shape(),
            mode,
            Budget::unlimited().clock(clock),
        )?;
        met.extend(found.met.iter().map(|met| (met.body, number)));
        if mode == Mode::Any && !met.is_empty() || clock.is_cancelled() {
            break;
        }
    }
    Ok(met)
}

/// The body closest to an object, the number of the object, and where they are closest.
fn closest(
    scene: &mut Scene,
    askers: &[Asker],
    clock: &dyn Clock,
) -> Result<Option<(BodyId, usize, Closest)>, SceneError> {
    let mut least: Option<(BodyId, usize, Closest)> = None;
    for (number, Asker { placed, body, .. }) in askers.iter().enumerate() {
        if clock.is_cancelled() {
            break;
        }
        let shape = body.map_or(placed.shape(), |body| placed.shape().of_body(body));
        let budget = || Budget::unlimited().clock(clock);
        let met: Vec<_> = {
            let found = scene.overlap(&shape, Mode::All, budget())?;
            // Of two that are both asked about, one asks.
            let asks = |met: &BodyId| askers.len() == 1 || body.is_none_or(|own| own < *met);
            found.met.iter().map(|met| met.body).filter(asks).collect()
        };
        let mut found = Vec::new();
        // Of those that meet, another may be deeper.
        let mut high = least.map_or(f64::INFINITY, |(.., least)| least.distance);
        for &met in &met {
            let pair = Pair([Placed::of(scene.body(met)?), placed.clone()]);
            if let Some(closest) = pair.closest(high, clock) {
                high = high.min(closest.distance);
                found.push((met, closest));
            }
        }
        if met.is_empty() && high > 0.0 {
            let near = scene.closest(&shape, high, budget())?;
            found.extend(near.hit.and_then(|hit| {
                let (points, triangles) = (hit.points?, hit.triangles?);
                let distance = near.high;
                Some((
                    hit.body,
                    Closest {
                        distance,
                        points,
                        triangles,
                    },
                ))
            }));
        }
        for (body, closest) in found {
            if least.is_none_or(|(.., least)| closest.distance < least.distance) {
                least = Some((body, number, closest));
            }
        }
    }
    Ok(least)
}

/// What a call asks for beside its answer.
#[derive(Clone, Copy)]
struct Wants {
    names: bool,
    data: bool,
}

impl Wants {
    /// One meeting is enough unless all are told.
    fn mode(self) -> Mode {
        if self.names || self.data {
            Mode::All
        } else {
            Mode::Any
        }
    }

    /// The answer, and what is asked for beside it.
    fn pack<'py>(
        self,
        answer: impl IntoPyObject<'py>,
        names: impl IntoPyObject<'py>,
        data: impl IntoPyObject<'py>,
        py: Python<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let answer = answer.into_bound_py_any(py)?;
        if !self.names && !self.data {
            return Ok(answer);
        }
        let mut parts = vec![answer];
        if self.names {
            parts.push(names.into_bound_py_any(py)?);
        }
        if self.data {
            parts.push(data.into_bound_py_any(py)?);
        }
        Ok(PyTuple::new(py, parts)?.into_any())
    }

    /// Whether any objects meet, with the names of those that do as `told` makes them of two.
    fn meetings<'py, N: IntoPyObject<'py>>(
        self,
        py: Python<'py>,
        met: Vec<([Bound<'py, PyAny>; 2], Pair)>,
        told: impl Fn([Bound<'py, PyAny>; 2]) -> PyResult<N>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (names, mut data) = (PySet::empty(py)?, Vec::new());
        let is_met = !met.is_empty();
        for (pair, objects) in met {
            if self.data {
                for place in cancellable(py, |clock| objects.places(clock))? {
                    let names = pair.clone().map(Bound::unbind);
                    data.push(Py::new(py, ContactData { names, place })?);
                }
            }
            if self.names {
                names.add(told(pair)?)?;
            }
        }
        self.pack(is_met, names, data, py)
    }

    /// The least distance, infinite without a pair; the names as `told` makes them of two.
    fn least<'py, N: IntoPyObject<'py>>(
        self,
        py: Python<'py>,
        found: Option<([Bound<'py, PyAny>; 2], Closest)>,
        told: impl Fn([Bound<'py, PyAny>; 2]) -> PyResult<N>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Some((pair, closest)) = found else {
            return self.pack(f64::INFINITY, py.None(), py.None(), py);
        };
        let names = pair.clone().map(Bound::unbind);
        let data = Py::new(py, DistanceData { names, closest })?;
        // Names without an order are refused only where they are told.
        let told = self.names.then(|| told(pair)).transpose()?;
        self.pack(closest.distance, told, data, py)
    }
}

/// Two names in their order.
fn sorted<'py>([x, y]: [Bound<'py, PyAny>; 2]) -> PyResult<[Bound<'py, PyAny>; 2]> {
    Ok(if y.lt(&x)? { [y, x] } else { [x, y] })
}

/// Objects by name: which of them meet, or how far apart they are. In place of trimesh.collision.CollisionManager.
///
/// A mesh is a trimesh.Trimesh or a punctual3d.Tree; a tree spares the build where a mesh is asked about again and
/// again.
///
/// A mesh that trimesh takes for convex is a solid: an object inside collides with it, and two of them have a depth.
/// Others are surfaces, without an inside: their contacts have no depth, and those that meet have the distance 0. A
/// tree is what it was built as.
#[pyclass(module = "punctual3d", frozen, subclass)]
pub struct CollisionManager(Mutex<Objects>);

thread_local! {
    /// Whether this thread is in a call.
    static IS_ASKING: Cell<bool> = const { Cell::new(false) };
}

impl CollisionManager {
    /// Lends the objects to a call; a thread waits for those that other threads ask about.
    fn with<R>(
        &self,
        py: Python<'_>,
        call: impl FnOnce(&mut Objects) -> PyResult<R>,
    ) -> PyResult<R> {
        let mut objects = match self.0.try_lock() {
            Ok(objects) => objects,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) if IS_ASKING.get() => {
                return Err(PyRuntimeError::new_err(
                    "the CollisionManager is in use: a handler of a signal cannot ask it",
                ));
            }
            Err(TryLockError::WouldBlock) => self
                .0
                .lock_py_attached(py)
                .unwrap_or_else(PoisonError::into_inner),
        };
        let before = IS_ASKING.replace(true);
        let answer = call(&mut objects);
        IS_ASKING.set(before);
        answer
    }

    /// The objects that others meet.
    fn meetings<'py, N: IntoPyObject<'py>>(
        &self,
        py: Python<'py>,
        askers: &[Asker],
        wants: Wants,
        told: impl Fn([Bound<'py, PyAny>; 2]) -> PyResult<N>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |objects| {
            let scene = &mut objects.scene;
            let met = cancellable(py, |clock| meetings(scene, askers, wants.mode(), clock))?;
            let mut pairs = Vec::new();
            for (id, number) in met.map_err(|error| objects.error(error))? {
                let asker = &askers[number];
                let body = objects
                    .scene
                    .body(id)
                    .map_err(|error| objects.error(error))?;
                let names = [objects.name(py, id), asker.name.bind(py).clone()];
                pairs.push((names, Pair([Placed::of(body), asker.placed.clone()])));
            }
            wants.meetings(py, pairs, told)
        })
    }

    /// The closest pair of objects and others; of objects and one of these.
    fn closest<'py, N: IntoPyObject<'py>>(
        &self,
        py: Python<'py>,
        askers: impl FnOnce(&Objects) -> PyResult<Vec<Asker>>,
        wants: Wants,
        told: impl Fn([Bound<'py, PyAny>; 2]) -> PyResult<N>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |objects| {
            let (askers, scene) = (askers(objects)?, &mut objects.scene);
            let found = cancellable(py, |clock| closest(scene, &askers, clock))?;
            let found = found.map_err(|error| objects.error(error))?;
            let named = found.map(|(id, number, closest)| {
                let names = [objects.name(py, id), askers[number].name.bind(py).clone()];
                (names, closest)
            });
            wants.least(py, named, told)
        })
    }
}

#[pymethods]
impl CollisionManager {
    /// A class that extends this one may take arguments of its own.
    #[new]
    #[classmethod]
    #[pyo3(signature = (*args, **options), text_signature = "()")]
    fn new(
        cls: &Bound<'_, PyType>,
        args: &Bound<'_, PyTuple>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = cls.py();
        if cls.is(py.get_type::<Self>()) && !(args.is_empty() && options.is_none()) {
            return Err(PyTypeError::new_err("CollisionManager takes no arguments"));
        }
        let mut scene = Scene::new();
        scene.set_max_pairs(usize::MAX);
        Ok(Self(Mutex::new(Objects {
            scene,
            ids: PyDict::new(py).unbind(),
            names: HashMap::new(),
            added: 0,
        })))
    }

    /// Pickles and copies hold the objects; trees that they share are shared.
    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>, Bound<'py, PyAny>)> {
        let py = slf.py();
        let mut objects = slf.get().with(py, |objects| {
            let bodies = objects.scene.bodies();
            let object =
                |(id, body): (BodyId, &Body)| (body.data, objects.name(py, id), Placed::of(body));
            Ok(bodies.map(object).collect::<Vec<_>>())
        })?;
        objects.sort_by_key(|&(number, ..)| number);
        let mut trees: HashMap<_, Py<Tree>> = HashMap::new();
        let object = |(_, name, Placed { tree, pose }): (u64, Bound<'py, PyAny>, Placed)| {
            let shared = match trees.entry(Arc::as_ptr(&tree)) {
                Entry::Occupied(made) => made.get().clone_ref(py),
                Entry::Vacant(place) => place
                    .insert(Py::new(
                        py,
                        Tree {
                            arc: tree,
                            refits: 0,
                        },
                    )?)
                    .clone_ref(py),
            };
            Ok((name, shared, matrix(py, &pose)?))
        };
        let objects = objects
            .into_iter()
            .map(object)
            .collect::<PyResult<Vec<_>>>()?;
        Ok((
            slf.get_type().into_any(),
            PyTuple::empty(py),
            objects.into_bound_py_any(py)?,
        ))
    }

    fn __setstate__(&self, objects: Vec<[Bound<'_, PyAny>; 3]>) -> PyResult<()> {
        let mut objects = objects.into_iter();
        objects.try_for_each(|[name, mesh, pose]| self.add_object(&name, &mesh, Some(&pose)))
    }

    /// Adds an object, or replaces that of the same name; transform: (4, 4), rigid.
    #[pyo3(signature = (name, mesh, transform=None))]
    fn add_object(
        &self,
        name: &Bound<'_, PyAny>,
        mesh: &Bound<'_, PyAny>,
        transform: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let placed = Placed::new(mesh, transform)?;
        self.with(name.py(), |objects| objects.add(name, placed))
    }

    /// Removes an object. Raises ValueError if there is none of this name.
    fn remove_object(&self, name: &Bound<'_, PyAny>) -> PyResult<()> {
        self.with(name.py(), |objects| {
            let id = objects.get(name)?;
            objects.ids.bind(name.py()).del_item(name)?;
            objects.names.remove(&id);
            let removed = objects.scene.remove(id).map(drop);
            removed.map_err(|error| objects.error(error))
        })
    }

    /// Moves an object. Raises ValueError if there is none of this name.
    fn set_transform(&self, name: &Bound<'_, PyAny>, transform: Transform) -> PyResult<()> {
        self.with(name.py(), |objects| {
            let placed = objects.scene.set_pose(objects.get(name)?, transform.0);
            placed.map_err(|error| objects.error(error))
        })
    }

    /// Whether an object meets any of those here; then the set of their names, and a list of ContactData.
    #[pyo3(signature = (mesh, transform=None, return_names=false, return_data=false))]
    fn in_collision_single<'py>(
        &self,
        mesh: &Bound<'py, PyAny>,
        transform: Option<&Bound<'py, PyAny>>,
        return_names: bool,
        return_data: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wants = Wants {
            names: return_names,
            data: return_data,
        };
        let askers = Asker::external(mesh, transform)?;
        self.meetings(mesh.py(), &askers, wants, |[name, _]| Ok(name))
    }

    /// Whether any two objects meet; then the set of their names, each pair sorted, and a list of ContactData.
    #[pyo3(signature = (return_names=false, return_data=false))]
    fn in_collision_internal<'py>(
        &self,
        py: Python<'py>,
        return_names: bool,
        return_data: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wants = Wants {
            names: return_names,
            data: return_data,
        };
        self.with(py, |objects| {
            let scene = &mut objects.scene;
            let meets = cancellable(py, |clock| {
                let mut work = match wants.mode() {
                    Mode::Any => LOOK_WORK,
                    Mode::All => u64::MAX,
                };
                loop {
                    let report = scene.detect(Budget::work(work).clock(clock));
                    // Those with radii are within them.
                    let meets = report.intersecting + report.contained + report.within > 0;
                    let is_done = report.is_whole() && report.undecided() == 0;
                    if is_done || meets && work < u64::MAX || clock.is_cancelled() {
                        return meets;
                    }
                    work = work.saturating_mul(2);
                }
            })?;
            if wants.mode() == Mode::Any {
                return meets.into_bound_py_any(py);
            }
            let mut pairs = Vec::new();
            for pair in objects.scene.report().meeting_pairs() {
                let body = |id| Ok((id, objects.scene.body(id)?));
                let bodies: Result<_, SceneError> =
                    body(pair.a).and_then(|a| Ok([a, body(pair.b)?]));
                let mut bodies = bodies.map_err(|error| objects.error(error))?;
                bodies.sort_by_key(|(_, body)| body.data);
                let names = bodies.map(|(id, _)| objects.name(py, id));
                pairs.push((names, Pair(bodies.map(|(_, body)| Placed::of(body)))));
            }
            wants.meetings(py, pairs, |pair| PyTuple::new(py, sorted(pair)?))
        })
    }

    /// Whether any object meets one of another manager; then the set of their names, and a list of ContactData.
    #[pyo3(signature = (other_manager, return_names=false, return_data=false))]
    fn in_collision_other<'py>(
        &self,
        py: Python<'py>,
        other_manager: &Self,
        return_names: bool,
        return_data: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wants = Wants {
            names: return_names,
            data: return_data,
        };
        let askers = other_manager.with(py, |objects| Ok(objects.askers(py, None)))?;
        self.meetings(py, &askers, wants, |pair| PyTuple::new(py, pair))
    }

    /// The distance of an object to the closest of those here; then its name, and DistanceData.
    #[pyo3(signature = (mesh, transform=None, return_name=false, return_data=false))]
    fn min_distance_single<'py>(
        &self,
        mesh: &Bound<'py, PyAny>,
        transform: Option<&Bound<'py, PyAny>>,
        return_name: bool,
        return_data: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wants = Wants {
            names: return_name,
            data: return_data,
        };
        let askers = Asker::external(mesh, transform)?;
        self.closest(mesh.py(), |_| Ok(askers), wants, |[name, _]| Ok(name))
    }

    /// The least distance of two objects, or of the named one to the others; then their names, and DistanceData.
    #[pyo3(signature = (name=None, return_names=false, return_data=false))]
    fn min_distance_internal<'py>(
        &self,
        py: Python<'py>,
        name: Option<&Bound<'py, PyAny>>,
        return_names: bool,
        return_data: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wants = Wants {
            names: return_names,
            data: return_data,
        };
        let askers = |objects: &Objects| {
            let only = name.map(|name| objects.get(name)).transpose()?;
            Ok(objects.askers(py, only))
        };
        self.closest(py, askers, wants, |pair| PyTuple::new(py, sorted(pair)?))
    }

    /// The least distance to an object of another manager; then the pair of names, and DistanceData.
    #[pyo3(signature = (other_manager, return_names=false, return_data=false))]
    fn min_distance_other<'py>(
        &self,
        py: Python<'py>,
        other_manager: &Self,
        return_names: bool,
        return_data: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wants = Wants {
            names: return_names,
            data: return_data,
        };
        let mut askers = other_manager.with(py, |objects| Ok(objects.askers(py, None)))?;
        askers.iter_mut().for_each(|asker| asker.body = None);
        self.closest(py, |_| Ok(askers), wants, |pair| PyTuple::new(py, pair))
    }
}
