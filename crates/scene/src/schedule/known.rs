//! A compact record of every pair of near bodies: a frame reads all of them, and the states of
//! those that have a turn.

use crate::body::{Bodies, triangle_ids};
use crate::cost::{LEAST_WORK, WORK_PER_QUERY, WORK_PER_ROOT_TEST, WORK_PER_WITNESS};
use crate::id::PairKey;
use crate::pair::apart::{LONG_SEARCH, reach, until};
use crate::pair::question::Question;
use crate::pair::spent::{Spent, capped};
use crate::pair::state::{NO_TRIANGLES, PairState};
use core::num::NonZeroU32;
use punctual::engine::{Deadline, root_test};
use punctual::intersection::Operand;
use punctual::prediction::MAX_STEP_WORK;
use punctual::{Query, Verdict, Workspace};

/// A test of a witness must be expected to save this many times its cost.
const MARGIN_OF_TESTS: f32 = 1.2;

/// Number of tests over which the steadiness of a pair is averaged.
const TESTS_OF_STEADINESS: i16 = 4;

/// The index of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot(NonZeroU32);

impl Slot {
    /// `place` must be below `u32::MAX`.
    pub fn new(place: usize) -> Self {
        Self(NonZeroU32::MIN.saturating_add(place as u32))
    }

    pub fn place(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// Two bodies whose fat AABBs overlap: all that a frame reads of a pair before its turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub key: PairKey,
    /// For a pair that met, the two triangles that intersected last (tree order). For others, the
    /// bits of [`Known::apart`].
    proof: u64,
    /// The index of its state; `None` before the first turn of the pair since its boxes overlap.
    pub slot: Option<Slot>,
    /// Low bits of a frame: the last that finished the pair, or, if none has, the one before its
    /// boxes overlapped.
    since: u32,
    /// Expected work of a search; 0 if there was none yet.
    pub cost: u32,
    /// Share of the tests of its latest witnesses in which they still met, in parts of 255;
    /// exponentially weighted mean.
    steadiness: u8,
    /// [`OVERLAPS`], [`DECIDED`], [`MET`], [`LOST`], [`ESTIMATED`], [`HOT`].
    flags: u8,
}

/// In place of a witness where one body is inside the other.
const INSIDE: [(Operand, [u32; 2]); 2] = [(Operand::A, [u32::MAX, 0]), (Operand::B, [u32::MAX, 1])];

/// Flags of a pair: the boxes overlap; it was decided; the bodies met when last decided; their
/// witnesses were lost since; estimates of it were reported; it is ranked before others.
const OVERLAPS: u8 = 1;
const DECIDED: u8 = 2;
const MET: u8 = 4;
const LOST: u8 = 8;
const ESTIMATED: u8 = 16;
const HOT: u8 = 32;

const _: () = assert!(size_of::<Known>() == 32);

impl Known {
    /// A pair whose boxes were not compared yet.
    pub fn new(key: PairKey) -> Self {
        Self {
            key,
            proof: 0,
            slot: None,
            since: 0,
            cost: 0,
            steadiness: 0,
            flags: HOT,
        }
    }

    /// Records that the boxes overlap from `frame` on. `steadiness`: that of other pairs.
    pub fn begin(&mut self, frame: u64, steadiness: f32) {
        self.flags |= OVERLAPS;
        self.since = (frame as u32).wrapping_sub(1);
        self.steadiness = (steadiness * 255.0) as u8;
    }

    /// Records that the boxes are separated, and returns the state's slot.
    pub fn end(&mut self) -> Option<Slot> {
        let slot = self.slot;
        *self = Self::new(self.key);
        slot
    }

    fn is(&self, flags: u8) -> bool {
        self.flags & flags == flags
    }

    /// True if the boxes overlapped when last compared.
    pub fn overlaps(&self) -> bool {
        self.is(OVERLAPS)
    }

    /// The last frame that finished it, correct if it is less than 2^32 frames before `frame`.
    pub fn since(&self, frame: u64) -> u64 {
        frame - u64::from((frame as u32).wrapping_sub(self.since))
    }

    /// A new state of the pair, to be [updated](Known::update) what this entry has recorded.
    pub fn new_state(&self, frame: u64) -> PairState {
        PairState::new(match self.is_decided() {
            true => 0,
            false => self.since(frame),
        })
    }

