//! Points of a cloud near a surface, and clouds of depth images: as in Rust, and what is refused.

use std::ptr::null;

use super::call::*;
use punctual::{DepthCamera, Pose, Query, StopReason, Tree, Workspace};
use punctual_capi::{punctual_status as Status, *};

const CAMERA: punctual_depth_camera = punctual_depth_camera {
    width: 80,
    height: 60,
    focal: [70.0, -70.0],
    center: [39.5, 29.5],
    scale: 0.001,
};

/// A wall with a bump, and pixels without a depth.
fn depths() -> Vec<f32> {
    let pixel = |k: usize| {
        let (x, y) = ((k % 80) as f32 - 40.0, (k / 80) as f32 - 30.0);
        if k.is_multiple_of(7) {
            f32::NAN
        } else {
            2000.0 - (900.0 - x * x - y * y).max(0.0)
        }
    };
    (0..80 * 60).map(pixel).collect()
}

fn cloud(radius: f64) -> Box<punctual_tree> {
    let depths = depths();
    // SAFETY: an array as long as said.
    owned(|out| unsafe {
        punctual_tree_from_depth(CAMERA, depths.as_ptr(), depths.len(), radius, out)
    })
}

fn cloud_of_rust() -> Tree {
    let punctual_depth_camera {
        width,
        height,
        focal,
        center,
        scale,
    } = CAMERA;
    let mut points = Vec::new();
    let camera = DepthCamera {
        size: [width, height],
        focal,
        center,
        scale,
    };
    camera.points(&depths(), &mut points).unwrap();
    assert!(points.len() > 4000 && points.len() < 80 * 60);
    Tree::from_points(points).unwrap()
}

/// Budgets that stop, lists that are full, and boxes of what was not found.
#[test]
fn near_points_are_those_of_rust() {
    let (ours, ball) = (cloud(0.01), owned(|out| punctual_tree_ball(0.3, out)));
    let theirs = [
        cloud_of_rust().with_radius(0.01).unwrap(),
        Tree::ball(0.3).unwrap(),
    ];
    let pose = Pose::from_row_major([1.0, 0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
    let pose = pose.unwrap();
    let (mut workspace, mut other) = (owned(|out| punctual_workspace_new(out)), Workspace::new());
    let (mut stops, mut seen, mut room) = (0, 0, [0; 64]);
    for (distance, limit, work) in [
        (0.2, usize::MAX, 20_000),
        (0.2, 20, u64::MAX),
        (0.0, usize::MAX, u64::MAX),
    ] {
        let mut query = punctual_near_points_query_new(Some(&ours), Some(&ball), raw(&pose));
        assert_eq!((query.distance, query.point_limit), (0.0, usize::MAX));
        (query.distance, query.point_limit) = (distance, limit);
        let native = Query::points_within(&theirs[0], &theirs[1], pose, distance).unwrap();
        let native = native.point_limit(limit);
        let compare = |said: &punctual_near_points,
                       told: &punctual::Answer<u64>,
                       held: &mut punctual_workspace,
                       other: &mut Workspace| {
            assert_eq!((said.found, said.stats.work), (told.value, told.stats.work));
            // SAFETY: there is room for 64.
            let count = made(|out| unsafe {
                punctual_workspace_near_points(Some(held), room.as_mut_ptr(), 64, out)
            });
            let some = count.min(64);
            assert_eq!(
                (&room[..some], count),
                (&other.near_points()[..some], other.near_points().len())
            );
            let left = made(|out| unsafe {
                punctual_near_points_query_remaining(asked(&query), Some(held), slot(out))
            });
            assert_eq!(
                left.work.p50,
                native.remaining(other, None).unwrap().work.p50
            );
            same_certificate!(
                punctual_near_points_query_certificate,
                punctual_near_points_query_open_boxes,
                &query,
                held,
                native.certificate(other).unwrap()
            );
            seen = told.value;
            if told.stop != StopReason::Finished {
                assert_eq!(punctual_workspace_drain_near_points(Some(held)), Status::Ok);
                drop(other.drain_near_points());
            }
        };
        stops += to_the_end!(
            punctual_near_points_query_run, punctual_near_points_query_resume, query, native, work,
            workspace, other; compare
        );
        assert!(seen > 50, "{distance}: {seen}");
    }
    assert!(stops > 5, "{stops}");
}

#[test]
fn bad_clouds_and_distances_are_refused() {
    let (tree, ball) = (cloud(0.0), owned(|out| punctual_tree_ball(0.3, out)));
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let query = punctual_near_points_query_new(Some(&tree), Some(&ball), punctual_pose_identity());
    let mut run = |query: &punctual_near_points_query| {
        let mut out = std::mem::MaybeUninit::uninit();
        let (held, all) = (Some(&mut *workspace), punctual_budget_unlimited());
        // SAFETY: no clock of the caller's.
        unsafe { punctual_near_points_query_run(query, held, all, None, slot(Some(&mut out))) }
    };
    refuses! {
        run(&punctual_near_points_query { a: None, ..query }) => null "query->a";
        run(&punctual_near_points_query { a: Some(&ball), ..query }) => BadArgument
            "punctual_near_points_query_run: the tree is not that of a point cloud, see punctual_tree_from_points_f32";
        run(&punctual_near_points_query { distance: -1.0, ..query }) => BadArgument
            "punctual_near_points_query_run: query->distance is -1, which is negative or no number";
        punctual_workspace_reserve_near_points(Some(&mut workspace), usize::MAX / 2)
            => OutOfMemory "punctual_workspace_reserve_near_points: there is not that much memory";
        punctual_workspace_drain_near_points(None) => null "workspace";
    }
    let (depths, [mut a, mut b, mut c, mut d]) =
        (depths(), [(); 4].map(|()| std::mem::MaybeUninit::uninit()));
    let count = depths.len();
    let make = |camera, depths, count, radius, out| {
        // SAFETY: null or as long as said.
        unsafe { punctual_tree_from_depth(camera, depths, count, radius, Some(out)) }
    };
    let blind = punctual_depth_camera {
        focal: [0.0, 1.0],
        ..CAMERA
    };
    refuses! {
        make(CAMERA, null(), 1, 0.0, &mut a) => null "depths";
        make(CAMERA, depths.as_ptr(), count - 1, 0.0, &mut b)
            => BadArgument "punctual_tree_from_depth: 4799 depths for an image of 80 x 60 pixels";
        make(blind, depths.as_ptr(), count, 0.0, &mut c)
            => BadArgument "punctual_tree_from_depth: focal[0] is 0 or not finite";
        make(CAMERA, depths.as_ptr(), count, -1.0, &mut d)
            => BadArgument "punctual_tree_from_depth: radius is -1, which is negative or no number";
    }
}
