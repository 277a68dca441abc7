//! `punctual sweep`: what a deadline costs in accuracy, for every order.

mod built_in;
mod case;
mod confidence;
mod contender;
mod distance;
mod measure;
mod open;
mod oracle;
mod page;
mod peers;
mod plan;
mod punctuality;
mod summary;
mod truth;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::ProgressBar;
use punctual_io::Format;
use punctual_lab::machine;
use punctual_lab::report::{self, Failure};
use serde_json::{Value, json};

use crate::input::progress_style;
use crate::{Completion, complain};
use case::Case;
use contender::{DEFAULT, DEPTH_FIRST, ORACLE};
use distance::summary::{GOALS, reached_over_cases};
use measure::Measured;
use page::{counted, decimals};
use plan::{Plan, plan};
use summary::{Measurement, Stratum};

/// Measure speed against error: what is known when a budget ends, for every order.
///
/// Takes two mesh files, `punctual sweep A.obj B.obj --out DIR`, or folders of cases with poses of their own. Of two meshes it
/// makes 100 poses itself, the same ones each time: 84 near contact, four of seven past the first touch and three before it, as
/// `punctual poses A B --contact 84` makes them, and 16 at random. They are written to DIR, as a list for the other commands.
///
/// Every query is compared with the exact truth, which is computed once and kept in DIR/truth. Writes to DIR: index.html,
/// which needs no other file; its plots as .svg and .png, those of single cases in DIR/cases; overview.svg, the main figures
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
    #[command(flatten)]
    plan: Plan,
}

/// Whether Ctrl-C was pressed.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Steps of the progress bar for a case.
const STEPS: u64 = 1000;

/// Share of the progress bar that is budgets of work.
const WORK_STEPS: u64 = STEPS / 4;

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed))?;
    args.plan.choose();
    let mut peers = args
        .peer_times
        .as_deref()
        .map(peers::read)
        .transpose()?
        .unwrap_or_default();
    report::create_folder(&args.out.join("truth"))?;
    let mut cases: Vec<Box<dyn FnOnce() -> Result<Case, Failure>>> = Vec::new();
    let mut paths = args.cases.iter();
    while let Some(path) = paths.next() {
        if !is_mesh(path) {
            cases.push(Box::new(move || Case::load(path)));
            continue;
        }
        let other = paths.next().filter(|path| is_mesh(path));
        let other = other.ok_or_else(|| {
            let path = path.display();
            format!("{path}: a mesh file must be followed by another one, mesh B")
        })?;
        let files = [path, other].map(PathBuf::as_path);
        cases.push(Box::new(move || {
            Case::between(files, args.quick, &args.out)
        }));
    }
    if args.builtin {
        cases.extend(built_in::cases(args.quick));
    }
    let total = cases.len();
    let bar = ProgressBar::new(STEPS * total as u64).with_style(progress_style()?);
    let mut measured = Vec::new();
    for (i, load) in cases.into_iter().enumerate() {
        let case = load()?;
        bar.set_message(case.name.clone());
        let progress = Progress {
            bar: &bar,
            start: STEPS * i as u64,
        };
        match measure(&case, args, &progress)? {
            Some(mut measurement) => {
                measurement.take_peers(peers.remove(&case.name).unwrap_or_default());
                measured.push(measurement);
            }
            None => break,
        }
    }
    bar.finish_and_clear();
    let wrong = complain_of_wrong(&measured);
    write_report(&measured, total, args, out)?;
    Ok(if wrong || measured.len() < total {
        Completion::Partial
    } else {
        Completion::Full
    })
}

struct Progress<'p> {
    bar: &'p ProgressBar,
    start: u64,
}

impl Progress<'_> {
    /// Notes a share of the case; false after Ctrl-C.
    fn at(&self, steps: u64) -> bool {
        self.bar.set_position(self.start + steps);
        !INTERRUPTED.load(Ordering::Relaxed)
    }
}

/// Whether a path is that of a mesh file, not of a folder.
fn is_mesh(path: &Path) -> bool {
    Format::of(path).is_ok() && !path.is_dir()
}

