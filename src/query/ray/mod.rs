//! What rays hit: a tree, a ray and a budget in, a [`RayCast`] out; and the same for many rays.
//!
//! [`cast`] is the question that the traversal asks, [`beam`] a ray among the boxes of a tree, [`state`] what
//! is kept between calls.

mod beam;
mod cast;
pub(super) mod state;

use crate::math::{Pose, Ray};
use crate::query::Deadline;
use crate::query::budget::{Budget, Clock};
use crate::query::flushing;
use crate::query::outcome::{Stats, StopReason};
use crate::query::strategy::Strategy;
use crate::query::traversal::Traversal;
use crate::query::views::Relation;
use crate::query::workspace::{Asked, Key, ResumeError, Workspace};
use crate::tree::Tree;
use beam::Beam;
use cast::{Cast, ROOT, entered, entry};
pub use state::{RayHit, RayMode};

/// The question what a ray or a segment hits. Cheap to make; one for each ray.
///
/// **Guarantee.** A triangle is hit if it shares a point with the ray, exactly for the coordinates as they are given: closed
/// triangles, edges and corners included, so no ray passes between triangles that share an edge. A degenerate triangle is
/// the hull of its points, and one in whose plane the ray lies is hit where it begins to be. Whenever the query stops, every
/// hit that it has not found lies at [`RayCast::free_until`] or after it. The nearest hit is the one with the least `t` as it
/// is told ([`RayHit::t`]), of equal ones the one with the least id. Two hits that are closer together than the error of `t`
/// may so change places; the answer does not depend on budgets, machines or the shape of the tree.
///
/// ```
/// use punctual::{Budget, Ray, RayQuery, Side, Tree, Workspace, shapes};
/// let ball = Tree::new(shapes::icosphere(4));
/// let ray = Ray::new([0.1, 0.2, 9.0], [0.0, 0.0, -2.0])?;
/// let cast = RayQuery::new(&ball, ray).run(&mut Workspace::new(), Budget::unlimited());
/// let hit = cast.hit.expect("the ray comes through the ball");
/// assert!(ray.at(hit.t).length() < 1.0 && hit.side == Side::Front && cast.free_until == hit.t);
/// # Ok::<(), punctual::RayError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RayQuery<'t> {
    tree: &'t Tree,
    ray: Ray,
    mode: RayMode,
}

/// Room that the first query for all hits makes in a workspace that has none.
const DEFAULT_ROOM: usize = 4096;

impl<'t> RayQuery<'t> {
    /// Asks for the nearest hit of `ray`, which is in the frame of the tree's mesh.
    #[must_use]
    pub fn new(tree: &'t Tree, ray: Ray) -> Self {
        Self {
            tree,
            ray,
            mode: RayMode::Nearest,
        }
    }

    /// Asks for the nearest hit, for any, or for all.
    #[must_use]
    pub fn mode(mut self, mode: RayMode) -> Self {
        self.mode = mode;
        self
    }

