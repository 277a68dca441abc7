//! How far bodies have gone, so that pairs that were proven to be apart are known to be still: [`super::apart`].

use super::body::Bodies;
use super::error::SceneError;
use super::id::BodyId;
use crate::math::{Pose, largest};
use crate::query::way;
use crate::tree::Tree;

/// How far a body has gone.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    /// A bound on the way of every point of its mesh, of all moves together, with what rounding may add.
    pub gone: f64,
    /// The part of its last frame.
    pub step: f32,
    /// The last frame, its low bits, in which it was changed but by a move.
    pub remade: u32,
}

impl Way {
    /// Whether it has only been moved since frame `since`, now being `frame`.
    pub fn is_of(&self, since: u64, frame: u64) -> bool {
        u64::from((frame as u32).wrapping_sub(self.remade)) >= frame - since
    }
}

/// What rounding may add to places relative to another body, in the magnitudes of coordinates and translations, and what
/// underflow may take away: `docs/numerics.md`.
const ROUNDING: f64 = 256.0 * f64::EPSILON;
const UNDERFLOW: f64 = 1024.0 * f64::MIN_POSITIVE;

/// What rounding may add to the places of a mesh at a pose, relative to another body.
pub(super) fn slack(mesh: &Tree, pose: &Pose) -> f64 {
    let bounds = mesh.mesh().aabb();
    let magnitude: f64 = [bounds.min, bounds.max, pose.translation()].map(|v| largest(v.abs())).iter().sum();
    ROUNDING * magnitude + UNDERFLOW
}

impl Bodies {
    /// Moves a body to a pose, with its inverse, where it rests.
    pub fn go(&mut self, id: BodyId, frame: u64, pose: Pose, inverse: Pose) -> Result<(), SceneError> {
        let placed = self.get(id)?;
        let moves = placed.motion.is_none();
        let step = way(&placed.body.tree, &placed.body.pose, &pose) + slack(&placed.body.tree, &pose);
        let (before, is_first) = (self.ways[id.index()], self.facts(id.index).changed < frame);
        self.change(id, frame, |placed| (placed.body.pose, placed.inverse, placed.motion) = (pose, inverse, None))?;
        if moves {
            let gone = (before.gone + step).next_up();
            let of_frame = if is_first { 0.0 } else { before.step };
            self.ways[id.index()] = Way { gone, step: of_frame + step as f32, ..before };
        }
        Ok(())
    }
}
