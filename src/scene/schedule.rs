//! How the budget of a frame is shared among its pairs.
//!
//! A pair that was decided and whose bodies have not moved since needs nothing. Of the others the cost is expected
//! ([`super::forecast`]), and the frame goes in rounds:
//!
//! - If the 90 % quantile of the sum fits the budget, all pairs are run to their ends.
//! - Otherwise each pair that intersected when it was last decided first gets a test of its last witnesses. Of what is left, a
//!   quarter goes round all pairs in turn, one after the other (the *rota*); the rest by importance, then by the chance of
//!   finding an intersection per expected cost. (Information, the entropy of the chance, was measured worse: what is almost
//!   sure to intersect would wait.)
//! - What is left over goes into the next round.
//!
//! **Guarantees.** Let B be the budget (of work, or the time that the broad phase leaves), R = B/8, and C the sum over the
//! overlapping pairs of what each takes to its end, or is expected to take if that is more.
//!
//! - Nothing runs past the budget: each query ends by its own budget, one step of work before that of its chain is spent.
//! - In each frame the rota has at least R. Its first pair runs to its end if it takes no more than R, and otherwise goes on in
//!   the next frame if neither body has moved, or else has had its turn. Of what a turn takes, up to 602 units are for setting it
//!   up and for its last step; in C they count for every frame in which a pair goes on.
//! - A turn cut short is the first of the next frame. So in any two frames the rota spends more than R on turns that end, it
//!   is round in **K = 2 ⌈C/R⌉ + 1** frames, and a pair that takes no more than R, or rests, is decided at least once in K
//!   frames. No pair starves: each has a turn within K frames.
//! - Under a budget of work, all of this is the same on any number of threads.

use super::body::Bodies;
use super::chain::{Chain, Item, LEAST, Round, WORK_PER_WITNESS, query};
use super::forecast::Forecast;
use super::pairs::{Key, Overlap, Pairs, bodies};
use super::report::{PairCertificate, Report};
use crate::math::Pose;
use crate::query::{Budget, Clock, Mode, Verdict};
use crate::tree::Tree;
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

/// The least time of a frame that affords estimates of its stopped queries: each takes 10 us where it has to read the trees again.
const ESTIMATES: Duration = Duration::from_millis(1);

/// Work that planning another round takes, for each pair.
const PLANNING: u64 = 15;

/// Most rounds of a frame. Leftovers are small after two or three.
const ROUNDS: usize = 8;

/// A pair that was not at its end when the frame began.
#[derive(Clone, Copy, Debug)]
struct Task {
    key: Key,
    /// Its place in the report, and that of its track.
    place: u32,
    slot: u32,
    /// Expected work.
    median: u32,
    high: u32,
    /// Expected work if its witnesses do not decide it.
    search: u32,
    /// Probability of an intersection if its witnesses do not decide it.
    chance: f32,
    /// Sorts by importance, then by the chance of finding an intersection per expected work, both descending.
    rank: u64,
    /// The chain that holds its stopped run.
    home: Option<u8>,
    /// Whether it has witnesses that are likely to decide it.
    witnessed: bool,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Open,
    /// In a chain.
    Dealt,
    /// At its end.
    Done,
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
    /// When the last chain has to end, so that the rest of the frame, as long as `rest`, ends within the budget.
    fn deadline(&self, rest: Duration) -> Option<Duration> {
        let end = self.started.zip(self.budget.time_limit()).map(|(start, limit)| start.saturating_add(limit));
        end.map(|end| end.saturating_sub(rest))
    }
}

/// How fast a thread works, as measured: sums that fade.
#[derive(Clone, Copy, Debug)]
struct Speed {
    work: f64,
    nanos: f64,
}

impl Speed {
    const GUESS: Self = Self { work: 1e5, nanos: 4e4 };

    fn learn(&mut self, work: f64, nanos: f64) {
        // Other programs may have had the processor, for any time: most that counts is 1 ns a unit.
        self.work = 0.9 * self.work + work;
        self.nanos = 0.9 * self.nanos + nanos.min(work);
    }

    fn work_per_nano(&self) -> f64 {
        self.work / self.nanos
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
    speed: Speed,
    /// Time from the end of the last chain to that of the frame, as measured in earlier frames.
    rest: Duration,
}

impl Schedule {
    pub fn new() -> Self {
        let chains = (0..CHAINS).map(|_| Chain::new()).collect();
        Self {
            chains,
            tasks: Vec::new(),
            order: Vec::new(),
            cursor: 0,
            overspent: false,
            speed: Speed::GUESS,
            rest: Duration::ZERO,
        }
    }

