//! The penetration depth of two bodies as an interval that only shrinks.
//!
//! `high` is the length of a push, that is, a translation of B after which an exact query finds the
//! bodies apart. `low` comes from a [`cover`](super::cover) of the shorter translations: it is the
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

use super::blocked::{Pool, unit};
use super::cover::{Advance, Ball, Cone, Pair, Rays};
use super::directions::{Segments, all_around};
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::time::Duration;
use glam::{DMat3, DVec3};
use punctual::clock::ClockedBudget;
use punctual::distance::Distance;
use punctual::engine::{Ask, Deadline, crossings};
use punctual::intersection::Intersection;
use punctual::{
    Answer, Budget, Mesh, PairMemory, Query, ResumeError, Stats, StopReason, Tree, Workspace,
};
use punctual_geom::Pose;
use punctual_geom::random::Random;

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

/// Trials of a climb to a point deep in both solids, at first and for a cone.
const CLIMB: u32 = 60;
const SHORT_CLIMB: u32 = 10;

/// Cones that were split as often as this get no climb of their own.
const CLIMBING_LEVELS: u8 = 6;

/// Summits that are kept to begin further climbs.
const SUMMITS: usize = 32;

/// Without a ball that is as large as this share of the best push, a point deep in both is sought
/// at once; otherwise after so many advances of cones.
const DEEP: f64 = 0.6;
const ADVANCES_BEFORE_CLIMBS: u32 = 60;

/// The default of [`PenetrationQuery::relative_tolerance`].
const TOLERANCE: f64 = 1e-3;

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

    /// Asks only whether they penetrate deeper than this: whether the depth, minus the signed
    /// distance, is at least so much. The query is finished as soon as one of the bounds decides;
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

impl State {
    fn new() -> Self {
        Self {
            pairs: Vec::with_capacity(PAIRS),
            bounds: Vec::with_capacity(PAIRS),
            ids: Vec::with_capacity(PAIRS),
            balls: Vec::with_capacity(BALLS),
            cones: BinaryHeap::with_capacity(CONES),
            ..Self::blank()
        }
    }

    /// A state without room for anything.
    fn blank() -> Self {
        Self {
            key: None,
            job: Job::Over,
            asking: None,
            memory: PairMemory::without_clearance(),
            blocked: Pool::default(),
            segments: None,
            likely: ArrayVec::new(),
            explored: 0,
            pairs: Vec::new(),
            bounds: Vec::new(),
            ids: Vec::new(),
            next_pair: 0,
            widest: (0.0, 0),
            balls: Vec::new(),
            next_ball: 0,
            points: ArrayVec::new(),
            summits: ArrayVec::new(),
            next_summit: 0,
            has_sought: false,
            cones: BinaryHeap::new(),
            number: 0,
            advances: 0,
            low: 0.0,
            high: f64::INFINITY,
            direction: DVec3::ZERO,
            is_apart: false,
            has_all_directions: false,
            rounding: 0.0,
            least_scale: 1.0,
            back: Pose::IDENTITY,
            inner: [0.0; 2],
            stats: Stats::default(),
        }
    }

    /// Starts a new run.
    fn begin(&mut self, asked: &PenetrationQuery<'_>) {
        let (pairs, bounds, ids) = (
            core::mem::take(&mut self.pairs),
            core::mem::take(&mut self.bounds),
            core::mem::take(&mut self.ids),
        );
        let (balls, cones) = (
            core::mem::take(&mut self.balls),
            core::mem::take(&mut self.cones),
        );
        *self = Self {
            pairs: emptied(pairs),
            bounds: emptied(bounds),
            ids: emptied(ids),
            balls: emptied(balls),
            cones: BinaryHeap::from(emptied(cones.into_vec())),
            key: Some(asked.key()),
            job: Job::Contacts,
            ..Self::blank()
        };
        let pose = &asked.b_in_a;
        let largest = |tree: &Tree| {
            let bounds = tree.mesh().aabb();
            bounds.min.abs().max(bounds.max.abs()).max_element()
        };
        let magnitude =
            largest(asked.a) + 4.0 * largest(asked.b) + pose.translation().abs().max_element();
        self.rounding = ROUNDING * magnitude + f64::MIN_POSITIVE;
        let rotation = pose.rotation();
        let defect = rotation.transpose() * *rotation - DMat3::IDENTITY;
        let defect = defect
            .to_cols_array()
            .into_iter()
            .fold(0.0, |most: f64, entry| most.max(entry.abs()));
        self.least_scale = libm::sqrt((1.0 - 3.0 * defect).max(0.0)) * (1.0 - 1e-12);
        match pose.inverse() {
            Ok(back) => self.back = back,
            // Nothing is measured in B's frame.
            Err(_) => self.least_scale = 0.0,
        }
        self.inner = [asked.inner(false), asked.inner(true)];
    }

    fn penetration(&self, limit: f64) -> Penetration {
        let found = self.high < f64::INFINITY && !self.is_apart;
        let deeper = match limit {
            f64::INFINITY => None,
            _ if self.low >= limit && self.low > 0.0 => Some(true),
            _ if self.high <= limit => Some(false),
            _ => None,
        };
        Penetration {
            low: self.low,
            high: self.high,
            direction: found.then_some(self.direction),
            deeper,
        }
    }

    fn took(&mut self, elapsed: Option<Duration>) {
        if let Some(elapsed) = elapsed {
            let total = &mut self.stats.elapsed;
            *total = Some(total.unwrap_or_default().saturating_add(elapsed));
        }
    }

