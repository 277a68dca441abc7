//! Ray queries: a tree and a ray, or many, in; triangles and parameters out.

use crate::arrays::{array, find_room, room};
use crate::budget::{punctual_budget, punctual_clock};
use crate::estimate::{punctual_remaining, tell};
use crate::handle::get;
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::points::punctual_inside;
use crate::pose::punctual_point;
use crate::query::answer;
use crate::sized::read;
use crate::status::{Fault, given, value_of};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, lists, question, types};
use crate::workspace::punctual_workspace;
use core::mem::take;
use core::ptr::null;
use punctual::glam::DVec3;
use punctual::rays::{RayBounds, RayCast, RayHit, RayMode, Side};
use punctual::{Answer, Query, Ray, Tree};

/// The triangle of a ray that hits none.
pub const PUNCTUAL_NO_TRIANGLE: u32 = 0xFFFF_FFFF;

types! {
    /// Which of its hits a ray is asked for.
    enum punctual_ray_mode {
        /// The one with the least `t`; of several with the same, the triangle with the least id.
        Nearest = 0,
        /// Any: whether there is one. Stops at the first that is found.
        Any = 1,
        /// All, each triangle once; not for batches.
        All = 2,
    }

    /// The side of a triangle that a ray comes from.
    enum punctual_side from Side {
        /// The one from which the corners appear counterclockwise.
        Front = 0,
        /// The other one.
        Back = 1,
        /// None: the ray lies in the triangle's plane, or the triangle is a segment or a point.
        Edge = 2,
    }

    /// A half-line from an origin in a direction of any length, or a segment between two points, in
    /// the frame of the mesh. Plain data, made by `punctual_ray_new` or `punctual_ray_segment`;
    /// checked wherever it is used, and then used as it is.
    plain punctual_ray {
        /// Where it begins.
        origin: punctual_point,
        /// Its direction, not zero; of a segment, its end.
        target: punctual_point,
        /// Hits before this parameter are left out. 0 by default.
        t_min: f64,
        /// Hits after this parameter are left out. Infinity by default. To end exactly at a point,
        /// take a segment.
        t_max: f64,
        /// 0: a half-line; else a segment, of which `t` goes from 0 to 1.
        is_segment: u32,
    }

    /// A triangle that a ray meets.
    plain punctual_ray_hit from (hit: Option<RayHit>) {
        /// Id of the input mesh, or PUNCTUAL_NO_TRIANGLE.
        triangle: u32 = hit.map_or(PUNCTUAL_NO_TRIANGLE, |hit| hit.triangle),
        /// The side that the ray comes from; SIDE_FRONT without a hit.
        side: punctual_side = hit.map_or(Side::Front, |hit| hit.side).into(),
        /// The least parameter of a common point, which is `origin + t direction`, of a segment
        /// `origin + t (end - origin)`. Off by at most 1e-11 of the largest coordinate of the
        /// triangle seen from the origin, over the largest component of the direction. Infinite
        /// without a hit.
        t: f64 = hit.map_or(f64::INFINITY, |hit| hit.t),
    }

    /// The question what a ray hits. Plain data, made by `punctual_ray_query_new`, one for each
    /// ray; it borrows the tree. To resume a query all of it must be what it was.
    ///
    /// A triangle is hit if it shares a point with the ray, exactly for the coordinates as they are
    /// given: closed triangles, edges and corners included.
    asked punctual_ray_query<'t>(ray) {
        /// A `punctual_ray_mode`; RAY_MODE_NEAREST by default.
        mode: u32 = punctual_ray_mode::Nearest as u32,
        /// The tree.
        tree: Option<&'t punctual_tree> = None,
        /// The ray.
        ray: punctual_ray = punctual_ray_new(DVec3::ZERO.into(), DVec3::ZERO.into()),
        /// Not 0: ask whether the ray starts inside the solid, too. 0 by default.
        solid: u64 = 0,
    }

    /// The answer of a ray query, wherever it stopped. All hits stay in the workspace:
    /// `punctual_workspace_ray_hits`.
    told punctual_ray_cast(hit) from (cast: Answer<RayBounds>) {
        /// The nearest hit of those found; for RAY_MODE_ANY the one found.
        hit: punctual_ray_hit = cast.value.hit.into(),
        /// Hits found, resumed calls and drained hits included; for RAY_MODE_NEAREST those that
        /// were compared.
        found: u64 = cast.stats.found,
        /// Proven: every hit that was not found is at this parameter or after it. For
        /// RAY_MODE_NEAREST never after the hit that was found. Infinite if there is none.
        free_until: f64 = cast.value.free_until,
        /// Why the query returned.
        stop: punctual_stop_reason = cast.stop.into(),
        /// What it has done.
        stats: punctual_stats = cast.stats.into(),
        /// A `punctual_inside`: whether the ray starts inside the solid or on its surface;
        /// INSIDE_UNDECIDED if that was not asked, the tree was not built as a solid, or the budget
        /// ended first.
        starts_inside: u64 = punctual_inside::from(cast.value.starts_inside) as u64,
    }

    /// The question what each of many rays hits, answered one after the other within one budget, in
    /// less time than a query for each. Plain data, made by `punctual_ray_batch_new`; it borrows
    /// the tree and the rays. To resume it all of it, and the rays, must be what they were.
    asked punctual_ray_batch<'t>(count) {
        /// RAY_MODE_NEAREST, by default, or RAY_MODE_ANY.
        mode: u32 = punctual_ray_mode::Nearest as u32,
        /// The tree.
        tree: Option<&'t punctual_tree> = None,
        /// The rays.
        rays: *const punctual_ray = null(),
        /// How many.
        count: usize = 0,
    }

    /// The answer for many rays; their hits are in the caller's array.
    told punctual_ray_batch_outcome(done) from (outcome: Answer<usize>) {
        /// The first so many rays are done and their hits are written.
        done: usize = outcome.value,
        /// Why it returned.
        stop: punctual_stop_reason = outcome.stop.into(),
        /// What it has done for all rays.
        stats: punctual_stats = outcome.stats.into(),
    }
}

