//! What all queries promise alike, at the edges: the least and the largest budgets, the first call, clones, one workspace for
//! all, numbers that are none.

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use std::sync::Arc;
use std::time::Duration;

use allocations::allocator_calls;
use common::ask::ENOUGH;
use common::meshes::{ball, knot, nothing, placed, solid};
use common::steps::assert_step;
use punctual::clock::ManualClock;
use punctual::contacts::{ContactBounds, Contacts};
use punctual::contacts::{ManifoldBounds, Manifolds};
use punctual::distance::{Bounds, Distance};
use punctual::engine::{Ask, Question};
use punctual::glam::{DMat3, DVec3};
use punctual::impact::{Impact, TimeOfImpact};
use punctual::intersection::Intersection;
use punctual::points::PointBounds;
use punctual::prediction::{CostModel, MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK};
use punctual::rays::{RayBounds, RayCast, RayMode};
use punctual::{
    Answer, Budget, Mesh, Mode, Motion, Pose, Query, Ray, ResumeError, StopReason, Tree, Verdict,
    Workspace, shapes,
};
use punctual_depenetrate::{MAX_PENETRATION_STEP_WORK, PenetrationQuery, PenetrationWorkspace};
use punctual_scene::{Body, Scene};

/// Two trees, and where they are.
struct Place {
    trees: [Tree; 2],
    pose: Pose,
    motion: Motion,
    rays: [Ray; RAYS],
    points: [[f64; 3]; POINTS],
}

const RAYS: usize = 20;
const POINTS: usize = 4;

impl Place {
    fn new(trees: [Tree; 2], translation: DVec3) -> Self {
        let pose = placed(DMat3::from_rotation_y(0.4), translation);
        let motion = Motion::turning(pose, [-0.5, 0.1, 0.2], [0.1, 0.2, 0.3], [0.0; 3]).unwrap();
        let rays = std::array::from_fn(|i| {
            Ray::new([-3.0, 0.1 * i as f64 - 1.0, 0.1], [1.0, 0.0, 0.05]).unwrap()
        });
        // On the surface, inside of most meshes, and far away.
        let corner = match trees[0].mesh() {
            mesh if mesh.is_empty() => [0.5; 3],
            mesh => mesh.triangle(mesh.len() - 1)[0].to_array(),
        };
        Self {
            trees,
            pose,
            motion,
            rays,
            points: [corner, [0.1, 0.2, 0.05], [30.0, 0.0, 0.0], [0.9, 0.3, 0.1]],
        }
    }

    /// A hull around a small one, two that meet, a solid that is open, and a large one.
    fn solids() -> [Self; 4] {
        let cube = |size: f32| solid(shapes::cuboid([size; 3], 1));
        let ball = |detail| solid(shapes::icosphere(detail));
        let whole = shapes::icosphere(2);
        let vertices = (0..whole.vertex_count()).map(|i| whole.vertex(i).to_array());
        let triangles = whole.triangles()[..whole.len() / 2].iter().copied();
        let half = solid(Mesh::from_f64(vertices, triangles).unwrap());
        [
            Self::new([cube(1.0), cube(0.2)], DVec3::new(0.1, 0.3, 0.2)),
            Self::new([ball(2), cube(0.7)], DVec3::new(1.3, 0.4, 0.2)),
            Self::new([half, ball(1)], DVec3::new(0.9, 0.2, 1.3)),
            Self::new([ball(3), ball(2)], DVec3::new(2.1, 0.1, 0.2)),
        ]
    }

