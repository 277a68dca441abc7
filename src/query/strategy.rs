//! How a run goes about its visits: decided once, when it begins, from what is asked and what it
//! may spend.

use super::budget::Budget;
use super::options::{Mode, Options};
use super::order::Order;
use super::triangle_pairs::PATIENCE;
use crate::tree::WIDTH;
use core::time::Duration;

/// What a run is after. All plans give the same finished answer; they differ in speed and in what a
/// stopped run has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// Nothing is expected to stop it: the whole answer for the least time, depth-first.
    FinishSoon,
    /// All pairs are asked for, and a budget may cut it: many of them early. It queues node pairs
    /// until the first hit and follows curves of contact from there.
    FindMuch,
    /// One hit is asked for, and a budget may cut it: the first hit early.
    FindOne,
}

/// Least expected BV tests of a node pair that is queued: until the first hit of
/// [`Plan::FindMuch`], and in orders other than the default.
const QUEUE_THRESHOLD: f32 = 48.0;
const ORDER_THRESHOLD: f32 = 128.0;

/// Work of the traversal for each node pair on the front up to which curves are followed. A pair
/// takes some 800 units, so this is about a fourth of all.
const WORK_PER_PAIR: u64 = 200;

/// Triangle pairs that wait before they are tested, where the first hit should come soon.
const BATCH_BEFORE_HIT: usize = 2;

impl Plan {
    /// For a run that may be cut, or not.
    #[inline(always)]
    pub fn of(mode: Mode, may_be_cut: bool) -> Self {
        match (may_be_cut, mode) {
            (false, _) => Self::FinishSoon,
            (true, Mode::All) => Self::FindMuch,
            (true, Mode::Any) => Self::FindOne,
        }
    }

    /// For a budget. `fits` tells whether a time is expected to last to the end.
    ///
    /// Budgets of work promise the same bits however the work is cut into pieces, so their size
    /// decides nothing.
    #[inline(always)]
    pub fn within(budget: Budget, mode: Mode, fits: impl FnOnce(Duration) -> bool) -> Self {
        let is_short = budget.time.is_some_and(|limit| !fits(limit));
        Self::of(mode, budget.work.is_some() || is_short)
    }

    /// Its choices.
    #[inline(always)]
    pub fn strategy(self, options: &Options) -> Strategy {
        if options.order != Order::default() {
            return self.in_order(options);
        }
        let threshold = |default| options.queue_threshold.unwrap_or(default);
        match (self, options.mode) {
            (Self::FinishSoon, Mode::All) => Strategy {
                batch: PATIENCE,
                ..Strategy::NONE
            },
            // The stack with the deepest of siblings on top finds the first hit sooner than the
            // queue.
            (Self::FinishSoon, Mode::Any) => Strategy {
                deepest_first: true,
                warm_start: WarmStart::Witnesses,
                ..Strategy::NONE
            },
            (Self::FindMuch, _) => Strategy {
                queue_threshold: threshold(QUEUE_THRESHOLD),
                deepest_first: true,
                batch: BATCH_BEFORE_HIT,
                march: Marching::Within(WORK_PER_PAIR),
                warm_start: WarmStart::Paths,
                ..Strategy::NONE
            },
            (Self::FindOne, _) => Strategy {
                queue_threshold: threshold(f32::INFINITY),
                deepest_first: true,
                batch: BATCH_BEFORE_HIT,
                warm_start: WarmStart::Witnesses,
                ..Strategy::NONE
            },
        }
    }

    /// For experiments: the order that is asked for decides, whatever the budget.
    #[cold]
    fn in_order(self, options: &Options) -> Strategy {
        let queue_threshold = match options.order {
            Order::DepthFirst => f32::INFINITY,
            _ => options.queue_threshold.unwrap_or(ORDER_THRESHOLD),
        };
        let (warm_start, batch) = match (options.mode, self) {
            (Mode::Any, _) => (WarmStart::Witnesses, WIDTH),
            (Mode::All, Self::FinishSoon) => (WarmStart::None, PATIENCE),
            (Mode::All, _) => (WarmStart::None, WIDTH),
        };
        Strategy {
            queue_threshold,
            batch,
            warm_start,
            ..Strategy::NONE
        }
    }
}

/// The choices of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strategy {
    /// Least expected BV tests of a node pair that is queued; cheaper ones are finished depth-first
    /// at once. Infinite: no queue.
    pub queue_threshold: f32,
    /// Whether the deepest of siblings goes on top of the stack.
    pub deepest_first: bool,
    /// Triangle pairs that wait before they are tested.
    pub batch: usize,
    pub march: Marching,
    /// What is done with the triangle pairs that met in the frame before.
    pub warm_start: WarmStart,
}

/// Whether curves of contact are followed from hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Marching {
    Never,
    /// As long as the traversal has done no more work than this for each node pair on the front.
    Within(u64),
    /// No more. What was found along curves is known.
    Over,
}

impl Marching {
    /// Whether curves are followed.
    #[inline(always)]
    pub fn goes_on(self) -> bool {
        matches!(self, Self::Within(_))
    }
}

/// What is looked at before anything else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WarmStart {
    None,
    /// The remembered triangle pairs themselves, then the nodes above the latest.
    Witnesses,
    /// The paths down to the remembered triangle pairs, then what lies beside them.
    Paths,
}

impl Strategy {
    pub const NONE: Self = Self {
        queue_threshold: f32::INFINITY,
        deepest_first: false,
        batch: WIDTH,
        march: Marching::Never,
        warm_start: WarmStart::None,
    };

    /// For what comes after the first hit of a run that marches: where to look first matters less
    /// from then on, since the curve that was found is followed, and to choose costs time.
    pub fn after_first_hit(self) -> Self {
        Self {
            queue_threshold: f32::INFINITY,
            deepest_first: false,
            batch: WIDTH,
            ..self
        }
    }

    /// Whether the first hit should come so soon that the second of siblings has its place too, and
    /// deep triangle pairs are tested first: work that is spared before a hit, at a little more
    /// time for each pair.
    #[inline(always)]
    pub fn ranks(&self) -> bool {
        self.deepest_first && self.batch < WIDTH
    }

    pub fn queues(&self) -> bool {
        self.queue_threshold < f32::INFINITY
    }
}
