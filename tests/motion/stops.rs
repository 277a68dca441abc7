//! Whatever stops a query, and wherever: nothing false, and it goes on as if it had never stopped.

use punctual::clock::ManualClock;
use punctual::geom::triangle_segment;
use punctual::glam::{DMat3, DVec3};
use punctual::impact::{Impact, TimeOfImpact};
use punctual::prediction::MAX_DISTANCE_STEP_WORK;
use punctual::{Answer, Budget, Motion, PairMemory, Query, StopReason, Tree, Workspace};

use crate::common::ask::{assert_time_is_kept, resumes, run_in_pieces};
use crate::common::meshes::{at, ball, cube, placed, ring};
use crate::common::random::{Family, soup};
use crate::common::steps::assert_step;
use crate::finished::motions;
use crate::judge::{ENOUGH, Truth, answer, resume, run, run_with_memory};
use crate::random::Random;

fn cases() -> Vec<([Tree; 2], Motion)> {
    let mut random = Random::new(5);
    let linked = placed(DMat3::from_rotation_x(1.57), [1.0, 0.0, 0.0]);
    let turning = Motion::turning(linked, [0.0; 3], [0.4, 0.1, 2.0], [1.0, 0.0, 0.0]);
    let straight = |start, velocity: [f64; 3]| Motion::straight(start, velocity).unwrap();
    let landing = straight(at(2.01, 0.5, 0.25), [-0.1, 0.3, 0.1]);
    let sliding = straight(at(2.0, 0.5, 0.25), [0.0, 0.3, 0.1]);
    let coming = straight(at(2.2, 0.3, 0.1), [-0.6, 0.2, 0.1]);
    let screw = Motion::screw(at(4.0, 0.0, 0.0), linked);
    let mut cases = vec![
        ([ring(12), ring(12)], turning.unwrap()),
        ([ring(12), ring(12)], straight(linked, [0.8, 0.1, 0.3])),
        ([cube(3), cube(3)], landing),
        ([cube(3), cube(3)], sliding),
        ([cube(3), ring(12)], screw.unwrap()),
        ([ball(2), cube(3)], coming),
    ];
    for family in [
        Family::Double,
        Family::Degenerate,
        Family::Unequal,
        Family::FarOffset,
        Family::Grid,
    ] {
        let trees = [18, 25].map(|count| Tree::new(soup(family, count, &mut random)));
        let mut all = motions(family, 40, &mut random).into_iter();
        let short = all.find(|motion| motion.turn().length() < 1.0);
        cases.push((trees, short.unwrap()));
    }
    cases
}

/// While a contact is known that is earlier than the one found by more than matters, its place is in one of the boxes.
#[test]
fn after_every_step_nothing_is_false_and_the_first_contact_is_in_the_certificate() {
    let (mut workspace, mut random) = (Workspace::new(), Random::new(1));
    let (mut looked, mut pieces) = (0, 0);
    for ([a, b], motion) in &cases() {
        let mut truth = Truth::new(a, b, *motion);
        let query = truth.query;
        let known = answer(&query);
        truth.assert_complete(&known, &mut random);
        let place = known
            .value
            .upper
            .and_then(|time| place(&query, [a, b], time, known.value.triangles?));
        let end = known.value.upper.unwrap_or(1.0);
        let matters = end + 2.0 * (end - known.value.lower) + 1e-9;
        let time = |said: &Answer<TimeOfImpact>| said.value.upper.unwrap_or(f64::INFINITY);
        let (mut bound, mut before) = (u64::MAX, run(&query, &mut workspace, Budget::work(0)));
        let last = run_in_pieces(
            &query,
            &mut workspace,
            || 1,
            |said, held| {
                truth.assert_sound(said);
                assert!(before.value.lower <= said.value.lower, "{said:?}");
                assert!(time(&before) >= time(said), "{before:?} {said:?}");
                let work = said.stats.work - before.stats.work;
                assert_step(work, 1, MAX_DISTANCE_STEP_WORK);
                before = *said;

                let certificate = query.certificate(held).unwrap();
                let (now, open) = (certificate.upper_bound(), certificate.open_pairs());
                assert!(now <= bound, "{bound}");
                bound = now;
                let boxes: Vec<_> = certificate.boxes().collect();
                assert!(boxes.len() <= open && (open > 0 || now == 0));
                let is_finite = |v: DVec3| v.is_finite();
                assert!(
                    boxes
                        .iter()
                        .all(|open| is_finite(open.min) && is_finite(open.max))
                );
                assert!(boxes.iter().all(|open| !open.is_empty()));
                pieces = pieces.max(open);
                if let Some(place) = place
                    && time(said) > matters
                {
                    let holds = |at: DVec3| boxes.iter().any(|open| open.contains(at));
                    assert!(place.into_iter().all(holds), "{place:?} {said:?}");
                    assert!(now > 0 && certificate.largest_extent() > 0.0);
                    looked += 1;
                }
            },
        );
        assert_eq!(last, known);
        let certificate = query.certificate(&workspace).unwrap();
        assert_eq!(
            (certificate.open_pairs(), certificate.boxes().count()),
            (0, 0)
        );
        // Another query.
        assert!(query.tolerance(0.5).certificate(&workspace).is_err());
    }
    assert!(looked > 300 && pieces > 100, "{looked} {pieces}");
}

/// The ends of what two triangles have in common at a time, in A's frame, if that is known.
fn place(
    query: &Query<Impact>,
    [a, b]: [&Tree; 2],
    time: f64,
    [i, j]: [u32; 2],
) -> Option<[DVec3; 2]> {
    let [of_a, of_b] = [(a, i), (b, j)].map(|(tree, id)| tree.mesh().triangle(id as usize));
    let pose = query.pose(time);
    triangle_segment(&of_a, &of_b.map(|corner| pose.transform_point(corner)))
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
                    assert_eq!(resume(&query, &mut pieces.clone(), ENOUGH), full);
                }
                said = resume(&query, &mut pieces, piece(&mut random));
            }
            assert_eq!(said, full);
            copy = memory.clone();
        }
        let _ = run(&query, &mut pieces, Budget::work(0));
        assert!(!resumes(&query.tolerance(0.5), &pieces), "another query");
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
            let full = answer(&query);
            if full.stop == StopReason::Finished {
                let said = run_in_pieces(&query, &mut workspace, || 1, |_, _| ());
                assert_eq!(said, full, "{query:?}");
            }
        }
    }
}

/// Other kernels give the same bits; a queue without room and a memory that knows, the same answer.
#[test]
fn answers_do_not_depend_on_kernels_or_room() {
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
            assert_eq!(said.value.upper.is_some(), other.value.upper.is_some());
            let off = (said.value.lower - other.value.lower).abs();
            assert!(off < 1e-5, "{said:?} {other:?}");
        }
    }
}

#[test]
fn budgets_of_time_are_sound_and_kept() {
    let mut workspace = Workspace::new();
    for ([a, b], motion) in &cases() {
        let truth = Truth::new(a, b, *motion);
        let check = |said: &Answer<TimeOfImpact>, held: &mut Workspace, clock: &ManualClock| {
            truth.assert_sound(said);
            let budget = Budget::time(std::time::Duration::from_micros(12)).clock(clock);
            if said.stop == StopReason::Deadline {
                truth.assert_sound(&truth.query.resume(held, budget).unwrap());
            }
        };
        let budgets = (0..).map(|i| i * i);
        let (query, step) = (&truth.query, MAX_DISTANCE_STEP_WORK);
        assert_time_is_kept(query, &mut workspace, step, budgets, check);
    }
}
