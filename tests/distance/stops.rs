//! Whatever stops a query, and wherever: its bounds hold, only close in, and it goes on as if it had never stopped.

use std::time::Duration;

use punctual::clock::ManualClock;
use punctual::distance::{Bounds, Distance};
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::shapes::{icosphere, torus, torus_knot};
use punctual::{
    Answer, Budget, Mesh, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes,
};

use crate::common::ask::{answer, assert_time_is_kept, resumes, run_in_pieces};
use crate::common::meshes::{at, ball, moved, placed, triangles};
use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::common::steps::assert_step;
use crate::distance::{ENOUGH, Question, Truth, resume, run, run_with_memory};

struct Case {
    name: &'static str,
    a: Tree,
    b: Tree,
    pose: Pose,
    truth: Truth,
}

fn case(name: &'static str, a: Mesh, b: Mesh, pose: Pose) -> Case {
    let (a, b) = (Tree::new(a), Tree::new(b));
    let truth = Truth::new(&a, &b, &pose);
    Case {
        name,
        a,
        b,
        pose,
        truth,
    }
}

/// Small enough to stop after every step, and different in what they reach.
fn cases() -> Vec<Case> {
    let mut random = Random::new(2024);
    let turned = pose_about(DVec3::ZERO, 0.3, Drift::Shear, &mut random);
    let linked = placed(DMat3::from_rotation_x(1.57), [1.0, 0.0, 0.0]);
    let away = placed(*turned.rotation(), [2.5, -0.7, 1.0]);
    let [ring, knot] = [torus(1.0, 0.15, 12), torus_knot(2, 3, 0.15, 10)];
    let [sphere, field] = [icosphere(2), shapes::height_field(16, 3)];
    let cube = shapes::cuboid([1.0; 3], 3);
    let far_pose = pose_about(Family::FarOffset.center(), 3.0, Drift::None, &mut random);
    let mut soups = |family, counts: [_; 2]| counts.map(|count| soup(family, count, &mut random));
    let [points, edges] = soups(Family::Degenerate, [70, 70]);
    let [small, large] = soups(Family::Unequal, [150, 30]);
    let [here, there] = soups(Family::FarOffset, [50, 50]);
    let [least, few] = soups(Family::Denormal, [20, 20]);
    let [dust, _] = soups(Family::Uniform, [1, 1]);
    let [zero, one] = [DVec3::ZERO, DVec3::ONE].map(|point| triangles([[point; 3]]));
    let inner = moved(&sphere, |vertex| 0.97 * vertex);
    let same = Pose::IDENTITY;
    vec![
        case("linked rings", ring.clone(), ring.clone(), linked),
        case("crossing rings", ring.clone(), ring, at(0.4, 0.1, 0.05)),
        case("apart", icosphere(1), sphere.clone(), at(9.0, 1.0, 0.0)),
        case("concentric spheres", sphere, inner, same),
        case(
            "face to face",
            cube.clone(),
            cube.clone(),
            at(2.01, 0.5, 0.25),
        ),
        case("flush boxes", cube.clone(), cube, at(2.0, 0.5, 0.25)),
        case("knots", knot, torus_knot(3, 2, 0.15, 10), away),
        case("dust over a field", field, dust, at(0.0, 0.0, 3.0)),
        case("degenerate soups", points, edges, away),
        case("unequal soups", small, large, at(12.0, 14.0, 9.0)),
        case("f64 soups far away", here, there, far_pose),
        case("denormal soups", least, few, same),
        case("two points", zero, one, turned),
    ]
}

/// What is known after each step.
fn steps(query: &Query<Distance>, workspace: &mut Workspace) -> Vec<Answer<Bounds>> {
    let (mut steps, mut bound, mut work) = (Vec::new(), u64::MAX, 0);
    let mut pieces = || std::mem::replace(&mut work, 1);
    let last = run_in_pieces(query, workspace, &mut pieces, |said, held| {
        let now = query.certificate(held).unwrap().upper_bound();
        assert!(now <= bound, "{bound} may be closer, then {now}");
        bound = now;
        steps.push(*said);
    });
    assert_eq!(last.stop, StopReason::Finished);
    steps.push(last);
    steps
}

/// The same, whatever `-0` or NaN there may be.
#[track_caller]
fn assert_same_bits(one: &Answer<Bounds>, other: &Answer<Bounds>, name: &str) {
    assert_eq!(one, other, "{name}");
    let bits = |said: &Answer<Bounds>| {
        let points = said.value.nearest.map(|nearest| nearest.points);
        let points = points.map(|both| both.map(|point| point.to_array().map(f64::to_bits)));
        (said.value.low.to_bits(), said.value.high.to_bits(), points)
    };
    assert_eq!(bits(one), bits(other), "{name}");
}

