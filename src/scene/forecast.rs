//! What a pair is expected to cost, and to tell.

use super::chain::WORK_PER_PAIR;
use super::pairs::Track;
use crate::query::{MAX_STEP_WORK, Verdict};
use crate::tree::Tree;

/// Expectations of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forecast {
    /// Work that it takes to run it to its end: as likely more as less.
    pub median: u32,
    /// More than this in one case of ten.
    pub high: u32,
    /// Expected information on the verdict, in bits, once the remembered witnesses have been tested.
    pub information: f32,
}

impl Forecast {
    pub const NONE: Self = Self { median: 0, high: 0, information: 0.0 };

    /// From what is remembered, or else from the size of the trees. `age`: frames since it was decided.
    pub fn new(track: &Track, a: &Tree, b: &Tree, age: u64) -> Self {
        let (median, high) = expected_cost(track, a, b);
        let information = match track.verdict {
            Verdict::Intersecting { .. } | Verdict::Undecided => 1.0,
            Verdict::Separated => NEW_CONTACT[(age as usize).min(NEW_CONTACT.len() - 1)],
        };
        let capped = |work: u64| (work + WORK_PER_PAIR).min(u64::from(u32::MAX)) as u32;
        Self { median: capped(median), high: capped(high), information }
    }
}

/// Information on a pair that was apart so many frames ago: the entropy of a chance of 2 % a frame.
const NEW_CONTACT: [f32; 16] =
    [0.0, 0.14, 0.24, 0.33, 0.40, 0.47, 0.53, 0.58, 0.63, 0.68, 0.72, 0.76, 0.79, 0.83, 0.85, 0.88];

/// Work of a query, median and 90 % quantile.
fn expected_cost(track: &Track, a: &Tree, b: &Tree) -> (u64, u64) {
    let (search, spread) = if track.search > 0 {
        (track.search, track.search / 2)
    } else {
        // Near contact, work grows about like the fourth root of the product of the triangle counts.
        let triangles = (a.mesh().len() as f32) * (b.mesh().len() as f32);
        let guess = 150 * libm::sqrtf(libm::sqrtf(triangles)) as u64;
        (guess, 2 * guess)
    };
    let left = search.saturating_sub(track.pending[0]).max(MAX_STEP_WORK);
    match track.verdict {
        // A remembered witness mostly spares the search.
        Verdict::Intersecting { .. } => (track.cost.min(left), left + spread),
        _ => (left, left + spread),
    }
}
