//! Budgets, and the clock that those of time are measured by.

use crate::status::{Fault, given, value_of};
use core::ffi::c_void;
use core::time::Duration;
use punctual::clock::SystemClock;
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

/// What `limit` of a budget limits.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum punctual_budget_kind {
    /// Nothing.
    Unlimited = 0,
    /// Time from the start of the call, in nanoseconds.
    Time = 1,
    /// Units of work: where it stops depends on the input alone.
    Work = 2,
}

/// What one call may spend. Made by `punctual_budget_unlimited`, `punctual_budget_time` and
/// `punctual_budget_work`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct punctual_budget {
    /// Nanoseconds or units of work.
    pub limit: u64,
    /// A `punctual_budget_kind`.
    pub kind: u32,
    /// Least work between looks at the clock, which bounds how late a time budget can end;
    /// PUNCTUAL_MAX_STEP_WORK by default. A frame of a scene goes by the default.
    pub poll_interval: u64,
}

/// A clock of the caller's. It is asked during the call that it is passed to, on the same thread.
/// It must not unwind (throw), and not use what that call is using.
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

/// The caller's clock or the system's.
pub(crate) enum AnyClock {
    System(SystemClock),
    Caller {
        now: unsafe extern "C" fn(context: *mut c_void) -> u64,
        context: *mut c_void,
    },
}

impl AnyClock {
    /// # Safety
    /// Until this is dropped, the function of the clock may be called with its context on this
    /// thread.
    pub unsafe fn new(clock: Option<&punctual_clock>) -> Result<Self, Fault> {
        Ok(match clock {
            None => Self::System(SystemClock::default()),
            Some(clock) => Self::Caller {
                now: given(clock.now, "clock->now")?,
                context: clock.context,
            },
        })
    }
}

impl Clock for AnyClock {
    fn now(&self) -> Duration {
        match self {
            Self::System(clock) => clock.now(),
            // SAFETY: the promise made to `new`; the context is a raw pointer, so that this is on
            // the same thread.
            Self::Caller { now, context } => Duration::from_nanos(unsafe { now(*context) }),
        }
    }
}

impl punctual_budget {
    pub(crate) fn check(self) -> Result<Budget, Fault> {
        let time = Budget::time(Duration::from_nanos(self.limit));
        let budget = value_of(
            self.kind,
            "budget.kind",
            &[Budget::unlimited(), time, Budget::work(self.limit)],
        )?;
        Ok(budget.poll_interval(self.poll_interval))
    }
}
