//! Decides when pairs in doubt go through the filter in `f64`.

/// Fewer pairs in doubt than this are tested one by one.
const ENOUGH: usize = 4;

/// Decides whether to test pairs in doubt in `f64` before the exact test. If surfaces lie in one
/// plane, that filter decides no pair: after some such steps it pauses for a while.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Refinement {
    /// Number of pairs decided minus pairs left in doubt.
    score: i32,
    /// Steps left of the pause.
    rest: u32,
    /// This many pairs, the first of those in doubt, are in doubt in `f64` too.
    pub done: usize,
}

impl Refinement {
    const WORST: i32 = -32;
    const REST: u32 = 32;

    /// Number of pairs in doubt to test in `f64` now, at most `room`.
    pub fn due(&mut self, uncertain: usize, room: usize) -> usize {
        let count = (uncertain - self.done).min(room);
        if count < ENOUGH {
            return 0;
        }
        if self.rest > 0 {
            self.rest -= 1;
            self.done = uncertain;
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
