//! Shares the budget of a frame among its pairs.
//!
//! If nothing has changed, a frame goes on with the list, the tasks and the stopped runs of the
//! last one. A pair that was decided and whose bodies have not moved since needs nothing. For the
//! others the cost is predicted ([`forecast`]), and the frame proceeds in rounds:
//!
//! - Before the broad phase the latest witnesses of pairs that met are tested, eight pairs at once,
//!   and, unless work is limited, those that met are searched ([`revisit`]). In a *tight* frame,
//!   which has little time left for rounds, all known pairs are. The pairs decided are reported
//!   however little of the frame is left.
//! - A task has one question. Its next question follows in the next round, with a new rank: the
//!   time of impact after a distance, if a body moves; the contacts of a pair found to meet, if
//!   they are requested.
//! - If the expected cost fits the budget, all pairs are run to their ends.
//!   Without a budget and on several threads, this begins in the first round, part by part while
//!   the list is made.
//! - Otherwise a quarter goes to all pairs in turn (the *round robin*). The rest is assigned by
//!   importance, then by gain per expected cost. The gain is the expected number of frames with a
//!   known intersection: this one, and later ones as long as the witness lasts. (Information, the
//!   entropy of the probability, was measured to be worse: pairs that almost certainly intersect
//!   would wait.)
//! - What is left of the budget goes into the next round.
//!
//! The guarantee of [`crate::Scene::detect`] holds for these reasons, with `B`, `R`, `C` and `K`
//! from there:
//!
//! - No budget of work is exceeded: each query ends one step of work before that of its batch is
//!   spent.
//! - In each frame the round robin has at least `R`: under a budget of work only tests of witnesses
//!   come before it, and they leave it that much. Its first pair finishes if it takes at most `R`.
//!   Otherwise it continues in the next frame if neither body has moved; if one has, it has had its
//!   turn.
//! - A turn cut short is the first of the next frame. So is the turn of the contacts of a pair that
//!   was found to meet: it comes before the question whether the pair still meets. So is the turn
//!   of a time of impact after the distance. So in any two frames the round robin spends more than
//!   `R` on turns that end, and it completes a round in `K` frames.

mod assignment;
pub(crate) mod executor;
mod forecast;
mod groups;
pub(crate) mod known;
mod listing;
mod merge;
mod pace;
pub(crate) mod pairs;
mod revisit;
pub(crate) mod share;
mod task;
mod turns;
#[cfg(feature = "parallel")]
pub(crate) mod workers;

use super::broad::Broad;
use super::certificate::PairCertificate;
use super::events::Events;
use super::id::PairKey;
use super::pair::batch::{Batch, Round};
use super::pair::frame::{Frame, GUARANTEED};
use super::pair::question::Question;
use super::report::Report;
use super::room::reserve;
use crate::cost::{
    LEAST_WORK, WORK_PER_KEPT_PAIR, WORK_PER_PLANNED_PAIR, WORK_PER_REPORTED_PAIR,
    WORK_PER_ROOT_TEST,
};
use alloc::boxed::Box;
use alloc::vec::Vec;
pub(super) use assignment::BATCHES;
use assignment::{Assignment, take_back};
use core::cell::Cell;
use core::time::Duration;
use groups::BoundsOfGroups;
use listing::{Counts, Listing};
use pace::{OVERHEAD, Reserved, Speed};
use pairs::Pairs;
use punctual::Tree;
use punctual::engine::Deadline;
use punctual::prediction::Calibration;
use punctual::{Mode, Query, Verdict, Workspace};
use punctual_geom::{Pose, nanoseconds};
use revisit::{Revisit, Search};
use share::Share;
use task::Task;
use turns::RoundRobin;

/// The end of the step before the broad phase ([`revisit`]), in sixteenths of the time of a frame;
/// and the end of a search begun before that.
const REVISIT: u32 = 13;
const LATEST: u32 = 15;
const PARTS: u32 = 16;

