//! What a distance proves for later frames: as long as B has not moved that far, it is known without a search that nothing meets.

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mode, PairMemory, Query, StopReason, Tree, Verdict, Workspace, shapes};

use crate::common::meshes::{at, ball, knot, placed};
use crate::common::random::{Drift, Family, Random, pose_about, soup};
use crate::distance::{ENOUGH, Question, Truth, answer, run_with_memory};
use crate::finished::scaled;

/// Small steps of a body beside another, with a distance query now and then; each answer beside that without a memory.
#[test]
fn a_clearance_never_hides_a_contact() {
    let mut random = Random::new(4);
    let mut workspace = Workspace::new();
    let (mut known, mut frames, mut met) = (0, 0, 0);
    for (i, family) in Family::ALL.into_iter().enumerate() {
        let [a, b] = [(); 2].map(|()| Tree::new(soup(family, 10, &mut random)));
        let (center, reach) = (family.center(), family.scale());
        for drift in [Drift::None, Drift::Shear] {
            let mut memory = PairMemory::new();
            let mut pose = pose_about(center, 3.0 * reach, drift, &mut random);
            for frame in 0..32 {
                if frame % 8 == 0 {
                    let budget = [ENOUGH, Budget::work(400)][frame / 8 % 2];
                    let query = Question::default().query(&a, &b, pose);
                    let _ = run_with_memory(&query, &mut workspace, &mut memory, budget);
                }
                let clearance = memory.clearance(&a, &b, &pose);
                let truth = Truth::new(&a, &b, &pose);
                let most = truth.distance() + truth.rounding();
                assert!(clearance <= most, "{family:?} {i}: {clearance}");
                for mode in [Mode::Any, Mode::All] {
                    let query = Query::intersection(&a, &b, pose).mode(mode);
                    let said = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
                    assert_eq!(said.value.meets(), answer(&query).value.meets());
                    if clearance > 0.0 {
                        let told = (said.value, said.stop);
                        assert_eq!(told, (Verdict::Separated, StopReason::Finished));
                        assert_eq!((said.stats.work, said.stats.bv_tests), (0, 0));
                        assert_eq!(query.certificate(&workspace).unwrap().upper_bound(), 0);
                    }
                }
                frames += 1;
                known += u32::from(clearance > 0.0);
                met += u32::from(truth.meet());
                let step = random.unit() * if random.below(4) == 0 { 0.2 } else { 0.005 };
                let axis = random.vector().normalize();
                let turn = DMat3::from_axis_angle(axis, 0.05 * random.signed());
                let arm = pose.translation() - center;
                pose = placed(turn * *pose.rotation(), turn * arm + center - step * arm);
            }
        }
    }
    println!("{known} of {frames} frames known, {met} met");
    assert!(known > 100 && met > 20, "{known} {frames} {met}");
}

/// Up to the last rounding: the cubes part by 1, and B comes closer by a little less than that, by just that, and by more.
#[test]
fn a_clearance_ends_where_contact_begins() {
    let cube = Tree::new(shapes::cuboid([0.5; 3], 1));
    let mut workspace = Workspace::new();
    for far in [0.0, 1e3, 1e9] {
        let b = Tree::new(scaled(cube.mesh(), 1.0, DVec3::new(far, 0.0, 0.0)));
        let place = |x: f64| at(x - far, 0.0, 0.0);
        let mut memory = PairMemory::new();
        let query = Question::EXACT.query(&cube, &b, place(2.0));
        let said = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
        let rounding = 1e-13 * far.max(1.0);
        assert!((said.value.low - 1.0).abs() < rounding, "{said:?}");
        let close = 1.0 + 2.0 * rounding;
        for (x, is_known) in [
            (close, true),
            (1.0, false),
            (0.9, false),
            (2.9, true),
            (3.0, false),
        ] {
            let known = memory.clearance(&cube, &b, &place(x)) > 0.0;
            assert_eq!(known, is_known, "{x} from {far}");
            let query = Query::intersection(&cube, &b, place(x));
            let said = run_with_memory(&query, &mut workspace, &mut memory.clone(), ENOUGH);
            assert_eq!(said.value == Verdict::Separated, x > 1.0, "{x} from {far}");
        }
    }
}

/// A refitted tree is another surface; so are the same trees the other way round.
#[test]
fn a_clearance_is_of_two_surfaces() {
    let (mut sphere, other) = (ball(2), ball(1));
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let pose = at(2.5, 0.0, 0.0);
    // Nothing is known before the first query.
    assert_eq!(memory.clearance(&sphere, &other, &pose), 0.0);
    let query = Question::EXACT.query(&sphere, &other, pose);
    let _ = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    assert!(memory.clearance(&sphere, &other, &pose) > 0.49);
    // A clone knows it too.
    assert!(memory.clone().clearance(&sphere, &other, &pose) > 0.49);
    assert_eq!(memory.clearance(&other, &sphere, &pose), 0.0);
    let vertices = (0..sphere.mesh().vertex_count()).map(|i| 2.0 * sphere.mesh().vertex(i));
    sphere.refit_f64(&vertices.collect::<Vec<_>>()).unwrap();
    assert_eq!(memory.clearance(&sphere, &other, &pose), 0.0);
    let query = Query::intersection(&sphere, &other, pose);
    assert!(
        run_with_memory(&query, &mut workspace, &mut memory, ENOUGH)
            .value
            .meets()
    );
}

/// A distance query begins with it: the lower bound from the first moment, and the answer to a limit below it.
#[test]
fn a_distance_begins_with_the_clearance() {
    let (a, b) = (knot(0.2, 32), ball(3));
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let ask = |x: f64| Question::EXACT.query(&a, &b, at(x, 0.0, 0.0));
    let whole = run_with_memory(&ask(5.0), &mut workspace, &mut memory, ENOUGH)
        .value
        .low;
    let nothing = Budget::work(0);
    let said = run_with_memory(&ask(4.9), &mut workspace, &mut memory.clone(), nothing);
    assert!(
        (said.value.low - (whole - 0.1)).abs() <= 1e-9,
        "{whole:?} {said:?}"
    );
    let near = Question::closer_than(whole - 0.2).query(&a, &b, at(4.9, 0.0, 0.0));
    let said = run_with_memory(&near, &mut workspace, &mut memory, nothing);
    let told = (said.value.closer, said.stop, said.stats.work);
    assert_eq!(told, (Some(false), StopReason::Finished, 0));
}
