//! Bodies that are given where they go until the next frame.

use crate::math::Motion;
use crate::scene::Scene;
use crate::scene::checks;
use crate::scene::error::SceneError;
use crate::scene::id::BodyId;
use crate::scene::room::reserve;
use alloc::boxed::Box;

impl Scene {
    /// Moves a body to where a motion begins, and says where it goes until the next frame, time 1;
    /// in the coordinates of the scene. [`Report::passages`](crate::Report::passages) tells until
    /// when each of its pairs is free.
    ///
    /// The boxes of its way are compared, true bounds of arcs. A pair of which one body has a
    /// motion is asked until when it is free, margins included ([`crate::Query::impact`]), and its
    /// verdict is that of time 0. Of equally important pairs those that met in their last motion go
    /// first, the soonest of them before all. The motion stays until [`Scene::set_pose`], or
    /// another one. A pair whose distance is [asked for](Scene::measure), by itself or for groups,
    /// is not asked about motions and has no passage.
    ///
    /// ```
    /// use punctual::{Body, Budget, Motion, Pose, Scene, Tree, shapes};
    /// use std::sync::Arc;
    ///
    /// let mut scene = Scene::new();
    /// let plate = Arc::new(Tree::new(shapes::cuboid([0.01, 3.0, 3.0], 4)));
    /// scene.insert(Body::fixed(plate, Pose::IDENTITY))?;
    /// let bullet = scene.insert(Body::moving(Arc::new(Tree::new(shapes::icosphere(2))), Pose::IDENTITY))?;
    /// let start = Pose::from_quat([0.0, 0.0, 0.0, 1.0], [-50.0, 0.0, 0.0])?;
    /// scene.set_motion(bullet, Motion::straight(start, [100.0, 0.0, 0.0])?)?;
    /// let report = scene.detect(Budget::unlimited());
    /// let passage = report.passages[0];
    /// assert!(report.intersecting == 0 && 0.489 < passage.free_until && passage.touching_at.unwrap() < 0.491);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the body is not in the scene, or cannot be where the motion begins or ends; it then stays
    /// where it was.
    pub fn set_motion(&mut self, id: BodyId, motion: Motion) -> Result<(), SceneError> {
        self.bodies.get(id)?;
        checks::motion(id, &motion)?;
        self.change(id, |placed| {
            placed.put(&motion.start());
            match &mut placed.motion {
                Some(there) => **there = motion,
                none => *none = Some(Box::new(motion)),
            }
        })?;
        reserve(&mut self.report.passages, self.pairs.room());
        Ok(())
    }
}
