//! The search for a short push: contacts give directions, whose lengths are bisected.

use super::cover::Cone;
use super::directions::{Segments, WORK_PER_SEGMENT};
use super::machine::{CONTACTS, Job, Machine, STEP, Step};
use super::sets::{Pair, unit};
use glam::DVec3;
use punctual::{Query, Verdict};

/// Contacts that are read at a pushed pose.
const CONTACTS_AHEAD: usize = 48;

/// Work to make a pair.
const WORK_PER_NEW_PAIR: u64 = 400;

/// A push in another direction is tried at this share of the best.
const SHORTER: f64 = 0.98;

/// Relative width to which the length of a push is bisected: in proportion to the angle by which the
/// best direction is turned, within limits.
const WIDTH_TO_TURN: f64 = 0.1;
const WIDTH: f64 = 0.01;
const MOST_WIDTH: f64 = 0.05;

/// The first push, relative to the one after which the boxes are apart. One that is too short is
/// lengthened by the next factor.
const FIRST: f64 = 1e-3;
const GROWTH: f64 = 1.7;

/// First and least angle by which the best direction is turned, radians.
pub(super) const TURN: f64 = 0.6;
const LEAST_TURN: f64 = 0.01;

/// A push whose length is searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    direction: DVec3,
    /// A length that is blocked.
    low: f64,
    /// A length that separates, if one is known.
    high: Option<f64>,
    /// What blocks the length that was tried last and is blocked.
    obstacle: Option<(Verdict, f64)>,
}

impl Push {
    pub fn new(direction: DVec3, low: f64) -> Self {
        Self {
            direction,
            low,
            high: None,
            obstacle: None,
        }
    }
}

