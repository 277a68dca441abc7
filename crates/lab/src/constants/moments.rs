//! Queries, stopped on the way: what the model sees, and what came of it.

use punctual::clock::{ClockedBudget, ManualClock};
use punctual::distance::Distance;
use punctual::engine::{Ask, Question, Remembers};
use punctual::glam::DVec3;
use punctual::impact::Impact;
use punctual::internals::{self, Batch, Closing, Listing, Passing, Random};
use punctual::rays::{RayBounds, RayMode};
use punctual::tree::Solid;
use punctual::{Answer, Budget, BuildOptions, PairMemory, Query, Ray, StopReason, Tree, Workspace};

use super::cases::Case;

/// Shares of the work of a complete query at which it is stopped.
pub const STOPS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.5];

/// Of the frames of a motion, one in so many is also asked about without a memory.
pub const THINNED: usize = 10;

/// One in so many poses that are no motion is asked about contacts.
const THINNED_POSES: usize = 3;

/// Limits of distances, relative to the distance; and relative to A's size, where the surfaces meet.
const LIMITS: [f64; 4] = [0.5, 0.9, 1.1, 2.0];
const LIMITS_AT_CONTACT: [f64; 2] = [0.01, 0.1];

/// Margins and skins that are asked about, relative to A's size.
const MARGINS: [f64; 2] = [0.0, 0.01];

/// Room for contacts; queries that find more are left out.
const ROOM: usize = 1 << 17;

/// Sizes of batches of rays and points.
const SIZES: [usize; 4] = [1, 1, 16, 200];

/// Solids of more triangles are not asked about, because they take long to build.
const LARGEST_SOLID: usize = 100_000;

/// A query at one moment, and its end.
pub struct Moment<S> {
    /// The case it is of, by number.
    pub case: usize,
    /// The share of its own work after which it was stopped; `None` before it began.
    pub stop: Option<f64>,
    /// What the model sees.
    pub seen: S,
    /// Work by then, and of the whole query.
    pub work: f64,
    pub total: f64,
    /// Work of the query before; `None` without a memory.
    pub last: Option<f64>,
}

impl<S> Moment<S> {
    /// Work that is left, at least 1.
    pub fn left(&self) -> f64 {
        (self.total - self.work).max(1.0)
    }
}

/// What is seen of a distance query, and the distance, as the finished query tells it.
pub struct Approaching {
    pub closing: Closing,
    pub distance: f64,
}

impl Approaching {
    /// Where the distance lies, 0 at the lower bound and 1 at the upper one; `None` where that is nowhere or everywhere.
    pub fn place(&self) -> Option<f64> {
        let Closing { low, high, .. } = self.closing;
        let is_between = high.is_finite() && high > low;
        is_between.then(|| ((self.distance - low) / (high - low)).clamp(0.0, 1.0))
    }
}

/// The moments of all queries but intersections.
#[derive(Default)]
pub struct Moments {
    pub distances: Vec<Moment<Approaching>>,
    pub motions: Vec<Moment<Passing>>,
    pub contacts: Vec<Moment<Listing>>,
    pub manifolds: Vec<Moment<Listing>>,
    pub rays: Vec<Moment<Batch>>,
    pub points: Vec<Moment<Batch>>,
}

impl Moments {
    /// Asks all these questions of a case.
    pub fn add(&mut self, number: usize, case: &Case) {
        let mut asker = Asker {
            number,
            case,
            workspace: Workspace::new(),
            moments: self,
        };
        asker.distances();
        asker.motions();
        asker.workspace.reserve_contacts(ROOM);
        asker.contacts();
        asker.batches();
    }

    pub fn count(&self) -> usize {
        self.distances.len()
            + self.motions.len()
            + self.contacts.len()
            + self.manifolds.len()
            + self.rays.len()
            + self.points.len()
    }
}

struct Asker<'c> {
    number: usize,
    case: &'c Case,
    workspace: Workspace,
    moments: &'c mut Moments,
}

/// What the query before took, and what it left behind.
type Last<'m> = Option<(f64, &'m PairMemory)>;

