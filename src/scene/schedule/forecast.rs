//! What a pair is expected to cost, and how likely it intersects.

use crate::model::cost::{MAX_STEP_WORK, WORK_PER_QUERY, WORK_PER_WITNESS};
use crate::query::Verdict;
use crate::scene::pair::frame::Frame;
use crate::scene::pair::spent::capped;
use crate::scene::pair::state::PairState;

/// Expectations of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forecast {
    /// Work of a run to its end, median.
    pub median: u32,
    /// The same, 90 % quantile.
    pub high: u32,
    /// Probability that it intersects.
    pub probability: f32,
    /// Intersections that are expected to be known, in this frame and in those after it, for a unit of work; at most 1.
    pub gain: f32,
}

impl Forecast {
    /// From what is remembered, or else from the fourth roots of the triangle counts, in a frame.
    #[inline]
    pub fn new(state: &PairState, sizes: [f32; 2], frame: &Frame) -> Self {
        let age = (frame.number - frame.decided(state)) as f32;
        let probability = match state.verdict {
            Verdict::Intersecting { .. } if state.is_lost(frame.number) => LOST_WITNESS,
            Verdict::Intersecting { .. } => (1.0 - PARTED * age).max(LOST_WITNESS),
            Verdict::Undecided => (NEVER_DECIDED * age).min(MOST_OF_UNKNOWN),
            Verdict::Separated => (NEW_CONTACT * state.search as f32 * age).min(MOST_OF_UNKNOWN),
        };
        let (median, high) = expected_cost(state, sizes);
        let [median, high] = [median, high].map(|work| capped(work + WORK_PER_QUERY));
        // What is found once is found by its witness as long as that lasts.
        let later = state.steadiness / (1.0 + SHORTEST_LOSS - state.steadiness);
        let gain = probability * (1.0 + later) / (median as f32 + later * WORK_PER_WITNESS as f32);
        Self { median, high, probability, gain }
    }

    /// Of the contacts of a pair that is known to meet: from the last run, or else from what a search takes.
    pub fn of_contacts(state: &PairState, sizes: [f32; 2]) -> Self {
        let (cost, pending) = state.touch.as_ref().map_or((0, 0), |touch| (touch.cost, touch.pending.work));
        let (guess, spread) = match cost {
            0 => (CONTACTS * (sizes[0] * sizes[1]) as u64, 4),
            cost => (cost, 2),
        };
        let median = guess.saturating_sub(pending).max(MAX_STEP_WORK) + WORK_PER_QUERY;
        let (median, high) = (capped(median), capped(spread * median));
        Self { median, high, probability: 1.0, gain: 1.0 / median as f32 }
    }
}

/// However steady a pair was, its witness is expected to be lost in one frame of 50.
const SHORTEST_LOSS: f32 = 0.02;

/// Per-frame probability that an intersecting pair has separated (.007 and .015 measured on two scenes).
const PARTED: f32 = 0.01;

/// Chances that a pair intersects: whose remembered witnesses do not meet any more (.92 and .95 measured on two scenes); that
/// was never decided, for each frame since their boxes met (.005 to .015 in the first); for each unit of work that it took to
/// find it apart, and each frame since (1e-5 and 1e-4); and the most of the last two.
const LOST_WITNESS: f32 = 0.93;
const NEVER_DECIDED: f32 = 0.01;
const NEW_CONTACT: f32 = 3e-5;
const MOST_OF_UNKNOWN: f32 = 0.3;

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
