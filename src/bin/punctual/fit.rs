//! `punctual fit`: the constants of the model from queries of known truth, and how well they do.

mod cases;
mod constants;
mod evaluate;
mod plots;
mod sample;

use std::io::Write;
use std::path::PathBuf;

use clap::ArgGroup;

use crate::Completion;
use crate::report::{self, Failure};
use cases::Case;
use sample::Sample;

/// Fit the constants of the cost and confidence model, or report how well the built-in ones do.
///
/// Each query is run to its end, and stopped at 2, 5, 10, 20 and 50 % of the work of the complete query; what the model sees
/// at each moment is set against what came of it. With --out, writes the constants as Rust source, to be put in the place of
/// src/model/constants.rs. With --report, writes tables (CSV) and pictures (SVG, PNG) of the errors of the constants that
/// this program was built with.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("what").required(true))]
pub struct Args {
    /// Case folders: a.*, b.* (.obj, .stl, .ply or .glb) and poses.txt.
    cases: Vec<PathBuf>,
    /// A case folder whose poses are consecutive frames of a motion. May be repeated.
    #[arg(long, value_name = "CASE_DIR")]
    motion: Vec<PathBuf>,
    /// Two mesh files, approached from twelve sides and put before and behind their first touch. May be repeated.
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

/// What is fitted to, or reported on.
struct Data {
    names: Vec<String>,
    poses: usize,
    samples: Vec<Sample>,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let mut data = Data { names: Vec::new(), poses: 0, samples: Vec::new() };
    for folder in &args.cases {
        data.add(&Case::folder(folder, false)?);
    }
    for folder in &args.motion {
        data.add(&Case::folder(folder, true)?);
    }
    for files in &args.approach {
        data.add(&Case::approached(files)?);
    }
    if args.shapes {
        Case::shapes().iter().for_each(|case| data.add(case));
    }
    if data.samples.is_empty() {
        return Err("no queries: name a case folder with poses, --motion, --approach or --shapes".into());
    }
    writeln!(out, "{} cases, {} poses, {} moments", data.names.len(), data.poses, data.samples.len())?;
    if let Some(file) = &args.out {
        report::write(file, constants::fit(&data))?;
    }
    if let Some(folder) = &args.report {
        report::create_folder(folder)?;
        evaluate::report(&data, folder, out)?;
    }
    Ok(Completion::Full)
}

impl Data {
    fn add(&mut self, case: &Case) {
        let number = self.names.len();
        self.names.push(case.name.clone());
        self.poses += case.poses.len();
        self.samples.extend(sample::samples(number, case));
    }
}
