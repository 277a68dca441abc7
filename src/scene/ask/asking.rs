//! Which distances bodies are asked for.

use super::measured::Asker;
use crate::model::cost::WORK_PER_PAIR_APART;
use crate::query::Deadline;
use crate::scene::body::Bodies;
use crate::scene::broad::Broad;
use crate::scene::error::SceneError;
use crate::scene::facts::Change;
use crate::scene::id::{BodyId, MeasureId, PairKey, bodies_of, pair_key};

impl Bodies {
    /// Asks for the distance of a pair, or no more, from `frame` on.
    pub fn measure(&mut self, pair: [BodyId; 2], tolerance: Option<f64>, frame: u64) -> Result<(), SceneError> {
        for id in pair {
            self.get(id)?;
        }
        let key = pair_key(pair[0].index, pair[1].index);
        match tolerance {
            Some(tolerance) => self.measured.insert(key, Asker::Pair, tolerance),
            None => self.measured.remove(key, Asker::Pair),
        }
        for BodyId { index, .. } in pair {
            self.renew(index, tolerance.is_some() || self.measured.has_body(index), frame)?;
        }
        Ok(())
    }

    /// Asks for the least distance of pairs, ascending, of these bodies, from `frame` on.
    pub fn measure_groups<'b>(
        &mut self,
        keys: &[PairKey],
        bodies: impl Iterator<Item = &'b BodyId>,
        tolerance: f64,
        frame: u64,
    ) -> Result<MeasureId, SceneError> {
        let id = self.measured.insert_groups(keys, tolerance);
        for body in bodies {
            self.renew(body.index, true, frame)?;
        }
        Ok(id)
    }

    /// Asks for it no more.
    pub fn stop_measuring_groups(&mut self, id: MeasureId, frame: u64) {
        for body in self.measured.remove_groups(id) {
            let _ = self.renew(body, self.measured.has_body(body), frame);
            // A pair stays known only if the broad phase finds it.
            self.set_pending(body, Change::Place);
        }
    }

    /// Takes note of whether distances of a body are asked for. What was found of it is the answer to another question.
    fn renew(&mut self, body: u32, is_measured: bool, frame: u64) -> Result<(), SceneError> {
        self.facts_mut(body).is_measured = is_measured;
        self.change(self.id(body), frame, |_| ())
    }

    /// Finds out what of the last frame's upper bounds is left for the groups; where nothing is, boxes tell, as far as there is
    /// room to look at them.
    pub fn begin_groups(&mut self, broad: &Broad, frame: u64, deadline: &mut Deadline) {
        for number in 0..self.measured.groups.len() {
            let closest = self.measured.groups[number].closest;
            let closest = closest.filter(|&(key, ..)| self.may_meet(bodies_of(key)));
            let of_last = closest.map_or(f64::INFINITY, |(key, bounds, since)| {
                if self.last_change(key) <= since { bounds.high } else { self.carried(key, bounds, since, frame).high }
            });
            let ceiling = if of_last < f64::INFINITY { of_last } else { self.farthest(number, broad, deadline) };
            let group = &mut self.measured.groups[number];
            (group.ceiling, group.closest) = (ceiling, closest.filter(|_| of_last < f64::INFINITY));
        }
    }

    /// An upper bound of the distance of groups, by the boxes of their bodies.
    fn farthest(&self, number: usize, broad: &Broad, deadline: &mut Deadline) -> f64 {
        let mut ceiling = f64::INFINITY;
        for key in self.measured.keys(Asker::Groups(number as u32)) {
            if !deadline.has_room(WORK_PER_PAIR_APART) {
                break;
            }
            deadline.spend(WORK_PER_PAIR_APART);
            if self.may_meet(bodies_of(key)) {
                ceiling = ceiling.min(self.boxes_apart(key, broad)[1]);
            }
        }
        ceiling
    }
}
