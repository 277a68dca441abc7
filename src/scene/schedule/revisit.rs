//! The first step of a frame whose time is limited: known pairs are looked at again.
//!
//! Most pairs that met in the last frame still do, and two triangles prove it where the bodies are now, before those are placed
//! and paired: their last witnesses. If the last frame was cut short, pairs whose witnesses are lost are searched next, and after
//! them all others that are known. What is found so is told, even if the list of the frame ends before it.

use super::pairs::Pairs;
use crate::model::cost::{LEAST_WORK, WORK_PER_MERGED_PAIR, WORK_PER_WITNESS};
use crate::query::{Deadline, Verdict, Workspace};
use crate::scene::ask::TurnKind;
use crate::scene::broad::Broad;
use crate::scene::id::{PairKey, bodies_of};
use crate::scene::pair::batch::{Desk, Round};
use crate::scene::pair::frame::Frame;
use crate::scene::pair::spent::Spent;
use crate::scene::pair::state::Turn;
use crate::scene::room::reserve;
use alloc::vec::Vec;
use core::mem;

/// A frame looks at this many known pairs at least, or at so many for each test of the last frame.
const LEAST: usize = 1024;
const PER_TEST: usize = 8;

#[derive(Debug, Default)]
pub(crate) struct Revisit {
    /// The pairs that were found to meet in this frame, ascending.
    pub found: Vec<PairKey>,
    /// Pairs whose witnesses are lost, and pairs that did not meet when they were last decided, or never were.
    lost: Sought,
    others: Sought,
    /// Tests of this frame, and what its searches spent.
    tests: usize,
    searches: Spent,
    /// Where the next frame goes on with its tests.
    next: PairKey,
}

/// Pairs to be searched, in turn.
#[derive(Debug, Default)]
struct Sought {
    places: Vec<u32>,
    /// Where the next frame goes on.
    next: PairKey,
}

impl Sought {
    /// Those that there is room for.
    fn push(&mut self, place: usize) {
        if self.places.len() < self.places.capacity() {
            self.places.push(place as u32);
        }
    }
}

impl Revisit {
    /// Makes room for this many pairs.
    pub fn reserve(&mut self, pairs: usize) {
        reserve(&mut self.found, pairs);
        reserve(&mut self.lost.places, pairs);
        reserve(&mut self.others.places, pairs);
    }

    /// What this frame spent.
    pub fn spent(&self) -> Spent {
        Spent { work: self.searches.work + self.tests as u64 * WORK_PER_WITNESS, ..self.searches }
    }

    /// Of a frame that tests nothing.
    pub fn skip(&mut self) {
        self.found.clear();
        (self.tests, self.searches) = (0, Spent::default());
    }

    /// Tests the pairs that met, in turn, as far as the deadline and the room for them allow. `searches`: takes note of others.
    pub fn test(&mut self, frame: &Frame, broad: &Broad, pairs: &mut Pairs, deadline: &mut Deadline, searches: bool) {
        let most = LEAST.max(PER_TEST * mem::take(&mut self.tests));
        self.found.clear();
        self.lost.places.clear();
        self.others.places.clear();
        let (known, start) = (pairs.len(), pairs.place(self.next));
        let (mut seen, mut before_turn) = (0, 0);
        for place in (start..known).chain(0..start).take(most) {
            if place == 0 {
                before_turn = self.found.len();
            }
            if !deadline.has_room(WORK_PER_WITNESS) || self.found.len() == self.found.capacity() {
                break;
            }
            seen += 1;
            let work = self.visit(place, frame, broad, pairs, searches);
            deadline.spend(work);
        }
        if seen < known {
            self.next = pairs.key((start + seen) % known);
        }
        self.found.rotate_left(before_turn);
        self.searches = Spent::default();
    }

    /// Tests a pair if it met when it was last decided, and something is new since. The work that it took.
    #[inline]
    fn visit(&mut self, place: usize, frame: &Frame, broad: &Broad, pairs: &mut Pairs, searches: bool) -> u64 {
        if !pairs.overlapped(place) {
            return WORK_PER_MERGED_PAIR;
        }
        let (key, number) = (pairs.key(place), frame.number);
        let state = pairs.state(place, number);
        let met = matches!(state.verdict, Verdict::Intersecting { .. });
        if !(met || searches) {
            return WORK_PER_MERGED_PAIR;
        }
        let changed = frame.changed(key);
        if state.completed >= changed || state.is_refuted(changed, number) || !is_plain(key, frame, broad) {
            return WORK_PER_MERGED_PAIR;
        }
        if !met {
            // The stopped run of bodies at rest is gone on with later.
            if changed == number && !state.stays_apart(frame.bodies, key, number) {
                self.others.push(place);
            }
            return WORK_PER_MERGED_PAIR;
        }
        let Some([a, b]) = frame.bodies.pair(key) else { return WORK_PER_MERGED_PAIR };
        self.tests += 1;
        if state.retest([a, b], &a.relative(b), number) {
            self.found.push(key);
        } else {
            self.lost.push(place);
        }
        WORK_PER_WITNESS
    }

    /// Asks whether the pairs meet that were lost, and then the others, as far as the deadlines of these and of those allow.
    pub fn search(
        &mut self,
        frame: &Frame,
        pairs: &mut Pairs,
        workspace: &mut Workspace,
        mut deadlines: [Deadline; 2],
    ) {
        let Frame { bodies, number, mode, .. } = *frame;
        let round = &Round { frame: number, mode, to_the_end: true, witnesses_only: false, end: None };
        let sought = [&mut self.lost, &mut self.others];
        for (Sought { places, next }, deadline) in sought.into_iter().zip(&mut deadlines) {
            places.sort_unstable();
            let first = places.partition_point(|&place| pairs.key(place as usize) < *next);
            let (before, after) = places.split_at(first);
            for place in after.iter().chain(before).map(|&place| place as usize) {
                let key = pairs.key(place);
                if !deadline.has_room(LEAST_WORK) || self.found.len() == self.found.capacity() {
                    *next = key;
                    break;
                }
                let (mut state, is_blank) = pairs.take(place, number);
                state.turn = Turn { key, kind: TurnKind::Meet, is_blank, ..Turn::NONE };
                let (held, looks_ahead) = (false, true);
                state.run(&mut Desk { bodies, round, deadline, workspace, held, patches: None, looks_ahead });
                self.searches.add(state.turn.spent);
                if matches!(state.standing(number).verdict, Verdict::Intersecting { .. }) {
                    self.found.insert(self.found.partition_point(|&other| other < key), key);
                }
                let is_blank = state.turn.is_blank;
                pairs.put_back(place, state, is_blank);
            }
        }
    }
}

/// Whether all that is asked of a pair is if the bodies meet that it was found for.
fn is_plain(key: PairKey, frame: &Frame, broad: &Broad) -> bool {
    let (bodies, pair) = (frame.bodies, bodies_of(key));
    let is_asked_more = bodies.is_special(key) || bodies.contact_requests.has(key);
    !is_asked_more && bodies.may_meet(pair) && !broad.is_of_another(bodies, pair)
}
