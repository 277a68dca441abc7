//! Penetration depth: how far one body has to move until it no longer penetrates another, as an
//! interval with both ends proven, and a push (a translation) that separates them.
//!
//! It is a caller of [`punctual::Query`]. Contacts give directions, bisection the least length
//! along each, and the faces of obstacles better directions: `high` is the length of the shortest
//! push after which an exact query, or a plane, finds the bodies apart. `low` comes from a cover of
//! the shorter translations: it is the least radius of the cones around 0. The search advances the
//! cone with the least radius by a set that it knows. If none helps, it asks what blocks a push
//! along the middle of the cone: either nothing does, and the push is shorter than the best, or two
//! triangles do, which give new sets.
//!
//! Convex components come first: an expanding polytope in the difference of two of them (module
//! `convex`) gives both bounds at once, and mostly ends the search.
//!
//! A set is the translations at which two triangles meet (module `sets`), or a ball: the bodies
//! meet where a ball inside A overlaps one inside B, or holds a point of B's surface.
//!
//! The search is a machine (`machine`): each step does little work, or puts one question to the
//! trees, and changes the state only when the answer is complete. So it stops and continues
//! anywhere.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(doctest, doc = include_str!("../README.md"))]

extern crate alloc;

mod balls;
mod cones;
mod convex;
mod cover;
mod directions;
mod machine;
mod pushes;
mod sets;

use glam::DVec3;
use machine::{Machine, State};
use punctual::clock::ClockedBudget;
use punctual::{Answer, ResumeError, Tree, Workspace};
use punctual_geom::Pose;
use sets::Sets;

/// Maximum work by which a penetration query exceeds a budget of work.
pub const MAX_PENETRATION_STEP_WORK: u64 = 4096;

/// The default of [`PenetrationQuery::relative_tolerance`].
const TOLERANCE: f64 = 1e-3;

/// Asks how deep A and B penetrate each other: how far B has to be moved, at least, until they are
/// apart, and in which direction. Cheap to make; make one for each pose.
///
/// **Guarantee.** `low <= depth <= high`, whenever it stops: at no translation of B shorter than
/// `low` are they apart, and a push of the length `high` is known at which an exact query, run to
/// its end, or a plane between the two found them apart. Both bounds only improve with more budget
/// of work. Where they are apart at the pose itself, both are 0.
///
/// Trees may have a [radius](punctual::Tree::with_radius): the search is about the cores first,
/// then about pushes of the thickened bodies. The bounds hold; how tight they end is not promised.
///
/// Apart means: no triangle of A shares a point with one of B. With [`solid`](Self::solid) it also
/// means that no component of one mesh is inside of the other.
///
/// **Which bodies finish tight.** Build trees as solids
/// ([`BuildOptions::solid`](punctual::BuildOptions::solid)): closed meshes tell inside from
/// outside.
///
/// | bodies | `high` over `low` when it is finished | time |
/// |---|---|---|
/// | both closed and convex, such as hulls and boxes | the tolerance | microseconds |
/// | convex components, such as decomposed meshes | the tolerance where one pair decides | some queries more |
/// | closed, not convex | the tolerance if shallow, 1.0 to 2 if deep | milliseconds, give a budget |
/// | open surfaces | the tolerance if the triangles are large and the contact shallow | as long |
/// | bodies that only touch, coincident surfaces | `low` is 0, `high` a rounding | as for shallow contact |
///
/// Convex means up to a thousandth of the size: rounded corners of a hull may bend faces inwards,
/// and widen the interval by as much. A mesh of many components in a solid counts as convex
/// components only if all of them are convex; at most 256 pairs are tried.
///
/// **What the tolerance means.** The query is finished when `high <= (1 + relative_tolerance) low`,
/// when `high <= low + absolute_tolerance`, when both differ by no more than the rounding of
/// coordinates (about `1e-12` times the largest of them), or when it can do no more. The depth is
/// in the interval in any case. With [`deeper_than`](Self::deeper_than) the tolerances do not end
/// it.
///
/// ```
/// use punctual::glam::DMat3;
/// use punctual::tree::Solid;
/// use punctual::{Budget, BuildOptions, Pose, Tree, shapes};
/// use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
/// let options = BuildOptions::default().solid(Solid::Keep);
/// let ring = Tree::with_options(shapes::torus(1.0, 0.3, 24), &options);
/// let ball = Tree::with_options(shapes::icosphere(3), &options);
/// let mut workspace = PenetrationWorkspace::new();
/// let pose = Pose::new(DMat3::IDENTITY, [2.2, 0.1, 0.0])?;
/// let query = PenetrationQuery::new(&ring, &ball, pose).solid(true);
/// let mut depth = query.run(&mut workspace, Budget::work(50_000));
/// println!("between {} and {}", depth.value.low, depth.value.high);
/// depth = query.resume(&mut workspace, Budget::work(2_000_000))?;
/// assert!(0.08 < depth.value.low && depth.value.high < 0.11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PenetrationQuery<'t> {
    a: &'t Tree,
    b: &'t Tree,
    asked: Asked,
}

