//! The search for a short push. Contacts give directions, whose lengths are bisected. Each new best
//! push is polished: the face by which it leaves the blocked translations bounds a half space, and
//! the next push is the shortest translation in the half spaces of the last few.

use super::cover::Cone;
use super::directions::{Segments, WORK_PER_SEGMENT};
use super::machine::{CONTACTS, Machine, STEP, Step, Task};
use super::sets::{Face, Pair, WORK_TO_LEAVE, unit};
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual::prediction::MAX_STEP_WORK;
use punctual::{Query, Verdict};

/// Contacts that are read at a pushed pose.
const CONTACTS_AHEAD: usize = 48;

/// Work to make a pair.
const WORK_PER_NEW_PAIR: u64 = 400;

/// Work of a push besides its query and the known pairs, and of polishing one.
const WORK_PER_PUSH: u64 = 600;
const _: () = assert!(MAX_STEP_WORK + WORK_PER_PUSH + WORK_TO_LEAVE <= STEP);

/// Length of the first push in another direction, relative to the best push.
const SHORTER: f64 = 0.98;

/// Relative width to which the length of a push is bisected, and that of a polished one.
const WIDTH: f64 = 0.01;
const POLISHED_WIDTH: f64 = 1e-3;

/// The angle by which the best direction of all is turned, radians.
const TURN: f64 = 0.3;

/// A polished push is tried if it is expected to be shorter than the best by this share.
const LEAST_GAIN: f64 = 1e-6;

/// Maximum number of pushes that polish a new best one.
const ROUNDS: usize = 3;

/// A push exceeds the length at which it leaves a face by this share of it, and by two roundings.
const BEYOND: f64 = 1e-10;

/// Length of the first push, relative to the push that separates the boxes. The next factor
/// lengthens a push that is too short.
const FIRST: f64 = 1e-3;
const GROWTH: f64 = 1.7;

/// The faces of a new best push and of those that polish it.
pub(super) type Faces = ArrayVec<Face, ROUNDS>;

/// The shortest translation beyond all faces.
fn shortest(faces: &Faces) -> Option<DVec3> {
    let is_beyond = |t: &DVec3| {
        let least = -1e-12 * punctual_geom::length(*t);
        faces.iter().all(|face| face.beyond(*t) >= least)
    };
    let count = faces.len();
    let threes =
        (0..count).flat_map(|i| (0..=i).flat_map(move |j| (0..=j).map(move |k| [i, j, k])));
    let points = threes.map(|three| {
        let (mut point, mut axes) = (DVec3::ZERO, ArrayVec::<DVec3, 3>::new());
        for face in three.map(|i| faces[i]) {
            let free = axes
                .iter()
                .fold(face.normal, |n, axis| n - axis * axis.dot(n));
            let length = free.length();
            if length > 1e-6 {
                point -= free * (face.beyond(point) / (length * length));
                axes.push(free / length);
            }
        }
        point
    });
    let length = |t: &DVec3| punctual_geom::length(*t);
    points
        .filter(is_beyond)
        .min_by(|s, t| length(s).total_cmp(&length(t)))
}

/// A push whose length is searched.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Push {
    direction: DVec3,
    /// A blocked length, and the face by which the push leaves the obstacle there.
    low: f64,
    face: Option<Face>,
    /// A length that separates, if one is known.
    high: Option<f64>,
    /// The obstacle at the last length that was tried and is blocked, and that length.
    obstacle: Option<(Verdict, f64)>,
    /// The push polishes the best one.
    polishes: bool,
    /// The length to try first, if one is expected to separate.
    guess: Option<f64>,
    /// The length to try next, if bisection or growth does not give it.
    next: Option<f64>,
}

impl Push {
    pub fn new(direction: DVec3, low: f64) -> Self {
        Self {
            direction,
            low,
            ..Self::default()
        }
    }
}