#[track_caller]
fn assert_closing_in(before: &Answer<Bounds>, after: &Answer<Bounds>) {
    let [x, y] = [before.value, after.value];
    assert!(x.low <= y.low && y.high <= x.high, "{x:?} {y:?}");
    assert!(x.closer.is_none() || y.closer == x.closer, "{x:?} {y:?}");
}

#[test]
fn after_every_step_the_bounds_hold_and_only_close_in() {
    let all = std::env::var_os("PUNCTUAL_ALL_STOPS").is_some();
    let (mut workspace, mut longest) = (Workspace::new(), 0);
    for mut case in cases() {
        for asked in case.truth.questions() {
            let query = asked.query(&case.a, &case.b, case.pose);
            let steps = steps(&query, &mut workspace);
            for two in steps.windows(2) {
                case.truth.assert_sound(&asked, &two[0]);
                assert_closing_in(&two[0], &two[1]);
                longest = longest.max(two[1].stats.work - two[0].stats.work);
            }
            let last = steps.last().unwrap();
            case.truth.assert_complete(&asked, last);
            // A budget ends at the first step that uses it up, and says what is known there.
            let work = last.stats.work;
            let stride = if all { 1 } else { (work / 20).max(1) };
            for budget in (0..work + stride).step_by(stride as usize) {
                let said = run(&query, &mut workspace, Budget::work(budget));
                case.truth.assert_sound(&asked, &said);
                let after = steps.iter().find(|step| step.stats.work >= budget);
                let step = after.unwrap_or(last);
                assert_eq!((said.stats, said.value.high), (step.stats, step.value.high));
                assert_step(said.stats.work, budget, MAX_DISTANCE_STEP_WORK);
            }
            assert_same_bits(&run(&query, &mut workspace, ENOUGH), last, case.name);
        }
    }
    println!("the largest step is {longest}");
    assert!(longest <= MAX_DISTANCE_STEP_WORK, "a step of {longest}");
}

/// Cut anywhere, without a memory and with one that knows; also where a copy of the workspace goes on.
#[test]
fn pieces_of_any_size_end_in_the_same_bits() {
    let mut random = Random::new(11);
    let (mut whole, mut pieces) = (Workspace::new(), Workspace::with_capacity(4096, 1));
    let clock = ManualClock::new();
    let piece = |random: &mut Random| {
        Budget::work([0, 1, 150, 3_000][random.below(4)] + random.below(1_000) as u64)
    };
    for case in cases() {
        for asked in case.truth.questions() {
            let query = asked.query(&case.a, &case.b, case.pose);
            let mut memory = PairMemory::new();
            for _ in 0..3 {
                let mut copy = memory.clone();
                let full = run_with_memory(&query, &mut whole, &mut memory, ENOUGH);
                let mut said = run_with_memory(&query, &mut pieces, &mut copy, piece(&mut random));
                while said.stop == StopReason::WorkLimit {
                    if random.below(8) == 0 {
                        let mut clone = pieces.clone();
                        assert_same_bits(&resume(&query, &mut clone, ENOUGH), &full, case.name);
                    }
                    let known = query.with_memory(&mut copy);
                    let more = piece(&mut random);
                    said = known.resume(&mut pieces, more.clock(&clock)).unwrap();
                }
                assert_same_bits(&said, &full, case.name);
                assert_eq!(copy, memory, "{}", case.name);
            }
        }
    }
}

/// What lies less than the tolerance before the closest triangles is left out, and may have been known to be farther than that.
#[test]
fn with_any_tolerance_stops_after_every_step_end_in_the_same_bits() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(7));
    for family in [Family::Double, Family::Unequal, Family::Grid] {
        for _ in 0..40 {
            let [a, b] = [150, 300].map(|count| Tree::new(soup(family, count, &mut random)));
            let pose = placed(random.rotation(), random.vector() * 6.0);
            let query = Query::distance(&a, &b, pose);
            let length = answer(&query).value.high * random.unit();
            for query in [
                query.absolute_tolerance(length),
                query.relative_tolerance(random.unit()),
            ] {
                let full = run(&query, &mut workspace, ENOUGH);
                let steps = steps(&query, &mut workspace);
                assert_same_bits(steps.last().unwrap(), &full, "stopped after every step");
            }
        }
    }
}

