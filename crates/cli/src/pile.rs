//! `punctual pile`: bodies fall into a bin, with a budget for the contacts of each frame.

mod solver;
mod world;

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use punctual::glam::DVec3;
use punctual::{Budget, Pose};
use punctual_depenetrate::PenetrationWorkspace;
use punctual_lab::report::{self, Failure};
use punctual_lab::statistics::{quantile, sorted};
use punctual_scene::{Body, BodyId};
use punctual_view::{Known, Shown};

use crate::Completion;
use crate::input::{MeshArgs, print_source};
use crate::scene::play::{CpuClock, FrameArgs};
use world::{Frame, Pile, SIZE, SKIN, Shape};

/// Let bodies fall into a bin: a small solver of rigid bodies, whose contacts a scene finds within the budget of a frame.
///
/// All bodies are scaled to a size of 1, the diagonal of the box around them; a second has 60 frames. Bodies of which
/// too little is known are slowed down or held.
///
/// Prints CSV, a line for each frame: lost is the number of bodies outside of the bin; deepest the longest push that takes to
/// part two bodies, as proven by an exact query, every 60 frames, else empty; fastest the largest speed of a body; manifolds
/// their number, old ones included; fresh the share of the touching pairs whose manifolds are of this frame; cpu_ns the CPU
/// time of the detection, and overrun_ns what of it is beyond a budget of time. Lines that begin with # sum up.
#[derive(clap::Args)]
pub struct Args {
    /// Mesh files whose solids fall, in turn; by default a ring, a gear and a knot.
    meshes: Vec<PathBuf>,
    #[command(flatten)]
    reading: MeshArgs,
    /// Number of bodies.
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u16).range(1..))]
    bodies: u16,
    /// Number of frames.
    #[arg(long, value_name = "F", default_value_t = 600)]
    frames: usize,
    #[command(flatten)]
    frame: FrameArgs,
    /// Write a page that shows the pile in a browser, frame by frame: of a long run every second, third or later frame, 120
    /// at most. It needs no other file and no network.
    #[arg(long, value_name = "FILE")]
    view: Option<PathBuf>,
}

/// Frames between two looks at how deep bodies are in each other.
const DEPTHS_EVERY: usize = 60;

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    args.frame.check()?;
    let start = Instant::now();
    let shapes = args.shapes()?;
    let mut pile = Pile::new(&shapes, args.bodies.into(), SKIN)?;
    print_source(out, start.elapsed())?;
    pile.scene.use_threads(args.frame.threads.into())?;
    let mut play = Play::new(args);
    writeln!(
        out,
        "frame,lost,deepest,fastest,manifolds,fresh,cpu_ns,overrun_ns"
    )?;
    for frame in 0..args.frames {
        play.frame(frame, &mut pile, out)?;
    }
    play.sum_up(&pile, out)?;
    if let Some(file) = &args.view {
        report::write(file, play.page(&pile).html()?)?;
    }
    Ok(Completion::Full)
}

impl Args {
    fn shapes(&self) -> Result<Vec<Shape>, Failure> {
        if self.meshes.is_empty() {
            return Shape::built_in();
        }
        let shape = |file: &PathBuf| {
            let shape = Shape::new(&self.reading.load(file)?, SIZE);
            Ok(shape.map_err(|error| format!("{}: {error}", file.display()))?)
        };
        self.meshes.iter().map(shape).collect()
    }
}

/// A frame that the page shows.
struct Shot {
    number: usize,
    poses: Vec<Pose>,
    known: Known,
    contacts: Vec<[DVec3; 2]>,
    frame: Frame,
}

/// What is needed from frame to frame, and what is summed up.
struct Play<'a> {
    args: &'a Args,
    clock: CpuClock,
    workspace: PenetrationWorkspace,
    shots: Vec<Shot>,
    times: Vec<Duration>,
    held: usize,
    slowed: usize,
    depths: Vec<f64>,
}

impl<'a> Play<'a> {
    fn new(args: &'a Args) -> Self {
        Self {
            args,
            clock: CpuClock::start(),
            workspace: PenetrationWorkspace::default(),
            shots: Vec::new(),
            times: Vec::new(),
            held: 0,
            slowed: 0,
            depths: Vec::new(),
        }
    }

