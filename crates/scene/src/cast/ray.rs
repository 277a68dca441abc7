//! Rays in a scene: one, or a batch on several threads.

use super::line::Line;
use super::{Caster, Probe, Region, Sight, Walk};
use crate::Scene;
use crate::body::Placed;
use crate::error::SceneError;
use crate::filter::Filter;
use crate::id::BodyId;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use punctual::clock::ClockedBudget;
use punctual::engine::{Ask, Deadline};
use punctual::prediction::MAX_STEP_WORK;
use punctual::rays::{RayHit, RayMode};
use punctual::{Budget, Query, StopReason, Workspace};
use punctual_geom::{Aabb, Ray};

/// Asks which body a ray or a segment of the scene hits: [`crate::Scene::cast`].
///
/// ```
/// use punctual::glam::DMat3;
/// use punctual::{Budget, Pose, Ray, Tree, shapes};
/// use punctual::rays::RayMode;
/// use punctual_scene::{Body, Scene, SceneRay};
/// use std::sync::Arc;
///
/// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
/// let mut scene = Scene::new();
/// let mut insert = |x: f64| scene.insert(Body::moving(Arc::clone(&ball), Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()));
/// let (near, far) = (insert(5.0)?, insert(9.0)?);
///
/// let ray = SceneRay::new(Ray::new([0.0, 0.1, 0.2], [2.0, 0.0, 0.0])?);
/// let hit = scene.cast(&ray, Budget::unlimited())?.hit.expect("both balls are in its way");
/// assert!(hit.body == near && 2.0 < hit.on_body.t && hit.on_body.t < 2.1);
///
/// // All hits, into both balls and out of them.
/// let cast = scene.cast(&ray.mode(RayMode::All), Budget::unlimited())?;
/// assert_eq!((cast.found, scene.ray_hits().iter().filter(|hit| hit.body == far).count()), (4, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct SceneRay {
    ray: Ray,
    mode: RayMode,
    sight: Sight,
}

impl SceneRay {
    /// Asks for the nearest hit of a ray in the coordinates of the scene.
    pub fn new(ray: Ray) -> Self {
        Self {
            ray,
            mode: RayMode::Nearest,
            sight: Sight::default(),
        }
    }

    /// Sets whether to find the nearest hit, any, or all.
    pub fn mode(self, mode: RayMode) -> Self {
        Self { mode, ..self }
    }

    /// Restricts the cast to bodies that a body with this filter may meet; by default all.
    pub fn filter(mut self, filter: Filter) -> Self {
        self.sight.filter = filter;
        self
    }

    /// Restricts the cast to other bodies that this body may meet: by their filters and groups, not
    /// [ignored](Scene::ignore), and not of its compound.
    pub fn of_body(mut self, body: BodyId) -> Self {
        self.sight.body = Some(body);
        self
    }
}

/// A triangle of a body that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyHit {
    /// The body.
    pub body: BodyId,
    /// The triangle, and the ray parameter, which is the same in the scene: [`Ray::at`].
    pub on_body: RayHit,
}

impl BodyHit {
    /// Compares by `t`, then by body, then by triangle: a total order.
    pub(crate) fn is_before(&self, other: &Self) -> bool {
        let key = |hit: &Self| (hit.body.index, hit.on_body.triangle);
        self.on_body.t < other.on_body.t
            || self.on_body.t == other.on_body.t && key(self) < key(other)
    }
}

/// The answer to a [`SceneRay`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct SceneCast {
    /// The nearest hit found; in [`RayMode::Any`] the hit found. If `stop` is
    /// [`StopReason::Finished`], it is the nearest of all hits.
    pub hit: Option<BodyHit>,
    /// Number of triangles found to be hit. In [`RayMode::All`] those of
    /// [`crate::Scene::ray_hits`].
    pub found: u64,
    /// Proven: no missing hit lies before this parameter of the ray. For a known nearest hit, its
    /// own parameter. Infinite if nothing is left to find.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub free_until: f64,
    /// The reason why the call returned. [`StopReason::FlushedToZero`] if flushing could falsify
    /// the answer for one of the bodies.
    pub stop: StopReason,
    /// Work of the call.
    pub work: u64,
    /// Time of the call; measured only under a time budget, and not for each ray of a batch.
    pub elapsed: Option<Duration>,
}

impl SceneCast {
    const NOT_CAST: Self = Self {
        hit: None,
        found: 0,
        free_until: 0.0,
        stop: StopReason::WorkLimit,
        work: u64::MAX,
        elapsed: None,
    };
}

/// One cast.
struct RayProbe<'c> {
    asked: &'c SceneRay,
    line: Line,
    hits: &'c mut Vec<BodyHit>,
    hit: Option<BodyHit>,
    found: u64,
}

