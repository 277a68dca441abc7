//! The first step of a frame: known pairs are looked at again.
//!
//! Most pairs that met in the last frame still do, and two triangles prove it where the bodies are now, before those are placed
//! and paired: their last witnesses, or two that lie next to the latest. Where time is limited and the last frame was cut short,
//! pairs whose witnesses are lost are searched next, and after them all others that are known. What is found so is told, even if
//! the list of the frame ends before it, and so are the pairs that met and rest.

use super::pairs::Pairs;
use crate::model::cost::{LEAST_WORK, WORK_PER_MERGED_PAIR, WORK_PER_NEIGHBORS, WORK_PER_WITNESS};
use crate::query::{Deadline, Verdict, Workspace};
use crate::scene::ask::TurnKind;
use crate::scene::broad::Broad;
use crate::scene::id::{PairKey, bodies_of};
use crate::scene::pair::batch::{Desk, Round};
use crate::scene::pair::frame::Frame;
use crate::scene::pair::retest::{Retest, Tested, WITNESSES};
use crate::scene::pair::spent::Spent;
use crate::scene::pair::state::Turn;
use crate::scene::room::reserve;
use alloc::vec::Vec;
use core::mem;

/// A frame looks for pairs that met among this many known ones at least, or among so many for each test of the last frame. For
/// so many of them it finds at most one that rests: listing these leaves less for the others.
const LEAST: usize = 8192;
const PER_TEST: usize = 8;
const PER_REST: usize = 16;

/// What lies next to a lost witness is tested where it is expected to meet this often, and one time in so many where it is not.
const LEAST_NEARBY: f32 = 0.2;
const PER_NEARBY: u32 = 16;

/// Tests over which is averaged how often it meets, of a pair and of all; and how often it does before the first.
const TESTS_OF_PAIR: f32 = 8.0;
const TESTS_OF_SCENE: f32 = 64.0;
const USUAL_NEARBY: f32 = 0.5;

/// A pair that was found to meet, and two triangles that do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    pub key: PairKey,
    pub witness: [u32; 2],
}

#[derive(Debug, Default)]
pub(crate) struct Revisit {
    /// The pairs that were found to meet in this frame, ascending.
    pub found: Vec<Meeting>,
    /// Places of pairs whose witnesses are lost.
    lost: Vec<u32>,
    /// Tests of this frame, work of looking next to witnesses that are lost, and what its searches spent.
    tests: usize,
    beside: u64,
    searches: Spent,
    /// How much more often than usual what lies next to a lost witness meets, and how often it was not tested since it is not
    /// expected to.
    nearby: f32,
    passed: u32,
    /// Whether there is no room for more of them.
    pub is_full: bool,
    /// Where the next frame goes on with its tests; and with its searches of pairs that are lost, that were never asked, and of
    /// others.
    next: PairKey,
    turns: [PairKey; 3],
}

impl Revisit {
    /// Makes room for this many pairs.
    pub fn reserve(&mut self, pairs: usize) {
        reserve(&mut self.found, pairs);
        reserve(&mut self.lost, pairs);
    }

    /// What this frame spent.
    pub fn spent(&self) -> Spent {
        let work = self.searches.work + self.beside + self.tests as u64 * WORK_PER_WITNESS;
        Spent { work, ..self.searches }
    }

    /// Of a frame that tests nothing.
    pub fn skip(&mut self) {
        self.found.clear();
        (self.tests, self.beside, self.searches, self.is_full) = (0, 0, Spent::default(), false);
    }

