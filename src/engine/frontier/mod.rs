//! The frontier: a bounded priority queue of node pairs, a stack of pairs that are finished
//! depth-first before it, and, before both, the few pairs on the warm-start paths to the witnesses
//! of the previous frame.
//!
//! The queue has two parts, and in both the order depends only on the input.
//!
//! - [`Ranked`]: up to 64 pairs, the largest key first. It decides the first openings of a run
//!   that a budget may cut, where the order matters most, and its pushes are cheap.
//! - Linked lists in one arena of fixed capacity, with a mask of those that are not empty: constant
//!   time, by bucket, then last in first out, for distances and motions.

pub(crate) mod order;
mod ranked;

use crate::engine::expand::Keys;
use crate::tree::{MAX_HEIGHT, Node, WIDTH};
use alloc::boxed::Box;
use arrayvec::ArrayVec;
use core::iter::successors;
use punctual_geom::bits;
use ranked::Ranked;

/// Two nodes, each with the mask of its active children, those still of interest. All children of
/// inner nodes are active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pair {
    pub nodes: [u32; 2],
    pub active: [u8; 2],
}

impl Pair {
    pub const fn new(a: u32, b: u32) -> Self {
        Self {
            nodes: [a, b],
            active: [u8::MAX; 2],
        }
    }

    /// A node of one tree, for questions without a second one, and its key. The key is positive,
    /// because the bits of positive numbers have the order of the numbers.
    pub const fn keyed(node: u32, key: f32) -> Self {
        Self::new(node, key.to_bits())
    }

    /// The key of [`Pair::keyed`].
    pub const fn key(&self) -> f32 {
        f32::from_bits(self.nodes[1])
    }
}

/// Where a pair was taken from. Most of its children go there too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A warm-start path to a witness of the previous frame.
    Path,
    /// The dive of a distance query: its children take its place.
    Dive,
    Stack,
    Queue,
    /// The nodes of one tree, which are compared with a body of one point or segment.
    Beside,
}

/// Maximum number of paths: one for each bit of a mask.
pub(crate) const PATHS: usize = 16;

/// Number of buckets; bucket 0 is visited first.
pub(crate) const BUCKETS: usize = 128;

/// Number of pairs popped by rank. Then all ranked pairs go on the stack, the oldest on top, as
/// after a hit: later the order of openings matters less, and ranking costs time.
const RANKED_POPS: u32 = 24;

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Entry {
    pair: Pair,
    key: f32,
    next: u32,
}

/// Node pairs still to be visited.
#[derive(Clone, Debug)]
pub(crate) struct Frontier {
    /// The last is opened first. Each has the mask of the witnesses below it.
    paths: ArrayVec<(Pair, u16), PATHS>,
    /// Witness mask of the path popped last. Kept here because carrying it in [`Origin`] slowed
    /// every pop.
    path_witnesses: u16,
    /// Key of the queued pair popped last.
    popped_key: f32,
    stack: Box<[Pair; STACK]>,
    height: usize,
    /// Entries below this height were set aside while paths were followed; they are popped after
    /// the last path.
    base: usize,
    ranked: Ranked,
    /// Number of pairs still to be popped by rank.
    ranked_pops: u32,
    arena: Box<[Entry]>,
    /// First entry of each bucket, or [`NONE`].
    lists: [u32; BUCKETS],
    /// Mask of the buckets that are not empty, 64 per word.
    occupied: [u64; BUCKETS / 64],
    free: u32,
    /// Number of entries of the arena that were ever used; the entries beyond are free too.
    touched: u32,
    queued: u32,
    peak: u32,
    jumps: u32,
}

