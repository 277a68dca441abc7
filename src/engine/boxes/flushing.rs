//! Checks whether a processor that takes denormal numbers for zero could make an answer false.

use crate::tree::Tree;
use glam::DVec3;
use punctual_geom::{Pose, Ray, denormals};

/// Least exponents for which flushing has no effect. `LEAST` is that of coordinates, of
/// translations and of their products, `LEAST_UNIT` that of the length of a unit. The proof is in
/// `docs/numerics.md`.
const LEAST: i32 = -960;
const LEAST_UNIT: i32 = -900;

/// True if numbers of this query are so small that flushing matters, and this thread flushes
/// denormal numbers. Checked in this order, because the latter takes longer: a denormal result
/// costs a hundred times an ordinary one.
#[inline(always)]
pub fn matters(a: &Tree, b: &Tree, b_in_a: &Pose) -> bool {
    !is_far_from_denormal(a, b, b_in_a) && denormals::are_flushed()
}

/// [`matters`] for rays. For many rays the order is reversed, because checking the flushing takes
/// less time than checking all rays.
#[inline(always)]
pub(crate) fn matters_to_rays(tree: &Tree, rays: &[Ray]) -> bool {
    match rays {
        [ray] => !is_ray_far_from_denormal(tree, ray) && denormals::are_flushed(),
        _ => {
            denormals::are_flushed() && !rays.iter().all(|ray| is_ray_far_from_denormal(tree, ray))
        }
    }
}

#[inline(always)]
pub(crate) fn matters_to_points(tree: &Tree, points: &[[f64; 3]]) -> bool {
    denormals::are_flushed()
        && !(is_tree_far_from_denormal(tree)
            && points
                .iter()
                .all(|point| denormals::none_below(point, LEAST)))
}

#[inline(always)]
fn is_tree_far_from_denormal(tree: &Tree) -> bool {
    tree.mesh().least_exponent() >= LEAST && tree.unit().exponent >= LEAST_UNIT
}

#[inline(always)]
fn is_ray_far_from_denormal(tree: &Tree, ray: &Ray) -> bool {
    let is_far = |v: DVec3| denormals::none_below(&v.to_array(), LEAST);
    // The direction of a segment is the difference of its target and origin.
    let [_, target] = ray.exact_direction();
    is_tree_far_from_denormal(tree) && is_far(ray.origin()) && is_far(target)
}

#[inline(always)]
fn is_far_from_denormal(a: &Tree, b: &Tree, b_in_a: &Pose) -> bool {
    let [of_a, of_b] = [a, b].map(|tree| tree.mesh().least_exponent());
    let units = [a, b].map(|tree| tree.unit().exponent);
    of_a.min(of_b) >= LEAST
        && units[0].min(units[1]) >= LEAST_UNIT
        && (of_b >= LEAST - GENERIC_EXPONENT && is_generic(b_in_a)
            || has_none_below(b_in_a, LEAST - of_b.min(0)))
}

/// `2^-256`, and its exponent.
const GENERIC: f64 = 8.636_168_555_094_445e-78;
const GENERIC_EXPONENT: i32 = -256;

/// True only if no entry of a pose is zero or less than [`GENERIC`]; false also for a few other
/// poses. Takes half the instructions of [`has_none_below`], and is true for almost all poses
/// except those along an axis.
#[inline(always)]
fn is_generic(pose: &Pose) -> bool {
    let [a, b, c, d, e, f, g, h, i] = pose.rotation().to_cols_array();
    // No entry exceeds 1.001, so none is much less than their product.
    let product = ((a * b) * (c * d)) * ((e * f) * (g * h)) * i;
    let [x, y, z] = pose.translation().to_array().map(f64::abs);
    product.abs() >= 2.0 * GENERIC && x >= GENERIC && y >= GENERIC && z >= GENERIC
}

#[cold]
fn has_none_below(pose: &Pose, exponent: i32) -> bool {
    denormals::none_below(&pose.translation().to_array(), LEAST)
        && denormals::none_below(&pose.rotation().to_cols_array(), exponent)
}
