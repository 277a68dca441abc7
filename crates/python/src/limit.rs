//! What a call may spend, and whether it keeps the interpreter's lock.

use crate::errors::value_error;
use crate::interrupt::{BETWEEN_LOOKS, cancellable};
use core::time::Duration;
use punctual::clock::SystemClock;
use punctual::{Budget, Clock, Stats};
use pyo3::prelude::*;

/// The budget of a call: seconds, units of work, or neither.
#[derive(Clone, Copy)]
pub enum Limit {
    None,
    Time(Duration),
    Work(u64),
}

impl Limit {
    pub fn new(budget: Option<f64>, work: Option<u64>) -> PyResult<Self> {
        match (budget, work) {
            (None, None) => Ok(Self::None),
            (None, Some(work)) => Ok(Self::Work(work)),
            (Some(_), Some(_)) => Err(value_error(
                "budget and work: only one of them can be given",
            )),
            (Some(f64::INFINITY), None) => Ok(Self::None),
            (Some(seconds), None) => match Duration::try_from_secs_f64(seconds) {
                Ok(time) => Ok(Self::Time(time)),
                Err(_) => Err(value_error(format_args!(
                    "budget is {seconds}, expected seconds, not negative"
                ))),
            },
        }
    }

    pub fn budget(self) -> Budget {
        match self {
            Self::None => Budget::unlimited(),
            Self::Time(time) => Budget::time(time),
            Self::Work(work) => Budget::work(work),
        }
    }

    /// What is left of it, if `before` and `now` are the sums of the run before the call and now.
    pub fn left(self, before: &Stats, now: &Stats) -> Self {
        match self {
            Self::None => Self::None,
            Self::Work(work) => Self::Work(work.saturating_sub(now.work - before.work)),
            Self::Time(time) => {
                let sum = |stats: &Stats| stats.elapsed.unwrap_or_default();
                Self::Time(time.saturating_sub(sum(now).saturating_sub(sum(before))))
            }
        }
    }

    /// Runs a call by a clock. Without the interpreter's lock, unless the time is short: to get the lock back from
    /// another thread
    /// may take as long. Raises what the user cancels the call with.
    pub fn run<R: Send>(
        self,
        py: Python<'_>,
        run: impl FnOnce(&dyn Clock) -> R + Send,
    ) -> PyResult<R> {
        match self {
            Self::Time(time) if time < BETWEEN_LOOKS => Ok(run(&SystemClock::default())),
            Self::None | Self::Work(_) | Self::Time(_) => cancellable(py, run),
        }
    }
}
