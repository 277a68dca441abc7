//! Each promise of [`punctual::MotionQuery`]: no contact before `free_until` wherever it stops, a proven contact at
//! `touching_at`, none missed, the same bits however it is cut.

#[path = "../common/mod.rs"]
mod common;
use common::random;

mod clearance;
mod estimates;
mod finished;
mod judge;
mod stops;
mod sweeps;
