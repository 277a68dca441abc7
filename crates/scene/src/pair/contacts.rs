//! A turn that finds the contact points of two bodies.

use super::batch::{Desk, Ended};
use super::question::Question;
use super::spent::Spent;
use super::state::Turn;
use crate::body::Placed;
use crate::cost::{WORK_PER_PATCHED_CONTACT, WORK_PER_QUERY};
use punctual::{Mode, StopReason, Verdict};

impl Turn {
    /// Continues finding contacts, as far as the deadline allows, and forms patches of those found.
    #[inline(never)]
    pub fn find_contacts(
        &mut self,
        question: &Question,
        pair: [&Placed; 2],
        desk: &mut Desk,
    ) -> Ended {
        let Desk {
            bodies,
            round,
            deadline,
            workspace,
            held,
            patches,
            ..
        } = desk;
        let (Some(touch), Some(patches)) = (&mut self.state.touch, patches) else {
            return Ended::NotBegun;
        };
        let (key, frame) = (self.key, round.frame);
        let resumed =
            question.resume_or_begin(*held, workspace, &self.state.memory, round.to_the_end, 0);
        deadline.spend(WORK_PER_QUERY);
        self.spent.work += WORK_PER_QUERY;
        let answer = question.go_on(workspace, &mut self.state.memory, deadline);
        let spent = Spent::of(workspace);
        self.spent.add(spent.since(resumed.unwrap_or_default()));
        touch.pending = spent;
        if answer.stop == StopReason::FlushedToZero {
            return Ended::Stopped;
        }
        let is_over = answer.stop.is_final() || answer.stop == StopReason::PairsFull;
        let (found, mut patched) = (workspace.contacts().len(), 0);
        let room = deadline.room();
        // An unfinished search without contacts reports nothing.
        if found == 0 && is_over || found > 0 && room >= WORK_PER_PATCHED_CONTACT {
            patched = touch.update(pair, workspace, answer.missing, patches, room);
            touch.since = frame;
            let work = patched as u64 * WORK_PER_PATCHED_CONTACT;
            deadline.spend(work);
            self.spent.work += work;
        }
        // If the contacts do not fit a second time, the rest is left out.
        let is_over = is_over && (patched == found || resumed.is_some() && patched > 0);
        let patching = found as u64 * WORK_PER_PATCHED_CONTACT;
        if is_over {
            touch.completed = frame;
            touch.cost = spent.work + patching;
            touch.left_out = if patched < found { patching } else { 0 };
            touch.pending = Spent::default();
        } else {
            // The question takes more work than that.
            touch.cost = touch.cost.max(2 * (spent.work + patching));
        }
        let is_all =
            round.mode == Mode::Any && !bodies.distance_requests.has(key) && !bodies.is_moving(key);
        if is_all && self.state.completed < frame && answer.verdict != Verdict::Undecided {
            self.state.completed = frame;
            self.state.decide(answer.verdict, answer.found, frame);
        }
        if is_over {
            Ended::Complete
        } else {
            Ended::Stopped
        }
    }
}
