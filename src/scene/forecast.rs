//! What a pair is expected to cost, and to tell.

use super::chain::WORK_PER_PAIR;
use super::pairs::Track;
use crate::query::{MAX_STEP_WORK, Verdict};
use crate::tree::Tree;

/// Expectations of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forecast {
    /// Work that it takes to run it to its end: as likely more as less.
    pub median: u64,
    /// More than this in one case of ten.
    pub high: u64,
    /// Probability that it intersects if its remembered witnesses do not decide it.
    chance: f32,
}

impl Forecast {
    /// From what is remembered, or else from the size of the trees. `age`: frames since it was decided.
    pub fn new(track: &Track, a: &Tree, b: &Tree, age: u64) -> Self {
        let (median, high) = expected_cost(track, a, b);
        let chance = match track.verdict {
            Verdict::Intersecting { .. } => 0.7,
            Verdict::Separated => NEW_CONTACTS * age as f32,
            Verdict::Undecided => 0.3,
        };
        Self { median: median + WORK_PER_PAIR, high: high + WORK_PER_PAIR, chance }
    }

    /// Expected information on the verdict, in bits, per unit of work.
    pub fn gain(&self) -> f32 {
        let p = self.chance.clamp(1e-4, 0.5);
        let information = -(p * libm::log2f(p) + (1.0 - p) * libm::log2f(1.0 - p));
        information / self.median as f32
    }
}

/// Share of the pairs with overlapping boxes that begin to intersect in a frame.
const NEW_CONTACTS: f32 = 0.02;

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