    /// Stores the summary of a state that was updated in `frame`.
    pub fn note(&mut self, state: &PairState, frame: u64) {
        let kept = if state.decided == frame {
            HOT
        } else {
            HOT | LOST
        };
        let estimated = if state.has_estimates() { ESTIMATED } else { 0 };
        (self.cost, self.flags) = (state.cost(), OVERLAPS | self.flags & kept | estimated);
        if state.met() || state.completed > 0 {
            self.since = state.completed as u32;
        }
        if state.verdict != Verdict::Undecided {
            self.flags |= DECIDED;
        }
        if state.met() {
            let [x, y] = state.witness().unwrap_or(NO_TRIANGLES);
            self.flags |= MET;
            self.proof = u64::from(x) << 32 | u64::from(y);
        } else {
            self.proof = state.apart.to_bits();
        }
    }

    /// Share of the tests of its witnesses in which they still met.
    pub fn steadiness(&self) -> f32 {
        f32::from(self.steadiness) / 255.0
    }

    /// Updates the state with what the list has recorded here since the last turn. `frame` is the
    /// current frame.
    #[inline]
    pub fn update(&self, state: &mut PairState, bodies: &Bodies, frame: u64) {
        let since = self.since(frame);
        if since <= state.decided || !self.is_decided() {
            return;
        }
        let Some(verdict) = self.verdict(bodies) else {
            return;
        };
        if self.met() || self.apart() == 0.0 {
            state.search = self.cost;
        }
        state.apart = if self.met() { 0.0 } else { self.apart() };
        let is_witnessed = verdict.witness().is_some();
        state.memory.decide(is_witnessed.then(|| self.witness()));
        state.finish(verdict, u64::from(is_witnessed), since);
    }

    /// The verdict that it proves; `None` if its witness does not exist.
    fn verdict(&self, bodies: &Bodies) -> Option<Verdict> {
        if !self.met() {
            return Some(Verdict::Separated);
        }
        let inside = INSIDE.iter().find(|(_, sign)| *sign == self.witness());
        if let Some(&(inner, _)) = inside {
            return Some(Verdict::Contained { inner });
        }
        let witness = triangle_ids(bodies.pair(self.key)?, self.witness())?;
        Some(Verdict::Intersecting { witness })
    }

    /// For a pair that did not meet: the bodies are separated until the sum of their displacements
    /// reaches this; 0 proves nothing.
    fn apart(&self) -> f64 {
        f64::from_bits(self.proof)
    }

    /// The triangles of a pair that met last.
    pub fn witness(&self) -> [u32; 2] {
        [(self.proof >> 32) as u32, self.proof as u32]
    }

    /// Records that these triangles (tree order) meet in `frame`: those that met last, or their
    /// neighbors.
    pub fn hold(&mut self, witness: [u32; 2], frame: u64) {
        self.learn_steadiness(u8::MAX);
        self.meet(witness, frame);
    }

    /// Records that the triangles that met last no longer do.
    pub fn lose(&mut self) {
        self.learn_steadiness(0);
        self.flags |= LOST;
    }

    fn learn_steadiness(&mut self, test: u8) {
        let difference = i16::from(test) - i16::from(self.steadiness);
        let step = difference / TESTS_OF_STEADINESS + difference.signum();
        self.steadiness = (i16::from(self.steadiness) + step).clamp(0, 255) as u8;
    }

    /// Records that these triangles (tree order) meet in `frame`.
    fn meet(&mut self, [x, y]: [u32; 2], frame: u64) {
        self.flags = self.flags & HOT | OVERLAPS | DECIDED | MET;
        self.proof = u64::from(x) << 32 | u64::from(y);
        self.since = frame as u32;
    }

