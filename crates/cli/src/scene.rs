//! `punctual scene`: many moving bodies, a budget for each frame.

mod answers;
mod files;
mod plain;
pub mod play;
mod summary;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use punctual::Mode;
use punctual_lab::report::{self, Failure};
use punctual_scene::PairReport;
use punctual_view::{Frame, Known, Shown, View};

use crate::Completion;
use crate::input::MeshArgs;
use crate::pair::ModeName;
use answers::Questions;
use files::Recording;
use play::{ClockName, FrameArgs, FrameRow, Settings, play};

/// Play a scene through the detector, frame by frame: a folder of meshes and poses, or a file that Scene::recorded wrote.
///
/// Prints CSV, a line for each frame: broad_pairs is the number of pairs whose boxes overlap; decided, hits and undecided
/// count verdicts; wall_ns and cpu_ns are times of the frame, new poses and broad phase included; overrun_ns is the CPU time
/// of the detection, without the new poses, beyond a time budget. Lines that begin with # sum up; accuracy is there if DIR
/// has truth_pairs.csv.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with scene.txt, poses.csv and, if there is one, truth_pairs.csv (the last two plain or .gz); or a file of a
    /// scene's calls (plain or .gz), which has its own questions and budgets; its frames take the times of the detection.
    #[arg(value_name = "DIR|FILE")]
    dir: PathBuf,
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    frame: FrameArgs,
    /// Instead of the scene its simplest rival, with the clock `cpu`: boxes sorted along x, then one query after another. Its
    /// rows count the pairs that it came to.
    #[arg(long, conflicts_with_all = ["view", "pairs_out"])]
    plain: bool,
    /// Play only this many frames.
    #[arg(long, value_name = "N", default_value_t = usize::MAX, hide_default_value = true)]
    frames: usize,
    /// Stop at the first intersecting triangle pair of two bodies, or find all.
    #[arg(long, value_enum, default_value = "any")]
    mode: ModeName,
    #[command(flatten)]
    questions: Questions,
    /// Plays of the whole recording; times are the least of them, all else is of the first.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
    /// Write lines frame,a,b,verdict,probability,age of all pairs whose boxes overlap, by the body numbers of the file.
    #[arg(long, value_name = "FILE")]
    pairs_out: Option<PathBuf>,
    /// Write a page that shows the bodies in a browser, frame by frame, in colours that say which meet others: of a long
    /// recording every second, third or later frame, 120 at most. It needs no other file and no network.
    #[arg(long, value_name = "FILE")]
    view: Option<PathBuf>,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    args.frame.check()?;
    let recording = Recording::load(&args.dir, &args.meshes)?;
    if args.plain
        && (args.frame.clock == ClockName::Wall || args.asks() || recording.calls.is_some())
    {
        return Err(
            "--plain needs a folder and --clock cpu, and asks only which bodies meet".into(),
        );
    }
    if recording.calls.is_some() && (args.view.is_some() || args.asks()) {
        return Err(
            "a file of calls is played with its own mode and questions, without --view".into(),
        );
    }
    let settings = args.settings();
    let mut pairs_out = match &args.pairs_out {
        Some(file) => Some(BufWriter::new(File::create(file)?)),
        None => None,
    };
    if let Some(file) = &mut pairs_out {
        writeln!(file, "frame,a,b,verdict,probability,age")?;
    }
    let shown = recording.frames.len().min(args.frames);
    let mut reported = vec![Known::default(); if args.view.is_some() { shown } else { 0 }];
    let (rows, completion) = play(&recording, &settings, |frame, report| {
        if let Some(reported) = reported.get_mut(frame) {
            *reported = Known::of(report);
        }
        pairs_out.as_mut().map_or(Ok(()), |file| {
            report
                .pairs
                .iter()
                .try_for_each(|pair| write_pair(file, frame, pair))
        })
    })?;
    if let Some(mut file) = pairs_out {
        file.flush()?;
    }
    print_rows(out, &rows)?;
    summary::print(out, &rows, recording.truth.is_some())?;
    if let Some(file) = &args.view {
        report::write(file, args.page(&recording, &reported, &rows).html()?)?;
    }
    Ok(completion)
}

impl Args {
    /// Whether the scene is to be asked for more than which bodies meet.
    fn asks(&self) -> bool {
        self.mode == ModeName::All || self.questions.any()
    }

    /// The page of a play, with the pairs reported in each frame.
    fn page(&self, recording: &Recording, reported: &[Known], rows: &[FrameRow]) -> View {
        let frame = |number: usize| {
            let row = &rows[number];
            let lines = [("Box tests", row.bv_tests), ("Work", row.work)];
            let facts = lines
                .map(|(name, number)| punctual_view::fact(name, punctual_view::count(number)))
                .to_vec();
            Frame {
                number,
                poses: &recording.frames[number],
                known: &reported[number],
                contacts: &[],
                facts,
            }
        };
        let frames: Vec<_> = (0..rows.len())
            .step_by(punctual_view::stride(rows.len()))
            .map(frame)
            .collect();
        let folder = self.dir.canonicalize().unwrap_or_else(|_| self.dir.clone());
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let shown = |(index, (body, mesh))| Shown {
            index,
            name: format!("{index}: {mesh}"),
            body,
        };
        let bodies: Vec<_> = recording
            .bodies
            .iter()
            .zip(&recording.meshes)
            .enumerate()
            .map(shown)
            .collect();
        punctual_view::scene(format!("Which bodies meet: {name}"), &bodies, &frames)
    }

    fn settings(&self) -> Settings<'_> {
        let mode = match self.mode {
            ModeName::Any => Mode::Any,
            ModeName::All => Mode::All,
        };
        Settings {
            mode,
            plain: self.plain,
            frame: &self.frame,
            frames: self.frames,
            plays: self.reps,
            questions: &self.questions,
        }
    }
}

fn write_pair(out: &mut impl Write, frame: usize, pair: &PairReport) -> std::io::Result<()> {
    let PairReport {
        a,
        b,
        verdict,
        probability,
        age,
        ..
    } = pair;
    let verdict = verdict.name();
    writeln!(
        out,
        "{frame},{},{},{verdict},{probability:.4},{age}",
        a.index(),
        b.index()
    )
}

fn print_rows(out: &mut impl Write, rows: &[FrameRow]) -> std::io::Result<()> {
    writeln!(
        out,
        "frame,broad_pairs,decided,hits,undecided,wall_ns,cpu_ns,overrun_ns,bv_tests,work"
    )?;
    for (frame, row) in rows.iter().enumerate() {
        let (undecided, overrun) = (row.broad_pairs - row.decided, row.overrun());
        writeln!(
            out,
            "{frame},{},{},{},{undecided},{},{},{},{},{}",
            row.broad_pairs,
            row.decided,
            row.hits,
            row.wall.as_nanos(),
            row.cpu.as_nanos(),
            overrun.as_nanos(),
            row.bv_tests,
            row.work,
        )?;
    }
    Ok(())
}
