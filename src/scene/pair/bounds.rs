//! What is proven of two bodies besides whether they meet.

/// What is proven of a distance, or of the time of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub low: f64,
    pub high: f64,
    /// The triangles that are `high` apart, or meet then.
    pub triangles: Option<[u32; 2]>,
    /// Whether these are times of a motion, not lengths.
    pub are_times: bool,
    /// Of a distance: how far both bodies had gone then, together, and up to where a run that came
    /// to its end would have told more than that it is more; 0 if none did.
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

    /// Both of one pose.
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

/// What is known of a distance in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub bounds: Bounds,
    /// Whether a query has proven it of the bodies where they are.
    pub is_of_query: bool,
}
