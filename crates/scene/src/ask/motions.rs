//! Bodies with a given motion until the next frame.

use crate::Scene;
use crate::checks;
use crate::error::SceneError;
use crate::id::{BodyId, pair_key};
use crate::pair::bounds::Times;
use crate::report::{PairPassage, PairReport};
use alloc::boxed::Box;
use punctual_geom::Motion;

impl Scene {
    /// Moves a body to the start of a motion in the coordinates of the scene. The motion ends at
    /// time 1, which is the next frame. [`Scene::passages`] has the time of impact of each pair of
    /// the body.
    ///
    /// The broad phase compares boxes around the whole motion, with true bounds of arcs. If one
    /// body of a pair has a motion, the question of the pair is its time of impact, margins
    /// included ([`punctual::Query::impact`]), and its verdict is that of time 0. Of equally
    /// important pairs, those that met in their last motion go first, the earliest
    /// contact first. The motion stays until [`Scene::set_pose`], or another motion.
    ///
    /// A pair whose distance is [measured](Scene::measure), by itself or for groups, has two
    /// questions: its distance at time 0, which also decides its verdict, then its time of impact.
    /// Each has its turn, and a run of either that is cut short continues in the next frame while
    /// neither body changes. If the boxes around the motions are separated, the pair needs no query
    /// to be free to the end.
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
    /// assert_eq!(scene.detect(Budget::unlimited()).intersecting, 0);
    /// let passage = scene.passages().next().unwrap();
    /// assert!(0.489 < passage.free_until && passage.touching_at.unwrap() < 0.491);
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
        record!(self, SetMotion(id, motion));
        Ok(())
    }

    /// The times of impact of the pairs of [`Report::pairs`](crate::Report::pairs), in the same
    /// order: those of which one or both bodies have a [motion](Scene::set_motion). If the report
    /// [is whole](crate::Report::is_whole), two bodies that may meet and form none of its pairs do
    /// not meet during their motions. Each time costs one search for its pair.
    pub fn passages(&self) -> impl Iterator<Item = PairPassage> {
        let pairs: &[PairReport] = match self.bodies.has_special {
            true => &self.report.pairs,
            false => &[],
        };
        let moving = pairs.iter().filter_map(|&PairReport { a, b, .. }| {
            let key = pair_key(a.index, b.index);
            self.bodies.is_moving(key).then_some((a, b, key))
        });
        moving.map(|(a, b, key)| {
            let (.., times) = self.proven(key);
            let times = match times.hold(self.bodies.last_change(key), self.report.frame) {
                true => times,
                false if self.bodies.boxes_apart(key)[0] > 0.0 => Times::FREE,
                false => Times::NOTHING,
            };
            PairPassage {
                a,
                b,
                free_until: times.low,
                touching_at: (times.high < f64::INFINITY).then_some(times.high),
                triangles: times.triangles(),
            }
        })
    }
}
