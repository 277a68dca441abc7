//! The profile of a subtree, level by level: what the cost model is computed from.
//!
//! All are measured along the axes of the subtree's root: a box with half extents `e` and axes `Q` counts as `|Q| e`.
//! Levels are merged bottom-up from those of the children, `O(nodes * height)`.

use super::eight::present;
use super::wide::{Node, xyz};
use crate::math::lanes::{F8, Lanes, per_axis, sums};
use alloc::boxed::Box;
use core::f32::consts::LN_2;
use glam::{Mat3A, Vec3, Vec3A};
use wide::bytemuck::cast;
use wide::{f32x4, i32x4};

/// The boxes of one level of a subtree, counted down from its root; axes of the root, unit coordinates (multiply by
/// [`crate::Tree::unit_length`] for the mesh's).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LevelProfile {
    /// Number of boxes.
    pub nodes: f32,
    /// Their mean half extent.
    pub half_extent: Vec3,
    /// Mean of their centres.
    pub center: Vec3,
    /// Variance of their centres.
    pub variance: Vec3,
}

impl LevelProfile {
    const NONE: Self = Self { nodes: 0.0, half_extent: Vec3::ZERO, center: Vec3::ZERO, variance: Vec3::ZERO };

    /// The children of `node` as its level 1, and the summed surface area of their boxes.
    #[inline(always)]
    fn of_children<L: Lanes>(lanes: L, node: &Node) -> (Self, f32) {
        let scale = 1.0 / f32::from(node.children);
        let own = xyz(node.own_center);
        // Boxes that are not there have no extent.
        let [x, y, z] = per_axis!(k => F8::load(lanes, &node.half[k]));
        let present = present(lanes, node.children.into());
        let [u, v, w] = per_axis!(k => (F8::load(lanes, &node.center[k]) - F8::splat(lanes, own[k])) * present);
        let [hx, hy, hz, area] = sums([x, y, z, x * y + y * z + z * x]);
        let [cx, cy, cz, uu] = sums([u, v, w, u * u]);
        let [vv, ww, ..] = sums([v * v, w * w, u, u]);
        let mean = Vec3A::new(cx, cy, cz) * scale;
        let level = Self {
            nodes: f32::from(node.children),
            half_extent: (Vec3A::new(hx, hy, hz) * scale).into(),
            center: (Vec3A::from(own) + mean).into(),
            variance: (Vec3A::new(uu, vv, ww) * scale - mean * mean).max(Vec3A::ZERO).into(),
        };
        (level, 8.0 * area)
    }

    /// The same boxes along the axes that `rotation` leads to.
    #[inline(always)]
    fn rotated(&self, rotation: &Mat3A, absolute: &Mat3A, squared: &Mat3A) -> Self {
        Self {
            nodes: self.nodes,
            half_extent: *absolute * self.half_extent,
            center: *rotation * self.center,
            variance: *squared * self.variance,
        }
    }

    /// Both sets of boxes together.
    #[inline(always)]
    fn merged(&self, other: &Self) -> Self {
        let nodes = self.nodes + other.nodes;
        let w = other.nodes / nodes;
        let apart = other.center - self.center;
        Self {
            nodes,
            half_extent: self.half_extent.lerp(other.half_extent, w),
            center: self.center.lerp(other.center, w),
            variance: self.variance.lerp(other.variance, w) + apart * apart * (w * (1.0 - w)),
        }
    }
}

/// What is kept of a subtree besides its node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Mean half extent of the triangles' boxes.
    pub leaf: Vec3,
    /// Diminishing factor per axis, end to end.
    pub alpha: Vec3,
}

/// The profiles of all subtrees: node `i` has levels `nodes[i].profile..` and shape `shapes[i]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Profiles {
    pub levels: Box<[LevelProfile]>,
    pub shapes: Box<[Shape]>,
    /// SAH cost: the summed area of all boxes, those of the triangles too, over that of the root; 0 if that has none.
    pub cost: f32,
}

