//! `punctual robot`: a robot, its cell, and lists of configurations or edges: what collides, what
//! is free.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use punctual::{Budget, Pose};
use punctual_io::{FileError, Format};
use punctual_lab::files::Listed;
use punctual_lab::report::{self, Failure};
use punctual_robot::{
    Checker, Clearance, ClearanceOptions, Collision, Edge, EdgeOptions, LARGEST, Margin, Model,
    Outcome, RobotError, Shape, ShapeId, UrdfOptions,
};
use punctual_view::Obstacle;

use crate::input::{
    Limits, Row, complain_of_bad_lines, complain_of_open, least_times, parse_size, print_rows,
    print_source, progress_style,
};
use crate::{Completion, complain};

/// Rows that several threads share between two steps of the progress bar.
const ROWS_PER_STEP: usize = 1024;

/// Which configurations of a robot collide, how much clearance they have, and which edges are free.
///
/// Prints CSV. A line for each configuration: verdict is free, contact or undecided (the budget
/// ended before), both proven; first_pair names the shapes that meet, with | between. With
/// --clearance: low <= least distance of all pairs <= high, both proven, in metres, and the pair.
/// With --edges a line for each edge, a straight line in joint space, times as shares of it: answer
/// is free, contact or undecided; no contact before free_until; contact at touching_at. ns is the
/// time of a call, kinematics included, the least of all repetitions; with several threads, the
/// time of all divided by their number. stop tells why a call ended, or error; work is in work
/// units. All but ns are of the first repetition.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("asked").required(true))]
pub struct Args {
    /// The robot, a URDF file. Meshes are .stl, .obj, .ply, .off, .glb, .gltf or .dae.
    urdf: PathBuf,
    /// The SRDF file, whose disabled pairs of links are not asked. Without it, links that are
    /// joined by one moving joint are not asked.
    #[arg(long, value_name = "FILE")]
    srdf: Option<PathBuf>,
    /// A folder in which packages of the robot are sought; may be given several times.
    #[arg(long, value_name = "DIR")]
    packages: Vec<PathBuf>,
    /// Closed meshes are solids: what is inside them collides.
    #[arg(long)]
    solids: bool,
    /// Shapes that are no farther apart than this, in metres, count as in contact. A clearance is
    /// what is left above it.
    #[arg(long, value_name = "D", default_value_t = 0.0, value_parser = parse_size, allow_negative_numbers = true)]
    margin: f64,
    /// A folder of meshes in world coordinates that stand around the robot.
    #[arg(long, value_name = "DIR")]
    env: Option<PathBuf>,
    /// Configurations: CSV with a header; columns are found by the names of joints, others are
    /// passed over.
    #[arg(long, value_name = "FILE", group = "asked")]
    configs: Option<PathBuf>,
    /// Measure the clearance of the configurations.
    #[arg(long, requires = "configs")]
    clearance: bool,
    /// Width of the bounds of a clearance, in metres; 0 is as close as f64 can tell.
    #[arg(long, value_name = "D", default_value_t = 1e-9, requires = "clearance", value_parser = parse_size, allow_negative_numbers = true)]
    tolerance: f64,
    /// Edges: CSV with a header; columns from_JOINT and to_JOINT for each joint, others are passed
    /// over.
    #[arg(long, value_name = "FILE", group = "asked")]
    edges: Option<PathBuf>,
    /// Seek the first contact of an edge, not any.
    #[arg(long, requires = "edges")]
    first_contact: bool,
    /// Threads; the answers are the same with any number of them, unless a budget of time ends
    /// them.
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: u16,
    /// Repetitions of the whole list; ns is the least of them.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
    #[command(flatten)]
    limits: Limits,
    /// Write a page that shows the robot at the configurations, its links coloured by clearance, with
    /// sliders that move the joints. It needs no other file and no network.
    #[arg(long, value_name = "FILE", conflicts_with = "edges")]
    view: Option<PathBuf>,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let start = Instant::now();
    let (mut checker, obstacles) = args.checker()?;
    print_source(out, start.elapsed())?;
    let model = Arc::clone(checker.model());
    let joints = model.joint_names();
    let mut asked = Asked {
        args,
        budget: args.limits.budget(),
        checker: &checker,
    };
    if let Some(file) = &args.edges {
        let columns = ["from_", "to_"].map(|end| joints.iter().map(move |j| format!("{end}{j}")));
        let columns: Vec<String> = columns.into_iter().flatten().collect();
        let edges = configurations(file, &columns)?;
        let completion = complain_of_bad_lines(file, "edge", &edges);
        asked.edges(&edges, out)?;
        return Ok(completion);
    }
    let file = args.configs.as_deref().unwrap_or(Path::new(""));
    let configs = configurations(file, joints)?;
    let completion = complain_of_bad_lines(file, "configuration", &configs);
    if args.clearance {
        asked.clearances(&configs, out)?;
    } else {
        asked.labels(&configs, out)?;
    }
    if let Some(view) = &args.view {
        let shown = configs.iter().enumerate();
        let shown = shown.filter_map(|(i, row)| Some((i, row.entry.as_deref().ok()?)));
        let shown: Vec<_> = shown
            .step_by(punctual_view::stride(configs.len()))
            .collect();
        let title = format!("How far a robot is from contact: {}", model.name());
        let budget = args.limits.budget();
        let page = punctual_view::robot(title, &mut checker, &obstacles, &shown, budget)?;
        report::write(view, page.html()?)?;
    }
    Ok(completion)
}

