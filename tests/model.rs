//! What the model promises of a query: before it, when it is stopped, and at its end.

mod common;

use std::time::Duration;

use common::ask::{answer, run_in_pieces};
use common::random::{Drift, Family, Random, pose_about, soup};
use punctual::clock::ManualClock;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::Intersection;
use punctual::prediction::{CostModel, Counts, DEFAULT_PRIOR, Quantiles};
use punctual::{Answer, Budget, Mode, PairMemory, Pose, Query, Tree, Verdict, Workspace, shapes};

fn trees() -> [Tree; 2] {
    [shapes::icosphere(4), shapes::torus(1.0, 0.3, 64)].map(Tree::new)
}

fn run(
    query: &Query<Intersection>,
    workspace: &mut Workspace,
    memory: Option<&mut PairMemory>,
    budget: Budget,
) -> Answer<Verdict> {
    query
        .with_memory(memory)
        .run(workspace, budget.clock(&ManualClock::new()))
}

fn along_x(x: f64) -> Pose {
    Pose::new(DMat3::from_rotation_z(0.7), DVec3::new(x, 0.1, 0.2)).unwrap()
}

/// Poses from far inside to far outside.
fn poses() -> impl Iterator<Item = Pose> {
    (0..40).map(|i| along_x(0.07 * f64::from(i)))
}

#[track_caller]
fn assert_ordered(q: Quantiles) {
    assert!(
        q.p10 >= 0.0 && q.p10 <= q.p50 && q.p50 <= q.p90 && q.p90.is_finite(),
        "{q:?}"
    );
}

#[test]
fn quantiles_are_in_order_and_the_same_each_time() {
    let [a, b] = trees();
    for mode in [Mode::Any, Mode::All] {
        for pose in poses() {
            let query = Query::intersection(&a, &b, pose).mode(mode);
            let prediction = query.predict(None);
            assert_ordered(prediction.bv_tests);
            assert_ordered(prediction.triangle_tests);
            assert_ordered(prediction.work);
            assert_ordered(prediction.time(&CostModel::default()));
            assert_eq!(prediction, query.predict(None));
            // A memory that knows nothing.
            assert_eq!(prediction, query.predict(Some(&PairMemory::new())));
        }
    }
}

#[test]
fn predictions_of_shapes_that_were_not_fitted_are_about_right() {
    let [a, b] = trees();
    let (mut errors, mut covered) = (Vec::new(), 0);
    for pose in poses() {
        let query = Query::all_pairs(&a, &b, pose);
        let predicted = query.predict(None).bv_tests;
        let actual = answer(&query).stats.bv_tests as f64;
        errors.push((predicted.p50 / actual).log2().abs());
        covered += usize::from(actual <= predicted.p90 + 0.5);
    }
    errors.sort_unstable_by(f64::total_cmp);
    assert!(errors[20] < 1.0 && errors[36] < 3.0, "{errors:?}");
    assert!(covered >= 32, "{covered} of 40");
}

#[test]
fn boxes_that_do_not_meet_cost_one_test() {
    let [a, b] = trees();
    let pose = along_x(50.0);
    for mode in [Mode::Any, Mode::All] {
        let query = Query::intersection(&a, &b, pose).mode(mode);
        let tests = query.predict(None).bv_tests;
        assert!((0.5..2.0).contains(&tests.p50), "{tests:?}");
    }
    let empty = Tree::new(soup(Family::Uniform, 0, &mut Random::new(0)));
    let query = Query::intersection(&a, &empty, pose);
    assert_eq!(query.predict(None).bv_tests, Quantiles::exactly(0.0));
    let mut workspace = Workspace::new();
    let said = run(&query, &mut workspace, None, Budget::work(0));
    assert_eq!(said.value, Verdict::Separated);
    assert_eq!(query.estimate(&workspace, None).unwrap().probability, 0.0);
}

#[test]
fn decided_queries_have_a_probability_of_zero_or_one() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    for mode in [Mode::Any, Mode::All] {
        for pose in poses() {
            let query = Query::intersection(&a, &b, pose).mode(mode).prior(0.3);
            let outcome = run(&query, &mut workspace, None, Budget::unlimited());
            let estimate = query.estimate(&workspace, None).unwrap();
            let met = outcome.value != Verdict::Separated;
            assert_eq!(estimate.probability, f64::from(u8::from(met)));
            assert_eq!(estimate.recall, 1.0);
            assert_eq!(estimate.remaining.bv_tests.p90, 0.0);
        }
    }
}

