//! The broad phase: which bodies may meet at all.
//!
//! Each body has its box, and a wider one around it that it may move in before anything else happens. The wide boxes are
//! the leaves of a balanced binary tree. When some bodies have left theirs, the tree is refitted along their paths, and one
//! descent of the tree against itself finds the pairs of wide boxes that have a new one among them: all subtrees without one
//! are passed by, and so are those of fixed bodies among themselves. The pairs found ([`super::pairs`]) stay until one of
//! their bodies leaves its wide box again.
//!
//! Cost: nothing for bodies that rest; `O(log n)` expected for a body that leaves its wide box, and as much, spread over
//! the frames, for building the tree anew when its bodies have moved about.

use super::pairs::{Key, key};
use crate::math::Aabb;
use alloc::vec::Vec;
use glam::DVec3;

const NONE: u32 = u32::MAX;

/// How much wider than the box of a body the wide box is, on each side, relative to the longest edge.
const SLACK: f64 = 0.05;

/// Times that a body leaves its wide box, on average, before the tree is built anew.
const MOVES_BEFORE_REBUILD: usize = 6;

/// What is new about a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum News {
    #[default]
    None,
    /// Another wide box, or other bodies that it may meet.
    Place,
    /// Another body than before.
    Body,
}

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
    /// Whether there is a new wide box below.
    new: bool,
    /// Whether there is a moving body below.
    moving: bool,
}

const _: () = assert!(size_of::<Node>() == 64);

/// What the broad phase knows of one body.
#[derive(Clone, Copy, Debug)]
struct Place {
    wide: Aabb,
    leaf: u32,
    moving: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Broad {
    /// The boxes of all bodies, empty for those that are not there.
    boxes: Vec<Aabb>,
    places: Vec<Place>,
    /// What is new about each body, and those of whom something is.
    news: Vec<News>,
    newcomers: Vec<u32>,
    nodes: Vec<Node>,
    /// The root of the tree, then the leaves of bodies that came or were carried off since it was built.
    roots: Vec<u32>,
    /// Leaves with a new box.
    marked: Vec<u32>,
    moves: usize,
    /// Buffer for building the tree.
    order: Vec<u32>,
    found: Vec<Key>,
}

impl Broad {
    /// The box of a body that is there.
    pub fn bounds(&self, body: u32) -> &Aabb {
        &self.boxes[body as usize]
    }

    /// Whether a body has another wide box than before the last [`Broad::update`].
    pub fn news(&self, body: u32) -> News {
        self.news[body as usize]
    }

    /// Gives a body its box; an empty box takes it away.
    pub fn place(&mut self, body: u32, bounds: Aabb, moving: bool, news: News) {
        let at = body as usize;
        if at >= self.boxes.len() {
            self.boxes.resize(at + 1, Aabb::EMPTY);
            self.places.resize(at + 1, Place { wide: Aabb::EMPTY, leaf: NONE, moving });
            self.news.resize(at + 1, News::None);
        }
        self.boxes[at] = bounds;
        let place = &mut self.places[at];
        place.moving = moving;
        let inside = place.wide.min.cmple(bounds.min).all() && bounds.max.cmple(place.wide.max).all();
        if inside && news == News::None && !bounds.is_empty() {
            return;
        }
        let slack = DVec3::splat(if moving { SLACK * bounds.extents().max_element() } else { 0.0 });
        place.wide = Aabb { min: bounds.min - slack, max: bounds.max + slack };
        if self.news[at] == News::None {
            self.newcomers.push(body);
        }
        self.news[at] = self.news[at].max(news).max(News::Place);
    }

    pub fn has_news(&self) -> bool {
        !self.newcomers.is_empty()
    }

    /// All pairs of wide boxes that overlap and have a new one among them, ascending, as of the last update.
    pub fn found(&self) -> &[Key] {
        &self.found
    }

    /// Brings the tree up to date. The news stay until [`Broad::forget_news`].
    pub fn update(&mut self) {
        self.found.clear();
        if self.newcomers.is_empty() {
            return;
        }
        self.moves += self.newcomers.len();
        for i in 0..self.newcomers.len() {
            self.renew(self.newcomers[i]);
        }
        let bodies = self.nodes.len() / 2;
        if self.roots.len().pow(2) > bodies + 64 || self.moves > MOVES_BEFORE_REBUILD * bodies + 64 {
            self.rebuild();
        }
        for (i, &root) in self.roots.iter().enumerate() {
            refit(&mut self.nodes, root);
            within(&self.nodes, root, &mut self.found);
            for &other in &self.roots[..i] {
                across(&self.nodes, root, other, &mut self.found);
            }
        }
        self.found.sort_unstable();
    }

