//! Bodies: a shared tree at a pose.

use super::ask::Weights;
use super::ask::contact_requests::ContactRequests;
use super::ask::distance_requests::DistanceRequests;
use super::error::SceneError;
use super::facts::{Change, Facts};
use super::filter::{Filter, Groups};
use super::id::{BodyId, CompoundId, PairKey, SceneNumber, bodies_of, pair_key};
use super::room::reserve;
use super::spot::Spot;
use super::waiting::Waiting;
use crate::cost::{LEAST_DISTANCE_WORK, LEAST_WORK};
use alloc::boxed::Box;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::mem;
use punctual::Tree;
use punctual_geom::{Aabb, Motion, Pose};

/// Determines whether a body is compared with others of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyKind {
    /// Compared with moving and fixed bodies.
    Moving,
    /// Part of the surroundings. Two fixed bodies are not compared, unless their
    /// [distance](crate::Scene::measure) is measured. A fixed body may still be given new poses.
    Fixed,
}

/// A body: a tree, shared with any number of other bodies, at a pose.
///
/// **Kinematic bodies**, such as platforms and doors, move as the program says, and nothing pushes
/// them. They are [fixed](Body::fixed) bodies with a new pose in each frame: they meet the moving
/// ones, and neither each other nor the surroundings. With
/// [`Scene::set_motion`](crate::Scene::set_motion) in place of
/// [`Scene::set_pose`](crate::Scene::set_pose) nothing slips through a fast one. The scene computes
/// no velocities: where they touch, the solver takes that of the body from its poses.
///
/// ```
/// use punctual::glam::{DMat3, Vec3};
/// use punctual::{Budget, Motion, Pose, Tree, shapes};
/// use punctual_scene::{Body, Scene};
/// use std::sync::Arc;
///
/// let at = |x: f64| Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap();
/// let plate = Arc::new(Tree::new(shapes::cuboid(Vec3::new(0.1, 2.0, 2.0), 2)));
/// let ball = Arc::new(Tree::new(shapes::icosphere(2)));
/// let mut scene = Scene::new();
/// let wall = scene.insert(Body::fixed(Arc::clone(&plate), at(0.0)))?;
/// let door = scene.insert(Body::fixed(plate, at(0.0)))?;
/// let id = scene.insert(Body::moving(ball, at(5.0)))?;
///
/// // In steps: it stands in the wall, which it does not meet, then in the ball.
/// scene.detect(Budget::unlimited());
/// assert!(scene.report().pair(wall, door).is_none());
/// scene.set_pose(door, at(4.5))?;
/// assert!(scene.detect(Budget::unlimited()).pair(door, id).unwrap().verdict.meets());
///
/// // Through the ball and beyond within a frame.
/// scene.set_motion(door, Motion::straight(at(0.0), [10.0, 0.0, 0.0])?)?;
/// scene.detect(Budget::unlimited());
/// let passage = scene.passages().find(|passage| passage.b == id).unwrap();
/// assert!(0.38 < passage.free_until && passage.touching_at.unwrap() < 0.41);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Body {
    /// The tree of its mesh.
    pub tree: Arc<Tree>,
    /// Maps the coordinates of the mesh to those of the scene.
    pub pose: Pose,
    /// Moving or fixed.
    pub kind: BodyKind,
    /// Determines which bodies it may meet; by default all.
    pub filter: Filter,
    /// How much its pairs matter if the budget does not reach all; default 0. A pair has the
    /// importance of the more important of its two bodies, and goes before all less important
    /// pairs.
    pub importance: f32,
    /// Thickness added to its surface, in the length unit of the scene, beside the
    /// [radius](punctual::Tree::with_radius) of its tree; default 0. Bodies that meet only by their
    /// margins or radii are [within](punctual::Verdict::Within) them. Rays ignore the margin.
    /// Distances of contacts contain the margins and no radii.
    pub margin: f64,
    /// True for a sensor: what meets or is inside it is reported ([`crate::ContactPhase`]), but its
    /// pairs have no [contacts](crate::Scene::find_contacts), unless those of a pair are
    /// [requested](crate::Scene::find_contacts_of).
    pub is_sensor: bool,
    /// Any value of the user; the scene ignores it.
    pub data: u64,
}