impl Machine<'_, '_, '_> {
    /// Lists the contacts just outside of the cone in hand, or at the pose.
    pub(super) fn list(&mut self) -> Step {
        let (direction, length, most) = match &self.state.hand {
            None => (DVec3::ZERO, 0.0, CONTACTS),
            Some(hand) => {
                let length = hand.proven * (1.0 + 1e-3) + 16.0 * self.state.rounding;
                let length = length.min(self.state.high);
                (hand.cone.middle(), length, CONTACTS_AHEAD)
            }
        };
        let at = direction * length;
        let query = Query::all_pairs(self.asked.a, self.asked.b, self.asked.pushed(at));
        let query = query.pair_limit(most);
        let mut verdict = self.ask(&self.asked.kind(query))?;
        let pairs = self.engine.pairs();
        if let Some(&witness) = pairs.get(pairs.len() / 2) {
            verdict = Verdict::Intersecting { witness };
        }
        self.sow(verdict, at);
        let state = &mut *self.state;
        if let Some(hand) = &mut state.hand {
            hand.has_asked = true;
        }
        state.job = match (verdict, &state.hand) {
            (Verdict::Intersecting { .. }, _) => Job::Read(0),
            (Verdict::Separated, None) => {
                state.high = 0.0;
                Job::Over
            }
            (Verdict::Separated, Some(_)) => {
                state.separates(direction, length);
                Job::Split
            }
            (_, Some(_)) => Job::Grow,
            (_, None) => {
                let directions = Cone::all_around(0.0).map(|cone| cone.middle());
                state.likely.extend(directions);
                Job::Explore
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
            if self.state.hand.is_none() {
                let margin = pair.margin();
                if self.state.widest.is_none_or(|(most, _)| margin > most) {
                    self.state.widest = Some((margin, pair));
                }
                let size = self.size();
                let new = || Segments::new(corners[0][0], size);
                self.state.segments.get_or_insert_with(new).add(&corners);
            }
        }
        self.state.job = if last < count {
            Job::Read(last)
        } else if self.state.hand.is_some() {
            Job::Grow
        } else {
            let likely = self.state.segments.iter().flat_map(Segments::directions);
            self.state.likely.extend(likely);
            self.state.likely.reverse();
            Job::Explore
        };
        Ok(())
    }

    /// The longest extent of both meshes.
    pub(super) fn size(&self) -> f64 {
        let [a, b] = [self.asked.a, self.asked.b].map(|tree| tree.mesh().aabb().extents());
        a.max(b).max_element().max(f64::MIN_POSITIVE)
    }

    /// Begins with the next of the likely directions, unless it is known to be blocked for too long.
    pub(super) fn explore(&mut self) -> Step {
        self.begin(STEP)?;
        self.state.job = match self.state.likely.pop() {
            Some(direction) => {
                let low = self.free_from(direction, 0.0);
                if low < self.goal() {
                    Job::Push(Push::new(direction, low))
                } else {
                    Job::Explore
                }
            }
            None if self.state.turned.is_none() => {
                self.sow_corners();
                Job::Start
            }
            None => self.turn(),
        };
        self.spend(64);
        Ok(())
    }

    /// A length, at least `from`, below which a push in this direction is known to be blocked, up to
    /// rounding.
    fn free_from(&mut self, direction: DVec3, from: f64) -> f64 {
        let (length, work) = self.sets.free_from(direction, from);
        self.spend(work);
        length
    }

    /// The length at which a push in another direction is tried first.
    fn goal(&self) -> f64 {
        let (low, high) = match &self.state.hand {
            Some(hand) => (hand.proven, self.state.high),
            None => (self.state.low, self.state.high),
        };
        (SHORTER * high).max(0.5 * (low + high))
    }

    /// Directions around the best one; nearer ones if the last did not help.
    fn turn(&mut self) -> Job {
        let state = &mut *self.state;
        if state.turned.is_none_or(|before| state.high >= before) {
            state.turn *= 0.5;
        }
        let is_known = state.rounding < state.high && state.high < f64::INFINITY;
        if state.turn < LEAST_TURN || !is_known {
            return Job::Over;
        }
        state.turned = Some(state.high);
        let (best, turn) = (state.direction, state.turn);
        let (u, w) = best.any_orthonormal_pair();
        let sides = [u, -u, w, -w, u + w, -u - w];
        let turned = sides.map(|side| unit(best + unit(side) * turn));
        state.likely.extend(turned.into_iter().rev());
        Job::Explore
    }

    /// Tries all directions, since nothing more is asked or can be known of `low`.
    pub(super) fn explore_all(&mut self) -> Job {
        let state = &mut *self.state;
        state.turned = Some(0.0);
        state
            .likely
            .extend(Cone::all_around(0.0).map(|cone| cone.middle()));
        let segments = self.state.segments.iter().flat_map(Segments::directions);
        self.state
            .likely
            .extend(segments.map(|direction| -direction));
        Job::Explore
    }

    /// Searches the length of a push.
    pub(super) fn push(&mut self, mut push: Push) -> Step {
        let longest = 1.001 * self.parting_length(push.direction) + 64.0 * self.state.rounding;
        let (is_known, goal) = (self.state.high < f64::INFINITY, self.goal());
        let length = match push.high {
            Some(high) => 0.5 * (push.low + high),
            None if is_known => goal,
            None => (GROWTH * push.low).max(FIRST * longest).min(longest),
        };
        let obstacle = self.obstacle(push.direction * length)?;
        self.spend(600);
        let is_over = if obstacle == Verdict::Separated {
            self.state.separates(push.direction, length);
            push.high = Some(length);
            false
        } else {
            if let Verdict::Intersecting { witness } = obstacle {
                self.learn(witness, push.direction);
            }
            push.obstacle = Some((obstacle, length));
            push.low = self.free_from(push.direction, length);
            push.high.is_none() && (is_known || length >= longest)
        };
        let width = match &self.state.hand {
            Some(_) => WIDTH,
            None => (WIDTH_TO_TURN * self.state.turn).clamp(WIDTH, MOST_WIDTH),
        };
        let least = self.state.rounding;
        let is_narrow = |high| high - push.low <= width * high || high <= least;
        self.state.job = if is_over || push.high.is_some_and(is_narrow) {
            self.end_push(&push)
        } else {
            Job::Push(push)
        };
        Ok(())
    }

    fn end_push(&mut self, push: &Push) -> Job {
        let is_new = push.high.is_some();
        let is_blocked = self.state.hand.is_none() || !is_new;
        if is_blocked && let Some((obstacle, length)) = push.obstacle {
            self.sow(obstacle, push.direction * length);
        }
        match (&self.state.hand, is_new) {
            (None, _) => Job::Explore,
            (Some(_), true) => self.put_back(),
            (Some(_), false) => self.after_block(),
        }
    }

    /// Length of a push after which the boxes are apart, up to rounding.
    fn parting_length(&self, direction: DVec3) -> f64 {
        let a = self.asked.a.mesh().aabb();
        let b = self.asked.b.aabb_at(&self.asked.asked.b_in_a);
        let forward = direction.cmpgt(DVec3::ZERO);
        let farthest = DVec3::select(forward, a.max - b.min, a.min - b.max);
        farthest.dot(direction).max(0.0)
    }
}
