//! Compounds against the same bodies one by one.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::random::Random;
use crate::{anywhere, ball, detect, nudged, pose, trees, whole_frame};
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Motion, Pose};
use punctual_scene::{Body, BodyId, CompoundId, Filter, PairPassage, Report, Scene, SceneError};

/// Two scenes of the same bodies: in one they are parts of compounds, in the other alone, where a filter says that those of
/// one compound never meet.
struct Twins {
    whole: Scene,
    single: Scene,
    compounds: Vec<(CompoundId, Vec<(BodyId, Pose)>)>,
}

impl Twins {
    fn new(random: &mut Random) -> Self {
        let trees = trees();
        let (mut whole, mut single) = (Scene::new(), Scene::new());
        let mut compounds = Vec::new();
        for group in 0..5 {
            let parts: Vec<_> = (0..1 + group)
                .map(|_| {
                    Body::moving(
                        Arc::clone(&trees[random.below(trees.len())]),
                        pose(1.0, random),
                    )
                })
                .collect();
            let filter = Filter::new(1 << group, !(1 << group));
            let alone = |part: &Body| {
                (
                    anywhere(single.insert(part.clone().filter(filter)).unwrap()),
                    part.pose,
                )
            };
            let bodies = parts.iter().map(alone).collect();
            compounds.push((
                whole.insert_compound(Pose::IDENTITY, parts).unwrap(),
                bodies,
            ));
        }
        Self {
            whole,
            single,
            compounds,
        }
    }
}

/// What a report says of pairs of bodies and of their motions, but how much it took.
fn said(scene: &Scene) -> (Vec<(usize, usize, String)>, Vec<PairPassage>) {
    let pairs = scene
        .report()
        .pairs
        .iter()
        .map(|pair| (pair.a.index(), pair.b.index(), format!("{pair:?}")));
    (pairs.collect(), scene.passages().collect())
}

#[test]
fn compounds_are_their_parts_at_products_of_poses() {
    let mut random = Random::new(71);
    let mut twins = Twins::new(&mut random);
    let mut poses: Vec<Pose> = twins
        .compounds
        .iter()
        .map(|_| pose(2.0, &mut random))
        .collect();
    let (mut met, mut passed) = (0, 0);
    for frame in 0..60 {
        for ((compound, parts), at) in twins.compounds.iter().zip(&mut poses) {
            *at = nudged(at, &mut random);
            if random.below(4) == 0 {
                let motion =
                    Motion::turning(*at, random.vector(), 2.0 * random.vector(), random.vector())
                        .unwrap();
                twins.whole.set_compound_motion(*compound, motion).unwrap();
                for (body, place) in parts {
                    twins
                        .single
                        .set_motion(*body, motion.of_part(place).unwrap())
                        .unwrap();
                }
            } else {
                twins.whole.set_compound_pose(*compound, *at).unwrap();
                for (body, place) in parts {
                    twins
                        .single
                        .set_pose(*body, at.compose(place).unwrap())
                        .unwrap();
                }
            }
        }
        let budget = if frame % 2 == 0 {
            Budget::unlimited()
        } else {
            Budget::work(1 << (10 + random.below(8)))
        };
        detect(&mut twins.whole, budget);
        let whole = twins.whole.report();
        detect(&mut twins.single, budget);
        assert_eq!(said(&twins.whole), said(&twins.single));
        met += whole.intersecting;
        passed += twins.whole.passages().count();
        let compound_of = |id| twins.whole.compound_of(id).unwrap();
        assert!(
            whole
                .pairs
                .iter()
                .all(|pair| compound_of(pair.a) != compound_of(pair.b))
        );
    }
    assert!(met > 100 && passed > 100, "{met} {passed}");
}

