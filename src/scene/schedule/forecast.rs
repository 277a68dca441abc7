//! What a pair is expected to cost, and how likely it intersects.

use crate::model::cost::{MAX_STEP_WORK, WORK_PER_QUERY, WORK_PER_WITNESS};
use crate::query::Verdict;
use crate::scene::pair::frame::Frame;
use crate::scene::pair::spent::capped;
use crate::scene::pair::state::PairState;

/// Expectations of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forecast {
    /// Work of a run to its end, median.
    pub median: u32,
    /// The same, 90 % quantile.
    pub high: u32,
    /// Probability that it intersects.
    pub probability: f32,
    /// Intersections that are expected to be known, in this frame and in those after it, for a unit
    /// of work; at most 1.
    pub gain: f32,
}

impl Forecast {
    /// Where nothing depends on it: all pairs are taken to cost the same.
    pub const EQUAL: Self = Self {
        median: 1,
        high: 1,
        probability: 0.0,
        gain: 0.0,
    };

    /// From what is remembered, or else from the fourth roots of the triangle counts, in a frame;
    /// and from the part that the boxes have [in common](crate::scene::body::Bodies::common_part).
    #[inline]
    pub fn new(state: &PairState, sizes: [f32; 2], part: f32, frame: &Frame) -> Self {
        let age = (frame.number - frame.decided(state)) as f32;
        let probability = match state.verdict {
            Verdict::Intersecting { .. } | Verdict::Within { .. }
                if state.is_lost(frame.number) =>
            {
                LEAST_OF_LOST + (MOST_OF_LOST - LEAST_OF_LOST) * saturating(part, HALF_PART)
            }
            Verdict::Intersecting { .. } | Verdict::Within { .. } => {
                (1.0 - PARTED * age).max(LEAST_OF_MET)
            }
            Verdict::Undecided => saturating(part * part, NEVER_DECIDED),
            Verdict::Separated => {
                let search = state.search as f32 + MORE_WORK;
                (NEW_CONTACT * age * search * part * saturating(part, HALF_PART)).min(MOST_OF_APART)
            }
        };
        let (median, high) = expected_cost(state, sizes);
        let [median, high] = [median, high].map(|work| capped(work + WORK_PER_QUERY));
        // What is found once is found by its witness as long as that lasts.
        let later = state.steadiness / (1.0 + SHORTEST_LOSS - state.steadiness);
        let gain = probability * (1.0 + later) / (median as f32 + later * WORK_PER_WITNESS as f32);
        Self {
            median,
            high,
            probability,
            gain,
        }
    }

    /// Of the contacts of a pair that is known to meet: from the last run, or else from what a
    /// search takes.
    pub fn of_contacts(state: &PairState, sizes: [f32; 2]) -> Self {
        let (cost, pending) = state
            .touch
            .as_ref()
            .map_or((0, 0), |touch| (touch.cost, touch.pending.work));
        let (guess, spread) = match cost {
            0 => (CONTACTS * (sizes[0] * sizes[1]) as u64, 4),
            cost => (cost, 2),
        };
        let median = guess.saturating_sub(pending).max(MAX_STEP_WORK) + WORK_PER_QUERY;
        let (median, high) = (capped(median), capped(spread * median));
        Self {
            median,
            high,
            probability: 1.0,
            gain: 1.0 / median as f32,
        }
    }
}

/// However steady a pair was, its witness is expected to be lost in one frame of 50.
const SHORTEST_LOSS: f32 = 0.02;

/// Per-frame probability that an intersecting pair has separated (.007 and .015 measured on two
/// scenes).
const PARTED: f32 = 0.01;

// These chances were fitted on three scenes: `docs/scene.md`.

/// However long ago a pair met, unless its witnesses were lost, the least chance that it does; and
/// if they were, the chance where boxes have next to nothing in common, and all.
const LEAST_OF_MET: f32 = 0.93;
const LEAST_OF_LOST: f32 = 0.55;
const MOST_OF_LOST: f32 = 0.98;

/// The part in common at which the chances of a pair that was lost or apart are half way to their
/// largest.
const HALF_PART: f32 = 0.1;

/// That of a pair that was never decided is one half where this is the square of that part.
const NEVER_DECIDED: f32 = 0.1;

/// That of a pair that was apart, for each frame since, each unit of work that it took to find it
/// apart and so many more, and that part; and the most that it is.
const NEW_CONTACT: f32 = 2.5e-5;
const MORE_WORK: f32 = 1000.0;
const MOST_OF_APART: f32 = 0.5;

/// Work of finding the contacts of a pair for the first time, times the fourth roots of the
/// triangle counts.
const CONTACTS: u64 = 2000;

/// Work of a query that no remembered witness spares, median and 90 % quantile.
#[inline]
fn expected_cost(state: &PairState, sizes: [f32; 2]) -> (u64, u64) {
    let (search, spread) = if state.search > 0 {
        (u64::from(state.search), u64::from(state.search / 2))
    } else {
        // Near contact, work grows about like the fourth root of the product of the triangle
        // counts.
        let guess = (40.0 * sizes[0] * sizes[1]) as u64;
        (guess, 4 * guess)
    };
    let left = search.saturating_sub(state.pending.work).max(MAX_STEP_WORK);
    (left, left + spread)
}

/// From 0 to 1, and 1/2 where `x` is `half`.
#[inline]
fn saturating(x: f32, half: f32) -> f32 {
    x / (x + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::{Budget, ManualClock, Mode};
    use crate::scene::body::Bodies;
    use crate::scene::schedule::crew::Alone;
    use alloc::sync::Arc;

    #[test]
    fn chances_are_chances_whatever_is_remembered() {
        let (clock, bodies) = (ManualClock::new(), Arc::new(Bodies::default()));
        let (mode, budget, crew) = (Mode::Any, Budget::unlimited(), Alone(&clock));
        let within = Verdict::Within {
            witness: [0; 2],
            distance: 1.0,
        };
        let verdicts = [
            Verdict::Undecided,
            Verdict::Separated,
            Verdict::Intersecting { witness: [0; 2] },
            within,
        ];
        let mut cases = 0;
        for verdict in verdicts {
            for (number, search, refuted) in [(1, 0, 0), (9, 85, 9), (1 << 40, u32::MAX, 0)] {
                let frame = Frame {
                    number,
                    mode,
                    asked_since: 0,
                    rest: [0; 2],
                    cut: false,
                    moved: true,
                    budget,
                    times: Default::default(),
                    clock: &clock,
                    bodies: &bodies,
                    crew: &crew,
                };
                let state = PairState {
                    verdict,
                    search,
                    refuted,
                    ..PairState::new(0)
                };
                let mut before = 0.0;
                for part in [0.0, f32::MIN_POSITIVE, 1e-3, 0.1, 0.5, 1.0] {
                    let forecast = Forecast::new(&state, [1.0, 200.0], part, &frame);
                    let Forecast {
                        probability,
                        gain,
                        median,
                        high,
                    } = forecast;
                    assert!(
                        (before..=1.0).contains(&probability),
                        "{verdict:?}, {part}: {forecast:?}"
                    );
                    assert!(
                        (0.0..=1.0).contains(&gain) && median <= high,
                        "{forecast:?}"
                    );
                    before = probability;
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 72);
    }
}
