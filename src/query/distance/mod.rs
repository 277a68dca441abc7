//! The distance of two meshes: two trees, a pose and a budget in, proven [`Bounds`] out.

mod closest_pairs;
pub(crate) mod estimate;
pub(crate) mod gaps;
pub(crate) mod halves;
pub(crate) mod interval;
mod lone;
pub(crate) mod nearest;
pub(crate) mod search;
#[cfg(all(test, feature = "std"))]
mod triangle_bounds_tests;

use crate::engine::boxes::RelativePose;
use crate::engine::certificate::Place;
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::frontier::Pair;
use crate::engine::memory::PairMemory;
use crate::engine::options::{DistanceOptions, OptionError, thickness};
use crate::engine::outcome::Operand;
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Certify, Query, Question, Remembers};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse;
use crate::engine::triangles::ids;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::prediction::Quantiles;
use crate::tree::Tree;
use glam::DVec3;
use halves::Halves;
use interval::{Interval, Tolerance};
use nearest::Nearness;
use punctual_geom::Pose;

/// Asks for the distance of two surfaces at a pose ([`Query::distance`]); 0 if they intersect.
///
/// **Guarantee.** `low <= distance <= high`, whenever the query stops: no point of A's surface is
/// closer to B's than `low`, and two named points of two named triangles are `high` apart. Both
/// bounds only improve. When the query is finished, they are as close as the tolerance asks and
/// `f64` can resolve: 4e-14 times the diagonal of the box around both meshes, whatever the shape of
/// their triangles. `high` is 0 only if the surfaces intersect. A finished query of surfaces that
/// intersect reports 0, whatever the tolerance, unless [`Query::leave_contact_open`] is set.
///
/// Triangle pairs at nearly equal distance are all tested, unless boxes, or a plane between the
/// surfaces, prove that none is closer. For nested or parallel sheets within a bend of another
/// mesh, their number can reach the product of the numbers of triangles. A tolerance above the
/// differences avoids these tests.
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(4)), Tree::new(shapes::torus(1.0, 0.3, 64)));
/// let pose = Pose::new(DMat3::IDENTITY, DVec3::new(3.0, 0.0, 0.0))?;
/// let query = Query::distance(&a, &b, pose);
/// let found = query.run(&mut Workspace::new(), Budget::work(20_000)).value;
/// assert!(found.low <= 0.7 && 0.7 <= found.high + 0.01);
/// # Ok::<(), punctual::PoseError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Distance {
    b_in_a: Pose,
    pub(crate) options: DistanceOptions,
    ceiling: f64,
}

impl Question for Distance {
    type Value = Bounds;
}

impl Remembers for Distance {}

/// The default absolute tolerance, relative to the size of the larger mesh. The default relative
/// tolerance of bodies farther apart than `FAR` times this size, where boxes in `f32` resolve no
/// more.
const DEFAULT_TOLERANCE: f64 = 1e-6;
const FAR: f64 = 64.0;
const FAR_TOLERANCE: f64 = 1e-5;

impl<'t> Query<'t, Distance> {
    /// Asks for the distance of the meshes of `a` and `b`, where `b_in_a` maps B's coordinates into
    /// A's.
    ///
    /// By default the absolute tolerance is a millionth of the larger mesh's unit
    /// ([`Tree::unit_length`], about half of its longest extent; 0 for a point) and
    /// [radius](Tree::with_radius), and the relative one 0. If no tolerance is set and the middles of the meshes are more than 64 such units
    /// apart, the relative tolerance is 1e-5. Next to a much larger mesh, set a tolerance relative
    /// to the size of the small one if its distance must be as precise; that takes up to a tenth
    /// more work (`docs/performance.md`).
    #[must_use]
    pub fn distance(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        let options = DistanceOptions {
            absolute: None,
            relative: None,
            margins: [a.radius(), b.radius()],
            limit: f64::INFINITY,
            leaves_contact_open: false,
            depth_first: false,
        };
        let ceiling = f64::INFINITY;
        let asked = Distance {
            b_in_a,
            options,
            ceiling,
        };
        Self::of([a, b], asked)
    }

