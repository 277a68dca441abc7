//! How the budget of a frame is shared among its pairs.
//!
//! A pair that was decided and whose bodies have not moved since needs nothing. Of the others the cost is expected
//! ([`super::forecast`]), and the frame goes in rounds:
//!
//! - If the 90 % quantile of the sum fits the budget, all pairs are run to their ends, those that wait longest first.
//! - Otherwise each pair that intersected when it was last decided first gets the test of its witnesses, which is one step.
//!   Of what is left, a quarter goes to those that wait longest, one after the other (the *rota*); the rest by importance,
//!   then by expected information per cost.
//! - What is left over goes into the next round.
//!
//! **Guarantees.** Let B be the budget (of work, or the time that the broad phase leaves), R = B/8, and C the sum over the
//! overlapping pairs of what each takes to its end, or is expected to take if that is more.
//!
//! - Nothing runs past the budget: each query ends by its own budget, one step of work before that of its chain is spent.
//! - In each frame the rota has at least R. Its first pair is the one that waits longest, runs to its end if it takes no more
//!   than R, and otherwise goes on in the next frame if neither body has moved, or else goes last: it has had its turn.
//! - So in any two frames more than R is spent on turns that end, and a pair that takes no more than R, or rests, is decided
//!   at least once in **K = 2 ⌈C/R⌉ + 1** frames. No pair starves: each has a turn within K frames.
//! - Under a budget of work, all of this is the same on any number of threads.

use super::body::Bodies;
use super::chain::{Chain, Item, LEAST, Round};
use super::forecast::Forecast;
use super::pairs::{Key, Overlap, Pairs, bodies};
use super::report::{PairCertificate, PairReport, Report};
use crate::query::{Budget, Clock, Mode, Order, Query, Verdict};
use alloc::vec::Vec;
use core::time::Duration;

/// Chains under a budget of work, on any number of threads; the first is the rota.
pub(super) const CHAINS: usize = 16;

/// Under a budget of work, a chain has at least this much: about 20 us.
const CHAIN_WORK: u64 = 1 << 16;

/// The guaranteed share of the rota is this part of the budget.
const GUARANTEED: u64 = 8;

/// The usual share of the rota is this part of what is left.
const ROTA: u64 = 4;

/// Work that planning another round takes, for each pair.
const PLANNING: u64 = 40;

/// Most rounds of a frame. Leftovers are small after two or three.
const ROUNDS: usize = 8;

/// A pair that is not at its end.
#[derive(Clone, Copy, Debug)]
struct Task {
    key: Key,
    /// Its place among the overlaps of the frame.
    place: u32,
    /// Where its track is.
    slot: u32,
    forecast: Forecast,
    importance: f32,
    /// Whether it has witnesses that are likely to decide it.
    witnessed: bool,
    /// The chain that holds its stopped run.
    home: Option<u8>,
    /// Whether it is in a chain.
    dealt: bool,
}

/// What a frame asks of the schedule.
pub(super) struct Frame<'f, C> {
    pub number: u64,
    pub mode: Mode,
    pub budget: Budget,
    /// When it began, for a budget of time.
    pub started: Option<Duration>,
    pub clock: &'f C,
    pub bodies: &'f Bodies,
    pub threads: usize,
}

impl<C: Clock> Frame<'_, C> {
    fn deadline(&self) -> Option<Duration> {
        self.started.zip(self.budget.time_limit()).map(|(start, limit)| start.saturating_add(limit))
    }
}

#[derive(Debug)]
pub(super) struct Schedule {
    chains: Vec<Chain>,
    /// Ascending by place.
    tasks: Vec<Task>,
    /// Sort keys and indices of tasks.
    order: Vec<(u64, u32)>,
    /// The pair that the rota begins with, and whether it has used up a guaranteed share.
    cursor: Key,
    overspent: bool,
    /// Time of a unit of work on one thread, as measured in earlier frames.
    nanos_per_work: f64,
}

impl Schedule {
    pub fn new() -> Self {
        let chains = (0..CHAINS).map(|_| Chain::default()).collect();
        Self { chains, tasks: Vec::new(), order: Vec::new(), cursor: 0, overspent: false, nanos_per_work: 0.4 }
    }

