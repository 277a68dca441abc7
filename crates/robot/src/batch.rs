//! Many configurations or edges, on several threads.
//!
//! The bits of the answers do not depend on the number of threads: the order of pairs stays the
//! same during a round, whose length depends on what was seen before, and what a round has learned
//! is a sum. Each question begins without memory of others.

use std::sync::Mutex;
use std::thread;

use punctual::Budget;

use crate::checker::Outcome;
use crate::edge::Run;
use crate::order::{Asked, Fact};
use crate::search::Search;
use crate::world::World;
use crate::{Checker, Clearance, ClearanceOptions, Collision, Edge, EdgeOptions, RobotError};

/// Questions that a thread takes at a time.
const BLOCK: usize = 16;

/// What one thread needs for batches.
#[derive(Debug, Default)]
pub(crate) struct Worker {
    search: Search,
    run: Run,
    facts: Vec<Fact>,
}

impl Checker {
    /// [`Checker::collide`] for configurations that lie one after the other, each within the
    /// budget, on so many threads. Under budgets of work the bits of the answers do not depend on
    /// their number.
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
        let (rows, width) = self.rows(configurations)?;
        Ok(self.batch(rows, threads, |world, order, worker, row| {
            let at = &configurations[row * width..][..width];
            let Worker { search, facts, .. } = worker;
            search.collide(world, order, facts, at, budget.into())
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
        let (rows, width) = self.rows(configurations)?;
        Ok(self.batch(rows, threads, |world, _, worker, row| {
            let at = &configurations[row * width..][..width];
            worker.search.clearance(world, at, options, budget.into())
        }))
    }

    /// [`Checker::edge`] for many edges, as [`Checker::collide_batch`]: edge `i` leads from row `i`
    /// of the one to row `i` of the other.
    ///
    /// # Errors
    /// Those of [`Checker::collide_batch`]; both must have the same number of rows.
    pub fn edge_batch(
        &mut self,
        from: &[f64],
        to: &[f64],
        options: &EdgeOptions,
        budget: Budget,
        threads: usize,
    ) -> Result<Vec<Outcome<Edge>>, RobotError> {
        let (rows, width) = self.rows(from)?;
        self.world.model.check_rows(to, rows)?;
        Ok(self.batch(rows, threads, |world, order, worker, row| {
            let ends = [from, to].map(|ends| &ends[row * width..][..width]);
            let Worker { search, run, facts } = worker;
            run.begin(world, ends, *options);
            search.begin();
            search.along(world, order, facts, run, budget.into())
        }))
    }

    fn rows(&self, configurations: &[f64]) -> Result<(usize, usize), RobotError> {
        let model = &self.world.model;
        let width = model.joint_names().len();
        let rows = configurations.len().checked_div(width).unwrap_or(0);
        let found = configurations.len() - rows * width;
        if found > 0 {
            return Err(RobotError::Length {
                expected: width,
                found,
            });
        }
        model.check_rows(configurations, rows)?;
        Ok((rows, width))
    }

    /// Asks in rounds, each as long as all before.
    fn batch<T: Send>(
        &mut self,
        rows: usize,
        threads: usize,
        ask: impl Fn(&World, &[Asked], &mut Worker, usize) -> T + Sync,
    ) -> Vec<T> {
        let Self {
            world,
            order,
            workers,
            run,
            ..
        } = self;
        run.forget();
        let threads = threads.clamp(1, rows.div_ceil(BLOCK).max(1));
        workers.resize_with(workers.len().max(threads), Worker::default);
        for worker in &mut workers[..threads] {
            worker.search.sync(world);
        }
        let mut answers: Vec<Option<T>> = Vec::new();
        answers.resize_with(rows, || None);
        let mut first = 0;
        while first < rows {
            let round = (order.until_due() as usize).min(rows - first);
            let pairs = &order.pairs;
            let blocks = answers[first..first + round].chunks_mut(BLOCK).enumerate();
            let blocks = Mutex::new(blocks);
            let work = |worker: &mut Worker| {
                worker.facts.clear();
                worker.facts.resize(world.pairs.len(), Fact::default());
                loop {
                    let next = blocks.lock().map(|mut blocks| blocks.next());
                    let Ok(Some((block, answers))) = next else {
                        break;
                    };
                    for (i, answer) in answers.iter_mut().enumerate() {
                        *answer = Some(ask(world, pairs, worker, first + block * BLOCK + i));
                    }
                }
            };
            let threads = threads.min(round.div_ceil(BLOCK));
            thread::scope(|scope| {
                let (own, others) = workers[..threads].split_at_mut(1);
                for worker in others {
                    scope.spawn(|| work(worker));
                }
                work(&mut own[0]);
            });
            for worker in &workers[..threads] {
                for (fact, learned) in order.facts.iter_mut().zip(&worker.facts) {
                    fact.add(learned);
                }
            }
            order.count(round as u64);
            first += round;
        }
        answers.into_iter().flatten().collect()
    }
}