/// Nothing if interrupted.
fn measure(case: &Case, args: &Args, progress: &Progress) -> Result<Option<Measurement>, Failure> {
    let truth = truth::of_case(
        case,
        &args.out.join("truth").join(format!("{}.csv", case.name)),
    )?;
    let (round_count, most) = effort(args.quick);
    let distance = distance::case(case, &truth, round_count, most);
    let mut measurement = Measurement {
        name: case.name.clone(),
        triangles: [case.a.mesh().len(), case.b.mesh().len()],
        strata: case
            .poses
            .iter()
            .zip(&truth)
            .map(|(pose, truth)| Stratum::of(case, pose, truth))
            .collect(),
        work: Measured::default(),
        rounds: Vec::new(),
        distance,
        peers: BTreeMap::new(),
    };
    if args.distance_only {
        return Ok(progress.at(STEPS).then_some(measurement));
    }
    let poses = truth.len() as u64;
    let mut done = 0;
    let work = measure::case(case, &truth, || {
        done += 1;
        progress.at(WORK_STEPS * done / poses)
    });
    let Some(work) = work else { return Ok(None) };
    measurement.work = work;
    let timed: Vec<usize> = (0..truth.len())
        .step_by(truth.len().div_ceil(most).max(1))
        .collect();
    let passes = round_count * 2 * plan().contenders().count() as u64;
    let mut done = 0;
    for _ in 0..round_count {
        let round = punctuality::round(case, &truth, &timed, || {
            done += 1;
            progress.at(WORK_STEPS + (STEPS - WORK_STEPS) * done / passes)
        });
        let Some(round) = round else { return Ok(None) };
        measurement.rounds.push(round);
    }
    Ok(Some(measurement))
}

/// Rounds of queries with budgets of time, and the poses of a case in them.
fn effort(quick: bool) -> (u64, usize) {
    if quick { (2, 12) } else { (5, 100) }
}

/// Names what a guarantee was broken by; whether anything did.
fn complain_of_wrong(cases: &[Measurement]) -> bool {
    cases
        .iter()
        .flat_map(Measurement::complaints)
        .for_each(|what| complain(what));
    let in_time: usize = cases
        .iter()
        .flat_map(|case| &case.rounds)
        .map(|round| round.wrong)
        .sum();
    if in_time > 0 {
        complain(&format!("{in_time} wrong answers under budgets of time"));
    }
    let too_far = summary::overruns(cases)
        .into_iter()
        .filter(|(overrun, most)| overrun > most);
    let too_far = too_far.map(|(overrun, most)| {
        complain(&format!(
            "a budget of work was overrun by {overrun} units, more than {most}"
        ))
    });
    let is_wrong = in_time > 0 || cases.iter().any(|case| case.complaints().next().is_some());
    too_far.count() > 0 || is_wrong
}

fn write_report(
    cases: &[Measurement],
    total: usize,
    args: &Args,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let machine = machine::describe();
    let table: Vec<_> = cases.iter().flat_map(summary::table).collect();
    report::write_csv(&args.out, "sweep", summary::HEADER, &table)?;
    let table: Vec<_> = cases.iter().flat_map(distance::summary::table).collect();
    report::write_csv(&args.out, "distance", distance::summary::HEADER, &table)?;

    let number = |value: f64| {
        if value.is_finite() {
            json!(value)
        } else {
            Value::Null
        }
    };
    let work = summary::work_figures(cases);
    let time = summary::time_figures(cases).into_iter();
    let time = time.map(|(name, f)| {
        (
            name,
            json!({ "value": number(f.value), "noise": number(f.noise) }),
        )
    });
    let summary = json!({
        "machine": machine,
        "cases": cases.iter().map(|case| format!("{}, {}", case.name, counted(case.strata.len(), "pose"))).collect::<Vec<_>>(),
        "work": work.iter().map(|(name, value)| (name.clone(), number(*value))).collect::<serde_json::Map<_, _>>(),
        "time": time.collect::<serde_json::Map<_, _>>(),
    });
    report::write(
        &args.out.join("summary.json"),
        serde_json::to_string_pretty(&summary)? + "\n",
    )?;

    let page = page::page(cases, &args.out, intro(cases, total, args, &machine))?;
    report::write(&args.out.join("index.html"), page.html())?;
    let figure = |name: String| work.get(&name).copied().unwrap_or(f64::NAN);
    if !args.distance_only {
        tell_of_intersections(cases, &work, out)?;
    }
    if cases.iter().any(|case| !case.distance.runs.is_empty()) {
        for (goal, name) in GOALS {
            let [ours, plain, told] =
                distance::ORDERS.map(|order| reached_over_cases(cases, order, goal).0);
            writeln!(
                out,
                "{name}: with {ours:.2} of the work (depth-first {plain:.2}, told the closest {told:.2})"
            )?;
        }
    } else {
        writeln!(
            out,
            "the meshes meet at every pose: no distance was measured"
        )?;
    }
    let in_time: usize = cases
        .iter()
        .flat_map(|case| &case.rounds)
        .map(|round| round.wrong)
        .sum();
    writeln!(
        out,
        "wrong: {}",
        figure("wrong".to_owned()) + in_time as f64
    )?;
    writeln!(
        out,
        "false certificates: {}",
        figure("false certificates".to_owned())
    )?;
    writeln!(out, "{}", args.out.join("index.html").display())?;
    Ok(())
}

