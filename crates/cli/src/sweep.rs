//! `punctual sweep`: what a deadline costs in accuracy, for every order.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use punctual_lab::report::Failure;
use punctual_lab::sweep::{self, Plan, Settings, others};

use crate::input::progress_style;
use crate::{Completion, complain};

/// Measure speed against error: what is known when a budget ends, for every order.
///
/// Takes two mesh files, `punctual sweep A.obj B.obj --out DIR`, or folders of cases with poses of their own. Of two meshes it
/// makes 100 poses itself, the same ones each time: 84 near contact, four of seven past the first touch and three before it, as
/// `punctual poses A B --contact 84` makes them, and 16 at random. They are written to DIR, as a list for the other commands.
///
/// Every query is compared with the exact truth, which is computed once and kept in DIR/truth. Writes to DIR: index.html,
/// which needs no other file; its plots as .svg, those of single cases in DIR/cases; overview.svg, the main figures
/// over time; sweep.csv and distance.csv, tidy tables; summary.json, for `punctual compare`. Figures of work budgets are the
/// same bits in every run; figures of time are of this machine. Ctrl-C leaves a report of the cases that are finished. Exit
/// status 1 if an answer or a certificate was wrong, or a budget of work overrun by more than a step.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).multiple(true))]
pub struct Args {
    /// Mesh files, two for a case, A before B. Or folders of cases: a mesh a.*, a mesh b.*, and poses.txt with the poses of
    /// B; with truth.csv, its numbers of pairs are checked, with truth_distance.csv the distances.
    #[arg(value_name = "MESH | CASE_DIR", group = "what")]
    cases: Vec<PathBuf>,
    /// Generated shapes that approach each other.
    #[arg(long, group = "what")]
    builtin: bool,
    /// Folder for the report; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Times of other libraries' distance queries, to be shown beside ours: lines `case,peer,pose,distance,ns`. Those of
    /// other cases are ignored.
    #[arg(long, value_name = "FILE")]
    peer_times: Option<PathBuf>,
    /// Measure distance queries alone, which takes a fraction of the time.
    #[arg(long)]
    distance_only: bool,
    /// A smaller report with more noise, in seconds.
    #[arg(long)]
    quick: bool,
    /// Orders to compare with the default (penetration) and with depth-first, which are always measured.
    #[arg(long, value_name = "ORDER,...", value_delimiter = ',', default_values = others(), value_parser = others())]
    orders: Vec<String>,
    /// Budgets of work, in percent of the work of a full search at the same pose.
    #[arg(long, value_name = "P,...", value_delimiter = ',', default_values_t = [1, 2, 5, 10, 20, 30, 50, 70, 100],
        value_parser = clap::value_parser!(u32).range(1..=100))]
    work_percent: Vec<u32>,
    /// Budgets of time in microseconds.
    #[arg(long, value_name = "T,...", value_delimiter = ',',
        default_values_t = [1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200, 500, 1000],
        value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    time_us: Vec<u64>,
}

/// Whether Ctrl-C was pressed.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed))?;
    let plan = Plan {
        orders: args.orders.clone(),
        work_percent: args.work_percent.clone(),
        time_us: args.time_us.clone(),
    };
    let settings = Settings {
        cases: &args.cases,
        builtin: args.builtin,
        folder: &args.out,
        peer_times: args.peer_times.as_deref(),
        distance_only: args.distance_only,
        quick: args.quick,
        plan,
        style: progress_style()?,
        interrupted: &INTERRUPTED,
        complain: &|what| complain(what),
    };
    Ok(match sweep::run(&settings, out)? {
        true => Completion::Full,
        false => Completion::Partial,
    })
}
