//! The oracle: what a traversal costs that opens only node pairs with an intersection below, the most rewarding first.
//!
//! It is simulated on the trees, by the engine's own rule of what to open and its weights of work, and tests no triangle
//! pair in vain. It shows how much an order could gain at most, not what one could reach.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use punctual::{Subtree, Tree, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST};

/// When the oracle finds what.
#[derive(Default)]
pub struct Oracle {
    /// Least work to a first intersection, and the BV tests in it; 0 if there is none.
    pub first_hit: [u64; 2],
    /// Work after which each pair is known, and its index among the true pairs; in order.
    pub found: Vec<(u64, u32)>,
}

impl Oracle {
    /// For a pose with the intersecting pairs `pairs`.
    pub fn new(a: &Places, b: &Places, pairs: &[[u32; 2]]) -> Self {
        let (Some(root_a), Some(root_b), false) = (a.tree.root(), b.tree.root(), pairs.is_empty()) else {
            return Self::default();
        };
        let scale = b.tree.unit_length() / a.tree.unit_length();
        let all: Vec<u32> = (0..pairs.len() as u32).collect();
        let alive = [&root_a, &root_b].map(|root| root.triangle_count() as usize);
        let root = Grower { places: [a, b], pairs, scale }.grow([root_a, root_b], alive, all);
        let mut oracle = Self { first_hit: root.first_hit(), found: Vec::with_capacity(pairs.len()) };
        let mut work = 0;
        let mut front = BinaryHeap::from([&root]);
        while let Some(branch) = front.pop() {
            work += branch.work;
            for &pair in &branch.pairs {
                work += WORK_PER_TRIANGLE_TEST;
                oracle.found.push((work, pair));
            }
            front.extend(&branch.children);
        }
        oracle
    }
}

/// A node pair with intersections below.
struct Branch {
    work: u64,
    bv_tests: u64,
    children: Vec<Branch>,
    /// Indices of its pairs, where both nodes are clusters.
    pairs: Vec<u32>,
    /// Intersections below, and the work to find them all.
    total: (u64, u64),
}

impl Branch {
    fn first_hit(&self) -> [u64; 2] {
        let below = self.children.iter().map(Self::first_hit).min();
        let below = below.unwrap_or([WORK_PER_TRIANGLE_TEST, 0]);
        [self.work + below[0], self.bv_tests + below[1]]
    }
}

/// More intersections for the work come first.
impl Ord for Branch {
    fn cmp(&self, other: &Self) -> Ordering {
        let product = |hits: u64, work: u64| u128::from(hits) * u128::from(work);
        product(self.total.0, other.total.1).cmp(&product(other.total.0, self.total.1))
    }
}

impl PartialOrd for Branch {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Branch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Branch {}

/// The place of each triangle in the order of the tree.
pub struct Places<'t> {
    tree: &'t Tree,
    place: Vec<u32>,
}

impl<'t> Places<'t> {
    pub fn new(tree: &'t Tree) -> Self {
        let mut place = vec![0; tree.mesh().len()];
        for (at, id) in (0..).zip(tree.root().iter().flat_map(Subtree::triangles)) {
            place[id as usize] = at;
        }
        Self { tree, place }
    }

    fn of(&self, triangle: u32) -> u32 {
        self.place[triangle as usize]
    }

    /// The children with the places where they begin.
    fn children(&self, node: Subtree<'t>) -> Vec<(u32, Subtree<'t>)> {
        let begin = |child: &Subtree| child.triangles().next().map_or(0, |id| self.of(id));
        let mut children: Vec<_> = node.children().map(|child| (begin(&child), child)).collect();
        children.sort_unstable_by_key(|(begin, _)| *begin);
        children
    }
}

struct Grower<'g, 't> {
    places: [&'g Places<'t>; 2],
    pairs: &'g [[u32; 2]],
    /// Length of B's unit in A's.
    scale: f64,
}

impl<'t> Grower<'_, 't> {
    /// The branch of a node pair with the intersections `pairs`; of clusters `alive` triangles are left.
    fn grow(&self, nodes: [Subtree<'t>; 2], mut alive: [usize; 2], pairs: Vec<u32>) -> Branch {
        let opened = self.opened(&nodes);
        let clusters = nodes.map(|node| node.is_cluster());
        let children = [0, 1].map(|side| self.places[side].children(nodes[side]));
        let tested = [0, 1].map(|side| if clusters[side] { alive[side] } else { children[side].len() });
        let [a, b] = [0, 1].map(|side| if opened[side] { tested[side] } else { 1 });
        let bv_tests = (a * b + 1) as u64;
        let mut branch =
            Branch { work: WORK_PER_EXPANSION + bv_tests, bv_tests, children: vec![], pairs: vec![], total: (0, 0) };
        let count = pairs.len() as u64;
        let mut below = 0;
        if clusters == [true; 2] {
            below += count * WORK_PER_TRIANGLE_TEST;
            branch.pairs = pairs;
        } else {
            for (places, pairs) in self.groups(&children, opened, pairs) {
                let child = |side: usize| places[side].map_or(nodes[side], |at| children[side][at].1);
                for side in [0, 1] {
                    if opened[side] && clusters[side] {
                        alive[side] = self.distinct(side, &pairs);
                    }
                }
                let next = [child(0), child(1)];
                let left =
                    [0, 1].map(|side| if clusters[side] { alive[side] } else { next[side].triangle_count() as usize });
                branch.children.push(self.grow(next, left, pairs));
            }
            below += branch.children.iter().map(|child| child.total.1).sum::<u64>();
        }
        branch.total = (count, branch.work + below);
        branch
    }

    /// Which sides are opened, by the rule of the engine; a cluster that is opened into triangles stays whole.
    fn opened(&self, [a, b]: &[Subtree; 2]) -> [bool; 2] {
        const LARGER: f64 = 6.0;
        let size = |node: &Subtree| {
            let [x, y, z] = node.half_extents().as_dvec3().to_array();
            (x * y + y * z + z * x).sqrt()
        };
        let (size_a, size_b) = (size(a), size(b) * self.scale);
        match (a.is_cluster(), b.is_cluster()) {
            (true, true) => [true, true],
            (true, false) => [size_a > size_b, true],
            (false, true) => [true, size_b > size_a],
            (false, false) => [size_b <= LARGER * size_a, size_a <= LARGER * size_b],
        }
    }

    /// The intersections by the pair of children that they lie under; `None` for a side that stays.
    fn groups(
        &self,
        children: &[Vec<(u32, Subtree<'t>)>; 2],
        opened: [bool; 2],
        pairs: Vec<u32>,
    ) -> Vec<([Option<usize>; 2], Vec<u32>)> {
        let under = |pair: u32| {
            [0, 1].map(|side| {
                let place = self.places[side].of(self.pairs[pair as usize][side]);
                let after = children[side].partition_point(|(begin, _)| *begin <= place);
                if opened[side] { after.checked_sub(1) } else { None }
            })
        };
        let mut keyed: Vec<_> = pairs.into_iter().map(|pair| (under(pair), pair)).collect();
        keyed.sort_unstable();
        let groups = keyed.chunk_by(|x, y| x.0 == y.0);
        groups.map(|group| (group[0].0, group.iter().map(|(_, pair)| *pair).collect())).collect()
    }

    fn distinct(&self, side: usize, pairs: &[u32]) -> usize {
        let mut ids: Vec<u32> = pairs.iter().map(|&pair| self.pairs[pair as usize][side]).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.len()
    }
}
