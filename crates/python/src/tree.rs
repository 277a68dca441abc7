//! Meshes with their trees.

use crate::arrays::{
    Transform, cloud, column, grid, mesh, numbers, point_of_mesh, table, vectors, vectors_or_one,
};
use crate::batch::{each, workers};
use crate::errors::{file_error, not_negative, not_solid, point_error, value_error};
use crate::interrupt::in_background;
use crate::limit::Limit;
use crate::query::with_workspace;
use numpy::{PyArray1, PyArray2};
use punctual::glam::DMat3;
use punctual::points::PointBounds;
use punctual::tree::{ShapeError, Solid, SolidError};
use punctual::{Budget, BuildOptions, DepthCamera, Mesh, Pose, Query};
use punctual_io::{Loaded, ReadOptions};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyUserWarning};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyType};
use std::ffi::CString;
use std::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;

/// A triangle mesh with its bounding volume tree. Built once, used in any number of queries, from any thread.
///
/// vertices: (V, 3) numbers, in one unit of length, kept as f32 where that is exact and as f64 otherwise. faces: (F, 3)
/// integers of any type. effort: "fast" or "normal", how much time the build may take. extremes: whether to
/// keep the corners that may be the farthest along a direction, so that a `Scene` tells convex bodies that are close apart
/// without a search. solid: whether closed components bound solids; those that are inside out are turned.
///
/// solid: "no", a surface without an inside; "keep", a solid, oriented as its triangles are; "flip", a solid of which parts that
/// are inside out are reversed. Degenerate triangles are what they are. Takes O(F log F), about 1 us a triangle.
/// Raises ValueError for an index out of range and for coordinates that are not finite, with the place.
#[pyclass(module = "punctual3d")]
pub struct Tree {
    pub arc: Arc<punctual::Tree>,
    /// How often its vertices were moved: what is known of it holds for one number of these.
    pub refits: u64,
}

impl Tree {
    /// The tree of a mesh that is generated.
    pub fn of(py: Python<'_>, mesh: impl FnOnce() -> Mesh + Send + 'static) -> PyResult<Self> {
        in_background(py, || punctual::Tree::new(mesh())).map(Self::from)
    }
}

impl From<punctual::Tree> for Tree {
    fn from(tree: punctual::Tree) -> Self {
        Arc::new(tree).into()
    }
}

impl From<Arc<punctual::Tree>> for Tree {
    fn from(arc: Arc<punctual::Tree>) -> Self {
        Self { arc, refits: 0 }
    }
}

fn options(effort: &str, extremes: bool, solid: &str) -> PyResult<BuildOptions> {
    let options = match effort {
        "fast" => BuildOptions::fast_build(),
        "normal" => BuildOptions::default(),
        _ => {
            return Err(value_error(format_args!(
                "effort: {effort:?} is none of fast, normal"
            )));
        }
    };
    let solid: Solid = solid
        .parse()
        .map_err(|error| value_error(format_args!("solid: {error}")))?;
    Ok(options.extremes(extremes).solid(solid))
}

/// The tree of a shape, or why it is refused.
fn shape(tree: Result<punctual::Tree, ShapeError>) -> PyResult<Tree> {
    tree.map(Tree::from).map_err(|error| match error {
        ShapeError::Mesh(error) => point_of_mesh(error),
        error => value_error(error),
    })
}

/// Volume, centre of mass and inertia tensor.
type MassArrays<'py> = (f64, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Points, their distances, and the triangles that they are on.
type ClosestPoints<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
);

/// A build of a smaller mesh takes less time than the user waits for the end of a call.
const LARGE_MESH: usize = 50_000;

/// The same of the bytes of a tree.
const LARGE_BYTES: usize = 20_000_000;

