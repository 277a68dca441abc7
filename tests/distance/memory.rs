//! A memory changes the way to a distance, never the distance.

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, PairMemory, Pose, StopReason, Tree, Workspace, shapes};

use crate::common::random::{Family, Random, soup};
use crate::distance::{ENOUGH, Question, Truth, run, run_with_memory};
use crate::finished::moved;

/// Past each other, in and out of contact, with a jump.
fn path() -> impl Iterator<Item = Pose> {
    (0..40).map(|step| {
        let at = 0.1 * f64::from(step - if step > 30 { 60 } else { 20 });
        Pose::new(DMat3::from_rotation_z(0.1 * at), DVec3::new(at, 1.7, 0.2)).unwrap()
    })
}

/// Fresh, of the frame before, of another pair, starved of budget, and cut short.
#[test]
fn any_memory_ends_at_the_distance() {
    let (a, b) = (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 10)),
        Tree::new(shapes::gear(7, 1)),
    );
    let stranger = Tree::new(soup(Family::Uniform, 300, &mut Random::new(1)));
    let mut workspace = Workspace::new();
    let mut memories = [(); 4].map(|()| PairMemory::new());
    let (mut with, mut without) = (0, 0);
    for pose in path() {
        let mut truth = Truth::new(&a, &b, &pose);
        for asked in truth.questions() {
            let query = asked.query(&a, &b, pose);
            let [known, foreign, starved, turned] = &mut memories;
            let said = run_with_memory(&query, &mut workspace, known, ENOUGH);
            truth.assert_complete(&asked, &said);
            with += said.stats.work;
            without += run(&query, &mut workspace, ENOUGH).stats.work;
            truth.assert_complete(
                &asked,
                &run_with_memory(&query, &mut workspace, foreign, ENOUGH),
            );
            let elsewhere = asked.query(&stranger, &b, pose);
            let _ = run_with_memory(&elsewhere, &mut workspace, foreign, Budget::work(2_000));
            for budget in [0, 1, 300, 3_000].map(Budget::work) {
                truth.assert_sound(
                    &asked,
                    &run_with_memory(&query, &mut workspace, starved, budget),
                );
            }
            truth.assert_complete(
                &asked,
                &run_with_memory(&query, &mut workspace, starved, ENOUGH),
            );
            // The same trees the other way round are another pair.
            let back = asked.query(&b, &a, pose.inverse().unwrap());
            let _ = run_with_memory(&back, &mut workspace, turned, Budget::work(5_000));
            truth.assert_complete(
                &asked,
                &run_with_memory(&query, &mut workspace, turned, ENOUGH),
            );
        }
    }
    println!("{with} with, {without} without");
    assert!(with < without, "{with} with, {without} without");
}

/// What was closest gives an upper bound before any other step, whether it still is closest or not.
#[test]
fn what_was_closest_is_looked_at_first() {
    let sphere = Tree::new(shapes::icosphere(2));
    let mut workspace = Workspace::new();
    let mut memory = PairMemory::new();
    let first = run_with_memory(
        &Question::EXACT.query(&sphere, &sphere, moved(3.0, 0.0, 0.0)),
        &mut workspace,
        &mut memory,
        ENOUGH,
    );
    // On the other side, where the closest triangles are now the farthest.
    let pose = moved(-3.0, 0.1, 0.0);
    let mut truth = Truth::new(&sphere, &sphere, &pose);
    let query = Question::EXACT.query(&sphere, &sphere, pose);
    let said = run_with_memory(&query, &mut workspace, &mut memory.clone(), Budget::work(1));
    truth.assert_sound(&Question::EXACT, &said);
    assert_eq!(
        said.value.nearest.unwrap().triangles,
        first.value.nearest.unwrap().triangles
    );
    assert!(said.value.high > 3.0);
    truth.assert_complete(
        &Question::EXACT,
        &run_with_memory(&query, &mut workspace, &mut memory, ENOUGH),
    );
    // Closer than it asks: one step is enough.
    let near = Question::closer_than(1.1 * truth.distance());
    let said = run_with_memory(
        &near.query(&sphere, &sphere, pose),
        &mut workspace,
        &mut memory,
        Budget::work(1),
    );
    assert_eq!(
        (said.value.closer, said.stop),
        (Some(true), StopReason::Finished),
        "{said:?}"
    );
}

/// A refitted tree keeps its memory; the triangle that was closest may lie anywhere by then.
#[test]
fn refitted_trees() {
    let mut random = Random::new(8);
    let mut tree = Tree::new(shapes::torus(1.0, 0.3, 12));
    let other = Tree::new(shapes::icosphere(1));
    let rest: Vec<DVec3> = (0..tree.mesh().vertex_count())
        .map(|i| tree.mesh().vertex(i))
        .collect();
    let mut workspace = Workspace::new();
    let mut memory = PairMemory::new();
    for frame in 0..30 {
        let pose = moved(2.0, 0.1 * f64::from(frame), 0.5);
        let mut truth = Truth::new(&tree, &other, &pose);
        for asked in [Question::EXACT, Question::default()] {
            let said = run_with_memory(
                &asked.query(&tree, &other, pose),
                &mut workspace,
                &mut memory,
                ENOUGH,
            );
            truth.assert_complete(&asked, &said);
        }
        let wild = if frame % 10 == 9 { 5.0 } else { 0.05 };
        let moved: Vec<DVec3> = rest
            .iter()
            .map(|vertex| *vertex + wild * random.vector())
            .collect();
        tree.refit_f64(&moved).unwrap();
    }
}