impl Frontier {
    pub fn new(capacity: usize) -> Self {
        let capacity = capacity.min(NONE as usize - 1);
        Self {
            paths: ArrayVec::new_const(),
            path_witnesses: 0,
            popped_key: 0.0,
            stack: Box::new([Pair::new(0, 0); STACK]),
            height: 0,
            base: 0,
            ranked: Ranked::EMPTY,
            ranked_pops: RANKED_POPS,
            arena: alloc::vec![Entry { pair: Pair::new(0, 0), key: 0.0, next: NONE }; capacity]
                .into(),
            lists: [NONE; BUCKETS],
            occupied: [0; BUCKETS / 64],
            free: NONE,
            touched: 0,
            queued: 0,
            peak: 0,
            jumps: 0,
        }
    }

    pub fn clear(&mut self) {
        self.drop_all();
        (self.peak, self.jumps, self.ranked_pops) = (0, 0, RANKED_POPS);
    }

    pub fn drop_all(&mut self) {
        self.paths.clear();
        self.ranked.clear();
        self.clear_queue();
        (self.height, self.base) = (0, 0);
    }

    /// Puts a pair on the paths, if it has witnesses below it and there is room for its children.
    /// Returns true if it did.
    pub fn follow(&mut self, pair: Pair, witnesses: u16) -> bool {
        witnesses != 0
            && self.height <= BESIDE_PATHS
            && self.paths.try_push((pair, witnesses)).is_ok()
    }

    /// The mask of the witnesses below the path popped last.
    pub fn path_witnesses(&self) -> u16 {
        self.path_witnesses
    }

    /// Pushes a pair on the stack, where it is finished depth-first, before any queued pair.
    /// Returns its position.
    #[inline(always)]
    pub fn push(&mut self, pair: Pair) -> usize {
        debug_assert!(
            self.height < STACK,
            "the stack holds 64 pairs for each level of both trees"
        );
        let at = self.height;
        // The remainder removes the compiler's bounds check.
        self.stack[at % STACK] = pair;
        self.height = at + 1;
        at
    }

    #[inline(always)]
    pub fn push_all(&mut self, mask: u64, pair: impl Fn(u32) -> Pair) {
        for bit in bits(mask) {
            self.push(pair(bit as u32));
        }
    }

    /// Pushes the children of a mask on the stack ([`Pair::keyed`]). The one with the largest key
    /// is the first. Returns the one with the least key instead.
    #[inline(always)]
    pub fn push_nearest(
        &mut self,
        nodes: &[Node],
        first_child: u32,
        mut children: u32,
        keys: &[f32; WIDTH],
    ) -> Pair {
        let count = children.count_ones() as usize;
        // Sort key: the key, then the index.
        let mut next = || {
            let i = children.trailing_zeros();
            children &= children.wrapping_sub(1);
            u64::from(keys[i as usize % WIDTH].to_bits()) << 32 | u64::from(first_child + i)
        };
        let pair = |key: u64| Pair::new(key as u32, (key >> 32) as u32);
        // The copy of `is_leaf` is never read. Making it loads the node into the cache before the
        // pair is popped.
        let waiting = |pair: Pair| Pair {
            active: [
                nodes
                    .get(pair.nodes[0] as usize)
                    .is_some_and(|node| node.is_leaf)
                    .into(),
                0,
            ],
            ..pair
        };
        let first = next();
        if count == 1 {
            return pair(first);
        }
        let second = next();
        if count == 2 {
            self.push(waiting(pair(first.max(second))));
            return pair(first.min(second));
        }
        let mut sorted = [first.max(second), first.min(second), 0, 0, 0, 0, 0, 0];
        let mut i = 2;
        while i < count {
            let (key, mut at) = (next(), i);
            while at > 0 && sorted[(at - 1) % WIDTH] < key {
                sorted[at % WIDTH] = sorted[(at - 1) % WIDTH];
                at -= 1;
            }
            sorted[at % WIDTH] = key;
            i += 1;
        }
        for &key in &sorted[..count - 1] {
            self.push(waiting(pair(key)));
        }
        pair(sorted[(count - 1) % WIDTH])
    }

    /// Replaces the pair at a position of the stack.
    #[inline(always)]
    pub fn put(&mut self, at: usize, pair: Pair) {
        self.stack[at % STACK] = pair;
    }

