//! What a stopped query of each question has still to do: as Rust tells it.

use super::call::*;
use punctual::engine::{Ask, Question};
use punctual::glam::DVec3;
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Motion, Query, Ray, StopReason, Tree, Workspace, shapes};
use punctual_capi::*;
use std::ptr::null;

/// What Rust tells of the query, stopped after 300 units.
fn told<'t, Q: Question>(query: &Query<'t, Q>) -> punctual_remaining
where
    Query<'t, Q>: Ask<Q>,
{
    let mut workspace = Workspace::new();
    let answer = query.run(&mut workspace, Budget::work(300));
    assert_eq!(answer.stop, StopReason::WorkLimit);
    let left = query.remaining(&workspace, None).unwrap();
    assert!(left.work.p50 > 0.0);
    punctual_remaining {
        size: size_of::<punctual_remaining>() as u32,
        work: left.work.into(),
        time: left.time.into(),
        probability: left.probability.unwrap_or(-1.0),
    }
}

#[test]
fn every_question_tells_what_is_left_as_rust_does() {
    let ours = solid_of(&knot());
    let options = BuildOptions::default().solid(Solid::Keep);
    let theirs = Tree::with_options(shapes::torus_knot(2, 3, 0.2, 96), &options);
    let (tree, pose) = (Some(&*ours), tilted());
    let (at, budget) = (raw(&pose), punctual_budget_work(300));
    let mut workspace = owned(|workspace| punctual_workspace_new(workspace));
    let check = |expected: punctual_remaining, left: punctual_remaining| {
        let probability = if left.probability.is_nan() {
            -1.0
        } else {
            left.probability
        };
        assert_eq!(
            punctual_remaining {
                probability,
                ..left
            },
            expected
        );
    };
    macro_rules! compare {
        ($query:expr, $native:expr, $run:ident($($memory:tt)?), $remaining:ident($($same:tt)?)) => {{
            let query = $query;
            // SAFETY: structs of the sizes that they say, no clock of the caller's.
            let left = unsafe {
                made(|out| $run(&raw const query, Some(&mut *workspace), $($memory,)? budget, None, slot(out)));
                made(|out| $remaining(&raw const query, Some(&*workspace), $($same,)? slot(out)))
            };
            check(told(&$native), left);
        }};
    }
    let mut query = punctual_query_new(tree, tree, at);
    query.mode = punctual_mode::All as u32;
    compare!(
        query,
        Query::all_pairs(&theirs, &theirs, pose),
        punctual_query_run(None),
        punctual_query_remaining(None)
    );
    compare!(
        punctual_distance_query_new(tree, tree, at),
        Query::distance(&theirs, &theirs, pose),
        punctual_distance_query_run(None),
        punctual_distance_query_remaining(None)
    );
    compare!(
        punctual_contact_query_new(tree, tree, at),
        Query::contacts(&theirs, &theirs, pose),
        punctual_contact_query_run(),
        punctual_contact_query_remaining()
    );
    compare!(
        punctual_manifold_query_new(tree, tree, at),
        Query::manifolds(&theirs, &theirs, pose),
        punctual_manifold_query_run(None),
        punctual_manifold_query_remaining(None)
    );
    let ray = Ray::new([-5.0, 0.1, 0.05], [1.0, 0.0, 0.0]).unwrap();
    let point = |v: DVec3| punctual_point::from(v);
    let raw_ray = punctual_ray_new(point(ray.origin()), point(DVec3::X));
    let mut query = punctual_ray_query_new(tree, raw_ray);
    query.mode = punctual_ray_mode::All as u32;
    compare!(
        query,
        Query::ray(&theirs, ray).mode(punctual::rays::RayMode::All),
        punctual_ray_query_run(),
        punctual_ray_query_remaining()
    );
    let way = DVec3::new(-3.0, 0.0, 0.0);
    let far = punctual::Pose::new(*pose.rotation(), DVec3::new(8.0, 0.0, 0.0)).unwrap();
    let motion = Motion::straight(far, way).unwrap();
    let theirs_moves = punctual_motion_straight(raw(&far), point(way));
    compare!(
        punctual_motion_query_new(tree, tree, theirs_moves),
        Query::impact(&theirs, &theirs, motion),
        punctual_motion_query_run(None),
        punctual_motion_query_remaining(None)
    );
    let (rays, raw_rays) = ([ray; 20], [raw_ray; 20]);
    let batch = punctual_ray_batch_new(tree, raw_rays.as_ptr(), 20);
    let mut hits = Vec::with_capacity(20);
    // SAFETY: as above, and there is room for all hits.
    let left = unsafe {
        made(|out| {
            let held = Some(&mut *workspace);
            punctual_ray_batch_run(
                &raw const batch,
                held,
                budget,
                None,
                hits.as_mut_ptr(),
                slot(out),
            )
        });
        made(|out| punctual_ray_batch_remaining(&raw const batch, Some(&*workspace), slot(out)))
    };
    check(told(&Query::rays(&theirs, &rays)), left);
    let points = [[0.1, 0.2, 0.3]; 20];
    let (places, mut bounds) = (points.as_ptr().cast(), Vec::with_capacity(20));
    // SAFETY: the same of points.
    let left = unsafe {
        made(|out| {
            let (held, out) = (Some(&mut *workspace), slot(out));
            punctual_points_run(
                tree,
                places,
                20,
                1,
                held,
                budget,
                None,
                bounds.as_mut_ptr(),
                out,
            )
        });
        made(|out| punctual_points_remaining(tree, places, 20, 1, Some(&*workspace), slot(out)))
    };
    check(
        told(&Query::signed_distances(&theirs, &points).unwrap()),
        left,
    );
    // SAFETY: no array is read.
    let status =
        unsafe { punctual_points_remaining(tree, null(), 0, 0, Some(&*workspace), slot(None)) };
    assert_ne!(status, punctual_status::Ok);
}