/// Builds without the interpreter's lock; the user can cancel the call.
fn built(py: Python<'_>, mesh: Mesh, options: BuildOptions) -> PyResult<punctual::Tree> {
    let is_large = mesh.len() > LARGE_MESH;
    let build = move || punctual::Tree::with_options(mesh, &options);
    if is_large {
        in_background(py, build)
    } else {
        Ok(py.detach(build))
    }
}

/// Warns of one thing (UserWarning).
pub fn warn(py: Python<'_>, what: String) -> PyResult<()> {
    let text = CString::new(what)?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

/// What is known of many points.
fn points_of(
    py: Python<'_>,
    tree: &punctual::Tree,
    points: &Bound<'_, PyAny>,
    measures: bool,
) -> PyResult<Vec<PointBounds>> {
    let points = vectors_or_one(points, "points")?;
    let query = if measures {
        Query::signed_distances(tree, &points)
    } else {
        Query::windings(tree, &points)
    };
    let query = query.map_err(point_error)?;
    Limit::None.run(py, |clock| {
        with_workspace(|workspace| {
            let _ = query.run(workspace, Budget::unlimited().clock(clock));
            workspace.points().to_vec()
        })
    })
}

/// The error of a tree that another thread asks or refits.
fn in_use(tree: &Bound<'_, Tree>, why: &str) -> PyErr {
    let name = match tree.try_borrow() {
        Ok(tree) => tree.__repr__(),
        Err(_) => "<punctual3d.Tree>".into(),
    };
    let at = tree.as_ptr();
    PyRuntimeError::new_err(format!(
        "{name} at {at:p} is in use: {why} by another thread"
    ))
}

/// An argument that is a tree, or a mesh that one is built from for this call.
pub struct Surface<'py>(pub PyRef<'py, Tree>);

impl Deref for Surface<'_> {
    type Target = Tree;

    fn deref(&self) -> &Tree {
        &self.0
    }
}

impl<'py> FromPyObject<'_, 'py> for Surface<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(tree) = given.cast::<Tree>() {
            let asked = tree.try_borrow();
            return asked
                .map(Self)
                .map_err(|_| in_use(&tree, "it is being refitted"));
        }
        let py = given.py();
        let part = |name| given.getattr_opt(name);
        let (Some(vertices), Some(faces)) =
            (part(intern!(py, "vertices"))?, part(intern!(py, "faces"))?)
        else {
            let kind = given.get_type().name()?;
            return Err(PyTypeError::new_err(format!(
                "{kind} is neither a punctual3d.Tree nor a mesh with vertices and faces, such as a trimesh.Trimesh"
            )));
        };
        let tree = Tree::from(built(
            py,
            mesh(&vertices, &faces)?,
            BuildOptions::default(),
        )?);
        Ok(Self(Bound::new(py, tree)?.try_borrow()?))
    }
}

#[pymethods]
impl Tree {
    #[new]
    #[pyo3(signature = (vertices, faces, *, effort="normal", extremes=false, solid="no"))]
    fn build(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        effort: &str,
        extremes: bool,
        solid: &str,
    ) -> PyResult<Self> {
        let options = options(effort, extremes, solid)?;
        built(py, mesh(vertices, faces)?, options).map(Self::from)
    }

    /// The tree of a trimesh.Trimesh, or of anything else with `vertices` and `faces`. All calls take such a mesh in
    /// place of a
    /// tree, but then it is built in each of them.
    #[classmethod]
    #[pyo3(signature = (mesh, *, effort="normal", extremes=false, solid="no"))]
    pub fn from_trimesh(
        _: &Bound<'_, PyType>,
        mesh: &Bound<'_, PyAny>,
        effort: &str,
        extremes: bool,
        solid: &str,
    ) -> PyResult<Self> {
        let (vertices, faces) = (mesh.getattr("vertices")?, mesh.getattr("faces")?);
        Self::build(mesh.py(), &vertices, &faces, effort, extremes, solid)
    }

