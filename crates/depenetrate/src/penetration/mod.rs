//! The penetration depth of two bodies as an interval that only shrinks.
//!
//! `high` is the length of a push, that is, a translation of B after which an exact query finds the
//! bodies apart. `low` comes from a [`cover`](crate::cover) of the shorter translations: it is the
//! least radius of the cones around 0. The search advances the cone with the least radius by a set
//! that it knows. If none helps, it asks what blocks a push along the middle of the cone: either
//! nothing does, and the push is shorter than the best, or two triangles do, which give new sets.
//!
//! A set is the translations at which two triangles meet, or a ball. A point of B's surface that is
//! inside of A, where A is closed, stays inside while B moves by less than the distance of the
//! point from A's surface. A point inside of both solids gives a ball whose radius is the sum of
//! its distances from both surfaces.
//!
//! The search is a machine: each step does little work, or puts one question to the trees, and the
//! answer changes the state only when it is complete. So it stops and continues anywhere.

mod balls;
mod cones;
mod pushes;
mod questions;
mod state;

use crate::blocked::Pool;
use crate::cover::{Advance, Ball, Cone, Pair, Rays};
use crate::directions::Segments;
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual::clock::ClockedBudget;
use punctual::engine::Deadline;
use punctual::{Answer, Mesh, PairMemory, ResumeError, Stats, Tree, Workspace};
use punctual_geom::Pose;

/// Maximum work by which a penetration query exceeds a budget of work.
pub const MAX_PENETRATION_STEP_WORK: u64 = 4096;

/// Work of the longest step outside of queries.
const STEP: u64 = MAX_PENETRATION_STEP_WORK;

/// Work to make a pair, to try one, to compare its box, to prove it, and to try a ball.
const WORK_PER_NEW_PAIR: u64 = 400;
const WORK_PER_PAIR: u64 = 150;
const WORK_PER_BOX: u64 = 4;
const WORK_PER_PROOF: u64 = 1200;
const WORK_PER_BALL: u64 = 60;
/// Work to count along a ray, and to look at a component of a solid.
const WORK_PER_RAY: u64 = 1000;

/// Pairs of triangles in contact that are read, and those read at a pushed pose.
const CONTACTS: usize = 256;
const CONTACTS_AHEAD: usize = 48;

/// Capacities: pairs and balls known, cones open, points that are known to be deep.
const PAIRS: usize = 512;
const BALLS: usize = 64;
const CONES: usize = 4096;
const POINTS: usize = 24;

/// The search ends after this many advances of a cone.
const ADVANCES: u32 = 20_000;

/// A push is tried at this share of the best, and bisected to this relative width.
const SHORTER: f64 = 0.98;
const WIDTH: f64 = 0.01;

/// The first push is at most this many times as long as the contact; a push that is too short is
/// lengthened by this factor.
const GROWTH: f64 = 1.7;

/// A ball is sought at so many points for each cone.
const POINTS_A_CONE: usize = 5;

/// Places from which a point deep in both solids is sought; from this one on they are random. The
/// best of them is where the climb begins.
const SEEDS: usize = 40;
const RANDOM_SEEDS: usize = 9;

/// Trials of a climb, at first and for a cone.
const CLIMB: u32 = 80;
const SHORT_CLIMB: u32 = 10;

/// Cones that were split as often as this get no climb of their own.
const CLIMBING_LEVELS: u8 = 6;

/// Summits that are kept to begin further climbs.
const SUMMITS: usize = 32;

/// Without a ball that is as large as this share of the best push, a point deep in both is sought
/// at once; otherwise after so many advances of cones.
const DEEP: f64 = 0.9;
const ADVANCES_BEFORE_CLIMBS: u32 = 60;

/// The default of [`PenetrationQuery::relative_tolerance`].
const TOLERANCE: f64 = 1e-3;

/// A direction along a coordinate axis, and the next ones.
const AXES: [DVec3; 6] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::NEG_X,
    DVec3::NEG_Y,
    DVec3::NEG_Z,
];

