//! Pose lists: 12 numbers a line, row-major `[R|t]` of B in A's frame; `#` comments and blank lines are skipped.

use std::path::Path;

use punctual::Pose;

use crate::load::FileError;
use crate::text::{fields, numbers};

/// One entry of a pose list. A line that holds no pose keeps its place in the list, with the reason.
pub struct ListedPose {
    pub line: usize,
    pub pose: Result<Pose, String>,
}

pub fn load(file: &Path) -> Result<Vec<ListedPose>, FileError> {
    let bytes = std::fs::read(file).map_err(|error| FileError::from_io(file, &error))?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().map(fields).zip(1..);
    let listed = lines.filter(|(fields, _)| !fields.is_empty());
    Ok(listed.map(|(fields, line)| ListedPose { line, pose: parse(&fields) }).collect())
}

fn parse(fields: &[&str]) -> Result<Pose, String> {
    Pose::from_row_major(numbers(fields)?).map_err(|error| error.to_string())
}
