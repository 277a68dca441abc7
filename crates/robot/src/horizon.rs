//! A controller's question: for how long is the robot free if its joints keep their velocities?

use punctual::clock::ClockedBudget;
use punctual::engine::Deadline;
use punctual::{Budget, StopReason};

use crate::call::{Call, Counted, Room};
use crate::checker::Outcome;
use crate::error::refuse;
use crate::model::LARGEST;
use crate::order::Sorted;
use crate::{Checker, Edge, EdgeAnswer, EdgeOptions, RobotError, Trajectory};

/// The shortest cycle, in seconds.
const SHORTEST: f64 = 1e-30;

/// The largest share of the speed (0 to 1) with which a robot that is free for `free_for` seconds
/// at full speed may go on for `cycle` seconds, and then still stop in time.
///
/// `braking` is the time in seconds in which it stops from the full speed at a constant
/// deceleration, all joints in proportion ([`braking_time`]). At the share `s` it stops in `s
/// braking`, on half of the way: `s cycle + s s braking / 2 <= free_for`.
///
/// It is 0 if a number is NaN.
pub fn safe_speed(free_for: f64, cycle: f64, braking: f64) -> f64 {
    let is_free = free_for > 0.0 && !cycle.is_nan() && !braking.is_nan();
    let (cycle, braking) = (cycle.max(0.0), braking.max(0.0));
    let root = (cycle * cycle + 2.0 * braking * free_for).sqrt();
    let share = 2.0 * free_for / (cycle + root) * (1.0 - 1e-12);
    // The quotient of infinite numbers, NaN, stands for a robot that is free forever.
    if is_free { share.min(1.0) } else { 0.0 }
}

/// The time in seconds in which joints with these velocities stop, if each brakes at no more than
/// its deceleration (rad/s^2 or m/s^2). All brake in proportion, so that they stay on their
/// straight line. Infinite if a velocity is NaN, or a joint that moves has no deceleration above 0.
pub fn braking_time(velocity: &[f64], decelerations: &[f64]) -> f64 {
    let time = |(i, v): (usize, &f64)| {
        let most = decelerations.get(i).map_or(0.0, |a| a.max(0.0));
        let time = v.abs() / most;
        if time.is_nan() { f64::INFINITY } else { time }
    };
    let moving = velocity.iter().enumerate().filter(|(_, v)| **v != 0.0);
    moving.map(time).fold(0.0, f64::max)
}

impl Checker {
    /// Finds for how long the robot is free if its joints go on at this velocity (rad/s or m/s), up
    /// to `seconds`. NaN and negative values of it count as 0. Times of the answer are in seconds.
    ///
    /// **Guarantee.** As that of [`Checker::edge`], which seeks the first contact here: the near
    /// future is proven first, so a budget that ends early leaves a shorter `free_until`.
    ///
    /// # Errors
    /// [`RobotError::Length`], [`RobotError::JointValue`], of the configurations now and then.
    ///
    /// ```no_run
    /// # use punctual::Budget;
    /// # use punctual_robot::{Checker, RobotError, braking_time, safe_speed};
    /// # fn cycle(checker: &mut Checker, q: [f64; 7]) -> Result<(), RobotError> {
    /// let velocity = [0.5, 0.0, 0.0, -0.2, 0.0, 0.0, 0.0];
    /// let budget = Budget::time(std::time::Duration::from_micros(200));
    /// let ahead = checker.horizon(&q, &velocity, 0.1, budget)?.value;
    /// let speed = safe_speed(ahead.free_until, 0.001, braking_time(&velocity, &[10.0; 7]));
    /// # Ok(())
    /// # }
    /// ```
    pub fn horizon<'c>(
        &mut self,
        configuration: &[f64],
        velocity: &[f64],
        seconds: f64,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Edge>, RobotError> {
        self.model().check(velocity)?;
        let seconds = seconds.max(0.0);
        let ways = velocity.iter().map(|v| v * seconds);
        let mut then = std::mem::take(&mut self.room.then);
        then.clear();
        then.extend(configuration.iter().zip(ways).map(|(q, way)| q + way));
        let mut options = EdgeOptions::first();
        options.duration = seconds;
        let edge = self.edge(configuration, &then, &options, budget);
        self.room.then = then;
        edge
    }
}

