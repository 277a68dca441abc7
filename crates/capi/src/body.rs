//! Bodies of a scene.

use crate::handle::get;
use crate::pose::punctual_pose;
use crate::status::{Fault, value_of};
use crate::tree::punctual_tree;
use crate::verbs::{inits, types};
use ::punctual_scene::{Body, BodyId, BodyKind, Filter};
use std::sync::Arc;

/// Names a body of one scene for as long as it is in it. The id of a removed body is never valid
/// again.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct punctual_body_id {
    /// A small number that no other body now in the scene has; those of removed bodies are given
    /// out again.
    pub index: u32,
    /// Tells bodies of the same index apart.
    pub generation: u32,
    /// Tells scenes of this process apart; no other scene takes the id for one of its own. It is no
    /// part of what the id says: compare and store `index` and `generation`. 0: every scene takes
    /// the id for its own.
    pub scene: u32,
}

/// As ids compare in Rust.
impl PartialEq for punctual_body_id {
    fn eq(&self, other: &Self) -> bool {
        (self.index, self.generation) == (other.index, other.generation)
    }
}

impl Eq for punctual_body_id {}

impl From<BodyId> for punctual_body_id {
    fn from(id: BodyId) -> Self {
        let bits = id.to_bits();
        Self {
            index: bits as u32,
            generation: (bits >> 32) as u32,
            scene: id.scene(),
        }
    }
}

impl From<punctual_body_id> for BodyId {
    fn from(id: punctual_body_id) -> Self {
        Self::from_bits(u64::from(id.generation) << 32 | u64::from(id.index)).of_scene(id.scene)
    }
}

types! {
    /// Whether a body can meet others of its kind.
    enum punctual_body_kind from BodyKind {
        /// Meets moving and fixed bodies.
        Moving = 0,
        /// Part of the surroundings: two fixed bodies are not compared, unless their distance is
        /// asked for. It may be given new poses all the same: a kinematic body, which moves as the
        /// program says and which nothing pushes, is a fixed one with a new pose in each frame, or
        /// a motion (`punctual_scene_set_motion`) so that nothing slips through it.
        Fixed = 1,
    }

    /// A tree at a pose. Made by `punctual_body_new`; the scene shares the tree, so any number of
    /// bodies may have the same.
    asked punctual_body<'t>(pose) {
        /// Its tree.
        tree: Option<&'t punctual_tree> = None,
        /// Maps coordinates of the mesh to those of the scene.
        pose: punctual_pose = punctual_pose::IDENTITY,
        /// A `punctual_body_kind`; moving by default.
        kind: u32 = punctual_body_kind::Moving as u32,
        /// The groups it belongs to, a bit each; all by default.
        groups: u32 = Filter::default().groups,
        /// The groups it meets, if they meet its own; all by default.
        mask: u32 = Filter::default().mask,
        /// How much its pairs matter when the budget does not reach all; 0 by default. A pair
        /// counts as the more important of its two bodies, and goes before all that are less
        /// important.
        importance: f32 = 0.0,
        /// By how much its surface is thickened, 0 by default: pairs meet when they come within the
        /// sum of their margins.
        margin: f64 = 0.0,
        /// Whether it is a sensor, false by default: what meets it or is inside it is told, but its
        /// pairs have no contact points, unless those of a pair are asked for
        /// (`punctual_scene_find_contacts_of`).
        is_sensor: bool = false,
        /// Any value of yours, 0 by default; the scene ignores it.
        data: u64 = 0,
    }
}

impl punctual_body<'_> {
    pub(crate) fn check(self) -> Result<Body, Fault> {
        let tree = Arc::clone(get(self.tree, "body->tree")?);
        let pose = self.pose.check()?;
        let body = match value_of(
            self.kind,
            "body->kind",
            &[BodyKind::Moving, BodyKind::Fixed],
        )? {
            BodyKind::Moving => Body::moving(tree, pose),
            BodyKind::Fixed => Body::fixed(tree, pose),
        };
        let mut body = body
            .filter(Filter::new(self.groups, self.mask))
            .importance(self.importance)
            .margin(self.margin);
        (body.is_sensor, body.data) = (self.is_sensor, self.data);
        Ok(body)
    }
}

/// Without the tree, which is the scene's.
impl From<&Body> for punctual_body<'_> {
    fn from(body: &Body) -> Self {
        let kind = match body.kind {
            BodyKind::Moving => punctual_body_kind::Moving,
            BodyKind::Fixed => punctual_body_kind::Fixed,
        };
        let Filter { groups, mask, .. } = body.filter;
        Self {
            size: Self::SIZE,
            tree: None,
            pose: (&body.pose).into(),
            kind: kind as u32,
            groups,
            mask,
            importance: body.importance,
            margin: body.margin,
            is_sensor: body.is_sensor,
            data: body.data,
        }
    }
}

inits! {
    /// A moving body that may meet all others. Checked when it is inserted.
    punctual_body_init(
        body: punctual_body<'t>, tree: Option<&'t punctual_tree>, pose: punctual_pose
    ) { tree, pose }
}
