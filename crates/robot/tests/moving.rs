//! Obstacles that move by themselves, motions along polynomials, and controllers, against labels at
//! many moments.

mod cell;

use std::time::Duration;

use cell::{UNLIMITED, at, cell, configurations, random};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, StopReason};
use punctual_robot::{
    Checker, Collision, Edge, EdgeAnswer, EdgeOptions, Horizon, Margin, RobotError, Shape, ShapeId,
    Track, Trajectory,
};

/// Labels at any time: the obstacles stand where their tracks are, with their reach as a margin.
struct Truth {
    checker: Checker,
    tracks: Vec<(&'static str, Track)>,
}

impl Truth {
    fn new(tracks: &[(&'static str, Track)]) -> Self {
        let (checker, tracks) = (cell(), tracks.to_vec());
        Self { checker, tracks }
    }

    fn is_free(&mut self, q: &[f64], time: f64) -> bool {
        for (name, track) in &self.tracks {
            let id = self.checker.find(name).unwrap();
            self.checker.move_to(id, track.pose(time)).unwrap();
            let reach = track.reach_at(time);
            self.checker.set_margin(Margin::Of(name), reach).unwrap();
        }
        self.checker.collide(q, UNLIMITED).unwrap().value == Collision::Free
    }
}

fn with(tracks: &[(&'static str, Track)]) -> Checker {
    let mut checker = cell();
    for (name, track) in tracks {
        let id = checker.find(name).unwrap();
        checker.move_along(id, track.clone()).unwrap();
    }
    checker
}

/// Tracks of the ball, the ring and the board that cross the room of the arm.
fn tracks(seed: u64) -> Vec<(&'static str, Track)> {
    let mut random = random(seed);
    let mut vector = |size: f64| [0; 3].map(|_| size * (2.0 * random() - 1.0));
    let [linear, angular] = [vector(1.5), vector(2.0)];
    let ball = Track::velocity(&at(-0.7, 0.3, 0.9), linear, angular).unwrap();
    let turn = |v: [f64; 3]| {
        let v = DVec3::from(v);
        DMat3::from_axis_angle(v.normalize(), 3.0 * v.length())
    };
    let mut pose = || {
        let r = turn(vector(1.0));
        Pose::new(r, DVec3::new(0.2, 0.6, 1.0) + DVec3::from(vector(0.5))).unwrap()
    };
    let ring = Track::poses(&[(0.1, pose()), (0.4, pose()), (0.9, pose())]).unwrap();
    let board = Track::velocity(&at(0.9, 0.0, 0.4), [0.0; 3], [0.0, 0.0, 1.0]).unwrap();
    vec![
        ("ball", ball.reach(0.01, 0.05).unwrap()),
        ("ring", ring),
        ("board", board.reach(0.0, 0.1).unwrap()),
    ]
}

/// What was said of a motion, against labels at many moments of it.
fn compare(
    found: &Edge,
    truth: &mut Truth,
    start: f64,
    end: f64,
    q: impl Fn(f64) -> Vec<f64>,
) -> [bool; 2] {
    for i in 0..=150 {
        let time = end * f64::from(i) / 150.0;
        if time < found.free_until || found.answer == EdgeAnswer::Free {
            assert!(truth.is_free(&q(time), start + time), "{found:?} {time}");
        }
    }
    if let Some(time) = found.touching_at {
        // Times are rounded, so a moment nearby has the contact.
        let near = [time, time - 1e-9, time + 1e-9];
        assert!(
            near.iter()
                .any(|&time| !truth.is_free(&q(time), start + time))
        );
    }
    let is = |answer| found.answer == answer;
    [
        is(EdgeAnswer::Free),
        is(EdgeAnswer::Contact) && found.free_until > 0.0,
    ]
}

fn line(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    let ways = from.iter().zip(to);
    ways.map(|(a, b)| a + share * (b - a)).collect()
}

#[test]
fn obstacles_are_where_their_tracks_are() {
    let turn = DMat3::from_rotation_x(0.4);
    let pose = Pose::new(turn, [1.0, 2.0, 3.0]).unwrap();
    let track = Track::velocity(&pose, [1.0, 0.0, -0.5], [0.0, 0.0, 2.0]).unwrap();
    for time in [-1.0, 0.0, 0.3, 7.0] {
        let passed = f64::max(time, 0.0);
        let found = track.pose(time);
        let want = DVec3::new(1.0 + passed, 2.0, 3.0 - 0.5 * passed);
        assert!(found.translation().distance(want) < 1e-14);
        let want = DMat3::from_rotation_z(2.0 * passed) * turn;
        assert!(found.rotation().abs_diff_eq(want, 1e-13));
    }
    let next = Pose::new(DMat3::from_rotation_x(-2.0), [0.0; 3]).unwrap();
    let track = Track::poses(&[(1.0, pose), (3.0, next), (4.0, pose)]).unwrap();
    for (time, want) in [
        (0.0, pose),
        (1.0, pose),
        (3.0, next),
        (4.0, pose),
        (9.0, pose),
    ] {
        let found = track.pose(time);
        assert!(found.translation().distance(want.translation()) < 1e-14);
        assert!(
            found.rotation().abs_diff_eq(*want.rotation(), 1e-13),
            "{time}"
        );
    }
    let half = DMat3::from_rotation_x(-0.8);
    assert!(track.pose(2.0).rotation().abs_diff_eq(half, 1e-13));
    let wide = track.reach(0.1, 0.2).unwrap();
    assert_eq!(
        [-1.0, 0.0, 2.0].map(|time| wide.reach_at(time)),
        [0.1, 0.1, 0.5]
    );
}

#[test]
fn edges_among_moving_obstacles_are_never_contradicted() {
    let (mut free, mut blocked, mut stopped) = (0, 0, 0);
    for seed in 0..40 {
        let tracks = tracks(seed);
        let (mut checker, mut truth) = (with(&tracks), Truth::new(&tracks));
        for ends in configurations(6, seed).chunks(2) {
            let mut options = EdgeOptions::first();
            (options.start, options.duration) = (0.05 * seed as f64, 0.7);
            let whole = checker
                .edge(&ends[0], &ends[1], &options, UNLIMITED)
                .unwrap()
                .value;
            let q = |time: f64| line(&ends[0], &ends[1], time / 0.7);
            let counts = compare(&whole, &mut truth, options.start, 0.7, q);
            free += u32::from(counts[0]);
            blocked += u32::from(counts[1]);
            options.first = false;
            let any = checker
                .edge(&ends[0], &ends[1], &options, UNLIMITED)
                .unwrap()
                .value;
            assert_eq!(any.answer, whole.answer);
            options.first = true;
            let mut cut = checker
                .edge(&ends[0], &ends[1], &options, Budget::work(500))
                .unwrap();
            while cut.stop != StopReason::Finished {
                stopped += 1;
                assert!(cut.value.free_until <= whole.free_until);
                cut = checker.resume_edge(Budget::work(5_000)).unwrap();
            }
            assert_eq!(cut.value.free_until, whole.free_until);
            let knots = [&ends[0][..], &ends[1], &ends[0]].concat();
            let path = checker.path(&knots, &options, UNLIMITED).unwrap().value;
            let q = |time: f64| line(&ends[0], &ends[1], 1.0 - (time / 0.7 - 1.0).abs());
            compare(&path, &mut truth, options.start, 1.4, q);
        }
    }
    assert!(free > 10 && blocked > 20 && stopped > 100, "{free}");
}

#[test]
fn labels_and_clearances_are_of_now() {
    let tracks = tracks(3);
    let (mut checker, mut truth) = (with(&tracks), Truth::new(&tracks));
    let mut met = 0;
    for q in configurations(200, 8) {
        let is_free = truth.is_free(&q, 0.0);
        let found = checker.collide(&q, UNLIMITED).unwrap().value;
        assert_eq!(found == Collision::Free, is_free);
        let [here, there] = [&mut checker, &mut truth.checker].map(|checker| {
            let found = checker.clearance(&q, &Default::default(), UNLIMITED);
            found.unwrap().value
        });
        // The other one checks the board against nothing more.
        assert!(here.low <= there.high && there.low <= here.high);
        met += u32::from(!is_free);
    }
    assert!(met > 10, "{met}");
}

#[test]
fn polynomials_are_never_contradicted() {
    let (mut free, mut blocked) = (0, 0);
    for seed in 0..30 {
        let tracks = tracks(seed);
        let (mut checker, mut truth) = (with(&tracks), Truth::new(&tracks));
        let rows = configurations(5, 100 + seed);
        let scaled = |i: usize, by: f64| rows[i].iter().map(|x| by * x).collect::<Vec<_>>();
        let (v, a, j) = (scaled(1, 0.8), scaled(2, -1.0), scaled(3, 0.5));
        let mut motion = Trajectory::default();
        motion.push(0.6, &[&rows[0], &v, &a, &j]).unwrap();
        let then = motion.at(0.6);
        motion.push(0.4, &[&then, &scaled(4, 0.7), &a]).unwrap();
        for options in [EdgeOptions::first(), EdgeOptions::any()] {
            let found = checker
                .trajectory(&motion, &options, UNLIMITED)
                .unwrap()
                .value;
            let counts = compare(&found, &mut truth, 0.0, 1.0, |time| motion.at(time));
            free += u32::from(counts[0]);
            blocked += u32::from(counts[1]);
        }
    }
    assert!(free > 5 && blocked > 10, "{free} {blocked}");
    // A line is a polynomial.
    let (mut checker, ends) = (cell(), configurations(60, 9));
    for two in ends.chunks(2) {
        let ways: Vec<f64> = two[0].iter().zip(&two[1]).map(|(a, b)| b - a).collect();
        let mut motion = Trajectory::default();
        motion.push(1.0, &[&two[0], &ways]).unwrap();
        let options = EdgeOptions::first();
        let found = checker
            .trajectory(&motion, &options, UNLIMITED)
            .unwrap()
            .value;
        let edge = checker
            .edge(&two[0], &two[1], &options, UNLIMITED)
            .unwrap()
            .value;
        assert_eq!(
            (found.answer, found.free_until),
            (edge.answer, edge.free_until)
        );
    }
}

/// A plan of lines and a bend, from a free configuration if there is one.
fn plan(seed: u64, truth: &mut Truth) -> Trajectory {
    let rows = configurations(40, seed);
    let mut free = rows.iter().filter(|q| truth.is_free(q, 0.0));
    let mut next = |i: usize| free.next().unwrap_or(&rows[i]);
    let (from, to) = (next(0), next(1));
    let velocity: Vec<f64> = from.iter().zip(to).map(|(a, b)| (b - a) / 0.3).collect();
    let mut plan = Trajectory::default();
    plan.push(0.15, &[from, &velocity]).unwrap();
    let slower: Vec<f64> = velocity.iter().map(|v| -0.8 * v).collect();
    plan.push(0.15, &[&plan.at(0.15), &velocity, &slower])
        .unwrap();
    plan
}

/// Any budget; obstacles that jump, and such that do as they were said to do.
#[test]
fn a_horizon_never_claims_more_than_is_free_nor_brakes_harder_than_it_can() {
    const CYCLE: f64 = 0.004;
    let clock = ManualClock::ticking(Duration::from_nanos(40));
    let (mut proven, mut moved, mut fast, mut braked) = (0, 0, 0, 0);
    for seed in 0..60 {
        let mut random = random(seed + 1);
        let is_timed = seed % 3 > 0;
        let jumps = seed % 4 == 3;
        let braking = [0.0, 0.002, 0.03, 0.1, 0.0501][seed as usize % 5];
        let tracks = if is_timed { tracks(seed) } else { Vec::new() };
        let (mut checker, mut truth) = (with(&tracks), Truth::new(&tracks));
        let plan = plan(seed, &mut truth);
        let mut horizon = Horizon::new(CYCLE, braking).unwrap();
        let (mut speed, mut time, mut new) = (0.0, 0.0, Some(&plan));
        let change = CYCLE / braking + 1e-12;
        for cycle in 0..150 {
            let now = CYCLE * f64::from(cycle);
            for (name, track) in &tracks {
                let id = checker.find(name).unwrap();
                let poses: Vec<_> = (0..60)
                    .map(|i| 0.02 * f64::from(i))
                    .map(|t| (t, track.pose(now + t)))
                    .collect();
                // The ball moves steadily, so its poses are its track.
                if *name == "ball" {
                    let later = Track::poses(&poses).unwrap();
                    let later = later.reach(track.reach_at(now), 0.05).unwrap();
                    checker.move_along(id, later).unwrap();
                }
            }
            if jumps && cycle % 40 == 20 {
                let post = checker.find("post").unwrap();
                let place = at(random() - 0.5, random() - 0.5, random());
                checker.move_to(post, place).unwrap();
                truth.checker.move_to(post, place).unwrap();
            }
            let chosen = (6.0 * random()) as usize;
            let work = [0, 1, 300, 3_000, 30_000, u64::MAX][chosen];
            let budget = Budget::work(if seed % 5 == 4 { work.min(3_000) } else { work });
            // A clock that is read at each step, and late from the beginning for the first.
            let time_left = Duration::from_nanos([0, 1, 300, 3_000, 30_000, 1 << 40][chosen]);
            let budget = match seed % 7 {
                6 => Budget::time(time_left).poll_interval(1).clock(&clock),
                _ => budget.into(),
            };
            let ahead = horizon
                .step(&mut checker, new.take(), budget)
                .unwrap()
                .value;
            assert!((ahead.speed - speed).abs() <= change, "{seed} {ahead:?}");
            assert!((0.0..=1.0).contains(&ahead.speed));
            assert!((ahead.time - time - 0.5 * CYCLE * (speed + ahead.speed)).abs() < 1e-12);
            if ahead.is_proven {
                assert!(ahead.stops_at <= ahead.free_until + 1e-9, "{seed}");
            }
            // Nothing that stands still is met before the time that is proven.
            if cycle % 10 == 0 && !is_timed {
                for i in 0..=30 {
                    let share = f64::from(i) / 30.0;
                    let moment = ahead.time + share * (ahead.free_until - ahead.time);
                    if moment < ahead.free_until && moment >= ahead.time {
                        assert!(truth.is_free(&plan.at(moment), 0.0), "{seed}");
                    }
                }
            }
            let is_moving = speed > 0.0 || ahead.speed > 0.0;
            (speed, time) = (ahead.speed, ahead.time);
            let only_ball = tracks.is_empty();
            if !jumps && is_moving && only_ball {
                assert!(truth.is_free(&plan.at(time), now + CYCLE), "{seed}");
            }
            proven += u32::from(ahead.is_proven);
            moved += u32::from(is_moving);
            fast += u32::from(speed == 1.0);
            braked += u32::from(ahead.since > 0 && speed > 0.0);
        }
    }
    assert!(proven > 3000 && moved > 1000, "{proven}");
    assert!(fast > 200 && braked > 30, "{proven}");
}

/// A slide among balls that cross its way: they do as they are said to do.
#[test]
fn a_horizon_among_moving_obstacles_is_never_met_while_it_moves() {
    const CYCLE: f64 = 0.005;
    let (mut moving, mut met_at_rest, mut arrived) = (0, 0, 0);
    for seed in 0..40 {
        let mut random = random(seed + 70);
        let mut checker = cell();
        let from = vec![0.3, 1.2, 0.2, 0.05];
        let velocity = [1.5, 0.1, -0.4, 0.0];
        let mut plan = Trajectory::default();
        plan.push(1.5, &[&from, &velocity]).unwrap();
        let balls: Vec<_> = (0..3)
            .map(|i| {
                let place = DVec3::new(random() * 2.0 - 1.0, 1.0 + random(), 0.3 + random());
                let velocity = DVec3::new(random() - 0.5, -1.5 * random(), 0.3 * random());
                let name = ["one", "two", "three"][i];
                let shape = Shape::sphere(0.1).unwrap();
                let id = checker
                    .add(name, at(place.x, place.y, place.z), shape)
                    .unwrap();
                (id, place, velocity)
            })
            .collect();
        let mut truth = checker.clone();
        let mut is_free = |q: &[f64], now: f64| {
            for (id, place, velocity) in &balls {
                let p = *place + *velocity * now;
                truth.move_to(*id, at(p.x, p.y, p.z)).unwrap();
            }
            truth.collide(q, UNLIMITED).unwrap().value == Collision::Free
        };
        let mut horizon = Horizon::new(CYCLE, 0.15).unwrap();
        let (mut new, mut speed) = (Some(&plan), 0.0);
        for cycle in 0..400 {
            let now = CYCLE * f64::from(cycle);
            for (id, place, velocity) in &balls {
                let p = *place + *velocity * now;
                let track = Track::velocity(&at(p.x, p.y, p.z), (*velocity).into(), [0.0; 3]);
                checker.move_along(*id, track.unwrap()).unwrap();
            }
            let work = [0, 500, 5_000, 50_000, u64::MAX][(5.0 * random()) as usize];
            let ahead = horizon
                .step(&mut checker, new.take(), Budget::work(work))
                .unwrap()
                .value;
            let is_moving = speed > 0.0 || ahead.speed > 0.0;
            speed = ahead.speed;
            let is_free = is_free(&plan.at(ahead.time), now + CYCLE);
            assert!(!is_moving || is_free, "{seed} {cycle} {ahead:?}");
            moving += u32::from(is_moving);
            met_at_rest += u32::from(!is_free);
            arrived += u32::from(ahead.time > 1.4 && cycle == 399);
        }
    }
    // Some robots at rest are met: that is not their fault.
    assert!(moving > 3000 && met_at_rest > 20 && arrived > 0, "{moving}");
}

#[test]
fn a_plan_that_is_not_proven_is_not_followed_at_speed() {
    let mut checker = cell();
    let line = |from: &[f64], velocity: [f64; 4]| {
        let mut plan = Trajectory::default();
        plan.push(2.0, &[from, &velocity]).unwrap();
        plan
    };
    let first = line(&[0.3, 0.4, 0.2, 0.05], [0.5, 0.0, 0.0, 0.0]);
    let mut horizon = Horizon::new(0.01, 0.2).unwrap();
    let mut step = |plan: Option<&Trajectory>, budget| horizon.step(&mut checker, plan, budget);
    assert!(step(None, UNLIMITED).is_err());
    for cycle in 0..30 {
        let plan = (cycle == 0).then_some(&first);
        assert_eq!(step(plan, UNLIMITED).unwrap().value.is_new, cycle == 0);
    }
    let ahead = step(None, Budget::work(0)).unwrap().value;
    assert_eq!((ahead.speed, ahead.is_proven, ahead.since), (1.0, true, 0));
    let second = line(&first.at(ahead.time), [0.5, 0.1, 0.0, 0.0]);
    // Without a budget nothing is known of it.
    let kept = step(Some(&second), Budget::work(0)).unwrap().value;
    assert!(
        !kept.is_new && kept.is_proven && (kept.speed - 0.95).abs() < 1e-9,
        "{kept:?}"
    );
    assert_eq!(kept.since, 1);
    let third = line(&first.at(kept.time), [0.5, 0.1, 0.0, 0.0]);
    let taken = step(Some(&third), UNLIMITED).unwrap().value;
    assert!(
        taken.is_new && taken.is_proven && taken.time < 0.011,
        "{taken:?}"
    );
}

#[test]
fn what_is_wrong_with_tracks_and_motions_is_named() {
    let mut checker = cell();
    let fault = |error: RobotError| match error {
        RobotError::Model(what) => what,
        other => panic!("{other:?}"),
    };
    let pose = at(0.0, 0.0, 0.0);
    for (track, words) in [
        (
            Track::velocity(&pose, [f64::NAN, 0.0, 0.0], [0.0; 3]),
            "track: velocity [NaN",
        ),
        (Track::poses(&[]), "track: no pose"),
        (
            Track::poses(&[(0.0, pose), (0.0, pose)]),
            "track: pose 0: 0 s follows 0 s",
        ),
        (Track::poses(&[(f64::NAN, pose)]), "track: pose 0: velocity"),
        (
            Track::poses(&[(0.0, pose)]).unwrap().reach(-1.0, 0.0),
            "track: reach -1 m",
        ),
    ] {
        let what = fault(track.unwrap_err());
        assert!(what.starts_with(words), "{what}");
    }
    let still = Track::poses(&[(0.0, pose)]).unwrap();
    let load = checker.find("load").unwrap();
    let what = fault(checker.move_along(load, still.clone()).unwrap_err());
    assert_eq!(what, "obstacle load: is attached to a link");
    let upper = checker.find("upper").unwrap();
    assert_eq!(
        checker.move_along(upper, still),
        Err(RobotError::NoObstacle)
    );
    let mut motion = Trajectory::default();
    let q = [0.0; 4];
    for (seconds, rows, words) in [
        (1.0, vec![], "piece 0: 0 rows"),
        (0.0, vec![&q[..]], "piece 0: 0 s, must be above 0"),
        (f64::NAN, vec![&q[..]], "piece 0: NaN s"),
        (
            1.0,
            vec![&q[..], &q[..3]],
            "piece 0: power 1: 3 numbers, must be 4",
        ),
        (
            1.0,
            vec![&q[..], &[0.0, f64::NAN, 0.0, 0.0]],
            "piece 0: power 1: joint 1: NaN",
        ),
    ] {
        let what = fault(motion.push(seconds, &rows).unwrap_err());
        assert!(what.starts_with(words), "{what}");
    }
    let options = EdgeOptions::any();
    assert!(checker.trajectory(&motion, &options, UNLIMITED).is_err());
    motion.push(1.0, &[&q[..3]]).unwrap();
    let found = checker.trajectory(&motion, &options, UNLIMITED);
    assert_eq!(
        found.unwrap_err(),
        RobotError::Length {
            expected: 4,
            found: 3
        }
    );
    let mut late = EdgeOptions::any();
    late.start = f64::NAN;
    let what = fault(checker.edge(&q, &q, &late, UNLIMITED).unwrap_err());
    assert!(what.starts_with("edge: start NaN s"), "{what}");
    assert!(
        Horizon::new(0.0, 1.0).is_err()
            && Horizon::new(5e-324, 0.0).is_err()
            && Horizon::new(0.1, f64::INFINITY).is_err()
    );
}

/// After any changes the answers are those of a checker that has seen only their result.
#[test]
fn a_world_that_changes_is_as_good_as_a_new_one() {
    let mut random = random(99);
    let mut checker = cell();
    // What the obstacles are that were added: id, place, track and link.
    let mut added: Vec<(ShapeId, Pose, Option<Track>, Option<&str>)> = Vec::new();
    let (mut all, mut met) = (0.0, 0);
    for step in 0..600 {
        let mut within = |low: f64, high: f64| low + (high - low) * random();
        let pose = at(within(-1.0, 1.0), within(-1.0, 1.0), within(0.0, 1.5));
        let velocity = [0; 3].map(|_| within(-1.0, 1.0));
        let (what, which) = (within(0.0, 7.0) as u32, within(0.0, 1.0));
        let which = (which * added.len() as f64) as usize;
        match what {
            0 | 1 => {
                let link = (what == 1 && step % 5 == 0).then_some("fore");
                let shape = Shape::sphere(0.05).unwrap();
                let place = if link.is_some() {
                    at(0.1, 0.1, 0.3)
                } else {
                    pose
                };
                let id = checker
                    .attach("new", link, place, shape, &["fore"])
                    .unwrap();
                added.push((id, place, None, link));
            }
            2 if !added.is_empty() => checker.remove(added.remove(which).0).unwrap(),
            3 if !added.is_empty() && added[which].3.is_none() => {
                checker.move_to(added[which].0, pose).unwrap();
                (added[which].1, added[which].2) = (pose, None);
            }
            4 if !added.is_empty() && added[which].3.is_none() => {
                let track = Track::velocity(&pose, velocity, [0.0; 3]).unwrap();
                checker.move_along(added[which].0, track.clone()).unwrap();
                added[which].2 = Some(track);
            }
            5 if step % 4 == 0 => {
                all = 0.04 * which as f64 / (1 + added.len()) as f64;
                checker.set_margin(Margin::All, all).unwrap();
            }
            _ => {}
        }
        if step % 3 > 0 {
            continue;
        }
        let mut fresh = cell();
        for (_, place, track, link) in &added {
            let shape = Shape::sphere(0.05).unwrap();
            let id = fresh
                .attach("new", *link, *place, shape, &["fore"])
                .unwrap();
            if let Some(track) = track {
                fresh.move_along(id, track.clone()).unwrap();
            }
        }
        fresh.set_margin(Margin::All, all).unwrap();
        assert_eq!(checker.pairs().len(), fresh.pairs().len(), "step {step}");
        let (mut pairs, options) = ([Vec::new(), Vec::new()], EdgeOptions::first());
        for ends in configurations(4, step).chunks(2) {
            let mut found = Vec::new();
            for (checker, pairs) in [&mut checker, &mut fresh].into_iter().zip(&mut pairs) {
                let _ = checker.collide_all(&ends[0], UNLIMITED, pairs).unwrap();
                let edge = checker
                    .edge(&ends[0], &ends[1], &options, UNLIMITED)
                    .unwrap()
                    .value;
                let clearance = checker.clearance(&ends[0], &Default::default(), UNLIMITED);
                let low = clearance.unwrap().value.low;
                found.push((edge.answer, edge.free_until, edge.touching_at, low));
            }
            assert_eq!(pairs[0].len(), pairs[1].len(), "step {step}");
            // The order of distances decides how far below one another the bounds end.
            assert_eq!(
                (found[0].0, found[0].1, found[0].2),
                (found[1].0, found[1].1, found[1].2)
            );
            assert!((found[0].3 - found[1].3).abs() < 2e-6, "step {step}");
            met += u32::from(!pairs[0].is_empty());
        }
    }
    assert!(met > 20 && added.len() > 10, "{met} {}", added.len());
}

#[test]
fn a_robot_that_is_touched_at_rest_is_not_proven() {
    let mut checker = cell();
    let q = [0.3, 0.4, 0.2, 0.05];
    let mut plan = Trajectory::default();
    plan.push(2.0, &[&q, &[0.5, 0.0, 0.0, 0.0]]).unwrap();
    let mut horizon = Horizon::new(0.01, 0.2).unwrap();
    let mut new = Some(&plan);
    let mut time = 0.0;
    // Before the first cycle, and where it stands later: it is in a box.
    for cycle in 0..100 {
        let is_met = cycle % 50 < 10;
        if cycle % 50 == 0 {
            let block = Shape::cuboid([9.0; 3]).unwrap();
            checker.add("block", at(0.0, 0.0, 0.0), block).unwrap();
        }
        if cycle % 50 == 10 {
            let block = checker.find("block").unwrap();
            checker.remove(block).unwrap();
        }
        let ahead = horizon.step(&mut checker, new.take(), UNLIMITED).unwrap();
        let ahead = ahead.value;
        if is_met {
            assert!(!ahead.is_proven && ahead.since > 0, "{cycle} {ahead:?}");
            assert!(ahead.free_until <= time, "{cycle} {ahead:?}");
        } else {
            assert!(ahead.is_proven, "{cycle} {ahead:?}");
        }
        time = ahead.time;
    }
    assert!(time > 0.0);
}
