//! Questions about a scene between frames. Which body does a ray hit ([`ray`])? Which does a moving
//! shape hit, which does a shape meet, and which is the closest to it ([`shape`])? How far may a
//! body move ([`stride`])?
//!
//! Each question is a [`Probe`]: it has a lower bound for all that is in a box, and asks one body
//! at a time. One walk through the tree of fat AABBs and the trees of the bodies, in the order of
//! these bounds, serves all of them.

mod line;
mod path;
pub(crate) mod ray;
pub(crate) mod shape;
mod stride;

use super::Scene;
use super::body::{Bodies, Placed};
use super::broad::Broad;
use super::broad::bounds::thickened;
use super::error::SceneError;
use super::filter::Filter;
use super::id::BodyId;
use crate::cost::{WORK_PER_BOX, WORK_PER_SEARCH};
use alloc::boxed::Box;
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::prediction::MAX_STEP_WORK;
use punctual::{StopReason, Tree, Workspace};
use punctual_geom::Aabb;
use ray::{BodyHit, SceneCast};
use shape::BodyOverlap;

/// The region that matters to a question, and the order in which it is searched.
trait Region {
    fn sight(&self) -> &Sight;

    /// A nonnegative lower bound for everything in a box, which is that of a body or of several;
    /// `None` if nothing in it matters.
    fn bound(&self, bounds: &Aabb, is_body: bool) -> Option<f64>;
}

/// A question about the bodies of a scene.
trait Probe: Region {
    /// Least work that is useful to the question about a body.
    const LEAST_WORK: u64;

    /// True if nothing with this lower bound matters any more.
    fn is_over(&self, bound: f64) -> bool;

    /// Asks the question about a body. Returns the reason why its run ended, and a lower bound for
    /// the part of the answer that is open.
    fn ask(
        &mut self,
        body: (BodyId, &Placed),
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(StopReason, f64), SceneError>;
}

/// Selects the bodies that are asked about: those that a body with this filter may meet. If `body`
/// is set, only other bodies that it may meet.
#[derive(Clone, Copy, Debug, Default)]
struct Sight {
    filter: Filter,
    body: Option<BodyId>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Body(u32),
    /// A node of the tree of fat AABBs.
    Node(u32),
}

/// Nodes and bodies that wait for a probe, with the bits of their lower bounds, which are not
/// negative; the least first.
type Queue = BinaryHeap<Reverse<(u64, What)>>;

/// The buffers of one thread.
#[derive(Debug, Default)]
struct Caster {
    queue: Queue,
    /// The hits of the last cast with [`RayMode::All`](punctual::rays::RayMode::All).
    hits: Vec<BodyHit>,
}

/// The buffers of all questions, and their last answers.
#[derive(Debug, Default)]
pub(crate) struct Casts {
    own: Caster,
    #[cfg(feature = "parallel")]
    others: Vec<(Caster, Box<Workspace>)>,
    answers: Vec<SceneCast>,
    met: Vec<BodyOverlap>,
    undecided: Vec<BodyId>,
    /// A point at the origin, for shapes that are points.
    point: Option<Box<Tree>>,
}

impl Casts {
    /// Reserves room for the questions about a scene with this many bodies.
    pub fn reserve(&mut self, bodies: usize) {
        // The queue is empty between calls.
        self.own.queue.reserve_exact(room(bodies));
    }
}

/// Each body may wait in a node of the tree, and separately if it has left its fat AABB.
fn room(bodies: usize) -> usize {
    2 * bodies
}

impl Scene {
    fn walk(&mut self) -> (Walk<'_>, &mut Casts, &mut Workspace) {
        let walk = Walk {
            bodies: &self.bodies,
            broad: &self.broad,
        };
        (walk, &mut self.casts, &mut self.scratch)
    }
}

/// The bodies and the broad phase that a walk searches.
struct Walk<'s> {
    bodies: &'s Bodies,
    broad: &'s Broad,
}

/// The end of a walk.
struct Walked {
    /// Lower bound for everything that is left open; infinite if it is finished.
    open: f64,
    /// The reason why it ended.
    stop: StopReason,
    work: u64,
    elapsed: Option<Duration>,
    /// False if it ended before the roots were queued.
    has_begun: bool,
}

