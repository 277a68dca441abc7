//! The cover of the cones: which set advances a cone, what is asked if none does, and how it is
//! split.

use super::cover::{Advance, Cone};
use super::machine::{Current, Machine, RESOLUTION, STEP, Step, Task};
use super::pushes::Push;
use super::sets::{CONES, WORK_PER_BOX, WORK_PER_SET};
use core::cmp::Reverse;

/// Work to prove an advance by a pair.
const WORK_PER_PROOF: u64 = 1200;

/// The search ends after this many advances of a cone.
const ADVANCES: u32 = 20_000;

/// Balls are grown before the first cone if `low` is less than this share of `high`.
const DEEP: f64 = 0.5;

impl Machine<'_, '_, '_> {
    /// Makes the first cones, with the radius proven so far.
    pub(super) fn start(&mut self) -> Step {
        self.pay(2 * WORK_PER_PROOF)?;
        let rounding = self.state.rounding;
        if let Some((margin, pair)) = &self.state.widest
            && !self.asked.asked.push_only
            && !self.state.is_thick
            && 0.9 * margin > RESOLUTION * rounding
            && pair.fills_cube(0.9 * margin)
        {
            let radius = 0.9 * margin - 8.0 * rounding;
            self.state.raise_low(radius);
        }
        let radius = self.state.low;
        self.state.task = if !self.state.seeds.is_empty() && radius < DEEP * self.state.high {
            Task::Grow
        } else if self.state.is_thick || radius <= RESOLUTION * rounding {
            self.explore_all()
        } else {
            self.state.seeds.clear();
            for cone in Cone::all_around(radius) {
                self.add_cone(cone);
            }
            Task::Pick
        };
        Ok(())
    }

    fn add_cone(&mut self, cone: Cone) {
        let index = self.sets.cones.len();
        self.sets.cones.push(cone);
        self.sets.open.push(Reverse((cone.radius.to_bits(), index)));
    }

    /// Makes the cone with the least radius the current one.
    pub(super) fn pick(&mut self) -> Step {
        self.pay(200)?;
        self.state.task = Task::Over;
        if let Some(Reverse((_, index))) = self.sets.open.pop() {
            let cone = self.sets.cones[index];
            self.state.raise_low(cone.radius);
            self.state.advances += 1;
            if self.state.advances < ADVANCES && cone.rays(self.state.rounding).is_some() {
                self.state.current = Some(Current {
                    index,
                    cone,
                    proven: cone.radius,
                    has_asked: false,
                });
                self.state.task = Task::Try(0, None);
            }
        }
        Ok(())
    }

    /// Puts the current cone back, with the radius that is proven.
    pub(super) fn put_back(&mut self) -> Task {
        if let Some(Current { index, proven, .. }) = self.state.current.take() {
            self.sets.cones[index].radius = proven;
            self.sets.open.push(Reverse((proven.to_bits(), index)));
        }
        Task::Pick
    }

    /// Tries some of the known sets.
    pub(super) fn try_sets(&mut self, mut next: usize, mut best: Option<(Advance, usize)>) -> Step {
        let current = self.state.current;
        let rays =
            current.and_then(|current| Some((current, current.cone.rays(self.state.rounding)?)));
        let Some((mut current, rays)) = rays else {
            return Ok(());
        };
        self.deadline.check(STEP)?;
        let (sets, bounds, high) = (&*self.sets, rays.bounds(), self.state.high);
        let mut work = 64;
        while next < sets.len() && work <= STEP - WORK_PER_BOX - WORK_PER_SET - WORK_PER_PROOF {
            work += WORK_PER_BOX;
            if sets.may_hold(next, &rays, bounds) {
                work += WORK_PER_SET;
                let known = best.map_or(current.proven, |(best, _)| best.radius);
                if let Some(advance) = rays.advance_by(sets.get(next), known) {
                    best = Some((advance, next));
                    if advance.radius >= high {
                        break;
                    }
                }
            }
            next += 1;
        }
        let is_enough = best.is_some_and(|(best, _)| best.radius >= high);
        if next < sets.len() && !is_enough {
            self.spend(work);
            self.state.task = Task::Try(next, best);
            return Ok(());
        }
        if let Some((advance, number)) = best
            && rays.proves(&advance, sets.get(number))
        {
            current.proven = advance.radius;
        }
        self.spend(work + WORK_PER_PROOF);
        self.state.current = Some(current);
        let goal = high.min(4.0 * current.cone.radius);
        let gains = current.proven >= high
            || current.proven > current.cone.radius + 0.25 * (goal - current.cone.radius);
        if current.has_asked {
            let [asked, helped, _] = &mut self.state.trials;
            (*asked, *helped) = (*asked + 1, *helped + u32::from(gains));
        }
        self.state.task = match (gains, current.has_asked) {
            (true, _) => self.put_back(),
            (false, true) => Task::Split,
            (false, false) => Task::Push(Push::new(current.cone.middle(), current.proven)),
        };
        Ok(())
    }

    /// Asks for new sets for the current cone, if they are worth it: one in eight attempts helped,
    /// or the last seven were skipped. Otherwise splits it.
    pub(super) fn after_block(&mut self) -> Task {
        let [asked, helped, skipped] = &mut self.state.trials;
        *skipped += 1;
        if *asked >= 8 && 8 * *helped < *asked && *skipped < 8 {
            self.state.seeds.clear();
            return Task::Split;
        }
        *skipped = 0;
        Task::List
    }

    /// Splits the current cone.
    pub(super) fn split(&mut self) -> Step {
        self.pay(600)?;
        let has_room = self.sets.cones.len() + 3 <= CONES;
        let current = self.state.current.take().filter(|_| has_room);
        let parts = current.and_then(|mut current| {
            current.cone.radius = current.proven;
            Some((current.index, current.cone.split()?))
        });
        self.state.task = Task::Over;
        if let Some((index, [first, rest @ ..])) = parts {
            self.sets.cones[index] = first;
            let key = (first.radius.to_bits(), index);
            self.sets.open.push(Reverse(key));
            rest.into_iter().for_each(|cone| self.add_cone(cone));
            self.state.task = Task::Pick;
        }
        Ok(())
    }
}
