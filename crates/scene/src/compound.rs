//! Compounds: bodies that move together.

use super::body::Body;
use super::error::SceneError;
use super::id::{BodyId, CompoundId};
use super::{Scene, checks};
use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use core::mem;
use punctual_geom::{Motion, Pose};

/// A body of a compound, and its pose in the frame of the compound.
#[derive(Clone, Copy, Debug)]
struct Part {
    body: BodyId,
    place: Pose,
}

#[derive(Debug, Default)]
pub(super) struct Compounds {
    parts: BTreeMap<CompoundId, Vec<Part>>,
    /// Number of compounds inserted so far.
    count: u64,
}

impl Compounds {
    fn get(&self, id: CompoundId) -> Result<&Vec<Part>, SceneError> {
        let found = self
            .parts
            .get_key_value(&id)
            .filter(|(known, _)| known.is(id));
        found
            .map(|(_, parts)| parts)
            .ok_or(SceneError::NoSuchCompound { compound: id })
    }

    pub fn forget(&mut self, compound: Option<u64>, body: BodyId) {
        let compound = compound.map(CompoundId::from_bits);
        if let Some(parts) = compound.and_then(|id| self.parts.get_mut(&id)) {
            parts.retain(|part| part.body != body);
        }
    }
}

impl Scene {
    /// Inserts bodies as the parts of one compound at `pose`: a body of several meshes that move
    /// together. The pose of each part, as given, is its pose in the frame of the compound.
    ///
    /// Parts are bodies like others, with trees, kinds, filters, importances and margins of their
    /// own, and reports name them. Parts of one compound never meet. The pose of a part in the
    /// scene is the product of both poses, rounded ([`Pose::compose`]). A part that is moved
    /// separately returns to its place with the next pose or motion of the compound.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let ball = Arc::new(Tree::new(shapes::icosphere(3)));
    /// let at = |x: f64, y: f64| Pose::from_quat([0.0, 0.0, 0.0, 1.0], [x, y, 0.0]).unwrap();
    /// let mut scene = Scene::new();
    /// let post = scene.insert(Body::fixed(Arc::clone(&ball), at(9.0, 0.0)))?;
    /// let parts = [-1.5, 0.0, 1.5].map(|y| Body::moving(Arc::clone(&ball), at(0.0, y)));
    /// let comb = scene.insert_compound(Pose::IDENTITY, parts)?;
    /// assert_eq!(scene.detect(Budget::unlimited()).intersecting, 0, "its balls overlap, as they should");
    /// scene.set_compound_pose(comb, at(9.0, 3.0))?;
    /// let hit = scene.detect(Budget::unlimited()).intersecting_pairs().next().unwrap().b;
    /// assert_eq!(scene.parts(comb)?.next(), Some(hit));
    /// assert_eq!(scene.compound_of(hit)?, Some(comb));
    /// assert_eq!(scene.compound_of(post)?, None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a part is invalid at its pose in the scene, as for [`Scene::insert`]. The scene is then
    /// unchanged.
    pub fn insert_compound(
        &mut self,
        pose: Pose,
        parts: impl IntoIterator<Item = Body>,
    ) -> Result<CompoundId, SceneError> {
        let at_its_place = |part: Body| {
            (
                part.pose,
                Body {
                    pose: pose.compose_unchecked(&part.pose),
                    ..part
                },
            )
        };
        let parts: Vec<_> = parts.into_iter().map(at_its_place).collect();
        let mut ids = self.bodies.next_ids();
        for (_, body) in &parts {
            checks::body(ids.next().ok_or(SceneError::Full)?, body)?;
        }
        drop(ids);
        let id = CompoundId::new(self.compounds.count, self.bodies.scene);
        let insert = |(place, body)| {
            Ok(Part {
                body: self.insert_part(body, Some(id))?,
                place,
            })
        };
        let parts = parts.into_iter().map(insert).collect::<Result<_, _>>()?;
        self.compounds.parts.insert(id, parts);
        self.compounds.count += 1;
        record!(self, |scene, recorder| {
            let parts = scene.compounds.get(id)?.iter();
            let parts = parts.map(|part| recorder.part(scene, part.body, part.place));
            Ok(crate::record::Call::InsertCompound(
                pose,
                parts.collect::<Result<_, _>>()?,
            ))
        });
        Ok(id)
    }

    /// The parts of a compound, in the order given, without removed ones.
    ///
    /// # Errors
    /// If the compound is not in the scene.
    pub fn parts(
        &self,
        id: CompoundId,
    ) -> Result<impl ExactSizeIterator<Item = BodyId>, SceneError> {
        Ok(self.compounds.get(id)?.iter().map(|part| part.body))
    }

    /// The compound that a body is a part of.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn compound_of(&self, id: BodyId) -> Result<Option<CompoundId>, SceneError> {
        let number = self.bodies.get(id)?.compound;
        Ok(number.map(|number| CompoundId::new(number, self.bodies.scene)))
    }

    /// Moves all parts of a compound, which then rest: [`Scene::set_pose`].
    ///
    /// # Errors
    /// If the compound is not in the scene, or the pose of a part would be invalid. All parts then
    /// stay where they were.
    pub fn set_compound_pose(&mut self, id: CompoundId, pose: Pose) -> Result<(), SceneError> {
        let at = |part: &Part| (part.body, pose.compose_unchecked(&part.place));
        self.with_parts(id, |scene, parts| scene.set_poses(parts.iter().map(at)))
    }

    /// Gives a compound a motion, including turns: each of its parts moves with it, about the same
    /// axis ([`Motion::of_part`], [`Scene::set_motion`]).
    ///
    /// # Errors
    /// If the compound is not in the scene, or the pose of a part would be invalid at the begin or
    /// the end. All parts then stay where they were.
    pub fn set_compound_motion(
        &mut self,
        id: CompoundId,
        motion: Motion,
    ) -> Result<(), SceneError> {
        let of = |part: &Part| match motion.of_part(&part.place) {
            Ok(motion) => checks::motion(part.body, &motion).map(|()| (part.body, motion)),
            Err(_) => Err(SceneError::TooFar {
                body: part.body,
                axis: part.place.translation().abs().max_position(),
            }),
        };
        self.with_parts(id, |scene, parts| {
            parts.iter().try_for_each(|part| of(part).map(drop))?;
            let mut motions = parts.iter().map(of);
            motions.try_for_each(|motion| motion.and_then(|(body, to)| scene.set_motion(body, to)))
        })
    }

    /// Runs a change of all parts, without a copy of them.
    fn with_parts(
        &mut self,
        id: CompoundId,
        change: impl FnOnce(&mut Self, &[Part]) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        self.compounds.get(id)?;
        let parts = self.compounds.parts.get_mut(&id);
        let parts = parts.map(mem::take).unwrap_or_default();
        let changed = change(self, &parts);
        self.compounds.parts.insert(id, parts);
        changed
    }

    /// Removes a compound with all its parts.
    ///
    /// # Errors
    /// If the compound is not in the scene.
    pub fn remove_compound(&mut self, id: CompoundId) -> Result<(), SceneError> {
        self.compounds.get(id)?;
        let parts = self.compounds.parts.remove(&id).unwrap_or_default();
        for part in parts {
            self.bodies_mut().remove(part.body)?;
        }
        record!(self, RemoveCompound(id));
        Ok(())
    }
}
