//! The pairs of bodies whose fat AABBs overlap, and what is kept about those whose boxes do.

use super::body::{Bodies, Change};
use super::broad::Broad;
use super::id::{PairKey, bodies_of};
use super::room::{Room, reserve};
use crate::model::calibration::Calibration;
use crate::model::cost::WORK_PER_WITNESS;
use crate::query::{PairMemory, StopReason, Verdict, Workspace};
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;

/// Work and BV tests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spent {
    pub work: u64,
    pub bv_tests: u64,
}

impl Spent {
    /// All that the query in a workspace has done.
    pub fn of(workspace: &Workspace) -> Self {
        Self { work: workspace.work(), bv_tests: workspace.bv_tests() }
    }

    pub fn add(&mut self, other: Self) {
        self.work += other.work;
        self.bv_tests += other.bv_tests;
    }

    pub fn since(self, before: Self) -> Self {
        Self { work: self.work - before.work, bv_tests: self.bv_tests - before.bv_tests }
    }
}

/// Most estimates of a pair that are kept until their truth comes out.
const TOLD: usize = 8;

/// The turn of a pair in a batch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turn {
    pub key: PairKey,
    /// The place of its job among those of the frame.
    pub index: u32,
    /// Work that it is expected to take.
    pub median: u64,
    /// Whether its last witness is likely to decide it, and has not been tested yet.
    pub witnessed: bool,
    pub spent: Spent,
}

/// What is kept about two bodies as long as their boxes overlap.
#[derive(Clone, Debug)]
pub(super) struct PairState {
    pub memory: PairMemory,
    /// What the last frame that decided it found.
    pub verdict: Verdict,
    pub found: u64,
    /// The last frame that ran it to its end; 0 if none did.
    pub completed: u64,
    /// The last frame that decided it; before, the one before the first.
    pub decided: u64,
    /// The last frame in which its last witnesses were tested and did not meet.
    pub refuted: u64,
    /// Work of the last run to the end; 0 if there was none.
    pub cost: u64,
    /// Work of the last run that no remembered witness cut short; a lower bound while that run is unfinished.
    pub search: u64,
    /// What the run that is not at its end has spent.
    pub pending: Spent,
    /// Probabilities that estimates told of the bodies as they are, until their truth comes out.
    pub told: ArrayVec<f64, TOLD>,
    /// While it is in a batch.
    pub turn: Turn,
}

impl PairState {
    /// Of a pair that overlaps for the first time in `frame`.
    fn new(frame: u64) -> Self {
        Self {
            memory: PairMemory::new(),
            verdict: Verdict::Undecided,
            found: 0,
            completed: 0,
            decided: frame - 1,
            refuted: 0,
            cost: 0,
            search: 0,
            pending: Spent::default(),
            told: ArrayVec::new(),
            turn: Turn::default(),
        }
    }

    /// Teaches what was told, if `frame` has decided the pair.
    pub fn teach(&mut self, calibration: &mut Calibration, frame: u64) {
        if self.decided == frame {
            let met = self.verdict != Verdict::Separated;
            self.told.drain(..).for_each(|told| calibration.learn(told, met));
        }
    }

    /// Takes note of a witness that still meets in `frame`.
    pub fn meets(&mut self, witness: [u32; 2], frame: u64) {
        (self.decided, self.completed, self.cost, self.pending) = (frame, frame, WORK_PER_WITNESS, Spent::default());
        (self.verdict, self.found) = (Verdict::Intersecting { witness }, 1);
    }

    /// Takes note of a call in `frame` that ended for this reason; whether the run is over.
    pub fn note(&mut self, workspace: &Workspace, stop: StopReason, frame: u64) -> bool {
        let spent = Spent::of(workspace);
        if stop.is_final() {
            (self.completed, self.cost, self.pending) = (frame, spent.work, Spent::default());
            if spent.bv_tests > 0 {
                self.search = spent.work;
            }
        } else {
            self.search = self.search.max(2 * spent.work);
            self.pending = spent;
        }
        let verdict = workspace.verdict(stop);
        if verdict != Verdict::Undecided {
            (self.decided, self.verdict, self.found) = (frame, verdict, workspace.found());
        }
        stop.is_final()
    }
}

/// The slot of a pair whose boxes are apart, and of one whose boxes overlap since this frame.
const NONE: u32 = u32::MAX;
const NEW: u32 = u32::MAX - 1;

/// Two bodies whose fat AABBs overlap, and where the state of those is whose boxes do.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    key: PairKey,
    slot: u32,
}

