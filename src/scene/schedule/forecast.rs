//! What a pair is expected to cost, and how likely it intersects.

use crate::model::cost::{MAX_STEP_WORK, WORK_PER_QUERY};
use crate::query::Verdict;
use crate::scene::pair::spent::capped;
use crate::scene::pair::state::PairState;

/// Expectations of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forecast {
    /// Work of a run to its end, median.
    pub median: u32,
    /// The same, 90 % quantile.
    pub high: u32,
    /// The median if no remembered witness spares the search.
    pub search: u32,
    /// Probability that it intersects, and the same if its last witnesses do not meet any more.
    pub still: f32,
    pub chance: f32,
}

impl Forecast {
    /// From what is remembered, or else from the fourth roots of the triangle counts. `age`: frames since it was decided.
    #[inline]
    pub fn new(state: &PairState, sizes: [f32; 2], age: u64) -> Self {
        let (search, high) = expected_cost(state, sizes);
        let chance = match state.verdict {
            Verdict::Intersecting { .. } => LOST_WITNESS,
            Verdict::Undecided => NEVER_DECIDED,
            Verdict::Separated => (NEW_CONTACT * state.search as f32 * age as f32).min(NEVER_DECIDED),
        };
        let (median, still) = match state.verdict {
            Verdict::Intersecting { .. } => {
                (u64::from(state.cost).min(search), (1.0 - PARTED * age as f32).max(chance))
            }
            _ => (search, chance),
        };
        let [median, high, search] = [median, high, search].map(|work| capped(work + WORK_PER_QUERY));
        Self { median, high, search, still, chance }
    }

    /// Of the contacts of a pair that is known to meet: from the last run, or else from what a search takes.
    pub fn of_contacts(state: &PairState, sizes: [f32; 2]) -> Self {
        let (cost, pending) = state.touch.as_ref().map_or((0, 0), |touch| (touch.cost, touch.pending.work));
        let (guess, spread) = match cost {
            0 => (CONTACTS * (sizes[0] * sizes[1]) as u64, 4),
            cost => (cost, 2),
        };
        let median = guess.saturating_sub(pending).max(MAX_STEP_WORK) + WORK_PER_QUERY;
        let (search, high) = (capped(median), capped(spread * median));
        Self { median: search, high, search, still: 1.0, chance: 1.0 }
    }

    /// Chance of finding an intersection per expected work; at most 1.
    #[inline]
    pub fn gain(&self) -> f32 {
        self.chance / (self.search as f32 + 1.0)
    }
}

/// Per-frame probability that an intersecting pair has separated (.007 and .015 measured on two scenes).
const PARTED: f32 = 0.01;

/// Chances that a pair intersects: whose remembered witnesses do not meet any more (.92 and .95 measured on two scenes); that
/// was never decided; and for each unit of work that it took to find it apart, and each frame since (1e-5 and 1e-4).
const LOST_WITNESS: f32 = 0.93;
const NEVER_DECIDED: f32 = 0.3;
const NEW_CONTACT: f32 = 3e-5;

/// Work of finding the contacts of a pair for the first time, times the fourth roots of the triangle counts.
const CONTACTS: u64 = 2000;

/// Work of a query that no remembered witness spares, median and 90 % quantile.
#[inline]
fn expected_cost(state: &PairState, sizes: [f32; 2]) -> (u64, u64) {
    let (search, spread) = if state.search > 0 {
        (u64::from(state.search), u64::from(state.search / 2))
    } else {
        // Near contact, work grows about like the fourth root of the product of the triangle counts.
        let guess = (40.0 * sizes[0] * sizes[1]) as u64;
        (guess, 4 * guess)
    };
    let left = search.saturating_sub(state.pending.work).max(MAX_STEP_WORK);
    (left, left + spread)
}
