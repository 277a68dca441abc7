//! Shapes in a scene: what one meets on its way, which bodies it meets, and which is the closest.

use super::path::Path;
use super::{Probe, Region, Sight, Walked, What};
use crate::Scene;
use crate::body::Placed;
use crate::checks;
use crate::cost::{LEAST_DISTANCE_WORK, WORK_PER_QUERY};
use crate::error::SceneError;
use crate::filter::Filter;
use crate::id::BodyId;
use crate::pair::question::Question;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cmp::Reverse;
use core::time::Duration;
use glam::{DMat3, DVec3};
use punctual::clock::ClockedBudget;
use punctual::engine::Deadline;
use punctual::tree::Solid;
use punctual::{BuildOptions, Mesh, Mode, PairMemory, Query, StopReason, Tree, Verdict, Workspace};
use punctual_geom::triangle::distance::{Closest as Nearest, closest};
use punctual_geom::{Aabb, Motion, MotionError, Pose, PoseError, triangle_segment};

/// A shape that asks about the bodies of a scene: a tree at a pose or in motion, or a point. It is
/// not itself in the scene.
///
/// The margins of bodies and of the shape count: a point with a margin is a ball. Without one, a
/// point that is cast passes through surfaces in no time, so only `free_until` tells of them: cast
/// a ray instead. Bodies are at the poses that were set last, as for [`Scene::cast`]; their motions
/// do not count. Sensors are bodies like others. A solid inside another solid meets it.
///
/// ```
/// use punctual::{Budget, Mode, Pose, Tree, shapes};
/// use punctual_scene::{Body, Scene, SceneShape};
/// use std::sync::Arc;
///
/// let mut scene = Scene::new();
/// let plate = Arc::new(Tree::new(shapes::cuboid([3.0, 3.0, 0.5], 4)));
/// let floor = scene.insert(Body::fixed(plate, Pose::IDENTITY))?;
///
/// // A ball of radius 1 falls from a height of 5.
/// let ball = SceneShape::point([0.1, 0.2, 5.0])?.margin(1.0);
/// let fall = scene.cast_shape(&ball.along([0.0, 0.0, -10.0])?, Budget::unlimited())?;
/// let hit = fall.hit.expect("the floor is in its way");
/// assert!(hit.body == floor && fall.free_until <= 0.35 && 0.35 <= fall.touching_at.unwrap());
/// assert!(hit.normal.unwrap().z > 0.999);
///
/// let closest = scene.closest(&ball, f64::INFINITY, Budget::unlimited())?;
/// assert!(closest.low <= 3.5 && 3.5 <= closest.high && closest.hit.unwrap().body == floor);
/// assert!(scene.overlap(&ball, Mode::All, Budget::unlimited())?.met.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct SceneShape<'t> {
    /// `None` for a point.
    tree: Option<&'t Tree>,
    motion: Motion,
    margin: f64,
    sight: Sight,
}

impl<'t> SceneShape<'t> {
    /// A tree at a pose, which maps the coordinates of its mesh to those of the scene.
    pub fn new(tree: &'t Tree, pose: Pose) -> Self {
        Self::moving(tree, Motion::still(pose))
    }

    /// A tree in motion, for [`Scene::cast_shape`]. Other questions are about its start.
    pub fn moving(tree: &'t Tree, motion: Motion) -> Self {
        Self {
            tree: Some(tree),
            ..Self::of(motion)
        }
    }

    /// A point in the coordinates of the scene.
    ///
    /// # Errors
    /// If a coordinate is not finite, or too large.
    pub fn point(point: impl Into<[f64; 3]>) -> Result<Self, PoseError> {
        Ok(Self::of(Motion::still(Pose::new(
            DMat3::IDENTITY,
            point.into(),
        )?)))
    }

    fn of(motion: Motion) -> Self {
        Self {
            tree: None,
            motion,
            margin: 0.0,
            sight: Sight::default(),
        }
    }

