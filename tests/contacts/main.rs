//! Each promise of [`punctual::Query::contacts`]: a finished query has all contacts; wherever it
//! stops, its contacts are true and its bound holds; budgets that cut it do not change the set.

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
