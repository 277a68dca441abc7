//! Promises of a scene, each tried where it once did not hold.

use std::sync::Arc;
use std::time::Duration;

use crate::common::ask::answer;
use crate::common::random::Random;
use crate::common::reference::posed_triangles;
use crate::{
    anywhere, at, ball, detect, fixed, moving, nudged, pose, put, sweep, trees, whole_frame,
};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Aabb, Budget, BuildOptions, Mode, Motion, Pose, Query, Tree, Verdict, shapes};
use punctual_scene::{Body, BodyId, Filter, PairReport, Reach, Report, Scene, SceneError};

/// A turn about the z axis through the origin.
fn turned(angle: f64) -> DMat3 {
    DMat3::from_rotation_z(angle)
}

fn knot() -> Arc<Tree> {
    let options = BuildOptions::default().extremes(true);
    let mesh = shapes::torus_knot(2, 3, 0.2, 64);
    Arc::new(Tree::with_options(mesh, &options))
}

/// Two knots that overlap, and how many pairs of their triangles meet.
fn crossing(scene: &mut Scene) -> ([BodyId; 2], u64) {
    let tree = knot();
    let found = answer(&Query::all_pairs(&tree, &tree, at(0.4, 0.3, 0.1)))
        .stats
        .found;
    assert!(found > 20);
    let poses = [Pose::IDENTITY, at(0.4, 0.3, 0.1)];
    (poses.map(|pose| moving(scene, &tree, pose)), found)
}

#[test]
fn another_mode_is_another_question() {
    let mut scene = Scene::new();
    let ([a, b], found) = crossing(&mut scene);
    let any = whole_frame(&mut scene).pairs[0];
    assert!(any.complete && any.found == 1);
    scene.set_mode(Mode::All);
    // Nothing is known yet.
    assert!(scene.certificate(a, b).unwrap().upper_bound >= found);
    // Too little to begin: what was complete for the other question is not for this one.
    let none = detect(&mut scene, Budget::work(0)).pairs[0];
    assert_eq!((none.complete, none.verdict), (false, Verdict::Undecided));
    assert!(scene.certificate(a, b).unwrap().upper_bound >= found);
    let all = whole_frame(&mut scene).pairs[0];
    assert_eq!((all.complete, all.found), (true, found));
    assert_eq!(scene.certificate(a, b).unwrap().upper_bound, found);
    scene.set_mode(Mode::Any);
    let any = whole_frame(&mut scene).pairs[0];
    assert_eq!((any.complete, any.found), (true, 1));
}

#[test]
fn nothing_is_proven_before_the_first_frame_or_of_what_changed_since() {
    let mut scene = Scene::new();
    scene.set_mode(Mode::All);
    let ([a, b], found) = crossing(&mut scene);
    let all = |scene: &Scene| scene.certificate(a, b).unwrap().upper_bound;
    let whole = knot().mesh().len().pow(2) as u64;
    assert_eq!(all(&scene), whole);
    whole_frame(&mut scene);
    assert_eq!(all(&scene), found);
    scene.set_pose(b, at(0.4, 0.3, 0.11)).unwrap();
    assert_eq!(all(&scene), whole);
    assert!(scene.certificate(a, b).unwrap().largest_extent > 1.0);
    whole_frame(&mut scene);
    assert!(all(&scene) < whole);
    let c = moving(&mut scene, &knot(), at(0.1, 0.1, 0.1));
    assert_eq!(scene.certificate(c, a).unwrap().upper_bound, whole);
    whole_frame(&mut scene);
    scene.tree_mut(c).unwrap();
    assert_eq!(scene.certificate(c, a).unwrap().upper_bound, whole);
}

