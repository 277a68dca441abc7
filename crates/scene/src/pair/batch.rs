//! A batch: pairs that are run one after another, each to its end, within one deadline.
//!
//! Threads share the batches among themselves. The result of a batch depends on nothing outside it.
//! So under a budget of work it does not matter which thread runs it, or when.

use super::question::{Answer, Question};
use super::spent::Spent;
use super::state::{Standing, Turn};
use super::touch::MOST_CONTACTS;
use crate::ask::TurnKind;
use crate::body::{Bodies, Placed};
use crate::cost::{LEAST_WORK, WORK_PER_QUERY};
use crate::id::PairKey;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Clock, Mode, StopReason, Verdict, Workspace};
use punctual_geom::Pose;

/// Capacity for queued node pairs in the workspaces of a scene, and for found pairs, which are only
/// counted.
const QUEUE: usize = 1024;
const FOUND: usize = 1024;

pub(crate) fn workspace() -> Box<Workspace> {
    let mut workspace = Box::new(Workspace::with_capacity(QUEUE, FOUND));
    workspace.reserve_containment();
    workspace
}

/// Makes room for the contacts of meshes of at most this many triangles and vertices.
pub(crate) fn make_room_for_contacts(workspace: &mut Workspace, [triangles, vertices]: [usize; 2]) {
    workspace.reserve_manifolds(MOST_CONTACTS, triangles, vertices);
}

/// The task for the pairs of a round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RoundKind {
    /// Searches the pairs before the broad phase; a stopped search is not resumed.
    Search,
    /// Answers the questions of the pairs.
    Answer,
}

/// Data common to all batches of a round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Round {
    pub kind: RoundKind,
    pub frame: u64,
    pub mode: Mode,
    /// True if all pairs are expected to finish, so that their queries need no queue.
    pub to_the_end: bool,
    /// Time at which the last batch must end.
    pub end: Option<Duration>,
}

impl Round {
    /// A round of questions that are all expected to be answered.
    pub fn to_the_end(frame: u64, mode: Mode, end: Option<Duration>) -> Self {
        Self {
            kind: RoundKind::Answer,
            frame,
            mode,
            to_the_end: true,
            end,
        }
    }
}

/// Pairs with a common budget.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    pub turns: Vec<Turn>,
    pub budget: u64,
    /// True if it may do extra work to save work in later frames.
    pub looks_ahead: bool,
    /// The pair whose run the end of the budget stopped. The run is in the workspace.
    pub held: Option<PairKey>,
    workspace: Option<Box<Workspace>>,
}

impl Batch {
    /// A batch with a workspace, so that no frame has to allocate one.
    pub fn new() -> Self {
        Self {
            workspace: Some(workspace()),
            ..Self::default()
        }
    }

    /// True if there is nothing to run.
    pub fn is_empty(&self) -> bool {
        self.turns.is_empty()
    }

    /// True if there is no room for more turns.
    pub fn is_full(&self) -> bool {
        self.turns.len() == self.turns.capacity()
    }

    pub fn make_room_for_contacts(&mut self, mesh: [usize; 2]) {
        make_room_for_contacts(self.workspace.get_or_insert_with(workspace), mesh);
    }

    /// The stopped run, if there is one, and its pair.
    pub fn stopped(&self) -> Option<(PairKey, &Workspace)> {
        self.held.zip(self.workspace.as_deref())
    }

    pub fn swap_held(&mut self, other: &mut Self) {
        mem::swap(&mut self.held, &mut other.held);
        mem::swap(&mut self.workspace, &mut other.workspace);
    }

