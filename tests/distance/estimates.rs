//! What is expected of a distance query: in order, within what is proven, nothing left at the end, about right.

use punctual::distance::Bounds;
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Quantiles;
use punctual::{Budget, PairMemory, Pose, Query, ResumeError, StopReason, Tree, Workspace, shapes};

use crate::common::meshes::{knot, nothing, placed};
use crate::distance::{ENOUGH, answer, run, run_with_memory};

fn is_ordered(Quantiles { p10, p50, p90 }: Quantiles) -> bool {
    0.0 <= p10 && p10 <= p50 && p50 <= p90
}

fn trees() -> [Tree; 2] {
    [knot(0.2, 40), Tree::new(shapes::gear(20, 2))]
}

fn poses() -> impl Iterator<Item = Pose> {
    (0..60).map(|i| {
        let turn = 0.7 * f64::from(i);
        let place = DVec3::new(1.0 + 0.05 * f64::from(i), turn.cos(), turn.sin());
        placed(DMat3::from_rotation_y(turn), place)
    })
}

#[test]
fn estimates_lie_within_what_is_proven_and_end_with_it() {
    let [a, b] = trees();
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    for pose in poses() {
        for limit in [f64::INFINITY, 0.3, 0.0] {
            let query = Query::distance(&a, &b, pose)
                .margins([0.1, 0.0])
                .closer_than(limit);
            let other = Query::distance(&b, &a, pose);
            let mut found = run(&query, &mut workspace, Budget::work(0));
            let mut budget = 100;
            loop {
                let said = query.estimate(&workspace, Some(&memory)).unwrap();
                let (remaining, distance) = (said.remaining, said.distance);
                assert!(is_ordered(remaining) && is_ordered(distance), "{said:?}");
                let Bounds { low, high, .. } = found.value;
                assert!(low <= distance.p10 && distance.p90 <= high, "{said:?}");
                // The same each time.
                assert_eq!(query.estimate(&workspace, Some(&memory)), Ok(said));
                assert_eq!(other.estimate(&workspace, None), Err(ResumeError));
                if found.stop == StopReason::Finished {
                    assert_eq!(remaining, Quantiles::default());
                    break;
                }
                assert!(remaining.p10 > 0.0);
                found = query.resume(&mut workspace, Budget::work(budget)).unwrap();
                budget *= 2;
            }
            let _ = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
        }
    }
}

/// On shapes that nothing was fitted on, most queries take no more than twice the upper quantile, and those without a limit no
/// less than half of the lower one.
#[test]
fn predicted_work_is_about_right() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    for limit in [f64::INFINITY, 0.5] {
        let mut memory = PairMemory::new();
        let (mut below, mut within) = ([0; 2], [0; 2]);
        for pose in poses() {
            let query = Query::distance(&a, &b, pose).closer_than(limit);
            let told = [None, Some(&memory)].map(|memory| query.predict(memory));
            let warm = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
            for (i, (told, said)) in told.into_iter().zip([answer(&query), warm]).enumerate() {
                assert!(is_ordered(told) && told.p10 >= 84.0, "{told:?}");
                let work = said.stats.work as f64;
                let is_below = work <= 2.0 * told.p90;
                below[i] += usize::from(is_below);
                within[i] += usize::from(is_below && 0.5 * told.p10 <= work);
            }
        }
        println!("limit {limit}: {below:?} below, {within:?} within, of 60");
        assert!(below.iter().all(|&below| below >= 36), "{limit} {below:?}");
        let is_enough = within.iter().all(|&within| within >= 36);
        assert!(limit.is_finite() || is_enough, "{within:?} of 60");
    }
    let nothing = nothing();
    let told = Query::distance(&a, &nothing, Pose::IDENTITY).predict(None);
    assert!(is_ordered(told));
}
