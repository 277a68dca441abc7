//! Time of impact: two trees, a motion and a budget in, a proven [`TimeOfImpact`] out.
//!
//! [`relative_motion`] cuts the motion into substeps that are nearly straight. For each substep the
//! traversal runs the question of [`sweep`], with the box test of [`windows`].
//! [`state`] holds what is proven so far, [`ahead`] bounds what is left, and [`estimate`] predicts
//! its cost.

pub(crate) mod ahead;
mod estimate;
mod relative_motion;
pub(crate) mod state;
mod sweep;
mod windows;

use crate::engine::boxes::RelativePose;
use crate::engine::certificate::Place;
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::frontier::Pair;
use crate::engine::memory::{PairMemory, Sought};
use crate::engine::options::{MotionOptions, OptionError, thickness};
use crate::engine::outcome::Operand;
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Certify, Query, Question, Remembers};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse;
use crate::engine::triangles::ids;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::cost::WORK_PER_SUBSTEP;
use crate::model::prediction::Quantiles;
use crate::query::distance::search::Bounded;
use crate::tree::Tree;
use punctual_geom::{Motion, Pose, smaller};
use relative_motion::{RelativeMotion, Setting, Substep};
use sweep::Sweep;
use windows::glide;

/// Asks until when a motion is free, and when the surfaces meet: continuous collision detection
/// ([`Query::impact`]).
///
/// **Guarantee.** Whenever it stops, the surfaces meet at no time before `lower`, and they do meet
/// at `upper`: two named triangles intersect exactly at the pose of that time ([`Query::pose`]).
/// `lower` only grows, and `upper` only falls. A finished query has found a contact no later than
/// the tolerance after `lower`, or none; then the motion is free to its end, time 1.
///
/// There is one exception: grazes. Surfaces may come within a few tolerances of each other, or
/// within the rounding of their coordinates. Or they may meet so briefly, or in so small a place,
/// that no pose in `f64` shows it, such as a point that passes through a triangle. Then `lower`
/// stays at that time, and the query goes on searching for a contact that it can prove. `upper` may
/// be later than `lower` by more than the tolerance, or `None` although `lower` is less than 1.
/// Both bounds still hold. This applies to all surfaces for which squares of lengths overflow, from
/// 1e154 on.
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Budget, Motion, Pose, Query, Tree, Workspace, shapes};
/// let wall = Tree::new(shapes::cuboid([5.0, 5.0, 0.01], 4));
/// let ball = Tree::new(shapes::icosphere(3));
/// let start = Pose::new(DMat3::IDENTITY, DVec3::new(0.0, 0.0, 50.0))?;
/// let motion = Motion::straight(start, [0.0, 0.0, -100.0])?;
/// let query = Query::impact(&wall, &ball, motion);
/// let found = query.run(&mut Workspace::new(), Budget::unlimited()).value;
/// assert!(found.lower < 0.49 && found.upper.unwrap() - found.lower < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    options: MotionOptions,
}

impl Question for Impact {
    type Value = TimeOfImpact;
}

impl Remembers for Impact {}

/// The default tolerance, relative to the unit of the smaller mesh.
const DEFAULT_TOLERANCE: f64 = 2e-6;

/// The least tolerance in time.
const LEAST_TOLERANCE: f64 = 4.0 * f64::EPSILON;

impl<'t> Query<'t, Impact> {
    /// Asks when the meshes of `a` and `b` meet, where `b_in_a` is the motion of B in A from time 0
    /// to 1.
    ///
    /// The tolerance is a length. Its default is two millionths of the smaller mesh's unit
    /// ([`Tree::unit_length`], about half of its longest extent) and radius, but at least the
    /// rounding of coordinates. For a point, the margin counts as its unit; for a point without a
    /// margin, the default is a millionth of the other mesh's unit.
    #[must_use]
    #[inline]
    pub fn impact(a: &'t Tree, b: &'t Tree, b_in_a: Motion) -> Self {
        let options = MotionOptions {
            of_a: None,
            of_b: b_in_a,
            length: None,
            time: 0.0,
            margin: a.radius() + b.radius(),
        };
        Self::of([a, b], Impact { options })
    }