impl Body {
    /// A moving body. `pose` maps the coordinates of the mesh to those of the scene.
    pub fn moving(tree: Arc<Tree>, pose: Pose) -> Self {
        Self {
            tree,
            pose,
            kind: BodyKind::Moving,
            filter: Filter::default(),
            importance: 0.0,
            margin: 0.0,
            is_sensor: false,
            data: 0,
        }
    }

    /// A fixed body, which meets only moving ones.
    pub fn fixed(tree: Arc<Tree>, pose: Pose) -> Self {
        Self {
            kind: BodyKind::Fixed,
            ..Self::moving(tree, pose)
        }
    }

    /// Replaces [`Body::filter`].
    #[must_use]
    pub fn filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Replaces [`Body::importance`].
    #[must_use]
    pub fn importance(self, importance: f32) -> Self {
        Self { importance, ..self }
    }

    /// Replaces [`Body::margin`].
    #[must_use]
    pub fn margin(self, margin: f64) -> Self {
        Self { margin, ..self }
    }

    /// Makes it a sensor: [`Body::is_sensor`]. If its tree and those of other bodies are
    /// [solids](punctual::BuildOptions::solid), bodies inside it meet it too: what crosses it
    /// enters once and leaves once.
    #[must_use]
    pub fn sensor(self) -> Self {
        Self {
            is_sensor: true,
            ..self
        }
    }

    /// Replaces [`Body::data`].
    #[must_use]
    pub fn data(self, data: u64) -> Self {
        Self { data, ..self }
    }
}

/// A body in a scene.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub body: Body,
    /// The inverse of the pose.
    pub inverse: Pose,
    /// The pose in the frame before its last change.
    pub last: Pose,
    /// Its motion until the next frame.
    pub motion: Option<Box<Motion>>,
    /// The number of the compound that it is a part of.
    pub compound: Option<u64>,
    pub group: Option<u32>,
}

impl Placed {
    pub fn new(body: Body, compound: Option<CompoundId>) -> Self {
        let (inverse, last) = (body.pose.inverse_unchecked(), body.pose);
        Self {
            body,
            inverse,
            last,
            motion: None,
            compound: compound.map(CompoundId::to_bits),
            group: None,
        }
    }

    /// The pose of another body in the frame of this one. There always is one:
    /// [`super::checks::pose`].
    pub fn relative(&self, other: &Self) -> Pose {
        self.relative_to(&other.body.pose)
    }

    /// Maps a pose to the frame of this body. Does not check the result.
    pub fn relative_to(&self, pose: &Pose) -> Pose {
        self.inverse.compose_unchecked(pose)
    }

    /// Sets the pose.
    pub fn put(&mut self, pose: &Pose) {
        (self.body.pose, self.inverse) = (*pose, pose.inverse_unchecked());
    }

    /// The motion until the next frame; constant if none was set.
    pub fn motion(&self) -> Motion {
        self.motion
            .as_deref()
            .copied()
            .unwrap_or(Motion::still(self.body.pose))
    }
}

/// Sum of the margins of two bodies.
pub(super) fn margins([a, b]: [&Placed; 2]) -> f64 {
    a.body.margin + b.body.margin
}

/// Sum of the radii of the trees of two bodies.
pub(super) fn radii([a, b]: [&Placed; 2]) -> f64 {
    a.body.tree.radius() + b.body.tree.radius()
}

/// Sum of the margins of two bodies and of the radii of their trees.
pub(super) fn thickness(pair: [&Placed; 2]) -> f64 {
    margins(pair) + radii(pair)
}

/// The ids of a triangle of each of two bodies (tree order). `None` if a body has no such triangle:
/// its tree may have been replaced.
#[inline]
pub(super) fn triangle_ids([a, b]: [&Placed; 2], [x, y]: [u32; 2]) -> Option<[u32; 2]> {
    Some([
        *a.body.tree.ids().get(x as usize)?,
        *b.body.tree.ids().get(y as usize)?,
    ])
}