/// Who may not meet is not compared, so nothing is known of it.
#[test]
fn nothing_is_proven_of_bodies_that_may_not_meet() {
    let mut scene = Scene::new();
    let alone = Filter::new(1, 0);
    let a = fixed(&mut scene, &knot(), Pose::IDENTITY);
    let b = fixed(&mut scene, &knot(), at(0.4, 0.3, 0.1));
    let c = scene
        .insert(Body::moving(knot(), at(0.2, 0.3, 0.1)).filter(alone))
        .unwrap();
    assert!(whole_frame(&mut scene).pairs.is_empty());
    for (x, y) in [(a, b), (b, c), (c, a)] {
        assert!(scene.certificate(x, y).unwrap().upper_bound > 1_000);
    }
}

/// Balls that roll around one another and touch, in pairs far apart, and one pair of knots that rests.
fn moving_contacts(scene: &mut Scene, count: usize) -> (Vec<BodyId>, [BodyId; 2]) {
    let ball = ball(2);
    let mut pair = |pair| {
        let center = at(10.0 * pair as f64, 0.0, 0.0);
        fixed(scene, &ball, center);
        moving(scene, &ball, center)
    };
    let rolling = (0..count).map(&mut pair).collect();
    let rests = fixed(scene, &knot(), at(0.0, 50.0, 0.0));
    let beside = moving(scene, &knot(), at(0.9, 50.8, 0.7));
    (rolling, [rests, beside])
}

fn roll(scene: &mut Scene, moving: &[BodyId], frame: usize) {
    for (pair, &body) in moving.iter().enumerate() {
        let turn = turned(0.2 * frame as f64 + pair as f64);
        let place = DVec3::new(10.0 * pair as f64, 0.0, 0.0) + turn * DVec3::X * 1.9;
        put(scene, body, Pose::new(turn, place).unwrap());
    }
}

#[test]
fn no_budget_of_work_is_passed_however_small() {
    let around = [119, 120, 601, 602, 603, 1_204, 1_323, 1_324, 1_919, 1_920];
    for budget in (0..2_600).step_by(61).chain(around) {
        let mut scene = Scene::new();
        let (moving, _) = moving_contacts(&mut scene, 40);
        roll(&mut scene, &moving, 0);
        // Now there are witnesses.
        whole_frame(&mut scene);
        for frame in 1..12 {
            roll(&mut scene, &moving, frame);
            let work = detect(&mut scene, Budget::work(budget)).work;
            assert!(work <= budget, "{work} of {budget} in frame {frame}");
            assert!(work > 0 || budget < 602, "{budget} does nothing");
        }
    }
}

/// K = 2 ⌈C/R⌉ + 1, R = B/8, from the smallest budget that is promised on.
#[test]
fn a_pair_that_rests_beside_moving_contacts_is_decided_within_k_frames() {
    // What all pairs take to their ends.
    let mut free = Scene::new();
    let (moving, [_, b]) = moving_contacts(&mut free, 40);
    let mut cost = 0;
    for frame in 0..20 {
        roll(&mut free, &moving, frame);
        free.set_pose(b, at(0.9, 50.8, 0.7 + 1e-3 * frame as f64))
            .unwrap();
        cost = cost.max(detect(&mut free, Budget::unlimited()).work);
    }
    let mut scene = Scene::new();
    let (moving, [x, y]) = moving_contacts(&mut scene, 40);
    let budgets = [602, 800, 1_300, 1_920, 2_600, 5_000];
    for (place, budget) in budgets.into_iter().enumerate() {
        let k = 2 * (2 * cost).div_ceil(budget / 8) + 1;
        put(&mut scene, y, at(0.9, 50.8, 0.7 + 1e-3 * place as f64));
        let mut is_decided = |frame: &u64| {
            roll(&mut scene, &moving, *frame as usize);
            let report = detect(&mut scene, Budget::work(budget));
            let pair = report.pair(x, y);
            pair.is_some_and(|pair| pair.verdict != Verdict::Undecided)
        };
        assert!((0..k).find(&mut is_decided).is_some(), "{budget}");
    }
}