    /// What the stopped run of a pair left open, if it is kept.
    pub fn certificate(&self, key: Key, query: &Query) -> Option<PairCertificate> {
        let held = self.chains.iter().filter_map(|chain| chain.held(key));
        let mut open = held.filter_map(|(order, workspace)| {
            let query = query.order(order);
            let certificate = query.certificate(workspace).ok()?;
            let (upper_bound, largest_extent) = (certificate.upper_bound(), certificate.largest_extent());
            Some(PairCertificate { upper_bound, largest_extent })
        });
        open.next()
    }

    /// Runs the overlapping pairs as far as the budget goes and fills the report. `execute` runs chains.
    pub fn run<C: Clock>(
        &mut self,
        frame: &Frame<C>,
        pairs: &mut Pairs,
        report: &mut Report,
        mut execute: impl FnMut(&mut [Chain], &Round),
    ) {
        self.gather(frame, pairs, report);
        let deadline = frame.deadline();
        let mut round = Round {
            frame: frame.number,
            mode: frame.mode,
            order: Order::DepthFirst,
            witnesses_only: false,
            deadline,
        };
        let total = self.left(frame, 0);
        for number in 0..ROUNDS as u64 {
            let left = self.left(frame, report.work);
            if self.tasks.is_empty() || left < LEAST + number * PLANNING * self.tasks.len() as u64 {
                break;
            }
            let reserve = if left == u64::MAX { 0 } else { left.min(total / GUARANTEED) };
            self.find_homes();
            self.bring_home_the_first();
            if self.fits(left - reserve) {
                (round.order, round.witnesses_only) = (Order::DepthFirst, false);
                self.deal_all(left, reserve, deadline.is_some(), pairs);
            } else {
                round.order = Order::Penetration;
                round.witnesses_only = number == 0 && self.deal_witnesses((left - reserve) / 2, pairs);
                if !round.witnesses_only {
                    self.deal_shares(left, reserve, deadline.map(|_| frame.threads), pairs);
                }
            }
            let began = deadline.map(|_| frame.clock.now());
            execute(&mut self.chains, &round);
            let took = began.map(|began| frame.clock.now().saturating_sub(began));
            let spent = self.collect(&round, total / GUARANTEED, pairs, report);
            if spent == 0 {
                break;
            }
            if let Some(took) = took {
                let measured = took.as_nanos() as f64 * frame.threads as f64 / spent as f64;
                self.nanos_per_work += 0.1 * (measured.clamp(0.05, 5.0) - self.nanos_per_work);
            }
        }
        let open = self.tasks.iter().map(|task| report.pairs[task.place as usize].age);
        report.worst_age = open.max().unwrap_or(0);
    }

    /// Work that is left, `spent` being done; `u64::MAX` without a budget.
    fn left<C: Clock>(&self, frame: &Frame<C>, spent: u64) -> u64 {
        let time = frame.deadline().map(|deadline| deadline.saturating_sub(frame.clock.now()));
        let speed = frame.threads as f64 / self.nanos_per_work;
        let in_time = time.map_or(u64::MAX, |time| (time.as_nanos() as f64 * speed) as u64);
        in_time.min(frame.budget.work_limit().map_or(u64::MAX, |limit| limit.saturating_sub(spent)))
    }

    /// Begins the report; what is known already is in it, the other pairs become tasks.
    fn gather<C>(&mut self, frame: &Frame<C>, pairs: &mut Pairs, report: &mut Report) {
        self.tasks.clear();
        report.pairs.clear();
        (report.decided, report.intersecting, report.work, report.bv_tests) = (0, 0, 0, 0);
        for place in 0..pairs.overlaps.len() {
            let Overlap { key, slot } = pairs.overlaps[place];
            let [a, b] = bodies(key);
            let (Some(x), Some(y), Some(track)) = (frame.bodies.at(a), frame.bodies.at(b), pairs.track(slot)) else {
                continue;
            };
            let changed = x.changed.max(y.changed);
            if self.overspent && key == self.cursor {
                // It had its turn in vain, and if it moved it would have to begin again.
                self.cursor += u64::from(changed == frame.number);
                self.overspent = false;
            }
            if track.completed >= changed {
                track.decided = frame.number;
            } else {
                self.tasks.push(Task {
                    key,
                    place: report.pairs.len() as u32,
                    slot,
                    forecast: Forecast::new(track, &x.body.tree, &y.body.tree, frame.number - track.decided),
                    importance: x.body.importance.max(y.body.importance),
                    witnessed: frame.mode == Mode::Any && matches!(track.verdict, Verdict::Intersecting { .. }),
                    home: None,
                    dealt: false,
                });
            }
            let (a, b) = (frame.bodies.id(a), frame.bodies.id(b));
            let undecided = Verdict::Undecided;
            report.pairs.push(PairReport { a, b, verdict: undecided, found: 0, complete: false, age: 0 });
            let complete = track.completed >= changed;
            report.note(place, track, frame.number, complete);
        }
    }

