//! `punctual inside`: a mesh, a list of points, which are inside and how far from the surface, within a budget.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use punctual::points::PointBounds;
use punctual::tree::Solid;
use punctual::{Answer, BuildOptions, Query};
use punctual_lab::files;
use punctual_lab::report::Failure;

use crate::input::{MeshArgs, Running, complain_of_bad_lines, print_rows, print_source, yes_or_no};
use crate::{Completion, complain};

/// Whether points are inside a solid, and how far from its surface.
///
/// Prints CSV, a line for each point: how often the surface winds around it, a whole number for a closed mesh, exactly; inside is
/// yes, no or undecided, and yes for points on the surface, whose winding is that just beside them; the signed distance,
/// negative inside, is within low and high, also where a budget ended the query. ns is the least time of all sweeps over the
/// list; stop tells why the query ended, or error. winding is nan, and inside undecided, where the budget ended first. All but ns
/// are of the first sweep.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or one of these with .gz; - is standard input, whose format its
    /// content
    /// tells.
    a: PathBuf,
    /// Points in its frame, one a line: 3 numbers; `#` begins a comment.
    ///
    /// A line that holds no point gives a row that says `error` and a message on standard error; the others are answered,
    /// and the exit status is 1.
    points: PathBuf,
    #[command(flatten)]
    meshes: MeshArgs,
    /// Reverse the triangles of parts that are inside out. Without it, a message on standard error names the first.
    #[arg(long)]
    flip: bool,
    #[command(flatten)]
    running: Running,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let solid = if args.flip { Solid::Flip } else { Solid::Keep };
    let options = BuildOptions::default().solid(solid);
    let (tree, build) = args.meshes.tree(&args.a, &options)?;
    let points = files::points(&args.points)?;
    let Some(solid) = tree.solid() else {
        return Err(format!("{}: points have no inside", args.a.display()).into());
    };
    if let Some(part) = solid.components().iter().find(|part| part.inside_out) {
        complain(&format!(
            "{}: the part of triangle {} is inside out; --flip reverses such parts",
            args.a.display(),
            part.first_triangle
        ));
    }
    let completion = complain_of_bad_lines(&args.points, "point", &points);
    let mut workspace = args.running.workspace();
    let rows = args.running.answers(
        &points,
        || (),
        |&point, (), budget| {
            // The points of the list were checked.
            let query = Query::signed_distance(&tree, point).ok()?;
            let start = Instant::now();
            Some((query.run(&mut workspace, budget), [start.elapsed()]))
        },
    );
    print_source(out, build)?;
    let header = "point,winding,inside,low,high,ns,stop";
    print_rows(
        out,
        header,
        &rows,
        ",,,,0,error",
        |answer: &Answer<_>, ns| {
            let PointBounds {
                winding,
                inside,
                distance,
                ..
            } = answer.value;
            let bounds = distance.map(|distance| [distance.low, distance.high]);
            let [low, high] = bounds.unwrap_or([f64::INFINITY; 2]);
            let winding = winding.map_or("nan".to_owned(), |winding| winding.to_string());
            let (inside, stop) = (yes_or_no(inside), answer.stop);
            format!("{winding},{inside},{low},{high},{ns},{stop}")
        },
    )?;
    Ok(completion)
}
