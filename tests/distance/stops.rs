//! Whatever stops a query, and wherever: its bounds hold, only close in, and it goes on as if it had never stopped.

use std::time::Duration;

use punctual::clock::ManualClock;
use punctual::distance::{Bounds, Distance};
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::{
    Answer, Budget, Mesh, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes,
};

use crate::common::check;
use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::common::steps::assert_step;
use crate::distance::{ENOUGH, Question, Truth, resume, run, run_with_memory};
use crate::finished::{moved, scaled, triangles};

struct Case {
    name: &'static str,
    a: Tree,
    b: Tree,
    pose: Pose,
    truth: Truth,
}

impl Case {
    fn new(name: &'static str, a: Mesh, b: Mesh, pose: Pose) -> Self {
        let (a, b) = (Tree::new(a), Tree::new(b));
        let truth = Truth::new(&a, &b, &pose);
        Self {
            name,
            a,
            b,
            pose,
            truth,
        }
    }
}

/// Small enough to stop after every step, and different in what they reach.
fn cases() -> Vec<Case> {
    let mut random = Random::new(2024);
    let turned = pose_about(DVec3::ZERO, 0.3, Drift::Shear, &mut random);
    let linked = Pose::new(DMat3::from_rotation_x(1.57), DVec3::new(1.0, 0.0, 0.0)).unwrap();
    let away = Pose::new(*turned.rotation(), DVec3::new(2.5, -0.7, 1.0)).unwrap();
    let (ring, box_of) = (
        || shapes::torus(1.0, 0.15, 12),
        |cells| shapes::cuboid(Vec3::ONE, cells),
    );
    let far = Family::FarOffset;
    let far_pose = pose_about(far.center(), 3.0, Drift::None, &mut random);
    let mut soup = |family, count| soup(family, count, &mut random);
    let inner = scaled(&shapes::icosphere(2), 0.97, DVec3::ZERO);
    vec![
        Case::new("linked rings", ring(), ring(), linked),
        Case::new("crossing rings", ring(), ring(), moved(0.4, 0.1, 0.05)),
        Case::new(
            "spheres apart",
            shapes::icosphere(1),
            shapes::icosphere(2),
            moved(9.0, 1.0, 0.0),
        ),
        Case::new(
            "concentric spheres",
            shapes::icosphere(2),
            inner,
            Pose::IDENTITY,
        ),
        Case::new(
            "boxes face to face",
            box_of(3),
            box_of(3),
            moved(2.01, 0.5, 0.25),
        ),
        Case::new("flush boxes", box_of(3), box_of(3), moved(2.0, 0.5, 0.25)),
        Case::new(
            "knots",
            shapes::torus_knot(2, 3, 0.15, 10),
            shapes::torus_knot(3, 2, 0.15, 10),
            away,
        ),
        Case::new(
            "dust over a field",
            shapes::height_field(16, 3),
            soup(Family::Uniform, 1),
            moved(0.0, 0.0, 3.0),
        ),
        Case::new(
            "degenerate soups",
            soup(Family::Degenerate, 70),
            soup(Family::Degenerate, 70),
            away,
        ),
        Case::new(
            "unequal soups",
            soup(Family::Unequal, 150),
            soup(Family::Unequal, 30),
            moved(12.0, 14.0, 9.0),
        ),
        Case::new("f64 soups far away", soup(far, 50), soup(far, 50), far_pose),
        Case::new(
            "denormal soups",
            soup(Family::Denormal, 20),
            soup(Family::Denormal, 20),
            Pose::IDENTITY,
        ),
        Case::new(
            "two points",
            triangles([[DVec3::ZERO; 3]]),
            triangles([[DVec3::ONE; 3]]),
            turned,
        ),
    ]
}

/// Everything in turn: after each step.
fn steps(query: &Query<Distance>, workspace: &mut Workspace) -> Vec<Answer<Bounds>> {
    let mut steps = vec![run(query, workspace, Budget::work(0))];
    let mut bound = u64::MAX;
    while steps.last().unwrap().stop != StopReason::Finished {
        let now = query.certificate(workspace).unwrap().upper_bound();
        assert!(now <= bound, "{bound} may be closer, then {now}");
        bound = now;
        steps.push(resume(query, workspace, Budget::work(1)));
    }
    steps
}

/// The same, whatever `-0` or NaN there may be.
#[track_caller]
fn assert_same_bits(one: &Answer<Bounds>, other: &Answer<Bounds>, name: &str) {
    assert_eq!(one, other, "{name}");
    let bits = |said: &Answer<Bounds>| {
        let points = said.value.nearest.map(|nearest| {
            nearest
                .points
                .map(|point| point.to_array().map(f64::to_bits))
        });
        (said.value.low.to_bits(), said.value.high.to_bits(), points)
    };
    assert_eq!(bits(one), bits(other), "{name}");
}

