//! What a distance proves for later frames: as long as B has not moved that far, it is known without a search that nothing meets.

use punctual::glam::{DMat3, DVec3};
use punctual::{
    Budget, Mode, PairMemory, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes,
};

use crate::common::check;
use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::distance::{ENOUGH, Question, Truth, run_with_memory};
use crate::finished::{moved, scaled};

/// Small steps of a body beside another, with a distance query now and then; each answer beside that without a memory.
#[test]
fn a_clearance_never_hides_a_contact() {
    let mut random = Random::new(4);
    let (mut workspace, mut cold) = (Workspace::new(), Workspace::new());
    let (mut known, mut frames, mut met) = (0, 0, 0);
    for (i, family) in Family::ALL.into_iter().enumerate() {
        let [a, b] = [(); 2].map(|()| Tree::new(soup(family, 10, &mut random)));
        let reach = family.scale();
        for drift in [Drift::None, Drift::Shear] {
            let mut memory = PairMemory::new();
            let mut pose = pose_about(family.center(), 3.0 * reach, drift, &mut random);
            for frame in 0..32 {
                if frame % 8 == 0 {
                    let budget = if frame % 16 == 0 {
                        ENOUGH
                    } else {
                        Budget::work(400)
                    };
                    let said = Question::default().query(&a, &b, pose);
                    let _ = run_with_memory(&said, &mut workspace, &mut memory, budget);
                }
                let clearance = memory.clearance(&a, &b, &pose);
                let truth = Truth::new(&a, &b, &pose);
                assert!(
                    clearance <= truth.distance() + truth.rounding(),
                    "{family:?} {i}: {clearance}"
                );
                for mode in [Mode::Any, Mode::All] {
                    let query = Query::intersection(&a, &b, pose).mode(mode);
                    let said = check::run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
                    let truth = check::run(&query, &mut cold, ENOUGH);
                    assert_eq!(
                        said.value == Verdict::Separated,
                        truth.value == Verdict::Separated
                    );
                    if clearance > 0.0 {
                        assert_eq!(
                            (said.value, said.stop),
                            (Verdict::Separated, StopReason::Finished)
                        );
                        assert_eq!((said.stats.work, said.stats.bv_tests), (0, 0));
                        assert!(query.certificate(&workspace).unwrap().upper_bound() == 0);
                    }
                }
                frames += 1;
                known += u32::from(clearance > 0.0);
                met += u32::from(truth.meet());
                let step = random.unit() * if random.below(4) == 0 { 0.2 } else { 0.005 };
                let turn =
                    DMat3::from_axis_angle(random.vector().normalize(), 0.05 * random.signed());
                let about = family.center();
                let to = turn * (pose.translation() - about) + about
                    - step * (pose.translation() - about);
                pose = Pose::new(turn * *pose.rotation(), to).unwrap();
            }
        }
    }
    println!("{known} of {frames} frames known, {met} met");
    assert!(
        known > 100 && met > 20,
        "{known} of {frames} known, {met} met"
    );
}

/// Up to the last rounding: the cubes part by 1, and B comes closer by a little less than that, by just that, and by more.
#[test]
fn a_clearance_ends_where_contact_begins() {
    let cube = Tree::new(shapes::cuboid(punctual::glam::Vec3::splat(0.5), 1));
    let mut workspace = Workspace::new();
    for far in [0.0, 1e3, 1e9] {
        let b = Tree::new(scaled(cube.mesh(), 1.0, DVec3::new(far, 0.0, 0.0)));
        let at = |x: f64| moved(x - far, 0.0, 0.0);
        let mut memory = PairMemory::new();
        let said = run_with_memory(
            &Question::EXACT.query(&cube, &b, at(2.0)),
            &mut workspace,
            &mut memory,
            ENOUGH,
        );
        let rounding = 1e-13 * far.max(1.0);
        assert!((said.value.low - 1.0).abs() < rounding, "{said:?}");
        for (x, is_known) in [
            (1.0 + 2.0 * rounding, true),
            (1.0, false),
            (0.9, false),
            (2.9, true),
            (3.0, false),
        ] {
            let known = memory.clearance(&cube, &b, &at(x)) > 0.0;
            assert_eq!(known, is_known, "{x} from {far}");
            let said = check::run_with_memory(
                &Query::intersection(&cube, &b, at(x)),
                &mut workspace,
                &mut memory.clone(),
                ENOUGH,
            );
            assert_eq!(said.value == Verdict::Separated, x > 1.0, "{x} from {far}");
        }
    }
}

/// A refitted tree is another surface; so are the same trees the other way round.
#[test]
fn a_clearance_is_of_two_surfaces() {
    let mut sphere = Tree::new(shapes::icosphere(2));
    let other = Tree::new(shapes::icosphere(1));
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let pose = moved(2.5, 0.0, 0.0);
    assert_eq!(
        memory.clearance(&sphere, &other, &pose),
        0.0,
        "nothing is known before the first query"
    );
    let _ = run_with_memory(
        &Question::EXACT.query(&sphere, &other, pose),
        &mut workspace,
        &mut memory,
        ENOUGH,
    );
    assert!(memory.clearance(&sphere, &other, &pose) > 0.49);
    assert!(
        memory.clone().clearance(&sphere, &other, &pose) > 0.49,
        "a clone knows it too"
    );
    assert_eq!(memory.clearance(&other, &sphere, &pose), 0.0);
    let grown: Vec<DVec3> = (0..sphere.mesh().vertex_count())
        .map(|i| 2.0 * sphere.mesh().vertex(i))
        .collect();
    sphere.refit_f64(&grown).unwrap();
    assert_eq!(memory.clearance(&sphere, &other, &pose), 0.0);
    let query = Query::intersection(&sphere, &other, pose);
    let said = check::run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    assert!(
        matches!(said.value, Verdict::Intersecting { .. }),
        "{said:?}"
    );
}

/// A distance query begins with it: the lower bound from the first moment, and the answer to a limit below it.
#[test]
fn a_distance_begins_with_the_clearance() {
    let (a, b) = (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 32)),
        Tree::new(shapes::icosphere(3)),
    );
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let ask = |x: f64| Question::EXACT.query(&a, &b, moved(x, 0.0, 0.0));
    let whole = run_with_memory(&ask(5.0), &mut workspace, &mut memory, ENOUGH);
    let said = run_with_memory(
        &ask(4.9),
        &mut workspace,
        &mut memory.clone(),
        Budget::work(0),
    );
    assert!(
        whole.value.low - 0.1 - 1e-9 < said.value.low
            && said.value.low <= whole.value.low - 0.1 + 1e-9,
        "{whole:?} {said:?}"
    );
    let near = Question::closer_than(whole.value.low - 0.2).query(&a, &b, moved(4.9, 0.0, 0.0));
    let said = run_with_memory(&near, &mut workspace, &mut memory, Budget::work(0));
    assert_eq!(
        (said.value.closer, said.stop, said.stats.work),
        (Some(false), StopReason::Finished, 0),
        "{said:?}"
    );
}
