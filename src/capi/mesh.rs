//! Meshes.

use super::arrays::array;
use super::status::{Fault, door, free, given, punctual_status};
use crate::mesh::Mesh;
use core::mem::MaybeUninit;

/// A triangle surface: checked once when it is made, never changed after. Any number of threads may read it.
#[derive(Debug)]
pub struct punctual_mesh(pub(super) Mesh);

/// A point or a vector, in the length unit of the mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_point {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
    /// Along the z axis.
    pub z: f64,
}

impl From<glam::DVec3> for punctual_point {
    fn from(point: glam::DVec3) -> Self {
        Self { x: point.x, y: point.y, z: point.z }
    }
}

/// A box that is parallel to the axes; empty if `min` exceeds `max`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_aabb {
    /// Smallest coordinates.
    pub min: punctual_point,
    /// Largest coordinates.
    pub max: punctual_point,
}

impl From<crate::math::Aabb> for punctual_aabb {
    fn from(aabb: crate::math::Aabb) -> Self {
        Self { min: aabb.min.into(), max: aabb.max.into() }
    }
}

/// Numbers that describe a mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_mesh_facts {
    /// Triangles.
    pub triangles: usize,
    /// Vertices, those that no triangle uses included.
    pub vertices: usize,
    /// Memory on the heap.
    pub bytes: usize,
    /// Whether the vertices are stored as float, which is then exact.
    pub is_f32: bool,
    /// The smallest box around all vertices in use, in the frame of the mesh; empty without triangles.
    pub bounds: punctual_aabb,
}

/// Makes a mesh from `3 * vertex_count` coordinates and `3 * triangle_count` vertex indices, from 0, which are copied.
///
/// Coordinates are in one length unit, the caller's, in the frame of the mesh, and kept to the bit. Triangles may be
/// degenerate, share vertices or overlap; vertices that none uses may hold anything. No triangles are fine. Takes linear
/// time.
///
/// Fails with BAD_MESH if an index is out of range or a coordinate in use is not finite.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_mesh_new_f32(
    vertices: *const f32,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    mesh: Option<&mut MaybeUninit<Option<Box<punctual_mesh>>>>,
) -> punctual_status {
    door("punctual_mesh_new_f32", || {
        // SAFETY: the contract of the header for arrays.
        let vertices = unsafe { array(vertices.cast::<[f32; 3]>(), vertex_count, "vertices") }?;
        // SAFETY: the same.
        let triangles = unsafe { array(triangles.cast::<[u32; 3]>(), triangle_count, "triangles") }?;
        put(mesh, || Ok(Mesh::new(vertices.iter().copied(), triangles.iter().copied())?))
    })
}

/// Like `punctual_mesh_new_f32`. The mesh is stored as float if that keeps every bit of the vertices in use.
///
/// Fails with BAD_MESH also if a coordinate in use exceeds 2^1000.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_mesh_new_f64(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    mesh: Option<&mut MaybeUninit<Option<Box<punctual_mesh>>>>,
) -> punctual_status {
    door("punctual_mesh_new_f64", || {
        // SAFETY: the contract of the header for arrays.
        let vertices = unsafe { array(vertices.cast::<[f64; 3]>(), vertex_count, "vertices") }?;
        // SAFETY: the same.
        let triangles = unsafe { array(triangles.cast::<[u32; 3]>(), triangle_count, "triangles") }?;
        put(mesh, || Ok(Mesh::from_f64(vertices.iter().copied(), triangles.iter().copied())?))
    })
}

/// Frees a mesh; null is fine. Trees have copies of their own.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_mesh_free(mesh: Option<Box<punctual_mesh>>) {
    free(mesh);
}

/// Describes a mesh. Takes constant time.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_mesh_describe(
    mesh: Option<&punctual_mesh>,
    facts: Option<&mut MaybeUninit<punctual_mesh_facts>>,
) -> punctual_status {
    door("punctual_mesh_describe", || {
        let (punctual_mesh(mesh), facts) = (given(mesh, "mesh")?, given(facts, "facts")?);
        facts.write(punctual_mesh_facts {
            triangles: mesh.len(),
            vertices: mesh.vertex_count(),
            bytes: mesh.bytes(),
            is_f32: mesh.is_f32(),
            bounds: mesh.aabb().into(),
        });
        Ok(())
    })
}

/// The vertex indices of all triangles, three for each, in the order given. Valid as long as the mesh.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_mesh_indices(
    mesh: Option<&punctual_mesh>,
    indices: Option<&mut MaybeUninit<*const u32>>,
) -> punctual_status {
    door("punctual_mesh_indices", || {
        let (punctual_mesh(mesh), indices) = (given(mesh, "mesh")?, given(indices, "indices")?);
        indices.write(mesh.triangles().as_ptr().cast());
        Ok(())
    })
}

/// One vertex, exact if a triangle uses it.
///
/// Fails with BAD_ARGUMENT if there is no such vertex.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_mesh_vertex(
    mesh: Option<&punctual_mesh>,
    index: usize,
    vertex: Option<&mut MaybeUninit<punctual_point>>,
) -> punctual_status {
    door("punctual_mesh_vertex", || {
        let (punctual_mesh(mesh), vertex) = (given(mesh, "mesh")?, given(vertex, "vertex")?);
        if index >= mesh.vertex_count() {
            return Err(Fault::Index("index", index, mesh.vertex_count()));
        }
        vertex.write(mesh.vertex(index).into());
        Ok(())
    })
}

/// Makes a value and hands it over, if there is a place for it.
pub(super) fn put<T: Into<H>, H>(
    out: Option<&mut MaybeUninit<Option<Box<H>>>>,
    make: impl FnOnce() -> Result<T, Fault>,
) -> Result<(), Fault> {
    let out = given(out, "the place for the new handle")?;
    out.write(Some(Box::new(make()?.into())));
    Ok(())
}

impl From<Mesh> for punctual_mesh {
    fn from(mesh: Mesh) -> Self {
        Self(mesh)
    }
}