/// Exact tests differ a hundredfold in time, so near the deadline the clock is asked after each, in a scene as in a query.
#[test]
fn near_the_deadline_a_scene_asks_the_clock_after_a_few_exact_tests() {
    let cube = Arc::new(Tree::new(shapes::cuboid(Vec3::ONE, 4)));
    let query = Query::all_pairs(&cube, &cube, at(1e-300, 0.0, 0.0));
    let exact_tests = answer(&query).stats.exact_tests;
    assert!(exact_tests > 100);
    let mut scene = Scene::new();
    scene.set_mode(Mode::All);
    for x in [0.0, 1e-300] {
        moving(&mut scene, &cube, at(x, 0.0, 0.0));
    }
    let tick = Duration::from_nanos(1);
    let clock = ManualClock::ticking(tick);
    let report = scene.detect(Budget::time(Duration::from_micros(30)).clock(&clock));
    assert!(report.pairs[0].complete);
    // 10,000 units at the slowest pace, and 3,000 for each.
    assert!(report.elapsed.unwrap() >= tick * exact_tests as u32 / 4);
}

/// A ball on an arm of length 10 that turns about its joint passes a post between two frames.
#[test]
fn a_body_on_the_arc_of_an_arm_is_reported() {
    let arm = ball(1);
    let post = Arc::new(Tree::new(shapes::cuboid(Vec3::new(0.05, 0.05, 2.0), 1)));
    let on_arm = |angle: f64| Pose::new(turned(angle), turned(angle) * DVec3::X * 10.0).unwrap();
    for (degrees, expected) in [(60.0, 1), (120.0, 1), (180.0, 1), (60.0, 1)] {
        let angle = f64::to_radians(degrees);
        let mut scene = Scene::new();
        scene.set_reach(Reach::Swept);
        // In the middle of the arc, beyond the straight line between its ends.
        let place = turned(angle / 2.0) * DVec3::X * 10.9;
        fixed(
            &mut scene,
            &post,
            Pose::new(DMat3::IDENTITY, place).unwrap(),
        );
        let ball = moving(&mut scene, &arm, on_arm(0.0));
        assert_eq!(whole_frame(&mut scene).pairs.len(), 0);
        scene.set_pose(ball, on_arm(angle)).unwrap();
        assert_eq!(
            whole_frame(&mut scene).pairs.len(),
            expected,
            "{degrees} degrees"
        );
        // It rests now.
        assert_eq!(whole_frame(&mut scene).pairs.len(), 0);
    }
}

/// The squares of such a way overflow.
#[test]
fn a_removed_body_meets_no_body_that_sweeps_past() {
    let tree = ball(0);
    let mut scene = Scene::new();
    scene.set_reach(Reach::Swept);
    let post = fixed(&mut scene, &tree, at(5.0, 0.0, 0.0));
    let far = Pose::new(turned(1.0), DVec3::NEG_Z * 1e228).unwrap();
    let ball = scene.insert(Body::moving(Arc::clone(&tree), far)).unwrap();
    let other = fixed(&mut scene, &tree, at(-5.0, 0.0, 0.0));
    whole_frame(&mut scene);
    scene.set_pose(ball, Pose::IDENTITY).unwrap();
    scene.remove(post).unwrap();
    let report = whole_frame(&mut scene);
    assert!(
        report.pairs.len() == 1 && report.pair(ball, other).is_some(),
        "{:?}",
        report.pairs
    );
    // Nor is what comes in its place met twice.
    scene.insert(Body::fixed(tree, at(5.0, 0.0, 0.0))).unwrap();
    scene.set_pose(ball, far).unwrap();
    whole_frame(&mut scene);
    whole_frame(&mut scene);
    scene.set_pose(ball, Pose::IDENTITY).unwrap();
    assert_eq!(whole_frame(&mut scene).pairs.len(), 2);
}

