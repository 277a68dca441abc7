//! Contact manifolds of two meshes: the contacts within a skin, reduced while they are found, and
//! the overlaps of surfaces that meet.
//!
//! The search is that of the [contacts](crate::query::contacts); what it finds goes to a
//! [`Reduction`](overlaps::Reduction) instead of a list. Pairs that intersect are kept for the
//! [`overlaps`], which follow in the same run.

pub(crate) mod manifold;
pub(crate) mod overlaps;
pub(crate) mod state;

use crate::engine::deadline::{Budget, Deadline};
use crate::engine::memory::PairMemory;
use crate::engine::memory::Sought;
use crate::engine::memory::identity::{Before, ManifoldMemory};
use crate::engine::options::{ContactOptions, OptionError};
use crate::engine::outcome::Operand;
use crate::engine::outcome::StopReason;
use crate::engine::question::{Ask, Query, Question, Remembers};
use crate::engine::workspace::{Asked, Containment, Key, Workspace};
use crate::model::cost::{WORK_PER_RAY, WORK_PER_RAY_TEST};
use crate::model::listing::manifolds_left;
use crate::model::prediction::Quantiles;
use crate::query::distance::thinner;
use crate::tree::Tree;
use core::mem;
use manifold::{Manifold, Shape, number};
use punctual_geom::Pose;

/// Asks for the contact manifolds of two surfaces ([`Query::manifolds`]): what a solver needs to
/// keep two bodies apart.
///
/// Where the surfaces are apart but within the skin, points of contact have a positive distance.
/// Where they are sunk into each other, an overlap has negative ones: minus the depth along its
/// normal. Both kinds are in one list, [`Workspace::manifolds`], the deepest first, each
/// [`Manifold`] with at most four points. Normals point from B to A.
///
/// Meshes are taken as solids: triangles are counterclockwise seen from outside. If both are known
/// to be closed ([`BuildOptions::solid`](crate::BuildOptions::solid)), what is inside is decided
/// exactly; else by the side of the nearest hit of a ray. A solid wholly inside a closed one has no
/// overlap manifold; [`ManifoldBounds::within`] names it.
///
/// The work is that of the contacts within the skin, and where surfaces meet about as much again.
/// The first query of a pair that meets makes room in the workspace: 4 bytes for each triangle and
/// 12 for each vertex.
///
/// Faces that lie in one plane, and edges and corners in one place, are no special case: a face in
/// contact has one manifold whose points, depth and area change steadily from apart through
/// touching to sunk. For manifolds, and for them alone, the faces of B count as drawn in by less
/// than 1e-12 of the largest coordinate; `meets` and `nearest` are about the surfaces as they are.
///
/// **Guarantee.** A finished query has reduced each pair of triangles within the skin, except those
/// that add nothing to the polygon of a manifold, nor to its least distance, up to a thousandth.
/// After a stopped query, each point in the list is a point of contact, and missing contacts are at
/// least [`ManifoldBounds::low`] apart. An overlap is listed when its depth is known. With a memory
/// ([`Query::with_memory`]) ids last from frame to frame.
///
/// ```
/// use punctual::glam::{DMat3, DVec3, Vec3};
/// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
/// let floor = Tree::new(shapes::cuboid(Vec3::splat(5.0), 1));
/// let crate_ = Tree::new(shapes::cuboid(Vec3::ONE, 1));
/// let mut workspace = Workspace::new();
/// for (height, distance) in [(6.01, 0.01), (5.99, -0.01)] {
///     let pose = Pose::new(DMat3::IDENTITY, DVec3::Z * height)?;
///     let query = Query::manifolds(&floor, &crate_, pose).skin(0.02);
///     let found = query.run(&mut workspace, Budget::unlimited());
///     assert!(found.value.low == f64::INFINITY);
///     let [manifold] = workspace.manifolds() else { panic!("one face of the crate") };
///     assert!((manifold.normal + DVec3::Z).length() < 1e-9 && manifold.points().len() == 4);
///     assert!(manifold.points().iter().all(|point| (point.distance - distance).abs() < 1e-6));
/// }
/// # Ok::<(), punctual::PoseError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Manifolds {
    b_in_a: Pose,
    options: ContactOptions,
}