fn tell_of_intersections(
    cases: &[Measurement],
    work: &BTreeMap<String, f64>,
    out: &mut impl Write,
) -> Result<(), Failure> {
    if cases.iter().all(|case| case.hits() == 0) {
        writeln!(
            out,
            "the meshes meet at no pose: no contact was to be found"
        )?;
        return Ok(());
    }
    let figure = |name: String| work.get(&name).copied().unwrap_or(f64::NAN);
    for (what, name, percent) in [
        ("contacts detected", "any", 5),
        ("pairs found", "recall", 20),
        ("contact regions seen", "coverage", 20),
    ] {
        let percent = plan().percent_near(percent);
        let shares = [DEFAULT, DEPTH_FIRST, ORACLE]
            .map(|order| figure(format!("{name}@{percent}% {order}")));
        let [ours, plain, oracle] = shares.map(|share| decimals(share, 3));
        writeln!(
            out,
            "{what} with {percent} % of the work: {ours} (depth-first {plain}, best order {oracle})"
        )?;
    }
    let gains =
        [DEFAULT, ORACLE].map(|order| figure(format!("first hit over depth-first {order} work")));
    let [ours, oracle] = gains.map(|gain| decimals(1.0 / gain, 2));
    writeln!(
        out,
        "first contact found with {ours} of the work of depth-first (best order {oracle})"
    )?;
    Ok(())
}

fn intro(cases: &[Measurement], total: usize, args: &Args, machine: &str) -> Vec<String> {
    let poses: usize = cases.iter().map(|case| case.strata.len()).sum();
    let hits: usize = cases.iter().map(Measurement::hits).sum();
    let (_, most) = effort(args.quick);
    let mut intro = vec![
        "A collision query has a budget, and stops when it is spent. This page shows what it knows by then: whether two meshes \
         touch, which of their triangles do, and how far apart they are, for several orders in which pairs of boxes can be visited. Everything \
         said is compared with the exact truth."
            .to_owned(),
        format!(
            "{} of two meshes, {}, {hits} of them colliding. Budgets of work are a share of the work of a \
             full search, a finished query for all pairs, at the same pose; these figures are the same on every machine. Budgets of time \
             were measured on up to {most} poses of each case: {machine}.",
            counted(cases.len(), "case"),
            counted(poses, "pose"),
        ),
        "Compared are: this library as it comes; plain depth-first search, a stack and nothing else, within the same budgets; a plain query, cut off, \
         of which nothing is known before it returns; and the best order that there is. That one is computed afterwards, from the truth: it \
         opens only pairs of boxes with intersections below, in the order that finds most by each budget, and pays for what no \
         order can avoid: the tests of all boxes on the way and of all triangles at its end, also of those that do not meet. \
         (For regions it follows the order that is best for pairs.) No order of visits can find more pairs sooner. \"With \
         memory\" takes the poses for frames of a motion and begins with what it remembers of the last one, which can be sooner."
            .to_owned(),
    ];
    if args.cases.iter().any(|path| is_mesh(path)) {
        intro.push(
            "The poses of two mesh files were made: the turned mesh comes from outside on random lines, with seven \
             poses on each, 5, 2, .5 and .1 % of the smaller mesh past the first touch and .1, .5 and 2 % before it, and poses \
             at random where the balls around the meshes overlap. They are the same in every run."
                .to_owned(),
        );
    }
    if cases.len() < total {
        intro.push(format!(
            "Interrupted: {} of {total} cases were finished, and only they are shown.",
            cases.len()
        ));
    }
    if args.quick {
        intro.push("A quick report: few poses, small meshes, more noise.".to_owned());
    }
    intro
}
