//! Collision detection of many bodies with one budget per frame.
//!
//! A [`Scene`] holds bodies: trees of the crate `punctual` at poses. [`Scene::detect`] finds,
//! within a budget, which of them meet, and its [`Report`] names what it did not reach. Bodies may
//! move together ([`Scene::insert_compound`]), have margins ([`Body::margin`]), be moved
//! continuously ([`Scene::set_motion`]), and be asked for distances ([`Scene::measure`]) and
//! contact points ([`Scene::find_contacts`]). Between frames, rays and shapes are asked about
//! ([`Scene::cast`], [`Scene::cast_shape`], [`Scene::overlap`], [`Scene::closest`]).
//!
//! The page `docs/scene.md` of `punctual` has the guarantees and measured figures.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(doctest, doc = include_str!("../README.md"))]
#![cfg_attr(doctest, doc = include_str!("../../../docs/scene.md"))]

extern crate alloc;

// A `Scene` holds bodies (`body`); some move together as a compound (`compound`). A frame
// (`frame`)
//
// 1. updates the boxes of the bodies that changed, and finds the pairs that are near each other
//    (`broad`);
// 2. lists the pairs whose boxes overlap, and shares the budget among them (`schedule`);
// 3. runs the query that answers the question of each pair (`pair`), on one thread or on
//    several;
// 4. reports which contacts began and ended (`events`).
//
// A pair has four records: an entry in the list of known pairs, a state that is kept from its
// first query on, a task of the frame, and a report. A pair proven to be farther apart than its
// bodies have moved since needs no task; only its entry is read. A pair may have further questions
// after its first: a time of impact after a distance, and contacts. The questions and their
// importance are in `ask`; rays and shapes are asked about between frames (`cast`).
//
// Each step has a share of the budget (`schedule::share`), stops when it is spent, and continues
// in the next frame where it stopped. The report counts what was not reached: bodies not placed,
// bodies with possibly unknown partners, pairs not listed, and pairs not decided.

/// Writes a call of a scene to its recording, if it has one.
#[cfg(feature = "record")]
macro_rules! record {
    ($scene:ident, $call:ident $($arguments:tt)?) => {
        $scene.record(|_, _| Ok(crate::record::Call::$call $($arguments)?))
    };
    ($scene:ident, $call:expr) => {
        $scene.record($call)
    };
}
#[cfg(not(feature = "record"))]
macro_rules! record {
    ($($call:tt)*) => {};
}

mod ask;
mod body;
mod broad;
mod cast;
mod certificate;
mod checks;
mod compound;
mod cost;
mod error;
mod events;
mod facts;
mod filter;
mod frame;
mod id;
mod pair;
#[cfg(feature = "record")]
mod record;
mod report;
mod room;
mod schedule;
mod spot;
mod waiting;

pub use ask::PairQuestion;
pub use ask::contacts::{ContactPoint, Contacts, PlacedContact};
pub use body::{Body, BodyKind};
pub use cast::ray::{BodyHit, SceneCast, SceneRay};
pub use cast::shape::{BodyOverlap, Closest, Overlap, SceneShape, ShapeCast, ShapeHit};
pub use certificate::PairCertificate;
pub use error::SceneError;
pub use filter::Filter;
pub use id::{BodyId, CompoundId, GroupId, MeasureId};
#[cfg(feature = "record")]
pub use record::Replay;
pub use report::{
    BodyContact, ContactPhase, GroupDistance, PairDistance, PairPassage, PairReport, Report,
};

use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::sync::Arc;
use body::{Bodies, Placed};
use broad::Broad;
use cast::Casts;
use compound::Compounds;
use events::Events;
use facts::Change;
use id::PairKey;
use punctual::Tree;
use punctual::clock::ClockedBudget;
use punctual::prediction::Calibration;
use punctual::{Mode, Workspace};
use punctual_geom::Pose;
use punctual_geom::named;
use schedule::Schedule;
use schedule::executor::Alone;
use schedule::pairs::Pairs;
#[cfg(feature = "parallel")]
use schedule::workers::Workers;

