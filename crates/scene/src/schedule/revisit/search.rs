//! Searches before the broad phase: known pairs that the tests of their witnesses leave open. A
//! pair is *hot* if it met, or if its rank is not far below that at which the last frame ended its
//! searches.
//!
//! First the pairs whose turn it is, in a share of the frame. If a long search exceeds this share,
//! the share of later frames is less. Then the hot ones and a part of the others by rank, then all
//! others.

use super::{Decision, Revisit, Search, Walk, is_plain};
use crate::ask::TurnKind;
use crate::cost::{LEAST_WORK, WORK_PER_KNOWN_PAIR, WORK_PER_LISTED_PAIR, WORK_PER_PAIR_APART};
use crate::id::{PairKey, bodies_of};
use crate::pair::batch::{Batch, Round, RoundKind};
use crate::pair::frame::Frame;
use crate::pair::spent::Spent;
use crate::pair::state::Turn;
use crate::schedule::known::Known;
use crate::schedule::pairs::Pairs;
use crate::schedule::task::outlook;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use punctual::Verdict;
use punctual::engine::Deadline;
use punctual_geom::nanoseconds;

/// The pairs whose turn it is have the frame divided by this.
const TURNS: f64 = 8.0;

/// Ranking takes at most the time left divided by this.
const RANKING: u32 = 4;

/// A pair is hot while its gain is at least that of the last one searched divided by this.
const COOLING: f32 = 4.0;

/// A frame looks at one in this many of the pairs that are not hot: some may have come near.
const COLD: usize = 16;

/// A tight frame has to end soon after any search, so each thread searches this many pairs at once.
/// Others assign parts of at least `LEAST_PART` pairs, which other threads begin at once.
const SEARCHES: usize = 4;
const LEAST_PART: usize = 8;

impl Revisit {
    /// Searches the important pairs.
    pub fn search_important(&mut self, search: &mut Search) {
        let mut deadline = search.deadline();
        let bodies = search.frame.bodies;
        // An important pair stays hot.
        let is_important = |known: &Known| known.is_hot() && bodies.is_important(known.key);
        self.search_in_turn(Walk::Important, search, &mut deadline, is_important);
    }

    /// Searches the pairs whose turn it is.
    pub fn take_turns(&mut self, search: &mut Search) {
        let frame = search.frame;
        let [_, limit] = frame.times;
        let share = nanoseconds(limit) / TURNS;
        self.credit = (self.credit + share).min(2.0 * share);
        if self.credit <= 0.0 {
            return;
        }
        let began = frame.clock.now();
        let end = began.saturating_add(Duration::from_nanos(self.credit as u64));
        let mut deadline = Deadline::of_a_part(Some(end), u64::MAX, frame.clock);
        // Pairs that the last frame decided are most likely decided by this one, too.
        let has_waited = |known: &Known| known.since(frame.number) + 1 < frame.number;
        self.search_in_turn(Walk::Turns, search, &mut deadline, has_waited);
        self.credit -= nanoseconds(frame.clock.now().saturating_sub(began));
    }

    /// Searches the pairs that met and that the tests leave open, if that needs no state.
    pub fn search_met(&mut self, search: &mut Search) {
        let mut deadline = search.deadline();
        let left = mem::take(&mut self.ranks);
        let rooms = search.batches.iter().map(|batch| batch.turns.capacity());
        let part = left.len().div_ceil(rooms.len()).max(LEAST_PART);
        search.part = rooms.min().unwrap_or(0).clamp(1, part);
        for place in left.iter().map(|&place| place as usize) {
            if !self.has_room(search, &mut deadline) {
                break;
            }
            let known = search.pairs.at(place);
            if known.is_bare(search.frame.bodies, search.frame.number) && is_sought(place, search) {
                self.ask(place, search, &mut deadline);
            }
        }
        self.ranks = left;
        self.run_searches(search);
    }

