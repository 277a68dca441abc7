//! Contacts of a scene, against a query for each pair.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::random::Random;
use crate::{at, ball, detect, moving, nudged, pose, put, row, swing_all, trees, whole_frame};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Mesh, Mode, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, BodyId, Filter, PairQuestion, Scene, SceneError};

/// The least work of a turn that asks for contacts.
const LEAST_CONTACT_WORK: u64 = 250 + punctual::prediction::MAX_DISTANCE_STEP_WORK;

/// Most points of a pair that are told.
const MOST_POINTS: usize = 16;

/// All contact points of two bodies: their distances.
fn truth(scene: &Scene, [a, b]: [BodyId; 2], workspace: &mut Workspace) -> Vec<f64> {
    let [x, y] = [a, b].map(|id| scene.body(id).unwrap());
    let b_in_a = x.pose.inverse().unwrap().compose(&y.pose).unwrap();
    let query = Query::manifolds(&x.tree, &y.tree, b_in_a).skin(x.margin + y.margin);
    let found = query.run(workspace, Budget::unlimited().clock(&ManualClock::new()));
    assert_eq!(found.value.low, f64::INFINITY);
    let points = workspace.manifolds().iter().flat_map(|m| m.points());
    points.map(|point| point.distance).collect()
}

/// What a scene says of two bodies in a frame is true, wherever it was found. Whether that is all.
#[track_caller]
fn assert_true(scene: &Scene, [a, b]: [BodyId; 2], truth: &[f64]) -> bool {
    let found = scene.contacts(a, b).unwrap();
    assert_eq!(found, scene.contacts(b, a).unwrap());
    let [a, b] = [a.min(b), a.max(b)];
    let [x, y] = [a, b].map(|id| scene.body(id).unwrap());
    let b_in_a = x.pose.inverse().unwrap().compose(&y.pose).unwrap();
    let scale = 1.0 + x.pose.translation().length() + y.pose.translation().length();
    let rounding = 1e-12 * scale;
    let dot = Tree::new(Mesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap());
    for point in found.points {
        let [on_a, on_b] = point.points;
        for (tree, place) in [(&x.tree, on_a), (&y.tree, on_b)] {
            let there = Pose::new(DMat3::IDENTITY, place).unwrap();
            let query = Query::distance(tree, &dot, there);
            let off = query.run(&mut Workspace::new(), Budget::unlimited()).value;
            // The normal of a manifold stands for normals up to 7 degrees from it.
            let slant = 0.13 * point.distance.abs();
            assert!(off.low <= slant + 1e-6, "{point:?} {off:?}");
        }
        let was = on_a - point.distance * point.normal;
        let moved = (b_in_a.transform_point(on_b) - was).length();
        let off = found.drift + 0.01 * point.distance.abs() + 1e-7 + rounding;
        assert!(moved <= off, "{moved} of {found:?}");
        let now = point.at([&x.pose, &y.pose]);
        assert!((now.points[0] - x.pose.transform_point(on_a)).length() <= rounding);
        assert!((now.distance - point.distance).abs() <= off);
    }
    if found.is_complete() && found.points.is_empty() {
        let query = Query::distance(&x.tree, &y.tree, b_in_a);
        let gap = query.run(&mut Workspace::new(), Budget::unlimited()).value;
        assert!(gap.high >= found.low - 1e-7 - rounding, "{gap:?} {found:?}");
    }
    if found.is_complete() {
        assert_eq!(found.points.len(), truth.len().min(MOST_POINTS));
        let told = found.points.iter().map(|point| point.distance);
        let told = told.fold(f64::INFINITY, f64::min);
        let least = truth.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(
            told == least || (told - least).abs() <= 1e-7 + rounding,
            "{told} {least}"
        );
    }
    found.is_complete()
}

/// The same of a pair whose contacts nobody knows.
#[track_caller]
pub fn assert_told(scene: &Scene, pair: [BodyId; 2], workspace: &mut Workspace) {
    let truth = truth(scene, pair, workspace);
    assert_true(scene, pair, &truth);
}

fn pairs(ids: &[BodyId]) -> impl Iterator<Item = [BodyId; 2]> {
    ids.iter()
        .enumerate()
        .flat_map(|(i, &a)| ids[i + 1..].iter().map(move |&b| [a, b]))
}

