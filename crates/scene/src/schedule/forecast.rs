//! Expected cost of a pair, and its probability of intersecting.

use super::known::Known;
use crate::cost::{WORK_PER_QUERY, WORK_PER_WITNESS};
use crate::pair::spent::capped;
use crate::pair::touch::Touch;
use punctual::prediction::MAX_STEP_WORK;

/// The forecast of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forecast {
    /// Work of a complete run, median.
    pub median: u32,
    /// Probability that the pair intersects.
    pub probability: f32,
    /// Expected number of frames, this one and those after it, with a known intersection, per unit
    /// of work; at most 1.
    pub gain: f32,
}

impl Forecast {
    /// The forecast when nothing depends on it: all pairs have equal costs.
    pub const EQUAL: Self = Self {
        median: 1,
        probability: 0.0,
        gain: 0.0,
    };

    /// The forecast of a pair decided `age` frames ago, from its record, or else from the fourth
    /// roots of the triangle counts, and from the [overlap](crate::body::Bodies::common_part) of
    /// the boxes.
    #[inline]
    pub fn new(known: &Known, age: f32, sizes: [f32; 2], part: f32) -> Self {
        let cost = match known.cost {
            // Near contact, work grows about like the fourth root of the product of the triangle
            // counts.
            0 => (40.0 * sizes[0] * sizes[1]) as u32,
            cost => cost,
        };
        let probability = if known.is_lost() {
            LEAST_OF_LOST + (MOST_OF_LOST - LEAST_OF_LOST) * saturating(part, HALF_PART)
        } else if known.met() {
            (1.0 - PARTED * age).max(LEAST_OF_MET)
        } else if known.is_decided() {
            let search = cost as f32 + MORE_WORK;
            (NEW_CONTACT * age * search * part * saturating(part, HALF_PART)).min(MOST_OF_APART)
        } else {
            saturating(part * part, NEVER_DECIDED)
        };
        let median = capped(u64::from(cost) + WORK_PER_QUERY);
        // After an intersection is found once, its witness finds it as long as the witness lasts.
        let steadiness = known.steadiness();
        let later = steadiness / (1.0 + SHORTEST_LOSS - steadiness);
        let gain = probability * (1.0 + later) / (median as f32 + later * WORK_PER_WITNESS as f32);
        Self {
            median,
            probability,
            gain,
        }
    }

    /// The forecast of the contacts of a pair: from the last run, or else from the triangle counts.
    /// `need`: how far the bodies have moved since they were found, relative to the skin.
    pub fn of_contacts(touch: Option<&Touch>, sizes: [f32; 2], need: f32) -> Self {
        let (cost, pending) = touch.map_or((0, 0), |touch| (touch.cost, touch.pending.work));
        let whole = match cost {
            0 => CONTACTS * (sizes[0] * sizes[1]) as u64,
            cost => cost,
        };
        let left = whole.saturating_sub(pending).max(MAX_STEP_WORK);
        let median = capped(left + WORK_PER_QUERY);
        Self {
            median,
            probability: 1.0,
            gain: need.max(f32::MIN_POSITIVE) / median as f32,
        }
    }
}

/// However steady a pair was, its witness is expected to be lost in one frame of 50.
const SHORTEST_LOSS: f32 = 0.02;

/// Per-frame probability that an intersecting pair has separated (.007 and .015 measured on two
/// scenes).
const PARTED: f32 = 0.01;

// These probabilities were fitted on three scenes: `docs/scene.md`.

/// Lower limit of P(contact) for a pair that met before. P(contact) after its witnesses were lost,
/// at zero and at full overlap of the boxes.
const LEAST_OF_MET: f32 = 0.93;
const LEAST_OF_LOST: f32 = 0.55;
const MOST_OF_LOST: f32 = 0.98;

/// The overlap of the boxes at which P(contact) of a lost or separated pair is half of its maximum.
const HALF_PART: f32 = 0.1;

/// P(contact) of a pair that was never decided is one half if the square of the overlap is this.
const NEVER_DECIDED: f32 = 0.1;

/// P(contact) of a separated pair is the product of this factor, the frames since, the work of the
/// separation plus `MORE_WORK`, and the overlap of the boxes; at most `MOST_OF_APART`.
const NEW_CONTACT: f32 = 2.5e-5;
const MORE_WORK: f32 = 1000.0;
const MOST_OF_APART: f32 = 0.5;

/// Work to find the contacts of a pair for the first time, times the fourth roots of the triangle
/// counts.
const CONTACTS: u64 = 300;

/// A function from 0 to 1 that is 1/2 at `x = half`.
#[inline]
fn saturating(x: f32, half: f32) -> f32 {
    x / (x + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::state::PairState;
    use punctual::Verdict;

    #[test]
    fn chances_are_chances_whatever_is_remembered() {
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
            for (number, search, is_lost) in
                [(1, 0, false), (9, 85, true), (1 << 40, u32::MAX, false)]
            {
                let state = PairState {
                    verdict,
                    search,
                    ..PairState::new(0)
                };
                let mut known = Known::new(1);
                known.note(&state, number);
                if is_lost {
                    known.lose();
                }
                let mut before = 0.0;
                for part in [0.0, f32::MIN_POSITIVE, 1e-3, 0.1, 0.5, 1.0] {
                    let forecast = Forecast::new(&known, number as f32, [1.0, 200.0], part);
                    let Forecast {
                        probability, gain, ..
                    } = forecast;
                    assert!(
                        (before..=1.0).contains(&probability),
                        "{verdict:?}, {part}: {forecast:?}"
                    );
                    assert!((0.0..=1.0).contains(&gain), "{forecast:?}");
                    before = probability;
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 72);
    }
}
