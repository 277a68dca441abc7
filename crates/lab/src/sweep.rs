//! What a deadline costs in accuracy, for every order.

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
use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::machine;
use crate::report::{self, Failure};
use indicatif::{ProgressBar, ProgressStyle};
use punctual_io::Format;
use serde_json::{Map, json};

use case::Case;
use contender::{DEFAULT, DEPTH_FIRST, ORACLE};
use distance::Truths;
use measure::{Asked, Measured};
use page::{counted, decimals};
use plan::plan;
pub use plan::{Plan, others};
use summary::{GOALS, Measurement, Stratum, reached_over_cases};

/// What to sweep, and where the report goes.
pub struct Settings<'s> {
    /// Mesh files, two for a case, A before B; or folders of cases.
    pub cases: &'s [PathBuf],
    /// Generated shapes that approach each other, too.
    pub builtin: bool,
    /// The folder of the report; made if it does not exist.
    pub folder: &'s Path,
    /// Times of other libraries' distance queries: lines `case,peer,pose,distance,ns`.
    pub peer_times: Option<&'s Path>,
    /// Measure distance queries alone.
    pub distance_only: bool,
    /// A smaller report with more noise, in seconds.
    pub quick: bool,
    /// What is compared, and by which budgets. That of the first sweep of a process counts.
    pub plan: Plan,
    /// Of the progress bar.
    pub style: ProgressStyle,
    /// Set while it runs, it ends the sweep after the step in hand; finished cases are reported.
    pub interrupted: &'s AtomicBool,
    /// Is told what is wrong, and what was passed over in mesh files.
    pub complain: &'s dyn Fn(&dyn Display),
}

/// Steps of the progress bar for a case.
const STEPS: u64 = 1000;

/// Share of the progress bar that is budgets of work.
const WORK_STEPS: u64 = STEPS / 4;

/// Measures, and writes the report. Whether all cases were finished and nothing was wrong.
///
/// # Errors
/// If a file cannot be read or written; the message names it.
pub fn run(args: &Settings<'_>, out: &mut impl Write) -> Result<bool, Failure> {
    args.plan.choose();
    let mut peers = args
        .peer_times
        .map(peers::read)
        .transpose()?
        .unwrap_or_default();
    report::create_folder(&args.folder.join("truth"))?;
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
            Case::between(files, args.quick, args.folder, args.complain)
        }));
    }
    if args.builtin {
        cases.extend(built_in::cases(args.quick));
    }
    let total = cases.len();
    let bar = ProgressBar::new(STEPS * total as u64).with_style(args.style.clone());
    let mut measured = Vec::new();
    for (i, load) in cases.into_iter().enumerate() {
        let case = load()?;
        bar.set_message(case.name.clone());
        let progress = Progress {
            bar: &bar,
            interrupted: args.interrupted,
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
    let wrong = complain_of_wrong(&measured, args.complain);
    write_report(&measured, total, args, out)?;
    Ok(!wrong && measured.len() == total)
}

struct Progress<'p> {
    bar: &'p ProgressBar,
    interrupted: &'p AtomicBool,
    start: u64,
}

impl Progress<'_> {
    /// Notes a share of the case; false after Ctrl-C.
    fn at(&self, steps: u64) -> bool {
        self.bar.set_position(self.start + steps);
        !self.interrupted.load(Ordering::Relaxed)
    }
}

/// Whether a path is that of a mesh file, not of a folder.
fn is_mesh(path: &Path) -> bool {
    Format::of(path).is_ok() && !path.is_dir()
}

