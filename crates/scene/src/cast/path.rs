//! Bounds the times at which a moving shape may meet a box, and its distance from a box.

use crate::broad::bounds::{arc_error, thickened};
use crate::pair::near::gap;
use arrayvec::ArrayVec;
use core::f64::consts::PI;
use glam::DVec3;
use punctual::Tree;
use punctual_geom::{Aabb, Motion, length};

/// Maximum number of substeps, and number of substeps for each half turn.
const MOST_SUBSTEPS: usize = 16;
const SUBSTEPS_PER_HALF_TURN: f64 = 8.0;

/// Bound of the rounding of a time, and of a distance relative to it.
const ROUNDING: f64 = 1e-12;

/// The boxes of a shape on its way. In each substep, every point is near the straight line between
/// its positions at both ends.
pub(super) struct Path {
    /// The box at the begin and at the end of each substep, widened by the deviation from the
    /// lines.
    substeps: ArrayVec<[Aabb; 2], MOST_SUBSTEPS>,
}

impl Path {
    pub fn new(tree: &Tree, motion: &Motion, margin: f64) -> Self {
        let angle = motion.turn().length();
        let is_still = angle == 0.0 && motion.velocity() == DVec3::ZERO;
        let substeps =
            libm::ceil(angle / PI * SUBSTEPS_PER_HALF_TURN).clamp(1.0, MOST_SUBSTEPS as f64);
        let margin = margin
            + if is_still {
                0.0
            } else {
                arc_error(tree, motion, angle / substeps)
            };
        let at = |substep: f64| thickened(tree.aabb_at(&motion.pose(substep / substeps)), margin);
        let substeps =
            (0..substeps as u32).map(|substep| [at(substep.into()), at(f64::from(substep) + 1.0)]);
        Self {
            substeps: substeps.collect(),
        }
    }

    /// The box at the begin.
    pub fn start(&self) -> &Aabb {
        &self.substeps[0][0]
    }

    /// A time before which the shape does not meet a box; `None` if it never does.
    pub fn enter(&self, bounds: &Aabb) -> Option<f64> {
        let count = self.substeps.len() as f64;
        let mut substeps = self.substeps.iter().zip(0u32..);
        substeps
            .find_map(|(ends, substep)| Some((f64::from(substep) + enter(ends, bounds)?) / count))
    }

    /// A lower bound of the distance from a box at the begin.
    pub fn apart(&self, bounds: &Aabb) -> f64 {
        length(gap(self.start(), bounds)) * (1.0 - ROUNDING)
    }
}

/// The fraction of a substep before which a box that changes linearly does not meet another.
fn enter([from, to]: &[Aabb; 2], bounds: &Aabb) -> Option<f64> {
    if from.is_empty() || bounds.is_empty() {
        return None;
    }
    let gaps = [from.min - bounds.max, bounds.min - from.max];
    let ends = [to.min - bounds.max, bounds.min - to.max];
    let [enter, leave] = crossing(gaps, [ends[0] - gaps[0], ends[1] - gaps[1]], 1.0)?;
    (enter <= leave + ROUNDING).then(|| (enter - ROUNDING).max(0.0))
}

/// The first and the last time from 0 to `end` at which no gap is positive, each changing by its
/// rate; the first is after the last if there is none. `None` if a gap never closes.
pub(super) fn crossing(gaps: [DVec3; 2], rates: [DVec3; 2], end: f64) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0f64, end);
    for (gap, rate) in gaps.into_iter().zip(rates) {
        for axis in 0..3 {
            match (gap[axis], rate[axis]) {
                (gap, rate) if rate < 0.0 => enter = enter.max(-gap / rate),
                (gap, rate) if rate > 0.0 => leave = leave.min(-gap / rate),
                (gap, _) if gap > 0.0 => return None,
                _ => {}
            }
        }
    }
    Some([enter, leave])
}
