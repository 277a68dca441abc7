//! Linear models of a few features: by least squares, by quantiles, of probabilities. How the constants are fitted.
//!
//! The last two are least squares again and again with other weights. Features are arrays of fixed length, the first usually
//! 1; lists of features, targets and weights are in step.

/// The `w` that minimizes `sum weight (y - w . x)^2`, by the normal equations.
pub fn least_squares<const N: usize>(x: &[[f64; N]], y: &[f64], weights: &[f64]) -> [f64; N] {
    let (mut matrix, mut right) = ([[0.0; N]; N], [0.0; N]);
    for ((x, y), weight) in x.iter().zip(y).zip(weights) {
        for i in 0..N {
            for j in 0..N {
                matrix[i][j] += weight * x[i] * x[j];
            }
            right[i] += weight * x[i] * y;
        }
    }
    solve(matrix, right)
}

/// Solves `matrix w = right` by elimination with pivots. Adds a billionth of the diagonal, so that
/// features may depend on one another.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] += 1e-9 * row[i] + f64::MIN_POSITIVE;
    }
    for i in 0..N {
        let pivot = (i..N)
            .max_by(|&j, &k| matrix[j][i].abs().total_cmp(&matrix[k][i].abs()))
            .unwrap_or(i);
        matrix.swap(i, pivot);
        right.swap(i, pivot);
        for j in i + 1..N {
            let (factor, row) = (matrix[j][i] / matrix[i][i], matrix[i]);
            matrix[j]
                .iter_mut()
                .zip(row)
                .skip(i)
                .for_each(|(entry, above)| *entry -= factor * above);
            right[j] -= factor * right[i];
        }
    }
    let mut w = [0.0; N];
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|k| matrix[i][k] * w[k]).sum();
        w[i] = (right[i] - known) / matrix[i][i];
    }
    w
}

/// `w . x`
pub fn dot(w: &[f64], x: &[f64]) -> f64 {
    w.iter().zip(x).map(|(w, x)| w * x).sum()
}

/// Rounds of reweighting.
const ROUNDS: usize = 60;

/// The `w` for which `w . x` is the quantile `p` of `y`: that with the least `sum rho(y - w . x)`, where `rho(r)` is `p r`
/// above 0 and `(p - 1) r` below. By least squares with the weights `rho(r) / r^2`; residuals below `blur` count as that.
pub fn quantile<const N: usize>(x: &[[f64; N]], y: &[f64], p: f64, blur: f64) -> [f64; N] {
    let mut w = least_squares(x, y, &vec![1.0; x.len()]);
    for _ in 1..ROUNDS {
        let weight = |(x, &y): (&[f64; N], &f64)| {
            let r = y - dot(&w, x);
            let side = if r > 0.0 { p } else { 1.0 - p };
            side / r.abs().max(blur)
        };
        let weights: Vec<f64> = x.iter().zip(y).map(weight).collect();
        w = least_squares(x, y, &weights);
    }
    w
}

/// The `w` for which `1 / (1 + exp(-w . x))` tells the probabilities `y` (0 to 1, often just 0 or 1) with the least weighted
/// cross-entropy and, for each sample, half of `pull` times the squares of all weights but the first. By Newton's method.
pub fn logistic<const N: usize>(x: &[[f64; N]], y: &[f64], weights: &[f64], pull: f64) -> [f64; N] {
    let total: f64 = weights.iter().sum();
    // A row for each weight but the first, which says that it is 0.
    let unit = |i: usize| std::array::from_fn(|k| f64::from(u8::from(k == i)));
    let rows: Vec<[f64; N]> = x.iter().copied().chain((1..N).map(unit)).collect();
    let mut w = [0.0; N];
    for _ in 0..ROUNDS {
        let step = |((x, &y), &weight): ((&[f64; N], &f64), &f64)| {
            let z = dot(&w, x).clamp(-30.0, 30.0);
            let p = 1.0 / (1.0 + libm::exp(-z));
            let slope = (p * (1.0 - p)).max(1e-6);
            (z + (y - p) / slope, weight * slope)
        };
        let pulls = std::iter::repeat_n((0.0, pull * total), N - 1);
        let (targets, weights): (Vec<f64>, Vec<f64>) =
            x.iter().zip(y).zip(weights).map(step).chain(pulls).unzip();
        w = least_squares(&rows, &targets, &weights);
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::internals::Random;

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
    fn quantiles_have_their_share_below() {
        let mut random = Random::new(2);
        let x: Vec<_> = (0..4000).map(|_| features(&mut random)).collect();
        let y: Vec<_> = x
            .iter()
            .map(|x| dot(&TRUE, x) + (1.0 + x[2]) * random.fraction())
            .collect();
        for p in [0.1, 0.5, 0.9] {
            let w = quantile(&x, &y, p, 1e-3);
            close(w, [TRUE[0] + p, TRUE[1], TRUE[2] + p], 0.1);
            let below = x.iter().zip(&y).filter(|(x, y)| **y < dot(&w, *x)).count();
            assert!((below as f64 / 4000.0 - p).abs() < 0.01, "{p}: {below}");
        }
    }

    #[test]
    fn logistic_finds_probabilities() {
        let mut random = Random::new(3);
        let x: Vec<_> = (0..20_000).map(|_| features(&mut random)).collect();
        let p = |x: &[f64; 3]| 1.0 / (1.0 + (-dot(&TRUE, x)).exp());
        let y: Vec<_> = x
            .iter()
            .map(|x| f64::from(random.fraction() < p(x)))
            .collect();
        let ones = vec![1.0; x.len()];
        close(logistic(&x, &y, &ones, 1e-6), TRUE, 0.15);
        let shares: Vec<_> = x.iter().map(p).collect();
        close(logistic(&x, &shares, &ones, 1e-6), TRUE, 0.01);
        // All of one kind: sure, and finite.
        let w = logistic(&x, &vec![1.0; x.len()], &ones, 1e-6);
        assert!(
            w.iter().all(|w| w.is_finite()) && dot(&w, &[1.0, 0.0, 0.5]) > 3.0,
            "{w:?}"
        );
    }
}
