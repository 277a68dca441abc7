//! A chain: pairs that are run one after the other, each to its end, within one budget of work.
//!
//! Chains are what threads share out among themselves. What comes of a chain depends on nothing outside it, so under a budget
//! of work it does not matter which thread runs it, or when.

use super::body::Bodies;
use super::guard::Guard;
use super::pairs::{Key, Track, bodies};
use crate::math::Pose;
use crate::query::{Budget, Clock, MAX_STEP_WORK, Mode, Query, StopReason, Workspace};
use crate::tree::Tree;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;

/// Work that counts for setting up the query of a pair, about what it takes.
pub(super) const WORK_PER_PAIR: u64 = 250;

/// Work that counts for testing the last witness of a pair, set-up included.
pub(super) const WORK_PER_WITNESS: u64 = 120;

/// The least that is of use: the set-up of a pair and one step.
pub(super) const LEAST: u64 = WORK_PER_PAIR + MAX_STEP_WORK;

/// Room for queued node pairs in the workspaces of a scene, and for found pairs, which are only counted.
const QUEUE: usize = 1024;
const FOUND: usize = 1024;

pub(super) fn workspace() -> Box<Workspace> {
    Box::new(Workspace::with_capacity(QUEUE, FOUND))
}

/// The query of a pair; a stopped one is found again by the same. A query that will get to its end needs no queue.
pub(super) fn query<'t>([a, b]: [&'t Tree; 2], b_in_a: Pose, mode: Mode, to_the_end: bool) -> Query<'t> {
    let query = Query::new(a, b, b_in_a).mode(mode);
    if to_the_end { query.grain(f32::INFINITY) } else { query }
}

/// What all chains of a round have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    pub frame: u64,
    pub mode: Mode,
    /// Whether all pairs are expected to get to their ends.
    pub to_the_end: bool,
    /// Whether pairs get no more than the test of their last witness.
    pub witnesses_only: bool,
    pub deadline: Option<Duration>,
}

/// A pair in a chain.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub key: Key,
    /// Its place in the report, and that of its track.
    pub place: u32,
    pub slot: u32,
    /// Its number among the tasks.
    pub task: u32,
    /// Work that it will take, as far as is known.
    pub expected: u64,
    /// Whether its last witness is likely to decide it, and has not been tested yet.
    pub witnessed: bool,
    pub track: Box<Track>,
    /// Work and BV tests of this round.
    pub spent: [u64; 2],
}

/// Pairs with a budget for all of them.
#[derive(Debug, Default)]
pub(super) struct Chain {
    pub items: Vec<Item>,
    pub budget: u64,
    /// The pair whose run was stopped by the end of the budget, and whether it had been expected to get to its end; the run
    /// is in the workspace.
    pub held: Option<(Key, bool)>,
    workspace: Option<Box<Workspace>>,
}

impl Chain {
    /// A chain with a workspace, so that no frame has to allocate one.
    pub fn new() -> Self {
        Self { workspace: Some(workspace()), ..Self::default() }
    }

    /// The stopped run, if there is one, and the pair that it is of.
    pub fn stopped(&self) -> Option<(Key, bool, &Workspace)> {
        let (key, to_the_end) = self.held?;
        Some((key, to_the_end, self.workspace.as_deref()?))
    }

    /// The stopped run of a pair, if it is this chain that keeps it.
    pub fn held(&self, key: Key) -> Option<(bool, &Workspace)> {
        let (_, to_the_end, workspace) = self.stopped().filter(|&(held, ..)| held == key)?;
        Some((to_the_end, workspace))
    }

    /// Changes stopped runs with another chain.
    pub fn swap_held(&mut self, other: &mut Self) {
        mem::swap(&mut self.held, &mut other.held);
        mem::swap(&mut self.workspace, &mut other.workspace);
    }

