//! Time of impact of two surfaces: how the traversal handles node pairs and triangle pairs.
//!
//! A run covers one substep of the motion. Boxes are compared by time intervals ([`Windows`]).
//! Pairs whose boxes overlap at the begin are finished depth-first. Other pairs wait in the queue,
//! ordered by the time at which they may meet, and are dropped when there is an earlier contact.
//! Triangles are compared in `f32`, eight at a time. Those that may meet earlier than all before
//! are *followed* in `f64`, one at a time, in steps of bounded work: over ever shorter time
//! intervals, until an exact test proves a contact.

use super::relative_motion::{RelativeMotion, Setting};
use super::state::{Contact, Followed, MOMENTS, MotionState, Phase, bucket, least_key};
use super::windows::{BEGIN, Windows};
use crate::engine::expand::{LeafRows, Scratch, Sink, expand};
use crate::engine::frontier::{Frontier, Origin, Pair};
use crate::engine::outcome::{Stats, StopReason};
use crate::engine::traversal::{Traversal, Visitor};
use crate::engine::triangles::{points, rows};
use crate::model::cost::{
    WORK_PER_CLOSEST_POINTS, WORK_PER_EXACT_TEST, WORK_PER_LOOKUP, WORK_PER_WINDOW,
    WORK_PER_WINDOW_TEST,
};
use crate::query::distance::search::{Bounded, Search};
use crate::tree::WIDTH;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual_geom::lanes::Lanes;
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::distance::{closest, closest_or_meeting};
use punctual_geom::triangle::swept::{Glide, Swept, windows};
use punctual_geom::triangles_intersect;

impl Setting<'_> {
    /// The local time of the substep, in `f32`, from which on nothing matters.
    fn cut(&self, state: &MotionState) -> f32 {
        let cut = self.substep.local(state.cut().min(self.substep.end));
        cut + cut.abs() * 4.0 * ROUNDING + 4.0 * ROUNDING
    }
}

/// The question when two surfaces meet in a substep of a motion.
pub(super) struct Sweep<'q> {
    setting: Setting<'q>,
    glide: &'q Glide,
    /// A contact is searched for up to this long after the time at which triangles may meet.
    tolerance: f64,
    /// Local time from which on nothing matters ([`Setting::cut`]).
    cut: f32,
}

impl<'q> Sweep<'q> {
    pub fn new(setting: Setting<'q>, state: &MotionState, glide: &'q Glide) -> Self {
        Self {
            setting,
            glide,
            tolerance: state.tolerance(),
            cut: setting.cut(state),
        }
    }
}

impl<const POINTS: bool> Visitor for Traversal<'_, '_, Sweep<'_>, POINTS> {
    #[inline(always)]
    fn next_pair(&mut self) -> Option<(Pair, Origin)> {
        self.workspace.frontier.pop()
    }

    #[inline(always)]
    fn open<L: Lanes>(&mut self, lanes: L, pair: Pair, scratch: &mut Scratch) {
        let (question, workspace) = (&self.question, &mut *self.workspace);
        let mut least = f32::NEG_INFINITY;
        if self.origin == Origin::Queue {
            least = workspace.frontier.popped_key();
            if least >= question.cut {
                workspace.run.stats.work += WORK_PER_LOOKUP;
                if least_key(bucket(least)) >= question.cut {
                    // All others that wait reach the cut too.
                    workspace.frontier.clear_queue();
                }
                let time = question.setting.substep.time(least);
                return workspace.state.motion.pass(time);
            }
            // A pair that the full queue puts on the stack loses its bound.
            if workspace.frontier.room() < WIDTH * WIDTH {
                workspace.state.motion.bound(
                    &workspace.frontier,
                    &workspace.state.distance,
                    question.setting.substep,
                    least,
                );
            }
        }
        let trees = [self.a, self.b];
        let mut children = Children {
            frontier: &mut workspace.frontier,
            search: &mut workspace.state.distance,
            stats: &mut workspace.run.stats,
        };
        let sink = &mut children;
        let mut windows = Windows::new(question.cut, least, question.glide, self.relative);
        expand::<POINTS, _, _>(
            lanes,
            pair,
            trees,
            self.relative,
            &mut windows,
            scratch,
            sink,
        );
        let least = windows.least;
        self.pass_rest(least);
    }

    #[inline(always)]
    fn waits(&self, any: bool) -> bool {
        let workspace = &*self.workspace;
        let left = workspace.state.distance.waiting.len();
        left >= WIDTH
            || any
                && (left > 0
                    || !workspace.state.distance.proposed.is_empty()
                    || workspace.state.motion.followed.is_some())
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, lanes: L) -> Option<StopReason> {
        let workspace = &mut *self.workspace;
        if let Some(followed) = workspace.state.motion.followed.take() {
            self.follow(followed);
        } else {
            self.test_batch(lanes);
        }
        let workspace = &mut *self.workspace;
        let (search, state) = (&workspace.state.distance, &workspace.state.motion);
        let last = workspace.frontier.is_empty() && !search.waiting.is_empty();
        workspace.testing = state.followed.is_some()
            || !search.proposed.is_empty()
            || search.waiting.len() >= WIDTH
            || last;
        state.is_decided().then_some(StopReason::Finished)
    }
}

