//! What the library lets `punctual-lab` and `punctual-cli` see of its inside.

use punctual::glam::{DMat3, DVec3};
use punctual::internals::{FrontierSummary, Random, Tracker, all_left, opened_pairs, pair_cost};
use punctual::intersection::Order;
use punctual::prediction::Quantiles;
use punctual::{Budget, Mesh, Pose, Query, Tree, Workspace, shapes};
use punctual_lab::regression::least_squares;

#[test]
fn the_sequence_is_splitmix64() {
    // The reference implementation's first numbers for seed 1234567.
    let mut random = Random::new(1_234_567);
    assert_eq!(
        [random.bits(), random.bits()],
        [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]
    );
}

#[test]
fn fractions_are_uniform() {
    let mut random = Random::new(1);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..100_000 {
        let x = random.between(-1.0, 1.0);
        assert!((-1.0..1.0).contains(&x));
        sum += x;
        squares += x * x;
    }
    assert!((sum / 1e5).abs() < 0.01 && (squares / 1e5 - 1.0 / 3.0).abs() < 0.01);
}

#[test]
fn the_plane_through_points_is_found() {
    const TRUE: [f64; 3] = [0.5, -1.0, 2.0];
    let mut random = Random::new(1);
    let x: Vec<_> = (0..9)
        .map(|_| [1.0, random.between(-2.0, 2.0), random.fraction()])
        .collect();
    let y: Vec<_> = x
        .iter()
        .map(|x| x.iter().zip(TRUE).map(|(x, w)| x * w).sum::<f64>())
        .collect();
    let w = least_squares(&x, &y, &[1.0; 9]);
    assert!(
        w.iter().zip(TRUE).all(|(w, e)| (w - e).abs() < 1e-6),
        "{w:?}"
    );
    // A point of no weight does not count; features may depend on one another.
    let x = [[1.0, 1.0], [2.0, 2.0], [5.0, 0.0]];
    let w = least_squares(&x, &[2.0, 4.0, 99.0], &[1.0, 1.0, 0.0]);
    assert!((w[0] + w[1] - 2.0).abs() < 1e-6, "{w:?}");
}

#[test]
fn the_pair_cost_by_hand() {
    assert_eq!(pair_cost([4.0, 64.0], 1.0), 108.0);
    assert_eq!(pair_cost([256.0, 256.0], 0.0625), 54.0);
    assert_eq!(pair_cost([1e9, 1e9], 0.0), 0.0);
}

/// A front with one open pair that costs this, after so many BV tests.
fn front(cost: f64, bv_tests: f64) -> FrontierSummary {
    let mut front = FrontierSummary::default();
    (front.node_pairs, front.cost, front.bv_tests) = (1.0, cost, bv_tests);
    front
}

#[test]
fn a_query_is_done_when_no_pair_waits() {
    let mut front = front(0.0, 5.0);
    assert!(!front.is_done());
    front.node_pairs = 0.0;
    assert!(front.is_done());
    assert_eq!(all_left(&front), Quantiles::exactly(0.0));
    front.triangle_pairs = 1.0;
    assert!(!front.is_done());
}

#[test]
fn a_tracker_tells_the_median_by_the_last_error_and_steps_by_what_came() {
    let model = Quantiles::exactly(1024.0);
    let mut tracker = Tracker::default();
    assert_eq!(tracker.corrected(model), model);
    // It may still take more.
    assert!(!tracker.learn(model, 512.0, false));
    assert!(tracker.learn(model, 2048.0, true));
    let Quantiles { p10, p50, p90 } = tracker.corrected(model);
    let log = |x: f64| (x / 1024.0).log2();
    assert!((log(p50) - 1.0).abs() < 1e-6, "{p50}");
    assert!(
        (log(p90) - 1.35).abs() < 1e-6 && (log(p10) - 0.15).abs() < 1e-6,
        "{p10} {p90}"
    );
    for _ in 0..100 {
        tracker.learn(model, 1e300, true);
    }
    assert!(tracker.corrected(model).p90 <= 1024.0 * (9.5_f64).exp2());
}

#[test]
fn every_order_opens_the_same_pairs() {
    let (a, b) = (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 32)),
        Tree::new(shapes::gear(9, 3)),
    );
    let mut workspace = Workspace::new();
    for x in [0.0, 0.7, 1.3, 9.0] {
        let pose = Pose::new(DMat3::from_rotation_x(x), DVec3::new(x, 0.1, 0.0)).unwrap();
        let opened = opened_pairs(&a, &b, &pose);
        for order in [Order::DepthFirst, Order::LowAlpha] {
            let query = Query::all_pairs(&a, &b, pose).order(order);
            let stats = query.run(&mut workspace, Budget::unlimited()).stats;
            assert_eq!(
                opened
                    .iter()
                    .map(|pair| u64::from(pair.bv_tests))
                    .sum::<u64>(),
                stats.bv_tests
            );
            let triangle_pairs: usize = opened.iter().map(|pair| pair.triangle_pairs.len()).sum();
            assert_eq!(triangle_pairs as u64, stats.primitive_tests);
        }
        assert!(
            opened
                .iter()
                .enumerate()
                .all(|(i, pair)| pair.parent < i.max(1))
        );
    }
    let empty = Tree::new(Mesh::new([[0.0f32; 3]], []).unwrap());
    assert!(opened_pairs(&a, &empty, &Pose::IDENTITY).is_empty());
}