    /// Asks when two moving bodies meet. Both motions are in the world or any other common frame.
    #[must_use]
    #[inline]
    pub fn impact_of_both(trees: [&'t Tree; 2], motions: [Motion; 2]) -> Self {
        let ([a, b], [of_a, of_b]) = (trees, motions);
        let mut query = Self::impact(a, b, of_b);
        query.asked.options.of_a = Some(of_a);
        query
    }

    /// The query is finished when no point of B moves farther than this, seen from A, between the
    /// two times. NaN counts as 0: as close as `f64` can resolve.
    #[must_use]
    #[inline]
    pub fn tolerance(mut self, length: f64) -> Self {
        OptionError::note(&mut self.fault, "tolerance", length, f64::MAX);
        self.asked.options.length = Some(length.max(0.0));
        self
    }

    /// The query is finished also when the two times differ by at most this. Negative values and
    /// NaN count as 0.
    #[must_use]
    #[inline]
    pub fn time_tolerance(mut self, time: f64) -> Self {
        OptionError::note(&mut self.fault, "time_tolerance", time, f64::MAX);
        self.asked.options.time = if time > 0.0 { time.min(1.0) } else { 0.0 };
        self
    }

    /// Thickens each surface by its margin, beside its [radius](Tree::with_radius). A margin is in
    /// the length unit of the meshes, not negative, at most 2^1000; NaN counts as 0. A point
    /// becomes a ball, a segment a capsule.
    #[must_use]
    #[inline]
    pub fn margins(mut self, margins: [f64; 2]) -> Self {
        OptionError::note_margins(&mut self.fault, margins);
        let [a, b] = margins.map(thickness);
        self.asked.options.margin = (a + self.a.radius()) + (b + self.b.radius());
        self
    }

    /// The pose of B in A at a time, 0 to 1, with the bits that the query uses.
    #[must_use]
    pub fn pose(&self, time: f64) -> Pose {
        self.relative_motion().pose(time)
    }

    /// The time until which B's points cannot have moved as far as the known clearance at the
    /// start.
    fn clear_until(&self, relative_motion: &RelativeMotion, memory: &PairMemory) -> f64 {
        let known = memory.clearance(self.a, self.b, &relative_motion.pose(0.0));
        let way = known - self.asked.options.margin - 4.0 * relative_motion.rounding;
        if way > 0.0 {
            smaller(way * (1.0 - 1e-9) / relative_motion.speed, 1.0)
        } else {
            0.0
        }
    }

    /// Proven upper bound, from the run in the workspace, of the distance of the first contact's
    /// triangles at its time. 0 only if they intersect.
    pub fn witness_distance(&self, workspace: &Workspace) -> f64 {
        let contact = workspace.state.motion.contact();
        contact.map_or(f64::INFINITY, |contact| contact.distance)
    }

    fn relative_motion(&self) -> RelativeMotion<'_> {
        RelativeMotion::new(
            self.a,
            self.b,
            self.asked.options.of_a.as_ref(),
            &self.asked.options.of_b,
        )
    }

    /// Half of the tolerance: a contact is searched for up to this long after the time at which it
    /// is possible. Contacts that are possible up to this much earlier do not matter then, so that
    /// neighbors that meet at the same time are not tested one by one.
    fn tolerance_in_time(&self, relative_motion: &RelativeMotion) -> f64 {
        let length = self
            .asked
            .options
            .length
            .unwrap_or_else(|| self.default_tolerance());
        // A time cannot be resolved better than the positions.
        let time = self
            .asked
            .options
            .time
            .max(length.max(8.0 * relative_motion.rounding) / relative_motion.speed);
        0.5 * if time > LEAST_TOLERANCE {
            time.min(1.0)
        } else {
            LEAST_TOLERANCE
        }
    }

    fn default_tolerance(&self) -> f64 {
        let sizes = [self.a, self.b].map(|tree| {
            if tree.size() > 0.0 {
                tree.size()
            } else {
                self.asked.options.margin
            }
        });
        let least = smaller(sizes[0], sizes[1]);
        DEFAULT_TOLERANCE
            * if least > 0.0 {
                least
            } else {
                0.5 * (sizes[0] + sizes[1])
            }
    }

    fn spend_on_substep(
        &self,
        relative_motion: &RelativeMotion,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> StopReason {
        let substep = relative_motion.substep(workspace.state.motion.substep);
        let trees = [self.a, self.b];
        if relative_motion.is_clear(&substep, trees, self.asked.options.margin) {
            workspace.frontier.clear();
            workspace.state.distance.clear();
            workspace.state.motion.followed = None;
            let end = deadline.step(workspace, |workspace, _| {
                workspace.run.stats.work += WORK_PER_SUBSTEP;
                workspace.bound_motion(&substep);
                Ok(())
            });
            workspace.run.stopped = end.is_err();
            return end.err().unwrap_or(StopReason::Finished);
        }
        let relative = RelativePose::new(self.a, self.b, &substep.pose);
        let setting = Setting {
            relative_motion,
            substep: &substep,
            margin: self.asked.options.margin,
        };
        let glide = glide(&setting, &relative, self.a.unit().origin);
        let question = Sweep::new(setting, &workspace.state.motion, &glide);
        let stop = traverse(
            question,
            trees,
            &substep.pose,
            &relative,
            workspace,
            deadline,
        );
        workspace.bound_motion(&substep);
        stop
    }
}

impl Ask<Impact> for Query<'_, Impact> {
    fn key(&self) -> Key {
        Key::new(
            [self.a, self.b],
            self.asked.options.of_b.start(),
            Asked::Motion,
        )
    }

