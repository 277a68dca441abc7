//! Assigns tasks to batches, and takes them back.

use super::pairs::Pairs;
use super::task::Task;
use crate::ask::TurnKind;
use crate::cost::LEAST_WORK;
use crate::pair::batch::Batch;
use crate::pair::frame::Frame;
use crate::report::Report;
use alloc::vec::Vec;
use punctual::Verdict;

/// Number of batches under a budget of work, on any number of threads. The first is that of the
/// round robin.
pub(crate) const BATCHES: usize = 16;

/// Number of turns that a batch has room for, with this many pairs. The first may get all.
pub(crate) fn room(batch: usize, pairs: usize) -> usize {
    let part = match batch {
        0 => 1,
        1 | 2 => 8,
        _ => BATCHES,
    };
    pairs.div_ceil(part) + 1
}

/// Under a budget of work, a batch has at least this much: about 20 us.
const BATCH_WORK: u64 = 1 << 16;

/// Otherwise, on several threads, one batch for each `PART_WORK` units of work, because handing it
/// to a thread takes a tenth of that; and at least `LEAST_PARTS` batches.
const PART_WORK: u64 = 1 << 12;
const LEAST_PARTS: u64 = 8;

/// The usual share of the round robin is the remaining budget divided by this. With less, important
/// tasks that are assigned to it are more often not reached.
const ROUND_ROBIN: u64 = 4;

/// The tasks of a round, and the batches that receive them.
pub(crate) struct Assignment<'s> {
    pub tasks: &'s mut [Task],
    pub batches: &'s mut [Batch],
    pub pairs: &'s mut Pairs,
    pub frame: &'s Frame<'s>,
    /// Buffer: sort keys and indices of tasks.
    pub order: &'s mut Vec<(u64, u32)>,
    /// The task whose turn it is.
    pub first_turn: usize,
    /// Overhead of a task, as work that a query could do in that time; 0 without a budget of time.
    pub overhead: u64,
}

