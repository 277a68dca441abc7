//! Bodies of a scene.

use crate::handle::get;
use crate::pose::punctual_pose;
use crate::sized::grows;
use crate::status::{Fault, value_of};
use crate::tree::punctual_tree;
use crate::verbs::inits;
use ::punctual_scene::{Body, BodyId, BodyKind, Filter};
use punctual::Pose;
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

/// Whether a body can meet others of its kind.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum punctual_body_kind {
    /// Meets moving and fixed bodies.
    Moving = 0,
    /// Part of the surroundings: two fixed bodies are not compared, unless their distance is asked
    /// for. It may be given new poses all the same: a kinematic body, which moves as the program
    /// says and which nothing pushes, is a fixed one with a new pose in each frame, or a motion
    /// (`punctual_scene_set_motion`) so that nothing slips through it.
    Fixed = 1,
}

/// A tree at a pose. Made by `punctual_body_new`; the scene shares the tree, so any number of
/// bodies may have the same.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_body<'t> {
    /// Its size in bytes, as made.
    pub size: u32,
    /// Its tree.
    pub tree: Option<&'t punctual_tree>,
    /// Maps coordinates of the mesh to those of the scene.
    pub pose: punctual_pose,
    /// A `punctual_body_kind`; moving by default.
    pub kind: u32,
    /// The groups it belongs to, a bit each; all by default.
    pub groups: u32,
    /// The groups it meets, if they meet its own; all by default.
    pub mask: u32,
    /// How much its pairs matter when the budget does not reach all; 0 by default. A pair counts as
    /// the more important of its two bodies, and goes before all that are less important.
    pub importance: f32,
    /// By how much its surface is thickened, 0 by default: pairs meet when they come within the sum
    /// of their margins.
    pub margin: f64,
    /// Whether it is a sensor, false by default: what meets it or is inside it is told, but its
    /// pairs have no contact points, unless those of a pair are asked for
    /// (`punctual_scene_find_contacts_of`).
    pub is_sensor: bool,
    /// Any value of yours, 0 by default; the scene ignores it.
    pub data: u64,
}

grows!(punctual_body<'_>: size, pose..data);

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

impl Default for punctual_body<'_> {
    fn default() -> Self {
        let Filter { groups, mask, .. } = Filter::default();
        let (pose, kind) = ((&Pose::IDENTITY).into(), punctual_body_kind::Moving as u32);
        Self {
            size: Self::SIZE,
            tree: None,
            pose,
            kind,
            groups,
            mask,
            importance: 0.0,
            margin: 0.0,
            is_sensor: false,
            data: 0,
        }
    }
}

inits! {
    /// A moving body that may meet all others. Checked when it is inserted.
    punctual_body_init(
        body: punctual_body<'t>, tree: Option<&'t punctual_tree>, pose: punctual_pose
    ) { tree, pose }
}
