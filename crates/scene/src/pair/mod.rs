//! A pair of bodies: the parameters of a frame ([`frame`]), the query that answers ([`question`]),
//! and the state that is kept ([`state`]).
//!
//! A frame begins with the latest witnesses of the pairs that met ([`retest`]). In its turn
//! ([`batch`]) a pair runs or resumes its query, as far as its share of the frame allows. Some
//! pairs need no query: those that stay farther apart than their bodies have moved ([`travel`],
//! [`apart`]), and those of two groups that have a nearer pair ([`near`]). Contact points are a
//! question of their own ([`contacts`], [`touch`]).

pub(crate) mod apart;
pub(crate) mod batch;
pub(crate) mod bounds;
mod contacts;
pub(crate) mod frame;
pub(crate) mod near;
pub(crate) mod question;
pub(crate) mod retest;
pub(crate) mod spent;
pub(crate) mod state;
pub(crate) mod touch;
pub(crate) mod travel;
