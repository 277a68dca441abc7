//! What a distance query that is under way still costs, and where the distance lies between its bounds: quantiles.
//!
//! Little can be told of either, and what the open pairs look like adds next to nothing to the numbers used here
//! (`docs/model.md`).

use super::constants::{DISTANCE_AFTER, DISTANCE_BETWEEN, DISTANCE_LEFT, LIMIT_LEFT};
use super::cost::WORK_PER_EXPANSION;
use super::prediction::{Quantiles, dot, with_history};
use libm::{exp2, log2};

/// A distance query in numbers, before it or after a part of it.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Triangles of A times those of B.
    pub pairs: f64,
    /// Distance of the middles of their boxes over the sum of their units.
    pub apart: f64,
    /// Units of work done.
    pub work: f64,
    /// What is proven so far.
    pub low: f64,
    /// The same; infinite as long as nothing was found.
    pub high: f64,
    /// The limit over the distance of the middles; `None` if the distance itself is asked for.
    pub limit: Option<f64>,
}

/// A query opens one pair at least.
const LEAST: f64 = WORK_PER_EXPANSION as f64;

/// How far apart the meshes are, and how far a limit is, counts as no more than this: the weights were not fitted on more.
const FARTHEST: f64 = 3.0;

/// What [`work_left`] looks at.
pub fn closing_features(closing: &Closing) -> [f64; 7] {
    let Closing {
        pairs,
        apart,
        work,
        low,
        high,
        limit,
    } = *closing;
    let (is_found, is_proven) = (f64::from(high.is_finite()), f64::from(low > 0.0));
    let known = limit.map_or(ratio(low, high), |limit| limit.min(FARTHEST));
    [
        1.0,
        log2(pairs.max(1.0)),
        log2(work + LEAST),
        is_found,
        is_proven,
        known,
        apart.min(FARTHEST),
    ]
}

/// What [`between`] looks at.
pub fn between_features(closing: &Closing) -> [f64; 4] {
    let [one, _, work, _, is_proven, ..] = closing_features(closing);
    [one, work, is_proven, ratio(closing.low, closing.high)]
}

fn ratio(low: f64, high: f64) -> f64 {
    if low > 0.0 { low / high } else { 0.0 }
}

/// Units of work left, given how many the previous query of the pair took in all.
pub fn work_left(closing: &Closing, previous: Option<f64>) -> Quantiles {
    let x = closing_features(closing);
    let weights = if closing.limit.is_some() {
        LIMIT_LEFT
    } else {
        DISTANCE_LEFT
    };
    let model = Quantiles::ordered(weights.map(|w| exp2(dot(&w, &x))), LEAST);
    previous.map_or(model, |previous| {
        with_history(model, previous, closing.work, DISTANCE_AFTER)
    })
}

/// The distance: within the bounds, and certain only where they are one.
pub fn between(closing: &Closing) -> Quantiles {
    let Closing { low, high, .. } = *closing;
    if high.is_infinite() {
        return Quantiles {
            p10: low,
            p50: high,
            p90: high,
        };
    }
    let x = between_features(closing);
    let at = |w: [f64; 4]| (low + dot(&w, &x).clamp(0.0, 1.0) * (high - low)).min(high);
    Quantiles::ordered(DISTANCE_BETWEEN.map(at), low)
}