    /// Keeps a pair, in the place of the oldest if there is no room. Returns its number.
    fn add_pair(&mut self, id: [u32; 2], corners: [[DVec3; 3]; 2]) -> usize {
        if let Some(known) = self.ids.iter().position(|&other| other == id) {
            return known;
        }
        let pair = Pair::new(corners);
        let at = if self.pairs.len() < PAIRS {
            self.pairs.push(pair);
            self.bounds.push(pair.bounds());
            self.ids.push(id);
            self.pairs.len() - 1
        } else {
            let at = self.next_pair;
            self.next_pair = (at + 1) % PAIRS;
            (self.pairs[at], self.bounds[at], self.ids[at]) = (pair, pair.bounds(), id);
            at
        };
        at
    }

    fn keep_ball(&mut self, ball: Ball) {
        if self.balls.len() < BALLS {
            self.balls.push(ball);
        } else {
            self.balls[self.next_ball] = ball;
            self.next_ball = (self.next_ball + 1) % BALLS;
        }
    }

    /// Keeps a summit, in the place of the oldest if there is no room.
    fn keep_summit(&mut self, summit: (DVec3, DVec3)) {
        if self.summits.try_push(summit).is_err() {
            self.summits[self.next_summit] = summit;
            self.next_summit = (self.next_summit + 1) % SUMMITS;
        }
    }

    fn add_cone(&mut self, cone: Cone) {
        self.number += 1;
        self.cones.push(Cone {
            number: self.number,
            ..cone
        });
    }

    /// A push of this length is proven to separate.
    fn separates(&mut self, direction: DVec3, length: f64) {
        if length < self.high {
            (self.high, self.direction) = (length, direction);
        }
    }

    /// True if a new radius is worth another turn of the same cone.
    fn is_gain(&self, cone: &Cone, radius: f64) -> bool {
        let goal = self.high.min(4.0 * cone.radius);
        radius >= self.high || radius > cone.radius + 0.25 * (goal - cone.radius)
    }

    /// Keeps the corner of a triangle that is deepest in the other body for a push along
    /// `direction`.
    fn add_point(&mut self, of_b: bool, corners: &[DVec3; 3], direction: DVec3) {
        let toward = if of_b { -direction } else { direction };
        let deepest = corners
            .iter()
            .max_by(|p, q| p.dot(toward).total_cmp(&q.dot(toward)));
        let Some(&place) = deepest else { return };
        let known = |point: &Point| point.of_b == of_b && point.place == place;
        let point = match self.points.iter().position(known) {
            Some(at) => self.points.remove(at),
            None => Point {
                of_b,
                place,
                near: ArrayVec::new(),
                inside: ArrayVec::new(),
            },
        };
        if self.points.is_full() {
            // The oldest that was found outside, or else the oldest.
            let is_outside = |point: &Point| point.inside.is_empty() && !point.near.is_empty();
            let worst = self.points.iter().position(is_outside);
            self.points.remove(worst.unwrap_or(0));
        }
        self.points.push(point);
    }
}

/// The vector without its elements.
fn emptied<T>(mut all: Vec<T>) -> Vec<T> {
    all.clear();
    all
}

/// A direction along a coordinate axis, and the next ones.
const AXES: [DVec3; 6] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::NEG_X,
    DVec3::NEG_Y,
    DVec3::NEG_Z,
];

/// Rounding of a coordinate of B after a push, relative to the coordinates: proof in
/// `docs/numerics.md`.
const ROUNDING: f64 = 32.0 * f64::EPSILON; // 64 U

/// How many corners of a mesh are looked at to find one that is far outside of the other.
const SAMPLES: usize = 256;

impl PenetrationQuery<'_> {
    /// For how long a push a point of the other body that is inside of A (of B) proves that they
    /// are not apart.
    ///
    /// For solids that is for ever. For surfaces it is as long as another point of the same
    /// component stays outside, as one does that is far from the box.
    fn inner(&self, of_b: bool) -> f64 {
        let (body, other) = if of_b {
            (self.b, self.a)
        } else {
            (self.a, self.b)
        };
        let has_inside = |tree: &Tree| {
            let solidity = tree.solid();
            solidity.is_some_and(|solidity| solidity.components().iter().any(|c| c.is_closed()))
        };
        if !has_inside(body) {
            return 0.0;
        }
        if self.solid {
            return f64::INFINITY;
        }
        let is_one = |tree: &Tree| {
            let solidity = tree.solid();
            solidity.is_some_and(|solidity| solidity.components().len() == 1)
        };
        if !is_one(other) {
            return 0.0;
        }
        let bounds = if of_b {
            self.b.aabb_at(&self.b_in_a)
        } else {
            self.a.mesh().aabb()
        };
        let count = other.mesh().len();
        let distance = |triangle: usize| {
            let [corner, ..] = other.mesh().triangle(triangle);
            let place = if of_b {
                corner
            } else {
                self.b_in_a.transform_point(corner)
            };
            let outside = (bounds.min - place).max(place - bounds.max);
            punctual_geom::length(outside.max(DVec3::ZERO))
        };
        let farthest = (0..count)
            .step_by(count.div_ceil(SAMPLES).max(1))
            .map(distance);
        farthest.fold(0.0, f64::max) * (1.0 - 1e-9)
    }

    /// How often the closed components of A (of B) wind around a point of their frame.
    fn winding(&self, of_b: bool, point: DVec3) -> i32 {
        let tree = if of_b { self.b } else { self.a };
        let Some(solidity) = tree.solid() else {
            return 0;
        };
        let is_closed = |triangle| {
            let component = solidity.component_of(triangle) as usize;
            solidity.components()[component].is_closed()
        };
        crossings(tree, point, is_closed).winding
    }

    /// True if a point of the frame of A (of B) is inside.
    fn is_inside(&self, of_b: bool, point: DVec3) -> bool {
        let winding = self.winding(of_b, point);
        if self.solid {
            winding > 0
        } else {
            winding != 0
        }
    }
}

struct Machine<'s, 't, 'd, 'c> {
    asked: &'s PenetrationQuery<'t>,
    engine: &'s mut Workspace,
    point: Option<&'s Tree>,
    state: &'s mut State,
    deadline: &'d mut Deadline<'c>,
}