impl Profiles {
    /// Room for those of `nodes`, still to be measured. Writes `height` and `profile` into the nodes.
    pub fn room(nodes: &mut [Node]) -> Self {
        let mut levels = 0;
        for index in (0..nodes.len()).rev() {
            let (node, later) = nodes[index..].split_first_mut().expect("index is within the nodes");
            let below = if node.is_cluster { 0..0 } else { node.child_range() };
            let below = &later[below.start.saturating_sub(index + 1)..][..below.len()];
            node.height = 1 + below.iter().map(|child| child.height).max().unwrap_or(0);
            node.profile = levels as u32;
            levels += usize::from(node.height);
        }
        let shape = Shape { leaf: Vec3::ZERO, alpha: Vec3::ONE };
        Self {
            levels: alloc::vec![LevelProfile::NONE; levels].into(),
            shapes: alloc::vec![shape; nodes.len()].into(),
            cost: 0.0,
        }
    }

    /// Measures the subtree of node `index`, whose boxes are there and whose `children` have been measured. Returns the
    /// summed surface area of the children's boxes.
    #[inline(always)]
    pub fn measure<L: Lanes>(&mut self, lanes: L, index: usize, node: &mut Node, children: &[Node]) -> f64 {
        // Levels of what is below come first.
        let (below, levels) = self.levels.split_at_mut(node.profile as usize);
        let levels = &mut levels[..usize::from(node.height)];
        let (level, area) = LevelProfile::of_children(lanes, node);
        levels[0] = level;
        let leaf = if node.is_cluster {
            level.half_extent
        } else {
            merge_children(node, children, &self.shapes[node.first_child as usize..], below, &mut levels[1..])
        };
        let alpha = alpha(leaf, node.extent(), node.triangles);
        node.alpha = alpha.element_product();
        node.self_cost = self_cost(node, levels);
        self.shapes[index] = Shape { leaf, alpha };
        f64::from(area)
    }
}

/// Puts the levels of the children of `node`, which lie in `all`, together in `levels`; returns the mean half extent of
/// its leaves.
#[inline(always)]
fn merge_children(
    node: &Node,
    children: &[Node],
    shapes: &[Shape],
    all: &[LevelProfile],
    levels: &mut [LevelProfile],
) -> Vec3 {
    let to_node = node.axes().transpose();
    levels.fill(LevelProfile::NONE);
    let mut leaves = Vec3::ZERO;
    for (child, shape) in children.iter().zip(shapes) {
        let of_child = &all[child.profile as usize..][..usize::from(child.height)];
        if child.orientation == node.orientation {
            for (level, seen) in levels.iter_mut().zip(of_child) {
                *level = level.merged(seen);
            }
            leaves += shape.leaf * child.triangles as f32;
        } else {
            let rotation = to_node * child.axes();
            let absolute = rotation.abs();
            let Mat3A { x_axis: x, y_axis: y, z_axis: z } = rotation;
            let squared = Mat3A::from_cols(x * x, y * y, z * z);
            for (level, seen) in levels.iter_mut().zip(of_child) {
                *level = level.merged(&seen.rotated(&rotation, &absolute, &squared));
            }
            leaves += absolute * shape.leaf * child.triangles as f32;
        }
    }
    leaves / node.triangles as f32
}

/// `alpha_k = (mean leaf extent_k / node extent_k)^(1/h)`, `h = log2(triangles)` the height of a balanced binary tree;
/// 1 where there is nothing to shrink.
#[inline(always)]
fn alpha(leaf: Vec3, own: Vec3, triangles: u32) -> Vec3 {
    if triangles < 2 {
        return Vec3::ONE;
    }
    let [x, y, z] = per_axis!(k => {
        if own[k] > 0.0 { (leaf[k] / own[k]).clamp(f32::MIN_POSITIVE, 1.0) } else { 1.0 }
    });
    let [x, y, z, height] = log2(f32x4::new([x, y, z, triangles as f32])).to_array();
    Vec3::from(xyz(exp2(f32x4::new([x, y, z, 0.0]) * f32x4::splat(1.0 / height))))
}

