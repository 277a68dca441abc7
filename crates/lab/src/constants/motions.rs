//! Motion queries, stopped on the way: what the model sees, and what came of it.

use punctual::clock::ManualClock;
use punctual::impact::{Impact, TimeOfImpact};
use punctual::internals::Passing;
use punctual::{Answer, Budget, Motion, PairMemory, Pose, Query, StopReason, Workspace};

use super::cases::Case;
use super::sample::{STOPS, THINNED};

/// A motion query at one moment, and its end.
pub struct Moment {
    /// The case it is of, by number.
    pub case: usize,
    /// The share of its own work after which it was stopped; `None` before it began.
    pub stop: Option<f64>,
    pub passing: Passing,
    /// Work of the whole query.
    pub total: f64,
    /// Work of the motion before; `None` if the query had no memory.
    pub last: Option<f64>,
}

/// All motions of a case that begin free, at all moments; those from frame to frame also with a memory.
pub fn moments(number: usize, case: &Case) -> Vec<Moment> {
    let mut sampler = Sampler {
        number,
        workspace: Workspace::new(),
        moments: Vec::new(),
    };
    let (mut memory, mut last) = (PairMemory::new(), None);
    for (i, &motion) in case.motions.iter().enumerate() {
        let query = Query::impact(&case.a, &case.b, motion);
        if !case.is_motion || i % THINNED == 0 {
            sampler.sample(&query, None, &memory);
        }
        if case.is_motion {
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

/// The motions from pose to pose: screws from frame to frame, otherwise every second one without turn.
pub fn between(poses: &[Pose], are_frames: bool) -> Vec<Motion> {
    let motion = |(i, ends): (usize, &[Pose])| {
        let way = ends[1].translation() - ends[0].translation();
        if are_frames || i % 2 == 0 {
            Motion::screw(ends[0], ends[1])
        } else {
            Motion::straight(ends[0], way)
        }
    };
    poses
        .windows(2)
        .enumerate()
        .filter_map(|motion_of| motion(motion_of).ok())
        .collect()
}

struct Sampler {
    number: usize,
    workspace: Workspace,
    moments: Vec<Moment>,
}

impl Sampler {
    /// All moments of a query, unless the surfaces meet at its start.
    fn sample(&mut self, query: &Query<Impact>, last: Option<f64>, memory: &PairMemory) {
        let memory = || last.map(|_| memory.clone());
        let whole = run(query, &mut self.workspace, memory().as_mut(), None);
        if whole.value.upper == Some(0.0) {
            return;
        }
        let total = whole.stats.work as f64;
        let moment = |stop, passing| Moment {
            case: self.number,
            stop,
            passing,
            total,
            last,
        };
        self.moments.push(moment(None, query.passing(0, 0.0, None)));
        for share in STOPS {
            let said = run(
                query,
                &mut self.workspace,
                memory().as_mut(),
                Some((share * total) as u64),
            );
            if said.stop == StopReason::WorkLimit {
                let passing = query.passing(said.stats.work, said.value.lower, said.value.upper);
                self.moments.push(moment(Some(share), passing));
            }
        }
    }
}

fn run(
    query: &Query<Impact>,
    workspace: &mut Workspace,
    memory: Option<&mut PairMemory>,
    limit: Option<u64>,
) -> Answer<TimeOfImpact> {
    query.with_memory(memory).run(
        workspace,
        limit
            .map_or(Budget::unlimited(), Budget::work)
            .clock(&ManualClock::new()),
    )
}
