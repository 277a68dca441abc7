//! When pairs in doubt go through the filter in `f64`.

/// Fewer pairs in doubt are tested one by one.
const ENOUGH: usize = 4;

/// Whether to test pairs in doubt in `f64` before the exact test. Where surfaces lie in one plane
/// none is decided by it: after some such steps it rests for a while.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Refinement {
    /// Pairs decided less pairs left in doubt.
    score: i32,
    /// Steps for which it rests.
    rest: u32,
    /// So many pairs, the first of those in doubt, are in doubt in `f64` too.
    pub done: usize,
}

impl Refinement {
    const WORST: i32 = -32;
    const REST: u32 = 32;

    /// How many of the pairs in doubt are to be tested in `f64` now, `room` at most.
    pub fn due(&mut self, doubtful: usize, room: usize) -> usize {
        let count = (doubtful - self.done).min(room);
        if count < ENOUGH {
            return 0;
        }
        if self.rest > 0 {
            self.rest -= 1;
            self.done = doubtful;
            return 0;
        }
        count
    }

    pub fn learn(&mut self, decided: usize, left: usize) {
        self.done += left;
        self.score = (self.score + decided as i32 - left as i32).min(0);
        if self.score < Self::WORST {
            *self = Self {
                score: 0,
                rest: Self::REST,
                ..*self
            };
        }
    }
}
