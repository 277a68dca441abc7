//! Contact queries: two trees, a pose and a margin in; all pairs of triangles within the margin out.

use crate::arrays::{find_room, list};
use crate::budget::{punctual_budget, punctual_clock};
use crate::distance::not_negative;
use crate::estimate::{punctual_remaining, tell};
use crate::outcome::{punctual_certificate, punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_aabb, punctual_point, punctual_pose};
use crate::query::{answer, trees};
use crate::sized::{begin, grows, place, read, rows};
use crate::status::{Fault, door, given, punctual_status};
use crate::tree::punctual_tree;
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use core::mem::MaybeUninit;
use punctual::contacts::{Contact, ContactBounds, Contacts};
use punctual::{Answer, Pose, Query};

/// The question where two surfaces meet or come within a margin of each other. Plain data, made by `punctual_contact_query_new`,
/// one for each pose; it borrows the trees. To resume a query or to ask for its certificate, all of it must be what it was.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct punctual_contact_query<'t> {
    /// Its size in bytes, as made.
    pub size: u32,
    /// Tree A.
    pub a: Option<&'t punctual_tree>,
    /// Tree B; it may be the same.
    pub b: Option<&'t punctual_tree>,
    /// Brings coordinates of B into those of A.
    pub b_in_a: punctual_pose,
    /// Stop with PAIRS_FULL when this many contacts are in the workspace, at least 1; by default when it is full.
    pub contact_limit: usize,
    /// Pairs of triangles this close are contacts, in the unit of the meshes; 0 by default: they meet. With infinity
    /// all pairs are.
    pub margin: f64,
}

grows!(punctual_contact_query<'_>: size, b_in_a..margin);

/// The answer of a contact query. The contacts stay in the workspace: `punctual_workspace_contacts`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_contacts {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Proven: every contact that was not found is at least this far apart. Infinite if the query is finished: none is missing.
    pub low: f64,
    /// Contacts found, resumed calls and drained contacts included.
    pub found: u64,
    /// Why the query returned.
    pub stop: punctual_stop_reason,
    /// What it has done.
    pub stats: punctual_stats,
}

grows!(punctual_contacts: size, low..stats);

/// A triangle of A and one of B that meet or are close to one another. All of it is in A's frame, in the unit of the meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_contact {
    /// The triangles.
    pub triangles: punctual_triangle_pair,
    /// Their closest points, of A and of B. Of triangles that meet both are the middle of the segment.
    pub points: [punctual_point; 2],
    /// Unit vector from B to A: moved along it, A parts from B. Of triangles that are apart it is the direction of least distance;
    /// of triangles that meet, that of the unit normal of B's triangle less that of A's, both by the right-hand rule.
    pub normal: punctual_point,
    /// How far apart they are, up to some roundings. 0 only if they meet.
    pub distance: f64,
    /// Whether they meet; if not, the segment is zeros.
    pub has_segment: bool,
    /// Where they meet: its ends; the same twice if that is a point.
    pub segment: [punctual_point; 2],
}

grows!(punctual_contact: distance..segment);

impl Default for punctual_contact_query<'_> {
    fn default() -> Self {
        let b_in_a = (&Pose::IDENTITY).into();
        Self {
            size: Self::SIZE,
            a: None,
            b: None,
            b_in_a,
            contact_limit: usize::MAX,
            margin: 0.0,
        }
    }
}

/// The question where `a` and `b` meet, with the default options. Checked when it is run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_query_init<'t>(
    query: *mut punctual_contact_query<'t>,
    size: usize,
    a: Option<&'t punctual_tree>,
    b: Option<&'t punctual_tree>,
    b_in_a: punctual_pose,
) {
    // SAFETY: the contract of the header for structs.
    unsafe {
        begin(
            query,
            size,
            punctual_contact_query {
                a,
                b,
                b_in_a,
                ..Default::default()
            },
        )
    }
}

