//! What a distance proves for motions: they are free for as long as B cannot have gone so far.

use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Quantiles;
use punctual::{Budget, Motion, PairMemory, Pose, Query, StopReason, Tree, Workspace};

use crate::common::meshes::{at, ball, knot};
use crate::common::random::{Family, Random, soup};
use crate::finished::{motions, straight};
use crate::judge::{ENOUGH, Truth, run, run_with_memory};

/// With a memory that knows how far apart the surfaces are at a pose.
fn known_at(a: &Tree, b: &Tree, pose: Pose, budget: Budget) -> (PairMemory, f64) {
    let mut memory = PairMemory::new();
    let query = Query::distance(a, b, pose)
        .absolute_tolerance(0.0)
        .relative_tolerance(0.0);
    let found = query
        .with_memory(&mut memory)
        .run(&mut Workspace::new(), budget.clock(&ManualClock::new()));
    (memory, found.value.low)
}

#[test]
fn a_clearance_makes_motions_free_without_a_search() {
    let (a, b) = (knot(0.2, 32), ball(3));
    let (memory, distance) = known_at(&a, &b, at(5.0, 0.0, 0.0), ENOUGH);
    let ask = |motion: Motion, margin: f64| {
        let query = Query::impact(&a, &b, motion).margins([margin, 0.0]);
        let (mut workspace, mut memory) = (Workspace::new(), memory.clone());
        let said = run_with_memory(&query, &mut workspace, &mut memory, Budget::work(0));
        let is_finished = said.stop == StopReason::Finished;
        (said.value.lower, said.value.upper, is_finished)
    };
    let way = |way: f64| straight(at(5.0, 0.0, 0.0), [-way, 0.0, 0.0]);
    let free = (1.0, None, true);
    assert_eq!(ask(way(0.98 * distance), 0.0), free);
    assert_eq!(ask(way(0.0), 0.0), free, "it stands still");
    for (length, margin) in [(2.0, 0.0), (0.98, 0.5), (1.0, 0.5)] {
        let (length, margin) = (length * distance, margin * distance);
        let (free_until, touching_at, is_finished) = ask(way(length), margin);
        let most = (distance - margin) / length;
        assert!(!is_finished && touching_at.is_none(), "{length} {margin}");
        assert!(
            0.98 * most < free_until && free_until < most,
            "{free_until}"
        );
    }
    // Thickened surfaces may meet at the start.
    assert_eq!(ask(way(0.1 * distance), 1.01 * distance).0, 0.0);
    // Corners of its box go 1.73 a radian.
    let turn = [0.0, 0.9 * distance / 1.75, 0.0];
    let turning = Motion::turning(at(5.0, 0.0, 0.0), [0.0; 3], turn, [5.0, 0.0, 0.0]);
    assert_eq!(ask(turning.unwrap(), 0.0), free);
    // Far from where it was known, nothing is.
    let elsewhere = straight(at(2.0, 0.0, 0.0), [-0.01, 0.0, 0.0]);
    assert_eq!(ask(elsewhere, 0.0).0, 0.0);
}

#[test]
fn a_clearance_never_hides_a_contact_on_the_way() {
    let mut random = Random::new(21);
    let (mut workspace, mut known, mut met, mut free) = (Workspace::new(), 0, 0, 0);
    for family in Family::ALL {
        let [a, b] = [(); 2].map(|()| Tree::new(soup(family, 8, &mut random)));
        for (i, motion) in motions(family, 12, &mut random).into_iter().enumerate() {
            // Every fourth is the beginning of one.
            let begun = (i % 4 == 2)
                .then(|| Motion::screw(motion.pose(0.0), motion.pose(0.01)).ok())
                .flatten();
            let motion = begun.unwrap_or(motion);
            // One body moves, or both do, which seen from A is another motion.
            let both = (i % 3 == 0).then(|| motions(family, 1, &mut random)[0]);
            let query = match both {
                Some(of_a) => Query::impact_of_both([&a, &b], [of_a, motion]),
                None => Query::impact(&a, &b, motion),
            };
            let budget = if i % 2 == 0 {
                ENOUGH
            } else {
                Budget::work(600)
            };
            let (mut memory, _) = known_at(&a, &b, query.pose(0.0), budget);
            let mut truth = Truth::of(query, &a, &b);
            let begun =
                run_with_memory(&query, &mut workspace, &mut memory.clone(), Budget::work(0));
            truth.assert_sound(&begun);
            let said = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
            let cold = run(&query, &mut workspace, ENOUGH);
            assert!(said.value.lower >= begun.value.lower, "{begun:?} {said:?}");
            met += u32::from(truth.assert_complete(&said, &mut random));
            known += u32::from(begun.value.lower > 0.0);
            free += u32::from(begun.value.lower == 1.0);
            assert_eq!(said.value.upper.is_some(), cold.value.upper.is_some());
        }
    }
    println!("{known} known, {free} to the end, {met} met");
    assert!(known > 50 && free > 3 && met > 30, "{known} {free} {met}");
}

/// What costs nothing is no sample of what a search costs.
#[test]
fn predictions_go_by_searches() {
    let (a, b) = (knot(0.2, 32), ball(3));
    let (mut memory, distance) = known_at(&a, &b, at(5.0, 0.0, 0.0), ENOUGH);
    let motion = |way: f64| straight(at(5.0, 0.0, 0.0), [-way, 0.0, 0.0]);
    let far = Query::impact(&a, &b, motion(2.0 * distance));
    let said = run_with_memory(&far, &mut Workspace::new(), &mut memory, ENOUGH);
    assert!(said.value.upper.is_some() && said.stats.work > 0);
    let before: Quantiles = far.predict(Some(&memory));
    let near = Query::impact(&a, &b, motion(0.5 * distance));
    let said = run_with_memory(&near, &mut Workspace::new(), &mut memory, ENOUGH);
    assert_eq!((said.value.lower, said.stats.work), (1.0, 0));
    assert_eq!(far.predict(Some(&memory)), before);
    let turned = Pose::new(DMat3::from_rotation_z(0.1), DVec3::new(5.0, 0.0, 0.0)).unwrap();
    let distance = Query::distance(&a, &b, turned).closer_than(0.1);
    let before = Query::distance(&a, &b, turned).predict(Some(&memory));
    let said = distance
        .with_memory(&mut memory)
        .run(&mut Workspace::new(), ENOUGH.clock(&ManualClock::new()));
    assert_eq!((said.value.closer, said.stats.work), (Some(false), 0));
    assert_eq!(
        Query::distance(&a, &b, turned).predict(Some(&memory)),
        before
    );
}
