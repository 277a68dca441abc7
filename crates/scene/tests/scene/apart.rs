//! Pairs that are apart by more than their bodies have gone since are decided without a query, and only those.

use std::sync::Arc;

use crate::common::check;
use crate::common::random::Random;
use crate::{Model, at, ball, detect, fixed, moving, pose, put, trees, whole_frame};
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::{Budget, BuildOptions, Mesh, Mode, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_scene::{Body, BodyId, Scene};

/// A pose that differs from another by a small turn and step.
fn trembling(from: &Pose, size: f64, random: &mut Random) -> Pose {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(size * random.vector()));
    Pose::new(
        turn * *from.rotation(),
        from.translation() + size * random.vector(),
    )
    .unwrap()
}

fn knowing_ball(extremes: bool) -> Arc<Tree> {
    Arc::new(Tree::with_options(
        shapes::icosphere(3),
        &BuildOptions::default().extremes(extremes),
    ))
}

/// Bodies of all shapes close to each other.
fn crowd(bodies: usize, random: &mut Random) -> (Scene, Model, Vec<Arc<Tree>>) {
    let (trees, mut scene, mut model) = (trees(), Scene::new(), Model::default());
    for _ in 0..bodies {
        let body = Body::moving(
            Arc::clone(&trees[random.below(trees.len())]),
            pose(2.0, random),
        );
        model
            .bodies
            .push((scene.insert(body.clone()).unwrap(), body));
    }
    (scene, model, trees)
}

/// Verdicts are those of all pairs asked anew, whatever changes on the way.
#[test]
fn bodies_that_tremble_are_decided_as_if_asked_anew() {
    let mut random = Random::new(61);
    let (mut scene, mut model, trees) = crowd(24, &mut random);
    let mut workspace = Workspace::new();
    let (mut work, mut decided) = ([0; 2], 0);
    for frame in 0..240 {
        let size = [1e-6, 1e-4, 1e-2][frame / 40 % 3];
        for (id, body) in &mut model.bodies {
            match random.below(400) {
                0 => {
                    body.tree = Arc::clone(&trees[random.below(trees.len())]);
                    scene.set_tree(*id, Arc::clone(&body.tree)).unwrap();
                }
                1 => {
                    let body = scene.remove(*id).unwrap();
                    *id = scene.insert(body).unwrap();
                }
                _ => {}
            }
            body.pose = trembling(&body.pose, size, &mut random);
            scene.set_pose(*id, body.pose).unwrap();
        }
        scene.set_mode(if frame % 24 < 16 {
            Mode::Any
        } else {
            Mode::All
        });
        let budget = if frame % 5 == 4 {
            Budget::work(100_000)
        } else {
            Budget::unlimited()
        };
        let report = detect(&mut scene, budget);
        if frame % 40 > 2 && frame % 24 < 16 && budget == Budget::unlimited() {
            work[usize::from(size == 1e-2)] += report.work;
        }
        let truth = model.truth(&mut workspace);
        for pair in &report.pairs {
            let met = truth
                .iter()
                .any(|&(a, b, _)| (a, b) == (pair.a.index(), pair.b.index()));
            match pair.verdict {
                Verdict::Undecided => assert_ne!(budget, Budget::unlimited()),
                verdict => assert_eq!(
                    met,
                    verdict != Verdict::Separated,
                    "frame {frame}: {pair:?}"
                ),
            }
            decided += usize::from(pair.verdict == Verdict::Separated);
        }
    }
    assert!(decided > 1_000 && work[0] / 2 < work[1] / 2, "{decided}");
}

