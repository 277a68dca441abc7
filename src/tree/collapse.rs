//! From the binary tree to the wide one: which binary nodes stay, their frames, their boxes.

use super::axes::Moments;
use super::binary::BinaryTree;
use super::columns::Columns;
use super::fork::Pieces;
use super::frame::{Frame, MESH_FRAME};
use super::unit::Triangle;
use super::wide::{Node, WIDTH};
use super::{BuildOptions, Effort};
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::ops::Range;

/// Collapses `binary` over `triangles` (tree order). The root is node 0; there is none for an empty mesh.
///
/// Each node gets the frame of the mesh, or if the options say so the best for it: moments bottom-up, then frames
/// top-down. `O(n)`.
pub(super) fn collapse(
    binary: &BinaryTree,
    triangles: &[Triangle],
    whole: Frame,
    options: &BuildOptions,
    pieces: Pieces,
) -> Box<[Node]> {
    let choose = options.frames && options.effort != Effort::Fast;
    let frame = if choose { Frame::IDENTITY } else { whole };
    let plan = Plan::of(binary);
    let mut nodes: Box<[Node]> = plan.0.iter().map(|stub| stub.node(binary, &frame)).collect();
    let mut families = Vec::new();
    if choose && !nodes.is_empty() {
        families.resize(plan.0[0].families, Moments::EMPTY);
        Gather { plan: &plan, triangles }.siblings(0..1, &mut families, pieces);
    }
    let Some((root, below)) = nodes.split_first_mut() else { return nodes };
    let finish = Finish { plan: &plan, families: &families, triangles, effort: options.effort };
    if choose {
        let whole = families.first().copied().unwrap_or_else(|| Moments::of_triangles(triangles, 0));
        finish.set_frames(&Moments::of_all(&[whole]), frame, 0, core::slice::from_mut(root));
    }
    finish.siblings(0, core::slice::from_mut(root), below, pieces);
    nodes
}

/// A wide node before it has boxes.
struct Stub {
    /// Its binary node.
    root: usize,
    first_child: usize,
    children: usize,
    triangles: usize,
    is_cluster: bool,
    depth: u8,
    /// Nodes below it.
    below: usize,
    /// Inner nodes of the subtree, and the number of the first: this one, if it is no cluster.
    families: usize,
    family: usize,
}

impl Stub {
    fn new(binary: &BinaryTree, root: usize, depth: u8) -> Self {
        let subtree = &binary.nodes[root];
        Self {
            root,
            first_child: subtree.first as usize,
            children: subtree.count as usize,
            triangles: subtree.count as usize,
            is_cluster: subtree.is_cluster(),
            depth,
            below: 0,
            families: 0,
            family: 0,
        }
    }

    fn child_range(&self) -> Range<usize> {
        self.first_child..self.first_child + self.children
    }

    fn node(&self, binary: &BinaryTree, frame: &Frame) -> Node {
        let subtree = &binary.nodes[self.root];
        let mut node = Node {
            first_child: self.first_child as u32,
            first_triangle: subtree.first,
            triangles: subtree.count,
            children: self.children as u8,
            is_cluster: self.is_cluster,
            depth: self.depth,
            ..Node::EMPTY
        };
        node.set_frame(frame);
        node
    }
}

/// Which binary nodes become wide nodes, in their order: siblings side by side, then what is below each in turn.
struct Plan(Vec<Stub>);

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
    fn open(&mut self, binary: &BinaryTree, index: usize, family: usize) {
        if self.0[index].is_cluster {
            return;
        }
        let (first, depth) = (self.0.len(), self.0[index].depth);
        self.0.extend(opened(binary, self.0[index].root).into_iter().map(|child| Stub::new(binary, child, depth + 1)));
        let children = first..self.0.len();
        let mut families = 1;
        for child in children.clone() {
            self.open(binary, child, family + families);
            families += self.0[child].families;
        }
        let below = self.0.len() - first;
        self.0[index] = Stub { first_child: first, children: children.len(), below, families, family, ..self.0[index] };
    }

    fn sum(&self, siblings: Range<usize>, of: impl Fn(&Stub) -> usize) -> usize {
        self.0[siblings].iter().map(of).sum()
    }

    /// Two halves of some siblings, with the triangles of each.
    fn halves(&self, siblings: &Range<usize>) -> ([Range<usize>; 2], [usize; 2]) {
        let middle = siblings.start + siblings.len() / 2;
        let halves = [siblings.start..middle, middle..siblings.end];
        let sizes = halves.clone().map(|half| self.sum(half, |stub| stub.triangles));
        (halves, sizes)
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

/// Bottom-up: the moments of the children of each inner node, its family.
struct Gather<'p> {
    plan: &'p Plan,
    triangles: &'p [Triangle],
}

