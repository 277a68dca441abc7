//! Where does a box rest on a floor? A contact manifold of a few points.

use std::error::Error;

use punctual::contacts::Patches;
use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Budget, Pose, Query, Tree, Workspace, shapes};

fn main() -> Result<(), Box<dyn Error>> {
    let floor = Tree::new(shapes::cuboid(Vec3::new(5.0, 5.0, 0.5), 16));
    let block = Tree::new(shapes::cuboid(Vec3::splat(0.5), 6));
    let mut workspace = Workspace::new();
    let mut patches = Patches::new();

    for frame in 0..3 {
        // It stands a thousandth above the floor, and slides along x.
        let pose = Pose::new(
            DMat3::IDENTITY,
            DVec3::new(0.1 * f64::from(frame), 0.0, 1.001),
        )?;
        let query = Query::contacts(&floor, &block, pose).margin(0.01);
        let found = query.run(&mut workspace, Budget::work(1_000_000));
        let contacts = workspace.contacts();
        println!(
            "frame {frame}: {} contacts, the query {}",
            contacts.len(),
            found.stop
        );

        // Contacts that hang together are one patch; its id lasts from frame to frame.
        patches.update(&floor, &block, contacts);
        for patch in patches.as_slice() {
            println!("  patch {}, normal {:.2}", patch.id, patch.normal);
            for point in patches.points_of(patch) {
                println!("    {:.3}, {:.4} apart", point.points[0], point.distance);
            }
        }
    }
    Ok(())
}
