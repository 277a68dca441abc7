//! What is wrong with a file, and where.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A line of a text format, counted from 1.
    Line(usize),
    /// A byte of a binary format, counted from 0.
    Byte(usize),
}

/// Why bytes hold no mesh, and where in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError {
    place: Option<Place>,
    what: String,
    kind: Option<io::ErrorKind>,
}

/// Why a file cannot be used: which one, where in it, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    file: PathBuf,
    error: ReadError,
}

impl ReadError {
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self {
            place: None,
            what: short(what.into()),
            kind: None,
        }
    }

    pub(crate) fn at(place: Place, what: impl Into<String>) -> Self {
        Self {
            place: Some(place),
            ..Self::new(what)
        }
    }

    pub(crate) fn at_line(line: usize, what: impl Into<String>) -> Self {
        Self::at(Place::Line(line), what)
    }

    /// A file that is in order, but of a kind that is not read.
    pub(crate) fn needs(what: impl fmt::Display) -> Self {
        Self::new(format!("needs {what}, which is not supported"))
    }

    /// Where it is, if the fault has one place; a node or primitive of a glTF document is named by the message.
    pub fn place(&self) -> Option<Place> {
        self.place
    }
}

impl From<&str> for ReadError {
    fn from(what: &str) -> Self {
        Self::new(what)
    }
}

impl FileError {
    /// A fault of this file.
    pub fn new(file: &Path, error: impl Into<ReadError>) -> Self {
        Self {
            file: file.to_owned(),
            error: error.into(),
        }
    }

    /// A file that cannot be opened, read or written.
    pub fn from_io(file: &Path, error: &io::Error) -> Self {
        let kind = Some(error.kind());
        let error = ReadError::new(error.to_string());
        Self::new(file, ReadError { kind, ..error })
    }

    /// A fault on a line, counted from 1, for readers of other text files than meshes.
    pub fn at_line(file: &Path, line: usize, what: impl Into<String>) -> Self {
        Self::new(file, ReadError::at_line(line, what))
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Why the system did not open, read or write the file; `None` if its content is at fault.
    pub fn kind(&self) -> Option<io::ErrorKind> {
        self.error.kind
    }

    /// Where in the file, if the fault has one place.
    pub fn place(&self) -> Option<Place> {
        self.error.place
    }
}

/// The beginning of a message: a parser may have found a million faults.
pub(crate) fn short(mut what: String) -> String {
    if let Some((end, _)) = what.char_indices().nth(300) {
        what.truncate(end);
        what += " ...";
    }
    what
}

/// Words from a file, of which control codes must not reach a terminal.
pub(crate) struct Printable<'a>(pub &'a str);

impl fmt::Display for Printable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| {
            if c.is_control() {
                write!(f, "{}", c.escape_default())
            } else {
                write!(f, "{c}")
            }
        })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = self.place {
            write!(f, "{place}: ")?;
        }
        Printable(&self.what).fmt(f)
    }
}

/// `FILE:LINE: what`, as compilers say it, or `FILE: what`.
impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file.display())?;
        match self.error.place {
            Some(Place::Line(line)) => write!(f, "{line}: {}", Printable(&self.error.what)),
            _ => write!(f, " {}", self.error),
        }
    }
}

impl std::error::Error for ReadError {}

impl std::error::Error for FileError {}
