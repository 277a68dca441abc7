//! A path in joint space, of straight lines or polynomials of time: proven free, in contact, or not
//! known from some time on.
//!
//! Its pieces, called lines here, are halved. At the middle of an interval each pair of shapes has
//! a distance. A bound limits how much of it the motion of half of the interval can use up
//! ([`Placement::reach`](crate::placement::Placement)). If the distance is larger, the pair is free
//! on the whole interval. Otherwise the pair is tested again in both halves. An open interval keeps
//! the pairs that are not proven on it. So at each moment all of the path is proven, known to be in
//! contact, or covered by an open interval.
//!
//! A pair that glides along what stands still would need ever shorter intervals. So where one shape
//! of a pair, seen from the other, moves almost straight, its sweep along that straight line is
//! tested, thickened by what it may be off ([`Call::is_free`]).
//!
//! If any contact will do, five configurations are tested first, and then wide intervals before
//! narrow ones. For the first contact, intervals are taken from left to right.

use std::collections::VecDeque;

use punctual::StopReason;
use punctual::clock::ClockedBudget;
use punctual_geom::named;

use crate::call::Call;
use crate::checker::Outcome;
use crate::error::refuse;
use crate::model::LARGEST;
use crate::order::BOX_WORK;
use crate::trajectory::{Move, Piece};
use crate::transform::Transform;
use crate::world::World;
use crate::{Checker, RobotError, ShapeId, Trajectory};

/// Shares of the path where contacts are sought first, from coarse to fine.
const PROBES: [f64; 5] = [0.0, 1.0, 0.5, 0.25, 0.75];
const ENDS: usize = 2;

/// A pair whose boxes are farther apart than this share of the limit gets no exact query: its boxes
/// will prove it on shorter intervals.
const APART: f64 = 1.0 / 16.0;

/// A pair is swept along a straight line if it is off it by at most this share of the limit.
const STRAIGHT: f64 = 1.0 / 64.0;

/// Work of bounding how far the points of a pair move, and of the test of its spheres, in units of
/// a query's work.
const SPHERE_WORK: u64 = 20;

/// Intervals are never narrower than this.
const NARROWEST: f64 = 1e-12;

/// Options of a question about an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EdgeOptions {
    /// Seek the first contact, not any. Off by default.
    pub first: bool,
    /// Intervals that are shorter than this share of the edge are given up. So the time of the
    /// first contact is known only to this share, and a pair that comes too close for such an
    /// interval stays undecided. By default 1e-6; at least 1e-12.
    pub resolution: f64,
    /// The time of the beginning, in seconds, for obstacles that move by themselves: 0 by default.
    pub start: f64,
    /// What each line of an edge or a path takes, in seconds: 1 by default. Reported times are in
    /// this unit of time, and count from the beginning.
    pub duration: f64,
}

impl EdgeOptions {
    /// Any contact, with the default resolution.
    pub const fn any() -> Self {
        Self {
            first: false,
            resolution: 1e-6,
            start: 0.0,
            duration: 1.0,
        }
    }

    /// The first contact, with the default resolution.
    pub const fn first() -> Self {
        Self {
            first: true,
            ..Self::any()
        }
    }

    pub(crate) fn check(&self) -> Result<(), RobotError> {
        let (start, duration) = (self.start, self.duration);
        if start.abs() <= LARGEST && (0.0..=LARGEST).contains(&duration) {
            return Ok(());
        }
        let allowed = format!("allowed is {LARGEST:e}, the duration not negative");
        refuse(format!(
            "edge: start {start} s, duration {duration} s, {allowed}"
        ))
    }
}

/// The answer about a motion, which starts at time 0. Each line of an edge or a path takes
/// [`EdgeOptions::duration`], by default a time of 1. The times of a trajectory and a horizon are
/// in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Edge {
    /// Whether the motion is free.
    pub answer: EdgeAnswer,
    /// Proven: no contact before this time. The time of the end if all is free, the end included.
    pub free_until: f64,
    /// Proven: contact at this time; the earliest one found.
    pub touching_at: Option<f64>,
    /// The shapes that meet then.
    pub pair: Option<[ShapeId; 2]>,
}

