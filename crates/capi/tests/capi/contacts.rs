//! Contact queries: the contacts, bounds and counters of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::call::*;
use super::queries::same_stats;
use punctual::contacts::{Contact, ContactBounds};
use punctual::{Answer, Query, StopReason, Workspace};
use punctual_capi::{punctual_status as Status, *};

const NO_CONTACT: punctual_contact = punctual_contact {
    triangles: punctual_triangle_pair { a: 0, b: 0 },
    points: [NO_POINT; 2],
    normal: NO_POINT,
    distance: 0.0,
    has_segment: false,
    segment: [NO_POINT; 2],
};

fn same(ours: &punctual_contacts, theirs: &Answer<ContactBounds>) {
    assert_eq!(
        (ours.low, ours.found),
        (theirs.value.low, theirs.stats.found)
    );
    same_stats(&ours.stats, &theirs.stats);
}

fn same_contact(ours: &punctual_contact, theirs: &Contact) {
    let point = |p: punctual_point| [p.x, p.y, p.z];
    assert_eq!([ours.triangles.a, ours.triangles.b], theirs.triangles);
    assert_eq!(ours.points.map(point), theirs.points.map(|p| p.to_array()));
    assert_eq!(
        (point(ours.normal), ours.distance),
        (theirs.normal.to_array(), theirs.distance)
    );
    let segment = ours.has_segment.then(|| ours.segment.map(point));
    assert_eq!(
        segment,
        theirs.segment.map(|ends| ends.map(|p| p.to_array()))
    );
}

fn run(
    query: &punctual_contact_query,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    out: Option<&mut MaybeUninit<punctual_contacts>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe { punctual_contact_query_run(asked(Some(query)), workspace, budget, None, slot(out)) }
}

fn resume(
    query: &punctual_contact_query,
    workspace: Option<&mut punctual_workspace>,
    budget: punctual_budget,
    out: Option<&mut MaybeUninit<punctual_contacts>>,
) -> Status {
    // SAFETY: no clock of the caller's.
    unsafe { punctual_contact_query_resume(asked(Some(query)), workspace, budget, None, slot(out)) }
}

/// Budgets that stop, lists that are full, and boxes of what was not found.
#[test]
fn contacts_are_those_of_rust() {
    let (ours, theirs) = knots();
    let (mut workspace, mut other) = workspaces();
    let (mut stops, mut touching, mut room) = (0, 0, vec![NO_CONTACT; 64]);
    for (margin, limit, work) in [
        (0.0, usize::MAX, 30_000),
        (0.02, 50, u64::MAX),
        (0.02, usize::MAX, u64::MAX),
    ] {
        let mut query = punctual_contact_query_new(Some(&ours), Some(&ours), raw(&tilted()));
        assert_eq!((query.margin, query.contact_limit), (0.0, usize::MAX));
        (query.margin, query.contact_limit) = (margin, limit);
        let native = Query::contacts(&theirs, &theirs, tilted())
            .margin(margin)
            .contact_limit(limit);
        let compare = |said: &_, told: &_, held: &mut punctual_workspace, other: &mut Workspace| {
            same(said, told);
            let (place, size) = (room.as_mut_ptr(), size_of::<punctual_contact>());
            // SAFETY: there is room for 64.
            let count = made(|out| unsafe {
                punctual_workspace_contacts(Some(held), place, size, 64, out)
            });
            assert_eq!(count, other.contacts().len());
            for (ours, theirs) in room.iter().zip(other.contacts()) {
                same_contact(ours, theirs);
                let faces = made(|out| unsafe {
                    punctual_contact_face_normals(asked(Some(&query)), ours.triangles, out)
                });
                let normals = [faces.a, faces.b].map(|n| Some([n.x, n.y, n.z].into()));
                assert_eq!(normals, native.face_normals(theirs.triangles));
                touching += usize::from(ours.has_segment);
            }
            same_certificate!(
                punctual_contact_query_certificate,
                punctual_contact_query_open_boxes,
                &query,
                held,
                native.certificate(other).unwrap()
            );
            if told.stop != StopReason::Finished {
                assert_eq!(punctual_workspace_drain_contacts(Some(held)), Status::Ok);
                drop(other.drain_contacts());
            }
        };
        stops += to_the_end!(
            punctual_contact_query_run, punctual_contact_query_resume, query, native, work,
            workspace, other; compare
        );
    }
    assert!(stops > 5 && touching > 50, "{stops} {touching}");
}

#[test]
fn room_is_made_for_contacts() {
    let mut workspace = owned(|out| punctual_workspace_new(out));
    works(punctual_workspace_reserve_contacts(
        Some(&mut workspace),
        10,
    ));
    refuses! {
        punctual_workspace_reserve_contacts(Some(&mut workspace), usize::MAX / 2)
            => OutOfMemory "punctual_workspace_reserve_contacts: there is not that much memory";
    }
    let tree = tree_of(&knot());
    let query = punctual_contact_query_new(Some(&tree), Some(&tree), raw(&tilted()));
    let said = made(|out| {
        run(
            &query,
            Some(&mut workspace),
            punctual_budget_unlimited(),
            out,
        )
    });
    assert_eq!(
        (said.stop, said.found),
        (punctual_stop_reason::PairsFull, 10)
    );
}

#[test]
fn nulls_and_numbers_are_refused_by_contact_queries() {
    let tree = tree_of(&knot());
    let query = punctual_contact_query_new(Some(&tree), Some(&tree), punctual_pose_identity());
    let budget = punctual_budget_unlimited();
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut out = MaybeUninit::uninit();
    refuses! {
        run(&punctual_contact_query { a: None, ..query }, None, budget, None) => null "query->a";
        run(&punctual_contact_query { b: None, ..query }, None, budget, None) => null "query->b";
        run(&query, None, budget, None) => null "outcome";
        run(&query, None, budget, Some(&mut out)) => null "workspace";
        resume(&query, None, budget, Some(&mut out)) => null "workspace";
        punctual_contact_query_certificate(asked(None), None, slot(None)) => null "query";
        punctual_contact_query_certificate(asked(Some(&query)), None, slot(None))
            => null "certificate";
    }
    let pair = punctual_triangle_pair { a: 0, b: u32::MAX };
    let mut normals = MaybeUninit::uninit();
    refuses! {
        punctual_contact_face_normals(asked(None), pair, Some(&mut normals)) => null "query";
        punctual_contact_face_normals(asked(Some(&query)), pair, None) => null "normals";
    }
    let text = format!(
        "punctual_contact_face_normals: triangles.b is 4294967295, but there are {}",
        made(|out| unsafe { punctual_tree_describe(Some(&tree), slot(out)) }).triangles
    );
    refuses! {
        punctual_contact_face_normals(asked(Some(&query)), pair, Some(&mut normals))
            => BadArgument &text;
        punctual_workspace_drain_contacts(None) => null "workspace";
        punctual_workspace_reserve_contacts(None, 1) => null "workspace";
    }
    refuses! {
        punctual_contact_query_open_boxes(asked(None), None, null_mut(), 0, None)
            => null "query";
        punctual_workspace_contacts(None, null_mut(), size_of::<punctual_contact>(), 0, None)
            => null "workspace";
        punctual_workspace_contacts(Some(&workspace), null_mut(), size_of::<punctual_contact>(), 0, None)
            => null "count";
    }
    for margin in [-1.0, f64::NAN] {
        refuses! {
            run(&punctual_contact_query { margin, ..query }, Some(&mut workspace), budget, Some(&mut out))
                => BadArgument &format!("punctual_contact_query_run: query->margin is {margin}, which is negative or no number");
        }
    }
}
