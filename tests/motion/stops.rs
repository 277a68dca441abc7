//! Whatever stops a query, and wherever: nothing false, and it goes on as if it had never stopped.

use punctual::geom::triangle_segment;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::impact::{Impact, TimeOfImpact};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::{
    Answer, Budget, Motion, PairMemory, Pose, Query, StopReason, Tree, Workspace, shapes,
};

use crate::common::random::{Family, soup};
use crate::common::steps::assert_step;
use crate::finished::{at, motions};
use crate::judge::{ENOUGH, Truth, resume, run, run_with_memory};
use crate::random::Random;

fn cases() -> Vec<([Tree; 2], Motion)> {
    let mut random = Random::new(5);
    let linked = Pose::new(DMat3::from_rotation_x(1.57), DVec3::new(1.0, 0.0, 0.0)).unwrap();
    let ring = || Tree::new(shapes::torus(1.0, 0.15, 12));
    let cube = || Tree::new(shapes::cuboid(Vec3::ONE, 3));
    let ball = || Tree::new(shapes::icosphere(2));
    let mut cases = vec![
        (
            [ring(), ring()],
            Motion::turning(linked, [0.0; 3], [0.4, 0.1, 2.0], [1.0, 0.0, 0.0]).unwrap(),
        ),
        (
            [ring(), ring()],
            Motion::straight(linked, [0.8, 0.1, 0.3]).unwrap(),
        ),
        (
            [cube(), cube()],
            Motion::straight(at(2.01, 0.5, 0.25), [-0.1, 0.3, 0.1]).unwrap(),
        ),
        (
            [cube(), cube()],
            Motion::straight(at(2.0, 0.5, 0.25), [0.0, 0.3, 0.1]).unwrap(),
        ),
        (
            [cube(), ring()],
            Motion::screw(at(4.0, 0.0, 0.0), linked).unwrap(),
        ),
        (
            [ball(), cube()],
            Motion::straight(at(2.2, 0.3, 0.1), [-0.6, 0.2, 0.1]).unwrap(),
        ),
    ];
    for family in [
        Family::Double,
        Family::Degenerate,
        Family::Unequal,
        Family::FarOffset,
        Family::Grid,
    ] {
        let trees = [18, 25].map(|count| Tree::new(soup(family, count, &mut random)));
        let short = motions(family, 40, &mut random)
            .into_iter()
            .find(|motion| motion.turn().length() < 1.0);
        cases.push((trees, short.unwrap()));
    }
    cases
}

#[test]
fn after_every_step_nothing_is_false() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(1));
    for ([a, b], motion) in &cases() {
        let mut truth = Truth::new(a, b, *motion);
        let mut steps = vec![run(&truth.query, &mut workspace, Budget::work(0))];
        while steps.last().unwrap().stop != StopReason::Finished {
            assert_eq!(steps.last().unwrap().stop, StopReason::WorkLimit);
            steps.push(resume(&truth.query, &mut workspace, Budget::work(1)));
        }
        truth.assert_complete(steps.last().unwrap(), &mut random);
        for two in steps.windows(2) {
            truth.assert_sound(&two[0]);
            assert!(two[0].value.lower <= two[1].value.lower, "{two:?}");
            let time = |said: &Answer<TimeOfImpact>| said.value.upper.unwrap_or(f64::INFINITY);
            assert!(time(&two[0]) >= time(&two[1]), "{two:?}");
            assert_step(
                two[1].stats.work - two[0].stats.work,
                1,
                MAX_DISTANCE_STEP_WORK,
            );
        }
        assert_eq!(
            &run(&truth.query, &mut workspace, ENOUGH),
            steps.last().unwrap()
        );
    }
}

/// While a contact is known that is earlier than the one found by more than matters, its place is in one of the boxes.
#[test]
fn after_every_step_the_first_contact_is_in_the_boxes_of_the_certificate() {
    let (mut workspace, mut finished) = (Workspace::new(), Workspace::new());
    let (mut looked, mut pieces) = (0, 0);
    for ([a, b], motion) in &cases() {
        let query = Query::impact(a, b, *motion);
        let known = run(&query, &mut finished, ENOUGH);
        assert_eq!(query.certificate(&finished).unwrap().open_pairs(), 0);
        assert!(
            query.tolerance(0.5).certificate(&finished).is_err(),
            "another query"
        );
        let place = known
            .value
            .upper
            .and_then(|time| place(&query, [a, b], time, known.value.triangles?));
        let within = 2.0 * (known.value.upper.unwrap_or(1.0) - known.value.lower) + 1e-9;
        let mut said = run(&query, &mut workspace, Budget::work(0));
        let mut bound = u64::MAX;
        while said.stop != StopReason::Finished {
            let certificate = query.certificate(&workspace).unwrap();
            assert!(
                certificate.upper_bound() <= bound,
                "{bound}, then {}",
                certificate.upper_bound()
            );
            bound = certificate.upper_bound();
            let open = certificate.open_pairs();
            assert!(
                certificate.boxes().count() <= open && (open > 0 || certificate.upper_bound() == 0)
            );
            assert!(
                certificate
                    .boxes()
                    .all(|open| open.min.is_finite() && open.max.is_finite() && !open.is_empty())
            );
            pieces = pieces.max(open);
            if let (Some(time), Some(place)) = (known.value.upper, place)
                && said.value.upper.is_none_or(|found| found > time + within)
            {
                let holds = |at: DVec3| certificate.boxes().any(|open| open.contains(at));
                assert!(place.into_iter().all(holds), "{place:?} {said:?}");
                assert!(certificate.upper_bound() > 0 && certificate.largest_extent() > 0.0);
                looked += 1;
            }
            said = resume(&query, &mut workspace, Budget::work(1));
        }
        assert_eq!(query.certificate(&workspace).unwrap().boxes().count(), 0);
    }
    assert!(looked > 300 && pieces > 100, "{looked} {pieces}");
}