/// Two balls draw near in ever smaller steps: the frame in which they meet is the one in which a query says so.
#[test]
fn bodies_that_approach_slowly_are_seen_to_meet() {
    for (turn, extremes) in [
        (DMat3::IDENTITY, true),
        (DMat3::from_rotation_z(0.7) * (1.0 + 4e-5), false),
    ] {
        let (ball, mut scene) = (knowing_ball(extremes), Scene::new());
        let far = DVec3::new(1e5, -2e5, 3e5);
        fixed(&mut scene, &ball, Pose::new(turn, far).unwrap());
        let id = moving(&mut scene, &ball, at(0.0, 0.0, 0.0));
        let (mut gap, mut met, mut queries) = (0.05, 0, 0);
        for frame in 0..4_000 {
            gap -= 2e-5;
            let place = Pose::new(
                DMat3::from_rotation_y(1e-6 * f64::from(frame)),
                far + DVec3::X * (2.0 + gap),
            )
            .unwrap();
            scene.set_pose(id, place).unwrap();
            let report = whole_frame(&mut scene);
            queries += usize::from(report.work > 0);
            let bodies: Vec<(BodyId, &Body)> = scene.bodies().collect();
            let b_in_a = bodies[0].1.pose.inverse().unwrap().compose(&place).unwrap();
            let truth = check::run(
                &Query::intersection(&ball, &ball, b_in_a),
                &mut Workspace::new(),
                Budget::unlimited(),
            );
            let verdict = scene
                .report()
                .pairs
                .first()
                .map_or(Verdict::Separated, |pair| pair.verdict);
            assert_eq!(
                verdict == Verdict::Separated,
                truth.value == Verdict::Separated,
                "gap {gap:e}"
            );
            met += usize::from(truth.value != Verdict::Separated);
        }
        assert!(met > 100 && queries - met < 1_000, "{met} {queries}");
    }
}

/// Balls tremble side by side, closer than the first proof asks for: they need a query in few frames all the same, and are never
/// said to meet.
#[test]
fn bodies_that_tremble_close_by_need_few_queries() {
    let ball = ball(3);
    for steps in [12.0, 24.0, 48.0] {
        let (step, mut scene) = (2e-4, Scene::new());
        fixed(&mut scene, &ball, Pose::IDENTITY);
        let [x, y] = [std::f64::consts::FRAC_1_SQRT_2; 2].map(|part| part * (2.0 + steps * step));
        let id = moving(&mut scene, &ball, at(x, y, 0.0));
        let mut free = 0;
        for frame in 0..96 {
            put(&mut scene, id, at(x, y, step * f64::from(frame % 2)));
            let report = whole_frame(&mut scene);
            assert_eq!(
                (report.pairs.len(), report.decided, report.intersecting),
                (1, 1, 0)
            );
            free += usize::from(report.work == 0);
        }
        assert!(free >= 72, "{steps} {free}");
    }
}

/// A ball rolls over another, far in a frame and close to it: a plane parts them, for the work of some planes a frame, if both
/// trees keep extremes and neither was refitted. Where the balls meet is told as ever.
#[test]
fn a_separating_plane_spares_the_search() {
    let mut refitted = Tree::clone(&knowing_ball(true));
    let vertices: Vec<_> = (0..refitted.mesh().vertex_count())
        .map(|i| refitted.mesh().vertex(i).as_vec3().to_array())
        .collect();
    refitted.refit(&vertices).unwrap();
    let rolling = |of: [Arc<Tree>; 2]| {
        let mut scene = Scene::new();
        scene
            .insert(Body::fixed(Arc::clone(&of[0]), at(3.0, 2.0, 1.0)))
            .unwrap();
        let id = scene
            .insert(Body::moving(Arc::clone(&of[1]), at(0.0, 0.0, 0.0)))
            .unwrap();
        let mut work = 0;
        for frame in 0..200 {
            let (angle, apart) = (0.05 * f64::from(frame), frame / 2 != 50);
            let away = DVec3::new(angle.cos(), angle.sin(), (2.0 * angle).sin()).normalize();
            let center = DVec3::new(3.0, 2.0, 1.0) + away * if apart { 2.001 } else { 1.9 };
            put(
                &mut scene,
                id,
                Pose::new(DMat3::from_rotation_y(3.0 * angle), center).unwrap(),
            );
            let report = whole_frame(&mut scene);
            assert_eq!(
                (report.decided, report.intersecting),
                (report.pairs.len(), usize::from(!apart)),
                "{frame}"
            );
            // Before the first plane there is a search, and after the balls have met there are some.
            work += if frame == 0 || (100..110).contains(&frame) {
                0
            } else {
                report.work
            };
        }
        work
    };
    let [kept, of_one] =
        [[true, true], [true, false]].map(|extremes| rolling(extremes.map(knowing_ball)));
    let of_refitted = rolling([Arc::new(refitted), knowing_ball(true)]);
    assert!(kept < of_one / 4 && kept < 190 * 3500, "{kept} {of_one}");
    assert_eq!(of_one, of_refitted);
}

