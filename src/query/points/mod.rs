//! Points and solids: how often a surface winds around a point, whether the point is inside, and
//! how far it is from the surface; for one point and for many.
//!
//! [`visit`] is the question that the traversal answers, [`rim`] what open edges add, [`near`] the
//! bounds of distances, and [`state`] what is kept between calls.

pub(crate) mod contained;
mod near;
mod rim;
pub(crate) mod state;
mod visit;

use crate::engine::boxes::{RelativePose, flushing};
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::memory::PairMemory;
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Query, Question};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse_of;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::batch::{Batch, points_left};
use crate::model::prediction::Quantiles;
use crate::tree::Tree;
use contained::may_hold;
use core::{fmt, slice};
use glam::DVec3;
use punctual_geom::Pose;
use punctual_geom::tolerance::COORDINATE_LIMIT;
pub(crate) use visit::{Locate, Source};

/// Asks about one point and a solid ([`Query::winding`], [`Query::signed_distance`]).
///
/// **Guarantee.** Of a closed solid, the winding number is exact for the coordinates as given: the
/// number of times that the surface surrounds the point. A point on the surface is said to be
/// there, exactly. The solid is closed as a set: a point is inside if the winding number is at
/// least 1, or if it is on the surface. Of an open solid, the winding number is the solid angle of
/// its surface over `4 pi`, off by no more than [`PointBounds::error`], and a point is inside if it
/// is more than 1/2. The signed distance lies within its two bounds whenever the query stops, and
/// is negative inside. Nothing depends on budgets, machines or the shape of the tree.
///
/// On the surface, the winding number is that at the points just beside it, along one of the axes.
///
/// Of a tree with a [radius](Tree::with_radius), winding number, nearest point and
/// [`PointBounds::is_on_surface`] are those of the core. The signed distance is that of the core
/// minus the radius: outside it is the distance of the thickened solid; inside, the solid is at
/// least that deep, and a convex one exactly. A point is inside if it is inside the core or no
/// farther from it than the radius, up to the error of the distance. The answer then has the
/// distance even if it was not asked for.
///
/// ```
/// use punctual::tree::Solid;
/// use punctual::{BuildOptions, Budget, Query, Tree, Workspace, shapes};
/// let options = BuildOptions::default().solid(Solid::Keep);
/// let ball = Tree::with_options(shapes::icosphere(4), &options);
/// let mut workspace = Workspace::new();
/// let query = Query::signed_distance(&ball, [0.0, 0.25, 0.5])?;
/// let point = query.run(&mut workspace, Budget::unlimited()).value;
/// assert_eq!((point.winding, point.inside), (Some(1.0), Some(true)));
/// let distance = point.distance.expect("asked for");
/// assert!(distance.low <= distance.high && distance.high < -0.4);
/// # Ok::<(), punctual::points::PointError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct AtPoint {
    point: [f64; 3],
    measures: bool,
}

impl Question for AtPoint {
    type Value = PointBounds;
}

/// Asks about many points and a solid, one after another within one budget
/// ([`Query::windings`], [`Query::signed_distances`]). Guarantees as for [`AtPoint`].
///
/// ```
/// use punctual::tree::Solid;
/// use punctual::{BuildOptions, Budget, Query, Tree, Workspace, shapes};
/// let options = BuildOptions::default().solid(Solid::Keep);
/// let ball = Tree::with_options(shapes::icosphere(4), &options);
/// let points: Vec<[f64; 3]> = (0..9).map(|i| [0.3 * f64::from(i), 0.0, 0.0]).collect();
/// let mut workspace = Workspace::new();
/// let done = Query::windings(&ball, &points)?.run(&mut workspace, Budget::unlimited()).value;
/// let inside = workspace.points().iter().filter(|point| point.inside == Some(true)).count();
/// assert_eq!((done, inside), (9, 4));
/// # Ok::<(), punctual::points::PointError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct AtPoints<'p> {
    points: &'p [[f64; 3]],
    measures: bool,
}

impl Question for AtPoints<'_> {
    /// Number of points done, from the first; [`Workspace::points`] has what is known of them.
    type Value = usize;
}

