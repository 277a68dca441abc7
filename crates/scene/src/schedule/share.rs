//! The share of a frame that the broad phase may spend.

use super::pace::{Reserved, list_work};
use crate::cost::{BROAD_PHASE_WORK, WORK_PER_FOUND_PAIR};
use core::hint::black_box;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Budget, Clock};

/// The ends of the steps before the list: the part of the work of the broad phase that is spent
/// then, in sixths, and the part of the time that has passed, in eighths.
pub(crate) const PLACE: (u64, u32) = (3, 2);
pub(crate) const PAIR: (u64, u32) = (5, 6);

const PARTS: u64 = 6;
const PARTS_OF_TIME: u32 = 8;

/// Maximum time that counts for a list after its deadline, nanoseconds.
const MOST_CLOSING: f64 = 10_000.0;

/// The share of a frame.
pub(crate) struct Share<'c> {
    is_timed: bool,
    started: Duration,
    limit: Duration,
    work: Option<u64>,
    /// Work reserved for listing the pairs found before.
    of_found: u64,
    clock: &'c dyn Clock,
    /// Work done so far.
    pub spent: u64,
}

impl<'c> Share<'c> {
    /// The share of the rest of a frame. `left`: when the rest begins, and how long it is, if time
    /// is limited. `found`: number of pairs known to meet.
    pub fn new(
        budget: Budget,
        left: Option<[Duration; 2]>,
        found: usize,
        clock: &'c dyn Clock,
    ) -> Self {
        let of_found = found as u64 * WORK_PER_FOUND_PAIR;
        let work = budget.work_limit().map(|work| {
            work.saturating_add(BROAD_PHASE_WORK)
                .saturating_sub(of_found)
        });
        // Without this, the compiler computes with missing values before they are needed, which
        // valgrind reports.
        let [started, limit] = black_box(left.unwrap_or_default());
        Self {
            is_timed: left.is_some(),
            started,
            limit,
            work,
            of_found,
            clock,
            spent: 0,
        }
    }

    /// Runs a step with its deadline.
    pub fn run(&mut self, (work, time): (u64, u32), run: impl FnOnce(&mut Deadline)) {
        let part = self.limit / PARTS_OF_TIME * time;
        let end = self.is_timed.then(|| self.started.saturating_add(part));
        self.run_until(end, self.work_left(work), run);
    }

    /// Runs the list, and measures how long it takes after its deadline (`closing`). Both together
    /// get half of the time left, but the deadline is never in less than a quarter of it. The pairs
    /// found before are listed in addition.
    pub fn list(&mut self, closing: &mut Reserved, run: impl FnOnce(&mut Deadline)) {
        let (work, of_found) = (self.work_left(PARTS), self.of_found);
        if !self.is_timed {
            return self.run_until(None, work.saturating_add(of_found), run);
        }
        let began = self.clock.now();
        let left = self
            .started
            .saturating_add(self.limit)
            .saturating_sub(began);
        let end = began.saturating_add(left / 2 - closing.time().min(left / 4));
        let work = work.min(list_work(left)).saturating_add(of_found);
        self.run_until(Some(end), work, run);
        closing.learn(self.clock.now().saturating_sub(end), MOST_CLOSING);
    }

    /// The rest of so many parts of the work of the broad phase.
    fn work_left(&self, parts: u64) -> u64 {
        self.work.map_or(u64::MAX, |work| {
            (work / PARTS * parts).saturating_sub(self.spent)
        })
    }

    fn run_until(&mut self, end: Option<Duration>, work: u64, run: impl FnOnce(&mut Deadline)) {
        let mut deadline = Deadline::of_a_part(end, work, self.clock);
        run(&mut deadline);
        self.spent += work - deadline.work_left();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::clock::ManualClock;

    #[test]
    fn a_list_that_was_over_late_ends_earlier_from_then_on() {
        const LIMIT: Duration = Duration::from_micros(100);
        let (clock, mut closing) = (ManualClock::new(), Reserved::default());
        let mut over = || {
            let began = clock.now();
            let mut share = Share::new(Budget::time(LIMIT), Some([began, LIMIT]), 0, &clock);
            share.list(&mut closing, |deadline| {
                while deadline.has_room(100) {
                    clock.advance(Duration::from_nanos(300));
                    deadline.spend(100);
                }
                clock.advance(Duration::from_micros(8));
            });
            clock.now() - began
        };
        let half = LIMIT / 2;
        assert!(over() > half + Duration::from_micros(7));
        for _ in 0..10 {
            let over = over();
            assert!(
                over <= half && over > half - Duration::from_micros(2),
                "{over:?}"
            );
        }
    }
}
