//! A page that shows an answer, in a notebook or a browser.

use crate::errors::file_error;
use punctual_io::FileError;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::{fs, io};

/// A page that shows an answer: both meshes, what was found after each of a ladder of budgets, and the boxes still open;
/// or the bodies of a scene. One HTML text that needs no network.
///
/// A notebook shows it where it is the value of a cell.
#[pyclass(module = "punctual3d", frozen)]
#[derive(Serialize, Deserialize)]
pub struct View(String);

impl View {
    /// That of a page, made without the interpreter's lock and saved if a file is named.
    pub fn made(
        py: Python<'_>,
        path: Option<PathBuf>,
        html: impl FnOnce() -> io::Result<String> + Send,
    ) -> PyResult<Self> {
        let view = Self(py.detach(html)?);
        path.map_or(Ok(()), |path| view.save(py, path))?;
        Ok(view)
    }
}

#[pymethods]
impl View {
    /// The page.
    #[getter]
    fn html(&self) -> &str {
        &self.0
    }

    /// Writes the page to a file. Raises OSError if that cannot be written, FileNotFoundError without its folder.
    pub fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let written = py.detach(|| fs::write(&path, &self.0));
        written.map_err(|error| file_error(&FileError::from_io(&path, &error)))
    }

    fn _repr_html_(&self) -> String {
        format!(
            "<iframe srcdoc=\"{}\" style=\"width: 100%; height: 640px; border: 0\"></iframe>",
            punctual_view::escape(&self.0)
        )
    }

    fn __repr__(&self) -> String {
        format!("<punctual3d.View of {} kB>", self.0.len() / 1000)
    }
}
