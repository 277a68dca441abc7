//! When does a bullet hit a plate that is thinner than the way of a frame? (CCD)

use std::error::Error;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Motion, Pose, Query, Tree, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let plate = Tree::new(shapes::cuboid([1.0, 1.0, 0.001], 16));
    let bullet = Tree::new(shapes::icosphere(2));
    let mut workspace = Workspace::new();

    let start = Pose::new(DMat3::IDENTITY, DVec3::new(0.3, 0.2, 80.0))?;
    for (name, way) in [("through the plate", -160.0), ("and back", 160.0)] {
        // Time runs from 0 to 1, the frame.
        let motion = Motion::straight(start, [0.0, 0.0, way])?;
        let query = Query::impact(&plate, &bullet, motion);
        for work in [500, 1_000_000] {
            let found = query.run(&mut workspace, Budget::work(work));
            // Both are proven, also where the budget ended the query.
            println!(
                "{name}, {work} units of work: free until {:.6}, touching at {:?}",
                found.value.lower, found.value.upper
            );
            if let Some(time) = found.value.upper {
                println!("  it is then at {:.4}", motion.pose(time).translation());
            }
        }
    }
    Ok(())
}