/// Bodies of all shapes, some with margins.
fn crowd(bodies: usize, random: &mut Random) -> (Scene, Vec<BodyId>) {
    let trees = trees();
    let mut scene = Scene::new();
    let mut insert = |i: usize| {
        let tree = Arc::clone(&trees[random.below(trees.len())]);
        let margin = [0.05 * random.signed().abs(), 0.0, 0.0][i % 3];
        let body = Body::moving(tree, pose(2.0, random)).margin(margin);
        scene.insert(body).unwrap()
    };
    let ids = (0..bodies).map(&mut insert).collect();
    (scene, ids)
}

#[test]
fn contacts_are_true_at_every_budget() {
    let mut random = Random::new(51);
    let (mut scene, ids) = crowd(9, &mut random);
    scene.find_contacts();
    let mut workspace = Workspace::new();
    let (mut complete, mut cut, mut stale) = (0, 0, 0);
    for frame in 0..180 {
        if frame % 7 < 4 {
            for &id in &ids {
                let next = nudged(&scene.body(id).unwrap().pose, &mut random);
                scene.set_pose(id, next).unwrap();
            }
        }
        scene.set_mode([Mode::Any, Mode::Any, Mode::All][frame / 10 % 3]);
        let unlimited = frame % 5 == 0;
        let budget = match unlimited {
            true => Budget::unlimited(),
            false => Budget::work(LEAST_CONTACT_WORK << random.below(7)),
        };
        let report = detect(&mut scene, budget);
        assert!(unlimited || report.work <= LEAST_CONTACT_WORK << 6);
        let known = report.pairs.iter();
        let known = known.map(|pair| ([pair.a, pair.b], pair.verdict));
        let known: BTreeMap<_, _> = known.collect();
        for pair in pairs(&ids) {
            let contacts = truth(&scene, pair, &mut workspace);
            let is_all = assert_true(&scene, pair, &contacts);
            let found = scene.contacts(pair[0], pair[1]).unwrap();
            match known.get(&pair) {
                Some(Verdict::Intersecting { .. } | Verdict::Within { .. }) => {
                    let [x, y] = pair.map(|id| scene.body(id).unwrap().margin);
                    let few = contacts.len() <= MOST_POINTS;
                    let is_small = found.drift <= (x + y) / 4.0;
                    let is_right = is_small && (is_all || !few || found.drift > 0.0);
                    assert!(!unlimited || is_right, "{found:?}");
                }
                Some(Verdict::Separated) => {
                    assert!(found.points.is_empty() && is_all);
                    assert!(contacts.iter().all(|&apart| apart >= -1e-9));
                }
                _ => assert!(!unlimited || contacts.is_empty()),
            }
            complete += usize::from(is_all && !found.points.is_empty());
            cut += usize::from(found.drift == 0.0 && !is_all);
            stale += usize::from(found.drift > 0.0 && !found.points.is_empty());
        }
    }
    assert!(complete > 50 && cut > 0 && stale > 20, "{complete}");
}

/// K = 2 ⌈C/R⌉ + 1 frames hold for contacts too: of pairs that rest, and of those that move on and take no more than R.
#[test]
fn no_contact_waits_longer_than_promised() {
    let mut free = Scene::new();
    let ids = row(&mut free, 20);
    free.find_contacts();
    let touching = |scene: &Scene| -> Vec<[BodyId; 2]> {
        let pairs = scene.report().intersecting_pairs();
        pairs.map(|pair| [pair.a, pair.b]).collect()
    };
    let mut cost = 0;
    for frame in 0..60 {
        swing_all(&mut free, &ids, frame);
        cost = cost.max(2 * detect(&mut free, Budget::unlimited()).work);
    }
    for budget in [24 * LEAST_CONTACT_WORK, 200_000, 1_000_000] {
        let mut scene = Scene::new();
        let ids = row(&mut scene, 20);
        scene.find_contacts();
        let frames = (2 * (2 * cost).div_ceil(budget / 8) + 1) as usize;
        let is_told =
            |scene: &Scene, [a, b]: [BodyId; 2]| scene.contacts(a, b).unwrap().drift == 0.0;
        for used in 1.. {
            let report = detect(&mut scene, Budget::work(budget));
            assert!(report.work <= budget && used <= frames, "{used} {frames}");
            let is_decided = report.undecided() == 0;
            if is_decided && touching(&scene).iter().all(|pair| is_told(&scene, *pair)) {
                break;
            }
        }
        // In motion, each has its turn.
        let mut waiting = BTreeMap::new();
        let mut told = 0;
        for frame in 0..(2 * frames).min(200) {
            swing_all(&mut scene, &ids, frame);
            assert!(detect(&mut scene, Budget::work(budget)).work <= budget);
            for pair in pairs(&ids) {
                let found = scene.contacts(pair[0], pair[1]).unwrap();
                let waits = waiting.entry(pair).or_insert(0);
                // Those that are apart have nothing to tell.
                let apart = scene.report().pair(pair[0], pair[1]).is_none();
                *waits = if apart || found.drift == 0.0 {
                    0
                } else {
                    *waits + 1
                };
                told += usize::from(found.drift == 0.0 && !found.points.is_empty());
                assert!(*waits <= frames, "{pair:?} {waits} {frames}");
            }
        }
        assert!(told > 5, "{told}");
    }
}

