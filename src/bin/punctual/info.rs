//! `punctual info`: what the tree of a mesh looks like.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use punctual::{Tree, TreeStats};

use crate::Completion;
use crate::load::load;

/// Print statistics of the trees of meshes.
///
/// For each mesh a line with triangles, nodes, depth, bytes a triangle and build time, then for each level the number
/// of nodes and their mean diminishing factor alpha: how much boxes shrink from one binary level to the next, along x,
/// y and z of the node, and the product of the three.
#[derive(clap::Args)]
pub struct Args {
    /// Mesh files: .obj, .stl, .ply or .glb.
    #[arg(required = true)]
    meshes: Vec<PathBuf>,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Box<dyn std::error::Error>> {
    for (i, file) in args.meshes.iter().enumerate() {
        let mesh = load(file)?;
        let precision = if mesh.is_f32() { "f32" } else { "f64" };
        let start = Instant::now();
        let tree = Tree::new(mesh);
        let build = start.elapsed();
        if i > 0 {
            writeln!(out)?;
        }
        print_tree(out, file, &tree.stats(), precision, build)?;
    }
    Ok(Completion::Full)
}

fn print_tree(
    out: &mut impl Write,
    file: &Path,
    stats: &TreeStats,
    precision: &str,
    build: Duration,
) -> io::Result<()> {
    let per_triangle = |bytes: usize| bytes as f64 / stats.triangles.max(1) as f64;
    writeln!(out, "{}", file.display())?;
    writeln!(out, "  triangles     {:>12}", stats.triangles)?;
    writeln!(out, "  coordinates   {precision:>12}")?;
    writeln!(out, "  nodes         {:>12}", stats.nodes)?;
    writeln!(out, "  clusters      {:>12}", stats.clusters)?;
    writeln!(out, "  depth         {:>12}", stats.depth)?;
    writeln!(out, "  build ms      {:>12.3}", build.as_secs_f64() * 1e3)?;
    writeln!(out, "  bytes/triangle{:>12.1}", per_triangle(stats.bytes()))?;
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
            write!(out, "   {:>6.3}  {:>6.3}  {:>6.3}   {product:>6.3}", alpha.x, alpha.y, alpha.z)?;
        }
        writeln!(out)?;
    }
    Ok(())
}
