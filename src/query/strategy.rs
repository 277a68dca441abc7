//! How a run goes about its visits: decided once, when it begins, from what is asked and what it may spend.

use super::budget::Budget;
use super::options::{Mode, Options};
use super::order::Order;
use super::triangle_pairs::PATIENCE;
use crate::tree::WIDTH;

/// Node pairs that are expected to take at least so many BV tests wait in the queue, if there is one: by default, and where much
/// should be known early. Where curves are followed by default there is none: they lead to more than its order would.
const QUEUE_THRESHOLD: f32 = 128.0;
const EARLY_QUEUE_THRESHOLD: f32 = 48.0;

/// Work of the traversal for each node pair on the front up to which curves are followed, by default and where much should be
/// known early. A pair takes some 800 units, so this is about a fourteenth and a fourth of all.
const CURVES_WORK_PER_PAIR: u64 = 56;
const EARLY_WORK_PER_PAIR: u64 = 200;

/// Triangle pairs that wait before they are tested, where the first hit should come soon.
const BATCH_BEFORE_HIT: usize = 2;

/// The choices of a run. All give the same finished answer; they differ in speed and in what a stopped run has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strategy {
    /// Least expected BV tests of a node pair that is queued; cheaper ones are finished depth-first at once. Infinite: no
    /// queue.
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

    /// For a run that nothing will stop: depth-first, which costs least.
    pub fn complete(options: &Options) -> Self {
        let default_order = options.order == Order::default();
        let (deepest_first, warm_start) = match options.mode {
            // The stack with the deepest of siblings on top finds the first hit sooner than the queue.
            Mode::Any => (default_order, WarmStart::Witnesses),
            Mode::All => (false, WarmStart::None),
        };
        Self {
            deepest_first,
            warm_start,
            ..Self::NONE
        }
    }

    /// For a budget. `fits` tells whether a time is expected to last to the end.
    ///
    /// What no budget can cut short, or a budget of time is not expected to, goes depth-first, unless another order was
    /// asked for. Budgets of work promise the same bits however the work is cut into pieces, so their size decides nothing.
    #[inline(always)]
    pub fn choose(
        options: &Options,
        budget: Budget,
        can_march: bool,
        fits: impl FnOnce(core::time::Duration) -> bool,
    ) -> Self {
        let mut strategy = Self::complete(options);
        let default_order = options.order == Order::default();
        let is_short = budget.time.is_some_and(|limit| !fits(limit));
        let stops = budget.work.is_some() || is_short;
        let is_early = is_short || options.early && !budget.is_unlimited();
        let marches =
            can_march && default_order && options.mode == Mode::All && (is_early || stops);
        let (default_threshold, work_per_pair) = match (marches, is_early) {
            (false, _) => (QUEUE_THRESHOLD, 0),
            (true, false) => (f32::INFINITY, CURVES_WORK_PER_PAIR),
            (true, true) => (EARLY_QUEUE_THRESHOLD, EARLY_WORK_PER_PAIR),
        };
        strategy.queue_threshold = match (options.order, options.mode) {
            (Order::DepthFirst, _) => f32::INFINITY,
            (Order::Penetration, _) if !stops && !marches => f32::INFINITY,
            (Order::Penetration, Mode::Any) => options.queue_threshold.unwrap_or(f32::INFINITY),
            _ => options.queue_threshold.unwrap_or(default_threshold),
        };
        if marches {
            strategy.march = Marching::Within(work_per_pair);
            strategy.deepest_first = true;
        }
        if marches || stops && default_order && options.mode == Mode::Any {
            strategy.batch = BATCH_BEFORE_HIT;
        }
        if options.mode == Mode::All {
            if (strategy.queues() || marches) && default_order {
                strategy.warm_start = WarmStart::Paths;
            }
            if !stops {
                // Nothing is expected to come too late, so batches may be as full as possible.
                strategy.batch = PATIENCE;
            }
        }
        strategy
    }

    /// For what comes after the first hit of a run that marches: where to look first matters less from then on, since the
    /// curve that was found is followed, and to choose costs time.
    pub fn after_first_hit(self) -> Self {
        Self {
            queue_threshold: f32::INFINITY,
            deepest_first: false,
            batch: WIDTH,
            ..self
        }
    }

    /// Whether the first hit should come so soon that the second of siblings has its place too, and deep triangle pairs are
    /// tested first: work that is spared before a hit, at a little more time for each pair.
    #[inline(always)]
    pub fn ranks(&self) -> bool {
        self.deepest_first && self.batch < WIDTH
    }

    pub fn queues(&self) -> bool {
        self.queue_threshold < f32::INFINITY
    }
}
