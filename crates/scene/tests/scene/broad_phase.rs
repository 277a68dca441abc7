//! A broad phase that is cut short by its budget, or by the room for pairs: nothing it says is false, and nothing is lost.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use crate::common::random::Random;
use crate::{anywhere, ball, detect, fixed, moving, put, whole_frame};
use punctual::clock::ManualClock;
use punctual::geom::triangles_intersect;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Budget, Mesh, Pose, Tree, Verdict, shapes};
use punctual_scene::{Body, BodyId, Filter, PairReport, Reach, Report, Scene};

/// What the broad phase may spend beyond a budget of work.
const BROAD_PHASE_WORK: u64 = 1 << 16;

fn at(place: DVec3) -> Pose {
    Pose::new(DMat3::IDENTITY, place).unwrap()
}

/// Balls of radius 1 somewhere in a cube, every fifth fixed.
fn crowd(scenes: &mut [&mut Scene], bodies: usize, half: f64, random: &mut Random) -> Vec<BodyId> {
    let ball = ball(0);
    let mut insert = |i: usize| {
        let make = if i % 5 == 4 {
            Body::fixed
        } else {
            Body::moving
        };
        let body = make(Arc::clone(&ball), at(half * random.vector()));
        anywhere(
            scenes
                .iter_mut()
                .map(|scene| scene.insert(body.clone()).unwrap())
                .last()
                .unwrap(),
        )
    };
    (0..bodies).map(&mut insert).collect()
}

fn meets(pair: &PairReport) -> bool {
    matches!(pair.verdict, Verdict::Intersecting { .. })
}

/// Nothing that a report says is false, by that of an unlimited frame, and what it does not know it does not claim.
#[track_caller]
fn assert_honest(scene: &Scene, truth: &Report) {
    let report = scene.report();
    assert!(
        report
            .pairs
            .windows(2)
            .all(|two| (two[0].a.index(), two[0].b.index()) < (two[1].a.index(), two[1].b.index()))
    );
    for pair in report
        .pairs
        .iter()
        .filter(|pair| pair.verdict != Verdict::Undecided)
    {
        assert_eq!(meets(pair), truth.pair(pair.a, pair.b).is_some_and(meets));
        assert_eq!(pair.age, 0);
    }
    let known = |id| scene.partners_known(anywhere(id)).unwrap();
    for pair in truth
        .pairs
        .iter()
        .filter(|pair| report.pair(pair.a, pair.b).is_none())
    {
        let claimed = known(pair.a) && known(pair.b) && report.unlisted == 0;
        assert!(!claimed && !report.is_whole(), "{pair:?} is lost");
        assert!(
            scene
                .certificate(anywhere(pair.a), anywhere(pair.b))
                .unwrap()
                .upper_bound
                >= pair.found
        );
    }
    let open = scene.bodies().filter(|&(id, _)| !known(id)).count();
    assert!(open <= report.unplaced + report.unpaired, "{open} bodies");
    assert_eq!(
        report.is_whole(),
        open == 0 && report.unlisted == 0 && (report.unplaced, report.unpaired) == (0, 0)
    );
    let decided = report
        .pairs
        .iter()
        .filter(|pair| pair.verdict != Verdict::Undecided)
        .count();
    assert_eq!(
        report.undecided(),
        report.pairs.len() - decided + report.unlisted
    );
}

#[test]
fn nothing_runs_past_the_budget_with_2000_bodies_in_one_place() {
    for (budget, limit) in [(20_000, 1 << 20), (400_000, 30_000)] {
        let (mut scene, mut random) = (Scene::new(), Random::new(1));
        scene.set_max_pairs(limit);
        let ids = crowd(&mut [&mut scene], 2_000, 0.2, &mut random);
        let mut decided = 0;
        for frame in 0..60 {
            if frame > 30 {
                for &id in &ids {
                    scene.set_pose(id, at(0.2 * random.vector())).unwrap();
                }
            }
            let report = detect(&mut scene, Budget::work(budget));
            assert!(report.work <= budget, "{} of {budget}", report.work);
            let allowed = budget + BROAD_PHASE_WORK;
            assert!(report.broad_phase_work <= allowed, "{allowed}");
            assert!(
                !report.is_whole() && report.undecided() + report.unpaired + report.unplaced > 0
            );
            assert!(report.pairs.len() + report.unlisted <= limit);
            decided += report.decided;
        }
        assert!(decided > 100, "{decided} decided with {budget}");
    }
}

