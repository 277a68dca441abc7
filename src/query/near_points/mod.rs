//! The points of a cloud that are near a surface, each once: the question, and how a run of it
//! begins and continues. The traversal is in [`visit`].

pub(crate) mod state;
mod visit;

use crate::engine::boxes::RelativePose;
use crate::engine::certificate::Place;
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::frontier::Pair;
use crate::engine::memory::PairMemory;
use crate::engine::options::{ContactOptions, OptionError};
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Certify, Query, Question};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse_of;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::listing::contacts_left;
use crate::model::prediction::Quantiles;
use crate::query::contacts::LARGEST_MARGIN;
use crate::query::points::PointError;
use crate::tree::Tree;
use punctual_geom::Pose;
use visit::Nearby;

/// Asks which points of a cloud are near a surface ([`Query::points_within`]).
#[derive(Clone, Copy, Debug)]
pub struct PointsWithin {
    other_in_cloud: Pose,
    options: ContactOptions,
}

impl Question for PointsWithin {
    /// The number of points found, drained ones included. The points are in
    /// [`Workspace::near_points`].
    type Value = u64;
}

impl<'t> Query<'t, PointsWithin> {
    /// Asks for all points of a cloud within a distance of the surface of `other`, a mesh or a
    /// cloud, each point once. `other_in_cloud` maps the coordinates of `other` into the cloud's.
    /// The distance is in the length unit of the meshes; [radii](Tree::with_radius) of both add to
    /// it. Negative values and NaN count as 0. With infinity all points are within.
    ///
    /// The answer is a set of ids, which stay in the workspace in order of discovery
    /// ([`Workspace::near_points`]). An id is the index of the point in the input.
    ///
    /// **Guarantee.** The set of a finished query misses no point within the distance. Without a
    /// distance and radii it has exactly the points on the surface. Otherwise it also has points
    /// that `f64` cannot tell from points within: they are farther by at most 4e-14 times the
    /// diagonal of the box around the point and a triangle. The set of a stopped query is a part of
    /// that set, and the closest points of each missing pair have their middle in one of the boxes
    /// of [`Query::certificate`].
    ///
    /// A solid is its surface: a point deep inside is not near it. About linear in the points
    /// found, plus the surface near the cloud.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
    /// let cloud = Tree::from_points([[0.0, 0.0, 3.0], [1.05, 0.0, 0.0], [0.0, 1.02, 0.0]])?;
    /// let ball = Tree::new(shapes::icosphere(3));
    /// let mut workspace = Workspace::new();
    /// let query = Query::points_within(&cloud, &ball, Pose::IDENTITY, 0.1)?;
    /// let answer = query.run(&mut workspace, Budget::unlimited());
    /// let mut near: Vec<_> = workspace.drain_near_points().collect();
    /// near.sort();
    /// assert!(answer.value == 2 && near == [1, 2]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If `cloud` is not the tree of a cloud ([`Tree::from_points`]).
    pub fn points_within(
        cloud: &'t Tree,
        other: &'t Tree,
        other_in_cloud: Pose,
        distance: f64,
    ) -> Result<Self, PointError> {
        if !cloud.is_cloud() {
            return Err(PointError::NotCloud);
        }
        let margin = if distance > 0.0 {
            distance.min(LARGEST_MARGIN)
        } else {
            0.0
        };
        let options = ContactOptions {
            margin,
            limit: usize::MAX,
        };
        let asked = PointsWithin {
            other_in_cloud,
            options,
        };
        let mut query = Self::of([cloud, other], asked);
        OptionError::note(&mut query.fault, "distance", distance, f64::INFINITY);
        Ok(query)
    }

    /// Stops with [`StopReason::PairsFull`] when this many points are in the workspace. By default,
    /// when the workspace is full.
    #[must_use]
    pub fn point_limit(mut self, points: usize) -> Self {
        self.asked.options.limit = points.max(1);
        self
    }

    fn reach(&self) -> f64 {
        self.asked.options.margin + self.radii()
    }
}

impl Ask<PointsWithin> for Query<'_, PointsWithin> {
    fn key(&self) -> Key {
        let asked = Asked::PointsWithin(self.asked.options);
        Key::new([self.a, self.b], self.asked.other_in_cloud, asked)
    }

    fn begin(&self, workspace: &mut Workspace, _: Option<&PairMemory>, _: Budget) {
        workspace.clear();
        workspace.run.begin(self.key(), Strategy::NONE);
        let limit = self.asked.options.limit;
        workspace
            .state
            .near_points
            .begin(self.a.block_count(), limit);
        if !self.a.nodes().is_empty() && !self.b.nodes().is_empty() {
            workspace.frontier.push(Pair::new(0, 0));
        }
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        _: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let (trees, pose) = ([self.a, self.b], &self.asked.other_in_cloud);
        let relative = RelativePose::new(self.a, self.b, pose);
        let question = Nearby::new(&relative, self.reach());
        traverse_of::<_, true>(question, trees, pose, &relative, workspace, deadline)
    }

    fn answer(&self, workspace: &Workspace, _: StopReason) -> u64 {
        workspace.found()
    }

    fn left(&self, workspace: &Workspace, _: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        (contacts_left(&self.listing(workspace)), None)
    }
}

impl Certify<PointsWithin> for Query<'_, PointsWithin> {
    fn place(&self, _: &Workspace) -> Place<'_> {
        Place::Still(&self.asked.other_in_cloud, self.reach())
    }
}