    /// Swaps a pair of the stack with its top.
    #[inline(always)]
    pub fn raise(&mut self, at: usize) {
        self.stack.swap(at % STACK, (self.height - 1) % STACK);
    }

    /// Swaps another pair of the stack, a different one each time, with its top.
    pub fn go_elsewhere(&mut self) {
        let below = self.height.saturating_sub(1);
        if below > 0 && below < SCATTERED {
            self.jumps = self.jumps.wrapping_add(0x9e37_79b9);
            let other = (self.jumps as u64 * below as u64) >> 32;
            self.raise(other as usize);
        }
    }

    /// The key of the queued pair that was popped last.
    pub fn popped_key(&self) -> f32 {
        self.popped_key
    }

    /// Ranks the pair of each bit of `hits` ([`Ranked::push`]). Pairs that find no room go on the
    /// stack.
    #[inline(always)]
    pub fn rank_all(&mut self, hits: u64, keys: &Keys, share: f32, pair: impl Fn(u32) -> Pair) {
        let rest = self.ranked.push(hits, keys, share, &pair);
        self.push_all(rest, pair);
    }

    /// The pairs ranked so far go on the stack before the next one is popped. The oldest is on top:
    /// those near a hit are the newest, and its curve is traced.
    pub fn end_ranking(&mut self) {
        self.ranked_pops = 0;
    }

    /// Queues a pair as the first of `bucket`. A pair that finds no room is pushed on the stack.
    pub fn queue(&mut self, pair: Pair, key: f32, bucket: usize) {
        let slot = if self.free != NONE {
            let next = self.arena[self.free as usize].next;
            core::mem::replace(&mut self.free, next)
        } else if (self.touched as usize) < self.arena.len() {
            self.touched += 1;
            self.touched - 1
        } else {
            self.push(pair);
            return;
        };
        let next = core::mem::replace(&mut self.lists[bucket % BUCKETS], slot);
        self.arena[slot as usize] = Entry { pair, key, next };
        self.occupied[bucket / 64 % 2] |= 1 << (bucket % 64);
        self.queued += 1;
    }