    /// The tree of a mesh file: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or of a point cloud: .xyz, .pts, .asc, .txt,
    /// .csv, .pcd or .npy; or one of these with .gz. Warns (UserWarning) of what was passed over in it, one line a kind. Raises FileNotFoundError if there is no such file, and OSError if it cannot be
    /// read or is damaged, with the place.
    ///
    /// scale: factors of the coordinates along x, y and z, (3,), such as (1, 1, -1) to mirror.
    #[classmethod]
    #[pyo3(signature = (path, *, scale=[1.0; 3], effort="normal", extremes=false, solid="no"))]
    fn load(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        path: PathBuf,
        scale: [f64; 3],
        effort: &str,
        extremes: bool,
        solid: &str,
    ) -> PyResult<Self> {
        let options = options(effort, extremes, solid)?;
        if let Some(factor) = scale
            .iter()
            .find(|factor| **factor == 0.0 || !factor.is_finite())
        {
            return Err(value_error(format_args!(
                "scale {factor}, must be finite and not 0"
            )));
        }
        let file = path.clone();
        let load = move || {
            let read = ReadOptions::default().scale_axes(scale);
            punctual_io::load_with(&file, &read).map(|Loaded { mesh, notices, .. }| {
                (punctual::Tree::with_options(mesh, &options), notices)
            })
        };
        let (tree, notices) = in_background(py, load)?.map_err(|error| file_error(&error))?;
        for notice in notices {
            warn(py, notice.in_file(&path))?;
        }
        Ok(tree.into())
    }

    /// The tree of a point cloud, or of equal balls: points, (N, 3), of which those in f32 are kept to the bit, and their
    /// radius. It is asked as that of a mesh is; where answers name triangles, they name points. Takes about .05 us
    /// a point, with effort "normal" .15 us, and queries take two thirds of the time.
    ///
    /// Raises ValueError for a point that is not finite, with its row, and for a radius that is negative or not finite.
    #[classmethod]
    #[pyo3(signature = (points, radius=0.0, effort="fast"))]
    fn from_points(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
        radius: f64,
        effort: &str,
    ) -> PyResult<Self> {
        let mesh = cloud(points)?;
        let tree = built(py, mesh, options(effort, false, "no")?)?;
        tree.with_radius(radius)
            .map(Self::from)
            .map_err(value_error)
    }

    /// The cloud of a depth image, (rows, columns), of a pinhole camera: its focal lengths and principal point in pixels,
    /// (fx, fy, cx, cy), and what one unit of depth is in the unit of the points, such as .001. The point of a pixel is in
    /// the frame of the camera: x to the right, y down, z forward. Pixels whose depth is 0, negative or not finite are
    /// passed over. The radius is that of `from_points`. Raises ValueError, which names the argument.
    #[classmethod]
    #[pyo3(signature = (depths, intrinsics, scale=1.0, radius=0.0))]
    fn from_depth(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        depths: &Bound<'_, PyAny>,
        intrinsics: &Bound<'_, PyAny>,
        scale: f64,
        radius: f64,
    ) -> PyResult<Self> {
        let (depths, columns) = grid(depths, "depths")?;
        let [fx, fy, cx, cy] = numbers(intrinsics, "intrinsics")?;
        let camera = DepthCamera {
            size: [columns, depths.len() / columns.max(1)],
            focal: [fx, fy],
            center: [cx, cy],
            scale,
        };
        let (mut points, depths) = (Vec::new(), depths.iter().map(|&depth| depth as f32));
        let found = camera.points(&depths.collect::<Vec<_>>(), &mut points);
        found.map_err(value_error)?;
        let mesh = Mesh::from_points(points).map_err(value_error)?;
        let tree = built(py, mesh, BuildOptions::fast_build())?;
        tree.with_radius(radius)
            .map(Self::from)
            .map_err(value_error)
    }

    /// The tree of a ball around the origin: a point with a radius. As of all shapes, lengths are 1e-150 to 1e150; others
    /// raise ValueError, which names the argument.
    #[staticmethod]
    fn ball(radius: f64) -> PyResult<Self> {
        shape(punctual::Tree::ball(radius))
    }

