//! Ray casts: a tree, a ray and a budget in, [`RayBounds`] out; and batches of rays.
//!
//! [`cast`] is the question that the traversal answers, and [`state`] what is kept between calls.

mod cast;
pub(crate) mod state;

use crate::engine::boxes::{RelativePose, flushing};
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::memory::PairMemory;
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Query, Question};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::batch::{Batch, rays_left};
use crate::model::prediction::Quantiles;
use crate::query::points;
use crate::tree::Tree;
use crate::tree::solid::local_ray::LocalRay;
use cast::{Cast, ROOT};
use core::slice;
use punctual_geom::{Pose, Ray};
use state::RayState;
pub use state::{RayHit, RayMode};

/// Asks what a ray or a segment hits ([`Query::ray`]).
///
/// **Guarantee.** A triangle is hit if it shares a point with the ray, exactly for the coordinates
/// as given. Triangles are closed, edges and corners included, so no ray passes between triangles
/// that share an edge. A degenerate triangle is the hull of its points. A triangle in whose plane
/// the ray lies is hit where the ray enters it. Whenever the query stops, every hit not found is at
/// [`RayBounds::free_until`] or after it. The nearest hit is the one with the least reported `t`
/// ([`RayHit::t`]), of equal ones the one with the least id. So two hits that are closer together
/// than the error of `t` may change places. Of a tree with a [radius](Tree::with_radius), the ray
/// hits each triangle thickened by the radius; a ray that misses it by less than 1e-12 of the size
/// counts as a hit. The answer does not depend on budgets, machines or the shape of the tree.
///
/// ```
/// use punctual::{Budget, Query, Ray, Tree, Workspace, shapes};
/// use punctual::rays::Side;
/// let ball = Tree::new(shapes::icosphere(4));
/// let ray = Ray::new([0.1, 0.2, 9.0], [0.0, 0.0, -2.0])?;
/// let cast = Query::ray(&ball, ray).run(&mut Workspace::new(), Budget::unlimited()).value;
/// let hit = cast.hit.expect("the ray comes through the ball");
/// assert!(ray.at(hit.t).length() < 1.0 && hit.side == Side::Front && cast.free_until == hit.t);
/// # Ok::<(), punctual::geom::RayError>(())
/// ```
///
/// A ray has no certificate: [`RayBounds::free_until`] bounds what a stopped cast has missed.
///
/// ```compile_fail,E0277
/// # use punctual::{Query, Ray, Tree, Workspace, shapes};
/// # let (ball, ray) = (Tree::new(shapes::icosphere(1)), Ray::new([0.0; 3], [1.0; 3]).unwrap());
/// let _ = Query::ray(&ball, ray).certificate(&Workspace::new());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RayCast {
    ray: Ray,
    mode: RayMode,
    solid: bool,
}

impl Question for RayCast {
    /// The hits of [`RayMode::All`] are in [`Workspace::ray_hits`].
    type Value = RayBounds;
}

/// Room that the first query for all hits reserves in a workspace without any.
const DEFAULT_ROOM: usize = 4096;

impl<'t> Query<'t, RayCast> {
    /// Asks for the nearest hit of `ray`, which is in the frame of the tree's mesh.
    #[must_use]
    pub fn ray(tree: &'t Tree, ray: Ray) -> Self {
        let mode = RayMode::Nearest;
        let solid = false;
        Self::of([tree; 2], RayCast { ray, mode, solid })
    }

