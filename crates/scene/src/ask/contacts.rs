//! Contacts of bodies, as a solver needs them: the requests, and the answers.

use crate::Scene;
use crate::body::margins;
use crate::checks;
use crate::error::SceneError;
use crate::filter::Filter;
use crate::id::{BodyId, PairKey, bodies_of};
use crate::pair::batch;
use glam::DVec3;
use punctual::Verdict;
use punctual::intersection::Operand;
use punctual_geom::Pose;

/// A contact point of two bodies: one of at most four of a
/// [manifold](punctual::contacts::Manifold), fixed to both bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ContactPoint {
    /// The id of its manifold. Constant from frame to frame while the manifold keeps a point.
    pub manifold: u64,
    /// Constant from frame to frame while the point stays near its place on one of the bodies. No
    /// other point of the pair gets the id as long as the bodies are not found separated.
    pub id: u64,
    /// The point on the body with the lower index, in the coordinates of its mesh; and the point on
    /// the other one, in those of its own.
    pub points: [DVec3; 2],
    /// Unit vector in the coordinates of the first body, from the second to the first: moving the
    /// first along it separates the bodies here.
    pub normal: DVec3,
    /// Signed distance along the normal at the poses at which it was found, in the length unit of
    /// the scene, without margins; negative where the bodies are sunk into each other.
    pub distance: f64,
}

/// A contact point at poses of both bodies, in the coordinates of the scene: [`ContactPoint::at`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlacedContact {
    /// The point on the first body, and on the second.
    pub points: [DVec3; 2],
    /// Unit vector from the second body to the first.
    pub normal: DVec3,
    /// Signed distance of the points along the normal, without margins.
    pub distance: f64,
}

impl ContactPoint {
    /// The contact at these poses of both bodies: its points and its normal move with them. If the
    /// bodies have moved relative to each other since it was found, the distance is an estimate
    /// that is good for small motions.
    pub fn at(&self, [a, b]: [&Pose; 2]) -> PlacedContact {
        let points = [
            a.transform_point(self.points[0]),
            b.transform_point(self.points[1]),
        ];
        let normal = *a.rotation() * self.normal;
        PlacedContact {
            points,
            normal,
            distance: (points[0] - points[1]).dot(normal),
        }
    }
}

/// The known contacts of two bodies: [`Scene::contacts`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Contacts<'s> {
    /// At most 16 points, those of the deepest manifold first.
    pub points: &'s [ContactPoint],
    /// True if the points stood for all contacts within the margins when they were found.
    pub is_whole: bool,
    /// The solid that was inside the other one, or had a vertex in it, while their surfaces did not
    /// meet. No point stands for that.
    pub within: Option<BodyId>,
    /// Where no point stands for a contact, the surfaces, taken as those of solids, were at least
    /// this far apart when the points were found, margins not subtracted. It is the sum of the
    /// margins if the points stand for all contacts, more if the bodies are proven apart by more
    /// ([`Scene::set_look_ahead`]), and 0 if one is `within` the other or nothing is known. The
    /// bodies meet nowhere else before they have moved by `low - drift` relative to each other. If
    /// that is negative, they have sunk into each other by no more elsewhere.
    pub low: f64,
    /// Upper bound of how far the surfaces have moved relative to each other since the points were
    /// found, in the length unit of the scene. 0 if they were found at the present poses, infinite
    /// if nothing is known.
    pub drift: f64,
    /// Frames since the points were found. If nothing is known, the number of frames so far.
    pub age: u64,
}

impl Contacts<'_> {
    /// True if the points stand for all contacts at the present poses.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.is_whole && self.drift == 0.0
    }
}

