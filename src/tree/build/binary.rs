//! The binary tree of the paper: binned surface-area heuristic over the triangles' boxes. All boxes
//! have the axes chosen for the whole mesh ([`super::align::align`]).
//!
//! The paper's alphas are defined on its levels, and the wide tree is collapsed from it. Splitting
//! ends at leaves of at most [`CLUSTER`] triangles. `O(n log n)` time, `O(n)` memory. The depth
//! is at most `2 log2(n) + 10` for all meshes ([`most_depth`]).

pub(crate) use super::bins::Bounds;
use super::bins::{Centers, Part};
use super::orientation::Orientation;
use crate::mesh::Mesh;
use crate::tree::fork::Pieces;
use crate::tree::options::Effort;
use crate::tree::unit::Unit;
use crate::tree::wide::WIDTH;
use alloc::vec::Vec;
use punctual_geom::lanes::Instructions;

/// Maximum number of triangles of a leaf, and of children of a wide node.
pub(crate) const CLUSTER: usize = WIDTH;

/// One node: triangles `order[first..first + count]`.
pub(crate) struct BinaryNode {
    pub first: u32,
    pub count: u32,
    /// Half the surface area of the node's box.
    pub area: f32,
    /// Offset from this node to its right child, in nodes; the left child is the next node. 0 for a
    /// leaf.
    right: u32,
}

impl BinaryNode {
    pub fn is_leaf(&self) -> bool {
        self.right == 0
    }
}

/// Maximum number of steps from the root to a leaf in a tree of this many triangles.
pub(crate) fn most_depth(triangles: usize) -> u32 {
    2 * (usize::BITS - triangles.leading_zeros()) + 8
}

/// The tree. `nodes[0]` is the root. `order` holds the triangle ids in tree order.
pub(crate) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    pub order: Vec<u32>,
}

impl BinaryTree {
    /// The children of a node that is not a leaf.
    pub fn children(&self, node: usize) -> [usize; 2] {
        [node + 1, node + self.nodes[node].right as usize]
    }
}

/// Builds the tree over the triangles' boxes along the axes of `orientation`.
pub(crate) fn build(
    mesh: &Mesh,
    unit: &Unit,
    orientation: &Orientation,
    effort: Effort,
    pieces: Pieces,
) -> BinaryTree {
    over(
        unit.bounds(mesh, orientation.rotation, pieces),
        effort,
        pieces,
    )
}

/// Builds the tree over boxes.
pub(crate) fn over(mut items: Vec<Bounds>, effort: Effort, pieces: Pieces) -> BinaryTree {
    let mut nodes = Vec::with_capacity(items.len() / 2 + 1);
    if !items.is_empty() {
        let depth_left = most_depth(items.len());
        split(effort, &mut items, 0, depth_left, &mut nodes, pieces);
    }
    BinaryTree {
        nodes,
        order: items.iter().map(Bounds::id).collect(),
    }
}

/// The tree over this many primitives in their order, cut at powers of two.
pub(crate) fn even(count: usize) -> BinaryTree {
    fn cut(first: usize, count: usize, nodes: &mut Vec<BinaryNode>) {
        let index = nodes.len();
        nodes.push(BinaryNode {
            first: first as u32,
            count: count as u32,
            area: count as f32,
            right: 0,
        });
        if count > CLUSTER {
            let left = 1 << (count - 1).ilog2();
            cut(first, left, nodes);
            nodes[index].right = (nodes.len() - index) as u32;
            cut(first + left, count - left, nodes);
        }
    }
    let mut nodes = Vec::new();
    if count > 0 {
        cut(0, count, &mut nodes);
    }
    BinaryTree {
        nodes,
        order: Vec::new(),
    }
}

/// Splits `items`, which begin at `first` in tree order, and appends their nodes.
fn split(
    effort: Effort,
    items: &mut [Bounds],
    first: u32,
    depth_left: u32,
    nodes: &mut Vec<BinaryNode>,
    pieces: Pieces,
) {
    // A split may be unbalanced as long as a balanced tree of `items` would fit in the depth left.
    let balanced = usize::BITS - items.len().saturating_sub(1).leading_zeros();
    let may_part = items.len() > CLUSTER && depth_left > balanced;
    let (area, middle) = Instructions::detect().run(Part {
        items,
        effort: may_part.then_some(effort),
    });
    let index = nodes.len();
    nodes.push(BinaryNode {
        first,
        count: items.len() as u32,
        area,
        right: 0,
    });
    if items.len() <= CLUSTER {
        return;
    }
    let middle = middle.unwrap_or_else(|| halve(items));
    let (left, right) = items.split_at_mut(middle);
    let (depth_left, second) = (depth_left - 1, first + middle as u32);
    if pieces.count() < 2 {
        split(effort, left, first, depth_left, nodes, pieces);
        nodes[index].right = (nodes.len() - index) as u32;
        split(effort, right, second, depth_left, nodes, pieces);
    } else {
        let mut of_right = Vec::new();
        pieces.join(
            [left.len(), right.len()],
            |pieces| split(effort, left, first, depth_left, nodes, pieces),
            |pieces| split(effort, right, second, depth_left, &mut of_right, pieces),
        );
        nodes[index].right = (nodes.len() - index) as u32;
        nodes.append(&mut of_right);
    }
}

/// Splits `items` into halves of equal number, along the axis on which their centers extend
/// farthest.
fn halve(items: &mut [Bounds]) -> usize {
    let Centers { min, max } = items.iter().fold(Centers::NONE, Centers::and);
    let axis = (max - min).truncate().max_position();
    let key = |item: &Bounds| item.center()[axis];
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        key(a).total_cmp(&key(b)).then(a.id().cmp(&b.id()))
    });
    middle
}
