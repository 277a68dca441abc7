//! The binary AABB tree of a mesh as the paper has it: boxes along the axes, down to single triangles.
//!
//! The library's own trees are eight wide, their boxes turned to fit, and their leaves hold up to eight triangles; so the
//! paper's tree is built here. Splits by the surface-area heuristic over 16 bins an axis, `O(n log n)`.

use crate::traversal::BinaryNode;
use punctual::glam::{DMat3, DVec3};
use punctual::{Aabb, Mesh};

fn area(bounds: &Aabb) -> f64 {
    let e = bounds.extents();
    e.x * e.y + e.y * e.z + e.z * e.x
}

fn union<'b>(boxes: impl IntoIterator<Item = &'b Aabb>) -> Aabb {
    boxes
        .into_iter()
        .fold(Aabb::EMPTY, |all, bounds| all.union(bounds))
}

struct Node {
    bounds: Aabb,
    /// Index of the second child, the first comes next; 0 for a leaf.
    second: usize,
}

/// The tree; node 0 is the root.
pub struct MeshTree {
    nodes: Vec<Node>,
}

impl MeshTree {
    /// The tree of a mesh with triangles, turned by `rotation` first.
    pub fn new(mesh: &Mesh, rotation: &DMat3) -> Self {
        let triangles = (0..mesh.len()).map(|i| mesh.triangle(i));
        let turned = triangles.map(|corners| corners.map(|corner| *rotation * corner));
        let mut boxes: Vec<Aabb> = turned.map(Aabb::from_points).collect();
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * boxes.len()),
        };
        tree.split(&mut boxes);
        tree
    }

    fn split(&mut self, boxes: &mut [Aabb]) {
        let index = self.nodes.len();
        self.nodes.push(Node {
            bounds: union(&*boxes),
            second: 0,
        });
        if boxes.len() > 1 {
            let middle = partition(boxes);
            let (first, second) = boxes.split_at_mut(middle);
            self.split(first);
            self.nodes[index].second = self.nodes.len();
            self.split(second);
        }
    }

    pub fn leaves(&self) -> usize {
        self.nodes.len().div_ceil(2)
    }

    fn center(&self) -> DVec3 {
        self.nodes[0].bounds.center()
    }

    /// Full extents of the root's box.
    pub fn extents(&self) -> DVec3 {
        self.nodes[0].bounds.extents()
    }

    /// The root of the tree moved by `shift`.
    pub fn root(&self, shift: DVec3) -> MeshNode<'_> {
        MeshNode {
            tree: self,
            index: 0,
            shift,
        }
    }

    /// How far to move `other` so that the centre of its root's box is at `offset` from this one's.
    pub fn shift_to(&self, other: &Self, offset: DVec3) -> DVec3 {
        self.center() + offset - other.center()
    }

    /// Diminishing factor along each axis, end to end: `(mean leaf extent / root extent)^(1 / log2 n)`.
    pub fn alpha(&self) -> [f64; 3] {
        let leaves = self.nodes.iter().filter(|node| node.second == 0);
        let sum: DVec3 = leaves.map(|leaf| leaf.bounds.extents()).sum();
        let n = self.leaves() as f64;
        let ratio = (sum / n / self.extents()).to_array();
        ratio.map(|ratio| {
            if ratio > 0.0 {
                ratio.min(1.0).powf(1.0 / n.log2())
            } else {
                1.0
            }
        })
    }
}

/// A node of a tree that is somewhere.
#[derive(Clone, Copy)]
pub struct MeshNode<'t> {
    tree: &'t MeshTree,
    index: usize,
    shift: DVec3,
}

impl BinaryNode for MeshNode<'_> {
    fn overlaps(&self, other: &Self) -> bool {
        let (a, b) = (
            &self.tree.nodes[self.index].bounds,
            &other.tree.nodes[other.index].bounds,
        );
        let shift = other.shift - self.shift;
        a.min.cmple(b.max + shift).all() && (b.min + shift).cmple(a.max).all()
    }

    fn children(&self) -> Option<[Self; 2]> {
        let second = self.tree.nodes[self.index].second;
        (second > 0).then(|| [self.index + 1, second].map(|index| Self { index, ..*self }))
    }
}