#[test]
fn a_patch_keeps_its_id_while_bodies_slide() {
    let plate = Arc::new(Tree::new(shapes::cuboid(Vec3::new(2.0, 2.0, 0.1), 8)));
    let foot = Arc::new(Tree::new(shapes::cuboid(Vec3::splat(0.3), 2)));
    let mut scene = Scene::new();
    scene.find_contacts();
    let a = scene.insert(Body::fixed(plate, Pose::IDENTITY)).unwrap();
    let b = scene
        .insert(Body::moving(foot, Pose::IDENTITY).margin(0.01))
        .unwrap();
    let mut ids = Vec::new();
    for frame in 0..80 {
        let height = if (40..50).contains(&frame) {
            0.5
        } else {
            0.405
        };
        put(
            &mut scene,
            b,
            at(-1.0 + 0.02 * f64::from(frame), 0.1, height),
        );
        let free = Budget::unlimited();
        detect(
            &mut scene,
            [Budget::work(1 << 20), free, free][frame as usize % 3],
        );
        let found = scene.contacts(a, b).unwrap();
        assert!(
            found.is_complete() && found.points.len() == if height < 0.45 { 4 } else { 0 },
            "{found:?}"
        );
        ids.extend(found.points.iter().map(|point| point.manifold));
    }
    assert!(ids[..160].iter().all(|&id| id == ids[0]), "{ids:?}");
    assert!(
        ids[160..].iter().all(|&id| id == ids[160] && id != ids[0]),
        "it parted in between: {ids:?}"
    );
}

#[test]
fn contacts_of_chosen_pairs_come_and_go_with_their_bodies() {
    let ball = ball(2);
    let mut scene = Scene::new();
    let mut insert = |x| moving(&mut scene, &ball, at(x, 0.0, 0.0));
    let [a, b, c] = [0.0, 1.7, 3.4].map(&mut insert);
    assert_eq!(
        scene.find_contacts_of(b, b),
        Err(SceneError::OneBody { body: b })
    );
    scene.find_contacts_of(c, b).unwrap();
    let count = |scene: &Scene, x, y| scene.contacts(x, y).unwrap().points.len();
    whole_frame(&mut scene);
    assert_eq!((count(&scene, a, b), count(&scene, b, c)), (0, 4));
    assert!(!scene.contacts(a, b).unwrap().is_whole, "not asked");
    scene.stop_finding_contacts_of(b, c).unwrap();
    scene.find_contacts_of(a, b).unwrap();
    scene.set_pose(c, at(3.5, 0.0, 0.0)).unwrap();
    whole_frame(&mut scene);
    assert_eq!(
        (count(&scene, a, b), scene.contacts(b, c).unwrap().age),
        (4, 1)
    );
    scene.set_filter(a, Filter::new(1, 0)).unwrap();
    whole_frame(&mut scene);
    scene.remove(b).unwrap();
    assert!(scene.contacts(a, b).is_err() && scene.find_contacts_of(a, b).is_err());
    let other = scene.insert(Body::moving(ball, at(1.7, 0.0, 0.0))).unwrap();
    scene.set_filter(a, Filter::default()).unwrap();
    whole_frame(&mut scene);
    // It was asked of another body.
    assert_eq!((other.index(), count(&scene, a, other)), (b.index(), 0));
    scene.find_contacts();
    whole_frame(&mut scene);
    // They rest, but it was not asked before.
    assert_eq!(count(&scene, a, other), 4);
}

