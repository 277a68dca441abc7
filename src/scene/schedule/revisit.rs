//! Before anything else of a frame whose time is limited: the last witnesses of pairs that met.
//!
//! Most pairs that met in the last frame still do, and two triangles prove it where the bodies are now, before those are placed
//! and paired. What is found so is told, even if the list of the frame ends before it.

use super::pairs::Pairs;
use crate::model::cost::{WORK_PER_MERGED_PAIR, WORK_PER_WITNESS};
use crate::query::{Deadline, Mode};
use crate::scene::broad::Broad;
use crate::scene::id::{PairKey, bodies_of};
use crate::scene::pair::frame::Frame;
use alloc::vec::Vec;
use core::mem;

/// Known pairs that a frame looks at, at least, and for each test of the last frame.
const LEAST: usize = 1024;
const PER_TEST: usize = 8;

#[derive(Debug, Default)]
pub(crate) struct Revisit {
    /// The pairs that were found to meet in this frame, ascending.
    pub found: Vec<PairKey>,
    /// Tests of this frame.
    pub tests: usize,
    /// Where the next frame goes on.
    next: PairKey,
}

impl Revisit {
    /// Work of this frame.
    pub fn work(&self) -> u64 {
        self.tests as u64 * WORK_PER_WITNESS
    }

    /// Of a frame that tests nothing.
    pub fn skip(&mut self) {
        self.found.clear();
        self.tests = 0;
    }

    /// Tests the pairs that met, in turn, as far as the deadline and the room for them allow.
    pub fn run(&mut self, frame: &Frame, broad: &Broad, pairs: &mut Pairs, deadline: &mut Deadline) {
        let most = LEAST.max(PER_TEST * mem::take(&mut self.tests));
        self.found.clear();
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
            let work = self.visit(place, frame, broad, pairs);
            deadline.spend(work);
        }
        if seen < known {
            self.next = pairs.key((start + seen) % known);
        }
        self.found.rotate_left(before_turn);
    }

    /// Tests a pair if it met when it was last decided, and something is new since. The work that it took.
    #[inline]
    fn visit(&mut self, place: usize, frame: &Frame, broad: &Broad, pairs: &mut Pairs) -> u64 {
        let (key, number) = (pairs.key(place), frame.number);
        let Some(state) = pairs.state_of_met(place) else { return WORK_PER_MERGED_PAIR };
        let changed = frame.changed(key);
        if state.completed >= changed || state.is_refuted(changed, number) || !is_plain(key, frame, broad) {
            return WORK_PER_MERGED_PAIR;
        }
        let Some([a, b]) = frame.bodies.pair(key) else { return WORK_PER_MERGED_PAIR };
        self.tests += 1;
        if state.retest([a, b], &a.relative(b), number) {
            self.found.push(key);
        }
        WORK_PER_WITNESS
    }
}

/// Whether all that is asked of a pair is if the bodies meet that it was found for.
fn is_plain(key: PairKey, frame: &Frame, broad: &Broad) -> bool {
    let (bodies, pair) = (frame.bodies, bodies_of(key));
    let is_another = |body| bodies.facts(body).is_another() || broad.is_another(body);
    !bodies.is_special(key) && !bodies.located.has(key) && bodies.may_meet(pair) && !pair.into_iter().any(is_another)
}

/// Whether a frame whose time is limited has such tests: nothing else is.
pub(crate) fn is_due(frame: &Frame) -> bool {
    frame.mode == Mode::Any && frame.budget.work_limit().is_none()
}
