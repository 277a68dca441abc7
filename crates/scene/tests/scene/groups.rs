//! Distances of groups of a scene, against a query for each pair.

use std::sync::Arc;
use std::time::Duration;

use crate::common::random::Random;
use crate::distances::{LEAST_DISTANCE_WORK, ROUNDING, crowd, distance};
use crate::{assert_witness, ball, detect, moving, nudged, pose, put, whole_frame};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Verdict, Workspace};
use punctual_scene::{Body, BodyId, Filter, GroupDistance, MeasureId, Scene, SceneError};

/// Two groups, and within which tolerance their distance is asked for.
struct Asked {
    id: MeasureId,
    groups: [Vec<BodyId>; 2],
    tolerance: f64,
}

/// How far apart two bodies are, margins counted.
fn apart(scene: &Scene, a: BodyId, b: BodyId, workspace: &mut Workspace) -> f64 {
    let margins: f64 = [a, b].map(|id| scene.body(id).unwrap().margin).iter().sum();
    (distance(scene, a.min(b), a.max(b), workspace) - margins).max(0.0)
}

/// The least distance of two groups.
fn truth(scene: &Scene, [x, y]: &[Vec<BodyId>; 2], workspace: &mut Workspace) -> f64 {
    let mut least = f64::INFINITY;
    for &a in x {
        for &b in y {
            let filters = [a, b].map(|id| scene.body(id).unwrap().filter);
            if filters[0].meets(filters[1]) {
                least = least.min(apart(scene, a, b, workspace));
            }
        }
    }
    least
}

/// What is told of groups holds for the bodies where they are, and says all if nothing is open.
#[track_caller]
fn assert_true(scene: &Scene, asked: &Asked, found: &GroupDistance, workspace: &mut Workspace) {
    let truth = truth(scene, &asked.groups, workspace);
    assert_eq!(found.id, asked.id);
    assert!(found.low <= truth + ROUNDING, "{found:?} {truth}");
    assert!(found.high >= truth - ROUNDING, "{found:?} {truth}");
    assert!(
        found.open > 0
            || found.low == found.high
            || found.high - found.low <= 1.001 * asked.tolerance,
        "{found:?}"
    );
    if let Some([a, b]) = found.bodies {
        assert!(
            a < b
                && asked
                    .groups
                    .iter()
                    .all(|group| group.contains(&a) != group.contains(&b))
        );
        assert!(apart(scene, a, b, workspace) <= found.high + ROUNDING);
    }
}

/// Bodies with some groups of them, which may have bodies in common.
fn grouped(random: &mut Random) -> (Scene, Vec<BodyId>, Vec<Asked>) {
    let (mut scene, ids) = crowd(16, random);
    let mut measure = |x: &[BodyId], y: &[BodyId], tolerance| {
        let id = scene.measure_groups(x, y, tolerance).unwrap();
        Asked {
            id,
            groups: [x.to_vec(), y.to_vec()],
            tolerance,
        }
    };
    let asked = vec![
        measure(&ids[..6], &ids[6..], 1e-4),
        measure(&[ids[3], ids[12], ids[3]], &[ids[7], ids[9]], 0.1),
        measure(&ids[10..], &ids[..6], 0.0),
    ];
    scene.measure(ids[2], ids[8], 1e-3).unwrap();
    (scene, ids, asked)
}

#[test]
fn groups_are_bounded_in_every_frame() {
    let mut random = Random::new(81);
    let (mut scene, ids, asked) = grouped(&mut random);
    let mut workspace = Workspace::new();
    let (mut open, mut shut, mut proven) = (0, 0, 0);
    for frame in 1..160 {
        if frame % 8 < 6 {
            for &id in &ids {
                let there = scene.body(id).unwrap().pose;
                let next = if random.below(40) == 0 {
                    pose(4.0, &mut random)
                } else {
                    nudged(&there, &mut random)
                };
                scene.set_pose(id, next).unwrap();
            }
        }
        match random.below(12) {
            0 => scene
                .set_margin(ids[random.below(16)], 0.2 * random.signed().abs())
                .unwrap(),
            1 => scene
                .set_filter(ids[random.below(16)], Filter::new(1 << random.below(2), 3))
                .unwrap(),
            2 => scene
                .set_filter(ids[random.below(16)], Filter::new(1, 2))
                .unwrap(),
            3 => scene
                .set_filter(ids[random.below(16)], Filter::default())
                .unwrap(),
            _ => {}
        }
        let budget = match frame % 8 {
            0 => Budget::unlimited(),
            1 => Budget::time(Duration::from_micros(1 << random.below(10))),
            _ => Budget::work(LEAST_DISTANCE_WORK << random.below(9)),
        };
        scene.detect(budget.clock(&ManualClock::ticking(Duration::from_nanos(300))));
        let report = scene.report().clone();
        assert_eq!(report.group_distances.len(), asked.len());
        for (asked, found) in asked.iter().zip(&report.group_distances) {
            assert_true(&scene, asked, found, &mut workspace);
            assert!(
                found.open == 0 || budget != Budget::unlimited(),
                "{found:?}"
            );
            open += usize::from(found.open > 0);
            shut += usize::from(found.open == 0);
            proven += usize::from(found.open > 0 && found.low > 0.0);
        }
        for pair in &report.pairs {
            let gap = apart(&scene, pair.a, pair.b, &mut workspace);
            assert_witness(&scene, pair);
            match pair.verdict {
                Verdict::Intersecting { .. }
                | Verdict::Within { .. }
                | Verdict::Contained { .. } => {
                    assert!(gap <= ROUNDING, "{gap} {pair:?}")
                }
                Verdict::Separated => {
                    assert!(gap > 0.0 || distance(&scene, pair.a, pair.b, &mut workspace) > 0.0)
                }
                Verdict::Undecided => assert!(
                    budget != Budget::unlimited() || gap < 1e-3,
                    "{gap} {pair:?}"
                ),
            }
        }
    }
    assert!(open > 50 && shut > 50 && proven > 20, "{open}");
}

