//! The broad phase: which bodies may meet at all.
//!
//! Each body has its box and a fat AABB around it; while the box stays inside that, the tree is left alone. The fat AABBs are
//! the leaves of a balanced binary tree. When some bodies have left theirs, the tree is refitted along their paths, and one
//! descent of the tree against itself finds the overlapping pairs of fat AABBs that have a new one among them: all subtrees
//! without one are passed by, and so are those of fixed bodies among themselves. The pairs found ([`super::pairs`]) stay until
//! one of their bodies leaves its fat AABB again.
//!
//! Cost: nothing for bodies that rest; `O(log n)` expected for a body that leaves its fat AABB, and as much, spread over
//! the frames, for building the tree anew when its bodies have moved about.

use super::body::{Bodies, Change};
use super::id::{PairKey, pair_key};
use super::room::reserve;
use crate::math::Aabb;
use alloc::vec::Vec;
use glam::DVec3;

const NONE: u32 = u32::MAX;

/// How far the fat AABB of a moving body reaches beyond its box, on each side, relative to the longest edge.
const SLACK: f64 = 0.05;

/// Times that a body leaves its fat AABB, on average, before the tree is built anew.
const MOVES_BEFORE_REBUILD: usize = 6;

/// A node of the tree, one cache line. Its children are the next node and `second`.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node {
    bounds: Aabb,
    /// [`NONE`] for a leaf.
    second: u32,
    /// [`NONE`] for a root.
    parent: u32,
    /// The body of a leaf.
    body: u32,
    /// Whether there is a new fat AABB below.
    new: bool,
    /// Whether there is a moving body below.
    moving: bool,
}

const _: () = assert!(size_of::<Node>() == 64);

/// A body in the broad phase.
#[derive(Clone, Copy, Debug)]
struct Proxy {
    fat: Aabb,
    leaf: u32,
    moving: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Broad {
    /// The boxes of all bodies, empty for those that are not there.
    boxes: Vec<Aabb>,
    proxies: Vec<Proxy>,
    /// What is new about each body, and those of whom something is.
    news: Vec<Change>,
    newcomers: Vec<u32>,
    nodes: Vec<Node>,
    /// The root of the tree, then a one-leaf tree for each body inserted or teleported since the last rebuild.
    roots: Vec<u32>,
    /// Leaves with a new box.
    marked: Vec<u32>,
    moves: usize,
    /// Buffer for building the tree.
    order: Vec<u32>,
    found: Vec<PairKey>,
}

impl Broad {
    /// The box of a body that is there.
    pub fn bounds(&self, body: u32) -> &Aabb {
        &self.boxes[body as usize]
    }

    /// What is new about a body since the [`Broad::update`] before the last.
    pub fn news(&self, body: u32) -> Change {
        self.news[body as usize]
    }

    /// Makes room for bodies of indices below `bodies`.
    ///
    /// A tree has less than `2 bodies` nodes. Beside it there are no more roots than [`Broad::update`] allows, which is less
    /// than `bodies + 64`, and those of bodies that came in this frame. Each newcomer has at most two leaves that are marked.
    pub fn reserve(&mut self, bodies: usize) {
        reserve(&mut self.boxes, bodies);
        reserve(&mut self.proxies, bodies);
        reserve(&mut self.news, bodies);
        reserve(&mut self.newcomers, bodies);
        reserve(&mut self.order, bodies);
        reserve(&mut self.marked, 2 * bodies);
        reserve(&mut self.roots, 2 * bodies + 64);
        reserve(&mut self.nodes, 4 * bodies + 64);
    }

    /// Makes room for this many pairs found in a frame.
    pub fn reserve_found(&mut self, pairs: usize) {
        reserve(&mut self.found, pairs);
    }

