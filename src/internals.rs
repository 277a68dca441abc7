//! What `punctual-lab` needs to look inside: the model that it fits, and the random numbers of generated shapes.
//! No promise of stability.

pub use crate::math::random::Random;
pub use crate::model::confidence::{history_features, hit_features, probability, recall, recall_features};
pub use crate::model::front::{FrontSummary, pair_cost};
pub use crate::model::least_squares::least_squares;
pub use crate::model::prediction::{all_left, any_left, features_of_all, features_of_any};
