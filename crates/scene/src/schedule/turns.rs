//! The round robin: decides which pair is searched next.

use super::job::Job;
use crate::ask::TurnKind;
use crate::id::PairKey;
use crate::pair::batch::Batch;
use crate::pair::state::Turn;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RoundRobin {
    /// The pair that it begins with.
    pub cursor: PairKey,
    /// True if it is the turn of the contacts of that pair.
    at_contacts: bool,
    /// True if that turn has used up a guaranteed share.
    overspent: bool,
    /// True if the list of the last frame was cut short; and where the next list continues.
    pub cut: bool,
    end: PairKey,
    /// True if the list begins with the cursor, or is complete.
    holds_cursor: bool,
}

impl RoundRobin {
    /// Records a pair that is listed. If its turn ended without an answer and a body moved, its run
    /// would begin anew, so the turn goes to the next pair.
    #[inline]
    pub fn list(&mut self, key: PairKey, changed: impl FnOnce() -> bool) {
        if self.overspent && key == self.cursor {
            let changed = changed();
            self.cursor += u64::from(changed);
            self.at_contacts &= !changed;
            self.overspent = false;
        }
    }

    /// If it is the turn of this pair, true if it is the turn of its contacts. They then come
    /// before its other questions, because its bodies may move in each frame.
    pub fn is_at_contacts(&self, key: PairKey) -> Option<bool> {
        (key == self.cursor).then_some(self.at_contacts)
    }

    /// Records that the list ends before the pair `end`. `cut`: the list is incomplete.
    pub fn end_list(&mut self, end: PairKey, cut: bool) {
        self.holds_cursor = self.cut || !cut;
        (self.cut, self.end) = (cut, end);
    }

    /// Moves the cursor past the turns that have ended. `enough`: work that is nearly the
    /// guaranteed share.
    pub fn advance(&mut self, batch: &Batch, enough: u64) {
        let Some(last) = batch.turns.last().filter(|_| self.holds_cursor) else {
            return;
        };
        let waiting = batch.turns.iter().position(Turn::is_due);
        let turn = waiting.map(|at| &batch.turns[at]);
        self.cursor = turn.map_or(last.key() + 1, |turn| turn.key());
        self.at_contacts = turn.is_some_and(|turn| turn.next == Some(TurnKind::Contacts));
        let is_cut =
            turn.is_some_and(|turn| turn.next == Some(turn.kind) && turn.spent.work >= enough);
        self.overspent = waiting == Some(0) && is_cut;
    }

    /// After a list cut short, skips the finished jobs, so that the next list has others.
    pub fn end_frame(&mut self, jobs: &[Job]) {
        if self.cut && self.holds_cursor {
            let (before, after) = jobs.split_at(jobs.partition_point(|job| job.key < self.cursor));
            let next = after
                .iter()
                .chain(before)
                .find(|job| job.open)
                .map_or(self.end, |job| job.key);
            self.at_contacts &= next == self.cursor;
            self.cursor = next;
        }
    }
}