    /// Runs the pairs that fit the budget. `scratch` is a workspace of the current thread.
    pub fn run(
        &mut self,
        bodies: &Bodies,
        scratch: &mut Box<Workspace>,
        round: &Round,
        clock: &dyn Clock,
    ) {
        if round.kind == RoundKind::Search {
            let mut deadline = Deadline::of_a_part(round.end, u64::MAX, clock);
            for turn in &mut self.turns {
                if !deadline.has_room(LEAST_WORK) {
                    break;
                }
                turn.search(bodies, scratch, round, &mut deadline);
            }
            return;
        }
        let mut deadline = Deadline::at(round.end, self.budget, clock);
        for (at, turn) in self.turns.iter_mut().enumerate() {
            let key = turn.key();
            // A pair that is not expected to finish has room in the next round; the pairs after it
            // must not overtake it.
            if !deadline.has_room(LEAST_WORK)
                || at > 0 && u64::from(turn.median) > deadline.work_left()
            {
                break;
            }
            let held = self.held == Some(key);
            let ended = if !held && turn.is_bare(bodies, round) {
                turn.search_entry(bodies, scratch, round, &mut deadline)
            } else {
                let kept = self.workspace.as_mut().filter(|_| held);
                let ended = turn.run(&mut Context {
                    bodies,
                    round,
                    deadline: &mut deadline,
                    workspace: kept.unwrap_or(scratch),
                    held,
                    looks_ahead: self.looks_ahead,
                });
                turn.end_question(bodies, round.frame);
                ended
            };
            match ended {
                Ended::Complete if held => self.held = None,
                Ended::Stopped if !held => {
                    self.held = Some(key);
                    mem::swap(self.workspace.get_or_insert_with(workspace), scratch);
                }
                _ => {}
            }
        }
    }
}

/// Everything that a turn needs.
pub(crate) struct Context<'d, 'c> {
    pub bodies: &'d Bodies,
    pub round: &'d Round,
    pub deadline: &'d mut Deadline<'c>,
    pub workspace: &'d mut Workspace,
    /// True if the workspace holds a stopped run of the pair.
    pub held: bool,
    pub looks_ahead: bool,
}

/// The progress of a pair in its turn.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Ended {
    Complete,
    Stopped,
    NotBegun,
}

impl Turn {
    /// Decides whether the pair meets, before the broad phase. Leaves its state unread if its entry
    /// has all that is needed.
    pub fn search(
        &mut self,
        bodies: &Bodies,
        workspace: &mut Workspace,
        round: &Round,
        deadline: &mut Deadline,
    ) {
        if self.is_bare(bodies, round) {
            self.search_entry(bodies, workspace, round, deadline);
            self.next = None;
            return;
        }
        let (held, looks_ahead) = (false, true);
        self.run(&mut Context {
            bodies,
            round,
            deadline,
            workspace,
            held,
            looks_ahead,
        });
        self.next = None;
        self.end(round.frame, true);
    }

    fn is_bare(&self, bodies: &Bodies, round: &Round) -> bool {
        self.kind == TurnKind::Meet
            && round.mode == Mode::Any
            && self.known.is_bare(bodies, round.frame)
            && !bodies.wants_contacts(self.key())
    }

    /// Decides a bare pair. Its state is left as it is unless the search is cut short.
    fn search_entry(
        &mut self,
        bodies: &Bodies,
        workspace: &mut Workspace,
        round: &Round,
        deadline: &mut Deadline,
    ) -> Ended {
        let Round {
            to_the_end, frame, ..
        } = *round;
        let (verdict, spent) = (self.known).search(bodies, workspace, deadline, to_the_end, frame);
        self.spent.add(spent);
        if verdict == Verdict::Undecided {
            self.known.update(&mut self.state, bodies, frame);
            if spent.work == 0 {
                return Ended::NotBegun;
            }
            (self.state.search, self.state.pending) = (self.known.cost, Spent::of(workspace));
            return Ended::Stopped;
        }
        let found = u64::from(verdict.witness().is_some());
        self.standing = Standing {
            verdict,
            found,
            complete: true,
            recall: 1.0,
        };
        self.next = None;
        Ended::Complete
    }

    /// Runs the pair as far as the deadline allows.
    pub fn run(&mut self, context: &mut Context) -> Ended {
        let Context { bodies, round, .. } = *context;
        if !context.held {
            // Which run of another batch a thread's workspace holds must not change the answer.
            context.workspace.forget_run();
        }
        self.known.update(&mut self.state, bodies, round.frame);
        let Some([a, b]) = bodies.pair(self.key()) else {
            return Ended::NotBegun;
        };
        let b_in_a = a.relative(b);
        let proven = mem::take(&mut self.state.apart);
        let ended = self.ask([a, b], b_in_a, context);
        let (key, since) = (self.key(), self.known.since(round.frame));
        if ended != Ended::Complete
            && self.state.apart == 0.0
            && bodies.gone(key, since, round.frame) < f64::INFINITY
        {
            // It still tells how deep the bodies may have sunk in.
            self.state.apart = proven;
        }
        ended
    }