/// Asks how deep A and B penetrate each other: how far B has to be moved, at least, until they are
/// apart. Cheap to make; make one for each pose.
///
/// **Guarantee.** `low <= depth <= high`, whenever it stops: at no translation of B shorter than
/// `low` are they apart, and a push of the length `high` is known at which an exact query, run to
/// its end, found them apart. Both bounds only improve. Where they are apart at the pose itself,
/// both are 0.
///
/// Apart means: no triangle of A shares a point with one of B. With [`solid`](Self::solid) it also
/// means that no component of one mesh is inside of the other.
///
/// `low` is best for meshes of large triangles, and for trees built as solids
/// ([`BuildOptions::solid`](punctual::BuildOptions::solid)), whose closed components tell inside
/// from outside. The depth of coincident surfaces is 0, as is their `low`.
///
/// ```
/// use punctual::glam::DMat3;
/// use punctual::tree::Solid;
/// use punctual::{Budget, BuildOptions, Pose, Tree, shapes};
/// use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
/// let options = BuildOptions::default().solid(Solid::Keep);
/// let ball = Tree::with_options(shapes::icosphere(3), &options);
/// let mut workspace = PenetrationWorkspace::new();
/// let pose = Pose::new(DMat3::IDENTITY, [1.9, 0.1, 0.0])?;
/// let query = PenetrationQuery::new(&ball, &ball, pose).solid(true);
/// let mut depth = query.run(&mut workspace, Budget::work(200_000));
/// println!("between {} and {}", depth.value.low, depth.value.high);
/// depth = query.resume(&mut workspace, Budget::work(2_000_000))?;
/// assert!(0.08 < depth.value.low && depth.value.high < 0.11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PenetrationQuery<'t> {
    a: &'t Tree,
    b: &'t Tree,
    b_in_a: Pose,
    solid: bool,
    tolerance: f64,
    limit: f64,
}

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
    /// True if they penetrate deeper than [`PenetrationQuery::deeper_than`] says. `None` if that is
    /// undecided, or no limit was set.
    pub deeper: Option<bool>,
}

/// All that changes during a [`PenetrationQuery`], owned by the caller, about 2 MB. It does not
/// allocate after it was made.
#[derive(Debug)]
pub struct PenetrationWorkspace {
    engine: Workspace,
    /// A mesh that is one point.
    point: Option<Tree>,
    state: State,
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
        Self::with_engine(Workspace::with_capacity(4096, CONTACTS))
    }

    /// Uses this workspace for the queries of which a penetration query consists.
    #[must_use]
    pub fn with_engine(engine: Workspace) -> Self {
        Self {
            engine,
            point: Mesh::new([[0f32; 3]], [[0, 0, 0]]).ok().map(Tree::new),
            state: State::new(),
        }
    }
}

impl<'t> PenetrationQuery<'t> {
    /// Asks about the meshes of `a` and `b`, where `b_in_a` brings B's coordinates into A's.
    #[must_use]
    pub fn new(a: &'t Tree, b: &'t Tree, b_in_a: Pose) -> Self {
        Self {
            a,
            b,
            b_in_a,
            solid: false,
            tolerance: TOLERANCE,
            limit: f64::INFINITY,
        }
    }

    /// Takes the closed components of both meshes as solids: a mesh inside of the other penetrates
    /// it. Needs trees built as solids; others count as surfaces.
    #[must_use]
    pub fn solid(mut self, solid: bool) -> Self {
        self.solid = solid;
        self
    }

    /// The query is finished as soon as `high <= (1 + share) low`. 0.001 by default; negative
    /// values and NaN count as 0.
    #[must_use]
    pub fn relative_tolerance(mut self, share: f64) -> Self {
        self.tolerance = share.max(0.0);
        self
    }

