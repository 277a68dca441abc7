//! What is kept about two bodies while their boxes overlap, once a query had its turn.

use super::id::PairKey;
use crate::model::calibration::Calibration;
use crate::model::cost::WORK_PER_WITNESS;
use crate::query::{PairMemory, StopReason, Verdict, Workspace};
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

/// What is kept about two bodies as long as their boxes overlap, from their first turn on.
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
    pub fn new(frame: u64) -> Self {
        Self {
            memory: PairMemory::without_clearance(),
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

    /// Whether no query of it was ever begun, so that it says no more than [`PairState::new`].
    pub fn is_blank(&self) -> bool {
        (self.completed, self.refuted, self.search, self.pending.work) == (0, 0, 0, 0)
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
