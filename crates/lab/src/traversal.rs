//! The paper's Algorithm 1, counted: the simultaneous traversal that the model is about.
//!
//! `traverse(A, B)`: no overlap, return; both leaves, test the primitives; else all pairs of children. This counts for the
//! model's sake, on any binary tree of boxes; queries have a loop of their own ([`punctual::Query`]).

use std::slice::from_ref;

use punctual::intersection::Intersection;
use punctual::{Answer, Budget, PairMemory, Query, StopReason, Verdict, Workspace};

/// A node of a binary tree of boxes, placed in space.
pub trait BinaryNode: Copy {
    /// Whether the boxes share a point.
    fn overlaps(&self, other: &Self) -> bool;

    /// The two nodes below; `None` for a leaf.
    fn children(&self) -> Option<[Self; 2]>;
}

/// What Algorithm 1 visits.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Overlapping pairs on each level, that of the roots first; a leaf goes down with its partner. The paper's `N^(l)`.
    pub overlapping: Vec<u64>,
    /// Overlap tests, the one of the roots included.
    pub bv_tests: u64,
    /// Pairs of leaves that overlap, `N_p`.
    pub leaf_pairs: u64,
}

impl Visits {
    /// Traverses two trees to the end. Time in the order of `bv_tests`; memory of the sum of the depths.
    pub fn count<N: BinaryNode>(a: N, b: N) -> Self {
        let mut visits = Self::default();
        visits.traverse(a, b, 0);
        visits
    }

    /// `N_v`: all overlapping pairs, as the sums of [`super::paper`] from level 0 on.
    pub fn total(&self) -> u64 {
        self.overlapping.iter().sum()
    }

    fn traverse<N: BinaryNode>(&mut self, a: N, b: N, level: usize) {
        self.bv_tests += 1;
        if !a.overlaps(&b) {
            return;
        }
        if self.overlapping.len() <= level {
            self.overlapping.push(0);
        }
        self.overlapping[level] += 1;
        let (of_a, of_b) = (a.children(), b.children());
        if of_a.is_none() && of_b.is_none() {
            self.leaf_pairs += 1;
            return;
        }
        for &a in of_a.as_ref().map_or(from_ref(&a), |of_a| of_a) {
            for &b in of_b.as_ref().map_or(from_ref(&b), |of_b| of_b) {
                self.traverse(a, b, level + 1);
            }
        }
    }
}

/// A whole query of the library; `report` is told its pairs.
pub fn complete(
    query: &Query<Intersection>,
    workspace: &mut Workspace,
    report: impl FnMut([u32; 2]),
) -> Answer<Verdict> {
    let outcome = query.run(workspace, Budget::unlimited());
    advance(query, workspace, None, outcome, None, report)
}

/// Goes on with a query of the library until it has done work up to a limit, if there is one, however
/// often the pair buffer fills.
pub fn advance(
    query: &Query<Intersection>,
    workspace: &mut Workspace,
    mut memory: Option<&mut PairMemory>,
    mut outcome: Answer<Verdict>,
    limit: Option<u64>,
    mut report: impl FnMut([u32; 2]),
) -> Answer<Verdict> {
    workspace.drain_pairs().for_each(&mut report);
    loop {
        let budget = limit.map_or(Budget::unlimited(), |limit| {
            Budget::work(limit.saturating_sub(outcome.stats.work))
        });
        let begun = query.with_memory(memory.as_deref_mut());
        let Ok(next) = begun.resume(workspace, budget) else {
            return outcome;
        };
        outcome = next;
        workspace.drain_pairs().for_each(&mut report);
        if outcome.stop != StopReason::PairsFull {
            return outcome;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dyadic intervals of the unit interval, `2^depth` leaves, moved to the right.
    #[derive(Clone, Copy)]
    struct Interval {
        min: f64,
        size: f64,
        depth: u32,
    }

    impl BinaryNode for Interval {
        fn overlaps(&self, other: &Self) -> bool {
            self.min <= other.min + other.size && other.min <= self.min + self.size
        }

        fn children(&self) -> Option<[Self; 2]> {
            let size = self.size / 2.0;
            let child = |min| Self {
                min,
                size,
                depth: self.depth - 1,
            };
            (self.depth > 0).then(|| [child(self.min), child(self.min + size)])
        }
    }

    fn unit(min: f64, depth: u32) -> Interval {
        Interval {
            min,
            size: 1.0,
            depth,
        }
    }

    #[test]
    fn counts_by_hand() {
        let apart = Visits::count(unit(0.0, 5), unit(1.5, 5));
        assert_eq!(
            apart,
            Visits {
                overlapping: vec![],
                bv_tests: 1,
                leaf_pairs: 0
            }
        );
        // Touching at one point: one pair a level.
        let touching = Visits::count(unit(0.0, 5), unit(1.0, 5));
        assert_eq!(
            (touching.overlapping, touching.bv_tests, touching.leaf_pairs),
            (vec![1; 6], 21, 1)
        );
        // Coincident: on level l the 2^l intervals meet themselves and their neighbours.
        let same = Visits::count(unit(0.0, 4), unit(0.0, 4));
        assert_eq!(same.overlapping, [1, 4, 10, 22, 46]);
        assert_eq!(
            (same.total(), same.leaf_pairs, same.bv_tests),
            (83, 46, 1 + 4 * (83 - 46))
        );
    }

    #[test]
    fn a_leaf_waits_for_the_deeper_tree() {
        let visits = Visits::count(unit(0.0, 0), unit(0.75, 3));
        // The last quarter of the leaf meets the first two of eight intervals, and touches the third.
        assert_eq!(visits.overlapping, [1, 1, 2, 3]);
        assert_eq!(visits.leaf_pairs, 3);
        assert_eq!(Visits::count(unit(0.75, 3), unit(0.0, 0)), visits);
    }
}