/// What is proven about a point and a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct PointBounds {
    /// How often the surface winds around the point: a whole number if the solid is closed. `None`
    /// if the query stopped before it was known.
    pub winding: Option<f64>,
    /// Bound of the error of the winding number: 0 for closed solids, infinite if it is not known.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub error: f64,
    /// True if the point is inside or on the surface. `None` if that is not known: the query
    /// stopped, or the winding number of an open solid is 1/2 to its error.
    pub inside: Option<bool>,
    /// True if the point is on the surface. False is final only once the winding number is known.
    pub is_on_surface: bool,
    /// The signed distance, if it was asked for. `None` for an empty mesh.
    pub distance: Option<SignedDistance>,
}

/// Bounds of the distance from a point to a surface, negative inside: `low <= distance <= high`.
/// Units are those of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SignedDistance {
    /// Lower bound. As long as it is not known whether the point is inside, `-high`.
    pub low: f64,
    /// Upper bound. Of a finished query, `high - low` is at most 1e-13 of the distance and 64
    /// roundings of the extent of the nearest triangle as seen from the point.
    pub high: f64,
    /// Id of the triangle in the input mesh that has the nearest point found.
    pub triangle: u32,
    /// The nearest point of the surface that was found, rounded.
    pub point: DVec3,
}

/// Reasons why a query about points is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointError {
    /// The tree was not built as a solid ([`crate::BuildOptions::solid`]).
    NotSolid,
    /// The tree is not that of a point cloud ([`Tree::from_points`]).
    NotCloud,
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// Index of the point.
        point: usize,
        /// Axis of the coordinate: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// A coordinate is larger than 2^1000 in magnitude.
    TooLarge {
        /// Index of the point.
        point: usize,
        /// Axis of the coordinate: 0, 1, 2 for x, y, z.
        axis: usize,
    },
}

impl fmt::Display for PointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSolid => {
                f.write_str("the tree was not built as a solid, see `BuildOptions::solid`")
            }
            Self::NotCloud => {
                f.write_str("the tree is not that of a point cloud, see `Tree::from_points`")
            }
            Self::NotFinite { point, axis } => {
                write!(f, "point {point} is not finite along axis {axis}")
            }
            Self::TooLarge { point, axis } => {
                write!(f, "point {point} exceeds 2^1000 along axis {axis}")
            }
        }
    }
}

impl core::error::Error for PointError {}

impl<'t> Query<'t, AtPoint> {
    /// Asks how often a solid winds around a point, and whether the point is inside. The point is
    /// in the frame of the tree's mesh.
    ///
    /// Takes a ray, and constant time for each open edge.
    ///
    /// # Errors
    /// [`PointError`], with 0 as the index of the point.
    pub fn winding(tree: &'t Tree, point: impl Into<[f64; 3]>) -> Result<Self, PointError> {
        let (point, measures) = (point.into(), false);
        AtPoint { point, measures }.about(tree)
    }

    /// Asks for the signed distance too: negative inside.
    ///
    /// # Errors
    /// [`PointError`], with 0 as the index of the point.
    pub fn signed_distance(tree: &'t Tree, point: impl Into<[f64; 3]>) -> Result<Self, PointError> {
        let (point, measures) = (point.into(), true);
        AtPoint { point, measures }.about(tree)
    }
}

impl<'t, 'p> Query<'t, AtPoints<'p>> {
    /// Asks how often a solid winds around each of many points, and whether they are inside. The
    /// first query for this many points in a workspace allocates room for the answers.
    ///
    /// # Errors
    /// [`PointError`].
    pub fn windings(tree: &'t Tree, points: &'p [[f64; 3]]) -> Result<Self, PointError> {
        let measures = false;
        AtPoints { points, measures }.about(tree)
    }

    /// Asks for the signed distances too.
    ///
    /// # Errors
    /// [`PointError`].
    pub fn signed_distances(tree: &'t Tree, points: &'p [[f64; 3]]) -> Result<Self, PointError> {
        let measures = true;
        AtPoints { points, measures }.about(tree)
    }
}

/// A question about one point or many.
trait Points: Question + Sized {
    /// The points, and true if their distances are asked for.
    fn points(&self) -> (&[[f64; 3]], bool);

    fn value(workspace: &Workspace, tree: &Tree) -> Self::Value;