/// A frame that was cut makes the next `LEAST_TIGHT` frames tight if less than a `LITTLE`-th of its
/// time was left for its rounds. If the frame after them is like that, the number doubles, up to
/// `MOST_TIGHT`.
const LITTLE: u32 = 4;
const LEAST_TIGHT: u64 = 16;
const MOST_TIGHT: u64 = 256;

/// Minimum number of known pairs per part of the list if their tasks are short.
const PART: usize = 64;

/// At most the frame divided by this is reserved for the end of the list and of the frame.
const MOST_RESERVED: u32 = 4;

/// Reading the findings of tasks about groups takes at most the frame divided by this.
const MOST_OF_GROUPS: u32 = 8;

/// Maximum number of rounds of a frame. The rest is small after two or three.
const ROUNDS: u64 = 8;

/// The results of the broad phase, and the contact tracking.
pub(crate) struct Found<'f> {
    pub broad: &'f mut Broad,
    pub pairs: &'f mut Pairs,
    pub events: &'f mut Events,
}

#[derive(Debug, Default)]
pub(crate) struct Schedule {
    batches: Vec<Batch>,
    /// The tasks of the frame, ascending by pair.
    tasks: Vec<Task>,
    /// Number of unfinished tasks.
    pub open: usize,
    /// Buffer for assigning tasks.
    order: Vec<(u64, u32)>,
    turns: RoundRobin,
    /// Bounds of groups: of the pairs without a task, of all as they were listed, and of all at the
    /// end of the frame.
    without_task: BoundsOfGroups,
    listed: BoundsOfGroups,
    pub reported: BoundsOfGroups,
    /// The frame that began the list; and true if the next frame may go on with it.
    pub began_list: u64,
    goes_on: bool,
    pub revisit: Revisit,
    speed: Speed,
    /// Time of a list after its deadline.
    closing: Reserved,
    /// The first frame that is not tight, and the number of tight ones before it.
    tight_until: u64,
    tight: u64,
    /// Time from the collection of the last task to the end of the frame, without estimates.
    rest: Reserved,
    /// The correction of the estimated probabilities.
    pub calibration: Calibration,
}

impl Schedule {
    pub fn new() -> Self {
        Self {
            batches: (0..BATCHES).map(|_| Batch::new()).collect(),
            ..Self::default()
        }
    }

    pub fn reserve(&mut self, pairs: usize, report: &mut Report) {
        reserve(&mut self.tasks, pairs);
        reserve(&mut report.pairs, pairs);
        reserve(&mut self.order, pairs);
        self.revisit.reserve(pairs);
        for (number, batch) in self.batches.iter_mut().enumerate() {
            reserve(&mut batch.turns, assignment::room(number, pairs));
        }
    }

    pub fn reserve_groups(&mut self, groups: usize, report: &mut Report) {
        self.without_task.reserve(groups);
        self.listed.reserve(groups);
        self.reported.reserve(groups);
        reserve(&mut report.group_distances, groups);
    }

    /// Makes room for the contacts of meshes of at most this many triangles and vertices.
    pub fn make_room_for_contacts(&mut self, mesh: [usize; 2]) {
        for batch in &mut self.batches {
            batch.make_room_for_contacts(mesh);
        }
    }

    /// The certificate of the stopped run of a pair, if the run is kept.
    pub fn certificate(
        &self,
        key: PairKey,
        [a, b]: [&Tree; 2],
        b_in_a: Pose,
        mode: Mode,
    ) -> Option<PairCertificate> {
        // A stopped run of another question does not belong to this query.
        let query = Query::intersection(a, b, b_in_a).surfaces().mode(mode);
        let mut held = self
            .batches
            .iter()
            .filter_map(Batch::stopped)
            .filter(|&(held, _)| held == key);
        let open = held.find_map(|(_, workspace)| query.certificate(workspace).ok())?;
        Some(PairCertificate {
            upper_bound: open.upper_bound(),
            largest_extent: open.largest_extent(),
        })
    }

