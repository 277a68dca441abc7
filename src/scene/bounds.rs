//! The box of a body in the scene.

use crate::math::tolerance::{FRAME_ROUNDING, ROUNDING};
use crate::math::{Aabb, Pose, rotation_deviation};
use crate::tree::{Node, Tree};
use core::f64::consts::PI;
use glam::{DMat3, DVec3, Mat4, Vec3, Vec4};
use wide::f32x8;

/// Rounding that the box of a body allows for, relative to its distance and size.
///
/// What a query decides is decided in the frame of one body. There and back is one inverse and two products of poses, each
/// entry a sum of at most four products: less than 40 roundings of 2^-53, of magnitudes up to three times those used here.
const MARGIN: f64 = 128.0 * f64::EPSILON;

/// Rounding of the boxes of a tree and of their way into the scene, in units of the tree: a coordinate is a sum of three
/// products, of a column of length 1 and a vector of length sqrt 3 at most, so off by 4 sqrt 3 roundings, twice, and the sum
/// of both by 2 sqrt 3 more; all this is less than 18.
const UNIT_MARGIN: f64 = FRAME_ROUNDING as f64 + 32.0 * ROUNDING as f64;

/// A thousand times the least normal number: more than underflow takes away, flushed to zero or not.
const UNDERFLOW: f64 = 1024.0 * f64::MIN_POSITIVE;

/// A box, along the axes of the scene, around the mesh of a tree at `pose`; empty if the mesh is.
///
/// It is that of the boxes below the root, which fit more closely than the root's own when they are turned. Lanes without a
/// child hold the middle of the mesh's box.
pub(super) fn at(tree: &Tree, pose: &Pose) -> Aabb {
    let Some(root) = tree.nodes().first() else { return Aabb::EMPTY };
    let (unit, local) = (tree.unit().length(), tree.unit().origin);
    // The axes of the scene in the frame of the boxes.
    let axes = (*pose.rotation() * root.rotation().as_dmat3()).transpose();
    let (low, high) = reach(root, [axes.x_axis, axes.y_axis, axes.z_axis]);
    let origin = pose.transform_point(local);
    let magnitude = local.abs().max_element() + pose.translation().abs().max_element() + 4.0 * unit;
    let margin = DVec3::splat(MARGIN * magnitude + UNIT_MARGIN * unit + UNDERFLOW);
    Aabb { min: origin + low * unit - margin, max: origin + high * unit + margin }
}

/// A box around all places that the mesh takes on its way from `from` to `to`, at a constant velocity and turn: along the
/// screw between the poses, or with the middle of its box on a straight line.
///
/// A point at distance `r` from the axis of a turn by `a` leaves the straight line between its ends by at most `r a^2 / 8`
/// (linear interpolation of a curve with a second derivative of `r a^2`). The axis of the screw is at most
/// `d / (2 sin(a/2))` from the middle of the box, which moves by `d`.
pub(super) fn swept(tree: &Tree, from: &Pose, to: &Pose) -> Aabb {
    let ends = at(tree, from).union(&at(tree, to));
    if tree.nodes().is_empty() || from.rotation() == to.rotation() {
        return ends;
    }
    let bounds = tree.mesh().aabb();
    let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
    let distance = (to.transform_point(min + max) - from.transform_point(min + max)).length();
    let deviation = rotation_deviation(from.rotation()) + rotation_deviation(to.rotation());
    let angle = (turn(from.rotation(), to.rotation()) + 4.0 * deviation + TURN_ROUNDING).min(PI);
    let radius = (max - min).length() * (1.0 + deviation);
    let bulge = angle / 8.0 * (distance * (angle / 2.0) / libm::sin(angle / 2.0) + radius * angle);
    // What is not quite a rotation is not quite the screw.
    let bulge = DVec3::splat((bulge + 4.0 * deviation * (distance + radius)) * (1.0 + 1e-9));
    Aabb { min: ends.min - bulge, max: ends.max + bulge }
}

/// The angle between two rotations, 0 to pi.
fn turn(from: &DMat3, to: &DMat3) -> f64 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *to * from.transpose();
    let sine = DVec3::new(y.z - z.y, z.x - x.z, x.y - y.x).length();
    libm::atan2(sine, x.x + y.y + z.z - 1.0)
}

/// Rounding of [`turn`], radians.
const TURN_ROUNDING: f64 = 1e-12;

/// Least and largest coordinates of the boxes below a node along three directions, given along its axes.
#[inline(always)]
fn reach(node: &Node, [x, y, z]: [DVec3; 3]) -> (DVec3, DVec3) {
    let (x, y, z) = (along(node, x.as_vec3()), along(node, y.as_vec3()), along(node, z.as_vec3()));
    let low = Mat4::from_cols(least(x.0), least(y.0), least(z.0), Vec4::ZERO).transpose();
    let high = Mat4::from_cols(most(x.1), most(y.1), most(z.1), Vec4::ZERO).transpose();
    let low = low.x_axis.min(low.y_axis).min(low.z_axis.min(low.w_axis));
    let high = high.x_axis.max(high.y_axis).max(high.z_axis.max(high.w_axis));
    (low.truncate().as_dvec3(), high.truncate().as_dvec3())
}

/// The same for each box, along one direction.
#[inline(always)]
fn along(node: &Node, direction: Vec3) -> (f32x8, f32x8) {
    let (x, y, z) = (f32x8::splat(direction.x), f32x8::splat(direction.y), f32x8::splat(direction.z));
    let ([a, b, c], [d, e, f]) = (node.center, node.half);
    let center = f32x8::new(a) * x + f32x8::new(b) * y + f32x8::new(c) * z;
    let half = f32x8::new(d) * x.abs() + f32x8::new(e) * y.abs() + f32x8::new(f) * z.abs();
    (center - half, center + half)
}

#[inline(always)]
fn least(lanes: f32x8) -> Vec4 {
    let [low, high] = halves(lanes);
    low.min(high)
}

#[inline(always)]
fn most(lanes: f32x8) -> Vec4 {
    let [low, high] = halves(lanes);
    low.max(high)
}

#[inline(always)]
fn halves(lanes: f32x8) -> [Vec4; 2] {
    let [a, b, c, d, e, f, g, h] = lanes.to_array();
    [Vec4::new(a, b, c, d), Vec4::new(e, f, g, h)]
}
