//! Named groups that ignore each other, and names of bodies.

use std::sync::Arc;

use crate::common::random::Random;
use crate::{ball, detect, pose, put, whole_frame};
use punctual::{Budget, Pose};
use punctual_scene::{Body, GroupId, Scene, SceneError};

/// Bodies change their groups, groups their relations, and bodies come and go: those pairs are
/// reported whose groups do not ignore each other.
#[test]
fn pairs_of_groups_that_ignore_each_other_are_not_reported_and_all_others_are() {
    let ball = ball(1);
    let (mut scene, mut random) = (Scene::new(), Random::new(41));
    let names = ["robot", "cell", "part", "cable"];
    let groups = names.map(|name| scene.group(name));
    // The same by the same name.
    assert_eq!(groups, names.map(|name| scene.group(name)));
    let mut bodies = Vec::new();
    let mut ignored = [[false; 4]; 4];
    let (mut seen, mut hidden) = (0, 0);
    for frame in 0..120 {
        if bodies.len() < 40 {
            let body = Body::moving(Arc::clone(&ball), pose(2.5, &mut random));
            bodies.push((scene.insert(body).unwrap(), None));
        }
        let at = random.below(bodies.len());
        match random.below(8) {
            0 => drop(scene.remove(bodies.swap_remove(at).0).unwrap()),
            1..4 => {
                let group = [None, Some(0), Some(1), Some(2), Some(3)][random.below(5)];
                let id = group.map(|group: usize| groups[group]);
                scene.set_group(bodies[at].0, id).unwrap();
                bodies[at].1 = group;
                assert_eq!(scene.group_of(bodies[at].0), Ok(id));
            }
            4..6 => put(&mut scene, bodies[at].0, pose(2.5, &mut random)),
            _ => {
                let ([x, y], ignores) = ([(); 2].map(|()| random.below(4)), frame % 3 > 0);
                scene.ignore_groups(groups[x], groups[y], ignores).unwrap();
                (ignored[x][y], ignored[y][x]) = (ignores, ignores);
            }
        }
        let mut report: Vec<_> = whole_frame(&mut scene)
            .intersecting_pairs()
            .map(|pair| (pair.a, pair.b))
            .collect();
        let mut plain = Scene::new();
        let mut there = Vec::new();
        for (id, group) in &bodies {
            let body = scene.body(*id).unwrap().clone();
            there.push((plain.insert(body).unwrap(), *id, *group));
        }
        for pair in detect(&mut plain, Budget::unlimited()).intersecting_pairs() {
            let of = |id| there.iter().find(|body| body.0 == id).unwrap();
            let (&(_, a, x), &(_, b, y)) = (of(pair.a), of(pair.b));
            let told = report.iter().position(|&pair| pair == (a.min(b), a.max(b)));
            let may_meet = x.zip(y).is_none_or(|(x, y)| !ignored[x][y]);
            assert_eq!(told.is_some(), may_meet, "frame {frame}: {a} {b}");
            told.map(|at| report.swap_remove(at));
            (seen, hidden) = (
                seen + usize::from(may_meet),
                hidden + usize::from(!may_meet),
            );
        }
        assert!(report.is_empty());
    }
    assert!(seen > 1_000 && hidden > 300, "{seen} {hidden}");
}

#[test]
fn groups_and_names_of_another_scene_are_refused_and_names_end_with_their_bodies() {
    let ball = ball(1);
    let [mut scene, mut other] = [Scene::new(), Scene::new()];
    let body = Body::moving(ball, Pose::IDENTITY);
    let [id, foreign] = [&mut scene, &mut other].map(|scene| scene.insert(body.clone()).unwrap());
    let (own, group) = (scene.group("own"), other.group("foreign"));
    let refused = Err(SceneError::NoSuchGroup { group });
    assert_eq!(scene.set_group(id, Some(group)), refused);
    assert_eq!(scene.ignore_groups(own, group, true), refused);
    assert_eq!(scene.ignore_groups(group, own, true), refused);
    assert!(scene.group_name(GroupId::from_bits(1)).is_err());
    assert!(scene.group_name(GroupId::from_bits(u64::MAX)).is_err());
    assert_eq!(scene.group_name(own), Ok("own"));
    assert_eq!(
        scene.set_group(foreign, None),
        Err(SceneError::NoSuchBody { body: foreign })
    );

    assert!(scene.set_name(foreign, "lamp").is_err() && scene.name(foreign).is_empty());
    scene.set_name(id, "lamp").unwrap();
    assert_eq!(scene.name(id), "lamp");
    let error = scene.ignore(id, id, true).unwrap_err();
    assert_eq!(
        scene.message(&error),
        "lamp (body 0 (generation 0)) has no distance from itself"
    );
    scene.remove(id).unwrap();
    assert!(scene.name(id).is_empty());
    let error = scene.remove(id).unwrap_err();
    assert_eq!(
        scene.message(&error),
        "body 0 (generation 0) is not in the scene"
    );
    let id = scene.insert(body).unwrap();
    // Of a reused slot.
    assert!(scene.name(id).is_empty() && scene.group_of(id) == Ok(None));
}
