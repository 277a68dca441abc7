//! The list of a frame: the known pairs whose boxes overlap, as far as the budget allows.
//!
//! A partial list begins with the pair whose turn it is, so that the guarantee of the round robin
//! holds however few pairs a frame can read.

use super::groups::BoundsOfGroups;
use super::known::Known;
use super::pairs::Pairs;
use super::revisit::Decision;
use super::task::{Task, outlook};
use super::turns::RoundRobin;
use crate::ask::TurnKind;
use crate::body::Bodies;
use crate::broad::Broad;
use crate::cost::{
    WORK_PER_FOUND_PAIR, WORK_PER_LISTED_PAIR, WORK_PER_PAIR_APART, WORK_PER_PAIR_OF_GROUPS,
    WORK_PER_PAIR_OF_GROUPS_APART,
};
use crate::id::{BodyId, PairKey, bodies_of, pair_key};
use crate::pair::frame::Frame;
use crate::pair::spent::Spent;
use crate::report::Report;
use alloc::vec::Vec;
use core::mem;
use core::ops::Range;
use punctual::engine::Deadline;
use punctual::{Mode, Verdict, Workspace};

pub(crate) struct Listing<'l> {
    pub frame: &'l Frame<'l>,
    pub broad: &'l Broad,
    pub pairs: &'l mut Pairs,
    pub tasks: &'l mut Vec<Task>,
    pub report: &'l mut Report,
    pub turns: &'l mut RoundRobin,
    /// Bounds of groups: from the pairs without a task, and from all pairs as they are listed.
    pub without_task: &'l mut BoundsOfGroups,
    pub listed: &'l mut BoundsOfGroups,
    /// Pairs that were found to meet before the list, ascending.
    pub found: &'l [Decision],
    /// Index of the next of them to be listed.
    pub next_found: usize,
    /// True if something depends on the forecasts of the tasks.
    pub expects: bool,
    pub counts: Counts,
    /// A workspace, if bare pairs are decided as they are listed.
    pub scratch: Option<&'l mut Workspace>,
}

/// Counts of a list, besides the pairs in it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    /// Pairs whose contacts are requested and that are not known to be separated.
    pub near: usize,
    /// Pairs of groups that are not listed but whose state is kept.
    pub kept: usize,
}

/// A known pair, and data of its bodies.
#[derive(Clone, Copy)]
struct Candidate {
    key: PairKey,
    place: usize,
    ids: [BodyId; 2],
    is_special: bool,
}

/// The consequences of the distance requests for a pair.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    /// True if the pair is excluded, for example by the filters of its bodies.
    is_out: bool,
    /// True if it is listed wherever its boxes are.
    listed: bool,
    /// True if its state is kept for later frames.
    keep: bool,
    /// True if it is proven separated; and true if nothing else is asked of it.
    is_apart: bool,
    is_whole: bool,
    /// If it may be the closest pair of groups, its nearness: [`outlook`].
    nearness: Option<f32>,
}

impl<'l> Listing<'l> {
    /// Begins the report, or, if it `goes_on`, continues that of the last frame. Pairs with a known
    /// result go into the report, the others become tasks; both ascending. After each of `parts`
    /// parts of the list, calls `hand_out` with the number of the part and the list so far.
    pub fn run(
        mut self,
        goes_on: bool,
        deadline: &mut Deadline,
        parts: usize,
        mut hand_out: impl FnMut(usize, &mut Listing),
    ) -> Counts {
        let known = self.pairs.len();
        let (from, left) = if goes_on {
            self.tasks.retain(|task| task.open);
            self.report.go_on();
            (self.turns.end, self.report.unlisted)
        } else {
            self.tasks.clear();
            self.report.begin();
            let cursor = if self.turns.cut { self.turns.cursor } else { 0 };
            (cursor, known)
        };
        let start = self.pairs.place(from);
        // The pairs found are paid for here, wherever they are listed.
        deadline.spend(self.found.len() as u64 * WORK_PER_FOUND_PAIR);
        let split = self.found.partition_point(|met| met.key < from);
        self.next_found = split;
        let first = left.min(known - start);
        let before = self.counts_so_far();
        let mut end = start;
        for part in 1..=parts {
            let until = start + first * part / parts;
            end = self.walk(end..until, deadline);
            if end < until {
                break;
            }
            hand_out(part - 1, &mut self);
        }
        let mut is_whole = end == start + first;
        let mut seen = end - start + self.list_found_until(self.found.len());
        self.sort_in(from, before);
        let rest = left - first;
        if rest > 0 || split > 0 {
            let before = self.counts_so_far();
            self.next_found = 0;
            let begin = if is_whole {
                self.walk(0..rest, deadline)
            } else {
                0
            };
            seen += begin + self.list_found_until(split);
            end = if is_whole { begin } else { end };
            is_whole &= begin == rest;
            self.sort_in(0, before);
        }
        let next = if end < known { self.pairs.key(end) } else { 0 };
        self.turns.end_list(next, !is_whole);
        self.report.unlisted = left.saturating_sub(seen);
        self.counts
    }