    /// Sets aside all pairs on the stack until the paths are finished.
    pub fn set_aside(&mut self) {
        self.base = self.height;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<(Pair, Origin)> {
        if self.height > self.base {
            return Some((self.pop_stack()?, Origin::Stack));
        }
        if self.ranked_pops > 0 && self.paths.is_empty() && self.base == 0 {
            self.note_peak();
            if let Some(pair) = self.ranked.pop() {
                self.ranked_pops -= 1;
                return Some((pair, Origin::Queue));
            }
        }
        let origin = self.refill()?;
        Some((self.pop_stack()?, origin))
    }

    /// Pops the pair of the stack with the least key ([`Pair::keyed`]), the last of several. Drops
    /// those whose keys are not below `cut`, and lowers `dropped` to their least key.
    #[inline(always)]
    pub fn pop_least(&mut self, cut: f32, dropped: &mut f32) -> Option<Pair> {
        let (mut kept, mut least, mut at) = (0, f32::INFINITY, 0);
        for i in 0..self.height {
            let pair = self.stack[i % STACK];
            let key = pair.key();
            if key < cut {
                if key <= least {
                    (least, at) = (key, kept);
                }
                self.stack[kept % STACK] = pair;
                kept += 1;
            } else {
                *dropped = dropped.min(key);
            }
        }
        self.height = kept;
        if kept > 0 {
            self.raise(at);
        }
        self.pop_stack()
    }

    /// Pops the last pair of the stack, except those set aside.
    #[inline(always)]
    pub fn pop_stack(&mut self) -> Option<Pair> {
        if self.height == self.base {
            return None;
        }
        self.height -= 1;
        // Part by part, as it was pushed: loading what two stores wrote would wait until both are
        // in the cache.
        let Pair {
            nodes: [a, b],
            active: [of_a, of_b],
        } = self.stack[self.height % STACK];
        Some(Pair {
            nodes: [a, b],
            active: [of_a, of_b],
        })
    }

    /// Pushes the next pair on the stack when nothing is above its base. Returns where the pair
    /// came from.
    #[cold]
    #[inline(never)]
    fn refill(&mut self) -> Option<Origin> {
        if let Some((pair, witnesses)) = self.paths.pop() {
            self.path_witnesses = witnesses;
            self.push(pair);
            return Some(Origin::Path);
        }
        if self.base > 0 {
            self.base = 0;
            return Some(Origin::Stack);
        }
        if self.ranked.len() > 0 {
            self.note_peak();
            for at in (0..self.ranked.len()).rev() {
                self.push(self.ranked.pair(at));
            }
            self.ranked.clear();
            return Some(Origin::Stack);
        }
        let pair = self.pop_queue()?;
        self.push(pair);
        Some(Origin::Queue)
    }

    #[inline(always)]
    fn pop_queue(&mut self) -> Option<Pair> {
        let bucket = self.first_bucket()? % BUCKETS;
        let slot = self.lists[bucket];
        let Entry { pair, key, next } = self.arena[slot as usize];
        self.popped_key = key;
        self.lists[bucket] = next;
        if next == NONE {
            self.occupied[bucket / 64] &= !(1 << (bucket % 64));
        }
        self.arena[slot as usize].next = core::mem::replace(&mut self.free, slot);
        self.note_peak();
        self.queued -= 1;
        Some(pair)
    }

    /// The first bucket that is not empty.
    #[inline(always)]
    fn first_bucket(&self) -> Option<usize> {
        let [low, high] = self.occupied;
        match (low, high) {
            (0, 0) => None,
            (0, high) => Some(64 + high.trailing_zeros() as usize),
            (low, _) => Some(low.trailing_zeros() as usize),
        }
    }

    /// The first bucket that is not empty; 0 if pairs are left outside the queue, `None` if no pair
    /// is left.
    pub fn least_bucket(&self) -> Option<usize> {
        if self.paths.is_empty() && self.height == 0 {
            self.first_bucket()
        } else {
            Some(0)
        }
    }

    /// Number of pairs that the queue has room for.
    pub fn room(&self) -> usize {
        self.arena.len() - self.queued as usize
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.paths.len() + self.height + self.ranked.len() + self.queued as usize
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Maximum number of pairs in the queue at one time.
    pub fn peak(&self) -> u32 {
        self.peak.max(self.queued + self.ranked.len() as u32)
    }

    #[inline(always)]
    fn note_peak(&mut self) {
        self.peak = self.peak();
    }

    pub fn clear_queue(&mut self) {
        self.note_peak();
        while let Some(bucket) = self.first_bucket() {
            self.lists[bucket] = NONE;
            self.occupied[bucket / 64] &= !(1 << (bucket % 64));
        }
        (self.free, self.touched, self.queued) = (NONE, 0, 0);
    }

    /// The pairs on the stack, from its top.
    pub fn stack(&self) -> impl Iterator<Item = Pair> + '_ {
        self.stack[..self.height].iter().rev().copied()
    }

    /// All pairs: those on paths, those of the stack from its top, the ranked ones, and the queued
    /// ones in the order in which they would be popped.
    pub fn iter(&self) -> impl Iterator<Item = Pair> + '_ {
        let paths = self.paths.iter().map(|(pair, _)| *pair);
        let entry = |slot: u32| (slot != NONE).then(|| &self.arena[slot as usize]);
        let list = move |first: u32| successors(entry(first), move |last| entry(last.next));
        let queued = self.lists.iter().flat_map(move |&first| list(first));
        let ranked = (0..self.ranked.len()).map(|at| self.ranked.pair(at));
        paths
            .chain(self.stack())
            .chain(ranked)
            .chain(queued.map(|entry| entry.pair))
    }
}

/// Room for 63 siblings on each level of both trees, for the children of the pair that found the
/// queue full, and for the pairs set aside next to the paths.
const STACK: usize = 1 << 14;

