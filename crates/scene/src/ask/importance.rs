//! Importance of the questions.

use super::{PairQuestion, TurnKind};
use crate::Scene;
use crate::body::Bodies;
use crate::error::SceneError;
use crate::id::PairKey;

/// The amount that each question adds to the importance of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Weights {
    of: [f32; 4],
    /// True if an importance was ever set.
    any: bool,
}

impl Bodies {
    /// The amount that the next question of a pair adds to its importance. Determines the question
    /// only if some importance was set.
    #[inline]
    pub fn weight(&self, key: PairKey, kind: TurnKind) -> f32 {
        if !self.weights.any {
            return 0.0;
        }
        let weight = |question| self.weights.of[question as usize];
        match self.question(key, kind) {
            // The distance comes before the time of impact.
            PairQuestion::Distance if self.asks_both(key) => {
                weight(PairQuestion::Distance).max(weight(PairQuestion::Motion))
            }
            // Contacts also decide whether the pair meets.
            PairQuestion::Contacts if self.asks_only_contact(key) => {
                weight(PairQuestion::Contacts).max(weight(PairQuestion::Meet))
            }
            question => weight(question),
        }
    }

    #[cold]
    fn question(&self, key: PairKey, kind: TurnKind) -> PairQuestion {
        match kind {
            TurnKind::Contacts => PairQuestion::Contacts,
            TurnKind::Motion => PairQuestion::Motion,
            _ if self.distance_requests.has(key) => PairQuestion::Distance,
            _ if self.is_moving(key) => PairQuestion::Motion,
            _ => PairQuestion::Meet,
        }
    }
}

impl Scene {
    /// Sets how much a question matters, in addition to the bodies; 0 by default. The importance of
    /// a question of a pair is the sum of this and the [importance](crate::Body::importance) of the
    /// more important body. It goes before all less important questions of any pair
    /// ([`Scene::detect`]).
    ///
    /// That holds to the end of the budget. If [`PairQuestion::Contacts`] is more important than
    /// the others, even slightly, the contacts of all pairs that met last are found first. That may
    /// use all of the budget apart from the quarter that goes to all questions in turn. Then the
    /// other pairs are decided by that quarter alone, within the frames that [`Scene::detect`]
    /// states; [`crate::Report::undecided`] counts those that wait. One contact question takes as
    /// long as about ten others. With the default of 0, whether bodies meet is decided first, and
    /// contacts are found with the rest of the budget. The distance of a pair comes before its time
    /// of impact, so it is as important as the more important of both.
    ///
    /// ```
    /// use punctual_scene::{PairQuestion, Scene};
    /// let mut scene = Scene::new();
    /// // Distances that a robot slows down by go before all else.
    /// scene.set_question_importance(PairQuestion::Distance, 1.0)?;
    /// # Ok::<(), punctual_scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// If the importance is infinite or NaN.
    pub fn set_question_importance(
        &mut self,
        question: PairQuestion,
        importance: f32,
    ) -> Result<(), SceneError> {
        if !importance.is_finite() {
            return Err(SceneError::QuestionImportanceNotFinite { question });
        }
        // Adding 0.0 makes -0.0 positive, so that the bits have the order of the numbers.
        let weights = &mut self.bodies_mut().weights;
        (weights.of[question as usize], weights.any) = (importance + 0.0, true);
        record!(self, SetQuestionImportance(question, importance));
        Ok(())
    }
}