    /// Tests the latest witnesses of pairs that met. If work is not limited, then searches the
    /// pairs that these tests leave open; in a tight frame, all other known pairs too. Under a
    /// budget of time, returns when this step ended and the time left after it, less what is
    /// reserved for the end of the list and of the frame.
    pub fn revisit(
        &mut self,
        frame: &Frame,
        broad: &Broad,
        pairs: &mut Pairs,
        scratch: &mut Box<Workspace>,
    ) -> Option<[Duration; 2]> {
        let [began, limit] = frame.times;
        let reserved = (self.closing.time() + self.rest.time()).min(limit / MOST_RESERVED);
        let whole = (frame.is_timed()).then(|| [began, limit.saturating_sub(reserved)]);
        if frame.is_still || frame.mode != Mode::Any || !frame.bodies.asks_without_contacts() {
            self.revisit.begin();
            return whole;
        }
        let work = frame.budget.work_limit().map_or(u64::MAX, |work| {
            work.saturating_sub(2 * (work / GUARANTEED).max(frame.bodies.least_work()))
        });
        let is_short = (frame.cut || self.open > 0)
            && frame.is_timed()
            && frame.budget.work_limit().is_none()
            && frame.bodies.changed > 0;
        let is_tight = is_short && frame.number < self.tight_until;
        let after =
            |parts: u32| whole.map(|[began, limit]| began.saturating_add(limit / PARTS * parts));
        let (end, latest_end) = (after(REVISIT), after(LATEST));
        let mut search = Search {
            frame,
            broad,
            pairs,
            batches: &mut self.batches,
            assigned: 0,
            part: 0,
            scratch,
            end,
            latest_end,
            latest: Deadline::of_a_part(latest_end, u64::MAX, frame.clock),
        };
        let tests = self.revisit.begin();
        if is_short && frame.bodies.has_important {
            self.revisit.search_important(&mut search);
        }
        if is_tight {
            self.revisit.take_turns(&mut search);
        }
        let mut deadline = Deadline::of_a_part(end, work, frame.clock);
        self.revisit
            .test(frame, broad, search.pairs, tests, &mut deadline);
        if is_tight {
            self.revisit.search(&mut search);
        } else if frame.budget.work_limit().is_none() {
            self.revisit.search_met(&mut search);
        }
        self.revisit.end();
        let [began, limit] = whole?;
        let ended = frame.clock.now();
        let end = began.saturating_add(limit);
        Some([ended, end.saturating_sub(ended)])
    }

    /// Runs the overlapping pairs as far as the budget allows and fills the report. Under a budget
    /// of time, returns when it ended.
    pub fn run(
        &mut self,
        frame: &Frame,
        found: &mut Found,
        share: &mut Share,
        report: &mut Report,
        scratch: &mut Box<Workspace>,
    ) -> Option<Duration> {
        let room = found.pairs.room();
        let mut closing = self.closing;
        share.list(&mut closing, |deadline| {
            self.list(frame, found, report, scratch, deadline)
        });
        self.closing = closing;
        report.spend(self.revisit.spent());
        let pairs = &mut *found.pairs;
        let made_room = pairs.room() != room;
        let estimates = frame.for_estimates();
        let measured = match frame.bodies.distance_requests.groups.len() {
            0 => 0,
            _ => self.tasks.iter().filter(|task| task.measures).count(),
        };
        let groups = pace::reading(measured).min(frame.times[1] / MOST_OF_GROUPS);
        let rest = self.rest.time() + groups + estimates.unwrap_or_default();
        let end = frame.end(rest);
        let mut round = Round::to_the_end(frame.number, frame.mode, end);
        let mut lap = None;
        frame.lap(&mut lap);
        let for_rounds = end.zip(lap).map(|(end, now)| end.saturating_sub(now));
        let total = self.left(frame, end.zip(lap), 0);
        let least = frame.bodies.least_work();
        for number in 0..ROUNDS {
            let left = self.left(frame, end.zip(lap), report.work);
            let open = self.open;
            // Under a budget of work, nothing comes before the guaranteed share, not even the cost
            // of planning another round.
            let rounds = if end.is_some() { number + 1 } else { number };
            let planning = rounds * WORK_PER_PLANNED_PAIR * open as u64;
            if open == 0 || left < LEAST_WORK + planning {
                break;
            }
            let reserve = if left == u64::MAX {
                0
            } else {
                left.min((total / GUARANTEED).max(least + WORK_PER_ROOT_TEST))
            };
            self.find_homes();
            self.plan(frame, &mut round, left, reserve, pairs);
            let assigned = self.batches.iter().map(|batch| batch.turns.len()).sum();
            round.end = frame.end(rest + pace::collecting(assigned));
            frame.lap(&mut lap);
            frame
                .executor
                .run(&mut self.batches, &round, frame.bodies, scratch);
            let running = frame.lap(&mut lap);
            let spent = self.collect(frame, [total, least], pairs, report);
            frame.lap(&mut lap);
            if let Some(running) = running {
                self.speed
                    .learn(spent as f64, nanoseconds(running) * frame.threads() as f64);
            }
            if spent == 0 {
                break;
            }
        }
        if frame.number >= self.tight_until && !made_room {
            let is_cut = self.open > 0 || report.unlisted > 0;
            let little = for_rounds.is_some_and(|left| LITTLE * left < frame.times[1]);
            if is_cut && little {
                self.tight = (2 * self.tight).clamp(LEAST_TIGHT, MOST_TIGHT);
                self.tight_until = frame.number + 1 + self.tight;
            } else {
                self.tight = 0;
            }
        }
        self.report(frame, found, report, estimates, lap)
    }

