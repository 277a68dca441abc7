//! Predicts the cost of a query and the certainty of a partial answer: numbers in, numbers out.
//! Knows no tree, no clock and no mesh.
//!
//! The model is based on R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time
//! of Collision Detection using AABB Trees" (EGVE 2006). The crate `punctual-lab` contains their
//! equations and the experiments that led from these to this model. This module contains what the
//! engine uses:
//!
//! | known of the query | predicted |
//! |---|---|
//! | its frontier after a probe ([`frontier`]) | BV tests left ([`prediction`]) |
//! | its frontier after a probe | probability of a hit, and recall ([`confidence`]) |
//! | the cost of the last frame | BV tests left, blended with that cost |
//! | the progress of a distance query | work left, and quantiles of the distance ([`closing`]) |
//! | the progress of a motion query | work left ([`passing`]) |
//! | counts | time ([`cost`]) |
//! | earlier predictions and their outcomes | a corrected probability ([`calibration`]) |
//!
//! `punctual fit` computes the constants.

pub mod calibration;
pub mod closing;
pub mod confidence;
#[rustfmt::skip]
mod constants;
pub mod cost;
pub mod frontier;
pub mod passing;
pub mod prediction;
