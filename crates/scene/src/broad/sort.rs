//! A merge sort that may stop between any two steps: `O(n log n)`, in `n` words of memory.

use crate::cost::WORK_PER_SORTED_KEY;
use crate::id::PairKey;
use crate::room::reserve;
use alloc::vec::Vec;
use core::mem;
use punctual::engine::Deadline;

/// Keys per step.
const STEP: usize = 16;

/// Work per key of a sort without interruption, for up to as many keys as fit into memory.
const WORK_AT_ONCE: u64 = 3 * WORK_PER_SORTED_KEY;

#[derive(Clone, Debug, Default)]
pub(crate) struct Sort {
    /// The output of the current pass.
    merged: Vec<PairKey>,
    /// Length of the sorted runs. While the first runs are made, `runs` counts the keys that are in
    /// runs.
    width: usize,
    runs: usize,
    /// The next keys of the two current runs.
    next: [usize; 2],
}

impl Sort {
    pub fn reserve(&mut self, keys: usize) {
        reserve(&mut self.merged, keys);
    }

    /// Sorts keys as far as the deadline allows; true if they are sorted. The keys must not change
    /// until then.
    pub fn advance(&mut self, keys: &mut Vec<PairKey>, deadline: &mut Deadline) -> bool {
        let at_once = keys.len() as u64 * WORK_AT_ONCE;
        if self.runs == 0 && deadline.has_room(at_once) {
            deadline.spend(at_once);
            keys.sort_unstable();
            return true;
        }
        while self.runs < keys.len() {
            if !deadline.has_room(STEP as u64 * WORK_AT_ONCE) {
                return false;
            }
            deadline.spend(STEP as u64 * WORK_AT_ONCE);
            let end = keys.len().min(self.runs + STEP);
            keys[self.runs..end].sort_unstable();
            (self.runs, self.width) = (end, STEP);
        }
        while self.width < keys.len() {
            while self.merged.len() < keys.len() {
                if !deadline.has_room(STEP as u64 * WORK_PER_SORTED_KEY) {
                    return false;
                }
                deadline.spend(STEP as u64 * WORK_PER_SORTED_KEY);
                self.step(keys);
            }
            mem::swap(keys, &mut self.merged);
            self.merged.clear();
            self.width *= 2;
        }
        (self.runs, self.width) = (0, 0);
        true
    }

    /// Merges the next keys of a pair of runs.
    fn step(&mut self, keys: &[PairKey]) {
        let begin = self.merged.len() / (2 * self.width) * (2 * self.width);
        let (middle, end) = (
            keys.len().min(begin + self.width),
            keys.len().min(begin + 2 * self.width),
        );
        if self.merged.len() == begin {
            self.next = [begin, middle];
        }
        let [mut left, mut right] = self.next;
        for _ in self.merged.len()..end.min(self.merged.len() + STEP) {
            let from = if right == end || left < middle && keys[left] <= keys[right] {
                &mut left
            } else {
                &mut right
            };
            self.merged.push(keys[*from]);
            *from += 1;
        }
        self.next = [left, right];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::clock::ManualClock;

    #[test]
    fn whatever_it_is_stopped_by_the_keys_are_sorted() {
        let clock = ManualClock::new();
        for length in [0, 1, 63, 64, 65, 128, 1_000, 4_097] {
            let mut keys: Vec<PairKey> = (0..length)
                .map(|i: u64| i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40)
                .collect();
            let mut expected = keys.clone();
            expected.sort_unstable();
            let (mut sort, mut calls) = (Sort::default(), 0);
            while !sort.advance(
                &mut keys,
                &mut Deadline::at(None, STEP as u64 * WORK_AT_ONCE, &clock),
            ) {
                calls += 1;
            }
            assert_eq!(keys, expected);
            assert!(
                calls > 0 || length <= STEP as u64,
                "{length} keys are sorted at once"
            );
        }
    }
}