    /// Number of tasks, and of pairs listed.
    fn counts_so_far(&self) -> [usize; 2] {
        [self.tasks.len(), self.report.pairs.len()]
    }

    /// Moves the tasks and pairs listed after the first `tasks` tasks and `pairs` pairs into their
    /// places: before those of the first whose keys are not below `from`.
    fn sort_in(&mut self, from: PairKey, [tasks, pairs]: [usize; 2]) {
        let listed = &mut self.report.pairs;
        let place =
            listed[..pairs].partition_point(|pair| pair_key(pair.a.index, pair.b.index) < from);
        let new = listed.len() - pairs;
        if place == pairs || new == 0 {
            return;
        }
        listed[place..].rotate_left(pairs - place);
        for task in &mut *self.tasks {
            let listed = task.listed as usize;
            if listed >= pairs {
                task.listed -= (pairs - place) as u32;
            } else if listed >= place {
                task.listed += new as u32;
            }
        }
        let at = self.tasks[..tasks].partition_point(|task| task.key < from);
        self.tasks[at..].rotate_left(tasks - at);
    }

    /// Lists the pairs in a range of places. Returns the place before which it ended.
    fn walk(&mut self, places: Range<usize>, deadline: &mut Deadline) -> usize {
        let settled = self.broad.open == 0 && self.frame.bodies.changed == 0;
        let has_groups = !self.frame.bodies.distance_requests.groups.is_empty();
        let end = places.end;
        for place in places {
            if !deadline.has_room(WORK_PER_LISTED_PAIR) {
                return place;
            }
            let pair = self.candidate(place);
            let next = |listing: &Self| listing.found.get(listing.next_found).copied();
            if next(self).is_some_and(|met| met.key < pair.key) {
                self.list_found_before(pair);
            }
            if let Some(met) = next(self).filter(|met| met.key == pair.key) {
                self.next_found += 1;
                self.list_found(met, pair.ids);
                continue;
            }
            let listed = match pair.is_special {
                true => self.list::<true>(pair, settled),
                false => self.list::<false>(pair, settled),
            };
            deadline.spend(match (pair.is_special && has_groups, listed) {
                (false, true) => WORK_PER_LISTED_PAIR,
                (false, false) => WORK_PER_PAIR_APART,
                (true, true) => WORK_PER_PAIR_OF_GROUPS,
                (true, false) => WORK_PER_PAIR_OF_GROUPS_APART,
            });
        }
        end
    }

    /// A known pair with data of its bodies.
    #[inline(always)]
    fn candidate(&self, place: usize) -> Candidate {
        let (key, bodies) = (self.pairs.key(place), self.frame.bodies);
        let is_special = bodies.has_special && bodies.is_special(key);
        let ids = bodies_of(key).map(|body| bodies.id(body));
        Candidate {
            key,
            place,
            ids,
            is_special,
        }
    }

    /// Lists the pairs found, from the next one up to `end`. Returns their number.
    fn list_found_until(&mut self, end: usize) -> usize {
        let next = mem::replace(&mut self.next_found, end);
        for &met in &self.found[next..end] {
            let ids = bodies_of(met.key).map(|body| self.frame.bodies.id(body));
            self.list_found(met, ids);
        }
        end - next
    }

    /// Lists pairs that were found but are no longer known, because their fat AABBs in the tree do
    /// not overlap.
    #[cold]
    fn list_found_before(&mut self, pair: Candidate) {
        let found = &self.found[self.next_found..];
        let count = found.iter().take_while(|met| met.key < pair.key).count();
        self.list_found_until(self.next_found + count);
    }

    /// Lists a pair that was decided before. Its result is complete. The boxes of bodies that meet
    /// overlap; those of others may have come apart since.
    #[inline(always)]
    fn list_found(&mut self, pair: Decision, ids: [BodyId; 2]) {
        let Frame { bodies, number, .. } = *self.frame;
        let both = bodies_of(pair.key);
        let is_placed = both
            .into_iter()
            .all(|body| !bodies.facts(body).is_changed());
        if is_placed && !pair.verdict.meets() && !bodies.overlap(both) {
            return;
        }
        let changed = || bodies.last_change(pair.key) == number;
        self.turns.list(pair.key, changed, || false);
        let found = u64::from(pair.verdict.witness().is_some());
        self.report.push_complete(ids, pair.verdict, found, 0);
    }

