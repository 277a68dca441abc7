//! What the broad phase may spend of a frame.

use crate::model::cost::{BROAD_PHASE_WORK, WORK_PER_LISTED_PAIR};
use crate::query::{Budget, Clock, Deadline};
use core::time::Duration;

/// The steps of the broad phase, by the parts of its share that are spent at their ends: in eighths of the time of a frame, and
/// in sixths of the work. Of the time that is left to it, the list has half.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Place = 3,
    Pair = 5,
    List = 6,
}

/// Parts of the share, and of a frame of time.
const PARTS: u64 = Step::List as u64;
const PARTS_OF_TIME: u32 = 8;

/// Nanoseconds that a pair takes in a frame besides its query, from the list to the report.
const TIME_PER_PAIR: u128 = 100;

/// The share of a frame.
pub(super) struct Share<'c> {
    started: Option<Duration>,
    limit: Option<Duration>,
    work: Option<u64>,
    clock: &'c dyn Clock,
    /// Work done so far.
    pub spent: u64,
}

impl<'c> Share<'c> {
    /// Of a frame that began at `started`, if its time is limited.
    pub fn new(budget: Budget, started: Option<Duration>, clock: &'c dyn Clock) -> Self {
        let work = budget.work_limit().map(|work| work.saturating_add(BROAD_PHASE_WORK));
        Self { started, limit: budget.time_limit(), work, clock, spent: 0 }
    }

    /// Runs a step with its deadline.
    pub fn run<R>(&mut self, step: Step, run: impl FnOnce(&mut Deadline) -> R) -> R {
        let parts = step as u32;
        let end_of = |parts| Some(self.started?.saturating_add(self.limit? / PARTS_OF_TIME * parts));
        let mut work = self.work.map_or(u64::MAX, |work| (work / PARTS * u64::from(parts)).saturating_sub(self.spent));
        let mut end = end_of(parts);
        if let (Step::List, Some(last), Some(frame)) = (step, end, end_of(PARTS_OF_TIME)) {
            // What comes after the list takes longer than the list.
            let now = self.clock.now();
            let half = frame.saturating_sub(now) / 2;
            end = Some(last.min(now.saturating_add(half)));
            work = work.min((half.as_nanos() / TIME_PER_PAIR) as u64 * WORK_PER_LISTED_PAIR);
        }
        let mut deadline = Deadline::at(end, work, self.clock);
        let result = run(&mut deadline);
        self.spent += work - deadline.work_left();
        result
    }
}
