//! Room in the buffers of a scene.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

/// How many pairs buffers are made for. Those of a scene grow together, and seldom, so that they
/// are done with it soon.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Room {
    pub pairs: usize,
    /// What the user asked for.
    pub asked: usize,
}

impl Room {
    /// Twice what is in use, if that is more than there is room for, or nearly so while the scene
    /// is `young`.
    pub fn grow(&mut self, used: usize, young: bool) {
        if used > self.pairs || young && used > self.asked.max(self.pairs / 4 * 3) {
            self.pairs = 2 * used + 64;
        }
    }

    /// Enough for what the user asks for.
    pub fn ask(&mut self, pairs: usize) {
        (self.pairs, self.asked) = (self.pairs.max(pairs), self.asked.max(pairs));
    }
}

/// Makes room for `most` elements.
pub(super) fn reserve<T>(buffer: &mut Vec<T>, most: usize) {
    buffer.reserve_exact(most.saturating_sub(buffer.len()));
}

/// The same for a queue.
pub(super) fn reserve_queue<T>(queue: &mut VecDeque<T>, most: usize) {
    queue.reserve_exact(most.saturating_sub(queue.len()));
}
