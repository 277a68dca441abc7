//! A compact record of every pair of near bodies: a frame reads all of them.

use crate::body::{Bodies, triangle_ids};
use crate::id::PairKey;
use crate::pair::state::{NO_TRIANGLES, PairState};
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
    /// [`OVERLAPS`], [`MET`], [`LOST`], [`FICKLE`], and the low bits of a frame: the last that finished the
    /// pair, or, if none has, the one before its boxes overlapped. 0 if the boxes are separated.
    bits: u32,
    /// For a pair that met, the two triangles that intersected last (tree order). For others, the
    /// bits of [`Known::apart`].
    proof: u64,
}

/// Bits of [`Known::bits`]: the boxes overlap; the bodies met when last decided; their witnesses
/// were lost since; a search is expected to cost less than tests of witnesses that rarely hold. The
/// lower bits hold the frame.
const OVERLAPS: u32 = 1 << 31;
const MET: u32 = 1 << 30;
const LOST: u32 = 1 << 29;
const FICKLE: u32 = 1 << 28;
const FRAME: u32 = FICKLE - 1;

const _: () = assert!(size_of::<Known>() == 24);

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

    /// The frame in the bits, correct if it is less than 2^28 frames before `frame`.
    pub fn since(&self, frame: u64) -> u64 {
        frame - u64::from((frame as u32).wrapping_sub(self.bits) & FRAME)
    }

    /// Stores the summary of a state that was updated in `frame`.
    pub fn note(&mut self, state: &PairState, frame: u64) {
        let completed = OVERLAPS | state.completed as u32 & FRAME;
        if state.met() {
            let [x, y] = state.memory.witness(0).unwrap_or(NO_TRIANGLES);
            let lost = if state.is_lost(frame) { LOST } else { 0 };
            let fickle = if state.is_fickle() { FICKLE } else { 0 };
            self.bits = completed | MET | lost | fickle;
            self.proof = u64::from(x) << 32 | u64::from(y);
        } else {
            if state.completed > 0 {
                self.bits = completed;
            }
            self.proof = state.apart.to_bits();
        }
    }

    /// Updates the state with what the list has found since its last turn. `frame` is the current
    /// frame.
    #[inline]
    pub fn tell(&self, state: &mut PairState, bodies: &Bodies, frame: u64) {
        let since = self.since(frame);
        if !self.met() {
            if self.apart() > 0.0 {
                state.stayed_apart(since);
            }
        } else if since > state.decided {
            let pair = bodies.pair(self.key);
            let ids = pair.and_then(|pair| triangle_ids(pair, self.witness()));
            state.went_on_meeting(ids, since);
        }
    }

    /// For a pair that did not meet: the bodies are separated until the sum of their displacements
    /// reaches this; 0 proves nothing.
    fn apart(&self) -> f64 {
        f64::from_bits(self.proof)
    }

    /// The triangles of a pair that met last.
    pub fn witness(&self) -> [u32; 2] {
        [(self.proof >> 32) as u32, self.proof as u32]
    }

    /// Records that the triangles that met last also meet in `frame`.
    pub fn hold(&mut self, frame: u64) {
        self.bits = OVERLAPS | MET | self.bits & FICKLE | frame as u32 & FRAME;
    }

    /// How far the bodies may move before they may meet; negative if they have moved farther since
    /// they were proven apart. `None` if they were not when last decided, or nothing is known.
    #[inline]
    pub fn room(&self, bodies: &Bodies, frame: u64) -> Option<f64> {
        let until = if self.met() { 0.0 } else { self.apart() };
        (until > 0.0).then(|| until - bodies.gone(self.key, self.since(frame), frame))
    }

    /// True if the bodies are known to be separated in `frame` because they have not moved far.
    /// Then records it.
    #[inline]
    pub fn stays_apart(&mut self, bodies: &Bodies, frame: u64) -> bool {
        let stays = self.room(bodies, frame).is_some_and(|room| room > 0.0);
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

    /// True if a test of its witness is expected to cost more than it saves.
    pub fn is_fickle(&self) -> bool {
        self.bits & FICKLE != 0
    }

    /// True if its witnesses were lost since then.
    pub fn is_lost(&self) -> bool {
        self.bits & LOST != 0
    }
}
