//! The C interface, called as C calls it: every null pointer, length and number that is refused, with status and text; and
//! the answers of the Rust interface, field by field.

#[path = "../../../tests/common/allocations.rs"]
mod allocations;
#[path = "capi/call.rs"]
mod call;
#[path = "../../../tests/common/mod.rs"]
mod common;
#[path = "capi/contacts.rs"]
mod contacts;
#[path = "capi/distances.rs"]
mod distances;
#[path = "capi/manifolds.rs"]
mod manifolds;
#[path = "capi/motions.rs"]
mod motions;
#[path = "capi/near_points.rs"]
mod near_points;
#[path = "capi/penetration.rs"]
mod penetration;
#[path = "capi/points.rs"]
mod points;
#[path = "capi/queries.rs"]
mod queries;
#[path = "capi/rays.rs"]
mod rays;
#[path = "capi/refusals.rs"]
mod refusals;
#[path = "capi/remaining.rs"]
mod remaining;
#[path = "capi/robots.rs"]
mod robots;
#[path = "capi/scene_answers.rs"]
mod scene_answers;
#[path = "capi/scene_groups.rs"]
mod scene_groups;
#[path = "capi/scene_shapes.rs"]
mod scene_shapes;
#[path = "capi/scenes.rs"]
mod scenes;
#[path = "capi/surfaces.rs"]
mod surfaces;
#[path = "capi/tree_shapes.rs"]
mod tree_shapes;

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::null_mut;

use allocations::allocator_calls;
use call::*;
use punctual_capi::{punctual_status as Status, *};

#[test]
fn queries_do_not_allocate_even_if_they_fail() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let mut memory = owned(|out| punctual_memory_new(out));
    let mut broken = raw(&tilted());
    broken.m[0] = f64::NAN;
    let budgets = [
        punctual_budget_time(20_000),
        punctual_budget_work(5_000),
        punctual_budget_unlimited(),
    ];
    let calls = allocator_calls(|| {
        for (budget, i) in budgets
            .iter()
            .flat_map(|budget| [(*budget, 0), (*budget, 1)])
        {
            let (pose, tree) = ([raw(&tilted()), broken][i], Some(&*tree));
            let meets = punctual_query_new(tree, tree, pose);
            let (out, other) = (&mut MaybeUninit::uninit(), &mut MaybeUninit::uninit());
            // SAFETY: no clock of the caller's.
            let met = unsafe {
                let (space, known) = (Some(&mut *workspace), Some(&mut *memory));
                punctual_query_run(&meets, space, known, budget, None, slot(Some(out)))
            };
            let distance = punctual_distance_query_new(tree, tree, pose);
            // SAFETY: as above.
            let apart = unsafe {
                let (space, known) = (Some(&mut *workspace), Some(&mut *memory));
                punctual_distance_query_run(
                    &distance,
                    space,
                    known,
                    budget,
                    None,
                    slot(Some(other)),
                )
            };
            assert_eq!([met == Status::Ok, apart == Status::Ok], [i == 0; 2]);
        }
    });
    assert_eq!(calls, 0);
}

#[test]
fn the_number_of_bytes_of_a_tree_is_told_without_making_them() {
    let tree = tree_of(&knot());
    let mut count = MaybeUninit::uninit();
    let calls = allocator_calls(|| {
        // SAFETY: no room is claimed.
        let status =
            unsafe { punctual_tree_to_bytes(Some(&tree), null_mut(), 0, Some(&mut count)) };
        assert_eq!(status, Status::Ok);
    });
    assert_eq!(calls, 0);
    // SAFETY: written by the call.
    let count = unsafe { count.assume_init() };
    let mut bytes = vec![0; count];
    // SAFETY: there is room for as many as said.
    let written =
        made(|out| unsafe { punctual_tree_to_bytes(Some(&tree), bytes.as_mut_ptr(), count, out) });
    assert_eq!(written, count);
}

#[test]
fn each_thread_has_its_own_last_error() {
    refuses! { punctual_tree_validate(None) => null "tree"; }
    std::thread::spawn(|| assert_eq!(last_error(), ""))
        .join()
        .unwrap();
    assert_eq!(last_error(), "punctual_tree_validate: tree is null");
    // SAFETY: the text ends with a zero byte.
    let version = unsafe { CStr::from_ptr(punctual_version()) };
    assert_eq!(version.to_str().unwrap(), env!("CARGO_PKG_VERSION"));
}

/// Handles may go from thread to thread, and be read by several.
#[test]
fn handles_may_change_threads() {
    fn send_and_sync<T: Send + Sync>() {}
    send_and_sync::<punctual_mesh>();
    send_and_sync::<punctual_tree>();
    send_and_sync::<punctual_workspace>();
    send_and_sync::<punctual_memory>();
    send_and_sync::<punctual_scene>();
}