    /// The query is finished as soon as `high - low` is at most this, in the length unit of the
    /// meshes. 0 (and NaN) means as close as `f64` can resolve: at most 4e-14 times the diagonal of
    /// the box around both meshes. Surfaces with large parallel parts have many triangle pairs at
    /// nearly equal distance; a tolerance saves comparing them. With any tolerance the query
    /// decides whether the surfaces intersect, unless [`Query::leave_contact_open`] is set too.
    #[must_use]
    pub fn absolute_tolerance(mut self, length: f64) -> Self {
        OptionError::note(&mut self.fault, "absolute_tolerance", length, f64::MAX);
        self.asked.options.absolute = Some(length.max(0.0));
        self
    }

    /// The query is finished also as soon as `high <= (1 + share) low`. Negative values and NaN
    /// count as 0.
    #[must_use]
    pub fn relative_tolerance(mut self, share: f64) -> Self {
        OptionError::note(&mut self.fault, "relative_tolerance", share, f64::MAX);
        self.asked.options.relative = Some(share.max(0.0));
        self
    }

    /// If true, a query is finished as soon as `high` is at most the absolute tolerance, even if it
    /// is then open whether the surfaces intersect (`low` is 0). Off by default. For surfaces that
    /// nearly touch in many places, deciding whether they intersect may take thousands of times as
    /// long as proving that they are within the tolerance. Does not affect [`Query::closer_than`].
    #[must_use]
    pub fn leave_contact_open(mut self, leave: bool) -> Self {
        self.asked.options.leaves_contact_open = leave;
        self
    }

    /// Thickens each surface by its margin, beside its [radius](Tree::with_radius). A margin is in
    /// the length unit of the meshes, not negative, at most 2^1000; NaN counts as 0. A point
    /// becomes a ball, a segment a capsule. The query measures the distance of the thickened
    /// surfaces.
    #[must_use]
    pub fn margins(mut self, margins: [f64; 2]) -> Self {
        OptionError::note_margins(&mut self.fault, margins);
        let [of_a, of_b] = margins.map(thickness);
        self.asked.options.margins = [of_a + self.a.radius(), of_b + self.b.radius()];
        self
    }

    /// Asks only whether the distance of the (thickened) surfaces is at most this. The query is
    /// finished as soon as one of the bounds decides; [`Bounds::closer`] has the answer. Takes a
    /// fraction of the time of the distance. Infinity disables the limit. Negative values and NaN
    /// count as 0.
    #[must_use]
    pub fn closer_than(mut self, distance: f64) -> Self {
        OptionError::note(&mut self.fault, "closer_than", distance, f64::INFINITY);
        self.asked.options.limit = distance.max(0.0);
        self
    }

    /// Does not resolve distances beyond this. A stopped run continues with the ceiling of its
    /// start.
    #[doc(hidden)]
    #[must_use]
    pub fn below(mut self, ceiling: f64) -> Self {
        self.asked.ceiling = ceiling;
        self
    }

    /// For comparison: keeps all node pairs on one stack, the closest of siblings on top. `low`
    /// then stays 0 almost to the end.
    #[cfg(feature = "internals")]
    #[doc(hidden)]
    #[must_use]
    pub fn depth_first(mut self) -> Self {
        self.asked.options.depth_first = true;
        self
    }

    /// Vector from the middle of A's box to that of B's.
    pub(crate) fn middle(&self) -> DVec3 {
        self.asked.b_in_a.transform_point(self.b.unit().origin) - self.a.unit().origin
    }