#[test]
fn bodies_not_looked_at_are_undecided() {
    let (mut scene, mut free, mut random) = (Scene::new(), Scene::new(), Random::new(2));
    let ids = crowd(&mut [&mut scene, &mut free], 1_500, 6.0, &mut random);
    let budget = Budget::work(2_000);
    let first = detect(&mut scene, budget).clone();
    let truth = detect(&mut free, Budget::unlimited()).clone();
    assert!(truth.is_whole() && truth.intersecting > 1_000);
    assert!(
        first.unplaced > 500 && first.unpaired > 100 && first.pairs.is_empty() && !first.is_whole()
    );
    assert_honest(&scene, &truth);
    let known = ids
        .iter()
        .filter(|&&id| scene.partners_known(id).unwrap())
        .count();
    assert_eq!(known, 0);
    let certificate = scene.certificate(ids[0], ids[1]).unwrap();
    assert!(certificate.upper_bound > 0, "nothing is proven of them");
}

/// Within small budgets, what rests is known after some frames, as without a budget.
#[test]
fn a_cut_broad_phase_loses_nothing() {
    for (seed, reach) in [(3, Reach::Here), (4, Reach::Swept)] {
        let (mut scene, mut free, mut random) = (Scene::new(), Scene::new(), Random::new(seed));
        scene.set_reach(reach);
        let ids = crowd(&mut [&mut scene, &mut free], 1_000, 9.0, &mut random);
        for round in 0..4 {
            for &id in ids.iter().filter(|_| round > 0) {
                let pose = at(9.0 * random.vector());
                scene.set_pose(id, pose).unwrap();
                free.set_pose(id, pose).unwrap();
            }
            let truth = detect(&mut free, Budget::unlimited()).clone();
            let (mut frames, mut cut, mut said) = (0, 0, BTreeMap::new());
            let key = |pair: &PairReport| (pair.a.index(), pair.b.index());
            let decided = |pair: &&PairReport| pair.verdict != Verdict::Undecided;
            while !truth.pairs.iter().all(|pair| said.contains_key(&key(pair))) {
                let report = detect(&mut scene, Budget::work(3_000 + 40_000 * round));
                said.extend(
                    report
                        .pairs
                        .iter()
                        .filter(decided)
                        .map(|pair| (key(pair), meets(pair))),
                );
                cut += usize::from(!report.is_whole());
                frames += 1;
                assert!(
                    frames < 4_000,
                    "{} {} {}",
                    report.unplaced,
                    report.unpaired,
                    report.unlisted
                );
                assert_honest(&scene, &truth);
            }
            assert!(cut > 1, "the broad phase was not cut");
            assert!(
                truth
                    .pairs
                    .iter()
                    .all(|pair| said[&key(pair)] == meets(pair))
            );
            assert_eq!((scene.report().unplaced, scene.report().unpaired), (0, 0));
        }
    }
}

/// Bodies that move, come, go, jump and change whom they meet.
#[test]
fn moving_bodies_with_a_cut_broad_phase_never_give_a_false_verdict() {
    let ball = ball(0);
    for seed in 5..9 {
        let (mut scene, mut free, mut random) = (Scene::new(), Scene::new(), Random::new(seed));
        let mut ids = crowd(&mut [&mut scene, &mut free], 700, 7.0, &mut random);
        let (mut cut, mut decided) = (0, 0);
        for frame in 0..60 {
            for slot in &mut ids {
                let id = *slot;
                let place = scene.body(id).unwrap().pose.translation();
                match random.below(400) {
                    0 => {
                        let new = Body::moving(Arc::clone(&ball), at(7.0 * random.vector()));
                        for scene in [&mut scene, &mut free] {
                            scene.remove(id).unwrap();
                            *slot = anywhere(scene.insert(new.clone()).unwrap());
                        }
                        continue;
                    }
                    1 => {
                        let filter = Filter::new(1 << random.below(3), random.bits() as u32 | 1);
                        scene.set_filter(id, filter).unwrap();
                        free.set_filter(id, filter).unwrap();
                    }
                    2 => scene.set_importance(id, random.signed() as f32).unwrap(),
                    _ => {}
                }
                let jumps = random.below(100) == 0;
                let pose = at(if jumps {
                    7.0 * random.vector()
                } else {
                    place + 0.04 * random.vector()
                });
                if frame % 20 < 15 {
                    scene.set_pose(id, pose).unwrap();
                    free.set_pose(id, pose).unwrap();
                }
            }
            let truth = detect(&mut free, Budget::unlimited()).clone();
            let report = detect(&mut scene, Budget::work(1 << (9 + random.below(9))));
            cut += usize::from(!report.is_whole());
            decided += report.decided;
            assert_honest(&scene, &truth);
        }
        assert!(cut > 20 && decided > 1_000, "{cut} {decided}");
    }
}

