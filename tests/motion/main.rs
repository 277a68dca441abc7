//! Each promise of [`punctual::Query::impact`]: wherever it stops, there is no contact before `lower`,
//! and a proven one at `upper`; none is missed; budgets that cut it do not change a bit.

#[path = "../common/mod.rs"]
mod common;
use common::random;

mod clearance;
mod estimates;
mod finished;
mod judge;
mod stops;
mod sweeps;
