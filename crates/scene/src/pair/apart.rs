//! Pairs proven to be farther apart than their bodies have moved since: they are decided without a
//! query.
//!
//! Bodies at rest on one another jitter, and most pairs of overlapping boxes are separated. If both
//! bodies move slowly, the query asks whether they are closer than a number of steps of this size,
//! instead of whether they meet. That takes a few times the work, and then none for as many frames.
//! The proof is in `docs/numerics.md`.

use super::batch::{Context, Ended, RoundKind};
use super::bounds::Proof;
use super::question::Question;
use super::state::Turn;
use super::travel::slack;
use crate::body::{Bodies, Placed, thickness};
use crate::cost::{WORK_PER_PLANE, WORK_PER_ROOT_TEST};
use crate::facts::Facts;
use crate::id::{PairKey, bodies_of};
use crate::spot::Spot;
use punctual::engine::SeparatingPlane;
use punctual::engine::root_test;
use punctual::{Mode, Verdict};
use punctual_geom::Pose;
use punctual_geom::tolerance::SCENE_ROTATION_TOLERANCE;

/// Relative difference of lengths in the scene and in the frame of a body, upper bound.
pub(crate) const STRETCH: f64 = 8.0 * SCENE_ROTATION_TOLERANCE;

/// A proof is tried for a distance of `LEAST_STEPS` to `MOST_STEPS` steps of the bodies. If they
/// are closer, it is tried for a smaller distance of at least `LEAST_OF_NEAR` steps.
const LEAST_STEPS: f64 = 8.0;
const LEAST_OF_NEAR: f64 = 3.0;
const MOST_STEPS: f64 = 64.0;

/// Upper limit of the distance asked for, relative to the smaller body: larger separations are
/// found at little cost anyway.
const LARGEST_PART: f64 = 1.0 / 64.0;

/// Frames until the next attempt: after a failed proof, and after the bodies were too fast for one.
const PAUSE: u64 = 32;
const BREAK: u64 = 8;

/// Maximum number of planes tried in a turn.
const PLANES: u32 = 16;

/// Turns without planes after none has separated the bodies. Each further failure doubles them, at
/// most `MOST_IN_VAIN` times.
const WITHOUT_PLANES: u8 = 4;
const MOST_IN_VAIN: u8 = 4;

/// If the last search of a pair took more work than this, the root test rarely helps; if it took
/// less, planes help little.
pub(crate) const LONG_SEARCH: u32 = 400;

/// Room required for a proof: `ROOM` times the work of the last search, plus `MORE_ROOM`.
const ROOM: u64 = 4;
const MORE_ROOM: u64 = 4096;

impl Bodies {
    /// Upper bound of the sum of the displacements of both bodies. Infinite if one was changed
    /// other than by a move between frames `since` and `frame`, the current one.
    #[inline]
    pub fn gone(&self, key: PairKey, since: u64, frame: u64) -> f64 {
        let [x, y] = self.spots_of(key);
        if x.has_only_moved(since, frame) && y.has_only_moved(since, frame) {
            (x.gone + y.gone).next_up()
        } else {
            f64::INFINITY
        }
    }

    /// Lower bound of the sum of the displacements of both bodies.
    pub fn gone_at_least(&self, key: PairKey) -> f64 {
        let [x, y] = self.spots_of(key);
        (x.gone + y.gone).next_down()
    }

    fn spots_of(&self, key: PairKey) -> [&Spot; 2] {
        bodies_of(key).map(|body| &self.spots[body as usize])
    }
}

impl Turn {
    /// True if the root test is applicable, and likely to separate the bodies.
    #[inline]
    pub fn may_test_roots(&self, context: &mut Context) -> bool {
        !self.state.met()
            && self.state.search <= LONG_SEARCH
            && self.has_room(WORK_PER_ROOT_TEST, context)
    }

    /// True if a plane is likely to separate the bodies. Before the broad phase, where time is
    /// short, only if one did the last time.
    #[inline]
    pub fn may_part(&mut self, context: &mut Context) -> bool {
        let did =
            self.state.in_vain == 0 && self.state.separating_plane != SeparatingPlane::default();
        let is_likely = self.state.verdict == Verdict::Separated
            && self.state.search > LONG_SEARCH
            && (did || context.round.kind == RoundKind::Answer)
            && self.has_room(u64::from(PLANES) * WORK_PER_PLANE, context);
        let waits = self.state.without_planes > 0;
        self.state.without_planes -= u8::from(is_likely && waits);
        is_likely && !waits
    }

    /// True if there is room for extra work besides a query, and the only question is whether the
    /// bodies meet.
    #[inline(always)]
    fn has_room(&self, work: u64, context: &mut Context) -> bool {
        !context.held
            && context.bodies.asks_only_contact(self.key())
            && context
                .deadline
                .has_room(work + context.bodies.least_work())
    }

    /// Runs the root test; true if it separates the bodies, and then records the bound. False also
    /// if the bodies are slow and a proof that lasts longer should be tried instead.
    #[inline(never)]
    pub fn root_test_parts(
        &mut self,
        pair: [&Placed; 2],
        b_in_a: &Pose,
        context: &mut Context,
    ) -> bool {
        context.deadline.spend(WORK_PER_ROOT_TEST);
        self.spent.work += WORK_PER_ROOT_TEST;
        let trees = pair.map(|placed| &*placed.body.tree);
        let low = root_test::distance(trees, b_in_a, context.workspace) - thickness(pair);
        let (bodies, key, frame) = (context.bodies, self.key(), context.round.frame);
        let lasts = low >= LEAST_STEPS * step(bodies, key, frame);
        if low <= 0.0
            || self.looks_beyond(low, context)
            || !lasts && self.may_prove_apart(context) && reach(bodies, key, pair, frame).is_some()
        {
            return false;
        }
        if lasts || self.state.proves_from == 0 {
            self.state.note_apart(until(bodies, key, pair, low, frame));
        }
        self.state.search = WORK_PER_ROOT_TEST as u32;
        self.state.finish(Verdict::Separated, 0, frame);
        true
    }

