//! The box of a body in the scene.

use crate::math::tolerance::FRAME_ROUNDING;
use crate::math::{Aabb, Pose};
use crate::tree::{Tree, xyz};
use glam::{DMat3, DVec3, Vec3};

/// Rounding that the box of a body allows for, relative to its distance and size.
///
/// What a query decides is decided in the frame of one body. There and back is one inverse and two products of poses, each
/// entry a sum of at most four products: less than 40 roundings of 2^-53, of magnitudes up to three times those used here.
const MARGIN: f64 = 128.0 * f64::EPSILON;

/// A box turned anyhow: its centre, and the three half edges as columns.
#[derive(Clone, Copy, Debug)]
struct Turned {
    center: DVec3,
    edges: DMat3,
}

impl Turned {
    fn at(&self, pose: &Pose) -> Aabb {
        let center = pose.transform_point(self.center);
        let edges = *pose.rotation() * self.edges;
        let half = edges.x_axis.abs() + edges.y_axis.abs() + edges.z_axis.abs();
        let reach = (self.center.abs() + pose.translation().abs()).max_element() + half.max_element();
        let half = half + DVec3::splat(MARGIN * reach);
        Aabb { min: center - half, max: center + half }
    }
}

/// Two boxes around a mesh, in its frame: one along its axes, one along those of the tree's root.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    boxes: Option<[Turned; 2]>,
}

impl Extent {
    pub fn of(tree: &Tree) -> Self {
        let boxes = tree.nodes().first().map(|root| {
            let bounds = tree.mesh().aabb();
            let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
            let along_axes = Turned { center: min + max, edges: DMat3::from_diagonal(max - min) };
            let (unit, rotation) = (tree.unit(), root.rotation().as_dmat3());
            let center = unit.origin + rotation * Vec3::from(xyz(root.own_center)).as_dvec3() * unit.length();
            let half = (root.extent().as_dvec3() + DVec3::splat(f64::from(FRAME_ROUNDING))) * unit.length();
            [along_axes, Turned { center, edges: rotation * DMat3::from_diagonal(half) }]
        });
        Self { boxes }
    }

    /// A box, along the axes of the scene, around the mesh at `pose`; empty if the mesh is.
    pub fn at(&self, pose: &Pose) -> Aabb {
        let Some([along_axes, along_root]) = &self.boxes else { return Aabb::EMPTY };
        let (x, y) = (along_axes.at(pose), along_root.at(pose));
        Aabb { min: x.min.max(y.min), max: x.max.min(y.max) }
    }

    /// A box around all of the mesh's way from `from` to `to`, if it turns about the middle of its box while that goes
    /// straight.
    pub fn swept(&self, from: &Pose, to: &Pose) -> Aabb {
        let Some([along_axes, _]) = &self.boxes else { return Aabb::EMPTY };
        let ends = self.at(from).union(&self.at(to));
        if from.rotation() == to.rotation() {
            return ends;
        }
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = along_axes.edges;
        let radius = DVec3::splat(SPHERE * (x + y + z).length());
        let way = [from, to].map(|pose| pose.transform_point(along_axes.center));
        let around = Aabb::from_points(way.into_iter().flat_map(|center| [center - radius, center + radius]));
        around.union(&ends)
    }
}

/// Radius of the sphere around a mesh over that of its box: what poses that are not quite rotations may stretch it by, and
/// rounding.
const SPHERE: f64 = 1.001;
