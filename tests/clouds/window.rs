//! Windows: whenever a frame is done, the tree has the newest points, and answers as brute force
//! does; before that it is the tree of the frames before.

use super::near::truth;
use crate::common::random::Random;
use punctual::clock::ManualClock;
use punctual::glam::DMat3;
use punctual::tree::PointWindow;
use punctual::{Budget, MeshError, Pose, Query, Tree, Workspace, shapes};
use std::sync::Arc;
use std::time::Duration;

const ALL: Budget = Budget::unlimited();

/// Points about the unit cube, which moves along; some are equal, and one frame is far away.
fn frame(random: &mut Random, count: usize, number: usize) -> Vec<[f32; 3]> {
    let drift = if number == 5 {
        1e6
    } else {
        0.1 * number as f64
    };
    let point = |random: &mut Random| match random.below(8) {
        0 => [1.5, -0.25, 0.0],
        _ => (random.vector() + drift).as_vec3().to_array(),
    };
    (0..count).map(|_| point(random)).collect()
}

/// Checks that a window has the newest of `all` points, and that its tree answers for them.
fn check(window: &PointWindow, all: &[[f32; 3]], capacity: usize) {
    let tree = window.tree();
    assert_eq!(tree.validate(), Ok(()));
    let count = all.len().min(capacity);
    assert_eq!(tree.mesh().len(), count);
    let mut seen = vec![false; count];
    for id in 0..count as u32 {
        let number = window.number(id) as usize;
        let expected = all[number].map(f64::from);
        assert_eq!(tree.mesh().vertex(id as usize).to_array(), expected);
        seen[number - (all.len() - count)] = true;
    }
    assert!(seen.into_iter().all(|seen| seen));
    let fresh = Tree::from_points(all[all.len() - count..].iter().copied()).unwrap();
    assert_eq!(fresh.mesh().aabb(), tree.mesh().aabb());
    let loaded = Tree::from_bytes(&tree.to_bytes()).unwrap();
    assert_eq!(loaded.to_bytes(), tree.to_bytes());

    let tool = Tree::new(shapes::icosphere(1));
    let center = all.last().map_or([0.0; 3], |point| point.map(f64::from));
    let pose = Pose::new(DMat3::IDENTITY, center).unwrap();
    let truth = truth(tree, &tool, &pose);
    let mut workspace = Workspace::new();
    for reach in [0.05, 0.6] {
        let query = Query::points_within(tree, &tool, pose, reach).unwrap();
        let found = query.run(&mut workspace, ALL).value;
        let near = truth.iter().filter(|(_, gap)| *gap <= reach).count();
        assert_eq!(found, near as u64);
        for &id in workspace.near_points() {
            assert!(truth[id as usize].1 <= reach + 1e-11);
        }
    }
    let query = Query::distance(tree, &tool, pose);
    let found = query.run(&mut workspace, ALL).value;
    let low = truth
        .iter()
        .map(|near| near.1)
        .fold(f64::INFINITY, f64::min);
    assert!(found.low <= low + 1e-9 && low <= found.high + 1e-9);
    assert!(found.high - found.low <= 1e-5 * tree.unit_length().max(1.0) || count == 0);
}

/// How many points had been inserted when the tree was done.
fn inserted(window: &PointWindow) -> usize {
    let ids = 0..window.tree().mesh().len() as u32;
    ids.map(|id| window.number(id) as usize + 1)
        .max()
        .unwrap_or(0)
}

#[test]
fn a_window_has_its_newest_points_wherever_it_is_stopped() {
    let mut random = Random::new(661);
    for capacity in [0, 1, 7, 8, 65, 500, 3000] {
        let [mut whole, mut cut] = [(); 2].map(|()| PointWindow::new(capacity, 3.0).unwrap());
        let (mut all, mut ends) = (Vec::new(), vec![0]);
        for number in 0..12 {
            let most = if number == 7 { 4000 } else { 600 };
            let count = random.below(most);
            let points = frame(&mut random, count, number);
            all.extend_from_slice(&points);
            ends.push(all.len());
            whole.insert(&points).unwrap();
            assert!(whole.advance(ALL));
            check(&whole, &all, capacity);
            // Every third frame is not done when the next one comes.
            cut.insert(&points).unwrap();
            let mut calls = 2 + random.below(8);
            let mut is_done = false;
            while !is_done && calls > 0 {
                let before = cut.tree().identity();
                let work = [0, 1, 1999, 2000, 5000, 60_000][random.below(6)];
                is_done = cut.advance(Budget::work(work));
                assert!(work > 0 || cut.tree().identity() == before);
                let done = inserted(&cut);
                assert!(ends.contains(&done));
                if !is_done && (calls < 3 || cut.tree().identity() != before) {
                    check(&cut, &all[..done], capacity);
                }
                calls -= usize::from(number % 3 == 0);
            }
            if is_done {
                // Its bits do not depend on the budgets.
                assert_eq!(cut.tree().to_bytes(), whole.tree().to_bytes());
                let ids = 0..cut.tree().mesh().len() as u32;
                assert!(ids.into_iter().all(|id| cut.number(id) == whole.number(id)));
            }
        }
        while !cut.advance(Budget::work(1)) {}
        assert_eq!(cut.tree().to_bytes(), whole.tree().to_bytes());
    }
}

#[test]
fn a_window_keeps_its_tree_whatever_is_held_and_refuses_what_no_point_is() {
    let mut random = Random::new(662);
    let mut window = PointWindow::new(200, 2.0).unwrap();
    let mut held = Vec::new();
    for number in 0..6 {
        window.insert(&frame(&mut random, 90, number)).unwrap();
        let bad = [[0.0_f32; 3], [0.0, f32::NAN, 0.0]];
        let fault = MeshError::NotFinite { vertex: 1, axis: 1 };
        assert_eq!(window.insert(&bad), Err(fault));
        let copy = window.clone();
        let clock = ManualClock::ticking(Duration::from_nanos(3));
        let budget = Budget::time(Duration::from_nanos(1));
        assert!(!window.advance(budget.clock(&clock)));
        let budget = Budget::time(Duration::from_secs(1));
        assert!(window.advance(budget.clock(&clock)));
        let mut copy = copy;
        assert!(copy.advance(ALL));
        assert_eq!(copy.tree().to_bytes(), window.tree().to_bytes());
        held.push((Arc::clone(window.tree()), window.tree().to_bytes()));
    }
    for (tree, bytes) in held {
        assert_eq!(tree.to_bytes(), bytes);
    }
    for (capacity, reach) in [
        (1 << 31, 1.0),
        (9, 0.0),
        (9, -1.0),
        (9, f64::NAN),
        (9, f64::INFINITY),
    ] {
        assert!(PointWindow::new(capacity, reach).is_err());
    }
    for reach in [1e-300, 1e300] {
        let mut window = PointWindow::new(100, reach).unwrap();
        let points = [[f32::MAX; 3], [-f32::MAX, 1e-40, 0.0], [-0.0; 3]];
        window.insert(&points).unwrap();
        assert!(window.advance(ALL));
        assert_eq!(window.tree().mesh().len(), 3);
        assert_eq!(window.tree().validate(), Ok(()));
    }
}
