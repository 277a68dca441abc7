//! Rays and clearance: the answers of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use super::allocations::allocator_calls;
use super::call::*;
use super::queries::same_stats;
use punctual::glam::DVec3;
use punctual::rays::{RayBounds, RayHit, RayMode};
use punctual::{Answer, Budget, Pose, Query, Ray, StopReason, Workspace};
use punctual_capi::{punctual_status as Status, *};

const NO_HIT: punctual_ray_hit = punctual_ray_hit {
    triangle: PUNCTUAL_NO_TRIANGLE,
    side: punctual_side::Front,
    t: f64::INFINITY,
};

fn same_hit(ours: &punctual_ray_hit, theirs: Option<RayHit>) {
    match theirs {
        None => assert_eq!(*ours, NO_HIT),
        Some(hit) => {
            assert_eq!((ours.triangle, ours.t), (hit.triangle, hit.t));
            assert_eq!(format!("{:?}", ours.side), format!("{:?}", hit.side));
        }
    }
}

/// Half-lines, segments and rays with limits, by turns.
fn rays() -> Vec<(punctual_ray, Ray)> {
    let ray = |i: u32| {
        let angle = f64::from(i) * 0.37;
        let from = DVec3::new(4.0 * angle.cos(), 4.0 * angle.sin(), 0.3);
        let to = DVec3::new(0.2, -0.4 * angle.sin(), 0.1);
        let ours = punctual_ray_new(from.into(), (to - from).into());
        let theirs = Ray::new(from, to - from).unwrap();
        let limited = punctual_ray {
            t_min: 0.4,
            t_max: 1.5,
            ..ours
        };
        let segment = punctual_ray_segment(from.into(), to.into());
        match i % 3 {
            0 => (ours, theirs),
            1 => (segment, Ray::segment(from, to).unwrap()),
            _ => (limited, theirs.within(0.4, 1.5)),
        }
    };
    (0..60).map(ray).collect()
}

fn cast(
    query: &punctual_ray_query,
    resumes: bool,
    workspace: Option<&mut punctual_workspace>,
    work: u64,
    out: Option<&mut MaybeUninit<punctual_ray_cast>>,
) -> Status {
    let (query, budget, out) = (asked(Some(query)), punctual_budget_work(work), slot(out));
    // SAFETY: no clock of the caller's.
    unsafe {
        match resumes {
            true => punctual_ray_query_resume(query, workspace, budget, None, out),
            false => punctual_ray_query_run(query, workspace, budget, None, out),
        }
    }
}

fn batch(
    batch: &punctual_ray_batch,
    resumes: bool,
    workspace: Option<&mut punctual_workspace>,
    work: u64,
    hits: *mut punctual_ray_hit,
    out: Option<&mut MaybeUninit<punctual_ray_batch_outcome>>,
) -> Status {
    let (batch, budget, out) = (asked(Some(batch)), punctual_budget_work(work), slot(out));
    // SAFETY: null or as many rays and hits as said; no clock of the caller's.
    unsafe {
        match resumes {
            true => punctual_ray_batch_resume(batch, workspace, budget, None, hits, out),
            false => punctual_ray_batch_run(batch, workspace, budget, None, hits, out),
        }
    }
}

fn found(workspace: &punctual_workspace) -> Vec<punctual_ray_hit> {
    let mut hits = [NO_HIT; 64];
    // SAFETY: as long as said.
    let count = made(|out| unsafe {
        punctual_workspace_ray_hits(Some(workspace), hits.as_mut_ptr(), 64, out)
    });
    hits[..count].to_vec()
}

