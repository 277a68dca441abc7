//! The pairs of bodies whose fat AABBs overlap, and the states of those that need one.

use super::known::{Known, Slot};
use crate::body::Bodies;
use crate::broad::Broad;
use crate::cost::WORK_PER_STATE;
use crate::id::PairKey;
use crate::pair::bounds::{Bounds, Times};
use crate::pair::frame::Frame;
use crate::pair::state::{PairState, Turn};
use crate::pair::touch::{Touch, Touches};
use crate::room::{Room, reserve};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;
use punctual::clock::ManualClock;
use punctual::engine::Deadline;

/// Beyond this number of pairs, room is made for the maximum at once, so that no frame copies many
/// of them.
const MANY: usize = 8192;

/// Default maximum number of pairs, and its upper limit: places and slots are 32-bit numbers.
const MOST_PAIRS: usize = 1 << 20;
pub(crate) const LIMIT: usize = u32::MAX as usize - 1;

/// Number of tests over which a learned share is averaged.
const TESTS: f32 = 64.0;

/// Progress of the merge of a portion: the next indices in the known pairs and in those found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Merge {
    pub known: usize,
    pub found: usize,
    /// True if some pairs did not fit.
    pub left_out: bool,
}

#[derive(Debug)]
pub(crate) struct Pairs {
    /// Ascending.
    pub(super) known: Vec<Known>,
    /// The merged part of the next list.
    pub(super) merged: Vec<Known>,
    pub(super) merge: Merge,
    /// `None` while the pair of the state is run.
    states: Vec<Option<Box<PairState>>>,
    /// Number of states made in advance, which was paid for. Other states were made on demand;
    /// their number depends on the threads.
    made: usize,
    free: Vec<Slot>,
    pub touches: Touches,
    /// Stands in for the state of a pair without a turn.
    new: PairState,
    /// Room for pairs: for known ones, and for states.
    room: [Room; 2],
    /// Maximum number of pairs.
    pub most: usize,
    /// Shares of the tests in which the witnesses of all pairs still met, and in which the
    /// neighbors of lost ones did; exponentially weighted means.
    pub holds: f32,
    pub nearby: f32,
}

impl Default for Pairs {
    fn default() -> Self {
        Self {
            known: Vec::new(),
            merged: Vec::new(),
            merge: Merge::default(),
            states: Vec::new(),
            made: 0,
            free: Vec::new(),
            touches: Touches::default(),
            new: PairState::new(0),
            room: [Room::default(); 2],
            most: MOST_PAIRS,
            holds: 0.5,
            nearby: 0.5,
        }
    }
}

/// Moves a learned share towards the outcome of a test.
pub(super) fn learn(share: &mut f32, outcome: bool) {
    *share += (f32::from(u8::from(outcome)) - *share) / TESTS;
}

impl Pairs {
    /// Number of known pairs of overlapping fat AABBs.
    pub fn len(&self) -> usize {
        self.merged.len() + self.known.len() - self.merge.known
    }

    /// The known pair at a place, ascending. During a merge, these are the merged pairs, then those
    /// not merged yet.
    pub fn at(&self, place: usize) -> &Known {
        let merged = self.merged.len();
        if place < merged {
            &self.merged[place]
        } else {
            &self.known[place - merged + self.merge.known]
        }
    }

    pub fn at_mut(&mut self, place: usize) -> &mut Known {
        let merged = self.merged.len();
        if place < merged {
            &mut self.merged[place]
        } else {
            &mut self.known[place - merged + self.merge.known]
        }
    }

    pub fn key(&self, place: usize) -> PairKey {
        self.at(place).key
    }

    /// The place of the first pair whose key is not below `key`.
    pub fn place(&self, key: PairKey) -> usize {
        let merged = self.merged.partition_point(|known| known.key < key);
        if merged < self.merged.len() {
            return merged;
        }
        merged + self.known[self.merge.known..].partition_point(|known| known.key < key)
    }

    /// The places of all pairs, from that of a key on and around.
    pub fn from(&self, key: PairKey) -> impl Iterator<Item = usize> + use<> {
        let (known, start) = (self.len(), self.place(key));
        (start..known).chain(0..start)
    }

