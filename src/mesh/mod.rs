//! Triangle meshes: validated once at construction, exact afterwards.
//!
//! A mesh is a triangle soup: a surface without an inside. Vertices keep every bit of the input, as
//! f32 where that is exact and as f64 only where the mesh needs it. Triangles may be degenerate,
//! share vertices or overlap. Vertices that no triangle uses keep their indices but are never read,
//! so they may hold any value. A point cloud is a mesh of vertices alone: each point counts as a
//! triangle without extent.

mod bytes;
pub mod depth;
pub mod shapes;
mod survey;
mod vertices;

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;

use glam::DVec3;

pub(crate) use bytes::TRIANGLE_BYTES;
use punctual_geom::Aabb;
pub(crate) use survey::{Survey, survey};
pub(crate) use vertices::Vertices;
use vertices::{all_in_use, check_vertex, is_f32_exact};

/// Maximum number of triangles. It leaves two spare bits in a 32-bit id, and keeps the number of
/// nodes of a binary tree below 2^31.
const TRIANGLE_LIMIT: usize = 1 << 30;

/// An indexed triangle surface with finite vertices. Only [`crate::Tree::refit`] and
/// [`crate::tree::Solid::Flip`] change it.
///
/// All coordinates are in one length unit, chosen by the caller, and in the frame of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vertices,
    triangles: Box<[[u32; 3]]>,
    aabb: Aabb,
    all_in_use: bool,
    is_cloud: bool,
    least_exponent: i32,
}

/// Reasons why a [`Mesh`] is refused.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// A triangle refers to a vertex that does not exist.
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// Its corner: 0, 1 or 2.
        corner: usize,
        /// The vertex index of that corner.
        index: u32,
        /// Number of vertices of the mesh.
        vertices: usize,
    },
    /// A coordinate of a vertex in use is NaN or infinite.
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Axis of the coordinate: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// A coordinate of a vertex in use is larger than 2^1000 in magnitude.
    TooLarge {
        /// Index of the vertex.
        vertex: usize,
        /// Axis of the coordinate: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// The number of new vertices differs from the mesh's ([`crate::Tree::refit`]).
    VertexCount {
        /// Number of new vertices.
        given: usize,
        /// Number of vertices of the mesh.
        vertices: usize,
    },
    /// A factor of [`Mesh::scaled_by`] or [`crate::Tree::scaled`] is 0, infinite or NaN.
    Factor {
        /// Axis of the factor: 0, 1, 2 for x, y, z.
        axis: usize,
        /// The factor.
        factor: f64,
    },
    /// Factors of [`crate::Tree::scaled`] for a tree with a radius differ in more than their signs,
    /// or the radius would exceed 2^1000.
    Radius {
        /// The factors.
        factors: [f64; 3],
    },
    /// The mesh has more than 2^30 triangles.
    TooManyTriangles {
        /// Number of triangles.
        triangles: usize,
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange {
                triangle,
                corner,
                index,
                vertices,
            } => {
                write!(
                    f,
                    "corner {corner} of triangle {triangle} is vertex {index}, but there are {vertices} vertices"
                )
            }
            Self::NotFinite { vertex, axis } => {
                write!(f, "vertex {vertex} is not finite along axis {axis}")
            }
            Self::TooLarge { vertex, axis } => {
                write!(f, "vertex {vertex} exceeds 2^1000 along axis {axis}")
            }
            Self::VertexCount { given, vertices } => {
                write!(f, "{given} new vertices for a mesh with {vertices}")
            }
            Self::Factor { axis, factor } => {
                write!(
                    f,
                    "factor {factor} along axis {axis}, must be finite and not 0"
                )
            }
            Self::Radius { factors } => {
                write!(
                    f,
                    "factors {factors:?} for a tree with a radius, must be equal but for signs"
                )
            }
            Self::TooManyTriangles { triangles } => {
                write!(
                    f,
                    "{triangles} triangles or points, but at most 2^30 are allowed"
                )
            }
        }
    }
}

impl core::error::Error for MeshError {}

impl Mesh {
    /// A mesh from f32 vertices and corner indices, kept to the bit. There may be no triangles.
    ///
    /// Takes time linear in vertices and triangles.
    ///
    /// # Errors
    /// Reports the first fault in the order of the triangles; does not check vertices that no
    /// triangle uses.
    ///
    /// ```
    /// let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = punctual::Mesh::new(corner, [[0, 1, 2]])?;
    /// assert_eq!(mesh.len(), 1);
    /// # Ok::<(), punctual::MeshError>(())
    /// ```
    pub fn new(
        vertices: impl IntoIterator<Item: Into<[f32; 3]>>,
        triangles: impl IntoIterator<Item = [u32; 3]>,
    ) -> Result<Self, MeshError> {
        let vertices = vertices.into_iter().map(Into::into).collect();
        Self::checked(Vertices::F32(vertices), triangles.into_iter().collect())
    }

