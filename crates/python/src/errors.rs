//! Errors of the library as exceptions, with its texts.

use core::fmt::Display;
use punctual::points::PointError;
use punctual_io::FileError;
use punctual_robot::RobotError;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::{PyErr, PyResult};
use std::io;

pyo3::create_exception!(
    punctual3d,
    UndecidedError,
    PyRuntimeError,
    "A truth value was asked for that is not known: the budget ended first."
);
pyo3::create_exception!(
    punctual3d,
    ResumeError,
    PyRuntimeError,
    "There is no stopped run to go on with, or none at all."
);

/// An argument that cannot be used.
pub fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A file that cannot be used: FileNotFoundError and its like where the system did not open it, else OSError.
pub fn file_error(error: &FileError) -> PyErr {
    io::Error::new(
        error.kind().unwrap_or(io::ErrorKind::Other),
        error.to_string(),
    )
    .into()
}

/// The same of a robot, or of a mesh that it names; else ValueError.
pub fn robot_error(error: &RobotError) -> PyErr {
    match error {
        RobotError::File {
            kind: Some(kind), ..
        } => io::Error::new(*kind, error.to_string()).into(),
        _ => value_error(error),
    }
}

/// A tree without an inside, where that is asked for.
pub fn not_solid() -> PyErr {
    value_error("the tree was not built as a solid: build it with solid=\"keep\", or \"flip\"")
}

/// A point that cannot be asked about, or a tree without an inside.
pub fn point_error(error: PointError) -> PyErr {
    match error {
        PointError::NotSolid => not_solid(),
        error => value_error(error),
    }
}

/// Refuses numbers that are negative or no numbers, by name.
pub fn not_negative(
    numbers: impl IntoIterator<Item = (&'static str, Option<f64>)>,
) -> PyResult<()> {
    for (what, number) in numbers {
        // NaN is not in order with 0.
        if let Some(number) = number
            .filter(|number| !matches!(number.partial_cmp(&0.0), Some(order) if order.is_ge()))
        {
            return Err(value_error(format_args!(
                "{what} is {number}, expected a number that is not negative"
            )));
        }
    }
    Ok(())
}

/// Refuses those and infinite ones.
pub fn finite(numbers: impl IntoIterator<Item = (&'static str, Option<f64>)>) -> PyResult<()> {
    for (what, number) in numbers {
        not_negative([(what, number)])?;
        if number == Some(f64::INFINITY) {
            return Err(value_error(format_args!(
                "{what} is inf, expected a finite number"
            )));
        }
    }
    Ok(())
}

pub fn resume_error(_: punctual::ResumeError) -> PyErr {
    ResumeError::new_err(
        "the query has no run to go on with: it was not run, or its last run is complete",
    )
}

pub fn undecided(what: &str, stop: punctual::StopReason) -> PyErr {
    UndecidedError::new_err(format!(
        "not known whether {what}: the query ended before ({stop})"
    ))
}