    /// Surfaces that meet, that are close, that are too far apart for `f64`, and none.
    fn all() -> [Self; 4] {
        let (knot, ball) = (knot(0.2, 32), ball(2));
        let two = [knot.clone(), ball.clone()];
        [
            Self::new(two.clone(), DVec3::new(0.8, 0.5, 0.1)),
            Self::new(two, DVec3::new(2.25, 0.5, 0.1)),
            Self::new([ball, knot.clone()], DVec3::splat(1e15)),
            Self::new([nothing(), knot], DVec3::ZERO),
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

    fn manifolds(&self) -> Query<'_, Manifolds> {
        Query::manifolds(&self.trees[0], &self.trees[1], self.pose).skin(0.05)
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
    Manifolds,
    Motion,
    NearestHit,
    AnyHit,
    AllHits,
    HitFromInside,
    Batch,
    /// About points of solids, with the number of the point.
    Winding(usize),
    SignedDistance(usize),
    Windings,
    SignedDistances,
}

const OF_SURFACES: [Asked; 12] = [
    Asked::Any,
    Asked::All,
    Asked::Touching,
    Asked::Distance,
    Asked::Closer,
    Asked::Contacts,
    Asked::Manifolds,
    Asked::Motion,
    Asked::NearestHit,
    Asked::AnyHit,
    Asked::AllHits,
    Asked::Batch,
];

const OF_SOLIDS: [Asked; 2 * POINTS + 3] = [
    Asked::HitFromInside,
    Asked::Winding(0),
    Asked::Winding(1),
    Asked::Winding(2),
    Asked::Winding(3),
    Asked::SignedDistance(0),
    Asked::SignedDistance(1),
    Asked::SignedDistance(2),
    Asked::SignedDistance(3),
    Asked::Windings,
    Asked::SignedDistances,
];

impl Asked {
    /// All that can be asked about a place.
    fn of(place: &Place) -> impl Iterator<Item = Self> {
        let of_solids = place.trees[0].solid().map_or(&[][..], |_| &OF_SOLIDS);
        OF_SURFACES.iter().chain(of_solids).copied()
    }

    /// The work by which it may pass a budget.
    fn step(self) -> u64 {
        match self {
            Self::Any
            | Self::All
            | Self::NearestHit
            | Self::AnyHit
            | Self::AllHits
            | Self::HitFromInside
            | Self::Batch
            | Self::Winding(_)
            | Self::Windings => MAX_STEP_WORK,
            _ => MAX_DISTANCE_STEP_WORK,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Said {
    Outcome(Answer<Verdict>),
    Distance(Answer<Bounds>),
    Contacts(Answer<ContactBounds>),
    Manifolds(Answer<ManifoldBounds>),
    Passage(Answer<TimeOfImpact>),
    Cast(Answer<RayBounds>),
    Batch(Answer<usize>),
    Point(Answer<PointBounds>),
}

impl Said {
    /// Why it ended, and after which work.
    fn end(&self) -> (StopReason, u64) {
        let (stop, stats) = match self {
            Self::Outcome(said) => (said.stop, said.stats),
            Self::Distance(said) => (said.stop, said.stats),
            Self::Contacts(said) => (said.stop, said.stats),
            Self::Passage(said) => (said.stop, said.stats),
            Self::Cast(said) => (said.stop, said.stats),
            Self::Manifolds(said) => (said.stop, said.stats),
            Self::Batch(said) => (said.stop, said.stats),
            Self::Point(said) => (said.stop, said.stats),
        };
        (stop, stats.work)
    }

    /// True if it claims nothing that the answer without a limit denies.
    fn agrees_with(&self, whole: &Self) -> bool {
        fn fits<T: PartialEq>(said: Option<T>, whole: Option<T>) -> bool {
            said.is_none() || said == whole
        }
        let meet = |[low, high]: [f64; 2], [least, most]: [f64; 2]| low <= most && least <= high;
        match (self, whole) {
            (Self::Outcome(said), Self::Outcome(whole)) => {
                let kind = std::mem::discriminant::<Verdict>;
                said.value == Verdict::Undecided || kind(&said.value) == kind(&whole.value)
            }
            (Self::Distance(said), Self::Distance(whole)) => {
                let [said, whole] = [said.value, whole.value];
                meet([said.low, said.high], [whole.low, whole.high])
                    && fits(said.closer, whole.closer)
                    && fits(said.within, whole.within)
            }
            (Self::Manifolds(said), Self::Manifolds(whole)) => {
                let [said, whole] = [said.value, whole.value];
                let nearest = whole.nearest.map(|(_, distance)| distance);
                let least = nearest.unwrap_or(f64::INFINITY);
                (whole.meets || !said.meets)
                    && fits(said.within, whole.within)
                    && said.nearest.is_none_or(|(_, distance)| distance >= least)
            }
            (Self::Passage(said), Self::Passage(whole)) => {
                let [said, whole] = [said.value, whole.value];
                said.lower <= whole.upper.unwrap_or(1.0)
                    && whole.lower <= said.upper.unwrap_or(1.0)
                    && fits(said.within, whole.within)
            }
            (Self::Cast(said), Self::Cast(whole)) => {
                let [said, whole] = [said.value, whole.value];
                let first = whole.hit.map_or(f64::INFINITY, |hit| hit.t);
                said.free_until <= first.max(whole.free_until)
                    && said.hit.is_none_or(|hit| hit.t >= first)
                    && fits(said.starts_inside, whole.starts_inside)
            }
            (Self::Point(said), Self::Point(whole)) => {
                let [said, whole] = [said.value, whole.value];
                let ends = |bounds: PointBounds| bounds.distance.map(|d| [d.low, d.high]);
                fits(said.winding, whole.winding)
                    && fits(said.inside, whole.inside)
                    && (whole.is_on_surface || !said.is_on_surface)
                    && ends(said).is_none_or(|said| ends(whole).is_some_and(|it| meet(said, it)))
            }
            (Self::Contacts(_), _) | (Self::Batch(_), _) => true,
            _ => false,
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

    /// Whose clock takes so many nanoseconds for each reading.
    fn ticking(reading: u64) -> Self {
        Self {
            clock: ManualClock::ticking(Duration::from_nanos(reading)),
            ..Self::new()
        }
    }

    fn run(&mut self, asked: Asked, place: &Place, budget: Budget) -> Said {
        let said = self.ask(asked, place, budget, false);
        said.expect("a run is never refused")
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
        let (tree, point) = (&place.trees[0], |i: usize| place.points[i]);
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
            Asked::AnyHit => Said::Cast(ask!(place.ray(RayMode::Any))),
            Asked::HitFromInside => Said::Cast(ask!(place.ray(RayMode::Nearest).solid(true))),
            Asked::Batch => Said::Batch(ask!(Query::rays(tree, &place.rays))),
            Asked::Manifolds => Said::Manifolds(ask!(place.manifolds())),
            Asked::Winding(i) => Said::Point(ask!(Query::winding(tree, point(i)).unwrap())),
            Asked::SignedDistance(i) => {
                Said::Point(ask!(Query::signed_distance(tree, point(i)).unwrap()))
            }
            Asked::Windings => Said::Batch(ask!(Query::windings(tree, &place.points).unwrap())),
            Asked::SignedDistances => {
                Said::Batch(ask!(Query::signed_distances(tree, &place.points).unwrap()))
            }
        })
    }

    /// What the last query found, in words.
    fn found(&self) -> String {
        let contacts: Vec<_> = self.workspace.contacts().collect();
        format!(
            "{:?} {contacts:?} {:?} {:?} {:?} {:?}",
            self.workspace.pairs(),
            self.workspace.ray_hits(),
            self.workspace.first_hits(),
            self.workspace.points(),
            self.workspace.manifolds()
        )
    }
}

/// Shows everything that can be asked about every place.
fn each(mut visit: impl FnMut(Asked, &Place)) {
    for place in Place::all().iter().chain(&Place::solids()) {
        Asked::of(place).for_each(|asked| visit(asked, place));
    }
}

#[test]
fn a_budget_of_work_is_passed_by_at_most_a_step() {
    each(|asked, place| {
        let mut room = Room::new();
        for work in (0..40).chain((40..8_000).step_by(37)) {
            let (_, done) = room.run(asked, place, Budget::work(work)).end();
            assert_step(done, work, asked.step());
        }
    });
    let (mut workspace, clock) = (PenetrationWorkspace::new(), ManualClock::new());
    for place in Place::all().iter().chain(&Place::solids()) {
        let query = PenetrationQuery::new(&place.trees[0], &place.trees[1], place.pose);
        for query in [query, query.solid(true)] {
            for work in (0..40).chain((40..40_000).step_by(371)) {
                let found = query.run(&mut workspace, Budget::work(work).clock(&clock));
                assert_step(found.stats.work, work, MAX_PENETRATION_STEP_WORK);
            }
        }
    }
}

#[test]
fn the_largest_budgets_end_like_none_however_late_the_clock() {
    let late = Duration::MAX - Duration::from_secs(20);
    let times = [
        (Duration::ZERO, Duration::MAX),
        (late, Duration::MAX),
        (late, late / 2),
    ];
    each(|asked, place| {
        let whole = Room::new().run(asked, place, Budget::work(u64::MAX - 1));
        assert!(whole.is_whole(), "{asked:?}: {whole:?}");
        for poll_interval in [0, 1, u64::MAX] {
            let mut room = Room::new();
            let said = room.run(asked, place, ENOUGH.poll_interval(poll_interval));
            assert_eq!(said, whole, "{asked:?}");
            for (by, limit) in times {
                room.clock = ManualClock::new();
                room.clock.advance(by);
                let budget = Budget::time(limit).poll_interval(poll_interval);
                let (stop, _) = room.run(asked, place, budget).end();
                assert_eq!(stop, whole.end().0, "{asked:?}, {limit:?} at {by:?}");
            }
        }
    });
}

#[test]
fn without_time_no_more_than_a_step_is_done_and_the_query_goes_on_later() {
    each(|asked, place| {
        for reading in [0, 1_000_000_000] {
            let mut room = Room::ticking(reading);
            let (stop, work) = room.run(asked, place, Budget::time(Duration::ZERO)).end();
            assert!(work < MAX_DISTANCE_STEP_WORK, "{asked:?}: {work}, {stop:?}");
            if stop == StopReason::Deadline {
                let said = room.resume(asked, place, ENOUGH);
                let said = said.expect("stopped by the clock");
                assert!(said.is_whole(), "{asked:?}: {said:?}");
            }
        }
    });
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
    let is_asked = |asked: &Asked| *asked != Asked::Manifolds;
    for place in &Place::all() {
        for asked in OF_SURFACES.into_iter().filter(is_asked) {
            let makes_room = matches!(
                asked,
                Asked::Touching | Asked::Contacts | Asked::AllHits | Asked::Batch
            );
            for budget in budgets {
                let [mut room, mut roomy] = [Room::new(), Room::new()];
                let calls =
                    |room: &mut Room| allocator_calls(|| _ = room.run(asked, place, budget));
                let first = calls(&mut room);
                assert!(first == 0 || makes_room, "{asked:?}: {first} calls");
                assert_eq!(calls(&mut room), 0, "{asked:?}");
                roomy.workspace.reserve_contacts(100);
                roomy.workspace.reserve_ray_hits(100);
                assert_eq!(calls(&mut roomy), 0, "{asked:?}");
            }
        }
    }
}

/// Budgets that leave no room for the first step, or for few steps; and how many nanoseconds each reading of the clock takes.
fn small_budgets() -> Vec<(Budget, u64)> {
    let works = [
        0,
        1,
        10,
        351,
        MAX_STEP_WORK,
        MAX_DISTANCE_STEP_WORK,
        3_000,
        12_000,
        u64::MAX,
    ];
    let times = [
        (0, 0),
        (1, 0),
        (1, 1),
        (20, 10),
        (100, 30),
        (400, 30),
        (1_000, 30),
        (1_000, 300),
        (5_000, 300),
        // A clock that is late at the first reading.
        (1_000, 1_000_000_000),
    ];
    let nanos = |(limit, reading)| (Budget::time(Duration::from_nanos(limit)), reading);
    let mut all: Vec<_> = works.map(|work| (Budget::work(work), 0)).into();
    all.extend(times.map(nanos));
    all.push((nanos((100, 30)).0.poll_interval(1), 30));
    all
}

#[test]
fn any_question_after_any_other_says_what_it_says_in_a_fresh_workspace() {
    let [_, surfaces, _, nothing] = Place::all();
    let solids = Place::solids().into_iter();
    let places: Vec<Place> = solids.chain([surfaces, nothing]).collect();
    let asked_of = |place| Asked::of(place).map(move |asked| (place, asked));
    let all: Vec<_> = places.iter().flat_map(asked_of).collect();
    let budgets = small_budgets();
    let mut before = Room::new();
    for &(place, asked) in &all {
        let whole = Room::new().run(asked, place, ENOUGH);
        let fresh = budgets.iter().map(|&(budget, reading)| {
            let mut room = Room::ticking(reading);
            let said = room.run(asked, place, budget);
            assert!(said.agrees_with(&whole), "{asked:?} {said:?} {whole:?}");
            (said, room.found())
        });
        let fresh: Vec<_> = fresh.collect();
        for (turn, &(other, earlier)) in all.iter().enumerate() {
            // Each budget after each question, at one of its places.
            let some = budgets.iter().enumerate();
            for (i, &(budget, reading)) in some.filter(|(i, _)| (i + turn) % 4 == 0) {
                let stop = [0, 1, 500, 1_100, 2_500, 9_000, 60_000][(i + turn) % 7];
                before.clock = ManualClock::new();
                let first = before.run(earlier, other, Budget::work(stop));
                if i % 2 == 1 && !first.is_whole() {
                    let _ = before.resume(earlier, other, Budget::work(stop));
                }
                before.workspace.set_cost_model(CostModel::default());
                before.clock = ManualClock::ticking(Duration::from_nanos(reading));
                let said = before.run(asked, place, budget);
                assert_eq!(said, fresh[i].0, "{asked:?} after {earlier:?}, {budget:?}");
                if (i + turn) % 12 == 0 {
                    assert_eq!(before.found(), fresh[i].1, "{asked:?} after {earlier:?}");
                    before.clock = ManualClock::new();
                    if !std::ptr::eq(other, place) || earlier != asked {
                        let late = before.resume(earlier, other, ENOUGH);
                        assert_eq!(late, Err(ResumeError), "{earlier:?} before {asked:?}");
                    }
                    let rest = before.resume(asked, place, ENOUGH).unwrap_or(said);
                    assert!(rest.is_whole() && rest.agrees_with(&whole), "{rest:?}");
                }
            }
        }
    }
}

/// Decided as far as a budget decides: the whole answer, or what it asks for.
fn is_decided(said: &Said) -> bool {
    said.is_whole()
        || match said {
            Said::Outcome(said) => said.value != Verdict::Undecided,
            Said::Distance(said) => said.value.closer.is_some(),
            Said::Passage(said) => said.value.upper.is_some(),
            Said::Cast(said) => said.value.hit.is_some(),
            Said::Point(said) => said.value.inside.is_some(),
            _ => false,
        }
}

/// The clock moves with each reading only, so it does not tell how busy the machine is.
#[test]
fn twice_the_budget_never_decides_fewer() {
    let time = |i: u32| Budget::time(Duration::from_nanos(60 << i));
    let mut never = 0;
    each(|asked, place| {
        for reading in [0, 20, 300] {
            let mut before = (false, 0);
            for i in 0..20 {
                let budget = if reading == 0 {
                    Budget::work(1 << i)
                } else {
                    time(i)
                };
                let said = Room::ticking(reading).run(asked, place, budget);
                let done = match said {
                    Said::Batch(said) => said.value,
                    _ => 0,
                };
                let now = (is_decided(&said), done);
                assert!(
                    before.0 <= now.0 && before.1 <= now.1,
                    "{asked:?} {budget:?}"
                );
                before = now;
            }
            never += usize::from(!before.0);
        }
    });
    assert!(never < 6, "{never} were never decided");
}

#[test]
fn twice_the_budget_never_decides_fewer_pairs_of_a_scene() {
    let tree = Arc::new(knot(0.2, 40));
    let decided = |budget: Budget, reading: u64| {
        let mut scene = Scene::new();
        for i in 0..60 {
            let at = DVec3::new(f64::from(i % 8), f64::from(i / 8), f64::from(i % 3)) * 1.4;
            let pose = placed(DMat3::from_rotation_x(f64::from(i)), at);
            scene.insert(Body::moving(Arc::clone(&tree), pose)).unwrap();
        }
        let clock = ManualClock::ticking(Duration::from_nanos(reading));
        let mut frame = || scene.detect(budget.clock(&clock)).decided;
        (0..3).map(|_| frame()).sum()
    };
    let most = decided(Budget::unlimited(), 0);
    for reading in [0, 20, 300] {
        let count = |i: u32| match reading {
            0 => decided(Budget::work(100 << i), 0),
            _ => decided(Budget::time(Duration::from_nanos(500 << i)), reading),
        };
        let counts: Vec<usize> = (0..20).map(count).collect();
        assert!(counts.is_sorted() && counts[19] == most, "{reading}");
    }
}

#[test]
fn a_clone_of_any_stopped_run_goes_on_like_its_original() {
    each(|asked, place| {
        for budget in [0, 900, 5_000] {
            let mut room = Room::new();
            let (stop, _) = room.run(asked, place, Budget::work(budget)).end();
            let mut clone = room.clone();
            assert_eq!(clone.found(), room.found());
            let both = [&mut room, &mut clone];
            let [said, again] = both.map(|room| room.resume(asked, place, ENOUGH));
            assert_eq!(said, again, "{asked:?}");
            assert_eq!(said.is_ok(), stop == StopReason::WorkLimit, "{asked:?}");
            assert_eq!(clone.found(), room.found(), "{asked:?}");
        }
    });
}

#[test]
fn before_the_first_query_a_workspace_holds_nothing() {
    for place in &Place::all() {
        let mut room = Room::new();
        assert!(
            Asked::of(place)
                .all(|asked| room.resume(asked, place, Budget::unlimited()) == Err(ResumeError))
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

/// A query with NaN equals itself, and so can be resumed. What it answers then, in order.
#[track_caller]
fn finishes<'t, Q: Question>(query: Query<'t, Q>) -> Q::Value
where
    Query<'t, Q>: Ask<Q>,
{
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let said = query.run(&mut workspace, Budget::work(500).clock(&clock));
    assert_eq!(said.stop, StopReason::WorkLimit);
    let said = query.resume(&mut workspace, Budget::unlimited().clock(&clock));
    let said = said.expect("the same query");
    assert_eq!(said.stop, StopReason::Finished);
    said.value
}

#[test]
fn a_number_that_is_none_counts_as_one() {
    let (place, nan) = (&Place::all()[1], f64::NAN);
    let distance = place.distance();
    for query in [
        distance.absolute_tolerance(nan),
        distance.relative_tolerance(nan),
        distance.closer_than(nan),
        distance.margins([nan, 0.1]),
    ] {
        let Bounds { low, high, .. } = finishes(query);
        assert!(low <= high, "{low} {high}");
    }
    let sweep = place.sweep();
    for query in [
        sweep.tolerance(nan),
        sweep.time_tolerance(nan),
        sweep.margins([nan, 0.1]),
    ] {
        let TimeOfImpact { lower, upper, .. } = finishes(query);
        assert!(lower <= upper.unwrap_or(1.0), "{lower} {upper:?}");
    }
    let _ = finishes(place.contacts().margin(nan));
    let mut workspace = Workspace::new();
    let mut told = |query: Query<Intersection>| {
        let _ = common::ask::run(&query, &mut workspace, Budget::work(500));
        query.estimate(&workspace, None).unwrap()
    };
    let query = place.query(Mode::All);
    assert_eq!(told(query.prior(nan)), told(query));
}