/// A controller that follows a plan no faster than is proven, from cycle to cycle.
///
/// What was proven of the plan stays proven: each cycle goes on from there with what is left of its
/// budget. The speed of a cycle is the largest from which the robot can still stop within the part
/// of the plan that is proven. If nothing can be proven, the robot brakes along the plan, at no
/// more than its deceleration, where it was proven free before.
///
/// A plan is a motion at full speed. The robot follows it at a share of that speed, 0 to 1, which
/// changes steadily within a cycle, by no more than `cycle / braking`. Obstacles that move by
/// themselves ([`Checker::move_along`]; time 0 is the beginning of the cycle) are checked anew in
/// each cycle, against the motion of the cycle and the braking after it.
///
/// ```
/// # use punctual::Budget;
/// # use punctual_robot::{Checker, Horizon, RobotError, Trajectory, braking_time};
/// # fn control(checker: &mut Checker, q: [f64; 2]) -> Result<(), RobotError> {
/// let velocity = [0.5, -0.2];
/// let mut plan = Trajectory::default();
/// plan.push(3.0, &[&q, &velocity])?;
/// let mut horizon = Horizon::new(0.001, braking_time(&velocity, &[10.0; 2]))?;
/// let mut new = Some(&plan);
/// loop {
///     let budget = Budget::time(std::time::Duration::from_micros(200));
///     let ahead = horizon.step(checker, new.take(), budget)?.value;
///     let q = plan.at(ahead.time);
///     // Bring the joints to q at the end of the cycle.
/// #   if ahead.speed == 0.0 { break }
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Horizon {
    cycle: f64,
    braking: f64,
    speed: f64,
    /// The time of the plan at the end of the last cycle.
    time: f64,
    since: u32,
    plan: Proof,
    /// A plan that was proposed.
    proposed: Proof,
    /// The motion that is checked against obstacles that move by themselves.
    motion: Trajectory,
}

/// The state at the end of a cycle of a [`Horizon`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Ahead {
    /// The share of the full speed at the end of the cycle that begins now.
    pub speed: f64,
    /// The time of the plan at the end of this cycle.
    pub time: f64,
    /// The time of the plan at which the robot stands if it brakes from then on.
    pub stops_at: f64,
    /// Proven: before this time of the plan there is no contact with what stands still, nor among
    /// the robot's links.
    pub free_until: f64,
    /// True if this cycle, and braking after it, is proven free: of what stands still, and of
    /// obstacles that move by themselves as set in the cycle `since` cycles ago. False if it was
    /// not yet proven since an obstacle was added, moved or removed, or a margin was set.
    pub is_proven: bool,
    /// Number of cycles since the last one that was proven for the present tracks of the obstacles.
    pub since: u32,
    /// True if the plan that was given is followed from this cycle on.
    pub is_new: bool,
}

/// A plan and what is proven of it.
#[derive(Debug, Default)]
struct Proof {
    plan: Trajectory,
    /// The version of the world for which the proof was begun.
    version: u64,
    room: Room,
    order: Sorted,
    /// The time of the plan from which on it is proven.
    from: f64,
    free_until: f64,
}

impl Proof {
    /// Takes over a plan, of which nothing is proven.
    fn begin(&mut self, plan: &Trajectory) {
        self.plan.copy(plan);
        self.version = 0;
    }

    /// Goes on until the plan is proven up to a time of it, beginning at `time` if the world has
    /// changed.
    fn advance(
        &mut self,
        checker: &mut Checker,
        deadline: &mut Deadline<'_>,
        time: f64,
        until: f64,
    ) -> Result<(), StopReason> {
        let world = &checker.world;
        if self.version != world.version {
            self.version = world.version;
            self.room.sync(world);
            // The order may change while the proof goes on.
            checker.order.count(0, world);
            let Sorted { pairs, ranks } = &checker.order.sorted;
            self.order.pairs.clone_from(pairs);
            self.order.ranks.clone_from(ranks);
            self.room.run.lines.copy(&self.plan);
            self.room.run.begin(EdgeOptions::first(), time);
            self.room.run.is_stopped = true;
            (self.free_until, self.from) = (0.0, self.room.run.edge(world).free_until);
        }
        if self.free_until >= until || !self.room.run.is_stopped {
            return Ok(());
        }
        let mut call = Call {
            world,
            order: &self.order,
            facts: &mut checker.order.facts,
            room: &mut self.room,
            deadline: take(deadline),
            pairs: Counted::Still,
        };
        let mut run = std::mem::take(&mut call.room.run);
        run.pause = until;
        let end = run.advance(&mut call);
        // Where the proof begins, a contact may be.
        let edge = run.edge(world);
        if edge.free_until > self.from || edge.answer == EdgeAnswer::Free {
            self.free_until = edge.free_until;
        }
        *deadline = call.deadline;
        self.room.run = run;
        end
    }
}

