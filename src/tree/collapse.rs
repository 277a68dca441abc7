//! From the binary tree to the wide one: which binary nodes become wide nodes.

use super::binary::BinaryTree;
use super::fork::Pieces;
use super::orientation::Orientation;
use super::unit::Triangle;
use super::wide::{Node, WIDTH};
use super::{BuildOptions, Effort, assign};
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::ops::Range;

/// Collapses `binary` over `triangles` (tree order). The root is node 0; there is none for an empty mesh.
///
/// Each node gets the orientation of the mesh, or if the options say so the best for it; boxes are still to come. `O(n)`.
pub(super) fn collapse(
    binary: &BinaryTree,
    triangles: &[Triangle],
    whole: Orientation,
    options: &BuildOptions,
    pieces: Pieces,
) -> Box<[Node]> {
    let choose = options.orientations && options.effort != Effort::Fast;
    let orientation = if choose { Orientation::IDENTITY } else { whole };
    let plan = Plan::of(binary);
    let mut nodes: Box<[Node]> = plan.0.iter().map(|stub| stub.node(binary, &orientation)).collect();
    if choose {
        assign::choose_orientations(&plan, &mut nodes, triangles, options.effort, pieces);
    }
    nodes
}

/// A wide node before it has boxes.
pub(super) struct Stub {
    /// Its binary node.
    root: u32,
    first_child: u32,
    pub triangles: u32,
    /// Nodes below it.
    pub below: u32,
    /// Inner nodes of the subtree, and the number of the first: this one, if it is no cluster.
    pub families: u32,
    pub family: u32,
    children: u8,
    depth: u8,
    pub is_cluster: bool,
}

impl Stub {
    fn new(binary: &BinaryTree, root: usize, depth: u8) -> Self {
        let subtree = &binary.nodes[root];
        Self {
            root: root as u32,
            first_child: subtree.first,
            triangles: subtree.count,
            children: subtree.count as u8,
            is_cluster: subtree.is_cluster(),
            depth,
            below: 0,
            families: 0,
            family: 0,
        }
    }

    /// Numbers of the children: nodes, or triangles of a cluster.
    pub fn child_range(&self) -> Range<usize> {
        self.first_child as usize..self.first_child as usize + usize::from(self.children)
    }

    fn node(&self, binary: &BinaryTree, orientation: &Orientation) -> Node {
        let subtree = &binary.nodes[self.root as usize];
        let mut node = Node {
            first_child: self.first_child,
            first_triangle: subtree.first,
            triangles: subtree.count,
            children: self.children,
            is_cluster: self.is_cluster,
            depth: self.depth,
            ..Node::EMPTY
        };
        node.set_orientation(orientation);
        node
    }
}

/// Which binary nodes become wide nodes, in their order: siblings side by side, then what is below each in turn.
pub(super) struct Plan(pub Vec<Stub>);

impl Plan {
    fn of(binary: &BinaryTree) -> Self {
        let mut plan = Self(Vec::with_capacity(binary.nodes.len() * 3 / 4 + 1));
        if !binary.nodes.is_empty() {
            plan.0.push(Stub::new(binary, 0, 0));
            plan.open(binary, 0, 0);
        }
        plan
    }

    /// Adds all below `index`, whose first inner node has the number `family`.
    fn open(&mut self, binary: &BinaryTree, index: usize, family: u32) {
        if self.0[index].is_cluster {
            return;
        }
        let (first, depth) = (self.0.len(), self.0[index].depth);
        self.0.extend(
            opened(binary, self.0[index].root as usize).into_iter().map(|child| Stub::new(binary, child, depth + 1)),
        );
        let children = first..self.0.len();
        let mut families = 1;
        for child in children.clone() {
            self.open(binary, child, family + families);
            families += self.0[child].families;
        }
        let (below, count) = ((self.0.len() - first) as u32, children.len() as u8);
        let stub = &mut self.0[index];
        (stub.first_child, stub.children, stub.below) = (first as u32, count, below);
        (stub.families, stub.family) = (families, family);
    }

    /// Two halves of some siblings.
    pub fn halves(&self, siblings: &Range<usize>) -> [Range<usize>; 2] {
        let middle = siblings.start + siblings.len() / 2;
        [siblings.start..middle, middle..siblings.end]
    }

    /// A quantity summed over some siblings.
    pub fn sum(&self, siblings: &Range<usize>, of: impl Fn(&Stub) -> u32) -> usize {
        self.0[siblings.clone()].iter().map(of).sum::<u32>() as usize
    }
}

/// Up to eight descendants of `root`: the one with the largest box is opened until there are eight, or only clusters.
fn opened(binary: &BinaryTree, root: usize) -> ArrayVec<usize, WIDTH> {
    let nodes = &binary.nodes;
    let mut below = ArrayVec::new();
    below.push(root);
    while below.len() < WIDTH {
        let openable = (0..below.len()).filter(|&i| !nodes[below[i]].is_cluster());
        let area = |i: usize| nodes[below[i]].area;
        let Some(widest) = openable.max_by(|&i, &j| area(i).total_cmp(&area(j))) else { break };
        let [left, right] = binary.children(below[widest]);
        below[widest] = left;
        // Beside its sibling, so that the triangles of a wide node stay in one piece and in order.
        below.insert(widest + 1, right);
    }
    below
}
