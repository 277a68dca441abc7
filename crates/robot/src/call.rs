//! One call: what it asks about, what it has room in, and when it must stop.

use punctual::distance::{self, Distance};
use punctual::engine::{Ask, Deadline, Question};
use punctual::intersection::Intersection;
use punctual::{Motion, PairMemory, Query, StopReason, Verdict, Workspace};

use crate::checker::Outcome;
use crate::clearance::Bounds;
use crate::edge::Run;
use crate::order::{BOX_WORK, Fact, Sorted};
use crate::placement::Placement;
use crate::shape::{Inner, holds_part};
use crate::transform::{Transform, to_pose};
use crate::world::{Pair, World};

/// Work of placing a body, and of the test of a pair's spheres, in units of a query's work.
const WORK_PER_BODY: u64 = 64;
const PAIRS_PER_WORK: usize = 8;

/// The buffers of one thread. Their content changes no answer.
#[derive(Debug, Default)]
pub(crate) struct Room {
    pub placement: Placement,
    workspace: Workspace,
    /// Bounds of a clearance.
    pub bounds: Bounds,
    pub run: Run,
    /// The configuration at the end of a horizon.
    pub then: Vec<f64>,
    /// What was learned of the pairs in a round of a batch.
    pub facts: Vec<Fact>,
    /// Memory of each pair from earlier configurations. It is valid if its stamp is the current
    /// one.
    memory: Vec<(u64, PairMemory)>,
    stamp: u64,
    /// One bit for each pair that the spheres of the current configuration do not prove apart, in
    /// the order in which pairs are tested.
    near: Vec<u64>,
    is_listed: bool,
}

impl Room {
    /// Takes over what has changed in the world, and begins a call.
    pub fn sync(&mut self, world: &World) {
        self.placement.sync(world);
        let none = || (0, PairMemory::without_clearance());
        self.memory.resize_with(world.pairs.len(), none);
        self.begin();
    }

    /// Begins a call: nothing is remembered, and nothing can be resumed.
    pub fn begin(&mut self) {
        self.stamp += 1;
        self.is_listed = false;
        self.workspace.forget_run();
        self.run.is_stopped = false;
    }
}

pub(crate) struct Call<'c, 'k> {
    pub world: &'c World,
    pub order: &'c Sorted,
    pub facts: &'c mut [Fact],
    pub room: &'c mut Room,
    pub deadline: Deadline<'k>,
    /// The pairs that count.
    pub pairs: Counted,
}

/// Which pairs count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Counted {
    #[default]
    All,
    /// Those of shapes that move with the robot or stand still.
    Still,
    /// Those with obstacles that move by themselves.
    Timed,
}