impl Question for Manifolds {
    /// The manifolds themselves are in [`Workspace::manifolds`].
    type Value = ManifoldBounds;
}

impl Remembers for Manifolds {}

/// The answer to a query for manifolds. Plain data; the manifolds stay in the workspace
/// ([`Workspace::manifolds`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct ManifoldBounds {
    /// Proven: every contact that is not in the list is at least this far apart, in the length unit
    /// of the meshes. 0 while overlaps may be missing. Infinite if the query is finished.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub low: f64,
    /// True if the surfaces are known to intersect.
    pub meets: bool,
    /// The triangles (ids of the meshes) of the nearest contact found, up to a thousandth, and
    /// their distance: 0 only if they intersect, negative only of thickened surfaces that are sunk
    /// into each other. `None` if no contact was found.
    pub nearest: Option<([u32; 2], f64)>,
    /// Proven: this body, a solid, is inside the other, a closed solid, and at most touches its
    /// surface from inside. So the solids overlap, but no manifold shows how to part them. `None`
    /// if a surface goes through the other, and in a stopped query if it is unknown.
    pub within: Option<Operand>,
}

impl<'t> Query<'t, Manifolds> {
    /// Asks for the contact manifolds of the meshes of `a` and `b`, where `b_in_a` maps B's
    /// coordinates into A's. The default skin is 0: only overlaps.
    #[must_use]
    pub fn manifolds(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        let options = ContactOptions {
            margin: 0.0,
            limit: usize::MAX,
        };
        Self::of([a, b], Manifolds { b_in_a, options })
    }

    /// Surfaces no farther apart than this have points of contact, in the length unit of the
    /// meshes; some that are farther apart by less than B is drawn in may have, too. Negative values
    /// and NaN count as 0. The work grows with the number of triangle pairs within the skin.
    #[must_use]
    pub fn skin(mut self, width: f64) -> Self {
        OptionError::note(&mut self.fault, "skin", width, f64::INFINITY);
        self.asked.options.margin = self.contacts_question().margin(width).asked.options.margin;
        self
    }

    /// True if a distance is within the skin.
    #[must_use]
    pub fn is_within(&self, distance: f64) -> bool {
        distance <= self.asked.options.margin
    }

    /// The query that lists the pairs.
    fn contacts_question(&self) -> Query<'t, crate::query::contacts::Contacts> {
        let query = Query::contacts(self.a, self.b, self.asked.b_in_a);
        match self.asked.options.margin {
            0.0 if self.radii() == 0.0 => query,
            skin => query.margin(skin.max(overlaps::reach(self.shape()))),
        }
    }

    fn shape(&self) -> Shape<'_> {
        Shape {
            trees: [self.a, self.b],
            b_in_a: &self.asked.b_in_a,
        }
    }

    /// Finds out whether one of two bodies that touch without a curve is inside the other.
    fn find_inner(
        &self,
        to_b: &Pose,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> StopReason {
        let end = deadline.step(workspace, |workspace, _| {
            let inner = workspace.state.manifolds.overlaps.inner(self.shape(), to_b);
            workspace.run.containment = Containment::Known(inner);
            workspace.run.stats.work += 2 * (WORK_PER_RAY + 2 * WORK_PER_RAY_TEST);
            Ok(())
        });
        end.err().unwrap_or(StopReason::Finished)
    }

    fn size(&self) -> f64 {
        self.a.size().min(self.b.size())
    }

    /// Writes the list: the deepest first, of equal ones in the order of discovery.
    fn write_list(
        &self,
        workspace: &mut Workspace,
        memory: Option<&mut ManifoldMemory>,
        to_b: &Pose,
        stop: StopReason,
    ) {
        let mut all = mem::take(&mut workspace.state.manifolds.list);
        all.clear();
        all.extend_from_slice(workspace.state.manifolds.overlaps.manifolds());
        let before = Before::new(memory.as_deref(), to_b, self.size());
        let reduction = &workspace.state.manifolds.reduction;
        reduction.skin.append_to(&mut all, before);
        number(&mut all);
        // A stable sort would allocate.
        all.sort_unstable_by(|x: &Manifold, y| {
            x.distance.total_cmp(&y.distance).then(x.id.cmp(&y.id))
        });
        match memory {
            Some(memory) => memory.assign(&mut all, to_b, self.size(), stop.is_final()),
            None => number(&mut all),
        }
        let radii = [self.a, self.b].map(Tree::radius);
        all.iter_mut().for_each(|one| one.thicken(radii));
        workspace.state.manifolds.list = all;
    }
}

