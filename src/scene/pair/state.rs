//! What is kept about two bodies from the first turn of their pair on, while their boxes overlap.

use super::bounds::Bounds;
use super::question::Answer;
use super::spent::{Spent, capped};
use super::touch::Touch;
use crate::model::calibration::Calibration;
use crate::query::parting::Parting;
use crate::query::{PairMemory, Verdict};
use crate::scene::ask::TurnKind;
use crate::scene::body::{Bodies, triangle_ids};
use crate::scene::id::PairKey;
use alloc::boxed::Box;
use arrayvec::ArrayVec;

/// Most estimates of a pair that are kept until their truth comes out.
const TOLD: usize = 8;

/// Tests over which the steadiness of a pair is averaged, and what it is before the first.
const TESTS_OF_STEADINESS: f32 = 8.0;
const USUAL_STEADINESS: f32 = 0.5;

/// A witness that no two trees have.
pub(crate) const NO_TRIANGLES: [u32; 2] = [u32::MAX; 2];

/// After so many tests nothing is left of what was before.
const MOST_TESTS: u64 = 64;

/// What was said of a pair, besides verdicts.
#[derive(Clone, Debug)]
pub(crate) enum Said {
    /// Probabilities that estimates told of the bodies as they are, until their truth comes out.
    Estimates(ArrayVec<f64, TOLD>),
    /// What was proven last of its distance or motion, and in which frame.
    Bounds(Bounds, u64),
}

/// What is known of a pair in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// What the frame found; [`Verdict::Undecided`] if it did not decide it.
    pub verdict: Verdict,
    pub found: u64,
    /// Whether the frame ran it to its end.
    pub complete: bool,
    /// Expected share of what is to be found.
    pub recall: f64,
}

/// The turn of a pair in a batch. All that is needed to deal and to collect it is here: its state
/// is out of cache by then, or in that of another core.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    pub state: Box<PairState>,
    pub key: PairKey,
    /// The place of its job among those of the frame.
    pub index: u32,
    /// Work that it is expected to take.
    pub median: u32,
    pub kind: TurnKind,
    /// Whether a body has moved, and its state does not know.
    pub is_new: bool,
    /// What is left to ask after it.
    pub next: Option<TurnKind>,
    /// Whether probabilities were reported whose truth is known now.
    pub teaches: bool,
    pub spent: Spent,
    /// What came of it.
    pub standing: Standing,
    pub marks: Marks,
}

/// The bits of a frame's number that are kept with each pair.
pub(crate) const FRAME: u32 = (1 << 29) - 1;

/// The last frame until `frame` whose kept bits are these.
pub(crate) fn last_frame(bits: u32, frame: u64) -> u64 {
    frame - u64::from((frame as u32).wrapping_sub(bits) & FRAME)
}

/// What is known of a pair before and after its turn, for the list of pairs: what it was when it
/// was last decided, its proof, and the last frame that ran it to its end, its bits in [`FRAME`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Marks {
    /// Two triangles met (tree order), which may have been lost since.
    Met {
        witness: [u32; 2],
        lost: bool,
        completed: u32,
    },
    /// The bodies are apart until the ways of both add up to this length; 0 proves nothing. Maybe
    /// no frame ran it to its end.
    Apart {
        until: f64,
        is_completed: bool,
        completed: u32,
    },
}

const _: () = assert!(size_of::<Marks>() == 16);

impl Marks {
    /// Tells the state of the pair what the list has found out since its last turn, now being
    /// `frame`.
    #[inline]
    pub fn tell(&self, key: PairKey, state: &mut PairState, bodies: &Bodies, frame: u64) {
        match *self {
            Self::Apart {
                until, completed, ..
            } if until > 0.0 => {
                state.stayed_apart(last_frame(completed, frame));
            }
            Self::Met {
                witness, completed, ..
            } => {
                let since = last_frame(completed, frame);
                if since > state.decided {
                    let ids = bodies
                        .pair(key)
                        .and_then(|pair| triangle_ids(pair, witness));
                    state.went_on_meeting(ids, since);
                }
            }
            Self::Apart { .. } => {}
        }
    }
}

