//! `punctual depth`: two meshes, a list of poses, how deep they penetrate each other at each, bounded within a budget.

use std::io::Write;
use std::time::Instant;

use punctual::tree::Solid;
use punctual::{Answer, BuildOptions};
use punctual_depenetrate::{Penetration, PenetrationQuery, PenetrationWorkspace};
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{
    Input, LoadedInput, Running, parse_size, print_rows, print_source, vector, yes_or_no,
};

/// How deep two meshes penetrate each other at each pose of a list: how far B has to be moved, at least, until they are apart.
///
/// Prints CSV, a line for each pose: low <= depth <= high, both proven, also where a budget ended the query. n is the unit
/// direction, in A's frame, in which B has to be moved by high: an exact query, run to its end at that pose, found them apart.
/// Where they are apart anyway, low and high are 0 and n is empty; where the budget ended before a push was found, high is inf
/// and n is empty. ns is the least time of all sweeps; stop tells why the query ended, or error; work is in work units. All
/// but ns are of the first sweep. deeper, the last column, is there with --deeper-than: yes or no, both proven, or undecided. Lengths are in the unit of the meshes.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    /// Take closed components as solids: a mesh inside of the other penetrates it, and a push has to lead out of it.
    #[arg(long)]
    solid: bool,
    /// Stop as soon as high <= (1 + E) low.
    #[arg(long, value_name = "E", value_parser = parse_size, allow_negative_numbers = true)]
    rel: Option<f64>,
    /// Stop as soon as high - low <= E, too.
    #[arg(long, value_name = "E", value_parser = parse_size, allow_negative_numbers = true)]
    abs: Option<f64>,
    /// Ask only whether the depth is more than D, and stop as soon as that is known. The column deeper has the answer.
    #[arg(long, value_name = "D", value_parser = parse_size, allow_negative_numbers = true, conflicts_with_all = ["rel", "abs"])]
    deeper_than: Option<f64>,
    #[command(flatten)]
    running: Running,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    // Closed components tell inside from outside, which helps surfaces too.
    let options = BuildOptions::default().solid(Solid::Flip);
    let LoadedInput { a, b, build, poses } = args.input.load(&options)?;
    if args.solid {
        args.input.complain_of_open([&a, &b]);
    }
    let completion = args.input.complain_of_bad_poses(&poses);
    let mut workspace = PenetrationWorkspace::with_engine(args.running.workspace());
    let rows = args.running.answers(
        &poses,
        || (),
        |&pose, (), budget| {
            let start = Instant::now();
            let query = PenetrationQuery::new(&a, &b, pose).solid(args.solid);
            let query = query.absolute_tolerance(args.abs.unwrap_or(0.0));
            let query = query.deeper_than(args.deeper_than.unwrap_or(f64::INFINITY));
            let query = match args.rel {
                Some(share) => query.relative_tolerance(share),
                None => query,
            };
            Some((query.run(&mut workspace, budget), [start.elapsed()]))
        },
    );
    print_source(out, build)?;
    let asks_limit = args.deeper_than.is_some();
    let [header, none] = if asks_limit {
        [",deeper", ","]
    } else {
        [""; 2]
    };
    let (header, none) = (
        format!("pose,low,high,nx,ny,nz,ns,stop,work{header}"),
        format!(",,,,,0,error,0{none}"),
    );
    print_rows(
        out,
        &header,
        &rows,
        &none,
        |said: &Answer<Penetration>, ns| {
            let Penetration {
                low,
                high,
                direction,
                deeper,
                ..
            } = said.value;
            let n = direction.map_or(",,".to_owned(), vector);
            let (stop, work) = (said.stop, said.stats.work);
            let deeper = if asks_limit {
                format!(",{}", yes_or_no(deeper))
            } else {
                String::new()
            };
            format!("{low},{high},{n},{ns},{stop},{work}{deeper}")
        },
    )?;
    Ok(completion)
}