/// The answer for an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeAnswer {
    /// Proven: no configuration of the edge collides.
    Free,
    /// Proven: a configuration of the edge collides, see [`Edge::touching_at`].
    Contact,
    /// Neither: the budget ended, or shapes come so near that no interval of the resolution can be
    /// proven free.
    Undecided,
}

named!(EdgeAnswer { Free => "free", Contact => "contact", Undecided => "undecided" });

/// A time of a path: the number of its line, and the share of that line.
type Time = (u32, f64);

/// A part of a line that is not proven, and the range in [`Run::pairs`] of the pairs still to be
/// proven on it.
#[derive(Clone, Copy, Debug)]
struct Interval {
    line: u32,
    ends: [f64; 2],
    pairs: [usize; 2],
}

/// A pair at the middle of an interval: the distance above its margin that would prove it on the
/// interval, and a lower bound of that distance from boxes.
#[derive(Clone, Copy, Debug)]
struct Kept {
    pair: u32,
    limit: f64,
    gap: f64,
    /// The most by which one shape is off a straight line, seen from the other, apart from its turn
    /// about its middle.
    bend: f64,
    /// The second shape at the beginning of the interval, seen from the first.
    start: Transform,
}

impl Kept {
    /// True if its motion is almost straight.
    fn glides(&self) -> bool {
        self.bend <= STRAIGHT * self.limit
    }
}

/// The next step at the middle of an interval.
#[derive(Clone, Copy, Debug)]
enum Phase {
    Place,
    Filter(usize),
    Distances(usize),
    Contacts(usize),
    Begin,
    End,
    Sweeps(usize),
}

/// A run along a path, which may be stopped at any step.
#[derive(Debug, Default)]
pub(crate) struct Run {
    pub is_stopped: bool,
    first: bool,
    resolution: f64,
    /// The time of the beginning.
    start: f64,
    pub lines: Trajectory,
    /// Where the proof begins, and where it may pause, in the time of the trajectory.
    from: Time,
    pub pause: f64,
    /// The configuration that was placed last.
    at: Vec<f64>,
    /// How the joint of each body moves in half of the current interval.
    moves: Vec<Move>,
    /// Half of its duration.
    half: f64,
    /// Number of probes done. Once the current probe is placed, the next pair to test, as an index
    /// into the order of pairs.
    probes: usize,
    cursor: Option<usize>,
    open: VecDeque<Interval>,
    now: Option<(Interval, Phase)>,
    kept: Vec<Kept>,
    /// The pairs of all intervals, in the order in which the intervals were made.
    pairs: Vec<u32>,
    touching: Option<(Time, u32)>,
    /// Start of the first interval that was given up.
    unproven: Option<Time>,
}

impl Run {
    /// Begins with the lines that are set, from a time of them on.
    pub fn begin(&mut self, options: EdgeOptions, from: f64) {
        (self.first, self.resolution) = (options.first, options.resolution.max(NARROWEST));
        self.start = options.start;
        (self.from, self.pause) = (self.lines.find(from), f64::INFINITY);
        (self.probes, self.cursor, self.now) = (0, None, None);
        (self.touching, self.unproven) = (None, None);
        self.open.clear();
        self.pairs.clear();
    }

    /// Continues until the question is answered or the budget ends.
    pub fn advance(&mut self, call: &mut Call<'_, '_>) -> Result<(), StopReason> {
        let end = self.probe(call).and_then(|()| self.halve_all(call));
        self.is_stopped = end.is_err() || self.now.is_some();
        end
    }

    fn put(&mut self, (line, share): Time, call: &mut Call<'_, '_>) -> Result<(), StopReason> {
        self.lines.put(line, share, &mut self.at);
        let piece = self.lines.pieces()[line as usize];
        let time = self.start + piece.begin + share * piece.seconds;
        call.put(&self.at, time)
    }

    /// Number of configurations that are tested before intervals.
    fn probe_count(&self) -> usize {
        if self.first { ENDS } else { PROBES.len() }
    }