/// Each mode, budgets that stop and resume, hits that are drained because there is no room.
#[test]
fn rays_are_those_of_rust() {
    let (ours, theirs) = knots();
    let (mut workspace, mut other) = workspaces();
    works(punctual_workspace_reserve_ray_hits(Some(&mut workspace), 2));
    other.reserve_ray_hits(2);
    let (mut stops, mut full, mut hits) = (0, 0, 0);
    for mode in [RayMode::Nearest, RayMode::Any, RayMode::All] {
        for (raw, ray) in rays() {
            let query = punctual_ray_query {
                mode: mode as u32,
                solid: 1,
                ..punctual_ray_query_new(Some(&ours), raw)
            };
            let native = Query::ray(&theirs, ray).mode(mode).solid(true);
            let compare = |said: &punctual_ray_cast,
                           told: &Answer<RayBounds>,
                           held: &mut punctual_workspace,
                           other: &mut Workspace| {
                same_hit(&said.hit, told.value.hit);
                assert_eq!(
                    (said.found, said.free_until),
                    (told.stats.found, told.value.free_until)
                );
                same_stats(&said.stats, &told.stats);
                let inside = match told.value.starts_inside {
                    None => punctual_inside::Undecided,
                    Some(true) => punctual_inside::Yes,
                    Some(false) => punctual_inside::No,
                };
                assert_eq!(said.starts_inside, inside as u64);
                let listed = found(held);
                assert_eq!(listed.len(), other.ray_hits().len());
                listed
                    .iter()
                    .zip(other.ray_hits())
                    .for_each(|(ours, &theirs)| same_hit(ours, Some(theirs)));
                hits += listed.len();
                if told.stop == StopReason::PairsFull {
                    full += 1;
                    assert_eq!(punctual_workspace_drain_ray_hits(Some(held)), Status::Ok);
                    drop(other.drain_ray_hits());
                }
            };
            stops += to_the_end!(
                punctual_ray_query_run, punctual_ray_query_resume, query, native, 400,
                workspace, other; compare
            );
        }
    }
    assert!(stops > 20 && full > 5 && hits > 60, "{stops} {full} {hits}");
}

#[test]
fn batches_are_those_of_rust_and_do_not_allocate_again() {
    let (ours, theirs) = knots();
    let (mut workspace, mut other) = workspaces();
    let (raw, rays): (Vec<_>, Vec<_>) = rays().into_iter().unzip();
    for any in [false, true] {
        let mut asked = punctual_ray_batch_new(Some(&ours), raw.as_ptr(), raw.len());
        asked.mode = u32::from(any);
        let native = Query::rays(&theirs, &rays);
        let native = if any { native.any() } else { native };
        let mut hits = vec![NO_HIT; raw.len()];
        let room = hits.as_mut_ptr();
        let mut ours = |resumes, work| {
            made(|out| batch(&asked, resumes, Some(&mut workspace), work, room, out))
        };
        let mut said = ours(false, 5_000);
        let mut told = native.run(&mut other, Budget::work(5_000));
        let mut stops = 0;
        loop {
            assert_eq!(said.done, told.value);
            assert_eq!(format!("{:?}", said.stop), format!("{:?}", told.stop));
            same_stats(&said.stats, &told.stats);
            let both = hits.iter().zip(other.first_hits());
            both.for_each(|(ours, &theirs)| same_hit(ours, theirs));
            if said.done == raw.len() {
                break;
            }
            stops += 1;
            told = native.resume(&mut other, Budget::work(5_000)).unwrap();
            hits.fill(NO_HIT);
            said = ours(true, 5_000);
        }
        assert!(stops > 2, "{stops}");
        assert!(other.first_hits().iter().flatten().count() > 20);
        assert_eq!(allocator_calls(|| _ = ours(false, u64::MAX)), 0);
        // Another batch is not this one.
        ours(false, 1);
        let fewer = punctual_ray_batch {
            count: raw.len() - 1,
            ..asked
        };
        let mut out = MaybeUninit::uninit();
        refuses! { batch(&fewer, true, Some(&mut workspace), 9, room, Some(&mut out)) => NotResumable; }
    }
}

