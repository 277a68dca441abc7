//! The question and budget of a frame.

use crate::body::Bodies;
use crate::id::PairKey;
use crate::schedule::executor::Executor;
use alloc::sync::Arc;
use core::time::Duration;
use punctual::{Budget, Clock, Mode};

/// Minimum time of a frame with estimates for stopped queries, the part of the frame reserved for
/// estimates, and its maximum per thread.
const ESTIMATES: Duration = Duration::from_millis(1);
const ESTIMATES_PART: u32 = 32;
const ESTIMATES_MOST: Duration = Duration::from_micros(50);

/// The guaranteed share of the round robin is the budget divided by this.
pub(crate) const GUARANTEED: u64 = 8;

/// A frame: its mode, bodies and budget.
pub(crate) struct Frame<'f> {
    pub number: u64,
    pub mode: Mode,
    /// The frame in which this mode was first set. Results of earlier frames answer another
    /// question.
    pub asked_since: u64,
    /// The frames without a change so far: the one that began their list, and the last of them.
    pub rest: [u64; 2],
    /// True if the last report was not whole; true if a body's box was outdated when this frame
    /// began.
    pub cut: bool,
    pub moved: bool,
    /// True if nothing has changed since the last frame, and all bodies are placed and paired.
    pub is_still: bool,
    pub budget: Budget,
    /// For a budget of time, its start and length. Otherwise two zeros, because the compiler
    /// computes with them before it is known whether they are needed.
    pub times: [Duration; 2],
    pub clock: &'f dyn Clock,
    pub bodies: &'f Arc<Bodies>,
    pub executor: &'f dyn Executor,
}

impl Frame<'_> {
    pub fn threads(&self) -> usize {
        self.executor.threads()
    }

    pub fn is_timed(&self) -> bool {
        self.budget.time_limit().is_some()
    }

    /// The end of the budget, minus `rest`, which is reserved for the rest of the frame.
    pub fn end(&self, rest: Duration) -> Option<Duration> {
        let [start, limit] = self.times;
        self.is_timed()
            .then(|| start.saturating_add(limit).saturating_sub(rest))
    }

    /// The time since the last lap, which ends now. `None` without a budget of time.
    pub fn lap(&self, last: &mut Option<Duration>) -> Option<Duration> {
        let now = self.is_timed().then(|| self.clock.now());
        let since = now.map(|now| now.saturating_sub(last.unwrap_or(self.times[0])));
        *last = now;
        since
    }

    /// Time reserved for the estimates of stopped queries; `None` if there are none.
    pub fn for_estimates(&self) -> Option<Duration> {
        let limit = self.budget.time_limit().unwrap_or(Duration::MAX);
        (limit >= ESTIMATES)
            .then(|| (limit / ESTIMATES_PART).min(ESTIMATES_MOST * self.threads() as u32))
    }

    /// The last frame for which the decision of a pair holds that the frame `decided` made: the end
    /// of the rest, if it was made during the rest.
    pub fn decided(&self, decided: u64) -> u64 {
        let [first, last] = self.rest;
        match (first..last).contains(&decided) {
            true => last,
            false => decided,
        }
    }

    /// The last frame in which something about a pair changed.
    pub fn changed(&self, key: PairKey) -> u64 {
        self.bodies.last_change(key).max(self.asked_since)
    }
}