    /// Asks only whether they penetrate deeper than this: the counterpart of
    /// [`Query::closer_than`](punctual::Query::closer_than) for a negative distance. The query is
    /// finished as soon as one of the bounds decides;
    /// [`Penetration::deeper`] has the answer. Infinity disables the limit. Negative values and NaN
    /// count as 0.
    #[must_use]
    pub fn deeper_than(mut self, depth: f64) -> Self {
        self.limit = depth.max(0.0);
        self
    }

    /// Runs within a budget. It does not allocate, lock or panic.
    pub fn run<'c>(
        &self,
        workspace: &mut PenetrationWorkspace,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Answer<Penetration> {
        workspace.state.begin(self);
        self.spend(workspace, budget.into())
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
        let state = &workspace.state;
        if state.key != Some(self.key()) || matches!(state.job, Job::Over) {
            return Err(ResumeError);
        }
        Ok(self.spend(workspace, budget.into()))
    }

    fn spend(
        &self,
        workspace: &mut PenetrationWorkspace,
        budget: ClockedBudget<'_>,
    ) -> Answer<Penetration> {
        let mut deadline = Deadline::of(budget);
        let PenetrationWorkspace {
            engine,
            point,
            state,
        } = workspace;
        let mut machine = Machine {
            asked: self,
            engine,
            point: point.as_ref(),
            state,
            deadline: &mut deadline,
        };
        let stop = machine.advance();
        let state = &mut workspace.state;
        state.took(deadline.elapsed());
        Answer::of(state.penetration(self.limit), stop, state.stats)
    }

    fn key(&self) -> Key {
        Key {
            trees: [self.a, self.b].map(Tree::identity),
            b_in_a: self.b_in_a,
            solid: self.solid,
            tolerance: self.tolerance,
            limit: self.limit,
        }
    }
}

/// Calls with equal keys belong to one query.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    trees: [usize; 2],
    b_in_a: Pose,
    solid: bool,
    tolerance: f64,
    limit: f64,
}

/// A question to the trees. B is moved by `at`.
#[derive(Clone, Copy, Debug)]
enum Asking {
    /// Triangles in contact, at most so many.
    Contacts { at: DVec3, most: usize },
    /// Whether the surfaces are apart.
    Apart { at: DVec3 },
    /// Whether a component is inside of the other body: those from `next` on, of A, then of B.
    Contained { at: DVec3, next: usize },
    /// How far the surface of A, or of B, is from a point of its frame.
    Near { of_b: bool, point: DVec3 },
}

/// What it gave.
#[derive(Clone, Copy, Debug)]
enum Heard {
    /// The contacts are in the workspace of the engine.
    Contacts(usize),
    /// Two triangles that meet, if surfaces do.
    Blocked(Option<[u32; 2]>),
    Apart,
    /// A lower bound of the distance, and the nearest point found.
    Near(f64, DVec3),
}

/// What the search does; see [`Machine::step`] and [`Machine::hear`].
#[derive(Clone, Copy, Debug)]
enum Job {
    /// Lists the contacts at the pose.
    Contacts,
    /// Reads those from here on.
    Read(usize),
    /// Tries the next of the likely directions.
    Explore,
    /// Lengthens a push until it separates.
    Lengthen {
        direction: DVec3,
        length: f64,
        longest: f64,
    },
    /// Bisects the length of a push.
    Shorten {
        direction: DVec3,
        low: f64,
        high: f64,
    },
    /// Makes a ball about 0 of the point of this number.
    About(usize),
    Start,
    /// Tries to climb from the place of this number.
    Seek(usize),
    Climb(Climb),
    /// Takes the next cone.
    Pick,
    Advance(Task),
    Over,
}

/// A cone that is advanced.
#[derive(Clone, Copy, Debug)]
struct Task {
    cone: Cone,
    rays: Rays,
    /// The radius that is proven by now, and what the best pair would give.
    proven: f64,
    best: Option<(Advance, u16)>,
    stage: Stage,
}

