//! Predicts the cost of a distance query, and estimates what a stopped one leaves open.

use super::Distance;
use crate::engine::memory::{PairMemory, Sought};
use crate::engine::question::Query;
use crate::engine::workspace::{ResumeError, Workspace};
use crate::model::closing::{self, Closing};
use crate::model::prediction::Quantiles;

/// The estimate for a stopped distance query: see [`Query::estimate`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DistanceEstimate {
    /// Units of work left.
    pub remaining: Quantiles,
    /// The distance, in the length unit of the meshes: within the proven bounds. Unbounded above if
    /// no pair was tested yet.
    pub distance: Quantiles,
}

impl Query<'_, Distance> {
    /// Predicts the units of work of this query if nothing stops it, using the memory of the pair.
    /// One unit takes the time [`CostModel::bv_test`]. Constant time, no allocation; the same bits
    /// on every machine.
    ///
    /// The prediction is rough: half of the queries are within a factor of 2.4 of the median, nine
    /// of ten within 6.5. With a memory of frames close together the factors are 1.2 and 5
    /// (`docs/model.md`).
    ///
    /// [`CostModel::bv_test`]: crate::prediction::CostModel::bv_test
    #[must_use]
    pub fn predict(&self, memory: Option<&PairMemory>) -> Quantiles {
        self.work_left(&self.closing(0, [0.0, f64::INFINITY]), memory)
    }

    /// Estimates what the last run of this query in `workspace` leaves open, using the memory of
    /// the pair; as rough as [`Query::predict`]. Constant time, no allocation; the same bits on
    /// every machine.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this pose and these options.
    pub fn estimate(
        &self,
        workspace: &Workspace,
        memory: Option<&PairMemory>,
    ) -> Result<DistanceEstimate, ResumeError> {
        self.holds(workspace)?;
        let closing = self.closing(
            workspace.work(),
            self.bounds(&workspace.state.distance.interval),
        );
        let remaining = if workspace.run.stopped {
            self.work_left(&closing, memory)
        } else {
            Quantiles::default()
        };
        Ok(DistanceEstimate {
            remaining,
            distance: closing::between(&closing),
        })
    }

    pub(crate) fn closing(&self, work: u64, [low, high]: [f64; 2]) -> Closing {
        let pairs = self.a.mesh().len() as f64 * self.b.mesh().len() as f64;
        let [of_a, of_b] = [self.a.unit(), self.b.unit()];
        let middles = self.middle().length();
        let apart = middles / (of_a.length() + of_b.length());
        let limit = self.asked.options.limit;
        let limit = (limit < f64::INFINITY).then_some(limit / middles);
        Closing {
            pairs,
            apart,
            work: work as f64,
            low,
            high,
            limit,
        }
    }

    pub(crate) fn work_left(&self, closing: &Closing, memory: Option<&PairMemory>) -> Quantiles {
        let model = closing::work_left(closing);
        self.predicted(memory, self.sought(), closing.work, model, |memory| {
            let previous = memory.last_work_of(Sought::Distance)?;
            let is_whole = closing.limit.is_none();
            is_whole.then(|| closing::work_after(previous as f64))
        })
    }

    pub(crate) fn sought(&self) -> Sought {
        if self.asked.options.limit < f64::INFINITY {
            Sought::Closer
        } else {
            Sought::Distance
        }
    }
}
