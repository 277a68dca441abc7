//! Computes in `f64`, along one direction, the gap of boxes that are separated by less than the
//! margins of `f32`.
//!
//! Those margins scale with the meshes, however small the nodes are. The margin in `f64` is little
//! more than the rounding of the boxes, so parallel sheets are separated high up in the trees.
//! The proof is in `docs/numerics.md`, "Boxes that are close".

use super::relative_pose::{RelativePose, Views};
use crate::tree::{Node, xyz};
use glam::DVec3;
use punctual_geom::tolerance;
use wide::f32x4;

/// Lower bound of the gap between the own boxes of two nodes, in A's units, along the face axis
/// with the largest gap in `f32`; negative if they may overlap.
#[cold]
#[inline(never)]
pub(crate) fn gap(a: &Node, b: &Node, views: &Views, relative: &RelativePose) -> f64 {
    let scale = f32x4::splat(relative.scale);
    let (of_a, of_b) = (
        (a.own_center, a.own_half),
        (b.own_center * scale, b.own_half * scale),
    );
    let (in_a, in_b) = (
        xyz(views.of_b.gaps(of_b, of_a)),
        xyz(views.of_a.gaps(of_a, of_b)),
    );
    let (mut widest, mut axis) = (f32::NEG_INFINITY, DVec3::X);
    for k in 0..3 {
        if in_a[k] > widest {
            (widest, axis) = (in_a[k], a.rotation().col(k).as_dvec3());
        }
        if in_b[k] > widest {
            (widest, axis) = (in_b[k], relative.linear() * b.rotation().col(k).as_dvec3());
        }
    }
    gap_of([a, b], relative, axis, ROUNDING)
}

/// Lower bound of the gap along a direction in A's unit coordinates.
#[cold]
#[inline(never)]
pub(crate) fn gap_along(a: &Node, b: &Node, relative: &RelativePose, direction: f32x4) -> f64 {
    gap_of([a, b], relative, wide(direction), ROUNDING)
}

fn gap_of([a, b]: [&Node; 2], relative: &RelativePose, direction: DVec3, rounding: f64) -> f64 {
    let [of_a, from_a] = shadow(a, direction, rounding);
    let [of_b, from_b] = shadow(b, relative.linear().transpose() * direction, rounding);
    let between = direction.dot(relative.middle()) + of_b - of_a;
    let position_error = 3.0 * f64::from(relative.triangles.position_error)
        + SECOND_ORDER * (1.0 + f64::from(relative.scale));
    (between.abs() - (from_a + from_b)) / direction.length() - position_error
}

/// One rounding of `f32`.
const ROUNDING: f64 = tolerance::ROUNDING as f64;

/// 2^-37, in unit coordinates: more than all terms with the square of a rounding plus the rounding
/// of `f64`.
const SECOND_ORDER: f64 = 1.0 / (1u64 << 37) as f64;

/// Middle and half length of an interval that contains the projections of all triangles of a node
/// on a direction, in its mesh's unit coordinates.
fn shadow(node: &Node, direction: DVec3, rounding: f64) -> [f64; 2] {
    let (center, half, axes) = (
        wide(node.own_center),
        wide(node.own_half),
        node.rotation().as_dmat3(),
    );
    // The axes are not exactly orthonormal: one step of Newton's method towards their inverse.
    let first = axes.transpose() * direction;
    let along = 2.0 * first - axes.transpose() * (axes * first);
    // Corners were rounded along the axes of the mesh.
    let sizes = axes.abs();
    let extent = sizes * half;
    let reach = (axes * center).abs() + extent;
    let roundings = sizes.transpose() * (4.0 * reach + 2.0 * extent) + 2.0 * (center.abs() + half);
    [
        along.dot(center),
        along.abs().dot(half + rounding * roundings),
    ]
}

fn wide(v: f32x4) -> DVec3 {
    DVec3::from_array(xyz(v).map(f64::from))
}

#[cfg(all(test, feature = "std"))]
mod tests;