impl Asker<'_> {
    /// All poses, without and with limits; those of a motion also with a memory.
    fn distances(&mut self) {
        let (mut memory, mut last) = (PairMemory::new(), None);
        for (i, &pose) in self.case.poses.iter().enumerate() {
            let query = Query::distance(&self.case.a, &self.case.b, pose);
            if !self.case.is_motion || i % THINNED == 0 {
                let distance = self.distance(&query, None);
                let limits = LIMITS.map(|share| share * distance);
                let at_contact = LIMITS_AT_CONTACT.map(|share| share * self.case.a.unit_length());
                for &limit in if distance > 0.0 {
                    &limits[..]
                } else {
                    &at_contact
                } {
                    self.distance(&query.closer_than(limit), None);
                }
            }
            if self.case.is_motion {
                if let Some(last) = last {
                    self.distance(&query, Some((last, &memory)));
                }
                last = Some(whole(&query, &mut self.workspace, &mut memory));
            }
        }
    }

    /// The moments of a query; the distance.
    fn distance(&mut self, query: &Query<Distance>, last: Last) -> f64 {
        let closing = |work, bounds| Approaching {
            closing: internals::closing(query, work, bounds),
            distance: 0.0,
        };
        let before = closing(0, [0.0, f64::INFINITY]);
        let (said, mut moments) = moments(self.number, last, Some(before), |memory, budget| {
            let said = query.with_memory(memory).run(&mut self.workspace, budget);
            (
                said,
                closing(said.stats.work, [said.value.low, said.value.high]),
            )
        });
        for moment in &mut moments {
            moment.seen.distance = said.value.high;
        }
        self.moments.distances.extend(moments);
        said.value.high
    }

    /// All motions that begin free; those from frame to frame also with a memory.
    fn motions(&mut self) {
        let (mut memory, mut last) = (PairMemory::new(), None);
        for (i, &motion) in self.case.motions.iter().enumerate() {
            let query = Query::impact(&self.case.a, &self.case.b, motion);
            if !self.case.is_motion || i % THINNED == 0 {
                self.motion(&query, None);
            }
            if self.case.is_motion {
                if let Some(last) = last {
                    self.motion(&query, Some((last, &memory)));
                }
                last = Some(whole(&query, &mut self.workspace, &mut memory));
            }
        }
    }

    fn motion(&mut self, query: &Query<Impact>, last: Last) {
        let before = internals::passing(query, 0, 0.0, None);
        let (said, moments) = moments(self.number, last, Some(before), |memory, budget| {
            let said = query.with_memory(memory).run(&mut self.workspace, budget);
            let seen =
                internals::passing(query, said.stats.work, said.value.lower, said.value.upper);
            (said, seen)
        });
        if said.value.upper != Some(0.0) {
            self.moments.motions.extend(moments);
        }
    }

    /// Contacts and manifolds of some poses, with all margins.
    fn contacts(&mut self) {
        let Case { a, b, .. } = self.case;
        let thinned = if self.case.is_motion {
            THINNED
        } else {
            THINNED_POSES
        };
        for &pose in self.case.poses.iter().step_by(thinned) {
            for margin in MARGINS.map(|share| share * a.unit_length()) {
                let contacts = self.listing(&Query::contacts(a, b, pose).margin(margin));
                self.moments.contacts.extend(contacts);
                let manifolds = self.listing(&Query::manifolds(a, b, pose).skin(margin));
                self.moments.manifolds.extend(manifolds);
            }
        }
    }

    fn listing<'t, Q: Question>(&mut self, query: &Query<'t, Q>) -> Vec<Moment<Listing>>
    where
        Query<'t, Q>: Ask<Q>,
    {
        let run = |_: Option<&mut PairMemory>, budget: ClockedBudget| {
            let said = query.run(&mut self.workspace, budget);
            (said, internals::listing(query, &self.workspace))
        };
        moments(self.number, None, None, run).1
    }

    /// Rays and points about the first mesh, alone and in batches.
    fn batches(&mut self) {
        let Case { a, .. } = self.case;
        let (mut random, bounds) = (Random::new(self.number as u64 + 1), a.mesh().aabb());
        let mut point = || {
            let at = DVec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
            bounds.center() + at * 0.6 * bounds.extents()
        };
        for size in SIZES {
            // From outside to a point in the box.
            let ray = |_| {
                let (from, to) = (bounds.center() + 4.0 * (point() - bounds.center()), point());
                Ray::new(from.to_array(), (to - from).to_array()).ok()
            };
            let rays: Vec<Ray> = (0..size).filter_map(ray).collect();
            if let [ray] = rays[..] {
                for mode in [RayMode::Nearest, RayMode::All] {
                    let query = Query::ray(a, ray).mode(mode);
                    let moments = self.batch(&query, 1, mode == RayMode::All);
                    self.moments.rays.extend(moments);
                }
            } else {
                let moments = self.batch(&Query::rays(a, &rays), rays.len(), false);
                self.moments.rays.extend(moments);
            }
        }
        if a.mesh().len() > LARGEST_SOLID {
            return;
        }
        let options = BuildOptions::default().solid(Solid::Keep);
        let solid = Tree::with_options(a.mesh().clone(), &options);
        for size in SIZES {
            let points: Vec<[f64; 3]> = (0..size).map(|_| point().to_array()).collect();
            if let Ok(query) = Query::windings(&solid, &points) {
                let moments = self.batch(&query, size, false);
                self.moments.points.extend(moments);
            }
            if let Ok(query) = Query::signed_distances(&solid, &points) {
                let moments = self.batch(&query, size, true);
                self.moments.points.extend(moments);
            }
        }
    }

    fn batch<'t, Q: Question>(
        &mut self,
        query: &Query<'t, Q>,
        size: usize,
        is_thorough: bool,
    ) -> Vec<Moment<Batch>>
    where
        Query<'t, Q>: Ask<Q>,
        Q::Value: Done,
    {
        let triangles = self.case.a.mesh().len() as f64;
        let run = |_: Option<&mut PairMemory>, budget: ClockedBudget| {
            let said = query.run(&mut self.workspace, budget);
            let done = said.value.done();
            let batch = Batch {
                triangles,
                done: done as f64,
                left: (size - done) as f64,
                work: said.stats.work as f64,
                is_thorough,
            };
            (said, batch)
        };
        moments(self.number, None, None, run).1
    }
}