    /// A mesh from f64 vertices and corner indices. There may be no triangles.
    ///
    /// The mesh is stored as f32 if that keeps every bit of the vertices in use; unused ones are
    /// rounded. Otherwise it is stored as f64, which takes more memory and is somewhat slower.
    /// Takes time linear in vertices and triangles.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_f64(
        vertices: impl IntoIterator<Item: Into<[f64; 3]>>,
        triangles: impl IntoIterator<Item = [u32; 3]>,
    ) -> Result<Self, MeshError> {
        let vertices = vertices.into_iter().map(Into::into).collect();
        let mesh = Self::checked(Vertices::F64(vertices), triangles.into_iter().collect())?;
        Ok(mesh.narrowed())
    }

    /// A point cloud from f32 points, kept to the bit. Point `i` is vertex `i`, and counts as
    /// triangle `i` without extent ([`triangle`](Self::triangle)). There may be no points, and
    /// points may be equal. Takes linear time.
    ///
    /// ```
    /// let cloud = punctual::Mesh::from_points([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])?;
    /// assert_eq!((cloud.len(), cloud.triangles().len()), (2, 0));
    /// # Ok::<(), punctual::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::NotFinite`] or [`MeshError::TooLarge`] for the first point at fault;
    /// [`MeshError::TooManyTriangles`] for more than 2^30 points.
    pub fn from_points(points: impl IntoIterator<Item: Into<[f32; 3]>>) -> Result<Self, MeshError> {
        Self::cloud(Vertices::F32(points.into_iter().map(Into::into).collect()))
    }

    /// A point cloud from f64 points, stored as by [`from_f64`](Self::from_f64).
    ///
    /// # Errors
    /// As [`from_points`](Self::from_points).
    pub fn from_points_f64(
        points: impl IntoIterator<Item: Into<[f64; 3]>>,
    ) -> Result<Self, MeshError> {
        let points = points.into_iter().map(Into::into).collect();
        Ok(Self::cloud(Vertices::F64(points))?.narrowed())
    }

    fn cloud(points: Vertices) -> Result<Self, MeshError> {
        check_count(points.len())?;
        let mut mesh = Self {
            vertices: points,
            ..Self::no_points()
        };
        if !mesh.measure() {
            (0..mesh.len()).try_for_each(|i| check_vertex(i, mesh.vertices.get(i)))?;
        }
        Ok(mesh)
    }

    pub(crate) fn no_points() -> Self {
        Self {
            vertices: Vertices::F32(Box::default()),
            triangles: Box::default(),
            aabb: Aabb::EMPTY,
            all_in_use: true,
            is_cloud: true,
            least_exponent: 0,
        }
    }

    /// Stores f64 vertices as f32 if that keeps every bit of those in use.
    fn narrowed(mut self) -> Self {
        if let Vertices::F64(wide) = &self.vertices {
            let is_exact = |vertex: usize| wide[vertex].into_iter().all(is_f32_exact);
            if self.in_use().all(is_exact) {
                let narrow = wide.iter().map(|vertex| vertex.map(|c| c as f32));
                self.vertices = Vertices::F32(narrow.collect());
                self.measure();
            }
        }
        self
    }

    /// The mesh with the coordinates of each axis multiplied by a factor, rounded once to f64 and
    /// stored as by [`from_f64`](Self::from_f64). If the factors mirror it, the second and the
    /// third corner of each triangle change places, so that faces look outwards as before.
    /// [`Tree::scaled`](crate::Tree::scaled) scales a tree that is built.
    ///
    /// ```
    /// use punctual::shapes;
    /// let left = shapes::cuboid([1.0, 2.0, 3.0], 1);
    /// let right = left.scaled_by([-1.0, 1.0, 1.0])?;
    /// assert_eq!(right.aabb(), left.aabb());
    /// # Ok::<(), punctual::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Factor`] for the first factor that is 0, infinite or NaN;
    /// [`MeshError::TooLarge`] for the first vertex in use that a product takes beyond 2^1000.
    pub fn scaled_by(&self, factors: impl Into<[f64; 3]>) -> Result<Self, MeshError> {
        let factors = factors.into();
        let is_bad = |&axis: &usize| factors[axis] == 0.0 || !factors[axis].is_finite();
        if let Some(axis) = (0..3).find(is_bad) {
            let factor = factors[axis];
            return Err(MeshError::Factor { axis, factor });
        }
        let factors = DVec3::from_array(factors);
        // An infinite product is one that is too large.
        let scale = |vertex: DVec3| (vertex * factors).clamp(DVec3::MIN, DVec3::MAX);
        let vertices: Vec<_> = (0..self.vertex_count())
            .map(|i| scale(self.vertex(i)))
            .collect();
        let mut mesh = self.clone();
        mesh.set_vertices_f64(&vertices)?;
        if mirrors(factors) {
            mesh.reverse(0..self.triangles.len());
        }
        Ok(mesh)
    }

    /// The mesh moved so that the center of its box is the origin, and the center before.
    /// Coordinates are rounded to f64. An empty mesh stays as it is.
    ///
    /// Near the origin f32 is finest, and engines turn bodies about their origins. A pose of the
    /// mesh becomes one of the result by a translation: `pose.transform_point(center)`.
    #[must_use]
    pub fn centered(&self) -> (Self, DVec3) {
        if self.is_empty() {
            return (self.clone(), DVec3::ZERO);
        }
        let center = self.aabb.center();
        let vertices = (0..self.vertex_count()).map(|i| (self.vertex(i) - center).to_array());
        let mut mesh = self.clone();
        mesh.vertices = Vertices::F64(vertices.collect());
        mesh.measure();
        (mesh.narrowed(), center)
    }

    fn checked(vertices: Vertices, triangles: Box<[[u32; 3]]>) -> Result<Self, MeshError> {
        check_count(triangles.len())?;
        for (triangle, corners) in triangles.iter().enumerate() {
            for (corner, &index) in corners.iter().enumerate() {
                if index as usize >= vertices.len() {
                    let vertices = vertices.len();
                    return Err(MeshError::IndexOutOfRange {
                        triangle,
                        corner,
                        index,
                        vertices,
                    });
                }
                check_vertex(index as usize, vertices.get(index as usize))?;
            }
        }
        Ok(Self::trusted(vertices, triangles))
    }

    /// A mesh from triangles and vertices that are valid by construction; does not check them.
    fn trusted(vertices: Vertices, triangles: Box<[[u32; 3]]>) -> Self {
        let all_in_use = all_in_use(vertices.len(), &triangles);
        let mut mesh = Self {
            vertices,
            triangles,
            aabb: Aabb::EMPTY,
            all_in_use,
            is_cloud: false,
            least_exponent: 0,
        };
        mesh.measure();
        mesh
    }

    /// True for a point cloud ([`from_points`](Self::from_points)).
    #[inline]
    pub fn is_cloud(&self) -> bool {
        self.is_cloud
    }

    /// Number of triangles; of a cloud, number of points.
    #[inline]
    pub fn len(&self) -> usize {
        if self.is_cloud {
            self.vertices.len()
        } else {
            self.triangles.len()
        }
    }

    /// True if the mesh has no triangles, or the cloud no points; a mesh may still have vertices.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The vertex indices of all triangles, in input order; none for a cloud.
    #[inline]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of vertices, unused ones included.
    #[inline]
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Vertex `i`, exact if a triangle uses it.
    ///
    /// # Panics
    /// If `i` is not below [`vertex_count`](Self::vertex_count).
    #[inline]
    pub fn vertex(&self, i: usize) -> DVec3 {
        self.vertices.get(i)
    }

    /// All vertices, as stored.
    #[inline]
    pub(crate) fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// The corners of triangle `i`, exact; three times point `i` of a cloud.
    ///
    /// # Panics
    /// If `i` is not below [`len`](Self::len).
    #[inline]
    pub fn triangle(&self, i: usize) -> [DVec3; 3] {
        if self.is_cloud {
            return [self.vertices.get(i); 3];
        }
        // Written out, because `map` compiles to a call.
        let [a, b, c] = self.triangles[i];
        [
            self.vertices.get(a as usize),
            self.vertices.get(b as usize),
            self.vertices.get(c as usize),
        ]
    }

    /// The smallest box around all vertices in use; [`Aabb::EMPTY`] without triangles. Takes
    /// constant time.
    #[inline]
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// log2 of the least magnitude of a stored coordinate, zeros excluded, rounded down. Far lower
    /// if that coordinate is denormal, and far higher if all are zero
    /// ([`punctual_geom::denormals::Number::exponent`]).
    #[inline]
    pub(crate) fn least_exponent(&self) -> i32 {
        self.least_exponent
    }

    /// True if the vertices are stored as f32. They are exact in either case.
    #[inline]
    pub fn is_f32(&self) -> bool {
        matches!(self.vertices, Vertices::F32(_))
    }

    /// Reverses triangles: their second and third corners change places.
    pub(crate) fn reverse(&mut self, triangles: impl Iterator<Item = usize>) {
        triangles.for_each(|i| self.triangles[i].swap(1, 2));
    }

    /// Heap memory, in bytes.
    pub fn bytes(&self) -> usize {
        let vertices = match &self.vertices {
            Vertices::F32(v) => size_of_val(&**v),
            Vertices::F64(v) => size_of_val(&**v),
        };
        vertices + size_of_val(&*self.triangles)
    }
}

/// True if a map with these factors turns outsides into insides.
pub(crate) fn mirrors(factors: DVec3) -> bool {
    factors.is_negative_bitmask().count_ones() % 2 == 1
}

fn check_count(triangles: usize) -> Result<(), MeshError> {
    if triangles > TRIANGLE_LIMIT {
        return Err(MeshError::TooManyTriangles { triangles });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_many_triangles_are_refused() {
        assert_eq!(check_count(1 << 30), Ok(()));
        let triangles = (1 << 30) + 1;
        assert_eq!(
            check_count(triangles),
            Err(MeshError::TooManyTriangles { triangles })
        );
    }
}
