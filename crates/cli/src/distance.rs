//! `punctual distance`: two meshes, a list of poses, how far apart they are at each, bounded within a budget.

use std::io::{self, Write};
use std::time::Instant;

use clap::ValueEnum;
use punctual::distance::{Bounds, Distance};
use punctual::{Answer, PairMemory, Pose, Query, Tree};
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{
    Input, LoadedInput, Row, Running, SolidArgs, parse_size, print_rows, print_source, vector,
    yes_or_no,
};
use crate::view::{self, ViewArgs};

/// How far apart two meshes are at each pose of a list.
///
/// Prints CSV, a line for each pose: low <= distance <= high, both proven, also where a budget ended the query; the closest
/// triangles found, counted from 0, and their closest points in A's frame, one point twice where the triangles meet
/// (empty if
/// none was found yet, high is then inf);
/// closer is the answer to --closer-than: yes, no (both proven), undecided, or empty if it was not asked; ns is the least
/// time of all sweeps, pose update included; stop tells why the query ended, or error; work is in work units. All but ns
/// are of the first sweep. high is 0 only where the surfaces meet, and there always, unless a budget, --closer-than or
/// --leave-contact-open ended the query before. Lengths are in the unit of the meshes.
///
/// A query ends as soon as it is known whether the surfaces meet, and high - low is a millionth of the larger mesh's unit
/// length, which is about half of its longest extent, or, of meshes that are more than 64 such lengths apart, a
/// hundred-thousandth of low. One of --mode exact, --rel, --abs and --closer-than asks for something
/// else.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    #[command(flatten)]
    goal: Goal,
    /// Be content with high <= E of --abs, even where it is open then whether the surfaces meet.
    #[arg(long, requires = "abs")]
    leave_contact_open: bool,
    #[command(flatten)]
    running: Running,
    /// Take the poses as consecutive frames: begin with the triangles that were closest in the one before.
    #[arg(long)]
    memory: bool,
    /// Thicken each of the two surfaces by M: the distance is less by 2 M, and 0 if that is negative.
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = parse_size, allow_negative_numbers = true)]
    margin: f64,
    #[command(flatten)]
    solid: SolidArgs,
    #[command(flatten)]
    view: ViewArgs,
}

#[derive(clap::Args)]
#[group(multiple = false)]
struct Goal {
    /// How close the bounds are to be.
    #[arg(long, value_enum)]
    mode: Option<ModeName>,
    /// Stop as soon as high <= (1 + E) low.
    #[arg(long, value_name = "E", value_parser = parse_size, allow_negative_numbers = true)]
    rel: Option<f64>,
    /// Stop as soon as high - low <= E.
    #[arg(long, value_name = "E", value_parser = parse_size, allow_negative_numbers = true)]
    abs: Option<f64>,
    /// Ask only whether the distance is at most D, and stop as soon as that is known.
    #[arg(long, value_name = "D", value_parser = parse_size, allow_negative_numbers = true)]
    closer_than: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ModeName {
    /// As close as f64 can tell
    Exact,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let LoadedInput { a, b, build, poses } = args.input.load(&args.solid.options())?;
    args.input.complain_of_open([&a, &b]);
    let completion = args.input.complain_of_bad_poses(&poses);
    let mut workspace = args.running.workspace();
    let begin = || args.memory.then(PairMemory::new);
    let rows = args.running.answers(&poses, begin, |pose, memory, budget| {
        let start = Instant::now();
        let query = args.query(&a, &b, *pose);
        let found = query
            .with_memory(memory.as_mut())
            .run(&mut workspace, budget);
        Some((found, [start.elapsed()]))
    });
    print_source(out, build)?;
    args.print(out, &rows)?;
    args.view.write(
        args.input.meshes.up(),
        view::answered(&poses, &rows),
        |(pose, (found, _))| {
            punctual_view::distance(
                &args.input.bodies([&a, &b]),
                args.query(&a, &b, *pose),
                pose,
                found,
            )
        },
    )?;
    Ok(completion)
}

impl Args {
    fn query<'t>(&self, a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t, Distance> {
        let query = self
            .goal
            .of(Query::distance(a, b, pose))
            .margins([self.margin; 2]);
        query.leave_contact_open(self.leave_contact_open)
    }

    fn print(&self, out: &mut impl Write, rows: &[Row<Answer<Bounds>>]) -> io::Result<()> {
        let header = format!(
            "pose,low,high,triangle_a,triangle_b,ax,ay,az,bx,by,bz,closer,ns,stop,work{}",
            self.solid.header()
        );
        let none = format!(",,,,,,,,,,,0,error,0{}", self.solid.field(None));
        print_rows(out, &header, rows, &none, |said, ns| {
            let Bounds {
                low,
                high,
                nearest,
                closer,
                within,
                ..
            } = said.value;
            let nearest = nearest.map_or(",,,,,,,".to_owned(), |nearest| {
                let ([a, b], [p, q]) = (nearest.triangles, nearest.points.map(vector));
                format!("{a},{b},{p},{q}")
            });
            let asked = self.goal.closer_than.is_some();
            let closer = if asked { yes_or_no(closer) } else { "" };
            let (stop, work) = (said.stop, said.stats.work);
            let within = self.solid.field(within);
            format!("{low},{high},{nearest},{closer},{ns},{stop},{work}{within}")
        })
    }
}

impl Goal {
    fn of<'t>(&self, query: Query<'t, Distance>) -> Query<'t, Distance> {
        let exact = query.absolute_tolerance(0.0);
        match *self {
            Self {
                closer_than: Some(limit),
                ..
            } => query.closer_than(limit),
            Self {
                abs: Some(length), ..
            } => query.absolute_tolerance(length),
            Self {
                rel: Some(share), ..
            } => exact.relative_tolerance(share),
            Self {
                mode: Some(ModeName::Exact),
                ..
            } => exact,
            Self { mode: None, .. } => query,
        }
    }
}
