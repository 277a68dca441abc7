//! Builds the tree of fat AABBs in steps, so that a frame may end between any two of them.
//!
//! Top down, each range of bodies is split by their middles along an axis, near its half: a small
//! range exactly, a large one at the median of a sample, with another sample if the split was far
//! from the half. Then the boxes are computed bottom up. The tree is balanced, so paths are short.

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

/// Bodies per sample.
const SAMPLE: usize = 31;

/// A range of `order` that becomes a subtree. `second`: the second child of its parent, else the
/// first.
#[derive(Clone, Copy, Debug)]
struct Range {
    begin: usize,
    end: usize,
    parent: u32,
    second: bool,
}

/// The partition of a large range: bodies below a pivot are moved to the front.
#[derive(Clone, Copy, Debug)]
struct Partition {
    range: Range,
    node: u32,
    /// The part of the range that contains the half.
    part: [usize; 2],
    axis: usize,
    pivot: (f64, u32),
    /// Bodies before `split` are below the pivot; those from `split` to `at` are not.
    split: usize,
    at: usize,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Build {
    order: Vec<u32>,
    /// Number of bodies collected, number of bodies at the begin, and number of nodes whose boxes
    /// are not computed yet.
    collected: usize,
    bodies: usize,
    ranges: Vec<Range>,
    partition: Option<Partition>,
    open: usize,
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
    /// Bodies with `news` are newcomers of this `generation`.
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
                self.open = nodes.len();
                STEP.min(range.end - range.begin)
            } else if self.open > 0 {
                self.fit(nodes)
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
        if order.len() > STEP {
            let part = [range.begin, range.end];
            let whole = Partition {
                range,
                node: at,
                part,
                axis: 0,
                pivot: (0.0, 0),
                split: range.begin,
                at: range.begin,
            };
            self.partition = Some(Partition {
                axis: longest_axis(order, proxies),
                ..whole
            });
            self.choose_pivot(proxies);
        } else {
            let axis = longest_axis(order, proxies);
            let half = order.len() / 2;
            order.select_nth_unstable_by(half, |&x, &y| {
                compare(key(proxies, x, axis), key(proxies, y, axis))
            });
            self.descend(range, range.begin + half, at);
        }
    }

    /// Chooses the median of a sample of the current part as pivot.
    fn choose_pivot(&mut self, proxies: &[Proxy]) {
        let Some(partition) = &mut self.partition else {
            return;
        };
        let [begin, end] = partition.part;
        let sample = self.order[begin..end]
            .iter()
            .step_by((end - begin).div_ceil(SAMPLE));
        let mut keys: ArrayVec<_, SAMPLE> = sample
            .map(|&body| key(proxies, body, partition.axis))
            .collect();
        keys.sort_unstable_by(|&x, &y| compare(x, y));
        (partition.pivot, partition.split, partition.at) = (keys[keys.len() / 2], begin, begin);
    }

    /// Compares the next bodies with the pivot. After the last, it splits the range, or partitions
    /// a part of it again. Returns the number of bodies compared.
    fn partition(&mut self, mut partition: Partition, proxies: &[Proxy]) -> usize {
        let Partition {
            range,
            node,
            part: [begin, end],
            axis,
            pivot,
            ..
        } = partition;
        let count = STEP.min(end - partition.at);
        for at in partition.at..partition.at + count {
            if compare(key(proxies, self.order[at], axis), pivot).is_lt() {
                self.order.swap(at, partition.split);
                partition.split += 1;
            }
        }
        partition.at += count;
        if partition.at < end {
            self.partition = Some(partition);
            return count;
        }
        let quarter = (range.end - range.begin) / 4;
        let split = partition.split;
        if split >= range.begin + quarter && split <= range.end - quarter {
            self.descend(range, split, node);
            return count;
        }
        // The part that contains the half is smaller than before: the median of several has some
        // below it.
        partition.part = if split < range.begin + quarter {
            [split, end]
        } else {
            [begin, split]
        };
        self.partition = Some(partition);
        self.choose_pivot(proxies);
        count
    }

    /// Queues the halves of a range for the next steps, the first one first: its root is the next
    /// node.
    fn descend(&mut self, range: Range, middle: usize, parent: u32) {
        self.ranges.push(Range {
            begin: middle,
            end: range.end,
            parent,
            second: true,
        });
        self.ranges.push(Range {
            begin: range.begin,
            end: middle,
            parent,
            second: false,
        });
    }

    /// Computes the boxes of the last nodes that have none yet; children come after their parents.
    /// Returns the number of nodes.
    fn fit(&mut self, nodes: &mut [Node]) -> usize {
        let begin = self.open.saturating_sub(STEP);
        for at in (begin..self.open).rev() {
            Node::fit(nodes, at);
        }
        let count = self.open - begin;
        self.open = begin;
        count
    }
}

fn middle(proxies: &[Proxy], body: u32) -> DVec3 {
    let fat = &proxies[body as usize].fat;
    fat.min * 0.5 + fat.max * 0.5
}

/// The sort key of a body along an axis. No two are equal.
fn key(proxies: &[Proxy], body: u32, axis: usize) -> (f64, u32) {
    (middle(proxies, body)[axis], body)
}

fn compare(x: (f64, u32), y: (f64, u32)) -> core::cmp::Ordering {
    x.0.total_cmp(&y.0).then(x.1.cmp(&y.1))
}

/// The axis with the largest extent of a sample of the middles.
fn longest_axis(order: &[u32], proxies: &[Proxy]) -> usize {
    let sample = order.iter().step_by(order.len().div_ceil(SAMPLE));
    Aabb::from_points(sample.map(|&body| middle(proxies, body)))
        .extents()
        .max_position()
}
