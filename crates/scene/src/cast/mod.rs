//! Casts a ray: through the tree of fat AABBs and the trees of the bodies, in the order in which
//! the ray enters them.

mod line;
pub(crate) mod ray;

use super::Scene;
use super::body::Bodies;
use super::broad::Broad;

use super::error::SceneError;
use crate::cost::{WORK_PER_BOX, WORK_PER_SEARCH};
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;
use line::Line;
use punctual::clock::ClockedBudget;
use punctual::engine::{Ask, Deadline};
use punctual::prediction::MAX_STEP_WORK;
use punctual::rays::RayMode;
use punctual::{Budget, Query, StopReason, Workspace};
use punctual_geom::Aabb;
use ray::{BodyHit, SceneCast, SceneRay};

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
    /// [`SceneError::NoRay`].
    pub fn cast<'c>(
        &mut self,
        ray: &SceneRay,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<SceneCast, SceneError> {
        self.cast_within(ray, budget.into())
    }

    fn cast_within(
        &mut self,
        ray: &SceneRay,
        budget: ClockedBudget<'_>,
    ) -> Result<SceneCast, SceneError> {
        let Self {
            bodies,
            broad,
            scratch,
            rays,
            ..
        } = self;
        // A rejected cast keeps the hits of the cast before.
        let before = rays.hits.len();
        let cast = Casting {
            asked: ray,
            bodies,
            broad,
            workspace: scratch,
            rays,
        }
        .run(budget);
        match cast {
            Ok(_) => drop(rays.hits.drain(..before)),
            Err(_) => rays.hits.truncate(before),
        }
        rays.hits.reserve(rays.hits.len());
        cast
    }

    /// The hits of the last cast with [`RayMode::All`]: body after body, each in order of
    /// discovery.
    pub fn ray_hits(&self) -> &[BodyHit] {
        &self.rays.hits
    }
}

/// A node or body that waits for a ray. Sorted by the parameter of entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// The bits of the parameter of entry, which is not negative.
    enter: u64,
    what: What,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Body(u32),
    /// A node of the tree of fat AABBs.
    Node(u32),
}

/// The buffers of casts.
#[derive(Debug, Default)]
pub(crate) struct Rays {
    queue: BinaryHeap<Reverse<Entry>>,
    /// The hits of the last cast with [`RayMode::All`].
    pub hits: Vec<BodyHit>,
}

/// One cast.
struct Casting<'c> {
    asked: &'c SceneRay,
    bodies: &'c Bodies,
    broad: &'c Broad,
    workspace: &'c mut Workspace,
    rays: &'c mut Rays,
}

