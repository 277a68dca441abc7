//! Marching: where triangles meet, their neighbors are likely to meet too.
//!
//! Triangle pairs that meet lie on curves. Where an edge of one triangle crosses the other, the neighbor across that edge
//! meets the other triangle too. So the pair of clusters in which it lies is visited next: the traversal follows the curve
//! from cluster to cluster, and finds in each what it would have found there later. Nothing is tested twice: a pair of
//! clusters that has been visited ([`visited`](super::visited)) is passed over when its turn comes.
//!
//! A lead is only a hint: it may be lost, or lead nowhere, and the answer stays the same.

use super::queue::Pair;
use super::visited::Visited;
use crate::math::bits;
use crate::tree::Tree;

/// Leads that wait; those beyond are lost.
const LEADS: usize = 64;

/// Any edge of two triangles that meet may cross the other one.
pub(super) const ALL_EDGES: u32 = 0b111_111;

/// The state of marching in a workspace.
#[derive(Clone, Debug)]
pub(super) struct March {
    visited: Visited,
    /// Cluster pairs to which curves lead, the latest last.
    leads: [[u32; 2]; LEADS],
    waiting: usize,
}

impl March {
    pub fn new(capacity: usize) -> Self {
        Self { visited: Visited::new(capacity), leads: [[0; 2]; LEADS], waiting: 0 }
    }

    pub fn clear(&mut self) {
        self.visited.clear();
        self.waiting = 0;
    }

    /// Takes over which pairs have been visited, and no leads.
    pub fn copy_visits(&mut self, other: &Self) {
        self.visited.copy_from(&other.visited);
        self.waiting = 0;
    }

    /// The latest lead.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<Pair> {
        self.waiting = self.waiting.checked_sub(1)?;
        let [a, b] = self.leads[self.waiting % LEADS];
        Some(Pair::new(a, b))
    }

    /// Takes note of a visit to a pair of nodes, if both are clusters. False if it has been visited before.
    #[inline(always)]
    pub fn visit(&mut self, pair: [u32; 2], are_clusters: impl FnOnce() -> bool) -> bool {
        let is_new = self.visited.add(pair, are_clusters);
        if self.visited.is_full() {
            // What can't be noted might be visited again.
            self.waiting = 0;
        }
        is_new
    }

    /// Whether a pair of clusters has been visited, as far as is known.
    pub fn has_visited(&self, pair: [u32; 2]) -> bool {
        self.visited.contains(pair)
    }

    /// Takes note of where curves lead from two triangles (tree order) that meet, and of which these edges may cross the other
    /// one: a bit each for 01, 12 and 20 of A, then those of B.
    ///
    /// Without branches on what can't be predicted: which edges cross, and which of them lead out of the cluster.
    // Seldom asked for, and so out of the loop.
    #[inline(never)]
    pub fn lead(&mut self, [a, b]: [&Tree; 2], pair: [u32; 2], crossings: u32) {
        let (Some(of_a), Some(of_b)) = (a.neighbors(pair[0]), b.neighbors(pair[1])) else { return };
        if self.visited.is_full() {
            return;
        }
        let neighbors = [of_a, of_b];
        for edge in bits(crossings) {
            let side = usize::from(edge >= 3);
            let step = neighbors[side].step((edge - 3 * side) as u32);
            let mut lead = neighbors.map(|of| of.cluster());
            lead[side] = lead[side].wrapping_add(step);
            let is_new = step != 0 && !self.visited.contains(lead);
            self.leads[self.waiting % LEADS] = lead;
            self.waiting = (self.waiting + usize::from(is_new)).min(LEADS - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, shapes};
    use crate::tree::BuildOptions;

    fn tree(mesh: Mesh) -> Tree {
        Tree::with_options(mesh, &BuildOptions::default().neighbors(true))
    }

    /// A triangle with a neighbor in another cluster across edge 01, 12 or 20.
    fn border(tree: &Tree, edge: u32) -> u32 {
        let leads_out = |&triangle: &u32| tree.neighbors(triangle).unwrap().step(edge) != 0;
        (0..tree.mesh().len() as u32).find(leads_out).unwrap()
    }

    #[test]
    fn a_crossing_leads_to_the_cluster_across_its_edge_until_that_is_visited() {
        let (a, b) = (tree(shapes::icosphere(2)), tree(shapes::torus(1.0, 0.3, 12)));
        for (bit, tree) in [(1, &a), (5, &b)] {
            let mut march = March::new(8);
            let pair = if bit < 3 { [border(tree, 1), 0] } else { [0, border(tree, 2)] };
            let mut expected = [a.neighbors(pair[0]).unwrap().cluster(), b.neighbors(pair[1]).unwrap().cluster()];
            let side = bit / 3;
            expected[side] = expected[side].wrapping_add(tree.neighbors(pair[side]).unwrap().step(bit as u32 % 3));
            march.lead([&a, &b], pair, 1 << bit);
            assert_eq!(march.pop(), Some(Pair::new(expected[0], expected[1])));
            assert_eq!(march.pop(), None);
            assert!(march.visit(expected, || true) && !march.visit(expected, || true));
            assert!(march.has_visited(expected));
            march.lead([&a, &b], pair, 1 << bit);
            assert_eq!(march.pop(), None);
        }
    }

    #[test]
    fn leads_end_when_visits_cannot_be_noted_any_more() {
        let tree = tree(shapes::icosphere(2));
        let mut march = March::new(2);
        assert!(march.visit([9, 9], || true));
        let pair = [border(&tree, 0); 2];
        march.lead([&tree, &tree], pair, 1);
        assert!(march.visit([8, 8], || true));
        assert_eq!(march.pop(), None);
        march.lead([&tree, &tree], pair, 1);
        assert_eq!(march.pop(), None);
        assert!(march.visit([7, 7], || true) && march.visit([7, 7], || true) && !march.visit([8, 8], || true));
    }

    #[test]
    fn more_leads_than_fit_are_dropped() {
        let tree = tree(shapes::icosphere(4));
        let mut march = March::new(8);
        for triangle in 0..tree.mesh().len() as u32 {
            march.lead([&tree, &tree], [triangle; 2], ALL_EDGES);
        }
        assert_eq!(core::iter::from_fn(|| march.pop()).count(), LEADS - 1);
    }
}
