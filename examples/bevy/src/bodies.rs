//! Meshes and transforms of Bevy's as those of punctual.

use std::error::Error;
use std::fmt;

use bevy_math::{Affine3A, Vec3};
use bevy_mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues};
use bevy_transform::components::{GlobalTransform, Transform};
use punctual::{MeshError, Pose, PoseError};

/// Farthest that a scale may be from 1, and that axes may be from right angles: rounding along a hierarchy of transforms stays
/// far below, and is taken out.
const RIGID: f32 = 1e-4;

/// Why a mesh or a transform cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyError {
    /// The mesh has no positions of three floats, or gave them to the renderer.
    NoPositions,
    /// The mesh is of lines or points.
    NoTriangles(PrimitiveTopology),
    /// A list of triangles ends within one.
    Cut { corners: usize },
    /// As the library says.
    Mesh(MeshError),
    /// A pose turns and moves, no more. The mesh can be scaled instead (`Mesh::scaled_by`).
    Scaled(Vec3),
    /// The axes are not at right angles.
    Sheared,
    /// As the library says.
    Pose(PoseError),
}

impl fmt::Display for BodyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPositions => write!(
                f,
                "the mesh has no positions of three floats that can be read"
            ),
            Self::NoTriangles(topology) => {
                write!(f, "the mesh is a {topology:?}, not of triangles")
            }
            Self::Cut { corners } => write!(
                f,
                "the mesh has {corners} corners of triangles, no multiple of 3"
            ),
            Self::Mesh(error) => error.fmt(f),
            Self::Scaled(scale) => write!(
                f,
                "the transform scales by {scale}: scale the mesh instead, once"
            ),
            Self::Sheared => write!(f, "the transform shears: its axes are not at right angles"),
            Self::Pose(error) => error.fmt(f),
        }
    }
}

impl Error for BodyError {}

/// The triangles of a Bevy mesh: a list or a strip, with indices of 16 or 32 bits or none.
///
/// Triangles keep their order. In a strip every second one is turned around, as the renderer does, and those with a corner
/// twice, which only lead to the next part, are left out.
pub fn mesh(mesh: &Mesh) -> Result<punctual::Mesh, BodyError> {
    let positions = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
        Ok(VertexAttributeValues::Float32x3(positions)) => positions,
        _ => return Err(BodyError::NoPositions),
    };
    // Where a strip breaks off.
    let (corners, restart) = match mesh
        .try_indices_option()
        .map_err(|_| BodyError::NoPositions)?
    {
        Some(Indices::U16(corners)) => (
            corners.iter().copied().map(u32::from).collect(),
            u32::from(u16::MAX),
        ),
        Some(Indices::U32(corners)) => (corners.clone(), u32::MAX),
        None => ((0..positions.len() as u32).collect::<Vec<_>>(), u32::MAX),
    };
    let triangles = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => {
            let (triangles, rest) = corners.as_chunks::<3>();
            if !rest.is_empty() {
                return Err(BodyError::Cut {
                    corners: corners.len(),
                });
            }
            triangles.to_vec()
        }
        PrimitiveTopology::TriangleStrip => corners
            .split(|&corner| corner == restart)
            .flat_map(strip)
            .collect(),
        other => return Err(BodyError::NoTriangles(other)),
    };
    punctual::Mesh::new(positions.iter().copied(), triangles).map_err(BodyError::Mesh)
}

fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let turned = |(i, w): (usize, &[u32])| {
        if i % 2 == 0 {
            [w[0], w[1], w[2]]
        } else {
            [w[1], w[0], w[2]]
        }
    };
    corners
        .windows(3)
        .enumerate()
        .map(turned)
        .filter(|[p, q, r]| p != q && q != r && r != p)
}

/// Where a transform brings a body to, in its parent.
pub fn pose(transform: &Transform) -> Result<Pose, BodyError> {
    rigid(transform.compute_affine())
}

/// Where a global transform brings a body to, in the world.
pub fn global_pose(transform: &GlobalTransform) -> Result<Pose, BodyError> {
    rigid(transform.affine())
}

