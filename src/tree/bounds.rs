//! A box around a mesh at a pose.

use super::{Node, Tree};
use glam::{DVec3, Vec3};
use punctual_geom::lanes::{F8, Portable, dot, greatest, least, per_axis};
use punctual_geom::tolerance::{FRAME_ROUNDING, ROUNDING, UNDERFLOW};
use punctual_geom::{Aabb, Pose};

/// Rounding allowance of a box, relative to its distance and size.
///
/// A query decides in the frame of one body. The way there and back is one inverse and two products
/// of poses. Each entry is a sum of at most four products: less than 40 roundings of 2^-53, of
/// magnitudes up to three times those used here.
const MARGIN: f64 = 128.0 * f64::EPSILON;

/// Rounding of the boxes of a tree and of their map into the scene, in units of the tree. A
/// coordinate is a sum of three products, of a column of length 1 and a vector of length at most
/// sqrt 3. Its error is at most 4 sqrt 3 roundings, twice, and the sum of both adds 2 sqrt 3. The
/// total is less than 18.
const UNIT_MARGIN: f64 = FRAME_ROUNDING as f64 + 32.0 * ROUNDING as f64;

impl Tree {
    /// A box around the mesh at a pose, along the axes into which the pose maps; empty if the mesh
    /// is. Constant time.
    ///
    /// It surrounds the boxes below the root, which fit more closely than the root's own when
    /// rotated.
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
        let margin = DVec3::splat(MARGIN * magnitude + UNIT_MARGIN * unit + UNDERFLOW);
        Aabb {
            min: origin + low * unit - margin,
            max: origin + high * unit + margin,
        }
    }
}

/// Least and largest coordinates of the boxes below a node along three directions, which are given
/// in the node's axes. Lanes without a child hold the middle of the mesh's box.
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