#[test]
fn budgets_of_time_are_sound_and_kept() {
    let more = Budget::time(Duration::from_micros(3));
    let mut workspace = Workspace::new();
    for mut case in cases() {
        for asked in case.truth.questions().into_iter().step_by(3) {
            let query = asked.query(&case.a, &case.b, case.pose);
            let check = |said: &Answer<Bounds>, held: &mut Workspace, clock: &ManualClock| {
                case.truth.assert_sound(&asked, said);
                let mut said = *said;
                let resumes = said.stats.work % 4 == 1;
                while resumes && said.stop == StopReason::Deadline {
                    let next = query.resume(held, more.clock(clock)).unwrap();
                    case.truth.assert_sound(&asked, &next);
                    assert_closing_in(&said, &next);
                    said = next;
                }
                if said.stop != StopReason::Deadline {
                    case.truth.assert_complete(&asked, &said);
                }
            };
            let budgets = (0..).map(|i| i * i / 4);
            assert_time_is_kept(
                &query,
                &mut workspace,
                MAX_DISTANCE_STEP_WORK,
                budgets,
                check,
            );
        }
    }
}

/// Closest points in `f64` take longest, so the clock is looked at after each, unless the deadline is far.
#[test]
fn near_the_deadline_the_clock_is_looked_at_after_all_closest_points() {
    let sphere = ball(2);
    let query = Question::EXACT.query(&sphere, &sphere, at(0.3, 0.0, 2.1));
    let clock = ManualClock::ticking(Duration::from_nanos(1));
    let looks = |time| {
        let said = query.run(&mut Workspace::new(), Budget::time(time).clock(&clock));
        assert_eq!(said.stop, StopReason::Finished);
        said.stats.elapsed.unwrap().as_nanos()
    };
    assert_eq!(looks(Duration::from_secs(1)), 1, "only at the end");
    assert!(looks(Duration::from_micros(9)) > 5);
}

#[test]
fn a_full_queue_loses_nothing() {
    for capacity in [0, 1, 7] {
        let mut workspace = Workspace::with_capacity(capacity, 1);
        for mut case in cases() {
            let questions = case.truth.questions().into_iter();
            for asked in questions.skip(capacity % 3).step_by(3) {
                let query = asked.query(&case.a, &case.b, case.pose);
                let full = run(&query, &mut workspace, ENOUGH);
                case.truth.assert_complete(&asked, &full);
                assert!(full.stats.queue_peak as usize <= capacity);
                let mut said = run(&query, &mut workspace, Budget::work(300));
                while said.stop == StopReason::WorkLimit {
                    case.truth.assert_sound(&asked, &said);
                    let next = resume(&query, &mut workspace, Budget::work(2_100));
                    assert_closing_in(&said, &next);
                    said = next;
                }
                assert_same_bits(&said, &full, case.name);
            }
        }
    }
}

#[test]
fn portable_kernels_give_the_same_bits() {
    let [mut workspace, mut portable] = [Workspace::new(), Workspace::new()];
    portable.use_portable_kernels();
    for case in cases() {
        for asked in case.truth.questions() {
            let query = asked.query(&case.a, &case.b, case.pose);
            let work = run(&query, &mut workspace, ENOUGH).stats.work;
            for budget in [work, work / 3, work * 9 / 10].map(Budget::work) {
                let both = [&mut workspace, &mut portable];
                let [fast, slow] = both.map(|workspace| run(&query, workspace, budget));
                assert_same_bits(&fast, &slow, case.name);
            }
        }
    }
}

#[test]
fn only_a_stopped_run_of_the_same_query_resumes() {
    let mut workspace = Workspace::new();
    for case in cases() {
        let asked = Question::default();
        let query = asked.query(&case.a, &case.b, case.pose);
        let _ = run(&query, &mut workspace, Budget::work(1));
        for stranger in [
            query.absolute_tolerance(0.125),
            query.margins([0.0, 1e-9]),
            query.closer_than(1.0),
            asked.query(&case.b, &case.a, case.pose),
            asked.query(&case.a, &case.b, at(0.1, 0.2, 0.3)),
        ] {
            assert!(!resumes(&stranger, &workspace), "{}", case.name);
        }
        let intersection = Query::all_pairs(&case.a, &case.b, case.pose);
        assert!(!resumes(&intersection, &workspace) && resumes(&query, &workspace));
        let meets = answer(&intersection).stats.found > 0;
        assert_eq!(meets, case.truth.meet(), "{}", case.name);
    }
}
