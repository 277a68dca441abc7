//! Motions of robots and of obstacles, and controllers.

use crate::arrays::column;
use crate::errors::value_error;
use crate::limit::Limit;
use crate::robot::{One, Robot, Rows};
use numpy::{PyArrayMethods, PyUntypedArrayMethods};
use punctual::Pose;
use punctual_robot::{RobotError, Track};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// How an obstacle moves by itself, for pickles.
#[derive(Clone, Serialize, Deserialize)]
pub struct Way {
    pub poses: Vec<[f64; 12]>,
    /// Of the poses, or the linear and the angular velocity from the only one on.
    pub times: Result<Vec<f64>, [[f64; 3]; 2]>,
    /// Radius and growth.
    pub reach: [f64; 2],
}

impl Way {
    pub fn track(&self) -> Result<Track, RobotError> {
        // Poses of a pickle that is damaged stay where they are said to be wrong.
        let pose = |numbers: &[f64; 12]| Pose::from_row_major(*numbers).unwrap_or(Pose::IDENTITY);
        let mut poses = self.poses.iter().map(pose);
        let track = match &self.times {
            Ok(times) => Track::poses(&times.iter().copied().zip(poses).collect::<Vec<_>>())?,
            Err([linear, angular]) => {
                let pose = poses.next().unwrap_or(Pose::IDENTITY);
                Track::velocity(&pose, *linear, *angular)?
            }
        };
        track.reach(self.reach[0], self.reach[1])
    }
}

/// A motion of all joints: pieces one after the other, each with a polynomial of time for each joint.
///
/// `Robot.trajectory` tells whether it is free, `Horizon` follows it. Straight lines, splines and
/// braking are such motions. A `spline = scipy.interpolate.CubicSpline(times, Q)` becomes one by
/// `for i, s in enumerate(numpy.diff(times)): motion.push(s, spline.c[::-1, i])`.
#[pyclass(module = "punctual3d")]
#[derive(Default)]
pub struct Trajectory(pub punctual_robot::Trajectory);

#[pymethods]
impl Trajectory {
    #[new]
    fn build() -> Self {
        Self::default()
    }

    /// Adds a piece of this duration. coefficients: (K, J); row k has those of the k-th power of the
    /// time in seconds since the piece began, in rad or m. It is not checked whether pieces join.
    ///
    /// Raises ValueError, which names the piece and the row, for other numbers of joints than in the
    /// first piece, a duration that is not above 0, and numbers that are not finite or beyond 1e30.
    #[pyo3(signature = (seconds, coefficients))]
    fn push(&mut self, seconds: f64, coefficients: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows = coefficients.extract::<Rows<'_>>();
        let rows = rows.map_err(|_| value_error("coefficients: expected (K, J) numbers"))?;
        let values = rows.0.as_slice().map_err(value_error)?;
        let rows: Vec<&[f64]> = values.chunks(rows.0.shape()[1].max(1)).collect();
        self.0.push(seconds, &rows).map_err(value_error)
    }

    /// The duration.
    #[getter]
    fn seconds(&self) -> f64 {
        self.0.seconds()
    }

    /// The configuration at a time, (J,), or those at many, (N, J). At its ends before and after it.
    #[pyo3(signature = (seconds))]
    fn at<'py>(&self, py: Python<'py>, seconds: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        if let Ok(seconds) = seconds.extract::<f64>() {
            return Ok(column(py, self.0.at(seconds)).into_any());
        }
        let One(times) = seconds.extract()?;
        let rows: Vec<f64> = times.iter().flat_map(|&time| self.0.at(time)).collect();
        let width = rows.len() / times.len().max(1);
        Ok(column(py, rows).reshape([times.len(), width])?.into_any())
    }

    /// Takes all pieces away.
    fn clear(&mut self) {
        self.0.clear();
    }

    fn __repr__(&self) -> String {
        let joints = self.0.at(0.0).len();
        let seconds = self.0.seconds();
        format!("<punctual3d.Trajectory of {joints} joints, {seconds} s>")
    }
}

/// A controller that follows a plan no faster than is proven, from cycle to cycle.
///
/// cycle: seconds. braking: seconds in which the robot stops from the full speed (`braking_time`).
/// The robot rests at first, and has no plan. What was proven of the plan stays proven: each cycle
/// goes on from there. The speed of a cycle is the largest from which the robot can still stop
/// within the part of the plan that is proven; if nothing can be proven, it brakes along the plan,
/// where it was proven free before. Obstacles that move by themselves (`Robot.move_along`) are
/// checked anew in each cycle: tell where they are before `step`. Raises ValueError unless both are
/// finite and not negative, and cycle is above 0.
#[pyclass(module = "punctual3d")]
pub struct Horizon(punctual_robot::Horizon);

/// What a `Horizon` knows at the end of a cycle. Times of the plan are in seconds.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct Ahead {
    /// The share of the full speed, 0 to 1, at the end of the cycle that begins now.
    speed: f64,
    /// The time of the plan then: `plan.at(time)` is where to bring the joints.
    time: f64,
    /// The time of the plan at which the robot stands if it brakes from then on.
    stops_at: f64,
    /// Proven: no contact before this time of the plan with what stands still, nor among links.
    free_until: f64,
    /// Whether this cycle, and braking after it, is proven free, of obstacles that move by themselves
    /// as told `since` cycles ago.
    is_proven: bool,
    /// Number of cycles since the last one that was proven for the tracks of now.
    since: u32,
    /// Whether the plan that was given is followed from this cycle on.
    is_new: bool,
    /// Units of work done.
    work: u64,
}

#[pymethods]
impl Horizon {
    #[new]
    #[pyo3(signature = (cycle, braking))]
    fn build(cycle: f64, braking: f64) -> PyResult<Self> {
        let horizon = punctual_robot::Horizon::new(cycle, braking);
        horizon.map(Self).map_err(value_error)
    }

    /// Tells the speed of the cycle that begins now. plan: a new `Trajectory`, which begins where the
    /// robot is, with the velocity that it has there; it is followed if it can be proven, or the
    /// robot rests (`is_new`). budget (seconds) or work: of this call.
    ///
    /// Raises ValueError for a plan of another number of joints, and without any plan.
    #[pyo3(signature = (robot, plan=None, *, budget=None, work=None))]
    fn step(
        &mut self,
        py: Python<'_>,
        robot: &Bound<'_, Robot>,
        plan: Option<PyRef<'_, Trajectory>>,
        budget: Option<f64>,
        work: Option<u64>,
    ) -> PyResult<Ahead> {
        let limit = Limit::new(budget, work)?;
        let plan = plan.as_ref().map(|plan| &plan.0);
        let (robot, horizon) = (robot.get(), &mut self.0);
        let found = limit.run(py, |clock| {
            horizon.step(&mut robot.checker(), plan, limit.budget().clock(clock))
        })?;
        let found = found.map_err(value_error)?;
        let ahead = found.value;
        Ok(Ahead {
            speed: ahead.speed,
            time: ahead.time,
            stops_at: ahead.stops_at,
            free_until: ahead.free_until,
            is_proven: ahead.is_proven,
            since: ahead.since,
            is_new: ahead.is_new,
            work: found.work,
        })
    }
}

#[pymethods]
impl Ahead {
    fn __repr__(&self) -> String {
        let proven = if self.is_proven {
            "proven"
        } else {
            "not proven"
        };
        format!(
            "<punctual3d.Ahead: {:.3} of the speed at {:.4} s, free until {:.4} s, {proven}>",
            self.speed, self.time, self.free_until
        )
    }
}