#[test]
fn the_limit_of_pairs_is_told_and_room_is_used_again() {
    const LIMIT: usize = 2_000;
    let (mut scene, mut free, mut random) = (Scene::new(), Scene::new(), Random::new(9));
    scene.set_max_pairs(LIMIT);
    let ids = crowd(&mut [&mut scene, &mut free], 150, 0.1, &mut random);
    let truth = detect(&mut free, Budget::unlimited()).clone();
    assert!(truth.pairs.len() > 5 * LIMIT);
    for budget in [
        Budget::unlimited(),
        Budget::work(50_000),
        Budget::unlimited(),
    ] {
        let report = detect(&mut scene, budget);
        assert!(report.is_full && !report.is_whole() && report.unpaired > 0);
        assert!(report.pairs.len() <= LIMIT && report.pairs.len() + report.unlisted == LIMIT);
        assert_honest(&scene, &truth);
    }
    // There is room as soon as they are apart,
    for (i, &id) in ids.iter().enumerate() {
        for scene in [&mut scene, &mut free] {
            scene.set_pose(id, at(DVec3::X * 1.5 * i as f64)).unwrap();
        }
    }
    let truth = detect(&mut free, Budget::unlimited()).clone();
    let frames = (0..10).position(|_| whole_frame(&mut scene).is_whole());
    assert!(frames.is_some_and(|frames| frames < 3) && !scene.report().is_full);
    let all = |report: &Report| {
        report
            .pairs
            .iter()
            .map(|pair| (pair.a, pair.b, meets(pair)))
            .collect::<Vec<_>>()
    };
    assert_eq!(all(scene.report()), all(&truth));
    // or when more is allowed.
    for &id in &ids {
        for scene in [&mut scene, &mut free] {
            scene.set_pose(id, at(DVec3::ZERO)).unwrap();
        }
    }
    assert!(whole_frame(&mut scene).is_full);
    scene.set_max_pairs(20_000);
    assert!(whole_frame(&mut scene).is_whole());
    let truth = detect(&mut free, Budget::unlimited());
    assert_eq!(scene.report().pairs.len(), truth.pairs.len());
}

#[test]
fn important_bodies_are_placed_first() {
    let (mut scene, mut random) = (Scene::new(), Random::new(10));
    let ids = crowd(&mut [&mut scene], 3_000, 40.0, &mut random);
    let important: Vec<_> = ids.iter().copied().step_by(250).collect();
    for &id in &important {
        scene.set_importance(id, 1.0).unwrap();
    }
    whole_frame(&mut scene);
    let mut known = [0, 0];
    for _ in 0..30 {
        for &id in &ids {
            let place = scene.body(id).unwrap().pose.translation();
            put(&mut scene, id, at(place + 0.05 * random.vector()));
        }
        let report = detect(&mut scene, Budget::work(10_000));
        assert!(report.unplaced > 1_000);
        for (known, bodies) in known.iter_mut().zip([&important, &ids]) {
            *known += bodies
                .iter()
                .filter(|&&id| scene.partners_known(id).unwrap())
                .count();
        }
    }
    let [first, all] = [
        known[0] as f64 / (30 * important.len()) as f64,
        known[1] as f64 / (30 * ids.len()) as f64,
    ];
    assert!(first > 0.5 && all < 0.1, "{first} {all}");
}

/// A pair that rests is decided, however many others keep the frames busy.
#[test]
fn no_pair_starves_beside_more_than_a_frame_can_look_at() {
    let (mut scene, mut random) = (Scene::new(), Random::new(11));
    let ids = crowd(&mut [&mut scene], 150, 0.5, &mut random);
    let rest = [DVec3::splat(9.0), DVec3::splat(9.9)];
    let [a, b] = rest.map(|place| scene.insert(Body::moving(ball(0), at(place))).unwrap());
    while !whole_frame(&mut scene).is_whole() {}
    let last = DVec3::new(9.0, 9.0, 10.0);
    scene.set_pose(b, at(last)).unwrap();
    for frame in 0..2_000 {
        for &id in &ids {
            let place = scene.body(id).unwrap().pose.translation();
            put(&mut scene, id, at(place + 1e-3 * random.vector()));
        }
        let report = detect(&mut scene, Budget::work(300_000));
        assert!(report.unlisted > 3_000);
        if report
            .pair(a, b)
            .is_some_and(|pair| pair.verdict != Verdict::Undecided)
        {
            assert!(frame > 0);
            return;
        }
    }
    panic!("the pair had no turn");
}

