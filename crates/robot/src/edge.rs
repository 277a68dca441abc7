//! A straight line in joint space: proven free, in contact, or not known from some time on.
//!
//! The line is halved. At the middle of an interval each pair of shapes has a distance, and a rate
//! by which it can change ([`Placement::rate`](crate::placement::Placement::rate)). If the distance
//! exceeds what half of the interval can take, the pair is free on the whole of it. Otherwise both
//! halves ask the pair again. An open interval keeps the pairs that are not proven on it, so at
//! each moment all of the line is proven, known to be in contact, or covered by an open interval.
//!
//! For any contact, five configurations are asked first, and then wide intervals before narrow
//! ones. For the first contact, intervals are taken from left to right.

use std::collections::VecDeque;

use punctual::StopReason;
use punctual::clock::ClockedBudget;
use punctual::engine::Deadline;

use crate::checker::Outcome;
use crate::order::{Asked, BOX_WORK, Fact};
use crate::search::Search;
use crate::world::World;
use crate::{Checker, RobotError, ShapeId};

/// Where contacts are sought first: the whole line, from coarse to fine.
const PROBES: [f64; 5] = [0.0, 1.0, 0.5, 0.25, 0.75];
const ENDS: usize = 2;

/// Intervals are never narrower than this.
const NARROWEST: f64 = 1e-12;

/// What is asked of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EdgeOptions {
    /// Seek the first contact, not any. Off by default.
    pub first: bool,
    /// Intervals that are shorter than this share of the edge are given up: the first contact is
    /// told within it, and a gap that closes further stays undecided. By default 1e-6; at least
    /// 1e-12.
    pub resolution: f64,
}

impl Default for EdgeOptions {
    fn default() -> Self {
        Self {
            first: false,
            resolution: 1e-6,
        }
    }
}

impl EdgeOptions {
    /// Any contact, with the default resolution.
    pub fn any() -> Self {
        Self::default()
    }

    /// The first contact, with the default resolution.
    pub fn first() -> Self {
        Self {
            first: true,
            ..Self::default()
        }
    }
}

/// What is known of an edge. Times are shares of the edge: 0 at its start, 1 at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Edge {
    /// The answer.
    pub answer: EdgeAnswer,
    /// Proven: no contact before this time. 1 if the edge is free; then its end is free too.
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

impl EdgeAnswer {
    /// Name in files: `free`, `contact` or `undecided`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Contact => "contact",
            Self::Undecided => "undecided",
        }
    }
}

/// An interval that is not proven, and the list of the pairs to be proven on it.
#[derive(Clone, Copy, Debug)]
struct Interval {
    low: f64,
    high: f64,
    list: usize,
}

/// A pair at the middle of an interval: how near it may come, and whether boxes tell it apart.
#[derive(Clone, Copy, Debug)]
struct Kept {
    pair: u32,
    limit: f64,
    is_apart: bool,
}

/// What remains to be done at the middle of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Place,
    Filter,
    Contacts(usize),
    Distances(usize),
}

/// A run along an edge, which may be stopped at any step.
#[derive(Debug, Default)]
pub(crate) struct Run {
    is_stopped: bool,
    options: EdgeOptions,
    from: Vec<f64>,
    step: Vec<f64>,
    at: Vec<f64>,
    /// Speed of each body's joint, by the length of the edge.
    speeds: Vec<f64>,
    /// Probes done, and the place in the order of the one at hand, if it is placed.
    probes: usize,
    cursor: Option<usize>,
    open: VecDeque<Interval>,
    now: Option<(Interval, Phase)>,
    kept: Vec<Kept>,
    /// Lists of pairs, with the number of intervals that use each.
    lists: Vec<(u32, Vec<u32>)>,
    touching: Option<(f64, u32)>,
    /// Start of the first interval that was given up.
    unproven: f64,
}

/// Why a run ends before it is done, or that it is done with.
enum End {
    Stop(StopReason),
    Found,
}

impl From<StopReason> for End {
    fn from(stop: StopReason) -> Self {
        Self::Stop(stop)
    }
}

impl Run {
    /// A run that can no longer be resumed.
    pub fn forget(&mut self) {
        self.is_stopped = false;
    }

    pub fn begin(&mut self, world: &World, [from, to]: [&[f64]; 2], options: EdgeOptions) {
        self.options = options;
        self.options.resolution = options.resolution.max(NARROWEST);
        self.from.clear();
        self.from.extend_from_slice(from);
        self.step.clear();
        self.step.extend(from.iter().zip(to).map(|(a, b)| b - a));
        self.speeds.clear();
        let bodies = &world.model.bodies;
        let speed = |i: usize| {
            let way = self.step.get(bodies[i].value as usize).unwrap_or(&0.0);
            (bodies[i].multiplier * way).abs()
        };
        self.speeds.extend((0..bodies.len()).map(speed));
        (self.probes, self.cursor, self.now) = (0, None, None);
        (self.touching, self.unproven) = (None, f64::INFINITY);
        self.open.clear();
        for (users, list) in &mut self.lists {
            *users = 0;
            list.clear();
        }
    }

