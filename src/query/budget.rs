//! What a query may spend, and who tells the time.

use super::system::SYSTEM;
use crate::model::cost::MAX_STEP_WORK;
use core::cell::Cell;
use core::fmt;
use core::time::Duration;

/// What one call may spend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default = "Budget::unlimited", deny_unknown_fields)
)]
#[must_use]
pub struct Budget {
    pub(crate) time: Option<Duration>,
    pub(crate) work: Option<u64>,
    pub(super) poll_interval: u64,
}

impl Budget {
    /// As much as it takes. Since nothing can cut the query short, the default order goes plainly
    /// depth-first, which costs least; every order finds the same in the end.
    pub const fn unlimited() -> Self {
        Self {
            time: None,
            work: None,
            poll_interval: MAX_STEP_WORK,
        }
    }

    /// Stop within this time from the start of the call.
    ///
    /// Calls that are handed no clock go by the system's. Where it has none, without `std` and on
    /// `wasm32-unknown-unknown`, they take the time as over at once
    /// ([`StopReason::Deadline`](crate::StopReason::Deadline)) and do nothing: hand them a
    /// [`Clock`], or give them a budget of work.
    pub const fn time(limit: Duration) -> Self {
        Self {
            time: Some(limit),
            ..Self::unlimited()
        }
    }

    /// Stop after this much work: BV tests, plus [`WORK_PER_EXPANSION`](crate::WORK_PER_EXPANSION),
    /// [`WORK_PER_EDGE_TEST`](crate::WORK_PER_EDGE_TEST),
    /// [`WORK_PER_TRIANGLE_TEST`](crate::WORK_PER_TRIANGLE_TEST) and
    /// [`WORK_PER_EXACT_TEST`](crate::WORK_PER_EXACT_TEST). Where it stops depends on the input
    /// alone: the same bits on every machine, in every run.
    ///
    /// The step at hand is finished, so up to [`MAX_STEP_WORK`](crate::MAX_STEP_WORK) units more
    /// are spent (by a query of distance, contacts or motion,
    /// [`MAX_DISTANCE_STEP_WORK`](crate::MAX_DISTANCE_STEP_WORK)); a budget of 0 does nothing.
    pub const fn work(limit: u64) -> Self {
        Self {
            work: Some(limit),
            ..Self::unlimited()
        }
    }

    /// With another least work between looks at the clock, which come closer together towards the
    /// deadline; default [`MAX_STEP_WORK`](crate::MAX_STEP_WORK). It bounds how late a budget of
    /// time can end. A frame of a scene goes by the default.
    pub const fn poll_interval(self, work: u64) -> Self {
        Self {
            poll_interval: work,
            ..self
        }
    }

    /// The same budget by a clock of the caller's, instead of the system's.
    pub const fn clock(self, clock: &dyn Clock) -> ClockedBudget<'_> {
        ClockedBudget {
            budget: self,
            clock: Some(clock),
        }
    }

    /// Whether nothing can end the call early.
    pub(crate) fn is_unlimited(self) -> bool {
        self.time.is_none() && self.work.is_none()
    }
}

/// Tells the time. The engine never asks the operating system itself.
pub trait Clock {
    /// Time since some fixed moment; never less than the call before.
    fn now(&self) -> Duration;

    /// True if calls by this clock have to end now, whatever their budget: a user has cancelled
    /// them. They end as at a deadline, with
    /// [`StopReason::Cancelled`](crate::StopReason::Cancelled). Asked about once a millisecond.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// A budget and the clock that measures its time ([`Budget::clock`]). Calls take one wherever they
/// take a [`Budget`], which goes by the clock of the system.
#[derive(Clone, Copy)]
#[must_use]
pub struct ClockedBudget<'c> {
    pub(crate) budget: Budget,
    /// `None`: the system's.
    pub(crate) clock: Option<&'c dyn Clock>,
}

impl<'c> ClockedBudget<'c> {
    pub(crate) fn parts(self) -> (Budget, &'c dyn Clock) {
        match self.clock {
            Some(clock) => (self.budget, clock),
            None => (self.budget.by_system(), &SYSTEM),
        }
    }
}

impl From<Budget> for ClockedBudget<'static> {
    fn from(budget: Budget) -> Self {
        Self {
            budget,
            clock: None,
        }
    }
}

impl fmt::Debug for ClockedBudget<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("ClockedBudget").field(&self.budget).finish()
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
        Self {
            now: Cell::default(),
            step,
        }
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
