//! What a query will cost, and what a stopped one leaves open: quantiles, a probability, a recall.

use crate::handle::get;
use crate::memory::{known, punctual_memory};
use crate::outcome::punctual_quantiles;
use crate::query::punctual_query;
use crate::sized::{grows, place, read};
use crate::status::{Fault, given};
use crate::verbs::calls;
use crate::workspace::punctual_workspace;
use core::mem::MaybeUninit;
use punctual::Query;
use punctual::engine::{Ask, Question};
use punctual::prediction::{CostModel, Prediction};

/// What a query, or the rest of one, is expected to take.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_prediction {
    /// BV tests.
    pub bv_tests: punctual_quantiles,
    /// Triangle pairs tested.
    pub triangle_tests: punctual_quantiles,
    /// Units of work.
    pub work: punctual_quantiles,
    /// Time in nanoseconds: of an estimate by the costs of its workspace, before a query by those
    /// of the machine of the authors.
    pub time: punctual_quantiles,
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

/// What can be said of a stopped query. Not proven: only verdict and certificate are.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_estimate {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// What the query has still to do.
    pub remaining: punctual_prediction,
    /// Probability that the surfaces meet: 1 with a hit at hand, 0 if they are proven to be apart.
    pub probability: f64,
    /// Expected share of the intersecting pairs that has been found, 0 to 1; for MODE_ANY, 1 as
    /// soon as it is decided.
    pub recall: f64,
}

grows!(punctual_estimate: size, remaining..recall);

/// What a stopped query has still to do; all 0 of a finished one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_remaining {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Units of work.
    pub work: punctual_quantiles,
    /// Nanoseconds, at the pace of the run so far; of runs without a budget of time, by the costs
    /// of the workspace.
    pub time: punctual_quantiles,
    /// Probability that the surfaces meet; NaN for questions other than `punctual_query`.
    pub probability: f64,
}

grows!(punctual_remaining: size, work..probability);

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