#[test]
fn a_compound_that_is_refused_changes_nothing() {
    let ball = ball(1);
    let at = |x: f64| Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
    let part = |x: f64| Body::moving(Arc::clone(&ball), at(x));
    let mut scene = Scene::new();
    let far = f64::from_bits((1023 + 990) << 52);
    let refused = scene.insert_compound(at(1.0), [part(0.0), part(2.0 * far)]);
    assert!(
        matches!(refused, Err(SceneError::TooFar { body, axis: 0 }) if body.index() == 1),
        "{refused:?}"
    );
    let refused = scene.insert_compound(at(1.0), [part(0.0), part(1.0).importance(f32::NAN)]);
    assert!(matches!(refused, Err(SceneError::ImportanceNotANumber { body }) if body.index() == 1));
    assert_eq!(scene.len(), 0);
    let id = scene
        .insert_compound(at(1.0), [part(0.0), part(0.9 * far)])
        .unwrap();
    let ids: Vec<_> = scene.parts(id).unwrap().collect();
    let places = |scene: &Scene| {
        ids.iter()
            .map(|&id| scene.body(id).unwrap().pose)
            .collect::<Vec<_>>()
    };
    let before = places(&scene);
    assert!(
        matches!(scene.set_compound_pose(id, at(0.9 * far)), Err(SceneError::TooFar { body, .. }) if body == ids[1])
    );
    let around =
        Motion::turning(at(0.0), [0.0; 3], [0.0, 0.0, 0.1], [-0.9 * far, 0.0, 0.0]).unwrap();
    let refused = scene.set_compound_motion(id, around);
    assert!(
        matches!(refused, Err(SceneError::TooFar { body, axis: 0 }) if body == ids[1]),
        "{refused:?}"
    );
    assert_eq!(places(&scene), before);
}

#[test]
fn compounds_go_with_their_parts() {
    let ball = ball(1);
    let at = |x: f64| Pose::new(DMat3::IDENTITY, DVec3::X * x).unwrap();
    let part = |x: f64| Body::moving(Arc::clone(&ball), at(x));
    let mut scene = Scene::new();
    let [one, other] = [0.0, 8.0].map(|x| {
        scene
            .insert_compound(at(x), [part(0.0), part(1.0), part(2.0)])
            .unwrap()
    });
    let ids: Vec<_> = scene.parts(one).unwrap().collect();
    scene.measure(ids[0], ids[2], 0.1).unwrap();
    // Not even if their distance is asked for.
    assert_eq!(whole_frame(&mut scene).pairs, []);
    scene.set_pose(ids[2], at(7.0)).unwrap();
    // Moved by itself.
    assert_eq!(whole_frame(&mut scene).intersecting, 2);
    scene.set_compound_pose(one, at(0.0)).unwrap();
    assert_eq!(scene.body(ids[2]).unwrap().pose, at(2.0));
    scene.remove(ids[0]).unwrap();
    assert_eq!(scene.parts(one).unwrap().collect::<Vec<_>>(), ids[1..]);
    scene.set_compound_pose(one, at(5.9)).unwrap();
    // The slot of a part is free for a body that meets the others.
    let new = scene.insert(part(7.5)).unwrap();
    assert_eq!(
        (new.index(), scene.compound_of(new).unwrap()),
        (ids[0].index(), None)
    );
    let count = |report: &Report| {
        let mut met = BTreeMap::new();
        for pair in report.intersecting_pairs() {
            *met.entry(pair.a.index()).or_insert(0) += 1;
        }
        met.into_iter().collect::<Vec<_>>()
    };
    assert_eq!(count(whole_frame(&mut scene)), [(0, 4), (1, 1), (2, 2)]);
    scene.remove_compound(other).unwrap();
    assert_eq!(
        scene.remove_compound(other),
        Err(SceneError::NoSuchCompound { compound: other })
    );
    assert!(scene.parts(other).is_err() && scene.set_compound_pose(other, at(0.0)).is_err());
    assert_eq!((scene.len(), whole_frame(&mut scene).intersecting), (3, 2));
    let next = scene.insert_compound(at(100.0), []).unwrap();
    assert!(
        next != other
            && CompoundId::from_bits(next.to_bits()) == next
            && scene.parts(next).unwrap().len() == 0
    );
}