    /// Reports the results. The rounds ended at `lap`. Measures how long the report takes, and
    /// returns when it ended.
    fn report(
        &mut self,
        frame: &Frame,
        found: &mut Found,
        report: &mut Report,
        estimates: Option<Duration>,
        mut lap: Option<Duration>,
    ) -> Option<Duration> {
        self.learn(frame, found.pairs);
        let estimating = estimates.map_or(Duration::ZERO, |_| {
            self.estimate(frame, found.pairs, report)
        });
        self.turns.end_frame(&self.tasks);
        let of_groups = self.report_groups(frame, found, report);
        report.finish();
        found.events.report(frame.bodies, found.broad, report);
        if let Some(took) = frame.lap(&mut lap) {
            let took = took.saturating_sub(estimating + of_groups);
            let reported = report.pairs.len() + found.events.len();
            let most = (2_000 + 10 * reported) as f64 + nanoseconds(estimates.unwrap_or_default());
            self.rest.learn(took, most);
        }
        lap
    }

    /// Updates the calibration from the decided pairs, in their order, which does not depend on the
    /// threads.
    fn learn(&mut self, frame: &Frame, pairs: &mut Pairs) {
        for task in self.tasks.iter().filter(|task| task.teaches) {
            pairs
                .state(task.place as usize, frame)
                .teach(&mut self.calibration);
        }
    }

    /// Reports the distances of groups, with the findings of the tasks if there is time to read
    /// them. Returns the time that it took.
    fn report_groups(&mut self, frame: &Frame, found: &mut Found, report: &mut Report) -> Duration {
        if frame.bodies.distance_requests.groups.is_empty() {
            return Duration::ZERO;
        }
        let mut lap = None;
        frame.lap(&mut lap);
        self.reported.copy(&self.without_task);
        let mut deadline = Deadline::of_a_part(frame.end(self.rest.time()), u64::MAX, frame.clock);
        for &Task { key, place, .. } in self.tasks.iter().filter(|task| task.measures) {
            if !deadline.has_room(WORK_PER_REPORTED_PAIR) {
                self.reported.copy(&self.listed);
                break;
            }
            deadline.spend(WORK_PER_REPORTED_PAIR);
            let state = found.pairs.state(place as usize, frame);
            self.reported.read(key, state, frame);
        }
        report.group_distances.clear();
        self.reported.report(frame.bodies, report);
        frame.lap(&mut lap).unwrap_or_default()
    }

