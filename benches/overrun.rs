//! How late a time budget ends, in CPU time of the thread: `cargo bench -p punctual-benches --bench overrun -- [CALLS]` (default 20,000; a tenth of
//! them with the longest budget).
//!
//! Queries that need far more than their budget, deadlines by the CPU clock of the thread, so that what other programs take
//! does not count; interrupts do. Beside each query, for as long, a loop that does nothing but look at the same clock. Run
//! something on the other cores when measuring.

#[path = "../examples/controller/arms.rs"]
mod arms;

use std::time::Duration;

use arms::Arms;
use cpu_time::ThreadTime;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Clock, Mode, Pose, Query, StopReason, Tree, Workspace, shapes};

struct Cpu(ThreadTime);

impl Clock for Cpu {
    fn now(&self) -> Duration {
        self.0.elapsed()
    }
}

/// Quantiles of times, microseconds.
fn row(name: &str, mut times: Vec<Duration>) {
    times.sort_unstable();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e6;
    let [half, ninety, most, nearly_all, all] = [0.5, 0.9, 0.99, 0.999, 1.0].map(at);
    println!("{name:<44} {half:>8.2} {ninety:>8.2} {most:>8.2} {nearly_all:>8.2} {all:>8.2}");
}

/// Time past the budget of `call`, which returns whether the budget ended it, and of an idle loop of the same length.
fn measure(name: &str, calls: usize, budget: Duration, mut call: impl FnMut(usize, &Cpu) -> bool) {
    let clock = Cpu(ThreadTime::now());
    let (mut late, mut idle) = (Vec::with_capacity(calls), Vec::with_capacity(calls));
    for number in 0..calls {
        let start = clock.now();
        let stopped = call(number, &clock);
        let elapsed = clock.now() - start;
        if !stopped {
            continue;
        }
        late.push(elapsed.saturating_sub(budget));
        let (start, mut elapsed) = (clock.now(), Duration::ZERO);
        while elapsed < budget {
            elapsed = clock.now() - start;
        }
        idle.push(elapsed - budget);
    }
    println!("{} of {calls} calls used their budget", late.len());
    if late.is_empty() {
        return;
    }
    row(&format!("{name}, past {budget:?}"), late);
    row("  idle loop", idle);
}

fn main() {
    let calls = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(20_000);
    let clock = Cpu(ThreadTime::now());
    let mut looks: Vec<Duration> = (0..1000).map(|_| clock.now()).collect();
    looks = looks.windows(2).map(|two| two[1] - two[0]).collect();
    println!("{:<44} {:>8} {:>8} {:>8} {:>8} {:>8}", "microseconds", "p50", "p90", "p99", "p99.9", "max");
    row("one look at the clock", looks);

    let mut workspace = Workspace::new();
    for resolution in [128, 512] {
        let knot = Tree::new(shapes::torus_knot(2, 3, 0.2, resolution));
        for (micros, calls) in [(20, calls), (200, calls / 10)] {
            let (name, budget) = (format!("{} triangles a side", knot.mesh().len()), Duration::from_micros(micros));
            measure(&name, calls, budget, |number, clock| {
                let turn = DMat3::from_rotation_x(0.2 + 0.001 * (number % 2500) as f64);
                let pose = Pose::new(turn, DVec3::ZERO).expect("a rotation");
                let query = Query::new(&knot, &knot, pose).mode(Mode::All);
                query.run_with(&mut workspace, None, Budget::time(budget), clock).stop == StopReason::Deadline
            });
        }
    }
    let mut arms = Arms::new().expect("sound meshes");
    let budget = Duration::from_micros(5);
    measure("two arms", calls, budget, |number, clock| {
        let undecided = arms.scene.detect_with(Budget::time(budget), clock).undecided();
        // Outside of the budget: poses for the next call.
        arms.place(0.01 * (number % 1000) as f64).expect("sound poses");
        undecided > 0
    });
}