impl Turn {
    /// Of a pair about which nothing is to be asked yet.
    pub fn new(key: PairKey, state: Box<PairState>, marks: Marks) -> Self {
        let standing = Standing {
            verdict: Verdict::Undecided,
            found: 0,
            complete: false,
            recall: 0.0,
        };
        let (kind, spent) = (TurnKind::Meet, Spent::default());
        let (is_new, teaches, next) = (false, false, None);
        Self {
            state,
            key,
            index: 0,
            median: 0,
            kind,
            is_new,
            next,
            teaches,
            spent,
            standing,
            marks,
        }
    }

    /// Takes note of what came of it in `frame`.
    #[inline]
    pub fn end(&mut self, frame: u64) {
        let state = &self.state;
        (self.standing, self.marks) = (state.standing(frame), state.marks(frame));
    }

    /// Ends the turn of a question in `frame`: says what is to be asked next.
    #[inline]
    pub fn end_question(&mut self, bodies: &Bodies, frame: u64) {
        self.end(frame);
        let Self {
            state,
            key,
            standing,
            ..
        } = self;
        self.teaches = standing.verdict != Verdict::Undecided && state.has_told();
        if standing.verdict == Verdict::Separated
            && let Some(touch) = &mut state.touch
        {
            touch.separate(frame);
        }
        let asks_contacts = bodies.contact_requests.any()
            && bodies.contact_requests.has(*key)
            && !state.knows_contacts(bodies.last_change(*key));
        self.next = match self.kind {
            TurnKind::Contacts if asks_contacts => Some(TurnKind::Contacts),
            TurnKind::Contacts if !standing.complete => Some(TurnKind::Meet),
            kind if !standing.complete => Some(kind),
            _ if asks_contacts && standing.verdict != Verdict::Separated => {
                Some(TurnKind::Contacts)
            }
            _ => None,
        };
    }

    /// Whether the question of this turn, or its contacts after it, are still to be answered.
    pub fn is_due(&self) -> bool {
        self.next == Some(TurnKind::Contacts)
            || self.next.is_some() && self.kind != TurnKind::Contacts
    }
}

/// What is kept about two bodies as long as their boxes overlap.
#[derive(Clone, Debug)]
pub(crate) struct PairState {
    pub memory: PairMemory,
    /// What the last frame that decided it found.
    pub verdict: Verdict,
    pub found: u64,
    /// The last frame that ran it to its end; 0 if none did.
    pub completed: u64,
    /// The last frame that decided it; before, the one before the first.
    pub decided: u64,
    /// The last frame, its low bits, in which its last witnesses were tested and did not meet.
    pub refuted: u32,
    /// Which part of the tests of its last witnesses found that they still met, a mean that fades.
    pub steadiness: f32,
    /// How much more often than elsewhere in the scene what lies next to a lost witness met, a mean
    /// that fades.
    pub nearby: f32,
    /// Work of the last run that no remembered witness cut short; a lower bound while that run is
    /// unfinished.
    pub search: u32,
    /// What the run that is not at its end has spent.
    pub pending: Spent,
    pub said: Said,
    /// The bodies are apart until the ways of both add up to this; 0: that is not known.
    pub apart: f64,
    /// The frame, its low bits, before which no proof is tried that they are apart by some
    /// distance; 0: any may.
    pub proves_from: u16,
    /// The plane that parted them last; how often in a row none did, and how many turns begin
    /// without another.
    pub parting: Parting,
    pub in_vain: u8,
    pub without_planes: u8,
    /// Where they touch, if that was ever asked.
    pub touch: Option<Box<Touch>>,
}

