//! Where does a box rest on a floor? A contact manifold of a few points.

use std::error::Error;

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Budget, PairMemory, Pose, Query, Tree, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let floor = Tree::new(shapes::cuboid(Vec3::new(5.0, 5.0, 0.5), 16));
    let block = Tree::new(shapes::cuboid(Vec3::splat(0.5), 6));
    let (mut workspace, mut memory) = (Workspace::new(), PairMemory::new());

    for frame in 0..3 {
        // It stands a thousandth above the floor, and slides along x.
        let pose = Pose::new(
            DMat3::IDENTITY,
            DVec3::new(0.1 * f64::from(frame), 0.0, 1.001),
        )?;
        let query = Query::manifolds(&floor, &block, pose).skin(0.01);
        let query = query.with_memory(&mut memory);
        let found = query.run(&mut workspace, Budget::work(1_000_000));
        println!("frame {frame}: the query {}", found.stop);

        // Hundreds of pairs of triangles, one manifold; its id lasts from frame to frame.
        for manifold in workspace.manifolds() {
            println!("  manifold {}, normal {:.2}", manifold.id, manifold.normal);
            for point in manifold.points() {
                println!("    {:.3}, {:.4} apart", point.points[0], point.distance);
            }
        }
    }
    Ok(())
}