impl<'c> Call<'c, '_> {
    pub fn outcome<T>(&mut self, value: T, end: Result<(), StopReason>) -> Outcome<T> {
        Outcome {
            value,
            stop: end.err().unwrap_or(StopReason::Finished),
            work: self.deadline.done(),
            elapsed: self.deadline.elapsed(),
        }
    }

    /// Places the robot, and obstacles that move by themselves at a time. The error is the reason
    /// why the call must stop.
    pub fn put(&mut self, configuration: &[f64], time: f64) -> Result<(), StopReason> {
        let bodies = self.world.model.bodies.len() as u64 * WORK_PER_BODY;
        let pairs = (self.world.pairs.len() / PAIRS_PER_WORK) as u64;
        self.deadline.pay(bodies + pairs)?;
        self.room.placement.put(self.world, configuration, time);
        self.room.is_listed = false;
        Ok(())
    }

    pub fn counts(&self, pair: u32) -> bool {
        let is_timed = self.world.pairs[pair as usize].is_timed;
        match self.pairs {
            Counted::All => true,
            Counted::Still => !is_timed,
            Counted::Timed => is_timed,
        }
    }

    /// Tests the pairs from `cursor` on until one meets. After an error the cursor is at the pair
    /// whose query was stopped.
    pub fn find(&mut self, cursor: &mut usize) -> Result<Option<u32>, StopReason> {
        let room = &mut *self.room;
        if !room.is_listed {
            room.near.clear();
            room.near.resize(self.order.pairs.len().div_ceil(64), 0);
            room.placement.list(&self.order.ranks, &mut room.near);
            room.is_listed = true;
        }
        while let Some(rank) = next_bit(&self.room.near, *cursor) {
            *cursor = rank;
            let pair = self.order.pairs[rank];
            if self.counts(pair) {
                let before = self.deadline.done();
                let met = self.meets(pair, false)?;
                self.facts[pair as usize].add(&Fact {
                    asked: 1,
                    met: u64::from(met),
                    work: self.deadline.done() - before,
                });
                if met {
                    return Ok(Some(pair));
                }
            }
            *cursor += 1;
        }
        Ok(None)
    }

    /// A pair, its shapes, and the pose of the second in the frame of the first.
    pub fn pair(&mut self, pair: u32) -> (&'c Pair, [&'c Inner; 2], Transform) {
        let pair = &self.world.pairs[pair as usize];
        let shapes = [pair.a, pair.b].map(|i| self.world.shapes[i as usize].shape.inner());
        (pair, shapes, self.room.placement.b_in_a(self.world, pair))
    }

    /// Decides whether the shapes of a pair are within their margin. The memory is of earlier
    /// configurations of the same call.
    pub fn meets(&mut self, pair: u32, with_memory: bool) -> Result<bool, StopReason> {
        let (of, [a, b], b_in_a) = self.pair(pair);
        let margin = self.room.placement.margin(of);
        // Boxes that overlap by more than the margin mostly hold surfaces that intersect, which is
        // decided in less time than the distance.
        let mut may_intersect = margin == 0.0;
        // Many samples cost more than most queries.
        let are_few = a.samples.are_few() && b.samples.are_few();
        if !self.room.workspace.is_stopped() {
            self.deadline.pay(BOX_WORK)?;
            let gap = self.room.placement.box_gap(of, [a, b], &b_in_a);
            if gap > 0.0 {
                return Ok(false);
            }
            if are_few && self.holds_part([a, b], &b_in_a) {
                return Ok(true);
            }
            may_intersect |= gap < -2.0 * margin;
        }
        let memory = with_memory.then_some(pair);
        let pose = to_pose(&b_in_a);
        let mut met = false;
        let intersects = may_intersect && a.tree.radius() + b.tree.radius() == 0.0;
        if intersects {
            let query = Query::<Intersection>::intersection(&a.tree, &b.tree, pose);
            let (verdict, end) = self.run(&query, memory);
            end?;
            met = verdict != Verdict::Separated;
        }
        if !(met || intersects && margin == 0.0) {
            let query = Query::distance(&a.tree, &b.tree, pose);
            let (bounds, end) = self.run(&query.closer_than(margin), memory);
            end?;
            // If f64 cannot tell a pair from one at the margin, it counts as within it.
            met = bounds.closer != Some(false);
        }
        Ok(met || !are_few && self.holds_part([a, b], &b_in_a))
    }

    /// Bounds of the distance of a pair's surfaces, final unless the call must stop.
    pub fn distance(
        &mut self,
        pair: u32,
        ask: impl for<'q> Fn(Query<'q, Distance>) -> Query<'q, Distance>,
    ) -> (distance::Bounds, Result<(), StopReason>) {
        let (_, [a, b], b_in_a) = self.pair(pair);
        let query = Query::distance(&a.tree, &b.tree, to_pose(&b_in_a));
        self.run(&ask(query), Some(pair))
    }

    /// [`holds_part`]; its tests count as work.
    pub fn holds_part(&mut self, [a, b]: [&Inner; 2], b_in_a: &Transform) -> bool {
        let mut tests = 0;
        let holds = holds_part(a, b, b_in_a, &mut tests);
        self.deadline.spend(tests * BOX_WORK);
        holds
    }

    /// Decides whether the distance of a pair's surfaces exceeds their margin by more than `left`.
    pub fn is_farther(&mut self, pair: u32, left: f64) -> Result<bool, StopReason> {
        let of = &self.world.pairs[pair as usize];
        let limit = self.room.placement.margin(of) + left;
        let (bounds, end) = self.distance(pair, |query| query.closer_than(limit));
        end.map(|()| bounds.closer == Some(false))
    }

    /// Decides whether a pair stays farther apart than its margin plus `bend` while the second
    /// shape moves from a pose to its present one, seen from the first. Its middle moves along a
    /// straight line, and it turns at a constant rate. False if that is not proven.
    pub fn is_free(&mut self, pair: u32, start: &Transform, bend: f64) -> Result<bool, StopReason> {
        let (of, [a, b], end) = self.pair(pair);
        let margin = self.room.placement.margin(of);
        let slack = 4.0 * self.room.placement.slack;
        let Ok(screw) = Motion::screw(to_pose(start), to_pose(&end)) else {
            return Ok(false);
        };
        let [from, to] = [start, &end].map(|pose| pose.transform_point3(b.centre));
        // An eighth of the acceleration of a turning point, as in `Placement::bend`.
        let bend = bend + screw.turn().length_squared() * b.radius / 8.0 + slack;
        let Ok(motion) = Motion::turning(to_pose(start), to - from, screw.turn(), from) else {
            return Ok(false);
        };
        let query = Query::impact(&a.tree, &b.tree, motion);
        let query = query.margins([margin + bend, 0.0]).time_tolerance(1.0);
        let (found, end) = self.run(&query, None);
        end.map(|()| found.lower == 1.0 && found.upper.is_none())
    }

    /// Runs a query of surfaces, or resumes it if it was stopped.
    fn run<Q: Question>(
        &mut self,
        query: &Query<'_, Q>,
        memory: Option<u32>,
    ) -> (Q::Value, Result<(), StopReason>)
    where
        for<'t> Query<'t, Q>: Ask<Q>,
    {
        let room = &mut *self.room;
        let memory = memory.map(|pair| {
            let (stamp, memory) = &mut room.memory[pair as usize];
            if *stamp != room.stamp {
                (*stamp, *memory) = (room.stamp, PairMemory::without_clearance());
            }
            memory
        });
        let (answer, _) = query.go_on(&mut room.workspace, memory, &mut self.deadline);
        let end = answer.stop.is_final().then_some(());
        (answer.value, end.ok_or(answer.stop))
    }
}

/// The first bit that is set, from one on.
fn next_bit(words: &[u64], from: usize) -> Option<usize> {
    let first = words.get(from / 64)? >> (from % 64);
    if first != 0 {
        return Some(from + first.trailing_zeros() as usize);
    }
    let next = from / 64 + 1;
    let at = words[next..].iter().position(|&word| word != 0)? + next;
    Some(at * 64 + words[at].trailing_zeros() as usize)
}
