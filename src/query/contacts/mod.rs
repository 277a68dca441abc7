//! Contacts of two meshes: all pairs of triangles within a margin, the nearest first.
//!
//! This is the distance question with a fixed cut ([`nearest`]): pairs beyond the margin are
//! dropped, and every pair within is written to the list of the workspace. With margin 0 it is the
//! question of the intersection ([`meeting`]), whose boxes and triangle tests cost less.
//!
//! [`nearest`]: crate::query::distance::nearest
//! [`meeting`]: crate::query::intersection::meeting

pub(crate) mod contact;
pub(crate) mod list;
mod listing;

use crate::engine::boxes::RelativePose;
use crate::engine::certificate::Place;
use crate::engine::deadline::{Budget, Deadline};
use crate::engine::frontier::Pair;
use crate::engine::memory::PairMemory;
use crate::engine::options::{ContactOptions, Mode, OptionError, Options};
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Certify, Query, Question};
use crate::engine::strategy::Strategy;
use crate::engine::traversal::traverse;
use crate::engine::triangles::PATIENCE;
use crate::engine::workspace::{Asked, Key, Workspace};
use crate::model::listing::contacts_left;
use crate::model::prediction::Quantiles;
use crate::query::distance::interval::{Interval, Tolerance};
use crate::query::distance::nearest::Nearness;
use crate::query::distance::thinner;
use crate::query::intersection::meeting::Meeting;
use crate::tree::Tree;
use contact::{Contact, face_normal};
use glam::DVec3;
use punctual_geom::Pose;
use punctual_geom::tolerance::COORDINATE_LIMIT;

/// Asks where two surfaces intersect, or come within a margin of each other ([`Query::contacts`]).
///
/// The answer is a set of [`Contact`](crate::contacts::Contact)s: all pairs of triangles no farther
/// apart than the margin. They stay in the workspace, nearest first ([`Workspace::contacts`]).
///
/// **Guarantee.** The set of a finished query misses no pair within the margin. With margin 0 the
/// set has exactly the pairs that intersect. Otherwise it also has pairs that `f64` cannot tell
/// from pairs within: they are farther apart than the margin by at most 4e-14 times the diagonal of
/// the box around both triangles, whatever their shape. The set of a stopped query is a part of
/// that set. Every missing contact is at least [`ContactBounds::low`] away and has its middle in
/// one of the boxes of [`Query::certificate`]. Overlapping boxes are opened first, then the
/// closest, so what was found is mostly the nearest part.
///
/// ```
/// use punctual::glam::{DMat3, DVec3};
/// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::icosphere(3)), Tree::new(shapes::icosphere(3)));
/// let pose = Pose::new(DMat3::IDENTITY, DVec3::new(2.01, 0.0, 0.0))?;
/// let mut workspace = Workspace::new();
/// let found = Query::contacts(&a, &b, pose).margin(0.05).run(&mut workspace, Budget::unlimited());
/// assert_eq!(found.stats.found, workspace.contacts().len() as u64);
/// let nearest = workspace.contacts().next().unwrap();
/// assert!(0.01 <= nearest.distance && nearest.distance < 0.02 && nearest.normal.x < -0.99);
/// # Ok::<(), punctual::PoseError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Contacts {
    b_in_a: Pose,
    pub(crate) options: ContactOptions,
}

impl Question for Contacts {
    /// The contacts themselves are in [`Workspace::contacts`].
    type Value = ContactBounds;
}

/// Room that the first contact query reserves in a workspace without any.
const DEFAULT_ROOM: usize = 4096;

/// No two points are farther apart than this.
pub(crate) const LARGEST_MARGIN: f64 = 1024.0 * COORDINATE_LIMIT;

impl<'t> Query<'t, Contacts> {
    /// Asks for the contacts of the meshes of `a` and `b`, where `b_in_a` maps B's coordinates into
    /// A's. The default margin is 0: only triangles that intersect are contacts.
    #[must_use]
    pub fn contacts(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        let options = ContactOptions {
            margin: 0.0,
            limit: usize::MAX,
        };
        Self::of([a, b], Contacts { b_in_a, options })
    }

    /// Pairs of triangles no farther apart than this are contacts, in the length unit of the
    /// meshes. Negative values and NaN count as 0. With infinity all pairs are contacts.
    #[must_use]
    pub fn margin(mut self, distance: f64) -> Self {
        OptionError::note(&mut self.fault, "margin", distance, f64::INFINITY);
        self.asked.options.margin = if distance > 0.0 {
            distance.min(LARGEST_MARGIN)
        } else {
            0.0
        };
        self
    }

    /// Stops with [`StopReason::PairsFull`] when this many contacts are in the workspace. By
    /// default, when the workspace is full.
    #[must_use]
    pub fn contact_limit(mut self, contacts: usize) -> Self {
        self.asked.options.limit = contacts.max(1);
        self
    }

