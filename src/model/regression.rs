//! Linear models of a few features: by least squares, by quantiles, of probabilities. How the constants are fitted.
//!
//! All three solve weighted normal equations, the last two again and again with other weights. Features are arrays of fixed
//! length, the first usually 1; lists of features, targets and weights are in step.

/// Symmetric equations `matrix w = right`.
#[derive(Clone, Copy)]
struct Normal<const N: usize> {
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl<const N: usize> Normal<N> {
    const fn new() -> Self {
        Self { matrix: [[0.0; N]; N], right: [0.0; N] }
    }

    fn add(&mut self, x: &[f64; N], y: f64, weight: f64) {
        for i in 0..N {
            for j in 0..N {
                self.matrix[i][j] += weight * x[i] * x[j];
            }
            self.right[i] += weight * x[i] * y;
        }
    }

    /// Elimination with pivots; a part in a billion of the diagonal is added, so that features may depend on one another.
    fn solve(mut self) -> [f64; N] {
        for i in 0..N {
            self.matrix[i][i] += 1e-9 * self.matrix[i][i] + f64::MIN_POSITIVE;
        }
        for i in 0..N {
            let pivot =
                (i..N).max_by(|&j, &k| self.matrix[j][i].abs().total_cmp(&self.matrix[k][i].abs())).unwrap_or(i);
            self.matrix.swap(i, pivot);
            self.right.swap(i, pivot);
            for j in i + 1..N {
                let factor = self.matrix[j][i] / self.matrix[i][i];
                for k in i..N {
                    self.matrix[j][k] -= factor * self.matrix[i][k];
                }
                self.right[j] -= factor * self.right[i];
            }
        }
        let mut w = [0.0; N];
        for i in (0..N).rev() {
            let known: f64 = (i + 1..N).map(|k| self.matrix[i][k] * w[k]).sum();
            w[i] = (self.right[i] - known) / self.matrix[i][i];
        }
        w
    }
}

fn dot<const N: usize>(w: &[f64; N], x: &[f64; N]) -> f64 {
    w.iter().zip(x).map(|(w, x)| w * x).sum()
}

/// The `w` with the least `sum weight (y - w . x)^2`.
pub fn least_squares<const N: usize>(x: &[[f64; N]], y: &[f64], weights: &[f64]) -> [f64; N] {
    let mut normal = Normal::new();
    for ((x, &y), &weight) in x.iter().zip(y).zip(weights) {
        normal.add(x, y, weight);
    }
    normal.solve()
}

/// Rounds of reweighting.
const ROUNDS: usize = 60;

/// The `w` for which `w . x` is the quantile `p` of `y`: that with the least `sum rho(y - w . x)`, where `rho(r)` is `p r`
/// above 0 and `(p - 1) r` below. By least squares with the weights `rho(r) / r^2`; residuals below `blur` count as that.
pub fn quantile<const N: usize>(x: &[[f64; N]], y: &[f64], p: f64, blur: f64) -> [f64; N] {
    let mut w = [0.0; N];
    for round in 0..ROUNDS {
        let mut normal = Normal::new();
        for (x, &y) in x.iter().zip(y) {
            let r = y - dot(&w, x);
            let side = if r > 0.0 { p } else { 1.0 - p };
            normal.add(x, y, if round == 0 { 1.0 } else { side / r.abs().max(blur) });
        }
        w = normal.solve();
    }
    w
}

/// The `w` for which `1 / (1 + exp(-w . x))` tells the probabilities `y` (0 to 1, often just 0 or 1) with the least weighted
/// cross-entropy and, for each sample, half of `pull` times the squares of all weights but the first. By Newton's method.
pub fn logistic<const N: usize>(x: &[[f64; N]], y: &[f64], weights: &[f64], pull: f64) -> [f64; N] {
    let total: f64 = weights.iter().sum();
    let mut w = [0.0; N];
    for _ in 0..ROUNDS {
        let mut normal = Normal::new();
        for ((x, &y), &weight) in x.iter().zip(y).zip(weights) {
            let z = dot(&w, x).clamp(-30.0, 30.0);
            let p = 1.0 / (1.0 + libm::exp(-z));
            let slope = (p * (1.0 - p)).max(1e-6);
            normal.add(x, z + (y - p) / slope, weight * slope);
        }
        for i in 1..N {
            normal.matrix[i][i] += pull * total;
        }
        w = normal.solve();
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use alloc::vec::Vec;

    fn features(random: &mut Random) -> [f64; 3] {
        [1.0, random.fraction() * 4.0 - 2.0, random.fraction()]
    }

    const TRUE: [f64; 3] = [0.5, -1.0, 2.0];

    fn close<const N: usize>(w: [f64; N], expected: [f64; N], tolerance: f64) {
        for (w, e) in w.iter().zip(expected) {
            assert!((w - e).abs() < tolerance, "{w} is not {e}");
        }
    }

    #[test]
    fn least_squares_finds_the_plane_through_points() {
        let mut random = Random::new(1);
        let x: Vec<_> = (0..9).map(|_| features(&mut random)).collect();
        let y: Vec<_> = x.iter().map(|x| dot(&TRUE, x)).collect();
        close(least_squares(&x, &y, &[1.0; 9]), TRUE, 1e-6);
        // A point of no weight does not count; features that depend on one another do no harm.
        let x = [[1.0, 1.0], [2.0, 2.0], [5.0, 0.0]];
        let w = least_squares(&x, &[2.0, 4.0, 99.0], &[1.0, 1.0, 0.0]);
        assert!((w[0] + w[1] - 2.0).abs() < 1e-6, "{w:?}");
    }

    #[test]
    fn quantiles_have_their_share_below() {
        let mut random = Random::new(2);
        let x: Vec<_> = (0..4000).map(|_| features(&mut random)).collect();
        let y: Vec<_> = x.iter().map(|x| dot(&TRUE, x) + (1.0 + x[2]) * random.fraction()).collect();
        for p in [0.1, 0.5, 0.9] {
            let w = quantile(&x, &y, p, 1e-3);
            close(w, [TRUE[0] + p, TRUE[1], TRUE[2] + p], 0.1);
            let below = x.iter().zip(&y).filter(|(x, y)| **y < dot(&w, x)).count();
            assert!((below as f64 / 4000.0 - p).abs() < 0.01, "{p}: {below}");
        }
    }

    #[test]
    fn logistic_finds_probabilities() {
        let mut random = Random::new(3);
        let x: Vec<_> = (0..20_000).map(|_| features(&mut random)).collect();
        let p = |x: &[f64; 3]| 1.0 / (1.0 + (-dot(&TRUE, x)).exp());
        let y: Vec<_> = x.iter().map(|x| f64::from(random.fraction() < p(x))).collect();
        let ones = alloc::vec![1.0; x.len()];
        close(logistic(&x, &y, &ones, 1e-6), TRUE, 0.15);
        let shares: Vec<_> = x.iter().map(p).collect();
        close(logistic(&x, &shares, &ones, 1e-6), TRUE, 0.01);
        // All of one kind: sure, and finite.
        let w = logistic(&x, &alloc::vec![1.0; x.len()], &ones, 1e-6);
        assert!(w.iter().all(|w| w.is_finite()) && dot(&w, &[1.0, 0.0, 0.5]) > 3.0, "{w:?}");
    }
}