#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Ascending.
    candidates: Vec<Candidate>,
    merged: Vec<Candidate>,
    /// A state is away while its pair is run.
    states: Vec<Option<Box<PairState>>>,
    free: Vec<u32>,
    /// Pairs that there is room for: candidates, and states.
    room: [Room; 2],
}

impl Pairs {
    pub fn state(&mut self, slot: u32) -> Option<&mut PairState> {
        self.states[slot as usize].as_deref_mut()
    }

    /// Takes a state out.
    pub fn take(&mut self, slot: u32) -> Option<Box<PairState>> {
        self.states[slot as usize].take()
    }

    pub fn put_back(&mut self, slot: u32, state: Box<PairState>) {
        self.states[slot as usize] = Some(state);
    }

    /// Pairs whose fat AABBs overlap.
    pub fn candidates(&self) -> usize {
        self.candidates.len()
    }

    /// One of them, in ascending order, and the slot of its state; `None` if their boxes are apart in this frame.
    pub fn overlapping(&self, candidate: usize) -> Option<(PairKey, u32)> {
        let Candidate { key, slot } = self.candidates[candidate];
        (slot != NONE).then_some((key, slot))
    }

    /// Pairs whose boxes overlap that there is room for.
    pub fn room(&self) -> usize {
        self.room[1].pairs
    }

    /// Makes room for this many pairs whose fat AABBs overlap.
    pub fn reserve(&mut self, broad: &mut Broad, most: usize) {
        self.room.iter_mut().for_each(|room| room.ask(most));
        self.make_room(broad);
    }

    /// Finds the pairs whose boxes overlap in `frame`.
    pub fn update(&mut self, broad: &mut Broad, bodies: &Bodies, frame: u64) {
        broad.update(bodies);
        self.merge(broad);
        let mut overlapping = 0;
        for Candidate { key, slot } in &mut self.candidates {
            let [a, b] = bodies_of(*key);
            if broad.bounds(a).intersects(broad.bounds(b)) {
                overlapping += 1;
                if *slot == NONE {
                    *slot = NEW;
                }
            } else if *slot != NONE {
                self.free.push(*slot);
                *slot = NONE;
            }
        }
        broad.forget_news();
        let young = bodies.is_young(frame);
        self.room[0].grow(self.candidates.len(), young);
        self.room[1].grow(overlapping, young);
        self.make_room(broad);
        for candidate in self.candidates.iter_mut().filter(|candidate| candidate.slot == NEW) {
            candidate.slot = new_state(&mut self.states, &mut self.free, frame);
        }
    }

    fn make_room(&mut self, broad: &mut Broad) {
        let [candidates, states] = self.room.map(|room| room.pairs);
        broad.reserve_found(candidates);
        reserve(&mut self.candidates, candidates);
        reserve(&mut self.merged, candidates);
        reserve(&mut self.states, states);
        reserve(&mut self.free, states);
        let new = self.states.len()..states;
        self.free.extend(new.clone().rev().map(|slot| slot as u32));
        self.states.extend(new.map(|_| Some(Box::new(PairState::new(1)))));
    }

    /// Replaces the candidates that have a body with news by those found now.
    fn merge(&mut self, broad: &Broad) {
        if !broad.has_news() {
            return;
        }
        let mut found = broad.found().iter().copied().peekable();
        self.merged.clear();
        for &candidate in &self.candidates {
            while let Some(key) = found.next_if(|&key| key < candidate.key) {
                self.merged.push(Candidate { key, slot: NONE });
            }
            let again = found.next_if_eq(&candidate.key).is_some();
            let [a, b] = bodies_of(candidate.key);
            match broad.news(a).max(broad.news(b)) {
                Change::None => self.merged.push(candidate),
                Change::Place if again => self.merged.push(candidate),
                news => {
                    if candidate.slot != NONE {
                        self.free.push(candidate.slot);
                    }
                    if again && news == Change::Body {
                        self.merged.push(Candidate { key: candidate.key, slot: NONE });
                    }
                }
            }
        }
        self.merged.extend(found.map(|key| Candidate { key, slot: NONE }));
        core::mem::swap(&mut self.candidates, &mut self.merged);
    }
}

/// A slot with a new state; those of pairs that are apart are used again.
fn new_state(states: &mut Vec<Option<Box<PairState>>>, free: &mut Vec<u32>, frame: u64) -> u32 {
    let slot = free.pop().unwrap_or_else(|| {
        states.push(None);
        states.len() as u32 - 1
    });
    match &mut states[slot as usize] {
        Some(state) => **state = PairState::new(frame),
        empty => *empty = Some(Box::new(PairState::new(frame))),
    }
    slot
}