impl PairState {
    /// Of a pair of which nothing is known; `before`: the frame before that since which its boxes
    /// overlap.
    pub fn new(before: u64) -> Self {
        Self {
            memory: PairMemory::without_clearance(),
            verdict: Verdict::Undecided,
            found: 0,
            completed: 0,
            decided: before,
            refuted: 0,
            steadiness: USUAL_STEADINESS,
            nearby: 0.0,
            search: 0,
            pending: Spent::default(),
            said: Said::Estimates(ArrayVec::new()),
            apart: 0.0,
            proves_from: 0,
            parting: Parting::default(),
            in_vain: 0,
            without_planes: 0,
            touch: None,
        }
    }

    /// Whether, in `frame`, its last witnesses did not meet when they were last tested, and no
    /// others are known.
    #[inline]
    pub fn is_lost(&self, frame: u64) -> bool {
        u64::from((frame as u32).wrapping_sub(self.refuted)) < frame - self.decided
    }

    /// Whether it met when it was last decided.
    #[inline]
    pub fn met(&self) -> bool {
        self.verdict.meets()
    }

    /// What the list of pairs is told of it in `frame`.
    pub fn marks(&self, frame: u64) -> Marks {
        let completed = self.completed as u32 & FRAME;
        if self.met() {
            Marks::Met {
                witness: self.memory.witness(0).unwrap_or(NO_TRIANGLES),
                lost: self.is_lost(frame),
                completed,
            }
        } else {
            Marks::Apart {
                until: self.apart,
                is_completed: self.completed > 0,
                completed,
            }
        }
    }

    /// Takes note of bodies that are apart until the ways of both add up to `until`; not at all, if
    /// that is negative.
    pub fn note_apart(&mut self, until: f64) {
        (self.apart, self.proves_from) = (until.max(0.0), 0);
    }

    /// Takes note of bodies that were known to be apart until `frame`, since they had not gone far.
    pub fn stayed_apart(&mut self, frame: u64) {
        (self.completed, self.decided) = (self.completed.max(frame), self.decided.max(frame));
    }

    /// Takes note of triangles that went on meeting until `frame`, as tests found in the frames
    /// since it was decided.
    #[cold]
    pub fn went_on_meeting(&mut self, witness: Option<[u32; 2]>, frame: u64) {
        for _ in self.decided.max(frame.saturating_sub(MOST_TESTS)) + 1..frame {
            self.learn_steadiness(1.0);
        }
        if witness.is_some() {
            self.note_test(witness, frame);
        }
    }

    /// What is known of it in `frame`.
    pub fn standing(&self, frame: u64) -> Standing {
        let verdict = if self.decided == frame {
            self.verdict
        } else {
            Verdict::Undecided
        };
        let complete = self.completed == frame;
        let recall = match complete {
            true => 1.0,
            false if verdict.meets() => self.share_done(),
            false => 0.0,
        };
        Standing {
            verdict,
            found: self.found,
            complete,
            recall,
        }
    }

    /// The share of the expected work of its run that is done: above 0, at most 1/2.
    #[cold]
    fn share_done(&self) -> f64 {
        // Twice what an unfinished run has spent is expected at least.
        self.pending.work.max(1) as f64
            / f64::from(self.search.max(2)).max(2.0 * self.pending.work as f64)
    }

    /// Whether the contacts of bodies that were last new in `changed` are known.
    pub fn knows_contacts(&self, changed: u64) -> bool {
        self.touch
            .as_ref()
            .is_some_and(|touch| touch.completed >= changed)
    }

    /// Keeps a probability that was reported, if there is room.
    pub fn tell(&mut self, probability: f64) {
        match &mut self.said {
            Said::Estimates(told) => {
                let _ = told.try_push(probability);
            }
            said @ Said::Bounds(..) => *said = Said::Estimates([probability].into_iter().collect()),
        }
    }

