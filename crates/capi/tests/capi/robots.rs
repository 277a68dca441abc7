//! Robots: the answers of Rust, and what is refused.

use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::sync::Arc;

use super::call::*;
use ::punctual_robot::{
    Checker, ClearanceOptions, Collision, EdgeOptions, Horizon, Margin, Model, NearPairs, Shape,
    Track, Trajectory, UrdfOptions,
};
use punctual::{Budget, Tree, shapes};
use punctual_capi::{punctual_status as Status, *};

const ARM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robot/examples/arm7.urdf");
const BENT: [f64; 7] = [-0.5, 1.2, 0.3, 0.4, 0.0, 0.2, 0.0];
const TURN: [f64; 7] = [1.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0];

fn text(text: &str) -> CString {
    CString::new(text).unwrap()
}

/// The arm beside a cube, here and in Rust.
fn arms() -> (Box<punctual_robot>, Checker, Box<punctual_tree>) {
    let (urdf, name) = (text(ARM), text("cube"));
    let mut ours =
        owned(|robot| unsafe { punctual_robot_from_urdf(urdf.as_ptr(), null(), null(), 0, robot) });
    let cube = owned(|mesh| punctual_shape_cuboid(0.1, 0.1, 0.4, 1, mesh));
    let tree = tree_of(&cube);
    let mut pose = punctual_pose_identity();
    (pose.m[3], pose.m[7], pose.m[11]) = (0.35, 0.45, 0.5);
    let shape = made(|shape| unsafe {
        let robot = Some(&mut *ours);
        punctual_robot_add(
            robot,
            name.as_ptr(),
            Some(&tree),
            pose,
            null(),
            null(),
            0,
            shape,
        )
    });
    let model = Model::from_urdf(ARM, &UrdfOptions::default()).unwrap();
    let mut theirs = Checker::new(model.into());
    let same = Shape::tree(Tree::new(shapes::cuboid([0.1, 0.1, 0.4], 1)).into());
    let place = punctual::Pose::from_row_major(pose.m).unwrap();
    assert_eq!(theirs.add("cube", place, same).unwrap().number(), shape);
    (ours, theirs, tree)
}

#[test]
fn robots_answer_as_in_rust() {
    let (mut ours, mut theirs, _tree) = arms();
    let then: Vec<f64> = BENT.iter().zip(TURN).map(|(q, v)| q + 2.0 * v).collect();
    let numbers = |pair: Option<[::punctual_robot::ShapeId; 2]>| {
        pair.map_or([PUNCTUAL_NO_SHAPE; 2], |pair| pair.map(|id| id.number()))
    };
    for work in [800, 6_000, u64::MAX] {
        let (budget, same) = (punctual_budget_work(work), Budget::work(work));
        for q in [&BENT, &then[..]] {
            // SAFETY: arrays as long as said, no clock of the caller's.
            let found = made(|out| unsafe {
                punctual_robot_collide(Some(&mut ours), q.as_ptr(), 7, budget, None, slot(out))
            });
            let want = theirs.collide(q, same).unwrap();
            let pair = match want.value {
                Collision::Contact(pair) => Some(pair),
                _ => None,
            };
            assert_eq!((found.work, found.shapes), (want.work, numbers(pair)));
            assert_eq!(
                found.verdict == punctual_robot_verdict::Free,
                want.value == Collision::Free
            );
            let found = made(|out| unsafe {
                punctual_robot_measure(
                    Some(&mut ours),
                    q.as_ptr(),
                    7,
                    1e-6,
                    budget,
                    None,
                    slot(out),
                )
            });
            let want = theirs
                .clearance(q, &ClearanceOptions::default(), same)
                .unwrap();
            assert_eq!(
                (found.low, found.high, found.work),
                (want.value.low, want.value.high, want.work)
            );
            assert_eq!(found.points.map(|p| p.x), want.value.points.map(|p| p.x));
            assert_eq!(
                (found.normal.z, found.shapes),
                (want.value.normal.z, numbers(want.value.pair))
            );
        }
        for first in [0, 1] {
            let options = if first > 0 {
                EdgeOptions::first()
            } else {
                EdgeOptions::any()
            };
            let (from, to) = (BENT.as_ptr(), then.as_ptr());
            let mut found = made(|out| unsafe {
                punctual_robot_edge(Some(&mut ours), from, to, 7, first, budget, None, slot(out))
            });
            let mut want = theirs.edge(&BENT, &then, &options, same).unwrap();
            if want.stop == punctual::StopReason::WorkLimit {
                want = theirs.resume_edge(Budget::unlimited()).unwrap();
                found = made(|out| unsafe {
                    let all = punctual_budget_unlimited();
                    punctual_robot_edge_resume(Some(&mut ours), all, None, slot(out))
                });
            }
            assert_eq!(found.verdict, punctual_robot_verdict::Contact);
            assert_eq!(
                (found.free_until, found.work),
                (want.value.free_until, want.work)
            );
            assert_eq!(Some(found.touching_at), want.value.touching_at);
            assert_eq!(found.shapes, numbers(want.value.pair));
        }
        for seconds in [0.1, 2.0] {
            let found = made(|out| unsafe {
                let (q, v, robot) = (BENT.as_ptr(), TURN.as_ptr(), Some(&mut *ours));
                punctual_robot_horizon(robot, q, v, 7, seconds, budget, None, slot(out))
            });
            let want = theirs.horizon(&BENT, &TURN, seconds, same).unwrap();
            assert_eq!(
                (found.free_until, found.work),
                (want.value.free_until, want.work)
            );
            assert_eq!(
                found.touching_at,
                want.value.touching_at.unwrap_or(f64::INFINITY)
            );
            let is_free = want.value.free_until == seconds;
            assert_eq!(found.verdict == punctual_robot_verdict::Free, is_free);
        }
    }
    let brakes = [5.0; 7];
    let braking =
        made(|out| unsafe { punctual_robot_braking_time(TURN.as_ptr(), brakes.as_ptr(), 7, out) });
    assert_eq!(braking, ::punctual_robot::braking_time(&TURN, &brakes));
    let speed = ::punctual_robot::safe_speed(0.01, 0.001, braking);
    assert_eq!(punctual_robot_safe_speed(0.01, 0.001, braking), speed);
    assert_eq!(made(|out| punctual_robot_joints(Some(&ours), out)), 7);
}

