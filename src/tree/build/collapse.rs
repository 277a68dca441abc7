//! Collapses the binary tree to the wide one: decides which binary nodes become wide nodes, and in
//! which order.

use super::binary::BinaryTree;
use super::orientation::Orientation;
use crate::tree::fork::Pieces;
use crate::tree::wide::{Node, WIDTH};
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::ops::Range;

/// The wide nodes, still without boxes. The root is node 0. Siblings are adjacent. After a group of
/// siblings come the nodes below the first one, then those below the second one, and so on. So the
/// nodes below a node are contiguous, and no node comes before its parent.
#[derive(Default)]
pub(crate) struct Plan {
    pub nodes: Box<[Node]>,
    /// The inner nodes. Each comes directly before the inner nodes below it.
    pub inner: Vec<Inner>,
}

/// The part of a node that is known when the node gets its number. It is small; the nodes
/// themselves are large and are written only once, in place.
#[derive(Clone, Copy)]
struct Seed {
    /// Index of the node in the binary tree.
    root: u32,
    first_child: u32,
    children: u8,
    depth: u8,
}

pub(crate) struct Inner {
    pub node: u32,
    /// Number of nodes below it.
    below: u32,
    /// Number of inner nodes below it, itself included.
    pub count: u32,
}

/// The nodes below some inner node, as ranges of a plan: one task for a thread.
pub(crate) struct Part {
    pub nodes: Range<usize>,
    pub inner: Range<usize>,
}

impl Plan {
    /// Collapses `binary`. All nodes get the same orientation. `O(n)`.
    pub fn of(binary: &BinaryTree, orientation: &Orientation) -> Self {
        let mut seeds = Vec::with_capacity(binary.nodes.len() * 3 / 4 + 1);
        let mut inner = Vec::new();
        if !binary.nodes.is_empty() {
            seeds.push(Seed::of(binary, 0, 0));
            open(binary, 0, &mut seeds, &mut inner);
        }
        Self {
            nodes: seeds
                .iter()
                .map(|seed| seed.node(binary, orientation))
                .collect(),
            inner,
        }
    }

    /// The largest subtrees with no more triangles than one of `pieces`, without their roots; none
    /// if there is only one piece.
    pub fn parts(&self, pieces: Pieces) -> Vec<Part> {
        let mut parts = Vec::new();
        let triangles = self
            .nodes
            .first()
            .map_or(0, |root| pieces.size(root.triangles as usize));
        let mut number = if pieces.count() > 1 {
            0
        } else {
            self.inner.len()
        };
        while let Some(inner) = self.inner.get(number) {
            let node = &self.nodes[inner.node as usize];
            let end = number
                + if node.triangles as usize <= triangles {
                    inner.count as usize
                } else {
                    1
                };
            if end > number + 1 {
                let first = node.first_child as usize;
                parts.push(Part {
                    nodes: first..first + inner.below as usize,
                    inner: number + 1..end,
                });
            }
            number = end;
        }
        parts
    }
}

impl Seed {
    fn of(binary: &BinaryTree, root: usize, depth: u8) -> Self {
        let subtree = &binary.nodes[root];
        let children = if subtree.is_leaf() {
            subtree.count as u8
        } else {
            0
        };
        Self {
            root: root as u32,
            first_child: subtree.first,
            children,
            depth,
        }
    }

    fn node(&self, binary: &BinaryTree, orientation: &Orientation) -> Node {
        let subtree = &binary.nodes[self.root as usize];
        let mut node = Node {
            first_child: self.first_child,
            first_triangle: subtree.first,
            triangles: subtree.count,
            children: self.children,
            is_leaf: subtree.is_leaf(),
            depth: self.depth,
            ..Node::default()
        };
        node.set_orientation(orientation);
        node
    }
}

/// Appends all nodes below node `index`.
fn open(binary: &BinaryTree, index: usize, seeds: &mut Vec<Seed>, inner: &mut Vec<Inner>) {
    let (first, Seed { root, depth, .. }) = (seeds.len(), seeds[index]);
    if binary.nodes[root as usize].is_leaf() {
        return;
    }
    let children = widest(binary, root as usize);
    seeds.extend(
        children
            .iter()
            .map(|&child| Seed::of(binary, child, depth + 1)),
    );
    (seeds[index].first_child, seeds[index].children) = (first as u32, children.len() as u8);
    let number = inner.len();
    inner.push(Inner {
        node: index as u32,
        below: 0,
        count: 0,
    });
    for child in first..first + children.len() {
        open(binary, child, seeds, inner);
    }
    let (below, count) = (seeds.len() - first, inner.len() - number);
    inner[number] = Inner {
        node: index as u32,
        below: below as u32,
        count: count as u32,
    };
}

/// Up to eight descendants of `root`. Replaces the one with the largest box by its children until
/// there are eight, or only leaves.
fn widest(binary: &BinaryTree, root: usize) -> ArrayVec<usize, WIDTH> {
    let nodes = &binary.nodes;
    let mut below = ArrayVec::new();
    below.push(root);
    while below.len() < WIDTH {
        let openable = (0..below.len()).filter(|&i| !nodes[below[i]].is_leaf());
        let area = |i: usize| nodes[below[i]].area;
        let Some(widest) = openable.max_by(|&i, &j| area(i).total_cmp(&area(j))) else {
            break;
        };
        let [left, right] = binary.children(below[widest]);
        below[widest] = left;
        // Next to its sibling, so that the triangles of a wide node stay contiguous and in order.
        below.insert(widest + 1, right);
    }
    below
}
