//! The box of a body in the scene.

use crate::tree::{Node, Tree};
use core::f64::consts::PI;
use glam::{DMat3, DVec3, Vec3};
use punctual_geom::lanes::{F8, Portable, dot, greatest, least, per_axis};
use punctual_geom::tolerance::{FRAME_ROUNDING, ROUNDING, UNDERFLOW};
use punctual_geom::{Aabb, Motion, Pose, length, rotation_deviation};

/// Rounding allowance of a body's box, relative to its distance and size.
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

/// A box, along the axes of the scene, around the mesh of a tree at `pose`; empty if the mesh is.
///
/// It surrounds the boxes below the root, which fit more closely than the root's own when rotated.
/// Lanes without a child hold the middle of the mesh's box.
pub(crate) fn at(tree: &Tree, pose: &Pose) -> Aabb {
    let Some(root) = tree.nodes().first() else {
        return Aabb::EMPTY;
    };
    let (unit, local) = (tree.unit().length(), tree.unit().origin);
    // The axes of the scene in the frame of the boxes.
    let axes = (*pose.rotation() * root.rotation().as_dmat3()).transpose();
    let (low, high) = reach(root, [axes.x_axis, axes.y_axis, axes.z_axis]);
    let origin = pose.transform_point(local);
    let magnitude = local.abs().max_element() + pose.translation().abs().max_element() + 4.0 * unit;
    let margin = DVec3::splat(MARGIN * magnitude + UNIT_MARGIN * unit + UNDERFLOW);
    Aabb {
        min: origin + low * unit - margin,
        max: origin + high * unit + margin,
    }
}

/// A box around all positions of the mesh between `from` and `to`, at a constant velocity and turn:
/// along the screw motion between the poses, or with the middle of its box on a straight line.
///
/// A point at distance `r` from the axis of a turn by `a` deviates from the straight line between
/// its ends by at most `r a^2 / 8` (linear interpolation of a curve with a second derivative of `r
/// a^2`). The axis of the screw is at most `d / (2 sin(a/2))` from the middle of the box, which
/// moves by `d`.
pub(crate) fn swept(tree: &Tree, from: &Pose, to: &Pose) -> Aabb {
    let ends = at(tree, from).union(&at(tree, to));
    if tree.nodes().is_empty() || from.rotation() == to.rotation() {
        return ends;
    }
    let bounds = tree.mesh().aabb();
    let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
    let distance = length(to.transform_point(min + max) - from.transform_point(min + max));
    let deviation = rotation_deviation(from.rotation()) + rotation_deviation(to.rotation());
    let angle = (turn(from.rotation(), to.rotation()) + 4.0 * deviation + TURN_ROUNDING).min(PI);
    let radius = length(max - min) * (1.0 + deviation);
    let bulge = angle / 8.0 * (distance * (angle / 2.0) / libm::sin(angle / 2.0) + radius * angle);
    // A matrix that is not exactly a rotation deviates from the screw motion.
    let bulge = DVec3::splat((bulge + 4.0 * deviation * (distance + radius)) * (1.0 + 1e-9));
    Aabb {
        min: ends.min - bulge,
        max: ends.max + bulge,
    }
}

/// A box around all positions of the mesh during a motion.
///
/// The bound is that of [`swept`], with the known radius of the body about the axis of the turn. No
/// point is farther from the line between its ends than the diameter of a circle. Rounding of
/// intermediate poses is relative to the arm and the path, and less than a tenth of the allowance.
pub(crate) fn on_way(tree: &Tree, motion: &Motion) -> Aabb {
    let (start, end) = (motion.start(), motion.pose(1.0));
    let ends = at(tree, &start).union(&at(tree, &end));
    let angle = motion.turn().length();
    if tree.nodes().is_empty() || angle == 0.0 {
        return ends;
    }
    let bounds = tree.mesh().aabb();
    let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
    let arm = start.transform_point(min + max) - start.translation() + motion.arm();
    let stretch = 1.0 + 2.0 * motion.deviation();
    let radius = length((motion.turn() / angle).cross(arm)) + length(max - min) * stretch;
    let lengths =
        length(motion.arm()) + length(motion.velocity()) + length(start.translation()) + radius;
    let bulge =
        radius * (angle * angle / 8.0).min(2.0) * (1.0 + 1e-9) + 512.0 * f64::EPSILON * lengths;
    Aabb {
        min: ends.min - bulge,
        max: ends.max + bulge,
    }
}

/// A box thickened by a margin. This adds one sum per corner; the margins of the box cover its
/// rounding.
pub(crate) fn thickened(bounds: Aabb, margin: f64) -> Aabb {
    let margin = margin * (1.0 + 4.0 * f64::EPSILON);
    Aabb {
        min: bounds.min - margin,
        max: bounds.max + margin,
    }
}

/// The angle between two rotations, 0 to pi.
fn turn(from: &DMat3, to: &DMat3) -> f64 {
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = *to * from.transpose();
    let sine = DVec3::new(y.z - z.y, z.x - x.z, x.y - y.x).length();
    libm::atan2(sine, x.x + y.y + z.z - 1.0)
}

/// Rounding of [`turn`], radians.
const TURN_ROUNDING: f64 = 1e-12;

/// Least and largest coordinates of the boxes below a node along three directions, which are given
/// in the node's axes.
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
