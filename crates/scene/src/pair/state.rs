//! The state of a pair of bodies, kept from its first turn on while their boxes overlap.

use super::apart::STRETCH;
use super::bounds::{Bounds, Proof, Times};
use super::question::Answer;
use super::spent::{Spent, capped};
use super::touch::Touch;
use crate::ask::TurnKind;
use crate::body::{Bodies, thickness};
use crate::id::PairKey;
use crate::schedule::known::Known;
use alloc::boxed::Box;
use arrayvec::ArrayVec;
use core::hint::black_box;
use punctual::engine::SeparatingPlane;
use punctual::prediction::{Calibration, MAX_STEP_WORK};
use punctual::{PairMemory, Verdict};

/// Maximum number of estimates of a pair that are kept until it is decided.
const MOST_ESTIMATES: usize = 8;

/// A witness that exists in no pair of trees.
pub(crate) const NO_TRIANGLES: [u32; 2] = [u32::MAX; 2];

/// The reported results of a pair, besides verdicts.
#[derive(Clone, Debug)]
pub(crate) enum Reported {
    /// Probabilities that estimates reported for the current poses, until the pair is decided.
    Estimates(ArrayVec<f64, MOST_ESTIMATES>),
    /// The last proven bounds of its distance, with the frame of the proof, and of its time of
    /// impact.
    Bounds(Bounds, u64, Times),
}

/// The result of a pair in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// The verdict of the frame; [`Verdict::Undecided`] if it did not decide the pair.
    pub verdict: Verdict,
    pub found: u64,
    /// True if the frame finished the pair.
    pub complete: bool,
    /// Expected share of the intersections that was found.
    pub recall: f64,
}

/// The turn of a pair in a batch. Holds all that is needed to assign and to collect it, because by
/// then its state is out of the cache, or in that of another core.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    pub state: Box<PairState>,
    /// Its entry in the list of pairs.
    pub known: Known,
    /// The index of its task in the frame.
    pub index: u32,
    /// Expected work, median.
    pub median: u32,
    pub kind: TurnKind,
    /// The question left after the turn.
    pub next: Option<TurnKind>,
    /// True if reported probabilities can now be compared with the verdict.
    pub teaches: bool,
    pub spent: Spent,
    /// Its result.
    pub standing: Standing,
}

impl Turn {
    /// A turn of a pair without a question yet.
    pub fn new(known: Known, state: Box<PairState>) -> Self {
        Self {
            state,
            known,
            index: 0,
            median: 0,
            kind: TurnKind::Meet,
            next: None,
            teaches: false,
            spent: Spent::default(),
            standing: Standing {
                verdict: Verdict::Undecided,
                found: 0,
                complete: false,
                recall: 0.0,
            },
        }
    }

    pub fn key(&self) -> PairKey {
        self.known.key
    }

    /// Stores the result in `frame`. `is_timed`: nothing is left to find of its time of impact.
    #[inline]
    pub fn end(&mut self, frame: u64, is_timed: bool) {
        self.standing = self.state.standing(frame, is_timed);
        self.known.note(&self.state, frame);
    }

    /// Ends the turn of a question in `frame`, and determines the next question.
    #[inline]
    pub fn end_question(&mut self, bodies: &Bodies, frame: u64) {
        let key = self.key();
        let is_timed = self.state.is_timed(key, bodies, frame);
        self.end(frame, is_timed);
        let (state, standing) = (&self.state, &self.standing);
        let complete = state.completed == frame;
        self.teaches = standing.verdict != Verdict::Undecided && state.has_estimates();
        let asks_contacts = standing.verdict != Verdict::Separated
            && bodies.wants_contacts(key)
            && bodies.small_drift(key, state, frame).is_none();
        self.next = match self.kind {
            TurnKind::Motion if !is_timed => Some(TurnKind::Motion),
            TurnKind::Motion | TurnKind::Contacts if asks_contacts => Some(TurnKind::Contacts),
            _ if !complete => Some(TurnKind::Meet),
            _ if !is_timed => Some(TurnKind::Motion),
            _ if asks_contacts => Some(TurnKind::Contacts),
            _ => None,
        };
    }