impl Args {
    fn checker(&self) -> Result<(Checker, Vec<Obstacle<'static>>), Failure> {
        let mut options = UrdfOptions::default();
        options.srdf.clone_from(&self.srdf);
        options.packages.clone_from(&self.packages);
        options.solids = self.solids;
        let model = Model::from_urdf(&self.urdf, &options)?;
        model.notices().iter().for_each(|notice| complain(notice));
        let (mut checker, mut obstacles) = (Checker::new(Arc::new(model)), Vec::new());
        checker.set_margin(Margin::All, self.margin)?;
        let Some(folder) = &self.env else {
            return Ok((checker, obstacles));
        };
        let fail = |error: io::Error| FileError::from_io(folder, &error);
        let files = fs::read_dir(folder).map_err(fail)?;
        let mut files = files.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        files.retain(|file| Format::of(&file.path()).is_ok());
        files.sort_by_key(fs::DirEntry::path);
        if files.is_empty() {
            complain(&format!("{}: no mesh files in it", folder.display()));
        }
        for file in files.iter().map(fs::DirEntry::path) {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            let mesh = punctual_io::load(&file)?.mesh;
            let shape = match self.solids {
                true => Shape::solid(mesh),
                false => Shape::mesh(mesh),
            };
            complain_of_open(&file, shape.surface());
            let pose = Pose::IDENTITY;
            let id = checker.add(&name, pose, shape.clone())?;
            obstacles.push(Obstacle {
                id,
                link: None,
                pose,
                shape,
            });
        }
        Ok((checker, obstacles))
    }
}

/// Rows of numbers, in the order of the columns named.
fn configurations(file: &Path, columns: &[String]) -> Result<Vec<Listed<Vec<f64>>>, FileError> {
    let text = fs::read_to_string(file).map_err(|error| FileError::from_io(file, &error))?;
    let lines = text.trim_start_matches('\u{feff}').lines();
    let lines = lines.enumerate().map(|(i, line)| (i + 1, line));
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (at_line, header) = lines
        .next()
        .ok_or_else(|| FileError::new(file, "no header with the names of joints"))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let find = |column: &String| {
        let mut found = (0..names.len()).filter(|&i| names[i] == column);
        let what = match [found.next(), found.next()] {
            [Some(at), None] => return Ok(at),
            [None, _] => format!("no column {column}"),
            _ => format!("two columns {column}"),
        };
        Err(FileError::at_line(file, at_line, what))
    };
    let places = columns.iter().map(find).collect::<Result<Vec<_>, _>>()?;
    let read = |line: &str| {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |(&at, column): (&usize, &String)| {
            let field = fields
                .get(at)
                .ok_or_else(|| format!("no value of {column}"))?;
            let number: f64 = field
                .parse()
                .map_err(|_| format!("{column} is \"{field}\", must be a number"))?;
            let is_fine = number.abs() <= LARGEST;
            is_fine
                .then_some(number)
                .ok_or_else(|| format!("{column} is {field}, must be at most {LARGEST:e}"))
        };
        places.iter().zip(columns).map(number).collect()
    };
    let listed = |(line, text)| Listed {
        line,
        entry: read(text),
    };
    Ok(lines.map(listed).collect())
}

struct Asked<'a> {
    args: &'a Args,
    budget: Budget,
    checker: &'a Checker,
}