impl<const POINTS: bool> Traversal<'_, '_, Sweep<'_>, POINTS> {
    /// Computes the times at which up to eight waiting pairs may meet. If earlier pairs were
    /// compared, it instead follows the one of them that may meet first. If B turns, it first tests
    /// each eighth of the substep for that pair.
    #[inline(always)]
    fn test_batch<L: Lanes>(&mut self, lanes: L) {
        let (search, state) = (
            &mut self.workspace.state.distance,
            &mut self.workspace.state.motion,
        );
        let (substep, cut) = (self.question.setting.substep, &self.question.cut);
        let (relative, glide) = (self.relative, self.question.glide);
        let first = search.proposed.pop();
        if let Some(Bounded { pair, low }) = first.filter(|_| glide.spin == 0.0) {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            state.followed = Some(Followed::new(pair, [substep.time(low), substep.end], 1.0));
            return;
        }
        let (pairs, keys, count) = match first {
            Some(Bounded { pair, low }) => ([pair; WIDTH], [low; WIDTH], WIDTH),
            None => search.pop_batch(*cut, |low| state.pass(substep.time(low))),
        };
        if count == 0 {
            return;
        }
        let made = [
            points::<POINTS>(self.a, pairs, 0),
            points::<POINTS>(self.b, pairs, 1),
        ];
        let (a, b) = (
            rows(self.a, &made[0], pairs, 0),
            rows(self.b, &made[1], pairs, 1),
        );
        let (enter, active) = windows(
            lanes,
            a,
            b,
            &relative.triangles,
            glide,
            *cut,
            first.is_some(),
        );
        let stats = &mut self.workspace.run.stats;
        stats.primitive_tests += if first.is_some() { 0 } else { count as u64 };
        stats.work += count as u64 * WORK_PER_WINDOW_TEST;
        let known = keys[..count].iter().copied().fold(f32::INFINITY, f32::min);
        self.pass_rest(known);
        if active == 0 {
            return;
        }
        let substep = self.question.setting.substep;
        match first {
            Some(Bounded { pair, low }) => {
                let (first, last) = (active.trailing_zeros(), active.ilog2());
                let from = substep.time(larger_known(enter[first as usize % WIDTH], low));
                let until = substep.end_of_part(last, WIDTH as u32);
                if from < until {
                    let followed =
                        Followed::new(pair, [from, until], substep.length() / WIDTH as f64);
                    self.workspace.state.motion.followed = Some(followed);
                }
            }
            None => self.propose(&pairs[..count], &keys, &enter, active),
        }
    }

    /// Raises the time until which the motion is free to the larger of `known`, the bound of the
    /// parent, and the cut, if a contact made the cut: dropped children meet no earlier. So the
    /// result is never less than what an earlier, stopped call has proven.
    #[inline(always)]
    fn pass_rest(&mut self, known: f32) {
        if self.workspace.state.motion.contact().is_some() {
            let time = larger_known(self.question.cut, known);
            let time = self.question.setting.substep.time(time);
            self.workspace.state.motion.pass(time);
        }
    }

    #[inline(never)]
    fn propose(
        &mut self,
        pairs: &[[u32; 2]],
        keys: &[f32; WIDTH],
        enter: &[f32; WIDTH],
        active: u32,
    ) {
        let mut proposed: ArrayVec<Bounded, WIDTH> = (0..pairs.len())
            .filter(|i| active >> i & 1 != 0)
            .map(|i| Bounded {
                pair: pairs[i],
                low: larger_known(enter[i], keys[i]),
            })
            .collect();
        proposed.sort_unstable_by(|x, y| y.low.total_cmp(&x.low).then(y.pair.cmp(&x.pair)));
        self.workspace.state.distance.proposed = proposed;
    }

    /// Advances a pair by one step.
    #[inline(never)]
    fn follow(&mut self, followed: Followed) {
        let state = &mut self.workspace.state.motion;
        if !state.matters(followed.from) {
            self.workspace.run.stats.work += WORK_PER_LOOKUP;
            return state.pass(followed.from);
        }
        self.deadline.allow_for_long_step();
        self.workspace.state.motion.followed = match followed.phase {
            Phase::Contact(moment) => self.look_for_contact(followed, moment),
            Phase::Window | Phase::Direction => self.narrow(followed),
        };
    }

    /// Narrows the times at which a pair may meet in the current interval, by its edges or by the
    /// direction between its closest points. Returns the next step.
    fn narrow(&mut self, mut followed: Followed) -> Option<Followed> {
        let Followed {
            pair,
            from,
            until,
            phase,
            ..
        } = followed;
        let Setting {
            relative_motion,
            margin,
            ..
        } = self.question.setting;
        let tolerance = self.question.tolerance;
        let (stats, state) = (
            &mut self.workspace.run.stats,
            &mut self.workspace.state.motion,
        );
        let [of_a, of_b] = &mut self.workspace.corners;
        let (a, of_b) = (
            of_a.of(self.a, pair[0], |v| v),
            of_b.of(self.b, pair[1], |v| v),
        );
        let at = |time| placed(relative_motion, of_b, time);
        let span = followed.span.min(until - from);
        let (half, middle) = (span / 2.0, from + span / 2.0);
        let (b, twist) = (at(middle), relative_motion.twist(middle));
        // The error of times, from the bend of the corners' paths and from the turn of the
        // triangle.
        let enough = (tolerance * relative_motion.speed / 16.0).max(relative_motion.rounding);
        let velocities = b.map(|corner| twist.at(corner));
        let tilt = relative_motion.spin * half * (b[1] - b[0]).length().max((b[2] - b[0]).length());
        let (bends, rest) = (
            relative_motion.bends(&twist, &b, half),
            relative_motion.bend_besides(half),
        );
        let swept = Swept::new(
            a,
            &b,
            velocities,
            bends,
            rest + 2.0 * relative_motion.rounding + margin,
            half,
        );
        let bend = rest + bends.map(DVec3::length).into_iter().fold(0.0, f64::max);
        followed.steps += 1;
        let window = if phase == Phase::Direction {
            stats.work += WORK_PER_CLOSEST_POINTS + WORK_PER_EXACT_TEST;
            swept.on(closest_or_meeting(a, &at(from)).direction, [-half, half])
        } else {
            stats.work += WORK_PER_WINDOW;
            swept.window(if state.cut() > 0.0 {
                state.cut() - middle
            } else {
                f64::INFINITY
            })
        };
        let Some([enter, leave]) = window else {
            // No contact in this interval.
            (followed.from, followed.span, followed.phase) =
                (from + span, 4.0 * span, Phase::Window);
            return (followed.from < until).then_some(followed);
        };
        let (enter, leave) = (
            (middle + enter).max(from),
            (middle + leave).min(from + span),
        );
        followed.from = enter;
        if !state.matters(enter) {
            state.pass(enter);
            return None;
        }
        followed.longest = tolerance.min(leave - enter);
        let (is_bent, is_tilted) = (bend > enough, tilt > enough || enter > from);
        followed.phase = match phase {
            Phase::Window if !is_bent => Phase::Contact(usize::from(enter > 0.0)),
            Phase::Direction if enter - from >= span / 8.0 => Phase::Window,
            Phase::Direction if followed.steps >= PATIENCE || !is_tilted => Phase::Contact(2),
            _ => {
                followed.span = span / 8.0;
                Phase::Window
            }
        };
        Some(followed)
    }

    /// Tests whether a pair meets at a moment. If not, returns the next step.
    fn look_for_contact(&mut self, mut followed: Followed, moment: usize) -> Option<Followed> {
        let Followed {
            pair, from, until, ..
        } = followed;
        let Setting {
            relative_motion,
            margin,
            ..
        } = self.question.setting;
        let tolerance = self.question.tolerance;
        let (stats, state) = (
            &mut self.workspace.run.stats,
            &mut self.workspace.state.motion,
        );
        let [of_a, of_b] = &mut self.workspace.corners;
        let (a, of_b) = (
            of_a.of(self.a, pair[0], |v| v),
            of_b.of(self.b, pair[1], |v| v),
        );
        stats.exact_tests += 1;
        stats.work += WORK_PER_EXACT_TEST
            + if margin > 0.0 {
                WORK_PER_CLOSEST_POINTS
            } else {
                0
            };
        let time = from + followed.longest * MOMENTS[moment];
        if let Some(distance) = meet(a, &placed(relative_motion, of_b, time), margin) {
            state.pass(from);
            state.touch(Contact {
                time,
                pair,
                distance,
            });
            self.question.cut = self.question.setting.cut(&self.workspace.state.motion);
            return None;
        }
        followed.phase = match moment {
            1 => Phase::Direction,
            _ if moment + 1 < MOMENTS.len() => Phase::Contact(moment + 1),
            _ => {
                // The tests at this time were inconclusive; continue at a later time.
                state.pass(from);
                let further = (tolerance * libm::ldexp(1.0, followed.doubts)).max(f64::EPSILON);
                if from + further >= until {
                    return None;
                }
                (followed.from, followed.span) = (from + further, 1.0);
                (followed.steps, followed.doubts) = (0, followed.doubts + 1);
                Phase::Window
            }
        };
        Some(followed)
    }
}

