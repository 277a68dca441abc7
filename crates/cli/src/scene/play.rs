//! Plays a recording through a scene, frame by frame.

use std::cell::Cell;
use std::hint::black_box;
use std::time::{Duration, Instant};

use cpu_time::{ProcessTime, ThreadTime};
use punctual::{Budget, Clock, Mode, Motion, Verdict, Workspace};
use punctual_io::FileError;
use punctual_lab::report::Failure;
use punctual_scene::{BodyId, PairReport, Report, Scene, SceneError};

use super::answers::{Counts, Questions};
use super::files::Recording;
use super::plain;
use crate::input::parse_microseconds;
use crate::{Completion, complain};

/// What is measured and counted of one frame.
#[derive(Clone, Debug, Default)]
pub struct FrameRow {
    /// Known pairs, listed or not.
    pub broad_pairs: usize,
    pub decided: usize,
    pub hits: usize,
    pub worst_age: u64,
    /// Time of the frame: the new poses and the detection; least of all plays.
    pub wall: Duration,
    pub cpu: Duration,
    /// The part of the detection, which has the budget.
    pub detect_cpu: Duration,
    /// The budget of time, if there is one.
    pub limit: Option<Duration>,
    pub bv_tests: u64,
    pub work: u64,
    /// Against the truth, if it is known: intersecting pairs, those of them that were reported, and wrong verdicts.
    pub true_hits: usize,
    pub true_found: usize,
    pub wrong: usize,
    pub answers: Counts,
}

/// What a frame may take, and how that is measured.
#[derive(clap::Args)]
pub struct FrameArgs {
    #[command(flatten)]
    pub limits: FrameLimits,
    /// By what a time budget is measured; `cpu` is for measuring on a machine with other things to do.
    #[arg(long, value_enum, default_value = "wall")]
    pub clock: ClockName,
    /// Threads that share the work, the calling one included.
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,
}

#[derive(clap::Args)]
#[group(id = "budget", multiple = false)]
pub struct FrameLimits {
    /// Time budget of a frame in microseconds; without it none, or those of a file of calls.
    #[arg(long, value_name = "T", value_parser = parse_microseconds, allow_negative_numbers = true)]
    pub budget_us: Option<Duration>,
    /// Work budget of a frame in work units; the same answer on every run and any number of threads.
    #[arg(long, value_name = "N", alias = "work")]
    budget_work: Option<u64>,
}

impl FrameArgs {
    /// Refuses a clock of one thread for several.
    pub fn check(&self) -> Result<(), Failure> {
        if self.clock == ClockName::Cpu && self.threads > 1 {
            return Err("--clock cpu needs --threads 1".into());
        }
        Ok(())
    }

    /// The budget that is asked for.
    pub fn budget(&self) -> Option<Budget> {
        let FrameLimits {
            budget_us,
            budget_work,
        } = self.limits;
        budget_us
            .map(Budget::time)
            .or(budget_work.map(Budget::work))
    }

    /// Finds out what meets, within a budget.
    pub fn detect(&self, scene: &mut Scene, budget: Budget, clock: &CpuClock) {
        match self.clock {
            ClockName::Wall => scene.detect(budget),
            ClockName::Cpu => scene.detect(budget.clock(clock)),
        };
    }
}

/// By what a time budget is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ClockName {
    /// The clock on the wall, as a deadline sees it
    Wall,
    /// CPU time of the one thread: what other programs take does not count
    Cpu,
}

/// CPU time of the calling thread, less what it takes to ask for it: that is a system call, which takes many times as long as a
/// look at the clock on the wall, and a frame looks some twenty times.
pub struct CpuClock {
    time: ThreadTime,
    look: Duration,
    looks: Cell<u32>,
    last: Cell<Duration>,
}

impl CpuClock {
    pub fn start() -> Self {
        let clock = Self {
            time: ThreadTime::now(),
            look: Duration::ZERO,
            looks: Cell::new(0),
            last: Cell::default(),
        };
        let batch = || {
            let began = clock.time.elapsed();
            for _ in 1..LOOKS {
                black_box(clock.time.elapsed());
            }
            (clock.time.elapsed() - began) / LOOKS
        };
        let look = (0..LOOKS).map(|_| batch()).min().unwrap_or_default();
        Self { look, ..clock }
    }

    /// What all looks so far took.
    pub fn taken(&self) -> Duration {
        self.look * self.looks.get()
    }
}

/// Looks that are timed together, so often.
const LOOKS: u32 = 50;

impl Clock for CpuClock {
    fn now(&self) -> Duration {
        let taken = self.taken();
        self.looks.set(self.looks.get() + 1);
        let now = self
            .time
            .elapsed()
            .saturating_sub(taken)
            .max(self.last.get());
        self.last.set(now);
        now
    }
}

/// How a recording is played.
#[derive(Clone, Copy)]
pub struct Settings<'q> {
    pub mode: Mode,
    /// By a plain loop in place of the scene.
    pub plain: bool,
    /// Its budget is in place of the recorded one, or of none.
    pub frame: &'q FrameArgs,
    pub frames: usize,
    pub plays: u32,
    pub questions: &'q Questions,
}

