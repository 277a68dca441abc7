//! The first step of a frame: known pairs are tested again.
//!
//! Most pairs that met in the last frame still meet. Two triangles prove it for the current poses,
//! whether the bodies are placed and paired or not: the latest witnesses, or neighbors of the
//! latest one. If time is limited and the last frame was cut short, pairs whose witnesses are lost
//! are searched next, and then all other known pairs. The pairs found are reported even if the list
//! of the frame ends before them, and so are pairs that met and rest.

mod search;

use super::pairs::Pairs;
use crate::broad::Broad;
use crate::cost::{WORK_PER_NEIGHBORS, WORK_PER_WITNESS};
use crate::id::{PairKey, bodies_of};
use crate::pair::batch::{Batch, Round, RoundKind};
use crate::pair::frame::Frame;
use crate::pair::retest::{LANES, Outcome, Test};
use crate::pair::spent::Spent;
use crate::pair::state::{NO_TRIANGLES, PairState};
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

/// The neighbors of a lost witness are tested if they meet at least this often in expectation, and
/// otherwise one time in `PER_NEARBY`.
const LEAST_NEARBY: f32 = 0.2;
const PER_NEARBY: u32 = 16;

/// Number of tests over which the frequency of meeting neighbors is averaged, for a pair and for
/// the scene; and its initial value.
const TESTS_OF_PAIR: f32 = 8.0;
const TESTS_OF_SCENE: f32 = 64.0;
const USUAL_NEARBY: f32 = 0.5;

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

/// The batches that receive tests, a workspace, and the time at which they end.
pub(crate) struct Hands<'h> {
    pub batches: &'h mut [Batch],
    pub scratch: &'h mut Box<Workspace>,
    pub end: Option<Duration>,
    /// Number of searches dealt.
    pub dealt: usize,
}

impl Hands<'_> {
    /// Runs everything started to its end.
    fn finish(&mut self, frame: &Frame, round: &Round) {
        frame
            .crew
            .finish(self.batches, round, frame.bodies, self.scratch, &mut |_| ());
    }

    /// The tests that were dealt.
    fn tests(&mut self) -> impl Iterator<Item = Test> {
        self.batches
            .iter_mut()
            .flat_map(|batch| batch.tests.drain(..))
    }
}

/// If time is limited, each thread tests this many pairs at once.
const TESTS: usize = 64;

/// Number of parts in which several threads share the tests.
const PARTS: usize = 8;

/// Number of tests that a batch needs room for, with this many pairs.
pub(crate) fn room(batch: usize, pairs: usize) -> usize {
    match batch {
        0 => pairs,
        1..PARTS => pairs / PARTS + LANES,
        _ => 0,
    }
}

