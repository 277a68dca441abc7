//! Predicts the cost of a motion query, and of the rest of an unfinished one
//! ([`Query::remaining`]).

use super::Impact;
use crate::engine::memory::{PairMemory, Sought};
use crate::engine::question::Query;
use crate::model::passing::{self, Passing};
use crate::model::prediction::Quantiles;
use glam::DVec3;

impl Query<'_, Impact> {
    /// Predicts the units of work of this query if nothing stops it, using the memory of the pair.
    /// Constant time, no allocation; the same bits on every machine.
    ///
    /// The prediction is rough: half of the queries are within a factor of 2.1 of the median, nine
    /// of ten within 8.6. With a memory of motions close together the factors are 1.3 and 2.3
    /// (`docs/model.md`).
    #[must_use]
    pub fn predict(&self, memory: Option<&PairMemory>) -> Quantiles {
        self.work_left(&self.passing(0, 0.0, None), memory)
    }

    pub(crate) fn passing(&self, work: u64, free_until: f64, touching_at: Option<f64>) -> Passing {
        let relative_motion = self.relative_motion();
        let until = touching_at.unwrap_or(1.0);
        let (from, left) = (free_until.min(until), (until - free_until).max(0.0));
        let size = self.a.unit().length() + self.b.unit().length();
        let [first, last] = [from, until].map(|time| {
            relative_motion
                .pose(time)
                .transform_point(self.b.unit().origin)
                - self.a.unit().origin
        });
        let way = last - first;
        let nearest = first + way * (-first.dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let pairs = self.a.mesh().len() as f64 * self.b.mesh().len() as f64;
        Passing {
            pairs,
            substeps: f64::from(relative_motion.substeps) * left,
            way: relative_motion.speed * left / size,
            apart: first.length() / size,
            nearest: if way == DVec3::ZERO {
                first.length()
            } else {
                nearest.length()
            } / size,
            work: work as f64,
            open: touching_at.map(|_| left / self.tolerance_in_time(&relative_motion)),
        }
    }

    pub(super) fn work_left(&self, passing: &Passing, memory: Option<&PairMemory>) -> Quantiles {
        let model = passing::work_left(passing);
        self.predicted(memory, Sought::Motion, passing.work, model, |memory| {
            let previous = memory.last_work_of(Sought::Motion)?;
            Some(passing::work_after(previous as f64))
        })
    }
}
