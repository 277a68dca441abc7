//! Bodies with a given motion until the next frame.

use crate::Scene;
use crate::checks;
use crate::error::SceneError;
use crate::id::BodyId;
use crate::room::reserve;
use alloc::boxed::Box;
use punctual_geom::Motion;

impl Scene {
    /// Moves a body to the start of a motion, which ends at the next frame, time 1; in the
    /// coordinates of the scene. [`Report::passages`](crate::Report::passages) has the time of
    /// impact of each of its pairs.
    ///
    /// The broad phase compares boxes around the whole motion, with true bounds of arcs. If one
    /// body of a pair has a motion, the question of the pair is its time of impact, margins
    /// included ([`punctual::Query::impact`]), and its verdict is that of time 0. Of equally
    /// important pairs, those that met in their last motion go first, the earliest contact before
    /// all. The motion stays until [`Scene::set_pose`], or another motion. A pair whose distance is
    /// [measured](Scene::measure), by itself or for groups, has no time of impact and no passage.
    ///
    /// ```
    /// use punctual::{Budget, Motion, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
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
    /// If the body is not in the scene, or its pose would be invalid at the begin or the end of the
    /// motion. The body then stays where it was.
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
