//! Solids: closedness of meshes.

#[path = "../common/mod.rs"]
mod common;

mod closed;
mod meshes;