/// Every point of every place on the way lies in the swept box: a body with a hole the size of its box would be missed.
#[test]
fn swept_boxes_hold_the_whole_screw() {
    let tree = Arc::new(Tree::new(shapes::gear(9, 2)));
    let probe = ball(0);
    let mut random = crate::common::random::Random::new(3);
    for _ in 0..60 {
        let axis = random.vector().normalize();
        let (angle, slide) = (3.1 * random.unit(), 4.0 * random.signed());
        let through = 6.0 * random.vector();
        let start = Pose::new(random.rotation(), 3.0 * random.vector()).unwrap();
        let screw = |s: f64| {
            let turn = DMat3::from_axis_angle(axis, angle * s);
            let screw = Pose::new(turn, through - turn * through + axis * slide * s).unwrap();
            screw.compose(&start).unwrap()
        };
        let mut scene = Scene::new();
        scene.set_reach(Reach::Swept);
        let body = moving(&mut scene, &tree, screw(0.0));
        whole_frame(&mut scene);
        // A small probe at a corner of the mesh somewhere on its way.
        let middle = screw(random.unit());
        let corners = posed_triangles(tree.mesh(), &middle);
        let corner = corners[random.below(corners.len())][0];
        let shrink = 1e-3 * DMat3::IDENTITY;
        let small: Vec<[f64; 3]> = (0..probe.mesh().vertex_count())
            .map(|i| (shrink * probe.mesh().vertex(i) + corner).to_array())
            .collect();
        let mesh =
            punctual::Mesh::from_f64(small, probe.mesh().triangles().iter().copied()).unwrap();
        let other = scene
            .insert(Body::fixed(Arc::new(Tree::new(mesh)), Pose::IDENTITY))
            .unwrap();
        scene.set_pose(body, screw(1.0)).unwrap();
        let report = whole_frame(&mut scene);
        assert!(report.pair(body, other).is_some(), "{angle} {slide}");
    }
}

/// The way begins where the body was in the frame before, whatever boxes were compared then.
#[test]
fn another_reach_takes_effect_from_the_frame_before_on() {
    let ball = ball(1);
    let mut scene = Scene::new();
    fixed(&mut scene, &ball, at(0.0, 0.0, 0.0));
    let bullet = scene
        .insert(Body::moving(ball, at(-10.0, 0.0, 0.0)))
        .unwrap();
    for x in [-10.0, 10.0, 20.0] {
        scene.set_pose(bullet, at(x, 0.0, 0.0)).unwrap();
        assert_eq!(whole_frame(&mut scene).pairs.len(), 0);
    }
    scene.set_reach(Reach::Swept);
    scene.set_pose(bullet, at(30.0, 0.0, 0.0)).unwrap();
    // It passed long ago.
    assert_eq!(whole_frame(&mut scene).pairs.len(), 0);
    scene.set_pose(bullet, at(-30.0, 0.0, 0.0)).unwrap();
    assert_eq!(whole_frame(&mut scene).pairs.len(), 1);
}

