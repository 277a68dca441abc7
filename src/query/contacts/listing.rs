//! Progress of a run for contacts or manifolds, for predictions.

use crate::engine::frontier::Pair;
use crate::engine::question::{Ask, Query, Question};
use crate::engine::workspace::{Asked, Workspace};
use crate::model::listing::Listing;
use crate::tree::node;

/// Number of node pairs that are sampled; the others count as the mean of the sample.
const SAMPLE: usize = 256;

impl<Q: Question> Query<'_, Q>
where
    Self: Ask<Q>,
{
    /// The progress of the run for contacts or manifolds in the workspace.
    pub(crate) fn listing(&self, workspace: &Workspace) -> Listing {
        let asked = self.key().asked;
        // Once all pairs are listed, the frontier holds nodes that rays enter.
        let is_listed =
            matches!(asked, Asked::Manifolds(_)) && workspace.state.manifolds.reduction.is_listed;
        let fourth_root = |pair: Pair| {
            let (leaf_a, leaf_b);
            let a = node!(self.a, pair.nodes[0], leaf_a).self_cost;
            let b = node!(self.b, pair.nodes[1], leaf_b).self_cost;
            f64::from(libm::sqrtf(libm::sqrtf(a * b)))
        };
        let open = if is_listed {
            0
        } else {
            workspace.frontier.len()
        };
        let sampled = workspace.frontier.iter().take(open.min(SAMPLE));
        let sum: f64 = sampled.map(fourth_root).sum();
        let waiting = workspace.triangle_pairs().count() + workspace.state.distance.pairs().count();
        Listing {
            pairs: self.a.mesh().len() as f64 * self.b.mesh().len() as f64,
            work: workspace.work() as f64,
            found: workspace.found() as f64,
            waiting: waiting as f64,
            open: sum * open as f64 / open.clamp(1, SAMPLE) as f64,
        }
    }
}
