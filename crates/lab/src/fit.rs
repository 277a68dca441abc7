//! Straight lines and power laws through points, by least squares.

/// `y = intercept + slope x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// `y` at `x = 0`.
    pub intercept: f64,
    /// Growth of `y` per unit of `x`.
    pub slope: f64,
    /// Share of the variance of `y` that it explains; 1 where there is none.
    pub r_squared: f64,
}

impl Line {
    /// The least-squares line through points `[x, y]`; `None` without two distinct `x`, or if a number is not finite.
    pub fn fit(points: &[[f64; 2]]) -> Option<Self> {
        let n = points.len() as f64;
        let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
        let middle = [mean(0), mean(1)];
        let moment = |j: usize, k: usize| {
            points
                .iter()
                .map(|p| (p[j] - middle[j]) * (p[k] - middle[k]))
                .sum::<f64>()
        };
        let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
        let slope = xy / xx;
        let r_squared = if yy > 0.0 { slope * xy / yy } else { 1.0 };
        (xx > 0.0 && slope.is_finite()).then(|| Self {
            intercept: middle[1] - slope * middle[0],
            slope,
            r_squared,
        })
    }

    /// `y` at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }
}

/// `y = factor x^exponent`, a straight line between logarithms.
///
/// With the number of leaves for `x` and a count for `y` it tells how the count grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// `log2 y` over `log2 x`; the exponent is its slope, and its `r_squared` is that of the logarithms.
    pub line: Line,
}

impl PowerLaw {
    /// The least-squares line through the logarithms of points `[x, y]`; `None` unless all are positive and finite and
    /// two `x` are distinct.
    pub fn fit(points: &[[f64; 2]]) -> Option<Self> {
        let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(libm::log2)).collect();
        Line::fit(&logs).map(|line| Self { line })
    }

    /// The exponent.
    pub fn exponent(&self) -> f64 {
        self.line.slope
    }

    /// `y` at `x`.
    pub fn at(&self, x: f64) -> f64 {
        libm::exp2(self.line.at(libm::log2(x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_by_hand() {
        let line = Line::fit(&[[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]]).unwrap();
        assert_eq!(
            line,
            Line {
                intercept: 0.5,
                slope: 0.5,
                r_squared: 0.25
            }
        );
        assert_eq!(line.at(4.0), 2.5);
        assert_eq!(Line::fit(&[[1.0, 2.0], [3.0, 2.0]]).unwrap().r_squared, 1.0);
    }

    #[test]
    fn a_power_law_is_found_again() {
        let law = |x: f64| 3.0 * x.powf(0.75);
        let points: Vec<_> = (1..9).map(|i| [f64::from(i), law(f64::from(i))]).collect();
        let fit = PowerLaw::fit(&points).unwrap();
        assert!((fit.exponent() - 0.75).abs() < 1e-12 && (fit.line.r_squared - 1.0).abs() < 1e-12);
        assert!((fit.at(100.0) / law(100.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn too_few_or_bad_points_have_no_fit() {
        for points in [
            &[][..],
            &[[2.0, 1.0]],
            &[[2.0, 1.0], [2.0, 3.0]],
            &[[0.0, 1.0], [2.0, 3.0]],
            &[[1.0, f64::NAN], [2.0, 3.0]],
        ] {
            assert_eq!(PowerLaw::fit(points), None);
        }
    }
}