/// What rests is measured to its end within K frames, whatever the budget, and then takes no more work.
#[test]
fn groups_at_rest_are_measured_to_the_end() {
    for seed in 0..6 {
        let mut random = Random::new(90 + seed);
        let (mut free, ..) = grouped(&mut random);
        let cost = 2 * detect(&mut free, Budget::unlimited()).work;
        assert!(
            free.report()
                .group_distances
                .iter()
                .all(|found| found.open == 0)
        );
        assert_eq!(detect(&mut free, Budget::unlimited()).work, 0);
        for budget in [8 * LEAST_DISTANCE_WORK, 100_000] {
            let mut random = Random::new(90 + seed);
            let (mut scene, _, asked) = grouped(&mut random);
            let frames = 2 * (2 * cost).div_ceil(budget / 8) + 1;
            let (mut used, mut workspace) = (0, Workspace::new());
            while detect(&mut scene, Budget::work(budget))
                .group_distances
                .iter()
                .any(|found| found.open > 0)
            {
                used += 1;
                assert!(scene.report().work <= budget && used <= frames, "{used}");
            }
            for (asked, found) in asked.iter().zip(&scene.report().group_distances) {
                assert_true(&scene, asked, found, &mut workspace);
            }
        }
    }
}

/// An arm of eight balls among 200 others: a few pairs are asked about, of 1,600.
#[test]
fn far_pairs_need_no_query() {
    let ball = ball(3);
    let mut random = Random::new(83);
    let mut scene = Scene::new();
    let mut insert = |place: DVec3| {
        moving(
            &mut scene,
            &ball,
            Pose::new(DMat3::IDENTITY, place).unwrap(),
        )
    };
    let cell: Vec<_> = (0..200)
        .map(|_| insert(20.0 * random.vector() + 24.0 * DVec3::X))
        .collect();
    let arm: Vec<_> = (0..8)
        .map(|link| insert(DVec3::X * -2.5 * f64::from(link)))
        .collect();
    let id = scene.measure_groups(&arm, &cell, 1e-3).unwrap();
    let asked = Asked {
        id,
        groups: [arm.clone(), cell],
        tolerance: 1e-3,
    };
    let mut workspace = Workspace::new();
    let mut listed = 0;
    for frame in 0..40 {
        for (link, &id) in arm.iter().enumerate() {
            let there = DVec3::new(-2.5 * link as f64, 0.1 * f64::from(frame), 0.0);
            put(&mut scene, id, Pose::new(DMat3::IDENTITY, there).unwrap());
        }
        let report = whole_frame(&mut scene);
        let of_groups = report
            .pairs
            .iter()
            .filter(|pair| arm.contains(&pair.a) != arm.contains(&pair.b));
        listed += of_groups.count();
        let found = report.group_distances[0];
        assert!(
            found.open == 0 && found.high - found.low <= 1.001e-3,
            "{found:?}"
        );
        if frame % 10 == 0 {
            assert_true(&scene, &asked, &found, &mut workspace);
        }
    }
    assert!(listed < 40 * 4, "{listed} pairs in 40 frames");
}

#[test]
fn short_frames_look_at_the_boxes_of_large_groups_one_after_another() {
    let ball = ball(1);
    let mut scene = Scene::new();
    let mut insert = |place: DVec3| {
        let pose = Pose::new(DMat3::IDENTITY, place).unwrap();
        scene.insert(Body::moving(Arc::clone(&ball), pose)).unwrap()
    };
    // The last bodies of both groups are the nearest ones.
    let side =
        |sign: f64| move |i: usize| DVec3::new(sign * (203.0 - i as f64), 3.0 * i as f64, 0.0);
    let groups = [-1.0, 1.0].map(|sign| {
        let places = (0..200).map(side(sign));
        places.map(&mut insert).collect::<Vec<_>>()
    });
    scene.measure_groups(&groups[0], &groups[1], 1e-3).unwrap();
    let mut high = f64::INFINITY;
    for frame in 0..40 {
        let there = side(-1.0)(0) + DVec3::Z * f64::from(frame) * 1e-3;
        let pose = Pose::new(DMat3::IDENTITY, there).unwrap();
        scene.set_pose(groups[0][0], pose).unwrap();
        high = detect(&mut scene, Budget::work(500)).group_distances[0].high;
    }
    // Boxes of bodies 8 apart, from corner to corner.
    assert!(high < 11.0, "{high}");
}

