//! What one thread needs to answer: placed shapes, a workspace, and the queries of a pair.

use punctual::distance::{self, Distance};
use punctual::engine::{Ask, Deadline, Question};
use punctual::intersection::Intersection;
use punctual::{Answer, Budget, PairMemory, Query, StopReason, Verdict, Workspace};

use crate::clearance::Bounds;
use crate::order::{Asked, BOX_WORK, Fact};
use crate::placement::Placement;
use crate::shape::holds_part;
use crate::world::World;

/// Work of placing a body, and of the test of a pair's spheres, in units of a query's work.
const WORK_PER_BODY: u64 = 64;
const PAIRS_PER_WORK: usize = 8;

/// What one thread needs. Its content changes no answer.
#[derive(Debug, Default)]
pub(crate) struct Search {
    pub placement: Placement,
    workspace: Workspace,
    /// Room for the bounds of a clearance.
    pub bounds: Bounds,
    /// What was near or met at the configurations before, by pair, since the time in `stamps`.
    memory: Vec<PairMemory>,
    stamps: Vec<u64>,
    stamp: u64,
    /// Work of the current call, and the part of the current query's that is in it.
    pub work: u64,
    counted: u64,
    /// True if the workspace holds a stopped query that is to be resumed.
    pub is_stopped: bool,
}

impl Search {
    pub fn sync(&mut self, world: &World) {
        self.placement.sync(world);
        if self.memory.len() != world.pairs.len() {
            self.memory
                .resize_with(world.pairs.len(), PairMemory::without_clearance);
            self.stamps.resize(world.pairs.len(), 0);
        }
        self.stamp += 1;
    }

    /// Begins a call: nothing is remembered, and no work done.
    pub fn begin(&mut self) {
        self.stamp += 1;
        self.work = 0;
        self.is_stopped = false;
    }

    /// Places the robot. The error is the reason why the call must stop.
    pub fn put(
        &mut self,
        world: &World,
        configuration: &[f64],
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        let bodies = world.model.bodies.len() as u64 * WORK_PER_BODY;
        self.pay(
            bodies + (world.pairs.len() / PAIRS_PER_WORK) as u64,
            deadline,
        )?;
        self.placement.put(world, configuration);
        Ok(())
    }

    /// Pays for work outside of queries; an error if there is no room for it.
    pub fn pay(&mut self, work: u64, deadline: &mut Deadline) -> Result<(), StopReason> {
        // A budget of work may be exceeded by a step, so that each call makes progress; one of time
        // should not be.
        let need = if deadline.is_timed() { work } else { 1 };
        if !deadline.has_room(need) {
            return Err(deadline.why(need));
        }
        deadline.spend(work);
        self.work += work;
        Ok(())
    }

    /// Asks the pairs from `cursor` on until one meets. After an error the cursor is at the pair
    /// whose query was stopped.
    pub fn find(
        &mut self,
        world: &World,
        order: &[Asked],
        facts: &mut [Fact],
        cursor: &mut usize,
        deadline: &mut Deadline,
    ) -> Result<Option<u32>, StopReason> {
        while let Some(&Asked { pair, slot }) = order.get(*cursor) {
            if self.placement.is_near(slot) {
                let before = self.work;
                let met = self.meets(world, pair, false, deadline)?;
                facts[pair as usize].learn(met, self.work - before);
                if met {
                    return Ok(Some(pair));
                }
            }
            *cursor += 1;
        }
        Ok(None)
    }

    /// Whether the shapes of a pair meet. The memory is of earlier configurations of the same call.
    pub fn meets(
        &mut self,
        world: &World,
        pair: u32,
        with_memory: bool,
        deadline: &mut Deadline,
    ) -> Result<bool, StopReason> {
        let asked = &world.pairs[pair as usize];
        let [a, b] = [asked.a, asked.b].map(|i| world.shapes[i as usize].shape.inner());
        let b_in_a = self.placement.b_in_a(world, asked);
        if !self.is_stopped {
            self.pay(BOX_WORK, deadline)?;
            if self.placement.box_gap([a, b], &b_in_a) > 0.0 {
                return Ok(false);
            }
            if holds_part(a, b, &b_in_a) {
                return Ok(true);
            }
        }
        let pose = b_in_a.pose();
        if a.margin + b.margin > 0.0 {
            let query = Query::distance(&a.tree, &b.tree, pose)
                .margins([a.margin, b.margin])
                .closer_than(0.0);
            let answer = self.spend::<Distance>(&query, with_memory.then_some(pair), deadline)?;
            // What f64 cannot tell from touching counts as touching.
            return Ok(answer.value.closer != Some(false));
        }
        let query = Query::intersection(&a.tree, &b.tree, pose);
        let answer = self.spend::<Intersection>(&query, with_memory.then_some(pair), deadline)?;
        Ok(answer.value != Verdict::Separated)
    }

    /// Bounds of the distance of a pair, and whether they are final.
    pub fn distance(
        &mut self,
        world: &World,
        pair: u32,
        ask: impl for<'q> Fn(Query<'q, Distance>) -> Query<'q, Distance>,
        deadline: &mut Deadline,
    ) -> (distance::Bounds, Option<StopReason>) {
        let asked = &world.pairs[pair as usize];
        let [a, b] = [asked.a, asked.b].map(|i| world.shapes[i as usize].shape.inner());
        let pose = self.placement.b_in_a(world, asked).pose();
        let query = Query::distance(&a.tree, &b.tree, pose).margins([a.margin, b.margin]);
        let query = ask(query);
        let answer = self.run(&query, Some(pair), deadline);
        (answer.value, self.is_stopped.then_some(answer.stop))
    }

    fn spend<Q: Question>(
        &mut self,
        query: &Query<'_, Q>,
        memory: Option<u32>,
        deadline: &mut Deadline,
    ) -> Result<Answer<Q::Value>, StopReason>
    where
        for<'t> Query<'t, Q>: Ask<Q>,
    {
        let answer = self.run(query, memory, deadline);
        if self.is_stopped {
            return Err(answer.stop);
        }
        Ok(answer)
    }

    /// Runs a query, or goes on with it if it was stopped. Its plan does not depend on the budget,
    /// so that budgets of work may cut it anywhere.
    fn run<Q: Question>(
        &mut self,
        query: &Query<'_, Q>,
        memory: Option<u32>,
        deadline: &mut Deadline,
    ) -> Answer<Q::Value>
    where
        for<'t> Query<'t, Q>: Ask<Q>,
    {
        let mut memory = memory.map(|pair| {
            let pair = pair as usize;
            if self.stamps[pair] != self.stamp {
                self.stamps[pair] = self.stamp;
                self.memory[pair] = PairMemory::without_clearance();
            }
            &mut self.memory[pair]
        });
        let goes_on = self.is_stopped && query.is_stopped_in(&self.workspace);
        if !goes_on {
            self.counted = 0;
            query.begin(&mut self.workspace, memory.as_deref(), Budget::unlimited());
        }
        let answer = query.spend(&mut self.workspace, memory.take(), deadline);
        self.work += answer.stats.work - self.counted;
        self.counted = answer.stats.work;
        self.is_stopped = !answer.stop.is_final();
        answer
    }
}