impl Region for RayProbe<'_> {
    fn sight(&self) -> &Sight {
        &self.asked.sight
    }

    fn bound(&self, bounds: &Aabb, _: bool) -> Option<f64> {
        self.line.enter(bounds)
    }
}

impl Probe for RayProbe<'_> {
    const LEAST_WORK: u64 = MAX_STEP_WORK;

    fn is_over(&self, enter: f64) -> bool {
        match self.asked.mode {
            RayMode::Nearest => self.hit.is_some_and(|hit| hit.on_body.t < enter),
            RayMode::Any => self.hit.is_some(),
            RayMode::All => false,
        }
    }

    fn ask(
        &mut self,
        (body, placed): (BodyId, &Placed),
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(StopReason, f64), SceneError> {
        let here = self
            .asked
            .ray
            .transformed(&placed.inverse)
            .map_err(|error| SceneError::NoRay { body, error })?;
        let [from, to] = here.limits();
        let nearest = self.hit.filter(|_| self.asked.mode == RayMode::Nearest);
        let ray = here.within(from, nearest.map_or(to, |hit| to.min(hit.on_body.t)));
        let query = Query::ray(&placed.body.tree, ray).mode(self.asked.mode);
        query.begin(workspace, None, Budget::unlimited());
        let cast = loop {
            let cast = query.spend(workspace, None, deadline);
            let hits = workspace.drain_ray_hits();
            self.hits
                .extend(hits.map(|on_body| BodyHit { body, on_body }));
            if cast.stop != StopReason::PairsFull {
                break cast;
            }
        };
        self.found += cast.stats.found;
        if let Some(hit) = cast.value.hit.map(|on_body| BodyHit { body, on_body })
            && self.hit.is_none_or(|before| hit.is_before(&before))
        {
            self.hit = Some(hit);
        }
        Ok((cast.stop, cast.value.free_until))
    }
}

impl Walk<'_> {
    fn cast(
        &self,
        asked: &SceneRay,
        caster: &mut Caster,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<SceneCast, SceneError> {
        let mut probe = RayProbe {
            asked,
            line: Line::new(&asked.ray),
            hits: &mut caster.hits,
            hit: None,
            found: 0,
        };
        let queue = &mut caster.queue;
        let walked = self.run(&mut probe, queue, workspace, deadline)?;
        let RayProbe { hit, found, .. } = probe;
        let on_body = hit.map(|hit| hit.on_body);
        Ok(SceneCast {
            hit,
            found,
            free_until: asked.mode.free_until(&asked.ray, on_body, walked.open),
            stop: walked.stop,
            work: walked.work,
            elapsed: walked.elapsed,
        })
    }
}

impl Scene {
    /// Finds which body a ray or a segment hits, within a budget of its own.
    ///
    /// It uses the pose of each body that was set last, whether a frame has run since or not.
    /// Bodies whose boxes the last frame did not reach, or that changed since, are tested one by
    /// one, with 120 units of work each. So cast rays after [`Scene::detect`] rather than before
    /// it. Other bodies are found through the tree of the broad phase, nearest boxes first, in a
    /// time that grows with the logarithm of their number.
    ///
    /// **Guarantee.** A body is hit where its own [`Query::ray`] reports a hit of the ray,
    /// [transformed](punctual::Ray::transformed) to the coordinates of its mesh by the inverse of
    /// its pose. No ray passes between triangles of a body that share an edge. Of several nearest
    /// hits with equal `t`, the one of the least body counts, then of the least triangle. A cast
    /// that is cut short has true hits, and [`SceneCast::free_until`] is proven. The same budget of
    /// work gives the same bits and is never exceeded. It allocates only in a scene with more
    /// bodies, or for more hits, than any before.
    ///
    /// # Errors
    /// [`SceneError::NoRay`], or [`SceneError::NoSuchBody`] if the asking body is not in the scene.
    pub fn cast<'c>(
        &mut self,
        ray: &SceneRay,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<SceneCast, SceneError> {
        // A rejected cast keeps the hits of the cast before.
        let before = self.casts.own.hits.len();
        let (walk, casts, workspace) = self.walk();
        let cast = walk.cast(
            ray,
            &mut casts.own,
            workspace,
            &mut Deadline::of(budget.into()),
        );
        let hits = &mut casts.own.hits;
        match cast {
            Ok(_) => drop(hits.drain(..before)),
            Err(_) => hits.truncate(before),
        }
        hits.reserve(hits.len());
        cast
    }

    /// The hits of the last [`Scene::cast`] with [`RayMode::All`]: body after body, each in order
    /// of discovery. Those of [`Scene::cast_rays`]: ray after ray, [`SceneCast::found`] each.
    pub fn ray_hits(&self) -> &[BodyHit] {
        &self.casts.own.hits
    }

