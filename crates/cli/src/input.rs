//! What the commands that go through a list have in common: its entries, the budget of each query, sweeps.
//!
//! The structs of arguments have no doc comments: these would replace those of the commands.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::ProgressStyle;
use indicatif::style::TemplateError;
use punctual::clock::{ClockedBudget, SystemClock};
use punctual::glam::DVec3;
use punctual::intersection::Operand;
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Mesh, Pose, Tree, Workspace};
use punctual_io::{Axis, FileError, Loaded, ReadOptions, load_with, read_with};
use punctual_lab::files::{self, Listed};
use punctual_view::{Bodies, Up};

use crate::{Completion, complain, view};

#[derive(clap::Args)]
pub struct MeshArgs {
    /// Multiply the coordinates of mesh files by S, such as 0.001 for files in millimetres, or by a factor for each axis,
    /// X,Y,Z, such as 1,1,-1 to mirror; not those of poses, motions or rays.
    #[arg(long, value_name = "S|X,Y,Z", default_value = "1", value_parser = parse_scale, allow_hyphen_values = true)]
    scale: [f64; 3],
    /// The axis that points up in mesh files: turn the meshes such that z does. From y, (x, y, z) becomes (x, -z, y);
    /// from x,
    /// (-z, y, x). Pages of --view have z up then; without it they guess.
    #[arg(long, value_name = "UP", value_parser = ["x", "y", "z"])]
    up: Option<String>,
}

impl MeshArgs {
    /// The tree of a mesh file, of points, or of a shape, and how long its build took.
    pub fn tree(&self, file: &Path, options: &BuildOptions) -> Result<(Tree, Duration), FileError> {
        let fault = |what: String| FileError::new(file, &*what);
        let name = file.to_string_lossy();
        let shape = name.split_once(':');
        if let Some(("thick", rest)) = shape {
            let parts = rest.split_once(',');
            let parts = parts.and_then(|(radius, file)| Some((radius.parse().ok()?, file)));
            let (radius, of) = parts.ok_or_else(|| fault("must be thick:R,FILE".into()))?;
            let (tree, build) = self.tree(Path::new(of), options)?;
            let thick = tree.with_radius(radius);
            return Ok((thick.map_err(|error| fault(error.to_string()))?, build));
        }
        if let Some(tree) = shape.and_then(|(kind, lengths)| shape_of(kind, lengths)) {
            return Ok((tree.map_err(fault)?, Duration::ZERO));
        }
        let mesh = self.load(file)?;
        let start = Instant::now();
        let tree = Tree::with_options(mesh, options);
        Ok((tree, start.elapsed()))
    }

    /// Reads a mesh file, or standard input for `-`, and tells what was passed over.
    pub fn load(&self, file: &Path) -> Result<Mesh, FileError> {
        let Loaded { mesh, notices, .. } = self.load_quietly(file)?;
        notices
            .iter()
            .for_each(|notice| complain(&notice.in_file(file)));
        Ok(mesh)
    }

    /// What is up in pictures of the meshes that were read.
    pub fn up(&self) -> Up {
        if self.up.is_some() { Up::Z } else { Up::Guess }
    }

    /// Reads a mesh file, or standard input for `-`.
    pub fn load_quietly(&self, file: &Path) -> Result<Loaded, FileError> {
        let up = match self.up.as_deref() {
            Some("x") => Axis::X,
            Some("y") => Axis::Y,
            _ => Axis::Z,
        };
        let options = ReadOptions::default().scale_axes(self.scale).up(up);
        if file.as_os_str() != "-" {
            return load_with(file, &options);
        }
        let mut bytes = Vec::new();
        std::io::stdin()
            .lock()
            .read_to_end(&mut bytes)
            .map_err(|error| FileError::from_io(file, &error))?;
        if bytes.is_empty() {
            return Err(FileError::new(
                file,
                "nothing in standard input, which can be read once",
            ));
        }
        // Buffers of glTF text are files of their own.
        read_with(&bytes, None, &options.folder(".")).map_err(|error| FileError::new(file, error))
    }
}

/// The tree of a shape, or why there is none of these lengths; `None` for another kind of file.
fn shape_of(kind: &str, lengths: &str) -> Option<Result<Tree, String>> {
    let tree = match (kind, numbers(lengths).as_deref()) {
        ("ball", Some(&[radius])) => Tree::ball(radius),
        ("capsule", Some(&[radius, length])) => Tree::capsule(radius, length),
        ("box", Some(&[x, y, z])) => Tree::cuboid([x, y, z]),
        ("cylinder", Some(&[radius, length])) => Tree::cylinder(radius, length),
        ("cone", Some(&[radius, length])) => Tree::cone(radius, length),
        ("ball" | "capsule" | "box" | "cylinder" | "cone", _) => {
            let known = "ball:R, capsule:R,L, box:X,Y,Z, cylinder:R,L or cone:R,L";
            return Some(Err(format!("must be {known}")));
        }
        _ => return None,
    };
    Some(tree.map_err(|error| error.to_string()))
}

