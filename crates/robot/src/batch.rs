//! Many configurations or edges, on several threads.
//!
//! The bits of the answers do not depend on the number of threads. The order of pairs stays the
//! same during a round. The length of a round depends only on the number of configurations before
//! it. What a round learns is a sum. Each question begins without memory of others.

use std::sync::Mutex;
use std::thread;

use punctual::Budget;
use punctual::engine::Deadline;

use crate::call::{Call, Counted, Room};
use crate::checker::Outcome;
use crate::error::refuse;
use crate::order::Fact;
use crate::{Checker, Clearance, ClearanceOptions, Collision, Edge, EdgeOptions, RobotError};

/// Questions that a thread takes at a time.
const BLOCK: usize = 16;

impl Checker {
    /// [`Checker::collide`] for configurations that lie one after the other, on this many threads.
    /// Each has the budget for itself. Under budgets of work the bits of the answers do not depend
    /// on the number of threads.
    ///
    /// # Errors
    /// [`RobotError::Length`] unless the number of values is a multiple of the joints',
    /// [`RobotError::JointValue`] with the row.
    pub fn collide_batch(
        &mut self,
        configurations: &[f64],
        budget: Budget,
        threads: usize,
    ) -> Result<Vec<Outcome<Collision>>, RobotError> {
        let (rows, width) = self.model().rows(configurations)?;
        Ok(self.batch(rows, budget, threads, |call, row| {
            call.collide(&configurations[row * width..][..width])
        }))
    }

    /// [`Checker::clearance`] for many configurations, as [`Checker::collide_batch`].
    ///
    /// # Errors
    /// Those of [`Checker::collide_batch`].
    pub fn clearance_batch(
        &mut self,
        configurations: &[f64],
        options: &ClearanceOptions,
        budget: Budget,
        threads: usize,
    ) -> Result<Vec<Outcome<Clearance>>, RobotError> {
        let (rows, width) = self.model().rows(configurations)?;
        Ok(self.batch(rows, budget, threads, |call, row| {
            call.clearance(&configurations[row * width..][..width], options)
        }))
    }

    /// [`Checker::edge`] for many edges, as [`Checker::collide_batch`]: edge `i` leads from row `i`
    /// of the one to row `i` of the other.
    ///
    /// # Errors
    /// Those of [`Checker::collide_batch`]; [`RobotError::Model`] unless both have the same number
    /// of rows.
    pub fn edge_batch(
        &mut self,
        from: &[f64],
        to: &[f64],
        options: &EdgeOptions,
        budget: Budget,
        threads: usize,
    ) -> Result<Vec<Outcome<Edge>>, RobotError> {
        options.check()?;
        let (rows, width) = self.model().rows(from)?;
        let ends = self.model().rows(to)?.0;
        if ends != rows {
            return refuse(format!("edges from {rows} configurations to {ends}"));
        }
        Ok(self.batch(rows, budget, threads, |call, row| {
            let ends = [from, to].map(|ends| &ends[row * width..][..width]);
            call.edge(&ends, *options)
        }))
    }

    /// Works in rounds, each as long as all rounds before it together, within limits.
    pub(crate) fn batch<T: Send>(
        &mut self,
        rows: usize,
        budget: Budget,
        threads: usize,
        ask: impl Fn(Call<'_, '_>, usize) -> T + Sync,
    ) -> Vec<T> {
        self.room.begin();
        let (world, order, rooms) = (&self.world, &mut self.order, &mut self.rooms);
        let threads = threads.clamp(1, rows.div_ceil(BLOCK).max(1));
        rooms.resize_with(rooms.len().max(threads), Room::default);
        let rooms = &mut rooms[..threads];
        rooms.iter_mut().for_each(|room| room.sync(world));
        order.count(0, world);
        let mut answers: Vec<Option<T>> = Vec::new();
        answers.resize_with(rows, || None);
        let mut first = 0;
        while first < rows {
            let round = (order.until_due() as usize).min(rows - first);
            let blocks = answers[first..first + round].chunks_mut(BLOCK).enumerate();
            let blocks = Mutex::new(blocks);
            let work = |room: &mut Room| {
                let mut facts = std::mem::take(&mut room.facts);
                facts.clear();
                facts.resize(world.pairs.len(), Fact::default());
                let next = || blocks.lock().ok()?.next();
                while let Some((block, answers)) = next() {
                    for (row, answer) in (first + block * BLOCK..).zip(answers) {
                        room.begin();
                        let call = Call {
                            world,
                            order: &order.sorted,
                            facts: &mut facts,
                            room,
                            deadline: Deadline::of(budget.into()),
                            pairs: Counted::All,
                        };
                        *answer = Some(ask(call, row));
                    }
                }
                room.facts = facts;
            };
            thread::scope(|scope| {
                let threads = threads.min(round.div_ceil(BLOCK));
                let (own, others) = rooms[..threads].split_at_mut(1);
                for room in others {
                    scope.spawn(|| work(room));
                }
                work(&mut own[0]);
            });
            for room in &mut *rooms {
                for (fact, learned) in order.facts.iter_mut().zip(room.facts.drain(..)) {
                    fact.add(&learned);
                }
            }
            order.count(round as u64, world);
            first += round;
        }
        answers.into_iter().flatten().collect()
    }
}