    /// The unit normals of a triangle of A and of one of B, by the right-hand rule, in A's frame:
    /// the orientations of the two faces of a [`Contact`](crate::contacts::Contact). `None` for a
    /// triangle whose area `f64` cannot resolve.
    ///
    /// The query need not have been run. Contacts do not store these normals, to stay small.
    ///
    /// ```
    /// use punctual::glam::{DMat3, DVec3, Vec3};
    /// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
    /// let floor = Tree::new(shapes::cuboid(Vec3::ONE, 1));
    /// let ball = Tree::new(shapes::icosphere(3));
    /// let pose = Pose::new(DMat3::IDENTITY, DVec3::Z * 1.99)?;
    /// let mut workspace = Workspace::new();
    /// let query = Query::contacts(&floor, &ball, pose);
    /// let _ = query.run(&mut workspace, Budget::unlimited());
    /// let nearest = workspace.contacts().next().unwrap();
    /// let [of_floor, of_ball] = query.face_normals(nearest.triangles);
    /// assert!(of_floor == Some(DVec3::Z) && of_ball.unwrap().z < -0.9);
    /// # Ok::<(), punctual::PoseError>(())
    /// ```
    ///
    /// # Panics
    /// If one of the meshes has no such triangle.
    #[must_use]
    pub fn face_normals(&self, [of_a, of_b]: [u32; 2]) -> [Option<DVec3>; 2] {
        let placed = self
            .b
            .mesh()
            .triangle(of_b as usize)
            .map(|corner| self.asked.b_in_a.transform_point(corner));
        [
            face_normal(&self.a.mesh().triangle(of_a as usize)),
            face_normal(&placed),
        ]
    }

    /// Triangles of the cores no farther apart than this are contacts.
    pub(crate) fn reach(&self) -> f64 {
        self.asked.options.margin + self.radii()
    }

    /// True if a contact proves that the surfaces come within the margin.
    pub fn is_within(&self, contact: &Contact) -> bool {
        contact.distance <= self.asked.options.margin
    }
}

impl Ask<Contacts> for Query<'_, Contacts> {
    fn key(&self) -> Key {
        let asked = Asked::Contacts(self.asked.options);
        Key::new([self.a, self.b], self.asked.b_in_a, asked)
    }

    fn begin(&self, workspace: &mut Workspace, _: Option<&PairMemory>, _: Budget) {
        workspace.clear();
        let strategy = Strategy {
            batch: PATIENCE,
            ..Strategy::NONE
        };
        workspace.run.begin(self.key(), strategy);
        if workspace.state.contacts.capacity() == 0 {
            workspace.state.contacts.reserve(DEFAULT_ROOM);
        }
        let limit = self.asked.options.limit;
        let reach = self.reach();
        (workspace.state.contacts).begin(reach, self.radii(), limit);
        if self.a.nodes().is_empty() || self.b.nodes().is_empty() {
            return;
        }
        if reach > 0.0 {
            let interval = Interval::new(Tolerance::default(), 0.0, reach);
            workspace.state.distance.begin(interval, None);
        }
        workspace.frontier.push(Pair::new(0, 0));
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        _: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let (trees, b_in_a) = ([self.a, self.b], &self.asked.b_in_a);
        let relative = RelativePose::within(
            self.a,
            self.b,
            b_in_a,
            workspace.state.manifolds.reduction.reach(),
        );
        workspace.state.contacts.hurry(deadline.is_timed());
        let stop = if self.reach() > 0.0 {
            let question = Nearness::new(&relative, &workspace.state.distance.interval);
            let stop = traverse(question, trees, b_in_a, &relative, workspace, deadline);
            workspace.bound(f32::INFINITY, relative.unit);
            stop
        } else {
            let options = &Options {
                mode: Mode::All,
                ..Options::DEFAULT
            };
            let question = Meeting { options };
            traverse(question, trees, b_in_a, &relative, workspace, deadline)
        };
        workspace.state.contacts.sort();
        stop
    }

    fn answer(&self, workspace: &Workspace, stop: StopReason) -> ContactBounds {
        let low = if stop.is_final() {
            f64::INFINITY
        } else {
            thinner(workspace.state.distance.interval.low(), self.radii())
        };
        ContactBounds { low }
    }

    fn left(&self, workspace: &Workspace, _: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        (contacts_left(&self.listing(workspace)), None)
    }
}

impl Certify<Contacts> for Query<'_, Contacts> {
    fn place(&self, _: &Workspace) -> Place<'_> {
        Place::Still(&self.asked.b_in_a, self.reach())
    }
}

/// The answer to a contact query. Plain data; the contacts stay in the workspace
/// ([`Workspace::contacts`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct ContactBounds {
    /// Proven: every contact not found is at least this far apart, in the length unit of the
    /// meshes. Infinite if the query is finished: none is missing.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub low: f64,
}