#[derive(clap::Args)]
pub struct Input {
    /// Mesh A, which stays as it is in its file: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or one of these with .gz; - is
    /// standard
    /// input, whose format its content tells.
    ///
    /// Also a point cloud, .xyz, .pts, .asc, .txt, .csv, .pcd or .npy; a shape, ball:R, capsule:R,L, box:X,Y,Z, cylinder:R,L or
    /// cone:R,L; or one of these files thickened by a radius, thick:R,FILE.
    a: PathBuf,
    /// Mesh B, which takes the poses.
    b: PathBuf,
    /// Poses of B in A's frame: 12 numbers a line, the rows of [R|t]; `#` begins a comment.
    ///
    /// A line that holds no rigid pose gives a row that says `error` and a message on standard error; the others are
    /// answered, and the exit status is 1.
    poses: PathBuf,
    #[command(flatten)]
    pub meshes: MeshArgs,
}

/// The files, read.
pub struct LoadedInput {
    pub a: Tree,
    pub b: Tree,
    /// What it took to build both trees.
    pub build: Duration,
    pub poses: Vec<Listed<Pose>>,
}

impl Input {
    pub fn load(&self, options: &BuildOptions) -> Result<LoadedInput, FileError> {
        let (a, of_a) = self.meshes.tree(&self.a, options)?;
        let (b, of_b) = self.meshes.tree(&self.b, options)?;
        let (build, poses) = (of_a + of_b, files::poses(&self.poses)?);
        Ok(LoadedInput { a, b, build, poses })
    }

    /// Tells which meshes that were to be solids are open.
    pub fn complain_of_open(&self, trees: [&Tree; 2]) {
        complain_of_open(&self.a, trees[0]);
        complain_of_open(&self.b, trees[1]);
    }

    /// The trees, with the names of the files.
    pub fn bodies<'t>(&self, trees: [&'t Tree; 2]) -> Bodies<'t> {
        view::bodies([&self.a, &self.b], trees)
    }

    /// Tells which lines hold no pose.
    pub fn complain_of_bad_poses(&self, poses: &[Listed<Pose>]) -> Completion {
        complain_of_bad_lines(&self.poses, "pose", poses)
    }
}

#[derive(clap::Args)]
#[group(id = "budget", multiple = false)]
pub struct Limits {
    /// Time budget of a query in microseconds; none without it.
    #[arg(long, value_name = "T", value_parser = parse_microseconds, allow_negative_numbers = true)]
    budget_us: Option<Duration>,
    /// Work budget of a query in work units (BV tests and weighted triangle tests); the same answer on every run.
    #[arg(long, value_name = "N")]
    budget_work: Option<u64>,
}

#[derive(clap::Args)]
pub struct Running {
    /// Sweeps over the whole list; ns is the least of them.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub reps: u32,
    #[command(flatten)]
    pub limits: Limits,
    /// Use the kernels that run everywhere, not the best that this machine has: slower, the same bits.
    #[arg(long)]
    portable: bool,
}

impl Running {
    pub fn workspace(&self) -> Workspace {
        self.prepared(Workspace::new())
    }

    /// Answers the entries of a list within the budget, as often as is asked: the answers of the first sweep, each with
    /// the least time that it took. `begin` makes what one sweep carries from entry to entry.
    pub fn answers<E, M, T, const N: usize>(
        &self,
        list: &[Listed<E>],
        begin: impl Fn() -> M,
        mut answer: impl FnMut(&E, &mut M, ClockedBudget<'_>) -> Row<T, N>,
    ) -> Vec<Row<T, N>> {
        let clock = SystemClock::default();
        least_times(self.reps, || {
            let mut carried = begin();
            let mut of_line = |listed: &Listed<E>| {
                let budget = self.limits.budget().clock(&clock);
                answer(listed.entry.as_ref().ok()?, &mut carried, budget)
            };
            list.iter().map(&mut of_line).collect()
        })
    }

    /// A workspace that uses the kernels that are asked for.
    pub fn prepared(&self, mut workspace: Workspace) -> Workspace {
        if self.portable {
            workspace.use_portable_kernels();
        }
        workspace
    }
}

/// Tells if a mesh that was to be a solid has open parts.
pub fn complain_of_open(file: &Path, tree: &Tree) {
    let open = tree.solid().map_or(0, |solid| solid.open_edges());
    if open > 0 {
        let (file, why) = (file.display(), "its open parts are surfaces");
        complain(&format!("{file}: {why}, it has {open} open edges"));
    }
}

/// The options of trees of meshes that are taken for solids, or for surfaces.
pub fn build_options(solid: bool) -> BuildOptions {
    BuildOptions::default().solid(if solid { Solid::Keep } else { Solid::No })
}

#[derive(clap::Args)]
pub struct SolidArgs {
    /// Take both meshes for solids: where a part of one is inside the other, which is closed, they meet although their
    /// surfaces do not. A last column, within, names the inner one, a or b.
    #[arg(long)]
    pub solid: bool,
}

impl SolidArgs {
    pub fn options(&self) -> BuildOptions {
        build_options(self.solid)
    }

