//! Searches before the broad phase: known pairs that the tests of their witnesses leave open.

use super::{Hands, LEAST, Meeting, PER_TEST, Revisit, is_plain};
use crate::ask::TurnKind;
use crate::broad::Broad;
use crate::cost::{LEAST_WORK, WORK_PER_MERGED_PAIR};
use crate::id::bodies_of;
use crate::pair::batch::{Round, RoundKind};
use crate::pair::frame::Frame;
use crate::pair::state::Turn;
use crate::schedule::known::Known;
use crate::schedule::pairs::Pairs;
use core::mem;
use core::time::Duration;
use punctual::engine::Deadline;

/// Of the pairs that are not to be searched, every `PASSED`-th place is checked against the
/// deadline, and costs `PASSED` units of work.
const PASSED: usize = 64;

/// Boxes overlap deeply if their [overlap](crate::body::Bodies::common_part) is at least
/// this. Most pairs that meet are among these.
const DEEP: f64 = 0.1;

/// Each thread searches this many pairs at once.
const SEARCHES: usize = 4;

impl Revisit {
    /// Searches the lost pairs; if bodies have moved, then pairs that did not meet and whose boxes
    /// overlap deeply, and then all other known pairs. Each group in turn, as far as the deadline
    /// and [`LEAST`] allow.
    pub fn search(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
    ) {
        self.lost.sort_unstable();
        let first = self
            .lost
            .partition_point(|&place| pairs.key(place as usize) < self.turns[0]);
        for at in (first..self.lost.len()).chain(0..first) {
            let place = self.lost[at] as usize;
            if !self.has_room(hands, deadline) {
                self.turns[0] = pairs.key(place);
                return self.run_searches(0, frame, pairs, hands);
            }
            self.ask(0, place, frame, pairs, hands, deadline);
        }
        self.run_searches(0, frame, pairs, hands);
        if frame.bodies.changed == 0 {
            return;
        }
        for (turn, deep) in [(1, true), (2, false)] {
            let (known, start) = (pairs.len(), pairs.place(self.turns[turn]));
            let mut left = LEAST;
            for place in (start..known).chain(0..start) {
                let is_unmet = !pairs.at(place).met();
                if !is_unmet && place % PASSED > 0 {
                    continue;
                }
                if left == 0 || !self.has_room(hands, deadline) {
                    self.turns[turn] = pairs.key(place);
                    break;
                }
                left -= 1;
                deadline.spend(if is_unmet {
                    WORK_PER_MERGED_PAIR
                } else {
                    PASSED as u64
                });
                if is_unmet && self.is_sought(place, deep, frame, broad, pairs) {
                    left += PER_TEST;
                    self.ask(turn, place, frame, pairs, hands, deadline);
                }
            }
            self.run_searches(turn, frame, pairs, hands);
        }
    }

    fn has_room(&mut self, hands: &Hands, deadline: &mut Deadline) -> bool {
        self.is_full |= self.found.len() + hands.dealt >= self.found.capacity();
        deadline.has_room(LEAST_WORK) && !self.is_full
    }

    /// True if a pair that did not meet should be searched before it is listed. `deep`: selects
    /// pairs whose boxes overlap deeply, else the others.
    fn is_sought(
        &self,
        place: usize,
        deep: bool,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
    ) -> bool {
        let (key, number) = (pairs.key(place), frame.number);
        let part = frame.bodies.common_part(bodies_of(key));
        // The stopped run of bodies at rest is resumed later.
        if part.is_none_or(|part| (part >= DEEP) != deep) || frame.changed(key) < number {
            return false;
        }
        let is_due = |known: &mut Known| {
            !known.is_completed(number) && !known.stays_apart(frame.bodies, number)
        };
        pairs.overlapping(place, true, number).is_some_and(is_due) && is_plain(key, frame, broad)
    }

    /// Searches a pair; on several threads, together with a few others.
    fn ask(
        &mut self,
        turn: usize,
        place: usize,
        frame: &Frame,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
    ) {
        let threads = frame.threads().min(hands.batches.len());
        let dealt = Turn {
            index: place as u32,
            next: Some(TurnKind::Meet),
            ..pairs.take(place, frame.number)
        };
        if threads == 1 {
            // A deadline in use knows the pace of the work.
            let mut searched = dealt;
            searched.search(
                frame.bodies,
                hands.scratch,
                &round_of_searches(frame, None),
                deadline,
            );
            return self.end_search(turn, searched, pairs);
        }
        hands.batches[hands.dealt % threads].turns.push(dealt);
        hands.dealt += 1;
        if hands.dealt == SEARCHES * threads {
            let before = self.searches.work;
            self.run_searches(turn, frame, pairs, hands);
            deadline.spend((self.searches.work - before) / threads as u64);
        }
    }

    /// Runs the searches that were dealt.
    fn run_searches(&mut self, turn: usize, frame: &Frame, pairs: &mut Pairs, hands: &mut Hands) {
        if mem::take(&mut hands.dealt) == 0 {
            return;
        }
        let Hands {
            batches,
            scratch,
            end,
            ..
        } = hands;
        frame.crew.run(
            batches,
            &round_of_searches(frame, *end),
            frame.bodies,
            scratch,
        );
        for searched in batches.iter_mut().flat_map(|batch| batch.turns.drain(..)) {
            self.end_search(turn, searched, pairs);
        }
    }

    /// Stores the result of a search. If there was no time for it, the next frame continues with
    /// it, or with an earlier one.
    fn end_search(&mut self, turn: usize, searched: Turn, pairs: &mut Pairs) {
        self.searches.add(searched.spent);
        if let Some(met) = Meeting::new(searched.key(), searched.standing.verdict) {
            self.find(met);
        }
        if searched.next.is_some() {
            self.turns[turn] = self.turns[turn].min(searched.key());
        }
        pairs.put_back(searched.index as usize, searched.state, searched.known);
    }
}

fn round_of_searches(frame: &Frame, end: Option<Duration>) -> Round {
    Round {
        kind: RoundKind::Search,
        ..Round::to_the_end(frame.number, frame.mode, end)
    }
}
