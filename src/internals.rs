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

use crate::engine::question::{Ask, Query, Question};
use crate::engine::workspace::{ResumeError, Workspace};
use crate::query::distance::Distance;
use crate::query::intersection::Intersection;
use crate::query::motion::Impact;

/// What the model is given of a distance query after this work, with these bounds.
pub fn closing(query: &Query<'_, Distance>, work: u64, bounds: [f64; 2]) -> Closing {
    query.closing(work, bounds)
}

/// What the model is given of a motion query after this work, with what is known then.
pub fn passing(
    query: &Query<'_, Impact>,
    work: u64,
    free_until: f64,
    touching_at: Option<f64>,
) -> Passing {
    query.passing(work, free_until, touching_at)
}

/// What the model is given of the last run of a query for contacts or manifolds.
pub fn listing<'t, Q: Question>(query: &Query<'t, Q>, workspace: &Workspace) -> Listing
where
    Query<'t, Q>: Ask<Q>,
{
    query.listing(workspace)
}

/// The numbers that [`Query::estimate`] computes from the frontier that the last run of an
/// intersection query left in `workspace`.
///
/// # Errors
/// If the last run in this workspace was not of this query.
pub fn frontier(
    query: &Query<'_, Intersection>,
    workspace: &Workspace,
) -> Result<FrontierSummary, ResumeError> {
    query.frontier_while(workspace, &|| true)
}

/// The frontier before an intersection query: its root, opened on trial.
pub fn frontier_before(query: &Query<'_, Intersection>) -> FrontierSummary {
    query.frontier_before()
}
