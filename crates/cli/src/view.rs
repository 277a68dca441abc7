//! `--view`: a page that shows the meshes of a query, and what it knows after one budget of work or another.

mod arrays;
mod contacts;
mod distance;
mod ladder;
mod motion;
mod page;
mod pair;
mod scene;
mod stage;

pub use contacts::contacts;
pub use distance::distance;
pub use motion::motion;
pub use page::View;
pub use pair::pair;
pub use scene::{Frame, scene, stride};
pub use stage::{count, fact};

use std::path::{Path, PathBuf};

use punctual::{Pose, Tree};
use punctual_lab::files::ListedPose;
use punctual_lab::report::{self, Failure};

/// Two meshes by the names of their files, and their trees.
pub struct Bodies<'t> {
    names: [String; 2],
    trees: [&'t Tree; 2],
}

impl<'t> Bodies<'t> {
    pub fn new(files: [&Path; 2], trees: [&'t Tree; 2]) -> Self {
        let name = |file: &Path| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        Self { names: files.map(name), trees }
    }

    fn title(&self, what: &str) -> String {
        format!("{what}: {} and {}", self.names[0], self.names[1])
    }

    /// Their lines of the key.
    fn key(&self) -> [(&'static str, String); 2] {
        let [a, b] = self.names.clone();
        [("a", format!("A: {a}")), ("b", format!("B: {b}"))]
    }
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

/// Poses with what was answered at them; `None` where a line holds no pose.
pub fn answered<'r, T>(
    poses: &'r [ListedPose],
    rows: &'r [Option<T>],
) -> impl Iterator<Item = Option<(&'r Pose, &'r T)>> {
    poses.iter().zip(rows).map(|(listed, row)| Some((listed.pose.as_ref().ok()?, row.as_ref()?)))
}

impl ViewArgs {
    /// Writes the page, if it is asked for, of one of `entries`; `None` is one that could not be read.
    pub fn write<T>(
        &self,
        mut entries: impl Iterator<Item = Option<T>>,
        show: impl FnOnce(T) -> Result<View, Failure>,
    ) -> Result<(), Failure> {
        let (Some(file), at) = (&self.view, self.view_pose) else { return Ok(()) };
        let entry = entries.nth(at).ok_or_else(|| format!("--view-pose {at}: the list has no such entry"))?;
        let entry = entry.ok_or_else(|| format!("--view-pose {at}: this entry was not understood"))?;
        report::write(file, show(entry)?.html()?)
    }
}
