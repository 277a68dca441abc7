//! The questions of pairs: distance ([`distances`]), time of impact ([`motions`]), contacts
//! ([`contacts`]); and their importance ([`importance`]).

pub(crate) mod contact_requests;
pub(crate) mod contacts;
pub(crate) mod distance_requests;
mod distances;
mod importance;
mod motions;

pub(crate) use importance::Weights;
use punctual_geom::named;

/// A question of a scene about a pair of bodies: [`crate::Scene::set_question_importance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PairQuestion {
    /// Do the bodies meet?
    Meet,
    /// Their distance: [`crate::Scene::measure`].
    Distance,
    /// Their time of impact: [`crate::Scene::set_motion`].
    Motion,
    /// Their contact points: [`crate::Scene::find_contacts`].
    Contacts,
}

named!(PairQuestion { Meet => "meet", Distance => "distance", Motion => "motion", Contacts => "contacts" });

/// The kind of the next turn of a pair. A pair has its turns in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum TurnKind {
    /// Decides whether the bodies meet, or computes their distance, or, if that is not requested,
    /// their time of impact.
    #[default]
    Meet,
    /// Computes the time of impact of bodies whose distance is also requested.
    Motion,
    /// Finds contact points of bodies that meet, or decides that too, if nothing else is asked.
    Contacts,
}
