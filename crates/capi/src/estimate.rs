//! What a query will cost, and what a stopped one leaves open: quantiles, a probability, a recall.

use crate::handle::get;
use crate::memory::{known, punctual_memory};
use crate::outcome::punctual_quantiles;
use crate::query::punctual_query;
use crate::sized::{place, read};
use crate::status::{Fault, given};
use crate::verbs::{calls, types};
use crate::workspace::punctual_workspace;
use core::mem::MaybeUninit;
use punctual::Query;
use punctual::engine::{Ask, Question};
use punctual::prediction::{CostModel, Prediction};

types! {
    /// What a query, or the rest of one, is expected to take.
    plain punctual_prediction {
        /// BV tests.
        bv_tests: punctual_quantiles,
        /// Triangle pairs tested.
        triangle_tests: punctual_quantiles,
        /// Units of work.
        work: punctual_quantiles,
        /// Time in nanoseconds: of an estimate by the costs of its workspace, before a query by
        /// those of the machine of the authors.
        time: punctual_quantiles,
    }
}

impl punctual_prediction {
    fn new(prediction: Prediction, costs: &CostModel) -> Self {
        Self {
            bv_tests: prediction.bv_tests.into(),
            triangle_tests: prediction.triangle_tests.into(),
            work: prediction.work.into(),
            time: prediction.time(costs).into(),
        }
    }
}

types! {
    /// What can be said of a stopped query. Not proven: only verdict and certificate are.
    told punctual_estimate(remaining) {
        /// What the query has still to do.
        remaining: punctual_prediction,
        /// Probability that the surfaces meet: 1 with a hit at hand, 0 if they are proven to be
        /// apart.
        probability: f64,
        /// Expected share of the intersecting pairs that has been found, 0 to 1; for MODE_ANY, 1 as
        /// soon as it is decided.
        recall: f64,
    }

    /// What a stopped query has still to do; all 0 of a finished one.
    told punctual_remaining(work) {
        /// Units of work.
        work: punctual_quantiles,
        /// Nanoseconds, at the pace of the run so far; of runs without a budget of time, by the
        /// costs of the workspace.
        time: punctual_quantiles,
        /// Probability that the surfaces meet; NaN for questions other than `punctual_query`.
        probability: f64,
    }
}

/// Writes what the last run of a query has still to do.
///
/// # Safety
/// The contract of the header for structs.
pub(crate) unsafe fn tell<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: Option<&punctual_workspace>,
    memory: Option<&punctual_memory>,
    remaining: *mut punctual_remaining,
) -> Result<(), Fault>
where
    Query<'t, Q>: Ask<Q>,
{
    // SAFETY: the caller's promise.
    let remaining = unsafe { place(remaining, "remaining") }?;
    let workspace = get(workspace, "workspace")?;
    let left = query.remaining(workspace, known(memory)?)?;
    remaining.write(punctual_remaining {
        size: punctual_remaining::SIZE,
        work: left.work.into(),
        time: left.time.into(),
        probability: left.probability.unwrap_or(f64::NAN),
    });
    Ok(())
}

calls! {
    /// What this query will take, if nothing stops it, given what is remembered of the pair;
    /// `memory` may be null. Takes about a microsecond and allocates nothing.
    unsafe fn punctual_query_predict(
        query: *const punctual_query<'_>, memory: Option<&punctual_memory>,
        prediction: Option<&mut MaybeUninit<punctual_prediction>>
    ) {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        let predicted = query.predict(known(memory)?);
        let costs = CostModel::default();
        given(prediction, "prediction")?.write(punctual_prediction::new(predicted, &costs));
        Ok(())
    }

    /// What the last run of this query in the workspace leaves open, given what is remembered of
    /// the pair; `memory` may be null. Costs as much as `punctual_query_remaining`. Allocates
    /// nothing.
    ///
    /// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
    unsafe fn punctual_query_estimate(
        query: *const punctual_query<'_>, workspace: Option<&punctual_workspace>,
        memory: Option<&punctual_memory>, estimate: *mut punctual_estimate
    ) {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        // SAFETY: the same.
        let estimate = unsafe { place(estimate, "estimate") }?;
        let workspace = get(workspace, "workspace")?;
        let said = query.estimate(workspace, known(memory)?)?;
        let remaining = punctual_prediction::new(said.remaining, &workspace.cost_model());
        let size = punctual_estimate::SIZE;
        estimate.write(punctual_estimate {
            size,
            remaining,
            probability: said.probability,
            recall: said.recall,
        });
        Ok(())
    }
}