    fn tolerance(&self) -> Tolerance {
        let size = self.a.size().max(self.b.size());
        let apart = self.middle().abs().max_element();
        let options = &self.asked.options;
        let is_far = options.absolute.is_none() && apart > FAR * size;
        let far = if is_far { FAR_TOLERANCE } else { 0.0 };
        Tolerance {
            absolute: options.absolute.unwrap_or(DEFAULT_TOLERANCE * size),
            relative: options.relative.unwrap_or(far),
        }
    }

    fn margin(&self) -> f64 {
        self.asked.options.margins[0] + self.asked.options.margins[1]
    }

    /// True if a finished run decides whether the surfaces intersect, whatever its tolerance.
    #[doc(hidden)]
    pub fn decides_contact(&self) -> bool {
        self.asked.options.limit == f64::INFINITY
            && self.margin() == 0.0
            && !self.asked.options.leaves_contact_open
    }

    /// Proven upper bound of the distance from the run in the workspace, neither margins nor radii
    /// subtracted. 0 only if the triangles intersect.
    pub fn witness_distance(&self, workspace: &Workspace) -> f64 {
        workspace.state.distance.interval.high()
    }

    /// The run in the workspace does not resolve distances beyond this; 0 with a limit.
    #[doc(hidden)]
    pub fn ceiling_in(&self, workspace: &Workspace) -> f64 {
        if self.asked.options.limit < f64::INFINITY {
            0.0
        } else {
            workspace.state.distance.interval.ceiling()
        }
    }

    /// The bounds of the distance of the thickened surfaces.
    pub(crate) fn bounds(&self, interval: &Interval) -> [f64; 2] {
        let low = less(interval.low(), self.margin(), -f64::EPSILON);
        let high = if interval.touches() {
            0.0
        } else {
            less(interval.high(), self.margin(), f64::EPSILON)
        };
        [low, high]
    }
}

impl Ask<Distance> for Query<'_, Distance> {
    fn key(&self) -> Key {
        let asked = Asked::Distance(self.asked.options);
        Key::new([self.a, self.b], self.asked.b_in_a, asked)
    }

    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, _: Budget) {
        workspace.clear();
        workspace.run.begin(self.key(), Strategy::NONE);
        if self.a.nodes().is_empty() || self.b.nodes().is_empty() {
            return;
        }
        let guess = memory.and_then(|memory| memory.nearest(self.a, self.b));
        let known = memory.map_or(0.0, |memory| {
            memory.clearance(self.a, self.b, &self.asked.b_in_a)
        });
        let interval = Interval::new(self.tolerance(), self.margin(), self.asked.options.limit);
        let mut interval = interval.below(self.asked.ceiling);
        if self.asked.options.leaves_contact_open {
            interval = interval.leaving_contact_open();
        }
        if interval.know(known) {
            return workspace.state.distance.begin(interval, None);
        }
        workspace.state.distance.begin(interval, guess);
        workspace.state.distance.halves = Halves::of(self.a, self.b);
        workspace.testing = guess.is_some();
        workspace.frontier.push(Pair::new(0, 0));
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        if let Some(stop) = self.containment_first(|| self.asked.b_in_a, workspace, deadline) {
            return stop;
        }
        let (trees, b_in_a) = ([self.a, self.b], &self.asked.b_in_a);
        let relative = RelativePose::new(self.a, self.b, b_in_a);
        let search = &mut workspace.state.distance;
        let question = Nearness::new(&relative, &search.interval);
        let mut question = question.beside(trees, &relative, search);
        question.depth_first = self.asked.options.depth_first;
        let stop = traverse(question, trees, b_in_a, &relative, workspace, deadline);
        workspace.bound(f32::INFINITY, relative.unit);
        if let Some(memory) = memory {
            // With a limit the work is less, so predictions must not use it.
            let interval = &workspace.state.distance.interval;
            let is_whole = stop.is_final() && !interval.has_limit();
            let work = is_whole.then(|| workspace.work());
            let nearest = interval.nearest().map(|(pair, _)| pair);
            memory.remember_distance(trees, b_in_a, interval.low(), nearest, work);
            memory.learn(self.sought(), workspace, workspace.work(), stop.is_final());
        }
        stop
    }

    fn answer(&self, workspace: &Workspace, _: StopReason) -> Bounds {
        let interval = &workspace.state.distance.interval;
        let within = workspace.run.containment.inner();
        let [low, high] = match within {
            Some(_) => [0.0; 2],
            None if self.is_open_in(workspace) => [0.0, f64::INFINITY],
            None => self.bounds(interval),
        };
        let nearest = interval.nearest().map(|(pair, found)| Nearest {
            triangles: ids([self.a, self.b], pair),
            points: [
                found.points[0] - found.direction * self.asked.options.margins[0],
                found.points[1] + found.direction * self.asked.options.margins[1],
            ],
        });
        let limit = self.asked.options.limit;
        let closer = match limit {
            f64::INFINITY => None,
            _ if high <= limit => Some(true),
            _ if low > limit => Some(false),
            _ => None,
        };
        Bounds {
            low,
            high,
            nearest,
            closer,
            within,
        }
    }

    fn left(&self, workspace: &Workspace, memory: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let closing = self.closing(
            workspace.work(),
            self.bounds(&workspace.state.distance.interval),
        );
        (self.work_left(&closing, memory), None)
    }
}

