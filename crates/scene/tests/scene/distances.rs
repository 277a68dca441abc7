//! Margins and distances of a scene, against a query for each pair.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::random::Random;
use crate::{assert_witness, ball, detect, nudged, pose, row, swing, trees, whole_frame};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mode, Pose, Query, Verdict, Workspace};
use punctual_scene::{Body, BodyId, Filter, Scene, SceneError};

/// The least work of a turn that asks for a distance.
pub const LEAST_DISTANCE_WORK: u64 = 250 + punctual::prediction::MAX_DISTANCE_STEP_WORK;

/// How far two bodies are apart, margins not counted.
pub fn distance(scene: &Scene, a: BodyId, b: BodyId, workspace: &mut Workspace) -> f64 {
    let [a, b] = [a, b].map(|id| scene.body(id).unwrap());
    let b_in_a = a.pose.inverse().unwrap().compose(&b.pose).unwrap();
    let query = Query::distance(&a.tree, &b.tree, b_in_a).absolute_tolerance(0.0);
    query
        .run(workspace, Budget::unlimited().clock(&ManualClock::new()))
        .value
        .high
}

/// Bodies of all shapes but empty ones, some with margins.
pub fn crowd(bodies: usize, random: &mut Random) -> (Scene, Vec<BodyId>) {
    let trees: Vec<_> = trees()
        .into_iter()
        .filter(|tree| !tree.mesh().is_empty())
        .collect();
    let mut scene = Scene::new();
    let mut insert = |i: usize| {
        let tree = Arc::clone(&trees[random.below(trees.len())]);
        let margin = if i.is_multiple_of(2) {
            0.3 * random.signed().abs()
        } else {
            0.0
        };
        scene
            .insert(Body::moving(tree, pose(3.0, random)).margin(margin))
            .unwrap()
    };
    let ids = (0..bodies).map(&mut insert).collect();
    (scene, ids)
}

fn pairs(ids: &[BodyId]) -> impl Iterator<Item = [BodyId; 2]> {
    ids.iter()
        .enumerate()
        .flat_map(|(i, &a)| ids[i + 1..].iter().map(move |&b| [a, b]))
}

/// Rounding of distances, relative to the bodies.
pub const ROUNDING: f64 = 1e-9;

/// Verdicts and bounds of a report are true of the distances; those of a complete one say all.
#[track_caller]
fn assert_true(scene: &Scene, gaps: &BTreeMap<[BodyId; 2], f64>, complete: bool) {
    let report = scene.report();
    for (&[a, b], &gap) in gaps {
        let pair = report.pair(a, b);
        pair.into_iter()
            .for_each(|pair| assert_witness(scene, pair));
        match pair.map(|pair| pair.verdict) {
            Some(
                Verdict::Intersecting { .. } | Verdict::Within { .. } | Verdict::Contained { .. },
            ) => {
                assert!(gap <= ROUNDING, "{gap} {pair:?}")
            }
            Some(Verdict::Separated) => assert!(gap >= -ROUNDING, "{gap} {pair:?}"),
            Some(Verdict::Undecided) => assert!(!complete, "{gap} {pair:?}"),
            None => assert!(gap > -ROUNDING || !report.is_whole(), "{gap}"),
        }
    }
}

