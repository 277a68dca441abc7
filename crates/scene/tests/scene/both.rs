//! Distance and time of impact of one pair, against a query for each.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::random::Random;
use crate::distances::{LEAST_DISTANCE_WORK, ROUNDING, crowd, distance};
use crate::{at, ball, detect, nudged, row, swing, whole_frame};
use punctual::clock::ManualClock;
use punctual::impact::TimeOfImpact;
use punctual::{Budget, Motion, Pose, Query, Verdict, Workspace};
use punctual_scene::{Body, BodyId, PairPassage, PairQuestion, Scene};

const TOLERANCE: f64 = 1e-4;

type Motions = BTreeMap<BodyId, Motion>;

fn pairs(ids: &[BodyId]) -> impl Iterator<Item = [BodyId; 2]> {
    ids.iter()
        .enumerate()
        .flat_map(|(i, &a)| ids[i + 1..].iter().map(move |&b| [a, b]))
}

fn truth(
    scene: &Scene,
    motions: &Motions,
    pair: [BodyId; 2],
    workspace: &mut Workspace,
) -> TimeOfImpact {
    let [x, y] = pair.map(|id| scene.body(id).unwrap());
    let motion = |id: BodyId| {
        let still = Motion::straight(scene.body(id).unwrap().pose, [0.0; 3]).unwrap();
        motions.get(&id).copied().unwrap_or(still)
    };
    let query = Query::impact_of_both([&x.tree, &y.tree], pair.map(motion));
    let query = query.margins([x.margin, y.margin]);
    query
        .run(workspace, Budget::unlimited().clock(&ManualClock::new()))
        .value
}

fn passage(scene: &Scene, [a, b]: [BodyId; 2]) -> Option<PairPassage> {
    scene.passages().find(|found| (found.a, found.b) == (a, b))
}

/// True if a passage leaves nothing open.
fn is_known(found: &PairPassage) -> bool {
    found.free_until == 1.0 || found.touching_at.is_some()
}

