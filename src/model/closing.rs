//! Quantiles of the work left in a distance query, and quantiles of the distance itself, which lies
//! between two proven bounds.
//!
//! Neither can be predicted well. Features of the open pairs add next to nothing to the numbers
//! used here (`docs/model.md`).

use super::constants::{DISTANCE_AFTER, DISTANCE_BETWEEN, DISTANCE_LEFT, LIMIT_LEFT};
use super::cost::WORK_PER_EXPANSION;
use super::prediction::{Quantiles, after, dot};
use libm::{exp2, log2};

/// The inputs of both predictions, for a distance query that has not begun or was stopped. The
/// bounds are in the unit of the meshes.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Number of triangles of A times that of B.
    pub pairs: f64,
    /// Distance between the centers of the meshes' boxes, divided by the sum of the lengths of
    /// their units.
    pub apart: f64,
    /// Units of work done.
    pub work: f64,
    /// Proven lower bound of the distance.
    pub low: f64,
    /// Proven upper bound of the distance; infinite until a pair of points is found.
    pub high: f64,
    /// The limit divided by the distance between the centers; `None` if the query has no limit.
    pub limit: Option<f64>,
}

/// Least work of a query: it opens at least one pair.
const LEAST: f64 = WORK_PER_EXPANSION as f64;

/// Maximum of `apart` and of `limit` as features. Larger values are clamped, because the weights
/// were not fitted on them.
const FARTHEST: f64 = 3.0;

/// Features of [`work_left`].
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

/// Features of [`between`].
pub fn between_features(closing: &Closing) -> [f64; 4] {
    let [one, _, work, _, is_proven, ..] = closing_features(closing);
    [one, work, is_proven, ratio(closing.low, closing.high)]
}

fn ratio(low: f64, high: f64) -> f64 {
    if low > 0.0 { low / high } else { 0.0 }
}

/// Units of work left.
pub fn work_left(closing: &Closing) -> Quantiles {
    let x = closing_features(closing);
    let weights = if closing.limit.is_some() {
        LIMIT_LEFT
    } else {
        DISTANCE_LEFT
    };
    Quantiles::ordered(weights.map(|w| exp2(dot(&w, &x))), LEAST)
}

/// Predicts the units of work of a query from those of the `previous` query of its pair alone.
pub fn work_after(previous: f64) -> Quantiles {
    after(previous, DISTANCE_AFTER)
}

/// Quantiles of the distance. They are within the bounds, and certain only if the bounds are equal.
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
