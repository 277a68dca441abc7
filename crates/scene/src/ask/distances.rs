//! Margins of bodies, and distance requests for pairs and for groups.

use crate::Scene;
use crate::body::Bodies;
use crate::checks;
use crate::cost::WORK_PER_PAIR_APART;
use crate::error::SceneError;
use crate::facts::Change;
use crate::id::{BodyId, MeasureId, PairKey, bodies_of, pair_key};
use crate::pair::bounds::{Bounds, Times};
use crate::report::PairDistance;
use alloc::vec::Vec;
use punctual::engine::Deadline;

impl Scene {
    /// Thickens a body by a margin, in the length unit of the scene:
    /// [`Body::margin`](crate::Body::margin). Two bodies meet when they come within the sum of
    /// their margins. Then the witness is the closest pair of triangles found. The verdict is
    /// [`Verdict::Within`](punctual::Verdict::Within) with its distance, or
    /// [`Verdict::Intersecting`](punctual::Verdict::Intersecting) if these triangles intersect. The
    /// search ends with the first pair within the margins, so an intersection of other triangles is
    /// found only by chance. Only one contact is counted, also in [`punctual::Mode::All`].
    ///
    /// ```
    /// use punctual::glam::DMat3;
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual::impact::Impact;
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
    /// let mut scene = Scene::new();
    /// let id = scene.insert(Body::fixed(Arc::clone(&ball), Pose::IDENTITY))?;
    /// scene.insert(Body::moving(ball, Pose::new(DMat3::IDENTITY, [2.5, 0.0, 0.0])?).margin(0.25))?;
    /// assert_eq!(scene.detect(Budget::unlimited()).within, 0);
    /// scene.set_margin(id, 0.3)?;
    /// let report = scene.detect(Budget::unlimited());
    /// assert_eq!((report.intersecting, report.within), (0, 1));
    /// assert!(report.pairs[0].verdict.witness_distance().is_some_and(|distance| 0.5 <= distance && distance <= 0.55));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the body is not in the scene, or the margin is not from 0 to 2^1000.
    pub fn set_margin(&mut self, id: BodyId, margin: f64) -> Result<(), SceneError> {
        let margin = checks::length(id, margin)?;
        self.change(id, |placed| placed.body.margin = margin)?;
        record!(self, SetMargin(id, margin));
        Ok(())
    }

    /// Measures the distance of two bodies in every frame from now on, wherever they are, if they
    /// may meet by their filters and are not parts of one compound: [`Scene::distances`].
    /// `tolerance` is a length, as for [`punctual::Query::absolute_tolerance`]. The margins of the
    /// bodies count.
    ///
    /// If a body [moves](Scene::set_motion), `low` and `high` are those at the begin of the motion,
    /// and the pair also has a time of impact ([`Scene::passages`]).
    ///
    /// The pair is in [`crate::Report::pairs`] as well, and shares the budget like any other, by
    /// importance and in its turn. A run that is cut short continues in the next frame while both
    /// bodies rest. The bounds of the last run stay, with their age. The verdict is decided as soon
    /// as one of the bounds decides it. The results of other pairs of the two bodies are computed
    /// anew once.
    ///
    /// ```
    /// use punctual::glam::DMat3;
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
    /// let mut scene = Scene::new();
    /// let mut insert = |x| scene.insert(Body::moving(Arc::clone(&ball), Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()));
    /// let (hand, part) = (insert(0.0)?, insert(9.0)?);
    /// scene.measure(hand, part, 1e-3)?;
    /// scene.detect(Budget::unlimited());
    /// let found = scene.distance(hand, part)?;
    /// assert!(found.age == 0 && found.low <= 7.01 && 7.0 <= found.high && found.high - found.low < 1.1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a body is not in the scene, both are the same, or the tolerance is not from 0 to 2^1000.
    pub fn measure(&mut self, x: BodyId, y: BodyId, tolerance: f64) -> Result<(), SceneError> {
        let tolerance = checks::length(x, tolerance)?;
        let key = self.bodies.key(x, y)?;
        let (frame, bodies) = (self.next_frame(), self.bodies_mut());
        bodies.distance_requests.pairs.insert(key, tolerance);
        bodies.renew(x.index, true, frame)?;
        bodies.renew(y.index, true, frame)?;
        self.pairs.insert(&[key]);
        self.pairs.grow_known(&mut self.broad, false);
        record!(self, Measure(x, y, tolerance));
        Ok(())
    }

    /// The bounds of the distance of two bodies that the frames so far have proven, if it is
    /// [measured](Scene::measure). Costs one search for the pair.
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn distance(&self, x: BodyId, y: BodyId) -> Result<PairDistance, SceneError> {
        Ok(self.distance_of(self.bodies.key(x, y)?))
    }

