//! `punctual motion`: two meshes, a list of motions, until when each is free, within a budget.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

use punctual::clock::SystemClock;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Motion, PairMemory, Query, Tree, Workspace};
use punctual_lab::files::{self, Listed};
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{
    MeshArgs, Row, Running, complain_of_bad_lines, least_times, parse_size, print_source,
};
use crate::view::{self, ViewArgs};

/// Until when the motions of a list are free, and when the meshes meet.
///
/// Prints CSV, a line for each motion, which takes one unit of time: the meshes meet at no time before free_until, which is
/// proven, also where a budget ended the query; at touching_at they do, at the triangles named, counted from 0. touching_at is
/// empty where no contact was found: with a free_until of 1 the motion is free to its end. ns is the least time of all sweeps
/// over the list; stop tells why the query ended, or error; work is in work units. All but ns are of the first sweep.
///
/// A query ends when nothing moves farther between free_until and touching_at than about a millionth of the longest
/// extent of
/// the smaller mesh; --tolerance asks for something else. After a graze in which no contact can be proven it looks on:
/// touching_at may be later then, or empty although free_until is less than 1.
#[derive(clap::Args)]
pub struct Args {
    /// Mesh A, which stays as it is in its file: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or one of these with .gz; - is
    /// standard
    /// input, whose format its content tells.
    a: PathBuf,
    /// Mesh B, which moves.
    b: PathBuf,
    /// Motions of B in A's frame, one a line: 15 numbers, the rows of the first pose [R|t] and a translation, or 24, the rows of
    /// the first and of the last pose, between which it goes on a screw; `#` begins a comment.
    ///
    /// A line that holds no motion gives a row that says `error` and a message on standard error; the others are answered, and
    /// the exit status is 1.
    sweeps: PathBuf,
    #[command(flatten)]
    meshes: MeshArgs,
    /// How far B may move between free_until and touching_at, in the unit of the meshes; 0 is as close as f64 can tell.
    #[arg(long, value_name = "D", value_parser = parse_size, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    #[command(flatten)]
    running: Running,
    /// Take the motions as consecutive: begin with the triangles that met in the one before.
    #[arg(long)]
    memory: bool,
    /// Thicken each of the two surfaces by M.
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = parse_size, allow_negative_numbers = true)]
    margin: f64,
    #[command(flatten)]
    view: ViewArgs,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let (a, b) = (args.meshes.load(&args.a)?, args.meshes.load(&args.b)?);
    let motions = files::motions(&args.sweeps)?;
    let start = Instant::now();
    let (a, b) = (Tree::new(a), Tree::new(b));
    let build = start.elapsed();
    let completion = complain_of_bad_lines(&args.sweeps, "sweep", &motions);
    let mut workspace = args.running.workspace();
    let rows = least_times(args.running.reps, || {
        args.sweep(&a, &b, &motions, &mut workspace)
    });
    print_source(out, build)?;
    print(out, &rows)?;
    args.view.write(
        args.meshes.up(),
        view::answered(&motions, &rows),
        |(motion, (passage, _))| {
            let bodies = view::bodies([&args.a, &args.b], [&a, &b]);
            punctual_view::motion(&bodies, args.query(&a, &b, *motion), passage)
        },
    )?;
    Ok(completion)
}

impl Args {
    fn query<'t>(&self, a: &'t Tree, b: &'t Tree, motion: Motion) -> Query<'t, Impact> {
        let query = Query::impact(a, b, motion).margins([self.margin; 2]);
        self.tolerance
            .map_or(query, |length| query.tolerance(length))
    }

    /// All motions once.
    fn sweep(
        &self,
        a: &Tree,
        b: &Tree,
        motions: &[Listed<Motion>],
        workspace: &mut Workspace,
    ) -> Vec<Row<Answer<TimeOfImpact>>> {
        let clock = SystemClock::default();
        let mut memory = self.memory.then(PairMemory::new);
        let mut answer = |&motion: &Motion| {
            let start = Instant::now();
            let found = self
                .query(a, b, motion)
                .with_memory(memory.as_mut())
                .run(workspace, self.running.limits.budget().clock(&clock));
            (found, start.elapsed())
        };
        motions
            .iter()
            .map(|listed| listed.entry.as_ref().ok().map(&mut answer))
            .collect()
    }
}

fn print(out: &mut impl Write, rows: &[Row<Answer<TimeOfImpact>>]) -> io::Result<()> {
    writeln!(
        out,
        "sweep,free_until,touching_at,triangle_a,triangle_b,ns,stop,work"
    )?;
    for (i, row) in rows.iter().enumerate() {
        let Some((passage, least)) = row else {
            writeln!(out, "{i},,,,,0,error,0")?;
            continue;
        };
        write!(out, "{i},{},", passage.value.lower)?;
        match (passage.value.upper, passage.value.triangles) {
            (Some(time), Some([a, b])) => write!(out, "{time},{a},{b}")?,
            _ => write!(out, ",,")?,
        }
        writeln!(
            out,
            ",{},{},{}",
            least.as_nanos(),
            passage.stop,
            passage.stats.work
        )?;
    }
    Ok(())
}
