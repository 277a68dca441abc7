//! Bodies that wait for a step of the broad phase.

use alloc::collections::VecDeque;

/// One in this many is taken from the unimportant bodies, so that none waits for ever.
const TURNS: u32 = 4;

/// Two queues, first in, first out: of bodies without importance, then of those with an importance
/// above 0, which go first.
#[derive(Clone, Debug, Default)]
pub(super) struct Waiting {
    queues: [VecDeque<u32>; 2],
    turn: u32,
}

impl Waiting {
    pub fn reserve(&mut self, bodies: usize) {
        for queue in &mut self.queues {
            queue.reserve_exact(bodies.saturating_sub(queue.len()));
        }
    }

    pub fn len(&self) -> usize {
        self.queues.iter().map(VecDeque::len).sum()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn push(&mut self, body: u32, importance: f32) {
        self.queues[usize::from(importance > 0.0)].push_back(body);
    }

    /// The waiting bodies, in no particular order.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.queues.iter().flatten().copied()
    }

    pub fn pop(&mut self) -> Option<u32> {
        self.turn = (self.turn + 1) % TURNS;
        let first = usize::from(self.turn != 0);
        let body = self.queues[first].pop_front();
        body.or_else(|| self.queues[1 - first].pop_front())
    }
}
