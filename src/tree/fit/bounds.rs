//! A box around a mesh at a pose.

use crate::tree::{Node, Tree};
use glam::{DVec3, Vec3};
use punctual_geom::lanes::{F8, Portable, dot, greatest, least, per_axis};
use punctual_geom::tolerance::{FRAME_ROUNDING, ROUNDING, UNDERFLOW};
use punctual_geom::{Aabb, Pose};

/// Rounding allowance of a box, relative to its distance and size.
///
/// A query decides in the frame of one body. Mapping a point to that frame and back takes one
/// inverse and two products of poses. Each entry is a sum of at most four products: less than 40
/// roundings of 2^-53, of magnitudes up to three times those used here.
const MARGIN: f64 = 128.0 * f64::EPSILON;

/// Rounding of the boxes of a tree, and of their map into the scene, in units of the tree.
///
/// The second term bounds the map. A center and a half extent are mapped separately. A coordinate
/// of each is a sum of three products, of a column of length 1 and a vector of length at most sqrt
/// 3, so its error is at most 4 sqrt 3 roundings. Adding both results adds 2 sqrt 3 more. The total
/// is less than 18 roundings; the term has 32.
const UNIT_MARGIN: f64 = FRAME_ROUNDING as f64 + 32.0 * ROUNDING as f64;

/// Covers the rounding of the sums with a radius.
const THICKER: f64 = 1.0 + 8.0 * f64::EPSILON;

impl Tree {
    /// A box around the (thickened) mesh at a pose, along the axes into which the pose maps; empty
    /// if the mesh is. Takes constant time.
    ///
    /// It surrounds the rotated boxes of the root's children. They fit more closely than the
    /// rotated box of the root.
    #[must_use]
    pub fn aabb_at(&self, pose: &Pose) -> Aabb {
        let Some(root) = self.nodes.first() else {
            return Aabb::EMPTY;
        };
        let (unit, local) = (self.unit.length(), self.unit.origin);
        // The outer axes in the frame of the boxes.
        let axes = (*pose.rotation() * root.rotation().as_dmat3()).transpose();
        let (low, high) = reach(root, [axes.x_axis, axes.y_axis, axes.z_axis]);
        let origin = pose.transform_point(local);
        let magnitude =
            local.abs().max_element() + pose.translation().abs().max_element() + 4.0 * unit;
        let margin = DVec3::splat(
            MARGIN * magnitude + UNIT_MARGIN * unit + UNDERFLOW + self.radius * THICKER,
        );
        Aabb {
            min: origin + low * unit - margin,
            max: origin + high * unit + margin,
        }
    }
}

/// Least and largest coordinates of the boxes of a node's children along three directions. These
/// are given in the node's axes. Lanes without a child hold the center of the mesh's box.
#[inline(always)]
fn reach(node: &Node, directions: [DVec3; 3]) -> (DVec3, DVec3) {
    let center = per_axis!(k => F8::read(Portable {}, &node.center[k]));
    let half = per_axis!(k => F8::read(Portable {}, &node.half[k]));
    let ends = per_axis!(i => {
        let direction = directions[i].as_vec3().to_array();
        let middle = dot(per_axis!(k => F8::splat(Portable {}, direction[k])), center);
        let reach = dot(per_axis!(k => F8::splat(Portable {}, direction[k].abs())), half);
        (middle - reach, middle + reach)
    });
    let (low, high) = (
        least(per_axis!(i => ends[i].0)),
        greatest(per_axis!(i => ends[i].1)),
    );
    (Vec3::from(low).as_dvec3(), Vec3::from(high).as_dvec3())
}