/// Selects the boxes that the broad phase compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reach {
    /// The boxes around the bodies at their poses. Pairs that are not reported do not meet.
    #[default]
    Here,
    /// Swept boxes: each covers a body's motion since the previous frame, at a constant velocity
    /// and turn between its two poses (the screw motion, or the middle of its box on a straight
    /// line). Pairs that may have met in between are also reported; their reports describe the
    /// current poses.
    Swept,
}

named!(Reach { Here => "here", Swept => "swept" });

/// Bodies that move. Each frame finds, within a budget, which of them meet.
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Budget, Pose, Tree, shapes};
/// use punctual::clock::ManualClock;
/// use punctual_scene::{Body, Scene};
/// use std::sync::Arc;
///
/// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
/// let ring = Arc::new(Tree::new(shapes::torus(2.0, 0.5, 48)));
/// let mut scene = Scene::new();
/// scene.insert(Body::fixed(ring, Pose::IDENTITY))?;
/// let id = scene.insert(Body::moving(ball, Pose::IDENTITY))?;
/// for frame in 0..60 {
///     let place = DVec3::new(0.0, 0.0, 3.0 - 0.1 * f64::from(frame));
///     scene.set_pose(id, Pose::new(DMat3::IDENTITY, place)?)?;
///     let report = scene.detect(Budget::work(50_000).clock(&ManualClock::new()));
///     for pair in report.intersecting_pairs() {
///         println!("frame {frame}: {} meets {}", pair.a, pair.b);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Scene {
    mode: Mode,
    /// The frame from which on this mode applies.
    asked_since: u64,
    /// True if nothing has changed since the last frame.
    is_same: bool,
    /// The frames without a change so far: the one that began their list, and the last of them.
    rest: [u64; 2],
    reach: Reach,
    bodies: Arc<Bodies>,
    broad: Broad,
    pairs: Pairs,
    schedule: Schedule,
    scratch: Box<Workspace>,
    report: Report,
    events: Events,
    casts: Casts,
    compounds: Compounds,
    #[cfg(feature = "parallel")]
    workers: Option<Workers>,
    #[cfg(feature = "record")]
    recorder: Option<Box<record::Recorder>>,
}

impl Scene {
    /// A scene without bodies, in [`Mode::Any`].
    #[must_use]
    pub fn new() -> Self {
        Self {
            mode: Mode::Any,
            asked_since: 1,
            is_same: false,
            rest: [0; 2],
            reach: Reach::Here,
            bodies: Arc::new(Bodies::new()),
            broad: Broad::default(),
            pairs: Pairs::default(),
            schedule: Schedule::new(),
            scratch: pair::batch::workspace(),
            report: Report::default(),
            events: Events::default(),
            casts: Casts::default(),
            compounds: Compounds::default(),
            #[cfg(feature = "parallel")]
            workers: None,
            #[cfg(feature = "record")]
            recorder: None,
        }
    }

    /// From the next frame on, decides only if each pair intersects (the default), or counts all
    /// its intersections. After a change, results of earlier frames no longer count.
    pub fn set_mode(&mut self, mode: Mode) {
        if self.mode != mode {
            (self.mode, self.asked_since, self.is_same) = (mode, self.next_frame(), false);
            record!(self, SetMode(mode));
        }
    }

    /// Sets which boxes the broad phase compares, from the next frame on. The default is
    /// [`Reach::Here`].
    pub fn set_reach(&mut self, reach: Reach) {
        (self.reach, self.is_same) = (reach, false);
        record!(self, SetReach(reach));
    }

    /// Sets the maximum number of pairs of near bodies that are kept; by default 1,048,576. A pair
    /// takes 88 bytes, and about 450 more from its first turn on.
    ///
    /// Further pairs are left out, and [`Report::is_full`] is true, until an eighth of the room is
    /// free again. Pairs that are already kept stay.
    pub fn set_max_pairs(&mut self, pairs: usize) {
        self.pairs.most = pairs.min(schedule::pairs::LIMIT);
        self.is_same = false;
        record!(self, SetMaxPairs(pairs));
    }