impl Machine<'_, '_, '_, '_> {
    /// Continues until the search is over or the deadline stops it.
    fn advance(&mut self) -> StopReason {
        // The first step may exceed the budget, so that every call gets on.
        let mut needed = 1;
        loop {
            if self.is_over() {
                self.state.job = Job::Over;
                return StopReason::Finished;
            }
            if let Some((asking, has_begun)) = self.state.asking {
                match self.put(asking, has_begun) {
                    Ok(Some(heard)) => {
                        self.state.asking = None;
                        self.hear(heard);
                    }
                    // The next part of the same question.
                    Ok(None) => {}
                    Err(stop) => return stop,
                }
            } else if self.deadline.has_room(needed) {
                let work = self.step().min(STEP);
                self.deadline.spend(work);
                self.state.stats.work += work;
                needed = STEP;
            } else {
                return self.deadline.why(needed);
            }
        }
    }

    fn is_over(&self) -> bool {
        let state = &*self.state;
        let limit = self.asked.limit;
        matches!(state.job, Job::Over)
            || state.high <= (1.0 + self.asked.tolerance) * state.low
            || limit < f64::INFINITY && state.penetration(limit).deeper.is_some()
    }

    /// Puts a question to the trees, or continues it. `None` if another part of it follows.
    fn put(&mut self, asking: Asking, has_begun: bool) -> Result<Option<Heard>, StopReason> {
        match asking {
            Asking::Contacts { at, most } => {
                let query = Query::all_pairs(self.asked.a, self.asked.b, self.pushed(at));
                let query = query.pair_limit(most);
                self.search(&query, has_begun)?;
                Ok(Some(Heard::Contacts(self.engine.pairs().len())))
            }
            Asking::Apart { at } => {
                let query = Query::intersection(self.asked.a, self.asked.b, self.pushed(at));
                let witness = self.search(&query, has_begun)?;
                if witness.is_some() {
                    return Ok(Some(Heard::Blocked(witness)));
                }
                if !self.asked.solid {
                    return Ok(Some(Heard::Apart));
                }
                self.state.asking = Some((Asking::Contained { at, next: 0 }, false));
                Ok(None)
            }
            Asking::Contained { at, next } => {
                if !self.deadline.has_room(1) {
                    return Err(self.deadline.why(1));
                }
                let (contained, next) = self.contained(at, next);
                self.deadline.spend(STEP);
                self.state.stats.work += STEP;
                match next {
                    _ if contained => Ok(Some(Heard::Blocked(None))),
                    None => Ok(Some(Heard::Apart)),
                    Some(next) => {
                        self.state.asking = Some((Asking::Contained { at, next }, false));
                        Ok(None)
                    }
                }
            }
            Asking::Near { of_b, point } => {
                let tree = if of_b { self.asked.b } else { self.asked.a };
                let (Some(one), Ok(pose)) = (self.point, Pose::new(DMat3::IDENTITY, point)) else {
                    return Ok(Some(Heard::Near(0.0, point)));
                };
                let query = Query::distance(tree, one, pose)
                    .absolute_tolerance(0.0)
                    .relative_tolerance(0.02);
                self.measure(&query, has_begun).map(Some)
            }
        }
    }

    /// Runs a query to its end, or until the deadline. Returns two triangles that meet.
    fn search(
        &mut self,
        query: &Query<'_, Intersection>,
        has_begun: bool,
    ) -> Result<Option<[u32; 2]>, StopReason> {
        let before = if has_begun {
            self.engine.stats()
        } else {
            query.begin_task(true, 0, self.engine, Some(&self.state.memory));
            Stats::default()
        };
        let stop = query.search(self.engine, Some(&mut self.state.memory), self.deadline);
        self.account(before);
        match stop {
            StopReason::Finished | StopReason::FirstHit | StopReason::PairsFull => {
                Ok(self.engine.verdict(stop).witness())
            }
            stop => Err(self.interrupted(stop)),
        }
    }

    fn measure(
        &mut self,
        query: &Query<'_, Distance>,
        has_begun: bool,
    ) -> Result<Heard, StopReason> {
        let before = if has_begun {
            self.engine.stats()
        } else {
            query.begin(self.engine, None, Budget::unlimited());
            Stats::default()
        };
        let answer = query.spend(self.engine, None, self.deadline);
        self.account(before);
        match answer.stop {
            StopReason::Finished => {
                let nearest = answer.value.nearest.map(|nearest| nearest.points[0]);
                Ok(Heard::Near(answer.value.low, nearest.unwrap_or_default()))
            }
            stop => Err(self.interrupted(stop)),
        }
    }

    /// The question continues in the next call.
    fn interrupted(&mut self, stop: StopReason) -> StopReason {
        if let Some((_, has_begun)) = &mut self.state.asking {
            *has_begun = true;
        }
        stop
    }

    fn account(&mut self, before: Stats) {
        let (now, stats) = (self.engine.stats(), &mut self.state.stats);
        stats.work += now.work - before.work;
        stats.bv_tests += now.bv_tests - before.bv_tests;
        stats.primitive_tests += now.primitive_tests - before.primitive_tests;
        stats.exact_tests += now.exact_tests - before.exact_tests;
    }

    /// Looks at some components at the pose after a push. Returns whether one of them is inside of
    /// the other body, and the next to look at.
    fn contained(&self, at: DVec3, next: usize) -> (bool, Option<usize>) {
        let [a, b] = [self.asked.a, self.asked.b].map(|tree| {
            let solidity = tree.solid();
            solidity.map_or(&[][..], |solidity| solidity.components())
        });
        let pose = self.pushed(at);
        let back = pose.inverse();
        let last = (next + (STEP / WORK_PER_RAY) as usize).min(a.len() + b.len());
        let is_in = |index: usize| {
            let (tree, of_b, component) = match index.checked_sub(a.len()) {
                None => (self.asked.a, false, &a[index]),
                Some(index) => (self.asked.b, true, &b[index]),
            };
            let [corner, ..] = tree.mesh().triangle(component.first_triangle as usize);
            let place = match (&back, of_b) {
                (_, true) => pose.transform_point(corner),
                (Ok(back), false) => back.transform_point(corner),
                (Err(_), false) => return false,
            };
            self.asked.is_inside(!of_b, place)
        };
        let found = (next..last).any(is_in);
        (found, (last < a.len() + b.len()).then_some(last))
    }