    /// Asks first whether the ray starts inside the solid ([`RayBounds::starts_inside`]), as
    /// [`Query::winding`] does for its origin. Needs a tree built as a solid; for others it is not
    /// known.
    ///
    /// ```
    /// use punctual::tree::Solid;
    /// use punctual::{Budget, BuildOptions, Query, Ray, Tree, Workspace, shapes};
    /// let solid = BuildOptions::default().solid(Solid::Keep);
    /// let ball = Tree::with_options(shapes::icosphere(4), &solid);
    /// let mut workspace = Workspace::new();
    /// for (x, inside) in [(0.5, true), (-1.5, false)] {
    ///     let query = Query::ray(&ball, Ray::new([x, 0.0, 0.0], [1.0, 0.0, 0.0])?).solid(true);
    ///     let cast = query.run(&mut workspace, Budget::unlimited()).value;
    ///     assert!(cast.starts_inside == Some(inside) && cast.hit.is_some());
    /// }
    /// # Ok::<(), punctual::geom::RayError>(())
    /// ```
    #[must_use]
    pub fn solid(mut self, solid: bool) -> Self {
        self.asked.solid = solid && self.a.solid().is_some();
        self
    }

    /// Sets whether to find the nearest hit, any, or all.
    #[must_use]
    pub fn mode(mut self, mode: RayMode) -> Self {
        self.asked.mode = mode;
        self
    }
}

impl Ask<RayCast> for Query<'_, RayCast> {
    fn key(&self) -> Key {
        key(self.a)
    }

    fn is_in(&self, workspace: &Workspace) -> bool {
        let RayCast { ray, mode, solid } = &self.asked;
        let points = &workspace.state.points;
        let origins = points.left + points.found.len();
        is_in(workspace, slice::from_ref(ray), *mode) && origins == usize::from(*solid)
    }

    fn begin(&self, workspace: &mut Workspace, _: Option<&PairMemory>, _: Budget) {
        begin(self.a, workspace, 1, self.asked.mode);
        if self.asked.solid {
            // The root follows when the origin is done.
            workspace.frontier.clear();
            let origin = self.asked.ray.origin().to_array();
            points::begin_points(self.a, workspace, slice::from_ref(&origin), false);
            workspace.state.rays.locates = true;
        }
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        _: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let RayCast { ray, mode, .. } = &self.asked;
        let rays = slice::from_ref(ray);
        if workspace.state.rays.locates {
            let origin = [ray.origin().to_array()];
            let stop = points::advance(self.a, workspace, &origin, deadline);
            if !stop.is_final() {
                workspace.state.rays.ray = Some(*ray);
                return stop;
            }
            workspace.state.rays.locates = false;
            push_root(self.a, workspace);
        }
        let stop = advance(self.a, workspace, rays, deadline);
        if *mode == RayMode::Any && workspace.state.rays.hit.is_some() && stop.is_final() {
            StopReason::FirstHit
        } else {
            stop
        }
    }

    fn answer(&self, workspace: &Workspace, stop: StopReason) -> RayBounds {
        let RayCast { ray, mode, .. } = &self.asked;
        let open = if stop.is_final() {
            f64::INFINITY
        } else if workspace.state.rays.locates {
            ray.limits()[0]
        } else {
            open_from(self.a, workspace, ray)
        };
        let hit = workspace.state.rays.hit;
        let free_until = mode.free_until(ray, hit, open);
        let origin = workspace.state.points.found.first();
        let starts_inside = origin.and_then(|found| found.inside);
        RayBounds {
            hit,
            free_until,
            starts_inside,
        }
    }

    fn left(&self, workspace: &Workspace, _: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let is_thorough = self.asked.mode == RayMode::All;
        (workspace.rays_left(self.a, 1, is_thorough), None)
    }
}

/// Asks for the nearest hit, or any, of each of many rays through one tree ([`Query::rays`]). The
/// rays are cast one after another within one budget. Takes less time per ray than [`Query::ray`].
///
/// ```
/// use punctual::{Budget, Query, Ray, Tree, Workspace, shapes};
/// let ball = Tree::new(shapes::icosphere(4));
/// let from = |i| [0.0, 0.3 * f64::from(i), 9.0];
/// let rays: Result<Vec<Ray>, _> = (0..9).map(|i| Ray::new(from(i), [0.0, 0.0, -1.0])).collect();
/// let (rays, mut workspace) = (rays?, Workspace::new());
/// let done = Query::rays(&ball, &rays).run(&mut workspace, Budget::unlimited()).value;
/// assert_eq!((done, workspace.first_hits().iter().flatten().count()), (9, 4));
/// # Ok::<(), punctual::geom::RayError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Rays<'r> {
    rays: &'r [Ray],
    mode: RayMode,
}

