//! The files of a case: a folder with a mesh `a.*`, a mesh `b.*`, and `poses.txt`, the poses of B in A's frame.

use std::path::Path;

use punctual::{Mesh, Pose};
use punctual_io::text::{fields, numbers};
use punctual_io::{FileError, load};

use crate::report::Failure;

/// One entry of a pose list. A line that holds no pose keeps its place in the list, with the reason.
pub struct ListedPose {
    /// Its line in the file, counted from 1.
    pub line: usize,
    /// The pose, or why it is none.
    pub pose: Result<Pose, String>,
}

/// Reads a mesh of a case, `a` or `b`, whatever its format.
///
/// # Errors
/// If there is no such file, or no mesh in it.
pub fn mesh(folder: &Path, stem: &str) -> Result<Mesh, Failure> {
    let files = ["obj", "stl", "ply", "glb"].map(|extension| folder.join(format!("{stem}.{extension}")));
    let file = files.iter().find(|file| file.exists());
    let file = file.ok_or_else(|| format!("{}: no mesh {stem}.obj, .stl, .ply or .glb", folder.display()))?;
    Ok(load(file)?)
}

/// Reads a pose list: 12 numbers a line, row-major `[R|t]` of B in A's frame; `#` comments and blank lines are skipped.
///
/// # Errors
/// If the file cannot be read; lines that hold no pose are listed with the others.
pub fn poses(file: &Path) -> Result<Vec<ListedPose>, FileError> {
    let bytes = std::fs::read(file).map_err(|error| FileError::from_io(file, &error))?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().map(fields).zip(1..);
    let listed = lines.filter(|(fields, _)| !fields.is_empty());
    Ok(listed.map(|(fields, line)| ListedPose { line, pose: parse(&fields) }).collect())
}

fn parse(fields: &[&str]) -> Result<Pose, String> {
    Pose::from_row_major(numbers(fields)?).map_err(|error| error.to_string())
}