    /// What the stopped run of a pair left open, if it is kept.
    pub fn certificate(&self, key: Key, trees: [&Tree; 2], b_in_a: Pose, mode: Mode) -> Option<PairCertificate> {
        let held = self.chains.iter().filter_map(|chain| chain.held(key));
        let mut open = held.filter_map(|(to_the_end, workspace)| {
            let query = query(trees, b_in_a, mode, to_the_end);
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
        let deadline = frame.deadline(self.rest);
        let mut round =
            Round { frame: frame.number, mode: frame.mode, to_the_end: true, witnesses_only: false, deadline };
        let mut last = None;
        let total = self.left(frame, deadline, 0);
        for number in 0..ROUNDS as u64 {
            let left = self.left(frame, deadline, report.work);
            let open = report.pairs.len() - report.complete;
            if open == 0 || left < LEAST + number * PLANNING * open as u64 {
                break;
            }
            let reserve = if left == u64::MAX { 0 } else { left.min((total / GUARANTEED).max(LEAST)) };
            self.find_homes();
            let [expected, high] = self.expected();
            if high <= left - reserve {
                (round.to_the_end, round.witnesses_only) = (true, false);
                self.deal_all(left, reserve, expected, deadline.is_some(), pairs);
            } else {
                round.to_the_end = false;
                round.witnesses_only = number == 0 && self.deal_witnesses(left.saturating_sub(2 * reserve), pairs);
                if !round.witnesses_only {
                    self.deal_shares(left, reserve, deadline.map(|_| frame.threads), pairs);
                }
            }
            let began = deadline.map(|_| frame.clock.now());
            execute(&mut self.chains, &round);
            let ended = deadline.map(|_| frame.clock.now());
            let spent = self.collect(&round, total, pairs, report);
            last = ended;
            if spent == 0 {
                break;
            }
            if let Some((began, ended)) = began.zip(ended) {
                let nanos = ended.saturating_sub(began).as_nanos() as f64 * frame.threads as f64;
                self.speed.learn(spent as f64, nanos);
            }
        }
        if frame.budget.time_limit().is_none_or(|limit| limit >= ESTIMATES) {
            self.estimate(frame, pairs, report);
        }
        report.finish();
        if let Some(ended) = last {
            // What another program took in between does not count.
            let stopped = self.chains.iter().filter(|chain| chain.held.is_some()).count() as u64;
            let most = Duration::from_nanos(2_000 + 20 * report.pairs.len() as u64 + 5_000 * stopped);
            let rest = frame.clock.now().saturating_sub(ended).min(most);
            self.rest = (7 * self.rest + 2 * rest) / 8;
        }
    }

    /// Asks the queries that were stopped how sure they are: at most one a chain.
    fn estimate<C>(&self, frame: &Frame<C>, pairs: &mut Pairs, report: &mut Report) {
        for chain in &self.chains {
            let Some((key, to_the_end, workspace)) = chain.stopped() else { continue };
            let Ok(at) = self.tasks.binary_search_by_key(&key, |task| task.key) else { continue };
            let Task { place, slot, .. } = self.tasks[at];
            let [Some(a), Some(b)] = bodies(key).map(|body| frame.bodies.at(body)) else { continue };
            let query = query([&a.body.tree, &b.body.tree], a.relative(b), frame.mode, to_the_end);
            let memory = pairs.track(slot).map(|track| &track.memory);
            if let Ok(estimate) = query.estimate(workspace, memory) {
                report.estimate(place as usize, &estimate);
            }
        }
    }

    /// Work that is left, `spent` being done; `u64::MAX` without a budget.
    fn left<C: Clock>(&self, frame: &Frame<C>, deadline: Option<Duration>, spent: u64) -> u64 {
        let time = deadline.map(|deadline| deadline.saturating_sub(frame.clock.now()));
        let work = |time: Duration| (time.as_nanos() as f64 * frame.threads as f64 * self.speed.work_per_nano()) as u64;
        let in_time = time.map_or(u64::MAX, work);
        in_time.min(frame.budget.work_limit().map_or(u64::MAX, |limit| limit.saturating_sub(spent)))
    }

    /// Begins the report; what is known already is in it, the other pairs become tasks.
    fn gather<C>(&mut self, frame: &Frame<C>, pairs: &mut Pairs, report: &mut Report) {
        self.tasks.clear();
        report.begin();
        for chain in &mut self.chains {
            // A body that changed has left the stopped run behind.
            let stands = |body| frame.bodies.facts(body).changed < frame.number;
            chain.held = chain.held.filter(|&(key, _)| bodies(key).into_iter().all(stands));
        }
        // Without a budget, on one thread, nothing depends on what is expected.
        let forecasts = frame.threads > 1 || frame.budget != Budget::unlimited();
        for place in 0..pairs.overlaps.len() {
            let Overlap { key, slot } = pairs.overlaps[place];
            let [a, b] = bodies(key);
            let (x, y) = (frame.bodies.facts(a), frame.bodies.facts(b));
            let Some(track) = pairs.track(slot) else { continue };
            let changed = x.changed.max(y.changed);
            if self.overspent && key == self.cursor {
                // It had its turn in vain, and if it moved it would have to begin again.
                self.cursor += u64::from(changed == frame.number);
                self.overspent = false;
            }
            let complete = track.completed >= changed;
            let mut probability = 0.0;
            if complete {
                track.decided = frame.number;
            } else {
                let age = frame.number - track.decided;
                let hit = frame.mode == Mode::Any && matches!(track.verdict, Verdict::Intersecting { .. });
                let forecast = if forecasts { Forecast::new(track, [x.size, y.size], age) } else { Forecast::NONE };
                probability = if hit && track.refuted >= changed { forecast.chance } else { forecast.still };
                self.tasks.push(Task {
                    key,
                    place: report.pairs.len() as u32,
                    slot,
                    median: forecast.median,
                    high: forecast.high,
                    search: forecast.search,
                    chance: forecast.chance,
                    rank: rank(x.importance.max(y.importance), &forecast),
                    home: None,
                    witnessed: hit && track.refuted < changed,
                    state: State::Open,
                });
            }
            report.push([a, b].map(|body| frame.bodies.id(body)), track, probability, complete);
        }
    }

    /// Median and 90 % quantile of the cost of all open tasks: the sum of the medians, and to it the deviations of the
    /// quantiles from them added as those of independent variables.
    fn expected(&self) -> [u64; 2] {
        let (mut sum, mut squares) = (0, 0.0);
        for task in self.tasks.iter().filter(|task| task.state == State::Open) {
            sum += u64::from(task.median);
            squares += f64::from(task.high - task.median) * f64::from(task.high - task.median);
        }
        [sum, sum + libm::sqrt(squares) as u64]
    }

    /// All tasks in the order of their turns, in blocks of equal expected cost.
    fn deal_all(&mut self, left: u64, reserve: u64, expected: u64, timed: bool, pairs: &mut Pairs) {
        let free = timed || left == u64::MAX;
        let chains = if free { CHAINS as u64 } else { (left / CHAIN_WORK).clamp(1, CHAINS as u64) };
        let block = expected / chains + 1;
        self.deal_turns(u64::MAX, |before| (before / block) as usize, pairs);
        for (chain, index) in self.chains.iter_mut().zip(0..) {
            let own: u64 = chain.items.iter().map(|item| item.expected).sum();
            let share = u128::from(left - reserve) * u128::from(own) / u128::from(expected.max(1));
            let share = share as u64 + if index == 0 { reserve } else { 0 };
            chain.budget = if free { u64::MAX } else { share };
        }
    }

    /// Tasks that a remembered witness may decide, as many as `work` allows. Whether there are any.
    fn deal_witnesses(&mut self, work: u64, pairs: &mut Pairs) -> bool {
        // A stopped run goes on instead: it is of this very place, which its witnesses were tested in.
        let is_due = |task: &Task| task.witnessed && task.home.is_none();
        let witnessed = self.tasks.iter().filter(|task| is_due(task)).count() as u64;
        let block = (witnessed.min(work / WORK_PER_WITNESS) as usize).div_ceil(CHAINS).max(1);
        let (mut dealt, first) = (0, self.first_turn());
        for at in (first..self.tasks.len()).chain(0..first) {
            if is_due(&self.tasks[at]) && dealt < block * CHAINS {
                self.deal(at, dealt / block, pairs);
                dealt += 1;
            }
        }
        for chain in &mut self.chains {
            chain.budget = chain.items.len() as u64 * WORK_PER_WITNESS;
        }
        witnessed > 0
    }

    /// The rota, and the others by importance and information per cost.
    fn deal_shares(&mut self, left: u64, reserve: u64, timed: Option<usize>, pairs: &mut Pairs) {
        let rota = reserve.max(left / ROTA);
        self.deal_turns(rota, |_| 0, pairs);
        self.chains[0].budget = rota;

        let chains = match timed {
            Some(threads) => threads.clamp(1, CHAINS - 1),
            None => (left / CHAIN_WORK).clamp(1, CHAINS as u64 - 1) as usize,
        };
        // Expectations may be too high: twice of what fits is kept ready.
        let ready = 2 * (left - rota);
        self.order_by_rank(ready);
        let mut before = 0;
        for dealt in 0..self.order.len() {
            let task = self.order[dealt].1 as usize;
            before += self.deal(task, 1 + dealt % chains, pairs);
            if before >= ready {
                break;
            }
        }
        let busy = self.chains[1..].iter().filter(|chain| !chain.items.is_empty()).count().max(1) as u64;
        for chain in &mut self.chains[1..] {
            chain.budget = if timed.is_some() { u64::MAX } else { (left - rota) / busy };
        }
    }

    /// Orders the open tasks by rank, as far as `work` may go.
    fn order_by_rank(&mut self, work: u64) {
        self.order.clear();
        let mut expected = 0;
        for (task, index) in self.tasks.iter().zip(0..).filter(|(task, _)| task.state == State::Open) {
            expected += u64::from(task.median);
            self.order.push((task.rank, index));
        }
        let mean = expected / self.order.len().max(1) as u64;
        let enough = usize::try_from(2 * work / mean.max(1)).unwrap_or(usize::MAX);
        if enough < self.order.len() {
            self.order.select_nth_unstable(enough);
            self.order.truncate(enough);
        }
        self.order.sort_unstable();
    }

    /// Deals open tasks in the order of their turns, by key from the cursor on and around, until `work` is expected to be
    /// spent. `chain` says where to, by the work before.
    fn deal_turns(&mut self, work: u64, chain: impl Fn(u64) -> usize, pairs: &mut Pairs) {
        let (mut before, first) = (0, self.first_turn());
        for at in (first..self.tasks.len()).chain(0..first) {
            if before >= work {
                break;
            }
            if self.tasks[at].state == State::Open {
                before += self.deal(at, chain(before), pairs);
            }
        }
    }

    /// Puts a task into the chain that holds its stopped run, or else into the one given. The work that is expected.
    fn deal(&mut self, at: usize, chain: usize, pairs: &mut Pairs) -> u64 {
        let task = &mut self.tasks[at];
        let Some(track) = pairs.take(task.slot) else { return 0 };
        let Task { key, place, slot, witnessed, .. } = *task;
        let expected = u64::from(task.median);
        let chain = task.home.take().map_or(chain, usize::from);
        let item = Item { key, place, slot, task: at as u32, expected, witnessed, track, spent: [0; 2] };
        self.chains[chain].items.push(item);
        task.state = State::Dealt;
        expected
    }

    fn first_turn(&self) -> usize {
        self.tasks.partition_point(|task| task.key < self.cursor)
    }

    /// Finds the tasks that have a stopped run somewhere. The one whose turn it is gets it into the chain of the rota.
    fn find_homes(&mut self) {
        if let Some(first) = self.tasks.get(self.first_turn()).or(self.tasks.first())
            && let [rota, others @ ..] = &mut self.chains[..]
            && let Some(home) = others.iter_mut().find(|chain| chain.held(first.key).is_some())
        {
            rota.swap_held(home);
        }
        for (chain, home) in self.chains.iter().zip(0..) {
            let at = chain.held.map(|(key, _)| self.tasks.binary_search_by_key(&key, |task| task.key));
            if let Some(Ok(at)) = at {
                self.tasks[at].home = Some(home);
            }
        }
    }

    /// Takes back what the chains did, of `total` work in this frame; the work that it took.
    fn collect(&mut self, round: &Round, total: u64, pairs: &mut Pairs, report: &mut Report) -> u64 {
        // Without a budget all have had their turn, however they were dealt.
        if !round.witnesses_only && total < u64::MAX {
            self.advance(round.frame, total / GUARANTEED);
        }
        let before = report.work;
        for Item { place, slot, task, witnessed, track, spent, .. } in
            self.chains.iter_mut().flat_map(|chain| chain.items.drain(..))
        {
            let complete = track.completed == round.frame;
            let task = &mut self.tasks[task as usize];
            task.state = if complete { State::Done } else { State::Open };
            if !witnessed && core::mem::replace(&mut task.witnessed, false) {
                task.median = task.search;
                report.pairs[place as usize].probability = task.chance.into();
            }
            report.note(place as usize, &track, spent, complete);
            pairs.put_back(slot, track);
        }
        report.work - before
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

/// See [`Task`].
fn rank(importance: f32, forecast: &Forecast) -> u64 {
    let bits = importance.to_bits();
    let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    let gain = forecast.chance / (forecast.search as f32 + 1.0);
    u64::from(!ascending) << 32 | u64::from(!gain.to_bits())
}
