//! Each promise of [`punctual::ContactQuery`]: the whole set of contacts in the end, true contacts and a true bound wherever it
//! stops, the same set however it is cut.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/distance.rs"]
mod distance;
#[path = "../common/exact_distance.rs"]
mod exact_distance;
use common::reference;

mod finished;
mod stops;
mod truth;