    /// Shares the work of [`Scene::detect`] among `threads` threads, including the caller's.
    /// Queries are shared. The caller tests the latest witnesses, places bodies, and finds and
    /// lists pairs. In a frame without a budget the other threads run queries while pairs are
    /// listed.
    ///
    /// Each frame wakes the threads. They poll for batches for up to 0.2 ms before they sleep
    /// again. The state of a pair moves between the cores that work on it. So if communication
    /// between the cores is slow, threads gain less, or nothing if frames are short.
    ///
    /// # Errors
    /// If the operating system cannot start a thread. The scene then keeps its threads.
    #[cfg(feature = "parallel")]
    pub fn use_threads(&mut self, threads: usize) -> std::io::Result<()> {
        self.workers = if threads > 1 {
            Some(Workers::start(threads - 1, schedule::BATCHES)?)
        } else {
            None
        };
        self.make_room_for_contacts();
        Ok(())
    }

    /// Reserves room for this many bodies, and for this many pairs of them whose boxes overlap or
    /// nearly do: the boxes of moving bodies are widened by a twentieth of their longest edge.
    /// Within this room [`Scene::detect`] does not allocate. Takes about 860 bytes per body and 960
    /// per pair.
    pub fn reserve(&mut self, bodies: usize, pairs: usize) {
        self.bodies_mut().reserve(bodies);
        self.broad.reserve(self.bodies.room());
        self.casts.reserve(self.bodies.room());
        self.pairs.reserve(&mut self.broad, pairs);
        self.schedule.reserve(self.pairs.room(), &mut self.report);
        self.events.reserve(self.pairs.room(), &mut self.report);
        record!(self, Reserve(bodies, pairs));
    }

    /// Inserts a body.
    ///
    /// # Errors
    /// If its pose, importance or margin is invalid; the error has the id that the body would have
    /// had. Or if no id is left.
    pub fn insert(&mut self, body: Body) -> Result<BodyId, SceneError> {
        let id = self.insert_part(body, None)?;
        record!(self, |scene, recorder| {
            let pose = scene.body(id)?.pose;
            Ok(record::Call::Insert(recorder.part(scene, id, pose)?))
        });
        Ok(id)
    }

    fn insert_part(
        &mut self,
        body: Body,
        compound: Option<CompoundId>,
    ) -> Result<BodyId, SceneError> {
        let id = self.bodies.next_ids().next().ok_or(SceneError::Full)?;
        let importance = checks::body(id, &body)?;
        let frame = self.next_frame();
        let placed = Placed::new(Body { importance, ..body }, compound);
        self.with_new_mesh(|scene| scene.bodies_mut().insert(placed, frame));
        self.broad.reserve(self.bodies.room());
        self.broad.insert(id.index);
        Ok(id)
    }

