//! Means and quantiles of what was measured.

/// Nothing without a value.
pub fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Least and largest.
pub fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::MAX, f64::MIN], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}

/// The value below which this fraction of the sorted values lies; NaN without any.
pub fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted
        .get((fraction * last as f64).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

/// Ascending, without those that are not numbers.
pub fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| !value.is_nan()).collect();
    values.sort_by(f64::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        let values = sorted([3.0, f64::NAN, 1.0, 2.0].into_iter());
        assert_eq!(
            [0.0, 0.5, 0.9, 1.0].map(|p| quantile(&values, p)),
            [1.0, 2.0, 3.0, 3.0]
        );
        let values = sorted([3.0, 1.0, 2.0, 5.0, 4.0].into_iter());
        assert_eq!(
            [0.0, 0.5, 0.75, 1.0].map(|p| quantile(&values, p)),
            [1.0, 3.0, 4.0, 5.0]
        );
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn nothing_has_no_mean() {
        assert_eq!(
            [mean([1.0, 4.0].into_iter()), mean([].into_iter())],
            [Some(2.5), None]
        );
    }
}