#[test]
fn bad_rays_are_refused_by_name() {
    let tree = tree_of(&knot());
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let (ray, mut out) = (rays()[0].0, MaybeUninit::uninit());
    let query = punctual_ray_query_new(Some(&tree), ray);
    refuses! {
        cast(&punctual_ray_query { tree: None, ..query }, false, None, 1, None)
            => null "query->tree";
        cast(&query, false, Some(&mut workspace), 1, None) => null "outcome";
        cast(&query, true, None, 1, Some(&mut out)) => null "workspace";
    }
    let (mut lost, mut still) = (ray, ray);
    lost.target.y = f64::NAN;
    (still.target, still.is_segment) = (ray.origin, 7);
    let lost_is = "y of the ray's direction or end is not finite";
    let still_is = "the ray's direction is zero, or both ends of the segment are one point";
    let name = "punctual_ray_query_run: query->";
    let mut run = |bad| cast(&bad, false, Some(&mut workspace), 1, Some(&mut out));
    refuses! {
        run(punctual_ray_query { ray: lost, ..query })
            => BadArgument &format!("{name}ray: {lost_is}");
        run(punctual_ray_query { ray: still, ..query })
            => BadArgument &format!("{name}ray: {still_is}");
        run(punctual_ray_query { mode: 3, ..query })
            => BadArgument &format!("{name}mode has no value 3");
    }
    let (mut many, mut hits, mut out) = ([ray; 3], [NO_HIT; 3], MaybeUninit::uninit());
    let asked = punctual_ray_batch_new(Some(&tree), many.as_ptr(), 3);
    let room = hits.as_mut_ptr();
    refuses! {
        batch(&punctual_ray_batch { tree: None, ..asked }, false, None, 1, room, None)
            => null "batch->tree";
        batch(&punctual_ray_batch { rays: null(), ..asked }, false, None, 1, room, None)
            => null "batch->rays";
        batch(&asked, false, None, 1, null_mut(), None) => null "hits";
        batch(&asked, false, Some(&mut workspace), 1, room, None) => null "outcome";
        batch(&asked, true, None, 1, room, Some(&mut out)) => null "workspace";
        batch(&punctual_ray_batch { mode: 2, ..asked }, false, Some(&mut workspace), 1, room, Some(&mut out))
            => BadArgument "punctual_ray_batch_run: batch->mode has no value 2";
    }
    many[1] = lost;
    let asked = punctual_ray_batch {
        rays: many.as_ptr(),
        ..asked
    };
    refuses! {
        batch(&asked, false, Some(&mut workspace), 1, room, Some(&mut out))
            => BadArgument "punctual_ray_batch_run: batch->rays[1]: y of the ray's direction or end is not finite";
        punctual_workspace_drain_ray_hits(None) => null "workspace";
        punctual_workspace_reserve_ray_hits(None, 1) => null "workspace";
        punctual_workspace_reserve_ray_hits(Some(&mut workspace), usize::MAX / 2)
            => OutOfMemory "punctual_workspace_reserve_ray_hits: there is not that much memory";
    }
    refuses! {
        punctual_workspace_ray_hits(None, null_mut(), 0, None) => null "workspace";
        punctual_workspace_ray_hits(Some(&workspace), null_mut(), 0, None) => null "count";
    }
}

#[test]
fn the_clearance_is_that_of_rust() {
    let (ours, theirs) = knots();
    let (mut workspace, mut other) = workspaces();
    let (mut memory, mut remembered) = memories();
    let at = |x: f64| Pose::new(tilted().rotation(), DVec3::new(x, 0.0, 0.0)).unwrap();
    let tree = Some(&*ours);
    let clearance = |memory: &punctual_memory, pose: &Pose| {
        made(|out| punctual_memory_clearance(Some(memory), tree, tree, raw(pose), out))
    };
    assert_eq!(clearance(&memory, &at(9.0)), 0.0);
    let query = punctual_distance_query_new(tree, tree, raw(&at(9.0)));
    let budget = punctual_budget_unlimited();
    made(|out| {
        let (query, out) = (asked(Some(&query)), slot(out));
        let (space, known) = (Some(&mut *workspace), Some(&mut *memory));
        // SAFETY: no clock of the caller's.
        unsafe { punctual_distance_query_run(query, space, known, budget, None, out) }
    });
    let pair = Query::distance(&theirs, &theirs, at(9.0));
    let known = pair.with_memory(&mut remembered);
    let distance = known.run(&mut other, Budget::unlimited());
    for x in [9.0, 8.0, 10.5, 2.0] {
        let expected = remembered.clearance(&theirs, &theirs, &at(x));
        assert_eq!(clearance(&memory, &at(x)), expected);
    }
    assert!(clearance(&memory, &at(9.0)) > 0.9 * distance.value.low);
    assert_eq!(clearance(&memory, &at(2.0)), 0.0);
    let (pose, mut out) = (raw(&at(9.0)), MaybeUninit::uninit());
    refuses! {
        punctual_memory_clearance(None, tree, tree, pose, Some(&mut out)) => null "memory";
        punctual_memory_clearance(Some(&memory), None, tree, pose, Some(&mut out)) => null "a";
        punctual_memory_clearance(Some(&memory), tree, None, pose, Some(&mut out)) => null "b";
        punctual_memory_clearance(Some(&memory), tree, tree, pose, None) => null "clearance";
    }
    let no_pose = punctual_pose { m: [0.0; 12] };
    refuses! {
        punctual_memory_clearance(Some(&memory), tree, tree, no_pose, Some(&mut out)) => BadPose;
    }
}