impl Question for Rays<'_> {
    /// Number of rays done, from the first; their hits are in [`Workspace::first_hits`].
    type Value = usize;
}

impl<'t, 'r> Query<'t, Rays<'r>> {
    /// Asks for the nearest hit of each ray, all in the frame of the tree's mesh. The first query
    /// for this many rays in a workspace allocates room for their hits, 32 bytes each.
    #[must_use]
    pub fn rays(tree: &'t Tree, rays: &'r [Ray]) -> Self {
        let mode = RayMode::Nearest;
        Self::of([tree; 2], Rays { rays, mode })
    }

    /// Asks for any hit of each ray.
    #[must_use]
    pub fn any(mut self) -> Self {
        self.asked.mode = RayMode::Any;
        self
    }
}

impl<'r> Ask<Rays<'r>> for Query<'_, Rays<'r>> {
    fn key(&self) -> Key {
        key(self.a)
    }

    fn is_in(&self, workspace: &Workspace) -> bool {
        is_in(workspace, self.asked.rays, self.asked.mode)
    }

    fn begin(&self, workspace: &mut Workspace, _: Option<&PairMemory>, _: Budget) {
        let count = self.asked.rays.len();
        begin(self.a, workspace, count, self.asked.mode);
        workspace.state.rays.first_hits.reserve_all(count);
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        _: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let stop = advance(self.a, workspace, self.asked.rays, deadline);
        if stop.is_final() {
            // The last hit; all of them if the mesh is empty.
            let RayState {
                first_hits, hit, ..
            } = &mut workspace.state.rays;
            first_hits.resize(self.asked.rays.len(), *hit);
        }
        stop
    }

    fn answer(&self, workspace: &Workspace, _: StopReason) -> usize {
        workspace.state.rays.done
    }

    fn left(&self, workspace: &Workspace, _: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let count = self.asked.rays.len();
        (workspace.rays_left(self.a, count, false), None)
    }
}

fn key(tree: &Tree) -> Key {
    Key::new([tree; 2], Pose::IDENTITY, Asked::Ray)
}

/// Prepares the workspace for the first of `count` rays.
fn begin(tree: &Tree, workspace: &mut Workspace, count: usize, mode: RayMode) {
    workspace.clear();
    workspace.run.begin(key(tree), Strategy::NONE);
    let state = &mut workspace.state.rays;
    (state.mode, state.radius) = (mode, tree.radius());
    if mode == RayMode::All && state.hits.capacity() == 0 {
        state.hits.reserve_all(DEFAULT_ROOM);
    }
    state.after = count.saturating_sub(1);
    if count > 0 {
        push_root(tree, workspace);
    }
}

fn push_root(tree: &Tree, workspace: &mut Workspace) {
    if !tree.nodes().is_empty() {
        workspace.frontier.push(ROOT);
    }
}

/// True if the last run in the workspace was of these rays: stopped at one of them, or finished
/// with the last.
fn is_in(workspace: &Workspace, rays: &[Ray], mode: RayMode) -> bool {
    let state = &workspace.state.rays;
    let current = state.done.min(rays.len().saturating_sub(1));
    state.mode == mode
        && (state.done + state.after + 1 == rays.len() || state.done == rays.len())
        && rays.get(current) == state.ray.as_ref()
}

impl Workspace {
    /// The work that a run of `count` rays has left.
    fn rays_left(&self, tree: &Tree, count: usize, is_thorough: bool) -> Quantiles {
        let done = self.state.rays.done.min(count);
        let batch = Batch {
            triangles: tree.mesh().len() as f64,
            done: done as f64,
            left: (count - done) as f64,
            work: self.work() as f64,
            is_thorough,
        };
        rays_left(&batch)
    }
}