    /// Runs what fits. `scratch` is a workspace of the thread at hand.
    pub fn run<C: Clock>(&mut self, bodies: &Bodies, scratch: &mut Box<Workspace>, round: &Round, clock: &C) {
        let mut guard = Guard::new(clock, round.deadline);
        let mut left = self.budget;
        for (item, at) in self.items.iter_mut().zip(0..) {
            let least = if round.witnesses_only { WORK_PER_WITNESS } else { LEAST };
            if left < least || guard.is_over() {
                break;
            }
            if at > 0 && item.expected > left {
                // The next round has room for it, and those after it do not go first.
                break;
            }
            let held = self.held.filter(|&(key, _)| key == item.key);
            let to_the_end = held.map_or(round.to_the_end, |(_, to_the_end)| to_the_end);
            let kept = self.workspace.as_mut().filter(|_| held.is_some());
            let run = Run { to_the_end, resumes: kept.is_some(), left, round };
            let ended = item.run(bodies, kept.unwrap_or(scratch), run, &mut guard);
            left = left.saturating_sub(item.spent[0]);
            match ended {
                Ended::Complete if held.is_some() => self.held = None,
                Ended::Stopped if held.is_none() => {
                    self.held = Some((item.key, to_the_end));
                    mem::swap(self.workspace.get_or_insert_with(workspace), scratch);
                }
                _ => {}
            }
        }
    }
}

/// One run of a pair.
struct Run<'r> {
    to_the_end: bool,
    /// Whether the workspace may have a stopped run of it.
    resumes: bool,
    left: u64,
    round: &'r Round,
}

/// How far a pair got.
#[derive(Clone, Copy, PartialEq)]
enum Ended {
    Complete,
    Stopped,
    NotBegun,
}

impl Item {
    fn run<C: Clock>(
        &mut self,
        bodies: &Bodies,
        workspace: &mut Workspace,
        mut run: Run,
        guard: &mut Guard<'_, C>,
    ) -> Ended {
        let [a, b] = self::bodies(self.key).map(|body| bodies.at(body));
        let (Some(a), Some(b)) = (a, b) else { return Ended::NotBegun };
        let b_in_a = a.relative(b);
        let (a, b, round) = (&a.body.tree, &b.body.tree, run.round);
        if self.witnessed && !run.resumes {
            if guard.allow(WORK_PER_WITNESS).is_none() {
                return Ended::NotBegun;
            }
            self.witnessed = false;
            self.spent[0] += WORK_PER_WITNESS;
            guard.spend(WORK_PER_WITNESS);
            if let Some(witness) = self.track.memory.recheck(a, b, &b_in_a) {
                self.track.meets(witness, round.frame);
                return Ended::Complete;
            }
            self.track.refuted = round.frame;
        }
        if round.witnesses_only {
            return Ended::NotBegun;
        }
        let query = query([a, b], b_in_a, round.mode, run.to_the_end);
        let clock = guard.clock();
        let mut ended = Ended::NotBegun;
        loop {
            let left = run.left.saturating_sub(self.spent[0]);
            let Some(allowed) = guard.allow(left).filter(|&work| work >= LEAST) else { return ended };
            let budget = Budget::work(allowed - LEAST + 1);
            let memory = &mut self.track.memory;
            let mut resume = || query.resume_with(workspace, Some(&mut *memory), budget, clock).ok();
            let resumed = if run.resumes { resume() } else { None };
            let before = if resumed.is_some() { self.track.pending } else { [0; 2] };
            let outcome = match resumed {
                Some(outcome) => outcome,
                None => query.run_with(workspace, Some(memory), budget, clock),
            };
            run.resumes = true;
            let work = outcome.stats.work - before[0] + WORK_PER_PAIR;
            self.spent[0] += work;
            self.spent[1] += outcome.stats.bv_tests - before[1];
            guard.spend(work);
            if self.track.note(&outcome, round.frame) {
                return Ended::Complete;
            }
            ended = Ended::Stopped;
            if outcome.stop == StopReason::PairsFull {
                workspace.drain_pairs().for_each(drop);
            }
        }
    }
}
