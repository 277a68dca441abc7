//! Meshes.

use crate::arrays::{array, path};
use crate::pose::{punctual_aabb, punctual_point};
use crate::sized::place;
use crate::status::{Fault, free, given, value_of};
use crate::verbs::{calls, types};
use core::ffi::c_char;
use core::mem::MaybeUninit;
use punctual::Mesh;
use punctual_io::Format;

/// A triangle surface: checked once when it is made, never changed after. Any number of threads may
/// read it.
#[derive(Debug)]
pub struct punctual_mesh(pub(crate) Mesh);

types! {
    /// Numbers that describe a mesh.
    told punctual_mesh_facts(triangles) {
        /// Triangles.
        triangles: usize,
        /// Vertices, those that no triangle uses included.
        vertices: usize,
        /// Memory on the heap.
        bytes: usize,
        /// Whether the vertices are stored as float, which is then exact.
        is_f32: bool,
        /// The smallest box around all vertices in use, in the frame of the mesh; empty without
        /// triangles.
        bounds: punctual_aabb,
    }
}

calls! {
    /// Makes a mesh from `3 * vertex_count` coordinates and `3 * triangle_count` vertex indices,
    /// from 0, which are copied.
    ///
    /// Coordinates are in one length unit, the caller's, in the frame of the mesh, and kept to the
    /// bit. Triangles may be degenerate, share vertices or overlap; vertices that none uses may
    /// hold anything. No triangles are fine. Takes linear time.
    ///
    /// Fails with BAD_MESH if an index is out of range or a coordinate in use is not finite.
    unsafe make punctual_mesh_new_f32(
        vertices: *const f32, vertex_count: usize, triangles: *const u32, triangle_count: usize
    ) -> mesh: punctual_mesh = {
        // SAFETY: the contract of the header for arrays.
        let (vertices, triangles) = unsafe {
            (
                array(vertices.cast::<[f32; 3]>(), vertex_count, "vertices")?,
                array(triangles.cast::<[u32; 3]>(), triangle_count, "triangles")?,
            )
        };
        Mesh::new(vertices.iter().copied(), triangles.iter().copied())?
    };

    /// Like `punctual_mesh_new_f32`. The mesh is stored as float if that keeps every bit of the
    /// vertices in use.
    ///
    /// Fails with BAD_MESH also if a coordinate in use exceeds 2^1000.
    unsafe make punctual_mesh_new_f64(
        vertices: *const f64, vertex_count: usize, triangles: *const u32, triangle_count: usize
    ) -> mesh: punctual_mesh = {
        // SAFETY: the contract of the header for arrays.
        let (vertices, triangles) = unsafe {
            (
                array(vertices.cast::<[f64; 3]>(), vertex_count, "vertices")?,
                array(triangles.cast::<[u32; 3]>(), triangle_count, "triangles")?,
            )
        };
        Mesh::from_f64(vertices.iter().copied(), triangles.iter().copied())?
    };
}

types! {
    /// A file format that can be read.
    enum punctual_format {
        /// Wavefront OBJ: vertices and polygons.
        Obj = 0,
        /// STL, ASCII or binary.
        Stl = 1,
        /// PLY, ASCII or binary of both byte orders.
        Ply = 2,
        /// glTF, binary or JSON text with its buffers in it: the triangles of the default scene,
        /// moved by their nodes.
        Gltf = 3,
        /// OFF in text.
        Off = 4,
        /// COLLADA: the meshes of the scene, moved by their nodes, in metres.
        Collada = 5,
    }
}

calls! {
    /// Reads the mesh of a file, OBJ, STL, PLY, OFF, glTF or COLLADA by its extension, also before
    /// `.gz`. `path` is UTF-8 and ends with a zero byte.
    ///
    /// Polygons are triangulated; coordinates have the precision of the file. What is passed over
    /// is not told; `punctual info` tells it. Takes time and memory in proportion to the file; a
    /// glTF file may use its meshes for up to 2^24 triangles, and a packed file hold up to 2^30
    /// bytes.
    ///
    /// Fails with BAD_FILE if the file cannot be read or holds no mesh, and with BAD_ARGUMENT if
    /// `path` is not UTF-8. The text of `punctual_last_error` names the file and the line or byte
    /// in it.
    unsafe make punctual_mesh_read(path: *const c_char) -> mesh: punctual_mesh =
        // SAFETY: the contract of the header for texts.
        punctual_io::load(unsafe { self::path(path, "path") }?)?.mesh;

    /// Like `punctual_mesh_read` for the content of a file, of `count` bytes in a
    /// `punctual_format`.
    ///
    /// Fails with BAD_FILE if it holds no mesh, and with BAD_ARGUMENT for an unknown format.
    unsafe make punctual_mesh_read_bytes(bytes: *const u8, count: usize, format: u32)
        -> mesh: punctual_mesh = {
            // SAFETY: the contract of the header for arrays.
            let bytes = unsafe { array(bytes, count, "bytes") }?;
            let formats =
                [Format::Obj, Format::Stl, Format::Ply, Format::Gltf, Format::Off, Format::Collada];
            punctual_io::read(bytes, value_of(format, "format", &formats)?)?.mesh
        };
}

/// Frees a mesh; null is fine. Trees have copies of their own.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_mesh_free(mesh: Option<Box<punctual_mesh>>) {
    free(mesh);
}

calls! {
    /// Describes a mesh. Takes constant time.
    unsafe fn punctual_mesh_describe(
        mesh: Option<&punctual_mesh>, facts: *mut punctual_mesh_facts
    ) {
        let punctual_mesh(mesh) = given(mesh, "mesh")?;
        // SAFETY: the contract of the header for structs.
        let facts = unsafe { place(facts, "facts") }?;
        facts.write(punctual_mesh_facts {
            size: punctual_mesh_facts::SIZE,
            triangles: mesh.triangles().len(),
            vertices: mesh.vertex_count(),
            bytes: mesh.bytes(),
            is_f32: mesh.is_f32(),
            bounds: mesh.aabb().into(),
        });
        Ok(())
    }

    /// The vertex indices of all triangles, three for each, in the order given. Valid as long as
    /// the mesh.
    fn punctual_mesh_indices(
        mesh: Option<&punctual_mesh>, indices: Option<&mut MaybeUninit<*const u32>>
    ) {
        let (punctual_mesh(mesh), indices) = (given(mesh, "mesh")?, given(indices, "indices")?);
        indices.write(mesh.triangles().as_ptr().cast());
        Ok(())
    }

    /// One vertex, exact if a triangle uses it.
    ///
    /// Fails with BAD_ARGUMENT if there is no such vertex.
    fn punctual_mesh_vertex(
        mesh: Option<&punctual_mesh>, index: usize,
        vertex: Option<&mut MaybeUninit<punctual_point>>
    ) {
        let (punctual_mesh(mesh), vertex) = (given(mesh, "mesh")?, given(vertex, "vertex")?);
        if index >= mesh.vertex_count() {
            return Err(Fault::Index("index", index, mesh.vertex_count()));
        }
        vertex.write(mesh.vertex(index).into());
        Ok(())
    }
}

impl From<Mesh> for punctual_mesh {
    fn from(mesh: Mesh) -> Self {
        Self(mesh)
    }
}