#[test]
fn groups_come_and_go_with_their_bodies() {
    let ball = ball(2);
    let at = |x: f64| Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
    let mut scene = Scene::new();
    let mut insert = |x: f64| moving(&mut scene, &ball, at(x));
    let [a, b, c, d] = [0.0, 10.0, 16.0, 30.0].map(&mut insert);
    assert_eq!(
        scene.measure_groups(&[b], &[b, b], 0.0),
        Err(SceneError::OneBody { body: b })
    );
    assert!(matches!(
        scene.measure_groups(&[a], &[c], f64::NAN),
        Err(SceneError::NotALength { .. })
    ));
    let [first, other] =
        [[a, b], [b, d]].map(|group| scene.measure_groups(&group, &[c], 1e-6).unwrap());
    let lows = |scene: &mut Scene| {
        let report = whole_frame(scene);
        report
            .group_distances
            .iter()
            .map(|found| (found.id, (found.low * 1e3).round() / 1e3))
            .collect::<Vec<_>>()
    };
    assert_eq!(lows(&mut scene), [(first, 4.0), (other, 4.0)]);
    scene.set_pose(d, at(18.0)).unwrap();
    assert_eq!(lows(&mut scene), [(first, 4.0), (other, 0.0)]);
    scene.remove(b).unwrap();
    assert_eq!(lows(&mut scene), [(first, 14.0), (other, 0.0)]);
    scene.set_filter(a, Filter::new(0, 0)).unwrap();
    scene.stop_measuring_groups(other).unwrap();
    // No two of them may meet.
    assert_eq!(lows(&mut scene), [(first, f64::INFINITY)]);
    let third = scene.measure_groups(&[d], &[a], 1e-6).unwrap();
    scene.set_filter(a, Filter::default()).unwrap();
    assert_eq!(lows(&mut scene), [(first, 14.0), (third, 16.0)]);
    scene.remove(d).unwrap();
    let new = scene.insert(Body::moving(ball, at(3.0))).unwrap();
    assert_eq!(new.index(), d.index());
    // Another body is none of it.
    assert_eq!(lows(&mut scene), [(first, 14.0), (third, f64::INFINITY)]);
    scene.stop_measuring_groups(first).unwrap();
    assert_eq!(
        scene.stop_measuring_groups(first),
        Err(SceneError::NoSuchMeasure { measure: first })
    );
    scene.stop_measuring_groups(third).unwrap();
    assert_eq!(lows(&mut scene), []);
    assert_eq!(scene.report().pairs, []);
}

/// One group and itself, and groups that have bodies in common: all pairs of two bodies, each once.
#[test]
fn groups_may_have_bodies_in_common() {
    let mut random = Random::new(78);
    let (mut scene, ids) = crowd(9, &mut random);
    for (body, &id) in ids.iter().enumerate() {
        put(
            &mut scene,
            id,
            Pose::new(random.rotation(), DVec3::X * (3.0 * body as f64)).unwrap(),
        );
    }
    // Links that are joined are kept apart by their filters.
    scene.set_filter(ids[0], Filter::new(1, !1)).unwrap();
    scene.set_filter(ids[1], Filter::new(1, !1)).unwrap();
    let groups = [
        (&ids[..], &ids[..]),
        (&ids[..6], &ids[3..]),
        (&ids[2..4], &ids[2..4]),
    ];
    let measures = groups.map(|(x, y)| scene.measure_groups(x, y, 1e-6).unwrap());
    let mut workspace = Workspace::new();
    for frame in 0..6 {
        for &id in &ids {
            let next = nudged(&scene.body(id).unwrap().pose, &mut random);
            scene.set_pose(id, next).unwrap();
        }
        let budget = if frame % 2 == 0 {
            Budget::unlimited()
        } else {
            Budget::work(20_000)
        };
        let report = detect(&mut scene, budget).clone();
        for ((x, y), id) in groups.iter().zip(measures) {
            let pairs = x
                .iter()
                .flat_map(|&a| y.iter().map(move |&b| (a, b)))
                .filter(|(a, b)| a != b);
            let may_meet = |&(a, b): &(BodyId, BodyId)| a.index() + b.index() != 1;
            let truth = pairs
                .filter(may_meet)
                .map(|(a, b)| apart(&scene, a, b, &mut workspace));
            let truth = truth.fold(f64::INFINITY, f64::min).max(0.0);
            let found = report
                .group_distances
                .iter()
                .find(|found| found.id == id)
                .unwrap();
            assert!(
                found.low <= truth + ROUNDING && truth <= found.high + ROUNDING,
                "{found:?} {truth}"
            );
            assert!(
                budget != Budget::unlimited() || found.high - found.low <= 1.1e-6,
                "{found:?}"
            );
        }
    }
}
