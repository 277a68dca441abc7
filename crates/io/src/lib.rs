//! Mesh files for [`punctual`]: OBJ, STL, PLY and glTF binary.
//!
//! ```no_run
//! let mesh = punctual_io::load("gear.obj".as_ref())?;
//! let tree = punctual::Tree::new(mesh);
//! # Ok::<(), punctual_io::FileError>(())
//! ```
//!
//! There is one reader a format, and one check at the end. Readers accept damaged files without a panic and say where the
//! damage is: the line of a text format, the byte of a binary one, the node or primitive of a glTF document. A file without a
//! triangle is an error too. Nothing is lost on the way: coordinates reach the mesh with the precision they have in the file,
//! and triangles keep its order.
//!
//! A polygon with more than three corners is filled without leaving it: as a fan around its first corner where that does, else
//! by cutting off ears. One that crosses itself is refused, and so are some with more than 4,000 corners that are not convex.
//!
//! Time and memory are in proportion to the size of the file, with two exceptions: polygons with many corners that are not
//! convex, 50 us a corner at worst, and glTF, which may use a mesh many times (see [`Limits`]). A glTF document takes up to 70
//! times the memory of its JSON.

#![deny(missing_docs, unsafe_code)]

mod error;
mod glb;
mod obj;
mod ply;
mod polygon;
mod stl;
pub mod text;

pub use error::{FileError, Place, ReadError};

use std::path::Path;

use punctual::{Mesh, MeshError};

/// A file format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ: `v` and `f`, with polygons, continued lines and relative indices; coordinates in f64.
    Obj,
    /// STL, ASCII or binary; coordinates in f32.
    Stl,
    /// PLY, ASCII or binary of both byte orders; coordinates as the file declares them.
    Ply,
    /// glTF binary: the triangles of the default scene, moved by their nodes in f64. Skins, morphs, sparse accessors and
    /// other files are refused.
    Glb,
}

impl Format {
    /// The format that the extension of a file name stands for, upper or lower case.
    ///
    /// # Errors
    /// If it stands for none.
    pub fn of(file: &Path) -> Result<Self, ReadError> {
        let extension = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Ok(Self::Obj),
            "stl" => Ok(Self::Stl),
            "ply" => Ok(Self::Ply),
            "glb" => Ok(Self::Glb),
            "gltf" => Err(ReadError::new("glTF as JSON text is not read; pack it into one .glb file")),
            _ => Err(ReadError::new("no mesh format by its extension; use .obj, .stl, .ply or .glb")),
        }
    }
}

/// How large a mesh may become by the repeated use of its parts, as glTF allows.
///
/// A file of a few kilobytes can name a mesh of a million triangles a million times. What a file holds without repetition is
/// never refused: an element takes a byte of it or more, and the limits are at least the bytes of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Most vertices, by default 2^24: 400 MB.
    pub vertices: usize,
    /// Most triangles, by default 2^24: 200 MB.
    pub triangles: usize,
}

impl Limits {
    /// At most so many vertices, and so many triangles.
    pub const fn new(vertices: usize, triangles: usize) -> Self {
        Self { vertices, triangles }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::new(1 << 24, 1 << 24)
    }
}

/// Reads the mesh of a file whose extension names its format.
///
/// # Errors
/// If the file cannot be read, or holds no mesh; the error names the file and the place in it.
pub fn load(file: &Path) -> Result<Mesh, FileError> {
    load_within(file, &Limits::default())
}

/// Reads the mesh of a file within other limits than the usual.
///
/// # Errors
/// Those of [`load`].
pub fn load_within(file: &Path, limits: &Limits) -> Result<Mesh, FileError> {
    let format = Format::of(file).map_err(|error| FileError::new(file, error))?;
    let bytes = std::fs::read(file).map_err(|error| FileError::from_io(file, &error))?;
    read_within(&bytes, format, limits).map_err(|error| FileError::new(file, error))
}

/// Reads a mesh from the content of a file.
///
/// # Errors
/// If it holds no mesh; the error names the place.
pub fn read(bytes: &[u8], format: Format) -> Result<Mesh, ReadError> {
    read_within(bytes, format, &Limits::default())
}

/// Reads a mesh from the content of a file, within other limits than the usual.
///
/// # Errors
/// Those of [`read`].
pub fn read_within(bytes: &[u8], format: Format, limits: &Limits) -> Result<Mesh, ReadError> {
    let surface = match format {
        Format::Obj => obj::parse(bytes),
        Format::Stl => stl::parse(bytes),
        Format::Ply => ply::parse(bytes),
        Format::Glb => glb::parse(bytes, limits),
    };
    surface?.into_mesh()
}

/// What a reader found: vertices and triangles as they stand in the file.
#[derive(Default)]
struct Surface {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Where each vertex stands in the file; empty if the reader checks its vertices itself.
    places: Vec<Place>,
}

impl Surface {
    fn into_mesh(self) -> Result<Mesh, ReadError> {
        let Self { vertices, triangles, places } = self;
        if triangles.is_empty() {
            return Err(ReadError::new("no triangles in it"));
        }
        let checked = Mesh::from_f64(vertices, triangles.iter().copied());
        checked.map_err(|error| {
            let vertex = match error {
                MeshError::NotFinite { vertex, .. } | MeshError::TooLarge { vertex, .. } => vertex,
                _ => return ReadError::new(error.to_string()),
            };
            let user = triangles.iter().position(|t| t.iter().any(|&corner| corner as usize == vertex));
            let user = user.map(|t| format!(" (counted from 0, in use by triangle {t})")).unwrap_or_default();
            let what = format!("{error}{user}");
            match places.get(vertex) {
                Some(&place) => ReadError::at(place, what),
                None => ReadError::new(what),
            }
        })
    }
}
