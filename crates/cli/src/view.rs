//! `--view`: a page that shows the meshes of a query, and what it knows after one budget of work or another.

use std::path::{Path, PathBuf};

use punctual::{ResumeError, Tree};
use punctual_lab::files::Listed;
use punctual_lab::report::{self, Failure};
use punctual_view::{Bodies, Up, View};

/// Two meshes by the names of their files, and their trees.
pub fn bodies<'t>(files: [&Path; 2], trees: [&'t Tree; 2]) -> Bodies<'t> {
    let name = |file: &Path| {
        file.file_name()
            .unwrap_or(file.as_os_str())
            .to_string_lossy()
            .into_owned()
    };
    Bodies::new(files.map(name), trees)
}

#[derive(clap::Args)]
pub struct ViewArgs {
    /// Write a page that shows the meshes in a browser, with what the query knows after each of a ladder of budgets of work:
    /// what it found, and the boxes that it has not looked at. It needs no other file and no network.
    #[arg(long, value_name = "FILE")]
    view: Option<PathBuf>,
    /// The entry of the list that --view shows, counted from 0.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "view")]
    view_pose: usize,
}

/// The entries of a list with what was answered to them; `None` where a line holds none.
pub fn answered<'r, E, T>(
    list: &'r [Listed<E>],
    rows: &'r [Option<T>],
) -> impl Iterator<Item = Option<(&'r E, &'r T)>> {
    list.iter()
        .zip(rows)
        .map(|(listed, row)| Some((listed.entry.as_ref().ok()?, row.as_ref()?)))
}

impl ViewArgs {
    /// Writes the page, if it is asked for, of one of `entries`; `None` is one that could not be read. `up` is what
    /// points up
    /// in the picture.
    pub fn write<T>(
        &self,
        up: Up,
        mut entries: impl Iterator<Item = Option<T>>,
        show: impl FnOnce(T) -> Result<View, ResumeError>,
    ) -> Result<(), Failure> {
        let (Some(file), at) = (&self.view, self.view_pose) else {
            return Ok(());
        };
        let entry = entries
            .nth(at)
            .ok_or_else(|| format!("--view-pose {at}: the list has no such entry"))?;
        let entry =
            entry.ok_or_else(|| format!("--view-pose {at}: this entry was not understood"))?;
        report::write(file, show(entry)?.up(up).html()?)
    }
}
