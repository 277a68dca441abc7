//! Contact points of bodies: the requests, and the answers.

use crate::Scene;
use crate::error::SceneError;
use crate::id::{BodyId, bodies_of};
use glam::DVec3;
use punctual::Verdict;

/// A contact point of two bodies, in the coordinates of the scene, rounded: one of the few
/// representative points of a patch of contacts ([`punctual::contacts::Patches`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ContactPoint {
    /// The id of its patch. Constant from frame to frame while the patch shares a triangle with its
    /// state when it was last found. No other patch of the pair gets the id as long as the boxes of
    /// the bodies overlap.
    pub patch: u64,
    /// Triangle of the body with the lower index, and of the other one: ids of their meshes.
    pub triangles: [u32; 2],
    /// The closest points of these triangles. For triangles that intersect, both are the middle of
    /// the segment in which they do.
    pub points: [DVec3; 2],
    /// Unit vector: moving the body with the lower index along it separates it from the other.
    /// [`punctual::contacts::Contact::normal`].
    pub normal: DVec3,
    /// Distance of the triangles, without margins; 0 only if they intersect.
    /// [`punctual::contacts::Contact::distance`].
    pub distance: f64,
}

/// The contact points of two bodies: [`Scene::contact_points`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactPoints<'s> {
    /// The points of the nearest patch first, its nearest point first, then those of the next
    /// patch. At most four per patch, and 16 in total.
    pub points: &'s [ContactPoint],
    /// Every contact within the margins that no point represents is at least this far away, up to
    /// some roundings. Infinite if there is none, and 0 if nothing is known.
    pub low: f64,
    /// Frames since this was found: 0 if it holds for the poses of the last frame. If nothing is
    /// known, the number of frames so far.
    pub age: u64,
}

impl ContactPoints<'_> {
    /// True if the points represent all contacts.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.low == f64::INFINITY
    }
}

impl Scene {
    /// Finds contact points, from the next frame on, for all pairs that meet:
    /// [`Scene::contact_points`].
    ///
    /// This is a separate question, asked once a pair is known to meet, and it shares the budget of
    /// the frame with all others ([`Scene::detect`]). Its contacts are all pairs of triangles
    /// within the sum of the margins of both bodies, or that intersect if that is 0
    /// ([`punctual::Query::contacts`]), up to 256 per pair. They form patches, of which the nearest
    /// are reported.
    ///
    /// Takes about 12 kB more for each pair that meets, plus 5 MB.
    ///
    /// ```
    /// use punctual::glam::{DMat3, Vec3};
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
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

    /// Finds contact points of two bodies, whenever they meet: [`Scene::find_contacts`].
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn find_contacts_of(&mut self, x: BodyId, y: BodyId) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        self.bodies_mut().contact_requests.chosen.insert(key);
        self.make_room_for_contacts();
        Ok(())
    }

    /// Stops finding contact points of two bodies, unless [`Scene::find_contacts`] includes them.
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

    /// The contact points of two bodies, as far as the frames so far have found them, if requested
    /// ([`Scene::find_contacts`]). No points if the bodies were found separated.
    ///
    /// A question that was cut short reports the nearest part of its contacts, and continues in the
    /// next frame if the bodies rest. Its points stay, with their age, until there are newer ones.
    /// Costs one search for the pair; nothing is copied within the time of a frame.
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
