//! What is known of every pair of near bodies, in few bytes: a frame looks at all of them.

use crate::scene::id::PairKey;

/// The slot of a pair whose boxes are apart, and of one whose boxes overlap but that had no turn yet.
pub(crate) const APART: u32 = u32::MAX;
pub(crate) const BLANK: u32 = u32::MAX - 1;

/// Two bodies whose fat AABBs overlap, and where their state is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub key: PairKey,
    pub slot: u32,
    /// The low bits of the frame since which their boxes overlap, [`MET`] and [`LOST`].
    since: u32,
}

/// Of [`Known::since`]: whether they met when it was last decided, whether their witnesses were lost since, and the frame.
const MET: u32 = 1 << 31;
const LOST: u32 = 1 << 30;
const FRAME: u32 = LOST - 1;

const _: () = assert!(size_of::<Known>() == 16);

impl Known {
    /// Of a pair whose boxes were not compared yet.
    pub fn new(key: PairKey) -> Self {
        Self { key, slot: APART, since: 0 }
    }

    /// Takes note of boxes that overlap from `frame` on.
    pub fn begin(&mut self, frame: u64) {
        (self.slot, self.since) = (BLANK, frame as u32 & FRAME);
    }

    /// The frame since which they do, if that is not 2^30 frames before `frame`.
    pub fn since(&self, frame: u64) -> u64 {
        frame - u64::from((frame as u32).wrapping_sub(self.since) & FRAME)
    }

    /// Takes note of whether the bodies met when it was last decided, and their witnesses were lost since.
    pub fn mark(&mut self, [met, lost]: [bool; 2]) {
        self.since = self.since & FRAME | if met { MET } else { 0 } | if lost { LOST } else { 0 };
    }

    /// Whether a query of it was ever begun since their boxes overlap.
    pub fn is_begun(&self) -> bool {
        self.slot < BLANK
    }

    /// Whether it met when it was last decided.
    pub fn met(&self) -> bool {
        self.is_begun() && self.since & MET != 0
    }

    /// Whether its witnesses were lost since then.
    pub fn is_lost(&self) -> bool {
        self.is_begun() && self.since & LOST != 0
    }
}
