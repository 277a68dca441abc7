//! Calls that a scene refuses leave it as it was; and ids of another scene are refused.

use crate::{ball, moving, put};
use std::sync::Arc;
use std::time::Duration;

use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::rays::RayMode;
use punctual::{Budget, Mode, Motion, Pose, Ray};
use punctual_scene::{
    Body, BodyId, CompoundId, Filter, MeasureId, PairQuestion, Scene, SceneError, SceneRay,
};

fn at(x: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, 0.0, 0.0]).unwrap()
}

/// Two balls that meet, a compound of two, and one that was removed.
struct World {
    scene: Scene,
    bodies: [BodyId; 2],
    compound: CompoundId,
    measure: Option<MeasureId>,
    gone: BodyId,
    gone_compound: CompoundId,
}

impl World {
    fn new(measures: bool) -> Self {
        let (ball, mut scene) = (ball(2), Scene::new());
        scene.track_contacts();
        scene.find_contacts();
        let bodies = [0.0, 1.5].map(|x| {
            scene
                .insert(Body::moving(Arc::clone(&ball), at(x)).margin(0.01))
                .unwrap()
        });
        let parts = [0.0, 1.0].map(|x| Body::moving(Arc::clone(&ball), at(x)));
        let compound = scene.insert_compound(at(3.0), parts.clone()).unwrap();
        let gone = scene.insert(Body::moving(ball, at(9.0))).unwrap();
        let gone_compound = scene.insert_compound(at(20.0), parts).unwrap();
        let measure = measures.then(|| {
            scene.measure(bodies[0], bodies[1], 1e-3).unwrap();
            let part = scene.parts(compound).unwrap().next().unwrap();
            scene.measure_groups(&bodies, &[part], 1e-3).unwrap()
        });
        scene.remove(gone).unwrap();
        scene.remove_compound(gone_compound).unwrap();
        scene
            .cast(
                &ray().mode(RayMode::All),
                Budget::unlimited().clock(&ManualClock::new()),
            )
            .map(drop)
            .unwrap();
        Self {
            scene,
            bodies,
            compound,
            measure,
            gone,
            gone_compound,
        }
    }

    /// All that the scene says, but what a frame may spend.
    fn said(&self) -> String {
        let points = self.scene.contacts(self.bodies[0], self.bodies[1]).unwrap();
        let bodies: Vec<_> = self
            .scene
            .bodies()
            .map(|(id, body)| (id, body.pose, body.margin, body.filter))
            .collect();
        let certificate = self.scene.certificate(self.bodies[0], self.bodies[1]);
        format!(
            "{:?} {points:?} {bodies:?} {certificate:?} {:?}",
            self.scene.report(),
            self.scene.ray_hits()
        )
    }
}

fn ray() -> SceneRay {
    SceneRay::new(Ray::new([-5.0, 0.1, 0.2], [1.0, 0.0, 0.0]).unwrap())
}

