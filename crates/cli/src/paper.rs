//! `punctual paper`: the experiments of Weller, Klein and Zachmann (2006) again, and the step beyond them.

use std::io::Write;
use std::path::PathBuf;

use punctual_lab::experiments::{self, Settings};
use punctual_lab::report::Failure;

use crate::Completion;

/// Reproduce the experiments of the paper that the cost model comes from.
///
/// Writes to a folder: index.html, which sets each claim, our measurement and the verdict side by side and needs no other
/// file; the plots as .svg; and their numbers as .csv. The same options give the same files. Prints a line for
/// each claim.
#[derive(clap::Args)]
pub struct Args {
    /// Folder for the report; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A ladder for Figure 4: one shape at rising resolution, files separated by commas. May be repeated; without it,
    /// built-in shapes are used.
    #[arg(long, value_name = "FILE,FILE...")]
    meshes: Vec<String>,
    /// A smaller report with more noise, in seconds.
    #[arg(long)]
    quick: bool,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    experiments::run(
        &Settings {
            folder: &args.out,
            ladders: &args.meshes,
            quick: args.quick,
        },
        out,
    )?;
    Ok(Completion::Full)
}
