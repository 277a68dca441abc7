//! Nodes of the tree of fat AABBs, and the bodies in its leaves.

use crate::facts::Change;
use punctual_geom::Aabb;

pub(crate) const NONE: u32 = u32::MAX;

/// A body in the broad phase, one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Proxy {
    pub fat: Aabb,
    pub leaf: u32,
    pub moving: bool,
    /// Its news in the next generation.
    pub next: Change,
    /// True if it waits for the next generation.
    pub waiting: bool,
    /// True if some of its partners may be unknown.
    pub open: bool,
    /// Its index in the list of bodies whose pairs were left out, or [`NONE`].
    pub cropped: u32,
}

const _: () = assert!(size_of::<Proxy>() == 64);

impl Proxy {
    pub const NOWHERE: Self = Self {
        fat: Aabb::EMPTY,
        leaf: NONE,
        moving: false,
        next: Change::None,
        waiting: false,
        open: false,
        cropped: NONE,
    };
}

/// A node of the tree, one cache line. Its children are the next node and `second`.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Node {
    pub bounds: Aabb,
    /// [`NONE`] for a leaf.
    pub second: u32,
    /// [`NONE`] for a root.
    pub parent: u32,
    /// The body of a leaf.
    pub body: u32,
    /// The last generation with a new fat AABB below this node.
    pub newest: u16,
    /// True if a moving body is below this node.
    pub moving: bool,
}

const _: () = assert!(size_of::<Node>() == 64);

impl Node {
    /// The leaf of a body. `newest` is the generation in which the body was new.
    pub fn leaf(body: u32, proxy: &Proxy, parent: u32, newest: u16) -> Self {
        Self {
            bounds: proxy.fat,
            second: NONE,
            parent,
            body,
            newest,
            moving: proxy.moving,
        }
    }

    /// An inner node without its children.
    pub fn inner(parent: u32) -> Self {
        Self {
            bounds: Aabb::EMPTY,
            second: NONE,
            parent,
            body: NONE,
            newest: 0,
            moving: false,
        }
    }

    /// Computes the box and marks of an inner node from its children.
    pub fn fit(nodes: &mut [Self], at: usize) {
        let Some(second) = nodes.get(nodes[at].second as usize).copied() else {
            return;
        };
        let first = nodes[at + 1];
        let node = &mut nodes[at];
        node.bounds = first.bounds.union(&second.bounds);
        (node.newest, node.moving) = (
            first.newest.max(second.newest),
            first.moving || second.moving,
        );
    }
}
