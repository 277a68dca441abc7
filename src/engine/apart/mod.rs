//! Proofs that two surfaces are apart, without a query: lower bounds of their distance.

pub mod root_test;
pub(crate) mod separating_plane;
