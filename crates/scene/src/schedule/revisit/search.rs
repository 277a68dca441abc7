//! Searches before the broad phase: known pairs that the tests of their witnesses leave open. A pair
//! is *hot* if it met, or if its rank is not far below that at which the last frame ended its
//! searches.
//!
//! First the pairs whose turn it is, in a share of the frame that what a long search takes beyond it
//! reduces in later frames. Then the hot ones by rank, then the others by rank.

use super::{Decision, Hands, Revisit, is_plain};
use crate::ask::TurnKind;
use crate::broad::Broad;
use crate::cost::{LEAST_WORK, WORK_PER_LISTED_PAIR, WORK_PER_PAIR_APART, WORK_PER_QUERY};
use crate::id::{PairKey, bodies_of};
use crate::pair::batch::{Round, RoundKind};
use crate::pair::frame::Frame;
use crate::pair::question::Question;
use crate::pair::spent::Spent;
use crate::pair::state::Turn;
use crate::schedule::job::outlook;
use crate::schedule::known::Known;
use crate::schedule::pairs::Pairs;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Query, Verdict};
use punctual_geom::nanoseconds;

/// The share of a frame that the pairs have whose turn it is: one part of so many.
const TURNS: f64 = 8.0;

/// Maximum number of pairs that a frame looks at for those whose turn it is.
const LOOKED_AT: usize = 8192;

/// Ranking takes at most one part of so many of the time left.
const RANKING: u32 = 4;

/// A pair is hot while its gain is at least that of the last one searched divided by this.
const COOLING: f32 = 4.0;

/// Each thread searches this many pairs at once.
const SEARCHES: usize = 4;

impl Revisit {
    /// Searches the pairs whose turn it is.
    pub fn take_turns(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        hands: &mut Hands,
    ) {
        let [_, limit] = frame.times;
        let share = nanoseconds(limit) / TURNS;
        self.credit = (self.credit + share).min(2.0 * share);
        if self.credit <= 0.0 {
            return;
        }
        let began = frame.clock.now();
        let end = began.saturating_add(Duration::from_nanos(self.credit as u64));
        let mut deadline = Deadline::of_a_part(Some(end), u64::MAX, frame.clock);
        let (known, start) = (pairs.len(), pairs.place(self.turn));
        for place in (start..known).chain(0..start).take(LOOKED_AT) {
            self.turn = pairs.key(place);
            if !self.has_room(hands, &mut deadline) {
                break;
            }
            deadline.spend(WORK_PER_LISTED_PAIR);
            if self.is_sought(place, frame, broad, pairs) {
                self.ask(place, frame, pairs, hands, &mut deadline);
            }
        }
        self.run_searches(frame, pairs, hands);
        self.credit -= nanoseconds(frame.clock.now().saturating_sub(began));
    }

    /// Searches the important pairs.
    pub fn search_important(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        hands: &mut Hands,
    ) {
        let mut deadline = Deadline::of_a_part(hands.end, u64::MAX, frame.clock);
        for place in 0..pairs.len() {
            let known = pairs.at(place);
            // An important pair stays hot.
            let is_important = known.is_hot() && frame.bodies.is_important(known.key);
            if is_important && self.is_sought(place, frame, broad, pairs) {
                if !self.has_room(hands, &mut deadline) {
                    break;
                }
                self.ask(place, frame, pairs, hands, &mut deadline);
            }
        }
        self.run_searches(frame, pairs, hands);
    }

    /// Searches the hot pairs by rank, and then the others, as far as the deadline allows.
    pub fn search(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
    ) {
        self.is_pressed = true;
        for groups in [&[Group::Met, Group::Hot][..], &[Group::Cold]] {
            let mut ranks = mem::take(&mut self.ranks);
            self.rank(groups, frame, broad, pairs, hands, &mut ranks);
            for &rank in &ranks {
                if !self.has_room(hands, deadline) {
                    self.cutoff = gain(rank);
                    break;
                }
                self.ask(rank as u32 as usize, frame, pairs, hands, deadline);
            }
            self.ranks = ranks;
            // What is dealt is not decided yet, and would be dealt again.
            self.run_searches(frame, pairs, hands);
            if !self.has_room(hands, deadline) {
                return;
            }
            let [began, limit] = frame.times;
            self.is_pressed &= frame.clock.now() > began.saturating_add(limit / 2);
            self.cutoff /= COOLING;
        }
    }

