//! Many bodies, one budget a frame.
//!
//! A [`Scene`] holds bodies, finds those whose boxes overlap ([`broad`], [`pairs`]), shares the budget of the frame among
//! them ([`schedule`], where the guarantees stand), and runs each pair through the one query ([`chain`]), on one thread or
//! on several ([`workers`]).

mod body;
mod bounds;
mod broad;
mod chain;
mod error;
mod forecast;
mod guard;
mod pairs;
mod report;
mod schedule;
#[cfg(feature = "parallel")]
mod workers;

pub use body::{Body, BodyId, BodyKind, Filter};
pub use error::SceneError;
pub use report::{PairCertificate, PairReport, Report};

use crate::math::{Aabb, Pose};
#[cfg(feature = "std")]
use crate::query::SystemClock;
use crate::query::{Budget, Clock, Mode, Verdict, Workspace};
use crate::tree::Tree;
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use body::{Bodies, Placed, checked_importance, checked_inverse};
use broad::{Broad, News};
use chain::{Chain, Round};
use pairs::Pairs;
use schedule::{Frame, Schedule};

/// Which boxes the broad phase compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reach {
    /// Those around the bodies where they are: pairs that are not reported do not meet.
    #[default]
    Here,
    /// Those around the way of each body since the last frame. Pairs that may have met in between are reported as well, with
    /// what is true of them here.
    Way,
}

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
///     let report = scene.detect_with(Budget::work(50_000), &ManualClock::new());
///     for pair in report.intersecting_pairs() {
///         println!("frame {frame}: {} meets {}", pair.a, pair.b);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Scene {
    mode: Mode,
    reach: Reach,
    bodies: Arc<Bodies>,
    /// Bodies that need a new box, and whether they are another body than before.
    moved: Vec<(u32, News)>,
    broad: Broad,
    pairs: Pairs,
    schedule: Schedule,
    scratch: Box<Workspace>,
    report: Report,
    #[cfg(feature = "parallel")]
    workers: Option<workers::Workers>,
}

