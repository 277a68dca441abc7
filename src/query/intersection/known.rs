//! The triangle pairs known to intersect, so that none is reported twice: a mask of 64 bits for
//! each pair of leaves with such pairs.
//!
//! A hash table with linear probing and fixed capacity; expected constant time. Pairs are only
//! added. The slots are small, because they are accessed at random and most are free; the entries
//! are dense. A slot is taken if its entry names it, so clearing the entries frees all slots.

use crate::room::Room;
use alloc::boxed::Box;

/// Maximum number of pairs of leaves, and twice as many slots.
pub(crate) const ROOM: usize = 1 << 12;
const SLOTS: usize = 2 * ROOM;

/// Stands for no entry: one more than the last index.
const FREE: usize = ROOM;

/// A pair of leaves and the mask of their known triangle pairs: bit `8 i + j` for triangle `i` of
/// A's leaf and `j` of B's.
#[derive(Clone, Copy, Debug)]
struct Entry {
    first: [u32; 2],
    known: u64,
    slot: u16,
}

#[derive(Clone, Debug)]
pub(crate) struct Known {
    /// Index of the entry, if that names the slot; anything else if the slot is free.
    slots: Box<[u16; SLOTS]>,
    /// Never grows beyond its first capacity.
    entries: Room<Entry>,
}

/// The result of adding a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Added {
    New,
    Known,
    /// The pair is unknown, and there is no room to add it.
    NoRoom,
}

impl Known {
    pub fn new(capacity: usize) -> Self {
        Self {
            slots: Box::new([0; SLOTS]),
            entries: Room::new(capacity.min(ROOM)),
        }
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Removes all pairs, in constant time.
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Adds a pair of the leaves whose first triangles are `first`.
    #[inline(always)]
    pub fn add(&mut self, first: [u32; 2], pair: [u32; 2]) -> Added {
        let (slot, at) = self.find(first);
        let bit = bit(first, pair);
        if let Some(entry) = self.entries.get_mut(at) {
            let before = entry.known;
            entry.known |= bit;
            return if entry.known == before {
                Added::Known
            } else {
                Added::New
            };
        }
        if self.entries.len() == self.entries.capacity() {
            return Added::NoRoom;
        }
        self.slots[slot] = self.entries.len() as u16;
        let (known, slot) = (bit, slot as u16);
        self.entries.push(Entry { first, known, slot });
        Added::New
    }

    /// The mask of known pairs of two leaves.
    #[inline(always)]
    pub fn of(&self, first: [u32; 2]) -> u64 {
        self.entries
            .get(self.find(first).1)
            .map_or(0, |entry| entry.known)
    }

    /// True if a pair of the leaves whose first triangles are `first` is known.
    pub fn has(&self, first: [u32; 2], pair: [u32; 2]) -> bool {
        self.of(first) & bit(first, pair) != 0
    }

    /// The slot and entry of two leaves; if they have none, the slot where they would go and
    /// [`FREE`].
    #[inline(always)]
    fn find(&self, first: [u32; 2]) -> (usize, usize) {
        let mut slot =
            ((first[0].wrapping_mul(0x9e37_79b1) >> 16) + (first[1] >> 1)) as usize % SLOTS;
        loop {
            let at = usize::from(self.slots[slot]);
            match self.entries.get(at) {
                Some(entry) if usize::from(entry.slot) != slot => return (slot, FREE),
                Some(entry) if entry.first != first => slot = (slot + 1) % SLOTS,
                Some(_) => return (slot, at),
                None => return (slot, FREE),
            }
        }
    }
}

/// The bit of a triangle pair of two leaves.
#[inline(always)]
fn bit(first: [u32; 2], pair: [u32; 2]) -> u64 {
    1 << ((8 * (pair[0] - first[0]) + (pair[1] - first[1])) & 63)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_known_once_added_and_unknown_once_cleared() {
        let mut known = Known::new(100);
        for round in 0..3 {
            let leaves = || (0..100).map(|i| [7 * (i % 5), 8 * i + round]);
            for (i, first) in leaves().enumerate() {
                assert_eq!(known.of(first), 0);
                let pair = [first[0] + i as u32 % 8, first[1] + 7];
                assert_eq!(
                    [known.add(first, pair), known.add(first, pair)],
                    [Added::New, Added::Known]
                );
                assert_eq!(known.add(first, first), Added::New);
                assert_eq!(known.of(first), 1 | 1 << (8 * (i % 8) + 7));
            }
            for mut full in [known.clone(), known.clone().clone()] {
                assert_eq!(
                    [full.add([9, 9], [9, 9]), full.add([9, 9], [9, 9])],
                    [Added::NoRoom; 2]
                );
                assert!(leaves().all(|first| full.of(first) == known.of(first)));
            }
            known.clear();
        }
        assert_eq!(known.clone().add([9, 9], [9, 9]), Added::New);
    }

    #[test]
    fn without_room_nothing_is_known() {
        let mut known = Known::new(0);
        assert_eq!(
            [1, 1].map(|i| known.add([i, i], [i, i])),
            [Added::NoRoom; 2]
        );
    }
}
