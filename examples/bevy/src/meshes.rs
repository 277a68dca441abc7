//! Does a ship of Bevy's touch a rock? Its meshes and transforms go in, places come out as its vectors.
//!
//! `cargo run --manifest-path examples/bevy/Cargo.toml --features meshes --bin meshes`

mod bodies;

use std::error::Error;

use bevy_asset::RenderAssetUsages;
use bevy_math::{EulerRot, Quat, Vec3};
use bevy_mesh::{Indices, Mesh, Meshable, PrimitiveTopology};
use bevy_shape::Sphere;
use bevy_transform::components::{GlobalTransform, Transform};
use punctual::{Budget, Query, Tree, Verdict, Workspace};

/// A flat triangular ship with a fin, as Bevy draws it.
fn ship() -> Mesh {
    let positions = vec![
        [1.0f32, 0.0, 0.0],
        [-1.0, 0.0, 0.7],
        [-1.0, 0.0, -0.7],
        [-1.0, 0.5, 0.0],
    ];
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(Indices::U16(vec![0, 1, 2, 0, 1, 3, 0, 3, 2, 1, 2, 3]))
}

fn main() -> Result<(), Box<dyn Error>> {
    // Once for each mesh. A scale is no part of a pose; the rock is made large before.
    let rock = Mesh::from(Sphere::new(1.0).mesh().ico(4)?).scaled_by(Vec3::new(0.6, 0.4, 0.7));
    let (ship, rock) = (
        Tree::new(bodies::mesh(&ship())?),
        Tree::new(bodies::mesh(&rock)?),
    );
    let ship_in_world = GlobalTransform::from(
        Transform::from_xyz(20.0, 0.0, 5.0).with_rotation(Quat::from_rotation_y(0.3)),
    );
    let mut workspace = Workspace::new();
    for x in [21.0, 23.0] {
        let rock_in_world = Transform::from_xyz(x, 0.1, 4.7).with_rotation(Quat::from_euler(
            EulerRot::XYZ,
            0.1,
            0.2,
            0.8,
        ));
        let rock_in_ship = bodies::global_pose(&ship_in_world)?
            .inverse()?
            .compose(&bodies::pose(&rock_in_world)?)?;
        let outcome = Query::intersection(&ship, &rock, rock_in_ship)
            .run(&mut workspace, Budget::unlimited());
        match outcome.value {
            Verdict::Intersecting {
                witness: [of_ship, of_rock],
            } => {
                let corner = Vec3::from(
                    ship.mesh().triangle(of_ship as usize)[0]
                        .as_vec3()
                        .to_array(),
                );
                let place = ship_in_world.transform_point(corner);
                println!(
                    "x = {x}: triangle {of_ship} of the ship, a corner of it at {place}, meets triangle {of_rock} of the rock"
                );
            }
            Verdict::Separated => println!("x = {x}: they do not touch"),
            // Within is what a scene says of bodies with margins.
            Verdict::Within { .. } | Verdict::Contained { .. } | Verdict::Undecided => {
                println!("x = {x}: not known")
            }
        }
    }
    Ok(())
}
