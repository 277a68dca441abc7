//! Predicts the cost of a motion query, and of the rest of an unfinished one.

use super::Impact;
use crate::model::passing::{self, Passing};
use crate::model::prediction::Quantiles;
use crate::query::memory::{PairMemory, Sought, tag};
use crate::query::question::Query;
use crate::query::workspace::{ResumeError, Workspace};
use glam::DVec3;

impl Query<'_, Impact> {
    /// Predicts the units of work of this query if nothing stops it, using the memory of the pair.
    /// Constant time, no allocation; the same bits on every machine.
    ///
    /// The prediction is rough: half of the queries are within a factor of 1.9 of the median, nine
    /// of ten within 8 (`docs/model.md`).
    #[must_use]
    pub fn predict(&self, memory: Option<&PairMemory>) -> Quantiles {
        self.work_left(&self.passing(0, 0.0, None), memory)
    }

    /// Predicts the units of work left in the last run of this query in `workspace`, using the
    /// memory of the pair. Constant time, no allocation; the same bits on every machine.
    ///
    /// # Errors
    /// If the last run in this workspace was not of these trees, this motion and these options.
    pub fn estimate(
        &self,
        workspace: &Workspace,
        memory: Option<&PairMemory>,
    ) -> Result<Quantiles, ResumeError> {
        self.holds(workspace)?;
        let state = &workspace.motion;
        let touching_at = state.contact().map(|contact| contact.time);
        let passing = self.passing(workspace.work(), state.free_until(), touching_at);
        Ok(if workspace.run.stopped {
            self.work_left(&passing, memory)
        } else {
            Quantiles::default()
        })
    }

    #[doc(hidden)]
    pub fn passing(&self, work: u64, free_until: f64, touching_at: Option<f64>) -> Passing {
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

    fn work_left(&self, passing: &Passing, memory: Option<&PairMemory>) -> Quantiles {
        let model = passing::work_left(passing);
        let Some(memory) = memory.filter(|memory| memory.is_of(self.a, self.b)) else {
            return model;
        };
        let after = || {
            let previous = memory.last_work_of(Sought::Motion)?;
            Some(passing::work_after(previous as f64))
        };
        memory.tell(Sought::Motion, self.tag(), passing.work, model, after)
    }

    /// Identifies this query to the memory of its pair.
    pub(super) fn tag(&self) -> u32 {
        let options = &self.asked.options;
        let motions = options.of_a.iter().chain([&options.of_b]);
        let numbers = motions.flat_map(|motion| {
            let [way, turn] = [motion.velocity(), motion.turn()].map(|v| v.to_array());
            motion
                .start()
                .to_row_major()
                .into_iter()
                .chain(way)
                .chain(turn)
        });
        tag(Sought::Motion, numbers)
    }
}
