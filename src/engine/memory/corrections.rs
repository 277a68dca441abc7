//! Predictions for the queries of one pair: quantiles of the model, corrected by the outcomes of
//! earlier predictions.

use crate::engine::options::Mode;
use crate::engine::workspace::Key;
use crate::model::prediction::Quantiles;
use crate::model::tracker::Tracker;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The predicted quantities, each with a correction of its own: BV tests and work of an
/// intersection query, work of all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Sought {
    Distance,
    /// A distance query with a limit.
    Closer,
    Motion,
    Manifolds,
    TestsOfAny,
    TestsOfAll,
    WorkOfAny,
    WorkOfAll,
}

const KINDS: usize = 8;

impl Sought {
    pub fn tests(mode: Mode) -> Self {
        match mode {
            Mode::Any => Self::TestsOfAny,
            Mode::All => Self::TestsOfAll,
        }
    }

    pub fn work(mode: Mode) -> Self {
        match mode {
            Mode::Any => Self::WorkOfAny,
            Mode::All => Self::WorkOfAll,
        }
    }
}

/// For each [`Sought`] two corrections: for predictions before a query, and for those after a part
/// of it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub(crate) struct Corrections([[Corrected; 2]; KINDS]);

#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
struct Corrected {
    tracker: Tracker,
    #[cfg_attr(feature = "serde", serde(skip))]
    pending: Pending,
}

/// A prediction that waits for its outcome: the [`tag`] of its query (0 if none), and as `f32` the
/// work done by then and three quantiles of the work left. It is written through a shared
/// reference, because predicting needs no exclusive one.
#[derive(Debug, Default)]
struct Pending([AtomicU32; 5]);

impl Pending {
    fn words(&self) -> [u32; 5] {
        self.0.each_ref().map(|word| word.load(Relaxed))
    }
}

impl Clone for Pending {
    fn clone(&self) -> Self {
        Self(self.words().map(AtomicU32::new))
    }
}

/// Pending predictions do not count when memories are compared.
impl PartialEq for Pending {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Tells the queries of a pair apart: a hash of the pose, never 0. Motions with the same start
/// count as one; a prediction for the wrong one is one lesson among many.
fn tag(key: &Key) -> u32 {
    let fold = |hash: u64, x: f64| {
        (hash.rotate_left(25) ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    };
    let numbers = key.b_in_a.to_row_major();
    (numbers.into_iter().fold(0, fold) >> 32) as u32 | 1
}

impl Corrections {
    /// The quantiles of the work left in a query that has done `used`, from those of the model;
    /// `None` while nothing is learned. Once the query has ended, [`Self::learn`] learns from them.
    pub fn predict(
        &self,
        sought: Sought,
        key: &Key,
        used: f64,
        model: Quantiles,
    ) -> Option<Quantiles> {
        let stage = usize::from(used > 0.0);
        let Corrected { tracker, pending } = &self.0[sought as usize][stage];
        let Quantiles { p10, p50, p90 } = model;
        let numbers = [used, p10, p50, p90].map(|x| (x as f32).to_bits());
        for (word, value) in pending.0.iter().zip([tag(key)].into_iter().chain(numbers)) {
            word.store(value, Relaxed);
        }
        (!tracker.is_new()).then(|| tracker.corrected(model))
    }

    /// Learns from a call of a query that has done this much by now.
    #[inline]
    pub fn learn(&mut self, sought: Sought, key: Option<&Key>, done: u64, is_finished: bool) {
        for Corrected { tracker, pending } in &mut self.0[sought as usize] {
            let [of, numbers @ ..] = pending.words();
            if of == 0 || key.is_none_or(|key| tag(key) != of) {
                continue;
            }
            let [used, p10, p50, p90] = numbers.map(|bits| f64::from(f32::from_bits(bits)));
            // A query whose answer was known does not show the work of a search.
            let has_learned = done > 0
                && tracker.learn(Quantiles { p10, p50, p90 }, done as f64 - used, is_finished);
            if has_learned || is_finished {
                *pending = Pending::default();
            }
        }
    }
}
