//! Margins against distances of all pairs, each measured alone.

mod cell;

use cell::{UNLIMITED, cell, configurations, surfaces};
use punctual::{Budget, StopReason};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, EdgeAnswer, EdgeOptions, Margin, RobotError, ShapeId,
};

/// What the margin of a pair must be, by names.
fn expected(checker: &Checker, pair: [ShapeId; 2]) -> f64 {
    let names = pair.map(|id| checker.name(id).unwrap());
    let is = |name: &str| names.contains(&name);
    if is("upper") && is("ring") {
        return 0.002;
    }
    let mut margin = 0.01;
    margin += if is("fore") { 0.03 } else { 0.0 };
    let robot = ["base", "upper", "fore", "left", "right", "load"];
    let with_obstacle = names.iter().any(|name| !robot.contains(name));
    margin += if is("left") && with_obstacle {
        0.05
    } else {
        0.0
    };
    margin + if is("board") { 0.02 } else { 0.0 }
}

fn padded() -> Checker {
    let mut checker = cell();
    for (of, metres) in [
        (Margin::All, 0.3),
        (Margin::All, 0.01),
        (Margin::Of("fore"), 0.03),
        (Margin::Of("board"), 0.02),
        (Margin::Padding("left"), 0.05),
        (Margin::Pair("ring", "upper"), 0.002),
    ] {
        checker.set_margin(of, metres).unwrap();
    }
    checker
}

#[test]
fn labels_are_those_of_distances_at_any_stop() {
    let mut checker = padded();
    let (mut within, mut apart, mut stopped, mut pairs) = (0, 0, 0, Vec::new());
    for q in configurations(300, 3) {
        let _ = checker.collide_all(&q, UNLIMITED, &mut pairs).unwrap();
        for (pair, distance) in surfaces(&checker, &q) {
            let margin = expected(&checker, pair);
            let says = pairs.contains(&pair);
            // Solids may hold each other; boxes are rounded to f32 in the list of distances.
            assert!(says || distance > margin - 1e-7, "{pair:?}");
            let is_solid = checker.name(pair[1]) != Some("ring") && distance > 0.0;
            assert!(!says || is_solid || distance < margin + 1e-7, "{pair:?}");
            within += u32::from(says && distance > 1e-6 && distance <= margin);
            apart += u32::from(!says);
        }
        for budget in [0, 1, 200, 1_000, 4_000]
            .map(Budget::work)
            .into_iter()
            .chain([UNLIMITED])
        {
            let found = checker.collide(&q, budget).unwrap();
            match found.value {
                Collision::Free => assert!(pairs.is_empty()),
                Collision::Contact(pair) => assert!(pairs.contains(&pair)),
                Collision::Undecided => stopped += u32::from(found.stop != StopReason::Finished),
            }
        }
    }
    assert!(within > 100 && apart > 1000 && stopped > 300, "{within}");
}

#[test]
fn a_clearance_is_what_is_left_above_the_margin() {
    let mut checker = padded();
    let without_cylinders = ["post", "base"].map(|name| cell().find(name).unwrap());
    let (mut negative, mut positive) = (0, 0);
    for q in configurations(200, 4) {
        let found = checker
            .clearance(&q, &ClearanceOptions::default(), UNLIMITED)
            .unwrap()
            .value;
        let left = surfaces(&checker, &q).into_iter();
        let left = left.map(|(pair, distance)| distance - expected(&checker, pair));
        let least = left.fold(f64::INFINITY, f64::min);
        assert!(found.low <= least + 1e-7, "{found:?} {least}");
        let pair = found.pair.unwrap();
        if !pair.iter().any(|id| without_cylinders.contains(id)) && found.points[0].length() > 0.0 {
            assert!(least <= found.high + 1e-7, "{found:?} {least}");
            let margin = expected(&checker, pair);
            let left = found.points[0].distance(found.points[1]) - margin;
            assert!(
                found.high == -margin || (left - found.high).abs() < 1e-6,
                "{found:?} {left}"
            );
        }
        let is_free = checker.collide(&q, UNLIMITED).unwrap().value == Collision::Free;
        assert!(if is_free {
            found.high >= 0.0
        } else {
            found.low <= 0.0
        });
        negative += u32::from(found.high < 0.0);
        positive += u32::from(found.low > 0.0);
        for work in [0, 100, 2_000, 20_000] {
            let cut = checker.clearance(&q, &ClearanceOptions::default(), Budget::work(work));
            let cut = cut.unwrap().value;
            assert!(cut.low <= found.high && found.low <= cut.high, "{work}");
        }
    }
    assert!(negative > 20 && positive > 20, "{negative} {positive}");
}