const BINS: usize = 16;

/// Reorders the boxes and returns how many are on the first side, neither none nor all: the cheapest border between bins,
/// half and half where no border divides them.
fn partition(boxes: &mut [Aabb]) -> usize {
    let centers = Aabb::from_points(boxes.iter().map(Aabb::center));
    let extent = centers.extents();
    let bin = |b: &Aabb, axis: usize| {
        let share = (b.center()[axis] - centers.min[axis]) / extent[axis];
        ((share * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best = (f64::INFINITY, 0, 0);
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut bins = [(Aabb::EMPTY, 0.0); BINS];
        for b in &*boxes {
            let bin = &mut bins[bin(b, axis)];
            *bin = (bin.0.union(b), bin.1 + 1.0);
        }
        for border in 1..BINS {
            let side = |bins: &[(Aabb, f64)]| {
                let count: f64 = bins.iter().map(|bin| bin.1).sum();
                if count > 0.0 {
                    area(&union(bins.iter().map(|bin| &bin.0))) * count
                } else {
                    f64::INFINITY
                }
            };
            let cost = side(&bins[..border]) + side(&bins[border..]);
            if cost < best.0 {
                best = (cost, axis, border);
            }
        }
    }
    let (cost, axis, border) = best;
    let middle = boxes.len() / 2;
    if cost.is_infinite() {
        return middle;
    }
    let mut first = 0;
    for i in 0..boxes.len() {
        if bin(&boxes[i], axis) < border {
            boxes.swap(i, first);
            first += 1;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traversal::Visits;
    use punctual::shapes;

    #[test]
    fn every_triangle_is_a_leaf_and_every_box_holds_its_children() {
        let mesh = shapes::torus_knot(2, 3, 0.1, 48);
        let tree = MeshTree::new(&mesh, &DMat3::from_rotation_z(0.3));
        assert_eq!(tree.leaves(), mesh.len());
        assert_eq!(tree.nodes.len(), 2 * mesh.len() - 1);
        for (i, node) in tree
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.second > 0)
        {
            let both = tree.nodes[i + 1]
                .bounds
                .union(&tree.nodes[node.second].bounds);
            assert_eq!((both.min, both.max), (node.bounds.min, node.bounds.max));
        }
    }

    #[test]
    fn leaf_pairs_are_those_of_brute_force() {
        let mesh = shapes::icosphere(2);
        let tree = MeshTree::new(&mesh, &DMat3::IDENTITY);
        let shift = DVec3::new(0.9, 0.4, -0.3);
        let boxes = |i: usize, shift| Aabb::from_points(mesh.triangle(i).map(|x| x + shift));
        let meets = |i: usize, j: usize| boxes(i, DVec3::ZERO).intersects(&boxes(j, shift));
        let expected = (0..mesh.len())
            .map(|i| (0..mesh.len()).filter(|&j| meets(i, j)).count() as u64)
            .sum::<u64>();
        let visits = Visits::count(tree.root(DVec3::ZERO), tree.root(shift));
        assert_eq!(visits.leaf_pairs, expected);
        assert!(expected > 0);
    }

    #[test]
    fn equal_triangles_make_a_tree_too() {
        let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(corners, [[0, 1, 2]; 5]).unwrap();
        let tree = MeshTree::new(&mesh, &DMat3::IDENTITY);
        assert_eq!((tree.leaves(), tree.alpha()), (5, [1.0; 3]));
        assert_eq!(
            Visits::count(tree.root(DVec3::ZERO), tree.root(DVec3::ZERO)).leaf_pairs,
            25
        );
        assert_eq!(
            MeshTree::new(&Mesh::new(corners, [[0, 1, 2]]).unwrap(), &DMat3::IDENTITY).leaves(),
            1
        );
    }
}
