//! A pair of bodies: what a frame asks of it ([`frame`]), the query that answers ([`question`]),
//! and what is kept ([`state`]).
//!
//! A frame begins with the last witnesses of the pairs that met ([`retest`]). In its turn
//! ([`batch`]) a pair goes on with the query, as far as its share of the frame allows. A pair that
//! stays apart as far as its bodies have gone ([`travel`]) needs none ([`apart`]), nor does one of
//! two groups that have a nearer pair ([`near`]); of one that meets, a second query finds where
//! ([`contacts`], [`touch`]).

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
