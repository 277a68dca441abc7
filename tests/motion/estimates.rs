//! What is expected of a motion query: in order, nothing left at the end, about right.

use punctual::glam::{DMat3, DVec3};
use punctual::prediction::Quantiles;
use punctual::{
    Budget, Mesh, Motion, PairMemory, Pose, Query, ResumeError, StopReason, Tree, Workspace, shapes,
};

use crate::judge::{ENOUGH, resume, run, run_with_memory};

fn is_ordered(Quantiles { p10, p50, p90 }: Quantiles) -> bool {
    0.0 < p10 && p10 <= p50 && p50 <= p90 && p90 < f64::INFINITY
}

fn trees() -> [Tree; 2] {
    [
        Tree::new(shapes::torus_knot(2, 3, 0.2, 40)),
        Tree::new(shapes::gear(20, 2)),
    ]
}

/// Straight past, into and away from A, every second one with a turn.
fn motions() -> impl Iterator<Item = Motion> {
    (0..60).map(|i| {
        let angle = 0.7 * f64::from(i);
        let start = DVec3::new(4.0 + 0.05 * f64::from(i), angle.cos(), angle.sin());
        let start = Pose::new(DMat3::from_rotation_y(angle), start).unwrap();
        let turn = if i % 2 == 0 { 0.0 } else { 0.6 };
        Motion::turning(
            start,
            [-5.0, 0.5 * angle.sin(), 0.0],
            [0.0, 0.0, turn],
            start.translation(),
        )
        .unwrap()
    })
}

#[test]
fn estimates_are_in_order_and_end_with_the_query() {
    let [a, b] = trees();
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    for motion in motions() {
        let query = Query::impact(&a, &b, motion);
        let mut found = run(&query, &mut workspace, Budget::work(0));
        let mut budget = 100;
        while found.stop != StopReason::Finished {
            let said = query.remaining(&workspace, Some(&memory)).unwrap();
            assert!(is_ordered(said.work), "{said:?} of {found:?}");
            // The same each time.
            assert_eq!(query.remaining(&workspace, Some(&memory)), Ok(said));
            assert_eq!(
                query.tolerance(0.1).remaining(&workspace, None),
                Err(ResumeError),
                "another query"
            );
            found = resume(&query, &mut workspace, Budget::work(budget));
            budget *= 2;
        }
        assert_eq!(
            query
                .remaining(&workspace, Some(&memory))
                .map(|left| left.work),
            Ok(Quantiles::default())
        );
        let _ = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    }
}

/// On shapes that nothing was fitted on, most queries take no more than twice the upper quantile and no less than half of the
/// lower one.
#[test]
fn predicted_work_is_about_right() {
    let [a, b] = trees();
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let mut within = [0; 2];
    for motion in motions() {
        let query = Query::impact(&a, &b, motion);
        let told = [None, Some(&memory)].map(|memory| query.predict(memory));
        let cold = run(&query, &mut workspace, ENOUGH).stats.work;
        let warm = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH)
            .stats
            .work;
        for (i, (told, work)) in told.into_iter().zip([cold, warm]).enumerate() {
            assert!(is_ordered(told), "{told:?}");
            within[i] += usize::from((0.5 * told.p10..=2.0 * told.p90).contains(&(work as f64)));
        }
    }
    println!("{within:?} within, of 60");
    assert!(within.iter().all(|&within| within >= 40), "{within:?}");
}

#[test]
fn something_is_told_of_every_motion() {
    let [a, nothing] = [shapes::icosphere(1), Mesh::new([[0.0f32; 3]], []).unwrap()].map(Tree::new);
    let point = Tree::new(Mesh::new([[0.0f32; 3]], [[0; 3]]).unwrap());
    let large = Tree::new(
        Mesh::from_f64([[1e300; 3], [-1e300; 3], [1e300, 0.0, 0.0]], [[0, 1, 2]]).unwrap(),
    );
    for [a, b] in [
        [&a, &nothing],
        [&nothing, &a],
        [&a, &point],
        [&point, &point],
        [&a, &large],
        [&large, &large],
    ] {
        for velocity in [[0.0; 3], [1e200, 0.0, 0.0]] {
            let motion = Motion::straight(Pose::IDENTITY, velocity).unwrap();
            let told = Query::impact(a, b, motion).predict(None);
            assert!(is_ordered(told), "{told:?}");
        }
    }
}
