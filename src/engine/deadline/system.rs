//! The clock of calls without one of their own.
//!
//! If the system has no clock, a budget of time ends at once, because the time left is unknown.
//! This is so without `std`, and on `wasm32-unknown-unknown`, whose `std` panics when asked for the
//! time.

use super::budget::{Budget, Clock};
use core::fmt;
use core::time::Duration;

/// The monotonic clock of the operating system; a reading takes about 25 ns. All system clocks of a
/// program count from the first reading of any. Not available without `std`, nor on
/// `wasm32-unknown-unknown`: there it stands still.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct SystemClock;

impl Clock for SystemClock {
    #[cfg(all(
        feature = "std",
        not(all(target_family = "wasm", target_os = "unknown"))
    ))]
    fn now(&self) -> Duration {
        static FIRST_LOOK: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
        FIRST_LOOK.get_or_init(std::time::Instant::now).elapsed()
    }

    #[cfg(not(all(
        feature = "std",
        not(all(target_family = "wasm", target_os = "unknown"))
    )))]
    fn now(&self) -> Duration {
        Duration::ZERO
    }
}

/// The clock of calls without one of their own, and whether it runs.
pub const SYSTEM: SystemClock = SystemClock;
const GOES: bool = cfg!(all(
    feature = "std",
    not(all(target_family = "wasm", target_os = "unknown"))
));

impl Budget {
    /// The same limits, measured by `clock` instead of the system clock.
    pub const fn clock(self, clock: &dyn Clock) -> ClockedBudget<'_> {
        ClockedBudget {
            budget: self,
            clock: Some(clock),
        }
    }
}

/// A budget and the clock that measures its time ([`Budget::clock`]). Calls accept it in place of a
/// [`Budget`], which uses the system clock.
#[derive(Clone, Copy)]
#[must_use]
pub struct ClockedBudget<'c> {
    budget: Budget,
    /// `None` selects the system clock.
    clock: Option<&'c dyn Clock>,
}

impl<'c> ClockedBudget<'c> {
    /// True if the system clock measures the time.
    #[inline]
    pub fn is_by_system(&self) -> bool {
        self.clock.is_none()
    }

    /// The limits, and the clock that measures them.
    #[inline]
    pub fn parts(self) -> (Budget, &'c dyn Clock) {
        let Self { mut budget, clock } = self;
        if clock.is_none() && !GOES {
            budget.time = budget.time.map(|_| Duration::ZERO);
        }
        (budget, clock.unwrap_or(&SYSTEM))
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