    /// The pose after a push; that before it if the push leads out of the range of poses.
    fn pushed(&self, at: DVec3) -> Pose {
        let pose = &self.asked.b_in_a;
        Pose::new(pose.rotation(), pose.translation() + at).unwrap_or(*pose)
    }

    fn ask(&mut self, asking: Asking) -> u64 {
        self.state.asking = Some((asking, false));
        64
    }

    /// The corners of two triangles in A's frame, before a push.
    fn corners(&self, [x, y]: [u32; 2]) -> [[DVec3; 3]; 2] {
        let PenetrationQuery { a, b, b_in_a, .. } = self.asked;
        let of_b = b.mesh().triangle(y as usize);
        [
            a.mesh().triangle(x as usize),
            of_b.map(|p| b_in_a.transform_point(p)),
        ]
    }

    /// Learns from two triangles that block a push.
    fn learn(&mut self, pair: [u32; 2], direction: DVec3) {
        let corners = self.corners(pair);
        self.state.add_pair(pair, corners);
        self.state.blocked.add(&corners[0], &corners[1]);
        for of_b in [false, true] {
            // Is it inside of the other?
            if self.state.inner[usize::from(!of_b)] > 0.0 {
                self.state
                    .add_point(of_b, &corners[usize::from(of_b)], direction);
            }
        }
    }
}

impl Machine<'_, '_, '_, '_> {
    /// Does one step, and returns its work: less than [`STEP`].
    fn step(&mut self) -> u64 {
        match self.state.job {
            Job::Over => 0,
            Job::Contacts => self.ask(Asking::Contacts {
                at: DVec3::ZERO,
                most: CONTACTS,
            }),
            Job::Read(next) => self.read(next),
            Job::Explore => self.explore(),
            Job::Lengthen {
                direction, length, ..
            } => self.ask(Asking::Apart {
                at: direction * length,
            }),
            Job::Shorten {
                direction,
                low,
                high,
            } => {
                if high - low <= WIDTH * high {
                    self.state.job = self.next_job();
                    return 64;
                }
                self.ask(Asking::Apart {
                    at: direction * (0.5 * (low + high)),
                })
            }
            Job::About(index) => self.about(index),
            Job::Start => self.start(),
            Job::Seek(index) => self.seek(index),
            Job::Climb(climb) => self.climb(climb),
            Job::Pick => self.pick(),
            Job::Advance(task) => self.work_on(task),
        }
    }

    /// Takes the answer to the question of the job.
    fn hear(&mut self, heard: Heard) {
        match (self.state.job, heard) {
            (Job::Contacts, Heard::Contacts(0)) => {
                // The surfaces are apart; solids may still be in one another.
                self.state.asking = self.asked.solid.then_some((
                    Asking::Contained {
                        at: DVec3::ZERO,
                        next: 0,
                    },
                    false,
                ));
                if !self.asked.solid {
                    self.are_apart();
                }
            }
            (Job::Contacts, Heard::Contacts(_)) => {
                let [first, ..] = *self.engine.pairs() else {
                    return;
                };
                let origin = self.corners(first)[0][0];
                let size = self.size();
                self.state.segments = Some(Segments::new(origin, size));
                self.state.job = Job::Read(0);
            }
            (Job::Contacts, Heard::Apart) => self.are_apart(),
            (Job::Contacts, Heard::Blocked(_)) => {
                self.state.likely.extend(AXES);
                self.add_sample_points();
                self.state.job = Job::Explore;
            }
            (
                Job::Lengthen {
                    direction,
                    length,
                    longest,
                },
                heard,
            ) => self.lengthened(direction, length, longest, heard),
            (
                Job::Shorten {
                    direction,
                    low,
                    high,
                },
                heard,
            ) => {
                let middle = 0.5 * (low + high);
                let [low, high] = if let Heard::Blocked(pair) = heard {
                    pair.inspect(|&pair| self.learn(pair, direction));
                    [
                        self.state.blocked.free_from(direction, middle, high).0,
                        high,
                    ]
                } else {
                    self.state.separates(direction, middle);
                    [low, middle]
                };
                self.state.job = Job::Shorten {
                    direction,
                    low,
                    high,
                };
            }
            (Job::About(index), Heard::Near(distance, nearest)) => {
                if let Some(ball) = self.add_ball(index, DVec3::ZERO, distance, nearest) {
                    self.raise_low(ball.radius.min(ball.longest));
                }
                self.state.job = Job::About(index + 1);
            }
            (Job::Climb(climb), Heard::Near(distance, _)) => self.climbed(climb, distance),
            (Job::Advance(task), heard) => self.worked_on(task, heard),
            _ => {}
        }
    }

    fn are_apart(&mut self) {
        (self.state.low, self.state.high, self.state.is_apart) = (0.0, 0.0, true);
        self.state.job = Job::Over;
    }

    /// The longest extent of both meshes.
    fn size(&self) -> f64 {
        let [a, b] = [self.asked.a, self.asked.b].map(|tree| tree.mesh().aabb().extents());
        a.max(b).max_element().max(f64::MIN_POSITIVE)
    }