    /// Ends the frame of an update.
    pub fn forget_news(&mut self) {
        for body in self.newcomers.drain(..) {
            self.news[body as usize] = News::None;
        }
        for mut at in self.marked.drain(..) {
            while let Some(node) = self.nodes.get_mut(at as usize).filter(|node| node.new) {
                node.new = false;
                at = node.parent;
            }
        }
    }

    /// Puts a body's wide box into its leaf, or into a leaf of its own if it was carried off.
    fn renew(&mut self, body: u32) {
        let place = self.places[body as usize];
        if let Some(leaf) = self.nodes.get(place.leaf as usize) {
            let moved = leaf.bounds.intersects(&place.wide);
            self.set_leaf(place.leaf, if moved { place.wide } else { Aabb::EMPTY }, place.moving);
            if moved {
                return;
            }
        }
        self.places[body as usize].leaf = NONE;
        if !place.wide.is_empty() {
            let leaf = self.nodes.len() as u32;
            self.places[body as usize].leaf = leaf;
            self.roots.push(leaf);
            self.nodes.push(Node { bounds: Aabb::EMPTY, second: NONE, parent: NONE, body, new: false, moving: false });
            self.set_leaf(leaf, place.wide, place.moving);
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
        for (body, place) in (0..).zip(&mut self.places) {
            place.leaf = NONE;
            if !place.wide.is_empty() {
                self.order.push(body);
            }
        }
        if !self.order.is_empty() {
            self.roots.push(build(&mut self.nodes, &mut self.places, &self.news, &mut self.order, NONE));
        }
        self.marked.clear();
        let leaves = self.newcomers.iter().map(|&body| self.places[body as usize].leaf);
        self.marked.extend(leaves.filter(|&leaf| leaf != NONE));
    }
}

/// Builds the subtree of `order`, which is not empty, by halves along the longest axis: balanced, so recursion is short.
fn build(nodes: &mut Vec<Node>, places: &mut [Place], news: &[News], order: &mut [u32], parent: u32) -> u32 {
    let at = nodes.len() as u32;
    if let [body] = *order {
        let place = &mut places[body as usize];
        place.leaf = at;
        let new = news[body as usize] != News::None;
        nodes.push(Node { bounds: place.wide, second: NONE, parent, body, new, moving: place.moving });
        return at;
    }
    let middle = |body: u32| places[body as usize].wide.min * 0.5 + places[body as usize].wide.max * 0.5;
    let axis = Aabb::from_points(order.iter().map(|&body| middle(body))).extents().max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
    let empty = Node { bounds: Aabb::EMPTY, second: NONE, parent, body: NONE, new: false, moving: false };
    nodes.push(empty);
    let (left, right) = order.split_at_mut(half);
    let first = build(nodes, places, news, left, at);
    let second = build(nodes, places, news, right, at);
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

/// Pairs below one node.
fn within(nodes: &[Node], at: u32, found: &mut Vec<Key>) {
    let node = &nodes[at as usize];
    if node.new && node.moving && node.second != NONE {
        within(nodes, at + 1, found);
        within(nodes, node.second, found);
        across(nodes, at + 1, node.second, found);
    }
}

/// [`Aabb::intersects`] without branches, which here go either way as often.
#[inline(always)]
pub(super) fn overlap(a: &Aabb, b: &Aabb) -> bool {
    let below = a.min.cmple(b.max) & b.min.cmple(a.max);
    below.x & below.y & below.z
}

/// Pairs of one body below each of two nodes.
#[inline(always)]
fn across(nodes: &[Node], x: u32, y: u32, found: &mut Vec<Key>) {
    let (a, b) = (&nodes[x as usize], &nodes[y as usize]);
    // Most pairs end here, before a call is made for them.
    if (a.new | b.new) & (a.moving | b.moving) && overlap(&a.bounds, &b.bounds) {
        if a.second == NONE && b.second == NONE {
            found.push(key(a.body, b.body));
        } else {
            below(nodes, x, y, found);
        }
    }
}

/// Pairs below two nodes that are not both leaves.
fn below(nodes: &[Node], x: u32, y: u32, found: &mut Vec<Key>) {
    match (nodes[x as usize].second, nodes[y as usize].second) {
        (NONE, second) => {
            across(nodes, x, y + 1, found);
            across(nodes, x, second, found);
        }
        (second, NONE) => {
            across(nodes, x + 1, y, found);
            across(nodes, second, y, found);
        }
        (of_x, of_y) => {
            across(nodes, x + 1, y + 1, found);
            across(nodes, x + 1, of_y, found);
            across(nodes, of_x, y + 1, found);
            across(nodes, of_x, of_y, found);
        }
    }
}
