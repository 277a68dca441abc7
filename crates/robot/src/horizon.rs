//! A controller's question: for how long is the robot free if its joints keep their velocities?

use punctual::clock::ClockedBudget;

use crate::checker::Outcome;
use crate::{Checker, Edge, EdgeOptions, RobotError};

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
        let edge = self.line(
            [configuration, &then],
            EdgeOptions::first(),
            seconds,
            budget,
        );
        self.room.then = then;
        edge
    }
}
