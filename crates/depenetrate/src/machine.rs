//! The machine: what a penetration query keeps from step to step, and its loop.
//!
//! A step does the task of the state. A task either pays for its work and does it, or puts one
//! question to the trees. If the budget ends a question, the task begins anew in the next call and
//! the question continues, since its workspace knows it. So a task changes nothing before the
//! answer.

use super::balls::Seed;
use super::convex::Support;
use super::cover::{Advance, Cone};
use super::directions::Segments;
use super::pushes::{Faces, Push};
use super::sets::{Pair, Sets, Triangle};
use super::{Key, MAX_PENETRATION_STEP_WORK, Penetration, PenetrationQuery};
use arrayvec::ArrayVec;
use glam::{DMat3, DVec3};
use punctual::clock::ClockedBudget;
use punctual::engine::{Ask, Deadline, Question};
use punctual::intersection::Intersection;
use punctual::{Answer, PairMemory, Query, Stats, StopReason, Tree, Verdict, Workspace};
use punctual_geom::Pose;
use punctual_geom::triangle::distance::closest;

/// Work of the longest task outside of queries.
pub(super) const STEP: u64 = MAX_PENETRATION_STEP_WORK;

/// Maximum number of contacts that are read.
pub(super) const CONTACTS: usize = 128;

/// Rounding of a coordinate of B after a push, relative to the coordinates: proof in
/// `docs/numerics.md`.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Bounds that differ by this many roundings are not brought closer together.
pub(super) const RESOLUTION: f64 = 64.0;

/// The error is the reason why a call ends.
pub(super) type Step<T = ()> = Result<T, StopReason>;

/// The next step of the search.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task {
    /// Searches the depth of a pair of convex components.
    Convex(Support),
    /// Lists the contacts at the pose, or just outside of the current cone.
    List,
    /// Reads the contacts from this index on.
    Read(usize),
    /// Takes the next of the likely directions.
    Explore,
    /// Searches the length of a push.
    Push(Push),
    /// Tilts the direction of a new best push, or ends its search.
    Polish(Push),
    /// Grows the balls of the seeds.
    Grow,
    /// Makes the first cones.
    Start,
    /// Makes the cone with the least radius the current one.
    Pick,
    /// Tries the sets from this index on. The option is the best advance so far, and its set.
    Try(usize, Option<(Advance, usize)>),
    /// Splits the current cone.
    Split,
    /// Asks how far the cores are apart, of thickened bodies.
    Measure,
    Over,
}

/// The cone that is advanced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Current {
    pub index: usize,
    pub cone: Cone,
    /// The radius that is proven so far.
    pub proven: f64,
    /// True if new sets were asked for. If they do not help, the cone is split.
    pub has_asked: bool,
}

#[derive(Debug)]
pub(super) struct State {
    pub key: Key,
    pub task: Task,
    memory: PairMemory,
    pub segments: Option<Segments>,
    /// Of the contacts at the pose, the pair of triangles with the largest margin.
    pub widest: Option<(f64, Pair)>,
    /// Of pairs of convex components the deepest: the direction and the length of a push that
    /// separates the two.
    pub deepest: Option<(DVec3, f64)>,
    /// Directions to explore, the last one first.
    pub likely: ArrayVec<DVec3, 40>,
    /// Length of the best push before its direction was last tilted, infinite before the first
    /// time; `None` before all directions are tried.
    pub turned: Option<f64>,
    pub faces: Faces,
    pub seeds: ArrayVec<Seed, 16>,
    pub current: Option<Current>,
    pub advances: u32,
    /// Number of times that new sets were asked for, that they helped, and that asking was skipped
    /// since.
    pub trials: [u32; 3],
    /// Lower bound of the depth: no shorter translation separates.
    pub low: f64,
    pub high: f64,
    pub direction: DVec3,
    /// Largest rounding of a coordinate of B after a push.
    pub rounding: f64,
    /// A length of 1 in B's frame is at least this long in A's.
    pub least_scale: f64,
    pub back: Pose,
    /// A point of B inside A proves that a push no longer than the first of these does not
    /// separate. A point of A inside B proves it up to the second.
    pub longest: [f64; 2],
    /// Sum of the radii of the trees, while the search is about the cores; then 0.
    pub radii: f64,
    /// True once it is about thickened bodies.
    pub is_thick: bool,
    stats: Stats,
}

pub(super) struct Machine<'s, 't, 'c> {
    pub asked: &'s PenetrationQuery<'t>,
    pub engine: &'s mut Workspace,
    pub sets: &'s mut Sets,
    pub state: &'s mut State,
    pub deadline: Deadline<'c>,
}