#[test]
fn distance_and_time_of_impact_of_a_pair_are_those_of_single_queries() {
    let (mut both, mut cut, mut met) = (0, 0, 0);
    for threads in [1, 3] {
        let mut random = Random::new(61);
        let (mut scene, ids) = crowd(9, &mut random);
        for &id in &ids {
            let start = scene.body(id).unwrap().pose;
            let near = 0.6 * start.translation();
            let pose = Pose::new(*start.rotation(), near).unwrap();
            scene.set_pose(id, pose).unwrap();
        }
        #[cfg(feature = "parallel")]
        scene.use_threads(threads).unwrap();
        #[cfg(not(feature = "parallel"))]
        let _ = threads;
        let group = scene
            .measure_groups(&ids[..4], &ids[3..], TOLERANCE)
            .unwrap();
        let (mut motions, mut measured) = (Motions::new(), Vec::new());
        let mut workspace = Workspace::new();
        for frame in 0..112 {
            for &id in ids.iter().filter(|_| frame % 8 < 5) {
                let there = scene.body(id).unwrap().pose;
                match random.below(4) {
                    0 | 1 => {
                        let start = nudged(&there, &mut random);
                        let motion = match random.below(2) {
                            0 => Motion::straight(start, 4.0 * random.vector()),
                            _ => Motion::screw(start, nudged(&start, &mut random)),
                        };
                        motions.insert(id, motion.unwrap());
                        scene.set_motion(id, motions[&id]).unwrap();
                    }
                    2 => {
                        motions.remove(&id);
                        scene.set_pose(id, nudged(&there, &mut random)).unwrap();
                    }
                    _ => {}
                }
            }
            let [a, b] = [0; 2].map(|_| ids[random.below(ids.len())]);
            let pair = [a.min(b), a.max(b)];
            if a != b && frame % 8 < 5 {
                if random.below(3) > 0 {
                    scene.measure(a, b, TOLERANCE).unwrap();
                    measured.push(pair);
                } else {
                    scene.stop_measuring(a, b).unwrap();
                    measured.retain(|&other| other != pair);
                }
            }
            if frame == 100 {
                scene.stop_measuring_groups(group).unwrap();
            }
            let is_free = frame % 8 == 0;
            let budget = match is_free {
                true => Budget::unlimited(),
                false => Budget::work(LEAST_DISTANCE_WORK << random.below(8)),
            };
            let report = scene.detect(budget).clone();
            assert!(is_free || report.work <= LEAST_DISTANCE_WORK << 7);
            for pair @ [a, b] in pairs(&ids) {
                let (told, found) = (report.pair(a, b), scene.distance(a, b).unwrap());
                let times = truth(&scene, &motions, pair, &mut workspace);
                let margins = pair.map(|id| scene.body(id).unwrap().margin);
                let apart = distance(&scene, a, b, &mut workspace) - margins[0] - margins[1];
                let gap = apart.max(0.0);
                let is_whole = told.is_some_and(|told| told.complete);
                if measured.contains(&pair) {
                    assert!(told.is_some() || report.unlisted > 0, "{pair:?}");
                    let is_true = found.low <= gap + ROUNDING && gap <= found.high + ROUNDING;
                    assert!(found.age > 0 || is_true, "{found:?} {gap}");
                    let is_tight = found.high - found.low <= 1.001 * TOLERANCE;
                    assert!(
                        !is_whole || found.age == 0 && (is_tight || found.high == 0.0),
                        "{found:?} {told:?}"
                    );
                }
                match told.map(|told| told.verdict) {
                    Some(Verdict::Separated) => assert!(apart >= -ROUNDING, "{apart} {told:?}"),
                    Some(verdict) if verdict.meets() => {
                        assert!(apart <= ROUNDING, "{apart} {told:?}")
                    }
                    _ => assert!(!is_free || told.is_none(), "{told:?}"),
                }
                let moves = pair.iter().any(|id| motions.contains_key(id));
                let passage = passage(&scene, pair);
                assert_eq!(passage.is_some(), moves && told.is_some(), "{pair:?}");
                let Some(passage) = passage else {
                    assert!(!moves || !report.is_whole() || times.upper.is_none());
                    continue;
                };
                assert!(
                    passage.free_until <= times.upper.unwrap_or(1.0)
                        && passage.touching_at.is_none_or(|time| time >= times.lower),
                    "{passage:?} {times:?}"
                );
                assert!(
                    !is_whole || passage.touching_at.is_some() == times.upper.is_some(),
                    "{passage:?} {times:?} {told:?}"
                );
                assert!(is_whole || !is_free, "{told:?}");
                let is_both = measured.contains(&pair) && found.age == 0;
                both += usize::from(is_both && is_whole && is_known(&passage));
                met += usize::from(is_both && passage.touching_at.is_some());
                cut += usize::from(is_both && !is_whole);
            }
        }
        assert!(scene.report().group_distances.is_empty());
    }
    assert!(both > 200 && met > 50 && cut > 50, "{both} {met} {cut}");
}

/// Motions from each pose of a swing on.
fn swings(scene: &mut Scene, ids: &[BodyId], frame: usize) {
    for (body, &id) in ids.iter().enumerate() {
        let motion = Motion::screw(swing(body, frame), swing(body, frame + 1)).unwrap();
        scene.set_motion(id, motion).unwrap();
    }
}

fn measure_all(scene: &mut Scene, ids: &[BodyId]) {
    for pair in ids.windows(2) {
        scene.measure(pair[0], pair[1], 1e-3).unwrap();
    }
}

/// K = 2 ⌈C/R⌉ + 1 frames hold for both questions of a pair: at rest, and in motion if neither takes
/// more than R.
#[test]
fn neither_question_of_a_pair_waits_longer_than_promised() {
    let mut free = Scene::new();
    let ids = row(&mut free, 16);
    measure_all(&mut free, &ids);
    let mut cost = 0;
    for frame in 0..40 {
        swings(&mut free, &ids, frame);
        let report = detect(&mut free, Budget::unlimited());
        assert_eq!(report.complete, report.pairs.len());
        cost = cost.max(2 * report.work);
    }
    for weight in [-1.0, 0.0, 1.0] {
        for budget in [8 * LEAST_DISTANCE_WORK, 100_000, 1_000_000] {
            let mut scene = Scene::new();
            let question = PairQuestion::Motion;
            scene.set_question_importance(question, weight).unwrap();
            let ids = row(&mut scene, 16);
            measure_all(&mut scene, &ids);
            swings(&mut scene, &ids, 0);
            let frames = 2 * (2 * cost).div_ceil(budget / 8) + 1;
            let mut used = 0;
            while detect(&mut scene, Budget::work(budget)).complete < scene.report().pairs.len()
                || !scene.report().is_whole()
            {
                used += 1;
                assert!(scene.report().work <= budget && used <= frames, "{used}");
            }
            assert!(scene.passages().all(|found| is_known(&found)));
            if budget < 1_000_000 {
                continue;
            }
            let mut waiting = vec![0; ids.len()];
            for frame in 0..(2 * frames).min(60) as usize {
                swings(&mut scene, &ids, frame);
                assert!(detect(&mut scene, Budget::work(budget)).work <= budget);
                assert!(scene.distances().all(|found| found.age <= frames));
                for (pair, waits) in ids.windows(2).zip(&mut waiting) {
                    let found = passage(&scene, [pair[0], pair[1]]);
                    *waits = if found.is_none_or(|found| is_known(&found)) {
                        0
                    } else {
                        *waits + 1
                    };
                    assert!(*waits <= frames, "{pair:?} waits for {waits} of {frames}");
                }
            }
        }
    }
}