    /// Finds the tasks that have a stopped run somewhere.
    fn find_homes(&mut self) {
        for (chain, home) in self.chains.iter().zip(0..) {
            let Some((key, _)) = chain.held else { continue };
            if let Ok(at) = self.tasks.binary_search_by_key(&key, |task| task.key) {
                self.tasks[at].home = Some(home);
            }
        }
    }

    /// Whether the 90 % quantile of the cost of all tasks is within `work`: the sum of the medians, and the deviations of
    /// the quantiles from them added as those of independent variables.
    fn fits(&self, work: u64) -> bool {
        let (mut sum, mut squares) = (0, 0.0);
        for Task { forecast: Forecast { median, high, .. }, .. } in &self.tasks {
            sum += median;
            squares += ((high - median) as f64).powi(2);
        }
        work == u64::MAX || sum as f64 + libm::sqrt(squares) <= work as f64
    }

    /// All tasks, those that wait longest first, in blocks of equal expected cost.
    fn deal_all(&mut self, left: u64, reserve: u64, timed: bool, pairs: &mut Pairs) {
        self.order_rota(|_| true);
        let free = timed || left == u64::MAX;
        let chains = if free { CHAINS as u64 } else { (left / CHAIN_WORK).clamp(1, CHAINS as u64) };
        let sum: u64 = self.tasks.iter().map(|task| task.forecast.median).sum();
        let block = sum / chains + 1;
        self.deal_until(u64::MAX, |_, before| (before / block) as usize, pairs);
        for (chain, index) in self.chains.iter_mut().zip(0..) {
            let expected: u64 = chain.items.iter().map(|item| item.expected).sum();
            let share = u128::from(left - reserve) * u128::from(expected) / u128::from(sum.max(1));
            let share = share as u64 + if index == 0 { reserve } else { 0 };
            chain.budget = if free { u64::MAX } else { share };
        }
    }

    /// Tasks that a remembered witness may decide, as many as `work` allows, those that wait longest first. Whether there
    /// are any.
    fn deal_witnesses(&mut self, work: u64, pairs: &mut Pairs) -> bool {
        self.order_rota(|task| task.witnessed);
        self.order.truncate((work / LEAST) as usize);
        let block = self.order.len().div_ceil(CHAINS);
        self.deal_until(u64::MAX, |dealt, _| dealt / block, pairs);
        for chain in &mut self.chains {
            chain.budget = chain.items.len() as u64 * LEAST;
        }
        !self.order.is_empty()
    }

    /// The rota, and the others by importance and information per cost.
    fn deal_shares(&mut self, left: u64, reserve: u64, timed: Option<usize>, pairs: &mut Pairs) {
        let rota = reserve.max(left / ROTA);
        self.order_rota(|_| true);
        self.deal_until(rota, |_, _| 0, pairs);
        self.chains[0].budget = rota;

        // Expectations may be too high: twice of what fits is kept ready.
        let ready = 2 * (left - rota);
        self.order_by_rank(ready);
        let chains = match timed {
            Some(threads) => threads.clamp(1, CHAINS - 1),
            None => (left / CHAIN_WORK).clamp(1, CHAINS as u64 - 1) as usize,
        };
        self.deal_until(ready, |dealt, _| 1 + dealt % chains, pairs);
        let busy = self.chains[1..].iter().filter(|chain| !chain.items.is_empty()).count().max(1) as u64;
        for chain in &mut self.chains[1..] {
            chain.budget = if timed.is_some() { u64::MAX } else { (left - rota) / busy };
        }
    }