    /// Tests whole configurations. Makes the first intervals, unless a contact answers the
    /// question.
    fn probe(&mut self, call: &mut Call<'_, '_>) -> Result<(), StopReason> {
        while self.probes < self.probe_count() {
            let count = self.lines.pieces().len() as u32;
            let time = PROBES[self.probes] * f64::from(count);
            let line = (time as u32).min(count - 1);
            let time = later((line, time - f64::from(line)), self.from);
            if self.cursor.is_none() {
                self.put(time, call)?;
            }
            let mut cursor = self.cursor.unwrap_or(0);
            let found = call.find(&mut cursor);
            self.cursor = Some(cursor);
            if let Some(pair) = found? {
                self.touching = Some((time, pair));
                if !self.first || time == self.from {
                    return Ok(());
                }
            }
            self.cursor = None;
            self.probes += 1;
            if self.probes == self.probe_count() {
                let order = call.order.pairs.iter().copied();
                self.pairs.extend(order.filter(|&pair| call.counts(pair)));
                let (first, share) = self.from;
                let whole = |line| Interval {
                    line,
                    ends: [if line == first { share } else { 0.0 }, 1.0],
                    pairs: [0, self.pairs.len()],
                };
                self.open.extend((first..count).map(whole));
            }
        }
        Ok(())
    }

    /// Takes intervals and queues the parts that are not proven, until no interval is open or a
    /// contact answers the question.
    fn halve_all(&mut self, call: &mut Call<'_, '_>) -> Result<(), StopReason> {
        let now = |run: &mut Self| run.now.or_else(|| Some((run.next()?, Phase::Place)));
        while let Some((interval, phase)) = now(self) {
            if self.lower_time((interval.line, interval.ends[0])) >= self.pause {
                self.now = Some((interval, phase));
                break;
            }
            self.halve(interval, phase, call)?;
            self.now = None;
            if self.touching.is_some() && !self.first {
                break;
            }
        }
        Ok(())
    }

    fn halve(
        &mut self,
        interval: Interval,
        mut phase: Phase,
        call: &mut Call<'_, '_>,
    ) -> Result<(), StopReason> {
        let (line, [low, high]) = (interval.line, interval.ends);
        let middle = 0.5 * (low + high);
        loop {
            self.now = Some((interval, phase));
            phase = match phase {
                Phase::Place => {
                    self.put((line, middle), call)?;
                    self.measure_moves(interval, call.world);
                    Phase::Filter(interval.pairs[0])
                }
                Phase::Filter(at) if at < interval.pairs[1] => {
                    self.filter(self.pairs[at], call)?;
                    Phase::Filter(at + 1)
                }
                Phase::Filter(_) => Phase::Distances(0),
                Phase::Distances(at) if at < self.kept.len() => {
                    let kept = self.kept[at];
                    if kept.gap <= APART * kept.limit && call.is_farther(kept.pair, kept.limit)? {
                        self.kept.remove(at);
                        Phase::Distances(at)
                    } else {
                        Phase::Distances(at + 1)
                    }
                }
                Phase::Distances(_) => Phase::Contacts(0),
                Phase::Contacts(at) if at < self.kept.len() => {
                    let Kept { pair, gap, .. } = self.kept[at];
                    if gap <= 0.0 && call.meets(pair, true)? {
                        self.touching = Some(((line, middle), pair));
                        self.leave([[low, middle]], line);
                        return Ok(());
                    }
                    Phase::Contacts(at + 1)
                }
                Phase::Contacts(_) if self.kept.iter().any(Kept::glides) => Phase::Begin,
                Phase::Contacts(_) => break,
                Phase::Begin => {
                    self.put((line, low), call)?;
                    for kept in &mut self.kept {
                        kept.start = call.pair(kept.pair).2;
                    }
                    Phase::End
                }
                Phase::End => {
                    self.put((line, high), call)?;
                    Phase::Sweeps(0)
                }
                Phase::Sweeps(at) if at < self.kept.len() => {
                    let kept = self.kept[at];
                    if kept.glides() && call.is_free(kept.pair, &kept.start, kept.bend)? {
                        self.kept.remove(at);
                        Phase::Sweeps(at)
                    } else {
                        Phase::Sweeps(at + 1)
                    }
                }
                Phase::Sweeps(_) => break,
            };
        }
        self.leave([[low, middle], [middle, high]], line);
        Ok(())
    }

    /// Queues the parts of a line on which the kept pairs are not proven.
    fn leave<const N: usize>(&mut self, mut parts: [[f64; 2]; N], line: u32) {
        if self.kept.is_empty() {
            return;
        }
        let begin = self.pairs.len();
        self.pairs.extend(self.kept.iter().map(|kept| kept.pair));
        let pairs = [begin, self.pairs.len()];
        if self.first {
            parts.reverse();
        }
        for ends in parts {
            let part = Interval { line, ends, pairs };
            let at = if self.first { 0 } else { self.open.len() };
            self.open.insert(at, part);
        }
    }