/// Of ids of removed bodies, of other scenes, and of none at all; of the others where two are asked for.
#[test]
fn every_call_refuses_a_body_that_is_not_there() {
    let mut scene = Scene::new();
    let [a, b] = [0.0, 1.0].map(|x| scene.insert(Body::moving(knot(), at(x, 0.0, 0.0))).unwrap());
    scene.remove(b).unwrap();
    let motion = Motion::straight(Pose::IDENTITY, [1.0; 3]).unwrap();
    let again = moving(&mut scene, &knot(), at(1.0, 0.0, 0.0));
    assert_eq!(again.index(), b.index());
    for frame in 0..2 {
        for gone in [b, BodyId::from_bits(u64::MAX), BodyId::from_bits(7)] {
            let mut refused = Vec::new();
            macro_rules! refuse {
                ($($call:ident($($argument:expr),*))*) => {
                    $(refused.push(scene.$call($($argument),*).map(drop).unwrap_err());)*
                };
            }
            refuse! {
                remove(gone)
                body(gone)
                set_pose(gone, Pose::IDENTITY)
                set_motion(gone, motion)
                set_tree(gone, knot())
                tree_mut(gone)
                set_filter(gone, Filter::default())
                set_importance(gone, 1.0)
                set_margin(gone, 1.0)
                compound_of(gone)
                partners_known(gone)
                measure_groups(&[a], &[again, gone], 0.0)
            }
            for [x, y] in [[a, gone], [gone, a], [gone, gone]] {
                refuse! {
                    measure(x, y, 0.0)
                    stop_measuring(x, y)
                    find_contacts_of(x, y)
                    stop_finding_contacts_of(x, y)
                    contacts(x, y)
                    certificate(x, y)
                }
            }
            let is_it = |error: &SceneError| *error == SceneError::NoSuchBody { body: gone };
            assert!(refused.iter().all(is_it), "{refused:?}");
            assert_eq!(scene.report().pair(a, gone), None);
        }
        let alone = [
            scene.measure(a, a, 0.0).unwrap_err(),
            scene.stop_measuring(a, a).unwrap_err(),
            scene.find_contacts_of(a, a).unwrap_err(),
            scene.stop_finding_contacts_of(a, a).unwrap_err(),
            scene.contacts(a, a).map(drop).unwrap_err(),
            scene.certificate(a, a).map(drop).unwrap_err(),
        ];
        assert_eq!(alone, [SceneError::OneBody { body: a }; 6]);
        let report = whole_frame(&mut scene);
        assert!(report.frame == frame + 1 && report.group_distances.is_empty());
        assert_eq!(scene.distances().count(), 0);
    }
}

/// So far out that rounding is as large as the gap, nothing is proven of the start of a motion.
#[test]
fn pairs_within_rounding_are_complete_with_a_probability_of_one_half() {
    let ball = ball(1);
    let mut scene = Scene::new();
    let [a, b] = [0.0, 2.001].map(|x| moving(&mut scene, &ball, at(1e12 + x, 0.0, 0.0)));
    let report = whole_frame(&mut scene);
    // At rest.
    assert_eq!(report.pair(a, b).unwrap().verdict, Verdict::Separated);
    sweep(
        &mut scene,
        b,
        Motion::straight(at(1e12 + 2.001, 0.0, 0.0), [-0.01, 0.0, 0.0]).unwrap(),
    );
    for budget in [Budget::unlimited(), Budget::work(0)] {
        let report = detect(&mut scene, budget);
        let pair = report.pair(a, b).unwrap();
        assert_eq!(
            (pair.verdict, pair.complete, pair.probability),
            (Verdict::Undecided, true, 0.5)
        );
        assert_eq!(scene.passages().next().unwrap().free_until, 0.0);
    }
}

/// Without a body, with one, and with groups and compounds of none, whatever the budget.
#[test]
fn a_scene_of_nothing_says_so() {
    let mut scene = Scene::new();
    scene.track_contacts();
    scene.find_contacts();
    let time = |nanos| Budget::time(Duration::from_nanos(nanos));
    let budgets = [
        Budget::work(0),
        Budget::work(u64::MAX),
        time(0),
        time(u64::MAX),
        Budget::unlimited(),
    ];
    let mut groups = 0;
    for step in 0..4 {
        for budget in budgets {
            let report = detect(&mut scene, budget);
            assert!(report.pairs.is_empty() && report.contacts.is_empty());
            assert_eq!((report.work, report.undecided()), (0, 0));
            assert_eq!(report.group_distances.len(), groups);
            for found in &report.group_distances {
                let told = (found.low, found.high, found.open);
                assert_eq!(told, (f64::INFINITY, f64::INFINITY, 0));
            }
        }
        assert!(scene.report().is_whole());
        match step {
            0 => {
                scene.measure_groups(&[], &[], 0.0).unwrap();
                groups = 1;
            }
            1 => {
                let id = scene.insert_compound(Pose::IDENTITY, []).unwrap();
                assert_eq!(scene.parts(id).unwrap().len(), 0);
            }
            _ => _ = fixed(&mut scene, &knot(), Pose::IDENTITY),
        }
    }
}

