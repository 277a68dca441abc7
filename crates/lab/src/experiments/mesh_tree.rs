//! The binary AABB tree of a mesh as the paper has it: boxes along the axes, down to single triangles.
//!
//! The library's own trees are eight wide, their boxes turned to fit, and their leaves hold up to eight triangles; so the
//! paper's tree is built here. Splits by the surface-area heuristic over 16 bins an axis, `O(n log n)`.

use crate::offset::LevelShape;
use crate::traversal::BinaryNode;
use punctual::Mesh;
use punctual::glam::{DMat3, DVec3};

#[derive(Clone, Copy)]
struct Bounds {
    min: DVec3,
    max: DVec3,
}

impl Bounds {
    const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn area(self) -> f64 {
        let e = self.max - self.min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    fn center(self) -> DVec3 {
        (self.min + self.max) * 0.5
    }
}

struct Node {
    bounds: Bounds,
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
        let bounds = |i: usize| {
            let corners = mesh.triangle(i).map(|corner| *rotation * corner);
            corners
                .iter()
                .fold(Bounds::EMPTY, |b, &x| b.union(Bounds { min: x, max: x }))
        };
        let mut boxes: Vec<Bounds> = (0..mesh.len()).map(bounds).collect();
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * boxes.len()),
        };
        tree.split(&mut boxes);
        tree
    }

    fn split(&mut self, boxes: &mut [Bounds]) {
        let index = self.nodes.len();
        let bounds = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(*b));
        self.nodes.push(Node { bounds, second: 0 });
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
        self.nodes[0].bounds.max - self.nodes[0].bounds.min
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
        let sum: DVec3 = leaves.map(|leaf| leaf.bounds.max - leaf.bounds.min).sum();
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

    /// What each level below the root looks like around the root's centre; leaves of higher levels go down with it.
    pub fn levels(&self) -> Vec<LevelShape> {
        let mut levels = Vec::new();
        let mut nodes = self.below(&[0]);
        loop {
            let boxes = || nodes.iter().map(|&i| self.nodes[i].bounds);
            let count = nodes.len() as f64;
            let center = boxes().map(|b| b.center() - self.center()).sum::<DVec3>() / count;
            levels.push(LevelShape {
                count,
                half_extent: boxes().map(|b| (b.max - b.min) * 0.5).sum::<DVec3>() / count,
                center,
                variance: boxes()
                    .map(|b| (b.center() - self.center() - center).powf(2.0))
                    .sum::<DVec3>()
                    / count,
            });
            let next = self.below(&nodes);
            if next.len() == nodes.len() {
                return levels;
            }
            nodes = next;
        }
    }

    /// The children of some nodes, leaves for themselves.
    fn below(&self, nodes: &[usize]) -> Vec<usize> {
        let children = |&i: &usize| match self.nodes[i].second {
            0 => [Some(i), None],
            second => [Some(i + 1), Some(second)],
        };
        nodes.iter().flat_map(children).flatten().collect()
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
        (second > 0).then(|| {
            [
                Self {
                    index: self.index + 1,
                    ..*self
                },
                Self {
                    index: second,
                    ..*self
                },
            ]
        })
    }
}

const BINS: usize = 16;

/// Reorders the boxes and returns how many are on the first side, neither none nor all: the cheapest border between bins,
/// half and half where no border divides them.
fn partition(boxes: &mut [Bounds]) -> usize {
    let centers = boxes.iter().fold(Bounds::EMPTY, |all, b| {
        all.union(Bounds {
            min: b.center(),
            max: b.center(),
        })
    });
    let extent = centers.max - centers.min;
    let bin = |b: &Bounds, axis: usize| {
        let share = (b.center()[axis] - centers.min[axis]) / extent[axis];
        ((share * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best = (f64::INFINITY, 0, 0);
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut bins = [(Bounds::EMPTY, 0.0); BINS];
        for b in &*boxes {
            let bin = &mut bins[bin(b, axis)];
            *bin = (bin.0.union(*b), bin.1 + 1.0);
        }
        for border in 1..BINS {
            let side = |bins: &[(Bounds, f64)]| {
                let all = bins.iter().fold((Bounds::EMPTY, 0.0), |all, bin| {
                    (all.0.union(bin.0), all.1 + bin.1)
                });
                if all.1 > 0.0 {
                    all.0.area() * all.1
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
                .union(tree.nodes[node.second].bounds);
            assert_eq!((both.min, both.max), (node.bounds.min, node.bounds.max));
        }
        let levels = tree.levels();
        assert_eq!(
            (levels[0].count, levels[levels.len() - 1].count),
            (2.0, mesh.len() as f64)
        );
    }

    #[test]
    fn leaf_pairs_are_those_of_brute_force() {
        let mesh = shapes::icosphere(2);
        let tree = MeshTree::new(&mesh, &DMat3::IDENTITY);
        let shift = DVec3::new(0.9, 0.4, -0.3);
        let boxes = |i: usize, shift: DVec3| {
            let [a, b, c] = mesh.triangle(i).map(|x| x + shift);
            (a.min(b).min(c), a.max(b).max(c))
        };
        let meets = |i: usize, j: usize| {
            let ((a, b), (c, d)) = (boxes(i, DVec3::ZERO), boxes(j, shift));
            a.cmple(d).all() && c.cmple(b).all()
        };
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
