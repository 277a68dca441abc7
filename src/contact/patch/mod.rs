//! Patches: contacts that hang together, each with a few points that stand for it and an id that
//! lasts from frame to frame.
//!
//! Two contacts are neighbors if their triangles of A have a corner in common (or are the same) and
//! their triangles of B too; a patch is what neighbors connect ([`join`]). So the feet of a table
//! are a patch each, though they stand on one large triangle. Expected time `O(n log n)` in the
//! number of contacts, whatever the number of points.

mod identity;
mod join;
mod reduce;

use super::Contact;
use crate::math::{Aabb, length};
use crate::tree::Tree;
use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;
use identity::Identities;
pub(crate) use identity::PatchMemory;
use join::Joined;
use reduce::Reduction;
use smallvec::SmallVec;

/// Contacts that hang together: [`Patches`]. Lengths are in the unit of the meshes, all else in A's
/// frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Patch {
    /// Stays the same from frame to frame while the patch has a triangle in common with the one
    /// that had it before.
    pub id: u64,
    /// How far apart its nearest triangles are.
    pub distance: f64,
    /// The box of the points of all its contacts, and of the ends of segments.
    pub bounds: Aabb,
    /// Mean of the middles of its contacts. If triangles meet, each counts by the length of its
    /// segment, and those apart do not count; all count alike if the sum of these lengths is 0.
    pub centroid: DVec3,
    /// Direction of the mean, weighted in the same way, of the normals from B to A: a unit vector.
    /// If they cancel out it is the normal of the nearest contact.
    pub normal: DVec3,
    /// Length of all segments in which triangles meet: of the curve in which the surfaces cross,
    /// except where they have areas in common.
    pub length: f64,
    /// Whether that curve closes up: the segments, each with its direction, sum up to nothing. Of
    /// surfaces whose triangles are not oriented alike it may be false although the curve does.
    pub is_closed: bool,
    /// Which of [`Patches::contacts_of`] stand for all.
    points: SmallVec<[u32; 4]>,
    contacts: Range<u32>,
}

/// The patches of a set of contacts, and what is remembered of them for the next frame.
///
/// It owns its buffers, which grow to the largest set and are used again.
///
/// ```
/// use punctual::glam::{DMat3, DVec3, Vec3};
/// use punctual::{Budget, Patches, Pose, Query, Tree, Workspace, shapes};
/// let (a, b) = (Tree::new(shapes::cuboid(Vec3::ONE, 8)), Tree::new(shapes::cuboid(Vec3::ONE, 8)));
/// let (mut workspace, mut patches) = (Workspace::new(), Patches::new());
/// let pose = Pose::new(DMat3::IDENTITY, DVec3::new(0.5, 2.001, 0.25))?;
/// let _ = Query::contacts(&a, &b, pose).margin(0.01).run(&mut workspace, Budget::unlimited());
/// patches.update(&a, &b, workspace.contacts());
/// let patch = &patches.as_slice()[0];
/// assert!((patch.normal + DVec3::Y).length() < 1e-9 && patches.points_of(patch).len() == 4);
/// # Ok::<(), punctual::PoseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Patches {
    /// Most points of a patch.
    limit: usize,
    patches: Vec<Patch>,
    /// The contacts of the first patch, nearest first, then those of the second, and so on.
    contacts: Vec<Contact>,
    /// In the order in which they came.
    given: Vec<Contact>,
    joined: Joined,
    reduction: Reduction,
    identities: Identities,
}

impl Default for Patches {
    fn default() -> Self {
        Self::new()
    }
}

impl Patches {
    /// No patches; at most four points for each.
    #[must_use]
    pub fn new() -> Self {
        Self {
            limit: 4,
            patches: Vec::new(),
            contacts: Vec::new(),
            given: Vec::new(),
            joined: Joined::default(),
            reduction: Reduction::default(),
            identities: Identities::default(),
        }
    }

    /// At most so many points for each patch from the next update on; 0 counts as 1.
    #[must_use]
    pub fn point_limit(mut self, points: usize) -> Self {
        self.limit = points.max(1);
        self
    }

    /// Forgets what was known of the frame before: no patch of the next update has an id that there
    /// was before.
    pub fn forget(&mut self) {
        self.identities.before.forget();
    }

    pub(crate) fn reserve(&mut self, contacts: usize) {
        self.patches.reserve(contacts);
        self.contacts.reserve(contacts);
        self.given.reserve(contacts);
        self.joined.reserve(contacts);
        self.reduction.reserve(contacts);
        self.identities.reserve(contacts);
    }

