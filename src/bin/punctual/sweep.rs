//! `punctual sweep`: what a deadline costs in accuracy, for every order.

mod built_in;
mod case;
mod contender;
mod measure;
mod oracle;
mod truth;

use std::io::Write;
use std::path::PathBuf;

use punctual::Mode;

use crate::Completion;
use crate::report::{self, Failure};
use case::Case;
use measure::{Answer, Limit};

/// Measure speed against error.
#[derive(clap::Args)]
pub struct Args {
    /// Folders with a mesh a.*, a mesh b.*, and poses.txt.
    #[arg(required_unless_present = "builtin")]
    cases: Vec<PathBuf>,
    /// Generated shapes, no files.
    #[arg(long)]
    builtin: bool,
    /// Folder for the report; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A smaller report with more noise, in seconds.
    #[arg(long)]
    quick: bool,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    report::create_folder(&args.out)?;
    report::create_folder(&args.out.join("truth"))?;
    let mut sums = std::collections::BTreeMap::<String, Vec<f64>>::new();
    let cases: Box<dyn Iterator<Item = Result<Case, Failure>>> = if args.builtin {
        Box::new(built_in::cases(args.quick).into_iter().map(Ok))
    } else {
        Box::new(args.cases.iter().map(|folder| Case::load(folder)))
    };
    for case in cases {
        let case = case?;
        let truth = truth::of_case(&case, &args.out.join("truth").join(format!("{}.csv", case.name)))?;
        let measured = measure::case(&case, &truth, || true).unwrap();
        for w in &measured.wrong { writeln!(out, "{w}")?; }
        let hits: Vec<usize> = (0..truth.len()).filter(|&p| !truth[p].pairs.is_empty()).collect();
        let mut line = case.name.clone();
        for c in contender::CONTENDERS.iter().map(|c| c.name).chain([contender::ORACLE]) {
            let mean = |f: &dyn Fn(&measure::Row) -> Option<f64>| {
                let v: Vec<f64> = measured.rows.iter().filter(|r| r.order == c && !truth[r.pose].pairs.is_empty()).filter_map(f).collect();
                v.iter().sum::<f64>() / v.len() as f64
            };
            let any = mean(&|r| (r.mode == Mode::Any && r.budget == Limit::Work(5)).then(|| f64::from(u8::from(r.verdict == Answer::Detected))));
            let recall = mean(&|r| (r.mode == Mode::All && r.budget == Limit::Work(20)).then_some(r.recall));
            let cover = mean(&|r| (r.mode == Mode::All && r.budget == Limit::Work(20)).then_some(r.coverage));
            let first = |order: &str, bv: bool| -> f64 {
                let v: Vec<f64> = measured.finished.iter().filter(|f| f.order == order && f.mode == Mode::Any && !truth[f.pose].pairs.is_empty()).map(|f| (if bv { f.bv_tests } else { f.work } as f64).ln()).collect();
                v.iter().sum::<f64>() / v.len() as f64
            };
            let fw = (first(contender::DEPTH_FIRST, false) - first(c, false)).exp();
            let fb = (first(contender::DEPTH_FIRST, true) - first(c, true)).exp();
            for (k, x) in [("any5", any), ("recall20", recall), ("cover20", cover), ("firstwork", fw), ("firstbv", fb)] {
                sums.entry(format!("{c:16} {k}")).or_default().push(x);
            }
            if c == "penetration" { line += &format!(" hits {} any5 {any:.2} recall20 {recall:.2} cover20 {cover:.2} first {fw:.1} {fb:.1} overrun {}", hits.len(), measured.overrun); }
        }
        writeln!(out, "{line}")?;
    }
    for (k, v) in sums {
        let m = v.iter().sum::<f64>() / v.len() as f64;
        let g = (v.iter().map(|x| x.ln()).sum::<f64>() / v.len() as f64).exp();
        writeln!(out, "{k} mean {m:.3} geomean {g:.2}")?;
    }
    Ok(Completion::Full)
}