/// Continues the run of these rays in the workspace until it is over or the deadline stops it. The
/// hit of the last ray is left in the state.
fn advance(
    tree: &Tree,
    workspace: &mut Workspace,
    rays: &[Ray],
    deadline: &mut Deadline,
) -> StopReason {
    let done = workspace.state.rays.done.min(rays.len());
    if done == rays.len() {
        return StopReason::Finished;
    }
    if tree.nodes().is_empty() {
        (workspace.state.rays.done, workspace.state.rays.after) = (rays.len(), 0);
        workspace.state.rays.ray = rays.last().copied();
        return StopReason::Finished;
    }
    let stop = if flushing::matters_to_rays(tree, &rays[done..]) {
        workspace.run.stopped = true;
        StopReason::FlushedToZero
    } else {
        let (mode, hit) = (workspace.state.rays.mode, workspace.state.rays.hit);
        let radius = workspace.state.rays.radius;
        let question = Cast::new(&rays[done..], mode);
        let local_ray = &mut workspace.state.rays.local_ray;
        local_ray.follow(tree.unit(), &rays[done], radius);
        if let (RayMode::Nearest, Some(hit)) = (mode, hit) {
            local_ray.cut(hit.t);
        }
        let (b_in_a, relative) = (&Pose::IDENTITY, &RelativePose::BLIND);
        traverse(question, [tree; 2], b_in_a, relative, workspace, deadline)
    };
    let state = &mut workspace.state.rays;
    state.ray = Some(rays[state.done]);
    if stop.is_final() {
        state.done += 1;
    }
    stop
}

/// Ray parameter before which the run in the workspace has left no hit to find.
fn open_from(tree: &Tree, workspace: &Workspace, ray: &Ray) -> f64 {
    let entries = workspace.frontier.iter().map(|pair| pair.key());
    let candidates = workspace.state.rays.candidates.iter();
    let candidates = candidates.map(|candidate| candidate.enter);
    let first = entries.chain(candidates).fold(f32::INFINITY, f32::min);
    LocalRay::near(tree.unit(), ray, workspace.state.rays.radius).t(first)
}

/// The answer to a ray query.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct RayBounds {
    /// The nearest of the hits found. In [`RayMode::Any`] the hit found.
    pub hit: Option<RayHit>,
    /// Proven: every hit not found is at this parameter or after it. In [`RayMode::Nearest`] it is
    /// at most the parameter of the hit found. In [`RayMode::Any`] with a hit it is the start of
    /// the ray's parameter range. Infinite if no hit is missing.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub free_until: f64,
    /// True if the ray starts inside the solid or on its surface, if that was asked
    /// ([`Query::solid`]) and is known.
    pub starts_inside: Option<bool>,
}

/// Casts a ray within the run of another question, or continues with it: the nearest hit of the
/// core.
///
/// # Errors
/// The reason why the deadline stopped it. Then the frontier holds the open nodes of the ray.
pub(crate) fn cast_alone(
    tree: &Tree,
    ray: &Ray,
    is_under_way: bool,
    workspace: &mut Workspace,
    deadline: &mut Deadline,
) -> Result<Option<RayHit>, StopReason> {
    if !is_under_way {
        workspace.state.rays.clear();
        workspace.state.rays.mode = RayMode::Nearest;
        if tree.nodes().is_empty() {
            return Ok(None);
        }
        workspace.frontier.push(ROOT);
    }
    let found = workspace.run.stats.found;
    let stop = advance(tree, workspace, slice::from_ref(ray), deadline);
    workspace.run.stats.found = found;
    if stop.is_final() {
        Ok(workspace.state.rays.hit)
    } else {
        Err(stop)
    }
}
