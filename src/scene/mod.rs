//! Many bodies, one budget a frame.
//!
//! A [`Scene`] holds bodies ([`body`]), some of which move as one ([`compound`]). A frame
//! ([`frame`])
//!
//! 1. updates the boxes of the bodies that changed, and finds the pairs that are near each other
//!    ([`broad`]);
//! 2. lists the pairs whose boxes overlap, and shares the budget among them ([`schedule`]);
//! 3. runs the query that answers what is asked of each pair ([`pair`]), on one thread or on
//!    several;
//! 4. reports which contacts began and ended ([`events`]).
//!
//! A pair has four records: an entry in the list of known pairs, a state that is kept from its
//! first query on, a job of the frame, and a report. A pair that was proven to be farther apart
//! than its bodies have moved since needs no job, and of its records only the entry is looked at. A
//! pair that meets may have a second question: where it touches. The questions, and how much each
//! matters, are in [`ask`]; rays are cast between frames ([`cast`]).
//!
//! Each of these steps has a part of the budget ([`schedule::share`]), stops when that is spent,
//! and goes on in the next frame where it stopped. What was not reached is counted: bodies that are
//! not placed, bodies whose partners are not known, pairs that are not listed, and pairs that are
//! not decided.

mod ask;
mod body;
mod broad;
mod cast;
mod certificate;
mod checks;
mod compound;
mod error;
mod events;
mod facts;
mod filter;
mod frame;
mod id;
mod pair;
mod report;
mod room;
mod schedule;
mod spot;
mod waiting;

pub use ask::PairQuestion;
pub use ask::contacts::{ContactPoint, ContactPoints};
pub use body::{Body, BodyKind};
pub use cast::ray::{BodyHit, SceneCast, SceneRay};
pub use certificate::PairCertificate;
pub use error::SceneError;
pub use filter::Filter;
pub use id::{BodyId, CompoundId, MeasureId};
pub use report::{
    BodyContact, ContactPhase, GroupDistance, PairDistance, PairPassage, PairReport, Report,
};

use crate::math::Pose;
use crate::model::calibration::Calibration;
use crate::names::named;
use crate::query::{ClockedBudget, Mode, Workspace};
use crate::tree::Tree;
use alloc::boxed::Box;
use alloc::sync::Arc;
use body::{Bodies, Placed};
use broad::Broad;
use cast::Rays;
use compound::Compounds;
use events::Events;
use facts::Change;
use schedule::Schedule;
use schedule::crew::Alone;
use schedule::pairs::Pairs;
#[cfg(feature = "parallel")]
use schedule::workers::Workers;

/// Which boxes the broad phase compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reach {
    /// Those around the bodies where they are: pairs that are not reported do not meet.
    #[default]
    Here,
    /// Swept boxes: each covers a body's motion since the previous frame, at a constant velocity
    /// and turn between its two poses (the screw motion, or the middle of its box on a straight
    /// line). Pairs that may have met in between are reported as well, with what is true of them
    /// here.
    Swept,
}

named!(Reach { Here => "here", Swept => "swept" });

/// Bodies that move, and the question which of them meet, asked again every frame within a budget.
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Body, Budget, ManualClock, Pose, Scene, Tree, shapes};
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
    /// The frame from which on this mode is asked for.
    asked_since: u64,
    /// Whether the last report holds for the next frame too, unless something changes.
    is_known: bool,
    /// The last frame that found all, and the last of those after it in which nothing had changed.
    rest: [u64; 2],
    reach: Reach,
    bodies: Arc<Bodies>,
    broad: Broad,
    pairs: Pairs,
    schedule: Schedule,
    scratch: Box<Workspace>,
    report: Report,
    events: Events,
    rays: Rays,
    compounds: Compounds,
    #[cfg(feature = "parallel")]
    workers: Option<Workers>,
}

