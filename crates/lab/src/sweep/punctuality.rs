//! Budgets of time: what is known when they end, and how late that is.

use std::hint::black_box;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use punctual::{Budget, StopReason, Workspace};

use super::case::Case;
use super::contender::{DEFAULT, DEPTH_FIRST};
use super::measure::{Answer, Finished, Judge, Limit, MODES, Round, Row, cut_off};
use super::plan::plan;
use super::truth::Truth;

/// How far beyond its budget a query ended, in seconds.
#[derive(Clone, Copy)]
pub struct Overrun {
    pub wall: f64,
    /// Less what the reading of the clocks takes.
    pub cpu: f64,
    /// Of a loop that only looks at the clock, over the same time, directly after the query.
    pub spin: f64,
}

/// The default order without any budget, which goes depth-first.
pub const UNLIMITED: &str = "no budget";

/// A round over the poses with these numbers; false if `progress`, called after each pass over the poses, says stop.
pub fn round(
    case: &Case,
    truth: &[Truth],
    poses: &[usize],
    round: &mut Round,
    mut progress: impl FnMut() -> bool,
) -> bool {
    let mut workspace = Workspace::with_capacity(4096, 1 << 20);
    let readings = clock_readings();
    for contender in plan().contenders() {
        for (asked, mode) in MODES {
            let query = |pose: usize| {
                contender
                    .query(&case.a, &case.b, case.poses[pose])
                    .mode(mode)
            };
            let mut finish = |order: &'static str, budget: Budget| {
                for &pose in poses {
                    let start = Instant::now();
                    let _ = black_box(query(pose).run(&mut workspace, budget));
                    round.finished.push(Finished {
                        pose,
                        order,
                        asked,
                        cost: start.elapsed().as_secs_f64(),
                        bv_tests: f64::NAN,
                    });
                }
            };
            finish(contender.name, Budget::work(u64::MAX));
            if contender.name == DEFAULT {
                finish(UNLIMITED, Budget::unlimited());
            }
            for limit in plan().times() {
                for &pose in poses {
                    let query = query(pose);
                    let (cpu, start) = (ThreadTime::now(), Instant::now());
                    let outcome = query.run(&mut workspace, Budget::time(limit));
                    let (wall, cpu) = (start.elapsed(), cpu.elapsed());
                    let mut judge = Judge::new(&truth[pose]);
                    let pairs = workspace.pairs().iter();
                    pairs.for_each(|pair| judge.report(*pair));
                    let verdict = judge.answer(&outcome, asked);
                    round.wrong += usize::from(verdict == Answer::Wrong);
                    let row = Row::new(pose, contender.name, asked, Limit::Time(limit), verdict)
                        .with(&judge);
                    round.rows.push(row);
                    let is_late = outcome.stop == StopReason::Deadline;
                    if contender.name == DEPTH_FIRST {
                        round.rows.push(cut_off(row, is_late));
                    }
                    if contender.name == DEFAULT && is_late {
                        let beyond = |time: Duration| time.as_secs_f64() - limit.as_secs_f64();
                        round.overruns.push(Overrun {
                            wall: beyond(wall),
                            cpu: beyond(cpu) - readings,
                            spin: beyond(spin(limit)),
                        });
                    }
                }
            }
            if !progress() {
                return false;
            }
        }
    }
    true
}

/// Looks at the clock until the time is over; how long that took.
fn spin(limit: Duration) -> Duration {
    let start = Instant::now();
    loop {
        let elapsed = start.elapsed();
        if elapsed >= limit {
            return elapsed;
        }
    }
}

/// CPU time that is measured around nothing, in seconds: the median.
fn clock_readings() -> f64 {
    let once = |_| {
        let (cpu, start) = (ThreadTime::now(), Instant::now());
        black_box(start.elapsed());
        cpu.elapsed().as_secs_f64()
    };
    let mut times: Vec<f64> = (0..101).map(once).collect();
    times.sort_by(f64::total_cmp);
    times[50]
}