impl Gather<'_> {
    /// Fills the families of the subtrees of some siblings.
    fn siblings(&self, siblings: Range<usize>, families: &mut [Moments], pieces: Pieces) {
        if siblings.len() > 1 {
            let ([left, right], sizes) = self.plan.halves(&siblings);
            let (of_left, of_right) = families.split_at_mut(self.plan.sum(left.clone(), |stub| stub.families));
            pieces.join(
                sizes,
                |pieces| self.siblings(left, of_left, pieces),
                |pieces| self.siblings(right, of_right, pieces),
            );
        } else if let Some((own, below)) = families.split_first_mut() {
            let stub = &self.plan.0[siblings.start];
            self.siblings(stub.child_range(), below, pieces);
            for (lane, child) in self.plan.0[stub.child_range()].iter().enumerate() {
                if child.is_cluster {
                    let triangles = child.child_range();
                    own.set(lane, &Moments::of_triangles(&self.triangles[triangles.clone()], triangles.start));
                } else {
                    own.set(lane, &below[child.family - stub.family - 1]);
                }
            }
        }
    }
}

/// Top-down: the frame of each node; and on the way back its boxes.
struct Finish<'p> {
    plan: &'p Plan,
    /// Empty if the frames stay as they are.
    families: &'p [Moments],
    triangles: &'p [Triangle],
    effort: Effort,
}

impl Finish<'_> {
    /// Finishes siblings with numbers from `first` on; `below` are all nodes below them.
    fn siblings(&self, first: usize, siblings: &mut [Node], below: &mut [Node], pieces: Pieces) {
        if let [node] = siblings {
            return self.node(&self.plan.0[first], node, below, pieces);
        }
        let ([left, right], sizes) = self.plan.halves(&(first..first + siblings.len()));
        let (of_left, of_right) = siblings.split_at_mut(left.len());
        let (below_left, below_right) = below.split_at_mut(self.plan.sum(left.clone(), |stub| stub.below));
        pieces.join(
            sizes,
            |pieces| self.siblings(left.start, of_left, below_left, pieces),
            |pieces| self.siblings(right.start, of_right, below_right, pieces),
        );
    }

    fn node(&self, stub: &Stub, node: &mut Node, below: &mut [Node], pieces: Pieces) {
        if !stub.is_cluster {
            let (children, rest) = below.split_at_mut(stub.children);
            if let Some(family) = self.families.get(stub.family) {
                self.set_frames(family, node.frame(), stub.first_child, children);
            }
            self.siblings(stub.first_child, children, rest, pieces);
        }
    }

    /// Chooses the frames of siblings with numbers from `first` on, whose moments are `family`.
    fn set_frames(&self, family: &Moments, parent: Frame, first: usize, siblings: &mut [Node]) {
        let candidates = family.candidates();
        for (lane, node) in siblings.iter_mut().enumerate() {
            let stub = &self.plan.0[first + lane];
            let candidates = candidates.of_lane(lane, self.triangles, self.effort);
            let id = MESH_FRAME + 1 + (first + lane) as u32;
            let frame = if stub.is_cluster {
                let columns = Columns::of(&self.triangles[stub.child_range()]);
                parent.or_better(&candidates, id, |axes| columns.cost(axes))
            } else {
                parent.or_better(&candidates, id, |axes| self.families[stub.family].cost(axes))
            };
            node.set_frame(&frame);
        }
    }
}
