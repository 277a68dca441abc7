//! How far bodies have gone, so that pairs that were proven to be apart are known to be still:
//! [`super::apart`].

use crate::math::tolerance::UNDERFLOW;
use crate::math::{Pose, largest};
use crate::query::displacement;
use crate::scene::spot::Spot;
use crate::tree::Tree;

impl Spot {
    /// Takes note of a change other than by a move, in a frame: nothing is known of where the
    /// points of the body were.
    pub fn remake(&mut self, frame: u64) {
        (self.gone, self.remade) = (0.0, frame as u32);
    }

    /// Adds a move of a mesh; how far it went, at most.
    pub fn go(&mut self, mesh: &Tree, from: &Pose, to: &Pose) -> f64 {
        let step = displacement(mesh, from, to) + slack(mesh, to);
        // The factor is a rounding up: no sum is subnormal.
        self.gone = (self.gone + step) * (1.0 + f64::EPSILON);
        step
    }

    /// Whether the body has only been moved since frame `since`, now being `frame`.
    pub fn has_only_moved(&self, since: u64, frame: u64) -> bool {
        u64::from((frame as u32).wrapping_sub(self.remade)) >= frame - since
    }
}

/// What rounding may add to places relative to another body, in the magnitudes of coordinates and
/// translations: `docs/numerics.md`.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// What rounding may add to the places of a mesh at a pose, relative to another body.
pub(crate) fn slack(mesh: &Tree, pose: &Pose) -> f64 {
    let bounds = mesh.mesh().aabb();
    let magnitude: f64 = [bounds.min, bounds.max, pose.translation()]
        .map(|v| largest(v.abs()))
        .iter()
        .sum();
    ROUNDING * magnitude + UNDERFLOW
}