    /// Moves the shape on a straight line from its start, without rotation. `velocity` is the
    /// displacement until time 1.
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn along(self, velocity: impl Into<[f64; 3]>) -> Result<Self, MotionError> {
        let motion = Motion::straight(self.motion.start(), velocity)?;
        Ok(Self { motion, ..self })
    }

    /// Thickens it by a margin, in the length unit of the scene; 0 by default.
    pub fn margin(self, margin: f64) -> Self {
        Self { margin, ..self }
    }

    /// Restricts it to bodies that a body with this filter may meet; by default all.
    pub fn filter(mut self, filter: Filter) -> Self {
        self.sight.filter = filter;
        self
    }

    /// Restricts it to other bodies that this body may meet, as for a ray:
    /// [`SceneRay::of_body`](crate::SceneRay::of_body).
    pub fn of_body(mut self, body: BodyId) -> Self {
        self.sight.body = Some(body);
        self
    }
}

/// A body that a shape touches, or is closest to.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ShapeHit {
    /// The body.
    pub body: BodyId,
    /// Triangle of the body, triangle of the shape: ids of the input meshes. `None` if one is
    /// inside the other.
    pub triangles: Option<[u32; 2]>,
    /// The closest points of these triangles, of the body and of the shape, in the coordinates of
    /// the scene, each moved towards the other by its margin. One point if the triangles intersect.
    pub points: Option<[DVec3; 2]>,
    /// Unit vector from the body to the shape, between the points; `None` where the triangles
    /// intersect.
    pub normal: Option<DVec3>,
}

/// What a shape meets on its way: [`Scene::cast_shape`]. Times from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct ShapeCast {
    /// Proven: the shape meets no body before this time. 1 if it is free to the end of its motion.
    pub free_until: f64,
    /// Proven: it meets the body of `hit` at this time. `None` if no contact was found.
    pub touching_at: Option<f64>,
    /// The body that it meets then. Its points and normal are those just before.
    pub hit: Option<ShapeHit>,
    /// The reason why the call returned.
    pub stop: StopReason,
    /// Work of the call.
    pub work: u64,
    /// Time of the call; measured only under a time budget.
    pub elapsed: Option<Duration>,
}

/// The body closest to a shape: [`Scene::closest`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct Closest {
    /// Proven: no body is closer than this, margins subtracted. Infinite if there is none at all.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub low: f64,
    /// Proven: the distance of the body of `hit` is at most this; 0 if they meet. Infinite if none
    /// was found.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub high: f64,
    /// The closest body found.
    pub hit: Option<ShapeHit>,
    /// The reason why the call returned.
    pub stop: StopReason,
    /// Work of the call.
    pub work: u64,
    /// Time of the call; measured only under a time budget.
    pub elapsed: Option<Duration>,
}

/// A body that a shape meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyOverlap {
    /// The body.
    pub body: BodyId,
    /// The proof. Its first triangle, or its operand A, belongs to the body.
    pub verdict: Verdict,
}

/// The bodies that a shape meets: [`Scene::overlap`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Overlap<'s> {
    /// The bodies proven to meet it, by index.
    pub met: &'s [BodyOverlap],
    /// The bodies whose boxes overlap its own and that were not decided, by index. In
    /// [`Mode::Any`], none if a body meets it.
    pub undecided: &'s [BodyId],
    /// True if all other bodies are proven not to meet it. False if the budget ended before all
    /// boxes were compared, or if a first body was enough.
    pub is_whole: bool,
    /// The reason why the call returned.
    pub stop: StopReason,
    /// Work of the call.
    pub work: u64,
    /// Time of the call; measured only under a time budget.
    pub elapsed: Option<Duration>,
}

/// The question about a shape and a body.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Asked {
    /// The time at which they meet.
    Time,
    /// Their distance, if it is at most this.
    Distance(f64),
    /// Whether they meet.
    Meeting(Mode),
}