/// The label of a configuration is exact, so samples may contradict a proof.
#[test]
fn edges_keep_their_margins() {
    let mut checker = padded();
    let ends = configurations(160, 5);
    let (mut free, mut blocked, mut first_within) = (0, 0, 0);
    for (from, to) in ends.iter().zip(ends.iter().skip(1)) {
        let found = checker
            .edge(from, to, &EdgeOptions::first(), UNLIMITED)
            .unwrap()
            .value;
        let any = checker
            .edge(from, to, &EdgeOptions::any(), UNLIMITED)
            .unwrap()
            .value;
        assert_eq!(found.answer, any.answer);
        let mut at = |share: f64| {
            let q: Vec<f64> = from
                .iter()
                .zip(to)
                .map(|(a, b)| a + share * (b - a))
                .collect();
            checker.collide(&q, UNLIMITED).unwrap().value
        };
        for i in 0..200 {
            let share = f64::from(i) / 200.0;
            assert!(
                share >= found.free_until || at(share) == Collision::Free,
                "{found:?}"
            );
        }
        if let Some(share) = found.touching_at {
            assert_ne!(at(share), Collision::Free);
            first_within += u32::from(share > 0.0);
        }
        free += u32::from(found.answer == EdgeAnswer::Free);
        blocked += u32::from(found.answer == EdgeAnswer::Contact);
        let mut cut = checker
            .edge(from, to, &EdgeOptions::first(), Budget::work(700))
            .unwrap();
        while cut.stop != StopReason::Finished {
            assert!(cut.value.free_until <= found.free_until);
            cut = checker.resume_edge(Budget::work(3_000)).unwrap();
        }
        assert_eq!(cut.value.free_until, found.free_until);
        assert_eq!(cut.value.touching_at, found.touching_at);
    }
    assert!(free > 5 && blocked > 50 && first_within > 20, "{free}");
}

#[test]
fn obstacles_that_come_later_and_batches_follow_the_margins() {
    let mut checker = padded();
    let ring = checker.find("ring").unwrap();
    checker.remove(ring).unwrap();
    let torus = punctual_robot::Shape::mesh(punctual::shapes::torus(0.3, 0.08, 24));
    checker.add("ring", cell::at(0.2, 0.8, 1.0), torus).unwrap();
    let rows = configurations(200, 6);
    let batch = checker.collide_batch(&rows.concat(), UNLIMITED, 2).unwrap();
    let options = ClearanceOptions::default();
    let clearances = checker
        .clearance_batch(&rows.concat(), &options, UNLIMITED, 2)
        .unwrap();
    let mut before = padded();
    for ((q, label), clearance) in rows.iter().zip(batch).zip(clearances) {
        let is_free = before.collide(q, UNLIMITED).unwrap().value == Collision::Free;
        assert_eq!(label.value == Collision::Free, is_free);
        let alone = before.clearance(q, &options, UNLIMITED).unwrap().value;
        assert_eq!(clearance.value.low, alone.low);
    }
}

#[test]
fn the_last_margin_of_two_names_counts_in_either_order() {
    let rows = configurations(20, 7);
    let lows = |checker: &mut Checker| -> Vec<f64> {
        let options = ClearanceOptions::default();
        let mut low = |q: &[f64]| checker.clearance(q, &options, UNLIMITED).unwrap().value.low;
        rows.iter().map(|q| low(q)).collect()
    };
    let (mut checker, mut last) = (cell(), Vec::new());
    for (metres, [a, b]) in [
        (0.1, ["fore", "board"]),
        (0.4, ["board", "fore"]),
        (0.2, ["fore", "board"]),
        (0.3, ["board", "fore"]),
    ] {
        checker.set_margin(Margin::Pair(a, b), metres).unwrap();
        let mut alone = cell();
        alone.set_margin(Margin::Pair(b, a), metres).unwrap();
        let now = lows(&mut checker);
        assert_eq!(now, lows(&mut alone), "{metres} {a} {b}");
        assert_ne!(now, last);
        last = now;
    }
}

#[test]
fn a_margin_of_nobody_or_nothing_is_refused() {
    let mut checker = cell();
    for (of, metres, says) in [
        (
            Margin::Of("tail"),
            0.1,
            "margin: there is no link or obstacle tail",
        ),
        (
            Margin::Pair("fore", "tail"),
            0.1,
            "margin: there is no link or obstacle tail",
        ),
        (
            Margin::All,
            -0.1,
            "margin: -0.1 m for All, allowed is 0 to 1e30",
        ),
        (
            Margin::All,
            f64::NAN,
            "margin: NaN m for All, allowed is 0 to 1e30",
        ),
    ] {
        let error = checker.set_margin(of, metres).unwrap_err();
        assert_eq!(error, RobotError::Model(says.into()));
    }
    // The turret has no shape.
    checker.set_margin(Margin::Of("turret"), 0.1).unwrap();
}