    /// Casts rays one after another within one budget, each like [`Scene::cast`]. Returns an answer
    /// for each ray; the scene keeps them until the next call. After the first ray that the budget
    /// stopped, the others are free until 0.
    ///
    /// With threads (`Scene::use_threads`), batches of more than 64 rays are shared among them,
    /// unless work is limited, the clock is the caller's, or a ray has [`RayMode::All`]. A budget
    /// of work, or none, gives the same bits on any number of threads.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Ray, Tree, shapes};
    /// use punctual_scene::{Body, Scene, SceneRay};
    /// use std::sync::Arc;
    ///
    /// let mut scene = Scene::new();
    /// scene.insert(Body::fixed(Arc::new(Tree::new(shapes::icosphere(4))), Pose::IDENTITY))?;
    /// let ray = |i| Ray::new([0.0, 0.3 * f64::from(i), 9.0], [0.0, 0.0, -1.0]).map(SceneRay::new);
    /// let rays: Vec<SceneRay> = (0..9).map(ray).collect::<Result<_, _>>()?;
    /// let casts = scene.cast_rays(&rays, Budget::unlimited())?;
    /// assert_eq!(casts.iter().filter(|cast| cast.hit.is_some()).count(), 4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Scene::cast`], for the first ray that has one.
    pub fn cast_rays<'c>(
        &mut self,
        rays: &[SceneRay],
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<&[SceneCast], SceneError> {
        let budget = budget.into();
        #[cfg(feature = "parallel")]
        let is_by_system = budget.is_by_system();
        let (budget, clock) = budget.parts();
        let end = budget
            .time_limit()
            .map(|time| clock.now().saturating_add(time));
        let work = budget.work_limit().unwrap_or(u64::MAX);
        let mut answers = mem::take(&mut self.casts.answers);
        answers.clear();
        answers.resize(rays.len(), SceneCast::NOT_CAST);
        #[cfg(feature = "parallel")]
        if is_by_system && work == u64::MAX && rays.iter().all(|ray| ray.mode != RayMode::All) {
            threads::cast(self, rays, &mut answers, end);
        }
        let mut deadline = Deadline::at(end, work, clock);
        let (walk, casts, workspace) = self.walk();
        casts.own.hits.clear();
        let mut ended = None;
        let mut left = rays.iter().zip(&mut answers);
        let cast = left.try_for_each(|(ray, answer)| {
            if answer.work < u64::MAX {
                return Ok(());
            }
            *answer = match ended {
                Some(stop) => SceneCast {
                    stop,
                    work: 0,
                    ..SceneCast::NOT_CAST
                },
                None => walk.cast(ray, &mut casts.own, workspace, &mut deadline)?,
            };
            ended = ended.or(is_cut(answer.stop).then_some(answer.stop));
            Ok(())
        });
        casts.answers = answers;
        cast.map(|()| &*self.casts.answers)
    }
}

/// True if the budget stopped a cast, or the caller cancelled it.
fn is_cut(stop: StopReason) -> bool {
    !stop.is_final() && stop != StopReason::FlushedToZero
}

#[cfg(feature = "parallel")]
mod threads {
    use super::*;
    use crate::pair::batch;
    use crate::schedule::executor::Executor;
    use punctual::engine::SYSTEM;
    use std::sync::{Mutex, PoisonError};
    use std::thread::{Builder, scope};

    /// Rays that a thread takes at a time.
    const BLOCK: usize = 64;

    /// Casts rays on the threads of the scene, from the first on, until the end. Rays that are
    /// refused or not reached stay as they are.
    pub(super) fn cast(
        scene: &mut Scene,
        rays: &[SceneRay],
        answers: &mut [SceneCast],
        end: Option<Duration>,
    ) {
        let threads = scene.workers.as_ref().map_or(1, Executor::threads);
        let others = threads.min(rays.len().div_ceil(BLOCK)).saturating_sub(1);
        if others == 0 {
            return;
        }
        let (walk, casts, workspace) = scene.walk();
        let new = || (Caster::default(), batch::workspace());
        casts
            .others
            .resize_with(others.max(casts.others.len()), new);
        let blocks = rays.chunks(BLOCK).zip(answers.chunks_mut(BLOCK));
        let blocks = Mutex::new(blocks);
        let next = || blocks.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = |caster: &mut Caster, workspace: &mut Workspace| {
            let mut deadline = Deadline::at(end, u64::MAX, &SYSTEM);
            while let Some((rays, answers)) = next() {
                for (ray, answer) in rays.iter().zip(answers) {
                    match walk.cast(ray, caster, workspace, &mut deadline) {
                        Ok(cast) => *answer = cast,
                        Err(_) => break,
                    }
                    if is_cut(answer.stop) {
                        return;
                    }
                }
            }
        };
        scope(|scope| {
            for (caster, workspace) in &mut casts.others[..others] {
                // If the system refuses a thread, the others do its part.
                let _ = Builder::new().spawn_scoped(scope, || work(caster, workspace));
            }
            work(&mut casts.own, workspace);
        });
    }
}
