//! The priority queue of the first openings of a run that a budget may cut, where the order of
//! visits matters most.

use super::Pair;
use crate::engine::expand::{Keys, key_of};

/// Maximum number of pairs: the slot of a pair is in the low six bits of its rank.
const SLOTS: usize = 64;

/// Pairs and their ranks in no order. A pop compares all slots, because a branch on their number
/// would be mispredicted.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Ranked {
    /// The bits of each key, with the slot in the last six; 0 beyond `len`.
    ranks: [u32; SLOTS],
    /// The nodes of each pair, A's in the low half, and their active children. Each is written by
    /// one store: loading what two stores wrote would wait until both are in the cache.
    nodes: [u64; SLOTS],
    active: [u16; SLOTS],
    len: usize,
    /// True until a leaf is reached. The best child of the pair opened last is popped then: many
    /// hits are near the first leaf, and it leaves siblings of all levels to compare.
    is_diving: bool,
    /// The slot of the best of the pairs pushed since the last pop.
    newest: Option<usize>,
}

impl Ranked {
    pub const EMPTY: Self = Self {
        ranks: [0; SLOTS],
        nodes: [0; SLOTS],
        active: [0; SLOTS],
        len: 0,
        is_diving: true,
        newest: None,
    };

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// The pair at a slot. The slots are in use from the first one on, roughly by age.
    #[inline(always)]
    pub fn pair(&self, at: usize) -> Pair {
        let nodes = self.nodes[at % SLOTS];
        Pair {
            nodes: [nodes as u32, (nodes >> 32) as u32],
            active: self.active[at % SLOTS].to_le_bytes(),
        }
    }

    pub fn clear(&mut self) {
        self.ranks = Self::EMPTY.ranks;
        (self.len, self.is_diving, self.newest) = (0, true, None);
    }

    /// Puts a pair at a slot. Returns its rank.
    #[inline(always)]
    fn put(&mut self, at: usize, key: u32, pair: Pair) -> u32 {
        let rank = key & !(SLOTS as u32 - 1) | at as u32;
        self.ranks[at % SLOTS] = rank;
        let [a, b] = pair.nodes.map(u64::from);
        self.nodes[at % SLOTS] = a | b << 32;
        self.active[at % SLOTS] = u16::from_le_bytes(pair.active);
        rank
    }

    /// Adds the pair of each bit of `hits`. The larger its key, which is not negative, times
    /// `share`, the earlier it is popped. Returns the bits that found no room.
    #[inline(always)]
    pub fn push(
        &mut self,
        mut hits: u64,
        keys: &Keys,
        share: f32,
        pair: impl Fn(u32) -> Pair,
    ) -> u64 {
        let (mut len, mut best) = (self.len, 0);
        while hits != 0 && len < SLOTS {
            let bit = hits.trailing_zeros();
            hits &= hits - 1;
            let key = (key_of(keys, bit as usize) * share).to_bits();
            best = self.put(len, key, pair(bit)).max(best);
            len += 1;
        }
        self.newest = (len > self.len).then_some(best as usize % SLOTS);
        self.len = len;
        hits
    }

    /// Removes the pair with the largest rank; while diving, of those pushed last.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<Pair> {
        self.len = self.len.checked_sub(1)?;
        let newest = self.newest.take();
        self.is_diving &= newest.is_some();
        let at = match newest {
            Some(newest) if self.is_diving => newest,
            _ => self.ranks.iter().fold(0, |most, &rank| most.max(rank)) as usize % SLOTS,
        };
        let pair = self.pair(at);
        let last = self.len % SLOTS;
        self.put(at, self.ranks[last], self.pair(last));
        self.ranks[last] = 0;
        Some(pair)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn push(ranked: &mut Ranked, first: u32, keys: &[f32], share: f32) -> u64 {
        let mut all = Keys::default();
        all.as_flattened_mut()[..keys.len()].copy_from_slice(keys);
        let hits = u64::MAX >> (64 - keys.len());
        ranked.push(hits, &all, share, |i| Pair::new(first + i, 7))
    }

    #[test]
    fn a_dive_takes_the_best_child_until_a_leaf_then_the_best_pair_of_all() {
        let mut ranked = Ranked::EMPTY;
        for _ in 0..2 {
            push(&mut ranked, 0, &[0.0], 0.0);
            let mut pop = |first, keys: &[f32], share| {
                let pair = ranked.pop();
                if !keys.is_empty() {
                    push(&mut ranked, first, keys, share);
                }
                pair.map(|pair| pair.nodes[0])
            };
            assert_eq!(pop(10, &[8.0, 9.0], 1.0), Some(0));
            assert_eq!(pop(20, &[1.0, 3.0, 2.0], 2.0), Some(11));
            assert_eq!(
                pop(0, &[], 0.0),
                Some(21),
                "deepest, though 10 has a larger key"
            );
            assert_eq!(pop(30, &[5.0], 1.0), Some(10), "the last had no children");
            assert_eq!(
                [0; 4].map(|_| pop(0, &[], 0.0)),
                [Some(30), Some(22), Some(20), None]
            );
            ranked.clear();
        }
    }

    #[test]
    fn what_finds_no_room_is_returned_and_the_rest_comes_by_rank() {
        let mut ranked = Ranked::EMPTY;
        let keys: Vec<f32> = (0..40).map(|i| (i * 17 % 40) as f32).collect();
        assert_eq!(push(&mut ranked, 0, &keys, 1.0), 0);
        assert_eq!(
            push(&mut ranked, 100, &keys, 0.5),
            u64::MAX >> 24 & !((1 << 24) - 1)
        );
        ranked.newest = None;
        let popped: Vec<Pair> = core::iter::from_fn(|| ranked.pop()).collect();
        let key = |pair: &Pair| match pair.nodes[0] {
            i @ 100.. => 0.5 * keys[i as usize - 100],
            i => keys[i as usize],
        };
        assert_eq!((popped.len(), ranked.len()), (64, 0));
        assert!(
            popped
                .iter()
                .all(|pair| pair.nodes[1] == 7 && pair.active == [u8::MAX; 2])
        );
        assert!(popped.is_sorted_by(|x, y| key(x) >= key(y)));
    }
}
