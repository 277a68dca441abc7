//! Whose turn it is: the round robin.

use super::batch::Batch;
use super::id::PairKey;
use super::job::Job;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoundRobin {
    /// The pair that it begins with.
    pub cursor: PairKey,
    /// Whether that has used up a guaranteed share.
    overspent: bool,
    /// Whether the list of the last frame was cut short, and where the next one goes on.
    pub cut: bool,
    end: PairKey,
    /// Whether the list begins with the cursor, or is whole.
    holds_cursor: bool,
}

impl RoundRobin {
    /// Takes note of a pair that is listed. If its turn ended without an answer and a body moved, its run would begin anew, so
    /// the next pair has its turn.
    #[inline]
    pub fn list(&mut self, key: PairKey, changed: bool) {
        if self.overspent && key == self.cursor {
            self.cursor += u64::from(changed);
            self.overspent = false;
        }
    }

    /// Takes note of a list that ends before the pair `end`; `cut`: and before all pairs are in it.
    pub fn end_list(&mut self, end: PairKey, cut: bool) {
        self.holds_cursor = self.cut || !cut;
        (self.cut, self.end) = (cut, end);
    }

    /// Moves on past the turns that have ended. `enough`: work that is all but the guaranteed share.
    pub fn advance(&mut self, batch: &Batch, enough: u64) {
        let Some(last) = batch.turns.last().filter(|_| self.holds_cursor) else { return };
        let waiting = batch.turns.iter().position(|state| !state.turn.standing.complete);
        self.cursor = waiting.map_or(last.turn.key + 1, |at| batch.turns[at].turn.key);
        self.overspent = waiting == Some(0) && batch.turns[0].turn.spent.work >= enough;
    }

    /// Passes by the jobs of a list cut short that are at their ends, so that the next list has others.
    pub fn end_frame(&mut self, jobs: &[Job]) {
        if self.cut && self.holds_cursor {
            let (before, after) = jobs.split_at(jobs.partition_point(|job| job.key < self.cursor));
            self.cursor = after.iter().chain(before).find(|job| job.open).map_or(self.end, |job| job.key);
        }
    }
}