    /// Removes a body.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn remove(&mut self, id: BodyId) -> Result<Body, SceneError> {
        let Placed { body, compound, .. } = self.edit(|bodies| bodies.remove(id))?;
        self.compounds.forget(compound, id);
        record!(self, Remove(id));
        Ok(body)
    }

    /// A body of the scene.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn body(&self, id: BodyId) -> Result<&Body, SceneError> {
        Ok(&self.bodies.get(id)?.body)
    }

    /// All bodies, by index.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyId, &Body)> {
        self.bodies.iter()
    }

    /// Names a body in [messages](Scene::message) and on pages.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_name(&mut self, id: BodyId, name: &str) -> Result<(), SceneError> {
        self.bodies.get(id)?;
        let names = &mut Arc::make_mut(&mut self.bodies).names;
        names.insert(id.index, name.into());
        record!(self, SetName(id, name.into()));
        Ok(())
    }

    /// The name of a body; empty if it has none, or is not in the scene.
    pub fn name(&self, id: BodyId) -> &str {
        let is_there = self.bodies.get(id).is_ok();
        let name = self.bodies.names.get(&id.index).filter(|_| is_there);
        name.map_or("", |name| name)
    }

    /// The message of an error of this scene, with the name of the body that it is about. Takes
    /// time linear in the bodies with names.
    ///
    /// ```
    /// use punctual::{Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let mut scene = Scene::new();
    /// let ball = Arc::new(Tree::new(shapes::icosphere(1)));
    /// let id = scene.insert(Body::moving(ball, Pose::IDENTITY))?;
    /// scene.set_name(id, "lamp")?;
    /// let error = scene.set_margin(id, -1.0).unwrap_err();
    /// assert!(scene.message(&error).starts_with("lamp (body 0 (generation 0)): -1 is not a length"));
    /// # Ok::<(), punctual_scene::SceneError>(())
    /// ```
    #[must_use]
    pub fn message(&self, error: &SceneError) -> String {
        let mut message = error.to_string();
        for (&body, name) in &self.bodies.names {
            let id = self.bodies.id(body).to_string();
            message = message.replacen(&id, &format!("{name} ({id})"), 1);
        }
        message
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// True if there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Moves a body to a pose, where it rests. Setting the pose at which it already rests is a
    /// no-op.
    ///
    /// # Errors
    /// If the body is not in the scene, or its pose is too far from a rotation or too far out. The
    /// body then stays where it was.
    pub fn set_pose(&mut self, id: BodyId, pose: Pose) -> Result<(), SceneError> {
        let Placed { body, motion, .. } = self.bodies.get(id)?;
        if body.pose != pose || motion.is_some() {
            checks::pose(id, &pose)?;
            let frame = self.next_frame();
            self.edit(|bodies| bodies.go(id, frame, &pose))?;
            record!(self, SetPose(id, pose));
        }
        Ok(())
    }

    /// Moves several bodies: [`Scene::set_pose`] for each, in this order, or for none.
    ///
    /// # Errors
    /// If a body is not in the scene, or its pose is too far from a rotation or too far out. All
    /// bodies then stay where they were.
    pub fn set_poses(
        &mut self,
        poses: impl IntoIterator<Item = (BodyId, Pose), IntoIter: Clone>,
    ) -> Result<(), SceneError> {
        let mut poses = poses.into_iter();
        for (id, pose) in poses.clone() {
            self.bodies.get(id)?;
            checks::pose(id, &pose)?;
        }
        poses.try_for_each(|(id, pose)| self.set_pose(id, pose))
    }

    /// Replaces the tree of a body, for example after its mesh was deformed.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_tree(&mut self, id: BodyId, tree: Arc<Tree>) -> Result<(), SceneError> {
        self.with_new_mesh(|scene| scene.change(id, |placed| placed.body.tree = tree))?;
        record!(self, |scene, recorder| {
            let number = recorder.tree(&scene.body(id)?.tree);
            Ok(record::Call::SetTree(id, number))
        });
        Ok(())
    }

    /// Runs a change that brings a mesh, which may be the largest so far.
    fn with_new_mesh<R>(&mut self, change: impl FnOnce(&mut Self) -> R) -> R {
        let largest = self.bodies.largest_mesh;
        let done = change(self);
        if self.bodies.largest_mesh != largest {
            self.make_room_for_contacts();
        }
        done
    }

    /// The tree of a body, to be changed in place, for example refitted to a deforming mesh. If
    /// other bodies share the tree, the body first gets a copy.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn tree_mut(&mut self, id: BodyId) -> Result<&mut Tree, SceneError> {
        self.change(id, |_| ())?;
        #[cfg(feature = "record")]
        if let Some(recorder) = &mut self.recorder {
            recorder.open_trees.push(id);
        }
        Ok(Arc::make_mut(&mut self.bodies_mut().get_mut(id)?.body.tree))
    }

    /// Sets which bodies a body may meet.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_filter(&mut self, id: BodyId, filter: Filter) -> Result<(), SceneError> {
        self.change(id, |placed| placed.body.filter = filter)?;
        self.bodies_mut().set_pending(id.index, Change::Place);
        record!(self, SetFilter(id, filter));
        Ok(())
    }

    /// Ignores a pair of bodies from the next frame on, or does no longer: it may not meet, like
    /// one that the [filters](Filter) exclude. An ignored pair is forgotten with one of its bodies.
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn ignore(&mut self, x: BodyId, y: BodyId, ignores: bool) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        self.edit(|bodies| {
            bodies.ignore(key, ignores);
            Ok(())
        })?;
        self.bodies_mut().set_pending(x.index, Change::Place);
        record!(self, Ignore(x, y, ignores));
        Ok(())
    }

    /// Sets the importance of the pairs of a body.
    ///
    /// # Errors
    /// If the body is not in the scene, or the importance is NaN.
    pub fn set_importance(&mut self, id: BodyId, importance: f32) -> Result<(), SceneError> {
        let importance = checks::importance(id, importance)?;
        self.edit(|bodies| bodies.set_importance(id, importance))?;
        record!(self, SetImportance(id, importance));
        Ok(())
    }

    /// Finds which bodies meet, within a budget for the whole frame.
    ///
    /// Nothing exceeds the budget. Placing bodies, finding pairs and listing them are work like the
    /// queries: they stop when their share of the frame is spent, and continue in the next frame.
    /// In [`Mode::Any`], pairs that met are tested first, by their latest witnesses and by the
    /// triangles next to these. If the last frame was cut and only time is limited, known pairs are
    /// searched before the others are found: first the important ones. If many pairs that met were
    /// left open, then also those whose turn it is, in an eighth of the frame, and after the tests
    /// the most likely contacts for their cost. Tests and searches may take up to thirteen
    /// sixteenths of the frame, and fifteen if the last search is long; under a budget of work,
    /// tests take up to `B - 2R` (see below). Finding pairs may then use up to three quarters of
    /// what is left, and listing them half of the rest. Under a budget of work, `B` units are for
    /// queries, as if all pairs were known, and the broad phase may do `B + 65,536` units of its
    /// own ([`Report::broad_phase_work`]).
    ///
    /// **Lock-step.** Two scenes with the same history of changes, frame by frame with the same
    /// budgets, report the same bits on any number of threads and on every machine, as long as
    /// every frame from the first on had a budget of work or none. The findings of a frame with a
    /// budget of time depend on the machine, and later frames, with any budget, continue from them.
    /// So after one such frame a scene is out of step for good and must be rebuilt. Rays may be
    /// cast within any budget.
    ///
    /// If the broad phase was cut, the report [is not whole](Report::is_whole). It counts the
    /// bodies not placed ([`Report::unplaced`]), the bodies with possibly unknown partners
    /// ([`Report::unpaired`]), and the known pairs not listed ([`Report::unlisted`]). Everything
    /// that it states about its pairs is still true. Bodies with an importance above 0 go first,
    /// except that one in four is another body. None waits for ever if budgets allow a step at all.
    /// Bodies that rest are known after some frames, as without a budget. While nothing changes, a
    /// frame goes on with the report of the last one: it lists further pairs and continues the
    /// stopped runs. Once all is decided, distances of groups included, the report is repeated
    /// within any budget.
    ///
    /// It allocates only as the scene grows: in a frame with more bodies, or with more pairs of
    /// overlapping boxes, than any before. In preparation it also allocates in the 64 frames after
    /// the scene had more bodies than ever. Buffers then get room for twice as many, so there are
    /// few such frames. Within the room made by [`Scene::reserve`] there are none. There are at
    /// most [`Scene::set_max_pairs`] pairs, plus those whose distances are measured.
    ///
    /// **Several questions, one budget.** The question of a pair whose boxes overlap is whether it
    /// meets. If its distance is [measured](Scene::measure), the distance is computed instead,
    /// which answers both. If a body [moves](Scene::set_motion), the question is the time of
    /// impact, after the distance if that is measured. A pair that meets may also be asked for its
    /// [contacts](Scene::find_contacts). The
    /// importance of a question is the sum of the importance of the more important body and [that
    /// of the question](Scene::set_question_importance). The most important go first; of equal
    /// ones, those with the most expected information per cost: a probable intersection, contacts
    /// that are certain to exist, the earliest time of impact. Tests of the latest witnesses
    /// precede them, and a quarter of the budget goes to all questions in turn. If contacts are
    /// more important than whether a pair meets, the contacts of pairs that met last are found
    /// first.
    ///
    /// **Guarantee: no question starves.** Let `B` be the budget of each frame: work (at least
    /// `L`), or the time left by the broad phase and the steps before it. Let `R = B/8`. Let `C` be
    /// the sum of costs over the questions of all overlapping pairs. A question costs its complete
    /// answer, or the expected cost if that is more, plus `L` units for every frame in which it
    /// continues. `L` is 602, or 1,290 with [margins](Scene::set_margin),
    /// [distances](Scene::measure) or [motions](Scene::set_motion), or 3,690 with contacts. Then
    /// each question of each pair has a turn within **`K = 2 ⌈C/R⌉ + 1`** frames. A question that
    /// costs at most `R`, or whose bodies rest, is answered at least once in `K` frames.
    ///
    /// If the broad phase is cut, this holds from the frame in which a pair is first known. `K` is
    /// then larger by twice the number of frames that it takes to list all known pairs once.
    ///
    /// With a clock of the caller's ([`Budget::clock`](punctual::Budget::clock)) the calling thread
    /// does all the work.
    pub fn detect<'c>(&mut self, budget: impl Into<ClockedBudget<'c>>) -> &Report {
        self.detect_within(budget.into())
    }

    fn detect_within(&mut self, budget: ClockedBudget<'_>) -> &Report {
        #[cfg(feature = "parallel")]
        let by_system = budget.is_by_system();
        let (budget, clock) = budget.parts();
        record!(self, Detect(budget));
        #[cfg(feature = "parallel")]
        if by_system && let Some(workers) = self.workers.take() {
            self.frame(budget, clock, &workers);
            self.workers = Some(workers);
            return &self.report;
        }
        self.frame(budget, clock, &Alone(clock));
        &self.report
    }

    /// The report of the last frame; before the first an empty report, of frame 0.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// True if the last frame knew all bodies that this one may meet: the body was placed at its
    /// pose, and the search for its partners is finished. If two such bodies may meet, are not in
    /// [`Report::pairs`] together, and [`Report::unlisted`] is 0, then their boxes are separated.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn partners_known(&self, id: BodyId) -> Result<bool, SceneError> {
        self.bodies.get(id)?;
        Ok(self.broad.is_closed(id.index) && !self.bodies.facts(id.index).is_changed())
    }

    /// The correction of the estimated probabilities. [`PairReport::probability`] of a pair whose
    /// query was stopped includes it.
    ///
    /// It is updated when a pair is decided, from up to eight estimates made while its bodies
    /// rested. Estimates made before one of them moved are not used: of moving pairs, those that
    /// meet are decided sooner than the others.
    pub fn calibration(&self) -> Calibration {
        self.schedule.calibration
    }

    /// Sets a correction that was learned before, for example by another scene with similar parts.
    pub fn set_calibration(&mut self, calibration: Calibration) {
        self.schedule.calibration = calibration;
        record!(self, SetCalibration(calibration));
    }

    /// The bodies, for a change that cannot fail. The last report may no longer hold.
    fn bodies_mut(&mut self) -> &mut Bodies {
        self.is_same = false;
        // Between frames no worker shares them, so nothing is copied.
        Arc::make_mut(&mut self.bodies)
    }

    /// Changes the bodies. If that fails, it leaves them unchanged, and the last report still
    /// holds.
    fn edit<R>(
        &mut self,
        change: impl FnOnce(&mut Bodies) -> Result<R, SceneError>,
    ) -> Result<R, SceneError> {
        let done = change(Arc::make_mut(&mut self.bodies))?;
        self.is_same = false;
        Ok(done)
    }

    /// The last frame in which something about a pair changed; the next frame if it changed after
    /// the last one.
    fn changed(&self, key: PairKey) -> u64 {
        self.bodies.last_change(key).max(self.asked_since)
    }

    /// The number of the frame in which a change takes effect.
    fn next_frame(&self) -> u64 {
        self.report.frame + 1
    }

    /// Changes a body in a way that may change its box or its verdicts.
    fn change(&mut self, id: BodyId, change: impl FnOnce(&mut Placed)) -> Result<(), SceneError> {
        let frame = self.next_frame();
        self.edit(|bodies| bodies.change(id, frame, change))
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}