    /// The next interval worth halving.
    fn next(&mut self) -> Option<Interval> {
        loop {
            let interval = self.open.pop_front()?;
            let [low, high] = interval.ends;
            let begin = (interval.line, low);
            if self.first {
                // Drops the pairs of intervals that are done.
                self.pairs.truncate(interval.pairs[1]);
            }
            if self.touching.is_some_and(|(time, _)| begin >= time) {
                continue;
            }
            if high - low >= self.resolution {
                return Some(interval);
            }
            let unproven = self.unproven.get_or_insert(begin);
            *unproven = earlier(*unproven, begin);
        }
    }

    /// Computes the motion of the joints in half of an interval.
    fn measure_moves(&mut self, Interval { line, ends, .. }: Interval, world: &World) {
        let [half, middle] = [0.5 * (ends[1] - ends[0]), 0.5 * (ends[0] + ends[1])];
        let moves = |joint| self.lines.moves(line, joint, middle, half);
        let bodies = world.model.bodies.iter();
        self.moves.clear();
        self.moves
            .extend(bodies.map(|body| body.value.motion(moves)));
        self.half = half * self.lines.pieces()[line as usize].seconds;
        self.kept.clear();
    }

    /// Keeps a pair unless spheres or boxes prove it free on the interval.
    fn filter(&mut self, pair: u32, call: &mut Call<'_, '_>) -> Result<(), StopReason> {
        call.deadline.pay(SPHERE_WORK)?;
        let asked = &call.world.pairs[pair as usize];
        let placement = &mut call.room.placement;
        let limit = placement.reach(call.world, asked, &self.moves, self.half);
        let limit = limit + placement.slack;
        if placement.sphere_gap(asked) <= limit {
            call.deadline.spend(BOX_WORK);
            let (_, shapes, b_in_a) = call.pair(pair);
            let gap = call.room.placement.box_gap(asked, shapes, &b_in_a);
            if gap <= limit {
                let bend = call.room.placement.bend(asked);
                self.kept.push(Kept {
                    pair,
                    limit,
                    gap,
                    bend,
                    start: Transform::IDENTITY,
                });
            }
        }
        Ok(())
    }

    /// The answer so far.
    pub fn edge(&self, world: &World) -> Edge {
        let end = (self.lines.pieces().len() as u32 - 1, 1.0);
        let is_probed = self.probes == self.probe_count();
        let begun = if is_probed { end } else { self.from };
        let open = self.open.iter().chain(self.now.iter().map(|now| &now.0));
        let touching = self.touching.map(|(time, _)| time);
        let free_until = open
            .map(|interval| (interval.line, interval.ends[0]))
            .chain(touching)
            .chain(self.unproven)
            .fold(begun, earlier);
        let answer = match self.touching {
            Some(_) => EdgeAnswer::Contact,
            None if free_until == end => EdgeAnswer::Free,
            None => EdgeAnswer::Undecided,
        };
        Edge {
            answer,
            free_until: self.lower_time(free_until),
            touching_at: touching.map(|(line, share)| {
                let piece = self.lines.pieces()[line as usize];
                piece.begin + share * piece.seconds
            }),
            pair: self.touching.map(|(_, pair)| world.ids_of(pair)),
        }
    }

    /// A time in the unit of answers, rounded down, so that nothing is claimed that is not proven.
    fn lower_time(&self, (line, share): Time) -> f64 {
        let Piece { begin, seconds, .. } = self.lines.pieces()[line as usize];
        if share == 1.0 && line as usize + 1 == self.lines.pieces().len() {
            return begin + seconds;
        }
        let passed = share * seconds;
        let is_exact = seconds == 1.0 || share == 0.0;
        let passed = if is_exact {
            passed
        } else {
            passed.next_down().max(0.0)
        };
        let sum = begin + passed;
        let is_late = sum - begin > passed || begin < passed;
        if begin > 0.0 && is_late {
            sum.next_down()
        } else {
            sum
        }
    }
}

fn later(a: Time, b: Time) -> Time {
    if b > a { b } else { a }
}