#[test]
fn undecided_queries_have_a_probability_below_one_and_work_left() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    let (mut undecided, mut told_apart) = (0, 0);
    for mode in [Mode::Any, Mode::All] {
        for pose in poses() {
            for budget in [0, 300, 1000, 3000] {
                let query = Query::intersection(&a, &b, pose).mode(mode);
                let outcome = run(&query, &mut workspace, None, Budget::work(budget));
                let estimate = query.estimate(&workspace, None).unwrap();
                assert_ordered(estimate.remaining.bv_tests);
                assert!((0.0..=1.0).contains(&estimate.recall));
                if outcome.value == Verdict::Undecided {
                    undecided += 1;
                    assert!((0.0..1.0).contains(&estimate.probability), "{estimate:?}");
                    // Where a look at the front finds nothing that may meet, all that there is was found.
                    assert_eq!(
                        estimate.recall,
                        f64::from(u8::from(estimate.probability == 0.0))
                    );
                    told_apart += u32::from(estimate.probability == 0.0);
                    assert!(estimate.remaining.bv_tests.p90 > 0.0 || workspace.pairs().is_empty());
                }
                // The same each time.
                assert_eq!(query.estimate(&workspace, None), Ok(estimate));
            }
        }
    }
    assert!(
        undecided > 50 && (1..undecided).contains(&told_apart),
        "{undecided} {told_apart}"
    );
}

#[test]
fn the_probability_rises_with_the_prior() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    let query = Query::intersection(&a, &b, along_x(1.9));
    let outcome = run(&query, &mut workspace, None, Budget::work(500));
    assert_eq!(outcome.value, Verdict::Undecided);
    let told = |query: Query<Intersection>| query.estimate(&workspace, None).unwrap().probability;
    let at = |prior: f64| told(query.prior(prior));
    let rising = [0.0, 1e-6, 0.1, 0.5, 0.9, 1.0].map(at);
    assert!(rising.windows(2).all(|two| two[0] < two[1]), "{rising:?}");
    assert_eq!([rising[0], rising[5]], [0.0, 1.0]);
    assert_eq!(at(DEFAULT_PRIOR), told(query));
    // A prior beyond its range counts as its end.
    assert_eq!([at(-3.0), at(7.0)], [0.0, 1.0]);
}

#[test]
fn a_memory_makes_predictions_of_a_motion_better() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    let mut memory = PairMemory::new();
    let mut errors = [0.0, 0.0];
    for i in 0..60 {
        let query = Query::all_pairs(&a, &b, along_x(1.0 + 0.002 * f64::from(i)));
        let predicted = [query.predict(None), query.predict(Some(&memory))];
        let (known, free) = (Some(&mut memory), Budget::unlimited());
        let actual = run(&query, &mut workspace, known, free).stats.bv_tests as f64;
        for (error, predicted) in errors.iter_mut().zip(predicted) {
            *error += (predicted.bv_tests.p50 / actual).log2().abs();
        }
    }
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
}

#[test]
fn the_last_verdict_counts() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    let told = [0.5, 3.0].map(|x| {
        let mut memory = PairMemory::new();
        let before = Query::intersection(&a, &b, along_x(x));
        let _ = run(
            &before,
            &mut workspace,
            Some(&mut memory),
            Budget::unlimited(),
        );
        let query = Query::intersection(&a, &b, along_x(1.95));
        let outcome = run(&query, &mut workspace, None, Budget::work(300));
        assert_eq!(outcome.value, Verdict::Undecided);
        let estimate = query.estimate(&workspace, Some(&memory));
        estimate.unwrap().probability
    });
    assert!(told[0] > told[1] + 0.1, "{} {}", told[0], told[1]);
}

#[test]
fn an_estimate_wants_the_run_it_is_of() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    let query = Query::intersection(&a, &b, along_x(1.0));
    assert!(query.estimate(&workspace, None).is_err());
    let _ = run(&query, &mut workspace, None, Budget::work(100));
    assert!(query.estimate(&workspace, None).is_ok());
    assert!(query.mode(Mode::All).estimate(&workspace, None).is_err());
}

#[test]
fn the_work_left_shrinks_to_zero() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    let query = Query::all_pairs(&a, &b, along_x(0.4));
    let total = answer(&query).stats;
    let (mut errors, mut step) = (Vec::new(), 0);
    let pieces = || std::mem::replace(&mut step, total.work / 10);
    let _ = run_in_pieces(&query, &mut workspace, pieces, |said, held| {
        let left = query.estimate(held, None).unwrap().remaining.bv_tests.p50;
        let share = (said.stats.bv_tests as f64 + left) / total.bv_tests as f64;
        errors.push((share.log2().abs(), left));
    });
    assert!(errors.len() >= 9, "{errors:?}");
    assert!(errors[1].0 < 1.0 && errors[5].0 < 0.5, "{errors:?}");
    assert!(errors[errors.len() - 1].1 < errors[0].1);
}