#[derive(Debug, Default)]
pub(crate) struct Revisit {
    /// The pairs found to meet in this frame, ascending.
    pub found: Vec<Meeting>,
    /// Places of the pairs that wait for their tests, and of those whose witnesses are lost.
    waiting: Vec<u32>,
    lost: Vec<u32>,
    /// Number of tests of this frame, work of testing neighbors of lost witnesses, and work of its
    /// searches.
    tests: usize,
    beside: u64,
    searches: Spent,
    /// How much more often than usual the neighbors of a lost witness meet; and how often they were
    /// not tested because they were not expected to meet.
    nearby: f32,
    passed: u32,
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
        reserve(&mut self.waiting, pairs);
        reserve(&mut self.lost, pairs);
    }

    /// Work of this frame.
    pub fn spent(&self) -> Spent {
        let work = self.searches.work + self.beside + self.tests as u64 * WORK_PER_WITNESS;
        Spent {
            work,
            ..self.searches
        }
    }

    /// Resets the results, for a frame without tests.
    pub fn skip(&mut self) {
        self.found.clear();
        self.lost.clear();
        (self.tests, self.beside, self.searches, self.is_full) = (0, 0, Spent::default(), false);
    }

    /// Tests the pairs that met, in turn, as far as the deadline and the room for them allow. If
    /// the last list was cut, pairs that rest are also found, so that they are listed. Calls
    /// `meanwhile` while other threads test.
    pub fn test(
        &mut self,
        frame: &Frame,
        broad: &mut Broad,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
        meanwhile: impl FnOnce(&mut Broad, &mut Pairs),
    ) {
        let enough = LEAST.max(PER_TEST * self.tests);
        self.skip();
        if !frame.cut && !frame.moved {
            return;
        }
        let first = self.next;
        let most = if frame.budget.is_unlimited() {
            usize::MAX
        } else {
            enough
        };
        let mut left = [most.min(pairs.len()), most / PER_REST];
        let (mut goes_on, mut is_cut, mut meanwhile) = (true, false, Some(meanwhile));
        while goes_on && !is_cut {
            goes_on = self.gather(frame, broad, pairs, &mut left, deadline);
            let round = self.begin(frame, pairs, hands, |pairs, place| {
                Some(Test::new(
                    pairs.key(place as usize),
                    place,
                    pairs.witness(place as usize),
                ))
            });
            if let Some(meanwhile) = meanwhile.take() {
                meanwhile(broad, pairs);
            }
            hands.finish(frame, &round);
            let mut before = 0;
            hands.tests().for_each(
                |Test {
                     key,
                     place,
                     witness,
                     outcome,
                     ..
                 }| {
                    self.tests += usize::from(outcome != Outcome::Untested);
                    let place = pairs.place_now(place as usize, key, before);
                    before = place.unwrap_or(before);
                    match outcome {
                        Outcome::Met => {
                            place
                                .into_iter()
                                .for_each(|place| pairs.hold(place, frame.number));
                            self.found.push(Meeting { key, witness });
                        }
                        Outcome::Lost => self.lost.extend(place.map(|place| place as u32)),
                        Outcome::Untested if is_cut => {}
                        Outcome::Untested => (is_cut, self.next) = (true, key),
                    }
                },
            );
        }
        // Order: first those that rest, then those from the start place on, then the others.
        let turn = self.found.iter().position(|meeting| meeting.key < first);
        self.found.rotate_left(turn.unwrap_or(0));
        if !self.found.is_sorted_by_key(|meeting| meeting.key) {
            self.found.sort_unstable_by_key(|meeting| meeting.key);
        }
        self.test_again(frame, pairs, hands, deadline);
    }

    /// For the pairs whose latest witnesses no longer meet, tests the witnesses before them, and
    /// the neighbors of the latest if these are expected to meet: surfaces usually still meet
    /// nearby, unless they move far in a frame.
    fn test_again(
        &mut self,
        frame: &Frame,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
    ) {
        // The others were lost before this frame.
        self.waiting.extend(
            self.lost
                .extract_if(.., |place| !pairs.is_lost(*place as usize)),
        );
        let (of_all, mut passed) = (USUAL_NEARBY + self.nearby, self.passed);
        let round = self.begin(frame, pairs, hands, |pairs, place| {
            let mut test = Test::new(pairs.key(place as usize), place, NO_TRIANGLES);
            let (mut state, known) = pairs.take_state(place as usize)?;
            known.tell(&mut state, frame.bodies, frame.number);
            test.witness = state.memory.witness(1).unwrap_or(test.witness);
            if deadline.has_room(WORK_PER_NEIGHBORS) {
                let is_expected = of_all + state.nearby >= LEAST_NEARBY;
                // Tested sometimes even if not expected to meet, because the expectation may be
                // outdated.
                passed = if is_expected {
                    passed
                } else {
                    (passed + 1) % PER_NEARBY
                };
                test.asks_beside = is_expected || passed == 0;
                deadline.spend(if test.asks_beside {
                    WORK_PER_NEIGHBORS
                } else {
                    0
                });
            }
            test.state = Some(state);
            Some(test)
        });
        hands.finish(frame, &round);
        self.passed = passed;
        hands.tests().for_each(
            |Test {
                 state,
                 key,
                 place,
                 witness,
                 beside,
                 outcome,
                 ..
             }| {
                let Some(mut state) = state else { return };
                if let Some(met) = beside {
                    self.learn_beside(&mut state, met);
                }
                match outcome {
                    Outcome::Met => {
                        if let Some(older) = state.memory.witness(1).filter(|_| beside.is_none()) {
                            state.memory.found(older);
                        }
                        state.note_test(Some(witness), frame.number);
                        self.find(Meeting { key, witness });
                    }
                    Outcome::Lost | Outcome::Untested => {
                        state.note_test(None, frame.number);
                        self.lost.push(place);
                    }
                }
                pairs.put_back_updated(place as usize, state, frame.number);
            },
        );
    }

    /// Gathers pairs that met, starting with the one whose turn it is. Pairs that rest are found;
    /// others wait for their tests or are lost. `left`: number of places to examine; `resting`:
    /// number of resting pairs to find. Returns true if pairs are left: only a few wait at a time
    /// if time is limited.
    fn gather(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        [left, resting]: &mut [usize; 2],
        deadline: &mut Deadline,
    ) -> bool {
        let (known, mut place) = (pairs.len(), pairs.place(self.next));
        let enough = if frame.is_timed() {
            TESTS * frame.threads()
        } else {
            usize::MAX
        };
        let mut goes_on = true;
        while *left > 0 && self.waiting.len() < enough {
            if place == known {
                place = 0;
            }
            let end = known.min(place + *left);
            let met = pairs.next_met(place..end);
            *left -= met.unwrap_or(end) - place;
            place = met.unwrap_or(end);
            if met.is_none() {
                continue;
            }
            self.is_full =
                self.found.len() + self.waiting.len() + self.lost.len() >= self.found.capacity();
            goes_on = !self.is_full && deadline.has_room(WORK_PER_WITNESS);
            if !goes_on {
                break;
            }
            let key = pairs.key(place);
            // A pair that moved in this frame does not rest, whatever its state says.
            let changed = frame.changed(key);
            let rests = changed < frame.number && pairs.state(place, frame).completed >= changed;
            if (frame.cut || !rests) && is_plain(key, frame, broad) {
                if rests {
                    goes_on = *resting > 0;
                    if !goes_on {
                        break;
                    }
                    *resting -= 1;
                    let state = pairs.state(place, frame);
                    state.decided = frame.number;
                    self.found.extend(Meeting::new(key, state.verdict));
                } else if !pairs.is_lost(place) {
                    self.waiting.push(place as u32);
                    deadline.spend(WORK_PER_WITNESS);
                } else if !frame.budget.is_unlimited() {
                    // Without a budget the pair is searched when it is listed. Its place may have
                    // changed by then.
                    self.lost.push(place as u32);
                }
            }
            (place, *left) = (place + 1, *left - 1);
        }
        self.next = if place < known { pairs.key(place) } else { 0 };
        goes_on && *left > 0
    }

    /// Starts the tests of the pairs that wait, in batches.
    fn begin(
        &mut self,
        frame: &Frame,
        pairs: &mut Pairs,
        Hands { batches, end, .. }: &mut Hands,
        mut test: impl FnMut(&mut Pairs, u32) -> Option<Test>,
    ) -> Round {
        let parts = if frame.threads() == 1 { 1 } else { PARTS };
        let each = self
            .waiting
            .len()
            .div_ceil(parts)
            .next_multiple_of(LANES)
            .max(LANES);
        let round = Round {
            kind: RoundKind::Test,
            ..Round::to_the_end(frame.number, frame.mode, *end)
        };
        for (part, places) in self.waiting.chunks(each).enumerate() {
            batches[part]
                .tests
                .extend(places.iter().filter_map(|&place| test(pairs, place)));
            frame
                .crew
                .begin(part, &mut batches[part..=part], &round, frame.bodies);
        }
        self.waiting.clear();
        round
    }

    /// Updates how often neighbors of met pairs meet too, after the test of a neighbor.
    fn learn_beside(&mut self, state: &mut PairState, met: bool) {
        self.beside += WORK_PER_NEIGHBORS;
        let (met, of_all) = (if met { 1.0 } else { 0.0 }, USUAL_NEARBY + self.nearby);
        state.nearby += (met - of_all - state.nearby) / TESTS_OF_PAIR;
        self.nearby += (met - of_all) / TESTS_OF_SCENE;
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