#[test]
fn after_every_step_the_bounds_hold_and_only_close_in() {
    let all = std::env::var_os("PUNCTUAL_ALL_STOPS").is_some();
    let (mut workspace, mut longest) = (Workspace::new(), 0);
    for mut case in cases() {
        for asked in case.truth.questions() {
            let query = asked.query(&case.a, &case.b, case.pose);
            let steps = steps(&query, &mut workspace);
            for said in &steps {
                case.truth.assert_sound(&asked, said);
                let whole = matches!(said.stop, StopReason::WorkLimit | StopReason::Finished);
                assert!(whole, "{}: {said:?}", case.name);
            }
            for two in steps.windows(2) {
                assert!(
                    two[0].value.low <= two[1].value.low && two[1].value.high <= two[0].value.high,
                    "{}: {two:?}",
                    case.name
                );
                assert!(
                    two[0].value.closer.is_none() || two[1].value.closer == two[0].value.closer,
                    "{}: {two:?}",
                    case.name
                );
                longest = longest.max(two[1].stats.work - two[0].stats.work);
            }
            let last = steps.last().unwrap();
            case.truth.assert_complete(&asked, last);
            // A budget ends at the first step that uses it up, and says what is known there.
            let stride = if all {
                1
            } else {
                (last.stats.work / 20).max(1)
            };
            for budget in (0..last.stats.work + stride).step_by(stride as usize) {
                let said = run(&query, &mut workspace, Budget::work(budget));
                case.truth.assert_sound(&asked, &said);
                let at = steps
                    .partition_point(|step| step.stats.work < budget)
                    .min(steps.len() - 1);
                assert!(
                    said.stats == steps[at].stats && said.value.high == steps[at].value.high,
                    "{}: {said:?}",
                    case.name
                );
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
                        assert_same_bits(&resume(&query, &mut pieces, ENOUGH), &full, case.name);
                        pieces = clone.clone();
                        assert_same_bits(&resume(&query, &mut clone, ENOUGH), &full, case.name);
                    }
                    said = query
                        .with_memory(&mut copy)
                        .resume(&mut pieces, piece(&mut random).clock(&clock))
                        .unwrap();
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
            let pose = Pose::new(random.rotation(), random.vector() * 6.0).unwrap();
            let query = Query::distance(&a, &b, pose);
            let size = run(&query, &mut workspace, ENOUGH).value.high;
            for query in [
                query.absolute_tolerance(size * random.unit()),
                query.relative_tolerance(random.unit()),
            ] {
                let full = run(&query, &mut workspace, ENOUGH);
                assert_same_bits(
                    steps(&query, &mut workspace).last().unwrap(),
                    &full,
                    "stopped after every step",
                );
            }
        }
    }
}

fn piece(random: &mut Random) -> Budget {
    Budget::work([0, 1, 150, 3_000][random.below(4)] + random.below(1_000) as u64)
}

/// The clock ticks once a look, so a budget of k ticks ends at look k.
#[test]
fn budgets_of_time_are_sound_and_kept() {
    let tick = Duration::from_micros(1);
    let mut workspace = Workspace::new();
    for mut case in cases() {
        for asked in case.truth.questions().into_iter().step_by(3) {
            let query = asked.query(&case.a, &case.b, case.pose);
            for ticks in (0u32..).map(|i| i * i / 4) {
                let (clock, time) = (ManualClock::ticking(tick), tick * ticks);
                let mut said = query.run(
                    &mut workspace,
                    Budget::time(time).poll_interval(64).clock(&clock),
                );
                case.truth.assert_sound(&asked, &said);
                let most_per_look = 64.max(time.as_nanos() as u64) + MAX_DISTANCE_STEP_WORK;
                assert!(
                    said.stats.work <= u64::from(ticks + 1) * most_per_look,
                    "{said:?}"
                );
                if said.stop == StopReason::Finished {
                    case.truth.assert_complete(&asked, &said);
                    break;
                }
                assert!(said.stop == StopReason::Deadline && said.stats.elapsed.unwrap() >= time);
                while ticks % 4 == 1 && said.stop == StopReason::Deadline {
                    let more = query
                        .resume(&mut workspace, Budget::time(3 * tick).clock(&clock))
                        .unwrap();
                    case.truth.assert_sound(&asked, &more);
                    assert!(said.value.low <= more.value.low && more.value.high <= said.value.high);
                    said = more;
                }
            }
        }
    }
}

