//! The points within a distance, each once, against brute force in `f64`. What `f64` cannot decide
//! may be in the answer or not.

use super::{ENOUGH, each};
use crate::common::reference::{all_pairs, posed_triangles};
use punctual::clock::ManualClock;
use punctual::glam::DVec3;
use punctual::points::{PointError, PointsWithin};
use punctual::{Aabb, Budget, Pose, Query, StopReason, Tree, Workspace, shapes};
use std::collections::BTreeSet;

/// The closest point of a triangle, by its regions; independent of the library.
fn foot(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let of_edge = |a: DVec3, b: DVec3| {
        let square = (b - a).length_squared();
        let along = if square > 0.0 {
            (p - a).dot(b - a) / square
        } else {
            0.0
        };
        a.lerp(b, along.clamp(0.0, 1.0))
    };
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let inside = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) >= 0.0;
    let mut feet = vec![of_edge(a, b), of_edge(b, c), of_edge(c, a)];
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        feet.push(p - normal * (p - a).dot(normal));
    }
    let nearest = feet.into_iter().min_by(|x, y| {
        let of = |foot: &DVec3| foot.distance_squared(p);
        of(x).total_cmp(&of(y))
    });
    nearest.unwrap()
}

/// Of each point, the closest point of the other operand, and their distance.
pub fn truth(cloud: &Tree, other: &Tree, pose: &Pose) -> Vec<(DVec3, f64)> {
    let triangles = posed_triangles(other.mesh(), pose);
    let of = |i| {
        let point = cloud.mesh().vertex(i);
        let feet = triangles.iter().map(|triangle| {
            let foot = foot(point, *triangle);
            (foot, foot.distance(point))
        });
        feet.min_by(|x, y| x.1.total_cmp(&y.1)).unwrap()
    };
    (0..cloud.mesh().len()).map(of).collect()
}

/// More than the rounding of [`truth`].
const ROUNDING: f64 = 1e-11;

/// Points within a reach, as far as the brute force knows, and those that may be.
fn sets(truth: &[(DVec3, f64)], reach: f64) -> [BTreeSet<u32>; 2] {
    [reach - ROUNDING, reach + ROUNDING].map(|reach| {
        let near = (0..).zip(truth).filter(|(_, near)| near.1 <= reach);
        near.map(|(id, _)| id).collect()
    })
}

/// Runs a query to its end in steps, drains as it is full, and tells all points, each once.
fn drained(query: &Query<PointsWithin>, step: Budget, workspace: &mut Workspace) -> BTreeSet<u32> {
    let clock = &ManualClock::new();
    let mut all = BTreeSet::new();
    let mut answer = query.run(workspace, step.clock(clock));
    loop {
        if answer.stop == StopReason::PairsFull || answer.stop.is_final() {
            for id in workspace.drain_near_points() {
                assert!(all.insert(id), "{id} twice");
            }
        }
        assert_eq!(answer.value, answer.stats.found);
        match query.resume(workspace, step.clock(clock)) {
            Ok(next) => answer = next,
            Err(_) => break,
        }
    }
    assert_eq!(
        (answer.stop, answer.value),
        (StopReason::Finished, all.len() as u64)
    );
    all
}

#[test]
fn each_point_within_is_found_once_wherever_a_query_stops() {
    let workspace = &mut Workspace::new();
    let portable = &mut Workspace::new();
    portable.use_portable_kernels();
    let clock = &ManualClock::new();
    each(|[cloud, other], _, pose| {
        if !cloud.is_cloud() || cloud.mesh().len() * other.mesh().len() > 2_000_000 {
            return;
        }
        let truth = truth(cloud, other, &pose);
        for reach in [1e-9, 0.003, 0.05, 0.7, 1e9, f64::INFINITY] {
            let [least, most] = sets(&truth, reach);
            let query = Query::points_within(cloud, other, pose, reach).unwrap();
            let all = drained(&query, ENOUGH, workspace);
            assert!(all.is_superset(&least) && all.is_subset(&most), "{reach}");
            let work = workspace.stats();
            assert_eq!(drained(&query, ENOUGH, portable), all);
            assert_eq!(portable.stats().work, work.work);
            assert_eq!(drained(&query, Budget::work(170), workspace), all);
            assert_eq!(workspace.stats().work, work.work);
            for limit in [1, 3] {
                let few = query.point_limit(limit);
                assert_eq!(drained(&few, Budget::work(900), workspace), all);
            }
            let mut found = 0;
            for budget in [0, 1, 200, 5000, 10_000, 20_000] {
                let answer = query.run(workspace, Budget::work(budget).clock(clock));
                assert!(answer.value >= found, "twice the budget finds less");
                found = answer.value;
                let near: BTreeSet<_> = workspace.near_points().iter().copied().collect();
                assert!(near.len() as u64 == found && near.is_subset(&all));
                let open = query.certificate(workspace).unwrap();
                assert!(open.upper_bound() >= least.len() as u64);
                assert!(open.open_pairs() > 0 || answer.stop == StopReason::Finished);
                let boxes: Vec<Aabb> = open.boxes().collect();
                for &id in least.difference(&near).take(20) {
                    let middle = cloud
                        .mesh()
                        .vertex(id as usize)
                        .midpoint(truth[id as usize].0);
                    let holds = |open: &Aabb| {
                        let open = Aabb {
                            min: open.min - ROUNDING,
                            max: open.max + ROUNDING,
                        };
                        open.contains(middle)
                    };
                    assert!(reach > 1e8 || boxes.iter().any(holds), "{id}");
                }
            }
        }
    });
}

