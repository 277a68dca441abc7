//! Capacity of the buffers of a scene.

use alloc::vec::Vec;

/// Number of pairs that buffers have room for. Buffers of a scene grow together and rarely, so that
/// growth soon ends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Room {
    pub pairs: usize,
    /// The room that the user requested.
    pub asked: usize,
}

impl Room {
    /// Grows to twice the use, if that exceeds the room, or nearly does while the scene is `young`.
    pub fn grow(&mut self, used: usize, young: bool) {
        if used > self.pairs || young && used > self.asked.max(self.pairs / 4 * 3) {
            self.pairs = 2 * used + 64;
        }
    }

    /// Grows to the room that the user requests.
    pub fn ask(&mut self, pairs: usize) {
        (self.pairs, self.asked) = (self.pairs.max(pairs), self.asked.max(pairs));
    }
}

/// Reserves room for `most` elements.
pub(super) fn reserve<T>(buffer: &mut Vec<T>, most: usize) {
    buffer.reserve_exact(most.saturating_sub(buffer.len()));
}
