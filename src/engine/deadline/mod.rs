//! The stop rule of a call: a limit of time, of work, or both. Queries and scenes share it.
//!
//! Reading the clock costs as much as a hundred units of work. So the time left is converted to the
//! work that cannot exceed the deadline, and the clock is read again only when that work is done. A
//! unit is assumed to take at most [`SLOWEST_UNIT`], or [`SLOWEST_TO_MEAN`] times the mean so far
//! if that is more, as on a slow or a busy machine. The first units are assumed to take
//! [`FIRST_TO_SLOWEST`] times that, because their data may not be in the cache.
//!
//! Under every budget the clock is asked every [`BETWEEN_LOOKS`] units whether the call is
//! cancelled.

pub(crate) mod budget;
pub(crate) mod system;

use crate::engine::outcome::StopReason;
use crate::engine::workspace::Workspace;
use crate::model::cost::{
    FIRST_TO_SLOWEST, LONGEST_STEP, MAX_STEP_WORK, SLOW_TO_MEAN_OF_A_PART, SLOW_UNIT_OF_A_PART,
    SLOWEST_TO_MEAN, SLOWEST_UNIT,
};
pub use budget::{Budget, Clock};
use core::time::Duration;
use punctual_geom::nanoseconds;
use system::ClockedBudget;

/// Maximum work between two readings of the clock: about a millisecond. In a part of a call it is
/// about 10 us, because later steps may be several times as slow as those measured.
const BETWEEN_LOOKS: u64 = 1 << 20;
const BETWEEN_LOOKS_OF_A_PART: u64 = 1 << 13;

/// The end of a call, or of all queries of a frame. The stop rule is [`Deadline::stop`].
///
/// The clock is not a type parameter: the loop would be compiled once for each type, to save a call
/// that costs far less than reading the clock.
pub struct Deadline<'c> {
    clock: &'c dyn Clock,
    started: Option<Duration>,
    end: Option<Duration>,
    /// Work left. Queries leave `reserve` of it for their last step and for the work after them;
    /// `after` is the work after them alone.
    left: u64,
    reserve: u64,
    after: u64,
    /// Work that cannot exceed the end at the slowest assumed pace, and that may be done before the
    /// next reading.
    safe: u64,
    /// The slowest assumed pace, in nanoseconds per unit: the larger of the first number and of the
    /// second times the mean so far.
    slowest: [f64; 2],
    /// The work until the next reading is the safe work divided by `stretch`, and at most
    /// `between_looks`.
    stretch: u64,
    between_looks: u64,
    /// Time of the first reading, and the work since. A later reading before any work takes its
    /// place: the time before is no measure of the pace.
    first_look: Option<Duration>,
    done: u64,
    /// Work of the current query when `left` and `safe` were last updated, and at which the stop
    /// rule reads the clock next.
    at: u64,
    next_look: u64,
    poll_interval: u64,
    /// True if the clock reported a cancellation.
    is_cancelled: bool,
    /// Time of the last reading, and the work done before it.
    last_look: (Duration, u64),
}

impl<'c> Deadline<'c> {
    /// The end of a budget that begins now. Its start counts as the first reading, unless the
    /// budget is so short that it may end before the first step.
    #[inline(always)]
    pub fn of(budget: ClockedBudget<'c>) -> Self {
        let (budget, clock) = budget.parts();
        let started = budget.time.map(|_| clock.now());
        let end = started
            .zip(budget.time)
            .map(|(now, limit)| now.saturating_add(limit));
        let left = budget.work.unwrap_or(u64::MAX);
        let poll_interval = budget.poll_interval.max(1);
        let first = budget.time.map_or(u64::MAX, |limit| {
            (nanoseconds(limit) / SLOWEST_UNIT) as u64 / FIRST_TO_SLOWEST
        });
        let (safe, first_look) = if first < poll_interval {
            (0, None)
        } else {
            (first.min(BETWEEN_LOOKS), started)
        };
        Self {
            started,
            first_look,
            safe,
            poll_interval,
            reserve: 0,
            ..Self::at(end, left, clock)
        }
    }

    /// The end at a time of the clock, if any, and after `work`, including the last step of a
    /// query.
    #[inline]
    pub fn at(end: Option<Duration>, work: u64, clock: &'c dyn Clock) -> Self {
        Self {
            clock,
            started: None,
            end,
            left: work,
            reserve: MAX_STEP_WORK - 1,
            after: 0,
            safe: if end.is_some() { 0 } else { BETWEEN_LOOKS },
            slowest: [SLOWEST_UNIT, SLOWEST_TO_MEAN],
            stretch: 1,
            between_looks: BETWEEN_LOOKS,
            first_look: None,
            done: 0,
            at: 0,
            next_look: 0,
            poll_interval: MAX_STEP_WORK,
            is_cancelled: false,
            last_look: (Duration::ZERO, u64::MAX),
        }
    }

