//! What a motion query that is under way still costs: quantiles, from a few numbers that take no look at the meshes.

use super::constants::{MOTION_AFTER, MOTION_LEFT};
use super::cost::WORK_PER_SWEPT_EXPANSION;
use super::prediction::{Quantiles, dot, with_history};
use libm::{exp2, log2};

/// A motion query in numbers, before it or after a part of it. Lengths are over the sum of the units of both meshes.
#[derive(Clone, Copy, Debug)]
pub struct Passing {
    /// Triangles of A times those of B.
    pub pairs: f64,
    /// Pieces of the motion that are left.
    pub pieces: f64,
    /// How far a point of B goes in them at most.
    pub way: f64,
    /// How far apart the middles are when they begin.
    pub apart: f64,
    /// The same at the least, if B goes straight from there to their end.
    pub nearest: f64,
    /// Units of work done.
    pub work: f64,
    /// The time between what is proven to be free and the contact found over the tolerance; `None` as long as none was found.
    pub open: Option<f64>,
}

/// A query opens one pair at least.
const LEAST: f64 = WORK_PER_SWEPT_EXPANSION as f64;

/// How far apart the meshes are, and how far they go, counts as no more than this: the weights were not fitted on more.
const FARTHEST: f64 = 3.0;
const LONGEST: f64 = 64.0;

/// What [`work_left`] looks at.
pub fn passing_features(passing: &Passing) -> [f64; 9] {
    let Passing {
        pairs,
        pieces,
        way,
        apart,
        nearest,
        work,
        open,
    } = *passing;
    let size = log2(pairs.max(1.0));
    let [apart, nearest] = [apart, nearest].map(|length| length.min(FARTHEST));
    let way = log2(1.0 + way.min(LONGEST));
    let (is_found, open) = open.map_or((0.0, 0.0), |open| (1.0, log2(open.max(1.0))));
    [
        1.0,
        size,
        log2(pieces.max(1.0)),
        way,
        apart,
        nearest,
        log2(work + LEAST),
        is_found,
        open,
    ]
}

/// Units of work left, given how many the previous query of the pair took in all.
pub fn work_left(passing: &Passing, previous: Option<f64>) -> Quantiles {
    let x = passing_features(passing);
    let model = Quantiles::ordered(MOTION_LEFT.map(|w| exp2(dot(&w, &x))), LEAST);
    previous.map_or(model, |previous| {
        with_history(model, previous, passing.work, MOTION_AFTER)
    })
}