#[cfg(feature = "parallel")]
#[test]
fn a_cut_broad_phase_is_the_same_on_any_number_of_threads() {
    let play = |threads| {
        let (mut scene, mut random) = (Scene::new(), Random::new(12));
        scene.use_threads(threads).unwrap();
        let ids = crowd(&mut [&mut scene], 800, 6.0, &mut random);
        let mut reports = Vec::new();
        for _ in 0..25 {
            for &id in &ids {
                let place = scene.body(id).unwrap().pose.translation();
                put(&mut scene, id, at(place + 0.1 * random.vector()));
            }
            let report = scene.detect(Budget::work(20_000)).clone();
            assert!(!report.is_whole());
            reports.push((
                report.pairs,
                report.work,
                report.broad_phase_work,
                report.unlisted,
            ));
        }
        reports
    };
    let alone = play(1);
    assert!(play(2) == alone && play(3) == alone);
}

/// Their last witnesses come before the broad phase: what they show is told in its place, listed or not.
#[test]
fn pairs_that_still_meet_are_told_however_little_of_the_frame_is_left() {
    let mut random = Random::new(11);
    let (mut free, mut scene) = (Scene::new(), Scene::new());
    let ids = crowd(&mut [&mut free, &mut scene], 300, 4.0, &mut random);
    whole_frame(&mut scene);
    let (mut told, mut meeting) = (0, 0);
    for frame in 0..60 {
        // Now and then one is removed, or goes far away.
        for &id in &ids {
            let Ok(body) = scene.body(id) else { continue };
            let way = if (id.index() + frame) % 97 == 0 {
                2.0
            } else {
                1e-3
            };
            let pose = at(body.pose.translation() + way * random.vector());
            scene.set_pose(id, pose).unwrap();
            free.set_pose(id, pose).unwrap();
        }
        if frame % 8 == 7 {
            scene.remove(ids[frame]).unwrap();
            free.remove(ids[frame]).unwrap();
        }
        let truth = detect(&mut free, Budget::unlimited()).clone();
        let budget = Duration::from_micros([40, 80, 160][frame % 3]);
        let report = scene
            .detect(Budget::time(budget).clock(&ManualClock::ticking(Duration::from_micros(1))));
        if report.unlisted > 0 {
            (told, meeting) = (told + report.intersecting, meeting + truth.intersecting);
        }
        assert_honest(&scene, &truth);
    }
    assert!(meeting > 0 && told > meeting / 2, "{told} of {meeting}");
}

/// Witnesses are lost where bodies go far in a frame: known pairs are searched again before the broad phase then.
#[test]
fn pairs_whose_witnesses_are_lost_are_found_again_however_little_of_the_frame_is_left() {
    let mut random = Random::new(13);
    let (mut free, mut scene) = (Scene::new(), Scene::new());
    let ids = crowd(&mut [&mut free, &mut scene], 120, 3.0, &mut random);
    whole_frame(&mut scene);
    let (mut told, mut meeting) = (0, 0);
    for _ in 0..40 {
        for &id in &ids {
            let pose = at(scene.body(id).unwrap().pose.translation() + 0.05 * random.vector());
            scene.set_pose(id, pose).unwrap();
            free.set_pose(id, pose).unwrap();
        }
        let truth = detect(&mut free, Budget::unlimited()).clone();
        let clock = ManualClock::ticking(Duration::from_micros(1));
        let report = scene.detect(Budget::time(Duration::from_micros(40)).clock(&clock));
        (told, meeting) = (told + report.intersecting, meeting + truth.intersecting);
        assert_honest(&scene, &truth);
    }
    assert!(told > meeting / 4 * 3, "{told} of {meeting}");
}