impl Walk<'_> {
    /// Asks about bodies in the order of their lower bounds, until no other matters or the deadline
    /// comes.
    fn run<P: Probe>(
        &self,
        probe: &mut P,
        queue: &mut Queue,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<Walked, SceneError> {
        if let Some(id) = probe.sight().body {
            self.bodies.get(id)?;
        }
        deadline.leave(MAX_STEP_WORK);
        let limit = deadline.work_left();
        queue.clear();
        queue.reserve_exact(room(self.bodies.room()));
        let (mut open, mut stop) = (f64::INFINITY, StopReason::Finished);
        let has_begun = self.begin(probe, queue, deadline);
        if !has_begun {
            (open, stop) = (0.0, deadline.why(WORK_PER_BOX));
        }
        while matches!(stop, StopReason::Finished | StopReason::FlushedToZero)
            && let Some(&Reverse((bound, what))) = queue.peek()
            && !probe.is_over(f64::from_bits(bound))
        {
            let least = match what {
                What::Node(_) => WORK_PER_SEARCH,
                What::Body(_) => P::LEAST_WORK,
            };
            if !deadline.has_room(least) {
                stop = deadline.why(least);
                break;
            }
            queue.pop();
            match what {
                What::Node(node) => {
                    deadline.spend(WORK_PER_SEARCH);
                    self.open(probe, queue, node);
                }
                What::Body(body) => {
                    if let Some(placed) = self.bodies.at(body) {
                        let asked = (self.bodies.id(body), placed);
                        let (ended, left) = probe.ask(asked, workspace, deadline)?;
                        if ended != StopReason::Finished {
                            (open, stop) = (open.min(left), ended);
                        }
                    }
                }
            }
        }
        if stop != StopReason::Finished
            && let Some(&Reverse((next, _))) = queue.peek()
        {
            open = open.min(f64::from_bits(next));
        }
        Ok(Walked {
            open,
            stop,
            work: limit - deadline.work_left(),
            elapsed: deadline.elapsed(),
            has_begun,
        })
    }

    /// Queues the roots, and the bodies that are not in the tree. False if the budget did not
    /// suffice.
    fn begin(&self, probe: &impl Region, queue: &mut Queue, deadline: &mut Deadline) -> bool {
        let mut queue_body = |index: u32| {
            let is_changed = self.bodies.facts(index).is_changed();
            let work = if is_changed {
                WORK_PER_BOX
            } else {
                WORK_PER_SEARCH
            };
            if !deadline.has_room(work) {
                return false;
            }
            deadline.spend(work);
            if let Some(Placed { body, .. }) = self.bodies.at(index) {
                let bounds = match is_changed {
                    true => thickened(body.tree.aabb_at(&body.pose), body.margin),
                    false => *self.bodies.bounds(index),
                };
                self.push(probe, queue, index, &bounds);
            }
            true
        };
        let Some(tree) = self.broad.tree() else {
            return self.bodies.slots().all(queue_body);
        };
        let is_settled = |&body: &u32| !self.bodies.facts(body).is_changed();
        let unsettled = self.broad.unsettled().filter(is_settled);
        let has_room = self.bodies.pending().chain(unsettled).all(&mut queue_body);
        let roots = tree.roots().filter(|_| has_room);
        queue.extend(roots.filter_map(|(root, bounds)| entry(probe, What::Node(root), bounds)));
        has_room
    }

    /// Replaces a node by its children, or a leaf by its body.
    fn open(&self, probe: &impl Region, queue: &mut Queue, node: u32) {
        match self.broad.tree().map(|tree| tree.below(node)) {
            Some(Ok(children)) => queue.extend(
                children
                    .into_iter()
                    .filter_map(|(child, bounds)| entry(probe, What::Node(child), bounds)),
            ),
            Some(Err(body))
                if !self.bodies.facts(body).is_changed() && !self.broad.is_unsettled(body) =>
            {
                self.push(probe, queue, body, self.bodies.bounds(body));
            }
            _ => {}
        }
    }

    /// Queues a body if it is to be asked about.
    fn push(&self, probe: &impl Region, queue: &mut Queue, index: u32, bounds: &Aabb) {
        let Sight { filter, body } = probe.sight();
        let may_meet = |id: BodyId| id.index != index && self.bodies.may_meet([id.index, index]);
        if filter.meets(self.bodies.facts(index).filter) && body.is_none_or(may_meet) {
            queue.extend(entry(probe, What::Body(index), bounds));
        }
    }
}

fn entry(probe: &impl Region, what: What, bounds: &Aabb) -> Option<Reverse<(u64, What)>> {
    let bound = probe.bound(bounds, matches!(what, What::Body(_)))?;
    Some(Reverse((bound.to_bits(), what)))
}