/// Plays the recording, several times over for the least times. `seen` gets the reports of the first play. A file of calls
/// is played up to its first fault.
pub fn play(
    recording: &Recording,
    settings: &Settings,
    mut seen: impl FnMut(usize, &Report) -> std::io::Result<()>,
) -> Result<(Vec<FrameRow>, Completion), Failure> {
    let mut rows: Vec<FrameRow> = Vec::new();
    let mut answers = settings.questions.open(recording.calls.is_some())?;
    for _ in 0..settings.plays {
        let (mut scene, ids) = set_up(recording, settings)?;
        let mut replay = recording.replay()?;
        let (cpu_clock, mut workspace) = (CpuClock::start(), Workspace::new());
        for number in 0..settings.frames {
            let recorded = match (&mut replay, &recording.calls) {
                (Some(replay), Some(file)) => replay
                    .next_frame(&mut scene)
                    .map_err(|error| FileError::from_io(file, &error)),
                _ => Ok((number < recording.frames.len()).then(Budget::unlimited)),
            };
            let budget = match recorded {
                Ok(None) => break,
                Ok(Some(recorded)) => settings.frame.budget().unwrap_or(recorded),
                Err(error) if rows.is_empty() => return Err(error.into()),
                Err(error) => {
                    complain(&error);
                    return Ok((rows, Completion::Partial));
                }
            };
            let (wall, cpu) = (Instant::now(), ProcessTime::now());
            let next = recording
                .frames
                .get(number + 1)
                .filter(|_| settings.questions.moves());
            let poses = recording.frames.get(number).into_iter().flatten();
            for (body, (&id, &pose)) in ids.iter().zip(poses).enumerate() {
                match next {
                    Some(next) => scene.set_motion(id, Motion::screw(pose, next[body])?)?,
                    None => scene.set_pose(id, pose)?,
                }
            }
            let (posed, taken) = (cpu.elapsed(), cpu_clock.taken());
            let mut rival = None;
            if settings.plain {
                rival = Some(plain::detect(&scene, &mut workspace, budget, &cpu_clock)?);
            } else {
                settings.frame.detect(&mut scene, budget, &cpu_clock);
            }
            let report = scene.report();
            let (wall, cpu) = (
                wall.elapsed(),
                cpu.elapsed().saturating_sub(cpu_clock.taken() - taken),
            );
            let detect_cpu = cpu.saturating_sub(posed);
            if let Some(row) = rows.get_mut(number) {
                (row.wall, row.cpu) = (row.wall.min(wall), row.cpu.min(cpu));
                row.detect_cpu = row.detect_cpu.min(detect_cpu);
                continue;
            }
            let mut row = FrameRow {
                broad_pairs: report.pairs.len() + report.unlisted,
                decided: report.decided,
                hits: report.intersecting + report.within,
                worst_age: report.worst_age,
                wall,
                cpu,
                detect_cpu,
                limit: budget.time_limit(),
                bv_tests: report.bv_tests,
                work: report.work,
                ..FrameRow::default()
            };
            if let Some(rival) = rival {
                row = FrameRow {
                    wall,
                    cpu,
                    detect_cpu,
                    limit: row.limit,
                    ..rival
                };
            } else if let Some(truth) = &recording.truth {
                let known = |body: u32| {
                    report.unlisted == 0 && scene.partners_known(ids[body as usize]) == Ok(true)
                };
                compare(&report.pairs, &truth[number], known, &mut row);
            }
            seen(number, report)?;
            row.answers = answers.frame(number, &mut scene)?;
            rows.push(row);
        }
    }
    Ok((rows, Completion::Full))
}

fn set_up(recording: &Recording, settings: &Settings) -> Result<(Scene, Vec<BodyId>), Failure> {
    let mut scene = Scene::new();
    scene.set_mode(settings.mode);
    scene.use_threads(settings.frame.threads.into())?;
    let ids = recording
        .bodies
        .iter()
        .map(|body| scene.insert(body.clone()));
    let ids = ids.collect::<Result<Vec<_>, SceneError>>()?;
    settings.questions.ask(&mut scene, &ids)?;
    Ok((scene, ids))
}

/// Bodies were inserted in the order of their numbers, so those are their indices. `known`: whether the report has all pairs of
/// a body with others of which it has all.
fn compare(
    pairs: &[PairReport],
    truth: &[[u32; 2]],
    known: impl Fn(u32) -> bool,
    row: &mut FrameRow,
) {
    row.true_hits = truth.len();
    for pair in pairs {
        let meets = truth
            .binary_search(&[pair.a.index() as u32, pair.b.index() as u32])
            .is_ok();
        match pair.verdict {
            verdict if verdict.meets() && meets => row.true_found += 1,
            Verdict::Separated if !meets => {}
            Verdict::Undecided => {}
            _ => row.wrong += 1,
        }
    }
    // A pair of known bodies that is not listed is reported as apart.
    let listed = |key: &&[u32; 2]| {
        let key = (key[0] as usize, key[1] as usize);
        pairs
            .binary_search_by_key(&key, |pair| (pair.a.index(), pair.b.index()))
            .is_ok()
    };
    row.wrong += truth
        .iter()
        .filter(|key| known(key[0]) && known(key[1]) && !listed(key))
        .count();
}