    /// What stands at the end of the header.
    pub fn header(&self) -> &'static str {
        if self.solid { ",within" } else { "" }
    }

    /// What stands at the end of a row.
    pub fn field(&self, within: Option<Operand>) -> &'static str {
        match within {
            _ if !self.solid => "",
            None => ",",
            Some(Operand::A) => ",a",
            Some(Operand::B) => ",b",
        }
    }
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
    Duration::try_from_secs_f64(microseconds * 1e-6)
        .map_err(|_| "must be finite and not negative".to_owned())
}

/// Numbers between commas.
fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|x| x.trim().parse().ok()).collect()
}

/// One factor, or one for each axis.
fn parse_scale(text: &str) -> Result<[f64; 3], String> {
    let factors = match numbers(text).as_deref() {
        Some(&[all]) => [all; 3],
        Some(&[x, y, z]) => [x, y, z],
        _ => return Err("must be a number, or three with commas".into()),
    };
    let is_good = |factor: &f64| *factor != 0.0 && factor.is_finite();
    let good = factors.iter().all(is_good);
    good.then_some(factors)
        .ok_or_else(|| "must be finite and not 0".into())
}

/// A length or a share.
pub fn parse_size(text: &str) -> Result<f64, String> {
    let size: f64 = text.parse().map_err(|_| "must be a number".to_owned())?;
    if size >= 0.0 && size.is_finite() {
        Ok(size)
    } else {
        Err("must be finite and not negative".into())
    }
}

/// An answer and the times that its parts took; none where a line holds nothing to answer.
pub type Row<T, const N: usize = 1> = Option<(T, [Duration; N])>;

/// The comment above the columns: the program, its version, and the time of the build in nanoseconds.
pub fn print_source(out: &mut impl Write, build: Duration) -> io::Result<()> {
    let (version, build) = (env!("CARGO_PKG_VERSION"), build.as_nanos());
    writeln!(out, "# peer=punctual version={version} build_ns={build}")
}

/// Prints a table: `line` gives what stands behind the number of a row, of the answer and of the
/// nanoseconds that it took, and `none` where there was nothing to answer.
pub fn print_rows<T>(
    out: &mut impl Write,
    header: &str,
    rows: &[Row<T>],
    none: &str,
    line: impl Fn(&T, u128) -> String,
) -> io::Result<()> {
    writeln!(out, "{header}")?;
    for (i, row) in rows.iter().enumerate() {
        match row {
            Some((answer, [least])) => writeln!(out, "{i},{}", line(answer, least.as_nanos()))?,
            None => writeln!(out, "{i},{none}")?,
        }
    }
    Ok(())
}

/// What is known of a question, in a word.
pub fn yes_or_no(answer: Option<bool>) -> &'static str {
    match answer {
        Some(true) => "yes",
        Some(false) => "no",
        None => "undecided",
    }
}

/// Three coordinates, between commas.
pub fn vector(DVec3 { x, y, z }: DVec3) -> String {
    format!("{x},{y},{z}")
}

/// The progress bar of long work. It is drawn on standard error, and only on a terminal.
pub fn progress_style() -> Result<ProgressStyle, TemplateError> {
    ProgressStyle::with_template("{bar:30} {percent} %, {eta} left  {msg}")
}

/// Sweeps over a list so many times: the answers of the first time, each with the least time that it took.
pub fn least_times<T, const N: usize>(
    sweeps: u32,
    mut sweep: impl FnMut() -> Vec<Row<T, N>>,
) -> Vec<Row<T, N>> {
    let mut rows = sweep();
    for _ in 1..sweeps {
        for (row, again) in rows.iter_mut().zip(sweep()) {
            if let (Some((_, least)), Some((_, times))) = (row, again) {
                *least = std::array::from_fn(|i| times[i].min(least[i]));
            }
        }
    }
    rows
}

/// Tells which lines of a file hold none of the entries that it is a list of, and why.
pub fn complain_of_bad_lines<T>(file: &Path, kind: &str, list: &[Listed<T>]) -> Completion {
    let mut completion = Completion::Full;
    for (i, listed) in list.iter().enumerate() {
        if let Err(what) = &listed.entry {
            complain(&FileError::at_line(
                file,
                listed.line,
                format!("{kind} {i}: {what}"),
            ));
            completion = Completion::Partial;
        }
    }
    completion
}
