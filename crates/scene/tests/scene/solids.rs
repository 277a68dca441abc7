//! Bodies that are solids: what is inside another meets it. Sensors, and pairs that are ignored.

use crate::{detect, fixed, moving, put, whole_frame};
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
fn a_body_that_crosses_a_sensor_enters_once_and_leaves_once() {
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
            put(
                &mut scene,
                id,
                at(start + (8.0 - start) * f64::from(step.min(100)) / 100.0),
            );
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
        let a = fixed(&mut scene, &room, Pose::IDENTITY);
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
        assert!(contained(whole_frame(&mut scene), ids), "{margin}");
        scene.set_pose(ids[1], at(0.1)).unwrap();
        assert!(contained(whole_frame(&mut scene), ids));
        assert_eq!(scene.report().meeting_pairs().count(), 1);
        scene.set_pose(ids[1], at(6.0)).unwrap();
        assert_eq!(whole_frame(&mut scene).meeting_pairs().count(), 0);
    }
    let (mut scene, ids) = new(0.0);
    scene.measure(ids[0], ids[1], 1e-3).unwrap();
    let report = whole_frame(&mut scene);
    assert!(contained(report, ids), "{report:?}");
    assert_eq!(scene.distance(ids[0], ids[1]).unwrap().high, 0.0);
    let (mut scene, ids) = new(0.0);
    let away = Motion::straight(at(0.0), DVec3::X).unwrap();
    scene.set_motion(ids[1], away).unwrap();
    whole_frame(&mut scene);
    let passage = scene.passages().next().unwrap();
    assert_eq!(passage.touching_at, Some(0.0));
}

#[test]
fn an_ignored_pair_does_not_meet() {
    let [_, ball] = room_and_ball();
    let mut scene = Scene::new();
    scene.track_contacts();
    let [a, b, c] = [0.0, 1.2, 2.4].map(|x| moving(&mut scene, &ball, at(x)));
    let meeting = |scene: &mut Scene| whole_frame(scene).meeting_pairs().count();
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

/// The contacts of two bodies, the contained one, and what is proven of them now.
fn told(scene: &mut Scene, [a, b]: [BodyId; 2]) -> (Option<BodyId>, f64, bool, usize) {
    whole_frame(scene);
    let found = scene.contacts(a, b).unwrap();
    assert_eq!(found, scene.contacts(b, a).unwrap());
    let left = found.low - found.drift;
    (found.within, left, found.is_complete(), found.points.len())
}

#[test]
fn a_contained_body_is_not_free() {
    let [room, ball] = room_and_ball();
    for [first, second] in [[0, 1], [1, 0]] {
        let mut scene = Scene::new();
        scene.find_contacts();
        let body = |at_room: bool| match at_room {
            true => Body::moving(Arc::clone(&room), Pose::IDENTITY),
            false => Body::moving(Arc::clone(&ball), at(0.0)).margin(0.01),
        };
        let ids = [first, second].map(|which| scene.insert(body(which == 0)).unwrap());
        let inner = ids[usize::from(first == 0)];
        let near = 3.995 - ball.mesh().aabb().max.x;
        // In the middle; moved a little; near the wall from within; crossing it; outside; far off.
        for (x, is_within) in [(0.0, true), (0.001, true), (near, true), (3.5, false)] {
            scene.set_pose(inner, at(x)).unwrap();
            let (within, left, complete, points) = told(&mut scene, ids);
            assert_eq!(within, is_within.then_some(inner), "{x}");
            assert!(scene.report().meeting_pairs().count() == 1);
            if is_within {
                assert!(left <= 0.0 && !complete, "{x}: {left}");
            }
            assert_eq!(points > 0, !is_within, "{x}: {points} points");
        }
        for x in [5.5, 50.0] {
            scene.set_pose(inner, at(x)).unwrap();
            let (within, left, complete, points) = told(&mut scene, ids);
            assert!(within.is_none() && left > 0.0 && complete && points == 0);
        }
    }
}

/// Whatever the budget: as long as a body may be contained, nothing is said to be apart.
#[test]
fn unfinished_contacts_of_solids_claim_no_room() {
    let [room, ball] = room_and_ball();
    for work in (400..12_000).step_by(97) {
        let mut scene = Scene::new();
        scene.find_contacts();
        let a = Body::fixed(Arc::clone(&room), Pose::IDENTITY);
        let b = Body::moving(Arc::clone(&ball), at(2.5)).margin(0.3);
        let [a, b] = [a, b].map(|body| scene.insert(body).unwrap());
        for _ in 0..4 {
            detect(&mut scene, Budget::work(work));
            let found = scene.contacts(a, b).unwrap();
            assert!(found.low - found.drift <= 0.0, "{work}: {found:?}");
        }
    }
}

#[test]
fn a_sensor_has_contacts_only_if_they_are_asked_for() {
    let [room, ball] = room_and_ball();
    let mut scene = Scene::new();
    scene.find_contacts();
    let sensor = Body::fixed(Arc::clone(&room), Pose::IDENTITY).sensor();
    let body = Body::moving(Arc::clone(&ball), at(3.5)).margin(0.01);
    let [a, b] = [sensor, body].map(|body| scene.insert(body).unwrap());
    assert_eq!(told(&mut scene, [a, b]).3, 0);
    let work = scene.report().work;
    scene.find_contacts_of(a, b).unwrap();
    scene.set_pose(b, at(3.4)).unwrap();
    assert!(told(&mut scene, [a, b]).3 > 0 && scene.report().work > work);
    scene.stop_finding_contacts_of(a, b).unwrap();
    scene.set_pose(b, at(0.0)).unwrap();
    scene.set_pose(b, at(3.5)).unwrap();
    assert_eq!(scene.body(a).unwrap().margin, 0.0);
}

/// A platform moves as it is told; what is on it is found, and nothing of it meets the scenery.
#[test]
fn a_kinematic_body_meets_moving_ones_on_its_way() {
    let [room, ball] = room_and_ball();
    let mut scene = Scene::new();
    let [ground, platform] = [-8.0, 0.0].map(|x| {
        let body = Body::fixed(Arc::clone(&room), at(x));
        scene.insert(body).unwrap()
    });
    let id = scene.insert(Body::moving(ball, at(40.0))).unwrap();
    // From 0 to 80 in a frame: it overtakes the ball.
    let way = Motion::straight(at(0.0), 80.0 * DVec3::X).unwrap();
    scene.set_motion(platform, way).unwrap();
    assert_eq!(whole_frame(&mut scene).meeting_pairs().count(), 0);
    let passages: Vec<_> = scene.passages().collect();
    let [passage] = passages[..] else {
        panic!("{passages:?}")
    };
    assert_eq!([passage.a, passage.b], [platform, id]);
    assert!(passage.free_until <= 0.4375 && 0.4375 <= passage.touching_at.unwrap());
    scene.set_pose(platform, at(38.0)).unwrap();
    let report = whole_frame(&mut scene);
    assert_eq!(report.meeting_pairs().count(), 1);
    assert!(report.pair(ground, platform).is_none());
}