#[test]
fn contacts_between_groups_are_those_of_their_pairs() {
    let ball = ball(2);
    let groups = [1, 2, 4, 1, 3];
    for filters in [
        vec![Filter::new(1, 2)],
        vec![Filter::new(4, 4), Filter::new(2, 1)],
        vec![
            Filter::new(1, 1),
            Filter::new(8, u32::MAX),
            Filter::new(6, 4),
        ],
        vec![Filter::default()],
    ] {
        let mut scene = Scene::new();
        let ids = [0, 1, 2, 3, 4].map(|i| {
            let filter = Filter::new(groups[i], u32::MAX);
            let place = at(0.1 * i as f64, 0.0, 0.0);
            let body = Body::moving(Arc::clone(&ball), place).filter(filter);
            scene.insert(body).unwrap()
        });
        let group = |scene: &Scene, id| scene.body(id).unwrap().filter.groups;
        let mut asked = Vec::new();
        let check = |scene: &mut Scene, asked: &[Filter]| {
            for budget in [Budget::work(3_000), Budget::unlimited(), Budget::work(0)] {
                detect(scene, budget);
                assert!(scene.report().intersecting == 10 || budget != Budget::unlimited());
            }
            let mut found = 0;
            for [x, y] in pairs(&ids) {
                let [of_x, of_y] = [x, y].map(|id| group(scene, id));
                let is_asked = asked.iter().any(|&Filter { groups, mask, .. }| {
                    of_x & groups != 0 && of_y & mask != 0 || of_y & groups != 0 && of_x & mask != 0
                });
                let told = scene.contacts(x, y).unwrap();
                let is_found = told.drift == 0.0 && !told.points.is_empty();
                assert_eq!(is_found, is_asked, "{told:?}");
                found += usize::from(is_asked);
            }
            // Then all rest, and a frame more takes nothing.
            assert_eq!(detect(scene, Budget::work(0)).broad_phase_work, 0);
            scene.set_pose(ids[0], at(-0.1, 0.0, 0.0)).unwrap();
            ids.iter().for_each(|&id| _ = scene.tree_mut(id).unwrap());
            found
        };
        for &filter in &filters {
            scene.find_contacts_between(filter);
            asked.push(filter);
            check(&mut scene, &asked);
            scene.find_contacts_between(filter);
        }
        // Bodies change their groups.
        scene.set_filter(ids[0], Filter::new(4, u32::MAX)).unwrap();
        assert!(check(&mut scene, &asked) > 0);
        for &filter in &filters {
            scene.stop_finding_contacts_between(filter);
            asked.retain(|&other| other != filter);
            check(&mut scene, &asked);
            scene.stop_finding_contacts_between(filter);
        }
        scene.find_contacts_of(ids[1], ids[2]).unwrap();
        scene.find_contacts();
        check(&mut scene, &[Filter::default()]);
        scene.stop_finding_contacts_between(Filter::default());
        whole_frame(&mut scene);
        let drifts = [[1, 2], [0, 1]].map(|[x, y]| scene.contacts(ids[x], ids[y]).unwrap().drift);
        assert_eq!(drifts, [0.0, f64::INFINITY], "one of a pair stays");
    }
}

/// Of a budget that does not do for all, the question that matters more has more; and no other one starves.
#[test]
fn the_question_that_matters_more_goes_first() {
    let play = |weights: [f32; 3]| {
        let mut scene = Scene::new();
        let ids = row(&mut scene, 24);
        scene.find_contacts();
        for pair in ids.windows(2).step_by(2) {
            scene.measure(pair[0], pair[1], 1e-6).unwrap();
        }
        let questions = [
            PairQuestion::Meet,
            PairQuestion::Distance,
            PairQuestion::Contacts,
        ];
        for (question, weight) in questions.into_iter().zip(weights) {
            scene.set_question_importance(question, weight).unwrap();
        }
        let mut answered = [0; 3];
        for frame in 0..80 {
            swing_all(&mut scene, &ids, frame);
            detect(&mut scene, Budget::work(150_000));
            let report = scene.report();
            let measured =
                |a: BodyId, b: BodyId| scene.distances().any(|found| (found.a, found.b) == (a, b));
            let others = report.pairs.iter().filter(|pair| !measured(pair.a, pair.b));
            answered[0] += others
                .filter(|pair| pair.verdict != Verdict::Undecided)
                .count();
            answered[1] += scene
                .distances()
                .filter(|found| found.age == 0 && found.high - found.low <= 1e-6)
                .count();
            let told = |pair: [BodyId; 2]| scene.contacts(pair[0], pair[1]).unwrap();
            let told = pairs(&ids)
                .map(told)
                .filter(|found| found.drift == 0.0 && !found.points.is_empty());
            answered[2] += told.count();
        }
        assert!(answered.iter().all(|&count| count > 0), "{answered:?}");
        answered
    };
    // Contacts decide whether a pair meets, so that question never comes alone here.
    let [meet, distance, contacts] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(play);
    let text = format!("{meet:?} {distance:?} {contacts:?}");
    assert!(meet[0] > distance[0] && contacts[0] > distance[0], "{text}");
    assert!(distance[1] > meet[1] && distance[1] > contacts[1], "{text}");
    assert!(contacts[2] > distance[2] && meet[2] > distance[2], "{text}");
    let refused = Scene::new().set_question_importance(PairQuestion::Motion, f32::NAN);
    assert_eq!(
        refused,
        Err(SceneError::QuestionImportanceNotFinite {
            question: PairQuestion::Motion
        })
    );
}