/// Runs a query to its end, and from the start to each stop. `run` answers within a budget, and tells
/// what the model sees then; `before` is what it sees of a query that has not begun, if not the same.
fn moments<V, S>(
    case: usize,
    last: Last,
    before: Option<S>,
    mut run: impl FnMut(Option<&mut PairMemory>, ClockedBudget) -> (Answer<V>, S),
) -> (Answer<V>, Vec<Moment<S>>) {
    let clock = ManualClock::new();
    let mut run = |budget: Budget| {
        let mut memory = last.map(|(_, memory)| memory.clone());
        run(memory.as_mut(), budget.clock(&clock))
    };
    let (whole, _) = run(Budget::unlimited());
    let total = whole.stats.work as f64;
    let moment = |stop, seen, work| Moment {
        case,
        stop,
        seen,
        work,
        total,
        last: last.map(|(work, _)| work),
    };
    let mut moments = Vec::new();
    if !whole.stop.is_final() {
        return (whole, moments);
    }
    let first = before.is_none().then_some(0.0);
    moments.extend(before.map(|seen| moment(None, seen, 0.0)));
    for share in first.into_iter().chain(STOPS) {
        let (said, seen) = run(Budget::work((share * total) as u64));
        if said.stop == StopReason::WorkLimit {
            let stop = (share > 0.0).then_some(share);
            moments.push(moment(stop, seen, said.stats.work as f64));
        }
    }
    (whole, moments)
}

/// Work of a query that learns from the one before, without a stop.
fn whole<'t, Q: Remembers>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    memory: &mut PairMemory,
) -> f64
where
    Query<'t, Q>: Ask<Q>,
{
    let clock = ManualClock::new();
    let budget = Budget::unlimited().clock(&clock);
    query.with_memory(memory).run(workspace, budget).stats.work as f64
}

/// How many of a batch are done.
trait Done {
    fn done(&self) -> usize;
}

impl Done for usize {
    fn done(&self) -> usize {
        *self
    }
}

impl Done for RayBounds {
    fn done(&self) -> usize {
        0
    }
}