    /// Ranks the pairs of some groups in turn, as far as a part of the time allows.
    fn rank(
        &mut self,
        groups: &[Group],
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        hands: &Hands,
        ranks: &mut Vec<u64>,
    ) {
        ranks.clear();
        let now = frame.clock.now();
        let left = hands.end.unwrap_or(now).saturating_sub(now);
        let end = now.saturating_add(left / RANKING);
        let mut deadline = Deadline::of_a_part(Some(end), u64::MAX, frame.clock);
        let (known, start) = (pairs.len(), pairs.place(self.next_rank));
        for group in groups {
            for place in (start..known).chain(0..start) {
                let known = pairs.at(place);
                if Group::of(known) != *group || known.is_completed(frame.number) {
                    continue;
                }
                if !deadline.has_room(WORK_PER_LISTED_PAIR) {
                    break;
                }
                self.next_rank = known.key;
                self.heat(place, frame, broad, pairs, ranks, &mut deadline);
            }
        }
        ranks.sort_unstable();
    }

    /// Ranks a pair, if it is to be searched, and determines whether it is hot.
    #[inline(always)]
    fn heat(
        &mut self,
        place: usize,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        ranks: &mut Vec<u64>,
        deadline: &mut Deadline,
    ) {
        deadline.spend(WORK_PER_PAIR_APART);
        let mut is_hot = frame.bodies.is_important(pairs.key(place));
        let is_sought = self.is_sought(place, frame, broad, pairs);
        self.is_full |= is_sought && ranks.len() == ranks.capacity();
        if is_sought && !self.is_full {
            deadline.spend(WORK_PER_LISTED_PAIR);
            let rank = rank_of(place, frame, pairs);
            is_hot |= COOLING * gain(rank) >= self.cutoff;
            ranks.push(rank);
        }
        pairs.at_mut(place).set_hot(is_hot);
    }

    fn has_room(&mut self, hands: &Hands, deadline: &mut Deadline) -> bool {
        self.is_full |= self.found.len() + hands.dealt >= self.found.capacity();
        deadline.has_room(LEAST_WORK) && !self.is_full
    }

    /// True if a pair should be searched before it is listed: its boxes overlap, and it is neither
    /// decided nor has its bodies at rest a stopped run, which is resumed later.
    #[inline(always)]
    fn is_sought(&self, place: usize, frame: &Frame, broad: &Broad, pairs: &mut Pairs) -> bool {
        let (known, number, changed) = (
            pairs.at(place),
            frame.number,
            frame.changed(pairs.key(place)),
        );
        let key = known.key;
        let is_done = known.is_completed(number)
            || changed < number
                && match known.is_decided() {
                    true => known.since(number) >= changed,
                    false => known.cost > 0,
                };
        if is_done || !frame.bodies.overlap(bodies_of(key)) {
            return false;
        }
        pairs
            .overlapping(place, true, number)
            .is_some_and(|known| !known.stays_apart(frame.bodies, number))
            && is_plain(key, frame, broad)
    }

    /// Searches a pair; on several threads, together with a few others.
    fn ask(
        &mut self,
        place: usize,
        frame: &Frame,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
    ) {
        if pairs.at(place).is_completed(frame.number) {
            return;
        }
        let threads = frame.threads().min(hands.batches.len());
        let is_bare = threads == 1 && pairs.at(place).is_bare();
        if is_bare && !(frame.bodies.has_special && frame.bodies.is_special(pairs.key(place))) {
            return self.search_bare(place, frame, pairs, hands, deadline);
        }
        let dealt = Turn {
            index: place as u32,
            next: Some(TurnKind::Meet),
            ..pairs.take(place, frame.number)
        };
        if threads == 1 {
            let mut searched = dealt;
            searched.search(
                frame.bodies,
                hands.scratch,
                &round_of_searches(frame, None),
                &mut hands.latest,
            );
            deadline.spend(searched.spent.work);
            return self.end_search(searched, pairs);
        }
        hands.batches[hands.dealt % threads].turns.push(dealt);
        hands.dealt += 1;
        if hands.dealt == SEARCHES * threads {
            let before = self.searches.work;
            self.run_searches(frame, pairs, hands);
            deadline.spend((self.searches.work - before) / threads as u64);
        }
    }