    /// Goes on until the question is answered or the budget ends.
    pub fn advance(
        &mut self,
        world: &World,
        order: &[Asked],
        facts: &mut [Fact],
        search: &mut Search,
        deadline: &mut Deadline,
    ) -> StopReason {
        let end = self.probe(world, order, facts, search, deadline);
        let end = end.and_then(|()| {
            while self.halve(world, search, deadline)? {}
            Ok(())
        });
        match end {
            Err(End::Stop(stop)) => {
                self.is_stopped = true;
                stop
            }
            Ok(()) | Err(End::Found) => {
                self.is_stopped = false;
                StopReason::Finished
            }
        }
    }

    fn put(
        &mut self,
        world: &World,
        time: f64,
        search: &mut Search,
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        self.at.clear();
        let values = self.from.iter().zip(&self.step);
        self.at
            .extend(values.map(|(from, step)| from + time * step));
        search.put(world, &self.at, deadline)
    }

    /// Whole configurations, and then the first interval.
    fn probe(
        &mut self,
        world: &World,
        order: &[Asked],
        facts: &mut [Fact],
        search: &mut Search,
        deadline: &mut Deadline,
    ) -> Result<(), End> {
        let probes = if self.options.first {
            ENDS
        } else {
            PROBES.len()
        };
        while self.probes < probes {
            let time = PROBES[self.probes];
            if self.cursor.is_none() {
                self.put(world, time, search, deadline)?;
            }
            let mut cursor = self.cursor.unwrap_or(0);
            let found = search.find(world, order, facts, &mut cursor, deadline);
            self.cursor = Some(cursor);
            if let Some(pair) = found? {
                self.touching = Some((time, pair));
                if !self.options.first || time == 0.0 {
                    return Err(End::Found);
                }
            }
            self.cursor = None;
            self.probes += 1;
            if self.probes == probes {
                let list = self.new_list();
                self.lists[list]
                    .1
                    .extend(order.iter().map(|asked| asked.pair));
                self.push([0.0, 1.0], list);
            }
        }
        Ok(())
    }

    /// Takes an interval, and leaves what is not proven of it. False if none is open.
    fn halve(
        &mut self,
        world: &World,
        search: &mut Search,
        deadline: &mut Deadline,
    ) -> Result<bool, End> {
        let (interval, mut phase) = match self.now {
            Some(now) => now,
            None => match self.next() {
                Some(interval) => (interval, Phase::Place),
                None => return Ok(false),
            },
        };
        self.now = Some((interval, phase));
        let Interval { low, high, list } = interval;
        let middle = 0.5 * (low + high);
        if phase == Phase::Place {
            self.put(world, middle, search, deadline)?;
            phase = Phase::Filter;
            self.now = Some((interval, phase));
        }
        if phase == Phase::Filter {
            self.filter(world, 0.5 * (high - low), list, search, deadline)?;
            phase = Phase::Contacts(0);
            self.now = Some((interval, phase));
        }
        if let Phase::Contacts(mut at) = phase {
            // The probes have found no contact.
            let is_known = !self.options.first && PROBES.contains(&middle);
            while at < self.kept.len() {
                let Kept { pair, is_apart, .. } = self.kept[at];
                self.now = Some((interval, Phase::Contacts(at)));
                if !is_apart && !is_known && search.meets(world, pair, true, deadline)? {
                    self.touching = Some((middle, pair));
                    if !self.options.first {
                        return Err(End::Found);
                    }
                    let rest = self.new_list();
                    let kept = self.kept.iter().map(|kept| kept.pair);
                    self.lists[rest].1.extend(kept);
                    self.push([low, middle], rest);
                    self.done(list);
                    return Ok(true);
                }
                at += 1;
            }
            phase = Phase::Distances(0);
        }
        if let Phase::Distances(mut at) = phase {
            while at < self.kept.len() {
                self.now = Some((interval, Phase::Distances(at)));
                let Kept { pair, limit, .. } = self.kept[at];
                let (bounds, stop) =
                    search.distance(world, pair, |query| query.closer_than(limit), deadline);
                if let Some(stop) = stop {
                    return Err(stop.into());
                }
                if bounds.closer == Some(false) {
                    self.kept.remove(at);
                } else {
                    at += 1;
                }
            }
        }
        if !self.kept.is_empty() {
            let rest = self.new_list();
            let kept = self.kept.iter().map(|kept| kept.pair);
            self.lists[rest].1.extend(kept);
            self.push([low, middle], rest);
            self.push([middle, high], rest);
            if self.options.first {
                // The left one is taken first.
                let at = self.open.len();
                self.open.swap(at - 2, at - 1);
            }
        }
        self.done(list);
        Ok(true)
    }

