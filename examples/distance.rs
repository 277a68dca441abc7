//! How far apart are two meshes? Proven bounds, with less and with more work.

use std::error::Error;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let part = Tree::new(shapes::gear(17, 8));
    let tool = Tree::new(shapes::torus_knot(2, 3, 0.2, 128));
    let tool_in_part = Pose::new(DMat3::from_rotation_x(0.4), DVec3::new(0.3, 0.2, 2.0))?;
    let query = Query::distance(&part, &tool, tool_in_part);
    let mut workspace = Workspace::new();

    for work in [1_000, 5_000, 20_000, 1_000_000] {
        let found = query.run(&mut workspace, Budget::work(work));
        println!(
            "{work:>9} units of work: {:.5} to {:.5}",
            found.value.low, found.value.high
        );
        if let Some(nearest) = found.value.nearest {
            let [on_part, on_tool] = nearest.points;
            println!("{:>10} nearest points {on_part:.3} and {on_tool:.3}", "");
        }
    }

    // Only a limit? That takes less.
    for limit in [0.5, 1.0] {
        let near = query
            .closer_than(limit)
            .run(&mut workspace, Budget::unlimited());
        println!(
            "closer than {limit}: {:?}, {} units of work",
            near.value.closer, near.stats.work
        );
    }
    Ok(())
}
