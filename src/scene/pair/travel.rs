//! How far bodies have gone, so that pairs that were proven to be apart are known to be still: [`super::apart`].

use crate::math::tolerance::UNDERFLOW;
use crate::math::{Pose, largest};
use crate::query::displacement;
use crate::tree::Tree;

/// How far a body has gone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travel {
    /// A bound on the way of every point of its mesh, of all moves since `remade` together, with what rounding may add.
    pub gone: f64,
    /// The part of its last frame.
    pub step: f32,
    /// The last frame, its low bits, in which it was changed other than by a move.
    pub remade: u32,
}

impl Travel {
    pub const NONE: Self = Self { gone: 0.0, step: 0.0, remade: 0 };

    /// Of a body that is changed in a frame other than by a move: nothing is known of where its points were.
    pub fn remake(&mut self, frame: u64) {
        (self.gone, self.remade) = (0.0, frame as u32);
    }

    /// Adds a move of a mesh, the first of its frame or another one.
    pub fn go(&mut self, mesh: &Tree, from: &Pose, to: &Pose, is_first: bool) {
        let step = displacement(mesh, from, to) + slack(mesh, to);
        // The factor is a rounding up: no sum is subnormal.
        self.gone = (self.gone + step) * (1.0 + f64::EPSILON);
        self.step = step as f32 + if is_first { 0.0 } else { self.step };
    }

    /// Whether it has only been moved since frame `since`, now being `frame`.
    pub fn is_of(&self, since: u64, frame: u64) -> bool {
        u64::from((frame as u32).wrapping_sub(self.remade)) >= frame - since
    }
}

/// What rounding may add to places relative to another body, in the magnitudes of coordinates and translations:
/// `docs/numerics.md`.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// What rounding may add to the places of a mesh at a pose, relative to another body.
pub(crate) fn slack(mesh: &Tree, pose: &Pose) -> f64 {
    let bounds = mesh.mesh().aabb();
    let magnitude: f64 = [bounds.min, bounds.max, pose.translation()].map(|v| largest(v.abs())).iter().sum();
    ROUNDING * magnitude + UNDERFLOW
}
