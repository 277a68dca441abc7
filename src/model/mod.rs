//! What a query will cost: numbers in, numbers out. Knows no tree, no clock and no mesh.
//!
//! The model is that of R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time of Collision Detection
//! using AABB Trees" (EGVE 2006): boxes shrink by a factor alpha from one level of a binary tree to the next, and the
//! number of box pairs that overlap on each level follows. [`paper`] has its equations by number, [`artificial`] the trees
//! on which it was tried. The rest goes on from there:
//!
//! | what is known of the query | expected BV tests |
//! |---|---|
//! | alpha | [`paper::eq11`] |
//! | all boxes, no placement | [`moments`], exact |
//! | alpha and the offset of the roots | [`delta`], exact for artificial trees |
//! | a profile of each level and the offset | [`offset`] |
//! | one stored number a node | [`cheap`] |
//! | what the query has done so far | [`correction`] |
//! | what the last frame cost | [`history`] |
//! | the front of a query after a look ahead | [`prediction`], which the engine uses |
//!
//! [`confidence`] tells from the same front how likely a hit is. [`cost`] turns counts into time, [`quantile`] a median into
//! a range, [`fit`] finds how counts grow, and [`regression`] the constants.

pub mod artificial;
pub mod cheap;
pub mod confidence;
mod constants;
pub mod correction;
pub mod cost;
pub mod delta;
pub mod fit;
pub mod front;
pub mod history;
pub mod moments;
mod normal;
pub mod offset;
pub mod paper;
pub mod prediction;
pub mod quantile;
pub mod regression;
pub mod traversal;
