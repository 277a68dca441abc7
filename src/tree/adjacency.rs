//! What lies next to a triangle: the clusters of the triangles with which it shares its edges.
//!
//! Edges are compared by the indices of their vertices, not by where these lie, so that a refit leaves the neighbors as they
//! are. Open edges, cracks and soups lead nowhere; where many triangles share an edge, two and two of them are neighbors.

use super::wide::Node;
use crate::mesh::Mesh;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// The cluster of a triangle, and those across its edges. 12 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Neighbors {
    cluster: u32,
    /// How far off in the list of nodes the others are, [`BITS`] each, the lowest for edge 01; 0 if there is none to go to.
    steps: [u32; 2],
}

const BITS: u32 = 21;

impl Neighbors {
    /// The cluster (a node) in which the triangle itself lies.
    #[inline(always)]
    pub fn cluster(self) -> u32 {
        self.cluster
    }

    /// How far off the cluster on the other side of edge 01, 12 or 20 is in the list of nodes; 0 if there is none, or it is
    /// the same. To be added modulo 2^32.
    #[inline(always)]
    pub fn step(self, edge: u32) -> u32 {
        let steps = u64::from(self.steps[0]) | u64::from(self.steps[1]) << 32;
        ((steps << (u64::BITS - BITS - BITS * edge)) as i64 >> (u64::BITS - BITS)) as u32
    }

    /// Sets the cluster on the other side of an edge. One that is too far off in a huge tree is left out.
    fn set(&mut self, edge: u32, cluster: u32) {
        let step = i64::from(cluster) - i64::from(self.cluster);
        let step = if step.unsigned_abs() < 1 << (BITS - 1) { step as u64 & ((1 << BITS) - 1) } else { 0 };
        let steps = step << (BITS * edge);
        self.steps[0] |= steps as u32;
        self.steps[1] |= (steps >> 32) as u32;
    }
}

const NONE: u32 = u32::MAX;

/// An edge of the mesh that has been met once, in the list of its lower vertex.
#[derive(Clone, Copy)]
struct Edge {
    high: u32,
    next: u32,
    triangle: u32,
    edge: u32,
}

/// The neighbors of all triangles (tree order). Expected `O(n)` time and memory.
///
/// Edges leave their list when they are met again, and their place is used anew: in the order of the tree few are open at a
/// time, so that all of it stays in the cache.
pub(super) fn neighbors(mesh: &Mesh, ids: &[u32], nodes: &[Node]) -> Box<[Neighbors]> {
    let mut all = alloc::vec![Neighbors { cluster: 0, steps: [0; 2] }; ids.len()].into_boxed_slice();
    for (index, node) in (0..).zip(nodes) {
        if node.is_cluster {
            all[node.triangle_range()].iter_mut().for_each(|neighbors| neighbors.cluster = index);
        }
    }
    let mut lists = alloc::vec![NONE; mesh.vertex_count()];
    let (mut open, mut free): (Vec<Edge>, _) = (Vec::new(), NONE);
    for (triangle, &id) in (0..).zip(ids) {
        let [p, q, r] = mesh.triangles()[id as usize];
        for (edge, [from, to]) in (0..).zip([[p, q], [q, r], [r, p]]) {
            let (list, high) = (&mut lists[from.min(to) as usize], from.max(to));
            let (mut at, mut before) = (*list, NONE);
            while at != NONE && open[at as usize].high != high {
                (before, at) = (at, open[at as usize].next);
            }
            if at == NONE {
                let new = Edge { high, next: *list, triangle, edge };
                if free == NONE {
                    *list = open.len() as u32;
                    open.push(new);
                } else {
                    *list = free;
                    free = core::mem::replace(&mut open[free as usize], new).next;
                }
                continue;
            }
            let Edge { next, triangle: other, edge: of_other, .. } = open[at as usize];
            if before == NONE {
                *list = next;
            } else {
                open[before as usize].next = next;
            }
            open[at as usize].next = core::mem::replace(&mut free, at);
            let clusters = [triangle, other].map(|triangle| all[triangle as usize].cluster);
            all[triangle as usize].set(edge, clusters[1]);
            all[other as usize].set(of_other, clusters[0]);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::tree::{BuildOptions, Tree};

    fn tree(mesh: Mesh) -> Tree {
        Tree::with_options(mesh, &BuildOptions::default().neighbors(true))
    }

    fn across(neighbors: Neighbors, edge: u32) -> Option<u32> {
        let step = neighbors.step(edge);
        (step != 0).then(|| neighbors.cluster.wrapping_add(step))
    }

    /// The clusters of the other triangles that have an edge, by brute force.
    fn expected(tree: &Tree, triangle: usize, edge: usize) -> Vec<u32> {
        let corners = |triangle: usize| tree.mesh().triangles()[tree.ids()[triangle] as usize];
        let ends = [corners(triangle)[edge], corners(triangle)[(edge + 1) % 3]];
        let same = |[x, y]: [u32; 2]| [x, y] == ends || [y, x] == ends;
        let has = |&other: &usize| [[0, 1], [1, 2], [2, 0]].iter().any(|e| same(e.map(|i| corners(other)[i])));
        let cluster = |triangle: usize| tree.nodes_above(triangle as u32)[1];
        (0..tree.mesh().len()).filter(|&other| other != triangle).filter(has).map(cluster).collect()
    }

    fn check(tree: &Tree) -> usize {
        let mut count = 0;
        for triangle in 0..tree.mesh().len() {
            let neighbors = tree.neighbors(triangle as u32).unwrap();
            for edge in 0..3 {
                let expected = expected(tree, triangle, edge);
                match (across(neighbors, edge as u32), &expected[..]) {
                    (Some(across), others) => {
                        assert!(others.contains(&across));
                        count += 1;
                    }
                    (None, [other]) => assert_eq!(*other, neighbors.cluster()),
                    (None, _) => {}
                }
            }
        }
        count
    }

    #[test]
    fn each_edge_leads_to_the_cluster_of_the_other_triangle_that_has_it() {
        assert!(check(&tree(shapes::torus_knot(2, 3, 0.2, 24))) > 500);
        assert!(check(&tree(shapes::height_field(9, 1))) > 50);
    }

    #[test]
    fn edges_of_one_or_many_triangles_lead_to_others_that_have_them_or_nowhere() {
        // A fan around the edge 01, and the same triangle twice; enough of them for several clusters.
        let vertices = (0..40).map(|i| [i as f32, (i * i % 11) as f32, (i * i % 7) as f32]);
        let triangles = (2..38).flat_map(|i| [[0, 1, i], [i, i + 1, i + 2]]).chain([[5, 6, 7], [3, 3, 9]]);
        let tree = tree(Mesh::new(vertices, triangles).unwrap());
        assert!(tree.nodes().len() > 5);
        check(&tree);
    }

    #[test]
    fn steps_are_kept_in_both_directions_as_far_as_they_fit() {
        let mut neighbors = Neighbors { cluster: 3_000_000, steps: [0; 2] };
        neighbors.set(0, 3_000_000 - (1 << 20) + 1);
        neighbors.set(1, 3_000_000 + (1 << 20) - 1);
        neighbors.set(2, 2_999_999);
        let all = |neighbors: Neighbors| [0, 1, 2].map(|edge| across(neighbors, edge));
        assert_eq!(all(neighbors), [Some(1_951_425), Some(4_048_575), Some(2_999_999)]);
        let mut neighbors = Neighbors { cluster: 3_000_000, steps: [0; 2] };
        neighbors.set(1, 3_000_000 + (1 << 20));
        assert_eq!(all(neighbors), [None; 3]);
    }
}
