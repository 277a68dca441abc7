//! The neighbors of a triangle: the triangles with which it shares its edges.
//!
//! Edges are compared by the indices of their vertices, not by positions, so a refit does not
//! change the neighbors. There are no neighbors across open edges and cracks, in soups, and for
//! triangles that use a vertex twice. Where many triangles share an edge, they become neighbors two
//! by two.
//!
//! An edge waits in a hash table for its other triangle, which usually comes soon in tree order.
//! Each slot has room for one edge; a later edge takes it over. Edges that lost their slot are
//! searched again with other hashes. So the work is `O(n)` for all meshes, and in a large mesh some
//! edges in 10,000 are not found. Whether an edge was met before cannot be predicted, so there is
//! no branch on it.

use crate::tree::wide::Node;
use crate::tree::{Tree, WIDTH};
use alloc::boxed::Box;
use core::hint::select_unpredictable;
use core::mem;

/// For each of the edges 01, 12 and 20, the triangle behind it (tree order) times 8. The low three
/// bits of the first entry are the position of this triangle in its leaf.
pub(crate) type Neighbors = [u32; 3];

/// The neighbors of a triangle whose second and third corners change places.
pub(crate) fn reverse(neighbors: &mut Neighbors) {
    let place = neighbors[0] & 7;
    neighbors[0] -= place;
    neighbors.swap(0, 2);
    neighbors[0] += place;
}

/// Stands for no triangle. Trees with this many triangles or more have no neighbors.
const NONE: u32 = u32::MAX >> 3;

const _: () = assert!(WIDTH == 8);

impl Tree {
    /// The triangle behind an edge of a triangle (tree order), if there is one. The edge goes from
    /// corner `edge` to the next.
    #[inline(always)]
    pub fn across(&self, triangle: u32, edge: usize) -> Option<u32> {
        // A cloud has none.
        let next = self.neighbors.get(triangle as usize)?[edge] >> 3;
        (next != NONE).then_some(next)
    }

    /// The vertex of the triangle `next` that is not on the edge it shares with `triangle` (both in
    /// tree order). `apex` is the vertex of `triangle` that is not on that edge.
    #[inline(always)]
    pub fn vertex_across(&self, triangle: u32, apex: u32, next: u32) -> u32 {
        let [[a, b, c], [p, q, r]] = [triangle, next].map(|at| self.vertices_of(at));
        a ^ b ^ c ^ apex ^ p ^ q ^ r
    }

    /// The first triangle of the leaf that contains a triangle (tree order).
    #[inline(always)]
    pub(crate) fn first_of_leaf(&self, triangle: u32) -> u32 {
        match self.neighbors.get(triangle as usize) {
            Some(neighbors) => triangle - (neighbors[0] & 7),
            None => self.first_of_block(triangle),
        }
    }
}

/// Factors of the hashes, tried one after the other.
const FACTORS: [u64; 3] = [
    0x9e37_79b9_7f4a_7c15,
    0xc2b2_ae3d_27d4_eb4f,
    0x1656_67b1_9e37_79f9,
];

/// An edge that waits for its other triangle.
#[derive(Clone, Copy)]
struct Open {
    /// The indices of its vertices, the lower one first.
    ends: u64,
    /// Index of the edge: three times its triangle, plus 0, 1 or 2.
    edge: u32,
    triangle: u32,
}

const FREE: Open = Open {
    ends: u64::MAX,
    edge: 0,
    triangle: 0,
};

/// The neighbors of all triangles (tree order). `O(n)` time and memory.
pub(crate) fn neighbors(corners: &[[u32; 3]], nodes: &[Node]) -> Box<[Neighbors]> {
    let mut rows = alloc::vec![[NONE << 3; 3]; corners.len()].into_boxed_slice();
    if corners.len() < NONE as usize {
        let bits = (corners.len() / 8).max(64).ilog2() + 1;
        let mut slots = alloc::vec![FREE; 1 << bits];
        let mut lost = link::<true>(corners, &mut rows, &mut slots, FACTORS[0]);
        for &factor in &FACTORS[1..] {
            // A soup has no shared edges to find.
            if lost == 0 || rows.iter().all(|row| *row == [NONE << 3; 3]) {
                break;
            }
            slots.fill(FREE);
            lost = link::<false>(corners, &mut rows, &mut slots, factor);
        }
    }
    for node in nodes.iter().filter(|node| node.is_leaf) {
        for (place, row) in (0..).zip(&mut rows[node.triangle_range()]) {
            row[0] |= place;
        }
    }
    rows
}