    /// Reads some of the contacts at the pose.
    fn read(&mut self, next: usize) -> u64 {
        const EACH: usize = 4;
        let count = self.engine.pairs().len();
        let last = (next + EACH).min(count);
        for i in next..last {
            let pair = self.engine.pairs()[i];
            let corners = self.corners(pair);
            if let Some(segments) = &mut self.state.segments {
                segments.add(&corners[0], &corners[1]);
            }
            let number = self.state.add_pair(pair, corners);
            let margin = self.state.pairs[number].margin();
            if margin > self.state.widest.0 {
                self.state.widest = (margin, number);
            }
            if i % (count / 8).max(1) == 0 {
                self.state.blocked.add(&corners[0], &corners[1]);
            }
        }
        self.state.job = Job::Read(last);
        if last == count {
            let likely = self.state.segments.as_ref().map(Segments::directions);
            self.state.likely.extend(likely.into_iter().flatten());
            self.state.job = Job::Explore;
        }
        (last - next) as u64 * (WORK_PER_NEW_PAIR + 600)
    }

    /// Of all triangles known, the corners that are deepest in the other body for the best push.
    fn add_deepest_corners(&mut self) {
        let direction = self.state.direction;
        for of_b in [false, true] {
            if self.state.inner[usize::from(!of_b)] == 0.0 {
                continue;
            }
            let toward = if of_b { -direction } else { direction };
            let depth = |pair: &Pair| {
                let [p, q, r] = pair.corners[usize::from(of_b)].map(|corner| corner.dot(toward));
                p.max(q).max(r)
            };
            let pairs = self.state.pairs.iter();
            let deepest = pairs.max_by(|x, y| depth(x).total_cmp(&depth(y)));
            if let Some(corners) = deepest.map(|pair| pair.corners[usize::from(of_b)]) {
                self.state.add_point(of_b, &corners, direction);
            }
        }
    }

    /// The corners of the first components, in case the bodies do not touch.
    fn add_sample_points(&mut self) {
        for of_b in [false, true] {
            let tree = if of_b { self.asked.b } else { self.asked.a };
            let components = tree
                .solid()
                .map_or(&[][..], |solidity| solidity.components());
            for component in components.iter().take(4) {
                let corners = tree.mesh().triangle(component.first_triangle as usize);
                let corners = if of_b {
                    corners.map(|p| self.asked.b_in_a.transform_point(p))
                } else {
                    corners
                };
                self.state.add_point(of_b, &corners, DVec3::X);
            }
        }
    }

    /// What follows a direction.
    fn next_job(&self) -> Job {
        if self.state.number > 0 {
            Job::Pick
        } else {
            Job::Explore
        }
    }

    /// Begins with the next of the likely directions.
    fn explore(&mut self) -> u64 {
        let Some(&direction) = self.state.likely.get(self.state.explored) else {
            self.add_deepest_corners();
            self.state.job = Job::About(0);
            return PAIRS as u64 * 4;
        };
        self.state.explored += 1;
        let longest = 1.001 * self.parting_length(direction) + 64.0 * self.state.rounding;
        let known = self.state.high < f64::INFINITY;
        let (low, work) = self.state.blocked.free_from(direction, 0.0, f64::INFINITY);
        let length = if known {
            self.state.high * SHORTER
        } else {
            let guess = self
                .state
                .segments
                .as_ref()
                .map_or(0.0, |s| s.extent(direction));
            (1.1 * low).max(guess.min(3.0 * low)).max(1e-3 * longest)
        };
        self.state.job = if known && low >= length {
            Job::Explore
        } else {
            Job::Lengthen {
                direction,
                length: length.min(longest),
                longest,
            }
        };
        work + 64
    }

    fn lengthened(&mut self, direction: DVec3, length: f64, longest: f64, heard: Heard) {
        let Heard::Blocked(pair) = heard else {
            self.state.separates(direction, length);
            let low = self.state.blocked.free_from(direction, 0.0, length).0;
            self.state.job = Job::Shorten {
                direction,
                low,
                high: length,
            };
            return;
        };
        pair.inspect(|&pair| self.learn(pair, direction));
        let low = self
            .state
            .blocked
            .free_from(direction, length, f64::INFINITY)
            .0;
        self.state.job = if self.state.high < f64::INFINITY || length >= longest {
            Job::Explore
        } else {
            Job::Lengthen {
                direction,
                length: (GROWTH * length).max(1.05 * low).min(longest),
                longest,
            }
        };
    }

    /// Length of a push after which the boxes are apart, up to rounding.
    fn parting_length(&self, direction: DVec3) -> f64 {
        let a = self.asked.a.mesh().aabb();
        let b = self.asked.b.aabb_at(&self.asked.b_in_a);
        let forward = direction.cmpgt(DVec3::ZERO);
        let farthest = DVec3::select(forward, a.max - b.min, a.min - b.max);
        farthest.dot(direction).max(0.0)
    }
}

impl Machine<'_, '_, '_, '_> {
    /// All translations shorter than `radius` are blocked.
    fn raise_low(&mut self, radius: f64) {
        let state = &mut *self.state;
        state.low = state.low.max(radius.min(state.high));
    }

    /// Where a point is in the frame of the other body while B is moved.
    fn place(&self, point: &Point, at: DVec3) -> DVec3 {
        if point.of_b {
            point.place + at
        } else {
            self.state.back.transform_point(point.place - at)
        }
    }

    /// Asks how deep a point is while B is moved; `None` if it is known to be less than `needed`.
    fn ask_point(&mut self, index: usize, at: DVec3, needed: f64) -> Option<u64> {
        let point = self.state.points.get(index)?;
        let place = self.place(point, at);
        let is_near = |near: &DVec3| punctual_geom::length(*near - place) < needed;
        if point.near.iter().any(is_near) {
            return None;
        }
        let of_b = !point.of_b;
        Some(self.ask(Asking::Near { of_b, point: place }))
    }