    /// Orders tasks by their turns: by key, from the cursor on and around.
    fn order_rota(&mut self, which: impl Fn(&Task) -> bool) {
        let first = self.tasks.partition_point(|task| task.key < self.cursor);
        let around = (first..self.tasks.len()).chain(0..first).filter(|&at| which(&self.tasks[at]));
        self.order.clear();
        self.order.extend(around.map(|at| (0, at as u32)));
    }

    /// Orders those tasks that are in no chain by rank, as far as `work` may go.
    fn order_by_rank(&mut self, work: u64) {
        self.order.clear();
        let free = self.tasks.iter().zip(0..).filter(|(task, _)| !task.dealt);
        self.order.extend(free.map(|(task, index)| (task.rank(), index)));
        let expected: u64 = self.tasks.iter().filter(|task| !task.dealt).map(|task| task.forecast.median).sum();
        let mean = expected / self.order.len().max(1) as u64;
        let enough = usize::try_from(2 * work / mean.max(1)).unwrap_or(usize::MAX);
        if enough < self.order.len() {
            self.order.select_nth_unstable(enough);
            self.order.truncate(enough);
        }
        self.order.sort_unstable();
    }

    /// Deals tasks in order until `work` is expected to be spent; each to the chain that holds its stopped run, or else to
    /// the one that `chain` says, by the number of tasks and the work dealt before.
    fn deal_until(&mut self, work: u64, chain: impl Fn(usize, u64) -> usize, pairs: &mut Pairs) {
        let mut before = 0;
        for (dealt, &(_, index)) in self.order.iter().enumerate() {
            if before >= work {
                break;
            }
            let task = &mut self.tasks[index as usize];
            let Some(track) = pairs.take(task.slot) else { continue };
            let expected = task.forecast.median;
            let chain = task.home.map_or_else(|| chain(dealt, before), usize::from);
            let Task { key, place, slot, .. } = *task;
            self.chains[chain].items.push(Item { key, place, slot, expected, track, spent: [0; 2] });
            task.dealt = true;
            before += expected;
        }
    }

    /// Gives the stopped run of the pair that is first in the rota to the chain of the rota.
    fn bring_home_the_first(&mut self) {
        let first = self.tasks.partition_point(|task| task.key < self.cursor);
        let first = if first < self.tasks.len() { first } else { 0 };
        if let Some(task) = self.tasks.get_mut(first)
            && let Some(home) = task.home.filter(|&home| home > 0)
        {
            let (rota, others) = self.chains.split_at_mut(1);
            rota[0].swap_held(&mut others[usize::from(home) - 1]);
            task.home = Some(0);
        }
    }

    /// Takes back what the chains did; the work that it took.
    fn collect(&mut self, round: &Round, guaranteed: u64, pairs: &mut Pairs, report: &mut Report) -> u64 {
        if !round.witnesses_only {
            self.advance(round.frame, guaranteed);
        }
        let mut spent = 0;
        for Item { place, slot, track, spent: [work, bv_tests], .. } in
            self.chains.iter_mut().flat_map(|chain| chain.items.drain(..))
        {
            report.note(place as usize, &track, round.frame, track.completed == round.frame);
            spent += work;
            report.bv_tests += bv_tests;
            pairs.put_back(slot, track);
        }
        report.work += spent;
        self.tasks.retain_mut(|task| {
            (task.dealt, task.home) = (false, None);
            !report.pairs[task.place as usize].complete
        });
        spent
    }

    /// Moves the cursor past the turns that have ended.
    fn advance(&mut self, frame: u64, guaranteed: u64) {
        let turns = &self.chains[0].items;
        let Some(last) = turns.last() else { return };
        let waiting = turns.iter().position(|item| item.track.completed != frame);
        self.cursor = waiting.map_or(last.key + 1, |at| turns[at].key);
        self.overspent = waiting == Some(0) && turns[0].spent[0] + 2 * LEAST >= guaranteed;
    }
}

impl Task {
    /// Sorts by importance, then by expected information per cost, both descending.
    fn rank(&self) -> u64 {
        let bits = self.importance.to_bits();
        let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        u64::from(!ascending) << 32 | u64::from(!(self.forecast.information / self.forecast.median as f32).to_bits())
    }
}
