//! Budgets, and the clocks that measure them.

use crate::model::cost::MAX_STEP_WORK;
use core::cell::Cell;
use core::time::Duration;

/// The limits of one call.
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
    pub(crate) poll_interval: u64,
}

impl Budget {
    /// No limit. Since nothing can cut the query short, the default order runs plainly depth-first,
    /// which costs least. The finished answer does not depend on the order.
    #[inline]
    pub const fn unlimited() -> Self {
        Self {
            time: None,
            work: None,
            poll_interval: MAX_STEP_WORK,
        }
    }

    /// Stops within this time from the start of the call.
    ///
    /// Without [`Budget::clock`] the system clock measures the time. If the system has none,
    /// without `std` and on `wasm32-unknown-unknown`, the call ends at once with
    /// [`StopReason::Deadline`](crate::StopReason::Deadline) and does nothing. Give the budget a
    /// [`Clock`], or use a budget of work.
    #[inline]
    pub const fn time(limit: Duration) -> Self {
        Self {
            time: Some(limit),
            ..Self::unlimited()
        }
    }

    /// Stops after this much work. The unit is a BV test of an intersection query. Expansions,
    /// tests on edge axes, triangle tests and exact tests count
    /// [`WORK_PER_EXPANSION`](crate::prediction::WORK_PER_EXPANSION),
    /// [`WORK_PER_EDGE_TEST`](crate::prediction::WORK_PER_EDGE_TEST),
    /// [`WORK_PER_TRIANGLE_TEST`](crate::prediction::WORK_PER_TRIANGLE_TEST) and
    /// [`WORK_PER_EXACT_TEST`](crate::prediction::WORK_PER_EXACT_TEST). The place where it stops
    /// depends on the input alone: the same bits on every machine, in every run.
    ///
    /// The current step is finished, so the query may exceed the limit by up to
    /// [`MAX_STEP_WORK`](crate::prediction::MAX_STEP_WORK) units (queries of distances, signed ones
    /// too, contacts, manifolds or motions by up to
    /// [`MAX_DISTANCE_STEP_WORK`](crate::prediction::MAX_DISTANCE_STEP_WORK)). A budget of 0 does
    /// nothing.
    #[inline]
    pub const fn work(limit: u64) -> Self {
        Self {
            work: Some(limit),
            ..Self::unlimited()
        }
    }

    /// Sets the least work between two readings of the clock; readings become more frequent towards
    /// the deadline. Default [`MAX_STEP_WORK`](crate::prediction::MAX_STEP_WORK). It bounds how
    /// late a budget of time can end. A frame of a scene uses the default.
    pub const fn poll_interval(self, work: u64) -> Self {
        Self {
            poll_interval: work,
            ..self
        }
    }

    /// The limit of time, if there is one.
    #[inline]
    pub const fn time_limit(&self) -> Option<Duration> {
        self.time
    }

    /// The limit of work, if there is one.
    #[inline]
    pub const fn work_limit(&self) -> Option<u64> {
        self.work
    }

    /// True if nothing can end the call early.
    #[inline]
    pub fn is_unlimited(self) -> bool {
        self.time.is_none() && self.work.is_none()
    }
}

/// Measures time. The engine never asks the operating system itself.
pub trait Clock {
    /// Time since a fixed moment. It must not decrease from call to call.
    fn now(&self) -> Duration;

    /// True if calls with this clock must end now, whatever their budget, because a user has
    /// cancelled them. They end as at a deadline, with
    /// [`StopReason::Cancelled`](crate::StopReason::Cancelled). Called about once a millisecond.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// A clock set by hand, for tests.
#[derive(Clone, Debug, Default)]
pub struct ManualClock {
    now: Cell<Duration>,
    step: Duration,
}

impl ManualClock {
    /// Starts at 0 and stands still until it is advanced.
    pub fn new() -> Self {
        Self::default()
    }

    /// Advances by `step` at every reading.
    pub fn ticking(step: Duration) -> Self {
        Self {
            now: Cell::default(),
            step,
        }
    }

    /// Advances by `time`.
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
