//! Bodies that wait for a step of the broad phase.

use super::room::reserve_queue;
use alloc::collections::VecDeque;

/// One in this many is taken from the unimportant bodies, so that none waits for ever.
const TURNS: u32 = 4;

/// Two queues, first in, first out: bodies with an importance above 0, which go first, and the
/// others.
#[derive(Clone, Debug, Default)]
pub(super) struct Waiting {
    important: VecDeque<u32>,
    others: VecDeque<u32>,
    turn: u32,
}

impl Waiting {
    pub fn reserve(&mut self, bodies: usize) {
        reserve_queue(&mut self.important, bodies);
        reserve_queue(&mut self.others, bodies);
    }

    pub fn is_empty(&self) -> bool {
        self.important.is_empty() && self.others.is_empty()
    }

    pub fn push(&mut self, body: u32, importance: f32) {
        if importance > 0.0 {
            &mut self.important
        } else {
            &mut self.others
        }
        .push_back(body);
    }

    /// The waiting bodies, in no particular order.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.important.iter().chain(&self.others).copied()
    }

    pub fn pop(&mut self) -> Option<u32> {
        self.turn = (self.turn + 1) % TURNS;
        let [first, then] = match self.turn {
            0 => [&mut self.others, &mut self.important],
            _ => [&mut self.important, &mut self.others],
        };
        first.pop_front().or_else(|| then.pop_front())
    }
}