#[test]
fn bodies_meet_within_their_margins() {
    let mut random = Random::new(31);
    let (mut scene, ids) = crowd(14, &mut random);
    let mut workspace = Workspace::new();
    let mut met = [0; 2];
    for frame in 0..60 {
        for &id in &ids {
            if random.below(3) > 0 {
                let next = nudged(&scene.body(id).unwrap().pose, &mut random);
                scene.set_pose(id, next).unwrap();
            }
        }
        let changed = ids[random.below(ids.len())];
        scene
            .set_margin(
                changed,
                if random.below(2) == 0 {
                    0.0
                } else {
                    0.4 * random.signed().abs()
                },
            )
            .unwrap();
        scene.set_mode(if frame % 20 < 10 {
            Mode::Any
        } else {
            Mode::All
        });
        let budget = if frame % 3 == 0 {
            Budget::unlimited()
        } else {
            Budget::work(1 << (10 + random.below(8)))
        };
        let report = detect(&mut scene, budget);
        assert!(budget == Budget::unlimited() || report.work <= 1 << 17);
        let gap = |scene: &Scene, [a, b]: [BodyId; 2], workspace: &mut Workspace| {
            let distance = distance(scene, a, b, workspace);
            let margins = [a, b].map(|id| scene.body(id).unwrap().margin);
            // Surfaces that meet are as close as their margins, if those are 0.
            if distance == 0.0 {
                -1.0
            } else {
                distance - margins[0] - margins[1]
            }
        };
        let gaps: BTreeMap<_, _> = pairs(&ids)
            .map(|pair| (pair, gap(&scene, pair, &mut workspace)))
            .collect();
        assert_true(&scene, &gaps, budget == Budget::unlimited());
        met[0] += gaps
            .values()
            .filter(|&&gap| gap < 0.0 && gap > -1.0)
            .count();
        met[1] += gaps.values().filter(|&&gap| gap > 0.0 && gap < 0.3).count();
    }
    assert!(met[0] > 50 && met[1] > 50, "{met:?}");
}

/// Bounds hold for the poses of the frame that their age names, whatever the budget.
#[test]
fn distances_are_bounded_at_every_budget() {
    let mut random = Random::new(32);
    let (mut scene, ids) = crowd(8, &mut random);
    let mut workspace = Workspace::new();
    for id in &ids {
        scene.set_margin(*id, 0.0).unwrap();
    }
    let asked: Vec<_> = pairs(&ids).filter(|_| random.below(2) == 0).collect();
    for &[a, b] in &asked {
        scene.measure(b, a, 1e-4).unwrap();
    }
    let mut history: Vec<Vec<f64>> = vec![Vec::new()];
    let (mut stale, mut open) = (0, 0);
    for frame in 1..80 {
        if frame % 8 < 5 {
            for &id in &ids {
                let next = nudged(&scene.body(id).unwrap().pose, &mut random);
                scene.set_pose(id, next).unwrap();
            }
        }
        history.push(
            asked
                .iter()
                .map(|&[a, b]| distance(&scene, a, b, &mut workspace))
                .collect(),
        );
        let budget = match frame % 8 {
            0 => Budget::unlimited(),
            _ => Budget::work(LEAST_DISTANCE_WORK << random.below(7)),
        };
        let work = detect(&mut scene, budget).work;
        assert!(budget == Budget::unlimited() || work <= LEAST_DISTANCE_WORK << 6);
        assert_eq!(scene.distances().count(), asked.len());
        for (at, found) in scene.distances().enumerate() {
            assert_eq!([found.a, found.b], asked[at]);
            let truth = history[frame - found.age as usize]
                .get(at)
                .copied()
                .unwrap_or(f64::INFINITY);
            assert!(found.low <= truth + ROUNDING, "{found:?} {truth}");
            assert!(
                found.high >= truth - ROUNDING || truth == f64::INFINITY,
                "{found:?} {truth}"
            );
            assert!(found.high.is_finite() == found.triangles.is_some());
            if budget == Budget::unlimited() {
                assert!(
                    found.age == 0 && found.high - found.low <= 1.001e-4,
                    "{found:?}"
                );
            }
            stale += usize::from(found.age > 0);
            open += usize::from(found.age == 0 && found.high - found.low > 1.001e-4);
        }
    }
    assert!(stale > 100 && open > 20, "{stale} stale, {open} open");
}

