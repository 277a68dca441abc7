//! Contact queries: two trees, a pose and a margin in; all pairs of triangles within the margin
//! out.

use crate::arrays::find_room;
use crate::distance::not_negative;
use crate::outcome::{punctual_stats, punctual_stop_reason};
use crate::pose::{punctual_point, punctual_pose};
use crate::query::trees;
use crate::sized::read;
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, lists, question, types};
use crate::workspace::{punctual_triangle_pair, punctual_workspace};
use core::mem::MaybeUninit;
use punctual::contacts::{Contact, ContactBounds, Contacts};
use punctual::{Answer, Query};

types! {
    /// The question where two surfaces meet or come within a margin of each other. Plain data, made
    /// by `punctual_contact_query_new`, one for each pose; it borrows the trees. To resume a query
    /// or to ask for its certificate, all of it must be what it was.
    asked punctual_contact_query<'t>(b_in_a) {
        /// Tree A.
        a: Option<&'t punctual_tree> = None,
        /// Tree B; it may be the same.
        b: Option<&'t punctual_tree> = None,
        /// Brings coordinates of B into those of A.
        b_in_a: punctual_pose = punctual_pose::IDENTITY,
        /// Stop with PAIRS_FULL when this many contacts are in the workspace, at least 1; by
        /// default when it is full.
        contact_limit: usize = usize::MAX,
        /// Pairs of triangles this close are contacts, in the unit of the meshes; 0 by default:
        /// they meet. With infinity all pairs are.
        margin: f64 = 0.0,
    }

    /// The answer of a contact query. The contacts stay in the workspace:
    /// `punctual_workspace_contacts`.
    told punctual_contacts(low) from (contacts: Answer<ContactBounds>) {
        /// Proven: every contact that was not found is at least this far apart. Infinite if the
        /// query is finished: none is missing.
        low: f64 = contacts.value.low,
        /// Contacts found, resumed calls and drained contacts included.
        found: u64 = contacts.stats.found,
        /// Why the query returned.
        stop: punctual_stop_reason = contacts.stop.into(),
        /// What it has done.
        stats: punctual_stats = contacts.stats.into(),
    }

    /// A triangle of A and one of B that meet or are close to one another. All of it is in A's
    /// frame, in the unit of the meshes.
    row punctual_contact(distance) from (contact: &Contact) {
        /// The triangles.
        triangles: punctual_triangle_pair = contact.triangles.into(),
        /// Their closest points, of A and of B. Of triangles that meet both are the middle of the
        /// segment.
        points: [punctual_point; 2] = contact.points.map(Into::into),
        /// Unit vector from B to A: moved along it, A parts from B. Of triangles that are apart it
        /// is the direction of least distance; of triangles that meet, that of the unit normal of
        /// B's triangle less that of A's, both by the right-hand rule.
        normal: punctual_point = contact.normal.into(),
        /// How far apart they are, up to some roundings. 0 only if they meet.
        distance: f64 = contact.distance,
        /// Whether they meet; if not, the segment is zeros.
        has_segment: bool = contact.segment.is_some(),
        /// Where they meet: its ends; the same twice if that is a point.
        segment: [punctual_point; 2] = contact.segment.unwrap_or_default().map(Into::into),
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
    change punctual_workspace_drain_contacts(workspace: punctual_workspace) =
        drop(workspace.drain_contacts());

    /// Makes room for at least so many contacts, 170 bytes each.
    ///
    /// Fails with OUT_OF_MEMORY if there is not that much.
    change punctual_workspace_reserve_contacts(
        workspace: punctual_workspace, contacts: usize
    ) = {
        find_room([(contacts, size_of::<Contact>() + 3 * size_of::<u64>())])?;
        workspace.reserve_contacts(contacts)
    };
}

types! {
    /// The unit normals of a triangle of A and of one of B by the right-hand rule, in A's frame:
    /// which way the surfaces face.
    plain punctual_face_normals {
        /// That of the triangle of A; zeros if it has no area.
        a: punctual_point,
        /// That of the triangle of B; zeros if it has no area.
        b: punctual_point,
    }
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

lists! {
    /// The contacts that the last query found, if it was a contact query, without those drained:
    /// the nearest first.
    rows punctual_workspace_contacts(workspace: punctual_workspace)
        -> contacts: punctual_contact, contacts_size = workspace.contacts();
}