struct ShapeProbe<'q> {
    asked: Asked,
    shape: &'q SceneShape<'q>,
    tree: &'q Tree,
    path: Path,
    is_limited: bool,
    /// Bounds of the time or distance of the bodies asked about, and the body of the upper one.
    low: f64,
    high: f64,
    hit: Option<ShapeHit>,
    met: &'q mut Vec<BodyOverlap>,
    undecided: &'q mut Vec<BodyId>,
}

impl ShapeProbe<'_> {
    fn question<'b>(&'b self, body: &'b Placed) -> Question<'b> {
        let trees = [&*body.body.tree, self.tree];
        let margins = [body.body.margin, self.shape.margin];
        let b_in_a = body.relative_to(&self.shape.motion.start());
        let distance = Query::distance(trees[0], trees[1], b_in_a).margins(margins);
        match self.asked {
            Asked::Time => {
                let motions = [Motion::still(body.body.pose), self.shape.motion];
                Question::Motion(Query::impact_of_both(trees, motions).margins(margins))
            }
            Asked::Distance(_) => Question::Distance(distance.below(self.high)),
            Asked::Meeting(_) if margins == [0.0; 2] => {
                Question::Meet(Query::intersection(trees[0], trees[1], b_in_a))
            }
            Asked::Meeting(_) => Question::Distance(distance.closer_than(0.0)),
        }
    }

    /// The closest points of a triangle of a body and one of the shape at a time.
    fn hit(
        &self,
        (body, placed): (BodyId, &Placed),
        triangles: Option<[u32; 2]>,
        time: f64,
    ) -> ShapeHit {
        let mut hit = ShapeHit {
            body,
            triangles,
            points: None,
            normal: None,
        };
        if let Some([x, y]) = triangles {
            let (outer, mesh) = (&placed.body.pose, placed.body.tree.mesh());
            let b_in_a = placed.relative_to(&self.shape.motion.pose(time));
            let a = mesh.triangle(x as usize);
            let b = self.tree.mesh().triangle(y as usize);
            let b = b.map(|corner| b_in_a.transform_point(corner));
            let found = match triangle_segment(&a, &b) {
                Some(segment) => Nearest::meeting(segment),
                None => closest(&a, &b).of_apart(&a, &b),
            };
            let [p, q] = found.points;
            let of_body = placed.body.margin + placed.body.tree.radius();
            let of_shape = self.shape.margin + self.tree.radius();
            let [of_a, of_b] = [of_body, of_shape].map(|length| length * found.direction);
            hit.points = Some([p - of_a, q + of_b].map(|point| outer.transform_point(point)));
            hit.normal = (*outer.rotation() * -found.direction).try_normalize();
        }
        hit
    }
}

impl Region for ShapeProbe<'_> {
    fn sight(&self) -> &Sight {
        &self.shape.sight
    }

    fn bound(&self, bounds: &Aabb, is_body: bool) -> Option<f64> {
        let start = self.path.start();
        match self.asked {
            _ if start.is_empty() || bounds.is_empty() => None,
            Asked::Time => self.path.enter(bounds),
            Asked::Distance(most) => Some(self.path.apart(bounds)).filter(|&apart| apart <= most),
            // All bodies are found before the first is asked about; those that overlap most are
            // asked about first.
            Asked::Meeting(_) => start.intersects(bounds).then(|| {
                let common = start.intersection(bounds).extents();
                let share = common / start.extents().min(bounds.extents());
                if is_body {
                    (1.0 - share.element_product()).max(0.0)
                } else {
                    0.0
                }
            }),
        }
    }
}

