//! Pairs that are near each other, against distances of all pairs and finite differences.

mod cell;

use cell::{UNLIMITED, arm, at, cell, configurations, random, surfaces};
use punctual::{Budget, Pose, StopReason, Tree};
use punctual_robot::{Checker, ClearanceOptions, Margin, NearPairs, Scope, Shape, ShapeId};

const WITHIN: f64 = 0.15;

fn padded() -> Checker {
    let mut checker = cell();
    checker.set_margin(Margin::All, 0.01).unwrap();
    checker
}

fn find(checker: &mut Checker, q: &[f64]) -> NearPairs {
    let (options, mut found) = (
        ClearanceOptions::default().tolerance(1e-10),
        NearPairs::default(),
    );
    let end = checker
        .near_pairs(q, WITHIN, &options, UNLIMITED, &mut found)
        .unwrap();
    assert_eq!((end.stop, end.value), (StopReason::Finished, WITHIN));
    found
}

#[test]
fn pairs_are_those_of_all_distances_at_any_stop() {
    let mut checker = padded();
    let (mut near, mut cut, mut found) = (0, 0, NearPairs::default());
    for q in configurations(200, 12) {
        let distances = surfaces(&checker, &q);
        for work in [0, 1, 700, 4_000, 20_000, u64::MAX] {
            let options = ClearanceOptions::default();
            let budget = Budget::work(work);
            let end = checker
                .near_pairs(&q, WITHIN, &options, budget, &mut found)
                .unwrap();
            cut += u32::from(end.stop != StopReason::Finished);
            for &(pair, distance) in &distances {
                let left = distance - 0.01;
                match found.pairs.iter().find(|near| near.pair == pair) {
                    Some(pair) => {
                        // One may hold the other; boxes are rounded to f32 in the list.
                        let is_held = pair.high == -0.01;
                        let is_within = pair.low <= left + 1e-7 && left <= pair.high + 1e-7;
                        assert!(is_held || is_within, "{pair:?} {left}");
                        assert!(pair.high - pair.low <= 1.01e-6);
                        assert!((pair.normal.length() - 1.0).abs() < 1e-9 || is_held);
                        near += 1;
                    }
                    None => assert!(left >= end.value - 1e-7, "{pair:?} {left} {end:?}"),
                }
            }
            assert!(found.pairs.is_sorted_by_key(|near| near.pair));
            assert_eq!(found.gradients.len(), 4 * found.pairs.len());
        }
    }
    assert!(near > 1_000 && cut > 400, "{near} {cut}");
}

#[test]
fn gradients_are_those_of_finite_differences() {
    let mut checker = padded();
    let left = |found: &NearPairs, pair: [ShapeId; 2]| {
        let near = found.pairs.iter().find(|near| near.pair == pair)?;
        Some(0.5 * (near.low + near.high))
    };
    let (mut compared, mut smooth) = (0, 0);
    for q in configurations(250, 13) {
        let here = find(&mut checker, &q);
        for joint in 0..4 {
            const STEP: f64 = 1e-5;
            let [before, after] = [-STEP, STEP].map(|step| {
                let mut q = q.clone();
                q[joint] += step;
                find(&mut checker, &q)
            });
            for (i, near) in here.pairs.iter().enumerate() {
                let (Some(a), Some(b)) = (left(&before, near.pair), left(&after, near.pair)) else {
                    continue;
                };
                // In contact it is 0, as the points are one.
                if near.high < -0.01 + 1e-4 || a < -0.01 + 1e-4 || b < -0.01 + 1e-4 {
                    continue;
                }
                let now = 0.5 * (near.low + near.high);
                let slopes = [(now - a) / STEP, (b - now) / STEP];
                let given = here.gradient(i)[joint];
                // Where the closest points jump, the slope is that of one of them.
                let [low, high] = [slopes[0].min(slopes[1]), slopes[0].max(slopes[1])];
                assert!(low - 2e-3 <= given && given <= high + 2e-3, "{near:?}");
                smooth += u32::from(high - low < 1e-3);
                compared += u32::from(given != 0.0);
            }
        }
    }
    assert!(compared > 1_000 && smooth > 3_000, "{compared} {smooth}");
}

#[test]
fn scopes_and_batches_have_the_same_pairs() {
    let mut checker = padded();
    let rows = configurations(100, 14);
    let options = ClearanceOptions::default();
    let batch = checker
        .near_pairs_batch(&rows.concat(), WITHIN, &options, UNLIMITED, 2)
        .unwrap();
    let mut alone = NearPairs::default();
    for (q, (end, found)) in rows.iter().zip(batch) {
        let again = checker
            .near_pairs(q, WITHIN, &options, UNLIMITED, &mut alone)
            .unwrap();
        assert_eq!((again.value, &alone), (end.value, &found));
        let mut count = 0;
        for scope in [Scope::Robot, Scope::Obstacles] {
            let options = options.scope(scope);
            let _ = checker
                .near_pairs(q, WITHIN, &options, UNLIMITED, &mut alone)
                .unwrap();
            count += alone.pairs.len();
        }
        assert_eq!(count, found.pairs.len());
    }
    let nothing = checker.near_pairs(&rows[0], f64::NAN, &options, UNLIMITED, &mut alone);
    assert_eq!(nothing.unwrap().value, 0.0);
}