/// Bodies that turn in one another lose their witnesses again and again; what meets then is found next to them, unless they turn
/// by more than a triangle in a frame.
#[test]
fn neighbors_spare_searches_where_surfaces_slide_on_one_another() {
    let torus = shapes::torus(0.8, 0.3, 40);
    let corners = (0..torus.len())
        .flat_map(|i| torus.triangle(i))
        .map(|corner| corner.to_array());
    let triangles = (0..torus.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let soup = Mesh::from_f64(corners, triangles).unwrap();
    let play = |mesh: &Mesh, angle: f64| {
        let tree = Arc::new(Tree::new(mesh.clone()));
        // Twelve couples, one of each turns.
        let pose = |body: usize, frame: usize| {
            let turn = DVec3::new(0.3, 0.1 * (body / 2) as f64, 1.0).normalize();
            let turn = DQuat::from_axis_angle(turn, angle * (frame * (body % 2)) as f64);
            Pose::new(
                DMat3::from_quat(turn),
                [3.0 * (body / 2) as f64, 0.9 * (body % 2) as f64, 0.0],
            )
            .unwrap()
        };
        let mut scene = Scene::new();
        let insert = |body| moving(&mut scene, &tree, pose(body, 0));
        let ids: Vec<BodyId> = (0..24).map(insert).collect();
        let (mut work, mut met) = (0, 0);
        for frame in 0..100 {
            for (body, &id) in ids.iter().enumerate() {
                scene.set_pose(id, pose(body, frame)).unwrap();
            }
            let report = whole_frame(&mut scene);
            work += report.work;
            for pair in report.intersecting_pairs() {
                let Verdict::Intersecting { witness: [x, y] } = pair.verdict else {
                    unreachable!()
                };
                let [a, b] = [pair.a, pair.b].map(|id| pose(id.index(), frame));
                let b_in_a = a.inverse().unwrap().compose(&b).unwrap();
                let of_b = tree
                    .mesh()
                    .triangle(y as usize)
                    .map(|corner| b_in_a.transform_point(corner));
                assert!(
                    triangles_intersect(&tree.mesh().triangle(x as usize), &of_b),
                    "frame {frame}: {pair:?}"
                );
                met += 1;
            }
        }
        assert_eq!(met, 1_200, "couples that meet, all frames");
        work
    };
    for (angle, percent) in [(0.03, 80), (0.6, 105)] {
        let (with, without) = (play(&torus, angle), play(&soup, angle));
        assert!(100 * with < percent * without, "{angle} {with} {without}");
    }
}

/// The tree of the broad phase may be at any step of its build then.
#[test]
fn a_body_that_comes_while_the_broad_phase_is_cut_is_paired_once() {
    for nanos in (0..12_000).step_by(300) {
        let mut random = Random::new(17);
        let mut scene = Scene::new();
        crowd(&mut [&mut scene], 40, 2.0, &mut random);
        let clock = ManualClock::ticking(Duration::from_nanos(300));
        for _ in 0..3 {
            scene.detect(Budget::time(Duration::from_nanos(nanos)).clock(&clock));
            crowd(&mut [&mut scene], 1, 2.0, &mut random);
        }
        let report = whole_frame(&mut scene);
        let mut pairs: Vec<_> = report.pairs.iter().map(|pair| (pair.a, pair.b)).collect();
        pairs.dedup();
        assert_eq!(pairs.len(), report.pairs.len(), "{nanos} ns");
        let mut fresh = Scene::new();
        for (_, body) in scene.bodies() {
            fresh.insert(body.clone()).unwrap();
        }
        assert_eq!(
            detect(&mut fresh, Budget::unlimited()).pairs.len(),
            pairs.len(),
            "{nanos} ns"
        );
    }
}

/// Of bodies that come at once, pairs are asked about as soon as they are known, not when all are.
#[test]
fn a_crowd_is_asked_about_while_it_is_being_paired() {
    let ball = ball(1);
    let mut scene = Scene::new();
    for _ in 0..400 {
        moving(&mut scene, &ball, Pose::IDENTITY);
    }
    let (mut frames, mut idle) = (0, 0);
    while detect(&mut scene, Budget::work(20_000)).unpaired > 0 {
        frames += 1;
        assert!(frames < 1_000, "some are never paired");
        idle += usize::from(scene.report().decided == 0);
    }
    assert!(frames > 300 && idle < 30, "{frames} {idle}");
}

#[test]
fn pairs_are_found_after_any_number_of_moves() {
    // So many that the tree is not built anew for that reason before its generations are used up.
    const BODIES: usize = 12_000;
    let (ball, mut scene) = (ball(0), Scene::new());
    for place in 0..BODIES {
        fixed(&mut scene, &ball, at(10.0 * DVec3::Y * place as f64));
    }
    let mover = scene.insert(Body::moving(ball, at(DVec3::ZERO))).unwrap();
    for frame in 0..(1 << 16) + 1_000 {
        let (place, met) = if frame % 2 == 0 {
            (1.0, true)
        } else {
            (2.5, false)
        };
        put(&mut scene, mover, at(DVec3::new(place, 50_000.0, 0.0)));
        let report = whole_frame(&mut scene);
        assert_eq!(
            (report.is_whole(), report.pairs.len(), report.intersecting),
            (true, usize::from(met), usize::from(met))
        );
    }
}
