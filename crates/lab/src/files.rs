//! The files of a case: a folder with a mesh `a.*`, a mesh `b.*`, and `poses.txt`, the poses of B in A's frame.

use std::path::Path;

use punctual::{Mesh, Motion, Pose, Ray};
use punctual_io::text::{decode, fields, lines, numbers};
use punctual_io::{FileError, Format, load};

use crate::report::Failure;

/// One entry of a list. A line that holds none keeps its place in the list, with the reason.
pub struct Listed<T> {
    /// Its line in the file, counted from 1.
    pub line: usize,
    /// The pose, motion, ray or point, or why it is none.
    pub entry: Result<T, String>,
}

/// Reads a mesh of a case, `a` or `b`, whatever its format.
///
/// # Errors
/// If there is no such file, or no mesh in it.
pub fn mesh(folder: &Path, stem: &str) -> Result<Mesh, Failure> {
    let names = Format::EXTENSIONS.map(|extension| {
        [
            format!("{stem}.{extension}"),
            format!("{stem}.{extension}.gz"),
        ]
    });
    let mut files = names.as_flattened().iter().map(|name| folder.join(name));
    let file = files.find(|file| file.exists());
    let file = file.ok_or_else(|| {
        format!(
            "{}: no mesh {}",
            folder.display(),
            names.as_flattened().join(" or ")
        )
    })?;
    Ok(load(&file)?.mesh)
}

/// Reads a pose list: 12 numbers a line, row-major `[R|t]` of B in A's frame; `#` comments and blank lines are skipped.
///
/// # Errors
/// If the file cannot be read; lines that hold no pose are listed with the others.
pub fn poses(file: &Path) -> Result<Vec<Listed<Pose>>, FileError> {
    listed(file, parse)
}

/// Reads a list of motions of B in A's frame: 15 numbers a line, the first pose as above and a translation, or 24, the first
/// and the last pose of a screw; `#` comments and blank lines are skipped.
///
/// # Errors
/// If the file cannot be read; lines that hold no motion are listed with the others.
pub fn motions(file: &Path) -> Result<Vec<Listed<Motion>>, FileError> {
    listed(file, parse_motion)
}

/// Reads a list of rays: 6 numbers a line, the origin and the direction, or the ends of a segment; `#` comments and blank lines
/// are skipped.
///
/// # Errors
/// If the file cannot be read; lines that hold no ray are listed with the others.
pub fn rays(file: &Path, are_segments: bool) -> Result<Vec<Listed<Ray>>, FileError> {
    listed(file, |fields| parse_ray(fields, are_segments))
}

/// Reads a list of points: 3 numbers a line; `#` comments and blank lines are skipped.
///
/// # Errors
/// If the file cannot be read; lines that hold no point are listed with the others.
pub fn points(file: &Path) -> Result<Vec<Listed<[f64; 3]>>, FileError> {
    listed(file, |fields| {
        let point: [f64; 3] = numbers(fields)?;
        let limit = f64::exp2(1000.0);
        match point.iter().position(|x| x.is_nan() || x.abs() > limit) {
            None => Ok(point),
            Some(axis) => Err(format!(
                "{} is not finite or exceeds 2^1000",
                ["x", "y", "z"][axis]
            )),
        }
    })
}

fn parse_ray(fields: &[&str], is_segment: bool) -> Result<Ray, String> {
    let [x, y, z, u, v, w] = numbers(fields)?;
    let (origin, other) = ([x, y, z], [u, v, w]);
    let ray = if is_segment {
        Ray::segment(origin, other)
    } else {
        Ray::new(origin, other)
    };
    ray.map_err(|error| error.to_string())
}

fn listed<T>(
    file: &Path,
    parse: impl Fn(&[&str]) -> Result<T, String>,
) -> Result<Vec<Listed<T>>, FileError> {
    let bytes = std::fs::read(file).map_err(|error| FileError::from_io(file, &error))?;
    let text = decode(&bytes);
    let lines = lines(&text)
        .map(fields)
        .zip(1..)
        .filter(|(fields, _)| !fields.is_empty());
    Ok(lines
        .map(|(fields, line)| Listed {
            line,
            entry: parse(&fields),
        })
        .collect())
}

fn parse_motion(fields: &[&str]) -> Result<Motion, String> {
    let [start, rest] = match fields.len() {
        15 | 24 => fields.split_at(12).into(),
        count => {
            return Err(format!(
                "{count} fields instead of the 15 of a pose and a translation or the 24 of two poses"
            ));
        }
    };
    let start = parse(start).map_err(|what| format!("first pose: {what}"))?;
    if rest.len() == 12 {
        let end = parse(rest).map_err(|what| format!("last pose: {what}"))?;
        return Motion::screw(start, end).map_err(|error| error.to_string());
    }
    let translation: [f64; 3] = numbers(rest).map_err(|what| format!("translation: {what}"))?;
    Motion::straight(start, translation).map_err(|error| error.to_string())
}

fn parse(fields: &[&str]) -> Result<Pose, String> {
    Pose::from_row_major(numbers(fields)?).map_err(|error| error.to_string())
}