    fn about(self, tree: &Tree) -> Result<Query<'_, Self>, PointError> {
        if tree.solid().is_none() {
            return Err(PointError::NotSolid);
        }
        let points = self.points().0;
        // A comparison with NaN is false.
        let is_good = |x: &f64| x.abs() <= COORDINATE_LIMIT;
        let bad = points.as_flattened().iter().position(|x| !is_good(x));
        match bad.map(|at| (at / 3, at % 3)) {
            None => Ok(Query::of([tree; 2], self)),
            Some((point, axis)) if points[point][axis].is_finite() => {
                Err(PointError::TooLarge { point, axis })
            }
            Some((point, axis)) => Err(PointError::NotFinite { point, axis }),
        }
    }
}

impl Points for AtPoint {
    fn points(&self) -> (&[[f64; 3]], bool) {
        (slice::from_ref(&self.point), self.measures)
    }

    fn value(workspace: &Workspace, tree: &Tree) -> PointBounds {
        match workspace.state.points.found.first() {
            Some(&bounds) => bounds,
            None => workspace.point_bounds(tree, false),
        }
    }
}

impl Points for AtPoints<'_> {
    fn points(&self) -> (&[[f64; 3]], bool) {
        (self.points, self.measures)
    }

    fn value(workspace: &Workspace, _: &Tree) -> usize {
        workspace.state.points.found.len()
    }
}

impl<Q: Points> Ask<Q> for Query<'_, Q> {
    fn key(&self) -> Key {
        Key::new([self.a; 2], Pose::IDENTITY, Asked::Points)
    }

    /// The last run may have stopped at one of the points, or finished with the last.
    fn is_in(&self, workspace: &Workspace) -> bool {
        let (points, measures) = self.asked.points();
        let state = &workspace.state.points;
        let done = state.found.len();
        let current = done.min(points.len().saturating_sub(1));
        state.measures == (measures || self.a.radius() > 0.0)
            && done + state.left == points.len()
            && points
                .get(current)
                .is_none_or(|point| *point == state.point.to_array())
    }

    fn begin(&self, workspace: &mut Workspace, _: Option<&PairMemory>, _: Budget) {
        let (points, measures) = self.asked.points();
        workspace.clear();
        workspace.run.begin(self.key(), Strategy::NONE);
        begin_points(self.a, workspace, points, measures);
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        _: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        advance(self.a, workspace, self.asked.points().0, deadline)
    }

    fn answer(&self, workspace: &Workspace, _: StopReason) -> Q::Value {
        Q::value(workspace, self.a)
    }

    fn left(&self, workspace: &Workspace, _: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let state = &workspace.state.points;
        let batch = Batch {
            triangles: self.a.mesh().len() as f64,
            done: state.found.len() as f64,
            left: state.left as f64,
            work: workspace.work() as f64,
            is_thorough: state.measures,
        };
        (points_left(&batch), None)
    }
}

/// Prepares for the first of the points, alone or within the run of another question.
pub(crate) fn begin_points(
    tree: &Tree,
    workspace: &mut Workspace,
    points: &[[f64; 3]],
    measures: bool,
) {
    let state = &mut workspace.state.points;
    state.reserve(points.len());
    let first = points.first().copied().unwrap_or_default();
    let measures = measures || tree.radius() > 0.0;
    state.begin(points.len(), measures, first.into());
    if let Some(solid) = tree.solid() {
        let rim = solid.rim().0.len();
        state.seen.clear();
        state.seen.reserve_exact(rim);
    }
}

/// Prepares the workspace for a vertex of each component of a solid, which may be inside another.
pub(crate) fn begin_samples(workspace: &mut Workspace, [outer, inner]: [&Tree; 2]) {
    let count = match inner.solid() {
        Some(solid) if may_hold(outer, inner) => solid.components().len(),
        _ => 0,
    };
    let state = &mut workspace.state.points;
    if count > 0 {
        state.reserve_stack();
    }
    state.begin(count, false, DVec3::ZERO);
}

/// Continues the run about these points in the workspace until it is over or the deadline stops it.
pub(crate) fn advance(
    tree: &Tree,
    workspace: &mut Workspace,
    points: &[[f64; 3]],
    deadline: &mut Deadline,
) -> StopReason {
    let points = &points[workspace.state.points.found.len().min(points.len())..];
    if flushing::matters_to_points(tree, points) {
        workspace.run.stopped = true;
        return StopReason::FlushedToZero;
    }
    let source = Source::Points(points);
    traverse_of::<_, false>(
        Locate { source },
        [tree; 2],
        &Pose::IDENTITY,
        &RelativePose::BLIND,
        workspace,
        deadline,
    )
}