    /// Takes the memory of other patches, and gives its own in exchange.
    pub(crate) fn swap_memory(&mut self, memory: &mut PatchMemory) {
        core::mem::swap(&mut self.identities.before, memory);
    }

    /// Makes the patches of these contacts, nearest first, of the meshes of `a` and `b`. Contacts
    /// of a stopped query will do.
    ///
    /// A patch gets the id of the patch of the last update with which it has most triangles in
    /// common, if it has any and that id has not gone to one that has more; otherwise a new one. Of
    /// a triangle that many patches have (a floor under many feet), only contacts with the same
    /// triangle count for that; which of such patches gets which id is arbitrary if they have
    /// nothing else in common.
    pub fn update<'c>(
        &mut self,
        a: &Tree,
        b: &Tree,
        contacts: impl IntoIterator<Item = &'c Contact>,
    ) {
        self.given.clear();
        self.given.extend(contacts.into_iter().copied());
        let count = self.joined.join([a.mesh(), b.mesh()], &self.given);
        self.contacts.clear();
        self.patches.clear();
        for members in self.joined.groups(count) {
            let first = self.contacts.len();
            self.contacts
                .extend(members.iter().map(|&i| self.given[i as usize]));
            let contacts = first as u32..self.contacts.len() as u32;
            self.patches.push(Patch::new(
                &self.contacts[first..],
                contacts,
                &mut self.reduction,
                self.limit,
            ));
        }
        self.identities.assign(&mut self.patches, &self.contacts);
    }

    /// The patches of the last update, the nearest first.
    #[must_use]
    pub fn as_slice(&self) -> &[Patch] {
        &self.patches
    }

    /// The contacts of one of these patches, nearest first.
    #[must_use]
    pub fn contacts_of(&self, patch: &Patch) -> &[Contact] {
        self.contacts.get(patch.range()).unwrap_or_default()
    }

    /// The contacts that stand for one of these patches, seen along the normal: the nearest, the
    /// one farthest from that, and then always the one that spans the largest triangle with an edge
    /// of the convex polygon of all before; fewer where nothing more is added.
    pub fn points_of<'p>(
        &'p self,
        patch: &'p Patch,
    ) -> impl ExactSizeIterator<Item = &'p Contact> + Clone {
        let contacts = self.contacts_of(patch);
        // A patch that was read with `serde` may name others.
        let exist = patch.points.iter().all(|&i| (i as usize) < contacts.len());
        let known = if exist { &patch.points[..] } else { &[] };
        known.iter().map(|&i| &contacts[i as usize])
    }
}

impl Patch {
    /// Of these contacts, nearest first, at least one.
    fn new(
        contacts: &[Contact],
        range: Range<u32>,
        reduction: &mut Reduction,
        limit: usize,
    ) -> Self {
        let length_of = |contact: &Contact| {
            contact
                .segment
                .map_or(0.0, |[start, end]| length(end - start))
        };
        let whole: f64 = contacts.iter().map(length_of).sum();
        let weight = |contact: &Contact| {
            if whole > 0.0 {
                length_of(contact) / whole
            } else {
                1.0 / contacts.len() as f64
            }
        };
        let middle = |contact: &Contact| 0.5 * contact.points[0] + 0.5 * contact.points[1];
        let centroid = contacts
            .iter()
            .map(|contact| weight(contact) * middle(contact))
            .sum();
        let normal: DVec3 = contacts
            .iter()
            .map(|contact| weight(contact) * contact.normal)
            .sum();
        let normal = if normal.length() > CANCELED {
            normal.normalize()
        } else {
            contacts[0].normal
        };
        let steps = contacts.iter().filter_map(|contact| contact.segment);
        let sum: DVec3 = steps.map(|[start, end]| end - start).sum();
        let ends = contacts
            .iter()
            .flat_map(|contact| contact.segment.unwrap_or(contact.points));
        Self {
            id: 0,
            distance: contacts[0].distance,
            bounds: Aabb::from_points(ends),
            centroid,
            normal,
            length: whole,
            is_closed: whole > 0.0 && length(sum) <= CLOSED * whole,
            points: reduction.points(contacts, normal, limit),
            contacts: range,
        }
    }

    /// How many contacts it has.
    #[must_use]
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    fn range(&self) -> Range<usize> {
        self.contacts.start as usize..self.contacts.end as usize
    }
}

/// A mean of unit vectors no longer than this has no direction.
const CANCELED: f64 = 1e-9;

/// A curve is closed if its ends are no farther apart than this part of its length, which is for
/// the rounding of segments.
const CLOSED: f64 = 1e-9;
