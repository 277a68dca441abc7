//! The first step of a frame: known pairs are tested again.
//!
//! Most pairs that met in the last frame still meet. Two triangles prove it for the current poses,
//! whether the bodies are placed and paired or not. If time is limited and the last frame was cut
//! short, pairs whose witnesses are lost are searched next, and then all other known pairs. The
//! pairs found are reported even if the list of the frame ends before them, and so are pairs that
//! met and rest.

mod search;

use super::known::Known;
use super::pairs::{Pairs, learn};
use crate::broad::Broad;
use crate::cost::{WORK_PER_NEIGHBORS, WORK_PER_WITNESS};
use crate::id::{PairKey, bodies_of};
use crate::pair::batch::Batch;
use crate::pair::frame::Frame;
use crate::pair::retest::{Retest, Waiting, beside};
use crate::pair::spent::Spent;
use crate::room::reserve;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Verdict, Workspace};

/// Limits for the pairs that a frame examines. It looks for pairs that met among at least `LEAST`
/// known ones, or among `PER_TEST` for each test of the last frame. It looks for pairs to search
/// among `LEAST`, and `PER_TEST` more for each search. For each `PER_REST` pairs it finds at most
/// one that rests: listing these leaves less for the others.
const LEAST: usize = 8192;
const PER_TEST: usize = 8;
const PER_REST: usize = 16;

/// The neighbors of a lost witness are tested if they met at least this often, and otherwise in one
/// frame of `PER_NEARBY`; so are witnesses that rarely hold.
const LEAST_NEARBY: f32 = 0.15;
const PER_NEARBY: u64 = 16;

/// True if the witness of a pair that met is to be tested. One that rarely holds is tested sometimes,
/// because that may change.
fn is_worth_a_test(known: &Known, frame: &Frame) -> bool {
    !known.is_lost()
        && (!known.is_fickle() || (frame.number ^ known.key).is_multiple_of(PER_NEARBY))
}

/// A pair that was found to meet, with its witness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    pub key: PairKey,
    pub witness: [u32; 2],
}

impl Meeting {
    /// The result of a pair, if its verdict has a witness that intersects.
    fn new(key: PairKey, verdict: Verdict) -> Option<Self> {
        // Bodies with margins do not occur here: they are not plain.
        let Verdict::Intersecting { witness } = verdict else {
            return None;
        };
        Some(Self { key, witness })
    }
}

/// The batches that receive searches, a workspace, and the time at which they end.
pub(crate) struct Hands<'h> {
    pub batches: &'h mut [Batch],
    pub scratch: &'h mut Box<Workspace>,
    pub end: Option<Duration>,
    /// Number of searches dealt.
    pub dealt: usize,
}

#[derive(Debug, Default)]
pub(crate) struct Revisit {
    /// The pairs found to meet in this frame, ascending.
    pub found: Vec<Meeting>,
    /// Places of the pairs whose witnesses are lost.
    lost: Vec<u32>,
    /// Number of tests of this frame, and work of its searches.
    tests: usize,
    searches: Spent,
    /// True if there is no room for more pairs.
    pub is_full: bool,
    /// Where the next frame continues its tests; and where it continues its searches: of lost
    /// pairs, of pairs whose boxes overlap deeply, and of others.
    next: PairKey,
    turns: [PairKey; 3],
}

impl Revisit {
    /// Reserves room for this many pairs.
    pub fn reserve(&mut self, pairs: usize) {
        reserve(&mut self.found, pairs);
        reserve(&mut self.lost, pairs);
    }

    /// Work of this frame.
    pub fn spent(&self) -> Spent {
        let work = self.searches.work + self.tests as u64 * WORK_PER_WITNESS;
        Spent {
            work,
            ..self.searches
        }
    }

    /// Resets the results, for a frame without tests.
    pub fn skip(&mut self) {
        self.found.clear();
        self.lost.clear();
        (self.tests, self.searches, self.is_full) = (0, Spent::default(), false);
    }

