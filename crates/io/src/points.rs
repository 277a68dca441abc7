//! Point clouds: text of three numbers a line, PCD, NumPy arrays, and the vertices of mesh files.

mod npy;
mod pcd;
mod xyz;

use std::path::Path;

use punctual::MeshError;

use crate::format::{Format, extension};
use crate::notice::Notices;
use crate::{FileError, Notice, ReadError, ReadOptions, refuse_pointer, surface, unpacked};

/// The points of a file, and what was passed over to get them.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Points {
    /// The points that have finite coordinates, in the order of the file.
    pub points: Vec<[f64; 3]>,
    /// What was passed over: one entry a kind, among them points without finite coordinates, as depth cameras write them.
    pub notices: Vec<Notice>,
}

/// How the points of a file are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PointFormat {
    /// Text, a point a line: `x y z` and what follows it, between blanks, commas or semicolons; `#` begins a comment. One
    /// first line without three numbers is a heading.
    Xyz,
    /// PCD of the Point Cloud Library: text, binary or compressed; the fields `x`, `y` and `z`.
    Pcd,
    /// A NumPy array of `float32` or `float64` in C order, whose last axis has x, y, z, and perhaps more.
    Npy,
    /// The vertices of a mesh file, also of one without faces.
    Mesh(Format),
}

impl PointFormat {
    /// The file name extensions of points alone, in lower case; each also with `.gz` behind it.
    pub const EXTENSIONS: [&str; 7] = ["xyz", "pts", "asc", "txt", "csv", "pcd", "npy"];

    /// The format that the extension of a file name stands for, upper or lower case, also before `.gz`.
    ///
    /// # Errors
    /// If it stands for none.
    pub fn of(file: &Path) -> Result<Self, ReadError> {
        match extension(file).as_str() {
            "xyz" | "pts" | "asc" | "txt" | "csv" => Ok(Self::Xyz),
            "pcd" => Ok(Self::Pcd),
            "npy" => Ok(Self::Npy),
            _ => Format::of(file).map(Self::Mesh).map_err(|_| {
                let known = Self::EXTENSIONS.iter().chain(&Format::EXTENSIONS);
                let known: Vec<_> = known.map(|name| format!(".{name}")).collect();
                let known = known.join(", ");
                ReadError::new(format!(
                    "no format of points by its extension; use one of {known}, or these with .gz"
                ))
            }),
        }
    }
}

/// Reads the points of a file whose extension names its format.
///
/// # Errors
/// If the file cannot be read, or holds no point; the error names the file and the place in it.
pub fn load_points(file: &Path, options: &ReadOptions) -> Result<Points, FileError> {
    let format = PointFormat::of(file).map_err(|error| FileError::new(file, error))?;
    let bytes = std::fs::read(file).map_err(|error| FileError::from_io(file, &error))?;
    let options = options.clone().in_folder_of(file);
    read_points(&bytes, format, &options).map_err(|error| FileError::new(file, error))
}

/// Reads points from the content of a file. The scale and the turn of the options apply to points as to vertices.
///
/// # Errors
/// If it holds no point, or a factor of the scale is 0, infinite or NaN; the error names the place.
pub fn read_points(
    bytes: &[u8],
    format: PointFormat,
    options: &ReadOptions,
) -> Result<Points, ReadError> {
    let is_bad = |factor: &f64| *factor == 0.0 || !factor.is_finite();
    if let Some(axis) = options.scale.iter().position(is_bad) {
        let factor = options.scale[axis];
        let error = MeshError::Factor { axis, factor };
        return Err(ReadError::new(format!("scaled: {error}")));
    }
    let bytes = unpacked(bytes, options.limits.unpacked)?;
    refuse_pointer(&bytes)?;
    let mut notices = Notices::default();
    let mut points = match format {
        PointFormat::Xyz => xyz::parse(&bytes, &mut notices)?,
        PointFormat::Pcd => pcd::parse(&bytes, options.limits.unpacked)?,
        PointFormat::Npy => npy::parse(&bytes)?,
        // What is wrong with faces is no matter.
        PointFormat::Mesh(format) => {
            surface(&bytes, format, options, &mut Notices::default())?.vertices
        }
    };
    options.turn(&mut points);
    for (k, factor) in options.scale.into_iter().enumerate() {
        points.iter_mut().for_each(|point| point[k] *= factor);
    }
    let count = points.len();
    points.retain(|point| point.iter().all(|x| x.is_finite()));
    if points.len() < count {
        let passed = count - points.len();
        notices.add(
            None,
            format!("{passed} points without finite coordinates passed over"),
        );
    }
    if points.is_empty() {
        return Err(ReadError::new(format!(
            "no points in it, {count} without finite coordinates"
        )));
    }
    Ok(Points {
        points,
        notices: notices.into_list(),
    })
}