/// The half-line from a point in a direction. Checked when it is used.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_ray_new(
    origin: punctual_point,
    direction: punctual_point,
) -> punctual_ray {
    punctual_ray {
        origin,
        target: direction,
        t_min: 0.0,
        t_max: f64::INFINITY,
        is_segment: 0,
    }
}

/// The segment between two points, both of them included. Checked when it is used.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_ray_segment(from: punctual_point, to: punctual_point) -> punctual_ray {
    punctual_ray {
        is_segment: 1,
        ..punctual_ray_new(from, to)
    }
}

inits! {
    /// The question for the nearest hit of a ray. Checked when it is run.
    punctual_ray_query_init(
        query: punctual_ray_query<'t>, tree: Option<&'t punctual_tree>, ray: punctual_ray
    ) { tree, ray }
}

question! {
    punctual_ray_query(punctual_workspace) -> punctual_ray_cast {
        /// Runs a ray query within a budget. The first one for all hits in a workspace makes room
        /// for 4,096 hits, unless `punctual_workspace_reserve_ray_hits` has made some; nothing else
        /// allocates. It does not lock or panic.
        ///
        /// Under a time budget it returns at most one poll interval of work late, under a work
        /// budget at most PUNCTUAL_MAX_STEP_WORK units later.
        run punctual_ray_query_run;

        /// After PAIRS_FULL drain the hits or make room first. However it is cut into pieces by
        /// work budgets, the outcome at the end is that of one uninterrupted run.
        resume punctual_ray_query_resume;

        remaining punctual_ray_query_remaining;
    }
}

calls! {
    /// Forgets the hits, so that a query that stopped with PAIRS_FULL can be resumed. Copy them
    /// first.
    change punctual_workspace_drain_ray_hits(workspace: punctual_workspace) =
        drop(workspace.drain_ray_hits());

    /// Makes room for at least so many hits, 24 bytes each.
    ///
    /// Fails with OUT_OF_MEMORY if there is not that much.
    change punctual_workspace_reserve_ray_hits(workspace: punctual_workspace, hits: usize) = {
        find_room([(hits, size_of::<RayHit>())])?;
        workspace.reserve_ray_hits(hits)
    };
}

inits! {
    /// The question for the nearest hit of each of `count` rays. Checked when it is run.
    punctual_ray_batch_init(
        batch: punctual_ray_batch<'t>, tree: Option<&'t punctual_tree>,
        rays: *const punctual_ray, count: usize
    ) { tree, rays, count }
}

calls! {
    /// Runs many rays within a budget, and writes the hits of those that are done to `hits`, which
    /// has room for all. The first batch of so many rays in a workspace makes room for them, about
    /// 100 bytes each; later ones do not allocate. It does not lock or panic. `clock` may be null:
    /// the clock of the system.
    ///
    /// Fails with NULL, BAD_ARGUMENT, which names the ray, OUT_OF_MEMORY or POISONED before it has
    /// begun.
    unsafe fn punctual_ray_batch_run(
        batch: *const punctual_ray_batch<'_>, workspace: Option<&mut punctual_workspace>,
        budget: punctual_budget, clock: Option<&punctual_clock>, hits: *mut punctual_ray_hit,
        outcome: *mut punctual_ray_batch_outcome
    ) {
        // SAFETY: the contract of the header for arrays and clocks.
        unsafe { read(batch, "batch")?.spend(false, workspace, budget, clock, hits, outcome) }
    }

    /// Goes on with the stopped run that the workspace holds, with a fresh budget. The hits of all
    /// rays that are done are written, those of earlier calls again.
    ///
    /// Fails as `punctual_ray_batch_run`, and with NOT_RESUMABLE if the last run in this workspace
    /// was not of this very batch or is complete.
    unsafe fn punctual_ray_batch_resume(
        batch: *const punctual_ray_batch<'_>, workspace: Option<&mut punctual_workspace>,
        budget: punctual_budget, clock: Option<&punctual_clock>, hits: *mut punctual_ray_hit,
        outcome: *mut punctual_ray_batch_outcome
    ) {
        // SAFETY: the contract of the header for arrays and clocks.
        unsafe { read(batch, "batch")?.spend(true, workspace, budget, clock, hits, outcome) }
    }

    /// What the last run of this batch in the workspace has still to do. Takes time linear in the
    /// rays, which it copies.
    ///
    /// Fails as `punctual_ray_batch_run`, and with NOT_RESUMABLE if the last run in this workspace
    /// was not of this very batch.
    unsafe fn punctual_ray_batch_remaining(
        batch: *const punctual_ray_batch<'_>, workspace: Option<&punctual_workspace>,
        remaining: *mut punctual_remaining
    ) {
        let mut held = Rays::default();
        // SAFETY: the contract of the header for structs and arrays.
        unsafe {
            let batch = read(batch, "batch")?;
            held.read(array(batch.rays, batch.count, "batch->rays")?)?;
            tell(&batch.query(&held.rays)?, workspace, None, remaining)
        }
    }
}