/// Every call that names a body, a compound or a measure, refused for these ids; and every one with a bad value.
fn refused(
    world: &mut World,
    body: BodyId,
    compound: CompoundId,
    measure: MeasureId,
) -> Vec<(&'static str, SceneError)> {
    let World {
        scene,
        bodies: [a, b],
        compound: own,
        ..
    } = world;
    let (a, b, own, tree) = (*a, *b, *own, ball(2));
    let (no_such, no_compound) = (
        SceneError::NoSuchBody { body },
        SceneError::NoSuchCompound { compound },
    );
    let far = Pose::new(DMat3::IDENTITY, [2f64.powi(995), 0.0, 0.0]).unwrap();
    let sheared =
        Pose::from_axes(DVec3::X, DVec3::new(5e-4, 1.0, 0.0), DVec3::Z, DVec3::ZERO).unwrap();
    let motion = Motion::straight(at(0.0), [1.0, 0.0, 0.0]).unwrap();
    let mut told = Vec::new();
    macro_rules! refuse {
        ($expected:expr; $($call:ident($($argument:expr),*))*) => {
            $({
                let error = scene.$call($($argument),*).map(drop).expect_err(stringify!($call));
                let expected: Option<SceneError> = $expected;
                assert!(expected.is_none_or(|expected| expected == error), "{}: {error:?}", stringify!($call));
                told.push((stringify!($call), error));
            })*
        };
    }
    refuse! { Some(no_such);
        remove(body) body(body) set_pose(body, at(1.0)) set_motion(body, motion) set_tree(body, Arc::clone(&tree))
        tree_mut(body) set_filter(body, Filter::default()) set_importance(body, 1.0) set_margin(body, 1.0)
        compound_of(body) partners_known(body) measure_groups(&[a], &[b, body], 0.0) set_poses([(a, at(7.0)), (body, at(8.0))])
    }
    for [x, y] in [[a, body], [body, a], [body, body]] {
        refuse! { Some(no_such);
            measure(x, y, 0.0) stop_measuring(x, y) find_contacts_of(x, y) stop_finding_contacts_of(x, y)
            contacts(x, y) certificate(x, y)
        }
    }
    refuse! { Some(no_compound);
        parts(compound) set_compound_pose(compound, at(1.0)) set_compound_motion(compound, motion) remove_compound(compound)
    }
    refuse! { Some(SceneError::NoSuchMeasure { measure }); stop_measuring_groups(measure) }
    refuse! { Some(SceneError::OneBody { body: a });
        measure(a, a, 0.0) stop_measuring(a, a) find_contacts_of(a, a) stop_finding_contacts_of(a, a)
        contacts(a, a) certificate(a, a) measure_groups(&[a], &[a], 0.0)
    }
    refuse! { None;
        set_pose(a, far) set_pose(a, sheared) set_motion(a, Motion::straight(sheared, [0.0; 3]).unwrap()) set_compound_pose(own, far)
        set_compound_motion(own, Motion::straight(sheared, [0.0; 3]).unwrap()) set_poses([(a, at(7.0)), (b, far)])
        insert(Body::moving(Arc::clone(&tree), far)) insert(Body::moving(Arc::clone(&tree), at(0.0)).margin(-1.0))
        insert(Body::moving(Arc::clone(&tree), at(0.0)).importance(f32::NAN))
        insert_compound(at(0.0), [at(0.0), far].map(|place| Body::moving(Arc::clone(&tree), place)))
        insert_compound(far, [Body::moving(Arc::clone(&tree), at(0.0))])
        set_importance(a, f32::NAN) set_margin(a, f64::NAN) set_margin(a, -1.0) set_margin(a, f64::INFINITY)
        measure(a, b, f64::NAN) measure(a, b, -1.0) measure_groups(&[a], &[b], f64::NAN)
        set_look_ahead(-1.0) set_question_importance(PairQuestion::Meet, f32::NAN) set_question_importance(PairQuestion::Contacts, f32::INFINITY)
    }
    told
}

#[test]
fn a_refused_call_leaves_a_scene_as_it_was() {
    let other = World::new(true);
    for measures in [false, true] {
        for mode in [Mode::Any, Mode::All] {
            let mut worlds = [World::new(measures), World::new(measures)];
            let clock = ManualClock::ticking(Duration::from_nanos(300));
            for (frame, budget) in [
                Budget::unlimited(),
                Budget::work(0),
                Budget::work(3000),
                Budget::unlimited(),
            ]
            .into_iter()
            .cycle()
            .take(12)
            .enumerate()
            {
                for world in &mut worlds {
                    world.scene.set_mode(mode);
                    if frame == 6 {
                        world.scene.set_pose(world.bodies[1], at(1.6)).unwrap();
                    }
                }
                // Stale ids, ids of another scene, and numbers that name nothing.
                let [gone, compound] = [worlds[0].gone, BodyId::from_bits(u64::MAX)];
                let stale = worlds[0].gone_compound;
                let nothing = (
                    CompoundId::from_bits(u64::MAX),
                    MeasureId::from_bits(u64::MAX),
                );
                for (body, compound, measure) in [
                    (gone, stale, nothing.1),
                    (compound, nothing.0, nothing.1),
                    (other.bodies[0], other.compound, other.measure.unwrap()),
                ] {
                    let before = worlds[0].said();
                    assert!(refused(&mut worlds[0], body, compound, measure).len() > 60);
                    assert_eq!(worlds[0].said(), before);
                }
                let [told, untold] = worlds.each_mut().map(|world| {
                    let _ = world.scene.detect(budget.clock(&clock));
                    world.said()
                });
                assert_eq!(told, untold, "{frame} {mode:?} {measures}");
            }
            // A resting scene that knows all does nothing.
            assert!(measures || worlds[0].scene.report().broad_phase_work == 0);
        }
    }
}

