//! What a query will cost, and what a stopped one leaves open: quantiles, a probability, a recall.

use crate::memory::punctual_memory;
use crate::query::punctual_query;
use crate::status::{Fault, door, given, punctual_status};
use crate::workspace::punctual_workspace;
use core::mem::MaybeUninit;
use punctual::{CostModel, PairMemory, Prediction, Quantiles};

/// Bounds below which a number stays with the given probability.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_quantiles {
    /// 10 %.
    pub p10: f64,
    /// The median.
    pub p50: f64,
    /// 90 %.
    pub p90: f64,
}

impl From<Quantiles> for punctual_quantiles {
    fn from(Quantiles { p10, p50, p90 }: Quantiles) -> Self {
        Self { p10, p50, p90 }
    }
}

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
    /// Time in nanoseconds: of an estimate by the costs of its workspace, before a query by those of the machine of the authors.
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
    /// What the query has still to do.
    pub remaining: punctual_prediction,
    /// Probability that the surfaces meet: 1 with a hit at hand, 0 if they are proven to be apart.
    pub probability: f64,
    /// Expected share of the intersecting pairs that has been found, 0 to 1; for MODE_ANY, 1 as soon as it is decided.
    pub recall: f64,
}

/// What the steps of a query cost, in nanoseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_cost_model {
    /// One BV test.
    pub bv_test: f64,
    /// One triangle pair.
    pub triangle_test: f64,
    /// One node pair that is opened.
    pub box_update: f64,
    /// One query.
    pub setup: f64,
}

pub(crate) fn known(memory: Option<&punctual_memory>) -> Result<Option<&PairMemory>, Fault> {
    memory.map(|memory| memory.0.get("memory")).transpose()
}

/// What this query will take, if nothing stops it, given what is remembered of the pair; `memory` may be null. Takes about a
/// microsecond and allocates nothing.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_query_predict(
    query: Option<&punctual_query>,
    memory: Option<&punctual_memory>,
    prediction: Option<&mut MaybeUninit<punctual_prediction>>,
) -> punctual_status {
    door("punctual_query_predict", || {
        let query = given(query, "query")?.check()?;
        let predicted = query.predict(known(memory)?);
        let costs = CostModel::default();
        given(prediction, "prediction")?.write(punctual_prediction::new(predicted, &costs));
        Ok(())
    })
}

/// What the last run of this query in the workspace leaves open, given what is remembered of the pair; `memory` may be null.
/// Takes about three microseconds and allocates nothing.
///
/// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_query_estimate(
    query: Option<&punctual_query>,
    workspace: Option<&punctual_workspace>,
    memory: Option<&punctual_memory>,
    estimate: Option<&mut MaybeUninit<punctual_estimate>>,
) -> punctual_status {
    door("punctual_query_estimate", || {
        let query = given(query, "query")?.check()?;
        let estimate = given(estimate, "estimate")?;
        let workspace = given(workspace, "workspace")?.0.get("workspace")?;
        let said = query.estimate(workspace, known(memory)?)?;
        let remaining = punctual_prediction::new(said.remaining, &workspace.cost_model());
        estimate.write(punctual_estimate { remaining, probability: said.probability, recall: said.recall });
        Ok(())
    })
}

/// Lets queries in this workspace begin with these costs; they change with each query under a time budget.
///
/// Fails with BAD_ARGUMENT if one is not finite.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_workspace_set_cost_model(
    workspace: Option<&mut punctual_workspace>,
    costs: punctual_cost_model,
) -> punctual_status {
    door("punctual_workspace_set_cost_model", || {
        let punctual_cost_model { bv_test, triangle_test, box_update, setup } = costs;
        if let Some(&bad) = [bv_test, triangle_test, box_update, setup].iter().find(|cost| !cost.is_finite()) {
            return Err(Fault::Number("a cost", bad));
        }
        given(workspace, "workspace")?.0.change("workspace", |workspace| {
            workspace.set_cost_model(CostModel::new([bv_test, triangle_test, box_update, setup]));
            Ok(())
        })
    })
}
