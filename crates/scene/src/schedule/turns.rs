//! The round robin: decides which pair is searched next.

use super::task::Task;
use crate::ask::TurnKind;
use crate::id::PairKey;
use crate::pair::batch::Batch;
use crate::pair::state::Turn;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RoundRobin {
    /// The pair that it begins with.
    pub cursor: PairKey,
    /// The question of that pair whose turn it is.
    at: TurnKind,
    /// True if that turn has used up a guaranteed share in the frame.
    overspent: bool,
    /// True if the list of the last frame was cut short; and where the next list continues.
    pub cut: bool,
    pub end: PairKey,
    /// True if the list begins with the cursor, or is complete.
    holds_cursor: bool,
}

impl RoundRobin {
    /// Records a pair that is listed. If its turn ended without an answer and a body moved, its run
    /// would begin anew. Then the turn goes from its distance to its motion, if it has `both`, and
    /// else to the next pair.
    #[inline]
    pub fn list(
        &mut self,
        key: PairKey,
        changed: impl FnOnce() -> bool,
        both: impl FnOnce() -> bool,
    ) {
        if self.overspent && key == self.cursor {
            self.overspent = false;
            if !changed() {
                return;
            }
            if self.at == TurnKind::Meet && both() {
                self.at = TurnKind::Motion;
            } else {
                (self.cursor, self.at) = (key + 1, TurnKind::Meet);
            }
        }
    }

    /// The question of this pair whose turn it is, if any. It comes before the others, because the
    /// bodies may move in each frame.
    pub fn at(&self, key: PairKey) -> Option<TurnKind> {
        (key == self.cursor).then_some(self.at)
    }

    /// Records that the list ends before the pair `end`. `cut`: the list is incomplete.
    pub fn end_list(&mut self, end: PairKey, cut: bool) {
        // A list that follows one cut short begins with the cursor.
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
        self.at = turn.and_then(|turn| turn.next).unwrap_or_default();
        let first = turn.filter(|turn| waiting == Some(0) && turn.next == Some(turn.kind));
        // A later round of the frame may be short.
        let goes_on = self.overspent;
        self.overspent = first.is_some_and(|turn| goes_on || turn.spent.work >= enough);
    }

    /// After a list cut short, skips the finished tasks, so that the next list has others.
    pub fn end_frame(&mut self, tasks: &[Task]) {
        if self.cut && self.holds_cursor {
            let (before, after) =
                tasks.split_at(tasks.partition_point(|task| task.key < self.cursor));
            let next = after
                .iter()
                .chain(before)
                .find(|task| task.open)
                .map_or(self.end, |task| task.key);
            if next != self.cursor {
                (self.cursor, self.at) = (next, TurnKind::Meet);
            }
        }
    }
}