fn rigid(affine: Affine3A) -> Result<Pose, BodyError> {
    let (scale, rotation, translation) = affine.to_scale_rotation_translation();
    if !scale.abs_diff_eq(Vec3::ONE, RIGID) {
        return Err(BodyError::Scaled(scale));
    }
    let [x, y, z] = [
        affine.matrix3.x_axis,
        affine.matrix3.y_axis,
        affine.matrix3.z_axis,
    ];
    if [x.dot(y), y.dot(z), z.dot(x)]
        .iter()
        .any(|dot| dot.abs() > RIGID)
    {
        return Err(BodyError::Sheared);
    }
    Pose::from_quat(rotation.as_dquat(), translation.as_dvec3()).map_err(BodyError::Pose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_asset::RenderAssetUsages;
    use bevy_math::Quat;

    const CORNERS: [[f32; 3]; 5] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 2.0, 0.5],
    ];

    fn bevy(topology: PrimitiveTopology, indices: Option<Indices>) -> Mesh {
        let mesh = Mesh::new(topology, RenderAssetUsages::default());
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, CORNERS.to_vec());
        match indices {
            Some(indices) => mesh.with_inserted_indices(indices),
            None => mesh,
        }
    }

    fn triangles(topology: PrimitiveTopology, indices: Option<Indices>) -> Vec<[u32; 3]> {
        mesh(&bevy(topology, indices)).unwrap().triangles().to_vec()
    }

    #[test]
    fn lists_and_strips_keep_their_triangles_and_sides() {
        use PrimitiveTopology::{TriangleList, TriangleStrip};
        let list = [[0, 1, 2], [2, 1, 3]];
        assert_eq!(
            triangles(TriangleList, Some(Indices::U16(vec![0, 1, 2, 2, 1, 3]))),
            list
        );
        assert_eq!(
            triangles(TriangleList, Some(Indices::U32(vec![0, 1, 2, 2, 1, 3]))),
            list
        );
        assert_eq!(
            triangles(TriangleStrip, None),
            [[0, 1, 2], [2, 1, 3], [2, 3, 4]]
        );
        // With a corner twice, and with a break.
        assert_eq!(
            triangles(TriangleStrip, Some(Indices::U16(vec![0, 1, 2, 2, 3, 4]))),
            [[0, 1, 2], [3, 2, 4]]
        );
        let broken = vec![0, 1, 2, u16::MAX, 1, 3, 2, 4];
        assert_eq!(
            triangles(TriangleStrip, Some(Indices::U16(broken))),
            [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
        );
    }

    #[test]
    fn what_is_no_body_is_refused() {
        use PrimitiveTopology::{LineList, TriangleList};
        let refused = |topology, indices| mesh(&bevy(topology, indices)).unwrap_err();
        assert_eq!(refused(LineList, None), BodyError::NoTriangles(LineList));
        assert_eq!(refused(TriangleList, None), BodyError::Cut { corners: 5 });
        let beyond = refused(TriangleList, Some(Indices::U32(vec![0, 1, 7])));
        assert!(
            matches!(beyond, BodyError::Mesh(_)) && beyond.to_string().contains('7'),
            "{beyond}"
        );
        assert_eq!(
            mesh(&Mesh::new(TriangleList, RenderAssetUsages::default())).unwrap_err(),
            BodyError::NoPositions
        );
        let scaled = pose(&Transform::from_scale(Vec3::new(1.0, 2.0, 1.0))).unwrap_err();
        assert!(
            scaled.to_string().contains("scales by [1, 2, 1]"),
            "{scaled}"
        );
        let leaning = GlobalTransform::from(Affine3A::from_mat3(bevy_math::Mat3::from_cols(
            Vec3::X,
            Vec3::new(0.02, 1.0, 0.0).normalize(),
            Vec3::Z,
        )));
        assert!(matches!(
            global_pose(&leaning),
            Err(BodyError::Sheared | BodyError::Scaled(_))
        ));
    }

    #[test]
    fn poses_move_points_as_transforms_do() {
        let turn = Transform::from_xyz(1.0, -2.0, 3.0).with_rotation(Quat::from_euler(
            bevy_math::EulerRot::XYZ,
            0.3,
            1.1,
            -2.0,
        ));
        // A hundred steps of a hierarchy, with their rounding.
        let deep = (0..100).fold(GlobalTransform::IDENTITY, |all, _| all * turn);
        for (pose, moved) in [
            (
                pose(&turn).unwrap(),
                turn.transform_point(Vec3::new(0.5, 0.7, -0.2)),
            ),
            (
                global_pose(&deep).unwrap(),
                deep.transform_point(Vec3::new(0.5, 0.7, -0.2)),
            ),
        ] {
            let ours = pose
                .transform_point([0.5f32 as f64, 0.7f32 as f64, -0.2f32 as f64])
                .as_vec3();
            assert!(
                (Vec3::from_array(ours.to_array()) - moved).length() < 1e-4,
                "{ours} {moved}"
            );
        }
    }
}
