//! Bodies that are solids: what is inside another meets it. Sensors, and pairs that are ignored.

use crate::detect;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Pose, Tree, Verdict, shapes};
use punctual_geom::Motion;
use punctual_scene::{Body, BodyId, ContactPhase, Report, Scene, SceneError};
use std::sync::Arc;

fn at(x: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, DVec3::new(x, 0.1, 0.2)).unwrap()
}

/// A box of half width 4 and a ball of radius 1.
fn room_and_ball() -> [Arc<Tree>; 2] {
    let options = BuildOptions::default().solid(Solid::Keep);
    [shapes::cuboid(Vec3::splat(4.0), 2), shapes::icosphere(2)]
        .map(|mesh| Arc::new(Tree::with_options(mesh, &options)))
}

fn count(reports: &[Vec<ContactPhase>], phase: ContactPhase) -> usize {
    reports.iter().flatten().filter(|&&is| is == phase).count()
}

/// Whatever the budget: what crosses a sensor enters once and leaves once, also what is born inside.
#[test]
fn what_crosses_a_sensor_enters_once_and_leaves_once() {
    let [room, ball] = room_and_ball();
    for (start, budget) in [
        (-8.0, Budget::unlimited()),
        (0.0, Budget::unlimited()),
        (-8.0, Budget::work(60_000)),
        (0.0, Budget::work(60_000)),
        (-8.0, Budget::work(700)),
    ] {
        let mut scene = Scene::new();
        scene.track_contacts();
        scene.find_contacts();
        let sensor = scene
            .insert(
                Body::fixed(Arc::clone(&room), Pose::IDENTITY)
                    .sensor()
                    .data(7),
            )
            .unwrap();
        let id = scene
            .insert(Body::moving(Arc::clone(&ball), at(start)).margin(0.01))
            .unwrap();
        assert!(scene.body(sensor).unwrap().is_sensor && scene.body(sensor).unwrap().data == 7);
        let (mut phases, mut contained) = (Vec::new(), 0);
        // Some frames more, to find out what is still open.
        for step in 0..=140 {
            scene
                .set_pose(
                    id,
                    at(start + (8.0 - start) * f64::from(step.min(100)) / 100.0),
                )
                .unwrap();
            let report = detect(&mut scene, budget);
            phases.push(
                report
                    .contacts
                    .iter()
                    .map(|contact| contact.phase)
                    .collect(),
            );
            contained += report.contained;
            assert!(scene.contacts(sensor, id).unwrap().points.is_empty());
        }
        let counts = [ContactPhase::Began, ContactPhase::Ended].map(|phase| count(&phases, phase));
        // A budget of one step a frame may miss it, but says nothing wrong.
        let least = usize::from(budget != Budget::work(700));
        assert!(
            counts[0] == counts[1] && (least..=1).contains(&counts[0]),
            "from {start}, {budget:?}: {counts:?}"
        );
        assert!(contained >= least && phases[140].is_empty());
    }
}

/// Each question of a scene knows what is inside.
#[test]
fn a_body_inside_another_meets_it() {
    let [room, ball] = room_and_ball();
    let new = |margin: f64| {
        let mut scene = Scene::new();
        let a = scene
            .insert(Body::fixed(Arc::clone(&room), Pose::IDENTITY))
            .unwrap();
        let b = scene
            .insert(Body::moving(Arc::clone(&ball), at(0.0)).margin(margin))
            .unwrap();
        (scene, [a, b])
    };
    let contained = |report: &Report, [a, b]: [BodyId; 2]| {
        let pair = report.pair(a, b).unwrap();
        matches!(pair.verdict, Verdict::Contained { .. }) && pair.complete && pair.found == 0
    };
    for (margin, finds_contacts) in [(0.0, false), (0.1, false), (0.1, true)] {
        let (mut scene, ids) = new(margin);
        if finds_contacts {
            scene.find_contacts();
        }
        assert!(
            contained(detect(&mut scene, Budget::unlimited()), ids),
            "{margin}"
        );
        scene.set_pose(ids[1], at(0.1)).unwrap();
        assert!(contained(detect(&mut scene, Budget::unlimited()), ids));
        assert_eq!(scene.report().meeting_pairs().count(), 1);
        scene.set_pose(ids[1], at(6.0)).unwrap();
        assert_eq!(
            detect(&mut scene, Budget::unlimited())
                .meeting_pairs()
                .count(),
            0
        );
    }
    let (mut scene, ids) = new(0.0);
    scene.measure(ids[0], ids[1], 1e-3).unwrap();
    let report = detect(&mut scene, Budget::unlimited());
    assert!(contained(report, ids), "{report:?}");
    assert_eq!(scene.distance(ids[0], ids[1]).unwrap().high, 0.0);
    let (mut scene, ids) = new(0.0);
    let away = Motion::straight(at(0.0), DVec3::X).unwrap();
    scene.set_motion(ids[1], away).unwrap();
    detect(&mut scene, Budget::unlimited());
    let passage = scene.passages().next().unwrap();
    assert_eq!(passage.touching_at, Some(0.0));
}

#[test]
fn an_ignored_pair_does_not_meet() {
    let [_, ball] = room_and_ball();
    let mut scene = Scene::new();
    scene.track_contacts();
    let [a, b, c] = [0.0, 1.2, 2.4].map(|x| {
        scene
            .insert(Body::moving(Arc::clone(&ball), at(x)))
            .unwrap()
    });
    let meeting = |scene: &mut Scene| detect(scene, Budget::unlimited()).meeting_pairs().count();
    assert_eq!(meeting(&mut scene), 2);
    scene.ignore(b, a, true).unwrap();
    assert_eq!(meeting(&mut scene), 1);
    assert!(scene.report().pair(a, b).is_none());
    let ended = scene
        .report()
        .contacts
        .iter()
        .find(|contact| contact.a == a);
    assert_eq!(ended.unwrap().phase, ContactPhase::Ended);
    scene.ignore(a, b, false).unwrap();
    assert_eq!(meeting(&mut scene), 2);
    scene.ignore(a, b, true).unwrap();
    scene.remove(a).unwrap();
    let d = scene.insert(Body::moving(ball, at(0.0))).unwrap();
    assert_eq!(d.index(), a.index());
    assert_eq!(meeting(&mut scene), 2, "another body took its place");
    assert_eq!(
        scene.ignore(c, c, true),
        Err(SceneError::OneBody { body: c })
    );
    assert_eq!(
        scene.ignore(a, c, true),
        Err(SceneError::NoSuchBody { body: a })
    );
}