impl Scene {
    /// A scene without bodies, that asks whether they meet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            mode: Mode::Any,
            reach: Reach::Here,
            bodies: Arc::default(),
            moved: Vec::new(),
            broad: Broad::default(),
            pairs: Pairs::default(),
            schedule: Schedule::new(),
            scratch: chain::workspace(),
            report: Report::default(),
            #[cfg(feature = "parallel")]
            workers: None,
        }
    }

    /// Any intersection of each pair (the default), or the number of all.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// Which boxes the broad phase compares; by default, those where the bodies are.
    #[must_use]
    pub fn reach(mut self, reach: Reach) -> Self {
        self.reach = reach;
        self
    }

    /// Shares the work of [`Scene::detect`] among `threads` threads, the caller's included. They wait between frames.
    ///
    /// # Errors
    /// If the operating system gives no thread; the scene then has the threads that it had.
    #[cfg(feature = "parallel")]
    pub fn use_threads(&mut self, threads: usize) -> std::io::Result<()> {
        self.workers = if threads > 1 { Some(workers::Workers::start(threads - 1, schedule::CHAINS)?) } else { None };
        Ok(())
    }

    /// Puts a body into the scene.
    ///
    /// # Errors
    /// If its pose or importance is refused; the error has the id that it would have had.
    pub fn insert(&mut self, body: Body) -> Result<BodyId, SceneError> {
        let id = self.bodies.next_id().ok_or(SceneError::Full)?;
        let inverse = checked_inverse(id, &body.pose)?;
        let importance = checked_importance(id, body.importance)?;
        let frame = self.next_frame();
        let last = body.pose;
        self.bodies_mut().insert(Placed { body: body.with_importance(importance), inverse, last }, frame);
        self.moved.push((id.index() as u32, News::Body));
        Ok(id)
    }

    /// Takes a body out of the scene.
    ///
    /// # Errors
    /// If it is not in it.
    pub fn remove(&mut self, id: BodyId) -> Result<Body, SceneError> {
        let body = self.bodies_mut().remove(id)?;
        self.moved.push((id.index() as u32, News::Body));
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

    /// Moves a body. The very pose that it has leaves it at rest.
    ///
    /// # Errors
    /// If the body is not in the scene, or its pose too far from a rotation or too far out; it then stays where it was.
    pub fn set_pose(&mut self, id: BodyId, pose: Pose) -> Result<(), SceneError> {
        if self.bodies.get(id)?.body.pose != pose {
            let inverse = checked_inverse(id, &pose)?;
            self.change(id, |placed| (placed.body.pose, placed.inverse) = (pose, inverse))?;
        }
        Ok(())
    }

    /// Gives a body another tree, of a mesh that was deformed, say.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_tree(&mut self, id: BodyId, tree: Arc<Tree>) -> Result<(), SceneError> {
        self.change(id, |placed| placed.body.tree = tree)
    }

    /// The tree of a body, to be changed in place: refitted to a mesh that deforms, say. If others share it, the body gets
    /// one of its own first.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn tree_mut(&mut self, id: BodyId) -> Result<&mut Tree, SceneError> {
        self.change(id, |_| ())?;
        let placed = Arc::make_mut(&mut self.bodies).at_mut(id.index() as u32);
        Ok(Arc::make_mut(&mut placed.ok_or(SceneError::NoSuchBody { body: id })?.body.tree))
    }

    /// Says whom a body may meet.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn set_filter(&mut self, id: BodyId, filter: Filter) -> Result<(), SceneError> {
        self.change(id, |placed| placed.body.filter = filter)?;
        self.moved.push((id.index() as u32, News::Place));
        Ok(())
    }

    /// Says how much the pairs of a body matter.
    ///
    /// # Errors
    /// If the body is not in the scene, or the importance is NaN.
    pub fn set_importance(&mut self, id: BodyId, importance: f32) -> Result<(), SceneError> {
        let importance = checked_importance(id, importance)?;
        let changed = self.bodies.facts_of(id)?.changed;
        self.bodies_mut().change(id, changed, |placed| placed.body.importance = importance).map(drop)
    }

    /// Finds out which bodies meet, within a budget for the whole frame.
    ///
    /// Under a budget of time it ends in time as long as the broad phase alone does; under a budget of work, which does not
    /// count the broad phase, it gives the same report on any number of threads. It does not allocate once its buffers have
    /// grown to the size of the scene.
    #[cfg(feature = "std")]
    pub fn detect(&mut self, budget: Budget) -> &Report {
        let clock = SystemClock::default();
        #[cfg(feature = "parallel")]
        if let Some(workers) = self.workers.take() {
            self.frame(budget, &clock, workers.threads(), |chains, round, bodies, scratch| {
                workers.run(chains, round, bodies, scratch, clock);
            });
            self.workers = Some(workers);
            return &self.report;
        }
        self.detect_with(budget, &clock)
    }

    /// [`Scene::detect`] by a clock of the caller's, on the calling thread alone.
    pub fn detect_with<C: Clock>(&mut self, budget: Budget, clock: &C) -> &Report {
        self.frame(budget, clock, 1, |chains, round, bodies, scratch| {
            for chain in chains {
                chain.run(bodies, scratch, round, clock);
            }
        });
        &self.report
    }

    /// What the last frame found.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// What the last frame left open about two bodies. Takes time linear in what is open, so it is not part of the report.
    ///
    /// # Errors
    /// If one of them is not in the scene.
    pub fn certificate(&self, x: BodyId, y: BodyId) -> Result<PairCertificate, SceneError> {
        let (a, b) = if x.index() < y.index() { (x, y) } else { (y, x) };
        let (placed_a, placed_b) = (self.bodies.get(a)?, self.bodies.get(b)?);
        let nothing = PairCertificate { upper_bound: 0, largest_extent: 0.0 };
        let Some(pair) = self.report.pair(a, b) else { return Ok(nothing) };
        if pair.complete && (self.mode == Mode::All || pair.verdict == Verdict::Separated) {
            return Ok(PairCertificate { upper_bound: pair.found, ..nothing });
        }
        let [index_a, index_b] = [a, b].map(|body| body.index() as u32);
        let key = pairs::key(index_a, index_b);
        let trees = [placed_a, placed_b].map(|placed| &*placed.body.tree);
        if let Some(held) = self.schedule.certificate(key, trees, placed_a.relative(placed_b), self.mode) {
            return Ok(held);
        }
        let (of_a, of_b) = (self.broad.bounds(index_a), self.broad.bounds(index_b));
        let common = Aabb { min: of_a.min.max(of_b.min), max: of_a.max.min(of_b.max) };
        let [a, b] = trees.map(|tree| tree.mesh().len() as u64);
        Ok(PairCertificate { upper_bound: a * b, largest_extent: common.extents().max_element() })
    }

    fn bodies_mut(&mut self) -> &mut Bodies {
        // No worker has a share of them between frames, so nothing is copied.
        Arc::make_mut(&mut self.bodies)
    }

    /// The frame in which a change takes effect.
    fn next_frame(&self) -> u64 {
        self.report.frame + 1
    }

    /// Changes a body in a way that may change its box or its verdicts.
    fn change(&mut self, id: BodyId, change: impl FnOnce(&mut Placed)) -> Result<(), SceneError> {
        let frame = self.next_frame();
        if self.bodies_mut().change(id, frame, change)? {
            self.moved.push((id.index() as u32, News::None));
        }
        Ok(())
    }

    fn frame<C: Clock>(
        &mut self,
        budget: Budget,
        clock: &C,
        threads: usize,
        mut execute: impl FnMut(&mut [Chain], &Round, &Arc<Bodies>, &mut Box<Workspace>),
    ) {
        let started = budget.time_limit().map(|_| clock.now());
        self.report.frame += 1;
        self.place_moved();
        let Self { pairs, broad, bodies, schedule, scratch, report, .. } = self;
        pairs.update(broad, bodies, report.frame);
        let number = report.frame;
        let frame = Frame { number, mode: self.mode, budget, started, clock, bodies, threads };
        schedule.run(&frame, pairs, report, |chains, round| execute(chains, round, bodies, scratch));
        report.elapsed = started.map(|started| clock.now().saturating_sub(started));
    }

    /// Gives their boxes to all bodies that moved, came or went.
    fn place_moved(&mut self) {
        if self.reach == Reach::Way {
            // Each once: its way ends where it is.
            self.moved.sort_unstable_by(|x, y| y.cmp(x));
            self.moved.dedup_by_key(|&mut (index, _)| index);
        }
        let bodies = Arc::make_mut(&mut self.bodies);
        for at in (0..self.moved.len()).rev() {
            let (index, news) = self.moved[at];
            let mut goes_on = false;
            if let Some(Placed { body, last, .. }) = bodies.at_mut(index) {
                let bounds = match self.reach {
                    Reach::Here => bounds::at(&body.tree, &body.pose),
                    Reach::Way => bounds::swept(&body.tree, last, &body.pose),
                };
                self.broad.place(index, bounds, body.kind == BodyKind::Moving, news);
                // In the next frame it has come from here.
                goes_on = self.reach == Reach::Way && core::mem::replace(last, body.pose) != body.pose;
            } else {
                self.broad.place(index, Aabb::EMPTY, false, news);
            }
            if goes_on {
                self.moved[at].1 = News::None;
            } else {
                self.moved.swap_remove(at);
            }
        }
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}