#[derive(Clone, Copy, Debug)]
enum Stage {
    Balls,
    /// Tries the pairs from here on; whether their answer is the last hope before a split.
    Pairs {
        next: usize,
        last: bool,
    },
    /// Asks what blocks a push that is nearly as long as the best.
    Block,
    /// Makes balls of the latest points, far out or near.
    Points {
        next: usize,
        near: bool,
    },
    /// Lists the contacts just outside of the radius.
    Contacts,
    Read(usize),
    /// No surfaces meet there: asks whether a push to there separates.
    Free,
    Split,
}

/// A climb to a point deep in both solids while B is moved by `at`.
#[derive(Clone, Copy, Debug)]
struct Climb {
    number: usize,
    at: DVec3,
    best: DVec3,
    sum: f64,
    step: f64,
    least: f64,
    left: u32,
    /// Number of the trial among six of a compass, which is turned now and then.
    side: usize,
    turns: u64,
    trial: DVec3,
    of_a: Option<f64>,
    cone: Option<Task>,
}

/// A corner of a surface that may be deep in the other body.
#[derive(Clone, Debug)]
struct Point {
    of_b: bool,
    /// In A's frame, before B is moved.
    place: DVec3,
    /// Points of the other surface, in that body's frame, that were nearest to it.
    near: ArrayVec<DVec3, 6>,
    /// Translations of B, with the radii of balls about them in which the point stays inside.
    inside: ArrayVec<(DVec3, f64), 6>,
}

/// Indices of [`State::trials`].
const POINTS_TRIED: usize = 0;
const CLIMBS: usize = 1;
const LISTS: usize = 2;

/// What a kind of attempt was good for, so that one that seldom helps is made seldom.
#[derive(Clone, Copy, Debug, Default)]
struct Trials {
    made: u32,
    gained: u32,
    skipped: u32,
}

impl Trials {
    fn note(&mut self, gains: bool) {
        self.made += 1;
        self.gained += u32::from(gains);
    }

    /// True if it is worth another attempt: one in eight was, or the last seven were skipped.
    fn is_due(&mut self) -> bool {
        self.skipped += 1;
        let is_due = self.made < 8 || 8 * self.gained >= self.made || self.skipped >= 8;
        if is_due {
            self.skipped = 0;
        }
        is_due
    }
}

#[derive(Debug)]
struct State {
    key: Option<Key>,
    job: Job,
    asking: Option<(Asking, bool)>,
    memory: PairMemory,
    blocked: Pool,
    segments: Option<Segments>,
    likely: ArrayVec<DVec3, 60>,
    /// How many of them were tried.
    explored: usize,
    pairs: Vec<Pair>,
    bounds: Vec<[DVec3; 2]>,
    ids: Vec<[u32; 2]>,
    next_pair: usize,
    /// The pair with the largest margin.
    widest: (f64, usize),
    balls: Vec<Ball>,
    next_ball: usize,
    points: ArrayVec<Point, POINTS>,
    /// Translations of B, with points that are deep in both solids then.
    summits: ArrayVec<(DVec3, DVec3), SUMMITS>,
    next_summit: usize,
    /// The best place to begin a climb from, after its sum of distances.
    seed: Option<(f64, DVec3)>,
    /// How often points, climbs and lists of contacts gained something for a cone.
    trials: [Trials; 3],
    /// Climbs were begun while B is not moved.
    has_sought: bool,
    cones: BinaryHeap<Cone>,
    number: u32,
    advances: u32,
    /// No translation that is shorter separates.
    low: f64,
    high: f64,
    direction: DVec3,
    is_apart: bool,
    has_all_directions: bool,
    /// Largest rounding of a coordinate of B after a push.
    rounding: f64,
    /// Lengths in B's frame are at least so much in A's.
    least_scale: f64,
    back: Pose,
    /// Per tree: whether a point of the other that is inside of it is proven to stay in contact,
    /// and for how long a translation.
    inner: [f64; 2],
    stats: Stats,
}

struct Machine<'s, 't, 'd, 'c> {
    asked: &'s PenetrationQuery<'t>,
    engine: &'s mut Workspace,
    point: Option<&'s Tree>,
    state: &'s mut State,
    deadline: &'d mut Deadline<'c>,
}
