//! What is known of every pair of near bodies, in few bytes: a frame looks at all of them.

use crate::scene::body::Bodies;
use crate::scene::id::PairKey;
use crate::scene::pair::state::{FRAME, Marks, last_frame};
use core::num::NonZeroU32;

/// The place of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot(NonZeroU32);

impl Slot {
    /// `place` is below `u32::MAX`.
    pub fn new(place: usize) -> Self {
        Self(NonZeroU32::MIN.saturating_add(place as u32))
    }

    pub fn place(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// Two bodies whose fat AABBs overlap, and where their state is. The state of a pair that stays
/// apart is not read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub key: PairKey,
    /// None before the first turn of the pair since its boxes overlap.
    pub slot: Option<Slot>,
    /// [`OVERLAPS`], [`MET`], [`LOST`], and the low bits of a frame: the last that ran the pair to
    /// its end; before, the one before that since which its boxes overlap. All 0 if they are apart.
    bits: u32,
    /// Of a pair that met, the two triangles of [`Marks::Met`]; of others, the bits of the length
    /// of [`Marks::Apart`].
    proof: u64,
}

/// Of [`Known::bits`]: whether the boxes overlap, whether the bodies met when it was last decided,
/// whether their witnesses were lost since, and the frame.
const OVERLAPS: u32 = 1 << 31;
const MET: u32 = 1 << 30;
const LOST: u32 = 1 << 29;

const _: () = assert!(FRAME == LOST - 1 && size_of::<Known>() == 24);

impl Known {
    /// Of a pair whose boxes were not compared yet.
    pub fn new(key: PairKey) -> Self {
        Self {
            key,
            slot: None,
            bits: 0,
            proof: 0,
        }
    }

    /// Takes note of boxes that overlap from `frame` on.
    pub fn begin(&mut self, frame: u64) {
        self.bits = OVERLAPS | (frame as u32).wrapping_sub(1) & FRAME;
    }

    /// Takes note of boxes that are apart, and gives the state up.
    pub fn end(&mut self) -> Option<Slot> {
        let slot = self.slot;
        *self = Self::new(self.key);
        slot
    }

    /// Whether the boxes overlapped when they were last compared.
    pub fn overlaps(&self) -> bool {
        self.bits & OVERLAPS != 0
    }

    /// The frame in the bits, if that is not 2^29 frames before `frame`.
    pub fn since(&self, frame: u64) -> u64 {
        last_frame(self.bits, frame)
    }

    /// Takes note of what is known of the pair after its turn.
    pub fn mark(&mut self, marks: Marks) {
        match marks {
            Marks::Met {
                witness: [x, y],
                lost,
                completed,
            } => {
                self.bits = OVERLAPS | MET | if lost { LOST } else { 0 } | completed;
                self.proof = u64::from(x) << 32 | u64::from(y);
            }
            Marks::Apart {
                until,
                is_completed,
                completed,
            } => {
                if is_completed {
                    self.bits = OVERLAPS | completed;
                }
                self.proof = until.to_bits();
            }
        }
    }

    pub fn marks(&self) -> Marks {
        let completed = self.bits & FRAME;
        if self.met() {
            Marks::Met {
                witness: self.witness(),
                lost: self.is_lost(),
                completed,
            }
        } else {
            Marks::Apart {
                until: self.apart(),
                is_completed: true,
                completed,
            }
        }
    }

    /// Of a pair that did not meet, the length of [`Marks::Apart`].
    fn apart(&self) -> f64 {
        f64::from_bits(self.proof)
    }

    /// The triangles of a pair that met last.
    pub fn witness(&self) -> [u32; 2] {
        [(self.proof >> 32) as u32, self.proof as u32]
    }

    /// Takes note that the triangles that met last meet in `frame` too.
    pub fn hold(&mut self, frame: u64) {
        self.bits = OVERLAPS | MET | frame as u32 & FRAME;
    }

    /// Whether the bodies are known to be apart in `frame` since they have not gone far. If so,
    /// takes note of it.
    #[inline]
    pub fn stays_apart(&mut self, bodies: &Bodies, frame: u64) -> bool {
        let until = if self.met() { 0.0 } else { self.apart() };
        let stays = until > 0.0 && until > bodies.gone(self.key, self.since(frame), frame);
        if stays {
            self.bits = self.bits & !FRAME | frame as u32 & FRAME;
        }
        stays
    }

    /// Whether `frame` ran it to its end.
    pub fn is_completed(&self, frame: u64) -> bool {
        self.bits & FRAME == frame as u32 & FRAME
    }

    /// Whether it met when it was last decided.
    pub fn met(&self) -> bool {
        self.bits & MET != 0
    }

    /// Whether its witnesses were lost since then.
    pub fn is_lost(&self) -> bool {
        self.bits & LOST != 0
    }
}
