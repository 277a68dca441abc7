//! Patches: contacts that hang together, with a few points each and ids that last from frame to frame.

use crate::contacts::punctual_contact;
use crate::handle::{Handle, put};
use crate::pose::{punctual_aabb, punctual_point};
use crate::sized::{grows, place, rows};
use crate::status::{Fault, door, free, given, punctual_status};
use crate::tree::punctual_tree;
use crate::workspace::punctual_workspace;
use core::mem::MaybeUninit;
use punctual::contacts::{Patch, Patches};

/// The patches of a set of contacts, and what is remembered of them for the next frame. Its buffers grow to the largest set and are
/// used again. One thread at a time may use it.
#[derive(Debug)]
pub struct punctual_patches(Handle<Patches>);

/// Contacts that hang together: from each to the next their triangles of A have a corner in common or are the same, and their
/// triangles of B too. All of it is in A's frame, in the unit of the meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_patch {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Whether these close up.
    pub is_closed: bool,
    /// How many contacts it has.
    pub contact_count: usize,
    /// How many of them stand for all.
    pub point_count: usize,
    /// Stays the same from frame to frame while the patch has a triangle in common with the one that had it before.
    pub id: u64,
    /// How far apart its nearest triangles are.
    pub distance: f64,
    /// The box of the points of all its contacts.
    pub bounds: punctual_aabb,
    /// Mean of the middles of its contacts. If triangles meet, each counts by the length of its segment.
    pub centroid: punctual_point,
    /// Direction of the mean of the normals from B to A, weighted in the same way: a unit vector.
    pub normal: punctual_point,
    /// Length of all segments in which triangles meet.
    pub length: f64,
}

grows!(punctual_patch: size, id..length);

/// Makes an empty set of patches, of which each will have at most so many points, at least 1; 4 are usual.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_patches_new(
    point_limit: usize,
    patches: Option<&mut MaybeUninit<Option<Box<punctual_patches>>>>,
) -> punctual_status {
    door("punctual_patches_new", || {
        put(patches, || {
            Ok(punctual_patches(Handle::new(
                Patches::new().point_limit(point_limit),
            )))
        })
    })
}

/// Frees a set of patches; null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_patches_free(patches: Option<Box<punctual_patches>>) {
    free(patches);
}

/// Makes the patches of the contacts in the workspace, of the meshes of `a` and `b`; how many there are. Expected time linear in
/// the contacts.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_patches_update(
    patches: Option<&mut punctual_patches>,
    a: Option<&punctual_tree>,
    b: Option<&punctual_tree>,
    workspace: Option<&punctual_workspace>,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_patches_update", || {
        let (a, b) = (given(a, "a")?.0.get("a")?, given(b, "b")?.0.get("b")?);
        let contacts = given(workspace, "workspace")?
            .0
            .get("workspace")?
            .contacts();
        let count = given(count, "count")?;
        count.write(given(patches, "patches")?.0.change("patches", |patches| {
            patches.update(a, b, contacts);
            Ok(patches.as_slice().len())
        })?);
        Ok(())
    })
}

/// Forgets what was known of the frame before: no patch of the next update has an id that there was before.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_patches_forget(
    patches: Option<&mut punctual_patches>,
) -> punctual_status {
    door("punctual_patches_forget", || {
        given(patches, "patches")?.0.change("patches", |patches| {
            patches.forget();
            Ok(())
        })
    })
}

/// A patch of the last update, counted from 0; the nearest come first.
///
/// Fails with BAD_ARGUMENT if there are fewer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_patches_describe(
    patches: Option<&punctual_patches>,
    index: usize,
    patch: *mut punctual_patch,
) -> punctual_status {
    door("punctual_patches_describe", || {
        let (patches, found) = find(patches, index)?;
        // SAFETY: the contract of the header for structs.
        unsafe { place(patch, "patch") }?.write(described(patches, found));
        Ok(())
    })
}

/// The contacts of a patch, the nearest first. As many as `capacity` allows are written to `contacts`, and how many there are to
/// `count`.
///
/// Fails as `punctual_patches_describe`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_patches_contacts(
    patches: Option<&punctual_patches>,
    index: usize,
    contacts: *mut punctual_contact,
    contacts_size: usize,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_patches_contacts", || {
        let (patches, patch) = find(patches, index)?;
        // SAFETY: the contract of the header for arrays.
        unsafe {
            let (count, found) = (given(count, "count")?, patches.contacts_of(patch).iter());
            rows(contacts, contacts_size, capacity, "contacts", count, found)
        }
    })
}

/// The contacts that stand for a patch: the nearest, and those that span most of its area, seen along its normal. As many as
/// `capacity` allows are written to `points`, and how many there are to `count`.
///
/// Fails as `punctual_patches_describe`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_patches_points(
    patches: Option<&punctual_patches>,
    index: usize,
    points: *mut punctual_contact,
    points_size: usize,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_patches_points", || {
        let (patches, patch) = find(patches, index)?;
        // SAFETY: the contract of the header for arrays.
        unsafe {
            rows(
                points,
                points_size,
                capacity,
                "points",
                given(count, "count")?,
                patches.points_of(patch),
            )
        }
    })
}

fn find(patches: Option<&punctual_patches>, index: usize) -> Result<(&Patches, &Patch), Fault> {
    let patches = given(patches, "patches")?.0.get("patches")?;
    let all = patches.as_slice();
    Ok((
        patches,
        all.get(index)
            .ok_or(Fault::Index("index", index, all.len()))?,
    ))
}

fn described(patches: &Patches, patch: &Patch) -> punctual_patch {
    punctual_patch {
        size: punctual_patch::SIZE,
        id: patch.id,
        distance: patch.distance,
        bounds: patch.bounds.into(),
        centroid: patch.centroid.into(),
        normal: patch.normal.into(),
        length: patch.length,
        is_closed: patch.is_closed,
        contact_count: patch.contact_count(),
        point_count: patches.points_of(patch).len(),
    }
}
