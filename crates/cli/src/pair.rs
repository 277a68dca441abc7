//! `punctual pair`: two meshes, a list of poses, an answer for each within a budget.

mod calibration;
mod sweep;

use std::io::Write;
use std::path::PathBuf;

use clap::ValueEnum;
use punctual::intersection::{Intersection, Order};
use punctual::prediction::CostModel;
use punctual::{Mode, Pose, Query, Tree};
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{Input, LoadedInput, Running, build_options, print_source};
use crate::view::{self, ViewArgs};
use calibration::CalibrationFile;
use sweep::{PairsFile, Row, Sweeper};

/// Intersect two meshes at each pose of a list.
///
/// Prints CSV, a line for each pose: hit is 1 only if an intersection is proven; pairs is the number of intersecting
/// triangle pairs found (-1 with --mode any); ns is the least time of all sweeps, pose update included; verdict is
/// intersecting, contained (with --solid), separated (proven), undecided (the budget ended first) or error; upper_bound is a number of
/// intersecting pairs that is proven not to be exceeded. Then what the model says: before the query, the median and the
/// 90 % quantile of its BV tests, and the median time in ns; at its end, the BV tests still to be made, the probability of
/// an intersection, and with --mode all the expected share of the pairs that was found. All but ns are of the first sweep.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    /// Stop at the first intersecting triangle pair, or find all.
    #[arg(long, value_enum, default_value = "any")]
    mode: ModeName,
    #[command(flatten)]
    running: Running,
    /// Which node pair of the front is visited next.
    #[arg(long, value_enum, default_value = "penetration")]
    order: OrderName,
    /// Take both meshes for solids: contained says that a part of one is inside the other, which is closed, although the
    /// surfaces do not meet. Parts that are inside out are taken as they are.
    #[arg(long)]
    solid: bool,
    /// Take the poses as consecutive frames: carry what one tells the next.
    #[arg(long)]
    memory: bool,
    /// Share of poses with an intersection that is to be expected, 0 to 1; it shifts the probability. By default that of
    /// the poses that the model was fitted to.
    #[arg(long, value_name = "P", value_parser = parse_share, allow_negative_numbers = true)]
    prior: Option<f64>,
    /// Correct the probability by what earlier queries of these parts taught, and learn from this run: JSON, made if it does
    /// not exist, written at the end.
    ///
    /// Each query of the first sweep that its budget left undecided is finished aside, which counts neither as work nor as
    /// time, and the probability that was told is held against what came.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Write the intersecting pairs of the first sweep, lines `pose,a,b` with triangles counted from 0, sorted.
    ///
    /// Only with --mode all.
    #[arg(long, value_name = "FILE")]
    pairs_out: Option<PathBuf>,
    #[command(flatten)]
    view: ViewArgs,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum ModeName {
    /// One intersecting pair settles it
    Any,
    /// Every intersecting pair is wanted
    All,
}

#[derive(Clone, Copy, ValueEnum)]
enum OrderName {
    /// Deepest relative penetration of the boxes first
    Penetration,
    /// Smallest product of the diminishing factors first
    LowAlpha,
    /// Newest first
    DepthFirst,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    if args.pairs_out.is_some() && args.mode == ModeName::Any {
        return Err("--pairs-out needs --mode all".into());
    }
    let mut calibration = args
        .calibration
        .as_deref()
        .map(CalibrationFile::read)
        .transpose()?;
    let LoadedInput { a, b, build, poses } = args.input.load(&build_options(args.solid))?;
    let mut pairs_out = args
        .pairs_out
        .as_deref()
        .map(PairsFile::create)
        .transpose()?;

    args.input.complain_of_open([&a, &b]);
    let completion = args.input.complain_of_bad_poses(&poses);
    let mut sweeper = Sweeper::new(args, &a, &b);
    let mut rows = sweeper.first_sweep(&poses, pairs_out.as_mut(), calibration.as_mut())?;
    for _ in 1..args.running.reps {
        sweeper.sweep_again(&poses, &mut rows)?;
    }
    if let Some(file) = pairs_out {
        file.finish()?;
    }
    print_source(out, build)?;
    print_rows(out, &rows, args.mode)?;
    if let Some(file) = calibration {
        file.write()?;
    }
    args.view.write(
        args.input.meshes.up(),
        view::answered(&poses, &rows),
        |(pose, row)| {
            punctual_view::pair(
                &args.input.bodies([&a, &b]),
                args.query(&a, &b, *pose),
                pose,
                args.mode(),
                &row.outcome,
            )
        },
    )?;
    Ok(completion)
}

impl Args {
    fn mode(&self) -> Mode {
        match self.mode {
            ModeName::Any => Mode::Any,
            ModeName::All => Mode::All,
        }
    }

    fn query<'t>(&self, a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t, Intersection> {
        let query = Query::intersection(a, b, pose)
            .mode(self.mode())
            .order(self.order());
        self.prior.map_or(query, |share| query.prior(share))
    }

    fn order(&self) -> Order {
        match self.order {
            OrderName::Penetration => Order::Penetration,
            OrderName::LowAlpha => Order::LowAlpha,
            OrderName::DepthFirst => Order::DepthFirst,
        }
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "must be a number".to_owned())?;
    if (0.0..=1.0).contains(&share) {
        Ok(share)
    } else {
        Err("must be from 0 to 1".into())
    }
}

fn print_rows(out: &mut impl Write, rows: &[Option<Row>], mode: ModeName) -> std::io::Result<()> {
    const MODEL: &str =
        "predicted_bv_tests,predicted_p90,predicted_ns,remaining_bv_tests,probability,recall";
    writeln!(
        out,
        "pose,hit,pairs,bv_tests,ns,verdict,stop,primitive_tests,work,upper_bound,{MODEL}"
    )?;
    for (i, row) in rows.iter().enumerate() {
        let Some(row) = row else {
            writeln!(out, "{i},invalid,-1,0,0,error,,0,0,,,,,,,")?;
            continue;
        };
        let (outcome, stats, estimate) = (&row.outcome, &row.outcome.stats, &row.estimate);
        let (pairs, recall) = match mode {
            ModeName::Any => (-1, String::new()),
            ModeName::All => (
                i64::try_from(stats.found).unwrap_or(i64::MAX),
                format!("{:.4}", estimate.recall),
            ),
        };
        let fields = [
            i.to_string(),
            u8::from(outcome.value.meets()).to_string(),
            pairs.to_string(),
            stats.bv_tests.to_string(),
            row.least.as_nanos().to_string(),
            outcome.value.name().to_owned(),
            outcome.stop.to_string(),
            stats.primitive_tests.to_string(),
            stats.work.to_string(),
            row.upper_bound.to_string(),
            format!("{:.0}", row.predicted.bv_tests.p50),
            format!("{:.0}", row.predicted.bv_tests.p90),
            format!("{:.0}", row.predicted.time(&CostModel::default()).p50),
            format!("{:.0}", estimate.remaining.bv_tests.p50),
            format!("{:.4}", estimate.probability),
            recall,
        ];
        writeln!(out, "{}", fields.join(","))?;
    }
    Ok(())
}
