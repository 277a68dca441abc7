//! What lies next to a triangle: the triangles with which it shares its edges.
//!
//! Edges are compared by the indices of their vertices, not by where these lie, so that a refit leaves the neighbors as they
//! are. Open edges, cracks and soups lead nowhere; where many triangles share an edge, two and two of them are neighbors.

use super::wide::Node;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// What is known of a triangle: half a cache line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub(crate) struct Neighbors {
    /// What is on the other side of the edges 01, 12 and 20.
    pub across: [Across; 3],
    /// The first triangle of its cluster.
    pub first: u32,
    /// Its number in the input mesh.
    pub id: u32,
}

/// The other side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Across {
    /// The triangle there (tree order) times 8, plus its `entry`.
    code: u32,
    /// The vertex there that is not on the edge.
    pub vertex: u32,
}

impl Across {
    const NOTHING: Self = Self {
        code: NONE,
        vertex: 0,
    };

    /// Nothing where the number is too large, in a huge tree.
    fn new(triangle: u32, edge: u32, same_direction: bool, vertex: u32) -> Self {
        let code = triangle << 3 | u32::from(same_direction) << 2 | edge;
        if triangle < NONE >> 3 {
            Self { code, vertex }
        } else {
            Self::NOTHING
        }
    }

    /// Whether there is none.
    #[inline(always)]
    pub fn is_nothing(self) -> bool {
        self.code == NONE
    }

    #[inline(always)]
    pub fn triangle(self) -> u32 {
        self.code >> 3
    }

    /// Which of the edges of the other triangle it is, plus 4 if both triangles run along it in the same direction, so that they
    /// are turned differently.
    #[inline(always)]
    pub fn entry(self) -> usize {
        (self.code & 7) as usize
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

/// The neighbors of all triangles (tree order), whose `corners` are numbers below `vertices`. Expected `O(n)` time and memory.
///
/// Edges leave their list when they are met again, and their place is used anew: in the order of the tree few are open at a
/// time, so that all of it stays in the cache.
pub(super) fn neighbors(
    corners: &[[u32; 3]],
    vertices: usize,
    ids: &[u32],
    nodes: &[Node],
) -> Box<[Neighbors]> {
    let alone = |&id: &u32| Neighbors {
        across: [Across::NOTHING; 3],
        first: 0,
        id,
    };
    let mut all: Box<[Neighbors]> = ids.iter().map(alone).collect();
    for node in nodes.iter().filter(|node| node.is_cluster) {
        all[node.triangle_range()]
            .iter_mut()
            .for_each(|neighbors| neighbors.first = node.first_triangle);
    }
    let mut lists = alloc::vec![NONE; vertices];
    let (mut open, mut free): (Vec<Edge>, _) = (Vec::new(), NONE);
    for (triangle, &[p, q, r]) in (0..).zip(corners) {
        for (edge, [from, to, apex]) in (0..).zip([[p, q, r], [q, r, p], [r, p, q]]) {
            let (list, high) = (&mut lists[from.min(to) as usize], from.max(to));
            let (mut at, mut before) = (*list, NONE);
            while at != NONE && open[at as usize].high != high {
                (before, at) = (at, open[at as usize].next);
            }
            if at == NONE {
                let new = Edge {
                    high,
                    next: *list,
                    triangle,
                    edge,
                };
                if free == NONE {
                    *list = open.len() as u32;
                    open.push(new);
                } else {
                    *list = free;
                    free = core::mem::replace(&mut open[free as usize], new).next;
                }
                continue;
            }
            let Edge {
                next,
                triangle: other,
                edge: of_other,
                ..
            } = open[at as usize];
            if before == NONE {
                *list = next;
            } else {
                open[before as usize].next = next;
            }
            open[at as usize].next = core::mem::replace(&mut free, at);
            let there = corners[other as usize];
            let same_direction = there[of_other as usize] == from;
            let there = there[(of_other as usize + 2) % 3];
            all[triangle as usize].across[edge as usize] =
                Across::new(other, of_other, same_direction, there);
            all[other as usize].across[of_other as usize] =
                Across::new(triangle, edge, same_direction, apex);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, shapes};
    use crate::tree::{BuildOptions, Tree};

    fn tree(mesh: Mesh) -> Tree {
        Tree::with_options(mesh, &BuildOptions::default().neighbors(true))
    }

    fn corners(tree: &Tree, triangle: usize) -> [u32; 3] {
        tree.mesh().triangles()[tree.ids()[triangle] as usize]
    }

    /// The other triangles that have an edge, by brute force.
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
        for triangle in 0..tree.mesh().len() {
            let here = tree.neighbors()[triangle];
            assert_eq!(here.id, tree.ids()[triangle]);
            let [_, cluster] = tree.nodes_above(triangle as u32);
            assert_eq!(here.first, tree.nodes()[cluster as usize].first_triangle);
            for (edge, across) in here.across.iter().enumerate() {
                let expected = expected(tree, triangle, edge);
                if across.is_nothing() {
                    assert_ne!(expected.len(), 1);
                    continue;
                }
                let (other, there) = (across.triangle(), across.entry() & 3);
                assert!(expected.contains(&other) || other as usize == triangle);
                let back = tree.neighbors()[other as usize].across[there];
                assert_eq!(
                    (back.triangle() as usize, back.entry() & 3),
                    (triangle, edge)
                );
                let (here, there_all) = (corners(tree, triangle), corners(tree, other as usize));
                assert_eq!(across.vertex, there_all[(there + 2) % 3]);
                let first = if across.entry() >= 4 {
                    here[edge]
                } else {
                    here[(edge + 1) % 3]
                };
                assert_eq!(there_all[there], first);
                count += 1;
            }
        }
        count
    }

    #[test]
    fn each_edge_leads_to_the_other_triangle_that_has_it() {
        assert!(check(&tree(shapes::torus_knot(2, 3, 0.2, 24))) > 500);
        assert!(check(&tree(shapes::height_field(9, 1))) > 50);
    }

    #[test]
    fn edges_of_one_or_many_triangles_lead_to_others_that_have_them_or_nowhere() {
        // A fan around the edge 01, and the same triangle twice; enough of them for several clusters.
        let vertices = (0..40).map(|i| [i as f32, (i * i % 11) as f32, (i * i % 7) as f32]);
        let triangles = (2..38)
            .flat_map(|i| [[0, 1, i], [i, i + 1, i + 2]])
            .chain([[5, 6, 7], [3, 3, 9]]);
        let tree = tree(Mesh::new(vertices, triangles).unwrap());
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
        let tree = tree(Mesh::new(vertices, [[0, 1, 2], [1, 2, 3], [1, 3, 4]]).unwrap());
        assert_eq!(check(&tree), 4);
        let flipped = |i| {
            tree.neighbors()[i as usize]
                .across
                .iter()
                .filter(|across| across.entry() >= 4)
                .count()
        };
        assert!((0..3).map(flipped).sum::<usize>() > 0);
    }
}
