//! Certainty of a partial answer: the probability that two surfaces intersect although no
//! intersection has been found yet, and the fraction of all intersections that a query has found.
//!
//! Both are logistic functions of features of the frontier ([`FrontierSummary`]), fitted on stopped
//! queries with known outcome.

use super::constants::{BASE_RATE, HIT, HIT_AFTER_HISTORY, HIT_BEFORE, RECALL, RECALL_TRACING};
use super::frontier::FrontierSummary;
use super::prediction::{dot, expected};
use libm::{exp, log, log2};

/// The prior for which the constants were fitted: the fraction of the fitted poses that have an
/// intersection.
pub const DEFAULT_PRIOR: f64 = BASE_RATE;

/// Features of the probability of a hit: waiting triangle pairs (their boxes overlap, but they are
/// not tested yet), triangle tests without a hit, and the size, depth and crossing of the open node
/// pairs.
pub fn hit_features(frontier: &FrontierSummary) -> [f64; 13] {
    let waiting = log2(frontier.triangle_pairs + 1.0);
    let tested = log2(frontier.triangle_tests + 1.0);
    let nodes = log2(frontier.node_pairs + 1.0);
    let cost = frontier.cost.max(1e-9);
    [
        1.0,
        waiting,
        tested,
        nodes,
        log2(frontier.cost + 1.0),
        frontier.crossing,
        frontier.deepest,
        frontier.largest / cost,
        frontier.depth / cost,
        f64::from(frontier.triangle_pairs == 0.0),
        0.1 * waiting * waiting,
        0.1 * waiting * tested,
        0.1 * waiting * nodes,
    ]
}

/// State remembered from earlier frames of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct History {
    /// True if the surfaces met in the last decided frame.
    pub met: bool,
    /// Number of undecided frames since that frame.
    pub frames_undecided: u32,
    /// Rate at which the verdict changes from one decided frame to the next, 0 to 1.
    pub change_rate: f64,
}

/// Features of the logit of a hit with a history:
/// - the logit from the frontier;
/// - the last verdict as +1 or -1, divided by one plus the number of undecided frames since;
/// - the previous feature times the logit of the probability that the verdict persists, which
///   follows from the rate of changes;
/// - the deepest penetration in the frontier, alone and times the second feature. It is more
///   informative for a pair in motion than for a pair at an arbitrary pose.
pub fn history_features(logit: f64, deepest: f64, history: &History) -> [f64; 6] {
    let sign = if history.met { 1.0 } else { -1.0 };
    let verdict = sign / (1.0 + f64::from(history.frames_undecided));
    let rate = history.change_rate.clamp(1e-3, 1.0 - 1e-3);
    [
        1.0,
        logit,
        verdict,
        verdict * log((1.0 - rate) / rate),
        deepest,
        verdict * deepest,
    ]
}

/// Probability that the surfaces meet, if the query has found no hit; 0 if nothing is left that may
/// meet.
///
/// `prior` is the fraction of hits among the poses that the caller asks about. It shifts the odds
/// from [`DEFAULT_PRIOR`], and the result rises with it. The result is between 0 and 1, both
/// excluded unless nothing is left or the prior is 0 or 1.
pub fn probability(frontier: &FrontierSummary, history: Option<&History>, prior: f64) -> f64 {
    if frontier.is_clear() {
        return 0.0;
    }
    let weights = if frontier.is_begun() {
        &HIT
    } else {
        &HIT_BEFORE
    };
    let from_frontier = dot(weights, &hit_features(frontier));
    let with = |history| {
        dot(
            &HIT_AFTER_HISTORY,
            &history_features(from_frontier, frontier.deepest, history),
        )
    };
    let logit = history.map_or(from_frontier, with);
    let shift = odds(prior.clamp(0.0, 1.0)) / odds(BASE_RATE);
    let odds = exp(logit.clamp(-20.0, 20.0)) * shift;
    if odds.is_finite() {
        odds / (1.0 + odds)
    } else {
        1.0
    }
}

fn odds(probability: f64) -> f64 {
    probability / (1.0 - probability)
}

/// Features of the recall: hits found, work done to find them, and work left.
pub fn recall_features(frontier: &FrontierSummary) -> [f64; 9] {
    [
        1.0,
        log2(expected(frontier) + 1.0),
        log2(frontier.found + 1.0),
        log2(frontier.triangle_tests + 1.0),
        log2(frontier.bv_tests + 1.0),
        log2(frontier.triangle_pairs + 1.0),
        frontier.deepest,
        frontier.depth / frontier.cost.max(1e-9),
        frontier.crossing,
    ]
}

/// Features of the recall of a query that traces curves. The pairs found are of three kinds:
/// 1. found by tracing, and not reached by the boxes yet;
/// 2. found by tracing, and reached by the boxes since;
/// 3. found by a triangle test, because tracing had not found them.
///
/// The fraction of the second kind among the pairs that the boxes have reached estimates the
/// fraction of all pairs that tracing has found.
pub fn tracing_features(frontier: &FrontierSummary) -> [f64; 19] {
    let [
        one,
        left,
        found,
        tests,
        bv_tests,
        waiting,
        deepest,
        depth,
        crossing,
    ] = recall_features(frontier);
    let kinds = [
        frontier.followed - frontier.passed,
        frontier.passed,
        frontier.found - frontier.followed,
    ];
    let traced = frontier.passed / (frontier.passed + kinds[2]).max(1.0);
    let [ahead, passed, new] = kinds.map(|count| log2(count.max(0.0) + 1.0));
    let follows = f64::from(frontier.follows);
    [
        one,
        left,
        ahead,
        passed,
        new,
        tests,
        bv_tests,
        waiting,
        deepest,
        depth,
        crossing,
        follows,
        follows * ahead,
        found,
        log2(frontier.cost + 1.0),
        log2(frontier.probed + 1.0),
        traced,
        traced * ahead,
        traced * left,
    ]
}

/// A second source of intersecting pairs, apart from a query's boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lead {
    /// None: the query only follows its boxes.
    Nothing,
    /// The query follows the curves along which surfaces meet.
    Curves,
}

/// Expected fraction of the intersecting pairs that has been found: 1 if nothing is left that may
/// meet, 0 if nothing is found yet.
pub fn recall(frontier: &FrontierSummary, lead: Lead) -> f64 {
    if frontier.is_clear() {
        return 1.0;
    }
    if frontier.found == 0.0 {
        return 0.0;
    }
    let logit = match lead {
        Lead::Nothing => dot(&RECALL, &recall_features(frontier)),
        Lead::Curves => dot(&RECALL_TRACING, &tracing_features(frontier)),
    };
    1.0 / (1.0 + exp(-logit))
}