    fn ask(&mut self, [a, b]: [&Placed; 2], b_in_a: Pose, context: &mut Context) -> Ended {
        let Context { bodies, round, .. } = *context;
        if self.may_test_roots(context) && self.root_test_parts([a, b], &b_in_a, context) {
            return Ended::Complete;
        }
        if self.may_part(context) && self.a_plane_parts([a, b], &b_in_a, context) {
            return Ended::Complete;
        }
        if self.may_prove_apart(context)
            && let Some(ended) = self.prove_apart([a, b], b_in_a, context)
            && (self.kind == TurnKind::Meet || self.state.verdict == Verdict::Separated)
        {
            return ended;
        }
        let question = match self.kind {
            TurnKind::Contacts => Question::contacts([a, b], b_in_a),
            TurnKind::Motion => Question::motion([a, b]),
            TurnKind::Meet => Question::new(bodies, self.key(), [a, b], b_in_a, round.mode),
        };
        if !context.deadline.has_room(question.least_work()) {
            return Ended::NotBegun;
        }
        match self.kind {
            TurnKind::Contacts => self.find_contacts(&question, [a, b], &b_in_a, context),
            TurnKind::Motion => self.find_impact(&question, context),
            TurnKind::Meet => self.answer(&question, context),
        }
    }

    /// Resumes or begins a question, as far as the deadline allows. Returns its answer, and the
    /// work of the run.
    pub fn go_on(&mut self, question: &Question, context: &mut Context) -> (Answer, Spent) {
        let Context {
            round,
            deadline,
            workspace,
            ..
        } = context;
        deadline.spend(WORK_PER_QUERY);
        let memory = &mut self.state.memory;
        let (answer, before) = question.go_on(workspace, memory, deadline, round.to_the_end);
        let spent = Spent::of(workspace);
        self.spent.work += WORK_PER_QUERY;
        self.spent.add(spent.since(before));
        (answer, spent)
    }

    /// Continues the time of impact of a pair whose distance is its first question. It also decides
    /// whether the bodies meet, if that is still open.
    #[inline(never)]
    fn find_impact(&mut self, question: &Question, context: &mut Context) -> Ended {
        let (answer, spent) = self.go_on(question, context);
        let (key, frame, state) = (self.key(), context.round.frame, &mut self.state);
        if let Some(proof) = answer.proof {
            state.note_proof(key, context.bodies, proof, frame);
        }
        if state.decided < frame && answer.verdict != Verdict::Undecided {
            state.decide(answer.verdict, answer.found, frame);
        }
        if answer.stop.is_final() {
            state.pending = Spent::default();
            return Ended::Complete;
        }
        state.pending = spent;
        Ended::Stopped
    }

    /// Runs any other question, as far as the deadline allows.
    #[inline(always)]
    fn answer(&mut self, question: &Question, context: &mut Context) -> Ended {
        let Context {
            bodies,
            round,
            deadline,
            workspace,
            ..
        } = context;
        loop {
            deadline.spend(WORK_PER_QUERY);
            self.spent.work += WORK_PER_QUERY;
            let memory = Some(&mut self.state.memory);
            let (answer, before) = question.advance(workspace, memory, deadline, round.to_the_end);
            let spent = Spent::of(workspace);
            self.spent.add(spent.since(before));
            if let Some(proof) = answer.proof {
                self.state
                    .note_proof(self.key(), bodies, proof, round.frame);
            }
            if self.state.note(&answer, spent, round.frame) {
                return Ended::Complete;
            }
            if answer.stop != StopReason::PairsFull || !deadline.has_room(LEAST_WORK) {
                return Ended::Stopped;
            }
            workspace.drain_pairs().for_each(drop);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::state::PairState;
    use crate::schedule::known::Known;
    use punctual::clock::ManualClock;

    #[test]
    fn a_turn_begins_with_what_the_list_has_found_out() {
        let (clock, bodies) = (ManualClock::new(), Bodies::default());
        let apart = PairState {
            verdict: Verdict::Separated,
            completed: 7,
            apart: 1.0,
            ..PairState::new(0)
        };
        let mut known = Known::new(1);
        known.note(&apart, 7);
        let mut turn = Turn::new(known, Box::new(PairState::new(0)));
        let round = Round {
            kind: RoundKind::Search,
            ..Round::to_the_end(9, Mode::Any, None)
        };
        turn.search(
            &bodies,
            &mut workspace(),
            &round,
            &mut Deadline::at(None, u64::MAX, &clock),
        );
        assert_eq!([turn.state.decided, turn.state.completed], [7; 2]);
        assert_eq!(turn.known.since(9), 7);
    }
}