    /// Tests the pairs that met, in turn, as far as the deadline and the room for them allow. `cut`: the last list was, so those
    /// that rest are found too, that they are listed.
    pub fn test(&mut self, frame: &Frame, broad: &Broad, pairs: &mut Pairs, cut: bool, deadline: &mut Deadline) {
        let enough = LEAST.max(PER_TEST * self.tests);
        let most = if frame.budget.is_unlimited() { usize::MAX } else { enough };
        self.skip();
        self.lost.clear();
        if !cut && frame.bodies.changed == 0 {
            return;
        }
        let (known, mut place) = (pairs.len(), pairs.place(self.next));
        let mut retest = Retest::new();
        // Those from a place on, then those before it; both ascend.
        let (mut left, mut resting, mut from) = (most.min(known), most / PER_REST, 0);
        while left > 0 {
            if place == known {
                self.flush(&mut retest, from, frame, pairs);
                (place, from) = (0, self.found.len());
            }
            let end = known.min(place + left);
            let met = pairs.next_met(place..end);
            left -= met.unwrap_or(end) - place;
            place = met.unwrap_or(end);
            if met.is_none() {
                continue;
            }
            let room = self.found.capacity().min(self.lost.capacity());
            let taken = self.found.len().max(self.lost.len()) + retest.len();
            self.is_full = taken >= room;
            if self.is_full || !deadline.has_room(WORK_PER_WITNESS) {
                break;
            }
            let key = pairs.key(place);
            let state = pairs.state(place, frame.number);
            let rests = state.completed >= frame.changed(key);
            if (cut || !rests) && is_plain(key, frame, broad) {
                if rests {
                    if resting == 0 {
                        break;
                    }
                    resting -= 1;
                    state.decided = frame.number;
                    let verdict = state.verdict;
                    self.find(key, verdict, from);
                } else if !state.is_lost(frame.number) && retest.add([place, 0], key, state, frame.bodies) {
                    self.tests += 1;
                    deadline.spend(WORK_PER_WITNESS);
                } else {
                    self.lost.push(place as u32);
                }
            }
            if retest.is_full() {
                self.flush(&mut retest, from, frame, pairs);
            }
            (place, left) = (place + 1, left - 1);
        }
        self.flush(&mut retest, from, frame, pairs);
        self.next = if place < known { pairs.key(place) } else { 0 };
        self.found.rotate_left(from);
        self.test_beside(&mut retest, frame, pairs, deadline);
    }

    /// Tests the pairs that wait. Those that meet are found, and come after the first `from` others.
    fn flush(&mut self, retest: &mut Retest, from: usize, frame: &Frame, pairs: &mut Pairs) {
        while retest.len() > 0 {
            let (tested, hits) = retest.run();
            for (lane, Tested { place, key, number, witness }) in tested.into_iter().enumerate() {
                let state = pairs.state(place, frame.number);
                if hits >> lane & 1 != 0 {
                    state.note_test(Some(witness), frame.number);
                    self.find(key, Verdict::Intersecting { witness }, from);
                } else if number + 1 == WITNESSES || !retest.add([place, number + 1], key, state, frame.bodies) {
                    state.note_test(None, frame.number);
                    self.lost.push(place as u32);
                }
            }
        }
    }

    /// Tests what lies next to the witnesses that are lost.
    fn test_beside(&mut self, retest: &mut Retest, frame: &Frame, pairs: &mut Pairs, deadline: &mut Deadline) {
        let mut lost = mem::take(&mut self.lost);
        lost.retain(|&place| !self.meets_beside(place as usize, retest, frame, pairs, deadline));
        self.lost = lost;
    }

    /// Whether triangles next to the latest witness of a pair meet, which this frame has lost: surfaces that meet go on meeting
    /// next door, unless they go far in a frame.
    fn meets_beside(
        &mut self,
        place: usize,
        retest: &mut Retest,
        frame: &Frame,
        pairs: &mut Pairs,
        deadline: &mut Deadline,
    ) -> bool {
        let (key, state) = (pairs.key(place), pairs.state(place, frame.number));
        let is_full = self.found.len() == self.found.capacity();
        if state.refuted != frame.number as u32 || is_full || !deadline.has_room(WORK_PER_NEIGHBORS) {
            return false;
        }
        let of_all = USUAL_NEARBY + self.nearby;
        let expected = of_all + state.nearby;
        if !frame.bodies.know_neighbors(key) || expected < LEAST_NEARBY && !self.tries_anyway() {
            return false;
        }
        self.beside += WORK_PER_NEIGHBORS;
        deadline.spend(WORK_PER_NEIGHBORS);
        let witness = retest.beside(key, state, frame.bodies);
        let met = if witness.is_some() { 1.0 } else { 0.0 };
        state.nearby += (met - expected) / TESTS_OF_PAIR;
        self.nearby += (met - of_all) / TESTS_OF_SCENE;
        let Some(witness) = witness else { return false };
        state.note_test(Some(witness), frame.number);
        self.find(key, Verdict::Intersecting { witness }, 0);
        true
    }