/// All of a query but its trees.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Asked {
    b_in_a: Pose,
    solid: bool,
    push_only: bool,
    tolerance: f64,
    absolute_tolerance: f64,
    limit: f64,
}

/// Calls with equal keys belong to one query.
type Key = ([usize; 2], Asked);

/// The answer to a [`PenetrationQuery`]: `low <= depth <= high`, in the length unit of the meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct Penetration {
    /// Proven lower bound: no shorter translation separates them.
    pub low: f64,
    /// Proven upper bound: the length of the push. 0 if they are apart; infinite if no push was
    /// found yet.
    #[cfg_attr(feature = "serde", serde(with = "punctual_geom::bound"))]
    pub high: f64,
    /// Direction in which B moves by `high`: a unit vector in A's frame. `None` if they are apart,
    /// or no push was found yet.
    pub direction: Option<DVec3>,
    /// The pose after the push, at which they are apart: `direction * high` is added to the
    /// translation. The pose that was asked about if there is no direction.
    pub b_in_a: Pose,
    /// True if they penetrate deeper than [`PenetrationQuery::deeper_than`] says. `None` if that is
    /// undecided, or no limit was set.
    pub deeper: Option<bool>,
}

/// All that changes during a [`PenetrationQuery`], owned by the caller, about 2 MB. It does not
/// allocate after it was made.
#[derive(Debug)]
pub struct PenetrationWorkspace {
    engine: Workspace,
    sets: Sets,
    state: Option<State>,
}

impl Default for PenetrationWorkspace {
    fn default() -> Self {
        Self::new()
    }
}

impl PenetrationWorkspace {
    /// Makes room for all that a query needs.
    #[must_use]
    pub fn new() -> Self {
        Self::with_engine(Workspace::with_capacity(4096, machine::CONTACTS))
    }

    /// Uses this workspace for the queries of which a penetration query consists.
    #[must_use]
    pub fn with_engine(mut engine: Workspace) -> Self {
        engine.reserve_points(1);
        engine.reserve_containment();
        Self {
            engine,
            sets: Sets::new(),
            state: None,
        }
    }
}

impl<'t> PenetrationQuery<'t> {
    /// Asks about the meshes of `a` and `b`, where `b_in_a` brings B's coordinates into A's.
    #[must_use]
    pub fn new(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        let asked = Asked {
            b_in_a,
            solid: false,
            push_only: false,
            tolerance: TOLERANCE,
            absolute_tolerance: 0.0,
            limit: f64::INFINITY,
        };
        Self { a, b, asked }
    }

    /// Takes closed meshes as solids: a mesh inside of the other penetrates it. Needs trees built
    /// as solids; others count as surfaces.
    #[must_use]
    pub fn solid(mut self, solid: bool) -> Self {
        self.asked.solid = solid;
        self
    }