    /// Records whether the boxes of a pair overlap in `frame`. Returns its record if they do.
    #[inline(always)]
    pub fn overlapping(&mut self, place: usize, overlap: bool, frame: u64) -> Option<&mut Known> {
        if overlap {
            let holds = self.holds;
            let known = self.at_mut(place);
            if !known.overlaps() {
                known.begin(frame, holds);
            }
            return Some(known);
        }
        let slot = self.at_mut(place).end();
        self.release(slot);
        None
    }

    /// The first of these places whose pair met when last decided.
    #[inline]
    pub fn next_met(&self, places: Range<usize>) -> Option<usize> {
        let split = self.merged.len();
        if split <= places.start {
            let known = &self.known[self.merge.known..][places.start - split..places.end - split];
            return known
                .iter()
                .position(Known::met)
                .map(|at| places.start + at);
        }
        let merged = &self.merged[places.start.min(split)..places.end.min(split)];
        let known = &self.known[self.merge.known..]
            [places.start.max(split) - split..places.end.max(split) - split];
        merged
            .iter()
            .chain(known)
            .position(Known::met)
            .map(|at| places.start + at)
    }

    /// The state of a pair whose boxes overlap.
    #[inline]
    pub fn state(&mut self, place: usize, frame: &Frame) -> &mut PairState {
        self.state_of(*self.at(place), frame)
    }

    #[inline]
    pub fn state_of(&mut self, known: Known, frame: &Frame) -> &mut PairState {
        let state = known
            .slot
            .and_then(|slot| self.states[slot.place()].as_deref_mut());
        let state = match state {
            Some(state) => state,
            None => {
                self.new = known.new_state(frame.number);
                &mut self.new
            }
        };
        known.update(state, frame.bodies, frame.number);
        state
    }

    /// Updates the entry of a pair from its state, which was updated in `frame`.
    pub fn note(&mut self, place: usize, frame: u64) {
        let mut known = *self.at(place);
        if let Some(state) = known
            .slot
            .and_then(|slot| self.states[slot.place()].as_ref())
        {
            known.note(state, frame);
            *self.at_mut(place) = known;
        }
    }

    /// Takes the state of a pair out for a turn, with its entry, which must [update](Known::update)
    /// the state first. A pair without a state gets one.
    #[inline]
    pub fn take(&mut self, place: usize, frame: u64) -> Turn {
        let slot = self.at(place).slot;
        let state = slot.and_then(|slot| self.states[slot.place()].take());
        let state = state.unwrap_or_else(|| self.new_state(place, frame));
        Turn::new(*self.at(place), state)
    }

    #[cold]
    fn new_state(&mut self, place: usize, frame: u64) -> Box<PairState> {
        let slot = self.free.pop().unwrap_or_else(|| {
            self.states.push(None);
            Slot::new(self.states.len() - 1)
        });
        let known = self.at_mut(place);
        known.slot = Some(slot);
        let new = known.new_state(frame);
        match self.states[slot.place()].take() {
            Some(mut state) => {
                *state = new;
                state
            }
            None => Box::new(new),
        }
    }

    /// Frees the state in a slot, if there is one.
    #[inline]
    pub(super) fn release(&mut self, slot: Option<Slot>) {
        let Some(slot) = slot else { return };
        self.free.push(slot);
        let state = if self.touches.any() {
            self.states[slot.place()].as_mut()
        } else {
            None
        };
        if let Some(touch) = state.and_then(|state| state.touch.take()) {
            self.touches.take_back(touch);
        }
    }

    /// How far the bodies of a pair may move, margins excluded, before they may meet
    /// ([`Known::room`]), and the last frame that finished the pair. If they were found to meet
    /// since, it is negative: how deep they may have sunk in.
    pub fn apart(&self, key: PairKey, bodies: &Bodies, frame: u64) -> Option<(f64, u64)> {
        let known = self.find(key)?;
        let since = known.since(frame);
        let room = known.room(bodies, frame).or_else(|| {
            let state = self.state_at(key)?;
            let gone = || bodies.gone(key, state.completed, frame);
            (state.apart > 0.0).then(|| state.apart - gone())
        });
        Some((room?, since))
    }

    /// The contact state of a pair.
    pub fn touch(&self, key: PairKey) -> Option<&Touch> {
        self.state_at(key)?.touch.as_deref()
    }

