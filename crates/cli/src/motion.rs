//! `punctual motion`: two meshes, a list of motions, until when each is free, within a budget.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

use punctual::glam::DVec3;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::{Answer, Budget, Motion, PairMemory, Pose, Query, Tree, Workspace};
use punctual_lab::files;
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{
    MeshArgs, Row, Running, SolidArgs, complain_of_bad_lines, complain_of_open, parse_size,
    print_rows, print_source,
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
///
/// With --ignore-start a contact at the start that the motion leads out of is no hit: a last column, free_from, says from which
/// time on the motion is asked. At that time the meshes are proven apart, and free_until and touching_at are about the rest. It is 0
/// for meshes that start apart, and empty, with touching_at 0, for those that do not come apart. Contacts before free_from are
/// passed over. Times after it are those of the rest of the motion, up to rounding. Looking for free_from has no budget, and does
/// not count to ns and work.
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
    solid: SolidArgs,
    /// Pass over a contact at the start if the meshes come apart before a point of B's box is farther than D from where it
    /// was. They are looked at after 2^-40, 2^-39, ... of the motion; at the first of these times at which they are proven
    /// apart, the motion begins anew. A small D, below what is thin in the meshes, keeps them from passing through each other.
    #[arg(long, value_name = "D", value_parser = parse_size, allow_negative_numbers = true)]
    ignore_start: Option<f64>,
    #[command(flatten)]
    view: ViewArgs,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let options = args.solid.options();
    let (a, of_a) = args.meshes.tree(&args.a, &options)?;
    let (b, of_b) = args.meshes.tree(&args.b, &options)?;
    let motions = files::motions(&args.sweeps)?;
    let build = of_a + of_b;
    complain_of_open(&args.a, &a);
    complain_of_open(&args.b, &b);
    let completion = complain_of_bad_lines(&args.sweeps, "sweep", &motions);
    let mut workspace = args.running.workspace();
    let begin = || args.memory.then(PairMemory::new);
    let rows = args
        .running
        .answers(&motions, begin, |&motion, memory, budget| {
            let begun = args.begin([&a, &b], motion, &mut workspace);
            let start = Instant::now();
            let query = args.query(&a, &b, begun.rest);
            let found = query
                .with_memory(memory.as_mut())
                .run(&mut workspace, budget);
            Some(((begun, found), [start.elapsed()]))
        });
    print_source(out, build)?;
    args.print(out, &rows)?;
    args.view.write(
        args.meshes.up(),
        view::answered(&motions, &rows),
        |(_, ((begun, passage), _))| {
            let bodies = view::bodies([&args.a, &args.b], [&a, &b]);
            punctual_view::motion(&bodies, args.query(&a, &b, begun.rest), passage)
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

    /// Where a motion begins: at its start, or where it has led out of a contact at its start.
    fn begin(&self, trees: [&Tree; 2], motion: Motion, workspace: &mut Workspace) -> Begun {
        let whole = |from| Begun { from, rest: motion };
        let Some(farthest) = self.ignore_start else {
            return whole(Some(0.0));
        };
        let mut is_apart = |pose: Pose| {
            let query = Query::distance(trees[0], trees[1], pose).margins([self.margin; 2]);
            let found = query.closer_than(0.0).run(workspace, Budget::unlimited());
            found.value.closer == Some(false)
        };
        if is_apart(motion.start()) {
            return whole(Some(0.0));
        }
        // No point of a box moves farther than all of its corners.
        let (low, high) = (trees[1].mesh().aabb().min, trees[1].mesh().aabb().max);
        let corners = (0..8u32).map(|i| {
            let side = |axis: usize| if i >> axis & 1 > 0 { high } else { low }[axis];
            DVec3::new(side(0), side(1), side(2))
        });
        let corners: Vec<DVec3> = corners.collect();
        let is_near = |time: &f64| {
            let [then, now] = [0.0, *time].map(|time| motion.pose(time));
            let way = |&p: &DVec3| now.transform_point(p).distance(then.transform_point(p));
            corners.iter().map(way).all(|way| way <= farthest)
        };
        let times = (0..=40).rev().map(|halvings| 0.5f64.powi(halvings));
        let from = times
            .take_while(is_near)
            .find(|&time| is_apart(motion.pose(time)));
        let begun = from.and_then(|from| {
            let rest = motion.rest(from).ok()?;
            let from = Some(from);
            Some(Begun { from, rest })
        });
        begun.unwrap_or_else(|| whole(None))
    }

    fn print(
        &self,
        out: &mut impl Write,
        rows: &[Row<(Begun, Answer<TimeOfImpact>)>],
    ) -> io::Result<()> {
        let [free_from, nothing] = match self.ignore_start {
            Some(_) => [",free_from", ","],
            None => [""; 2],
        };
        let header = format!(
            "sweep,free_until,touching_at,triangle_a,triangle_b,ns,stop,work{}{free_from}",
            self.solid.header()
        );
        let none = format!(",,,,0,error,0{}{nothing}", self.solid.field(None));
        print_rows(out, &header, rows, &none, |(begun, passage), ns| {
            let TimeOfImpact {
                lower,
                upper,
                triangles,
                within,
                ..
            } = passage.value;
            let lower = begun.time(lower);
            let upper = upper.map_or(String::new(), |time| begun.time(time).to_string());
            let triangles = triangles.map_or(",".into(), |[a, b]| format!("{a},{b}"));
            let (stop, work) = (passage.stop, passage.stats.work);
            let within = self.solid.field(within);
            let from = begun.from.map_or(String::new(), |from| from.to_string());
            let from = self
                .ignore_start
                .map_or(String::new(), |_| format!(",{from}"));
            format!("{lower},{upper},{triangles},{ns},{stop},{work}{within}{from}")
        })
    }
}

/// A motion from the time on at which it is asked.
struct Begun {
    /// `None`: from the start on, although the meshes meet there.
    from: Option<f64>,
    rest: Motion,
}

impl Begun {
    /// A time of the rest, as one of the motion.
    fn time(&self, of_rest: f64) -> f64 {
        let from = self.from.unwrap_or(0.0);
        from + of_rest * (1.0 - from)
    }
}
