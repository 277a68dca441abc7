//! The box of a body in the scene.

use punctual::Tree;
use punctual_geom::{Aabb, Motion, Pose, length, rotation_deviation};

/// A box around all positions of the mesh between `from` and `to`, at a constant velocity and turn:
/// along the screw motion between the poses, or with the middle of its box on a straight line.
///
/// The arcs of the latter have the lesser radius, so [`arc_error`] bounds both. Matrices that are
/// not exactly rotations add at most 16 times their deviation, and turns below the least that a
/// [`Motion`] gives an axis 1e-12. If the axis is too far away for a [`Motion`], no arc leaves its
/// line by more than `.62 d + 1.24 r` (`d`: the distance of the middles of both boxes, `r`: half
/// their diagonal).
pub(crate) fn swept(tree: &Tree, from: &Pose, to: &Pose) -> Aabb {
    let ends = tree.aabb_at(from).union(&tree.aabb_at(to));
    if ends.is_empty() || from.rotation() == to.rotation() {
        return ends;
    }
    let size = length(ends.extents());
    let deviation = rotation_deviation(from.rotation()) + rotation_deviation(to.rotation());
    let by = match Motion::screw(*from, *to) {
        Ok(screw) => {
            let arcs = arc_error(tree, &screw, screw.turn().length());
            arcs + (16.0 * deviation + 1e-12) * size
        }
        Err(_) => 2.0 * size,
    };
    widened(ends, by)
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
    widened(ends, arc_error)
}

/// How far points of the mesh may be from the straight lines between their positions before and
/// after a part of a motion that turns by `angle`.
///
/// A point at distance `r` from the axis of a turn by `a` deviates from the straight line between
/// its ends by at most `r a^2 / 8` (linear interpolation of a curve with a second derivative of `r
/// a^2`). No point is farther from that line than the diameter of a circle. Rounding of
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
    widened(bounds, margin * (1.0 + 4.0 * f64::EPSILON))
}

/// A box with each of its faces moved out by `by`.
pub(super) fn widened(bounds: Aabb, by: f64) -> Aabb {
    Aabb {
        min: bounds.min - by,
        max: bounds.max + by,
    }
}
