//! How sure a partial answer is: the probability that surfaces meet which have not been seen to, and the share of all
//! intersections that a query has found.
//!
//! Both are logistic in features of the front ([`FrontSummary`]), fitted on stopped queries of known truth.

use super::constants::{BASE_RATE, HIT, HIT_AFTER_HISTORY, RECALL};
use super::front::FrontSummary;
use super::prediction::{dot, expected};
use libm::{exp, log, log2};

/// Number of features of [`hit_features`].
pub const HIT_FEATURES: usize = 13;

/// Number of features of [`recall_features`].
pub const RECALL_FEATURES: usize = 9;

/// The prior for which the constants were fitted: the share of poses with an intersection among those.
pub const DEFAULT_PRIOR: f64 = BASE_RATE;

/// What speaks for a hit and against it: triangle pairs that wait (boxes that overlap down to the triangles), triangle tests
/// without a hit, the size, depth and crossing of the open pairs.
pub fn hit_features(front: &FrontSummary) -> [f64; HIT_FEATURES] {
    let waiting = log2(front.triangle_pairs + 1.0);
    let tested = log2(front.triangle_tests + 1.0);
    let nodes = log2(front.node_pairs + 1.0);
    let cost = front.cost.max(1e-9);
    [
        1.0,
        waiting,
        tested,
        nodes,
        log2(front.cost + 1.0),
        front.crossing,
        front.deepest,
        front.largest / cost,
        front.depth / cost,
        f64::from(front.triangle_pairs == 0.0),
        0.1 * waiting * waiting,
        0.1 * waiting * tested,
        0.1 * waiting * nodes,
    ]
}

/// What an earlier frame said: the logit from the front, and the verdict as +1 or -1, less the longer ago.
pub fn history_features(logit: f64, met: bool, frames_undecided: u32) -> [f64; 3] {
    let verdict = if met { 1.0 } else { -1.0 };
    [1.0, logit, verdict / (1.0 + f64::from(frames_undecided))]
}

/// Probability that the surfaces meet, if the query has found no hit; 0 if nothing is left to look at.
///
/// `last` is the verdict of the last decided frame of the pair and how many frames have passed undecided since. `prior` is
/// the share of hits among the poses that the caller asks about; it shifts the odds from [`DEFAULT_PRIOR`]. Between 0 and 1,
/// both excluded unless nothing is left or the prior is 0 or 1, and rising with the prior.
pub fn probability(front: &FrontSummary, last: Option<(bool, u32)>, prior: f64) -> f64 {
    if front.is_done() {
        return 0.0;
    }
    let from_front = dot(&HIT, &hit_features(front));
    let logit =
        last.map_or(from_front, |(met, frames)| dot(&HIT_AFTER_HISTORY, &history_features(from_front, met, frames)));
    let shift = odds(prior.clamp(0.0, 1.0)) / odds(BASE_RATE);
    let odds = exp(logit.clamp(-20.0, 20.0)) * shift;
    if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 }
}

fn odds(probability: f64) -> f64 {
    probability / (1.0 - probability)
}

/// What the recall depends on: hits found, the work done for them, and the work that is left.
pub fn recall_features(front: &FrontSummary) -> [f64; RECALL_FEATURES] {
    [
        1.0,
        log2(expected(front) + 1.0),
        log2(front.found + 1.0),
        log2(front.triangle_tests + 1.0),
        log2(front.bv_tests + 1.0),
        log2(front.triangle_pairs + 1.0),
        front.deepest,
        front.depth / front.cost.max(1e-9),
        front.crossing,
    ]
}

/// Expected share of the intersecting pairs that has been found: 1 if nothing is left, 0 if nothing is found yet.
pub fn recall(front: &FrontSummary) -> f64 {
    if front.is_done() {
        1.0
    } else if front.found == 0.0 {
        0.0
    } else {
        1.0 / (1.0 + exp(-dot(&RECALL, &recall_features(front))))
    }
}

/// The logit of a probability.
pub fn logit(probability: f64) -> f64 {
    log(odds(probability))
}
