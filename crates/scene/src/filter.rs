//! Groups of bodies, and which groups may meet.

use super::Scene;
use super::error::SceneError;
use super::facts::Change;
use super::id::{BodyId, GroupId, PairKey};
use alloc::boxed::Box;
use alloc::collections::BTreeSet;
use alloc::vec::Vec;

/// Determines which bodies may meet: `x` and `y` if `x.groups & y.mask` and `y.groups & x.mask`
/// both have a bit set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Filter {
    /// The groups that the body belongs to.
    pub groups: u32,
    /// The groups that the body may meet.
    pub mask: u32,
}

impl Filter {
    /// Member of the groups `groups`, meets those of `mask`.
    pub const fn new(groups: u32, mask: u32) -> Self {
        Self { groups, mask }
    }

    /// True if bodies with these filters may meet.
    pub const fn meets(self, other: Self) -> bool {
        self.groups & other.mask != 0 && other.groups & self.mask != 0
    }
}

impl Default for Filter {
    /// Member of all groups, meets all groups.
    fn default() -> Self {
        Self::new(u32::MAX, u32::MAX)
    }
}

/// The named groups of a scene, and the pairs of them that may not meet.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    names: Vec<Box<str>>,
    pub ignored: BTreeSet<PairKey>,
}

impl Scene {
    /// The group of this name, new if there is none yet. A body is in at most one
    /// ([`Scene::set_group`]), beside the bits of its [`Filter`].
    ///
    /// ```
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let (ball, mut scene) = (Arc::new(Tree::new(shapes::icosphere(2))), Scene::new());
    /// let (links, cables) = (scene.group("links"), scene.group("cables"));
    /// for group in [links, links, cables] {
    ///     let id = scene.insert(Body::moving(Arc::clone(&ball), Pose::IDENTITY))?;
    ///     scene.set_group(id, Some(group))?;
    /// }
    /// assert_eq!(scene.detect(Budget::unlimited()).intersecting, 3);
    /// scene.ignore_groups(links, cables, true)?;
    /// assert_eq!(scene.detect(Budget::unlimited()).intersecting, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn group(&mut self, name: &str) -> GroupId {
        let names = &self.bodies.groups.names;
        let number = names.iter().position(|other| **other == *name);
        let number = number.unwrap_or(names.len());
        if number == names.len() {
            self.bodies_mut().groups.names.push(name.into());
            record!(self, Group(name.into()));
        }
        GroupId::new(number as u64, self.bodies.scene)
    }

    /// The name of a group.
    ///
    /// # Errors
    /// If it is a group of another scene.
    pub fn group_name(&self, group: GroupId) -> Result<&str, SceneError> {
        let is_of_it = group.is(GroupId::new(group.to_bits(), self.bodies.scene));
        let at = usize::try_from(group.to_bits()).ok().filter(|_| is_of_it);
        let name = at.and_then(|at| self.bodies.groups.names.get(at));
        name.map(|name| &**name)
            .ok_or(SceneError::NoSuchGroup { group })
    }

    /// Moves a body to a group, or out of its group.
    ///
    /// # Errors
    /// If the body is not in the scene, or the group is of another one.
    pub fn set_group(&mut self, id: BodyId, group: Option<GroupId>) -> Result<(), SceneError> {
        self.bodies.get(id)?;
        group.map_or(Ok(""), |group| self.group_name(group))?;
        self.edit(|bodies| {
            bodies.get_mut(id)?.group = group.map(|group| group.to_bits() as u32);
            bodies.note(id.index());
            bodies.set_pending(id.index, Change::Place);
            Ok(())
        })?;
        record!(self, SetGroup(id, group));
        Ok(())
    }

    /// The group of a body.
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn group_of(&self, id: BodyId) -> Result<Option<GroupId>, SceneError> {
        let number = self.bodies.get(id)?.group;
        Ok(number.map(|number| GroupId::new(number.into(), self.bodies.scene)))
    }

    /// Ignores all pairs of a body of one group and a body of the other from the next frame on, or
    /// does no longer. If both are the same group, its bodies do not meet each other. Takes time
    /// linear in the bodies.
    ///
    /// # Errors
    /// If one is a group of another scene.
    pub fn ignore_groups(
        &mut self,
        x: GroupId,
        y: GroupId,
        ignores: bool,
    ) -> Result<(), SceneError> {
        self.group_name(x).and(self.group_name(y))?;
        let pair = [x, y].map(|group| group.to_bits() as u32);
        self.bodies_mut().ignore_groups(pair, ignores);
        record!(self, IgnoreGroups(x, y, ignores));
        Ok(())
    }
}
