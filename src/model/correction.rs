//! Correction of predicted costs by what the query has found so far.
//!
//! A query that opens a pair learns what the opening cost, and what is now predicted for the children; together they should
//! be what was predicted for the pair. Per height of pairs (levels below them), the ratio of the two sums tells how far
//! predictions at that height are off, which is temporal-difference learning. A pair's own cost is then corrected by the
//! ratios of its height and of all below.

/// Heights that are told apart; higher pairs count with the last.
pub const HEIGHTS: usize = 32;

/// Weight of the first guess, a ratio of 1, in BV tests: a height with fewer tests than this is hardly corrected.
const PRIOR: f64 = 40.0;

/// No height is corrected by more than this factor, either way.
const LIMIT: f64 = 4.0;

/// The ratios learned so far. 512 bytes, no allocation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Correction {
    found: [f64; HEIGHTS],
    predicted: [f64; HEIGHTS],
}

impl Default for Correction {
    fn default() -> Self {
        Self { found: [0.0; HEIGHTS], predicted: [0.0; HEIGHTS] }
    }
}

impl Correction {
    /// Learns from a pair that was opened: `tests` BV tests were made, and `children` are predicted for those that
    /// overlapped, where `own` had been predicted for the pair; all uncorrected.
    pub fn learn(&mut self, height: usize, tests: f64, children: f64, own: f64) {
        let height = height.min(HEIGHTS - 1);
        self.found[height] += tests + children;
        self.predicted[height] += own;
    }

    /// `r_h = clamp((sum (tests + children) + 40) / (sum own + 40), 1/4, 4)`.
    pub fn ratio(&self, height: usize) -> f64 {
        let height = height.min(HEIGHTS - 1);
        let ratio = (self.found[height] + PRIOR) / (self.predicted[height] + PRIOR);
        ratio.clamp(1.0 / LIMIT, LIMIT)
    }

    /// The factor for a predicted cost of a pair of height `h`: `prod_{j<=h} r_j`. `O(HEIGHTS)`; for many pairs, take
    /// [`Self::factors`].
    pub fn factor(&self, height: usize) -> f64 {
        (0..=height.min(HEIGHTS - 1)).map(|j| self.ratio(j)).product()
    }

    /// The factors of all heights.
    pub fn factors(&self) -> [f64; HEIGHTS] {
        let mut product = 1.0;
        core::array::from_fn(|height| {
            product *= self.ratio(height);
            product
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_learned_changes_nothing() {
        let fresh = Correction::default();
        assert_eq!(fresh.factors(), [1.0; HEIGHTS]);
        let mut exact = fresh;
        exact.learn(3, 4.0, 96.0, 100.0);
        assert_eq!(exact.factors(), [1.0; HEIGHTS]);
    }

    #[test]
    fn ratios_by_hand() {
        let mut learned = Correction::default();
        learned.learn(2, 4.0, 56.0, 20.0);
        learned.learn(2, 4.0, 16.0, 0.0);
        learned.learn(5, 0.0, 0.0, 1e9);
        learned.learn(99, 1e9, 0.0, 0.0);
        assert_eq!(learned.ratio(2), 2.0);
        assert_eq!([learned.ratio(5), learned.ratio(HEIGHTS - 1), learned.ratio(40)], [0.25, 4.0, 4.0]);
        assert_eq!([1, 2, 4, 5, 30, 99].map(|h| learned.factor(h)), [1.0, 2.0, 2.0, 0.5, 0.5, 2.0]);
        for height in 0..HEIGHTS {
            assert_eq!(learned.factors()[height], learned.factor(height));
        }
    }

    #[test]
    fn a_wrong_branching_is_learned() {
        // Pairs of height h cost 3^h; predicted is 4^h. Each opening sees 3 children and 4 tests.
        let predicted = |h: i32| 4f64.powi(h);
        let mut learned = Correction::default();
        for height in 1..=6 {
            for _ in 0..1000 {
                learned.learn(height as usize, 0.0, 3.0 * predicted(height - 1), predicted(height));
            }
        }
        let error = predicted(6) * learned.factor(6) / 3f64.powi(6);
        assert!((error - 1.0).abs() < 0.05, "{error}");
    }
}