/// The rays of a batch, as the library has them; kept in the workspace, so that batches do not
/// allocate.
#[derive(Debug, Default)]
pub(crate) struct Rays {
    rays: Vec<Ray>,
}

impl Rays {
    /// Takes the rays over.
    fn read(&mut self, rays: &[punctual_ray]) -> Result<(), Fault> {
        self.rays.clear();
        self.rays
            .try_reserve_exact(rays.len())
            .map_err(|_| Fault::OutOfMemory)?;
        for (index, ray) in rays.iter().enumerate() {
            self.rays.push(ray.check("batch->rays", Some(index))?);
        }
        Ok(())
    }
}

impl<'t> punctual_ray_batch<'t> {
    fn query<'r>(&self, rays: &'r [Ray]) -> Result<Query<'t, punctual::rays::Rays<'r>>, Fault> {
        let tree = get(self.tree, "batch->tree")?;
        match check_mode(self.mode, "batch->mode")? {
            RayMode::Nearest => Ok(Query::rays(tree, rays)),
            RayMode::Any => Ok(Query::rays(tree, rays).any()),
            RayMode::All => Err(Fault::Value("batch->mode", self.mode)),
        }
    }

    /// # Safety
    /// The contract of the header for the rays, the hits and the clock.
    unsafe fn spend(
        self,
        resumes: bool,
        workspace: Option<&mut punctual_workspace>,
        budget: punctual_budget,
        clock: Option<&punctual_clock>,
        hits: *mut punctual_ray_hit,
        outcome: *mut punctual_ray_batch_outcome,
    ) -> Result<(), Fault> {
        // The tree and the mode are checked first.
        self.query(&[])?;
        // SAFETY: the caller's promise.
        let (rays, written) = unsafe {
            (
                array(self.rays, self.count, "batch->rays")?,
                room(hits, self.count, "hits")?,
            )
        };
        let workspace = given(workspace, "workspace")?;
        let mut held = take(&mut workspace.1);
        let result = held.read(rays).and_then(|()| {
            // SAFETY: the caller's promise.
            unsafe {
                answer(
                    Some(workspace),
                    None,
                    budget,
                    clock,
                    outcome,
                    |workspace, _, budget| {
                        if held.rays.len() > workspace.first_hits().len() {
                            find_room([(held.rays.len(), size_of::<Option<RayHit>>())])?;
                        }
                        let batch = self.query(&held.rays)?;
                        let answer = if resumes {
                            batch.resume(workspace, budget)?
                        } else {
                            batch.run(workspace, budget)
                        };
                        for (place, &hit) in written.iter_mut().zip(workspace.first_hits()) {
                            place.write(hit.into());
                        }
                        Ok(answer)
                    },
                )
            }
        });
        workspace.1 = held;
        result
    }
}

impl punctual_ray {
    /// `what` and `index` name it for the error.
    pub(crate) fn check(&self, what: &'static str, index: Option<usize>) -> Result<Ray, Fault> {
        let [origin, target] = [self.origin, self.target].map(punctual_point::numbers);
        let ray = if self.is_segment != 0 {
            Ray::segment(origin, target)
        } else {
            Ray::new(origin, target)
        };
        Ok(ray
            .map_err(|error| Fault::Ray(what, index, error))?
            .within(self.t_min, self.t_max))
    }
}

impl<'t> punctual_ray_query<'t> {
    fn check(self) -> Result<Query<'t, RayCast>, Fault> {
        let tree: &'t Tree = get(self.tree, "query->tree")?;
        let query = Query::ray(tree, self.ray.check("query->ray", None)?);
        let query = query.mode(check_mode(self.mode, "query->mode")?);
        Ok(query.solid(self.solid != 0))
    }
}

pub(crate) fn check_mode(value: u32, what: &'static str) -> Result<RayMode, Fault> {
    value_of(value, what, &[RayMode::Nearest, RayMode::Any, RayMode::All])
}

lists! {
    /// The hits that the last query found, if it was a ray query for all hits, without those
    /// drained: in order of discovery, which is nearly that of `t`.
    list punctual_workspace_ray_hits(workspace: punctual_workspace) -> hits: punctual_ray_hit =
        workspace.ray_hits().iter().map(|&hit| Some(hit));
}