    /// Runs within a budget, by the clock of the system. It does not lock or panic. The first query for [`RayMode::All`] makes
    /// room for 4,096 hits, unless [`Workspace::reserve_ray_hits`] has made some; otherwise nothing is allocated.
    pub fn run(&self, workspace: &mut Workspace, budget: Budget) -> RayCast {
        self.run_with(workspace, budget.by_system(), &crate::query::SYSTEM)
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget.
    ///
    /// However it is cut into pieces by budgets of work, the outcome at the end is that of one uninterrupted run.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this tree, this ray and this mode, or is complete.
    pub fn resume(
        &self,
        workspace: &mut Workspace,
        budget: Budget,
    ) -> Result<RayCast, ResumeError> {
        self.resume_with(workspace, budget.by_system(), &crate::query::SYSTEM)
    }

    /// [`RayQuery::run`] by a clock of the caller's.
    pub fn run_with(
        &self,
        workspace: &mut Workspace,
        budget: Budget,
        clock: &dyn Clock,
    ) -> RayCast {
        let mut deadline = Deadline::of(budget, clock);
        self.begin(workspace);
        self.spend(workspace, &mut deadline)
    }

    /// [`RayQuery::resume`] by a clock of the caller's.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this tree, this ray and this mode, or is complete.
    pub fn resume_with(
        &self,
        workspace: &mut Workspace,
        budget: Budget,
        clock: &dyn Clock,
    ) -> Result<RayCast, ResumeError> {
        holds(
            self.tree,
            workspace,
            core::slice::from_ref(&self.ray),
            self.mode,
        )?;
        Ok(self.spend(workspace, &mut Deadline::of(budget, clock)))
    }

    /// Prepares the workspace for a run.
    pub(crate) fn begin(&self, workspace: &mut Workspace) {
        begin(
            self.tree,
            workspace,
            core::slice::from_ref(&self.ray),
            self.mode,
        );
    }

    /// Goes on with the run in the workspace until it is over or the deadline stops it.
    pub(crate) fn spend(&self, workspace: &mut Workspace, deadline: &mut Deadline) -> RayCast {
        let rays = core::slice::from_ref(&self.ray);
        let (stop, open) = spend(self.tree, workspace, rays, &mut [None], deadline);
        let (hit, found) = (workspace.rays.hit, workspace.run.found);
        let free_until = self.mode.free_until(&self.ray, hit, open);
        let is_first = self.mode == RayMode::Any && hit.is_some() && stop.is_final();
        let stop = if is_first { StopReason::FirstHit } else { stop };
        RayCast {
            hit,
            found,
            free_until,
            stop,
            stats: workspace.stats(),
        }
    }
}

/// Many rays through one tree, answered one after the other within one budget; for each its nearest hit, or any. Takes less
/// time for each ray than a [`RayQuery`].
///
/// ```
/// use punctual::{Budget, Ray, RayBatch, Tree, Workspace, shapes};
/// let ball = Tree::new(shapes::icosphere(4));
/// let rays: Result<Vec<Ray>, _> = (0..9).map(|i| Ray::new([0.0, 0.3 * f64::from(i), 9.0], [0.0, 0.0, -1.0])).collect();
/// let (rays, mut hits) = (rays?, [None; 9]);
/// let done = RayBatch::new(&ball, &rays).run(&mut Workspace::new(), &mut hits, Budget::unlimited()).done;
/// assert_eq!((done, hits.iter().flatten().count()), (9, 4));
/// # Ok::<(), punctual::RayError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RayBatch<'t> {
    tree: &'t Tree,
    rays: &'t [Ray],
    mode: RayMode,
}

impl<'t> RayBatch<'t> {
    /// Asks for the nearest hit of each ray.
    #[must_use]
    pub fn new(tree: &'t Tree, rays: &'t [Ray]) -> Self {
        Self {
            tree,
            rays,
            mode: RayMode::Nearest,
        }
    }

    /// Asks for any hit of each ray.
    #[must_use]
    pub fn any(mut self) -> Self {
        self.mode = RayMode::Any;
        self
    }

    /// Runs within a budget, by the clock of the system, and writes the hits of the rays that are done into `hits`. If one of
    /// the two slices is longer, the rest of it is left alone. It does not allocate, lock or panic.
    pub fn run(
        &self,
        workspace: &mut Workspace,
        hits: &mut [Option<RayHit>],
        budget: Budget,
    ) -> RayBatchOutcome {
        self.run_with(workspace, hits, budget.by_system(), &crate::query::SYSTEM)
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget. `hits` is as long as it was; what is done
    /// already is not written again.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this tree and these rays, or is complete.
    pub fn resume(
        &self,
        workspace: &mut Workspace,
        hits: &mut [Option<RayHit>],
        budget: Budget,
    ) -> Result<RayBatchOutcome, ResumeError> {
        self.resume_with(workspace, hits, budget.by_system(), &crate::query::SYSTEM)
    }

    /// [`RayBatch::run`] by a clock of the caller's.
    pub fn run_with(
        &self,
        workspace: &mut Workspace,
        hits: &mut [Option<RayHit>],
        budget: Budget,
        clock: &dyn Clock,
    ) -> RayBatchOutcome {
        let mut deadline = Deadline::of(budget, clock);
        begin(self.tree, workspace, self.answered(hits), self.mode);
        self.spend(workspace, hits, &mut deadline)
    }

    /// [`RayBatch::resume`] by a clock of the caller's.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this tree and these rays, or is complete.
    pub fn resume_with(
        &self,
        workspace: &mut Workspace,
        hits: &mut [Option<RayHit>],
        budget: Budget,
        clock: &dyn Clock,
    ) -> Result<RayBatchOutcome, ResumeError> {
        holds(self.tree, workspace, self.answered(hits), self.mode)?;
        Ok(self.spend(workspace, hits, &mut Deadline::of(budget, clock)))
    }

    fn answered(&self, hits: &[Option<RayHit>]) -> &'t [Ray] {
        &self.rays[..self.rays.len().min(hits.len())]
    }

