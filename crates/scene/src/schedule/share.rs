//! The share of a frame that the broad phase may spend.

use super::pace::{Reserved, list_work};
use crate::cost::{BROAD_PHASE_WORK, WORK_PER_FOUND_PAIR};
use core::hint::black_box;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Budget, Clock};

/// The end of a step before the list: the part of the work of the broad phase that is spent then,
/// and the part of the time left that has passed.
pub(crate) struct End {
    sixths_of_work: u64,
    eighths_of_time: u32,
}

/// The ends of placing bodies, and of finding pairs.
pub(crate) const PLACE: End = End {
    sixths_of_work: 3,
    eighths_of_time: 2,
};
pub(crate) const PAIR: End = End {
    sixths_of_work: 5,
    eighths_of_time: 6,
};

/// Maximum time that counts for a list after its deadline, nanoseconds.
const MOST_CLOSING: f64 = 10_000.0;
/// Maximum time that counts for each pair found before a list, nanoseconds.
const MOST_OF_FOUND: f64 = 250.0;

/// The share of a frame.
pub(crate) struct Share<'c> {
    is_timed: bool,
    started: Duration,
    limit: Duration,
    work: Option<u64>,
    /// Number of pairs found before the list.
    found: usize,
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
        let work = budget.work_limit().map(|work| {
            work.saturating_add(BROAD_PHASE_WORK)
                .saturating_sub(listing(found))
        });
        // Without `black_box` the compiler computes with missing values before they are needed,
        // which valgrind reports.
        let [started, limit] = black_box(left.unwrap_or_default());
        Self {
            is_timed: left.is_some(),
            started,
            limit,
            work,
            found,
            clock,
            spent: 0,
        }
    }

    /// Runs a step with its deadline.
    pub fn run(&mut self, step: End, run: impl FnOnce(&mut Deadline)) {
        let part = self.limit / 8 * step.eighths_of_time;
        let end = self.is_timed.then(|| self.started.saturating_add(part));
        self.run_until(end, self.work_left(step.sixths_of_work), run);
    }

    /// Runs the list in half of the time left, and measures how long it takes after that
    /// (`closing`): the pairs found before are listed in any case.
    pub fn list(&mut self, closing: &mut Reserved, run: impl FnOnce(&mut Deadline)) {
        let (work, of_found) = (self.work_left(6), listing(self.found));
        if !self.is_timed {
            return self.run_until(None, work.saturating_add(of_found), run);
        }
        let began = self.clock.now();
        let left = self
            .started
            .saturating_add(self.limit)
            .saturating_sub(began);
        let end = began.saturating_add(left / 2);
        let work = work.min(list_work(left)).saturating_add(of_found);
        self.run_until(Some(end), work, run);
        let most = MOST_CLOSING + MOST_OF_FOUND * self.found as f64;
        closing.learn(self.clock.now().saturating_sub(end), most);
    }

    /// The work left of this many sixths of the work of the broad phase.
    fn work_left(&self, sixths: u64) -> u64 {
        self.work.map_or(u64::MAX, |work| {
            (work / 6 * sixths).saturating_sub(self.spent)
        })
    }

    fn run_until(&mut self, end: Option<Duration>, work: u64, run: impl FnOnce(&mut Deadline)) {
        let mut deadline = Deadline::of_a_part(end, work, self.clock);
        run(&mut deadline);
        self.spent += work - deadline.work_left();
    }
}

/// Work of listing this many pairs that were found before.
fn listing(found: usize) -> u64 {
    found as u64 * WORK_PER_FOUND_PAIR
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::clock::ManualClock;

    #[test]
    fn what_a_list_takes_after_half_of_the_time_left_is_measured() {
        const LIMIT: Duration = Duration::from_micros(100);
        let late = Duration::from_micros(8);
        let (clock, mut closing) = (ManualClock::new(), Reserved::default());
        for _ in 0..10 {
            let mut share = Share::new(Budget::time(LIMIT), Some([clock.now(), LIMIT]), 0, &clock);
            share.list(&mut closing, |deadline| {
                while deadline.has_room(100) {
                    clock.advance(Duration::from_nanos(300));
                    deadline.spend(100);
                }
                clock.advance(late);
            });
            let error = closing.time().abs_diff(late);
            assert!(error < Duration::from_micros(2), "{:?}", closing.time());
        }
    }
}