impl Scene {
    /// Finds contacts for a solver, from the next frame on, of all pairs whose bodies are within
    /// the sum of their margins: [`Scene::contacts`]. This *skin* is what makes contacts useful
    /// before bodies sink into each other; .5 to 2 % of their size is usual.
    ///
    /// If nothing else is asked of a pair in [`Mode::Any`](punctual::Mode::Any), the contacts are
    /// its only question, and also decide whether it meets. Bodies that were proven apart by more
    /// than they have moved need nothing. Contacts are kept while the bodies have moved relative to
    /// each other by less than a quarter of the skin. They go on being reported, with their
    /// [drift](Contacts::drift), and prove that the bodies still meet. Under a budget, pairs of
    /// which nothing is known go first. Then go those with the largest displacement relative to
    /// their skins per expected cost.
    ///
    /// Takes about 2 kB more for each pair near contact, plus 15 MB and 200 bytes for each triangle
    /// of the largest mesh.
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
    /// let found = scene.contacts(floor, id)?;
    /// assert!(found.is_complete() && found.points.len() == 4);
    /// for point in found.points {
    ///     let now = point.at([&scene.body(floor)?.pose, &scene.body(id)?.pose]);
    ///     assert!(now.normal.z < -0.99 && (now.distance - 0.005).abs() < 1e-6);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_contacts(&mut self) {
        self.find_contacts_between(Filter::default());
    }

    /// Finds contacts, from the next frame on, of all pairs of which one body is in
    /// `filter.groups` and the other in `filter.mask`, by the [`groups`](Filter::groups) of their
    /// own filters. Several calls add up. With [`Filter::default`] it is [`Scene::find_contacts`].
    ///
    /// ```
    /// use punctual::glam::DMat3;
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Filter, Scene};
    /// use std::sync::Arc;
    ///
    /// const SOLID: u32 = 1;
    /// const SCENERY: u32 = 2;
    /// let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    /// let mut scene = Scene::new();
    /// // Solids have contacts with each other. A touch of the scenery is only reported.
    /// scene.find_contacts_between(Filter::new(SOLID, SOLID));
    /// let mut insert = |x, group| {
    ///     let place = Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap();
    ///     scene.insert(Body::moving(Arc::clone(&ball), place).filter(Filter::new(group, u32::MAX)))
    /// };
    /// let [a, b, tree] = [insert(0.0, SOLID)?, insert(1.9, SOLID)?, insert(-1.9, SCENERY)?];
    /// assert_eq!(scene.detect(Budget::unlimited()).intersecting, 2);
    /// assert!(scene.contacts(a, b)?.points.len() > 0);
    /// assert!(scene.contacts(a, tree)?.points.is_empty());
    /// # Ok::<(), punctual_scene::SceneError>(())
    /// ```
    pub fn find_contacts_between(&mut self, filter: Filter) {
        let between = &mut self.bodies_mut().contact_requests.between;
        if !between.contains(&filter) {
            between.push(filter);
        }
        self.make_room_for_contacts();
        record!(self, FindContactsBetween(filter));
    }

    /// Ends [`Scene::find_contacts_between`] of this filter, or, with [`Filter::default`],
    /// [`Scene::find_contacts`]. A no-op if there was no such call. Contacts of pairs that are also
    /// requested otherwise are found as before.
    pub fn stop_finding_contacts_between(&mut self, filter: Filter) {
        let between = &mut self.bodies_mut().contact_requests.between;
        between.retain(|other| *other != filter);
        record!(self, StopFindingContactsBetween(filter));
    }

    /// Finds contacts of two bodies, whenever they are within their margins:
    /// [`Scene::find_contacts`].
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn find_contacts_of(&mut self, x: BodyId, y: BodyId) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        self.bodies_mut().contact_requests.chosen.insert(key);
        self.make_room_for_contacts();
        record!(self, FindContactsOf(x, y));
        Ok(())
    }

    /// Sets the look-ahead, a length; 0 by default. Bodies whose contacts are
    /// [requested](Self::find_contacts), and that have none, are measured up to this distance
    /// beyond their skins. A finished question then proves a [`Contacts::low`] of the skin plus
    /// four fifths of their distance, or of the look-ahead if that is less. Costs another question
    /// for each pair that is found apart, and none while its bodies move by less. Of bodies whose
    /// boxes are apart, `low` is the skin plus the gap of the boxes.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let mut scene = Scene::new();
    /// scene.find_contacts();
    /// scene.set_look_ahead(0.3)?;
    /// let ring = Arc::new(Tree::new(shapes::torus(1.0, 0.2, 24)));
    /// let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    /// let hole = Pose::from_quat([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.9])?;
    /// let [a, b] = [(ring, Pose::IDENTITY), (ball, hole)]
    ///     .map(|(tree, pose)| scene.insert(Body::moving(tree, pose).margin(0.005)).unwrap());
    /// scene.detect(Budget::unlimited());
    /// let found = scene.contacts(a, b)?;
    /// assert!(found.points.is_empty() && found.low > 0.1 && found.drift == 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If it is not from 0 to 2^1000.
    pub fn set_look_ahead(&mut self, length: f64) -> Result<(), SceneError> {
        self.bodies_mut().contact_requests.look_ahead = checks::look_ahead(length)?;
        record!(self, SetLookAhead(length));
        Ok(())
    }

    /// Stops finding contacts of two bodies, unless [`Scene::find_contacts`] or
    /// [`Scene::find_contacts_between`] includes them.
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn stop_finding_contacts_of(&mut self, x: BodyId, y: BodyId) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        if self.bodies.contact_requests.chosen.contains(&key) {
            self.bodies_mut().contact_requests.chosen.remove(&key);
            record!(self, StopFindingContactsOf(x, y));
        }
        Ok(())
    }

    /// Makes room in the workspaces for the contacts of the largest mesh, if contacts are
    /// requested.
    pub(crate) fn make_room_for_contacts(&mut self) {
        if !self.bodies.contact_requests.any() {
            return;
        }
        self.is_same = false;
        let mesh = self.bodies.largest_mesh;
        self.schedule.make_room_for_contacts(mesh);
        batch::make_room_for_contacts(&mut self.scratch, mesh);
        #[cfg(feature = "parallel")]
        if let Some(workers) = &self.workers {
            workers.make_room_for_contacts(mesh);
        }
        self.pairs.reserve_touches();
    }

    /// The answer for two bodies without points. `is_apart`: they are separated now.
    fn without_points(&self, key: PairKey, is_apart: bool) -> Contacts<'_> {
        let (bodies, frame) = (&self.bodies, self.report.frame);
        let skin = bodies.pair(key).map_or(0.0, margins);
        let is_of_another = self.broad.is_of_another(bodies, bodies_of(key));
        let proven = self.pairs.apart(key, bodies, self.next_frame());
        let proven = proven.filter(|&(room, _)| !is_of_another && room > f64::NEG_INFINITY);
        let now = self.apart_now(key);
        let nothing = Contacts {
            points: &[],
            is_whole: false,
            within: None,
            low: 0.0,
            drift: f64::INFINITY,
            age: frame,
        };
        let found = |room: f64, age| Contacts {
            is_whole: true,
            low: skin + room.max(0.0),
            drift: (-room).max(0.0),
            age,
            ..nothing
        };
        match proven {
            _ if is_apart || now > 0.0 => {
                let room = proven.map_or(0.0, |(room, _)| room);
                found(room.max(now), 0)
            }
            Some((room, since)) => found(room, frame - since),
            None => nothing,
        }
    }

    /// Lower bound of the distance of two bodies at their present poses, margins subtracted: from
    /// their boxes, and from the distance that was proven last.
    fn apart_now(&self, key: PairKey) -> f64 {
        let (bounds, since, _) = self.proven(key);
        let low = match since >= self.changed(key) {
            true => bounds.low,
            false => {
                (self.bodies)
                    .carried(key, bounds, since, self.next_frame())
                    .low
            }
        };
        low.max(self.bodies.boxes_apart(key)[0])
    }

    /// The contacts of two bodies, as far as the frames so far have found them, if requested
    /// ([`Scene::find_contacts`]). No points if the bodies were found separated.
    ///
    /// A question that was cut short reports a part of the contacts, and continues in the next
    /// frame if the bodies rest. Points stay until there are newer ones, with a
    /// [drift](Contacts::drift). Costs one search for the pair; nothing is copied within the time
    /// of a frame.
    ///
    /// # Errors
    /// If one of the bodies is not in the scene, or both are the same.
    pub fn contacts(&self, x: BodyId, y: BodyId) -> Result<Contacts<'_>, SceneError> {
        let (key, frame) = (self.bodies.key(x, y)?, self.report.frame);
        let is_apart = match self.report.pair(x, y) {
            // The verdict is that of the frame, and the bodies may have changed since.
            Some(pair) => {
                pair.verdict == Verdict::Separated && self.bodies.last_change(key) <= frame
            }
            None => self.was_compared(x, y)? && frame > 0,
        };
        let within = |inner| {
            let [a, b] = bodies_of(key).map(|body| self.bodies.id(body));
            if inner == Operand::A { a } else { b }
        };
        let is_of_another = self.broad.is_of_another(&self.bodies, bodies_of(key));
        let touch = self
            .pairs
            .touch(key)
            .filter(|touch| touch.since > 0 && !is_apart && !is_of_another);
        let Some(touch) = touch else {
            return Ok(self.without_points(key, is_apart));
        };
        Ok(Contacts {
            points: &touch.points,
            is_whole: touch.is_whole,
            within: touch.within.map(within),
            low: touch.low,
            drift: self.bodies.drift(key, touch, self.next_frame()),
            age: frame - touch.since,
        })
    }
}
