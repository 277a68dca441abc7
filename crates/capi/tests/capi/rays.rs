//! Rays and clearance: the answers of Rust, and everything that is refused.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use super::allocations::allocator_calls;
use super::call::*;
use super::queries::same_stats;
use punctual::glam::DVec3;
use punctual::rays::{RayBounds, RayHit, RayMode};
use punctual::{Answer, Budget, PairMemory, Pose, Query, Ray, StopReason, Tree, Workspace, shapes};
use punctual_capi::{punctual_status as Status, *};

const NO_HIT: punctual_ray_hit = punctual_ray_hit {
    triangle: PUNCTUAL_NO_TRIANGLE,
    side: punctual_side::Front,
    t: f64::INFINITY,
};

fn point([x, y, z]: [f64; 3]) -> punctual_point {
    punctual_point { x, y, z }
}

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
        let (from, to) = (
            [4.0 * angle.cos(), 4.0 * angle.sin(), 0.3],
            [0.2, -0.4 * angle.sin(), 0.1],
        );
        let direction = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        match i % 3 {
            0 => (
                punctual_ray_new(point(from), point(direction)),
                Ray::new(from, direction).unwrap(),
            ),
            1 => (
                punctual_ray_segment(point(from), point(to)),
                Ray::segment(from, to).unwrap(),
            ),
            _ => {
                let ours = punctual_ray_new(point(from), point(direction));
                let theirs = Ray::new(from, direction).unwrap().within(0.4, 1.5);
                (
                    punctual_ray {
                        t_min: 0.4,
                        t_max: 1.5,
                        ..ours
                    },
                    theirs,
                )
            }
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
    let budget = punctual_budget_work(work);
    // SAFETY: no clock of the caller's.
    unsafe {
        match resumes {
            true => {
                punctual_ray_query_resume(asked(Some(query)), workspace, budget, None, slot(out))
            }
            false => punctual_ray_query_run(asked(Some(query)), workspace, budget, None, slot(out)),
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
    let budget = punctual_budget_work(work);
    // SAFETY: null or as many rays and hits as said; no clock of the caller's.
    unsafe {
        match resumes {
            true => punctual_ray_batch_resume(
                asked(Some(batch)),
                workspace,
                budget,
                None,
                hits,
                slot(out),
            ),
            false => {
                punctual_ray_batch_run(asked(Some(batch)), workspace, budget, None, hits, slot(out))
            }
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
    let (ours, theirs) = (
        tree_of(&knot()),
        Tree::new(shapes::torus_knot(2, 3, 0.2, 96)),
    );
    let (mut workspace, mut other) = (owned(|out| punctual_workspace_new(out)), Workspace::new());
    assert_eq!(
        punctual_workspace_reserve_ray_hits(Some(&mut workspace), 2),
        Status::Ok
    );
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
    let (ours, theirs) = (
        tree_of(&knot()),
        Tree::new(shapes::torus_knot(2, 3, 0.2, 96)),
    );
    let (mut workspace, mut other) = (owned(|out| punctual_workspace_new(out)), Workspace::new());
    let (raw, rays): (Vec<_>, Vec<_>) = rays().into_iter().unzip();
    for any in [false, true] {
        let mut asked = punctual_ray_batch_new(Some(&ours), raw.as_ptr(), raw.len());
        asked.mode = u32::from(any);
        let native = Query::rays(&theirs, &rays);
        let native = if any { native.any() } else { native };
        let mut told = native.run(&mut other, Budget::work(5_000));
        let mut hits = vec![NO_HIT; raw.len()];
        let mut said = made(|out| {
            batch(
                &asked,
                false,
                Some(&mut workspace),
                5_000,
                hits.as_mut_ptr(),
                out,
            )
        });
        let mut stops = 0;
        loop {
            assert_eq!(said.done, told.value);
            assert_eq!(format!("{:?}", said.stop), format!("{:?}", told.stop));
            same_stats(&said.stats, &told.stats);
            hits.iter()
                .zip(other.first_hits())
                .for_each(|(ours, &theirs)| same_hit(ours, theirs));
            if said.done == raw.len() {
                break;
            }
            stops += 1;
            told = native.resume(&mut other, Budget::work(5_000)).unwrap();
            // Another batch is not this one.
            let fewer = punctual_ray_batch {
                count: raw.len() - 1,
                ..asked
            };
            let mut out = MaybeUninit::uninit();
            let status = batch(
                &fewer,
                true,
                Some(&mut workspace),
                9,
                hits.as_mut_ptr(),
                Some(&mut out),
            );
            assert_eq!(status, Status::NotResumable);
            hits.fill(NO_HIT);
            said = made(|out| {
                batch(
                    &asked,
                    true,
                    Some(&mut workspace),
                    5_000,
                    hits.as_mut_ptr(),
                    out,
                )
            });
        }
        assert!(
            stops > 2 && other.first_hits().iter().flatten().count() > 20,
            "{stops}"
        );
        let mut out = MaybeUninit::uninit();
        let calls = allocator_calls(|| {
            let status = batch(
                &asked,
                false,
                Some(&mut workspace),
                u64::MAX,
                hits.as_mut_ptr(),
                Some(&mut out),
            );
            assert_eq!(status, Status::Ok);
        });
        assert_eq!(calls, 0);
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
    let lost = punctual_ray {
        target: punctual_point {
            x: 0.0,
            y: f64::NAN,
            z: 0.0,
        },
        ..ray
    };
    let still = punctual_ray {
        target: ray.origin,
        is_segment: 7,
        ..ray
    };
    for (bad, text) in [
        (
            punctual_ray_query { ray: lost, ..query },
            "query->ray: y of the ray's direction or end is not finite",
        ),
        (
            punctual_ray_query {
                ray: still,
                ..query
            },
            "query->ray: the ray's direction is zero, or both ends of the segment are one point",
        ),
        (
            punctual_ray_query { mode: 3, ..query },
            "query->mode has no value 3",
        ),
    ] {
        refuses! {
            cast(&bad, false, Some(&mut workspace), 1, Some(&mut out))
                => BadArgument &format!("punctual_ray_query_run: {text}");
        }
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
    let (ours, theirs) = (
        tree_of(&knot()),
        Tree::new(shapes::torus_knot(2, 3, 0.2, 96)),
    );
    let (mut workspace, mut other) = (owned(|out| punctual_workspace_new(out)), Workspace::new());
    let (mut memory, mut remembered) = (owned(|out| punctual_memory_new(out)), PairMemory::new());
    let at = |x: f64| Pose::new(tilted().rotation(), DVec3::new(x, 0.0, 0.0)).unwrap();
    let tree = Some(&*ours);
    let clearance = |memory: &punctual_memory, pose: &Pose| {
        made(|out| punctual_memory_clearance(Some(memory), tree, tree, raw(pose), out))
    };
    assert_eq!(clearance(&memory, &at(9.0)), 0.0);
    let query = punctual_distance_query_new(tree, tree, raw(&at(9.0)));
    made(|out| {
        let (space, known) = (Some(&mut *workspace), Some(&mut *memory));
        // SAFETY: no clock of the caller's.
        unsafe {
            punctual_distance_query_run(
                asked(Some(&query)),
                space,
                known,
                punctual_budget_unlimited(),
                None,
                slot(out),
            )
        }
    });
    let pair = Query::distance(&theirs, &theirs, at(9.0));
    let distance = pair
        .with_memory(&mut remembered)
        .run(&mut other, Budget::unlimited());
    for x in [9.0, 8.0, 10.5, 2.0] {
        assert_eq!(
            clearance(&memory, &at(x)),
            remembered.clearance(&theirs, &theirs, &at(x))
        );
    }
    assert!(
        clearance(&memory, &at(9.0)) > 0.9 * distance.value.low
            && clearance(&memory, &at(2.0)) == 0.0
    );
    let (pose, mut out) = (raw(&at(9.0)), MaybeUninit::uninit());
    refuses! {
        punctual_memory_clearance(None, tree, tree, pose, Some(&mut out)) => null "memory";
        punctual_memory_clearance(Some(&memory), None, tree, pose, Some(&mut out)) => null "a";
        punctual_memory_clearance(Some(&memory), tree, None, pose, Some(&mut out)) => null "b";
        punctual_memory_clearance(Some(&memory), tree, tree, pose, None) => null "clearance";
    }
    let no_pose = punctual_pose { m: [0.0; 12] };
    assert_eq!(
        punctual_memory_clearance(Some(&memory), tree, tree, no_pose, Some(&mut out)),
        Status::BadPose
    );
}
