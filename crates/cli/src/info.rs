//! `punctual info`: what the tree of a mesh looks like.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use punctual::{BuildOptions, Mesh, MeshError, Tree};
use punctual_io::Loaded;

use crate::Completion;
use crate::input::MeshArgs;

/// Print statistics of the trees of meshes.
///
/// For each mesh a line with triangles, nodes, depth, bytes a triangle, build and refit time, and how many pairs of its
/// triangles intersect beyond the corners that they share, then for each level the number
/// of nodes and their mean diminishing factor alpha: how much boxes shrink from one binary level to the next, along x,
/// y and z of the node, and the product of the three. What was passed over in the file is told in lines that begin with
/// `notice`.
#[derive(clap::Args)]
pub struct Args {
    /// Mesh files: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or one of these with .gz; - is standard input, whose format
    /// its
    /// content tells.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    meshes: MeshArgs,
    /// What the build may cost.
    #[arg(long, value_enum, default_value = "normal")]
    effort: EffortName,
    /// Most threads to build in; more than one needs a program built with the feature `parallel`.
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
    /// Build and refit this often; the least times are printed.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
}

#[derive(Clone, Copy, ValueEnum)]
enum EffortName {
    /// One frame for the whole mesh, few bins
    Fast,
    /// A frame for each node
    Normal,
}

impl Args {
    fn options(&self) -> BuildOptions {
        let preset = match self.effort {
            EffortName::Fast => BuildOptions::fast_build(),
            EffortName::Normal => BuildOptions::default(),
        };
        preset.threads(self.threads)
    }
}

/// The tree, and the least times to build it and to refit it to the vertices that it has.
fn build(mesh: Mesh, args: &Args) -> Result<(Tree, [Duration; 2]), MeshError> {
    let vertices: Vec<_> = (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect();
    let mut least = [Duration::MAX; 2];
    let mut tree = None;
    for _ in 0..args.reps {
        let copy = mesh.clone();
        let start = Instant::now();
        let built = tree.insert(Tree::with_options(copy, &args.options()));
        least[0] = least[0].min(start.elapsed());
        let start = Instant::now();
        built.refit_f64(&vertices)?;
        least[1] = least[1].min(start.elapsed());
    }
    let tree = tree.unwrap_or_else(|| Tree::new(mesh));
    Ok((tree, least))
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Box<dyn std::error::Error>> {
    for (i, file) in args.files.iter().enumerate() {
        let Loaded { mesh, notices, .. } = args.meshes.load_quietly(file)?;
        let precision = if mesh.is_f32() { "f32" } else { "f64" };
        let (tree, times) = build(mesh, args)?;
        if i > 0 {
            writeln!(out)?;
        }
        writeln!(out, "{}", file.display())?;
        notices
            .iter()
            .try_for_each(|notice| writeln!(out, "  notice        {notice}"))?;
        print_tree(out, &tree, precision, times)?;
    }
    Ok(Completion::Full)
}

fn print_tree(
    out: &mut impl Write,
    tree: &Tree,
    precision: &str,
    [build, refit]: [Duration; 2],
) -> io::Result<()> {
    let stats = tree.stats();
    let per_triangle = |bytes: usize| bytes as f64 / stats.triangles.max(1) as f64;
    let one = if tree.is_cloud() { "point" } else { "triangle" };
    writeln!(out, "  {:<14}{:>12}", format!("{one}s"), stats.triangles)?;
    writeln!(out, "  coordinates   {precision:>12}")?;
    writeln!(out, "  nodes         {:>12}", stats.nodes)?;
    writeln!(out, "  leaves        {:>12}", stats.leaves)?;
    writeln!(out, "  depth         {:>12}", stats.depth)?;
    writeln!(out, "  build ms      {:>12.3}", build.as_secs_f64() * 1e3)?;
    writeln!(out, "  refit ms      {:>12.3}", refit.as_secs_f64() * 1e3)?;
    writeln!(
        out,
        "  self-pairs    {:>12}",
        tree.self_intersections().len()
    )?;
    let bytes = per_triangle(stats.bytes());
    writeln!(out, "  {:<14}{bytes:>12.1}", format!("bytes/{one}"))?;
    let parts = [
        ("nodes", stats.bytes_nodes),
        ("triangles", stats.bytes_triangles),
        ("mesh", stats.bytes_mesh),
        ("profiles", stats.bytes_profiles),
    ];
    for (name, bytes) in parts {
        writeln!(out, "    {name:<12}{:>12.1}", per_triangle(bytes))?;
    }
    writeln!(out, "  level    nodes  alpha x       y       z  product")?;
    for (level, nodes) in stats.nodes_per_level.iter().enumerate() {
        write!(out, "  {level:>5} {nodes:>8}")?;
        if let Some(alpha) = stats.alpha_per_level.get(level) {
            let product = alpha.element_product();
            write!(
                out,
                "   {:>6.3}  {:>6.3}  {:>6.3}   {product:>6.3}",
                alpha.x, alpha.y, alpha.z
            )?;
        }
        writeln!(out)?;
    }
    Ok(())
}
