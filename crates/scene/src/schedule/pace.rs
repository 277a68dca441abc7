//! How long parts of a frame take: constants, and what earlier frames took.

use crate::cost::WORK_PER_LISTED_PAIR;
use core::time::Duration;
use punctual::engine::TYPICAL_UNIT;
use punctual_geom::nanoseconds;

// Times that are small beside the queries are not measured on each machine: nanoseconds per unit of
// work of the list, per task assigned to a batch, per task collected, and per task whose findings
// about groups are read.
const LISTING: u64 = 1;
const ASSIGNING: u64 = 50;
const COLLECTING: u64 = 25;
const READING: u64 = 400;

/// Time beyond this many times the usual is attributed to other programs.
const MOST: f64 = 4.0;

/// Added to a number of tasks, because a step takes time even without any.
const NEVER_NONE: usize = 16;

/// Speed of the queries of a thread: exponentially fading sums.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Speed {
    work: f64,
    nanos: f64,
}

impl Default for Speed {
    /// A guess that soon fades.
    fn default() -> Self {
        Self {
            work: 1e5,
            nanos: 1e5 * TYPICAL_UNIT,
        }
    }
}

impl Speed {
    pub fn learn(&mut self, work: f64, nanos: f64) {
        self.work = 0.9 * self.work + work;
        self.nanos = 0.9 * self.nanos + nanos.min(MOST * TYPICAL_UNIT * work);
    }

    pub fn work_per_nano(&self) -> f64 {
        self.work / self.nanos
    }
}

/// Time to collect this many tasks.
pub(crate) fn collecting(tasks: usize) -> Duration {
    Duration::from_nanos(COLLECTING * (tasks + NEVER_NONE) as u64)
}

/// Time to read the findings of this many tasks about groups.
pub(crate) fn reading(tasks: usize) -> Duration {
    Duration::from_nanos(READING * tasks as u64)
}

/// Work of a list of as many pairs as can be listed, assigned and collected in `time`.
pub(crate) fn list_work(time: Duration) -> u64 {
    let each = LISTING as f64 + (ASSIGNING + COLLECTING) as f64 / WORK_PER_LISTED_PAIR as f64;
    (nanoseconds(time) / each) as u64
}

/// Work that a query could do while a task is assigned and collected.
pub(crate) const OVERHEAD: u64 = ((ASSIGNING + COLLECTING) as f64 / TYPICAL_UNIT) as u64;

/// Nanoseconds reserved for a time that varies: they rise at once and fall slowly.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reserved(f64);

impl Reserved {
    /// `most`: time beyond it is attributed to other programs.
    pub fn learn(&mut self, took: Duration, most: f64) {
        let took = nanoseconds(took).min(most);
        self.0 = took.max((15.0 * self.0 + took) / 16.0);
    }

    pub fn time(&self) -> Duration {
        Duration::from_nanos(self.0 as u64)
    }
}