impl State {
    pub fn new(query: &PenetrationQuery<'_>) -> Self {
        let pose = &query.asked.b_in_a;
        // The box of an empty mesh has infinite corners.
        let largest = |tree: &Tree| match tree.mesh() {
            mesh if mesh.is_empty() => 0.0,
            mesh => mesh
                .aabb()
                .min
                .abs()
                .max(mesh.aabb().max.abs())
                .max_element(),
        };
        let magnitude =
            largest(query.a) + 4.0 * largest(query.b) + pose.translation().abs().max_element();
        let rounding = ROUNDING * magnitude + f64::MIN_POSITIVE;
        let rotation = pose.rotation();
        let defect = rotation.transpose() * *rotation - DMat3::IDENTITY;
        let defect = defect
            .to_cols_array()
            .map(f64::abs)
            .into_iter()
            .fold(0.0, f64::max);
        let least_scale = libm::sqrt((1.0 - 3.0 * defect).max(0.0)) * (1.0 - 1e-12);
        let longest = |of_b| (query.longest(of_b) - 16.0 * rounding).max(0.0);
        Self {
            key: query.key(),
            task: Task::List,
            memory: PairMemory::without_clearance(),
            segments: None,
            widest: None,
            deepest: None,
            likely: ArrayVec::new(),
            turned: None,
            faces: Faces::new(),
            seeds: ArrayVec::new(),
            current: None,
            advances: 0,
            trials: [0; 3],
            low: 0.0,
            high: f64::INFINITY,
            direction: DVec3::ZERO,
            rounding,
            least_scale,
            back: pose.inverse().unwrap_or(Pose::IDENTITY),
            longest: [false, true].map(longest),
            radii: query.radii(),
            is_thick: false,
            stats: Stats::default(),
        }
    }

    pub fn is_over(&self) -> bool {
        let (_, asked) = self.key;
        let resolved = RESOLUTION * self.rounding;
        let width = match asked.limit {
            f64::INFINITY => (asked.tolerance * self.low).max(asked.absolute_tolerance),
            // With a limit, the tolerances do not end the search.
            _ => 0.0,
        };
        matches!(self.task, Task::Over)
            || self.high <= self.low + width.max(resolved)
            || self.deeper().is_some()
    }

    fn deeper(&self) -> Option<bool> {
        let (limit, [low, high]) = (self.key.1.limit, self.bounds());
        match limit {
            f64::INFINITY => None,
            _ if low > limit => Some(true),
            _ if high <= limit => Some(false),
            _ => None,
        }
    }

    /// The bounds of the depth. If the cores penetrate each other, both radii add to their depth:
    /// around each translation at which the cores meet, the bodies meet in a ball of both radii.
    fn bounds(&self) -> [f64; 2] {
        match self.radii {
            0.0 => [self.low, self.high],
            radii if self.low > 0.0 => [self.deep(radii), f64::INFINITY],
            _ => [0.0, f64::INFINITY],
        }
    }

    fn deep(&self, radii: f64) -> f64 {
        (self.low + radii) * (1.0 - 4.0 * f64::EPSILON) - self.rounding
    }

    /// Turns from the cores to the thickened bodies, whose depth is not less than that of the cores
    /// and their radii.
    fn thicken(&mut self) {
        let radii = core::mem::take(&mut self.radii);
        let has_push = 0.0 < self.high && self.high < f64::INFINITY;
        self.deepest = has_push.then_some((self.direction, self.high + radii));
        self.low = if self.low > 0.0 {
            self.deep(radii)
        } else {
            0.0
        };
        (self.high, self.direction) = (f64::INFINITY, DVec3::ZERO);
        (self.is_thick, self.turned, self.current) = (true, None, None);
        self.likely.clear();
        self.seeds.clear();
        self.task = Task::Measure;
    }

    /// No translation shorter than this separates.
    pub fn raise_low(&mut self, radius: f64) {
        self.low = self.low.max(radius.min(self.high));
    }

    /// A push of this length is proven to separate.
    pub fn separates(&mut self, direction: DVec3, length: f64) {
        if length < self.high {
            (self.high, self.direction) = (length, direction);
        }
    }
}