    /// The next interval worth halving.
    fn next(&mut self) -> Option<Interval> {
        loop {
            let interval = match self.options.first {
                true => self.open.pop_back()?,
                false => self.open.pop_front()?,
            };
            if self.touching.is_some_and(|(time, _)| interval.low >= time) {
                self.done(interval.list);
            } else if interval.high - interval.low < self.options.resolution {
                self.unproven = self.unproven.min(interval.low);
                self.done(interval.list);
            } else {
                return Some(interval);
            }
        }
    }

    /// Keeps the pairs that spheres and boxes do not prove free on an interval of this half length.
    fn filter(
        &mut self,
        world: &World,
        half: f64,
        list: usize,
        search: &mut Search,
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        self.kept.clear();
        search.pay(self.lists[list].1.len() as u64 * BOX_WORK, deadline)?;
        let placement = &mut search.placement;
        for &number in &self.lists[list].1 {
            let pair = &world.pairs[number as usize];
            let limit = placement.rate(world, pair, &self.speeds) * half + placement.slack;
            if placement.sphere_gap(pair) > limit {
                continue;
            }
            let shapes = [pair.a, pair.b].map(|i| world.shapes[i as usize].shape.inner());
            let b_in_a = placement.b_in_a(world, pair);
            let gap = placement.box_gap(shapes, &b_in_a);
            if gap > limit {
                continue;
            }
            self.kept.push(Kept {
                pair: number,
                limit,
                is_apart: gap > 0.0,
            });
        }
        Ok(())
    }

    fn push(&mut self, [low, high]: [f64; 2], list: usize) {
        self.lists[list].0 += 1;
        self.open.push_back(Interval { low, high, list });
    }

    fn new_list(&mut self) -> usize {
        let free = self.lists.iter().position(|(users, _)| *users == 0);
        let list = free.unwrap_or(self.lists.len());
        if free.is_none() {
            self.lists.push((0, Vec::new()));
        }
        self.lists[list].1.clear();
        list
    }

    fn done(&mut self, list: usize) {
        self.lists[list].0 -= 1;
        self.now = None;
    }

    /// What is known so far.
    pub fn edge(&self, world: &World) -> Edge {
        let probes = if self.options.first {
            ENDS
        } else {
            PROBES.len()
        };
        let open = self.open.iter().map(|interval| interval.low);
        let now = self.now.map(|(interval, _)| interval.low);
        let begun: f64 = if self.probes < probes { 0.0 } else { 1.0 };
        let free_until = open
            .chain(now)
            .chain(self.touching.map(|(time, _)| time))
            .fold(begun.min(self.unproven), f64::min);
        let answer = match self.touching {
            Some(_) => EdgeAnswer::Contact,
            None if free_until == 1.0 => EdgeAnswer::Free,
            None => EdgeAnswer::Undecided,
        };
        Edge {
            answer,
            free_until,
            touching_at: self.touching.map(|(time, _)| time),
            pair: self.touching.map(|(_, pair)| world.ids_of(pair)),
        }
    }
}

impl Checker {
    /// Whether the straight line in joint space between two configurations is free.
    ///
    /// **Guarantee.** A free edge is free at each of its configurations, ends included, not at
    /// samples. Stopped by its budget, it tells how far it is proven free, and can be resumed
    /// ([`Checker::resume_edge`]). However budgets of work cut it, it ends with the same answer.
    ///
    /// The nearer shapes come to each other, the shorter are the intervals that can be proven, and
    /// the more of them are needed.
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
        self.world.model.check(from)?;
        self.world.model.check(to)?;
        self.run.begin(&self.world, [from, to], *options);
        self.search.begin();
        Ok(self.spend(budget.into()))
    }

    /// Continues the last edge, which its budget has stopped.
    ///
    /// # Errors
    /// [`RobotError::NothingToResume`] if the edge is done, or another question was asked or an
    /// obstacle changed since.
    pub fn resume_edge<'c>(
        &mut self,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Edge>, RobotError> {
        if !self.run.is_stopped {
            return Err(RobotError::NothingToResume);
        }
        self.search.work = 0;
        Ok(self.spend(budget.into()))
    }

    fn spend(&mut self, budget: ClockedBudget<'_>) -> Outcome<Edge> {
        let Self {
            world,
            order,
            search,
            run,
            ..
        } = self;
        let outcome = search.along(world, &order.pairs, &mut order.facts, run, budget);
        // The order is part of a stopped run.
        if outcome.stop == StopReason::Finished {
            order.count(1);
        }
        outcome
    }
}

impl Search {
    /// Goes on with a run.
    pub fn along(
        &mut self,
        world: &World,
        order: &[Asked],
        facts: &mut [Fact],
        run: &mut Run,
        budget: ClockedBudget<'_>,
    ) -> Outcome<Edge> {
        let mut deadline = Deadline::of(budget);
        let stop = run.advance(world, order, facts, self, &mut deadline);
        self.outcome(run.edge(world), stop, &deadline)
    }
}