/// Two balls fly at each other, and a frame is too short to look.
#[test]
fn bodies_that_were_apart_may_have_sunk_in_as_far_as_they_came() {
    let ball = ball(3);
    for work in [0, 1_500, 4_000] {
        let mut scene = Scene::new();
        scene.find_contacts();
        // Their boxes overlap.
        let place = |distance: f64| at(0.6 * distance, 0.8 * distance, 0.0);
        let [a, b] = [0.0, 2.015].map(|distance| {
            let body = Body::moving(Arc::clone(&ball), place(distance)).margin(0.005);
            scene.insert(body).unwrap()
        });
        let nothing = scene.contacts(a, b).unwrap();
        assert_eq!((nothing.low, nothing.drift), (0.0, f64::INFINITY));
        whole_frame(&mut scene);
        let apart = scene.contacts(a, b).unwrap();
        assert!(apart.drift == 0.0 && apart.low >= 0.01, "{apart:?}");
        for x in [1.985, 1.955] {
            scene.set_pose(b, place(x)).unwrap();
            let budget = if x < 1.96 { work } else { 0 };
            detect(&mut scene, Budget::work(budget));
            let found = scene.contacts(a, b).unwrap();
            if found.points.is_empty() {
                // The meshes are up to .004 inside of their balls.
                let room = found.low - found.drift;
                assert!((x - 2.02..=x - 1.992).contains(&room), "{work}");
            } else {
                assert_eq!((work, found.drift), (4_000, 0.0));
            }
        }
    }
}

/// Bodies that are apart in the last frame, and then change.
#[test]
fn a_frame_tells_nothing_false_of_bodies_that_change_after_it() {
    let ball = ball(3);
    let larger = Arc::new(Tree::new(shapes::cuboid(Vec3::splat(1.5), 4)));
    let place = |distance: f64| at(0.6 * distance, 0.8 * distance, 0.0);
    let room_after = |change: &dyn Fn(&mut Scene, BodyId)| {
        let mut scene = Scene::new();
        scene.find_contacts();
        let [a, b] = [0.0, 2.015].map(|distance| {
            let body = Body::moving(Arc::clone(&ball), place(distance)).margin(0.005);
            scene.insert(body).unwrap()
        });
        whole_frame(&mut scene);
        change(&mut scene, b);
        let found = scene.contacts(a, b).unwrap();
        assert!(found.points.is_empty(), "{found:?}");
        found.low - found.drift
    };
    // The meshes are up to .004 inside of their balls.
    let rests = room_after(&|_, _| ());
    assert!((0.01..=0.023).contains(&rests), "{rests}");
    let comes = room_after(&|scene, b| scene.set_pose(b, place(1.955)).unwrap());
    assert!((-0.065..=-0.037).contains(&comes), "{comes}");
    let thickens = room_after(&|scene, b| scene.set_margin(b, 0.3).unwrap());
    assert!(thickens <= 0.023, "{thickens}");
    let grows = room_after(&|scene, b| scene.set_tree(b, Arc::clone(&larger)).unwrap());
    assert!(grows == f64::NEG_INFINITY, "{grows}");
}

/// A ball in the hole of a ring: their boxes overlap, and they are far apart.
fn ball_in_a_ring(margin: f64) -> (Scene, [BodyId; 2], f64) {
    let ring = Arc::new(Tree::new(shapes::torus(1.0, 0.2, 24)));
    let ball = Arc::new(Tree::new(shapes::cuboid(Vec3::splat(0.1), 2)));
    let query = Query::distance(&ring, &ball, Pose::IDENTITY).absolute_tolerance(1e-12);
    let distance = query.run(&mut Workspace::new(), Budget::unlimited()).value;
    let mut scene = Scene::new();
    scene.find_contacts();
    let ids = [ring, ball].map(|tree| {
        let body = Body::moving(tree, Pose::IDENTITY).margin(margin);
        scene.insert(body).unwrap()
    });
    (scene, ids, distance.high)
}