    /// Whether it is the turn of a test that is not expected to find anything: things may have changed.
    fn tries_anyway(&mut self) -> bool {
        self.passed = (self.passed + 1) % PER_NEARBY;
        self.passed == 0
    }

    /// Takes note of a pair if it meets, among those after the first `from`.
    fn find(&mut self, key: PairKey, verdict: Verdict, from: usize) {
        let Verdict::Intersecting { witness } = verdict else { return };
        let others = &self.found[from..];
        // Most come in order.
        let is_last = others.last().is_none_or(|last| last.key < key);
        let at = if is_last { others.len() } else { others.partition_point(|other| other.key < key) };
        self.found.insert(from + at, Meeting { key, witness });
    }

    /// Asks whether the pairs meet that were lost, then those that were never asked, and then all others that are known, each in
    /// turn, as far as the deadline allows.
    pub fn search(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) {
        self.lost.sort_unstable();
        let first = self.lost.partition_point(|&place| pairs.key(place as usize) < self.turns[0]);
        for at in (first..self.lost.len()).chain(0..first) {
            let place = self.lost[at] as usize;
            if !self.has_room(deadline) {
                self.turns[0] = pairs.key(place);
                return;
            }
            self.ask(place, frame, pairs, workspace, deadline);
        }
        for (turn, is_begun) in [(1, false), (2, true)] {
            let (known, start) = (pairs.len(), pairs.place(self.turns[turn]));
            for place in (start..known).chain(0..start) {
                if !pairs.is_unmet(place, is_begun) {
                    continue;
                }
                if !self.has_room(deadline) {
                    self.turns[turn] = pairs.key(place);
                    return;
                }
                deadline.spend(WORK_PER_MERGED_PAIR);
                if self.is_sought(place, frame, broad, pairs) {
                    self.ask(place, frame, pairs, workspace, deadline);
                }
            }
        }
    }

    fn has_room(&mut self, deadline: &mut Deadline) -> bool {
        self.is_full |= self.found.len() == self.found.capacity();
        deadline.has_room(LEAST_WORK) && !self.is_full
    }

    /// Whether a pair that did not meet is to be searched before it is listed.
    fn is_sought(&self, place: usize, frame: &Frame, broad: &Broad, pairs: &mut Pairs) -> bool {
        let (key, number) = (pairs.key(place), frame.number);
        // The stopped run of bodies at rest is gone on with later.
        if frame.changed(key) < number {
            return false;
        }
        let [a, b] = bodies_of(key).map(|body| broad.bounds(body));
        if !a.intersects(b) {
            return false;
        }
        pairs.overlapping(place, true, number);
        let state = pairs.state(place, number);
        state.completed < number && is_plain(key, frame, broad) && !state.stays_apart(frame.bodies, key, number)
    }

    /// Asks whether a pair meets.
    fn ask(
        &mut self,
        place: usize,
        frame: &Frame,
        pairs: &mut Pairs,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) {
        let Frame { bodies, number, mode, .. } = *frame;
        let round = &Round { frame: number, mode, to_the_end: true, end: None };
        let key = pairs.key(place);
        let (mut state, is_blank) = pairs.take(place, number);
        state.turn = Turn { key, kind: TurnKind::Meet, is_blank, ..Turn::NONE };
        let (held, looks_ahead) = (false, true);
        state.run(&mut Desk { bodies, round, deadline, workspace, held, patches: None, looks_ahead });
        self.searches.add(state.turn.spent);
        self.find(key, state.standing(number).verdict, 0);
        let is_blank = state.turn.is_blank;
        pairs.put_back(place, state, is_blank);
    }
}

/// Whether all that is asked of a pair is if the bodies meet that it was found for.
#[inline]
fn is_plain(key: PairKey, frame: &Frame, broad: &Broad) -> bool {
    let (bodies, pair) = (frame.bodies, bodies_of(key));
    !bodies.is_special(key) && bodies.may_meet(pair) && !broad.is_of_another(bodies, pair)
}
