//! A compact record of every pair of near bodies: a frame reads all of them.

use crate::body::Bodies;
use crate::id::PairKey;
use crate::pair::state::{FRAME, Marks, last_frame};
use core::num::NonZeroU32;

/// The index of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot(NonZeroU32);

impl Slot {
    /// `place` must be below `u32::MAX`.
    pub fn new(place: usize) -> Self {
        Self(NonZeroU32::MIN.saturating_add(place as u32))
    }

    pub fn place(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// Two bodies whose fat AABBs overlap, and the index of their state. The state of a pair that stays
/// separated is not read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub key: PairKey,
    /// `None` before the first turn of the pair since its boxes overlap.
    pub slot: Option<Slot>,
    /// [`OVERLAPS`], [`MET`], [`LOST`], and the low bits of the last frame that finished the pair;
    /// before that, of the frame before its boxes overlapped. 0 if the boxes are separated.
    bits: u32,
    /// For a pair that met, the two triangles of [`Marks::Met`]; for others, the bits of the length
    /// of [`Marks::Apart`].
    proof: u64,
}

/// Bits of [`Known::bits`]: the boxes overlap; the bodies met when last decided; their witnesses
/// were lost since. The lower bits hold the frame.
const OVERLAPS: u32 = 1 << 31;
const MET: u32 = 1 << 30;
const LOST: u32 = 1 << 29;

const _: () = assert!(FRAME == LOST - 1 && size_of::<Known>() == 24);

impl Known {
    /// A pair whose boxes were not compared yet.
    pub fn new(key: PairKey) -> Self {
        Self {
            key,
            slot: None,
            bits: 0,
            proof: 0,
        }
    }

    /// Records that the boxes overlap from `frame` on.
    pub fn begin(&mut self, frame: u64) {
        self.bits = OVERLAPS | (frame as u32).wrapping_sub(1) & FRAME;
    }

    /// Records that the boxes are separated, and returns the state's slot.
    pub fn end(&mut self) -> Option<Slot> {
        let slot = self.slot;
        *self = Self::new(self.key);
        slot
    }

    /// True if the boxes overlapped when last compared.
    pub fn overlaps(&self) -> bool {
        self.bits & OVERLAPS != 0
    }

    /// The frame in the bits, unless it is 2^29 or more frames before `frame`.
    pub fn since(&self, frame: u64) -> u64 {
        last_frame(self.bits, frame)
    }

    /// Stores the summary of the pair after its turn.
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

    /// The length of [`Marks::Apart`], for a pair that did not meet.
    fn apart(&self) -> f64 {
        f64::from_bits(self.proof)
    }

    /// The triangles of a pair that met last.
    pub fn witness(&self) -> [u32; 2] {
        [(self.proof >> 32) as u32, self.proof as u32]
    }

    /// Records that the triangles that met last also meet in `frame`.
    pub fn hold(&mut self, frame: u64) {
        self.bits = OVERLAPS | MET | frame as u32 & FRAME;
    }

    /// How far the bodies may move before they may meet; 0 if nothing is proven.
    #[inline]
    pub fn room(&self, bodies: &Bodies, frame: u64) -> f64 {
        let until = if self.met() { 0.0 } else { self.apart() };
        if until > 0.0 {
            (until - bodies.gone(self.key, self.since(frame), frame)).max(0.0)
        } else {
            0.0
        }
    }

    /// True if the bodies are known to be separated in `frame` because they have not moved far.
    /// Then records it.
    #[inline]
    pub fn stays_apart(&mut self, bodies: &Bodies, frame: u64) -> bool {
        let stays = self.room(bodies, frame) > 0.0;
        if stays {
            self.bits = self.bits & !FRAME | frame as u32 & FRAME;
        }
        stays
    }

    /// True if `frame` finished the pair.
    pub fn is_completed(&self, frame: u64) -> bool {
        self.bits & FRAME == frame as u32 & FRAME
    }

    /// True if the pair met when last decided.
    pub fn met(&self) -> bool {
        self.bits & MET != 0
    }

    /// True if its witnesses were lost since then.
    pub fn is_lost(&self) -> bool {
        self.bits & LOST != 0
    }
}