// The triangles are one more level.
const _: () = assert!(STACK >= 64 * 2 * (MAX_HEIGHT + 1) + SCATTERED + BESIDE_PATHS + 64 * PATHS);

/// With more pairs on the stack than this, no path is followed. Each started path adds its
/// siblings.
const BESIDE_PATHS: usize = 2048;

/// With this many pairs on the stack or more, the next one is not chosen from elsewhere.
const SCATTERED: usize = 512;

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn drain(frontier: &mut Frontier) -> Vec<u32> {
        core::iter::from_fn(|| frontier.pop())
            .map(|(pair, _)| pair.nodes[0])
            .collect()
    }

    #[test]
    fn the_stack_goes_first_then_the_buckets_in_turn() {
        let mut frontier = Frontier::new(8);
        for (i, bucket) in [(0, 5), (1, 0), (2, 127), (3, 0)] {
            frontier.queue(Pair::new(i, 0), 0.0, bucket);
        }
        frontier.push(Pair::new(9, 0));
        frontier.push(Pair::new(8, 0));
        frontier.raise(0);
        assert_eq!(frontier.iter().count(), 6);
        assert_eq!(drain(&mut frontier), [9, 8, 3, 1, 0, 2]);
        assert!(frontier.is_empty());
    }

    #[test]
    fn paths_go_first_and_what_is_beside_them_waits_for_their_ends() {
        let pair = |i| Pair::new(i, 0);
        let mut frontier = Frontier::new(8);
        assert!(!frontier.follow(pair(9), 0) && frontier.follow(pair(0), 0b11));
        assert_eq!(
            (frontier.pop(), frontier.path_witnesses()),
            (Some((pair(0), Origin::Path)), 0b11)
        );
        frontier.push(pair(1));
        frontier.queue(pair(2), 0.0, 0);
        assert!(frontier.follow(pair(3), 0b01) && frontier.follow(pair(4), 0b10));
        frontier.set_aside();
        assert_eq!(
            (frontier.pop(), frontier.path_witnesses()),
            (Some((pair(4), Origin::Path)), 0b10)
        );
        frontier.push(pair(5));
        assert_eq!(frontier.iter().count(), 4);
        assert_eq!(frontier.pop(), Some((pair(5), Origin::Stack)));
        assert_eq!(frontier.pop(), Some((pair(3), Origin::Path)));
        frontier.push(pair(6));
        frontier.set_aside();
        assert_eq!(drain(&mut frontier), [6, 1, 2]);
        assert!(frontier.is_empty());
    }

    #[test]
    fn a_high_stack_ends_the_paths() {
        let mut frontier = Frontier::new(0);
        for i in 0..=BESIDE_PATHS as u32 {
            assert!(frontier.follow(Pair::new(i, 0), 1));
            frontier.pop();
            frontier.push(Pair::new(i, 0));
            frontier.set_aside();
        }
        assert!(!frontier.follow(Pair::new(0, 0), 1));
        assert_eq!(drain(&mut frontier).len(), BESIDE_PATHS + 1);
    }

    #[test]
    fn a_full_queue_loses_nothing_and_uses_freed_room_again() {
        let mut frontier = Frontier::new(2);
        for i in 0..3 {
            frontier.queue(Pair::new(i, 0), 0.0, 0);
        }
        assert_eq!(frontier.peak(), 2);
        assert_eq!(frontier.pop(), Some((Pair::new(2, 0), Origin::Stack)));
        assert_eq!(frontier.pop(), Some((Pair::new(1, 0), Origin::Queue)));
        frontier.queue(Pair::new(7, 0), 0.0, 3);
        assert_eq!(drain(&mut frontier), [0, 7]);
    }

    #[test]
    fn without_room_it_is_a_stack() {
        let mut frontier = Frontier::new(0);
        frontier.queue(Pair::new(1, 0), 0.0, 0);
        frontier.queue(Pair::new(2, 0), 0.0, 9);
        assert_eq!(drain(&mut frontier), [2, 1]);
    }
}