    /// [`Scene::distance`] of all measured pairs, ascending by index, whether or not a pair had a
    /// turn.
    pub fn distances(&self) -> impl Iterator<Item = PairDistance> {
        let of_pairs = self.bodies.distance_requests.pairs.keys();
        of_pairs.map(|&key| self.distance_of(key))
    }

    fn distance_of(&self, key: PairKey) -> PairDistance {
        let [a, b] = bodies_of(key).map(|body| self.bodies.id(body));
        let (bounds, since, _) = self.proven(key);
        let age = if since >= self.changed(key) {
            0
        } else {
            self.report.frame - since
        };
        PairDistance {
            a,
            b,
            low: bounds.low,
            high: bounds.high,
            triangles: bounds.triangles,
            age,
        }
    }

    /// The bounds that the frames so far have proven for a pair, of its distance, with the frame of
    /// the proof, and of its time of impact.
    pub(super) fn proven(&self, key: PairKey) -> (Bounds, u64, Times) {
        let is_of_another = self.broad.is_of_another(&self.bodies, bodies_of(key));
        let proven = self.pairs.proven(key).filter(|_| !is_of_another);
        proven.unwrap_or((Bounds::NOTHING, 0, Times::NOTHING))
    }

    /// Ends the measurement of the distance of two bodies. A no-op if it is not measured.
    ///
    /// # Errors
    /// If a body is not in the scene, or both are the same.
    pub fn stop_measuring(&mut self, x: BodyId, y: BodyId) -> Result<(), SceneError> {
        let key = self.bodies.key(x, y)?;
        if !self.bodies.distance_requests.pairs.contains_key(&key) {
            return Ok(());
        }
        let (frame, bodies) = (self.next_frame(), self.bodies_mut());
        bodies.distance_requests.pairs.remove(&key);
        bodies.stop_measuring(x.index, frame)?;
        bodies.stop_measuring(y.index, frame)?;
        record!(self, StopMeasuring(x, y));
        Ok(())
    }

    /// Measures the least distance between two groups of bodies in every frame from now on, for
    /// example a robot and its surroundings. [`crate::Report::group_distances`] has bounds that
    /// hold in each frame, whatever the budget reached.
    ///
    /// The groups may share bodies, or be equal, for example the links of a robot for its
    /// self-distance. A body has no distance from itself; exclude joined links by their filters, or
    /// make them parts of one compound. `tolerance` is a length: pairs that are farther apart than
    /// the closest pair minus the tolerance are not queried. The margins of bodies count. Pairs
    /// that may not meet by their filters do not count.
    ///
    /// This takes fewer queries than all pairs. The last upper bound, corrected for the
    /// displacement of both bodies, is an upper bound at once. Pairs need no query if their boxes,
    /// or their own lower bounds minus the displacement of their bodies, are farther apart than
    /// that. The others are in [`crate::Report::pairs`], and are measured like those of
    /// [`Scene::measure`] within the one budget. A frame takes time linear in the number of pairs,
    /// 40 bytes each. The results of the pairs of these bodies are computed anew once.
    ///
    /// ```
    /// use punctual::glam::DMat3;
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
    /// let mut scene = Scene::new();
    /// let mut insert = |x| scene.insert(Body::moving(Arc::clone(&ball), Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()));
    /// let robot = [insert(0.0)?, insert(1.0)?];
    /// let cell = [insert(-8.0)?, insert(5.0)?, insert(30.0)?];
    /// let id = scene.measure_groups(&robot, &cell, 1e-3)?;
    /// let found = scene.detect(Budget::unlimited()).group_distances[0];
    /// assert!(found.id == id && found.low <= 2.01 && 2.0 <= found.high && found.high - found.low < 1.1e-3);
    /// assert_eq!(found.bodies, Some([robot[1], cell[1]]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a body is not in the scene, both groups consist of one and the same body, or the
    /// tolerance is not from 0 to 2^1000.
    pub fn measure_groups(
        &mut self,
        x: &[BodyId],
        y: &[BodyId],
        tolerance: f64,
    ) -> Result<MeasureId, SceneError> {
        let mut keys = Vec::with_capacity(x.len() * y.len());
        for &id in x.iter().chain(y) {
            self.bodies.get(id)?;
            checks::length(id, tolerance)?;
        }
        for &a in x {
            keys.extend(
                y.iter()
                    .filter(|&&b| b != a)
                    .map(|b| pair_key(a.index, b.index)),
            );
        }
        if let ([a, ..], [_, ..], []) = (x, y, &keys[..]) {
            return Err(SceneError::OneBody { body: *a });
        }
        keys.sort_unstable();
        keys.dedup();
        let (frame, bodies) = (self.next_frame(), self.bodies_mut());
        let id = bodies
            .distance_requests
            .insert_groups(&keys, tolerance, bodies.scene);
        x.iter()
            .chain(y)
            .try_for_each(|body| bodies.renew(body.index, true, frame))?;
        self.pairs.insert(&keys);
        self.pairs.grow_known(&mut self.broad, false);
        self.schedule
            .reserve_groups(self.bodies.distance_requests.groups.len(), &mut self.report);
        record!(self, MeasureGroups(x.into(), y.into(), tolerance));
        Ok(id)
    }

