//! The set of cluster pairs whose triangles have been compared, so that none is visited twice.
//!
//! A hash table with linear probing, of fixed capacity; expected constant time. Pairs are only added.

use alloc::boxed::Box;
use alloc::vec::Vec;

/// No pair: node numbers are below 2^31.
const FREE: u64 = u64::MAX;

#[derive(Debug)]
pub(super) struct Visited {
    /// At least twice as many as there is room for, a power of two.
    slots: Box<[u64]>,
    /// Those in use.
    used: Vec<u32>,
    /// Most of them.
    room: usize,
}

impl Visited {
    pub fn new(capacity: usize) -> Self {
        let slots = (2 * capacity).next_power_of_two().max(2);
        Self { slots: alloc::vec![FREE; slots].into(), used: Vec::with_capacity(capacity), room: capacity }
    }

    /// Forgets all pairs, in time linear in their number.
    pub fn clear(&mut self) {
        for slot in self.used.drain(..) {
            self.slots[slot as usize] = FREE;
        }
    }

    /// Adds a pair, if it is wanted and there is room. False if it was there.
    #[inline(always)]
    pub fn add(&mut self, pair: [u32; 2], is_wanted: impl FnOnce() -> bool) -> bool {
        let slot = self.slot(pair);
        if self.slots[slot] != FREE {
            return false;
        }
        if !self.is_full() && is_wanted() {
            self.slots[slot] = key(pair);
            self.used.push(slot as u32);
        }
        true
    }

    /// Becomes a copy of another set with as much room.
    pub fn copy_from(&mut self, other: &Self) {
        debug_assert_eq!(self.room, other.room);
        self.clear();
        for &slot in &other.used {
            self.slots[slot as usize] = other.slots[slot as usize];
            self.used.push(slot);
        }
    }

    pub fn is_full(&self) -> bool {
        self.used.len() == self.room
    }

    #[inline]
    pub fn contains(&self, pair: [u32; 2]) -> bool {
        self.slots[self.slot(pair)] != FREE
    }

    /// Where the pair is, or would be.
    #[inline(always)]
    fn slot(&self, pair: [u32; 2]) -> usize {
        let (key, mask) = (key(pair), self.slots.len() - 1);
        let mut slot = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        while self.slots[slot] != FREE && self.slots[slot] != key {
            slot = (slot + 1) & mask;
        }
        slot
    }
}

#[inline(always)]
fn key([a, b]: [u32; 2]) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

impl Clone for Visited {
    /// With the room of the original.
    fn clone(&self) -> Self {
        let mut used = Vec::with_capacity(self.room);
        used.extend_from_slice(&self.used);
        Self { slots: self.slots.clone(), used, room: self.room }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_known_once_added_and_unknown_once_cleared() {
        let mut visited = Visited::new(1000);
        for round in 0..3 {
            let pairs = || (0..1000).map(|i| [i % 7, i + round]);
            for pair in pairs() {
                assert!(!visited.contains(pair) && !visited.is_full());
                assert!(visited.add(pair, || false) && !visited.contains(pair));
                assert!(visited.add(pair, || true));
            }
            for pair in pairs() {
                assert!(visited.contains(pair));
                assert!(!visited.add(pair, || true));
            }
            for mut full in [visited.clone(), visited.clone().clone()] {
                assert!(full.is_full() && full.add([9, 9], || true) && !full.contains([9, 9]));
            }
            visited.clear();
        }
        assert!(visited.clone().add([9, 9], || true));
    }

    #[test]
    fn without_room_nothing_is_known() {
        let mut visited = Visited::new(0);
        assert!(visited.is_full());
        assert_eq!([1, 1].map(|i| visited.add([i, i], || true)), [true; 2]);
    }
}