/// Nothing if interrupted.
fn measure(
    case: &Case,
    args: &Settings<'_>,
    progress: &Progress,
) -> Result<Option<Measurement>, Failure> {
    let truth = truth::of_case(
        case,
        &args.folder.join("truth").join(format!("{}.csv", case.name)),
    )?;
    let (round_count, most) = effort(args.quick);
    let mut work = Measured::default();
    let distances = Truths::new(case, &truth, &mut work);
    distances.work(&mut work);
    let rounds = 0..round_count;
    let mut rounds: Vec<_> = rounds.map(|_| distances.round(most, &mut work)).collect();
    if args.distance_only {
        if !progress.at(STEPS) {
            return Ok(None);
        }
    } else {
        let poses = truth.len() as u64;
        let mut done = 0;
        let is_whole = measure::case(case, &truth, &mut work, || {
            done += 1;
            progress.at(WORK_STEPS * done / poses)
        });
        let step = truth.len().div_ceil(most).max(1);
        let timed: Vec<usize> = (0..truth.len()).step_by(step).collect();
        let passes = round_count * 2 * plan().contenders().count() as u64;
        let mut done = 0;
        let mut timed = |round| {
            punctuality::round(case, &truth, &timed, round, || {
                done += 1;
                progress.at(WORK_STEPS + (STEPS - WORK_STEPS) * done / passes)
            })
        };
        if !is_whole || !rounds.iter_mut().all(&mut timed) {
            return Ok(None);
        }
    }
    let strata = case.poses.iter().zip(&truth);
    Ok(Some(Measurement {
        name: case.name.clone(),
        triangles: [case.a.mesh().len(), case.b.mesh().len()],
        strata: strata
            .map(|(pose, truth)| Stratum::of(case, pose, truth))
            .collect(),
        work,
        rounds,
        peers: BTreeMap::new(),
    }))
}

/// Rounds of queries with budgets of time, and the poses of a case in them.
fn effort(quick: bool) -> (u64, usize) {
    if quick { (2, 12) } else { (5, 100) }
}

/// Wrong answers under budgets of time.
fn wrong_in_time(cases: &[Measurement]) -> usize {
    let rounds = cases.iter().flat_map(|case| &case.rounds);
    rounds.map(|round| round.wrong).sum()
}

/// Names what a guarantee was broken by; whether anything did.
fn complain_of_wrong(cases: &[Measurement], complain: &dyn Fn(&dyn Display)) -> bool {
    cases
        .iter()
        .flat_map(Measurement::complaints)
        .for_each(|what| complain(what));
    let in_time = wrong_in_time(cases);
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
    args: &Settings<'_>,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let machine = machine::describe();
    let table: Vec<_> = cases.iter().flat_map(summary::table).collect();
    report::write_csv(args.folder, "sweep", summary::HEADER, &table)?;
    let table: Vec<_> = cases.iter().flat_map(summary::distance_table).collect();
    report::write_csv(args.folder, "distance", summary::DISTANCE_HEADER, &table)?;

    // What is not a number is null.
    let work = summary::work_figures(cases);
    let time = summary::time_figures(cases).into_iter();
    let time = time.map(|(name, f)| (name, json!({ "value": f.value, "noise": f.noise })));
    let names = cases
        .iter()
        .map(|case| format!("{}, {}", case.name, counted(case.strata.len(), "pose")));
    let summary = json!({
        "machine": machine,
        "cases": names.collect::<Vec<_>>(),
        "work": work,
        "time": time.collect::<Map<_, _>>(),
    });
    report::write(
        &args.folder.join("summary.json"),
        serde_json::to_string_pretty(&summary)? + "\n",
    )?;

    let page = page::page(cases, args.folder, intro(cases, total, args, &machine))?;
    report::write(&args.folder.join("index.html"), page.html())?;
    if !args.distance_only {
        tell_of_intersections(cases, &work, out)?;
    }
    if cases.iter().any(|case| case.has(Asked::Distance)) {
        for (goal, (name, _)) in GOALS.into_iter().enumerate() {
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
    writeln!(
        out,
        "wrong: {}",
        work["wrong"] + wrong_in_time(cases) as f64
    )?;
    writeln!(out, "false certificates: {}", work["false certificates"])?;
    writeln!(out, "{}", args.folder.join("index.html").display())?;
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

fn intro(cases: &[Measurement], total: usize, args: &Settings<'_>, machine: &str) -> Vec<String> {
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
