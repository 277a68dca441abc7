//! Fits linear models of a few features by least squares.
//!
//! Features are arrays of fixed length. Lists of features, targets and weights have the same order.

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
