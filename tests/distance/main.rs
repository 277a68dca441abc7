//! Each promise of [`punctual::Query::distance`]: a finished query has the exact distance; wherever
//! it stops, its bounds are proven; budgets that cut it do not change a bit.
//!
//! `PUNCTUAL_ALL_STOPS=1` stops at every unit of work, `PUNCTUAL_ALL_CASES=1` takes all poses beside
//! the repository.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/distance.rs"]
mod distance;
#[path = "../common/exact_distance.rs"]
mod exact_distance;
use common::reference;

mod bracket;
mod clearance;
mod estimates;
mod files;
mod finished;
mod kinds;
mod memory;
mod stops;