    /// Whether probabilities were reported whose truth is not known yet.
    fn has_told(&self) -> bool {
        matches!(&self.said, Said::Estimates(told) if !told.is_empty())
    }

    /// Forgets the probabilities of bodies that have moved since, and a search for contacts that
    /// was cut short.
    #[inline]
    pub fn forget_told(&mut self) {
        if let Said::Estimates(told) = &mut self.said {
            told.clear();
        }
        if let Some(touch) = &mut self.touch {
            touch.pending = Spent::default();
        }
    }

    /// Corrects the calibration by what was reported of the pair, which is decided now.
    pub fn teach(&mut self, calibration: &mut Calibration) {
        if let Said::Estimates(told) = &mut self.said {
            let met = self.verdict != Verdict::Separated;
            told.drain(..).for_each(|told| calibration.learn(told, met));
        }
    }

    /// Takes note of a test of its last witnesses in `frame`: which of them still meets.
    pub fn note_test(&mut self, witness: Option<[u32; 2]>, frame: u64) {
        self.learn_steadiness(if witness.is_some() { 1.0 } else { 0.0 });
        let Some(witness) = witness else {
            self.refuted = frame as u32;
            return;
        };
        (self.completed, self.pending) = (frame, Spent::default());
        self.decide(Verdict::Intersecting { witness }, 1, frame);
    }

    fn learn_steadiness(&mut self, held: f32) {
        self.steadiness += (held - self.steadiness) / TESTS_OF_STEADINESS;
    }

    /// Takes note of bounds that are proven in `frame`.
    #[cold]
    pub fn note_bounds(&mut self, key: PairKey, bodies: &Bodies, bounds: Bounds, frame: u64) {
        let bounds = Bounds {
            gone: bodies.gone_at_least(key),
            ..bounds
        };
        let bounds = match self.said {
            Said::Bounds(before, _) if before.are_times != bounds.are_times => bounds,
            Said::Bounds(before, since) if since >= bodies.last_change(key) => before.and(bounds),
            Said::Bounds(before, since) if !bounds.are_times => {
                // A run that is cut may know less than is left of what was proven before.
                let carried = bodies.carried(key, before, since, frame);
                Bounds {
                    low: bounds.low.max(carried.low).min(bounds.high),
                    ..bounds
                }
            }
            _ => bounds,
        };
        self.said = Said::Bounds(bounds, frame);
    }

    /// What was proven last, times or lengths, and in which frame.
    pub fn bounds(&self, are_times: bool) -> Option<(Bounds, u64)> {
        match self.said {
            Said::Bounds(bounds, frame) if bounds.are_times == are_times => Some((bounds, frame)),
            _ => None,
        }
    }

    /// How soon a contact was proven in the last motion: 1 at once, 0 at its end.
    pub fn urgency(&self) -> Option<f32> {
        self.bounds(true)
            .filter(|(bounds, _)| bounds.high <= 1.0)
            .map(|(bounds, _)| 1.0 - bounds.low as f32)
    }

    /// Takes note of what `frame` has found out.
    pub fn decide(&mut self, verdict: Verdict, found: u64, frame: u64) {
        (self.decided, self.verdict, self.found) = (frame, verdict, found);
    }

    /// Takes note of the answer of a call in `frame`, and of what the run has spent; whether it is
    /// over.
    pub fn note(&mut self, answer: &Answer, spent: Spent, frame: u64) -> bool {
        let is_final = answer.stop.is_final();
        if is_final {
            (self.completed, self.pending) = (frame, Spent::default());
            if spent.bv_tests > 0 {
                self.search = capped(spent.work);
            }
        } else {
            self.search = self.search.max(capped(2 * spent.work));
            self.pending = spent;
        }
        if answer.verdict != Verdict::Undecided {
            self.decide(answer.verdict, answer.found, frame);
        } else if is_final {
            // A distance that equals the margins as far as numbers tell.
            self.verdict = Verdict::Undecided;
        }
        is_final
    }
}