/// The larger of a bound and a known one; NaN is ignored.
fn larger_known(bound: f32, known: f32) -> f32 {
    if bound > known { bound } else { known }
}

/// After this many inconclusive steps with a pair, contact is tested instead of ever shorter
/// intervals.
const PATIENCE: u32 = 400;

/// The corners of a triangle of B at a time.
fn placed(relative_motion: &RelativeMotion, corners: &[DVec3; 3], time: f64) -> [DVec3; 3] {
    let pose = relative_motion.pose(time);
    corners.map(|corner| pose.transform_point(corner))
}

/// If two triangles meet, thickened by `margin` in total: an upper bound of their distance, 0 only
/// if they intersect.
fn meet(a: &[DVec3; 3], b: &[DVec3; 3], margin: f64) -> Option<f64> {
    if triangles_intersect(a, b) {
        return Some(0.0);
    }
    (margin > 0.0)
        .then(|| closest(a, b).of_apart(a, b).high)
        .filter(|&distance| distance <= margin)
}

/// Receives the children of an opened pair.
struct Children<'w> {
    frontier: &'w mut Frontier,
    search: &'w mut Search,
    stats: &'w mut Stats,
}

impl Sink for Children<'_> {
    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        self.stats
    }

    #[inline(always)]
    fn place(&mut self, pair: Pair, key: impl FnOnce() -> f32) {
        let key = key();
        if key > BEGIN {
            self.frontier.queue(pair, key, bucket(key));
        } else {
            self.frontier.push(pair);
        }
    }

    #[inline(always)]
    fn triangles<'t, L: Lanes>(
        &mut self,
        _: L,
        hits: u64,
        key: impl Fn(usize) -> f32,
        first: [u32; 2],
        _: impl FnOnce() -> LeafRows<'t>,
    ) {
        self.search.wait(hits, first, key);
    }
}
