//! A controller at 1 kHz: two arms share a space, and each cycle has 200 us to find out whether
//! they may go on.
//!
//! Each cycle looks at one more step of the path ahead. The arms drive what is proven clear, and
//! turn around before a contact. If the budget ends first, they drive more slowly on what is clear
//! already, or stop if the open boxes are too large or contact is too likely. At the end every
//! place where they were is checked again without a budget. Beside each check a loop only reads the
//! clock for as long: what it is late, the machine is.
//!
//! `controller [--calls N] [--budget-us N] [--unpaced]`; unpaced, cycles follow one another at once.
//! `docs/real-time.md` has measurements, and what a machine needs to be as punctual as this.

mod arms;
#[path = "../common/mod.rs"]
mod common;

use std::error::Error;
use std::hint::spin_loop;
use std::io::{self, Write};
use std::time::{Duration, Instant};

use arms::Arms;
use punctual::{Budget, Verdict};
use punctual_scene::Scene;

const CYCLE: Duration = Duration::from_millis(1);

/// Path driven in a cycle at full speed, seconds of the path.
const STEP: f64 = 4e-3;

/// Braking distance: the path ahead of the arms that must be clear.
const AHEAD: f64 = 10.0 * STEP;

/// Largest extent of the open boxes, metres, at which the arms only slow down.
const SMALL: f64 = 0.03;

/// Largest probability of a contact ahead at which the arms only slow down.
const UNLIKELY: f64 = 0.05;

/// The decision of a cycle.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Decision {
    Go,
    Slow,
    Stop,
    TurnAround,
}

fn decide(scene: &Scene) -> Result<Decision, Box<dyn Error>> {
    let report = scene.report();
    if report.intersecting > 0 {
        return Ok(Decision::TurnAround);
    }
    let (mut open, mut likely): (f64, f64) = (0.0, 0.0);
    for pair in report
        .pairs
        .iter()
        .filter(|pair| pair.verdict == Verdict::Undecided)
    {
        open = open.max(scene.certificate(pair.a, pair.b)?.largest_extent);
        likely = likely.max(pair.probability);
    }
    Ok(match report.undecided() {
        0 => Decision::Go,
        _ if open < SMALL && likely < UNLIKELY => Decision::Slow,
        _ => Decision::Stop,
    })
}

/// Position of the arms on their path, the clear part of it, and the direction of driving.
struct Drive {
    phase: f64,
    clear: f64,
    forward: f64,
}

impl Drive {
    /// The next place to look at.
    fn ahead(&self) -> f64 {
        self.clear + self.forward * STEP
    }

    fn follow(&mut self, decision: Decision) {
        let left = (self.clear - self.phase).abs() / AHEAD;
        let speed = match decision {
            Decision::Go => {
                if left < 1.0 {
                    self.clear = self.ahead();
                }
                left
            }
            Decision::Slow => 0.5 * left,
            Decision::Stop => 0.0,
            Decision::TurnAround => {
                // The path behind was clear too.
                (self.forward, self.clear) = (-self.forward, self.phase);
                0.0
            }
        };
        self.phase += self.forward * STEP * speed.min(1.0);
    }
}

/// Quantiles of times, microseconds.
fn row(out: &mut impl Write, name: &str, times: &mut [Duration]) -> io::Result<()> {
    times.sort_unstable();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e6;
    let [half, ninety, most, nearly_all, all] = [0.5, 0.9, 0.99, 0.999, 1.0].map(at);
    writeln!(
        out,
        "{name:<44} {half:>8.2} {ninety:>8.2} {most:>8.2} {nearly_all:>8.2} {all:>8.2}"
    )
}

/// Spins until `end`.
fn idle(end: Instant) {
    while Instant::now() < end {
        spin_loop();
    }
}

/// Number of cycles, budget of each, and pacing by the clock.
fn options() -> Result<(usize, Duration, bool), Box<dyn Error>> {
    let (mut calls, mut budget, mut paced) = (3000, Duration::from_micros(200), true);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || {
            arguments
                .next()
                .ok_or("a number is missing")?
                .parse::<u64>()
                .map_err(Box::<dyn Error>::from)
        };
        match argument.as_str() {
            "--calls" => calls = number()?.max(1) as usize,
            "--budget-us" => budget = Duration::from_micros(number()?),
            "--unpaced" => paced = false,
            _ => return Err(format!("unknown argument {argument}").into()),
        }
    }
    Ok((calls, budget, paced))
}

/// Counts the places at which the arms touch something, of 2,000 places at most.
fn touched(arms: &mut Arms, mut places: Vec<f64>) -> Result<usize, Box<dyn Error>> {
    places.sort_unstable_by(f64::total_cmp);
    places.dedup();
    let mut touched = 0;
    for &place in places.iter().step_by(places.len().div_ceil(2000)) {
        arms.place(place)?;
        touched += usize::from(arms.scene.detect(Budget::unlimited()).intersecting > 0);
    }
    Ok(touched)
}

fn run(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let (calls, budget, paced) = options()?;
    let mut arms = Arms::new()?;
    let mut drive = Drive {
        phase: 0.0,
        clear: 0.0,
        forward: 1.0,
    };
    let (mut checks, mut lateness) = (Vec::with_capacity(calls), Vec::with_capacity(calls));
    let (mut places, mut idles) = (Vec::with_capacity(calls), Vec::with_capacity(calls));
    let (mut decisions, mut missed, mut open) = ([0; 4], 0, 0);
    // A first round allocates all buffers and fills the caches.
    for _ in 0..100 {
        arms.scene.detect(Budget::time(budget));
    }
    eprintln!("cycles begin");
    let mut next = Instant::now();
    for _ in 0..calls {
        if paced {
            next += CYCLE;
            idle(next);
        }
        let start = Instant::now();
        arms.place(drive.ahead())?;
        let report = arms.scene.detect(Budget::time(budget));
        let (elapsed, undecided) = (report.elapsed.unwrap_or_default(), report.undecided());
        let decision = decide(&arms.scene)?;
        drive.follow(decision);
        let check = start.elapsed();

        let start = Instant::now();
        idle(start + check);
        idles.push(start.elapsed() - check);
        checks.push(check);
        lateness.push(elapsed.saturating_sub(budget));
        places.push(drive.phase);
        missed += usize::from(elapsed > budget + Duration::from_micros(2));
        open += usize::from(undecided > 0);
        decisions[decision as usize] += 1;
    }
    eprintln!("cycles end");

    writeln!(
        out,
        "{:<44} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "microseconds", "p50", "p90", "p99", "p99.9", "max"
    )?;
    row(out, "from the poses to the decision", &mut checks)?;
    row(out, "collision check past its budget", &mut lateness)?;
    row(out, "idle loop as long, past its end", &mut idles)?;
    let [go, slow, stop, back] = decisions;
    writeln!(
        out,
        "{calls} cycles: {go} went on, {slow} slowed down, {stop} stopped, {back} turned around; {open} had open pairs"
    )?;
    writeln!(
        out,
        "{missed} checks ended more than 2 us after their budget of {budget:?}"
    )?;
    let touched = touched(&mut arms, places)?;
    writeln!(out, "places where the arms touched something: {touched}")?;
    assert_eq!(touched, 0);
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(run)
}
