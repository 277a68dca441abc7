//! The program `punctual`: collision queries of mesh files from the command line.
//!
//! Exit status: 0 if every line of the input was answered, 1 if some were bad (the others are answered), 2 if the
//! program could not begin: a bad option, mesh or list. Results go to standard output, reasons to standard error.

#![deny(unsafe_code)]

mod compare;
mod contacts;
mod depth;
mod distance;
mod fit;
mod info;
mod input;
mod inside;
mod motion;
mod pair;
mod paper;
mod pile;
mod poses;
mod rays;
mod robot;
mod scene;
mod sweep;
mod triangles;
mod view;

use std::fmt::Display;
use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Mesh collision detection that answers by the deadline, and says how sure it is.
#[derive(Parser)]
#[command(name = "punctual", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Pair(pair::Args),
    Distance(distance::Args),
    Motion(motion::Args),
    Contacts(contacts::Args),
    Depth(depth::Args),
    Rays(rays::Args),
    Inside(inside::Args),
    Triangles(triangles::Args),
    Robot(robot::Args),
    Info(info::Args),
    Poses(poses::Args),
    Paper(paper::Args),
    Fit(fit::Args),
    Scene(scene::Args),
    Pile(pile::Args),
    Sweep(sweep::Args),
    Compare(compare::Args),
}

/// Whether every line of the input had an answer.
pub enum Completion {
    Full,
    Partial,
}

/// A message on standard error. Nothing is left to do where even that fails.
pub fn complain(message: &dyn Display) {
    let _ = writeln!(io::stderr(), "punctual: {message}");
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut out = BufWriter::new(io::stdout().lock());
    let result = match &cli.command {
        Command::Pair(args) => pair::run(args, &mut out),
        Command::Distance(args) => distance::run(args, &mut out),
        Command::Motion(args) => motion::run(args, &mut out),
        Command::Contacts(args) => contacts::run(args, &mut out),
        Command::Depth(args) => depth::run(args, &mut out),
        Command::Rays(args) => rays::run(args, &mut out),
        Command::Inside(args) => inside::run(args, &mut out),
        Command::Triangles(args) => triangles::run(args, &mut out),
        Command::Robot(args) => robot::run(args, &mut out),
        Command::Info(args) => info::run(args, &mut out),
        Command::Poses(args) => poses::run(args, &mut out),
        Command::Paper(args) => paper::run(args, &mut out),
        Command::Fit(args) => fit::run(args, &mut out),
        Command::Scene(args) => scene::run(args, &mut out),
        Command::Pile(args) => pile::run(args, &mut out),
        Command::Sweep(args) => sweep::run(args, &mut out),
        Command::Compare(args) => compare::run(args, &mut out),
    };
    let flushed = out.flush();
    match result.and_then(|completion| Ok(flushed.map(|()| completion)?)) {
        Ok(Completion::Full) => ExitCode::SUCCESS,
        Ok(Completion::Partial) => ExitCode::from(1),
        // The reader of a pipe, such as `head`, has seen enough.
        Err(error) if is_closed_pipe(&*error) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&error);
            ExitCode::from(2)
        }
    }
}

fn is_closed_pipe(error: &(dyn std::error::Error + 'static)) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
