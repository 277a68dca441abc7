//! Bounds on what is unknown about two bodies.

use super::error::SceneError;
use super::id::BodyId;
use super::{BodyKind, Scene};
use punctual::{Mode, Verdict};
use punctual_geom::Aabb;

/// Bounds on what is unknown about a pair: [`crate::Scene::certificate`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairCertificate {
    /// Upper bound of the number of triangle pairs that intersect.
    pub upper_bound: u64,
    /// Each missing intersection lies in a box no longer than this, in the length unit of the
    /// scene.
    pub largest_extent: f64,
}

impl Scene {
    /// True if the last frame compared two bodies or their boxes.
    pub(super) fn was_compared(&self, a: BodyId, b: BodyId) -> Result<bool, SceneError> {
        let pair = [self.bodies.get(a)?, self.bodies.get(b)?];
        let moving = pair
            .iter()
            .any(|placed| placed.body.kind == BodyKind::Moving);
        let may_meet = self.bodies.may_meet([a.index, b.index]);
        let known = self.partners_known(a)? && self.partners_known(b)? && self.report.unlisted == 0;
        Ok(moving && may_meet && (known || self.report.pair(a, b).is_some()))
    }

    /// Bounds what is unknown about two bodies at their current poses: what the last frame left
    /// open. Everything is unknown if the bodies may not meet, if one of them changed since the
    /// last frame, or if no frame has run. Takes time linear in the open pairs, so it is not part
    /// of the report.
    ///
    /// # Errors
    /// If one of the bodies is not in the scene, or both are the same.
    pub fn certificate(&self, x: BodyId, y: BodyId) -> Result<PairCertificate, SceneError> {
        let key = self.bodies.key(x, y)?;
        let [a, b] = [x.min(y), x.max(y)];
        let pair = [self.bodies.get(a)?, self.bodies.get(b)?];
        let trees = pair.map(|placed| &*placed.body.tree);
        let of_boxes = |[x, y]: [Aabb; 2]| PairCertificate {
            upper_bound: trees.iter().map(|tree| tree.mesh().len() as u64).product(),
            largest_extent: x.intersection(&y).extents().max_element(),
        };
        if !self.was_compared(a, b)? || self.changed(key) > self.report.frame {
            return Ok(of_boxes(
                pair.map(|placed| placed.body.tree.aabb_at(&placed.body.pose)),
            ));
        }
        let found = |upper_bound| PairCertificate {
            upper_bound,
            largest_extent: 0.0,
        };
        let Some(report) = self.report.pair(a, b) else {
            return Ok(found(0));
        };
        let counts_all = self.mode == Mode::All && !self.bodies.is_special(key);
        if report.complete && (counts_all || report.verdict == Verdict::Separated) {
            return Ok(found(report.found));
        }
        let b_in_a = pair[0].relative(pair[1]);
        let held = self.schedule.certificate(key, trees, b_in_a, self.mode);
        Ok(held.unwrap_or_else(|| of_boxes([a, b].map(|id| *self.bodies.bounds(id.index)))))
    }
}
