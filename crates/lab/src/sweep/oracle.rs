//! The oracle: what the best order of visits would know, and when.
//!
//! It knows the truth: which node pairs lead to intersections, how many, and at what cost. It chooses the order in which node
//! pairs are opened, and never opens one that leads nowhere. It pays, at the engine's own weights of work, all that no order
//! can avoid: for each pair that it opens, the tests of all its children's boxes, also of those that lead nowhere; for each
//! pair of leaves, the tests of all triangle pairs that the boxes leave, also of those that do not meet. (Tests in doubt,
//! which are then made exactly, are not charged: the oracle is a little too good.)
//!
//! Of all such orders it takes the best for each budget: no order finds more pairs by then. That is a known problem, jobs
//! with costs and gains, each of which must wait for its parent. The pieces with the largest gain for their cost come first;
//! their ends lie on the upper concave hull of all that any order reaches (J. B. Sidney, "Decomposition algorithms for
//! single-machine sequencing with precedence relations and deferral costs", Operations Research 23, 1975), and within a piece
//! the hull is a straight line. `O(n height log n)` for `n` node pairs with intersections below.

use std::cmp::Ordering;

use punctual::internals::{OpenedPair, opened_pairs};
use punctual::prediction::WORK_PER_TRIANGLE_TEST;
use punctual::{Pose, Tree};

/// Triangle pairs that the engine tests together.
const BATCH: usize = 8;

/// When the oracle finds what.
#[derive(Default)]
pub struct Oracle {
    /// Least work to a first intersection, and the BV tests in it; 0 if there is none.
    pub first_hit: [u64; 2],
    /// Work after which the last step to it begins, a batch of triangle pairs. A budget that ends later has it, since steps
    /// are finished.
    pub last_step: u64,
    /// Work after which each pair is known, and its index among the true pairs; in order. (A query with that budget may be
    /// ahead by the step in which it ends.)
    pub found: Vec<(u64, u32)>,
}

impl Oracle {
    /// For a pose with the intersecting pairs `pairs`, sorted.
    pub fn new(a: &Tree, b: &Tree, pose: &Pose, pairs: &[[u32; 2]]) -> Self {
        let opened = opened_pairs(a, b, pose);
        let hits = |pair: &OpenedPair| -> Vec<u32> {
            let indices = pair
                .triangle_pairs
                .iter()
                .filter_map(|pair| pairs.binary_search(pair).ok());
            indices.map(|index| index as u32).collect()
        };
        let hits: Vec<Vec<u32>> = opened.iter().map(hits).collect();
        let (first_hit, last_step) = first_hit(&opened, &hits);
        let mut oracle = Self {
            first_hit,
            last_step,
            found: Vec::with_capacity(pairs.len()),
        };
        let mut work = 0;
        for piece in pieces(&opened, hits) {
            let count = piece.hits.len() as u64;
            let at = |i: u64| (work + piece.work * i / count).max(first_hit[0]);
            oracle.found.extend((1..).map(at).zip(piece.hits));
            work += piece.work;
        }
        oracle
    }
}

/// Least work, and the BV tests in it, from the roots to an intersection; and the least work before a last step to one.
fn first_hit(opened: &[OpenedPair], hits: &[Vec<u32>]) -> ([u64; 2], u64) {
    // Below each pair; `None` where there is no intersection.
    let mut below: Vec<Option<([u64; 2], u64)>> = vec![None; opened.len()];
    let least = |x: Option<([u64; 2], u64)>, y: ([u64; 2], u64)| {
        Some(x.map_or(y, |x| (x.0.min(y.0), x.1.min(y.1))))
    };
    for (i, pair) in opened.iter().enumerate().rev() {
        if !hits[i].is_empty() {
            let batch = pair.triangle_pairs.len().min(BATCH) as u64;
            below[i] = least(below[i], ([batch * WORK_PER_TRIANGLE_TEST, 0], 0));
        }
        let Some(([work, bv_tests], before)) = below[i] else {
            continue;
        };
        let all = (
            [pair.work + work, u64::from(pair.bv_tests) + bv_tests],
            pair.work + before,
        );
        if i == 0 {
            return all;
        }
        below[pair.parent] = least(below[pair.parent], all);
    }
    Default::default()
}

/// Node pairs that are opened one after the other.
struct Piece {
    work: u64,
    /// Indices of the intersections found.
    hits: Vec<u32>,
}

impl Piece {
    /// By intersections for the work.
    fn compare(&self, other: &Self) -> Ordering {
        let product = |piece: &Self, work: u64| piece.hits.len() as u128 * u128::from(work);
        product(self, other.work).cmp(&product(other, self.work))
    }
}