    /// Keeps the ball of a point that is inside of the other body, at `distance` from its surface,
    /// while B is moved by `at`.
    fn add_ball(&mut self, index: usize, at: DVec3, distance: f64, nearest: DVec3) -> Option<Ball> {
        let point = self.state.points.get(index)?;
        let (of_b, place) = (point.of_b, self.place(point, at));
        let point_in_a = point.place;
        let mut radius = distance;
        if !of_b {
            let miss = self.asked.b_in_a.transform_point(place) - (point_in_a - at);
            radius = distance * self.state.least_scale - 2.0 * punctual_geom::length(miss);
        }
        let radius = radius - 16.0 * self.state.rounding;
        let is_known = |&(center, radius): &(DVec3, f64)| {
            punctual_geom::length(center - at) < radius * (1.0 - 1e-9)
        };
        let is_inside = point.inside.iter().any(is_known) || self.asked.is_inside(!of_b, place);
        let longest = self.state.inner[usize::from(!of_b)];
        let point = &mut self.state.points[index];
        if point.near.is_full() {
            point.near.remove(0);
        }
        point.near.push(nearest);
        if !(is_inside && radius > 0.0) {
            return None;
        }
        if point.inside.is_full() {
            point.inside.remove(0);
        }
        point.inside.push((at, radius));
        let ball = Ball {
            center: at,
            radius,
            longest,
        };
        self.state.keep_ball(ball);
        Some(ball)
    }

    fn about(&mut self, index: usize) -> u64 {
        if index >= self.state.points.len() {
            self.state.job = Job::Start;
            return 64;
        }
        let needed = self.state.low;
        self.ask_point(index, DVec3::ZERO, needed)
            .unwrap_or_else(|| {
                self.state.job = Job::About(index + 1);
                100
            })
    }

    /// Makes the first cones, with the radius known by now.
    fn start(&mut self) -> u64 {
        let rounding = self.state.rounding;
        let (margin, number) = self.state.widest;
        let half = 0.9 * margin;
        if let Some(pair) = self.state.pairs.get(number)
            && half > 64.0 * rounding
            && pair.fills_cube(half)
        {
            self.raise_low(half - 8.0 * rounding);
        }
        let radius = self.state.low;
        if self.may_seek() && radius < DEEP * self.state.high {
            self.state.job = Job::Seek(0);
        } else if radius > 64.0 * rounding {
            for cone in Cone::all_around() {
                self.state.add_cone(Cone { radius, ..cone });
            }
            self.state.job = Job::Pick;
        } else if self.state.has_all_directions {
            self.state.job = Job::Over;
        } else {
            // Nothing more is known of `low`, so what is left is a shorter push.
            self.state.has_all_directions = true;
            self.state.likely.extend(all_around());
            self.state.job = Job::Explore;
        }
        2 * WORK_PER_PROOF
    }

    /// True if both have an inside, and no point deep in both was sought yet.
    fn may_seek(&self) -> bool {
        self.asked.solid && self.state.inner == [f64::INFINITY; 2] && !self.state.has_sought
    }

    /// Begins a climb at a place that is inside of both, if it is.
    fn seek(&mut self, index: usize) -> u64 {
        self.state.has_sought = true;
        let half = self.state.direction * (0.5 * self.state.high.min(self.size()));
        let place = match index.checked_sub(1) {
            None => self.state.segments.as_ref().map(Segments::middle),
            Some(index) => {
                let point = self.state.points.iter().rev().nth(index);
                point.map(|p| {
                    if p.of_b {
                        p.place + half
                    } else {
                        p.place - half
                    }
                })
            }
        };
        let is_enough = self.state.summits.len() >= 2 || index >= 8;
        let Some(place) = place.filter(|_| !is_enough) else {
            self.state.job = match index {
                0 => Job::Seek(1),
                _ if self.state.number > 0 => Job::Pick,
                _ => Job::Start,
            };
            return 64;
        };
        self.state.job = if self.is_in_both(place, DVec3::ZERO) {
            let step = 0.5 * punctual_geom::length(half);
            Job::Climb(Climb::new(index, DVec3::ZERO, place, step, CLIMB, None))
        } else {
            Job::Seek(index + 1)
        };
        2 * WORK_PER_RAY
    }

    /// True if a point of A's frame is inside of both while B is moved.
    fn is_in_both(&self, place: DVec3, at: DVec3) -> bool {
        self.asked.is_inside(false, place)
            && self
                .asked
                .is_inside(true, self.state.back.transform_point(place - at))
    }

    fn climb(&mut self, mut climb: Climb) -> u64 {
        if climb.left == 0 || climb.step < climb.least {
            self.end_climb(climb);
            return 256;
        }
        if climb.of_a.is_none() {
            if !self.is_in_both(climb.trial, climb.at) {
                climb.turn_away();
                self.state.job = Job::Climb(climb);
                return 2 * WORK_PER_RAY;
            }
            return 2 * WORK_PER_RAY
                + self.ask(Asking::Near {
                    of_b: false,
                    point: climb.trial,
                });
        }
        let point = self.state.back.transform_point(climb.trial - climb.at);
        self.ask(Asking::Near { of_b: true, point })
    }

    fn climbed(&mut self, mut climb: Climb, distance: f64) {
        if let Some(of_a) = climb.of_a.take() {
            let place = climb.trial - climb.at;
            let back = self.state.back.transform_point(place);
            let miss = self.asked.b_in_a.transform_point(back) - place;
            let sum = of_a + distance * self.state.least_scale
                - 2.0 * punctual_geom::length(miss)
                - 32.0 * self.state.rounding;
            if sum > climb.sum {
                climb.rise(sum);
            } else {
                climb.turn_away();
            }
        } else {
            climb.of_a = Some(distance);
        }
        self.state.job = Job::Climb(climb);
    }

