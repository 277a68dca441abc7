//! Quantiles of the work left in a motion query, from a few numbers that need no access to the
//! meshes.

use super::constants::{MOTION_AFTER, MOTION_LEFT};
use super::cost::WORK_PER_SWEPT_EXPANSION;
use super::prediction::{Quantiles, after, dot};
use libm::{exp2, log2};

/// The inputs of the prediction of a motion query that has not begun, or was stopped. Lengths are
/// divided by the sum of the units of both meshes.
#[derive(Clone, Copy, Debug)]
pub struct Passing {
    /// Number of triangles of A times that of B.
    pub pairs: f64,
    /// Number of substeps of the motion that are left; may be a fraction.
    pub substeps: f64,
    /// Upper bound of the distance that a point of B travels during the rest of the motion.
    pub way: f64,
    /// Distance between the centers of the meshes where the rest of the motion begins.
    pub apart: f64,
    /// Least distance between the centers during the rest of the motion, if B's center moves
    /// straight.
    pub nearest: f64,
    /// Units of work done.
    pub work: f64,
    /// Time from the end of the part proven free to the contact found, divided by the tolerance;
    /// `None` until a contact is found.
    pub open: Option<f64>,
}

/// Least work of a query: it opens at least one pair.
const LEAST: f64 = WORK_PER_SWEPT_EXPANSION as f64;

/// Maxima, as features, of the distances between the centers and of the distance travelled. Larger
/// values are clamped, because the weights were not fitted on them.
const FARTHEST: f64 = 3.0;
const LONGEST: f64 = 64.0;

/// Features of [`work_left`].
pub fn passing_features(passing: &Passing) -> [f64; 9] {
    let Passing {
        pairs,
        substeps,
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
        log2(substeps.max(1.0)),
        way,
        apart,
        nearest,
        log2(work + LEAST),
        is_found,
        open,
    ]
}

/// Units of work left.
pub fn work_left(passing: &Passing) -> Quantiles {
    let x = passing_features(passing);
    Quantiles::ordered(MOTION_LEFT.map(|w| exp2(dot(&w, &x))), LEAST)
}

/// Predicts the units of work of a query from those of the `previous` query of its pair alone.
pub fn work_after(previous: f64) -> Quantiles {
    after(previous, MOTION_AFTER)
}
