//! Which triangles of two meshes intersect? With more and more work, then in one go.

use std::error::Error;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mode, Pose, Query, StopReason, Tree, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let a = Tree::new(shapes::torus_knot(2, 3, 0.25, 96));
    let b = Tree::new(shapes::torus_knot(3, 4, 0.2, 96));
    let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(0.4);
    let b_in_a = Pose::new(turn, DVec3::new(0.9, 0.6, 0.3))?;
    let query = Query::intersection(&a, &b, b_in_a).mode(Mode::All);
    let mut workspace = Workspace::new();

    let slice = Budget::work(80_000);
    let mut outcome = query.run(&mut workspace, slice);
    while outcome.stop != StopReason::Finished {
        // What was found is proven, and so is how many pairs there can be at most.
        println!(
            "after {} units of work: {} pairs, at most {}",
            outcome.stats.work,
            outcome.stats.found,
            query.certificate(&workspace)?.upper_bound(),
        );
        outcome = query.resume(&mut workspace, slice)?;
    }
    println!(
        "after {} units of work: all {} pairs",
        outcome.stats.work, outcome.stats.found
    );
    println!("the first is {:?}", workspace.pairs().first());
    assert_eq!(query.run(&mut workspace, Budget::work(u64::MAX)), outcome);
    println!("in one go: the same, to the bit");
    Ok(())
}