/// Takes a deadline, which is put back after a call.
fn take<'c>(deadline: &mut Deadline<'c>) -> Deadline<'c> {
    std::mem::replace(deadline, Deadline::of(Budget::work(0).into()))
}

impl Horizon {
    /// A robot at rest, without a plan, with cycles of this duration, that stops from the full
    /// speed within `braking` ([`braking_time`]), both in seconds.
    ///
    /// # Errors
    /// [`RobotError::Model`] unless the cycle is 1e-30 to 1e30 s, and `braking` 0 to 1e30 s.
    pub fn new(cycle: f64, braking: f64) -> Result<Self, RobotError> {
        if !((SHORTEST..=LARGEST).contains(&cycle) && (0.0..=LARGEST).contains(&braking)) {
            let what = format!("horizon: cycle {cycle} s, braking {braking} s");
            return refuse(format!(
                "{what}, allowed is {SHORTEST:e}, and 0, to {LARGEST:e}"
            ));
        }
        Ok(Self {
            cycle,
            braking,
            speed: 0.0,
            time: 0.0,
            since: 0,
            plan: Proof::default(),
            proposed: Proof::default(),
            motion: Trajectory::default(),
        })
    }

    /// Returns the speed of the cycle that begins now.
    ///
    /// `plan` is a new one, which begins where the robot is and with the velocity that the old one
    /// has there, or none. It is followed if this cycle and braking after it can be proven within
    /// the budget, or the robot is at rest; otherwise the robot brakes along the old plan.
    ///
    /// **Guarantee.** However short the budget, the speed changes by at most `cycle / braking`, and
    /// the robot can stop where the plan is proven, up to the rounding of times
    /// ([`Ahead::is_proven`]).
    ///
    /// # Errors
    /// [`RobotError::Length`] or [`RobotError::Model`] of the plan; without any plan
    /// [`RobotError::Model`]. Nothing is changed then, so the braking of the last answer remains
    /// valid.
    pub fn step<'c>(
        &mut self,
        checker: &mut Checker,
        plan: Option<&Trajectory>,
        budget: impl Into<ClockedBudget<'c>>,
    ) -> Result<Outcome<Ahead>, RobotError> {
        let model = checker.model();
        model.check_motion(plan.unwrap_or(&self.plan.plan))?;
        if plan.is_some() && self.speed > 0.0 {
            model.check_motion(&self.plan.plan)?;
        }
        let mut deadline = Deadline::of(budget.into());
        let (limit, change) = self.limit();
        let slowest = if self.speed <= limit {
            0.0
        } else {
            self.speed - change
        };
        let speeds = [slowest, (self.speed + change).min(1.0)];
        let old = plan.map(|plan| {
            std::mem::swap(&mut self.plan, &mut self.proposed);
            self.plan.begin(plan);
            std::mem::replace(&mut self.time, 0.0)
        });
        let mut found = self.fastest(checker, &mut deadline, speeds);
        let is_new = old.is_some() && (found.is_some() || self.speed == 0.0);
        if let Some(time) = old.filter(|_| !is_new) {
            std::mem::swap(&mut self.plan, &mut self.proposed);
            (self.time, found) = (time, None);
        }
        let speed = found.unwrap_or(speeds[0]);
        let is_proven = self.is_covered(speed);
        self.since = match found {
            Some(_) => 0,
            None => self.since.saturating_add(1),
        };
        let end = self
            .plan
            .advance(checker, &mut deadline, self.time, f64::INFINITY);
        self.time += self.way(speed);
        self.speed = speed;
        let value = Ahead {
            speed,
            time: self.time,
            stops_at: self.time + self.stop_way(speed),
            free_until: self.plan.free_until,
            is_proven,
            since: self.since,
            is_new,
        };
        Ok(Outcome {
            value,
            stop: end.err().unwrap_or(StopReason::Finished),
            work: deadline.done(),
            elapsed: deadline.elapsed(),
        })
    }

    /// The fastest speed at the end of the cycle for which all is proven.
    fn fastest(
        &mut self,
        checker: &mut Checker,
        deadline: &mut Deadline<'_>,
        [slowest, fastest]: [f64; 2],
    ) -> Option<f64> {
        let until = self.time + self.way(fastest) + self.stop_way(fastest);
        let _ = self.plan.advance(checker, deadline, self.time, until);
        let free = self.plan.free_until - self.time - 0.5 * self.cycle * self.speed;
        // Braking by cycles takes up to this more than at a constant deceleration.
        let rest = (0.125 * self.cycle * self.cycle / self.braking).min(0.5 * self.cycle);
        let [rest, braking] = [rest, self.braking].map(|x| x * (1.0 + 1e-6));
        let allowed = safe_speed(free - rest, 0.5 * self.cycle, braking);
        let mut speeds = [allowed.clamp(slowest, fastest), slowest].into_iter();
        let mut is_free = |speed: f64| {
            let is_timed = !checker.world.tracks.is_empty();
            self.is_covered(speed) && (!is_timed || self.avoids(checker, deadline, speed))
        };
        speeds.find(|&speed| is_free(speed))
    }

    /// True if obstacles that move by themselves are proven not to meet the robot in a cycle that
    /// ends at this speed, nor while it brakes after it.
    fn avoids(&mut self, checker: &mut Checker, deadline: &mut Deadline<'_>, speed: f64) -> bool {
        let (cycles, last) = self.steps(speed);
        let (motion, plan, mut at) = (&mut self.motion, &self.plan.plan, self.time);
        motion.clear();
        motion.add_part(plan, &mut at, self.cycle, [self.speed, speed]);
        motion.add_part(plan, &mut at, cycles * self.cycle, [speed, last]);
        motion.add_part(plan, &mut at, self.cycle, [last, 0.0]);
        checker.sync(0);
        let mut run = std::mem::take(&mut checker.room.run);
        run.lines.copy(motion);
        run.begin(EdgeOptions::any(), 0.0);
        let mut call = Call {
            world: &checker.world,
            order: &checker.order.sorted,
            facts: &mut checker.order.facts,
            room: &mut checker.room,
            deadline: take(deadline),
            pairs: Counted::Timed,
        };
        let _ = run.advance(&mut call);
        *deadline = call.deadline;
        let answer = run.edge(&checker.world).answer;
        run.is_stopped = false;
        checker.room.run = run;
        answer == EdgeAnswer::Free
    }

    /// The time of the plan that passes in a cycle that ends at this speed.
    fn way(&self, speed: f64) -> f64 {
        0.5 * self.cycle * (self.speed + speed)
    }

    /// The time of the plan that passes while the robot brakes from this speed.
    fn stop_way(&self, speed: f64) -> f64 {
        let (cycles, last) = self.steps(speed);
        0.5 * self.cycle * (cycles * (speed + last) + last)
    }

    /// True if the plan is proven where the robot is in a cycle that ends at this speed, and while
    /// it brakes after it. The rounding of times is below the slack of the proof.
    fn is_covered(&self, speed: f64) -> bool {
        let stop = self.time + self.way(speed) + self.stop_way(speed);
        stop < self.plan.free_until * (1.0 + 1e-13)
    }

    /// The most by which the speed may change in a cycle, and a change just below it, so that no
    /// rest of rounding is left when the robot has stopped.
    fn limit(&self) -> (f64, f64) {
        let limit = (self.cycle / self.braking).min(1.0);
        (limit, limit * (1.0 - 1e-9))
    }

    /// How the robot brakes by cycles: the number of those in which its speed falls by the most,
    /// and the speed at the beginning of the last one, in which it stops.
    fn steps(&self, speed: f64) -> (f64, f64) {
        let (limit, change) = self.limit();
        let cycles = ((speed - limit) / change).ceil().max(0.0);
        (cycles, speed - cycles * change)
    }
}
