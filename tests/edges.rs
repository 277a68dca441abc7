//! What all queries promise alike, at the edges: the least and the largest budgets, the first call, clones, one workspace for
//! all, numbers that are none.

#[path = "common/allocations.rs"]
mod allocations;

use std::time::Duration;

use allocations::allocator_calls;
use punctual::clock::ManualClock;
use punctual::contacts::{ContactBounds, Contacts};
use punctual::distance::{Bounds, Distance};
use punctual::glam::{DMat3, DVec3};
use punctual::impact::{Impact, TimeOfImpact};
use punctual::intersection::Intersection;
use punctual::prediction::{MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK};
use punctual::rays::{RayBounds, RayCast, RayMode};
use punctual::{
    Answer, Budget, Mesh, Mode, Motion, Pose, Query, Ray, ResumeError, StopReason, Tree, Verdict,
    Workspace, shapes,
};

/// Two trees, and where they are.
struct Place {
    trees: [Tree; 2],
    pose: Pose,
    motion: Motion,
    rays: [Ray; RAYS],
}

const RAYS: usize = 20;

impl Place {
    fn new(trees: [Tree; 2], translation: DVec3) -> Self {
        let pose = Pose::new(DMat3::from_rotation_y(0.4), translation).unwrap();
        let motion = Motion::turning(pose, [-0.5, 0.1, 0.2], [0.1, 0.2, 0.3], [0.0; 3]).unwrap();
        let rays = std::array::from_fn(|i| {
            Ray::new([-3.0, 0.1 * i as f64 - 1.0, 0.1], [1.0, 0.0, 0.05]).unwrap()
        });
        Self {
            trees,
            pose,
            motion,
            rays,
        }
    }

    /// Surfaces that meet, that are close, that are too far apart for `f64`, and none.
    fn all() -> [Self; 4] {
        let knot = || Tree::new(shapes::torus_knot(2, 3, 0.2, 32));
        let ball = || Tree::new(shapes::icosphere(2));
        let nothing = Tree::new(Mesh::new([] as [[f32; 3]; 0], [] as [[u32; 3]; 0]).unwrap());
        [
            Self::new([knot(), ball()], DVec3::new(0.8, 0.5, 0.1)),
            Self::new([knot(), ball()], DVec3::new(2.25, 0.5, 0.1)),
            Self::new([ball(), knot()], DVec3::splat(1e15)),
            Self::new([nothing, knot()], DVec3::ZERO),
        ]
    }

    fn query(&self, mode: Mode) -> Query<'_, Intersection> {
        Query::intersection(&self.trees[0], &self.trees[1], self.pose).mode(mode)
    }

    fn distance(&self) -> Query<'_, Distance> {
        Query::distance(&self.trees[0], &self.trees[1], self.pose)
    }

    fn contacts(&self) -> Query<'_, Contacts> {
        Query::contacts(&self.trees[0], &self.trees[1], self.pose).margin(0.05)
    }

    fn sweep(&self) -> Query<'_, Impact> {
        Query::impact(&self.trees[0], &self.trees[1], self.motion)
    }

    fn ray(&self, mode: RayMode) -> Query<'_, RayCast> {
        Query::ray(&self.trees[0], self.rays[9]).mode(mode)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Asked {
    Any,
    All,
    Touching,
    Distance,
    Closer,
    Contacts,
    Motion,
    NearestHit,
    AllHits,
    Batch,
}

const QUESTIONS: [Asked; 10] = [
    Asked::Any,
    Asked::All,
    Asked::Touching,
    Asked::Distance,
    Asked::Closer,
    Asked::Contacts,
    Asked::Motion,
    Asked::NearestHit,
    Asked::AllHits,
    Asked::Batch,
];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Said {
    Outcome(Answer<Verdict>),
    Distance(Answer<Bounds>),
    Contacts(Answer<ContactBounds>),
    Passage(Answer<TimeOfImpact>),
    Cast(Answer<RayBounds>),
    Batch(Answer<usize>),
}