/// The bodies of a scene, in slots that are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    pub scene: SceneNumber,
    slots: Vec<Option<Placed>>,
    pub facts: Vec<Facts>,
    pub spots: Vec<Spot>,
    free: Vec<u32>,
    /// Slots with a pending change, each once; and the number of those with an outdated box
    /// ([`Facts::is_changed`]).
    pending: Waiting,
    pub changed: usize,
    /// Slots whose swept box is replaced by the body's box in the next frame.
    pub settling: Vec<u32>,
    len: usize,
    /// The frame of the last new slot.
    grown: u64,
    /// The largest numbers of triangles and of vertices of a mesh so far.
    pub largest_mesh: [usize; 2],
    /// The pairs whose distances are measured.
    pub distance_requests: DistanceRequests,
    /// The pairs whose contacts are requested.
    pub contact_requests: ContactRequests,
    pub weights: Weights,
    /// True if any body is, or was, [special](Facts::is_special).
    pub has_special: bool,
    /// True if the importance of any body is, or was, above 0.
    pub has_important: bool,
    /// True if any body is, or was, a sensor.
    has_sensor: bool,
    /// True if any body was removed, so that slots may have another body than before.
    pub has_removed: bool,
    /// True if any body is, or was, filtered, a part of a compound, in a group, or in an ignored
    /// pair.
    has_filtered: bool,
    ignored: BTreeSet<PairKey>,
    pub groups: Groups,
    /// The names of bodies that have one.
    pub names: BTreeMap<u32, Box<str>>,
}

/// A scene counts as young for this many frames after its number of bodies reached a new maximum.
const YOUTH: u64 = 64;

