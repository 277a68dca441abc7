//! What is wrong with a robot or a call, and where.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a robot, an obstacle or a configuration is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RobotError {
    /// A file cannot be read, or is not what it should be.
    File {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1, if the fault has one place.
        line: Option<u32>,
        /// What is wrong, with the name of the link or joint.
        what: String,
        /// Why the system did not open this file, or a mesh that it names, such as
        /// [`io::ErrorKind::NotFound`]. `None` if the content is at fault.
        kind: Option<io::ErrorKind>,
    },
    /// A link, joint or shape is out of order; the text names it.
    Model(String),
    /// A configuration has another number of values than the robot has joint values.
    Length {
        /// Joint values of the robot.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// A joint value is NaN, infinite, or so large that the robot would leave the range of numbers.
    JointValue {
        /// Row of a batch, 0 otherwise.
        row: usize,
        /// Name of the joint.
        joint: String,
    },
    /// There is no such obstacle: it was removed, or belongs to another checker.
    NoObstacle,
    /// There is no stopped edge to resume.
    NothingToResume,
}

/// An error of a link, joint or shape.
pub(crate) fn refuse<T>(what: impl Into<String>) -> Result<T, RobotError> {
    Err(RobotError::Model(what.into()))
}

/// Files as compilers name them: `FILE:LINE: what`.
impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File {
                file, line, what, ..
            } => {
                let line = line.map_or(String::new(), |line| format!("{line}:"));
                write!(f, "{}:{line} {what}", file.display())
            }
            Self::Model(what) => f.write_str(what),
            Self::Length { expected, found } => {
                write!(f, "{found} joint values, the robot has {expected}")
            }
            Self::JointValue { row, joint } => {
                write!(
                    f,
                    "configuration {row}: joint {joint} is not finite or too large"
                )
            }
            Self::NoObstacle => f.write_str("no such obstacle"),
            Self::NothingToResume => f.write_str("no stopped edge to resume"),
        }
    }
}

impl std::error::Error for RobotError {}
