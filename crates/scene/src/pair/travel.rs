//! The displacements of bodies, from which pairs proven separated are known to be still separated:
//! [`super::apart`].

use crate::spot::Spot;
use punctual::Tree;
use punctual::engine::displacement;
use punctual_geom::tolerance::UNDERFLOW;
use punctual_geom::{Pose, largest};

impl Spot {
    /// Records a change other than by a move in a frame: the earlier positions of the body's points
    /// are no longer known.
    pub fn remake(&mut self, frame: u64) {
        (self.gone, self.remade) = (0.0, frame as u32);
    }

    /// Adds a move of a mesh. Returns an upper bound of its displacement.
    pub fn go(&mut self, mesh: &Tree, from: &Pose, to: &Pose) -> f64 {
        let step = displacement(mesh, from, to) + slack(mesh, to);
        // The factor rounds up, because no sum is subnormal.
        self.gone = (self.gone + step) * (1.0 + f64::EPSILON);
        step
    }

    /// True if the body has only been moved since frame `since`. `frame` is the current frame.
    pub fn has_only_moved(&self, since: u64, frame: u64) -> bool {
        u64::from((frame as u32).wrapping_sub(self.remade)) >= frame - since
    }
}

/// Rounding of positions relative to another body, in the magnitudes of coordinates and
/// translations: `docs/numerics.md`.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Bound on the rounding of the positions of a mesh at a pose, relative to another body.
pub(crate) fn slack(mesh: &Tree, pose: &Pose) -> f64 {
    let bounds = mesh.mesh().aabb();
    let magnitude: f64 = [bounds.min, bounds.max, pose.translation()]
        .map(|v| largest(v.abs()))
        .iter()
        .sum();
    ROUNDING * magnitude + UNDERFLOW
}
