//! The expected running time of collision detection: what was done once, for knowledge.
//!
//! The model is that of R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time of Collision Detection
//! using AABB Trees" (EGVE 2006): boxes shrink by a factor alpha from one level of a binary tree to the next, and the
//! number of box pairs that overlap on each level follows. [`paper`] has its equations, [`artificial`] the trees
//! on which it was tried, [`traversal`] its Algorithm 1. The rest goes on from there:
//!
//! | what is known of the query | expected BV tests |
//! |---|---|
//! | alpha | [`paper::eq11`] |
//! | alpha and the offset of the roots | [`delta`], exact for artificial trees |
//!
//! What the engine of [`punctual`] predicts with comes from here too: [`constants`] fits the constants of its model, by
//! [`regression`], and writes them as Rust source. [`experiments`] measures the claims of the paper; [`fit`] tells how
//! counts grow; [`report`] draws what was found; [`sweep`]
//! measures what a deadline costs in accuracy, at poses of [`approach`].
//!
//! The program `punctual` (package `punctual-cli`) runs it: `punctual paper`, `punctual fit`, `punctual sweep`.

#![deny(missing_docs, unsafe_code)]

pub mod approach;
pub mod artificial;
pub mod constants;
pub mod delta;
pub mod experiments;
pub mod files;
pub mod fit;
pub mod machine;
pub mod paper;
pub mod regression;
pub mod report;
pub mod statistics;
pub mod sweep;
pub mod traversal;
