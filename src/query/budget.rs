//! What a query may spend, and who tells the time.

use super::outcome::StopReason;
use core::cell::Cell;
use core::time::Duration;

/// Work of opening one node pair, besides its BV tests.
///
/// One unit of work is the time that one more BV test adds to an opened pair, about 0.3 ns. The weights were fitted so that
/// work is proportional to time within about 20 % (`docs/performance.md`), and are part of what a work budget means.
pub const WORK_PER_EXPANSION: u64 = 84;

/// Work of one triangle test in the fast filter.
pub const WORK_PER_TRIANGLE_TEST: u64 = 44;

/// Work of one exact triangle test, on average.
pub const WORK_PER_EXACT_TEST: u64 = 200;

/// The most work that is done between two looks at the budget: a batch of eight triangle tests.
pub const MAX_STEP_WORK: u64 = 8 * WORK_PER_TRIANGLE_TEST;

const _: () = assert!(MAX_STEP_WORK >= WORK_PER_EXPANSION + 65 && MAX_STEP_WORK >= WORK_PER_EXACT_TEST);

/// What one call may spend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default = "Budget::unlimited", deny_unknown_fields))]
#[must_use]
pub struct Budget {
    pub(super) time: Option<Duration>,
    pub(super) work: Option<u64>,
}

impl Budget {
    /// As much as it takes. Since nothing can cut the query short, the default order goes plainly depth-first, which costs
    /// least; every order finds the same in the end.
    pub const fn unlimited() -> Self {
        Self { time: None, work: None }
    }

    /// Stop within this time from the start of the call.
    pub const fn time(limit: Duration) -> Self {
        Self { time: Some(limit), work: None }
    }

    /// Stop after this much work: BV tests, plus [`WORK_PER_EXPANSION`], [`WORK_PER_TRIANGLE_TEST`] and
    /// [`WORK_PER_EXACT_TEST`]. Where it stops depends on the input alone: the same bits on every machine, in every run.
    ///
    /// The step at hand is finished, so up to [`MAX_STEP_WORK`] units more are spent; a budget of 0 does nothing.
    pub const fn work(limit: u64) -> Self {
        Self { time: None, work: Some(limit) }
    }

    pub(crate) const fn time_limit(self) -> Option<Duration> {
        self.time
    }

    pub(crate) const fn work_limit(self) -> Option<u64> {
        self.work
    }
}

/// Tells the time. The engine never asks the operating system itself.
pub trait Clock {
    /// Time since some fixed moment; never less than the call before.
    fn now(&self) -> Duration;
}

/// The monotonic clock of the operating system, about 25 ns a look.
#[cfg(feature = "std")]
#[derive(Clone, Copy, Debug)]
pub struct SystemClock(std::time::Instant);

#[cfg(feature = "std")]
impl Default for SystemClock {
    fn default() -> Self {
        Self(std::time::Instant::now())
    }
}

#[cfg(feature = "std")]
impl Clock for SystemClock {
    fn now(&self) -> Duration {
        self.0.elapsed()
    }
}

/// A clock that is moved by hand, for tests.
#[derive(Clone, Debug, Default)]
pub struct ManualClock {
    now: Cell<Duration>,
    step: Duration,
}

impl ManualClock {
    /// Stands still until it is advanced.
    pub fn new() -> Self {
        Self::default()
    }

    /// Advances by `step` at every look.
    pub fn ticking(step: Duration) -> Self {
        Self { now: Cell::default(), step }
    }

    /// Moves on by `time`.
    pub fn advance(&self, time: Duration) {
        self.now.set(self.now.get().saturating_add(time));
    }
}

impl Clock for ManualClock {
    fn now(&self) -> Duration {
        self.advance(self.step);
        self.now.get()
    }
}

/// Upper bound on the time of a unit of work, as far as a machine allows one: eight times what was measured in cache. With
/// 1 ns, large trees out of cache were 5 us late in one call of a hundred.
const SLOWEST: Duration = Duration::from_nanos(3);

/// Watches a budget during one call. The stop rule is [`Meter::stop`].
pub(super) struct Meter<'c, C> {
    clock: &'c C,
    started: Option<Duration>,
    deadline: Option<Duration>,
    work_limit: u64,
    /// Work at which to look again.
    next_look: u64,
    poll_interval: u64,
}

impl<'c, C: Clock> Meter<'c, C> {
    /// Starts a call at which `work` has been done already.
    pub fn start(budget: Budget, poll_interval: u64, clock: &'c C, work: u64) -> Self {
        let started = budget.time.map(|_| clock.now());
        let deadline = started.zip(budget.time).map(|(now, limit)| now.saturating_add(limit));
        let work_limit = budget.work.map_or(u64::MAX, |limit| work.saturating_add(limit));
        let next_look = if deadline.is_some() { work } else { work_limit };
        Self { clock, started, deadline, work_limit, next_look, poll_interval: poll_interval.max(1) }
    }

    /// Whether the call has to stop, having done `work`: the only place where a budget ends a query.
    #[inline(always)]
    pub fn stop(&mut self, work: u64) -> Option<StopReason> {
        if work < self.next_look { None } else { self.look(work) }
    }

    #[cold]
    fn look(&mut self, work: u64) -> Option<StopReason> {
        if work >= self.work_limit {
            return Some(StopReason::WorkLimit);
        }
        let left = self.deadline?.saturating_sub(self.clock.now());
        if left.is_zero() {
            return Some(StopReason::Deadline);
        }
        // A unit of work takes less than SLOWEST, so the deadline cannot pass unseen; far from it, looks are rare.
        let safe = (left.as_nanos() / SLOWEST.as_nanos()).min(u128::from(u64::MAX)) as u64;
        self.next_look = work.saturating_add(safe.max(self.poll_interval)).min(self.work_limit);
        None
    }

    /// Looks at the clock before the next step, however far the deadline.
    pub fn look_next(&mut self) {
        if self.deadline.is_some() {
            self.next_look = 0;
        }
    }

    /// Time since the start of the call; known only under a time budget.
    pub fn elapsed(&self) -> Option<Duration> {
        self.started.map(|started| self.clock.now().saturating_sub(started))
    }
}