/// log2 of positive normal numbers, off by less than 10^-6; unlike those of `libm` four at once.
#[inline(always)]
fn log2(x: f32x4) -> f32x4 {
    // x = 2^e m, m within sqrt(1/2)..sqrt(2).
    let half_root = i32x4::splat(0x3f35_04f3);
    let shifted = cast::<f32x4, i32x4>(x) - half_root;
    let m: f32x4 = cast((shifted & i32x4::splat(0x007f_ffff)) + half_root);
    let e: i32x4 = shifted >> 23_i32;
    // ln m = 2 artanh t
    let t = (m - f32x4::ONE) / (m + f32x4::ONE);
    let tt = t * t;
    e.round_float() + t * polynomial(tt, [2.0 / LN_2, 2.0 / 3.0 / LN_2, 2.0 / 5.0 / LN_2, 2.0 / 7.0 / LN_2])
}

/// 2^x for x within -126..=0, off by less than 10^-6 of it.
#[inline(always)]
fn exp2(x: f32x4) -> f32x4 {
    let whole = (x - f32x4::HALF).fast_trunc_int();
    let y = (x - whole.round_float()) * f32x4::splat(LN_2);
    let power = polynomial(y, [1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0]);
    let exponent: i32x4 = (whole + i32x4::splat(127)) << 23_i32;
    power * cast::<i32x4, f32x4>(exponent)
}

/// The sum of `coefficients[i] * x^i`; nothing is fused.
#[inline(always)]
fn polynomial<const N: usize>(x: f32x4, coefficients: [f32; N]) -> f32x4 {
    let mut sum = f32x4::splat(coefficients[N - 1]);
    for i in (0..N - 1).rev() {
        sum = sum * x + f32x4::splat(coefficients[i]);
    }
    sum
}

/// Expected BV tests of a subtree against a copy of itself, averaged over all overlapping placements:
/// `sum_l n_(l+1)^2 O_l / n_l^2`, `O_l = n_l^2 prod_k e_k(l) / e_k(0)` (the mean of the products replaced by the product
/// of the means).
#[inline(always)]
fn self_cost(node: &Node, levels: &[LevelProfile]) -> f32 {
    let own = node.extent();
    let mut share = 1.0;
    let mut tests = 0.0;
    for level in &levels[..usize::from(node.height)] {
        tests += level.nodes * level.nodes * share;
        let [x, y, z] = per_axis!(k => if own[k] > 0.0 { (level.half_extent[k] / own[k]).min(1.0) } else { 1.0 });
        share = x * y * z;
    }
    tests
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_logarithms_are_those_of_libm() {
        let one = |f: fn(f32x4) -> f32x4, x: f32| f(f32x4::splat(x)).to_array()[2];
        for i in 1..=20_000 {
            let x = i as f32 / 20_000.0;
            for x in [x, 1.0 / x, x * 1e-30, 1.0 - x * 1e-6] {
                assert!((one(log2, x) - libm::log2f(x)).abs() < 1e-6 * libm::log2f(x).abs().max(1.0), "{x}");
            }
            let x = -126.0 * (i - 1) as f32 / 20_000.0;
            for x in [x, x / 100.0] {
                assert!((one(exp2, x) / libm::exp2f(x) - 1.0).abs() < 1e-6, "{x}");
            }
        }
    }

    #[test]
    fn nothing_to_shrink_is_alpha_one_and_points_in_a_box_are_zero() {
        assert_eq!(alpha(Vec3::ONE, Vec3::ONE, 1), Vec3::ONE);
        let alpha = alpha(Vec3::new(0.0, 0.25, 0.0), Vec3::new(0.0, 1.0, 1.0), 4);
        assert!((alpha - Vec3::new(1.0, 0.5, 0.0)).abs().max_element() < 1e-6, "{alpha}");
    }
}