    /// The end of a part of a call, which may be exceeded a little: a reading of the clock may cost
    /// as much as the work it limits. Units of a part are of many kinds, some several times slower
    /// than the mean, so half of the safe work is done between readings.
    #[inline]
    pub fn of_a_part(end: Option<Duration>, work: u64, clock: &'c dyn Clock) -> Self {
        Self {
            slowest: [SLOW_UNIT_OF_A_PART, SLOW_TO_MEAN_OF_A_PART],
            stretch: 2,
            between_looks: BETWEEN_LOOKS_OF_A_PART,
            ..Self::at(end, work, clock)
        }
    }

    /// From here on queries leave room for a last step of `work`.
    #[inline]
    pub fn leave(&mut self, work: u64) {
        self.leave_after(work, 0);
    }

    /// From here on queries leave room for a last step of `work`, and for `after` units after them.
    #[inline]
    pub fn leave_after(&mut self, work: u64, after: u64) {
        (self.reserve, self.after) = (work - 1 + after, after);
    }

    /// Starts or resumes a query that has done `work`.
    pub fn begin(&mut self, work: u64) {
        self.at = work;
        self.next_look = work.saturating_add(self.safe.min(self.left.saturating_sub(self.reserve)));
    }

    /// Returns a reason if the query, having done `work`, must stop. This is the only place where a
    /// budget ends a query.
    #[inline(always)]
    pub fn stop(&mut self, work: u64) -> Option<StopReason> {
        if work < self.next_look {
            None
        } else {
            self.look(work)
        }
    }

    #[cold]
    fn look(&mut self, work: u64) -> Option<StopReason> {
        self.end(work);
        if self.left <= self.reserve {
            return Some(StopReason::WorkLimit);
        }
        let safe = self
            .safe_work()
            .and_then(|safe| safe.checked_sub(self.after));
        let Some(safe) = safe else {
            return Some(self.no_time());
        };
        self.safe = self.until_next_look(safe).max(self.poll_interval);
        self.begin(work);
        None
    }

    /// Ends or interrupts a query that has done `work`.
    pub fn end(&mut self, work: u64) {
        self.spend(work - self.at);
        self.at = work;
    }

    /// Adds work that was done outside of a query.
    #[inline]
    pub fn spend(&mut self, work: u64) {
        self.left = self.left.saturating_sub(work);
        self.safe = self.safe.saturating_sub(work);
        self.done += work;
    }

    /// True if there is room for `work` more, at the slowest assumed pace.
    #[inline]
    pub fn has_room(&mut self, work: u64) -> bool {
        if self.safe < work {
            let safe = self.safe_work().unwrap_or(0);
            self.safe = safe.min(work.max(self.until_next_look(safe)));
        }
        self.left >= work && self.safe >= work
    }

    /// Checks that there is room for a step of at most `most`. The first step of a call may exceed
    /// the budget, unless that is used up, so that each call makes progress.
    ///
    /// # Errors
    /// The reason why the call must stop.
    #[inline]
    pub fn check(&mut self, most: u64) -> Result<(), StopReason> {
        let needed = if self.done == 0 { 1 } else { most };
        if self.has_room(needed) {
            Ok(())
        } else {
            Err(self.why(needed))
        }
    }

    /// Pays for a step of `work` before it is done.
    ///
    /// # Errors
    /// Those of [`Deadline::check`].
    #[inline]
    pub fn pay(&mut self, work: u64) -> Result<(), StopReason> {
        self.check(work)?;
        self.spend(work);
        Ok(())
    }

    /// Does a step of work that the workspace counts, unless the deadline comes before it.
    ///
    /// # Errors
    /// The reason why the call must stop, also if the step itself returns one.
    pub(crate) fn step<T>(
        &mut self,
        workspace: &mut Workspace,
        step: impl FnOnce(&mut Workspace, &mut Self) -> Result<T, StopReason>,
    ) -> Result<T, StopReason> {
        self.begin(workspace.work());
        if let Some(reason) = self.stop(workspace.work()) {
            return Err(reason);
        }
        let done = step(workspace, self);
        self.end(workspace.work());
        done
    }

    /// The reason why there is no room for `work`.
    #[inline]
    pub fn why(&self, work: u64) -> StopReason {
        if self.left < work {
            StopReason::WorkLimit
        } else {
            self.no_time()
        }
    }

    fn no_time(&self) -> StopReason {
        if self.is_cancelled {
            StopReason::Cancelled
        } else {
            StopReason::Deadline
        }
    }

    /// Work that there is room for, at the slowest assumed pace.
    pub fn room(&mut self) -> u64 {
        let safe = self.safe_work().unwrap_or(0);
        self.safe = safe.min(BETWEEN_LOOKS);
        self.left.min(safe)
    }

    /// Prepares for a step that may take some dozen times as long as its work suggests: near the
    /// end, the clock is read after it.
    #[inline]
    pub fn allow_for_long_step(&mut self) {
        if self.is_timed() {
            self.safe = self.safe.saturating_sub(LONGEST_STEP);
            self.next_look = self.next_look.saturating_sub(LONGEST_STEP);
        }
    }

    /// Work done since the start.
    #[inline]
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Work left until the limit of work.
    #[inline]
    pub fn work_left(&self) -> u64 {
        self.left
    }

