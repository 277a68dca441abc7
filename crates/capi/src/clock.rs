//! The clock that a budget of time is measured by.

use crate::status::{Fault, given};
use core::ffi::c_void;
use core::time::Duration;
use punctual::{Clock, SystemClock};

/// A clock of the caller's. It is asked during the call that it is passed to, on the same thread. It must not unwind (throw),
/// and not use what that call is using.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_clock {
    /// Nanoseconds since some fixed moment, never less than before. `context` is the one below.
    pub now: Option<unsafe extern "C" fn(context: *mut c_void) -> u64>,
    /// Passed on to `now`.
    pub context: *mut c_void,
}

/// The caller's clock or the system's.
pub(crate) enum AnyClock {
    System(SystemClock),
    Caller { now: unsafe extern "C" fn(context: *mut c_void) -> u64, context: *mut c_void },
}

impl AnyClock {
    /// # Safety
    /// Until this is dropped, the function of the clock may be called with its context on this thread.
    pub unsafe fn new(clock: Option<&punctual_clock>) -> Result<Self, Fault> {
        Ok(match clock {
            None => Self::System(SystemClock::default()),
            Some(clock) => Self::Caller { now: given(clock.now, "clock->now")?, context: clock.context },
        })
    }
}

impl Clock for AnyClock {
    fn now(&self) -> Duration {
        match self {
            Self::System(clock) => clock.now(),
            // SAFETY: the promise made to `new`; the context is a raw pointer, so that this is on the same thread.
            Self::Caller { now, context } => Duration::from_nanos(unsafe { now(*context) }),
        }
    }
}
