//! What a subtree is like, level by level: the numbers that the cost model lives on.
//!
//! All are measured in the frame of the subtree's root: a box with half extents `e` and frame `Q` counts as `|Q| e`.
//! Levels are merged bottom-up from those of the children, `O(nodes * height)`.

use super::wide::{Node, WIDTH};
use alloc::vec::Vec;
use glam::{Mat3, Vec3};

/// The boxes of one level of a subtree, counted down from its root; frame of the root, unit coordinates (multiply by
/// [`crate::Tree::unit_length`] for the mesh's).
#[derive(Clone, Copy, Debug, PartialEq)]
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

    /// The children of `node` as its level 1.
    fn of_children(node: &Node) -> Self {
        let n = f32::from(node.children);
        let lanes = 0..usize::from(node.children);
        let of = |lane: usize, boxes: &[[f32; WIDTH]; 3]| Vec3::new(boxes[0][lane], boxes[1][lane], boxes[2][lane]);
        let center = lanes.clone().map(|i| of(i, &node.center)).sum::<Vec3>() / n;
        let square = |x: Vec3| x * x;
        Self {
            nodes: n,
            half_extent: lanes.clone().map(|i| of(i, &node.half)).sum::<Vec3>() / n,
            center,
            variance: lanes.map(|i| square(of(i, &node.center) - center)).sum::<Vec3>() / n,
        }
    }

    /// The same boxes seen from a frame that `rotation` leads to.
    fn rotated(&self, rotation: &Mat3) -> Self {
        Self {
            nodes: self.nodes,
            half_extent: rotation.abs() * self.half_extent,
            center: *rotation * self.center,
            variance: map(rotation, |x| x * x) * self.variance,
        }
    }

    /// Both sets of boxes together.
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

fn map(m: &Mat3, f: impl Fn(f32) -> f32) -> Mat3 {
    Mat3::from_cols_array(&m.to_cols_array().map(f))
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
    pub levels: Vec<LevelProfile>,
    pub shapes: Vec<Shape>,
}

impl Profiles {
    /// Measures all subtrees and writes `height`, `profile`, `alpha` and `visits` into the nodes.
    pub fn measure(nodes: &mut [Node]) -> Self {
        let mut levels = Vec::with_capacity(nodes.len() * 5 / 4);
        let mut shapes = alloc::vec![Shape { leaf: Vec3::ZERO, alpha: Vec3::ONE }; nodes.len()];
        for index in (0..nodes.len()).rev() {
            let (node, below) = nodes[index..].split_first_mut().expect("index is within the nodes");
            node.profile = levels.len() as u32;
            node.height = 1;
            levels.push(LevelProfile::of_children(node));
            let mut leaf = levels[levels.len() - 1].half_extent;
            if !node.is_cluster {
                let first = node.first_child as usize - index - 1;
                let below = &below[first..first + usize::from(node.children)];
                node.height += below.iter().map(|child| child.height).max().unwrap_or(0);
                leaf = merge_children(node, below, &mut levels, &shapes[index + 1 + first..]);
            }
            let alpha = alpha(leaf, node.extent(), node.triangles);
            shapes[index] = Shape { leaf, alpha };
            node.alpha = alpha.element_product();
            node.visits = visits(node, &levels[node.profile as usize..]);
        }
        Self { levels, shapes }
    }
}

/// Appends levels 2 and deeper of `node`; returns the mean half extent of its leaves.
fn merge_children(node: &Node, below: &[Node], levels: &mut Vec<LevelProfile>, shapes: &[Shape]) -> Vec3 {
    let to_node = node.rotation().transpose();
    let start = levels.len();
    levels.resize(start + usize::from(node.height) - 1, LevelProfile::NONE);
    let mut leaves = Vec3::ZERO;
    for (child, shape) in below.iter().zip(shapes) {
        let rotation = if child.frame == node.frame { Mat3::IDENTITY } else { to_node * child.rotation() };
        for level in 0..usize::from(child.height) {
            let seen = levels[child.profile as usize + level].rotated(&rotation);
            levels[start + level] = levels[start + level].merged(&seen);
        }
        leaves += rotation.abs() * shape.leaf * child.triangles as f32;
    }
    leaves / node.triangles as f32
}

/// `alpha_k = (mean leaf extent_k / node extent_k)^(1/h)`, `h = log2(triangles)` the height of a balanced binary tree;
/// 1 where there is nothing to shrink.
fn alpha(leaf: Vec3, own: Vec3, triangles: u32) -> Vec3 {
    if triangles < 2 {
        return Vec3::ONE;
    }
    let exponent = 1.0 / libm::log2f(triangles as f32);
    let axis = |k: usize| if own[k] > 0.0 { libm::powf((leaf[k] / own[k]).min(1.0), exponent) } else { 1.0 };
    Vec3::new(axis(0), axis(1), axis(2))
}

/// Expected BV tests of a subtree against its like, averaged over the placements in which their roots meet:
/// `sum_l n_(l+1)^2 O_l / n_l^2`, `O_l = n_l^2 prod_k e_k(l) / e_k(0)` (the mean of the products replaced by the product
/// of the means).
fn visits(node: &Node, levels: &[LevelProfile]) -> f32 {
    let own = node.extent();
    let ratio = |half: Vec3, k: usize| if own[k] > 0.0 { (half[k] / own[k]).min(1.0) } else { 1.0 };
    let mut share = 1.0;
    let mut tests = 0.0;
    for level in &levels[..usize::from(node.height)] {
        tests += level.nodes * level.nodes * share;
        share = ratio(level.half_extent, 0) * ratio(level.half_extent, 1) * ratio(level.half_extent, 2);
    }
    tests
}
