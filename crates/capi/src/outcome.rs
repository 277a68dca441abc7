//! What queries say: outcome, counters and certificate.

use crate::verbs::types;
use crate::workspace::punctual_triangle_pair;
use core::time::Duration;
use punctual::intersection::Operand;
use punctual::prediction::Quantiles;
use punctual::{Certificate, Stats, StopReason, Verdict};

types! {
    /// Whether the surfaces meet. Never a mere yes or no: a budget can end before the answer is
    /// known.
    enum punctual_verdict {
        /// The budget ended first. It says nothing about contact: do not treat it as separated.
        Undecided = 0,
        /// Proven: the witness triangles share a point.
        Intersecting = 1,
        /// Proven: no triangle of A shares a point with one of B; of bodies with margins, nor comes
        /// within them.
        Separated = 2,
        /// Proven: the witness triangles are no farther apart than the margins of both bodies
        /// together. Said only of bodies of a scene of which one has a margin. Whether some
        /// triangles share a point is not said.
        Within = 3,
        /// Proven: the surfaces do not meet, but one body is inside the other: A if the first
        /// number of the witness is 0, B if it is 1. Said only of two solids of which the outer one
        /// is closed. Of bodies of a scene with a margin, a measured distance or a motion, it says
        /// only that a vertex of this body is inside the other: their surfaces may meet, too.
        Contained = 4,
    }

    /// Why a query returned.
    enum punctual_stop_reason {
        /// Nothing is left to visit: the answer is complete.
        Finished = 0,
        /// The first intersection was found, which is all that MODE_ANY asks for.
        FirstHit = 1,
        /// The time was up.
        Deadline = 2,
        /// The work was spent.
        WorkLimit = 3,
        /// The pair buffer was full. Drain it and resume.
        PairsFull = 4,
        /// The processor is set to take denormal numbers for zero (FTZ, DAZ), and coordinates or
        /// the pose are so small, below about 2^-960, that this could make an answer false. Clear
        /// the setting and resume.
        FlushedToZero = 5,
        /// The call was cancelled. No clock of this interface does that.
        Cancelled = 6,
    }

    /// What a query has done, resumed calls included.
    plain punctual_stats from (stats: Stats) {
        /// Box overlap tests.
        bv_tests: u64 = stats.bv_tests,
        /// Triangle pairs tested.
        primitive_tests: u64 = stats.primitive_tests,
        /// Those among them that needed exact arithmetic.
        exact_tests: u64 = stats.exact_tests,
        /// Units of work; one is about 0.3 ns.
        work: u64 = stats.work,
        /// Time of all calls together in nanoseconds; -1 if it was not measured, which it is only
        /// under a time budget.
        elapsed: i64 = nanoseconds(stats.elapsed),
        /// Most node pairs that waited in the queue at once.
        queue_peak: u32 = stats.queue_peak,
    }

    /// What a query left open; of a distance query, what may be closer than its `high`.
    told punctual_certificate(upper_bound) from (open: Certificate<'_>) {
        /// Open pairs, of nodes or triangles; 0 means that nothing was missed.
        open_pairs: usize = open.open_pairs(),
        /// No more triangle pairs than this intersect (or are closer), those found included.
        upper_bound: u64 = open.upper_bound(),
        /// Every missed intersection lies in a box with no edge longer than this, in the length
        /// unit of the meshes.
        largest_extent: f64 = open.largest_extent(),
    }

    /// Bounds below which a number stays with the given probability.
    plain punctual_quantiles {
        /// 10 %.
        p10: f64,
        /// The median.
        p50: f64,
        /// 90 %.
        p90: f64,
    }
}

impl From<Quantiles> for punctual_quantiles {
    fn from(Quantiles { p10, p50, p90 }: Quantiles) -> Self {
        Self { p10, p50, p90 }
    }
}

/// In nanoseconds; -1 for none.
pub(crate) fn nanoseconds(time: Option<Duration>) -> i64 {
    time.map_or(-1, |time| {
        i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
    })
}

/// Verdict and witness.
pub(crate) fn verdict(verdict: Verdict) -> (punctual_verdict, punctual_triangle_pair) {
    match verdict {
        Verdict::Undecided => (punctual_verdict::Undecided, [0; 2].into()),
        Verdict::Intersecting { witness } => (punctual_verdict::Intersecting, witness.into()),
        Verdict::Within { witness, .. } => (punctual_verdict::Within, witness.into()),
        Verdict::Contained { inner } => (
            punctual_verdict::Contained,
            [u32::from(inner == Operand::B), 0].into(),
        ),
        Verdict::Separated => (punctual_verdict::Separated, [0; 2].into()),
    }
}

impl From<StopReason> for punctual_stop_reason {
    fn from(stop: StopReason) -> Self {
        match stop {
            StopReason::Finished => Self::Finished,
            StopReason::FirstHit => Self::FirstHit,
            StopReason::Deadline => Self::Deadline,
            StopReason::WorkLimit => Self::WorkLimit,
            StopReason::PairsFull => Self::PairsFull,
            StopReason::FlushedToZero => Self::FlushedToZero,
            StopReason::Cancelled => Self::Cancelled,
            // A reason that is added without a number here may be taken for one that is not final
            // either.
            _ => Self::WorkLimit,
        }
    }
}
