//! Distance queries, stopped on the way: what the model sees, and what came of it.

use punctual::clock::ManualClock;
use punctual::distance::{Bounds, Distance};
use punctual::internals::Closing;
use punctual::{Answer, Budget, PairMemory, Pose, Query, StopReason, Workspace};

use super::cases::Case;
use super::sample::{STOPS, THINNED};

/// Limits that are asked about, relative to the distance; and relative to A's size, where the surfaces meet.
const LIMITS: [f64; 4] = [0.5, 0.9, 1.1, 2.0];
const LIMITS_AT_CONTACT: [f64; 2] = [0.01, 0.1];

/// A distance query at one moment, and its end.
pub struct Moment {
    /// The case it is of, by number.
    pub case: usize,
    /// The share of its own work after which it was stopped; `None` before it began.
    pub stop: Option<f64>,
    pub closing: Closing,
    /// Work of the whole query.
    pub total: f64,
    /// The distance, as the finished query tells it.
    pub distance: f64,
    /// Work of the frame before; `None` if the query had no memory.
    pub last: Option<f64>,
}

/// All poses of a case, without and with limits, at all moments; those of a motion also with a memory.
pub fn moments(number: usize, case: &Case) -> Vec<Moment> {
    let mut sampler = Sampler {
        number,
        case,
        workspace: Workspace::new(),
        moments: Vec::new(),
    };
    let (mut memory, mut last) = (PairMemory::new(), None);
    for (i, &pose) in case.poses.iter().enumerate() {
        if !case.is_motion || i % THINNED == 0 {
            sampler.without_memory(pose);
        }
        if case.is_motion {
            let query = Query::distance(&case.a, &case.b, pose);
            if last.is_some() {
                sampler.sample(&query, last, &memory);
            }
            last = Some(
                run(&query, &mut sampler.workspace, Some(&mut memory), None)
                    .stats
                    .work as f64,
            );
        }
    }
    sampler.moments
}

struct Sampler<'c> {
    number: usize,
    case: &'c Case,
    workspace: Workspace,
    moments: Vec<Moment>,
}

impl Sampler<'_> {
    fn without_memory(&mut self, pose: Pose) {
        let query = Query::distance(&self.case.a, &self.case.b, pose);
        let distance = self.sample(&query, None, &PairMemory::new());
        let limits = LIMITS.map(|share| share * distance);
        let at_contact = LIMITS_AT_CONTACT.map(|share| share * self.case.a.unit_length());
        for &limit in if distance > 0.0 {
            &limits[..]
        } else {
            &at_contact
        } {
            self.sample(&query.closer_than(limit), None, &PairMemory::new());
        }
    }

    /// All moments of a query; what it ends with.
    fn sample(&mut self, query: &Query<Distance>, last: Option<f64>, memory: &PairMemory) -> f64 {
        let memory = || last.map(|_| memory.clone());
        let whole = run(query, &mut self.workspace, memory().as_mut(), None);
        let total = whole.stats.work as f64;
        let moment = |stop, work, low, high| {
            let closing = query.closing(work, [low, high]);
            Moment {
                case: self.number,
                stop,
                closing,
                total,
                distance: whole.value.high,
                last,
            }
        };
        self.moments.push(moment(None, 0, 0.0, f64::INFINITY));
        for share in STOPS {
            let limit = (share * total) as u64;
            let cut = run(query, &mut self.workspace, memory().as_mut(), Some(limit));
            let Bounds { low, high, .. } = cut.value;
            if cut.stop == StopReason::WorkLimit {
                self.moments
                    .push(moment(Some(share), cut.stats.work, low, high));
            }
        }
        whole.value.high
    }
}

fn run(
    query: &Query<Distance>,
    workspace: &mut Workspace,
    memory: Option<&mut PairMemory>,
    limit: Option<u64>,
) -> Answer<Bounds> {
    query.with_memory(memory).run(
        workspace,
        limit
            .map_or(Budget::unlimited(), Budget::work)
            .clock(&ManualClock::new()),
    )
}

impl Moment {
    /// Where the distance lies, 0 at the lower bound and 1 at the upper one; `None` where that is nowhere or everywhere.
    pub fn place(&self) -> Option<f64> {
        let Closing { low, high, .. } = self.closing;
        let is_between = high.is_finite() && high > low;
        is_between.then(|| ((self.distance - low) / (high - low)).clamp(0.0, 1.0))
    }
}
