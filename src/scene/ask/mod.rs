//! The questions that are asked of pairs: how far apart they are ([`distances`]), until when they
//! are free ([`motions`]), where they touch ([`contacts`]); and how much each matters
//! ([`importance`]).

pub(crate) mod contact_requests;
pub(crate) mod contacts;
pub(crate) mod distance_requests;
mod distances;
mod importance;
mod motions;

use crate::names::named;
pub(crate) use importance::Weights;

/// What a scene asks of a pair of bodies: [`crate::Scene::set_question_importance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PairQuestion {
    /// Whether they meet.
    Meet,
    /// How far apart they are: [`crate::Scene::measure`].
    Distance,
    /// Until when they are free: [`crate::Scene::set_motion`].
    Motion,
    /// Where they touch: [`crate::Scene::find_contacts`].
    Contacts,
}

named!(PairQuestion { Meet => "meet", Distance => "distance", Motion => "motion", Contacts => "contacts" });

/// What the next turn of a pair asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TurnKind {
    /// Whether the bodies meet, how far apart they are, or until when.
    Meet,
    /// Where they touch, as they are known to.
    Contacts,
}