    /// Lists a pair if its boxes overlap; true if they do. `SPECIAL`: the pair may have other
    /// questions than whether it meets.
    #[inline(always)]
    fn list<const SPECIAL: bool>(&mut self, pair: Candidate, settled: bool) -> bool {
        let Frame { number, bodies, .. } = *self.frame;
        let (place, key) = (pair.place, pair.key);
        let look = match SPECIAL {
            true => self.look(pair, settled),
            false => Look::default(),
        };
        if look.is_out {
            return false;
        }
        let overlap = look.listed || bodies.overlap(bodies_of(key));
        let overlap = match settled {
            true => Some(overlap),
            false => self.may_overlap(pair, overlap),
        };
        let Some(overlap) = overlap else { return false };
        let Some(known) = self.pairs.overlapping(place, overlap | look.keep, number) else {
            return false;
        };
        if look.keep && !overlap {
            self.counts.kept += 1;
            return false;
        }
        let changed = || self.frame.changed(key) == number;
        self.turns.list(key, changed, || bodies.asks_both(key));
        if known.stays_apart(bodies, number) && look.nearness.is_none() {
            self.report
                .push_complete(pair.ids, Verdict::Separated, 0, 0);
            return true;
        }
        let changed = self.frame.changed(key);
        let had_estimates = changed == number && known.forget_estimates();
        let known = *known;
        let is_plain = !SPECIAL && self.frame.mode == Mode::Any && !bodies.wants_contacts(key);
        if is_plain && changed == number && !had_estimates {
            if !self.decide(pair, &known) {
                self.list_open(pair, &known);
            }
            return true;
        }
        let state = self.pairs.state_of(known, self.frame);
        if changed == number {
            state.forget_estimates();
        }
        let mut complete = state.completed >= changed;
        // A verdict holds while both bodies rest, even if more contacts may be left to find.
        let mut holds =
            state.verdict != Verdict::Undecided && (complete || state.decided >= changed);
        if holds {
            state.decided = number;
        }
        if look.is_apart && !complete {
            state.decide(Verdict::Separated, 0, number);
            (complete, holds) = (look.nearness.is_none(), true);
        }
        let is_timed = !SPECIAL || state.is_timed(key, bodies, number);
        let wants_contacts = bodies.wants_contacts(key);
        let touches = wants_contacts && state.met();
        self.counts.near += usize::from(wants_contacts);
        let drift = if touches {
            bodies.small_drift(key, state, number)
        } else {
            None
        };
        let located = !touches || drift.is_some();
        // Contacts decide whether the bodies meet, if nothing else is asked.
        let by_contacts =
            wants_contacts && self.frame.mode == Mode::Any && bodies.asks_only_contact(key);
        if by_contacts
            && !complete
            && let Some(drift) = drift
        {
            complete = state.goes_on_touching(key, bodies, drift, number);
            holds |= complete;
        }
        let mut probability = 0.0;
        if look.nearness.is_some() || !(complete && is_timed && located) {
            let is_known = complete && look.nearness.is_none();
            let asks_contacts = by_contacts && !is_known
                || !located
                    && (is_known && is_timed || asks_contacts_first(bodies, self.turns, key));
            let kind = if asks_contacts {
                TurnKind::Contacts
            } else if !is_timed && (is_known || self.turns.at(key) == Some(TurnKind::Motion)) {
                TurnKind::Motion
            } else {
                TurnKind::Meet
            };
            if is_known {
                state.completed = number;
            }
            let (forecast, rank) = outlook(
                self.frame,
                &known,
                Some(state),
                kind,
                look.nearness,
                self.expects,
            );
            probability = forecast.probability;
            self.tasks.push(Task {
                key,
                listed: self.report.pairs.len() as u32,
                place: place as u32,
                median: forecast.median,
                rank,
                home: None,
                kind,
                measures: look.nearness.is_some(),
                teaches: false,
                open: true,
            });
        }
        let (verdict, found, age) = (
            state.verdict,
            state.found,
            number - self.frame.decided(state.decided),
        );
        let is_whole = is_timed && (complete || look.is_whole);
        let standing = (holds && !is_whole).then(|| state.standing(number, is_timed));
        if complete && state.decided == number {
            self.pairs.at_mut(place).stay(number);
        }
        if is_whole {
            let (verdict, found) = if age == 0 {
                (verdict, found)
            } else {
                (Verdict::Undecided, 0)
            };
            self.report.push_complete(pair.ids, verdict, found, age);
        } else {
            let listed = self.report.pairs.len();
            self.report.push_open(pair.ids, probability, age);
            if let Some(standing) = standing {
                self.report.note(listed, standing, Spent::default());
            }
        }
        true
    }

