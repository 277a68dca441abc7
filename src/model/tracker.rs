//! A correction of predicted quantiles for one pair of meshes, learned from the work of its
//! queries.
//!
//! The weights of the model are right on a mixture of meshes. On a single pair they are off by a
//! factor, which lasts. So the factors of three quantiles are tracked: that of the median is the
//! last error; each outer one takes a step after each query. For the quantile `p` the step is up by
//! `g p` if the query took more than predicted, and down by `g (1 - p)` if less, in log2. Then the
//! share of queries that took more than predicted differs from `1 - p` by at most `(2 R + g) / (g
//! n)` after `n` queries, in whatever order they come. `R` is the largest error that counts,
//! [`LARGEST`]; `g` is [`STEP`].

use super::prediction::Quantiles;
use libm::{exp2, log2};

/// Size of a step, in log2. With smaller ones the quantiles are sharper, but follow later.
const STEP: f32 = 1.5;

/// Largest error that counts, in log2.
const LARGEST: f32 = 8.0;

/// The levels of the outer quantiles.
const LEVELS: [f32; 2] = [0.1, 0.9];

/// log2 of the factors of three predicted quantiles; 0 at first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "[f32; 3]", into = "[f32; 3]"))]
pub struct Tracker([f32; 3]);

impl Tracker {
    /// True if nothing was learned yet.
    pub fn is_new(&self) -> bool {
        *self == Self::default()
    }

    /// The quantiles for this pair, from those of the model.
    pub fn corrected(&self, model: Quantiles) -> Quantiles {
        let [low, middle, high] = self.0.map(|factor| exp2(factor.into()));
        Quantiles::ordered([model.p10 * low, model.p50 * middle, model.p90 * high], 1.0)
    }

    /// Learns from a query that took `actual`, for which the model gave these quantiles. Returns
    /// true if it has learned: a query that is not finished teaches only if it has taken more than
    /// the 90 % quantile.
    pub fn learn(&mut self, model: Quantiles, actual: f64, is_finished: bool) -> bool {
        let error = |quantile: f64| {
            let error = log2(actual.max(1.0)) - log2(quantile.max(1.0));
            (error as f32).clamp(-LARGEST, LARGEST)
        };
        let [low, middle, high] = [model.p10, model.p50, model.p90].map(error);
        if !is_finished && high <= self.0[2] {
            return false;
        }
        self.0[1] = middle;
        for (factor, (error, level)) in [0, 2].into_iter().zip([low, high].into_iter().zip(LEVELS))
        {
            let factor = &mut self.0[factor];
            let step = if error > *factor { level } else { level - 1.0 };
            *factor += STEP * step;
        }
        true
    }
}

impl From<Tracker> for [f32; 3] {
    fn from(Tracker(factors): Tracker) -> Self {
        factors
    }
}

/// An error if learning cannot produce the numbers.
impl TryFrom<[f32; 3]> for Tracker {
    type Error = &'static str;

    fn try_from(factors: [f32; 3]) -> Result<Self, Self::Error> {
        let is_good = |factor: &f32| factor.abs() <= LARGEST + STEP;
        if factors.iter().all(is_good) {
            Ok(Self(factors))
        } else {
            Err("a factor of a tracker is out of range")
        }
    }
}
