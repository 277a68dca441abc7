//! A memory changes the way to a distance, never the distance.

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, PairMemory, Pose, StopReason, Tree, Workspace, shapes};

use crate::common::meshes::{at, ball, knot, placed};
use crate::common::random::{Family, Random, soup};
use crate::distance::{ENOUGH, Question, Truth, answer, run_with_memory};

/// Past each other, in and out of contact, with a jump.
fn path() -> impl Iterator<Item = Pose> {
    (0..40).map(|step| {
        let at = 0.1 * f64::from(step - if step > 30 { 60 } else { 20 });
        placed(DMat3::from_rotation_z(0.1 * at), [at, 1.7, 0.2])
    })
}

/// Fresh, of the frame before, of another pair, starved of budget, and cut short.
#[test]
fn any_memory_ends_at_the_distance() {
    let (a, b) = (knot(0.2, 10), Tree::new(shapes::gear(7, 1)));
    let stranger = Tree::new(soup(Family::Uniform, 300, &mut Random::new(1)));
    let mut workspace = Workspace::new();
    let mut memories = [(); 4].map(|()| PairMemory::new());
    let (mut with, mut without) = (0, 0);
    for pose in path() {
        let mut truth = Truth::new(&a, &b, &pose);
        for asked in truth.questions() {
            let query = asked.query(&a, &b, pose);
            for memory in &mut memories {
                let said = run_with_memory(&query, &mut workspace, memory, ENOUGH);
                truth.assert_complete(&asked, &said);
                with += said.stats.work;
                without += answer(&query).stats.work;
            }
            let [_, foreign, starved, turned] = &mut memories;
            let elsewhere = asked.query(&stranger, &b, pose);
            let _ = run_with_memory(&elsewhere, &mut workspace, foreign, Budget::work(2_000));
            for budget in [0, 1, 300, 3_000].map(Budget::work) {
                let said = run_with_memory(&query, &mut workspace, starved, budget);
                truth.assert_sound(&asked, &said);
            }
            // The same trees the other way round are another pair.
            let back = asked.query(&b, &a, pose.inverse().unwrap());
            let _ = run_with_memory(&back, &mut workspace, turned, Budget::work(5_000));
        }
    }
    println!("{with} with, {without} without");
    assert!(with < without, "{with} with, {without} without");
}

/// What was closest gives an upper bound before any other step, whether it still is closest or not.
#[test]
fn the_last_closest_triangles_are_tested_first() {
    let sphere = ball(2);
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    let query = Question::EXACT.query(&sphere, &sphere, at(3.0, 0.0, 0.0));
    let first = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    // On the other side, where the closest triangles are now the farthest.
    let pose = at(-3.0, 0.1, 0.0);
    let mut truth = Truth::new(&sphere, &sphere, &pose);
    let query = Question::EXACT.query(&sphere, &sphere, pose);
    let said = run_with_memory(&query, &mut workspace, &mut memory.clone(), Budget::work(1));
    truth.assert_sound(&Question::EXACT, &said);
    let [first, now] = [first, said].map(|said| said.value.nearest.unwrap().triangles);
    assert_eq!(first, now);
    assert!(said.value.high > 3.0);
    let said = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
    truth.assert_complete(&Question::EXACT, &said);
    // Closer than it asks: one step is enough.
    let near = Question::closer_than(1.1 * truth.distance()).query(&sphere, &sphere, pose);
    let said = run_with_memory(&near, &mut workspace, &mut memory, Budget::work(1));
    assert_eq!(
        (said.value.closer, said.stop),
        (Some(true), StopReason::Finished)
    );
}

/// A refitted tree keeps its memory; the triangle that was closest may lie anywhere by then.
#[test]
fn refitted_trees() {
    let mut random = Random::new(8);
    let mut tree = Tree::new(shapes::torus(1.0, 0.3, 12));
    let (rest, other) = (tree.mesh().clone(), ball(1));
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());
    for frame in 0..30 {
        let pose = at(2.0, 0.1 * f64::from(frame), 0.5);
        let mut truth = Truth::new(&tree, &other, &pose);
        for asked in [Question::EXACT, Question::default()] {
            let query = asked.query(&tree, &other, pose);
            let said = run_with_memory(&query, &mut workspace, &mut memory, ENOUGH);
            truth.assert_complete(&asked, &said);
        }
        let wild = if frame % 10 == 9 { 5.0 } else { 0.05 };
        let vertices = (0..rest.vertex_count()).map(|i| rest.vertex(i) + wild * random.vector());
        tree.refit_f64(&vertices.collect::<Vec<DVec3>>()).unwrap();
    }
}
