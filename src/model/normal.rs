//! The normal distribution.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

/// `Phi(x)`, the standard normal distribution function.
pub(super) fn cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x * FRAC_1_SQRT_2)
}

/// The `x` with `Phi(x) = p`; infinite at 0 and 1, NaN outside.
///
/// Begins with the rational approximation 26.2.23 of Abramowitz and Stegun (error below 4.5e-4), and improves it by two
/// Newton steps; the result is good to 1e-12 relative for `p` from 1e-12 to 1 - 1e-12.
pub(super) fn inverse_cdf(p: f64) -> f64 {
    if !(p > 0.0 && p < 1.0) {
        return if p == 0.0 {
            f64::NEG_INFINITY
        } else if p == 1.0 {
            f64::INFINITY
        } else {
            f64::NAN
        };
    }
    let tail = p.min(1.0 - p);
    let t = libm::sqrt(-2.0 * libm::log(tail));
    let numerator = 2.515517 + t * (0.802853 + t * 0.010328);
    let denominator = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    // Within the lower tail, where the distribution function loses no digits.
    let mut x = numerator / denominator - t;
    for _ in 0..2 {
        let density = libm::exp(-0.5 * x * x) / libm::sqrt(2.0 * PI);
        x -= (cdf(x) - tail) / density;
    }
    if p < 0.5 { x } else { -x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_values() {
        assert_eq!(cdf(0.0), 0.5);
        for (x, p) in [(1.0, 0.841_344_746_068_542_9), (-1.281_551_565_544_6, 0.1), (3.0, 0.998_650_101_968_369_9)] {
            assert!((cdf(x) - p).abs() < 1e-12, "{x}");
            assert!((inverse_cdf(p) - x).abs() < 1e-11, "{p}");
        }
    }

    #[test]
    fn the_inverse_undoes_the_distribution() {
        for i in -69..=69 {
            let x = f64::from(i) / 10.0;
            // Above the median the digits of `1 - p` are lost before the inverse sees them.
            let tolerance = if x > 0.0 { 1e-16 / (1.0 - cdf(x)) } else { 0.0 } + 1e-12;
            assert!((inverse_cdf(cdf(x)) - x).abs() <= tolerance * x.abs().max(1.0), "{x}");
        }
        assert_eq!([inverse_cdf(0.0), inverse_cdf(1.0)], [f64::NEG_INFINITY, f64::INFINITY]);
        assert!(inverse_cdf(-0.1).is_nan() && inverse_cdf(1.1).is_nan() && inverse_cdf(f64::NAN).is_nan());
    }
}