/// Closest points in `f64` take longest, so the clock is looked at after each, unless the deadline is far.
#[test]
fn near_the_deadline_the_clock_is_looked_at_after_all_closest_points() {
    let sphere = Tree::new(shapes::icosphere(2));
    let query = Question::EXACT.query(&sphere, &sphere, moved(0.3, 0.0, 2.1));
    let tick = Duration::from_nanos(1);
    let clock = ManualClock::ticking(tick);
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
            for asked in case
                .truth
                .questions()
                .into_iter()
                .skip(capacity % 3)
                .step_by(3)
            {
                let query = asked.query(&case.a, &case.b, case.pose);
                let full = run(&query, &mut workspace, ENOUGH);
                case.truth.assert_complete(&asked, &full);
                assert!(full.stats.queue_peak as usize <= capacity);
                let mut said = run(&query, &mut workspace, Budget::work(300));
                while said.stop == StopReason::WorkLimit {
                    case.truth.assert_sound(&asked, &said);
                    let more = resume(&query, &mut workspace, Budget::work(2_100));
                    assert!(said.value.low <= more.value.low && more.value.high <= said.value.high);
                    said = more;
                }
                assert_same_bits(&said, &full, case.name);
            }
        }
    }
}

#[test]
fn portable_kernels_give_the_same_bits() {
    let mut portable = Workspace::new();
    portable.use_portable_kernels();
    let mut workspace = Workspace::new();
    for case in cases() {
        for asked in case.truth.questions() {
            let query = asked.query(&case.a, &case.b, case.pose);
            let full = run(&query, &mut workspace, ENOUGH);
            for budget in [
                ENOUGH,
                Budget::work(full.stats.work / 3),
                Budget::work(full.stats.work * 9 / 10),
            ] {
                let [fast, slow] =
                    [&mut workspace, &mut portable].map(|workspace| run(&query, workspace, budget));
                assert_same_bits(&fast, &slow, case.name);
            }
        }
    }
}

/// One workspace for both kinds of questions: neither goes on with a run of the other, nor leaves anything behind.
#[test]
fn distances_and_intersections_in_turn() {
    let mut workspace = Workspace::new();
    let clock = ManualClock::new();
    for mut case in cases() {
        let asked = Question::default();
        let distance = asked.query(&case.a, &case.b, case.pose);
        let strangers = [
            distance.absolute_tolerance(0.125),
            distance.margins([0.0, 1e-9]),
            distance.closer_than(1.0),
            asked.query(&case.b, &case.a, case.pose),
            asked.query(&case.a, &case.b, moved(0.1, 0.2, 0.3)),
        ];
        let meets = Query::all_pairs(&case.a, &case.b, case.pose);
        let [full, all] = [
            run(&distance, &mut Workspace::new(), ENOUGH),
            run(&distance, &mut workspace, ENOUGH),
        ];
        assert_same_bits(&full, &all, case.name);
        assert!(
            distance
                .resume(&mut workspace, ENOUGH.clock(&clock))
                .is_err(),
            "it is complete"
        );
        let outcome = check::run(&meets, &mut Workspace::new(), check::ENOUGH);
        for _ in 0..2 {
            let stopped = run(&distance, &mut workspace, Budget::work(1));
            assert_eq!(stopped.stop, StopReason::WorkLimit);
            assert!(meets.resume(&mut workspace, ENOUGH.clock(&clock)).is_err());
            assert!(
                meets.certificate(&workspace).is_err() && meets.estimate(&workspace, None).is_err()
            );
            for stranger in &strangers {
                assert!(
                    stranger
                        .resume(&mut workspace, ENOUGH.clock(&clock))
                        .is_err()
                );
            }
            assert_same_bits(&resume(&distance, &mut workspace, ENOUGH), &full, case.name);
            let stopped = check::run(&meets, &mut workspace, Budget::work(1));
            if stopped.stop == StopReason::WorkLimit {
                assert!(
                    distance
                        .resume(&mut workspace, ENOUGH.clock(&clock))
                        .is_err()
                );
                assert_eq!(
                    check::resume(&meets, &mut workspace, check::ENOUGH),
                    outcome,
                    "{}",
                    case.name
                );
            }
            assert_eq!(workspace.pairs().len() as u64, outcome.stats.found);
            let _ = run(&distance, &mut workspace, Budget::work(500));
            assert_eq!(
                check::run(&meets, &mut workspace, check::ENOUGH),
                outcome,
                "{}",
                case.name
            );
        }
        case.truth.assert_complete(&asked, &full);
        assert_eq!(case.truth.meet(), outcome.stats.found > 0);
    }
}