    /// Chooses the plan of the round and assigns the tasks.
    fn plan(
        &mut self,
        frame: &Frame,
        round: &mut Round,
        left: u64,
        reserve: u64,
        pairs: &mut Pairs,
    ) {
        let timed = round.end.map(|_| frame.threads());
        let overhead = timed.map_or(0, |threads| OVERHEAD * threads as u64);
        let Self {
            tasks,
            batches,
            order,
            turns,
            ..
        } = self;
        let first_turn = tasks.partition_point(|task| task.key < turns.cursor);
        let mut assign = Assignment {
            tasks,
            batches,
            pairs,
            frame,
            order,
            first_turn,
            overhead,
        };
        let expected = assign.expected();
        if frame.is_still {
            assign.stopped();
        }
        round.to_the_end = expected <= left - reserve;
        if round.to_the_end {
            assign.all([left, reserve, expected], timed.is_some(), frame.threads());
        } else {
            assign.shares([left, reserve], timed);
        }
    }

    /// Estimates the stopped queries, at most one per batch, as long as there is time. Returns the
    /// time that it took within its limit.
    fn estimate(&mut self, frame: &Frame, pairs: &mut Pairs, report: &mut Report) -> Duration {
        let end = frame.end(self.rest.time());
        let began = end.map_or(Duration::ZERO, |_| frame.clock.now());
        let last_look = Cell::new(began);
        let goes_on = || {
            end.is_none_or(|end| {
                last_look.set(frame.clock.now());
                last_look.get() < end
            })
        };
        for batch in &self.batches {
            let Some((key, workspace)) = batch.stopped() else {
                continue;
            };
            let Ok(at) = self.tasks.binary_search_by_key(&key, |task| task.key) else {
                continue;
            };
            let Some([a, b]) = frame.bodies.pair(key) else {
                continue;
            };
            if !goes_on() {
                break;
            }
            let Task { place, listed, .. } = self.tasks[at];
            let Question::Meet(query) =
                Question::new(frame.bodies, key, [a, b], a.relative(b), frame.mode)
            else {
                continue;
            };
            let state = pairs.state(place as usize, frame);
            if let Ok(mut estimate) = query.estimate_while(workspace, Some(&state.memory), &goes_on)
            {
                // An estimate of a decided pair teaches nothing.
                if report.pairs[listed as usize].verdict == Verdict::Undecided {
                    state.add_estimate(estimate.probability);
                    pairs.note(place as usize, frame.number);
                }
                estimate.probability = self.calibration.apply(estimate.probability);
                report.estimate(listed as usize, &estimate);
            }
        }
        let interrupted = end.map_or(began, |end| end.min(last_look.get()));
        interrupted.saturating_sub(began)
    }

    /// Work left after `spent`; `u64::MAX` without a budget.
    fn left(&self, frame: &Frame, until_from: Option<(Duration, Duration)>, spent: u64) -> u64 {
        let time = until_from.map(|(end, now)| end.saturating_sub(now));
        let work = |time: Duration| {
            (nanoseconds(time) * frame.threads() as f64 * self.speed.work_per_nano()) as u64
        };
        let in_time = time.map_or(u64::MAX, work);
        in_time.min(
            frame
                .budget
                .work_limit()
                .map_or(u64::MAX, |limit| limit.saturating_sub(spent)),
        )
    }