#[test]
fn boxes_intersect_where_both_are() {
    let cube = |low, high| Aabb::new(DVec3::splat(low), DVec3::splat(high));
    let unit = cube(0.0, 1.0);
    assert_eq!(unit.intersection(&cube(0.5, 3.0)), cube(0.5, 1.0));
    assert!(unit.intersection(&cube(2.0, 3.0)).is_empty());
}

/// A scene that knows it has nothing to do, beside one that is told of a change that is none, and so looks at everything.
#[test]
fn frames_in_which_nothing_changed_say_what_a_look_at_all_pairs_says() {
    let (trees, mut rests) = (trees(), 0);
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let mut scenes = [Scene::new(), Scene::new()];
        if seed % 2 == 1 {
            scenes.iter_mut().for_each(Scene::track_contacts);
        }
        if seed % 3 == 2 {
            scenes.iter_mut().for_each(Scene::find_contacts);
        }
        let mut ids = Vec::<BodyId>::new();
        for _ in 0..60 {
            let chosen = random.below(ids.len().max(1));
            let mut both = |change: &dyn Fn(&mut Scene)| scenes.iter_mut().for_each(change);
            match random.below(12) {
                0 | 1 => {
                    let tree = &trees[random.below(trees.len())];
                    let pose = pose(2.0, &mut random);
                    let [id, same] = scenes.each_mut().map(|scene| moving(scene, tree, pose));
                    assert_eq!(id, same);
                    ids.push(anywhere(id));
                }
                2 if !ids.is_empty() => {
                    let id = ids.swap_remove(chosen);
                    both(&|scene| drop(scene.remove(id).unwrap()));
                }
                3 | 4 if !ids.is_empty() => {
                    let id = ids[chosen];
                    let place = nudged(&scenes[0].body(id).unwrap().pose, &mut random);
                    scenes.iter_mut().for_each(|scene| put(scene, id, place));
                }
                5 => {
                    let mode = [Mode::Any, Mode::All][random.below(2)];
                    both(&|scene| scene.set_mode(mode));
                }
                6 => {
                    let reach = [Reach::Here, Reach::Swept][random.below(2)];
                    both(&|scene| scene.set_reach(reach));
                }
                7 if ids.len() > 1 && random.below(3) == 0 => {
                    let call = match random.below(2) {
                        0 => Scene::stop_finding_contacts_of,
                        _ => Scene::find_contacts_of,
                    };
                    both(&|scene| call(scene, ids[0], ids[1]).unwrap());
                }
                _ => {}
            }
            if let Some(&id) = ids.first() {
                scenes[1].set_importance(id, 1.0).unwrap();
            }
            let [rested, looked] = scenes.each_mut().map(|scene| {
                let mut report = whole_frame(scene).clone();
                let spent = std::mem::take(&mut report.broad_phase_work);
                (report.work, report.bv_tests) = (0, 0);
                let pairs = ids
                    .iter()
                    .enumerate()
                    .flat_map(|(i, &a)| ids[..i].iter().map(move |&b| (a, b)));
                let points: Vec<_> = pairs.map(|(a, b)| scene.contacts(a, b).unwrap()).collect();
                (format!("{report:?} {points:?}"), spent)
            });
            assert_eq!(rested.0, looked.0, "seed {seed}");
            rests += usize::from(rested.1 == 0 && looked.1 > 0);
        }
    }
    assert!(rests > 400, "{rests}");
}

