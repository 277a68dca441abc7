//! A turn that finds the contacts of two bodies.

use super::apart::until;
use super::batch::{Desk, Ended};
use super::question::Question;
use super::spent::Spent;
use super::state::Turn;
use crate::body::Placed;
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
        desk: &mut Desk,
    ) -> Ended {
        let (answer, spent) = self.go_on(question, desk);
        let Desk {
            bodies,
            round,
            workspace,
            ..
        } = desk;
        let (key, frame) = (self.key(), round.frame);
        let Some(touch) = &mut self.state.touch else {
            return Ended::NotBegun;
        };
        touch.pending = spent;
        let is_over = answer.stop.is_final() || answer.stop == StopReason::PairsFull;
        // An unfinished search without contacts replaces nothing.
        if is_over || !workspace.manifolds().is_empty() {
            touch.nearest = answer.nearest;
            touch.update(pair, workspace.manifolds(), answer.missing, b_in_a, frame);
        }
        if is_over {
            (touch.completed, touch.cost) = (frame, spent.work);
            touch.pending = Spent::default();
        } else {
            // The question takes more work than that.
            touch.cost = touch.cost.max(2 * spent.work);
        }
        let decides = round.mode == Mode::Any && bodies.asks_only_contact(key);
        if decides && self.state.completed < frame && answer.verdict != Verdict::Undecided {
            self.state.completed = frame;
            self.state.decide(answer.verdict, answer.found, frame);
            if answer.verdict == Verdict::Separated {
                // Above 0, which proves nothing.
                let until = until(bodies, key, pair, 0.0, frame);
                self.state.apart = until.max(f64::from_bits(1));
            }
        }
        if is_over {
            Ended::Complete
        } else {
            Ended::Stopped
        }
    }
}
