//! Pairs that are near each other, against distances of all pairs and finite differences.

mod cell;

use cell::{UNLIMITED, cell, configurations, surfaces};
use punctual::{Budget, StopReason};
use punctual_robot::{Checker, ClearanceOptions, Margin, NearPairs, Scope, ShapeId};

const WITHIN: f64 = 0.15;

fn padded() -> Checker {
    let mut checker = cell();
    checker.set_margin(Margin::All, 0.01).unwrap();
    checker
}

fn find(checker: &mut Checker, q: &[f64]) -> NearPairs {
    let (options, mut found) = (
        ClearanceOptions::default().tolerance(1e-10),
        NearPairs::default(),
    );
    let end = checker
        .near_pairs(q, WITHIN, &options, UNLIMITED, &mut found)
        .unwrap();
    assert_eq!((end.stop, end.value), (StopReason::Finished, WITHIN));
    found
}

#[test]
fn pairs_are_those_of_all_distances_at_any_stop() {
    let mut checker = padded();
    let (mut near, mut cut, mut found) = (0, 0, NearPairs::default());
    for q in configurations(200, 12) {
        let distances = surfaces(&checker, &q);
        for work in [0, 1, 700, 4_000, 20_000, u64::MAX] {
            let options = ClearanceOptions::default();
            let budget = Budget::work(work);
            let end = checker
                .near_pairs(&q, WITHIN, &options, budget, &mut found)
                .unwrap();
            cut += u32::from(end.stop != StopReason::Finished);
            for &(pair, distance) in &distances {
                let left = distance - 0.01;
                match found.pairs.iter().find(|near| near.pair == pair) {
                    Some(pair) => {
                        // One may hold the other; boxes are rounded to f32 in the list.
                        let is_held = pair.high == -0.01;
                        let is_within = pair.low <= left + 1e-7 && left <= pair.high + 1e-7;
                        assert!(is_held || is_within, "{pair:?} {left}");
                        assert!(pair.high - pair.low <= 1.01e-6);
                        assert!((pair.normal.length() - 1.0).abs() < 1e-9 || is_held);
                        near += 1;
                    }
                    None => assert!(left >= end.value - 1e-7, "{pair:?} {left} {end:?}"),
                }
            }
            assert!(found.pairs.is_sorted_by_key(|near| near.pair));
            assert_eq!(found.gradients.len(), 4 * found.pairs.len());
        }
    }
    assert!(near > 1_000 && cut > 400, "{near} {cut}");
}

#[test]
fn gradients_are_those_of_finite_differences() {
    let mut checker = padded();
    let left = |found: &NearPairs, pair: [ShapeId; 2]| {
        let near = found.pairs.iter().find(|near| near.pair == pair)?;
        Some(0.5 * (near.low + near.high))
    };
    let (mut compared, mut smooth) = (0, 0);
    for q in configurations(250, 13) {
        let here = find(&mut checker, &q);
        for joint in 0..4 {
            const STEP: f64 = 1e-5;
            let [before, after] = [-STEP, STEP].map(|step| {
                let mut q = q.clone();
                q[joint] += step;
                find(&mut checker, &q)
            });
            for (i, near) in here.pairs.iter().enumerate() {
                let (Some(a), Some(b)) = (left(&before, near.pair), left(&after, near.pair)) else {
                    continue;
                };
                // In contact it is 0, as the points are one.
                if near.high < -0.01 + 1e-4 || a < -0.01 + 1e-4 || b < -0.01 + 1e-4 {
                    continue;
                }
                let now = 0.5 * (near.low + near.high);
                let slopes = [(now - a) / STEP, (b - now) / STEP];
                let given = here.gradient(i)[joint];
                // Where the closest points jump, the slope is that of one of them.
                let [low, high] = [slopes[0].min(slopes[1]), slopes[0].max(slopes[1])];
                assert!(
                    low - 2e-3 <= given && given <= high + 2e-3,
                    "{near:?} {joint} {slopes:?} {given}"
                );
                smooth += u32::from(high - low < 1e-3);
                compared += u32::from(given != 0.0);
            }
        }
    }
    assert!(compared > 1_000 && smooth > 3_000, "{compared} {smooth}");
}

#[test]
fn scopes_and_batches_have_the_same_pairs() {
    let mut checker = padded();
    let rows = configurations(100, 14);
    let options = ClearanceOptions::default();
    let batch = checker
        .near_pairs_batch(&rows.concat(), WITHIN, &options, UNLIMITED, 2)
        .unwrap();
    let mut alone = NearPairs::default();
    for (q, (end, found)) in rows.iter().zip(batch) {
        let again = checker
            .near_pairs(q, WITHIN, &options, UNLIMITED, &mut alone)
            .unwrap();
        assert_eq!((again.value, &alone), (end.value, &found));
        let mut count = 0;
        for scope in [Scope::Robot, Scope::Obstacles] {
            let options = options.scope(scope);
            let _ = checker
                .near_pairs(q, WITHIN, &options, UNLIMITED, &mut alone)
                .unwrap();
            count += alone.pairs.len();
        }
        assert_eq!(count, found.pairs.len());
    }
    let nothing = checker.near_pairs(&rows[0], f64::NAN, &options, UNLIMITED, &mut alone);
    assert_eq!(nothing.unwrap().value, 0.0);
}
