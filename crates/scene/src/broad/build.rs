//! Builds the tree of fat AABBs in steps, so that a frame may end between any two of them.
//!
//! Top down, each range of bodies is split along an axis at the median of a sample of their
//! middles, so that the tree is nearly balanced and its paths are short. The next refit computes
//! its boxes.

use super::node::{NONE, Node, Proxy};
use crate::cost::WORK_PER_BUILT_LEVEL;
use crate::facts::Change;
use crate::room::reserve;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual::engine::Deadline;
use punctual_geom::Aabb;

/// Bodies per step.
const STEP: usize = 16;

/// Bodies per sample, and the distance of their places in a range, modulo its length. The distance
/// is a prime, so that the bodies differ, and large, so that no pattern in the range repeats in the
/// sample.
const SAMPLE: usize = 31;
const SCATTER: u64 = 2_654_435_761;

/// A range of `order` that becomes a subtree. `second`: the second child of its parent, else the
/// first.
#[derive(Clone, Copy, Debug)]
struct Range {
    begin: usize,
    end: usize,
    parent: u32,
    second: bool,
}

/// The partition of a range: bodies below a pivot are moved to the front.
#[derive(Clone, Copy, Debug)]
struct Partition {
    range: Range,
    node: u32,
    axis: usize,
    pivot: (i64, u32),
    /// Bodies before `split` are below the pivot; those from `split` to `at` are not.
    split: usize,
    at: usize,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Build {
    order: Vec<u32>,
    /// Number of bodies collected, and number of bodies at the begin.
    collected: usize,
    bodies: usize,
    ranges: Vec<Range>,
    partition: Option<Partition>,
}

impl Build {
    pub fn reserve(&mut self, bodies: usize) {
        reserve(&mut self.order, bodies);
        reserve(&mut self.ranges, 256);
    }

    /// Begins with the bodies of indices below `bodies`. More bodies may be inserted before it is
    /// done.
    pub fn begin(&mut self, bodies: usize) {
        *self = Self {
            bodies,
            order: core::mem::take(&mut self.order),
            ranges: core::mem::take(&mut self.ranges),
            ..Self::default()
        };
        self.order.clear();
        self.ranges.clear();
    }

    /// Builds as far as the deadline allows; true if done. The root is node 0, if there is one.
    /// Inner boxes come with the next refit. Bodies with `news` are newcomers of this `generation`.
    pub fn advance(
        &mut self,
        nodes: &mut Vec<Node>,
        proxies: &mut [Proxy],
        news: &[Change],
        generation: u16,
        deadline: &mut Deadline,
    ) -> bool {
        while deadline.has_room(STEP as u64 * WORK_PER_BUILT_LEVEL) {
            let count = if self.collected < self.bodies {
                self.collect(proxies)
            } else if let Some(partition) = self.partition.take() {
                self.partition(partition, proxies)
            } else if let Some(range) = self.ranges.pop() {
                let newest = |body| {
                    if news[body as usize] == Change::None {
                        0
                    } else {
                        generation
                    }
                };
                self.split(range, nodes, proxies, newest);
                STEP.min(range.end - range.begin)
            } else {
                return true;
            };
            deadline.spend(count as u64 * WORK_PER_BUILT_LEVEL);
        }
        false
    }

    /// Collects the next bodies that are present. Returns the number of slots examined.
    fn collect(&mut self, proxies: &mut [Proxy]) -> usize {
        let end = self.bodies.min(self.collected + STEP);
        for (proxy, body) in proxies[self.collected..end]
            .iter_mut()
            .zip(self.collected as u32..)
        {
            proxy.leaf = NONE;
            if !proxy.fat.is_empty() {
                self.order.push(body);
            }
        }
        let count = end - self.collected;
        self.collected = end;
        if end == self.bodies && !self.order.is_empty() {
            self.ranges.push(Range {
                begin: 0,
                end: self.order.len(),
                parent: NONE,
                second: false,
            });
        }
        count
    }

    /// Makes the node of a range. `newest` returns the generation of a body.
    fn split(
        &mut self,
        range: Range,
        nodes: &mut Vec<Node>,
        proxies: &mut [Proxy],
        newest: impl Fn(u32) -> u16,
    ) {
        let at = nodes.len() as u32;
        if range.second {
            nodes[range.parent as usize].second = at;
        }
        let order = &mut self.order[range.begin..range.end];
        if let [body] = *order {
            let proxy = &mut proxies[body as usize];
            proxy.leaf = at;
            return nodes.push(Node::leaf(body, proxy, range.parent, newest(body)));
        }
        nodes.push(Node::inner(range.parent));
        let places = (0..order.len().min(SAMPLE) as u64).map(|i| i * SCATTER % order.len() as u64);
        let sample: ArrayVec<u32, SAMPLE> = places.map(|place| order[place as usize]).collect();
        let middles = sample.iter().map(|&body| middle(proxies, body));
        let axis = Aabb::from_points(middles).extents().max_position();
        let keys = sample.iter().map(|&body| key(proxies, body, axis));
        let mut keys: ArrayVec<_, SAMPLE> = keys.collect();
        keys.sort_unstable();
        self.partition = Some(Partition {
            range,
            node: at,
            axis,
            pivot: keys[keys.len() / 2],
            split: range.begin,
            at: range.begin,
        });
    }

    /// Compares the next bodies with the pivot. After the last, queues the parts before and from
    /// the pivot, the first one first: its root is the next node. Returns the number of bodies
    /// compared.
    fn partition(&mut self, mut partition: Partition, proxies: &[Proxy]) -> usize {
        let Range { begin, end, .. } = partition.range;
        let from = partition.at;
        partition.at = end.min(from + STEP);
        for at in from..partition.at {
            if key(proxies, self.order[at], partition.axis) < partition.pivot {
                self.order.swap(at, partition.split);
                partition.split += 1;
            }
        }
        if partition.at < end {
            self.partition = Some(partition);
        } else {
            // A body may have left its place since the pivot was chosen.
            let middle = partition.split.clamp(begin + 1, end - 1);
            let parent = partition.node;
            let parts = [(middle, end, true), (begin, middle, false)];
            self.ranges.extend(parts.map(|(begin, end, second)| Range {
                begin,
                end,
                parent,
                second,
            }));
        }
        partition.at - from
    }
}

fn middle(proxies: &[Proxy], body: u32) -> DVec3 {
    let fat = &proxies[body as usize].fat;
    fat.min * 0.5 + fat.max * 0.5
}

/// The sort key of a body along an axis. No two are equal.
fn key(proxies: &[Proxy], body: u32, axis: usize) -> (i64, u32) {
    let bits = middle(proxies, body)[axis].to_bits() as i64;
    // The bits of negative numbers descend.
    (bits ^ ((bits >> 63) as u64 >> 1) as i64, body)
}
