//! What `punctual-lab` and `punctual-cli` need to look inside: the model that is fitted, the random
//! numbers of generated shapes, the node pairs that a query opens. No promise of stability.

pub use crate::model::batch::{
    Batch, batch_features, mean_left, points_left, rays_left, single_features,
};
pub use crate::model::closing::{Closing, between, between_features, closing_features, work_left};
pub use crate::model::confidence::{
    Lead, history_features, hit_features, probability, recall, recall_features, tracing_features,
};
pub use crate::model::frontier::FrontierSummary;
pub use crate::model::listing::{Listing, contacts_left, listing_features, manifolds_left};
pub use crate::model::passing::{Passing, passing_features, work_left as motion_work_left};
pub use crate::model::prediction::{
    all_left, any_left, expected, features_of_all, features_of_any,
};
pub use crate::model::tracker::Tracker;
pub use crate::model::visits::pair_cost;
pub use crate::query::intersection::opened::{OpenedPair, opened_pairs};
pub use punctual_geom::random::Random;
