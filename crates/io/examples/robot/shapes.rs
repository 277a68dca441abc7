//! The geometry of URDF as meshes. What is round becomes a polyhedron around it, not inside: a distance to it is never too large.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use punctual::glam::{DVec2, DVec3};
use punctual::shapes::{cuboid, icosphere};
use punctual::{Mesh, Pose};
use urdf_rs::Geometry;

/// Sides of a cylinder: a polyhedron that is .2 % wider.
const SIDES: u32 = 48;

/// Vertices and triangles, before they are checked.
#[derive(Default)]
pub struct Surface {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Of a geometry; files of meshes are in `folder`, or below.
    pub fn new(geometry: &Geometry, folder: &Path) -> Result<Self, Box<dyn Error>> {
        Ok(match geometry {
            Geometry::Box { size } => Self::scaled(&cuboid([0.5; 3], 1), DVec3::from_array(size.0)),
            Geometry::Sphere { radius } => {
                let ball = icosphere(3);
                let inner = (0..ball.len())
                    .map(|id| depth(&ball, id))
                    .fold(1.0, f64::min);
                Self::scaled(&ball, DVec3::splat(radius / inner))
            }
            Geometry::Cylinder { radius, length } => Self::cylinder(*radius, *length),
            Geometry::Capsule { .. } => return Err("a capsule, which URDF does not have".into()),
            Geometry::Mesh { filename, scale } => {
                let name = filename.trim_start_matches("file://");
                let name = match name.strip_prefix("package://") {
                    Some(rest) => rest.split_once('/').map_or(rest, |(_, file)| file),
                    None => name,
                };
                let mesh = punctual_io::load(&folder.join(name))?.mesh;
                Self::scaled(
                    &mesh,
                    scale.map_or(DVec3::ONE, |scale| DVec3::from_array(scale.0)),
                )
            }
        })
    }

    fn scaled(mesh: &Mesh, scale: DVec3) -> Self {
        let vertices = (0..mesh.vertex_count())
            .map(|i| mesh.vertex(i) * scale)
            .collect();
        Self {
            vertices,
            triangles: mesh.triangles().to_vec(),
        }
    }

    /// Around the z axis: two rings of corners, and the middles of both ends.
    fn cylinder(radius: f64, length: f64) -> Self {
        let outer = radius / (0.5 * TAU / f64::from(SIDES)).cos();
        let corner = |i: u32, z: f64| {
            (outer * DVec2::from_angle(TAU * f64::from(i) / f64::from(SIDES))).extend(z)
        };
        let ring = |z: f64| (0..SIDES).map(move |i| corner(i, z)).chain([DVec3::Z * z]);
        let vertices = ring(-0.5 * length).chain(ring(0.5 * length)).collect();
        let (bottom, top) = (SIDES, 2 * SIDES + 1);
        let side = |i: u32| {
            let (j, up) = ((i + 1) % SIDES, SIDES + 1);
            [
                [bottom, j, i],
                [i, j, j + up],
                [i, j + up, i + up],
                [top, i + up, j + up],
            ]
        };
        Self {
            vertices,
            triangles: (0..SIDES).flat_map(side).collect(),
        }
    }

    /// Adds another one, which lies at a pose.
    pub fn add(&mut self, other: &Self, pose: &Pose) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(
            other
                .vertices
                .iter()
                .map(|&point| pose.transform_point(point)),
        );
        self.triangles.extend(
            other
                .triangles
                .iter()
                .map(|corners| corners.map(|corner| first + corner)),
        );
    }

    pub fn mesh(&self) -> Result<Mesh, punctual::MeshError> {
        Mesh::from_f64(
            self.vertices.iter().map(DVec3::to_array),
            self.triangles.iter().copied(),
        )
    }
}

/// How far the plane of a triangle is from the origin.
fn depth(mesh: &Mesh, triangle: usize) -> f64 {
    let [p, q, r] = mesh.triangle(triangle);
    (q - p).cross(r - p).normalize().dot(p).abs()
}