/// An obstacle in the world that is sunk into every link may touch those that are named, and no other.
#[test]
fn obstacles_may_touch_the_links_that_are_named() {
    let (mut ours, mut theirs, tree) = arms();
    let links: Vec<String> = theirs.model().link_names().map(str::to_owned).collect();
    let texts: Vec<CString> = links.iter().map(|link| text(link)).collect();
    let named: Vec<_> = texts.iter().map(|link| link.as_ptr()).collect();
    let (name, mut place) = (text("held"), punctual_pose_identity());
    place.m[11] = 0.5;
    for count in 0..=named.len() {
        let id = made(|shape| unsafe {
            let (name, links) = (name.as_ptr(), named.as_ptr());
            let robot = Some(&mut *ours);
            punctual_robot_add(robot, name, Some(&tree), place, null(), links, count, shape)
        });
        let same = Shape::tree(Tree::new(shapes::cuboid([0.1, 0.1, 0.4], 1)).into());
        let pose = punctual::Pose::from_row_major(place.m).unwrap();
        let may_touch: Vec<&str> = links[..count].iter().map(String::as_str).collect();
        let theirs_id = theirs.attach("held", None, pose, same, &may_touch).unwrap();
        let budget = punctual_budget_unlimited();
        let found = made(|out| unsafe {
            let robot = Some(&mut *ours);
            punctual_robot_collide(robot, BENT.as_ptr(), 7, budget, None, slot(out))
        });
        let want = theirs.collide(&BENT, Budget::unlimited()).unwrap();
        assert_eq!(found.work, want.work, "{count}");
        let is_met = found.verdict == punctual_robot_verdict::Contact;
        assert_eq!(is_met, want.value != Collision::Free, "{count}");
        assert!(is_met || count > 0);
        assert!(!is_met || count < named.len());
        assert_eq!(punctual_robot_remove(Some(&mut ours), id), Status::Ok);
        theirs.remove(theirs_id).unwrap();
    }
}