impl Assignment<'_> {
    /// Expected cost of all open tasks.
    pub fn expected(&self) -> u64 {
        let open = self.tasks.iter().filter(|task| task.open);
        open.map(|task| u64::from(task.median) + self.overhead)
            .sum()
    }

    /// Assigns the tasks with a stopped run before the others, whose runs would take their places.
    pub fn stopped(&mut self) {
        for index in 0..self.tasks.len() {
            if self.tasks[index].open && self.tasks[index].home.is_some() {
                self.assign(index, 0);
            }
        }
    }

    /// Assigns all tasks in the order of their turns, in blocks of equal expected cost.
    pub fn all(&mut self, [left, reserve, expected]: [u64; 3], timed: bool, threads: usize) {
        let free = timed || left == u64::MAX;
        let blocks = match threads {
            _ if !free => (left / BATCH_WORK).clamp(1, BATCHES as u64),
            1 => BATCHES as u64,
            _ => (expected / PART_WORK).clamp(LEAST_PARTS, BATCHES as u64),
        };
        let block = expected / blocks + 1;
        self.turns(u64::MAX, |before| (before / block) as usize);
        for (batch, index) in self.batches.iter_mut().zip(0..) {
            let own: u64 = batch.turns.iter().map(|turn| u64::from(turn.median)).sum();
            let share = u128::from(left - reserve) * u128::from(own) / u128::from(expected.max(1));
            let share = share as u64 + if index == 0 { reserve } else { 0 };
            batch.budget = if free { u64::MAX } else { share };
            batch.looks_ahead = index > 0 || left == u64::MAX;
        }
    }

    /// Fills the batch of the round robin, then assigns the rest by importance and hit probability
    /// per cost. `timed` is the number of threads under a budget of time.
    pub fn shares(&mut self, [left, reserve]: [u64; 2], timed: Option<usize>) {
        let turns = reserve.max(left / ROUND_ROBIN);
        // The others could do nothing with less.
        let turns = if left - turns < LEAST_WORK {
            left
        } else {
            turns
        };
        // Some tasks take far more than their medians. Tasks that are not reached would have to
        // wait, however important.
        self.turns(turns / 2, |_| 0);
        (self.batches[0].budget, self.batches[0].looks_ahead) = (turns, false);

        let others = match timed {
            Some(threads) => threads.clamp(1, BATCHES - 1),
            None => (left / BATCH_WORK).clamp(1, BATCHES as u64 - 1) as usize,
        };
        // Expected costs may be too high, so twice as many tasks as fit are assigned.
        let ready = 2 * (left - turns);
        self.order_by_rank(ready);
        let mut before = 0;
        for assigned in 0..self.order.len() {
            before += self.assign(self.order[assigned].1 as usize, 1 + assigned % others);
            if before >= ready {
                break;
            }
        }
        let others = &mut self.batches[1..];
        let busy = others
            .iter()
            .filter(|batch| !batch.turns.is_empty())
            .count()
            .max(1) as u64;
        for batch in others {
            batch.budget = if timed.is_some() {
                u64::MAX
            } else {
                (left - turns) / busy
            };
            batch.looks_ahead = true;
        }
    }

    /// Sorts the open tasks by rank, as far as `work` suffices.
    fn order_by_rank(&mut self, work: u64) {
        self.order.clear();
        let (mut expected, mut counted) = (0, 0);
        for (task, index) in self.tasks.iter().zip(0..).filter(|(task, _)| task.open) {
            // Contact tasks cost many times as much as others, and are rarely the first.
            if task.kind != TurnKind::Contacts {
                expected += u64::from(task.median) + self.overhead;
                counted += 1;
            }
            self.order.push((task.rank, index));
        }
        let mean = expected / counted.max(1);
        let enough = usize::try_from(2 * work / mean.max(1)).unwrap_or(usize::MAX);
        if enough < self.order.len() {
            self.order.select_nth_unstable(enough);
            self.order.truncate(enough);
        }
        self.order.sort_unstable();
    }

    /// Assigns open tasks in the order of their turns until `work` is expected to be spent. `batch`
    /// returns the batch for a task from the expected work before it.
    fn turns(&mut self, work: u64, batch: impl Fn(u64) -> usize) {
        let mut before = 0;
        // By key, from the cursor on and around.
        for at in (self.first_turn..self.tasks.len()).chain(0..self.first_turn) {
            if before >= work {
                break;
            }
            if self.tasks[at].open {
                before += self.assign(at, batch(before));
            }
        }
    }

    /// Puts a task into the batch that holds its stopped run, or else into `batch`. If that is
    /// full, the task waits for the next round. Returns the expected work, including overhead.
    fn assign(&mut self, index: usize, batch: usize) -> u64 {
        let task = &mut self.tasks[index];
        let batch = &mut self.batches[task.home.take().map_or(batch, usize::from)];
        if batch.is_full() {
            return 0;
        }
        batch
            .turns
            .push(task.assign(index as u32, self.pairs, self.frame));
        u64::from(task.median) + self.overhead
    }
}

/// Takes tasks back from a batch and reports their results. Returns the number of finished tasks.
pub(crate) fn take_back(
    batch: &mut Batch,
    tasks: &mut [Task],
    frame: &Frame,
    pairs: &mut Pairs,
    report: &mut Report,
) -> usize {
    let mut ended = 0;
    for turn in batch.turns.drain(..) {
        let task = &mut tasks[turn.index as usize];
        task.teaches |= turn.teaches;
        task.open = turn.next.is_some();
        ended += usize::from(!task.open);
        let is_begun = turn.spent.work > 0;
        if let Some(next) = turn.next.filter(|&next| is_begun || next != task.kind) {
            task.ask(next, frame, &turn);
        }
        report.note(task.listed as usize, turn.standing, turn.spent);
        let mut state = turn.state;
        if turn.standing.verdict == Verdict::Separated
            && let Some(touch) = state.touch.take()
        {
            pairs.touches.take_back(touch);
        }
        pairs.put_back(task.place as usize, state, turn.known);
    }
    ended
}
