#![doc = include_str!("../README.md")]
#![deny(missing_docs, unsafe_code)]

#[cfg(feature = "collada")]
mod collada;
#[cfg(not(feature = "collada"))]
mod collada {
    pub fn parse(
        _: &[u8],
        _: &crate::ReadOptions,
        _: &mut crate::notice::Notices,
    ) -> Result<crate::Surface, crate::ReadError> {
        Err("COLLADA: the feature `collada` is off".into())
    }
}
mod error;
mod format;
mod gltf;
mod notice;
mod obj;
mod off;
mod options;
mod ply;
pub mod points;
mod polygon;
mod stl;
pub mod text;
#[cfg(feature = "xml")]
pub mod xml;

pub use error::{FileError, Place, ReadError};
pub use format::Format;
pub use notice::Notice;
pub use options::{Axis, Limits, ReadOptions};

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use notice::Notices;
use punctual::{Mesh, MeshError};

/// A mesh, and what was passed over to get it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// What was passed over, or read although it is out of order: one entry a kind, a few at most, none for most files.
    pub notices: Vec<Notice>,
}

/// Reads the mesh of a file whose extension names its format.
///
/// # Errors
/// If the file cannot be read, or holds no mesh; the error names the file and the place in it.
pub fn load(file: &Path) -> Result<Loaded, FileError> {
    load_with(file, &ReadOptions::default())
}

/// Reads the mesh of a file with options. Files of [points](points::PointFormat::EXTENSIONS) are
/// clouds ([`Mesh::is_cloud`]).
///
/// # Errors
/// Those of [`load`].
pub fn load_with(file: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
    if points::PointFormat::EXTENSIONS.contains(&&*format::extension(file)) {
        let points::Points { points, notices } = points::load_points(file, options)?;
        let mesh = Mesh::from_points_f64(points)
            .map_err(|error| FileError::new(file, ReadError::new(error.to_string())))?;
        return Ok(Loaded { mesh, notices });
    }
    let format = Format::of(file).map_err(|error| FileError::new(file, error))?;
    let bytes = std::fs::read(file).map_err(|error| FileError::from_io(file, &error))?;
    let options = options.clone().in_folder_of(file);
    read_with(&bytes, format, &options).map_err(|error| FileError::new(file, error))
}

/// Reads a mesh from the content of a file; without a format, from what the content looks like.
///
/// # Errors
/// If it holds no mesh; the error names the place.
pub fn read(bytes: &[u8], format: impl Into<Option<Format>>) -> Result<Loaded, ReadError> {
    read_with(bytes, format, &ReadOptions::default())
}

/// Reads a mesh from the content of a file with options.
///
/// # Errors
/// Those of [`read`].
pub fn read_with(
    bytes: &[u8],
    format: impl Into<Option<Format>>,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let bytes = unpacked(bytes, options.limits.unpacked)?;
    refuse_pointer(&bytes)?;
    let format = format
        .into()
        .map_or_else(|| Format::of_content(&bytes), Ok)?;
    let mut notices = Notices::default();
    let mut surface = surface(&bytes, format, options, &mut notices)?;
    if surface.triangles.is_empty() {
        let passed = notices
            .first()
            .map(|notice| format!("; {notice}"))
            .unwrap_or_default();
        return Err(ReadError::new(format!("no triangles in it{passed}")));
    }
    options.turn(&mut surface.vertices);
    let mesh = surface.into_mesh()?;
    let scaled = (options.scale != [1.0; 3]).then(|| mesh.scaled_by(options.scale));
    let scaled = scaled.transpose();
    let scaled = scaled.map_err(|error| ReadError::new(format!("scaled: {error}")))?;
    Ok(Loaded {
        mesh: scaled.unwrap_or(mesh),
        notices: notices.into_list(),
    })
}

/// What a mesh file holds.
fn surface(
    bytes: &[u8],
    format: Format,
    options: &ReadOptions,
    notices: &mut Notices,
) -> Result<Surface, ReadError> {
    // The header of a binary STL file may begin with any bytes.
    let is_wide = format != Format::Stl && text::is_utf16(bytes);
    let bytes = &*if is_wide {
        Cow::Owned(text::decode(bytes).into_owned().into_bytes())
    } else {
        Cow::Borrowed(bytes)
    };
    match format {
        Format::Obj => obj::parse(bytes, notices),
        Format::Stl => stl::parse(bytes, notices),
        Format::Ply => ply::parse(bytes, notices),
        Format::Off => off::parse(bytes, notices),
        Format::Collada => collada::parse(bytes, options, notices),
        Format::Gltf => gltf::parse(bytes, options, notices),
    }
}

/// What is in a file packed by gzip, or the bytes as they are.
fn unpacked(bytes: &[u8], limit: usize) -> Result<Cow<'_, [u8]>, ReadError> {
    if !bytes.starts_with(b"\x1f\x8b\x08") {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut unpacked = Vec::new();
    let read = MultiGzDecoder::new(bytes)
        .take(limit as u64 + 1)
        .read_to_end(&mut unpacked);
    match read {
        Err(error) => Err(ReadError::new(format!("damaged gzip: {error}"))),
        Ok(length) if length > limit => Err(ReadError::new(format!(
            "gzip of more than {limit} bytes; unpack it first"
        ))),
        Ok(_) => Ok(Cow::Owned(unpacked)),
    }
}

/// What Git leaves in the place of a large file that was not fetched.
fn refuse_pointer(bytes: &[u8]) -> Result<(), ReadError> {
    match bytes.starts_with(b"version https://git-lfs.github.com/spec/") {
        true => Err(ReadError::new(
            "a Git LFS pointer, not the file itself, which `git lfs pull` fetches",
        )),
        false => Ok(()),
    }
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
        let Self {
            vertices,
            triangles,
            places,
        } = self;
        let checked = Mesh::from_f64(vertices, triangles.iter().copied());
        checked.map_err(|error| {
            let vertex = match error {
                MeshError::NotFinite { vertex, .. } | MeshError::TooLarge { vertex, .. } => vertex,
                _ => return ReadError::new(error.to_string()),
            };
            let user = triangles
                .iter()
                .position(|t| t.iter().any(|&corner| corner as usize == vertex));
            let user = user
                .map(|t| format!(" (counted from 0, in use by triangle {t})"))
                .unwrap_or_default();
            let what = format!("{error}{user}");
            match places.get(vertex) {
                Some(&place) => ReadError::at(place, what),
                None => ReadError::new(what),
            }
        })
    }
}
