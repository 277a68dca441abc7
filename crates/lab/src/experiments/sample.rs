//! Means over random runs, on all cores, the same on any number of them.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::artificial::{ArtificialTree, Corners, Random};
use crate::traversal::Visits;

/// How long to sample: until so many BV tests were made, within bounds on the number of runs.
#[derive(Clone, Copy)]
pub struct Effort {
    pub tests: u64,
    pub least: u32,
    pub most: u32,
}

/// A mean and its standard error.
#[derive(Clone, Copy)]
pub struct Mean {
    pub value: f64,
    pub error: f64,
}

/// Points spread evenly over the unit cube, more evenly than random ones: point `i` is `start + i (1/g, 1/g^2, 1/g^3)` modulo
/// 1, with `g^4 = g + 1` (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
#[derive(Clone)]
pub struct Spread(pub [f64; 3]);

impl Spread {
    pub fn new(random: &mut Random) -> Self {
        Self([(); 3].map(|()| random.fraction()))
    }

    pub fn next(&mut self) -> [f64; 3] {
        const G: f64 = 1.220_744_084_605_759_5;
        let steps = [1.0 / G, 1.0 / (G * G), 1.0 / (G * G * G)];
        self.0 = std::array::from_fn(|k| (self.0[k] + steps[k]).fract());
        self.0
    }
}

impl Effort {
    /// The mean `N_v` over runs, each of which gets random numbers and a point of a [`Spread`], by `seed`, and has a weight.
    /// The error is that of independent points, and so too large.
    pub fn mean_visits(
        &self,
        seed: u64,
        mut run: impl FnMut(&mut Random, [f64; 3]) -> (Visits, f64),
    ) -> Mean {
        let mut random = Random::new(seed);
        let mut spread = Spread::new(&mut random);
        let (mut runs, mut tests, mut sum, mut squares) = (0, 0, 0.0, 0.0);
        while runs < self.least || (runs < self.most && tests < self.tests) {
            let (visits, weight) = run(&mut random, spread.next());
            let total = visits.total() as f64 * weight;
            runs += 1;
            tests += visits.bv_tests;
            sum += total;
            squares += total * total;
        }
        let n = f64::from(runs);
        let value = sum / n;
        Mean {
            value,
            error: ((squares / n - value * value).max(0.0) / n).sqrt(),
        }
    }
}

/// Whether trees draw their corners.
#[derive(Clone, Copy, PartialEq)]
pub enum Rule {
    Fixed,
    Random,
}

/// Two trees of one kind, and how far the roots overlap along x; `None`: at random like along the other axes.
#[derive(Clone, Copy)]
pub struct Setting {
    pub alpha: [f64; 3],
    pub depth: u32,
    pub rule: Rule,
    pub delta: Option<f64>,
}

impl Setting {
    /// The offset of the roots at a point of the unit cube: along x as delta says, else uniform where the roots meet.
    ///
    /// Trees with random corners cannot tell an axis from its reverse, so that positive offsets are enough for them.
    pub fn offset(&self, point: [f64; 3]) -> [f64; 3] {
        let uniform = if self.rule == Rule::Fixed {
            point.map(|u| 2.0 * u - 1.0)
        } else {
            point
        };
        [
            self.delta.map_or(uniform[0], |delta| 1.0 - delta),
            uniform[1],
            uniform[2],
        ]
    }

    /// What two new trees visit at an offset.
    pub fn visits(&self, random: &mut Random, offset: [f64; 3]) -> Visits {
        let mut tree = || {
            let corners = if self.rule == Rule::Fixed {
                Corners::Fixed
            } else {
                Corners::Random(random.bits())
            };
            ArtificialTree {
                alpha: self.alpha,
                depth: self.depth,
                corners,
            }
        };
        let [a, b] = [tree(), tree()];
        a.visits(&b, offset)
    }

    /// The mean over trees and placements.
    ///
    /// A few placements near the centre make up most of it, so these are drawn more often and weigh less: an offset `o` is
    /// moved to `o |o|`, which makes room `2 |o|` times as large.
    pub fn mean(&self, effort: &Effort, seed: u64) -> Mean {
        effort.mean_visits(seed, |random, point| {
            let mut offset = self.offset(point);
            let drawn = usize::from(self.delta.is_some())..3;
            let weight = drawn.clone().map(|k| 2.0 * offset[k].abs()).product();
            drawn.for_each(|k| offset[k] *= offset[k].abs());
            (self.visits(random, offset), weight)
        })
    }
}

/// `run` of every item, on all cores; the order of the results is that of the items.
pub fn parallel<I: Sync, O: Send>(items: &[I], run: impl Fn(&I) -> O + Sync) -> Vec<O> {
    let next = AtomicUsize::new(0);
    let one = || {
        let i = next.fetch_add(1, Ordering::Relaxed);
        items.get(i).map(|item| (i, run(item)))
    };
    let results = Mutex::new(Vec::with_capacity(items.len()));
    let work = || {
        while let Some(result) = one() {
            results
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(result);
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(work);
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_unstable_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_their_order() {
        let items: Vec<u64> = (0..1000).collect();
        assert_eq!(
            parallel(&items, |i| i * i),
            items.iter().map(|i| i * i).collect::<Vec<_>>()
        );
        assert!(parallel(&[], |i: &u64| *i).is_empty());
    }

    #[test]
    fn spread_points_fill_the_cube_evenly() {
        let mut spread = Spread([0.3; 3]);
        let n = 4096;
        let mut octants = [0; 8];
        for _ in 0..n {
            let octant = spread
                .next()
                .iter()
                .fold(0, |octant, &u| 2 * octant + usize::from(u >= 0.5));
            octants[octant] += 1;
        }
        // Independent points would be off by 21 on average.
        assert!(
            octants
                .iter()
                .all(|&count: &i32| (count - n / 8).abs() < 12),
            "{octants:?}"
        );
    }

    #[test]
    fn effort_bounds_the_runs() {
        let effort = Effort {
            tests: 100,
            least: 3,
            most: 20,
        };
        let runs_of = |bv_tests: u64| {
            let mut runs = 0;
            effort.mean_visits(1, |_, _| {
                runs += 1;
                (
                    Visits {
                        overlapping: vec![7],
                        bv_tests,
                        leaf_pairs: 0,
                    },
                    1.0,
                )
            });
            runs
        };
        assert_eq!([runs_of(1000), runs_of(10), runs_of(1)], [3, 10, 20]);
    }
}
