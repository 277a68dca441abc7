//! The tree of fat AABBs, and its search for overlapping pairs, in steps, so that a frame may end
//! between any two of them.

use super::build::Build;
use super::node::{NONE, Node, Proxy};
use crate::body::Bodies;
use crate::cost::{WORK_PER_REFIT, WORK_PER_SEARCH};
use crate::facts::Change;
use crate::id::{PairKey, pair_key};
use crate::room::reserve;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use punctual::engine::Deadline;
use punctual_geom::Aabb;

/// The tree is rebuilt after this many moves out of a fat AABB per body, on average.
const MOVES_BEFORE_REBUILD: usize = 6;

/// If the new bodies are more than one per this many nodes, all nodes are refitted in order.
const SWEPT_PART: usize = 16;

/// Nodes, or pairs of nodes, per step; and nodes per step of a refit of all, which takes as long.
const STEP: usize = 16;
const SWEEP: usize = 128;

#[derive(Clone, Debug, Default)]
pub(crate) struct FatTree {
    nodes: Vec<Node>,
    /// The root of the tree, then a one-leaf tree for each body inserted or teleported since the
    /// last rebuild.
    roots: Vec<u32>,
    /// Number of generations of newcomers since the last rebuild, and number of their moves.
    generation: u16,
    moves: usize,
    build: Build,
    /// True if so many bodies are new that all nodes are refitted instead of paths; and the number
    /// of nodes still to refit.
    sweeps: bool,
    unswept: usize,
    /// `inner`: nodes to refit, parents first. `stack`: node pairs to visit, by the refit and then
    /// by the search.
    inner: Vec<u32>,
    stack: Vec<[u32; 2]>,
    /// The next two roots to search against each other, as indices of `roots`.
    next_roots: [usize; 2],
}

impl FatTree {
    /// Reserves room for bodies of indices below `bodies`.
    ///
    /// A tree has less than `2 bodies` nodes. Besides its root there are at most the roots that
    /// [`FatTree::begin_update`] allows, less than `bodies + 64`, and those of bodies that came in
    /// this generation. A step of the search adds at most three pairs of nodes for each pair that
    /// it opens, one level deeper. The tree is balanced and has fewer levels than this allows for.
    pub fn reserve(&mut self, bodies: usize) {
        reserve(&mut self.roots, 2 * bodies + 64);
        reserve(&mut self.nodes, 4 * bodies + 64);
        reserve(&mut self.inner, bodies);
        let levels = 2 * bodies.max(1).ilog2() as usize + 8;
        reserve(&mut self.stack, 3 * STEP * levels);
        self.build.reserve(bodies);
    }

    pub fn begin_generation(&mut self, newcomers: usize) {
        self.generation += 1;
        self.sweeps = SWEPT_PART * newcomers > self.nodes.len();
    }

    /// Updates a body's leaf to its fat AABB. If they do not overlap, because the body was
    /// teleported, moves the body to a one-leaf tree.
    pub fn renew(&mut self, body: u32, proxy: &mut Proxy) {
        self.moves += 1;
        let is_near = self.bounds(proxy).intersects(&proxy.fat);
        if (proxy.leaf as usize) < self.nodes.len() {
            self.set_leaf(
                proxy.leaf,
                if is_near { proxy.fat } else { Aabb::EMPTY },
                proxy.moving,
            );
            if is_near {
                return;
            }
        }
        proxy.leaf = NONE;
        if !proxy.fat.is_empty() {
            proxy.leaf = self.nodes.len() as u32;
            self.roots.push(proxy.leaf);
            self.nodes
                .push(Node::leaf(body, proxy, NONE, self.generation));
        }
    }

    /// Sets a leaf, and marks the path to it as new, unless all nodes will be visited.
    fn set_leaf(&mut self, leaf: u32, bounds: Aabb, moving: bool) {
        let node = &mut self.nodes[leaf as usize];
        (node.bounds, node.moving) = (bounds, moving);
        if self.sweeps {
            node.newest = self.generation;
            return;
        }
        let mut at = leaf;
        while let Some(node) = self
            .nodes
            .get_mut(at as usize)
            .filter(|node| node.newest != self.generation)
        {
            node.newest = self.generation;
            at = node.parent;
        }
    }

    /// The box of a body in the tree; empty if it has none.
    pub fn bounds(&self, proxy: &Proxy) -> Aabb {
        self.nodes
            .get(proxy.leaf as usize)
            .map_or(Aabb::EMPTY, |leaf| leaf.bounds)
    }

    /// Roots of the trees, each with its box.
    pub fn roots(&self) -> impl Iterator<Item = (u32, &Aabb)> {
        self.roots
            .iter()
            .map(|&root| (root, &self.nodes[root as usize].bounds))
    }

    /// The children of a node with their boxes, or the body of a leaf.
    pub fn below(&self, at: u32) -> Result<[(u32, &Aabb); 2], u32> {
        let node = &self.nodes[at as usize];
        let child = |at: u32| (at, &self.nodes[at as usize].bounds);
        if node.second == NONE {
            Err(node.body)
        } else {
            Ok([child(at + 1), child(node.second)])
        }
    }

    /// Starts an update of the tree after its newcomers were renewed. `bodies` bounds their
    /// indices. Returns true if the tree must be rebuilt.
    pub fn begin_update(&mut self, bodies: usize) -> bool {
        // Left over if the last search was ended for lack of room.
        self.stack.clear();
        let leaves = self.nodes.len() / 2;
        let outgrown = self.roots.len().pow(2) > leaves + 64
            || self.moves > MOVES_BEFORE_REBUILD * leaves + 64
            || self.generation == u16::MAX;
        if outgrown {
            (self.generation, self.moves) = (1, 0);
            self.roots.clear();
            self.nodes.clear();
            self.build.begin(bodies);
        } else if self.sweeps {
            self.unswept = self.nodes.len();
        } else {
            self.stack.extend(self.roots.iter().map(|&root| [root; 2]));
        }
        outgrown
    }

