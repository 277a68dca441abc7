//! Measured speeds of the frames of a scene on this machine, for sharing the rest of a frame.

use crate::cost::{WORK_PER_FOUND_PAIR, WORK_PER_LISTED_PAIR};
use core::time::Duration;
use punctual::engine::TYPICAL_UNIT;
use punctual_geom::nanoseconds;

/// Initial values: nanoseconds per unit of work of the list, per job dealt to a batch, and per job
/// collected.
const LISTING: f64 = 1.0;
const DEALING: f64 = 50.0;
const COLLECTING: f64 = 25.0;

/// Maximum time that counts for a list after its deadline, nanoseconds.
const MOST_CLOSING: f64 = 10_000.0;

/// Time beyond this many times the usual is attributed to other programs.
const MOST: f64 = 4.0;

/// Added to a number of jobs or units before a time is divided by it, because a step takes time
/// even without any.
const NEVER_NONE: f64 = 16.0;

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

/// Nanoseconds reserved for a time that varies: they rise at once and fall slowly.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reserved(f64);

impl Reserved {
    /// `most`: time beyond it is attributed to other programs.
    pub fn learn(&mut self, nanos: f64, most: f64) {
        let took = nanos.min(most);
        self.0 = took.max((15.0 * self.0 + took) / 16.0);
    }

    pub fn times(&self, count: f64) -> Duration {
        Duration::from_nanos((self.0 * count) as u64)
    }
}

/// Overhead of the pairs in a frame besides their queries, nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overhead {
    /// Exponentially weighted means.
    listing: f64,
    dealing: f64,
    collecting: Reserved,
    /// Time of a list after its deadline.
    closing: Reserved,
}

impl Default for Overhead {
    fn default() -> Self {
        Self {
            listing: LISTING,
            dealing: DEALING,
            collecting: Reserved(COLLECTING),
            closing: Reserved(0.0),
        }
    }
}

impl Overhead {
    pub fn learn_list(&mut self, took: Duration, work: u64) {
        let each = nanoseconds(took) / (work as f64 + NEVER_NONE);
        self.listing += (each.min(MOST * LISTING) - self.listing) / 16.0;
    }

    /// Records the time from the deadline of a list to its end; zero if it ended before.
    pub fn learn_closing(&mut self, took: Duration) {
        self.closing.learn(nanoseconds(took), MOST_CLOSING);
    }

    /// Expected maximum time of a list after its deadline.
    pub fn closing(&self) -> Duration {
        self.closing.times(1.0)
    }

    /// Records the times in which the jobs of a round were dealt and collected.
    pub fn learn_round(&mut self, [dealing, collecting]: [Duration; 2], jobs: usize) {
        let each = |took: Duration| nanoseconds(took) / (jobs as f64 + NEVER_NONE);
        self.dealing += (each(dealing).min(MOST * DEALING) - self.dealing) / 16.0;
        self.collecting.learn(each(collecting), MOST * COLLECTING);
    }

    /// Time to list this many pairs.
    pub fn listing(&self, pairs: usize) -> Duration {
        Duration::from_nanos((self.listing * (pairs as u64 * WORK_PER_FOUND_PAIR) as f64) as u64)
    }

    /// Overhead of a job, from the list to the report, nanoseconds.
    pub fn of_a_job(&self) -> f64 {
        self.dealing + self.collecting.0
    }

    /// Time to collect this many jobs.
    pub fn collecting(&self, jobs: usize) -> Duration {
        self.collecting.times(jobs as f64 + NEVER_NONE)
    }

    /// Work of a list of as many pairs as can be listed, dealt and collected in `time`.
    pub fn list_work(&self, time: Duration) -> u64 {
        let after = self.of_a_job() / WORK_PER_LISTED_PAIR as f64;
        (nanoseconds(time) / (self.listing + after)) as u64
    }
}
