//! Contact queries: two trees, a pose and a margin in; all pairs of triangles within the margin
//! out.

use crate::arrays::find_room;
use crate::distance::not_negative;
use crate::handle::{change, set};
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::sized::{grows, read};
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, lists, question};
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use core::mem::MaybeUninit;
use punctual::contacts::{Contact, ContactBounds, Contacts};
use punctual::{Answer, Pose, Query};

/// The question where two surfaces meet or come within a margin of each other. Plain data, made by
/// `punctual_contact_query_new`, one for each pose; it borrows the trees. To resume a query or to
/// ask for its certificate, all of it must be what it was.
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
    /// Stop with PAIRS_FULL when this many contacts are in the workspace, at least 1; by default
    /// when it is full.
    pub contact_limit: usize,
    /// Pairs of triangles this close are contacts, in the unit of the meshes; 0 by default: they
    /// meet. With infinity all pairs are.
    pub margin: f64,
}

grows!(punctual_contact_query<'_>: size, b_in_a..margin);

/// The answer of a contact query. The contacts stay in the workspace:
/// `punctual_workspace_contacts`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_contacts {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// Proven: every contact that was not found is at least this far apart. Infinite if the query
    /// is finished: none is missing.
    pub low: f64,
    /// Contacts found, resumed calls and drained contacts included.
    pub found: u64,
    /// Why the query returned.
    pub stop: punctual_stop_reason,
    /// What it has done.
    pub stats: punctual_stats,
}

grows!(punctual_contacts: size, low..stats);

/// A triangle of A and one of B that meet or are close to one another. All of it is in A's frame,
/// in the unit of the meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_contact {
    /// The triangles.
    pub triangles: punctual_triangle_pair,
    /// Their closest points, of A and of B. Of triangles that meet both are the middle of the
    /// segment.
    pub points: [punctual_point; 2],
    /// Unit vector from B to A: moved along it, A parts from B. Of triangles that are apart it is
    /// the direction of least distance; of triangles that meet, that of the unit normal of B's
    /// triangle less that of A's, both by the right-hand rule.
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

inits! {
    /// The question where `a` and `b` meet, with the default options. Checked when it is run.
    punctual_contact_query_init(
        query: punctual_contact_query<'t>,
        a: Option<&'t punctual_tree>, b: Option<&'t punctual_tree>, b_in_a: punctual_pose
    ) { a, b, b_in_a }
}

question! {
    punctual_contact_query(punctual_workspace) -> punctual_contacts {
        /// Runs a contact query within a budget. The first one in a workspace makes room for 4,096
        /// contacts, unless `punctual_workspace_reserve_contacts` has made some; later ones do not
        /// allocate. It does not lock or panic.
        ///
        /// Under a time budget it returns at most one poll interval of work late, under a work
        /// budget at most PUNCTUAL_MAX_DISTANCE_STEP_WORK units later.
        run punctual_contact_query_run;

        /// After PAIRS_FULL drain the contacts or make room first. However it is cut into pieces by
        /// work budgets, all contacts together are those of one uninterrupted run.
        resume punctual_contact_query_resume;

        remaining punctual_contact_query_remaining;

        /// Where the last run of this query in the workspace may have missed contacts.
        certificate punctual_contact_query_certificate;

        /// Every missed contact has the middle of its closest points in one of them.
        open_boxes punctual_contact_query_open_boxes;
    }
}

calls! {
    /// Forgets the contacts, so that a query that stopped with PAIRS_FULL can be resumed. Copy them
    /// first.
    fn punctual_workspace_drain_contacts(workspace: Option<&mut punctual_workspace>) {
        set(workspace, "workspace", |workspace| drop(workspace.drain_contacts()))
    }

    /// Makes room for at least so many contacts, 170 bytes each.
    ///
    /// Fails with OUT_OF_MEMORY if there is not that much.
    fn punctual_workspace_reserve_contacts(
        workspace: Option<&mut punctual_workspace>, contacts: usize
    ) {
        change(workspace, "workspace", |workspace| {
            find_room([(contacts, size_of::<Contact>() + 3 * size_of::<u64>())])?;
            workspace.reserve_contacts(contacts);
            Ok(())
        })
    }
}

/// The unit normals of a triangle of A and of one of B by the right-hand rule, in A's frame: which
/// way the surfaces face.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_face_normals {
    /// That of the triangle of A; zeros if it has no area.
    pub a: punctual_point,
    /// That of the triangle of B; zeros if it has no area.
    pub b: punctual_point,
}

calls! {
    /// Tells which way the triangles of a contact face. The query need not have been run; only its
    /// trees and its pose matter.
    ///
    /// Fails with BAD_ARGUMENT if one of the meshes has no such triangle.
    unsafe fn punctual_contact_face_normals(
        query: *const punctual_contact_query<'_>, triangles: punctual_triangle_pair,
        normals: Option<&mut MaybeUninit<punctual_face_normals>>
    ) {
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
        let [a, b] = query.face_normals([triangles.a, triangles.b]).map(Option::unwrap_or_default);
        normals.write(punctual_face_normals {
            a: a.into(),
            b: b.into(),
        });
        Ok(())
    }
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

lists! {
    /// The contacts that the last query found, if it was a contact query, without those drained:
    /// the nearest first.
    rows punctual_workspace_contacts(workspace: punctual_workspace)
        -> contacts: punctual_contact, contacts_size = workspace.contacts();
}
