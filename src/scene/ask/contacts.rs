//! Where bodies touch: which pairs are asked, and what is known of them.

use crate::query::Verdict;
use crate::scene::Scene;
use crate::scene::error::SceneError;
use crate::scene::id::{BodyId, bodies_of};
use glam::DVec3;

/// A place where two bodies touch, in the coordinates of the scene, rounded: one of the few that
/// stand for a patch of contacts ([`crate::Patches`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ContactPoint {
    /// The patch it belongs to. Stays the same from frame to frame while the patch has a triangle
    /// in common with what it was when it was found last; no other patch of the pair gets it as
    /// long as the boxes of the bodies overlap.
    pub patch: u64,
    /// Triangle of the body of the lower index, and of the other one: ids of their meshes.
    pub triangles: [u32; 2],
    /// The closest points of these triangles. Of triangles that meet both are the middle of the
    /// segment in which they do.
    pub points: [DVec3; 2],
    /// Unit vector: moved along it, the body of the lower index parts from the other.
    /// [`crate::Contact::normal`].
    pub normal: DVec3,
    /// How far apart the triangles are, without margins; 0 only if they meet.
    /// [`crate::Contact::distance`].
    pub distance: f64,
}

/// Where two bodies touch: [`Scene::contact_points`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactPoints<'s> {
    /// The points of the nearest patch first, its nearest point first; then those of the next. At
    /// most four a patch, and 16.
    pub points: &'s [ContactPoint],
    /// Every contact within the margins that no point stands for is at least so far away, up to
    /// some roundings; infinite if there is none, and 0 if nothing is known.
    pub low: f64,
    /// Frames since this was found. 0: it holds for the bodies where they were in the last frame.
    /// As many as there were if nothing is known.
    pub age: u64,
}

impl ContactPoints<'_> {
    /// Whether the points stand for all contacts.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.low == f64::INFINITY
    }
}

impl Scene {
    /// Finds where bodies touch from the next frame on, of all pairs that meet:
    /// [`Scene::contact_points`].
    ///
    /// It is a question of its own, asked of a pair once it is known to meet, and it shares the
    /// budget of the frame with all others ([`Scene::detect`]). Its contacts are all pairs of
    /// triangles within the margins of both bodies, or that meet if these are 0
    /// ([`crate::Query::contacts`]), up to 256 of a pair; they hang together in patches, of which
    /// the nearest are told.
    ///
    /// Takes about 12 kB more for each pair that meets, and 5 MB.
    ///
    /// ```
    /// use punctual::glam::{DMat3, Vec3};
    /// use punctual::{Body, Budget, Pose, Scene, Tree, shapes};
    /// use std::sync::Arc;
    ///
    /// let crate_ = Arc::new(Tree::new(shapes::cuboid(Vec3::ONE, 4)));
    /// let mut scene = Scene::new();
    /// scene.find_contacts();
    /// let floor = scene.insert(Body::fixed(Arc::clone(&crate_), Pose::IDENTITY))?;
    /// let place = Pose::new(DMat3::IDENTITY, [0.3, 0.2, 2.005])?;
    /// let id = scene.insert(Body::moving(crate_, place).margin(0.01))?;
    /// scene.detect(Budget::unlimited());
    /// let found = scene.contact_points(floor, id)?;
    /// assert!(found.is_complete() && found.age == 0 && found.points.len() == 4);
    /// assert!(found.points.iter().all(|point| point.normal.z < -0.99 && point.patch == found.points[0].patch));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_contacts(&mut self) {
        self.bodies_mut().contact_requests.all = true;
        self.make_room_for_contacts();
    }

    /// The same of two bodies, whenever they meet.
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn find_contacts_of(&mut self, x: BodyId, y: BodyId) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        self.bodies_mut().contact_requests.chosen.insert(key);
        self.make_room_for_contacts();
        Ok(())
    }

    /// Does not ask for the contacts of two bodies any more, but as one of all pairs.
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn stop_finding_contacts_of(&mut self, x: BodyId, y: BodyId) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        if self.bodies.contact_requests.chosen.contains(&key) {
            self.bodies_mut().contact_requests.chosen.remove(&key);
        }
        Ok(())
    }

    fn make_room_for_contacts(&mut self) {
        self.schedule.make_patches();
        self.pairs.reserve_touches();
    }

    /// Where two bodies touch, as far as the frames up to the last have found, if that is asked for
    /// ([`Scene::find_contacts`]); no points if they were found apart.
    ///
    /// A question that was cut short tells the nearest part of what it has found, and goes on in
    /// the next frame if the bodies rest. What was found stays, with its age, until there is
    /// something newer. A search for the pair, and otherwise free: nothing is copied within the
    /// time of a frame.
    ///
    /// # Errors
    /// If one of the bodies is not in the scene, or both are the same.
    pub fn contact_points(&self, x: BodyId, y: BodyId) -> Result<ContactPoints<'_>, SceneError> {
        let (key, frame) = (self.bodies.key(x, y)?, self.report.frame);
        let is_apart = match self.report.pair(x, y) {
            Some(pair) => pair.verdict == Verdict::Separated,
            None => self.is_looked_at(x, y)? && frame > 0,
        };
        if is_apart {
            return Ok(ContactPoints {
                points: &[],
                low: f64::INFINITY,
                age: 0,
            });
        }
        let is_of_another = self.broad.is_of_another(&self.bodies, bodies_of(key));
        let touch = self
            .pairs
            .touch(key)
            .filter(|touch| touch.since > 0 && !is_of_another);
        let Some(touch) = touch else {
            return Ok(ContactPoints {
                points: &[],
                low: 0.0,
                age: frame,
            });
        };
        let age = if touch.since >= self.bodies.last_change(key) {
            0
        } else {
            frame - touch.since
        };
        Ok(ContactPoints {
            points: &touch.points,
            low: touch.low,
            age,
        })
    }
}