/// The ray has no image in the coordinates of a body that is far away.
#[test]
fn a_refused_cast_leaves_the_hits_of_the_one_before() {
    let mut world = World::new(false);
    let clock = ManualClock::new();
    let hits = world.scene.ray_hits().to_vec();
    assert!(hits.len() >= 4);
    let far = DVec3::X * 2f64.powi(989);
    let turned = Pose::new(DMat3::from_rotation_z(0.8), far).unwrap();
    world.scene.insert(Body::moving(ball(2), turned)).unwrap();
    let long = SceneRay::new(Ray::segment([1e301, 1e301, 0.0], far).unwrap()).mode(RayMode::All);
    let refused = world.scene.cast(&long, Budget::unlimited().clock(&clock));
    assert!(
        matches!(refused, Err(SceneError::NoRay { .. })),
        "{refused:?}"
    );
    assert_eq!(world.scene.ray_hits(), hits);
    let _ = world
        .scene
        .cast(&ray(), Budget::unlimited().clock(&clock))
        .unwrap();
    assert_eq!(world.scene.ray_hits(), []);
}

/// Ids say the same in every scene to which the same was done, and as numbers they are taken by all of them.
#[test]
fn an_id_is_of_one_scene_and_says_the_same_in_all() {
    let [mut one, mut other] = [World::new(true), World::new(true)];
    assert_eq!(
        (one.bodies, one.compound, one.measure),
        (other.bodies, other.compound, other.measure)
    );
    assert_eq!(format!("{:?}", one.bodies), format!("{:?}", other.bodies));
    let (ours, theirs) = (one.bodies[0], other.bodies[0]);
    assert_eq!(
        one.scene.set_pose(theirs, at(0.1)),
        Err(SceneError::NoSuchBody { body: theirs })
    );
    assert_eq!(one.scene.set_pose(ours, at(0.1)), Ok(()));
    assert_eq!(
        other
            .scene
            .set_pose(BodyId::from_bits(ours.to_bits()), at(0.1)),
        Ok(())
    );
    assert_eq!(
        other
            .scene
            .parts(CompoundId::from_bits(one.compound.to_bits()))
            .unwrap()
            .len(),
        2
    );
    let clock = ManualClock::new();
    let [first, second] = [&mut one, &mut other].map(|world| {
        world
            .scene
            .detect(Budget::unlimited().clock(&clock))
            .clone()
    });
    assert_eq!(format!("{first:?}"), format!("{second:?}"));
    assert_eq!(first.pairs, second.pairs);
    assert!(
        first.pair(ours, one.bodies[1]).is_some() && first.pair(theirs, other.bodies[1]).is_some()
    );
    let measure = MeasureId::from_bits(one.measure.unwrap().to_bits());
    assert_eq!(other.scene.stop_measuring_groups(measure), Ok(()));
}

/// Two fixed bodies are compared only as long as their distance is asked for.
#[test]
fn fixed_bodies_leave_the_report_when_their_measuring_ends() {
    for budget in [
        Budget::unlimited(),
        Budget::work(100_000),
        Budget::work(700),
        Budget::work(0),
    ] {
        for groups in [false, true] {
            let (ball, mut scene, clock) = (ball(2), Scene::new(), ManualClock::new());
            let [a, b] =
                [0.0, 1.5].map(|x| scene.insert(Body::fixed(Arc::clone(&ball), at(x))).unwrap());
            moving(&mut scene, &ball, at(0.5));
            let measure = if groups {
                Some(scene.measure_groups(&[a], &[b], 1e-3).unwrap())
            } else {
                None
            };
            if !groups {
                scene.measure(a, b, 1e-3).unwrap();
            }
            scene.detect(Budget::unlimited().clock(&clock));
            assert!(scene.report().pair(a, b).is_some());
            match measure {
                Some(measure) => scene.stop_measuring_groups(measure).unwrap(),
                None => scene.stop_measuring(a, b).unwrap(),
            }
            for _ in 0..5 {
                let shift = 1e-6 * scene.report().frame as f64;
                put(&mut scene, a, at(shift));
                scene.detect(budget.clock(&clock));
                assert_eq!(scene.report().pair(a, b), None, "{budget:?}");
            }
        }
    }
}

/// What is not asked for cannot be stopped: a resting scene goes on knowing all.
#[test]
fn stopping_what_was_not_asked_for_changes_nothing() {
    let mut world = World::new(false);
    let (clock, [a, b]) = (ManualClock::new(), world.bodies);
    for _ in 0..3 {
        world.scene.detect(Budget::unlimited().clock(&clock));
    }
    assert_eq!(world.scene.report().broad_phase_work, 0, "it rests");
    world.scene.stop_measuring(a, b).unwrap();
    world.scene.stop_finding_contacts_of(a, b).unwrap();
    assert_eq!(
        world
            .scene
            .detect(Budget::unlimited().clock(&clock))
            .broad_phase_work,
        0
    );
}