    /// True if one of a few planes separates the bodies; then records the bound.
    #[inline(never)]
    pub fn a_plane_parts(
        &mut self,
        pair: [&Placed; 2],
        b_in_a: &Pose,
        context: &mut Context,
    ) -> bool {
        let trees = pair.map(|placed| &*placed.body.tree);
        let (low, tried) =
            self.state
                .separating_plane
                .distance(trees, b_in_a, PLANES, context.workspace);
        let low = low - thickness(pair);
        let (work, frame) = (u64::from(tried) * WORK_PER_PLANE, context.round.frame);
        context.deadline.spend(work);
        self.spent.work += work;
        if low <= 0.0 || self.looks_beyond(low, context) {
            self.state.without_planes = WITHOUT_PLANES << self.state.in_vain;
            self.state.in_vain = MOST_IN_VAIN.min(self.state.in_vain + 1);
            return false;
        }
        self.state.in_vain = 0;
        let until = until(context.bodies, self.key(), pair, low, frame);
        self.state.note_apart(until);
        self.state.finish(Verdict::Separated, 0, frame);
        true
    }

    /// True if a proof of some distance should be tried; not if there is a stopped run to resume.
    #[inline]
    pub fn may_prove_apart(&self, context: &Context) -> bool {
        let until = self
            .state
            .proves_from
            .wrapping_sub(context.round.frame as u16);
        let is_due = self.state.proves_from == 0 || !(1..=PAUSE as u16).contains(&until);
        context.looks_ahead
            && !context.held
            && self.state.verdict == Verdict::Separated
            && is_due
            && !self.looks_beyond(0.0, context)
    }

    /// Proves a lower bound of the distance of slow bodies. `None` if the question whether they
    /// meet is still open.
    #[inline(never)]
    pub fn prove_apart(
        &mut self,
        pair: [&Placed; 2],
        b_in_a: Pose,
        context: &mut Context,
    ) -> Option<Ended> {
        let Context { bodies, round, .. } = *context;
        let (key, frame) = (self.key(), round.frame);
        let Some(mut limit) = reach(bodies, key, pair, frame) else {
            self.state.proves_from = (frame + BREAK) as u16;
            return None;
        };
        let needed = ROOM * u64::from(self.state.search) + MORE_ROOM;
        if !context.deadline.has_room(needed) {
            return None;
        }
        self.state.proves_from = (frame + PAUSE) as u16;
        let answer = loop {
            let answer = self.measure(&Question::apart(pair, b_in_a, limit), context);
            let Some(Proof::Distance(bounds)) = answer.proof else {
                return None;
            };
            match answer.verdict {
                Verdict::Separated => {
                    self.state
                        .note_apart(until(bodies, key, pair, bounds.low, frame));
                    break answer;
                }
                verdict if verdict.meets() && round.mode == Mode::Any => break answer,
                // Their distance is likely to be half of the bound found.
                Verdict::Undecided if bounds.high < limit => limit = bounds.high / 2.0,
                _ => return None,
            }
            if limit < LEAST_OF_NEAR * step(bodies, key, frame)
                || !context.deadline.has_room(needed)
            {
                return None;
            }
        };
        self.state.finish(answer.verdict, answer.found, frame);
        Some(Ended::Complete)
    }
}

/// The sum of displacements below which bodies cannot meet that are `low` apart in `frame`.
pub(crate) fn until(
    bodies: &Bodies,
    key: PairKey,
    pair: [&Placed; 2],
    low: f64,
    frame: u64,
) -> f64 {
    (room(pair, low) + bodies.gone(key, frame, frame))
        .next_down()
        .next_down()
}

/// Sum of the displacements of both bodies in this frame.
fn step(bodies: &Bodies, key: PairKey, frame: u64) -> f64 {
    let step = |facts: &Facts| {
        if facts.changed == frame {
            f64::from(facts.step)
        } else {
            0.0
        }
    };
    let [a, b] = bodies.facts_of(key);
    step(a) + step(b)
}

/// The distance to prove. `None` if the bodies rest or are too fast, or if the pair has other
/// questions.
pub(crate) fn reach(bodies: &Bodies, key: PairKey, pair: [&Placed; 2], frame: u64) -> Option<f64> {
    let step = step(bodies, key, frame);
    if step == 0.0 {
        return None;
    }
    let size = pair
        .map(|placed| placed.body.tree.unit_length())
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let limit = (MOST_STEPS * step).min(LARGEST_PART * size);
    let is_slow = limit >= LEAST_STEPS * step;
    (is_slow && bodies.asks_only_contact(key)).then_some(limit)
}

/// How far bodies at a proven distance `low`, margins not counted, can move before they may meet.
pub(crate) fn room(pair: [&Placed; 2], low: f64) -> f64 {
    let [of_a, of_b] = pair.map(|placed| slack(&placed.body.tree, &placed.body.pose));
    low - STRETCH * (low + thickness(pair)) - of_a - of_b
}
