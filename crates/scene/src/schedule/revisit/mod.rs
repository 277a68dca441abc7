//! The first step of a frame: known pairs are tested again.
//!
//! Most pairs that met in the last frame still meet. Two triangles prove it for the current poses,
//! whether the bodies are placed and paired or not. Unless work is limited, those that these tests
//! leave open are [searched](search); in a frame with little time, all known pairs are. The pairs
//! decided are reported even if the list of the frame ends before them, and so are pairs that met
//! and rest.

mod search;

use super::known::Known;
use super::pairs::{Pairs, learn};
use crate::body::triangle_ids;
use crate::broad::Broad;
use crate::cost::{WORK_PER_NEIGHBORS, WORK_PER_WITNESS};
use crate::id::{PairKey, bodies_of};
use crate::pair::batch::Batch;
use crate::pair::frame::Frame;
use crate::pair::retest::{Retest, Waiting, beside, within};
use crate::pair::spent::Spent;
use crate::room::reserve;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Verdict, Workspace};

/// Limits for the pairs that a frame examines. It looks for pairs that met among at least `LEAST`
/// known ones, or among `PER_TEST` for each test of the last frame. For each `PER_REST`
/// pairs it finds at most one that rests: listing these leaves less for the others.
const LEAST: usize = 8192;
const PER_TEST: usize = 8;
const PER_REST: usize = 16;

/// The neighbors of a lost witness are tested if they met at least this often, and otherwise in one
/// frame of `PER_NEARBY`; so are witnesses that rarely hold.
const LEAST_NEARBY: f32 = 0.15;
const PER_NEARBY: u64 = 32;

/// True if the witness of a pair that met is to be tested. One that rarely holds is tested
/// sometimes, because that may change.
fn is_worth_a_test(known: &Known, frame: &Frame) -> bool {
    !known.is_lost()
        && (!known.is_fickle() || (frame.number ^ known.key).is_multiple_of(PER_NEARBY))
}

/// A pair that was decided before the list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decision {
    pub key: PairKey,
    pub verdict: Verdict,
}

/// The inputs of the searches of a frame.
pub(crate) struct Search<'s, 'c> {
    pub frame: &'s Frame<'c>,
    pub broad: &'s Broad,
    pub pairs: &'s mut Pairs,
    /// The batches that receive searches, the number of those assigned to them, and of those that
    /// make a part for one batch; 0 if the batches are run together.
    pub batches: &'s mut [Batch],
    pub assigned: usize,
    pub part: usize,
    pub scratch: &'s mut Box<Workspace>,
    /// The time until which searches begin, and the time at which the last must end: a search cut
    /// short is lost.
    pub end: Option<Duration>,
    pub latest_end: Option<Duration>,
    /// The latter, for searches on this thread: a deadline in use knows the pace of the work.
    pub latest: Deadline<'c>,
}

impl<'c> Search<'_, 'c> {
    /// The time until which searches begin.
    fn deadline(&self) -> Deadline<'c> {
        Deadline::of_a_part(self.end, u64::MAX, self.frame.clock)
    }
}

/// The walks through the known pairs, each of which continues where its last one ended.
#[derive(Clone, Copy)]
enum Walk {
    Tests,
    Important,
    Turns,
    Hot,
    Cold,
}

#[derive(Debug, Default)]
pub(crate) struct Revisit {
    /// The pairs decided in this frame, ascending after [`Revisit::end`].
    pub found: Vec<Decision>,
    /// Number of tests of this frame, and work of its searches.
    tests: usize,
    searches: Spent,
    /// True if there is no room for more pairs.
    pub is_full: bool,
    /// Where the next [walks](Walk) begin.
    next: [PairKey; 5],
    /// Time that the turns have saved for later frames, nanoseconds; negative if they owe some.
    credit: f64,
    /// The gain of the pair at which the last frame ended its searches.
    cutoff: f32,
    /// The pairs that met and that the tests leave open, by place; then the ranks of those
    /// searched.
    ranks: Vec<u64>,
}

impl Revisit {
    /// Reserves room for this many pairs.
    pub fn reserve(&mut self, pairs: usize) {
        reserve(&mut self.found, pairs);
        reserve(&mut self.ranks, pairs);
    }

    /// Work of this frame.
    pub fn spent(&self) -> Spent {
        let work = self.searches.work + self.tests as u64 * WORK_PER_WITNESS;
        Spent {
            work,
            ..self.searches
        }
    }

    /// Resets the results. Returns the number of tests of the last frame.
    pub fn begin(&mut self) -> usize {
        let tests = self.tests;
        self.found.clear();
        self.ranks.clear();
        (self.tests, self.searches, self.is_full) = (0, Spent::default(), false);
        tests
    }