/// The arm with a link that it does not have in its SRDF file, told with and without room.
#[test]
fn ignored_elements_of_robot_files_are_reported() {
    let srdf = std::env::temp_dir().join(format!("punctual-c-{}.srdf", std::process::id()));
    let pair = "<disable_collisions link1=\"nose\" link2=\"nose\"/>";
    std::fs::write(&srdf, format!("<robot>{pair}\n{pair}</robot>")).unwrap();
    let [urdf, file] = [ARM, srdf.to_str().unwrap()].map(text);
    let robot = owned(|robot| unsafe {
        punctual_robot_from_urdf(urdf.as_ptr(), file.as_ptr(), null(), 0, robot)
    });
    std::fs::remove_file(&srdf).unwrap();
    let mut told = [1u8; 400];
    let length = made(|out| unsafe {
        punctual_robot_notices(Some(&robot), told.as_mut_ptr().cast(), told.len(), out)
    });
    let line = |line: u32| format!("{}:{line}: there is no link nose", srdf.display());
    let want = format!("{}\n{}\0", line(1), line(2));
    assert_eq!(
        (&told[..length + 1], length + 1),
        (want.as_bytes(), want.len())
    );
    let mut cut = [1u8; 3];
    let same = made(|out| unsafe {
        punctual_robot_notices(Some(&robot), cut.as_mut_ptr().cast(), cut.len(), out)
    });
    assert_eq!(
        (same, &cut[..2], cut[2]),
        (length, &want.as_bytes()[..2], 0)
    );
}

fn zero_pair() -> punctual_robot_near_pair {
    let point = punctual_point {
        x: 0.0,
        y: 0.0,
        z: 0.0,
    };
    let (shapes, points) = ([0; 2], [point; 2]);
    punctual_robot_near_pair {
        shapes,
        low: 0.0,
        high: 0.0,
        points,
        normal: point,
    }
}