impl Bodies {
    /// The bodies of a new scene.
    pub fn new() -> Self {
        Self {
            scene: SceneNumber::new(),
            ..Self::default()
        }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    /// Reserves room for this many bodies, and for changes of all of them.
    pub fn reserve(&mut self, bodies: usize) {
        reserve(&mut self.slots, bodies);
        reserve(&mut self.facts, bodies);
        reserve(&mut self.spots, bodies);
        reserve(&mut self.free, bodies);
        self.pending.reserve(bodies);
        reserve(&mut self.settling, bodies);
    }

    pub fn room(&self) -> usize {
        self.slots.capacity()
    }

    /// True if the number of bodies recently reached a new maximum.
    pub fn is_young(&self, frame: u64) -> bool {
        frame < self.grown + YOUTH
    }

    /// The ids of the next bodies, in order.
    pub fn next_ids(&self) -> impl Iterator<Item = BodyId> {
        let new = u32::try_from(self.slots.len()).unwrap_or(u32::MAX)..u32::MAX;
        self.free
            .iter()
            .rev()
            .copied()
            .chain(new)
            .map(|index| self.id(index))
    }

    /// Inserts a body; its id is the first of [`Bodies::next_ids`].
    pub fn insert(&mut self, placed: Placed, frame: u64) {
        let index = self
            .free
            .pop()
            .map_or(self.slots.len(), |index| index as usize);
        let is_new = index == self.slots.len();
        if is_new {
            self.slots.push(None);
            self.facts.push(Facts::default());
            self.spots.push(Spot::NOWHERE);
            self.reserve(self.room());
            self.grown = frame;
        }
        self.slots[index] = Some(placed);
        self.spots[index].remake(frame);
        self.len += 1;
        (self.facts[index].changed, self.facts[index].step) = (frame, 0.0);
        self.note(index);
        // A new slot has no known pairs.
        self.set_pending(
            index as u32,
            if is_new { Change::Place } else { Change::Body },
        );
    }

    pub fn remove(&mut self, id: BodyId) -> Result<Placed, SceneError> {
        self.get(id)?;
        let placed = self.slots[id.index()]
            .take()
            .ok_or(SceneError::NoSuchBody { body: id })?;
        self.len -= 1;
        self.has_removed = true;
        if mem::take(&mut self.facts[id.index()].is_measured) {
            self.distance_requests.forget(id.index);
        }
        self.contact_requests.forget(id.index);
        self.names.remove(&id.index);
        self.ignored
            .retain(|&key| !bodies_of(key).contains(&id.index));
        // A slot whose generations are used up is not reused.
        if let Some(next) = id.generation.checked_add(1) {
            self.spots[id.index()].generation = next;
            self.free.push(id.index);
        }
        self.set_pending(id.index, Change::Body);
        Ok(placed)
    }

    /// Changes a body in a way that may change its box or its verdicts from `frame` on.
    pub fn change(
        &mut self,
        id: BodyId,
        frame: u64,
        change: impl FnOnce(&mut Placed),
    ) -> Result<(), SceneError> {
        let (placed, spot, ..) = self.begin_change(id, frame)?;
        spot.remake(frame);
        change(placed);
        self.note(id.index());
        Ok(())
    }

    /// Moves a body to a pose, where it rests.
    pub fn go(&mut self, id: BodyId, frame: u64, pose: &Pose) -> Result<(), SceneError> {
        let (placed, spot, facts, is_first) = self.begin_change(id, frame)?;
        let was_moving = placed.motion.take().is_some();
        if was_moving {
            spot.remake(frame);
        } else {
            let before = if is_first { 0.0 } else { facts.step };
            facts.step = before + spot.go(&placed.body.tree, &placed.body.pose, pose) as f32;
        }
        placed.put(pose);
        if was_moving {
            self.note(id.index());
        }
        Ok(())
    }

    /// Prepares a body for a change in `frame`. True if it is the first one in this frame.
    fn begin_change(
        &mut self,
        id: BodyId,
        frame: u64,
    ) -> Result<(&mut Placed, &mut Spot, &mut Facts, bool), SceneError> {
        let (index, scene) = (id.index(), self.scene);
        let is_it = |spot: &&mut Spot| spot.generation == id.generation && id.scene.may_be(scene);
        let spot = self.spots.get_mut(index).filter(is_it);
        let (Some(spot), Some(Some(placed)), Some(facts)) =
            (spot, self.slots.get_mut(index), self.facts.get_mut(index))
        else {
            return Err(SceneError::NoSuchBody { body: id });
        };
        wait(
            facts,
            id.index,
            Change::None,
            &mut self.pending,
            &mut self.changed,
        );
        let is_first = mem::replace(&mut facts.changed, frame) < frame;
        if is_first {
            placed.last = placed.body.pose;
        }
        Ok((placed, spot, facts, is_first))
    }

    /// Changes neither the box nor the verdicts of the body.
    pub fn set_importance(&mut self, id: BodyId, importance: f32) -> Result<(), SceneError> {
        self.get_mut(id)?.body.importance = importance;
        self.facts[id.index()].importance = importance;
        self.has_important |= importance > 0.0;
        Ok(())
    }

    /// Updates the facts of a body.
    pub fn note(&mut self, index: usize) {
        let facts = &mut self.facts[index];
        if let Some(placed) = &self.slots[index] {
            let body = &placed.body;
            (facts.importance, facts.filter) = (body.importance, body.filter);
            facts.is_member = placed.compound.is_some() || placed.group.is_some();
            let is_thick = body.margin > 0.0 || body.tree.radius() > 0.0;
            facts.is_special = facts.is_measured || is_thick || placed.motion.is_some();
            self.has_special |= facts.is_special;
            self.has_important |= facts.importance > 0.0;
            self.has_sensor |= body.is_sensor;
            self.has_filtered |= facts.is_member || facts.filter != Filter::default();
            let mesh = body.tree.mesh();
            facts.size = libm::sqrtf(libm::sqrtf(mesh.len() as f32));
            let [triangles, vertices] = &mut self.largest_mesh;
            *triangles = mesh.len().max(*triangles);
            *vertices = mesh.vertex_count().max(*vertices);
        }
    }

    /// True if two bodies may meet: their filters and groups allow it, the pair is not ignored, and
    /// they are not parts of one compound.
    #[inline]
    pub fn may_meet(&self, [a, b]: [u32; 2]) -> bool {
        if !self.has_filtered {
            return true;
        }
        let (x, y) = (self.facts(a), self.facts(b));
        x.filter.meets(y.filter)
            && !(x.is_member && y.is_member && self.are_exclusive([a, b]))
            && (self.ignored.is_empty() || !self.ignored.contains(&pair_key(a, b)))
    }

    /// True if two bodies are parts of one compound, or in groups that ignore each other.
    #[cold]
    fn are_exclusive(&self, pair: [u32; 2]) -> bool {
        let [Some(x), Some(y)] = pair.map(|body| self.at(body)) else {
            return false;
        };
        let groups = x.group.zip(y.group);
        x.compound.is_some() && x.compound == y.compound
            || groups.is_some_and(|(x, y)| self.groups.ignored.contains(&pair_key(x, y)))
    }

    /// Ignores a pair of groups, or does no longer, and finds the pairs of the first one anew.
    pub fn ignore_groups(&mut self, [x, y]: [u32; 2], ignores: bool) {
        set(&mut self.groups.ignored, pair_key(x, y), ignores);
        for body in self.slots() {
            if self.at(body).is_some_and(|placed| placed.group == Some(x)) {
                self.set_pending(body, Change::Place);
            }
        }
    }

    /// Ignores a pair, or does no longer.
    pub fn ignore(&mut self, key: PairKey, ignores: bool) {
        set(&mut self.ignored, key, ignores);
        self.has_filtered |= ignores;
    }

    /// True if the contacts of a pair are requested: by itself, or by its filters if neither body
    /// is a sensor.
    #[inline]
    pub fn wants_contacts(&self, key: PairKey) -> bool {
        let is_sensor = |placed: &Placed| placed.body.is_sensor;
        let requests = &self.contact_requests;
        requests.any()
            && (requests.chosen.contains(&key)
                || requests.has(self.facts_of(key).map(|facts| facts.filter))
                    && (self.pair(key)).is_some_and(|pair| !pair.into_iter().any(is_sensor)))
    }

    /// True if the contacts of some pairs may not be requested.
    pub fn asks_without_contacts(&self) -> bool {
        let of_all = Filter::default();
        self.has_sensor || !self.contact_requests.between.contains(&of_all)
    }

    /// True if a pair may have other questions than whether it meets.
    pub fn is_special(&self, key: PairKey) -> bool {
        Facts::are_special(self.facts_of(key))
    }

    /// True if one body of a pair has a motion.
    pub fn is_moving(&self, key: PairKey) -> bool {
        self.is_special(key)
            && bodies_of(key)
                .into_iter()
                .any(|body| self.at(body).is_some_and(|placed| placed.motion.is_some()))
    }

    /// True if a pair has two questions: its distance, and then its time of impact, because its
    /// boxes meet on their way.
    #[inline]
    pub fn asks_both(&self, key: PairKey) -> bool {
        self.has_special
            && self.is_moving(key)
            && self.distance_requests.has(key)
            && self.boxes_apart(key)[0] == 0.0
    }

    /// True if all that may be asked of a pair is whether it meets, and where: neither its distance
    /// nor its time of impact.
    pub fn asks_only_contact(&self, key: PairKey) -> bool {
        !self.is_special(key) || !self.distance_requests.has(key) && !self.is_moving(key)
    }

    /// Least work of a turn, for any question that may be asked.
    pub fn least_work(&self) -> u64 {
        if self.has_special || self.contact_requests.any() {
            LEAST_DISTANCE_WORK
        } else {
            LEAST_WORK
        }
    }

    /// Leaves a change to the next frame.
    pub fn set_pending(&mut self, index: u32, change: Change) {
        wait(
            &mut self.facts[index as usize],
            index,
            change,
            &mut self.pending,
            &mut self.changed,
        );
    }

    /// True if all boxes are those that the bodies will have in the next frame if nothing changes.
    pub fn are_settled(&self) -> bool {
        self.pending.is_empty() && self.settling.is_empty()
    }

    pub fn end_changes(&mut self) {
        while let Some(index) = self.settling.pop() {
            self.set_pending(index, Change::Settle);
        }
    }

    /// Slots with outdated boxes, including those of removed bodies.
    pub fn pending(&self) -> impl Iterator<Item = u32> {
        self.pending
            .iter()
            .filter(|&index| self.facts(index).is_changed())
    }

    /// Slots that are or were in use.
    pub fn slots(&self) -> impl Iterator<Item = u32> + use<> {
        0..self.slots.len() as u32
    }

    pub fn take_pending(&mut self) -> Option<(u32, Change)> {
        let index = self.pending.pop()?;
        let facts = &mut self.facts[index as usize];
        self.changed -= usize::from(facts.is_changed());
        Some((index, facts.pending.take().unwrap_or_default()))
    }

    pub fn get(&self, id: BodyId) -> Result<&Placed, SceneError> {
        let placed = self.at(id.index).filter(|_| self.id(id.index).is(id));
        placed.ok_or(SceneError::NoSuchBody { body: id })
    }

    pub fn get_mut(&mut self, id: BodyId) -> Result<&mut Placed, SceneError> {
        self.get(id)?;
        self.slots[id.index()]
            .as_mut()
            .ok_or(SceneError::NoSuchBody { body: id })
    }

    pub fn at(&self, index: u32) -> Option<&Placed> {
        self.slots.get(index as usize)?.as_ref()
    }

    /// The key of two bodies that are in the scene.
    pub fn key(&self, x: BodyId, y: BodyId) -> Result<PairKey, SceneError> {
        self.get(x).and(self.get(y))?;
        if x == y {
            Err(SceneError::OneBody { body: x })
        } else {
            Ok(pair_key(x.index, y.index))
        }
    }

    /// Both bodies of a pair, if they are in the scene.
    pub fn pair(&self, key: PairKey) -> Option<[&Placed; 2]> {
        let [a, b] = bodies_of(key);
        Some([self.at(a)?, self.at(b)?])
    }

    /// The frame of the last change of a body of the pair.
    pub fn last_change(&self, key: PairKey) -> u64 {
        let [x, y] = self.facts_of(key);
        x.changed.max(y.changed)
    }

    /// The facts of a slot that is or was in use.
    pub fn facts(&self, index: u32) -> &Facts {
        &self.facts[index as usize]
    }

    /// The facts of both bodies of a pair.
    pub fn facts_of(&self, key: PairKey) -> [&Facts; 2] {
        bodies_of(key).map(|body| self.facts(body))
    }

    /// True if the importance of a pair of bodies is above 0.
    pub fn is_important(&self, key: PairKey) -> bool {
        self.facts_of(key)
            .iter()
            .any(|facts| facts.importance > 0.0)
    }

    /// The box of a placed body.
    pub fn bounds(&self, index: u32) -> &Aabb {
        &self.spots[index as usize].bounds
    }

    /// True if the boxes of two placed bodies overlap.
    #[inline]
    pub fn overlap(&self, [a, b]: [u32; 2]) -> bool {
        self.bounds(a).intersects(self.bounds(b))
    }

    /// If the boxes of two placed bodies overlap, the volume of the overlap, relative to a box with
    /// the shorter of their edges along each axis; 0 to 1.
    #[inline]
    pub fn common_part(&self, [a, b]: [u32; 2]) -> Option<f32> {
        let [x, y] = [self.bounds(a), self.bounds(b)];
        let [common, shorter] = [x.intersection(y).extents(), x.extents().min(y.extents())];
        x.intersects(y)
            .then(|| (common.as_vec3() / shorter.as_vec3()).element_product())
    }

    pub fn id(&self, index: u32) -> BodyId {
        let generation = self
            .spots
            .get(index as usize)
            .map_or(0, |spot| spot.generation);
        BodyId {
            index,
            generation,
            scene: self.scene,
        }
    }

    /// All bodies, by index.
    pub fn iter(&self) -> impl Iterator<Item = (BodyId, &Body)> {
        let slots = self.slots.iter().zip(0..);
        slots.filter_map(|(slot, index)| Some((self.id(index), &slot.as_ref()?.body)))
    }
}

/// Inserts a pair, or removes it.
fn set(pairs: &mut BTreeSet<PairKey>, key: PairKey, is_in: bool) {
    if is_in {
        pairs.insert(key);
    } else {
        pairs.remove(&key);
    }
}

/// Leaves a change of a body to the next frame. The body is queued once, and counts as changed if
/// its box is outdated.
fn wait(facts: &mut Facts, index: u32, change: Change, pending: &mut Waiting, changed: &mut usize) {
    if facts.pending.is_none() {
        pending.push(index, facts.importance);
    }
    *changed += usize::from(change > Change::Settle && !facts.is_changed());
    facts.pending = facts.pending.max(Some(change));
}