impl<'s, 't, 'c> Machine<'s, 't, 'c> {
    pub fn new(
        asked: &'s PenetrationQuery<'t>,
        (engine, sets, state): (&'s mut Workspace, &'s mut Sets, &'s mut State),
        budget: ClockedBudget<'c>,
    ) -> Self {
        Self {
            asked,
            engine,
            sets,
            state,
            deadline: Deadline::of(budget),
        }
    }

    /// Continues until the search is over or the deadline stops it.
    pub fn run(mut self) -> Answer<Penetration> {
        let stop = loop {
            if self.state.is_over() {
                if self.state.radii == 0.0 || self.state.deeper().is_some() {
                    self.state.task = Task::Over;
                    break StopReason::Finished;
                }
                self.state.thicken();
                continue;
            }
            if let Err(stop) = self.step() {
                break stop;
            }
        };
        let state = self.state;
        if let Some(elapsed) = self.deadline.elapsed() {
            let total = &mut state.stats.elapsed;
            *total = Some(total.unwrap_or_default().saturating_add(elapsed));
        }
        let [low, high] = state.bounds();
        let direction = Some(state.direction).filter(|_| state.radii == 0.0);
        let direction = direction.filter(|direction| *direction != DVec3::ZERO);
        let push = direction.map_or(DVec3::ZERO, |direction| direction * high);
        let value = Penetration {
            low,
            high,
            direction,
            b_in_a: self.asked.pushed(push),
            deeper: state.deeper(),
        };
        Answer::of(value, stop, state.stats)
    }

    fn step(&mut self) -> Step {
        match self.state.task {
            Task::Convex(support) => self.convex(support),
            Task::List => self.list(),
            Task::Read(next) => self.read(next),
            Task::Explore => self.explore(),
            Task::Push(push) => self.push(push),
            Task::Polish(push) => self.polish(push),
            Task::Grow => self.grow(),
            Task::Start => self.start(),
            Task::Pick => self.pick(),
            Task::Try(next, best) => self.try_sets(next, best),
            Task::Split => self.split(),
            Task::Measure => self.measure(),
            Task::Over => Ok(()),
        }
    }

    /// Does a task of this work outside of queries, if there is room for it.
    pub fn pay(&mut self, work: u64) -> Step {
        self.deadline.check(work)?;
        self.spend(work);
        Ok(())
    }

    /// Adds work that was done outside of queries.
    pub fn spend(&mut self, work: u64) {
        self.deadline.spend(work);
        self.state.stats.work += work;
    }

    /// Puts a question to the trees, or continues it.
    pub fn ask<Q: Question>(&mut self, query: &Query<'_, Q>) -> Step<Q::Value>
    where
        for<'q> Query<'q, Q>: Ask<Q>,
    {
        let memory = Some(&mut self.state.memory);
        let (answer, before) = query.go_on(self.engine, memory, &mut self.deadline);
        let (now, stats) = (answer.stats, &mut self.state.stats);
        stats.work += now.work - before.work;
        stats.bv_tests += now.bv_tests - before.bv_tests;
        stats.primitive_tests += now.primitive_tests - before.primitive_tests;
        stats.exact_tests += now.exact_tests - before.exact_tests;
        match answer.stop {
            stop if stop.is_final() || stop == StopReason::PairsFull => Ok(answer.value),
            stop => Err(stop),
        }
    }

    /// The obstacle that blocks a push, as a verdict.
    pub fn obstacle(&mut self, at: DVec3) -> Step<Verdict> {
        let query = Query::intersection(self.asked.a, self.asked.b, self.asked.pushed(at));
        self.ask(&self.kind(query))
    }

    /// The question about solids or surfaces: about their cores, until the search is about
    /// thickened bodies.
    pub fn kind<'q>(&self, query: Query<'q, Intersection>) -> Query<'q, Intersection> {
        let query = self.asked.kind(query);
        if self.state.is_thick {
            query
        } else {
            query.cores()
        }
    }

    /// Measures the distance of the cores, which tells how deep thickened bodies penetrate each
    /// other if their cores do not, and along which direction.
    fn measure(&mut self) -> Step {
        let PenetrationQuery { a, b, asked } = self.asked;
        let mut query = Query::distance(a, b, asked.b_in_a).absolute_tolerance(0.0);
        if !asked.solid {
            query = query.surfaces();
        }
        let found = self.ask(&query)?;
        let apart = query.witness_distance(self.engine);
        let state = &mut *self.state;
        state.task = Task::Explore;
        if found.low > 0.0 {
            (state.high, state.direction) = (0.0, DVec3::ZERO);
            state.task = Task::Over;
        } else if let Some(nearest) = found.nearest.filter(|_| apart > 0.0) {
            let depth = self.asked.radii() - apart;
            let corners = self.corners(nearest.triangles);
            let state = &mut *self.state;
            if !asked.push_only {
                state.low = state.low.max(depth - state.rounding);
            }
            let away = -closest(&corners[0], &corners[1]).direction;
            if away != DVec3::ZERO && found.within.is_none() {
                let length = depth.max(0.0) * (1.0 + 1e-9) + 4.0 * state.rounding;
                state.deepest = Some((away, length));
            }
        }
        Ok(())
    }

    /// The corners of two triangles in A's frame, before a push.
    pub fn corners(&self, [x, y]: [u32; 2]) -> [Triangle; 2] {
        let PenetrationQuery { a, b, asked } = self.asked;
        let of_b = b.mesh().triangle(y as usize);
        let of_b = of_b.map(|p| asked.b_in_a.transform_point(p));
        [a.mesh().triangle(x as usize), of_b]
    }
}

impl PenetrationQuery<'_> {
    pub(super) fn radii(&self) -> f64 {
        self.a.radius() + self.b.radius()
    }

    /// The question about solids, or about surfaces only.
    pub(super) fn kind<'q>(&self, query: Query<'q, Intersection>) -> Query<'q, Intersection> {
        if self.asked.solid {
            query
        } else {
            query.surfaces()
        }
    }

    /// The pose after a push; that before it if the push leads out of the range of poses.
    pub(super) fn pushed(&self, at: DVec3) -> Pose {
        let pose = &self.asked.b_in_a;
        Pose::new(pose.rotation(), pose.translation() + at).unwrap_or(*pose)
    }
}