/// Pairs within a distance, with margins, and beside an obstacle that moves.
#[test]
fn near_pairs_margins_and_tracks_are_those_of_rust() {
    let (mut ours, mut theirs, _tree) = arms();
    let links: Vec<String> = theirs.model().link_names().map(str::to_owned).collect();
    let (cube, link) = (text("cube"), text(links.last().unwrap()));
    let last = links.last().unwrap();
    let none = null();
    let margins = [
        (0.01, none, none, 0, Margin::All),
        (0.02, cube.as_ptr(), none, 0, Margin::Of("cube")),
        (0.04, link.as_ptr(), none, 1, Margin::Padding(last)),
        (
            0.001,
            link.as_ptr(),
            cube.as_ptr(),
            0,
            Margin::Pair(last, "cube"),
        ),
    ];
    let options = ClearanceOptions::default();
    let mut want = NearPairs::default();
    for (margin, name, other, padding, of) in margins {
        for (work, room) in [(u64::MAX, 99), (3_000, 99), (u64::MAX, 2)] {
            let (mut pairs, mut gradients) = (vec![zero_pair(); room], vec![f64::NAN; 7 * room]);
            let found = made(|out| unsafe {
                let budget = punctual_budget_work(work);
                let (pairs, size) = (pairs.as_mut_ptr(), size_of::<punctual_robot_near_pair>());
                let (q, gradients) = (BENT.as_ptr(), gradients.as_mut_ptr());
                let robot = Some(&mut *ours);
                punctual_robot_near_pairs(
                    robot,
                    q,
                    7,
                    0.3,
                    1e-6,
                    budget,
                    None,
                    pairs,
                    size,
                    gradients,
                    room,
                    slot(out),
                )
            });
            let told = theirs.near_pairs(&BENT, 0.3, &options, Budget::work(work), &mut want);
            let told = told.unwrap();
            assert_eq!(
                (found.beyond, found.work, found.count),
                (told.value, told.work, want.pairs.len())
            );
            assert!(found.count > 2 || work < u64::MAX);
            for (i, (found, pair)) in pairs.iter().zip(&want.pairs).enumerate() {
                assert_eq!(found.shapes, pair.pair.map(|id| id.number()));
                assert_eq!(
                    (found.low, found.high, found.normal.x),
                    (pair.low, pair.high, pair.normal.x)
                );
                assert_eq!(found.points.map(|p| p.z), pair.points.map(|p| p.z));
                let row = &want.gradients[7 * i..][..7];
                assert_eq!(&gradients[7 * i..][..7], row);
            }
        }
        let robot = Some(&mut *ours);
        // SAFETY: texts.
        let status = unsafe { punctual_robot_set_margin(robot, margin, name, other, padding) };
        assert_eq!(status, Status::Ok, "{}", last_error());
        theirs.set_margin(of, margin).unwrap();
    }
    let mut place = punctual_pose_identity();
    (place.m[3], place.m[7], place.m[11]) = (0.35, 1.45, 0.5);
    let [linear, angular] = [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let point = |[x, y, z]: [f64; 3]| punctual_point { x, y, z };
    let cube = theirs.find("cube").unwrap();
    let (linear_c, angular_c) = (point(linear), point(angular));
    let (robot, number) = (Some(&mut *ours), cube.number());
    let status = punctual_robot_move_along(robot, number, place, linear_c, angular_c, 0.01, 0.1);
    assert_eq!(status, Status::Ok, "{}", last_error());
    let pose = punctual::Pose::from_row_major(place.m).unwrap();
    let track = Track::velocity(&pose, linear, angular).unwrap();
    theirs
        .move_along(cube, track.reach(0.01, 0.1).unwrap())
        .unwrap();
    let found = made(|out| unsafe {
        let (q, v, all) = (BENT.as_ptr(), [0.0; 7], punctual_budget_unlimited());
        punctual_robot_horizon(Some(&mut ours), q, v.as_ptr(), 7, 3.0, all, None, slot(out))
    });
    let want = theirs
        .horizon(&BENT, &[0.0; 7], 3.0, Budget::unlimited())
        .unwrap();
    assert!(want.value.free_until > 0.3 && want.value.free_until < 3.0);
    assert_eq!(
        (found.free_until, found.work),
        (want.value.free_until, want.work)
    );
}

#[test]
fn bad_margins_and_tracks_are_refused() {
    let (mut robot, _, _) = arms();
    let (nose, cube, none) = (text("nose"), text("cube"), null());
    let (zero, pose) = (zero_pair().normal, punctual_pose_identity());
    let mut near = MaybeUninit::uninit();
    let mut margin = |margin, name, other, padding| {
        // SAFETY: texts.
        unsafe { punctual_robot_set_margin(Some(&mut robot), margin, name, other, padding) }
    };
    refuses! {
        margin(0.1, nose.as_ptr(), none, 0)
            => BadArgument "punctual_robot_set_margin: margin: there is no link or obstacle nose";
        margin(-1.0, cube.as_ptr(), none, 0)
            => BadArgument "punctual_robot_set_margin: margin: -1 m for Of(\"cube\"), allowed is 0 to 1e30";
        margin(0.1, none, cube.as_ptr(), 0) => null "name";
        margin(0.1, none, none, 1) => null "name";
        margin(0.1, cube.as_ptr(), cube.as_ptr(), 1)
            => BadArgument "punctual_robot_set_margin: padding of two names has no value 1";
    }
    let mut along = |shape, reach| {
        punctual_robot_move_along(Some(&mut robot), shape, pose, zero, zero, reach, 0.0)
    };
    refuses! {
        along(999, 0.0) => BadArgument "punctual_robot_move_along: no such obstacle";
        along(999, -1.0)
            => BadArgument "punctual_robot_move_along: track: reach -1 m, 0 m/s, allowed is 0 to 1e30";
    }
    let mut ask = |within, joints, room| unsafe {
        let (q, all, size) = (
            BENT.as_ptr(),
            punctual_budget_unlimited(),
            size_of::<punctual_robot_near_pair>(),
        );
        let (robot, near) = (Some(&mut *robot), slot(Some(&mut near)));
        punctual_robot_near_pairs(
            robot,
            q,
            joints,
            within,
            1e-6,
            all,
            None,
            null_mut(),
            size,
            null_mut(),
            room,
            near,
        )
    };
    assert_eq!(ask(0.1, 7, 0), Status::Ok);
    refuses! {
        ask(0.1, 7, 1) => null "pairs";
        ask(-0.1, 7, 0)
            => BadArgument "punctual_robot_near_pairs: within is -0.1, which is negative or no number";
        ask(0.1, 3, 0) => BadArgument "punctual_robot_near_pairs: 3 joint values, the robot has 7";
        punctual_robot_move_along(None, 0, pose, zero, zero, 0.0, 0.0) => null "robot";
    }
}

#[test]
fn bad_robot_arguments_are_refused() {
    let (mut robot, _, tree) = arms();
    let [urdf, name, nose, none] = [ARM, "it", "nose", "none.urdf"].map(text);
    let pose = punctual_pose_identity();
    let all = punctual_budget_unlimited();
    let q = BENT.as_ptr();
    // SAFETY: arrays and texts as said, no clock of the caller's.
    unsafe {
        refuses! {
            punctual_robot_from_urdf(urdf.as_ptr(), null(), null(), 0, None)
                => null "the place for the new handle";
            punctual_robot_from_urdf(null(), null(), null(), 0, None) => null "urdf";
        }
        let mut out = MaybeUninit::uninit();
        let status = punctual_robot_from_urdf(none.as_ptr(), null(), null(), 0, Some(&mut out));
        assert_eq!(status, Status::BadFile);
        assert!(last_error().contains("none.urdf"), "{}", last_error());
        let mut shape = MaybeUninit::uninit();
        let ours = &mut *robot;
        let mut add = |link: *const _, pose| {
            punctual_robot_add(
                Some(&mut *ours),
                name.as_ptr(),
                Some(&tree),
                pose,
                link,
                null(),
                0,
                Some(&mut shape),
            )
        };
        refuses! {
            add(nose.as_ptr(), pose)
                => BadArgument "punctual_robot_add: obstacle it: there is no link nose";
        }
        let mut tilted = pose;
        tilted.m[0] = 0.9995;
        assert_eq!(add(null(), tilted), Status::BadArgument);
        assert!(
            last_error().contains("obstacle it: pose is off a rotation"),
            "{}",
            last_error()
        );
        refuses! {
            punctual_robot_add(None, name.as_ptr(), Some(&tree), pose, null(), null(), 0, Some(&mut shape))
                => null "robot";
        }
        let ours = Some(&mut *robot);
        refuses! {
            punctual_robot_collide(ours, null(), 7, all, None, null_mut()) => null "values";
        }
        let ours = Some(&mut *robot);
        refuses! {
            punctual_robot_collide(ours, q, 7, all, None, null_mut()) => null "collision";
        }
        let mut collision =
            made(|out| punctual_robot_collide(Some(&mut robot), q, 7, all, None, slot(out)));
        let bad = [f64::NAN; 7];
        refuses! {
            punctual_robot_collide(Some(&mut robot), bad.as_ptr(), 7, all, None, &mut collision)
                => BadArgument "punctual_robot_collide: configuration 0: joint joint1 is not finite or too large";
        }
        let mut clearance =
            made(|out| punctual_robot_measure(Some(&mut robot), q, 7, 0.1, all, None, slot(out)));
        refuses! {
            punctual_robot_measure(Some(&mut robot), q, 7, -1.0, all, None, &mut clearance)
                => BadArgument "punctual_robot_measure: tolerance is -1, which is negative or no number";
        }
        let mut motion =
            made(|out| punctual_robot_edge(Some(&mut robot), q, q, 7, 0, all, None, slot(out)));
        refuses! {
            punctual_robot_edge_resume(Some(&mut robot), all, None, &mut motion)
                => NotResumable "punctual_robot_edge_resume: no stopped edge to resume";
            punctual_robot_horizon(Some(&mut robot), q, q, 7, f64::INFINITY, all, None, &mut motion)
                => BadArgument "punctual_robot_horizon: seconds is inf, which is not finite or too large";
            punctual_robot_shape_name(Some(&robot), 0, null_mut(), 1, None) => null "name";
            punctual_robot_shape_name(Some(&robot), 0, null_mut(), 0, None) => null "length";
            punctual_robot_braking_time(q, q, 7, None) => null "seconds";
        }
    }
    refuses! {
        punctual_robot_joints(None, None) => null "robot";
    }
    let text = "punctual_robot_move: no such obstacle";
    refuses! {
        punctual_robot_move(Some(&mut robot), 0, pose) => BadArgument text;
    }
    let text = "punctual_robot_remove: no such obstacle";
    refuses! {
        punctual_robot_remove(Some(&mut robot), 99) => BadArgument text;
    }
    punctual_robot_free(None);
}

fn same_motion(
    found: &punctual_robot_motion,
    want: &::punctual_robot::Outcome<::punctual_robot::Edge>,
) {
    let touching = want.value.touching_at.unwrap_or(f64::INFINITY);
    assert_eq!(
        (found.free_until, found.work),
        (want.value.free_until, want.work)
    );
    assert_eq!(found.touching_at, touching);
}

/// Motions by polynomials, tested, resumed, and followed from cycle to cycle beside an obstacle that
/// comes; then a pair that may touch.
#[test]
fn trajectories_and_horizons_are_those_of_rust() {
    let (mut ours, mut theirs, _tree) = arms();
    let (mut ours_plan, mut plan) = (
        owned(|out| punctual_trajectory_new(out)),
        Trajectory::default(),
    );
    let bend = TURN.map(|v| -0.2 * v);
    for (seconds, rows) in [
        (1.5, vec![BENT, TURN, bend]),
        (1.0, vec![BENT.map(|q| q + 1.0)]),
    ] {
        let flat = rows.concat();
        // SAFETY: an array as long as said.
        let status = unsafe {
            punctual_trajectory_push(Some(&mut ours_plan), seconds, flat.as_ptr(), rows.len(), 7)
        };
        assert_eq!(status, Status::Ok, "{}", last_error());
        plan.push(
            seconds,
            &rows.iter().map(|row| &row[..]).collect::<Vec<_>>(),
        )
        .unwrap();
    }
    assert_eq!(
        made(|out| punctual_trajectory_seconds(Some(&ours_plan), out)),
        plan.seconds()
    );
    let mut values = [0.0; 7];
    for time in [-1.0, 0.7, 2.0, 9.0] {
        let count = made(|out| unsafe {
            punctual_trajectory_at(Some(&ours_plan), time, values.as_mut_ptr(), 7, out)
        });
        assert_eq!((count, &values[..]), (7, &plan.at(time)[..]));
    }
    for (work, first) in [(u64::MAX, 1), (u64::MAX, 0), (6_000, 1)] {
        let (budget, same) = (punctual_budget_work(work), Budget::work(work));
        let options = [EdgeOptions::any(), EdgeOptions::first()][first as usize];
        let found = made(|out| unsafe {
            let (robot, plan) = (Some(&mut *ours), Some(&*ours_plan));
            punctual_robot_follow(robot, plan, first, budget, None, slot(out))
        });
        same_motion(&found, &theirs.trajectory(&plan, &options, same).unwrap());
        if work < u64::MAX {
            let found = made(|out| unsafe {
                let all = punctual_budget_unlimited();
                punctual_robot_edge_resume(Some(&mut ours), all, None, slot(out))
            });
            same_motion(&found, &theirs.resume_edge(Budget::unlimited()).unwrap());
        }
    }
    let mut ours_horizon = owned(|out| punctual_horizon_new(0.01, 0.1, out));
    let mut horizon = Horizon::new(0.01, 0.1).unwrap();
    let cube = theirs.find("cube").unwrap();
    let mut braked = 0;
    for cycle in 0..150 {
        let work = [200, 3_000, 30_000][cycle % 3];
        let mut pose = punctual_pose_identity();
        (pose.m[3], pose.m[7]) = (0.35, 0.9 - 0.003 * cycle as f64);
        let down = punctual_point {
            x: 0.0,
            y: -0.3,
            z: 0.0,
        };
        let still = zero_pair().normal;
        let number = cube.number();
        let status =
            punctual_robot_move_along(Some(&mut ours), number, pose, down, still, 0.02, 0.1);
        assert_eq!(status, Status::Ok);
        let pose = punctual::Pose::from_row_major(pose.m).unwrap();
        let track = Track::velocity(&pose, [0.0, -0.3, 0.0], [0.0; 3]).unwrap();
        theirs
            .move_along(cube, track.reach(0.02, 0.1).unwrap())
            .unwrap();
        let is_new = cycle == 0;
        let found = made(|out| unsafe {
            let budget = punctual_budget_work(work);
            let (horizon, robot) = (Some(&mut *ours_horizon), Some(&mut *ours));
            let plan = is_new.then_some(&*ours_plan);
            punctual_horizon_step(horizon, robot, plan, budget, None, slot(out))
        });
        let want = horizon
            .step(&mut theirs, is_new.then_some(&plan), Budget::work(work))
            .unwrap();
        let ahead = want.value;
        assert_eq!(
            (
                found.speed,
                found.time,
                found.stops_at,
                found.free_until,
                found.work
            ),
            (
                ahead.speed,
                ahead.time,
                ahead.stops_at,
                ahead.free_until,
                want.work
            )
        );
        assert_eq!(
            (found.is_proven, found.is_new, found.since),
            (ahead.is_proven, ahead.is_new, ahead.since)
        );
        braked += u32::from(ahead.since > 0);
    }
    assert!(braked > 10, "{braked}");
    let (cube, wrist) = (text("cube"), text("wrist"));
    for may_touch in [1, 0] {
        // SAFETY: texts.
        let status = unsafe {
            punctual_robot_allow(Some(&mut ours), cube.as_ptr(), wrist.as_ptr(), may_touch)
        };
        assert_eq!(status, Status::Ok);
        theirs.allow(["cube", "wrist"], may_touch != 0).unwrap();
        let found = made(|out| unsafe {
            let all = punctual_budget_unlimited();
            punctual_robot_collide(Some(&mut ours), BENT.as_ptr(), 7, all, None, slot(out))
        });
        assert_eq!(
            found.work,
            theirs.collide(&BENT, Budget::unlimited()).unwrap().work
        );
    }
    assert_eq!(punctual_trajectory_clear(Some(&mut ours_plan)), Status::Ok);
    assert_eq!(
        made(|out| punctual_trajectory_seconds(Some(&ours_plan), out)),
        0.0
    );
}

#[test]
fn bad_plans_are_refused() {
    let (mut robot, _, _) = arms();
    let mut plan = owned(|out| punctual_trajectory_new(out));
    let mut horizon = owned(|out| punctual_horizon_new(0.01, 0.0, out));
    let (mut a, mut b) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    let mut ahead = MaybeUninit::uninit();
    let mut motion = MaybeUninit::uninit();
    let (cube, nose, all) = (text("cube"), text("nose"), punctual_budget_unlimited());
    let numbers = [0.0, 1.0, f64::NAN, 0.0];
    let mut push = |seconds, powers, joints| {
        // SAFETY: an array of 4.
        unsafe {
            punctual_trajectory_push(Some(&mut plan), seconds, numbers.as_ptr(), powers, joints)
        }
    };
    refuses! {
        push(1.0, 2, 2) => BadArgument "punctual_trajectory_push: piece 0: power 1: joint 0: NaN, allowed is 1e30";
        push(1.0, 0, 2) => BadArgument "punctual_trajectory_push: piece 0: 0 rows, the first of 0 numbers";
        push(1.0, usize::MAX, 2)
            => BadArgument "punctual_trajectory_push: coefficients is longer than memory or not aligned";
        push(0.0, 1, 2) => BadArgument "punctual_trajectory_push: piece 0: 0 s, must be above 0 and at most 1e30";
        punctual_horizon_new(0.0, 1.0, Some(&mut a))
            => BadArgument "punctual_horizon_new: horizon: cycle 0 s, braking 1 s, allowed is 1e-30, and 0, to 1e30";
        punctual_trajectory_new(None) => null "the place for the new handle";
        punctual_horizon_new(1.0, 1.0, None) => null "the place for the new handle";
        punctual_trajectory_seconds(None, None) => null "trajectory";
        punctual_trajectory_clear(None) => null "trajectory";
    }
    assert_eq!(push(1.0, 1, 2), Status::Ok);
    refuses! {
        punctual_horizon_step(Some(&mut horizon), Some(&mut robot), Some(&plan), all, None, slot(Some(&mut ahead)))
            => BadArgument "punctual_horizon_step: 2 joint values, the robot has 7";
        punctual_horizon_step(Some(&mut horizon), Some(&mut robot), None, all, None, slot(Some(&mut ahead)))
            => BadArgument "punctual_horizon_step: a trajectory of no piece, or beyond all times";
        punctual_horizon_step(None, Some(&mut robot), None, all, None, slot(Some(&mut ahead))) => null "horizon";
        punctual_horizon_step(Some(&mut horizon), None, Some(&plan), all, None, slot(Some(&mut ahead)))
            => null "robot";
        punctual_robot_follow(Some(&mut robot), Some(&plan), 0, all, None, slot(Some(&mut motion)))
            => BadArgument "punctual_robot_follow: 2 joint values, the robot has 7";
        punctual_robot_follow(Some(&mut robot), None, 0, all, None, slot(Some(&mut motion))) => null "trajectory";
        punctual_trajectory_at(Some(&plan), 0.0, null_mut(), 2, Some(&mut b)) => null "values";
        punctual_robot_allow(Some(&mut robot), cube.as_ptr(), nose.as_ptr(), 1)
            => BadArgument "punctual_robot_allow: allow: there is no link or obstacle nose";
        punctual_robot_allow(Some(&mut robot), null(), nose.as_ptr(), 1) => null "x";
    }
    punctual_trajectory_free(None);
    punctual_horizon_free(None);
}

/// Writes the name of the part with a number, and its length.
type NameOf<'f> = dyn Fn(usize, *mut c_char, Option<&mut MaybeUninit<usize>>) -> Status + 'f;

/// Names, limits and poses; all pairs that meet; a path, stopped and resumed.
#[test]
fn parts_pairs_and_paths_are_those_of_rust() {
    let (mut ours, mut theirs, _tree) = arms();
    let model = Arc::clone(theirs.model());
    let name = |number, call: &NameOf| {
        let mut bytes = [0u8; 32];
        let length = made(|out| call(number, bytes.as_mut_ptr().cast(), out));
        String::from_utf8(bytes[..length].to_vec()).unwrap()
    };
    let robot = &*ours;
    for (i, (joint, limits)) in model
        .joint_names()
        .iter()
        .zip(model.joint_limits())
        .enumerate()
    {
        // SAFETY: room for 32.
        let told = name(i, &|i, out, length| unsafe {
            punctual_robot_joint_name(Some(robot), i, out, 32, length)
        });
        assert_eq!(told, *joint);
        let [mut lower, mut upper] = [MaybeUninit::new(0.0); 2];
        let (low, high) = (Some(&mut lower), Some(&mut upper));
        assert_eq!(
            punctual_robot_joint_limits(Some(robot), i, low, high),
            Status::Ok
        );
        // SAFETY: written above.
        let told = unsafe { [lower.assume_init(), upper.assume_init()] };
        assert_eq!(told, limits.unwrap_or([-f64::INFINITY, f64::INFINITY]));
    }
    let mut poses = [punctual_pose_identity(); 16];
    let count = made(|out| unsafe {
        punctual_robot_link_poses(Some(robot), BENT.as_ptr(), 7, poses.as_mut_ptr(), 16, out)
    });
    assert_eq!(count, model.link_names().len());
    let places = model.link_poses(&BENT).unwrap();
    for ((i, link), (ours, theirs)) in model
        .link_names()
        .enumerate()
        .zip(poses.iter().zip(&places))
    {
        // SAFETY: room for 32.
        let told = name(i, &|i, out, length| unsafe {
            punctual_robot_link_name(Some(robot), i, out, 32, length)
        });
        assert_eq!((told.as_str(), ours.m), (link, theirs.to_row_major()));
    }
    let (then, all) = (BENT.map(|q| q + 0.7), punctual_budget_unlimited());
    let knots = [BENT, then, BENT, BENT.map(|q| -q)].concat();
    let (mut room, mut want) = ([[0; 2]; 32], Vec::new());
    for (work, at) in [(u64::MAX, 0), (u64::MAX, 1), (u64::MAX, 3), (500, 1)] {
        let q = &knots[7 * at..];
        let mut count = MaybeUninit::uninit();
        let found = made(|out| unsafe {
            let (budget, shapes) = (punctual_budget_work(work), room.as_mut_ptr().cast());
            let (robot, count) = (Some(&mut *ours), Some(&mut count));
            punctual_robot_collide_all(
                robot,
                q.as_ptr(),
                7,
                budget,
                None,
                shapes,
                32,
                count,
                slot(out),
            )
        });
        let told = theirs
            .collide_all(&q[..7], Budget::work(work), &mut want)
            .unwrap();
        let pairs: Vec<_> = want.iter().map(|pair| pair.map(|id| id.number())).collect();
        // SAFETY: written by the call.
        assert_eq!(
            (&room[..unsafe { count.assume_init() }], found.work),
            (&pairs[..], told.work)
        );
    }
    for (first, options) in [(0, EdgeOptions::any()), (1, EdgeOptions::first())] {
        let found = made(|out| unsafe {
            let (robot, budget) = (Some(&mut *ours), punctual_budget_work(4_000));
            punctual_robot_path(robot, knots.as_ptr(), 4, 7, first, budget, None, slot(out))
        });
        same_motion(
            &found,
            &theirs.path(&knots, &options, Budget::work(4_000)).unwrap(),
        );
        if found.stop == punctual_stop_reason::WorkLimit {
            let found = made(|out| unsafe {
                punctual_robot_edge_resume(Some(&mut ours), all, None, slot(out))
            });
            same_motion(&found, &theirs.resume_edge(Budget::unlimited()).unwrap());
        }
    }
    let mut motion = MaybeUninit::uninit();
    let mut path = |count, joints| {
        let (robot, out) = (Some(&mut *ours), slot(Some(&mut motion)));
        // SAFETY: no longer than the array.
        unsafe { punctual_robot_path(robot, knots.as_ptr(), count, joints, 0, all, None, out) }
    };
    refuses! {
        path(1, 7) => BadArgument "punctual_robot_path: a path of fewer than two configurations";
        path(7, 4) => BadArgument "punctual_robot_path: 4 joint values, the robot has 7";
        path(usize::MAX, 7)
            => BadArgument "punctual_robot_path: knots is longer than memory or not aligned";
        punctual_robot_link_name(Some(&ours), 99, null_mut(), 0, None)
            => BadArgument "punctual_robot_link_name: link is 99, but there are 8";
        punctual_robot_link_poses(None, null(), 0, null_mut(), 0, None) => null "robot";
        punctual_robot_joint_limits(None, 0, None, None) => null "robot";
    }
}