/// Runs a contact query within a budget. The first one in a workspace makes room for 4,096 contacts, unless
/// `punctual_workspace_reserve_contacts` has made some; later ones do not allocate. It does not lock or panic. `clock` may be null:
/// the clock of the system.
///
/// Under a time budget it returns at most one poll interval of work late, under a work budget at most
/// PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
///
/// Fails with NULL, BAD_POSE, BAD_ARGUMENT or POISONED before it has begun; the workspace is unchanged then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_query_run(
    query: *const punctual_contact_query<'_>,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    contacts: *mut punctual_contacts,
) -> punctual_status {
    door("punctual_contact_query_run", || {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let query = read(query, "query")?.check()?;
            answer(workspace, None, budget, clock, contacts, |w, _, b| {
                Ok(query.run(w, b))
            })
        }
    })
}

/// Goes on with the stopped run that the workspace holds, with a fresh budget; after PAIRS_FULL drain the contacts or make
/// room first.
/// However it is cut into pieces by work budgets, all contacts together are those of one uninterrupted run.
///
/// Fails as `punctual_contact_query_run`, and with NOT_RESUMABLE if the last run in this workspace was not of this very query
/// or is complete.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_query_resume(
    query: *const punctual_contact_query<'_>,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    clock: Option<&punctual_clock>,
    contacts: *mut punctual_contacts,
) -> punctual_status {
    door("punctual_contact_query_resume", || {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let query = read(query, "query")?.check()?;
            answer(workspace, None, budget, clock, contacts, |w, _, b| {
                Ok(query.resume(w, b)?)
            })
        }
    })
}

/// What the last run of this query in the workspace has still to do.
/// Takes less than a microsecond and allocates nothing.
///
/// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_query_remaining(
    query: *const punctual_contact_query<'_>,
    workspace: Option<&punctual_workspace>,
    remaining: *mut punctual_remaining,
) -> punctual_status {
    door("punctual_contact_query_remaining", || {
        // SAFETY: the contract of the header for structs.
        unsafe { tell(&read(query, "query")?.check()?, workspace, None, remaining) }
    })
}

/// Where the last run of this query in the workspace may have missed contacts. Takes time linear in the open pairs; allocates
/// nothing.
///
/// Fails with NOT_RESUMABLE if the last run in this workspace was not of this very query.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_query_certificate(
    query: *const punctual_contact_query<'_>,
    workspace: Option<&punctual_workspace>,
    certificate: *mut punctual_certificate,
) -> punctual_status {
    door("punctual_contact_query_certificate", || {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        // SAFETY: the same.
        let certificate = unsafe { place(certificate, "certificate") }?;
        certificate.write(
            query
                .certificate(given(workspace, "workspace")?.0.get("workspace")?)?
                .into(),
        );
        Ok(())
    })
}

/// Boxes in A's frame, at most one for each open pair: every missed contact has the middle of its closest points in one of them. As
/// many as `capacity` allows are written to `boxes`, and how many there are to `count`.
///
/// Fails as `punctual_contact_query_certificate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_query_open_boxes(
    query: *const punctual_contact_query<'_>,
    workspace: Option<&punctual_workspace>,
    boxes: *mut punctual_aabb,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_contact_query_open_boxes", || {
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?.check()?;
        let count = given(count, "count")?;
        let open = query.certificate(given(workspace, "workspace")?.0.get("workspace")?)?;
        // SAFETY: the contract of the header for arrays.
        unsafe { list(boxes, capacity, "boxes", count, open.boxes()) }
    })
}

/// The contacts that the last query found, if it was a contact query, without those drained: the nearest first. As many as
/// `capacity` allows are written to `contacts`, and how many there are to `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_workspace_contacts(
    workspace: Option<&punctual_workspace>,
    contacts: *mut punctual_contact,
    contacts_size: usize,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
) -> punctual_status {
    door("punctual_workspace_contacts", || {
        let found = given(workspace, "workspace")?
            .0
            .get("workspace")?
            .contacts();
        // SAFETY: the contract of the header for arrays.
        unsafe {
            rows(
                contacts,
                contacts_size,
                capacity,
                "contacts",
                given(count, "count")?,
                found,
            )
        }
    })
}

