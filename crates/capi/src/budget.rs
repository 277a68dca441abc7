//! Budgets, and the clock that those of time are measured by.

use crate::status::{Fault, given, value_of};
use crate::verbs::types;
use core::ffi::c_void;
use core::time::Duration;
use punctual::clock::ClockedBudget;
use punctual::prediction::{MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK};
use punctual::{Budget, Clock};

/// The most work of an intersection query between two looks at a work budget, which can be overrun
/// by no more; the default poll interval.
pub const PUNCTUAL_MAX_STEP_WORK: u64 = 352;

/// What PUNCTUAL_MAX_STEP_WORK is for intersection queries, for those of distances, contacts,
/// manifolds and motions.
pub const PUNCTUAL_MAX_DISTANCE_STEP_WORK: u64 = 1040;

const _: () = assert!(PUNCTUAL_MAX_STEP_WORK == MAX_STEP_WORK);
const _: () = assert!(PUNCTUAL_MAX_DISTANCE_STEP_WORK == MAX_DISTANCE_STEP_WORK);

types! {
    /// What `limit` of a budget limits.
    enum punctual_budget_kind {
        /// Nothing.
        Unlimited = 0,
        /// Time from the start of the call, in nanoseconds.
        Time = 1,
        /// Units of work: where it stops depends on the input alone.
        Work = 2,
    }

    /// What one call may spend. Made by `punctual_budget_unlimited`, `punctual_budget_time` and
    /// `punctual_budget_work`.
    plain punctual_budget {
        /// Nanoseconds or units of work.
        limit: u64,
        /// A `punctual_budget_kind`.
        kind: u32,
        /// Least work between looks at the clock, which bounds how late a time budget can end;
        /// PUNCTUAL_MAX_STEP_WORK by default. A frame of a scene goes by the default.
        poll_interval: u64,
    }
}

/// A clock of the caller's. It is asked during the call that it is passed to, on the same
/// thread. It must not unwind (throw), and not use what that call is using.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_clock {
    /// Nanoseconds since some fixed moment, never less than before. `context` is the one below.
    pub now: Option<unsafe extern "C" fn(context: *mut c_void) -> u64>,
    /// Passed on to `now`.
    pub context: *mut c_void,
}

/// As much as it takes.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_budget_unlimited() -> punctual_budget {
    punctual_budget {
        limit: 0,
        kind: punctual_budget_kind::Unlimited as u32,
        poll_interval: MAX_STEP_WORK,
    }
}

/// Stop within this time from the start of the call.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_budget_time(nanoseconds: u64) -> punctual_budget {
    punctual_budget {
        limit: nanoseconds,
        kind: punctual_budget_kind::Time as u32,
        ..punctual_budget_unlimited()
    }
}

/// Stop after this much work, at most PUNCTUAL_MAX_STEP_WORK later (distance queries:
/// PUNCTUAL_MAX_DISTANCE_STEP_WORK): the same bits on every machine, in every run.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_budget_work(units: u64) -> punctual_budget {
    punctual_budget {
        limit: units,
        kind: punctual_budget_kind::Work as u32,
        ..punctual_budget_unlimited()
    }
}

/// A clock of the caller's.
struct Theirs {
    now: unsafe extern "C" fn(context: *mut c_void) -> u64,
    context: *mut c_void,
}

impl Clock for Theirs {
    fn now(&self) -> Duration {
        // SAFETY: the promise made to `spend`; the context is a raw pointer, so that this is on
        // the same thread.
        Duration::from_nanos(unsafe { (self.now)(self.context) })
    }
}

impl punctual_budget {
    /// Spends the budget by the caller's clock, or without one by the system's.
    ///
    /// # Safety
    /// Until it returns, the function of the clock may be called with its context on this thread.
    pub(crate) unsafe fn spend<R>(
        self,
        clock: Option<&punctual_clock>,
        spend: impl FnOnce(ClockedBudget<'_>) -> Result<R, Fault>,
    ) -> Result<R, Fault> {
        let budget = self.check()?;
        let Some(clock) = clock else {
            return spend(budget.into());
        };
        let (now, context) = (given(clock.now, "clock->now")?, clock.context);
        spend(budget.clock(&Theirs { now, context }))
    }

    fn check(self) -> Result<Budget, Fault> {
        let time = Budget::time(Duration::from_nanos(self.limit));
        let all = [Budget::unlimited(), time, Budget::work(self.limit)];
        let budget = value_of(self.kind, "budget.kind", &all)?;
        Ok(budget.poll_interval(self.poll_interval))
    }
}