    /// Decides a bare pair. False if it is not one, or if there is no workspace.
    #[inline(always)]
    fn decide(&mut self, pair: Candidate, known: &Known) -> bool {
        let Frame { bodies, number, .. } = *self.frame;
        let is_bare = |_: &&mut &mut Workspace| known.is_bare(bodies, number);
        let Some(scratch) = self.scratch.as_mut().filter(is_bare) else {
            return false;
        };
        let mut deadline = Deadline::of_a_part(None, u64::MAX, self.frame.clock);
        let known = self.pairs.at_mut(pair.place);
        let (verdict, spent) = known.search(bodies, scratch, &mut deadline, true, number);
        self.report.spend(spent);
        if verdict == Verdict::Undecided {
            return false;
        }
        let found = u64::from(verdict.witness().is_some());
        self.report.push_complete(pair.ids, verdict, found, 0);
        true
    }

    /// Lists a pair whose bodies moved and whose only question is whether they meet. Its state is
    /// not read.
    #[inline(always)]
    fn list_open(&mut self, pair: Candidate, known: &Known) {
        let frame = self.frame;
        let (forecast, rank) = outlook(frame, known, None, TurnKind::Meet, None, self.expects);
        self.tasks.push(Task {
            key: pair.key,
            listed: self.report.pairs.len() as u32,
            place: pair.place as u32,
            median: forecast.median,
            rank,
            home: None,
            kind: TurnKind::Meet,
            measures: false,
            teaches: false,
            open: true,
        });
        let age = frame.number - frame.decided(known.since(frame.number));
        self.report.push_open(pair.ids, forecast.probability, age);
    }

    /// Determines the consequences of the distance requests for a pair, and records its known
    /// bounds.
    #[cold]
    fn look(&mut self, pair: Candidate, settled: bool) -> Look {
        let Frame { number, bodies, .. } = *self.frame;
        let (place, key) = (pair.place, pair.key);
        let Some(wanted) = bodies.distance_requests.wanted(key) else {
            return Look::default();
        };
        if !bodies.may_meet(bodies_of(key)) {
            let requests = &bodies.distance_requests;
            self.without_task.add(requests, key, None, true);
            self.listed.add(requests, key, None, true);
            return Look {
                is_out: true,
                ..Look::default()
            };
        }
        if !wanted.of_groups {
            return Look {
                listed: true,
                ..Look::default()
            };
        }
        let of_boxes = bodies.near_by_boxes(key);
        let is_far = wanted.is_settled(&of_boxes);
        let is_known = settled || self.may_overlap(pair, true).is_some();
        let near = match is_known && !is_far && self.pairs.at(place).overlaps() {
            true => bodies.near(
                key,
                self.pairs.state(place, self.frame),
                self.frame.changed(key),
                number,
            ),
            false => of_boxes,
        };
        let is_settled = wanted.is_settled(&near);
        let requests = &bodies.distance_requests;
        self.listed.add(requests, key, Some(&near), is_settled);
        if is_settled || !is_known {
            self.without_task
                .add(requests, key, Some(&near), is_settled);
        }
        let nearness = || 1.0 - (near.bounds.low / wanted.ceiling.max(f64::MIN_POSITIVE)) as f32;
        Look {
            is_out: false,
            listed: wanted.by_itself || !is_settled,
            keep: !is_far,
            is_apart: near.bounds.low > 0.0,
            is_whole: near.bounds.low > 0.0 && !wanted.by_itself,
            nearness: (!is_settled).then(nearness),
        }
    }

    /// Returns true if the boxes of a pair may overlap. `overlap` is the result for the boxes as
    /// computed. `None` if no answer is possible: a body was replaced, may no longer meet the
    /// other, or has moved away from its box. Also `None` for two fixed bodies whose distance is no
    /// longer measured.
    fn may_overlap(&self, pair: Candidate, overlap: bool) -> Option<bool> {
        let (bodies, both) = (self.frame.bodies, bodies_of(pair.key));
        if self.broad.is_of_another(bodies, both) || !bodies.may_meet(both) {
            return None;
        }
        if !self.broad.compares(both) && !bodies.distance_requests.has(pair.key) {
            return None;
        }
        if both
            .into_iter()
            .all(|body| !bodies.facts(body).is_changed())
        {
            return Some(overlap);
        }
        (overlap || self.pairs.at(pair.place).overlaps()).then_some(true)
    }
}

/// True if contacts come before any other question of a pair that met: because it is their turn, or
/// because they are more important.
fn asks_contacts_first(bodies: &Bodies, turns: &RoundRobin, key: PairKey) -> bool {
    let weight = |kind| bodies.weight(key, kind);
    turns.at(key).map_or_else(
        || weight(TurnKind::Contacts) > weight(TurnKind::Meet),
        |at| at == TurnKind::Contacts,
    )
}