/// The ends of what two triangles have in common at a time, in A's frame, if that is known.
fn place(
    query: &Query<Impact>,
    [a, b]: [&Tree; 2],
    time: f64,
    triangles: [u32; 2],
) -> Option<[DVec3; 2]> {
    let [of_a, of_b] =
        [(a, triangles[0]), (b, triangles[1])].map(|(tree, id)| tree.mesh().triangle(id as usize));
    triangle_segment(
        &of_a,
        &of_b.map(|corner| query.pose(time).transform_point(corner)),
    )
}

/// Without a memory and with one that knows; also where a copy of the workspace goes on, and where another query came between.
#[test]
fn pieces_of_any_size_end_in_the_same_bits() {
    let mut random = Random::new(2);
    let (mut whole, mut pieces) = (Workspace::new(), Workspace::with_capacity(4096, 1));
    for ([a, b], motion) in &cases() {
        let query = Query::impact(a, b, *motion);
        let (mut memory, mut copy) = (PairMemory::new(), PairMemory::new());
        for _ in 0..3 {
            let full = run_with_memory(&query, &mut whole, &mut memory, ENOUGH);
            let most = (full.stats.work / 4).max(3_000) as usize;
            let piece = |random: &mut Random| Budget::work(random.below(most) as u64);
            let mut said = run_with_memory(&query, &mut pieces, &mut copy, piece(&mut random));
            while said.stop == StopReason::WorkLimit {
                if random.below(4) == 0 {
                    let mut clone = pieces.clone();
                    assert_eq!(resume(&query, &mut pieces, ENOUGH), full);
                    pieces = clone.clone();
                    assert_eq!(resume(&query, &mut clone, ENOUGH), full);
                }
                said = resume(&query, &mut pieces, piece(&mut random));
            }
            assert_eq!(said, full);
            copy = memory.clone();
        }
        assert!(
            query
                .resume(
                    &mut pieces,
                    ENOUGH.clock(&punctual::clock::ManualClock::new())
                )
                .is_err(),
            "it is complete"
        );
        let _ = run(&query, &mut pieces, Budget::work(0));
        let other = query.tolerance(0.5);
        assert!(
            other
                .resume(
                    &mut pieces,
                    ENOUGH.clock(&punctual::clock::ManualClock::new())
                )
                .is_err(),
            "another query"
        );
    }
}

/// What lies less than the tolerance before a contact is left out, and may have been known to be later than that.
#[test]
fn with_any_tolerance_stops_after_every_step_end_in_the_same_bits() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(7));
    for family in [Family::Double, Family::Unequal, Family::Grid] {
        for motion in motions(family, 40, &mut random) {
            let [a, b] = [9, 12].map(|count| Tree::new(soup(family, count, &mut random)));
            let query = Query::impact(&a, &b, motion).tolerance(random.unit() * random.unit());
            let full = run(&query, &mut workspace, ENOUGH);
            if full.stop != StopReason::Finished {
                continue;
            }
            let mut said = run(&query, &mut workspace, Budget::work(0));
            while said.stop == StopReason::WorkLimit {
                said = resume(&query, &mut workspace, Budget::work(1));
            }
            assert_eq!(said, full, "{query:?}");
        }
    }
}

/// Other kernels give the same bits; a queue without room and a memory that knows, the same answer.
#[test]
fn what_is_known_does_not_depend_on_kernels_or_room() {
    let (mut portable, mut fast) = (Workspace::new(), Workspace::new());
    portable.use_portable_kernels();
    let mut small = Workspace::with_capacity(0, 1);
    for ([a, b], motion) in &cases() {
        let query = Query::impact(a, b, *motion);
        let said = run(&query, &mut fast, ENOUGH);
        assert_eq!(said, run(&query, &mut portable, ENOUGH));
        let cramped = run(&query, &mut small, ENOUGH);
        let mut memory = PairMemory::new();
        let _ = run_with_memory(&query, &mut fast, &mut memory, ENOUGH);
        let warm = run_with_memory(&query, &mut fast, &mut memory, ENOUGH);
        for other in [cramped, warm] {
            assert_eq!(
                said.value.upper.is_some(),
                other.value.upper.is_some(),
                "{said:?} {other:?}"
            );
            assert!(
                (said.value.lower - other.value.lower).abs() < 1e-5,
                "{said:?} {other:?}"
            );
        }
    }
}

#[test]
fn a_deadline_ends_it_with_what_is_proven() {
    let clock = punctual::clock::ManualClock::ticking(std::time::Duration::from_micros(1));
    let mut workspace = Workspace::new();
    for ([a, b], motion) in &cases() {
        let truth = Truth::new(a, b, *motion);
        let budget = Budget::time(std::time::Duration::from_micros(12));
        let mut said = truth.query.run(&mut workspace, budget.clock(&clock));
        while said.stop == StopReason::Deadline {
            truth.assert_sound(&said);
            said = truth
                .query
                .resume(&mut workspace, budget.clock(&clock))
                .unwrap();
        }
        assert_eq!(said.stop, StopReason::Finished);
    }
}
