//! From a median to a range: how far predictions are off.
//!
//! Counts of BV tests are extremely skewed, so errors are taken in log2, `log2(actual / predicted)`, and assumed normal
//! there: the actual count is log-normal around the prediction.

use super::normal;

/// Mean and standard deviation of `log2(actual / predicted)` over some queries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LogSpread {
    /// Mean: positive where predictions are too low.
    pub bias: f64,
    /// Standard deviation.
    pub sigma: f64,
}

impl LogSpread {
    /// The spread of the given errors, each `log2(actual / predicted)`; zero without any.
    pub fn of(errors: &[f64]) -> Self {
        let n = errors.len().max(1) as f64;
        let bias = errors.iter().sum::<f64>() / n;
        let variance = errors.iter().map(|e| (e - bias) * (e - bias)).sum::<f64>() / n;
        Self { bias, sigma: libm::sqrt(variance) }
    }

    /// The value that the actual count stays below with probability `p`:
    /// `predicted * 2^(bias + sigma * Phi^-1(p))`. With `p = 0.5` the median.
    pub fn quantile(&self, predicted: f64, p: f64) -> f64 {
        let deviation = if self.sigma == 0.0 { 0.0 } else { self.sigma * normal::inverse_cdf(p) };
        predicted * libm::exp2(self.bias + deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use alloc::vec::Vec;

    #[test]
    fn quantiles_by_hand() {
        let spread = LogSpread::of(&[0.0, 2.0]);
        assert_eq!(spread, LogSpread { bias: 1.0, sigma: 1.0 });
        assert_eq!(spread.quantile(8.0, 0.5), 16.0);
        let p90 = 16.0 * f64::powf(2.0, 1.281_551_565_544_6);
        assert!((spread.quantile(8.0, 0.9) / p90 - 1.0).abs() < 1e-11);
        assert_eq!(LogSpread::of(&[]).quantile(3.0, 0.9), 3.0);
    }

    #[test]
    fn a_quantile_covers_its_share_of_log_normal_counts() {
        let mut random = Random::new(7);
        let errors: Vec<f64> = (0..20_000).map(|_| (0..12).map(|_| random.fraction()).sum::<f64>() - 5.5).collect();
        let spread = LogSpread::of(&errors);
        for p in [0.1, 0.5, 0.9] {
            let limit = spread.quantile(100.0, p);
            let below = errors.iter().filter(|&&e| 100.0 * e.exp2() <= limit).count();
            assert!((below as f64 / 20_000.0 - p).abs() < 0.01, "{p}: {below}");
        }
    }
}