impl Said {
    /// Why it ended, and after which work.
    fn end(&self) -> (StopReason, u64) {
        match self {
            Self::Outcome(said) => (said.stop, said.stats.work),
            Self::Distance(said) => (said.stop, said.stats.work),
            Self::Contacts(said) => (said.stop, said.stats.work),
            Self::Passage(said) => (said.stop, said.stats.work),
            Self::Cast(said) => (said.stop, said.stats.work),
            Self::Batch(said) => (said.stop, said.stats.work),
        }
    }

    fn is_whole(&self) -> bool {
        matches!(self.end().0, StopReason::Finished | StopReason::FirstHit)
    }
}

/// A workspace and a clock.
#[derive(Clone)]
struct Room {
    workspace: Workspace,
    clock: ManualClock,
}

impl Room {
    fn new() -> Self {
        Self {
            workspace: Workspace::new(),
            clock: ManualClock::new(),
        }
    }

    fn run(&mut self, asked: Asked, place: &Place, budget: Budget) -> Said {
        self.ask(asked, place, budget, false)
            .expect("a run is never refused")
    }

    fn resume(&mut self, asked: Asked, place: &Place, budget: Budget) -> Result<Said, ResumeError> {
        self.ask(asked, place, budget, true)
    }

    fn ask(
        &mut self,
        asked: Asked,
        place: &Place,
        budget: Budget,
        resume: bool,
    ) -> Result<Said, ResumeError> {
        let Self { workspace, clock } = self;
        macro_rules! ask {
            ($query:expr) => {{
                let (query, budget) = ($query, budget.clock(clock));
                if resume {
                    query.resume(workspace, budget)?
                } else {
                    query.run(workspace, budget)
                }
            }};
        }
        Ok(match asked {
            Asked::Any => Said::Outcome(ask!(place.query(Mode::Any))),
            Asked::All => Said::Outcome(ask!(place.query(Mode::All))),
            Asked::Distance => Said::Distance(ask!(place.distance())),
            Asked::Closer => Said::Distance(ask!(place.distance().closer_than(0.3))),
            Asked::Touching => Said::Contacts(ask!(place.contacts().margin(0.0))),
            Asked::Contacts => Said::Contacts(ask!(place.contacts())),
            Asked::Motion => Said::Passage(ask!(place.sweep())),
            Asked::NearestHit => Said::Cast(ask!(place.ray(RayMode::Nearest))),
            Asked::AllHits => Said::Cast(ask!(place.ray(RayMode::All))),
            Asked::Batch => Said::Batch(ask!(Query::rays(&place.trees[0], &place.rays))),
        })
    }

    /// What the last query found, in words.
    fn found(&self) -> String {
        let contacts: Vec<_> = self.workspace.contacts().collect();
        format!(
            "{:?} {contacts:?} {:?} {:?}",
            self.workspace.pairs(),
            self.workspace.ray_hits(),
            self.workspace.first_hits()
        )
    }
}

const ENOUGH: Budget = Budget::work(u64::MAX);

#[test]
fn a_budget_of_work_is_passed_by_at_most_a_step() {
    for (number, place) in Place::all().iter().enumerate() {
        for asked in QUESTIONS {
            let step = match asked {
                Asked::Distance | Asked::Closer | Asked::Contacts | Asked::Motion => {
                    MAX_DISTANCE_STEP_WORK
                }
                _ => MAX_STEP_WORK,
            };
            let mut room = Room::new();
            for work in (0..40).chain((40..4_000).step_by(37)) {
                let (stop, done) = room.run(asked, place, Budget::work(work)).end();
                assert!(
                    done < work + step,
                    "place {number}, {asked:?}: {done} for {work}"
                );
                assert!(
                    work > 0 || done == 0,
                    "place {number}, {asked:?}: {done} for nothing, {stop:?}"
                );
            }
        }
    }
}

