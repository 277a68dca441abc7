//! Patches: groups of connected contacts, each with a few representative points and an id that
//! lasts from frame to frame.
//!
//! Two contacts are neighbors if their triangles of A share a corner (or are the same) and their
//! triangles of B too. A patch is a connected component of neighbors ([`join`]). So each foot of a
//! table is a patch, although all of them stand on one large triangle. Expected time `O(n log n)`
//! in the number of contacts, for any number of points.

mod identity;
mod join;
mod reduce;

use super::Contact;
use crate::tree::Tree;
use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;
use identity::Identities;
pub use identity::PatchMemory;
use join::Joined;
use punctual_geom::{Aabb, length};
use reduce::Reduction;
use smallvec::SmallVec;

/// A group of connected contacts: [`Patches`]. Lengths are in the unit of the meshes, vectors in
/// A's frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Patch {
    /// The patch keeps its id from one frame to the next while it shares a triangle with the patch
    /// that had the id before.
    pub id: u64,
    /// The distance of its nearest triangles.
    pub distance: f64,
    /// The box around the points of all contacts and around the ends of their segments.
    pub bounds: Aabb,
    /// Mean of the midpoints of its contacts. If triangles intersect, each contact is weighted by
    /// the length of its segment, and separated triangles do not count. If the sum of these lengths
    /// is 0, all contacts have equal weight.
    pub centroid: DVec3,
    /// Unit vector: the direction of the mean of the normals from B to A, with the weights of the
    /// centroid. If the normals cancel out, it is the normal of the nearest contact.
    pub normal: DVec3,
    /// Total length of the segments in which triangles intersect. This is the length of the
    /// intersection curve, except where the surfaces have areas in common.
    pub length: f64,
    /// True if the intersection curve is closed: the segments, as directed vectors, sum to zero. If
    /// the triangles of a surface are not oriented consistently, it may be false for a closed
    /// curve.
    pub is_closed: bool,
    /// Indices into [`Patches::contacts_of`] of the representative points.
    points: SmallVec<[u32; 4]>,
    contacts: Range<u32>,
}

/// The patches of a set of contacts, and their ids for the next frame.
///
/// It owns its buffers, which grow to the largest set and are reused.
///
/// ```
/// use punctual::glam::{DMat3, DVec3, Vec3};
/// use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};
/// use punctual::contacts::Patches;
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
    /// Maximum number of points per patch.
    limit: usize,
    patches: Vec<Patch>,
    /// The contacts of the first patch, nearest first, then those of the second, and so on.
    contacts: Vec<Contact>,
    /// The contacts in the order given.
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

    /// Sets the maximum number of points per patch, from the next update on; 0 counts as 1.
    #[must_use]
    pub fn point_limit(mut self, points: usize) -> Self {
        self.limit = points.max(1);
        self
    }

    /// Forgets the previous frame: the patches of the next update get new ids.
    pub fn forget(&mut self) {
        self.identities.before.forget();
    }

    /// Reserves room for the patches of this many contacts.
    pub fn reserve(&mut self, contacts: usize) {
        self.patches.reserve(contacts);
        self.contacts.reserve(contacts);
        self.given.reserve(contacts);
        self.joined.reserve(contacts);
        self.reduction.reserve(contacts);
        self.identities.reserve(contacts);
    }

    /// Exchanges the memory of the previous frame with `memory`.
    pub fn swap_memory(&mut self, memory: &mut PatchMemory) {
        core::mem::swap(&mut self.identities.before, memory);
    }

    /// Computes the patches of these contacts, which must be sorted nearest first. `a` and `b` are
    /// the trees of the contacts' meshes. The contacts may be those of a stopped query.
    ///
    /// A patch inherits the id of the patch of the last update with which it shares most triangles.
    /// If there is none, or if that id goes to a patch that shares more, it gets a new id. A
    /// triangle in many patches (a floor under many feet) counts as shared only through contacts
    /// that also have the same triangle on the other side. Patches that share such a triangle and
    /// nothing else get the remaining ids of its previous patches, in arbitrary order.
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

    /// The patches of the last update, nearest first.
    #[must_use]
    pub fn as_slice(&self) -> &[Patch] {
        &self.patches
    }

    /// The contacts of one of these patches, nearest first.
    #[must_use]
    pub fn contacts_of(&self, patch: &Patch) -> &[Contact] {
        self.contacts.get(patch.range()).unwrap_or_default()
    }

    /// The representative contacts of a patch. They are chosen in the projection along the normal.
    /// The first is the nearest, and the second is the one farthest from it. Each further one spans
    /// the largest triangle with an edge of the convex polygon of those chosen before. There are
    /// fewer than the limit if another would add nothing.
    pub fn points_of<'p>(
        &'p self,
        patch: &'p Patch,
    ) -> impl ExactSizeIterator<Item = &'p Contact> + Clone {
        let contacts = self.contacts_of(patch);
        // A deserialized patch may name other contacts.
        let exist = patch.points.iter().all(|&i| (i as usize) < contacts.len());
        let known = if exist { &patch.points[..] } else { &[] };
        known.iter().map(|&i| &contacts[i as usize])
    }
}

impl Patch {
    /// The patch of these contacts, of which there is at least one. They are sorted nearest first.
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

    /// Number of contacts of the patch.
    #[must_use]
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    fn range(&self) -> Range<usize> {
        self.contacts.start as usize..self.contacts.end as usize
    }
}

/// A mean of unit vectors no longer than this counts as zero.
const CANCELED: f64 = 1e-9;

/// A curve is closed if the gap between its ends is at most this fraction of its length. Allows for
/// the rounding of segments.
const CLOSED: f64 = 1e-9;
