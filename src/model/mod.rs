//! Predicts the cost of a query and the certainty of a partial answer: numbers in, numbers out.
//! Knows no tree, no clock and no mesh.
//!
//! The model is based on R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time
//! of Collision Detection using AABB Trees" (EGVE 2006); [`visits`] is their sum over levels. The
//! crate `punctual-lab` contains the experiments that led from it to the rest:
//!
//! | known of the query | predicted |
//! |---|---|
//! | alpha and boxes of each level of two subtrees | expected BV tests, `N_v` ([`visits`]) |
//! | its frontier after a probe ([`frontier`]) | BV tests left: the sum of these, corrected ([`prediction`]) |
//! | its frontier after a probe | probability of a hit, and recall ([`confidence`]) |
//! | earlier predictions for a pair and their outcomes | its quantiles, corrected ([`tracker`]) |
//! | the progress of a distance query | work left, and quantiles of the distance ([`closing`]) |
//! | the progress of a motion query | work left ([`passing`]) |
//! | the progress of a query for contacts or manifolds | work left ([`listing`]) |
//! | the progress of a batch of rays or points | work left ([`batch`]) |
//! | counts | time ([`cost`]) |
//! | earlier predictions and their outcomes | a corrected probability ([`calibration`]) |
//!
//! `punctual fit` computes the constants.

pub mod batch;
pub mod calibration;
pub mod closing;
pub mod confidence;
#[rustfmt::skip]
#[allow(clippy::approx_constant, reason = "a fitted weight may come near one")]
mod constants;
pub mod cost;
pub mod frontier;
pub mod listing;
pub mod passing;
pub mod prediction;
pub mod tracker;
pub mod visits;
