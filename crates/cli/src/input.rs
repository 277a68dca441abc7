//! What `pair` and `distance` have in common: two meshes, a list of poses, a budget for each query.
//!
//! The structs of arguments have no doc comments: these would replace those of the commands.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use punctual::{Budget, BuildOptions, Tree};
use punctual_io::{FileError, load};
use punctual_lab::files::{self, ListedPose};
use punctual_view::Bodies;

use crate::{Completion, complain, view};

#[derive(clap::Args)]
pub struct Input {
    /// Mesh A, which stays as it is in its file: .obj, .stl, .ply or .glb.
    a: PathBuf,
    /// Mesh B, which takes the poses.
    b: PathBuf,
    /// Poses of B in A's frame: 12 numbers a line, the rows of [R|t]; `#` begins a comment.
    ///
    /// A line that holds no rigid pose gives a row that says `error` and a message on standard error; the others are
    /// answered, and the exit status is 1.
    poses: PathBuf,
}

/// The files, read.
pub struct Loaded {
    pub a: Tree,
    pub b: Tree,
    /// What it took to build both trees.
    pub build: Duration,
    pub poses: Vec<ListedPose>,
}

impl Input {
    pub fn load(&self, options: &BuildOptions) -> Result<Loaded, FileError> {
        let (a, b) = (load(&self.a)?, load(&self.b)?);
        let poses = files::poses(&self.poses)?;
        let start = Instant::now();
        let (a, b) = (Tree::with_options(a, options), Tree::with_options(b, options));
        Ok(Loaded { a, b, build: start.elapsed(), poses })
    }

    /// The trees, with the names of the files.
    pub fn bodies<'t>(&self, trees: [&'t Tree; 2]) -> Bodies<'t> {
        view::bodies([&self.a, &self.b], trees)
    }

    /// Tells which lines hold no pose.
    pub fn complain_of_bad_poses(&self, poses: &[ListedPose]) -> Completion {
        let faults = poses.iter().map(|listed| (listed.line, listed.pose.as_ref().err()));
        complain_of_bad_lines(&self.poses, "pose", faults)
    }
}

#[derive(clap::Args)]
#[group(id = "budget", multiple = false)]
pub struct Limits {
    /// Time budget of a query in microseconds; none without it.
    #[arg(long, value_name = "T", value_parser = parse_microseconds)]
    budget_us: Option<Duration>,
    /// Work budget of a query in work units (BV tests and weighted triangle tests); the same answer on every run.
    #[arg(long, value_name = "N")]
    budget_work: Option<u64>,
}

impl Limits {
    pub fn budget(&self) -> Budget {
        self.budget_left(Duration::ZERO, 0)
    }

    /// The budget of a query that has used some of it.
    pub fn budget_left(&self, elapsed: Duration, work: u64) -> Budget {
        match (self.budget_us, self.budget_work) {
            (Some(limit), _) => Budget::time(limit.saturating_sub(elapsed)),
            (None, Some(limit)) => Budget::work(limit.saturating_sub(work)),
            (None, None) => Budget::unlimited(),
        }
    }
}

pub fn parse_microseconds(text: &str) -> Result<Duration, String> {
    let microseconds: f64 = text.parse().map_err(|_| "must be a number".to_owned())?;
    Duration::try_from_secs_f64(microseconds * 1e-6).map_err(|error| error.to_string())
}

/// A length or a share.
pub fn parse_size(text: &str) -> Result<f64, String> {
    let size: f64 = text.parse().map_err(|_| "must be a number".to_owned())?;
    if size >= 0.0 && size.is_finite() { Ok(size) } else { Err("must be finite and not negative".into()) }
}

/// Sweeps over a list so many times: the answers of the first time, each with the least time that it took; none where a line
/// holds nothing to answer.
pub fn least_times<T>(
    sweeps: u32,
    mut sweep: impl FnMut() -> Vec<Option<(T, Duration)>>,
) -> Vec<Option<(T, Duration)>> {
    let mut rows = sweep();
    for _ in 1..sweeps {
        for (row, again) in rows.iter_mut().zip(sweep()) {
            if let (Some((_, least)), Some((_, time))) = (row, again) {
                *least = time.min(*least);
            }
        }
    }
    rows
}

/// Tells which lines of a list hold none of what it is a list of: the line of each entry, and what is wrong with it.
pub fn complain_of_bad_lines<'f>(
    list: &Path,
    entry: &str,
    faults: impl Iterator<Item = (usize, Option<&'f String>)>,
) -> Completion {
    let mut completion = Completion::Full;
    for (i, (line, fault)) in faults.enumerate() {
        if let Some(what) = fault {
            complain(&FileError::at_line(list, line, format!("{entry} {i}: {what}")));
            completion = Completion::Partial;
        }
    }
    completion
}
