//! The loop of a penetration query, and the questions that it puts to the trees.

use super::{Asking, Heard, Job, Machine, PenetrationQuery, STEP, WORK_PER_RAY};
use glam::{DMat3, DVec3};
use punctual::distance::Distance;
use punctual::engine::Ask;
use punctual::intersection::Intersection;
use punctual::{Budget, Query, Stats, StopReason};
use punctual_geom::Pose;

impl Machine<'_, '_, '_, '_> {
    /// Continues until the search is over or the deadline stops it.
    pub(super) fn advance(&mut self) -> StopReason {
        // The first step may exceed the budget, so that every call gets on.
        let mut needed = 1;
        loop {
            if self.is_over() {
                self.state.job = Job::Over;
                return StopReason::Finished;
            }
            if let Some((asking, has_begun)) = self.state.asking {
                match self.put(asking, has_begun) {
                    Ok(Some(heard)) => {
                        self.state.asking = None;
                        self.hear(heard);
                    }
                    // The next part of the same question.
                    Ok(None) => {}
                    Err(stop) => return stop,
                }
            } else if self.deadline.has_room(needed) {
                let work = self.step().min(STEP);
                self.deadline.spend(work);
                self.state.stats.work += work;
                needed = STEP;
            } else {
                return self.deadline.why(needed);
            }
        }
    }

    pub(super) fn is_over(&self) -> bool {
        let state = &*self.state;
        let limit = self.asked.limit;
        matches!(state.job, Job::Over)
            || state.high <= (1.0 + self.asked.tolerance) * state.low
            || limit < f64::INFINITY && state.penetration(limit).deeper.is_some()
    }

    /// Puts a question to the trees, or continues it. `None` if another part of it follows.
    pub(super) fn put(
        &mut self,
        asking: Asking,
        has_begun: bool,
    ) -> Result<Option<Heard>, StopReason> {
        match asking {
            Asking::Contacts { at, most } => {
                let query = Query::all_pairs(self.asked.a, self.asked.b, self.pushed(at));
                let query = query.pair_limit(most);
                self.search(&query, has_begun)?;
                Ok(Some(Heard::Contacts(self.engine.pairs().len())))
            }
            Asking::Apart { at } => {
                let query = Query::intersection(self.asked.a, self.asked.b, self.pushed(at));
                let witness = self.search(&query, has_begun)?;
                if witness.is_some() {
                    return Ok(Some(Heard::Blocked(witness)));
                }
                if !self.asked.solid {
                    return Ok(Some(Heard::Apart));
                }
                self.state.asking = Some((Asking::Contained { at, next: 0 }, false));
                Ok(None)
            }
            Asking::Contained { at, next } => {
                if !self.deadline.has_room(1) {
                    return Err(self.deadline.why(1));
                }
                let (contained, next) = self.contained(at, next);
                self.deadline.spend(STEP);
                self.state.stats.work += STEP;
                match next {
                    _ if contained => Ok(Some(Heard::Blocked(None))),
                    None => Ok(Some(Heard::Apart)),
                    Some(next) => {
                        self.state.asking = Some((Asking::Contained { at, next }, false));
                        Ok(None)
                    }
                }
            }
            Asking::Near { of_b, point } => {
                let tree = if of_b { self.asked.b } else { self.asked.a };
                let (Some(one), Ok(pose)) = (self.point, Pose::new(DMat3::IDENTITY, point)) else {
                    return Ok(Some(Heard::Near(0.0, point)));
                };
                let query = Query::distance(tree, one, pose)
                    .absolute_tolerance(0.0)
                    .relative_tolerance(0.02);
                self.measure(&query, has_begun).map(Some)
            }
        }
    }

    /// Runs a query to its end, or until the deadline. Returns two triangles that meet.
    pub(super) fn search(
        &mut self,
        query: &Query<'_, Intersection>,
        has_begun: bool,
    ) -> Result<Option<[u32; 2]>, StopReason> {
        let before = if has_begun {
            self.engine.stats()
        } else {
            query.begin_task(true, 0, self.engine, Some(&self.state.memory));
            Stats::default()
        };
        let stop = query.search(self.engine, Some(&mut self.state.memory), self.deadline);
        self.account(before);
        match stop {
            StopReason::Finished | StopReason::FirstHit | StopReason::PairsFull => {
                Ok(self.engine.verdict(stop).witness())
            }
            stop => Err(self.interrupted(stop)),
        }
    }