impl Ask<Manifolds> for Query<'_, Manifolds> {
    fn key(&self) -> Key {
        Key::new(
            [self.a, self.b],
            self.asked.b_in_a,
            Asked::Manifolds(self.asked.options),
        )
    }

    fn begin(&self, workspace: &mut Workspace, memory: Option<&PairMemory>, budget: Budget) {
        self.contacts_question().begin(workspace, memory, budget);
        workspace.run.key = Some(self.key());
        let room = workspace.state.contacts.capacity();
        let state = &mut workspace.state.manifolds;
        let width = self.asked.options.margin + self.radii();
        let (reduction, overlaps) = (&mut state.reduction, &mut state.overlaps);
        reduction.begin(width, self.size(), self.shape(), overlaps);
        overlaps.reserve(room);
    }

    fn advance(
        &self,
        workspace: &mut Workspace,
        mut memory: Option<&mut PairMemory>,
        deadline: &mut Deadline,
    ) -> StopReason {
        let is_new = mem::replace(&mut workspace.state.manifolds.reduction.is_new, false);
        let known = memory
            .as_deref_mut()
            .map(|memory| memory.manifolds([self.a, self.b], is_new));
        let to_b = self.asked.b_in_a.inverse_unchecked();
        let mut stop = StopReason::Finished;
        if !workspace.state.manifolds.reduction.is_listed {
            stop = self.contacts_question().advance(workspace, None, deadline);
            workspace.state.manifolds.reduction.is_listed = stop.is_final();
        }
        if stop.is_final() && !workspace.state.manifolds.overlaps.is_done() {
            let before = Before::new(known.as_deref(), &to_b, self.size());
            stop = overlaps::advance(self.shape(), before, workspace, deadline);
        }
        if stop == StopReason::Finished && self.may_contain() {
            stop = if workspace.state.manifolds.overlaps.meets() {
                self.find_inner(&to_b, workspace, deadline)
            } else {
                self.ask_containment(&self.asked.b_in_a, workspace, deadline)
            };
        }
        workspace.run.stopped = !stop.is_final();
        self.write_list(workspace, known, &to_b, stop);
        if let Some(memory) = memory {
            memory.learn(
                Sought::Manifolds,
                workspace,
                workspace.work(),
                stop.is_final(),
            );
        }
        stop
    }

    fn answer(&self, workspace: &Workspace, stop: StopReason) -> ManifoldBounds {
        let meets = workspace.state.manifolds.overlaps.meets();
        let low = if stop.is_final() {
            f64::INFINITY
        } else if meets || workspace.state.manifolds.overlaps.is_open() {
            0.0
        } else {
            thinner(workspace.state.distance.interval.low(), self.radii())
        };
        let nearest = workspace.state.manifolds.reduction.nearest;
        let ids = |[x, y]: [u32; 2]| [self.a.ids()[x as usize], self.b.ids()[y as usize]];
        let radii = self.radii();
        ManifoldBounds {
            low,
            meets: meets || nearest.is_some_and(|(_, distance)| distance <= radii),
            nearest: nearest.map(|(pair, distance)| (ids(pair), distance - radii)),
            within: workspace.run.containment.inner(),
        }
    }

    fn left(&self, workspace: &Workspace, memory: Option<&PairMemory>) -> (Quantiles, Option<f64>) {
        let model = manifolds_left(&self.listing(workspace));
        let done = workspace.work() as f64;
        (
            self.predicted(memory, Sought::Manifolds, done, model, |_| None),
            None,
        )
    }
}
