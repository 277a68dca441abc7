//! The cover of the cones: which set advances one, what is asked if none does, and how it is split.

use super::{
    ADVANCES, ADVANCES_BEFORE_CLIMBS, Asking, CLIMBING_LEVELS, CLIMBS, CONES, CONTACTS_AHEAD,
    Climb, Heard, Job, LISTS, Machine, POINTS_A_CONE, POINTS_TRIED, SHORT_CLIMB, SHORTER, STEP,
    Stage, Task, WORK_PER_BALL, WORK_PER_BOX, WORK_PER_NEW_PAIR, WORK_PER_PAIR, WORK_PER_PROOF,
};
use crate::cover::Cone;
use glam::DVec3;

impl Machine<'_, '_, '_, '_> {
    /// Takes the cone with the least radius.
    pub(super) fn pick(&mut self) -> u64 {
        if self.state.advances == ADVANCES_BEFORE_CLIMBS && self.may_seek() {
            self.state.job = Job::Seek(0);
            return 64;
        }
        let state = &mut *self.state;
        state.job = Job::Over;
        if let Some(cone) = state.cones.pop() {
            state.advances += 1;
            let radius = cone.radius;
            let rays = cone.rays(state.rounding);
            self.raise_low(radius);
            if let Some(rays) = rays
                && self.state.advances < ADVANCES
            {
                self.state.job = Job::Advance(Task {
                    cone,
                    rays,
                    proven: radius,
                    best: None,
                    stage: Stage::Balls,
                });
            }
        }
        200
    }

    /// Ends the turn of a cone if it gained enough; otherwise its next stage follows.
    pub(super) fn settle(&mut self, task: Task) {
        if self.state.is_gain(&task.cone, task.proven) {
            self.put_back(task);
            self.state.job = Job::Pick;
        } else {
            self.state.job = Job::Advance(task);
        }
    }

    pub(super) fn put_back(&mut self, task: Task) {
        self.state.add_cone(Cone {
            radius: task.proven,
            ..task.cone
        });
    }

    /// The middle of a cone, and how far a push along it is tried.
    pub(super) fn goal(&self, task: &Task) -> (DVec3, f64) {
        let (radius, high) = (task.proven, self.state.high);
        let goal = if high < f64::INFINITY {
            (SHORTER * high).max(0.5 * (radius + high))
        } else {
            2.0 * radius
        };
        (task.cone.middle(), goal)
    }

    pub(super) fn work_on(&mut self, mut task: Task) -> u64 {
        match task.stage {
            Stage::Balls => {
                for ball in self.state.balls.iter().rev() {
                    if let Some(advance) = task.rays.by_ball(ball) {
                        task.proven = task.proven.max(advance.radius);
                    }
                }
                task.stage = Stage::Pairs {
                    next: 0,
                    last: false,
                };
                self.settle(task);
                self.state.balls.len() as u64 * WORK_PER_BALL + 64
            }
            Stage::Pairs { next, last } => self.try_pairs(task, next, last),
            Stage::Block => {
                let (middle, goal) = self.goal(&task);
                self.ask(Asking::Apart { at: middle * goal })
            }
            Stage::Points { next, near } => self.try_point(task, next, near),
            Stage::Contacts => self.ask(Asking::Contacts {
                at: self.just_outside(&task),
                most: CONTACTS_AHEAD,
            }),
            Stage::Free => self.ask(Asking::Apart {
                at: self.just_outside(&task),
            }),
            Stage::Read(next) => {
                let count = self.engine.pairs().len();
                let last = (next + 8).min(count);
                for i in next..last {
                    let pair = self.engine.pairs()[i];
                    let corners = self.corners(pair);
                    self.state.add_pair(pair, corners);
                }
                task.stage = if last < count {
                    Stage::Read(last)
                } else {
                    Stage::Pairs {
                        next: 0,
                        last: true,
                    }
                };
                self.state.job = Job::Advance(task);
                (last - next) as u64 * WORK_PER_NEW_PAIR + 64
            }
            Stage::Split => {
                task.cone.radius = task.proven;
                let has_room = self.state.cones.len() + 4 <= CONES;
                self.state.job = match task.cone.split().filter(|_| has_room) {
                    Some(parts) => {
                        parts.into_iter().for_each(|cone| self.state.add_cone(cone));
                        Job::Pick
                    }
                    None => Job::Over,
                };
                600
            }
        }
    }

    /// A push along the middle of a cone, a little longer than its radius.
    pub(super) fn just_outside(&self, task: &Task) -> DVec3 {
        let length = task.proven * (1.0 + 1e-3) + 16.0 * self.state.rounding;
        task.cone.middle() * length.min(self.state.high)
    }

    /// Tries some of the known pairs, the one that helped last first.
    pub(super) fn try_pairs(&mut self, mut task: Task, mut next: usize, last: bool) -> u64 {
        let (state, [least, most]) = (&*self.state, task.rays.bounds());
        let mut work = 64;
        let first = usize::from(task.cone.hint);
        let order = |i: usize| if i == 0 { first } else { i - 1 };
        while next <= state.pairs.len() && work < STEP - WORK_PER_PAIR - WORK_PER_PROOF {
            let number = order(next);
            next += 1;
            work += WORK_PER_BOX;
            let Some([from, to]) = state.bounds.get(number) else {
                continue;
            };
            if !(from.cmple(least) & to.cmpge(most)).all() {
                continue;
            }
            work += WORK_PER_PAIR;
            if let Some(advance) = task.rays.by_pair(&state.pairs[number]) {
                let best = task.best.map_or(task.proven, |(best, _)| best.radius);
                if advance.radius > best {
                    task.best = Some((advance, number as u16));
                    if advance.radius >= state.high {
                        next = state.pairs.len() + 1;
                    }
                }
            }
        }
        if next <= state.pairs.len() {
            task.stage = Stage::Pairs { next, last };
            self.state.job = Job::Advance(task);
            return work;
        }
        if let Some((advance, number)) = task.best.take()
            && task
                .rays
                .proves(&state.pairs[usize::from(number)], &advance)
        {
            (task.proven, task.cone.hint) = (advance.radius, number);
        }
        if last {
            let gains = self.state.is_gain(&task.cone, task.proven);
            self.state.trials[LISTS].note(gains);
        }
        task.stage = if last { Stage::Split } else { Stage::Block };
        self.settle(task);
        work + WORK_PER_PROOF
    }