#[test]
fn without_a_distance_the_points_on_the_surface_are_found_exactly() {
    let workspace = &mut Workspace::new();
    each(|[cloud, other], _, pose| {
        if cloud.is_cloud() {
            let pairs = all_pairs(cloud.mesh(), other.mesh(), &pose);
            let on: BTreeSet<_> = pairs.iter().map(|pair| pair[0]).collect();
            let query = Query::points_within(cloud, other, pose, 0.0).unwrap();
            assert_eq!(drained(&query, ENOUGH, workspace), on);
        }
    });
}

#[test]
fn radii_of_both_add_to_the_distance() {
    let workspace = &mut Workspace::new();
    let grid = (-9..9).flat_map(|x| (-9..9).map(move |y| [f64::from(x), f64::from(y), 0.1]));
    let grid = grid.map(|p| p.map(|x| x * 0.3));
    let cloud = Tree::from_points_f64(grid).unwrap();
    let ball = Tree::new(shapes::icosphere(3));
    let near = |cloud: &Tree, ball: &Tree, reach, workspace: &mut Workspace| {
        let query = Query::points_within(cloud, ball, Pose::IDENTITY, reach).unwrap();
        drained(&query, ENOUGH, workspace)
    };
    let plain = near(&cloud, &ball, 0.25, workspace);
    let (thick, fat) = (
        cloud.clone().with_radius(0.1),
        ball.clone().with_radius(0.15),
    );
    let thick = [thick.unwrap(), fat.unwrap()];
    assert_eq!(near(&thick[0], &thick[1], 0.0, workspace), plain);
    assert!(!plain.is_empty() && plain.len() < cloud.mesh().len());
}

#[test]
fn what_cannot_be_asked_is_refused_and_what_is_empty_is_answered() {
    let workspace = &mut Workspace::new();
    let (ball, none) = (
        Tree::new(shapes::icosphere(2)),
        Tree::from_points([[0.0_f32; 3]; 0]).unwrap(),
    );
    let pose = Pose::IDENTITY;
    let refused = Query::points_within(&ball, &none, pose, 1.0).unwrap_err();
    assert_eq!(refused, PointError::NotCloud);
    let query = Query::points_within(&none, &ball, pose, 1.0).unwrap();
    assert_eq!(drained(&query, ENOUGH, workspace), BTreeSet::new());
    let cloud = Tree::from_points([[0.0, 0.0, 1.01]]).unwrap();
    let query = Query::points_within(&cloud, &none, pose, f64::INFINITY).unwrap();
    assert_eq!(drained(&query, ENOUGH, workspace), BTreeSet::new());
    for wrong in [-1.0, f64::NAN] {
        let query = Query::points_within(&cloud, &ball, pose, wrong).unwrap();
        assert_eq!(query.checked().unwrap_err().argument, "distance");
        assert_eq!(drained(&query, ENOUGH, workspace), BTreeSet::new());
    }
    // Another question in between leaves no marks, and is not continued.
    let near = Query::points_within(&cloud, &ball, pose, 0.1).unwrap();
    for _ in 0..2 {
        assert_eq!(drained(&near, ENOUGH, workspace), BTreeSet::from([0]));
        let _ = near.run(workspace, Budget::work(0).clock(&ManualClock::new()));
        let distance = Query::distance(&cloud, &ball, pose);
        let _ = distance.run(workspace, ENOUGH.clock(&ManualClock::new()));
        assert!(
            near.resume(workspace, ENOUGH.clock(&ManualClock::new()))
                .is_err()
        );
        assert!(workspace.near_points().is_empty());
    }
}

#[test]
fn far_from_the_origin_and_of_all_sizes() {
    let workspace = &mut Workspace::new();
    let mut random = crate::common::random::Random::new(9);
    for (far, size) in [
        (0.0, 1e-30),
        (0.0, 1e30),
        (1e3, 1.0),
        (1e9, 1.0),
        (1e15, 1.0),
    ] {
        let points: Vec<_> = (0..500).map(|_| random.vector() * 2.0 * size).collect();
        let points = points.iter().map(|point| *point + DVec3::splat(far));
        let cloud = Tree::from_points_f64(points).unwrap();
        let ball = Tree::new(shapes::icosphere(2)).scaled([size; 3]).unwrap();
        let pose = Pose::new(random.rotation(), DVec3::splat(far)).unwrap();
        let truth = truth(&cloud, &ball, &pose);
        let reach = 0.1 * size;
        let band = (far + size) * 1e-13;
        let query = Query::points_within(&cloud, &ball, pose, reach).unwrap();
        let all = drained(&query, ENOUGH, workspace);
        for (id, (_, distance)) in (0..).zip(truth) {
            let is_clear = (distance - reach).abs() > band;
            assert!(
                !is_clear || all.contains(&id) == (distance <= reach),
                "{far} {size} {id}"
            );
        }
    }
}
