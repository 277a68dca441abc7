//! The front: a bounded priority queue of node pairs, before a stack of pairs that are finished depth-first.
//!
//! The queue is a set of linked lists in one arena of fixed capacity, with a mask of those that are not empty: constant
//! time, and a total order (bucket, then last in first out, or first in first out) that depends on nothing but the input.

use alloc::boxed::Box;
use alloc::vec::Vec;

/// Two nodes, or a triangle and a node: indices, with [`TRIANGLE`] set for a triangle (in tree order).
pub(super) type Pair = [u32; 2];

/// Marks the index of a triangle.
pub(super) const TRIANGLE: u32 = 1 << 31;

/// Number of buckets; 0 is visited first.
pub(super) const BUCKETS: usize = 128;

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Entry {
    pair: Pair,
    next: u32,
}

/// Node pairs still to be visited.
#[derive(Clone, Debug)]
pub(super) struct Front {
    stack: Vec<Pair>,
    arena: Box<[Entry]>,
    /// First and last entry of each bucket.
    lists: [(u32, u32); BUCKETS],
    occupied: u128,
    free: u32,
    /// Entries of the arena that were ever in use; those beyond are free too.
    touched: u32,
    queued: u32,
    peak: u32,
}

impl Front {
    pub fn new(capacity: usize) -> Self {
        let capacity = capacity.min(NONE as usize - 1);
        Self {
            stack: Vec::with_capacity(STACK),
            arena: alloc::vec![Entry { pair: [0; 2], next: NONE }; capacity].into(),
            lists: [(NONE, NONE); BUCKETS],
            occupied: 0,
            free: NONE,
            touched: 0,
            queued: 0,
            peak: 0,
        }
    }

    pub fn clear(&mut self) {
        self.stack.clear();
        self.occupied = 0;
        self.free = NONE;
        self.touched = 0;
        self.queued = 0;
        self.peak = 0;
    }

    /// Puts a pair where it is finished depth-first, before any queued pair: on top of the stack, or below its top.
    #[inline(always)]
    pub fn push(&mut self, pair: Pair, on_top: bool) {
        debug_assert!(
            self.stack.len() < self.stack.capacity(),
            "the stack holds 64 pairs for each level of both trees"
        );
        let top = if on_top { None } else { self.stack.last_mut() };
        let pair = top.map_or(pair, |top| core::mem::replace(top, pair));
        self.stack.push(pair);
    }

    /// Queues a pair in `bucket`, as its first or last; a pair that finds no room is finished depth-first.
    pub fn queue(&mut self, pair: Pair, bucket: usize, first: bool) {
        let slot = if self.free != NONE {
            {
                let next = self.arena[self.free as usize].next;
                core::mem::replace(&mut self.free, next)
            }
        } else if (self.touched as usize) < self.arena.len() {
            self.touched += 1;
            self.touched - 1
        } else {
            return self.push(pair, true);
        };
        let empty = self.occupied & 1 << bucket == 0;
        let (head, tail) = &mut self.lists[bucket];
        let next = if first && !empty { *head } else { NONE };
        self.arena[slot as usize] = Entry { pair, next };
        if empty {
            (*head, *tail) = (slot, slot);
        } else if first {
            *head = slot;
        } else {
            self.arena[*tail as usize].next = slot;
            *tail = slot;
        }
        self.occupied |= 1 << bucket;
        self.queued += 1;
        self.peak = self.peak.max(self.queued);
    }

    /// The next pair, and whether it comes from the queue.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<(Pair, bool)> {
        if let Some(pair) = self.stack.pop() {
            return Some((pair, false));
        }
        if self.occupied == 0 { None } else { Some((self.pop_queue(), true)) }
    }

    fn pop_queue(&mut self) -> Pair {
        let bucket = self.occupied.trailing_zeros() as usize;
        let slot = self.lists[bucket].0;
        let Entry { pair, next } = self.arena[slot as usize];
        self.lists[bucket].0 = next;
        if next == NONE {
            self.occupied &= !(1 << bucket);
        }
        self.arena[slot as usize].next = core::mem::replace(&mut self.free, slot);
        self.queued -= 1;
        pair
    }

    pub fn is_empty(&self) -> bool {
        self.stack.is_empty() && self.occupied == 0
    }

    /// Most pairs that waited in the queue at once.
    pub fn peak(&self) -> u32 {
        self.peak
    }

    /// All pairs, in no particular order.
    pub fn iter(&self) -> impl Iterator<Item = Pair> + '_ {
        let lists = (0..BUCKETS).filter(|bucket| self.occupied & 1 << bucket != 0).map(|bucket| self.lists[bucket].0);
        let entry = |slot: &u32| self.arena[*slot as usize].next;
        let queued = lists.flat_map(move |head| {
            core::iter::successors(Some(head), move |slot| Some(entry(slot)).filter(|&next| next != NONE))
        });
        self.stack.iter().copied().chain(queued.map(|slot| self.arena[slot as usize].pair))
    }
}

/// Room for 63 siblings on each level of both trees, and the children of the pair that found the queue full.
const STACK: usize = 64 * 2 * MAX_DEPTH;

/// Levels of a tree, its triangles included: [`crate::tree`] keeps binary trees of 2^30 triangles to a depth of 70.
const MAX_DEPTH: usize = 72;

#[cfg(test)]
mod tests {
    use super::*;

    fn drain(front: &mut Front) -> Vec<u32> {
        core::iter::from_fn(|| front.pop()).map(|(pair, _)| pair[0]).collect()
    }

    #[test]
    fn the_stack_goes_first_then_the_buckets_in_turn() {
        let mut front = Front::new(8);
        for (i, bucket) in [(0, 5), (1, 0), (2, 127), (3, 0)] {
            front.queue([i, 0], bucket, true);
        }
        front.push([9, 0], true);
        front.push([8, 0], false);
        assert_eq!(front.iter().count(), 6);
        assert_eq!(drain(&mut front), [9, 8, 3, 1, 0, 2]);
        assert!(front.is_empty());
    }

    #[test]
    fn last_means_first_in_first_out() {
        let mut front = Front::new(8);
        for i in 0..4 {
            front.queue([i, 0], 1, false);
        }
        assert_eq!(drain(&mut front), [0, 1, 2, 3]);
    }

    #[test]
    fn a_full_queue_loses_nothing_and_uses_freed_room_again() {
        let mut front = Front::new(2);
        for i in 0..3 {
            front.queue([i, 0], 0, true);
        }
        assert_eq!(front.peak(), 2);
        assert_eq!(front.pop(), Some(([2, 0], false)));
        assert_eq!(front.pop(), Some(([1, 0], true)));
        front.queue([7, 0], 3, true);
        assert_eq!(drain(&mut front), [0, 7]);
    }

    #[test]
    fn without_room_it_is_a_stack() {
        let mut front = Front::new(0);
        front.queue([1, 0], 0, true);
        front.queue([2, 0], 9, true);
        assert_eq!(drain(&mut front), [2, 1]);
    }
}