impl Probe for ShapeProbe<'_> {
    const LEAST_WORK: u64 = LEAST_DISTANCE_WORK;

    fn is_over(&self, bound: f64) -> bool {
        !matches!(self.asked, Asked::Meeting(_)) && bound >= self.high
    }

    fn ask(
        &mut self,
        (body, placed): (BodyId, &Placed),
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(StopReason, f64), SceneError> {
        let mut memory = PairMemory::without_clearance();
        deadline.spend(WORK_PER_QUERY);
        let question = self.question(placed);
        workspace.forget_run();
        let (answer, _) = question.go_on(workspace, &mut memory, deadline, !self.is_limited);
        let is_over = answer.stop.is_final();
        let stop = if is_over {
            StopReason::Finished
        } else {
            answer.stop
        };
        if let Asked::Meeting(mode) = self.asked {
            let verdict = answer.verdict;
            match verdict {
                Verdict::Separated => {}
                Verdict::Undecided => self.undecided.push(body),
                _ => self.met.push(BodyOverlap { body, verdict }),
            }
            let is_enough = mode == Mode::Any && verdict.meets();
            return Ok((
                if is_enough {
                    StopReason::FirstHit
                } else {
                    stop
                },
                0.0,
            ));
        }
        let is_inside = matches!(answer.verdict, Verdict::Contained { .. });
        let (mut low, mut high, triangles) = answer
            .proof
            .map_or((0.0, f64::INFINITY, None), |proof| proof.parts());
        if is_inside {
            (low, high) = (0.0, 0.0);
        }
        let is_near = match self.asked {
            Asked::Distance(most) => high <= most,
            _ => high <= 1.0,
        };
        if is_near && high < self.high {
            let time = if self.asked == Asked::Time { low } else { 0.0 };
            self.hit = Some(self.hit((body, placed), triangles, time));
            self.high = high;
        }
        if is_over {
            self.low = self.low.min(low);
        }
        Ok((stop, low))
    }
}

/// The results of a walk with a shape.
struct Found {
    low: f64,
    high: f64,
    hit: Option<ShapeHit>,
    walked: Walked,
}

impl Scene {
    fn ask(
        &mut self,
        shape: &SceneShape,
        asked: Asked,
        budget: ClockedBudget<'_>,
    ) -> Result<Found, SceneError> {
        checks::shape(&shape.motion, shape.margin)?;
        let mut deadline = Deadline::of(budget);
        let is_limited = deadline.is_timed() || deadline.work_left() < u64::MAX;
        let (walk, casts, workspace) = self.walk();
        let tree = match shape.tree {
            Some(tree) => tree,
            None => casts.point.get_or_insert_with(point),
        };
        casts.met.clear();
        casts.undecided.clear();
        if matches!(asked, Asked::Meeting(Mode::All)) {
            casts.met.reserve(walk.bodies.len());
            casts.undecided.reserve(walk.bodies.len());
        }
        let mut probe = ShapeProbe {
            asked,
            shape,
            tree,
            path: Path::new(tree, &shape.motion, shape.margin),
            is_limited,
            low: f64::INFINITY,
            high: f64::INFINITY,
            hit: None,
            met: &mut casts.met,
            undecided: &mut casts.undecided,
        };
        let queue = &mut casts.own.queue;
        let walked = walk.run(&mut probe, queue, workspace, &mut deadline)?;
        let ShapeProbe { low, high, hit, .. } = probe;
        Ok(Found {
            low: low.min(walked.open).min(high),
            high,
            hit,
            walked,
        })
    }