    fn frame(
        &mut self,
        number: usize,
        pile: &mut Pile,
        out: &mut impl Write,
    ) -> Result<(), Failure> {
        pile.place()?;
        let budget = self.args.frame.budget().unwrap_or(Budget::unlimited());
        let (start, taken) = (ProcessTime::now(), self.clock.taken());
        self.args.frame.detect(&mut pile.scene, budget, &self.clock);
        let cpu = start.elapsed().saturating_sub(self.clock.taken() - taken);
        if self.args.view.is_some()
            && number.is_multiple_of(punctual_view::stride(self.args.frames))
        {
            self.shots.push(Shot::of(number, pile)?);
        }
        let frame = pile.advance()?;
        if let Some(shot) = self.shots.last_mut().filter(|shot| shot.number == number) {
            shot.frame = frame;
        }
        (self.held, self.slowed) = (self.held + frame.held, self.slowed + frame.slowed);
        self.times.push(cpu);
        let Frame {
            touching,
            fresh,
            manifolds,
            ..
        } = frame;
        let fresh = fresh as f64 / touching.max(1) as f64;
        let limits = &self.args.frame.limits;
        let overrun = limits
            .budget_us
            .map_or(Duration::ZERO, |limit| cpu.saturating_sub(limit));
        write!(out, "{number},{},", pile.lost())?;
        if (number + 1).is_multiple_of(DEPTHS_EVERY) {
            self.depths = pile.depths(&mut self.workspace)?;
            write!(out, "{:.4}", self.depths.last().unwrap_or(&0.0))?;
        }
        let (fastest, cpu, overrun) = (
            pile.speeds().last().copied().unwrap_or(0.0),
            cpu.as_nanos(),
            overrun.as_nanos(),
        );
        writeln!(out, ",{fastest:.4},{manifolds},{fresh:.3},{cpu},{overrun}")?;
        Ok(())
    }

    fn sum_up(&self, pile: &Pile, out: &mut impl Write) -> io::Result<()> {
        let all = (self.args.frames * usize::from(self.args.bodies)).max(1) as f64;
        let [held, slowed] = [self.held, self.slowed].map(|part| 100.0 * part as f64 / all);
        writeln!(
            out,
            "# bodies held, percent: {held:.2}; slowed down: {slowed:.2}"
        )?;
        let times = sorted(self.times.iter().map(|time| 1e6 * time.as_secs_f64()));
        // Nothing is 0.
        let at = |sorted: &[f64], share| quantile(sorted, share).max(0.0);
        let [median, p99, max] = [0.5, 0.99, 1.0].map(|share| at(&times, share));
        writeln!(
            out,
            "# detection, us: median {median:.1}, p99 {p99:.1}, max {max:.1}"
        )?;
        let (speeds, depths) = (pile.speeds(), &self.depths);
        let [speed, fastest] = [0.5, 1.0].map(|share| at(&speeds, share));
        let [deep, deepest] = [0.99, 1.0].map(|share| at(depths, share));
        let [over_1, over_5] =
            [0.01, 0.05].map(|limit| depths.iter().filter(|depth| **depth > limit).count());
        writeln!(
            out,
            "# at the end: speed median {speed:.4}, max {fastest:.4}; depth max {deepest:.4}, p99 {deep:.4}, of {} pairs; \
             {over_1} over 1 %, {over_5} over 5 %",
            depths.len(),
        )
    }

    fn page(&self, pile: &Pile) -> punctual_view::View {
        let bodies: Vec<(BodyId, &Body)> = pile.scene.bodies().collect();
        let bodies: Vec<_> = bodies
            .iter()
            .map(|&(id, body)| Shown {
                index: id.index(),
                name: id.index().to_string(),
                body,
            })
            .collect();
        let frames: Vec<_> = self.shots.iter().map(Shot::shown).collect();
        punctual_view::scene("A pile: what touches what".into(), &bodies, &frames)
    }
}

impl Shot {
    fn of(number: usize, pile: &Pile) -> Result<Self, Failure> {
        let poses = pile.scene.bodies().map(|(_, body)| body.pose).collect();
        let report = pile.scene.report();
        let mut contacts = Vec::new();
        for pair in &report.pairs {
            let poses = [
                &pile.scene.body(pair.a)?.pose,
                &pile.scene.body(pair.b)?.pose,
            ];
            let points = pile.scene.contacts(pair.a, pair.b)?.points.iter();
            contacts.extend(
                points
                    .map(|point| point.at(poses))
                    .map(|now| [now.points[0], now.normal]),
            );
        }
        Ok(Self {
            number,
            poses,
            known: Known::of(report),
            contacts,
            frame: Frame::default(),
        })
    }

    fn shown(&self) -> punctual_view::Frame<'_> {
        let Frame {
            touching,
            fresh,
            manifolds,
            held,
            slowed,
        } = self.frame;
        let lines = [
            ("Pairs with contacts", touching),
            ("Of these, of this frame", fresh),
            ("Manifolds", manifolds),
            ("Bodies held", held),
            ("Bodies slowed down", slowed),
        ];
        let facts = lines
            .map(|(name, number)| punctual_view::fact(name, punctual_view::count(number as u64)));
        punctual_view::Frame {
            number: self.number,
            poses: &self.poses,
            known: &self.known,
            contacts: &self.contacts,
            facts: facts.to_vec(),
        }
    }
}