    pub(super) fn measure(
        &mut self,
        query: &Query<'_, Distance>,
        has_begun: bool,
    ) -> Result<Heard, StopReason> {
        let before = if has_begun {
            self.engine.stats()
        } else {
            query.begin(self.engine, None, Budget::unlimited());
            Stats::default()
        };
        let answer = query.spend(self.engine, None, self.deadline);
        self.account(before);
        match answer.stop {
            StopReason::Finished => {
                let nearest = answer.value.nearest.map(|nearest| nearest.points[0]);
                Ok(Heard::Near(answer.value.low, nearest.unwrap_or_default()))
            }
            stop => Err(self.interrupted(stop)),
        }
    }

    /// The question continues in the next call.
    pub(super) fn interrupted(&mut self, stop: StopReason) -> StopReason {
        if let Some((_, has_begun)) = &mut self.state.asking {
            *has_begun = true;
        }
        stop
    }

    pub(super) fn account(&mut self, before: Stats) {
        let (now, stats) = (self.engine.stats(), &mut self.state.stats);
        stats.work += now.work - before.work;
        stats.bv_tests += now.bv_tests - before.bv_tests;
        stats.primitive_tests += now.primitive_tests - before.primitive_tests;
        stats.exact_tests += now.exact_tests - before.exact_tests;
    }

    /// Looks at some components at the pose after a push. Returns whether one of them is inside of
    /// the other body, and the next to look at.
    pub(super) fn contained(&self, at: DVec3, next: usize) -> (bool, Option<usize>) {
        let [a, b] = [self.asked.a, self.asked.b].map(|tree| {
            let solidity = tree.solid();
            solidity.map_or(&[][..], |solidity| solidity.components())
        });
        let pose = self.pushed(at);
        let back = pose.inverse();
        let last = (next + (STEP / WORK_PER_RAY) as usize).min(a.len() + b.len());
        let is_in = |index: usize| {
            let (tree, of_b, component) = match index.checked_sub(a.len()) {
                None => (self.asked.a, false, &a[index]),
                Some(index) => (self.asked.b, true, &b[index]),
            };
            let [corner, ..] = tree.mesh().triangle(component.first_triangle as usize);
            let place = match (&back, of_b) {
                (_, true) => pose.transform_point(corner),
                (Ok(back), false) => back.transform_point(corner),
                (Err(_), false) => return false,
            };
            self.asked.is_inside(!of_b, place)
        };
        let found = (next..last).any(is_in);
        (found, (last < a.len() + b.len()).then_some(last))
    }

    /// The pose after a push; that before it if the push leads out of the range of poses.
    pub(super) fn pushed(&self, at: DVec3) -> Pose {
        let pose = &self.asked.b_in_a;
        Pose::new(pose.rotation(), pose.translation() + at).unwrap_or(*pose)
    }

    pub(super) fn ask(&mut self, asking: Asking) -> u64 {
        self.state.asking = Some((asking, false));
        64
    }

    /// The corners of two triangles in A's frame, before a push.
    pub(super) fn corners(&self, [x, y]: [u32; 2]) -> [[DVec3; 3]; 2] {
        let PenetrationQuery { a, b, b_in_a, .. } = self.asked;
        let of_b = b.mesh().triangle(y as usize);
        [
            a.mesh().triangle(x as usize),
            of_b.map(|p| b_in_a.transform_point(p)),
        ]
    }

    /// Learns from two triangles that block a push.
    pub(super) fn learn(&mut self, pair: [u32; 2], direction: DVec3) {
        let corners = self.corners(pair);
        self.state.add_pair(pair, corners);
        self.state.blocked.add(&corners[0], &corners[1]);
        for of_b in [false, true] {
            // Is it inside of the other?
            if self.state.inner[usize::from(!of_b)] > 0.0 {
                self.state
                    .add_point(of_b, &corners[usize::from(of_b)], direction);
            }
        }
    }
}
