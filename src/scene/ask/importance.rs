//! How much each question matters.

use super::{Asks, PairQuestion};
use crate::scene::Scene;
use crate::scene::body::Bodies;
use crate::scene::error::SceneError;
use crate::scene::id::PairKey;

impl Bodies {
    /// What the question that comes next adds to the importance of a pair.
    #[inline]
    pub fn weight(&self, key: PairKey, asks: Asks) -> f32 {
        self.weights.of(|| self.question(key, asks))
    }

    #[cold]
    fn question(&self, key: PairKey, asks: Asks) -> PairQuestion {
        match asks {
            Asks::Contacts => PairQuestion::Contacts,
            _ if self.measured.has(key) => PairQuestion::Distance,
            _ if self.is_moving(key) => PairQuestion::Motion,
            _ => PairQuestion::Meet,
        }
    }
}

impl Scene {
    /// Says how much a question matters, beside the bodies that it is asked of; 0 by default. A question of a pair counts as
    /// much as the [importance](crate::Body::importance) of the more important body and this together, and goes before all
    /// questions of any pair that count less ([`Scene::detect`]).
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
    pub fn set_question_importance(&mut self, question: PairQuestion, importance: f32) -> Result<(), SceneError> {
        if !importance.is_finite() {
            return Err(SceneError::QuestionImportanceNotFinite { question });
        }
        // One zero, so that the bits give the order.
        self.bodies_mut().weights.set(question, importance + 0.0);
        Ok(())
    }
}
