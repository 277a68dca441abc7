//! Quantiles of the work left in a query for contacts or manifolds, which lists all pairs within a
//! margin.

use super::constants::{CONTACTS_LEFT, MANIFOLDS_LEFT};
use super::cost::WORK_PER_EXPANSION;
use super::prediction::{Quantiles, dot};
use libm::{exp2, log2};

/// The inputs of the prediction, for a query that has not begun or was stopped.
#[derive(Clone, Copy, Debug)]
pub struct Listing {
    /// Number of triangles of A times that of B.
    pub pairs: f64,
    /// Units of work done.
    pub work: f64,
    /// Pairs listed.
    pub found: f64,
    /// Triangle pairs that wait for their test.
    pub waiting: f64,
    /// Sum over the open node pairs: square root of the geometric mean of the visits of both nodes.
    pub open: f64,
}

/// Least work of a query: it opens at least one pair.
const LEAST: f64 = WORK_PER_EXPANSION as f64;

/// Features of [`contacts_left`] and [`manifolds_left`].
pub fn listing_features(listing: &Listing) -> [f64; 6] {
    let Listing {
        pairs,
        work,
        found,
        waiting,
        open,
    } = *listing;
    [
        1.0,
        log2(pairs.max(1.0)),
        log2(work + LEAST),
        log2(found + 1.0),
        log2(waiting + 1.0),
        log2(open + 1.0),
    ]
}

/// Units of work left in a query for contacts.
pub fn contacts_left(listing: &Listing) -> Quantiles {
    left(&CONTACTS_LEFT, listing)
}

/// Units of work left in a query for manifolds.
pub fn manifolds_left(listing: &Listing) -> Quantiles {
    left(&MANIFOLDS_LEFT, listing)
}

fn left(weights: &[[f64; 6]; 3], listing: &Listing) -> Quantiles {
    let x = listing_features(listing);
    Quantiles::ordered(weights.map(|w| exp2(dot(&w, &x))), 1.0)
}
