//! `punctual fit`: the constants of the model from queries of known truth, and how well they do.

use std::io::Write;
use std::path::PathBuf;

use clap::ArgGroup;
use punctual_lab::constants::{self, Asked, Case, Data};
use punctual_lab::report::{self, Failure};

use crate::Completion;

/// Fit the constants of the cost and confidence model, or report how well the built-in ones do.
///
/// Each query is run to its end, and stopped at 2, 5, 10, 20 and 50 % of the work of the complete query; what the model sees
/// at each moment is set against what came of it. With --out, writes the constants as Rust source, to be put in the place of
/// src/model/constants.rs. With --report, writes tables (CSV) and pictures (SVG) of the errors of the constants that
/// this program was built with. `tools/fit_model` does both for the cases that the built-in constants are of.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("what").required(true))]
pub struct Args {
    /// Case folders: a.*, b.* (mesh files) and poses.txt, or sweeps.txt with motions.
    cases: Vec<PathBuf>,
    /// A case folder whose poses are consecutive frames of a motion. May be repeated.
    #[arg(long, value_name = "CASE_DIR")]
    motion: Vec<PathBuf>,
    /// A case folder asked only about intersections. May be repeated.
    #[arg(long, value_name = "CASE_DIR")]
    intersections: Vec<PathBuf>,
    /// A case folder asked all but intersections. May be repeated.
    #[arg(long, value_name = "CASE_DIR")]
    others: Vec<PathBuf>,
    /// Two mesh files, approached from twelve sides and put before and behind their first touch, and asked only
    /// about intersections. May be repeated.
    #[arg(long, value_name = "A,B")]
    approach: Vec<String>,
    /// Built-in shapes, approached like that.
    #[arg(long)]
    shapes: bool,
    /// Write the constants to this file.
    #[arg(long, value_name = "FILE", group = "what")]
    out: Option<PathBuf>,
    /// Write the report to this folder; made if it does not exist.
    #[arg(long, value_name = "DIR", group = "what")]
    report: Option<PathBuf>,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let mut data = Data::default();
    let folders = [
        (&args.cases, Asked::Everything),
        (&args.intersections, Asked::Intersections),
        (&args.others, Asked::Others),
    ];
    for (folders, asked) in folders {
        for folder in folders {
            data.add(&Case::folder(folder)?, asked);
        }
    }
    for folder in &args.motion {
        data.add(&Case::motion(folder)?, Asked::Everything);
    }
    for files in &args.approach {
        data.add(&Case::approached(files)?, Asked::Intersections);
    }
    if args.shapes {
        for case in Case::shapes()? {
            data.add(&case, Asked::Everything);
        }
    }
    let [cases, poses, moments] = data.counts();
    if moments == 0 {
        return Err(
            "no queries: name a case folder with poses, --motion, --approach or --shapes".into(),
        );
    }
    writeln!(out, "{cases} cases, {poses} poses, {moments} moments")?;
    if let Some(file) = &args.out {
        report::write(file, constants::fit(&data))?;
    }
    if let Some(folder) = &args.report {
        report::create_folder(folder)?;
        constants::report(&data, folder, out)?;
    }
    Ok(Completion::Full)
}
