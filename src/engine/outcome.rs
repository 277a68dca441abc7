//! The answer of a query.

use crate::model::cost::{Counts, WORK_PER_EXACT_TEST, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST};
use core::fmt;
use core::time::Duration;
use punctual_geom::named;

/// Tells whether the surfaces intersect. Never a bare `bool`: a budget can end before the answer is
/// known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub enum Verdict {
    /// Proven: these triangles, of A and of B (ids of the input meshes), share a point.
    Intersecting {
        /// Triangle of A, triangle of B.
        witness: [u32; 2],
    },
    /// Proven: these triangles are no farther apart than the sum of the margins and radii of both
    /// bodies, up to 4e-14 times the diagonal of the box around both triangles. Occurs only for
    /// trees of which one has a [radius](crate::Tree::with_radius), and for bodies of a
    /// `punctual_scene::Scene` of which one has a margin. Says nothing on whether some triangles
    /// share a point.
    Within {
        /// Triangle of A, triangle of B.
        witness: [u32; 2],
        /// Proven upper bound of their distance in A's frame, in the length unit of the meshes,
        /// neither margins nor radii subtracted. Above 0.
        distance: f64,
    },
    /// Proven: the surfaces do not meet, but this body, or a component of it, is inside the other.
    /// Occurs only if both trees are solids, and the outer one is closed. Of bodies of a
    /// `punctual_scene::Scene` with a margin, a measured distance or a motion, it says only that a
    /// vertex of this body is inside the other: their surfaces may meet, too.
    Contained {
        /// The body that is inside the other.
        inner: Operand,
    },
    /// Proven: no triangle of A shares a point with one of B. For bodies with margins or radii,
    /// also none is within them. For solids, also no component of one is inside the other, if the
    /// other is closed.
    Separated,
    /// The budget ended before the answer was known. [`crate::Query::certificate`] bounds what is
    /// left open.
    Undecided,
}

impl Verdict {
    /// The verdict for triangles within the margins: they intersect if their distance is 0.
    #[inline]
    pub fn of_witness(witness: [u32; 2], distance: f64) -> Self {
        if distance == 0.0 {
            Self::Intersecting { witness }
        } else {
            Self::Within { witness, distance }
        }
    }

    /// Name in files, without the witness: `intersecting`, `within`, `contained`, `separated`
    /// or `undecided`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Intersecting { .. } => "intersecting",
            Self::Within { .. } => "within",
            Self::Contained { .. } => "contained",
            Self::Separated => "separated",
            Self::Undecided => "undecided",
        }
    }

    /// True if it is proven that the surfaces, thickened by their margins, meet: `Intersecting` or
    /// `Within`, or `Contained`.
    pub const fn meets(self) -> bool {
        matches!(
            self,
            Self::Intersecting { .. } | Self::Within { .. } | Self::Contained { .. }
        )
    }

    /// Upper bound of the distance of the witness, margins not subtracted; 0 if it intersects.
    pub const fn witness_distance(self) -> Option<f64> {
        match self {
            Self::Intersecting { .. } => Some(0.0),
            Self::Within { distance, .. } => Some(distance),
            Self::Contained { .. } | Self::Separated | Self::Undecided => None,
        }
    }

    /// The triangles that prove that the surfaces meet, thickened by their margins.
    pub const fn witness(self) -> Option<[u32; 2]> {
        match self {
            Self::Intersecting { witness } | Self::Within { witness, .. } => Some(witness),
            Self::Contained { .. } | Self::Separated | Self::Undecided => None,
        }
    }
}

/// Includes the witness: `intersecting(12, 907)`, `within(12, 907, 0.25)`.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Intersecting { witness: [a, b] } => write!(f, "intersecting({a}, {b})"),
            Self::Within {
                witness: [a, b],
                distance,
            } => write!(f, "within({a}, {b}, {distance})"),
            Self::Contained { inner } => write!(f, "contained({inner})"),
            Self::Separated | Self::Undecided => f.pad(self.name()),
        }
    }
}

/// The reason why a query returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StopReason {
    /// Nothing is left to visit: the answer is complete.
    Finished,
    /// The first intersection was found, and [`crate::Mode::Any`] asks for no more.
    FirstHit,
    /// The time budget ended.
    Deadline,
    /// The work budget was spent.
    WorkLimit,
    /// The buffer of pairs, contacts or hits was full. Drain it and resume.
    PairsFull,
    /// The clock reported that the call is cancelled
    /// ([`Clock::is_cancelled`](crate::Clock::is_cancelled)).
    Cancelled,
    /// The processor is set to take denormal numbers for zero (FTZ, DAZ), and the input is so small
    /// that this could make an answer false. That is so if coordinates, the pose, or products of
    /// coordinates and entries of the pose are below 2^-960, if coordinates of a mesh of f32 are
    /// denormal as f32, or if the mesh is smaller than 2^-900. Clear the setting and resume.
    FlushedToZero,
}

named!(StopReason {
    Finished => "finished",
    FirstHit => "first-hit",
    Deadline => "deadline",
    WorkLimit => "work-limit",
    PairsFull => "pairs-full",
    Cancelled => "cancelled",
    FlushedToZero => "flushed-to-zero",
});

impl StopReason {
    /// True if the run is over, so that there is nothing to resume.
    #[inline]
    pub fn is_final(self) -> bool {
        matches!(self, Self::Finished | Self::FirstHit)
    }
}

/// The work of a query, including resumed calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Stats {
    /// Intersecting pairs, contacts or hits found, including drained ones. For the nearest hit of a
    /// ray, the hits compared.
    pub found: u64,
    /// Box overlap tests, the paper's `N_v`.
    pub bv_tests: u64,
    /// Triangle pairs tested, `N_p`.
    pub primitive_tests: u64,
    /// Triangle pairs that needed exact arithmetic, a part of `primitive_tests`.
    pub exact_tests: u64,
    /// Units of work, see [`crate::Budget::work`].
    pub work: u64,
    /// Maximum number of node pairs in the queue at one time.
    pub queue_peak: u32,
    /// Total time of all calls. Measured only under a time budget, because reading the clock costs
    /// as much as a small query.
    pub elapsed: Option<Duration>,
}

impl Stats {
    /// The counts that the time depends on. Opened node pairs count as box updates; so does all
    /// other work, such as tests on edge axes and steps along curves.
    pub fn counts(&self) -> Counts {
        let others = self.bv_tests
            + self.primitive_tests * WORK_PER_TRIANGLE_TEST
            + self.exact_tests * WORK_PER_EXACT_TEST;
        Counts {
            bv_tests: self.bv_tests as f64,
            triangle_tests: self.primitive_tests as f64,
            box_updates: (self.work.saturating_sub(others) / WORK_PER_EXPANSION) as f64,
        }
    }
}

/// The answer of a query. Plain data; pairs, contacts and hits stay in the workspace. What a
/// stopped query has left to do: [`Query::remaining`](crate::Query::remaining).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
#[non_exhaustive]
pub struct Answer<T> {
    /// What is proven so far. Complete if the query is finished.
    pub value: T,
    /// The reason why the query returned.
    pub stop: StopReason,
    /// The work of the query.
    pub stats: Stats,
}

impl<T> Answer<T> {
    /// The answer of a caller of several queries.
    pub fn of(value: T, stop: StopReason, stats: Stats) -> Self {
        Self { value, stop, stats }
    }
}

/// One of the two bodies of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Operand {
    /// The first tree.
    A,
    /// The second tree.
    B,
}

named!(Operand { A => "a", B => "b" });
