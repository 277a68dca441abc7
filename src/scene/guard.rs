//! The deadline of a frame, as work that cannot pass it.

use super::chain::LEAST;
use crate::query::Clock;
use core::time::Duration;

/// Allows work that ends before a deadline: a unit counts as a nanosecond, three times what was measured. So the clock is
/// asked once for many pairs, and more often the nearer the deadline.
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
        Self { clock, deadline, safe: if deadline.is_some() { 0 } else { u64::MAX }, over: false }
    }

    /// How much of `work` may be done before it has to be asked again; at least [`LEAST`], or nothing if the time is up.
    pub fn allow(&mut self, work: u64) -> Option<u64> {
        if let Some(deadline) = self.deadline.filter(|_| self.safe < LEAST) {
            let left = deadline.saturating_sub(self.clock.now());
            self.safe = left.as_nanos().min(u128::from(u64::MAX)) as u64;
            self.over = self.safe < LEAST;
        }
        (!self.over).then_some(work.min(self.safe))
    }

    /// Takes note of work done.
    pub fn spend(&mut self, work: u64) {
        self.safe = self.safe.saturating_sub(work);
    }

    /// Whether the time is up.
    pub fn is_over(&self) -> bool {
        self.over
    }

    pub fn clock(&self) -> &'c C {
        self.clock
    }
}
