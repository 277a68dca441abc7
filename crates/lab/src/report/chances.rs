//! Probabilities against what came: scores, and the reliability diagram.

use super::{Axis, Chart, Series, Shape};

/// Probabilities told, and what came of them.
#[derive(Default)]
pub struct Chances(pub Vec<(f64, bool)>);

impl Chances {
    /// Mean square of the difference between what was told (0 to 1) and what came (0 or 1).
    pub fn brier(&self) -> f64 {
        let squares = self.0.iter().map(|&(p, hit)| (p - f64::from(hit)).powi(2));
        squares.sum::<f64>() / self.0.len() as f64
    }

    /// Mean difference, over ten bins, between what was told and how often it came.
    pub fn calibration_error(&self) -> f64 {
        let bins = self.bins();
        bins.iter()
            .map(|bin| bin.count * (bin.told - bin.came).abs())
            .sum::<f64>()
            / self.0.len() as f64
    }

    /// How often came true what was told, bin by bin, with 95 % intervals.
    pub fn diagram(&self, title: &str) -> Chart {
        let bins = self.bins();
        let points = bins.iter().map(|bin| [bin.told, bin.came]).collect();
        let intervals = bins
            .iter()
            .map(|bin| [bin.told, bin.interval()[0], bin.interval()[1]])
            .collect();
        let total = self.0.len() as f64;
        let shares = (0..10).map(|i| {
            let (low, high) = (f64::from(i) / 10.0, f64::from(i + 1) / 10.0);
            let count: f64 = bins
                .iter()
                .filter(|bin| bin.told >= low && bin.told < high)
                .map(|bin| bin.count)
                .sum();
            [low, high, count / total]
        });
        Chart {
            title: format!(
                "{title}: Brier {:.3}, ECE {:.3}",
                self.brier(),
                self.calibration_error()
            ),
            x: Axis::linear("probability told").range(0.0..1.0),
            y: Axis::linear("share that came true").range(0.0..1.0),
            series: vec![
                Series::new("share of the queries", 7, Shape::Columns(shares.collect())),
                Series::new(
                    "as it should be",
                    6,
                    Shape::Dashed(vec![[0.0, 0.0], [1.0, 1.0]]),
                ),
                Series::new("95 % interval", 1, Shape::Intervals(intervals)),
                Series::new("measured", 0, Shape::Points(points)),
            ],
        }
    }

    /// Ten bins of equal width, without the empty ones.
    pub fn bins(&self) -> Vec<Bin> {
        let bin = |i: usize| {
            let inside = || {
                self.0
                    .iter()
                    .filter(move |(p, _)| ((p * 10.0) as usize).min(9) == i)
            };
            let count = inside().count() as f64;
            let told = inside().map(|(p, _)| p).sum::<f64>() / count;
            let came = inside().filter(|(_, hit)| *hit).count() as f64 / count;
            Bin { count, told, came }
        };
        (0..10).map(bin).filter(|bin| bin.count > 0.0).collect()
    }
}

/// Probabilities that are about the same.
pub struct Bin {
    pub count: f64,
    /// Their mean.
    pub told: f64,
    /// The share that came true.
    pub came: f64,
}

impl Bin {
    /// The range of the true probability, 95 % (Wilson's score interval).
    pub fn interval(&self) -> [f64; 2] {
        const Z: f64 = 1.96;
        let (n, p) = (self.count, self.came);
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        [(middle - half).max(0.0), (middle + half).min(1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_of_chances_by_hand() {
        let chances = Chances(vec![(0.2, false), (0.2, true), (0.9, true), (1.0, true)]);
        assert!((chances.brier() - (0.04 + 0.64 + 0.01) / 4.0).abs() < 1e-12);
        // Told .2, came half of the time; told .95 on average, came always.
        assert!((chances.calibration_error() - (2.0 * 0.3 + 2.0 * 0.05) / 4.0).abs() < 1e-12);
        let [low, high] = chances.bins()[1].interval();
        assert!(high == 1.0 && (low - 0.342).abs() < 1e-3, "{low}");
    }
}
