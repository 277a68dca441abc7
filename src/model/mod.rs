//! What a query will cost, and how sure a partial answer is: numbers in, numbers out. Knows no tree, no clock and no mesh.
//!
//! The model goes back to R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time of Collision Detection
//! using AABB Trees" (EGVE 2006). Their equations, and what was tried between them and this, are the crate `punctual-lab`.
//! What the engine uses is here:
//!
//! | what is known of the query | what is told |
//! |---|---|
//! | its front after a probe ([`front`]) | BV tests left ([`prediction`]), probability of a hit and recall ([`confidence`]) |
//! | what the last frame cost | the same, blended with it |
//! | how far a distance query has come | work left, and where the distance lies ([`closing`]) |
//! | how far a motion query has come | work left ([`passing`]) |
//! | counts | time ([`cost`]) |
//! | what it told before, and what came of it | a corrected probability ([`calibration`]) |
//!
//! The constants are made by `punctual fit`. [`least_squares`] serves [`cost::CostModel::measure`].

pub mod calibration;
pub mod closing;
pub mod confidence;
#[rustfmt::skip]
mod constants;
pub mod cost;
pub mod front;
pub mod least_squares;
pub mod passing;
pub mod prediction;