    /// Makes room for the contacts of all pairs that there is room for.
    pub fn reserve_touches(&mut self) {
        self.touches.ask(self.room[1].asked);
    }

    /// Puts a state back, with its entry.
    #[inline]
    pub fn put_back(&mut self, place: usize, state: Box<PairState>, known: Known) {
        *self.at_mut(place) = known;
        if let Some(slot) = known.slot {
            self.states[slot.place()] = Some(state);
        }
    }

    /// Number of pairs with overlapping boxes that there is room for.
    pub fn room(&self) -> usize {
        self.room[1].pairs
    }

    /// Makes room for this many pairs whose fat AABBs overlap, and for their states.
    pub fn reserve(&mut self, broad: &mut Broad, most: usize) {
        self.room.iter_mut().for_each(|room| room.ask(most));
        if self.touches.any() {
            self.touches.ask(most);
        }
        self.reserve_known(broad);
        self.reserve_states(&mut Deadline::at(None, u64::MAX, &ManualClock::new()));
    }

    /// Inserts pairs whose distances are measured, wherever their bodies are, in addition to those
    /// that there is room for. They must ascend.
    pub fn insert(&mut self, keys: &[PairKey]) {
        let is_merged = |&key: &PairKey| self.merged.last().is_some_and(|last| key <= last.key);
        let (to_merged, to_known) = keys.split_at(keys.partition_point(is_merged));
        insert(&mut self.merged, 0, to_merged);
        insert(&mut self.known, self.merge.known, to_known);
    }

    /// The bounds proven for a pair last: [`PairState::proven`].
    pub fn proven(&self, key: PairKey) -> Option<(Bounds, u64, Times)> {
        self.state_at(key).map(PairState::proven)
    }

    fn find(&self, key: PairKey) -> Option<&Known> {
        let place = self.place(key);
        let known = (place < self.len()).then(|| self.at(place));
        known.filter(|known| known.key == key)
    }

    fn state_at(&self, key: PairKey) -> Option<&PairState> {
        let known = self.find(key).filter(|known| known.overlaps())?;
        self.states[known.slot?.place()].as_deref()
    }

    /// Makes room for the known pairs, for the states of `overlapping` pairs, and for the contacts
    /// of `near` pairs; for more if the scene is `young`.
    pub fn grow(
        &mut self,
        broad: &mut Broad,
        [overlapping, near]: [usize; 2],
        young: bool,
        deadline: &mut Deadline,
    ) {
        self.grow_known(broad, young);
        self.room[1].grow(overlapping, young);
        self.reserve_states(deadline);
        self.touches.grow(near, young, deadline);
    }

    /// Makes room for more known pairs than there are; for still more if the scene is `young`.
    pub fn grow_known(&mut self, broad: &mut Broad, young: bool) {
        let (used, [room, _]) = (self.len(), &mut self.room);
        let before = room.pairs;
        room.grow(used, young);
        if room.pairs > before.max(MANY) {
            // Growing later would copy them; untouched memory costs almost nothing.
            room.ask(self.most.min(room.pairs.max(MOST_PAIRS)));
        }
        self.reserve_known(broad);
    }

    fn reserve_known(&mut self, broad: &mut Broad) {
        let most = self.room[0].pairs;
        broad.reserve_found(most);
        reserve(&mut self.known, most);
        reserve(&mut self.merged, most);
    }

    fn reserve_states(&mut self, deadline: &mut Deadline) {
        let most = self.room[1].pairs;
        reserve(&mut self.states, most);
        reserve(&mut self.free, most);
        while self.made < most && deadline.has_room(WORK_PER_STATE) {
            deadline.spend(WORK_PER_STATE);
            self.made += 1;
            if self.states.len() < self.made {
                self.free.push(Slot::new(self.states.len()));
                self.states.push(Some(Box::new(PairState::new(0))));
            }
        }
    }
}

/// Inserts pairs into the part of a list from a place on. Pairs that are already in it stay.
fn insert(list: &mut Vec<Known>, from: usize, keys: &[PairKey]) {
    list.extend(keys.iter().map(|&key| Known::new(key)));
    list[from..].sort_by_key(|known| known.key);
    list.dedup_by_key(|known| known.key);
}
