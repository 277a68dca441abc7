//! Motions of robots by polynomials, and controllers that follow them no faster than is proven.

use crate::arrays::{array, fill};
use crate::budget::{punctual_budget, punctual_clock};
use crate::handle::{change, get};
use crate::outcome::punctual_stop_reason;
use crate::robot::{punctual_robot, spend};
use crate::sized::place;
use crate::status::{Fault, given};
use crate::verbs::{calls, handles, types};
use ::punctual_robot::{Ahead, Horizon, Outcome, Trajectory};
use core::mem::MaybeUninit;

handles! {
    /// A motion of all joints: pieces one after the other, each with a polynomial of time for each
    /// joint. Lines, splines and braking are such motions.
    punctual_trajectory(Trajectory);

    /// Frees a trajectory; null is fine.
    punctual_trajectory_free(trajectory);

    /// A controller that follows a plan no faster than is proven, from cycle to cycle. What was
    /// proven of the plan stays proven: each cycle goes on from there. The speed of a cycle is the
    /// largest from which the robot can still stop within the part of the plan that is proven; if
    /// nothing can be proven, it brakes along the plan, where it was proven free before. Obstacles
    /// that move by themselves are checked anew in each cycle: tell where they are before
    /// `punctual_horizon_step`.
    punctual_horizon(Horizon);

    /// Frees a controller; null is fine.
    punctual_horizon_free(horizon);
}

types! {
    /// What a `punctual_horizon` knows at the end of a cycle. Times are those of the plan, in
    /// seconds.
    told punctual_ahead(stop) from (found: Outcome<Ahead>) {
        /// Cycles since the last one that was proven for the obstacles' motions of now.
        since: u32 = found.value.since,
        /// The share of the full speed, 0 to 1, at the end of the cycle that begins now.
        speed: f64 = found.value.speed,
        /// The time of the plan then: `punctual_trajectory_at` tells where to bring the joints.
        time: f64 = found.value.time,
        /// The time of the plan at which the robot stands if it brakes from then on.
        stops_at: f64 = found.value.stops_at,
        /// Proven: no contact before this time of the plan with what stands still, nor among links.
        free_until: f64 = found.value.free_until,
        /// Whether this cycle, and braking after it, is proven free, of obstacles that move by
        /// themselves as told `since` cycles ago. False if it was not yet proven since an obstacle
        /// was added, moved or removed, or a margin was set.
        is_proven: bool = found.value.is_proven,
        /// Whether the plan that was given is followed from this cycle on.
        is_new: bool = found.value.is_new,
        /// Why the call returned.
        stop: punctual_stop_reason = found.stop.into(),
        /// Units of work done.
        work: u64 = found.work,
    }
}

calls! {
    /// Makes a trajectory without a piece.
    make punctual_trajectory_new() -> trajectory: punctual_trajectory = Trajectory::default();

    /// Adds a piece of this duration. `coefficients` holds `powers * joints` numbers: row `k` has
    /// those of the `k`-th power of the time in seconds since the piece began, one for each joint,
    /// in rad or m. Whether pieces join is not checked.
    ///
    /// Fails with BAD_ARGUMENT, which names the piece and the row, for another number of joints
    /// than in the first piece, a duration that is not above 0, and numbers that are not finite or
    /// beyond 1e30 within the piece. The trajectory is as before then.
    unsafe fn punctual_trajectory_push(
        trajectory: Option<&mut punctual_trajectory>, seconds: f64, coefficients: *const f64,
        powers: usize, joints: usize
    ) {
        let count = powers.checked_mul(joints).ok_or(Fault::Array("coefficients"))?;
        // SAFETY: the contract of the header for arrays.
        let numbers = unsafe { array(coefficients, count, "coefficients") }?;
        let rows: Vec<_> = numbers.chunks(joints.max(1)).collect();
        change(trajectory, "trajectory", |trajectory| Ok(trajectory.push(seconds, &rows)?))
    }

    /// The duration, in seconds.
    fn punctual_trajectory_seconds(
        trajectory: Option<&punctual_trajectory>, seconds: Option<&mut MaybeUninit<f64>>
    ) {
        let trajectory = get(trajectory, "trajectory")?;
        given(seconds, "seconds")?.write(trajectory.seconds());
        Ok(())
    }

    /// Where the joints are at a time; at its ends before and after it. As many values as
    /// `capacity` allows are written to `values`, and how many there are to `count`.
    unsafe fn punctual_trajectory_at(
        trajectory: Option<&punctual_trajectory>, seconds: f64, values: *mut f64, capacity: usize,
        count: Option<&mut MaybeUninit<usize>>
    ) {
        let (trajectory, count) = (get(trajectory, "trajectory")?, given(count, "count")?);
        let found = trajectory.at(seconds).into_iter();
        // SAFETY: the contract of the header for arrays.
        count.write(unsafe { fill(values, capacity, "values", found) }?);
        Ok(())
    }

    /// Takes all pieces away.
    change punctual_trajectory_clear(trajectory: punctual_trajectory) = trajectory.clear();

    /// Makes a controller of a robot at rest, without a plan, with cycles of this duration, which
    /// stops from the full speed of its plans within `braking`
    /// (`punctual_robot_braking_time`), both in seconds.
    ///
    /// Fails with BAD_ARGUMENT unless `cycle` is above 0, and both are finite and not negative.
    make punctual_horizon_new(cycle: f64, braking: f64) -> horizon: punctual_horizon =
        Horizon::new(cycle, braking)?;

    /// Tells the speed of the cycle that begins now, within a budget; `clock` may be null: the
    /// clock of the system. `plan` is a new one, which begins where the robot is and at the
    /// velocity that it has there, or null. It is followed if this cycle and braking after it can
    /// be proven, or the robot rests; else the robot brakes along the old one. However short the
    /// budget, the speed changes by at most `cycle / braking`.
    ///
    /// Fails with BAD_ARGUMENT for a plan of another number of joints, and without any plan.
    /// Nothing is changed then: braking as told before remains right.
    unsafe fn punctual_horizon_step(
        horizon: Option<&mut punctual_horizon>, robot: Option<&mut punctual_robot>,
        plan: Option<&punctual_trajectory>, budget: punctual_budget,
        clock: Option<&punctual_clock>, ahead: *mut punctual_ahead
    ) {
        let plan = plan.map(|plan| plan.0.get("plan")).transpose()?;
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let out = place(ahead, "ahead")?;
            let found = change(horizon, "horizon", |horizon| {
                spend(robot, budget, clock, |robot, budget| horizon.step(robot, plan, budget))
            })?;
            out.write(found.into());
        }
        Ok(())
    }
}