    /// Tests the pairs that met, in turn, as far as the deadline and the room for them allow. If
    /// the last frame was cut, pairs that rest are also found, so that they are listed. `tests`:
    /// their number in the last frame.
    pub fn test(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        tests: usize,
        deadline: &mut Deadline,
    ) {
        let enough = LEAST.max(PER_TEST * tests);
        if !frame.cut && !frame.moved {
            return;
        }
        let is_free = frame.budget.is_unlimited();
        let most = if is_free { usize::MAX } else { enough };
        let (known, mut place) = (pairs.len(), pairs.place(self.next[Walk::Tests as usize]));
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
            let taken = self.found.len() + retest.waiting.len();
            self.is_full = taken >= self.found.capacity();
            if self.is_full || !deadline.has_room(WORK_PER_WITNESS) {
                break;
            }
            let (key, known) = (pairs.key(place), pairs.at(place));
            let (is_worth, is_done) = (
                is_worth_a_test(known, frame),
                known.is_completed(frame.number),
            );
            // A pair that moved in this frame does not rest, whatever its state says.
            let changed = frame.changed(key);
            let rests = changed < frame.number && pairs.state(place, frame).completed >= changed;
            let is_due = !is_done && if rests { frame.cut } else { is_worth };
            if is_due && is_plain(key, frame, broad) {
                if rests {
                    if resting == 0 {
                        break;
                    }
                    resting -= 1;
                    let state = pairs.state(place, frame);
                    state.decided = frame.number;
                    let verdict = state.verdict;
                    self.found.push(Decision { key, verdict });
                    pairs.at_mut(place).stay(frame.number);
                } else {
                    deadline.spend(WORK_PER_WITNESS);
                    self.tests += 1;
                    if frame.bodies.has_special && frame.bodies.is_special(key) {
                        self.test_margins(place, frame, pairs);
                    } else if !retest.add(key, place, pairs.at(place).witness()) {
                        self.lose(place, frame, pairs, deadline);
                    }
                    if retest.waiting.is_full() {
                        self.end_tests(&mut retest, frame, pairs, deadline);
                    }
                }
            } else if !rests && !is_done {
                self.leave_open(place);
            }
            (place, left) = (place + 1, left - 1);
        }
        self.end_tests(&mut retest, frame, pairs, deadline);
        self.next[Walk::Tests as usize] = if place < known { pairs.key(place) } else { 0 };
    }

    /// Sorts the pairs decided.
    pub fn end(&mut self) {
        self.found.sort_unstable_by_key(|decision| decision.key);
    }

    /// Tests the pairs that wait.
    fn end_tests(
        &mut self,
        retest: &mut Retest,
        frame: &Frame,
        pairs: &mut Pairs,
        deadline: &mut Deadline,
    ) {
        for (Waiting { place, ids }, meets) in retest.test() {
            learn(&mut pairs.holds, meets);
            if meets {
                let witness = pairs.at(place).witness();
                self.hold(place, witness, ids, frame, pairs);
            } else {
                self.lose(place, frame, pairs, deadline);
            }
        }
    }

    #[cold]
    fn test_margins(&mut self, place: usize, frame: &Frame, pairs: &mut Pairs) {
        let (key, latest) = (pairs.key(place), pairs.at(place).witness());
        let pair = frame.bodies.pair(key);
        let met = pair
            .and_then(|pair| within(pair, latest))
            .map(|(witness, distance)| Verdict::of_witness(witness, distance));
        learn(&mut pairs.holds, met.is_some());
        let Some(verdict) = met else {
            return pairs.at_mut(place).lose();
        };
        pairs.at_mut(place).hold(latest, frame.number);
        pairs.state(place, frame).finish(verdict, 1, frame.number);
        self.found.push(Decision { key, verdict });
    }

    /// Records that two triangles of a pair, `witness` in tree order, meet.
    fn hold(
        &mut self,
        place: usize,
        witness: [u32; 2],
        ids: [u32; 2],
        frame: &Frame,
        pairs: &mut Pairs,
    ) {
        let known = pairs.at_mut(place);
        known.hold(witness, frame.number);
        let (key, verdict) = (known.key, Verdict::Intersecting { witness: ids });
        self.found.push(Decision { key, verdict });
    }

    /// Tests the neighbors of a lost witness if they are expected to meet, and sometimes even if
    /// not, because the expectation may be outdated. If none meets, records the pair as lost.
    fn lose(&mut self, place: usize, frame: &Frame, pairs: &mut Pairs, deadline: &mut Deadline) {
        let (key, witness) = (pairs.key(place), pairs.at(place).witness());
        let is_due =
            pairs.nearby >= LEAST_NEARBY || (frame.number ^ key).is_multiple_of(PER_NEARBY);
        let mut met = None;
        if let Some(pair) = frame.bodies.pair(key)
            && is_due
            && deadline.has_room(WORK_PER_NEIGHBORS)
        {
            deadline.spend(WORK_PER_NEIGHBORS);
            self.searches.work += WORK_PER_NEIGHBORS;
            met = beside(pair, witness).and_then(|found| Some((found, triangle_ids(pair, found)?)));
            learn(&mut pairs.nearby, met.is_some());
        }
        match met {
            Some((witness, ids)) => self.hold(place, witness, ids, frame, pairs),
            None => {
                pairs.at_mut(place).lose();
                self.leave_open(place);
            }
        }
    }

    /// Records a pair that met and that the tests leave open.
    fn leave_open(&mut self, place: usize) {
        if self.ranks.len() < self.ranks.capacity() {
            self.ranks.push(place as u64);
        }
    }
}

/// True if the only question of a pair is whether these two bodies, thickened by their margins,
/// meet.
#[inline(always)]
fn is_plain(key: PairKey, frame: &Frame, broad: &Broad) -> bool {
    let (bodies, pair) = (frame.bodies, bodies_of(key));
    // A pair of fixed bodies is known only if its distance was measured: then a body is, or was,
    // special.
    !(bodies.has_special && !(bodies.asks_only_contact(key) && broad.compares(pair)))
        && !bodies.wants_contacts(key)
        && bodies.may_meet(pair)
        && !(bodies.has_removed && broad.is_of_another(bodies, pair))
}