/// A distance that takes more than R, of bodies that move in every frame, does not keep the time of
/// impact of its pair from its turn.
#[test]
fn a_motion_has_its_turn_although_the_distance_before_it_is_never_done() {
    let sphere = ball(5);
    let mut scene = Scene::new();
    let [a, b] = [0.0, 1e-3].map(|x| {
        let body = Body::moving(Arc::clone(&sphere), at(x, 0.0, 0.0));
        scene.insert(body).unwrap()
    });
    let grown: Vec<[f64; 3]> = (0..sphere.mesh().vertex_count())
        .map(|i| (1.1 * sphere.mesh().vertex(i)).to_array())
        .collect();
    scene.tree_mut(b).unwrap().refit_f64(&grown).unwrap();
    let go = |scene: &mut Scene, frame: usize| {
        let start = at(1e-3 + 1e-6 * frame as f64, 0.0, 0.0);
        let motion = Motion::straight(start, [1e-6, 0.0, 0.0]).unwrap();
        scene.set_motion(b, motion).unwrap();
    };
    go(&mut scene, 0);
    let impact = whole_frame(&mut scene).work;
    scene.measure(a, b, 0.0).unwrap();
    go(&mut scene, 1);
    let all = whole_frame(&mut scene).work;
    let (budget, distance) = (12 * impact, all - impact);
    assert!(8 * distance > 2 * budget, "{distance} and {impact}");
    let k = 2 * (2 * all).div_ceil(budget / 8) + 1;
    let (mut known, mut measured) = (0, 0);
    for frame in 2..2 + 4 * k as usize {
        go(&mut scene, frame);
        assert!(!detect(&mut scene, Budget::work(budget)).pairs[0].complete);
        known += u64::from(passage(&scene, [a, b]).is_some_and(|found| is_known(&found)));
        let found = scene.distance(a, b).unwrap();
        measured += usize::from(found.age == 0);
    }
    assert!(known >= 4 && measured > 0, "{known} of {} frames", 4 * k);
}

/// Far from each other on their way, a pair needs no query for its motion.
#[test]
fn bodies_whose_ways_are_far_apart_are_free_without_a_query() {
    let ball = ball(2);
    let mut scene = Scene::new();
    let [a, b] = [0.0, 9.0].map(|x| {
        let body = Body::moving(Arc::clone(&ball), at(x, 0.0, 0.0));
        scene.insert(body).unwrap()
    });
    scene.measure(a, b, 1e-3).unwrap();
    let measured = whole_frame(&mut scene).work;
    let go = |scene: &mut Scene, way: f64| {
        let motion = Motion::straight(at(9.0, 0.0, 0.0), [way, 0.0, 0.0]).unwrap();
        scene.set_motion(b, motion).unwrap();
        let work = whole_frame(scene).work;
        (work, scene.passages().next().unwrap())
    };
    let (work, found) = go(&mut scene, -6.9);
    assert!(work <= measured, "{work}, {measured} before");
    assert_eq!((found.free_until, found.touching_at), (1.0, None));
    let (work, found) = go(&mut scene, -9.0);
    assert!(work > measured && found.touching_at.is_some(), "{found:?}");
    assert!(scene.distance(a, b).unwrap().low > 6.9);
    // What is said of a motion ends with it.
    scene.set_pose(b, at(8.0, 0.0, 0.0)).unwrap();
    assert_eq!(scene.passages().next().map(|found| is_known(&found)), None);
    whole_frame(&mut scene);
    assert_eq!(scene.passages().count(), 0);
}
