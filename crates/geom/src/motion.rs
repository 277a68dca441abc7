//! Rigid motions: the pose of a body at every time from 0 to 1.

use super::pose::{Pose, axes, rotation_deviation};
use super::tolerance::SCENE_REACH;
use core::fmt;
use glam::{DMat3, DQuat, DVec3};

/// A rigid motion over one unit of time, from time 0 to 1: a constant velocity, and a turn at a
/// constant rate about an axis that moves with that velocity.
///
/// At time `t` a point that `start` maps to `x` is at `p + t v + R(t w) (x - p)`. Here `v` is the
/// velocity. `w` is the turn: the axis by the right-hand rule, times the angle in radians. `p` is a
/// point of the axis at time 0, and `R` the rotation of a turn. [`Motion::pose`] evaluates this in
/// `f64`; whatever is proven of a motion holds for these poses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "(Pose, [DVec3; 3])", into = "(Pose, [DVec3; 3])")
)]
pub struct Motion {
    start: Pose,
    velocity: DVec3,
    turn: DVec3,
    arm: DVec3,
}

/// Reasons why a [`Motion`] is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MotionError {
    /// A component of the velocity, the turn or the point of the axis is NaN or infinite.
    NotFinite,
    /// A translation, a velocity or a point of the axis exceeds 2^990, or a turn 2^20 radians.
    TooLarge,
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => {
                "a component of the motion (velocity, turn or point of the axis) is not finite"
            }
            Self::TooLarge => "a length of the motion exceeds 2^990, or its turn 2^20 radians",
        })
    }
}

impl core::error::Error for MotionError {}

/// Largest accepted turn, in radians.
const LARGEST_TURN: f64 = (1 << 20) as f64;

/// A turn below this angle (radians) gets an axis through the body's origin: the screw axis would
/// be too far away.
const LEAST_SCREW: f64 = 1e-12;

impl Motion {
    /// A translation along a straight line, without turn.
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn straight(start: Pose, velocity: impl Into<[f64; 3]>) -> Result<Self, MotionError> {
        Self::with_arm(start, velocity, DVec3::ZERO, DVec3::ZERO)
    }

    /// A motion without velocity or turn. Does not check the translation of `start`: a scene has
    /// checked it.
    #[inline]
    pub const fn still(start: Pose) -> Self {
        Self {
            start,
            velocity: DVec3::ZERO,
            turn: DVec3::ZERO,
            arm: DVec3::ZERO,
        }
    }

    /// A motion with a turn: the turn is the axis times the angle in radians. `point` lies on the
    /// axis at time 0 and moves with the velocity.
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn turning(
        start: Pose,
        velocity: impl Into<[f64; 3]>,
        turn: impl Into<[f64; 3]>,
        point: impl Into<[f64; 3]>,
    ) -> Result<Self, MotionError> {
        let arm = start.translation() - DVec3::from_array(point.into());
        Self::with_arm(start, velocity, turn, arm)
    }

    /// A motion with a turn, given by the vector from a point of the axis to the body's origin at
    /// time 0 ([`Motion::arm`]).
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn with_arm(
        start: Pose,
        velocity: impl Into<[f64; 3]>,
        turn: impl Into<[f64; 3]>,
        arm: impl Into<[f64; 3]>,
    ) -> Result<Self, MotionError> {
        let [velocity, turn, arm] =
            [velocity.into(), turn.into(), arm.into()].map(DVec3::from_array);
        Self::checked(start, velocity, turn, arm)
    }

    /// The screw motion from one pose to another: a turn of at most half a circle about an axis,
    /// and a translation along it.
    ///
    /// It ends in `end` up to rounding, and up to the deviation of the matrices from rotations.
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn screw(start: Pose, end: Pose) -> Result<Self, MotionError> {
        let way = end.translation() - start.translation();
        let turn = turn_between(start.rotation(), end.rotation());
        let angle = turn.length();
        if angle < LEAST_SCREW {
            return Self::checked(start, way, turn, DVec3::ZERO);
        }
        let axis = turn / angle;
        let along = axis * way.dot(axis);
        let across = way - along;
        let arm = (across + axis.cross(across) * (libm::cos(angle / 2.0) / libm::sin(angle / 2.0)))
            * -0.5;
        Self::checked(start, along, turn, arm)
    }

    /// The motion of a part that is fixed to the body at the pose `part_in_body`. It has the
    /// velocity and the axis of the body.
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn of_part(&self, part_in_body: &Pose) -> Result<Self, MotionError> {
        let arm = self.arm + self.start.rotate(part_in_body.translation());
        Self::checked(
            self.start.compose_unchecked(part_in_body),
            self.velocity,
            self.turn,
            arm,
        )
    }

