//! What the tree of fat AABBs consists of: its nodes, and the bodies in its leaves.

use crate::math::Aabb;
use crate::scene::facts::Change;

pub(crate) const NONE: u32 = u32::MAX;

/// A body in the broad phase, one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Proxy {
    pub fat: Aabb,
    pub leaf: u32,
    pub moving: bool,
    /// What will be new about it in the next generation.
    pub next: Change,
    /// Whether it waits for the next generation.
    pub waiting: bool,
    /// Whether not all of its partners may be known.
    pub open: bool,
    /// Its place among those of which pairs were left out, or [`NONE`].
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
    /// The last generation of which there is a new fat AABB below.
    pub newest: u16,
    /// Whether there is a moving body below.
    pub moving: bool,
}

const _: () = assert!(size_of::<Node>() == 64);

impl Node {
    /// Of a body that was new in a generation.
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

    /// Without its children.
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

    /// Sets what a node has from its children, if there are any.
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