    /// True if the question of this turn, or one after it, must still be answered.
    pub fn is_due(&self) -> bool {
        self.next.is_some_and(|next| next >= self.kind)
    }
}

/// The state of a pair of bodies, kept while their boxes overlap.
#[derive(Clone, Debug)]
pub(crate) struct PairState {
    pub memory: PairMemory,
    /// The result of the last frame that decided it.
    pub verdict: Verdict,
    pub found: u64,
    /// The last frame that finished it; 0 if none did.
    pub completed: u64,
    /// The last frame that decided it; before that, the frame before its boxes overlapped.
    pub decided: u64,
    /// Work of the last run that no remembered witness cut short; a lower bound while that run is
    /// unfinished.
    pub search: u32,
    /// Work of the unfinished run.
    pub pending: Spent,
    pub reported: Reported,
    /// The bodies are separated until the sum of their displacements reaches this; 0 if nothing is
    /// proven.
    pub apart: f64,
    /// The frame, low bits, before which no proof of a distance is tried; 0 if one may be tried at
    /// any time.
    pub proves_from: u16,
    /// The last plane that separated them, the number of failures in a row, and the number of turns
    /// to come without planes.
    pub separating_plane: SeparatingPlane,
    pub in_vain: u8,
    pub without_planes: u8,
    /// Their contacts, if these are requested and the bodies are not known to be separated.
    pub touch: Option<Box<Touch>>,
}

impl PairState {
    /// The state of a pair of which nothing is known. `before` is the frame before its boxes
    /// overlapped.
    pub fn new(before: u64) -> Self {
        Self {
            memory: PairMemory::without_clearance(),
            verdict: Verdict::Undecided,
            found: 0,
            completed: 0,
            decided: before,
            search: 0,
            pending: Spent::default(),
            reported: Reported::Estimates(ArrayVec::new()),
            apart: 0.0,
            proves_from: 0,
            separating_plane: SeparatingPlane::default(),
            in_vain: 0,
            without_planes: 0,
            touch: None,
        }
    }

    /// Expected work of a search, or of the rest of an unfinished one; 0 if there was none yet.
    pub fn cost(&self) -> u32 {
        match self.search {
            0 => 0,
            search => capped(
                u64::from(search)
                    .saturating_sub(self.pending.work)
                    .max(MAX_STEP_WORK),
            ),
        }
    }

    /// True if it met when it was last decided.
    #[inline]
    pub fn met(&self) -> bool {
        self.verdict.meets()
    }

    /// The triangles (tree order) that met last, or that were within the margins.
    pub fn witness(&self) -> Option<[u32; 2]> {
        let closest = self.memory.closest();
        match self.verdict {
            Verdict::Within { .. } => closest,
            _ => self.memory.witness(0).or(closest),
        }
    }

    /// Records that the bodies are separated until the sum of their displacements reaches `until`;
    /// a negative value proves nothing.
    pub fn note_apart(&mut self, until: f64) {
        (self.apart, self.proves_from) = (until.max(0.0), 0);
    }

    /// Records a verdict that finished the pair in `frame`.
    pub fn finish(&mut self, verdict: Verdict, found: u64, frame: u64) {
        (self.completed, self.pending) = (frame, Spent::default());
        self.decide(verdict, found, frame);
    }

    /// The result of the pair in `frame`: [`Turn::end`].
    pub fn standing(&self, frame: u64, is_timed: bool) -> Standing {
        let verdict = if self.decided == frame {
            self.verdict
        } else {
            Verdict::Undecided
        };
        let complete = is_timed && self.completed == frame;
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
        // The expected work is at least twice that of the unfinished run so far.
        self.pending.work.max(1) as f64
            / f64::from(self.search.max(2)).max(2.0 * self.pending.work as f64)
    }

    /// True if contacts found before the surfaces moved by `drift` prove that the bodies still meet
    /// in `frame`, which is then recorded.
    pub fn goes_on_touching(
        &mut self,
        key: PairKey,
        bodies: &Bodies,
        drift: f64,
        frame: u64,
    ) -> bool {
        let nearest = self.touch.as_ref().and_then(|touch| touch.nearest);
        let Some(((triangles, distance), pair)) = nearest.zip(bodies.pair(key)) else {
            return false;
        };
        let distance = match drift > 0.0 {
            true => (distance + drift) * (1.0 + STRETCH),
            false => distance,
        };
        let touches = distance <= thickness(pair);
        if touches {
            self.completed = frame;
            self.decide(Verdict::of_witness(triangles, distance), 1, frame);
        }
        touches
    }

