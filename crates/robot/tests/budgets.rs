//! What budgets decide: never fewer with more.

use std::sync::Arc;
use std::time::Duration;

use cpu_time::ThreadTime;
use punctual::clock::ManualClock;
use punctual::{Budget, Clock, Pose};
use punctual_robot::{Checker, Collision, Model, Shape, UrdfOptions};

/// A chain of links, each with a box, that turn about changing axes, among some balls.
fn chain(joints: usize) -> Checker {
    let link = |i: usize| {
        format!(
            r#"<link name="l{i}"><collision><origin xyz="0 0 .15"/><geometry><box size=".08 .06 .2"/></geometry></collision></link>"#
        )
    };
    let joint = |i: usize| {
        let axis = ["1 0 0", "0 1 0", "0 0 1"][i % 3];
        format!(
            r#"<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{}"/><origin xyz="0 0 .3"/><axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>"#,
            i + 1
        )
    };
    let text: String = (0..=joints)
        .map(link)
        .chain((0..joints).map(joint))
        .collect();
    // Tests run at the same time.
    let name = format!(
        "punctual-{}-{:?}.urdf",
        std::process::id(),
        std::thread::current().id()
    );
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, format!("<robot name=\"chain\">{text}</robot>")).unwrap();
    let model = Model::from_urdf(&file, &UrdfOptions::default()).unwrap();
    std::fs::remove_file(file).unwrap();
    let mut checker = Checker::new(Arc::new(model));
    for i in 0..6 {
        let turn = f64::from(i);
        let at = [0.6 * turn.cos(), 0.6 * turn.sin(), 0.3 * turn];
        let pose = Pose::new(punctual::glam::DMat3::IDENTITY, at).unwrap();
        checker
            .add("ball", pose, Shape::sphere(0.1).unwrap())
            .unwrap();
    }
    checker
}

/// Configurations from bent to nearly straight.
fn configurations(joints: usize) -> Vec<Vec<f64>> {
    let at = |i: usize, j: usize| ((i * 7 + j * 13) % 29) as f64 / 14.5 - 1.0;
    (0..24)
        .map(|i| {
            (0..joints)
                .map(|j| at(i, j) * (0.1 + 0.05 * i as f64))
                .collect()
        })
        .collect()
}

fn decided(fresh: &Checker, joints: usize, budget: Budget, clock: &dyn Clock) -> usize {
    // A copy, because it learns.
    let mut checker = fresh.clone();
    let mut is_decided = |q: &Vec<f64>| {
        let said = checker.collide(q, budget.clock(clock)).unwrap();
        said.value != Collision::Undecided
    };
    configurations(joints)
        .iter()
        .filter(|q| is_decided(q))
        .count()
}

#[test]
fn twice_the_time_never_leaves_more_configurations_undecided() {
    for joints in [7, 20, 50, 100] {
        let fresh = chain(joints);
        for reading in [20, 300, 1_000] {
            let counts: Vec<usize> = (0..14)
                .map(|i| {
                    let clock = ManualClock::ticking(Duration::from_nanos(reading));
                    let budget = Budget::time(Duration::from_nanos(1_000 << i));
                    decided(&fresh, joints, budget, &clock)
                })
                .collect();
            assert!(counts.is_sorted() && counts[13] == 24, "{joints}");
        }
        let counts: Vec<usize> = (0..20)
            .map(|i| decided(&fresh, joints, Budget::work(100 << i), &ManualClock::new()))
            .collect();
        assert!(counts.is_sorted() && counts[19] == 24, "{joints}");
    }
}

/// The time of this thread alone.
struct Own;

impl Clock for Own {
    fn now(&self) -> Duration {
        ThreadTime::now().as_duration()
    }
}

/// A hole in the budgets left all configurations undecided, whatever the machine.
#[test]
fn no_budget_decides_nothing_where_half_of_it_decides_half() {
    for joints in [7, 20, 50, 100] {
        let fresh = chain(joints);
        let counts: Vec<usize> = (0..14)
            .map(|i| {
                decided(
                    &fresh,
                    joints,
                    Budget::time(Duration::from_nanos(1_000 << i)),
                    &Own,
                )
            })
            .collect();
        for two in counts.windows(2) {
            assert!(two[1] + 4 >= two[0], "{joints} joints: {counts:?}");
        }
        assert_eq!(counts[13], 24, "{joints} joints: {counts:?}");
    }
}
