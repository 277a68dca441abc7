//! The box of a body in the scene.

use core::f64::consts::PI;
use glam::{DMat3, DVec3};
use punctual::Tree;
use punctual_geom::{Aabb, Motion, Pose, length, rotation_deviation};

/// A box around all positions of the mesh between `from` and `to`, at a constant velocity and turn:
/// along the screw motion between the poses, or with the middle of its box on a straight line.
///
/// A point at distance `r` from the axis of a turn by `a` deviates from the straight line between
/// its ends by at most `r a^2 / 8` (linear interpolation of a curve with a second derivative of `r
/// a^2`). The axis of the screw is at most `d / (2 sin(a/2))` from the middle of the box, which
/// moves by `d`.
pub(crate) fn swept(tree: &Tree, from: &Pose, to: &Pose) -> Aabb {
    let ends = tree.aabb_at(from).union(&tree.aabb_at(to));
    if ends.is_empty() || from.rotation() == to.rotation() {
        return ends;
    }
    let bounds = tree.mesh().aabb();
    let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
    let distance = length(to.transform_point(min + max) - from.transform_point(min + max));
    let deviation = rotation_deviation(from.rotation()) + rotation_deviation(to.rotation());
    let angle = (turn(from.rotation(), to.rotation()) + 4.0 * deviation + TURN_ROUNDING).min(PI);
    let radius = length(max - min) * (1.0 + deviation);
    let arc_error =
        angle / 8.0 * (distance * (angle / 2.0) / libm::sin(angle / 2.0) + radius * angle);
    // A matrix that is not exactly a rotation deviates from the screw motion.
    let arc_error =
        DVec3::splat((arc_error + 4.0 * deviation * (distance + radius)) * (1.0 + 1e-9));
    Aabb {
        min: ends.min - arc_error,
        max: ends.max + arc_error,
    }
}

/// A box around all positions of the mesh during a motion.
pub(crate) fn on_way(tree: &Tree, motion: &Motion) -> Aabb {
    let ends = tree
        .aabb_at(&motion.start())
        .union(&tree.aabb_at(&motion.pose(1.0)));
    let angle = motion.turn().length();
    if ends.is_empty() || angle == 0.0 {
        return ends;
    }
    let arc_error = arc_error(tree, motion, angle);
    Aabb {
        min: ends.min - arc_error,
        max: ends.max + arc_error,
    }
}

/// How far points of the mesh may be from the straight lines between their positions before and
/// after a part of a motion that turns by `angle`.
///
/// The bound is that of [`swept`], with the known radius of the body about the axis of the turn. No
/// point is farther from the line between its ends than the diameter of a circle. Rounding of
/// intermediate poses is relative to the arm and the path, and less than a tenth of the allowance.
pub(crate) fn arc_error(tree: &Tree, motion: &Motion, angle: f64) -> f64 {
    let start = motion.start();
    let bounds = tree.mesh().aabb();
    let (min, max) = (bounds.min * 0.5, bounds.max * 0.5);
    let arm = start.transform_point(min + max) - start.translation() + motion.arm();
    let stretch = 1.0 + 2.0 * motion.deviation();
    let axis = motion.turn() / motion.turn().length().max(f64::MIN_POSITIVE);
    let radius = length(axis.cross(arm)) + length(max - min) * stretch;
    let lengths =
        length(motion.arm()) + length(motion.velocity()) + length(start.translation()) + radius;
    radius * (angle * angle / 8.0).min(2.0) * (1.0 + 1e-9) + 512.0 * f64::EPSILON * lengths
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