    fn end_climb(&mut self, climb: Climb) {
        let ball = Ball {
            center: climb.at,
            radius: climb.sum,
            longest: f64::INFINITY,
        };
        let is_ball = ball.radius > 0.0;
        if is_ball {
            self.state.keep_ball(ball);
            self.state.keep_summit((climb.at, climb.best));
        }
        let Some(mut task) = climb.task() else {
            if is_ball && self.state.number == 0 {
                self.raise_low(ball.radius);
            }
            self.state.job = Job::Seek(climb.number + 1);
            return;
        };
        if is_ball && let Some(advance) = task.rays.by_ball(&ball) {
            task.proven = task.proven.max(advance.radius);
        }
        task.stage = Stage::Contacts;
        self.settle(task);
    }
}

impl Climb {
    fn new(
        number: usize,
        at: DVec3,
        start: DVec3,
        step: f64,
        left: u32,
        cone: Option<Task>,
    ) -> Self {
        Self {
            number,
            at,
            best: start,
            sum: 0.0,
            step,
            least: 0.01 * step,
            left,
            side: 0,
            turns: 0,
            trial: start,
            of_a: None,
            cone,
        }
    }

    fn task(&self) -> Option<Task> {
        self.cone
    }

    /// The trial is better.
    fn rise(&mut self, sum: f64) {
        (self.best, self.sum) = (self.trial, sum);
        self.step *= 1.3;
        self.next(true);
    }

    /// The trial is no better.
    fn turn_away(&mut self) {
        self.side += 1;
        let is_round = self.side == 6;
        if is_round {
            self.step *= 0.5;
        }
        self.next(is_round);
    }

    /// Chooses the next of six directions, of a turned compass if the last is done with.
    fn next(&mut self, is_new: bool) {
        self.left = self.left.saturating_sub(1);
        if is_new {
            self.side = 0;
            self.turns += 1;
        }
        let mut random = Random::new(self.turns);
        let mut axis = || random.between(-1.0, 1.0);
        let first = unit(DVec3::new(axis(), axis(), axis()) + DVec3::splat(1e-9));
        let (second, third) = first.any_orthonormal_pair();
        let along = [first, second, third][self.side / 2 % 3];
        let sign = if self.side % 2 == 0 { 1.0 } else { -1.0 };
        self.trial = self.best + along * (sign * self.step);
    }
}

impl Machine<'_, '_, '_, '_> {
    /// Takes the cone with the least radius.
    fn pick(&mut self) -> u64 {
        if self.state.advances == ADVANCES_BEFORE_CLIMBS && self.may_seek() {
            self.state.job = Job::Seek(0);
            return 64;
        }
        let state = &mut *self.state;
        state.job = Job::Over;
        if let Some(cone) = state.cones.pop() {
            state.advances += 1;
            let radius = cone.radius;
            let rays = cone.rays(state.rounding);
            self.raise_low(radius);
            if let Some(rays) = rays
                && self.state.advances < ADVANCES
            {
                self.state.job = Job::Advance(Task {
                    cone,
                    rays,
                    proven: radius,
                    best: None,
                    stage: Stage::Balls,
                });
            }
        }
        200
    }

    /// Ends the turn of a cone if it gained enough; otherwise its next stage follows.
    fn settle(&mut self, task: Task) {
        if self.state.is_gain(&task.cone, task.proven) {
            self.put_back(task);
            self.state.job = Job::Pick;
        } else {
            self.state.job = Job::Advance(task);
        }
    }

    fn put_back(&mut self, task: Task) {
        self.state.add_cone(Cone {
            radius: task.proven,
            ..task.cone
        });
    }

    /// The middle of a cone, and how far a push along it is tried.
    fn goal(&self, task: &Task) -> (DVec3, f64) {
        let (radius, high) = (task.proven, self.state.high);
        let goal = if high < f64::INFINITY {
            (SHORTER * high).max(0.5 * (radius + high))
        } else {
            2.0 * radius
        };
        (task.cone.middle(), goal)
    }

    fn work_on(&mut self, mut task: Task) -> u64 {
        match task.stage {
            Stage::Balls => {
                for ball in self.state.balls.iter().rev() {
                    if let Some(advance) = task.rays.by_ball(ball) {
                        task.proven = task.proven.max(advance.radius);
                    }
                }
                task.stage = Stage::Pairs {
                    next: 0,
                    last: false,
                };
                self.settle(task);
                self.state.balls.len() as u64 * WORK_PER_BALL + 64
            }
            Stage::Pairs { next, last } => self.try_pairs(task, next, last),
            Stage::Block => {
                let (middle, goal) = self.goal(&task);
                self.ask(Asking::Apart { at: middle * goal })
            }
            Stage::Points { next, near } => self.try_point(task, next, near),
            Stage::Contacts => self.ask(Asking::Contacts {
                at: self.just_outside(&task),
                most: CONTACTS_AHEAD,
            }),
            Stage::Free => self.ask(Asking::Apart {
                at: self.just_outside(&task),
            }),
            Stage::Read(next) => {
                let count = self.engine.pairs().len();
                let last = (next + 8).min(count);
                for i in next..last {
                    let pair = self.engine.pairs()[i];
                    let corners = self.corners(pair);
                    self.state.add_pair(pair, corners);
                }
                task.stage = if last < count {
                    Stage::Read(last)
                } else {
                    Stage::Pairs {
                        next: 0,
                        last: true,
                    }
                };
                self.state.job = Job::Advance(task);
                (last - next) as u64 * WORK_PER_NEW_PAIR + 64
            }
            Stage::Split => {
                task.cone.radius = task.proven;
                let has_room = self.state.cones.len() + 4 <= CONES;
                self.state.job = match task.cone.split().filter(|_| has_room) {
                    Some(parts) => {
                        parts.into_iter().for_each(|cone| self.state.add_cone(cone));
                        Job::Pick
                    }
                    None => Job::Over,
                };
                600
            }
        }
    }