    /// Gives a body its box; an empty box takes it away.
    pub fn place(&mut self, body: u32, bounds: Aabb, moving: bool, news: Change) {
        let at = body as usize;
        if at >= self.boxes.len() {
            self.boxes.resize(at + 1, Aabb::EMPTY);
            self.proxies.resize(at + 1, Proxy { fat: Aabb::EMPTY, leaf: NONE, moving });
            self.news.resize(at + 1, Change::None);
        }
        self.boxes[at] = bounds;
        let proxy = &mut self.proxies[at];
        proxy.moving = moving;
        let inside = proxy.fat.min.cmple(bounds.min).all() && bounds.max.cmple(proxy.fat.max).all();
        if inside && news == Change::None && !bounds.is_empty() {
            return;
        }
        let slack = DVec3::splat(if moving { SLACK * bounds.extents().max_element() } else { 0.0 });
        proxy.fat = Aabb { min: bounds.min - slack, max: bounds.max + slack };
        if self.news[at] == Change::None {
            self.newcomers.push(body);
        }
        self.news[at] = self.news[at].max(news).max(Change::Place);
    }

    pub fn has_news(&self) -> bool {
        !self.newcomers.is_empty()
    }

    /// All pairs that may meet of fat AABBs that overlap and have a new one among them, ascending, as of the last update.
    pub fn found(&self) -> &[PairKey] {
        &self.found
    }

    /// Brings the tree up to date. The news stay until [`Broad::forget_news`].
    pub fn update(&mut self, bodies: &Bodies) {
        self.found.clear();
        if self.newcomers.is_empty() {
            return;
        }
        self.moves += self.newcomers.len();
        for i in 0..self.newcomers.len() {
            self.renew(self.newcomers[i]);
        }
        let leaves = self.nodes.len() / 2;
        if self.roots.len().pow(2) > leaves + 64 || self.moves > MOVES_BEFORE_REBUILD * leaves + 64 {
            self.rebuild();
        }
        self.roots.iter().for_each(|&root| refit(&mut self.nodes, root));
        let mut search = Search { nodes: &self.nodes, bodies, found: &mut self.found };
        for (i, &root) in self.roots.iter().enumerate() {
            search.within(root);
            for &other in &self.roots[..i] {
                search.across(root, other);
            }
        }
        self.found.sort_unstable();
    }

    /// Ends the frame of an update.
    pub fn forget_news(&mut self) {
        for body in self.newcomers.drain(..) {
            self.news[body as usize] = Change::None;
        }
        for mut at in self.marked.drain(..) {
            while let Some(node) = self.nodes.get_mut(at as usize).filter(|node| node.new) {
                node.new = false;
                at = node.parent;
            }
        }
    }

    /// Puts a body's fat AABB into its leaf, or into a one-leaf tree if it was teleported.
    fn renew(&mut self, body: u32) {
        let proxy = self.proxies[body as usize];
        if let Some(leaf) = self.nodes.get(proxy.leaf as usize) {
            let moved = leaf.bounds.intersects(&proxy.fat);
            self.set_leaf(proxy.leaf, if moved { proxy.fat } else { Aabb::EMPTY }, proxy.moving);
            if moved {
                return;
            }
        }
        self.proxies[body as usize].leaf = NONE;
        if !proxy.fat.is_empty() {
            let leaf = self.nodes.len() as u32;
            self.proxies[body as usize].leaf = leaf;
            self.roots.push(leaf);
            self.nodes.push(Node { bounds: Aabb::EMPTY, second: NONE, parent: NONE, body, new: false, moving: false });
            self.set_leaf(leaf, proxy.fat, proxy.moving);
        }
    }

    /// Sets a leaf and marks the path to it.
    fn set_leaf(&mut self, leaf: u32, bounds: Aabb, moving: bool) {
        let node = &mut self.nodes[leaf as usize];
        (node.bounds, node.moving) = (bounds, moving);
        self.marked.push(leaf);
        let mut at = leaf;
        while let Some(node) = self.nodes.get_mut(at as usize).filter(|node| !node.new) {
            node.new = true;
            at = node.parent;
        }
    }