    /// Searches some of the pairs, from where the last walk ended, as far as the deadline allows.
    fn search_in_turn(
        &mut self,
        walk: Walk,
        search: &mut Search,
        deadline: &mut Deadline,
        wants: impl Fn(&Known) -> bool,
    ) {
        for place in search.pairs.from(self.next[walk as usize]) {
            let known = search.pairs.at(place);
            self.next[walk as usize] = known.key;
            if !self.has_room(search, deadline) {
                break;
            }
            deadline.spend(WORK_PER_KNOWN_PAIR);
            if wants(known) {
                deadline.spend(WORK_PER_PAIR_APART);
                if is_sought(place, search) {
                    self.ask(place, search, deadline);
                }
            }
        }
        self.run_searches(search);
    }

    /// Searches the hot pairs by rank, and then the others, as far as the deadline allows.
    pub fn search(&mut self, search: &mut Search) {
        let mut deadline = search.deadline();
        for shares in [&[(true, 1), (false, COLD)][..], &[(false, 1)]] {
            let mut ranks = mem::take(&mut self.ranks);
            self.rank(shares, search, &mut ranks);
            for &rank in &ranks {
                if !self.has_room(search, &mut deadline) {
                    self.cutoff = gain(rank);
                    break;
                }
                self.ask(rank as u32 as usize, search, &mut deadline);
            }
            self.ranks = ranks;
            // Assigned pairs are not decided yet, and would be assigned again.
            self.run_searches(search);
            if !self.has_room(search, &mut deadline) {
                return;
            }
            self.cutoff /= COOLING;
        }
    }

    /// Ranks pairs, as far as a part of the time allows. `shares`: hot (true) or cold pairs, and
    /// one in how many of them, in turn.
    fn rank(&mut self, shares: &[(bool, usize)], search: &mut Search, ranks: &mut Vec<u64>) {
        ranks.clear();
        let frame = search.frame;
        let now = frame.clock.now();
        let left = search.end.unwrap_or(now).saturating_sub(now);
        let end = now.saturating_add(left / RANKING);
        let mut deadline = Deadline::of_a_part(Some(end), u64::MAX, frame.clock);
        for &(is_hot, of) in shares {
            let walk = if is_hot { Walk::Hot } else { Walk::Cold };
            let most = search.pairs.len().div_ceil(of);
            for place in search.pairs.from(self.next[walk as usize]).take(most) {
                let known = search.pairs.at(place);
                self.next[walk as usize] = known.key;
                if !deadline.has_room(WORK_PER_LISTED_PAIR) {
                    break;
                }
                deadline.spend(WORK_PER_KNOWN_PAIR);
                if known.is_hot() == is_hot && !known.is_completed(frame.number) {
                    self.heat(place, search, ranks, &mut deadline);
                }
            }
        }
        ranks.sort_unstable();
    }

    /// Ranks a pair, if it is to be searched, and determines whether it is hot.
    #[inline(always)]
    fn heat(
        &mut self,
        place: usize,
        search: &mut Search,
        ranks: &mut Vec<u64>,
        deadline: &mut Deadline,
    ) {
        deadline.spend(WORK_PER_PAIR_APART);
        let (frame, known) = (search.frame, search.pairs.at(place));
        let (key, was_hot) = (known.key, known.is_hot());
        let is_sought = is_sought(place, search);
        // A pair proven apart for now may soon meet.
        let mut is_hot = frame.bodies.is_important(key)
            || was_hot && !is_sought && frame.bodies.overlap(bodies_of(key));
        self.is_full |= is_sought && ranks.len() == ranks.capacity();
        if is_sought && !self.is_full {
            deadline.spend(WORK_PER_LISTED_PAIR);
            let rank = rank_of(place, frame, search.pairs);
            is_hot |= COOLING * gain(rank) >= self.cutoff;
            ranks.push(rank);
        }
        search.pairs.at_mut(place).set_hot(is_hot);
    }

    fn has_room(&mut self, search: &Search, deadline: &mut Deadline) -> bool {
        self.is_full |= self.found.len() + search.assigned >= self.found.capacity();
        deadline.has_room(LEAST_WORK) && !self.is_full
    }

