//! How a file is read: limits, unit, upward axis.

use std::path::{Path, PathBuf};

/// How large a mesh may become by the repeated use of its parts, as glTF allows, and a packed file.
///
/// A file of a few kilobytes can name a mesh of a million triangles a million times, or unpack to a thousand times its
/// size.
/// What a file holds without repetition is never refused: an element takes a byte of it or more, and the limits of
/// vertices and
/// triangles are at least the bytes of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Most vertices, by default 2^24: 400 MB.
    pub vertices: usize,
    /// Most triangles, by default 2^24: 200 MB.
    pub triangles: usize,
    /// Most bytes that a file packed by gzip holds, and, if there are several, the buffers of a glTF document that are
    /// files of
    /// their own; by default 2^30.
    pub unpacked: usize,
}

impl Limits {
    /// At most so many vertices, and so many triangles.
    pub const fn new(vertices: usize, triangles: usize) -> Self {
        Self {
            vertices,
            triangles,
            unpacked: 1 << 30,
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::new(1 << 24, 1 << 24)
    }
}

/// An axis of a file's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
    /// The third coordinate.
    #[default]
    Z,
}

/// How a file is read. The defaults leave its coordinates as they are.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// How large the mesh may become.
    pub limits: Limits,
    /// The factors of the coordinates along each axis, after the turn: finite and not 0, such as 0.001 for a file in
    /// millimetres that is wanted in metres. An odd number of negative ones mirrors the mesh; its triangles are turned so
    /// that they face outwards as before. Products are rounded to f64; where one is not exact in f32, the mesh keeps f64.
    pub scale: [f64; 3],
    /// The axis that points up in the file. The mesh is turned such that z points up, by the shortest turn: `Y` takes
    /// (x, y, z)
    /// to (x, -z, y), and `X` to (-z, y, x). `Z`, the default, turns nothing.
    pub up: Axis,
    /// Where the buffers of a glTF document lie that are files of their own; none without it. [`load`](crate::load)
    /// takes the
    /// folder of the file.
    pub folder: Option<PathBuf>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            scale: [1.0; 3],
            up: Axis::Z,
            folder: None,
        }
    }
}

impl ReadOptions {
    /// The same with other limits.
    pub fn limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// The same with another scale, of all axes.
    pub fn scale(self, scale: f64) -> Self {
        self.scale_axes([scale; 3])
    }

    /// The same with another scale along each axis.
    pub fn scale_axes(self, scale: [f64; 3]) -> Self {
        Self { scale, ..self }
    }

    /// The same with another axis that points up in the file.
    pub fn up(self, up: Axis) -> Self {
        Self { up, ..self }
    }

    /// The same with a folder for the buffers of glTF documents.
    pub fn folder(self, folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: Some(folder.into()),
            ..self
        }
    }

    /// The same, for a file whose buffers lie beside it unless a folder is given.
    pub(crate) fn in_folder_of(self, file: &Path) -> Self {
        let folder = self.folder.or_else(|| file.parent().map(Path::to_owned));
        Self { folder, ..self }
    }

    /// Turns vertices.
    pub(crate) fn turn(&self, vertices: &mut [[f64; 3]]) {
        for vertex in vertices {
            let [x, y, z] = *vertex;
            // Not by a sign, which would make -0 of 0.
            *vertex = match self.up {
                Axis::X => [0.0 - z, y, x],
                Axis::Y => [x, 0.0 - z, y],
                Axis::Z => [x, y, z],
            };
        }
    }
}