    /// Builds the tree of all bodies that are there.
    fn rebuild(&mut self) {
        self.moves = 0;
        self.roots.clear();
        self.nodes.clear();
        self.order.clear();
        for (body, proxy) in (0..).zip(&mut self.proxies) {
            proxy.leaf = NONE;
            if !proxy.fat.is_empty() {
                self.order.push(body);
            }
        }
        if !self.order.is_empty() {
            self.roots.push(build(&mut self.nodes, &mut self.proxies, &self.news, &mut self.order, NONE));
        }
        self.marked.clear();
        let leaves = self.newcomers.iter().map(|&body| self.proxies[body as usize].leaf);
        self.marked.extend(leaves.filter(|&leaf| leaf != NONE));
    }
}

/// Builds the subtree of `order`, which is not empty, by halves along the longest axis: balanced, so recursion is short.
fn build(nodes: &mut Vec<Node>, proxies: &mut [Proxy], news: &[Change], order: &mut [u32], parent: u32) -> u32 {
    let at = nodes.len() as u32;
    if let [body] = *order {
        let proxy = &mut proxies[body as usize];
        proxy.leaf = at;
        let new = news[body as usize] != Change::None;
        nodes.push(Node { bounds: proxy.fat, second: NONE, parent, body, new, moving: proxy.moving });
        return at;
    }
    let middle = |body: u32| proxies[body as usize].fat.min * 0.5 + proxies[body as usize].fat.max * 0.5;
    let axis = Aabb::from_points(order.iter().map(|&body| middle(body))).extents().max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
    let empty = Node { bounds: Aabb::EMPTY, second: NONE, parent, body: NONE, new: false, moving: false };
    nodes.push(empty);
    let (left, right) = order.split_at_mut(half);
    let first = build(nodes, proxies, news, left, at);
    let second = build(nodes, proxies, news, right, at);
    let (first, other) = (nodes[first as usize], nodes[second as usize]);
    let node = &mut nodes[at as usize];
    node.bounds = first.bounds.union(&other.bounds);
    node.second = second;
    node.new = first.new || other.new;
    node.moving = first.moving || other.moving;
    at
}

/// Makes the boxes on marked paths fit again.
fn refit(nodes: &mut [Node], at: u32) {
    let node = nodes[at as usize];
    if !node.new || node.second == NONE {
        return;
    }
    refit(nodes, at + 1);
    refit(nodes, node.second);
    let (first, second) = (nodes[at as usize + 1], nodes[node.second as usize]);
    let node = &mut nodes[at as usize];
    node.bounds = first.bounds.union(&second.bounds);
    node.moving = first.moving || second.moving;
}

/// The search for pairs that may meet.
struct Search<'b> {
    nodes: &'b [Node],
    bodies: &'b Bodies,
    found: &'b mut Vec<PairKey>,
}

impl Search<'_> {
    /// Pairs below one node.
    fn within(&mut self, at: u32) {
        let node = &self.nodes[at as usize];
        if node.new && node.moving && node.second != NONE {
            self.within(at + 1);
            self.within(node.second);
            self.across(at + 1, node.second);
        }
    }

    /// Pairs of one body below each of two nodes.
    #[inline(always)]
    fn across(&mut self, x: u32, y: u32) {
        let (a, b) = (&self.nodes[x as usize], &self.nodes[y as usize]);
        // Most pairs end here, before a call is made for them.
        if (a.new | b.new) & (a.moving | b.moving) && a.bounds.intersects(&b.bounds) {
            if a.second != NONE || b.second != NONE {
                self.below(x, y);
            } else if self.bodies.facts(a.body).may_meet(self.bodies.facts(b.body)) {
                self.found.push(pair_key(a.body, b.body));
            }
        }
    }

    /// Pairs below two nodes that are not both leaves.
    fn below(&mut self, x: u32, y: u32) {
        match (self.nodes[x as usize].second, self.nodes[y as usize].second) {
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
