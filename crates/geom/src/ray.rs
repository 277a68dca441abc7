//! Rays and segments.

use super::Pose;
use super::tolerance::COORDINATE_LIMIT;
use core::fmt;
use glam::DVec3;

/// A half-line from an origin in a direction, or a segment between two points.
///
/// The points of a half-line are `origin + t direction` with `t >= 0`. The points of a segment are
/// `origin + t (end - origin)` with `0 <= t <= 1`. Triangles that have such a point are found
/// exactly: the decision is that of real arithmetic on the given numbers. The direction may have
/// any length; `t` counts in that length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    origin: DVec3,
    /// The direction of a half-line, or the end of a segment.
    target: DVec3,
    is_segment: bool,
    t_min: f64,
    t_max: f64,
}

/// Reasons why a [`Ray`] is refused. Numbers are counted from 0: three of the origin, then three of
/// the direction or the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RayError {
    /// A number is NaN or infinite.
    NotFinite {
        /// Index of the number, 0 to 5.
        number: usize,
    },
    /// A number exceeds 2^1000.
    TooLarge {
        /// Index of the number, 0 to 5.
        number: usize,
    },
    /// The direction is zero, or the ends of the segment are the same point.
    NoDirection,
}

impl fmt::Display for RayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |number: usize| {
            let part = if number < 3 {
                "origin"
            } else {
                "direction or end"
            };
            (["x", "y", "z"][number % 3], part)
        };
        match *self {
            Self::NotFinite { number } => {
                let (axis, part) = name(number);
                write!(f, "{axis} of the ray's {part} is not finite")
            }
            Self::TooLarge { number } => {
                let (axis, part) = name(number);
                write!(f, "{axis} of the ray's {part} exceeds 2^1000")
            }
            Self::NoDirection => f.write_str(
                "the ray's direction is zero, or both ends of the segment are one point",
            ),
        }
    }
}

impl core::error::Error for RayError {}

impl Ray {
    /// The half-line from `origin` in `direction`.
    ///
    /// # Errors
    /// [`RayError`].
    #[inline]
    pub fn new(
        origin: impl Into<[f64; 3]>,
        direction: impl Into<[f64; 3]>,
    ) -> Result<Self, RayError> {
        Self::checked(origin.into(), direction.into(), false)
    }

    /// The segment between two points, both included; `t` runs from 0 to 1.
    ///
    /// # Errors
    /// [`RayError`].
    pub fn segment(from: impl Into<[f64; 3]>, to: impl Into<[f64; 3]>) -> Result<Self, RayError> {
        Self::checked(from.into(), to.into(), true)
    }

    #[inline]
    fn checked(origin: [f64; 3], target: [f64; 3], is_segment: bool) -> Result<Self, RayError> {
        let [origin, target] = [origin, target].map(DVec3::from_array);
        // A comparison with NaN is false.
        let is_good = |v: DVec3| v.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all();
        if !(is_good(origin) && is_good(target)) {
            return Err(Self::fault(origin, target));
        }
        let ray = Self {
            origin,
            target,
            is_segment,
            t_min: 0.0,
            t_max: f64::INFINITY,
        };
        let [base, target] = ray.exact_direction();
        if base == target {
            Err(RayError::NoDirection)
        } else {
            Ok(ray)
        }
    }

    #[cold]
    fn fault(origin: DVec3, target: DVec3) -> RayError {
        let numbers = origin.to_array().into_iter().chain(target.to_array());
        for (number, x) in numbers.enumerate() {
            if !x.is_finite() {
                return RayError::NotFinite { number };
            }
            if x.abs() > COORDINATE_LIMIT {
                return RayError::TooLarge { number };
            }
        }
        RayError::NoDirection
    }

    /// Discards hits whose reported `t` is below `t_min` or above `t_max`. A NaN sets no limit. To
    /// end exactly at a point, use a segment.
    #[must_use]
    pub fn within(mut self, t_min: f64, t_max: f64) -> Self {
        (self.t_min, self.t_max) = (t_min.max(0.0), t_max.min(f64::INFINITY));
        self
    }

    /// The start of the ray.
    #[inline]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The direction of a half-line. For a segment, the end minus the origin, rounded.
    #[inline]
    pub fn direction(&self) -> DVec3 {
        if self.is_segment {
            self.target - self.origin
        } else {
            self.target
        }
    }

    /// True if this is a segment.
    #[inline]
    pub fn is_segment(&self) -> bool {
        self.is_segment
    }

    /// The limits set by [`Ray::within`].
    #[inline]
    pub fn limits(&self) -> [f64; 2] {
        [self.t_min, self.t_max]
    }

    /// `origin + t direction`, rounded.
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction() * t
    }

    /// The ray in other coordinates. `pose` maps the origin and the direction, or both ends, and
    /// the results are rounded. Limits stay. To cast a ray of the scene at the tree of a body,
    /// transform it by the inverse of the body's pose.
    ///
    /// ```
    /// use punctual::{Pose, Ray, glam::DMat3};
    /// let ray = Ray::new([1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
    /// let moved = ray.transformed(&Pose::new(DMat3::IDENTITY, [0.0, 0.0, 3.0])?)?;
    /// assert_eq!((moved.origin().z, moved.direction().to_array()), (3.0, [0.0, 2.0, 0.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`RayError`] if a number becomes too large, or if the direction is zero after rounding.
    pub fn transformed(&self, pose: &Pose) -> Result<Self, RayError> {
        let target = if self.is_segment {
            pose.transform_point(self.target)
        } else {
            pose.rotate(self.target)
        };
        let ray = Self::checked(
            pose.transform_point(self.origin).into(),
            target.into(),
            self.is_segment,
        )?;
        Ok(Self {
            t_min: self.t_min,
            t_max: self.t_max,
            ..ray
        })
    }

    /// Two points whose exact difference is the direction.
    #[inline]
    pub fn exact_direction(&self) -> [DVec3; 2] {
        [
            if self.is_segment {
                self.origin
            } else {
                DVec3::ZERO
            },
            self.target,
        ]
    }
}