#[test]
fn the_room_of_bodies_apart_is_what_is_proven_of_them() {
    let margin = 0.005;
    for moves in [false, true] {
        let (mut scene, [a, b], distance) = ball_in_a_ring(margin);
        let room = |scene: &mut Scene, x: f64| {
            if moves {
                scene.set_pose(b, at(x, 0.0, 0.0)).unwrap();
            }
            whole_frame(scene);
            let found = scene.contacts(a, b).unwrap();
            assert!(found.points.is_empty() && found.is_whole);
            found.low - found.drift
        };
        assert!(room(&mut scene, 1e-5) <= distance);
        // Measured, and found out ahead.
        scene.measure(a, b, 1e-4).unwrap();
        let measured = room(&mut scene, 2e-5);
        assert!(
            distance - 1e-3 < measured && measured <= distance,
            "{measured}"
        );
        // Moved after the frame: less of it is left.
        scene.set_pose(b, at(0.1, 0.0, 0.0)).unwrap();
        let found = scene.contacts(a, b).unwrap();
        let left = found.low - found.drift;
        assert!(
            distance - 0.102 < left && left <= distance - 0.0999,
            "{left}"
        );
    }
}

#[test]
fn contacts_look_ahead_as_far_as_asked() {
    for (ahead, least) in [(0.0, 0.0), (0.05, 0.05), (10.0, 0.8)] {
        let (mut scene, [a, b], distance) = ball_in_a_ring(0.005);
        scene.set_look_ahead(ahead).unwrap();
        let mut works = Vec::new();
        for step in 0..4 {
            put(&mut scene, b, at(1e-4 * f64::from(step), 0.0, 0.0));
            whole_frame(&mut scene);
            works.push(scene.report().work);
            let found = scene.contacts(a, b).unwrap();
            let left = found.low - found.drift;
            let least = if ahead > 1.0 { least * distance } else { least };
            assert!(least * 0.99 <= left && left <= distance, "{ahead}: {left}");
        }
        // Not asked again before the room is used up.
        assert!(ahead == 0.0 || works[1..] == [0; 3], "{works:?}");
    }
    let mut scene = Scene::new();
    for length in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = scene.set_look_ahead(length);
        assert!(matches!(
            refused,
            Err(SceneError::LookAheadNotALength { .. })
        ));
    }
}

/// Sunk boxes with flush sides had one true corner of four.
#[test]
fn stacks_of_boxes_have_four_true_corners_a_foot() {
    let plain = BuildOptions::default();
    let trees = [plain, plain.solid(Solid::Keep)]
        .map(|options| Arc::new(Tree::with_options(shapes::cuboid([0.5; 3], 1), &options)));
    let gaps = [0.0, 1e-3, -1e-3, 1e-6, -1e-6, 1e-9, -1e-9, 1e-12, -1e-12];
    for (trial, count) in (2..=20).enumerate() {
        for (number, gap) in gaps.into_iter().enumerate() {
            let aside = [0.0, 1e-12, 1e-9, 1e-6, 1e-3][(trial + number) % 5];
            let angle = if trial % 3 == 0 {
                0.0
            } else {
                0.1 * trial as f64
            };
            let turn = DMat3::from_rotation_y(angle);
            let mut scene = Scene::new();
            scene.find_contacts();
            let ids: Vec<BodyId> = (0..count)
                .map(|i| {
                    let height = f64::from(i) * (1.0 + gap);
                    let place = DVec3::new(aside * f64::from(i % 2), 0.0, height);
                    let pose = Pose::new(turn, turn * place).unwrap();
                    let tree = Arc::clone(&trees[trial % 2]);
                    scene.insert(Body::moving(tree, pose).margin(2e-3)).unwrap()
                })
                .collect();
            whole_frame(&mut scene);
            for pair in ids.windows(2) {
                let found = scene.contacts(pair[0], pair[1]).unwrap();
                assert!(found.is_complete());
                assert_eq!(found.points.len(), 4, "{count} gap {gap:e}: {found:?}");
                for point in found.points {
                    assert!(
                        (point.distance - gap).abs() < 1e-11 + 1e-6 * gap.abs(),
                        "{point:?}"
                    );
                    let off = point.points[0].abs() - DVec3::splat(0.5);
                    assert!(off.abs().max_element() < 1e-6 + aside, "{aside:e}");
                }
            }
        }
    }
}