#[test]
fn no_pair_is_lost_among_hundreds_of_obstacles_that_come_move_and_go() {
    let mut none = Checker::new(arm());
    none.set_margin(Margin::Of("fore"), 0.02).unwrap();
    let (mut checker, mut random) = (none.clone(), random(31));
    let (mut pairs, mut own, mut met) = (Vec::new(), Vec::new(), 0);
    let mut added: Vec<(ShapeId, Pose, Shape)> = Vec::new();
    for q in configurations(150, 17) {
        for _ in 0..12 {
            let pose = at(1.2 * random() - 0.6, 1.2 * random() - 0.6, 1.3 * random());
            let chosen = (random() * added.len() as f64) as usize;
            match (random() * 4.0) as usize {
                0 if added.len() > 40 => checker.remove(added.swap_remove(chosen).0).unwrap(),
                1 if !added.is_empty() => {
                    checker.move_to(added[chosen].0, pose).unwrap();
                    added[chosen].1 = pose;
                }
                _ => {
                    // From millimetres to a metre.
                    let size = 0.003 * 10f64.powf(2.0 * random());
                    let shape = Shape::cuboid([size, 2.0 * size, 0.5 * size]).unwrap();
                    added.push((
                        checker.add("box", pose, shape.clone()).unwrap(),
                        pose,
                        shape,
                    ));
                }
            }
        }
        let _ = checker.collide_all(&q, UNLIMITED, &mut pairs).unwrap();
        let mut expected = Vec::new();
        let _ = none.collide_all(&q, UNLIMITED, &mut expected).unwrap();
        for (id, pose, shape) in &added {
            let mut alone = none.clone();
            let box_alone = alone.add("box", *pose, shape.clone()).unwrap();
            let _ = alone.collide_all(&q, UNLIMITED, &mut own).unwrap();
            own.retain(|pair| pair[1] == box_alone);
            expected.extend(own.iter().map(|pair| [pair[0], *id]));
        }
        expected.sort_unstable();
        assert_eq!(pairs, expected);
        met += pairs.len();
    }
    assert!(added.len() > 150 && met > 500, "{} {met}", added.len());
}

#[test]
fn what_was_told_last_of_a_pair_counts() {
    let mut checker = cell();
    let pairs = |checker: &Checker| {
        let names = |pair: [ShapeId; 2]| pair.map(|id| checker.name(id).unwrap().to_owned());
        let mut all: Vec<_> = checker.pairs().map(names).collect();
        all.sort_unstable();
        all
    };
    let before = pairs(&checker);
    let asks = |all: &[[String; 2]], pair: [&str; 2]| all.iter().any(|names| names == &pair);
    // An object in the hand and what stands in the world, both obstacles.
    assert!(asks(&before, ["board", "load"]));
    checker.allow(["load", "board"], true).unwrap();
    let allowed = pairs(&checker);
    assert!(!asks(&allowed, ["board", "load"]));
    assert_eq!(allowed.len() + 1, before.len());
    // Links that are neighbours, and what the object was allowed to touch.
    assert!(!asks(&before, ["upper", "fore"]) && !asks(&before, ["left", "load"]));
    checker.allow(["fore", "upper"], false).unwrap();
    checker.allow(["load", "left"], false).unwrap();
    assert!(asks(&pairs(&checker), ["upper", "fore"]) && asks(&pairs(&checker), ["left", "load"]));
    // Later obstacles follow their name.
    let shape = Shape::sphere(0.1).unwrap();
    let board = checker.add("board", at(0.0, 0.0, 0.0), shape).unwrap();
    let load = checker.find("load").unwrap();
    assert!(!checker.pairs().any(|pair| pair == [load, board]));
    checker.remove(board).unwrap();
    for (names, may_touch) in [
        (["board", "load"], false),
        (["upper", "fore"], true),
        (["left", "load"], true),
    ] {
        checker.allow(names, may_touch).unwrap();
    }
    assert_eq!(pairs(&checker), before);
    let refused = checker.allow(["load", "tray"], true).unwrap_err();
    assert!(refused.to_string().contains("tray"), "{refused}");
    let mut rival = cell();
    for q in configurations(100, 5) {
        let labels = [&mut checker, &mut rival].map(|checker| {
            let mut pairs = Vec::new();
            let _ = checker.collide_all(&q, UNLIMITED, &mut pairs).unwrap();
            pairs
        });
        assert_eq!(labels[0], labels[1]);
    }
}

#[test]
fn a_cloud_meets_the_links_that_its_points_meet_one_by_one() {
    let (mut cloud, mut balls) = (Checker::new(arm()), Checker::new(arm()));
    let mut random = random(77);
    let mut point = || [(); 3].map(|()| 1.6 * random() - 0.8);
    let points: Vec<_> = (0..700).map(|_| point()).collect();
    let tree = Tree::from_points_f64(points.iter().copied()).unwrap();
    let tree = tree.with_radius(0.004).unwrap();
    let pose = at(0.0, 0.0, 0.5);
    let shape = Shape::tree(tree.into());
    let id = cloud.add("cloud", pose, shape).unwrap();
    for [x, y, z] in points {
        let shape = Shape::sphere(0.004).unwrap();
        balls.add("ball", at(x, y, z + 0.5), shape).unwrap();
    }
    let (mut met, mut free) = (0, 0);
    for margin in [0.0, 0.01] {
        cloud.set_margin(Margin::Of("cloud"), margin).unwrap();
        balls.set_margin(Margin::All, margin).unwrap();
        for q in configurations(150, 9) {
            let [mut of_cloud, of_balls] = [&mut cloud, &mut balls].map(|checker| {
                let mut pairs = Vec::new();
                let _ = checker.collide_all(&q, UNLIMITED, &mut pairs).unwrap();
                // What meets an obstacle.
                pairs.retain(|pair| pair[1] >= id);
                let mut links: Vec<_> = pairs.iter().map(|pair| pair[0]).collect();
                links.dedup();
                links
            });
            of_cloud.sort_unstable();
            assert_eq!(of_cloud, of_balls);
            met += of_balls.len();
            free += u32::from(of_balls.is_empty());
        }
    }
    assert!(met > 200 && free > 20, "{met} {free}");
}
