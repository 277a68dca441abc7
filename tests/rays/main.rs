//! Each promise of [`punctual::Query::ray`]: its hits are those of rational arithmetic; no ray passes
//! between triangles; nothing is false wherever it stops; budgets that cut it do not change a bit.

#[path = "../common/mod.rs"]
mod common;

mod finished;
mod stops;
mod truth;
mod watertight;