    /// Looks only for a short push: `low` stays 0. The query is finished when it has tried 32
    /// directions all around and those near the best one. A shorter push may exist
    /// (`docs/guide/push_out.md`).
    ///
    /// ```
    /// use punctual::glam::{DMat3, DVec3};
    /// use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
    /// use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
    /// let (a, b) = (Tree::new(shapes::icosphere(3)), Tree::new(shapes::icosphere(3)));
    /// let mut workspace = PenetrationWorkspace::new();
    /// let pose = Pose::new(DMat3::IDENTITY, DVec3::new(1.9, 0.1, 0.0))?;
    /// let query = PenetrationQuery::new(&a, &b, pose).push_only(true);
    /// let push = query.run(&mut workspace, Budget::work(1_000_000)).value;
    /// assert!(push.high < 0.12 && push.direction.unwrap().x > 0.9);
    /// let query = Query::intersection(&a, &b, push.b_in_a);
    /// let verdict = query.run(&mut Workspace::new(), Budget::unlimited()).value;
    /// assert_eq!(verdict, Verdict::Separated);
    /// # Ok::<(), punctual::PoseError>(())
    /// ```
    #[must_use]
    pub fn push_only(mut self, push_only: bool) -> Self {
        self.asked.push_only = push_only;
        self
    }

    /// The query is finished as soon as `high <= (1 + share) low`. 0.001 by default; negative
    /// values and NaN count as 0.
    #[must_use]
    pub fn relative_tolerance(mut self, share: f64) -> Self {
        self.asked.tolerance = share.max(0.0);
        self
    }

    /// The query is finished as soon as `high <= low + length`, too. 0 by default; negative values
    /// and NaN count as 0. Whatever the tolerances, it is finished once the bounds differ by no
    /// more than the rounding of coordinates.
    #[must_use]
    pub fn absolute_tolerance(mut self, length: f64) -> Self {
        self.asked.absolute_tolerance = length.max(0.0);
        self
    }

    /// Asks only whether they penetrate deeper than this: the counterpart of
    /// [`Query::closer_than`](punctual::Query::closer_than) for a negative distance. The query is
    /// finished as soon as one of the bounds decides; [`Penetration::deeper`] has the answer. The
    /// tolerances do not end it. It stays undecided if the depth is the limit up to rounding, or if
    /// no more can be found out. Infinity disables the limit. Negative values and NaN count as 0.
    #[must_use]
    pub fn deeper_than(mut self, depth: f64) -> Self {
        self.asked.limit = depth.max(0.0);
        self
    }

    /// Runs within a budget. It does not allocate, lock or panic.
    pub fn run<'c>(
        &self,
        workspace: &mut PenetrationWorkspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Answer<Penetration> {
        let state = workspace.state.insert(State::new(self));
        workspace.engine.forget_run();
        workspace.sets.clear();
        let parts = (&mut workspace.engine, &mut workspace.sets, state);
        let mut machine = Machine::new(self, parts, budget.into());
        machine.state.task = machine.convex_task(0);
        machine.run()
    }

    /// Continues the stopped run that the workspace holds, with a fresh budget.
    ///
    /// However budgets of work cut a query into calls, the last answer equals that of one
    /// uninterrupted run.
    ///
    /// # Errors
    /// If the last run in this workspace was not of this query (the same trees, pose and options),
    /// or is complete.
    pub fn resume<'c>(
        &self,
        workspace: &mut PenetrationWorkspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Answer<Penetration>, ResumeError> {
        let state = workspace.state.as_mut();
        let is_stopped = |state: &&mut State| state.key == self.key() && !state.is_over();
        let state = state.filter(is_stopped).ok_or(ResumeError)?;
        let parts = (&mut workspace.engine, &mut workspace.sets, state);
        Ok(Machine::new(self, parts, budget.into()).run())
    }

    fn key(&self) -> Key {
        ([self.a, self.b].map(Tree::identity), self.asked)
    }
}
