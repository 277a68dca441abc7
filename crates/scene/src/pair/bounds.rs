//! Proven bounds on two bodies, besides whether they meet.

/// Proven bounds of a distance, or of a time of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub low: f64,
    pub high: f64,
    /// The triangles that are `high` apart, or that meet at time `high`.
    pub triangles: Option<[u32; 2]>,
    /// True for times of a motion, false for lengths.
    pub are_times: bool,
    /// Only for a distance. `gone`: sum of the displacements of both bodies at the proof. `below`:
    /// a finished run resolves distances up to this; 0 if no run finished.
    pub gone: f64,
    pub below: f64,
}

impl Bounds {
    pub const NOTHING: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        triangles: None,
        are_times: false,
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
