//! A heap sort in place that may stop between any two steps: `O(n log n)`.

use crate::cost::WORK_PER_SORTED_KEY;
use crate::id::PairKey;
use punctual::engine::Deadline;

/// Work per key of a sort without interruption, for up to as many keys as fit into memory.
const WORK_AT_ONCE: u64 = 3 * WORK_PER_SORTED_KEY;

#[derive(Clone, Debug, Default)]
pub(crate) struct Sort {
    /// Number of steps done. The first half of them make the keys a heap, the largest on top; each
    /// of the others moves the top behind the heap.
    done: usize,
}

impl Sort {
    /// Sorts keys as far as the deadline allows; true if they are sorted. The keys must not change
    /// until then.
    pub fn advance(&mut self, keys: &mut [PairKey], deadline: &mut Deadline) -> bool {
        let at_once = keys.len() as u64 * WORK_AT_ONCE;
        if self.done == 0 && deadline.has_room(at_once) {
            deadline.spend(at_once);
            keys.sort_unstable();
            return true;
        }
        let half = keys.len() / 2;
        let work = WORK_PER_SORTED_KEY * u64::from(keys.len().max(2).ilog2());
        while self.done < half + keys.len() {
            if !deadline.has_room(work) {
                return false;
            }
            deadline.spend(work);
            match self.done.checked_sub(half) {
                None => sink(keys, half - 1 - self.done),
                Some(behind) => {
                    let last = keys.len() - 1 - behind;
                    keys.swap(0, last);
                    sink(&mut keys[..last], 0);
                }
            }
            self.done += 1;
        }
        self.done = 0;
        true
    }
}

/// Moves a key below the larger ones under it, which are heaps.
fn sink(keys: &mut [PairKey], mut at: usize) {
    while let Some(&left) = keys.get(2 * at + 1) {
        let is_right = keys.get(2 * at + 2).is_some_and(|&right| right > left);
        let below = 2 * at + 1 + usize::from(is_right);
        if keys[below] <= keys[at] {
            return;
        }
        keys.swap(at, below);
        at = below;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use punctual::clock::ManualClock;

    #[test]
    fn whatever_it_is_stopped_by_the_keys_are_sorted() {
        let clock = ManualClock::new();
        for length in [0, 1, 2, 63, 64, 65, 128, 1_000, 4_097] {
            let mut keys: Vec<PairKey> = (0..length)
                .map(|i: u64| i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40)
                .collect();
            let mut expected = keys.clone();
            expected.sort_unstable();
            let (mut sort, mut calls) = (Sort::default(), 0);
            while !sort.advance(&mut keys, &mut Deadline::at(None, 1_000, &clock)) {
                calls += 1;
            }
            assert_eq!(keys, expected);
            assert!(calls > 0 || length < 63, "{length} keys are sorted at once");
        }
    }
}