    /// Searches a pair that met, and reads and writes nothing of it but its entry in the list.
    fn search_bare(
        &mut self,
        place: usize,
        frame: &Frame,
        pairs: &mut Pairs,
        hands: &mut Hands,
        deadline: &mut Deadline,
    ) {
        let (known, number) = (pairs.at_mut(place), frame.number);
        let key = known.key;
        let pair = frame.bodies.pair(key);
        let Some([a, b]) = pair.filter(|_| hands.latest.has_room(LEAST_WORK)) else {
            return;
        };
        let query = Query::intersection(&a.body.tree, &b.body.tree, a.relative(b));
        let question = Question::Meet(query);
        let workspace = &mut *hands.scratch;
        query.begin_task(true, workspace);
        hands.latest.spend(WORK_PER_QUERY);
        let answer = question.advance(workspace, None, &mut hands.latest);
        let mut spent = Spent::of(workspace);
        known.note_search(&answer, workspace.witness(), spent.work, number);
        spent.work += WORK_PER_QUERY;
        deadline.spend(spent.work);
        let verdict = answer.verdict;
        self.note(key, verdict, spent);
        if let Verdict::Contained { .. } = verdict {
            pairs.state(place, frame).finish(verdict, 0, number);
        }
    }

    /// Runs the searches that were dealt.
    fn run_searches(&mut self, frame: &Frame, pairs: &mut Pairs, hands: &mut Hands) {
        if mem::take(&mut hands.dealt) == 0 {
            return;
        }
        let Hands {
            batches,
            scratch,
            latest_end,
            ..
        } = hands;
        let round = round_of_searches(frame, *latest_end);
        frame.crew.run(batches, &round, frame.bodies, scratch);
        for searched in batches.iter_mut().flat_map(|batch| batch.turns.drain(..)) {
            self.end_search(searched, pairs);
        }
    }

    /// Stores the result of a search.
    fn end_search(&mut self, searched: Turn, pairs: &mut Pairs) {
        self.note(searched.key(), searched.standing.verdict, searched.spent);
        pairs.put_back(searched.index as usize, searched.state, searched.known);
    }

    fn note(&mut self, key: PairKey, verdict: Verdict, spent: Spent) {
        self.searches.add(spent);
        if verdict != Verdict::Undecided {
            self.found.push(Decision { key, verdict });
        }
    }
}

/// The bits of a gain that count in a rank.
const GAIN_BITS: u64 = 0xffc0;

/// The pairs that are ranked one after another.
#[derive(PartialEq)]
enum Group {
    Met,
    Hot,
    Cold,
}

impl Group {
    fn of(known: &Known) -> Self {
        match known.met() {
            true => Self::Met,
            false if known.is_hot() => Self::Hot,
            false => Self::Cold,
        }
    }
}

/// The rank of a pair, with its place in the low 32 bits, ascending.
#[inline(always)]
fn rank_of(place: usize, frame: &Frame, pairs: &Pairs) -> u64 {
    let (_, rank) = outlook(frame, pairs.at(place), None, TurnKind::Meet, None, true);
    // Of the importance the upper half tells enough. Gains of one half of an octave count as equal:
    // then pairs of one body follow one another, and their trees are in the cache.
    let halves = rank >> 32 & 0xffff_0000 | rank >> 16 & GAIN_BITS;
    halves << 32 | place as u64
}

/// The gain in a rank.
fn gain(rank: u64) -> f32 {
    f32::from_bits(!((rank >> 32) as u32) << 16)
}

fn round_of_searches(frame: &Frame, end: Option<Duration>) -> Round {
    Round {
        kind: RoundKind::Search,
        ..Round::to_the_end(frame.number, frame.mode, end)
    }
}
