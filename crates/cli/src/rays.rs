//! `punctual rays`: a mesh, a list of rays, what each hits, within a budget.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

use punctual::Query;
use punctual::rays::{RayBounds, RayHit, RayMode};
use punctual_lab::files;
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{
    MeshArgs, Row, Running, build_options, complain_of_bad_lines, print_source, yes_or_no,
};

/// What the rays of a list hit.
///
/// Prints CSV, a line for each ray; with --mode all one for each of its hits, by t: the triangle, counted from 0; t, where
/// the point is origin + t direction; and the side of the triangle that the ray comes from, front where its corners appear
/// counterclockwise, or edge if the ray lies in its plane. These are empty where no hit was found. Every hit that is not
/// told is at free_until or after it, which is proven, also where a budget ended the query. ns is the least time of all
/// sweeps over the list. With --solid a last column says whether the ray starts inside: yes, no or undecided. stop tells why the query ended, or error; work is in work units. All but ns are of the first sweep.
#[derive(clap::Args)]
pub struct Args {
    /// The mesh: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or one of these with .gz; - is standard input, whose format its
    /// content
    /// tells.
    a: PathBuf,
    /// Rays in its frame, one a line: 6 numbers, the origin and the direction; `#` begins a comment.
    ///
    /// A line that holds no ray gives a row that says `error` and a message on standard error; the others are answered, and
    /// the exit status is 1.
    rays: PathBuf,
    #[command(flatten)]
    meshes: MeshArgs,
    /// Take the last three numbers of a line as the end of a segment, which goes from t = 0 to 1.
    #[arg(long)]
    segments: bool,
    /// Which hits: nearest, any or all.
    #[arg(long, value_name = "MODE", default_value_t = RayMode::Nearest)]
    mode: RayMode,
    /// Take closed components as solids and say whether a ray starts inside one, or on its surface: a last column `inside`.
    #[arg(long)]
    solid: bool,
    #[command(flatten)]
    running: Running,
}

/// An answer, with the hits that were asked for.
type Answer = (punctual::Answer<RayBounds>, Vec<RayHit>);

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let (tree, build) = args.meshes.tree(&args.a, &build_options(args.solid))?;
    let rays = files::rays(&args.rays, args.segments)?;
    let completion = complain_of_bad_lines(&args.rays, "ray", &rays);
    let mut workspace = args.running.workspace();
    // So that room for hits is no part of the first time.
    workspace.reserve_ray_hits(tree.mesh().len());
    let rows = args.running.answers(
        &rays,
        || (),
        |&ray, (), budget| {
            let start = Instant::now();
            let query = Query::ray(&tree, ray).mode(args.mode).solid(args.solid);
            let cast = query.run(&mut workspace, budget);
            let took = start.elapsed();
            let mut hits: Vec<RayHit> = cast.value.hit.into_iter().collect();
            if args.mode == RayMode::All {
                hits = workspace.drain_ray_hits().collect();
                hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
            }
            Some(((cast, hits), [took]))
        },
    );
    print_source(out, build)?;
    print(out, &rows, args.solid)?;
    Ok(completion)
}

fn print(out: &mut impl Write, rows: &[Row<Answer>], solid: bool) -> io::Result<()> {
    let name = if solid { ",inside" } else { "" };
    writeln!(out, "ray,triangle,t,side,free_until,ns,stop,work{name}")?;
    for (i, row) in rows.iter().enumerate() {
        let Some(((cast, hits), [least])) = row else {
            let nothing = if solid { "," } else { "" };
            writeln!(out, "{i},,,,,0,error,0{nothing}")?;
            continue;
        };
        let inside = if solid {
            format!(",{}", yes_or_no(cast.value.starts_inside))
        } else {
            String::new()
        };
        let rest = format!(
            "{},{},{},{}{inside}",
            cast.value.free_until,
            least.as_nanos(),
            cast.stop,
            cast.stats.work
        );
        for RayHit {
            triangle, t, side, ..
        } in hits
        {
            writeln!(out, "{i},{triangle},{t},{side},{rest}")?;
        }
        if hits.is_empty() {
            writeln!(out, "{i},,,,{rest}")?;
        }
    }
    Ok(())
}
