//! What is known of every pair of near bodies, in few bytes: a frame looks at all of them.

use crate::model::cost::WORK_PER_GLANCE;
use crate::query::Verdict;
use crate::scene::body::Bodies;
use crate::scene::id::PairKey;
use crate::scene::pair::state::{FRAME, Marks, PairState, Proof, last_frame};

/// The slot of a pair whose boxes are apart, of one whose boxes overlap but that had no turn yet, and of one that needs no state
/// either: a glance has found it apart, and nothing else is known of it.
pub(crate) const APART: u32 = u32::MAX;
pub(crate) const BLANK: u32 = u32::MAX - 1;
pub(crate) const GLANCED: u32 = u32::MAX - 2;

/// Two bodies whose fat AABBs overlap, and where their state is. The state of a pair that stays apart is not read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub key: PairKey,
    pub slot: u32,
    /// [`MET`], [`LOST`], and the low bits of a frame: of a pair that had no turn, that since which their boxes overlap; of others,
    /// the last in which it was known whether they meet.
    bits: u32,
    proof: Proof,
}

/// Of [`Known::bits`]: whether they met when it was last decided, whether their witnesses were lost since, and the frame.
const MET: u32 = 1 << 31;
const LOST: u32 = 1 << 30;

const _: () = assert!(FRAME == LOST - 1 && size_of::<Known>() == 24);

impl Known {
    /// Of a pair whose boxes were not compared yet.
    pub fn new(key: PairKey) -> Self {
        Self {
            key,
            slot: APART,
            bits: 0,
            proof: Proof::default(),
        }
    }

    /// Takes note of boxes that overlap from `frame` on.
    pub fn begin(&mut self, frame: u64) {
        (self.slot, self.bits, self.proof) = (BLANK, frame as u32 & FRAME, Proof::default());
    }

    /// The frame in the bits, if that is not 2^30 frames before `frame`.
    pub fn since(&self, frame: u64) -> u64 {
        last_frame(self.bits, frame)
    }

    /// Takes note of what is known of the pair after its turn.
    pub fn mark(
        &mut self,
        Marks {
            met,
            lost,
            completed,
            proof,
            ..
        }: Marks,
    ) {
        self.bits = completed | if met { MET } else { 0 } | if lost { LOST } else { 0 };
        self.proof = proof;
    }

    pub fn marks(&self) -> Marks {
        let (blank, met, lost) = (!self.is_begun(), self.met(), self.is_lost());
        Marks {
            blank,
            met,
            lost,
            completed: self.bits & FRAME,
            proof: self.proof,
        }
    }

    /// The triangles of a pair that met last.
    pub fn witness(&self) -> [u32; 2] {
        self.proof.witness()
    }

    /// If above 0, the bodies are apart until the ways of both add up to this.
    fn apart(&self) -> f64 {
        if self.bits & MET != 0 {
            0.0
        } else {
            self.proof.apart()
        }
    }

    /// Takes note that the triangles that met last meet in `frame` too.
    pub fn hold(&mut self, frame: u64) {
        self.bits = MET | frame as u32 & FRAME;
    }

    /// Whether the bodies are known to be apart in `frame` since they have not gone far. If so, takes note of it.
    #[inline]
    pub fn stays_apart(&mut self, bodies: &Bodies, frame: u64) -> bool {
        let apart = self.apart();
        let stays = apart > 0.0 && apart > bodies.gone(self.key, self.since(frame), frame);
        if stays {
            self.bits = self.bits & !FRAME | frame as u32 & FRAME;
        }
        stays
    }

    /// Tells a state that knows nothing what a glance found, if one did. `frame` is the one at hand.
    pub fn tell_blank(&self, state: &mut PairState, frame: u64) {
        let since = self.since(frame);
        state.apart = self.apart();
        (state.verdict, state.search, state.completed, state.decided) = match self.slot {
            GLANCED => (Verdict::Separated, WORK_PER_GLANCE as u32, since, since),
            _ => (Verdict::Undecided, 0, 0, since - 1),
        };
    }

    /// Whether it was ever looked at since their boxes overlap.
    pub fn is_begun(&self) -> bool {
        self.slot < BLANK
    }

    /// Whether `frame` ran it to its end.
    pub fn is_completed(&self, frame: u64) -> bool {
        self.is_begun() && self.bits & FRAME == frame as u32 & FRAME
    }

    /// Whether it met when it was last decided.
    pub fn met(&self) -> bool {
        self.is_begun() && self.bits & MET != 0
    }

    /// Whether its witnesses were lost since then.
    pub fn is_lost(&self) -> bool {
        self.is_begun() && self.bits & LOST != 0
    }
}