impl Certify<Distance> for Query<'_, Distance> {
    fn place(&self, workspace: &Workspace) -> Place<'_> {
        let most = self.asked.options.limit + self.margin();
        let reach = workspace.state.distance.interval.high().min(most);
        Place::Still(&self.asked.b_in_a, reach)
    }
}

/// Subtracts radii from a proven lower bound, rounded down. May be negative.
pub(crate) fn thinner(low: f64, radii: f64) -> f64 {
    if radii > 0.0 && low < f64::INFINITY {
        low - radii - f64::EPSILON * (low + radii)
    } else {
        low
    }
}

/// Subtracts the margins from a bound; at least 0. `rounding`, relative to the sum of bound and
/// margin, covers the rounding of the difference. An infinite bound stays infinite.
fn less(bound: f64, margin: f64, rounding: f64) -> f64 {
    let is_less = margin > 0.0 && bound < f64::INFINITY;
    if is_less {
        (bound - margin + rounding * (bound + margin)).max(0.0)
    } else {
        bound
    }
}

/// The closest triangles found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Nearest {
    /// Triangle of A, triangle of B: ids of the input meshes.
    pub triangles: [u32; 2],
    /// Their closest points in A's frame, rounded, each moved towards the other surface by its
    /// margin. If the triangles intersect, both are one point, whatever the margins: the middle of
    /// the segment in which they intersect ([`triangle_segment`](crate::geom::triangle_segment)),
    /// within 1e-12 times the largest coordinate of both.
    pub points: [DVec3; 2],
}

/// The answer to a distance query: `low <= distance <= high`, in the length unit of the meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct Bounds {
    /// Proven lower bound: the surfaces are nowhere closer. Infinite if one of the meshes is empty.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub low: f64,
    /// Proven upper bound: the distance of [`Bounds::nearest`]. 0 only if the surfaces meet.
    /// Infinite if no pair was tested yet.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub high: f64,
    /// The closest triangles found so far.
    pub nearest: Option<Nearest>,
    /// True if the distance is at most the limit of [`Query::closer_than`]. `None` if that is
    /// undecided, or no limit was set. It stays undecided if `f64` cannot resolve it: if the
    /// distance equals the limit up to 4e-14 times the diagonal of the box around both meshes.
    pub closer: Option<bool>,
    /// Proven: this body, a solid, has a vertex inside the other, a closed solid. So the solids
    /// meet, and their distance is 0, whether or not their surfaces meet. How deep they are is
    /// another question. `None` for surfaces and where no first vertex of a component is inside.
    pub within: Option<Operand>,
}
