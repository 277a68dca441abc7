//! What is expected of a distance query: in order, within what is proven, nothing left at the end, about right.

use punctual::distance::DistanceEstimate;
use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Quantiles;
use punctual::{
    Budget, Mesh, PairMemory, Pose, Query, ResumeError, StopReason, Tree, Workspace, shapes,
};

use crate::distance::{ENOUGH, run, run_with_memory};

fn is_ordered(Quantiles { p10, p50, p90 }: Quantiles) -> bool {
    0.0 <= p10 && p10 <= p50 && p50 <= p90
}

fn trees() -> [Tree; 2] {
    [
        Tree::new(shapes::torus_knot(2, 3, 0.2, 40)),
        Tree::new(shapes::gear(20, 2)),
    ]
}

fn poses() -> impl Iterator<Item = Pose> {
    (0..60).map(|i| {
        let turn = 0.7 * f64::from(i);
        let place = DVec3::new(1.0 + 0.05 * f64::from(i), turn.cos(), turn.sin());
        Pose::new(DMat3::from_rotation_y(turn), place).unwrap()
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
                let DistanceEstimate {
                    remaining,
                    distance,
                    ..
                } = said;
                assert!(is_ordered(remaining) && is_ordered(distance), "{said:?}");
                assert!(
                    found.value.low <= distance.p10 && distance.p90 <= found.value.high,
                    "{said:?} of {found:?}"
                );
                assert_eq!(
                    query.estimate(&workspace, Some(&memory)),
                    Ok(said),
                    "the same each time"
                );
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
            let cold = run(&query, &mut workspace, ENOUGH).stats.work;
            let warm = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH)
                .stats
                .work;
            for (i, (told, work)) in told.into_iter().zip([cold, warm]).enumerate() {
                assert!(is_ordered(told) && told.p10 >= 84.0, "{told:?}");
                below[i] += usize::from(work as f64 <= 2.0 * told.p90);
                within[i] +=
                    usize::from((0.5 * told.p10..=2.0 * told.p90).contains(&(work as f64)));
            }
        }
        println!("limit {limit}: {below:?} below, {within:?} within, of 60");
        assert!(
            below.iter().all(|&below| below >= 36),
            "limit {limit}: {below:?} of 60"
        );
        assert!(
            limit.is_finite() || within.iter().all(|&within| within >= 36),
            "{within:?} of 60"
        );
    }
    let nothing = Tree::new(Mesh::new([[0.0f32; 3]], []).unwrap());
    assert!(is_ordered(
        Query::distance(&a, &nothing, Pose::IDENTITY).predict(None)
    ));
}
