//! Solids: closedness of meshes.

#[path = "../common/mod.rs"]
mod common;

mod closed;
mod contained;
#[path = "../common/exact_distance.rs"]
mod exact_distance;
mod mass;
mod meshes;
mod points;
mod truth;
