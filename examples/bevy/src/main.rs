//! Does a ship of Bevy's touch a rock? Bevy's vectors go in and come out, whichever version of glam they are of.
//!
//! `cargo run --manifest-path examples/bevy/Cargo.toml`

use std::error::Error;

use bevy_math::{DMat3, DVec3, Isometry3d, Mat3, Quat, Vec3};
use punctual::{Budget, Mesh, Pose, PoseError, Query, Tree, Verdict, Workspace, shapes};

/// Where an entity is and how it is turned: Bevy's `Transform` without its scale.
fn pose_of(isometry: Isometry3d) -> Result<Pose, PoseError> {
    Pose::from_quat(
        isometry.rotation.as_dquat(),
        isometry.translation.as_dvec3(),
    )
}

/// A flat triangular ship with a fin, from the vertices of a Bevy mesh.
fn ship() -> Result<Mesh, Box<dyn Error>> {
    let vertices = [
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(-1.0, 0.0, 0.7),
        Vec3::new(-1.0, 0.0, -0.7),
        Vec3::new(-1.0, 0.5, 0.0),
    ];
    Ok(Mesh::new(
        vertices,
        [[0, 1, 2], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (ship, rock) = (
        Tree::new(ship()?),
        Tree::new(shapes::cuboid(Vec3::new(0.5, 0.4, 0.6), 4)),
    );
    let ship_in_world = Isometry3d::new(Vec3::new(20.0, 0.0, 5.0), Quat::from_rotation_y(0.3));
    let mut workspace = Workspace::new();
    for x in [21.0, 23.0] {
        let rock_in_world = Isometry3d::new(Vec3::new(x, 0.1, 4.7), Quat::from_rotation_z(0.8));
        let rock_in_ship = pose_of(ship_in_world.inverse() * rock_in_world)?;
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
                let place = ship_in_world * corner;
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

    // Matrices, in double and in single precision, there and back.
    let (turn, place) = (
        Mat3::from_quat(ship_in_world.rotation),
        ship_in_world.translation,
    );
    let pose = Pose::new(turn.as_dmat3(), place.as_dvec3())?;
    assert_eq!(pose, Pose::from_f32(turn, place)?);
    assert_eq!(
        DMat3::from_cols_array(&pose.rotation().to_cols_array()),
        turn.as_dmat3()
    );
    assert_eq!(DVec3::from(pose.translation().to_array()), place.as_dvec3());
    Ok(())
}