    fn spend(
        &self,
        workspace: &mut Workspace,
        hits: &mut [Option<RayHit>],
        deadline: &mut Deadline,
    ) -> RayBatchOutcome {
        let (stop, _) = spend(self.tree, workspace, self.answered(hits), hits, deadline);
        RayBatchOutcome {
            done: workspace.rays.done,
            stop,
            stats: workspace.stats(),
        }
    }
}

fn key(tree: &Tree) -> Key {
    Key::new([tree; 2], Pose::IDENTITY, Asked::Ray)
}

/// Prepares the workspace for the first of some rays.
fn begin(tree: &Tree, workspace: &mut Workspace, rays: &[Ray], mode: RayMode) {
    workspace.clear();
    workspace.run.begin(key(tree), Strategy::NONE);
    let state = &mut workspace.rays;
    state.mode = mode;
    if mode == RayMode::All && state.hits.capacity() == 0 {
        state.reserve(DEFAULT_ROOM);
    }
    state.after = rays.len().saturating_sub(1);
    if !rays.is_empty() && !tree.nodes().is_empty() {
        workspace.front.push(entered(ROOT, 0.0));
    }
}

/// Whether the workspace holds a stopped run of these rays.
fn holds(
    tree: &Tree,
    workspace: &Workspace,
    rays: &[Ray],
    mode: RayMode,
) -> Result<(), ResumeError> {
    workspace.run.holds_stopped(&key(tree))?;
    let state = &workspace.rays;
    let is_same = state.mode == mode
        && state.done + state.after + 1 == rays.len()
        && rays.get(state.done) == state.ray.as_ref();
    if is_same { Ok(()) } else { Err(ResumeError) }
}

/// Spends a budget on the run of these rays in the workspace. With why it ends, the parameter of the ray at hand before which no
/// hit is left to be found.
fn spend(
    tree: &Tree,
    workspace: &mut Workspace,
    rays: &[Ray],
    hits: &mut [Option<RayHit>],
    deadline: &mut Deadline,
) -> (StopReason, f64) {
    let done = workspace.rays.done.min(rays.len());
    if done == rays.len() {
        return (StopReason::Finished, f64::INFINITY);
    }
    if tree.nodes().is_empty() {
        hits[..rays.len()].fill(None);
        (workspace.rays.done, workspace.rays.after) = (rays.len(), 0);
        return (StopReason::Finished, f64::INFINITY);
    }
    let stop = if flushing::matters_to_rays(tree, &rays[done..]) {
        workspace.run.stopped = true;
        StopReason::FlushedToZero
    } else {
        let (mode, hit) = (workspace.rays.mode, workspace.rays.hit);
        let question = Cast::new(&rays[done..], mode, &mut hits[done..]);
        let beam = &mut workspace.rays.beam;
        beam.follow(tree.unit(), &rays[done]);
        if let (RayMode::Nearest, Some(hit)) = (mode, hit) {
            beam.cut(hit.t);
        }
        Traversal::new(
            question,
            [tree; 2],
            &Pose::IDENTITY,
            &Relation::BLIND,
            workspace,
            deadline,
        )
        .advance()
    };
    workspace.run.took(deadline.elapsed());
    let state = &mut workspace.rays;
    if stop.is_final() {
        hits[state.done] = state.hit;
        state.done += 1;
        return (stop, f64::INFINITY);
    }
    let entries = workspace.front.iter().map(|pair| entry(&pair));
    let first = entries
        .chain(state.suspects.iter().map(|suspect| suspect.enter))
        .fold(f32::INFINITY, f32::min);
    let ray = &rays[state.done];
    state.ray = Some(*ray);
    (stop, Beam::new(tree.unit(), ray).t(first))
}

/// The answer of a ray query.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct RayCast {
    /// The nearest hit of those found; in [`RayMode::Any`] the one found.
    pub hit: Option<RayHit>,
    /// Hits found, resumed calls and drained hits included. In [`RayMode::Nearest`] those that were compared.
    pub found: u64,
    /// Proven: every hit that was not found is at this parameter or after it. In [`RayMode::Nearest`] never after the hit that
    /// was found, in [`RayMode::Any`] with a hit the least parameter that was asked for. Infinite if there is none.
    #[cfg_attr(feature = "serde", serde(with = "crate::math::bound"))]
    pub free_until: f64,
    /// Why the query returned.
    pub stop: StopReason,
    /// What it has done.
    pub stats: Stats,
}

/// The answer for many rays; their hits are in the caller's slice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct RayBatchOutcome {
    /// The first so many rays are done and their hits are written.
    pub done: usize,
    /// Why it returned.
    pub stop: StopReason,
    /// What it has done for all rays.
    pub stats: Stats,
}