    /// Builds the tree of all bodies; true if done.
    pub fn build(
        &mut self,
        proxies: &mut [Proxy],
        news: &[Change],
        deadline: &mut Deadline,
    ) -> bool {
        let done = self
            .build
            .advance(&mut self.nodes, proxies, news, self.generation, deadline);
        if done && !self.nodes.is_empty() {
            self.roots.push(0);
        }
        self.unswept = self.nodes.len();
        done
    }

    /// Refits the boxes above new ones; true if done. Then a search may begin.
    pub fn refit(&mut self, deadline: &mut Deadline) -> bool {
        const WORK: u64 = STEP as u64 * WORK_PER_REFIT;
        while self.unswept > 0 {
            if !deadline.has_room(WORK) {
                return false;
            }
            // Children come after their parents, and access in order is fast.
            let first = self.unswept.saturating_sub(SWEEP);
            (first..self.unswept)
                .rev()
                .for_each(|at| Node::fit(&mut self.nodes, at));
            deadline.spend(WORK_PER_REFIT * (self.unswept - first).div_ceil(SWEEP / STEP) as u64);
            self.unswept = first;
        }
        while !(self.stack.is_empty() && self.inner.is_empty()) {
            if !deadline.has_room(WORK) {
                return false;
            }
            deadline.spend(WORK);
            for _ in 0..STEP {
                if let Some([at, _]) = self.stack.pop() {
                    let node = &self.nodes[at as usize];
                    if node.newest == self.generation && node.second != NONE {
                        self.inner.push(at);
                        self.stack.extend([[at + 1; 2], [node.second; 2]]);
                    }
                } else if let Some(at) = self.inner.pop() {
                    Node::fit(&mut self.nodes, at as usize);
                }
            }
        }
        self.next_roots = [0, 0];
        true
    }

    /// Adds pairs that may meet, of overlapping fat AABBs of which one is new. Returns true if
    /// these are all, false if there are at least `enough`; `None` if the deadline came first.
    pub fn search(
        &mut self,
        bodies: &Bodies,
        found: &mut Vec<PairKey>,
        enough: usize,
        deadline: &mut Deadline,
    ) -> Option<bool> {
        const WORK: u64 = STEP as u64 * WORK_PER_SEARCH;
        let mut search = Search {
            nodes: &self.nodes,
            generation: self.generation,
            bodies,
            stack: &mut self.stack,
            found,
        };
        loop {
            // A step finds at most as many pairs as it opens.
            if search.found.len() + STEP > enough.max(STEP) {
                return Some(false);
            }
            if !deadline.has_room(WORK) {
                return None;
            }
            // Opened together, so that their cache misses overlap.
            let first = search.stack.len().saturating_sub(STEP);
            let step: ArrayVec<_, STEP> = search.stack.drain(first..).collect();
            deadline.spend(WORK_PER_SEARCH * step.len().max(1) as u64);
            if !step.is_empty() {
                step.into_iter().for_each(|[x, y]| search.open(x, y));
                continue;
            }
            let [i, j] = self.next_roots;
            let Some(&root) = self.roots.get(i) else {
                return Some(true);
            };
            if i == j {
                search.within(root);
                self.next_roots = [i + 1, 0];
            } else {
                search.across(root, self.roots[j]);
                self.next_roots = [i, j + 1];
            }
        }
    }
}

/// The search for pairs that may meet.
struct Search<'b> {
    nodes: &'b [Node],
    generation: u16,
    bodies: &'b Bodies,
    stack: &'b mut Vec<[u32; 2]>,
    found: &'b mut Vec<PairKey>,
}

impl Search<'_> {
    /// Visits the pairs below one node.
    #[inline(always)]
    fn within(&mut self, at: u32) {
        let node = &self.nodes[at as usize];
        self.push(
            [at; 2],
            (node.newest == self.generation) & node.moving & (node.second != NONE),
        );
    }

    /// Visits the pairs of one body below each of two nodes.
    #[inline(always)]
    fn across(&mut self, x: u32, y: u32) {
        let (a, b) = (&self.nodes[x as usize], &self.nodes[y as usize]);
        let new = (a.newest == self.generation) | (b.newest == self.generation);
        self.push(
            [x, y],
            new & (a.moving | b.moving) & a.bounds.intersects(&b.bounds),
        );
    }

    /// Branch-free: a branch on `keep` would often be mispredicted.
    #[inline(always)]
    fn push(&mut self, nodes: [u32; 2], keep: bool) {
        let len = self.stack.len();
        self.stack.push(nodes);
        self.stack.truncate(len + usize::from(keep));
    }

    /// Replaces two nodes by their children. A pair of leaves is a result.
    #[inline(always)]
    fn open(&mut self, x: u32, y: u32) {
        match (self.nodes[x as usize].second, self.nodes[y as usize].second) {
            (NONE, NONE) => {
                let [a, b] = [x, y].map(|leaf| self.nodes[leaf as usize].body);
                if self.bodies.may_meet([a, b]) {
                    self.found.push(pair_key(a, b));
                }
            }
            (second, _) if x == y => {
                self.within(second);
                self.within(x + 1);
                self.across(x + 1, second);
            }
            (NONE, second) => {
                self.across(x, y + 1);
                self.across(x, second);
            }
            (second, NONE) => {
                self.across(x + 1, y);
                self.across(second, y);
            }
            (of_x, of_y) => {
                self.across(x + 1, y + 1);
                self.across(x + 1, of_y);
                self.across(of_x, y + 1);
                self.across(of_x, of_y);
            }
        }
    }
}
