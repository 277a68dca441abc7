//! What a frame asks.

use super::state::PairState;
use crate::query::{Budget, Clock, Mode};
use crate::scene::body::Bodies;
use crate::scene::id::PairKey;
use crate::scene::schedule::crew::Crew;
use alloc::sync::Arc;
use core::time::Duration;

/// The least time of a frame that affords estimates of its stopped queries, the part of it that is
/// kept for them, and the most of that for each thread.
const ESTIMATES: Duration = Duration::from_millis(1);
const ESTIMATES_PART: u32 = 32;
const ESTIMATES_MOST: Duration = Duration::from_micros(50);

/// The guaranteed share of the round robin is this part of the budget.
pub(crate) const GUARANTEED: u64 = 8;

/// A frame: what is asked, of which bodies, within which budget.
pub(crate) struct Frame<'f> {
    pub number: u64,
    pub mode: Mode,
    /// The frame in which this mode was first asked for; what older ones found is of another
    /// question.
    pub asked_since: u64,
    /// The last frame that found all, and the last of those after it in which nothing had changed.
    pub rest: [u64; 2],
    /// Whether the report of the last frame was not whole, and whether the box of a body was out of
    /// date when this one began.
    pub cut: bool,
    pub moved: bool,
    pub budget: Budget,
    /// For a budget of time, when it began and how long it is: two zeros otherwise, since the
    /// compiler computes with them before it is known whether they are asked for.
    pub times: [Duration; 2],
    pub clock: &'f dyn Clock,
    pub bodies: &'f Arc<Bodies>,
    pub crew: &'f dyn Crew,
}

impl Frame<'_> {
    pub fn threads(&self) -> usize {
        self.crew.threads()
    }

    /// Whether its budget is one of time.
    pub fn is_timed(&self) -> bool {
        self.budget.time.is_some()
    }

    /// When the budget ends, less what has to be kept for the rest of the frame.
    pub fn end(&self, rest: Duration) -> Option<Duration> {
        let [start, limit] = self.times;
        self.is_timed()
            .then(|| start.saturating_add(limit).saturating_sub(rest))
    }

    /// The time since the last lap, which ends here; under a budget of time.
    pub fn lap(&self, last: &mut Option<Duration>) -> Option<Duration> {
        let now = self.is_timed().then(|| self.clock.now());
        let since = now.map(|now| now.saturating_sub(last.unwrap_or(self.times[0])));
        *last = now;
        since
    }

    /// Time that is kept for asking stopped queries how sure they are; none if they are not asked.
    pub fn for_estimates(&self) -> Option<Duration> {
        let limit = self.budget.time.unwrap_or(Duration::MAX);
        (limit >= ESTIMATES)
            .then(|| (limit / ESTIMATES_PART).min(ESTIMATES_MOST * self.threads() as u32))
    }

    /// Whether the contacts of bodies that were last new in `changed` are known as well as this
    /// frame can tell.
    pub fn knows_contacts(&self, state: &PairState, changed: u64) -> bool {
        let left_out = state.touch.as_ref().map_or(0, |touch| touch.left_out);
        let work = self.budget.work.unwrap_or(u64::MAX);
        let time = self
            .budget
            .time
            .map_or(u64::MAX, |time| time.as_nanos() as u64);
        state.knows_contacts(changed) && (left_out == 0 || left_out > work.min(time) / GUARANTEED)
    }

    /// The last frame in which a pair was decided; those of a rest count, though nothing was looked
    /// at.
    pub fn decided(&self, state: &PairState) -> u64 {
        let [found_all, last] = self.rest;
        if state.decided == found_all {
            last
        } else {
            state.decided
        }
    }

    /// The last frame in which something about a pair was new.
    pub fn changed(&self, key: PairKey) -> u64 {
        self.bodies.last_change(key).max(self.asked_since)
    }
}