    /// The rest of the motion after a time from 0 to 1, as a motion from time 0 to 1. Its poses are
    /// those of this motion up to rounding.
    ///
    /// # Errors
    /// [`MotionError`], if the body has moved too far away.
    pub fn rest(&self, time: f64) -> Result<Self, MotionError> {
        let time = if time > 0.0 { time.min(1.0) } else { 0.0 };
        let (start, left) = (self.pose(time), 1.0 - time);
        let on_axis = self.start.translation() - self.arm + self.velocity * time;
        let arm = start.translation() - on_axis;
        Self::checked(start, self.velocity * left, self.turn * left, arm)
    }

    fn checked(start: Pose, velocity: DVec3, turn: DVec3, arm: DVec3) -> Result<Self, MotionError> {
        if !(velocity.is_finite() && turn.is_finite() && arm.is_finite()) {
            return Err(MotionError::NotFinite);
        }
        let reach = velocity
            .abs()
            .max(arm.abs())
            .max(start.translation().abs())
            .max_element();
        if reach > SCENE_REACH || turn.length() > LARGEST_TURN {
            return Err(MotionError::TooLarge);
        }
        Ok(Self {
            start,
            velocity,
            turn,
            arm,
        })
    }

    /// The pose of the body at a time from 0 to 1. Times outside are clamped; NaN counts as 0.
    #[must_use]
    pub fn pose(&self, time: f64) -> Pose {
        let time = if time > 0.0 { time.min(1.0) } else { 0.0 };
        if time == 0.0 {
            return self.start;
        }
        let way = self.velocity * time;
        if self.turn == DVec3::ZERO {
            return Pose::unchecked(*self.start.rotation(), self.start.translation() + way);
        }
        let angle = self.turn.length();
        let axis = self.turn / angle;
        // `k` is `1 - cos`, computed without cancellation: a long arm would magnify the error of a
        // small angle.
        let (sine, half) = (libm::sin(angle * time), libm::sin(angle * time / 2.0));
        let (DVec3 { y, z, .. }, k) = (axis, 2.0 * half * half);
        // The matrix of the turn minus the identity (Rodrigues): `sine` times the axis's
        // cross-product matrix, plus `k` times its square.
        let (u, v, w) = (axis * sine, axis * k, axis * axis * k);
        let turned = DMat3::from_cols(
            DVec3::new(-(w.y + w.z), v.x * y + u.z, v.x * z - u.y),
            DVec3::new(v.x * y - u.z, -(w.z + w.x), v.y * z + u.x),
            DVec3::new(v.x * z + u.y, v.y * z - u.x, -(w.x + w.y)),
        );
        let [x, y, z] = axes(self.start.rotation());
        let rotation = DMat3::from_cols(x + turned * x, y + turned * y, z + turned * z);
        Pose::unchecked(
            rotation,
            self.start.translation() + (way + turned * self.arm),
        )
    }

    /// The pose at time 0.
    #[must_use]
    pub fn start(&self) -> Pose {
        self.start
    }

    /// The velocity of the axis: length per unit of time.
    #[must_use]
    pub fn velocity(&self) -> DVec3 {
        self.velocity
    }

    /// The turn: the axis times the angle in radians.
    #[must_use]
    pub fn turn(&self) -> DVec3 {
        self.turn
    }

    /// The vector from a point of the axis to the origin of the body at time 0.
    #[must_use]
    pub fn arm(&self) -> DVec3 {
        self.arm
    }

    /// The largest entry of `|RᵀR − I|` for the rotation matrix `R` at the start (no unit). Up to
    /// rounding, it holds for the matrix at every time.
    #[inline]
    pub fn deviation(&self) -> f64 {
        rotation_deviation(self.start.rotation())
    }
}

impl TryFrom<(Pose, [DVec3; 3])> for Motion {
    type Error = MotionError;

    /// [`Motion::with_arm`].
    fn try_from((start, [velocity, turn, arm]): (Pose, [DVec3; 3])) -> Result<Self, MotionError> {
        Self::checked(start, velocity, turn, arm)
    }
}

impl From<Motion> for (Pose, [DVec3; 3]) {
    fn from(motion: Motion) -> Self {
        (motion.start, [motion.velocity, motion.turn, motion.arm])
    }
}

/// The turn from one rotation to another, by at most half a circle.
fn turn_between(from: &DMat3, to: &DMat3) -> DVec3 {
    let q = DQuat::from_mat3(&(*to * from.transpose())).normalize();
    let q = if q.w < 0.0 { -q } else { q };
    let (sine, axis) = (q.xyz().length(), q.xyz());
    if sine == 0.0 {
        DVec3::ZERO
    } else {
        axis * (2.0 * libm::atan2(sine, q.w) / sine)
    }
}