fn earlier(a: Time, b: Time) -> Time {
    if b < a { b } else { a }
}

impl Checker {
    /// Decides whether the straight line in joint space between two configurations is free.
    ///
    /// **Guarantee.** A free edge is free at each of its configurations, ends included, not at
    /// samples. If the budget stops the call, the answer says how far the edge is proven free, and
    /// the call can be resumed ([`Checker::resume_edge`]). However budgets of work cut it, it ends
    /// with the same answer.
    ///
    /// The nearer shapes come to each other, the shorter are the intervals that can be proven, and
    /// the more of them are needed: about 1 / gap between two moving shapes, and 1 / sqrt(gap)
    /// along what stands still, or as few as the length needs where the motion is straight.
    ///
    /// # Errors
    /// [`RobotError::Length`], [`RobotError::JointValue`].
    pub fn edge<'c>(
        &mut self,
        from: &[f64],
        to: &[f64],
        options: &EdgeOptions,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Edge>, RobotError> {
        self.world.model.check(to)?;
        options.check()?;
        let call = self.begin(from, budget.into())?;
        Ok(call.edge(&[from, to], *options))
    }

    /// Decides whether a motion along polynomials of time is free, from [`EdgeOptions::start`] on,
    /// as [`Checker::path`] does for lines. The ends of all pieces count too; pieces need not join.
    ///
    /// # Errors
    /// [`RobotError::Length`] if it has another number of joints; [`RobotError::Model`] without a
    /// piece, and for times beyond [`LARGEST`].
    pub fn trajectory<'c>(
        &mut self,
        motion: &Trajectory,
        options: &EdgeOptions,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Edge>, RobotError> {
        options.check()?;
        self.world.model.check_motion(motion)?;
        self.sync(1);
        let call = self.call(budget.into());
        call.room.run.lines.copy(motion);
        call.room.run.begin(*options, 0.0);
        Ok(call.resume_edge())
    }

    /// Decides whether a path is free: the straight lines from each of its knots to the next one.
    /// `knots` holds one knot after the other. The path is tested like one edge, from coarse to
    /// fine along all of it. Times are rounded to f64; `free_until` downwards.
    ///
    /// # Errors
    /// Those of [`Checker::edge`], with the row; [`RobotError::Model`] for fewer than two knots.
    pub fn path<'c>(
        &mut self,
        knots: &[f64],
        options: &EdgeOptions,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Edge>, RobotError> {
        let (rows, width) = self.model().rows(knots)?;
        if rows < 2 {
            return refuse("a path of fewer than two configurations");
        }
        options.check()?;
        let call = self.begin(&knots[..width], budget.into())?;
        Ok(call.edge(&[knots], *options))
    }

    /// Continues the last edge, path or horizon, which its budget has stopped.
    ///
    /// # Errors
    /// [`RobotError::NothingToResume`] if it is done, or another question was asked or an obstacle
    /// changed since.
    pub fn resume_edge<'c>(
        &mut self,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Edge>, RobotError> {
        if self.room.run.is_stopped {
            Ok(self.call(budget.into()).resume_edge())
        } else {
            Err(RobotError::NothingToResume)
        }
    }
}

impl Call<'_, '_> {
    /// Asks about the straight lines between knots, at least two.
    pub fn edge(self, knots: &[&[f64]], options: EdgeOptions) -> Outcome<Edge> {
        let width = self.world.model.joint_names().len();
        let (all, run) = (knots[0], &mut self.room.run);
        let knot = |i: usize| match knots {
            [_] => &all[i * width..][..width],
            _ => knots[i],
        };
        let ends = if knots.len() == 1 {
            all.len() / width.max(1)
        } else {
            2
        };
        run.lines.clear();
        for line in 1..ends.max(2) {
            let [from, to] = [knot(line - 1), knot(line)];
            let ways = from.iter().zip(to).map(|(a, b)| b - a);
            run.lines
                .add(width, options.duration, from.iter().copied().chain(ways));
        }
        run.begin(options, 0.0);
        self.resume_edge()
    }

    pub fn resume_edge(mut self) -> Outcome<Edge> {
        let mut run = std::mem::take(&mut self.room.run);
        let end = run.advance(&mut self);
        let edge = run.edge(self.world);
        self.room.run = run;
        self.outcome(edge, end)
    }
}
