//! Calls that have seen as many intervals and pairs before touch no allocator.

#[path = "../../../tests/common/allocations.rs"]
mod allocations;

use allocations::allocator_calls;
use punctual::glam::DMat3;
use punctual::{Budget, Pose, StopReason, shapes};
use punctual_robot::{
    Checker, ClearanceOptions, Description, EdgeOptions, Horizon, Joint, JointKind, Link, Model,
    NearPairs, Shape, Track, Trajectory,
};

fn at(x: f64, z: f64) -> Pose {
    Pose::new(DMat3::IDENTITY, [x, 0.0, z]).unwrap()
}

/// An arm of three turning links among rings.
fn checker() -> Checker {
    let name = |i: usize| format!("link{i}");
    let bar = Shape::cuboid([0.1, 0.1, 0.8]).unwrap();
    let link = |i: usize| Link {
        name: name(i),
        shapes: vec![(at(0.0, 0.5), bar.clone())],
    };
    let joint = |i: usize| Joint {
        name: format!("joint{i}"),
        kind: JointKind::Revolute,
        parent: name(i),
        child: name(i + 1),
        origin: at(0.0, 1.0),
        axis: [0.3, 1.0, 0.2 * i as f64],
        limits: None,
        mimic: None,
    };
    let robot = Description {
        links: (0..4).map(link).collect(),
        joints: (0..3).map(joint).collect(),
        allows_neighbours: true,
        ..Description::default()
    };
    let mut checker = Checker::new(Model::new(&robot).unwrap().into());
    for (i, x) in [-1.4, 0.9, 1.7].into_iter().enumerate() {
        let ring = Shape::mesh(shapes::torus(0.4, 0.1, 24));
        checker
            .add(&format!("ring{i}"), at(x, 2.0 - x), ring)
            .unwrap();
    }
    checker
}

fn ask(checker: &mut Checker, horizon: &mut Horizon, plan: &mut Trajectory, near: &mut NearPairs) {
    for i in 0..60 {
        let angle = |k: f64| (f64::from(i) * k).sin();
        let from = [angle(1.1), angle(2.3), angle(3.7)];
        let to = [angle(4.9), angle(5.3), angle(6.1)];
        let ring = checker.find("ring1").unwrap();
        checker.move_to(ring, at(from[0], 1.1)).unwrap();
        let track = Track::velocity(&at(from[1], 1.5), from, to).unwrap();
        checker
            .move_along(checker.find("ring2").unwrap(), track)
            .unwrap();
        for budget in [Budget::unlimited(), Budget::work(900)] {
            let _ = checker.collide(&from, budget).unwrap();
            let _ = checker
                .clearance(&from, &ClearanceOptions::default(), budget)
                .unwrap();
            let _ = checker.horizon(&from, &to, 0.4, budget).unwrap();
            let knots = [
                from[0], from[1], from[2], to[0], to[1], to[2], 0.0, 0.0, 0.0,
            ];
            let _ = checker.path(&knots, &EdgeOptions::any(), budget).unwrap();
            let options = ClearanceOptions::default();
            let _ = checker
                .near_pairs(&from, 0.3, &options, budget, near)
                .unwrap();
            plan.clear();
            plan.push(0.4, &[&from, &to]).unwrap();
            let _ = horizon.step(checker, Some(plan), budget).unwrap();
            let _ = horizon.step(checker, None, budget).unwrap();
            for options in [EdgeOptions::any(), EdgeOptions::first()] {
                let mut edge = checker.edge(&from, &to, &options, budget).unwrap();
                while edge.stop != StopReason::Finished {
                    edge = checker.resume_edge(Budget::work(5_000)).unwrap();
                }
            }
        }
    }
}

#[test]
fn warm_calls_do_not_allocate() {
    let (mut checker, mut plan) = (checker(), Trajectory::default());
    let mut horizon = Horizon::new(0.001, 0.1).unwrap();
    let mut near = NearPairs::default();
    ask(&mut checker, &mut horizon, &mut plan, &mut near);
    let mut again = || ask(&mut checker, &mut horizon, &mut plan, &mut near);
    assert_eq!(allocator_calls(&mut again), 0);
}