    /// Lists the pairs of the frame, and makes room for more of them. If nothing depends on the
    /// order of the tasks, they are run while the list is made, by other threads if there are any.
    fn list(
        &mut self,
        frame: &Frame,
        found: &mut Found,
        report: &mut Report,
        scratch: &mut Box<Workspace>,
        deadline: &mut Deadline,
    ) {
        for batch in &mut self.batches {
            // After a body changed, a stopped run belongs to an older pose or tree.
            batch.held = batch.held.filter(|&key| frame.changed(key) < frame.number);
        }
        let Found {
            broad,
            pairs,
            events,
        } = found;
        let goes_on = frame.is_still && self.goes_on && {
            let work = WORK_PER_KEPT_PAIR * report.pairs.len() as u64;
            let has_room = deadline.has_room(work);
            // More tasks than a round can plan would be of no use.
            let planning = WORK_PER_PLANNED_PAIR * self.open as u64;
            deadline.spend(if has_room { work + planning } else { 0 });
            has_room
        };
        self.goes_on = frame.is_still;
        if !goes_on {
            self.began_list = frame.number;
            self.without_task.begin(&frame.bodies.distance_requests);
            self.listed.begin(&frame.bodies.distance_requests);
        }
        let is_closed = |task: &&Task| goes_on && task.measures && !task.open;
        for &Task { key, place, .. } in self.tasks.iter().filter(is_closed) {
            deadline.spend(WORK_PER_REPORTED_PAIR);
            self.without_task
                .read(key, pairs.state(place as usize, frame), frame);
        }
        let Self {
            tasks,
            turns,
            without_task,
            listed,
            revisit,
            batches,
            ..
        } = self;
        let found = &revisit.found;
        let is_free = frame.budget.is_unlimited();
        let alone = frame.threads() == 1;
        let begins =
            is_free && !alone && !turns.cut && batches.iter().all(|batch| batch.held.is_none());
        let known = pairs.len();
        pairs.touches.begin();
        let listing = Listing {
            frame,
            broad,
            pairs,
            tasks,
            report,
            turns,
            without_task,
            listed,
            found,
            next_found: 0,
            expects: !(is_free && (alone || begins)),
            counts: Counts::default(),
            scratch: (is_free && alone).then_some(&mut **scratch),
        };
        let parts = match begins {
            false => 1,
            true if frame.mode == Mode::Any => (known / PART).clamp(1, BATCHES),
            true => known.clamp(1, BATCHES),
        };
        let round = Round::to_the_end(frame.number, frame.mode, None);
        let (mut assigned, mut ended) = (0, 0);
        let Counts { kept, near } = listing.run(goes_on, deadline, parts, |part, list| {
            if !begins {
                return;
            }
            let batch = &mut batches[part];
            (batch.budget, batch.looks_ahead) = (u64::MAX, true);
            for task in &mut list.tasks[assigned..] {
                if !batch.is_full() {
                    batch
                        .turns
                        .push(task.assign(assigned as u32, list.pairs, frame));
                }
                assigned += 1;
            }
            frame
                .executor
                .begin(part, &mut batches[part..=part], &round, frame.bodies);
        });
        if begins {
            frame
                .executor
                .finish(batches, &round, frame.bodies, scratch, &mut |batch| {
                    ended += take_back(batch, tasks, frame, pairs, report);
                });
        }
        self.open = self.tasks.len() - ended;
        let listed = report.pairs.len() + kept;
        let used = match revisit.is_full {
            true => listed.max(pairs.room() + 1),
            false => listed,
        };
        pairs.grow(
            broad,
            [used, near],
            frame.bodies.is_young(frame.number),
            deadline,
        );
        self.reserve(pairs.room(), report);
        events.reserve(pairs.room(), report);
    }

    /// Finds the tasks with a stopped run. The run of the task whose turn it is moves to the batch
    /// of the round robin.
    fn find_homes(&mut self) {
        let first = self
            .tasks
            .partition_point(|task| task.key < self.turns.cursor);
        if let Some(first) = self.tasks.get(first).or(self.tasks.first())
            && let [round_robin, others @ ..] = &mut self.batches[..]
            && let Some(home) = others
                .iter_mut()
                .find(|batch| batch.held == Some(first.key))
        {
            round_robin.swap_held(home);
        }
        for (batch, home) in self.batches.iter().zip(0..) {
            let at = batch
                .held
                .map(|key| self.tasks.binary_search_by_key(&key, |task| task.key));
            if let Some(Ok(at)) = at {
                self.tasks[at].home = Some(home);
            }
        }
    }

    /// Takes the tasks back from the batches. `total` is the work of this frame, `least` that of a
    /// turn. Returns the work done.
    fn collect(
        &mut self,
        frame: &Frame,
        [total, least]: [u64; 2],
        pairs: &mut Pairs,
        report: &mut Report,
    ) -> u64 {
        // Without a budget all have had their turn, however they were assigned.
        if total < u64::MAX {
            self.turns.advance(
                &self.batches[0],
                (total / GUARANTEED).saturating_sub(2 * least),
            );
        }
        let before = report.work;
        for batch in &mut self.batches {
            self.open -= take_back(batch, &mut self.tasks, frame, pairs, report);
        }
        report.work - before
    }
}
