//! A turn that finds the contacts of two bodies.

use super::apart::until;
use super::batch::{Context, Ended};
use super::question::{Answer, Question};
use super::spent::Spent;
use super::state::Turn;
use crate::ask::TurnKind;
use crate::body::Placed;
use crate::cost::{LEAST_DISTANCE_WORK, WORK_PER_QUERY};
use punctual::{Mode, StopReason, Verdict};
use punctual_geom::Pose;

impl Turn {
    /// Continues finding contacts, as far as the deadline allows. They also decide whether the
    /// bodies meet, if nothing else is asked.
    #[inline(never)]
    pub fn find_contacts(
        &mut self,
        question: &Question,
        pair: [&Placed; 2],
        b_in_a: &Pose,
        context: &mut Context,
    ) -> Ended {
        let (answer, spent) = self.go_on(question, context);
        let (bodies, round, workspace) = (context.bodies, context.round, &mut *context.workspace);
        let (key, frame) = (self.key(), round.frame);
        let Some(touch) = &mut self.state.touch else {
            return Ended::NotBegun;
        };
        touch.pending = spent;
        let is_over = answer.stop.is_final() || answer.stop == StopReason::PairsFull;
        // An unfinished search without contacts replaces nothing.
        if is_over || !workspace.manifolds().is_empty() {
            touch.nearest = answer.nearest;
            let within = match answer.verdict {
                Verdict::Contained { inner } => Some(inner),
                _ => None,
            };
            let rest = (answer.missing, within);
            touch.update(pair, workspace.manifolds(), rest, b_in_a, frame);
        }
        if is_over {
            (touch.completed, touch.cost) = (frame, spent.work);
            touch.pending = Spent::default();
        } else {
            // The whole question takes more work than its run so far.
            touch.cost = touch.cost.max(2 * spent.work);
        }
        let decides = round.mode == Mode::Any && bodies.asks_only_contact(key);
        if decides && self.state.completed < frame && answer.verdict != Verdict::Undecided {
            self.state.completed = frame;
            self.state.decide(answer.verdict, answer.found, frame);
            if answer.verdict == Verdict::Separated {
                // More than 0, because 0 proves nothing.
                let until = until(
                    bodies,
                    key,
                    pair,
                    self.look_ahead(pair, b_in_a, context),
                    frame,
                );
                self.state.apart = until.max(f64::from_bits(1));
            }
        }
        if is_over {
            Ended::Complete
        } else {
            Ended::Stopped
        }
    }

    /// True if a bound of a distance is lower than contacts are to look ahead.
    pub fn looks_beyond(&self, low: f64, context: &Context) -> bool {
        self.kind == TurnKind::Contacts && low < context.bodies.contact_requests.look_ahead
    }

    /// Lower bound of the distance of bodies without contacts, as far as the look-ahead and the
    /// deadline allow.
    fn look_ahead(&mut self, pair: [&Placed; 2], b_in_a: &Pose, context: &mut Context) -> f64 {
        if !self.looks_beyond(0.0, context) || !context.deadline.has_room(LEAST_DISTANCE_WORK) {
            return 0.0;
        }
        let limit = context.bodies.contact_requests.look_ahead;
        let answer = self.measure(&Question::look_ahead(pair, *b_in_a, limit), context);
        answer.proof.map_or(0.0, |proof| proof.parts().0)
    }

    /// Runs a question about the distance of the pair from its begin, besides its own.
    pub fn measure(&mut self, question: &Question, context: &mut Context) -> Answer {
        let workspace = &mut *context.workspace;
        workspace.forget_run();
        context.deadline.spend(WORK_PER_QUERY);
        let (memory, to_the_end) = (&mut self.state.memory, context.round.to_the_end);
        let (answer, _) = question.go_on(workspace, memory, context.deadline, to_the_end);
        self.spent.add(Spent::of(workspace));
        self.spent.work += WORK_PER_QUERY;
        answer
    }
}
