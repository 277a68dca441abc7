//! Each promise of [`punctual::RayQuery`]: what is hit is what rational numbers say, no ray passes between triangles,
//! nothing false wherever it stops, the same bits however it is cut.

#[path = "../common/mod.rs"]
mod common;

mod finished;
mod stops;
mod truth;
mod watertight;