    /// True if time is limited.
    #[inline]
    pub fn is_timed(&self) -> bool {
        self.end.is_some()
    }

    /// Time since the start; known only under a budget of time. A reading holds until more work is
    /// done.
    #[inline]
    pub fn elapsed(&mut self) -> Option<Duration> {
        let started = self.started?;
        if self.last_look.1 != self.done {
            self.last_look = (self.clock.now(), self.done);
        }
        Some(self.last_look.0.saturating_sub(started))
    }

    /// Work until the next reading of the clock. Before the first units are done, their pace is
    /// unknown.
    fn until_next_look(&self, safe: u64) -> u64 {
        let part = match self.done {
            0 => FIRST_TO_SLOWEST,
            _ => self.stretch,
        };
        (safe / part).min(self.between_looks)
    }

    /// Reads the clock. Returns the work that takes no longer than the time left; `None` if the
    /// time is up, or the call cancelled.
    fn safe_work(&mut self) -> Option<u64> {
        self.is_cancelled = self.clock.is_cancelled();
        if self.is_cancelled {
            return None;
        }
        let Some(end) = self.end else {
            return Some(u64::MAX);
        };
        let now = self.clock.now();
        self.last_look = (now, self.done);
        let first = self.first_look.filter(|_| self.done > 0).unwrap_or(now);
        self.first_look = Some(first);
        let mean = nanoseconds(now.saturating_sub(first)) / self.done.max(1) as f64;
        let left = end.checked_sub(now).filter(|left| !left.is_zero())?;
        let [slowest, to_mean] = self.slowest;
        Some((nanoseconds(left) / slowest.max(to_mean * mean)) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::deadline::budget::{Budget, ManualClock};

    #[test]
    fn slow_units_bring_the_looks_closer_together() {
        let clock = ManualClock::new();
        let budget = Budget::time(Duration::from_micros(100)).poll_interval(1);
        let mut deadline = Deadline::of(budget.clock(&clock));
        deadline.begin(0);
        assert_eq!(deadline.stop(0), None);
        let second = deadline.next_look;
        assert_eq!(
            second, 4_166,
            "100 us at 24 ns a unit, as long as nothing is known"
        );
        clock.advance(Duration::from_micros(1));
        assert_eq!(deadline.stop(second), None);
        let third = deadline.next_look;
        assert_eq!(third - second, 33_000, "99 us at 3 ns a unit");
        clock.advance(Duration::from_micros(50));
        assert_eq!(deadline.stop(third), None);
        let fourth = deadline.next_look;
        assert_eq!(fourth - third, 4_463, "49 us at eight times 1.37 ns a unit");
        clock.advance(Duration::from_micros(49));
        assert_eq!(deadline.stop(fourth), Some(StopReason::Deadline));
    }

    #[test]
    fn after_long_steps_the_clock_is_asked_only_near_the_end() {
        let clock = ManualClock::new();
        let mut deadline = Deadline::of(Budget::time(Duration::from_micros(200)).clock(&clock));
        deadline.begin(0);
        for _ in 0..2 {
            deadline.allow_for_long_step();
            assert!(
                deadline.next_look > 0,
                "8,333 units cannot pass the end, and two long steps are as long as 6,000"
            );
        }
        deadline.allow_for_long_step();
        clock.advance(Duration::from_micros(200));
        assert_eq!(deadline.stop(0), Some(StopReason::Deadline));
    }

    #[test]
    fn a_part_whose_units_become_slower_ends_in_time() {
        for [first, later] in [[0.3, 1.8], [1.6, 1.6], [1.0, 3.5], [4.5, 4.5]] {
            let clock = ManualClock::new();
            let end = Duration::from_micros(75);
            let mut deadline = Deadline::of_a_part(Some(end), u64::MAX, &clock);
            while deadline.has_room(600) {
                let pace = if clock.now() < end / 3 { first } else { later };
                clock.advance(Duration::from_nanos((600.0 * pace) as u64));
                deadline.spend(600);
            }
            let step = Duration::from_nanos((600.0 * later) as u64);
            assert!(
                clock.now() < end + step,
                "{first} and {later} ns a unit: {:?}",
                clock.now()
            );
        }
    }

    #[test]
    fn a_reading_holds_until_more_work_is_done() {
        let clock = ManualClock::ticking(Duration::from_nanos(1));
        let mut deadline = Deadline::of(Budget::time(Duration::from_nanos(9)).clock(&clock));
        assert_eq!(deadline.elapsed(), Some(Duration::from_nanos(1)));
        assert_eq!(deadline.elapsed(), Some(Duration::from_nanos(1)));
        deadline.spend(1);
        assert_eq!(deadline.elapsed(), Some(Duration::from_nanos(2)));
        deadline.begin(0);
        assert_eq!(deadline.stop(500), None);
        assert_eq!(deadline.elapsed(), Some(Duration::from_nanos(3)));
        assert_eq!(clock.now(), Duration::from_nanos(5), "begun at 1");
    }
}