    /// Tests the pairs that met, in turn, as far as the deadline and the room for them allow. If
    /// the last frame was cut, pairs that rest are also found, so that they are listed.
    pub fn test(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        deadline: &mut Deadline,
    ) {
        let enough = LEAST.max(PER_TEST * self.tests);
        self.skip();
        if !frame.cut && !frame.moved {
            return;
        }
        let first = self.next;
        let is_free = frame.budget.is_unlimited();
        let most = if is_free { usize::MAX } else { enough };
        let (known, mut place) = (pairs.len(), pairs.place(self.next));
        let (mut left, mut resting) = (most.min(known), most / PER_REST);
        let mut retest = Retest::new(frame.bodies);
        while left > 0 {
            if place == known {
                place = 0;
            }
            let end = known.min(place + left);
            let met = pairs.next_met(place..end);
            left -= met.unwrap_or(end) - place;
            place = met.unwrap_or(end);
            if met.is_none() {
                continue;
            }
            let taken = self.found.len() + retest.waiting.len() + self.lost.len();
            self.is_full = taken >= self.found.capacity();
            if self.is_full || !deadline.has_room(WORK_PER_WITNESS) {
                break;
            }
            let key = pairs.key(place);
            // A pair that moved in this frame does not rest, whatever its state says.
            let changed = frame.changed(key);
            let rests = changed < frame.number && pairs.state(place, frame).completed >= changed;
            if (frame.cut || !rests) && is_plain(key, frame, broad) {
                if rests {
                    if resting == 0 {
                        break;
                    }
                    resting -= 1;
                    let state = pairs.state(place, frame);
                    state.decided = frame.number;
                    self.found.extend(Meeting::new(key, state.verdict));
                    pairs.at_mut(place).stay(frame.number);
                } else if is_worth_a_test(pairs.at(place), frame) {
                    deadline.spend(WORK_PER_WITNESS);
                    self.tests += 1;
                    if !retest.add(key, place, pairs.at(place).witness()) {
                        self.lose(place, frame, pairs, deadline);
                    }
                    if retest.waiting.is_full() {
                        self.end_tests(&mut retest, frame, pairs, deadline);
                    }
                } else if !is_free {
                    // Without a budget the pair is searched when it is listed.
                    self.lost.push(place as u32);
                }
            }
            (place, left) = (place + 1, left - 1);
        }
        self.end_tests(&mut retest, frame, pairs, deadline);
        self.next = if place < known { pairs.key(place) } else { 0 };
        // They are nearly ascending, but for the turn.
        let turn = self.found.iter().position(|meeting| meeting.key < first);
        self.found.rotate_left(turn.unwrap_or(0));
        self.found.sort_unstable_by_key(|meeting| meeting.key);
    }

    /// Tests the pairs that wait.
    fn end_tests(
        &mut self,
        retest: &mut Retest,
        frame: &Frame,
        pairs: &mut Pairs,
        deadline: &mut Deadline,
    ) {
        for (Waiting { place, witness }, meets) in retest.test() {
            learn(&mut pairs.holds, meets);
            if meets {
                pairs.at_mut(place).hold(frame.number);
                let key = pairs.key(place);
                self.found.push(Meeting { key, witness });
            } else {
                self.lose(place, frame, pairs, deadline);
            }
        }
    }

    /// A witness no longer meets: its neighbors may.
    fn lose(&mut self, place: usize, frame: &Frame, pairs: &mut Pairs, deadline: &mut Deadline) {
        match self.test_beside(place, frame, pairs, deadline) {
            Some(witness) => {
                let key = pairs.key(place);
                self.found.push(Meeting { key, witness });
            }
            None => self.lost.push(place as u32),
        }
    }

    /// Tests the neighbors of a lost witness, if they are expected to meet.
    fn test_beside(
        &mut self,
        place: usize,
        frame: &Frame,
        pairs: &mut Pairs,
        deadline: &mut Deadline,
    ) -> Option<[u32; 2]> {
        let key = pairs.key(place);
        let pair = frame.bodies.pair(key)?;
        // Tested sometimes even if not expected to meet, because the expectation may be outdated.
        let is_due = pairs.nearby >= LEAST_NEARBY || (frame.number ^ key).is_multiple_of(PER_NEARBY);
        let mut nearby = pairs.nearby;
        let state = pairs.state(place, frame);
        let mut met = None;
        if is_due && deadline.has_room(WORK_PER_NEIGHBORS) {
            deadline.spend(WORK_PER_NEIGHBORS);
            self.searches.work += WORK_PER_NEIGHBORS;
            met = beside(pair, &mut state.memory);
            learn(&mut nearby, met.is_some());
        }
        state.note_test(met, frame.number);
        pairs.nearby = nearby;
        pairs.note(place, frame.number);
        met
    }

    /// Inserts a pair that meets.
    fn find(&mut self, met: Meeting) {
        let at = self.found.partition_point(|other| other.key < met.key);
        self.found.insert(at, met);
    }
}

/// True if the only question of a pair is whether these two bodies meet.
#[inline(always)]
fn is_plain(key: PairKey, frame: &Frame, broad: &Broad) -> bool {
    let (bodies, pair) = (frame.bodies, bodies_of(key));
    // Two fixed bodies may be known because their distance was measured.
    !bodies.is_special(key)
        && !bodies.wants_contacts(key)
        && broad.compares(pair)
        && bodies.may_meet(pair)
        && !broad.is_of_another(bodies, pair)
}
