//! Motions of bodies until the next frame, against a query for each pair.

use std::sync::Arc;

use crate::common::random::Random;
use crate::{at, ball, detect, fixed, moving, pose, sweep, trees, whole_frame};
use punctual::clock::ManualClock;
use punctual::impact::TimeOfImpact;
use punctual::{Answer, Budget, Motion, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, BodyId, Scene};

fn motion(start: Pose, random: &mut Random) -> Motion {
    match random.below(4) {
        0 => Motion::straight(start, 3.0 * random.vector()),
        1 => Motion::screw(start, pose(3.0, random)),
        2 => Motion::turning(
            start,
            random.vector(),
            0.5 * random.vector(),
            3.0 * random.vector(),
        ),
        _ => Motion::turning(
            start,
            0.3 * random.vector(),
            8.0 * random.vector(),
            2.0 * random.vector(),
        ),
    }
    .unwrap()
}

/// A body with where it goes.
type Going = (BodyId, Arc<Tree>, Motion);

/// What a query without a budget says of two bodies.
fn truth(
    [(_, a, of_a), (_, b, of_b)]: [&Going; 2],
    workspace: &mut Workspace,
) -> Answer<TimeOfImpact> {
    let query = Query::impact_of_both([a, b], [*of_a, *of_b]);
    query.run(workspace, Budget::unlimited().clock(&ManualClock::new()))
}

#[test]
fn no_body_meets_another_before_the_time_told() {
    let mut random = Random::new(41);
    let trees: Vec<_> = trees()
        .into_iter()
        .filter(|tree| !tree.mesh().is_empty())
        .collect();
    let (mut scene, mut workspace) = (Scene::new(), Workspace::new());
    let mut bodies: Vec<Going> = (0..10)
        .map(|i| {
            let (tree, start) = (Arc::clone(&trees[i % trees.len()]), pose(4.0, &mut random));
            let body = if i == 0 { Body::fixed } else { Body::moving };
            (
                scene.insert(body(Arc::clone(&tree), start)).unwrap(),
                tree,
                Motion::straight(start, [0.0; 3]).unwrap(),
            )
        })
        .collect();
    let (mut met, mut free, mut cut) = (0, 0, 0);
    for frame in 0..16 {
        for (id, _, going) in &mut bodies {
            if random.below(3) == 0 && frame > 0 {
                continue;
            }
            *going = motion(pose(4.0, &mut random), &mut random);
            scene.set_motion(*id, *going).unwrap();
        }
        let unlimited = frame % 2 == 0;
        let budget = if unlimited {
            Budget::unlimited()
        } else {
            Budget::work(1 << (11 + random.below(8)))
        };
        detect(&mut scene, budget);
        let report = scene.report();
        assert!(unlimited || report.work <= 1 << 18);
        assert!(report.is_whole());
        for (i, a) in bodies.iter().enumerate() {
            for b in &bodies[i + 1..] {
                let truth = truth([a, b], &mut workspace);
                let Some(found) = scene
                    .passages()
                    .find(|found| (found.a, found.b) == (a.0, b.0))
                else {
                    assert_eq!(truth.value.upper, None, "lost by the broad phase");
                    continue;
                };
                assert!(
                    found.free_until <= truth.value.upper.unwrap_or(1.0),
                    "{found:?} {truth:?}"
                );
                assert!(
                    found
                        .touching_at
                        .is_none_or(|time| time >= truth.value.lower),
                    "{found:?} {truth:?}"
                );
                assert!(!unlimited || found.touching_at.is_some() == truth.value.upper.is_some());
                assert!(!unlimited || found.touching_at.is_some() || found.free_until == 1.0);
                match report.pair(a.0, b.0).unwrap().verdict {
                    Verdict::Intersecting { .. }
                    | Verdict::Within { .. }
                    | Verdict::Contained { .. } => {
                        assert_eq!(truth.value.upper, Some(0.0))
                    }
                    Verdict::Separated => assert_ne!(truth.value.upper, Some(0.0)),
                    Verdict::Undecided => assert!(found.free_until == 0.0),
                }
                met += usize::from(found.touching_at.is_some_and(|time| time > 0.0));
                free += usize::from(found.free_until == 1.0);
                cut += usize::from(found.free_until < 1.0 && found.touching_at.is_none());
            }
        }
    }
    assert!(met > 20 && free > 20 && cut > 10, "{met} {free} {cut}");
    // What goes on with the same motion needs nothing, and a pose ends it.
    whole_frame(&mut scene);
    assert_eq!(detect(&mut scene, Budget::work(0)).work, 0);
    for (id, ..) in &bodies {
        let here = scene.body(*id).unwrap().pose;
        scene.set_pose(*id, here).unwrap();
    }
    whole_frame(&mut scene);
    assert_eq!(scene.passages().count(), 0);
}

/// Balls that fall past others: those that are known to meet soon are looked at first.
#[test]
fn the_most_urgent_goes_first() {
    let ball = ball(3);
    let mut scene = Scene::new();
    let meets = |i: usize| i.is_multiple_of(4);
    let ids: Vec<BodyId> = (0..40)
        .map(|i| {
            fixed(&mut scene, &ball, at(6.0 * i as f64, 0.0, 0.0));
            moving(&mut scene, &ball, at(6.0 * i as f64, 0.0, 5.0))
        })
        .collect();
    let fall = |scene: &mut Scene, height: f64| {
        for (i, &id) in ids.iter().enumerate() {
            let beside = if meets(i) { 1.2 } else { 1.5 };
            let start = at(6.0 * i as f64 + beside, beside, height);
            sweep(
                scene,
                id,
                Motion::straight(start, [0.0, 0.0, -8.0]).unwrap(),
            );
        }
    };
    fall(&mut scene, 5.0);
    let hits = |scene: &Scene| {
        scene
            .passages()
            .filter(|found| found.touching_at.is_some())
            .count()
    };
    let part = whole_frame(&mut scene).work * 3 / 5;
    assert_eq!((scene.passages().count(), hits(&scene)), (40, 10));
    fall(&mut scene, 4.9);
    detect(&mut scene, Budget::work(part));
    let (found, undecided) = (hits(&scene), scene.report().undecided());
    assert!(found >= 8 && undecided >= 15, "{found} {undecided}");
}

#[test]
fn an_arc_is_more_than_its_ends() {
    let (rod, ball) = (
        Tree::new(shapes::cuboid([3.0, 0.05, 0.05], 2)),
        Tree::new(shapes::icosphere(1)),
    );
    let mut scene = Scene::new();
    let arm = scene
        .insert(Body::moving(Arc::new(rod), at(3.0, 0.0, 0.0)))
        .unwrap();
    scene
        .insert(Body::fixed(Arc::new(ball), at(0.0, 6.0, 0.0)))
        .unwrap();
    // Half a turn about the origin, and more than three of them.
    for (turn, time) in [(std::f64::consts::PI, 0.44), (20.0, 0.07)] {
        let motion =
            Motion::turning(at(3.0, 0.0, 0.0), [0.0; 3], [0.0, 0.0, turn], [0.0; 3]).unwrap();
        scene.set_motion(arm, motion).unwrap();
        whole_frame(&mut scene);
        let found = scene.passages().next().unwrap();
        assert!(
            (found.free_until - time).abs() < 0.02 && found.touching_at.is_some(),
            "{found:?}"
        );
    }
}