    /// The tree of a capsule: all points no farther than radius from a segment of this length along z, around the origin.
    /// The length may be 0.
    #[staticmethod]
    fn capsule(radius: f64, length: f64) -> PyResult<Self> {
        shape(punctual::Tree::capsule(radius, length))
    }

    /// The tree of a solid box around the origin: its lengths along x, y and z, (3,). radius: of rounded edges, within these
    /// lengths.
    #[staticmethod]
    #[pyo3(signature = (size, radius=0.0))]
    fn r#box(size: &Bound<'_, PyAny>, radius: f64) -> PyResult<Self> {
        let size: [f64; 3] = numbers(size, "size")?;
        shape(match radius {
            0.0 => punctual::Tree::cuboid(size),
            radius => punctual::Tree::rounded_cuboid(size, radius),
        })
    }

    /// The tree of a solid cylinder along z, around the origin: a prism of 128 sides, which holds the true one and is
    /// within 3.02e-4 of the radius of it.
    #[staticmethod]
    fn cylinder(radius: f64, length: f64) -> PyResult<Self> {
        shape(punctual::Tree::cylinder(radius, length))
    }

    /// The tree of a solid cone along z: its base is at -length / 2, its tip at length / 2. A pyramid of 128 sides, within
    /// 3.02e-4 of the radius as a cylinder.
    #[staticmethod]
    fn cone(radius: f64, length: f64) -> PyResult<Self> {
        shape(punctual::Tree::cone(radius, length))
    }

    /// The tree of the convex hull of points, (N, 3), a solid; exact. Raises ValueError for a point that is not finite, with
    /// its row, and for points in one plane.
    #[staticmethod]
    fn hull(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = vectors(points, "points")?;
        shape(py.detach(|| punctual::Tree::hull(points)))
    }

    /// The tree of the surface over a grid, which faces +z: heights, (rows, columns), and the distances of columns along x
    /// and of rows along y, (2,). The first height is that at the origin; heights[row, column] is vertex
    /// row * columns + column. Raises ValueError for a height that is not finite, with its place.
    #[staticmethod]
    fn height_field(
        py: Python<'_>,
        heights: &Bound<'_, PyAny>,
        spacing: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (heights, columns) = grid(heights, "heights")?;
        let spacing = numbers(spacing, "spacing")?;
        if let Some(at) = heights.iter().position(|height| !height.is_finite()) {
            let (row, column) = (at / columns, at % columns);
            let fault = format!("heights[{row}, {column}] is {}", heights[at]);
            return Err(value_error(fault));
        }
        shape(py.detach(|| punctual::Tree::height_field(heights, columns, spacing)))
    }

    /// A copy of the tree, thickened by a ball of this radius: all questions are about the points no farther than that from
    /// its triangles, or points. So a point becomes a ball, a segment a capsule. It is in place of an earlier radius. Raises
    /// ValueError for one that is negative or not finite.
    fn with_radius(&self, py: Python<'_>, radius: f64) -> PyResult<Self> {
        let thick = py.detach(|| punctual::Tree::clone(&self.arc).with_radius(radius));
        thick.map(Self::from).map_err(value_error)
    }

    /// By how much the tree is thickened: 0 unless `with_radius` or `from_points` said otherwise.
    #[getter]
    fn radius(&self) -> f64 {
        self.arc.radius()
    }

    /// Whether it is the tree of a point cloud, without triangles.
    #[getter]
    fn is_cloud(&self) -> bool {
        self.arc.mesh().is_cloud()
    }

    /// The tree that `to_bytes` wrote. Raises ValueError if the bytes are not one, or damaged.
    #[classmethod]
    fn from_bytes(_: &Bound<'_, PyType>, py: Python<'_>, bytes: PyBackedBytes) -> PyResult<Self> {
        let is_large = bytes.len() > LARGE_BYTES;
        let read = move || punctual::Tree::from_bytes(&bytes);
        let tree = if is_large {
            in_background(py, read)?
        } else {
            py.detach(read)
        };
        tree.map(Self::from).map_err(value_error)
    }

    /// The tree as bytes, the same on every machine. Pickles hold them.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &py.detach(|| self.arc.to_bytes()))
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((
            py.get_type::<Self>().getattr("from_bytes")?,
            (self.to_bytes(py),),
        ))
    }

    /// Moves the vertices: (V, 3), as many as before. Takes a fraction of the time of a build. Copies of this tree in
    /// scenes keep the old ones. Raises RuntimeError while another thread asks about the tree.
    fn refit(slf: &Bound<'_, Self>, vertices: &Bound<'_, PyAny>) -> PyResult<()> {
        let vertices = vectors(vertices, "vertices")?;
        let mut refitted = slf
            .try_borrow_mut()
            .map_err(|_| in_use(slf, "it is asked about"))?;
        let tree = &mut refitted.arc;
        slf.py()
            .detach(|| Arc::make_mut(tree).refit_f64(&vertices))
            .map_err(value_error)?;
        refitted.refits += 1;
        Ok(())
    }

    /// The tree of the mesh scaled along x, y and z, (3,): an instance, made in a part of a build's time. An odd number of
    /// negative factors mirrors it; faces look outwards as before. Raises ValueError for factors that are 0, not finite or
    /// too large.
    fn scaled(&self, py: Python<'_>, factors: [f64; 3]) -> PyResult<Self> {
        let scaled = py.detach(|| self.arc.scaled(factors));
        scaled.map(Self::from).map_err(value_error)
    }

    /// Pairs of triangles that intersect beyond the corners that they share, (N, 2), sorted; exact. Triangles that share an
    /// edge count if they are folded flat on each other, a triangle that is there twice counts. Corners are shared if
    /// they are at the same place.
    fn self_intersections<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let pairs = py.detach(|| self.arc.self_intersections());
        table(py, pairs)
    }

    /// Factor by which refits have loosened the boxes since the build, 1 after it. Queries take about its square root as
    /// long as those of a new tree. A build takes as long as seven to ten refits: it pays once the queries since the last
    /// one have lost as much, 1 - degradation**-.5 of their time.
    #[getter]
    fn degradation(&self) -> f32 {
        self.arc.degradation()
    }

    /// The vertices, (V, 3), exact where triangles use them.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let mesh = self.arc.mesh();
        table(
            py,
            (0..mesh.vertex_count()).map(|vertex| mesh.vertex(vertex).to_array()),
        )
    }

    /// The triangles, (F, 3), in the order given.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        table(py, self.arc.mesh().triangles().iter().copied())
    }

    /// Least and greatest corner of the box around all triangles, or points, (2, 3), without the radius; None if there
    /// are none.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let mesh = self.arc.mesh();
        let corners = [mesh.aabb().min.to_array(), mesh.aabb().max.to_array()];
        (!mesh.is_empty()).then(|| table(py, corners)).transpose()
    }

    /// Bytes of memory that the tree takes, its mesh included.
    #[getter]
    fn nbytes(&self) -> usize {
        self.arc.stats().bytes()
    }

    /// The alpha of each node, (N,), as stored at build and refit: the factor by which the volumes of boxes below it shrink
    /// per binary level, 0 to 1. The root's first, each node before those below it.
    #[getter]
    fn node_alpha<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        let alphas = self.arc.subtrees().map(|subtree| subtree.alpha_product());
        column(py, alphas.collect())
    }

    /// Number of nodes on each level, (depth,); the root's first.
    #[getter]
    fn nodes_per_level<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<usize>> {
        column(py, self.arc.stats().nodes_per_level)
    }

    /// Mean alpha of the nodes on each level, (depth, 3): per axis of their boxes.
    #[getter]
    fn alpha_per_level<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        table(
            py,
            self.arc
                .stats()
                .alpha_per_level
                .iter()
                .map(|alpha| alpha.to_array()),
        )
    }

    /// Mean number of binary levels below the nodes on each level, (depth,): log2 of their triangles.
    #[getter]
    fn levels_per_level<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, self.arc.stats().levels_per_level)
    }

    /// Levels of nodes.
    #[getter]
    fn depth(&self) -> usize {
        self.arc.root().map_or(0, |root| root.height())
    }

    /// Whether points are inside the solid, or on its surface: (N,) bool. Exact for closed meshes; of open ones, whether
    /// the winding number is above 1/2, and False where that cannot be told.
    ///
    /// points: (N, 3), in the frame of the mesh. Raises ValueError if the tree is no solid,
    /// and for a point that is not finite, with the row.
    fn contains<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'_, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let found = points_of(py, &self.arc, points, false)?;
        let inside = found.iter().map(|point| point.inside == Some(true));
        Ok(column(py, inside.collect()))
    }

    /// Distances of points from the surface, negative inside the solid: (N,) float64, off by no more than some roundings. NaN
    /// where it cannot be told whether a point is inside, and infinite for a mesh without triangles.
    ///
    /// points: (N, 3), in the frame of the mesh. Raises ValueError if the tree is no solid,
    /// and for a point that is not finite, with the row. trimesh has the other sign.
    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'_, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = points_of(py, &self.arc, points, true)?;
        let distance = |point: &PointBounds| match (point.inside, point.distance) {
            (None, _) => f64::NAN,
            (_, None) => f64::INFINITY,
            (_, Some(distance)) => 0.5 * (distance.low + distance.high),
        };
        Ok(column(py, found.iter().map(distance).collect()))
    }

    /// The closest points of the surface to points, as `trimesh.proximity.closest_point` tells them: (N, 3) float64;
    /// their distances, (N,) float64, off by no more than some roundings; and their triangles, (N,) int64. Of a mesh
    /// without triangles NaN, infinite and -1.
    ///
    /// points: (N, 3), in the frame of the mesh, which need not be a solid. threads: how many share them; the answers
    /// are the same on any number. progress: as of `collide_batch`. Raises ValueError for a point that is not finite,
    /// with the row.
    #[pyo3(signature = (points, *, threads=1, progress=None))]
    fn closest_points<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'_, PyAny>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<ClosestPoints<'py>> {
        let points = vectors_or_one(points, "points")?;
        let place = |(row, &point)| {
            let pose = Pose::new(DMat3::IDENTITY, point);
            pose.map_err(|fault| value_error(format_args!("point {row}: {fault}")))
        };
        let places: Vec<Pose> = points
            .iter()
            .enumerate()
            .map(place)
            .collect::<PyResult<_>>()?;
        let point = Mesh::new([[0.0f32; 3]; 3], [[0, 1, 2]]).map_err(value_error)?;
        let point = punctual::Tree::new(point);
        let workers = workers(threads, places.len(), None)?;
        let found = each(py, places.len(), progress, workers, |worker, clock, at| {
            let query = Query::distance(&self.arc, &point, places[at]).absolute_tolerance(0.0);
            let query = query.relative_tolerance(0.0);
            let budget = Budget::unlimited().clock(clock);
            Ok(query.run(&mut worker.workspace, budget).value.nearest)
        })?;
        let nearest = found
            .iter()
            .zip(&points)
            .map(|(found, &point)| match found {
                Some(found) => {
                    let [on_surface, _] = found.points;
                    let distance = on_surface.distance(point.into());
                    (
                        on_surface.to_array(),
                        distance,
                        i64::from(found.triangles[0]),
                    )
                }
                None => ([f64::NAN; 3], f64::INFINITY, -1),
            });
        let nearest: Vec<_> = nearest.collect();
        Ok((
            table(py, nearest.iter().map(|&(point, ..)| point))?,
            column(
                py,
                nearest.iter().map(|&(_, distance, _)| distance).collect(),
            ),
            column(py, nearest.iter().map(|&(.., triangle)| triangle).collect()),
        ))
    }

    /// The points of a cloud no farther than a distance from the surface of a tree, or mesh, that lies at T, (4, 4): their
    /// rows, (N,) int64, ascending, each once. Radii of both add to the distance. A point deep inside of a solid is not
    /// near its surface. Raises ValueError if this is no cloud, and for a distance that is negative or no number.
    #[pyo3(signature = (other, T=None, *, distance=0.0))]
    #[expect(non_snake_case, reason = "the argument of the Python function")]
    fn points_within<'py>(
        &self,
        py: Python<'py>,
        other: Surface<'_>,
        T: Option<Transform>,
        distance: f64,
    ) -> PyResult<Bound<'py, PyArray1<i64>>> {
        not_negative([("distance", Some(distance))])?;
        let (pose, other) = (T.unwrap_or_default().0, &other.arc);
        let query = Query::points_within(&self.arc, other, pose, distance);
        let query = query.map_err(point_error)?;
        let points = self.arc.mesh().len();
        let mut rows: Vec<i64> = Limit::None.run(py, |clock| {
            with_workspace(|workspace| {
                workspace.reserve_near_points(points);
                let _ = query.run(workspace, Budget::unlimited().clock(clock));
                workspace.drain_near_points().map(i64::from).collect()
            })
        })?;
        rows.sort_unstable();
        Ok(column(py, rows))
    }

    /// Number of edges of the solid without an opposite one, 0 if it is closed; None if the tree is no solid.
    #[getter]
    fn open_edges(&self) -> Option<usize> {
        self.arc.solid().map(|solid| solid.open_edges())
    }

    /// Volume of the solid, negative if it is inside out; None if the tree is no solid.
    #[getter]
    fn volume(&self) -> Option<f64> {
        self.arc.solid().map(|solid| solid.volume())
    }

    /// Volume, centre of mass (3,) and inertia tensor about it (3, 3) of the closed solid, of density 1. Raises ValueError if
    /// the tree is no solid, has open edges, or is inside out.
    fn mass_properties<'py>(&self, py: Python<'py>) -> PyResult<MassArrays<'py>> {
        let found = py.detach(|| self.arc.mass_properties());
        let found = found.map_err(|error| match error {
            SolidError::NotSolid => not_solid(),
            error => value_error(error),
        })?;
        let center = column(py, found.center.to_array().into());
        let inertia = table(py, found.inertia.to_cols_array_2d())?;
        Ok((found.volume, center, inertia))
    }

    /// Number of triangles; of a cloud, of points.
    fn __len__(&self) -> usize {
        self.arc.mesh().len()
    }

    /// Whether all of both is the same: vertices, faces and how the tree was built.
    fn __eq__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let Ok(other) = other.cast::<Self>() else {
            return Ok(py.NotImplemented());
        };
        let (tree, other) = (&self.arc, &other.try_borrow()?.arc);
        let is_same = Arc::ptr_eq(tree, other)
            || tree.mesh().len() == other.mesh().len()
                && py.detach(|| tree.to_bytes() == other.to_bytes());
        Ok(is_same.into_pyobject(py)?.to_owned().into_any().unbind())
    }

    // A refit keeps this.
    fn __hash__(&self) -> usize {
        self.arc.mesh().len()
    }

    fn __repr__(&self) -> String {
        let mesh = self.arc.mesh();
        let what = if mesh.is_cloud() {
            "points"
        } else {
            "triangles"
        };
        let radius = match self.radius() {
            0.0 => String::new(),
            radius => format!(", radius {radius}"),
        };
        format!("<punctual3d.Tree of {} {what}{radius}>", mesh.len())
    }
}
