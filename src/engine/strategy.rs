//! The choices of a run, made once at its start from the question and the budget.

use super::deadline::Budget;
use super::frontier::order::Order;
use super::options::{Mode, Options};
use super::triangles::PATIENCE;
use crate::tree::WIDTH;
use core::time::Duration;

/// The aim of a run. All plans give the same finished answer; they differ in speed and in what a
/// stopped run has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// Nothing is expected to stop the run: the complete answer in the least time, depth-first.
    FinishSoon,
    /// All pairs are wanted, and a budget may cut the run: many pairs early. Queues node pairs
    /// until the first hit, then traces contact curves from hits.
    FindMuch,
    /// One hit is wanted, and a budget may cut the run: the first hit early.
    FindOne,
}

/// Curves are traced until the traversal has done this much work for each node pair on the
/// frontier: about a fourth of all work, because a pair takes about 800 units.
const WORK_PER_PAIR: u64 = 200;

/// Triangle pairs that wait before they are tested, if the first hit should come soon.
const BATCH_BEFORE_HIT: usize = 2;

impl Plan {
    /// The plan of a run for a mode.
    #[inline(always)]
    pub fn of(mode: Mode, may_be_cut: bool) -> Self {
        match (may_be_cut, mode) {
            (false, _) => Self::FinishSoon,
            (true, Mode::All) => Self::FindMuch,
            (true, Mode::Any) => Self::FindOne,
        }
    }

    /// The plan of a run within a budget. `fits` returns true if a time is expected to suffice.
    ///
    /// Budgets of work promise the same bits however they cut the work, so their size decides
    /// nothing.
    #[inline(always)]
    pub fn within(budget: Budget, mode: Mode, fits: impl FnOnce(Duration) -> bool) -> Self {
        let is_short = budget.time.is_some_and(|limit| !fits(limit));
        Self::of(mode, budget.work.is_some() || is_short)
    }

    /// The choices of the plan.
    #[inline(always)]
    pub fn strategy(self, options: &Options) -> Strategy {
        if options.is_plain {
            return Strategy::NONE;
        }
        // Siblings are ranked by the key of the queue. A stack alone has no key.
        let (queue, deepest_first) = match options.order {
            Order::DepthFirst => (None, false),
            order => (Some(order), true),
        };
        match (self, options.mode) {
            (Self::FinishSoon, Mode::All) => Strategy {
                batch: PATIENCE,
                ..Strategy::NONE
            },
            (Self::FinishSoon, Mode::Any) => Strategy {
                deepest_first,
                warm_start: WarmStart::Witnesses,
                ..Strategy::NONE
            },
            (Self::FindMuch, _) => Strategy {
                queue,
                deepest_first,
                batch: BATCH_BEFORE_HIT,
                trace: Tracing::Within(WORK_PER_PAIR),
                warm_start: WarmStart::Paths,
            },
            (Self::FindOne, _) => Strategy {
                queue,
                deepest_first,
                batch: BATCH_BEFORE_HIT,
                warm_start: WarmStart::Witnesses,
                ..Strategy::NONE
            },
        }
    }
}

/// The choices of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Strategy {
    /// The order of the queue. `None`: all node pairs go on the stack.
    pub queue: Option<Order>,
    /// True if the deepest of siblings goes on top of the stack.
    pub deepest_first: bool,
    /// Triangle pairs that wait before they are tested.
    pub batch: usize,
    pub trace: Tracing,
    /// Use of the triangle pairs that intersected in the previous frame.
    pub warm_start: WarmStart,
}

/// Selects whether contact curves are traced from hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tracing {
    Never,
    /// Until the traversal has done more work than this for each node pair on the frontier.
    Within(u64),
    /// Tracing has ended. Pairs that were found along curves are remembered, so that none is
    /// reported twice.
    Over,
}

impl Tracing {
    /// True while curves are traced.
    #[inline(always)]
    pub fn goes_on(self) -> bool {
        matches!(self, Self::Within(_))
    }
}

/// The pairs visited before anything else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WarmStart {
    None,
    /// The remembered triangle pairs, then the nodes above the latest.
    Witnesses,
    /// The paths down to the remembered triangle pairs, then the node pairs next to them.
    Paths,
}

impl Strategy {
    pub const NONE: Self = Self {
        queue: None,
        deepest_first: false,
        batch: WIDTH,
        trace: Tracing::Never,
        warm_start: WarmStart::None,
    };

    /// The choices after the first hit of a run that traces curves. From then on the order of
    /// visits matters less, because the curve found is traced, and choosing costs time.
    pub fn after_first_hit(self) -> Self {
        Self {
            queue: None,
            deepest_first: false,
            batch: WIDTH,
            ..self
        }
    }

    /// True if the first hit should come as soon as possible: then the second deepest of siblings
    /// is ranked too, and deep triangle pairs are tested first. That saves work before a hit, at
    /// slightly more time per pair.
    #[inline(always)]
    pub fn ranks(&self) -> bool {
        self.deepest_first && self.batch < WIDTH
    }
}