impl Machine<'_, '_, '_> {
    /// Lists the contacts just outside of the current cone, or at the pose.
    pub(super) fn list(&mut self) -> Step {
        let (direction, length, most) = match &self.state.current {
            None => (DVec3::ZERO, 0.0, CONTACTS),
            Some(current) => {
                let length = current.proven * (1.0 + 1e-3) + 16.0 * self.state.rounding;
                let length = length.min(self.state.high);
                (current.cone.middle(), length, CONTACTS_AHEAD)
            }
        };
        let at = direction * length;
        let query = Query::all_pairs(self.asked.a, self.asked.b, self.asked.pushed(at));
        let query = query.pair_limit(most);
        let mut verdict = self.ask(&self.kind(query))?;
        let pairs = self.engine.pairs();
        if let Some(&witness) = pairs.get(pairs.len() / 2) {
            verdict = Verdict::Intersecting { witness };
        }
        self.sow(verdict, at);
        let state = &mut *self.state;
        if let Some(current) = &mut state.current {
            current.has_asked = true;
        }
        state.task = match (verdict, &state.current) {
            (Verdict::Intersecting { .. }, _) => Task::Read(0),
            (Verdict::Separated, None) => {
                (state.high, state.direction) = (0.0, DVec3::ZERO);
                Task::Over
            }
            (Verdict::Separated, Some(_)) => {
                state.separates(direction, length);
                Task::Split
            }
            (_, Some(_)) => Task::Grow,
            (_, None) => {
                let directions = Cone::all_around(0.0).map(|cone| cone.middle());
                state.likely.extend(directions);
                Task::Explore
            }
        };
        Ok(())
    }

    /// Reads some of the contacts.
    pub(super) fn read(&mut self, next: usize) -> Step {
        const EACH: usize = 4;
        self.pay(EACH as u64 * (WORK_PER_NEW_PAIR + WORK_PER_SEGMENT))?;
        let count = self.engine.pairs().len();
        let last = (next + EACH).min(count);
        for i in next..last {
            let id = self.engine.pairs()[i];
            let corners = self.corners(id);
            let pair = Pair::new(corners);
            self.sets.add_pair(id, pair);
            if self.state.current.is_none() {
                let margin = pair.margin();
                if self.state.widest.is_none_or(|(most, _)| margin > most) {
                    self.state.widest = Some((margin, pair));
                }
                let size = self.size();
                let new = || Segments::new(corners[0][0], size);
                self.state.segments.get_or_insert_with(new).add(&corners);
            }
        }
        self.state.task = if last < count {
            Task::Read(last)
        } else if self.state.current.is_some() {
            Task::Grow
        } else {
            let likely = self.state.segments.iter().flat_map(Segments::directions);
            self.state.likely.extend(likely);
            self.state.likely.reverse();
            Task::Explore
        };
        Ok(())
    }

    /// The longest extent of both meshes.
    pub(super) fn size(&self) -> f64 {
        let [a, b] = [self.asked.a, self.asked.b].map(|tree| tree.mesh().aabb().extents());
        a.max(b).max_element().max(f64::MIN_POSITIVE)
    }

    /// Takes the next of the likely directions, unless the known pairs block it up to the goal.
    pub(super) fn explore(&mut self) -> Step {
        self.deadline.check(STEP)?;
        if let Some((direction, length)) = self.state.deepest.take() {
            self.spend(64);
            self.state.task = Task::Push(Push {
                guess: Some(length),
                ..Push::new(direction, 0.0)
            });
            return Ok(());
        }
        self.state.task = match self.state.likely.pop() {
            Some(direction) => {
                let push = self.leave(Push::new(direction, 0.0));
                if push.low < self.goal() {
                    Task::Push(push)
                } else {
                    Task::Explore
                }
            }
            None if self.state.turned.is_none() => {
                self.sow_corners();
                Task::Start
            }
            None => self.turn(),
        };
        self.spend(64);
        Ok(())
    }

    /// Raises the blocked length to where the push leaves the known pairs, up to rounding.
    fn leave(&mut self, mut push: Push) -> Push {
        let (low, pair, work) = self.sets.free_from(push.direction, push.low);
        push.low = low;
        if let Some(pair) = pair {
            push.face = pair.face(push.direction * low);
            push.next = Some(low * (1.0 + BEYOND) + 2.0 * self.state.rounding);
        }
        self.spend(work);
        push
    }

    /// The length at which a push in another direction is tried first.
    fn goal(&self) -> f64 {
        let (low, high) = match &self.state.current {
            Some(current) => (current.proven, self.state.high),
            None => (self.state.low, self.state.high),
        };
        (SHORTER * high).max(0.5 * (low + high))
    }

    /// Queues six directions tilted .3 rad from the best one, unless the last six gained nothing.
    fn turn(&mut self) -> Task {
        let state = &mut *self.state;
        if state.turned.is_some_and(|before| state.high >= before) {
            return Task::Over;
        }
        state.turned = Some(state.high);
        let best = state.direction;
        let (u, w) = best.any_orthonormal_pair();
        let sides = [u, -u, w, -w, u + w, -u - w];
        let turned = sides.map(|side| unit(best + unit(side) * TURN));
        state.likely.extend(turned);
        Task::Explore
    }

    /// Tries all directions. No more is asked of `low`, or no more can be proven.
    pub(super) fn explore_all(&mut self) -> Task {
        let state = &mut *self.state;
        state.turned = Some(f64::INFINITY);
        state
            .likely
            .extend(Cone::all_around(0.0).map(|cone| cone.middle()));
        let segments = self.state.segments.iter().flat_map(Segments::directions);
        self.state
            .likely
            .extend(segments.map(|direction| -direction));
        Task::Explore
    }

    /// Searches the length of a push.
    pub(super) fn push(&mut self, mut push: Push) -> Step {
        let longest = 1.001 * self.parting_length(push.direction) + 64.0 * self.state.rounding;
        let best = self.state.high;
        let is_known = best < f64::INFINITY;
        let last = if push.polishes {
            (1.0 - LEAST_GAIN) * best
        } else {
            self.goal()
        };
        let mut next_before = |most: f64| push.next.take().filter(|next| *next < most);
        let length = match push.high {
            Some(high) => next_before(high).unwrap_or(0.5 * (push.low + high)),
            None if push.polishes => next_before(last).unwrap_or(last),
            None if is_known => last,
            None if push.guess.is_some_and(|guess| guess > push.low) => {
                push.guess.take().unwrap_or(longest)
            }
            None => (GROWTH * push.low).max(FIRST * longest).min(longest),
        };
        let obstacle = self.obstacle(push.direction * length)?;
        self.spend(WORK_PER_PUSH);
        let is_over = if obstacle == Verdict::Separated {
            self.state.separates(push.direction, length);
            push.high = Some(length);
            false
        } else {
            if let Verdict::Intersecting { witness } = obstacle {
                self.learn(witness, push.direction);
            }
            push.obstacle = Some((obstacle, length));
            let is_last = length >= if is_known { last } else { longest };
            let middle = push.high.map(|high| 0.5 * (push.low + high));
            push.low = length;
            push = self.leave(push);
            // The gain was less than that of bisection, or no length is known to separate. So do
            // not follow the known pairs.
            if middle.is_none_or(|middle| length < middle) {
                push.next = None;
            }
            push.high.is_none() && is_last
        };
        let width = if push.polishes { POLISHED_WIDTH } else { WIDTH };
        let least = self.state.rounding;
        let is_narrow = |high| high - push.low <= width * high || high <= least;
        self.state.task = if is_over || push.high.is_some_and(is_narrow) {
            Task::Polish(push)
        } else {
            Task::Push(push)
        };
        Ok(())
    }

    fn end_push(&mut self, push: &Push) -> Task {
        let is_new = push.high.is_some();
        let is_blocked = self.state.current.is_none() || !is_new;
        if is_blocked && let Some((obstacle, length)) = push.obstacle {
            self.sow(obstacle, push.direction * length);
        }
        match &self.state.current {
            None => Task::Explore,
            Some(_) if is_new || push.polishes => self.put_back(),
            Some(_) => self.after_block(),
        }
    }

    /// Follows this push by one that may be shorter than the best, or ends it.
    pub(super) fn polish(&mut self, push: Push) -> Step {
        self.deadline.check(STEP)?;
        let next = (push.high.is_some() || push.polishes).then(|| self.polished(&push));
        self.state.task = match next.flatten() {
            Some(next) => Task::Push(next),
            None => self.end_push(&push),
        };
        Ok(())
    }

    fn polished(&mut self, push: &Push) -> Option<Push> {
        let high = self.state.high;
        let faces = &mut self.state.faces;
        if !push.polishes {
            faces.clear();
        }
        faces.try_push(push.face?).ok()?;
        let shortest = shortest(faces)?;
        self.spend(WORK_PER_PUSH);
        let length = punctual_geom::length(shortest);
        if length >= high * (1.0 - LEAST_GAIN) {
            return None;
        }
        let next = self.leave(Push::new(unit(shortest), 0.0));
        let length = length * (1.0 + BEYOND) + 2.0 * self.state.rounding;
        (next.low < high).then_some(Push {
            polishes: true,
            next: Some(length.max(next.low)),
            ..next
        })
    }

    /// Length of a push after which the boxes are apart, up to rounding.
    fn parting_length(&self, direction: DVec3) -> f64 {
        let a = self.asked.a.mesh().aabb();
        let b = self.asked.b.aabb_at(&self.asked.asked.b_in_a);
        let forward = direction.cmpgt(DVec3::ZERO);
        let farthest = DVec3::select(forward, a.max - b.min, a.min - b.max);
        farthest.dot(direction).max(0.0) + self.asked.a.radius()
    }
}
