//! How much each question matters.

use super::{PairQuestion, TurnKind};
use crate::scene::Scene;
use crate::scene::body::Bodies;
use crate::scene::error::SceneError;
use crate::scene::id::PairKey;

/// What each question adds to the importance of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Weights {
    of: [f32; 4],
    /// Whether one was ever set.
    any: bool,
}

impl Bodies {
    /// What the question that comes next adds to the importance of a pair; it is looked for only if
    /// it matters.
    #[inline]
    pub fn weight(&self, key: PairKey, kind: TurnKind) -> f32 {
        if self.weights.any {
            self.weights.of[self.question(key, kind) as usize]
        } else {
            0.0
        }
    }

    #[cold]
    fn question(&self, key: PairKey, kind: TurnKind) -> PairQuestion {
        match kind {
            TurnKind::Contacts => PairQuestion::Contacts,
            _ if self.distance_requests.has(key) => PairQuestion::Distance,
            _ if self.is_moving(key) => PairQuestion::Motion,
            _ => PairQuestion::Meet,
        }
    }
}

impl Scene {
    /// Says how much a question matters, beside the bodies that it is asked of; 0 by default. A
    /// question of a pair counts as much as the [importance](crate::Body::importance) of the more
    /// important body and this together, and goes before all questions of any pair that count less
    /// ([`Scene::detect`]).
    ///
    /// That holds to the end of the budget. [`PairQuestion::Contacts`] above the others are asked
    /// first of all pairs that met last, even a little above: if finding where these touch takes
    /// all that the budget has beside the quarter that goes round in turn, the other pairs are
    /// decided by that quarter alone, within the frames that [`Scene::detect`] states, and
    /// [`crate::Report::undecided`] counts those that wait. One contact question takes as long as
    /// some ten others. Whether bodies meet is asked first, and where they touch of what is left,
    /// with the default of 0.
    ///
    /// ```
    /// use punctual::{PairQuestion, Scene};
    /// let mut scene = Scene::new();
    /// // Distances that a robot slows down by go before all else.
    /// scene.set_question_importance(PairQuestion::Distance, 1.0)?;
    /// # Ok::<(), punctual::SceneError>(())
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
        // One zero, so that the bits give the order.
        let weights = &mut self.bodies_mut().weights;
        (weights.of[question as usize], weights.any) = (importance + 0.0, true);
        Ok(())
    }
}