/// Links triangles that share an edge, for edges without a known neighbor. In the `FIRST` call
/// these are all edges. Returns the number of edges that lost their slot.
#[inline(always)]
fn link<const FIRST: bool>(
    corners: &[[u32; 3]],
    rows: &mut [Neighbors],
    slots: &mut [Open],
    factor: u64,
) -> usize {
    let (mut lost, shift) = (0, (slots.len() as u64).leading_zeros() + 1);
    let mut meet = |rows: &mut [Neighbors], triangle: u32, edge: u32, from: u32, to: u32| {
        let ends = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
        let slot = &mut slots[(ends.wrapping_mul(factor) >> shift) as usize];
        let other = mem::replace(
            slot,
            Open {
                ends,
                edge,
                triangle,
            },
        );
        let met = other.ends == ends;
        lost += usize::from(!met & (other.ends != FREE.ends));
        slot.ends = select_unpredictable(met, FREE.ends, ends);
        let rows = rows.as_flattened_mut();
        rows[edge as usize] = select_unpredictable(met, other.triangle, NONE) << 3;
        let edge = select_unpredictable(met, other.edge, edge);
        rows[edge as usize] = select_unpredictable(met, triangle, NONE) << 3;
    };
    for (triangle, &[p, q, r]) in (0u32..).zip(corners) {
        let is_open = rows[triangle as usize].map(|across| FIRST || across == NONE << 3);
        if is_open == [false; 3] || p == q || q == r || r == p {
            continue;
        }
        let edge = 3 * triangle;
        if is_open[0] {
            meet(rows, triangle, edge, p, q);
        }
        if is_open[1] {
            meet(rows, triangle, edge + 1, q, r);
        }
        if is_open[2] {
            meet(rows, triangle, edge + 2, r, p);
        }
    }
    lost
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, shapes};

    fn corners(tree: &Tree, triangle: usize) -> [u32; 3] {
        tree.mesh().triangles()[tree.ids()[triangle] as usize]
    }

    /// The other triangles that contain an edge, by brute force.
    fn expected(tree: &Tree, triangle: usize, edge: usize) -> Vec<u32> {
        let ends = [
            corners(tree, triangle)[edge],
            corners(tree, triangle)[(edge + 1) % 3],
        ];
        let same = |[x, y]: [u32; 2]| [x, y] == ends || [y, x] == ends;
        let has = |&other: &usize| {
            let corners = corners(tree, other);
            [[0, 1], [1, 2], [2, 0]]
                .iter()
                .any(|e| same(e.map(|i| corners[i])))
        };
        (0..tree.mesh().len())
            .filter(|&other| other != triangle)
            .filter(has)
            .map(|other| other as u32)
            .collect()
    }

    fn check(tree: &Tree) -> usize {
        let mut count = 0;
        for triangle in 0..tree.mesh().len() as u32 {
            let [_, leaf] = tree.nodes_above(triangle);
            assert_eq!(
                tree.first_of_leaf(triangle),
                tree.nodes()[leaf as usize].first_triangle
            );
            let here = tree.vertices_of(triangle);
            for edge in 0..3 {
                let expected = expected(tree, triangle as usize, edge);
                let Some(next) = tree.across(triangle, edge) else {
                    assert_ne!(expected.len(), 1);
                    continue;
                };
                assert!(expected.contains(&next));
                assert!((0..3).any(|back| tree.across(next, back) == Some(triangle)));
                let there = tree.vertices_of(next);
                let vertex = tree.vertex_across(triangle, here[(edge + 2) % 3], next);
                let ends = [here[edge], here[(edge + 1) % 3]];
                assert!(there.contains(&vertex) && !ends.contains(&vertex));
                count += 1;
            }
        }
        count
    }

    #[test]
    fn each_edge_leads_to_the_other_triangle_that_has_it() {
        assert!(check(&Tree::new(shapes::torus_knot(2, 3, 0.2, 24))) > 500);
        assert!(check(&Tree::new(shapes::height_field(9, 1))) > 50);
    }

    #[test]
    fn edges_of_one_or_many_triangles_lead_to_others_that_have_them_or_nowhere() {
        // A fan around the edge 01, and one triangle twice; enough triangles for several leaves.
        let vertices = (0..40).map(|i| [i as f32, (i * i % 11) as f32, (i * i % 7) as f32]);
        let triangles = (2..38)
            .flat_map(|i| [[0, 1, i], [i, i + 1, i + 2]])
            .chain([[5, 6, 7], [3, 3, 9]]);
        let tree = Tree::new(Mesh::new(vertices, triangles).unwrap());
        assert!(tree.nodes().len() > 5);
        check(&tree);
    }

    #[test]
    fn triangles_turned_differently_are_neighbors_too() {
        let vertices = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.5],
            [2.0, 0.0, 0.0],
        ];
        let tree = Tree::new(Mesh::new(vertices, [[0, 1, 2], [1, 2, 3], [1, 3, 4]]).unwrap());
        assert_eq!(check(&tree), 4);
    }
}