impl Asked<'_> {
    /// Asks about all good rows; each repetition begins with a fresh checker. `one` asks about a
    /// row, `all` about many, one after the other, on several threads.
    fn ask<T>(
        &self,
        rows: &[Listed<Vec<f64>>],
        one: impl Fn(&mut Checker, &[f64]) -> Result<T, RobotError>,
        all: impl Fn(&mut Checker, &[&[f64]]) -> Result<Vec<T>, RobotError>,
    ) -> Result<Vec<Row<T>>, Failure> {
        let good: Vec<&[f64]> = rows
            .iter()
            .filter_map(|row| Some(row.entry.as_ref().ok()?.as_slice()))
            .collect();
        let total = good.len() as u64 * u64::from(self.args.reps);
        let bar = ProgressBar::new(total).with_style(progress_style()?);
        let mut fault = None;
        let mut repetition = || {
            let mut checker = self.checker.clone();
            let answers: Result<Vec<(T, [Duration; 1])>, RobotError> = if self.args.threads > 1 {
                let start = Instant::now();
                let mut answers = Vec::with_capacity(good.len());
                let asked = good.chunks(ROWS_PER_STEP).try_for_each(|rows| {
                    answers.extend(all(&mut checker, rows)?);
                    bar.inc(rows.len() as u64);
                    Ok(())
                });
                let each = start.elapsed() / good.len().max(1) as u32;
                asked.map(|()| answers.into_iter().map(|answer| (answer, [each])).collect())
            } else {
                let timed = |row: &&[f64]| {
                    let start = Instant::now();
                    let answer = (one(&mut checker, row)?, [start.elapsed()]);
                    bar.inc(1);
                    Ok(answer)
                };
                good.iter().map(timed).collect()
            };
            let mut answers = answers
                .map_err(|error| fault = Some(error))
                .into_iter()
                .flatten();
            let row = |row: &Listed<_>| row.entry.as_ref().ok().and_then(|_| answers.next());
            rows.iter().map(row).collect()
        };
        let answers = least_times(self.args.reps, &mut repetition);
        bar.finish_and_clear();
        match fault {
            Some(fault) => Err(fault.into()),
            None => Ok(answers),
        }
    }

    fn threads(&self) -> usize {
        usize::from(self.args.threads)
    }

    fn name(&self, id: ShapeId) -> &str {
        self.checker.name(id).unwrap_or("")
    }

    /// The names of both shapes, or nothing.
    fn names(&self, pair: Option<[ShapeId; 2]>) -> [&str; 2] {
        pair.map_or([""; 2], |pair| pair.map(|id| self.name(id)))
    }

    fn labels(&mut self, rows: &[Listed<Vec<f64>>], out: &mut impl Write) -> Result<(), Failure> {
        let answers: Vec<Row<Outcome<Collision>>> = self.ask(
            rows,
            |checker, q| checker.collide(q, self.budget),
            |checker, all| checker.collide_batch(&all.concat(), self.budget, self.threads()),
        )?;
        let header = "config,verdict,first_pair,ns,stop,work";
        print_rows(out, header, &answers, ",,0,error,0", |found, ns| {
            let (verdict, pair) = match found.value {
                Collision::Free => ("free", None),
                Collision::Contact(pair) => ("contact", Some(pair)),
                Collision::Undecided => ("undecided", None),
            };
            let pair = pair.map_or(String::new(), |pair| self.names(Some(pair)).join("|"));
            format!("{verdict},{pair},{ns},{},{}", found.stop, found.work)
        })?;
        Ok(())
    }

    fn clearances(
        &mut self,
        rows: &[Listed<Vec<f64>>],
        out: &mut impl Write,
    ) -> Result<(), Failure> {
        let options = ClearanceOptions::default().tolerance(self.args.tolerance);
        let answers: Vec<Row<Outcome<Clearance>>> = self.ask(
            rows,
            |checker, q| checker.clearance(q, &options, self.budget),
            |checker, all| {
                checker.clearance_batch(&all.concat(), &options, self.budget, self.threads())
            },
        )?;
        let header = "config,low,high,pair_a,pair_b,ns";
        print_rows(out, header, &answers, ",,,,0", |found, ns| {
            let Clearance {
                low, high, pair, ..
            } = found.value;
            let [a, b] = self.names(pair);
            format!("{low},{high},{a},{b},{ns}")
        })?;
        Ok(())
    }

    fn edges(&mut self, rows: &[Listed<Vec<f64>>], out: &mut impl Write) -> Result<(), Failure> {
        let options = match self.args.first_contact {
            true => EdgeOptions::first(),
            false => EdgeOptions::any(),
        };
        let width = self.checker.model().joint_names().len();
        let answers: Vec<Row<Outcome<Edge>>> = self.ask(
            rows,
            |checker, q| checker.edge(&q[..width], &q[width..], &options, self.budget),
            |checker, all| {
                let from: Vec<f64> = all.iter().flat_map(|q| &q[..width]).copied().collect();
                let to: Vec<f64> = all.iter().flat_map(|q| &q[width..]).copied().collect();
                checker.edge_batch(&from, &to, &options, self.budget, self.threads())
            },
        )?;
        let header = "edge,answer,free_until,touching_at,pair_a,pair_b,ns,work";
        print_rows(out, header, &answers, "error,,,,,0,0", |found, ns| {
            let Edge {
                answer,
                free_until,
                touching_at,
                pair,
                ..
            } = found.value;
            let at = touching_at.map(|time| time.to_string()).unwrap_or_default();
            let ([a, b], work) = (self.names(pair), found.work);
            format!("{answer},{free_until},{at},{a},{b},{ns},{work}")
        })?;
        Ok(())
    }
}