    /// A push along the middle of a cone, a little longer than its radius.
    fn just_outside(&self, task: &Task) -> DVec3 {
        let length = task.proven * (1.0 + 1e-3) + 16.0 * self.state.rounding;
        task.cone.middle() * length.min(self.state.high)
    }

    /// Tries some of the known pairs, the one that helped last first.
    fn try_pairs(&mut self, mut task: Task, mut next: usize, last: bool) -> u64 {
        let (state, [least, most]) = (&*self.state, task.rays.bounds());
        let mut work = 64;
        let first = usize::from(task.cone.hint);
        let order = |i: usize| if i == 0 { first } else { i - 1 };
        while next <= state.pairs.len() && work < STEP - WORK_PER_PAIR - WORK_PER_PROOF {
            let number = order(next);
            next += 1;
            work += WORK_PER_BOX;
            let Some([from, to]) = state.bounds.get(number) else {
                continue;
            };
            if !(from.cmple(least) & to.cmpge(most)).all() {
                continue;
            }
            work += WORK_PER_PAIR;
            if let Some(advance) = task.rays.by_pair(&state.pairs[number]) {
                let best = task.best.map_or(task.proven, |(best, _)| best.radius);
                if advance.radius > best {
                    task.best = Some((advance, number as u16));
                    if advance.radius >= state.high {
                        next = state.pairs.len() + 1;
                    }
                }
            }
        }
        if next <= state.pairs.len() {
            task.stage = Stage::Pairs { next, last };
            self.state.job = Job::Advance(task);
            return work;
        }
        if let Some((advance, number)) = task.best.take()
            && task
                .rays
                .proves(&state.pairs[usize::from(number)], &advance)
        {
            (task.proven, task.cone.hint) = (advance.radius, number);
        }
        task.stage = if last { Stage::Split } else { Stage::Block };
        self.settle(task);
        work + WORK_PER_PROOF
    }

    /// Asks how deep one of the latest points is, half way to the best push or at the radius.
    fn try_point(&mut self, mut task: Task, next: usize, near: bool) -> u64 {
        let Some(index) = self.candidate(next) else {
            let at = self.far(&task, false);
            let distance = |other: DVec3| (other - at).length_squared();
            let summits = self.state.summits.iter();
            let nearest = summits.min_by(|(x, _), (y, _)| distance(*x).total_cmp(&distance(*y)));
            self.state.job = match nearest {
                Some(&(other, summit)) if task.cone.level < CLIMBING_LEVELS => {
                    let step = 0.25 * punctual_geom::length(at - other);
                    let start = summit + (at - other) * 0.5;
                    Job::Climb(Climb::new(0, at, start, step, SHORT_CLIMB, Some(task)))
                }
                _ => {
                    task.stage = Stage::Contacts;
                    Job::Advance(task)
                }
            };
            return 200;
        };
        let at = self.far(&task, near);
        let needed = task.rays.farthest(at);
        self.ask_point(index, at, needed).unwrap_or_else(|| {
            task.stage = after_point(next, near);
            self.state.job = Job::Advance(task);
            150
        })
    }

    /// The point that is tried for a cone after `next` others: the latest two, then the latest
    /// that were inside.
    fn candidate(&self, next: usize) -> Option<usize> {
        let latest = self.state.points.len().checked_sub(2).unwrap_or_default();
        let points = self.state.points.iter().enumerate().rev();
        let mut tried = points.filter(|(i, point)| *i >= latest || !point.inside.is_empty());
        let (index, _) = tried.nth(next)?;
        (next < POINTS_A_CONE).then_some(index)
    }

    /// A push along the middle of a cone, at its radius or half way to the best.
    fn far(&self, task: &Task, near: bool) -> DVec3 {
        let radius = task.cone.radius;
        let length = if near {
            radius
        } else {
            (0.5 * (radius + self.state.high)).min(2.0 * radius.max(self.state.low))
        };
        task.cone.middle() * length
    }

    fn worked_on(&mut self, mut task: Task, heard: Heard) {
        match (task.stage, heard) {
            (Stage::Block, Heard::Blocked(pair)) => {
                let (middle, _) = self.goal(&task);
                pair.inspect(|&pair| self.learn(pair, middle));
                task.stage = Stage::Points {
                    next: 0,
                    near: false,
                };
                self.state.job = Job::Advance(task);
            }
            (Stage::Block, Heard::Apart) => {
                let (direction, high) = self.goal(&task);
                self.state.separates(direction, high);
                let low = task.proven;
                self.put_back(task);
                self.state.job = Job::Shorten {
                    direction,
                    low,
                    high,
                };
            }
            (Stage::Points { next, near }, Heard::Near(distance, nearest)) => {
                let at = self.far(&task, near);
                let index = self.candidate(next);
                let ball = index.and_then(|i| self.add_ball(i, at, distance, nearest));
                if let Some(advance) = ball.and_then(|ball| task.rays.by_ball(&ball)) {
                    task.proven = task.proven.max(advance.radius);
                }
                task.stage = after_point(next, near || ball.is_some());
                self.settle(task);
            }
            (Stage::Contacts, Heard::Contacts(count)) => {
                task.stage = if count == 0 {
                    Stage::Free
                } else {
                    Stage::Read(0)
                };
                self.state.job = Job::Advance(task);
            }
            (Stage::Free, heard) => {
                if let Heard::Apart = heard {
                    let at = self.just_outside(&task);
                    let length = task.proven * (1.0 + 1e-3) + 16.0 * self.state.rounding;
                    if length < self.state.high && at == task.cone.middle() * length {
                        self.state.separates(task.cone.middle(), length);
                    }
                }
                task.stage = Stage::Split;
                self.state.job = Job::Advance(task);
            }
            _ => {}
        }
    }
}

/// The stage after a point was tried far out or near.
fn after_point(next: usize, near: bool) -> Stage {
    if near {
        Stage::Points {
            next: next + 1,
            near: false,
        }
    } else {
        Stage::Points { next, near: true }
    }
}