#[test]
fn time_budgets_teach_the_costs() {
    let [a, b] = trees();
    let mut workspace = Workspace::new();
    assert_eq!(workspace.cost_model(), CostModel::default());
    let slow = CostModel::default().scaled(10.0);
    workspace.set_cost_model(slow);
    // Every look at this clock takes a nanosecond: a machine that is far faster.
    let clock = ManualClock::ticking(Duration::from_nanos(1));
    let query = Query::all_pairs(&a, &b, along_x(0.4));
    let predicted = query.predict(None);
    let second = Budget::time(Duration::from_secs(1));
    for _ in 0..10 {
        let _ = query.run(&mut workspace, second.clock(&clock));
    }
    let learned = workspace.cost_model();
    assert!(learned.bv_test < 0.5 * slow.bv_test);
    assert!(predicted.time(&learned).p50 < predicted.time(&slow).p50);
    let _ = query.run(&mut workspace, Budget::unlimited().clock(&clock));
    // Only budgets of time are measured.
    assert_eq!(workspace.cost_model(), learned);
}

/// Generous time: depth-first, no queue. Too little: the queue. Either way the answer is the same.
#[test]
fn the_time_budget_decides_whether_pairs_are_queued() {
    let [a, b] = [shapes::icosphere(6), shapes::torus(1.0, 0.3, 256)].map(Tree::new);
    let query = Query::all_pairs(&a, &b, along_x(0.4));
    let mut workspace = Workspace::new();
    let peaks = [Duration::from_secs(100), Duration::from_nanos(100)].map(|limit| {
        let stats = run(&query, &mut workspace, None, Budget::time(limit)).stats;
        (stats.queue_peak > 0, stats.found)
    });
    assert_eq!(peaks[0], (false, peaks[1].1));
    assert!(peaks[1].0);
}

/// The costs that a workspace was given count from its first query on.
#[test]
fn given_costs_decide_whether_the_first_query_is_queued() {
    let [a, b] = [shapes::icosphere(6), shapes::torus(1.0, 0.3, 256)].map(Tree::new);
    let query = Query::all_pairs(&a, &b, along_x(0.4));
    let queued = [1.0, 1e9].map(|factor| {
        let mut workspace = Workspace::new();
        workspace.set_cost_model(CostModel::default().scaled(factor));
        let limit = Budget::time(Duration::from_secs(100));
        run(&query, &mut workspace, None, limit).stats.queue_peak > 0
    });
    assert_eq!(queued, [false, true]);
}

#[test]
fn measured_costs_are_positive() {
    #[cfg(feature = "std")]
    {
        let costs = CostModel::measure();
        let all = [
            costs.bv_test,
            costs.triangle_test,
            costs.box_update,
            costs.setup,
        ];
        assert!(all.iter().all(|&cost| cost > 0.0 && cost < 1e5), "{all:?}");
    }
    assert_eq!(
        CostModel::measure_with(&ManualClock::new()),
        CostModel::default(),
        "a clock that stands still"
    );
}

/// No pose and no stop makes a number that is none.
#[test]
fn random_queries_give_numbers() {
    let mut random = Random::new(5);
    let mut workspace = Workspace::with_capacity(8, 64);
    let tiny = Tree::new(shapes::cuboid(punctual::glam::Vec3::splat(1e-6), 2));
    let large = Tree::new(shapes::height_field(40, 1));
    for _ in 0..300 {
        let pose = pose_about(DVec3::ZERO, 1.5, Drift::None, &mut random);
        for (a, b) in [
            (&large, &large),
            (&tiny, &large),
            (&large, &tiny),
            (&tiny, &tiny),
        ] {
            let query = Query::all_pairs(a, b, pose);
            assert_ordered(query.predict(None).bv_tests);
            let budget = Budget::work(random.below(3000) as u64);
            let _ = run(&query, &mut workspace, None, budget);
            let estimate = query.estimate(&workspace, None).unwrap();
            assert_ordered(estimate.remaining.work);
            let shares = [estimate.probability, estimate.recall];
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)));
        }
    }
}

#[test]
fn every_count_has_its_own_cost() {
    let costs = CostModel::new([2.0, 30.0, 500.0, 7000.0]);
    let counts = Counts {
        bv_tests: 1.5,
        triangle_tests: 2.0,
        box_updates: 3.0,
    };
    assert_eq!(costs.time(&Counts::default()), 7000.0);
    assert_eq!(costs.time(&counts), 3.0 + 60.0 + 1500.0 + 7000.0);
}

/// At .36 ns a unit, and 61 ns to set up a query.
#[test]
fn the_default_costs_are_the_weights_of_work() {
    let counts = Counts {
        bv_tests: 1000.0,
        triangle_tests: 20.0,
        box_updates: 30.0,
    };
    let time = CostModel::default().time(&counts);
    assert!((time - 0.36 * counts.work() - 61.0).abs() < 1e-9 * time);
}