/// Forgets the contacts, so that a query that stopped with PAIRS_FULL can be resumed. Copy them first.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_workspace_drain_contacts(
    workspace: Option<&mut punctual_workspace>,
) -> punctual_status {
    door("punctual_workspace_drain_contacts", || {
        given(workspace, "workspace")?
            .0
            .set("workspace", |workspace| drop(workspace.drain_contacts()))
    })
}

/// Makes room for at least so many contacts, 170 bytes each.
///
/// Fails with OUT_OF_MEMORY if there is not that much.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_workspace_reserve_contacts(
    workspace: Option<&mut punctual_workspace>,
    contacts: usize,
) -> punctual_status {
    door("punctual_workspace_reserve_contacts", || {
        given(workspace, "workspace")?
            .0
            .change("workspace", |workspace| {
                find_room([(contacts, size_of::<Contact>() + 3 * size_of::<u64>())])?;
                workspace.reserve_contacts(contacts);
                Ok(())
            })
    })
}

/// The unit normals of a triangle of A and of one of B by the right-hand rule, in A's frame: which way the surfaces face.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_face_normals {
    /// That of the triangle of A; zeros if it has no area.
    pub a: punctual_point,
    /// That of the triangle of B; zeros if it has no area.
    pub b: punctual_point,
}

/// Tells which way the triangles of a contact face. The query need not have been run; only its trees and its pose matter.
///
/// Fails with BAD_ARGUMENT if one of the meshes has no such triangle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn punctual_contact_face_normals(
    query: *const punctual_contact_query<'_>,
    triangles: punctual_triangle_pair,
    normals: Option<&mut MaybeUninit<punctual_face_normals>>,
) -> punctual_status {
    door("punctual_contact_face_normals", || {
        let normals = given(normals, "normals")?;
        // SAFETY: the contract of the header for structs.
        let query = unsafe { read(query, "query") }?;
        let [a, b] = trees(query.a, query.b)?;
        for (name, triangle, tree) in [
            ("triangles.a", triangles.a, a),
            ("triangles.b", triangles.b, b),
        ] {
            let count = tree.mesh().len();
            if triangle as usize >= count {
                return Err(Fault::Index(name, triangle as usize, count));
            }
        }
        let query = Query::contacts(a, b, query.b_in_a.check()?);
        let [a, b] = query
            .face_normals([triangles.a, triangles.b])
            .map(Option::unwrap_or_default);
        normals.write(punctual_face_normals {
            a: a.into(),
            b: b.into(),
        });
        Ok(())
    })
}

impl<'t> punctual_contact_query<'t> {
    fn check(self) -> Result<Query<'t, Contacts>, Fault> {
        let [a, b] = trees(self.a, self.b)?;
        not_negative(self.margin, "query->margin")?;
        let query = Query::contacts(a, b, self.b_in_a.check()?).margin(self.margin);
        Ok(query.contact_limit(self.contact_limit))
    }
}

impl From<Answer<ContactBounds>> for punctual_contacts {
    fn from(contacts: Answer<ContactBounds>) -> Self {
        Self {
            size: Self::SIZE,
            low: contacts.value.low,
            found: contacts.stats.found,
            stop: contacts.stop.into(),
            stats: contacts.stats.into(),
        }
    }
}

impl From<&Contact> for punctual_contact {
    fn from(contact: &Contact) -> Self {
        Self {
            triangles: contact.triangles.into(),
            points: contact.points.map(Into::into),
            normal: contact.normal.into(),
            distance: contact.distance,
            has_segment: contact.segment.is_some(),
            segment: contact.segment.unwrap_or_default().map(Into::into),
        }
    }
}