/// The pieces of the best order, best first: in a subtree, its root takes up the best pieces below it for as long as they
/// are better than itself. `hits` are those of each node pair alone.
fn pieces(opened: &[OpenedPair], hits: Vec<Vec<u32>>) -> Vec<Piece> {
    // Of the children that are done, for each pair.
    let mut below: Vec<Vec<Piece>> = Vec::new();
    below.resize_with(opened.len(), Vec::new);
    for (i, hits) in hits.into_iter().enumerate().rev() {
        let mut later = std::mem::take(&mut below[i]);
        if hits.is_empty() && later.is_empty() {
            continue;
        }
        later.sort_by(Piece::compare);
        let pair = &opened[i];
        let tests = pair.triangle_pairs.len() as u64 * WORK_PER_TRIANGLE_TEST;
        let mut piece = Piece {
            work: pair.work + tests,
            hits,
        };
        while let Some(best) = later.pop_if(|best| (*best).compare(&piece).is_gt()) {
            piece.work += best.work;
            piece.hits.extend(best.hits);
        }
        later.push(piece);
        if i == 0 {
            later.reverse();
            return later;
        }
        below[pair.parent].append(&mut later);
    }
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::glam::{DMat3, DVec3};
    use punctual::prediction::WORK_PER_EXPANSION;
    use punctual::{Budget, Query, Workspace, shapes};

    fn pair(parent: usize, bv_tests: u32, triangle_pairs: usize) -> OpenedPair {
        let work = WORK_PER_EXPANSION + u64::from(bv_tests);
        OpenedPair {
            parent,
            bv_tests,
            work,
            triangle_pairs: vec![[0, 0]; triangle_pairs],
        }
    }

    /// Roots; a poor leaf; an inner pair with a rich leaf below.
    fn opened() -> [OpenedPair; 4] {
        [
            pair(0, 16, 0),
            pair(0, 0, 4),
            pair(0, 16, 0),
            pair(2, 0, 10),
        ]
    }

    #[test]
    fn the_oracle_takes_the_best_hits_per_work_first_and_pays_for_the_path() {
        let pieces = pieces(&opened(), vec![vec![], vec![7], vec![], vec![1, 2, 3]]);
        let work: Vec<u64> = pieces.iter().map(|piece| piece.work).collect();
        assert_eq!(work, [100 + 100 + 84 + 10 * 44, 84 + 4 * 44]);
        assert_eq!(pieces[0].hits, [1, 2, 3]);
    }

    #[test]
    fn the_first_hit_is_the_cheapest() {
        let at = |poor: &[u32], rich: &[u32]| {
            first_hit(&opened(), &[vec![], poor.to_vec(), vec![], rich.to_vec()])
        };
        assert_eq!(at(&[7], &[1]), ([100 + 84 + 4 * 44, 16], 100 + 84));
        assert_eq!(at(&[], &[1]), ([200 + 84 + 8 * 44, 32], 200 + 84));
        assert_eq!(at(&[], &[]), ([0, 0], 0));
    }

    #[test]
    fn no_order_is_ahead_of_the_oracle() {
        let (a, b) = (
            Tree::new(shapes::torus_knot(2, 3, 0.2, 32)),
            Tree::new(shapes::gear(9, 3)),
        );
        let mut workspace = Workspace::new();
        for x in [0.4, 0.9, 1.2] {
            let pose = Pose::new(DMat3::from_rotation_x(x), DVec3::new(x, 0.1, 0.0)).unwrap();
            // The orders follow contacts from triangle to triangle, which is no order of visits.
            let query = Query::all_pairs(&a, &b, pose).plain();
            let full = query.run(&mut workspace, Budget::unlimited());
            let mut pairs = workspace.pairs().to_vec();
            pairs.sort_unstable();
            let oracle = Oracle::new(&a, &b, &pose, &pairs);
            assert!(
                pairs.len() > 50
                    && oracle.found.len() == pairs.len()
                    && oracle.found.is_sorted_by_key(|f| f.0)
            );
            assert!(oracle.found.last().unwrap().0 <= full.stats.work);
            for percent in 1..=100 {
                let budget = full.stats.work * percent / 100;
                let outcome = query.run(&mut workspace, Budget::work(budget));
                let best = oracle
                    .found
                    .partition_point(|(work, _)| *work <= outcome.stats.work)
                    as u64;
                assert!(
                    outcome.stats.found <= best,
                    "{percent} %: {} > {best}",
                    outcome.stats.found
                );
            }
        }
    }
}