#[test]
fn the_largest_budgets_end_like_none_however_late_the_clock() {
    let late = Duration::MAX - Duration::from_secs(20);
    for place in &Place::all() {
        for asked in QUESTIONS {
            let whole = Room::new().run(asked, place, Budget::work(u64::MAX - 1));
            assert!(whole.is_whole(), "{asked:?}: {whole:?}");
            for poll_interval in [0, 1, u64::MAX] {
                let mut room = Room::new();
                assert_eq!(
                    room.run(asked, place, ENOUGH.poll_interval(poll_interval)),
                    whole,
                    "{asked:?}"
                );
                for (by, limit) in [
                    (Duration::ZERO, Duration::MAX),
                    (late, Duration::MAX),
                    (late, late / 2),
                ] {
                    room.clock = ManualClock::new();
                    room.clock.advance(by);
                    let said = room.run(
                        asked,
                        place,
                        Budget::time(limit).poll_interval(poll_interval),
                    );
                    assert_eq!(
                        said.end().0,
                        whole.end().0,
                        "{asked:?}, {limit:?} at {by:?}, every {poll_interval}"
                    );
                }
            }
        }
    }
}

#[test]
fn without_time_no_more_than_a_step_is_done_and_the_query_goes_on_later() {
    for place in &Place::all() {
        for asked in QUESTIONS {
            for clock in [
                ManualClock::new(),
                ManualClock::ticking(Duration::from_secs(1)),
            ] {
                let mut room = Room {
                    clock,
                    ..Room::new()
                };
                let (stop, work) = room.run(asked, place, Budget::time(Duration::ZERO)).end();
                assert!(work < MAX_DISTANCE_STEP_WORK, "{asked:?}: {work}, {stop:?}");
                if stop == StopReason::Deadline {
                    let said = room
                        .resume(asked, place, ENOUGH)
                        .expect("stopped by the clock");
                    assert!(said.is_whole(), "{asked:?}: {said:?}");
                }
            }
        }
    }
}

/// Room for contacts, all hits of a ray and batches of rays is made by the first query for them, and by no other call.
#[test]
fn not_even_the_first_call_allocates_but_for_contacts_all_hits_and_batches() {
    let budgets = [
        Budget::work(0),
        Budget::work(500),
        Budget::time(Duration::from_secs(9)),
        Budget::unlimited(),
    ];
    for place in &Place::all() {
        for asked in QUESTIONS {
            for budget in budgets {
                let mut room = Room::new();
                let makes_room = matches!(
                    asked,
                    Asked::Touching | Asked::Contacts | Asked::AllHits | Asked::Batch
                );
                let first = allocator_calls(|| _ = room.run(asked, place, budget));
                assert!(first == 0 || makes_room, "{asked:?}: {first} calls");
                assert_eq!(
                    allocator_calls(|| _ = room.run(asked, place, budget)),
                    0,
                    "{asked:?}"
                );
                let mut room = Room::new();
                room.workspace.reserve_contacts(100);
                room.workspace.reserve_ray_hits(100);
                assert_eq!(
                    allocator_calls(|| _ = room.run(asked, place, budget)),
                    0,
                    "{asked:?}"
                );
            }
        }
    }
}

#[test]
fn a_used_workspace_gives_the_same_bits_as_a_fresh_one() {
    let places = Place::all();
    let mut used = Room::new();
    for round in 0..3 {
        for (number, place) in places.iter().enumerate() {
            for (index, asked) in QUESTIONS.into_iter().enumerate() {
                // Stopped in the first rounds, so that each begins with what another has left.
                let budget = Budget::work(if round == 2 {
                    u64::MAX
                } else {
                    300 + 700 * index as u64
                });
                let mut fresh = Room { ..Room::new() };
                let said = used.run(asked, place, budget);
                assert_eq!(
                    said,
                    fresh.run(asked, place, budget),
                    "place {number}, {asked:?}"
                );
                assert_eq!(used.found(), fresh.found(), "place {number}, {asked:?}");
            }
        }
    }
}

