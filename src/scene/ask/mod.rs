//! The questions that are asked of pairs: how far apart they are ([`distances`]), until when they are free ([`motions`]), where
//! they touch ([`contacts`]); and how much each matters ([`importance`]).

pub(crate) mod contacts;
mod distances;
pub(crate) mod group;
mod importance;
pub(crate) mod located;
pub(crate) mod measured;
mod motions;

use crate::names::named;

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

/// What each question adds to the importance of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Weights {
    of: [f32; 4],
    /// Whether one was ever set.
    any: bool,
}

impl Weights {
    pub fn set(&mut self, question: PairQuestion, weight: f32) {
        self.of[question as usize] = weight;
        self.any = true;
    }

    /// That of the question at hand, which is looked for only if it matters.
    #[inline]
    pub fn of(&self, question: impl FnOnce() -> PairQuestion) -> f32 {
        if self.any { self.of[question() as usize] } else { 0.0 }
    }
}

/// What the next turn of a pair asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asks {
    /// Whether its last witness still meets, which is likely, and then whether the bodies do.
    Witness,
    /// Whether the bodies meet, how far apart they are, or until when.
    Meet,
    /// Where they touch, as they are known to.
    Contacts,
}