    /// Asks how deep one of the latest points is, half way to the best push or at the radius.
    pub(super) fn try_point(&mut self, mut task: Task, next: usize, near: bool) -> u64 {
        let Some(index) = self.candidate(next) else {
            let at = self.far(&task, false);
            let distance = |other: DVec3| (other - at).length_squared();
            let summits = self.state.summits.iter();
            let nearest = summits.min_by(|(x, _), (y, _)| distance(*x).total_cmp(&distance(*y)));
            self.state.job = match nearest {
                Some(&(other, summit))
                    if task.cone.level < CLIMBING_LEVELS && self.state.trials[CLIMBS].is_due() =>
                {
                    let step = 0.25 * punctual_geom::length(at - other);
                    let start = summit + (at - other) * 0.5;
                    Job::Climb(Climb::new(0, at, start, step, SHORT_CLIMB, Some(task)))
                }
                _ => {
                    task.stage = self.before_contacts();
                    Job::Advance(task)
                }
            };
            return 200;
        };
        let at = self.far(&task, near);
        let needed = task.rays.farthest(at);
        self.ask_point(index, at, needed).unwrap_or_else(|| {
            task.stage = after_point(next, near);
            self.state.job = Job::Advance(task);
            150
        })
    }

    /// Contacts at the cone, if they are worth it; otherwise the split.
    pub(super) fn before_contacts(&mut self) -> Stage {
        if self.state.trials[LISTS].is_due() {
            Stage::Contacts
        } else {
            Stage::Split
        }
    }

    /// The point that is tried for a cone after `next` others: the latest two, then the latest
    /// that were inside.
    pub(super) fn candidate(&self, next: usize) -> Option<usize> {
        let latest = self.state.points.len().checked_sub(2).unwrap_or_default();
        let points = self.state.points.iter().enumerate().rev();
        let mut tried = points.filter(|(i, point)| *i >= latest || !point.inside.is_empty());
        let (index, _) = tried.nth(next)?;
        (next < POINTS_A_CONE).then_some(index)
    }

    /// A push along the middle of a cone, at its radius or half way to the best.
    pub(super) fn far(&self, task: &Task, near: bool) -> DVec3 {
        let radius = task.cone.radius;
        let length = if near {
            radius
        } else {
            (0.5 * (radius + self.state.high)).min(2.0 * radius.max(self.state.low))
        };
        task.cone.middle() * length
    }

    pub(super) fn worked_on(&mut self, mut task: Task, heard: Heard) {
        match (task.stage, heard) {
            (Stage::Block, Heard::Blocked(pair)) => {
                let (middle, _) = self.goal(&task);
                pair.inspect(|&pair| self.learn(pair, middle));
                let next = if self.state.trials[POINTS_TRIED].is_due() {
                    0
                } else {
                    POINTS_A_CONE
                };
                task.stage = Stage::Points { next, near: false };
                self.state.job = Job::Advance(task);
            }
            (Stage::Block, Heard::Apart) => {
                let (direction, high) = self.goal(&task);
                self.state.separates(direction, high);
                let low = task.proven;
                self.put_back(task);
                self.state.job = Job::Shorten {
                    direction,
                    low,
                    high,
                };
            }
            (Stage::Points { next, near }, Heard::Near(distance, nearest)) => {
                let at = self.far(&task, near);
                let index = self.candidate(next);
                let ball = index.and_then(|i| self.add_ball(i, at, distance, nearest));
                if let Some(advance) = ball.and_then(|ball| task.rays.by_ball(&ball)) {
                    task.proven = task.proven.max(advance.radius);
                }
                if near || ball.is_some() {
                    let gains = self.state.is_gain(&task.cone, task.proven);
                    self.state.trials[POINTS_TRIED].note(gains);
                }
                task.stage = after_point(next, near || ball.is_some());
                self.settle(task);
            }
            (Stage::Contacts, Heard::Contacts(count)) => {
                task.stage = if count == 0 {
                    Stage::Free
                } else {
                    Stage::Read(0)
                };
                self.state.job = Job::Advance(task);
            }
            (Stage::Free, heard) => {
                if let Heard::Apart = heard {
                    let at = self.just_outside(&task);
                    let length = task.proven * (1.0 + 1e-3) + 16.0 * self.state.rounding;
                    if length < self.state.high && at == task.cone.middle() * length {
                        self.state.separates(task.cone.middle(), length);
                    }
                }
                task.stage = Stage::Split;
                self.state.job = Job::Advance(task);
            }
            _ => {}
        }
    }
}

/// The stage after a point was tried far out or near.
fn after_point(next: usize, near: bool) -> Stage {
    if near {
        Stage::Points {
            next: next + 1,
            near: false,
        }
    } else {
        Stage::Points { next, near: true }
    }
}