#[test]
fn a_clone_of_any_stopped_run_goes_on_like_its_original() {
    for place in &Place::all() {
        for asked in QUESTIONS {
            for budget in [0, 900, 5_000] {
                let mut room = Room::new();
                let (stop, _) = room.run(asked, place, Budget::work(budget)).end();
                let mut clone = room.clone();
                assert_eq!(clone.found(), room.found());
                let [said, again] =
                    [&mut room, &mut clone].map(|room| room.resume(asked, place, ENOUGH));
                assert_eq!(said, again, "{asked:?}");
                assert_eq!(
                    said.is_ok(),
                    stop == StopReason::WorkLimit,
                    "{asked:?}, {stop:?}"
                );
                assert_eq!(clone.found(), room.found(), "{asked:?}");
            }
        }
    }
}

#[test]
fn before_the_first_query_a_workspace_holds_nothing() {
    for place in &Place::all() {
        let mut room = Room::new();
        assert!(
            QUESTIONS
                .iter()
                .all(|&asked| room.resume(asked, place, Budget::unlimited()) == Err(ResumeError))
        );
        let workspace = &mut room.workspace;
        assert!(place.query(Mode::All).certificate(workspace).is_err());
        assert!(place.query(Mode::All).estimate(workspace, None).is_err());
        assert!(place.distance().certificate(workspace).is_err());
        assert!(place.distance().estimate(workspace, None).is_err());
        assert!(place.contacts().certificate(workspace).is_err());
        assert!(place.sweep().certificate(workspace).is_err());
        assert!(workspace.pairs().is_empty() && workspace.ray_hits().is_empty());
        assert_eq!(workspace.contacts().len(), 0);
        assert_eq!(workspace.drain_pairs().count(), 0);
        assert_eq!(workspace.drain_contacts().len(), 0);
        assert_eq!(workspace.drain_ray_hits().len(), 0);
    }
}

/// A query with NaN equals itself, and so can be resumed.
#[test]
fn a_number_that_is_none_counts_as_one() {
    let place = &Place::all()[1];
    let (workspace, clock) = (&mut Workspace::new(), &ManualClock::new());
    let distance = place.distance();
    for query in [
        distance.absolute_tolerance(f64::NAN),
        distance.relative_tolerance(f64::NAN),
        distance.closer_than(f64::NAN),
        distance.margins([f64::NAN, 0.1]),
    ] {
        assert_eq!(
            query.run(workspace, Budget::work(500).clock(clock)).stop,
            StopReason::WorkLimit
        );
        let said = query
            .resume(workspace, Budget::unlimited().clock(clock))
            .expect("the same query");
        assert!(
            said.stop == StopReason::Finished && said.value.low <= said.value.high,
            "{said:?}"
        );
    }
    let sweep = place.sweep();
    for query in [
        sweep.tolerance(f64::NAN),
        sweep.time_tolerance(f64::NAN),
        sweep.margins([f64::NAN, 0.1]),
    ] {
        assert_eq!(
            query.run(workspace, Budget::work(500).clock(clock)).stop,
            StopReason::WorkLimit
        );
        assert!(query.certificate(workspace).is_ok());
        let said = query
            .resume(workspace, Budget::unlimited().clock(clock))
            .expect("the same query");
        assert!(
            said.stop == StopReason::Finished
                && said.value.lower <= said.value.upper.unwrap_or(1.0),
            "{said:?}"
        );
    }
    let query = place.contacts().margin(f64::NAN);
    assert_eq!(
        query.run(workspace, Budget::work(500).clock(clock)).stop,
        StopReason::WorkLimit
    );
    assert_eq!(
        query
            .resume(workspace, Budget::unlimited().clock(clock))
            .unwrap()
            .stop,
        StopReason::Finished
    );
    let mut told = |query: Query<Intersection>| {
        let _ = query.run(workspace, Budget::work(500).clock(clock));
        query.estimate(workspace, None).unwrap()
    };
    let query = place.query(Mode::All);
    assert_eq!(told(query.prior(f64::NAN)), told(query));
}
