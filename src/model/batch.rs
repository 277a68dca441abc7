//! Quantiles of the work left in a batch of rays or points: the mean work of the items done times
//! the number left, with a spread. Before the first is done, the work of a typical item.

use super::constants::{BATCH_LEFT, POINT_WORK, RAY_WORK};
use super::prediction::{Quantiles, dot};
use libm::{exp2, log2, sqrt};

/// The inputs of the prediction, for a batch that has not begun or was stopped.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    /// Number of triangles.
    pub triangles: f64,
    /// Number of rays or points that are done.
    pub done: f64,
    /// Number of rays or points left, the current one included.
    pub left: f64,
    /// Units of work done.
    pub work: f64,
    /// True if each takes more: all hits of a ray, the distance of a point.
    pub is_thorough: bool,
}

/// Work, about that of preparing a ray, below which the logarithm hardly falls.
const LITTLE: f64 = 100.0;

/// Features of log2 of the work for each item left, before any is done.
pub fn single_features(batch: &Batch) -> [f64; 5] {
    [
        1.0,
        log2(batch.triangles.max(1.0)),
        log2(batch.work + LITTLE),
        f64::from(batch.is_thorough),
        1.0 / sqrt(batch.left.max(1.0)),
    ]
}

/// Features of log2 of the work left over [`mean_left`], once some are done.
pub fn batch_features(batch: &Batch) -> [f64; 3] {
    let spread = |count: f64| 1.0 / sqrt(count.max(1.0));
    [1.0, spread(batch.done), spread(batch.left)]
}

/// Mean work of the items done, times the number left. The current item counts as half done.
pub fn mean_left(batch: &Batch) -> f64 {
    batch.work / (batch.done + 0.5) * batch.left
}

/// Units of work left in a batch of rays.
pub fn rays_left(batch: &Batch) -> Quantiles {
    left(&RAY_WORK, batch)
}

/// Units of work left in a batch of points.
pub fn points_left(batch: &Batch) -> Quantiles {
    left(&POINT_WORK, batch)
}

fn left(single: &[[f64; 5]; 3], batch: &Batch) -> Quantiles {
    let at = |scale: f64, log: f64| scale * exp2(log);
    let quantiles = if batch.done > 0.0 {
        let x = batch_features(batch);
        BATCH_LEFT.map(|w| at(mean_left(batch), dot(&w, &x)))
    } else {
        let x = single_features(batch);
        single.map(|w| at(batch.left, dot(&w, &x)))
    };
    Quantiles::ordered(quantiles, 1.0)
}
