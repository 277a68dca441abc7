//! The deadline of a frame, as work that cannot pass it.

use crate::query::{Budget, Clock};
use core::time::Duration;

/// Further from the deadline than this, budgets are work and the clock is asked once for many pairs; nearer, each query
/// watches the clock itself.
const NEAR: u64 = 20_000;

/// Too near to begin anything: a pair's set-up and one step of its query.
const LAST: u64 = 700;

/// Hands out budgets that end before a deadline. One unit of work takes less than a nanosecond (three times what was
/// measured), as the query's own meter assumes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guard<'c, C> {
    clock: &'c C,
    deadline: Option<Duration>,
    /// Work that cannot pass the deadline.
    safe: u64,
    over: bool,
}

impl<'c, C: Clock> Guard<'c, C> {
    pub fn new(clock: &'c C, deadline: Option<Duration>) -> Self {
        Self { clock, deadline, safe: 0, over: false }
    }

    /// A budget of at most `work`; `None` if there is no time for anything.
    pub fn budget(&mut self, work: u64) -> Option<Budget> {
        let Some(deadline) = self.deadline else { return Some(Budget::work(work)) };
        if self.safe < NEAR {
            let left = deadline.saturating_sub(self.clock.now());
            // Nearest the deadline, what cannot be done in time is not begun.
            self.safe = left.as_nanos().min(u128::from(u64::MAX)) as u64;
            if self.safe < LAST {
                self.over = true;
                return None;
            }
            if self.safe < NEAR {
                return Some(Budget::time(left - Duration::from_nanos(LAST / 2)).and_work(work));
            }
        }
        Some(Budget::work(work.min(self.safe)))
    }

    pub fn clock(&self) -> &'c C {
        self.clock
    }

    /// Whether there was no time for something.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Takes note of work done.
    pub fn spend(&mut self, work: u64) {
        self.safe = self.safe.saturating_sub(work);
    }
}