    /// Searches a pair; on several threads, together with others.
    fn ask(&mut self, place: usize, search: &mut Search, deadline: &mut Deadline) {
        let Search {
            frame,
            pairs,
            batches,
            scratch,
            latest,
            ..
        } = search;
        let (bodies, number) = (frame.bodies, frame.number);
        let known = pairs.at_mut(place);
        if known.is_completed(number) {
            return;
        }
        let threads = frame.threads().min(batches.len());
        if threads == 1 && known.is_bare(bodies, number) {
            let key = known.key;
            let (verdict, spent) = known.search(bodies, scratch, latest, true, number);
            deadline.spend(spent.work);
            return self.note(key, verdict, spent);
        }
        let mut assigned = Turn {
            index: place as u32,
            next: Some(TurnKind::Meet),
            ..pairs.take(place, number)
        };
        if threads == 1 {
            assigned.search(bodies, scratch, &round_of_searches(frame, None), latest);
            deadline.spend(assigned.spent.work);
            return self.end_search(assigned, pairs);
        }
        let at = match search.part {
            0 => search.assigned % threads,
            part => search.assigned / part,
        };
        batches[at].turns.push(assigned);
        search.assigned += 1;
        if search.part > 0 && search.assigned.is_multiple_of(search.part) {
            let round = round_of_searches(frame, search.latest_end);
            let part = &mut batches[at..=at];
            frame.executor.begin(at, part, &round, bodies);
        }
        let most = match search.part {
            0 => SEARCHES * threads,
            part => part * batches.len(),
        };
        if search.assigned == most {
            let before = self.searches.work;
            self.run_searches(search);
            deadline.spend((self.searches.work - before) / threads as u64);
        }
    }

    /// Runs the searches that were assigned and not begun, and ends all.
    fn run_searches(&mut self, search: &mut Search) {
        let assigned = mem::take(&mut search.assigned);
        if assigned == 0 {
            return;
        }
        let begun = assigned.checked_div(search.part).unwrap_or(0);
        let Search {
            frame,
            pairs,
            batches,
            scratch,
            latest_end,
            ..
        } = search;
        let round = round_of_searches(frame, *latest_end);
        let rest = &mut batches[begun..];
        frame.executor.begin(begun, rest, &round, frame.bodies);
        let mut back = |batch: &mut Batch| {
            for searched in batch.turns.drain(..) {
                self.end_search(searched, pairs);
            }
        };
        frame
            .executor
            .finish(batches, &round, frame.bodies, scratch, &mut back);
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

/// True if a pair should be searched before it is listed: its boxes overlap, and it is not decided.
/// A stopped run of resting bodies is not searched, but resumed later.
#[inline(always)]
fn is_sought(place: usize, search: &mut Search) -> bool {
    let (frame, known) = (search.frame, search.pairs.at(place));
    let (key, number, changed) = (known.key, frame.number, frame.changed(known.key));
    let is_done = known.is_completed(number)
        || changed < number
            && match known.is_decided() {
                true => known.since(number) >= changed,
                false => known.cost > 0,
            };
    if is_done || !frame.bodies.overlap(bodies_of(key)) {
        return false;
    }
    search
        .pairs
        .overlapping(place, true, number)
        .is_some_and(|known| !known.stays_apart(frame.bodies, number))
        && is_plain(key, frame, search.broad)
}

/// The rank of a pair, with its place in the low 32 bits, ascending.
#[inline(always)]
fn rank_of(place: usize, frame: &Frame, pairs: &Pairs) -> u64 {
    let (_, rank) = outlook(frame, pairs.at(place), None, TurnKind::Meet, None, true);
    // The upper half of the importance suffices. Gains of one half of an octave count as equal:
    // then pairs of one body follow one another, and their trees are in the cache.
    let halves = rank >> 32 & 0xffff_0000 | rank >> 16 & GAIN_BITS;
    halves << 32 | place as u64
}

fn gain(rank: u64) -> f32 {
    f32::from_bits(!((rank >> 32) as u32) << 16)
}

fn round_of_searches(frame: &Frame, end: Option<Duration>) -> Round {
    Round {
        kind: RoundKind::Search,
        ..Round::to_the_end(frame.number, frame.mode, end)
    }
}
