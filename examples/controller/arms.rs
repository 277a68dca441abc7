//! Two arms over uneven ground: six links each, of built-in shapes, on paths that cross.

use std::error::Error;
use std::sync::Arc;

use punctual::glam::{DMat3, DVec3, Vec3};
use punctual::{Mesh, Pose, PoseError, Tree, shapes};
use punctual_scene::{Body, BodyId, Filter, Scene};

const LINKS: usize = 6;

/// Distance of the joints, metres.
const REACH: f64 = 0.17;

/// A scene with the links of both arms.
pub struct Arms {
    pub scene: Scene,
    links: [[BodyId; LINKS]; 2],
}

/// A mesh with each axis scaled.
fn scaled(mesh: &Mesh, scale: Vec3) -> Result<Tree, Box<dyn Error>> {
    let vertices = (0..mesh.vertex_count()).map(|i| mesh.vertex(i).as_vec3() * scale);
    Ok(Tree::new(Mesh::new(
        vertices,
        mesh.triangles().iter().copied(),
    )?))
}

impl Arms {
    /// Links of 3,200 to 20,480 triangles. The links of one arm are not compared.
    pub fn new() -> Result<Self, Box<dyn Error>> {
        let joint = Arc::new(scaled(&shapes::gear(25, 2), Vec3::new(0.07, 0.07, 0.2))?);
        let link = Arc::new(scaled(&shapes::icosphere(5), Vec3::new(0.05, 0.05, 0.12))?);
        let hand = Arc::new(scaled(
            &shapes::torus_knot(2, 3, 0.2, 128),
            Vec3::splat(0.08),
        )?);
        let ground = Arc::new(scaled(
            &shapes::height_field(64, 3),
            Vec3::new(1.5, 1.5, 0.15),
        )?);
        let mut scene = Scene::new();
        scene.insert(Body::fixed(
            ground,
            Pose::new(DMat3::IDENTITY, DVec3::Z * -0.2)?,
        ))?;
        let mut links = Vec::new();
        for side in [1, 2] {
            for number in 0..LINKS {
                let tree = [&joint, &link][number % 2];
                let tree = if number + 1 == LINKS { &hand } else { tree };
                let filter = Filter::new(side, !side);
                links.push(
                    scene.insert(Body::moving(Arc::clone(tree), Pose::IDENTITY).filter(filter))?,
                );
            }
        }
        let of_side = |side: usize| std::array::from_fn(|number| links[side * LINKS + number]);
        let mut arms = Self {
            links: [of_side(0), of_side(1)],
            scene,
        };
        arms.place(0.0)?;
        Ok(arms)
    }

    /// Moves both arms to `phase` of their paths, seconds.
    pub fn place(&mut self, phase: f64) -> Result<(), Box<dyn Error>> {
        for (side, links) in self.links.iter().enumerate() {
            for (number, pose) in chain(side, phase)?.into_iter().enumerate() {
                self.scene.set_pose(links[number], pose)?;
            }
        }
        Ok(())
    }
}

/// The poses of the links of one arm: each joint swings at its own pace.
fn chain(side: usize, phase: f64) -> Result<[Pose; LINKS], PoseError> {
    let facing = if side == 0 { 1.0 } else { -1.0 };
    let (mut turn, mut place) = (DMat3::IDENTITY, DVec3::new(-0.36 * facing, 0.0, 0.1));
    let mut poses = [Pose::IDENTITY; LINKS];
    for (number, pose) in poses.iter_mut().enumerate() {
        let swing = (phase * (0.7 + 0.13 * number as f64) + 1.3 * side as f64).sin();
        turn *= match number % 2 {
            0 => DMat3::from_rotation_z(0.6 * swing),
            _ => DMat3::from_rotation_y(facing * (0.35 + 0.25 * swing)),
        };
        *pose = Pose::new(turn, place)?;
        place += turn * DVec3::Z * REACH;
    }
    Ok(poses)
}