    /// Finds which body a shape meets first in its motion, straight or with a rotation, within a
    /// budget of its own ([`SceneShape`]).
    ///
    /// **Guarantee.** [`ShapeCast::free_until`] is proven and the contact is true, whenever the
    /// cast stops. For each body, the answer is that of [`Query::impact`]; the earliest contact
    /// counts, and of equally early ones the one found first. A finished cast has found a contact
    /// no later than its tolerance after `free_until`, or none, apart from grazes. The same budget
    /// of work gives the same bits and is never exceeded. Allocates like [`Scene::cast`].
    ///
    /// # Errors
    /// [`SceneError::NoShape`], or [`SceneError::NoSuchBody`] if the asking body is not in the
    /// scene.
    pub fn cast_shape<'c>(
        &mut self,
        shape: &SceneShape,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<ShapeCast, SceneError> {
        let found = self.ask(shape, Asked::Time, budget.into())?;
        Ok(ShapeCast {
            free_until: found.low.min(1.0),
            touching_at: found.hit.map(|_| found.high),
            hit: found.hit,
            stop: found.walked.stop,
            work: found.walked.work,
            elapsed: found.walked.elapsed,
        })
    }

    /// Finds the body closest to a shape, and no farther than `within` (0 to infinity), within a
    /// budget of its own ([`SceneShape`]).
    ///
    /// **Guarantee.** Whenever the call stops, no body is closer than [`Closest::low`], and the
    /// body named is no farther than [`Closest::high`]. If it is finished, these are as close to
    /// each other as the tolerance of [`Query::distance`] asks; or no body is within `within`, and
    /// `low` is as close to `within`. Of bodies that are equally close up to the tolerance, any is
    /// named. The same budget of work gives the same bits and is never exceeded. Allocates like
    /// [`Scene::cast`].
    ///
    /// # Errors
    /// [`SceneError::NoShape`], or [`SceneError::NoSuchBody`] if the asking body is not in the
    /// scene.
    pub fn closest<'c>(
        &mut self,
        shape: &SceneShape,
        within: f64,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Closest, SceneError> {
        if within.is_nan() || within < 0.0 {
            let fault = "the distance to search within is not from 0 to infinity";
            return Err(SceneError::NoShape { fault });
        }
        let found = self.ask(shape, Asked::Distance(within), budget.into())?;
        Ok(Closest {
            low: found.low.min(within),
            high: found.high,
            hit: found.hit,
            stop: found.walked.stop,
            work: found.walked.work,
            elapsed: found.walked.elapsed,
        })
    }

    /// Finds the bodies that a shape meets, all or any, within a budget of its own
    /// ([`SceneShape`]).
    ///
    /// **Guarantee.** Each body of [`Overlap::met`] is proven to meet the shape; each that is in
    /// neither list is proven not to, if [`Overlap::is_whole`]. The same budget of work gives the
    /// same bits and is never exceeded. Allocates like [`Scene::cast`], and room for all bodies in
    /// the lists.
    ///
    /// # Errors
    /// [`SceneError::NoShape`], or [`SceneError::NoSuchBody`] if the asking body is not in the
    /// scene.
    pub fn overlap<'c>(
        &mut self,
        shape: &SceneShape,
        mode: Mode,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Overlap<'_>, SceneError> {
        let found = self.ask(shape, Asked::Meeting(mode), budget.into())?;
        let Walked {
            stop,
            work,
            elapsed,
            ..
        } = found.walked;
        let Self { bodies, casts, .. } = self;
        let mut is_whole = found.walked.has_begun && stop != StopReason::FirstHit;
        if stop == StopReason::FirstHit {
            casts.undecided.clear();
            casts.own.queue.clear();
        }
        for Reverse((_, what)) in &casts.own.queue {
            match *what {
                What::Body(body) => casts.undecided.push(bodies.id(body)),
                What::Node(_) => is_whole = false,
            }
        }
        casts.met.sort_unstable_by_key(|met| met.body);
        casts.undecided.sort_unstable();
        Ok(Overlap {
            met: &casts.met,
            undecided: &casts.undecided,
            is_whole,
            stop,
            work,
            elapsed,
        })
    }
}

fn point() -> Box<Tree> {
    let mesh = Mesh::new([[0.0f32; 3]; 3], [[0, 1, 2]]).expect("it is finite");
    let options = BuildOptions::default().solid(Solid::Keep);
    Box::new(Tree::with_options(mesh, &options))
}