    /// Stores a reported probability, if there is room.
    pub fn add_estimate(&mut self, probability: f64) {
        match &mut self.reported {
            Reported::Estimates(estimates) => {
                let _ = estimates.try_push(probability);
            }
            reported @ Reported::Bounds(..) => {
                *reported = Reported::Estimates([probability].into_iter().collect())
            }
        }
    }

    /// True if there are reported probabilities of a pair that is not decided yet.
    pub fn has_estimates(&self) -> bool {
        matches!(&self.reported, Reported::Estimates(estimates) if !estimates.is_empty())
    }

    /// Drops the reported probabilities, because the bodies have moved, and the record of an
    /// unfinished search for contacts.
    #[inline]
    pub fn forget_estimates(&mut self) {
        if let Reported::Estimates(estimates) = &mut self.reported {
            estimates.clear();
        }
        if let Some(touch) = &mut self.touch {
            touch.pending = Spent::default();
        }
    }

    /// Updates the calibration from the reported probabilities of the pair, which is now decided.
    pub fn teach(&mut self, calibration: &mut Calibration) {
        if let Reported::Estimates(estimates) = &mut self.reported {
            let met = self.verdict != Verdict::Separated;
            estimates
                .drain(..)
                .for_each(|estimate| calibration.learn(estimate, met));
        }
    }

    /// Records what was proven in `frame`.
    #[cold]
    pub fn note_proof(&mut self, key: PairKey, bodies: &Bodies, proof: Proof, frame: u64) {
        let changed = bodies.last_change(key);
        let (before, since, times) = self.proven();
        self.reported = match proof {
            Proof::Impact(found) => {
                Reported::Bounds(before, since, times.and(found, changed, frame))
            }
            Proof::Distance(found) => {
                let gone = bodies.gone_at_least(key);
                let found = Bounds { gone, ..found };
                let bounds = if since >= changed {
                    before.and(found)
                } else {
                    // A truncated run may prove less than the old bound minus the displacement
                    // since; keep the larger.
                    let carried = bodies.carried(key, before, since, frame);
                    let low = found.low.max(carried.low).min(found.high);
                    Bounds { low, ..found }
                };
                Reported::Bounds(bounds, frame, times)
            }
        };
    }

    /// The last proven bounds of its distance, with the frame of the proof, and of its time of
    /// impact. If nothing is proven, they hold in no frame.
    pub fn proven(&self) -> (Bounds, u64, Times) {
        match self.reported {
            Reported::Bounds(bounds, since, times) => (bounds, since, times),
            Reported::Estimates(_) => (Bounds::NOTHING, 0, Times::NOTHING),
        }
    }

    /// True if nothing is left to find of its time of impact, if that is requested besides its
    /// distance.
    #[inline]
    pub fn is_timed(&self, key: PairKey, bodies: &Bodies, frame: u64) -> bool {
        !bodies.asks_both(key) || {
            let (.., times) = self.proven();
            times.is_final && times.hold(bodies.last_change(key), frame)
        }
    }

    /// How early a contact was proven in the last motion: 1 at once, 0 at its end.
    pub fn urgency(&self) -> Option<f32> {
        // Without `black_box` the compiler compares times before it has checked that there are any,
        // which valgrind reports.
        let (.., times) = black_box(self.proven());
        (times.high <= 1.0).then_some(1.0 - times.low as f32)
    }

    /// Records the verdict of `frame`.
    pub fn decide(&mut self, verdict: Verdict, found: u64, frame: u64) {
        (self.decided, self.verdict, self.found) = (frame, verdict, found);
    }

    /// Records the answer of a call in `frame` and the work of the run. Returns true if the run is
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
            // The distance equals the margins up to rounding.
            self.verdict = Verdict::Undecided;
        }
        is_final
    }
}