    /// Ends the measurement of the distance of two groups. The results of the pairs of their bodies
    /// are computed anew once.
    ///
    /// # Errors
    /// If this scene does not measure the distance.
    pub fn stop_measuring_groups(&mut self, id: MeasureId) -> Result<(), SceneError> {
        let frame = self.next_frame();
        self.edit(|bodies| {
            let stopped = bodies.distance_requests.remove_groups(id)?;
            stopped
                .into_iter()
                .try_for_each(|body| bodies.stop_measuring(body, frame))
        })?;
        record!(self, StopMeasuringGroups(id));
        Ok(())
    }
}

impl Bodies {
    /// Records whether distances of a body are measured. Earlier results for the body answered
    /// another question and are dropped.
    fn renew(&mut self, body: u32, is_measured: bool, frame: u64) -> Result<(), SceneError> {
        self.facts[body as usize].is_measured = is_measured;
        self.change(self.id(body), frame, |_| ())
    }

    /// Records that a distance of a body is no longer measured. A pair of the body stays known only
    /// if the broad phase finds it.
    fn stop_measuring(&mut self, body: u32, frame: u64) -> Result<(), SceneError> {
        self.renew(body, self.distance_requests.has_body(body), frame)?;
        self.set_pending(body, Change::Place);
        Ok(())
    }

    /// Sets the upper bound of each group for this frame: the last frame's bound, corrected for
    /// displacement. If there is none, it uses boxes: those of the pair that had the nearest ones,
    /// and of as many others as the deadline allows, from where the last frame stopped.
    pub fn begin_groups(&mut self, frame: u64, deadline: &mut Deadline) {
        let count = self.distance_requests.groups.len();
        for number in 0..count {
            let group = &self.distance_requests.groups[number];
            let closest = (group.closest).filter(|&(key, ..)| self.may_meet(bodies_of(key)));
            let of_last =
                closest.map(
                    |(key, bounds, since)| match self.last_change(key) <= since {
                        true => bounds.high,
                        false => self.carried(key, bounds, since, frame).high,
                    },
                );
            let of_last = of_last.filter(|&high| high < f64::INFINITY);
            let of_boxes = group.nearest.map_or(f64::INFINITY, |key| self.span(key));
            let group = &mut self.distance_requests.groups[number];
            group.closest = group.closest.filter(|_| of_last.is_some());
            group.ceiling = of_last.unwrap_or(of_boxes);
        }
        let first = self.distance_requests.next;
        for number in (first..count).chain(0..first.min(count)) {
            if !self.look_at_boxes(number, deadline) {
                self.distance_requests.next = number;
                break;
            }
        }
    }

    /// Looks at the boxes of groups without a closest pair; false if it has not looked at all of
    /// them.
    fn look_at_boxes(&mut self, number: usize, deadline: &mut Deadline) -> bool {
        let group = &self.distance_requests.groups[number];
        if group.closest.is_some() {
            return true;
        }
        let (from, count) = (group.next, group.keys.len());
        let (mut seen, mut nearest, mut ceiling) = (0, group.nearest, group.ceiling);
        while seen < count && deadline.has_room(WORK_PER_PAIR_APART) {
            deadline.spend(WORK_PER_PAIR_APART);
            let key = group.keys[(from + seen) % count];
            seen += 1;
            let span = self.span(key);
            if span < ceiling {
                (nearest, ceiling) = (Some(key), span);
            }
        }
        let group = &mut self.distance_requests.groups[number];
        group.next = (from + seen).checked_rem(count).unwrap_or(0);
        (group.nearest, group.ceiling) = (nearest, ceiling);
        seen == count
    }

    /// Upper bound of the distance of two bodies, from their boxes; infinite if they may not meet.
    fn span(&self, key: PairKey) -> f64 {
        match self.may_meet(bodies_of(key)) {
            true => self.boxes_apart(key)[1],
            false => f64::INFINITY,
        }
    }
}