/// What a body was before counts no more, not even nothing, which has no place to go from.
#[test]
fn a_body_that_had_no_mesh_stays_apart_like_others() {
    let [ball, nothing] = [
        shapes::icosphere(2),
        Mesh::new([] as [[f32; 3]; 0], [] as [[u32; 3]; 0]).unwrap(),
    ]
    .map(|mesh| Arc::new(Tree::new(mesh)));
    let mut scene = Scene::new();
    fixed(&mut scene, &ball, Pose::IDENTITY);
    let id = moving(&mut scene, &ball, Pose::IDENTITY);
    for tree in [&nothing, &ball] {
        scene.set_tree(id, Arc::clone(tree)).unwrap();
        let mut free = 0;
        for frame in 0..60 {
            put(&mut scene, id, at(1.5, 1.5, 1e-5 * f64::from(frame)));
            let report = whole_frame(&mut scene);
            assert_eq!(
                (report.pairs.len(), report.intersecting),
                (usize::from(!tree.mesh().is_empty()), 0)
            );
            free += usize::from(report.work == 0);
        }
        assert!(free > 50, "{free}");
    }
}

/// Of how many frames ago a pair was decided, those count in which no query was needed.
#[test]
fn a_pair_that_was_known_to_be_apart_is_as_old_as_that() {
    let ball = ball(3);
    for quiet in [1, 30] {
        let mut scene = Scene::new();
        fixed(&mut scene, &ball, Pose::IDENTITY);
        let id = moving(&mut scene, &ball, at(1.5, 1.5, 0.0));
        for frame in 0..10 + quiet {
            put(&mut scene, id, at(1.5, 1.5, 1e-5 * f64::from(frame)));
            let report = whole_frame(&mut scene);
            assert!(report.decided == 1 && (frame < 10 || report.work == 0));
        }
        for age in 1..4 {
            put(&mut scene, id, at(1.45, 1.45, 0.01 * age as f64));
            let pair = detect(&mut scene, Budget::work(0)).pairs[0];
            assert_eq!((pair.verdict, pair.age), (Verdict::Undecided, age));
        }
    }
}

#[test]
fn bodies_that_come_to_rest_in_contact_have_triangles_that_meet_there() {
    let tree = ball(2);
    let mut scene = Scene::new();
    let mut insert = |pose| scene.insert(Body::moving(Arc::clone(&tree), pose)).unwrap();
    let [a, b, far] = [at(0.0, 0.0, 0.0), at(1.2, 0.0, 0.0), at(9.0, 0.0, 0.0)].map(&mut insert);
    let (mut workspace, mut searches) = (Workspace::new(), 0);
    for step in 0..200 {
        // It turns about the other for 20 frames, with a stop of 5; meanwhile another body goes its way.
        let turn = f64::from(step - step % 25 + (step % 25).min(20)) / 40.0;
        let place = at(1.2 * turn.cos(), 1.2 * turn.sin(), 0.0);
        let rests = step % 25 > 20;
        if !rests {
            scene.set_pose(b, place).unwrap();
        }
        put(&mut scene, far, at(9.0 + f64::from(step), 0.0, 0.0));
        let report = whole_frame(&mut scene);
        let told = *report.pair(a, b).unwrap();
        let Verdict::Intersecting { witness } = told.verdict else {
            panic!("{told:?}, step {step}")
        };
        assert!(
            told.complete && told.age == 0 && (!rests || report.work == 0),
            "{told:?}"
        );
        searches += usize::from(report.bv_tests > 0);
        let query = Query::all_pairs(&tree, &tree, place);
        let (_, meeting) = check::run_to_end(&query, &mut workspace, Budget::unlimited());
        assert!(meeting.contains(&witness), "{witness:?} {step}");
    }
    assert!((1..100).contains(&searches), "{searches}");
}
