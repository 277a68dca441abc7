//! Mesh files: one reader a format, chosen by the file's extension, and one check at the end.
//!
//! Readers accept damaged files without a panic and say where the damage is: the line of a text format, else the
//! element. Nothing is lost on the way: coordinates reach the mesh with the precision they have in the file.

mod glb;
mod obj;
mod ply;
mod stl;

use std::fmt;
use std::path::{Path, PathBuf};

use punctual::{Mesh, MeshError};

use crate::report::Failure;

/// A file that cannot be used: which one, where in it, and why.
#[derive(Debug)]
pub struct FileError {
    file: PathBuf,
    fault: Fault,
}

/// What is wrong with a file, and on which line if it has lines.
#[derive(Debug)]
pub struct Fault {
    line: Option<usize>,
    what: String,
}

/// What a reader found: vertices and triangles as they stand in the file.
#[derive(Default)]
pub struct Surface {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Line of each vertex; empty if the format has no lines or checks its vertices itself.
    vertex_lines: Vec<usize>,
}

/// Reads a mesh of the folder of a case, `a` or `b`, whatever its format.
pub fn load_of_case(folder: &Path, stem: &str) -> Result<Mesh, Failure> {
    let files = ["obj", "stl", "ply", "glb"].map(|extension| folder.join(format!("{stem}.{extension}")));
    let file = files.iter().find(|file| file.exists());
    let file = file.ok_or_else(|| format!("{}: no mesh {stem}.obj, .stl, .ply or .glb", folder.display()))?;
    Ok(load(file)?)
}

/// Reads the mesh of a file whose extension names its format.
pub fn load(file: &Path) -> Result<Mesh, FileError> {
    read(file).map_err(|fault| FileError::new(file, fault))
}

fn read(file: &Path) -> Result<Mesh, Fault> {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let parse: fn(Vec<u8>) -> Result<Surface, Fault> = match extension.as_str() {
        "obj" => |bytes| obj::parse(&bytes),
        "stl" => stl::parse,
        "ply" => |bytes| ply::parse(&bytes),
        "glb" => |bytes| glb::parse(&bytes),
        "gltf" => {
            return Err(Fault::new("glTF as JSON text is not read; pack it into one .glb file"));
        }
        _ => {
            return Err(Fault::new("no mesh format by its extension; use .obj, .stl, .ply or .glb"));
        }
    };
    let bytes = std::fs::read(file).map_err(|error| Fault::new(error.to_string()))?;
    parse(bytes)?.into_mesh()
}

impl Surface {
    fn into_mesh(self) -> Result<Mesh, Fault> {
        let Self { vertices, triangles, vertex_lines } = self;
        let checked = Mesh::from_f64(vertices, triangles.iter().copied());
        checked.map_err(|error| {
            let vertex = match error {
                MeshError::NotFinite { vertex, .. } | MeshError::TooLarge { vertex, .. } => vertex,
                _ => return Fault::new(error.to_string()),
            };
            let user = triangles.iter().position(|t| t.iter().any(|&corner| corner as usize == vertex));
            let user = user.map(|t| format!(" (counted from 0, in use by triangle {t})"));
            Fault {
                line: vertex_lines.get(vertex).copied(),
                what: error.to_string() + user.as_deref().unwrap_or_default(),
            }
        })
    }

    /// Adds the corners of a polygon as a fan of triangles around the first corner.
    fn push_polygon(&mut self, corners: &[u32]) {
        let fan = corners.windows(2).skip(1);
        self.triangles.extend(fan.map(|edge| [corners[0], edge[0], edge[1]]));
    }
}

impl Fault {
    fn new(what: impl Into<String>) -> Self {
        Self { line: None, what: what.into() }
    }

    fn at(line: usize, what: impl Into<String>) -> Self {
        Self { line: Some(line), what: what.into() }
    }
}

impl FileError {
    pub fn new(file: &Path, fault: Fault) -> Self {
        Self { file: file.to_owned(), fault }
    }

    pub fn from_io(file: &Path, error: &std::io::Error) -> Self {
        Self::new(file, Fault::new(error.to_string()))
    }

    pub fn at_line(file: &Path, line: usize, what: impl Into<String>) -> Self {
        Self::new(file, Fault::at(line, what))
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, fault: Fault { line, what } } = self;
        write!(f, "{}:", file.display())?;
        if let Some(line) = line {
            write!(f, "{line}:")?;
        }
        // A damaged file must not reach the terminal as control codes.
        let (mut text, what) = (String::from(" "), what.chars());
        what.for_each(|c| match c.is_control() {
            true => text.extend(c.escape_default()),
            false => text.push(c),
        });
        f.write_str(&text)
    }
}

impl std::error::Error for FileError {}