    fn is_in(&self, workspace: &Workspace) -> bool {
        workspace.state.motion.options == Some(self.asked.options)
    }

    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, _: Budget) {
        let relative_motion = &self.relative_motion();
        workspace.clear();
        workspace.run.begin(self.key(), Strategy::NONE);
        let is_empty = self.a.nodes().is_empty() || self.b.nodes().is_empty();
        let free_until = if is_empty {
            1.0
        } else {
            memory.map_or(0.0, |memory| self.clear_until(relative_motion, memory))
        };
        workspace.state.motion.begin(
            &self.asked.options,
            self.tolerance_in_time(relative_motion),
            free_until,
        );
        workspace.state.motion.substep = relative_motion.substep_at(free_until);
        if workspace.state.motion.substep < relative_motion.substeps {
            workspace.begin_substep(memory.and_then(|memory| memory.nearest(self.a, self.b)));
        }
    }

    /// Runs substep after substep.
    fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let relative_motion = &self.relative_motion();
        let start = || relative_motion.pose(0.0);
        if let Some(stop) = self.containment_first(start, workspace, deadline) {
            return stop;
        }
        let mut stop = StopReason::Finished;
        while workspace.state.motion.substep < relative_motion.substeps {
            stop = self.spend_on_substep(relative_motion, workspace, deadline);
            if !stop.is_final() || workspace.state.motion.contact().is_some() {
                break;
            }
            workspace.state.motion.substep += 1;
            if workspace.state.motion.substep < relative_motion.substeps {
                workspace.begin_substep(None);
            }
        }
        if workspace.state.motion.substep == relative_motion.substeps {
            workspace.state.motion.end();
        }
        if let Some(memory) = memory {
            let contact = workspace.state.motion.contact();
            let work = stop.is_final().then_some(workspace.work());
            memory.remember_motion(self.a, self.b, contact.map(|contact| contact.pair), work);
            memory.learn(Sought::Motion, workspace, workspace.work(), stop.is_final());
        }
        stop
    }

    fn answer(&self, workspace: &Workspace, _: StopReason) -> TimeOfImpact {
        let state = &workspace.state.motion;
        let within = workspace.run.containment.inner();
        if self.is_open_in(workspace) {
            return TimeOfImpact {
                lower: 0.0,
                upper: within.map(|_| 0.0),
                triangles: None,
                within,
            };
        }
        let contact = state.contact();
        TimeOfImpact {
            lower: state.free_until(),
            upper: contact.map(|contact| contact.time),
            triangles: contact.map(|contact| ids([self.a, self.b], contact.pair)),
            within,
        }
    }

    fn left(&self, workspace: &Workspace, memory: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let state = &workspace.state.motion;
        let touching_at = state.contact().map(|contact| contact.time);
        let passing = self.passing(workspace.work(), state.free_until(), touching_at);
        (self.work_left(&passing, memory), None)
    }
}

impl Certify<Impact> for Query<'_, Impact> {
    fn place(&self, _: &Workspace) -> Place<'_> {
        Place::Moving(&self.asked.options)
    }
}

impl Workspace {
    /// Prepares the buffers for a substep of a motion. `guess` is a pair of triangles that may meet
    /// in it.
    fn begin_substep(&mut self, guess: Option<[u32; 2]>) {
        self.frontier.clear();
        self.state.distance.begin_pairs(guess.map(|pair| Bounded {
            pair,
            low: f32::NEG_INFINITY,
        }));
        self.testing = guess.is_some();
        self.frontier.push(Pair::new(0, 0));
    }

    /// Raises the time that is proven free to the least time of the pairs left of a substep.
    fn bound_motion(&mut self, substep: &Substep) {
        let (frontier, distance) = (&self.frontier, &self.state.distance);
        (self.state.motion).bound(frontier, distance, substep, f32::INFINITY);
    }
}

/// The answer to a motion query; times from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct TimeOfImpact {
    /// Proven: the surfaces meet at no time before. If it is 1 and [`TimeOfImpact::upper`] is
    /// `None`, the motion is free to its end.
    pub lower: f64,
    /// Proven: the surfaces meet at this time; 0 if they meet at the start. `None` if no contact
    /// was found (yet).
    pub upper: Option<f64>,
    /// The triangles that meet at `upper`: triangle of A, triangle of B, ids of the input meshes.
    pub triangles: Option<[u32; 2]>,
    /// Proven: this body, a solid, begins with a vertex inside the other, a closed solid. Then
    /// `upper` is 0, and `triangles` is `None`. `None` for surfaces.
    pub within: Option<Operand>,
}