    /// Finds out whether a [bare](Known::is_bare) pair meets: all that this reads and writes of it
    /// is this entry. `to_the_end`: the search is expected to finish.
    pub fn search(
        &mut self,
        bodies: &Bodies,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
        to_the_end: bool,
        frame: u64,
    ) -> (Verdict, Spent) {
        let pair = bodies.pair(self.key);
        let Some([a, b]) = pair.filter(|_| deadline.has_room(LEAST_WORK)) else {
            return (Verdict::Undecided, Spent::default());
        };
        let (trees, b_in_a) = ([&*a.body.tree, &*b.body.tree], a.relative(b));
        let mut tested = 0;
        if !self.met() && self.cost <= LONG_SEARCH {
            tested = WORK_PER_ROOT_TEST;
            deadline.spend(tested);
            let low = root_test::distance(trees, &b_in_a, workspace);
            if low > 0.0 {
                self.part(until(bodies, self.key, [a, b], low, frame), frame);
                self.cost = capped(MAX_STEP_WORK);
                let (work, bv_tests) = (tested, 0);
                return (Verdict::Separated, Spent { work, bv_tests });
            }
        }
        let query = Query::intersection(trees[0], trees[1], b_in_a);
        workspace.forget_run();
        deadline.spend(WORK_PER_QUERY);
        let (answer, _) = Question::Meet(query).advance(workspace, None, deadline, to_the_end);
        let mut spent = Spent::of(workspace);
        if answer.stop.is_final() {
            self.cost = capped(spent.work.max(MAX_STEP_WORK));
            if answer.verdict == Verdict::Separated {
                self.part(0.0, frame);
            } else {
                let is_inside =
                    |&&(inner, _): &&(_, _)| answer.verdict == Verdict::Contained { inner };
                let inside = INSIDE.iter().find(is_inside).map(|&(_, sign)| sign);
                let witness = inside.or(workspace.witness()).unwrap_or(NO_TRIANGLES);
                self.meet(witness, frame);
            }
        } else {
            self.cost = self.cost.max(capped(2 * spent.work));
        }
        spent.work += WORK_PER_QUERY + tested;
        (answer.verdict, spent)
    }

    /// Records that the bodies are separated in `frame`, until the sum of their displacements
    /// reaches `until`.
    fn part(&mut self, until: f64, frame: u64) {
        (self.proof, self.since) = (until.max(0.0).to_bits(), frame as u32);
        self.flags = self.flags & HOT | OVERLAPS | DECIDED;
    }

    /// How far the bodies may move before they may meet; negative if they have moved farther since
    /// they were proven apart. `None` if they were not when last decided, or nothing is known.
    #[inline]
    pub fn room(&self, bodies: &Bodies, frame: u64) -> Option<f64> {
        let until = if self.met() { 0.0 } else { self.apart() };
        (until > 0.0).then(|| until - bodies.gone(self.key, self.since(frame), frame))
    }

    /// True if the bodies are known to be separated in `frame` because they have not moved far.
    /// Then records it.
    #[inline]
    pub fn stays_apart(&mut self, bodies: &Bodies, frame: u64) -> bool {
        let stays = self.room(bodies, frame).is_some_and(|room| room > 0.0);
        if stays {
            self.stay(frame);
        }
        stays
    }

    /// True if `frame` finished the pair.
    pub fn is_completed(&self, frame: u64) -> bool {
        self.since == frame as u32
    }

    /// True if the pair met when last decided.
    pub fn met(&self) -> bool {
        self.is(MET)
    }

    /// True if a test of its witness is expected to cost more than it saves.
    pub fn is_fickle(&self) -> bool {
        let saved = self.steadiness() * (self.cost as f32 + WORK_PER_QUERY as f32);
        saved < MARGIN_OF_TESTS * WORK_PER_WITNESS as f32
    }

    /// True if it was decided since its boxes overlap.
    pub fn is_decided(&self) -> bool {
        self.is(DECIDED)
    }

    /// Forgets that probabilities of it were reported. True if they were.
    pub fn forget_estimates(&mut self) -> bool {
        let had = self.is(ESTIMATED);
        self.flags &= !ESTIMATED;
        had
    }

    /// Records that what finished it still holds in `frame`.
    pub fn stay(&mut self, frame: u64) {
        self.since = frame as u32;
    }

    /// True if it is ranked in each frame, as pairs that met always are; others take turns.
    pub fn is_hot(&self) -> bool {
        self.flags & (HOT | MET) != 0
    }

    pub fn set_hot(&mut self, is_hot: bool) {
        self.flags = self.flags & !HOT | if is_hot { HOT } else { 0 };
    }

    /// True if [`Known::search`] is the best way to answer all questions of the pair: no estimates
    /// of it were reported, it is not special, and nothing in its state is likely to prove it apart
    /// at less cost or for longer.
    pub fn is_bare(&self, bodies: &Bodies, frame: u64) -> bool {
        let is_slow = |pair| reach(bodies, self.key, pair, frame).is_some();
        let is_simple = || {
            self.met()
                || !self.is_decided()
                || self.cost <= LONG_SEARCH && !bodies.pair(self.key).is_some_and(is_slow)
        };
        let is_special = bodies.has_special && bodies.is_special(self.key);
        !self.is(ESTIMATED) && !is_special && is_simple()
    }

    /// True if its witnesses were lost since then.
    pub fn is_lost(&self) -> bool {
        self.is(LOST)
    }
}