/// K = 2 ⌈C/R⌉ + 1 frames hold with distances, and what rests is measured to its end.
#[test]
fn no_distance_waits_longer_than_promised() {
    let all = |scene: &mut Scene, ids: &[BodyId]| {
        for pair in ids.windows(3) {
            scene.measure(pair[0], pair[1], 1e-3).unwrap();
            scene.measure(pair[0], pair[2], 1e-3).unwrap();
        }
    };
    let mut free = Scene::new();
    let ids = row(&mut free, 20);
    all(&mut free, &ids);
    let cost = 2 * detect(&mut free, Budget::unlimited()).work;
    for budget in [8 * LEAST_DISTANCE_WORK, 100_000, 1_000_000] {
        let mut scene = Scene::new();
        let ids = row(&mut scene, 20);
        all(&mut scene, &ids);
        let frames = 2 * (2 * cost).div_ceil(budget / 8) + 1;
        let mut used = 0;
        while detect(&mut scene, Budget::work(budget)).complete < scene.report().pairs.len()
            || !scene.report().is_whole()
        {
            used += 1;
            assert!(scene.report().work <= budget && used <= frames, "{used}");
        }
        assert!(
            scene
                .distances()
                .all(|found| found.age == 0 && found.high - found.low <= 1.001e-3)
        );
        // In motion, each has its turn.
        for frame in 0..frames.min(60) as usize {
            for (body, &id) in ids.iter().enumerate() {
                scene.set_pose(id, swing(body, frame)).unwrap();
            }
            let report = detect(&mut scene, Budget::work(budget));
            assert!(report.work <= budget);
            assert!(scene.distances().all(|found| found.age <= frames));
        }
    }
}

#[test]
fn distances_come_and_go_with_their_bodies() {
    let ball = ball(1);
    let at = |x: f64| Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
    let mut scene = Scene::new();
    let [a, b] = [0.0, 50.0].map(|x| scene.insert(Body::fixed(Arc::clone(&ball), at(x))).unwrap());
    assert_eq!(
        scene.measure(a, a, 0.0),
        Err(SceneError::OneBody { body: a })
    );
    assert!(
        matches!(scene.measure(a, b, -1.0), Err(SceneError::NotALength { body, .. }) if body == a)
    );
    assert!(
        matches!(scene.set_margin(b, f64::NAN), Err(SceneError::NotALength { body, .. }) if body == b)
    );
    scene.measure(a, b, 0.0).unwrap();
    let lows = |scene: &mut Scene| {
        whole_frame(scene);
        scene
            .distances()
            .map(|found| (found.age, found.low.round()))
            .collect::<Vec<_>>()
    };
    assert_eq!(lows(&mut scene), [(0, 48.0)], "far away, and both fixed");
    scene.set_pose(b, at(30.0)).unwrap();
    scene.set_margin(b, 5.0).unwrap();
    assert_eq!(lows(&mut scene), [(0, 23.0)]);
    scene.set_filter(b, Filter::new(1, 0)).unwrap();
    assert_eq!(lows(&mut scene), [(1, 23.0)], "they may not meet");
    scene.set_filter(b, Filter::default()).unwrap();
    scene.remove(b).unwrap();
    let other = scene.insert(Body::moving(ball, at(10.0))).unwrap();
    assert_eq!((other.index(), lows(&mut scene)), (b.index(), vec![]));
    scene.measure(a, other, 0.0).unwrap();
    assert_eq!(lows(&mut scene), [(0, 8.0)]);
    scene.stop_measuring(a, other).unwrap();
    assert_eq!(lows(&mut scene), []);
    assert_eq!(scene.report().pairs, []);
}

#[test]
fn bodies_closer_than_the_tolerance_are_known_to_meet_or_not() {
    let ball = ball(3);
    let cases = [(1e-3, false), (1e-9, false), (-1e-3, true)];
    for ((gap, meets), margin) in cases
        .into_iter()
        .flat_map(|case| [(case, 0.0), (case, 0.3)])
    {
        let mut scene = Scene::new();
        let ids = [0.0, 2.0 + 2.0 * margin + gap].map(|x| {
            let place = Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
            scene
                .insert(Body::moving(Arc::clone(&ball), place).margin(margin))
                .unwrap()
        });
        scene.measure(ids[0], ids[1], 0.1).unwrap();
        let report = scene.detect(Budget::unlimited());
        let pair = report.pair(ids[0], ids[1]).unwrap();
        assert!(pair.complete && pair.verdict.meets() == meets, "{gap}");
        assert_eq!(pair.verdict == Verdict::Separated, !meets, "{gap}");
        let found = scene.distances().next().unwrap();
        assert!(found.high - found.low <= 0.1);
    }
}