impl Casting<'_> {
    fn run(mut self, budget: ClockedBudget<'_>) -> Result<SceneCast, SceneError> {
        let mut deadline = Deadline::of(budget);
        deadline.leave(MAX_STEP_WORK);
        let limit = deadline.work_left();
        self.rays.queue.clear();
        self.rays.reserve(self.bodies.room());
        let free_until = f64::INFINITY;
        let mut known = SceneCast {
            hit: None,
            found: 0,
            free_until,
            stop: StopReason::Finished,
            work: 0,
            elapsed: None,
        };
        let line = Line::new(&self.asked.ray);
        if self.begin(&line, &mut deadline) {
            self.search(&line, &mut known, &mut deadline)?;
        } else {
            known.free_until = 0.0;
            known.stop = deadline.why(WORK_PER_BOX);
        }
        let next = self
            .rays
            .queue
            .peek()
            .map_or(f64::INFINITY, |Reverse(entry)| f64::from_bits(entry.enter));
        let open = if known.stop == StopReason::Finished {
            f64::INFINITY
        } else {
            known.free_until.min(next)
        };
        known.free_until =
            self.asked
                .mode
                .free_until(&self.asked.ray, known.hit.map(|hit| hit.on_body), open);
        (known.work, known.elapsed) = (limit - deadline.work_left(), deadline.elapsed());
        Ok(known)
    }

    /// Queues the roots, and the bodies that are not in the tree. False if the budget did not
    /// suffice.
    fn begin(&mut self, line: &Line, deadline: &mut Deadline) -> bool {
        let Self {
            bodies,
            broad,
            rays,
            ..
        } = self;
        for index in bodies.pending() {
            if !deadline.has_room(WORK_PER_BOX) {
                return false;
            }
            deadline.spend(WORK_PER_BOX);
            if let Some(placed) = bodies.at(index) {
                rays.push(
                    line,
                    What::Body(index),
                    &placed.body.tree.aabb_at(&placed.body.pose),
                );
            }
        }
        let mut queue = |index: u32| {
            let has_room = deadline.has_room(WORK_PER_SEARCH);
            deadline.spend(WORK_PER_SEARCH);
            if has_room && !bodies.facts(index).is_changed() {
                rays.push(line, What::Body(index), bodies.bounds(index));
            }
            has_room
        };
        let Some(tree) = broad.tree() else {
            return bodies.slots().all(queue);
        };
        broad.unsettled().all(&mut queue) && {
            tree.roots()
                .for_each(|(root, bounds)| rays.push(line, What::Node(root), bounds));
            true
        }
    }

    /// Casts the ray until nothing nearer is left, or the deadline comes. Of the bodies already
    /// tested, no missing hit lies before `known.free_until`.
    fn search(
        &mut self,
        line: &Line,
        known: &mut SceneCast,
        deadline: &mut Deadline,
    ) -> Result<(), SceneError> {
        while let Some(&Reverse(entry)) = self.rays.queue.peek() {
            let is_nearer = |hit: BodyHit| hit.on_body.t < f64::from_bits(entry.enter);
            if self.asked.mode == RayMode::Nearest && known.hit.is_some_and(is_nearer) {
                break;
            }
            let least = if matches!(entry.what, What::Node(_)) {
                WORK_PER_SEARCH
            } else {
                MAX_STEP_WORK
            };
            if !deadline.has_room(least) {
                known.stop = deadline.why(least);
                return Ok(());
            }
            self.rays.queue.pop();
            match entry.what {
                What::Node(node) => {
                    deadline.spend(WORK_PER_SEARCH);
                    self.open(line, node);
                }
                What::Body(body) => self.ask(body, known, deadline)?,
            }
            if !matches!(known.stop, StopReason::Finished | StopReason::FlushedToZero) {
                break;
            }
        }
        Ok(())
    }

    /// Replaces a node by its children, or a leaf by its body.
    fn open(&mut self, line: &Line, node: u32) {
        let Some(tree) = self.broad.tree() else {
            return;
        };
        match tree.below(node) {
            Ok(children) => {
                children
                    .into_iter()
                    .for_each(|(child, bounds)| self.rays.push(line, What::Node(child), bounds));
            }
            Err(body) => {
                let facts = self.bodies.facts(body);
                let is_here = !facts.is_changed() && !self.broad.is_unsettled(body);
                if is_here && self.asked.filter.meets(facts.filter) {
                    self.rays
                        .push(line, What::Body(body), self.bodies.bounds(body));
                }
            }
        }
    }

    /// Casts the ray against the tree of a body.
    fn ask(
        &mut self,
        index: u32,
        known: &mut SceneCast,
        deadline: &mut Deadline,
    ) -> Result<(), SceneError> {
        let Self {
            asked,
            bodies,
            workspace,
            rays,
            ..
        } = self;
        let Some(placed) = bodies
            .at(index)
            .filter(|placed| asked.filter.meets(placed.body.filter))
        else {
            return Ok(());
        };
        let body = bodies.id(index);
        let here = asked
            .ray
            .transformed(&placed.inverse)
            .map_err(|error| SceneError::NoRay { body, error })?;
        let [from, to] = here.limits();
        let nearest = known.hit.filter(|_| asked.mode == RayMode::Nearest);
        let ray = here.within(from, nearest.map_or(to, |hit| to.min(hit.on_body.t)));
        let query = Query::ray(&placed.body.tree, ray).mode(asked.mode);
        query.begin(workspace, None, Budget::unlimited());
        let cast = loop {
            let cast = query.spend(workspace, None, deadline);
            rays.hits.extend(
                workspace
                    .drain_ray_hits()
                    .map(|on_body| BodyHit { body, on_body }),
            );
            if cast.stop != StopReason::PairsFull {
                break cast;
            }
        };
        known.found += cast.stats.found;
        if let Some(hit) = cast.value.hit.map(|on_body| BodyHit { body, on_body })
            && known.hit.is_none_or(|before| hit.is_before(&before))
        {
            known.hit = Some(hit);
        }
        if cast.stop != StopReason::Finished {
            known.stop = cast.stop;
            known.free_until = known.free_until.min(cast.value.free_until);
        }
        Ok(())
    }
}

impl Rays {
    /// Reserves room for the casts of a scene with this many bodies.
    pub fn reserve(&mut self, bodies: usize) {
        // Each body may wait in a node of the tree, and separately if it has left its fat AABB.
        self.queue
            .reserve_exact((2 * bodies).saturating_sub(self.queue.len()));
    }

    /// Queues a node or body if the ray enters its box.
    fn push(&mut self, line: &Line, what: What, bounds: &Aabb) {
        self.queue.extend(line.enter(bounds).map(|enter| {
            Reverse(Entry {
                enter: enter.to_bits(),
                what,
            })
        }));
    }
}