/// A pair is as old after a rest as if all had been looked at in each frame of it, and as likely to meet. While
/// it rests undecided, its probability stays.
#[test]
fn after_a_rest_a_pair_is_as_old_as_if_it_had_been_looked_at() {
    let ball = ball(2);
    // Balls that meet, and others whose boxes overlap.
    for place in [1.3, 1.5] {
        let mut scenes = [Scene::new(), Scene::new()];
        let [ids, _] = scenes.each_mut().map(|scene| {
            scene.track_contacts();
            [0.0, place].map(|x| anywhere(moving(scene, &ball, at(x, x, 0.0))))
        });
        let mut before = None;
        for frame in 0..30 {
            if frame == 12 {
                scenes
                    .iter_mut()
                    .for_each(|scene| put(scene, ids[1], at(place + 0.01, place, 0.0)));
            }
            scenes[1].set_importance(ids[0], 1.0).unwrap();
            // Nothing is decided in some frames after the rest.
            let is_free = [0, 18].contains(&frame);
            let budget = [Budget::work(0), Budget::unlimited()][usize::from(is_free)];
            let [rested, mut looked] = scenes.each_mut().map(|scene| {
                let report = detect(scene, budget);
                (report.frame, report.pairs.clone(), report.contacts.clone())
            });
            let stays = rested.1[0].probability;
            if (13..18).contains(&frame) {
                assert_eq!(stays, *before.get_or_insert(stays), "frame {frame}");
                looked.1[0].probability = stays;
            }
            assert_eq!(rested, looked);
            let waited = if (12..18).contains(&frame) {
                frame - 11
            } else {
                0
            };
            assert_eq!(rested.1[0].age, waited, "frame {frame}");
        }
    }
}

/// Balls in a heap whose neighbors touch, or are within their margins. `question`: what is asked of them.
fn heap(question: &str) -> Scene {
    let options = BuildOptions::default().extremes(true);
    let ball = Arc::new(Tree::with_options(shapes::icosphere(2), &options));
    let mut scene = Scene::new();
    if question == "contacts" {
        scene.find_contacts();
    }
    let margin = if question == "whether" { 0.0 } else { 0.005 };
    // More pairs than a frame of little work lists.
    let places = (0..125).map(|i| [i % 5, i / 5 % 5, i / 25].map(|k| 1.99 * f64::from(k)));
    let ids: Vec<_> = places
        .map(|[x, y, z]| Body::moving(Arc::clone(&ball), at(x, y, z)).margin(margin))
        .map(|body| scene.insert(body).unwrap())
        .collect();
    if question == "groups" {
        scene.measure_groups(&ids[..8], &ids[8..20], 1e-3).unwrap();
        scene.measure_groups(&ids[..4], &ids[40..], 1e-3).unwrap();
    }
    scene
}

/// A frame goes on with the list and the runs of the last one. So all is known after as many frames as the work
/// takes, however little a frame does; then a frame does nothing.
#[test]
fn bodies_at_rest_are_known_after_their_work_and_then_cost_nothing() {
    for (question, least) in [
        ("whether", 1_000),
        ("margins", 2_000),
        ("contacts", 4_000),
        ("groups", 2_000),
    ] {
        let mut free = heap(question);
        let mut whole_work = 0;
        while !rests(detect(&mut free, Budget::work(1 << 40))) {
            whole_work += free.report().work;
        }
        let whole = free.report().clone();
        for budget in [least, 10_000, 100_000, 1_000_000] {
            let mut scene = heap(question);
            let (mut frames, mut work) = (0, 0);
            while !rests(detect(&mut scene, Budget::work(budget))) {
                frames += 1;
                work += scene.report().work;
                // A frame answers a pair, or spends half of its budget.
                let most = 2 * (whole.pairs.len() as u64 + work / budget);
                assert!(frames <= 50 + most, "{question} {budget} {frames} {most}");
                assert!(work <= 2 * whole_work, "{question} {budget}: {work}");
            }
            let verdicts = |report: &Report| {
                let told = |pair: &PairReport| (pair.a, pair.b, pair.verdict.meets());
                report.pairs.iter().map(told).collect::<Vec<_>>()
            };
            if question != "groups" {
                assert_eq!(verdicts(scene.report()), verdicts(&whole), "{question}");
            }
        }
    }
}

/// True if a frame found that nothing is left to do.
fn rests(report: &Report) -> bool {
    let all = report.pairs.len();
    let groups = &report.group_distances;
    report.is_whole()
        && [report.decided, report.complete] == [all; 2]
        && groups.iter().all(|group| group.open == 0)
        && (report.work, report.broad_phase_work) == (0, 0)
}