impl Scene {
    /// A scene without bodies, that asks whether they meet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            mode: Mode::Any,
            asked_since: 1,
            is_known: false,
            rest: [0; 2],
            reach: Reach::Here,
            bodies: Arc::new(Bodies::new()),
            broad: Broad::default(),
            pairs: Pairs::default(),
            schedule: Schedule::new(),
            scratch: pair::batch::workspace(),
            report: Report::default(),
            events: Events::default(),
            rays: Rays::default(),
            compounds: Compounds::default(),
            #[cfg(feature = "parallel")]
            workers: None,
        }
    }

    /// Asks from the next frame on for any intersection of each pair (the default), or for the
    /// number of all; what earlier frames found does not answer another question.
    pub fn set_mode(&mut self, mode: Mode) {
        if self.mode != mode {
            (self.mode, self.asked_since, self.is_known) = (mode, self.next_frame(), false);
        }
    }

    /// Which boxes the broad phase compares from the next frame on; by default, those where the
    /// bodies are.
    pub fn set_reach(&mut self, reach: Reach) {
        (self.reach, self.is_known) = (reach, false);
    }

    /// The most pairs of near bodies that are kept; by default 1,048,576. A pair takes 72 bytes,
    /// and about 450 more from its first turn on.
    ///
    /// Pairs beyond that are left out, and [`Report::is_full`] says so, until an eighth of the room
    /// is free again. Those that are kept already stay.
    pub fn set_max_pairs(&mut self, pairs: usize) {
        self.pairs.most = pairs.min(schedule::pairs::LIMIT);
        self.is_known = false;
    }

    /// Shares the work of [`Scene::detect`] among `threads` threads, the caller's included. Tests
    /// of last witnesses and queries are shared; placing bodies and finding and listing pairs are
    /// done by the caller. In a frame without a budget the other threads run queries while pairs
    /// are listed.
    ///
    /// Each frame wakes the threads. They poll for tasks for up to 0.2 ms before they sleep again.
    /// The state of a pair has to travel between the cores that work on it: where cores are far
    /// apart, threads gain less, or nothing if frames are short.
    ///
    /// # Errors
    /// If the operating system gives no thread; the scene then has the threads that it had.
    #[cfg(feature = "parallel")]
    pub fn use_threads(&mut self, threads: usize) -> std::io::Result<()> {
        self.workers = if threads > 1 {
            Some(Workers::start(threads - 1, schedule::BATCHES)?)
        } else {
            None
        };
        Ok(())
    }

    /// Makes room for this many bodies, and for this many pairs of them whose boxes overlap or
    /// nearly do: the boxes of moving bodies are widened by a twentieth of their longest edge.
    /// Within this room [`Scene::detect`] does not allocate. Takes about 850 bytes a body and 970 a
    /// pair.
    pub fn reserve(&mut self, bodies: usize, pairs: usize) {
        self.bodies_mut().reserve(bodies);
        let Self {
            bodies,
            broad,
            pairs: states,
            schedule,
            report,
            events,
            rays,
            ..
        } = self;
        broad.reserve(bodies.room());
        rays.reserve(bodies.room());
        states.reserve(broad, pairs);
        schedule.reserve(states.room(), bodies, report);
        events.reserve(states.room(), report);
    }

    /// Puts a body into the scene.
    ///
    /// # Errors
    /// If its pose, importance or margin is refused, with the id that it would have had, or no id
    /// is left.
    pub fn insert(&mut self, body: Body) -> Result<BodyId, SceneError> {
        self.insert_part(body, None)
    }

    fn insert_part(
        &mut self,
        body: Body,
        compound: Option<CompoundId>,
    ) -> Result<BodyId, SceneError> {
        let id = self.bodies.next_ids().next().ok_or(SceneError::Full)?;
        let importance = checks::body(id, &body)?;
        let frame = self.next_frame();
        let (inverse, last) = (body.pose.inverse_unchecked(), body.pose);
        let placed = Placed {
            body: Body { importance, ..body },
            inverse,
            last,
            motion: None,
            compound,
        };
        self.bodies_mut().insert(placed, frame);
        self.broad.reserve(self.bodies.room());
        self.broad.insert(id.index);
        Ok(id)
    }

    /// Takes a body out of the scene.
    ///
    /// # Errors
    /// If it is not in it.
    pub fn remove(&mut self, id: BodyId) -> Result<Body, SceneError> {
        let Placed { body, compound, .. } = self.edit(|bodies| bodies.remove(id))?;
        self.compounds.forget(compound, id);
        Ok(body)
    }

    /// A body of the scene.
    ///
    /// # Errors
    /// If it is not in it.
    pub fn body(&self, id: BodyId) -> Result<&Body, SceneError> {
        Ok(&self.bodies.get(id)?.body)
    }

    /// All bodies, by index.
    pub fn bodies(&self) -> impl Iterator<Item = (BodyId, &Body)> {
        self.bodies.iter()
    }

    /// The number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Moves a body, which rests there. Setting the pose at which it already rests is a no-op.
    ///
    /// # Errors
    /// If the body is not in the scene, or its pose too far from a rotation or too far out; it then
    /// stays where it was.
    pub fn set_pose(&mut self, id: BodyId, pose: Pose) -> Result<(), SceneError> {
        let Placed { body, motion, .. } = self.bodies.get(id)?;
        if body.pose != pose || motion.is_some() {
            checks::pose(id, &pose)?;
            let frame = self.next_frame();
            self.edit(|bodies| bodies.go(id, frame, &pose))?;
        }
        Ok(())
    }

    /// Moves several bodies: [`Scene::set_pose`] of each, in this order, or of none.
    ///
    /// # Errors
    /// If a body is not in the scene, or its pose too far from a rotation or too far out; all then
    /// stay where they were.
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

    /// Gives a body another tree, of a mesh that was deformed, say.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_tree(&mut self, id: BodyId, tree: Arc<Tree>) -> Result<(), SceneError> {
        self.change(id, |placed| placed.body.tree = tree)
    }

    /// The tree of a body, to be changed in place: refitted to a mesh that deforms, say. If others
    /// share it, the body gets one of its own first.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn tree_mut(&mut self, id: BodyId) -> Result<&mut Tree, SceneError> {
        self.change(id, |_| ())?;
        Ok(Arc::make_mut(&mut self.bodies_mut().get_mut(id)?.body.tree))
    }

    /// Says whom a body may meet.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_filter(&mut self, id: BodyId, filter: Filter) -> Result<(), SceneError> {
        self.change(id, |placed| placed.body.filter = filter)?;
        self.bodies_mut().set_pending(id.index, Change::Place);
        Ok(())
    }

    /// Says how much the pairs of a body matter.
    ///
    /// # Errors
    /// If the body is not in the scene, or the importance is NaN.
    pub fn set_importance(&mut self, id: BodyId, importance: f32) -> Result<(), SceneError> {
        let importance = checks::importance(id, importance)?;
        self.edit(|bodies| bodies.set_importance(id, importance))
    }

    /// Finds out which bodies meet, within a budget for the whole frame.
    ///
    /// Nothing runs past the budget: placing bodies, finding pairs and listing them are work like
    /// the queries, stop when their part of the frame is spent, and go on in the next frame. In
    /// [`Mode::Any`] pairs that met are tested before them by their last witnesses, and by what
    /// lies next to these: under a budget of time for half of the frame at most, under one of work
    /// up to `B - 2R` (see below). If the last report [is not whole](Report::is_whole) and only
    /// time is limited, known pairs are then searched too, and both may last until thirteen
    /// sixteenths of the frame are over. Of what is left the broad phase has up to seven eighths.
    /// Under a budget of work, `B` units are for queries, as if all pairs were known, and the broad
    /// phase may do `B + 65,536` units of its own ([`Report::broad_phase_work`]).
    ///
    /// **Lock-step.** Scenes to which the same was done, frame by frame with the same budgets,
    /// report the same bits on any number of threads and on every machine, as long as every frame
    /// from the first on had a budget of work or none. What a frame finds within a budget of time
    /// depends on the machine, and later frames, under whatever budget, go on from there: a scene
    /// that had one such frame is out of step for good, and is to be made anew. Rays may be cast
    /// within any budget.
    ///
    ///
    /// If the broad phase was cut, the report [is not whole](Report::is_whole) and says how many
    /// bodies are not placed ([`Report::unplaced`]), how many have partners that may not be known
    /// ([`Report::unpaired`]), and how many known pairs it did not look at ([`Report::unlisted`]).
    /// What it says about the pairs in it is as true as ever. Bodies of an importance above 0 go
    /// first, but for one in four; none waits for ever if budgets allow a step at all. What rests
    /// is known after some frames, as without a budget. If the last frame decided all pairs and
    /// nothing has changed since, its report is told again, within any budget; unless it tells of
    /// distances, of motions, or [where some bodies touch](Scene::find_contacts_of), which are
    /// looked at in every frame.
    ///
    /// It allocates only as the scene grows: in a frame with more bodies, or with more pairs of
    /// overlapping boxes, than any before it, and, to be ready for more, in the 64 frames after it
    /// had more bodies than ever. Buffers then get room for twice as many, so there are few such
    /// frames; within the room made by [`Scene::reserve`] there are none. There are no more than
    /// [`Scene::set_max_pairs`] pairs, and those whose distances are asked for.
    ///
    /// **Several questions, one budget.** Of each pair that overlaps is asked whether it meets; how
    /// far apart it is instead, if that is [asked for](Scene::measure), which tells both; until
    /// when it is free, if a body [moves](Scene::set_motion); and of a pair that meets, [where it
    /// touches](Scene::find_contacts). A question counts as much as the more important body of the
    /// pair and [the question](Scene::set_question_importance) together. Those that count most go
    /// first, and of equal ones those that are expected to tell most for their cost: an
    /// intersection that is likely, contacts that are sure to be there, the contact in time that is
    /// the soonest. Before them come tests of the last witnesses, and a quarter of the budget goes
    /// round all questions in turn. If contacts count more than whether a pair meets, they are
    /// asked first of the pairs that met last.
    ///
    /// **Guarantee: no question starves.** Let `B` be the budget of each frame, of work (at least
    /// `L`) or the time that the broad phase and what comes before it leave; `R = B/8`; and `C` the
    /// sum over the overlapping pairs, and over the questions asked of each, of what they take to
    /// their ends, or are expected to take if that is more, with `L` units for every frame in which
    /// one goes on: `L` is 602, or 1,290 if [margins](Scene::set_margin),
    /// [distances](Scene::measure) or [motions](Scene::set_motion) are asked for, or 3,690 if
    /// contacts are. Then each question of each pair has a turn within **`K = 2 ⌈C/R⌉ + 1`**
    /// frames, and one that takes no more than `R`, or whose bodies rest, is answered at least once
    /// in `K` frames.
    ///
    /// If the broad phase is cut, this holds from the frame on in which a pair is known, with `K`
    /// plus twice the frames that it takes to list all known pairs once.
    ///
    /// With a clock of the caller's ([`Budget::clock`](crate::Budget::clock)) the calling thread
    /// does all by itself.
    pub fn detect<'c>(&mut self, budget: impl Into<ClockedBudget<'c>>) -> &Report {
        self.detect_within(budget.into())
    }

    fn detect_within(&mut self, budget: ClockedBudget<'_>) -> &Report {
        #[cfg(feature = "parallel")]
        let by_system = budget.clock.is_none();
        let (budget, clock) = budget.parts();
        #[cfg(feature = "parallel")]
        if by_system && let Some(workers) = self.workers.take() {
            self.frame(budget, clock, &workers);
            self.workers = Some(workers);
            return &self.report;
        }
        self.frame(budget, clock, &Alone(clock));
        &self.report
    }

    /// What the last frame found; before the first an empty report, of frame 0.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Whether the last frame knew all bodies that this one may meet: it was placed where it is,
    /// and the search for its partners came to its end. Of two such bodies that may meet and are
    /// not in [`Report::pairs`] together the boxes are apart if [`Report::unlisted`] is 0.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn partners_known(&self, id: BodyId) -> Result<bool, SceneError> {
        self.bodies.get(id)?;
        Ok(self.broad.is_closed(id.index) && !self.bodies.facts(id.index).is_changed())
    }

    /// The correction of the probabilities that estimates tell: [`PairReport::probability`] of a
    /// pair whose query was stopped includes it.
    ///
    /// It learns by itself when a pair is decided, from up to eight estimates while its bodies
    /// rested. What was told before one of them moved teaches nothing: of pairs in motion, those
    /// that meet are decided sooner than the others.
    pub fn calibration(&self) -> Calibration {
        self.schedule.calibration
    }

    /// Goes on with a correction that was learned before, by another scene with parts of the same
    /// kind, say.
    pub fn set_calibration(&mut self, calibration: Calibration) {
        self.schedule.calibration = calibration;
    }

    /// The bodies, to be changed in a way that is not refused: the last report may not hold any
    /// more.
    fn bodies_mut(&mut self) -> &mut Bodies {
        self.is_known = false;
        // No worker has a share of them between frames, so nothing is copied.
        Arc::make_mut(&mut self.bodies)
    }

    /// Changes the bodies. If that is refused, which leaves them as they were, the last report
    /// holds as long as before.
    fn edit<R>(
        &mut self,
        change: impl FnOnce(&mut Bodies) -> Result<R, SceneError>,
    ) -> Result<R, SceneError> {
        let done = change(Arc::make_mut(&mut self.bodies))?;
        self.is_known = false;
        Ok(done)
    }

    /// The frame in which a change takes effect.
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
