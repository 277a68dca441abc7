//! Proven bounds on two bodies, besides whether they meet.

use super::state::NO_TRIANGLES;
use punctual::impact::TimeOfImpact;

/// The bounds that a call has proven, besides whether the bodies meet.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Proof {
    Distance(Bounds),
    Impact(Times),
}

impl Proof {
    /// The lower bound, the upper bound, and the triangles that prove the latter.
    pub fn parts(&self) -> (f64, f64, Option<[u32; 2]>) {
        match self {
            Self::Distance(bounds) => (bounds.low, bounds.high, bounds.triangles),
            Self::Impact(times) => (times.low, times.high, times.triangles()),
        }
    }
}

/// Proven bounds of a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub low: f64,
    pub high: f64,
    /// The triangles that are `high` apart.
    pub triangles: Option<[u32; 2]>,
    /// Sum of the displacements of both bodies at the proof.
    pub gone: f64,
    /// A finished run resolves distances up to this; 0 if no run finished.
    pub below: f64,
}

impl Bounds {
    pub const NOTHING: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        triangles: None,
        gone: 0.0,
        below: 0.0,
    };

    /// Combines bounds for one pose.
    pub fn and(self, other: Self) -> Self {
        let nearer = if other.high < self.high { other } else { self };
        Self {
            low: self.low.max(other.low),
            gone: other.gone,
            below: other.below,
            ..nearer
        }
    }
}

/// The known bounds of a distance in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub bounds: Bounds,
    /// True if a query has proven them for the current poses.
    pub is_of_query: bool,
}

/// Proven bounds of a time of impact. Few bytes, because every pair has room for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Times {
    pub low: f64,
    /// Infinite if no contact is known.
    pub high: f64,
    /// The triangles that meet at `high`, or [`NO_TRIANGLES`].
    triangles: [u32; 2],
    /// The frame of the proof, low bits.
    since: u32,
    /// True if a run finished.
    pub is_final: bool,
}

impl Times {
    pub const NOTHING: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        triangles: NO_TRIANGLES,
        since: 0,
        is_final: false,
    };

    /// The bodies do not meet during their motions.
    pub const FREE: Self = Self {
        low: 1.0,
        ..Self::NOTHING
    };

    pub fn new(found: &TimeOfImpact, is_final: bool) -> Self {
        Self {
            low: found.lower,
            high: found.upper.unwrap_or(f64::INFINITY),
            triangles: found.triangles.unwrap_or(NO_TRIANGLES),
            is_final,
            ..Self::NOTHING
        }
    }

    pub fn triangles(&self) -> Option<[u32; 2]> {
        Some(self.triangles).filter(|&triangles| triangles != NO_TRIANGLES)
    }

    /// True if they hold in `frame`, for bodies that last changed in `changed`.
    pub fn hold(&self, changed: u64, frame: u64) -> bool {
        let age = (frame as u32).wrapping_sub(self.since);
        frame
            .checked_sub(changed)
            .is_some_and(|rest| u64::from(age) <= rest)
    }

    /// Adds what was found in `frame`, for bodies that last changed in `changed`.
    pub fn and(self, found: Self, changed: u64, frame: u64) -> Self {
        let before = if self.hold(changed, frame) {
            self
        } else {
            Self::NOTHING
        };
        let sooner = if found.high < before.high {
            found
        } else {
            before
        };
        Self {
            low: before.low.max(found.low),
            since: frame as u32,
            is_final: before.is_final | found.is_final,
            ..sooner
        }
    }
}
